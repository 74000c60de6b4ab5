"""Format results as text for a terminal: values and assessment first, then one table, at the terminal width."""

from __future__ import annotations

import itertools
import math
import re
import shutil
import textwrap
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

import numpy as np

from stiction._number_format import duration, from_to, prefix, quoted, significant, with_interval, with_unit
from stiction.mechanics import friction
from stiction.mechanics.quantities import HELD, PER_AREA, QUANTITIES, shown_in
from stiction.studies.assessment import ASPERITY_CHECKS, VERDICTS, WIDE_INTERVAL_TEXT, Caveat, apply_checks
from stiction.studies.budget import FINER, LOWER_PIECE, POSITIONS, UPPER_PIECE
from stiction.studies.point import (
    CELL_DIMENSIONS,
    MEAN_AND_ENDS,
    by_rule,
    contact_status_of,
    has_nominal_area,
    is_capped,
    is_unloaded,
    points,
    rules_of,
    shape_coordinate,
    value_of,
)
from stiction.studies.resolution import find_resolved_roughness
from stiction.studies.summary import ORIGIN, PointSummary, Summary
from stiction.views.onset import onset_note, onset_rows, onset_text, quantity_label
from stiction.views.point import RULE_DESCRIPTIONS, load_text, motion_text
from stiction.views.pull_off import pull_off_text
from stiction.views.resolution import ELASTIC, RULE_TITLES, cut_off_note, cut_off_rows, wavelengths_text, yield_rows
from stiction.views.sentence import finer_text, inputs_text, list_assumptions, note_text, slopes_text
from stiction.views.sentence import roughness_text as contribution_text

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

COMPLETE = "summary()"  # method of a result that returns all points and caveats
MIN_TERMINAL_WIDTH = 40  # characters; narrower terminals are treated as this wide
Rows = Sequence[Sequence[str]]


# ---- Layout ----------------------------------------------------------------------------------------------------------


def terminal_width() -> int:
    """Return the number of columns of the terminal."""
    return max(MIN_TERMINAL_WIDTH, shutil.get_terminal_size().columns)


def wrap_text(text: str, width: int | None = None, *, indent: str = "", hang: str = "") -> str:
    """Wrap a paragraph to the width of the terminal."""
    together = _NO_BREAK.sub("\N{NO-BREAK SPACE}", text)
    return textwrap.fill(
        together, width or terminal_width(), initial_indent=indent, subsequent_indent=indent + hang,
        break_long_words=False, break_on_hyphens=False,
    ).replace("\N{NO-BREAK SPACE}", " ")  # fmt: skip


_NO_BREAK = re.compile(r"(?<=[^\s] =) | (?=[=<>] )|(?<=\d) (?=(?:[kmµn]?[NmgL]|[GMk]Pa|%|°)(?!\w))")
"""Spaces where a line must not break: around an equals sign, and between a number and its unit."""


def format_table(rows: Rows, width: int | None = None, *, labels: int = 1) -> str:
    """Format rows as a table with aligned columns, within a width (default: the terminal width).

    Rows may have different lengths. Columns that do not fit are moved to further tables that repeat the first `labels`
    columns. A first column that is too wide is wrapped.
    """
    room = width or terminal_width()
    columns = max(map(len, rows), default=0)
    others = max((len(cell) for row in rows for cell in row[1:]), default=0)
    rows = [line for row in rows for line in _wrap_label(row, max(room - others - 2, MIN_LABEL_WIDTH))]
    sizes = [max(len(row[c]) if c < len(row) else 0 for row in rows) for c in range(columns)]
    blocks, first = [], labels
    while first < max(columns, labels + 1):
        last = first + 1
        while last < columns and sum(2 + size for size in sizes[:labels] + sizes[first : last + 1]) - 2 <= room:
            last += 1
        block = sizes[:labels] + sizes[first:last]
        blocks.append("\n".join(_join_cells([*row[:labels], *row[first:last]], block) for row in rows))
        first = last
    return "\n".join(blocks)


MIN_LABEL_WIDTH = 16  # minimum width of the first column of a table, in characters


def _wrap_label(row: Sequence[str], width: int) -> list[Sequence[str]]:
    """Wrap the first cell of a row to a width and return the resulting rows."""
    lines = textwrap.wrap(row[0], width, subsequent_indent="  ", drop_whitespace=False) if len(row[0]) > width else []
    return [[lines[0].rstrip(), *row[1:]], *([line.rstrip()] for line in lines[1:])] if lines else [row]


def _join_cells(cells: Sequence[str], sizes: Sequence[int]) -> str:
    return "  ".join(cell.ljust(size) for cell, size in zip(cells, sizes, strict=False)).rstrip()


# ---- Any result ------------------------------------------------------------------------------------------------------


def result_text(
    summary: Summary, *, verbose: bool = False, max_lines: int | None = None, complete: str = COMPLETE
) -> str:
    """Return a summary as text for the terminal: values, assessment and a table.

    Parameters
    ----------
    summary : Summary
    verbose : bool
        Whether to add the inputs, every direction and every quantity.
    max_lines : int, optional
        Maximum number of lines for caveats. The first caveat and all faults are always printed; the number of omitted
        caveats is printed.
    complete : str
        Option or method that shows the omitted points and caveats.
    """
    return values_text(summary, verbose=verbose, max_lines=max_lines, complete=complete) + resolution_and_onset_text(
        summary, verbose=verbose
    )


def default_values_text(study: Study, *, mu0: bool, tau0: bool) -> str:
    """Return a line that lists mu0 and tau0 of a study if there are several values; empty otherwise."""
    friction = study.friction
    words = []
    if mu0 and len(friction.mu0) > 1:
        words.append(f"μ0 = {', '.join(f'{value:g}' for value in friction.mu0)} (--mu0)")
    if tau0 and len(friction.tau0) > 1:
        words.append(f"τ0 = {', '.join(_coordinate('tau0', float(value)) for value in friction.tau0)} (--tau0)")
    return wrap_text(f"Values of the study by default: {'; '.join(words)}.") if words else ""


def values_text(
    summary: Summary, *, verbose: bool = False, max_lines: int | None = None, complete: str = COMPLETE
) -> str:
    """Return `result_text` without the cutoff study and the onset of sliding."""
    at, study, headlines = summary.at, summary.study, summary.headlines
    shown = headlines if verbose else _thin_points(headlines)
    first = at.sel({name: headlines[0].at[name] for name in CELL_DIMENSIONS if name in at.dims})
    first = first.sel(load=sorted({point.at["load"] for point in shown}))
    parts = [history_text(at, study)] if verbose else []
    loaded = [point for point in headlines if not point.unloaded]
    sticking = headlines[0].sticking
    varying = [name for name in ("mu0", "tau0") if len({point.at[name] for point in headlines}) > 1]
    inputs = ", ".join(f"{_COORDINATE_LABELS[name]} = {_coordinate(name, headlines[0].at[name])}" for name in varying)
    lines = [wrap_text(pull_off_text(sticking, inputs))] if sticking is not None and sticking.pull_off[0] > 0 else []
    lines += [coefficients_text(shown)] if loaded else []
    if len(shown) < len(headlines):
        lines.append(wrap_text(f"Shown: {len(shown)} of {len(headlines)} points; {complete} shows all."))
    limits = {} if verbose else {"max_lines": max_lines, "max_groups": MAX_CAVEATS}
    parts.append("\n".join([*lines, assessment_text(headlines, complete=complete, **limits)]))
    is_known = any(math.isfinite(point.value) or point.unloaded for point in headlines)
    quantities = quantities_text(first, study, verbose=verbose, cell=_first_cell(headlines)) if is_known else ""
    details = _conditions_text(headlines[0]) if len(headlines) == 1 else ""
    if verbose:
        parts += [details, wrap_text(slopes_text(headlines[0])), quantities]
    else:
        parts.append("\n".join(filter(None, (details, quantities))))
    if is_known and (values := next((loaded for loaded in points(first) if not is_unloaded(loaded)), None)) is not None:
        parts += [axes_text(values, verbose=verbose), directions_text(values) if verbose else ""]
    return "\n\n".join(part for part in parts if part) + "\n"


def resolution_and_onset_text(summary: Summary, *, verbose: bool = False) -> str:
    """Return the cutoff study and the onset of sliding as text after an empty line; empty if there are none."""
    at, study, over, onset = summary.at, summary.study, summary.over_cut_offs, summary.onset
    parts = []
    is_over = at.sizes.get("cut_off", 0) > 1
    if any(math.isfinite(point.value) for point in summary.points):
        if verbose:
            first = at.isel({name: 0 for name in CELL_DIMENSIONS if name in at.dims})
            parts.append(resolution_text(first, study, at if over is None and is_over else over))
        if onset is not None and verbose:
            text = f"{onset_text(onset)} {onset_note(onset)}"
            parts.append(f"{wrap_text(text)}\n{format_table(onset_rows(onset))}")
        elif onset is not None:
            parts.append(wrap_text(onset_text(onset)))
    return "".join(f"\n{part}\n" if verbose else f"{part}\n" for part in parts if part)


def coefficients_text(headlines: Sequence[PointSummary]) -> str:
    """Format the coefficients: one line per rule for a single point, otherwise a table with the varying inputs."""
    if len(headlines) == 1:
        words = (
            f"{_coefficient(headlines[0], index)}  {RULE_DESCRIPTIONS[rule.rule]}"
            for index, rule in enumerate(headlines[0].rules)
        )
        lines = [wrap_text(f"{'      ' if i else 'μ_s = '}{line}", hang=" " * 8) for i, line in enumerate(words)]
        return "\n".join(filter(None, [*lines, wrap_text(roughness_text(headlines[0]))]))
    names = [name for name in headlines[0].at if name != "fractal_dimension" or "hurst_exponent" not in headlines[0].at]
    names.sort(key=lambda name: name != "hurst_exponent")
    varying = [name for name in names if len({point.at[name] for point in headlines}) > 1]
    titles = (f"μ_s {RULE_TITLES[rule.rule]}" for rule in headlines[0].rules)
    rows = [[*(_COORDINATE_LABELS.get(name, name) for name in varying), *titles, "assessment"]]
    for point in headlines:
        values = [_coefficient(point, index) for index in range(len(point.rules))]
        places = [
            load_text(point.values, point.study) if name == "load" else _coordinate(name, point.at[name])
            for name in varying
        ]
        rows.append([*places, *values, point.verdict])
    inputs = [inputs_text(point).split(", ") for point in headlines]
    same = [word for word in inputs[0] if all(word in other for other in inputs)]
    shared = f"with {', '.join(same)}; " if same else ""
    assumptions = list_assumptions(headlines[0].study)
    assumed = f"; assuming {', '.join(assumptions)}" if assumptions else ""
    return (
        format_table(rows, labels=len(varying))
        + "\n"
        + wrap_text(f"{shared}{note_text(headlines[0])}{assumed}", indent="  ")
    )


def _thin_points(headlines: Sequence[PointSummary]) -> Sequence[PointSummary]:
    """Return at most `MAX_POINTS` points, at evenly spaced values of each coordinate including first and last."""
    values = {name: list(dict.fromkeys(point.at[name] for point in headlines)) for name in headlines[0].at}
    if "hurst_exponent" in values:
        values.pop("fractal_dimension", None)
    counts = {name: len(coordinates) for name, coordinates in values.items()}
    while math.prod(counts.values()) > MAX_POINTS:
        counts[max(reversed(counts), key=lambda name: counts[name])] -= 1
    if counts == {name: len(coordinates) for name, coordinates in values.items()}:
        return headlines
    kept = {
        name: {coordinates[index] for index in np.linspace(0, len(coordinates) - 1, counts[name]).round().astype(int)}
        for name, coordinates in values.items()
    }
    return [point for point in headlines if all(point.at[name] in kept[name] for name in kept)]


MAX_POINTS = 15  # rows of the table of several points on the first screen


def _coefficient(point: PointSummary, index: int) -> str:
    rule = point.rules[index]
    if math.isfinite(rule.value):
        return quoted(rule.value, rule.lower, rule.upper)
    return "none" if point.status == friction.STATUS_OK else point.status


_COORDINATE_LABELS = {"fractal_dimension": "D", "hurst_exponent": "H", "mu0": "μ0", "tau0": "τ0", "cut_off": "cut-off"}
_COORDINATE_UNITS = {"load": "mN", "tau0": "GPa", "amplitude": "um", "cut_off": "um"}


def _coordinate(name: str, value: float) -> str:
    if name == "cut_off" and value == 0:
        return "none"
    return with_unit(value, _COORDINATE_UNITS[name]) if name in _COORDINATE_UNITS and value else f"{value:.4g}"


def _conditions_text(point: PointSummary) -> str:
    lines = [] if point.unloaded else [parts_text(point), single_test_text(point), dwell_time_text(point)]
    if finer := finer_text(point):
        lines.append(f"{finer[0].upper()}{finer[1:]}.")
    assumptions = list_assumptions(point.study)
    assumed = f" Assumes {', '.join(assumptions)}." if assumptions else ""
    return "\n".join(map(wrap_text, [*filter(None, lines), f"At {inputs_text(point)}; {note_text(point)}.{assumed}"]))


NEGLIGIBLE_FRACTION = 0.05  # fraction of the coefficient below which roughness is called negligible


def roughness_text(point: PointSummary) -> str:
    """Return the contribution of roughness and the inputs that determine the rest; empty if unknown."""
    if point.from_roughness is None:
        return ""
    inputs = "the hardness, μ0 and τ0" if point.hardness is not None and point.at["tau0"] > 0 else "μ0"
    decides = abs(point.from_roughness) <= NEGLIGIBLE_FRACTION * point.value
    remainder = f"{inputs} determine{'s' * (inputs == 'μ0')} it" if decides else f"the rest is from {inputs}"
    return f"R{contribution_text(point)[1:]}; {remainder}."


def parts_text(point: PointSummary) -> str:
    """Return the contributions of mu0, adhesion and slopes to the coefficient; empty if unknown."""
    if point.parts is None:
        return ""
    mu0, adhesion, slopes = (round(part, 3) + 0.0 for part in point.parts)
    sign = "\N{MINUS SIGN}" if slopes < 0 else "+"
    more = "" if math.isclose(mu0, point.at["mu0"], abs_tol=1e-3) else " on the load of the contacts"
    return f"{mu0:.3f} (μ0{more}) + {adhesion:.3f} (τ0 on the true area) {sign} {abs(slopes):.3f} (slopes)"


def budget_text(point: PointSummary) -> str:
    """Return the most useful measurement and the interval that it would give."""
    largest = point.most
    if largest is None or any(fault.text != WIDE_INTERVAL_TEXT for fault in point.faults):
        return ""
    current, reduced = (
        from_to(low, high) for low, high in ((point.lower, point.upper), (largest.lower, largest.upper))
    )
    if current == reduced:
        return ""
    action = _ACTIONS.get(largest.words, f"Measuring {largest.words}")
    return f"{action} would give [{reduced.replace(' to ', ', ')}]."


_ACTIONS = {
    ORIGIN: "Scanning one place twice", POSITIONS: "Using more positions", FINER: "A finer scan",
    UPPER_PIECE: "Scanning more places of the upper part", LOWER_PIECE: "Scanning more places of the lower part",
}  # fmt: skip
"""Actions that reduce the uncertainty of contributions that are not inputs."""


def single_test_text(point: PointSummary) -> str:
    """Return the prediction interval for a single test and the sampling interval of the mean."""
    first = point.rules[0]
    if not math.isfinite(first.next_test[0]) or first.next_test == (first.lower, first.upper):
        return ""
    sampled_items = "positions" if point.scans == (1, 1) else "scans and positions"
    selected = math.isfinite(first.positions[0]) and first.positions != (first.lower, first.upper)
    sampling_text = f"; {sampled_items} alone: {from_to(*first.positions)}" if selected else ""
    return f"Single test in one direction: {from_to(*first.next_test)}{sampling_text}."


def dwell_time_text(point: PointSummary) -> str:
    """Return the coefficient after the dwell times of the study; empty without dwell times."""
    entries = [f"{duration(aged.seconds)} {quoted(aged.value, aged.lower, aged.upper)}" for aged in point.waited]
    reason = (
        "; none if the hardness falls below the pressure"
        if any(math.isnan(aged.value) for aged in point.waited)
        else ""
    )
    rate = f"; {significant(point.ageing)} for each factor e of time" if math.isfinite(point.ageing) else ""
    return f"After a dwell time: {', '.join(entries)}{reason}{rate}." if entries else ""


def assessment_text(
    headlines: Sequence[PointSummary], max_lines: int | None = None, *, max_groups: int | None = None,
    complete: str = COMPLETE,
) -> str:  # fmt: skip
    """Format the assessment, the most useful measurement and the caveats with their remedies.

    Caveats of several points are grouped. At most `max_lines` lines of caveats, and at most `max_groups` groups without
    `max_lines`, are printed; `complete` names what shows the others.
    """
    if len({(point.verdict, point.caveats) for point in headlines}) == 1:
        point, caveats = headlines[0], headlines[0].caveats
        faults = sum(caveat.severity == "fault" for caveat in caveats)
        lines = [_caveat_line(caveat) for caveat in caveats]
        num_shown = len(lines) if max_lines is None else max(_count_within(lines, max_lines), faults, 1)
        suffix = f". {words}" if len(headlines) == 1 and not point.unloaded and (words := budget_text(point)) else ""
        suffix = suffix or (" a coefficient" if point.unloaded else "")
        first = wrap_text(f"{point.verdict}{suffix}", hang="  ")
    else:
        groups: dict[tuple[str, str], list[Caveat]] = {}
        for caveat in (caveat for point in headlines for caveat in point.caveats):
            groups.setdefault((caveat.severity, _AMOUNT.sub("", caveat.text)), []).append(caveat)
        lines = [
            _caveat_line(group[0], f" ({len(group)} of {len(headlines)})")
            for group in sorted(groups.values(), key=lambda group: group[0].severity != "fault")
        ]
        num_shown = len(lines) if max_groups is None else max_groups
        num_shown = num_shown if max_lines is None else max(_count_within(lines, max_lines), 1)
        counts = [(verdict, sum(point.verdict == verdict for point in headlines)) for verdict in VERDICTS.values()]
        assessed = ", ".join(f"{verdict} ({count} of {len(headlines)})" for verdict, count in counts if count)
        first = wrap_text(f"{assessed}.")
    omitted = len(lines) - num_shown
    return "\n".join([first, *lines[:num_shown], *([f"  {omitted} more: {complete} shows all"] if omitted > 0 else [])])


_AMOUNT = re.compile(r"\d[\d.]* ?(?:%|(?:[kMGmµn]?(?:Pa|N|m|m²)\b))?")
"""Number and unit. Caveats that differ only in numbers are grouped."""


def _count_within(texts: Sequence[str], lines: int) -> int:
    """Return how many leading texts fit on a number of lines."""
    return int(np.searchsorted(np.cumsum([text.count("\n") + 1 for text in texts]), lines, side="right"))


MAX_CAVEATS = 6  # groups of caveats of several points on the first screen


def _caveat_line(caveat: Caveat, suffix: str = "") -> str:
    mark = "!" if caveat.severity == "fault" else "-"
    return wrap_text(f"{mark} {caveat.text}{suffix}; {caveat.cure}", indent="  ", hang="  ")


# ---- Quantities ------------------------------------------------------------------------------------------------------

_VERBOSE_QUANTILES = (("patch_area", 0.5), ("patch_area", 0.9), ("pressure", 0.5), ("pressure", 0.9))
_UNIT_SCALES: dict[str, tuple[tuple[float, float, str], ...]] = {
    "um^2": ((1e5, 1e-6, "mm²"), (0.0, 1.0, "µm²")),
    "mN/um": ((1e4, 1e-3, "N/µm"), (0.0, 1.0, "mN/µm")),
    "MPa/mm": ((1e7, 1e-6, "TPa/mm"), (1e4, 1e-3, "GPa/mm"), (0.0, 1.0, "MPa/mm")),
    "GPa/mm": ((1e4, 1e-3, "TPa/mm"), (0.0, 1.0, "GPa/mm")),
}
"""Minimum value, factor and name of units without SI prefixes, for large numbers."""


def _first_cell(headlines: Sequence[PointSummary]) -> str:
    """Return the coordinates of the first of several cells, such as "H = 0.9"; empty for a single cell."""
    hidden = {"load", "mu0", "tau0", *(["fractal_dimension"] if "hurst_exponent" in headlines[0].at else [])}
    names = [
        name for name in headlines[0].at if name not in hidden and len({point.at[name] for point in headlines}) > 1
    ]
    return ", ".join(
        f"{_COORDINATE_LABELS.get(name, name)} = {_coordinate(name, headlines[0].at[name])}" for name in names
    )


def quantities_text(at: xarray.Dataset, study: Study, *, verbose: bool = False, cell: str = "") -> str:
    """Format means and 95 % intervals: a row for each quantity and a column for each load, with the default rule."""
    dataset = at.isel({name: 0 for name in ("mu0", "tau0") if name in at.dims})
    dataset = dataset.sel(sliding=rules_of(study)[0]) if "sliding" in dataset.dims else dataset
    loads = list(points(dataset))
    fraction = "contact_area_fraction" in dataset and has_nominal_area(loads[0], study)
    rows: list[list[str]] = []
    in_words = len(loads) == 1 and study.is_measured and not verbose
    for name in (*shown_in("table"), *(shown_in("verbose") if verbose else ())):
        hidden = {
            "mean_pressure": in_words,  # load divided by area, both of which are printed
            "contact_area": fraction and not verbose, "contact_area_fraction": not fraction,
            **dict.fromkeys(("closure", "closure_stiffness"), not (verbose or study.is_gap)),
            **dict.fromkeys(HELD, not verbose),
            **dict.fromkeys(PER_AREA, not fraction),
        }.get(name, False)  # fmt: skip
        if name in dataset and not hidden and dataset[name].sizes.get("direction", 1) == 1:
            words = quantity_label(name, study) + (
                " at least" if name in HELD and pull_off_is_bound(name, dataset) else ""
            )
            rows += _row(name, words, [point[name] for point in loads])
            if name == "contact_area_fraction" and rows:
                rows[-1] = _with_statuses(rows[-1], [contact_status_of(point, study) for point in loads])
    for name, below in _VERBOSE_QUANTILES if verbose else ():
        if name in dataset:
            words = f"{QUANTITIES[name].short}, {100 * below:.0f}th percentile"
            rows += _row(name, words, [point[name].sel(fraction_below=below, method="nearest") for point in loads])
    if verbose and "rms_gradient" in dataset:
        rows += _row("rms_gradient", QUANTITIES["rms_gradient"].short, [point["rms_gradient"] for point in loads])
    if in_words:
        words = "; ".join(f"{name} {value.removesuffix(' no interval')} {unit}".rstrip() for name, unit, value in rows)
        return wrap_text(f"{words[:1].upper()}{words[1:]}.")
    heading = f"{cell}, mean [95 %]" if cell else "mean [95 %]"
    names = [heading, *(load_text(point, study) for point in loads)]
    columns = [[f"{name} ({unit})" if unit else name, *cells] for name, unit, *cells in rows]
    if len(loads) == 1:
        return format_table([names, *columns])
    return format_table(
        [
            *_stack_headings([column[0] for column in (names, *columns)]),
            *zip(names[1:], *(column[1:] for column in columns), strict=True),
        ]
    )


def _stack_headings(heads: Sequence[str]) -> Rows:
    """Wrap column headings into several rows, so that columns are as narrow as their cells."""
    lines = [textwrap.wrap(head, MAX_HEADING_WIDTH, break_long_words=False) for head in heads]
    return list(itertools.zip_longest(*lines, fillvalue=""))


MAX_HEADING_WIDTH = 20  # characters of a heading above a column of numbers


def pull_off_is_bound(name: str, at: xarray.Dataset) -> bool:
    """Return whether a quantity is a pull-off force or pressure to which members contribute lower bounds."""
    fraction = QUANTITIES[name].bound_fraction
    return bool(fraction) and float(at[fraction].sel(statistic="mean").max()) > 0


def _row(name: str, words: str, tables: Sequence[xarray.DataArray]) -> list[list[str]]:
    """Return a row with name, unit and a cell for each load, or no row if no load has a value."""
    unit = QUANTITIES[name].unit
    if unit in ("um", "GPa", "mN"):
        values = [value for value in map(_largest, tables) if math.isfinite(value)]
        core, shown = prefix(max(values, default=1.0), unit)
        factor = 1 / core
    else:
        largest = max((value for value in map(_largest, tables) if math.isfinite(value)), default=0.0)
        scales = ((0.0, 100.0, "%"),) if QUANTITIES[name].percent else _UNIT_SCALES.get(unit, ((0.0, 1.0, ""),))
        factor, shown = next((factor, name) for least, factor, name in scales if largest >= least)
    cells = [_cell(table, factor) for table in tables]
    return [] if set(cells) == {"none"} else [[words, shown, *cells]]


def _with_statuses(row: list[str], statuses: Sequence[str]) -> list[str]:
    """Return a row of area fractions with the status instead of a value unless the status is ok."""
    name, unit, *cells = row
    cells = [cell if status == friction.STATUS_OK else status for cell, status in zip(cells, statuses, strict=True)]
    return [name, unit if set(cells) - set(statuses) else "", *cells]


def _largest(table: xarray.DataArray) -> float:
    means = table.sel(statistic="mean") if "statistic" in table.dims else table
    return float(np.abs(means).max())


def _cell(table: xarray.DataArray, factor: float) -> str:
    if "statistic" not in table.dims:
        value = factor * table.item()
        return "none" if math.isnan(value) else significant(value)
    if table.name == "error":
        worst = table.sel(statistic="mean").item()
        return "none" if math.isnan(worst) else significant(worst, 1)
    return with_interval(*(factor * table.sel(statistic=statistic).item() for statistic in MEAN_AND_ENDS))


def axes_text(values: xarray.Dataset, *, verbose: bool = False) -> str:
    """Return whether friction depends on the axis, and with `verbose` or grooves the coefficient along each axis."""
    if "friction_by_axis" not in values or values.sizes.get("axis", 0) < 2:
        return ""
    table = values["friction_by_axis"]
    lay = lay_text(
        by_rule(table, next(rule for rule in RULE_DESCRIPTIONS if rule in np.atleast_1d(values["sliding"].values)))
    )
    if not verbose:
        return wrap_text(lay) if lay.startswith("Grooves: friction") else ""
    return _rules_table("μ_s along an axis", table, "axis", _axis_name) + "\n" + wrap_text(lay)


def _rules_table(title: str, table: xarray.DataArray, along: str, name: Callable[[float], str]) -> str:
    """Format coefficients: a row for each coordinate along a dimension and a column for each sliding rule."""
    rules = [rule for rule in RULE_DESCRIPTIONS if rule in np.atleast_1d(table["sliding"].values)]
    rows = [[title, *(RULE_TITLES[rule] for rule in rules)]]
    for place in table[along].values:
        selected = table.sel({along: place})
        rows.append([name(float(place)), *(_cell(by_rule(selected, rule), 1.0) for rule in rules)])
    return format_table(rows)


def _axis_name(degrees: float) -> str:
    return {0.0: "x", 90.0: "y"}.get(degrees, f"{degrees:g}°")


def lay_text(table: xarray.DataArray) -> str:
    """Return a sentence on grooves: the surfaces have grooves if the intervals of two axes do not overlap."""
    mean, lower, upper = (table.sel(statistic=statistic) for statistic in MEAN_AND_ENDS)
    if not np.isfinite(lower.values).all():
        return "Grooves: unknown, because the coefficients along the axes have no intervals."
    high, low = (int(choose(mean.values)) for choose in (np.argmax, np.argmin))
    names = [_axis_name(float(table["axis"][place])) for place in (high, low)]
    if float(lower[high]) > float(upper[low]):
        more = 100 * (float(mean[high]) / float(mean[low]) - 1)
        return f"Grooves: friction along {names[0]} is {significant(more)} % higher than along {names[1]}."
    return "No grooves: the axes differ by less than their intervals."


def directions_text(values: xarray.Dataset) -> str:
    """Format the coefficient in every direction of motion of the upper body."""
    if "direction" not in values.dims:
        return ""
    return _rules_table("μ_s, upper body", values["friction_coefficient"], "direction", motion_text)


def resolution_text(at: xarray.Dataset, study: Study, over: xarray.Dataset | None) -> str:
    """Format the resolved wavelengths, the cutoff study of the first point, and the effect of a hardness.

    `at` is a result of `at_load`, `over` a result of `resolution_at`.
    """
    scan, parts = find_resolved_roughness(study), []
    if scan is not None:
        parts.append(wrap_text(wavelengths_text(scan)))
    if over is not None:
        first = over.isel(dict.fromkeys(("load", "mu0", "tau0"), 0))
        parts.append(
            format_table(cut_off_rows(first, study)) + "\n" + wrap_text(cut_off_note(first, study), indent="  ")
        )
    capped = is_capped(study) or not study.uses_half_space
    if scan is not None and not capped and (rows := yield_rows(next(points(at)), study, scan)):
        parts.append(wrap_text(ELASTIC) + "\n" + format_table(rows))
    return "\n\n".join(parts)


def history_text(at: xarray.Dataset, study: Study) -> str:
    """Return the preparation of the surfaces and the contact model."""
    steps = {name: str(at.attrs[name]).replace("\n", "; ") for name in ("upper", "lower") if name in at.attrs}
    mechanics = {"half-space": "the elastic half-space", "asperities": "asperities without interaction"}
    model = [mechanics[study.contact.mechanics]]
    if "nominal_area" in at.coords:
        model.append(f"on a nominal area of {float(at['nominal_area']):.4g} µm²")
    if study.contact.mechanics == "asperities" and study.surfaces.kind != "surface":
        model += [str(getattr(study.contact, name)) for name in ("law", "detection", "curvature")]
    steps["model"] = ", ".join(model)
    return "\n".join(wrap_text(f"{name:<9}{words}", hang=" " * 9) for name, words in steps.items())


def preview_text(summary: Summary) -> str:
    """Return a line with the coefficient from the first members of a preview study."""
    point = summary.points[0]
    return f"preliminary, with asperities: μ_s = {quoted(point.value)}  {RULE_DESCRIPTIONS[point.rules[0].rule]}"


# ---- Overview --------------------------------------------------------------------------------------------------------


def overview_text(summary: Summary, max_lines: int | None = None, *, complete: str = COMPLETE) -> str:
    """Format tables of mu_s of generated surfaces, one table for each sliding rule and amplitude.

    A table has a row for each cell of the study and a column for each load, and columns for mu0 and tau0 if the study
    has several values. Caveats follow, in at most `max_lines` lines; `complete` shows the others.
    """
    at, study, headlines = summary.at, summary.study, summary.headlines
    chosen = at if _count_rows(at) <= MAX_OVERVIEW_ROWS else _ends_and_middle(at)
    all_values, at = at, chosen
    remainder = [name for name in ("amplitude", "sliding") if name in at.dims]
    varying = [name for name in ("mu0", "tau0") if at.sizes[name] > 1]
    tables, marked = [], False
    for place in np.ndindex(*(at.sizes[name] for name in remainder)):
        part = at.isel(dict(zip(remainder, place, strict=True)))
        labels = [[*(_COORDINATE_LABELS[name] for name in varying), shape_coordinate(study, 1.0)[0]]]
        rows = [[with_unit(load, "mN") for load in at["load"].values.tolist()]]
        for mu0, tau0, cell in np.ndindex(*(at.sizes[name] for name in ("mu0", "tau0", "fractal_dimension"))):
            selected = part.isel(mu0=mu0, tau0=tau0, fractal_dimension=cell)
            values = [_coordinate(name, float(selected[name])) for name in varying]
            labels.append([*values, f"{shape_coordinate(study, float(selected['fractal_dimension']))[1]:.4g}"])
            rows.append([_overview_cell(selected.isel(load=index)) for index in range(at.sizes["load"])])
        marked = marked or any(cell.endswith("*") for row in rows for cell in row)
        sizes = [max(map(len, column)) for column in zip(*labels, strict=True)]
        names = ["  ".join(text.ljust(size) for text, size in zip(row, sizes, strict=True)) for row in labels]
        table = format_table([[name, *cells] for name, cells in zip(names, rows, strict=True)])
        tables.append(f"{wrap_text(_overview_title(part, varying))}\n{table}")
    if marked:
        note = "* outside the model: more than half of the load is on overlaps > R/10, or on radii < spacing"
        tables.append(wrap_text(note))
    if left_out := _omission_text(at, all_values, study):
        tables.append(wrap_text(left_out))
    return "\n".join(tables) + f"\n\n{assessment_text(headlines, max_lines, complete=complete)}"


MAX_OVERVIEW_ROWS = 40  # rows of an overview; a longer overview is limited to a few values of mu0 and tau0


def _count_rows(at: xarray.Dataset) -> int:
    return math.prod(at.sizes.get(name, 1) for name in ("mu0", "tau0", *CELL_DIMENSIONS))


def _ends_and_middle(at: xarray.Dataset) -> xarray.Dataset:
    """Select the middle mu0 and the first and last tau0."""
    return at.isel(mu0=[at.sizes["mu0"] // 2], tau0=sorted({0, at.sizes["tau0"] - 1}))


def _omission_text(at: xarray.Dataset, complete: xarray.Dataset, study: Study) -> str:
    """Return how many values an overview omits and how to print them; empty if none."""
    every = study.surfaces.cells()["fractal_dimension"].size
    sizes = {
        shape_coordinate(study, 1.0)[0]: (at.sizes["fractal_dimension"], every),
        "μ0": (at.sizes["mu0"], complete.sizes["mu0"]), "τ0": (at.sizes["tau0"], complete.sizes["tau0"]),
    }  # fmt: skip
    words = [f"{shown} of {number} values of {name}" for name, (shown, number) in sizes.items() if shown < number]
    return f"Shown: {', '.join(words)}; use stiction at for all." if words else ""


def _overview_title(part: xarray.Dataset, varying: Sequence[str]) -> str:
    given = {"mu0": f"μ0 = {float(part['mu0'][0]):g}", "tau0": f"τ0 = {_coordinate('tau0', float(part['tau0'][0]))}"}
    words = [text for name, text in given.items() if name not in varying]
    if "amplitude" in part.coords and part["amplitude"].ndim == 0:
        words.append(f"amplitude {with_unit(float(part['amplitude']), 'um')}")
    if "sliding" in part.coords and part["sliding"].ndim == 0:
        words.append(RULE_DESCRIPTIONS[str(part["sliding"].values)])
    return f"μ_s [95 %] at {', '.join(words)}" if words else "μ_s [95 %]"


def _overview_cell(values: xarray.Dataset) -> str:
    statuses = np.unique(np.atleast_1d(values["status"].values))
    bad = [str(status) for status in statuses if status != friction.STATUS_OK]
    if bad:
        return bad[0]
    name = "friction_all_round" if "friction_all_round" in values else "friction_coefficient"
    numbers = {name: value_of(values, name) for name in ("share_beyond_hertz", "share_below_grid")}
    beyond = apply_checks(ASPERITY_CHECKS, numbers)
    mean, lower, upper = (float(values[name].sel(statistic=statistic)) for statistic in MEAN_AND_ENDS)
    return quoted(mean, lower, upper) + "*" * any(beyond)
