"""How a pair of bodies is pressed to loads, and what it has there: sums over contacts, and statistics of contacts."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array
from stiction._units import in_core_units
from stiction.mechanics.candidates import candidates
from stiction.mechanics.contact import contacts
from stiction.mechanics.friction import STATUS_OK, STATUSES
from stiction.mechanics.half_space import Boundary, HalfSpaceCurve, half_space
from stiction.mechanics.load_curve import press
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import ContactModel, Sliding
from stiction.mechanics.quantities import AREAL_SUMS, DIRECTED, DISTRIBUTIONS, SUMS
from stiction.studies.contact_statistics import (
    QUANTILES,
    STATISTICS,
    Slopes,
    asperities_of,
    on_steepest,
    patches_of,
    pressed_on_steepest,
)
from stiction.studies.contact_tables import ByAsperities
from stiction.studies.result import Arrays
from stiction.studies.study import Study
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

Load = Literal["normal", "elastic"]
Mechanics = Literal["half-space", "asperities"]

STIFFNESS_STEP = 0.02
"""The fraction of the approach on both sides of it over which the stiffness of asperities is taken."""


def checked_loads(loads: ArrayLike) -> Floats:
    """Loads (mN) above 0, each once and rising."""
    values = np.unique(np.atleast_1d(float_array("loads", in_core_units("loads", loads, "force"))))
    if not values.size or not (values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {loads!r}")
    return values


@dataclass(frozen=True, eq=False)
class Pressing:
    """How a pair of bodies is pressed to elastic loads, by whichever mechanics."""

    mechanics: Mechanics
    loads: Floats  # mN
    angles: Floats  # degrees
    rules: tuple[Sliding, ...]
    model: ContactModel  # modulus, and of asperities law, detection and curvature
    compliance_share: float = 0.5  # this and what follows: of the half-space
    hardness: float | None = None
    boundary: Boundary = "free"

    @classmethod
    def of(cls, study: Study) -> Pressing:
        """That of a study of measured bodies."""
        contact = study.contact
        common: dict[str, Any] = {
            "mechanics": contact.mechanics, "loads": contact.steps(), "angles": contact.degrees(),
            "rules": contact.rules(),
        }  # fmt: skip
        if isinstance(contact, ByAsperities):
            return cls(**common, model=contact.model())
        solid = contact.solid()
        return cls(**common, model=ContactModel(effective_modulus=solid.pop("effective_modulus")), **solid)

    def pressed(self, upper: Profile | Surface, lower: Profile | Surface) -> Arrays:
        """Sums and statistics by name: (rules, directions, loads) of what depends on the motion, else (loads,)."""
        values = _Values(self, (upper, lower))
        (_by_half_space if self.mechanics == "half-space" else _by_asperities)(self, upper, lower, values)
        gradient, slope = values.slopes.of_gap(self.angles)
        return values.arrays | {"rms_gradient": np.asarray(gradient), "rms_slope": slope}

    def directed(self, upper: Profile | Surface) -> list[ContactModel]:
        """Models of every direction together, or of profiles one for each."""
        if isinstance(upper, Surface):
            return [replace(self.model, direction=self.angles.tolist(), shear="+x").for_surfaces()]
        return [
            replace(
                self.model, shear="+x" if math.cos(math.radians(angle)) > 0 else "-x", direction=None
            ).for_profiles()
            for angle in self.angles
        ]


class _Values:
    """Arrays of a pressed pair, NaN where nothing is filled in."""

    def __init__(self, pressing: Pressing, pair: tuple[Any, Any]) -> None:
        self.arrays: Arrays = {}
        self.slopes = Slopes.of(*pair)
        self._loads, self._motions = pressing.loads.size, (len(pressing.rules), pressing.angles.size)
        upper = pair[0]
        self.spacing = (upper.spacing,) if isinstance(upper, Profile) else upper.spacing
        self.extent = (upper.extent,) if isinstance(upper, Profile) else upper.extent
        for name in (*STATISTICS, *DISTRIBUTIONS, "status"):
            self.of(name)

    def of(self, name: str) -> NDArray[Any]:
        """The array of a quantity."""
        if name not in self.arrays:
            shape: tuple[int, ...] = (self._loads,)
            if name in DIRECTED:
                shape = (*self._motions, self._loads)
            elif name in DISTRIBUTIONS:
                shape = (self._loads, len(QUANTILES))
            self.arrays[name] = nothing(shape, name)
            if name == "status":
                self.arrays[name] = np.full(shape, STATUSES.index("not-solved"))
        return self.arrays[name]


def _by_half_space(pressing: Pressing, upper: Any, lower: Any, values: _Values) -> None:
    """The elastic half-space; a load without a solution leaves the others theirs."""
    for name in _OF_HALF_SPACE:
        values.of(name)
    areal = isinstance(upper, Surface)
    first: list[float] | Literal["+x"] = pressing.angles.tolist() if areal else "+x"
    solve = functools.partial(
        half_space, upper, lower, effective_modulus=float(pressing.model.effective_modulus),
        compliance_share=pressing.compliance_share, hardness=pressing.hardness, boundary=pressing.boundary,
        direction=first, sliding=pressing.rules[0],
    )  # fmt: skip
    for at, curve in solved(solve, pressing.loads):
        for rule, sliding in enumerate(pressing.rules):
            by_rule = curve if rule == 0 else curve.with_sliding(sliding)
            for name in _OF_HALF_SPACE:
                if name not in DIRECTED:
                    values.of(name)[at] = getattr(curve, name)
                elif areal:
                    values.of(name)[rule][:, at] = getattr(by_rule, name)
                else:
                    for way, angle in enumerate(pressing.angles):
                        towards = by_rule.with_direction("+x" if math.cos(math.radians(angle)) > 0 else "-x")
                        values.of(name)[rule, way, at] = getattr(towards, name)
        values.of("status")[at] = STATUSES.index("ok")
        values.of("normal_stiffness")[at] = curve.stiffness
        values.of("error")[at] = curve.error
        for place, load in enumerate(at):
            contact = curve.at(place)
            more = patches_of(contact).statistics() | pressed_on_steepest(contact, values.slopes)
            for name, value in more.items():
                values.of(name)[load] = value


_OF_HALF_SPACE = (
    "contact_count", "contact_area", "normal_elastic", "tangential_elastic", "normal_frictional",
    "tangential_frictional", "normal_adhesive", "tangential_adhesive", "approach", "load_share_at_hardness",
    "area_share_at_hardness",
)  # fmt: skip


def _by_asperities(pressing: Pressing, upper: Any, lower: Any, values: _Values) -> None:
    """Hertz contacts that do not feel each other, at the approaches that carry the elastic loads."""
    models = pressing.directed(upper)
    one = models[0] if isinstance(upper, Profile) else replace(models[0], direction=0.0)
    # Without friction F_N is the elastic load.
    approach, status = crossing(Bodies(upper, lower), pressing.loads, mu0=0.0, tau0=0.0, model=one)
    values.of("status")[:] = [STATUSES.index(each) for each in status.tolist()]
    ok = np.flatnonzero(status == STATUS_OK)
    fractions = [1 - STIFFNESS_STEP, 1, 1 + STIFFNESS_STEP]
    steps, place = np.unique(np.outer(fractions, approach[ok]), return_inverse=True)
    low, at, high = place.reshape(len(fractions), ok.size)
    if not ok.size:
        steps = np.zeros(1)  # for the names of the sums
    found = None
    if one.detection == "gap-minimum":
        found = candidates(upper, lower, deepest=float(steps[-1]), curvature=one.curvature)
    bodies = (upper, lower) if found is None else (found,)
    pressed: Any = functools.partial(press, *bodies)
    listed: Any = functools.partial(contacts, *bodies)
    for rule, sliding in enumerate(pressing.rules):
        curves: list[Any] = [pressed(steps, model=replace(model, sliding=sliding)) for model in models]
        for name in _SUMS_OF_CURVES & {each for each in vars(curves[0]) if not each.startswith("_")}:
            if name in DIRECTED:
                for way, curve in enumerate(curves if len(curves) > 1 else [curves[0]]):
                    target = values.of(name)[rule] if isinstance(upper, Surface) else values.of(name)[rule, way]
                    target[..., ok] = getattr(curve, name)[..., at]
            else:
                values.of(name)[ok] = getattr(curves[0], name)[at]
    values.of("approach")[ok] = approach[ok]
    if not ok.size:
        return
    normal = curves[0].normal_elastic
    values.of("normal_stiffness")[ok] = (normal[high] - normal[low]) / (steps[high] - steps[low])
    for load in ok:
        table = asperities_of(listed(float(approach[load]), model=one), values.spacing, values.extent)
        for name, value in (table.statistics() | on_steepest(table, values.slopes)).items():
            values.of(name)[load] = value


_SUMS_OF_CURVES = {*SUMS, *AREAL_SUMS}


def nothing(shape: tuple[int, ...], name: str) -> NDArray[Any]:
    """An array of what has no answer."""
    return np.zeros(shape, np.int64) if name.endswith("_count") else np.full(shape, np.nan)


def solved(solve: Callable[[Floats], HalfSpaceCurve], loads: Floats) -> list[tuple[NDArray[np.intp], HalfSpaceCurve]]:
    """The curves of a half-space and which loads are theirs; a load without a solution is in none."""
    try:
        return [(np.arange(loads.size), solve(loads))]
    except RuntimeError:
        curves = []
        for index in range(loads.size):
            try:
                curves.append((np.array([index]), solve(loads[index : index + 1])))
            except RuntimeError:
                continue
        return curves
