"""Two profiles in contact with the forces on the upper one, and the contacts of two measured bodies."""

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

_ZOOM = 40  # spacings on both sides of the contact that is drawn large, at least
_FINE = 0.5  # heights (µm) below which an axis is in nm
_LONGEST = 0.45  # inches of the longest arrow
CUT = "#e00030"  # contacts that the edge cuts
AROUND = 5  # contacts near the strongest that are magnified with it, where they are not far
CLOSEST = 60  # points of a line on both sides of the strongest contact that are magnified, at least


def contact_figure(
    upper: Profile, lower: Profile, approach: float, *, mu0: float, tau0: float = 0.0, load: float | None = None,
    offset: float | None = None, title: str = "", **contact: Any,
) -> Figure:  # fmt: skip
    """Two profiles in contact: all of them, and the contact that carries most with the forces on the upper body.

    They are on the same grid, at an approach (µm) at which they carry a load (mN), as the title says; where the upper
    one lies on a longer one it is moved by an offset (µm). Contacts are as `contacts` finds them; tau0 is in GPa.
    """
    touching = contacts(upper, lower, approach, **contact)
    x = lower.x
    drop = float((upper.heights - lower.heights).min()) + approach
    fine = max(float(np.ptp(upper.heights)), float(np.ptp(lower.heights))) < _FINE
    scale = 1000.0 if fine else 1.0
    bodies = scale * (upper.heights - drop), scale * lower.heights
    figure = new_figure(90)
    whole, large = figure.subplots(2, 1, height_ratios=[1, 1.5])
    draw_bodies(whole, x, *bodies)
    whole.plot(touching.centre[:, 0], scale * touching.centre[:, 2], "o", color=FORCE, markersize=2, mew=0)
    whole.set_xlim(x[0], x[-1])
    number = f"{len(touching)} {'contact' if len(touching) == 1 else 'contacts'}"
    words = [] if load is None else [f"$F_N$ = {with_unit(load, 'mN')}"]
    words += [] if offset is None else [f"upper profile moved by {offset:.4g} µm"]
    lines = (title, f"{number} at an approach of {1000 * approach:.4g} nm", ", ".join(words))
    whole.set_title("\n".join(filter(None, lines)), loc="left", fontsize=6, pad=3)
    shown: NDArray[np.bool_] = np.zeros(len(touching), np.bool_)
    if len(touching):
        largest = int(touching.force.argmax())
        half = max(_ZOOM * lower.spacing, 6 * float(np.sqrt(touching.radius[largest] * touching.overlap[largest])))
        middle = float(touching.centre[largest, 0])
        inside = np.abs(x - middle) <= half
        large.set_title("where most of the load is", loc="left", fontsize=6, pad=3)  # that there is room
        draw_bodies(large, x[inside], *(body[inside] for body in bodies))
        large.set_xlim(x[inside][0], x[inside][-1])
        whole.axvspan(middle - half, middle + half, color="0.5", alpha=0.25, linewidth=0)
        shown = np.abs(touching.centre[:, 0] - middle) <= half
    for ax in (whole, large):
        ax.set(ylabel=label("height_nm" if fine else "height"), xlabel=label("x"))
    resisting = np.where(touching.opposing, mu0 * touching.force + tau0 * touching.area, 0.0)
    style: dict[str, Any] = {"linestyle": "none", "markersize": 5}
    handles = [Line2D([], [], color=FORCE, marker=r"$\uparrow$", label="elastic force on the upper body", **style)]
    if (resisting[shown] > 0).any():
        handles.append(Line2D([], [], color=FRICTION, marker=r"$\leftarrow$", label="friction", **style))
    figure.legend(
        handles=handles, title="arrows are normal and tangent to the surfaces as they are drawn",
        loc="outside lower center", ncols=len(handles),
    )  # fmt: skip
    figure.draw_without_rendering()  # arrows need the final place of the axes
    figure.set_layout_engine("none")
    if len(touching):
        size = _room_for_arrows(large, scale * float(touching.centre[shown, 2].max()))
        (right, _), (_, up), (left, low) = large.transData.transform([(1.0, 0.0), (0.0, scale), (0.0, 0.0)])
        larger = float((up - low) / (right - left))
        said = f"where most of the load is; heights drawn {larger:.2g} times larger"
        large.set_title(said, loc="left", fontsize=6, pad=3)
        _forces(large, touching, shown, scale, larger, resisting, size)
    return figure


def draw_bodies(axes: Axes, x: Floats, upper: Floats, lower: Floats) -> None:
    """Two lines as the bodies that they bound."""
    top, bottom = max(float(upper.max()), float(lower.max())), min(float(upper.min()), float(lower.min()))
    margin = 0.08 * (top - bottom or 1.0)
    axes.fill_between(x, upper, top + margin, color=UPPER, linewidth=0)
    axes.fill_between(x, bottom - margin, lower, color=LOWER, linewidth=0)
    axes.plot(x, upper, color="#3f6f93", linewidth=0.5)
    axes.plot(x, lower, color="#7d6a3c", linewidth=0.5)
    axes.set_ylim(bottom - margin, top + margin)
    for side, height, align in (("upper body", 0.97, "top"), ("lower body", 0.03, "bottom")):
        axes.text(0.01, height, side, transform=axes.transAxes, fontsize=6, color="#333333", va=align)


def _room_for_arrows(axes: Axes, highest: float) -> float:
    """Inches of the longest arrow, for which there is room above the highest contact: else it loses its head."""
    figure = axes.get_figure()
    assert figure is not None
    inches = axes.get_window_extent().transformed(figure.dpi_scale_trans.inverted())
    size = min(_LONGEST, 0.4 * inches.height, 0.25 * inches.width)
    low, high = axes.get_ylim()
    top = low + (highest - low) / (1 - 1.15 * size / inches.height)
    if top > high:
        axes.set_ylim(low, top)
        axes.axhspan(high, top, color=UPPER, linewidth=0)
    return float(size)


def _forces(
    axes: Axes, touching: Contacts, shown: Any, scale: float, larger: float, resisting: Floats, size: float
) -> None:
    """Elastic forces on the upper body and the friction of the opposing contacts, all to one scale, inside the axes.

    As the surface is drawn: where heights are drawn larger by a factor, so are the slopes that arrows stand on.
    """
    places, normals, tangents = (each[:, ::2] for each in (touching.centre, touching.normal, touching.tangent))  # x, z
    places = places * (1.0, scale)

    def drawn(vectors: Floats, factors: tuple[float, float]) -> Floats:
        bent = vectors * factors
        return np.asarray(bent / np.hypot(*bent.T)[:, np.newaxis])

    elastic = touching.force[:, np.newaxis] * drawn(normals, (larger, 1.0))
    friction = resisting[:, np.newaxis] * drawn(tangents, (1.0, larger))
    longest = max(float(np.hypot(*force[shown].T).max(initial=0.0)) for force in (elastic, friction))
    for force, colour in ((elastic, FORCE), (friction, FRICTION)):
        there = shown & (np.hypot(*force.T) > 0)
        # In inches on the page, so that an arrow has the direction that is given whatever the axes are stretched by.
        axes.quiver(
            *places[there].T, *force[there].T, color=colour, angles="uv", scale=longest / size,
            scale_units="inches", width=0.012, units="inches", zorder=3,
        )  # fmt: skip
    axes.plot(*places[shown].T, "o", color=FORCE, markersize=2.5, mew=0, zorder=4)


# ---- All of a member ------------------------------------------------------------------------------------------------


_LARGEST = 60.0  # area (square points) of the mark of the contact that carries most


def climbing(picture: xarray.Dataset, direction: float) -> NDArray[np.bool_]:
    """Contacts that have to climb where the upper body moves in a direction (degrees)."""
    x, y = (picture[f"contact_slope_{axis}"].values for axis in "xy")
    return np.asarray(x * np.cos(np.radians(direction)) + y * np.sin(np.radians(direction)) > 0)


def contacts_figure(
    picture: xarray.Dataset, *, direction: float = 0.0, hardness: float | None = None, title: str = ""
) -> Figure:
    """Contacts over the heights of the lower body, and the pressure about the one that carries most; 80 mm wide.

    It is of what `contact_picture` returns, for a motion of the upper body in a direction (degrees, from +x towards
    +y); a hardness (GPa) is marked on the scale of pressures.
    """
    force = picture["contact_force"].values
    has_pressure = "zoom_pressure" in picture and bool((picture["zoom_pressure"].values > 0).any())
    figure = new_figure(144 if has_pressure else 86)
    drawn = figure.subplots(2 if has_pressure else 1, 1, squeeze=False)[:, 0]
    axes = drawn[0]
    draw_heights(figure, axes, picture["lower_height"].values, box_of(picture, "height"))
    climbs = climbing(picture, direction)
    x, y = picture["contact_x"].values, picture["contact_y"].values
    sizes = np.maximum(_LARGEST * force / force.max(initial=1e-300), 3.0)
    for which, colour, marker, words in (
        (climbs, OPPOSING, "D", "oppose the motion"),
        (~climbs, LEANING, "o", "do not"),
    ):
        percent = 100 * force[which].sum() / (force.sum() or 1.0)
        text = f"{int(which.sum())} {words}, with {percent:.0f} % of the load"
        style: dict[str, Any] = {"facecolors": "none", "marker": marker}
        axes.scatter(x[which], y[which], s=sizes[which], edgecolors="white", linewidths=2.0, **style)
        axes.scatter(x[which], y[which], s=sizes[which], edgecolors=colour, linewidths=1.2, label=text, **style)
    shift = [float(picture.attrs[name]) for name in ("x", "y")]
    along = [f"{each:.3g} µm".replace("-", "\N{MINUS SIGN}") for each in shift]
    moved = "" if np.isnan(shift).any() else f"upper body moved by {along[0]} and {along[1]}"
    words = f"{force.size} contacts at {with_unit(float(picture.attrs['load_mN']), 'mN')}"
    axes.set_title("\n".join(filter(None, (title, words, moved))), loc="left", fontsize=6, pad=3)
    add_scale_bar(axes, box_of(picture, "height"), fontsize=6)
    if has_pressure:
        _pressure_panel(figure, drawn[1], picture, hardness)
        draw_frame(axes, box_of(picture, "zoom"))
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
    axes.set(xlabel=label("x"), ylabel=label("y"))


def draw_frame(axes: Axes, box: tuple[float, float, float, float]) -> None:
    """A frame around a box of a map, which is seen on light and on dark heights."""
    left, right, bottom, top = box
    for colour, width in (("white", 1.6), ("black", 0.6)):
        axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], color=colour, linewidth=width)


def box_of(picture: xarray.Dataset, what: str) -> tuple[float, float, float, float]:
    """Where a map of the picture lies: left, right, bottom, top."""
    ends: list[float] = []
    for axis in ("x", "y"):
        values = picture[f"{what}_{axis}"].values
        ends += [float(values[0]), float(2 * values[-1] - values[-2])]
    return ends[0], ends[1], ends[2], ends[3]


def _pressure_panel(figure: Figure, axes: Axes, picture: xarray.Dataset, hardness: float | None) -> None:
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
    axes.set(xlabel=label("x"), ylabel=label("y"))


# ---- Where they touch ------------------------------------------------------------------------------------------------


def touching_figure(picture: xarray.Dataset, *, direction: float = 0.0) -> Figure:
    """Contacts over maps or between lines, by whether they have to climb and whether the edge cuts them.

    It is of what `contact_picture` returns, for a motion of the upper body in a direction (degrees); 80 mm wide.
    """
    climbs, cut = climbing(picture, direction), picture["contact_at_edge"].values > 0
    kinds = [(OPPOSING, "opposes the motion"), (LEANING, "does not")] + [(CUT, "cut by the edge")] * bool(cut.any())
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
