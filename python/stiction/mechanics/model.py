"""How two bodies are pressed together: one object from a study file to the core."""

from __future__ import annotations

import inspect
import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any, Literal, TypedDict, TypeVar

import numpy as np

import stiction._core
from stiction._caching import cached_property
from stiction._checks import Floats, check_choice, number
from stiction.mechanics.law import HertzCylinder, Law, LawName, law_of
from stiction.surfaces.profile import MAX_POINTS, Profile, reject_missing
from stiction.surfaces.surface import Surface, as_body

Detection = Literal["cell", "gap-minimum"]
Curvature = Literal["convex", "signed"]
Shear = Literal["+x", "-x"]
Direction = Literal["+x", "-x"] | float
Sliding = Literal["opposing", "all"]
EFFECTIVE_MODULUS = 10.0  # GPa, of the paper
THICKNESS = 1.0  # µm, of a profile
_Function = TypeVar("_Function", bound=Callable[..., Any])
TURNED = "turned over"  # what the history of a body says that `flipped` has made
_ROUND_OFF = 1e-9  # of the height of a body, by which two that are the same may differ


@dataclass(frozen=True, kw_only=True)
class ContactModel:
    """How two bodies are pressed together: what `contacts`, `press`, `approach_at_load` and `traverse` take as `model`.

    Keywords of these functions take precedence over the model's.

    Parameters
    ----------
    effective_modulus : float, GPa
        E*, with 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2.
    law : HertzSphere, HertzCylinder or JacksonGreen, or "hertz-sphere" or "hertz-cylinder"
        What one contact carries.
        On surfaces "hertz-sphere" is the elliptic contact of Hertz; `JacksonGreen` takes the sphere of the same mean
        radius, which it was fitted to; `HertzCylinder` is refused, because the contacts are no lines.
    detection : {"cell", "gap-minimum"}, optional
        "cell" (Eq. 5): a grid point owns a contact whose centre lies in its own cell. "gap-minimum": contacts are at
        the local minima of the splined gap, which do not depend on the grid where it resolves the surfaces. By default
        "cell" for profiles, as the paper has it, and "gap-minimum" for surfaces, for which there is no other.
    curvature : {"convex", "signed"}, optional
        Whether both bodies must be convex at a contact, or one may be a wider cup. By default "convex" for profiles, as
        the paper has it, and "signed" for surfaces, where a summit rarely meets a summit.
    shear : {"+x", "-x"}
        Where the upper body is about to move.
    direction : {"+x", "-x"}, float or a sequence of these, optional
        The same for surfaces: along x, or at an angle in degrees from +x towards +y. Of a sequence, `press` computes
        all. By default that of `shear`, beside which it must not be given.
    sliding : {"opposing", "all"}
        Which contacts rub and push: those whose normal force opposes the motion, as the paper has it, or every one.

    Examples
    --------
    >>> from stiction import ContactModel, JacksonGreen
    >>> steel = ContactModel(effective_modulus=115.0, law=JacksonGreen(yield_strength=0.3, poisson_ratio=0.3))
    >>> steel.sliding
    'opposing'
    """

    effective_modulus: float = EFFECTIVE_MODULUS
    law: Law | LawName = "hertz-sphere"
    detection: Detection | None = None
    curvature: Curvature | None = None
    shear: Shear = "+x"
    direction: Direction | Sequence[Direction] | None = None
    sliding: Sliding = "opposing"

    def __post_init__(self) -> None:
        if self.detection is not None:
            check_choice("detection", self.detection, Detection)
        if self.curvature is not None:
            check_choice("curvature", self.curvature, Curvature)
        check_choice("shear", self.shear, Shear)
        check_choice("sliding", self.sliding, Sliding)
        if self.direction is not None:
            if self.shear != "+x":
                raise ValueError(f"shear and direction must not both be given, got {self.shear!r}, {self.direction!r}")
            if isinstance(self.direction, (list, tuple, range)) or np.ndim(self.direction):
                object.__setattr__(self, "direction", tuple(self.direction))  # type: ignore[arg-type]
            if not self._angles:
                raise ValueError("direction must have at least one element, got none")
        number("effective_modulus", self.effective_modulus, unit="GPa", above=0)
        self.core()

    def angles(self) -> Floats:
        """Directions in degrees from +x towards +y: () of one, (m,) of a sequence."""
        angles = np.array(self._angles)
        return angles if self._has_many_directions() else angles.reshape(())

    def directions(self) -> Floats:
        """(m, 2) horizontal unit vectors (x, y) of the directions."""
        return np.array([_unit_vector(angle) for angle in self._angles])

    def _has_many_directions(self) -> bool:
        return isinstance(self.direction, tuple)

    @cached_property
    def _angles(self) -> list[float]:
        given: Any = self.shear if self.direction is None else self.direction
        return [_angle(one) for one in given] if self._has_many_directions() else [_angle(given)]

    def for_profiles(self) -> ContactModel:
        """The model with what it leaves open as profiles have it, and along x."""
        if self._has_many_directions() or self._angles[0] not in (0.0, 180.0):
            raise ValueError(f'direction on profiles must be "+x" or "-x", got {self.direction!r}')
        return self._with(self.detection or "cell", self.curvature or "convex")

    def for_surfaces(self) -> ContactModel:
        """The model with what it leaves open as surfaces have it."""
        if self.detection == "cell":
            raise ValueError(
                'detection must be "gap-minimum" on surfaces, got "cell": the paper defines that along a line only'
            )
        if isinstance(law_of(self.law), HertzCylinder):
            raise ValueError(
                "law must not be HertzCylinder on surfaces: their contacts are ellipses, for which take HertzSphere"
            )
        return self._with("gap-minimum", self.curvature or "signed")

    def _with(self, detection: Detection, curvature: Curvature) -> ContactModel:
        if (self.detection, self.curvature) == (detection, curvature):
            return self
        return replace(self, detection=detection, curvature=curvature)

    def core(self) -> stiction._core.ContactModel:
        """The model of the core, with the first direction."""
        return self._core

    @cached_property
    def _core(self) -> stiction._core.ContactModel:
        law = law_of(self.law)
        return stiction._core.ContactModel(
            law=law.name, parameters=law.parameters(self.effective_modulus), detection=self.detection or "cell",
            curvature=self.curvature or "convex", direction=_unit_vector(self._angles[0]), sliding=self.sliding,
        )  # fmt: skip

    def __getstate__(self) -> dict[str, Any]:
        """What is pickled: all but what is made again, as the model of the core."""
        return {name: value for name, value in vars(self).items() if not name.startswith("_")}


def _angle(direction: Any) -> float:
    """Degrees from +x towards +y, from 0 to below 360."""
    if isinstance(direction, str):
        if direction not in ("+x", "-x"):
            raise ValueError(f'direction must be "+x", "-x" or an angle in degrees, got {direction!r}')
        return 0.0 if direction == "+x" else 180.0
    return number("direction", direction, unit="degrees") % 360.0


def _unit_vector(angle: float) -> tuple[float, float]:
    """Exact along the axes."""
    quarter, rest = divmod(angle, 90.0)
    x, y = math.cos(math.radians(rest)), math.sin(math.radians(rest))
    return [(x, y), (-y, x), (-x, -y), (y, -x)][int(quarter) % 4]


_DEFAULT = ContactModel()
_OF_PROFILES = _DEFAULT.for_profiles()
_OF_SURFACES = _DEFAULT.for_surfaces()


class ContactKeywords(TypedDict, total=False):
    """A contact model as keywords: the model itself, and what shall differ from it."""

    model: ContactModel
    effective_modulus: float
    law: Law | LawName
    detection: Detection | None
    curvature: Curvature | None
    shear: Shear
    direction: Direction | Sequence[Direction] | None
    sliding: Sliding


def model_of(keywords: Mapping[str, object], default: ContactModel | None = None) -> ContactModel:
    """The contact model that keywords give; what they leave open is the default's."""
    changes: dict[str, Any] = dict(keywords)
    model = changes.pop("model", default or _DEFAULT)
    if not isinstance(model, ContactModel):
        raise ValueError(f"model must be a ContactModel, got {type(model).__name__}")
    if not changes:
        return model
    if unknown := changes.keys() - ContactKeywords.__annotations__.keys():
        raise TypeError(f"unexpected keyword argument {min(unknown)!r}")
    # One of the two says where the body moves, and the one that is given replaces the other of the model.
    if "shear" in changes and changes.get("direction") is None:
        changes["direction"] = None
    elif changes.get("direction") is not None and "shear" not in changes:
        changes["shear"] = "+x"
    return replace(model, **changes)


def model_for_pair(upper: Any, lower: Any, keywords: Mapping[str, object]) -> ContactModel:
    """The contact model that keywords give for two bodies, which are checked; nothing is left open."""
    check_pair(upper, lower)
    check_modulus(keywords, upper, lower)
    if isinstance(upper, Surface):
        return model_of(keywords, _OF_SURFACES).for_surfaces()
    return model_of(keywords, _OF_PROFILES).for_profiles()


def modulus_for(effective_modulus: Any, *bodies: Profile | Surface) -> float:
    """The modulus (GPa) that is given, or that of the paper; bodies that were measured must have one of their own."""
    if effective_modulus is None:
        check_modulus({}, *bodies)
        return EFFECTIVE_MODULUS
    return number("effective_modulus", effective_modulus, unit="GPa", above=0)


def check_modulus(keywords: Mapping[str, object], *bodies: Profile | Surface) -> None:
    """Ask for a modulus, or a model that has one, where a body was measured."""
    if "effective_modulus" not in keywords and "model" not in keywords:
        refuse_no_modulus(*map(measured_source, bodies))


def refuse_no_modulus(*sources: str) -> None:
    """Ask for a modulus where there is a file that a body was read from."""
    for source in filter(None, sources):
        raise ValueError(
            f"effective_modulus (GPa) must be given, because a body was {source}: only of generated ones it is "
            f"{EFFECTIVE_MODULUS:g} GPa"
        )


def measured_source(body: Profile | Surface) -> str:
    """What the history of a body says of the file that it was read from; nothing of bodies that were generated."""
    return next((step for step in getattr(body, "history", ())[:1] if step.startswith("read from")), "")


def shows_model(function: _Function) -> _Function:
    """Let the signature of a function name the keywords of a contact model, as tooltips show it."""
    signature = inspect.signature(function)
    own = [each for each in signature.parameters.values() if each.kind is not each.VAR_KEYWORD]
    model = [inspect.Parameter("model", inspect.Parameter.KEYWORD_ONLY, default=None, annotation="ContactModel | None")]
    model += [
        inspect.Parameter(each.name, inspect.Parameter.KEYWORD_ONLY, default=each.default, annotation=each.type)
        for each in fields(ContactModel)
    ]
    function.__signature__ = signature.replace(parameters=[*own, *model])  # type: ignore[attr-defined]
    return function


def check_pair(upper: Any, lower: Any, *, whole: bool = True) -> None:
    """Two profiles or two surfaces on one grid, and whole; how many points they have is for the core to see."""
    for name, body in (("upper", upper), ("lower", lower)):
        as_body(name, body)
        if whole:
            reject_missing(body, "all but half_space")
    if isinstance(upper, Surface) != isinstance(lower, Surface):
        raise ValueError(
            f"upper and lower must both be profiles or both surfaces, got {type(upper).__name__} and "
            f"{type(lower).__name__}"
        )
    if isinstance(upper, Surface) and upper.heights.size > MAX_POINTS:
        raise ValueError(f"upper and lower must have at most {MAX_POINTS} points, got {upper.heights.size}")
    if upper.spacing != lower.spacing:
        raise ValueError(f"upper and lower must have equal spacings, got {upper.spacing!r} and {lower.spacing!r} µm")


def warn_of_one_body(upper: Profile | Surface, lower: Profile | Surface, *, moved: bool = False) -> None:
    """Warn of a body that is pressed on itself, or on its own mirror image unless it is `moved` before."""
    source, is_one = _source(upper), _source(upper) == _source(lower)
    faces = [body.history.count(TURNED) % 2 for body in (upper, lower)]
    said = ""
    if is_one and source[:1] and source[0].startswith("read from") and faces[0] == faces[1]:
        said = f"upper and lower were both {source[0]} and face the same way: press flipped(upper) on lower"
    elif upper.heights.shape != lower.heights.shape or upper.is_flat:
        return
    elif upper is lower or (is_one and source and _differ_by_a_constant(upper.heights, lower.heights)):
        said = "upper and lower are the same and fit into each other everywhere: press flipped(upper) on lower"
    elif is_one and not moved and (source or (faces[0] and isinstance(upper, Surface))):
        if _differ_by_a_constant(upper.heights, -lower.heights):
            said = (
                "upper is the mirror image of lower, whose summits meet themselves, so that their slopes cancel: move "
                "one of them, or press another piece"
            )
        elif _differ_by_a_constant(upper.heights, -lower.heights[::-1]):
            said = (
                "upper is lower turned over, so that the gap is the same on both sides of its middle row and slopes "
                "along y cancel: move one of them, or press another piece"
            )
    if said:
        warnings.warn(said, stacklevel=3)


def _source(body: Profile | Surface) -> tuple[str, ...]:
    """What a body was made from, whichever way it faces."""
    return tuple(step for step in body.history if step != TURNED)


def _differ_by_a_constant(a: Floats, b: Floats) -> bool:
    """Whether two arrays of one shape are the same but for their height; a row that is not is enough to tell."""
    allowed = _ROUND_OFF * float(np.ptp(a))
    first = np.atleast_2d(a)[0, :64] - np.atleast_2d(b)[0, :64]
    return float(np.ptp(first)) <= allowed and float(np.ptp(a - b)) <= allowed
