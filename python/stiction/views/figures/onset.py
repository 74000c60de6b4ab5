"""Figures of the onset of sliding: tangential load against displacement with cycles, and slip."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from stiction._checks import Floats
from stiction._drawing import add_scale_bar
from stiction._number_format import with_unit
from stiction.studies.assessment import MAX_AFFECTED_FRACTION
from stiction.studies.contact_picture import MIN_ZOOM_SIZE, ZOOM_DIVISOR
from stiction.studies.contact_tables import AsperityContactTable
from stiction.studies.evaluation import at_load, reached_loads
from stiction.studies.point import MEAN_AND_ENDS
from stiction.studies.study import study_of
from stiction.views.figures.contact import draw_frame, draw_heights, map_extent
from stiction.views.figures.ensemble import (
    HEADING_HEIGHT,
    create_axes_rows,
    draw_heading,
    draw_panel_letter,
    format_dimension_axis,
    heading_lines,
)
from stiction.views.onset import AMPLITUDES
from stiction.views.style import AREA, FORCE, FRICTION, SLIP_MAP, friction_parameters_text, label, new_figure

CYCLE_COLOURS = ("0.55", FRICTION)  # colours of the load cycles


def onset_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw tangential load against displacement with cycles, and slipping fractions against load; 80 mm wide.

    `onset` is a result of `onset_of_result`. For a half-plane, which has no defined displacement, only the slipping
    fractions are drawn.
    """
    curve = onset.sel(statistic="mean")
    displacement, load = (_with_origin(curve[name].values) for name in ("displacement", "tangential_load"))
    has_displacement = bool(np.isfinite(displacement).all())
    figure = new_figure(114 if has_displacement else 66)
    panels = figure.subplots(
        2 if has_displacement else 1, 1, squeeze=False, height_ratios=[1.25, 1] if has_displacement else [1]
    )[:, 0]
    if has_displacement:
        axes = panels[0]
        low, high = (_with_origin(onset["displacement"].sel(statistic=item).values) for item in ("lower", "upper"))
        if np.isfinite(low).all():
            axes.fill_betweenx(load, 1e3 * low, 1e3 * high, color=FORCE, alpha=0.15, linewidth=0)
        for amplitude, colour in zip(AMPLITUDES, CYCLE_COLOURS, strict=True):
            cycle = _masing_cycle(displacement, load, float(curve["tangential_load"].sel(fraction=amplitude)))
            lost = 1e3 * float(curve["energy_lost"].sel(fraction=amplitude))
            text = f"cycle of {amplitude:g}: {with_unit(lost, 'pJ')}"
            axes.plot(1e3 * cycle[0], cycle[1], color=colour, linewidth=0.8, label=text)
        first = _interpolate_loading(displacement, load, float(load[-1]))
        axes.plot(1e3 * first[0], first[1], color=FORCE, linewidth=1.2, label="first loading")
        axes.axhline(0, color="0.7", linewidth=0.4)
        axes.axvline(0, color="0.7", linewidth=0.4)
        axes.set(xlabel="displacement of the upper body (nm)", ylabel="tangential load $F_T$ (mN)")
        axes.legend(loc="lower right", title="of the sliding load")
    axes = panels[-1]
    fraction = np.concatenate([[0.0], onset["fraction"].values])
    for name, text, dashes, colour in (
        ("slipped_area", "of the true contact area", "-", AREA),
        ("slipped_load", "of the normal load", "--", FORCE),
    ):
        mean, low, high = (
            100 * _with_origin(onset[name].sel(statistic=statistic).values) for statistic in MEAN_AND_ENDS
        )
        if np.isfinite(low).all():
            axes.fill_between(fraction, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(fraction, mean, dashes, color=colour, linewidth=1, label=text)
    axes.set(xlim=(0, 1), ylim=(0, 100), xlabel="tangential load over sliding load", ylabel="slipping fraction (%)")
    axes.legend(loc="upper left")
    figure.suptitle(f"{_heading(onset, title)}; bands: 95 %, sampling of positions", fontsize=6)
    return figure


def _heading(onset: xarray.Dataset, title: str) -> str:
    a = onset.attrs
    parameters = friction_parameters_text(float(a["mu0"]), float(a["tau0_GPa"]))
    return f"{title}\n{parameters}, $F_N$ = {with_unit(float(a['load_mN']), 'mN')}".strip()


def _with_origin(values: Floats) -> Floats:
    return np.concatenate([[0.0], np.asarray(values, dtype=np.float64)])


NUM_CURVE_POINTS = 200  # points of an interpolated curve


def _interpolate_loading(displacement: Floats, load: Floats, top: float) -> tuple[Floats, Floats]:
    """Return the first loading curve up to a load, interpolated by a monotone cubic."""
    from scipy.interpolate import PchipInterpolator

    fine = np.linspace(0.0, top, NUM_CURVE_POINTS)
    return np.asarray(PchipInterpolator(load, displacement)(fine)), fine


def _masing_cycle(displacement: Floats, load: Floats, top: float) -> tuple[Floats, Floats]:
    """Return a cycle between plus and minus a load by Masing's rule: branches are the loading curve scaled by two."""
    up = _interpolate_loading(displacement, load, top)
    down = up[0][-1] - 2 * up[0], up[1][-1] - 2 * up[1]
    return np.concatenate([down[0], -down[0]]), np.concatenate([down[1], -down[1]])


# ---- What slips first -----------------------------------------------------------------------------------------------


_MAX_MARKER_AREA = 60.0  # area of the largest marker (square points)


def has_slip_map(onset: xarray.Dataset) -> bool:
    """Return whether an onset contains the data of `slip_figure`, which only areal contacts have."""
    return bool("slip" in onset or "contact_slip" in onset)


def slip_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw the tangential load at which each contact point starts to slip, over the heights; 80 mm wide.

    `onset` is a result of `onset_of_result` for areal contact. With the asperity model each contact is one marker,
    coloured by the load at which it slides.
    """
    of_points = "slip" in onset
    figure = new_figure(144 if of_points else 86)
    panels = figure.subplots(2 if of_points else 1, 1, squeeze=False)[:, 0]
    colours = mpl.colormaps[SLIP_MAP]
    levels = BoundaryNorm([0.0, *onset["fraction"].values], colours.N)
    whole = map_extent(onset, "slip")
    draw_heights(figure, panels[0], onset["lower_height"].values, whole)
    add_scale_bar(panels[0], whole, fontsize=6)
    if of_points:
        _draw_slip(panels[0], onset["slip"].values, whole, levels)
        fraction, box = _busiest_window(onset)
        draw_frame(panels[0], box)
        panels[1].imshow(onset["lower_height"].values[fraction], extent=box, origin="lower", cmap="gray", alpha=0.6)
        _draw_slip(panels[1], onset["slip"].values[fraction], box, levels)
        panels[1].set_title("region with the most contact (frame above)", loc="left", fontsize=6, pad=3)
        panels[1].set(xlabel=label("x"), ylabel=label("y"))
    else:
        area = onset["contact_area"].values
        panels[0].scatter(
            onset["contact_x"], onset["contact_y"],
            s=np.maximum(_MAX_MARKER_AREA * area / area.max(initial=1e-300), 4.0),
            c=onset["contact_slip"], cmap=SLIP_MAP, norm=levels, edgecolors="white", linewidths=0.4,
        )  # fmt: skip
    bar = figure.colorbar(
        ScalarMappable(levels, colours), ax=panels[-1], location="bottom", shrink=0.8, ticks=[0, 0.2, 0.4, 0.6, 0.8, 1]
    )
    bar.set_label(f"tangential over sliding load at which a {'point slips' if of_points else 'contact slides'}")
    panels[0].set_title(_heading(onset, title), loc="left", fontsize=6, pad=3)
    return figure


def _draw_slip(axes: Axes, slip: Floats, box: tuple[float, ...], levels: BoundaryNorm) -> None:
    kind: dict[str, Any] = {"origin": "lower", "interpolation": "nearest", "cmap": SLIP_MAP, "norm": levels}
    axes.imshow(slip, extent=(box[0], box[1], box[2], box[3]), **kind)


def _busiest_window(onset: xarray.Dataset) -> tuple[tuple[slice, slice], tuple[float, float, float, float]]:
    """Return the window of the map with the most contact: its rows and columns, and its extent (µm)."""
    from scipy.ndimage import gaussian_filter

    touching = np.isfinite(onset["slip"].values)
    size = [min(max(n // ZOOM_DIVISOR, MIN_ZOOM_SIZE), n) for n in touching.shape]
    density = gaussian_filter(touching.astype(np.float64), [item / 4 for item in size], mode="constant")
    middle = np.unravel_index(int(density.argmax()), density.shape)
    rows, columns = (
        slice(begin := int(np.clip(at - wide // 2, 0, n - wide)), begin + wide)
        for at, wide, n in zip(middle, size, touching.shape, strict=True)
    )
    return (rows, columns), map_extent(onset.isel(slip_y=rows, slip_x=columns), "slip")


# ---- Over fractal dimension -----------------------------------------------------------------------------------------


_PANELS = {
    "displacement_at_sliding": (1000.0, "pre-sliding displacement (nm)", True),
    "fraction_slipped": (100.0, "slip at half the sliding load (%)", False),
    "tangential_stiffness": (1.0, "tangential stiffness (mN/µm)", True),
}
"""Factor, axis label and whether the axis is logarithmic, by panel."""

LOAD_FRACTIONS = (0.25, 0.5, 0.75)
"""Loads of the curves, as fractions of the logarithmic load range."""

LOAD_COLOURS = ("#56b4e9", "#0072b2", "#003a5d")  # colours of the curves, from low to high loads


def dimension_onset_figure(dataset: xarray.Dataset) -> Figure:
    """Draw pre-sliding displacement, slip and stiffness against fractal dimension; a row for each amplitude.

    Bands are 95 % intervals. Curves are dotted where the model is not valid.
    """
    study = study_of(dataset)
    assert isinstance(study.contact, AsperityContactTable)
    settings = study.contact.onset
    assert settings is not None
    ends = np.log(reached_loads(dataset, 2))
    loads = np.unique([float(f"{np.exp(ends[0] + fraction * (ends[1] - ends[0])):.0e}") for fraction in LOAD_FRACTIONS])
    at = at_load(dataset, loads, mu0=settings.mu0, tau0=float(settings.tau0)).isel(mu0=0, tau0=0)
    amplitudes = dataset["amplitude"].values
    lines = heading_lines(dataset, study)
    figure, total, axes_at = create_axes_rows(
        amplitudes.size, 42.0, 6.0 + HEADING_HEIGHT * len(lines), 15.0, between=5.0
    )
    for row, amplitude in enumerate(amplitudes):
        for number, name in enumerate(_PANELS):
            axes = axes_at(13 + 57 * number, row, 40)
            _draw_curves(axes, at.isel(amplitude=row), name)
            format_dimension_axis(axes, dataset, last=row == amplitudes.size - 1)
            if row == 0:
                draw_panel_letter(axes, number)
            if amplitudes.size > 1 and number == 0:
                axes.set_title(f"$a$ = {1000 * amplitude:g} nm", loc="right", pad=2)
    draw_heading(figure, lines)
    handles, text = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, text, loc="lower left", ncols=len(handles), borderaxespad=0.3)
    figure.text(
        0.99, 1.5 / total, f"at {friction_parameters_text(settings.mu0, float(settings.tau0))}; bands: 95 %; dotted: "
        "model not valid", ha="right", va="bottom", fontsize=6,
    )  # fmt: skip
    return figure


def _draw_curves(axes: Axes, at: xarray.Dataset, name: str) -> None:
    factor, text, in_ratios = _PANELS[name]
    dimension = at["fractal_dimension"].values
    for load, colour in zip(at["load"].values, LOAD_COLOURS, strict=False):
        dataset_at_load = at.sel(load=load)
        mean, lower, upper = (
            factor * dataset_at_load[name].sel(statistic=statistic).values for statistic in MEAN_AND_ENDS
        )
        trusted = ~(dataset_at_load["share_beyond_hertz"].values > MAX_AFFECTED_FRACTION)
        axes.fill_between(dimension, lower, upper, color=colour, alpha=0.2, linewidth=0)
        marker = "o" if dimension.size == 1 else None
        style: dict[str, Any] = {"color": colour, "linewidth": 1, "marker": marker, "markersize": 2}
        axes.plot(dimension, mean, ":", **style)
        axes.plot(dimension, np.where(trusted, mean, np.nan), label=f"$F_N$ = {with_unit(load, 'mN')}", **style)
    positive = at[name].sel(statistic="mean").values
    positive = factor * positive[np.isfinite(positive) & (positive > 0)]
    if in_ratios and positive.size:
        axes.set(yscale="log", ylim=(positive.min() / 2, positive.max() * 2))
    elif not in_ratios:
        axes.set_ylim(0, 50)
    axes.set_ylabel(text)
