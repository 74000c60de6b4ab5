"""Descriptions of computations (studies); each study is read from a TOML file, or is built in."""

from __future__ import annotations

import json
import math
import zlib
from collections.abc import Mapping
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, get_args

from pydantic import (
    AfterValidator,
    Field,
    SerializerFunctionWrapHandler,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_serializer,
    model_validator,
)
from pydantic_core import PydanticCustomError

from stiction._files import UnreadableFileError, describe_os_error, read_file_bytes
from stiction._text import MAX_PATH_LENGTH, printable_path, printable_text
from stiction._units import Quantity, exact_quantity_text, quantity, short_repr
from stiction.mechanics.quantities import (
    ADHESION_QUANTITIES,
    AREAL_SUM_QUANTITIES,
    HALF_SPACE_SUM_QUANTITIES,
    ONSET_QUANTITIES,
    SUM_QUANTITIES,
    YIELDING_QUANTITIES,
)
from stiction.study.contact_settings import (
    DERIVED_ELASTICITY_KEYS,
    MAX_AREAL_LOAD_RATIO,
    ContactSettings,
    ContactSettingsForMeasuredMaps,
    HalfSpaceSettings,
    choose_load_steps,
    parse_contact_settings,
    select_contact_settings_class,
)
from stiction.study.generated_surfaces import (
    GeneratedProfileSettings,
    GeneratedSurfaceSettings,
    SelfAffineSettings,
    WeierstrassMandelbrotSettings,
)
from stiction.study.input_distributions import (
    CreepExponentEntry,
    FrictionCoefficientEntries,
    InputValue,
    ShearStrengthEntries,
)
from stiction.study.interfaces import InterfaceSettings
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.study.measured_surfaces import MeasuredSurfaceSettings
from stiction.study.member_names import MemberNames
from stiction.study.old_formats import convert_old_study
from stiction.study.values import (
    FrictionCoefficients,
    LoadsOfInterest,
    SettingsSection,
    SettingsSectionVariant,
    ShearStrengths,
    StudyError,
    Times,
    check_keys,
    format_quantities,
    format_toml_sections,
    format_toml_value,
    list_to_tuple_validator,
    make_key_error,
    parse_toml,
    select_key_value,
    validate_section,
)

if TYPE_CHECKING:
    import xarray

MAX_STUDY_BYTES = 1_000_000  # bytes
MAX_PARAMETER_COMBINATIONS = 1000

_DISCRIMINATOR_KEYS = (("surfaces", "kind"), ("surfaces", "generator"), ("surfaces", "press"), ("contact", "mechanics"))
"""Keys whose value selects the class of a section, as pairs of section name and key."""

_KEYS_WRITTEN_FIRST = (
    "kind", "generator", "press", "upper", "lower", "mechanics", "effective_modulus", "materials", "young", "poisson",
    "law", "detection", "curvature", "boundary", "hardness", "compliance_share",
)  # fmt: skip
"""Keys that come first in their sections of a written study file."""

_STUDY_LIBRARY_DIRECTORY = resources.files("stiction.study") / "library"
DEFAULT_SEED = 2016
# Difference between two studies: dotted key, value in the first study and value in the second study, as TOML text.
StudyDifference = tuple[str, str, str]
MAX_LISTED_DIFFERENCES = 4

SurfaceSettings = GeneratedSurfaceSettings | MeasuredSurfaceSettings
SURFACE_SETTINGS_CLASSES: tuple[type[SurfaceSettings], ...] = get_args(SurfaceSettings)


def _map_key_to_classes(key: str, *cases: type[SurfaceSettings]) -> tuple[str, dict[str, type[SurfaceSettings]]]:
    return key, {case.model_fields[key].default: case for case in cases}


_SURFACE_CLASSES_BY_KIND = {
    "profile": _map_key_to_classes("kind", GeneratedProfileSettings),
    "surface": _map_key_to_classes("generator", WeierstrassMandelbrotSettings, SelfAffineSettings),
    "measured": _map_key_to_classes("press", *get_args(MeasuredSurfaceSettings)),
}
"""Classes of the section `[surfaces]` by `kind`, with the key whose value selects one of several classes.

The first class is the default.
"""


def select_surface_settings_class(section: Mapping[str, Any]) -> type[SurfaceSettings]:
    """Return the class for a section `[surfaces]`, selected by its keys `kind`, `generator` and `press`."""
    key, settings_classes = _SURFACE_CLASSES_BY_KIND[select_key_value("kind", section, _SURFACE_CLASSES_BY_KIND)]
    return settings_classes[select_key_value(key, section, settings_classes)]


ZERO_SHEAR_STRENGTH = quantity("0 MPa", "pressure")
PAPER_SHEAR_STRENGTHS = tuple(quantity(f"{tau0} MPa", "pressure") for tau0 in ("0", "0.5", "10", "100", "200"))
MU0_DESCRIPTION = "Molecular friction coefficients."
TAU0_DESCRIPTION = "Adhesive shear strengths."
LOADS_DESCRIPTION = "Normal loads of the results; `contact.load` contains these and the other loads of the curve."


class GeneratedSurfaceFrictionSettings(SettingsSectionVariant):
    """Base class of the section `[friction]` for generated surfaces, with the mu0 and tau0 used in figures."""

    place: ClassVar[str] = "generated surfaces"
    wait: ClassVar[tuple[Quantity, ...]] = ()
    creep: ClassVar[None] = None
    interface: ClassVar[None] = None

    mu0: FrictionCoefficients = Field(default=(0.1, 0.4, 1.0), description=MU0_DESCRIPTION)
    tau0: ShearStrengths = Field(default=PAPER_SHEAR_STRENGTHS, description=TAU0_DESCRIPTION)


class AsperityFrictionSettings(GeneratedSurfaceFrictionSettings):
    """Section `[friction]` for generated surfaces, asperity model: mu0 and tau0 used in figures."""

    place: ClassVar[str] = "asperities of generated surfaces"
    load: ClassVar[tuple[Quantity, ...]] = ()


class HalfSpaceFrictionSettings(GeneratedSurfaceFrictionSettings):
    """Section `[friction]` for generated surfaces, half-space model: loads, mu0 and tau0 used in figures."""

    place: ClassVar[str] = "the half-space of generated surfaces"

    load: LoadsOfInterest = Field(default=(), description=LOADS_DESCRIPTION)


class MeasuredSurfaceFrictionSettings(SettingsSectionVariant):
    """Section `[friction]` for measured surfaces: mu0, tau0, loads and dwell times."""

    place: ClassVar[str] = "measured surfaces"

    mu0: FrictionCoefficientEntries = Field(description=f"{MU0_DESCRIPTION} Not given together with `interface`.")
    tau0: ShearStrengthEntries = Field(default=(ZERO_SHEAR_STRENGTH,), description=TAU0_DESCRIPTION)
    interface: InterfaceSettings | None = Field(
        default=None, description="Interface that defines μ0 and τ0 jointly, instead of `mu0` and `tau0`."
    )
    load: LoadsOfInterest = Field(description=LOADS_DESCRIPTION)
    wait: Times = Field(
        default=(), description="Dwell times under load before sliding; `contact.hardness` is the hardness after 1 s."
    )
    creep: CreepExponentEntry | None = Field(
        default=None, description="Exponent m of indentation creep, for `wait`: H = H(1 s) (t/1 s)^-m."
    )

    @model_serializer(mode="wrap")
    def _omit_derived_values(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = serialize(self)
        return {
            key: value for key, value in data.items() if self.interface is None or key not in INTERFACE_STRENGTH_KEYS
        }


INTERFACE_STRENGTH_KEYS = ("mu0", "tau0")
"""Keys of the section `[friction]` whose values follow from the interface, if the section names an interface."""


def _add_interface_strength(section: Mapping[str, Any]) -> Mapping[str, Any]:
    """Complete a section `[friction]` with the mu0 and tau0 of the interface that the section names."""
    if (source := section.get("interface")) is None:
        return section
    for key in INTERFACE_STRENGTH_KEYS:
        if key in section:
            raise make_key_error(key, "must not be given together with interface, which determines mu0 and tau0")
    try:
        interface = (
            InterfaceSettings.from_source(source)
            if isinstance(source, str)
            else InterfaceSettings.model_validate(source)
        )
    except ValidationError:
        # An invalid interface causes no error here, because the validation of the interface reports it.
        return {**section, "mu0": [0.0]}
    except ValueError as error:
        raise make_key_error("interface", str(error).removeprefix("interface ")) from None
    interface = interface.find_current_entry() or interface
    return {**section, "interface": interface, "mu0": (interface.mu0,), "tau0": (interface.tau0,)}


FrictionSettings = AsperityFrictionSettings | HalfSpaceFrictionSettings | MeasuredSurfaceFrictionSettings
"""Section `[friction]` of a study: one class for measured surfaces, and one per model for generated surfaces."""
FRICTION_SETTINGS_CLASSES: tuple[type[FrictionSettings], ...] = get_args(FrictionSettings)
SHARED_FRICTION_SETTINGS_CLASSES: tuple[type[SettingsSectionVariant], ...] = (
    MeasuredSurfaceFrictionSettings,
    GeneratedSurfaceFrictionSettings,
    HalfSpaceFrictionSettings,
)
"""Base classes with keys that several sections `[friction]` have in common."""


def select_friction_settings_class(surfaces: type[SurfaceSettings], mechanics: str) -> type[FrictionSettings]:
    """Return the class of the section `[friction]`, given the kind of surfaces and the contact model."""
    if issubclass(surfaces, get_args(MeasuredSurfaceSettings)):
        return MeasuredSurfaceFrictionSettings
    return HalfSpaceFrictionSettings if mechanics == "half-space" else AsperityFrictionSettings


class EnsembleSettings(SettingsSection):
    """Section `[ensemble]` of a study: number of members, and seed of the random numbers."""

    repetitions: int = Field(
        default=100, ge=1, le=100_000_000,
        description="Number of repetitions for each fractal dimension and amplitude, or number of relative positions "
        "of measured surfaces.",
    )  # fmt: skip
    seed: int = Field(
        default=DEFAULT_SEED, ge=0, lt=2**63,
        description="Seed of the random numbers; equal seeds give equal surfaces.",
    )  # fmt: skip


FigureName = Literal["profiles", "length-scales", "friction", "area", "onset"]


def _require_distinct_figure_names(names: tuple[str, ...]) -> tuple[str, ...]:
    for name in names:
        if names.count(name) > 1:
            raise ValueError(f"must list each figure at most once, got {short_repr(name)} {names.count(name)} times")
    return names


class FigureSettings(SettingsSection):
    """Section `[figures]` of a study: the figures that are drawn from a result of generated surfaces."""

    draw: Annotated[tuple[FigureName, ...], list_to_tuple_validator, AfterValidator(_require_distinct_figure_names)] = (
        Field(default=("friction", "area"), description="Figures that `run` and `plot` draw.")
    )


def _add_bracketing_loads(
    surfaces: Mapping[str, Any], contact: Mapping[str, Any], friction: Mapping[str, Any]
) -> dict[str, Any]:
    """Return the sections `[contact]` and `[friction]` with two more loads, below and above the requested loads.

    This applies to generated surfaces in the half-space model. Returns an empty dictionary if no loads are requested,
    if the study has its own load curve, or if a section is invalid.
    """
    requested_loads = friction.get("load") or (
        contact.get("load") if isinstance(contact.get("load"), (list, tuple)) else None
    )
    has_curve_loads = bool(friction.get("load")) and "load" in contact
    if (
        contact.get("mechanics") != "half-space"
        or not isinstance(requested_loads, (list, tuple))
        or not requested_loads
        or has_curve_loads
    ):
        return {}
    try:
        loads = [float(quantity(load, "force")) for load in requested_loads]
        highest_load = max(loads) * MAX_AREAL_LOAD_RATIO
        if contact.get("hardness") is not None:
            max_load = float(quantity(contact["hardness"], "pressure")) * _compute_nominal_area(surfaces)
            # A requested load above hardness times nominal area is rejected later, when the section is validated.
            highest_load = min(highest_load, max(loads) * max(math.sqrt(max_load / max(loads)), 1.001))
    except (ValueError, TypeError, AttributeError):
        return {}
    bracketing_loads = [
        exact_quantity_text(float(f"{load:.6g}"), "mN") for load in (min(loads) / MAX_AREAL_LOAD_RATIO, highest_load)
    ]
    return {
        "contact": {**contact, "load": [bracketing_loads[0], *requested_loads, bracketing_loads[1]]},
        "friction": {**friction, "load": [*requested_loads]},
    }


def _compute_nominal_area(surfaces: Mapping[str, Any]) -> float:
    """Compute the nominal area (µm²) of generated surfaces from the keys of the section `[surfaces]`."""
    section: Any = select_surface_settings_class(surfaces).model_validate(surfaces)
    return float(section.nominal_area)


def _build_empty_section() -> Any:
    """Return an empty section; validation replaces it by a section with default values."""
    return {}


class Study(SettingsSection):
    """Complete description of a computation: pairs of surfaces, contact model, friction parameters and ensemble.

    Missing sections and keys have the values of Fig. 6 of the paper. In files, a quantity is text with a unit, as in
    "10 GPa". In Python, a quantity may also be a number in core units (µm, GPa, mN). Some keys exist only for a single
    kind of surfaces or a single contact model, and are rejected in other studies.

    Examples
    --------
    >>> from stiction import Study
    >>> study = Study.named("figure6").with_changes({"ensemble.repetitions": 10})
    >>> study.ensemble.repetitions, float(study.surfaces.extent)
    (10, 40.0)
    """

    surfaces: SurfaceSettings = GeneratedProfileSettings()
    contact: ContactSettings = Field(default_factory=_build_empty_section)
    friction: FrictionSettings = Field(default_factory=_build_empty_section)
    ensemble: EnsembleSettings = EnsembleSettings()
    figures: FigureSettings = FigureSettings()

    @model_validator(mode="before")
    @classmethod
    def _add_loads_for_interpolation(cls, data: Any) -> Any:
        """Add loads below and above the requested loads, so that results can be interpolated at the requested loads.

        The requested loads are `friction.load`. For generated surfaces with the half-space, a list `contact.load` is
        used if `friction.load` is missing.
        """
        if not isinstance(data, Mapping):
            return data
        surfaces, contact, friction = (data.get(name, {}) for name in ("surfaces", "contact", "friction"))
        are_sections = all(isinstance(section, Mapping) for section in (surfaces, contact, friction))
        if are_sections and surfaces.get("kind") != "measured":
            return {**data, **_add_bracketing_loads(surfaces, contact, friction)}
        if not are_sections or "load" in contact or "load" not in friction:
            return data
        try:
            mechanics = (
                select_contact_settings_class(select_surface_settings_class(surfaces), contact)
                .model_fields["mechanics"]
                .default
            )
            loads = [float(quantity(load, "force")) for load in friction["load"]]
            curve_loads = choose_load_steps(loads, press=surfaces.get("press", "areas"), mechanics=mechanics)
        except (ValueError, TypeError):
            return data
        return {
            **data,
            "contact": {**contact, "load": [exact_quantity_text(load, "mN") for load in curve_loads.tolist()]},
        }

    @field_validator("surfaces", mode="before")
    @classmethod
    def _validate_surfaces_section(cls, value: object) -> SurfaceSettings:
        """Validate the section `[surfaces]` with the class that the keys of the section select."""
        if isinstance(value, SURFACE_SETTINGS_CLASSES):
            return value
        if not isinstance(value, Mapping):
            raise ValueError(f"must be a section, got {short_repr(value)}")
        settings_class = select_surface_settings_class(value)
        check_keys(value, settings_class, SURFACE_SETTINGS_CLASSES)
        return settings_class.model_validate(value)

    @field_validator("contact", "friction", mode="before")
    @classmethod
    def _validate_dependent_section(cls, value: object, info: ValidationInfo) -> Any:
        """Validate the section `[contact]` or `[friction]` with the class for the study's kind of surfaces.

        If the section `[surfaces]` is invalid, return a section with defaults, so that only the error in `[surfaces]`
        is reported.
        """
        surfaces = info.data.get("surfaces")
        if surfaces is None:
            surfaces, value = GeneratedProfileSettings(), {}
        if not isinstance(value, Mapping):
            raise ValueError(f"must be a section, got {short_repr(value)}")
        if info.field_name == "contact":
            return parse_contact_settings(value, surfaces)
        if value.get("load") == [] and isinstance(surfaces, MeasuredSurfaceSettings):
            raise make_key_error("load", "must have at least one load, got []")
        contact = info.data.get("contact")
        mechanics = "half-space" if contact is None else contact.mechanics
        settings_class = select_friction_settings_class(type(surfaces), mechanics)
        if settings_class is MeasuredSurfaceFrictionSettings:
            value = _add_interface_strength(value)
        check_keys(value, settings_class, SHARED_FRICTION_SETTINGS_CLASSES)
        return settings_class.model_validate(value)

    @model_validator(mode="after")
    def _require_consistent_sections(self) -> Study:
        figure_names, friction, steps = self.figures.draw, self.friction, self.contact.loading_steps()
        if friction.load and not steps[0] <= float(friction.load[0]) <= float(friction.load[-1]) <= steps[-1]:
            raise ValueError(
                f"friction.load: must be from {steps[0]:g} to {steps[-1]:g} mN, the limits of contact.load, got "
                f"{float(friction.load[0]):g} to {float(friction.load[-1]):g} mN; omit contact.load to compute loads "
                "around friction.load"
            )
        if not self.is_measured:
            self._require_exact_inputs()
            if self.is_areal and (
                profile_figures := [name for name in figure_names if name in ("profiles", "length-scales")]
            ):
                raise ValueError(f'figures.draw: "{profile_figures[0]}" needs profiles, but surfaces.kind is "surface"')
            if "onset" in figure_names and self.contact.onset is None:
                raise ValueError('figures.draw: "onset" needs contact.onset, which specifies mu0 and tau0')
            return self
        if self.figures != FigureSettings():
            raise ValueError("figures.draw: must be omitted for measured surfaces, whose results have all figures")
        if friction.wait and (self.contact.hardness is None or friction.creep is None):
            missing_key = "friction.creep" if self.contact.hardness else "contact.hardness"
            raise ValueError(
                f"friction.wait: needs contact.hardness and friction.creep, the creep exponent; add {missing_key}"
            )
        num_combinations = len(friction.load) * len(friction.mu0) * len(friction.tau0)
        if num_combinations > MAX_PARAMETER_COMBINATIONS:
            raise ValueError(
                f"friction: must have at most {MAX_PARAMETER_COMBINATIONS} combinations of load, mu0 and tau0, "
                f"got {num_combinations}"
            )
        return self

    def _require_exact_inputs(self) -> None:
        """Raise a `ValueError` if an input in the section `[contact]` of generated surfaces is uncertain.

        The intervals of such a study would not include the uncertainty.
        """
        for key, value in self.contact:
            if isinstance(value, InputValue) and not value.is_exact:
                raise ValueError(f"contact.{key}: must be exact for generated surfaces, got {short_repr(value.text)}")

    @property
    def is_measured(self) -> bool:
        """True if the surfaces are measured, and False if they are generated."""
        return self.surfaces.kind == "measured"

    @property
    def is_gap(self) -> bool:
        """True if the study presses one measured map of the gap, instead of two bodies."""
        return bool(getattr(self.surfaces, "gap", None))

    @property
    def pair_checksum(self) -> str:
        """Checksum of the properties that identify a tested pair, such as its surfaces, contact model, E* and hardness.

        The checksum does not depend on paths, loads or friction, so that `calibrate` recognizes a tested pair.
        """
        sections: dict[str, Any] = {name: drop_none_entries(getattr(self, name)) for name in ("surfaces", "ensemble")}
        contact = self.contact
        sections["contact"] = (
            contact.mechanics,
            *(
                f"{float(getattr(contact, name, None) or 0.0):.6g}"
                for name in ("effective_modulus", "hardness", "work_of_adhesion", "indent")
            ),
        )
        text = json.dumps(_replace_paths_by_checksums(sections), sort_keys=True, default=str)
        return f"{zlib.crc32(text.encode()):08x}"

    @property
    def is_areal(self) -> bool:
        """True if the surface pairs (members) are pairs of height maps, and False if they are pairs of profiles."""
        return self.surfaces.is_areal

    @property
    def uses_half_space(self) -> bool:
        """True if contacts are computed in the half-space model, and False in the asperity model."""
        return self.contact.mechanics == "half-space"

    @property
    def has_nominal_area(self) -> bool:
        """True if the bodies have a nominal area, so that a load can be converted to a nominal pressure.

        Profiles in contact as spheres have no nominal area, because the thickness of the strip is arbitrary.
        """
        return self.is_areal or self.uses_half_space or "cylinder" in str(self.contact.law or "").lower()

    @property
    def member_names(self) -> MemberNames:
        """Words for the surface pairs (members) in output, singular and plural, such as "position" and "positions"."""
        return self.surfaces.member_names

    @property
    def step_quantity(self) -> Literal["approach", "load"]:
        """Quantity that is prescribed at each loading step: "approach" or "load"."""
        return self.contact.step_quantity

    def contact_sum_names(self) -> tuple[str, ...]:
        """Return the names of the quantities stored for each surface pair and loading step, such as the true area."""
        if self.uses_half_space:
            adhesion_names = ADHESION_QUANTITIES if self.contact.adheres else ()
            yielding_names = YIELDING_QUANTITIES if self.contact.yield_exponent is not None else ()
            return HALF_SPACE_SUM_QUANTITIES + adhesion_names + yielding_names
        approach_names = ("approach",) if self.step_quantity == "load" else ()
        onset_names = ONSET_QUANTITIES if self.contact.onset is not None else ()
        return SUM_QUANTITIES + (AREAL_SUM_QUANTITIES if self.is_areal else ()) + approach_names + onset_names

    def motion_coordinates(self) -> dict[str, list[Any]]:
        """Return the sliding rules and directions of motion (degrees), which are dataset coordinates of a result."""
        return self.contact.motion_coordinates()

    def with_checksums(self, folder: Path | None = None) -> Study:
        """Return a copy of the study in which all scan files have absolute paths and checksums.

        If a directory is given, bodies in memory are written to it. Raises a `ValueError` if a file cannot be read.
        """
        if not isinstance(self.surfaces, MeasuredSurfaceSettings):
            return self

        def complete_file_entry(file: MeasuredBodySettings, side: str) -> MeasuredBodySettings:
            return (
                (file if folder is None else file.with_saved_bodies(folder, side))
                .with_absolute_paths(Path.cwd())
                .with_checksums()
            )

        return self.model_copy(update={"surfaces": self.surfaces.with_changed_files(complete_file_entry)})

    @classmethod
    def named(cls, name: str) -> Study:
        """Return the built-in study with a given name; `study_names` lists all names.

        Raises
        ------
        StudyError
            If there is no study with that name.
        """
        if not isinstance(name, str) or name not in study_names():
            raise StudyError(
                f"there is no built-in study {short_repr(name)}; the studies are {', '.join(study_names())}"
            )
        return parse_study((_STUDY_LIBRARY_DIRECTORY / f"{name}.toml").read_text(encoding="utf-8"), name)

    @classmethod
    def from_toml(cls, path: str | Path) -> Study:
        """Read a study from a TOML file.

        Raises
        ------
        StudyError
            If the file cannot be read, is not TOML, or has unknown keys, wrong units or impossible values.
        """
        try:
            content = read_file_bytes(Path(path), MAX_STUDY_BYTES)
            study = parse_study(content.decode("utf-8"), str(path))
        except OSError as error:
            raise StudyError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None
        except UnreadableFileError as error:
            raise StudyError(f"{printable_path(path)}: {error}, so it is not a study") from None
        except UnicodeDecodeError:
            raise StudyError(f"{printable_path(path)} is not a text file, so it is not a study") from None
        if not isinstance(study.surfaces, MeasuredSurfaceSettings):
            return study
        directory = Path(path).absolute().parent
        surfaces = study.surfaces.with_changed_files(lambda file, _: file.with_absolute_paths(directory))
        return study.model_copy(update={"surfaces": surfaces})

    def with_changes(self, changes: Mapping[str, Any]) -> Study:
        """Return a copy of the study in which the given keys have new values.

        Parameters
        ----------
        changes : mapping
            Such as ``{"ensemble.repetitions": 10, "surfaces.amplitude": ["50 nm"]}``.

        Raises
        ------
        StudyError
            If a key is unknown, or if a value is impossible.
        """
        data = self._convert_base_sections(changes)
        self._remove_replaced_entries(data, changes)
        for key, value in changes.items():
            section: Any = data
            if not isinstance(key, str):
                raise StudyError(f"{short_repr(key)}: unknown key")
            *path, last_key = key.split(".")
            for name in path:
                section = section.setdefault(name, {}) if isinstance(section, dict) else None
            if not isinstance(section, dict):
                raise StudyError(f"{printable_text(key)}: unknown key")
            section[last_key] = value
        return validate_section(Study, data, "changes")

    def to_toml(self) -> str:
        """Format the study as TOML text with all keys.

        `Study.from_toml` creates an equal study from this text.
        """
        return format_toml_sections(self._to_sections())

    def _convert_base_sections(self, changes: Mapping[str, Any]) -> dict[str, dict[str, Any]]:
        """Return the study's sections, converted to other classes if a changed key, such as `kind`, requires it."""
        sections = self._to_sections()
        selectors = {
            key: changes.get(f"{section}.{key}", sections[section].get(key)) for section, key in _DISCRIMINATOR_KEYS
        }
        selectors = {key: value for key, value in selectors.items() if value is not None}
        try:
            surfaces = select_surface_settings_class(selectors)
            contact = select_contact_settings_class(surfaces, selectors)
        except PydanticCustomError:
            return sections
        sections["surfaces"] = _convert_section(self.surfaces, surfaces)
        sections["contact"] = _convert_section(self.contact, contact)
        if not issubclass(surfaces, get_args(MeasuredSurfaceSettings)):
            friction = select_friction_settings_class(surfaces, contact.model_fields["mechanics"].default)
            self._remove_dependent_loads(sections, changes, is_allowed="load" in friction.model_fields)
        return sections

    def _remove_replaced_entries(self, sections: Mapping[str, dict[str, Any]], changes: Mapping[str, Any]) -> None:
        """Remove keys of the sections `[contact]` and `[friction]` that a newly given key replaces or rules out.

        E* replaces Young's moduli, but not `compliance_share`, and Young's moduli replace both. An interface replaces
        mu0 and tau0; a change of mu0 or tau0 replaces the interface, but not the other parameter.
        """
        contact, friction = sections["contact"], sections["friction"]
        if changes.get("contact.effective_modulus") is not None:
            contact.pop("young", None)
            if isinstance(self.contact, HalfSpaceSettings):
                contact["compliance_share"] = self.contact.compliance_share
        if changes.get("contact.young") is not None:
            for key in DERIVED_ELASTICITY_KEYS:
                contact.pop(key, None)
        if changes.get("friction.interface") is not None:
            for key in INTERFACE_STRENGTH_KEYS:
                friction.pop(key, None)
        elif self.friction.interface is not None and any(
            f"friction.{key}" in changes for key in INTERFACE_STRENGTH_KEYS
        ):
            del friction["interface"]
            friction |= {key: getattr(self.friction, key) for key in INTERFACE_STRENGTH_KEYS}

    def _remove_dependent_loads(
        self, sections: dict[str, dict[str, Any]], changes: Mapping[str, Any], *, is_allowed: bool
    ) -> None:
        """Remove the loads from a study of generated surfaces if `changes` contains loads that contradict them.

        `friction.load` is removed if `contact.load` changes, or if the changed study has no `friction.load`. Otherwise,
        `contact.load` is removed if it has two loads more than `friction.load`, because validation added two loads, and
        will add two loads that enclose the changed loads.
        """
        if "contact.load" in changes or not is_allowed:
            sections["friction"].pop("load", None)
        elif (
            len(requested_loads := sections["friction"].get("load", ()))
            and len(sections["contact"]["load"]) == len(requested_loads) + 2
        ):
            sections["contact"].pop("load")

    def _to_sections(self) -> dict[str, dict[str, Any]]:
        names = [name for name in type(self).model_fields if name != "figures" or not self.is_measured]
        return {name: drop_none_entries(getattr(self, name)) for name in names}


def _convert_section(section: SettingsSection, target_class: type[SettingsSection]) -> dict[str, Any]:
    """Convert a section to another section class, and replace defaults of the old class by defaults of the new one.

    Keys that differ from the default of the old class keep their values.
    """
    section_class = type(section)
    changed_keys = {key for key, value in section if value != section_class.model_fields[key].default}
    keys = [key for key, field in target_class.model_fields.items() if key in changed_keys or not field.is_required()]
    values = {
        key: getattr(section, key) if key in changed_keys else target_class.model_fields[key].default for key in keys
    }
    return drop_none_entries(target_class.model_construct(**values))


def drop_none_entries(section: SettingsSection) -> dict[str, Any]:
    """Convert a section to a dictionary without keys whose value is None; the keys are sorted as in study files."""
    data = section.model_dump(exclude_none=True)
    key_order = {key: index - len(_KEYS_WRITTEN_FIRST) for index, key in enumerate(_KEYS_WRITTEN_FIRST)}
    if isinstance(section, ContactSettingsForMeasuredMaps):
        key_order["direction"] = 1
    return dict(sorted(data.items(), key=lambda item: key_order.get(item[0], 0)))


def _replace_paths_by_checksums(value: Any) -> Any:
    """Copy nested study entries, but omit the file path and the loaded body of each scan that has a checksum."""
    if isinstance(value, Mapping):
        ignored_keys = ("file", "body") if "sha256" in value else ()
        return {key: _replace_paths_by_checksums(item) for key, item in value.items() if key not in ignored_keys}
    return [_replace_paths_by_checksums(item) for item in value] if isinstance(value, (list, tuple)) else value


def study_names() -> list[str]:
    """Return the names of the built-in studies.

    Returns
    -------
    names : list of str
        Sorted names, which `Study.named` accepts.

    See Also
    --------
    run : Run a study.

    Examples
    --------
    >>> from stiction import study_names
    >>> "quick" in study_names()
    True
    """
    return sorted(
        item.name.removesuffix(".toml") for item in _STUDY_LIBRARY_DIRECTORY.iterdir() if item.name.endswith(".toml")
    )


def read_study_description(study_name: str) -> str:
    """Return the description of a built-in study: one sentence."""
    return (
        (_STUDY_LIBRARY_DIRECTORY / f"{study_name}.toml")
        .read_text(encoding="utf-8")
        .partition("\n")[0]
        .removeprefix("# ")
    )


def parse_study_of_dataset(dataset: xarray.Dataset) -> Study:
    """Parse the study that is stored in the attributes of a result's dataset.

    Raises a `StudyError` if the dataset has no attribute 'study'.
    """
    text = dataset.attrs.get("study")
    if not isinstance(text, str):
        raise StudyError("the dataset has no attribute 'study', so mu0 and tau0 must be given")
    return parse_study(text, "the dataset's study")


def find_step_dimension(dataset: xarray.Dataset) -> str:
    """Return the dimension along which a dataset stores its loading steps: "load" or "approach"."""
    return "load" if "load" in dataset.dims else "approach"


def find_section_differences(
    first_section: SettingsSection, second_section: SettingsSection, prefix: str = ""
) -> list[StudyDifference]:
    """List the keys whose values differ between two sections, in study file order, with both values as text."""
    serialized, differences = (first_section.model_dump(), second_section.model_dump()), []
    for name in dict.fromkeys((*type(first_section).model_fields, *type(second_section).model_fields)):
        field = type(first_section).model_fields.get(name) or type(second_section).model_fields[name]
        # Bodies in memory (fields without `repr`) are not compared, because other fields contain their checksums.
        if not field.repr:
            continue
        first_value, second_value = getattr(first_section, name, None), getattr(second_section, name, None)
        if first_value == second_value:
            continue
        # A published interface is a section in memory, but only a name in a study file.
        have_keys = all(isinstance(section.get(name), dict) for section in serialized)
        if have_keys and isinstance(first_value, SettingsSection) and isinstance(second_value, SettingsSection):
            differences += find_section_differences(first_value, second_value, f"{prefix}{name}.")
        else:
            texts = [
                format_toml_value(section.get(name, format_quantities(value)))
                for section, value in zip(serialized, (first_value, second_value), strict=True)
            ]
            differences.append((f"{prefix}{name}", texts[0], texts[1]))
    return differences


def find_member_differences(first_study: Study, second_study: Study) -> list[StudyDifference]:
    """List the keys that have different values in two studies and affect the computed surface pairs.

    Each key is listed with both values as text.

    Members depend on the central values of inputs, but not on the ranges. Members do not depend on the section
    `[friction]`, on the area loss under shear, on the depth of the indentation, on whether the lay was assumed, on
    figures, or on file paths. If bodies yield, the stored elastic areas serve every exponent of the yielding area.
    """
    has_same_areas = (first_study.contact.yield_exponent is None) == (second_study.contact.yield_exponent is None)
    ignored_keys = (
        "contact.young",
        "contact.area_loss",
        "contact.indent",
        "surfaces.lay_assumed",
        *(["contact.yield_exponent"] if has_same_areas else []),
    )
    return [
        difference
        for difference in find_section_differences(first_study, second_study)
        if (difference[0].startswith(("surfaces.", "contact.")) or difference[0] == "ensemble.seed")
        and not difference[0].endswith((".upper.file", ".lower.file"))
        and difference[0] not in ignored_keys
        and not _have_equal_central_values(first_study, second_study, difference[0])
    ]


def _have_equal_central_values(first_study: Study, second_study: Study, key: str) -> bool:
    """Return whether a key names an input, such as the hardness, whose central values are equal in two studies."""
    section, _, name = key.partition(".")
    values = [getattr(getattr(study, section), name, None) for study in (first_study, second_study)]
    inputs = [value if isinstance(value, tuple) else (value,) for value in values]
    is_input = all(isinstance(item, InputValue) for value in inputs for item in value)
    return is_input and [float(item) for item in inputs[0]] == [float(item) for item in inputs[1]]


def format_study_differences(differences: list[StudyDifference]) -> str:
    """Format the first few differences between two studies as lines of an error message."""
    lines = [
        f"{key} = {short_repr(stored_value)} there, {short_repr(other_value)} here"
        for key, stored_value, other_value in differences[:MAX_LISTED_DIFFERENCES]
    ]
    if len(differences) > MAX_LISTED_DIFFERENCES:
        lines.append(f"... and {len(differences) - MAX_LISTED_DIFFERENCES} more")
    return "\n".join(lines)


def parse_study(text: str, source: str) -> Study:
    """Parse a study from TOML text.

    Error messages start with `source`, the name of the file or text.
    """
    try:
        data = parse_toml(text)
    except ValueError as error:
        raise StudyError(
            f"{printable_path(source)}: the text is not valid TOML: {printable_text(error, MAX_PATH_LENGTH)}"
        ) from None
    # An empty study file is rejected as a mistake, although all keys have defaults.
    if not data:
        raise StudyError(f"{printable_path(source)} is empty, so it is not a study")
    return validate_section(Study, convert_old_study(data, source), source)
