"""Overview of generated surfaces: tables of coefficients by sliding rule and amplitude."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiction._number_format import format_with_unit
from stiction.evaluate.point import CELL_DIMENSIONS, SlidingRuleCoefficient
from stiction.mechanics.friction import STATUS_OK
from stiction.summary.summary import PointSummary, Summary
from stiction.views.assessment import COMPLETE_OUTPUT_METHOD, assessment_paragraph
from stiction.views.layout import Table, format_paragraphs
from stiction.views.point import COORDINATE_LABELS, SLIDING_RULE_DESCRIPTIONS, coordinate_text
from stiction.views.sentence import no_values_text

if TYPE_CHECKING:
    from stiction.study.study import Study


def overview_text(
    summary: Summary, max_lines: int | None = None, *, complete_command: str = COMPLETE_OUTPUT_METHOD
) -> str:
    """Return the coefficients of generated surfaces as tables, one per sliding rule and amplitude.

    A table has one row per fractal dimension and one column per load, and separate rows for mu0 and tau0 if the study
    has several of them. Caveats follow in at most `max_lines` lines; `complete_command` names the option that shows all
    caveats.
    """
    if summary.no_points_reason:
        return no_values_text(summary)
    study, points = summary.study, summary.reported_points
    printed_points = _select_overview_points(points)
    omission_note = _omission_text(printed_points, points, study)
    varying_names = [name for name in ("mu0", "tau0") if len({point.at[name] for point in printed_points}) > 1]
    tables: list[str | Table] = []
    for amplitude, rule in itertools.product(
        dict.fromkeys(point.at["amplitude"] for point in printed_points), study.contact.sliding_rules()
    ):
        points_of_table = [point for point in printed_points if point.at["amplitude"] == amplitude]
        tables += [
            _overview_title(points_of_table[0], rule, varying_names),
            _overview_table(points_of_table, rule, varying_names),
        ]
    is_any_outside_model = any(_is_marked(rule) for point in printed_points for rule in point.rules)
    notes = [OUTSIDE_MODEL_NOTE] if is_any_outside_model else []
    notes.append(omission_note)
    assessment = assessment_paragraph(points, max_lines, complete_command=complete_command)
    return format_paragraphs([[*tables, *notes], assessment])


OUTSIDE_MODEL_NOTE = "* outside the model: more than half of the load is on overlaps > R/10, or on radii < spacing"

# Maximum number of rows in an overview: if there are more, the rows of only some mu0 and tau0 are shown.
MAX_OVERVIEW_ROWS = 40


def _select_overview_points(points: Sequence[PointSummary]) -> Sequence[PointSummary]:
    """Return the result points for the overview: all or, if there are too many, only the points at a few mu0 and tau0.

    The selection has the middle mu0, and the lowest and the highest tau0.
    """
    names = ("mu0", "tau0", *(name for name in CELL_DIMENSIONS if name in points[0].at))
    if len({tuple(point.at[name] for name in names) for point in points}) <= MAX_OVERVIEW_ROWS:
        return points
    mu0, tau0 = (list(dict.fromkeys(point.at[name] for point in points)) for name in ("mu0", "tau0"))
    return [
        point for point in points if point.at["mu0"] == mu0[len(mu0) // 2] and point.at["tau0"] in (tau0[0], tau0[-1])
    ]


def _overview_table(points: Sequence[PointSummary], rule: str, varying_names: Sequence[str]) -> Table:
    """Return a coefficient table for one sliding rule: rows for mu0, tau0 and fractal dimension, columns for loads."""
    row_names = ("mu0", "tau0", "fractal_dimension")
    cells_by_row: dict[tuple[float, ...], list[str]] = {
        key: [] for key in itertools.product(*(dict.fromkeys(point.at[name] for point in points) for name in row_names))
    }
    for point in points:
        cells_by_row[tuple(point.at[name] for name in row_names)].append(_overview_cell(point, rule))
    exponents = {point.at["fractal_dimension"]: point.roughness_exponent[1] for point in points}
    labels = [[*(COORDINATE_LABELS[name] for name in varying_names), points[0].roughness_exponent[0]]]
    for key in cells_by_row:
        coordinate_texts = {name: coordinate_text(name, value) for name, value in zip(row_names, key, strict=True)}
        labels.append([*(coordinate_texts[name] for name in varying_names), f"{exponents[key[2]]:.4g}"])
    loads = [format_with_unit(load, "mN") for load in dict.fromkeys(point.at["load"] for point in points)]
    column_widths = [max(map(len, column)) for column in zip(*labels, strict=True)]
    rows = [
        ["  ".join(text.ljust(column_width) for text, column_width in zip(label, column_widths, strict=True)), *cells]
        for label, cells in zip(labels, [loads, *cells_by_row.values()], strict=True)
    ]
    return Table(rows)


def _omission_text(printed_points: Sequence[PointSummary], points: Sequence[PointSummary], study: Study) -> str:
    """Return a sentence that states how many values of each coordinate are shown, and which command prints all.

    Returns "" if no coefficients are omitted.
    """
    num_values = {name: len({point.at[name] for point in points}) for name in ("fractal_dimension", "mu0", "tau0")}
    num_values["fractal_dimension"] = study.surfaces.cell_coordinates()["fractal_dimension"].size
    count_texts = [
        f"{num_printed_values} of {num_available_values} values of "
        f"{points[0].roughness_exponent[0] if name == 'fractal_dimension' else COORDINATE_LABELS[name]}"
        for name, num_available_values in num_values.items()
        if (num_printed_values := len({point.at[name] for point in printed_points})) < num_available_values
    ]
    return f"Shown: {', '.join(count_texts)}; the command 'stiction at' prints all." if count_texts else ""


def _overview_title(point: PointSummary, rule: str, varying_names: Sequence[str]) -> str:
    assignment_texts = {"mu0": f"μ0 = {point.at['mu0']:g}", "tau0": f"τ0 = {coordinate_text('tau0', point.at['tau0'])}"}
    shared_conditions = [text for name, text in assignment_texts.items() if name not in varying_names]
    shared_conditions.append(f"amplitude {format_with_unit(point.at['amplitude'], 'um')}")
    if "sliding" in point.values.coords:
        shared_conditions.append(SLIDING_RULE_DESCRIPTIONS[rule])
    return f"μ_s [95 %] at {', '.join(shared_conditions)}"


def _overview_cell(point: PointSummary, rule: str) -> str:
    coefficient = next(coefficient for coefficient in point.rules if coefficient.rule == rule)
    if coefficient.status != STATUS_OK:
        return coefficient.status
    return str(coefficient) + "*" * _is_marked(coefficient)


def _is_marked(coefficient: SlidingRuleCoefficient) -> bool:
    """Return whether the overview marks a coefficient with an asterisk, because the asperity model is invalid."""
    return coefficient.status == STATUS_OK and coefficient.is_outside_asperity_model
