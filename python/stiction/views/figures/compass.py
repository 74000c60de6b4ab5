"""Friction around the compass: against the direction in which the upper body moves."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray
from matplotlib.figure import Figure

from stiction._checks import Floats
from stiction.views.digits import with_unit
from stiction.views.point import STATISTICS, by_rule
from stiction.views.style import RULE_WORDS, RULES, friction_parameters_text, label, new_figure

FEWEST_DIRECTIONS = 3  # from which on there is a compass to draw
RINGS = 5


def compass_figure(points: xarray.Dataset, *, title: str = "") -> Figure:
    """Friction coefficient against the direction of the motion, by each sliding rule; 80 mm wide.

    It is of what `at_load` returns at one load and of one cell, mu0 and tau0. Between directions a smooth curve is
    drawn.
    """
    at = points.sortby("direction")
    degrees = np.asarray(at["direction"].values, dtype=np.float64)
    figure = new_figure(96)
    axes: Any = figure.add_subplot(projection="polar")
    fine = np.linspace(0, 360, 361)
    highest = 0.0
    rules = [rule for rule in RULES if rule in np.atleast_1d(at["sliding"].values)]
    for rule in rules:
        colour, own = RULES[rule], by_rule(at, rule)
        values = own["friction_coefficient"].transpose("statistic", "direction")
        mean, low, high = (values.sel(statistic=name).values for name in STATISTICS)
        axes.plot(np.radians(degrees), mean, "o", color=colour, markersize=2.5, label=RULE_WORDS[rule])
        highest = max(highest, float(np.nanmax(mean, initial=0.0)))
        if np.isfinite(mean).all():
            axes.plot(np.radians(fine), _smooth(degrees, mean, fine), color=colour, linewidth=1)
        if np.isfinite(low).all() and np.isfinite(high).all():
            ends = (_smooth(degrees, each, fine) for each in (low, high))
            axes.fill_between(np.radians(fine), *ends, color=colour, alpha=0.2, linewidth=0)
            highest = max(highest, min(float(high.max()), 2 * highest))
        if "gentle_friction" in own:
            alone = own["gentle_friction"]
            alone = alone.sel(statistic="mean") if "statistic" in alone.dims else alone
            if np.isfinite(alone.values).all():
                words = "by the slope of the gap alone" if rule == rules[0] else None
                axes.plot(
                    np.radians(fine), _smooth(degrees, alone.values, fine), ":", color="0.2", linewidth=0.8, label=words
                )
    _rings(axes, highest)
    ways = ("$+x$", "45°", "$+y$", "135°", "$-x$", "225°", "$-y$", "315°")
    axes.set_xticks(np.radians(np.arange(0, 360, 45)), ways)
    modulus = float(at["effective_modulus"]) if "effective_modulus" in at.coords else None
    load = f"{label('friction_coefficient')} at {with_unit(float(at['load']), 'mN')}"
    parameters = friction_parameters_text(float(at["mu0"]), float(at["tau0"]), modulus)
    figure.suptitle("\n".join(filter(None, (title, load, parameters))), fontsize=6)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower center", ncols=1,
        title="angle: motion of the upper body; bands: 95 %",
    )  # fmt: skip
    return figure


def _smooth(degrees: Floats, values: Floats, fine: Floats) -> Floats:
    """A periodic cubic spline through values around the compass, not below 0."""
    from scipy.interpolate import CubicSpline

    around = np.append(degrees, degrees[0] + 360)
    spline = CubicSpline(around, np.append(values, values[0]), bc_type="periodic")
    return np.asarray(np.maximum(spline((fine - degrees[0]) % 360 + degrees[0]), 0))


def _rings(axes: Any, highest: float) -> None:
    """Rings at round numbers from 0 on, and their numbers on white between two of the spokes."""
    least = (highest or 1.0) / RINGS
    power = 10.0 ** np.floor(np.log10(least))
    step = float(next(factor * power for factor in (1, 2, 5, 10) if factor * power >= least * (1 - 1e-9)))
    ticks = step * np.arange(1, int(np.ceil((highest or 1.0) / step - 1e-9)) + 1)
    axes.set_ylim(0, ticks[-1])
    axes.grid(linewidth=0.3, color="0.8")
    axes.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axes.set_rlabel_position(67.5)
    for text in axes.get_yticklabels():
        text.set(fontsize=6, bbox={"facecolor": "white", "linewidth": 0, "pad": 0.4, "alpha": 0.9})
