"""How a pair of bodies is pressed to loads, and what it has there: sums over contacts, and statistics of contacts."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array
from stiction._units import in_core_units
from stiction.mechanics.candidates import candidates
from stiction.mechanics.contact import contacts
from stiction.mechanics.friction import STATUS_OK, STATUSES
from stiction.mechanics.half_space import HalfSpaceCurve, half_space, solved, unloaded
from stiction.mechanics.load_curve import LoadCurve, press
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import ContactModel, Shear, Sliding
from stiction.mechanics.quantities import ADHESION, AREAL_SUMS, DIRECTED, DISTRIBUTIONS, SUMS, UNLOADED
from stiction.studies.contact_statistics import (
    QUANTILES,
    STATISTICS,
    Slopes,
    Table,
    asperities_of,
    on_steepest,
    patches_of,
    pressed_on_steepest,
)
from stiction.studies.contact_tables import Asperities, HalfSpace
from stiction.studies.result import Arrays, measured
from stiction.studies.study import Study
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

Load = Literal["normal", "elastic"]
Mechanics = Literal["half-space", "asperities"]

STIFFNESS_STEP = 0.02
"""The fraction of the approach on both sides of it over which the stiffness of asperities is taken."""

MPA_OVER_MM = 1e6  # in GPa/µm; a line is 1 µm thick

JUST_BEFORE = 1e-11
"""Fraction of an approach by which the one before a jump of the load is smaller: beyond the tolerance of `crossing`."""


def checked_loads(loads: ArrayLike) -> Floats:
    """Loads (mN) above 0, each once and rising."""
    values = np.unique(np.atleast_1d(float_array("loads", in_core_units("loads", loads, "force"))))
    if not values.size or not (values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {loads!r}")
    return values


UNLOADED_MEMBERS = 4
"""Members of which the stiffness of unloading is known, where there is a hardness."""


@dataclass(frozen=True, eq=False)
class Pressing:
    """How a pair of bodies is pressed to elastic loads, by whichever mechanics."""

    loads: Floats  # mN
    angles: Floats  # degrees
    rules: tuple[Sliding, ...]
    how: ContactModel | dict[str, Any]  # of asperities, or what `half_space` takes
    unloads: bool = True  # whether the stiffness of unloading is solved for, which takes a third of the time

    @classmethod
    def of(cls, study: Study, member: int = 0) -> Pressing:
        """That of a study of measured bodies; of a member of it, only the first of which unload."""
        contact = study.contact
        how = contact.model() if isinstance(contact, Asperities) else contact.solid()
        unloads = member - measured(study).first_scanned < UNLOADED_MEMBERS
        return cls(contact.steps(), contact.degrees(), contact.rules(), how, unloads)

    def pressed(self, upper: Profile | Surface, lower: Profile | Surface) -> Arrays:
        """Sums and statistics by name: (rules, directions, loads) of what depends on the motion, else (loads,)."""
        values = _Values(self, (upper, lower))
        (_by_half_space if isinstance(self.how, dict) else _by_asperities)(self, upper, lower, values)
        gradient, slope = values.slopes.of_gap(self.angles)
        return values.arrays | {"rms_gradient": np.asarray(gradient), "rms_slope": slope}

    def directed(self, upper: Profile | Surface) -> list[ContactModel]:
        """Models of every direction together, or of profiles one for each."""
        assert isinstance(self.how, ContactModel)
        if isinstance(upper, Surface):
            return [replace(self.how, direction=self.angles.tolist(), shear="+x").for_surfaces()]
        return [replace(self.how, shear=way, direction=None).for_profiles() for way in self.ways()]

    def ways(self) -> list[Shear]:
        """Directions on profiles."""
        return ["+x" if math.cos(math.radians(angle)) > 0 else "-x" for angle in self.angles]


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
            if name in UNLOADED or name == "pull_off":
                shape = self._motions if name in UNLOADED else ()
            elif name in DIRECTED:
                shape = (*self._motions, self._loads)
            elif name in DISTRIBUTIONS:
                shape = (self._loads, len(QUANTILES))
            self.arrays[name] = nothing(shape, name)
            if name == "status":
                self.arrays[name] = np.full(shape, STATUSES.index("not-solved"))
        return self.arrays[name]


def _by_half_space(pressing: Pressing, upper: Any, lower: Any, values: _Values) -> None:
    """The elastic half-space; a load without a solution leaves the others theirs."""
    assert isinstance(pressing.how, dict)
    adheres = "work_of_adhesion" in pressing.how
    names = (*_OF_HALF_SPACE, *(ADHESION[:1] if adheres else ()))
    for name in (*names, *(ADHESION[1:] if adheres else ())):
        values.of(name)
    areal = isinstance(upper, Surface)
    first: list[float] | Literal["+x"] = pressing.angles.tolist() if areal else "+x"
    solve = functools.partial(half_space, upper, lower, **pressing.how, direction=first, sliding=pressing.rules[0])
    for at, curve in solved(solve, pressing.loads):
        by_rule = _by_rule(pressing, curve, areal=areal)
        for name in names:
            if name in DIRECTED:
                values.of(name)[..., at] = _of_motions(by_rule, name)
            else:
                values.of(name)[at] = getattr(curve, name)
        values.of("status")[at] = STATUSES.index("ok")
        values.of("normal_stiffness")[at] = curve.stiffness
        values.of("closure")[at] = curve.closure
        values.of("closure_stiffness")[at] = curve.closure_stiffness * MPA_OVER_MM
        if pressing.unloads or curve.hardness is None:
            values.of("unloading_stiffness")[at] = curve.unloading_stiffness
        values.of("error")[at] = curve.error
        for place, load in enumerate(at):
            contact = curve.at(place)
            more = patches_of(contact).statistics() | pressed_on_steepest(contact, values.slopes)
            for name, value in more.items():
                values.of(name)[load] = value

    if adheres:
        held, values.of("pull_off")[...] = unloaded(solve)
        if held is not None:
            by_rule = _by_rule(pressing, held, areal=areal)
            for name in UNLOADED:
                values.of(name)[...] = _of_motions(by_rule, sliding_sum(name))[..., 0]


def sliding_sum(name: str) -> str:
    """The sum at each load that a name of `UNLOADED` is at none."""
    return name.replace("unloaded", "tangential")


def _by_rule(pressing: Pressing, curve: HalfSpaceCurve, *, areal: bool) -> list[list[HalfSpaceCurve]]:
    """A curve by every rule, and of lines in every direction."""
    ways = [curve]
    if not areal:  # the curve is that of +x
        ways = [curve if way == "+x" else curve.with_direction(way) for way in pressing.ways()]
    rules = enumerate(pressing.rules)
    return [[way if rule == 0 else way.with_sliding(sliding) for way in ways] for rule, sliding in rules]


def _of_motions(by_rule: list[list[HalfSpaceCurve]], name: str) -> Floats:
    """A sum over rules, directions and loads."""
    return np.stack([np.concatenate([np.atleast_2d(getattr(way, name)) for way in ways]) for ways in by_rule])


_OF_HALF_SPACE = (
    "contact_count", "contact_area", "normal_elastic", "tangential_elastic", "normal_frictional",
    "tangential_frictional", "normal_adhesive", "tangential_adhesive", "approach", "load_share_at_hardness",
    "area_share_at_hardness",
)  # fmt: skip


def _by_asperities(pressing: Pressing, upper: Any, lower: Any, values: _Values) -> None:
    """Hertz contacts that do not feel each other, at the approaches that carry the elastic loads.

    Where the load jumps with the approach, as it does by cells, sums are in proportion between before and behind it.
    """
    models = pressing.directed(upper)
    one = models[0] if isinstance(upper, Profile) else replace(models[0], direction=0.0)
    # Without friction F_N is the elastic load.
    approach, status = crossing(Bodies(upper, lower), pressing.loads, mu0=0.0, tau0=0.0, model=one)
    values.of("status")[:] = [STATUSES.index(each) for each in status.tolist()]
    ok = np.flatnonzero(status == STATUS_OK)
    # Contacts by minima of the gap begin without a load, so that nothing jumps.
    fractions = [1 - STIFFNESS_STEP, 1 - JUST_BEFORE * (one.detection == "cell"), 1, 1 + STIFFNESS_STEP]
    steps, place = np.unique(np.outer(fractions, approach[ok]), return_inverse=True)
    low, before, at, high = place.reshape(len(fractions), ok.size)
    if not ok.size:
        steps = np.zeros(1)  # for the names of the sums
    bodies = found_once(upper, lower, float(steps[-1]), one)
    pressed: Any = functools.partial(press, *bodies)
    listed: Any = functools.partial(contacts, *bodies)

    def read(name: str, curve: Any) -> Floats:
        normal, sums = curve.normal_elastic, getattr(curve, name)
        jump, rise = normal[at] - normal[before], pressing.loads[ok] - normal[before]
        share = np.clip(np.divide(rise, jump, out=np.ones(ok.size), where=jump > 0), 0, 1)
        there = sums[..., before] + share * (sums[..., at] - sums[..., before])
        return np.asarray(np.rint(there) if name.endswith("_count") else there)

    for rule, sliding in enumerate(pressing.rules):
        curves: list[Any] = [pressed(steps, model=replace(model, sliding=sliding)) for model in models]
        for name in _SUMS_OF_CURVES & {each for each in vars(curves[0]) if not each.startswith("_")}:
            if name in DIRECTED:
                for way, curve in enumerate(curves if len(curves) > 1 else [curves[0]]):
                    target = values.of(name)[rule] if isinstance(upper, Surface) else values.of(name)[rule, way]
                    target[..., ok] = read(name, curve)
            else:
                values.of(name)[ok] = read(name, curves[0])
    values.of("approach")[ok] = approach[ok]
    if not ok.size:
        return
    normal = curves[0].normal_elastic
    values.of("closure")[ok] = approach[ok]
    stiffness = (normal[high] - normal[low]) / (steps[high] - steps[low])
    values.of("normal_stiffness")[ok] = stiffness
    values.of("closure_stiffness")[ok] = stiffness / math.prod(values.extent) * MPA_OVER_MM
    for load in ok:
        table = asperities_of(listed(float(approach[load]), model=one), values.spacing, values.extent)
        for name, value in (table.statistics() | on_steepest(table, values.slopes)).items():
            values.of(name)[load] = value


_SUMS_OF_CURVES = {*SUMS, *AREAL_SUMS}


def nothing(shape: tuple[int, ...], name: str) -> NDArray[Any]:
    """An array of what has no answer."""
    return np.zeros(shape, np.int64) if name.endswith("_count") else np.full(shape, np.nan)


def found_once(upper: Any, lower: Any, deepest: float, model: ContactModel) -> tuple[Any, ...]:
    """What `press` takes: candidates up to an approach (µm) where contacts are minima of the gap, else both bodies."""
    if model.detection != "gap-minimum":
        return upper, lower
    return (candidates(upper, lower, deepest=deepest, curvature=model.curvature),)


# ---- At one load ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class OneLoad:
    """A pair under one elastic load."""

    upper: Any
    lower: Any
    curve: HalfSpaceCurve | LoadCurve  # of this load alone, pushed along +x
    model: ContactModel | None = None  # how asperities were pressed

    @classmethod
    def of(cls, study: Study, pair: tuple[Any, Any], load: float) -> OneLoad | None:
        """The pair pressed as its study says, to a load (mN); None where it has no answer."""
        upper, lower = pair
        contact = study.contact
        if isinstance(contact, HalfSpace):
            try:
                curve = half_space(upper, lower, [load], **contact.solid(), sliding="all")
            except RuntimeError:
                return None
            return cls(upper, lower, curve)
        model = replace(contact.model(), shear="+x", direction=None, sliding="all")
        model = model.for_profiles() if isinstance(upper, Profile) else replace(model, direction=0.0).for_surfaces()
        approach, status = crossing(Bodies(upper, lower), np.array([load]), mu0=0.0, tau0=0.0, model=model)
        if status[0] != STATUS_OK:
            return None
        bodies: Any = found_once(upper, lower, float(approach[0]), model)
        pushed: LoadCurve = press(*bodies, approach, model=model)  # type: ignore[call-overload]
        return cls(upper, lower, pushed, model=model)

    def table(self) -> Table:
        """The contacts, one row each."""
        if isinstance(self.curve, HalfSpaceCurve):
            return patches_of(self.curve.at(0))
        spacing = (self.lower.spacing,) if isinstance(self.lower, Profile) else self.lower.spacing
        extent = (self.lower.extent,) if isinstance(self.lower, Profile) else self.lower.extent
        assert self.model is not None
        touching = contacts(self.upper, self.lower, float(self.curve.approach[0]), model=self.model)
        return asperities_of(touching, spacing, extent)

    def pressure(self) -> Floats | None:
        """GPa, over the grid of a half-space; None of asperities."""
        if not isinstance(self.curve, HalfSpaceCurve):
            return None
        pressed = self.curve.at(0)
        return pressed.on_grid(pressed.values)

    def patches(self) -> NDArray[Any]:
        """Numbers of the patches, from 1 on, over the grid of a half-space."""
        assert isinstance(self.curve, HalfSpaceCurve)
        pressed = self.curve.at(0)
        return pressed.on_grid(pressed.patch)
