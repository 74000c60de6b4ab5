"""What each member of a result has at a load of its own, before any mean is taken."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array
from stiction.mechanics import friction
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.friction import RATIOS, SIX, STATUS_DTYPE, STATUSES, load_of, loads_of, ratio_of
from stiction.mechanics.quantities import DISTRIBUTIONS, ONSET, UNLOADED, attributes_of
from stiction.studies.contact_statistics import STATISTICS
from stiction.studies.intervals import Crossing
from stiction.studies.maps import MOTIONS, Result, cells_of, head_of, material_of
from stiction.studies.store import pieces
from stiction.studies.study import step_of, study_of

if TYPE_CHECKING:
    import xarray

Reading = Literal["mean", "elastic", "normal"]
Kind = Literal["shifts", "surrogates"]
_OF_STEPS = ("contact_count", "contact_area", "normal_elastic", "contact_load", "approach")
_VALIDITY_LOADS = ("overlap_load", "load_beyond_hertz", "load_below_grid", "crossed_count", "load_overlapping")

_PROPORTIONAL = (
    "tangential_stiffness", "contact_count", "contact_area", "normal_elastic", "contact_load", *_VALIDITY_LOADS,
)  # fmt: skip
"""What grows about as the load does."""

PER_AREA = {"stiffness_per_area": "normal_stiffness", "unloading_stiffness_per_area": "unloading_stiffness"}
"""Stiffnesses over the nominal area, and what they are of."""


def member_values(
    result: Result, loads: ArrayLike, *, mu0: ArrayLike | None = None, tau0: ArrayLike | None = None,
    reading: Reading = "elastic", of: Kind | None = None,
) -> xarray.Dataset:  # fmt: skip
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
    if reading == "mean":
        raise ValueError("reading must be 'elastic' or 'normal': members have no mean load")
    values = np.unique(np.atleast_1d(float_array("loads", loads)))
    material = material_of(head_of(result), mu0, tau0)
    return _of_all(
        result, of, lambda piece: piece_at(piece, values, *material, reading, ratio=step_of(piece) == "load")
    )


def six_at(result: Result, loads: Floats, *, of: Kind | None = None) -> xarray.Dataset:
    """The six sums of each member at loads (mN) of its own, over cells, repetition, sliding, direction and load."""
    import xarray

    def six(piece: xarray.Dataset) -> xarray.Dataset:
        sums, off = _curves(piece, loads, ratio=step_of(piece) == "load")
        dims = (*cells_of(piece), "repetition", *MOTIONS, "load")
        values = np.broadcast_arrays(*map(off.at, sums.values()))
        kept = {str(name): each for name, each in piece.coords.items() if {*each.dims} <= {*dims} - {"load"}}
        return xarray.Dataset(
            {name: (dims, each) for name, each in zip(sums, values, strict=True)}, _motions_of(piece) | kept
        )

    return _of_all(result, of, six)


@dataclass(frozen=True, kw_only=True)
class PerLoad:
    """Both forces over the elastic load: tangential = elastic + mu0 rub + tau0 stick, normal = 1 + mu0 .. + tau0 .."""

    elastic: float = 0.0
    rub: float = 1.0
    stick: float
    rub_normal: float = 0.0
    stick_normal: float = 0.0

    @classmethod
    def of(cls, six: Mapping[str, Any], **more: Any) -> Self:
        """From means of the six sums."""
        per = {name: float(each / six["normal_elastic"]) for name, each in six.items()}
        return cls(
            elastic=per["tangential_elastic"], rub=per["tangential_frictional"], stick=per["tangential_adhesive"],
            rub_normal=per["normal_frictional"], stick_normal=per["normal_adhesive"], **more,
        )  # fmt: skip

    def coefficient(self, mu0: Any, tau0: Any, area: Any = 1.0) -> Any:
        """mu_s, where the true area is that many times the computed one."""
        tangential = self.elastic + mu0 * self.rub + tau0 * self.stick * area
        return tangential / (1 + mu0 * self.rub_normal + tau0 * self.stick_normal * area)


def _of_all(result: Result, of: Kind | None, read: Callable[[xarray.Dataset], xarray.Dataset]) -> xarray.Dataset:
    """All members of a kind, read piece by piece."""
    import xarray

    parts = [read(piece) for piece in pieces(result) if piece.sizes["repetition"]]
    whole = parts[0] if len(parts) == 1 else xarray.concat(
        parts, "repetition", data_vars="minimal", coords="minimal", compat="override", combine_attrs="override"
    )  # fmt: skip
    if "surrogate" not in whole.coords:
        return whole
    made = whole["surrogate"].values.astype(bool)
    wanted = bool(made.all()) if of is None else of == "surrogates"
    if not (made == wanted).any():
        raise ValueError(f"of must not be {of!r}: the result has no such members")
    return whole.isel(repetition=np.flatnonzero(made == wanted))


def piece_at(
    piece: xarray.Dataset, loads: Floats, mu0: Floats, tau0: Floats, reading: Reading, *, ratio: bool
) -> xarray.Dataset:
    """`member_values` of some members in memory; by `ratio` sums are read off over the logarithm of the load."""
    import xarray

    cells, step = cells_of(piece), step_of(piece)
    lead = (*cells, "repetition")
    there = piece.variables
    sums, off = _curves(piece, loads, ratio=ratio)
    motions = [name for name in MOTIONS if name in piece.dims]
    six = {name: off.at(values) for name, values in sums.items()} if reading == "elastic" else {}
    if reading == "elastic":
        normal, tangential = loads_of(six, mu0, tau0)
        reached, below = off.reached[..., None, None, :, None, None], off.below[..., None, None, :, None, None]
    else:
        # (..., load, mu0, tau0) where each member's own normal load is that of `loads`.
        normal, tangential = (np.moveaxis(each, -3, -1) for each in loads_of(sums, mu0, tau0))
        normal = np.broadcast_to(normal, tangential.shape)
        with np.errstate(invalid="ignore"):
            carried = np.where(normal > 0, normal, np.nan) if ratio else normal
        own = Crossing.of(carried, loads, ratio=ratio).without_gaps(normal, loads)
        reached, below = (np.moveaxis(each, -1, -3) for each in (own.reached, own.below))
        normal, tangential = (np.moveaxis(own.at(each), -1, -3) for each in (normal, tangential))
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
    for name in ("rms_gradient", "rms_slope", "pull_off"):
        if name in there:
            variables[name] = there[name]
    if "pull_off" in there:
        missing = np.isnan(_over(there["pull_off"], lead)).astype(np.float64)
        variables["share_without_pull_off"] = (lead, missing, attributes_of("share_without_pull_off"))
        parts = {name: _over(there[name], (*lead, *MOTIONS), missing=True)[..., None, None] for name in UNLOADED}
        held = load_of("unloaded", parts, mu0[:, np.newaxis], tau0).mean(axis=len(lead) + 1)
        variables["friction_at_no_load"] = (
            (*lead, "sliding", "mu0", "tau0"), held, attributes_of("friction_at_no_load"),
        )  # fmt: skip
    coordinates: dict[str, Any] = {
        str(name): each.variable for name, each in piece.coords.items() if name not in (step, "mu0", "tau0")
    }
    asked = {"load": loads, "mu0": mu0, "tau0": tau0}
    coordinates |= _motions_of(piece) | {name: (name, each, attributes_of(name)) for name, each in asked.items()}
    return xarray.Dataset(_with_derived(variables, piece.coords.get("nominal_area")), coordinates, piece.attrs)


def _curves(piece: xarray.Dataset, loads: Floats, *, ratio: bool) -> tuple[dict[str, Floats], Crossing]:
    """The six sums of members over sliding, direction and step, and where their elastic load reaches loads."""
    step = step_of(piece)
    lead = (*cells_of(piece), "repetition")
    there = piece.variables  # without coordinates, which take longer to carry along than the numbers to compute
    elastic = _over(there["normal_elastic"], (*lead, step))
    curve = elastic if step == "approach" else np.where(np.isfinite(elastic), piece[step].values, np.nan)
    sums = {name: _over(there[name], (*lead, *MOTIONS, step), missing=True) for name in SIX}
    return sums, Crossing.of(curve, loads, ratio=ratio).without_gaps(curve, loads)


def _motions_of(piece: xarray.Dataset) -> dict[str, Any]:
    """Coordinates of sliding rules or directions of which a result has but one."""
    one: dict[str, Callable[[], Any]] = {
        "sliding": lambda: study_of(piece).contact.rules(),
        "direction": lambda: study_of(piece).contact.degrees(),
    }
    return {name: ((name,), list(one[name]()[:1]), attributes_of(name)) for name in MOTIONS if name not in piece.dims}


def _with_derived(variables: dict[str, Any], nominal_area: Any) -> dict[str, Any]:
    """With the fractions that follow from the sums, in place of what only they are made of."""
    dims, elastic = variables["normal_elastic"][:2]
    found: dict[str, Any] = {}
    if nominal_area is not None and "pull_off" in variables:
        pull_off = variables["pull_off"]
        pressure = pull_off.values / float(nominal_area)
        variables["pull_off_pressure"] = (pull_off.dims, pressure, attributes_of("pull_off_pressure"))
    if nominal_area is not None:
        area = float(nominal_area)
        found["contact_area_fraction"] = variables["contact_area"][1] / area
        found["nominal_pressure"] = np.broadcast_to(elastic, elastic.shape) / area
        for name, of in PER_AREA.items():
            if of in variables:
                found[name] = 1e3 * variables[of][1] / area  # of mN/µm³
    with np.errstate(divide="ignore", invalid="ignore"):
        carried = variables["contact_load"][1] if "contact_load" in variables else elastic
        found["mean_pressure"] = carried / variables["contact_area"][1]
    sums = {name: each[1] for name, each in variables.items() if isinstance(each, tuple)}
    for name in ("share_beyond_hertz", "share_below_grid", "relative_overlap", "share_overlapping", "share_crossed"):
        if RATIOS[name][0] in sums:
            found[name] = ratio_of(name, sums)
    kept = {name: each for name, each in variables.items() if name not in (*_VALIDITY_LOADS, "normal_elastic")}
    return kept | {name: (dims, values, attributes_of(name)) for name, values in found.items()}


def _over(array: xarray.Variable, dims: tuple[str, ...], *, missing: bool = False) -> Floats:
    """Values over dimensions in this order, as floating-point numbers; those that are missing have one element."""
    own = [dim for dim in dims if dim in array.dims]
    values = array.transpose(*own).values.astype(np.float64)
    if not missing:
        return values
    return np.asarray(values[tuple(slice(None) if dim in own else np.newaxis for dim in dims)])


def _status(piece: xarray.Dataset, loads: Floats, normal: Floats, reached: Any, below: Any) -> NDArray[Any]:
    """Status of each member over (..., sliding, direction, load, mu0, tau0)."""
    known = np.isfinite(normal)
    locked = known & (normal <= 0)
    status = friction.status_of(touched=True, reached=known & reached & ~locked, locked=locked, below=below)
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


def by_slopes(
    dims: list[str], gradient: Floats, slope: Floats, rules: Iterable[Any], mu0: Floats, tau0: Floats, modulus: float
) -> dict[str, Any]:
    """`gentle_friction` as a variable, of gradients of a gap (...) and its slopes along directions (..., direction)."""
    known = (gradient[..., np.newaxis] > 0) & (slope > 0)
    steep, along = (np.where(known, each, 1.0)[..., None, None] for each in (gradient[..., np.newaxis], slope))
    found = [
        gentle_friction(
            mu0[:, np.newaxis], tau0, rms_gradient=steep, rms_slope=along, effective_modulus=modulus, sliding=rule
        )
        for rule in rules
    ]
    values = np.where(known[..., np.newaxis, :, np.newaxis, np.newaxis], np.stack(found, axis=-4), np.nan)
    return {
        "gentle_friction": (
            [*dims, "sliding", "direction", "mu0", "tau0"], values, attributes_of("gentle_friction")
        )
    }  # fmt: skip
