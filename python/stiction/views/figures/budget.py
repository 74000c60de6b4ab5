"""Figures: contributions to friction, uncertainty budget, and friction as a function of dwell time."""

from __future__ import annotations

import textwrap
from typing import Any

from matplotlib.figure import Figure

from stiction._number_format import format_time
from stiction.summary.summary import PointSummary
from stiction.views.style import (
    AREA_COLOUR,
    FRICTION_COLOUR,
    NOT_OPPOSING_CONTACT_COLOUR,
    OPPOSING_CONTACT_COLOUR,
    axis_label,
    new_figure,
)

MIN_DRAWN_INTERVAL_REDUCTION = 0.02
MAX_DRAWN_INPUTS = 5
MAX_ROW_LABEL_WIDTH = 20  # characters


_CONTRIBUTION_STYLES = {
    "": (NOT_OPPOSING_CONTACT_COLOUR, None), "mu0": (NOT_OPPOSING_CONTACT_COLOUR, r"$\mu_0$"),
    "adhesion": (AREA_COLOUR, r"$\tau_0$ on the area at the onset"), "slopes": (OPPOSING_CONTACT_COLOUR, "slopes"),
    "mu0_and_adhesion": (NOT_OPPOSING_CONTACT_COLOUR, r"$\mu_0$ and $\tau_0$, not separated"),
}  # fmt: skip
"""Colour and label of each contribution to the coefficient, by the names of `PointSummary.contribution_terms`."""


def uncertainty_budget_figure(point: PointSummary, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: contributions to friction, combined interval, and uncertainty budget."""
    width = point.upper - point.lower
    remaining_inputs = [item for item in point.budget if item.width < (1 - MIN_DRAWN_INTERVAL_REDUCTION) * width][
        :MAX_DRAWN_INPUTS
    ]
    test_interval = point.rules[0].prediction_interval
    rows = [("combined interval", point.lower, point.upper)]
    rows += [(item.label.removeprefix("the "), item.lower, item.upper) for item in remaining_inputs]
    row_labels = [textwrap.fill(label, MAX_ROW_LABEL_WIDTH) for label, _, _ in rows]
    figure = new_figure(42 + 6 * len(rows))
    axes: Any = figure.subplots()
    contribution_start = 0.0
    terms = point.contribution_terms or {"": point.value}
    for name, contribution in terms.items():
        colour, label = _CONTRIBUTION_STYLES[name]
        axes.barh(0, contribution, left=contribution_start, height=0.6, color=colour, label=label)
        contribution_start += contribution
    interval_distances = [[point.value - point.lower], [point.upper - point.value]]
    axes.errorbar([point.value], [0], xerr=interval_distances, color="black", capsize=3, linewidth=1.2)
    axes.plot(test_interval, [0.45, 0.45], color=FRICTION_COLOUR, linewidth=2, label="single test, 95 %")
    for row, (_, lower_limit, upper_limit) in enumerate(rows, 1):
        label = "95 % if this input were exact" if row == 2 else ""
        linewidth = 3 if row == 1 else 1.5
        axes.plot(
            [lower_limit, upper_limit],
            [row, row],
            color="black",
            linewidth=linewidth,
            solid_capstyle="butt",
            label=label,
        )
    axes.set_yticks(range(len(rows) + 1), ["contributions", *row_labels])
    axes.invert_yaxis()
    title = f"{title}\n{point.rules[0]}".strip()
    axes.set(xlim=(0, None), xlabel=axis_label("friction_coefficient"), title=title)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def dwell_time_figure(point: PointSummary, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: the coefficient and its 95 % interval against the dwell time."""
    estimate = point.rules[0]
    rows = [(1.0, estimate.value, estimate.lower, estimate.upper)]
    rows += [
        (aged_estimate.seconds, aged_estimate.value, aged_estimate.lower, aged_estimate.upper)
        for aged_estimate in point.after_dwell
        if aged_estimate.seconds != 1
    ]
    seconds, values, lower, upper = zip(*sorted(rows), strict=True)
    figure = new_figure(60)
    axes = figure.subplots()
    axes.fill_between(seconds, lower, upper, color=FRICTION_COLOUR, alpha=0.25, linewidth=0, label="95 %, combined")
    axes.plot(seconds, values, "o-", color=FRICTION_COLOUR)
    axes.set(xscale="log", xlabel="dwell time", title=title)
    axes.set(ylabel=axis_label("friction_coefficient"), ylim=(0, None))
    axes.set_xticks(seconds, [format_time(aged_estimate) for aged_estimate in seconds])
    axes.minorticks_off()
    axes.legend(loc="lower right")
    return figure
