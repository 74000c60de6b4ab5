"""mu0 and tau0 from friction that was measured on surfaces that were scanned.

A test gives a coefficient y at a load. The surfaces give, at that load, the sums of which both forces are made, so that
y (F_N0 + mu0 F_Nm + tau0 F_Na) = F_T0 + mu0 F_Tm + tau0 F_Ta: a straight line in (mu0, tau0). Where contacts rub on
gentle slopes it is y = mu0 + tau0 A/F, and both are told apart only as far as A/F varies among the tests.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stiction._checks import Floats, choice, number
from stiction._units import in_core_units, loads_in_core_units
from stiction.mechanics.closed_forms import hertz_sphere
from stiction.mechanics.friction import SIX, Curve
from stiction.mechanics.model import Sliding
from stiction.studies.hardness import Areas
from stiction.studies.known import Known, creep_of, inputs_of, relative_modulus, sobol
from stiction.studies.member_values import PerLoad, member_values, six_at
from stiction.studies.study import Study, study_of

if TYPE_CHECKING:
    import pandas

LEAST_VARIATION = 0.1  # standard deviation over mean of A/F among tests below which mu0 and tau0 are not told apart
NUISANCES = 128  # points of a Sobol sequence over gain of the force cell, areas of the surfaces, and hardness
STRENGTHS, COEFFICIENTS = 161, 97  # points of the grids of tau0, and of mu0 at each of these
DRAWS = 4000  # pairs of mu0 and tau0 that stand for their joint distribution
TAIL = 1e-7  # density over its maximum, below which the grid of tau0 ends
WIDE = 8.0  # half-width of the grid of mu0, standard deviations
LEAST_TESTS = 3  # tests that slid from whose scatter errors are found

EXCLUDED, UNLIKELY = 0.01, 0.05
"""Probabilities of residuals as large: a rule is excluded by the first, errors are scaled by the second."""

FREEDOM = 4.0  # degrees of freedom of Student's t for tests among which there may be outliers
AT_BOUND = 0.01  # distance of a lower end from its bound, in widths of the interval, up to which it is the bound
COVERAGE = 0.95  # probability of intervals
RULES: tuple[Sliding, ...] = ("all", "opposing")

HARDNESS = "hardness of the draws"
"""Line of `Interface.about` with the range that all tests had, whose values the draws keep."""

Interval = tuple[float, float, float]  # a value with the ends of its 95 % interval
_CENTRED = np.linspace(0.0, 1.0, COEFFICIENTS)  # where points of mu0 stand between the ends of their grid


@dataclass(frozen=True)
class Ball:
    """A smooth ball on a smooth flat below yield, whose true contact is Hertz's.

    Attributes
    ----------
    radius : float or str, µm
    effective_modulus : float or str, GPa

    Examples
    --------
    >>> from stiction import Ball
    >>> round(Ball("5 mm", "3 GPa").area_per_load(100.0), 2)  # µm²/mN
    78.54
    """

    radius: float | str
    effective_modulus: float | str

    def __post_init__(self) -> None:
        """Numbers in core units."""
        for name, kind, unit in (("radius", "length", "µm"), ("effective_modulus", "pressure", "GPa")):
            value = number(name, in_core_units(name, getattr(self, name), kind), unit=unit, above=0)
            object.__setattr__(self, name, value)

    def area_per_load(self, load: float) -> float:
        """A/F (1/GPa) at a load (mN)."""
        radius, modulus = float(self.radius), float(self.effective_modulus)
        overlap = (0.75 * load / (modulus * math.sqrt(radius))) ** (2 / 3)
        force, area = hertz_sphere(overlap, radius, modulus)
        return float(area / force)


@dataclass(frozen=True, kw_only=True)
class _Friction(PerLoad):
    """What the surfaces of a test do at its load."""

    scatter: float = 0.0  # relative standard error of `stick`
    hardness: float = math.nan
    yields: _Yields | None = None

    def area(self, columns: Mapping[str, Floats]) -> Any:
        """True area over the computed one, of probabilities of what is known of hardness, creep and moduli."""
        return 1.0 if self.yields is None else self.yields.area(columns)


@dataclass(frozen=True)
class _Yields:
    """How the true area of a result at a load goes with what is not known of its bodies."""

    areas: Areas
    study: Study
    known: Mapping[str, Known]  # hardness, creep and moduli that are ranges
    wait: float

    @classmethod
    def of(cls, result: Any, load: float, wait: float) -> _Yields | None:
        """Those of a result of measured bodies by the half-space; None of others, and where nothing varies."""
        source = getattr(result, "source", result)
        study = study_of(getattr(result, "dataset", result))
        known = {name: each.known for name, each in inputs_of(study).items() if name not in ("mu0", "tau0")}
        fall = creep_of(study)
        if wait != 1 and fall is None:
            raise ValueError("wait needs a pair that was pressed with wait and creep")
        if not known and fall is None:
            return None
        members = member_values(source, [load], mu0=[0.0], tau0=[0.0])
        at = members[["contact_area", "rms_gradient"]].mean("repetition").expand_dims(statistic=["mean"])
        return cls(Areas.of(at, study, source), study, known | ({} if fall is None else {"creep": fall}), wait)

    def key(self, name: str) -> str:
        """Name of a nuisance: what two results know alike is one."""
        return f"{name} {self.known[name].text}"

    def area(self, columns: Mapping[str, Floats]) -> Floats:
        """As `_Friction.area`, of probabilities by `key`."""
        return self.area_of({name: each.quantile(columns[self.key(name)]) for name, each in self.known.items()})

    def area_of(self, drawn: Mapping[str, Floats]) -> Floats:
        """The same of values of what is known."""
        hardness = drawn.get("hardness", np.asarray(self.areas.hardness or math.nan))
        hardness = hardness * self.wait ** -drawn["creep"] if "creep" in drawn else hardness
        modulus = relative_modulus(self.study, drawn)
        return self.areas.factor(0, None if self.areas.hardness is None else hardness, modulus)


@dataclass(frozen=True)
class FrictionTest:
    """One friction test: what was pressed, under which load, and what was measured.

    Attributes
    ----------
    result : Result, HalfSpaceCurve, LoadCurve or Ball
        What the surfaces of the test do under load; several tests on the same surfaces share it.
    load : float or str, mN
        "10 mN", or per nominal area "10 MPa" where the result has one.
    coefficient : float, optional
    force : float or str, mN, optional
        Tangential force at which it slid, in place of the coefficient. The first peak is the static one.
    uncertainty : float, optional
        Standard uncertainty of the coefficient, or of the force where that is given. None: it is found from the scatter
        of all tests.
    slid : bool
        Whether it slid; if it held, the coefficient is a lower bound.
    run : str or int, optional
        Specimen or series; tests of one run share an unknown offset.
    wait : float or str, s
        Time under load before it was sheared, of a result that was pressed with waiting and creep.

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
    uncertainty: float | None = None
    slid: bool = True
    run: str | int | None = None
    wait: float | str = 1.0

    def __post_init__(self) -> None:
        """Load and coefficient as numbers."""
        area = getattr(self.result, "nominal_area", None)
        given = (
            in_core_units("load", self.load, "force") if area is None else loads_in_core_units("load", self.load, area)
        )
        load = number("load", given, unit="mN", above=0)
        object.__setattr__(self, "wait", number("wait", in_core_units("wait", self.wait, "time"), unit="s", above=0))
        if (self.coefficient is None) == (self.force is None):
            raise ValueError("one of coefficient and force is needed")
        scale = 1.0
        if self.force is not None:
            scale = load
            force = number("force", in_core_units("force", self.force, "force"), unit="mN")
            object.__setattr__(self, "coefficient", force / load)
        found = number("coefficient", self.coefficient)
        if not found >= 0:
            raise ValueError(f"the measured coefficient must not be negative, got {found:g}")
        object.__setattr__(self, "coefficient", found)
        object.__setattr__(self, "load", load)
        if self.uncertainty is not None:
            of_force = isinstance(self.uncertainty, str)
            error = in_core_units("uncertainty", self.uncertainty, "force") if of_force else self.uncertainty
            object.__setattr__(self, "uncertainty", number("uncertainty", error, above=0) / scale)

    @cached_property
    def yields(self) -> _Yields | None:
        """How the true area goes with what is not known of the bodies, of a result of `pair`."""
        return _Yields.of(self.result, float(self.load), float(self.wait))


@dataclass(frozen=True)
class Fit:
    """What the tests say by one sliding rule."""

    sliding: Sliding
    chi_squared: float  # of the most likely mu0 and tau0, with the errors that were given
    freedom: int  # tests that slid less what was fitted
    probability: float  # of residuals as large or larger; NaN without errors or freedom
    scale: float  # by which errors were multiplied because residuals are larger than they allow
    trend: float  # probability that residuals vary as much with the load by chance: small where the law does not fit
    mu0: Floats  # draws
    tau0: Floats  # of the same draws, GPa
    hardness: Floats  # of the same draws, GPa; NaN where there is none, or another in other tests


@dataclass(frozen=True)
class Interface:
    """The strength of an interface as tests know it: mu0 and tau0 jointly.

    Attributes
    ----------
    fits : tuple of Fit
        By each sliding rule that was asked for, the one that is used first.
    area_per_load : float, 1/GPa
        A/F of the tests, at which mu0 + tau0 A/F is identified.
    variation : float
        Standard deviation over mean of A/F among the tests.
    separated : bool
        Whether both are known, and not only mu0 + tau0 A/F.
    advice : tuple of (str, float, float)
        Tests that would tell them apart: what, and the expected standard errors of mu0 and tau0 (GPa) after as many
        tests as there are.
    tests : tuple of (float, float, float, bool)
        A/F (1/GPa), coefficient, its standard uncertainty (NaN where none was given) and whether it slid, of each test.
    about : mapping of str to str
        Kind ("measured", "lumped" or "bound"), materials, conditions, source: what a reader must know.

    Examples
    --------
    >>> from stiction import interface
    >>> strength = interface("MoS2 on bearing steel, dry air")
    >>> strength.separated, round(strength.tau0[0], 4)
    (True, 0.0248)
    """

    fits: tuple[Fit, ...]
    area_per_load: float
    variation: float
    separated: bool
    advice: tuple[tuple[str, float, float], ...] = ()
    tests: tuple[tuple[float, float, float, bool], ...] = ()
    about: Mapping[str, str] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Show what is identified, and mu0 and tau0 where they are separated."""
        known = [("mu0 + tau0 A/F", self.identified, "")]
        if self.separated:
            known += [("mu0", self.mu0, ""), ("tau0", self.tau0, " GPa")]
        rows = [
            f"  {name:<14}  {value:.4g} [{low:.4g}, {high:.4g}]{unit}"
            for name, (value, low, high), unit in known
            if math.isfinite(value)
        ]
        return "\n".join(["Interface", *rows, *(f"  {key:<14}  {text}" for key, text in self.about.items())])

    @property
    def identified(self) -> Interval:
        """mu0 + tau0 A/F at the A/F of the tests, and its 95 % interval."""
        return highest_density(self.fits[0].mu0 + self.fits[0].tau0 * self.area_per_load, 0.0)

    @property
    def mu0(self) -> Interval:
        """Molecular friction coefficient and its interval; NaN where the two are not separated."""
        return highest_density(self.fits[0].mu0, 0.0) if self.separated else (math.nan,) * 3

    @property
    def tau0(self) -> Interval:
        """Adhesive shear strength (GPa) and its interval; NaN where the two are not separated."""
        return highest_density(self.fits[0].tau0, 0.0) if self.separated else (math.nan,) * 3

    @property
    def excluded(self) -> tuple[Sliding, ...]:
        """Sliding rules that the tests exclude, while another one fits them."""
        likely = [fit.sliding for fit in self.fits if fit.probability > UNLIKELY]
        return tuple(fit.sliding for fit in self.fits if fit.probability < EXCLUDED and likely)

    @cached_property
    def draws(self) -> pandas.DataFrame:
        """The joint distribution, a row a draw: mu0, tau0 (GPa) and hardness (GPa, NaN without one of all tests)."""
        import pandas

        fit = self.fits[0]
        return pandas.DataFrame({"mu0": fit.mu0, "tau0": fit.tau0, "hardness": fit.hardness})

    def predict(self, result: Any, load: float | str) -> Interval:
        """mu_s of other surfaces at a load, with its 95 % interval.

        Parameters
        ----------
        result : Result, HalfSpaceCurve, LoadCurve or Ball
        load : float or str, mN

        Returns
        -------
        (float, float, float)
            Value, lower and upper end: of mu0 and tau0 jointly, and of the area of the surfaces over their positions.
        """
        fit, random = self.fits[0], np.random.default_rng(1)
        found = _friction_of(FrictionTest(result, load, coefficient=0.0), fit.sliding)
        area = np.exp(found.scatter * random.standard_normal(len(fit.mu0)))
        if (own := found.yields) is not None:
            drawn = {name: each.quantile(random.random(len(fit.mu0))) for name, each in own.known.items()}
            if "hardness" in drawn and own.known["hardness"].says(self.about.get(HARDNESS, "")):
                drawn["hardness"] = fit.hardness  # what is common to tests and prediction is drawn once
            area = area * own.area_of(drawn)
        return highest_density(found.coefficient(fit.mu0, fit.tau0, area), 0.0)


def calibrate(
    tests: Sequence[FrictionTest],
    *,
    common: float = 0.02,
    sliding: Sliding | Literal["both"] = "both",
    mu0: float | None = None,
    tau0: float | str | None = None,
    outliers: bool = False,
) -> Interface:
    """The strength of an interface, mu0 and tau0 jointly, from friction tests on surfaces that were scanned.

    Parameters
    ----------
    tests : sequence of FrictionTest
    common : float
        Relative standard uncertainty that all tests share: of the force cell, of the load.
    sliding : {"both", "all", "opposing"}
        By which rule; of both, "all" is used unless the tests exclude it and not the other one.
    mu0, tau0 : float, tau0 in GPa or as text
        Where one of them is known.
    outliers : bool
        Whether there may be outliers among the tests: errors by Student's t in place of the normal distribution.

    Returns
    -------
    Interface

    Raises
    ------
    ValueError
        If there are no tests that slid, or an argument is outside its range.

    Notes
    -----
    Given gain, areas and hardness the data are linear in mu0 and tau0. The density is computed on a grid of tau0, and
    at each of its points of mu0, which is exact however alike the tests are; both are at least 0, and all values of
    mu0 and of tau0 A/F are as likely beforehand. Gain and areas have normal distributions of their own, over which
    the densities are summed. Where residuals are larger than the errors allow, the errors are taken as known up to a
    factor.

    Examples
    --------
    >>> from stiction import Ball, FrictionTest, calibrate
    >>> ball = Ball("5 mm", "3 GPa")
    >>> loads = [5.0, 20.0, 100.0, 500.0, 2000.0]
    >>> tests = [
    ...     FrictionTest(ball, load, coefficient=0.15 + 0.012 * ball.area_per_load(load), uncertainty=0.01)
    ...     for load in loads
    ... ]
    >>> interface = calibrate(tests)
    >>> interface.separated, round(interface.tau0[0], 3)
    (True, 0.012)
    """
    choice("sliding", sliding, Literal["both", "all", "opposing"])
    tests = tuple(tests)
    if not all(isinstance(test, FrictionTest) for test in tests):
        raise ValueError("tests must be a sequence of FrictionTest")
    if not any(test.slid for test in tests):
        raise ValueError("tests must have one that slid: those that held are lower bounds alone")
    if not 0 <= number("common", common) < 1:
        raise ValueError(f"common must be at least 0 and below 1, got {common!r}")
    held = {test.uncertainty is None for test in tests}
    if len(held) > 1:
        raise ValueError("uncertainty must be given of all tests, or of none")
    if True in held and sum(test.slid for test in tests) < LEAST_TESTS:
        raise ValueError(f"uncertainty is needed of fewer than {LEAST_TESTS} tests: their scatter says too little")
    known = tuple(
        None if value is None else number(name, in_core_units(name, value, "pressure") if name == "tau0" else value)
        for name, value in (("mu0", mu0), ("tau0", tau0))
    )
    if any(value is not None and value < 0 for value in known):
        raise ValueError("mu0 and tau0 must not be negative")
    there = [rule for rule in RULES if all(rule in _rules_of(test.result) for test in tests)]
    if all(isinstance(test.result, Ball) for test in tests) and sliding == "both":
        there = there[:1]  # both rules are one
    rules = there if sliding == "both" else [sliding]
    if not rules or not set(rules) <= set(there):
        raise ValueError(
            f"sliding must be a rule that all results have ({', '.join(there) or 'none'}), got {sliding!r}"
        )
    problems = [_Problem.of(tests, rule, common, known, outliers=outliers) for rule in rules]
    fits = [problem.fit() for problem in problems]
    if len(fits) == 2 and fits[0].probability < EXCLUDED and fits[1].probability > UNLIKELY:
        fits, problems = fits[::-1], problems[::-1]
    first = problems[0]
    separated = any(value is not None for value in known) or (len(tests) > 2 and first.variation >= LEAST_VARIATION)
    points = [
        (float(ratio), float(test.coefficient or 0.0), float(test.uncertainty or math.nan), test.slid)
        for ratio, test in zip(first.ratio, tests, strict=True)
    ]
    advice = () if separated else first.advice()
    about = {"kind": "measured"} | ({HARDNESS: first.shared} if first.shared else {})
    return Interface(tuple(fits), first.pivot, first.variation, separated, advice, tuple(points), about)


def highest_density(values: Floats, bound: float = -math.inf) -> Interval:
    """Median of draws and the shortest interval that holds 95 % of them; a lower end beside the bound is the bound."""
    ordered = np.sort(values)
    inside = math.ceil(COVERAGE * len(ordered)) - 1
    start = int((ordered[inside:] - ordered[: len(ordered) - inside]).argmin())
    low, high = float(ordered[start]), float(ordered[start + inside])
    if low - bound < AT_BOUND * (high - low):
        low, high = bound, float(ordered[inside])
    return float(np.median(ordered)), low, high


def _rules_of(result: Any) -> tuple[str, ...]:
    """Sliding rules of which a result has sums."""
    if isinstance(result, Ball):  # on which all rubs
        return RULES
    if isinstance(result, Curve):
        return (str(getattr(result, "sliding", "all")),)
    return tuple(study_of(getattr(result, "dataset", result)).contact.rules())


def _friction_of(test: FrictionTest, sliding: Sliding) -> _Friction:
    """What the surfaces of a test do at its load, by a sliding rule."""
    result, load = test.result, float(test.load)
    if isinstance(result, (Ball, Curve)) and test.wait != 1:
        raise ValueError("wait needs a result of pair, which knows the creep")
    if isinstance(result, Ball):
        return _Friction(stick=result.area_per_load(load))
    if isinstance(result, Curve):
        return _of_curve(result, load)
    return replace(_of_members(result, load, sliding), yields=test.yields)


def _of_curve(curve: Curve, load: float) -> _Friction:
    """A curve has one rule, its own, and one direction, the first."""
    loads = np.asarray(curve.normal_elastic)
    if not loads.min() <= load * (1 + 1e-9) or not load * (1 - 1e-9) <= loads.max():
        raise ValueError(
            f"load must be one that the curve reaches, {loads.min():g} to {loads.max():g} mN, got {load:g}"
        )
    order = np.argsort(loads)

    def at(name: str) -> float:
        values = np.asarray(getattr(curve, name))
        values = values.reshape(-1, values.shape[-1])[0] / loads
        return float(np.interp(math.log(load), np.log(loads[order]), values[order]))

    return _Friction.of({name: at(name) for name in SIX}, hardness=float(getattr(curve, "hardness", None) or math.nan))


def _of_members(result: Any, load: float, sliding: Sliding) -> _Friction:
    """Means of a result over members and directions, and the scatter of the adhesive sum over members."""
    dataset = getattr(result, "dataset", result)
    there = six_at(dataset, np.array([load])).sel(sliding=sliding).isel(cut_off=0, load=0, missing_dims="ignore")
    six = {str(name): each.mean("direction").values.reshape(-1) for name, each in there.data_vars.items()}
    reached = np.isfinite(list(six.values())).all(axis=0)
    if not reached.any():
        raise ValueError(f"load must be one that the result reaches, got {load:g} mN")
    stick = six["tangential_adhesive"][reached]
    spread = float(stick.std(ddof=1) / stick.mean() / math.sqrt(len(stick))) if len(stick) > 1 else 0.0
    means = {name: each[reached].mean() for name, each in six.items()}
    return _Friction.of(means, scatter=spread, hardness=float(study_of(dataset).contact.hardness or math.nan))


@dataclass(frozen=True, eq=False)
class _Problem:
    """Equations rub mu0 + stick tau0 = right of all tests, (nuisances, tests) each, and their errors."""

    sliding: Sliding
    rub: Floats
    stick: Floats
    right: Floats
    error: Floats  # (tests,)
    slid: Any  # (tests,) of bool
    load: Floats
    ratio: Floats  # (tests,) A/F, 1/GPa
    hardness: Floats  # (nuisances,)
    shared: str  # what is known of it, where that is a range of all tests
    known: tuple[float | None, float | None]
    outliers: bool
    has_errors: bool

    @classmethod
    def of(
        cls, tests: Sequence[FrictionTest], sliding: Sliding, common: float, known: Any, *, outliers: bool
    ) -> _Problem:
        """From tests, with gain and areas drawn from what is known of them."""
        from scipy.special import ndtri

        friction = [_friction_of(test, sliding) for test in tests]
        bodies = list({id(test.result): None for test in tests})
        places = np.array([bodies.index(id(test.result)) for test in tests])
        scatter = np.zeros(len(bodies))
        for place, found in zip(places, friction, strict=True):
            scatter[place] = max(scatter[place], found.scatter)
        yields = [found.yields for found in friction if found.yields is not None]
        keys = list(dict.fromkeys(each.key(name) for each in yields for name in each.known))
        points = sobol(1 + len(bodies) + len(keys), NUISANCES).copy()
        points[0] = 0.5  # the middle, by which fits are judged
        scores, columns = ndtri(points), dict(zip(keys, points.T[1 + len(bodies) :], strict=True))
        gain = np.exp(common * scores[:, :1])
        area = np.exp(scatter[places] * scores[:, 1:][:, places])
        area = area * np.stack([np.broadcast_to(each.area(columns), NUISANCES) for each in friction], axis=1)
        measured = np.array([float(test.coefficient or 0.0) for test in tests]) / gain

        def of_all(name: str) -> Floats:
            return np.array([getattr(found, name) for found in friction])

        hardness = np.full(
            NUISANCES, friction[0].hardness if len({each.hardness for each in friction}) == 1 else math.nan
        )
        # What knows the hardness, where all tests are of bodies of one that is not known exactly.
        ranges = {each.yields and "hardness" in each.yields.known and each.yields.key("hardness") for each in friction}
        shared = friction[0].yields if len(ranges) == 1 and all(ranges) else None
        if shared is not None:
            hardness = shared.known["hardness"].quantile(columns[shared.key("hardness")])
        has_errors = tests[0].uncertainty is not None
        error = np.array([test.uncertainty if has_errors else 1.0 for test in tests], float)
        if not has_errors:  # all of one relative error
            error = np.maximum(measured[0], 1e-6 * measured[0].max())
        problem = cls(
            sliding=sliding,
            rub=of_all("rub") - measured * of_all("rub_normal"),
            stick=(of_all("stick") - measured * of_all("stick_normal")) * area,
            right=measured - of_all("elastic"),
            error=error,
            slid=np.array([test.slid for test in tests]),
            load=np.array([float(test.load) for test in tests]),
            ratio=of_all("stick") / of_all("rub") * area[0],
            hardness=hardness,
            shared="" if shared is None else shared.known["hardness"].text,
            known=known,
            outliers=outliers,
            has_errors=has_errors,
        )
        return problem._without_runs([test.run for test in tests])

    def _without_runs(self, runs: list[Any]) -> _Problem:
        """Equations whose errors are independent, where tests of one run share an offset of unknown size."""
        names = [run for run in dict.fromkeys(runs) if run is not None and runs.count(run) > 1]
        if len(names) < 2:
            return self
        member = np.array([[run == name for run in runs] for name in names], float)
        counts = member.sum(axis=1)
        residual = self._residual_of_best()
        means = member @ residual / counts
        within = float(
            ((residual - means @ member) ** 2 * member.any(axis=0)).sum() / max(1, counts.sum() - len(names))
        )
        between = max(0.0, float(means.var(ddof=1)) - within * float((1 / counts).mean()))
        part = 1 - np.sqrt(within / (within + counts * between)) if within > 0 else np.ones(len(names))
        take = np.eye(len(runs)) - (member.T * (part / counts)) @ member

        def apart(values: Floats) -> Floats:
            return np.asarray((values / self.error) @ take.T * self.error)

        return replace(self, rub=apart(self.rub), stick=apart(self.stick), right=apart(self.right))

    @cached_property
    def _weight(self) -> Floats:
        return np.where(self.slid, 1.0 / self.error**2, 0.0)

    @property
    def pivot(self) -> float:
        """A/F of the tests, 1/GPa, each with its weight."""
        return float(np.average(self.ratio, weights=self._weight))

    @property
    def variation(self) -> float:
        """Standard deviation over mean of A/F."""
        return float(np.sqrt(np.average((self.ratio - self.pivot) ** 2, weights=self._weight)) / self.pivot)

    def _best(self) -> tuple[float, float]:
        """The most likely mu0 and tau0, at least 0, without outliers, at the middle of gain and areas."""
        from scipy.optimize import lsq_linear

        weight = np.sqrt(self._weight)
        columns = np.stack([self.rub[0], self.stick[0]], axis=1)
        free = [value is None for value in self.known]
        values = np.array([0.0 if value is None else value for value in self.known])
        if any(free):
            right = self.right[0] - columns @ values
            scale = np.abs(columns[:, free]).max(axis=0)
            values[free] = (
                lsq_linear(columns[:, free] / scale * weight[:, None], right * weight, (0.0, np.inf)).x / scale
            )
        return float(values[0]), float(values[1])

    def _residual_of_best(self) -> Floats:
        mu0, tau0 = self._best()
        return np.asarray((self.right[0] - self.rub[0] * mu0 - self.stick[0] * tau0) / self.error)

    def fit(self) -> Fit:
        """The joint distribution of mu0 and tau0, and how well the tests fit."""
        from scipy.stats import chi2, linregress

        residual = self._residual_of_best()[self.slid]
        chi_squared = float((residual**2).sum())
        slid = int(self.slid.sum())
        # Where A/F is the same in all tests, one combination is what was fitted.
        fitted = min(sum(value is None for value in self.known), 1 if self.variation < LEAST_VARIATION else 2)
        freedom = max(0, slid - fitted)
        probability = float(chi2.sf(chi_squared, freedom)) if self.has_errors and freedom else math.nan
        is_scaled = freedom > 0 and (not self.has_errors or (probability < UNLIKELY and not self.outliers))
        scale = math.sqrt(chi_squared / freedom) if is_scaled else 1.0
        loads = np.log(self.load[self.slid])
        trend = float(linregress(loads, residual).pvalue) if residual.size > 2 and np.ptp(loads) > 0 else math.nan
        mu0, tau0, hardness = self._drawn(scale, freedom if is_scaled else None)
        scale = scale if self.has_errors else 1.0
        return Fit(self.sliding, chi_squared, freedom, probability, scale, trend, mu0, tau0, hardness)

    # ---- Density ----------------------------------------------------------------------------------------------------

    @cached_property
    def _rows(self) -> Floats:
        """(nuisances, at most 3, 3) rows of rub, stick and right side over errors, of tests that slid."""
        columns = (self.rub, self.stick, self.right)
        rows = np.stack([np.broadcast_to(each, self.right.shape) / self.error for each in columns], axis=-1)
        rows = rows[:, self.slid]
        return rows if self.outliers else np.asarray(np.linalg.qr(rows, mode="r"))

    def _log_density(self, mu0: Floats, tau0: Floats, nuisance: int, scale: float, freedom: int | None) -> Floats:
        """Logarithm of the density (...) of the data; with a freedom, of errors that are known up to a factor."""
        from scipy.special import log_ndtr

        slid = self._rows[nuisance] @ np.array([[-1.0, 0, 0], [0, -1, 0], [0, 0, 1]])
        squares = [(row[2] + row[0] * mu0 + row[1] * tau0) ** 2 for row in slid]
        if self.outliers:
            found = sum(-0.5 * (FREEDOM + 1) * np.log1p(each / (scale**2 * FREEDOM)) for each in squares)
        elif freedom is None:
            found = -0.5 * sum(squares)
        else:
            found = -0.5 * np.count_nonzero(self.slid) * np.log(sum(squares) + 1e-300)
        for test in np.flatnonzero(~self.slid):
            predicted = self.rub[nuisance, test] * mu0 + self.stick[nuisance, test] * tau0
            found = found + log_ndtr((predicted - self.right[nuisance, test]) / (scale * self.error[test]))
        return np.asarray(found)

    def _coefficients(self, tau0: Floats, nuisance: int, scale: float) -> Floats:
        """(tau0, COEFFICIENTS) grid of mu0: around the best one at each tau0, at least 0."""
        if self.known[0] is not None:
            return np.full((tau0.size, 1), self.known[0])
        weight = self._weight
        curvature = float((weight * self.rub[nuisance] ** 2).sum())
        right = self.right[nuisance] - self.stick[nuisance] * tau0[:, np.newaxis]
        best = (weight * self.rub[nuisance] * right).sum(axis=-1) / curvature
        half = WIDE * max(scale, 1.0) / math.sqrt(curvature)
        # Errors that are found from few tests have long tails.
        half *= (
            1.0 + 12.0 / max(1, int(self.slid.sum()) - 1) if not self.has_errors or scale > 1 or self.outliers else 1
        )
        if not self.slid.all():
            half *= 2.0
        low = np.maximum(best - half, 0.0)
        high = np.maximum(best + half, low + half)
        return np.asarray(low[:, np.newaxis] + (high - low)[:, np.newaxis] * _CENTRED[np.newaxis])

    def _on_grid(self, tau0: Floats, nuisance: int, scale: float, freedom: int | None) -> tuple[Floats, Floats]:
        """Grid of mu0 and logarithm of the probability of each of its cells, (tau0, mu0) each."""
        mu0 = self._coefficients(tau0, nuisance, scale)
        density = self._log_density(mu0, np.broadcast_to(tau0[:, np.newaxis], mu0.shape), nuisance, scale, freedom)
        if mu0.shape[1] > 1:
            density = density + np.log(np.gradient(mu0, axis=1))
        return mu0, density

    def _strengths(self, scale: float, freedom: int | None) -> Floats:
        """Grid of tau0 (GPa) that closes in on where the density is."""
        if self.known[1] is not None:
            return np.array([self.known[1]])
        top = float(np.max(np.abs(self.right[0]) + 20 * self.error * scale) / np.min(np.abs(self.stick[0])))
        low, high = 0.0, 2.0 * top
        for _ in range(6):
            grid = np.linspace(low, high, STRENGTHS)
            density = self._on_grid(grid, 0, scale, freedom)[1]
            marginal = np.logaddexp.reduce(density, axis=1)
            there = np.flatnonzero(marginal > marginal.max() + math.log(TAIL))
            step = grid[1] - grid[0]
            new = max(0.0, grid[there[0]] - step), grid[there[-1]] + step
            if new[1] - new[0] > 0.8 * (high - low):
                break
            low, high = new
        # Room for gains and areas that are not in the middle.
        spare = 0.15 * (high - low) + 0.1 * high
        return np.linspace(max(0.0, low - spare), high + spare, STRENGTHS)

    def _drawn(self, scale: float, freedom: int | None) -> tuple[Floats, Floats, Floats]:
        """Draws of mu0, tau0 and hardness from their joint density."""
        grid = self._strengths(scale, freedom)
        cells = [self._on_grid(grid, nuisance, scale, freedom) for nuisance in range(NUISANCES)]
        top = max(float(density.max()) for _, density in cells)
        # All values of tau0 A/F are as likely beforehand, so that a larger area is no more likely than a smaller one.
        area = np.abs(self.stick).mean(axis=1)
        weights = [np.exp(density - top) * each for (_, density), each in zip(cells, area / area[0], strict=True)]
        total = np.cumsum([float(weight.sum()) for weight in weights])
        random = np.random.default_rng(0)
        # Systematic: each nuisance has its share of the draws, and so have the cells within.
        wanted = (np.arange(DRAWS) + random.random()) / DRAWS * total[-1]
        counts = np.bincount(np.searchsorted(total, wanted), minlength=NUISANCES)
        mu0, tau0, hardness = [], [], []
        step = grid[1] - grid[0] if grid.size > 1 else 0.0
        for nuisance, count in enumerate(counts):
            if not count:
                continue
            values, weight = cells[nuisance][0], np.cumsum(weights[nuisance])
            place = np.searchsorted(weight, (np.arange(count) + random.random()) / count * weight[-1])
            row, column = np.divmod(np.minimum(place, weight.size - 1), values.shape[1])
            strength = np.maximum(grid[row] + step * (random.random(count) - 0.5), 0.0)
            width = np.gradient(values, axis=1)[row, column] if values.shape[1] > 1 else 0.0
            # A move along tau0 within a cell is one along the line on which the tests agree.
            moved = (grid[row] - strength) * self.pivot if self.known[0] is None else 0.0
            mu0.append(np.maximum(values[row, column] + width * (random.random(count) - 0.5) + moved, 0.0))
            tau0.append(strength)
            hardness.append(np.full(count, self.hardness[nuisance]))
        order = random.permutation(DRAWS)
        return tuple(np.concatenate(each)[order] for each in (mu0, tau0, hardness))  # type: ignore[return-value]

    # ---- Advice -----------------------------------------------------------------------------------------------------

    def advice(self) -> tuple[tuple[str, float, float], ...]:
        """What would tell mu0 and tau0 apart, with the standard errors that are expected."""
        mu0, tau0 = self._best()
        predicted = self.rub[0] * mu0 + self.stick[0] * tau0
        relative = float(np.median(self.error / np.maximum(predicted, 1e-12))) if self.has_errors else 0.05
        ratio, count = self.pivot, len(self.error)
        plans = (
            ("a smooth ball below yield, two decades of load", ratio * np.geomspace(0.3, 3, count)),
            ("as many tests on a second finish, elastic, three times as rough", np.full(count, ratio / 3)),
            ("as many tests with the same film on a body twice as hard", np.full(count, ratio / 2)),
        )
        found = []
        for words, more in plans:
            ratios = np.concatenate([np.full(count, ratio), more])
            errors = relative * np.maximum(mu0 + tau0 * ratios, 1e-12)
            matrix = np.stack([1 / errors, ratios / errors], axis=1)
            covariance = np.linalg.inv(matrix.T @ matrix)
            found.append((words, math.sqrt(covariance[0, 0]), math.sqrt(covariance[1, 1])))
        return tuple(found)
