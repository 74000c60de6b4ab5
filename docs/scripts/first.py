"""Draw docs/images/first.png and first_dark.png: two lapped surfaces of examples/scans, with contacts and friction.

The script takes half a minute on one core.
"""

import tempfile
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from stiction import flipped, half_space, levelled, pair, read_profile
from stiction.views.style import (
    INCHES_PER_MILLIMETRE,
    LOWER_BODY_COLOUR,
    MATPLOTLIB_STYLE,
    NOT_OPPOSING_CONTACT_COLOUR,
    OPPOSING_CONTACT_COLOUR,
    SLIDING_RULE_COLOURS,
    UPPER_BODY_COLOUR,
    axis_label,
    save_figure,
)

ROOT = Path(__file__).resolve().parents[2]
SCANS_DIRECTORY = ROOT / "examples/scans"
EXAMPLE_PAIR_OPTIONS = {
    "upper": "steel", "lower": "brass", "hardness": "120 HV ± 10 %", "lay": "grooves", "mu0": 0.2, "tau0": "50 MPa",
}  # fmt: skip
"""Options of `pair` in the example in README, except the load."""
CURVE_LOADS = np.geomspace(1.0, 100.0, 9)
DRAWN_PROFILE_HALF_WIDTH = 20.0
"""Half width (µm) of the profile in the left plot."""
MARKED_LOAD = 10.0
FIGURE_WIDTH, FIGURE_HEIGHT = 124.0, 56.0
"""Size of the figure in mm; the width is 470 px at 96 dots per inch."""
MAX_MARKER_DISTANCE_FROM_MIDDLE = 150.0
"""Largest distance (µm) of a marked contact from the middle of the profile."""
DARK_STYLE = {
    "text.color": "0.9",
    "axes.edgecolor": "0.6",
    "axes.labelcolor": "0.9",
    "xtick.color": "0.8",
    "ytick.color": "0.8",
}


def compute_friction():
    """Return the coefficient and the limits of its combined interval over the load, by sliding rule."""
    with tempfile.TemporaryDirectory() as directory:
        result = pair(
            SCANS_DIRECTORY / "lapped_upper.csv",
            SCANS_DIRECTORY / "lapped_lower.csv",
            load=CURVE_LOADS.tolist(),
            onset=0,
            directory=directory,
            **EXAMPLE_PAIR_OPTIONS,
        )
        quoted_points = result.summary().reported_points
        results_by_rule = [
            {item.rule: (item.value, item.lower, item.upper) for item in point.rules} for point in quoted_points
        ]
        return {rule: np.transpose([point[rule] for point in results_by_rule]) for rule in SLIDING_RULE_COLOURS}


def solve_contact():
    """Return the lower profile (x and heights), and the contact of one pair at the load MARKED_LOAD."""
    upper, lower = (
        levelled(read_profile(SCANS_DIRECTORY / f"lapped_{side}.csv"), "line") for side in ("upper", "lower")
    )
    curve = half_space(flipped(upper), lower, [MARKED_LOAD], effective_modulus=78.7, hardness=1.27, boundary="free")
    return lower.x, lower.heights, curve.contact(0)


def draw_figure(curves, dark):
    figure = Figure(
        figsize=(FIGURE_WIDTH * INCHES_PER_MILLIMETRE, FIGURE_HEIGHT * INCHES_PER_MILLIMETRE),
        facecolor="none" if dark else "white",
    )
    contact_axes = figure.add_axes((0.125, 0.2, 0.37, 0.66))
    friction_axes = figure.add_axes((0.62, 0.2, 0.36, 0.66))
    for ax in (contact_axes, friction_axes):
        ax.set_facecolor("none")

    x, lower_heights, contact = solve_contact()
    is_contact = contact.pressure > 0
    # Show the part of the profile that has most contact points of the rarer kind, opposing or not.
    candidates = x[is_contact & (np.abs(x - x.mean()) < MAX_MARKER_DISTANCE_FROM_MIDDLE)]
    counts_of_rarer_kind = [
        min(np.count_nonzero(is_near & contact.opposing), np.count_nonzero(is_near & ~contact.opposing))
        for is_near in (is_contact & (np.abs(x - middle) < DRAWN_PROFILE_HALF_WIDTH) for middle in candidates)
    ]
    middle_x = candidates[int(np.argmax(counts_of_rarer_kind))]
    contact_axes.fill_between(x, 1000 * lower_heights, -1e4, color=LOWER_BODY_COLOUR, linewidth=0)
    contact_axes.fill_between(
        x, 1000 * (lower_heights + contact.gap.clip(0)), 1e4, color=UPPER_BODY_COLOUR, linewidth=0
    )
    for is_of_kind, colour in (
        (contact.opposing, OPPOSING_CONTACT_COLOUR),
        (~contact.opposing, NOT_OPPOSING_CONTACT_COLOUR),
    ):
        selected_points = is_contact & is_of_kind
        contact_axes.plot(x[selected_points], 1000 * lower_heights[selected_points], "o", markersize=2.5, color=colour)
    is_shown = np.abs(x - middle_x) < DRAWN_PROFILE_HALF_WIDTH
    heights = 1000 * lower_heights[is_shown]
    contact_axes.set(
        xlim=(middle_x - DRAWN_PROFILE_HALF_WIDTH, middle_x + DRAWN_PROFILE_HALF_WIDTH),
        ylim=(heights.min() - 10, heights.max() + 130),
    )
    contact_axes.set(xlabel="x (µm)", ylabel="height (nm)", title="two lapped faces, and where they touch")

    for rule, text in (("all", "friction at all contacts"), ("opposing", "at opposing contacts only")):
        (coefficients, lower_limit, upper_limit), colour = (
            curves[rule],
            SLIDING_RULE_COLOURS[rule] if not dark or rule != "all" else "#a99cf0",
        )
        friction_axes.fill_between(CURVE_LOADS, lower_limit, upper_limit, color=colour, alpha=0.3, linewidth=0)
        friction_axes.semilogx(CURVE_LOADS, coefficients, color=colour)
        coefficient = float(np.interp(np.log(MARKED_LOAD), np.log(CURVE_LOADS), coefficients))
        friction_axes.plot(MARKED_LOAD, coefficient, "o", color=colour, markersize=4)
        friction_axes.annotate(
            f"{coefficient:.2f}",
            (MARKED_LOAD, coefficient),
            (0, 5),
            textcoords="offset points",
            ha="center",
            weight="bold",
            color=colour,
        )
        friction_axes.annotate(text, (CURVE_LOADS[0], coefficient), (2, -11), textcoords="offset points", color=colour)
    friction_axes.set(
        ylim=(0, 0.35),
        xlim=(CURVE_LOADS[0], CURVE_LOADS[-1]),
        xlabel=axis_label("load"),
        title="coefficient of static friction",
    )
    friction_axes.set(ylabel=axis_label("friction_coefficient"), xticks=[1, 10, 100], xticklabels=["1", "10", "100"])
    return figure


def main():
    curves = compute_friction()
    for dark, name in ((False, "first.png"), (True, "first_dark.png")):
        with mpl.rc_context(MATPLOTLIB_STYLE | {"font.size": 7.5} | (DARK_STYLE if dark else {})):
            save_figure(draw_figure(curves, dark), ROOT / "docs/images" / name)


if __name__ == "__main__":
    main()
