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
from stiction.studies.study import step_of

if TYPE_CHECKING:
    import xarray


_DIMS = ("fractal_dimension", "amplitude", "repetition")
"""And the steps of `step_of`."""

_MOTIONS = ("sliding", "direction")
"""Dimensions of results for several sliding rules and directions."""


def _read_off(normal: Floats, values: Floats, loads: Floats) -> tuple[Floats, Floats, Floats, Crossing]:
    """Mean of values (r, k) at loads (l,), read off along mean normal loads (r, k), and its interval."""
    crossing = Crossing.of(normal.mean(axis=0, keepdims=True), loads)
    mean = np.where(crossing.reached, crossing.at(values.mean(axis=0, keepdims=True)), np.nan)[0]
    return mean, *intervals.of_ratio_at_load(normal, values, crossing, loads), crossing


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
            each = [_map(dataset.isel({motion: i}), loads, mu0, tau0, what) for i in range(dataset.sizes[motion])]
            whole = xarray.concat(each, dim=motion, coords="minimal", compat="override", join="override")
            return whole.assign_coords({motion: dataset[motion].variable})
    load_values = _list("loads", loads)
    if not load_values.size or not (load_values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {loads!r}")
    mu0_values, tau0_values = _parameters(dataset, mu0, tau0)
    step = step_of(dataset)
    missing = [name for name in (*_DIMS, step) if not dataset.sizes.get(name)]
    if missing:
        raise ValueError(f"the dataset has nothing along {missing[0]!r}")
    data = dataset.transpose(*_DIMS, step)
    shape = (
        data.sizes["fractal_dimension"], data.sizes["amplitude"], load_values.size, mu0_values.size, tau0_values.size,
    )  # fmt: skip
    mean, lower, upper = (np.full(shape, np.nan) for _ in range(3))
    validity = {name: np.full(shape, np.nan) for name in VALIDITY}
    status = np.full(shape, friction.STATUS_OK, dtype=STATUS_DTYPE)
    sums = _sums_of(data, what)
    judged = all(name in data for name in SUMS)  # a dataset of loads alone still has a friction coefficient
    for d, a in np.ndindex(shape[:2]):
        pair = sums.each(operator.itemgetter((d, a)))
        touched = bool(pair.contact_count.any())
        means = np.array([getattr(pair, name).mean(axis=0) for name in SUMS])
        for m, t in np.ndindex(shape[3:]):
            normal = friction.normal_load(pair, mu0_values[m], tau0_values[t])
            match what:
                case "contact_area":
                    values = pair.contact_area
                case "normal_stiffness":
                    values = np.gradient(normal, data[step].values, axis=1, edge_order=2)
                    if step == "load":
                        own = data["approach"].values[d, a]
                        values = values / np.gradient(own, data[step].values, axis=1, edge_order=2)
                case _:
                    values = friction.tangential_load(pair, mu0_values[m], tau0_values[t])
            here = (d, a, slice(None), m, t)
            mean[here], lower[here], upper[here], crossing = _read_off(normal, values, load_values)
            status[here] = _status(touched, _locked(pair, normal), crossing)
            if judged:
                there = Sums(**dict(zip(SUMS, crossing.at(means), strict=True)))
                for name, figure in vars(Validity.of(there)).items():
                    validity[name][here] = np.where(crossing.reached[0], figure, np.nan)
    if what == "friction_coefficient":
        for array in (mean, lower, upper):
            array /= load_values[:, np.newaxis, np.newaxis]
    coordinates: dict[str, Any] = {
        "fractal_dimension": data["fractal_dimension"].variable,
        "amplitude": data["amplitude"].variable,
        "load": ("load", load_values, {"units": "mN", "long_name": "normal load"}),
        "mu0": ("mu0", mu0_values, {"units": "1", "long_name": "molecular friction coefficient"}),
        "tau0": ("tau0", tau0_values, {"units": "GPa", "long_name": "adhesive shear strength"}),
    }
    dims = tuple(coordinates)
    coordinates |= {motion: data[motion].variable for motion in _MOTIONS if motion in data.coords}
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


_NEEDED = {
    "friction_coefficient": ("tangential_elastic", "tangential_frictional", "tangential_adhesive"),
    "contact_area": ("contact_area",),
    "normal_stiffness": (),
}
"""What a quantity is made of, beside the normal load and the number of contacts."""


def _sums_of(data: xarray.Dataset, what: str) -> Sums:
    """The sums of a dataset as plain arrays; those that `what` does not need may be missing, and are NaN then."""
    for name in ("contact_count", "normal_elastic", "normal_frictional", "normal_adhesive", *_NEEDED[what]):
        if name not in data:
            raise ValueError(f"the dataset has no variable {name!r}")
    missing = np.full(data["contact_count"].shape, np.nan)
    return Sums.of({name: data[name].values if name in data else missing for name in SUMS})


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
    """Whether contacts at the largest approach carry no normal load, because friction holds them."""
    return bool(pair.contact_count[:, -1].any() and normal[:, -1].mean() <= 0)


def _status(touched: bool, locked: bool, crossing: Crossing) -> NDArray[np.str_]:
    return friction.status_of(touched=touched, reached=crossing.reached[0], below=crossing.below[0], locked=locked)
