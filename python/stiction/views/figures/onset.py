"""Figures of the onset of sliding: tangential load over displacement, load cycles, and slipping fractions."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._drawing import add_scale_bar
from stiction._number_format import format_with_unit
from stiction.companions.contact_picture import MIN_ZOOM_SIDE_POINTS, ZOOM_FACTOR
from stiction.evaluate.point import MEAN_AND_LIMITS
from stiction.study.study import Study
from stiction.summary.assessment import MAX_AFFECTED_FRACTION
from stiction.views.figures.column_layout import ColumnLayout
from stiction.views.figures.contact import draw_height_map, draw_zoom_border, label_map_axes, picture_extent
from stiction.views.figures.ensemble import (
    HEADING_HEIGHT,
    create_figure_with_axes_rows,
    draw_heading,
    draw_panel_letter,
    find_fraction_beyond_hertz,
    format_fractal_dimension_axis,
    heading_lines,
)
from stiction.views.onset import CYCLE_AMPLITUDES
from stiction.views.style import (
    AREA_COLOUR,
    FORCE_COLOUR,
    FRICTION_COLOUR,
    SLIP_COLOUR_MAP,
    friction_parameters_text,
    interval_bands_text,
    new_figure,
)

LOAD_CYCLE_COLOURS = ("0.55", FRICTION_COLOUR)


def onset_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: tangential load over displacement, load cycles, and slipping fractions.

    `onset` comes from `compute_onset`. A half-plane has no displacement, so only the slipping fractions are drawn.
    """
    mean_onset = onset.sel(statistic="mean")
    displacement, load = (_prepend_zero(mean_onset[name].values) for name in ("displacement", "tangential_load"))
    has_displacement = bool(np.isfinite(displacement).all())
    figure = new_figure(114 if has_displacement else 66, layout=ColumnLayout())
    panels = figure.subplots(
        2 if has_displacement else 1, 1, squeeze=False, height_ratios=[1.25, 1] if has_displacement else [1]
    )[:, 0]
    if has_displacement:
        axes = panels[0]
        lower_limits, upper_limits = (
            _prepend_zero(onset["displacement"].sel(statistic=item).values) for item in ("lower", "upper")
        )
        if np.isfinite(lower_limits).all():
            axes.fill_betweenx(
                load, 1e3 * lower_limits, 1e3 * upper_limits, color=FORCE_COLOUR, alpha=0.15, linewidth=0
            )
        for amplitude, colour in zip(CYCLE_AMPLITUDES, LOAD_CYCLE_COLOURS, strict=True):
            load_cycle = _build_masing_cycle(
                displacement, load, float(mean_onset["tangential_load"].sel(fraction=amplitude))
            )
            energy_loss = 1e3 * float(mean_onset["energy_lost"].sel(fraction=amplitude))
            text = f"cycle of {amplitude:g}: {format_with_unit(energy_loss, 'pJ')}"
            axes.plot(1e3 * load_cycle[0], load_cycle[1], color=colour, linewidth=0.8, label=text)
        loading_curve = _interpolate_loading_curve(displacement, load, float(load[-1]))
        axes.plot(1e3 * loading_curve[0], loading_curve[1], color=FORCE_COLOUR, linewidth=1.2, label="first loading")
        axes.axhline(0, color="0.7", linewidth=0.4)
        axes.axvline(0, color="0.7", linewidth=0.4)
        axes.set(xlabel="displacement of the upper body (nm)", ylabel="tangential load $F_T$ (mN)")
        axes.legend(loc="lower right", title="of the sliding load")
    axes = panels[-1]
    fraction = np.concatenate([[0.0], onset["fraction"].values])
    for name, text, line_style, colour in (
        ("slipped_area", "of the true contact area", "-", AREA_COLOUR),
        ("slipped_load", "of the normal load", "--", FORCE_COLOUR),
    ):
        mean, lower_limits, upper_limits = (
            100 * _prepend_zero(onset[name].sel(statistic=statistic).values) for statistic in MEAN_AND_LIMITS
        )
        if np.isfinite(lower_limits).all():
            axes.fill_between(fraction, lower_limits, upper_limits, color=colour, alpha=0.15, linewidth=0)
        axes.plot(fraction, mean, line_style, color=colour, linewidth=1, label=text)
    axes.set(xlim=(0, 1), ylim=(0, 100), xlabel="ratio of tangential to sliding load", ylabel="slipping fraction (%)")
    axes.legend(loc="upper left")
    figure.suptitle(f"{_heading_text(onset, title)}; {interval_bands_text(onset)}", fontsize=6)
    return figure


def _heading_text(onset: xarray.Dataset, title: str) -> str:
    attributes = onset.attrs
    parameters = friction_parameters_text(float(attributes["mu0"]), float(attributes["tau0_GPa"]))
    return f"{title}\n{parameters}, $F_N$ = {format_with_unit(float(attributes['load_mN']), 'mN')}".strip()


def _prepend_zero(values: Floats) -> Floats:
    return np.concatenate([[0.0], np.asarray(values, dtype=np.float64)])


NUM_CURVE_POINTS = 200


def _interpolate_loading_curve(displacement: Floats, load: Floats, max_load: float) -> tuple[Floats, Floats]:
    """Return displacements and loads (mN) at many points of the first loading curve, up to the load `max_load`.

    The interpolation is cubic and monotone.
    """
    from scipy.interpolate import PchipInterpolator

    fine_loads = np.linspace(0.0, max_load, NUM_CURVE_POINTS)
    return np.asarray(PchipInterpolator(load, displacement)(fine_loads)), fine_loads


def _build_masing_cycle(displacement: Floats, load: Floats, amplitude: float) -> tuple[Floats, Floats]:
    """Return displacements and loads of a load cycle that follows from the first loading curve by Masing's rule.

    Each branch of the cycle is the first loading curve, magnified by a factor of two.
    """
    loading = _interpolate_loading_curve(displacement, load, amplitude)
    unloading = loading[0][-1] - 2 * loading[0], loading[1][-1] - 2 * loading[1]
    return np.concatenate([unloading[0], -unloading[0]]), np.concatenate([unloading[1], -unloading[1]])


# ---- Slip map --------------------------------------------------------------------------------------------------------


_MAX_MARKER_AREA = 60.0  # square points


def contains_slip_map(onset: xarray.Dataset) -> bool:
    """Return whether an onset dataset contains a slip map, which `slip_figure` draws.

    Only areal contacts have such a map.
    """
    return bool("slip" in onset or "contact_slip" in onset)


def slip_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw a figure 80 mm wide: map of the tangential load at which each contact point starts to slip.

    `onset` comes from `compute_onset`, for areal contact. In the asperity model, each contact is one marker, and the
    colour of the marker shows the load at which the contact slides.
    """
    has_point_map = "slip" in onset
    figure = new_figure(144 if has_point_map else 86)
    panels = figure.subplots(2 if has_point_map else 1, 1, squeeze=False)[:, 0]
    colours = mpl.colormaps[SLIP_COLOUR_MAP]
    colour_norm = BoundaryNorm([0.0, *onset["fraction"].values], colours.N)
    full_extent = picture_extent(onset, "slip")
    draw_height_map(figure, panels[0], onset["lower_height"].values, full_extent)
    add_scale_bar(panels[0], full_extent, fontsize=6)
    if has_point_map:
        _draw_slip_map(panels[0], onset["slip"].values, full_extent, colour_norm)
        fraction, box = _densest_contact_window(onset)
        draw_zoom_border(panels[0], box)
        panels[1].imshow(onset["lower_height"].values[fraction], extent=box, origin="lower", cmap="gray", alpha=0.6)
        _draw_slip_map(panels[1], onset["slip"].values[fraction], box, colour_norm)
        panels[1].set_title("region with the most contact (frame above)", loc="left", fontsize=6, pad=3)
        label_map_axes(panels[1], box)
    else:
        area = onset["contact_area"].values
        panels[0].scatter(
            onset["contact_x"], onset["contact_y"],
            s=np.maximum(_MAX_MARKER_AREA * area / area.max(initial=1e-300), 4.0),
            c=onset["contact_slip"], cmap=SLIP_COLOUR_MAP, norm=colour_norm, edgecolors="white", linewidths=0.4,
        )  # fmt: skip
    colour_bar = figure.colorbar(
        ScalarMappable(colour_norm, colours),
        ax=panels[-1],
        location="bottom",
        shrink=0.8,
        ticks=[0, 0.2, 0.4, 0.6, 0.8, 1],
    )
    colour_bar.set_label(
        f"ratio of tangential to sliding load at which a {'point slips' if has_point_map else 'contact slides'}"
    )
    panels[0].set_title(_heading_text(onset, title), loc="left", fontsize=6, pad=3)
    return figure


def _draw_slip_map(axes: Axes, slip: Floats, box: tuple[float, ...], colour_norm: BoundaryNorm) -> None:
    image_options: dict[str, Any] = {
        "origin": "lower",
        "interpolation": "nearest",
        "cmap": SLIP_COLOUR_MAP,
        "norm": colour_norm,
    }
    axes.imshow(slip, extent=(box[0], box[1], box[2], box[3]), **image_options)


def _densest_contact_window(onset: xarray.Dataset) -> tuple[tuple[slice, slice], tuple[float, float, float, float]]:
    """Return the part of a slip map with the most contact points: its row and column slices, and its edges (µm)."""
    is_contact = np.isfinite(onset["slip"].values)
    window_shape = [min(max(length // ZOOM_FACTOR, MIN_ZOOM_SIDE_POINTS), length) for length in is_contact.shape]
    contact_density = is_contact.astype(np.int64)
    for axis, width in enumerate(window_shape):
        contact_density = _sum_with_triangular_weights(contact_density, width // 2, axis)
    densest_index = np.unravel_index(int(contact_density.argmax()), contact_density.shape)
    rows, columns = (
        slice(start := int(np.clip(centre - width // 2, 0, length - width)), start + width)
        for centre, width, length in zip(densest_index, window_shape, is_contact.shape, strict=True)
    )
    return (rows, columns), picture_extent(onset.isel(slip_y=rows, slip_x=columns), "slip")


def _sum_with_triangular_weights(counts: NDArray[np.int64], width: int, axis: int) -> NDArray[np.int64]:
    """Return moving sums of point counts along an axis, with triangular weights.

    The weights fall from `width` to 1, so that a group of counts has its largest sum at its centre. Beyond the edges,
    the counts are 0.
    """
    lines = np.moveaxis(counts, axis, 0)
    sums = np.pad(lines, [(width, width - 1)] + [(0, 0)] * (lines.ndim - 1))
    # Two successive moving sums over `width` elements equal one sum with triangular weights.
    for num_zeros in (0, 1):
        cumulative = np.cumsum(np.pad(sums, [(num_zeros, 0)] + [(0, 0)] * (lines.ndim - 1)), axis=0)
        sums = cumulative[width:] - cumulative[:-width]
    return np.moveaxis(sums, 0, axis)


# ---- Onset of sliding against fractal dimension ---------------------------------------------------------------------


_ONSET_PANELS = {
    "displacement_at_sliding": (1000.0, "pre-sliding displacement (nm)", True),
    "fraction_slipped": (100.0, "slip at half the sliding load (%)", False),
    "tangential_stiffness": (1.0, "tangential stiffness (mN/µm)", True),
}
"""Unit factor, axis label, and whether the axis is logarithmic, for each panel."""

LOAD_COLOURS = ("#56b4e9", "#0072b2", "#003a5d")


def onset_by_dimension_figure(points: xarray.Dataset, study: Study) -> Figure:
    """Draw pre-sliding displacement, slip and stiffness against fractal dimension, in one row of panels per amplitude.

    `points` comes from `evaluate_onset_over_dimension`. Bands are 95 % intervals. Curves are dotted where the model is
    not valid.
    """
    amplitudes, lines = points["amplitude"].values, heading_lines(points, study)
    figure, height, add_axes_at = create_figure_with_axes_rows(
        amplitudes.size, 42.0, 6.0 + HEADING_HEIGHT * len(lines), 15.0, between=5.0
    )
    for row, amplitude in enumerate(amplitudes):
        for number, name in enumerate(_ONSET_PANELS):
            axes = add_axes_at(13 + 57 * number, row, 40)
            _draw_onset_curves(axes, points.isel(amplitude=row), name)
            format_fractal_dimension_axis(axes, points, last=row == amplitudes.size - 1)
            if row == 0:
                draw_panel_letter(axes, number)
            if amplitudes.size > 1 and number == 0:
                axes.set_title(f"$a$ = {1000 * amplitude:g} nm", loc="right", pad=2)
    draw_heading(figure, lines)
    handles, labels = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="lower left", ncols=len(handles), borderaxespad=0.3)
    figure.text(
        0.99,
        1.5 / height,
        f"at {friction_parameters_text(float(points['mu0']), float(points['tau0']))}; bands: 95 %; "
        "dotted: model not valid",
        ha="right",
        va="bottom",
        fontsize=6,
    )
    return figure


def _draw_onset_curves(axes: Axes, dataset: xarray.Dataset, name: str) -> None:
    factor, y_label, is_logarithmic = _ONSET_PANELS[name]
    dimension = dataset["fractal_dimension"].values
    for load, colour in zip(dataset["load"].values, LOAD_COLOURS, strict=False):
        dataset_at_load = dataset.sel(load=load)
        mean, lower, upper = (
            factor * dataset_at_load[name].sel(statistic=statistic).values for statistic in MEAN_AND_LIMITS
        )
        is_valid = ~(find_fraction_beyond_hertz(dataset_at_load, name) > MAX_AFFECTED_FRACTION)
        axes.fill_between(dimension, lower, upper, color=colour, alpha=0.2, linewidth=0)
        marker = "o" if dimension.size == 1 else None
        style: dict[str, Any] = {"color": colour, "linewidth": 1, "marker": marker, "markersize": 2}
        axes.plot(dimension, mean, ":", **style)
        axes.plot(dimension, np.where(is_valid, mean, np.nan), label=f"$F_N$ = {format_with_unit(load, 'mN')}", **style)
    mean_values = dataset[name].sel(statistic="mean").values
    mean_values = factor * mean_values[np.isfinite(mean_values) & (mean_values > 0)]
    if is_logarithmic and mean_values.size:
        axes.set(yscale="log", ylim=(mean_values.min() / 2, mean_values.max() * 2))
    elif not is_logarithmic:
        axes.set_ylim(0, 50)
    axes.set_ylabel(y_label)
