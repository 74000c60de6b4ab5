"""Joint distribution of mu0 and tau0 from friction tests, by adaptive importance sampling.

Nuisance parameters are uncertain quantities that the tests share: the gain of the force cell, the true areas of the
surfaces, ranges of hardness, junction growth, creep and moduli, the spread between runs, and the size of the errors if
it is not given. With fixed nuisance parameters the tests are linear in mu0 and tau0, except with junction growth, where
the true area depends on both coefficients. The density of mu0 and tau0 is computed on a grid that covers its support.
Each set of nuisance parameters is weighted by its evidence, which is the integral of this density. The proposal
distribution of the nuisance parameters, Student's t, starts at the best fit and is adapted to the evidence (Cappé et
al. 2008, Statistics and Computing 18, 447-459).
"""

from __future__ import annotations

import copy
import math
from collections.abc import Hashable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction.calibration.friction_tests import FrictionTest, depends_on_junction_growth, evaluate_test_sums
from stiction.calibration.growth import find_best_mu0, find_tau0_range
from stiction.calibration.planning import DEFAULT_RELATIVE_ERROR, list_plans_that_vary_area_per_load
from stiction.mechanics.friction import LOAD_SUM_NAMES, FrictionLaw
from stiction.mechanics.model import SlidingRule
from stiction.study.input_distributions import (
    UncertainInput,
    compute_effective_sample_size,
    generate_sobol_points,
    parse_uncertain_input,
    select_by_weight,
)
from stiction.study.interfaces import (
    ERROR_SCALING_P_VALUE_LIMIT,
    MIN_AREA_VARIATION,
    StrengthFit,
    area_error_name,
    compute_coverage_at_bound,
)
from stiction.study.shared_inputs import INPUTS_WITHOUT_RANGE_COMPARISON

# A nuisance point is a random sample of all uncertain parameters of the fit, except mu0 and tau0.
NUM_NUISANCE_POINTS_PER_ROUND = 256
MAX_NUISANCE_POINTS = 8192
# The first number, doubled for each nuisance parameter, is the final number of nuisance points; the second limits it.
FINAL_NUISANCE_POINT_COUNTS = 256, 1024
MAX_NORMAL_SCORE = 5.0  # standard deviations
MAX_PROPOSAL_ROUNDS = 8
MIN_EFFECTIVE_SAMPLE_FRACTION = 0.4
MIN_EFFECTIVE_SAMPLES = 300.0
NUM_TAU0_CELLS, NUM_MU0_CELLS = 41, 31
NUM_STRENGTH_PAIRS = 4000
# Grids of mu0 and tau0 end where -2 ln(probability density) is this much (about 5.8²) above its minimum.
# With outliers, or if a test did not slide, the limit of -2 ln(probability density) is four times `MAX_GRID_DEVIANCE`.
MAX_GRID_DEVIANCE = 34.0
# Degrees of freedom of the t distribution from which nuisance points are drawn.
PROPOSAL_DEGREES_OF_FREEDOM = 5.0
# Degrees of freedom of the t distribution that describes the errors of friction tests with outliers.
OUTLIER_DEGREES_OF_FREEDOM = 4.0
MEDIAN_RELATIVE_DEVIATION_BETWEEN_RUNS = 0.10

# If contacts grow under shear, nuisance points are processed in batches of this size to limit the memory use.
MAX_GROWTH_BATCH_POINTS = 256
GAIN_PARAMETER_NAME, RUN_SPREAD_PARAMETER_NAME = "gain", "spread between runs"


@dataclass(frozen=True)
class _BestFit:
    """Least-squares fit to friction tests: the fitted mu0, tau0 and nuisance parameters, and the residuals."""

    mu0: float
    tau0: float  # GPa
    scores: Floats
    residuals: Floats
    # Derivatives of (residuals · `robust_factors`) and of nuisance parameters with respect to the fitted parameters.
    jacobian: Floats
    robust_factors: Floats
    scale: float


@dataclass(frozen=True)
class _GridLimits:
    """Limits of the mu0 and tau0 grids on which probabilities are computed: one grid per nuisance-parameter sample."""

    # Triangular factor R of the QR decomposition of the test equations at each nuisance point; shape (points, 3, 3).
    triangular_factors: Floats
    deviance_range: float
    min_tau0: Floats
    max_tau0: Floats
    # Best mu0 at each nuisance point and tau0, shape (points, tau0); None if contacts do not grow under shear.
    best_mu0: Floats | None = None
    width_below: Any = None
    width_above: Any = None


@dataclass(frozen=True)
class _ProbabilityGrid:
    """Log-probabilities of mu0 and tau0 in the cells of grids, one grid for each sample of the nuisance parameters."""

    limits: _GridLimits
    # Log-probability in each grid cell, excluding the prior density; shape (nuisance points, tau0 cells, mu0 cells).
    log_probability: Floats


class CalibrationProblem:
    """Fit of mu0 and tau0 to friction tests, each of which gives a linear equation with uncertain coefficients.

    In each equation, a mu0 + b tau0 equals the right side, where a and b are the coefficients of the equation.

    Parameters
    ----------
    tests : sequence of FrictionTest
    sliding : {"all", "opposing"}
    common : float
        Relative standard uncertainty of the gain, which all tests share.
    fixed_strengths : (float or None, float or None)
        Fixed values of mu0 and tau0 (GPa); None if unknown.
    outliers : bool
        True if errors follow Student's t distribution instead of a normal distribution.
    """

    def __init__(
        self,
        tests: Sequence[FrictionTest],
        sliding: SlidingRule,
        common: float,
        fixed_strengths: tuple[float | None, float | None],
        *,
        outliers: bool,
    ) -> None:
        self.sliding, self.common, self.fixed_strengths, self.outliers = sliding, common, fixed_strengths, outliers
        tests_by_key = {(id(test.result), test.load, test.wait): test for test in tests}
        sums_by_key = {key: evaluate_test_sums(test, sliding) for key, test in tests_by_key.items()}
        self._friction = [sums_by_key[id(test.result), test.load, test.wait] for test in tests]
        self.slid = np.array([test.slid for test in tests])
        self.load = np.array([float(test.load) for test in tests])
        self.measured = np.array([float(test.coefficient or 0.0) for test in tests])
        self.has_errors = tests[0].uncertainty is not None
        if self.has_errors:
            self.error = np.array([test.uncertainty for test in tests], float)
        else:
            # Tests without given errors are assumed to have errors proportional to the measured coefficients.
            self.error = np.maximum(self.measured, 1e-6 * self.measured.max())
        area_errors: dict[str, float] = {}
        for equation in self._friction:
            if equation.scatter > 0:
                name = area_error_name(equation.surfaces)
                area_errors[name] = max(area_errors.get(name, 0.0), equation.scatter)
        self._area_errors = area_errors
        self.has_growing_contacts = any(equation.area_factor.junction_growth is not None for equation in self._friction)
        input_names = [name for equation in self._friction for name in equation.area_factor.nuisance_names]
        self._run_membership = _build_run_membership_matrix(tests)
        self.nuisances: list[str] = [
            *([GAIN_PARAMETER_NAME] if common > 0 else []), *area_errors, *dict.fromkeys(input_names),
            *([RUN_SPREAD_PARAMETER_NAME] if len(self._run_membership) else []),
        ]  # fmt: skip
        """Names of the nuisance parameters. Each parameter is expressed as a standard normal score."""
        central_coefficients = self._compute_equation_coefficients(np.zeros((1, len(self.nuisances))))
        self.area_per_load = central_coefficients[1][0] / central_coefficients[0][0]
        """True area per load (1/GPa) of each test at zero scores; contacts grow as at the measured coefficient."""
        self._offsets, self._offset_sizes = self._compute_run_offset_vectors(central_coefficients)

    # ---- Equations --------------------------------------------------------------------------------------------------

    def _compute_equation_coefficients(
        self, scores: Floats, mu0: Floats | None = None, tau0: Floats | None = None
    ) -> tuple[Floats, Floats, Floats]:
        """Return a, b and c of the test equations a mu0 + b tau0 = c.

        `scores` are normal scores of the nuisance parameters, with the shape (points, nuisances): each point is one
        sample. The coefficients have the shape (points, tests). If mu0 and tau0 (GPa) of shape (points, ...) are given,
        the coefficients of tau0 have the shape (points, tests, ...) and include the junction growth for these mu0 and
        tau0. Otherwise the junction growth is computed from the measured coefficients.
        """
        from scipy.special import ndtr

        grid_shape = () if mu0 is None else mu0.shape[1:]
        scores_by_name = dict(zip(self.nuisances, np.clip(scores, -MAX_NORMAL_SCORE, MAX_NORMAL_SCORE).T, strict=True))
        shape = len(scores), *(1 for _ in grid_shape)
        probability = {name: ndtr(values).reshape(shape) for name, values in scores_by_name.items()}
        # Tests with the same equation share its area factor, unless the factor depends on their measured coefficients.
        cached_factors: dict[Hashable, Floats] = {}

        def area_factors_of_test(test: int) -> Floats:
            equation = self._friction[test]
            area_factor, is_measured = equation.area_factor, mu0 is None or tau0 is None
            key = id(equation), self.measured[test] if is_measured and area_factor.junction_growth is not None else None
            if key not in cached_factors:
                # The area of sliding contacts depends only on the ratio of friction force to normal force.
                law = FrictionLaw(self.measured[test], 0.0) if mu0 is None or tau0 is None else FrictionLaw(mu0, tau0)
                area, fraction = area_factor.onset_area_and_friction_factors(area_factor.input_values(probability), law)
                # Pairs (mu0, tau0) for which the softer body shears are excluded: no test can measure such pairs.
                cached_factors[key] = area if is_measured else np.where(fraction < 1, np.inf, area)
            factor = np.ones(shape) * cached_factors[key]
            if equation.scatter > 0:
                name = area_error_name(equation.surfaces)
                factor = factor * np.exp(self._area_errors[name] * scores_by_name[name]).reshape(shape)
            return np.broadcast_to(factor, (len(scores), *grid_shape))

        sums = {name: np.array([equation.sums[name] for equation in self._friction]) for name in LOAD_SUM_NAMES}

        gain = (
            np.exp(self.common * scores_by_name[GAIN_PARAMETER_NAME])[:, np.newaxis]
            if GAIN_PARAMETER_NAME in scores_by_name
            else np.ones((len(scores), 1))
        )
        # The force-cell gain multiplies computed coefficients, because the test errors refer to the measured ones.
        mu0_coefficient = gain * sums["tangential_frictional"] - self.measured * sums["normal_frictional"]
        tau0_coefficient = gain * sums["tangential_adhesive"] - self.measured * sums["normal_adhesive"]
        right_side = self.measured - gain * sums["tangential_elastic"]
        area_factors = np.stack([area_factors_of_test(test) for test in range(len(self._friction))], axis=1)
        return (
            mu0_coefficient,
            tau0_coefficient.reshape(*tau0_coefficient.shape, *(1 for _ in grid_shape)) * area_factors,
            right_side,
        )

    def _compute_run_offset_vectors(self, central_coefficients: tuple[Floats, Floats, Floats]) -> tuple[Floats, Floats]:
        """Return how the friction offset of each test run shifts the residuals: unit vectors, and norms of the shifts.

        The unit vectors have the shape (runs, tests). The norms, with the shape (runs,), are in units of the errors.
        Offsets are relative to the fitted coefficients, because offsets relative to measured coefficients would bias
        the fit low.
        """
        self._run_errors = np.zeros(len(self.slid))
        if not len(self._run_membership):
            return np.zeros((0, len(self.slid))), np.zeros(0)
        mu0_coefficient, tau0_coefficient, right_side = (column[0] for column in central_coefficients)
        mu0, tau0 = _solve_nonnegative_least_squares(
            np.stack([mu0_coefficient, tau0_coefficient, right_side], axis=1),
            self._weights_of_tests,
            self.fixed_strengths,
        )
        residual_shifts = self._run_membership * (mu0_coefficient * mu0 + tau0_coefficient * tau0) / self.error
        self._run_errors = (residual_shifts * self.error).sum(axis=0)
        residual_shifts = np.where(self.slid, residual_shifts, 0.0)
        shift_norms = np.linalg.norm(residual_shifts, axis=1)
        is_used = shift_norms > 0
        return residual_shifts[is_used] / shift_norms[is_used, np.newaxis], shift_norms[is_used]

    @cached_property
    def _weights_of_tests(self) -> Floats:
        return np.where(self.slid, 1.0 / self.error**2, 0.0)

    def average_over_tests(self, area_per_load: Floats) -> float:
        """Return the weighted mean of true area per load, A/F (1/GPa), over the tests in which the pair slid."""
        return float(np.average(area_per_load, weights=self._weights_of_tests))

    def compute_area_per_load_variation(self, area_per_load: Floats) -> float:
        """Return the relative standard deviation of true area per load, weighted over tests in which the pair slid."""
        mean = self.average_over_tests(area_per_load)
        variance = np.average((area_per_load - mean) ** 2, weights=self._weights_of_tests)
        return float(np.sqrt(variance) / mean)

    def _compute_deviation_between_runs(self, scores: Floats) -> Floats:
        """Return the relative standard deviation of friction between test runs, for each nuisance-parameter sample."""
        from scipy.special import ndtr

        if RUN_SPREAD_PARAMETER_NAME not in self.nuisances:
            return np.zeros(len(scores))
        probability = np.minimum(ndtr(scores[:, self.nuisances.index(RUN_SPREAD_PARAMETER_NAME)]), 1 - 1e-9)
        return np.asarray(MEDIAN_RELATIVE_DEVIATION_BETWEEN_RUNS * np.tan(0.5 * math.pi * probability))

    def _build_weighted_equations(
        self, columns: tuple[Floats, ...], scale: Floats, spread: Floats
    ) -> tuple[Floats, Floats]:
        """Return equations of the tests in which the pair slid, scaled so that their errors are equal and uncorrelated.

        The equations have the shape (points, tests with sliding, 3). Also returns the logarithms of the normalization
        factors (points,).
        """
        rows = (np.stack(columns, axis=-1) / self.error[:, np.newaxis])[:, self.slid] / scale[:, np.newaxis, np.newaxis]
        return self._decorrelate_within_runs(rows, scale, spread)

    def _decorrelate_within_runs(self, rows: Floats, scale: Floats, spread: Floats) -> tuple[Floats, Floats]:
        """Transform the equations of tests so that the errors of tests in the same run become uncorrelated.

        Also returns the logarithms of the normalization factors (points,).
        """
        log_norm = -np.count_nonzero(self.slid) * np.log(scale)
        if len(self._offsets):
            run_directions = self._offsets[:, self.slid]
            variance_ratios = 1 + np.square(np.multiply.outer(spread / scale, self._offset_sizes))
            log_norm = log_norm - 0.5 * np.log(variance_ratios).sum(axis=1)
            run_components = (
                np.einsum("rn,pnk->prk", run_directions, rows) * (1 - 1 / np.sqrt(variance_ratios))[..., np.newaxis]
            )
            rows = rows - np.einsum("rn,prk->pnk", run_directions, run_components)
        return rows, np.asarray(log_norm, dtype=np.float64)

    def _compute_residuals(
        self, scores: Floats, scale: Floats, spread: Floats, mu0: Floats, tau0: Floats
    ) -> tuple[Floats, tuple[Floats, Floats, Floats]]:
        """Return the residuals of the tests in which the pair slid, and the equation coefficients of all tests.

        Each residual is divided by the standard error of its test.

        The residuals have the shape (points, tests that slid, ...), and are infinite at seizure. The coefficients
        include junction growth. mu0 and tau0 (GPa) have the shape (points, ...).
        """
        columns = self._compute_equation_coefficients(scores, mu0, tau0)
        grid_axes = tuple(1 for _ in mu0.shape[1:])
        mu0_coefficient, right_side = (column.reshape(*column.shape, *grid_axes) for column in (columns[0], columns[2]))
        with np.errstate(invalid="ignore"):
            misfit = right_side - mu0_coefficient * mu0[:, np.newaxis] - columns[1] * tau0[:, np.newaxis]
            misfit = misfit[:, self.slid] / self.error[self.slid].reshape(-1, *grid_axes)
            misfit = misfit / scale.reshape(-1, 1, *grid_axes)
            rows = self._decorrelate_within_runs(misfit.reshape(*misfit.shape[:2], -1), scale, spread)[0]
        rows = np.where(np.isfinite(rows), rows, np.inf)
        return rows.reshape(misfit.shape), columns

    # ---- Best fit ---------------------------------------------------------------------------------------------------

    @cached_property
    def best_fit(self) -> _BestFit:
        """Fit of mu0, tau0 and the nuisance parameters to the tests by least squares.

        Offsets of runs are free parameters, so that residuals contain only the scatter within runs. Outliers get
        smaller weights.
        """
        from scipy.optimize import least_squares

        free_indices = [index for index, value in enumerate(self.fixed_strengths) if value is None]
        score_indices = [index for index, name in enumerate(self.nuisances) if name != RUN_SPREAD_PARAMETER_NAME]
        robust_factors, error_scale = np.ones(len(self.slid)), 1.0

        def insert_run_spread_score(free_scores: Floats) -> Floats:
            scores = np.zeros((len(free_scores), len(self.nuisances)))
            scores[:, score_indices] = free_scores
            return scores

        def build_equation_rows(free_scores: Floats) -> Floats:
            columns = self._compute_equation_coefficients(insert_run_spread_score(free_scores))
            rows = self._build_weighted_equations(
                columns, np.full(len(free_scores), error_scale), np.full(len(free_scores), 1e6 * error_scale)
            )[0]
            return np.asarray(rows * robust_factors[self.slid, np.newaxis])

        central_equations = build_equation_rows(np.zeros((1, len(score_indices))))[0]
        column_norms = np.maximum(np.linalg.norm(central_equations[:, :2], axis=0), 1e-300)

        def to_strengths(x: Floats) -> Floats:
            strength = np.array([0.0 if value is None else value for value in self.fixed_strengths])
            strength[free_indices] = x[: len(free_indices)] / column_norms[free_indices]
            return strength

        def residuals_with_growth(points: Floats) -> Floats:
            """Return the weighted residuals of friction tests with junction growth, one row per set of parameters."""
            mu0, tau0 = np.transpose([to_strengths(x) for x in points])
            scales = np.full(len(points), error_scale)
            misfit, _ = self._compute_residuals(
                insert_run_spread_score(points[:, len(free_indices) :]), scales, 1e6 * scales, mu0, tau0
            )
            return np.asarray(misfit * robust_factors[self.slid])

        def residuals(x: Floats) -> Floats:
            if self.has_growing_contacts:
                return np.concatenate([residuals_with_growth(x[np.newaxis])[0], x[len(free_indices) :]])
            rows = build_equation_rows(x[np.newaxis, len(free_indices) :])[0]
            return np.concatenate([rows[:, 2] - rows[:, :2] @ to_strengths(x), x[len(free_indices) :]])

        def jacobian(x: Floats) -> Floats:
            difference_step = 1e-5
            if self.has_growing_contacts:
                step_residuals = residuals_with_growth(
                    x + difference_step * np.concatenate([np.zeros((1, x.size)), np.eye(x.size)])
                )
                # If a step makes the interface stronger than the softer body, the derivative of residuals is set to 0.
                test_rows = np.nan_to_num(
                    (step_residuals[1:] - step_residuals[0]).T / difference_step, posinf=0.0, neginf=0.0
                )
            else:
                free_scores = x[len(free_indices) :] + difference_step * np.concatenate(
                    [np.zeros((1, len(score_indices))), np.eye(len(score_indices))]
                )
                rows = build_equation_rows(free_scores)
                step_residuals = rows[..., 2] - rows[..., :2] @ to_strengths(x)
                test_rows = np.concatenate(
                    [
                        -rows[0][:, free_indices] / column_norms[free_indices],
                        (step_residuals[1:] - step_residuals[0]).T / difference_step,
                    ],
                    axis=1,
                )
            prior_rows = np.concatenate(
                [np.zeros((len(score_indices), len(free_indices))), np.eye(len(score_indices))], axis=1
            )
            return np.concatenate([test_rows, prior_rows])

        lower_bounds = np.concatenate([np.zeros(len(free_indices)), np.full(len(score_indices), -np.inf)])
        x = np.zeros(len(free_indices) + len(score_indices))
        for _ in range(1 if self.has_errors and not self.outliers else 4):
            linear_strengths = _solve_nonnegative_least_squares(
                build_equation_rows(x[np.newaxis, len(free_indices) :])[0],
                np.ones(len(central_equations)),
                self.fixed_strengths,
            )
            x[: len(free_indices)] = np.array(linear_strengths)[free_indices] * column_norms[free_indices] + 1e-9
            while (
                self.has_growing_contacts
                and free_indices
                and not np.isfinite(residuals(x)).all()
                and x[: len(free_indices)].max() > 1e-9
            ):
                # The interface seizes at the initial mu0 and tau0, so both are halved until the interface slides.
                x[: len(free_indices)] /= 2
            if x.size:
                x = least_squares(residuals, x, jacobian, bounds=(lower_bounds, np.inf), xtol=1e-9, ftol=1e-9).x
            misfit = residuals(x)[: len(central_equations)] / robust_factors[self.slid]
            jacobian_matrix = jacobian(x) if x.size else np.zeros((len(misfit), 0))
            if not self.has_errors:
                residual_scale = np.median(np.abs(misfit)) / 0.6745 if self.outliers else np.sqrt((misfit**2).mean())
                error_scale, misfit = (
                    error_scale * max(float(residual_scale), 1e-9),
                    misfit / max(float(residual_scale), 1e-9),
                )
            if self.outliers:
                robust_factors[self.slid] = np.sqrt(
                    (OUTLIER_DEGREES_OF_FREEDOM + 1) / (OUTLIER_DEGREES_OF_FREEDOM + misfit**2)
                )
        scores = np.zeros(len(self.nuisances))
        scores[score_indices] = x[len(free_indices) :]
        mu0, tau0 = to_strengths(x)
        return _BestFit(float(mu0), float(tau0), scores, misfit, jacobian_matrix, robust_factors, error_scale)

    def fit(self) -> StrengthFit:
        """Fit the joint distribution of mu0 and tau0 to the tests, and assess the quality of the fit."""
        from scipy.stats import chi2, linregress

        best_fit = self.best_fit
        chi_squared = float((best_fit.residuals**2).sum() + (best_fit.scores**2).sum())
        num_slid = int(self.slid.sum())
        # If A/F is equal in all tests, the tests determine only the sum mu0 + tau0 A/F, not mu0 and tau0 separately.
        best_area_per_load = self._find_median_area_per_load(
            self._compute_area_per_load_samples(
                best_fit.scores[np.newaxis], np.array([best_fit.mu0]), np.array([best_fit.tau0])
            )
        )
        num_fitted = min(
            sum(value is None for value in self.fixed_strengths),
            1 if self.compute_area_per_load_variation(best_area_per_load) < MIN_AREA_VARIATION else 2,
        )
        degrees_of_freedom = max(0, num_slid - num_fitted - max(0, len(self._offsets) - 1))
        probability = (
            float(chi2.sf(chi_squared, degrees_of_freedom)) if self.has_errors and degrees_of_freedom else math.nan
        )
        is_scaled = degrees_of_freedom > 0 and (
            not self.has_errors or (probability < ERROR_SCALING_P_VALUE_LIMIT and not self.outliers)
        )
        scale = best_fit.scale * math.sqrt(chi_squared / degrees_of_freedom) if is_scaled else 1.0
        loads = np.log(self.load[self.slid])
        trend_probability = (
            float(linregress(loads, best_fit.residuals).pvalue) if num_slid > 2 and np.ptp(loads) > 0 else math.nan
        )
        unstored_names = {GAIN_PARAMETER_NAME, RUN_SPREAD_PARAMETER_NAME}
        # Samples of the error of the computed area are stored only if all tests used the same surfaces.
        if len({equation.surfaces for equation in self._friction}) > 1:
            unstored_names |= self._area_errors.keys()

        weights = self._weights_of_tests[self.slid]

        def draw_fit(problem: CalibrationProblem) -> StrengthFit:
            mu0, tau0, scores = problem._draw_samples(max(scale, 1e-9), degrees_of_freedom if is_scaled else None)
            scores_by_name = {
                name: scores[:, index] for index, name in enumerate(self.nuisances) if name not in unstored_names
            }
            area_per_load = self._compute_area_per_load_samples(scores, mu0, tau0)
            mean_area_per_load = np.average(area_per_load[:, self.slid], axis=1, weights=weights)
            return StrengthFit(
                self.sliding, chi_squared, degrees_of_freedom, probability, scale if self.has_errors else 1.0,
                trend_probability, mu0, tau0, self._compute_hardness_samples(scores_by_name),
                self._compute_growth_samples(scores_by_name), np.asarray(mean_area_per_load), scores_by_name,
                area_per_load_of_tests=self._find_median_area_per_load(area_per_load),
            )  # fmt: skip

        fit = draw_fit(self)
        if self.fixed_strengths != (None, None):
            return fit
        fits_at_bounds = {
            name: draw_fit(self._with_fixed_strengths(strengths))
            for name, strengths in (("mu0", (0.0, None)), ("tau0", (None, 0.0)))
            if compute_coverage_at_bound(getattr(fit, name)) > 0
        }
        return replace(fit, fits_at_bounds=fits_at_bounds)

    def _with_fixed_strengths(self, strengths: tuple[float | None, float | None]) -> CalibrationProblem:
        """Return a copy of the problem in which mu0 and tau0 (GPa), unless None, are fixed to the given numbers."""
        problem = copy.copy(self)
        # The cached best fit was computed with other fixed mu0 and tau0, so it is removed.
        problem.__dict__.pop("best_fit", None)
        problem.fixed_strengths = strengths
        return problem

    def _compute_area_per_load_samples(self, scores: Floats, mu0: Floats, tau0: Floats) -> Floats:
        """Return samples of the true area per load A/F (1/GPa) of each test, with the shape (samples, tests)."""
        mu0_coefficient, tau0_coefficient, _ = self._compute_equation_coefficients(scores, mu0, tau0)
        return np.asarray(tau0_coefficient / mu0_coefficient)

    def _find_median_area_per_load(self, samples: Floats) -> Floats:
        """Return the true area per load (1/GPa) of each test: the median of `samples` if contacts grow under shear.

        If no contacts grow, A/F at the central inputs is returned. With friction at opposing contacts only, the
        friction and the growth of these contacts exceed those at the measured coefficient, for which `area_per_load` is
        computed.
        """
        if not self.has_growing_contacts:
            return np.asarray(self.area_per_load)
        medians = np.median(samples, axis=0)
        return np.where(np.isfinite(medians), medians, self.area_per_load)

    @cached_property
    def junction_growth(self) -> UncertainInput | None:
        """Junction growth factor α of the tests, or None if α differs between tests or has no effect on any test.

        α is 0 if no test includes junction growth, although junction growth would affect at least one test.
        """
        growths = [
            equation.area_factor.junction_growth for equation in self._friction if equation.area_factor.junction_growth
        ]
        if growths:
            return growths[0] if len({growth.text for growth in growths}) == 1 else None
        depend_on_growth = [
            depends_on_junction_growth(equation, self.best_fit.mu0, self.best_fit.tau0) for equation in self._friction
        ]
        return parse_uncertain_input("junction_growth", 0.0) if any(depend_on_growth) else None

    @property
    def exact_inputs(self) -> tuple[tuple[str, float], ...]:
        """Inputs that are exact in at least one test, as pairs of name and value (core units).

        The area loss under shear is left out, because each pair has its own.
        """
        inputs = [item for equation in self._friction for item in equation.area_factor.inputs.items()]
        ignored_names = ("area_loss", *INPUTS_WITHOUT_RANGE_COMPARISON)
        exact_inputs = (
            (name, float(value.value)) for name, value in inputs if value.is_exact and name not in ignored_names
        )
        return tuple(dict.fromkeys(exact_inputs))

    def _compute_growth_samples(self, scores: Mapping[str, Floats]) -> Floats:
        """Return samples of the junction growth α that all tests share.

        Returns NaN if the tests share no α.
        """
        from scipy.special import ndtr

        if self.junction_growth is None or self.junction_growth.is_exact:
            return np.full(NUM_STRENGTH_PAIRS, math.nan if self.junction_growth is None else self.junction_growth.value)
        growth_nuisances = [
            equation.area_factor.nuisance_name("junction_growth")
            for equation in self._friction
            if equation.area_factor.junction_growth
        ]
        return np.asarray(self.junction_growth.quantile(ndtr(scores[growth_nuisances[0]])))

    @cached_property
    def shared_hardness(self) -> Any:
        """Uncertain hardness that all tests share, or None if the tests share no hardness."""
        area_factors = [equation.area_factor for equation in self._friction]
        hardness_nuisances = {
            area_factor.nuisance_name("hardness") if "hardness" in area_factor.uncertain_inputs else ""
            for area_factor in area_factors
        }
        is_shared = len(hardness_nuisances) == 1 and all(hardness_nuisances)
        return area_factors[0].uncertain_inputs["hardness"] if is_shared else None

    def _compute_hardness_samples(self, scores: Mapping[str, Floats]) -> Floats:
        """Return samples of the hardness (GPa) that all tests share.

        Returns NaN if the tests share no hardness.
        """
        from scipy.special import ndtr

        first_test = self._friction[0]
        if self.shared_hardness is not None:
            return np.asarray(
                self.shared_hardness.quantile(ndtr(scores[first_test.area_factor.nuisance_name("hardness")]))
            )
        hardnesses = {equation.hardness for equation in self._friction}
        return np.full(NUM_STRENGTH_PAIRS, first_test.hardness if len(hardnesses) == 1 else math.nan)

    # ---- Density of mu0 and tau0 for given nuisance parameters ------------------------------------------------------

    def _evaluate_probability_grids(self, points: Floats) -> _ProbabilityGrid:
        """Compute the log-probability on a grid of mu0 and tau0 for each sample of the nuisance parameters.

        Each row of `points` is one sample. Its last element is the logarithm of the scale of the errors.
        """
        from scipy.special import log_ndtr

        if self.has_growing_contacts and len(points) > MAX_GROWTH_BATCH_POINTS:
            batches = np.array_split(points, math.ceil(len(points) / MAX_GROWTH_BATCH_POINTS))
            return _concatenate_grids([self._evaluate_probability_grids(batch) for batch in batches])
        scores, scale = points[:, : len(self.nuisances)], np.exp(points[:, len(self.nuisances)])
        columns, spread = self._compute_equation_coefficients(scores), self._compute_deviation_between_runs(scores)
        rows, log_norm = self._build_weighted_equations(columns, scale, spread)
        triangular_factors = _compute_triangular_factors(rows)
        if self.outliers:
            robust_triangle = _compute_triangular_factors(rows * self.best_fit.robust_factors[self.slid, np.newaxis])
        else:
            rows = robust_triangle = triangular_factors
        deviance_range = MAX_GRID_DEVIANCE * (1.0 if self.slid.all() and not self.outliers else 4.0)
        if self.fixed_strengths[1] is not None:
            lowest_tau0 = highest_tau0 = np.full(len(points), self.fixed_strengths[1])
        elif self.fixed_strengths[0] is not None:
            lowest_tau0, highest_tau0 = _find_tau0_range_at_fixed_mu0(
                self.fixed_strengths[0], robust_triangle, deviance_range
            )
        else:
            lowest_tau0, highest_tau0 = _find_tau0_range_at_best_mu0(robust_triangle, deviance_range)
        grid_limits = _GridLimits(robust_triangle, deviance_range, lowest_tau0, highest_tau0)
        if self.has_growing_contacts:
            grid_limits = self._find_grid_limits_with_growth(grid_limits, scores, scale, spread, columns)
        num_tau0_cells = 1 if self.fixed_strengths[1] is not None else NUM_TAU0_CELLS
        tau0 = grid_limits.min_tau0[:, np.newaxis] + np.multiply.outer(
            grid_limits.max_tau0 - grid_limits.min_tau0, (np.arange(num_tau0_cells) + 0.5) / num_tau0_cells
        )
        mu0_start, mu0_step = self._choose_mu0_grid_at_tau0(
            grid_limits, np.arange(len(points))[:, np.newaxis], np.arange(num_tau0_cells), tau0
        )
        mu0 = mu0_start[..., np.newaxis] + mu0_step[..., np.newaxis] * (np.arange(self._num_mu0_cells) + 0.5)
        tau0 = tau0[..., np.newaxis]
        mu0_coefficient, tau0_coefficient, right_side = columns[0], columns[1][..., np.newaxis, np.newaxis], columns[2]
        residuals: Iterable[Floats]
        if self.has_growing_contacts:
            misfit, (mu0_coefficient, tau0_coefficient, right_side) = self._compute_residuals(
                scores, scale, spread, mu0, np.broadcast_to(tau0, mu0.shape)
            )
            residuals = np.moveaxis(misfit, 1, 0)
        else:
            test_rows = np.moveaxis(rows, 1, 0)[..., np.newaxis, np.newaxis]
            residuals = (row[:, 2] - row[:, 1] * tau0 - row[:, 0] * mu0 for row in test_rows)
        log_probability = np.zeros(mu0.shape)
        for residual in residuals:
            if self.outliers:
                log_probability -= (
                    0.5 * (OUTLIER_DEGREES_OF_FREEDOM + 1) * np.log1p(residual**2 / OUTLIER_DEGREES_OF_FREEDOM)
                )
            else:
                log_probability -= 0.5 * residual**2
        for test in np.flatnonzero(~self.slid):
            test_error = scale * self.error[test]
            if len(self._run_membership):
                test_error = np.hypot(test_error, spread * self._run_errors[test])
            mu0_coefficient_of_test, right_side_of_test = (
                column[:, test, np.newaxis, np.newaxis] for column in (mu0_coefficient, right_side)
            )
            log_probability += log_ndtr(
                (mu0_coefficient_of_test * mu0 + tau0_coefficient[:, test] * tau0 - right_side_of_test)
                / test_error[:, np.newaxis, np.newaxis]
            )
        # At each nuisance point, the prior density is uniform in mu0 and in tau0 · A/F, where A/F is the area per load.
        best_cell = (
            log_probability.reshape(len(points), -1).argmax(axis=1)
            if self.has_growing_contacts
            else np.zeros(len(points), int)
        )
        tau0_coefficient_at_best = tau0_coefficient.reshape(*tau0_coefficient.shape[:2], -1)[
            np.arange(len(points)), :, best_cell
        ]
        with np.errstate(divide="ignore", invalid="ignore"):
            log_volume = sum(
                np.log(np.abs(column[:, self.slid]).mean(axis=1))
                for column, value in zip((mu0_coefficient, tau0_coefficient_at_best), self.fixed_strengths, strict=True)
                if value is None
            )
        if self.fixed_strengths[1] is None:
            log_volume = log_volume + np.log((grid_limits.max_tau0 - grid_limits.min_tau0) / num_tau0_cells)
        # If the interface seizes in all cells of the grid, `log_volume` is infinite or NaN.
        log_volume = np.where(np.isfinite(log_volume), log_volume, 0.0)
        with np.errstate(divide="ignore"):
            log_mu0_step = np.log(mu0_step) if self.fixed_strengths[0] is None else np.zeros(mu0_step.shape)
        log_probability += (log_norm + log_volume)[:, np.newaxis, np.newaxis] + log_mu0_step[..., np.newaxis]
        return _ProbabilityGrid(grid_limits, np.where(np.isfinite(log_probability), log_probability, -np.inf))

    @property
    def _num_mu0_cells(self) -> int:
        return 1 if self.fixed_strengths[0] is not None else NUM_MU0_CELLS

    def _find_grid_limits_with_growth(
        self, limits: _GridLimits, scores: Floats, scale: Floats, spread: Floats, columns: tuple[Floats, Floats, Floats]
    ) -> _GridLimits:
        """Return limits of the grids of tau0 and mu0 for tests in which shear enlarges the contacts.

        The limits of mu0 lie around the best mu0 at each tau0. `columns` contains the coefficients of the equations for
        the junction growth at the measured coefficients.
        """
        robust_factors = self.best_fit.robust_factors[self.slid] if self.outliers else np.ones(int(self.slid.sum()))

        def residuals(mu0: Floats, tau0: Floats) -> Floats:
            misfit, _ = self._compute_residuals(scores, scale, spread, mu0, tau0)
            return np.asarray(misfit * robust_factors.reshape(-1, *(1 for _ in mu0.shape[1:])))

        def find_best_mu0_at(tau0: Floats) -> tuple[Floats, Floats, Floats]:
            if self.fixed_strengths[0] is not None:
                start = np.full(tau0.shape, self.fixed_strengths[0])
                return start, np.ones(tau0.shape), (residuals(start, tau0) ** 2).sum(axis=1)
            row = limits.triangular_factors[:, 0, :, np.newaxis]
            start = np.maximum((row[:, 2] - row[:, 1] * tau0) / row[:, 0], 0.0)
            return find_best_mu0(residuals, start, tau0)

        if self.fixed_strengths[1] is None:
            # Each test limits tau0: tau0 is largest at mu0 = 0, where tau0 alone causes the measured friction.
            test_errors = np.hypot(scale[:, np.newaxis] * self.error, spread[:, np.newaxis] * self._run_errors)
            margin = (
                2
                * (math.sqrt(limits.deviance_range) + math.sqrt(robust_factors.size))
                * test_errors[:, self.slid]
                / robust_factors
            )
            with np.errstate(divide="ignore"):
                max_tau0 = (columns[2][:, self.slid] + margin) / np.maximum(columns[1][:, self.slid], 0.0)
            lowest_tau0, highest_tau0 = find_tau0_range(
                lambda tau0: find_best_mu0_at(tau0)[2], max_tau0.min(axis=1), limits.deviance_range
            )
            limits = replace(limits, min_tau0=lowest_tau0, max_tau0=highest_tau0)
        num_tau0_cells = 1 if self.fixed_strengths[1] is not None else NUM_TAU0_CELLS
        tau0 = limits.min_tau0[:, np.newaxis] + np.multiply.outer(
            limits.max_tau0 - limits.min_tau0, (np.arange(num_tau0_cells) + 0.5) / num_tau0_cells
        )
        best_mu0, slope, _ = find_best_mu0_at(tau0)
        width_above = math.sqrt(limits.deviance_range) / np.where(np.isfinite(slope) & (slope > 0), slope, 1.0)
        # Below the best mu0, residuals vary less with mu0 than above it, but no less than without junction growth.
        width_below = np.maximum(width_above, math.sqrt(limits.deviance_range) / limits.triangular_factors[:, :1, 0])
        return replace(limits, best_mu0=best_mu0, width_below=width_below, width_above=width_above)

    def _choose_mu0_grid_at_tau0(
        self, limits: _GridLimits, point: Any, row: Any, tau0: Floats
    ) -> tuple[Floats, Floats]:
        """Return, for each given tau0, the lower end of the grid of mu0, and the width of the grid cells."""
        if self.fixed_strengths[0] is not None:
            return np.full(tau0.shape, self.fixed_strengths[0]), np.zeros(tau0.shape)
        if limits.best_mu0 is None:
            triangular_factors = limits.triangular_factors[point]
            best_mu0 = (triangular_factors[..., 0, 2] - triangular_factors[..., 0, 1] * tau0) / triangular_factors[
                ..., 0, 0
            ]
            width_below = width_above = math.sqrt(limits.deviance_range) / triangular_factors[..., 0, 0]
        else:
            count = limits.best_mu0.shape[1]
            slope = np.gradient(limits.best_mu0, axis=1) if count > 1 else np.zeros(limits.best_mu0.shape)
            width = (limits.max_tau0 - limits.min_tau0)[point] / count
            cell_offset = (tau0 - limits.min_tau0[point]) / np.where(width > 0, width, 1.0) - row - 0.5
            best_mu0 = limits.best_mu0[point, row] + slope[point, row] * np.where(width > 0, cell_offset, 0.0)
            width_below, width_above = limits.width_below[point, row], limits.width_above[point, row]
        lowest_mu0 = np.maximum(best_mu0 - width_below, 0.0)
        highest_mu0 = np.maximum(best_mu0 + width_above, lowest_mu0 + width_above)
        return lowest_mu0, (highest_mu0 - lowest_mu0) / NUM_MU0_CELLS

    # ---- Nuisance parameters ----------------------------------------------------------------------------------------

    def _draw_samples(self, scale: float, freedom: int | None) -> tuple[Floats, Floats, Floats]:
        """Draw samples of mu0, tau0 (GPa) and the nuisance parameters from their joint distribution.

        If `freedom` is given, all errors share an unknown factor.
        """
        nuisance_count = len(self.nuisances)
        active_indices = [*range(nuisance_count), *([nuisance_count] if freedom is not None else [])]
        mean, covariance = self._build_first_proposal(scale, freedom)
        nuisance_points, grid, log_weight = self._draw_nuisance_points(
            mean, covariance, active_indices, NUM_NUISANCE_POINTS_PER_ROUND if active_indices else 1
        )
        for seed in range(1, MAX_PROPOSAL_ROUNDS if active_indices else 0):
            if (
                compute_effective_sample_size(log_weight)
                > MIN_EFFECTIVE_SAMPLE_FRACTION * NUM_NUISANCE_POINTS_PER_ROUND
            ):
                break
            # A weight exponent below 1 reduces the influence of the few nuisance points with the largest weights.
            weight_exponent = 1.0
            while (
                weight_exponent > 1e-3
                and compute_effective_sample_size(weight_exponent * log_weight) < 0.15 * NUM_NUISANCE_POINTS_PER_ROUND
            ):
                weight_exponent *= 0.7
            weight = np.exp(weight_exponent * (log_weight - log_weight.max()))
            mean = np.average(nuisance_points[:, active_indices], axis=0, weights=weight)
            covariance = np.cov(nuisance_points[:, active_indices].T, aweights=weight, ddof=0).reshape(
                len(active_indices), -1
            )
            covariance = covariance + 1e-6 * np.eye(len(active_indices))
            nuisance_points, grid, log_weight = self._draw_nuisance_points(
                mean, covariance, active_indices, NUM_NUISANCE_POINTS_PER_ROUND, seed
            )
        num_points = min(FINAL_NUISANCE_POINT_COUNTS[0] << len(active_indices), FINAL_NUISANCE_POINT_COUNTS[1])
        while active_indices:
            nuisance_points, grid, log_weight = self._draw_nuisance_points(
                mean, covariance, active_indices, num_points, MAX_PROPOSAL_ROUNDS
            )
            if (
                compute_effective_sample_size(log_weight)
                > min(MIN_EFFECTIVE_SAMPLES, MIN_EFFECTIVE_SAMPLE_FRACTION * num_points)
                or num_points >= MAX_NUISANCE_POINTS
            ):
                break
            num_points *= 2
        return self._draw_samples_from_grids(nuisance_points, grid, log_weight)

    def _build_first_proposal(self, scale: float, freedom: int | None) -> tuple[Floats, Floats]:
        """Return mean and covariance of the first proposal distribution, from which nuisance parameters are sampled."""
        score_indices = [index for index, name in enumerate(self.nuisances) if name != RUN_SPREAD_PARAMETER_NAME]
        num_parameters = len(self.nuisances) + (freedom is not None)
        mean, covariance = np.zeros(num_parameters), np.eye(num_parameters)
        mean[: len(self.nuisances)] = self.best_fit.scores
        if score_indices:
            num_residuals, jacobian_matrix = len(self.best_fit.residuals), self.best_fit.jacobian
            scaled_jacobian = np.concatenate(
                [jacobian_matrix[:num_residuals] * self.best_fit.scale / scale, jacobian_matrix[num_residuals:]]
            )
            inverse_hessian = np.linalg.pinv(scaled_jacobian.T @ scaled_jacobian, rcond=1e-12, hermitian=True)[
                -len(score_indices) :, -len(score_indices) :
            ]
            covariance[np.ix_(score_indices, score_indices)] = 1.2 * inverse_hessian
        if freedom is not None:
            mean[-1], covariance[-1, -1] = math.log(scale), 1.0 / freedom
        return mean, covariance

    def _draw_nuisance_points(
        self, mean: Floats, covariance: Floats, active_indices: list[int], count: int, seed: int = 0
    ) -> tuple[Floats, _ProbabilityGrid, Floats]:
        """Sample nuisance parameters. Return the samples, with a mu0-tau0 grid and a log-weight for each sample."""
        from scipy.special import gammaincinv, ndtri

        points = np.zeros((count, len(self.nuisances) + 1))
        log_weight = np.zeros(count)
        if active_indices:
            unit_points = generate_sobol_points(len(active_indices) + 1, count, seed=seed)
            deviates = ndtri(unit_points[:, :-1])
            chi_squared_ratio = PROPOSAL_DEGREES_OF_FREEDOM / (
                2 * gammaincinv(PROPOSAL_DEGREES_OF_FREEDOM / 2, unit_points[:, -1])
            )
            deviates = deviates * np.sqrt(chi_squared_ratio)[:, np.newaxis]
            points[:, active_indices] = mean + deviates @ np.linalg.cholesky(covariance).T
            power = 0.5 * (PROPOSAL_DEGREES_OF_FREEDOM + len(active_indices))
            log_weight = power * np.log1p((deviates**2).sum(axis=1) / PROPOSAL_DEGREES_OF_FREEDOM)
        grid = self._evaluate_probability_grids(points)
        log_evidence = np.logaddexp.reduce(grid.log_probability.reshape(count, -1), axis=1)
        log_weight = log_weight + log_evidence - 0.5 * (points[:, : len(self.nuisances)] ** 2).sum(axis=1)
        return points, grid, np.where(np.isfinite(log_weight), log_weight, -np.inf)

    def _draw_samples_from_grids(
        self, points: Floats, grid: _ProbabilityGrid, log_weight: Floats
    ) -> tuple[Floats, Floats, Floats]:
        """Draw joint samples of mu0, tau0 (GPa) and nuisance parameters in proportion to the grids' probabilities."""
        generator = np.random.default_rng(0)
        log_cell_probability = grid.log_probability.reshape(len(points), -1)
        with np.errstate(invalid="ignore"):
            log_excess = log_weight - np.logaddexp.reduce(log_cell_probability, axis=1)
        log_excess = np.where(np.isfinite(log_weight), log_excess, 0.0)
        log_cell_weight = log_cell_probability + log_excess[:, np.newaxis]
        cumulative_weight = np.cumsum(np.exp(log_cell_weight - log_cell_weight.max()))
        indices = select_by_weight(cumulative_weight, NUM_STRENGTH_PAIRS, generator.random())
        indices = generator.permutation(indices)
        point, row, column = np.unravel_index(indices, grid.log_probability.shape)
        low, high = grid.limits.min_tau0[point], grid.limits.max_tau0[point]
        tau0 = low + (high - low) * (row + generator.random(NUM_STRENGTH_PAIRS)) / grid.log_probability.shape[1]
        mu0_fraction = generator.random(NUM_STRENGTH_PAIRS)
        mu0 = self._find_mu0_in_cells(grid.limits, point, row, tau0, column + mu0_fraction)
        scores = points[point, : len(self.nuisances)]
        if self.has_growing_contacts:
            # If the softer body would shear at a random (mu0, tau0) of a grid cell, the centre of the cell is used.
            _, area_coefficients, _ = self._compute_equation_coefficients(scores, mu0, tau0)
            is_outside = ~np.isfinite(area_coefficients[:, self.slid]).all(axis=1)
            tau0_centre = low + (high - low) * (row + 0.5) / grid.log_probability.shape[1]
            mu0_centre = self._find_mu0_in_cells(grid.limits, point, row, tau0_centre, column + 0.5)
            mu0, tau0 = np.where(is_outside, mu0_centre, mu0), np.where(is_outside, tau0_centre, tau0)
        return mu0, tau0, scores

    def _find_mu0_in_cells(self, limits: _GridLimits, point: Any, row: Any, tau0: Floats, column: Any) -> Floats:
        """Convert column indices of mu0 grids (integer or fractional) to mu0. Each tau0 has its own mu0 grid."""
        mu0_start, mu0_step = self._choose_mu0_grid_at_tau0(limits, point, row, tau0)
        return np.asarray(mu0_start + mu0_step * column)

    # ---- Advice -----------------------------------------------------------------------------------------------------

    def suggest_tests(self, area_per_load: float, hardness: float) -> tuple[tuple[str, float, float], ...]:
        """Suggest tests that would separate mu0 from tau0, with the resulting standard errors of mu0 and tau0.

        `area_per_load` and `hardness` are the mean true area per load A/F (1/GPa) and the hardness (GPa, or NaN) of the
        present tests. The planned tests have the median relative error of the present tests, or 5 % if the errors are
        unknown.
        """
        mu0, tau0 = self.best_fit.mu0, self.best_fit.tau0
        best_fit_arguments = self.best_fit.scores[np.newaxis], np.array([mu0]), np.array([tau0])
        mu0_coefficient, tau0_coefficient, _ = (
            column[0] for column in self._compute_equation_coefficients(*best_fit_arguments)
        )
        predicted_coefficients = mu0_coefficient * mu0 + tau0_coefficient * tau0
        relative_error = (
            float(np.median(self.error / np.maximum(predicted_coefficients, 1e-12)))
            if self.has_errors
            else DEFAULT_RELATIVE_ERROR
        )
        num_tests = len(self.error)
        plans_with_errors = []
        for plan, further_areas_per_load in list_plans_that_vary_area_per_load(area_per_load, num_tests, hardness):
            areas_per_load = np.concatenate([np.full(num_tests, area_per_load), further_areas_per_load])
            coefficient_errors = relative_error * np.maximum(FrictionLaw(mu0, tau0).force(1.0, areas_per_load), 1e-12)
            design_matrix = np.stack([1 / coefficient_errors, areas_per_load / coefficient_errors], axis=1)
            covariance = np.linalg.inv(design_matrix.T @ design_matrix)
            plans_with_errors.append((plan, math.sqrt(covariance[0, 0]), math.sqrt(covariance[1, 1])))
        return tuple(plans_with_errors)


def _concatenate_grids(grids: Sequence[_ProbabilityGrid]) -> _ProbabilityGrid:
    """Join the probability grids of several batches of nuisance-parameter samples into one `_ProbabilityGrid`."""
    limits = [grid.limits for grid in grids]
    array_names = (
        "triangular_factors",
        "min_tau0",
        "max_tau0",
        *(("best_mu0", "width_below", "width_above") if limits[0].best_mu0 is not None else ()),
    )
    concatenated_arrays: dict[str, Any] = {
        name: np.concatenate([getattr(grid_limits, name) for grid_limits in limits]) for name in array_names
    }
    return _ProbabilityGrid(
        replace(limits[0], **concatenated_arrays), np.concatenate([grid.log_probability for grid in grids])
    )


def _build_run_membership_matrix(tests: Sequence[FrictionTest]) -> Floats:
    """Return a matrix of test runs (rows) and tests (columns) that is 1 where a test belongs to a run, else 0.

    The matrix has no rows unless there are at least two runs, one of which has at least two tests.
    """
    runs = [test.run for test in tests]
    run_names = [run for run in dict.fromkeys(runs) if run is not None]
    if len(run_names) < 2 or all(runs.count(name) < 2 for name in run_names):
        return np.zeros((0, len(runs)))
    return np.array([[run == name for run in runs] for name in run_names], float)


def _solve_nonnegative_least_squares(
    rows: Floats, weight: Floats, fixed_strengths: Sequence[float | None]
) -> tuple[float, float]:
    """Fit nonnegative mu0 and tau0 (GPa) to weighted test equations. If one of them is fixed, fit only the other."""
    from scipy.optimize import lsq_linear

    is_free = [value is None for value in fixed_strengths]
    strengths = np.array([0.0 if value is None else value for value in fixed_strengths])
    if any(is_free):
        root_weight = np.sqrt(weight)[:, np.newaxis]
        right_side = rows[:, 2] - rows[:, :2] @ strengths
        columns = rows[:, :2][:, is_free]
        scale = np.maximum(np.abs(columns).max(axis=0), 1e-300)
        strengths[is_free] = (
            lsq_linear(columns / scale * root_weight, right_side * root_weight[:, 0], (0.0, np.inf)).x / scale
        )
    return float(strengths[0]), float(strengths[1])


def _compute_triangular_factors(rows: Floats) -> Floats:
    """Return the triangular factors, with nonnegative diagonals, of QR decompositions of the test equations.

    The equations have the shape (points, tests, 3), and the factors have the shape (points, 3, 3).
    """
    if rows.shape[1] < 3:
        rows = np.concatenate([rows, np.zeros((len(rows), 3 - rows.shape[1], 3))], axis=1)
    factor: Floats = np.asarray(np.linalg.qr(rows, mode="r"))
    factor = factor * np.where(np.einsum("pii->pi", factor) < 0, -1.0, 1.0)[..., np.newaxis]
    min_diagonal = 1e-12 * np.abs(factor[:, :2, :2]).max(axis=(1, 2))
    for column in (0, 1):
        factor[:, column, column] = np.maximum(factor[:, column, column], np.maximum(min_diagonal, 1e-150))
    return np.asarray(factor)


def _find_tau0_range_at_best_mu0(triangular_factors: Floats, deviance_range: float) -> tuple[Floats, Floats]:
    """Return the limits of tau0 (GPa) outside which tau0 has a negligible probability density, whatever mu0 is."""
    first_row, second_row = triangular_factors[:, 0], triangular_factors[:, 1]
    # At mu0 = 0, -2 ln(density) is a quadratic function of tau0, and `curvature` is the coefficient of tau0².
    curvature = second_row[:, 1] ** 2 + first_row[:, 1] ** 2
    unbounded_best, best_at_bound = (
        second_row[:, 2] / second_row[:, 1],
        (second_row[:, 1] * second_row[:, 2] + first_row[:, 1] * first_row[:, 2]) / curvature,
    )
    tau0_at_zero_mu0 = first_row[:, 2] / np.where(first_row[:, 1] == 0, 1e-300, first_row[:, 1])

    def deviance(tau0: Floats) -> Floats:
        # Apart from a positive factor, `mu0` is the best mu0 at the given tau0.
        # Where the best mu0 is negative, the condition mu0 >= 0 raises the deviance by `mu0`².
        mu0 = first_row[:, 2] - first_row[:, 1] * tau0
        return np.asarray((second_row[:, 2] - second_row[:, 1] * tau0) ** 2 + np.minimum(mu0, 0.0) ** 2)

    min_deviance = np.min(
        [
            deviance(np.maximum(tau0, 0.0))
            for tau0 in (unbounded_best, best_at_bound, tau0_at_zero_mu0, np.zeros(len(unbounded_best)))
        ],
        axis=0,
    )
    max_deviance = min_deviance + deviance_range
    deviance_at_bound = (second_row[:, 2] - second_row[:, 1] * best_at_bound) ** 2 + (
        first_row[:, 2] - first_row[:, 1] * best_at_bound
    ) ** 2
    half_width, half_width_at_bound = (
        np.sqrt(max_deviance) / second_row[:, 1],
        np.sqrt(np.maximum(max_deviance - deviance_at_bound, 0.0) / curvature),
    )
    tau0_limits = []
    for sign in (-1.0, 1.0):
        bound = unbounded_best + sign * half_width
        tau0_limits.append(
            np.where(first_row[:, 2] - first_row[:, 1] * bound >= 0, bound, best_at_bound + sign * half_width_at_bound)
        )
    low = np.maximum(tau0_limits[0], 0.0)
    return low, np.maximum(tau0_limits[1], low + 1e-9 * np.abs(half_width_at_bound) + 1e-300)


def _find_tau0_range_at_fixed_mu0(
    mu0: float, triangular_factors: Floats, deviance_range: float
) -> tuple[Floats, Floats]:
    """Return the range of tau0 (GPa) in which the posterior density at a fixed mu0 is not negligible."""
    first_row, second_row = triangular_factors[:, 0], triangular_factors[:, 1]
    curvature = second_row[:, 1] ** 2 + first_row[:, 1] ** 2
    centre = (
        second_row[:, 1] * second_row[:, 2] + first_row[:, 1] * (first_row[:, 2] - first_row[:, 0] * mu0)
    ) / curvature
    half_width = np.sqrt(deviance_range / curvature)
    low = np.maximum(centre - half_width, 0.0)
    return low, np.maximum(centre + half_width, low + half_width)
