"""Results as text for a terminal: the answer first, then one table, at the width that the reader has."""

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
from stiction.studies.assessment import OF_ASPERITIES, VERDICTS, WIDE_INTERVAL, Doubt, doubted
from stiction.studies.budget import FINER, LOWER_PIECE, POSITIONS, UPPER_PIECE
from stiction.studies.point import (
    CELLS,
    STATISTICS,
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
from stiction.studies.resolution import seen
from stiction.studies.summary import ORIGIN, PointSummary, Summary
from stiction.views.onset import onset_note, onset_rows, onset_text, words_of
from stiction.views.point import RULES, load_text, way_text
from stiction.views.pull_off import sticking_text
from stiction.views.resolution import ELASTIC, RULE_TITLES, cut_off_note, cut_off_rows, waves_text, yielding_rows
from stiction.views.sentence import assumptions_of, finer_text, inputs_text, note_text, slopes_text
from stiction.views.sentence import roughness_text as contribution_text

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

LEAST_WIDTH = 40  # columns below which nothing is made narrower
Rows = Sequence[Sequence[str]]


# ---- Layout ----------------------------------------------------------------------------------------------------------


def width_of_terminal() -> int:
    """Columns of the terminal, or what the environment says."""
    return max(LEAST_WIDTH, shutil.get_terminal_size().columns)


def fitted(text: str, width: int | None = None, *, indent: str = "", hang: str = "") -> str:
    """Text of one paragraph, filled to the width of the terminal."""
    together = _TOGETHER.sub("\N{NO-BREAK SPACE}", text)
    return textwrap.fill(
        together, width or width_of_terminal(), initial_indent=indent, subsequent_indent=indent + hang,
        break_long_words=False, break_on_hyphens=False,
    ).replace("\N{NO-BREAK SPACE}", " ")  # fmt: skip


_TOGETHER = re.compile(r"(?<=[^\s] =) | (?=[=<>] )|(?<=\d) (?=(?:[kmµn]?[NmgL]|[GMk]Pa|%|°)(?!\w))")
"""Spaces at which no line ends: around an equals sign, and between a number and its unit."""


def aligned(rows: Rows, width: int | None = None, *, labels: int = 1) -> str:
    """A table whose columns are aligned and which fits a width, that of the terminal by default; rows may be short.

    Columns that do not fit go into further tables below, each with the first `labels` columns again. The cells of a
    first column that is too wide go on in the next line.
    """
    room = width or width_of_terminal()
    columns = max(map(len, rows), default=0)
    others = max((len(cell) for row in rows for cell in row[1:]), default=0)
    rows = [each for row in rows for each in _in_lines(row, max(room - others - 2, LEAST_LABEL))]
    sizes = [max(len(row[c]) if c < len(row) else 0 for row in rows) for c in range(columns)]
    blocks, first = [], labels
    while first < max(columns, labels + 1):
        last = first + 1
        while last < columns and sum(2 + size for size in sizes[:labels] + sizes[first : last + 1]) - 2 <= room:
            last += 1
        block = sizes[:labels] + sizes[first:last]
        blocks.append("\n".join(_line([*row[:labels], *row[first:last]], block) for row in rows))
        first = last
    return "\n".join(blocks)


LEAST_LABEL = 16  # columns of the first column of a table, however wide the others are


def _in_lines(row: Sequence[str], width: int) -> list[Sequence[str]]:
    """A row whose first cell is no wider than this, in as many lines as it takes."""
    lines = textwrap.wrap(row[0], width, subsequent_indent="  ", drop_whitespace=False) if len(row[0]) > width else []
    return [[lines[0].rstrip(), *row[1:]], *([line.rstrip()] for line in lines[1:])] if lines else [row]


def _line(cells: Sequence[str], sizes: Sequence[int]) -> str:
    return "  ".join(cell.ljust(size) for cell, size in zip(cells, sizes, strict=False)).rstrip()


# ---- Any result ------------------------------------------------------------------------------------------------------


def result_text(summary: Summary, *, verbose: bool = False, most: int | None = None) -> str:
    """Return a summary as text for the terminal: values, assessment and a table.

    Parameters
    ----------
    summary : Summary
    verbose : bool
        Whether to add what was pressed, each direction and every quantity.
    most : int, optional
        Lines that caveats may take, beside the first one and all faults; the others are counted.
    """
    return answer_text(summary, verbose=verbose, most=most) + beside_text(summary, verbose=verbose)


def own_values_text(study: Study, *, mu0: bool, tau0: bool) -> str:
    """Return a line with the mu0 and tau0 of a study of which several are used; empty if each is a single value."""
    friction = study.friction
    words = []
    if mu0 and len(friction.mu0) > 1:
        words.append(f"μ0 = {', '.join(f'{each:g}' for each in friction.mu0)} (--mu0)")
    if tau0 and len(friction.tau0) > 1:
        words.append(f"τ0 = {', '.join(_coordinate('tau0', float(each)) for each in friction.tau0)} (--tau0)")
    return fitted(f"Values of the study, unless others are given: {'; '.join(words)}.") if words else ""


def answer_text(summary: Summary, *, verbose: bool = False, most: int | None = None) -> str:
    """Return `result_text` without resolution and onset of sliding."""
    at, study, found = summary.at, summary.study, summary.headlines
    first = at.sel({name: found[0].at[name] for name in CELLS if name in at.dims})
    parts = [history_text(at, study)] if verbose else []
    loaded = [one for one in found if not one.unloaded]
    sticking = found[0].sticking
    varying = [name for name in ("mu0", "tau0") if len({one.at[name] for one in found}) > 1]
    inputs = ", ".join(f"{_TITLES[name]} = {_coordinate(name, found[0].at[name])}" for name in varying)
    lines = [fitted(sticking_text(sticking, inputs))] if sticking is not None and sticking.pull_off[0] > 0 else []
    lines += [answers_text(found)] if loaded else []
    parts.append("\n".join([*lines, doubts_text(found, None if verbose else most)]))
    is_known = any(math.isfinite(one.value) or one.unloaded for one in found)
    quantities = quantities_text(first, study, verbose=verbose, cell=_first_cell(found)) if is_known else ""
    details = _details(found[0]) if len(found) == 1 else ""
    if verbose:
        parts += [details, fitted(slopes_text(found[0])), quantities]
    else:
        parts.append("\n".join(filter(None, (details, quantities))))
    if is_known and (point := next((each for each in points(first) if not is_unloaded(each)), None)) is not None:
        parts += [axes_text(point, verbose=verbose), directions_text(point) if verbose else ""]
    return "\n\n".join(part for part in parts if part) + "\n"


def beside_text(summary: Summary, *, verbose: bool = False) -> str:
    """Return resolution and onset of sliding as text, after an empty line; nothing where there is none."""
    at, study, over, onset = summary.at, summary.study, summary.over_cut_offs, summary.onset
    parts = []
    is_over = at.sizes.get("cut_off", 0) > 1
    if any(math.isfinite(one.value) for one in summary.points):
        if verbose:
            first = at.isel({name: 0 for name in CELLS if name in at.dims})
            parts.append(resolution_text(first, study, at if over is None and is_over else over))
        if onset is not None and verbose:
            said = f"{onset_text(onset)} {onset_note(onset)}"
            parts.append(f"{fitted(said)}\n{aligned(onset_rows(onset))}")
        elif onset is not None:
            parts.append(fitted(onset_text(onset)))
    return "".join(f"\n{part}\n" if verbose else f"{part}\n" for part in parts if part)


def answers_text(found: Sequence[PointSummary]) -> str:
    """The coefficients: a line for each rule of one answer, and a table of several with their inputs."""
    if len(found) == 1:
        words = (f"{_coefficient(found[0], index)}  {RULES[rule.rule]}" for index, rule in enumerate(found[0].rules))
        lines = [fitted(f"{'      ' if i else 'μ_s = '}{each}", hang=" " * 8) for i, each in enumerate(words)]
        return "\n".join(filter(None, [*lines, fitted(roughness_text(found[0]))]))
    names = [name for name in found[0].at if name != "fractal_dimension" or "hurst_exponent" not in found[0].at]
    names.sort(key=lambda name: name != "hurst_exponent")
    varying = [name for name in names if len({one.at[name] for one in found}) > 1]
    titles = (f"μ_s {RULE_TITLES[rule.rule]}" for rule in found[0].rules)
    rows = [[*(_TITLES.get(name, name) for name in varying), *titles, "assessment"]]
    for one in found:
        values = [_coefficient(one, index) for index in range(len(one.rules))]
        places = [
            load_text(one.values, one.study) if name == "load" else _coordinate(name, one.at[name]) for name in varying
        ]
        rows.append([*places, *values, one.verdict])
    inputs = [inputs_text(one).split(", ") for one in found]
    same = [word for word in inputs[0] if all(word in each for each in inputs)]
    shared = f"with {', '.join(same)}; " if same else ""
    assumptions = assumptions_of(found[0].study)
    assumed = f"; assuming {', '.join(assumptions)}" if assumptions else ""
    return aligned(rows, labels=len(varying)) + "\n" + fitted(f"{shared}{note_text(found[0])}{assumed}", indent="  ")


def _coefficient(one: PointSummary, index: int) -> str:
    rule = one.rules[index]
    if math.isfinite(rule.value):
        return quoted(rule.value, rule.lower, rule.upper)
    return "none" if one.status == friction.STATUS_OK else one.status


_TITLES = {"fractal_dimension": "D", "hurst_exponent": "H", "mu0": "μ0", "tau0": "τ0", "cut_off": "cut-off"}
_UNITS = {"load": "mN", "tau0": "GPa", "amplitude": "um", "cut_off": "um"}


def _coordinate(name: str, value: float) -> str:
    if name == "cut_off" and value == 0:
        return "none"
    return with_unit(value, _UNITS[name]) if name in _UNITS and value else f"{value:.4g}"


def _details(one: PointSummary) -> str:
    lines = [] if one.unloaded else [parts_text(one), test_text(one), waited_text(one)]
    if finer := finer_text(one):
        lines.append(f"{finer[0].upper()}{finer[1:]}.")
    assumptions = assumptions_of(one.study)
    assumed = f" Assumes {', '.join(assumptions)}." if assumptions else ""
    return "\n".join(map(fitted, [*filter(None, lines), f"At {inputs_text(one)}; {note_text(one)}.{assumed}"]))


NEGLIGIBLE = 0.05  # fraction of the coefficient below which the roughness does not decide it


def roughness_text(one: PointSummary) -> str:
    """How much of the coefficient the scans contribute, and what decides it; empty where that is not known."""
    if one.from_roughness is None:
        return ""
    inputs = "the hardness, μ0 and τ0" if one.hardness is not None and one.at["tau0"] > 0 else "μ0"
    decides = abs(one.from_roughness) <= NEGLIGIBLE * one.value
    rest = f"{inputs} decide{'s' * (inputs == 'μ0')}" if decides else f"the rest is from {inputs}"
    return f"R{contribution_text(one)[1:]}; {rest}."


def parts_text(one: PointSummary) -> str:
    """What holds the bodies, in the digits of the coefficient; empty where it is not known."""
    if one.parts is None:
        return ""
    mu0, adhesion, slopes = (round(part, 3) + 0.0 for part in one.parts)
    sign = "\N{MINUS SIGN}" if slopes < 0 else "+"
    more = "" if math.isclose(mu0, one.at["mu0"], abs_tol=1e-3) else " on the load of the contacts"
    return f"{mu0:.3f} (μ0{more}) + {adhesion:.3f} (τ0 on the true area) {sign} {abs(slopes):.3f} (slopes)"


def budget_text(one: PointSummary) -> str:
    """What to measure next, and what it would leave; empty where nothing printed decides, or a fault comes first."""
    most = one.most
    if most is None or any(fault.text != WIDE_INTERVAL for fault in one.faults):
        return ""
    now, then = (from_to(low, high) for low, high in ((one.lower, one.upper), (most.lower, most.upper)))
    if now == then:
        return ""
    how = _MEASURES.get(most.words, f"Measuring {most.words}")
    return f"{how} would give [{then.replace(' to ', ', ')}]."


_MEASURES = {
    ORIGIN: "Scanning one place twice", POSITIONS: "Using more positions", FINER: "A finer scan",
    UPPER_PIECE: "Scanning more places of the upper part", LOWER_PIECE: "Scanning more places of the lower part",
}  # fmt: skip
"""How to get to know what is no input."""


def test_text(one: PointSummary) -> str:
    """Where the next test would lie, and what positions alone leave open."""
    first = one.rules[0]
    if not math.isfinite(first.next_test[0]) or first.next_test == (first.lower, first.upper):
        return ""
    what = "positions" if one.scans == (1, 1) else "scans and positions"
    own = math.isfinite(first.positions[0]) and first.positions != (first.lower, first.upper)
    alone = f"; {what} alone: {from_to(*first.positions)}" if own else ""
    return f"Single test in one direction: {from_to(*first.next_test)}{alone}."


def waited_text(one: PointSummary) -> str:
    """How it grows under load, where the study waits."""
    after = [f"{duration(each.seconds)} {quoted(each.value, each.lower, each.upper)}" for each in one.waited]
    why = "; none if the hardness falls below the pressure" if any(math.isnan(e.value) for e in one.waited) else ""
    rate = f"; {significant(one.ageing)} for each factor e of time" if math.isfinite(one.ageing) else ""
    return f"After a dwell time: {', '.join(after)}{why}{rate}." if after else ""


def doubts_text(found: Sequence[PointSummary], most: int | None = None) -> str:
    """The verdict on every answer, what to measure next of one, and its doubts with their cures, the first of them."""
    if len({(one.verdict, one.doubts) for one in found}) == 1:
        one, doubts = found[0], found[0].doubts
        faults = sum(doubt.severity == "fault" for doubt in doubts)
        lines = [_doubt(doubt) for doubt in doubts]
        said = lines if most is None else lines[: max(_within(lines, most), faults, 1)]
        what = f". {words}" if len(found) == 1 and not one.unloaded and (words := budget_text(one)) else ""
        what = what or (" a coefficient" if one.unloaded else "")
        rest = [f"  {len(doubts) - len(said)} more: see the report or --json"] if len(doubts) > len(said) else []
        return "\n".join([fitted(f"{one.verdict}{what}", hang="  "), *said, *rest])
    kinds: dict[tuple[str, str], list[Doubt]] = {}
    for doubt in (doubt for one in found for doubt in one.doubts):
        kinds.setdefault((doubt.severity, _AMOUNT.sub("", doubt.text)), []).append(doubt)
    lines = [
        _doubt(same[0], f" ({len(same)} of {len(found)})")
        for same in sorted(kinds.values(), key=lambda same: same[0].severity != "fault")
    ]
    shown = MOST_DOUBTS if most is None else max(_within(lines, most), 1)
    rest = [f"  {len(lines) - shown} more: see the report or --json"] if len(lines) > shown else []
    counts = [(verdict, sum(one.verdict == verdict for one in found)) for verdict in VERDICTS.values()]
    assessed = ", ".join(f"{verdict} ({count} of {len(found)})" for verdict, count in counts if count)
    return "\n".join([fitted(f"{assessed}."), *lines[:shown], *rest])


_AMOUNT = re.compile(r"\d[\d.]* ?(?:%|(?:[kMGmµn]?(?:Pa|N|m|m²)\b))?")
"""A number and its unit, in which caveats of one kind differ."""


def _within(texts: Sequence[str], lines: int) -> int:
    """How many of the texts, from the first, are on so many lines."""
    return int(np.searchsorted(np.cumsum([text.count("\n") + 1 for text in texts]), lines, side="right"))


MOST_DOUBTS = 6  # most doubts that are printed of several answers; JSON and CSV have all


def _doubt(doubt: Doubt, more: str = "") -> str:
    mark = "!" if doubt.severity == "fault" else "-"
    return fitted(f"{mark} {doubt.text}{more}; {doubt.cure}", indent="  ", hang="  ")


# ---- Quantities ------------------------------------------------------------------------------------------------------

_QUANTILES = (("patch_area", 0.5), ("patch_area", 0.9), ("pressure", 0.5), ("pressure", 0.9))
_SCALES: dict[str, tuple[tuple[float, float, str], ...]] = {
    "um^2": ((1e5, 1e-6, "mm²"), (0.0, 1.0, "µm²")),
    "mN/um": ((1e4, 1e-3, "N/µm"), (0.0, 1.0, "mN/µm")),
    "MPa/mm": ((1e7, 1e-6, "TPa/mm"), (1e4, 1e-3, "GPa/mm"), (0.0, 1.0, "MPa/mm")),
    "GPa/mm": ((1e4, 1e-3, "TPa/mm"), (0.0, 1.0, "GPa/mm")),
}
"""Least value, factor and name of units without prefixes, by which large numbers have few digits."""


def _first_cell(found: Sequence[PointSummary]) -> str:
    """Return the coordinates of the first of several cells, as in "H = 0.9"; empty if there is a single cell."""
    hidden = {"load", "mu0", "tau0", *(["fractal_dimension"] if "hurst_exponent" in found[0].at else [])}
    names = [name for name in found[0].at if name not in hidden and len({one.at[name] for one in found}) > 1]
    return ", ".join(f"{_TITLES.get(name, name)} = {_coordinate(name, found[0].at[name])}" for name in names)


def quantities_text(at: xarray.Dataset, study: Study, *, verbose: bool = False, cell: str = "") -> str:
    """Means and 95 % intervals of one cell: a row for each quantity, a column for each load; by the rule to quote."""
    one = at.isel({name: 0 for name in ("mu0", "tau0") if name in at.dims})
    one = one.sel(sliding=rules_of(study)[0]) if "sliding" in one.dims else one
    loads = list(points(one))
    fraction = "contact_area_fraction" in one and has_nominal_area(loads[0], study)
    rows: list[list[str]] = []
    in_words = len(loads) == 1 and study.is_measured and not verbose
    for name in (*shown_in("table"), *(shown_in("verbose") if verbose else ())):
        hidden = {
            "mean_pressure": in_words,  # load over area, both of which it has
            "contact_area": fraction and not verbose, "contact_area_fraction": not fraction,
            **dict.fromkeys(("closure", "closure_stiffness"), not (verbose or study.is_gap)),
            **dict.fromkeys(HELD, not verbose),
            **dict.fromkeys(PER_AREA, not fraction),
        }.get(name, False)  # fmt: skip
        if name in one and not hidden and one[name].sizes.get("direction", 1) == 1:
            words = words_of(name, study) + (" at least" if name in HELD and pull_off_is_bound(name, one) else "")
            rows += _row(name, words, [point[name] for point in loads])
            if name == "contact_area_fraction" and rows:
                rows[-1] = _with_statuses(rows[-1], [contact_status_of(point, study) for point in loads])
    for name, below in _QUANTILES if verbose else ():
        if name in one:
            words = f"{QUANTITIES[name].short}, {100 * below:.0f}th percentile"
            rows += _row(name, words, [point[name].sel(fraction_below=below, method="nearest") for point in loads])
    if verbose and "rms_gradient" in one:
        rows += _row("rms_gradient", QUANTITIES["rms_gradient"].short, [point["rms_gradient"] for point in loads])
    if in_words:
        words = "; ".join(f"{name} {value.removesuffix(' no interval')} {unit}".rstrip() for name, unit, value in rows)
        return fitted(f"{words[:1].upper()}{words[1:]}.")
    head = f"{cell}, mean [95 %]" if cell else "mean [95 %]"
    names = [head, *(load_text(point, study) for point in loads)]
    columns = [[f"{name} ({unit})" if unit else name, *cells] for name, unit, *cells in rows]
    if len(loads) == 1:
        return aligned([names, *columns])
    return aligned(
        [
            *_stacked([each[0] for each in (names, *columns)]),
            *zip(names[1:], *(each[1:] for each in columns), strict=True),
        ]
    )


def _stacked(heads: Sequence[str]) -> Rows:
    """Return the rows of a head whose words go on in further lines, so that columns are as narrow as their cells."""
    lines = [textwrap.wrap(head, HEAD_WIDTH, break_long_words=False) for head in heads]
    return list(itertools.zip_longest(*lines, fillvalue=""))


HEAD_WIDTH = 20  # columns of the words above a column of numbers


def pull_off_is_bound(name: str, at: xarray.Dataset) -> bool:
    """Return whether a quantity is a pull-off force or pressure to which members contribute lower bounds."""
    fraction = QUANTITIES[name].bound_fraction
    return bool(fraction) and float(at[fraction].sel(statistic="mean").max()) > 0


def _row(name: str, words: str, tables: Sequence[xarray.DataArray]) -> list[list[str]]:
    """A row of the name, the unit and a cell for each load, or none where no load has a number."""
    unit = QUANTITIES[name].unit
    if unit in ("um", "GPa", "mN"):
        values = [value for value in map(_largest, tables) if math.isfinite(value)]
        core, shown = prefix(max(values, default=1.0), unit)
        factor = 1 / core
    else:
        largest = max((value for value in map(_largest, tables) if math.isfinite(value)), default=0.0)
        scales = ((0.0, 100.0, "%"),) if QUANTITIES[name].percent else _SCALES.get(unit, ((0.0, 1.0, ""),))
        factor, shown = next((factor, name) for least, factor, name in scales if largest >= least)
    cells = [_cell(table, factor) for table in tables]
    return [] if set(cells) == {"none"} else [[words, shown, *cells]]


def _with_statuses(row: list[str], statuses: Sequence[str]) -> list[str]:
    """Return a row of area fractions with the status in place of a value where it is not ok."""
    name, unit, *cells = row
    cells = [cell if each == friction.STATUS_OK else each for cell, each in zip(cells, statuses, strict=True)]
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
    return with_interval(*(factor * table.sel(statistic=each).item() for each in STATISTICS))


def axes_text(point: xarray.Dataset, *, verbose: bool = False) -> str:
    """Whether the surfaces have grooves; if so, or if everything is told, the coefficient along each axis."""
    if "friction_by_axis" not in point or point.sizes.get("axis", 0) < 2:
        return ""
    table = point["friction_by_axis"]
    lay = lay_text(by_rule(table, next(rule for rule in RULES if rule in np.atleast_1d(point["sliding"].values))))
    if not verbose:
        return fitted(lay) if lay.startswith("Grooves: friction") else ""
    return _by_rules("μ_s along an axis", table, "axis", _axis) + "\n" + fitted(lay)


def _by_rules(title: str, table: xarray.DataArray, along: str, name: Callable[[float], str]) -> str:
    """A table of coefficients: a row for each coordinate along a dimension, a column for each sliding rule."""
    rules = [rule for rule in RULES if rule in np.atleast_1d(table["sliding"].values)]
    rows = [[title, *(RULE_TITLES[rule] for rule in rules)]]
    for place in table[along].values:
        own = table.sel({along: place})
        rows.append([name(float(place)), *(_cell(by_rule(own, rule), 1.0) for rule in rules)])
    return aligned(rows)


def _axis(degrees: float) -> str:
    return {0.0: "x", 90.0: "y"}.get(degrees, f"{degrees:g}°")


def lay_text(table: xarray.DataArray) -> str:
    """Grooves or none, from the coefficients along several axes: whether the intervals of the extremes are apart."""
    mean, lower, upper = (table.sel(statistic=each) for each in STATISTICS)
    if not np.isfinite(lower.values).all():
        return "Grooves: unknown, because the coefficients along the axes have no intervals."
    high, low = (int(choose(mean.values)) for choose in (np.argmax, np.argmin))
    names = [_axis(float(table["axis"][place])) for place in (high, low)]
    if float(lower[high]) > float(upper[low]):
        more = 100 * (float(mean[high]) / float(mean[low]) - 1)
        return f"Grooves: friction along {names[0]} is {significant(more)} % higher than along {names[1]}."
    return "No grooves: the axes differ by less than their intervals."


def directions_text(point: xarray.Dataset) -> str:
    """The coefficient in every direction of the upper body."""
    if "direction" not in point.dims:
        return ""
    return _by_rules("μ_s, upper body", point["friction_coefficient"], "direction", way_text)


def resolution_text(at: xarray.Dataset, study: Study, over: xarray.Dataset | None) -> str:
    """Which waves were seen, how the first answer moves with a cut-off, and what lies beyond.

    It is of what `at_load` returns, and over cut-offs of what `resolution_at` gives.
    """
    found, parts = seen(study), []
    if found is not None:
        parts.append(fitted(waves_text(found)))
    if over is not None:
        first = over.isel(dict.fromkeys(("load", "mu0", "tau0"), 0))
        parts.append(aligned(cut_off_rows(first, study)) + "\n" + fitted(cut_off_note(first, study), indent="  "))
    capped = is_capped(study) or not study.by_half_space
    if found is not None and not capped and (rows := yielding_rows(next(points(at)), study, found)):
        parts.append(fitted(ELASTIC) + "\n" + aligned(rows))
    return "\n\n".join(parts)


def history_text(at: xarray.Dataset, study: Study) -> str:
    """What was pressed, and how."""
    steps = {name: str(at.attrs[name]).replace("\n", "; ") for name in ("upper", "lower") if name in at.attrs}
    mechanics = {"half-space": "the elastic half-space", "asperities": "asperities without interaction"}
    model = [mechanics[study.contact.mechanics]]
    if "nominal_area" in at.coords:
        model.append(f"on a nominal area of {float(at['nominal_area']):.4g} µm²")
    if study.contact.mechanics == "asperities" and study.surfaces.kind != "surface":
        model += [str(getattr(study.contact, name)) for name in ("law", "detection", "curvature")]
    steps["model"] = ", ".join(model)
    return "\n".join(fitted(f"{name:<9}{words}", hang=" " * 9) for name, words in steps.items())


def first_text(summary: Summary) -> str:
    """Return the coefficient of the first members of a study of asperities in a line."""
    one = summary.points[0]
    return f"preliminary, with asperities: μ_s = {quoted(one.value)}  {RULES[one.rules[0].rule]}"


# ---- Overview --------------------------------------------------------------------------------------------------------


def overview_text(summary: Summary, most: int | None = None) -> str:
    """Tables of mu_s of generated surfaces, one for each sliding rule and amplitude: a row for each cell of the study.

    Columns are loads; mu0 and tau0 are columns too where the study has several. Caveats follow, in `most` lines.
    """
    at, study, found = summary.at, summary.study, summary.headlines
    chosen = at if _num_rows(at) <= MAX_OVERVIEW_ROWS else _ends_and_middle(at)
    whole, at = at, chosen
    rest = [name for name in ("amplitude", "sliding") if name in at.dims]
    varying = [name for name in ("mu0", "tau0") if at.sizes[name] > 1]
    tables, marked = [], False
    for place in np.ndindex(*(at.sizes[name] for name in rest)):
        part = at.isel(dict(zip(rest, place, strict=True)))
        labels = [[*(_TITLES[name] for name in varying), shape_coordinate(study, 1.0)[0]]]
        rows = [[with_unit(load, "mN") for load in at["load"].values.tolist()]]
        for mu0, tau0, cell in np.ndindex(*(at.sizes[name] for name in ("mu0", "tau0", "fractal_dimension"))):
            own = part.isel(mu0=mu0, tau0=tau0, fractal_dimension=cell)
            values = [_coordinate(name, float(own[name])) for name in varying]
            labels.append([*values, f"{shape_coordinate(study, float(own['fractal_dimension']))[1]:.4g}"])
            rows.append([_overview_cell(own.isel(load=index)) for index in range(at.sizes["load"])])
        marked = marked or any(cell.endswith("*") for row in rows for cell in row)
        sizes = [max(map(len, column)) for column in zip(*labels, strict=True)]
        names = ["  ".join(text.ljust(size) for text, size in zip(row, sizes, strict=True)) for row in labels]
        table = aligned([[name, *cells] for name, cells in zip(names, rows, strict=True)])
        tables.append(f"{fitted(_overview_title(part, varying))}\n{table}")
    if marked:
        note = "* outside the model: more than half of the load is on overlaps > R/10, or on radii < spacing"
        tables.append(fitted(note))
    if left_out := _left_out(at, whole, study):
        tables.append(fitted(left_out))
    return "\n".join(tables) + f"\n\n{doubts_text(found, most)}"


MAX_OVERVIEW_ROWS = 40  # rows of an overview, of all mu0, tau0 and cells, above which it shows a few mu0 and tau0


def _num_rows(at: xarray.Dataset) -> int:
    return math.prod(at.sizes.get(name, 1) for name in ("mu0", "tau0", *CELLS))


def _ends_and_middle(at: xarray.Dataset) -> xarray.Dataset:
    """Select the middle mu0 and the first and last tau0."""
    return at.isel(mu0=[at.sizes["mu0"] // 2], tau0=sorted({0, at.sizes["tau0"] - 1}))


def _left_out(at: xarray.Dataset, whole: xarray.Dataset, study: Study) -> str:
    """Return how many values of a study an overview leaves out, and the command that shows them; empty if none."""
    every = study.surfaces.cells()["fractal_dimension"].size
    sizes = {
        shape_coordinate(study, 1.0)[0]: (at.sizes["fractal_dimension"], every),
        "μ0": (at.sizes["mu0"], whole.sizes["mu0"]), "τ0": (at.sizes["tau0"], whole.sizes["tau0"]),
    }  # fmt: skip
    words = [f"{shown} of {number} values of {name}" for name, (shown, number) in sizes.items() if shown < number]
    return f"Shown: {', '.join(words)}; use stiction at for all." if words else ""


def _overview_title(part: xarray.Dataset, varying: Sequence[str]) -> str:
    given = {"mu0": f"μ0 = {float(part['mu0'][0]):g}", "tau0": f"τ0 = {_coordinate('tau0', float(part['tau0'][0]))}"}
    words = [text for name, text in given.items() if name not in varying]
    if "amplitude" in part.coords and part["amplitude"].ndim == 0:
        words.append(f"amplitude {with_unit(float(part['amplitude']), 'um')}")
    if "sliding" in part.coords and part["sliding"].ndim == 0:
        words.append(RULES[str(part["sliding"].values)])
    return f"μ_s [95 %] at {', '.join(words)}" if words else "μ_s [95 %]"


def _overview_cell(point: xarray.Dataset) -> str:
    statuses = np.unique(np.atleast_1d(point["status"].values))
    bad = [str(status) for status in statuses if status != friction.STATUS_OK]
    if bad:
        return bad[0]
    name = "friction_all_round" if "friction_all_round" in point else "friction_coefficient"
    numbers = {name: value_of(point, name) for name in ("share_beyond_hertz", "share_below_grid")}
    beyond = doubted(OF_ASPERITIES, numbers)
    mean, lower, upper = (float(point[name].sel(statistic=each)) for each in STATISTICS)
    return quoted(mean, lower, upper) + "*" * any(beyond)
