"""The study that the options of `stiction pair` ask for, and where each of them applies."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import typer

from stiction._checks import Floats
from stiction._units import Quantity, exactly, quantity
from stiction.cli.elasticity import Elasticity, elasticity_of
from stiction.cli.options import announce_reader, given, listed, load_of, numbers, of_each, quantity_of
from stiction.mechanics.law import NAMED, JacksonGreen
from stiction.studies.ladder import ladder
from stiction.studies.measured_files import Body, MeasuredFile
from stiction.studies.study import Study
from stiction.studies.text import validated
from stiction.surfaces.joined import JoinedSpectrum
from stiction.surfaces.pairing import LINES
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

OFFSETS = 64
"""Positions of one pair of profiles by default: some seconds of computing, and enough for an interval."""

SHIFTS = 16
"""Relative positions of two maps by default."""

SURROGATES = 16
"""Pairs of surrogates of profiles, which have no areas of their own, by default."""

HARDNESS = 2.84
"""Hardness over yield strength, of the law of Jackson and Green at small contact radii."""

MECHANICS = ("half-space", "asperities")

SPHERES = (
    "A profile says nothing about the third direction, so contacts were taken as spheres on a strip 1 µm thick. For "
    "grooves across the scan add --lay grooves; for surfaces alike in all directions, --lay isotropic."
)
HALF_PLANES = (
    "A profile says nothing about the third direction, so the surfaces were taken as grooved across the scan. For "
    "surfaces alike in all directions add --lay isotropic."
)


@dataclass(frozen=True)
class Asked:
    """What the options ask for.

    Attributes
    ----------
    values : dict
        Every option by its name, with its default where it is not given.
    chosen : frozenset of str
        Names of the options that are given.
    files : (MeasuredFile, MeasuredFile)
    upper, lower : Profile, Surface or JoinedSpectrum
        What they hold.
    """

    values: dict[str, Any]
    chosen: frozenset[str]
    files: tuple[MeasuredFile, MeasuredFile]
    upper: Body
    lower: Body

    @classmethod
    def of(cls, context: typer.Context) -> Asked:
        """What the options of a command line ask for, whose files are read.

        Raises
        ------
        ValueError
            If a file cannot be read, or an option does not apply or is not one of its choices.
        """
        values = dict(context.params)
        return cls._read(values, frozenset(name for name in values if given(context, name)))

    @classmethod
    def asking(cls, texts: dict[str, Any], defaults: dict[str, Any]) -> Asked:
        """What texts of options ask for without a command line; all others have their defaults.

        Raises
        ------
        ValueError
            As `of`.
        """
        return cls._read(defaults | texts, frozenset(texts))

    @classmethod
    def _read(cls, values: dict[str, Any], chosen: frozenset[str]) -> Asked:
        _check_choices(values)
        files = tuple(_file(values, side, index) for index, side in enumerate(("upper", "lower")))
        for file in files:
            announce_reader(Path(file.file))
        asked = cls(values, chosen, files, *(file.read() for file in files))  # type: ignore[arg-type]
        asked.check()
        return asked

    @property
    def are_maps(self) -> bool:
        """Whether both are maps."""
        return isinstance(self.upper, Surface) and isinstance(self.lower, Surface)

    @property
    def are_profiles(self) -> bool:
        """Whether both are profiles."""
        return isinstance(self.upper, Profile) and isinstance(self.lower, Profile)

    @property
    def has_spectrum(self) -> bool:
        """Whether one of both is a spectrum of several scans."""
        return isinstance(self.upper, JoinedSpectrum) or isinstance(self.lower, JoinedSpectrum)

    @property
    def press(self) -> str:
        """How members are made: "areas", "lines" or "surrogates"."""
        if self.has_spectrum or self.values["lay"] == "isotropic":
            return "surrogates"
        return "areas" if self.are_maps and self.values["lines"] is None else "lines"

    @property
    def by(self) -> tuple[str, ...]:
        """The mechanics, of which the first is that of the answer."""
        usual = "asperities" if self.press == "lines" else "half-space"
        if self.values["check"]:
            return usual, MECHANICS[1 - MECHANICS.index(usual)]
        return (self.values["mechanics"] or usual,)

    @property
    def law(self) -> str:
        """Name of the contact law of asperities."""
        is_free = "law" not in self.chosen and self.values["lay"] == "grooves"
        return "hertz-cylinder" if is_free else str(self.values["law"])

    @property
    def has_surrogates(self) -> bool:
        """Whether anything is pressed that was not scanned."""
        return self.press == "surrogates" or self.values["surrogates"] != "none"

    def check(self) -> None:
        """Refuse options that do not apply."""
        for names, applies, why in _APPLY:
            for name in names:
                if name in self.chosen and not applies(self):
                    value = self.values[name]
                    shown = f" {value}" if value is not True else ""
                    raise ValueError(f"{_option(name)} {why}, got {_option(name)}{shown}")

    # ---- The study --------------------------------------------------------------------------------------------------

    @property
    def elasticity(self) -> Elasticity:
        """What both bodies are made of."""
        return elasticity_of(
            *(self.values[name] for name in ("effective_modulus", "young", "poisson", "upper_material",
                                             "lower_material"))
        )  # fmt: skip

    def studies(self) -> list[Study]:
        """The study of the answer and, with --check, that by the other mechanics."""
        elasticity = self.elasticity
        contacts = [self._contact(mechanics, elasticity) for mechanics in self.by]
        loads = [exactly(load, "mN") for load in self._ladder(contacts).tolist()]
        return [self._study(contact | {"load": loads}) for contact in contacts]

    def first_study(self) -> Study | None:
        """The study of an answer within a second, by asperities; None where they are the answer, or of lines."""
        if self.press == "lines" or self.by[0] == "asperities":
            return None
        loads = [exactly(float(load), "mN") for load in self.loads]
        return self._study(self._contact("asperities", self.elasticity) | {"load": loads})

    def _ladder(self, contacts: list[dict[str, Any]]) -> Floats:
        """The loads that members are pressed to, by all mechanics the same, mN."""
        loads, most = [float(load) for load in self.loads], None
        hardness = [contact["hardness"] for contact in contacts if "hardness" in contact]
        if hardness:
            most = float(quantity(hardness[0], "pressure")) * self._nominal_area()
            if not loads[-1] < most:
                raise ValueError(f"--load must be below the hardness times the area, {most:.4g} mN")
        by_half_space = "half-space" in self.by
        return ladder(loads, press=self.press, mechanics="half-space" if by_half_space else "asperities", most=most)

    @property
    def loads(self) -> list[Quantity]:
        """The loads that are asked for, mN, in rising order; of pressures those on the nominal area."""
        loads = [load_of(text) for text in self.values["load"]]
        for text, (amount, _) in zip(self.values["load"], loads, strict=True):
            if not amount > 0:
                raise ValueError(f"--load must be above 0, got {text!r}")
        area = self._nominal_area() if any(per_area for _, per_area in loads) else 1.0
        # Pressure times area has a last digit that nobody asked for.
        forces = {float(f"{amount * area:.12g}") if per_area else amount for amount, per_area in loads}
        return [quantity(exactly(force, "mN"), "force") for force in sorted(forces)]

    def _nominal_area(self) -> float:
        """What is pressed of each member, µm²."""
        from stiction.studies.members import about

        placeholder = {"mu0": [0.0], "load": ["1 mN"]}
        data = {"surfaces": self._surfaces(), "ensemble": self._ensemble(), "friction": placeholder}
        area = about(validated(Study, data, "pair")).nominal_area
        assert area is not None, "measured bodies have one"
        return area

    def _study(self, contact: dict[str, Any]) -> Study:
        strengths = {quantity_of("--tau0", text, "pressure"): text for text in listed(self.values["tau0"])}
        friction = {
            "mu0": sorted(set(numbers("--mu0", self.values["mu0"]))),
            "tau0": [strengths[strength] for strength in sorted(strengths)],
            "load": [load.text for load in self.loads],
        }
        data = {
            "surfaces": self._surfaces(), "contact": contact, "friction": friction, "ensemble": self._ensemble(),
        }  # fmt: skip
        return validated(Study, data, "pair").with_known_files()

    def _surfaces(self) -> dict[str, Any]:
        values, press = self.values, self.press
        table: dict[str, Any] = {"kind": "measured", "press": press, "upper": self.files[0], "lower": self.files[1]}
        if values["cutoff"] is not None:
            lengths = {quantity_of("--cutoff", text, "length"): text for text in listed(values["cutoff"])}
            table["cut_off"] = [lengths[length] for length in sorted(lengths)]
        if values["level"] is not None:
            table["level"] = "plane" if press == "surrogates" and values["level"] == "line" else values["level"]
        if press == "areas":
            table |= {"rotate": values["rotate"] or 0.0, "surrogates": self._number_of_surrogates(0)}
        if press == "lines":
            table |= {"along": values["along"], "replace": values["surrogates"], "offsets": self._positions()[1]}
            if values["travel"] is not None:
                table["travel"] = values["travel"]
        return table

    def _ensemble(self) -> dict[str, Any]:
        if self.press == "lines":
            lines, offsets = self._positions()
            repetitions = lines * offsets
        elif self.press == "surrogates":
            repetitions = self._number_of_surrogates(SURROGATES)
        else:
            repetitions = self.values["shifts"] + self._number_of_surrogates(0)
        return {"repetitions": repetitions, "seed": self.values["seed"]}

    def _positions(self) -> tuple[int, int]:
        """How many pairs of lines there are, and how many positions on each."""
        lines, offsets = self.values["lines"] or LINES, self.values["offsets"]
        if self.are_profiles and not self.has_surrogates:
            return 1, OFFSETS if offsets is None else offsets
        if not self.has_surrogates:
            axis = 0 if self.values["along"] == "x" else 1
            scans = (self.upper, self.lower)
            lines = min(lines, *(scan.heights.shape[axis] for scan in scans if isinstance(scan, Surface)))
        if (offsets or 1) > 1 and self.values["travel"] is None:
            raise ValueError(f"--offsets {offsets} needs a --travel LENGTH, for which the slider is shortened")
        return lines, offsets or 1

    def _number_of_surrogates(self, default: int) -> int:
        text = self.values["surrogates"]
        if text == "none":
            return default
        if not text.isdecimal() or not int(text):
            raise ValueError(f"--surrogates of areas must be a number of pairs of at least 1, got {text!r}")
        return int(text)

    def _contact(self, mechanics: str, elasticity: Elasticity) -> dict[str, Any]:
        values = self.values
        table: dict[str, Any] = {
            "mechanics": mechanics, "effective_modulus": exactly(elasticity.effective_modulus, "GPa"),
        }  # fmt: skip
        for name, known in (("materials", elasticity.materials), ("poisson_ratio", elasticity.poisson_ratios)):
            if known is not None:
                table[name] = list(known)
        if values["direction"] is not None:
            table["direction"] = numbers("--direction", values["direction"])
        if mechanics == "half-space":
            table["compliance_share"] = elasticity.compliance_share
            if values["hardness"] is not None:
                table["hardness"] = values["hardness"]
            elif elasticity.hardness is not None:
                table["hardness"] = exactly(elasticity.hardness, "GPa")
        else:
            table |= {"law": self._law(elasticity), "detection": values["detection"]}
            if values["curvature"] is not None:
                table["curvature"] = values["curvature"]
        return table

    def _law(self, elasticity: Elasticity) -> Any:
        """The contact law of asperities, with its parameters."""
        if self.law != JacksonGreen.name:
            return self.law
        hardness, strength = self.values["hardness"], self.values["yield_strength"]
        of_material = elasticity.hardness if strength is None else None
        if strength is None and hardness is None and of_material is None:
            raise ValueError("--law jackson-green needs --yield-strength or --hardness, one of them")
        if elasticity.poisson_ratio is None:
            raise ValueError("--law jackson-green needs --poisson, of the softer body")
        if strength is None:
            largest = of_material if hardness is None else quantity_of("--hardness", hardness, "pressure")
            strength = exactly(float(largest or 0.0) / HARDNESS, "GPa")
        return {"name": self.law, "yield_strength": strength, "poisson_ratio": elasticity.poisson_ratio}

    def remarks(self) -> list[str]:
        """What is worth knowing of materials, and of profiles whose lay is not said."""
        remarks = [self.elasticity.source]
        if self.are_profiles and self.values["lay"] is None and self.press == "lines":
            by_half_planes = self.by == ("half-space",)
            remarks.append(HALF_PLANES if by_half_planes else "" if self.law == "hertz-cylinder" else SPHERES)
        return [remark for remark in remarks if remark]


def _check_choices(values: dict[str, Any]) -> None:
    """Refuse a value that is not one of the choices of an option."""
    for name, allowed in _CHOICES.items():
        if (value := values[name]) is not None and value not in allowed:
            raise ValueError(f"{_option(name)} must be {' or '.join(allowed)}, got {value!r}")


def _file(values: dict[str, Any], side: str, index: int) -> MeasuredFile:
    """A file and how it is read; options are for both files, or for one after the other."""
    parts = {name: of_each(values[name], index, _option(name)) for name in ("unit", "spacing", "channel", "columns")}
    table: dict[str, Any] = {"file": str(values[side]), "missing": values["missing"]}
    for name, text in parts.items():
        if text:
            table[name] = listed(text) if "," in text and name != "channel" else text
    return validated(MeasuredFile, table, f"pair: {side}")


def _option(name: str) -> str:
    """How an option is called on the command line."""
    named = {"upper_material": "upper", "lower_material": "lower"}.get(name, name)
    return f"--{named.replace('_', '-')}"


_CHOICES: dict[str, tuple[str, ...]] = {
    "mechanics": MECHANICS,
    "lay": ("grooves", "isotropic"),
    "law": (*NAMED, JacksonGreen.name),
    "along": ("x", "y"),
    "detection": ("gap-minimum", "cell"),
    "curvature": ("convex", "signed"),
    "missing": ("error", "interpolate"),
}

_APPLY: tuple[tuple[tuple[str, ...], Callable[[Asked], bool], str], ...] = (
    (("lay",), lambda asked: asked.are_profiles, "is for two profiles; a map has its lay in it"),
    (("mechanics",), lambda asked: not asked.values["check"], "must not be given beside --check, which is both"),
    (("lines",), lambda asked: not asked.has_spectrum, "is not for a spectrum, of which surfaces are made"),
    (("lines",), lambda asked: not asked.are_profiles or (asked.press == "lines" and asked.has_surrogates),
     "is for surfaces and surrogates; two profiles are one pair"),
    (("offsets", "travel"), lambda asked: asked.press == "lines", "is for lines; of maps give --lines as well"),
    (("along",), lambda asked: asked.press == "lines" and not asked.are_profiles, "is for lines of surfaces"),
    (("shifts", "rotate"), lambda asked: asked.press == "areas", "is for the areas of two maps, without --lines"),
    (("direction",), lambda asked: asked.press != "lines", "is for areas; lines are moved both ways"),
    (("seed",), lambda asked: asked.has_surrogates, "is for --surrogates"),
    (("law", "detection", "curvature", "yield_strength"), lambda asked: "asperities" in asked.by,
     "is for --mechanics asperities"),
    (("law",), lambda asked: asked.values["lay"] != "grooves" or asked.law == "hertz-cylinder",
     "must not be given beside --lay grooves, which presses cylinders"),
    (("yield_strength",), lambda asked: asked.law == JacksonGreen.name, "is for --law jackson-green"),
    (("yield_strength",), lambda asked: "hardness" not in asked.chosen or "half-space" in asked.by,
     "must not be given beside --hardness, which says it"),
    (("hardness",), lambda asked: "half-space" in asked.by or asked.law == JacksonGreen.name,
     "is for --mechanics half-space, and for --law jackson-green"),
    (("poisson",), lambda asked: asked.values["young"] is not None or asked.law == JacksonGreen.name,
     "is for --young and --law jackson-green"),
)  # fmt: skip
"""Options that do not always apply: where they apply, and the message where they do not."""
