"""Draw docs/images/decision.png and decision_dark.png: the contact model and options for each kind of data."""

from pathlib import Path

import matplotlib as mpl
from matplotlib.figure import Figure
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch
from stiction.views.style import INCHES_PER_MILLIMETRE, MATPLOTLIB_STYLE

IMAGE_DIRECTORY = Path(__file__).resolve().parents[1] / "images"
FIGURE_WIDTH, FIGURE_HEIGHT = 170.0, 84.0  # mm
BOX_HEIGHT = 12.0  # mm
LIGHT_COLOURS = {"text": "0.1", "line": "0.35", "question": "#e8eef5", "answer": "#dcefe6"}
DARK_COLOURS = {"text": "0.92", "line": "0.7", "question": "#26323f", "answer": "#1f3a30"}

# Centre x, centre y and width in mm, text and kind of each box, by name.
FLOWCHART_BOXES = {
    "data": (85, 76, 54, "What was measured?", "question"),
    "maps": (22, 55, 38, "two height maps", "question"),
    "profiles": (82, 55, 42, "two profiles", "question"),
    "other": (142, 55, 48, "one map and one profile", "question"),
    "areas": (22, 12, 38, "height maps,\nhalf-space (default)", "answer"),
    "lay": (82, 34, 42, "Is there a lay across\nthe profiles?", "question"),
    "grooves": (62, 12, 36, "--lay grooves:\nprofiles across the lay", "answer"),
    "isotropic": (101, 12, 36, "--lay isotropic:\nrandom height maps", "answer"),
    "lines": (142, 12, 40, "lines of the map,\n128 pairs", "answer"),
}
FLOWCHART_ARROWS = [
    ("data", "maps", ""),
    ("data", "profiles", ""),
    ("data", "other", ""),
    ("maps", "areas", ""),
    ("profiles", "lay", ""),
    ("lay", "grooves", "yes"),
    ("lay", "isotropic", "no"),
    ("other", "lines", ""),
]


def draw_figure(dark: bool) -> Figure:
    """Return the decision tree, for a light or a dark page."""
    colours = DARK_COLOURS if dark else LIGHT_COLOURS
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = Figure(figsize=(FIGURE_WIDTH * INCHES_PER_MILLIMETRE, FIGURE_HEIGHT * INCHES_PER_MILLIMETRE))
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=(0, FIGURE_WIDTH), ylim=(0, FIGURE_HEIGHT))
        ax.axis("off")
        for start, end, text in FLOWCHART_ARROWS:
            x0, y0, *_ = FLOWCHART_BOXES[start]
            x1, y1, *_ = FLOWCHART_BOXES[end]
            arrow_start, arrow_end = (x0, y0 - BOX_HEIGHT / 2), (x1, y1 + BOX_HEIGHT / 2)
            ax.add_patch(
                FancyArrowPatch(
                    arrow_start, arrow_end, arrowstyle="-|>", mutation_scale=8, color=colours["line"], linewidth=0.8
                )
            )
            if text:
                label_offset = -3.0 if x1 < x0 else 3.0
                ax.text(
                    (x0 + x1) / 2 + label_offset,
                    (arrow_start[1] + arrow_end[1]) / 2,
                    text,
                    ha="center",
                    color=colours["text"],
                )
        for x, y, width, text, box_kind in FLOWCHART_BOXES.values():
            corner = (x - width / 2, y - BOX_HEIGHT / 2)
            style = {"facecolor": colours[box_kind], "edgecolor": colours["line"], "linewidth": 0.6}
            box = FancyBboxPatch(corner, width, BOX_HEIGHT, boxstyle="round,pad=0,rounding_size=2", **style)
            ax.add_patch(box)
            ax.text(x, y, text, ha="center", va="center", color=colours["text"], fontsize=7.5)
    return figure


if __name__ == "__main__":
    for name, dark in (("decision", False), ("decision_dark", True)):
        draw_figure(dark).savefig(IMAGE_DIRECTORY / f"{name}.png", dpi=200, facecolor="none" if dark else "white")
