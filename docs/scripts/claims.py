"""Test the claims of the paper, and write the tables of claims.md and friction.md into docs/generated.

`./dev claims` runs this script after it has computed the studies of the figures in build/claims. `--repetitions 2000`
adds tables for 2000 repetitions, and `--columns` adds areas, half-planes and half-spaces with fewer repetitions.

Hanaor, Gan & Einav, Tribology International 93 (2016) 229. A claim has one or more parts. A part is a number
with a range. The part is true if the number's 95 % interval is inside the range, false if it is outside, and undecided
if it contains an end of the range. A claim is true if all of its parts are true, false if any part is false, and
undecided otherwise. All numbers and ranges were defined before any of them was computed.

Intervals are percentiles over resampled ensembles (bootstrap over the repetitions). Fractal
dimensions are excluded if the quantity has no value, or has none in more than one of forty resampled ensembles, because
friction is self-locking or the load is not reached. The outcome lists excluded dimensions.

The percentile rule has two faults. The largest of many noisy values grows with the noise, so that its interval may
exclude the value itself; and above D = 1.65 a few pairs that are nearly self-locking dominate a mean. A second rule
(`IntervalMethod` "bands") avoids both: the interval of an extreme over D follows from simultaneous bands for all
values, and for profiles with asperities D is at most 1.65.
"""

import argparse
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import SimpleNamespace
from typing import Any, Literal

import numpy as np
import xarray
from numpy.typing import ArrayLike, NDArray
from stiction import Study, open_result, run
from stiction.evaluate.intervals import LoadCrossings
from stiction.mechanics import friction
from stiction.study.study import parse_study_of_dataset

Floats = NDArray[np.float64]
SlidingRule = Literal["opposing", "all"]
ClaimQuantity = Literal["friction", "area", "stiffness"]
IntervalMethod = Literal["percentiles", "bands"]
"""Method for the interval of an extreme over D: percentiles of resampled ensembles, or simultaneous bands."""

Verdict = Literal["true", "false", "undecided", "undefined"]

ROOT = Path(__file__).resolve().parents[2]

MIN_REPETITIONS = 20
"""Minimum number of repetitions that a verdict requires."""

MAX_FRACTAL_DIMENSION_IN_BANDS = 1.65
"""Largest fractal dimension in simultaneous bands of profiles with the asperity model."""

NUM_RESAMPLES = 400

LOW_AMPLITUDE, HIGH_AMPLITUDE = 0.05, 0.2
"""Amplitudes (µm) of the claim about amplitudes."""

_CONTACT_SUM_NAMES = (
    "contact_area",
    *(f"{load}_{part}" for load in ("normal", "tangential") for part in ("elastic", "frictional", "adhesive")),
)

CLAIMS = {
    1: "The true contact area is linear in the load, for every D.",
    2: "Friction grows with D, most for D > 1.5, and mu0 amplifies it.",
    3: "tau0 raises friction everywhere, most at low D and low load; up to 1 MPa it cannot be told from none.",
    4: "At high tau0 friction has a minimum at an intermediate D, about 1.3 to 1.5.",
    5: "At high D, friction is higher at low load.",
    6: "Friction can be lower than mu0.",
    7: "A larger amplitude lowers A/F_N, and at tau0 = 200 MPa friction; flatter surfaces show the rise at high D "
    "less, and the adhesion at low D more.",
    8: "mu0 and tau0 change the area at a load and the normal stiffness only slightly.",
}

STUDY_VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "default": {},
    "Ra": {"surfaces.amplitude_measure": "Ra"},
    "signed": {"contact.curvature": "signed"},
    "gap-minimum": {"contact.detection": "gap-minimum"},
    "band-limited": {"surfaces.band_limit": "nyquist"},
}
"""Variants of the default study for choices that the paper leaves open, as changed keys by name of the variant."""


@dataclass(frozen=True)
class ClaimsTableColumn:
    """Column of the table of claims: a built-in study with changes, and a sliding rule.

    Attributes
    ----------
    study : str
    changes : mapping
        Values by key of the study.
    sliding : {"opposing", "all"}
    divisor : int
        Number of repetitions of the default study divided by that of this study, which takes longer per repetition.
    directory : str
        Directory of the result; columns that differ only in the sliding rule share it.
    """

    study: str
    changes: Mapping[str, Any]
    sliding: SlidingRule
    divisor: int
    directory: str

    def to_study(self, repetitions: int) -> Study:
        """Return the study of the column, with the fraction of `repetitions` that the column specifies."""
        reduced_repetitions = max(MIN_REPETITIONS, repetitions // self.divisor)
        return Study.named(self.study).with_changes({**self.changes, "ensemble.repetitions": reduced_repetitions})


_OVERRIDES_FOR_THREE_AMPLITUDES = {"surfaces.amplitude": ["0.05 um", "0.1 um", "0.2 um"]}
_OVERRIDES_FOR_HEIGHT_MAPS = {
    **_OVERRIDES_FOR_THREE_AMPLITUDES,
    "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 15},
}
_OVERRIDES_FOR_HALF_PLANES = {
    "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.5, "count": 6},
    "surfaces.points": 65_536,
    "contact.load": {"start": "0.01 mN", "stop": "1 mN", "count": 5, "spacing": "geometric"},
}
_OVERRIDES_FOR_HALF_SPACES = {
    **_OVERRIDES_FOR_THREE_AMPLITUDES,
    "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 8},
    "surfaces.shape": [256, 256],
    "contact.mechanics": "half-space",
    "contact.load": {"start": "0.1 mN", "stop": "3 mN", "count": 5, "spacing": "geometric"},
}
_OVERRIDES_FOR_GAP_MINIMUM_DETECTION = {"contact.detection": "gap-minimum"}
_OVERRIDES_FOR_FRICTION_AT_ALL_CONTACTS = {
    **_OVERRIDES_FOR_GAP_MINIMUM_DETECTION,
    "contact.sliding": "all",
    "surfaces.fractal_dimension.count": 15,
}

CLAIMS_TABLE_COLUMNS: Mapping[str, ClaimsTableColumn] = {
    "profiles, gap-minimum detection": ClaimsTableColumn(
        "figure7", _OVERRIDES_FOR_GAP_MINIMUM_DETECTION, "opposing", 20, "gap-minima"
    ),
    "profiles, gap-minimum detection, friction at all contacts": ClaimsTableColumn(
        "figure7", _OVERRIDES_FOR_FRICTION_AT_ALL_CONTACTS, "all", 20, "gap-minima-all"
    ),
    "height maps, asperities": ClaimsTableColumn("figure6-areal", _OVERRIDES_FOR_HEIGHT_MAPS, "opposing", 80, "areas"),
    "height maps, asperities, friction at all contacts": ClaimsTableColumn(
        "figure6-areal", _OVERRIDES_FOR_HEIGHT_MAPS, "all", 80, "areas"
    ),
    "half-planes": ClaimsTableColumn("figure6-half-plane", _OVERRIDES_FOR_HALF_PLANES, "opposing", 100, "half-planes"),
    "half-planes, friction at all contacts": ClaimsTableColumn(
        "figure6-half-plane", _OVERRIDES_FOR_HALF_PLANES, "all", 100, "half-planes"
    ),
    "half-spaces": ClaimsTableColumn("figure6-areal", _OVERRIDES_FOR_HALF_SPACES, "opposing", 66, "half-spaces"),
    "half-spaces, friction at all contacts": ClaimsTableColumn(
        "figure6-areal", _OVERRIDES_FOR_HALF_SPACES, "all", 66, "half-spaces"
    ),
}
"""Columns of the table of claims, by title."""


def column_titles(repetitions: int) -> dict[str, str]:
    """Return the heading of each column by title: the title and the number of repetitions."""
    return {
        name: f"{name}, {column.to_study(repetitions).ensemble.repetitions}"
        for name, column in CLAIMS_TABLE_COLUMNS.items()
    }


def check_study_suits_claims(study: Study) -> None:
    """Raise a `ValueError` if claims cannot be tested on the result of a study. Nothing is computed."""
    if "direction" in study.motion_coordinates():
        raise ValueError("claims are judged on motion in one direction, and contact.direction is a list")
    if study.ensemble.repetitions < MIN_REPETITIONS:
        raise ValueError(
            f"claims need at least {MIN_REPETITIONS} ensemble.repetitions, got {study.ensemble.repetitions}"
        )
    loading_steps = study.contact.loading_steps()
    if loading_steps.size < 3:
        raise ValueError(
            f"claims need at least 3 values of contact.{study.contact.step_quantity}, got {loading_steps.size}"
        )
    if study.contact.mechanics == "asperities" and not has_claim_amplitudes(study.surfaces.amplitudes()):
        raise ValueError(
            f"claims need amplitudes of {LOW_AMPLITUDE:g} and {HIGH_AMPLITUDE:g} µm among surfaces.amplitude"
        )


def claims_study() -> Study:
    """Return the study that tests the claims: 50 fractal dimensions, three amplitudes, 100 repetitions."""
    return Study.named("figure7")


def variant_study(name: str) -> Study:
    """Return the study of a variant, at 15 fractal dimensions."""
    return claims_study().with_changes({"surfaces.fractal_dimension.count": 15, **STUDY_VARIANTS[name]})


# ---- Resampled ensembles ---------------------------------------------------------------------------------------------


def has_claim_amplitudes(amplitudes: Floats) -> bool:
    """Return whether the amplitudes (µm) of a result include those of claim 7."""
    return all(bool(np.isclose(amplitudes, item, rtol=1e-9).any()) for item in (LOW_AMPLITUDE, HIGH_AMPLITUDE))


class ResampledMeans:
    """Ensemble means of a result, and of bootstrap resamples of its repetitions.

    Arrays (resample, D) are for one amplitude at a time. Resample 0 is the ensemble itself.
    """

    def __init__(
        self,
        dataset: xarray.Dataset,
        amplitude: float,
        *,
        sliding: SlidingRule | None = None,
        interval_method: IntervalMethod = "percentiles",
    ) -> None:
        study = parse_study_of_dataset(dataset)
        self._step_quantity = study.contact.step_quantity
        rules = study.contact.sliding_rules()
        if (sliding or rules[0]) not in rules:
            raise ValueError(f"the result has no sliding rule {sliding!r}, it has {', '.join(rules)}")
        motion_dataset = dataset.sel(sliding=sliding or rules[0]) if "sliding" in dataset.dims else dataset
        if interval_method == "bands" and study.surfaces.kind == "profile" and study.contact.mechanics == "asperities":
            motion_dataset = motion_dataset.sel(
                fractal_dimension=motion_dataset["fractal_dimension"] <= MAX_FRACTAL_DIMENSION_IN_BANDS
            )
        self.interval_method = interval_method
        repetitions = motion_dataset.sizes["repetition"]
        generator = np.random.default_rng(study.ensemble.seed)
        equal_weights = np.full(repetitions, 1 / repetitions)
        # Store as a byte how often each repetition occurs in a resample.
        draw_counts = np.ones((1 + NUM_RESAMPLES, repetitions), np.uint8)
        for resample_counts in draw_counts[1:]:
            resample_counts[:] = generator.multinomial(repetitions, equal_weights)
        dimension_order = ("repetition", "fractal_dimension", "amplitude", self._step_quantity)
        sum_names = (*_CONTACT_SUM_NAMES, "approach") if self._step_quantity == "load" else _CONTACT_SUM_NAMES
        self._means: dict[str, Floats] = {}
        weights = draw_counts / repetitions
        for name in sum_names:
            self._means[name] = np.tensordot(weights, motion_dataset[name].transpose(*dimension_order).values, axes=1)
        self.dimensions = motion_dataset["fractal_dimension"].values
        self._loading_steps = motion_dataset[self._step_quantity].values
        self._amplitudes = motion_dataset["amplitude"].values
        self.amplitude = amplitude
        self.excluded_dimensions: set[float] = set()
        min_loads, max_loads = self._reached_load_range([amplitude])
        self.light_load, self.middle_load, self.heavy_load = (
            interpolate_load_range(min_loads.max(), max_loads.min(), range_fraction).item()
            for range_fraction in (0.1, 0.5, 0.9)
        )

    def _reached_load_range(self, amplitudes: ArrayLike) -> tuple[Floats, Floats]:
        """Return the lowest and the highest elastic load that 99 % of resamples reach at all amplitudes, for each D."""
        elastic_loads = np.stack(
            [self.mean_sums("normal_elastic", amplitude) for amplitude in np.atleast_1d(amplitudes)]
        )
        min_loads = np.quantile(elastic_loads[..., 0], 0.99, axis=1).max(axis=0)
        return min_loads, np.quantile(elastic_loads.max(axis=-1), 0.01, axis=1).min(axis=0)

    def mean_sums(self, name: str, amplitude: float) -> Floats:
        """Return the mean of a contact sum at one amplitude, as an array (resample, D, approach)."""
        amplitude_index = int(np.argmin(np.abs(self._amplitudes - amplitude)))
        if not math.isclose(self._amplitudes[amplitude_index], amplitude, rel_tol=1e-9):
            raise ValueError(f"the result has no amplitude of {amplitude:g} µm, which a claim needs")
        return np.asarray(self._means[name][:, :, amplitude_index])

    def middle_load_of_all_amplitudes(self) -> Floats | None:
        """Return the geometric mean of the lowest and the highest load reached at every amplitude, for each D.

        Return None if the result lacks the amplitudes of claim 7.
        """
        if not has_claim_amplitudes(self._amplitudes):
            return None
        return interpolate_load_range(*self._reached_load_range(self._amplitudes), 0.5)

    def finite_value_mask(self, values: Floats, is_requested: Any) -> Any:
        """Return a mask of the fractal dimensions for which `values` (resample, D) exist, and record all others.

        The mask is false everywhere if fewer than half of the requested dimensions have a number, or if only one
        dimension is requested, because the remaining dimensions would not represent the range.
        """
        is_usable = is_requested & np.isfinite(values[0]) & (np.isfinite(values).mean(axis=0) > 1 - 1 / 40)
        self.excluded_dimensions.update(float(dimension) for dimension in self.dimensions[is_requested & ~is_usable])
        has_enough = is_requested.sum() > 1 and 2 * is_usable.sum() >= is_requested.sum()
        return is_usable if has_enough else np.zeros_like(is_usable)

    def evaluate_at(
        self,
        quantity: ClaimQuantity,
        load: float | Floats,
        *,
        mu0: float = 0.4,
        tau0: float = 0.0,
        amplitude: float | None = None,
    ) -> Floats:
        """Return a quantity as an array (resample, D) at one load, or at one load per D.

        It is NaN at loads not reached.
        """
        resampled_sums: Any = SimpleNamespace(
            **{name: self.mean_sums(name, amplitude or self.amplitude) for name in _CONTACT_SUM_NAMES}
        )
        normal_load = friction.FrictionLaw(mu0, tau0).load("normal", resampled_sums)
        match quantity:
            case "friction":
                values = friction.FrictionLaw(mu0, tau0).load("tangential", resampled_sums)
            case "area":
                values = resampled_sums.contact_area
            case "stiffness":
                values = np.gradient(normal_load, self._loading_steps, axis=-1, edge_order=2)
                if self._step_quantity == "load":
                    approach = self.mean_sums("approach", amplitude or self.amplitude)
                    values = values / np.gradient(approach, self._loading_steps, axis=-1, edge_order=2)
        loads = np.broadcast_to(np.asarray(load, dtype=np.float64), self.dimensions.shape)
        result = np.full(normal_load.shape[:2], np.nan)
        for dimension_index in np.flatnonzero(np.isfinite(loads)):
            load_crossing = LoadCrossings.from_curves(
                normal_load[:, dimension_index], loads[dimension_index : dimension_index + 1]
            )
            result[:, dimension_index] = np.where(
                load_crossing.reached, load_crossing.interpolate(values[:, dimension_index]), np.nan
            )[:, 0]
        return result / loads if quantity == "friction" else result

    def dimension_range_mask(self, start: float, stop: float) -> Any:
        """Return a mask of the fractal dimensions from `start` to `stop`, including both."""
        return (self.dimensions > start - 1e-9) & (self.dimensions < stop + 1e-9)


def interpolate_load_range(min_load: Any, max_load: Any, range_fraction: float) -> Floats:
    """Return the load at a fraction of the logarithmic range between two loads, or NaN if the range is empty."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(
            (min_load > 0) & (min_load < max_load), min_load * (max_load / min_load) ** range_fraction, np.nan
        )


# ---- Numbers and their ranges ----------------------------------------------------------------------------------------


@dataclass(frozen=True)
class SimultaneousInterval:
    """Number that tests a part of a claim, with the interval that simultaneous bands give."""

    value: float
    lower: float
    upper: float


MeasureFunction = Callable[[ResampledMeans], "Floats | SimultaneousInterval"]


@dataclass(frozen=True)
class ClaimPart:
    """Part of a claim: a number that can be measured, and the range of the number for which the part is true."""

    name: str
    statement: str
    min_value: float
    max_value: float
    measure: MeasureFunction

    @property
    def claim_number(self) -> int:
        """Number of the claim, which is the label of the part without its letter."""
        return int(self.name.rstrip("abcd"))


def _mean_over_dimensions(r: ResampledMeans, values: Floats, start: float, stop: float) -> Floats:
    """Return the mean over the fractal dimensions from `start` to `stop`."""
    finite_values = values[:, r.finite_value_mask(values, r.dimension_range_mask(start, stop))]
    return np.asarray(np.nansum(finite_values, axis=1) / np.isfinite(finite_values).sum(axis=1))


def _find_extreme_over_dimensions(
    r: ResampledMeans, arrays: list[Floats], extreme_function: np.ufunc
) -> Floats | SimultaneousInterval:
    """Return the largest (fmax) or smallest (fmin) number over those D at which all quantities are known."""
    is_usable = r.finite_value_mask(np.sum(arrays, axis=0), r.dimension_range_mask(*_FULL_DIMENSION_RANGE))
    usable_values = np.concatenate([values[:, is_usable] for values in arrays], axis=1)
    if r.interval_method == "percentiles" or not usable_values.size:
        return np.asarray(extreme_function.reduce(usable_values, axis=1, initial=np.nan))
    # Simultaneous 95 % band: the number of standard deviations that contain all values in 95 % of the resamples.
    standard_deviations = np.nanstd(usable_values[1:], axis=0)
    has_spread = standard_deviations > 0
    deviations = np.abs(usable_values[1:, has_spread] - usable_values[0, has_spread]) / standard_deviations[has_spread]
    band_half_width = float(np.quantile(np.fmax.reduce(deviations, axis=1, initial=0.0), 0.95)) * standard_deviations
    lower_bound = 0.0 if (usable_values[0] >= 0).all() else -math.inf
    band_ends = [float(extreme_function.reduce(usable_values[0] + side * band_half_width)) for side in (-1, 1)]
    return SimultaneousInterval(
        float(extreme_function.reduce(usable_values[0])), max(band_ends[0], lower_bound), band_ends[1]
    )


def _fit_slope_over_dimensions(r: ResampledMeans, values: Floats, start: float, stop: float) -> Floats:
    """Return the least-squares slope over the fractal dimensions from `start` to `stop`."""
    is_used = r.finite_value_mask(values, r.dimension_range_mask(start, stop))
    if is_used.sum() < 2:
        return np.full(values.shape[0], np.nan)
    x = r.dimensions[is_used] - r.dimensions[is_used].mean()
    return np.asarray((values[:, is_used] * x).sum(axis=1) / (x * x).sum())


_LOW_DIMENSION_RANGE, _MIDDLE_DIMENSION_RANGE, _UPPER_DIMENSION_RANGE, _HIGH_DIMENSION_RANGE = (
    (1.0, 1.2),
    (1.3, 1.5),
    (1.4, 1.5),
    (1.6, 1.7),
)
_FULL_DIMENSION_RANGE = (1.0, 1.7)
_DIMENSION_RANGE_OF_SMALLEST_FRICTION = (1.25, 1.55)


def _find_smallest_area_load_r_squared(r: ResampledMeans) -> Floats | SimultaneousInterval:
    load, area = r.mean_sums("normal_elastic", r.amplitude), r.mean_sums("contact_area", r.amplitude)
    proportionality = (area * load).sum(axis=2, keepdims=True) / (load * load).sum(axis=2, keepdims=True)
    residual_sum_of_squares = ((area - proportionality * load) ** 2).sum(axis=2)
    return _find_extreme_over_dimensions(
        r, [1 - residual_sum_of_squares / ((area - area.mean(axis=2, keepdims=True)) ** 2).sum(axis=2)], np.fmin
    )


def _area_exponent_farthest_from_one(r: ResampledMeans) -> Floats:
    load, area = np.log(r.mean_sums("normal_elastic", r.amplitude)), np.log(r.mean_sums("contact_area", r.amplitude))
    is_known = np.isfinite(load + area)
    load, area = np.where(is_known, load, 0.0), np.where(is_known, area, 0.0)
    load -= np.where(is_known, load.sum(axis=2, keepdims=True) / is_known.sum(axis=2, keepdims=True), 0.0)
    exponents = (area * load).sum(axis=2) / (load * load).sum(axis=2)
    usable_exponents = exponents[:, r.finite_value_mask(exponents, r.dimension_range_mask(*_FULL_DIMENSION_RANGE))]
    if not usable_exponents.size:
        return np.full(exponents.shape[0], np.nan)
    return np.asarray(
        usable_exponents[:, np.argmax(np.abs(usable_exponents[0] - 1))]
    )  # D at which the area of the ensemble itself is least linear


def _friction_ratio_upper_to_low_dimensions(r: ResampledMeans) -> Floats:
    log_friction = np.log(r.evaluate_at("friction", r.middle_load))
    return np.exp(
        _mean_over_dimensions(r, log_friction, *_UPPER_DIMENSION_RANGE)
        - _mean_over_dimensions(r, log_friction, *_LOW_DIMENSION_RANGE)
    )


def _slope_change_at_dimension_1_5(r: ResampledMeans) -> Floats:
    log_friction = np.log(r.evaluate_at("friction", r.middle_load))
    return _fit_slope_over_dimensions(r, log_friction, 1.5, 1.7) - _fit_slope_over_dimensions(r, log_friction, 1.0, 1.5)


def _mu0_effect_on_dimension_rise(r: ResampledMeans) -> Floats:
    added_friction = r.evaluate_at("friction", r.middle_load, mu0=1.0) - r.evaluate_at(
        "friction", r.middle_load, mu0=0.1
    )
    return _mean_over_dimensions(r, added_friction, *_UPPER_DIMENSION_RANGE) - _mean_over_dimensions(
        r, added_friction, *_LOW_DIMENSION_RANGE
    )


def _friction_added_by_adhesion(r: ResampledMeans, load: float | Floats, amplitude: float | None = None) -> Floats:
    return r.evaluate_at("friction", load, tau0=0.2, amplitude=amplitude) - r.evaluate_at(
        "friction", load, amplitude=amplitude
    )


def _adhesion_friction_ratios(r: ResampledMeans, tau0: float) -> list[Floats]:
    """Return the ratio of the friction coefficients with tau0 and without tau0, at three loads."""
    return [
        r.evaluate_at("friction", load, tau0=tau0) / r.evaluate_at("friction", load)
        for load in (r.light_load, r.middle_load, r.heavy_load)
    ]


def _smallest_adhesion_ratio(r: ResampledMeans) -> Floats | SimultaneousInterval:
    return _find_extreme_over_dimensions(r, _adhesion_friction_ratios(r, 0.2), np.fmin)


def _adhesion_rise_at_low_dimensions(r: ResampledMeans) -> Floats:
    added_friction = _friction_added_by_adhesion(r, r.middle_load)
    return _mean_over_dimensions(r, added_friction, *_LOW_DIMENSION_RANGE) - _mean_over_dimensions(
        r, added_friction, *_HIGH_DIMENSION_RANGE
    )


def _adhesion_rise_at_low_load(r: ResampledMeans) -> Floats:
    return _mean_over_dimensions(
        r,
        _friction_added_by_adhesion(r, r.light_load) - _friction_added_by_adhesion(r, r.heavy_load),
        *_FULL_DIMENSION_RANGE,
    )


def _largest_change_by_weak_adhesion(r: ResampledMeans) -> Floats | SimultaneousInterval:
    return _find_extreme_over_dimensions(
        r, [np.abs(ratio - 1) for ratio in _adhesion_friction_ratios(r, 0.001)], np.fmax
    )


def _make_dimension_ratio_measure(start: float, stop: float) -> MeasureFunction:
    def measure(r: ResampledMeans) -> Floats:
        log_friction_values = np.log(r.evaluate_at("friction", r.middle_load, tau0=0.2))
        return np.exp(
            _mean_over_dimensions(r, log_friction_values, start, stop)
            - _mean_over_dimensions(r, log_friction_values, *_MIDDLE_DIMENSION_RANGE)
        )

    return measure


def _dimension_of_smallest_friction(r: ResampledMeans) -> Floats:
    values = r.evaluate_at("friction", r.middle_load, tau0=0.2)
    is_used = r.finite_value_mask(values, r.dimension_range_mask(*_FULL_DIMENSION_RANGE))
    if not is_used.any():
        return np.full(values.shape[0], np.nan)
    minimum_indices = np.argmin(np.where(np.isfinite(values[:, is_used]), values[:, is_used], np.inf), axis=1)
    result = np.asarray(r.dimensions[is_used][minimum_indices])
    # If friction is smallest at the last D, it has no minimum, because it may decrease further in the claimed range.
    highest_dimension = r.dimensions[is_used][-1]
    return (
        np.full(result.shape, np.nan)
        if result[0] == highest_dimension < _DIMENSION_RANGE_OF_SMALLEST_FRICTION[1]
        else result
    )


def _ratio_of_light_to_heavy_load(r: ResampledMeans) -> Floats:
    log_ratio = np.log(r.evaluate_at("friction", r.light_load) / r.evaluate_at("friction", r.heavy_load))
    return np.exp(_mean_over_dimensions(r, log_ratio, 1.5, 1.7))


def _smallest_friction_to_mu0_ratio(r: ResampledMeans) -> Floats | SimultaneousInterval:
    return _find_extreme_over_dimensions(r, [r.evaluate_at("friction", r.middle_load) / 0.4], np.fmin)


def _make_amplitude_ratio_measure(quantity: ClaimQuantity, tau0: float) -> MeasureFunction:
    def measure(r: ResampledMeans) -> Floats:
        loads = r.middle_load_of_all_amplitudes()
        if loads is None:
            return np.array([math.nan])
        high_amplitude_values, low_amplitude_values = (
            r.evaluate_at(quantity, loads, tau0=tau0, amplitude=a) for a in (HIGH_AMPLITUDE, LOW_AMPLITUDE)
        )
        return np.exp(
            _mean_over_dimensions(r, np.log(high_amplitude_values / low_amplitude_values), *_FULL_DIMENSION_RANGE)
        )

    return measure


def _amplitude_effect_on_dimension_rise(r: ResampledMeans) -> Floats:
    loads = r.middle_load_of_all_amplitudes()
    if loads is None:
        return np.array([math.nan])
    log_ratio = np.log(
        r.evaluate_at("friction", loads, amplitude=LOW_AMPLITUDE)
        / r.evaluate_at("friction", loads, amplitude=HIGH_AMPLITUDE)
    )
    return np.exp(
        _mean_over_dimensions(r, log_ratio, 1.5, 1.6) - _mean_over_dimensions(r, log_ratio, *_LOW_DIMENSION_RANGE)
    )


def _amplitude_effect_on_adhesion_rise(r: ResampledMeans) -> Floats:
    loads = r.middle_load_of_all_amplitudes()
    if loads is None:
        return np.array([math.nan])
    return _mean_over_dimensions(
        r,
        _friction_added_by_adhesion(r, loads, LOW_AMPLITUDE) - _friction_added_by_adhesion(r, loads, HIGH_AMPLITUDE),
        *_LOW_DIMENSION_RANGE,
    )


def _make_largest_relative_change_function(
    quantity: ClaimQuantity, changed_parameters: dict[str, float], reference_parameters: dict[str, float]
) -> MeasureFunction:
    def measure(r: ResampledMeans) -> Floats | SimultaneousInterval:
        return _find_extreme_over_dimensions(
            r,
            [
                np.abs(
                    r.evaluate_at(quantity, r.middle_load, **changed_parameters)
                    / r.evaluate_at(quantity, r.middle_load, **reference_parameters)
                    - 1
                )
            ],
            np.fmax,
        )

    return measure


_HIGH_AND_LOW_MU0 = ({"mu0": 1.0}, {"mu0": 0.1})
_HIGH_AND_ZERO_TAU0 = ({"tau0": 0.2}, {"tau0": 0.0})
_LARGEST_CHANGE_TEXT = "largest relative change of the"

CLAIM_PARTS = (
    ClaimPart(
        "1a", "smallest R² for any D of a straight line A = c F_N", 0.95, math.inf, _find_smallest_area_load_r_squared
    ),
    ClaimPart(
        "1b",
        "exponent p of A ∝ F_N^p at the D with the largest deviation from 1",
        0.9,
        1.1,
        _area_exponent_farthest_from_one,
    ),
    ClaimPart(
        "2a",
        "mu_s at D = 1.4 to 1.5 divided by mu_s at D = 1 to 1.2",
        1.0,
        math.inf,
        _friction_ratio_upper_to_low_dimensions,
    ),
    ClaimPart(
        "2b", "slope of ln mu_s with D above D = 1.5 minus slope below", 0.0, math.inf, _slope_change_at_dimension_1_5
    ),
    ClaimPart(
        "2c",
        "increase of mu_s from D ≤ 1.2 to D = 1.4 to 1.5, at mu0 = 1 minus at mu0 = 0.1",
        0.0,
        math.inf,
        _mu0_effect_on_dimension_rise,
    ),
    ClaimPart(
        "3a",
        "smallest ratio of mu_s at tau0 = 200 MPa to mu_s at 0, for all D and three loads",
        1.0,
        math.inf,
        _smallest_adhesion_ratio,
    ),
    ClaimPart(
        "3b",
        "increase of mu_s by tau0 = 200 MPa at D ≤ 1.2, minus at D ≥ 1.6",
        0.0,
        math.inf,
        _adhesion_rise_at_low_dimensions,
    ),
    ClaimPart(
        "3c",
        "increase of mu_s by tau0 = 200 MPa at light load, minus at heavy load",
        0.0,
        math.inf,
        _adhesion_rise_at_low_load,
    ),
    ClaimPart(
        "3d",
        "largest relative change of mu_s by tau0 = 1 MPa, for all D and three loads",
        -math.inf,
        0.05,
        _largest_change_by_weak_adhesion,
    ),
    ClaimPart(
        "4a",
        "mu_s at tau0 = 200 MPa, D = 1 to 1.2, divided by mu_s at D = 1.3 to 1.5",
        1.0,
        math.inf,
        _make_dimension_ratio_measure(*_LOW_DIMENSION_RANGE),
    ),
    ClaimPart(
        "4b",
        "mu_s at tau0 = 200 MPa, D = 1.6 to 1.7, divided by mu_s at D = 1.3 to 1.5",
        1.0,
        math.inf,
        _make_dimension_ratio_measure(*_HIGH_DIMENSION_RANGE),
    ),
    ClaimPart(
        "4c",
        "D with the smallest mu_s at tau0 = 200 MPa",
        *_DIMENSION_RANGE_OF_SMALLEST_FRICTION,
        _dimension_of_smallest_friction,
    ),
    ClaimPart(
        "5", "mu_s at light load divided by mu_s at heavy load, D ≥ 1.5", 1.0, math.inf, _ratio_of_light_to_heavy_load
    ),
    ClaimPart("6", "smallest mu_s/mu0 for any D, mu0 = 0.4", -math.inf, 1.0, _smallest_friction_to_mu0_ratio),
    ClaimPart(
        "7a", "A/F_N at 0.2 µm divided by A/F_N at 0.05 µm", -math.inf, 1.0, _make_amplitude_ratio_measure("area", 0.0)
    ),
    ClaimPart(
        "7b",
        "mu_s at tau0 = 200 MPa, 0.2 µm, divided by mu_s at 0.05 µm",
        -math.inf,
        1.0,
        _make_amplitude_ratio_measure("friction", 0.2),
    ),
    ClaimPart(
        "7c",
        "increase of mu_s up to D = 1.5 to 1.6 at 0.05 µm divided by increase at 0.2 µm",
        -math.inf,
        1.0,
        _amplitude_effect_on_dimension_rise,
    ),
    ClaimPart(
        "7d",
        "increase of mu_s by tau0 = 200 MPa at D ≤ 1.2, at 0.05 µm minus at 0.2 µm",
        0.0,
        math.inf,
        _amplitude_effect_on_adhesion_rise,
    ),
    ClaimPart(
        "8a",
        f"{_LARGEST_CHANGE_TEXT} area for any D if mu0 changes from 0.1 to 1",
        -math.inf,
        0.1,
        _make_largest_relative_change_function("area", *_HIGH_AND_LOW_MU0),
    ),
    ClaimPart(
        "8b",
        f"{_LARGEST_CHANGE_TEXT} area for any D if tau0 changes from 0 to 200 MPa",
        -math.inf,
        0.1,
        _make_largest_relative_change_function("area", *_HIGH_AND_ZERO_TAU0),
    ),
    ClaimPart(
        "8c",
        f"{_LARGEST_CHANGE_TEXT} stiffness for any D if mu0 changes from 0.1 to 1",
        -math.inf,
        0.1,
        _make_largest_relative_change_function("stiffness", *_HIGH_AND_LOW_MU0),
    ),
    ClaimPart(
        "8d",
        f"{_LARGEST_CHANGE_TEXT} stiffness for any D if tau0 changes from 0 to 200 MPa",
        -math.inf,
        0.1,
        _make_largest_relative_change_function("stiffness", *_HIGH_AND_ZERO_TAU0),
    ),
)
"""Parts of all claims. Unless stated otherwise, mu0 is 0.4, tau0 is 0, and the load is the middle load."""


# ---- Verdicts --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ClaimPartOutcome:
    """Measured number of a part of a claim, and the verdict on the part.

    Attributes
    ----------
    part : ClaimPart
    value, lower, upper : float
        The number and its 95 % interval; NaN if undefined.
    verdict : {"true", "false", "undecided", "undefined"}
    excluded_dimensions : tuple of float
        Fractal dimensions without a value.
    """

    part: ClaimPart
    value: float
    lower: float
    upper: float
    verdict: Verdict
    excluded_dimensions: tuple[float, ...]

    @classmethod
    def judge(cls, part: ClaimPart, resampled: ResampledMeans) -> "ClaimPartOutcome":
        """Measure a part of a claim. The verdict is "undefined" if the ensemble itself gives no number."""
        resampled.excluded_dimensions.clear()
        with np.errstate(divide="ignore", invalid="ignore"):
            values = part.measure(resampled)
        excluded_dimensions = tuple(sorted(resampled.excluded_dimensions))
        if isinstance(values, SimultaneousInterval):
            value, lower, upper = values.value, values.lower, values.upper
        else:
            value, lower, upper = float(values[0]), math.nan, math.nan
            if math.isfinite(value):
                lower, upper = (float(end) for end in np.nanquantile(values[1:], [0.025, 0.975]))
        if not math.isfinite(value):
            return cls(part, math.nan, math.nan, math.nan, "undefined", excluded_dimensions)
        is_inside = part.min_value < lower and upper < part.max_value
        is_outside = upper < part.min_value or lower > part.max_value
        return cls(
            part,
            value,
            lower,
            upper,
            "true" if is_inside else "false" if is_outside else "undecided",
            excluded_dimensions,
        )


def judge_claims(
    dataset: xarray.Dataset,
    *,
    amplitude: float = 0.1,
    sliding: SlidingRule | None = None,
    interval_method: IntervalMethod = "percentiles",
) -> list[ClaimPartOutcome]:
    """Measure all parts of all claims on a result, and return one outcome per part.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of a study such as `claims_study()`: fractal dimensions from 1 to 1.7, amplitudes 0.05, 0.1 and 0.2 µm.
    amplitude : float, µm
        Amplitude for all claims but claim 7.
    sliding : {"opposing", "all"}, optional
        Sliding rule of the result; the first by default.
    interval_method : {"percentiles", "bands"}
        Rule for extreme values over D; the docstring of this script explains both rules.

    Raises
    ------
    ValueError
        If the result lacks an amplitude that is needed, or has fewer than 20 repetitions or 3 approaches.
    """
    check_study_suits_claims(parse_study_of_dataset(dataset))
    if interval_method not in ("percentiles", "bands"):
        raise ValueError(f"interval_method must be percentiles or bands, got {interval_method!r}")
    resampled = ResampledMeans(dataset, amplitude, sliding=sliding, interval_method=interval_method)
    return [ClaimPartOutcome.judge(part, resampled) for part in CLAIM_PARTS]


def claim_verdict(claim: int, outcomes: list[ClaimPartOutcome]) -> Verdict:
    """Return the verdict on a claim: "true" if all its parts are true, or else "false", "undefined" or "undecided"."""
    verdicts = {outcome.verdict for outcome in outcomes if outcome.part.claim_number == claim}
    for verdict in ("false", "undefined", "undecided"):
        if verdict in verdicts:
            return verdict
    return "true"


# ---- Tables ----------------------------------------------------------------------------------------------------------


def render_claims(outcomes: list[ClaimPartOutcome]) -> str:
    """Return a table with one row per part of a claim."""
    lines = [
        "| claim or test | verdict | statement, and its test numbers | value [95 %] | criterion |",
        "|---|---|---|---|---|",
    ]
    for claim, statement in CLAIMS.items():
        lines.append(f"| **{claim}** | {_verdict_badge(claim_verdict(claim, outcomes))} | **{statement}** | | |")
        for outcome in _outcomes_of_claim(claim, outcomes):
            part = outcome.part
            lines.append(
                f"| {part.name} | {outcome.verdict} | {part.statement}{_exclusion_text(outcome)} | "
                f"{_format_outcome(outcome)} | {_format_range(part)} |"
            )
    return _replace_symbols("\n".join(lines) + "\n")


def _verdict_badge(verdict: str) -> str:
    """Return a verdict as a coloured badge."""
    return f'<span class="verdict verdict-{verdict}">{verdict}</span>'


def _replace_symbols(text: str) -> str:
    """Replace mu0, tau0 and F_N in a text by mathematical symbols."""
    for plain_symbol, symbol in (("mu_s", "μ_s"), ("mu0", "μ0"), ("tau0", "τ0")):
        text = text.replace(plain_symbol, symbol)
    return text


def render_claim_variants(variants: Mapping[str, list[ClaimPartOutcome]]) -> str:
    """Return a table of claim parts (rows) and variants (columns). A star marks numbers that leave out some D."""
    return _render_side_by_side(
        variants, lambda part: part.name, lambda outcome: f"{_format_number_with_star(outcome)}, {outcome.verdict}"
    )


def render_claim_columns(columns: Mapping[str, list[ClaimPartOutcome]]) -> str:
    """Return a table with the outcome of each part of a claim for each column of surfaces."""

    def outcome_cell(outcome: ClaimPartOutcome) -> str:
        if not math.isfinite(outcome.value):
            return "not applicable"
        star = r"\*" if outcome.excluded_dimensions else ""
        return f"{_format_outcome(outcome)}{star} {outcome.verdict}"

    return _render_side_by_side(
        columns, lambda part: f"{part.name} {part.statement}; {_format_range(part)}", outcome_cell
    )


def _render_side_by_side(
    columns: Mapping[str, list[ClaimPartOutcome]],
    format_row_heading: Callable[[ClaimPart], str],
    format_cell: Callable[[ClaimPartOutcome], str],
) -> str:
    first_outcomes = next(iter(columns.values()))
    lines = [f"| claim or test | {' | '.join(columns)} |", "|" + "---|" * (len(columns) + 1)]
    for claim in CLAIMS:
        verdicts = [f"**{claim_verdict(claim, outcomes)}**" for outcomes in columns.values()]
        lines.append(f"| **{claim}** | {' | '.join(verdicts)} |")
        for row in [
            index
            for index, outcome in enumerate(first_outcomes)
            if outcome in _outcomes_of_claim(claim, first_outcomes)
        ]:
            cells = [format_cell(outcomes[row]) for outcomes in columns.values()]
            lines.append(f"| {format_row_heading(first_outcomes[row].part)} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def _outcomes_of_claim(claim: int, outcomes: list[ClaimPartOutcome]) -> list[ClaimPartOutcome]:
    return [outcome for outcome in outcomes if outcome.part.claim_number == claim]


def _format_number(value: float) -> str:
    return f"{value:.3g}" if math.isfinite(value) else "none"


def _format_number_with_star(outcome: ClaimPartOutcome) -> str:
    return _format_number(outcome.value) + (r"\*" if outcome.excluded_dimensions else "")


def _format_outcome(outcome: ClaimPartOutcome) -> str:
    if not math.isfinite(outcome.value):
        return "none"
    return f"{_format_number(outcome.value)} [{_format_number(outcome.lower)}, {_format_number(outcome.upper)}]"


def _format_range(part: ClaimPart) -> str:
    if math.isinf(part.max_value):
        return f"above {part.min_value:g}"
    return f"below {part.max_value:g}" if math.isinf(part.min_value) else f"{part.min_value:g} to {part.max_value:g}"


def _exclusion_text(outcome: ClaimPartOutcome) -> str:
    if not outcome.excluded_dimensions:
        return ""
    return f" (without D = {', '.join(f'{dimension:.2f}' for dimension in outcome.excluded_dimensions)})"


# ---- Tables of the documentation ------------------------------------------------------------------------------------


def main() -> None:
    """Compute the studies that are missing in build/claims, and test the claims."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--repetitions", type=int)
    parser.add_argument("--columns", action="store_true")
    options = parser.parse_args()
    write_tables(ROOT / "build/claims", ROOT / "docs/generated", options.repetitions, columns=options.columns)


def write_tables(
    results: Path, tables: Path, repetitions: int | None = None, *, columns: bool = False, changes: Any = ()
) -> None:
    """Write the tables of claims, of variants and, if requested, of columns, from stored results in a directory."""
    changes = dict(changes)

    def load_or_compute_result(study: Study, directory: str) -> xarray.Dataset:
        if not (results / directory / "study.toml").exists():
            return run(study.with_changes(changes), store=results / directory).dataset
        return open_result(results / directory).dataset

    result = load_or_compute_result(claims_study(), "figure7")
    outcomes = judge_claims(result)
    outcomes_by_variant = {}
    for name in STUDY_VARIANTS:
        dataset = load_or_compute_result(variant_study(name), f"variants/{name}")
        outcomes_by_variant[name] = judge_claims(dataset)
        if name == "default":
            outcomes_by_variant["amplitude 0.05 µm"] = judge_claims(dataset, amplitude=LOW_AMPLITUDE)
    (tables / "claims.md").write_text(render_claims(outcomes), encoding="utf-8")
    (tables / "variants.md").write_text(render_claim_variants(outcomes_by_variant), encoding="utf-8")
    if not columns:
        return
    outcomes_by_column = {f"profiles, {result.sizes['repetition']} repetitions": outcomes}
    max_repetitions = repetitions or result.sizes["repetition"]
    if repetitions is not None:
        result = load_or_compute_result(
            claims_study().with_changes({"ensemble.repetitions": max_repetitions}), "columns/lines"
        )
        outcomes_by_column[f"profiles, {max_repetitions} repetitions"] = judge_claims(result)
    outcomes_by_column[f"profiles, {max_repetitions} repetitions, by bands"] = judge_claims(
        result, interval_method="bands"
    )
    for name, title in column_titles(max_repetitions).items():
        column = CLAIMS_TABLE_COLUMNS[name]
        dataset = load_or_compute_result(column.to_study(max_repetitions), f"columns/{column.directory}")
        outcomes_by_column[title] = judge_claims(dataset, sliding=column.sliding, interval_method="bands")
    (tables / "columns.md").write_text(render_claim_columns(outcomes_by_column), encoding="utf-8")


if __name__ == "__main__":
    main()
