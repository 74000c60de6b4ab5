"""Friction tests and interface strengths. Strengths are inferred from tests, read from files or published.

An interface file has header lines that begin with "# ", and below them a table with one sample per row. The columns are
mu0, tau0, hardness, junction growth, and the true area per load of the tests (A/F).
"""

from __future__ import annotations

import contextlib
import csv
import io
import math
import tomllib
import warnings
import zlib
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, lru_cache
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats, check_callable, check_choice, check_instance, parse_path, validate_number
from stiction._files import UnreadableFileError, describe_os_error, read_file_bytes, replace_file_atomically
from stiction._text import printable_path, printable_text
from stiction._units import is_pressure, loads_to_core_units, short_repr, to_core_units
from stiction.mechanics.closed_forms import hardness_under_shear, hertz_sphere, tabor_friction
from stiction.mechanics.friction import LOAD_SUM_NAMES, ForcesPerLoad, FrictionCurve
from stiction.mechanics.model import SlidingRule
from stiction.studies.elasticity import PairElasticity
from stiction.studies.hardness import (
    AreaInterpolator,
    compute_relative_modulus,
    find_creep_exponent,
    find_junction_growth,
    find_uncertain_inputs,
)
from stiction.studies.input_uncertainty import (
    UncertainInput,
    draw_input_samples,
    parse_study_input,
    parse_uncertain_input,
)
from stiction.studies.junction_growth import build_area_interpolator
from stiction.studies.member_sums import MemberSums
from stiction.studies.member_values import compute_mean_areas, interpolate_member_sums, member_values
from stiction.studies.moduli import UncertainModulus, parse_elasticity
from stiction.studies.study import Study, parse_study_of_dataset

if TYPE_CHECKING:
    import pandas

INTERFACE_FILE_HEADER = "# stiction interface"  # first line of an interface file
INTERFACE_FILE_COLUMNS = (
    "mu0",
    "tau0 (GPa)",
    "hardness (GPa)",
    "junction growth",
    "area per load of the tests (1/GPa)",
)
MAX_INTERFACE_BYTES = 50_000_000  # maximum size of an interface file in bytes
_NUMERIC_HEADER_ENTRIES = ("area_per_load", "variation")

EXCLUSION_P_VALUE_LIMIT, ERROR_SCALING_P_VALUE_LIMIT = 0.01, 0.05
"""Probabilities of the residuals: below the first, a sliding rule is excluded; below the second, errors are scaled."""

# A lower limit is set to the bound if its distance from the bound is below this fraction of the interval width.
BOUND_TOLERANCE = 0.01
INTERVAL_COVERAGE = 0.95  # probability with which an interval contains the true value
SLIDING_RULES: tuple[SlidingRule, ...] = ("all", "opposing")

HARDNESS_HEADER_ENTRY = "hardness of the draws"
"""Name of the entry of `Interface.about` that contains the hardness range of all tests."""

GROWTH_HEADER_ENTRY = "junction growth of the draws"
"""Name of the entry of `Interface.about` that contains α of the tests.

The entry is missing if no test depends on α, or if α differs between tests.
"""

MIN_RELATIVE_PRESSURE = 1.001  # smallest ratio of the contact pressure in sliding contacts to the nominal pressure
VON_MISES_GROWTH_COEFFICIENT = (
    27.0  # value of α for which the shear strength of a body is its hardness divided by √27 (von Mises)
)
MIN_PLASTIC_AREA_RATIO, NEGLIGIBLE_GROWTH_EFFECT = 0.5, 0.05
"""Limits above which a coefficient depends on α.

The first limit is the ratio of the true area to the area of plastic contact, and the second limit is the relative
increase of the coefficient due to junction growth. A coefficient depends on α if both limits are exceeded.
"""

_AREA_ERROR_NAME = "area over hardness"

ValueWithLimits = tuple[float, float, float]  # value, lower limit and upper limit of the 95 % interval


@dataclass(frozen=True)
class Ball:
    """Smooth elastic ball on a smooth flat, for which the true area is the Hertzian contact area.

    Attributes
    ----------
    radius : float or str, µm
    effective_modulus : float or str, GPa
        E* as in "3 GPa", or a range as in "2..4.5 GPa". The attribute is the middle of the range, or None if the moduli
        of the bodies are given.
    young, poisson : optional
        Young's moduli and Poisson's ratios of both bodies; ranges are accepted.
    upper_material, lower_material : str, optional
        Names of the materials of the bodies. The moduli have the ranges that `material` returns.

    Examples
    --------
    >>> from stiction import Ball
    >>> round(Ball("5 mm", "3 GPa").area_per_load(100.0), 2)  # µm²/mN
    78.54
    """

    radius: float | str
    effective_modulus: float | str | None = None
    young: Any = field(default=None, kw_only=True)
    poisson: Any = field(default=None, kw_only=True)
    upper_material: str | None = field(default=None, kw_only=True)
    lower_material: str | None = field(default=None, kw_only=True)
    elasticity: PairElasticity = field(
        init=False, repr=False, compare=False
    )  # elastic properties computed from the central values of both moduli
    moduli: UncertainModulus = field(init=False, repr=False, hash=False)  # moduli of both bodies with their uncertainty

    def __post_init__(self) -> None:
        """Convert the radius and the moduli to core units."""
        radius = validate_number("radius", to_core_units("radius", self.radius, "length"), unit="µm", above=0)
        object.__setattr__(self, "radius", radius)
        elasticity, moduli = parse_elasticity(
            self.effective_modulus, self.young, self.poisson, self.upper_material, self.lower_material
        )
        object.__setattr__(self, "effective_modulus", elasticity.effective_modulus)
        object.__setattr__(self, "elasticity", elasticity)
        object.__setattr__(self, "moduli", moduli)

    def area_per_load(self, load: float | str) -> float:
        """Return the true area per load A/F (1/GPa) at a load (mN), computed with the central values of the moduli."""
        load = validate_number("load", load, unit="mN", above=0)
        radius, modulus = float(self.radius), self.elasticity.effective_modulus
        overlap = (0.75 * load / (modulus * math.sqrt(radius))) ** (2 / 3)
        force, area = hertz_sphere(overlap, radius, modulus)
        return float(area / force)


@dataclass(frozen=True, kw_only=True)
class _FrictionTestForces(ForcesPerLoad):
    """Normal and tangential forces per load in a friction test, as functions of mu0 and tau0."""

    scatter: float = 0.0  # relative standard error of the adhesive sum `stick`
    surfaces: Hashable = None  # key of the surfaces; tests with equal keys share the area error
    hardness: float = math.nan
    area_factor: _AreaFactor | None = None


@dataclass(frozen=True)
class StrengthSamples:
    """Samples of mu0 and tau0 (GPa), or samples of a friction coefficient, that define the strength of an interface."""

    sliding: SlidingRule
    mu0: Floats
    # None if `mu0` is the ratio T/F of sliding contacts
    tau0: Floats | None = None

    def pressure_under_shear(self, hardness: Floats, alpha: Floats | float) -> Floats:
        """Return the pressure H' (GPa) in plastic contacts under shear, computed from the hardness H (GPa)."""
        if self.tau0 is None:  # p² + α s² = H² with s = (T/F) p
            return np.asarray(hardness / np.sqrt(1 + alpha * self.mu0**2))
        return hardness_under_shear(hardness, self.mu0, self.tau0, alpha)


@dataclass(frozen=True)
class _AreaFactor:
    """Area factor, i.e. the ratio of true area to computed area, as a function of uncertain inputs."""

    # uncertain inputs by name: hardness, creep exponent, moduli and α of junction growth
    known: Mapping[str, UncertainInput]

    def nuisance_name(self, name: str) -> str:
        """Return the name of the nuisance parameter for an input. Tests with equal inputs share this parameter."""
        return f"{name} {self.known[name].text}"

    @property
    def nuisance_names(self) -> list[str]:
        """Names of all nuisance parameters."""
        return [self.nuisance_name(name) for name in self.known]

    def input_values(self, columns: Mapping[Any, Floats]) -> dict[str, Floats]:
        """Convert cumulative probabilities of the nuisance parameters to input values."""
        return {name: each.quantile(columns[self.nuisance_name(name)]) for name, each in self.known.items()}

    @property
    def junction_growth(self) -> UncertainInput | None:
        """Junction growth α, or None if contacts do not grow."""
        return None

    def area_factor_for_probabilities(
        self, columns: Mapping[Any, Floats], strength: StrengthSamples | None = None
    ) -> Floats:
        """Compute the ratio of true area to computed area from cumulative probabilities of nuisance parameters."""
        return self.area_factor_for_inputs(self.input_values(columns), strength)

    def area_factor_for_inputs(self, samples: Mapping[str, Floats], strength: StrengthSamples | None = None) -> Floats:
        """Return the ratio of the true area to the computed area for given values of the inputs.

        If a strength is given, the true area is the area at the onset of sliding with junction growth, which is
        infinite at seizure.
        """
        raise NotImplementedError


@dataclass(frozen=True)
class _BallAreaFactor(_AreaFactor):
    """Area factor of a Hertzian point contact. The area is proportional to E*^(-2/3)."""

    moduli: UncertainModulus

    def area_factor_for_inputs(self, samples: Mapping[str, Floats], strength: StrengthSamples | None = None) -> Floats:
        """Return the true area divided by the true area for the central moduli. The interface strength is ignored."""
        return np.asarray(self.moduli.relative_modulus(samples)) ** (-2 / 3)


@dataclass(frozen=True)
class _AreaFactorFromResult(_AreaFactor):
    """Area factor at a given load, computed from a result for measured bodies."""

    areas: AreaInterpolator
    study: Study
    wait: float
    error: str | None  # name of the nuisance parameter for the error of the interpolated area

    @classmethod
    def from_result(cls, result: Any, load: float, wait: float) -> _AreaFactorFromResult | None:
        """Return the area factor of a result, or None if no uncertain input, creep or growth affects the area."""
        sums = MemberSums.of(result)
        study = sums.study
        uncertain_inputs = {
            name: each.estimate for name, each in find_uncertain_inputs(study).items() if name not in ("mu0", "tau0")
        }
        creep = find_creep_exponent(study)
        if wait != 1 and creep is None:
            raise ValueError("wait requires a result that was computed with the options wait and creep")
        if not uncertain_inputs and creep is None and find_junction_growth(study) is None:
            return None
        members = member_values(sums, [load], mu0=[0.0], tau0=[0.0])
        means = members[["contact_area", "rms_gradient"]].mean("repetition").expand_dims(statistic=["mean"])
        areas = build_area_interpolator(means, sums, sums.compute_once(compute_mean_areas))
        error_name = f"{_AREA_ERROR_NAME} after {wait:g} s, {sums.head.attrs['study']}" if areas.errors.any() else None
        return cls(uncertain_inputs | ({} if creep is None else {"creep": creep}), areas, study, wait, error_name)

    @property
    def nuisance_names(self) -> list[str]:
        """Names of all nuisance parameters.

        Tests with the same dwell time share the error of the interpolated area.
        """
        return [*super().nuisance_names, *([] if self.error is None else [self.error])]

    def input_values(self, columns: Mapping[Any, Floats]) -> dict[str, Floats]:
        """Return the input values, and the standard normal score that sets the interpolation error of the area."""
        from scipy.special import ndtri

        scores = {} if self.error is None else {_AREA_ERROR_NAME: ndtri(columns[self.error])}
        return super().input_values(columns) | scores

    @property
    def junction_growth(self) -> UncertainInput | None:
        """Junction growth α, or None if contacts do not grow."""
        return find_junction_growth(self.study)

    def area_factor_for_inputs(self, samples: Mapping[str, Floats], strength: StrengthSamples | None = None) -> Floats:
        """Return the ratio of the true area to the computed area for given values of the inputs.

        If a strength is given, the true area is the area at the onset of sliding with junction growth, which is
        infinite at seizure.
        """
        hardness = samples.get("hardness", np.asarray(self.areas.hardness or math.nan))
        hardness = hardness * self.wait ** -samples["creep"] if "creep" in samples else hardness
        modulus = compute_relative_modulus(self.study, samples)
        factor = self.areas.area_ratio(0, None if self.areas.hardness is None else hardness, modulus)
        if self.junction_growth is not None and strength is not None:
            pressure = strength.pressure_under_shear(
                hardness, samples.get("junction_growth", self.junction_growth.value)
            )
            # keeps the pressure above the nominal pressure, so that the computed area is finite
            if strength.tau0 is None:
                pressure = np.maximum(pressure, MIN_RELATIVE_PRESSURE * self.areas.pressures[0])
            factor = factor * self.areas.growth_ratio(0, strength.sliding, hardness, pressure, modulus)
            hardness = np.where(np.isfinite(factor), pressure, hardness)
        if _AREA_ERROR_NAME in samples:
            factor = factor * np.exp(self.areas.area_ratio_error(0, hardness / modulus) * samples[_AREA_ERROR_NAME])
        return np.asarray(factor)


MIN_COEFFICIENT_UNCERTAINTY = 1e-15
"""Smallest standard uncertainty of a measured coefficient that does not cause an overflow of the weights."""


@dataclass(frozen=True)
class FrictionTest:
    """Friction test, described by its surfaces, load and measured coefficient.

    Attributes
    ----------
    result : Result, HalfSpaceCurve, LoadCurve or Ball
        Contact of the surfaces under load. Tests on the same surfaces must use the same object.
    load : float or str, mN
        Normal load, as in "10 mN", or pressure, as in "10 MPa", if the result has a nominal area.
    coefficient : float, optional
    force : float or str, mN, optional
        Tangential force at the onset of sliding (the first peak), instead of the coefficient.
    uncertainty : float or str, optional
        Standard uncertainty of the coefficient, or of the force (mN) if the force is given. A string is an uncertainty
        of the force, as in "20 mN", or a relative uncertainty, as in "3 %". By default the uncertainty is estimated
        from the scatter of the tests.
    slid : bool
        True if the pair slid; otherwise the coefficient is a lower bound.
    run : str or int, optional
        Name of the specimen or series. Tests of the same run share an unknown offset.
    wait : float or str, s
        Dwell time under load before shear. Values other than 1 s require a result with dwell times and a creep
        exponent.

    Examples
    --------
    >>> from stiction import Ball, FrictionTest
    >>> FrictionTest(Ball("5 mm", "3 GPa"), "100 mN", force="20 mN").coefficient
    0.2
    """

    result: Any
    load: float | str
    coefficient: float | None = None
    force: float | str | None = None
    uncertainty: float | str | None = None
    slid: bool = True
    run: str | int | None = None
    wait: float | str = 1.0

    def __post_init__(self) -> None:
        """Convert the load, the coefficient and the uncertainty to numbers."""
        nominal_area = getattr(self.result, "nominal_area", None)
        load_value = (
            to_core_units("load", self.load, "force")
            if nominal_area is None
            else loads_to_core_units("load", self.load, nominal_area)
        )
        load = validate_number("load", load_value, unit="mN", above=0)
        object.__setattr__(
            self, "wait", validate_number("wait", to_core_units("wait", self.wait, "time"), unit="s", above=0)
        )
        if (self.coefficient is None) == (self.force is None):
            raise ValueError("either coefficient or force must be given, but not both")
        if self.force is not None:
            if is_pressure(self.load):
                raise ValueError(
                    "coefficient must be given instead of force if the load is a pressure, because the area of the "
                    f"specimen is unknown, got load {self.load!r} and force {self.force!r}"
                )
            force = validate_number("force", to_core_units("force", self.force, "force"), unit="mN")
            object.__setattr__(self, "coefficient", force / load)
        coefficient = validate_number("coefficient", self.coefficient, below=1e6)
        if not coefficient >= 0:
            raise ValueError(f"the measured coefficient must not be negative, got {coefficient:g}")
        object.__setattr__(self, "coefficient", coefficient)
        object.__setattr__(self, "load", load)
        if self.uncertainty is not None:
            uncertainty = self._compute_coefficient_uncertainty(load)
            if not uncertainty >= MIN_COEFFICIENT_UNCERTAINTY:
                raise ValueError(
                    "uncertainty of a coefficient must be at least "
                    f"{MIN_COEFFICIENT_UNCERTAINTY:g}, got {uncertainty:g}"
                )
            object.__setattr__(self, "uncertainty", uncertainty)

    def _compute_coefficient_uncertainty(self, load: float) -> float:
        """Convert the given uncertainty to the standard uncertainty of the coefficient at a load (mN)."""
        uncertainty, is_force = self.uncertainty, self.force is not None
        if isinstance(uncertainty, str) and uncertainty.strip().endswith("%"):
            try:
                percent_value = float(uncertainty.strip().removesuffix("%"))
            except ValueError:
                raise ValueError(f"uncertainty must be a percentage, as in '3 %', got {uncertainty!r}") from None
            return validate_number("uncertainty", 0.01 * percent_value * float(self.coefficient or 0.0), above=0)
        if isinstance(uncertainty, str):
            uncertainty, is_force = to_core_units("uncertainty", uncertainty, "force"), True
        return validate_number("uncertainty", uncertainty, above=0) / (load if is_force else 1.0)

    @cached_property
    def area_factor(self) -> _AreaFactor | None:
        """Area factor of the test, or None if no uncertain input, creep or growth affects the area."""
        if isinstance(self.result, Ball):
            return _BallAreaFactor(self.result.moduli.inputs, self.result.moduli) if self.result.moduli.inputs else None
        return _AreaFactorFromResult.from_result(self.result, float(self.load), float(self.wait))


@dataclass(frozen=True)
class StrengthFit:
    """Joint distribution of mu0 and tau0 fitted with one sliding rule, and the quality of the fit."""

    sliding: SlidingRule
    chi_squared: float  # chi-squared of the best fit; without given errors, it has no meaning
    freedom: int  # number of tests with sliding minus number of fitted parameters
    probability: float  # probability of a larger chi_squared; NaN if there are no errors or no degrees of freedom
    scale: float  # factor by which the errors were multiplied
    trend: float  # p-value of the trend of the residuals with the load
    mu0: Floats  # samples of mu0
    tau0: Floats  # samples of tau0 (GPa), paired with `mu0`
    hardness: Floats  # samples of the hardness (GPa), paired with `mu0`; NaN if the hardness differs between tests
    junction_growth: Floats  # samples of α, paired with `mu0`; NaN if α differs between tests or has no effect
    area_per_load: Floats  # samples of A/F (1/GPa) at the onset of sliding in the tests; NaN if unknown
    scores: Mapping[Hashable, Floats] = field(default_factory=dict)  # normal scores of the nuisance parameters


@dataclass(frozen=True)
class Interface:
    """Strength of an interface, expressed as a joint distribution of mu0 and tau0.

    Attributes
    ----------
    fits : tuple of StrengthFit
        Fits for the requested sliding rules, in order of preference.
    area_per_load : float, 1/GPa
        True area per load (A/F) of the tests, at which mu0 + tau0 A/F is identified.
    variation : float
        Standard deviation of A/F among the tests, divided by the mean.
    separated : bool
        True if the tests determine mu0 and tau0 separately, rather than only the sum mu0 + tau0 A/F.
    advice : tuple of (str, float, float)
        Further tests that would separate mu0 and tau0, each with the expected standard errors of mu0 and tau0 (GPa)
        after these tests.
    tests : tuple of (float, float, float, bool)
        For each test: A/F (1/GPa), coefficient, standard uncertainty of the coefficient (NaN if not given), and True if
        the pair slid.
    about : mapping of str to str
        Kind ("measured", "lumped" or "bound"), materials, conditions and source.

    Examples
    --------
    >>> from stiction import interface
    >>> strength = interface("MoS2 on bearing steel, dry air")
    >>> strength.separated, round(strength.tau0[0], 4)
    (True, 0.0248)
    """

    fits: tuple[StrengthFit, ...]
    area_per_load: float
    variation: float
    separated: bool
    advice: tuple[tuple[str, float, float], ...] = ()
    tests: tuple[tuple[float, float, float, bool], ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Describe the interface by the sum mu0 + tau0 A/F, and by mu0 and tau0 if the tests can separate them."""
        entries = [("mu0 + tau0 A/F", self.identified, "")]
        if self.separated:
            entries += [("mu0", self.mu0, ""), ("tau0", self.tau0, " GPa")]
        rows = [
            f"  {name:<14}  {value:.4g} [{low:.4g}, {high:.4g}]{unit}"
            for name, (value, low, high), unit in entries
            if math.isfinite(value)
        ]
        return "\n".join(["Interface", *rows, *(f"  {key:<14}  {text}" for key, text in self.about.items())])

    @property
    def has_unknown_range(self) -> bool:
        """True if the source has a single mu0 and a single tau0, without their ranges."""
        return bool(np.ptp(self.fits[0].mu0) == np.ptp(self.fits[0].tau0) == 0)

    @property
    def identified(self) -> ValueWithLimits:
        """Sum mu0 + tau0 A/F with its 95 % interval, evaluated at the A/F of the tests."""
        area_per_load = self.fits[0].area_per_load
        if not np.isfinite(area_per_load).all():
            return self.at(self.area_per_load)
        return self.interval_of(lambda mu0, tau0: mu0 + tau0 * area_per_load)

    @property
    def mu0(self) -> ValueWithLimits:
        """Molecular friction coefficient mu0 with its interval, or NaN if the tests do not separate mu0 and tau0."""
        return self.strength_intervals[0] if self.separated else (math.nan,) * 3

    @property
    def tau0(self) -> ValueWithLimits:
        """Adhesive shear strength tau0 (GPa) with its interval, or NaN if the tests do not separate mu0 and tau0."""
        return self.strength_intervals[1] if self.separated else (math.nan,) * 3

    @cached_property
    def strength_intervals(self) -> tuple[ValueWithLimits, ValueWithLimits]:
        """Intervals of mu0 and tau0 (GPa), computed even if the tests do not separate mu0 and tau0."""
        return self.interval_of(lambda mu0, tau0: mu0), self.interval_of(lambda mu0, tau0: tau0)

    @cached_property
    def samples_at_bounds(self) -> tuple[tuple[Floats, Floats], ...]:
        """Pairs of mu0 and tau0 samples (GPa). In each pair, a parameter whose interval includes 0 is set to 0.

        The shift does not change the sum mu0 + tau0 A/F at the A/F of the tests.
        """
        fit = self.fits[0]
        area_per_load = fit.area_per_load
        are_both_fitted = np.isfinite(area_per_load).all() and np.ptp(fit.mu0) > 0 and np.ptp(fit.tau0) > 0
        zeros = np.zeros(fit.mu0.size)
        strengths = []
        if are_both_fitted and compute_credible_interval(fit.mu0, 0.0)[1] == 0:
            strengths.append((zeros, fit.tau0 + fit.mu0 / area_per_load))
        if are_both_fitted and compute_credible_interval(fit.tau0, 0.0)[1] == 0:
            strengths.append((fit.mu0 + fit.tau0 * area_per_load, zeros))
        return tuple(strengths)

    def interval_of(self, coefficient: Callable[[Floats, Floats], Floats]) -> ValueWithLimits:
        """Return the median and the 95 % interval of a coefficient, given as a function of mu0 and tau0 (GPa).

        The interval also covers the intervals for mu0 = 0 and for tau0 = 0, unless the tests exclude these values.
        """
        check_callable("coefficient", coefficient)
        fit = self.fits[0]
        value, low, high = compute_credible_interval(coefficient(fit.mu0, fit.tau0), 0.0)
        for strength in self.samples_at_bounds:
            _, low_at_bound, high_at_bound = compute_credible_interval(coefficient(*strength), 0.0)
            low, high = min(low, low_at_bound), max(high, high_at_bound)
        return value, low, high

    def at(self, area_per_load: float) -> ValueWithLimits:
        """Return the sum mu0 + tau0 A/F with its 95 % interval, evaluated at a given A/F (1/GPa)."""
        area_per_load = validate_number("area_per_load", area_per_load)
        if area_per_load < 0:
            raise ValueError(f"area_per_load must be at least 0, got {area_per_load:g}")
        return self.interval_of(lambda mu0, tau0: mu0 + tau0 * area_per_load)

    @property
    def excluded(self) -> tuple[SlidingRule, ...]:
        """Sliding rules that the tests exclude. The tuple is empty if no sliding rule fits the tests."""
        accepted_rules = [fit.sliding for fit in self.fits if fit.probability > ERROR_SCALING_P_VALUE_LIMIT]
        return tuple(fit.sliding for fit in self.fits if fit.probability < EXCLUSION_P_VALUE_LIMIT and accepted_rules)

    @cached_property
    def draws(self) -> pandas.DataFrame:
        """Joint samples of mu0, tau0 (GPa) and hardness (GPa), with one sample per row.

        The hardness is NaN unless all tests share its range.
        """
        import pandas

        fit = self.fits[0]
        return pandas.DataFrame({"mu0": fit.mu0, "tau0": fit.tau0, "hardness": fit.hardness})

    def predict(self, result: Any, load: float | str) -> ValueWithLimits:
        """Predict the friction coefficient of other surfaces at a load, with its 95 % interval.

        Parameters
        ----------
        result : Result, HalfSpaceCurve, LoadCurve or Ball
        load : float or str, mN

        Returns
        -------
        (float, float, float)
            Value, lower limit and upper limit. The interval includes the joint uncertainty of mu0 and tau0, and the
            scatter of the area between positions. A limit is infinite at seizure.

        Warns
        -----
        UserWarning
            If α of junction growth differs between the tests and the result.
        """
        if not (isinstance(result, (Ball, FrictionCurve)) or hasattr(result, "dataset") or hasattr(result, "attrs")):
            raise ValueError(f"result must be a Result, a curve or a Ball, got {type(result).__name__}")
        from scipy.special import ndtr

        fit, generator = self.fits[0], np.random.default_rng(1)
        test_forces = evaluate_test_forces(FrictionTest(result, load, coefficient=0.0), fit.sliding)

        def draw_scores(name: Hashable) -> Floats:
            # If an input also occurs in the tests, its samples from the fit are used.
            return fit.scores[name] if name in fit.scores else generator.standard_normal(len(fit.mu0))

        area_samples = np.exp(test_forces.scatter * draw_scores(test_forces.surfaces))
        if (area_factor := test_forces.area_factor) is not None:
            samples = area_factor.input_values({name: ndtr(draw_scores(name)) for name in area_factor.nuisance_names})
            if "hardness" in samples and area_factor.known["hardness"].describes_same_hardness(
                self.about.get(HARDNESS_HEADER_ENTRY, "")
            ):
                samples["hardness"] = fit.hardness
            if "junction_growth" in samples and self.has_equal_junction_growth(area_factor.known["junction_growth"]):
                samples["junction_growth"] = fit.junction_growth
        growth = None if area_factor is None else area_factor.junction_growth
        depends_on_alpha = growth is not None or depends_on_junction_growth(
            test_forces, float(np.median(fit.mu0)), float(np.median(fit.tau0))
        )
        if depends_on_alpha and self.junction_growth is not None and not self.has_equal_junction_growth(growth):
            test_alpha, result_alpha = (
                estimate.short_text if estimate is not None else "0" for estimate in (self.junction_growth, growth)
            )
            warnings.warn(
                f"the interface was calibrated with α = {test_alpha} of junction growth, and the result has "
                f"α = {result_alpha}; press both with the same junction_growth",
                stacklevel=2,
            )

        def compute_coefficients(mu0: Floats, tau0: Floats) -> Floats:
            strength = StrengthSamples(fit.sliding, mu0, tau0)
            total_area = (
                area_samples
                if area_factor is None
                else area_samples * area_factor.area_factor_for_inputs(samples, strength)
            )
            values = test_forces.compute_coefficient(mu0, tau0, np.where(tau0 > 0, total_area, 1.0))
            return np.where(np.isfinite(values), values, np.inf)

        return self.interval_of(compute_coefficients)

    @property
    def junction_growth(self) -> UncertainInput | None:
        """Junction growth α of the tests, or None if α differs between tests or does not affect them."""
        if GROWTH_HEADER_ENTRY not in self.about:
            return None
        median = float(f"{np.median(self.fits[0].junction_growth):.4g}")
        return replace(parse_study_input("junction_growth", self.about[GROWTH_HEADER_ENTRY]), value=median)

    def has_equal_junction_growth(self, growth: UncertainInput | None) -> bool:
        """Return whether the junction growth α of the tests has the distribution `junction_growth` (None for α = 0)."""
        test_growth = self.junction_growth
        if test_growth is None or growth is None:
            return test_growth is not None and test_growth.high == 0
        return test_growth.distribution == growth.distribution and np.allclose(
            [test_growth.low, test_growth.high], [growth.low, growth.high]
        )


def compute_credible_interval(values: Floats, bound: float = -math.inf) -> ValueWithLimits:
    """Return the median of the samples, and the limits of the interval that contains 95 % of them.

    The interval has equal tails, unless the shortest interval with 95 % of the samples starts at the bound. Then this
    shortest interval is returned.
    """
    sorted_values = np.sort(values)
    num_inside = math.ceil(INTERVAL_COVERAGE * len(sorted_values)) - 1
    start_index = int((sorted_values[num_inside:] - sorted_values[: len(sorted_values) - num_inside]).argmin())
    if sorted_values[start_index] - bound < BOUND_TOLERANCE * (
        sorted_values[start_index + num_inside] - sorted_values[start_index]
    ):
        low, high = bound, float(sorted_values[num_inside])
    else:
        low, high = (
            float(end) for end in np.quantile(sorted_values, [(1 - INTERVAL_COVERAGE) / 2, (1 + INTERVAL_COVERAGE) / 2])
        )
    return float(np.median(sorted_values)), low, high


def depends_on_junction_growth(friction: _FrictionTestForces, mu0: float, tau0: float) -> bool:
    """Return whether junction growth with α = 27 (von Mises) would noticeably change the friction coefficient."""
    if not friction.stick * friction.hardness > MIN_PLASTIC_AREA_RATIO:
        return False
    coefficient, coefficient_with_growth = tabor_friction(
        friction.hardness, mu0, tau0, [0.0, VON_MISES_GROWTH_COEFFICIENT]
    )
    return not coefficient_with_growth <= (1 + NEGLIGIBLE_GROWTH_EFFECT) * coefficient


def list_sliding_rules(result: Any) -> tuple[str, ...]:
    """Return the sliding rules for which a result contains values."""
    if isinstance(result, Ball):  # A ball has a single contact, so both rules give the same friction.
        return SLIDING_RULES
    if isinstance(result, FrictionCurve):
        return (str(getattr(result, "sliding", "all")),)
    return tuple(parse_study_of_dataset(getattr(result, "dataset", result)).contact.sliding_rules())


def evaluate_test_forces(test: FrictionTest, sliding: SlidingRule) -> _FrictionTestForces:
    """Evaluate the forces per load in a friction test for a given sliding rule."""
    result, load = test.result, float(test.load)
    if isinstance(result, (Ball, FrictionCurve)) and test.wait != 1:
        raise ValueError("wait requires a result of `pair` with a creep exponent")
    if isinstance(result, Ball):
        return _FrictionTestForces(stick=result.area_per_load(load), area_factor=test.area_factor)
    if isinstance(result, FrictionCurve):
        return _interpolate_forces_per_load(result, load)
    return replace(_average_forces_per_load(result, load, sliding), area_factor=test.area_factor)


def _interpolate_forces_per_load(curve: FrictionCurve, load: float) -> _FrictionTestForces:
    """Interpolate a load curve to a given load, and return the forces per load."""
    loads = np.asarray(curve.normal_elastic)
    if not loads.min() <= load * (1 + 1e-9) or not load * (1 - 1e-9) <= loads.max():
        range_text = f"{loads.min():g} to {loads.max():g} mN"
        raise ValueError(f"load must be within the range of the curve ({range_text}), got {load:g}")
    order = np.argsort(loads)

    def interpolate_sum(name: str) -> float:
        values = np.asarray(getattr(curve, name))
        values = values.reshape(-1, values.shape[-1])[0] / loads
        return float(np.interp(math.log(load), np.log(loads[order]), values[order]))

    return _FrictionTestForces.from_contact_sums(
        {name: interpolate_sum(name) for name in LOAD_SUM_NAMES},
        hardness=float(getattr(curve, "hardness", None) or math.nan),
    )


def _average_forces_per_load(result: Any, load: float, sliding: SlidingRule) -> _FrictionTestForces:
    """Average the forces per load over the members and directions of a result at a given load."""
    dataset = getattr(result, "dataset", result)
    sums = (
        interpolate_member_sums(dataset, np.array([load]))
        .sel(sliding=sliding)
        .isel(cut_off=0, load=0, missing_dims="ignore")
    )
    contact_sums = {str(name): values.mean("direction").values.reshape(-1) for name, values in sums.data_vars.items()}
    is_reached = np.isfinite(list(contact_sums.values())).all(axis=0)
    if not is_reached.any():
        area = getattr(result, "nominal_area", None)
        hint = (
            f", which is {1e3 * load / area:.4g} MPa on the area of the scans; specify a pressure for a larger specimen"
            if area
            else ""
        )
        raise ValueError(f"load must be within the range of the result, got {load:g} mN{hint}")
    adhesive_sums = contact_sums["tangential_adhesive"][is_reached]
    relative_error = (
        float(adhesive_sums.std(ddof=1) / adhesive_sums.mean() / math.sqrt(len(adhesive_sums)))
        if len(adhesive_sums) > 1
        else 0.0
    )
    means = {name: values[is_reached].mean() for name, values in contact_sums.items()}
    surfaces = dataset.attrs["study"]
    return _FrictionTestForces.from_contact_sums(
        means,
        scatter=relative_error,
        surfaces=surfaces,
        hardness=float(parse_study_of_dataset(dataset).contact.hardness or math.nan),
    )


# ---- Files -----------------------------------------------------------------------------------------------------------


def write_interface(interface: Interface, path: str | Path, about: Mapping[str, str] | None = None) -> None:
    """Write an interface as a text file with a header and one sample per row.

    Parameters
    ----------
    interface : Interface
        Interface to write.
    path : path
        Path of the file. An existing file is replaced only if it is an interface file.
    about : mapping of str to str, optional
        Additional entries of the header, such as materials, conditions and operator.

    Raises
    ------
    ValueError
        If the path is a file of another kind, or if the file cannot be written.

    See Also
    --------
    read_interface : Inverse function.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from stiction import interface, read_interface, write_interface
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "film.csv"
    ...     write_interface(interface("MoS2 on bearing steel, dry air"), path, {"operator": "A. B."})
    ...     read_interface(path).about["operator"]
    'A. B.'
    """
    check_instance("interface", interface, Interface, "an Interface from calibrate()")
    content = _format_interface(interface, about or {})
    with replace_file_atomically(parse_path("path", path), INTERFACE_FILE_HEADER.encode(), ValueError) as file:
        file.write_bytes(content)


def store_interface(interface: Interface, folder: Path) -> Path:
    """Write an interface to a folder for a study in this folder, and return the path of the file.

    Files of other interfaces in the folder belong to other studies and are kept.
    """
    content = _format_interface(interface, {})
    path = folder / "interface.csv"
    folder.mkdir(parents=True, exist_ok=True)
    if path.exists() and path.read_bytes() != content:
        path = folder / f"interface-{zlib.crc32(content):08x}.csv"
    write_interface(interface, path)
    return path


def _format_interface(interface: Interface, about: Mapping[str, str]) -> bytes:
    header = {
        "sliding": interface.fits[0].sliding,
        "area_per_load": repr(interface.area_per_load),
        "variation": repr(interface.variation),
        "separated": "yes" if interface.separated else "no",
    }
    for key, value in {**interface.about, **about}.items():
        text = " ".join(str(value).split())
        if not key.strip() or key in header or ": " in f"{key} " or key != printable_text(key):
            raise ValueError(f"about must have names of other entries as keys, got {short_repr(key)}")
        header[key] = printable_text(text, len(text))
    file_text = io.StringIO()
    file_text.write(
        "\n".join(
            [
                INTERFACE_FILE_HEADER,
                *(f"# {key}: {value}" for key, value in header.items()),
                ",".join(INTERFACE_FILE_COLUMNS),
            ]
        )
        + "\n"
    )
    fit = interface.fits[0]
    columns = [fit.mu0, fit.tau0, fit.hardness, fit.junction_growth, fit.area_per_load]
    np.savetxt(file_text, np.stack(columns, axis=1), fmt="%.9g", delimiter=",")
    return file_text.getvalue().encode()


def read_interface(path: str | Path) -> Interface:
    """Read an interface from a file written by `write_interface`.

    Parameters
    ----------
    path : path
        Path of the file.

    Returns
    -------
    interface : Interface
        Joint distribution of mu0 and tau0 (GPa).

    Raises
    ------
    ValueError
        If the file cannot be read, or is not an interface file.

    See Also
    --------
    write_interface : Inverse function.

    Examples
    --------
    >>> from stiction import read_interface
    >>> read_interface("no such file")
    Traceback (most recent call last):
    ...
    ValueError: no such file cannot be read as an interface: No such file or directory
    """
    check_instance("path", path, (str, Path), "a path")
    try:
        lines = (
            read_file_bytes(parse_path("path", path), MAX_INTERFACE_BYTES, INTERFACE_FILE_HEADER.encode())
            .decode("utf-8")
            .splitlines()
        )
    except UnreadableFileError as error:
        raise ValueError(f"{printable_path(path)} is not an interface file: {error}") from None
    except OSError as error:
        raise ValueError(f"{printable_path(path)} cannot be read as an interface: {describe_os_error(error)}") from None
    except UnicodeDecodeError:
        raise ValueError(f"{printable_path(path)} is not an interface file, because it is not a text file") from None
    header = dict(line[2:].partition(": ")[::2] for line in lines[1:] if line.startswith("# "))
    rows = [line for line in lines if line and not line.startswith("#")]
    try:
        if lines[0] != INTERFACE_FILE_HEADER or tuple(next(csv.reader(rows))) != INTERFACE_FILE_COLUMNS:
            raise ValueError
        table = np.array([[float(cell) for cell in row] for row in csv.reader(rows[1:])])
        area_per_load, variation = (float(header.pop(name)) for name in _NUMERIC_HEADER_ENTRIES)
        sliding, separated = header.pop("sliding"), header.pop("separated") == "yes"
        check_choice("sliding", sliding, SlidingRule)
        parse_study_input("junction_growth", header.get(GROWTH_HEADER_ENTRY, "0"))
    except (ValueError, KeyError, csv.Error, StopIteration):
        reason = "an entry of the header is missing or unknown, or a row does not have five numbers"
        raise ValueError(f"{printable_path(path)} is a damaged interface file ({reason})") from None
    if (
        table.ndim != 2
        or table.shape[1] != len(INTERFACE_FILE_COLUMNS)
        or not (np.isfinite(table[:, :2]) & (table[:, :2] >= 0)).all()
    ):
        raise ValueError(f"{printable_path(path)} is a damaged interface file (mu0 and tau0 must be at least 0)")
    fit = _build_strength_fit(sliding, *table.T)
    return Interface((fit,), area_per_load, variation, separated, about=header)


def _build_strength_fit(sliding: Any, mu0: Any, tau0: Any, *more: Any) -> StrengthFit:
    return StrengthFit(sliding, math.nan, 0, math.nan, 1.0, math.nan, mu0, tau0, *more)


@cache
def interfaces() -> dict[str, dict[str, str]]:
    """Return the published interfaces by name. Each entry is a dict with keys such as kind, mu0 and tau0.

    Returns
    -------
    entries : dict of str to dict of str to str
        Entries by name, such as kind, mu0 and tau0 with their units, conditions, motion and source.

    See Also
    --------
    interface : Single interface by its name.

    Examples
    --------
    >>> from stiction import interfaces
    >>> interfaces()["MoS2 on bearing steel, dry air"]["kind"]
    'measured'
    """
    text = (resources.files("stiction.studies") / "interfaces.toml").read_text(encoding="utf-8")
    return {str(name): table for name, table in tomllib.loads(text).items()}


def read_interface_entries(path: str | Path) -> dict[str, dict[str, str]]:
    """Read one interface file, or all interface files in a folder, and return the entries by file name.

    Other files in the folder are ignored.
    """
    entries, path = {}, Path(path)
    is_single_file = path.is_file()
    try:
        files = (
            [path] if is_single_file else sorted(folder_item for folder_item in path.iterdir() if folder_item.is_file())
        )
    except OSError as error:
        raise ValueError(f"{printable_path(path)} cannot be listed: {describe_os_error(error)}") from None
    for file in files:
        with contextlib.nullcontext() if is_single_file else contextlib.suppress(ValueError):
            interface_in_file = read_interface(file)
            (_, *mu0), (_, *tau0) = interface_in_file.strength_intervals
            entries[file.name] = {"kind": "measured", **interface_in_file.about} | {
                "mu0": f"{mu0[0]:.3g}..{mu0[1]:.3g}", "tau0": f"{1e3 * tau0[0]:.3g}..{1e3 * tau0[1]:.3g} MPa",
                "area_per_load": f"{interface_in_file.area_per_load:.3g} /GPa",
            }  # fmt: skip
    return entries


def interface(name_or_path: str | Path) -> Interface:
    """Return a published interface, or read an interface from a file written by `stiction calibrate`.

    Parameters
    ----------
    name_or_path : str or path
        Name of a published interface as in `interfaces`, or path of a file.

    Returns
    -------
    interface : Interface
        Joint distribution of mu0 and tau0 (GPa).

    Raises
    ------
    ValueError
        If no interface or file has this name.

    See Also
    --------
    interfaces : Names of the published interfaces.
    read_interface : Files only.

    Examples
    --------
    >>> from stiction import interface
    >>> interface("MoS2 on bearing steel, dry air").about["motion"]
    'kinetic'
    """
    check_instance("interface", name_or_path, (str, Path), "a name or a path")
    published_entry = interfaces().get(str(name_or_path))
    if published_entry is None:
        if Path(name_or_path).is_file():
            return read_interface(name_or_path)
        known_names = "; ".join(interfaces())
        raise ValueError(f"interface must be a file or one of {known_names}, got {str(name_or_path)!r}")
    ranges: dict[str, UncertainInput] = {
        "mu0": parse_uncertain_input("mu0", published_entry["mu0"]),
        "tau0": parse_uncertain_input("tau0", published_entry["tau0"], "pressure"),
    }
    samples = draw_input_samples(ranges)
    unknown_samples = np.full(samples["mu0"].size, math.nan)
    fit = _build_strength_fit("all", samples["mu0"], samples["tau0"], unknown_samples, unknown_samples, unknown_samples)
    description = {key: text for key, text in published_entry.items() if key not in ranges}
    return Interface((fit,), math.nan, math.nan, separated=True, about={"name": str(name_or_path), **description})


def find_interface(study: Study) -> Interface | None:
    """Return the interface of a study. Return None if no interface is given, or if its file is missing or changed."""
    interface_name = study.known.interface
    if interface_name is None:
        return None
    try:
        study_interface = _read_cached_interface(
            interface_name, 0 if interface_name in interfaces() else Path(interface_name).stat().st_mtime_ns
        )
    except (ValueError, OSError):
        return None
    mu0, tau0 = round_median_strength(study_interface)
    return (
        study_interface
        if study.friction.mu0 == (mu0,) and [float(strength) for strength in study.friction.tau0] == [tau0]
        else None
    )


@lru_cache(maxsize=8)
def _read_cached_interface(text: str, _changed: int) -> Interface:
    return interface(text)


def round_median_strength(strength: Interface) -> tuple[float, float]:
    """Return the medians of mu0 and tau0 (GPa) rounded to four digits."""
    mu0, tau0 = (float(f"{np.median(samples):.4g}") for samples in (strength.fits[0].mu0, strength.fits[0].tau0))
    return mu0, tau0
