"""Friction and true contact area against load or the cut-off, closure, and the coming and going of adhesion."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullLocator

from stiction._checks import Floats
from stiction._drawing import set_log_ticks
from stiction._number_format import prefix
from stiction.studies.contact_picture import IN_PULL_OFFS
from stiction.studies.point import STATISTICS, by_rule
from stiction.views.style import (
    ALL,
    AREA,
    OPPOSING,
    RULE_WORDS,
    RULES,
    direction_text,
    friction_parameters_text,
    label,
    new_figure,
)

MOST_SHOWN = 4.0
"""Times the highest mean that the axis of coefficients reaches at most: an interval of few members may be wider."""

MOST_SINGLE_DIRECTIONS = 2  # directions that are drawn one by one beside their mean


BANDS = {
    True: "light bands: 95 %, combined uncertainty\ndark bands and area: 95 %, sampling of positions",
    False: "bands: 95 %, sampling of positions",
}
"""Names of the intervals that are drawn, with and without a combined one."""


def load_figure(points: xarray.Dataset, asked: Sequence[float] = (), *, title: str = "") -> Figure:
    """Friction coefficient by both sliding rules, and true contact area, against load; 80 mm wide.

    It is of what `add_uncertainty` returns, of one cell and one mu0 and tau0; loads that were asked for (mN) are
    marked. Friction has its combined interval, and darker the sampling interval of the mean over positions.
    """
    loads = np.asarray(points["load"].values, dtype=np.float64)
    figure = _against(points, "load", loads, title)
    upper, lower = figure.axes[:2]
    for ax, load in itertools.product((upper, lower), asked):
        ax.axvline(load, color="0.5", linewidth=0.5, linestyle="--")
    lower.set_xlabel(label("load"))
    if "nominal_area" in points.coords:
        area = float(points["nominal_area"])
        both: Any = (lambda load: 1000 * load / area, lambda pressure: pressure * area / 1000)
        top = upper.secondary_xaxis("top", functions=both)
        top.set_xlabel(label("nominal_pressure"))
        plain_log(top.xaxis)
    return figure


def closure_figure(points: xarray.Dataset, *, title: str = "") -> Figure:
    """Closure and its incremental stiffness against nominal pressure, of what `at_load` returns; 80 mm wide."""
    stress = 1000 / float(points["nominal_area"])  # MPa/mN
    figure = new_figure(100)
    for ax, name in zip(figure.subplots(2, 1, sharex=True), ("closure", "closure_stiffness"), strict=True):
        x = stress * np.asarray(points["load"].values, dtype=np.float64)
        mean, low, high = (points[name].sel(statistic=each).values for each in STATISTICS)
        ax.fill_between(x, low, high, color=AREA, alpha=0.2, linewidth=0)
        ax.plot(x, mean, "o-", color=AREA, linewidth=1, markersize=2)
        ax.set(ylabel=label(name), ylim=(0, None))
    figure.axes[1].set(xlabel=label("nominal_pressure"), xlim=(0, None))
    bands = BANDS[False] if np.isfinite(low).any() else ""
    figure.suptitle("\n".join(filter(None, (title, bands))), fontsize=6)
    return figure


def adhesion_figure(ways: xarray.Dataset, *, title: str = "") -> Figure:
    """Load against the approach, where it is known, and against the true area, coming and going; 80 mm wide.

    It is of what `coming_and_going` returns; the pull-off force is marked.
    """
    going = ways["going"].values
    load, area = ways["load"].values, ways["contact_area"].values
    near = load <= IN_PULL_OFFS[-1] * -load.min() * 1.001  # loads that are seen
    core, unit = prefix(float(abs(load[near]).max()), "mN")
    figure = new_figure(70)
    across = [(ways["approach"].values * 1000, "approach (nm)")] if ways["approach"].notnull().all() else []
    panels: Any = figure.subplots(1, len(across) + 1, sharey=True, squeeze=False)[0]
    nominal = float(ways.attrs["nominal_area"])
    across.append((100 * area / nominal, label("contact_area_fraction")))
    for axes, (x, words) in zip(panels, across, strict=True):
        axes.axhline(0, color="0.6", linewidth=0.5)
        axes.plot(x[~going], load[~going] / core, "o-", color=ALL, markersize=3, linewidth=1, label="coming")
        axes.plot(x[going], load[going] / core, "--", color=OPPOSING, linewidth=1.2, label="going")
        last = int(load.argmin())
        axes.plot(x[last], load[last] / core, "v", color=AREA, markersize=5, label="pull-off force")
        axes.set(xlim=_wider(x[near]), xlabel=words)
    panels[0].set(ylim=_wider(load[near] / core), ylabel=f"load ({unit})")
    figure.suptitle(title, fontsize=6)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _wider(values: Floats) -> tuple[float, float]:
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 1.0
    return low - room, high + room


def cut_off_figure(points: xarray.Dataset, *, title: str = "", limits: Mapping[str, Any] | None = None) -> Figure:
    """Friction coefficient and true contact area against the cut-off wavelength, at one load; 80 mm wide.

    It is of what `resolution_at` returns, at one load, mu0 and tau0. A cut-off of 0 leaves the surfaces as they were
    measured; it is drawn at their shortest wave where that is known, else to the left of the first one. Of the `limits`
    the plastic one is a line, what is continued dashed, and grey is where nothing was seen.
    """
    limits = limits or {}
    cut_off = np.asarray(points["cut_off"].values, dtype=np.float64)
    positive = cut_off[cut_off > 0].min(initial=2.0)
    shown = np.where(cut_off > 0, cut_off, limits.get("shortest") or positive / FINER_THAN_FIRST)
    figure = _against(points, "cut_off", shown, title, limits)
    figure.axes[1].set_xlabel(label("cut_off") + ("; first point: none" if (cut_off == 0).any() else ""))
    return figure


FINER_THAN_FIRST = 1.5
"""Times that the scan itself is drawn to the left of the first cut-off, where its shortest wave is not known."""

LONGEST = 8.0  # times the longest cut-off, as far as the closed form of spectra is drawn
FINEST = 1 / 16  # shortest wave over the first cut-off that a continued answer is drawn to


def _draw_limits(upper: Axes, lower: Axes, limits: Mapping[str, Any], x: Floats) -> None:
    """What lies beyond the scan, under what was computed."""
    if limits.get("friction") is not None:
        upper.axhline(limits["friction"], color=RULES["all"], linewidth=0.8, linestyle=":", label="plastic limit")
        lower.axhline(100 * limits["area_fraction"], color=AREA, linewidth=0.8, linestyle=":")
    waves = np.asarray(limits.get("wavelength", ()))
    there = waves >= FINEST * x[x > 0].min()
    for axes, name, factor, colour in (
        (upper, "finer_friction", 1.0, RULES["all"]),
        (lower, "finer_area_fraction", 100.0, AREA),
    ):
        if not there.any() or not np.isfinite(limits[name][there, 0]).any():
            continue
        mean, low, high = factor * limits[name][there].T
        words = "by the Hurst exponent" if axes is upper else None
        axes.fill_between(waves[there], low, high, color=colour, alpha=0.1, linewidth=0)
        axes.plot(waves[there], mean, "--", color=colour, linewidth=0.8, label=words)
        if axes is upper:
            axes.set_ylim(0, max(axes.get_ylim()[1], 1.05 * float(np.nanmax(mean))))
    spectral = limits.get("spectral")
    if spectral is not None:
        spectral = spectral.isel(wavelength=spectral.wavelength <= LONGEST * x.max())
        for rule in spectral.sliding.values:
            label = "by the spectra alone" if rule == "all" else None
            values = spectral.friction_coefficient.sel(sliding=rule)
            upper.plot(spectral.wavelength, values, "-.", color=RULES[str(rule)], linewidth=0.8, label=label)
        lower.plot(spectral.wavelength, 100 * spectral.contact_area_fraction, "-.", color=AREA, linewidth=0.8)
    if limits.get("shortest"):
        for axes in (upper, lower):
            axes.axvspan(1e-9, 0.97 * limits["shortest"], color="0.9", linewidth=0, zorder=-2, label="not seen")


def _against(
    points: xarray.Dataset, along: str, x: Floats, title: str, limits: Mapping[str, Any] | None = None
) -> Figure:
    figure = new_figure(114)
    upper, lower = figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1])
    has_combined = along == "load" and "friction_combined" in points
    for rule in _rules(points):
        at, colour = by_rule(points, rule), RULES[rule]
        mean, low, high = (at["friction_all_round"].sel(statistic=name).values for name in STATISTICS)
        upper.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0)
        if has_combined:
            low, high = (at["friction_combined"].sel(statistic=name).values for name in STATISTICS[1:])
            upper.fill_between(x, low, high, color=colour, alpha=0.2, linewidth=0)
        upper.plot(x, mean, "o-", color=colour, linewidth=1, markersize=2, label=RULE_WORDS[rule])
        _single_directions(upper, at, x, colour)
    _mark_incomplete(upper, points, along, x)
    has_fraction = "contact_area_fraction" in points
    area = 100 * points["contact_area_fraction"] if has_fraction else points["contact_area"]
    mean, low, high = (area.sel(statistic=name).values for name in STATISTICS)
    lower.fill_between(x, low, high, color=AREA, alpha=0.2, linewidth=0)
    lower.plot(x, mean, "o-", color=AREA, linewidth=1, markersize=2)
    for ax in (upper, lower):
        ax.set_xscale("log")
    if (mean > 0).any():
        lower.set_yscale("log")
    highest = max(line.get_ydata().max(initial=0.0, where=np.isfinite(line.get_ydata())) for line in upper.lines)
    upper.set_ylim(0, min(upper.get_ylim()[1], MOST_SHOWN * highest) if highest > 0 else None)
    if limits:
        left = min([*x, *(each for each in limits["wavelength"] if each >= FINEST * x.min())])
        _draw_limits(upper, lower, limits, x)
        lower.set_xlim(left / 1.2, (1.2 if limits.get("spectral") is None else LONGEST) * x.max())
    upper.set_ylabel(label("friction_coefficient"))
    lower.set_ylabel(label("contact_area_fraction" if has_fraction else "contact_area"))
    for ax in (upper, lower):
        set_log_ticks(ax)
    plain_log(lower.xaxis)
    low, high = lower.get_ylim()
    if lower.get_yscale() == "log" and high < 30 * low:
        plain_log(lower.yaxis)
    modulus = float(points["effective_modulus"]) if "effective_modulus" in points.coords else None
    parameters = friction_parameters_text(float(points["mu0"]), float(points["tau0"]), modulus)
    figure.suptitle(f"{title}\n{parameters}".strip(), fontsize=6)
    handles = upper.get_legend_handles_labels()
    figure.legend(*handles, title=BANDS[has_combined], loc="outside lower center", ncols=2)
    return figure


def _rules(points: xarray.Dataset) -> list[str]:
    there = np.atleast_1d(points["sliding"].values).tolist() if "sliding" in points.coords else ["opposing"]
    return [rule for rule in RULES if rule in there]


def _single_directions(axes: Axes, at: xarray.Dataset, x: Floats, colour: str) -> None:
    if not 1 < at.sizes.get("direction", 1) <= MOST_SINGLE_DIRECTIONS or colour == RULES["all"]:
        return  # where all contacts rub both are one line
    for direction, dashes in zip(at["direction"].values, ("--", ":"), strict=False):
        mean = at["friction_coefficient"].sel(direction=direction, statistic="mean").values
        name = f"  upper body to {direction_text(float(direction))} alone"
        axes.plot(x, mean, dashes, color=colour, linewidth=0.6, label=name)


def _mark_incomplete(axes: Axes, points: xarray.Dataset, along: str, x: Floats) -> None:
    """Crosses where some members have no answer."""
    if not {"ok", "members"} <= set(points.variables):
        return
    ok = points["ok"].min([dim for dim in points["ok"].dims if dim != along])
    some = (ok > 0).values & (ok < points["members"].max()).values
    if not some.any():
        return
    mean = by_rule(points["friction_all_round"], _rules(points)[0]).sel(statistic="mean").values
    axes.plot(x[some], mean[some], "x", color="0.3", markersize=4, label="some members have no answer")


def plain_log(axis: Any) -> None:
    """Numbers in place of powers of ten on an axis, several of them also within a decade."""
    low, high = axis.get_view_interval()
    several = high >= 10 * low
    axis.set_major_locator(
        LogLocator(subs=(1.0, 2.0, 5.0), numticks=8) if several else MaxNLocator(4, steps=[1, 2, 5, 10])
    )
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
