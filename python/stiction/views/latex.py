"""LaTeX table of a result, with one row per point of a summary."""

from __future__ import annotations

import math
from collections.abc import Sequence

from stiction._number_format import format_significant
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.quantities import column_title_and_factor
from stiction.studies.summary import PointSummary, Summary
from stiction.views.point import cutoff_text

_RULE_HEADINGS = {"all": r"$\mu_s$, all contacts", "opposing": r"$\mu_s$, opposing contacts"}
_COORDINATE_HEADINGS = {"hurst_exponent": "$H$", "fractal_dimension": "$D$", "mu0": r"$\mu_0$"}
_LATEX_ESCAPES = str.maketrans({character: f"\\{character}" for character in "&%$#_{}"} | {"∞": r"$\infty$"})


def latex_table(summary: Summary) -> str:
    r"""Return the reported points of a summary as a LaTeX ``tabular``: conditions, coefficients and assessment.

    Conditions common to all points are comments above the table. Intervals of coefficients are the combined 95 %
    intervals. Numbers have the same digits as on the terminal.
    """
    points = summary.headlines
    coordinate_names = [
        name for name in points[0].at if name != "fractal_dimension" or "hurst_exponent" not in points[0].at
    ]
    varying_names = [name for name in coordinate_names if len({point.at[name] for point in points}) > 1]
    shared_texts = [
        f"{_column_heading(name)} = {_coordinate_text(name, points[0])}"
        for name in coordinate_names
        if name not in varying_names
    ]
    has_area = "contact_area_fraction" in summary.at
    rules = [rule.rule for rule in points[0].rules]
    header = [
        *map(_column_heading, varying_names),
        *(_RULE_HEADINGS[rule] for rule in rules),
        *([r"$A/A_0$"] if has_area else []),
        "assessment",
    ]
    rows = [
        [*(_coordinate_text(name, point) for name in varying_names), *_point_cells(point, has_area)] for point in points
    ]
    lines = [f"% {text}" for text in shared_texts]
    lines += [
        rf"\begin{{tabular}}{{{'l' * len(header)}}}",
        r"\hline",
        _latex_row(header),
        r"\hline",
        *map(_latex_row, rows),
    ]
    return "\n".join([*lines, r"\hline", r"\end{tabular}"]) + "\n"


def _point_cells(point: PointSummary, has_area: bool) -> list[str]:
    """Return the table cells of a point: coefficients of all sliding rules, area fraction and assessment."""
    texts = [str(rule) for rule in point.rules]
    if has_area:
        fraction = point.quantities["contact_area_fraction"] / 0.01
        is_printed = point.contact_status == STATUS_OK and not math.isnan(fraction.value)
        texts.append(f"{fraction:.2u} %" if is_printed else point.contact_status.replace(STATUS_OK, "none"))
    return [cell.translate(_LATEX_ESCAPES) for cell in (*texts, point.verdict)]


def _column_heading(name: str) -> str:
    """Return the column heading of a coordinate, with its unit."""
    return _COORDINATE_HEADINGS.get(name, column_title_and_factor(name)[0].translate(_LATEX_ESCAPES))


def _coordinate_text(name: str, point: PointSummary) -> str:
    if name == "cut_off" and point.cut_offs is not None:
        return cutoff_text(point.cut_offs, lambda length: format_significant(length, 4))
    factor = 1.0 if name in _COORDINATE_HEADINGS else column_title_and_factor(name)[1]
    return format_significant(factor * point.at[name], 4)


def _latex_row(cells: Sequence[str]) -> str:
    return " & ".join(cells) + r" \\"
