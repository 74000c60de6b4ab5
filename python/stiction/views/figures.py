"""The paper's figures from a result, for print: matplotlib, colour-blind-safe, units on every axis."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.friction import STATUS_SELF_LOCKED
from stiction.studies.ensemble import area_map, friction_map
from stiction.studies.study import Study, study_of

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MILLIMETRE = 1 / 25.4
LOAD_STEPS = 80
MOST_CURVES = 8
_STYLE: dict[Any, Any] = {
    "font.size": 8,
    "axes.titlesize": 8,
    "axes.linewidth": 0.6,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "legend.frameon": False,
    "figure.dpi": 200,
    "hatch.linewidth": 0.4,
}
_LOCKED_COLOUR = "#7a0019"


def save_figures(dataset: xarray.Dataset, directory: str | Path) -> list[Path]:
    """Draw every figure of a result into a directory and return their paths.

    ``friction.png`` maps the friction coefficient over fractal dimension and load (one file per amplitude if there are
    several); ``area.png`` shows the true contact area against load.
    """
    import matplotlib as mpl

    directory = Path(directory)
    amplitudes = dataset["amplitude"].values
    paths = []
    with mpl.rc_context(_STYLE):
        for amplitude in amplitudes:
            name = "friction" if amplitudes.size == 1 else f"friction_amplitude_{1000 * amplitude:.12g}nm"
            paths.append(_save(friction_figure(dataset, amplitude), directory / f"{name}.png"))
        paths.append(_save(area_figure(dataset), directory / "area.png"))
    return paths


def _save(figure: Figure, path: Path) -> Path:
    figure.savefig(path)
    return path


def _say_if_unfinished(figure: Figure, dataset: xarray.Dataset, study: Study) -> None:
    done, total = dataset.sizes["repetition"], study.ensemble.repetitions
    if done < total:
        figure.suptitle(f"unfinished: {done} of {total} repetitions", fontsize=8)


def reached_loads(dataset: xarray.Dataset, steps: int = LOAD_STEPS) -> Floats:
    """Loads in equal ratios (mN), from what the lightest approach carries to the most that any ensemble reaches.

    The lower end is the largest of the ensembles' loads at the first approach, so that none of them starts above it.
    """
    elastic = dataset["normal_elastic"].mean("repetition")
    highest = float(elastic.max())
    if not highest > 0:
        raise ValueError("no pair of this result touches within its approaches, so there is nothing to draw")
    lowest = float(elastic.isel(approach=0).max())
    if not 1e-6 * highest < lowest < 0.5 * highest:
        lowest = 1e-6 * highest if lowest < highest / 2 else highest / 10
    return np.geomspace(lowest, highest, steps)


# ---- Friction coefficient over fractal dimension and load -----------------------------------------------------------


def friction_figure(dataset: xarray.Dataset, amplitude: float) -> Figure:
    """Colour maps over fractal dimension and normal load: a row per mu0, with its own colours, a column per tau0."""
    from matplotlib.figure import Figure

    study = study_of(dataset)
    maps = friction_map(dataset.sel(amplitude=[amplitude]), reached_loads(dataset)).isel(amplitude=0)
    rows, columns = maps.sizes["mu0"], maps.sizes["tau0"]
    figure = Figure(figsize=((30 + 31 * columns) * MILLIMETRE, (24 + 36 * rows) * MILLIMETRE), layout="constrained")
    axes = figure.subplots(rows, columns, sharex=True, sharey=True, squeeze=False)
    for row in range(rows):
        norm = _norm(maps["friction_coefficient"].isel(mu0=row).values)
        for column in range(columns):
            mesh = _friction_panel(axes[row, column], maps.isel(mu0=row, tau0=column), norm)
            if row == 0:
                axes[row, column].set_title(rf"$\tau_0$ = {study.friction.tau0[column].text}")
        axes[row, 0].set_ylabel("$F_N$ (mN)")
        bar = figure.colorbar(mesh, ax=axes[row], extend="both", pad=0.01)
        bar.set_label(rf"$\mu_s$ at $\mu_0$ = {study.friction.mu0[row]:g}")
        ticks = [tick for tick in _TICKS if norm.vmin <= tick <= norm.vmax]
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        bar.ax.minorticks_off()
    axes[-1, columns // 2].set_xlabel(_dimension_label(dataset))
    _say_if_unfinished(figure, dataset, study)
    _friction_legend(figure, locked=bool((maps["status"] == STATUS_SELF_LOCKED).any()), columns=min(columns, 2))
    return figure


_TICKS = (0.02, 0.03, 0.05, 0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 0.7, 1, 1.5, 2, 3, 5, 7, 10, 20)


def _norm(values: Floats) -> Any:
    """Colours in equal ratios; the highest few per cent share one, or friction at the highest D would take them all."""
    from matplotlib.colors import LogNorm

    positive = values[np.isfinite(values) & (values > 0)]
    low, high = np.quantile(positive, [0.01, 0.95]) if positive.size else (0.1, 1.0)
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
    mesh = axes.pcolormesh(*edges, np.ma.masked_invalid(values), norm=norm, cmap="viridis", rasterized=True)
    if min(values.shape) > 1:
        for name, style, _ in _VALIDITY_LINES:
            share = np.ma.masked_invalid(panel[name].values)
            if share.count() and share.min() < 0.5 < share.max():
                axes.contour(
                    panel["fractal_dimension"].values, panel["load"].values, share,
                    levels=[0.5], colors="white", linewidths=0.8, linestyles=[style],
                )  # fmt: skip
    return mesh


_VALIDITY_LINES: tuple[tuple[str, Any, str], ...] = (
    ("share_beyond_hertz", "--", "above: more than half of the load on overlaps $> R/10$"),
    ("share_below_grid", ":", "below: more than half of the load on radii < grid spacing"),
)


def _not_reached_patch(*args: Any, **kwargs: Any) -> Any:
    from matplotlib.patches import Rectangle

    return Rectangle(*args, facecolor="white", edgecolor="0.6", hatch="////", linewidth=0.5, **kwargs)


def _friction_legend(figure: Figure, *, locked: bool, columns: int) -> None:
    from matplotlib.lines import Line2D
    from matplotlib.patches import Patch

    handles = [_not_reached_patch((0, 0), 1, 1, label="load not reached")]
    if locked:
        handles.append(Patch(facecolor=_LOCKED_COLOUR, label=r"self-locked: $F_N \leq 0$"))
    handles += [
        Line2D([], [], color="0.4", linestyle=style, linewidth=1, label=label) for _, style, label in _VALIDITY_LINES
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=columns)


def _edges(centres: Floats) -> Floats:
    if centres.size == 1:
        return np.array([centres[0] - 0.5, centres[0] + 0.5])
    middles = (centres[1:] + centres[:-1]) / 2
    return np.concatenate([[2 * centres[0] - middles[0]], middles, [2 * centres[-1] - middles[-1]]])


# ---- Area against load ----------------------------------------------------------------------------------------------


def area_figure(dataset: xarray.Dataset) -> Figure:
    """True contact area against normal load, and their ratio, with 95 % intervals; a row for each amplitude."""
    from matplotlib import colormaps
    from matplotlib.figure import Figure

    study = study_of(dataset)
    mu0, tau0 = study.friction.mu0[0], study.friction.tau0[0]
    dimensions = dataset["fractal_dimension"].values
    shown = np.unique(np.linspace(0, dimensions.size - 1, min(MOST_CURVES, dimensions.size)).round().astype(int))
    areas = area_map(dataset.isel(fractal_dimension=shown), reached_loads(dataset), mu0=mu0, tau0=float(tau0))
    areas = areas.isel(mu0=0, tau0=0)
    rows = areas.sizes["amplitude"]
    figure = Figure(figsize=(170 * MILLIMETRE, (18 + 62 * rows) * MILLIMETRE), layout="constrained")
    axes = figure.subplots(rows, 2, squeeze=False, sharex=True)
    colours = colormaps["viridis"](np.linspace(0, 0.92, shown.size))
    for row, amplitude in enumerate(areas["amplitude"].values):
        for curve, colour in zip(range(shown.size), colours, strict=True):
            line = areas.isel(amplitude=row, fractal_dimension=curve)
            load = line["load"].values
            label = f"{float(line['fractal_dimension']):.2f}"
            trusted = line["share_beyond_hertz"].values <= 0.5
            for ax, scale in zip(axes[row], (1.0, 1 / load), strict=True):
                area = scale * line["contact_area"].values
                ax.plot(load, area, ":", color=colour, linewidth=1)
                ax.plot(load, np.where(trusted, area, np.nan), color=colour, linewidth=1, label=label)
                ax.fill_between(
                    load,
                    scale * line["lower"].values,
                    scale * line["upper"].values,
                    color=colour,
                    alpha=0.25,
                    linewidth=0,
                )
        for ax in axes[row]:
            ax.set_xscale("log")
            if (areas["contact_area"].isel(amplitude=row) > 0).any():
                ax.set_yscale("log")
            else:
                ax.text(0.5, 0.5, "no load reached", transform=ax.transAxes, ha="center")
        axes[row, 0].set_ylabel("true contact area $A$ (µm²)")
        axes[row, 1].set_ylabel("$A / F_N$ (µm²/mN)")
        if rows > 1:
            axes[row, 0].set_title(f"amplitude {1000 * amplitude:g} nm", loc="left")
    for ax in axes[-1]:
        ax.set_xlabel("normal load $F_N$ (mN)")
    _say_if_unfinished(figure, dataset, study)
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(),
        title=f"{_dimension_label(dataset)}\n$\\mu_0$ = {mu0:g}\n$\\tau_0$ = {tau0.text}\nshaded: 95 %\n"
        "dotted: more than half of\nthe load on overlaps $> R/10$",
        loc="outside right center",
    )
    return figure


def _dimension_label(dataset: xarray.Dataset) -> str:
    classical = dataset["fractal_dimension"].attrs.get("convention") == "classical"
    return "fractal dimension $D$" + (" (classical)" if classical else "")
