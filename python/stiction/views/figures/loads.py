"""Figures of friction and contact area against load or cutoff, of joint closure, and of adhesive loading cycles."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, LogFormatterMathtext, LogLocator, MaxNLocator, NullLocator

from stiction._checks import Floats
from stiction._drawing import set_log_tick_labels
from stiction._number_format import choose_prefixed_unit
from stiction.companions.contact_picture import LOADS_RELATIVE_TO_PULL_OFF
from stiction.companions.resolution import ResolutionLimits
from stiction.evaluate.point import MEAN_AND_LIMITS, select_sliding_rule
from stiction.mechanics.quantities import find_interval_kind
from stiction.views.figures.column_layout import ColumnLayout
from stiction.views.style import (
    ALL_CONTACTS_COLOUR,
    AREA_COLOUR,
    OPPOSING_CONTACT_COLOUR,
    SLIDING_RULE_COLOURS,
    SLIDING_RULE_LABELS,
    axis_label,
    direction_text,
    friction_parameters_text,
    interval_bands_text,
    new_figure,
)

MAX_FRICTION_AXIS_RATIO = 4.0
"""Maximum ratio of the upper limit of the friction axis to the highest mean. Longer interval bands are cut off."""

MAX_DRAWN_DIRECTIONS = 2

MAX_PLAIN_LABEL_RATIO = 2e3
"""Maximum ratio of the limits of a logarithmic axis with plain numbers as labels."""


def friction_by_load_figure(points: xarray.Dataset, study_loads: Sequence[float] = (), *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: friction coefficient and true contact area against load.

    `points` is a dataset from `add_uncertainty` for one cutoff, mu0 and tau0. The loads of the study (mN) are marked.
    The bands of friction are the combined interval and, in a darker colour, the interval of the mean over positions.
    """
    loads = np.asarray(points["load"].values, dtype=np.float64)
    figure = _friction_and_area_figure(points, "load", loads, title)
    friction_axes, area_axes = figure.axes[:2]
    for ax, load in itertools.product((friction_axes, area_axes), study_loads):
        ax.axvline(load, color="0.5", linewidth=0.5, linestyle="--")
    area_axes.set_xlabel(axis_label("load"))
    if "nominal_area" in points.coords:
        area = float(points["nominal_area"])
        pressure_conversions: Any = (lambda load: 1000 * load / area, lambda pressure: pressure * area / 1000)
        pressure_axis = friction_axes.secondary_xaxis("top", functions=pressure_conversions)
        pressure_axis.set_xlabel(axis_label("nominal_pressure"))
        format_log_axis(pressure_axis.xaxis, friction_axes.get_xlim())
    return figure


def closure_figure(points: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: closure and closure stiffness over nominal pressure."""
    pressure_per_load = 1000 / float(points["nominal_area"])  # MPa/mN
    figure = new_figure(100)
    for ax, name in zip(figure.subplots(2, 1, sharex=True), ("closure", "closure_stiffness"), strict=True):
        x = pressure_per_load * np.asarray(points["load"].values, dtype=np.float64)
        draw_curve_with_band(ax, x, points[name], AREA_COLOUR)
        ax.set(ylabel=axis_label(name), ylim=(0, None))
    figure.axes[1].set(xlabel=axis_label("nominal_pressure"), xlim=(0, None))
    is_combined = find_interval_kind("closure", points["closure"].attrs) == "combined"
    has_bands = bool(np.isfinite(points["closure_stiffness"].sel(statistic="lower")).any())
    bands_label = interval_bands_text(points, combined=is_combined) if has_bands else ""
    figure.suptitle("\n".join(filter(None, (title, bands_label))), fontsize=6)
    return figure


def adhesion_figure(branches: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: load against approach and true area, during adhesive loading and unloading.

    `branches` is `Result.loading_cycle`. The pull-off force is marked.
    """
    is_unloading = branches["going"].values
    load, area = branches["load"].values, branches["contact_area"].values
    is_visible = load <= LOADS_RELATIVE_TO_PULL_OFF[-1] * -load.min() * 1.001
    prefix_factor, unit = choose_prefixed_unit(float(abs(load[is_visible]).max()), "mN")
    figure = new_figure(70)
    abscissas = [(branches["approach"].values * 1000, "approach (nm)")] if branches["approach"].notnull().all() else []
    panels: Any = figure.subplots(1, len(abscissas) + 1, sharey=True, squeeze=False)[0]
    nominal_area = float(branches.attrs["nominal_area"])
    abscissas.append((100 * area / nominal_area, axis_label("contact_area_fraction")))
    for axes, (x, x_label) in zip(panels, abscissas, strict=True):
        axes.axhline(0, color="0.6", linewidth=0.5)
        for is_drawn, line_style, options in (
            (~is_unloading, "o-", {"color": ALL_CONTACTS_COLOUR, "markersize": 3, "linewidth": 1, "label": "loading"}),
            (is_unloading, "--", {"color": OPPOSING_CONTACT_COLOUR, "linewidth": 1.2, "label": "unloading"}),
        ):
            axes.plot(x[is_drawn], load[is_drawn] / prefix_factor, line_style, **options)
        pull_off_index = int(load.argmin())
        axes.plot(
            x[pull_off_index],
            load[pull_off_index] / prefix_factor,
            "v",
            color=AREA_COLOUR,
            markersize=5,
            label="pull-off force",
        )
        axes.set(xlim=_add_margins_to_range(x[is_visible]), xlabel=x_label)
    panels[0].set(ylim=_add_margins_to_range(load[is_visible] / prefix_factor), ylabel=f"load ({unit})")
    figure.suptitle(title, fontsize=6)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _add_margins_to_range(values: Floats) -> tuple[float, float]:
    lowest_value, highest_value = float(values.min()), float(values.max())
    margin = 0.06 * (highest_value - lowest_value) or 1.0
    return lowest_value - margin, highest_value + margin


def cut_off_figure(limits: ResolutionLimits, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: friction coefficient and true area over the cutoff, at one load.

    Unfiltered surfaces (cutoff 0) are drawn at their shortest resolved wavelength or, if this is unknown or not clearly
    below the shortest cutoff, to the left of the shortest cutoff. The figure also has a line at the plastic limit,
    dashed lines for extrapolated friction and area, and a grey band over unresolved wavelengths.
    """
    cut_off = np.asarray(limits.points["cut_off"].values, dtype=np.float64)
    shortest_cutoff = cut_off[cut_off > 0].min(initial=2.0)
    unfiltered_position = limits.shortest or shortest_cutoff
    if not unfiltered_position < shortest_cutoff / MIN_MARKER_WAVELENGTH_RATIO:
        unfiltered_position = shortest_cutoff / SHORTEST_CUTOFF_TO_UNFILTERED_POSITION_RATIO
    positions = np.where(cut_off > 0, cut_off, unfiltered_position)
    figure = _friction_and_area_figure(limits.points, "cut_off", positions, title, limits)
    figure.axes[1].set_xlabel(axis_label("cut_off") + ("; first point: none" if (cut_off == 0).any() else ""))
    return figure


MIN_MARKER_WAVELENGTH_RATIO = 1.05
SHORTEST_CUTOFF_TO_UNFILTERED_POSITION_RATIO = 1.5
"""Ratio of the shortest cutoff to the position at which unfiltered scans of unknown resolution are drawn."""

MAX_CLOSED_FORM_TO_CUTOFF_RATIO = 8.0
MIN_EXTRAPOLATED_TO_CUTOFF_RATIO = 1 / 16


def _draw_resolution_limits(friction_axes: Axes, area_axes: Axes, limits: ResolutionLimits, x: Floats) -> None:
    """Draw three estimates of friction and area for finer scans: plastic limit, extrapolation, closed-form estimate."""
    if limits.plastic_limit is not None:
        friction, area_fraction = limits.plastic_limit
        friction_axes.axhline(
            friction, color=SLIDING_RULE_COLOURS["all"], linewidth=0.8, linestyle=":", label="plastic limit"
        )
        area_axes.axhline(100 * area_fraction, color=AREA_COLOUR, linewidth=0.8, linestyle=":")
    wavelengths = limits.wavelengths
    is_shown = wavelengths >= MIN_EXTRAPOLATED_TO_CUTOFF_RATIO * x[x > 0].min()
    for axes, spectral_friction, colour in (
        (friction_axes, limits.friction, SLIDING_RULE_COLOURS["all"]),
        (area_axes, 100 * limits.area_fractions, AREA_COLOUR),
    ):
        if not np.isfinite(spectral_friction[is_shown, 0]).any():
            continue
        mean, lower_limits, upper_limits = spectral_friction[is_shown].T
        curve_label = "extrapolated with H" if axes is friction_axes else None
        axes.fill_between(wavelengths[is_shown], lower_limits, upper_limits, color=colour, alpha=0.1, linewidth=0)
        axes.plot(wavelengths[is_shown], mean, "--", color=colour, linewidth=0.8, label=curve_label)
        if axes is friction_axes:
            axes.set_ylim(0, max(axes.get_ylim()[1], 1.05 * float(np.nanmax(mean))))
    if (spectral_estimate := limits.spectral) is not None:
        spectral_estimate = spectral_estimate.isel(
            wavelength=spectral_estimate.wavelength <= MAX_CLOSED_FORM_TO_CUTOFF_RATIO * x.max()
        )
        for rule in spectral_estimate.sliding.values:
            curve_label = "estimate from spectra" if rule == "all" else None
            spectral_friction = spectral_estimate.friction_coefficient.sel(sliding=rule)
            friction_axes.plot(
                spectral_estimate.wavelength,
                spectral_friction,
                "-.",
                color=SLIDING_RULE_COLOURS[str(rule)],
                linewidth=0.8,
                label=curve_label,
            )
        area_axes.plot(
            spectral_estimate.wavelength,
            100 * spectral_estimate.contact_area_fraction,
            "-.",
            color=AREA_COLOUR,
            linewidth=0.8,
        )
    if limits.shortest:
        # If the first point is at the shortest resolved wavelength, the band of unresolved ones must not cover it.
        longest_unresolved = 0.97 * min(limits.shortest, x.min())
        for axes in (friction_axes, area_axes):
            axes.axvspan(1e-9, longest_unresolved, color="0.9", linewidth=0, zorder=-2, label="not resolved")


def _friction_and_area_figure(
    points: xarray.Dataset, dimension: str, x: Floats, title: str, limits: ResolutionLimits | None = None
) -> Figure:
    figure = new_figure(114, layout=ColumnLayout())
    friction_axes, area_axes = figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1])
    has_combined = "friction_combined" in points
    for rule in _list_sliding_rules(points):
        dataset, colour = select_sliding_rule(points, rule), SLIDING_RULE_COLOURS[rule]
        draw_curve_with_band(friction_axes, x, dataset["mean_friction"], colour, label=SLIDING_RULE_LABELS[rule])
        if has_combined:
            lower_limits, upper_limits = (
                dataset["friction_combined"].sel(statistic=name).values for name in MEAN_AND_LIMITS[1:]
            )
            friction_axes.fill_between(x, lower_limits, upper_limits, color=colour, alpha=0.2, linewidth=0)
        _draw_single_directions(friction_axes, dataset, x, colour)
    _mark_points_with_missing_coefficients(friction_axes, points, dimension, x)
    has_fraction = "contact_area_fraction" in points
    area = 100 * points["contact_area_fraction"] if has_fraction else points["contact_area"]
    mean_area = draw_curve_with_band(area_axes, x, area, AREA_COLOUR)
    for ax in (friction_axes, area_axes):
        ax.set_xscale("log")
    if (mean_area > 0).any():
        area_axes.set_yscale("log")
    highest_mean = max(
        line.get_ydata().max(initial=0.0, where=np.isfinite(line.get_ydata())) for line in friction_axes.lines
    )
    friction_axes.set_ylim(
        0, min(friction_axes.get_ylim()[1], MAX_FRICTION_AXIS_RATIO * highest_mean) if highest_mean > 0 else None
    )
    if limits is not None:
        is_shown = limits.wavelengths >= MIN_EXTRAPOLATED_TO_CUTOFF_RATIO * x.min()
        left_limit = min([*x, *limits.wavelengths[is_shown]])
        _draw_resolution_limits(friction_axes, area_axes, limits, x)
        area_axes.set_xlim(
            left_limit / 1.2, (1.2 if limits.spectral is None else MAX_CLOSED_FORM_TO_CUTOFF_RATIO) * x.max()
        )
    friction_axes.set_ylabel(axis_label("friction_coefficient"))
    area_axes.set_ylabel(axis_label("contact_area_fraction" if has_fraction else "contact_area"))
    for ax in (friction_axes, area_axes):
        set_log_tick_labels(ax)
    format_log_axis(area_axes.xaxis)
    bottom, top = area_axes.get_ylim()
    if area_axes.get_yscale() == "log" and top < 30 * bottom:
        format_log_axis(area_axes.yaxis)
    modulus = float(points["effective_modulus"]) if "effective_modulus" in points.coords else None
    parameters = friction_parameters_text(float(points["mu0"]), float(points["tau0"]), modulus)
    figure.suptitle(f"{title}\n{parameters}".strip(), fontsize=6)
    bands_label = (
        f"{interval_bands_text(points, combined=True, bands='light bands and area')}\n"
        f"{interval_bands_text(points, bands='dark bands')}"
        if has_combined
        else interval_bands_text(points)
    )
    handles = friction_axes.get_legend_handles_labels()
    figure.legend(*handles, title=bands_label, loc="outside lower center", ncols=2)
    return figure


def draw_curve_with_band(axes: Axes, x: Floats, values: xarray.DataArray, colour: str, *, label: str = "") -> Floats:
    """Draw mean values as a curve with markers, and their 95 % intervals as a band; return the mean values."""
    mean, lower_limits, upper_limits = (values.sel(statistic=name).values for name in MEAN_AND_LIMITS)
    axes.fill_between(x, lower_limits, upper_limits, color=colour, alpha=0.2, linewidth=0)
    axes.plot(x, mean, "o-", color=colour, linewidth=1, markersize=2, label=label or None)
    return np.asarray(mean)


def _list_sliding_rules(points: xarray.Dataset) -> list[str]:
    return np.atleast_1d(points["sliding"].values).tolist() if "sliding" in points.coords else ["opposing"]


def _draw_single_directions(axes: Axes, dataset: xarray.Dataset, x: Floats, colour: str) -> None:
    if not 1 < dataset.sizes.get("direction", 1) <= MAX_DRAWN_DIRECTIONS or colour == SLIDING_RULE_COLOURS["all"]:
        # If friction acts at all contacts, opposite directions have equal friction, so only the mean is drawn.
        return
    for direction, line_style in zip(dataset["direction"].values, ("--", ":"), strict=False):
        mean = dataset["friction_coefficient"].sel(direction=direction, statistic="mean").values
        name = f"  upper body to {direction_text(float(direction))} alone"
        axes.plot(x, mean, line_style, color=colour, linewidth=0.6, label=name)


def _mark_points_with_missing_coefficients(axes: Axes, points: xarray.Dataset, dimension: str, x: Floats) -> None:
    """Mark the points of a curve for which some surface pairs have no coefficient."""
    if not {"ok", "members"} <= set(points.variables):
        return
    num_solved = points["ok"].min([dim for dim in points["ok"].dims if dim != dimension])
    is_incomplete = (num_solved > 0).values & (num_solved < points["members"].max()).values
    if not is_incomplete.any():
        return
    mean = select_sliding_rule(points["mean_friction"], _list_sliding_rules(points)[0]).sel(statistic="mean").values
    axes.plot(x[is_incomplete], mean[is_incomplete], "x", color="0.3", markersize=4, label="some results are missing")


def format_log_axis(axis: Any, limits: tuple[float, float] | None = None) -> None:
    """Label a logarithmic axis with several plain numbers per decade or, for long axes, with powers of ten.

    Axes that span more than `MAX_PLAIN_LABEL_RATIO` are labelled with powers of ten. For a secondary axis, `limits`
    are the limits of its main axis, because a secondary axis has no limits before it is drawn.
    """
    axis_start, axis_end = limits or axis.get_view_interval()
    if axis_end > MAX_PLAIN_LABEL_RATIO * axis_start:
        axis.set_major_locator(LogLocator(numticks=8))
        axis.set_major_formatter(LogFormatterMathtext())
    else:
        spans_decade = axis_end >= 10 * axis_start
        axis.set_major_locator(
            LogLocator(subs=(1.0, 2.0, 5.0), numticks=8) if spans_decade else MaxNLocator(4, steps=[1, 2, 5, 10])
        )
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_locator(NullLocator())
