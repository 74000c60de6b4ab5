"""Terminal texts of results: values and assessment first, then one table, within the terminal width."""

from __future__ import annotations

import itertools
import math
import re
import shutil
import textwrap
from collections.abc import Callable, Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

from stiction._estimate import Estimate
from stiction._number_format import choose_prefixed_unit, format_significant, format_time, format_with_unit
from stiction.mechanics import friction
from stiction.mechanics.quantities import (
    LOAD_INDEPENDENT_QUANTITIES,
    QUANTITIES,
    STIFFNESS_PER_AREA_QUANTITIES,
    quantity_names_shown_in,
)
from stiction.studies.alternatives import ALTERNATIVE_LABELS, SPIKES_ALTERNATIVE, TIP_ALTERNATIVE
from stiction.studies.assessment import (
    ASPERITY_CHECKS,
    VERDICTS_BY_SEVERITY,
    WIDE_INTERVAL_TEXT,
    Caveat,
    find_caveats_of_failed_checks,
)
from stiction.studies.budget import (
    LOWER_SCANS_INPUT_NAME,
    POSITIONS_INPUT_NAME,
    UNRESOLVED_ROUGHNESS_INPUT_NAME,
    UPPER_SCANS_INPUT_NAME,
)
from stiction.studies.point import (
    CELL_DIMENSIONS,
    MEAN_AND_LIMITS,
    mean_over_directions,
    read_estimate,
    select_sliding_rule,
)
from stiction.studies.summary import UNATTRIBUTED_WAVELENGTHS_INPUT_NAME, PointSummary, Summary
from stiction.views.onset import onset_paragraph, quantity_label
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS, motion_direction_text, point_load_text
from stiction.views.pull_off import pull_off_text
from stiction.views.resolution import SLIDING_RULE_TITLES, Paragraph, TextRows, resolution_paragraphs
from stiction.views.sentence import (
    finer_scan_text,
    inputs_text,
    list_assumptions,
    point_note_text,
    roughness_contribution_text,
    small_slope_estimate_text,
)

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

COMPLETE_OUTPUT_METHOD = "summary()"  # method of a result that prints all points and caveats
MIN_TERMINAL_WIDTH = 40  # minimum text width in characters, also used if the terminal is narrower


# ---- Layout ----------------------------------------------------------------------------------------------------------


def terminal_width() -> int:
    """Return the width of the terminal in characters."""
    return max(MIN_TERMINAL_WIDTH, shutil.get_terminal_size().columns)


def wrap_text(text: str, width: int | None = None, *, indent: str = "", hanging_indent: str = "") -> str:
    """Wrap a paragraph to the width of the terminal."""
    unbreakable_text = _NO_BREAK_SPACE_PATTERN.sub("\N{NO-BREAK SPACE}", text)
    return textwrap.fill(
        unbreakable_text, width or terminal_width(), initial_indent=indent, subsequent_indent=indent + hanging_indent,
        break_long_words=False, break_on_hyphens=False,
    ).replace("\N{NO-BREAK SPACE}", " ")  # fmt: skip


_NO_BREAK_SPACE_PATTERN = re.compile(r"(?<=[^\s] =) | (?=[=<>] )|(?<=\d) (?=(?:[kmµn]?[NmgL]|[GMk]Pa|%|°)(?!\w))")
"""Spaces at which a line must not break: around an equals sign, and between a number and its unit."""


def format_table(rows: TextRows, width: int | None = None, *, labels: int = 1) -> str:
    """Format rows as a table with aligned columns, by default within the width of the terminal.

    Rows may have different lengths. Columns that do not fit are moved to further tables, which repeat the first
    `labels` columns. A first column that is too wide is wrapped.
    """
    available_width = width or terminal_width()
    columns = max(map(len, rows), default=0)
    other_widths = max((len(cell) for row in rows for cell in row[1:]), default=0)
    rows = [
        line for row in rows for line in _wrap_first_cell(row, max(available_width - other_widths - 2, MIN_LABEL_WIDTH))
    ]
    column_widths = [max(len(row[column]) if column < len(row) else 0 for row in rows) for column in range(columns)]
    blocks, first_column = [], labels
    while first_column < max(columns, labels + 1):
        last_column = first_column + 1
        while (
            last_column < columns
            and sum(
                2 + column_width
                for column_width in column_widths[:labels] + column_widths[first_column : last_column + 1]
            )
            - 2
            <= available_width
        ):
            last_column += 1
        block_widths = column_widths[:labels] + column_widths[first_column:last_column]
        blocks.append(
            "\n".join(_join_cells([*row[:labels], *row[first_column:last_column]], block_widths) for row in rows)
        )
        first_column = last_column
    return "\n".join(blocks)


MIN_LABEL_WIDTH = 16  # minimum width of the first column of a table, in characters


def _wrap_first_cell(row: Sequence[str], width: int) -> list[Sequence[str]]:
    """Wrap the first cell of a row to a width, and return the resulting rows."""
    lines = textwrap.wrap(row[0], width, subsequent_indent="  ", drop_whitespace=False) if len(row[0]) > width else []
    return [[lines[0].rstrip(), *row[1:]], *([line.rstrip()] for line in lines[1:])] if lines else [row]


def _join_cells(cells: Sequence[str], column_widths: Sequence[int]) -> str:
    return "  ".join(
        cell.ljust(column_width) for cell, column_width in zip(cells, column_widths, strict=False)
    ).rstrip()


def format_paragraph(paragraph: Paragraph) -> str:
    """Format sentences and tables within the width of the terminal. A sentence below a table is indented."""
    return "\n".join(
        wrap_text(item, indent="  " if index else "") if isinstance(item, str) else format_table(item)
        for index, item in enumerate(paragraph)
    )


# ---- Text of a result ------------------------------------------------------------------------------------------------


def result_text(
    summary: Summary,
    *,
    verbose: bool = False,
    max_lines: int | None = None,
    complete_command: str = COMPLETE_OUTPUT_METHOD,
) -> str:
    """Return a summary as terminal text: values, assessment and a table.

    Parameters
    ----------
    summary : Summary
    verbose : bool
        True to add the inputs, every direction and every quantity.
    max_lines : int, optional
        Maximum number of lines for caveats. The first caveat, all faults, and the number of omitted caveats are always
        printed.
    complete : str
        Option or method that shows omitted points and caveats.
    """
    return main_values_text(
        summary, verbose=verbose, max_lines=max_lines, complete_command=complete_command
    ) + resolution_and_onset_text(summary, verbose=verbose)


def default_friction_parameters_text(study: Study, *, mu0: bool, tau0: bool) -> str:
    """Return a line with the mu0 and tau0 of the study if there are several values, or an empty string."""
    friction = study.friction
    assignment_texts = []
    if mu0 and len(friction.mu0) > 1:
        assignment_texts.append(f"μ0 = {', '.join(f'{value:g}' for value in friction.mu0)} (--mu0)")
    if tau0 and len(friction.tau0) > 1:
        assignment_texts.append(
            f"τ0 = {', '.join(_coordinate_text('tau0', float(value)) for value in friction.tau0)} (--tau0)"
        )
    return wrap_text(f"Values of the study by default: {'; '.join(assignment_texts)}.") if assignment_texts else ""


def main_values_text(
    summary: Summary,
    *,
    verbose: bool = False,
    max_lines: int | None = None,
    complete_command: str = COMPLETE_OUTPUT_METHOD,
) -> str:
    """Return `result_text` without the cutoff study and the onset of sliding."""
    quoted_points = summary.headlines
    first_point = quoted_points[0]
    printed_points = quoted_points if verbose else _select_printed_points(quoted_points)
    varying_names = [name for name in ("mu0", "tau0") if len({point.at[name] for point in quoted_points}) > 1]
    inputs = ", ".join(
        f"{_COORDINATE_LABELS[name]} = {_coordinate_text(name, first_point.at[name])}" for name in varying_names
    )
    lines = (
        [wrap_text(pull_off_text(first_point.sticking, inputs))]
        if first_point.sticking is not None and first_point.sticking.pull_off.value > 0
        else []
    )
    if not all(point.is_unloaded for point in quoted_points):
        lines.append(coefficients_text(printed_points))
    if len(printed_points) < len(quoted_points):
        lines.append(
            wrap_text(f"Shown: {len(printed_points)} of {len(quoted_points)} points; {complete_command} shows all.")
        )
    caveat_limits = {} if verbose else {"max_lines": max_lines, "max_groups": MAX_CAVEAT_GROUPS}
    lines.append(assessment_text(quoted_points, complete_command=complete_command, **caveat_limits))
    conditions_paragraph = _point_details_text(first_point) if len(quoted_points) == 1 else ""
    quantities_paragraph, direction_paragraphs = "", []
    if any(math.isfinite(point.value) or point.is_unloaded for point in quoted_points):
        points_of_first_cell = _select_points_of_first_cell(
            quoted_points, {point.at["load"] for point in printed_points}
        )
        quantities_paragraph = quantities_text(
            points_of_first_cell, verbose=verbose, cell=_first_cell_coordinates_text(quoted_points)
        )
        for point in [point for point in points_of_first_cell if not point.is_unloaded][:1]:
            direction_paragraphs.append(friction_by_axis_text(point.values, verbose=verbose))
            if verbose:
                direction_paragraphs.append(friction_by_direction_text(point.values))
    if verbose:
        paragraphs = [
            history_text(first_point),
            "\n".join(lines),
            conditions_paragraph,
            wrap_text(small_slope_estimate_text(first_point)),
            quantities_paragraph,
            *direction_paragraphs,
        ]
    else:
        paragraphs = [
            "\n".join(lines),
            "\n".join(filter(None, (conditions_paragraph, quantities_paragraph))),
            *direction_paragraphs,
        ]
    return "\n\n".join(filter(None, paragraphs)) + "\n"


def _select_points_of_first_cell(points: Sequence[PointSummary], loads: Collection[float]) -> list[PointSummary]:
    """Select the points at the first cell, the first mu0 and the first tau0 for given loads, in the order of loads."""
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


def resolution_and_onset_text(summary: Summary, *, verbose: bool = False) -> str:
    """Return text about the onset of sliding and, if `verbose`, the cutoff study. Missing results are omitted."""
    if not any(math.isfinite(point.value) for point in summary.points):
        return ""
    paragraphs: list[Paragraph] = []
    if verbose and summary.resolution is not None:
        paragraphs += resolution_paragraphs(summary.resolution, summary.points[0].hardness)
    if summary.onset_values is not None:
        paragraphs.append(onset_paragraph(summary.onset_values, verbose=verbose))
    return "".join(f"\n{text}\n" if verbose else f"{text}\n" for text in map(format_paragraph, paragraphs))


def coefficients_text(headlines: Sequence[PointSummary]) -> str:
    """Format the coefficients: one line per rule for a single point, otherwise a table with the varying inputs."""
    if len(headlines) == 1:
        rule_lines = (
            f"{_coefficient_text(headlines[0], index)}  {SLIDING_RULE_DESCRIPTIONS[rule.rule]}"
            for index, rule in enumerate(headlines[0].rules)
        )
        lines = [
            wrap_text(f"{'      ' if i else 'μ_s = '}{line}", hanging_indent=" " * 8)
            for i, line in enumerate(rule_lines)
        ]
        return "\n".join(filter(None, [*lines, wrap_text(roughness_text(headlines[0]))]))
    coordinate_names = [
        name for name in headlines[0].at if name != "fractal_dimension" or "hurst_exponent" not in headlines[0].at
    ]
    coordinate_names.sort(key=lambda name: name != "hurst_exponent")
    varying_names = [name for name in coordinate_names if len({point.at[name] for point in headlines}) > 1]
    headings = (f"μ_s {SLIDING_RULE_TITLES[rule.rule]}" for rule in headlines[0].rules)
    rows = [[*(_COORDINATE_LABELS.get(name, name) for name in varying_names), *headings, "assessment"]]
    for point in headlines:
        values = [_coefficient_text(point, index) for index in range(len(point.rules))]
        coordinates = [
            point_load_text(point) if name == "load" else _coordinate_text(name, point.at[name])
            for name in varying_names
        ]
        rows.append([*coordinates, *values, point.verdict])
    inputs = [inputs_text(point).split(", ") for point in headlines]
    common_inputs = [
        input_text for input_text in inputs[0] if all(input_text in other_inputs for other_inputs in inputs)
    ]
    common_inputs_note = f"with {', '.join(common_inputs)}; " if common_inputs else ""
    assumptions = list_assumptions(headlines[0].study)
    assumptions_note = f"; assuming {', '.join(assumptions)}" if assumptions else ""
    return (
        format_table(rows, labels=len(varying_names))
        + "\n"
        + wrap_text(f"{common_inputs_note}{point_note_text(headlines[0])}{assumptions_note}", indent="  ")
    )


def _select_printed_points(headlines: Sequence[PointSummary]) -> Sequence[PointSummary]:
    """Return at most `MAX_PRINTED_POINTS` points, evenly spaced along each coordinate, including both ends."""
    values = {name: list(dict.fromkeys(point.at[name] for point in headlines)) for name in headlines[0].at}
    if "hurst_exponent" in values:
        values.pop("fractal_dimension", None)
    num_values = {name: len(coordinates) for name, coordinates in values.items()}
    while math.prod(num_values.values()) > MAX_PRINTED_POINTS:
        num_values[max(reversed(num_values), key=lambda name: num_values[name])] -= 1
    if num_values == {name: len(coordinates) for name, coordinates in values.items()}:
        return headlines
    selected_values = {
        name: {
            coordinates[index] for index in np.linspace(0, len(coordinates) - 1, num_values[name]).round().astype(int)
        }
        for name, coordinates in values.items()
    }
    return [point for point in headlines if all(point.at[name] in selected_values[name] for name in selected_values)]


MAX_PRINTED_POINTS = 15  # maximum number of rows in the first table if a result has several points


def _coefficient_text(point: PointSummary, index: int) -> str:
    rule = point.rules[index]
    if math.isfinite(rule.value):
        return str(rule)
    return "none" if point.status == friction.STATUS_OK else point.status


_COORDINATE_LABELS = {"fractal_dimension": "D", "hurst_exponent": "H", "mu0": "μ0", "tau0": "τ0", "cut_off": "cutoff"}
_COORDINATE_UNITS = {"load": "mN", "tau0": "GPa", "amplitude": "um", "cut_off": "um"}


def _coordinate_text(name: str, value: float) -> str:
    if name == "cut_off" and value == 0:
        return "none"
    return format_with_unit(value, _COORDINATE_UNITS[name]) if name in _COORDINATE_UNITS and value else f"{value:.4g}"


def _point_details_text(point: PointSummary) -> str:
    lines = [] if point.is_unloaded else [contributions_text(point), single_test_text(point), dwell_time_text(point)]
    if finer_scans := finer_scan_text(point):
        lines.append(f"{finer_scans[0].upper()}{finer_scans[1:]}.")
    assumptions = list_assumptions(point.study)
    assumptions_note = f" Assumes {', '.join(assumptions)}." if assumptions else ""
    return "\n".join(
        map(wrap_text, [*filter(None, lines), f"At {inputs_text(point)}; {point_note_text(point)}.{assumptions_note}"])
    )


# roughness counts as negligible if it contributes less than this fraction of the coefficient
NEGLIGIBLE_ROUGHNESS_FRACTION = 0.05


def roughness_text(point: PointSummary) -> str:
    """Return text with the roughness contribution to the coefficient, and the inputs that determine the remainder.

    The text is empty if the contribution is unknown.
    """
    if point.from_roughness is None:
        return ""
    inputs = "the hardness, μ0 and τ0" if point.hardness is not None and point.at["tau0"] > 0 else "μ0"
    is_negligible = abs(point.from_roughness) <= NEGLIGIBLE_ROUGHNESS_FRACTION * point.value
    remainder = f"{inputs} determine{'s' * (inputs == 'μ0')} it" if is_negligible else f"the rest is from {inputs}"
    return f"R{roughness_contribution_text(point)[1:]}; {remainder}."


def contributions_text(point: PointSummary) -> str:
    """Return text with the contributions of mu0, adhesion and slopes to the coefficient, or "" if they are unknown."""
    if point.parts is None:
        return ""
    mu0, adhesion_part, slopes_part = (round(contribution, 3) + 0.0 for contribution in point.parts)
    sign = "\N{MINUS SIGN}" if slopes_part < 0 else "+"
    load_note = "" if math.isclose(mu0, point.at["mu0"], abs_tol=1e-3) else " on the load of the contacts"
    return (
        f"{mu0:.3f} (μ0{load_note}) + {adhesion_part:.3f} (τ0 on the true area) {sign} {abs(slopes_part):.3f} (slopes)"
    )


def uncertainty_budget_text(point: PointSummary) -> str:
    """Return text that names the measurement that would reduce the uncertainty most, and the resulting interval."""
    dominant_input = point.dominant_input
    if dominant_input is None or any(fault.text != WIDE_INTERVAL_TEXT for fault in point.faults):
        return ""
    current_limits, reduced_limits = str(point.rules[0].interval), str(dominant_input.interval)
    if current_limits == reduced_limits:
        return ""
    action_text = _REMEDY_TEXTS.get(dominant_input.words, f"Measuring {dominant_input.words}")
    return f"{action_text} would give [{reduced_limits.replace(' to ', ', ')}]."


_REMEDY_TEXTS = {
    UNATTRIBUTED_WAVELENGTHS_INPUT_NAME: "Scanning one place twice",
    POSITIONS_INPUT_NAME: "Using more positions",
    UNRESOLVED_ROUGHNESS_INPUT_NAME: "A finer scan",
    ALTERNATIVE_LABELS[SPIKES_ALTERNATIVE]: "A scan without spikes",
    ALTERNATIVE_LABELS[TIP_ALTERNATIVE]: "A sharper tip",
    UPPER_SCANS_INPUT_NAME: "Scanning more places of the upper part",
    LOWER_SCANS_INPUT_NAME: "Scanning more places of the lower part",
}  # fmt: skip
"""Actions that reduce the uncertainty from sources other than uncertain inputs."""


def single_test_text(point: PointSummary) -> str:
    """Return text with the prediction interval of a single test and the confidence interval of the mean."""
    estimate = point.rules[0]
    if not math.isfinite(estimate.next_test.lower) or estimate.next_test == estimate.interval:
        return ""
    sampled_items = "positions" if point.scans == (1, 1) else "scans and positions"
    has_sampling_interval = math.isfinite(estimate.positions.lower) and estimate.positions != estimate.interval
    sampling_text = f"; {sampled_items} alone: {estimate.positions}" if has_sampling_interval else ""
    return f"Single test in one direction: {estimate.next_test}{sampling_text}."


def dwell_time_text(point: PointSummary) -> str:
    """Return text with the coefficients after the dwell times of the study, or an empty string without dwell times."""
    estimate_texts = [f"{format_time(aged.seconds)} {aged}" for aged in point.waited]
    ageing_reason = (
        "; none if the hardness falls below the pressure"
        if any(math.isnan(aged_estimate.value) for aged_estimate in point.waited)
        else ""
    )
    rate_text = f"; {format_significant(point.ageing)} for each factor e of time" if math.isfinite(point.ageing) else ""
    return f"After a dwell time: {', '.join(estimate_texts)}{ageing_reason}{rate_text}." if estimate_texts else ""


def assessment_text(
    headlines: Sequence[PointSummary], max_lines: int | None = None, *, max_groups: int | None = None,
    complete_command: str = COMPLETE_OUTPUT_METHOD,
) -> str:  # fmt: skip
    """Format the assessment, the most useful measurement, and the caveats with their remedies.

    Caveats of several points are grouped. At most `max_lines` lines of caveats are printed or, without `max_lines`, at
    most `max_groups` groups. `complete_command` names the option that shows all others.
    """
    if len({(point.verdict, point.caveats) for point in headlines}) == 1:
        point, caveats = headlines[0], headlines[0].caveats
        num_faults = sum(caveat.severity == "fault" for caveat in caveats)
        lines = [_caveat_line(caveat) for caveat in caveats]
        num_shown = (
            len(lines) if max_lines is None else max(_count_texts_fitting_lines(lines, max_lines), num_faults, 1)
        )
        suffix = (
            f". {budget_sentence}"
            if len(headlines) == 1 and not point.is_unloaded and (budget_sentence := uncertainty_budget_text(point))
            else ""
        )
        suffix = suffix or (" a coefficient" if point.is_unloaded else "")
        first_line = wrap_text(f"{point.verdict}{suffix}", hanging_indent="  ")
    else:
        caveat_groups: dict[tuple[str, str], list[Caveat]] = {}
        for caveat in (caveat for point in headlines for caveat in point.caveats):
            caveat_groups.setdefault((caveat.severity, _CAVEAT_NUMBER_PATTERN.sub("", caveat.text)), []).append(caveat)
        lines = [
            _caveat_line(caveat_group[0], f" ({len(caveat_group)} of {len(headlines)})")
            for caveat_group in sorted(
                caveat_groups.values(), key=lambda caveat_group: caveat_group[0].severity != "fault"
            )
        ]
        num_shown = len(lines) if max_groups is None else max_groups
        num_shown = num_shown if max_lines is None else max(_count_texts_fitting_lines(lines, max_lines), 1)
        verdict_counts = [
            (verdict, sum(point.verdict == verdict for point in headlines)) for verdict in VERDICTS_BY_SEVERITY.values()
        ]
        assessments_text = ", ".join(
            f"{verdict} ({count} of {len(headlines)})" for verdict, count in verdict_counts if count
        )
        first_line = wrap_text(f"{assessments_text}.")
    num_omitted = len(lines) - num_shown
    return "\n".join(
        [
            first_line,
            *lines[:num_shown],
            *([f"  {num_omitted} more: {complete_command} shows all"] if num_omitted > 0 else []),
        ]
    )


_CAVEAT_NUMBER_PATTERN = re.compile(r"\d[\d.]* ?(?:%|(?:[kMGmµn]?(?:Pa|N|m|m²)\b))?")
"""Pattern of a number with its unit. Caveats that differ only in numbers are grouped."""


def _count_texts_fitting_lines(texts: Sequence[str], lines: int) -> int:
    """Return how many texts, counted from the first, fit on a given number of lines."""
    return int(np.searchsorted(np.cumsum([text.count("\n") + 1 for text in texts]), lines, side="right"))


MAX_CAVEAT_GROUPS = 6  # maximum number of printed groups of caveats if a result has several points


def _caveat_line(caveat: Caveat, suffix: str = "") -> str:
    marker = "!" if caveat.severity == "fault" else "-"
    return wrap_text(f"{marker} {caveat.text}{suffix}; {caveat.remedy}", indent="  ", hanging_indent="  ")


# ---- Quantities ------------------------------------------------------------------------------------------------------

_VERBOSE_QUANTILES = (("patch_area", 0.5), ("patch_area", 0.9), ("pressure", 0.5), ("pressure", 0.9))


def _first_cell_coordinates_text(headlines: Sequence[PointSummary]) -> str:
    """Return the coordinates of the first cell as text, as in "H = 0.9", or "" if there is only one cell."""
    hidden_coordinates = {
        "load",
        "mu0",
        "tau0",
        *(["fractal_dimension"] if "hurst_exponent" in headlines[0].at else []),
    }
    names = [
        name
        for name in headlines[0].at
        if name not in hidden_coordinates and len({point.at[name] for point in headlines}) > 1
    ]
    return ", ".join(
        f"{_COORDINATE_LABELS.get(name, name)} = {_coordinate_text(name, headlines[0].at[name])}" for name in names
    )


def quantities_text(points: Sequence[PointSummary], *, verbose: bool = False, cell: str = "") -> str:
    """Format means and 95 % intervals of the reported sliding rule, one row per quantity and one column per point."""
    study, rule = points[0].study, points[0].rules[0].rule
    datasets = [point.values.sel(sliding=rule) if "sliding" in point.values.dims else point.values for point in points]
    dataset = datasets[0]
    has_area_fraction = "contact_area_fraction" in dataset and not math.isnan(points[0].nominal_pressure)
    rows: list[list[str]] = []
    is_in_words = len(points) == 1 and study.is_measured and not verbose
    for name in (*quantity_names_shown_in("table"), *(quantity_names_shown_in("verbose") if verbose else ())):
        is_hidden = {
            "mean_pressure": is_in_words,  # not printed, because the printed load and area determine the mean pressure
            "contact_area": has_area_fraction and not verbose, "contact_area_fraction": not has_area_fraction,
            **dict.fromkeys(("closure", "closure_stiffness"), not (verbose or study.is_gap)),
            **dict.fromkeys(LOAD_INDEPENDENT_QUANTITIES, not verbose),
            **dict.fromkeys(STIFFNESS_PER_AREA_QUANTITIES, not has_area_fraction),
        }.get(name, False)  # fmt: skip
        if name in dataset and not is_hidden and dataset[name].sizes.get("direction", 1) == 1:
            label = quantity_label(name, study) + (
                " at least" if name in LOAD_INDEPENDENT_QUANTITIES and is_pull_off_lower_bound(name, dataset) else ""
            )
            rows += _quantity_row(name, label, [values[name] for values in datasets])
            if name == "contact_area_fraction" and rows:
                rows[-1] = _replace_values_by_statuses(rows[-1], [point.contact_status for point in points])
    for name, probability in _VERBOSE_QUANTILES if verbose else ():
        if name in dataset:
            label = f"{QUANTITIES[name].table_label}, {100 * probability:.0f}th percentile"
            rows += _quantity_row(
                name, label, [values[name].sel(fraction_below=probability, method="nearest") for values in datasets]
            )
    if verbose and "rms_gradient" in dataset:
        rows += _quantity_row(
            "rms_gradient", QUANTITIES["rms_gradient"].table_label, [values["rms_gradient"] for values in datasets]
        )
    if is_in_words:
        label = "; ".join(f"{name} {value.removesuffix(' no interval')} {unit}".rstrip() for name, unit, value in rows)
        return wrap_text(f"{label[:1].upper()}{label[1:]}.")
    first_heading = f"{cell}, mean [95 %]" if cell else "mean [95 %]"
    headings = [first_heading, *map(point_load_text, points)]
    columns = [[f"{name} ({unit})" if unit else name, *cells] for name, unit, *cells in rows]
    if len(points) == 1:
        return format_table([headings, *columns])
    return format_table(
        [
            *_wrap_headings([column[0] for column in (headings, *columns)]),
            *zip(headings[1:], *(column[1:] for column in columns), strict=True),
        ]
    )


def _wrap_headings(headings: Sequence[str]) -> TextRows:
    """Wrap column headings into several rows, so that columns are as narrow as their cells."""
    lines = [textwrap.wrap(heading, MAX_HEADING_WIDTH, break_long_words=False) for heading in headings]
    return list(itertools.zip_longest(*lines, fillvalue=""))


MAX_HEADING_WIDTH = 20  # maximum width of the heading of a column of numbers, in characters


def is_pull_off_lower_bound(name: str, dataset: xarray.Dataset) -> bool:
    """Return whether a quantity is a pull-off force or pressure for which some members give only lower bounds."""
    bound_fraction = QUANTITIES[name].bound_fraction
    return bool(bound_fraction) and float(dataset[bound_fraction].sel(statistic="mean").max()) > 0


def _quantity_row(name: str, label: str, estimates: Sequence[xarray.DataArray]) -> list[list[str]]:
    """Return the table row of a quantity in a list, or an empty list if the quantity has no value at any load."""
    values = [value for value in map(_largest_absolute_mean, estimates) if math.isfinite(value)]
    factor, unit_label = choose_prefixed_unit(max(values, default=0.0), QUANTITIES[name].table_unit)
    cells = [_estimate_cell(estimate, factor) for estimate in estimates]
    return [] if set(cells) == {"none"} else [[label, unit_label, *cells]]


def _replace_values_by_statuses(row: list[str], statuses: Sequence[str]) -> list[str]:
    """Return a row of area fractions in which statuses other than "ok" replace the values."""
    label, unit, *cells = row
    cells = [cell if status == friction.STATUS_OK else status for cell, status in zip(cells, statuses, strict=True)]
    return [label, unit if set(cells) - set(statuses) else "", *cells]


def _largest_absolute_mean(estimate: xarray.DataArray) -> float:
    means = estimate.sel(statistic="mean") if "statistic" in estimate.dims else estimate
    return float(np.abs(means).max())


def _estimate_cell(estimate: xarray.DataArray, factor: float) -> str:
    if "statistic" not in estimate.dims:
        value = estimate.item() / factor
        return "none" if math.isnan(value) else format_significant(value)
    if estimate.name == "error":
        largest_error = estimate.sel(statistic="mean").item()
        return "none" if math.isnan(largest_error) else format_significant(largest_error, 1)
    return (read_estimate(estimate) / factor).table_text


def friction_by_axis_text(values: xarray.Dataset, *, verbose: bool = False) -> str:
    """Return a sentence about grooves if friction depends on the axis. `verbose` adds the values along each axis."""
    if "friction_by_axis" not in values or values.sizes.get("axis", 0) < 2:
        return ""
    table = values["friction_by_axis"]
    lay_sentence = lay_text(
        select_sliding_rule(
            table, next(rule for rule in SLIDING_RULE_DESCRIPTIONS if rule in np.atleast_1d(values["sliding"].values))
        )
    )
    if not verbose:
        return wrap_text(lay_sentence) if lay_sentence.startswith("Grooves: friction") else ""
    return _coefficient_table("μ_s along an axis", table, "axis", _direction_label) + "\n" + wrap_text(lay_sentence)


def _coefficient_table(
    title: str, table: xarray.DataArray, dimension: str, format_coordinate: Callable[[float], str]
) -> str:
    """Format coefficients as a table with one row per coordinate and one column per sliding rule."""
    rules = [rule for rule in SLIDING_RULE_DESCRIPTIONS if rule in np.atleast_1d(table["sliding"].values)]
    rows = [[title, *(SLIDING_RULE_TITLES[rule] for rule in rules)]]
    for coordinate in table[dimension].values:
        selected_coefficients = table.sel({dimension: coordinate})
        rows.append(
            [
                format_coordinate(float(coordinate)),
                *(_estimate_cell(select_sliding_rule(selected_coefficients, rule), 1.0) for rule in rules),
            ]
        )
    return format_table(rows)


def _direction_label(degrees: float) -> str:
    return {0.0: "x", 90.0: "y"}.get(degrees, f"{degrees:g}°")


def lay_text(table: xarray.DataArray) -> str:
    """Return a sentence about grooves. Grooves are reported if the intervals along two axes do not overlap."""
    mean, lower, upper = (table.sel(statistic=statistic) for statistic in MEAN_AND_LIMITS)
    if not np.isfinite(lower.values).all():
        return "Grooves: unknown, because the coefficients along the axes have no intervals."
    highest_index, lowest_index = (
        int(find_extreme_index(mean.values)) for find_extreme_index in (np.argmax, np.argmin)
    )
    names = [_direction_label(float(table["axis"][index])) for index in (highest_index, lowest_index)]
    if float(lower[highest_index]) > float(upper[lowest_index]):
        increase = 100 * (float(mean[highest_index]) / float(mean[lowest_index]) - 1)
        return f"Grooves: friction along {names[0]} is {format_significant(increase)} % higher than along {names[1]}."
    return "No grooves: the axes differ by less than their intervals."


def friction_by_direction_text(values: xarray.Dataset) -> str:
    """Format the coefficient in every direction of motion of the upper body."""
    if "direction" not in values.dims:
        return ""
    return _coefficient_table("μ_s, upper body", values["friction_coefficient"], "direction", motion_direction_text)


def history_text(point: PointSummary) -> str:
    """Return text that describes the preparation of the surfaces and the contact model."""
    dataset, study = point.values, point.study
    preparation_steps = {
        name: str(dataset.attrs[name]).replace("\n", "; ") for name in ("upper", "lower") if name in dataset.attrs
    }
    mechanics_texts = {"half-space": "the elastic half-space", "asperities": "asperities without interaction"}
    model_texts = [mechanics_texts[study.contact.mechanics]]
    if "nominal_area" in dataset.coords:
        model_texts.append(f"on a nominal area of {float(dataset['nominal_area']):.4g} µm²")
    if study.contact.mechanics == "asperities" and study.surfaces.kind != "surface":
        model_texts += [str(getattr(study.contact, name)) for name in ("law", "detection", "curvature")]
    preparation_steps["model"] = ", ".join(model_texts)
    return "\n".join(wrap_text(f"{name:<9}{text}", hanging_indent=" " * 9) for name, text in preparation_steps.items())


def preview_text(summary: Summary) -> str:
    """Return a preview line with the friction coefficient computed from the first members of a study."""
    point = summary.points[0]
    rule = SLIDING_RULE_DESCRIPTIONS[point.rules[0].rule]
    return f"preliminary, with asperities: μ_s = {Estimate(point.value)}  {rule}"


# ---- Overview --------------------------------------------------------------------------------------------------------


def overview_text(
    summary: Summary, max_lines: int | None = None, *, complete_command: str = COMPLETE_OUTPUT_METHOD
) -> str:
    """Format the mu_s values of generated surfaces as tables, one per sliding rule and amplitude.

    A table has one row per cell of the study and one column per load, and columns for mu0 and tau0 if the study has
    several values of them. Caveats follow in at most `max_lines` lines; `complete_command` names the option
    that shows all others.
    """
    study, points = summary.study, summary.headlines
    printed_points = _select_overview_points(points)
    varying_names = [name for name in ("mu0", "tau0") if len({point.at[name] for point in printed_points}) > 1]
    tables = [
        _overview_table([point for point in printed_points if point.at["amplitude"] == amplitude], rule, varying_names)
        for amplitude, rule in itertools.product(
            dict.fromkeys(point.at["amplitude"] for point in printed_points), study.contact.sliding_rules()
        )
    ]
    if any("*" in table for table in tables):
        note = "* outside the model: more than half of the load is on overlaps > R/10, or on radii < spacing"
        tables.append(wrap_text(note))
    if omission_note := _omission_text(printed_points, points, study):
        tables.append(wrap_text(omission_note))
    return "\n".join(tables) + f"\n\n{assessment_text(points, max_lines, complete_command=complete_command)}"


# maximum number of rows in an overview; a longer overview shows only a few values of mu0 and tau0
MAX_OVERVIEW_ROWS = 40


def _select_overview_points(points: Sequence[PointSummary]) -> Sequence[PointSummary]:
    """Return the points of an overview. A long overview has only the middle mu0, and the first and last tau0."""
    names = ("mu0", "tau0", *(name for name in CELL_DIMENSIONS if name in points[0].at))
    if len({tuple(point.at[name] for name in names) for point in points}) <= MAX_OVERVIEW_ROWS:
        return points
    mu0, tau0 = (list(dict.fromkeys(point.at[name] for point in points)) for name in ("mu0", "tau0"))
    return [
        point for point in points if point.at["mu0"] == mu0[len(mu0) // 2] and point.at["tau0"] in (tau0[0], tau0[-1])
    ]


def _overview_table(points: Sequence[PointSummary], rule: str, varying_names: Sequence[str]) -> str:
    """Format the coefficients under a sliding rule with one row per mu0, tau0 and cell, and one column per load."""
    row_names = ("mu0", "tau0", "fractal_dimension")
    cells_by_row: dict[tuple[float, ...], list[str]] = {
        key: [] for key in itertools.product(*(dict.fromkeys(point.at[name] for point in points) for name in row_names))
    }
    for point in points:
        cells_by_row[tuple(point.at[name] for name in row_names)].append(_overview_cell(point, rule))
    exponents = {point.at["fractal_dimension"]: point.roughness_exponent[1] for point in points}
    labels = [[*(_COORDINATE_LABELS[name] for name in varying_names), points[0].roughness_exponent[0]]]
    for key in cells_by_row:
        texts = {name: _coordinate_text(name, value) for name, value in zip(row_names, key, strict=True)}
        labels.append([*(texts[name] for name in varying_names), f"{exponents[key[2]]:.4g}"])
    loads = [format_with_unit(load, "mN") for load in dict.fromkeys(point.at["load"] for point in points)]
    column_widths = [max(map(len, column)) for column in zip(*labels, strict=True)]
    rows = [
        ["  ".join(text.ljust(column_width) for text, column_width in zip(label, column_widths, strict=True)), *cells]
        for label, cells in zip(labels, [loads, *cells_by_row.values()], strict=True)
    ]
    return f"{wrap_text(_overview_title(points[0], rule, varying_names))}\n{format_table(rows)}"


def _omission_text(printed_points: Sequence[PointSummary], points: Sequence[PointSummary], study: Study) -> str:
    """Return how many values an overview omits and how to print them, or an empty string if all values are printed."""
    num_values = {name: len({point.at[name] for point in points}) for name in ("fractal_dimension", "mu0", "tau0")}
    num_values["fractal_dimension"] = study.surfaces.cell_coordinates()["fractal_dimension"].size
    count_texts = [
        f"{num_printed} of {num_available} values of "
        f"{points[0].roughness_exponent[0] if name == 'fractal_dimension' else _COORDINATE_LABELS[name]}"
        for name, num_available in num_values.items()
        if (num_printed := len({point.at[name] for point in printed_points})) < num_available
    ]
    return f"Shown: {', '.join(count_texts)}; use stiction at for all." if count_texts else ""


def _overview_title(point: PointSummary, rule: str, varying_names: Sequence[str]) -> str:
    assignment_texts = {
        "mu0": f"μ0 = {point.at['mu0']:g}",
        "tau0": f"τ0 = {_coordinate_text('tau0', point.at['tau0'])}",
    }
    shared_conditions = [text for name, text in assignment_texts.items() if name not in varying_names]
    shared_conditions.append(f"amplitude {format_with_unit(point.at['amplitude'], 'um')}")
    if "sliding" in point.values.coords:
        shared_conditions.append(SLIDING_RULE_DESCRIPTIONS[rule])
    return f"μ_s [95 %] at {', '.join(shared_conditions)}"


def _overview_cell(point: PointSummary, rule: str) -> str:
    values = select_sliding_rule(point.values, rule)
    bad_statuses = [str(status) for status in np.unique(values["status"].values) if status != friction.STATUS_OK]
    if bad_statuses:
        return bad_statuses[0]
    checked_fractions = {
        name: mean_over_directions(values, name) for name in ("share_beyond_hertz", "share_below_grid")
    }
    estimate = next(estimate for estimate in point.rules if estimate.rule == rule)
    return str(estimate) + "*" * any(find_caveats_of_failed_checks(ASPERITY_CHECKS, checked_fractions))
