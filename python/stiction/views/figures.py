"""The paper's figures from a result, for print: matplotlib, colour-blind-safe, units on every axis."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._core import __version__
from stiction._files import replaced_file
from stiction.mechanics.friction import STATUS_SELF_LOCKED
from stiction.studies.dataset import step_of
from stiction.studies.maps import area_map, friction_map
from stiction.studies.pairs import ProfileGenerator, pair_of
from stiction.studies.study import Study, study_of
from stiction.surfaces.fractal import weierstrass_mandelbrot_surface
from stiction.surfaces.profile import Profile

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MILLIMETRE = 1 / 25.4
WIDTH = 80 * MILLIMETRE
"""One column of print; nothing on a figure is smaller than 6 pt at this width."""

LOAD_STEPS = 80
MOST_CURVES = 8
SHARE_LIMIT = 0.5
"""Share of the load beyond Hertz, or on radii below the grid spacing, from which on a figure marks a value."""

COLOUR_QUANTILES = (0.01, 0.95)
"""Of the friction coefficients, those between which the colours run: a few high values would take them all."""

STYLE: dict[Any, Any] = {
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.labelsize": 7,
    "xtick.labelsize": 6,
    "ytick.labelsize": 6,
    "legend.fontsize": 6,
    "legend.title_fontsize": 6,
    "axes.linewidth": 0.5,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.minor.width": 0.3,
    "ytick.minor.width": 0.3,
    "legend.frameon": False,
    "figure.dpi": 300,
    "hatch.linewidth": 0.3,
}
_LOCKED_COLOUR = "#7a0019"


def save_figures(dataset: xarray.Dataset, directory: str | Path) -> list[Path]:
    """Draw the figures that a result's study asks for into a directory and return their paths.

    ``profiles.png``: profiles of several fractal dimensions. ``length_scales.png``: profiles and areal surfaces of
    three length scales. ``friction_mu0_*.png``: the friction coefficient over fractal dimension and load, a file for
    each mu0. ``area.png``: the true contact area against load. Of several sliding rules or directions each has files
    of its own, as in ``friction_mu0_0.4_all_90.png``.
    """
    import matplotlib as mpl

    directory = Path(directory)
    study = study_of(dataset)
    paths = []
    with mpl.rc_context(STYLE):
        for name in study.figures.draw:
            match name:
                case "profiles":
                    paths.append(_save(profiles_figure(study), directory / "profiles.png"))
                case "length-scales":
                    paths.append(_save(length_scales_figure(study), directory / "length_scales.png"))
                case "friction":
                    paths += [
                        _save(friction_figure(one, mu0), directory / f"friction_mu0_{mu0:.12g}{suffix}.png")
                        for suffix, one in _motions(dataset)
                        for mu0 in study.friction.mu0
                    ]
                case "area":
                    paths += [
                        _save(area_figure(one), directory / f"area{suffix}.png") for suffix, one in _motions(dataset)
                    ]
    return paths


def save_picture(figure: Figure, path: Path) -> None:
    """Write a figure as PNG, over no other picture than one of this package: instruments write PNGs beside their data.

    Raises
    ------
    ValueError
        If the name does not end in .png, another picture has it, or it cannot be written.
    """
    if path.suffix.lower() != ".png":
        raise ValueError(f"{path}: cannot be written: its name must end in .png")
    with replaced_file(path, _MADE_BY, ValueError) as partial, partial.open("wb") as file:
        figure.savefig(file, format="png", metadata={"Software": f"stiction {__version__}"})


_MADE_BY = b"Software\0stiction"
"""In the PNG."""


def _save(figure: Figure, path: Path) -> Path:
    save_picture(figure, path)
    return path


def _motions(dataset: xarray.Dataset) -> Iterator[tuple[str, xarray.Dataset]]:
    """The result of each sliding rule and direction, and what its files are called by."""
    dims = [dim for dim in ("sliding", "direction") if dim in dataset.dims]
    for place in np.ndindex(*(dataset.sizes[dim] for dim in dims)):
        one = dataset.isel(dict(zip(dims, place, strict=True)))
        names = [f"{one[dim].item():g}" if dim == "direction" else str(one[dim].item()) for dim in dims]
        yield "".join(f"_{name}" for name in names), one


def _title(figure: Figure, dataset: xarray.Dataset, study: Study) -> None:
    """Above a figure: how the bodies move, unless they are profiles as the paper has them; and what is missing."""
    contact = study.contact
    rule = dataset["sliding"].item() if "sliding" in dataset.coords else contact.rules()[0]
    angle = dataset["direction"].item() if "direction" in dataset.coords else float(contact.degrees()[0])
    lines = []
    if study.surfaces.kind == "surface" or contact.mechanics == "half-space" or rule != "opposing":
        mechanics = "half-space, " if contact.mechanics == "half-space" else ""
        lines.append(f"{mechanics}sliding: {rule}, along {_way(angle)}")
    done, total = dataset.sizes["repetition"], study.ensemble.repetitions
    if done < total:
        lines.append(f"unfinished: {done} of {total} repetitions")
    if lines:
        figure.suptitle("\n".join(lines), fontsize=8)


def _way(angle: float) -> str:
    return {0.0: "$+x$", 90.0: "$+y$", 180.0: "$-x$", 270.0: "$-y$"}.get(angle, f"{angle:g}° from $+x$")


def reached_loads(dataset: xarray.Dataset, steps: int = LOAD_STEPS) -> Floats:
    """Loads in equal ratios (mN), from what the lightest approach carries to the most that any ensemble reaches.

    The lower end is the largest of the ensembles' loads at the first approach (or load, by the half-space), so that
    none of them starts above it.
    """
    elastic = dataset["normal_elastic"].mean("repetition")
    highest = float(elastic.max())
    if not highest > 0:
        raise ValueError("no pair of this result touches within its approaches, so there is nothing to draw")
    lowest = float(elastic.isel({step_of(dataset): 0}).max())
    if not 1e-6 * highest < lowest < 0.5 * highest:
        lowest = 1e-6 * highest if lowest < highest / 2 else highest / 10
    return np.geomspace(lowest, highest, steps)


# ---- Surfaces --------------------------------------------------------------------------------------------------------


def profiles_figure(study: Study) -> Figure:
    """Profiles of several fractal dimensions, of the same phases: their whole length, and one length scale of it."""
    from matplotlib.figure import Figure

    dimensions = study.surfaces.fractal_dimensions()
    dimensions = dimensions[_some(dimensions.size, MOST_PROFILES)]
    amplitude = float(study.surfaces.amplitudes()[0])
    window = min(float(study.surfaces.length_scale), float(study.surfaces.extent))
    figure = Figure(figsize=(WIDTH, (12 + 13 * dimensions.size) * MILLIMETRE), layout="constrained")
    axes = figure.subplots(dimensions.size, 2, squeeze=False, sharex="col", sharey=True)
    for row, dimension in enumerate(dimensions):
        _, profile = pair_of(study, 0, fractal_dimension=dimension, amplitude=amplitude)
        for ax, end in zip(axes[row], (profile.extent, window), strict=True):
            shown = profile.x <= end
            ax.fill_between(profile.x[shown], profile.heights[shown], profile.heights.min(), color="0.85", linewidth=0)
            ax.plot(profile.x[shown], profile.heights[shown], color="C0", linewidth=0.4, rasterized=True)
            ax.set_xlim(0, end)
        axes[row, 0].set_title(f"$D$ = {dimension:.3g}", loc="left", pad=2)
    for ax in axes[-1]:
        ax.set_xlabel("$x$ (µm)")
    axes[dimensions.size // 2, 0].set_ylabel("height (µm)")
    return figure


def length_scales_figure(study: Study) -> Figure:
    """Eq. 1, unscaled, for three length scales and the same phases: profiles, and surfaces without aliases."""
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    dimension = study.surfaces.fractal_dimensions()[0]
    extent = float(study.surfaces.extent)
    pixels = int(min(AREAL_POINTS, study.surfaces.points))
    scales = [factor * float(study.surfaces.length_scale) for factor in LENGTH_SCALES]
    figure = Figure(figsize=(WIDTH, 66 * MILLIMETRE), layout="constrained")
    axes = figure.subplots(2, len(scales), height_ratios=[1, 1.2], sharex=True)
    for column, scale in enumerate(scales):
        generator = replace(ProfileGenerator.of(study), length_scale=scale)
        profile = Profile(generator.heights(dimension, 0, "lower"), spacing=generator.spacing)
        surface = weierstrass_mandelbrot_surface(
            generator.phases(0, "lower"), dimension, shape=(pixels, pixels), extent=extent, length_scale=scale,
            gamma=generator.gamma, convention=generator.convention, band_limit="nyquist",
        )  # fmt: skip
        top, bottom = axes[:, column]
        top.plot(profile.x, profile.heights - profile.heights.mean(), color="C0", linewidth=0.4, rasterized=True)
        top.set_title(f"$L$ = {scale:.3g} µm")
        top.set_xlim(0, extent)
        heights = surface.heights - surface.heights.mean()
        image = bottom.imshow(heights, extent=(0, extent, 0, extent), origin="lower", cmap="cividis")
        bar = figure.colorbar(image, ax=bottom, location="bottom", pad=0.02)
        bar.locator = MaxNLocator(3)
        bar.set_label("height (µm)")
        bottom.set_xlabel("$x$ (µm)")
        bottom.tick_params(axis="x", labelbottom=True)
        if column > 0:
            bottom.tick_params(labelleft=False)
    axes[0, 0].set_ylabel("height (µm)")
    axes[1, 0].set_ylabel("$y$ (µm)")
    return figure


LENGTH_SCALES = (0.5, 1.0, 2.0)
"""Of the study's own, in the figure of length scales."""

AREAL_POINTS = 400
"""Rows and columns of a surface in a figure."""

MOST_PROFILES = 5


def _some(count: int, most: int) -> NDArray[np.intp]:
    """At most so many indices out of `count`, evenly spread, both ends included."""
    return np.unique(np.linspace(0, count - 1, min(most, count)).round().astype(np.intp))


# ---- Friction coefficient over fractal dimension and load -----------------------------------------------------------


def friction_figure(dataset: xarray.Dataset, mu0: float) -> Figure:
    """Colour maps over fractal dimension and normal load for one mu0, all with the same colours.

    A panel for each tau0; with several amplitudes a row for each tau0 and a column for each amplitude.
    """
    from matplotlib.figure import Figure
    from matplotlib.ticker import MaxNLocator

    study = study_of(dataset)
    maps = friction_map(dataset, reached_loads(dataset), mu0=[mu0]).isel(mu0=0)
    strengths = study.friction.tau0
    amplitudes = [float(value) for value in dataset["amplitude"].values]
    panels = [
        (maps.isel(amplitude=a, tau0=t), rf"$\tau_0$ = {strength.text}")
        for t, strength in enumerate(strengths)
        for a in range(len(amplitudes))
    ]
    columns = len(amplitudes) if len(amplitudes) > 1 else min(2, len(panels))
    rows = -(-len(panels) // columns)
    figure = Figure(figsize=(WIDTH, (32 + (29 if columns < 3 else 22) * rows) * MILLIMETRE), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    norm = _norm(maps["friction_coefficient"].values)
    for ax in axes.flat[len(panels) :]:
        ax.set_axis_off()
    for ax, (panel, title) in zip(axes.flat, panels, strict=False):
        mesh = _friction_panel(ax, panel, norm)
        ax.set_title(title, pad=2)
    last = axes.flat[len(panels) - columns : len(panels)]
    for ax in last:
        ax.tick_params(labelbottom=True)
    for ax in last if columns < 3 else [last[columns // 2]]:
        ax.set_xlabel(_dimension_label(dataset))
    for ax in axes[:, 0]:
        ax.set_ylabel("$F_N$ (mN)")
    if columns > 2:
        axes[0, 0].xaxis.set_major_locator(MaxNLocator(2))
    if len(amplitudes) > 1:
        for column, amplitude in enumerate(amplitudes):
            axes[0, column].set_title(f"{1000 * amplitude:g} nm\n{panels[0][1]}", pad=2)
    bar = figure.colorbar(mesh, ax=axes, location="top", extend="both", aspect=35, pad=0.01)
    bar.set_label(rf"$\mu_s$ at $\mu_0$ = {mu0:g}")
    ticks = _ticks(norm)
    bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    bar.ax.minorticks_off()
    _title(figure, dataset, study)
    _friction_legend(
        figure,
        locked=bool((maps["status"] == STATUS_SELF_LOCKED).any()),
        asperities=study.contact.mechanics == "asperities",
    )
    return figure


def _ticks(norm: Any) -> list[float]:
    """Some of the round numbers on a scale of equal ratios, no closer than their labels are long."""
    inside = [tick for tick in TICKS if norm.vmin <= tick <= norm.vmax]
    return inside[:: max(1, -(-len(inside) // 8))]


TICKS = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 20, 30, 50, 100)
"""Round coefficients of friction on a scale of colours."""


def _norm(values: Floats) -> Any:
    """Colours in equal ratios; the highest few per cent share one, or friction at the highest D would take them all."""
    from matplotlib.colors import LogNorm

    positive = values[np.isfinite(values) & (values > 0)]
    low, high = np.quantile(positive, COLOUR_QUANTILES) if positive.size else (0.1, 1.0)
    return LogNorm(low, max(high, 1.05 * low))


def _friction_panel(axes: Axes, panel: xarray.Dataset, norm: Any) -> Any:
    from matplotlib.colors import ListedColormap

    panel = panel.transpose("load", "fractal_dimension")
    values, status = panel["friction_coefficient"].values, panel["status"].values
    edges = _edges(panel["fractal_dimension"].values), np.exp(_edges(np.log(panel["load"].values)))
    axes.set_yscale("log")
    axes.set_xlim(edges[0][0], edges[0][-1])
    axes.set_ylim(edges[1][0], edges[1][-1])
    axes.add_patch(_not_reached_patch((0, 0), 1, 1, transform=axes.transAxes))
    locked = np.ma.masked_where(status != STATUS_SELF_LOCKED, np.ones(status.shape))
    axes.pcolormesh(*edges, locked, cmap=ListedColormap([_LOCKED_COLOUR]), rasterized=True)
    # A coefficient of 0 has no logarithm, and is drawn as the lowest colour is.
    shown = np.ma.masked_invalid(np.maximum(values, norm.vmin))
    mesh = axes.pcolormesh(*edges, shown, norm=norm, cmap="viridis", rasterized=True)
    if min(values.shape) > 1:
        for name, style, _ in _VALIDITY_LINES:
            share = np.ma.masked_invalid(panel[name].values)
            if share.count() and share.min() < SHARE_LIMIT < share.max():
                axes.contour(
                    panel["fractal_dimension"].values, panel["load"].values, share,
                    levels=[SHARE_LIMIT], colors="white", linewidths=0.8, linestyles=[style],
                )  # fmt: skip
    return mesh


_VALIDITY_LINES: tuple[tuple[str, Any, str], ...] = (
    ("share_beyond_hertz", "--", "above: more than half of the load on overlaps $> R/10$"),
    ("share_below_grid", ":", "below: more than half of the load on radii < grid spacing"),
)


def _not_reached_patch(*args: Any, **kwargs: Any) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle(*args, facecolor="white", edgecolor="0.6", hatch="////", linewidth=0.5, **kwargs)


def _friction_legend(figure: Figure, *, locked: bool, asperities: bool) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [_not_reached_patch((0, 0), 1, 1, label="load not reached")]
    if locked:
        handles.append(Patch(facecolor=_LOCKED_COLOUR, label=r"self-locked: $F_N \leq 0$"))
    if asperities:
        handles += [
            Line2D([], [], color="0.4", linestyle=style, linewidth=1, label=label)
            for _, style, label in _VALIDITY_LINES
        ]
    figure.legend(handles=handles, loc="outside lower center")


def _edges(centres: Floats) -> Floats:
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middles = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middles[0]], middles, [2 * centres[-1] - middles[-1]]])


# ---- Area against load ----------------------------------------------------------------------------------------------


def area_figure(dataset: xarray.Dataset) -> Figure:
    """True contact area against normal load, and their ratio, with 95 % intervals; a column for each amplitude."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    study = study_of(dataset)
    mu0, tau0 = study.friction.mu0[0], study.friction.tau0[0]
    shown = _some(dataset.sizes["fractal_dimension"], MOST_CURVES)
    areas = area_map(dataset.isel(fractal_dimension=shown), reached_loads(dataset), mu0=mu0, tau0=float(tau0))
    areas = areas.isel(mu0=0, tau0=0)
    exact = study.contact.mechanics == "half-space"
    amplitudes = areas["amplitude"].values
    figure = Figure(figsize=(WIDTH, 102 * MILLIMETRE), layout="constrained")
    axes = figure.subplots(2, amplitudes.size, squeeze=False, sharex=True, sharey="row")
    colours = colormaps["viridis"](np.linspace(0, 0.92, shown.size))
    for column, amplitude in enumerate(amplitudes):
        for curve, colour in zip(range(shown.size), colours, strict=True):
            line = areas.isel(amplitude=column, fractal_dimension=curve)
            load = line["load"].values
            label = f"{float(line['fractal_dimension']):.2f}"
            trusted = exact | (line["share_beyond_hertz"].values <= SHARE_LIMIT)
            for ax, scale in zip(axes[:, column], (1.0, 1 / load), strict=True):
                area = scale * line["contact_area"].values
                ax.plot(load, area, ":", color=colour, linewidth=0.8)
                ax.plot(load, np.where(trusted, area, np.nan), color=colour, linewidth=0.8, label=label)
                lower, upper = scale * line["lower"].values, scale * line["upper"].values
                ax.fill_between(load, lower, upper, color=colour, alpha=0.25, linewidth=0)
        for ax in axes[:, column]:
            ax.set_xscale("log")
            if (areas["contact_area"] > 0).any():
                ax.set_yscale("log")
            if not (areas["contact_area"].isel(amplitude=column) > 0).any():
                ax.text(0.5, 0.5, "no load reached", transform=ax.transAxes, ha="center")
        if amplitudes.size > 1:
            axes[0, column].set_title(f"{1000 * amplitude:g} nm")
    axes[0, 0].set_ylabel("true contact area $A$ (µm²)")
    axes[1, 0].set_ylabel("$A / F_N$ (µm²/mN)")
    axes[1, amplitudes.size // 2].set_xlabel("normal load $F_N$ (mN)")
    _title(figure, dataset, study)
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(),
        title=f"{_dimension_label(dataset)}, at $\\mu_0$ = {mu0:g}, $\\tau_0$ = {tau0.text}; shaded: 95 %"
        + ("" if exact else "\ndotted: more than half of the load on overlaps $> R/10$"),
        loc="outside lower center",
        ncols=4,
    )
    return figure


def _dimension_label(dataset: xarray.Dataset) -> str:
    classical = dataset["fractal_dimension"].attrs.get("convention") == "classical"
    return "fractal dimension $D$" + (" (classical)" if classical else "")
