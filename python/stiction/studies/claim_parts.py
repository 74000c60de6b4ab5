"""The numbers that the paper's claims come down to, each with the range that a claim wants it in."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from stiction._checks import Floats
from stiction.studies.resampled import FLATTER, STEEPER, Quantity, Resampled


@dataclass(frozen=True)
class Band:
    """A number, and its interval from bands."""

    value: float
    lower: float
    upper: float


Measure = Callable[[Resampled], "Floats | Band"]


@dataclass(frozen=True)
class Part:
    """One number of a claim, and the range that the claim wants it in."""

    name: str
    statement: str
    least: float
    most: float
    measure: Measure

    @property
    def claim(self) -> int:
        """Number of the claim that it is a part of."""
        return int(self.name.rstrip("abcd"))


def _mean(r: Resampled, values: Floats, start: float, stop: float) -> Floats:
    """Mean over fractal dimensions in a range."""
    kept = values[:, r.usable(values, r.within(start, stop))]
    return np.asarray(np.nansum(kept, axis=1) / np.isfinite(kept).sum(axis=1))


def _extreme(r: Resampled, arrays: list[Floats], pick: np.ufunc) -> Floats | Band:
    """The largest (fmax) or smallest (fmin) of several quantities over the D at which all have one."""
    usable = r.usable(np.sum(arrays, axis=0), r.within(*_ALL))
    kept = np.concatenate([values[:, usable] for values in arrays], axis=1)
    if r.ruling == "percentiles" or not kept.size:
        return np.asarray(pick.reduce(kept, axis=1, initial=np.nan))
    # In 95 of 100 ensembles no value is further off than so many of its standard deviations.
    spread = np.nanstd(kept[1:], axis=0)
    known = spread > 0
    off = np.abs(kept[1:, known] - kept[0, known]) / spread[known]
    reach = float(np.quantile(np.fmax.reduce(off, axis=1, initial=0.0), 0.95)) * spread
    least = 0.0 if (kept[0] >= 0).all() else -math.inf
    ends = [float(pick.reduce(kept[0] + side * reach)) for side in (-1, 1)]
    return Band(float(pick.reduce(kept[0])), max(ends[0], least), ends[1])


def _slope(r: Resampled, values: Floats, start: float, stop: float) -> Floats:
    """Least-squares slope over fractal dimensions in a range."""
    kept = r.usable(values, r.within(start, stop))
    if kept.sum() < 2:
        return np.full(values.shape[0], np.nan)
    x = r.dimensions[kept] - r.dimensions[kept].mean()
    return np.asarray((values[:, kept] * x).sum(axis=1) / (x * x).sum())


# Ranges of fractal dimensions.
_LOW, _MIDDLE, _UPPER, _HIGH = (1.0, 1.2), (1.3, 1.5), (1.4, 1.5), (1.6, 1.7)
_ALL = (1.0, 1.7)
_MINIMUM = (1.25, 1.55)


def _linearity(r: Resampled) -> Floats | Band:
    load, area = r.sums("normal_elastic", r.amplitude), r.sums("contact_area", r.amplitude)
    factor = (area * load).sum(axis=2, keepdims=True) / (load * load).sum(axis=2, keepdims=True)
    residual = ((area - factor * load) ** 2).sum(axis=2)
    return _extreme(r, [1 - residual / ((area - area.mean(axis=2, keepdims=True)) ** 2).sum(axis=2)], np.fmin)


def _exponent(r: Resampled) -> Floats:
    load, area = np.log(r.sums("normal_elastic", r.amplitude)), np.log(r.sums("contact_area", r.amplitude))
    known = np.isfinite(load + area)
    load, area = np.where(known, load, 0.0), np.where(known, area, 0.0)
    load -= np.where(known, load.sum(axis=2, keepdims=True) / known.sum(axis=2, keepdims=True), 0.0)
    exponents = (area * load).sum(axis=2) / (load * load).sum(axis=2)
    kept = exponents[:, r.usable(exponents, r.within(*_ALL))]
    if not kept.size:
        return np.full(exponents.shape[0], np.nan)
    return np.asarray(kept[:, np.argmax(np.abs(kept[0] - 1))])  # where the ensemble itself is farthest from linear


def _growth(r: Resampled) -> Floats:
    logarithm = np.log(r.at("friction", r.middle))
    return np.exp(_mean(r, logarithm, *_UPPER) - _mean(r, logarithm, *_LOW))


def _steepening(r: Resampled) -> Floats:
    logarithm = np.log(r.at("friction", r.middle))
    return _slope(r, logarithm, 1.5, 1.7) - _slope(r, logarithm, 1.0, 1.5)


def _amplification(r: Resampled) -> Floats:
    gained = r.at("friction", r.middle, mu0=1.0) - r.at("friction", r.middle, mu0=0.1)
    return _mean(r, gained, *_UPPER) - _mean(r, gained, *_LOW)


def _by_adhesion(r: Resampled, load: float | Floats, amplitude: float | None = None) -> Floats:
    return r.at("friction", load, tau0=0.2, amplitude=amplitude) - r.at("friction", load, amplitude=amplitude)


def _ratios(r: Resampled, tau0: float) -> list[Floats]:
    """Friction with adhesion over that without, at three loads."""
    return [r.at("friction", load, tau0=tau0) / r.at("friction", load) for load in (r.light, r.middle, r.heavy)]


def _raised(r: Resampled) -> Floats | Band:
    return _extreme(r, _ratios(r, 0.2), np.fmin)


def _raised_at_low_dimensions(r: Resampled) -> Floats:
    raised = _by_adhesion(r, r.middle)
    return _mean(r, raised, *_LOW) - _mean(r, raised, *_HIGH)


def _raised_at_low_load(r: Resampled) -> Floats:
    return _mean(r, _by_adhesion(r, r.light) - _by_adhesion(r, r.heavy), *_ALL)


def _of_weak_adhesion(r: Resampled) -> Floats | Band:
    return _extreme(r, [np.abs(ratio - 1) for ratio in _ratios(r, 0.001)], np.fmax)


def _dip_from(start: float, stop: float) -> Measure:
    def measure(r: Resampled) -> Floats:
        logarithm = np.log(r.at("friction", r.middle, tau0=0.2))
        return np.exp(_mean(r, logarithm, start, stop) - _mean(r, logarithm, *_MIDDLE))

    return measure


def _minimum(r: Resampled) -> Floats:
    values = r.at("friction", r.middle, tau0=0.2)
    kept = r.usable(values, r.within(*_ALL))
    if not kept.any():
        return np.full(values.shape[0], np.nan)
    least = np.argmin(np.where(np.isfinite(values[:, kept]), values[:, kept], np.inf), axis=1)
    found = np.asarray(r.dimensions[kept][least])
    # The last D is no minimum where friction may fall further within the range that the claim speaks of.
    end = r.dimensions[kept][-1]
    return np.full(found.shape, np.nan) if found[0] == end < _MINIMUM[1] else found


def _light_over_heavy(r: Resampled) -> Floats:
    logarithm = np.log(r.at("friction", r.light) / r.at("friction", r.heavy))
    return np.exp(_mean(r, logarithm, 1.5, 1.7))


def _below_mu0(r: Resampled) -> Floats | Band:
    return _extreme(r, [r.at("friction", r.middle) / 0.4], np.fmin)


def _steeper_over_flatter(what: Quantity, tau0: float) -> Measure:
    def measure(r: Resampled) -> Floats:
        loads = r.middle_of_all_amplitudes()
        if loads is None:
            return np.array([math.nan])
        steeper, flatter = (r.at(what, loads, tau0=tau0, amplitude=a) for a in (STEEPER, FLATTER))
        return np.exp(_mean(r, np.log(steeper / flatter), *_ALL))

    return measure


def _rise_of_flatter(r: Resampled) -> Floats:
    loads = r.middle_of_all_amplitudes()
    if loads is None:
        return np.array([math.nan])
    ratio = np.log(r.at("friction", loads, amplitude=FLATTER) / r.at("friction", loads, amplitude=STEEPER))
    return np.exp(_mean(r, ratio, 1.5, 1.6) - _mean(r, ratio, *_LOW))


def _adhesion_of_flatter(r: Resampled) -> Floats:
    loads = r.middle_of_all_amplitudes()
    if loads is None:
        return np.array([math.nan])
    return _mean(r, _by_adhesion(r, loads, FLATTER) - _by_adhesion(r, loads, STEEPER), *_LOW)


def _change(what: Quantity, one: dict[str, float], other: dict[str, float]) -> Measure:
    def measure(r: Resampled) -> Floats | Band:
        return _extreme(r, [np.abs(r.at(what, r.middle, **one) / r.at(what, r.middle, **other) - 1)], np.fmax)

    return measure


_BY_MU0 = ({"mu0": 1.0}, {"mu0": 0.1})
_BY_TAU0 = ({"tau0": 0.2}, {"tau0": 0.0})
_SAME = "largest change over D by"

PARTS = (
    Part("1a", "smallest R² over D of a line A = c F_N", 0.95, math.inf, _linearity),
    Part("1b", "exponent of A ∝ F_N^p, at the D where it is farthest from 1", 0.9, 1.1, _exponent),
    Part("2a", "friction at D = 1.4 to 1.5 over that at D = 1 to 1.2", 1.0, math.inf, _growth),
    Part("2b", "slope of ln mu_s against D: above D = 1.5 minus below", 0.0, math.inf, _steepening),
    Part("2c", "rise of mu_s from D up to 1.2 to D = 1.4 to 1.5: mu0 = 1, less 0.1", 0.0, math.inf, _amplification),
    Part("3a", "least friction at 200 MPa over that at 0, of all D and three loads", 1.0, math.inf, _raised),
    Part("3b", "rise of mu_s by 200 MPa: D up to 1.2, less D from 1.6", 0.0, math.inf, _raised_at_low_dimensions),
    Part("3c", "rise of mu_s by 200 MPa: light load, less heavy load", 0.0, math.inf, _raised_at_low_load),
    Part(
        "3d", "largest relative change of mu_s by 1 MPa, of all D and three loads", -math.inf, 0.05, _of_weak_adhesion
    ),
    Part("4a", "friction at 200 MPa: D = 1 to 1.2 over D = 1.3 to 1.5", 1.0, math.inf, _dip_from(*_LOW)),
    Part("4b", "friction at 200 MPa: D = 1.6 to 1.7 over D = 1.3 to 1.5", 1.0, math.inf, _dip_from(*_HIGH)),
    Part("4c", "D of least friction at 200 MPa", *_MINIMUM, _minimum),
    Part("5", "friction at light over that at heavy load, D from 1.5", 1.0, math.inf, _light_over_heavy),
    Part("6", "least mu_s/mu0 over D, mu0 = 0.4", -math.inf, 1.0, _below_mu0),
    Part("7a", "A/F_N at 0.2 µm over that at 0.05 µm", -math.inf, 1.0, _steeper_over_flatter("area", 0.0)),
    Part("7b", "friction at 200 MPa: 0.2 µm over 0.05 µm", -math.inf, 1.0, _steeper_over_flatter("friction", 0.2)),
    Part("7c", "rise of friction to D = 1.5 to 1.6: 0.05 µm over 0.2 µm", -math.inf, 1.0, _rise_of_flatter),
    Part("7d", "rise of mu_s by 200 MPa at D up to 1.2: 0.05 µm, less 0.2 µm", 0.0, math.inf, _adhesion_of_flatter),
    Part("8a", f"{_SAME} mu0 0.1 → 1 of the area", -math.inf, 0.1, _change("area", *_BY_MU0)),
    Part("8b", f"{_SAME} tau0 0 → 200 MPa of the area", -math.inf, 0.1, _change("area", *_BY_TAU0)),
    Part("8c", f"{_SAME} mu0 0.1 → 1 of the stiffness", -math.inf, 0.1, _change("stiffness", *_BY_MU0)),
    Part("8d", f"{_SAME} tau0 0 → 200 MPa of the stiffness", -math.inf, 0.1, _change("stiffness", *_BY_TAU0)),
)
"""At mu0 = 0.4, tau0 = 0 and the middle load unless a part says otherwise."""
