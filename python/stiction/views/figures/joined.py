"""The figure of several scans of one surface: their spectra, the joined one, slopes, and the pressure of contact."""

from __future__ import annotations

import math

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from stiction._drawing import few_ticks
from stiction.mechanics.closed_forms import effective_modulus
from stiction.mechanics.materials import material
from stiction.mechanics.resolution import KAPPA
from stiction.surfaces.joined import JoinedSpectrum
from stiction.views.style import ALL, AREA, FULL_WIDTH, LEANING, OPPOSING, STYLE, new_figure

MATERIALS = ("PMMA", "bearing steel", "titanium alloy", "brass", "aluminium")
"""Materials whose hardness over E*, pressed on themselves, is a line."""

SCANS = (LEANING, AREA, OPPOSING, "#cc79a7", "#56b4e9", "#e69f00")  # colours of the scans, one after the other
_LONGEST_NAME = 24


def joined_figure(joined: JoinedSpectrum) -> Figure:
    """Spectra over wavelength, slope and curvature down to it, and the mean pressure in contact; 170 mm wide.

    The surface is pressed on one like it. The elastic pressure over E* is h'/κ of the gap, by `spectral_resolution`;
    where it reaches the hardness of a material over E*, the material yields, and finer waves no longer matter.
    """
    with mpl.rc_context(STYLE):
        figure = new_figure(66, width=FULL_WIDTH)
        spectra, slopes, pressure = figure.subplots(1, 3)
        _spectra_panel(spectra, joined)
        found = joined.roughness()
        slopes.plot(found.wavelength, found.gradient, color=ALL, linewidth=1, label="slope $h'$")
        words = "curvature $h''$ (1/µm)"
        slopes.plot(found.wavelength, found.curvature, "--", color=OPPOSING, linewidth=1, label=words)
        slopes.set_title("of all waves down to this", pad=2)
        slopes.legend(loc="upper left")
        _pressure_panel(pressure, joined)
        for axes in (spectra, slopes, pressure):
            axes.set(xscale="log", yscale="log", xlabel="wavelength (µm)")
            axes.set_xlim(1.15 * joined.longest, joined.shortest / 1.15)
            few_ticks(axes)
    return figure


def _spectra_panel(axes: Axes, joined: JoinedSpectrum) -> None:
    lengths = 2 * math.pi / joined.wave_number
    for scan, (name, ratio) in enumerate(zip(joined.names, joined.ratio, strict=True)):
        short = name if len(name) <= _LONGEST_NAME else f"…{name[1 - _LONGEST_NAME :]}"
        axes.plot(lengths, ratio * joined.density, "o", color=SCANS[scan % len(SCANS)], markersize=2.5, label=short)
    axes.plot(lengths, joined.density, color="black", linewidth=0.8, label="together")
    gap = joined.count == 0
    if gap.any():
        axes.plot(lengths[gap], joined.density[gap], "x", color="black", markersize=3, label="no scan")
    axes.set_ylabel("$C^{2D}$ (µm$^4$)")
    axes.set_title("spectrum", pad=2)
    axes.legend(loc="lower left", handlelength=1.2)


def _pressure_panel(axes: Axes, joined: JoinedSpectrum) -> None:
    found = joined.roughness()
    elastic = math.sqrt(2) * found.gradient / KAPPA
    axes.plot(found.wavelength, elastic, color="black", linewidth=1)
    for index, (name, limit) in enumerate(_hardnesses().items()):
        if not elastic[0] < limit < elastic[-1]:
            continue
        start = np.exp(np.interp(math.log(limit), np.log(elastic), np.log(found.wavelength)))
        colour = SCANS[index % len(SCANS)]
        axes.plot([start, joined.shortest], [limit, limit], color=colour, linewidth=0.8)
        axes.annotate(
            f"{name} yields", (joined.shortest, limit), (0, -1), textcoords="offset points", ha="right", va="top",
            fontsize=6, color=colour,
        )  # fmt: skip
    axes.set_ylabel("mean pressure $p_c/E^*$, on its like")
    axes.set_title("$A/A_0 = p/p_c$, $\\mu_s = \\mu_0 + \\tau_0/p_c$", pad=2)


def _hardnesses() -> dict[str, float]:
    """Hardness over E* of two bodies of one material, for some materials."""
    found = {}
    for name in MATERIALS:
        body = material(name)
        young, ratio = float(body.young_modulus), float(body.poisson_ratio)
        found[name] = float(body.hardness or 0.0) / float(effective_modulus(young, ratio, young, ratio))
    return found
