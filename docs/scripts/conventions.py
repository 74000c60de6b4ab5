"""Draw the terms and the signs that the conventions define, and write images/conventions.png and
conventions_contact.png.

The library computes bodies, contacts, normals, spheres and forces of one small pair. Only the positions of labels are
chosen by hand.
"""

from dataclasses import dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, Rectangle
from stiction import Contacts, Profile, asperities, contacts, random_phases, weierstrass_mandelbrot
from stiction.views.style import INCHES_PER_MILLIMETRE, MATPLOTLIB_STYLE

IMAGES_DIRECTORY = Path(__file__).parents[1] / "images"

APPROACH = 0.15  # µm
MU0 = 0.4
ENLARGED_CONTACT_INDEX = 1
"""Index of the contact that is drawn enlarged."""

LOWER_BODY_COLOUR, UPPER_BODY_COLOUR, OVERLAP_COLOUR, INK_COLOUR = "#e3d5bb", "#c6d9e7", "#8a7f95", "0.15"
OPPOSING_CONTACT_COLOUR, ASSISTING_CONTACT_COLOUR = "#B84C00", "#0072B2"


@dataclass(frozen=True)
class ContactingProfiles:
    """Two profiles at an approach, with their contacts."""

    lower: Profile
    upper: Profile
    contact_list: Contacts

    @property
    def first_contact_displacement(self) -> float:
        """Displacement (µm) of the upper profile at which grid points first touch."""
        return float((self.upper.heights - self.lower.heights).min())

    @property
    def upper_displacement(self) -> float:
        """Displacement (µm) of the upper profile at the approach of the drawing."""
        return self.first_contact_displacement + APPROACH


def project_to_plane(vectors: np.ndarray) -> np.ndarray:
    """Return the x and z components of vectors (x, y, z)."""
    return vectors[:, ::2]


def create_pair() -> ContactingProfiles:
    """Return two profiles that touch both on flanks with positive slope and on flanks with negative slope."""
    lower, upper = (
        weierstrass_mandelbrot(
            random_phases(2096, side=side, directions=5, frequencies=3), 1.3, length_scale=4.0, extent=9.0, points=900
        ).with_amplitude(1.3)
        for side in ("lower", "upper")
    )
    return ContactingProfiles(lower, upper, contacts(upper, lower, APPROACH, shear="+x"))


def draw_arrow(
    ax: Axes, start: np.ndarray, end: np.ndarray, colour: str = INK_COLOUR, *, style: str = "-|>", width: float = 0.9
) -> None:
    ax.annotate(
        "", end, start, annotation_clip=False,
        arrowprops={"arrowstyle": style, "color": colour, "linewidth": width, "shrinkA": 0, "shrinkB": 0,
                    "mutation_scale": 6},
    )  # fmt: skip


def draw_label(
    ax: Axes, place: np.ndarray, text: str, right: float = 0.0, up: float = 0.0, **text_options: object
) -> None:
    ax.text(place[0] + right, place[1] + up, text, **({"ha": "center", "va": "center"} | text_options))


def draw_bodies(ax: Axes, profiles: ContactingProfiles, bottom: float, top: float) -> None:
    x, lower, upper = profiles.lower.x, profiles.lower.heights, profiles.upper.heights - profiles.upper_displacement
    ax.fill_between(x, bottom, lower, color=LOWER_BODY_COLOUR, linewidth=0)
    ax.fill_between(x, upper, top, color=UPPER_BODY_COLOUR, linewidth=0)
    ax.fill_between(x, upper, lower, where=upper < lower, color=OVERLAP_COLOUR, linewidth=0)
    for heights in (lower, upper):
        ax.plot(x, heights, color=INK_COLOUR, linewidth=0.6)
    ax.set_aspect("equal")
    ax.set_ylim(bottom, top)
    ax.set_axis_off()


def draw_pair(ax: Axes, profiles: ContactingProfiles) -> None:
    x, lower, result = profiles.lower.x, profiles.lower.heights, profiles.contact_list
    touching_heights = profiles.upper.heights - profiles.first_contact_displacement
    bottom, top = lower.min() - 0.4, touching_heights.max() + 0.45
    draw_bodies(ax, profiles, bottom, top)
    ax.set_xlim(-0.95, x[-1] + 0.05)
    ax.plot(x, touching_heights, color=INK_COLOUR, linewidth=0.5, linestyle=(0, (4, 3)))
    vectors = (project_to_plane(item) for item in (result.centre, result.normal, result.tangent))
    for number, (centre, normal, tangent) in enumerate(zip(*vectors, strict=True)):
        colour, contact_kind = (
            (OPPOSING_CONTACT_COLOUR, "opposes")
            if result.opposing[number]
            else (ASSISTING_CONTACT_COLOUR, "does not oppose")
        )
        draw_arrow(ax, centre, centre + 0.6 * normal, colour, width=1.2)
        draw_label(ax, centre + 0.6 * normal, "n", 0.06, color=colour, weight="bold", ha="left", va="bottom")
        if result.opposing[number]:
            draw_arrow(ax, centre, centre + 0.45 * tangent, colour, width=1.2)
            draw_label(ax, centre + 0.53 * tangent, "t", color=colour, weight="bold")
        ax.plot(*centre, "o", color=colour, markersize=2.5)
        draw_label(
            ax, centre, f"{number + 1}: {contact_kind}", 0.1 if result.opposing[number] else -0.1, -0.42, color=colour
        )

    draw_label(ax, np.array([0.15, bottom + 0.1]), "lower body: solid below its profile", ha="left", va="bottom")
    draw_label(ax, np.array([0.15, top - 0.1]), "upper body: solid above its profile", ha="left", va="top")
    draw_arrow(ax, np.array([4.2, top - 0.19]), np.array([5.1, top - 0.19]), width=1.2)
    draw_label(
        ax, np.array([5.2, top - 0.19]), r'is about to move along $\sigma x$, $\sigma = +1$ (shear="+x")', ha="left"
    )

    j = round(3.7 / profiles.lower.spacing)
    draw_arrow(ax, np.array([x[j], lower[j]]), np.array([x[j], touching_heights[j]]), style="<|-|>")
    draw_label(ax, np.array([x[j] + 0.08, lower[j] + 0.3]), "gap", ha="left")
    j = round(8.3 / profiles.lower.spacing)
    draw_arrow(ax, np.array([x[j], touching_heights[j]]), np.array([x[j], touching_heights[j] - APPROACH]))
    draw_label(ax, np.array([x[j], touching_heights[j] - APPROACH - 0.15]), r"approach $\delta$")
    draw_label(ax, np.array([1.15, touching_heights[115] + 0.12]), "at first contact", va="bottom")

    corner = np.array([-0.6, bottom + 0.12])
    draw_arrow(ax, corner, corner + np.array([0.5, 0.0]))
    draw_arrow(ax, corner, corner + np.array([0.0, 0.5]))
    draw_label(ax, corner, "$x$", 0.25, -0.1)
    draw_label(ax, corner, "heights", 0.0, 0.6)


def draw_contact(ax: Axes, profiles: ContactingProfiles) -> None:
    """Draw one contact enlarged, with the spheres that replace both surfaces."""
    result = profiles.contact_list
    centre, normal, tangent = (
        project_to_plane(item)[ENLARGED_CONTACT_INDEX] for item in (result.centre, result.normal, result.tangent)
    )
    draw_bodies(ax, profiles, centre[1] - 1.05, centre[1] + 0.9)
    ax.set_xlim(centre[0] - 1.3, centre[0] + 1.3)
    for body, side, upper_displacement, along in (
        (profiles.lower, "lower", 0.0, np.array([-0.8, 0.6])),
        (profiles.upper, "upper", profiles.upper_displacement, np.array([1.0, 0.0])),
    ):
        spheres = asperities(body, side)
        sphere_centre, radius = (
            project_to_plane(spheres.centre)[result.index[ENLARGED_CONTACT_INDEX]] - [0.0, upper_displacement],
            spheres.radius[result.index[ENLARGED_CONTACT_INDEX]],
        )
        circle = Circle(sphere_centre, radius, fill=False, linewidth=0.6, linestyle="--", edgecolor=INK_COLOUR)
        circle.set_clip_path(ax.add_patch(Rectangle((centre[0] - 1.3, centre[1] - 1.05), 2.6, 1.95, fill=False, lw=0)))
        ax.add_patch(circle)
        ax.plot(*sphere_centre, "o", color=INK_COLOUR, markersize=2)
        draw_label(ax, sphere_centre, f"$O_{side[0]}$", 0.0, 0.1)
        draw_arrow(ax, sphere_centre, sphere_centre + radius * along, width=0.6)
        draw_label(ax, sphere_centre + 0.6 * radius * along, f"$R_{side[0]}$", 0.04, 0.09)
    ax.plot(centre[0] + np.zeros(2), centre[1] + np.array([0.0, 0.5]), color=INK_COLOUR, linewidth=0.5, linestyle=":")
    draw_arrow(ax, centre, centre + 0.5 * normal, OPPOSING_CONTACT_COLOUR, width=1.2)
    draw_arrow(ax, centre, centre + 0.4 * tangent, OPPOSING_CONTACT_COLOUR, width=1.2)
    ax.plot(*centre, "o", color=OPPOSING_CONTACT_COLOUR, markersize=3)
    draw_label(ax, centre + 0.5 * normal, "n", -0.08, color=OPPOSING_CONTACT_COLOUR, weight="bold")
    draw_label(ax, centre + 0.47 * tangent, "t", color=OPPOSING_CONTACT_COLOUR, weight="bold")
    draw_label(ax, centre, "$c$", 0.05, -0.08, color=OPPOSING_CONTACT_COLOUR)
    draw_angle(ax, centre, 0.42, normal, np.array([0.0, 1.0]), r"$\theta$")


def draw_angle(ax: Axes, corner: np.ndarray, radius: float, left: np.ndarray, right: np.ndarray, name: str) -> None:
    start, end = (float(np.arctan2(item[1], item[0])) for item in (right, left))
    ax.add_patch(
        Arc(
            corner,
            2 * radius,
            2 * radius,
            theta1=np.degrees(start),
            theta2=np.degrees(end),
            color=INK_COLOUR,
            linewidth=0.6,
        )
    )
    middle_angle = (start + end) / 2
    draw_label(ax, corner + 1.13 * radius * np.array([np.cos(middle_angle), np.sin(middle_angle)]), name)


def draw_forces(ax: Axes, profiles: ContactingProfiles) -> None:
    """Draw the forces on the upper body at the enlarged contact, tip to tail, and the loads that balance them."""
    result = profiles.contact_list
    normal, tangent = (
        project_to_plane(result.normal)[ENLARGED_CONTACT_INDEX],
        project_to_plane(result.tangent)[ENLARGED_CONTACT_INDEX],
    )
    # Arrow lengths are divided by the normal force.
    start, normal_tip, end = np.zeros(2), normal, normal + MU0 * tangent
    arrow_foot = np.array([end[0], 0.0])
    draw_arrow(ax, start, normal_tip, OPPOSING_CONTACT_COLOUR, width=1.2)
    draw_arrow(ax, normal_tip, end, OPPOSING_CONTACT_COLOUR, width=1.2)
    draw_arrow(ax, end, arrow_foot, width=1.2)
    draw_arrow(ax, arrow_foot, start, width=1.2)
    ax.plot(*zip(start, end, strict=True), color=INK_COLOUR, linewidth=0.5, linestyle=":")
    ax.plot([0.0, 0.0], [0.0, 1.0], color=INK_COLOUR, linewidth=0.5, linestyle=":")
    draw_angle(ax, start, 0.7, normal, np.array([0.0, 1.0]), r"$\theta$")
    draw_angle(ax, start, 0.5, end, normal, "")
    draw_label(ax, 0.42 * end, r"$\arctan\,\mu_0$", -0.04, ha="right")
    draw_label(ax, 0.55 * normal_tip, r"$F\,\mathbf{n}$", 0.04, color=OPPOSING_CONTACT_COLOUR, ha="left")
    draw_label(
        ax, (normal_tip + end) / 2, r"$\mu_0 F\,\mathbf{t}$", 0.0, 0.04, color=OPPOSING_CONTACT_COLOUR, va="bottom"
    )
    draw_label(ax, (end + arrow_foot) / 2, "load $F_N$", -0.03, ha="right")
    draw_label(ax, (arrow_foot + start) / 2, "load $F_T$", 0.0, -0.03, va="top")
    ax.set_xlim(end[0] - 0.4, 0.2)
    ax.set_ylim(-0.12, normal_tip[1] + 0.12)
    ax.set_aspect("equal")
    ax.set_axis_off()


def draw_pair_figure() -> Figure:
    figure = Figure(figsize=(170 * INCHES_PER_MILLIMETRE, 54 * INCHES_PER_MILLIMETRE))
    draw_pair(figure.add_axes((0.0, 0.0, 1.0, 1.0)), create_pair())
    return figure


def draw_contact_figure() -> Figure:
    """Draw one contact with its circles, and the triangle of its forces."""
    profiles = create_pair()
    figure = Figure(figsize=(150 * INCHES_PER_MILLIMETRE, 58 * INCHES_PER_MILLIMETRE))
    for name, x in (("(a)", 0.005), ("(b)", 0.58)):
        figure.text(x, 0.93, name, weight="bold")
    draw_contact(figure.add_axes((0.04, 0.0, 0.52, 1.0)), profiles)
    draw_forces(figure.add_axes((0.61, 0.01, 0.38, 0.97)), profiles)
    return figure


DRAWING_FUNCTIONS = {"conventions.png": draw_pair_figure, "conventions_contact.png": draw_contact_figure}
"""Functions that draw the images, by file name."""


def save_figures(directory: Path) -> None:
    with mpl.rc_context(MATPLOTLIB_STYLE):
        for name, draw in DRAWING_FUNCTIONS.items():
            draw().savefig(directory / name, dpi=200)


if __name__ == "__main__":
    save_figures(IMAGES_DIRECTORY)
