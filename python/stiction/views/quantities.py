"""Text output of a result's quantities: a sentence for a single load, mu0 and tau0, or a table for several."""

from __future__ import annotations

import itertools
import math
import textwrap
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from stiction._estimate import Estimate
from stiction._number_format import choose_prefixed_unit, format_significant
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.quantities import (
    LOAD_INDEPENDENT_QUANTITIES,
    QUANTITIES,
    STIFFNESS_PER_AREA_QUANTITIES,
    quantity_names_shown_in,
)
from stiction.summary.summary import PointSummary
from stiction.views.layout import Paragraph, Table, TextRows
from stiction.views.point import coordinate_text, point_load_text

if TYPE_CHECKING:
    from stiction.study.study import Study

MAX_HEADING_WIDTH = 20  # characters
_VERBOSE_QUANTILES = (("patch_area", 0.5), ("patch_area", 0.9), ("pressure", 0.5), ("pressure", 0.9))


@dataclass(frozen=True)
class QuantityRow:
    """Table row of one quantity: its estimates at several loads, mu0 and tau0, in µm, mN and GPa."""

    name: str
    label: str
    estimates: Sequence[Estimate]
    num_digits: int | None = None
    # Statuses of the result points. A status other than "ok" is printed instead of the number.
    statuses: Sequence[str] = ()


def quantities_paragraph(points: Sequence[PointSummary], *, verbose: bool = False, cell: str = "") -> Paragraph:
    """Return a paragraph with all quantities and their 95 % intervals: a sentence for one point, or a table.

    A single result point gives a sentence or, if `verbose` is True or the surfaces are generated, a table with one row
    per quantity. Several points give a table with one row per point. `cell` starts the heading of the first column.
    """
    is_sentence = len(points) == 1 and points[0].study.is_measured and not verbose
    selected_rows = _select_rows(points, verbose=verbose, is_sentence=is_sentence)
    all_rows = [_format_row(row, is_sentence=is_sentence) for row in selected_rows]
    rows = [row for row in all_rows if set(row[2:]) != {"none"}]
    if is_sentence:
        text = "; ".join(f"{label} {value} {unit}".rstrip() for label, unit, value in rows)
        return [f"{text[:1].upper()}{text[1:]}."] if rows else []
    columns = [
        [f"{cell}, mean [95 %]" if cell else "mean [95 %]", *map(point_load_text, points)],
        *([f"{label} ({unit})" if unit else label, *cells] for label, unit, *cells in rows),
    ]
    if len(points) == 1:
        return [Table(columns)]
    headings, *cells_by_point = zip(*columns, strict=True)
    return [Table([*_wrap_headings(headings), *cells_by_point])]


# ---- Selection of quantities -----------------------------------------------------------------------------------------


def _select_rows(points: Sequence[PointSummary], *, verbose: bool, is_sentence: bool) -> Iterator[QuantityRow]:
    """Yield a table row for each printed quantity, with its estimates at all printed loads, mu0 and tau0."""
    first_point = points[0]
    has_pull_off_bound = first_point.pull_off is not None and first_point.pull_off.is_bound
    for name in _list_printed_quantities(first_point, verbose=verbose, is_sentence=is_sentence):
        is_bound = has_pull_off_bound and bool(QUANTITIES[name].bound_fraction)
        label = quantity_label(name, first_point.study) + " at least" * is_bound
        if name in first_point.numbers:
            number_estimates = [Estimate(point.numbers[name]) for point in points]
            yield QuantityRow(name, label, number_estimates, num_digits=2 if QUANTITIES[name].unit == "1" else 3)
            continue
        estimates = [point.quantities[name] for point in points]
        statuses = [point.contact_status for point in points] if name == "contact_area_fraction" else ()
        yield QuantityRow(name, label, estimates, num_digits=1 if name == "error" else None, statuses=statuses)
    for name, fraction in _VERBOSE_QUANTILES if verbose else ():
        if name in first_point.distributions:
            label = f"{QUANTITIES[name].table_label}, {100 * fraction:.0f}th percentile"
            yield QuantityRow(name, label, [_find_quantile(point, name, fraction) for point in points])
    if verbose and "rms_gradient" in first_point.quantities:
        label = QUANTITIES["rms_gradient"].table_label
        yield QuantityRow("rms_gradient", label, [point.quantities["rms_gradient"] for point in points])


def _list_printed_quantities(point: PointSummary, *, verbose: bool, is_sentence: bool) -> list[str]:
    """Return the names of the quantities to print for one load, mu0 and tau0.

    The additional quantities for `verbose` come last.
    """
    has_area_fraction = "contact_area_fraction" in point.quantities and not math.isnan(point.nominal_pressure)
    is_hidden = {
        # Sentences omit the mean pressure, because the reader can compute it from load and area.
        "mean_pressure": is_sentence,
        "contact_area": has_area_fraction and not verbose, "contact_area_fraction": not has_area_fraction,
        **dict.fromkeys(("closure", "closure_stiffness"), not (verbose or point.study.is_gap)),
        **dict.fromkeys(LOAD_INDEPENDENT_QUANTITIES, not verbose),
        **dict.fromkeys(STIFFNESS_PER_AREA_QUANTITIES, not has_area_fraction),
    }  # fmt: skip
    names = (*quantity_names_shown_in("table"), *(quantity_names_shown_in("verbose") if verbose else ()))
    return [
        name for name in names if (name in point.quantities or name in point.numbers) and not is_hidden.get(name, False)
    ]


def percent_text(fraction: float) -> str:
    """Return a fraction as a percentage with three significant digits, such as "10.9 %", or "none" for NaN."""
    return "none" if math.isnan(fraction) else f"{format_significant(100 * fraction, 3)} %"


def _find_quantile(point: PointSummary, name: str, fraction: float) -> Estimate:
    """Return the stored quantile of a distribution at the probability closest to `fraction`."""
    quantiles = point.distributions[name]
    return quantiles[min(quantiles, key=lambda fraction_below: abs(fraction_below - fraction))]


def quantity_label(name: str, study: Study) -> str:
    """Return the label of a quantity in printed tables of a study's results.

    Quantities of the onset of sliding are labelled with mu0 and tau0.
    """
    onset, text = study.contact.onset, QUANTITIES[name].table_label
    if name == "normal_stiffness" and study.contact.hardness is not None:
        return f"{text} while loading"
    if onset is None or name not in ("displacement_at_sliding", "fraction_slipped"):
        return text
    return f"{text} at μ0 = {onset.mu0:g}, τ0 = {coordinate_text('tau0', float(onset.tau0))}"


# ---- Format ----------------------------------------------------------------------------------------------------------


def _format_row(row: QuantityRow, *, is_sentence: bool) -> list[str]:
    """Return a table row as texts (label, unit, numbers), with a unit prefix that suits the size of the numbers.

    A missing interval is stated only in tables.
    """
    finite_values = [abs(estimate.value) for estimate in row.estimates if math.isfinite(estimate.value)]
    factor, unit = choose_prefixed_unit(max(finite_values, default=0.0), QUANTITIES[row.name].table_unit)
    estimates = [estimate.in_unit(unit, factor) for estimate in row.estimates]
    if row.num_digits is not None:
        return [row.label, unit, *(format_significant(estimate.value, row.num_digits) for estimate in estimates)]
    cells = [estimate.text() if is_sentence else estimate.table_text for estimate in estimates]
    if set(row.statuses) <= {STATUS_OK}:
        return [row.label, unit, *cells]
    cells = [cell if status == STATUS_OK else status for cell, status in zip(cells, row.statuses, strict=True)]
    return [row.label, unit if STATUS_OK in row.statuses else "", *cells]


def _wrap_headings(headings: Sequence[str]) -> TextRows:
    """Wrap column headings into lines of at most `MAX_HEADING_WIDTH` characters, so that columns stay narrow."""
    lines = [textwrap.wrap(heading, MAX_HEADING_WIDTH, break_long_words=False) for heading in headings]
    return list(itertools.zip_longest(*lines, fillvalue=""))
