"""Draw the terms and signs of the conventions: writes images/conventions.png.

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
from stiction.views.style import MATPLOTLIB_STYLE, MILLIMETRE

IMAGE = Path(__file__).parents[1] / "images/conventions.png"

APPROACH = 0.15
"""µm"""
MU0 = 0.4
ENLARGED = 1
"""Index of the enlarged contact."""

LOWER, UPPER, OVERLAP, INK = "#e3d5bb", "#c6d9e7", "#8a7f95", "0.15"
OPPOSING, OTHER = "#B84C00", "#0072B2"


@dataclass(frozen=True)
class ContactingProfiles:
    """Two profiles at an approach, and their contacts."""

    lower: Profile
    upper: Profile
    found: Contacts

    @property
    def first_contact(self) -> float:
        """Return the displacement of the upper profile until grid points touch, µm."""
        return float((self.upper.heights - self.lower.heights).min())

    @property
    def lowered(self) -> float:
        return self.first_contact + APPROACH


def plane(vectors: np.ndarray) -> np.ndarray:
    """Return the x and z components of vectors."""
    return vectors[:, ::2]


def pair() -> ContactingProfiles:
    """Return a pair with contacts on both kinds of flanks."""
    lower, upper = (
        weierstrass_mandelbrot(
            random_phases(2096, side=side, directions=5, frequencies=3), 1.3, length_scale=4.0, extent=9.0, points=900
        ).with_amplitude(1.3)
        for side in ("lower", "upper")
    )
    return ContactingProfiles(lower, upper, contacts(upper, lower, APPROACH, shear="+x"))


def arrow(
    ax: Axes, start: np.ndarray, end: np.ndarray, colour: str = INK, *, style: str = "-|>", width: float = 0.9
) -> None:
    ax.annotate(
        "", end, start, annotation_clip=False,
        arrowprops={"arrowstyle": style, "color": colour, "linewidth": width, "shrinkA": 0, "shrinkB": 0,
                    "mutation_scale": 6},
    )  # fmt: skip


def word(ax: Axes, place: np.ndarray, text: str, right: float = 0.0, up: float = 0.0, **how: object) -> None:
    ax.text(place[0] + right, place[1] + up, text, **({"ha": "center", "va": "center"} | how))


def draw_bodies(ax: Axes, these: ContactingProfiles, bottom: float, top: float) -> None:
    x, lower, upper = these.lower.x, these.lower.heights, these.upper.heights - these.lowered
    ax.fill_between(x, bottom, lower, color=LOWER, linewidth=0)
    ax.fill_between(x, upper, top, color=UPPER, linewidth=0)
    ax.fill_between(x, upper, lower, where=upper < lower, color=OVERLAP, linewidth=0)
    for heights in (lower, upper):
        ax.plot(x, heights, color=INK, linewidth=0.6)
    ax.set_aspect("equal")
    ax.set_ylim(bottom, top)
    ax.set_axis_off()


def draw_pair(ax: Axes, these: ContactingProfiles) -> None:
    x, lower, result = these.lower.x, these.lower.heights, these.found
    touching = these.upper.heights - these.first_contact
    bottom, top = lower.min() - 0.4, touching.max() + 0.45
    draw_bodies(ax, these, bottom, top)
    ax.set_xlim(-0.95, x[-1] + 0.05)
    ax.plot(x, touching, color=INK, linewidth=0.5, linestyle=(0, (4, 3)))
    vectors = (plane(item) for item in (result.centre, result.normal, result.tangent))
    for number, (centre, normal, tangent) in enumerate(zip(*vectors, strict=True)):
        colour, kind = (OPPOSING, "opposes") if result.opposing[number] else (OTHER, "does not oppose")
        arrow(ax, centre, centre + 0.6 * normal, colour, width=1.2)
        word(ax, centre + 0.6 * normal, "n", 0.06, color=colour, weight="bold", ha="left", va="bottom")
        if result.opposing[number]:
            arrow(ax, centre, centre + 0.45 * tangent, colour, width=1.2)
            word(ax, centre + 0.53 * tangent, "t", color=colour, weight="bold")
        ax.plot(*centre, "o", color=colour, markersize=2.5)
        word(ax, centre, f"{number + 1}: {kind}", 0.1 if result.opposing[number] else -0.1, -0.42, color=colour)

    word(ax, np.array([0.15, bottom + 0.1]), "lower body: solid below its profile", ha="left", va="bottom")
    word(ax, np.array([0.15, top - 0.1]), "upper body: solid above its profile", ha="left", va="top")
    arrow(ax, np.array([4.2, top - 0.19]), np.array([5.1, top - 0.19]), width=1.2)
    word(ax, np.array([5.2, top - 0.19]), r'is about to move along $\sigma x$, $\sigma = +1$ (shear="+x")', ha="left")

    j = round(3.7 / these.lower.spacing)
    arrow(ax, np.array([x[j], lower[j]]), np.array([x[j], touching[j]]), style="<|-|>")
    word(ax, np.array([x[j] + 0.08, lower[j] + 0.3]), "gap", ha="left")
    j = round(8.3 / these.lower.spacing)
    arrow(ax, np.array([x[j], touching[j]]), np.array([x[j], touching[j] - APPROACH]))
    word(ax, np.array([x[j], touching[j] - APPROACH - 0.15]), r"approach $\delta$")
    word(ax, np.array([1.15, touching[115] + 0.12]), "at first touch", va="bottom")

    corner = np.array([-0.6, bottom + 0.12])
    arrow(ax, corner, corner + np.array([0.5, 0.0]))
    arrow(ax, corner, corner + np.array([0.0, 0.5]))
    word(ax, corner, "$x$", 0.25, -0.1)
    word(ax, corner, "heights", 0.0, 0.6)


def draw_contact(ax: Axes, these: ContactingProfiles) -> None:
    """Draw the spheres of the enlarged contact."""
    result = these.found
    centre, normal, tangent = (plane(item)[ENLARGED] for item in (result.centre, result.normal, result.tangent))
    draw_bodies(ax, these, centre[1] - 1.05, centre[1] + 0.9)
    ax.set_xlim(centre[0] - 1.3, centre[0] + 1.3)
    for body, side, lowered, along in (
        (these.lower, "lower", 0.0, np.array([-0.8, 0.6])),
        (these.upper, "upper", these.lowered, np.array([1.0, 0.0])),
    ):
        spheres = asperities(body, side)
        middle, radius = (
            plane(spheres.centre)[result.index[ENLARGED]] - [0.0, lowered],
            spheres.radius[result.index[ENLARGED]],
        )
        circle = Circle(middle, radius, fill=False, linewidth=0.6, linestyle="--", edgecolor=INK)
        circle.set_clip_path(ax.add_patch(Rectangle((centre[0] - 1.3, centre[1] - 1.05), 2.6, 1.95, fill=False, lw=0)))
        ax.add_patch(circle)
        ax.plot(*middle, "o", color=INK, markersize=2)
        word(ax, middle, f"$O_{side[0]}$", 0.0, 0.1)
        arrow(ax, middle, middle + radius * along, width=0.6)
        word(ax, middle + 0.6 * radius * along, f"$R_{side[0]}$", 0.04, 0.09)
    ax.plot(centre[0] + np.zeros(2), centre[1] + np.array([0.0, 0.5]), color=INK, linewidth=0.5, linestyle=":")
    arrow(ax, centre, centre + 0.5 * normal, OPPOSING, width=1.2)
    arrow(ax, centre, centre + 0.4 * tangent, OPPOSING, width=1.2)
    ax.plot(*centre, "o", color=OPPOSING, markersize=3)
    word(ax, centre + 0.5 * normal, "n", -0.08, color=OPPOSING, weight="bold")
    word(ax, centre + 0.47 * tangent, "t", color=OPPOSING, weight="bold")
    word(ax, centre, "$c$", 0.05, -0.08, color=OPPOSING)
    draw_angle(ax, centre, 0.42, normal, np.array([0.0, 1.0]), r"$\theta$")


def draw_angle(ax: Axes, corner: np.ndarray, radius: float, left: np.ndarray, right: np.ndarray, name: str) -> None:
    start, end = (float(np.arctan2(item[1], item[0])) for item in (right, left))
    ax.add_patch(
        Arc(corner, 2 * radius, 2 * radius, theta1=np.degrees(start), theta2=np.degrees(end), color=INK, linewidth=0.6)
    )
    middle = (start + end) / 2
    word(ax, corner + 1.13 * radius * np.array([np.cos(middle), np.sin(middle)]), name)


def draw_forces(ax: Axes, these: ContactingProfiles) -> None:
    """Draw the forces on the upper body at the enlarged contact, tip to tail, and the loads that balance them."""
    result = these.found
    normal, tangent = plane(result.normal)[ENLARGED], plane(result.tangent)[ENLARGED]
    # In units of the normal force.
    start, middle, end = np.zeros(2), normal, normal + MU0 * tangent
    foot = np.array([end[0], 0.0])
    arrow(ax, start, middle, OPPOSING, width=1.2)
    arrow(ax, middle, end, OPPOSING, width=1.2)
    arrow(ax, end, foot, width=1.2)
    arrow(ax, foot, start, width=1.2)
    ax.plot(*zip(start, end, strict=True), color=INK, linewidth=0.5, linestyle=":")
    ax.plot([0.0, 0.0], [0.0, 1.0], color=INK, linewidth=0.5, linestyle=":")
    draw_angle(ax, start, 0.7, normal, np.array([0.0, 1.0]), r"$\theta$")
    draw_angle(ax, start, 0.5, end, normal, "")
    word(ax, 0.42 * end, r"$\arctan\,\mu_0$", -0.04, ha="right")
    word(ax, 0.55 * middle, r"$F\,\mathbf{n}$", 0.04, color=OPPOSING, ha="left")
    word(ax, (middle + end) / 2, r"$\mu_0 F\,\mathbf{t}$", 0.0, 0.04, color=OPPOSING, va="bottom")
    word(ax, (end + foot) / 2, "load $F_N$", -0.03, ha="right")
    word(ax, (foot + start) / 2, "load $F_T$", 0.0, -0.03, va="top")
    ax.set_xlim(end[0] - 0.4, 0.55)
    ax.set_ylim(-0.12, middle[1] + 0.12)
    ax.set_aspect("equal")
    ax.set_axis_off()


def drawing() -> Figure:
    these = pair()
    figure = Figure(figsize=(170 * MILLIMETRE, 122 * MILLIMETRE))
    for name, x, y in (("(a)", 0.005, 0.94), ("(b)", 0.005, 0.435), ("(c)", 0.54, 0.435)):
        figure.text(x, y, name, weight="bold")
    draw_pair(figure.add_axes((0.0, 0.5, 1.0, 0.5)), these)
    draw_contact(figure.add_axes((0.03, 0.0, 0.5, 0.47)), these)
    draw_forces(figure.add_axes((0.56, 0.01, 0.43, 0.45)), these)
    return figure


def save(path: Path) -> None:
    with mpl.rc_context(MATPLOTLIB_STYLE):
        drawing().savefig(path, dpi=200)


if __name__ == "__main__":
    save(IMAGE)
