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
from stiction.studies.executors import threads
from stiction.studies.streams import pieces, repetitions_last
from stiction.studies.study import step_of

if TYPE_CHECKING:
    import xarray


AT_ONCE = 2**20
"""Numbers of curves of a fractal dimension and amplitude that are in memory at a time, however many mu0 and tau0."""

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
    motions = [motion for motion in _MOTIONS if motion in dataset.dims]
    cells = tuple(sizes[dim] for dim in (*motions, "fractal_dimension", "amplitude"))
    shape = (*cells, load_values.size, mu0_values.size, tau0_values.size)
    mean, lower, upper = (np.full(shape, np.nan) for _ in range(3))
    validity = {name: np.full(shape, np.nan) for name in VALIDITY}
    status = np.full(shape, friction.STATUS_OK, dtype=STATUS_DTYPE)
    judged = all(name in dataset for name in SUMS)  # a dataset of loads alone still has a friction coefficient
    material = mu0_values[:, np.newaxis, np.newaxis, np.newaxis], tau0_values[:, np.newaxis, np.newaxis]

    def curves(cell: tuple[int, ...], sums: Sums, others: Sums, some: slice = slice(None)) -> tuple[Floats, Floats]:
        """Normal loads and values of every mu0 and tau0, one after the other, and of some repetitions: (c, k, r)."""
        pair, other = (each.each(operator.itemgetter((*cell, slice(None), some))) for each in (sums, others))
        normal = friction.normal_load(pair, *material)
        values = np.broadcast_to(_values(other, what, *material), normal.shape)
        return tuple(each.reshape(-1, *normal.shape[2:]) for each in (normal, values))  # type: ignore[return-value]

    # Two passes over the repetitions: the means say where loads are reached, and intervals are of what each has there.
    means, others = _means(dataset, what, step)
    at = {}
    for cell in np.ndindex(cells):
        normal, values = (each[..., 0] for each in curves(cell, means, others))
        at[cell] = intervals.AtLoads(normal, values, sizes["repetition"], load_values)
    at_a_time = max(1, AT_ONCE // max(1, mu0_values.size * tau0_values.size * sizes[step]))
    with threads() as pool:
        for piece in pieces(dataset, (*_NEEDED[what], *_of_step(what, step))):
            both = [_sums_of(piece, what, step)] * len(at)

            def add(cell: tuple[int, ...], sums: tuple[Sums, Sums]) -> None:
                for first in range(0, sums[0].contact_count.shape[-1], at_a_time):
                    at[cell].add(*curves(cell, *sums, slice(first, first + at_a_time)))

            list(pool.map(add, at, both))
    for cell, each in at.items():
        for array, found in zip((mean, lower, upper), (each.mean, *each.interval()), strict=True):
            array[cell] = _by_load(found, shape)
        pair = means.each(operator.itemgetter((*cell, slice(None), 0)))
        normal = curves(cell, means, others)[0][..., 0]
        locked = (pair.contact_count[-1] > 0) & (normal[:, -1:] <= 0)  # friction holds them at the largest approach
        status[cell] = _by_load(
            friction.status_of(
                touched=bool(pair.contact_count.any()), reached=each.crossing.reached, below=each.crossing.below,
                locked=locked,
            ),
            shape,
        )  # fmt: skip
        if judged:
            there = {name: each.crossing.at(np.tile(getattr(pair, name), (normal.shape[0], 1))) for name in SUMS}
            for name, figure in vars(Validity.of(Sums(**there))).items():
                validity[name][cell] = _by_load(np.where(each.crossing.reached, figure, np.nan), shape)
    if what == "friction_coefficient":
        for array in (mean, lower, upper):
            array /= load_values[:, np.newaxis, np.newaxis]
    coordinates: dict[str, Any] = {
        **{motion: dataset[motion].variable for motion in motions},
        "fractal_dimension": dataset["fractal_dimension"].variable,
        "amplitude": dataset["amplitude"].variable,
        "load": ("load", load_values, {"units": "mN", "long_name": "normal load"}),
        "mu0": ("mu0", mu0_values, {"units": "1", "long_name": "molecular friction coefficient"}),
        "tau0": ("tau0", tau0_values, {"units": "GPa", "long_name": "adhesive shear strength"}),
    }
    dims = tuple(coordinates)
    coordinates |= {motion: dataset[motion].variable for motion in _MOTIONS if motion in dataset.coords}  # of one
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


def _by_load(of_curves: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """What curves (c, l) of every mu0 and tau0 have, over load, mu0 and tau0."""
    return np.moveaxis(of_curves.reshape(*shape[-2:], shape[-3]), -1, 0)


def _sums_of(data: xarray.Dataset, what: str, step: str) -> tuple[Sums, Sums]:
    """The sums of a result as plain arrays, and those that a quantity is linear in: of a stiffness their derivatives.

    Over motions, fractal dimension, amplitude, step and repetition. Those that the result has not are NaN.
    """
    dims = [
        *(motion for motion in _MOTIONS if motion in data.dims),
        "fractal_dimension",
        "amplitude",
        step,
        "repetition",
    ]
    shape = [data.sizes[dim] for dim in dims]

    def values_of(name: str) -> NDArray[Any]:
        if name not in data:
            return np.broadcast_to(np.nan, shape)
        own = [dim for dim in dims if dim in data[name].dims]
        values = repetitions_last(data[name], own[:-1])
        return np.broadcast_to(values.reshape([data.sizes[dim] if dim in own else 1 for dim in dims]), shape)

    columns = {name: values_of(name) for name in SUMS}
    sums = Sums.of(columns)
    if what != "normal_stiffness":
        return sums, sums

    def derivative(values: NDArray[Any]) -> Floats:
        return np.asarray(np.gradient(values, data[step].values, axis=-2, edge_order=2))

    own = derivative(values_of("approach")) if step == "load" else 1.0
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
    """Means over the repetitions of what `_sums_of` gives, as of one repetition."""
    names = [name for name in (*SUMS, *_of_step(what, step)) if name in dataset]
    total: list[Sums] = []
    for piece in pieces(dataset, names):
        added = [sums.each(lambda values: values.sum(axis=-1, keepdims=True)) for sums in _sums_of(piece, what, step)]
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
