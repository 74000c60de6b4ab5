"""Draw the conventions of height maps in three dimensions, and write images/conventions_areas.png.

The library computes contacts, normals and tangents of one small pair. Only the positions of labels are chosen by hand.
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from stiction import contacts, self_affine_surface
from stiction.views.style import INCHES_PER_MILLIMETRE, MATPLOTLIB_STYLE

IMAGES_DIRECTORY = Path(__file__).parents[1] / "images"

DIRECTION = 30.0  # degrees from +x towards +y
APPROACH = 0.9  # µm
OPPOSING_CONTACT_COLOUR, ASSISTING_CONTACT_COLOUR, INK_COLOUR, BODY_COLOUR = "#d55e00", "#0072b2", "0.15", "#e3d5bb"


def create_pair():
    """Return two maps of 4 µm with small slopes, and the contacts between them."""
    lower, upper = (
        self_affine_surface(
            12, hurst_exponent=0.9, rms=0.15, shape=(48, 48), spacing=1 / 12, longest_wavelength=2.0,
            shortest_wavelength=0.8, side=side,
        )
        for side in ("lower", "upper")
    )  # fmt: skip
    return lower, contacts(upper, lower, APPROACH, effective_modulus=10.0, direction=DIRECTION)


def draw_arrow(axes, start, direction, colour, text, length=0.8, label_distance_ratio=1.15):
    """Draw an arrow from a point in a direction, with a label at the tip."""
    axes.quiver(*start, *(length * np.asarray(direction)), color=colour, linewidth=1.2, arrow_length_ratio=0.18)
    axes.text(
        *(start + label_distance_ratio * length * np.asarray(direction)), text, color=colour, ha="center", va="center"
    )


def hide_axes(axes, heights=1.0, zoom=1.0):
    """Set the proportions of three-dimensional axes, and hide their box."""
    axes.set_box_aspect((1, 1, heights), zoom=zoom)
    axes.set_axis_off()


def draw_overview(axes, lower, contact_list):
    """Draw the lower surface, its contacts with normals, the axes, and the direction of motion."""
    y, x = np.mgrid[: lower.heights.shape[0], : lower.heights.shape[1]] / 12
    axes.plot_surface(
        x, y, lower.heights, color=BODY_COLOUR, rstride=2, cstride=2, linewidth=0.15, edgecolor="0.7", zorder=0
    )
    for centre, normal, is_opposing in zip(
        contact_list.centre, contact_list.normal, contact_list.opposing, strict=True
    ):
        axes.quiver(
            *centre,
            *(0.9 * normal),
            color=OPPOSING_CONTACT_COLOUR if is_opposing else ASSISTING_CONTACT_COLOUR,
            linewidth=1.1,
            arrow_length_ratio=0.2,
        )
        axes.plot(
            *centre[:, None],
            "o",
            color=OPPOSING_CONTACT_COLOUR if is_opposing else ASSISTING_CONTACT_COLOUR,
            markersize=3,
        )
    corner = np.array([0.0, 0.0, lower.heights.min()])
    for vector, name in (((1, 0, 0), "x"), ((0, 1, 0), "y"), ((0, 0, 1), "z")):
        draw_arrow(
            axes, corner, vector, "0.2", f"${name}$", length=1.0, label_distance_ratio=1.4 if name == "y" else 1.15
        )
    phi = np.radians(DIRECTION)
    start = np.array([0.4, 0.4, 1.3])
    draw_arrow(axes, start, (np.cos(phi), np.sin(phi), 0), INK_COLOUR, r"$\mathbf{s}$", length=1.4)
    arc_angles = np.linspace(0, phi, 20)
    axes.plot(
        0.4 + 0.8 * np.cos(arc_angles),
        0.4 + 0.8 * np.sin(arc_angles),
        np.full(20, 1.3),
        color=INK_COLOUR,
        linewidth=0.6,
    )
    axes.plot([0.4, 1.5], [0.4, 0.4], [1.3, 1.3], color=INK_COLOUR, linewidth=0.5, linestyle=":")
    axes.text(1.45, 0.62, 1.3, r"$\varphi$", ha="center", va="center")
    axes.set(xlim=(0, 4), ylim=(0, 4), zlim=(-0.5, 1.2))
    axes.text2D(0.5, 0.86, "(a) the lower body and its contacts", transform=axes.transAxes, ha="center")
    hide_axes(axes, 0.45, zoom=0.97)
    axes.view_init(elev=28, azim=-62)


def draw_contact(axes, normal, tangent):
    """Draw an opposing contact with its tangent plane, and the directions of its forces."""
    phi = np.radians(DIRECTION)
    s = np.array([np.cos(phi), np.sin(phi), 0.0])
    side = np.cross(normal, tangent)
    u, v = np.meshgrid([-1, 1], [-1, 1])
    corners = 0.9 * (u[..., None] * tangent + v[..., None] * side)
    axes.plot_surface(*np.moveaxis(corners, -1, 0), color=BODY_COLOUR, alpha=0.55, linewidth=0)
    level_corners = 0.9 * (u[..., None] * s + v[..., None] * np.cross([0, 0, 1.0], s))
    axes.plot_wireframe(*np.moveaxis(level_corners, -1, 0), color="0.6", linewidth=0.5, linestyle=":")
    origin = np.zeros(3)
    draw_arrow(axes, origin, normal, OPPOSING_CONTACT_COLOUR, r"$\mathbf{n}$, along $F$", length=1.3)
    draw_arrow(
        axes,
        origin,
        tangent,
        OPPOSING_CONTACT_COLOUR,
        r"$\mathbf{t}$, along $\mu_0 F + \tau_0 A$",
        length=1.0,
        label_distance_ratio=1.55,
    )
    draw_arrow(axes, origin, s, INK_COLOUR, r"$\mathbf{s}$", length=1.2)
    axes.set(xlim=(-1, 1), ylim=(-1, 1), zlim=(-0.8, 1.2))
    axes.text2D(
        0.5, 0.93, r"(b) an opposing contact, $\mathbf{s}\cdot\mathbf{n} < 0$", transform=axes.transAxes, ha="center"
    )
    hide_axes(axes)
    axes.view_init(elev=14, azim=-75)


def save_figures(directory):
    """Draw the figure, and write it to a directory."""
    lower, contact_list = create_pair()
    steepest_index = int(
        np.argmax(np.where(contact_list.opposing, np.hypot(contact_list.normal[:, 0], contact_list.normal[:, 1]), -1))
    )
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = Figure(figsize=(160 * INCHES_PER_MILLIMETRE, 74 * INCHES_PER_MILLIMETRE))
        draw_overview(
            figure.add_axes((-0.06, -0.12, 0.7, 1.16), projection="3d", computed_zorder=False), lower, contact_list
        )
        draw_contact(
            figure.add_axes((0.56, -0.08, 0.44, 1.08), projection="3d"),
            contact_list.normal[steepest_index],
            contact_list.tangent[steepest_index],
        )
        figure.savefig(directory / "conventions_areas.png", dpi=200)


if __name__ == "__main__":
    save_figures(IMAGES_DIRECTORY)
