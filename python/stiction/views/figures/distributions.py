"""Figures of distributions: friction by direction and by surface pair, contact areas, and contact pressures."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray
from matplotlib.figure import Figure

from stiction._checks import Floats
from stiction._drawing import set_log_tick_labels
from stiction._number_format import format_with_unit
from stiction.evaluate.point import MEAN_AND_LIMITS, select_sliding_rule
from stiction.views.figures.column_layout import ColumnLayout
from stiction.views.style import (
    SLIDING_RULE_COLOURS,
    SLIDING_RULE_LABELS,
    axis_label,
    fractal_dimension_colours,
    friction_parameters_text,
    interval_bands_text,
    new_figure,
)

MIN_COMPASS_DIRECTIONS = 3
MAX_COMPASS_RINGS = 5


def friction_by_direction_figure(points: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: friction against the direction of motion, with one curve for each sliding rule.

    `points` is a dataset of `at_load` at one load, cutoff, mu0 and tau0. A smooth curve connects the directions.
    """
    dataset = points.sortby("direction")
    degrees = np.asarray(dataset["direction"].values, dtype=np.float64)
    figure = new_figure(96)
    axes: Any = figure.add_subplot(projection="polar")
    fine_degrees = np.linspace(0, 360, 361)
    highest_coefficient = 0.0
    rules = np.atleast_1d(dataset["sliding"].values).tolist()
    for rule in rules:
        colour, rule_values = SLIDING_RULE_COLOURS[rule], select_sliding_rule(dataset, rule)
        values = rule_values["friction_coefficient"].transpose("statistic", "direction")
        mean, lower_limits, upper_limits = (values.sel(statistic=name).values for name in MEAN_AND_LIMITS)
        axes.plot(np.radians(degrees), mean, "o", color=colour, markersize=2.5, label=SLIDING_RULE_LABELS[rule])
        highest_coefficient = max(highest_coefficient, float(np.nanmax(mean, initial=0.0)))
        if np.isfinite(mean).all():
            axes.plot(
                np.radians(fine_degrees), _interpolate_periodic(degrees, mean, fine_degrees), color=colour, linewidth=1
            )
        if np.isfinite(lower_limits).all() and np.isfinite(upper_limits).all():
            interval_limits = (
                _interpolate_periodic(degrees, interval_end, fine_degrees)
                for interval_end in (lower_limits, upper_limits)
            )
            axes.fill_between(np.radians(fine_degrees), *interval_limits, color=colour, alpha=0.2, linewidth=0)
            highest_coefficient = max(highest_coefficient, min(float(upper_limits.max()), 2 * highest_coefficient))
        if "gentle_friction" in rule_values:
            slope_estimate = rule_values["gentle_friction"]
            slope_estimate = (
                slope_estimate.sel(statistic="mean") if "statistic" in slope_estimate.dims else slope_estimate
            )
            if np.isfinite(slope_estimate.values).all():
                estimate_label = "small-slope estimate" if rule == rules[0] else None
                axes.plot(
                    np.radians(fine_degrees),
                    _interpolate_periodic(degrees, slope_estimate.values, fine_degrees),
                    ":",
                    color="0.2",
                    linewidth=0.8,
                    label=estimate_label,
                )
    _draw_circles_of_polar_axes(axes, highest_coefficient, degrees)
    direction_labels = ("$+x$", "45°", "$+y$", "135°", "$-x$", "225°", "$-y$", "315°")
    axes.set_xticks(np.radians(np.arange(0, 360, 45)), direction_labels)
    modulus = float(dataset["effective_modulus"]) if "effective_modulus" in dataset.coords else None
    coefficient_and_load_text = (
        f"{axis_label('friction_coefficient')} at {format_with_unit(float(dataset['load']), 'mN')}"
    )
    parameters = friction_parameters_text(float(dataset["mu0"]), float(dataset["tau0"]), modulus)
    figure.suptitle("\n".join(filter(None, (title, coefficient_and_load_text, parameters))), fontsize=6)
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside lower center",
        ncols=1,
        title=f"angle: motion of the upper body\n{interval_bands_text(points)}",
    )
    return figure


def _interpolate_periodic(degrees: Floats, values: Floats, new_degrees: Floats) -> Floats:
    """Interpolate friction over the direction (degrees) by a periodic cubic spline.

    Negative values become 0.
    """
    from scipy.interpolate import CubicSpline

    closed_degrees = np.append(degrees, degrees[0] + 360)
    spline = CubicSpline(closed_degrees, np.append(values, values[0]), bc_type="periodic")
    return np.asarray(np.maximum(spline((new_degrees - degrees[0]) % 360 + degrees[0]), 0))


def _draw_circles_of_polar_axes(axes: Any, highest: float, degrees: Floats) -> None:
    """Draw circles at round values in a polar plot, with labels that avoid the data points.

    A label has a white background, which hides the curves behind it.
    """
    min_ring_spacing = (highest or 1.0) / MAX_COMPASS_RINGS
    power_of_ten = 10.0 ** np.floor(np.log10(min_ring_spacing))
    ring_spacing = float(
        next(
            factor * power_of_ten for factor in (1, 2, 5, 10) if factor * power_of_ten >= min_ring_spacing * (1 - 1e-9)
        )
    )
    ticks = ring_spacing * np.arange(1, int(np.ceil((highest or 1.0) / ring_spacing - 1e-9)) + 1)
    axes.set_ylim(0, ticks[-1])
    axes.grid(linewidth=0.3, color="0.8")
    axes.set_yticks(ticks, [])
    label_direction = np.radians(_find_polar_angle_of_labels(degrees))
    for tick in ticks:
        axes.text(
            label_direction, tick, f"{tick:g}", fontsize=6, ha="center", va="center", zorder=5,
            bbox={"facecolor": "white", "linewidth": 0, "pad": 0.4, "alpha": 0.9},
        )  # fmt: skip


def _find_polar_angle_of_labels(degrees: Floats) -> float:
    """Return the direction (degrees, first quadrant) for circle labels that is farthest from data points and spokes."""
    candidates = np.array([67.5, 75.0, 60.0, 52.5, 22.5, 15.0, 30.0, 37.5])
    occupied_directions = np.concatenate([degrees, np.arange(0, 360, 45)])
    distances = np.abs((candidates[:, np.newaxis] - occupied_directions + 180) % 360 - 180).min(axis=1)
    return float(candidates[distances.argmax()])


def friction_by_position_figure(point: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: friction of each surface pair (such as a position) in each direction of motion.

    `point` comes from `evaluate_positions`. Members of a single traverse are drawn against the offset, other members in
    ascending order. Directions are not averaged, because a test slides in one direction.
    """
    member_friction = point["member_friction"]
    figure = new_figure(62, layout=ColumnLayout())
    axes = figure.subplots()
    by_offset = _has_single_profile_pair(member_friction)
    highest_coefficient = float(np.nanmax(member_friction.values)) if np.isfinite(member_friction.values).any() else 1.0
    for rule in np.atleast_1d(point["sliding"].values).tolist():
        rule_values = select_sliding_rule(member_friction, rule)
        finite_values = rule_values.values[np.isfinite(rule_values.values)]
        if by_offset:
            x, y = (
                np.repeat(member_friction["x"].values, member_friction.sizes["direction"]),
                rule_values.values.ravel(),
            )
        else:
            x, y = np.arange(1, finite_values.size + 1), np.sort(finite_values)
        axes.plot(
            x,
            y,
            "o",
            color=SLIDING_RULE_COLOURS[rule],
            markersize=2.5,
            markeredgewidth=0,
            alpha=0.8,
            label=SLIDING_RULE_LABELS[rule],
        )
        mean = select_sliding_rule(point["mean_friction"], rule)
        mean_value, lower_limit, upper_limit = (float(mean.sel(statistic=name)) for name in MEAN_AND_LIMITS)
        axes.axhspan(lower_limit, upper_limit, color=SLIDING_RULE_COLOURS[rule], alpha=0.15, linewidth=0)
        axes.axhline(mean_value, color=SLIDING_RULE_COLOURS[rule], linewidth=0.6)
    axes.set(ylim=(0, 1.05 * max(highest_coefficient, 1e-3)), ylabel=axis_label("friction_coefficient"))
    axes.set_xlabel("offset of the upper body (µm)" if by_offset else "single results, in ascending order")
    parameters = friction_parameters_text(float(point["mu0"]), float(point["tau0"]))
    caption = f"at {format_with_unit(float(point['load']), 'mN')}, {parameters}, single directions"
    figure.suptitle(f"{title}\n{caption}".strip(), fontsize=6)
    num_missing = int(np.isnan(member_friction.values).reshape(member_friction.shape[0], -1).any(axis=-1).sum())
    note = f"; {num_missing} of {member_friction.shape[0]} results are incomplete" if num_missing else ""
    legend_title = f"lines: means; {interval_bands_text(point)}{note}"
    figure.legend(*axes.get_legend_handles_labels(), title=legend_title, loc="outside lower center", ncols=2)
    return figure


def _has_single_profile_pair(values: xarray.DataArray) -> bool:
    """Return whether all surface pairs of a study consist of the same two profiles, shifted along each other."""
    if "x" not in values.coords or "line" not in values.coords:
        return False
    lines, offsets = np.unique(values["line"].values), np.unique(values["x"].values)
    return bool(lines.size == 1 and offsets.size == values.sizes["repetition"] > 1 and not values["y"].values.any())


def contact_sizes_figure(
    members: xarray.Dataset, points: xarray.Dataset, *, hardness: float | None = None, title: str = ""
) -> Figure:
    """Draw a figure 80 mm wide: distribution of contact sizes, and distribution of pressures (weighted by area).

    `members` contains patch_area (µm²) and pressure (GPa) over repetition, load and fraction_below, which are drawn as
    thin lines. `points` contains the means for a single cutoff, as returned by `at_load`. The hardness (GPa) is marked.
    """
    figure = new_figure(96)
    axes: Sequence[Any] = figure.subplots(2, 1)
    fraction_percent = 100 * points["fraction_below"].values
    loads = np.atleast_1d(points["load"].values)
    for load, colour in zip(loads, fractal_dimension_colours(loads), strict=True):
        for ax, name in zip(axes, ("patch_area", "pressure"), strict=True):
            for member_values in (
                members[name].sel(load=load, method="nearest").transpose("repetition", "fraction_below").values
            ):
                ax.plot(member_values, fraction_percent, color=colour, linewidth=0.3, alpha=0.4)
            mean = points[name].sel(load=load, statistic="mean").values
            ax.plot(mean, fraction_percent, color=colour, linewidth=1.2, label=format_with_unit(float(load), "mN"))
    for ax, name in zip(axes, ("patch_area", "pressure"), strict=True):
        ax.set(ylim=(0, 100), xlabel=axis_label(name), xscale="log")
        set_log_tick_labels(ax)
    axes[0].set_ylabel("fraction of smaller contacts (%)")
    axes[1].set_ylabel("true contact area\nat lower pressure (%)")
    if hardness is not None:
        axes[1].axvline(hardness, color="0.3", linewidth=0.6, linestyle="--")
        axes[1].text(hardness, 90, "hardness ", fontsize=6, color="0.3", ha="right", va="center")
    axes[0].set_title(title, loc="left", fontsize=6, pad=3)
    handles = axes[0].get_legend_handles_labels()
    figure.legend(*handles, title="thick: mean; thin: single results", loc="outside lower center", ncols=3)
    return figure
