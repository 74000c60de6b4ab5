"""One member of a study pressed together: sums and statistics at every step, along every direction, by every rule."""

from __future__ import annotations

import functools
import math
import threading
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

import stiction._core as _core
from stiction._checks import Floats, read_only
from stiction.mechanics.candidates import candidates
from stiction.mechanics.half_space import HalfSpaceCurve, half_space, solved, unloaded
from stiction.mechanics.load_curve import LoadCurve, press
from stiction.mechanics.model import ContactModel
from stiction.mechanics.quantities import DIRECTED, ONSET, UNLOADED
from stiction.studies.contact_tables import Asperities, HalfSpace
from stiction.studies.members import (
    FAMILY_MEMORY,
    ProfileGenerator,
    bodies_of,
    points_of_member,
    scaled_surface,
    unscaled_surface,
)
from stiction.studies.pressing import Pressing, nothing, sliding_sum
from stiction.studies.result import Arrays, generated, names_of, profiles, variables_of
from stiction.studies.study import Study
from stiction.surfaces.pairing import SIDES
from stiction.surfaces.profile import Profile, scaled_profile
from stiction.surfaces.surface import Surface

CACHE_LINE = 64  # bytes
HALF = 0.5  # of the sliding load, at which a result says what slips

COSTS = {
    "onset": 1e-3, "profile": 1.1e-8, "asperities": 3e-8, "point": 1.35e-7, "area": 2e-3, "line": 3.6e-4,
    "half-space": 1e-3, "half-plane": 8e-4,
}  # fmt: skip
"""Seconds of one core, roughly: of an onset of sliding; of a point of a generated profile and of a generated area; of
a point of a measured area, and of a load on that and on a measured line, all as asperities; and of a load on a
half-space and a half-plane besides its solution. They decide how many members are a block."""

SOLUTION = {False: 6e-8, True: 1.3e-8}  # seconds of one core of a solution of lines and areas over points^(5/4)
REPEATED, PARTING = 5, 25  # solutions of a contact with adhesion, and contacts on the way to the pull-off force
_kept = threading.local()


def member_sums(study: Study, index: int) -> Arrays:
    """Every variable of a result as an array without the dimension of members, of one member of its study.

    Of measured bodies also what the member is, as `OF_MEMBERS` lists it. A load that has no solution is NaN. Raises a
    `ValueError` if the bodies cannot be made.
    """
    arrays: Arrays = {name: np.empty(shape, dtype) for name, (shape, dtype) in arrays_of(study).items()}
    for place, part in _measured(study, index, arrays) if study.is_measured else _generated(study, index):
        for name, values in part.items():
            arrays[name][place] = values.reshape(arrays[name][place].shape)
    return arrays


@functools.lru_cache(maxsize=4)
def arrays_of(study: Study) -> dict[str, tuple[tuple[int, ...], np.dtype[Any]]]:
    """Shape and kind of each variable of a member."""
    cells = len(study.surfaces.cells())
    return {
        name: ((*each.shape[:cells], *each.shape[cells + 1 :]), each.dtype)
        for name, each in variables_of(study, [0]).items()
    }


def cost_of_member(study: Study) -> float:
    """A rough estimate of the seconds that a member takes on one core, whatever the number of members."""
    cells = math.prod(values.size for values in study.surfaces.cells().values())
    loads = study.contact.steps().size
    points, areal = points_of_member(study), study.is_areal
    if study.by_half_space:
        if study.contact.adheres:
            loads = REPEATED * (loads + PARTING)
        return (
            cells * loads * (COSTS["half-space" if areal else "half-plane"] + SOLUTION[areal] * math.pow(points, 1.25))
        )
    if study.is_measured:
        return cells * (COSTS["area"] * loads + COSTS["point"] * points if areal else COSTS["line"] * loads)
    onsets = cells * loads * COSTS["onset"] if study.contact.onset else 0.0
    return cells * points * COSTS["asperities" if study.is_areal else "profile"] + onsets + 1e-4


# ---- Generated bodies ------------------------------------------------------------------------------------------------


def _generated(study: Study, repetition: int) -> Iterator[tuple[Any, Arrays]]:
    """Parts of a repetition with their places among the cells."""
    if not (study.is_areal or study.by_half_space or study.contact.onset):
        for place, uppers, lowers, scratch in _families(study, repetition):
            yield place, pressed_families(study, uppers, lowers, scratch)
        return
    pairs = (_surfaces if study.is_areal else _profiles)(study, repetition)
    for cell, upper, lower in pairs:
        yield cell, pressed(study, upper, lower)


def pressed(study: Study, upper: Profile | Surface, lower: Profile | Surface) -> Arrays:
    """Each sum of a study as an array (steps,), or of those that depend on the motion ([rules], [directions], steps).

    A load that the half-space has no solution of is NaN, with no contacts.
    """
    names, contact = study.sums(), study.contact
    if not study.by_half_space:
        curves: list[Any] = list(_asperity_curves(study, upper, lower))
        table = _table([name for name in names if name not in ONSET], curves)
        return table | _onset(study, curves[0]) if contact.onset else table
    steps = _steps(contact)
    result = _unloaded(study, upper, lower) if contact.adheres else {}
    names = tuple(name for name in names if name not in result)
    of_steps: Arrays = {}
    for at, curve in solved(functools.partial(_half_space, study, upper, lower), steps):
        part = _table(names, [curve, *(curve.with_sliding(rule) for rule in contact.rules()[1:])])
        if at.size == steps.size:
            return part | result
        for name, values in part.items():
            of_steps.setdefault(name, nothing((*values.shape[:-1], steps.size), name))[..., at] = values
    if not of_steps:  # none of the loads has a solution
        shapes = {name: shape for name, (shape, _) in arrays_of(study).items()}
        cells = len(study.surfaces.cells())
        of_steps = {name: nothing(shapes[name][cells:], name) for name in names}
    return of_steps | result


def _unloaded(study: Study, upper: Profile | Surface, lower: Profile | Surface) -> Arrays:
    """What holds a pair without a load, NaN where that is not solved."""
    curve, pull_off = unloaded(functools.partial(_half_space, study, upper, lower))
    found: Arrays = {"pull_off": np.asarray(pull_off)}
    rules = study.contact.rules()
    for name in UNLOADED:
        curves = [] if curve is None else [curve, *(curve.with_sliding(rule) for rule in rules[1:])]
        found[name] = np.stack([getattr(each, sliding_sum(name))[..., 0] for each in curves] or [np.array(np.nan)])
    return found


def _onset(study: Study, curve: LoadCurve) -> Arrays:
    """How a pair begins to slide at every approach, pushed along the first direction; 0 where nothing touches."""
    contact = study.contact
    assert isinstance(contact, Asperities)
    assert contact.onset is not None
    found = {name: np.zeros(curve.approach.size) for name in ONSET}
    for place in np.flatnonzero(curve.normal_elastic > 0).tolist():
        onset = curve.onset(
            place, mu0=contact.onset.mu0, tau0=float(contact.onset.tau0), direction=contact.ways()[0], steps=[HALF],
            poisson=contact.onset.poisson_ratio,
        )  # fmt: skip
        values = (onset.stiffness, onset.displacement_at_sliding, float(onset.slipped_load[0]))
        for name, value in zip(ONSET, values, strict=True):
            found[name][place] = value
    return found


def _table(names: Sequence[str], curves: list[Any]) -> Arrays:
    return {
        name: np.stack([getattr(curve, name) for curve in curves]) if name in DIRECTED else getattr(curves[0], name)
        for name in names
    }


def pressed_families(
    study: Study, upper: tuple[Floats, Floats], lower: tuple[Floats, Floats], scratch: Floats
) -> Arrays:
    """What `pressed` has of each pair of two families of profiles that touch at asperities, in one call.

    A family is its unscaled heights (k, points), µm, which are used up, and what `ProfileGenerator.fill` returns of
    them; the scratch is (2, points). Each sum is an array (k, amplitudes, rules, steps); of those that do not depend on
    the motion there is one rule.
    """
    surfaces, models, steps = profiles(study), _models(study.contact), _steps(study.contact)
    amplitudes = surfaces.amplitudes()
    columns = _core.press_families(
        *upper, *lower, spacing=float(surfaces.extent) / surfaces.points, amplitudes=amplitudes,
        measure=surfaces.amplitude_measure, approaches=steps, models=[model.for_profiles().core() for model in models],
        scratch=scratch,
    )  # fmt: skip
    shape = len(upper[0]), amplitudes.size, len(models), steps.size
    tables = {name: columns[name].reshape(shape) for name in study.sums()}
    return {name: table if name in DIRECTED else table[:, :, :1] for name, table in tables.items()}


def _asperity_curves(study: Study, upper: Profile | Surface, lower: Profile | Surface) -> Iterator[LoadCurve]:
    contact = study.contact
    steps, models = _steps(contact), _models(contact)
    if isinstance(upper, Surface):
        models = tuple(model.for_surfaces() for model in models)
        found = candidates(upper, lower, deepest=float(steps[-1]), curvature=models[0].curvature)
        for model in models:
            yield press(found, steps, model=model)
        return
    assert isinstance(lower, Profile)
    for model in models:
        yield press(upper, lower, steps, model=model)


def _half_space(study: Study, upper: Profile | Surface, lower: Profile | Surface, loads: Floats) -> HalfSpaceCurve:
    contact = study.contact
    assert isinstance(contact, HalfSpace)
    direction = contact.ways() if isinstance(contact.direction, tuple) else contact.ways()[0]
    return half_space(upper, lower, loads, **contact.solid(), direction=direction, sliding=contact.rules()[0])


@functools.lru_cache(maxsize=4)
def _models(contact: Any) -> tuple[ContactModel, ...]:
    return tuple(contact.model(rule) for rule in contact.rules())


@functools.lru_cache(maxsize=4)
def _steps(contact: Any) -> Floats:
    return read_only(contact.steps())


def _surfaces(study: Study, repetition: int) -> Iterator[tuple[tuple[int, int], Surface, Surface]]:
    """Each pair with its place (fractal dimension, amplitude)."""
    for d, dimension in enumerate(generated(study).fractal_dimensions()):
        upper, lower = (unscaled_surface(study, repetition, side, dimension) for side in SIDES)
        for a, amplitude in enumerate(generated(study).amplitudes()):
            yield (d, a), scaled_surface(study, upper, amplitude), scaled_surface(study, lower, amplitude)


def _profiles(study: Study, repetition: int) -> Iterator[tuple[tuple[int, int], Profile, Profile]]:
    """Each pair with its place (fractal dimension, amplitude); it is gone when the next one comes."""
    spacing = ProfileGenerator.of(study).spacing
    measure = profiles(study).amplitude_measure
    for place, (uppers, _), (lowers, _), scratch in _families(study, repetition):
        for d, (upper, lower) in enumerate(zip(uppers, lowers, strict=True), start=place.start):
            for a, amplitude in enumerate(generated(study).amplitudes()):
                yield (
                    (d, a),
                    scaled_profile(upper, spacing, amplitude, measure, scratch[0]),
                    scaled_profile(lower, spacing, amplitude, measure, scratch[1]),
                )


def _families(
    study: Study, repetition: int
) -> Iterator[tuple[slice, tuple[Floats, Floats], tuple[Floats, Floats], Floats]]:
    """Unscaled profiles and their levels at some fractal dimensions at a time, and memory for a scaled pair."""
    dimensions, points = profiles(study).fractal_dimensions(), profiles(study).points
    generator = ProfileGenerator.of(study)
    members = min(dimensions.size, max(1, FAMILY_MEMORY // (8 * points)))
    memory = _memory((2 * members + 2, points))
    for first in range(0, dimensions.size, members):
        family = dimensions[first : first + members]
        uppers, lowers = memory[: family.size], memory[members : members + family.size]
        yield (
            slice(first, first + family.size), (uppers, generator.fill(uppers, family, repetition, "upper")),
            (lowers, generator.fill(lowers, family, repetition, "lower")), memory[-2:],
        )  # fmt: skip


def _memory(shape: tuple[int, ...]) -> Floats:
    """An uninitialised array; a thread's tasks use the same again, because new pages are slow to come by.

    It begins on a line of the cache: wide writes across two lines cost two.
    """
    memory: Floats | None = getattr(_kept, "memory", None)
    if memory is None or memory.shape != shape:
        whole = np.empty(math.prod(shape) + CACHE_LINE // 8)
        begin = -whole.__array_interface__["data"][0] % CACHE_LINE // 8
        _kept.memory = memory = whole[begin : begin + math.prod(shape)].reshape(shape)
    return memory


# ---- Measured bodies -------------------------------------------------------------------------------------------------


def _measured(study: Study, index: int, arrays: Arrays) -> Iterator[tuple[int, Arrays]]:
    """A member at each cut-off; what the member is goes to `arrays` at once."""
    pressing = Pressing.of(study, index)
    for place, wavelength in enumerate(study.surfaces.cells()["cut_off"]):
        member = bodies_of(study).member(index, float(wavelength))
        arrays |= {name: np.asarray(getattr(member, name)) for name in ("x", "y", "line", "surrogate")}
        columns = pressing.pressed(*member.pair)
        yield place, {name: columns[name] for name in names_of(study)}
