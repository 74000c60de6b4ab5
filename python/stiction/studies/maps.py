"""Ensemble means at a load: read off along approaches or elastic loads, with an interval from the repetitions.

An ensemble value at a load is a ratio of means over the repetitions, not a mean of ratios; repetitions without contact
count as zeros. The load is reached where mean(F_N), linear between the steps, first crosses it upwards; nothing is
extrapolated.
"""

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE, Sums, Validity
from stiction.mechanics.quantities import QUANTITIES, SUMS, VALIDITY, attributes_of
from stiction.studies import intervals
from stiction.studies.crossing import Crossing
from stiction.studies.streams import pieces
from stiction.studies.study import step_of

if TYPE_CHECKING:
    import xarray


_DIMS = ("fractal_dimension", "amplitude", "repetition")
"""And the steps of `step_of`."""

_MOTIONS = ("sliding", "direction")
"""Dimensions of results for several sliding rules and directions."""


def friction_map(
    dataset: xarray.Dataset,
    loads: ArrayLike,
    *,
    mu0: ArrayLike | None = None,
    tau0: ArrayLike | None = None,
) -> xarray.Dataset:
    """Friction coefficient of the ensemble, mean(F_T) / mean(F_N), at given normal loads.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `run` returns.
    loads : (l,) array_like of float, mN
        Above 0.
    mu0 : (m,) array_like of float, optional
        Molecular friction coefficients; those of the study by default.
    tau0 : (t,) array_like of float, GPa, optional
        Adhesive shear strengths; those of the study by default.

    Returns
    -------
    xarray.Dataset
        friction_coefficient, lower and upper (95 % interval from the repetitions; NaN for a single repetition), status
        and the figures of `Validity`, over fractal_dimension, amplitude, load (mN), mu0 and tau0 (GPa), and before them
        sliding and direction if the result has these. By the half-space there is no such validity: NaN. The status is
        "ok", "no-contact", "self-locked" (mean(F_N) is zero or below at the largest approach), "not-reached" (no
        approach carries as much) or "below-range" (the smallest approach carries more); the coefficient is NaN unless
        it is "ok".

    Raises
    ------
    ValueError
        If loads, mu0 or tau0 are not positive (zero is allowed for mu0 and tau0).
    """
    return _map(dataset, loads, mu0, tau0, "friction_coefficient")


def area_map(
    dataset: xarray.Dataset,
    loads: ArrayLike,
    *,
    mu0: ArrayLike | None = None,
    tau0: ArrayLike | None = None,
) -> xarray.Dataset:
    """Mean true contact area of the ensemble (µm²) at given normal loads; otherwise as `friction_map`."""
    return _map(dataset, loads, mu0, tau0, "contact_area")


def stiffness_map(
    dataset: xarray.Dataset,
    loads: ArrayLike,
    *,
    mu0: ArrayLike | None = None,
    tau0: ArrayLike | None = None,
) -> xarray.Dataset:
    """Normal stiffness of the ensemble, d mean(F_N) / dδ (mN/µm), at given normal loads; otherwise as `friction_map`.

    The derivative along the approach δ is that of the parabola through an approach and its two neighbours, so it is as
    fine as the approaches are; it can be negative, because load is not monotone in approach. By the half-space, whose
    steps are loads, it is the mean of the pairs' own derivatives at equal elastic load.

    Raises
    ------
    ValueError
        As `friction_map`, with fewer than three approaches or loads, and of free half-planes, which have no approach.
    """
    step = step_of(dataset)
    if dataset.sizes.get(step, 0) < 3:
        kind = "approaches" if step == "approach" else "loads"
        raise ValueError(f"a stiffness needs at least 3 {kind}, got {dataset.sizes.get(step, 0)}")
    if step == "load" and "approach" in dataset and dataset["approach"].isnull().any():
        raise ValueError("a free half-plane has no approach, so there is no stiffness of it")
    return _map(dataset, loads, mu0, tau0, "normal_stiffness")


def _map(
    dataset: xarray.Dataset, loads: ArrayLike, mu0: ArrayLike | None, tau0: ArrayLike | None, what: str
) -> xarray.Dataset:
    import xarray

    for motion in _MOTIONS:
        if motion in dataset.dims:
            maps = [_map(dataset.isel({motion: i}), loads, mu0, tau0, what) for i in range(dataset.sizes[motion])]
            whole = xarray.concat(maps, dim=motion, coords="minimal", compat="override", join="override")
            return whole.assign_coords({motion: dataset[motion].variable})
    load_values = _list("loads", loads)
    if not load_values.size or not (load_values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {loads!r}")
    mu0_values, tau0_values = _parameters(dataset, mu0, tau0)
    step = step_of(dataset)
    missing = [name for name in (*_DIMS, step) if not dataset.sizes.get(name)]
    if missing:
        raise ValueError(f"the dataset has nothing along {missing[0]!r}")
    for name in _NEEDED[what]:
        if name not in dataset:
            raise ValueError(f"the dataset has no variable {name!r}")
    sizes = dataset.sizes
    shape = (
        sizes["fractal_dimension"], sizes["amplitude"], load_values.size, mu0_values.size, tau0_values.size,
    )  # fmt: skip
    mean, lower, upper = (np.full(shape, np.nan) for _ in range(3))
    validity = {name: np.full(shape, np.nan) for name in VALIDITY}
    status = np.full(shape, friction.STATUS_OK, dtype=STATUS_DTYPE)
    judged = all(name in dataset for name in SUMS)  # a dataset of loads alone still has a friction coefficient
    # Two passes over the repetitions: the means say where loads are reached, and intervals are of what each has there.
    means, others = _means(dataset, what, step)
    at = {}
    for d, a, m, t in np.ndindex(*shape[:2], *shape[3:]):
        pair, other = (sums.each(operator.itemgetter((d, a))) for sums in (means, others))
        normal = friction.normal_load(pair, mu0_values[m], tau0_values[t])
        values = _values(other, what, mu0_values[m], tau0_values[t])
        at[d, a, m, t] = intervals.AtLoads(normal, values, sizes["repetition"], load_values)
    for piece in pieces(dataset, (*_NEEDED[what], *_of_step(what, step))):
        own, changed = _sums_of(piece, what, step)
        for (d, a, m, t), each in at.items():
            pair, other = (sums.each(operator.itemgetter((d, a))) for sums in (own, changed))
            normal = friction.normal_load(pair, mu0_values[m], tau0_values[t])
            each.add(normal, _values(other, what, mu0_values[m], tau0_values[t]))
    for (d, a, m, t), each in at.items():
        here = (d, a, slice(None), m, t)
        mean[here] = each.mean
        lower[here], upper[here] = each.interval()
        pair = means.each(operator.itemgetter((d, a)))
        normal = friction.normal_load(pair, mu0_values[m], tau0_values[t])
        status[here] = _status(bool(pair.contact_count.any()), _locked(pair, normal), each.crossing)
        if judged:
            there = each.crossing.at(np.array([getattr(pair, name) for name in SUMS]))
            for name, figure in vars(Validity.of(Sums(**dict(zip(SUMS, there, strict=True))))).items():
                validity[name][here] = np.where(each.crossing.reached[0], figure, np.nan)
    if what == "friction_coefficient":
        for array in (mean, lower, upper):
            array /= load_values[:, np.newaxis, np.newaxis]
    coordinates: dict[str, Any] = {
        "fractal_dimension": dataset["fractal_dimension"].variable,
        "amplitude": dataset["amplitude"].variable,
        "load": ("load", load_values, {"units": "mN", "long_name": "normal load"}),
        "mu0": ("mu0", mu0_values, {"units": "1", "long_name": "molecular friction coefficient"}),
        "tau0": ("tau0", tau0_values, {"units": "GPa", "long_name": "adhesive shear strength"}),
    }
    dims = tuple(coordinates)
    coordinates |= {motion: dataset[motion].variable for motion in _MOTIONS if motion in dataset.coords}
    units, long_name = QUANTITIES[what]
    return xarray.Dataset(
        {
            what: (dims, mean, {"units": units, "long_name": long_name}),
            "lower": (dims, lower, {"units": units, "long_name": f"lower end of the 95 % interval of the {long_name}"}),
            "upper": (dims, upper, {"units": units, "long_name": f"upper end of the 95 % interval of the {long_name}"}),
            "status": (dims, status, attributes_of("status")),
            **{name: (dims, values, attributes_of(name)) for name, values in validity.items()},
        },
        coordinates,
        dict(dataset.attrs),
    )


_LOADS = ("contact_count", "normal_elastic", "normal_frictional", "normal_adhesive")
_NEEDED = {
    "friction_coefficient": (*_LOADS, "tangential_elastic", "tangential_frictional", "tangential_adhesive"),
    "contact_area": (*_LOADS, "contact_area"),
    "normal_stiffness": _LOADS,
}
"""Sums that a quantity is made of."""


def _of_step(what: str, step: str) -> tuple[str, ...]:
    """What a quantity is made of besides: each pair's own approach, where steps are loads."""
    return ("approach",) if what == "normal_stiffness" and step == "load" else ()


def _sums_of(data: xarray.Dataset, what: str, step: str) -> tuple[Sums, Sums]:
    """The sums of a result as plain arrays, and those that a quantity is linear in: of a stiffness their derivatives.

    Those that the result has not are NaN.
    """
    ordered = data.transpose(*_DIMS, step)
    missing = np.full(ordered["contact_count"].shape, np.nan)
    columns = {name: ordered[name].values if name in ordered else missing for name in SUMS}
    sums = Sums.of(columns)
    if what != "normal_stiffness":
        return sums, sums

    def derivative(values: NDArray[Any]) -> Floats:
        return np.asarray(np.gradient(values, ordered[step].values, axis=-1, edge_order=2))

    own = derivative(ordered["approach"].values) if step == "load" else 1.0
    return sums, Sums.of(columns | {name: derivative(columns[name]) / own for name in _LOADS[1:]})


def _values(sums: Sums, what: str, mu0: Floats, tau0: Floats) -> Floats:
    match what:
        case "contact_area":
            return sums.contact_area
        case "normal_stiffness":
            return friction.normal_load(sums, mu0, tau0)
        case _:
            return friction.tangential_load(sums, mu0, tau0)


def _means(dataset: xarray.Dataset, what: str, step: str) -> tuple[Sums, Sums]:
    """Means over the repetitions of what `_sums_of` gives, (fractal dimension, amplitude, step)."""
    names = [name for name in (*SUMS, *_of_step(what, step)) if name in dataset]
    total: list[Sums] = []
    for piece in pieces(dataset, names):
        added = [sums.each(lambda values: values.sum(axis=2)) for sums in _sums_of(piece, what, step)]
        total = [_sum(*each) for each in zip(total, added, strict=True)] if total else added
    sums, others = (each.each(lambda values: values / dataset.sizes["repetition"]) for each in total)
    return sums, others


def _sum(one: Sums, other: Sums) -> Sums:
    return Sums(**{name: getattr(one, name) + getattr(other, name) for name in SUMS})


def _parameters(dataset: xarray.Dataset, mu0: ArrayLike | None, tau0: ArrayLike | None) -> tuple[Floats, Floats]:
    if mu0 is None or tau0 is None or "study" in dataset.attrs:
        from stiction.studies.study import study_of

        study = study_of(dataset)
        mu0 = study.friction.mu0 if mu0 is None else mu0
        tau0 = [float(value) for value in study.friction.tau0] if tau0 is None else tau0
        friction.check_shear_strength(friction.friction_parameter("tau0", tau0), float(study.contact.effective_modulus))
    return tuple(
        np.atleast_1d(friction.friction_parameter(name, values)).ravel()
        for name, values in (("mu0", mu0), ("tau0", tau0))
    )  # type: ignore[return-value]


def _list(name: str, values: ArrayLike) -> Floats:
    array = np.atleast_1d(friction.friction_parameter(name, values))
    if array.ndim != 1:
        raise ValueError(f"{name} must be a number or a list of numbers, got shape {array.shape}")
    return array


def _locked(pair: Sums, normal: Floats) -> bool:
    """Whether contacts at the largest approach carry no mean normal load, because friction holds them."""
    return bool(pair.contact_count[-1] > 0 and normal[-1] <= 0)


def _status(touched: bool, locked: bool, crossing: Crossing) -> NDArray[np.str_]:
    return friction.status_of(touched=touched, reached=crossing.reached[0], below=crossing.below[0], locked=locked)
