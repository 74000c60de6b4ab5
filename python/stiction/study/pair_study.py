"""Conversion of the options for a measured pair to a study."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable
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
    split_values,
    validate_nonnegative_values,
)
from stiction._checks import Floats
from stiction._errors import ArgumentError
from stiction._text import MAX_WORD_LENGTH
from stiction._threads import thread_pool_executor
from stiction._units import Quantity, exact_quantity_text, quantity_in_core_units, short_repr
from stiction.mechanics.half_space import DEFAULT_ADHESION_RANGE
from stiction.mechanics.half_space_problem import min_resolved_adhesion_range
from stiction.mechanics.hardness import HARDNESS_TO_YIELD_RATIO
from stiction.mechanics.law import JacksonGreen
from stiction.mechanics.materials import SLIP_LINE_KINDS, Material, material, softest_material
from stiction.mechanics.model import PROFILE_WIDTH
from stiction.study.contact_settings import choose_load_steps
from stiction.study.elasticity import (
    NUM_ELASTIC_CONSTANT_DIGITS,
    NUM_MATERIAL_DIGITS,
    PairElasticity,
    determine_elasticity,
    format_material_value,
)
from stiction.study.input_distributions import (
    INPUT_KINDS,
    SLIP_LINE_TEXT,
    UNCERTAINTY_PATTERN,
    InputValue,
    UncertainInput,
    parse_input_value,
)
from stiction.study.inputs import Inputs, find_material_of_hardness
from stiction.study.interfaces import InterfaceStrength, interfaces, round_median_strength
from stiction.study.measured_bodies import MACHINING_PROCESSES, MeasuredBody, MeasuredBodySettings
from stiction.study.measured_surfaces import DEFAULT_NUM_SHIFTS, DEFAULT_NUM_SURROGATES
from stiction.study.member_sources import BodyAttributes
from stiction.study.members import find_body_attributes
from stiction.study.moduli import DEFAULT_YIELD_EXPONENT, find_default_area_loss
from stiction.study.pair_options import (
    CONTACT_MODEL_NAMES,
    OPTION_CHECK_ORDER,
    PAIR_OPTIONS,
    READING_OPTION_NAMES,
    Mechanics,
    OptionKind,
    PairOptions,
    select_body_value,
    split_option_text,
    validate_option_values,
)
from stiction.study.study import DEFAULT_SEED, Study
from stiction.study.values import StudyError, validate_section
from stiction.surfaces.hidden_noise import NoiseHiddenInSpectrum
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.pairing import DEFAULT_NUM_LINE_PAIRS, SIDES, SurrogateBodies
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import InstrumentLimit
from stiction.surfaces.scan_defects import find_scan_defects
from stiction.surfaces.surface import Surface, as_body

# Number of relative positions of two profiles; all positions together take a few seconds to compute.
DEFAULT_NUM_POSITIONS = 64
NUM_ADHESION_LOADS = 4
ZERO_LOAD_REPLACEMENT_FRACTION = 1e-3
DEFAULT_CONTACT_LAW = "hertz-sphere"
SINGLE_VALUE_REQUIREMENTS = {
    "hardness": "the hardness of the softer body, as one value or one range", "creep": "one value or one range",
    "effective_modulus": "one value or one range",
}  # fmt: skip
"""Requirement, as text for a message, of each input of which a study has a single value, by name of the input."""

GAP_REMARK = (
    "A gap map does not contain the slopes of the two faces. Each face is assumed to have half of the slopes. "
    "Closure, stiffness and area do not depend on this assumption."
)


class MeasuredPair:
    """Measured pair: its bodies and options, from which a study is built.

    Quantities are converted to core units (µm, mN, GPa). Invalid options raise an `ArgumentError`.
    """

    def __init__(self, options: PairOptions, *, reads_scans: bool = True) -> None:
        self.options = options
        num_bodies = (options.upper is not None) + (options.lower is not None)
        if num_bodies != (2 if options.gap is None else 0):
            hint = "; {upper_material} and {lower_material} are materials; the first two arguments are the files"
            hint = "" if options.upper_material is None and options.lower_material is None else hint
            raise ArgumentError(f"give {{upper}} and {{lower}}, or the {{gap}} between them{hint}")
        if options.mu0 is None and options.interface is None:
            raise ArgumentError("give {mu0} or {interface}")
        self._check_conditions(OPTION_CHECK_ORDER if reads_scans else ())

    def _check_conditions(self, names: Iterable[str]) -> None:
        """Raise an `ArgumentError` if an option among `names` is given, but does not apply to the pair.

        The error names the first option that does not apply.
        """
        for name in names:
            if (value := self.options.option_value(name)) is None:
                continue
            for condition in PAIR_OPTIONS[name].applies:
                if not condition.is_met(self):
                    value_text = "" if value is True else f" {value}"
                    raise ArgumentError(
                        f"{{{name}}} {condition.message}, got {{{name}}}{{value_text}}", value_text=value_text
                    )

    @classmethod
    def from_values(cls, **values: object) -> MeasuredPair:
        """Create a measured pair from the values of its options, keyed by field names of `PairOptions`.

        Raises an `ArgumentError` if a value is invalid.
        """
        return cls(validate_option_values(values))

    @classmethod
    def check_entries(cls, **values: object) -> None:
        """Check the values of options without reading the scans.

        Raises an `ArgumentError` for the first invalid value. Conditions that depend on the scans are not checked.
        """
        pair = cls(validate_option_values(values), reads_scans=False)
        _ = pair.files, pair._loads_given_as_options, pair._friction_parameters, pair.elasticity, pair._hardness
        _ = (
            pair._adhesion_entries,
            pair._junction_growth,
            pair._yield_exponent,
            pair._area_loss,
            pair._indentation_depth,
        )
        for name in ("cutoff", "width", "wait"):
            if (value := pair.options.option_value(name)) not in (None, "none"):
                pair._parse_quantities(name, value)
        if pair.options.direction is not None:
            parse_numbers("direction", pair.options.direction, integers=True)

    def _find_quantity_kind(self, name: str) -> OptionKind:
        kind = PAIR_OPTIONS[name].kind
        assert kind is not None, f"{name} is declared without a kind of quantity"
        return kind

    def _parse_quantity(self, name: str, value: object) -> Quantity:
        """Parse the value of an option as a quantity whose unit must fit the option."""
        return parse_quantity(name, value, self._find_quantity_kind(name))

    def _parse_quantities(self, name: str, values: object) -> list[Quantity]:
        return parse_quantities(name, values, self._find_quantity_kind(name))

    # ---- Bodies ------------------------------------------------------------------------------------------------------

    @cached_property
    def files(self) -> tuple[MeasuredBodySettings, MeasuredBodySettings]:
        """Entries of the study file that specify the upper and the lower body: scan files and how to read them."""
        entries = []
        for index, side in enumerate(SIDES):
            scans = self.options.option_value(side) if self.options.gap is None else self.options.gap
            name = side if self.options.gap is None else "gap"
            first_scan, *other_scans = (self._build_file_entry(side, index, scan) for scan in _list_scans(name, scans))
            entries.append(first_scan.model_copy(update={"others": tuple(other_scans) or None}))
        return entries[0], entries[1]

    def _build_file_entry(self, side: str, index: int, body: Any) -> MeasuredBodySettings:
        """Create a study file's entry for a scan: file name and reading options, or a body that is already loaded."""
        options = self.options
        properties: dict[str, Any] = {}
        if options.tip is not None:
            tip_radii = self._parse_quantities("tip", options.tip)
            properties["tip"] = tip_radii[index % len(tip_radii)]
        processes = split_values(options.texture or ())
        if processes and (process := processes[index % len(processes)]) != "":
            properties["texture"] = self._validate_machining_process(process)
        is_array = isinstance(body, np.ndarray)
        if not isinstance(body, (str, Path)):
            for name in READING_OPTION_NAMES:
                if is_array and name in ("unit", "spacing"):
                    continue
                if options.option_value(name) not in (None, "error", "keep"):
                    raise ArgumentError(
                        f"{{{name}}} applies to files, but a body is an array or an object in memory; if the other "
                        f"body is a file, read it into memory with {{{name}}} first, and pass both as objects"
                    )
            body = self._build_body_from_array(side, index, body) if is_array else body
            return MeasuredBodySettings.from_body(body, side).model_copy(update=properties)
        settings = properties | {"file": str(body)}
        for name in READING_OPTION_NAMES:
            if (value := self._select_option_value(name, index)) in (None, ""):
                continue
            text = (
                value
                if isinstance(value, str)
                else exact_quantity_text(value, "um")
                if name == "spacing"
                else str(value)
            )
            settings[name] = split_option_text(name, text)
        try:
            return validate_section(MeasuredBodySettings, settings, f"pair: {side}")
        except StudyError as error:
            key, reason = error.faults[0]
            if key not in PAIR_OPTIONS:
                raise
            raise ArgumentError(f"{{{key}}} of {{{side}}} {{why}}", why=reason) from None

    def _select_option_value(self, name: str, index: int) -> Any:
        return select_body_value(name, self.options.option_value(name), index)

    def _validate_machining_process(self, name: Any) -> Any:
        if name not in MACHINING_PROCESSES:
            raise ArgumentError(
                f"{{texture}} must be one or two of {', '.join(MACHINING_PROCESSES)}, got {{got}}", got=repr(name)
            )
        return name

    def _build_body_from_array(self, side: str, index: int, heights: Any) -> MeasuredBody:
        """Convert an array of heights to a profile or height map, with the spacing and the unit that the user gives."""
        spacing: Any = self._select_option_value("spacing", index)
        unit: Any = self._select_option_value("unit", index) or "um"
        if spacing is None:
            raise ArgumentError(
                f"{{spacing}} must be given for an array, got {{{side}}} without a spacing; "
                'give spacing="0.1 um", and {unit} if the heights are not in um'
            )
        try:
            return as_body(side, heights, spacing=_split_at_commas(spacing), unit=_split_at_commas(unit))  # type: ignore[no-any-return]
        except ValueError as error:
            reason = str(error)
            name = next((name for name in ("unit", "spacing") if reason.startswith(f"{name} ")), side)
            raise ArgumentError.for_argument(name, reason.removeprefix(name).lstrip()) from None

    @cached_property
    def bodies(self) -> tuple[MeasuredBody, MeasuredBody]:
        """First scan of the upper body and first scan of the lower body."""
        upper, lower = (file.read() for file in self.files)
        return upper, lower

    @property
    def are_maps(self) -> bool:
        """True if both bodies are height maps."""
        return all(isinstance(body, Surface) for body in self.bodies)

    @property
    def are_profiles(self) -> bool:
        """True if both bodies are profiles."""
        return all(isinstance(body, Profile) for body in self.bodies)

    @property
    def has_spectrum(self) -> bool:
        """True if at least one body is given as a spectrum joined from several scans."""
        return any(isinstance(body, JoinedSpectrum) for body in self.bodies)

    @property
    def scan_counts(self) -> tuple[int, int]:
        """Numbers of scans of the upper and of the lower body."""
        upper, lower = self.files
        return len(upper.scans), len(lower.scans)

    # ---- Contact model -----------------------------------------------------------------------------------------------

    @property
    def has_masked_points(self) -> bool:
        """True if at least one body has masked points (points that were not measured)."""
        return any(getattr(body, "missing", None) is not None for body in self.bodies)

    @property
    def press_mode(self) -> str:
        """Kind of bodies that are pressed: "areas" (maps), "lines" (profiles or lines of maps) or "surrogates"."""
        if self.has_spectrum or self.options.lay == "isotropic":
            return "surrogates"
        return "areas" if self.are_maps and self.options.lines is None else "lines"

    @property
    def contact_models(self) -> tuple[Mechanics, ...]:
        """Contact models to use: the model for the result and, if the user requests a check, the other model."""
        default: Mechanics = (
            "half-space"
            if self.press_mode != "lines" or self.has_masked_points or self._uses_half_space_for_profiles
            else "asperities"
        )
        if self.options.check:
            return default, CONTACT_MODEL_NAMES[1 - CONTACT_MODEL_NAMES.index(default)]
        return (self.options.mechanics or default,)

    @property
    def _uses_half_space_for_profiles(self) -> bool:
        """True if both bodies are profiles, a hardness is known, and no option of the asperity model is given."""
        asperity_options = (
            self.options.law,
            self.options.yield_strength,
            self.options.detection,
            self.options.curvature,
        )
        if not self.are_profiles or any(option is not None for option in asperity_options):
            return False
        return self.elasticity.hardness is not None

    @property
    def contact_law(self) -> str:
        """Name of the contact law in the asperity model."""
        return self.options.law or ("hertz-cylinder" if self.options.lay == "grooves" else DEFAULT_CONTACT_LAW)

    @property
    def has_surrogates(self) -> bool:
        """True if the study generates surrogates: random surfaces with the measured spectra."""
        return self.press_mode == "surrogates" or self.options.surrogates not in (None, "none")

    @cached_property
    def elasticity(self) -> PairElasticity:
        """Elastic constants of the pair; an uncertain constant is represented by its central value."""
        modulus, young, poisson = (
            self._get_central_option_value(name) for name in ("effective_modulus", "young", "poisson")
        )
        return determine_elasticity(modulus, young, poisson, self.options.upper_material, self.options.lower_material)

    @cached_property
    def uncertain_inputs(self) -> dict[str, list[InputValue]]:
        """Inputs of the study for which the user gives an uncertainty, keyed by name."""
        inputs: dict[str, list[InputValue]] = {}
        for name in INPUT_KINDS:
            texts = [text for text in split_values(self.options.option_value(name)) if text is not None]
            if not any(isinstance(text, str) and UNCERTAINTY_PATTERN.search(text) for text in texts):
                continue
            if name in SINGLE_VALUE_REQUIREMENTS:
                inputs[name] = [self._parse_single_input(name)]
                continue
            if len(texts) > (2 if name in ("young", "poisson") else 1):
                reject_decimal_commas(name, self.options.option_value(name))
                raise ArgumentError(
                    f"{{{name}}} must not be a list if it contains a range, got {{got}}", got=repr(texts)
                )
            inputs[name] = self._parse_inputs(name)
        return inputs

    def _parse_inputs(self, name: str) -> list[InputValue]:
        """Parse the numbers that the user gives for one input of the study, for example several values of mu0.

        Numbers without a unit are in core units.
        """
        values = [value for value in split_values(self.options.option_value(name)) if value is not None]
        if INPUT_KINDS[name]:
            values = [value if isinstance(value, str) else exact_quantity_text(value, "GPa") for value in values]
        return [self._parse_input(name, value) for value in values]

    def _parse_single_input(self, name: str) -> InputValue:
        """Parse an input of the study that must be a single number; the user must not give a list."""
        given_value = self.options.option_value(name)
        if len(split_values(given_value)) != 1:
            reject_decimal_commas(name, given_value)
            raise ArgumentError(
                f"{{{name}}} must be {SINGLE_VALUE_REQUIREMENTS[name]}, got {{got}}", got=short_repr(given_value)
            )
        return self._parse_inputs(name)[0]

    def _parse_input(self, name: str, value: Any) -> InputValue:
        try:
            return parse_input_value(name, value)
        except ValueError as error:
            raise ArgumentError.for_argument(name, str(error)) from None

    @cached_property
    def given_interface(self) -> InterfaceStrength | None:
        """Interface that the user gives instead of mu0 and tau0.

        None if the user gives no interface.
        """
        if self.options.interface is None:
            return None
        if isinstance(self.options.interface, InterfaceStrength):
            return self.options.interface
        if not isinstance(self.options.interface, (str, Path)):
            raise ArgumentError(
                "{interface} must be a name, or a file written by write_interface, got {got}",
                got=short_repr(self.options.interface),
            )
        try:
            return InterfaceStrength.named(self.options.interface)
        except ValueError as error:
            raise ArgumentError("{interface} {why}", why=str(error).removeprefix("interface ")) from None

    @cached_property
    def half_space_inputs(self) -> Inputs:
        """Inputs of half-space contact without adhesion and junction growth: mu0, tau0, elasticity and hardness.

        If an interface is given, mu0 and tau0 are the medians of the interface.
        """
        self._check_conditions(("mu0", "tau0"))
        values = {name: self._parse_single_mu0_or_tau0(name) for name in ("mu0", "tau0")}
        entries = self._elasticity_entries
        modulus_text = exact_quantity_text(self.elasticity.effective_modulus, "GPa")
        values["effective_modulus"] = parse_input_value(
            "effective_modulus", entries.get("effective_modulus", modulus_text)
        )
        if self._hardness is not None:
            values["hardness"] = self._hardness
        moduli = ([parse_input_value(name, value) for value in entries.get(name, ())] for name in ("young", "poisson"))
        return Inputs.from_values(values, tuple(zip(*moduli, strict=True)), self._materials)

    @property
    def _materials(self) -> tuple[Material, ...]:
        """Materials of both bodies, or an empty tuple if the user names no materials."""
        return tuple(material(name) for name in self.elasticity.materials or ())

    def _parse_single_mu0_or_tau0(self, name: str) -> InputValue:
        """Parse mu0 or tau0 as one number, which may be uncertain."""
        if self.given_interface is not None or self.options.option_value(name) is None:
            value = self._get_central_option_value(name)
            return parse_input_value(name, exact_quantity_text(value, "GPa") if INPUT_KINDS[name] else value)
        values = self._parse_inputs(name)
        if len(values) != 1:
            raise ArgumentError(
                f"{{{name}}} must be one value or one range, got {{got}}",
                got=short_repr(self.options.option_value(name)),
            )
        return values[0]

    def _get_central_option_value(self, name: str) -> Any:
        """Return the value that the user gives for an option; if the value is uncertain, return its central value."""
        if name in ("mu0", "tau0") and self.given_interface is not None:
            return round_median_strength(self.given_interface)[name == "tau0"]
        if name == "tau0" and self.options.tau0 is None:
            return 0.0
        if name not in self.uncertain_inputs:
            return self.options.option_value(name)
        central_values = [float(item) for item in self.uncertain_inputs[name]]
        return central_values if len(central_values) > 1 else central_values[0]

    @cached_property
    def loads(self) -> list[Quantity]:
        """Requested loads (mN) in ascending order.

        A load that the user gives as a pressure is multiplied by the nominal area.
        """
        area = self._nominal_area if any(per_area for _, per_area in self._loads_given_as_options) else 1.0
        width_factor = 1.0 if self.options.width is None else PROFILE_WIDTH / self._profile_width
        # Rounding to twelve digits removes the round-off of the unit conversion.
        forces = {
            float(load) if (factor := area if per_area else width_factor) == 1 else float(f"{load * factor:.12g}")
            for load, per_area in self._loads_given_as_options
        }
        if 0.0 in forces:
            forces = {
                force or float(f"{ZERO_LOAD_REPLACEMENT_FRACTION * self._max_cell_adhesion_force:.3g}")
                for force in forces
            }
        return [quantity_in_core_units(force, "force") for force in sorted(forces)]

    @property
    def _has_zero_load(self) -> bool:
        return not all(load > 0 for load, _ in self._loads_given_as_options)

    @property
    def _max_cell_adhesion_force(self) -> float:
        """Largest adhesive force (mN) on a grid cell: cell area × work of adhesion, divided by the adhesion range."""
        num_points = int(np.prod(self._body_attributes.attributes["shape"]))
        spacings = np.atleast_1d(np.asarray(self._body_attributes.attributes["spacing_um"], float))
        work_of_adhesion, adhesion_range_of_study = (
            float(self._adhesion_entries.get(name) or 0.0) for name in ("work_of_adhesion", "adhesion_range")
        )
        min_adhesion_range = min_resolved_adhesion_range(
            work_of_adhesion, float(spacings.max()), self.elasticity.effective_modulus
        )
        return (
            work_of_adhesion
            / max(adhesion_range_of_study or DEFAULT_ADHESION_RANGE, min_adhesion_range)
            * self._nominal_area
            / num_points
        )

    @property
    def _profile_width(self) -> float:
        """Width (µm) perpendicular to the profiles; a load that the user gives as a force acts on this width."""
        width = self._parse_quantity("width", self.options.width)
        if not width > 0:
            raise ArgumentError("{width} must be above 0, got {got}", got=repr(self.options.width))
        if all(per_area for _, per_area in self._loads_given_as_options):
            raise ArgumentError(
                "{width} applies only if the {load} is a force, got {load} {got}", got=repr(self.options.load)
            )
        return float(width)

    @cached_property
    def _loads_given_as_options(self) -> list[tuple[Quantity, bool]]:
        """Loads that the user gives: (number in mN, False) for a force, and (number in GPa, True) for a pressure."""
        if not (loads := split_values(self.options.load)):
            raise ArgumentError("{load} must have at least one value, got {got}", got=repr(self.options.load))
        reject_decimal_commas("load", self.options.load)
        return [
            parse_load("load", load, or_zero=bool(self._adhesion_entries.get("work_of_adhesion"))) for load in loads
        ]

    # ---- Studies -----------------------------------------------------------------------------------------------------

    @property
    def study(self) -> Study:
        """Study from which the result of the pair is computed."""
        return self.studies[0]

    @cached_property
    def studies(self) -> list[Study]:
        """Studies to compute: one for the result and, if a check is requested, one with the other contact model."""
        contact_sections = [self._build_contact_section(mechanics) for mechanics in self.contact_models]
        load_texts = [exact_quantity_text(load, "mN") for load in self._choose_load_steps(contact_sections).tolist()]
        return [self._build_study(contact | {"load": load_texts}) for contact in contact_sections]

    @property
    def preview_study(self) -> Study | None:
        """Study in the asperity model, for a quick preview of the result.

        None if profiles or scan lines are pressed, if points are masked, or if the result itself uses the asperity
        model.
        """
        if self.press_mode == "lines" or self.contact_models[0] == "asperities" or self.has_masked_points:
            return None
        return self._build_study(self._build_contact_section("asperities") | {"load": self.loads})

    @property
    def remarks(self) -> list[str]:
        """Remarks for the user about the materials and, if a measured gap is given, about the gap map."""
        elasticity, remarks = self.elasticity, []
        if elasticity.source and self.options.hardness is None:
            remarks.append(f"{elasticity.source}, {elasticity.hardness_source}")
        elif elasticity.source:
            remarks.append(f"{elasticity.source}; the hardness was set by --hardness")
        remarks += [elasticity.alias_note] if elasticity.alias_note else []
        if self.options.gap is not None:
            remarks.append(GAP_REMARK)
        return remarks

    @property
    def _friction_parameters(self) -> dict[str, Any]:
        """Entries of the study section `[friction]` for mu0 and tau0: exact or uncertain numbers, or an interface."""
        if self.given_interface is not None:
            name = str(self.options.interface)
            return {"interface": name if name in interfaces() else str(Path(name).resolve())}
        strengths = validate_nonnegative_values(
            "tau0", self._parse_quantities("tau0", self._get_central_option_value("tau0")), self.options.tau0
        )
        coefficients = parse_coefficients("mu0", self._get_central_option_value("mu0"))
        values = {"mu0": sorted(set(coefficients)), "tau0": _sort_without_duplicates(strengths)}
        return values | {name: self.uncertain_inputs[name] for name in values if name in self.uncertain_inputs}

    def _build_study(self, contact: dict[str, Any]) -> Study:
        friction = self._friction_parameters | {"load": self.loads}
        if self.options.wait is not None and contact["mechanics"] == "half-space":
            if self._hardness is None:
                raise ArgumentError("{wait} needs {hardness}, because elastic contacts do not creep")
            friction["wait"] = _sort_without_duplicates(self._parse_quantities("wait", self.options.wait))
            friction["creep"] = self._parse_single_input("creep")
        sections = {
            "surfaces": self._build_surfaces_section(), "contact": contact, "friction": friction,
            "ensemble": self._build_ensemble_section(),
        }  # fmt: skip
        return _validate_study(sections).with_checksums()

    def _build_surfaces_section(self) -> dict[str, Any]:
        press, level = self.press_mode, self.options.level
        section: dict[str, Any] = {"kind": "measured", "press": press, "upper": self.files[0], "lower": self.files[1]}
        if self.options.cutoff == "none":
            section["vouched"] = True
        elif self.options.cutoff is None:
            section |= self._filter_settings
        else:
            section["cut_off"] = _sort_without_duplicates(self._parse_quantities("cutoff", self.options.cutoff))
        if level is None and self.options.gap is not None and self.options.tilt == "fixed":
            # Only the mean of the gap is subtracted, because the tilt between the faces matters.
            level = "mean"
        if level is not None:
            section["level"] = "plane" if press == "surrogates" and level == "line" else level
        if press == "areas":
            section |= {"rotate": float(self.options.rotate or 0.0), "surrogates": self._parse_num_surrogates(0)}
            section |= {} if self.options.gap is None else {"gap": True}
        if (positions := self._listed_positions) is not None:
            section["positions"] = positions
        if press == "lines":
            surrogate_choice = "none" if self.options.surrogates is None else str(self.options.surrogates)
            if surrogate_choice not in get_args(SurrogateBodies):
                allowed = ", ".join(get_args(SurrogateBodies))
                raise ArgumentError(
                    f"{{surrogates}} must be one of {allowed} for pairs of lines, got {{got}}",
                    got=repr(surrogate_choice),
                )
            section |= {"along": self.options.along or "x", "replace": surrogate_choice}
            if self.are_profiles and self.options.lay is None and self.options.law is None:
                section["lay_assumed"] = True
            section |= {"offsets": self._count_positions()[1]} if self._listed_positions is None else {}
            if self.options.travel is not None:
                section["travel"] = self._parse_quantity("travel", self.options.travel)
        return section

    @cached_property
    def _filter_settings(self) -> dict[str, Any]:
        """Entries of the study section `[surfaces]` for low-pass filters of scans whose short wavelengths may be noise.

        The study then has two cutoffs: one without a filter, and one at which each scan is filtered at its own cutoff.
        The filtered scans come first and give the quoted result if the spectrum of one scan ends in the noise floor of
        an instrument, and if wavelengths in the other scans may be noise as well. The dictionary is empty if no scan
        needs a filter.
        """
        extents = [float(np.min(body.extent)) for file in self.files for body in file.bodies]
        # The scans are read above, because readers change warning filters, which all threads share.
        # Each large scan takes seconds, mostly in NumPy functions that run without the interpreter lock.
        with thread_pool_executor() as pool:
            limits = pool.map(_find_noise_wavelengths, [scan for file in self.files for scan in file.scans])
            limits_by_file = [list(itertools.islice(limits, len(file.scans))) for file in self.files]
        present_limits = [limit for file_limits in limits_by_file for limit in file_limits if limit is not None]
        longest_cutoff = max((limit.cut_off for limit in present_limits), default=0.0)
        if not 0 < longest_cutoff < min(extents, default=0.0) / 4:
            return {}
        filtered_files = []
        for file, file_limits in zip(self.files, limits_by_file, strict=True):
            first_file, *other_files = (
                scan.model_copy(
                    update={"max_cut_off": quantity_in_core_units(0.0 if limit is None else limit.cut_off, "length")}
                )
                for scan, limit in zip(file.scans, file_limits, strict=True)
            )
            filtered_files.append(first_file.model_copy(update={"others": tuple(other_files) or None}))
        instrument_limits = [limit for limit in present_limits if isinstance(limit, InstrumentLimit)]
        are_noise_floors = bool(instrument_limits) and all(limit.origin == "instrument" for limit in instrument_limits)
        cut_offs = ["0 um", exact_quantity_text(longest_cutoff, "um")]
        return {
            "cut_off": cut_offs[::-1] if are_noise_floors else cut_offs, "both_readings": True,
            **dict(zip(SIDES, filtered_files, strict=True)),
        }  # fmt: skip

    def _build_ensemble_section(self) -> dict[str, Any]:
        if self.press_mode == "lines":
            num_lines, num_offsets = self._count_positions()
            num_members = num_lines * num_offsets
        elif self.press_mode == "surrogates":
            num_members = self._parse_num_surrogates(DEFAULT_NUM_SURROGATES)
        else:
            num_shifts = 1 if self.options.gap is not None else self.options.shifts or DEFAULT_NUM_SHIFTS
            positions = self._listed_positions
            num_members = (num_shifts if positions is None else len(positions)) + self._parse_num_surrogates(0)
        # The number of members is rounded up, so that all pairs of scans have the same number of members.
        num_scan_pairs = 1 if self.options.gap is not None else math.prod(len(file.scans) for file in self.files)
        if self._listed_positions is not None:
            num_members *= num_scan_pairs
        return {
            "repetitions": -(-num_members // num_scan_pairs) * num_scan_pairs,
            "seed": DEFAULT_SEED if self.options.seed is None else self.options.seed,
        }

    @cached_property
    def _listed_positions(self) -> list[Any] | None:
        """Positions (µm) of the slider that the user lists, or None if the program chooses the positions.

        Positions on maps are pairs (x, y).
        """
        if self.options.positions is None:
            return None
        lengths = self._parse_quantities("positions", self.options.positions)
        if self.press_mode == "lines":
            return list(validate_nonnegative_values("positions", lengths, self.options.positions))
        if len(lengths) % 2:
            raise ArgumentError(
                "{positions} must be pairs of x and y for maps, got {got} values", got=str(len(lengths))
            )
        return [list(pair) for pair in zip(lengths[::2], lengths[1::2], strict=True)]

    def _count_positions(self) -> tuple[int, int]:
        """Return the number of line pairs in the study, and the number of relative positions of each line pair."""
        num_lines, num_offsets = self.options.lines or DEFAULT_NUM_LINE_PAIRS, self.options.offsets
        if self.are_profiles and not self.has_surrogates:
            positions = self._listed_positions
            return 1, len(
                positions
            ) if positions is not None else DEFAULT_NUM_POSITIONS if num_offsets is None else num_offsets
        if not self.has_surrogates:
            axis = 1 if self.options.along == "y" else 0
            num_lines = min(num_lines, *(scan.heights.shape[axis] for scan in self.bodies if isinstance(scan, Surface)))
        if self._listed_positions is not None:
            num_offsets = len(self._listed_positions)
        elif (num_offsets or 1) > 1 and self.options.travel is None:
            raise ArgumentError(
                f"{{offsets}} {num_offsets} needs {{travel}} LENGTH, the difference in length between "
                "counterface and slider"
            )
        return num_lines, num_offsets or 1

    def _parse_num_surrogates(self, default: int) -> int:
        text = "none" if self.options.surrogates is None else str(self.options.surrogates)
        if text == "none":
            return default
        if not text.isdecimal() or len(text) > MAX_WORD_LENGTH or not int(text):
            raise ArgumentError("{surrogates} must be a whole number of at least 1, got {got}", got=short_repr(text))
        return int(text)

    def _build_contact_section(self, mechanics: str) -> dict[str, Any]:
        section: dict[str, Any] = {"mechanics": mechanics, **self._elasticity_entries}
        if self.options.direction is not None:
            section["direction"] = parse_numbers("direction", self.options.direction, integers=True)
        if mechanics == "half-space":
            section |= {} if self.options.tilt is None else {"tilt": self.options.tilt}
            if (hardness := self._hardness) is not None:
                section["hardness"] = hardness
            if (growth := self._junction_growth) is not None:
                section["junction_growth"] = growth
            if (exponent := self._yield_exponent) is not None:
                section["yield_exponent"] = exponent
            if (indent := self._indentation_depth) is not None:
                section["indent"] = indent
            if (area_loss := self._area_loss) is not None:
                section["area_loss"] = area_loss
            section |= self._adhesion_entries
        else:
            section |= {"law": self._build_contact_law_entry(), "detection": self.options.detection or "gap-minimum"}
            if self.options.curvature is not None:
                section["curvature"] = self.options.curvature
        return section

    @property
    def _elasticity_entries(self) -> dict[str, Any]:
        """Entries of the study section `[contact]` for elasticity: E*, or Young's moduli and Poisson's ratios."""
        elasticity, options = self.elasticity, self.options
        if options.effective_modulus is not None:
            return {"effective_modulus": self._parse_single_input("effective_modulus")}
        named_bodies = [None if name is None else material(name) for name in self._material_names]
        entries: dict[str, list[Any]] = {"young": [], "poisson": []}
        given_values = {
            name: self._parse_inputs(name) if options.option_value(name) is not None else [] for name in entries
        }
        for index, body in enumerate(named_bodies):
            if body is None:
                for name, values in given_values.items():
                    entries[name].append(values[index % len(values)])
                continue
            digits = NUM_MATERIAL_DIGITS if elasticity.materials is None else NUM_ELASTIC_CONSTANT_DIGITS
            entries["young"].append(format_material_value(body.young_modulus, "GPa", digits=digits))
            entries["poisson"].append(format_material_value(body.poisson_ratio, digits=digits))
        return entries | ({} if elasticity.materials is None else {"materials": list(elasticity.materials)})

    @property
    def _material_names(self) -> tuple[str | None, str | None]:
        """Names of the upper and the lower material; None for a body whose elastic constants are given as numbers."""
        upper, lower = self.options.upper_material, self.options.lower_material
        return (upper, lower) if self.options.young is not None else (upper or lower, lower or upper)

    @property
    def _adhesion_entries(self) -> dict[str, Quantity]:
        """Entries of the study section `[contact]` for adhesion: the work of adhesion, and the range of the attraction.

        The work of adhesion and the range must be single values, because the contacts are computed only once.
        """
        quantities = {}
        for name in ("work_of_adhesion", "adhesion_range"):
            if (value := self.options.option_value(name)) is None:
                continue
            if isinstance(value, str) and UNCERTAINTY_PATTERN.search(value):
                message = f"{{{name}}} must be one value, got {{got}}; compute both limits of a range separately"
                raise ArgumentError(message, got=repr(value))
            quantities[name] = self._parse_quantity(name, value)
            validate_nonnegative_values(name, [quantities[name]], value)
        return quantities

    @property
    def _junction_growth(self) -> InputValue | None:
        """Junction growth under shear; None if contacts cannot grow, and the user gives no junction growth.

        Contacts can grow if they yield and do not adhere. The default is the junction growth of the interface. Without
        an interface, contacts yield by slip lines, or do not grow (0) if a material to which slip-line theory does not
        apply is named.
        """
        no_growth = parse_input_value("junction_growth", 0.0)
        given_value: Any = self.options.junction_growth
        if given_value is None:
            can_grow = self._hardness is not None and not self._adhesion_entries.get("work_of_adhesion")
            if not can_grow:
                return None
            interface_growth = None if self.given_interface is None else self.given_interface.junction_growth
            if interface_growth is not None:
                return _build_growth_entry(interface_growth) or None
            if not self._can_yield_by_slip_lines:
                return no_growth
            given_value = SLIP_LINE_TEXT
        elif self._hardness is None:
            raise ArgumentError("{junction_growth} needs {hardness}, because shear enlarges only contacts that yield")
        growth = self._parse_input("junction_growth", given_value)
        if growth and self._adhesion_entries.get("work_of_adhesion"):
            raise ArgumentError(
                "{junction_growth} must be 0 if {work_of_adhesion} is given, got {got}", got=repr(given_value)
            )
        return growth if growth else no_growth

    @property
    def _can_yield_by_slip_lines(self) -> bool:
        """True if the softer body is a metal or a polymer, or has no named material: slip-line theory may apply.

        A given hardness may belong to either of two named materials.
        """
        assert self._hardness is not None, "contacts yield"
        softer_material = find_material_of_hardness(self._hardness.estimate, self._materials)
        possible_materials = self._materials if softer_material is None else (softer_material,)
        return not possible_materials or any(body.kind in SLIP_LINE_KINDS for body in possible_materials)

    @property
    def _yield_exponent(self) -> InputValue | None:
        """Exponent m in the formula for the true area of yielding contacts; None for elastic or adhesive contacts."""
        can_yield = self._hardness is not None and not self._adhesion_entries.get("work_of_adhesion")
        if (value := self.options.yield_exponent) is None:
            return parse_input_value("yield_exponent", DEFAULT_YIELD_EXPONENT) if can_yield else None
        if not can_yield:
            if self._hardness is None:
                raise ArgumentError(
                    "{yield_exponent} needs {hardness}, because contacts do not yield without a hardness"
                )
            raise ArgumentError(
                "{yield_exponent} must not be combined with {work_of_adhesion}, because the area of adhesive contacts "
                "is computed by capping pressures at the hardness, without an exponent"
            )
        return self._parse_input("yield_exponent", value)

    @property
    def _indentation_depth(self) -> Quantity | None:
        """Depth (µm) of the indentation from which the hardness was measured, or None if the depth is unknown."""
        if (value := self.options.indent) is None:
            return None
        if self._yield_exponent is None:
            if self._hardness is None:
                raise ArgumentError("{indent} needs {hardness}, because contacts do not yield without a hardness")
            raise ArgumentError(
                "{indent} must not be combined with {work_of_adhesion}, because adhesive contacts are computed with "
                "the measured hardness, without a size effect"
            )
        softer_material = softest_material(*self._materials)
        if softer_material is not None and softer_material.kind != "metal":
            raise ArgumentError(
                f"{{indent}} must not be given for {softer_material.name}, because only metals have the size effect"
            )
        depth = self._parse_quantity("indent", value)
        if not depth > 0:
            raise ArgumentError("{indent} must be above 0, got {got}", got=repr(value))
        return depth

    @property
    def _area_loss(self) -> InputValue | None:
        """Fraction of the true contact area that contacts lose under shear, or None if they lose no area.

        By default, soft bodies lose area under shear.
        """
        value: Any = self.options.area_loss
        if self._hardness is not None:
            if value is not None:
                reason = "because contacts that yield grow under shear"
                raise ArgumentError(f"{{area_loss}} must not be given for bodies with a hardness, {reason}")
            return None
        value = find_default_area_loss(self.elasticity.effective_modulus) if value is None else value
        return None if value is None else self._parse_input("area_loss", value)

    @property
    def _hardness(self) -> InputValue | None:
        """Hardness that the user gives or, by default, the hardness of the softer material; None for elastic bodies."""
        if self.options.hardness is None:
            value = self.elasticity.hardness
            return None if value is None else parse_input_value("hardness", format_material_value(value, "GPa"))
        if self.elasticity.materials and self.elasticity.hardness is None:
            raise ArgumentError(
                "{hardness} must not be given, because {reason}", reason=self.elasticity.hardness_source
            )
        return self._parse_single_input("hardness")

    def _build_contact_law_entry(self) -> Any:
        """Return the study entry for the contact law of the asperity model: its name, or a section with parameters."""
        if self.contact_law != JacksonGreen.name:
            return self.contact_law
        strength, ratio = self.options.yield_strength, self.elasticity.poisson_ratio
        if strength is None and self._hardness is None:
            raise ArgumentError("{law} jackson-green needs either {yield_strength} or {hardness}")
        if ratio is None:
            raise ArgumentError("{law} jackson-green needs {poisson} of the softer body")
        if strength is None:
            strength = exact_quantity_text(float(self._hardness or 0.0) / HARDNESS_TO_YIELD_RATIO, "GPa")
        else:
            strength = self._parse_quantity("yield_strength", strength)
        return {"name": self.contact_law, "yield_strength": strength, "poisson_ratio": ratio}

    def _choose_load_steps(self, contacts: list[dict[str, Any]]) -> Floats:
        """Return the loads (mN) at which contacts are computed.

        All contact models use the same loads.
        """
        max_load = None
        hardness = next((contact["hardness"] for contact in contacts if "hardness" in contact), None)
        if hardness is not None:
            if any(per_area and load >= hardness for load, per_area in self._loads_given_as_options):
                raise ArgumentError(
                    "{load} must give a pressure below the hardness ({hardest:.4g} GPa)", hardest=float(hardness)
                )
            max_load = float(hardness) * self._nominal_area
            if not self.loads[-1] < max_load:
                is_line_pair = self.are_profiles and self.press_mode == "lines"
                raise ArgumentError(
                    "{load} must be below {max_load:.4g} mN, the hardness times the nominal area of {area:.4g} µm²"
                    + (
                        "; this is for a width of 1 µm: give a pressure, or a force and its {width}"
                        if is_line_pair else ""
                    ),
                    area=self._nominal_area, max_load=max_load,
                )  # fmt: skip
        loads = self.loads
        # No loads are inserted between a load of 0 and the next load, because results are not interpolated there.
        zero_load_replacements = loads[:1] if self._has_zero_load else []
        regular_loads = loads[len(zero_load_replacements) :] or loads
        num_smaller = NUM_ADHESION_LOADS if self._adhesion_entries.get("work_of_adhesion") else 1
        steps = choose_load_steps(
            regular_loads, press=self.press_mode,
            mechanics="half-space" if "half-space" in self.contact_models else "asperities",
            max_load=max_load, num_smaller=0 if regular_loads == zero_load_replacements else num_smaller,
        )  # fmt: skip
        return np.union1d(steps, np.array(zero_load_replacements, np.float64))

    @cached_property
    def _body_attributes(self) -> BodyAttributes:
        placeholder_friction = {"mu0": [0.0], "load": ["1 mN"]}
        sections = {
            "surfaces": self._build_surfaces_section(),
            "ensemble": self._build_ensemble_section(),
            "friction": placeholder_friction,
        }
        # With file checksums, the surface settings equal those of the final study, so both studies share cached bodies.
        return find_body_attributes(_validate_study(sections).with_checksums())

    @property
    def _nominal_area(self) -> float:
        """Nominal contact area (µm²), which is the same for all surface pairs of the study."""
        area = self._body_attributes.nominal_area
        assert area is not None, "measured bodies have a nominal area"
        return area


def _build_growth_entry(estimate: UncertainInput) -> InputValue:
    """Convert a junction growth factor to a study-file entry: its central value and, if it is uncertain, its range."""
    if estimate.is_exact:
        return parse_input_value("junction_growth", estimate.value)
    return parse_input_value("junction_growth", f"{estimate.value:.6g} ({estimate.text})")


def _validate_study(sections: dict[str, Any]) -> Study:
    """Validate the sections of a study, and return the study.

    If the value of an option is invalid, an `ArgumentError` with the name of the option is raised.
    """
    try:
        return validate_section(Study, sections, "pair")
    except StudyError as error:
        key, reason = error.faults[0]
        if (name := _find_option(key)) is None:
            raise
        raise ArgumentError.for_argument(name, reason) from None


def _find_option(key: str) -> str | None:
    """Return the name of the option that sets a study key such as "friction.mu0[0]".

    Returns None if no option sets the key.
    """
    key = key.partition("[")[0]
    last_part = key.rpartition(".")[2]
    return next(
        (name for name, option in PAIR_OPTIONS.items() if option.key == key),
        last_part if last_part in PAIR_OPTIONS else None,
    )


def build_study_from_options(options: PairOptions) -> Study:
    """Create the study of a measured pair from its options.

    Raises a `ValueError` if the contact of the bodies cannot be computed.
    """
    study = MeasuredPair(options).study
    find_body_attributes(study)
    return study


def _split_at_commas(value: Any) -> Any:
    """Split a text at commas.

    Other values are returned unchanged.
    """
    return split_values(value) if isinstance(value, str) and "," in value else value


def _list_scans(side: str, scan_input: Any) -> list[Any]:
    """Return a list of a body's scans, given as a list, a directory, comma-separated file names, or a single scan."""
    if isinstance(scan_input, (str, Path)) and "\0" in str(scan_input):
        raise ArgumentError(
            f"{{{side}}} must be a path of printable characters, got {{got}}", got=repr(str(scan_input))
        )
    if isinstance(scan_input, (list, tuple)):
        scans = list(scan_input)
    elif isinstance(scan_input, str) and not scan_input.strip():
        # An empty path must be rejected, because Path("") is the current directory.
        scans = [scan_input]
    elif isinstance(scan_input, (str, Path)) and Path(scan_input).is_dir():
        scans = sorted(path for path in Path(scan_input).iterdir() if not (path.is_dir() or path.name.startswith(".")))
    elif isinstance(scan_input, (str, Path)) and "," in str(scan_input) and not Path(scan_input).exists():
        scans = split_values(str(scan_input))
    else:
        return [scan_input]
    if not scans:
        raise ArgumentError(f"{{{side}}} must contain at least one scan, got {{got}}", got=repr(str(scan_input)))
    if any(isinstance(scan, str) and not scan.strip() for scan in scans):
        raise ArgumentError(f"{{{side}}} must not contain an empty file name, got {{got}}", got=repr(str(scan_input)))
    return scans


def _find_noise_wavelengths(scan: MeasuredBodySettings) -> InstrumentLimit | NoiseHiddenInSpectrum | None:
    """Return the wavelength limit due to noise in a scan or, if there is none, the noise that its spectrum may hide."""
    body = scan.read()
    if isinstance(body, JoinedSpectrum) or body.is_flat:
        return None
    defects = find_scan_defects(body, scan.tip, textured=scan.texture is not None)
    return defects.instrument_limit if defects.instrument_limit.matters else defects.hidden_noise


def _sort_without_duplicates(values: list[Quantity]) -> list[Quantity]:
    """Return quantities in ascending order without duplicates.

    Of equal quantities, the last one is kept.
    """
    by_value = {float(value): value for value in values}
    return [by_value[value] for value in sorted(by_value)]
