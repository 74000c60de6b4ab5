"""How a pair begins to slide: load against displacement with cycles, and what slips before."""

from __future__ import annotations

from typing import Any

import matplotlib as mpl
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import BoundaryNorm
from matplotlib.figure import Figure

from stiction._checks import Floats
from stiction._drawing import add_scale_bar
from stiction._number_format import with_unit
from stiction.studies.assessment import HALF
from stiction.studies.contact_picture import AROUND_LARGEST, FEWEST_POINTS
from stiction.studies.contact_tables import Asperities
from stiction.studies.evaluation import at_load, reached_loads
from stiction.studies.point import STATISTICS
from stiction.studies.study import study_of
from stiction.views.figures.contact import box_of, draw_frame, draw_heights
from stiction.views.figures.ensemble import HEADLINE, dimension_axis, head, headlines, letter, rows_of_axes
from stiction.views.onset import AMPLITUDES
from stiction.views.style import AREA, FORCE, FRICTION, SLIP_MAP, friction_parameters_text, label, new_figure

CYCLES = ("0.55", FRICTION)  # colours of the cycles


def onset_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """Tangential load against displacement with cycles, and the fractions that slip against the load; 80 mm wide.

    It is of what `onset_of_result` returns. Of a free half-plane, which has no displacement, only what slips is drawn.
    """
    curve = onset.sel(statistic="mean")
    way, load = (_from_rest(curve[name].values) for name in ("displacement", "tangential_load"))
    moves = bool(np.isfinite(way).all())
    figure = new_figure(114 if moves else 66)
    panels = figure.subplots(2 if moves else 1, 1, squeeze=False, height_ratios=[1.25, 1] if moves else [1])[:, 0]
    if moves:
        axes = panels[0]
        low, high = (_from_rest(onset["displacement"].sel(statistic=each).values) for each in ("lower", "upper"))
        if np.isfinite(low).all():
            axes.fill_betweenx(load, 1e3 * low, 1e3 * high, color=FORCE, alpha=0.15, linewidth=0)
        for amplitude, colour in zip(AMPLITUDES, CYCLES, strict=True):
            cycle = _cycle(way, load, float(curve["tangential_load"].sel(fraction=amplitude)))
            lost = 1e3 * float(curve["energy_lost"].sel(fraction=amplitude))
            words = f"cycle of {amplitude:g}: {with_unit(lost, 'pJ')}"
            axes.plot(1e3 * cycle[0], cycle[1], color=colour, linewidth=0.8, label=words)
        first = _smooth(way, load, float(load[-1]))
        axes.plot(1e3 * first[0], first[1], color=FORCE, linewidth=1.2, label="first way up")
        axes.axhline(0, color="0.7", linewidth=0.4)
        axes.axvline(0, color="0.7", linewidth=0.4)
        axes.set(xlabel="displacement of the upper body (nm)", ylabel="tangential load $F_T$ (mN)")
        axes.legend(loc="lower right", title="of the sliding load")
    axes = panels[-1]
    part = np.concatenate([[0.0], onset["fraction"].values])
    for name, words, dashes, colour in (
        ("slipped_area", "of the true contact area", "-", AREA),
        ("slipped_load", "of the normal load", "--", FORCE),
    ):
        mean, low, high = (100 * _from_rest(onset[name].sel(statistic=each).values) for each in STATISTICS)
        if np.isfinite(low).all():
            axes.fill_between(part, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(part, mean, dashes, color=colour, linewidth=1, label=words)
    axes.set(xlim=(0, 1), ylim=(0, 100), xlabel="tangential load over sliding load", ylabel="what slips (%)")
    axes.legend(loc="upper left")
    figure.suptitle(f"{_head(onset, title)}; bands: 95 %, sampling of positions", fontsize=6)
    return figure


def _head(onset: xarray.Dataset, title: str) -> str:
    a = onset.attrs
    parameters = friction_parameters_text(float(a["mu0"]), float(a["tau0_GPa"]))
    return f"{title}\n{parameters}, $F_N$ = {with_unit(float(a['load_mN']), 'mN')}".strip()


def _from_rest(values: Floats) -> Floats:
    return np.concatenate([[0.0], np.asarray(values, dtype=np.float64)])


SMOOTH = 200  # points of a drawn curve


def _smooth(way: Floats, load: Floats, top: float) -> tuple[Floats, Floats]:
    """The first way up to a load, between its steps by a monotone cubic."""
    from scipy.interpolate import PchipInterpolator

    fine = np.linspace(0.0, top, SMOOTH)
    return np.asarray(PchipInterpolator(load, way)(fine)), fine


def _cycle(way: Floats, load: Floats, top: float) -> tuple[Floats, Floats]:
    """A cycle between plus and minus a load, by Masing's rule: the first way up twice as large from each reversal."""
    up = _smooth(way, load, top)
    down = up[0][-1] - 2 * up[0], up[1][-1] - 2 * up[1]
    return np.concatenate([down[0], -down[0]]), np.concatenate([down[1], -down[1]])


# ---- What slips first -----------------------------------------------------------------------------------------------


_LARGEST = 60.0  # area (square points) of the mark of the largest contact


def has_slip_map(onset: xarray.Dataset) -> bool:
    """Whether an onset has what `slip_figure` shows: that of areas has."""
    return bool("slip" in onset or "contact_slip" in onset)


def slip_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """At which tangential load each point of the contacts begins to slip, over the heights; 80 mm wide.

    It is of what `onset_of_result` returns of areas. Of asperities each contact is a mark, at the load at which it
    slides as a whole.
    """
    of_points = "slip" in onset
    figure = new_figure(144 if of_points else 86)
    drawn = figure.subplots(2 if of_points else 1, 1, squeeze=False)[:, 0]
    colours = mpl.colormaps[SLIP_MAP]
    levels = BoundaryNorm([0.0, *onset["fraction"].values], colours.N)
    whole = box_of(onset, "slip")
    draw_heights(figure, drawn[0], onset["lower_height"].values, whole)
    add_scale_bar(drawn[0], whole, fontsize=6)
    if of_points:
        _points(drawn[0], onset["slip"].values, whole, levels)
        part, box = _crop(onset)
        draw_frame(drawn[0], box)
        drawn[1].imshow(onset["lower_height"].values[part], extent=box, origin="lower", cmap="gray", alpha=0.6)
        _points(drawn[1], onset["slip"].values[part], box, levels)
        drawn[1].set_title("where most touches (framed above)", loc="left", fontsize=6, pad=3)
        drawn[1].set(xlabel=label("x"), ylabel=label("y"))
    else:
        area = onset["contact_area"].values
        drawn[0].scatter(
            onset["contact_x"], onset["contact_y"], s=np.maximum(_LARGEST * area / area.max(initial=1e-300), 4.0),
            c=onset["contact_slip"], cmap=SLIP_MAP, norm=levels, edgecolors="white", linewidths=0.4,
        )  # fmt: skip
    bar = figure.colorbar(
        ScalarMappable(levels, colours), ax=drawn[-1], location="bottom", shrink=0.8, ticks=[0, 0.2, 0.4, 0.6, 0.8, 1]
    )
    bar.set_label(f"tangential over sliding load at which a {'point slips' if of_points else 'contact slides'}")
    drawn[0].set_title(_head(onset, title), loc="left", fontsize=6, pad=3)
    return figure


def _points(axes: Axes, slip: Floats, box: tuple[float, ...], levels: BoundaryNorm) -> None:
    kind: dict[str, Any] = {"origin": "lower", "interpolation": "nearest", "cmap": SLIP_MAP, "norm": levels}
    axes.imshow(slip, extent=(box[0], box[1], box[2], box[3]), **kind)


def _crop(onset: xarray.Dataset) -> tuple[tuple[slice, slice], tuple[float, float, float, float]]:
    """The part of the map in which most touches: its rows and columns, and its box (µm)."""
    from scipy.ndimage import gaussian_filter

    touching = np.isfinite(onset["slip"].values)
    size = [min(max(n // AROUND_LARGEST, FEWEST_POINTS), n) for n in touching.shape]
    busy = gaussian_filter(touching.astype(np.float64), [each / 4 for each in size], mode="constant")
    middle = np.unravel_index(int(busy.argmax()), busy.shape)
    rows, columns = (
        slice(begin := int(np.clip(at - wide // 2, 0, n - wide)), begin + wide)
        for at, wide, n in zip(middle, size, touching.shape, strict=True)
    )
    return (rows, columns), box_of(onset.isel(slip_y=rows, slip_x=columns), "slip")


# ---- Over fractal dimension -----------------------------------------------------------------------------------------


_PANELS = {
    "displacement_at_sliding": (1000.0, "creep before sliding (nm)", True),
    "fraction_slipped": (100.0, "slips at half of the load (%)", False),
    "tangential_stiffness": (1.0, "tangential stiffness (mN/µm)", True),
}
"""Factor, words and whether the axis has equal ratios, of each panel."""

PARTS = (0.25, 0.5, 0.75)
"""Loads of the curves, as fractions of the way in ratio from the lightest to the heaviest load."""

COLOURS = ("#56b4e9", "#0072b2", "#003a5d")  # colours of the curves, from light loads to heavy ones


def dimension_onset_figure(dataset: xarray.Dataset) -> Figure:
    """Creep, what slips at half of the sliding load, and stiffness over fractal dimension; a row for each amplitude.

    With 95 % intervals; dotted where the model is beyond its validity.
    """
    study = study_of(dataset)
    assert isinstance(study.contact, Asperities)
    asked = study.contact.onset
    assert asked is not None
    ends = np.log(reached_loads(dataset, 2))
    loads = np.unique([float(f"{np.exp(ends[0] + part * (ends[1] - ends[0])):.0e}") for part in PARTS])
    at = at_load(dataset, loads, mu0=asked.mu0, tau0=float(asked.tau0)).isel(mu0=0, tau0=0)
    amplitudes = dataset["amplitude"].values
    lines = headlines(dataset, study)
    figure, total, axes_at = rows_of_axes(amplitudes.size, 42.0, 6.0 + HEADLINE * len(lines), 15.0, between=5.0)
    for row, amplitude in enumerate(amplitudes):
        for number, name in enumerate(_PANELS):
            axes = axes_at(13 + 57 * number, row, 40)
            _curves(axes, at.isel(amplitude=row), name)
            dimension_axis(axes, dataset, last=row == amplitudes.size - 1)
            if row == 0:
                letter(axes, number)
            if amplitudes.size > 1 and number == 0:
                axes.set_title(f"$a$ = {1000 * amplitude:g} nm", loc="right", pad=2)
    head(figure, lines)
    handles, words = figure.axes[0].get_legend_handles_labels()
    figure.legend(handles, words, loc="lower left", ncols=len(handles), borderaxespad=0.3)
    figure.text(
        0.99, 1.5 / total, f"at {friction_parameters_text(asked.mu0, float(asked.tau0))}; bands: 95 %; dotted: model "
        "not valid", ha="right", va="bottom", fontsize=6,
    )  # fmt: skip
    return figure


def _curves(axes: Axes, at: xarray.Dataset, name: str) -> None:
    factor, words, in_ratios = _PANELS[name]
    dimension = at["fractal_dimension"].values
    for load, colour in zip(at["load"].values, COLOURS, strict=False):
        one = at.sel(load=load)
        mean, lower, upper = (factor * one[name].sel(statistic=each).values for each in STATISTICS)
        trusted = ~(one["share_beyond_hertz"].values > HALF)
        axes.fill_between(dimension, lower, upper, color=colour, alpha=0.2, linewidth=0)
        marker = "o" if dimension.size == 1 else None
        style: dict[str, Any] = {"color": colour, "linewidth": 1, "marker": marker, "markersize": 2}
        axes.plot(dimension, mean, ":", **style)
        axes.plot(dimension, np.where(trusted, mean, np.nan), label=f"$F_N$ = {with_unit(load, 'mN')}", **style)
    known = at[name].sel(statistic="mean").values
    known = factor * known[np.isfinite(known) & (known > 0)]
    if in_ratios and known.size:
        axes.set(yscale="log", ylim=(known.min() / 2, known.max() * 2))
    elif not in_ratios:
        axes.set_ylim(0, 50)
    axes.set_ylabel(words)
