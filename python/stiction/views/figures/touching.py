"""Two measured bodies where they touch, as their page shows them first."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._drawing import HEIGHT_MAP
from stiction.views.figures.contact import box_of, draw_bodies
from stiction.views.style import LEANING, OPPOSING, label, new_figure

CUT = "#e00030"  # contacts that the edge cuts
AROUND = 5  # contacts near the strongest that are magnified with it, where they are not far
CLOSEST = 60  # points of a line on both sides of the strongest contact that are magnified, at least


def climbing(picture: xarray.Dataset, direction: float) -> NDArray[np.bool_]:
    """Contacts that have to climb where the upper body moves in a direction (degrees)."""
    x, y = (picture[f"contact_slope_{axis}"].values for axis in "xy")
    return np.asarray(x * np.cos(np.radians(direction)) + y * np.sin(np.radians(direction)) > 0)


def touching_figure(picture: xarray.Dataset, *, direction: float = 0.0) -> Figure:
    """Contacts over maps or between lines, by whether they have to climb and whether the edge cuts them.

    It is of what `contact_picture` returns, for a motion of the upper body in a direction (degrees); 80 mm wide.
    """
    climbs, cut = climbing(picture, direction), picture["contact_at_edge"].values > 0
    kinds = [(OPPOSING, "has to climb"), (LEANING, "does not")] + [(CUT, "cut by the edge")] * bool(cut.any())
    if "gap" in picture:
        figure = new_figure(70)
        _lines(figure.subplots(2, 1, height_ratios=[1, 2.5]), picture, np.where(climbs, OPPOSING, LEANING), cut)
    else:
        figure = new_figure(80)
        _map(figure.subplots(), picture, climbs, cut)
    figure.legend(
        handles=[Patch(color=colour, label=words) for colour, words in kinds], loc="outside upper left", ncols=3
    )
    return figure


def _map(axes: Axes, picture: xarray.Dataset, climbs: NDArray[np.bool_], cut: NDArray[np.bool_]) -> None:
    """Patches over the heights of the lower body."""
    heights, patch = (picture[name].transpose("height_y", "height_x").values for name in ("lower_height", "patch"))
    place: dict[str, Any] = {"extent": box_of(picture, "height"), "origin": "lower"}
    axes.imshow(heights, cmap=HEIGHT_MAP, **place)
    kind = np.append(np.nan, climbs)[patch]
    axes.imshow(kind, cmap=ListedColormap([LEANING, OPPOSING]), vmin=0, vmax=1, interpolation="nearest", **place)
    if (outlined := np.append(False, cut)[patch]).any():
        axes.contour(outlined, levels=[0.5], colors=CUT, linewidths=1.2, **place)
    axes.set(xlabel=label("x"), ylabel=label("y"))


def _lines(panels: Any, picture: xarray.Dataset, colours: NDArray[Any], cut: NDArray[np.bool_]) -> None:
    """Both lines, whole and about the strongest contact."""
    x, lower, gap = (picture[name].values for name in ("height_x", "lower_height", "gap"))
    there = np.isfinite(gap)  # over holes it is drawn straight
    bodies = np.array([lower + np.interp(x, x[there], gap[there]).clip(0), lower]) * 1000
    middle, width = picture["contact_x"].values, picture["contact_patch_area"].values  # of lines 1 µm thick
    close = slice(*np.searchsorted(x, _ends(x, middle, width, picture["contact_force"].values, cut)))
    for axes, part in zip(panels, (slice(None), close), strict=True):
        draw_bodies(axes, x[part], *bodies[:, part])
        axes.set(xlim=x[part][[0, -1]], ylabel=label("height_nm"))
    panels[0].scatter(middle, np.interp(middle, x, bodies[1]), s=4, c=np.where(cut, CUT, colours), zorder=3)
    panels[0].axvspan(*x[close][[0, -1]], color="0.5", alpha=0.25, linewidth=0)
    low, high = bodies[1, close].min(), bodies[1, close].max()
    room = (high - low) or 1.0
    top = min(high + 0.6 * room, panels[1].get_ylim()[1])
    panels[1].set(ylim=(low - 0.1 * room, top), xlabel=f"{label('x')}, magnified")
    for at, half, colour, is_cut in zip(middle, width / 2, colours, cut, strict=True):
        own = np.linspace(at - half, at + half, 20)
        for edge, line in [(CUT, 4.5)] * bool(is_cut) + [(colour, 2.5)]:
            panels[1].plot(own, np.interp(own, x, bodies[1]), color=edge, linewidth=line, solid_capstyle="round")


def _ends(x: Floats, middle: Floats, width: Floats, force: Floats, cut: NDArray[np.bool_]) -> tuple[float, float]:
    """Between which places a line is magnified: the strongest contact that is whole, and some beside it."""
    strongest = middle[np.argmax(np.where(cut, -1.0, force))]
    apart = np.sort(np.abs(middle - strongest))
    least = max(CLOSEST * (x[1] - x[0]), 4 * float(width.max()))
    half = float(np.clip(1.3 * apart[min(AROUND, apart.size - 1)], least, x[-1] / 7))
    start = float(np.clip(strongest - half, 0, max(x[-1] - 2 * half, 0)))
    return start, start + 2 * half
