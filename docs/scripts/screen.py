"""Draw docs/images/screen.png and screen_dark.png: the output of the example in README, with numbered parts."""

import subprocess
import sys
import tempfile

import matplotlib as mpl
from first import EXAMPLE_PAIR_OPTIONS, ROOT, SCANS_DIRECTORY
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from stiction.views.style import INCHES_PER_MILLIMETRE, MATPLOTLIB_STYLE

COMMAND_OPTIONS = [
    text for name, value in (EXAMPLE_PAIR_OPTIONS | {"load": "50 MPa"}).items() for text in (f"--{name}", str(value))
]
NUM_COLUMNS = 80
LINE_HEIGHT, CHARACTER_WIDTH = 4.2, 1.98  # mm
IMAGE_MARGIN, LABEL_WIDTH, DISC_RADIUS = 3.0, 7.0, 1.75  # mm
FONT_SIZE = 9.3  # font size (points) at which a character of DejaVu Sans Mono is CHARACTER_WIDTH wide
LIGHT_COLOURS = {"paper": "#f6f7f9", "text": "0.12", "label": "#35618e", "number": "white", "band": "#e3ebf4"}
DARK_COLOURS = {"paper": "#171b21", "text": "0.9", "label": "#8db8e8", "number": "#171b21", "band": "#232d3a"}

LABELLED_LINE_PARTS = [
    "μ_s = ",
    "friction at opposing contacts only",
    "Roughness contributes",
    "Quote ",
    "  - both scans",
    "(slopes)",
    "Single test",
    "With H = ",
    "At 10 mN",
    "True area",
    "% of the contact slips",
    "wrote ",
]
"""Texts that identify the first line of each numbered part of the output."""


def run_readme_example() -> list[str]:
    """Return the lines that the example in README prints."""
    with tempfile.TemporaryDirectory() as directory:
        command = [
            sys.executable,
            "-m",
            "stiction",
            "pair",
            SCANS_DIRECTORY / "lapped_upper.csv",
            SCANS_DIRECTORY / "lapped_lower.csv",
        ]
        completed = subprocess.run(
            [*command, *COMMAND_OPTIONS],
            cwd=directory,
            capture_output=True,
            check=True,
            text=True,
            env={"COLUMNS": f"{NUM_COLUMNS}"},
        )
    return completed.stdout.rstrip().splitlines()


def find_part_starts(lines: list[str]) -> list[int]:
    """Return the index of the first line of each part. Raises a `ValueError` if a part is missing or misplaced."""
    indices = []
    for part in LABELLED_LINE_PARTS:
        matching_indices = [i for i, line in enumerate(lines) if part in line]
        if not matching_indices:
            raise ValueError(
                f"no line contains {part!r}: adapt LABELLED_LINE_PARTS, and the list in docs/howto/pair.md"
            )
        indices.append(matching_indices[0])
    if indices != sorted(set(indices)):
        raise ValueError("parts of the output are not in the order of LABELLED_LINE_PARTS")
    return indices


def draw_figure(lines: list[str], dark: bool) -> Figure:
    """Return a figure of the output, for a light or a dark page."""
    colours = DARK_COLOURS if dark else LIGHT_COLOURS
    start_lines = find_part_starts(lines)
    width = NUM_COLUMNS * CHARACTER_WIDTH + LABEL_WIDTH + 2 * IMAGE_MARGIN
    height = len(lines) * LINE_HEIGHT + 2 * IMAGE_MARGIN
    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = Figure(
            figsize=(width * INCHES_PER_MILLIMETRE, height * INCHES_PER_MILLIMETRE), facecolor=colours["paper"]
        )
        ax = figure.add_axes((0, 0, 1, 1))
        ax.set(xlim=(0, width), ylim=(height, 0), aspect="equal")
        ax.axis("off")
        end_lines = [*start_lines[1:], len(lines)]
        for number, (start, end) in enumerate(zip(start_lines, end_lines, strict=True), 1):
            while not lines[end - 1].strip():
                end -= 1
            if number % 2:
                ax.axhspan(
                    IMAGE_MARGIN + start * LINE_HEIGHT,
                    IMAGE_MARGIN + end * LINE_HEIGHT,
                    color=colours["band"],
                    linewidth=0,
                )
            y = IMAGE_MARGIN + (start + 0.5) * LINE_HEIGHT
            ax.add_patch(Circle((IMAGE_MARGIN + DISC_RADIUS, y), DISC_RADIUS, color=colours["label"], linewidth=0))
            ax.text(
                IMAGE_MARGIN + DISC_RADIUS,
                y + 0.1,
                f"{number}",
                ha="center",
                va="center_baseline",
                color=colours["number"],
                fontsize=6.5,
                weight="bold",
            )
        for i, line in enumerate(lines):
            ax.text(
                IMAGE_MARGIN + LABEL_WIDTH, IMAGE_MARGIN + (i + 0.5) * LINE_HEIGHT, line, va="center_baseline",
                color=colours["text"], family="DejaVu Sans Mono", fontsize=FONT_SIZE,
                weight="bold" if i == start_lines[0] else "normal",
            )  # fmt: skip
    return figure


if __name__ == "__main__":
    printed_lines = run_readme_example()
    for name, dark in (("screen", False), ("screen_dark", True)):
        draw_figure(printed_lines, dark).savefig(ROOT / f"docs/images/{name}.png", dpi=180)
