"""What holds a pair, what is not known of it, and what would be left if one input were."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stiction.views.digits import quoted
from stiction.views.style import AREA, FRICTION, LEANING, MILLIMETRE, OPPOSING, WIDTH, label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stiction.views.answer import Answer

SHOWN = 0.02
"""Part of the width that an input has to take away to be drawn."""

MOST = 5
"""Inputs that are drawn at most."""


def budget_figure(answer: Answer, *, title: str = "") -> Figure:
    """A bar of what holds the bodies with the whole interval, and below it what would be left; 80 mm wide."""
    from matplotlib.figure import Figure

    width = answer.upper - answer.lower
    left = [each for each in answer.budget if each.width < (1 - SHOWN) * width][:MOST]
    test = answer.rules[0].next_test
    rows = [("all that is known", answer.lower, answer.upper)]
    rows += [(f"{each.words} known", each.lower, each.upper) for each in left]
    figure = Figure(figsize=(WIDTH, (34 + 5 * len(rows)) * MILLIMETRE), layout="constrained")
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
    axes.set_xlim(left=0)
    axes.set_xlabel(label("friction_coefficient"))
    axes.set_title(f"{title}\n{quoted(answer.value, answer.lower, answer.upper)}".strip())
    figure.legend(loc="outside lower center", ncols=2)
    return figure
