"""How values are distributed: friction over the members of a result, and areas of contacts and pressures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray
from matplotlib.figure import Figure

from stiction._drawing import few_ticks
from stiction.views.digits import with_unit
from stiction.views.point import STATISTICS, by_rule
from stiction.views.style import RULE_WORDS, RULES, dimension_colours, friction_parameters_text, label, new_figure


def positions_figure(values: xarray.DataArray, points: xarray.Dataset, *, title: str = "") -> Figure:
    """Friction coefficient of each member in each single direction; 80 mm wide.

    Values are over repetition, direction and sliding, and `points` are their means, as for `compass_figure`. Members of
    several offsets along one line are drawn over the offset, others in the order of their values. A test slides one
    way, so that directions are not put together.
    """
    figure = new_figure(62)
    axes = figure.subplots()
    by_offset = _moves_along_a_line(values)
    highest = float(np.nanmax(values.values)) if np.isfinite(values.values).any() else 1.0
    for rule in (rule for rule in RULES if rule in np.atleast_1d(values["sliding"].values)):
        own = by_rule(values, rule)
        known = own.values[np.isfinite(own.values)]
        if by_offset:
            x, y = np.repeat(values["x"].values, values.sizes["direction"]), own.values.ravel()
        else:
            x, y = np.arange(1, known.size + 1), np.sort(known)
        axes.plot(x, y, "o", color=RULES[rule], markersize=2.5, markeredgewidth=0, alpha=0.8, label=RULE_WORDS[rule])
        mean = by_rule(points["friction_all_round"], rule)
        middle, low, high = (float(mean.sel(statistic=name)) for name in STATISTICS)
        axes.axhspan(low, high, color=RULES[rule], alpha=0.15, linewidth=0)
        axes.axhline(middle, color=RULES[rule], linewidth=0.6)
    axes.set(ylim=(0, 1.05 * max(highest, 1e-3)), ylabel=label("friction_coefficient"))
    axes.set_xlabel("offset of the upper body (µm)" if by_offset else "members and directions, in order")
    parameters = friction_parameters_text(float(points["mu0"]), float(points["tau0"]))
    head = f"at {with_unit(float(points['load']), 'mN')}, {parameters}, single directions"
    figure.suptitle(f"{title}\n{head}".strip(), fontsize=6)
    missing = int(np.isnan(values.values).reshape(values.shape[0], -1).any(axis=-1).sum())
    note = f"; {missing} members have no answer" if missing else ""
    figure.legend(
        *axes.get_legend_handles_labels(), title=f"lines: means; bands: their 95 %{note}", loc="outside lower center",
        ncols=2,
    )  # fmt: skip
    return figure


def _moves_along_a_line(values: xarray.DataArray) -> bool:
    """Whether the members are one pair of lines at several offsets."""
    if "x" not in values.coords or "line" not in values.coords:
        return False
    lines, offsets = np.unique(values["line"].values), np.unique(values["x"].values)
    return bool(lines.size == 1 and offsets.size == values.sizes["repetition"] > 1 and not values["y"].values.any())


def sizes_figure(
    members: xarray.Dataset, points: xarray.Dataset, *, hardness: float | None = None, title: str = ""
) -> Figure:
    """Fraction of the contacts against their area, and of the true area against pressure; 80 mm wide.

    Members have patch_area (µm²) and pressure (GPa) over repetition, load and fraction_below, each a thin line;
    `points` are their means, as `at_load` returns them, of one cell. A hardness (GPa) is marked.
    """
    figure = new_figure(96)
    axes: Sequence[Any] = figure.subplots(2, 1)
    percent = 100 * points["fraction_below"].values
    loads = np.atleast_1d(points["load"].values)
    for load, colour in zip(loads, dimension_colours(loads), strict=True):
        for ax, name in zip(axes, ("patch_area", "pressure"), strict=True):
            for own in members[name].sel(load=load, method="nearest").transpose("repetition", "fraction_below").values:
                ax.plot(own, percent, color=colour, linewidth=0.3, alpha=0.4)
            mean = points[name].sel(load=load, statistic="mean").values
            ax.plot(mean, percent, color=colour, linewidth=1.2, label=with_unit(float(load), "mN"))
    for ax, name in zip(axes, ("patch_area", "pressure"), strict=True):
        ax.set(ylim=(0, 100), xlabel=label(name), xscale="log")
        few_ticks(ax)
    axes[0].set_ylabel("contacts that are smaller (%)")
    axes[1].set_ylabel("true contact area\nat lower pressure (%)")
    if hardness is not None:
        axes[1].axvline(hardness, color="0.3", linewidth=0.6, linestyle="--")
        axes[1].text(hardness, 90, "hardness ", fontsize=6, color="0.3", ha="right", va="center")
    axes[0].set_title(title, loc="left", fontsize=6, pad=3)
    named = axes[0].get_legend_handles_labels()
    figure.legend(*named, title="thick: mean over members; thin: each", loc="outside lower center", ncols=3)
    return figure
