"""Results as text for a terminal: friction and assessment first, then a table.

The module selects the result points to print, composes paragraphs of lines and tables, and finally lays them out.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._estimate import Estimate
from stiction._number_format import format_load, format_percent, format_significant
from stiction.summary.summary import PointSummary, Summary
from stiction.views.assessment import (
    COMPLETE_OUTPUT_METHOD,
    MAX_CAVEAT_GROUPS,
    assessment_paragraph,
    count_assessments,
    count_assessments_text,
)
from stiction.views.layout import Paragraph, Table, WrappedText, format_paragraph, format_paragraphs
from stiction.views.onset import onset_paragraph
from stiction.views.overview import overview_text
from stiction.views.point import (
    COORDINATE_LABELS,
    SLIDING_RULE_DESCRIPTIONS,
    SLIDING_RULE_TITLES,
    coefficient_text,
    coordinate_text,
    motion_direction_text,
    nominal_area_text,
    point_coordinate_text,
    point_load_text,
    sliding_rule_text,
)
from stiction.views.pull_off import pull_off_text
from stiction.views.quantities import quantities_paragraph
from stiction.views.resolution import resolution_paragraphs
from stiction.views.sentence import (
    area_size_effect_text,
    input_range_text,
    no_values_text,
    result_point_detail_sentences,
    roughness_text,
    shared_conditions_text,
    small_slope_estimate_text,
)

if TYPE_CHECKING:
    from stiction.evaluate.point import SlidingRuleCoefficient
    from stiction.study.study import Study

MIN_STATED_GROOVE_FRICTION_DIFFERENCE = 0.01
MAX_PRINTED_POINTS = 15


def study_result_text(
    summary: Summary,
    *,
    verbose: bool = False,
    max_overview_lines: int | None = None,
    complete_command: str = COMPLETE_OUTPUT_METHOD,
) -> str:
    """Return a result at the loads of its study as text for a terminal.

    The text is `result_text` for measured surfaces and `overview_text` for generated surfaces. Generated surfaces have
    many fractal dimensions and loads, so their text contains only coefficients and caveats.

    Parameters
    ----------
    summary : Summary
    verbose : bool
        True to print all caveats and, for measured surfaces, the inputs, every direction and every quantity.
    max_overview_lines : int, optional
        Maximum number of caveat lines in an overview, unless `verbose` is true.
    complete_command : str
        Option, command or method that shows omitted points and caveats.
    """
    if summary.study.is_measured:
        return result_text(summary, verbose=verbose, complete_command=complete_command)
    return overview_text(summary, None if verbose else max_overview_lines, complete_command=complete_command)


def result_text(
    summary: Summary,
    *,
    verbose: bool = False,
    max_lines: int | None = None,
    complete_command: str = COMPLETE_OUTPUT_METHOD,
) -> str:
    """Return a result as text for a terminal: first friction and its assessment, then a table.

    Parameters
    ----------
    summary : Summary
    verbose : bool
        True to add the inputs, every direction and every quantity.
    max_lines : int, optional
        Maximum number of lines for caveats. The first caveat, all faults, and the number of omitted caveats are always
        printed.
    complete_command : str
        Option, command or method that shows omitted points and caveats.
    """
    return main_values_text(
        summary, verbose=verbose, max_lines=max_lines, complete_command=complete_command
    ) + resolution_and_onset_text(summary, verbose=verbose)


def main_values_text(
    summary: Summary,
    *,
    verbose: bool = False,
    max_lines: int | None = None,
    complete_command: str = COMPLETE_OUTPUT_METHOD,
) -> str:
    """Return a result as text for a terminal; the onset of sliding and friction at several cutoffs are left out."""
    if summary.no_points_reason:
        return no_values_text(summary)
    points = summary.reported_points
    printed_points = points if verbose else _select_printed_points(points)
    points_of_first_cell = _select_points_of_first_cell(points, {point.at["load"] for point in printed_points})
    num_omitted = len(points) - len(printed_points)
    omission_note = f"Shown: {len(printed_points)} of {len(points)} points; {complete_command} shows all."
    caveat_limits = {} if verbose else {"max_lines": max_lines, "max_groups": MAX_CAVEAT_GROUPS}
    values_paragraph = [
        *_pull_off_lines(points),
        *(coefficients_paragraph(printed_points) if any(not point.is_unloaded for point in points) else []),
        *([omission_note] if num_omitted else []),
        *assessment_paragraph(points, complete_command=complete_command, **caveat_limits),
    ]
    details_paragraph = result_point_detail_sentences(points[0]) if len(points) == 1 else []
    slopes_paragraph = [small_slope_estimate_text(points[0])]
    table_paragraph: Paragraph = []
    direction_paragraphs: list[Paragraph] = []
    if any(math.isfinite(point.value) or point.is_unloaded for point in points):
        table_paragraph = quantities_paragraph(
            points_of_first_cell, verbose=verbose, cell=_first_cell_coordinates_text(points)
        )
        if size_effect_text := area_size_effect_text(points_of_first_cell):
            table_paragraph = [*table_paragraph, size_effect_text]
        if verbose:
            table_paragraph = [combined_intervals_note(points[0]), *table_paragraph]
        for point in [point for point in points_of_first_cell if not point.is_unloaded][:1]:
            direction_paragraphs = _direction_paragraphs(point, verbose=verbose)
    if verbose:
        return _join_paragraphs(
            _history_paragraph(points[0]), values_paragraph, details_paragraph, slopes_paragraph, table_paragraph,
            *direction_paragraphs,
        )  # fmt: skip
    return _join_paragraphs(values_paragraph, [*details_paragraph, *table_paragraph], *direction_paragraphs)


def combined_intervals_note(point: PointSummary) -> str:
    """Return a note that states which intervals in tables of quantities include the uncertainty of inputs."""
    if "friction_combined" not in point.values:
        return "Intervals in the following tables are 95 % intervals of the mean for exact inputs."
    alternatives = " and alternative preparations of the scans" if point.values.attrs.get("alternatives") else ""
    return (
        f"Intervals of the true area, the mean pressure and the stiffness include the uncertain inputs{alternatives}; "
        "all other intervals in the following tables are those of the mean for exact inputs."
    )


def _join_paragraphs(*paragraphs: Paragraph) -> str:
    return format_paragraphs(paragraphs) + "\n"


def resolution_and_onset_text(summary: Summary, *, verbose: bool = False) -> str:
    """Return text on the onset of sliding and, if `verbose`, on friction at several cutoffs."""
    if not any(math.isfinite(point.value) for point in summary.points):
        return ""
    paragraphs: list[Paragraph] = []
    if verbose and summary.resolution is not None:
        paragraphs += resolution_paragraphs(summary.resolution, summary.points[0].hardness, summary.study)
    if summary.onset_values is not None:
        paragraphs.append(onset_paragraph(summary.onset_values, summary.study, verbose=verbose))
    return "".join(f"\n{text}\n" if verbose else f"{text}\n" for text in map(format_paragraph, paragraphs))


def preview_text(summary: Summary) -> str:
    """Return a line with a preliminary coefficient, from the asperity model and the first few surface pairs."""
    point = summary.points[0]
    rule = SLIDING_RULE_DESCRIPTIONS[point.rules[0].rule]
    return f"preliminary, with asperities: μ_s = {Estimate(point.value)}  {rule}"


def default_friction_parameters_text(study: Study, *, mu0: bool, tau0: bool) -> str:
    """Return a line with the study's mu0 and tau0.

    Returns "" if the study has a single mu0 and a single tau0.
    """
    friction = study.friction
    assignment_texts = []
    if mu0 and len(friction.mu0) > 1:
        assignment_texts.append(f"μ0 = {', '.join(f'{value:g}' for value in friction.mu0)} (--mu0)")
    if tau0 and len(friction.tau0) > 1:
        tau0_texts = (coordinate_text("tau0", float(value)) for value in friction.tau0)
        assignment_texts.append(f"τ0 = {', '.join(tau0_texts)} (--tau0)")
    text = f"Using the values of the study: {'; '.join(assignment_texts)}." if assignment_texts else ""
    return format_paragraph([text])


def interpolation_text(
    neighbours: Mapping[float, tuple[float, float]], points: Sequence[PointSummary], nominal_area: float | None
) -> str:
    """Return, for each interpolated load, a sentence on the assessments at the next smaller and larger computed load.

    `neighbours` contains the two computed loads by interpolated load (mN), and `points` all result points at computed
    loads.
    """

    def describe_load(load: float) -> str:
        return format_load(load, math.nan if nominal_area is None else load / nominal_area)

    def describe_computed_load(load: float) -> str:
        points_of_load = [point for point in points if point.at["load"] == load]
        assessments = {point.assessment for point in points_of_load}
        text = assessments.pop() if len(assessments) == 1 else count_assessments_text(points_of_load)
        return f"{describe_load(load)}: {text}"

    sentences = [
        f"Interpolated at {describe_load(load)}, between {' and '.join(map(describe_computed_load, loads))}."
        for load, loads in neighbours.items()
    ]
    return format_paragraph(list(sentences))


def interpolation_records(
    neighbours: Mapping[float, tuple[float, float]], points: Sequence[PointSummary]
) -> list[dict[str, Any]]:
    """Return, for each interpolated load, a JSON object: the neighbouring computed loads and their assessments."""
    return [
        {
            "load": load,
            "between": [
                {
                    "load": computed_load,
                    "assessments": count_assessments([point for point in points if point.at["load"] == computed_load]),
                }
                for computed_load in loads
            ],
        }
        for load, loads in neighbours.items()
    ]


# ---- Selection of points ---------------------------------------------------------------------------------------------


def _select_printed_points(points: Sequence[PointSummary]) -> Sequence[PointSummary]:
    """Select at most `MAX_PRINTED_POINTS` result points that are evenly spaced along each coordinate."""
    coordinate_values = {name: list(dict.fromkeys(point.at[name] for point in points)) for name in points[0].at}
    if "hurst_exponent" in coordinate_values:
        coordinate_values.pop("fractal_dimension", None)
    num_values = {name: len(coordinates) for name, coordinates in coordinate_values.items()}
    while math.prod(num_values.values()) > MAX_PRINTED_POINTS:
        num_values[max(reversed(num_values), key=lambda name: num_values[name])] -= 1
    if num_values == {name: len(coordinates) for name, coordinates in coordinate_values.items()}:
        return points
    selected_values = {
        name: {
            coordinates[index] for index in np.linspace(0, len(coordinates) - 1, num_values[name]).round().astype(int)
        }
        for name, coordinates in coordinate_values.items()
    }
    return [point for point in points if all(point.at[name] in selected_values[name] for name in selected_values)]


def _select_points_of_first_cell(points: Sequence[PointSummary], loads: Collection[float]) -> list[PointSummary]:
    """Return the result points at given loads (mN) with the same surfaces, mu0 and tau0 as the first result point."""
    first_coordinates = points[0].at.items()
    return sorted(
        (
            point
            for point in points
            if point.at["load"] in loads
            and all(point.at[name] == value for name, value in first_coordinates if name != "load")
        ),
        key=lambda point: point.at["load"],
    )


def _first_cell_coordinates_text(points: Sequence[PointSummary]) -> str:
    """Return the coordinates that describe the surfaces of the first result point as text, such as "H = 0.9".

    Returns "" if all points share these coordinates.
    """
    names = [name for name in _list_varying_coordinates(points) if name not in ("load", "mu0", "tau0")]
    return _assignments_text(points[0], names)


def _list_varying_coordinates(points: Sequence[PointSummary]) -> list[str]:
    """Return the names of the coordinates, such as "load", that differ between result points.

    The Hurst exponent H replaces the fractal dimension D if both are known.
    """
    names = [name for name in points[0].at if name != "fractal_dimension" or "hurst_exponent" not in points[0].at]
    return [name for name in names if len({point.at[name] for point in points}) > 1]


def _assignments_text(point: PointSummary, names: Sequence[str]) -> str:
    """Return the named coordinates of a result point as text, as in "μ0 = 0.2, τ0 = 50 MPa"."""
    return ", ".join(f"{COORDINATE_LABELS.get(name, name)} = {point_coordinate_text(point, name)}" for name in names)


# ---- Coefficients ----------------------------------------------------------------------------------------------------


def _pull_off_lines(points: Sequence[PointSummary]) -> list[str]:
    """Return a list with one sentence on the pull-off force and on friction at zero load.

    Returns an empty list if the bodies do not adhere.
    """
    first_point = points[0]
    if first_point.pull_off is None or not first_point.pull_off.force.value > 0:
        return []
    varying_names = [name for name in ("mu0", "tau0") if len({point.at[name] for point in points}) > 1]
    return [pull_off_text(first_point.pull_off, _assignments_text(first_point, varying_names))]


def coefficients_paragraph(points: Sequence[PointSummary]) -> Paragraph:
    """Return a paragraph on coefficients: a line per sliding rule for one load, mu0 and tau0, otherwise a table."""
    varying_names = sorted(_list_varying_coordinates(points), key=lambda name: name != "hurst_exponent")
    if len(points) == 1:
        (point,) = points
        lines = []
        for index, rule in enumerate(point.rules):
            symbol, relation = ("   ", "  ") if index else ("μ_s", "= ")
            text = coefficient_text(point, rule)
            relation = "" if text.startswith("≥") else relation
            line = f"{symbol} {relation}{text}  {sliding_rule_text(point, rule.rule)}"
            lines.append(WrappedText(line, hanging_indent=" " * 8))
        return [*lines, roughness_text(point)]
    headings = (f"μ_s {SLIDING_RULE_TITLES[rule.rule]}" for rule in points[0].rules)
    rows = [[*(COORDINATE_LABELS.get(name, name) for name in varying_names), *headings, "assessment"]]
    for point in points:
        coefficients = [coefficient_text(point, rule) for rule in point.rules]
        coordinates = [_table_coordinate_text(point, name) for name in varying_names]
        rows.append([*coordinates, *coefficients, point.assessment])
    return [Table(rows, num_labels=len(varying_names)), WrappedText(shared_conditions_text(points), indent="  ")]


def _table_coordinate_text(point: PointSummary, name: str) -> str:
    """Return a result point's coordinate as text for a table, with the range of mu0 or tau0 in brackets."""
    if name == "load":
        return point_load_text(point)
    has_range = name in ("mu0", "tau0") and point.are_strengths_separated
    return point_coordinate_text(point, name) + (input_range_text(point, name) if has_range else "")


# ---- Directions ------------------------------------------------------------------------------------------------------


def _direction_paragraphs(point: PointSummary, *, verbose: bool) -> list[Paragraph]:
    """Return a paragraph on grooves and, if `verbose`, tables of coefficients for each axis and each direction."""
    if not verbose:
        return [grooves_paragraph(point)]
    by_direction = {rule.rule: rule.by_direction for rule in _sort_rules_of_directions(point)}
    return [
        grooves_paragraph(point, verbose=True),
        _coefficients_table(by_direction, lambda degrees: f"upper body {motion_direction_text(degrees)}"),
    ]


def _sort_rules_of_directions(point: PointSummary) -> list[SlidingRuleCoefficient]:
    """Sort the coefficients for all sliding rules into the order of columns in tables by direction.

    The first column is for the rule "all", unless an interface was fitted under the other rule.
    """
    return list(point.rules) if point.study.is_measured else sorted(point.rules, key=lambda rule: rule.rule)


def grooves_paragraph(point: PointSummary, *, verbose: bool = False) -> Paragraph:
    """Return a paragraph on the effect of grooves; empty if friction does not differ significantly between axes.

    With `verbose`, a sentence is returned even then, below a table of the coefficients along each axis. For a single
    axis, the paragraph is always empty.
    """
    coefficients = {rule.rule: rule.by_axis for rule in _sort_rules_of_directions(point)}
    by_axis = next(iter(coefficients.values()))
    if len(by_axis) < 2:
        return []
    sentence = _grooves_text(by_axis)
    if verbose:
        return [*_coefficients_table(coefficients, lambda degrees: f"along {_axis_label(degrees)}"), sentence]
    return [sentence] if sentence.startswith("Grooves: friction") else []


def _grooves_text(by_axis: Mapping[float, Estimate]) -> str:
    """Return a sentence on grooves: the relative difference between coefficients for motion along different axes.

    Grooves are reported if the intervals along two axes do not overlap, and if the difference is at least 1 %.
    """
    if not all(math.isfinite(estimate.lower) for estimate in by_axis.values()):
        return "Grooves: unknown, because the coefficients along the axes have no intervals."
    highest_axis = max(by_axis, key=lambda axis: by_axis[axis].value)
    lowest_axis = min(by_axis, key=lambda axis: by_axis[axis].value)
    highest_coefficient, lowest_coefficient = by_axis[highest_axis], by_axis[lowest_axis]
    if not highest_coefficient.lower > lowest_coefficient.upper:
        return "No grooves: the axes differ by less than their intervals."
    increase = highest_coefficient.value / lowest_coefficient.value - 1
    if increase < MIN_STATED_GROOVE_FRICTION_DIFFERENCE:
        return f"No grooves: the axes differ by less than {format_percent(MIN_STATED_GROOVE_FRICTION_DIFFERENCE)}."
    return (
        f"Grooves: friction along {_axis_label(highest_axis)} is {format_significant(100 * increase)} % higher "
        f"than along {_axis_label(lowest_axis)}."
    )


def _coefficients_table(
    coefficients: Mapping[str, Mapping[float, Estimate]], format_coordinate: Callable[[float], str]
) -> Paragraph:
    """Return a table of coefficients with intervals of the mean: rows for directions, columns for sliding rules."""
    rows = [
        [
            format_coordinate(coordinate),
            *(_coefficient_cell(estimates[coordinate]) for estimates in coefficients.values()),
        ]
        for coordinate in next(iter(coefficients.values()))
    ]
    headings = ["μ_s [sampling]", *(SLIDING_RULE_TITLES[rule] for rule in coefficients)]
    return [Table([headings, *rows])] if rows else []


def _coefficient_cell(estimate: Estimate) -> str:
    """Return text with a coefficient and its interval, or with the words "no interval" if there is none."""
    return str(estimate) if estimate.has_interval or math.isnan(estimate.value) else f"{estimate} no interval"


def _axis_label(degrees: float) -> str:
    return {0.0: "x", 90.0: "y"}.get(degrees, f"{degrees:g}°")


# ---- Inputs ----------------------------------------------------------------------------------------------------------


def _history_paragraph(point: PointSummary) -> Paragraph:
    """Return lines on a result: the processing history of each body, and the contact model."""
    dataset, study = point.values, point.study
    descriptions = {
        name: str(dataset.attrs[name]).replace("\n", "; ") for name in ("upper", "lower") if name in dataset.attrs
    }
    mechanics_texts = {"half-space": "the elastic half-space", "asperities": "asperities without interaction"}
    model_texts = [mechanics_texts[study.contact.mechanics]]
    if "nominal_area" in dataset.coords:
        model_texts.append(f"on a nominal area of {nominal_area_text(float(dataset['nominal_area']))}")
    if study.contact.mechanics == "asperities" and study.surfaces.kind != "surface":
        model_texts += [str(getattr(study.contact, name)) for name in ("law", "detection", "curvature")]
    descriptions["model"] = ", ".join(model_texts)
    return [WrappedText(f"{name:<9}{text}", hanging_indent=" " * 9) for name, text in descriptions.items()]
