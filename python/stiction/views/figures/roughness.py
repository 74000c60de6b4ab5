"""Heights, spectra and the distribution of heights of one measured profile or surface."""

from __future__ import annotations

import math
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from stiction._checks import Floats
from stiction._drawing import HEIGHT_MAP, to_wavelength
from stiction.surfaces.lines import LineRoughness
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface
from stiction.views.characterisation import Characterisation, characterisation_of, length_text
from stiction.views.style import AXES, FULL_WIDTH, STYLE, new_figure

MOST_POINTS = 1500  # points of a profile that are drawn; of more, means of neighbours
HEIGHTS = 40  # bins of the distribution of heights
MEASURED, FITTED = "#0072b2", "#d55e00"  # colours of what was measured, and of what was fitted to it
STEPS = (1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)  # of ticks, times a power of ten
MILLIMETRES = 1000.0  # lengths (µm) from which on an axis is in mm


def characterisation_figure(body: Profile | Surface | Characterisation, **options: Any) -> Figure:
    """The figure of a profile, 80 mm wide, or of a surface, 170 mm wide: heights, their distribution, and spectra.

    The parameters are those of `characterisation_text`.
    """
    found = characterisation_of(body, **options)
    with mpl.rc_context(STYLE):
        if isinstance(found.body, Profile):
            figure = new_figure(88)
            first, second = figure.subfigures(2, 1, squeeze=False, height_ratios=[1, 1.7])[:, 0]
            axes = first.subplot_mosaic([["heights", "distribution"]], width_ratios=[1.7, 1])
            axes |= second.subplot_mosaic([["spectrum"]])
            _draw_heights(axes["heights"], found.body)
        else:
            figure = new_figure(112, width=FULL_WIDTH)
            first, second = figure.subfigures(1, 2, squeeze=False, width_ratios=[1, 1.1])[0]
            axes = first.subplot_mosaic([["heights"], ["distribution"]], height_ratios=[2, 1])
            axes |= second.subplot_mosaic([["spectrum"], ["lines"]])
            _draw_map(first, axes["heights"], found.body)
            for line, colour in zip(found.lines, AXES.items(), strict=True):
                _draw_line(axes["lines"], line, *colour)
            _finish_spectrum(axes["lines"], "µm³")
        _draw_spectrum(axes["spectrum"], found)
        _draw_distribution(axes["distribution"], found.body.heights)
    return figure


def _draw_heights(axes: Axes, profile: Profile) -> None:
    """Heights along a profile; of a long one means of neighbours between their lowest and their highest."""
    every = -(-len(profile) // MOST_POINTS)
    heights = profile.heights - profile.heights.min()
    groups = np.pad(1000 * heights, (0, -len(profile) % every), mode="edge").reshape(-1, every)
    x = profile.spacing * (every * np.arange(len(groups)) + (every - 1) / 2)
    unit, size = ("mm", 1000) if x[-1] >= MILLIMETRES else ("µm", 1)
    axes.plot(x / size, groups.mean(axis=1), color=MEASURED, linewidth=0.7)
    if every > 1:
        ends = groups.min(axis=1), groups.max(axis=1)
        axes.fill_between(x / size, *ends, color=MEASURED, alpha=0.4, linewidth=0)
    axes.set(xlabel=f"position $x$ ({unit})", ylabel="height (nm)")
    axes.locator_params(nbins=4, steps=STEPS)


def _draw_distribution(axes: Axes, heights: Floats) -> None:
    about = 1000 * (heights - heights.mean()).ravel()
    rms = float(about.std())
    density, edges = np.histogram(about, HEIGHTS, density=True)
    x = (edges[1:] + edges[:-1]) / 2
    axes.plot(x, density, color=MEASURED, linewidth=0.7)
    normal = np.exp(-((x / rms) ** 2) / 2) / (rms * math.sqrt(2 * math.pi))
    axes.plot(x, normal, "--", color=FITTED, linewidth=1.2)
    axes.set(xlabel="height (nm)", ylabel="density (1/nm)")
    axes.set_title("dashed: Gaussian", fontsize=6, pad=2)
    axes.locator_params(nbins=4, steps=STEPS)


def _draw_spectrum(axes: Axes, found: Characterisation) -> None:
    if found.spectrum is not None:
        shown = found.spectrum.density > 0
        axes.plot(
            found.spectrum.wave_number[shown], found.spectrum.density[shown], ".", color="0.8", markersize=1,
            markeredgewidth=0, rasterized=True, label="harmonics",
        )  # fmt: skip
    shown = found.binned.density > 0
    axes.plot(
        found.binned.wave_number[shown], found.binned.density[shown], color=MEASURED, linewidth=0.6, marker="o",
        markersize=2, label="measured",
    )  # fmt: skip
    law, one = found.law, found.spectrum is not None
    if law is None:
        note = "no self-affine band found" if found.fit is None else "no power law"
    else:
        q = np.geomspace(2 * math.pi / law.longest_wavelength, 2 * math.pi / law.shortest_wavelength, 40)
        name = f"$q^{{-{2 - one}-2H}}$, $H$ = {law.value:.2f} [{law.lower:.2f}, {law.upper:.2f}]"
        axes.plot(q, law.density(q), "--", color=FITTED, linewidth=1.2, label=name)
        axes.axvspan(q[0], q[-1], color=FITTED, alpha=0.12, linewidth=0, label="fitted band")
        classical = f"{law.fractal_dimension_classical:.2f} (classical), " if law.value <= 1 else ""
        note = f"$D$ = {classical}{law.fractal_dimension_paper:.2f} (paper)"
    axes.plot([], [], " ", label=note)
    _finish_spectrum(axes, "µm³" if one else "µm⁴", found.binned.density)


def _draw_line(axes: Axes, line: LineRoughness, axis: str, colour: str) -> None:
    spectrum = line.spectrum.in_bins()
    shown = spectrum.density > 0
    axes.plot(spectrum.wave_number[shown], spectrum.density[shown], color=colour, linewidth=0.7, label=f"along {axis}")
    if line.is_straight and line.band is not None:
        exponent, scatter = float(line.hurst_exponents.mean()), float(line.hurst_exponents.std())
        first, last = (2 * math.pi / end for end in line.band[::-1])
        inside = shown & (spectrum.wave_number >= first) & (spectrum.wave_number <= last)
        # Through the mean spectrum, on average over the band.
        level = np.log(spectrum.wave_number[inside] ** (1 + 2 * exponent) * spectrum.density[inside]).mean()
        q = np.geomspace(first, last, 40)
        name = f"$q^{{-1-2H}}$, $H$ = {exponent:.2f} ± {scatter:.2f}"
        axes.plot(q, np.exp(level) * q ** (-1 - 2 * exponent), "--", color=colour, linewidth=1.2, label=name)


def _finish_spectrum(axes: Axes, unit: str, density: Floats | None = None) -> None:
    """Logarithmic scales, wavelengths above, and what the lines are; over a density, or that of the first line."""
    axes.set(xscale="log", yscale="log", xlabel="wave number $q$ (1/µm)", ylabel=f"density $C$ ({unit})")
    axes.secondary_xaxis("top", functions=(to_wavelength, to_wavelength)).set_xlabel(r"wavelength $\lambda$ (µm)")
    known = np.asarray(axes.lines[0].get_ydata() if density is None else density[density > 0], np.float64)
    axes.set_ylim(max(known.min() / 5, 1e-14 * known.max()), 5 * known.max())
    axes.legend(loc="lower left", handlelength=1.5, borderaxespad=0.3, labelspacing=0.3)


def _draw_map(figure: Any, axes: Axes, surface: Surface) -> None:
    unit, size = ("mm", 1e3) if max(surface.extent) >= MILLIMETRES else ("µm", 1.0)
    heights = 1000 * (surface.heights - surface.heights.mean())
    along_y, along_x = (length / size for length in surface.extent)
    lowest, highest = np.quantile(heights, [0.001, 0.999])  # or a grain of dust takes all the colours
    image = axes.imshow(
        heights, extent=(0, along_x, 0, along_y), origin="lower", cmap=HEIGHT_MAP, vmin=lowest, vmax=highest,
        aspect="equal" if 1 / 4 < along_x / along_y < 4 else "auto",
    )  # fmt: skip
    bar = figure.colorbar(image, ax=axes, location="top", extend="both", aspect=30, pad=0.02)
    bar.locator = MaxNLocator(5)
    bar.set_label(f"height (nm), $Sq$ = {length_text(float(surface.heights.std()))}")
    axes.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
