"""Figure of a direct shear test: shear stress and dilation, and the contacts at the peak of the shear stress."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
import xarray
from matplotlib.axes import Axes
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from stiction._number_format import choose_prefixed_unit
from stiction.views.style import AREA_COLOUR, FORCE_COLOUR, MATPLOTLIB_STYLE, OPPOSING_CONTACT_COLOUR, new_figure

MARKER_AREA = 2.0  # square points
PRESSURE_COLOURS = ListedColormap(mpl.colormaps["inferno"](np.linspace(0, 0.8, 256)), "pressure")
"""Colour map of pressures, without pale colours, which would not be visible on white."""


def shear_figure(test: xarray.Dataset) -> Figure:
    """Draw a figure 80 mm wide: shear stress and dilation against displacement, and contacts at the peak stress."""
    with mpl.rc_context(MATPLOTLIB_STYLE):
        has_contacts = "peak_pressure" in test
        has_map = has_contacts and test["peak_pressure"].ndim == 2
        figure = new_figure(165 if has_map else 120 if has_contacts else 80)
        panels = figure.subplots(
            3 if has_contacts else 2, 1, height_ratios=[1, 0.8, 2 if has_map else 0.8][: 3 if has_contacts else 2]
        )
        factor, unit = choose_prefixed_unit(float(test["displacement"][-1]), "um")
        displacement = test["displacement"].values / factor
        _draw_stress(panels[0], test, displacement)
        dilation_factor, dilation_unit = choose_prefixed_unit(_find_largest_value(test["dilation"]), "um")
        if "dilation_interval" in test:
            lower, upper = test["dilation_interval"].values / dilation_factor
            panels[1].fill_between(displacement, lower, upper, color=AREA_COLOUR, alpha=0.2, linewidth=0)
        panels[1].plot(displacement, test["dilation"] / dilation_factor, color=AREA_COLOUR, linewidth=1)
        panels[1].set(ylabel=f"dilation ({dilation_unit})", xlabel=f"displacement ({unit})")
        panels[1].sharex(panels[0])
        panels[0].set_xlim(0, displacement[-1])
        panels[0].tick_params(labelbottom=False)
        if has_contacts:
            peak = test.attrs["peak_displacement_um"] / factor
            for axes in panels[:2]:
                axes.axvline(peak, color="0.4", linewidth=0.5, linestyle=":")
            panels[0].annotate(
                "peak", (peak, 1), (0, 1), xycoords=("data", "axes fraction"), textcoords="offset points", color="0.4",
                ha="center", va="bottom",
            )  # fmt: skip
            _draw_contacts(panels[2], test["peak_pressure"])
            panels[2].set_title(f"contacts at the peak, {peak:.3g} {unit}")
        return figure


def _find_largest_value(values: xarray.DataArray) -> float:
    return float(np.max(np.abs(values.values), initial=0.0, where=np.isfinite(values.values)))


def _draw_stress(axes: Axes, test: xarray.Dataset, displacement: np.ndarray) -> None:
    factor, unit = choose_prefixed_unit(_find_largest_value(test["shear_stress"]), "GPa")
    if "shear_stress_interval" in test:
        lower, upper = test["shear_stress_interval"].values / factor
        axes.fill_between(displacement, lower, upper, color=OPPOSING_CONTACT_COLOUR, alpha=0.2, linewidth=0)
    axes.plot(
        displacement, test["shear_stress"] / factor, color=OPPOSING_CONTACT_COLOUR, linewidth=1, label="shear stress"
    )
    normal_stress = test["normal_load"] / test["overlap_area"] / factor
    axes.plot(displacement, normal_stress, color=FORCE_COLOUR, linewidth=0.7, linestyle="--", label="normal stress")
    axes.set_ylabel(f"stress ({unit})")
    if float(test["shear_stress"].min()) < 0:
        axes.axhline(0, color="0.7", linewidth=0.4)
    else:
        axes.set_ylim(bottom=0)
    axes.legend(loc="best")


def _draw_contacts(axes: Axes, pressure: xarray.DataArray) -> None:
    factor, unit = choose_prefixed_unit(float(pressure["x"][-1]), "um")
    x, megapascals = pressure["x"].values / factor, 1e3 * pressure.values
    if pressure.ndim == 1:
        axes.fill_between(x, megapascals, color=OPPOSING_CONTACT_COLOUR, linewidth=0.6, step="mid")
        axes.set(xlabel=f"position on the lower face ({unit})", ylabel="pressure (MPa)", ylim=(0, None))
        return
    y = pressure["y"].values / factor
    rows, columns = np.nonzero(megapascals > 0)
    # Each contact point is drawn as a marker larger than a grid cell, because a single grid cell would be invisible.
    image = axes.scatter(
        x[columns], y[rows], c=megapascals[rows, columns], s=MARKER_AREA, linewidth=0, cmap=PRESSURE_COLOURS, vmin=0
    )
    axes.figure.colorbar(image, ax=axes, label="pressure (MPa)", location="bottom", shrink=0.8)
    axes.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})", xlim=x[[0, -1]], ylim=y[[0, -1]], aspect="equal")
