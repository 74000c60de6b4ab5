"""Draws docs/images/hero.png: Fig. 6 of the paper on lines and areas, and the one curve of gentle surfaces.

The results, a thousand pairs of lines and a hundred of areas at each fractal dimension, stay in build/hero; they take
about ten minutes on two cores.
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from stiction import Study, friction_map, gentle_friction, pair_of, run
from stiction.studies.at_load import reached_loads
from stiction.views.digits import with_unit
from stiction.views.figures import ensemble as figures
from stiction.views.style import FULL_WIDTH, MILLIMETRE, STYLE, label, save_picture

ROOT = Path(__file__).resolve().parents[2]
MU0, TAU0 = 0.4, ("0 MPa", "200 MPa")
LOADS = {"lines": 1e-4, "areas": 1.0}
LINES, AREAS = 1000, 100
GRADIENTS = 8
"""Pairs over which the mean slope is taken; it differs by some per cent between pairs."""
STEEPEST = 1.5
"""Fractal dimension of lines above which their slope is that of the grid's finest waves."""


def result(name, repetitions):
    study = Study.named(name).with_changes({"ensemble.repetitions": repetitions, "figures.draw": []})
    return study, run(study, store=ROOT / f"build/hero/{name}", progress=True)


def slopes_of_lines(study, dimensions):
    """Root-mean-square slope of the gap between lines, the mean of some pairs."""
    each = []
    for repetition in range(GRADIENTS):
        for dimension in dimensions:
            upper, lower = pair_of(study, repetition, fractal_dimension=dimension, amplitude=0.1)
            each.append(np.sqrt(np.mean(np.square(np.diff(upper.heights - lower.heights) / upper.spacing))))
    return np.reshape(each, (GRADIENTS, -1)).mean(axis=0)


def gradients_of_areas(study, dimensions):
    each = []
    for repetition in range(GRADIENTS):
        for dimension in dimensions:
            upper, lower = pair_of(study, repetition, fractal_dimension=dimension, amplitude=0.1)
            gap = upper.heights - lower.heights
            dy, dx = (np.diff(gap, axis=axis) / step for axis, step in enumerate(upper.spacing))
            each.append(np.sqrt(np.mean(np.square(dx)) + np.mean(np.square(dy))))
    return np.reshape(each, (GRADIENTS, -1)).mean(axis=0)


def draw(lines, areas):
    strengths = [0.0, 0.2]
    maps = friction_map(lines[1], reached_loads(lines[1]), mu0=[MU0], tau0=strengths).isel(mu0=0, amplitude=0)
    height, below, above = 42.0, 16.0, 15.0
    total = height + below + above
    figure = Figure(figsize=(FULL_WIDTH, total * MILLIMETRE))

    def axes_at(left, width):
        return figure.add_axes((left / 170, below / total, width / 170, height / total))

    norm = figures._norm(maps)
    for column, strength in enumerate(TAU0):
        ax = axes_at(13 + 33 * column, 30)
        figures._friction_panel(ax, maps.isel(tau0=column), norm, LOADS["lines"])
        ax.set_title(rf"lines, $\tau_0$ = {strength}", pad=2)
        figures._dimension_axis(ax, lines[1], last=True)
        if column == 0:
            ax.set_ylabel(label("load"))
        else:
            ax.yaxis.set_visible(False)
    figures._colour_bar(figure, (13 / 170, 1 - (above - 5.5) / total, 63 / 170, 2.2 / total), norm, MU0)

    for left, (name, (study, dataset)) in zip((91, 131), (("lines", lines), ("areas", areas)), strict=True):
        ax = axes_at(left, 36)
        load = LOADS[name]
        curves = friction_map(dataset, [load], mu0=[MU0], tau0=strengths).isel(mu0=0, amplitude=0, load=0)
        figures._friction_curves(ax, curves, list(TAU0), MU0)
        ax.set_ylim(0, 0.95)
        ax.set_title(f"{name}, $F_N$ = {with_unit(load, 'mN')}", pad=2)
        dimensions = dataset["fractal_dimension"].values[::4]
        if name == "lines":
            dimensions = dimensions[dimensions <= STEEPEST]
            h = slopes_of_lines(study, dimensions)
            gentle = [gentle_friction(MU0, 0.0, rms_gradient=h, rms_slope=h)]
            ax.set_ylabel(label("friction_coefficient"))
        else:
            h = gradients_of_areas(study, dimensions)
            gentle = [gentle_friction(MU0, tau0, rms_gradient=h) for tau0 in strengths]
            ax.tick_params(labelleft=False)
        print(name, np.round(dimensions, 2), np.round(h, 3), *(np.round(each, 3) for each in gentle))
        print(np.round(curves["friction_coefficient"].values[::4].T, 3))
        for each in gentle:
            ax.plot(dimensions, each, color="black", linewidth=0.8, dashes=(5, 2))
        figures._dimension_axis(ax, dataset, last=True)
    meanings = figures._meanings(maps, asperities=True)
    gentle_line = mpl.lines.Line2D([], [], color="black", linewidth=0.8, dashes=(5, 2))
    gentle_line.set_label("gentle slopes on an elastic half-space: one formula")
    meanings.append(gentle_line)
    figure.legend(handles=meanings, loc="lower center", ncols=2, handlelength=1.8, columnspacing=1.4, borderaxespad=0.2)
    return figure


def main():
    lines, areas = result("figure6", LINES), result("figure6-areal", AREAS)
    areas = areas[0], areas[1].sel(sliding="opposing")
    with mpl.rc_context(STYLE):
        save_picture(draw(lines, areas), ROOT / "docs/images/hero.png")


if __name__ == "__main__":
    main()
