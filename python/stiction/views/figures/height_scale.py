"""Figure of a pair's friction and true contact area for several factors by which its heights are multiplied."""

from __future__ import annotations

import numpy as np
import xarray
from matplotlib.figure import Figure

from stiction._drawing import set_log_tick_labels
from stiction._number_format import format_with_unit
from stiction.evaluate.point import is_unloaded, select_sliding_rule
from stiction.views.figures.loads import draw_curve_with_band, format_log_axis
from stiction.views.style import (
    AREA_COLOUR,
    SLIDING_RULE_COLOURS,
    SLIDING_RULE_LABELS,
    axis_label,
    friction_parameters_text,
    interval_bands_text,
    new_figure,
)


def height_scale_figure(points: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw friction and true contact area of a pair with scaled heights, as functions of the gap's rms gradient.

    Parameters
    ----------
    points : xarray.Dataset
        Result of `evaluate_at_height_factors` at one load, mu0 and tau0.
    title : str
    """
    height_factors = np.asarray(points["height_scale"].values, dtype=np.float64)
    rms_gradient = points["rms_gradient"].sel(statistic="mean").values
    measured_gradient = np.interp(1.0, height_factors, rms_gradient)
    has_load = xarray.DataArray(
        [not is_unloaded(points.isel(height_scale=index)) for index in range(height_factors.size)], dims="height_scale"
    )
    figure = new_figure(114)
    friction_axes, area_axes = figure.subplots(2, 1, sharex=True, height_ratios=[1.25, 1])
    for rule in np.atleast_1d(points["sliding"].values).tolist():
        combined_friction = select_sliding_rule(points["friction_combined"], rule).where(has_load)
        colour, label = SLIDING_RULE_COLOURS[rule], SLIDING_RULE_LABELS[rule]
        draw_curve_with_band(friction_axes, rms_gradient, combined_friction, colour, label=label)
    has_fraction = "contact_area_fraction" in points
    area = 100 * points["contact_area_fraction"] if has_fraction else points["contact_area"]
    mean_area = draw_curve_with_band(area_axes, rms_gradient, area, AREA_COLOUR)
    area_axes.set_xscale("log")
    if (mean_area > 0).any():
        area_axes.set_yscale("log")
    for axes in (friction_axes, area_axes):
        axes.axvline(measured_gradient, color="0.5", linewidth=0.5, linestyle="--")
        set_log_tick_labels(axes)
    friction_axes.set(ylim=(0, None), ylabel=axis_label("friction_coefficient"))
    area_axes.set(
        xlabel=axis_label("rms_gradient"),
        ylabel=axis_label("contact_area_fraction" if has_fraction else "contact_area"),
    )
    format_log_axis(area_axes.xaxis)
    bottom, top = area_axes.get_ylim()
    if area_axes.get_yscale() == "log" and top < 30 * bottom:
        format_log_axis(area_axes.yaxis)
    # The rms gradient is proportional to the height factor only if both bodies are scaled.
    if points.attrs["scaled"] == "both":
        factor_axis = friction_axes.secondary_xaxis(
            "top", functions=(lambda x: x / measured_gradient, lambda x: x * measured_gradient)
        )
        factor_axis.set_xlabel(axis_label("height_scale"))
        format_log_axis(factor_axis.xaxis, friction_axes.get_xlim())
    parameters = friction_parameters_text(
        float(points["mu0"]), float(points["tau0"]), float(points["effective_modulus"])
    )
    figure.suptitle(
        f"{title}\n{parameters}, $F_N$ = {format_with_unit(float(points['load']), 'mN')}".strip(), fontsize=6
    )
    handles = friction_axes.get_legend_handles_labels()
    legend_title = f"{interval_bands_text(points, combined=True)}; dashed: as measured"
    figure.legend(*handles, title=legend_title, loc="outside lower center", ncols=2)
    return figure
