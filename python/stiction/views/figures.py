"""The paper's figures from a result, for print: matplotlib, colour-blind-safe, units on every axis."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.mechanics.friction import STATUS_OK, STATUS_SELF_LOCKED
from stiction.studies.maps import area_map, friction_map
from stiction.studies.pairs import ProfileGenerator, pair_of
from stiction.studies.streams import means
from stiction.studies.study import Study, step_of, study_of
from stiction.surfaces.fractal import weierstrass_mandelbrot_surface
from stiction.surfaces.profile import Profile
from stiction.views.style import (
    FRICTION_MAP,
    FULL_WIDTH,
    LOCKED,
    MILLIMETRE,
    STRENGTHS,
    STYLE,
    WIDTH,
    dimension_colours,
    few_ticks,
    force_text,
    label,
    save_picture,
    spread_out,
)

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LOAD_STEPS = 80
MOST_CURVES = 8
SHARE_LIMIT = 0.5
"""Share of the load beyond Hertz, or on radii below the grid spacing, from which on a figure marks a value."""

COLOUR_QUANTILES = (0.01, 0.95)
"""Of the friction coefficients, those between which the colours run: a few high values would take them all."""

MOST_STRENGTHS = 3
"""Adhesive shear strengths that a figure shows: of more, the lowest and the highest."""

VEIL = 0.7
"""Share of white over what is beyond the model's validity."""

FADE = (0.3, 1.2, 0.75)
"""Width of an interval, over the value, from which and up to which a cell fades, and to what share of white."""

LINE_HEIGHT = 2.4
"""Millimetres from one name of a curve to the next."""

MOST_BAND = 2.0
"""Times the highest or lowest value, as far as an axis goes for a band."""


def save_figures(dataset: xarray.Dataset, directory: str | Path) -> list[Path]:
    """Draw the figures that a result's study asks for into a directory and return their paths.

    ``profiles.png``: profiles of several fractal dimensions. ``length_scales.png``: profiles and areal surfaces of
    three length scales. ``friction_mu0_*.png``: the friction coefficient over fractal dimension and load, a file for
    each mu0. ``area.png``: the true contact area against load. Of several sliding rules or directions each has files
    of its own, as in ``friction_mu0_0.4_all_90.png``.
    """
    return [save() for _, save in pictures(dataset, Path(directory))]


def pictures(dataset: xarray.Dataset, directory: Path) -> Iterator[tuple[Path, Callable[[], Path]]]:
    """The figures of `save_figures`: the path of each, and what draws it."""
    study = study_of(dataset)

    def picture(name: str, figure: Callable[..., Figure], *arguments: Any) -> tuple[Path, Callable[[], Path]]:
        return directory / name, lambda: _save(directory / name, figure, *arguments)

    for name in study.figures.draw:
        match name:
            case "profiles":
                yield picture("profiles.png", profiles_figure, study)
            case "length-scales":
                yield picture("length_scales.png", length_scales_figure, study)
            case "friction":
                for suffix, one in _motions(dataset):
                    for mu0 in study.friction.mu0:
                        yield picture(f"friction_mu0_{mu0:.12g}{suffix}.png", friction_figure, one, mu0)
            case "area":
                for suffix, one in _motions(dataset):
                    yield picture(f"area{suffix}.png", area_figure, one)


def _save(path: Path, figure: Callable[..., Figure], *arguments: Any) -> Path:
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        save_picture(figure(*arguments), path)
    return path


def _motions(dataset: xarray.Dataset) -> Iterator[tuple[str, xarray.Dataset]]:
    """The result of each sliding rule and direction, and what its files are called by."""
    dims = [dim for dim in ("sliding", "direction") if dim in dataset.dims]
    for place in np.ndindex(*(dataset.sizes[dim] for dim in dims)):
        one = dataset.isel(dict(zip(dims, place, strict=True)))
        names = [f"{one[dim].item():g}" if dim == "direction" else str(one[dim].item()) for dim in dims]
        yield "".join(f"_{name}" for name in names), one


def _headlines(dataset: xarray.Dataset, study: Study) -> list[str]:
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
    return lines


HEADLINE = 4.0
"""Millimetres that one takes."""


def _head(figure: Figure, lines: list[str]) -> None:
    if lines:
        figure.suptitle("\n".join(lines), fontsize=8, y=1 - MILLIMETRE / figure.get_figheight(), va="top")


def _way(angle: float) -> str:
    return {0.0: "$+x$", 90.0: "$+y$", 180.0: "$-x$", 270.0: "$-y$"}.get(angle, f"{angle:g}° from $+x$")


def reached_loads(dataset: xarray.Dataset, steps: int = LOAD_STEPS) -> Floats:
    """Loads in equal ratios (mN), from what the lightest approach carries to the most that any ensemble reaches.

    The lower end is the largest of the ensembles' loads at the first approach (or load, by the half-space), so that
    none of them starts above it.
    """
    elastic = means(dataset, ["normal_elastic"])["normal_elastic"]
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
            ax.plot(profile.x[shown], profile.heights[shown], color="0.2", linewidth=0.4)
            ax.set_xlim(0, end)
        axes[row, 0].set_title(f"$D$ = {dimension:.3g}", loc="left", pad=2)
    for ax in axes[-1]:
        ax.set_xlabel("$x$ (µm)")
    axes[dimensions.size // 2, 0].set_ylabel("height $z$ (µm)")
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
        top.plot(profile.x, profile.heights - profile.heights.mean(), color="0.2", linewidth=0.4)
        top.set_title(f"$L$ = {scale:.3g} µm")
        top.set_xlim(0, extent)
        heights = surface.heights - surface.heights.mean()
        image = bottom.imshow(heights, extent=(0, extent, 0, extent), origin="lower", cmap="cividis")
        bar = figure.colorbar(image, ax=bottom, location="bottom", pad=0.02)
        bar.locator = MaxNLocator(3)
        bar.set_label("height $z$ (µm)")
        bottom.set_xlabel("$x$ (µm)")
        bottom.tick_params(axis="x", labelbottom=True)
        if column > 0:
            bottom.tick_params(labelleft=False)
    axes[0, 0].set_ylabel("height $z$ (µm)")
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
    """Friction coefficient over fractal dimension and load as maps, and over fractal dimension at one load as curves.

    A map for each tau0, of more than three the lowest and the two highest; a row for each amplitude. Veiled where the
    model is beyond its validity, pale where the 95 % interval is wide. The curves, of the lowest and the highest tau0
    with their intervals, are at the highest power of ten that nine of ten fractal dimensions reach.
    """
    from matplotlib.figure import Figure

    study = study_of(dataset)
    chosen = _chosen_strengths(len(study.friction.tau0))
    strengths = [study.friction.tau0[index] for index in chosen]
    load = _common_load(dataset)
    loads = [*reached_loads(dataset), load]
    maps = friction_map(dataset, loads, mu0=[mu0], tau0=[float(each) for each in strengths]).isel(mu0=0)
    maps, curves = maps.isel(load=slice(-1)), maps.isel(load=-1)
    amplitudes = dataset["amplitude"].values
    lines = _headlines(dataset, study)
    meanings = _meanings(maps, asperities=study.contact.mechanics == "asperities")
    above, below = 15.0 + HEADLINE * len(lines), 16.0 + (3.0 if len(meanings) > MOST_IN_ROW else 0.0)
    height = 42.0 if amplitudes.size == 1 else 34.0
    between = 4.0
    total = above + below + amplitudes.size * (height + between) - between
    figure = Figure(figsize=(FULL_WIDTH, total * MILLIMETRE))

    def axes_at(left: float, row: int, width: float) -> Axes:
        bottom = below + (amplitudes.size - 1 - row) * (height + between)
        return figure.add_axes((left / 170, bottom / total, width / 170, height / total))

    norm = _norm(maps)
    for row, amplitude in enumerate(amplitudes):
        several = f"{1000 * amplitude:g} nm" if amplitudes.size > 1 else ""
        width = (99 - 3 * (len(strengths) - 1)) / len(strengths)
        for column, strength in enumerate(strengths):
            ax = axes_at(13 + column * (width + 3), row, width)
            _friction_panel(ax, maps.isel(amplitude=row, tau0=column), norm, load)
            if column == 0:
                ax.set_ylabel(label("load"))
            else:
                ax.yaxis.set_visible(False)
            if row == 0:
                ax.set_title(rf"$\tau_0$ = {strength.text}", pad=2)
            _dimension_axis(ax, dataset, last=row == amplitudes.size - 1, long=column == len(strengths) // 2)
            if several:
                box = {"facecolor": "white", "linewidth": 0, "pad": 0.8}
                corner = ax.text(0.96, 0.96, f"$a$ = {several}", transform=ax.transAxes, fontsize=6, bbox=box)
                corner.set(horizontalalignment="right", verticalalignment="top")
        ax = axes_at(127, row, 40)
        _friction_curves(ax, curves.isel(amplitude=row), [each.text for each in strengths], mu0)
        if row == amplitudes.size // 2:
            ax.set_ylabel(label("friction_coefficient"))
        if row == 0:
            ax.set_title(f"at $F_N$ = {force_text(load)}", pad=2)
        _dimension_axis(ax, dataset, last=row == amplitudes.size - 1, long=True)
    _colour_bar(figure, (13 / 170, 1 - (above - 5.5) / total, 99 / 170, 2.2 / total), norm, mu0)
    _head(figure, lines)
    figure.legend(
        handles=meanings, loc="lower center", ncols=len(meanings) if len(meanings) <= MOST_IN_ROW else 3,
        handlelength=1.6, columnspacing=1.4, borderaxespad=0.3,
    )  # fmt: skip
    return figure


def _chosen_strengths(count: int) -> list[int]:
    """Which of so many shear strengths are drawn."""
    return list(range(count)) if count <= MOST_STRENGTHS else [0, *range(count - MOST_STRENGTHS + 1, count)]


def _common_load(dataset: xarray.Dataset) -> float:
    """The highest power of ten (mN) that nine of ten ensembles reach, or their highest load if that is out of range."""
    elastic = means(dataset, ["normal_elastic"])["normal_elastic"].max(step_of(dataset)).values
    lowest, common = float(reached_loads(dataset)[0]), float(np.quantile(elastic[elastic > 0], 0.1))
    power = 10.0 ** np.floor(np.log10(0.9 * common))
    return float(power if power >= lowest else max(common, lowest))


def _dimension_axis(axes: Axes, dataset: xarray.Dataset, *, last: bool, long: bool) -> None:
    axes.xaxis.set_major_locator(_few_numbers())
    if not last:
        axes.tick_params(labelbottom=False)
    elif long:
        axes.set_xlabel(_dimension_label(dataset))
    else:
        axes.set_xlabel("$D$")


def _few_numbers(most: int = 4) -> Any:
    from matplotlib.ticker import MaxNLocator

    return MaxNLocator(most, steps=[1, 2, 5, 10])


def _friction_curves(axes: Axes, curves: xarray.Dataset, strengths: list[str], mu0: float) -> None:
    """Of the lowest and the highest strength, with their intervals; dotted where the model is beyond its validity."""
    dimension = curves["fractal_dimension"].values
    shown = [0] if len(strengths) == 1 else [0, len(strengths) - 1]
    trusted = ~(curves["share_beyond_hertz"].values > SHARE_LIMIT)  # (dimension, strength)
    value, lower, upper = (curves[name].values for name in ("friction_coefficient", "lower", "upper"))
    for index in shown:
        colour = STRENGTHS[0] if index == 0 else STRENGTHS[-1]
        axes.fill_between(dimension, lower[:, index], upper[:, index], color=colour, alpha=0.25, linewidth=0)
        style: dict[str, Any] = {
            "color": colour,
            "linewidth": 1,
            "markersize": 2,
            "marker": "o" if dimension.size == 1 else None,
        }
        axes.plot(dimension, value[:, index], ":", **style)
        axes.plot(dimension, np.where(trusted[:, index], value[:, index], np.nan), **style)
    known = value[:, shown][np.isfinite(value[:, shown])]
    # Where it is to be trusted, all of it; beyond, as far as there is room.
    inside = upper[:, shown][(np.isfinite(upper) & trusted)[:, shown]]
    top = 1.1 * max(2 * mu0, float(inside.max(initial=0.0)), 2.5 * float(np.min(known, initial=1.0))) or 1.0
    axes.set_ylim(0, top)
    axes.yaxis.set_major_locator(_few_numbers(6))
    span = float(np.ptp(dimension)) or 1.0
    axes.set_xlim(dimension[0] - 0.02 * span, dimension[-1] + 0.02 * span)
    axes.axhline(mu0, color="0.6", linewidth=0.5, linestyle="--", zorder=0)
    axes.text(
        axes.get_xlim()[1] - 0.01 * span, mu0, r"$\mu_0$", color="0.4", fontsize=6, va="bottom", ha="right"
    )  # fmt: skip
    for index in shown:
        starts = np.flatnonzero(np.isfinite(value[:, index]))
        if starts.size:
            at = starts[0]
            height = min(np.nan_to_num(upper[at, index], nan=value[at, index]), 0.93 * top)
            colour = STRENGTHS[0] if index == 0 else STRENGTHS[-1]
            name = rf"$\tau_0$ = {strengths[index]}"
            box = {"facecolor": "white", "alpha": 0.8, "linewidth": 0, "pad": 0.5}
            axes.text(dimension[at] + 0.03 * span, height, name, color=colour, fontsize=6, va="bottom", bbox=box)


def _colour_bar(figure: Figure, place: tuple[float, float, float, float], norm: Any, mu0: float) -> None:
    from matplotlib.cm import ScalarMappable

    axes = figure.add_axes(place, label="<colorbar>")
    bar = figure.colorbar(ScalarMappable(norm, FRICTION_MAP), cax=axes, orientation="horizontal", extend="both")
    ticks = _ticks(norm)
    bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    bar.ax.minorticks_off()
    axes.xaxis.set_ticks_position("top")
    axes.xaxis.set_label_position("top")
    axes.tick_params(length=2, pad=1)
    bar.set_label(rf"{label('friction_coefficient')}, at $\mu_0$ = {mu0:g}", labelpad=2)


def _ticks(norm: Any) -> list[float]:
    """Some of the round numbers on a scale of equal ratios, no closer than their labels are long."""
    inside = [tick for tick in TICKS if norm.vmin <= tick * (1 + 1e-9) and tick <= norm.vmax * (1 + 1e-9)]
    return inside[:: max(1, -(-len(inside) // 8))]


TICKS = (0.01, 0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 20, 30, 50, 100)
"""Round coefficients of friction on a scale of colours."""


def _norm(maps: xarray.Dataset) -> Any:
    """Colours in equal ratios over what is to be trusted, or over all where that is little; the highest share one."""
    from matplotlib.colors import LogNorm

    values = maps["friction_coefficient"].values
    known = np.isfinite(values) & (values > 0)
    trusted = known & ~(maps["share_beyond_hertz"].values > SHARE_LIMIT)
    positive = values[trusted if trusted.sum() > 0.1 * known.sum() else known]
    low, high = np.quantile(positive, COLOUR_QUANTILES) if positive.size else (0.1, 1.0)
    step = 10.0 ** np.floor(np.log10(low)) / 2  # to ends that can be written
    low, high = max(np.floor(low / step) * step, step), np.ceil(high / step) * step
    return LogNorm(low, max(high, low + step))


def _friction_panel(axes: Axes, panel: xarray.Dataset, norm: Any, load: float) -> None:
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb

    panel = panel.transpose("load", "fractal_dimension")
    values, status = panel["friction_coefficient"].values, panel["status"].values
    edges = _edges(panel["fractal_dimension"].values), np.exp(_edges(np.log(panel["load"].values)))
    axes.set_yscale("log")
    axes.set_xlim(edges[0][0], edges[0][-1])
    axes.set_ylim(edges[1][0], edges[1][-1])
    few_ticks(axes)
    axes.add_patch(_not_reached_patch((0, 0), 1, 1, transform=axes.transAxes))
    known = np.isfinite(values)
    # A coefficient of 0 has no logarithm, and is drawn as the lowest colour is.
    colours = colormaps[FRICTION_MAP](norm(np.where(known, np.maximum(values, norm.vmin), norm.vmin)))
    share = panel["share_beyond_hertz"].values
    white = np.maximum(_fading(panel), np.where(share > SHARE_LIMIT, VEIL, 0))[..., np.newaxis]
    colours[..., :3] = (1 - white) * colours[..., :3] + white
    colours[..., 3] = known
    colours[status == STATUS_SELF_LOCKED] = (*to_rgb(LOCKED), 1)
    axes.pcolormesh(*edges, colours)
    if min(values.shape) > 1:
        share = np.ma.masked_invalid(share)
        if share.count() and share.min() < SHARE_LIMIT < share.max():
            axes.contour(
                panel["fractal_dimension"].values, panel["load"].values, share,
                levels=[SHARE_LIMIT], colors="0.2", linewidths=0.6,
            )  # fmt: skip
    axes.plot([0, 0.04], [load, load], color="black", linewidth=1, transform=axes.get_yaxis_transform())


def _fading(maps: xarray.Dataset) -> Floats:
    """Share of white of each cell for the width of its interval, which a single repetition does not have."""
    values = maps["friction_coefficient"].values
    with np.errstate(divide="ignore", invalid="ignore"):
        width = (maps["upper"].values - maps["lower"].values) / values
    first, last, most = FADE
    width = np.where(np.isfinite(values), np.nan_to_num(width, nan=last, posinf=last), first)
    return np.asarray(most * np.clip((width - first) / (last - first), 0, 1))


def _not_reached_patch(*args: Any, **kwargs: Any) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle(*args, facecolor="white", edgecolor="0.6", hatch="////", linewidth=0.5, **kwargs)


MOST_IN_ROW = 4
"""Entries of a legend."""


def _meanings(maps: xarray.Dataset, *, asperities: bool) -> list[Any]:
    """What a legend says of the marks on maps, of those that are there."""
    from matplotlib import colormaps
    from matplotlib.colors import to_rgb
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    middle = np.array(colormaps[FRICTION_MAP](0.4)[:3])
    handles: list[Any] = []
    if asperities:
        handles.append(
            Patch(
                facecolor=tuple((1 - VEIL) * middle + VEIL), edgecolor="0.2", linewidth=0.6,
                label="beyond Hertz (dotted): most load on overlaps $> R/10$",
            )
        )  # fmt: skip
    if (_fading(maps)[~(maps["share_beyond_hertz"].values > SHARE_LIMIT)] > 0.1).any():
        handles.append(Patch(facecolor=tuple((1 - FADE[2]) * middle + FADE[2]), label="pale: wide 95 % interval"))
    if (~np.isin(maps["status"].values, (STATUS_OK, STATUS_SELF_LOCKED))).any():
        handles.append(_not_reached_patch((0, 0), 1, 1, label="load not reached"))
    if (maps["status"].values == STATUS_SELF_LOCKED).any():
        handles.append(Patch(facecolor=to_rgb(LOCKED), label=r"self-locked: $F_N \leq 0$"))
    handles.append(Line2D([], [], color="black", linewidth=1, label="load of the curves; band: 95 %"))
    return handles


def _edges(centres: Floats) -> Floats:
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middles = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middles[0]], middles, [2 * centres[-1] - middles[-1]]])


# ---- Area against load ----------------------------------------------------------------------------------------------


def area_figure(dataset: xarray.Dataset) -> Figure:
    """True contact area against normal load, and their ratio, with 95 % intervals; a row for each amplitude."""
    from matplotlib.figure import Figure

    study = study_of(dataset)
    mu0, tau0 = study.friction.mu0[0], study.friction.tau0[0]
    shown = _some(dataset.sizes["fractal_dimension"], MOST_CURVES)
    areas = area_map(dataset.isel(fractal_dimension=shown), reached_loads(dataset), mu0=mu0, tau0=float(tau0))
    areas = areas.isel(mu0=0, tau0=0)
    amplitudes = areas["amplitude"].values
    lines = _headlines(dataset, study)
    above, below, between = 2.0 + HEADLINE * len(lines), 15.0, 4.0
    height = 50.0 if amplitudes.size == 1 else 38.0
    total = above + below + amplitudes.size * (height + between) - between
    figure = Figure(figsize=(FULL_WIDTH, total * MILLIMETRE))
    for row, amplitude in enumerate(amplitudes):
        bottom = below + (amplitudes.size - 1 - row) * (height + between)
        pair = [figure.add_axes((left / 170, bottom / total, 70 / 170, height / total)) for left in (13, 98)]
        exact = study.contact.mechanics == "half-space"
        _area_curves(pair, areas.isel(amplitude=row), exact=exact, apart=LINE_HEIGHT / height)
        for ax in pair:
            if row < amplitudes.size - 1:
                ax.tick_params(labelbottom=False)
            else:
                ax.set_xlabel(label("load"))
        pair[0].set_ylabel(label("contact_area"))
        pair[1].set_ylabel("area over load $A/F_N$ (µm²/mN)")
        if amplitudes.size > 1:
            pair[0].text(0.03, 0.95, f"$a$ = {1000 * amplitude:g} nm", transform=pair[0].transAxes, va="top")
    _head(figure, lines)
    figure.text(
        0.5, 1.5 / total,
        f"at $\\mu_0$ = {mu0:g}, $\\tau_0$ = {tau0.text}; bands: 95 %"
        + ("" if study.contact.mechanics == "half-space"
           else "; dotted: beyond Hertz, over half of the load on overlaps $> R/10$"),
        ha="center", va="bottom", fontsize=6,
    )  # fmt: skip
    return figure


def _area_curves(axes: list[Axes], areas: xarray.Dataset, *, exact: bool, apart: float) -> None:
    """Area, and area over load, of each fractal dimension; names where curves begin, this share of an axis apart."""
    load, dimensions = areas["load"].values, areas["fractal_dimension"].values
    areas = areas.transpose("fractal_dimension", "load")
    area, lower, upper = (areas[name].values for name in ("contact_area", "lower", "upper"))
    trusted = exact | (areas["share_beyond_hertz"].values <= SHARE_LIMIT)
    positive = area[area > 0]
    for ax, scale in zip(axes, (np.ones(load.size), 1 / load), strict=True):
        ax.set_xscale("log")
        ax.set_xlim(load[0] / (load[-1] / load[0]) ** 0.18, load[-1] * 1.2)
        if not positive.size:
            ax.text(0.5, 0.5, "no load reached", transform=ax.transAxes, ha="center")
            continue
        ax.set_yscale("log")
        # A band that is wider than all the curves may be cut off.
        values = (scale * area)[area > 0]
        ax.set_ylim(values.min() / MOST_BAND, values.max() * MOST_BAND)
        few_ticks(ax)
        names, places = [], []
        for curve, colour in enumerate(dimension_colours(dimensions)):
            ax.fill_between(load, scale * lower[curve], scale * upper[curve], color=colour, alpha=0.25, linewidth=0)
            ax.plot(load, scale * area[curve], ":", color=colour, linewidth=0.8)
            ax.plot(load, np.where(trusted[curve], scale * area[curve], np.nan), color=colour, linewidth=0.8)
            starts = np.flatnonzero(area[curve] > 0)
            if starts.size:
                names.append((load[starts[0]], dimensions[curve], colour))
                places.append(np.log(scale[starts[0]] * area[curve, starts[0]]))
        low, high = np.log(ax.get_ylim())
        spread = spread_out(places, apart * (high - low))
        spread += max(0, low + apart * (high - low) - spread.min(initial=high))
        for (start, dimension, colour), place in zip(names, spread, strict=True):
            text = f"{dimension:.2f}" if dimension != dimensions[0] else f"$D$ = {dimension:.2f}"
            ax.text(start / 1.12, np.exp(place), text, color=colour, fontsize=6, ha="right", va="center")


def _dimension_label(dataset: xarray.Dataset) -> str:
    classical = dataset["fractal_dimension"].attrs.get("convention") == "classical"
    return label("fractal_dimension") + (" (classical)" if classical else "")
