"""Declarations of the options for a measured pair: types, units, defaults, help texts and conditions."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Protocol, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, PlainValidator, SkipValidation, ValidationError
from pydantic.fields import FieldInfo

from stiction._arguments import split_values
from stiction._checks import unwrap_scalar, validate_number, validate_whole_number
from stiction._errors import ArgumentError
from stiction._units import short_repr
from stiction.mechanics.half_space import TiltMode
from stiction.mechanics.law import JacksonGreen
from stiction.mechanics.model import CurvatureRequirement, DetectionMethod
from stiction.study.interfaces import InterfaceStrength
from stiction.study.measured_bodies import MACHINING_PROCESSES
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.measured.interpret import MissingPointTreatment, OutlierTreatment
from stiction.surfaces.pairing import SurrogateBodies
from stiction.surfaces.profile import LineOrientation, Profile
from stiction.surfaces.surface import Surface

# ---- Types of values -------------------------------------------------------------------------------------------------


class HeightData(Protocol):
    """Object with heights in its attribute `data`, from a library such as surfalize or xarray."""

    @property
    def data(self) -> object:
        """Heights as a NumPy array, or as an object that converts to such an array."""


class SurfaceTopographyObject(Protocol):
    """Topography object of the library SurfaceTopography."""

    def heights(self) -> object:
        """Return the heights as a NumPy array, or as an object that converts to such an array."""


def _parse_single_value(value: object) -> object:
    value = unwrap_scalar(value)
    if isinstance(value, (list, tuple, range, np.ndarray)):
        raise ValueError(f"must be one value, got {short_repr(value)}")
    if not isinstance(value, (str, int, float)):
        raise ValueError(f"must be a number or a string, got {short_repr(value)}")
    return value


def _parse_value_list(value: object) -> object:
    value = unwrap_scalar(value)
    items = value.tolist() if isinstance(value, np.ndarray) else value
    return (
        [_parse_single_value(item) for item in items]
        if isinstance(items, (list, tuple, range))
        else _parse_single_value(value)
    )


_WHOLE_NUMBER_PATTERN = re.compile(r"\s*-?[0-9]{1,80}\s*")


def _parse_whole_number(value: object, minimum: int) -> int:
    if isinstance(value, str) and _WHOLE_NUMBER_PATTERN.fullmatch(value):
        value = int(value)
    try:
        return validate_whole_number("", value, minimum=minimum)
    except ValueError as error:
        raise ValueError(str(error).strip()) from None


def _parse_positive_integer(value: object) -> int:
    return _parse_whole_number(value, 1)


def _parse_nonnegative_integer(value: object) -> int:
    return _parse_whole_number(value, 0)


def _parse_degrees(value: object) -> float:
    try:
        return validate_number("", float(value) if isinstance(value, str) else value)
    except ValueError:
        raise ValueError(f"must be a finite number of degrees, got {short_repr(unwrap_scalar(value))}") from None


def _parse_positions(value: object) -> object:
    """Convert slider positions, given as lengths or as (x, y) pairs of lengths, to a flat list of lengths."""
    value = unwrap_scalar(value)
    items = value.tolist() if isinstance(value, np.ndarray) else value
    if not isinstance(items, (list, tuple)):
        return _parse_value_list(items)
    rows = [item if isinstance(item, (list, tuple)) else (item,) for item in items]
    return [_parse_single_value(item) for row in rows for item in row]


def _parse_surrogates(value: object) -> object:
    value = unwrap_scalar(value)
    if isinstance(value, bool) or not isinstance(value, (str, int)):
        allowed = ", ".join(get_args(SurrogateBodies))
        raise ValueError(f"must be a number of pairs, or one of {allowed}, got {short_repr(value)}")
    return value


HeightInput: TypeAlias = str | Path | Profile | Surface | NDArray[np.generic] | HeightData | SurfaceTopographyObject
"""Measured profile or height map: a file, an array of heights, or an object of this package or another library."""
ScanInput: TypeAlias = HeightInput | JoinedSpectrum
BodyScans: TypeAlias = Annotated[ScanInput | Sequence[ScanInput], SkipValidation]
"""A single scan of a body, or scans at several places on the body."""
GapInput: TypeAlias = Annotated[HeightInput, SkipValidation]
InterfaceInput: TypeAlias = Annotated[str | Path | InterfaceStrength, SkipValidation]
QuantityInput: TypeAlias = Annotated[str | float, PlainValidator(_parse_single_value)]
"""Quantity as a number in the default unit of the option, or as text with a unit."""
QuantityInputs: TypeAlias = Annotated[
    str | float | Sequence[str | float] | NDArray[np.float64], PlainValidator(_parse_value_list)
]  # fmt: skip
"""One or several quantities; in a string, commas separate the quantities."""
Positions: TypeAlias = Annotated[
    str | float | Sequence[str | float | Sequence[str | float]] | NDArray[np.float64], PlainValidator(_parse_positions)
]  # fmt: skip
"""Positions of the slider: lengths for profiles, and (x, y) pairs or a flat list of x and y for maps."""
PositiveInteger: TypeAlias = Annotated[int, PlainValidator(_parse_positive_integer)]
Seed: TypeAlias = Annotated[int, PlainValidator(_parse_nonnegative_integer)]
Degrees: TypeAlias = Annotated[float, PlainValidator(_parse_degrees)]
SurrogateChoice: TypeAlias = Annotated[int | str, PlainValidator(_parse_surrogates)]

Mechanics = Literal["half-space", "asperities"]
CONTACT_MODEL_NAMES: tuple[Mechanics, ...] = get_args(Mechanics)
Lay = Literal["grooves", "isotropic"]
LawChoice = Literal["hertz-sphere", "hertz-cylinder", "jackson-green"]
LevellingForm = Literal["mean", "line", "plane", "quadratic", "none"]


# ---- Conditions of options -------------------------------------------------------------------------------------------


class PairProperties(Protocol):
    """Properties of a measured pair that decide which options apply."""

    @property
    def options(self) -> PairOptions:
        """Options that the user has given for the pair."""

    @property
    def are_maps(self) -> bool:
        """True if both bodies are height maps."""

    @property
    def are_profiles(self) -> bool:
        """True if both bodies are profiles."""

    @property
    def has_spectrum(self) -> bool:
        """True if at least one body is given as a spectrum joined from several scans."""

    @property
    def has_masked_points(self) -> bool:
        """True if at least one body has masked points (points that were not measured)."""

    @property
    def has_surrogates(self) -> bool:
        """True if the study generates surrogates: random surfaces with the measured spectra."""

    @property
    def scan_counts(self) -> tuple[int, int]:
        """Numbers of scans of the upper and of the lower body."""

    @property
    def press_mode(self) -> str:
        """Kind of bodies that are pressed: "areas" for maps, "lines" for profiles or lines of maps, or "surrogates"."""

    @property
    def contact_models(self) -> tuple[Mechanics, ...]:
        """Contact models to use: the model for the result and, if the user requests a check, the other model."""

    @property
    def contact_law(self) -> str:
        """Name of the contact law in the asperity model."""


@dataclass(frozen=True)
class OptionCondition:
    """Condition under which an option applies to a pair, and the error message if the condition does not hold."""

    is_met: Callable[[PairProperties], bool]
    # In the message, the name of another option is a placeholder in braces, such as {gap}.
    message: str


def select_body_value(name: str, values: Any, index: int) -> Any:
    """Return an option's value for one body: index 0 is the upper body, and index 1 the lower body.

    A single value applies to both bodies.
    """
    values = values if isinstance(values, list) else [values]
    if len(values) > 2:
        raise ArgumentError(
            f"{{{name}}} must be given once for both files, or once for each file, got {len(values)} values"
        )
    return values[index % len(values)] if values else None


def make_condition(message: str) -> Callable[[Callable[[PairProperties], bool]], OptionCondition]:
    """Return a decorator that turns a predicate of a pair into an `OptionCondition` with the given error message."""

    def attach_message(is_met: Callable[[PairProperties], bool]) -> OptionCondition:
        return OptionCondition(is_met, message)

    return attach_message


@make_condition("must be one map")
def is_gap_map(pair: PairProperties) -> bool:
    """Return whether the gap is given as a single height map."""
    return pair.are_maps and pair.scan_counts == (1, 1)


@make_condition("must not be combined with {gap}, because the relative position of the two faces is fixed")
def has_two_bodies(pair: PairProperties) -> bool:
    """Return whether the user gives two bodies instead of the gap between them."""
    return pair.options.gap is None


@make_condition("is for two profiles; a map contains its lay")
def has_two_profiles(pair: PairProperties) -> bool:
    """Return whether both bodies are profiles."""
    return pair.are_profiles


@make_condition("is for two profiles that are pressed as lines; other bodies have a nominal area")
def presses_profiles_as_lines(pair: PairProperties) -> bool:
    """Return whether both bodies are profiles that are used directly, instead of surrogate maps of the profiles."""
    return pair.are_profiles and pair.press_mode == "lines"


@make_condition("generates surfaces from a spectrum and needs scans without masked points")
def has_complete_scans_for_surrogates(pair: PairProperties) -> bool:
    """Return False if surrogates are requested, but a scan has masked points; return True otherwise."""
    return not (pair.has_masked_points and pair.has_surrogates)


@make_condition("uses the asperity model and needs scans without masked points")
def has_complete_scans_for_asperities(pair: PairProperties) -> bool:
    """Return False if the asperity model is requested, but a scan has masked points; return True otherwise."""
    return not pair.has_masked_points or "asperities" not in pair.contact_models


@make_condition("needs scans without masked points; {missing} interpolate fills them, and {crop} excludes them")
def has_complete_scans(pair: PairProperties) -> bool:
    """Return whether the scans have no masked points."""
    return not pair.has_masked_points


@make_condition("must not be combined with a spectrum, because its surfaces are generated")
def has_no_spectrum(pair: PairProperties) -> bool:
    """Return whether neither body is given as a spectrum joined from several scans."""
    return not pair.has_spectrum


@make_condition("is for surfaces and surrogates; two profiles are one pair")
def has_several_line_pairs(pair: PairProperties) -> bool:
    """Return whether the bodies contain several pairs of lines: maps do, and so do surrogates of profiles."""
    return not pair.are_profiles or (pair.press_mode == "lines" and pair.has_surrogates)


@make_condition("is for lines; for maps give {lines} as well")
def presses_lines(pair: PairProperties) -> bool:
    """Return whether the contact is computed for profiles, or for single lines of maps, instead of whole maps."""
    return pair.press_mode == "lines"


@make_condition("is for lines of surfaces")
def presses_lines_of_maps(pair: PairProperties) -> bool:
    """Return whether the contact is computed for single lines of the height maps, instead of whole maps."""
    return pair.press_mode == "lines" and not pair.are_profiles


@make_condition("is for the areas of two maps, without {lines}")
def presses_areas(pair: PairProperties) -> bool:
    """Return whether the contact is computed for the whole measured maps, not for surrogates or single lines."""
    return pair.press_mode == "areas"


@make_condition("is for areas; lines are always moved in both directions")
def presses_maps_or_surrogates(pair: PairProperties) -> bool:
    """Return whether the contact is computed for maps or surrogates, and not for profiles or single lines of maps."""
    return pair.press_mode != "lines"


@make_condition("is for lines, or for the areas of two maps")
def presses_scans(pair: PairProperties) -> bool:
    """Return whether the contact is computed for the scans themselves, instead of surrogates of the scans."""
    return pair.press_mode != "surrogates"


@make_condition("must not be given with {positions}")
def uses_default_positions(pair: PairProperties) -> bool:
    """Return whether the program chooses the relative positions of the bodies, because the user gives none."""
    return pair.options.positions is None


@make_condition("is for {surrogates}")
def presses_surrogates(pair: PairProperties) -> bool:
    """Return whether the contact is computed for surrogates: random surfaces with the spectra of the scans."""
    return pair.has_surrogates


@make_condition("must not be combined with {check}, which uses both contact models")
def uses_one_contact_model(pair: PairProperties) -> bool:
    """Return whether only one contact model is used: no option requests a check of the result by the other model."""
    return not pair.options.check


@make_condition("is for {mechanics} half-space")
def uses_half_space_model(pair: PairProperties) -> bool:
    """Return whether contacts are computed with the half-space model, for the result or for a check of the result."""
    return "half-space" in pair.contact_models


@make_condition("is for {mechanics} half-space")
def has_half_space_result(pair: PairProperties) -> bool:
    """Return whether the result is computed with the half-space model."""
    return pair.contact_models[0] == "half-space"


@make_condition("is for {mechanics} half-space alone")
def uses_only_half_space_model(pair: PairProperties) -> bool:
    """Return whether the half-space model is used, and no check of the result by the asperity model is requested."""
    return pair.contact_models == ("half-space",)


@make_condition("is for {mechanics} asperities")
def uses_asperity_model(pair: PairProperties) -> bool:
    """Return whether contacts are computed with the asperity model, for the result or for a check of the result."""
    return "asperities" in pair.contact_models


@make_condition("must not be combined with {lay} grooves, which needs the law of cylinders")
def has_contact_law_for_lay(pair: PairProperties) -> bool:
    """Return False if the lay is "grooves", but the contact law is not "hertz-cylinder"; return True otherwise."""
    return pair.options.lay != "grooves" or pair.contact_law == "hertz-cylinder"


@make_condition("is for {law} jackson-green")
def has_contact_law_with_yield(pair: PairProperties) -> bool:
    """Return whether the contact law is the Jackson-Green law, which needs a yield strength."""
    return pair.contact_law == JacksonGreen.name


@make_condition("must not be combined with {hardness}, which determines it")
def has_free_yield_strength(pair: PairProperties) -> bool:
    """Return whether a yield strength is allowed: no hardness is given, or the half-space model uses the hardness."""
    return pair.options.hardness is None or "half-space" in pair.contact_models


@make_condition("needs {mechanics} half-space, or {law} jackson-green with the asperity model")
def has_contact_model_with_hardness(pair: PairProperties) -> bool:
    """Return whether a contact model of the pair can use a hardness (half-space model or Jackson-Green law)."""
    return "half-space" in pair.contact_models or pair.contact_law == JacksonGreen.name


@make_condition("needs {creep}, the exponent of indentation creep")
def has_creep_exponent(pair: PairProperties) -> bool:
    """Return whether a creep exponent is given."""
    return pair.options.creep is not None


@make_condition("is for {wait}")
def has_dwell_times(pair: PairProperties) -> bool:
    """Return whether dwell times are given."""
    return pair.options.wait is not None


@make_condition("is for {work_of_adhesion}")
def has_work_of_adhesion(pair: PairProperties) -> bool:
    """Return whether a work of adhesion is given."""
    return pair.options.work_of_adhesion is not None


@make_condition("must not be combined with {interface}, which contains mu0 and tau0")
def has_no_interface(pair: PairProperties) -> bool:
    """Return whether the user names no interface; mu0 and tau0 may only be set without an interface."""
    return pair.options.interface is None


@make_condition("is for {young} and {law} jackson-green")
def needs_poisson_ratio(pair: PairProperties) -> bool:
    """Return whether Poisson's ratio is needed: Young's modulus is given, or the contact law is Jackson-Green."""
    return pair.options.young is not None or pair.contact_law == JacksonGreen.name


# ---- Declaration of an option ----------------------------------------------------------------------------------------

OptionKind = Literal["length", "pressure", "force", "time", "work of adhesion"]
DEFAULT_UNITS: dict[OptionKind, str] = {
    "length": "µm", "pressure": "GPa", "force": "mN", "time": "s", "work of adhesion": "kJ/m²",
}  # fmt: skip
"""Default unit of a number without a unit, by kind of quantity."""


@dataclass(frozen=True, kw_only=True)
class FormField:
    """Input field of an option in the app's form: its label, its example, its choices and the group it belongs to."""

    label: str
    place: Literal["scan", "body", "load", "more"] = "more"
    example: str = ""
    default_label: str = ""
    choices: tuple[tuple[str, str], ...] = ()
    # Width of the input field in characters; 0 for the default width.
    size: int = 0
    unit: str = ""
    keyboard: Literal["", "numeric", "decimal"] = ""


@dataclass(frozen=True)
class PairOption:
    """Declaration of one option of a measured pair, for the command line, Python, study files and the app."""

    value: str  # empty for a switch
    # In the help text, the name of another option is a placeholder in braces, such as {gap}.
    help: str
    kind: OptionKind | None = None
    default_text: str = ""
    # Names of an option on the command line and in Python, if they differ from the field name.
    flag: str = ""
    argument: str = ""
    key: str = ""
    field: FormField | None = None
    applies: tuple[OptionCondition, ...] = ()
    is_common: bool = False
    is_repeatable: bool = False
    # True if an option accepts several inputs for one file, separated by commas, as in "mm,um".
    is_list: bool = False
    is_in_python: bool = True


class OptionGroup(BaseModel):
    """Base class for a group of related options of a measured pair.

    The value None of an option stands for its default.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", strict=True, arbitrary_types_allowed=True, defer_build=True)

    title: ClassVar[str]


class SurfaceOptions(OptionGroup):
    """Options that select the two bodies, and specify the preparation of their scans."""

    title: ClassVar[str] = "Surfaces"

    upper: Annotated[BodyScans | None, PairOption(
        "UPPER", "The slider: a measured profile or surface. Several scans of one part are given as a list, "
        "a directory, or names separated by commas.", flag="UPPER", argument="first",
    )] = None  # fmt: skip
    lower: Annotated[BodyScans | None, PairOption(
        "LOWER", "The counterface; both may be the same file.", flag="LOWER", argument="second",
    )] = None  # fmt: skip
    gap: Annotated[GapInput | None, PairOption(
        "FILE", "A map of the gap between two faces, for example of a fracture, instead of {upper} and {lower}.",
        applies=(is_gap_map,),
    )] = None  # fmt: skip
    lay: Annotated[Lay | None, PairOption(
        "grooves|isotropic", "Lay of two profiles: measured across grooves, or on isotropic surfaces, which are then "
        "pressed as areas.", default_text="pressed as lines",
        applies=(has_two_profiles, has_complete_scans_for_surrogates),
        field=FormField(
            label="lay of profiles", default_label="not given",
            choices=(("grooves", "across grooves"), ("isotropic", "none, isotropic")),
        ),
    )] = None  # fmt: skip
    lines: Annotated[PositiveInteger | None, PairOption(
        "N", "Press this many pairs of lines of two maps instead of their areas; for surrogates of profiles, the "
        "number of surrogates.", default_text="128 of surrogates, and of a map and a profile",
        applies=(has_no_spectrum, has_several_line_pairs, has_two_bodies),
    )] = None  # fmt: skip
    along: Annotated[LineOrientation | None, PairOption(
        "x|y", "Direction of the lines of maps.", default_text="x", key="surfaces.along",
        applies=(presses_lines_of_maps,),
    )] = None  # fmt: skip
    level: Annotated[LevellingForm | None, PairOption(
        "TREND", "Trend to subtract from each line (mean, line, quadratic or none) or map (mean, plane or "
        "quadratic).", default_text="line for profiles, plane for maps", key="surfaces.level",
        field=FormField(
            label="level", default_label="plane or line", choices=(("quadratic", "quadratic"), ("mean", "mean")),
        ),
    )] = None  # fmt: skip
    cutoff: Annotated[QuantityInputs | None, PairOption(
        "LENGTHS", 'Cutoff wavelength of a Gaussian low-pass filter, "0.1 um". Several cutoffs give several results; '
        '"none" attributes all wavelengths to the surfaces.', kind="length",
        default_text="unfiltered; also filtered if some wavelengths may not belong to the surface",
        key="surfaces.cut_off", field=FormField(label="cutoff wavelength", example="0.5 um, or none"),
    )] = None  # fmt: skip
    rotate: Annotated[Degrees | None, PairOption(
        "DEGREES", "Rotate the upper map in its plane.", default_text="0", key="surfaces.rotate",
        applies=(has_two_bodies, presses_areas),
        field=FormField(label="turn upper, °", keyboard="decimal", example="0"),
    )] = None  # fmt: skip


class FileReadingOptions(OptionGroup):
    """Options for reading scan files.

    An option has one value for both files, or one value per file.
    """

    title: ClassVar[str] = "Reading files"

    unit: Annotated[QuantityInputs | None, PairOption(
        "UNIT", 'Unit of the lengths in the file, "um", or of positions and heights, "mm,um". Required if the file '
        "has no unit.", is_repeatable=True, is_common=True, is_list=True,
        field=FormField(
            label="unit", place="scan", default_label="its own", choices=(
                ("nm", "nm"), ("um", "um"), ("mm", "mm"), ("m", "m"), ("mm,um", "mm, heights µm"),
                ("mm,nm", "mm, heights nm"), ("um,nm", "µm, heights nm"),
            ),
        ),
    )] = None  # fmt: skip
    spacing: Annotated[QuantityInputs | None, PairOption(
        "LENGTH", 'Distance between points, "0.5 um", or between rows and columns, "2 um,0.5 um". Required if the '
        "file has no spacing.", kind="length", is_repeatable=True, is_common=True, is_list=True,
        field=FormField(label="spacing", place="scan", example="0.5 um", size=7),
    )] = None  # fmt: skip
    missing: Annotated[MissingPointTreatment | None, PairOption(
        "error|mask|interpolate", "Points without a height: reject the file, press only the measured points, or "
        "interpolate.",
        default_text="error", is_common=True,
        field=FormField(
            label="missing points", place="scan", default_label="are an error",
            choices=(("mask", "leave them out"), ("interpolate", "interpolate")),
        ),
    )] = None  # fmt: skip
    missing_value: Annotated[QuantityInputs | None, PairOption(
        "NUMBERS|WORDS", 'Numbers or words that mark points without a height, "-9999".', is_repeatable=True,
        is_list=True,
        field=FormField(label="missing value", place="scan", example="-9999", size=9),
    )] = None  # fmt: skip
    outliers: Annotated[OutlierTreatment | None, PairOption(
        "keep|mask", "Treat up to 4 adjacent points beyond 6 robust deviations of their neighbours as missing.",
        default_text="keep",
        field=FormField(
            label="outliers", place="scan", default_label="keep them", choices=(("mask", "leave them out"),)
        ),
    )] = None  # fmt: skip
    crop: Annotated[QuantityInputs | None, PairOption(
        "X0,X1[,Y0,Y1]", 'Region of the file to read: "10 um,60 um"; for a map, first along x, then along y.',
        kind="length", is_repeatable=True,
        field=FormField(label="crop", place="scan", example="10 um,60 um", size=11),
    )] = None  # fmt: skip
    channel: Annotated[QuantityInputs | None, PairOption(
        "NAME|NUMBER", "Channel or sheet to read, by its name or number from 0.", default_text="the first of heights",
        is_repeatable=True,
        field=FormField(label="channel", place="scan", example="name or number", size=9),
    )] = None  # fmt: skip
    columns: Annotated[QuantityInputs | None, PairOption(
        "Z|X,Z|X,Y,Z", "Columns of a table, names or numbers from 0: of heights, or of positions and heights.",
        is_repeatable=True, is_list=True,
        field=FormField(label="columns", place="scan", example="0,1 or names", size=9),
    )] = None  # fmt: skip
    accept: Annotated[QuantityInputs | None, PairOption(
        "NAMES", 'Names of caveats about a file that you have checked and accept, "whole-numbers".', is_repeatable=True,
        is_list=True,
        field=FormField(label="settled caveats", place="scan", example="whole-numbers", size=9),
    )] = None  # fmt: skip
    texture: Annotated[QuantityInputs | None, PairOption(
        "PROCESS", "Machining process (turned, milled, ground, ...): lines and humps of the spectrum are then "
        "attributed to the surface.", is_repeatable=True,
        field=FormField(
            label="texture", place="scan", default_label="not given",
            choices=tuple((process, process) for process in MACHINING_PROCESSES),
        ),
    )] = None  # fmt: skip
    tip: Annotated[QuantityInputs | None, PairOption(
        "RADIUS", 'Radius of the stylus or probe, "10 nm", which limits the curvature that it can follow.',
        kind="length", is_repeatable=True, field=FormField(label="tip radius", example="10 nm"),
    )] = None  # fmt: skip


class MaterialOptions(OptionGroup):
    """Options for the materials of the bodies: elastic constants, hardness, yielding, dwell times and adhesion.

    Either effective_modulus, or young with poisson, or the names of materials are required.
    """

    title: ClassVar[str] = "Materials"

    upper_material: Annotated[str | None, PairOption(
        "MATERIAL", "Material of the slider by name, as in steel; or give {young} and {poisson}.", flag="--upper",
        argument="upper", is_common=True, key="contact.materials", field=FormField(label="upper", place="body"),
    )] = None  # fmt: skip
    lower_material: Annotated[str | None, PairOption(
        "MATERIAL", "Material of the counterface; the same as {upper_material} by default.", flag="--lower",
        argument="lower", is_common=True, field=FormField(label="lower", place="body"),
    )] = None  # fmt: skip
    effective_modulus: Annotated[QuantityInput | None, PairOption(
        "PRESSURE", 'Effective modulus E*, "10 GPa", instead of materials.', kind="pressure",
        key="contact.effective_modulus",
    )] = None  # fmt: skip
    young: Annotated[QuantityInputs | None, PairOption(
        "PRESSURES", 'Young\'s modulus of both bodies, or of the slider and the counterface, "200 GPa,70 GPa".',
        kind="pressure", is_common=True, field=FormField(label="E", place="body", unit="GPa"),
    )] = None  # fmt: skip
    poisson: Annotated[QuantityInputs | None, PairOption(
        "NUMBERS", 'Poisson\'s ratios, "0.3" or "0.3,0.33".', is_common=True, key="contact.poisson",
        applies=(needs_poisson_ratio,), field=FormField(label="ν", place="body"),
    )] = None  # fmt: skip
    hardness: Annotated[QuantityInput | None, PairOption(
        "PRESSURE", 'Hardness of the softer body, the largest contact pressure: "2 GPa", "150 HV" or "150 HV ± 10 %".',
        kind="pressure", default_text="the material's hardness", is_common=True, key="contact.hardness",
        applies=(has_contact_model_with_hardness,), field=FormField(label="hardness, GPa", place="body", unit="GPa"),
    )] = None  # fmt: skip
    yield_strength: Annotated[QuantityInput | None, PairOption(
        "PRESSURE", "Yield strength of the softer body, for {law} jackson-green.", kind="pressure",
        default_text="the hardness divided by 2.84",
        applies=(uses_asperity_model, has_contact_law_with_yield, has_free_yield_strength),
    )] = None  # fmt: skip
    junction_growth: Annotated[QuantityInput | None, PairOption(
        "LAW", 'Growth of plastic contacts under shear: "slip-line", α of p² + α τ² = H² as in "9" or "0..27", or 0.',
        default_text="slip-line, or 0 if the softer body is a named rock, glass, ceramic, semiconductor or coating",
        key="contact.junction_growth", applies=(uses_half_space_model,),
        field=FormField(label="junction growth", example="slip-line, 9, or 0..27"),
    )] = None  # fmt: skip
    yield_exponent: Annotated[QuantityInput | None, PairOption(
        "NUMBER", 'Exponent of the area of yielding contacts, "1.25" or "uniform 0.7 .. 1.6".',
        default_text='"uniform 0.7 .. 1.6"', key="contact.yield_exponent", applies=(uses_half_space_model,),
    )] = None  # fmt: skip
    indent: Annotated[QuantityInput | None, PairOption(
        "LENGTH", 'Depth of the indentation that measured the hardness of a metal, "5 um". Small contacts are harder.',
        kind="length", key="contact.indent", applies=(uses_half_space_model,),
        field=FormField(label="depth of the indentation", example="5 um"),
    )] = None  # fmt: skip
    area_loss: Annotated[QuantityInput | None, PairOption(
        "FRACTION", 'Fraction of the true area that soft elastic bodies lose under shear, "0.1" or "0..0.3".',
        default_text='"0..0.3" if E* is below 100 MPa', key="contact.area_loss", applies=(uses_half_space_model,),
        field=FormField(label="area loss under shear", example="0..0.3"),
    )] = None  # fmt: skip
    wait: Annotated[QuantityInputs | None, PairOption(
        "TIMES", 'Dwell times under load before sliding, "1 min,1 h". The given hardness applies after 1 s.',
        kind="time",
        key="friction.wait", applies=(has_creep_exponent, has_half_space_result),
        field=FormField(label="dwell times", example="1 min,1 h"),
    )] = None  # fmt: skip
    creep: Annotated[QuantityInput | None, PairOption(
        "NUMBER", 'Exponent m of indentation creep, "0.03" or "0.02..0.05": the hardness falls as (t/1 s)^-m.',
        key="friction.creep", applies=(has_dwell_times,), field=FormField(label="creep exponent", example="0.02..0.05"),
    )] = None  # fmt: skip
    work_of_adhesion: Annotated[QuantityInput | None, PairOption(
        "ENERGY", 'Work of adhesion, "50 mJ/m^2"; "0 mJ/m^2" declares that there is none.', kind="work of adhesion",
        default_text="taken as 0", flag="--adhesion", key="contact.work_of_adhesion",
        applies=(has_complete_scans, uses_only_half_space_model),
        field=FormField(label="work of adhesion, mJ/m²", example="0, or 50", unit="mJ/m^2"),
    )] = None  # fmt: skip
    adhesion_range: Annotated[QuantityInput | None, PairOption(
        "LENGTH", "Gap over which the attraction decays to 1/e.", kind="length", default_text="0.5 nm",
        key="contact.adhesion_range", applies=(uses_only_half_space_model, has_work_of_adhesion),
    )] = None  # fmt: skip


class FrictionOptions(OptionGroup):
    """Options for the load, for mu0 and tau0 (or an interface), and for the direction of motion."""

    title: ClassVar[str] = "Load and friction"

    load: Annotated[QuantityInputs, PairOption(
        "PRESSURE", 'Normal load over the nominal area, "10 MPa", or a force, "0.1 mN".', kind="force",
        key="friction.load", is_common=True, is_repeatable=True,
        field=FormField(label="load", place="load"),
    )]  # fmt: skip
    width: Annotated[QuantityInput | None, PairOption(
        "LENGTH", "Width across two profiles on which a force acts.", kind="length", default_text="1 um",
        applies=(presses_profiles_as_lines,), field=FormField(label="width of profiles", example="1 mm"),
    )] = None  # fmt: skip
    mu0: Annotated[QuantityInputs | None, PairOption(
        "NUMBERS", 'Molecular friction coefficients, "0.3,0.4", or one with its standard deviation, "0.30±0.02", or '
        'its 95 % range, "0.2..0.4".', key="friction.mu0", is_common=True,
        applies=(has_no_interface,), field=FormField(label="μ0", place="load"),
    )] = None  # fmt: skip
    tau0: Annotated[QuantityInputs | None, PairOption(
        "PRESSURES", 'Adhesive shear strengths, "0 MPa,50 MPa", or one with its uncertainty, "30..80 MPa".',
        kind="pressure", default_text="0 MPa", key="friction.tau0", is_common=True, applies=(has_no_interface,),
        field=FormField(label="τ0, MPa", place="load", unit="MPa"),
    )] = None  # fmt: skip
    interface: Annotated[InterfaceInput | None, PairOption(
        "NAME|FILE", "Joint values of {mu0} and {tau0}: a file from stiction calibrate, or a name listed by stiction "
        "interfaces.",
        key="friction.interface", is_common=True, field=FormField(label="interface", place="load"),
    )] = None  # fmt: skip
    direction: Annotated[QuantityInputs | None, PairOption(
        "DEGREES", 'Directions of motion of the upper body, from +x towards +y, "0,90".',
        default_text="every 30 degrees",
        key="contact.direction", applies=(presses_maps_or_surrogates,),
        field=FormField(label="directions, °", example="0,90"),
    )] = None  # fmt: skip


class ContactOptions(OptionGroup):
    """Options for the contact model and its parameters."""

    title: ClassVar[str] = "Contact model"

    check: Annotated[bool, PairOption(
        "", "Also press with the other contact model, with results in DIR/NAME.", is_in_python=False,
        applies=(has_complete_scans_for_asperities,),
    )] = False  # fmt: skip
    mechanics: Annotated[Mechanics | None, PairOption(
        "half-space|asperities", "The elastic half-space (half-plane for lines), or isolated asperities (fast).",
        default_text="asperities for lines, except two profiles whose softer body is a material with a hardness",
        key="contact.mechanics",
        applies=(has_complete_scans_for_asperities, uses_one_contact_model),
        field=FormField(
            label="contact model", default_label="the usual one",
            choices=(("half-space", "half-space (exact)"), ("asperities", "asperities (fast)")),
        ),
    )] = None  # fmt: skip
    tilt: Annotated[TiltMode | None, PairOption(
        "fixed|free", "Orientation of the slider: fixed, or tilted until the load is centred, as on a ball joint.",
        default_text="fixed", key="contact.tilt", applies=(uses_half_space_model,),
        field=FormField(
            label="tilt of the slider", default_label="fixed", choices=(("free", "free, as on a ball joint"),),
        ),
    )] = None  # fmt: skip
    law: Annotated[LawChoice | None, PairOption(
        "hertz-sphere|hertz-cylinder|jackson-green", "Contact law of asperities.", default_text="hertz-sphere",
        key="contact.law", applies=(uses_asperity_model, has_contact_law_for_lay),
    )] = None  # fmt: skip
    detection: Annotated[DetectionMethod | None, PairOption(
        "gap-minimum|cell", "Criterion that detects contacts of asperities.", default_text="gap-minimum",
        key="contact.detection",
        applies=(uses_asperity_model,),
    )] = None  # fmt: skip
    curvature: Annotated[CurvatureRequirement | None, PairOption(
        "convex|signed", "Contact points to count: convex only, or concave ones too.",
        default_text="convex for lines, signed for areas", key="contact.curvature", applies=(uses_asperity_model,),
    )] = None  # fmt: skip


class EnsembleOptions(OptionGroup):
    """Options for the relative positions of the bodies, and for surrogates."""

    title: ClassVar[str] = "Ensemble"

    shifts: Annotated[PositiveInteger | None, PairOption(
        "N", "Relative positions of two maps.", default_text="16", key="ensemble.repetitions",
        applies=(has_two_bodies, presses_areas, uses_default_positions),
        field=FormField(label="positions", keyboard="numeric", example="16"),
    )] = None  # fmt: skip
    offsets: Annotated[PositiveInteger | None, PairOption(
        "N", "Positions along the lower profile.", default_text="64, or 1 for several lines", key="surfaces.offsets",
        applies=(presses_lines, uses_default_positions),
    )] = None  # fmt: skip
    travel: Annotated[QuantityInput | None, PairOption(
        "LENGTH", "The largest offset.", kind="length", default_text="half the length", key="surfaces.travel",
        applies=(presses_lines, uses_default_positions),
    )] = None  # fmt: skip
    positions: Annotated[Positions | None, PairOption(
        "LENGTHS", 'Positions of the slider on the counterface, "0 um,5 um"; for maps, x and y of each position.',
        kind="length",
        default_text="spread evenly", key="surfaces.positions", applies=(has_two_bodies, presses_scans),
    )] = None  # fmt: skip
    surrogates: Annotated[SurrogateChoice | None, PairOption(
        "N|none|upper|lower|both", "For areas: number of additional pairs of random surfaces with equal spectra. For "
        "lines: body to replace by random surfaces.", default_text="none", key="surfaces.replace",
        applies=(has_complete_scans_for_surrogates, has_two_bodies),
    )] = None  # fmt: skip
    seed: Annotated[Seed | None, PairOption(
        "N", "Seed of the random phases of surrogates.", default_text="2016", key="ensemble.seed",
        applies=(presses_surrogates,),
    )] = None  # fmt: skip


class ExtraComputationOptions(OptionGroup):
    """Options that request further computations, such as the onset of sliding."""

    title: ClassVar[str] = "Computing"

    onset: Annotated[Seed | None, PairOption(
        "N", "Number of positions whose onset of sliding is computed; 0 for none.",
        default_text="16, or 4 for height maps with the half-space model",
    )] = None  # fmt: skip


class PairOptions(
    SurfaceOptions,
    FileReadingOptions,
    MaterialOptions,
    FrictionOptions,
    ContactOptions,
    EnsembleOptions,
    ExtraComputationOptions,
):
    """All options for a measured pair, with their values."""

    title: ClassVar[str] = "Options of a pair"

    def option_value(self, name: str) -> object:
        """Return the value of the option with a given field name.

        Returns None if the user has not given the option.
        """
        value: object = getattr(self, name)
        return None if value is False else value


OPTION_GROUPS: tuple[type[OptionGroup], ...] = (
    FrictionOptions, MaterialOptions, ContactOptions, SurfaceOptions, EnsembleOptions,
    FileReadingOptions, ExtraComputationOptions,
)  # fmt: skip
"""Groups of options in the order in which the help lists them."""


def _find_option_declaration(field: FieldInfo) -> PairOption:
    return next(item for item in field.metadata if isinstance(item, PairOption))


PAIR_OPTIONS: dict[str, PairOption] = {
    name: _find_option_declaration(field) for group in OPTION_GROUPS for name, field in group.model_fields.items()
}  # fmt: skip
"""Declarations of all options for a measured pair, by field name."""

READING_OPTION_NAMES: tuple[str, ...] = tuple(
    name for name in FileReadingOptions.model_fields if name not in ("texture", "tip")
)
"""Names of the options that are arguments of `read_measurement`."""


def split_option_text(name: str, text: str) -> str | tuple[str, ...]:
    """Split the text of an option at commas if the option accepts a list of values."""
    return tuple(split_values(text)) if PAIR_OPTIONS[name].is_list and "," in text else text


OPTION_CHECK_ORDER: tuple[str, ...] = tuple(
    name
    for group in (SurfaceOptions, ContactOptions, EnsembleOptions, FrictionOptions, MaterialOptions)
    for name in group.model_fields
)
"""Names of the options in the order in which their conditions are checked."""


def list_option_choices(name: str) -> tuple[str, ...]:
    """Return the words that are the only valid values of an option.

    The tuple is empty if the option also accepts other values.
    """
    annotation = PairOptions.model_fields[name].annotation
    literal_type = next((argument for argument in get_args(annotation) if get_args(argument)), annotation)
    return tuple(argument for argument in get_args(literal_type) if isinstance(argument, str))


# ---- Names of options on the command line and in Python --------------------------------------------------------------


_OPTION_ALIASES = {"wavelength": "cutoff"}
"""Names of `pair` options, by the name of the corresponding argument in functions about surfaces."""


def format_command_line_name(name: str) -> str:
    """Return the name of an option on the command line, such as "--hardness"."""
    name = _OPTION_ALIASES.get(name, name)
    option = PAIR_OPTIONS.get(name)
    return option.flag if option and option.flag else f"--{name.replace('_', '-')}"


def format_python_name(name: str) -> str:
    """Return the name of an option in Python, such as "hardness"."""
    name = _OPTION_ALIASES.get(name, name)
    option = PAIR_OPTIONS.get(name)
    return option.argument if option and option.argument else name


@contextmanager
def convert_validation_errors() -> Iterator[None]:
    """Convert a pydantic validation error about options to an `ArgumentError` about the first invalid option."""
    try:
        yield
    except ValidationError as error:
        first_error = error.errors(include_url=False)[0]
        name, value = str(first_error["loc"][0]) if first_error["loc"] else "", first_error["input"]
        match first_error["type"]:
            case "literal_error":
                choices = list_option_choices(name)
                suggestions = difflib.get_close_matches(str(value), choices, n=1)
                hint = f"; did you mean {suggestions[0]}?" if suggestions else ""
                reason = f"must be {' or '.join(choices)}, got {short_repr(value)}{hint}"
            case "string_type" | "string_unicode":
                reason = f"must be a string, got {short_repr(value)}"
            case "bool_type":
                reason = f"must be True or False, got {short_repr(value)}"
            case "missing":
                reason = "must be given"
            case "extra_forbidden":
                suggestions = difflib.get_close_matches(name, PairOptions.model_fields, n=1)
                reason = f"is no option of a pair{f'; is it {suggestions[0]}?' if suggestions else ''}"
            case _:
                reason = first_error["msg"].removeprefix("Value error, ")
        raise ArgumentError.for_argument(name, reason) from None


def validate_option_values(values: dict[str, object]) -> PairOptions:
    """Validate option values, keyed by field name of `PairOptions`, and return them as `PairOptions`.

    Raises an `ArgumentError` if a value is invalid.
    """
    with convert_validation_errors():
        return PairOptions.model_validate(values)
