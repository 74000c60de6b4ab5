"""What each member of a result has at a load of its own, before any mean is taken."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE, STATUSES
from stiction.mechanics.quantities import DISTRIBUTIONS, ONSET, attributes_of
from stiction.studies.contact_statistics import STATISTICS
from stiction.studies.crossing import Crossing
from stiction.studies.maps import MOTIONS, cells_of, head_of, material_of
from stiction.studies.store import pieces
from stiction.studies.study import step_of, study_of

if TYPE_CHECKING:
    import xarray

    from stiction.studies.maps import Result

Reading = Literal["mean", "elastic", "normal"]

Kind = Literal["shifts", "surrogates"]

SIX = (
    "normal_elastic", "normal_frictional", "normal_adhesive", "tangential_elastic", "tangential_frictional",
    "tangential_adhesive",
)  # fmt: skip
"""The sums that normal and tangential load are made of for every mu0 and tau0."""


def member_values(
    result: Result,
    loads: ArrayLike,
    *,
    mu0: ArrayLike | None = None,
    tau0: ArrayLike | None = None,
    reading: Reading = "elastic",
    of: Kind | None = None,
) -> xarray.Dataset:
    """What each member has at given loads of its own, before any mean is taken.

    Parameters
    ----------
    result, loads, mu0, tau0, of
        As for `at_load`.
    reading : {"elastic", "normal"}

    Returns
    -------
    xarray.Dataset
        Over cells, repetition, sliding and direction (of one element where the result has no list), load, mu0 and tau0:
        friction_coefficient, normal_load and tangential_load (mN), and status; the other quantities over cells,
        repetition and load (and fraction_below), read off at the elastic load.
    """
    import xarray

    if reading == "mean":
        raise ValueError("reading must be 'elastic' or 'normal': members have no mean load")
    values = np.unique(np.atleast_1d(float_array("loads", loads)))
    material = material_of(head_of(result), mu0, tau0)
    parts = [
        piece_at(piece, values, *material, reading, ratio=step_of(piece) == "load")
        for piece in pieces(result)
        if piece.sizes["repetition"]
    ]
    whole = parts[0] if len(parts) == 1 else xarray.concat(
        parts, "repetition", data_vars="minimal", coords="minimal", compat="override", combine_attrs="override"
    )  # fmt: skip
    return _of_kind(whole, of)


def _of_kind(members: xarray.Dataset, of: Kind | None) -> xarray.Dataset:
    if "surrogate" not in members.coords:
        return members
    made = members["surrogate"].values.astype(bool)
    wanted = bool(made.all()) if of is None else of == "surrogates"
    if not (made == wanted).any():
        raise ValueError(f"of must not be {of!r}: the result has no such members")
    return members.isel(repetition=np.flatnonzero(made == wanted))


def piece_at(
    piece: xarray.Dataset, loads: Floats, mu0: Floats, tau0: Floats, reading: Reading, *, ratio: bool
) -> xarray.Dataset:
    """`member_values` of some members, all of them in memory.

    With `ratio` what grows with the load is read off by straight lines of value/load over the logarithm of the load.
    """
    import xarray

    cells, step = cells_of(piece), step_of(piece)
    lead = (*cells, "repetition")
    there = piece.variables  # without coordinates, which take longer to carry along than the numbers to compute
    elastic = _over(there["normal_elastic"], (*lead, step))
    curve = elastic if step == "approach" else np.where(np.isfinite(elastic), piece[step].values, np.nan)
    off = Off.of(curve, loads, ratio=ratio)
    motions = [name for name in MOTIONS if name in piece.dims]
    sums = {
        name: _over(there[name], (*lead, "sliding", "direction", step), missing=True) for name in SIX
    }  # fmt: skip
    six = {name: off.at(values) for name, values in sums.items()} if reading == "elastic" else {}
    if reading == "elastic":
        normal, tangential = loads_of(six, mu0, tau0)
        reached, below = off.reached[..., None, None, :, None, None], off.below[..., None, None, :, None, None]
    else:
        normal, tangential, reached, below = _at_normal_load(sums, loads, mu0, tau0, ratio=ratio)
    status = _status(piece, loads, normal, reached, below)
    with np.errstate(divide="ignore", invalid="ignore"):
        coefficient = np.where(status == friction.STATUS_OK, tangential / normal, np.nan)
    dims = (*lead, "sliding", "direction", "load", "mu0", "tau0")
    variables: dict[str, Any] = {
        "friction_coefficient": (dims, coefficient, attributes_of("friction_coefficient")),
        "normal_load": (dims, normal, attributes_of("normal_load")),
        "tangential_load": (dims, tangential, attributes_of("tangential_load")),
        "status": (dims, status, attributes_of("status")),
    }
    rules = [str(each) for each in piece["sliding"].values] if "sliding" in motions else []
    if six and {"opposing", "all"} <= set(rules):
        rubbing = six["tangential_frictional"]
        both = [np.take(rubbing, rules.index(rule), axis=len(lead)) for rule in ("opposing", "all")]
        with np.errstate(divide="ignore", invalid="ignore"):
            opposing = both[0] / both[1]  # of the sum of F |t·s|, which is the load but for squares of slopes
        variables["share_opposing"] = ((*lead, "direction", "load"), opposing, attributes_of("share_opposing"))
    for name in (*_OF_STEPS, *ONSET, *STATISTICS, "load_share_at_hardness", "area_share_at_hardness", *_VALIDITY_LOADS):
        if name in there and step in there[name].dims:
            read = off.at(_over(there[name], (*lead, step)), sums=name in _PROPORTIONAL)
            variables[name] = ((*lead, "load"), read, there[name].attrs)
    for name in DISTRIBUTIONS:
        if name in there:
            read = off.at(_over(there[name], (*lead, "fraction_below", step)), sums=False)
            variables[name] = ((*lead, "fraction_below", "load"), read, there[name].attrs)
    for name in ("rms_gradient", "rms_slope"):
        if name in there:
            variables[name] = there[name]
    coordinates: dict[str, Any] = {
        str(name): each.variable for name, each in piece.coords.items() if name not in (step, "mu0", "tau0")
    }
    for name in MOTIONS:
        if name not in motions:
            coordinates[name] = ((name,), *_motion_of(piece, name))
    coordinates |= {
        "load": ("load", loads, {"units": "mN", "long_name": "normal load"}),
        "mu0": ("mu0", mu0, attributes_of("mu0")),
        "tau0": ("tau0", tau0, attributes_of("tau0")),
    }
    return xarray.Dataset(_with_derived(variables, piece.coords.get("nominal_area")), coordinates, piece.attrs)


_OF_STEPS = ("contact_count", "contact_area", "normal_elastic", "approach")

_VALIDITY_LOADS = ("overlap_load", "load_beyond_hertz", "load_below_grid", "crossed_count", "load_overlapping")


_PROPORTIONAL = ("tangential_stiffness", "contact_count", "contact_area", "normal_elastic", *_VALIDITY_LOADS)
"""What grows about as the load does."""


def _motion_of(piece: xarray.Dataset, name: str) -> tuple[list[Any], dict[str, str]]:
    """The one sliding rule or direction of a result without a list."""
    contact = study_of(piece).contact
    value: Any = contact.rules()[0] if name == "sliding" else float(contact.degrees()[0])
    return [value], attributes_of(name)


def _with_derived(variables: dict[str, Any], nominal_area: Any) -> dict[str, Any]:
    """With the fractions that follow from the sums, in place of what only they are made of."""
    dims, elastic = variables["normal_elastic"][:2]
    found: dict[str, Any] = {}
    if nominal_area is not None:
        found["contact_area_fraction"] = variables["contact_area"][1] / float(nominal_area)
    with np.errstate(divide="ignore", invalid="ignore"):
        found["mean_pressure"] = elastic / variables["contact_area"][1]
        for name, load in (
            ("share_beyond_hertz", "load_beyond_hertz"), ("share_below_grid", "load_below_grid"),
            ("relative_overlap", "overlap_load"), ("share_overlapping", "load_overlapping"),
        ):  # fmt: skip
            if load in variables:
                found[name] = variables[load][1] / elastic
        if "crossed_count" in variables:
            crossed = variables["crossed_count"][1]
            found["share_crossed"] = crossed / (crossed + variables["contact_count"][1])
    kept = {name: each for name, each in variables.items() if name not in (*_VALIDITY_LOADS, "normal_elastic")}
    return kept | {name: (dims, values, attributes_of(name)) for name, values in found.items()}


def _over(array: xarray.Variable, dims: tuple[str, ...], *, missing: bool = False) -> Floats:
    """Values over dimensions in this order, as floating-point numbers; those that are missing have one element."""
    own = [dim for dim in dims if dim in array.dims]
    values = array.transpose(*own).values.astype(np.float64)
    if not missing:
        return values
    return np.asarray(values[tuple(slice(None) if dim in own else np.newaxis for dim in dims)])


class Off:
    """Where curves (..., k) first reach loads (l,), and what other curves are there."""

    def __init__(self, crossing: Crossing, lead: tuple[int, ...], scale: tuple[Floats, Floats] | None) -> None:
        self._crossing, self._lead, self._scale = crossing, lead, scale
        self.reached, self.below = (each.reshape(*lead, -1) for each in (crossing.reached, crossing.below))

    @classmethod
    def of(cls, curve: Floats, loads: Floats, *, ratio: bool) -> Off:
        """By straight lines; with `ratio` by straight lines of value/load over the logarithm of the load."""
        lead, flat = curve.shape[:-1], curve.reshape(-1, curve.shape[-1])
        if not ratio:
            return cls(Crossing.of(flat, loads), lead, None)
        with np.errstate(divide="ignore", invalid="ignore"):
            return cls(Crossing.of(np.log(flat), np.log(loads)), lead, (curve, loads))

    def at(self, values: Floats, *, sums: bool = True) -> Floats:
        """(..., more, l): values (..., more, k) where the loads are reached, NaN where they are not.

        Sums grow with the load, so of these the ratio to it is what is nearly straight; of fractions and lengths it is
        the values themselves.
        """
        more = values.shape[len(self._lead) : -1]
        index = self._broadcast(self._crossing.index, more)
        fraction = self._broadcast(self._crossing.fraction, more)
        curve = None
        if sums and self._scale is not None:
            curve = self._scale[0].reshape(*self._lead, *(1,) * len(more), -1)
            with np.errstate(divide="ignore", invalid="ignore"):
                values = values / curve
        shape = (*np.broadcast_shapes(values.shape[:-1], index.shape[:-1]), index.shape[-1])
        index = np.broadcast_to(index, shape)
        values = np.broadcast_to(values, (*shape[:-1], values.shape[-1]))
        after = np.take_along_axis(values, index, axis=-1)
        before = np.take_along_axis(values, np.maximum(index - 1, 0), axis=-1)
        # At a step itself the step before it does not matter, even where it is missing.
        there = np.where(fraction == 1, after, before + fraction * (after - before))
        if sums and self._scale is not None:
            there = there * self._scale[1]
        return np.where(self._broadcast(self._crossing.reached, more), there, np.nan)

    def slope(self, values: Floats, over: Floats) -> Floats:
        """(..., l): steps of values over those of others, (..., k) each, between which the loads are reached."""
        index = np.maximum(self._crossing.index.reshape(*self._lead, -1), 1)
        rise, run = (
            np.take_along_axis(each, index, axis=-1) - np.take_along_axis(each, index - 1, axis=-1)
            for each in (values, over)
        )
        return np.asarray(rise / run)

    def _broadcast(self, array: NDArray[Any], more: tuple[int, ...]) -> NDArray[Any]:
        return array.reshape(*self._lead, *(1,) * len(more), -1)


def loads_of(six: dict[str, Floats], mu0: Floats, tau0: Floats) -> tuple[Floats, Floats]:
    """Normal and tangential load (..., mu0, tau0)."""
    rub, stick = mu0[:, np.newaxis], tau0[np.newaxis]
    each = {name: values[..., np.newaxis, np.newaxis] for name, values in six.items()}
    normal = each["normal_elastic"] + rub * each["normal_frictional"] + stick * each["normal_adhesive"]
    tangential = each["tangential_elastic"] + rub * each["tangential_frictional"] + stick * each["tangential_adhesive"]
    return np.asarray(normal), np.asarray(tangential)


def _at_normal_load(
    sums: dict[str, Floats], loads: Floats, mu0: Floats, tau0: Floats, *, ratio: bool
) -> tuple[Floats, Floats, NDArray[np.bool_], NDArray[np.bool_]]:
    """Normal and tangential load (..., load, mu0, tau0) where each member's own normal load is that of `loads`."""
    normal, tangential = (np.moveaxis(each, -3, -1) for each in loads_of(sums, mu0, tau0))
    normal = np.broadcast_to(normal, tangential.shape)
    with np.errstate(invalid="ignore"):
        off = Off.of(np.where(normal > 0, normal, np.nan) if ratio else normal, loads, ratio=ratio)
    reached, below = (np.moveaxis(each, -1, -3) for each in (off.reached, off.below))
    return (
        np.moveaxis(off.at(normal), -1, -3), np.moveaxis(off.at(tangential), -1, -3), reached, below,
    )  # fmt: skip


def _status(piece: xarray.Dataset, loads: Floats, normal: Floats, reached: Any, below: Any) -> NDArray[Any]:
    """Status of each member over (..., sliding, direction, load, mu0, tau0)."""
    touched = True
    known = np.isfinite(normal)
    locked = known & (normal <= 0)
    status = friction.status_of(touched=touched, reached=known & reached & ~locked, locked=locked, below=below)
    status = np.array(np.broadcast_to(status, normal.shape), STATUS_DTYPE)
    step = step_of(piece)
    if "status" in piece:
        # Why a member has no answer is said at the step that is nearest above.
        codes = _over(piece.variables["status"], (*cells_of(piece), "repetition", step)).astype(int)
        ladder = piece[step].values
        place = np.minimum(np.searchsorted(ladder, loads), ladder.size - 1)
        why = np.array(STATUSES)[codes[..., place]][..., None, None, :, None, None]
        why = np.broadcast_to(why, status.shape)
        replace = (status != friction.STATUS_OK) & (why != friction.STATUS_OK)
        status[replace] = why[replace]
    return status
