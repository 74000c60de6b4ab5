"""Figures that show contacts: two profiles with contact forces, or two measured bodies with all contacts."""

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
from stiction._drawing import HEIGHT_COLOUR_MAP, PRESSURE_COLOUR_MAP, add_scale_bar, map_extent
from stiction._number_format import format_with_unit
from stiction.summary.figure_values import find_opposing_contacts
from stiction.views.figures.column_layout import ColumnLayout
from stiction.views.style import (
    FORCE_COLOUR,
    FRICTION_COLOUR,
    LOWER_BODY_COLOUR,
    MIN_LENGTH_IN_MILLIMETRES,
    NOT_OPPOSING_CONTACT_COLOUR,
    OPPOSING_CONTACT_COLOUR,
    UPPER_BODY_COLOUR,
    axis_label,
    direction_text,
    new_figure,
    place_axes,
)

_MIN_HALF_WIDTH_OF_FORCE_MAGNIFIER = 40  # grid spacings
_MAX_HEIGHT_RANGE_IN_NANOMETRES = 0.5  # µm
_MAX_ARROW_LENGTH = 0.45  # inches
_MIN_VISIBLE_TO_LONGEST_ARROW_RATIO = 0.05
EDGE_CONTACT_COLOUR = "#e00030"
NUM_NEIGHBOURING_CONTACTS = 5
_MIN_HALF_WIDTH_OF_PROFILE_MAGNIFIER = 60  # grid spacings


def contact_forces_figure(forces: xarray.Dataset, *, title: str = "") -> Figure:
    """Draw two profiles in contact, and the forces on the upper profile at the contact that carries most load.

    `forces` comes from `build_contact_forces`. The heading contains the load and the shift of the upper profile if the
    dataset has them.
    """
    x, contact_force = forces["height_x"].values, forces["contact_force"].values
    centre_x, centre_z = forces["contact_centre"].values.T
    profiles = [forces[f"{side}_height"].values for side in ("upper", "lower")]
    in_nanometres = max(float(np.ptp(heights)) for heights in profiles) < _MAX_HEIGHT_RANGE_IN_NANOMETRES
    unit_factor = 1000.0 if in_nanometres else 1.0
    bodies = [unit_factor * heights for heights in profiles]
    figure = new_figure(90)
    overview_axes, zoomed_axes = figure.subplots(2, 1, height_ratios=[1, 1.5])
    draw_bodies(overview_axes, x, *bodies)
    overview_axes.plot(centre_x, unit_factor * centre_z, "o", color=FORCE_COLOUR, markersize=2, mew=0)
    overview_axes.set_xlim(x[0], x[-1])
    overview_axes.set_title(_contact_forces_heading(forces, title), loc="left", fontsize=6, pad=3)
    is_in_zoom: NDArray[np.bool_] = np.zeros(contact_force.size, np.bool_)
    if contact_force.size:
        largest_contact_index = int(contact_force.argmax())
        half_width = max(
            _MIN_HALF_WIDTH_OF_FORCE_MAGNIFIER * float(forces.attrs["spacing_um"]),
            6 * float(forces["contact_radius"].values[largest_contact_index]),
        )
        zoom_centre = float(centre_x[largest_contact_index])
        in_window = np.abs(x - zoom_centre) <= half_width
        # The title is set before the layout is computed, so that the layout reserves space for the title.
        zoomed_axes.set_title("contact with the largest load", loc="left", fontsize=6, pad=3)
        draw_bodies(zoomed_axes, x[in_window], *(body[in_window] for body in bodies))
        zoomed_axes.set_xlim(x[in_window][0], x[in_window][-1])
        overview_axes.axvspan(zoom_centre - half_width, zoom_centre + half_width, color="0.5", alpha=0.25, linewidth=0)
        is_in_zoom = np.abs(centre_x - zoom_centre) <= half_width
    for ax in (overview_axes, zoomed_axes):
        ax.set(ylabel=axis_label("height_nm" if in_nanometres else "height"), xlabel=axis_label("x"))
    marker_style: dict[str, Any] = {"linestyle": "none", "markersize": 5}
    handles = [
        Line2D(
            [], [], color=FORCE_COLOUR, marker=r"$\uparrow$", label="elastic force on the upper body", **marker_style
        )
    ]
    largest_friction = forces["contact_friction"].values[is_in_zoom].max(initial=0.0)
    if largest_friction > _MIN_VISIBLE_TO_LONGEST_ARROW_RATIO * contact_force[is_in_zoom].max(initial=0.0):
        handles.append(Line2D([], [], color=FRICTION_COLOUR, marker=r"$\leftarrow$", label="friction", **marker_style))
    figure.legend(
        handles=handles,
        title="arrows are normal and tangential to the surfaces as drawn",
        loc="outside lower center",
        ncols=len(handles),
    )
    # This call fixes the size of the axes, on which the lengths of arrows depend.
    place_axes(figure)
    if contact_force.size:
        max_arrow_length = _make_room_for_arrows(zoomed_axes, unit_factor * float(centre_z[is_in_zoom].max()))
        (unit_x, _), (_, unit_y), (origin_x, origin_y) = zoomed_axes.transData.transform(
            [(1.0, 0.0), (0.0, unit_factor), (0.0, 0.0)]
        )
        magnification = float((unit_y - origin_y) / (unit_x - origin_x))
        text = f"contact with the largest load; heights magnified {magnification:.2g} times"
        zoomed_axes.set_title(text, loc="left", fontsize=6, pad=3)
        _draw_forces(zoomed_axes, forces, is_in_zoom, unit_factor, magnification, max_arrow_length)
    return figure


def _count_text(num_contacts: int) -> str:
    return f"{num_contacts} {'contact' if num_contacts == 1 else 'contacts'}"


def _contact_forces_heading(forces: xarray.Dataset, title: str) -> str:
    """Return the heading of a figure of contact forces: title, number of contacts, approach, load, and shift."""
    attributes = forces.attrs
    load_captions = []
    if "load_mN" in attributes:
        load_captions.append(f"$F_N$ = {format_with_unit(float(attributes['load_mN']), 'mN')}")
    if "x" in attributes:
        load_captions.append(f"upper profile moved by {float(attributes['x']):.4g} µm")
    approach_text = f"{1000 * float(attributes['approach_um']):.4g} nm"
    approach_caption = f"{_count_text(forces.sizes['contact'])} at an approach of {approach_text}"
    return "\n".join(filter(None, (title, approach_caption, ", ".join(load_captions))))


def draw_bodies(axes: Axes, x: Floats, upper: Floats, lower: Floats) -> None:
    """Draw two solid bodies whose surfaces are an upper and a lower profile."""
    top, bottom = max(float(upper.max()), float(lower.max())), min(float(upper.min()), float(lower.min()))
    margin = 0.08 * (top - bottom or 1.0)
    axes.fill_between(x, upper, top + margin, color=UPPER_BODY_COLOUR, linewidth=0)
    axes.fill_between(x, bottom - margin, lower, color=LOWER_BODY_COLOUR, linewidth=0)
    axes.plot(x, upper, color="#3f6f93", linewidth=0.5)
    axes.plot(x, lower, color="#7d6a3c", linewidth=0.5)
    axes.set_ylim(bottom - margin, top + margin)
    for name, height, vertical_alignment in (("upper body", 0.97, "top"), ("lower body", 0.03, "bottom")):
        # In dark mode, labels turn light. A box, which turns dark, keeps them legible on bodies drawn as pixels.
        axes.text(
            0.01, height, name, transform=axes.transAxes, fontsize=6, color="#333333", va=vertical_alignment,
            bbox={"facecolor": "white", "linewidth": 0, "pad": 0.8},
        )  # fmt: skip


def _make_room_for_arrows(axes: Axes, highest: float) -> float:
    """Extend the axes upwards for arrows above the highest contact; return the length limit (inches) of the arrows."""
    figure = axes.get_figure()
    assert figure is not None
    extent_in_inches = axes.get_window_extent().transformed(figure.dpi_scale_trans.inverted())
    arrow_length = min(_MAX_ARROW_LENGTH, 0.4 * extent_in_inches.height, 0.25 * extent_in_inches.width)
    lower_limit, upper_limit = axes.get_ylim()
    new_upper_limit = lower_limit + (highest - lower_limit) / (1 - 1.15 * arrow_length / extent_in_inches.height)
    if new_upper_limit > upper_limit:
        axes.set_ylim(lower_limit, new_upper_limit)
        axes.axhspan(upper_limit, new_upper_limit, color=UPPER_BODY_COLOUR, linewidth=0)
    return float(arrow_length)


def _draw_forces(
    axes: Axes,
    forces: xarray.Dataset,
    is_drawn: NDArray[np.bool_],
    scale: float,
    magnification: float,
    max_arrow_length: float,
) -> None:
    """Draw arrows for the elastic and the frictional forces on the upper body, with lengths on a common scale.

    Slopes are magnified by the same factor as heights.
    """
    positions, normals, tangents = (forces[f"contact_{name}"].values for name in ("centre", "normal", "tangent"))
    positions = positions * (1.0, scale)

    def scale_to_unit_vectors(vectors: Floats, factors: tuple[float, float]) -> Floats:
        scaled_vectors = vectors * factors
        return np.asarray(scaled_vectors / np.hypot(*scaled_vectors.T)[:, np.newaxis])

    elastic, friction = (
        forces[name].values[:, np.newaxis] * scale_to_unit_vectors(directions, factors)
        for name, directions, factors in (
            ("contact_force", normals, (magnification, 1.0)),
            ("contact_friction", tangents, (1.0, magnification)),
        )
    )
    largest_force = max(float(np.hypot(*force[is_drawn].T).max(initial=0.0)) for force in (elastic, friction))
    for force, colour in ((elastic, FORCE_COLOUR), (friction, FRICTION_COLOUR)):
        is_nonzero = is_drawn & (np.hypot(*force.T) > 0)
        # Arrows are specified in inches, so that their directions do not depend on the scales of the axes.
        axes.quiver(
            *positions[is_nonzero].T,
            *force[is_nonzero].T,
            color=colour,
            angles="uv",
            scale=largest_force / max_arrow_length,
            scale_units="inches",
            width=0.012,
            units="inches",
            zorder=3,
        )
    axes.plot(*positions[is_drawn].T, "o", color=FORCE_COLOUR, markersize=2.5, mew=0, zorder=4)


# ---- All contacts of a member ---------------------------------------------------------------------------------------


_MAX_MARKER_AREA = 60.0  # square points


def contacts_and_pressure_figure(
    picture: xarray.Dataset, *, direction: float = 0.0, hardness: float | None = None, title: str = ""
) -> Figure:
    """Draw a figure 80 mm wide: all contacts on a map of the lower body, and pressures in the largest contact.

    `picture` comes from `contact_picture`, and `direction` is the direction of motion of the upper body (degrees from
    +x towards +y). The hardness (GPa) is marked on the colour bar of the pressures.
    """
    force = picture["contact_force"].values
    has_pressure = "zoom_pressure" in picture and bool((picture["zoom_pressure"].values > 0).any())
    figure = new_figure(144 if has_pressure else 86)
    panels = figure.subplots(2 if has_pressure else 1, 1, squeeze=False)[:, 0]
    axes = panels[0]
    draw_height_map(figure, axes, picture["lower_height"].values, picture_extent(picture, "height"))
    is_opposing = find_opposing_contacts(picture, direction)
    x, y = picture["contact_x"].values, picture["contact_y"].values
    marker_areas = np.maximum(_MAX_MARKER_AREA * force / force.max(initial=1e-300), 3.0)
    for mask, colour, marker, caption in (
        (is_opposing, OPPOSING_CONTACT_COLOUR, "D", "oppose the motion"),
        (~is_opposing, NOT_OPPOSING_CONTACT_COLOUR, "o", "do not"),
    ):
        load_percent = 100 * force[mask].sum() / (force.sum() or 1.0)
        text = f"{int(mask.sum())} {caption}, with {load_percent:.0f} % of the load"
        marker_style: dict[str, Any] = {"facecolors": "none", "marker": marker}
        axes.scatter(x[mask], y[mask], s=marker_areas[mask], edgecolors="white", linewidths=2.0, **marker_style)
        axes.scatter(
            x[mask], y[mask], s=marker_areas[mask], edgecolors=colour, linewidths=1.2, label=text, **marker_style
        )
    displacement = [float(picture.attrs[name]) for name in ("x", "y")]
    displacement_texts = [f"{item:.3g} µm".replace("-", "\N{MINUS SIGN}") for item in displacement]
    displacement_caption = (
        ""
        if np.isnan(displacement).any()
        else f"upper body moved by {displacement_texts[0]} and {displacement_texts[1]}"
    )
    caption = f"{_count_text(force.size)} at {format_with_unit(float(picture.attrs['load_mN']), 'mN')}"
    axes.set_title("\n".join(filter(None, (title, caption, displacement_caption))), loc="left", fontsize=6, pad=3)
    add_scale_bar(axes, picture_extent(picture, "height"), fontsize=6)
    if has_pressure:
        _draw_pressure_panel(figure, panels[1], picture, hardness)
        draw_zoom_border(axes, picture_extent(picture, "zoom"))
    figure.legend(
        *axes.get_legend_handles_labels(),
        loc="outside lower center",
        title=f"motion along {direction_text(direction)}; marker size: load, not area",
    )
    return figure


def draw_height_map(figure: Figure, axes: Axes, heights: Floats, box: tuple[float, float, float, float]) -> None:
    """Draw the heights of the lower body in grey, with a colour bar.

    `box` contains the edges of the image (µm).
    """
    in_nanometres = np.ptp(heights) < _MAX_HEIGHT_RANGE_IN_NANOMETRES
    scaled_heights = heights * (1000 if in_nanometres else 1)
    lowest_height, highest_height = np.quantile(scaled_heights, [0.01, 0.99])
    image = axes.imshow(
        scaled_heights, extent=box, origin="lower", cmap="gray", vmin=lowest_height, vmax=highest_height
    )
    colour_bar = figure.colorbar(image, ax=axes, extend="both", shrink=0.8)
    colour_bar.set_label("lower body, " + axis_label("height_nm" if in_nanometres else "height"))
    label_map_axes(axes, box)


def label_map_axes(axes: Axes, box: tuple[float, float, float, float]) -> None:
    """Label the axes of a map in µm, or in mm for large maps.

    `box` contains the edges of the image (µm).
    """
    left, right, bottom, top = box
    in_millimetres = max(right - left, top - bottom) >= MIN_LENGTH_IN_MILLIMETRES
    for axis, name in ((axes.xaxis, "x"), (axes.yaxis, "y")):
        axis.set_label_text(f"${name}$ (mm)" if in_millimetres else axis_label(name))
        if in_millimetres:
            axis.set_major_formatter(lambda length, _: f"{length / 1000:g}".replace("-", "\N{MINUS SIGN}"))


def draw_zoom_border(axes: Axes, box: tuple[float, float, float, float]) -> None:
    """Draw a frame that is visible both on light and on dark colours of a map."""
    left, right, bottom, top = box
    for colour, width in (("white", 1.6), ("black", 0.6)):
        axes.plot([left, right, right, left, left], [bottom, bottom, top, top, bottom], color=colour, linewidth=width)


def picture_extent(picture: xarray.Dataset, name: str) -> tuple[float, float, float, float]:
    """Return the edges (left, right, bottom, top; µm) of a map's image, computed from the positions of its points."""
    y, x = (picture[f"{name}_{axis}"].values for axis in "yx")
    return map_extent((y.size, x.size), (float(y[1] - y[0]), float(x[1] - x[0])), (float(y[0]), float(x[0])))


def _draw_pressure_panel(figure: Figure, axes: Axes, picture: xarray.Dataset, hardness: float | None) -> None:
    pressure = picture["zoom_pressure"].values
    box = picture_extent(picture, "zoom")
    axes.imshow(picture["zoom_height"].values, extent=box, origin="lower", cmap="gray", alpha=0.6)
    image = axes.imshow(
        np.where(pressure > 0, pressure, np.nan), extent=box, origin="lower", cmap=PRESSURE_COLOUR_MAP, vmin=0,
        vmax=hardness if hardness is not None and float(np.nanmax(pressure)) >= 0.99 * hardness else None,
    )  # fmt: skip
    colour_bar = figure.colorbar(image, ax=axes, shrink=0.8)
    colour_bar.set_label(axis_label("pressure"))
    if hardness is not None and image.get_clim()[1] >= 0.99 * hardness:
        colour_bar.ax.axhline(hardness, color="black", linewidth=1)
        colour_bar.ax.text(
            0.5, 1.02, "hardness", transform=colour_bar.ax.transAxes, fontsize=6, ha="center", va="bottom"
        )
    is_at_edge = picture["contact_at_edge"].values[picture["contact_force"].values.argmax()] > 0
    title = "around the contact with the largest load (frame above)"
    title += "\nthe edge of the pressed area cuts this contact" if is_at_edge else ""
    axes.set_title(title, loc="left", fontsize=6, pad=3)
    label_map_axes(axes, box)


# ---- Contacts --------------------------------------------------------------------------------------------------------


def contact_map_figure(picture: xarray.Dataset, *, direction: float = 0.0) -> Figure:
    """Draw a figure 80 mm wide: contacts of two maps or profiles; colours show which contacts oppose the motion.

    Three colours mark contacts that oppose the motion, contacts that assist it, and contacts cut by an edge.
    `picture` comes from `contact_picture`, and `direction` is the direction of motion of the upper body (degrees).
    """
    is_opposing, is_cut = find_opposing_contacts(picture, direction), picture["contact_at_edge"].values > 0
    colours_and_labels = [
        (OPPOSING_CONTACT_COLOUR, "opposes motion"),
        (NOT_OPPOSING_CONTACT_COLOUR, "assists motion"),
    ] + [(EDGE_CONTACT_COLOUR, "cut by the edge")] * bool(is_cut.any())
    if "gap" in picture:
        figure = new_figure(70, layout=ColumnLayout(legend_at="top"))
        _draw_profile_contacts(
            figure.subplots(2, 1, height_ratios=[1, 2.5]),
            picture,
            np.where(is_opposing, OPPOSING_CONTACT_COLOUR, NOT_OPPOSING_CONTACT_COLOUR),
            is_cut,
        )
    else:
        figure = new_figure(80, layout=ColumnLayout(legend_at="top"))
        _draw_contact_map(figure.subplots(), picture, is_opposing, is_cut)
    figure.legend(
        handles=[Patch(color=colour, label=description) for colour, description in colours_and_labels],
        loc="outside upper left",
        ncols=3,
    )
    return figure


def _draw_contact_map(
    axes: Axes, picture: xarray.Dataset, is_opposing: NDArray[np.bool_], is_cut: NDArray[np.bool_]
) -> None:
    heights, contact_indices = (
        picture[name].transpose("height_y", "height_x").values for name in ("lower_height", "patch")
    )
    image_options: dict[str, Any] = {"extent": picture_extent(picture, "height"), "origin": "lower"}
    axes.imshow(heights, cmap=HEIGHT_COLOUR_MAP, **image_options)
    contact_kinds = np.append(np.nan, is_opposing)[contact_indices]
    axes.imshow(
        contact_kinds,
        cmap=ListedColormap([NOT_OPPOSING_CONTACT_COLOUR, OPPOSING_CONTACT_COLOUR]),
        vmin=0,
        vmax=1,
        interpolation="nearest",
        **image_options,
    )
    if (has_outline := np.append(False, is_cut)[contact_indices]).any():
        axes.contour(has_outline, levels=[0.5], colors=EDGE_CONTACT_COLOUR, linewidths=1.2, **image_options)
    label_map_axes(axes, image_options["extent"])


def _draw_profile_contacts(
    panels: Any, picture: xarray.Dataset, colours: NDArray[Any], is_cut: NDArray[np.bool_]
) -> None:
    """Draw the full length of two profiles, and enlarge the part around the contact that carries most load."""
    x, lower, gap = (picture[name].values for name in ("height_x", "lower_height", "gap"))
    is_finite = np.isfinite(gap)
    bodies = np.array([lower + np.interp(x, x[is_finite], gap[is_finite]).clip(0), lower]) * 1000
    # Profiles are assumed to be 1 µm wide, so a contact area in µm² equals the contact width in µm.
    centre_positions, width = picture["contact_x"].values, picture["contact_patch_area"].values
    zoom_slice = slice(
        *np.searchsorted(x, _choose_zoom_range(x, centre_positions, width, picture["contact_force"].values))
    )
    for axes, point_slice in zip(panels, (slice(None), zoom_slice), strict=True):
        draw_bodies(axes, x[point_slice], *bodies[:, point_slice])
        axes.set(xlim=x[point_slice][[0, -1]], ylabel=axis_label("height_nm"))
    panels[0].scatter(
        centre_positions,
        np.interp(centre_positions, x, bodies[1]),
        s=4,
        c=np.where(is_cut, EDGE_CONTACT_COLOUR, colours),
        zorder=3,
    )
    panels[0].axvspan(*x[zoom_slice][[0, -1]], color="0.5", alpha=0.25, linewidth=0)
    lowest_height, highest_height = bodies[1, zoom_slice].min(), bodies[1, zoom_slice].max()
    height_range = (highest_height - lowest_height) or 1.0
    top = min(highest_height + 0.6 * height_range, panels[1].get_ylim()[1])
    panels[1].set(ylim=(lowest_height - 0.1 * height_range, top), xlabel=f"{axis_label('x')}, magnified")
    for centre, half_width, colour, has_edge in zip(centre_positions, width / 2, colours, is_cut, strict=True):
        positions = np.linspace(centre - half_width, centre + half_width, 20)
        heights = np.interp(positions, x, bodies[1])
        for line_colour, line_width in [(EDGE_CONTACT_COLOUR, 4.5)] * bool(has_edge) + [(colour, 2.5)]:
            panels[1].plot(positions, heights, color=line_colour, linewidth=line_width, solid_capstyle="round")


def _choose_zoom_range(x: Floats, centre_positions: Floats, width: Floats, force: Floats) -> tuple[float, float]:
    """Return both ends of the enlarged part of a profile, around the contact that carries most load."""
    zoom_centre = centre_positions[np.argmax(force)]
    distances = np.sort(np.abs(centre_positions - zoom_centre))
    min_half_width = max(_MIN_HALF_WIDTH_OF_PROFILE_MAGNIFIER * (x[1] - x[0]), 4 * float(width.max()))
    half_width = float(
        np.clip(1.3 * distances[min(NUM_NEIGHBOURING_CONTACTS, distances.size - 1)], min_half_width, x[-1] / 7)
    )
    start = float(np.clip(zoom_centre - half_width, 0, max(x[-1] - 2 * half_width, 0)))
    return start, start + 2 * half_width
