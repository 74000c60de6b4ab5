"""What holds a pair, what would be left of its interval if an input were known, and how it grows under load."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure

from stiction._number_format import duration, quoted
from stiction.studies.summary import PointSummary
from stiction.views.style import AREA, FRICTION, LEANING, OPPOSING, label, new_figure

SHOWN = 0.02  # part of the width that an input has to take away to be drawn
MOST = 5  # most inputs that are drawn


def budget_figure(answer: PointSummary, *, title: str = "") -> Figure:
    """A bar of what holds the bodies with the whole interval, and below it what would be left; 80 mm wide."""
    width = answer.upper - answer.lower
    left = [each for each in answer.budget if each.width < (1 - SHOWN) * width][:MOST]
    test = answer.rules[0].next_test
    rows = [("all that is known", answer.lower, answer.upper)]
    rows += [(f"{each.words} known", each.lower, each.upper) for each in left]
    figure = new_figure(34 + 5 * len(rows))
    axes: Any = figure.subplots()
    start = 0.0
    words = (r"$\mu_0$", r"$\tau_0$ on the true area", "slopes")
    for part, colour, word in zip(answer.parts or (answer.value,), (LEANING, AREA, OPPOSING), words, strict=False):
        axes.barh(0, part, left=start, height=0.6, color=colour, label=word if answer.parts else None)
        start += part
    ends = [[answer.value - answer.lower], [answer.upper - answer.value]]
    axes.errorbar([answer.value], [0], xerr=ends, color="black", capsize=3, linewidth=1.2)
    axes.plot(test, [0.45, 0.45], color=FRICTION, linewidth=2, label="next test, 95 %")
    for row, (_, low, high) in enumerate(rows, 1):
        axes.plot([low, high], [row, row], color="black", linewidth=3 if row == 1 else 1.5, solid_capstyle="butt")
    axes.set_yticks(range(len(rows) + 1), ["what holds it", *(name for name, _, _ in rows)])
    axes.invert_yaxis()
    title = f"{title}\n{quoted(answer.value, answer.lower, answer.upper)}".strip()
    axes.set(xlim=(0, None), xlabel=label("friction_coefficient"), title=title)
    figure.legend(loc="outside lower center", ncols=2)
    return figure


def waiting_figure(answer: PointSummary, *, title: str = "") -> Figure:
    """The coefficient over the logarithm of the time under load, with its 95 % interval; 80 mm wide."""
    first = answer.rules[0]
    rows = [(1.0, first.value, first.lower, first.upper)]
    rows += [(each.seconds, each.value, each.lower, each.upper) for each in answer.waited if each.seconds != 1]
    seconds, values, lower, upper = zip(*sorted(rows), strict=True)
    figure = new_figure(60)
    axes = figure.subplots()
    axes.fill_between(seconds, lower, upper, color=FRICTION, alpha=0.25, linewidth=0, label="95 %, all that is known")
    axes.plot(seconds, values, "o-", color=FRICTION)
    axes.set(xscale="log", xlabel="time under load before it is sheared", title=title)
    axes.set(ylabel=label("friction_coefficient"), ylim=(0, None))
    axes.set_xticks(seconds, [duration(each) for each in seconds])
    axes.minorticks_off()
    axes.legend(loc="lower right")
    return figure
