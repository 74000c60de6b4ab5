"""Figures of generated surfaces: friction charts, true contact area, and the surfaces themselves."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import xarray
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm, to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, PathPatch, Rectangle
from matplotlib.path import Path
from matplotlib.ticker import MaxNLocator
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._drawing import HEIGHT_COLOUR_MAP, map_extent, set_log_tick_labels
from stiction._number_format import format_with_unit
from stiction.evaluate.point import MEAN_AND_LIMITS
from stiction.mechanics.friction import STATUS_OK, STATUS_SELF_LOCKED
from stiction.study.study import Study
from stiction.summary.assessment import MAX_AFFECTED_FRACTION
from stiction.summary.figure_values import FrictionOverDimension
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface
from stiction.views.style import (
    COLOUR_BAR_TICKS,
    COLOUR_RANGE_QUANTILES,
    FRICTION_COLOUR_MAP,
    INCHES_PER_MILLIMETRE,
    PAGE_WIDTH,
    SELF_LOCKED_COLOUR,
    SHEAR_STRENGTH_COLOURS,
    axis_label,
    direction_text,
    fractal_dimension_colours,
    friction_parameters_text,
    new_figure,
    spread_label_positions,
)

MIN_FADED_INTERVAL_WIDTH, FULLY_FADED_INTERVAL_WIDTH, MAX_FADING = 0.3, 1.2, 0.85
"""Relative interval widths at which the fading of a chart cell begins and ends, and the strongest fading."""

CURVE_LABEL_SPACING = 2.4  # mm
# Interval bands extend a vertical axis at most to this multiple of the largest mean value.
MAX_DRAWN_BAND_RATIO = 2.0
HEADING_HEIGHT = 4.0  # mm
MAX_LEGEND_COLUMNS = 4

MIN_COLOUR_BAR_TICKS = 3

_LUMINANCE_WEIGHTS = np.array([0.2126, 0.7152, 0.0722])  # red, green, blue


def heading_lines(points: xarray.Dataset, study: Study) -> list[str]:
    """Return the heading lines of a figure: contact model, sliding rule, direction, and unfinished repetitions.

    Model, rule and direction are left out for the model of the paper.
    """
    contact = study.contact
    rule = points["sliding"].item() if "sliding" in points.coords else contact.sliding_rules()[0]
    angle = points["direction"].item() if "direction" in points.coords else float(contact.direction_angles()[0])
    lines = []
    if study.is_areal or study.uses_half_space or rule != "opposing":
        mechanics_text = "half-space, " if study.uses_half_space else ""
        lines.append(f"{mechanics_text}sliding: {rule}, along {direction_text(angle)}")
    num_finished, num_repetitions = int(points["members"]), study.ensemble.repetitions
    if num_finished < num_repetitions:
        lines.append(f"unfinished: {num_finished} of {num_repetitions} repetitions")
    return lines


def draw_heading(figure: Figure, lines: list[str]) -> None:
    """Draw heading lines above all panels of a figure."""
    if lines:
        figure.suptitle("\n".join(lines), fontsize=8, y=1 - INCHES_PER_MILLIMETRE / figure.get_figheight(), va="top")


def draw_panel_letter(axes: Axes, number: int) -> None:
    """Draw the letter of a panel above its upper left corner."""
    axes.text(0, 1.02, chr(ord("a") + number), transform=axes.transAxes, fontsize=8, fontweight="bold", va="bottom")


def create_figure_with_axes_rows(
    rows: int, height: float, margin_above: float, margin_below: float, *, between: float
) -> tuple[Figure, float, Callable[[float, int, float], Axes]]:
    """Return an empty figure (170 mm wide), its height (mm), and a function that adds axes to a given row."""
    total_height = margin_above + margin_below + rows * (height + between) - between
    figure = new_figure(total_height, width=PAGE_WIDTH, layout=None)

    def add_axes_at(left: float, row: int, width: float) -> Axes:
        bottom = margin_below + (rows - 1 - row) * (height + between)
        return figure.add_axes((left / PAGE_WIDTH, bottom / total_height, width / PAGE_WIDTH, height / total_height))

    return figure, total_height, add_axes_at


# ---- Friction coefficient against fractal dimension and load --------------------------------------------------------


def friction_figure(values: FrictionOverDimension) -> Figure:
    """Draw friction coefficients as charts over fractal dimension and load, and as curves over fractal dimension.

    There is one chart for each tau0, and one row of panels for each amplitude. Cells of a chart are hatched if the
    model is not valid, and grey if the 95 % interval is wide.
    """
    study, maps, curves, strengths = values.study, values.map_points, values.curve_points, values.strengths
    mu0, load, amplitudes = float(maps["mu0"]), float(curves["load"]), maps["amplitude"].values
    lines = heading_lines(maps, study)
    handles = _legend_handles(maps, has_asperities=not study.uses_half_space)
    margin_above, margin_below = (
        15.0 + HEADING_HEIGHT * len(lines),
        16.0 + (3.0 if len(handles) > MAX_LEGEND_COLUMNS else 0.0),
    )
    height = 42.0 if amplitudes.size == 1 else 34.0
    figure, total_height, add_axes_at = create_figure_with_axes_rows(
        amplitudes.size, height, margin_above, margin_below, between=4.0
    )
    norm = _logarithmic_colour_norm(maps)
    for row, amplitude in enumerate(amplitudes):
        is_last_row = row == amplitudes.size - 1
        width = (99 - 4 * (len(strengths) - 1)) / len(strengths)
        for column, strength in enumerate(strengths):
            ax = add_axes_at(13 + column * (width + 4), row, width)
            _draw_friction_panel(ax, maps.isel(amplitude=row, tau0=column), norm, load)
            if column == 0:
                ax.set_ylabel(axis_label("load"))
            else:
                ax.yaxis.set_visible(False)
            if row == 0:
                ax.set_title(rf"$\tau_0$ = {strength}", pad=2)
                draw_panel_letter(ax, column)
            format_fractal_dimension_axis(ax, maps, last=is_last_row)
            if amplitudes.size > 1:
                ax.text(
                    0.96, 0.96, f"$a$ = {1000 * amplitude:g} nm", transform=ax.transAxes, fontsize=6, ha="right",
                    va="top", bbox={"facecolor": "white", "linewidth": 0, "pad": 0.8},
                )  # fmt: skip
        ax = add_axes_at(127, row, 40)
        _draw_friction_curves(ax, curves.isel(amplitude=row), strengths, mu0)
        if row == amplitudes.size // 2:
            ax.set_ylabel(axis_label("friction_coefficient"))
        if row == 0:
            ax.set_title(f"at $F_N$ = {format_with_unit(load, 'mN')}", pad=2)
            draw_panel_letter(ax, len(strengths))
            ax.legend(loc="lower right", bbox_to_anchor=(1.02, 1.08), ncols=2, handlelength=1.2, borderaxespad=0)
        format_fractal_dimension_axis(ax, maps, last=is_last_row)
    _draw_colour_bar(
        figure, (13 / 170, 1 - (margin_above - 5.5) / total_height, 99 / 170, 2.2 / total_height), norm, mu0
    )
    draw_heading(figure, lines)
    figure.legend(
        handles=handles, loc="lower center", ncols=len(handles) if len(handles) <= MAX_LEGEND_COLUMNS else 3,
        handlelength=1.6, columnspacing=1.4, borderaxespad=0.3,
    )  # fmt: skip
    return figure


def format_fractal_dimension_axis(axes: Axes, points: xarray.Dataset, *, last: bool) -> None:
    """Format the axis of the fractal dimension.

    Only panels in the last row have an axis label.
    """
    axes.locator_params("x", nbins=4, steps=[1, 2, 5, 10])
    if last:
        is_classical = points["fractal_dimension"].attrs.get("convention") == "classical"
        axes.set_xlabel(axis_label("fractal_dimension") + (" (classical)" if is_classical else ""))
    else:
        axes.tick_params(labelbottom=False)


def find_fraction_beyond_hertz(points: xarray.Dataset, name: str = "friction_coefficient") -> Floats:
    """Return, for each result point, the fraction of the load on contacts that are pressed too deeply for Hertz theory.

    The fraction is NaN in the half-space model, which has no asperities.
    """
    if "share_beyond_hertz" in points:
        return np.asarray(points["share_beyond_hertz"].values)
    return np.full_like(points[name].isel(statistic=0).values, np.nan)


def _draw_friction_curves(axes: Axes, curves: xarray.Dataset, strengths: list[str], mu0: float) -> None:
    """Draw curves of friction against fractal dimension, for the lowest and the highest tau0.

    Curves are dotted where the asperity model is not valid.
    """
    dimension = curves["fractal_dimension"].values
    is_valid = ~(find_fraction_beyond_hertz(curves) > MAX_AFFECTED_FRACTION)
    value, lower, upper = (
        curves["friction_coefficient"].sel(statistic=statistic).values for statistic in MEAN_AND_LIMITS
    )
    for index, colour in zip(range(len(strengths)), SHEAR_STRENGTH_COLOURS, strict=False):
        axes.fill_between(dimension, lower[:, index], upper[:, index], color=colour, alpha=0.25, linewidth=0)
        marker = "o" if dimension.size == 1 else None
        style: dict[str, Any] = {"color": colour, "linewidth": 1, "markersize": 2, "marker": marker}
        axes.plot(dimension, value[:, index], ":", **style)
        valid_curve = np.where(is_valid[:, index], value[:, index], np.nan)
        axes.plot(dimension, valid_curve, label=rf"$\tau_0$ = {strengths[index]}", **style)
    # The vertical axis includes mu0, all valid friction coefficients, and at least half of all friction coefficients.
    valid_ends, valid_values = (array[np.isfinite(array) & is_valid].max(initial=0.0) for array in (upper, value))
    median_value = float(np.median(value[np.isfinite(value)])) if np.isfinite(value).any() else 0.0
    upper_limit = 1.1 * max(mu0, float(min(valid_ends, MAX_DRAWN_BAND_RATIO * valid_values)), median_value) or 1.0
    axes.set_ylim(0, upper_limit)
    axes.locator_params("y", nbins=6, steps=[1, 2, 5, 10])
    dimension_range = float(np.ptp(dimension)) or 1.0
    axes.set_xlim(dimension[0] - 0.02 * dimension_range, dimension[-1] + 0.02 * dimension_range)
    axes.axhline(mu0, color="0.6", linewidth=0.5, linestyle="--", zorder=0)
    axes.text(
        axes.get_xlim()[1] - 0.01 * dimension_range, mu0, r"$\mu_0$", color="0.4", fontsize=6, va="bottom", ha="right"
    )


def _draw_colour_bar(figure: Figure, position: tuple[float, float, float, float], norm: Any, mu0: float) -> None:
    axes = figure.add_axes(position, label="<colorbar>")
    colour_bar = figure.colorbar(
        ScalarMappable(norm, FRICTION_COLOUR_MAP), cax=axes, orientation="horizontal", extend="both"
    )
    ticks = [tick for tick in COLOUR_BAR_TICKS if norm.vmin <= tick * (1 + 1e-9) and tick <= norm.vmax * (1 + 1e-9)]
    if len(ticks) < MIN_COLOUR_BAR_TICKS:
        round_values = MaxNLocator(5, steps=[1, 2, 5]).tick_values(norm.vmin, norm.vmax)
        ticks = [float(tick) for tick in round_values if norm.vmin <= tick <= norm.vmax]
    ticks = ticks[:: max(1, -(-len(ticks) // 8))]
    colour_bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    colour_bar.ax.minorticks_off()
    axes.xaxis.tick_top()
    axes.xaxis.set_label_position("top")
    axes.tick_params(length=2, pad=1)
    colour_bar.set_label(rf"{axis_label('friction_coefficient')}, at $\mu_0$ = {mu0:g}", labelpad=2)


def _logarithmic_colour_norm(maps: xarray.Dataset) -> Any:
    """Return a logarithmic colour scale that covers the friction coefficients for which the asperity model is valid.

    If the model is valid at few coefficients, the scale covers all positive coefficients.
    """
    coefficients = maps["friction_coefficient"].sel(statistic="mean").values
    is_positive = np.isfinite(coefficients) & (coefficients > 0)
    is_valid = is_positive & ~(find_fraction_beyond_hertz(maps) > MAX_AFFECTED_FRACTION)
    positive_values = coefficients[is_valid if is_valid.sum() > 0.1 * is_positive.sum() else is_positive]
    lower_limit, upper_limit = (
        np.quantile(positive_values, COLOUR_RANGE_QUANTILES) if positive_values.size else (0.1, 1.0)
    )
    step = 10.0 ** np.floor(np.log10(lower_limit)) / 2
    lower_limit, upper_limit = max(np.floor(lower_limit / step) * step, step), np.ceil(upper_limit / step) * step
    return LogNorm(lower_limit, max(upper_limit, lower_limit + step))


def _draw_friction_panel(axes: Axes, panel: xarray.Dataset, norm: Any, load: float) -> None:
    panel = panel.transpose("load", "fractal_dimension", "statistic")
    friction, status = panel["friction_coefficient"].values, panel["status"].values
    coefficients = friction[..., 0]
    edges = (
        _compute_cell_edges(panel["fractal_dimension"].values),
        np.exp(_compute_cell_edges(np.log(panel["load"].values))),
    )
    axes.set(yscale="log", xlim=(edges[0][0], edges[0][-1]), ylim=(edges[1][0], edges[1][-1]))
    set_log_tick_labels(axes)
    axes.add_patch(_patch_of_unreached_cells((0, 0), 1, 1, transform=axes.transAxes))
    is_finite = np.isfinite(coefficients)
    # The coefficient 0, which has no logarithm, gets the lowest colour of the scale.
    colours = colormaps[FRICTION_COLOUR_MAP](norm(np.where(is_finite, np.maximum(coefficients, norm.vmin), norm.vmin)))
    colours[..., :3] = _fade_colours(colours[..., :3], _compute_cell_fading(friction))
    colours[..., 3] = is_finite
    colours[status == STATUS_SELF_LOCKED] = (*to_rgb(SELF_LOCKED_COLOUR), 1)
    axes.pcolormesh(*edges, colours)
    fraction = find_fraction_beyond_hertz(panel)
    _hatch_cells(axes, *edges, is_finite & (fraction > MAX_AFFECTED_FRACTION))
    if min(coefficients.shape) > 1:
        masked_fractions = np.ma.masked_invalid(fraction)
        if masked_fractions.count() and masked_fractions.min() < MAX_AFFECTED_FRACTION < masked_fractions.max():
            axes.contour(
                panel["fractal_dimension"].values,
                panel["load"].values,
                masked_fractions,
                levels=[MAX_AFFECTED_FRACTION],
                colors="0.1",
                linewidths=0.7,
            )
    axes.axhline(load, color="black", linewidth=0.5)


def _hatch_cells(axes: Axes, x: Floats, y: Floats, is_hatched: NDArray[np.bool_]) -> None:
    """Hatch the chart cells that a mask selects.

    The colours of the cells remain visible.
    """
    vertices: list[tuple[float, float]] = []
    for row, column in np.argwhere(is_hatched):
        left, right, bottom, top = x[column], x[column + 1], y[row], y[row + 1]
        vertices += [(left, bottom), (right, bottom), (right, top), (left, top), (left, bottom)]
    if vertices:
        codes = np.tile([Path.MOVETO, Path.LINETO, Path.LINETO, Path.LINETO, Path.CLOSEPOLY], len(vertices) // 5)
        # A thin white line on a black line is visible on any colour.
        for colour, width in (("black", 0.7), ("white", 0.3)):
            patch = PathPatch(Path(vertices, codes), **_INVALID_CELL_STYLE | {"edgecolor": colour})
            patch.set_hatch_linewidth(width)
            # `add_patch` would compute the axis limits from all cells, which is slow.
            axes.add_artist(patch)


_INVALID_CELL_STYLE: dict[str, Any] = {"facecolor": "none", "edgecolor": "white", "hatch": "\\\\", "linewidth": 0}
"""Style of cells in which the model is not valid: hatching with thin lines, between which the colour is visible."""


def _compute_cell_fading(friction_with_limits: Floats) -> Floats:
    """Return how grey each chart cell is drawn: from 0 (narrow interval) to `MAX_FADING` (wide interval).

    The width is divided by the coefficient.
    """
    coefficients, lower, upper = np.moveaxis(friction_with_limits, -1, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        width = (upper - lower) / coefficients
    width = np.nan_to_num(width, nan=FULLY_FADED_INTERVAL_WIDTH, posinf=FULLY_FADED_INTERVAL_WIDTH)
    width = np.where(np.isfinite(coefficients), width, MIN_FADED_INTERVAL_WIDTH)
    return np.asarray(
        MAX_FADING
        * np.clip((width - MIN_FADED_INTERVAL_WIDTH) / (FULLY_FADED_INTERVAL_WIDTH - MIN_FADED_INTERVAL_WIDTH), 0, 1)
    )


def _fade_colours(colours: Floats, fading: Floats) -> Floats:
    """Fade colours to grey without changing their luminance.

    A faded colour then equals no other colour of the scale.
    """
    grey = (colours @ _LUMINANCE_WEIGHTS)[..., np.newaxis]
    fraction = np.asarray(fading)[..., np.newaxis]
    return np.asarray((1 - fraction) * colours + fraction * grey)


def _patch_of_unreached_cells(*args: Any, **kwargs: Any) -> Any:
    return Rectangle(*args, facecolor="white", edgecolor="0.6", hatch="////", linewidth=0.5, **kwargs)


def _legend_handles(maps: xarray.Dataset, *, has_asperities: bool) -> list[Any]:
    example_colour = np.array(colormaps[FRICTION_COLOUR_MAP](0.4)[:3])
    handles: list[Any] = []
    if has_asperities and (find_fraction_beyond_hertz(maps) > MAX_AFFECTED_FRACTION).any():
        invalid_label = "model not valid (dotted): most load on overlaps $> R/10$"
        # The hatching in the legend is denser than in the chart, because a legend patch is small.
        legend_style = {"facecolor": tuple(example_colour), "hatch": 2 * _INVALID_CELL_STYLE["hatch"]}
        handles.append(Patch(**_INVALID_CELL_STYLE | legend_style, label=invalid_label))
    fading = _compute_cell_fading(maps["friction_coefficient"].transpose(..., "statistic").values)
    if (fading[~(find_fraction_beyond_hertz(maps) > MAX_AFFECTED_FRACTION)] > 0.1).any():
        handles.append(
            Patch(
                facecolor=tuple(_fade_colours(example_colour, np.array(MAX_FADING))), label="grey: wide 95 % interval"
            )
        )
    if (~np.isin(maps["status"].values, (STATUS_OK, STATUS_SELF_LOCKED))).any():
        handles.append(_patch_of_unreached_cells((0, 0), 1, 1, label="load not reached"))
    if (maps["status"].values == STATUS_SELF_LOCKED).any():
        handles.append(Patch(facecolor=to_rgb(SELF_LOCKED_COLOUR), label=r"self-locked: $F_N \leq 0$"))
    handles.append(Line2D([], [], color="black", linewidth=0.7, label="load of the curves; bands: 95 %"))
    return handles


def _compute_cell_edges(centres: Floats) -> Floats:
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    midpoints = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - midpoints[0]], midpoints, [2 * centres[-1] - midpoints[-1]]])


# ---- Area against load ----------------------------------------------------------------------------------------------


def area_figure(points: xarray.Dataset, study: Study) -> Figure:
    """Draw true area and area per load against load, with 95 % intervals; each amplitude has a row of panels.

    `points` comes from `evaluate_area_over_load`.
    """
    amplitudes, lines = points["amplitude"].values, heading_lines(points, study)
    height = 50.0 if amplitudes.size == 1 else 38.0
    figure, figure_height, add_axes_at = create_figure_with_axes_rows(
        amplitudes.size, height, 4.0 + HEADING_HEIGHT * len(lines), 15.0, between=4.0
    )
    for row, amplitude in enumerate(amplitudes):
        row_axes = [add_axes_at(left, row, 70) for left in (13, 98)]
        _draw_area_curves(row_axes, points.isel(amplitude=row), label_distance=CURVE_LABEL_SPACING / height)
        for number, ax in enumerate(row_axes):
            if row == 0:
                draw_panel_letter(ax, number)
            if row < amplitudes.size - 1:
                ax.tick_params(labelbottom=False)
            else:
                ax.set_xlabel(axis_label("load"))
        row_axes[0].set_ylabel(axis_label("contact_area"))
        row_axes[1].set_ylabel(axis_label("area_over_load"))
        if amplitudes.size > 1:
            row_axes[0].text(0.03, 0.95, f"$a$ = {1000 * amplitude:g} nm", transform=row_axes[0].transAxes, va="top")
    draw_heading(figure, lines)
    validity_note = "" if study.uses_half_space else "; dotted: model not valid, most load on overlaps $> R/10$"
    figure.text(
        0.5,
        1.5 / figure_height,
        f"at {friction_parameters_text(float(points['mu0']), float(points['tau0']))}; bands: 95 %{validity_note}",
        ha="center",
        va="bottom",
        fontsize=6,
    )
    return figure


def _draw_area_curves(axes: list[Axes], areas: xarray.Dataset, *, label_distance: float) -> None:
    """Draw true area and area per load against load: one curve per fractal dimension, labelled at its left end."""
    load, dimensions = areas["load"].values, areas["fractal_dimension"].values
    areas = areas.transpose("fractal_dimension", "load", ...)
    area, lower, upper = (areas["contact_area"].sel(statistic=statistic).values for statistic in MEAN_AND_LIMITS)
    is_valid = ~(find_fraction_beyond_hertz(areas, "contact_area") > MAX_AFFECTED_FRACTION)
    areas_above_zero = area[area > 0]
    for ax, area_factor in zip(axes, (np.ones(load.size), 1 / load), strict=True):
        ax.set(xscale="log", xlim=(load[0] / (load[-1] / load[0]) ** 0.24, load[-1] * 1.2))
        if not areas_above_zero.size:
            ax.text(0.5, 0.5, "no load reached", transform=ax.transAxes, ha="center")
            continue
        ax.set_yscale("log")
        positive_areas = (area_factor * area)[area > 0]
        ax.set_ylim(positive_areas.min() / MAX_DRAWN_BAND_RATIO, positive_areas.max() * MAX_DRAWN_BAND_RATIO)
        set_log_tick_labels(ax)
        labels, label_heights = [], []
        for curve_index, colour in enumerate(fractal_dimension_colours(dimensions)):
            ax.fill_between(
                load,
                area_factor * lower[curve_index],
                area_factor * upper[curve_index],
                color=colour,
                alpha=0.25,
                linewidth=0,
            )
            ax.plot(load, area_factor * area[curve_index], ":", color=colour, linewidth=0.8)
            ax.plot(
                load,
                np.where(is_valid[curve_index], area_factor * area[curve_index], np.nan),
                color=colour,
                linewidth=0.8,
            )
            indices = np.flatnonzero(area[curve_index] > 0)
            if indices.size:
                labels.append((load[indices[0]], dimensions[curve_index], colour))
                label_heights.append(np.log(area_factor[indices[0]] * area[curve_index, indices[0]]))
        log_bottom, log_top = np.log(ax.get_ylim())
        spread_heights = spread_label_positions(label_heights, label_distance * (log_top - log_bottom))
        spread_heights += max(
            0, log_bottom + label_distance * (log_top - log_bottom) - spread_heights.min(initial=log_top)
        )
        for (curve_start, dimension, colour), label_height in zip(labels, spread_heights, strict=True):
            text = f"{dimension:.2f}" if dimension != dimensions[0] else f"$D$ = {dimension:.2f}"
            ax.text(curve_start / 1.12, np.exp(label_height), text, color=colour, fontsize=6, ha="right", va="center")


# ---- Surfaces -------------------------------------------------------------------------------------------------------


def profiles_figure(profiles: Mapping[float, Profile], study: Study) -> Figure:
    """Draw profiles of several fractal dimensions: whole profiles on the left, one length scale of each on the right.

    `profiles` comes from `generate_profiles`.
    """
    surfaces: Any = study.surfaces
    shown_length = min(float(surfaces.length_scale), float(surfaces.extent))
    figure = new_figure(12 + 13 * len(profiles))
    axes = figure.subplots(len(profiles), 2, squeeze=False, sharex="col", sharey=True)
    for row, (dimension, profile) in enumerate(profiles.items()):
        for ax, x_limit in zip(axes[row], (profile.extent, shown_length), strict=True):
            is_shown = profile.x <= x_limit
            ax.fill_between(
                profile.x[is_shown], profile.heights[is_shown], profile.heights.min(), color="0.85", linewidth=0
            )
            ax.plot(profile.x[is_shown], profile.heights[is_shown], color="0.2", linewidth=0.4)
            ax.set_xlim(0, x_limit)
        axes[row, 0].set_title(f"$D$ = {dimension:.3g}", loc="left", pad=2)
    for ax in axes[-1]:
        ax.set_xlabel(axis_label("x"))
    axes[len(profiles) // 2, 0].set_ylabel(axis_label("height"))
    return figure


def length_scales_figure(bodies: Mapping[float, tuple[Profile, Surface]]) -> Figure:
    """Draw a generated profile and a generated height map for each length scale (µm).

    `bodies` comes from `generate_bodies_by_length_scale`.
    """
    figure = new_figure(66)
    axes = figure.subplots(2, len(bodies), height_ratios=[1, 1.2], sharex=True)
    for column, (length_scale, (profile, surface)) in enumerate(bodies.items()):
        profile_axes, surface_axes = axes[:, column]
        profile_axes.plot(profile.x, profile.heights - profile.heights.mean(), color="0.2", linewidth=0.4)
        heights = surface.heights - surface.heights.mean()
        edges = map_extent(heights.shape, surface.spacing)
        profile_axes.set(title=f"$L$ = {length_scale:.3g} µm", xlim=edges[:2])
        image = surface_axes.imshow(heights, extent=edges, origin="lower", cmap=HEIGHT_COLOUR_MAP)
        colour_bar = figure.colorbar(image, ax=surface_axes, location="bottom", pad=0.02)
        colour_bar.locator = MaxNLocator(3)
        colour_bar.set_label(axis_label("height"))
        surface_axes.set_xlabel(axis_label("x"))
        surface_axes.tick_params(axis="x", labelbottom=True)
        if column > 0:
            surface_axes.tick_params(labelleft=False)
    axes[0, 0].set_ylabel(axis_label("height"))
    axes[1, 0].set_ylabel(axis_label("y"))
    return figure
