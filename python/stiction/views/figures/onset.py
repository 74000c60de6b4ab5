"""How a pair begins to slide: load against displacement with cycles, and what slips before."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction._checks import Floats
from stiction.views.digits import with_unit
from stiction.views.onset import AMPLITUDES
from stiction.views.style import AREA, FORCE, FRICTION, MILLIMETRE, WIDTH, friction_parameters_text

if TYPE_CHECKING:
    import xarray
    from matplotlib.figure import Figure

CYCLES = ("0.55", FRICTION)
"""Colours of the cycles."""


def onset_figure(onset: xarray.Dataset, *, title: str = "") -> Figure:
    """Tangential load against displacement with cycles, and the fractions that slip against the load; 80 mm wide.

    It is of what `onset_of_result` returns. Of a free half-plane, which has no displacement, only what slips is drawn.
    """
    from matplotlib.figure import Figure

    curve = onset.sel(statistic="mean")
    way, load = (_from_rest(curve[name].values) for name in ("displacement", "tangential_load"))
    moves = bool(np.isfinite(way).all())
    figure = Figure(figsize=(WIDTH, (114 if moves else 66) * MILLIMETRE), layout="constrained")
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
        axes.set_xlabel("displacement of the upper body (nm)")
        axes.set_ylabel("tangential load $F_T$ (mN)")
        axes.legend(loc="lower right", title="of the sliding load")
    axes = panels[-1]
    part = np.concatenate([[0.0], onset["fraction"].values])
    for name, words, dashes, colour in (
        ("slipped_area", "of the true contact area", "-", AREA),
        ("slipped_load", "of the normal load", "--", FORCE),
    ):
        mean, low, high = (
            100 * _from_rest(onset[name].sel(statistic=each).values) for each in ("mean", "lower", "upper")
        )
        if np.isfinite(low).all():
            axes.fill_between(part, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.plot(part, mean, dashes, color=colour, linewidth=1, label=words)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 100)
    axes.set_xlabel("tangential load over sliding load")
    axes.set_ylabel("what slips (%)")
    axes.legend(loc="upper left")
    attributes = onset.attrs
    said = friction_parameters_text(float(attributes["mu0"]), float(attributes["tau0_GPa"]))
    head = [title, f"{said}, $F_N$ = {with_unit(float(attributes['load_mN']), 'mN')}; bands: 95 %"]
    figure.suptitle("\n".join(line for line in head if line), fontsize=6)
    return figure


def _from_rest(values: Floats) -> Floats:
    return np.concatenate([[0.0], np.asarray(values, dtype=np.float64)])


SMOOTH = 200
"""Points of a drawn curve."""


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
