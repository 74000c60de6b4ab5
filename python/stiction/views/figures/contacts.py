"""Contacts over a map of heights, and the pressure about the one that carries most."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.views.digits import with_unit
from stiction.views.style import (
    LEANING,
    MILLIMETRE,
    OPPOSING,
    PRESSURE_MAP,
    WIDTH,
    direction_text,
    label,
)

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FINE = 0.5
"""Heights (µm) below which colours are in nm."""

_LARGEST = 60.0
"""Area (square points) of the mark of the contact that carries most."""

BAR_FRACTION = 0.25
"""About how much of the width the bar of the scale takes."""


def contacts_figure(
    picture: xarray.Dataset, *, direction: float = 0.0, hardness: float | None = None, title: str = ""
) -> Figure:
    """Contacts over the heights of the lower body, and the pressure about the one that carries most; 80 mm wide.

    It is of what `contact_picture` returns, for a motion of the upper body in a direction (degrees, from +x towards
    +y); a hardness (GPa) is marked on the scale of pressures.
    """
    from matplotlib.figure import Figure

    force = picture["contact_force"].values
    has_pressure = "zoom_pressure" in picture and bool((picture["zoom_pressure"].values > 0).any())
    figure = Figure(figsize=(WIDTH, (144 if has_pressure else 86) * MILLIMETRE), layout="constrained")
    drawn = figure.subplots(2 if has_pressure else 1, 1, squeeze=False)[:, 0]
    axes = drawn[0]
    draw_heights(figure, axes, picture["lower_height"].values, box_of(picture, "height"))
    radians = np.radians(direction)
    slope = picture["contact_slope_x"].values * np.cos(radians) + picture["contact_slope_y"].values * np.sin(radians)
    x, y = picture["contact_x"].values, picture["contact_y"].values
    sizes = np.maximum(_LARGEST * force / force.max(initial=1e-300), 3.0)
    for which, colour, marker, words in (
        (slope > 0, OPPOSING, "D", "oppose the motion"),
        (~(slope > 0), LEANING, "o", "do not"),
    ):
        percent = 100 * force[which].sum() / (force.sum() or 1.0)
        text = f"{int(which.sum())} {words}, with {percent:.0f} % of the load"
        style: dict[str, Any] = {"facecolors": "none", "marker": marker}
        axes.scatter(x[which], y[which], s=sizes[which], edgecolors="white", linewidths=2.0, **style)
        axes.scatter(x[which], y[which], s=sizes[which], edgecolors=colour, linewidths=1.2, label=text, **style)
    shift = [float(picture.attrs[name]) for name in ("x", "y")]
    along = [f"{each:.3g} µm".replace("-", "\N{MINUS SIGN}") for each in shift]
    moved = "" if np.isnan(shift).any() else f"upper body moved by {along[0]} and {along[1]}"
    axes.set_title(
        "\n".join(line for line in (
            title, f"{force.size} contacts at {with_unit(float(picture.attrs['load_mN']), 'mN')}", moved,
        ) if line), loc="left", fontsize=6, pad=3,
    )  # fmt: skip
    scale_bar(axes, box_of(picture, "height"))
    if has_pressure:
        _pressure_panel(figure, drawn[1], picture, hardness)
        left, right, bottom, top = box_of(picture, "zoom")
        axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], color="white", linewidth=1.6)
        axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], color="black", linewidth=0.6)
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower center",
        title=f"motion along {direction_text(direction)}; size of a mark: its load, not its area",
    )  # fmt: skip
    return figure


def draw_heights(figure: Figure, axes: Axes, heights: Floats, box: tuple[float, float, float, float]) -> None:
    """Heights of the lower body in grey, with their scale, in a box: left, right, bottom, top (µm)."""
    fine = np.ptp(heights) < _FINE
    shown = heights * (1000 if fine else 1)
    low, high = np.quantile(shown, [0.01, 0.99])
    image = axes.imshow(shown, extent=box, origin="lower", cmap="gray", vmin=low, vmax=high)
    bar = figure.colorbar(image, ax=axes, extend="both", shrink=0.8)
    bar.set_label("lower body, " + label("height_nm" if fine else "height"))
    axes.set_xlabel(label("x"))
    axes.set_ylabel(label("y"))


def box_of(picture: xarray.Dataset, what: str) -> tuple[float, float, float, float]:
    """Where a map of the picture lies: left, right, bottom, top."""
    ends: list[float] = []
    for axis in ("x", "y"):
        values = picture[f"{what}_{axis}"].values
        ends += [float(values[0]), float(2 * values[-1] - values[-2])]
    return ends[0], ends[1], ends[2], ends[3]


def scale_bar(axes: Axes, box: tuple[float, float, float, float]) -> None:
    """A bar of a round length in the lower right corner."""
    from matplotlib.patheffects import withStroke

    left, right, bottom, top = box
    wanted = BAR_FRACTION * (right - left)
    power = 10.0 ** np.floor(np.log10(wanted))
    length = max(factor * power for factor in (1, 2, 5) if factor * power <= wanted)
    x, y = right - 0.05 * (right - left) - length, bottom + 0.05 * (top - bottom)
    halo = [withStroke(linewidth=2.5, foreground="black")]
    axes.plot([x, x + length], [y, y], color="white", linewidth=1.5, path_effects=halo, solid_capstyle="butt")
    above = y + 0.015 * (top - bottom)
    name = axes.text(x + length / 2, above, f"{length:g} µm", color="white", fontsize=6, path_effects=halo)
    name.set(horizontalalignment="center", verticalalignment="bottom")


def _pressure_panel(figure: Figure, axes: Axes, picture: xarray.Dataset, hardness: float | None) -> None:
    """Pressure about the contact that carries most."""
    pressure = picture["zoom_pressure"].values
    box = box_of(picture, "zoom")
    axes.imshow(picture["zoom_height"].values, extent=box, origin="lower", cmap="gray", alpha=0.6)
    image = axes.imshow(
        np.where(pressure > 0, pressure, np.nan), extent=box, origin="lower", cmap=PRESSURE_MAP, vmin=0,
        vmax=hardness if hardness is not None and float(np.nanmax(pressure)) >= 0.99 * hardness else None,
    )  # fmt: skip
    bar = figure.colorbar(image, ax=axes, shrink=0.8)
    bar.set_label(label("pressure"))
    if hardness is not None and image.get_clim()[1] >= 0.99 * hardness:
        bar.ax.axhline(hardness, color="black", linewidth=1)
        bar.ax.text(0.5, 1.02, "hardness", transform=bar.ax.transAxes, fontsize=6, ha="center", va="bottom")
    axes.set_title("around the contact that carries most (framed above)", loc="left", fontsize=6, pad=3)
    axes.set_xlabel(label("x"))
    axes.set_ylabel(label("y"))
