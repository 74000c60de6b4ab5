"""Calibration of mu0 and tau0 as text, JSON and figure."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats, check_instance
from stiction._estimate import Estimate
from stiction._number_format import format_load, format_percent, format_with_unit
from stiction._repr import render_png
from stiction.calibration.friction_tests import find_pair_hardness
from stiction.calibration.planning import PlanConditions, PlannedTests, find_plan_conditions, plan_tests
from stiction.calibration.prediction import Interface
from stiction.mechanics.hardness import BALL_YIELD_PRESSURE_RATIO
from stiction.study.inputs import Inputs
from stiction.study.interfaces import (
    ERROR_SCALING_P_VALUE_LIMIT,
    EXCLUSION_P_VALUE_LIMIT,
    MIN_AREA_VARIATION,
    StrengthFit,
    ValueWithLimits,
    find_tail_probabilities,
)
from stiction.summary.interface_caveats import find_range_caveats
from stiction.views.json_record import record_json
from stiction.views.layout import format_table, wrap_text
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
from stiction.views.sentence import junction_growth_text, lay_assumption, possible_zeros_text
from stiction.views.style import ALL_CONTACTS_COLOUR, FORCE_COLOUR, MATPLOTLIB_STYLE, PAGE_WIDTH, new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from stiction.summary.evaluation import Evaluation

MIN_PRINTED_AREA_PER_LOAD_RANGE = 1e-6
MIN_NARROWING_FRACTION = 0.05
MAX_SHOWN_SAMPLES = 800

UNLIMITED_PREDICTION_TEXT = (
    "An upper limit of ∞ means that the interface may be stronger than the softer body, which would then shear instead "
    "of the interface: measure the hardness, or add tests of a ball, to narrow the ranges of μ0 and τ0."
)
"""Explanation of an infinite upper limit."""


@dataclass(frozen=True)
class WantedPairPrediction:
    """Predicted coefficients of a pair at all loads of its study, and proposals for further friction tests.

    `points` has the text of each load, and the coefficient with its interval. `caveats` are texts about inputs of the
    pair that the tests also have, but with other ranges. `hardness` is the hardness (GPa) of the pair, or NaN for an
    elastic pair.
    """

    points: tuple[tuple[str, ValueWithLimits], ...]
    plans: tuple[PlannedTests, ...]
    caveats: tuple[str, ...] = ()
    hardness: float = math.nan

    @property
    def is_unlimited(self) -> bool:
        """True if a predicted interval has no upper limit."""
        return any(math.isinf(upper) for _, (_, _, upper) in self.points)


def predict_wanted_pair(interface: Interface, result: Evaluation) -> WantedPairPrediction:
    """Predict the coefficients of a pair, and how further friction tests would change their intervals."""
    loads = [float(load) for load in result.study.friction.load]
    points = tuple(
        (
            format_load(load, load / result.nominal_area if result.nominal_area else math.nan),
            interface.predict(result, load),
        )
        for load in loads
    )
    inputs, checksum = Inputs.from_study(result.study), result.study.pair_checksum
    caveats = tuple(f"! {caveat.text}; {caveat.remedy}" for caveat in find_range_caveats(interface, inputs, checksum))
    plans = plan_tests(interface, result, loads[0])
    return WantedPairPrediction(points, plans, caveats, find_pair_hardness(result))


def calibration_text(
    interface: Interface, pair_notes: Sequence[str] = (), prediction: WantedPairPrediction | None = None
) -> str:
    """Return a calibration as text: mu0, tau0, mu0 + tau0 A/F, junction growth, and the fit under each sliding rule.

    `pair_notes` are paragraphs about the tested pairs, such as notes on their lay. `prediction` replaces the table of
    tests that would separate mu0 and tau0.
    """
    first_fit = interface.fits[0]
    sum_text = f"μ0 + τ0 A/F = {Estimate(*interface.identified).table_text}"
    condition = f"{SLIDING_RULE_DESCRIPTIONS[first_fit.sliding]}; {_area_per_load_text(interface)}"
    lines = [wrap_text(f"{sum_text}, {condition}", hanging_indent="  ")]
    if interface.separated:
        mu0, tau0 = Estimate(*interface.mu0), Estimate(*(1e3 * item for item in interface.tau0))
        lines += [f"μ0 = {mu0.table_text}", f"τ0 = {tau0.table_text} MPa"]
        if zeros := possible_zeros_text(interface, " or "):
            text = f"The tests do not exclude {zeros}, so all intervals include the results for this case."
            lines += [wrap_text(text, hanging_indent="  ")]
    else:
        lines += [wrap_text(item, hanging_indent="  ") for item in _describe_unseparated_mu0_tau0(interface)]
    lines += [wrap_text(note, hanging_indent="  ") for note in (*list_pair_caveats(interface), *pair_notes)]
    if interface.junction_growth is not None:
        lines += [wrap_text(_junction_growth_text(interface), hanging_indent="  ")]
    lines += [
        "",
        *(wrap_text(item, hanging_indent="  ") for fit in interface.fits for item in _describe_fit(interface, fit)),
    ]
    if len(interface.fits) > 1 and all(math.isnan(test[2]) for test in interface.tests):
        advice = "The tests have no uncertainties, so they cannot exclude a sliding rule: add a column uncertainty (%)."
        lines += [wrap_text(advice, hanging_indent="  ")]
    if interface.common > 0:
        text = f"The fit assumes a further error of {format_percent(interface.common)} that all tests share (--common)."
        lines += [wrap_text(text, hanging_indent="  ")]
    if prediction is not None:
        lines += ["", *_describe_prediction(interface, prediction)]
    elif interface.advice:
        table = [["further test that would separate μ0 and τ0", "± μ0", "± τ0"]]
        table += [[text, f"{mu0:.2g}", format_with_unit(tau0, "GPa")] for text, mu0, tau0 in interface.advice]
        conditions_text = _plan_conditions_text(find_plan_conditions(interface))
        lines += ["", format_table(table), wrap_text(conditions_text, hanging_indent="  ")]
    return "\n".join(lines)


def _plan_conditions_text(conditions: PlanConditions) -> str:
    """Return text on proposed friction tests: the error that each test is assumed to have, and the loads to choose."""
    reason = "the median of your tests" if conditions.is_error_known else "because the errors of your tests are unknown"
    low, high = conditions.ball_area_per_load
    error_text = f"has an error of {format_percent(conditions.relative_error)}, {reason}."
    yield_text = (
        ""
        if math.isnan(conditions.hardness)
        else f" Above a mean pressure of {format_with_unit(conditions.ball_yield_limit, 'GPa')} "
        f"({BALL_YIELD_PRESSURE_RATIO:g} times the hardness of {format_with_unit(conditions.hardness, 'GPa')}), the "
        "ball would yield."
    )
    if conditions.num_tests == 1:
        return (
            f"Each of these tests {error_text} Choose a load at which A/F of the ball is {low:.3g} 1/GPa, and the "
            f"present load for other pairs.{yield_text}"
        )
    return (
        f"Each of these tests {error_text} Choose loads at which A/F of the ball is {low:.3g} to {high:.3g} 1/GPa, and "
        f"the present loads for other pairs.{yield_text}"
    )


def _describe_prediction(interface: Interface, prediction: WantedPairPrediction) -> Iterator[str]:
    """Yield lines of text: the predicted coefficients, and a table of the intervals that further tests would give."""
    rule, (load, first_coefficient) = SLIDING_RULE_DESCRIPTIONS[interface.fits[0].sliding], prediction.points[0]
    for text, limits in prediction.points:
        yield f"predicted at {text}: μ_s = {Estimate(*limits)}  {rule}"
    if prediction.is_unlimited:
        yield wrap_text(UNLIMITED_PREDICTION_TEXT, hanging_indent="  ")
    yield from (wrap_text(caveat, hanging_indent="  ") for caveat in prediction.caveats)
    yield ""
    rows = [[f"further tests, by the interval at {load}", "μ_s"], ["none", str(Estimate(*first_coefficient))]]
    yield format_table([*rows, *([plan.text, str(Estimate(*plan.coefficient))] for plan in prediction.plans)])
    conditions = find_plan_conditions(interface, prediction.hardness)
    yield wrap_text(_plan_conditions_text(conditions), hanging_indent="  ")


def list_pair_caveats(interface: Interface) -> list[str]:
    """Return a caveat for each severe fault of a tested pair, with advice not to quote the interface's coefficients."""
    return [f"! {place}, do not quote: {fault}" for place, fault in interface.pair_faults]


def list_lay_notes(name: str, result: Evaluation) -> list[str]:
    """Return a note on the lay assumed for a tested pair of profiles; empty for height maps."""
    lay = lay_assumption(result.study)
    note = f"{name}: computed for {lay}. Another lay would change A/F, and no interval includes this change."
    return [note] if lay else []


def _area_per_load_text(interface: Interface) -> str:
    """Return a sentence on the ratio A/F (true area to load) in the tests: its mean with interval, and its range."""
    ratios = np.array([test[0] for test in interface.tests])
    value, low, high = interface.tested_area_per_load
    is_exact = math.isnan(low) or high - low <= MIN_PRINTED_AREA_PER_LOAD_RANGE * value
    mean_text = f"{value:.3g}" if is_exact else Estimate(value, low, high).text()
    if ratios.size < 2 or _are_ratios_equal(ratios):
        return f"A/F of the tests: {mean_text} 1/GPa"
    return f"mean A/F of the tests: {mean_text} 1/GPa; the tests span {min(ratios):.3g} to {max(ratios):.3g} 1/GPa"


def _are_ratios_equal(ratios: Floats) -> bool:
    return bool(np.ptp(ratios) <= MIN_PRINTED_AREA_PER_LOAD_RANGE * np.median(ratios))


def _describe_unseparated_mu0_tau0(interface: Interface) -> Iterator[str]:
    num_tests = len(interface.tests)
    shortage_text = (
        f"the standard deviation of A/F of the {num_tests} tests is {format_percent(interface.variation)} of the mean"
        if num_tests > 1
        else "there is one test"
    )
    requirement_text = (
        f"a standard deviation of {format_percent(MIN_AREA_VARIATION)}" if num_tests > 2 else "three tests"
    )
    yield (
        f"The tests determine only the sum μ0 + τ0 A/F: {shortage_text}. To determine μ0 and τ0, {requirement_text} "
        f"{'is' if num_tests > 2 else 'are'} required."
    )
    (high_mu0, low_tau0), (low_mu0, high_tau0) = _find_ends_of_strengths(interface)
    zeros = possible_zeros_text(interface, " and ")
    covered_text = f"; all intervals include the results for {zeros}" if zeros else ""
    line_text = f"{high_mu0}, {low_tau0}, to {low_mu0}, {high_tau0}"
    yield f"The tests allow all values near the line from {line_text}{covered_text}."


def _find_ends_of_strengths(interface: Interface) -> tuple[tuple[str, str], tuple[str, str]]:
    """Return as text two extreme pairs (mu0, tau0) that the tests allow: with the lowest tau0, and with the lowest mu0.

    The first pair has the lowest tau0, and the second the lowest mu0. The samples at an end have tau0 = 0 or mu0 = 0.
    If the tests exclude this value, the samples are the 5 % with the lowest tau0 or mu0, whose median is the lower
    limit of an interval with 95 % of all samples.
    """
    fit = interface.fits[0]

    def end(name: str) -> tuple[str, str]:
        if name in interface.possible_zeros:
            bound = fit.fits_at_bounds[name]
            mu0, tau0 = np.median(bound.mu0), np.median(bound.tau0)
        else:
            values = getattr(fit, name)
            is_lowest = values <= np.quantile(values, 2 * find_tail_probabilities()[0])
            mu0, tau0 = np.median(fit.mu0[is_lowest]), np.median(fit.tau0[is_lowest])
        return f"μ0 = {mu0:.3g}", f"τ0 = {format_with_unit(tau0, 'GPa') if tau0 else 0}"

    return end("tau0"), end("mu0")


def _junction_growth_text(interface: Interface) -> str:
    """Return a sentence on junction growth: the value used for the tests, and whether the tests narrow its range."""
    growth = interface.junction_growth
    assert growth is not None, "tests have a junction growth"
    text = f"Junction growth: the tests were evaluated with {junction_growth_text(growth)}"
    if growth.is_exact:
        return f"{text}. A pair with this interface uses the same value."
    lower_limit, value, upper_limit = np.quantile(interface.fits[0].junction_growth, [0.025, 0.5, 0.975])
    prior_low, prior_high = growth.quantile([0.025, 0.975])
    if max(abs(lower_limit - prior_low), abs(upper_limit - prior_high)) <= MIN_NARROWING_FRACTION * (
        prior_high - prior_low
    ):
        return f"{text}, a range that the tests do not narrow. A pair with this interface uses the same range."
    name = "H/k" if growth.uses_slip_lines else "α"
    text += f", and narrow the range to {name} = {Estimate(value, lower_limit, upper_limit).text()}"
    return f"{text}. A pair with this interface uses the narrowed range."


def _describe_fit(interface: Interface, fit: StrengthFit) -> Iterator[str]:
    rule = SLIDING_RULE_DESCRIPTIONS[fit.sliding]
    if not fit.freedom:
        yield f"{rule}: there are as many unknowns as tests, so the fit cannot be judged."
    elif math.isnan(fit.probability):
        yield f"{rule}: errors were estimated from the scatter with {fit.freedom} degrees of freedom."
    else:
        text = f"{rule}: χ² = {fit.chi_squared:.3g} with {fit.freedom} degrees of freedom"
        if fit.sliding in interface.excluded:
            yield f"{text}: excluded by the tests (probability {fit.probability:.1g})."
        elif fit.scale > 1:
            yield (
                f"{text}: residuals are larger than the errors allow, so the errors were multiplied by {fit.scale:.2g}."
            )
        elif fit.probability < ERROR_SCALING_P_VALUE_LIMIT:
            yield f"{text}: a poor fit."
        else:
            yield f"{text}."
    if fit.trend < EXCLUSION_P_VALUE_LIMIT:
        yield f"{rule}: residuals vary with the load (probability {fit.trend:.1g}), so the law does not fit."


def calibration_json(
    interface: Interface, lays: Sequence[str] = (), prediction: WantedPairPrediction | None = None
) -> str:
    """Return a calibration as JSON.

    `lays` are the notes of `list_lay_notes` on the tested pairs.
    """
    separate_status = "ok" if interface.separated else "not separated"
    coordinates = {"area_per_load_per_GPa": interface.tested_area_per_load[0]}
    estimate_records = [
        Estimate(*limits, name=name, unit=unit, kind="combined", status=status).to_record(coordinates)
        for name, limits, unit, coordinates, status in (
            ("identified", interface.identified, "1", coordinates, "ok"),
            ("mu0", interface.mu0, "1", {}, separate_status),
            ("tau0", interface.tau0, "GPa", {}, separate_status),
        )
    ]
    fits = [
        {
            "sliding": fit.sliding,
            "chi_squared": None if math.isnan(fit.probability) else fit.chi_squared,
            "degrees_of_freedom": fit.freedom,
            "probability": fit.probability,
            "errors_multiplied_by": fit.scale,
            "trend": fit.trend,
        }
        for fit in interface.fits
    ]
    advice_records = [
        {"test": text, "error_of_mu0": mu0, "error_of_tau0": tau0} for text, mu0, tau0 in interface.advice
    ]
    return record_json(
        "calibrate", estimate_records, kind="interface", common=interface.common,
        variation=interface.variation, separated=interface.separated,
        junction_growth=None if interface.junction_growth is None else interface.junction_growth.short_text,
        possible_zeros=list(interface.possible_zeros), excluded=list(interface.excluded), fits=fits,
        would_separate=advice_records, plan_conditions=_build_plan_conditions(
            find_plan_conditions(interface, math.nan if prediction is None else prediction.hardness)
        ),
        pair_caveats=list_pair_caveats(interface), lays=list(lays),
        **_build_prediction_fields(prediction),
    )  # fmt: skip


def _build_plan_conditions(conditions: PlanConditions) -> dict[str, Any]:
    """Return the conditions of the planned friction tests as JSON fields.

    The fields are the number and the relative error of the tests, and A/F (1/GPa) and the yield limit (GPa) of a ball.
    """
    return {
        "tests": conditions.num_tests, "relative_error": conditions.relative_error,
        "is_error_known": conditions.is_error_known, "ball_area_per_load_per_GPa": list(conditions.ball_area_per_load),
        "ball_yield_limit_GPa": None if math.isnan(conditions.hardness) else conditions.ball_yield_limit,
    }  # fmt: skip


def _build_prediction_fields(prediction: WantedPairPrediction | None) -> dict[str, Any]:
    """Return predicted coefficients and proposed tests as JSON fields; {} if no prediction was requested."""
    if prediction is None:
        return {}
    return {
        "predicted": [_build_coefficient_fields(text, limits) for text, limits in prediction.points],
        "unlimited": UNLIMITED_PREDICTION_TEXT if prediction.is_unlimited else None,
        "caveats": list(prediction.caveats),
        "further_tests": [_build_coefficient_fields(plan.text, plan.coefficient) for plan in prediction.plans],
    }


def _build_coefficient_fields(text: str, limits: ValueWithLimits) -> dict[str, Any]:
    return {"text": text, "coefficient": Estimate(*limits, name="mu_s", unit="1", kind="combined").to_record()}


def interfaces_text(interfaces: Sequence[Mapping[str, str]]) -> str:
    """Return a description of interfaces as text, with one paragraph per interface."""
    paragraphs = []
    for record in interfaces:
        kind_and_motion = ", ".join(record[name] for name in ("kind", "motion") if name in record)
        law_text = f"{kind_and_motion}: μ0 = {record['mu0']}, τ0 = {record['tau0']}"
        other_entries = {
            name.replace("_", " "): text for name, text in record.items() if name not in _FRICTION_LAW_KEYS
        }
        other_lines = (
            text if name in _KEYS_PRINTED_WITHOUT_NAME else f"{name} {text}" for name, text in other_entries.items()
        )
        paragraphs.append(
            "\n".join(
                [
                    record["name"],
                    *(wrap_text(line, indent="  ", hanging_indent="  ") for line in (law_text, *other_lines)),
                ]
            )
        )
    return "\n\n".join(paragraphs)


_FRICTION_LAW_KEYS = ("name", "kind", "motion", "mu0", "tau0")
_KEYS_PRINTED_WITHOUT_NAME = ("conditions", "source")
"""Keys of an interface whose entries are printed without the name of the key, such as "source"."""


def calibration_figure(interface: Interface) -> Figure:
    """Draw a figure 170 mm wide: coefficients against true area per load, and the joint distribution of mu0 and tau0.

    Parameters
    ----------
    interface : Interface
        Result of `calibrate`, or an interface from a file.

    Returns
    -------
    figure : matplotlib.figure.Figure
        Two panels: coefficients over A/F (1/GPa), and the joint distribution of mu0 and tau0 (MPa).

    See Also
    --------
    calibrate : Calibration from friction tests.

    Examples
    --------
    >>> from stiction import Ball, FrictionTest, calibrate, calibration_figure
    >>> ball = Ball("5 mm", "3 GPa")
    >>> tests = [FrictionTest(ball, load, coefficient=0.3, uncertainty=0.01) for load in (10.0, 100.0, 1000.0)]
    >>> len(calibration_figure(calibrate(tests)).axes)
    2
    """
    import matplotlib as mpl

    check_instance("interface", interface, Interface, "an Interface, as returned by calibrate()")
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = new_figure(66, width=PAGE_WIDTH)
        tests_axes, distribution_axes = figure.subplots(1, 2)
        _draw_tests_panel(tests_axes, interface)
        fit = interface.fits[0]
        distribution_axes.plot(
            1e3 * fit.tau0[:MAX_SHOWN_SAMPLES],
            fit.mu0[:MAX_SHOWN_SAMPLES],
            ".",
            color=ALL_CONTACTS_COLOUR,
            markersize=2,
            alpha=0.3,
        )
        distribution_axes.set(
            xlabel="adhesive shear strength $\\tau_0$ (MPa)", ylabel="molecular friction coefficient $\\mu_0$"
        )
        distribution_axes.set(xlim=(0, None), ylim=(0, None))
        distribution_axes.set_title(
            "both are determined" if interface.separated else "only their combination is determined"
        )
    vars(figure)["_repr_png_"] = partial(render_png, figure)
    return figure


def _draw_tests_panel(axes: Axes, interface: Interface) -> None:
    tests = np.array(interface.tests, dtype=float).reshape(-1, 4)
    max_ratio = 1.15 * max(tests[:, 0].max(initial=0.0), interface.area_per_load)
    area_per_load = np.linspace(0.0, max_ratio, 60)
    fitted_coefficients = np.array([interface.at(item) for item in area_per_load])
    axes.fill_between(
        area_per_load,
        fitted_coefficients[:, 1],
        fitted_coefficients[:, 2],
        color=ALL_CONTACTS_COLOUR,
        alpha=0.15,
        linewidth=0,
        label="95 %",
    )
    axes.plot(
        area_per_load, fitted_coefficients[:, 0], color=ALL_CONTACTS_COLOUR, linewidth=1, label="$\\mu_0 + \\tau_0 A/F$"
    )
    is_slid = tests[:, 3] > 0
    axes.errorbar(
        tests[is_slid, 0],
        tests[is_slid, 1],
        2 * np.nan_to_num(tests[is_slid, 2]),
        fmt="o",
        color=FORCE_COLOUR,
        markersize=2.5,
        linewidth=0.6,
        label="tests, ±2 standard errors",
    )
    if not is_slid.all():
        axes.plot(tests[~is_slid, 0], tests[~is_slid, 1], "^", color=FORCE_COLOUR, markersize=3, label="did not slide")
    axes.set(xlim=(0, max_ratio), ylim=(0, 1.3 * max(tests[:, 1].max(initial=0.0), fitted_coefficients[-1, 0])))
    axes.set(xlabel="true contact area over load $A/F$ (1/GPa)", ylabel="coefficient of static friction")
    axes.legend(loc="lower right")
