"""Ensemble means at a load: read off along the approach, with an interval from the repetitions.

An ensemble value at a load is a ratio of means over the repetitions, not a mean of ratios; repetitions without contact
count as zeros. The load is reached where mean(F_N), linear between approaches, first crosses it upwards; nothing is
extrapolated.
"""

from __future__ import annotations

import functools
import math
import operator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE, Sums, Validity
from stiction.mechanics.quantities import QUANTITIES, SUMS, VALIDITY, attributes_of

if TYPE_CHECKING:
    import xarray

CONFIDENCE = 0.95

_DIMS = ("fractal_dimension", "amplitude", "repetition", "approach")


@dataclass(frozen=True)
class Crossing:
    """Where curves (c, k) first reach loads (l,): between approaches index - 1 and index, at a fraction of the step."""

    index: NDArray[np.intp]  # (c, l)
    fraction: Floats  # (c, l)
    reached: NDArray[np.bool_]  # (c, l)
    below: NDArray[np.bool_]  # (c, l): the load is less than that of the first approach

    @classmethod
    def of(cls, normal: Floats, loads: Floats) -> Crossing:
        """First upward crossings of loads (l,) by curves (c, k)."""
        at_least = normal[:, :, np.newaxis] >= loads  # (c, k, l)
        reaches = np.concatenate([normal[:, :1, np.newaxis] == loads, ~at_least[:, :-1] & at_least[:, 1:]], axis=1)
        reached: NDArray[np.bool_] = np.any(reaches, axis=1)
        index = reaches.argmax(axis=1)
        below = ~reached & at_least[:, 0]
        before = np.take_along_axis(normal, np.maximum(index - 1, 0), axis=1)
        step = np.take_along_axis(normal, index, axis=1) - before
        fraction = np.divide(loads - before, step, out=np.ones_like(before), where=step > 0)
        return cls(index, fraction, reached, below)

    def at(self, values: Floats) -> Floats:
        """(c, l): values (c, k) where the loads are reached."""
        after = np.take_along_axis(values, self.index, axis=1)
        before = np.take_along_axis(values, np.maximum(self.index - 1, 0), axis=1)
        return before + self.fraction * (after - before)

    def slope(self, values: Floats, normal: Floats) -> Floats:
        """(c, l): change of values per change of normal load over the step in which a load is reached."""
        previous = np.maximum(self.index - 1, 0)
        rise = np.take_along_axis(values, self.index, axis=1) - np.take_along_axis(values, previous, axis=1)
        run = np.take_along_axis(normal, self.index, axis=1) - np.take_along_axis(normal, previous, axis=1)
        return np.divide(rise, run, out=np.zeros_like(rise), where=run > 0)


def _read_off(normal: Floats, values: Floats, loads: Floats) -> tuple[Floats, Floats, Floats, Crossing]:
    """Mean of values (r, k) at loads (l,), read off along mean normal loads (r, k), and its interval.

    Few repetitions that carry load make an interval too narrow: 5 lognormal ones cover 81 to 94 % of the time, 24 and
    more 89 to 95 %. It is NaN where fewer than two carry any.

    The interval is a jackknife over the repetitions of the logarithm, which is the natural scale of a ratio of positive
    means, with Student's t at the degrees of freedom that the kurtosis of the jackknife values leaves (Satterthwaite).
    """
    repetitions = normal.shape[0]
    mean_normal = normal.mean(axis=0, keepdims=True)
    mean_values = values.mean(axis=0, keepdims=True)
    crossing = Crossing.of(mean_normal, loads)
    mean = np.where(crossing.reached, crossing.at(mean_values), np.nan)[0]
    carrying = np.count_nonzero(normal.any(axis=1))
    if carrying < 2:
        return mean, np.full_like(mean, np.nan), np.full_like(mean, np.nan), crossing

    others_normal = (normal.sum(axis=0) - normal) / (repetitions - 1)
    others_values = (values.sum(axis=0) - values) / (repetitions - 1)
    others = Crossing.of(others_normal, loads)
    left_out = others.at(others_values)
    with np.errstate(divide="ignore", invalid="ignore"):
        logarithms = np.log(left_out)
        if not (others.reached | ~crossing.reached).all():
            # Where the mean of the others does not reach the load, to first order in what was left out.
            each = Crossing(*(np.repeat(part, repetitions, axis=0) for part in vars(crossing).values()))
            influence = each.at(values) - mean - crossing.slope(mean_values, mean_normal) * (each.at(normal) - loads)
            first_order = np.log(mean) - influence / mean / (repetitions - 1)
            logarithms = np.where(others.reached, logarithms, first_order)
        half_width = _half_width(logarithms)
        lower, upper = mean * np.exp(-half_width), mean * np.exp(half_width)
    plain = crossing.reached[0] & ~np.isfinite(logarithms).all(axis=0)
    if plain.any():
        # What is not positive has no logarithm; the interval is then symmetric, but not below zero if no value is.
        half_width = _half_width(left_out)
        least = -np.inf if (values < 0).any() else 0.0
        lower = np.where(plain, np.maximum(mean - half_width, least), lower)
        upper = np.where(plain, mean + half_width, upper)
    return mean, lower, upper, crossing


def _half_width(left_out: Floats, independent: float = math.inf) -> Floats:
    """Half the interval of a mean from its leave-one-out values (r, l), of which so many are independent."""
    from scipy.special import stdtrit

    repetitions = left_out.shape[0]
    deviations = left_out - left_out.mean(axis=0)
    powers = np.square(deviations)
    squares = powers.sum(axis=0)
    kurtosis = repetitions * np.divide(
        np.square(powers).sum(axis=0), squares**2, out=np.full_like(squares, 3.0 / repetitions), where=squares > 0
    )
    freedom = np.clip(2 * repetitions / np.maximum(kurtosis - 1, 1e-9), 1, max(min(repetitions, independent) - 1, 1))
    error = np.sqrt((repetitions - 1) / repetitions * squares)
    return np.asarray(stdtrit(freedom, 0.5 + CONFIDENCE / 2) * error)


def mean_of_neighbours(values: Floats) -> tuple[float, float, float]:
    """Mean of values (r,) in the order in which they are neighbours, and its interval.

    The interval is that of `_read_off` for independent values, wider by the square root of (1 + ρ)/(1 - ρ), with ρ the
    correlation of neighbours, and with Student's t for as many fewer values. It is NaN for fewer than two values, where
    all are equal, because their spread is then not known, and where it would go from a thirtieth to thirty times the
    mean and beyond.
    """
    mean = float(values.mean()) if values.size else math.nan
    if values.size < 2 or (values == values[0]).all():
        return mean, math.nan, math.nan
    correlation = _correlation_of_neighbours(values)
    wider = math.sqrt((1 + correlation) / (1 - correlation))
    left_out = (values.sum() - values[:, np.newaxis]) / (values.size - 1)
    if (left_out > 0).all():
        half_width = float(_half_width(np.log(left_out), values.size / wider**2)[0]) * wider
        if half_width > _ENDLESS:
            return mean, math.nan, math.nan
        return mean, mean * math.exp(-half_width), mean * math.exp(half_width)
    half_width = float(_half_width(left_out, values.size / wider**2)[0]) * wider
    least = 0.0 if (values >= 0).all() else -math.inf
    return mean, max(mean - half_width, least), mean + half_width


_ENDLESS = math.log(30)
"""Logarithm of the factor to both sides beyond which an interval says nothing; so few values have none."""


def _correlation_of_neighbours(values: Floats) -> float:
    """Lag-one autocorrelation, at least 0; its estimate from few values is too low by about one over their number."""
    deviations = values - values.mean()
    estimate = float(deviations[1:] @ deviations[:-1] / (deviations @ deviations)) + 1 / values.size
    return min(max(estimate, 0.0), 1 - 2 / values.size)


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
        and the figures of `Validity`, over fractal_dimension, amplitude, load (mN), mu0 and tau0 (GPa). The status is
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
    fine as the approaches are; it can be negative, because load is not monotone in approach.

    Raises
    ------
    ValueError
        As `friction_map`, and with fewer than three approaches.
    """
    if dataset.sizes.get("approach", 0) < 3:
        raise ValueError(f"a stiffness needs at least 3 approaches, got {dataset.sizes.get('approach', 0)}")
    return _map(dataset, loads, mu0, tau0, "normal_stiffness")


def _map(
    dataset: xarray.Dataset, loads: ArrayLike, mu0: ArrayLike | None, tau0: ArrayLike | None, what: str
) -> xarray.Dataset:
    import xarray

    load_values = _list("loads", loads)
    if not load_values.size or not (load_values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {loads!r}")
    mu0_values, tau0_values = _parameters(dataset, mu0, tau0)
    missing = [name for name in _DIMS if not dataset.sizes.get(name)]
    if missing:
        raise ValueError(f"the dataset has nothing along {missing[0]!r}")
    data = dataset.transpose(*_DIMS, ...)
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
        for m, t in np.ndindex(shape[3:]):
            normal = friction.normal_load(pair, mu0_values[m], tau0_values[t])
            match what:
                case "contact_area":
                    values = pair.contact_area
                case "normal_stiffness":
                    values = np.gradient(normal, data["approach"].values, axis=1, edge_order=2)
                case _:
                    values = friction.tangential_load(pair, mu0_values[m], tau0_values[t])
            here = (d, a, slice(None), m, t)
            mean[here], lower[here], upper[here], crossing = _read_off(normal, values, load_values)
            status[here] = _status(touched, _locked(pair, normal), crossing)
            if judged:
                for name, figure in vars(Validity.of(pair.each(functools.partial(_mean_at, crossing)))).items():
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


def _mean_at(crossing: Crossing, values: NDArray[Any]) -> Floats:
    """Mean over the repetitions where the loads are reached."""
    return np.asarray(crossing.at(values.mean(axis=0)[None])[0])


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
