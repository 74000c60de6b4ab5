"""Draw docs/images/sliding_rules.png and sliding_rules_dark.png: contacts with friction under each sliding rule."""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from stiction.views.style import (
    INCHES_PER_MILLIMETRE,
    LOWER_BODY_COLOUR,
    MATPLOTLIB_STYLE,
    NOT_OPPOSING_CONTACT_COLOUR,
    OPPOSING_CONTACT_COLOUR,
    UPPER_BODY_COLOUR,
)

IMAGE_DIRECTORY = Path(__file__).resolve().parents[1] / "images"
FIGURE_WIDTH, FIGURE_HEIGHT = 170.0, 44.0  # mm
ASPERITY_RADIUS = 1.0  # asperity radius, the unit of all lengths
UPPER_OFFSETS = np.array(
    [-0.5, 0.6, -0.6, 0.5]
)  # offsets of the upper asperities from the lower asperities, along the sliding direction
SPACING = 3.0  # distance between lower asperities
FLAT_HEIGHT = 0.45  # height of the flat between asperities above the centres of the asperities
ARROW_LENGTH = 1.15
NUM_POINTS = 1200
RULE_TITLES = {"all": "friction at all contacts", "opposing": "friction at opposing contacts only"}


def asperity_heights(x: np.ndarray, centres: np.ndarray) -> np.ndarray:
    """Return the heights at x of a row of circular asperities with the given centres."""
    heights = np.sqrt(np.clip(ASPERITY_RADIUS**2 - np.subtract.outer(x, centres) ** 2, 0.0, None))
    return np.maximum(heights.max(axis=1), FLAT_HEIGHT)


def draw_pair(ax: Axes, rule: str, text_colour: str) -> None:
    """Draw two rough surfaces, and the friction on the lower surface while the upper surface moves to the right."""
    lower_centres = SPACING * np.arange(len(UPPER_OFFSETS))
    upper_centres = lower_centres + UPPER_OFFSETS
    # Lower asperities with larger offsets are higher, so that every pair is in contact.
    centre_heights = np.sqrt((2 * ASPERITY_RADIUS) ** 2 - UPPER_OFFSETS**2)
    max_centre_height = centre_heights.max()
    x = np.linspace(-2.2, lower_centres[-1] + 2.2, NUM_POINTS)
    lower = np.full_like(x, FLAT_HEIGHT)
    for centre, height_difference in zip(lower_centres, max_centre_height - centre_heights, strict=True):
        lower = np.maximum(lower, asperity_heights(x, np.array([centre])) + height_difference)
    upper = max_centre_height - asperity_heights(x, upper_centres)
    ax.fill_between(x, lower, -0.6, color=LOWER_BODY_COLOUR, linewidth=0)
    ax.fill_between(x, upper, max_centre_height + 0.6, color=UPPER_BODY_COLOUR, linewidth=0)
    for centre, offset, height, height_difference in zip(
        lower_centres, UPPER_OFFSETS, centre_heights, max_centre_height - centre_heights, strict=True
    ):
        is_opposing = offset < 0  # the upper asperity is to the left: it must climb to move to the right
        colour = OPPOSING_CONTACT_COLOUR if is_opposing else NOT_OPPOSING_CONTACT_COLOUR
        point = np.array([centre + offset / 2, height_difference + height / 2])
        ax.plot(*point, "o", markersize=5, color=colour, zorder=4)
        if is_opposing or rule == "all":
            tangent = np.array([height, -offset]) / (2 * ASPERITY_RADIUS)
            ax.annotate(
                "",
                point - ARROW_LENGTH * tangent,
                point,
                zorder=5,
                arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.6, "shrinkA": 0, "shrinkB": 0},
            )
    middle_x = lower_centres.mean()
    ax.annotate(
        "", (middle_x + 2.2, max_centre_height + 1.1), (middle_x - 2.2, max_centre_height + 1.1),
        arrowprops={"arrowstyle": "-|>", "color": text_colour, "linewidth": 1.0},
    )  # fmt: skip
    ax.text(
        middle_x, max_centre_height + 1.3, "motion of the upper surface", ha="center", va="bottom", color=text_colour
    )
    ax.set(xlim=(x[0], x[-1]), ylim=(-0.7, max_centre_height + 1.9), aspect="equal")
    ax.set_title(RULE_TITLES[rule], color=text_colour)
    ax.axis("off")


def draw_figure(dark: bool) -> Figure:
    """Return the figure, in colours for a light or for a dark page."""
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = Figure(figsize=(FIGURE_WIDTH * INCHES_PER_MILLIMETRE, FIGURE_HEIGHT * INCHES_PER_MILLIMETRE))
        for i, rule in enumerate(RULE_TITLES):
            draw_pair(figure.add_axes((0.01 + 0.5 * i, 0.1, 0.48, 0.84)), rule, "0.92" if dark else "0.1")
        for x, colour, label in (
            (0.2, OPPOSING_CONTACT_COLOUR, "slope opposes the motion"),
            (0.58, NOT_OPPOSING_CONTACT_COLOUR, "slope assists the motion"),
        ):
            figure.text(x, 0.07, "●", color=colour, va="center")
            figure.text(x + 0.02, 0.07, label, color="0.92" if dark else "0.1", va="center")
    return figure


if __name__ == "__main__":
    for name, dark in (("sliding_rules", False), ("sliding_rules_dark", True)):
        draw_figure(dark).savefig(IMAGE_DIRECTORY / f"{name}.png", dpi=200, facecolor="none" if dark else "white")
