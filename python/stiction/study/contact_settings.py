"""Section `[contact]` of a study: one class for each contact model and kind of surfaces."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike
from pydantic import (
    BeforeValidator,
    Field,
    PlainSerializer,
    PlainValidator,
    SerializerFunctionWrapHandler,
    model_serializer,
    model_validator,
)

from stiction._checks import Floats, float_array
from stiction._units import VALID_QUANTITY_RANGES, exact_quantity, quantity, short_repr
from stiction.mechanics.half_space import DEFAULT_ADHESION_RANGE, BoundaryCondition, TiltMode
from stiction.mechanics.law import CONTACT_LAWS_BY_NAME, HertzCylinder, JacksonGreen, LawName, parse_contact_law
from stiction.mechanics.model import (
    ContactModel,
    CurvatureRequirement,
    DetectionMethod,
    Direction,
    ShearDirection,
    SlidingRule,
)
from stiction.study.elasticity import derive_elasticity
from stiction.study.generated_surfaces import GeneratedProfileSettings, GeneratedSurfaceSettings
from stiction.study.input_distributions import (
    AreaLossEntry,
    EffectiveModulusEntry,
    HardnessEntry,
    JunctionGrowthEntry,
    PoissonRatioEntry,
    YieldExponentEntry,
    YoungModulusEntry,
    parse_input_value,
)
from stiction.study.measured_surfaces import MeasuredSurfaceSettings
from stiction.study.values import (
    ApproachesOrRange,
    ApproachRange,
    Directions,
    Fraction,
    Length,
    LoadRange,
    LoadsOrRange,
    Modulus,
    PressureOrZero,
    SettingsSection,
    SettingsSectionVariant,
    SlidingRules,
    WorkOfAdhesion,
    check_keys,
    direction_to_degrees,
    format_quantities,
    list_to_tuple_validator,
    make_key_error,
    select_key_value,
    to_value_array,
)

DEFAULT_DIRECTIONS = tuple(30.0 * step for step in range(12))  # degrees
MAX_DIRECTIONS = 360
ASPERITY_LOAD_EXTENSION_FACTOR = 30.0
NUM_ASPERITY_LOADS = 25
HALF_PLANE_LOAD_EXTENSION_FACTOR = 10.0
NUM_HALF_PLANE_LOADS = 7
MAX_AREAL_LOAD_RATIO = 10**0.5


# ---- Laws -----------------------------------------------------------------------------------------------------------


class HertzCylinderSettings(SettingsSection):
    """Section `law` for the contact law of elastic cylinders, with the width of the cylinders."""

    name: Literal["hertz-cylinder"]
    width: Length

    def law(self) -> HertzCylinder:
        """Return the contact law of elastic cylinders with the width in this section."""
        return HertzCylinder(width=float(self.width))


class JacksonGreenSettings(SettingsSection):
    """Section `law` for the Jackson-Green contact law: yield strength and Poisson's ratio of the softer body."""

    name: Literal["jackson-green"]
    yield_strength: Modulus
    poisson_ratio: Annotated[float, Field(ge=0, le=0.5)]

    def law(self) -> JacksonGreen:
        """Return the Jackson-Green contact law with the yield strength and Poisson's ratio in this section."""
        return JacksonGreen(yield_strength=float(self.yield_strength), poisson_ratio=self.poisson_ratio)


LawTableSettings = HertzCylinderSettings | JacksonGreenSettings
SETTINGS_CLASSES_BY_CONTACT_LAW: dict[str, type[LawTableSettings]] = {
    "hertz-cylinder": HertzCylinderSettings,
    "jackson-green": JacksonGreenSettings,
}
"""Classes of the section `law`, by name of the contact law. Other contact laws have no parameters."""


def _parse_law(value: object) -> LawName | LawTableSettings:
    """Parse the value of the key `law`: the name of a contact law, or a section with the parameters of the law."""
    for name in CONTACT_LAWS_BY_NAME:
        if value == name:
            return name  # type: ignore[return-value]
    if isinstance(value, LawTableSettings):
        return value
    settings_class = SETTINGS_CLASSES_BY_CONTACT_LAW.get(str(value.get("name"))) if isinstance(value, Mapping) else None
    if settings_class is None:
        names = " or ".join(f'"{name}"' for name in CONTACT_LAWS_BY_NAME)
        section_names = " or ".join(
            f'"{name}" ({", ".join(list(settings_class.model_fields)[1:])})'
            for name, settings_class in SETTINGS_CLASSES_BY_CONTACT_LAW.items()
        )
        raise ValueError(f"must be {names}, or a section with the name {section_names}, got {short_repr(value)}")
    return settings_class.model_validate(value)


def _serialize_law(law: LawName | LawTableSettings) -> object:
    return law if isinstance(law, str) else law.model_dump()


LawNameOrSettings = Annotated[LawName | LawTableSettings, PlainValidator(_parse_law), PlainSerializer(_serialize_law)]


# ---- Contacts -------------------------------------------------------------------------------------------------------

_MaterialName = Annotated[str, Field(min_length=1, max_length=80)]
DetectionSetting = Annotated[
    DetectionMethod,
    Field(description="Criterion for a contact: as in the paper, or minima of the gap (the only criterion for areas)."),
]
CurvatureSetting = Annotated[
    CurvatureRequirement, Field(description="Convexity required at a contact: of both bodies, or only of their gap.")
]
MaterialNames = Annotated[tuple[_MaterialName, _MaterialName], list_to_tuple_validator]
DERIVED_ELASTICITY_KEYS = ("effective_modulus", "compliance_share")
"""Keys of the section `[contact]` that are computed if Young's moduli and Poisson's ratios are given."""


def _repeat_single_value(value: Any) -> Any:
    """Return a pair of values for the upper and the lower body. A single value is used for both."""
    values = tuple(value) if isinstance(value, (list, tuple)) else (value,)
    return 2 * values if len(values) == 1 else values


_repeat_for_both_bodies = BeforeValidator(_repeat_single_value)
YoungModuli = Annotated[tuple[YoungModulusEntry, YoungModulusEntry], _repeat_for_both_bodies]
PoissonRatios = Annotated[tuple[PoissonRatioEntry, PoissonRatioEntry], _repeat_for_both_bodies]


class OnsetSettings(SettingsSection):
    """Section `onset` with mu0 and tau0 for the onset of sliding of generated surfaces.

    A result stores the onset of sliding for these parameters only.
    """

    mu0: float = Field(default=0.4, ge=0, description="Molecular friction coefficient.")
    tau0: PressureOrZero = Field(default=quantity("0 MPa", "pressure"), description="Adhesive shear strength.")
    poisson_ratio: float = Field(default=0.3, gt=-1, le=0.5, description="Poisson's ratio of both bodies.")

    @model_validator(mode="after")
    def _require_mu0_or_tau0(self) -> OnsetSettings:
        if self.mu0 == 0 and float(self.tau0) == 0:
            raise ValueError("mu0 and tau0 must not both be 0, because the bodies would slide without friction")
        return self


DIRECTION_DESCRIPTION = (
    "Direction of motion of the upper body, instead of `shear`. For height maps, it may be an angle in degrees from +x "
    "towards +y, or a list of directions."
)
LOAD_DESCRIPTION = "Elastic normal loads; measured bodies use loads around `friction.load` by default."


class CommonContactSettings(SettingsSectionVariant):
    """Keys of the section `[contact]` for all contact models and all kinds of surfaces."""

    effective_modulus: EffectiveModulusEntry = Field(
        default=parse_input_value("effective_modulus", "10 GPa"), description="Effective modulus E* of both bodies."
    )

    @property
    def step_quantity(self) -> Literal["approach", "load"]:
        """Name of the quantity that the study prescribes at each loading step: "approach" or "load"."""
        return "load"

    def loading_steps(self) -> Floats:
        """Return the approaches (µm) or loads (mN) of all loading steps."""
        raise NotImplementedError

    def sliding_rules(self) -> tuple[SlidingRule, ...]:
        """Return the sliding rules for which the section requests results."""
        raise NotImplementedError

    def directions_of_motion(self) -> tuple[Direction, ...]:
        """Return the directions of motion of the upper body, as given by the key `shear` or `direction`."""
        raise NotImplementedError

    def direction_angles(self) -> Floats:
        """Return the directions of motion of the upper body as angles (degrees) from +x towards +y."""
        return np.array([direction_to_degrees(direction) for direction in self.directions_of_motion()])

    def motion_coordinates(self) -> dict[str, list[Any]]:
        """Return the coordinates of a result that describe the motion: sliding rules, and directions in degrees."""
        return {"sliding": list(self.sliding_rules()), "direction": self.direction_angles().tolist()}


# ---- Study-file keys for each kind of surfaces ----------------------------------------------------------------------


class GeneratedSurfaceContactSettings(CommonContactSettings):
    """Keys of the section `[contact]` that describe how generated surfaces move over each other."""

    place: ClassVar[str] = "generated surfaces"
    materials: ClassVar[None] = None
    young: ClassVar[None] = None
    poisson: ClassVar[None] = None

    shear: ShearDirection = Field(default="+x", description="Direction of motion of the upper body along a profile.")
    direction: Directions = Field(default=None, description=DIRECTION_DESCRIPTION)
    sliding: SlidingRules = Field(
        default="opposing",
        description="Contacts with friction: only contacts that oppose the motion, as in the paper, or all contacts; "
        "or a list of both rules.",
    )

    @model_validator(mode="after")
    def _require_one_direction(self) -> Self:
        if self.direction is not None and self.shear != "+x":
            raise make_key_error("direction", f'must not be given together with shear = "{self.shear}"')
        return self

    def sliding_rules(self) -> tuple[SlidingRule, ...]:
        """Return the sliding rules for which the section requests results."""
        return self.sliding if isinstance(self.sliding, tuple) else (self.sliding,)

    def directions_of_motion(self) -> tuple[Direction, ...]:
        """Return the directions of motion of the upper body, as given by the key `shear` or `direction`."""
        direction_value = self.shear if self.direction is None else self.direction
        return direction_value if isinstance(direction_value, tuple) else (direction_value,)

    def motion_coordinates(self) -> dict[str, list[Any]]:
        """Return the coordinates of a result that describe the motion: sliding rules, and directions in degrees.

        For generated surfaces, a single rule or direction is not a coordinate.
        """
        is_list = {"sliding": isinstance(self.sliding, tuple), "direction": isinstance(self.direction, tuple)}
        return {name: values for name, values in super().motion_coordinates().items() if is_list[name]}


class GeneratedSurfaceLoadSettings(GeneratedSurfaceContactSettings):
    """Keys of the section `[contact]` that list the loads on generated surfaces in the half-space model."""

    place: ClassVar[str] = "the half-space of generated surfaces"

    load: LoadsOrRange = Field(
        default=LoadRange(start=quantity("0.01 mN", "force"), stop=quantity("1 mN", "force"), count=8),
        description=LOAD_DESCRIPTION,
    )

    def loading_steps(self) -> Floats:
        """Return the loads (mN) of all loading steps."""
        return to_value_array(self.load)


class ContactSettingsForMeasuredSurfaces(CommonContactSettings):
    """Keys of the section `[contact]` for measured surfaces at given loads, with results for both sliding rules."""

    place: ClassVar[str] = "measured surfaces"

    load: LoadsOrRange = Field(description=LOAD_DESCRIPTION)
    materials: MaterialNames | None = Field(
        default=None,
        description="Material names of the upper and the lower body. E* of `young` and `poisson` is then rounded to "
        "three digits.",
    )
    young: YoungModuli | None = Field(
        default=None,
        description="Young's moduli of the upper and the lower body, instead of `effective_modulus` and "
        "`compliance_share`.",
    )
    poisson: PoissonRatios | None = Field(
        default=None,
        description="Poisson's ratios of the upper and the lower body; without `young`, they affect only the onset of "
        "sliding, and are 0.3 by default.",
    )

    @model_validator(mode="before")
    @classmethod
    def _derive_effective_modulus(cls, data: Any) -> Any:
        """Compute E* and the lower body's compliance fraction if the `[contact]` section gives Young's moduli."""
        if not isinstance(data, Mapping) or data.get("young") is None:
            return data
        for key in DERIVED_ELASTICITY_KEYS:
            if data.get(key) is not None:
                raise make_key_error(key, f"must not be given together with young, from which {key} is computed")
        if data.get("poisson") is None:
            raise make_key_error("poisson", "must be given together with young")
        try:
            young, poisson = (
                [float(parse_input_value(key, value)) for value in _repeat_single_value(data[key])]
                for key in ("young", "poisson")
            )
            elasticity = derive_elasticity(young, poisson, is_named=data.get("materials") is not None)
        except (ValueError, IndexError):
            # Invalid elastic constants are reported later, by the validation of the keys `young` and `poisson`.
            return data
        derived_elasticity: dict[str, Any] = {
            "effective_modulus": exact_quantity(elasticity.effective_modulus, "GPa"),
            "compliance_share": elasticity.compliance_share,
        }
        return {**data, **{key: value for key, value in derived_elasticity.items() if key in cls.model_fields}}

    @model_serializer(mode="wrap")
    def _omit_derived_values(self, serialize: SerializerFunctionWrapHandler) -> dict[str, Any]:
        data: dict[str, Any] = serialize(self)
        omitted_keys = () if self.young is None else DERIVED_ELASTICITY_KEYS
        return {key: value for key, value in data.items() if key not in omitted_keys}

    def loading_steps(self) -> Floats:
        """Return the loads (mN) of all loading steps."""
        return to_value_array(self.load)

    def sliding_rules(self) -> tuple[SlidingRule, ...]:
        """Return both sliding rules, "all" and "opposing", because measured surfaces have results for both."""
        return "all", "opposing"


class ContactSettingsForMeasuredLines(ContactSettingsForMeasuredSurfaces):
    """Keys of the section `[contact]` for measured profiles and scan lines, which slide in both directions."""

    place: ClassVar[str] = "measured lines"

    def directions_of_motion(self) -> tuple[Direction, ...]:
        """Return both directions of motion of a profile, "+x" and "-x"."""
        return "+x", "-x"


class ContactSettingsForMeasuredMaps(ContactSettingsForMeasuredSurfaces):
    """Keys of the section `[contact]` for measured height maps, which can slide in one or several directions."""

    place: ClassVar[str] = "measured areas"

    direction: Directions = Field(default=DEFAULT_DIRECTIONS, description=DIRECTION_DESCRIPTION)

    def directions_of_motion(self) -> tuple[Direction, ...]:
        """Return the directions of motion of a height map, as given by the key `direction`."""
        assert self.direction is not None
        return self.direction if isinstance(self.direction, tuple) else (self.direction,)


class HalfSpaceSettings(CommonContactSettings):
    """Keys of the section `[contact]` for the half-space model."""

    place: ClassVar[str] = "the half-space"
    law: ClassVar[None] = None
    onset: ClassVar[None] = None

    mechanics: Literal["half-space"] = Field(default="half-space", description="Contact model: the elastic half-space.")
    boundary: BoundaryCondition = Field(
        default="free", description="Boundary at the edges: free, or periodic continuation of the surfaces."
    )
    hardness: HardnessEntry | None = Field(
        default=None, description="Largest contact pressure; elastic contact if omitted."
    )
    junction_growth: JunctionGrowthEntry | None = Field(
        default=None,
        description='Growth of contacts under shear: "slip-line", or α of p² + α τ² = H²; 0 with a caveat if omitted.',
    )
    yield_exponent: YieldExponentEntry | None = Field(
        default=None, description="Exponent of the area of yielding contacts, 0.7 to 1.6 for rough surfaces."
    )
    indent: Length | None = Field(
        default=None,
        description="Depth of the indentation that measured the hardness, which is higher in smaller contacts.",
    )
    area_loss: AreaLossEntry | None = Field(
        default=None,
        description="Fraction of the true area that soft elastic bodies lose under shear; 0 with a caveat if omitted.",
    )
    compliance_share: Fraction = Field(
        default=0.5, description="Fraction of the compliance that the lower body contributes."
    )
    work_of_adhesion: WorkOfAdhesion | None = Field(
        default=None,
        description="Energy per area that separates surfaces in contact; if omitted, it is unknown and treated as 0.",
    )
    adhesion_range: Length | None = Field(
        default=None, description="Gap over which the attraction decays to 1/e; 0.5 nm by default."
    )

    tilt: TiltMode = Field(
        default="fixed",
        description="Orientation of the upper body: fixed, or (with free boundaries) tilted until the load is centred.",
    )

    @model_validator(mode="after")
    def _require_consistent_growth(self) -> HalfSpaceSettings:
        if self.junction_growth and self.hardness is None:
            raise make_key_error(
                "junction_growth",
                "must not be given without a hardness, because shear enlarges only contacts that yield",
            )
        if self.area_loss and self.hardness is not None:
            raise make_key_error(
                "area_loss", "must not be given with a hardness, because contacts that yield grow under shear"
            )
        if self.yield_exponent is not None and (self.hardness is None or self.adheres):
            raise make_key_error(
                "yield_exponent",
                "must not be given without a hardness, because contacts then do not yield"
                if self.hardness is None
                else "must not be given if work_of_adhesion is above 0, because the area of adhesive contacts is "
                "computed by capping pressures at the hardness, without an exponent",
            )
        if self.indent is not None and self.yield_exponent is None:
            raise make_key_error(
                "indent", "requires yield_exponent, because the size effect is computed only for contacts that yield"
            )
        if self.junction_growth and self.adheres:
            raise make_key_error(
                "junction_growth",
                "must be 0 if work_of_adhesion is above 0, because the model does not enlarge adhesive contacts",
            )
        return self

    @model_validator(mode="after")
    def _require_consistent_adhesion(self) -> HalfSpaceSettings:
        if self.adhesion_range is not None and not self.adheres:
            raise make_key_error("adhesion_range", "must not be given unless work_of_adhesion is above 0")
        max_attraction = float(self.work_of_adhesion or 0) / float(self.adhesion_range or DEFAULT_ADHESION_RANGE)
        if self.hardness is not None and not max_attraction < float(self.hardness):
            raise make_key_error(
                "hardness", f"must be above work_of_adhesion / adhesion_range = {max_attraction:g} GPa, because the "
                "attraction alone would make softer bodies yield, "
                f"got {short_repr(format_quantities(self.hardness))}",
            )  # fmt: skip
        return self

    @property
    def adheres(self) -> bool:
        """True if the bodies adhere, because the work of adhesion is above 0."""
        return bool(self.work_of_adhesion)

    @model_validator(mode="after")
    def _require_consistent_tilt(self) -> HalfSpaceSettings:
        if self.tilt == "free" and (self.adheres or self.boundary == "periodic"):
            raise make_key_error(
                "tilt", 'must be "fixed" if the boundaries are periodic or the bodies adhere, got "free"'
            )
        return self

    def solver_arguments(self) -> dict[str, Any]:
        """Return the arguments of `half_space` from this section: elasticity, hardness, adhesion, boundary and tilt."""
        return {
            "effective_modulus": float(self.effective_modulus),
            "boundary": self.boundary,
            "compliance_share": self.compliance_share,
            "tilt": self.tilt,
            "hardness": None if self.hardness is None else float(self.hardness),
            **({"work_of_adhesion": float(self.work_of_adhesion)} if self.work_of_adhesion else {}),
            **({"adhesion_range": float(self.adhesion_range)} if self.adhesion_range else {}),
        }


class AsperityModelSettings(CommonContactSettings):
    """Keys of the section `[contact]` for the asperity model, whose contacts do not interact."""

    place: ClassVar[str] = "asperities"
    hardness: ClassVar[None] = None
    junction_growth: ClassVar[None] = None
    yield_exponent: ClassVar[None] = None
    indent: ClassVar[None] = None
    area_loss: ClassVar[None] = None
    work_of_adhesion: ClassVar[None] = None
    adheres: ClassVar[bool] = False

    mechanics: Literal["asperities"] = Field(
        default="asperities", description="Contact model: Hertzian contacts that do not interact."
    )
    law: LawNameOrSettings = Field(
        default="hertz-sphere",
        description='Contact law; `{ name = "jackson-green", yield_strength = ..., poisson_ratio = ... }`.',
    )
    detection: DetectionSetting = "gap-minimum"
    curvature: CurvatureSetting = "convex"

    def direction_arguments(self) -> dict[str, Any]:
        """Return the arguments of `ContactModel` for the direction of motion: none for measured surfaces."""
        return {}

    def contact_model(self, sliding: SlidingRule | None = None) -> ContactModel:
        """Return the contact model for a sliding rule, by default for the first sliding rule in the section."""
        return ContactModel(
            effective_modulus=float(self.effective_modulus),
            law=self.law if isinstance(self.law, str) else self.law.law(), detection=self.detection,
            curvature=self.curvature, sliding=sliding or self.sliding_rules()[0], **self.direction_arguments(),
        )  # fmt: skip


# ---- Combinations of contact model and kind of surfaces --------------------------------------------------------------


class AsperitySettingsForGeneratedSurfaces(AsperityModelSettings, GeneratedSurfaceContactSettings):
    """Keys of the section `[contact]` for generated surfaces in the asperity model, at given approaches."""

    place: ClassVar[str] = "asperities of generated surfaces"

    approach: ApproachesOrRange = Field(
        default=ApproachRange(start=quantity("0.1 nm", "length"), stop=quantity("40 nm", "length"), count=40),
        description="Approaches of the bodies from first contact.",
    )
    onset: OnsetSettings | None = Field(
        default=None,
        description="Friction parameters for which the onset of sliding of each pair is stored, as in `{ mu0 = 0.4 }`.",
    )

    @model_validator(mode="after")
    def _require_valid_onset(self) -> Self:
        if self.onset is not None and isinstance(parse_contact_law(self.contact_model().law), HertzCylinder):
            raise make_key_error(
                "onset",
                'must not be given with the law "hertz-cylinder", because the displacement under a line load is '
                "unbounded",
            )
        return self

    @property
    def step_quantity(self) -> Literal["approach", "load"]:
        """Quantity that is prescribed at each loading step: "approach" or "load"."""
        return "approach"

    def loading_steps(self) -> Floats:
        """Return the approaches (µm) of all loading steps."""
        return to_value_array(self.approach)

    def direction_arguments(self) -> dict[str, Any]:
        """Return the arguments of `ContactModel` that set the direction of motion of generated surfaces."""
        return {"shear": self.shear, "direction": self.direction}


class AsperitySettingsForGeneratedProfiles(AsperitySettingsForGeneratedSurfaces):
    """Section `[contact]` of a study that applies the asperity model to generated profiles."""

    place: ClassVar[str] = "asperities of generated lines"

    detection: DetectionSetting = "cell"


class AsperitySettingsForGeneratedMaps(AsperitySettingsForGeneratedSurfaces):
    """Section `[contact]` of a study that applies the asperity model to generated height maps."""

    place: ClassVar[str] = "asperities of generated areas"

    curvature: CurvatureSetting = "signed"


class AsperitySettingsForMeasuredLines(AsperityModelSettings, ContactSettingsForMeasuredLines):
    """Section `[contact]` of a study that applies the asperity model to measured profiles or to scan lines of maps."""

    place: ClassVar[str] = "asperities of measured lines"
    onset: ClassVar[None] = None


class AsperitySettingsForMeasuredMaps(AsperityModelSettings, ContactSettingsForMeasuredMaps):
    """Section `[contact]` of a study that applies the asperity model to measured height maps."""

    place: ClassVar[str] = "asperities of measured areas"
    onset: ClassVar[None] = None

    curvature: CurvatureSetting = "signed"


class HalfSpaceSettingsForGeneratedProfiles(HalfSpaceSettings, GeneratedSurfaceLoadSettings):
    """Section `[contact]` of a study that applies the half-plane model to generated profiles."""

    place: ClassVar[str] = "the half-space of generated lines"


class HalfSpaceSettingsForGeneratedMaps(HalfSpaceSettings, GeneratedSurfaceLoadSettings):
    """Section `[contact]` of a study that applies the half-space model to generated height maps."""

    place: ClassVar[str] = "the half-space of generated areas"


class HalfSpaceSettingsForMeasuredLines(HalfSpaceSettings, ContactSettingsForMeasuredLines):
    """Section `[contact]` of a study that applies the half-plane model to measured profiles or scan lines of maps."""

    place: ClassVar[str] = "the half-space of measured lines"


class HalfSpaceSettingsForMeasuredMaps(HalfSpaceSettings, ContactSettingsForMeasuredMaps):
    """Section `[contact]` of a study that applies the half-space model to measured height maps."""

    place: ClassVar[str] = "the half-space of measured areas"


ContactSettings = (
    AsperitySettingsForGeneratedProfiles
    | AsperitySettingsForGeneratedMaps
    | AsperitySettingsForMeasuredLines
    | AsperitySettingsForMeasuredMaps
    | HalfSpaceSettingsForGeneratedProfiles
    | HalfSpaceSettingsForGeneratedMaps
    | HalfSpaceSettingsForMeasuredLines
    | HalfSpaceSettingsForMeasuredMaps
)
"""Section `[contact]` of a study: one of eight classes, for each combination of bodies and contact model."""

CONTACT_SETTINGS_CLASSES: dict[str, dict[str, type[ContactSettings]]] = {
    "generated lines": {
        "asperities": AsperitySettingsForGeneratedProfiles,
        "half-space": HalfSpaceSettingsForGeneratedProfiles,
    },
    "generated areas": {
        "asperities": AsperitySettingsForGeneratedMaps,
        "half-space": HalfSpaceSettingsForGeneratedMaps,
    },
    "measured lines": {"asperities": AsperitySettingsForMeasuredLines, "half-space": HalfSpaceSettingsForMeasuredLines},
    "measured areas": {"half-space": HalfSpaceSettingsForMeasuredMaps, "asperities": AsperitySettingsForMeasuredMaps},
}
"""Classes of the section `[contact]`, by kind of bodies and value of the key `mechanics`. The first class of each kind
is the default.
"""

SHARED_CONTACT_SETTINGS_CLASSES: tuple[type[CommonContactSettings], ...] = (
    AsperityModelSettings, AsperitySettingsForGeneratedSurfaces, ContactSettingsForMeasuredSurfaces,
    GeneratedSurfaceContactSettings, ContactSettingsForMeasuredMaps, HalfSpaceSettings, GeneratedSurfaceLoadSettings,
)  # fmt: skip
"""Base classes of sections `[contact]`, which messages name if a key is only valid for other bodies or models."""


def select_contact_settings_class(
    surfaces: type[GeneratedSurfaceSettings | MeasuredSurfaceSettings], section: Mapping[str, Any]
) -> type[ContactSettings]:
    """Return the settings class for a section `[contact]`, from the kind of surfaces and the key `mechanics`."""
    settings_classes = CONTACT_SETTINGS_CLASSES[surfaces.bodies]
    return settings_classes[select_key_value("mechanics", section, settings_classes)]


def parse_contact_settings(
    value: Mapping[str, Any], surfaces: GeneratedSurfaceSettings | MeasuredSurfaceSettings
) -> ContactSettings:
    """Parse a section `[contact]`, and check that the section suits the kind of surfaces."""
    settings_class = select_contact_settings_class(type(surfaces), value)
    check_keys(value, settings_class, SHARED_CONTACT_SETTINGS_CLASSES)
    contact = settings_class.model_validate(value)
    if isinstance(contact, ContactSettingsForMeasuredMaps):
        direction = contact.direction
        if direction is None or len(contact.directions_of_motion()) > MAX_DIRECTIONS:
            raise make_key_error(
                "direction", f"must have from 1 to {MAX_DIRECTIONS} directions, got {short_repr(direction)}"
            )
        contact = contact.model_copy(update={"direction": tuple(contact.direction_angles().tolist())})
    is_profile = isinstance(surfaces, GeneratedProfileSettings)
    if (
        is_profile
        and isinstance(contact, GeneratedSurfaceContactSettings)
        and contact.direction not in (None, "+x", "-x")
    ):
        raise make_key_error("direction", f'must be "+x" or "-x" for profiles, got {short_repr(contact.direction)}')
    if isinstance(contact, AsperityModelSettings) and surfaces.is_areal:
        try:
            contact.contact_model().for_surfaces()
        except ValueError as error:
            key, _, reason = str(error).partition(" ")
            raise make_key_error(key, reason) from None
    if (
        isinstance(contact, HalfSpaceSettings)
        and contact.hardness is not None
        and not isinstance(surfaces, MeasuredSurfaceSettings)
        and not contact.loading_steps()[-1] < (max_load := float(contact.hardness) * surfaces.nominal_area)
    ):
        raise make_key_error(
            "load",
            f"must be below hardness times nominal area ({max_load:g} mN), got {contact.loading_steps()[-1]:g} mN",
        )
    return contact


def _add_loads_outside_range(given_loads: Floats, margin: float, num_loads: int) -> Floats:
    """Return the given loads (mN) and a geometric series of loads that extends below and above the given ones.

    The series has `num_loads` loads, from the smallest given load divided by `margin` to the largest times `margin`.
    Loads of the series that equal a given load are omitted.
    """
    load_series = np.geomspace(given_loads.min() / margin, given_loads.max() * margin, num_loads)
    is_new_load = np.abs(load_series[:, np.newaxis] / given_loads - 1).min(axis=1) > 1e-6
    return np.unique(np.concatenate([given_loads, load_series[is_new_load]]))


def _insert_intermediate_loads(given_loads: Floats) -> Floats:
    """Insert loads (mN) between the given loads, so that neighbouring loads differ at most by a constant factor.

    The factor is `MAX_AREAL_LOAD_RATIO`, plus 1 %.
    """
    given_loads = np.unique(given_loads)
    step_counts = np.ceil(np.log(given_loads[1:] / given_loads[:-1]) / np.log(1.01 * MAX_AREAL_LOAD_RATIO)).astype(int)
    loads_between = [
        np.geomspace(smaller_load, larger_load, count, endpoint=False)[1:]
        for smaller_load, larger_load, count in zip(given_loads[:-1], given_loads[1:], step_counts, strict=True)
    ]
    return np.concatenate([given_loads, *loads_between])


def choose_load_steps(
    loads: ArrayLike, *, press: str, mechanics: str, max_load: float | None = None, num_smaller: int = 1
) -> Floats:
    """Return the loads (mN) at which to compute a measured pair: the given loads and additional loads.

    Additional loads are between the given loads and beyond the smallest and the largest of them.

    All loads are below `max_load` (mN). For height maps, `num_smaller` loads are below the given loads, and the ratio
    of successive loads is at most `MAX_AREAL_LOAD_RATIO`.
    """
    given_loads = np.atleast_1d(float_array("loads", loads))
    if not given_loads.size or not (given_loads > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {short_repr(loads)}")
    if press == "lines" and mechanics == "asperities":
        load_steps = _add_loads_outside_range(given_loads, ASPERITY_LOAD_EXTENSION_FACTOR, NUM_ASPERITY_LOADS)
    elif press == "lines":
        load_steps = _add_loads_outside_range(given_loads, HALF_PLANE_LOAD_EXTENSION_FACTOR, NUM_HALF_PLANE_LOADS)
    else:
        smaller_loads = given_loads.min() / MAX_AREAL_LOAD_RATIO ** np.arange(1, num_smaller + 1)
        load_steps = np.unique(
            np.concatenate(
                [_insert_intermediate_loads(given_loads), smaller_loads, [given_loads.max() * MAX_AREAL_LOAD_RATIO]]
            )
        )
    requested_loads = set(given_loads.tolist())
    rounded_loads = np.array(
        [load if load in requested_loads else float(f"{load:.6g}") for load in load_steps.tolist()]
    )
    min_load, max_valid_load = VALID_QUANTITY_RANGES["force"]
    rounded_loads = rounded_loads[(min_load <= rounded_loads) & (rounded_loads <= max_valid_load)]
    return rounded_loads if max_load is None else rounded_loads[rounded_loads < max_load]
