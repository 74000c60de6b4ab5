"""What a result says at a load: one reader for every result, with the load meant in one of three ways.

*mean*: the ensemble's mean normal load reaches it (a ratio of means, as the paper's figures have it). *elastic*: each
member's own load before anything slides is it. *normal*: each member's own normal load at the onset of sliding is it,
with what friction on slopes adds. On gentle slopes the three agree to four digits.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, choice, float_array
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE, STATUSES
from stiction.mechanics.quantities import ONSET, VALIDITY, attributes_of
from stiction.studies import intervals
from stiction.studies.maps import CELLS, Result, cells_of, ensemble_map, head_of, material_of, means, study_of_result
from stiction.studies.member_values import Kind, Reading, by_slopes, member_values
from stiction.studies.result import measured
from stiction.studies.study import Study, step_of

if TYPE_CHECKING:
    import xarray

STATISTIC = ["mean", "lower", "upper"]
SPREAD = (0.1, 0.9)  # quantiles of single members that are reported as spread_low and spread_high
__all__ = ["Reading", "at_load", "axes_of", "means", "member_values", "reached_loads"]
_NOT_ONE = ("contact_area_fraction",)  # fractions that may come out above 1, which a reader must see


def at_load(
    result: Result, loads: ArrayLike, *, mu0: ArrayLike | None = None, tau0: ArrayLike | None = None,
    reading: Reading | None = None, of: Kind | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Friction, true area and statistics of contacts at given loads, with 95 % intervals.

    Parameters
    ----------
    result : xarray.Dataset or Stored
        What `run` returns, or a stored result.
    loads : (l,) array_like of float, mN
        Above 0.
    mu0 : (m,) array_like of float, optional
    tau0 : (t,) array_like of float, GPa, optional
        Those of the study by default; nothing is computed again for others.
    reading : {"mean", "elastic", "normal"}, optional
        Which load is meant: "mean" of generated bodies by default, "elastic" of measured ones.
    of : {"shifts", "surrogates"}, optional
        Of measured areas, which members: those at relative positions of the two maps, where there are any, or the pairs
        of surrogates.

    Returns
    -------
    xarray.Dataset
        Over the cells of the result, sliding and direction where it has several, load, mu0 and tau0:
        friction_coefficient and status; friction_by_axis, the mean over both senses of an axis, and friction_all_round,
        the mean over all directions, where there are opposite directions; contact_area (µm²), normal_stiffness and
        figures of validity over cells and load; where a study asks for the onset of sliding also tangential_stiffness
        (mN/µm), displacement_at_sliding (µm) and fraction_slipped, of an ensemble at its mean load means that weigh
        pairs by the load they carry, but of the stiffness. Of measured bodies also their statistics of contacts,
        quantiles of areas and pressures, slopes of the gap and `gentle_friction`. All with a last dimension statistic
        ("mean", "lower", "upper"). spread_low and spread_high say between which values four of five single members lie,
        reading_difference by how much, relatively, the three readings differ, ok and members how many have an answer.

    Raises
    ------
    ValueError
        If a load, mu0 or tau0 is outside its range, or there are no members of the kind.
    """
    study = study_of_result(result)
    measured = study.is_measured
    reading = reading or ("elastic" if measured else "mean")
    choice("reading", reading, Reading)
    values = np.unique(np.atleast_1d(float_array("loads", loads)))
    if not values.size or not (values > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {loads!r}")
    material = material_of(head_of(result), mu0, tau0)
    if reading == "mean":
        point = _of_ensemble(result, values, *material)
    else:
        members = member_values(result, values, mu0=material[0], tau0=material[1], reading=reading, of=of)
        point = _of_members(study, members)
        if measured:
            gradient, slope = (point[name].sel(statistic="mean") for name in ("rms_gradient", "rms_slope"))
            cells = [str(dim) for dim in gradient.dims]
            along = slope.transpose(*cells, "direction").values
            modulus, rules = float(study.contact.effective_modulus), point["sliding"].values
            point = point.assign(by_slopes(cells, gradient.values, along, rules, *material, modulus))
    if measured:
        # The largest relative difference of friction between each member's elastic and its normal load.
        other: Reading = "normal" if reading == "elastic" else "elastic"
        members = member_values(result, values, mu0=material[0], tau0=material[1], reading=other, of=of)
        there = members["friction_coefficient"].mean(("repetition", "direction"))
        here = point["friction_all_round"].sel(statistic="mean")
        rest = [str(dim) for dim in here.dims if dim not in (*CELLS, "load")]
        point["reading_difference"] = abs(there / here - 1).max(rest).variable
    return point.assign_attrs(reading=reading)


# ---- Directions ------------------------------------------------------------------------------------------------------


def axes_of(directions: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Axes (degrees, 0 to 180) both senses of which are among directions, and where these are, (a, 2)."""
    angles = np.mod(directions, 360.0)
    found, places = [], []
    for index, angle in enumerate(angles):
        opposite = np.flatnonzero(np.abs(np.mod(angles - angle - 180.0 + 1e-6, 360.0)) < 2e-6)
        if angle < 180.0 and opposite.size:
            found.append(float(angle))
            places.append((index, int(opposite[0])))
    order = np.argsort(found)
    return np.array(found)[order], np.array(places, np.intp).reshape(-1, 2)[order]


# ---- The ensemble's mean load ----------------------------------------------------------------------------------------


def _of_ensemble(result: Result, loads: Floats, mu0: Floats, tau0: Floats) -> xarray.Dataset:
    """What `friction_map` and its kin say, with a dimension statistic."""
    import xarray

    def read(what: str, groups: NDArray[np.intp] | None = None) -> xarray.Dataset:
        """Where the mean normal load reaches the loads; of means over groups of directions, if there are any."""

        def put_together(piece: xarray.Dataset) -> xarray.Dataset:
            found = piece.isel(direction=xarray.DataArray(groups, dims=("group", "way")))
            found = found.mean("way", skipna=False, keep_attrs=True).rename(group="direction")
            return found.assign_coords(direction=("direction", np.arange(found.sizes["direction"], dtype=float)))

        return ensemble_map(result, loads, mu0, tau0, what, None if groups is None else put_together)

    head = head_of(result)
    first = read("friction_coefficient")
    variables: dict[str, Any] = {"friction_coefficient": _with_statistic(first, "friction_coefficient")}
    # Area and stiffness of an ensemble at its mean load depend, a little, on what friction adds to the load.
    variables["status"] = first["status"].variable
    every, about = None, first
    if "direction" in head.dims:
        every = np.arange(head.sizes["direction"])[np.newaxis]
        about = read("friction_coefficient", every).isel(direction=0)
        variables["friction_all_round"] = _with_statistic(about, "friction_coefficient")
        axes, places = axes_of(head["direction"].values)
        if axes.size:
            along = _with_statistic(read("friction_coefficient", places), "friction_coefficient")
            dims = ["axis" if each == "direction" else each for each in along.dims]
            variables["friction_by_axis"] = xarray.Variable(dims, along.values, along.attrs)
            first = first.assign_coords(axis=("axis", axes, attributes_of("axis")))
    for what in ("contact_area", "normal_stiffness", *(name for name in (*ONSET, "contact_load") if name in head)):
        try:
            found = read(what, every)
        except ValueError:
            if what != "normal_stiffness":  # of too few steps, or of a half-plane
                raise
            continue
        variables[what] = _with_statistic(found if every is None else found.isel(direction=0), what)
    if study_of_result(result).contact.adheres:
        held = member_values(result, loads[:1], mu0=mu0, tau0=tau0)
        for name in ("pull_off", "share_without_pull_off", "friction_at_no_load"):
            own = held[name].transpose("repetition", ...)
            mean = np.stack(intervals.of_sample(own.values), axis=-1)
            one = {dim: 0 for dim in own.dims if dim == "sliding" and dim not in head.dims}
            variables[name] = xarray.Variable((*own.dims[1:], "statistic"), mean, own.attrs).isel(one)
    variables |= {name: about[name].variable for name in VALIDITY}
    members = head.sizes["repetition"] if not hasattr(result, "finished") else result.finished.size
    variables |= {"members": ((), members, {"units": "1", "long_name": "members"})}
    dataset = xarray.Dataset(variables, first.coords, first.attrs).assign_coords(statistic=STATISTIC)
    return dataset.transpose(*cells_of(dataset), ...)


def _with_statistic(table: xarray.Dataset, name: str) -> xarray.Variable:
    import xarray

    first = table[name]
    values = np.stack([table[each].values for each in (name, "lower", "upper")], axis=-1)
    return xarray.Variable((*first.dims, "statistic"), values, first.attrs)


def reached_loads(result: Result, steps: int = 80) -> Floats:
    """Loads in equal ratios (mN), from what every cell carries at its first step to the most that any reaches."""
    elastic = means(result, ["normal_elastic"])["normal_elastic"]
    highest = float(elastic.max())
    if not highest > 0:
        raise ValueError("no pair of this result touches within its steps, so there is nothing to draw")
    lowest = float(elastic.isel({step_of(elastic.to_dataset(name="load_of_step")): 0}).max())
    if not 1e-6 * highest < lowest < 0.5 * highest:
        lowest = 1e-6 * highest if lowest < highest / 2 else highest / 10
    return np.asarray(np.geomspace(lowest, highest, steps))


# ---- Means over members ----------------------------------------------------------------------------------------------


def _of_members(study: Study, members: xarray.Dataset) -> xarray.Dataset:
    """Means over members with their intervals."""
    import xarray

    order = OverMembers.of(study, members)
    several = members.sizes["direction"] > 1
    there = members.variables
    dims = [str(dim) for dim in there["friction_coefficient"].dims if dim != "repetition"]
    variables: dict[str, Any] = {}
    for name in members.data_vars:
        values = there[name]
        if values.dtype.kind == "f" and "repetition" in values.dims:
            own = [dim for dim in values.dims if dim != "repetition"]
            found = order.mean(values.transpose("repetition", *own).values)
            if "share" in str(name) or "fraction" in str(name):
                found = np.where(found > 1, np.maximum(1.0, found[..., :1]), found) if name not in _NOT_ONE else found
            variables[str(name)] = ((*own, "statistic"), found, values.attrs)
    coefficient = there["friction_coefficient"].transpose("repetition", *dims).values
    at = dims.index("direction") + 1
    status = there["status"].transpose("repetition", *dims).values
    ok = status == friction.STATUS_OK
    counts = np.stack([(status == each).sum(axis=0) for each in STATUSES])
    frequent = np.array(STATUSES, STATUS_DTYPE)[counts.argmax(axis=0)]  # the reason where no member has an answer
    common = np.where(ok.any(axis=0), np.array("ok", STATUS_DTYPE), frequent)
    words = attributes_of("friction_coefficient")
    rest = [dim for dim in dims if dim != "direction"]
    coordinates: dict[str, Any] = {
        str(name): each for name, each in members.coords.items() if "repetition" not in each.dims
    }
    round_mean = coefficient.mean(axis=at)
    variables["friction_all_round"] = (
        (*rest, "statistic"), order.mean(round_mean), words | {"long_name": "friction coefficient, mean of directions"},
    )  # fmt: skip
    axes, places = axes_of(members["direction"].values)
    if several and axes.size:
        by_axis = np.stack([np.take(coefficient, pair, axis=at).mean(axis=at) for pair in places], axis=at)
        named = ("axis" if dim == "direction" else dim for dim in dims)
        variables["friction_by_axis"] = (
            (*named, "statistic"), order.mean(by_axis), words | {"long_name": "friction coefficient, both senses"},
        )  # fmt: skip
        coordinates["axis"] = ("axis", axes, attributes_of("axis"))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)  # where no member has an answer there is none
        low, high = np.nanquantile(coefficient, SPREAD, axis=(0, at))
    variables |= {
        "spread_low": (rest, low, words | {"long_name": "a tenth of the members are below"}),
        "spread_high": (rest, high, words | {"long_name": "a tenth of the members are above"}),
        "status": (dims, common, attributes_of("status")),
        "ok": (dims, ok.sum(axis=0), {"units": "1", "long_name": "members with an answer"}),
        "members": ((), coefficient.shape[0], {"units": "1", "long_name": "members"}),
    }  # fmt: skip
    return xarray.Dataset(variables, coordinates | {"statistic": STATISTIC}, members.attrs)


class OverMembers:
    """How members belong together: independent of each other, neighbours on lines, or of several scans of parts."""

    def __init__(
        self, order: NDArray[np.intp] | None, lines: NDArray[np.intp] | None, scans: tuple[Any, Any] | None = None
    ) -> None:
        self._order, self._lines, self._scans = order, lines, scans

    @classmethod
    def of(cls, study: Study, places: Mapping[Any, Any]) -> OverMembers:
        """Members at places: neighbours are the lines of maps, side by side, and the positions on one line."""
        if study.is_measured and math.prod(measured(study).scan_counts) > 1:
            return cls(None, None, measured(study).scans_of(np.asarray(places["repetition"])))
        if not study.is_measured or study.is_areal:
            return cls(None, None)
        lines, x, y = (np.asarray(places[name]) for name in ("line", "x", "y"))
        order = np.lexsort((x, lines, y))
        return cls(order, lines[order])

    def mean(self, values: Floats) -> Floats:
        """(..., 3): mean, lower and upper end of values (members, ...)."""
        if self._scans is not None:
            columns = values.reshape(values.shape[0], -1).T
            ends = [_ends_of(column, intervals.of_scans(column, *self._scans)) for column in columns]
            return np.array(ends).reshape(*values.shape[1:], 3)
        if self._order is None or self._lines is None:
            return np.stack(intervals.of_sample(values), axis=-1)
        flat = values[self._order].reshape(values.shape[0], -1)
        known = np.isfinite(flat)
        found = [
            intervals.of_positions(column[there], self._lines[there])
            for column, there in zip(flat.T, known.T, strict=True)
        ]
        return np.array(found).reshape(*values.shape[1:], 3)


def _ends_of(values: Floats, found: intervals.OfScans | None) -> tuple[float, float, float]:
    """Mean, lower and upper end, which is not below 0 where no value is."""
    if found is None:
        known = values[np.isfinite(values)]
        return float(known.mean()) if known.size else np.nan, np.nan, np.nan
    least = -np.inf if np.nanmin(values) < 0 else 0.0
    return found.mean, max(found.mean - found.half_width, least), found.mean + found.half_width
