"""One body at positions on another: which parts lie above each other, and what each position has under its loads."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE, Sums, Validity
from stiction.mechanics.load_curve import press
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import ContactModel
from stiction.mechanics.quantities import DIRECTED
from stiction.studies.member_values import SIX, loads_of
from stiction.studies.pressing import STIFFNESS_STEP, Load, Pressing
from stiction.surfaces.pairing import FEWEST_POINTS
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

_JUST_BEFORE = 1e-11
"""Fraction of an approach by which the step before it is closer to first touch: beyond the tolerance of `crossing`."""

Values = dict[str, NDArray[Any]]

Pair = tuple[Profile, Profile] | tuple[Surface, Surface]


# ---- Which parts lie above each other --------------------------------------------------------------------------------


def places_on_lines(offsets: ArrayLike, uppers: list[Profile], lowers: list[Profile]) -> NDArray[np.intp]:
    """Offsets in whole spacings, at which every slider is over its lower profile."""
    spacing = uppers[0].spacing
    values = np.atleast_1d(float_array("offsets", offsets))
    if values.ndim != 1 or not values.size or not (values >= 0).all() or not (np.diff(values) > 0).all():
        raise ValueError(f"offsets must be numbers of at least 0 µm that rise, got {offsets!r}")
    places = np.rint(values / spacing).astype(np.intp)
    if not (np.diff(places) > 0).all():
        raise ValueError(
            f"offsets must be at least a spacing apart, {spacing:g} µm, got {values.size} offsets of which two are "
            f"{np.diff(values).min():.3g} µm apart"
        )
    for line, (above, below) in enumerate(zip(uppers, lowers, strict=True)):
        if places[-1] + len(above) > len(below):
            raise ValueError(
                f"the slider must be over the lower profile: line {line} has {above.extent:g} µm of it and "
                f"{below.extent:g} µm below, so that offsets are at most {(len(below) - len(above)) * spacing:g} µm, "
                f"got {places[-1] * spacing:g} µm"
            )
    return places


def places_on_maps(offsets: ArrayLike, upper: Surface, lower: Surface) -> NDArray[np.intp]:
    """Offsets (x, y) in whole rows and columns, with enough of both maps above each other."""
    values = float_array("offsets", offsets)
    if values.ndim == 0 and values == 0:
        values = np.zeros((1, 2))
    if values.ndim == 1 and values.size == 2:
        values = values[np.newaxis]
    if values.ndim != 2 or values.shape[1] != 2 or not len(values):
        raise ValueError(f"offsets of surfaces must be (x, y) or a list of these, µm, got {offsets!r}")
    if not (np.abs(values) < 1e9 * np.array(upper.spacing[::-1])).all():
        raise ValueError(f"offsets must not move the maps further apart than they are long, got {offsets!r}")
    places = np.rint(values[:, ::-1] / np.array(upper.spacing)).astype(np.intp)
    moved_to, below = np.array(upper.heights.shape), np.array(lower.heights.shape)
    common = np.minimum(places + moved_to, below) - np.maximum(places, 0)
    if (common < FEWEST_POINTS).any():
        x, y = values[(common < FEWEST_POINTS).any(axis=1)][0]
        raise ValueError(
            f"offsets must leave at least {FEWEST_POINTS} rows and columns of both maps above each other, got ({x:g}, "
            f"{y:g}) µm"
        )
    return np.asarray(places)


def overlap(upper: Surface, lower: Surface, place: tuple[int, int]) -> tuple[Surface, Surface]:
    """What of two maps lies above each other when the upper is moved by rows and columns over the lower."""
    of_upper, of_lower = [], []
    for size_upper, size_lower, moved in zip(upper.heights.shape, lower.heights.shape, place, strict=True):
        first, last = max(0, moved), min(size_lower, moved + size_upper)
        of_lower.append(slice(first, max(first, last)))
        of_upper.append(slice(first - moved, max(first, last) - moved))
    return (
        Surface(upper.heights[tuple(of_upper)], spacing=upper.spacing, history=upper.history),
        Surface(lower.heights[tuple(of_lower)], spacing=lower.spacing, history=lower.history),
    )


# ---- What a position has under its loads -----------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Asked:
    """What is asked of every position: loads (mN) and what they are, mu0 and tau0 (GPa), and a model for each motion.

    With a `compliance_share` elastic half-planes are pressed, else asperities.
    """

    loads: Floats
    load: Load
    mu0: Floats
    tau0: Floats
    models: tuple[ContactModel, ...]
    compliance_share: float | None = None

    def at(self, pair: Pair) -> Values:
        """Each quantity and the status at one position, (motions, loads, mu0, tau0) each."""
        return self._by_asperities(pair) if self.compliance_share is None else self._by_half_planes(pair)

    def _by_asperities(self, pair: Pair) -> Values:
        bodies = Bodies(*pair)
        shape = len(self.models), self.loads.size, self.mu0.size, self.tau0.size
        found: Values = {"status": np.empty(shape, dtype=STATUS_DTYPE)}
        for row, m, t in np.ndindex(shape[0], *shape[2:]):
            material = float(self.mu0.flat[m]), float(self.tau0.flat[t])
            mu0, tau0 = carrying = material if self.load == "normal" else (0.0, 0.0)
            approach, status = crossing(bodies, self.loads, mu0=mu0, tau0=tau0, model=self.models[row])
            found["status"][row, :, m, t] = status
            ok = np.flatnonzero(status == friction.STATUS_OK)
            if not ok.size:
                continue
            if isinstance(pair[0], Surface):
                values = _of_maps(bodies, approach[ok], material, self.models[row])
            else:
                values = _of_lines(bodies, approach[ok], self.loads[ok], carrying, material, self.models[row])
            for name, value in values.items():
                found.setdefault(name, np.full(shape, np.nan))[row, ok, m, t] = value
        return found

    def _by_half_planes(self, pair: Pair) -> Values:
        assert self.compliance_share is not None
        model = self.models[0]
        angles = np.array([float(each.angles()) for each in self.models])
        pressing = Pressing("half-space", self.loads, angles, (model.sliding, "opposing"), model, self.compliance_share)
        sums = pressing.pressed(*pair)
        # (motions, loads), by the rule that is asked for.
        own = {name: sums[name][0] if name in DIRECTED else sums[name][np.newaxis] for name in SIX}
        normal, tangential = loads_of(own, self.mu0.ravel(), self.tau0.ravel())
        solved = np.isfinite(sums["normal_elastic"])[:, np.newaxis, np.newaxis]
        status = np.where(solved, friction.status_at(sums["contact_count"][:, np.newaxis, np.newaxis], normal),
                          np.array(friction.STATUS_NOT_SOLVED, STATUS_DTYPE))  # fmt: skip
        values = {
            "friction_coefficient": tangential / normal,
            "tangential_load": tangential,
            "contact_area": sums["contact_area"][:, np.newaxis, np.newaxis],
            "contact_count": sums["contact_count"][:, np.newaxis, np.newaxis],
            "share_opposing": (sums["tangential_frictional"][1] / own["normal_elastic"])[..., np.newaxis, np.newaxis],
        }
        ok = status == friction.STATUS_OK
        return {name: np.where(ok, value, np.nan) for name, value in values.items()} | {"status": status}


def _of_lines(
    bodies: Bodies,
    approach: Floats,
    loads: Floats,
    carrying: tuple[float, float],
    material: tuple[float, float],
    model: ContactModel,
) -> dict[str, Any]:
    """Each quantity where a position carries its loads, by friction `carrying` or by none."""
    fractions = [1 - STIFFNESS_STEP, 1 - _JUST_BEFORE, 1, 1 + STIFFNESS_STEP]
    steps, place = np.unique(np.outer(fractions, approach), return_inverse=True)
    low, before, behind, high = place.reshape(len(fractions), approach.size)
    curve = bodies.pressed(steps, model)
    normal = friction.normal_load(curve, *carrying)
    rise = loads - normal[before], normal[behind] - normal[before]
    at = rubbing = _across(curve, before, behind, rise)
    if model.sliding != "opposing":
        rubbing = _across(bodies.pressed(steps, replace(model, sliding="opposing")), before, behind, rise)
    tangential = friction.tangential_load(at, *material)
    carried = loads if carrying == material else friction.normal_load(at, *material)
    return {
        "friction_coefficient": tangential / carried,
        "tangential_load": tangential,
        "contact_area": at.contact_area,
        "contact_count": at.contact_count,
        "normal_stiffness": (normal[high] - normal[low]) / (steps[high] - steps[low]),
        "approach": approach,
        # t_x of an opposing contact is -σ n_z, so this sum per unit mu0 is their F n_z.
        "share_opposing": rubbing.tangential_frictional / rubbing.normal_elastic,
        **vars(Validity.of(at)),
    }


def _across(curve: Sums, before: Any, behind: Any, rise: tuple[Floats, Floats]) -> Sums:
    """The sums of a curve at loads between two steps each: linear, as an ensemble is read off, where F_N jumps."""
    to_load, jump = rise
    share = np.clip(np.divide(to_load, jump, out=np.ones_like(jump), where=jump > 0), 0.0, 1.0)
    return curve.each(lambda values: values[before] + share * (values[behind] - values[before]))


def _of_maps(bodies: Bodies, approach: Floats, material: tuple[float, float], model: ContactModel) -> dict[str, Any]:
    """Each quantity at the approaches of two maps, whatever friction carries the loads there."""
    steps, place = np.unique(approach, return_inverse=True)
    curve: Any = press(bodies.upper, bodies.lower, steps, model=model)  # type: ignore[arg-type]
    mu0, tau0 = material
    tangential = curve.tangential_load(mu0=mu0, tau0=tau0)
    values = {
        "friction_coefficient": tangential / curve.normal_load(mu0=mu0, tau0=tau0),
        "tangential_load": tangential,
        "lateral_load": curve.lateral_load(mu0=mu0, tau0=tau0),
        "contact_area": curve.contact_area,
        "contact_count": curve.contact_count,
        "approach": steps,
        **vars(curve.validity),
    }
    return {name: value[place] for name, value in values.items()}
