"""Figures of contacts: two profiles with the forces on the upper one, and the contacts of two measured bodies."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._drawing import HEIGHT_MAP, PRESSURE_MAP, add_scale_bar
from stiction._number_format import with_unit
from stiction.mechanics.contact import Contacts, contacts
from stiction.surfaces.profile import Profile
from stiction.views.style import FORCE, FRICTION, LEANING, LOWER, OPPOSING, UPPER, direction_text, label, new_figure

_MIN_ZOOM_SPACINGS = 40  # minimum number of spacings on both sides of the magnified contact
_MAX_NANOMETRE_RANGE = 0.5  # range of heights (µm) below which an axis is in nm
_MAX_ARROW_LENGTH = 0.45  # inches
EDGE_COLOUR = "#e00030"  # contacts cut by the edge of the map
NUM_NEIGHBOURS = 5  # number of neighbouring contacts magnified with the strongest one
MIN_ZOOM_POINTS = 60  # minimum number of points on both sides of the strongest contact


def contact_figure(
    upper: Profile, lower: Profile, approach: float, *, mu0: float, tau0: float = 0.0, load: float | None = None,
    offset: float | None = None, title: str = "", **contact: Any,
) -> Figure:  # fmt: skip
    """Draw two profiles in contact, and the contact with the largest load with the forces on the upper body.

    Both profiles are on the same grid, at an approach (µm) that corresponds to the load (mN) in the title. `offset`
    (µm) is the position of the upper profile on a longer lower one. Contacts are found by `contacts`; tau0 is in GPa.
    """
    contact_points = contacts(upper, lower, approach, **contact)
    x = lower.x
    drop = float((upper.heights - lower.heights).min()) + approach
    fine = max(float(np.ptp(upper.heights)), float(np.ptp(lower.heights))) < _MAX_NANOMETRE_RANGE
    scale = 1000.0 if fine else 1.0
    bodies = scale * (upper.heights - drop), scale * lower.heights
    figure = new_figure(90)
    whole, large = figure.subplots(2, 1, height_ratios=[1, 1.5])
    draw_bodies(whole, x, *bodies)
    whole.plot(contact_points.centre[:, 0], scale * contact_points.centre[:, 2], "o", color=FORCE, markersize=2, mew=0)
    whole.set_xlim(x[0], x[-1])
    number = f"{len(contact_points)} {'contact' if len(contact_points) == 1 else 'contacts'}"
    words = [] if load is None else [f"$F_N$ = {with_unit(load, 'mN')}"]
    words += [] if offset is None else [f"upper profile moved by {offset:.4g} µm"]
    lines = (title, f"{number} at an approach of {1000 * approach:.4g} nm", ", ".join(words))
    whole.set_title("\n".join(filter(None, lines)), loc="left", fontsize=6, pad=3)
    shown: NDArray[np.bool_] = np.zeros(len(contact_points), np.bool_)
    if len(contact_points):
        largest = int(contact_points.force.argmax())
        half = max(
            _MIN_ZOOM_SPACINGS * lower.spacing,
            6 * float(np.sqrt(contact_points.radius[largest] * contact_points.overlap[largest])),
        )
        middle = float(contact_points.centre[largest, 0])
        inside = np.abs(x - middle) <= half
        large.set_title("contact with the largest load", loc="left", fontsize=6, pad=3)  # reserves space for the title
        draw_bodies(large, x[inside], *(body[inside] for body in bodies))
        large.set_xlim(x[inside][0], x[inside][-1])
        whole.axvspan(middle - half, middle + half, color="0.5", alpha=0.25, linewidth=0)
        shown = np.abs(contact_points.centre[:, 0] - middle) <= half
    for ax in (whole, large):
        ax.set(ylabel=label("height_nm" if fine else "height"), xlabel=label("x"))
    resisting = np.where(contact_points.opposing, mu0 * contact_points.force + tau0 * contact_points.area, 0.0)
    style: dict[str, Any] = {"linestyle": "none", "markersize": 5}
    handles = [Line2D([], [], color=FORCE, marker=r"$\uparrow$", label="elastic force on the upper body", **style)]
    if (resisting[shown] > 0).any():
        handles.append(Line2D([], [], color=FRICTION, marker=r"$\leftarrow$", label="friction", **style))
    figure.legend(
        handles=handles, title="arrows are normal and tangential to the surfaces as drawn",
        loc="outside lower center", ncols=len(handles),
    )  # fmt: skip
    figure.draw_without_rendering()  # arrows need the final axes position
    figure.set_layout_engine("none")
    if len(contact_points):
        size = _reserve_arrow_length(large, scale * float(contact_points.centre[shown, 2].max()))
        (right, _), (_, up), (left, low) = large.transData.transform([(1.0, 0.0), (0.0, scale), (0.0, 0.0)])
        larger = float((up - low) / (right - left))
        text = f"contact with the largest load; heights magnified {larger:.2g} times"
        large.set_title(text, loc="left", fontsize=6, pad=3)
        _draw_forces(large, contact_points, shown, scale, larger, resisting, size)
    return figure


def draw_bodies(axes: Axes, x: Floats, upper: Floats, lower: Floats) -> None:
    """Draw two profiles as the surfaces of solid bodies."""
    top, bottom = max(float(upper.max()), float(lower.max())), min(float(upper.min()), float(lower.min()))
    margin = 0.08 * (top - bottom or 1.0)
    axes.fill_between(x, upper, top + margin, color=UPPER, linewidth=0)
    axes.fill_between(x, bottom - margin, lower, color=LOWER, linewidth=0)
    axes.plot(x, upper, color="#3f6f93", linewidth=0.5)
    axes.plot(x, lower, color="#7d6a3c", linewidth=0.5)
    axes.set_ylim(bottom - margin, top + margin)
    for side, height, align in (("upper body", 0.97, "top"), ("lower body", 0.03, "bottom")):
        axes.text(0.01, height, side, transform=axes.transAxes, fontsize=6, color="#333333", va=align)


def _reserve_arrow_length(axes: Axes, highest: float) -> float:
    """Return the length (inches) of the longest arrow and extend the axes so that it fits above the highest contact."""
    figure = axes.get_figure()
    assert figure is not None
    inches = axes.get_window_extent().transformed(figure.dpi_scale_trans.inverted())
    size = min(_MAX_ARROW_LENGTH, 0.4 * inches.height, 0.25 * inches.width)
    low, high = axes.get_ylim()
    top = low + (highest - low) / (1 - 1.15 * size / inches.height)
    if top > high:
        axes.set_ylim(low, top)
        axes.axhspan(high, top, color=UPPER, linewidth=0)
    return float(size)


def _draw_forces(
    axes: Axes, contact_points: Contacts, shown: Any, scale: float, larger: float, resisting: Floats, size: float
) -> None:
    """Draw elastic forces on the upper body and friction at opposing contacts, all to the same scale.

    Slopes are magnified by the same factor as heights.
    """
    places, normals, tangents = (
        item[:, ::2] for item in (contact_points.centre, contact_points.normal, contact_points.tangent)
    )  # x, z
    places = places * (1.0, scale)

    def panels(vectors: Floats, factors: tuple[float, float]) -> Floats:
        bent = vectors * factors
        return np.asarray(bent / np.hypot(*bent.T)[:, np.newaxis])

    elastic = contact_points.force[:, np.newaxis] * panels(normals, (larger, 1.0))
    friction = resisting[:, np.newaxis] * panels(tangents, (1.0, larger))
    longest = max(float(np.hypot(*force[shown].T).max(initial=0.0)) for force in (elastic, friction))
    for force, colour in ((elastic, FORCE), (friction, FRICTION)):
        finite = shown & (np.hypot(*force.T) > 0)
        # Units are inches, so that the direction of an arrow does not depend on the scales of the axes.
        axes.quiver(
            *places[finite].T, *force[finite].T, color=colour, angles="uv", scale=longest / size,
            scale_units="inches", width=0.012, units="inches", zorder=3,
        )  # fmt: skip
    axes.plot(*places[shown].T, "o", color=FORCE, markersize=2.5, mew=0, zorder=4)


# ---- All of a member ------------------------------------------------------------------------------------------------


_MAX_MARKER_AREA = 60.0  # area (square points) of the marker of the contact with the largest load


def find_opposing_contacts(picture: xarray.Dataset, direction: float) -> NDArray[np.bool_]:
    """Return a mask of the contacts whose slope opposes a motion of the upper body in a direction (degrees)."""
    x, y = (picture[f"contact_slope_{axis}"].values for axis in "xy")
    return np.asarray(x * np.cos(np.radians(direction)) + y * np.sin(np.radians(direction)) > 0)


def contacts_figure(
    picture: xarray.Dataset, *, direction: float = 0.0, hardness: float | None = None, title: str = ""
) -> Figure:
    """Draw contacts over the heights of the lower body, and the pressure around the largest load; 80 mm wide.

    `picture` is a result of `contact_picture`, `direction` the motion of the upper body (degrees from +x towards +y).
    The hardness (GPa) is marked on the colour bar of pressures.
    """
    force = picture["contact_force"].values
    has_pressure = "zoom_pressure" in picture and bool((picture["zoom_pressure"].values > 0).any())
    figure = new_figure(144 if has_pressure else 86)
    panels = figure.subplots(2 if has_pressure else 1, 1, squeeze=False)[:, 0]
    axes = panels[0]
    draw_heights(figure, axes, picture["lower_height"].values, map_extent(picture, "height"))
    is_opposing = find_opposing_contacts(picture, direction)
    x, y = picture["contact_x"].values, picture["contact_y"].values
    sizes = np.maximum(_MAX_MARKER_AREA * force / force.max(initial=1e-300), 3.0)
    for mask, colour, marker, words in (
        (is_opposing, OPPOSING, "D", "oppose the motion"),
        (~is_opposing, LEANING, "o", "do not"),
    ):
        percent = 100 * force[mask].sum() / (force.sum() or 1.0)
        text = f"{int(mask.sum())} {words}, with {percent:.0f} % of the load"
        style: dict[str, Any] = {"facecolors": "none", "marker": marker}
        axes.scatter(x[mask], y[mask], s=sizes[mask], edgecolors="white", linewidths=2.0, **style)
        axes.scatter(x[mask], y[mask], s=sizes[mask], edgecolors=colour, linewidths=1.2, label=text, **style)
    shift = [float(picture.attrs[name]) for name in ("x", "y")]
    along = [f"{item:.3g} µm".replace("-", "\N{MINUS SIGN}") for item in shift]
    moved = "" if np.isnan(shift).any() else f"upper body moved by {along[0]} and {along[1]}"
    words = f"{force.size} contacts at {with_unit(float(picture.attrs['load_mN']), 'mN')}"
    axes.set_title("\n".join(filter(None, (title, words, moved))), loc="left", fontsize=6, pad=3)
    add_scale_bar(axes, map_extent(picture, "height"), fontsize=6)
    if has_pressure:
        _pressure_panel(figure, panels[1], picture, hardness)
        draw_frame(axes, map_extent(picture, "zoom"))
    figure.legend(
        *axes.get_legend_handles_labels(), loc="outside lower center",
        title=f"motion along {direction_text(direction)}; marker size: load, not area",
    )  # fmt: skip
    return figure


def draw_heights(figure: Figure, axes: Axes, heights: Floats, box: tuple[float, float, float, float]) -> None:
    """Draw heights of the lower body in grey with a colour bar; `box` is left, right, bottom, top (µm)."""
    fine = np.ptp(heights) < _MAX_NANOMETRE_RANGE
    shown = heights * (1000 if fine else 1)
    low, high = np.quantile(shown, [0.01, 0.99])
    image = axes.imshow(shown, extent=box, origin="lower", cmap="gray", vmin=low, vmax=high)
    bar = figure.colorbar(image, ax=axes, extend="both", shrink=0.8)
    bar.set_label("lower body, " + label("height_nm" if fine else "height"))
    axes.set(xlabel=label("x"), ylabel=label("y"))


def draw_frame(axes: Axes, box: tuple[float, float, float, float]) -> None:
    """Draw a frame on a map, visible on light and dark heights."""
    left, right, bottom, top = box
    for colour, width in (("white", 1.6), ("black", 0.6)):
        axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], color=colour, linewidth=width)


def map_extent(picture: xarray.Dataset, name: str) -> tuple[float, float, float, float]:
    """Return the extent of a map: left, right, bottom, top (µm)."""
    ends: list[float] = []
    for axis in ("x", "y"):
        values = picture[f"{name}_{axis}"].values
        ends += [float(values[0]), float(2 * values[-1] - values[-2])]
    return ends[0], ends[1], ends[2], ends[3]


def _pressure_panel(figure: Figure, axes: Axes, picture: xarray.Dataset, hardness: float | None) -> None:
    pressure = picture["zoom_pressure"].values
    box = map_extent(picture, "zoom")
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
    axes.set_title("around the contact with the largest load (frame above)", loc="left", fontsize=6, pad=3)
    axes.set(xlabel=label("x"), ylabel=label("y"))


# ---- Contacts --------------------------------------------------------------------------------------------------------


def contact_map_figure(picture: xarray.Dataset, *, direction: float = 0.0) -> Figure:
    """Draw contacts on maps or between lines, coloured by slope against the motion and by cuts at the edge.

    `picture` is a result of `contact_picture`, `direction` the motion of the upper body (degrees); 80 mm wide.
    """
    is_opposing, cut = find_opposing_contacts(picture, direction), picture["contact_at_edge"].values > 0
    kinds = [(OPPOSING, "opposes motion"), (LEANING, "assists motion")] + [(EDGE_COLOUR, "cut by the edge")] * bool(
        cut.any()
    )
    if "gap" in picture:
        figure = new_figure(70)
        _draw_lines(
            figure.subplots(2, 1, height_ratios=[1, 2.5]), picture, np.where(is_opposing, OPPOSING, LEANING), cut
        )
    else:
        figure = new_figure(80)
        _draw_contact_map(figure.subplots(), picture, is_opposing, cut)
    figure.legend(
        handles=[Patch(color=colour, label=words) for colour, words in kinds], loc="outside upper left", ncols=3
    )
    return figure


def _draw_contact_map(
    axes: Axes, picture: xarray.Dataset, is_opposing: NDArray[np.bool_], cut: NDArray[np.bool_]
) -> None:
    heights, patch = (picture[name].transpose("height_y", "height_x").values for name in ("lower_height", "patch"))
    place: dict[str, Any] = {"extent": map_extent(picture, "height"), "origin": "lower"}
    axes.imshow(heights, cmap=HEIGHT_MAP, **place)
    kind = np.append(np.nan, is_opposing)[patch]
    axes.imshow(kind, cmap=ListedColormap([LEANING, OPPOSING]), vmin=0, vmax=1, interpolation="nearest", **place)
    if (outlined := np.append(False, cut)[patch]).any():
        axes.contour(outlined, levels=[0.5], colors=EDGE_COLOUR, linewidths=1.2, **place)
    axes.set(xlabel=label("x"), ylabel=label("y"))


def _draw_lines(panels: Any, picture: xarray.Dataset, colours: NDArray[Any], cut: NDArray[np.bool_]) -> None:
    """Draw both lines, complete and magnified around the strongest contact."""
    x, lower, gap = (picture[name].values for name in ("height_x", "lower_height", "gap"))
    finite = np.isfinite(gap)  # missing data is interpolated
    bodies = np.array([lower + np.interp(x, x[finite], gap[finite]).clip(0), lower]) * 1000
    middle, width = picture["contact_x"].values, picture["contact_patch_area"].values  # profiles are 1 µm wide
    close = slice(*np.searchsorted(x, _zoom_range(x, middle, width, picture["contact_force"].values, cut)))
    for axes, part in zip(panels, (slice(None), close), strict=True):
        draw_bodies(axes, x[part], *bodies[:, part])
        axes.set(xlim=x[part][[0, -1]], ylabel=label("height_nm"))
    panels[0].scatter(middle, np.interp(middle, x, bodies[1]), s=4, c=np.where(cut, EDGE_COLOUR, colours), zorder=3)
    panels[0].axvspan(*x[close][[0, -1]], color="0.5", alpha=0.25, linewidth=0)
    low, high = bodies[1, close].min(), bodies[1, close].max()
    room = (high - low) or 1.0
    top = min(high + 0.6 * room, panels[1].get_ylim()[1])
    panels[1].set(ylim=(low - 0.1 * room, top), xlabel=f"{label('x')}, magnified")
    for at, half, colour, is_cut in zip(middle, width / 2, colours, cut, strict=True):
        positions = np.linspace(at - half, at + half, 20)
        for edge, line in [(EDGE_COLOUR, 4.5)] * bool(is_cut) + [(colour, 2.5)]:
            panels[1].plot(
                positions, np.interp(positions, x, bodies[1]), color=edge, linewidth=line, solid_capstyle="round"
            )


def _zoom_range(x: Floats, middle: Floats, width: Floats, force: Floats, cut: NDArray[np.bool_]) -> tuple[float, float]:
    """Return the ends of the magnified range: the strongest contact that is not cut, and its neighbours."""
    strongest = middle[np.argmax(np.where(cut, -1.0, force))]
    apart = np.sort(np.abs(middle - strongest))
    least = max(MIN_ZOOM_POINTS * (x[1] - x[0]), 4 * float(width.max()))
    half = float(np.clip(1.3 * apart[min(NUM_NEIGHBOURS, apart.size - 1)], least, x[-1] / 7))
    start = float(np.clip(strongest - half, 0, max(x[-1] - 2 * half, 0)))
    return start, start + 2 * half
