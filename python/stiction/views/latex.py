"""LaTeX table of a result: one row for each combination of load, mu0, tau0 and roughness."""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Sequence

from stiction._number_format import format_significant
from stiction._text import printable_text
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.quantities import column_title_and_factor
from stiction.study.study_description import describe_study
from stiction.summary.summary import PointSummary, Summary
from stiction.views.point import coefficient_text, cutoff_text
from stiction.views.sentence import covered_inputs_text, shared_conditions_text

_RULE_HEADINGS = {"all": r"$\mu_s$, all contacts", "opposing": r"$\mu_s$, opposing contacts"}
_COORDINATE_HEADINGS = {"hurst_exponent": "$H$", "fractal_dimension": "$D$", "mu0": r"$\mu_0$"}
_LATEX_ESCAPES = str.maketrans(
    {character: f"\\{character}" for character in "&%$#_{}"} | {"∞": r"$\infty$", "≥": r"$\geq$"}
)
_LATEX_SYMBOLS = {character: f"\\{character}" for character in "&%$#_{}"} | {
    "\\": r"\textbackslash{}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}", "<": "$<$", ">": "$>$",
    "μ_s": r"$\mu_s$", "μ0": r"$\mu_0$", "τ0": r"$\tau_0$", "E*": "$E^*$", "A/A0": "$A/A_0$", "H′": "$H'$",
    "µ": r"$\mu$", "μ": r"$\mu$", "τ": r"$\tau$", "α": r"$\alpha$", "ν": r"$\nu$", "°": r"$^\circ$", "²": "$^2$",
    "³": "$^3$", "±": r"$\pm$", "×": r"$\times$", "√": r"$\surd$", "∞": r"$\infty$", "′": "$'$", "·": r"$\cdot$",
    "\N{MINUS SIGN}": "$-$", "–": "--", "…": r"\ldots{}",
}  # fmt: skip
_SYMBOL_PATTERN = re.compile("|".join(map(re.escape, sorted(_LATEX_SYMBOLS, key=len, reverse=True))))


def latex_table(summary: Summary) -> str:
    r"""Return a LaTeX ``table`` of a result's coefficients, with the conditions and assessment of each coefficient.

    The caption contains the conditions that all rows share, with the ranges of the inputs. Comments above the table
    contain the central values of the inputs. Numbers have the same digits as on the terminal. The table requires the
    LaTeX package booktabs.
    """
    points = summary.reported_points
    coordinate_names = [
        name for name in points[0].at if name != "fractal_dimension" or "hurst_exponent" not in points[0].at
    ]
    varying_names = [name for name in coordinate_names if len({point.at[name] for point in points}) > 1]
    shared_texts = [
        f"{_column_heading(name)} = {_coordinate_text(name, points[0])}"
        for name in coordinate_names
        if name not in varying_names
    ]
    has_pressure = "load" in varying_names and not any(math.isnan(point.nominal_pressure) for point in points)
    has_area = "contact_area_fraction" in summary.at
    rules = [rule.rule for rule in points[0].rules]
    header = [
        *map(_column_heading, varying_names),
        *([r"$F_N/A_0$ (MPa)"] if has_pressure else []),
        *(_RULE_HEADINGS[rule] for rule in rules),
        *([r"$A/A_0$"] if has_area else []),
        "assessment",
    ]
    rows = [
        [
            *(_coordinate_text(name, point) for name in varying_names),
            *([format_significant(1000 * point.nominal_pressure, 4)] if has_pressure else []),
            *_point_cells(point, has_area),
        ]
        for point in points
    ]
    lines = [
        "% requires the package booktabs",
        *(f"% {text}" for text in shared_texts),
        r"\begin{table}",
        r"\centering",
        rf"\caption{{{_to_latex(_caption_text(summary, points, has_area=has_area))}}}",
        rf"\begin{{tabular}}{{{'l' * len(header)}}}",
        r"\toprule",
        _latex_row(header),
        r"\midrule",
        *map(_latex_row, rows),
        r"\bottomrule",
        r"\end{tabular}",
        r"\end{table}",
    ]
    return "\n".join(lines) + "\n"


def _caption_text(summary: Summary, points: Sequence[PointSummary], *, has_area: bool) -> str:
    """Return the caption of a table: names of the bodies, conditions that all rows share, and meaning of brackets."""
    version = summary.at.attrs.get("stiction_version")
    intervals_text = next(filter(None, map(covered_inputs_text, points)), "")
    bodies = "" if summary.study.is_measured else " of generated surfaces"
    sentences = [
        f"Coefficient of static friction{bodies}: {describe_study(summary.study).name}",
        shared_conditions_text(points),
        f"Brackets after μ_s: {intervals_text}" if intervals_text else "",
        "Brackets after A/A0: 95 % interval of the mean over positions, for exact inputs" if has_area else "",
        f"Computed with stiction {version}" if version else "",
    ]
    return " ".join(f"{sentence[0].upper()}{sentence[1:]}." for sentence in sentences if sentence)


def _to_latex(text: str) -> str:
    """Convert text to one line of LaTeX: escape special characters, and replace symbols by LaTeX commands."""
    return _SYMBOL_PATTERN.sub(lambda match: _LATEX_SYMBOLS[match[0]], printable_text(text, sys.maxsize))


def _point_cells(point: PointSummary, has_area: bool) -> list[str]:
    """Return the cells of a LaTeX table row: one coefficient per sliding rule, area fraction, and assessment."""
    coefficient_texts = [coefficient_text(point, rule) for rule in point.rules]
    if has_area:
        fraction = point.quantities["contact_area_fraction"].in_unit("%", 0.01)
        is_printed = point.contact_status == STATUS_OK and not math.isnan(fraction.value)
        coefficient_texts.append(
            f"{fraction.text()} %" if is_printed else point.contact_status.replace(STATUS_OK, "none")
        )
    return [cell.translate(_LATEX_ESCAPES) for cell in (*coefficient_texts, point.assessment)]


def _column_heading(name: str) -> str:
    """Return the heading of a table column: the name of a quantity with its unit."""
    return _COORDINATE_HEADINGS.get(name, _to_latex(column_title_and_factor(name)[0].replace("tau0", "τ0")))


def _coordinate_text(name: str, point: PointSummary) -> str:
    if name == "cut_off" and point.cutoffs is not None:
        return cutoff_text(point.cutoffs, lambda length: format_significant(length, 4))
    factor = 1.0 if name in _COORDINATE_HEADINGS else column_title_and_factor(name)[1]
    return format_significant(factor * point.at[name], 4)


def _latex_row(cells: Sequence[str]) -> str:
    return " & ".join(cells) + r" \\"
