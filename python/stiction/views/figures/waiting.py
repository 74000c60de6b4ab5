"""How static friction grows while bodies wait under load."""

from __future__ import annotations

from typing import TYPE_CHECKING

from stiction.views.digits import duration
from stiction.views.style import FRICTION, MILLIMETRE, WIDTH, label

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from stiction.views.answer import Answer


def waiting_figure(answer: Answer, *, title: str = "") -> Figure:
    """The coefficient over the logarithm of the time under load, with its 95 % interval; 80 mm wide."""
    from matplotlib.figure import Figure

    first = answer.rules[0]
    rows = [(1.0, first.value, first.lower, first.upper)]
    rows += [(each.seconds, each.value, each.lower, each.upper) for each in answer.waited if each.seconds != 1]
    seconds, values, lower, upper = zip(*sorted(rows), strict=True)
    figure = Figure(figsize=(WIDTH, 60 * MILLIMETRE), layout="constrained")
    axes = figure.subplots()
    axes.fill_between(seconds, lower, upper, color=FRICTION, alpha=0.25, linewidth=0, label="95 %, all that is known")
    axes.plot(seconds, values, "o-", color=FRICTION)
    axes.set_xscale("log")
    axes.set_xticks(seconds, [duration(each) for each in seconds])
    axes.minorticks_off()
    axes.set_xlabel("time under load before it is sheared")
    axes.set_ylabel(label("friction_coefficient"))
    axes.set_ylim(bottom=0)
    axes.set_title(title)
    axes.legend(loc="lower right")
    return figure
