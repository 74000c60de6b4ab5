"""A pair of measured bodies as a study, from numbers, arrays, or texts with units."""

from __future__ import annotations

import math
from functools import cached_property
from pathlib import Path
from typing import Any, get_args

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
from stiction._checks import Floats
from stiction._errors import ArgumentError
from stiction._units import Quantity, exact_text, quantity
from stiction.mechanics.half_space import ADHESION_RANGE, resolved_range
from stiction.mechanics.law import JacksonGreen
from stiction.mechanics.materials import material, softer_material
from stiction.mechanics.model import THICKNESS
from stiction.studies.contact_tables import ladder
from stiction.studies.elasticity import Elasticity, elasticity_of
from stiction.studies.input_uncertainty import KINDS, UNCERTAIN_TEXT, UncertainInput, parse_study_input
from stiction.studies.interfaces import Interface, interface, interfaces, median_strength
from stiction.studies.measured_surfaces import SHIFTS, SURROGATES, TEXTURES, Body, BodyAttributes, MeasuredFile
from stiction.studies.members import body_attributes
from stiction.studies.pair_options import (
    CHECK_ORDER,
    MECHANICS,
    OPTIONS,
    READING,
    Kind,
    Mechanics,
    PairOptions,
    read_options,
    split_list,
)
from stiction.studies.study import SEED, Study
from stiction.studies.values import StudyError, validated
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.pairing import DEFAULT_LINES, SIDES, Surrogates
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import InstrumentLimit, instrument_limit
from stiction.surfaces.surface import Surface, as_body

DEFAULT_OFFSETS = (
    64  # positions of one pair of profiles by default: some seconds of computing, and enough for an interval
)
NUM_LIGHTER_LOADS = (
    4  # loads below those asked for of bodies that adhere, over two decades, on which their coefficient rises
)
PRELOAD_FRACTION = (
    1e-3  # load of bodies that are not loaded over the attraction of one point, which holds them at least
)
DEFAULT_LAW = "hertz-sphere"  # contact law of asperities by default
HARDNESS_TO_YIELD_RATIO = 2.84  # hardness over yield strength, of the law of Jackson and Green at small contact radii

GAP_REMARK = (
    "A gap does not say how its faces lean: contacts were taken to slide on half of its slopes. Closure, stiffness and "
    "area do not depend on that."
)


class Pair:
    """Two bodies and what is asked of them, in core units; a wrong option is an `ArgumentError`."""

    def __init__(self, options: PairOptions) -> None:
        self.options = options
        bodies = (options.upper is not None) + (options.lower is not None)
        if bodies != (2 if options.gap is None else 0):
            more = "; {upper_material} and {lower_material} are materials, such as steel; the files come first"
            more = "" if options.upper_material is None and options.lower_material is None else more
            raise ArgumentError(f"give {{upper}} and {{lower}}, or the {{gap}} between them{more}")
        if options.mu0 is None and options.interface is None:
            raise ArgumentError("give {mu0}, or the {interface} that has it")
        for name in CHECK_ORDER:
            if (value := options.given(name)) is None:
                continue
            for each in OPTIONS[name].applies:
                if not each.holds(self):
                    shown = "" if value is True else f" {value}"
                    raise ArgumentError(f"{{{name}}} {each.message}, got {{{name}}}{{shown}}", shown=shown)

    @classmethod
    def from_values(cls, **values: object) -> Pair:
        """Return a pair by options that are not checked yet, named as the fields of `PairOptions`."""
        return cls(read_options(values))

    def _kind(self, name: str) -> Kind:
        kind = OPTIONS[name].kind
        assert kind is not None, f"{name} is declared without a kind of quantity"
        return kind

    def _quantity(self, name: str, value: object) -> Quantity:
        """Return a value of an option as a quantity of the kind of that option."""
        return parse_quantity(name, value, self._kind(name))

    def _quantities(self, name: str, values: object) -> list[Quantity]:
        return parse_quantities(name, values, self._kind(name))

    # ---- Bodies ------------------------------------------------------------------------------------------------------

    @cached_property
    def files(self) -> tuple[MeasuredFile, MeasuredFile]:
        """Where both bodies are, and how they are read."""
        parts = []
        for index, side in enumerate(SIDES):
            given = self.options.given(side) if self.options.gap is None else self.options.gap
            name = side if self.options.gap is None else "gap"
            first, *others = (self._file(side, index, scan) for scan in _list_scans(name, given))
            parts.append(first.model_copy(update={"others": tuple(others) or None}))
        return parts[0], parts[1]

    def _file(self, side: str, index: int, body: Any) -> MeasuredFile:
        """Return one body as a file and how it is read, or as a body in memory."""
        options = self.options
        own: dict[str, Any] = {}
        if options.tip is not None:
            radii = self._quantities("tip", options.tip)
            own["tip"] = radii[index % len(radii)]
        if processes := split_values(options.texture or ()):
            own["texture"] = self._process(processes[index % len(processes)])
        is_array = isinstance(body, np.ndarray)
        if not isinstance(body, (str, Path)):
            for name in READING:
                if is_array and name in ("unit", "spacing"):
                    continue
                if options.given(name) not in (None, "error", "keep"):
                    raise ArgumentError(
                        f"{{{name}}} is for files: read them first where only one of both is one, got {{{name}}}"
                    )
            body = self._from_array(side, index, body) if is_array else body
            return MeasuredFile.holding(body, side).model_copy(update=own)
        table = own | {"file": str(body)}
        for name in READING:
            if (value := self._select_value(name, index)) in (None, ""):
                continue
            text = value if isinstance(value, str) else exact_text(value, "um") if name == "spacing" else str(value)
            table[name] = split_list(name, text)
        try:
            return validated(MeasuredFile, table, f"pair: {side}")
        except StudyError as error:
            key, why = error.faults[0]
            if key not in OPTIONS:
                raise
            raise ArgumentError(f"{{{key}}} {{why}}, for {{{side}}}", why=why) from None

    def _select_value(self, name: str, index: int) -> Any:
        """Return the value of an option for one of both bodies: that of both, or the first or second of two."""
        given = self.options.given(name)
        values = given if isinstance(given, list) else [given]
        if len(values) > 2:
            raise ArgumentError(
                f"{{{name}}} is for both files, or given twice for one after the other, got {len(values)}"
            )
        return values[index % len(values)] if values else None

    def _process(self, name: Any) -> Any:
        if name not in TEXTURES:
            raise ArgumentError(
                f"{{texture}} must be {', '.join(TEXTURES)} or two of these, got {{got}}", got=repr(name)
            )
        return name

    def _from_array(self, side: str, index: int, heights: Any) -> Body:
        """Return an array as a body; its spacing and unit are for both bodies, or for one after the other."""
        spacing: Any = self._select_value("spacing", index)
        unit: Any = self._select_value("unit", index) or "um"
        try:
            return as_body(side, heights, spacing=_split_commas(spacing), unit=_split_commas(unit))  # type: ignore[no-any-return]
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

    @property
    def scan_counts(self) -> tuple[int, int]:
        """Number of scans of the upper and of the lower body."""
        upper, lower = self.files
        return len(upper.scans), len(lower.scans)

    # ---- What is pressed, and how ------------------------------------------------------------------------------------

    @property
    def has_missing(self) -> bool:
        """Whether points of one are masked."""
        return any(getattr(body, "missing", None) is not None for body in self.bodies)

    @property
    def press(self) -> str:
        """How members are made: "areas", "lines" or "surrogates"."""
        if self.has_spectrum or self.options.lay == "isotropic":
            return "surrogates"
        return "areas" if self.are_maps and self.options.lines is None else "lines"

    @property
    def contact_models(self) -> tuple[Mechanics, ...]:
        """The mechanics, of which the first is that of the answer."""
        usual: Mechanics = (
            "half-space" if self.press != "lines" or self.has_missing or self._uses_plastic_lines else "asperities"
        )
        if self.options.check:
            return usual, MECHANICS[1 - MECHANICS.index(usual)]
        return (self.options.mechanics or usual,)

    @property
    def _uses_plastic_lines(self) -> bool:
        """Whether two profiles are of materials with a hardness, and nothing asks for a law of asperities."""
        of_asperities = (self.options.law, self.options.yield_strength, self.options.detection, self.options.curvature)
        if not self.are_profiles or any(each is not None for each in of_asperities):
            return False
        return self.elasticity.hardness is not None

    @property
    def contact_law(self) -> str:
        """Name of the contact law of asperities."""
        return self.options.law or ("hertz-cylinder" if self.options.lay == "grooves" else DEFAULT_LAW)

    @property
    def has_surrogates(self) -> bool:
        """Whether anything is pressed that was not scanned."""
        return self.press == "surrogates" or self.options.surrogates not in (None, "none")

    @cached_property
    def elasticity(self) -> Elasticity:
        """What both bodies are made of, at the middle of what is known."""
        modulus, young, poisson = (self._nominal_value(name) for name in ("effective_modulus", "young", "poisson"))
        return elasticity_of(modulus, young, poisson, self.options.upper_material, self.options.lower_material)

    @cached_property
    def uncertain_inputs(self) -> dict[str, list[UncertainInput]]:
        """What is known of inputs that were given as ranges or with an uncertainty, by their names."""
        found: dict[str, list[UncertainInput]] = {}
        for name in KINDS:
            texts = [each for each in split_values(self.options.given(name)) if each is not None]
            if not any(isinstance(each, str) and UNCERTAIN_TEXT.search(each) for each in texts):
                continue
            if len(texts) > (2 if name in ("young", "poisson") else 1):
                raise ArgumentError(f"{{{name}}} must be one value where it is a range, got {{got}}", got=repr(texts))
            found[name] = self._read(name)
        return found

    def _read(self, name: str) -> list[UncertainInput]:
        try:
            return [
                parse_study_input(name, each) for each in split_values(self.options.given(name)) if each is not None
            ]
        except ValueError as error:
            raise ArgumentError(f"{{{name}}} {{why}}", why=str(error).strip()) from None

    @cached_property
    def strength(self) -> Interface | None:
        """mu0 and tau0 jointly, where an interface is given."""
        if self.options.interface is None:
            return None
        if not isinstance(self.options.interface, (str, Path)):
            raise ArgumentError("{interface} must be a name or a file that write_interface wrote")
        try:
            return interface(self.options.interface)
        except ValueError as error:
            raise ArgumentError("{interface} {why}", why=str(error).removeprefix("interface ")) from None

    def _nominal_value(self, name: str) -> Any:
        """An argument as it was given, or the middle of what is known, in four digits."""
        if name in ("mu0", "tau0") and self.strength is not None:
            return median_strength(self.strength)[name == "tau0"]
        if name == "tau0" and self.options.tau0 is None:
            return 0.0
        if name not in self.uncertain_inputs:
            return self.options.given(name)
        middle = [float(f"{each.value:.4g}") for each in self.uncertain_inputs[name]]
        return middle if len(middle) > 1 else middle[0]

    @property
    def _uncertainty_table(self) -> dict[str, Any]:
        """What a study says of what is known; moduli with Poisson's ratios, of either of which it is the range."""
        names = set(self.uncertain_inputs) | {
            name for name in ("hardness", "creep") if self.options.given(name) is not None
        }
        if names & {"young", "poisson"} and self.options.young is not None and self.options.poisson is not None:
            names |= {"young", "poisson"}
        table: dict[str, Any] = {}
        for name in sorted(names):
            own = self.uncertain_inputs.get(name) or self._read(name)
            table[name] = [each.text for each in own] if name in ("young", "poisson") else own[0].text
        if self.contact_models[0] == "half-space" and (growth := self._growth) is not None and not growth.is_exact:
            table["junction_growth"] = growth.text
        if self.strength is not None:
            name = str(self.options.interface)
            table["interface"] = name if name in interfaces() else str(Path(name).resolve())
            mu0, tau0 = self.strength.strength_intervals
            for name, interval, scale, unit in (("mu0", mu0, 1.0, ""), ("tau0", tau0, 1e3, " MPa")):
                low, high = (f"{scale * end:.4g}" for end in interval[1:])
                table |= {name: f"{low}..{high}{unit}"} if float(low) < float(high) else {}
        return table

    @cached_property
    def loads(self) -> list[Quantity]:
        """The loads that are asked for, mN, in rising order; of pressures those on the nominal area."""
        area = self._nominal_area if any(per_area for _, per_area in self._given_loads) else 1.0
        strip = 1.0 if self.options.width is None else THICKNESS / self._width
        # A product has a last digit that nobody asked for.
        forces = {
            float(load) if (factor := area if per_area else strip) == 1 else float(f"{load * factor:.12g}")
            for load, per_area in self._given_loads
        }
        if 0.0 in forces:  # every pull-off force is more than the attraction of one point
            forces = {force or float(f"{PRELOAD_FRACTION * self._cell_attraction:.3g}") for force in forces}
        return [quantity(exact_text(force, "mN"), "force") for force in sorted(forces)]

    @property
    def _has_zero_load(self) -> bool:
        return not all(load > 0 for load, _ in self._given_loads)

    @property
    def _cell_attraction(self) -> float:
        """Attraction w/ρ over one cell of the grid, mN."""
        points = int(np.prod(self._body_attributes.attributes["shape"]))
        steps = np.atleast_1d(np.asarray(self._body_attributes.attributes["spacing_um"], float))
        work, asked = (float(self._adhesion.get(name) or 0.0) for name in ("work_of_adhesion", "adhesion_range"))
        least = resolved_range(work, float(steps.max()), self.elasticity.effective_modulus)
        return work / max(asked or ADHESION_RANGE, least) * self._nominal_area / points

    @property
    def _width(self) -> float:
        """Width that forces on profiles are on, µm."""
        width = self._quantity("width", self.options.width)
        if not width > 0:
            raise ArgumentError("{width} must be above 0, got {got}", got=repr(self.options.width))
        if all(per_area for _, per_area in self._given_loads):
            raise ArgumentError("{width} is for a load that is a force, got {load} {got}", got=repr(self.options.load))
        return float(width)

    @cached_property
    def _given_loads(self) -> list[tuple[Quantity, bool]]:
        """Loads as they were given, mN or GPa of the slider's area, and whether they are that."""
        if not (loads := split_values(self.options.load)):
            raise ArgumentError("{load} must have at least one value, got {got}", got=repr(self.options.load))
        reject_decimal_commas("load", self.options.load)
        return [parse_load("load", load, or_zero=bool(self._adhesion.get("work_of_adhesion"))) for load in loads]

    # ---- Studies -----------------------------------------------------------------------------------------------------

    @property
    def study(self) -> Study:
        """The study of the answer."""
        return self.studies[0]

    @cached_property
    def studies(self) -> list[Study]:
        """The study of the answer and, with a check, that by the other mechanics."""
        contacts = [self._contact(mechanics) for mechanics in self.contact_models]
        loads = [exact_text(load, "mN") for load in self._load_steps(contacts).tolist()]
        return [self._study(contact | {"load": loads}) for contact in contacts]

    @property
    def preview_study(self) -> Study | None:
        """The study of an answer within a second, by asperities; None where they are the answer, or of lines."""
        if self.press == "lines" or self.contact_models[0] == "asperities" or self.has_missing:
            return None
        return self._study(self._contact("asperities") | {"load": self.loads})

    @property
    def remarks(self) -> list[str]:
        """What is worth knowing of materials, and of profiles whose lay is not said."""
        known, remarks = self.elasticity, []
        if known.source and self.options.hardness is None:
            remarks.append(f"{known.source}, {known.hardness_source}")
        elif known.source:
            remarks.append(f"{known.source}; the hardness is that of --hardness")
        remarks += [known.renamed] if known.renamed else []
        if self.options.gap is not None:
            remarks.append(GAP_REMARK)
        return remarks

    def _study(self, contact: dict[str, Any]) -> Study:
        strengths = reject_negative("tau0", self._quantities("tau0", self._nominal_value("tau0")), self.options.tau0)
        coefficients = parse_coefficients("mu0", self._nominal_value("mu0"))
        friction = {"mu0": sorted(set(coefficients)), "tau0": _sort_unique(strengths), "load": self.loads}
        if self.options.wait is not None and contact["mechanics"] == "half-space":
            if self._hardness is None:
                raise ArgumentError("{wait} needs {hardness}: bodies that do not yield do not creep into each other")
            friction["wait"] = _sort_unique(self._quantities("wait", self.options.wait))
        data = {
            "surfaces": self._surfaces(), "contact": contact, "friction": friction, "ensemble": self._ensemble(),
            "known": self._uncertainty_table,
        }  # fmt: skip
        return _validate_study(data).with_checksums()

    def _surfaces(self) -> dict[str, Any]:
        press, level = self.press, self.options.level
        table: dict[str, Any] = {"kind": "measured", "press": press, "upper": self.files[0], "lower": self.files[1]}
        if self.options.cutoff == "none":
            table["vouched"] = True
        elif self.options.cutoff is None:
            table |= self._filter_settings
        else:
            table["cut_off"] = _sort_unique(self._quantities("cutoff", self.options.cutoff))
        if level is None and self.options.gap is not None and self.options.tilt == "fixed":
            level = "mean"  # the faces stay as they were measured
        if level is not None:
            table["level"] = "plane" if press == "surrogates" and level == "line" else level
        if press == "areas":
            table |= {"rotate": float(self.options.rotate or 0.0), "surrogates": self._num_surrogates(0)}
            table |= {} if self.options.gap is None else {"gap": True}
        if (positions := self._listed_positions) is not None:
            table["positions"] = positions
        if press == "lines":
            replaced = "none" if self.options.surrogates is None else str(self.options.surrogates)
            if replaced not in get_args(Surrogates):
                allowed = ", ".join(get_args(Surrogates))
                raise ArgumentError(
                    f"{{surrogates}} of lines must be one of {allowed}, got {{got}}", got=repr(replaced)
                )
            table |= {"along": self.options.along or "x", "replace": replaced}
            table |= {"offsets": self._positions()[1]} if self._listed_positions is None else {}
            if self.options.travel is not None:
                table["travel"] = self._quantity("travel", self.options.travel)
        return table

    @cached_property
    def _filter_settings(self) -> dict[str, Any]:
        """Scans as measured and filtered, where waves that may not be the surface's have much of the slope.

        Each scan is filtered at its own cutoff, or not at all. Filtered scans come first, and are quoted, if all of
        these waves are noise floors.
        """
        limits = [[_find_limit(scan) for scan in file.scans] for file in self.files]
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
            repetitions = self._num_surrogates(SURROGATES)
        else:
            shifts = 1 if self.options.gap is not None else self.options.shifts or SHIFTS
            listed = self._listed_positions
            repetitions = (shifts if listed is None else len(listed)) + self._num_surrogates(0)
        # Each pair of scans has equally many members.
        pairs = 1 if self.options.gap is not None else math.prod(len(file.scans) for file in self.files)
        if self._listed_positions is not None:
            repetitions *= pairs
        return {
            "repetitions": -(-repetitions // pairs) * pairs,
            "seed": SEED if self.options.seed is None else self.options.seed,
        }

    @cached_property
    def _listed_positions(self) -> list[Any] | None:
        """Positions (µm) of the slider on the counterface, (x, y) of maps; None where they follow from a number."""
        if self.options.positions is None:
            return None
        found = self._quantities("positions", self.options.positions)
        if self.press == "lines":
            return list(reject_negative("positions", found, self.options.positions))
        if len(found) % 2:
            raise ArgumentError("{positions} of maps must be x and y of each, got {got} values", got=str(len(found)))
        return [list(pair) for pair in zip(found[::2], found[1::2], strict=True)]

    def _positions(self) -> tuple[int, int]:
        """How many pairs of lines there are, and how many positions on each."""
        lines, offsets = self.options.lines or DEFAULT_LINES, self.options.offsets
        if self.are_profiles and not self.has_surrogates:
            listed = self._listed_positions
            return 1, len(listed) if listed is not None else DEFAULT_OFFSETS if offsets is None else offsets
        if not self.has_surrogates:
            axis = 1 if self.options.along == "y" else 0
            lines = min(lines, *(scan.heights.shape[axis] for scan in self.bodies if isinstance(scan, Surface)))
        if self._listed_positions is not None:
            offsets = len(self._listed_positions)
        elif (offsets or 1) > 1 and self.options.travel is None:
            raise ArgumentError(f"{{offsets}} {offsets} needs a {{travel}} LENGTH, for which the slider is shortened")
        return lines, offsets or 1

    def _num_surrogates(self, default: int) -> int:
        text = "none" if self.options.surrogates is None else str(self.options.surrogates)
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
        if self.options.direction is not None:
            table["direction"] = parse_numbers("direction", self.options.direction, integers=True)
        if mechanics == "half-space":
            table["compliance_share"] = known.compliance_share
            table |= {} if self.options.tilt is None else {"tilt": self.options.tilt}
            if (hardness := self._hardness) is not None:
                table["hardness"] = hardness
            if (growth := self._growth) is not None:
                table["junction_growth"] = growth.value
            elif self.options.junction_growth is not None:
                table["junction_growth"] = 0.0
            table |= self._adhesion
        else:
            table |= {"law": self._law(), "detection": self.options.detection or "gap-minimum"}
            if self.options.curvature is not None:
                table["curvature"] = self.options.curvature
        return table

    @property
    def _adhesion(self) -> dict[str, Quantity]:
        """Work of adhesion and its range, of which no range of values is taken: solutions over it are other studies."""
        found = {}
        for name in ("work_of_adhesion", "adhesion_range"):
            if (value := self.options.given(name)) is None:
                continue
            if isinstance(value, str) and UNCERTAIN_TEXT.search(value):
                said = f"{{{name}}} must be one value; press at both ends of a range, got {{got}}"
                raise ArgumentError(said, got=repr(value))
            found[name] = self._quantity(name, value)
            reject_negative(name, [found[name]], value)
        return found

    @property
    def _growth(self) -> UncertainInput | None:
        """Return α of junction growth, None where contacts do not grow.

        By default it is that of the tests of the interface, or else that of the softer material.
        """
        given = self.options.junction_growth
        if given is None:
            grows = self._hardness is not None and not self._adhesion.get("work_of_adhesion")
            calibrated = self.strength.growth if grows and self.strength is not None else None
            if calibrated is not None:
                return calibrated if calibrated.value else None
            softer = softer_material(*map(material, self.elasticity.materials or ())) if grows else None
            value = softer and softer.junction_growth
            given = f"{value.low:g}..{value.high:g}" if value else 0.0
        elif self._hardness is None:
            raise ArgumentError("{junction_growth} needs {hardness}: contacts that do not yield do not grow")
        try:
            found = parse_study_input("junction_growth", given)
        except ValueError as error:
            raise ArgumentError("{junction_growth} {why}", why=str(error).strip()) from None
        if found.value and self._adhesion.get("work_of_adhesion"):
            raise ArgumentError("{junction_growth} must be 0 with {work_of_adhesion}, got {got}", got=repr(given))
        return found if found.value else None

    @property
    def _hardness(self) -> Quantity | None:
        """That which is given, or else that of the materials."""
        if self.options.hardness is None:
            known = self.elasticity.hardness
            return None if known is None else quantity(exact_text(known, "GPa"), "pressure")
        if self.elasticity.materials and self.elasticity.hardness is None:
            raise ArgumentError("{hardness} must not be given: {got}", got=self.elasticity.hardness_source)
        self._read("hardness")  # whose errors name scales of hardness as well
        hardness = self._quantity("hardness", self._nominal_value("hardness"))
        if not hardness > 0:
            raise ArgumentError("{hardness} must be above 0, got {got}", got=repr(self.options.hardness))
        return hardness

    def _law(self) -> Any:
        """The contact law of asperities, with its parameters."""
        if self.contact_law != JacksonGreen.name:
            return self.contact_law
        strength, ratio = self.options.yield_strength, self.elasticity.poisson_ratio
        if strength is None and self._hardness is None:
            raise ArgumentError("{law} jackson-green needs {yield_strength} or {hardness}, one of them")
        if ratio is None:
            raise ArgumentError("{law} jackson-green needs {poisson}, of the softer body")
        if strength is None:
            strength = exact_text(float(self._hardness or 0.0) / HARDNESS_TO_YIELD_RATIO, "GPa")
        else:
            strength = self._quantity("yield_strength", strength)
        return {"name": self.contact_law, "yield_strength": strength, "poisson_ratio": ratio}

    def _load_steps(self, contacts: list[dict[str, Any]]) -> Floats:
        """The loads that members are pressed to, by all mechanics the same, mN."""
        most = None
        hardness = next((contact["hardness"] for contact in contacts if "hardness" in contact), None)
        if hardness is not None:
            if any(per_area and load >= hardness for load, per_area in self._given_loads):
                raise ArgumentError("{load} must be below the hardness, {hardest:.4g} GPa", hardest=float(hardness))
            most = float(hardness) * self._nominal_area
            if not self.loads[-1] < most:
                strip = self.are_profiles and self.press == "lines"
                raise ArgumentError(
                    "{load} must be below the hardness times the nominal area of {area:.4g} µm², {most:.4g} mN"
                    + ("; that is of a strip 1 µm wide: give a pressure, or a force and its {width}" if strip else ""),
                    area=self._nominal_area, most=most,
                )  # fmt: skip
        loads = self.loads
        unloaded = loads[:1] if self._has_zero_load else []  # nothing between it and the others is read off
        loaded = loads[len(unloaded) :] or loads
        lighter = NUM_LIGHTER_LOADS if self._adhesion.get("work_of_adhesion") else 1
        around = ladder(
            loaded, press=self.press, mechanics="half-space" if "half-space" in self.contact_models else "asperities",
            most=most, lighter=0 if loaded == unloaded else lighter,
        )  # fmt: skip
        return np.union1d(around, np.array(unloaded, np.float64))

    @cached_property
    def _body_attributes(self) -> BodyAttributes:
        placeholder = {"mu0": [0.0], "load": ["1 mN"]}
        data = {"surfaces": self._surfaces(), "ensemble": self._ensemble(), "friction": placeholder}
        return body_attributes(_validate_study(data))

    @property
    def _nominal_area(self) -> float:
        """Area of each member, µm²."""
        area = self._body_attributes.nominal_area
        assert area is not None, "measured bodies have one"
        return area


def _validate_study(data: dict[str, Any]) -> Study:
    """Return a study of tables; a fault at a key that an option sets is an `ArgumentError` of the option."""
    try:
        return validated(Study, data, "pair")
    except StudyError as error:
        key, why = error.faults[0]
        if (name := _find_option(key)) is None:
            raise
        raise ArgumentError(f"{{{name}}} {{why}}", why=why) from None


def _find_option(key: str) -> str | None:
    """Return the option that sets a key of a study, "friction.mu0[0]", or None."""
    key = key.partition("[")[0]
    last = key.rpartition(".")[2]
    return next((name for name, option in OPTIONS.items() if option.key == key), last if last in OPTIONS else None)


def pair_study(upper: object = None, lower: object = None, **options: object) -> Study:
    """Return the study of two bodies, files or in memory, by options as fields of `PairOptions`.

    Raises a `ValueError` if it cannot be pressed.
    """
    return study_from_options(read_options({"upper": upper, "lower": lower, **options}))


def study_from_options(options: PairOptions) -> Study:
    """Return the study of two bodies, files or in memory; a `ValueError` if it cannot be pressed."""
    study = Pair(options).study
    body_attributes(study)
    return study


def _split_commas(value: Any) -> Any:
    """Return a text between commas as a list, and any other value unchanged."""
    return split_values(value) if isinstance(value, str) and "," in value else value


def _list_scans(side: str, given: Any) -> list[Any]:
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


def _find_limit(scan: MeasuredFile) -> InstrumentLimit | None:
    """Limit of a scan below which waves have much of the slope and may not be the surface's, or None."""
    body = scan.read()
    if isinstance(body, JoinedSpectrum) or body.is_flat:
        return None
    limit = instrument_limit(body, texture=scan.texture is not None)
    return limit if limit.matters else None


def _length(wavelength: float) -> Quantity:
    return quantity(exact_text(wavelength, "um"), "length")


def _sort_unique(values: list[Quantity]) -> list[Quantity]:
    """Quantities in rising order, each once; of equal ones the last."""
    by_value = {float(value): value for value in values}
    return [by_value[value] for value in sorted(by_value)]
