"""Figure of a measured profile or surface: heights, their distribution, and spectra."""

from __future__ import annotations

import math
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from stiction._checks import Floats
from stiction._drawing import HEIGHT_COLOUR_MAP, map_extent, wave_number_to_wavelength
from stiction._number_format import choose_prefixed_unit
from stiction.summary.characterisation import Characterisation
from stiction.surfaces.lines import LineRoughness
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface
from stiction.views.characterisation import length_text, to_characterisation
from stiction.views.style import MAP_AXIS_COLOURS, MATPLOTLIB_STYLE, MIN_LENGTH_IN_MILLIMETRES, PAGE_WIDTH, new_figure

# Maximum number of points of a drawn profile; neighbouring points of a longer profile are averaged.
MAX_DRAWN_PROFILE_POINTS = 1500
NUM_HEIGHT_BINS = 40
MEASURED_SPECTRUM_COLOUR, FITTED_LINE_COLOUR = "#0072b2", "#d55e00"
TICK_STEPS = (1, 1.5, 2, 2.5, 3, 4, 5, 6, 8, 10)


def characterisation_figure(body: Profile | Surface | Characterisation, **options: Any) -> Figure:
    """Draw heights, height distribution and spectra, 80 mm wide for a profile and 170 mm wide for a surface.

    Options are the same as for `characterisation_text`.
    """
    characterisation = to_characterisation(body, **options)
    with mpl.rc_context(MATPLOTLIB_STYLE):
        if isinstance(characterisation.body, Profile):
            figure = new_figure(88)
            upper_subfigure, lower_subfigure = figure.subfigures(2, 1, squeeze=False, height_ratios=[1, 1.7])[:, 0]
            axes = upper_subfigure.subplot_mosaic([["heights", "distribution"]], width_ratios=[1.7, 1])
            axes |= lower_subfigure.subplot_mosaic([["spectrum"]])
            _draw_profile_heights(axes["heights"], characterisation.body)
        else:
            figure = new_figure(112, width=PAGE_WIDTH)
            upper_subfigure, lower_subfigure = figure.subfigures(1, 2, squeeze=False, width_ratios=[1, 1.1])[0]
            axes = upper_subfigure.subplot_mosaic([["heights"], ["distribution"]], height_ratios=[2, 1])
            axes |= lower_subfigure.subplot_mosaic([["spectrum"], ["lines"]])
            _draw_height_map(upper_subfigure, axes["heights"], characterisation.body)
            for line, colour in zip(characterisation.line_roughnesses, MAP_AXIS_COLOURS.items(), strict=True):
                _draw_line_spectrum(axes["lines"], line, *colour)
            _format_spectrum_axes(axes["lines"], "µm³")
        _draw_spectrum(axes["spectrum"], characterisation)
        _draw_height_distribution(axes["distribution"], characterisation.body.heights)
    return figure


def _draw_profile_heights(axes: Axes, profile: Profile) -> None:
    """Draw the heights of a profile.

    In a long profile, each drawn height is a mean with the range of several points.
    """
    group_size = -(-len(profile) // MAX_DRAWN_PROFILE_POINTS)
    heights = profile.heights - profile.heights.min()
    height_factor, height_unit = choose_prefixed_unit(float(np.ptp(heights)), "um")
    height_groups = np.pad(heights / height_factor, (0, -len(profile) % group_size), mode="edge").reshape(
        -1, group_size
    )
    x = profile.spacing * (group_size * np.arange(len(height_groups)) + (group_size - 1) / 2)
    unit, unit_length = ("mm", 1000) if x[-1] >= MIN_LENGTH_IN_MILLIMETRES else ("µm", 1)
    axes.plot(x / unit_length, height_groups.mean(axis=1), color=MEASURED_SPECTRUM_COLOUR, linewidth=0.7)
    if group_size > 1:
        height_ranges = height_groups.min(axis=1), height_groups.max(axis=1)
        axes.fill_between(x / unit_length, *height_ranges, color=MEASURED_SPECTRUM_COLOUR, alpha=0.4, linewidth=0)
    axes.set(xlabel=f"position $x$ ({unit})", ylabel=f"height ({height_unit})")
    axes.locator_params(nbins=4, steps=TICK_STEPS)


def _draw_height_distribution(axes: Axes, heights: Floats) -> None:
    height_factor, height_unit = choose_prefixed_unit(float(np.ptp(heights)), "um")
    deviations = (heights - heights.mean()).ravel() / height_factor
    rms_height = float(deviations.std())
    density, bin_edges = np.histogram(deviations, NUM_HEIGHT_BINS, density=True)
    x = (bin_edges[1:] + bin_edges[:-1]) / 2
    axes.plot(x, density, color=MEASURED_SPECTRUM_COLOUR, linewidth=0.7)
    normal_density = np.exp(-((x / rms_height) ** 2) / 2) / (rms_height * math.sqrt(2 * math.pi))
    axes.plot(x, normal_density, "--", color=FITTED_LINE_COLOUR, linewidth=1.2)
    axes.set(xlabel=f"height ({height_unit})", ylabel=f"density (1/{height_unit})")
    axes.set_title("dashed: Gaussian", fontsize=6, pad=2)
    axes.locator_params(nbins=4, steps=TICK_STEPS)
    axes.locator_params(axis="x", nbins=3)


def _draw_spectrum(axes: Axes, result: Characterisation) -> None:
    if result.spectrum is not None:
        has_power = result.spectrum.density > 0
        axes.plot(
            result.spectrum.wave_number[has_power], result.spectrum.density[has_power], ".", color="0.8", markersize=1,
            markeredgewidth=0, rasterized=True, label="harmonics",
        )  # fmt: skip
    has_power = result.binned_spectrum.density > 0
    axes.plot(
        result.binned_spectrum.wave_number[has_power],
        result.binned_spectrum.density[has_power],
        color=MEASURED_SPECTRUM_COLOUR,
        linewidth=0.6,
        marker="o",
        markersize=2,
        label="measured",
    )
    law, is_profile = result.valid_power_law, result.spectrum is not None
    if law is None:
        note = "no self-affine band found" if result.power_law_fit is None else "no power law"
    else:
        q = np.geomspace(2 * math.pi / law.longest_wavelength, 2 * math.pi / law.shortest_wavelength, 40)
        name = f"$q^{{-{2 - is_profile}-2H}}$, $H$ = {law.value:.2f} [{law.lower:.2f}, {law.upper:.2f}]"
        axes.plot(q, law.density(q), "--", color=FITTED_LINE_COLOUR, linewidth=1.2, label=name)
        axes.axvspan(q[0], q[-1], color=FITTED_LINE_COLOUR, alpha=0.12, linewidth=0, label="fitted band")
        classical_text = f"{law.fractal_dimension_classical:.2f} (classical), " if law.value <= 1 else ""
        note = f"$D$ = {classical_text}{law.fractal_dimension_paper:.2f} (paper)"
    axes.plot([], [], " ", label=note)
    _format_spectrum_axes(axes, "µm³" if is_profile else "µm⁴", result.binned_spectrum.density)


def _draw_line_spectrum(axes: Axes, line: LineRoughness, axis: str, colour: str) -> None:
    spectrum = line.spectrum.in_bins()
    has_power = spectrum.density > 0
    axes.plot(
        spectrum.wave_number[has_power], spectrum.density[has_power], color=colour, linewidth=0.7, label=f"along {axis}"
    )
    if line.is_straight and line.band is not None:
        exponent, exponent_scatter = float(line.hurst_exponents.mean()), float(line.hurst_exponents.std())
        min_wave_number, max_wave_number = (2 * math.pi / end for end in line.band[::-1])
        is_in_band = has_power & (spectrum.wave_number >= min_wave_number) & (spectrum.wave_number <= max_wave_number)
        mean_log_factor = np.log(
            spectrum.wave_number[is_in_band] ** (1 + 2 * exponent) * spectrum.density[is_in_band]
        ).mean()
        q = np.geomspace(min_wave_number, max_wave_number, 40)
        name = f"$q^{{-1-2H}}$, $H$ = {exponent:.2f} ± {exponent_scatter:.2f}"
        axes.plot(q, np.exp(mean_log_factor) * q ** (-1 - 2 * exponent), "--", color=colour, linewidth=1.2, label=name)


def _format_spectrum_axes(axes: Axes, unit: str, density: Floats | None = None) -> None:
    """Format the axes of a drawn spectrum, add a second axis for the wavelength, and add a legend."""
    axes.set(xscale="log", yscale="log", xlabel="wave number $q$ (1/µm)", ylabel=f"density $C$ ({unit})")
    axes.secondary_xaxis("top", functions=(wave_number_to_wavelength, wave_number_to_wavelength)).set_xlabel(
        r"wavelength $\lambda$ (µm)"
    )
    density_values = np.asarray(axes.lines[0].get_ydata() if density is None else density[density > 0], np.float64)
    axes.set_ylim(max(density_values.min() / 5, 1e-14 * density_values.max()), 5 * density_values.max())
    axes.legend(loc="lower left", handlelength=1.5, borderaxespad=0.3, labelspacing=0.3)


def _draw_height_map(figure: Any, axes: Axes, surface: Surface) -> None:
    unit, unit_length = ("mm", 1e3) if max(surface.extent) >= MIN_LENGTH_IN_MILLIMETRES else ("µm", 1.0)
    height_factor, height_unit = choose_prefixed_unit(float(np.ptp(surface.heights)), "um")
    heights = (surface.heights - surface.heights.mean()) / height_factor
    left, right, bottom, top = (edge / unit_length for edge in map_extent(surface.heights.shape, surface.spacing))
    aspect_ratio = (right - left) / (top - bottom)
    # The colour scale ends at quantiles of the heights, because single dust grains would otherwise determine its range.
    lowest_height, highest_height = np.quantile(heights, [0.001, 0.999])
    image = axes.imshow(
        heights, extent=(left, right, bottom, top), origin="lower", cmap=HEIGHT_COLOUR_MAP, vmin=lowest_height,
        vmax=highest_height, aspect="equal" if 1 / 4 < aspect_ratio < 4 else "auto",
    )  # fmt: skip
    colour_bar = figure.colorbar(image, ax=axes, location="top", extend="both", aspect=30, pad=0.02)
    colour_bar.locator = MaxNLocator(5)
    colour_bar.set_label(f"height ({height_unit}), $Sq$ = {length_text(float(surface.heights.std()))}")
    axes.set(xlabel=f"$x$ ({unit})", ylabel=f"$y$ ({unit})")
