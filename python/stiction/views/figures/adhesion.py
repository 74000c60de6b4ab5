"""Coming and going of bodies that adhere."""

from __future__ import annotations

from typing import Any

import xarray
from matplotlib.figure import Figure

from stiction._checks import Floats
from stiction.studies.contact_picture import IN_PULL_OFFS
from stiction.views.digits import prefix
from stiction.views.style import ALL, AREA, OPPOSING, label, new_figure


def adhesion_figure(ways: xarray.Dataset, *, title: str = "") -> Figure:
    """Load against the approach, where it is known, and against the true area, coming and going; 80 mm wide.

    It is of what `coming_and_going` returns; the pull-off force is marked.
    """
    going = ways["going"].values
    load, area = ways["load"].values, ways["contact_area"].values
    near = load <= IN_PULL_OFFS[-1] * -load.min() * 1.001  # loads that are seen
    core, unit = prefix(float(abs(load[near]).max()), "mN")
    figure = new_figure(70)
    across = [(ways["approach"].values * 1000, "approach (nm)")] if ways["approach"].notnull().all() else []
    panels: Any = figure.subplots(1, len(across) + 1, sharey=True, squeeze=False)[0]
    nominal = float(ways.attrs["nominal_area"])
    across.append((100 * area / nominal, label("contact_area_fraction")))
    for axes, (x, words) in zip(panels, across, strict=True):
        axes.axhline(0, color="0.6", linewidth=0.5)
        axes.plot(x[~going], load[~going] / core, "o-", color=ALL, markersize=3, linewidth=1, label="coming")
        axes.plot(x[going], load[going] / core, "--", color=OPPOSING, linewidth=1.2, label="going")
        last = int(load.argmin())
        axes.plot(x[last], load[last] / core, "v", color=AREA, markersize=5, label="pull-off force")
        axes.set(xlim=_wider(x[near]), xlabel=words)
    panels[0].set(ylim=_wider(load[near] / core), ylabel=f"load ({unit})")
    figure.suptitle(title, fontsize=6)
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3)
    return figure


def _wider(values: Floats) -> tuple[float, float]:
    """Ends of an axis with some room."""
    low, high = float(values.min()), float(values.max())
    room = 0.06 * (high - low) or 1.0
    return low - room, high + room
