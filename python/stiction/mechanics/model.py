"""Contact model: the parameters of a contact calculation, which the C++ core receives as one object."""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypedDict, TypeVar

import numpy as np

import stiction._core
from stiction._caching import cached_property
from stiction._checks import Floats, check_choice, check_instance, validate_number
from stiction._units import short_repr
from stiction._warnings import warn_caller
from stiction.mechanics.law import ContactLaw, HertzCylinder, LawName, parse_contact_law
from stiction.surfaces.preparation import count_flips, list_history_without_flips
from stiction.surfaces.profile import MAX_POINTS, Profile, reject_missing_points
from stiction.surfaces.surface import Surface, as_body

DetectionMethod = Literal["cell", "gap-minimum"]
CurvatureRequirement = Literal["convex", "signed"]
ShearDirection = Literal["+x", "-x"]
Direction = Literal["+x", "-x"] | float
SlidingRule = Literal["opposing", "all"]
# Effective modulus (GPa) that Hanaor, Gan and Einav (2016) assume for all surfaces.
DEFAULT_EFFECTIVE_MODULUS = 10.0
PROFILE_WIDTH = 1.0  # µm
_Function = TypeVar("_Function", bound=Callable[..., Any])
_SAME_HEIGHT_TOLERANCE = 1e-9


@dataclass(frozen=True, kw_only=True)
class ContactModel:
    """Parameters of a contact calculation: the argument `model` of `contacts`, `press` and `approach_at_load`.

    Keyword arguments of these functions take precedence over the model.

    Parameters
    ----------
    effective_modulus : float, GPa
        E*, with 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2.
    law : HertzSphere, HertzCylinder or JacksonGreen, or "hertz-sphere" or "hertz-cylinder"
        Law of a single contact. On surfaces "hertz-sphere" is the elliptic Hertz contact. `JacksonGreen`, which
        was fitted to spheres, uses the geometric mean of the principal radii. `HertzCylinder` is rejected, because
        contacts are not lines.
    detection : {"cell", "gap-minimum"}, optional
        "cell" (Eq. 5): a grid point has a contact if the contact's centre lies in its cell. "gap-minimum": contacts are
        at the local minima of the splined gap, which do not depend on the grid if it resolves the surfaces. The default
        is "cell" for profiles, as in the paper, and "gap-minimum" for surfaces, for which it is the only choice.
    curvature : {"convex", "signed"}, optional
        With "convex", both surfaces must be convex at a contact; with "signed", only their gap. The default is "convex"
        for profiles, as in the paper, and "signed" for surfaces, where summits rarely meet summits.
    shear : {"+x", "-x"}
        Direction in which the upper surface is about to move.
    direction : {"+x", "-x"}, float or a sequence of these, optional
        Direction for surfaces: along x, or an angle in degrees from +x towards +y. `press` computes all directions of a
        sequence. By default the direction is taken from `shear`; only one of the two may be given.
    sliding : {"opposing", "all"}
        Contacts with friction: only contacts whose normal force opposes the motion, as in the paper, or all contacts.

    Examples
    --------
    >>> from stiction import ContactModel, JacksonGreen
    >>> steel = ContactModel(effective_modulus=115.0, law=JacksonGreen(yield_strength=0.3, poisson_ratio=0.3))
    >>> steel.sliding
    'opposing'
    """

    effective_modulus: float = DEFAULT_EFFECTIVE_MODULUS
    law: ContactLaw | LawName = "hertz-sphere"
    detection: DetectionMethod | None = None
    curvature: CurvatureRequirement | None = None
    shear: ShearDirection = "+x"
    direction: Direction | Sequence[Direction] | None = None
    sliding: SlidingRule = "opposing"

    def __post_init__(self) -> None:
        if self.detection is not None:
            check_choice("detection", self.detection, DetectionMethod)
        if self.curvature is not None:
            check_choice("curvature", self.curvature, CurvatureRequirement)
        check_choice("shear", self.shear, ShearDirection)
        check_choice("sliding", self.sliding, SlidingRule)
        if self.direction is not None:
            if self.shear != "+x":
                raise ValueError(
                    "shear and direction must not both be given, "
                    f"got {short_repr(self.shear)}, {short_repr(self.direction)}"
                )
            if isinstance(self.direction, (list, tuple, range)) or np.ndim(self.direction):
                object.__setattr__(self, "direction", tuple(self.direction))  # type: ignore[arg-type]
            if not self._direction_angles:
                raise ValueError("direction must have at least one element, got none")
        object.__setattr__(
            self, "effective_modulus", validate_number("effective_modulus", self.effective_modulus, unit="GPa", above=0)
        )
        self.core()

    def angles(self) -> Floats:
        """Return the directions of motion of the upper surface in degrees from +x towards +y.

        The shape is () for one direction and (m,) for a sequence.
        """
        angles = np.array(self._direction_angles)
        return angles if self._has_many_directions() else angles.reshape(())

    def directions(self) -> Floats:
        """Return the m directions of motion of the upper surface as unit vectors (x, y), with shape (m, 2)."""
        return np.array([_unit_vector(angle) for angle in self._direction_angles])

    def _has_many_directions(self) -> bool:
        return isinstance(self.direction, tuple)

    @cached_property
    def _direction_angles(self) -> list[float]:
        direction_value: Any = self.shear if self.direction is None else self.direction
        return (
            [_parse_angle(value) for value in direction_value]
            if self._has_many_directions()
            else [_parse_angle(direction_value)]
        )

    def for_profiles(self) -> ContactModel:
        """Return the model with unset parameters replaced by the defaults for profiles.

        Raise a `ValueError` if its direction is not along x.
        """
        if self._has_many_directions() or self._direction_angles[0] not in (0.0, 180.0):
            raise ValueError(f'direction for profiles must be "+x" or "-x", got {short_repr(self.direction)}')
        return self._with_default_detection_and_curvature(self.detection or "cell", self.curvature or "convex")

    def for_surfaces(self) -> ContactModel:
        """Return the model with unset parameters replaced by the defaults for surfaces.

        Raise a `ValueError` if the model is for profiles only.
        """
        if self.detection == "cell":
            raise ValueError(
                'detection must be "gap-minimum" on surfaces, got "cell", which is defined only on profiles'
            )
        if isinstance(parse_contact_law(self.law), HertzCylinder):
            raise ValueError(
                "law must not be HertzCylinder on surfaces, because their contacts are ellipses; use HertzSphere"
            )
        return self._with_default_detection_and_curvature("gap-minimum", self.curvature or "signed")

    def _with_default_detection_and_curvature(
        self, detection: DetectionMethod, curvature: CurvatureRequirement
    ) -> ContactModel:
        if (self.detection, self.curvature) == (detection, curvature):
            return self
        return replace(self, detection=detection, curvature=curvature)

    def core(self) -> stiction._core.ContactModel:
        """Return the model as an object of the C++ core, with only the first direction of motion."""
        return self._core

    @cached_property
    def _core(self) -> stiction._core.ContactModel:
        law = parse_contact_law(self.law)
        return stiction._core.ContactModel(
            law=law.name, parameters=law.parameters(self.effective_modulus), detection=self.detection or "cell",
            curvature=self.curvature or "convex", direction=_unit_vector(self._direction_angles[0]),
            sliding=self.sliding,
        )  # fmt: skip

    def __getstate__(self) -> dict[str, Any]:
        """Return the state for pickling: all parameters, without the cached object of the C++ core."""
        return {name: value for name, value in vars(self).items() if not name.startswith("_")}


def _parse_angle(direction: Any) -> float:
    """Parse a direction of motion, and return its angle from +x towards +y, from 0 to below 360 degrees."""
    if isinstance(direction, str):
        if direction not in ("+x", "-x"):
            raise ValueError(f'direction must be "+x", "-x" or an angle in degrees, got {short_repr(direction)}')
        return 0.0 if direction == "+x" else 180.0
    return validate_number("direction", direction, unit="degrees") % 360.0


def _unit_vector(angle: float) -> tuple[float, float]:
    """Return the unit vector at an angle (degrees), with exact components at multiples of 90 degrees."""
    quarter_turns, remaining_angle = divmod(angle, 90.0)
    x, y = math.cos(math.radians(remaining_angle)), math.sin(math.radians(remaining_angle))
    return [(x, y), (-y, x), (-x, -y), (y, -x)][int(quarter_turns) % 4]


_DEFAULT_MODEL = ContactModel()
_DEFAULT_PROFILE_MODEL = _DEFAULT_MODEL.for_profiles()
_DEFAULT_SURFACE_MODEL = _DEFAULT_MODEL.for_surfaces()


class ContactModelArguments(TypedDict, total=False):
    """Keyword arguments of functions that compute contacts: `model`, and parameters that override those of `model`."""

    model: ContactModel
    effective_modulus: float
    law: ContactLaw | LawName
    detection: DetectionMethod | None
    curvature: CurvatureRequirement | None
    shear: ShearDirection
    direction: Direction | Sequence[Direction] | None
    sliding: SlidingRule


def make_model(keywords: Mapping[str, object], default: ContactModel | None = None) -> ContactModel:
    """Create a contact model from keyword arguments.

    Parameters that are not given have the values of the default model.
    """
    parameters: dict[str, Any] = dict(keywords)
    model: ContactModel = parameters.pop("model", default or _DEFAULT_MODEL)
    check_instance("model", model, ContactModel, "a ContactModel")
    if not parameters:
        return model
    if unknown_keywords := parameters.keys() - ContactModelArguments.__annotations__.keys():
        raise TypeError(f"a contact model has no parameter {min(unknown_keywords)!r}")
    # Both `shear` and `direction` specify the direction of motion, so giving one resets the other.
    if "shear" in parameters and parameters.get("direction") is None:
        parameters["direction"] = None
    elif parameters.get("direction") is not None and "shear" not in parameters:
        parameters["shear"] = "+x"
    return replace(model, **parameters)


def make_pair_model(upper: Any, lower: Any, keywords: Mapping[str, object]) -> ContactModel:
    """Check two surfaces, and create their contact model from keyword arguments and defaults.

    The defaults depend on the type of the surfaces.
    """
    check_pair(upper, lower)
    check_modulus_is_given(keywords, upper, lower)
    if isinstance(upper, Surface):
        return make_model(keywords, _DEFAULT_SURFACE_MODEL).for_surfaces()
    return make_model(keywords, _DEFAULT_PROFILE_MODEL).for_profiles()


def modulus_or_default(effective_modulus: Any, *bodies: Profile | Surface) -> float:
    """Return the given effective modulus (GPa), or the default modulus for generated surfaces if None is given.

    The default is the modulus of the paper. For measured surfaces, a modulus is required.
    """
    if effective_modulus is None:
        check_modulus_is_given({}, *bodies)
        return DEFAULT_EFFECTIVE_MODULUS
    return validate_number("effective_modulus", effective_modulus, unit="GPa", above=0)


def check_modulus_is_given(keywords: Mapping[str, object], *bodies: Profile | Surface) -> None:
    """Raise a `ValueError` if a surface from a file has neither an effective modulus nor a contact model."""
    if "effective_modulus" not in keywords and "model" not in keywords:
        reject_missing_modulus(*map(source_history_entry, bodies))


def reject_missing_modulus(*sources: str) -> None:
    """Raise a `ValueError` if a body was measured, because measured bodies require an `effective_modulus`.

    `sources` contains the files of measured bodies.
    """
    for source in filter(None, sources):
        raise ValueError(
            f"effective_modulus (GPa) must be given, because a body was {source}; the default "
            f"{DEFAULT_EFFECTIVE_MODULUS:g} GPa is for generated bodies"
        )


def source_history_entry(body: Profile | Surface) -> str:
    """Return the history entry "read from FILE" of a measured body.

    Returns "" if the body was generated.
    """
    return next((step for step in getattr(body, "history", ())[:1] if step.startswith("read from")), "")


def add_model_keywords_to_signature(function: _Function) -> _Function:
    """Add the parameters of `ContactModel` to a function's signature, so that tooltips list these parameters."""
    signature = inspect.signature(function)
    parameters = [
        parameter for parameter in signature.parameters.values() if parameter.kind is not parameter.VAR_KEYWORD
    ]
    model_parameter = [
        inspect.Parameter("model", inspect.Parameter.KEYWORD_ONLY, default=None, annotation="ContactModel | None")
    ]
    model_parameter += [
        inspect.Parameter(field.name, inspect.Parameter.KEYWORD_ONLY, default=field.default, annotation=field.type)
        for field in fields(ContactModel)
    ]
    function.__signature__ = signature.replace(parameters=[*parameters, *model_parameter])  # type: ignore[attr-defined]
    return function


def check_pair(upper: Any, lower: Any, *, whole: bool = True) -> None:
    """Check that two bodies have equal types and spacings. If `whole` is True, reject missing points."""
    for name, body in (("upper", upper), ("lower", lower)):
        as_body(name, body)
        if whole:
            reject_missing_points(body, "every model except half_space")
    if isinstance(upper, Surface) != isinstance(lower, Surface):
        raise ValueError(
            f"the upper and the lower body must both be profiles or both surfaces, got {type(upper).__name__} and "
            f"{type(lower).__name__}"
        )
    if isinstance(upper, Surface) and upper.heights.size > MAX_POINTS:
        raise ValueError(f"each surface must have at most {MAX_POINTS} points, got {upper.heights.size}")
    if upper.spacing != lower.spacing:
        raise ValueError(
            f"the upper and the lower body must have equal spacings, got {upper.spacing} and {lower.spacing} µm"
        )


def warn_if_same_body(upper: Profile | Surface, lower: Profile | Surface) -> None:
    """Warn if the upper surface of a pair equals the lower surface or its mirror image."""
    upper_history, lower_history = map(list_history_without_flips, (upper, lower))
    is_same = upper_history == lower_history
    flip_parities = [count_flips(body) % 2 for body in (upper, lower)]
    message = ""
    if (
        is_same
        and upper_history[:1]
        and upper_history[0].startswith("read from")
        and flip_parities[0] == flip_parities[1]
    ):
        message = f"upper and lower were both {upper_history[0]} and face the same way: press flipped(upper) on lower"
    elif upper.heights.shape != lower.heights.shape or upper.is_flat:
        return
    elif upper is lower or (is_same and upper_history and _differ_by_a_constant(upper.heights, lower.heights)):
        message = "upper and lower are the same and fit into each other everywhere: press flipped(upper) on lower"
    elif is_same and (upper_history or (flip_parities[0] and isinstance(upper, Surface))):
        if _differ_by_a_constant(upper.heights, -lower.heights):
            message = (
                "upper is the mirror image of lower: each summit meets its image, so the slopes cancel; move "
                "one of the surfaces, or press another piece"
            )
        elif _differ_by_a_constant(upper.heights, -lower.heights[::-1]):
            message = (
                "upper is a flipped copy of lower, so the gap is the same on both sides of its middle row, and slopes "
                "along y cancel; move one of the surfaces, or press another piece"
            )
    if message:
        warn_caller(message)


def _differ_by_a_constant(a: Floats, b: Floats) -> bool:
    """Return True if two arrays differ only by a constant.

    To save time, a few points are compared before the rest.
    """
    tolerance = _SAME_HEIGHT_TOLERANCE * float(np.ptp(a))
    first_differences = np.atleast_2d(a)[0, :64] - np.atleast_2d(b)[0, :64]
    return float(np.ptp(first_differences)) <= tolerance and float(np.ptp(a - b)) <= tolerance
