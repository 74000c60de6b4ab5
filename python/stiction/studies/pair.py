"""A pair of measured bodies as a study, from numbers, arrays, or texts with units."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from stiction._arguments import (
    parse_coefficients,
    parse_load,
    parse_numbers,
    parse_quantities,
    parse_quantity,
    reject_decimal_commas,
    reject_negative,
    split_values,
)
from stiction._checks import Floats, number, whole_number
from stiction._errors import ArgumentError
from stiction._units import Quantity, exact_text, quantity, short_repr
from stiction.mechanics.half_space import ADHESION_RANGE, resolved_range
from stiction.mechanics.law import NAMED, JacksonGreen
from stiction.mechanics.materials import material, softer_material
from stiction.mechanics.model import THICKNESS
from stiction.studies.contact_tables import ladder
from stiction.studies.elasticity import Elasticity, elasticity_of
from stiction.studies.interfaces import Interface, interface, interfaces, medians
from stiction.studies.known import KINDS, NO_NUMBER, Known, read_known
from stiction.studies.measured_surfaces import SHIFTS, SURROGATES, TEXTURES, About, Body, MeasuredFile
from stiction.studies.members import about
from stiction.studies.study import SEED, Study
from stiction.studies.values import StudyError, validated
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.pairing import DEFAULT_LINES, SIDES
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import InstrumentLimit, instrument_limit
from stiction.surfaces.surface import Surface, as_body

OFFSETS = 64  # positions of one pair of profiles by default: some seconds of computing, and enough for an interval
LIGHTER = 4  # loads below those asked for of bodies that adhere, over two decades, on which their coefficient rises
NO_LOAD = 1e-3  # load of bodies that are not loaded over the attraction of one point, which holds them at least
LAW = "hertz-sphere"  # contact law of asperities by default
HARDNESS = 2.84  # hardness over yield strength, of the law of Jackson and Green at small contact radii
MECHANICS = ("half-space", "asperities")

OF_A_GAP = (
    "A gap does not say how its faces lean: contacts were taken to slide on half of its slopes. Closure, stiffness and "
    "area do not depend on that."
)

Several = Any  # one value or several: a number, a text with its unit, texts between commas, a list or an array


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two bodies and what is asked of them, in core units; None is the usual, a wrong one an `ArgumentError`."""

    upper: Any = None  # a file, or a Profile, Surface or JoinedSpectrum as it was scanned, or several: the slider
    lower: Any = None  # what it is carried over
    gap: Any = None  # in place of both: one map that is the gap of two faces
    load: Several
    width: Any = None  # across two profiles, that forces are on; else a strip 1 µm wide
    mu0: Several = None
    tau0: Several = None  # 0
    interface: Any = None  # name or file of both
    direction: Several = None
    effective_modulus: Any = None
    young: Several = None
    poisson: Several = None
    upper_material: str | None = None
    lower_material: str | None = None
    hardness: Any = None
    junction_growth: Any = None  # α
    wait: Several = None
    creep: Any = None
    work_of_adhesion: Any = None
    adhesion_range: Any = None
    law: str | None = None
    yield_strength: Any = None
    mechanics: str | None = None
    check: bool = False
    lines: int | None = None
    lay: str | None = None
    surrogates: int | str | None = None
    seed: int | None = None
    level: str | None = None
    cutoff: Several = None
    offsets: int | None = None
    travel: Any = None
    along: str | None = None
    detection: str | None = None
    curvature: str | None = None
    shifts: int | None = None
    rotate: float | None = None
    tilt: str | None = None
    unit: Several = None
    spacing: Several = None
    missing: str | None = None
    outliers: str | None = None
    crop: Several = None
    channel: Several = None
    columns: Several = None
    missing_value: Several = None
    accept: Several = None
    tip: Several = None
    texture: Several = None

    def __post_init__(self) -> None:
        bodies = (self.upper is not None) + (self.lower is not None)
        if bodies != (2 if self.gap is None else 0):
            more = "; {upper_material} and {lower_material} are materials, such as steel; the files come first"
            more = "" if self.upper_material is None and self.lower_material is None else more
            raise ArgumentError(f"give {{upper}} and {{lower}}, or the {{gap}} between them{more}")
        for name, allowed in _CHOICES.items():
            if (value := getattr(self, name)) is not None and value not in allowed:
                near = difflib.get_close_matches(str(value), allowed, n=1)
                hint = f"; did you mean {near[0]}?" if near else ""
                raise ArgumentError(f"{{{name}}} must be {' or '.join(allowed)}, got {{got}}{hint}", got=repr(value))
        if self.rotate is not None:
            number("rotate", self.rotate, unit="degrees")
        for name in (
            "hardness",
            "junction_growth",
            "creep",
            "work_of_adhesion",
            "adhesion_range",
            "yield_strength",
            "travel",
        ):
            if isinstance(getattr(self, name), (list, tuple)):
                raise ArgumentError(f"{{{name}}} must be one value, got {{got}}", got=short_repr(getattr(self, name)))
        for name, least in (("shifts", 1), ("lines", 1), ("offsets", 1), ("seed", 0)):
            if (value := getattr(self, name)) is not None:
                try:
                    whole_number("", value, minimum=least)
                except ValueError as error:
                    raise ArgumentError(f"{{{name}}} {{why}}", why=str(error).strip()) from None
        if self.mu0 is None and self.interface is None:
            raise ArgumentError("give {mu0}, or the {interface} that has it")
        for names, applies, why in _APPLY:
            for name in names:
                value = getattr(self, name)
                if value is not None and value is not False and not applies(self):
                    shown = "" if value is True else f" {value}"
                    raise ArgumentError(f"{{{name}}} {why}, got {{{name}}}{{shown}}", shown=shown)

    # ---- Bodies ------------------------------------------------------------------------------------------------------

    @cached_property
    def files(self) -> tuple[MeasuredFile, MeasuredFile]:
        """Where both bodies are, and how they are read."""
        parts = []
        for index, side in enumerate(SIDES):
            given = getattr(self, side) if self.gap is None else self.gap
            name = side if self.gap is None else "gap"
            first, *others = (self._file(side, index, scan) for scan in _scans_of(name, given))
            parts.append(first.model_copy(update={"others": tuple(others) or None}))
        return parts[0], parts[1]

    def _file(self, side: str, index: int, body: Any) -> MeasuredFile:
        """One body; what says how files are read is for both, or for one after the other."""
        names = ("unit", "spacing", "channel", "columns", "missing_value", "accept")
        table: dict[str, Any] = {
            "file": str(body), "missing": self.missing or "error", "outliers": self.outliers or "keep",
        }  # fmt: skip
        crops = list(self.crop) if isinstance(self.crop, (list, tuple)) else [self.crop] if self.crop else []
        if crops:
            table["crop"] = crops[index % len(crops)]
        if self.tip is not None and np.size(self.tip):  # of the command none is an empty list
            radii = parse_quantities("tip", self.tip, "length")
            table["tip"] = radii[index % len(radii)]
        if processes := split_values(self.texture or ()):
            table["texture"] = self._process(processes[index % len(processes)])
        if is_array := isinstance(body, np.ndarray):
            body = self._from_array(side, index, body)
        if not isinstance(body, (str, Path)):
            for name in (*(names[2:] if is_array else names), "missing", "outliers", "crop"):
                if np.size(getattr(self, name) or ()) and getattr(self, name) not in ("error", "keep"):
                    raise ArgumentError(
                        f"{{{name}}} is for files: read them first where only one of both is one, got {{{name}}}"
                    )
            own: dict[str, Any] = {name: table[name] for name in ("tip", "texture") if name in table}
            return MeasuredFile.holding(body, side).model_copy(update=own)
        for name in names:
            values = getattr(self, name)
            several = list(values) if isinstance(values, (list, tuple)) else [values]
            if len(several) > 2:
                raise ArgumentError(
                    f"{{{name}}} is for both files, or given twice for one after the other, got {len(several)}"
                )
            value = several[index % len(several)] if several else None
            if value is None or value == "":
                continue
            text = value if isinstance(value, str) else exact_text(value, "um") if name == "spacing" else str(value)
            table[name] = split_values(text) if "," in text and name != "channel" else text
        return validated(MeasuredFile, table, f"pair: {side}")

    def _process(self, name: Any) -> Any:
        if name not in TEXTURES:
            raise ArgumentError(
                f"{{texture}} must be {', '.join(TEXTURES)} or two of these, got {{got}}", got=repr(name)
            )
        return name

    def _from_array(self, side: str, index: int, heights: Any) -> Body:
        """Return an array as a body; its spacing and unit are for both bodies, or for one after the other."""
        given: list[Any] = []
        for values in (self.spacing, self.unit):
            several = list(values) if isinstance(values, (list, tuple)) else [values]
            value = several[index % len(several)] if several else None
            given.append(split_values(value) if isinstance(value, str) and "," in value else value)
        try:
            return as_body(side, heights, spacing=given[0], unit=given[1] or "um")  # type: ignore[no-any-return]
        except ValueError as error:
            raise ArgumentError(f"{{{side}}}{{why}}", why=str(error).removeprefix(side)) from None

    @cached_property
    def bodies(self) -> tuple[Body, Body]:
        """The slider, and what it is carried over, as they were scanned, the first of several scans."""
        upper, lower = (file.read() for file in self.files)
        return upper, lower

    @property
    def are_maps(self) -> bool:
        """Whether both are maps."""
        return all(isinstance(body, Surface) for body in self.bodies)

    @property
    def are_profiles(self) -> bool:
        """Whether both are profiles."""
        return all(isinstance(body, Profile) for body in self.bodies)

    @property
    def has_spectrum(self) -> bool:
        """Whether one of both is a spectrum of several scans."""
        return any(isinstance(body, JoinedSpectrum) for body in self.bodies)

    # ---- What is pressed, and how ------------------------------------------------------------------------------------

    @property
    def has_holes(self) -> bool:
        """Whether points of one are masked."""
        return any(getattr(body, "missing", None) is not None for body in self.bodies)

    @property
    def press(self) -> str:
        """How members are made: "areas", "lines" or "surrogates"."""
        if self.has_spectrum or self.lay == "isotropic":
            return "surrogates"
        return "areas" if self.are_maps and self.lines is None else "lines"

    @property
    def by(self) -> tuple[str, ...]:
        """The mechanics, of which the first is that of the answer."""
        usual = "half-space" if self.press != "lines" or self.has_holes or self._yields else "asperities"
        if self.check:
            return usual, MECHANICS[1 - MECHANICS.index(usual)]
        return (self.mechanics or usual,)

    @property
    def _yields(self) -> bool:
        """Whether two profiles are of materials with a hardness, and nothing asks for a law of asperities."""
        of_asperities = (self.law, self.yield_strength, self.detection, self.curvature)
        if not self.are_profiles or any(each is not None for each in of_asperities):
            return False
        return self.elasticity.hardness is not None

    @property
    def contact_law(self) -> str:
        """Name of the contact law of asperities."""
        return self.law or ("hertz-cylinder" if self.lay == "grooves" else LAW)

    @property
    def has_surrogates(self) -> bool:
        """Whether anything is pressed that was not scanned."""
        return self.press == "surrogates" or self.surrogates not in (None, "none")

    @cached_property
    def elasticity(self) -> Elasticity:
        """What both bodies are made of, at the middle of what is known."""
        modulus, young, poisson = (self._middle(name) for name in ("effective_modulus", "young", "poisson"))
        return elasticity_of(modulus, young, poisson, self.upper_material, self.lower_material)

    @cached_property
    def known(self) -> dict[str, list[Known]]:
        """What is known of inputs that were given as ranges or with an uncertainty, by their names."""
        found: dict[str, list[Known]] = {}
        for name in KINDS:
            texts = [each for each in split_values(getattr(self, name)) if each is not None]
            if not any(isinstance(each, str) and NO_NUMBER.search(each) for each in texts):
                continue
            if len(texts) > (2 if name in ("young", "poisson") else 1):
                raise ArgumentError(f"{{{name}}} must be one value where it is a range, got {{got}}", got=repr(texts))
            found[name] = self._read(name)
        return found

    def _read(self, name: str) -> list[Known]:
        try:
            return [read_known(name, each) for each in split_values(getattr(self, name)) if each is not None]
        except ValueError as error:
            raise ArgumentError(f"{{{name}}} {{why}}", why=str(error).strip()) from None

    @cached_property
    def strength(self) -> Interface | None:
        """mu0 and tau0 jointly, where an interface is given."""
        if self.interface is None:
            return None
        if not isinstance(self.interface, (str, Path)):
            raise ArgumentError("{interface} must be a name or a file that write_interface wrote")
        try:
            return interface(self.interface)
        except ValueError as error:
            raise ArgumentError("{interface} {why}", why=str(error).removeprefix("interface ")) from None

    def _middle(self, name: str) -> Any:
        """An argument as it was given, or the middle of what is known, in four digits."""
        if name in ("mu0", "tau0") and self.strength is not None:
            return medians(self.strength)[name == "tau0"]
        if name == "tau0" and self.tau0 is None:
            return 0.0
        if name not in self.known:
            return getattr(self, name)
        middle = [float(f"{each.value:.4g}") for each in self.known[name]]
        return middle if len(middle) > 1 else middle[0]

    @property
    def _known_table(self) -> dict[str, Any]:
        """What a study says of what is known; moduli with Poisson's ratios, of either of which it is the range."""
        names = set(self.known) | {name for name in ("hardness", "creep") if getattr(self, name) is not None}
        if names & {"young", "poisson"} and self.young is not None and self.poisson is not None:
            names |= {"young", "poisson"}
        table: dict[str, Any] = {}
        for name in sorted(names):
            own = self.known.get(name) or self._read(name)
            table[name] = [each.text for each in own] if name in ("young", "poisson") else own[0].text
        if self.by[0] == "half-space" and (growth := self._growth) is not None and not growth.is_exact:
            table["junction_growth"] = growth.text
        if self.strength is not None:
            name = str(self.interface)
            table["interface"] = name if name in interfaces() else str(Path(name).resolve())
            mu0, tau0 = self.strength.strength_intervals
            for name, interval, scale, unit in (("mu0", mu0, 1.0, ""), ("tau0", tau0, 1e3, " MPa")):
                low, high = (f"{scale * end:.4g}" for end in interval[1:])
                table |= {name: f"{low}..{high}{unit}"} if float(low) < float(high) else {}
        return table

    @cached_property
    def loads(self) -> list[Quantity]:
        """The loads that are asked for, mN, in rising order; of pressures those on the nominal area."""
        area = self._nominal_area if any(per_area for _, per_area in self._asked_loads) else 1.0
        strip = 1.0 if self.width is None else THICKNESS / self._width
        # A product has a last digit that nobody asked for.
        forces = {
            float(load) if (factor := area if per_area else strip) == 1 else float(f"{load * factor:.12g}")
            for load, per_area in self._asked_loads
        }
        if 0.0 in forces:  # every pull-off force is more than the attraction of one point
            forces = {force or float(f"{NO_LOAD * self._attraction_of_a_point:.3g}") for force in forces}
        return [quantity(exact_text(force, "mN"), "force") for force in sorted(forces)]

    @property
    def _asks_for_no_load(self) -> bool:
        return not all(load > 0 for load, _ in self._asked_loads)

    @property
    def _attraction_of_a_point(self) -> float:
        """Attraction w/ρ over one cell of the grid, mN."""
        points = int(np.prod(self._about.attributes["shape"]))
        steps = np.atleast_1d(np.asarray(self._about.attributes["spacing_um"], float))
        work, asked = (float(self._adhesion.get(name) or 0.0) for name in ("work_of_adhesion", "adhesion_range"))
        least = resolved_range(work, float(steps.max()), self.elasticity.effective_modulus)
        return work / max(asked or ADHESION_RANGE, least) * self._nominal_area / points

    @property
    def _width(self) -> float:
        """Width that forces on profiles are on, µm."""
        width = parse_quantity("width", self.width, "length")
        if not width > 0:
            raise ArgumentError("{width} must be above 0, got {got}", got=repr(self.width))
        if all(per_area for _, per_area in self._asked_loads):
            raise ArgumentError("{width} is for a load that is a force, got {load} {got}", got=repr(self.load))
        return float(width)

    @cached_property
    def _asked_loads(self) -> list[tuple[Quantity, bool]]:
        """Loads as they were given, mN or GPa of the slider's area, and whether they are that."""
        if not (loads := split_values(self.load)):
            raise ArgumentError("{load} must have at least one value, got {got}", got=repr(self.load))
        reject_decimal_commas("load", self.load)
        return [parse_load("load", load, or_zero=bool(self._adhesion.get("work_of_adhesion"))) for load in loads]

    # ---- Studies -----------------------------------------------------------------------------------------------------

    @property
    def study(self) -> Study:
        """The study of the answer."""
        return self.studies[0]

    @cached_property
    def studies(self) -> list[Study]:
        """The study of the answer and, with a check, that by the other mechanics."""
        contacts = [self._contact(mechanics) for mechanics in self.by]
        loads = [exact_text(load, "mN") for load in self._ladder(contacts).tolist()]
        return [self._study(contact | {"load": loads}) for contact in contacts]

    @property
    def first_study(self) -> Study | None:
        """The study of an answer within a second, by asperities; None where they are the answer, or of lines."""
        if self.press == "lines" or self.by[0] == "asperities" or self.has_holes:
            return None
        return self._study(self._contact("asperities") | {"load": self.loads})

    @property
    def remarks(self) -> list[str]:
        """What is worth knowing of materials, and of profiles whose lay is not said."""
        known, remarks = self.elasticity, []
        if known.source and self.hardness is None:
            remarks.append(f"{known.source}, {known.hardness_source}")
        elif known.source:
            remarks.append(f"{known.source}; the hardness is that of --hardness")
        remarks += [known.renamed] if known.renamed else []
        if self.gap is not None:
            remarks.append(OF_A_GAP)
        return remarks

    def _study(self, contact: dict[str, Any]) -> Study:
        strengths = reject_negative("tau0", parse_quantities("tau0", self._middle("tau0"), "pressure"), self.tau0)
        coefficients = parse_coefficients("mu0", self._middle("mu0"))
        friction = {"mu0": sorted(set(coefficients)), "tau0": _rising(strengths), "load": self.loads}
        if self.wait is not None and contact["mechanics"] == "half-space":
            if self._hardness is None:
                raise ArgumentError("{wait} needs {hardness}: bodies that do not yield do not creep into each other")
            friction["wait"] = _rising(parse_quantities("wait", self.wait, "time"))
        data = {
            "surfaces": self._surfaces(), "contact": contact, "friction": friction, "ensemble": self._ensemble(),
            "known": self._known_table,
        }  # fmt: skip
        return _study_of(data).with_known_files()

    def _surfaces(self) -> dict[str, Any]:
        press, level = self.press, self.level
        table: dict[str, Any] = {"kind": "measured", "press": press, "upper": self.files[0], "lower": self.files[1]}
        if self.cutoff == "none":
            table["vouched"] = True
        elif self.cutoff is None:
            table |= self._both_readings
        else:
            table["cut_off"] = _rising(parse_quantities("cutoff", self.cutoff, "length"))
        if level is None and self.gap is not None and self.tilt == "fixed":
            level = "mean"  # the faces stay as they were measured
        if level is not None:
            table["level"] = "plane" if press == "surrogates" and level == "line" else level
        if press == "areas":
            table |= {"rotate": float(self.rotate or 0.0), "surrogates": self._number_of_surrogates(0)}
            table |= {} if self.gap is None else {"gap": True}
        if press == "lines":
            replaced = "none" if self.surrogates is None else str(self.surrogates)
            table |= {"along": self.along or "x", "replace": replaced, "offsets": self._positions()[1]}
            if self.travel is not None:
                table["travel"] = parse_quantity("travel", self.travel, "length")
        return table

    @cached_property
    def _both_readings(self) -> dict[str, Any]:
        """Scans as measured and filtered, where waves that may not be the surface's have much of the slope.

        Each scan is filtered at its own cutoff, or not at all. Filtered scans come first, and are quoted, if all of
        these waves are noise floors.
        """
        limits = [[_limit_of(scan) for scan in file.scans] for file in self.files]
        doubtful = [each for limits_of_part in limits for each in limits_of_part if each is not None]
        sides = [float(np.min(body.extent)) for file in self.files for body in file.bodies]
        longest = max((limit.cut_off for limit in doubtful), default=0.0)
        if not 0 < longest < min(sides, default=0.0) / 4:
            return {}
        parts = []
        for file, own in zip(self.files, limits, strict=True):
            first, *others = (
                scan.model_copy(update={"max_cut_off": _length(0.0 if limit is None else limit.cut_off)})
                for scan, limit in zip(file.scans, own, strict=True)
            )
            parts.append(first.model_copy(update={"others": tuple(others) or None}))
        floors = all(limit.origin == "instrument" for limit in doubtful)
        cut_offs = ["0 um", exact_text(longest, "um")]
        return {
            "cut_off": cut_offs[::-1] if floors else cut_offs, "both_readings": True,
            **dict(zip(SIDES, parts, strict=True)),
        }  # fmt: skip

    def _ensemble(self) -> dict[str, Any]:
        if self.press == "lines":
            lines, offsets = self._positions()
            repetitions = lines * offsets
        elif self.press == "surrogates":
            repetitions = self._number_of_surrogates(SURROGATES)
        else:
            repetitions = (1 if self.gap is not None else self.shifts or SHIFTS) + self._number_of_surrogates(0)
        pairs = 1 if self.gap is not None else math.prod(len(file.scans) for file in self.files)  # each as often
        return {"repetitions": -(-repetitions // pairs) * pairs, "seed": SEED if self.seed is None else self.seed}

    def _positions(self) -> tuple[int, int]:
        """How many pairs of lines there are, and how many positions on each."""
        lines, offsets = self.lines or DEFAULT_LINES, self.offsets
        if self.are_profiles and not self.has_surrogates:
            return 1, OFFSETS if offsets is None else offsets
        if not self.has_surrogates:
            axis = 1 if self.along == "y" else 0
            lines = min(lines, *(scan.heights.shape[axis] for scan in self.bodies if isinstance(scan, Surface)))
        if (offsets or 1) > 1 and self.travel is None:
            raise ArgumentError(f"{{offsets}} {offsets} needs a {{travel}} LENGTH, for which the slider is shortened")
        return lines, offsets or 1

    def _number_of_surrogates(self, default: int) -> int:
        text = "none" if self.surrogates is None else str(self.surrogates)
        if text == "none":
            return default
        if not text.isdecimal() or not int(text):
            raise ArgumentError(
                "{surrogates} of areas must be a number of pairs of at least 1, got {got}", got=repr(text)
            )
        return int(text)

    def _contact(self, mechanics: str) -> dict[str, Any]:
        known = self.elasticity
        table: dict[str, Any] = {
            "mechanics": mechanics, "effective_modulus": exact_text(known.effective_modulus, "GPa"),
        }  # fmt: skip
        for name, value in (("materials", known.materials), ("poisson_ratio", known.poisson_ratios)):
            if value is not None:
                table[name] = list(value)
        if self.direction is not None:
            table["direction"] = parse_numbers("direction", self.direction, integers=True)
        if mechanics == "half-space":
            table["compliance_share"] = known.compliance_share
            table |= {} if self.tilt is None else {"tilt": self.tilt}
            if (hardness := self._hardness) is not None:
                table["hardness"] = hardness
            if (growth := self._growth) is not None:
                table["junction_growth"] = growth.value
            elif self.junction_growth is not None:
                table["junction_growth"] = 0.0
            table |= self._adhesion
        else:
            table |= {"law": self._law(), "detection": self.detection or "gap-minimum"}
            if self.curvature is not None:
                table["curvature"] = self.curvature
        return table

    @property
    def _adhesion(self) -> dict[str, Quantity]:
        """Work of adhesion and its range, of which no range of values is taken: solutions over it are other studies."""
        found = {}
        for name, kind in (("work_of_adhesion", "work of adhesion"), ("adhesion_range", "length")):
            if (value := getattr(self, name)) is None:
                continue
            if isinstance(value, str) and NO_NUMBER.search(value):
                said = f"{{{name}}} must be one value; press at both ends of a range, got {{got}}"
                raise ArgumentError(said, got=repr(value))
            found[name] = parse_quantity(name, value, kind)
            reject_negative(name, [found[name]], value)
        return found

    @property
    def _growth(self) -> Known | None:
        """Return α of junction growth, by default that of the softer material; None where contacts do not grow."""
        given = self.junction_growth
        if given is None:
            # An interface is calibrated without growth, and applied without it.
            grows = self._hardness is not None and self.interface is None and not self._adhesion.get("work_of_adhesion")
            softer = softer_material(*map(material, self.elasticity.materials or ())) if grows else None
            value = softer and softer.junction_growth
            given = f"{value.low:g}..{value.high:g}" if value else 0.0
        elif self._hardness is None:
            raise ArgumentError("{junction_growth} needs {hardness}: contacts that do not yield do not grow")
        try:
            found = read_known("junction_growth", given)
        except ValueError as error:
            raise ArgumentError("{junction_growth} {why}", why=str(error).strip()) from None
        if found.value and self._adhesion.get("work_of_adhesion"):
            raise ArgumentError("{junction_growth} must be 0 with {work_of_adhesion}, got {got}", got=repr(given))
        return found if found.value else None

    @property
    def _hardness(self) -> Quantity | None:
        """That which is given, or else that of the materials."""
        if self.hardness is None:
            known = self.elasticity.hardness
            return None if known is None else quantity(exact_text(known, "GPa"), "pressure")
        if self.elasticity.materials and self.elasticity.hardness is None:
            raise ArgumentError("{hardness} must not be given: {got}", got=self.elasticity.hardness_source)
        self._read("hardness")  # whose errors name scales of hardness as well
        hardness = parse_quantity("hardness", self._middle("hardness"), "pressure")
        if not hardness > 0:
            raise ArgumentError("{hardness} must be above 0, got {got}", got=repr(self.hardness))
        return hardness

    def _law(self) -> Any:
        """The contact law of asperities, with its parameters."""
        if self.contact_law != JacksonGreen.name:
            return self.contact_law
        strength, ratio = self.yield_strength, self.elasticity.poisson_ratio
        if strength is None and self._hardness is None:
            raise ArgumentError("{law} jackson-green needs {yield_strength} or {hardness}, one of them")
        if ratio is None:
            raise ArgumentError("{law} jackson-green needs {poisson}, of the softer body")
        if strength is None:
            strength = exact_text(float(self._hardness or 0.0) / HARDNESS, "GPa")
        else:
            strength = parse_quantity("yield_strength", strength, "pressure")
        return {"name": self.contact_law, "yield_strength": strength, "poisson_ratio": ratio}

    def _ladder(self, contacts: list[dict[str, Any]]) -> Floats:
        """The loads that members are pressed to, by all mechanics the same, mN."""
        most = None
        hardness = next((contact["hardness"] for contact in contacts if "hardness" in contact), None)
        if hardness is not None:
            if any(per_area and load >= hardness for load, per_area in self._asked_loads):
                raise ArgumentError("{load} must be below the hardness, {hardest:.4g} GPa", hardest=float(hardness))
            most = float(hardness) * self._nominal_area
            if not self.loads[-1] < most:
                strip = self.are_profiles and self.press == "lines"
                raise ArgumentError(
                    "{load} must be below the hardness times the nominal area of {area:.4g} µm², {most:.4g} mN"
                    + ("; that is of a strip 1 µm wide: give a pressure, or a force and its {width}" if strip else ""),
                    area=self._nominal_area, most=most,
                )  # fmt: skip
        by_half_space = "half-space" in self.by
        lighter = LIGHTER if self._adhesion.get("work_of_adhesion") else 1
        return ladder(
            self.loads, press=self.press, mechanics="half-space" if by_half_space else "asperities", most=most,
            lighter=0 if self._asks_for_no_load else lighter,
        )  # fmt: skip

    @cached_property
    def _about(self) -> About:
        placeholder = {"mu0": [0.0], "load": ["1 mN"]}
        data = {"surfaces": self._surfaces(), "ensemble": self._ensemble(), "friction": placeholder}
        return about(_study_of(data))

    @property
    def _nominal_area(self) -> float:
        """Area of each member, µm²."""
        area = self._about.nominal_area
        assert area is not None, "measured bodies have one"
        return area


def _study_of(data: dict[str, Any]) -> Study:
    """Return a study of tables; a fault at a key that an argument sets is an `ArgumentError` of the argument."""
    try:
        return validated(Study, data, "pair")
    except StudyError as error:
        match = _AT_KEY.match(str(error))
        if match is None or (name := _ARGUMENT_OF_KEY.get(match["key"], match["key"])) not in ARGUMENTS:
            raise
        raise ArgumentError(f"{{{name}}} {{why}}", why=match["why"]) from None


_AT_KEY = re.compile(r"pair: (?:contact|friction|ensemble|known)\.(?P<key>\w+)(?:\[\d+\])?: (?P<why>.+)")
"""A line of a fault of a study, without where in a list it is."""

_ARGUMENT_OF_KEY = {"repetitions": "shifts", "materials": "upper_material", "poisson_ratio": "poisson"}
"""Arguments that have other names than the keys that they set."""


def pair_study(upper: Any = None, lower: Any = None, **asked: Any) -> Study:
    """The study of two bodies, files or in memory, by arguments of `Pair`; a `ValueError` if it cannot be pressed."""
    study = Pair(upper=upper, lower=lower, **asked).study
    about(study)
    return study


ARGUMENTS = tuple(each.name for each in fields(Pair))  # names of what may be asked of a pair


def _scans_of(side: str, given: Any) -> list[Any]:
    """Scans of a part: elements of a list, files in a folder or between commas, or the one that is given."""
    if isinstance(given, (list, tuple)):
        found = list(given)
    elif isinstance(given, str) and not given.strip():  # which `Path` would take for the current folder
        found = [given]
    elif isinstance(given, (str, Path)) and Path(given).is_dir():
        found = sorted(each for each in Path(given).iterdir() if not (each.is_dir() or each.name.startswith(".")))
    elif isinstance(given, (str, Path)) and "," in str(given) and not Path(given).exists():
        found = split_values(str(given))
    else:
        return [given]
    if not found or any(isinstance(each, str) and not each.strip() for each in found):
        raise ArgumentError(
            f"{{{side}}} must have at least one scan, and no empty name, got {{got}}", got=repr(str(given))
        )
    return found


def _limit_of(scan: MeasuredFile) -> InstrumentLimit | None:
    """Limit of a scan below which waves have much of the slope and may not be the surface's, or None."""
    body = scan.read()
    if isinstance(body, JoinedSpectrum) or body.is_flat:
        return None
    limit = instrument_limit(body, texture=scan.texture is not None)
    return limit if limit.matters else None


def _length(wavelength: float) -> Quantity:
    return quantity(exact_text(wavelength, "um"), "length")


def _rising(values: list[Quantity]) -> list[Quantity]:
    """Quantities in rising order, each once; of equal ones the last."""
    by_value = {float(value): value for value in values}
    return [by_value[value] for value in sorted(by_value)]


_CHOICES: dict[str, tuple[str, ...]] = {
    "mechanics": MECHANICS,
    "lay": ("grooves", "isotropic"),
    "law": (*NAMED, JacksonGreen.name),
    "along": ("x", "y"),
    "tilt": ("fixed", "free"),
    "detection": ("gap-minimum", "cell"),
    "curvature": ("convex", "signed"),
    "missing": ("error", "interpolate", "mask"),
    "outliers": ("keep", "mask"),
}

_APPLY: tuple[tuple[tuple[str, ...], Callable[[Pair], bool], str], ...] = (
    (("width",), lambda asked: asked.are_profiles and asked.press == "lines",
     "is for two profiles, which are pressed as lines; other bodies have an area"),
    (("lay",), lambda asked: asked.are_profiles, "is for two profiles; a map has its lay in it"),
    (("mechanics", "check"), lambda asked: not asked.has_holes or "asperities" not in asked.by,
     "presses asperities, which take whole scans: points of one are masked"),
    (("surrogates", "lay"), lambda asked: not (asked.has_holes and asked.has_surrogates),
     "makes surfaces of a spectrum, which takes whole scans: points of one are masked"),
    (("work_of_adhesion",), lambda asked: not asked.has_holes,
     "takes whole scans: points of one are masked; {missing} interpolate fills them, and {crop} leaves them out"),
    (("mechanics",), lambda asked: not asked.check, "must not be given beside {check}, which is both"),
    (("lines",), lambda asked: not asked.has_spectrum, "is not for a spectrum, of which surfaces are made"),
    (("lines",), lambda asked: not asked.are_profiles or (asked.press == "lines" and asked.has_surrogates),
     "is for surfaces and surrogates; two profiles are one pair"),
    (("offsets", "travel"), lambda asked: asked.press == "lines", "is for lines; of maps give {lines} as well"),
    (("along",), lambda asked: asked.press == "lines" and not asked.are_profiles, "is for lines of surfaces"),
    (("shifts", "rotate", "lines", "surrogates"), lambda asked: asked.gap is None,
     "is not for the {gap} of two faces, which belong together"),
    (("gap",), lambda asked: asked.are_maps and len(asked.files[0].scans) == 1, "must be one map"),
    (("tilt",), lambda asked: "half-space" in asked.by, "is for {mechanics} half-space"),
    (("shifts", "rotate"), lambda asked: asked.press == "areas", "is for the areas of two maps, without {lines}"),
    (("direction",), lambda asked: asked.press != "lines", "is for areas; lines are moved both ways"),
    (("seed",), lambda asked: asked.has_surrogates, "is for {surrogates}"),
    (("law", "detection", "curvature", "yield_strength"), lambda asked: "asperities" in asked.by,
     "is for {mechanics} asperities"),
    (("law",), lambda asked: asked.lay != "grooves" or asked.contact_law == "hertz-cylinder",
     "must not be given beside {lay} grooves, which presses cylinders"),
    (("mu0", "tau0"), lambda asked: asked.interface is None, "must not be given beside {interface}, which has both"),
    (("yield_strength",), lambda asked: asked.contact_law == JacksonGreen.name, "is for {law} jackson-green"),
    (("yield_strength",), lambda asked: asked.hardness is None or "half-space" in asked.by,
     "must not be given beside {hardness}, which says it"),
    (("hardness",), lambda asked: "half-space" in asked.by or asked.contact_law == JacksonGreen.name,
     "is for {mechanics} half-space, and for {law} jackson-green"),
    (("junction_growth",), lambda asked: "half-space" in asked.by, "is for {mechanics} half-space"),
    (("wait",), lambda asked: asked.creep is not None, "needs {creep}, the exponent of indentation creep"),
    (("creep",), lambda asked: asked.wait is not None, "is for {wait}"),
    (("wait",), lambda asked: asked.by[0] == "half-space", "is for {mechanics} half-space"),
    (("work_of_adhesion", "adhesion_range"), lambda asked: asked.by == ("half-space",),
     "is for {mechanics} half-space alone"),
    (("adhesion_range",), lambda asked: asked.work_of_adhesion is not None, "is for {work_of_adhesion}"),
    (("poisson",), lambda asked: asked.young is not None or asked.contact_law == JacksonGreen.name,
     "is for {young} and {law} jackson-green"),
)  # fmt: skip
"""Arguments that do not always apply: where they apply, and the message where they do not."""
