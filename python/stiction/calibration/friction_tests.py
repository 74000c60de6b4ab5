"""Friction tests: contact forces and areas divided by the load, and the uncertainty of the true area."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from stiction._checks import Floats, validate_number
from stiction._errors import ArgumentError
from stiction._number_format import format_load
from stiction._units import is_pressure, loads_to_core_units, short_repr, to_core_units
from stiction.evaluate.contact_area import AreaFunction, build_area_functions
from stiction.evaluate.member_values import estimate_area_error, interpolate_member_sums
from stiction.mechanics.closed_forms import hertz_sphere
from stiction.mechanics.friction import LOAD_SUM_NAMES, FrictionCurve, FrictionLaw, sums_per_load
from stiction.mechanics.hardness import CENTRAL_SIZE_EFFECT_LENGTH
from stiction.mechanics.model import SlidingRule
from stiction.solve.member_sums import MemberSums
from stiction.study.elasticity import PairElasticity
from stiction.study.input_distributions import InputValue, UncertainInput, parse_input_value
from stiction.study.inputs import Inputs
from stiction.study.interfaces import SLIDING_RULES, shared_input_name
from stiction.study.moduli import UncertainModulus, find_default_area_loss, parse_elasticity
from stiction.study.study import parse_study_of_dataset

MIN_PLASTIC_AREA_RATIO, NEGLIGIBLE_GROWTH_EFFECT = 0.5, 0.05
"""Area ratio and growth effect above which a friction coefficient depends on junction growth.

The area ratio is the true area divided by the area of plastic contact. The growth effect is the relative change of the
coefficient due to junction growth. A coefficient depends on junction growth if it exceeds both limits.
"""


@dataclass(frozen=True)
class Ball:
    """Smooth elastic ball on a smooth flat.

    Its true contact area follows from Hertz's theory.

    Attributes
    ----------
    radius : float or str, µm
    effective_modulus : float or str, GPa
        E* as in "3 GPa", or a range as in "2..4.5 GPa".
    young, poisson : optional
        Young's moduli and Poisson's ratios of both bodies; ranges are accepted.
    upper_material, lower_material : str, optional
        Names of the materials of the bodies. The moduli have the ranges that `material` returns.
    area_loss : float or str, optional
        Fraction of the true area that the contact loses before it slides. By default "0..0.3" if E* is below 100 MPa.

    Examples
    --------
    >>> from stiction import Ball
    >>> round(Ball("5 mm", "3 GPa").area_per_load(100.0), 2)  # µm²/mN
    78.54
    """

    radius: float | str
    # Two balls are compared by `moduli` and `lost_fraction`, because E* and area loss can be given in several forms.
    effective_modulus: float | str | None = field(default=None, compare=False)
    young: Any = field(default=None, kw_only=True)
    poisson: Any = field(default=None, kw_only=True)
    upper_material: str | None = field(default=None, kw_only=True)
    lower_material: str | None = field(default=None, kw_only=True)
    area_loss: Any = field(default=None, kw_only=True, compare=False)
    elasticity: PairElasticity = field(init=False, repr=False, compare=False)
    moduli: UncertainModulus = field(init=False, repr=False, hash=False)
    lost_fraction: InputValue = field(init=False, repr=False)

    def __post_init__(self) -> None:
        """Convert the radius to core units, and derive the elastic constants from the arguments."""
        radius = validate_number("radius", to_core_units("radius", self.radius, "length"), unit="µm", above=0)
        object.__setattr__(self, "radius", radius)
        elasticity, moduli = parse_elasticity(
            self.effective_modulus, self.young, self.poisson, self.upper_material, self.lower_material
        )
        object.__setattr__(self, "elasticity", elasticity)
        object.__setattr__(self, "moduli", moduli)
        area_loss = self.area_loss
        if area_loss is None:
            area_loss = find_default_area_loss(elasticity.effective_modulus) or 0.0
        try:
            object.__setattr__(self, "lost_fraction", parse_input_value("area_loss", area_loss))
        except ValueError as error:
            raise ArgumentError("{area_loss} {why}", why=str(error)) from None

    def __repr__(self) -> str:
        """Return the text of a constructor call that creates an equal ball, including its uncertain arguments."""
        direct_modulus = self.moduli.effective_modulus
        arguments = {
            "radius": self.radius, "effective_modulus": None if direct_modulus is None else direct_modulus.text,
            "young": self.young, "poisson": self.poisson, "upper_material": self.upper_material,
            "lower_material": self.lower_material, "area_loss": self.lost_fraction.text,
        }  # fmt: skip
        return f"Ball({', '.join(f'{name}={value!r}' for name, value in arguments.items() if value is not None)})"

    def area_per_load(self, load: float | str) -> float:
        """Return the true area per load A/F (1/GPa) of the ball before shear, at a load (mN) and the central E*."""
        load = validate_number("load", load, unit="mN", above=0)
        radius, modulus = float(self.radius), self.elasticity.effective_modulus
        overlap = (0.75 * load / (modulus * math.sqrt(radius))) ** (2 / 3)
        force, area = hertz_sphere(overlap, radius, modulus)
        return float(area / force)


@dataclass(frozen=True)
class AreaFactor:
    """Ratio of the true contact area in a friction test to the computed area, as a function of the test's inputs.

    In this class, the factor is 1, as for exact inputs and contacts whose area does not change under shear.
    """

    # Exact and uncertain inputs of a friction test, keyed by name. The unknowns mu0 and tau0 are not inputs of a test.
    inputs: Mapping[str, UncertainInput]
    # Checksum of the surfaces of the test: tests with equal checksums have the same loss of contact area under shear.
    surfaces: str

    @cached_property
    def uncertain_inputs(self) -> dict[str, UncertainInput]:
        """Uncertain inputs of the test, keyed by name. The creep exponent is included even if it is exact."""
        return {name: value for name, value in self.inputs.items() if not value.is_exact or name == "creep"}

    def nuisance_name(self, name: str) -> str:
        """Return the name of the nuisance parameter that represents the uncertainty of the input `name`.

        Tests with equal inputs share this parameter.
        """
        return shared_input_name(name, self.uncertain_inputs[name], self.surfaces)

    @property
    def nuisance_names(self) -> list[str]:
        """Names of the nuisance parameters for all uncertain inputs."""
        return [self.nuisance_name(name) for name in self.uncertain_inputs]

    def input_values(self, columns: Mapping[Any, Floats]) -> dict[str, Floats]:
        """Return samples of the uncertain inputs, keyed by name, at given cumulative probabilities."""
        return {
            name: estimate.quantile(columns[self.nuisance_name(name)])
            for name, estimate in self.uncertain_inputs.items()
        }

    @property
    def junction_growth(self) -> UncertainInput | None:
        """Junction growth α of the test, or None if the contacts of the test are assumed not to grow."""
        return None

    def onset_area_and_friction_factors(self, samples: Mapping[str, Floats], law: FrictionLaw) -> tuple[Floats, Floats]:
        """Return two ratios at the onset of sliding: true area A / computed area, and friction / (mu0 F + tau0 A).

        `samples` are samples of the inputs. The junction growth of the test replaces that of the law. At seizure the
        area is infinite, or the nominal area if tau0 is 0.
        """
        return np.ones(()), np.ones(())


@dataclass(frozen=True, kw_only=True)
class _FrictionTestSums:
    """Contact forces and areas of one friction test, summed over its contacts and divided by the normal load.

    The normal load is the load at the same approach without friction.
    """

    sums: Mapping[str, float]
    scatter: float = 0.0
    # Tests with equal checksums of their surfaces have the same error of the computed contact area.
    surfaces: str = ""
    hardness: float = math.nan
    area_factor: AreaFactor = field(default_factory=lambda: AreaFactor({}, ""))


@dataclass(frozen=True)
class _BallAreaFactor(AreaFactor):
    """Contact area of a ball at the onset of sliding, divided by the Hertz area at the central E*.

    The contact area of a ball is proportional to E*^(-2/3).
    """

    moduli: UncertainModulus
    area_loss: float

    @classmethod
    def from_ball(cls, ball: Ball) -> _BallAreaFactor:
        """Create the area factor (ratio of true to computed contact area) for a friction test with a ball."""
        loss = ball.lost_fraction
        inputs = ball.moduli.all_inputs | {"area_loss": loss.estimate}
        return cls(inputs, f"ball {ball.radius:g}", ball.moduli, float(loss))

    def onset_area_and_friction_factors(self, samples: Mapping[str, Floats], law: FrictionLaw) -> tuple[Floats, Floats]:
        """Return two ratios at the onset of sliding: true area / Hertz area, and 1 for friction / (mu0 F + tau0 A)."""
        area = np.asarray(self.moduli.relative_modulus(samples)) ** (-2 / 3)
        return area * (1 - samples.get("area_loss", np.asarray(self.area_loss))), np.ones(())


@dataclass(frozen=True)
class _AreaFactorFromResult(AreaFactor):
    """Ratio of the true contact area in a test with rough surfaces to the area in the computed result."""

    area: AreaFunction
    load: float
    study_inputs: Inputs
    wait: float

    @classmethod
    def from_result(cls, result: Any, load: float, wait: float) -> AreaFactor:
        """Create the area factor (ratio of true to computed contact area) for a friction test on a computed pair."""
        sums = MemberSums.of(result)
        study_inputs = Inputs.from_study(sums.study)
        creep = study_inputs.estimate("creep")
        if wait != 1 and creep is None:
            raise ValueError("`wait` requires a result that was computed with the options `wait` and `creep`")
        inputs = {
            name: entry.estimate for name, entry in study_inputs.entries.items() if name not in ("mu0", "tau0", "creep")
        } | ({} if creep is None else {"creep": creep})
        unchanged = AreaFactor(inputs, sums.study.pair_checksum)
        if not unchanged.uncertain_inputs and not {"junction_growth", "area_loss"} & inputs.keys():
            return unchanged
        area = sums.compute_once(build_area_functions)[0]
        return cls(inputs, sums.study.pair_checksum, area, load, study_inputs, wait)

    @property
    def junction_growth(self) -> UncertainInput | None:
        """Junction growth α of the test, or None if the contacts of the test are assumed not to grow."""
        return self.study_inputs.estimate("junction_growth")

    def onset_area_and_friction_factors(self, samples: Mapping[str, Floats], law: FrictionLaw) -> tuple[Floats, Floats]:
        """Return two ratios at the onset of sliding: true area A / computed area, and friction / (mu0 F + tau0 A).

        `samples` are samples of the inputs. The junction growth of the test replaces that of the law. At seizure the
        area is infinite, or the nominal area if tau0 is 0.
        """
        inputs: dict[str, Any] = {
            "modulus": self.study_inputs.relative_modulus(samples),
            "yield_exponent": samples.get("yield_exponent", self.area.yield_exponent),
            "size_effect": samples.get("size_effect", CENTRAL_SIZE_EFFECT_LENGTH),
        }
        if self.area.hardness is not None:
            hardness = samples.get("hardness", np.asarray(self.area.hardness))
            inputs["hardness"] = hardness * self.wait ** -samples["creep"] if "creep" in samples else hardness
        central_area = self.area(self.load)
        if "area_loss" in self.study_inputs.entries:
            law = replace(law, area_loss=samples.get("area_loss", self.study_inputs.central("area_loss")))
            return self.area.onset(law, self.load, **inputs).area / central_area, np.ones(())
        if (estimate := self.junction_growth) is None:
            return self.area(self.load, **inputs) / central_area, np.ones(())
        growth = samples.get("junction_growth", self.study_inputs.central("junction_growth"))
        law = replace(law, junction_growth=growth, uses_slip_lines=estimate.uses_slip_lines)
        onset = self.area.onset(law, self.load, **inputs)
        area = np.where(law.tau0 > 0, onset.area, np.minimum(onset.area, self.area.nominal_area))
        return area / central_area, onset.friction_fraction


MIN_COEFFICIENT_UNCERTAINTY = 1e-15
"""Smallest accepted standard uncertainty of a measured coefficient, whose weight would otherwise overflow."""


@dataclass(frozen=True)
class FrictionTest:
    """Friction test: computed result for the pair (or a ball), load, and measured coefficient with uncertainty.

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
        Standard uncertainty of the coefficient, or of the force (mN) if the force is given. A string is a relative
        uncertainty, as in "3 %", or an uncertainty of the force, as in "20 mN", if the load is a force. By default the
        uncertainty is estimated from the scatter of the tests.
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
        """Convert load, coefficient and uncertainty of the test to numbers."""
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
                    f"specimen is unknown, got load {short_repr(self.load)} and force {short_repr(self.force)}"
                )
            force = validate_number("force", to_core_units("force", self.force, "force"), unit="mN")
            object.__setattr__(self, "coefficient", force / load)
        coefficient = validate_number("coefficient", self.coefficient, below=1e6)
        if not coefficient >= 0:
            raise ValueError(f"the measured coefficient must not be negative, got {coefficient:g}")
        object.__setattr__(self, "coefficient", coefficient)
        if self.uncertainty is not None:
            uncertainty = self._compute_coefficient_uncertainty(load)
            if not uncertainty >= MIN_COEFFICIENT_UNCERTAINTY:
                raise ValueError(
                    "uncertainty of a coefficient must be at least "
                    f"{MIN_COEFFICIENT_UNCERTAINTY:g}, got {uncertainty:g}"
                )
            object.__setattr__(self, "uncertainty", uncertainty)
        object.__setattr__(self, "load", load)

    def _compute_coefficient_uncertainty(self, load: float) -> float:
        """Convert the given uncertainty to a standard uncertainty of the friction coefficient at a load (mN)."""
        uncertainty, is_force = self.uncertainty, self.force is not None
        if isinstance(uncertainty, str) and uncertainty.strip().endswith("%"):
            try:
                percent_value = float(uncertainty.strip().removesuffix("%"))
            except ValueError:
                raise ValueError(
                    f"uncertainty must be a percentage, as in '3 %', got {short_repr(uncertainty)}"
                ) from None
            return validate_number("uncertainty", 0.01 * percent_value * float(self.coefficient or 0.0), above=0)
        if isinstance(uncertainty, str):
            if is_pressure(self.load):
                raise ValueError(
                    "uncertainty must be a number or a percentage if the load is a pressure, because the area of the "
                    f"specimen is unknown, got load {short_repr(self.load)} and uncertainty {short_repr(uncertainty)}"
                )
            uncertainty, is_force = to_core_units("uncertainty", uncertainty, "force"), True
        return validate_number("uncertainty", uncertainty, above=0) / (load if is_force else 1.0)

    @cached_property
    def area_factor(self) -> AreaFactor:
        """Ratio of the true contact area in the test to the computed area; 1 if the test refers to a load curve."""
        if isinstance(self.result, Ball):
            return _BallAreaFactor.from_ball(self.result)
        if isinstance(self.result, FrictionCurve):
            return AreaFactor({}, "")
        return _AreaFactorFromResult.from_result(self.result, float(self.load), float(self.wait))


def find_pair_hardness(result: Any) -> float:
    """Return the hardness (GPa) with which a pair was computed; NaN for elastic pairs and for a ball."""
    if isinstance(result, Ball):
        return math.nan
    if isinstance(result, FrictionCurve):
        return float(getattr(result, "hardness", None) or math.nan)
    return float(MemberSums.of(result).study.contact.hardness or math.nan)


def find_tested_hardness(tests: Sequence[FrictionTest]) -> float:
    """Return the lowest hardness (GPa) of the tested pairs or, if no pair has one, of the materials of tested balls.

    Returns NaN if neither is known.
    """
    results = [test.result for test in tests]
    pair_hardnesses = [value for value in map(find_pair_hardness, results) if not math.isnan(value)]
    ball_hardnesses = [result.elasticity.hardness for result in results if isinstance(result, Ball)]
    known_ball_hardnesses = [float(value) for value in ball_hardnesses if value is not None]
    return min(pair_hardnesses or known_ball_hardnesses, default=math.nan)


def depends_on_junction_growth(friction: _FrictionTestSums, mu0: float, tau0: float) -> bool:
    """Return whether junction growth by slip-line theory would noticeably change the coefficient of a test."""
    if not friction.sums["tangential_adhesive"] * friction.hardness > MIN_PLASTIC_AREA_RATIO:
        return False
    return abs(FrictionLaw(mu0, tau0).growth_effect(friction.hardness)) > NEGLIGIBLE_GROWTH_EFFECT


def find_pair_faults(tests: Sequence[FrictionTest], mu0: float, tau0: float) -> tuple[tuple[str, str], ...]:
    """Return the faults that forbid quoting the friction of the tested pairs at the test loads.

    `mu0` and `tau0` (GPa) are the fitted ones, because those of the studies of the pairs may be placeholders.

    Each fault has two texts: the pair with its loads, and the fault with its remedy.
    """
    faults: dict[tuple[str, str], list[str]] = {}
    results = {id(test.result): test.result for test in tests if hasattr(test.result, "summary")}
    for index, result in enumerate(results.values(), start=1):
        name = result.path.resolve().name if result.path else f"tested pair {index}"
        loads = sorted({float(test.load) for test in tests if test.result is result})
        for point in result.summary_at(loads, mu0, tau0).reported_points:
            load_text = format_load(point.at["load"], point.nominal_pressure)
            for fault in point.faults:
                load_texts = faults.setdefault((name, f"{fault.text}, so A/F may be wrong; {fault.remedy}"), [])
                load_texts += [] if load_text in load_texts else [load_text]
    return tuple((f"{name} at {', '.join(load_texts)}", text) for (name, text), load_texts in faults.items())


def list_sliding_rules(result: Any) -> tuple[str, ...]:
    """Return the sliding rules for which a result has coefficients."""
    if isinstance(result, Ball):
        return SLIDING_RULES
    if isinstance(result, FrictionCurve):
        return (str(getattr(result, "sliding", "all")),)
    return tuple(parse_study_of_dataset(getattr(result, "dataset", result)).contact.sliding_rules())


def evaluate_test_sums(test: FrictionTest, sliding: SlidingRule) -> _FrictionTestSums:
    """Return the contact forces and areas in a friction test: sums over the contacts, divided by the normal load.

    The normal load is the load at the same approach without friction.
    """
    result, load = test.result, float(test.load)
    if isinstance(result, (Ball, FrictionCurve)) and test.wait != 1:
        raise ValueError("`wait` requires a result that pair() computed with a creep exponent")
    if isinstance(result, Ball):
        sums = dict.fromkeys(LOAD_SUM_NAMES, 0.0) | {"normal_elastic": 1.0, "tangential_frictional": 1.0}
        sums["tangential_adhesive"] = result.area_per_load(load)
        return _FrictionTestSums(sums=sums, area_factor=test.area_factor)
    if isinstance(result, FrictionCurve):
        return _interpolate_sums_per_load(result, load)
    return replace(_average_sums_per_load(result, load, sliding), area_factor=test.area_factor)


def _interpolate_sums_per_load(curve: FrictionCurve, load: float) -> _FrictionTestSums:
    """Return the interpolated contact forces and areas at a load (mN), summed over contacts and divided by the load.

    The load is that at the same approach without friction.
    """
    loads = np.asarray(curve.normal_elastic)
    if not loads.min() <= load * (1 + 1e-9) or not load * (1 - 1e-9) <= loads.max():
        range_text = f"{loads.min():g} to {loads.max():g} mN"
        raise ValueError(f"load must be within the load range of the curve ({range_text}), got {load:g} mN")
    order = np.argsort(loads)

    def interpolate_sum(name: str) -> float:
        values = np.asarray(getattr(curve, name))
        values = values.reshape(-1, values.shape[-1])[0] / loads
        return float(np.interp(math.log(load), np.log(loads[order]), values[order]))

    return _FrictionTestSums(
        sums=sums_per_load({name: interpolate_sum(name) for name in LOAD_SUM_NAMES}), hardness=find_pair_hardness(curve)
    )


def _average_sums_per_load(result: Any, load: float, sliding: SlidingRule) -> _FrictionTestSums:
    """Return contact forces and areas at a load (mN), averaged over the members and divided by the load.

    The forces and areas are sums over the contacts of a member. The load is that at the same approach without friction.
    """
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
        raise ValueError(f"load must be within the load range of the result, got {load:g} mN{hint}")
    adhesive_sums = contact_sums["tangential_adhesive"][is_reached]
    means = {name: values[is_reached].mean() for name, values in contact_sums.items()}
    study = MemberSums.of(result).study
    return _FrictionTestSums(
        sums=sums_per_load(means),
        scatter=estimate_area_error(adhesive_sums),
        surfaces=study.pair_checksum,
        hardness=find_pair_hardness(result),
    )
