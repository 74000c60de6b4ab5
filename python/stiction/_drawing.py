"""Plots of profiles, surfaces, spectra, contacts and onset curves with Matplotlib."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stiction._checks import Floats

HEIGHT_COLOUR_MAP = "gray"
_MAX_HEIGHT_RANGE_IN_NANOMETRES = 0.5  # µm
_MAX_SCALE_BAR_FRACTION = 0.25
PRESSURE_COLOUR_MAP = "inferno"
MAX_LEGEND_LINES = 12


def to_readable_height_unit(heights: Floats) -> tuple[Floats, str]:
    """Convert heights in µm to nm if their range is below 0.5 µm. Return the heights and the name of their unit."""
    return (heights * 1000, "nm") if np.ptp(heights) < _MAX_HEIGHT_RANGE_IN_NANOMETRES else (heights, "µm")


def draw_profile(ax: Axes, x: Floats, heights: Floats) -> Axes:
    """Draw the heights of a profile against x. The two axes have different scales."""
    heights, unit = to_readable_height_unit(heights)
    ax.plot(x, heights, color="0.2", linewidth=0.8)
    ax.set(xlim=(0, float(x[-1])), xlabel="x (µm)", ylabel=f"height ({unit})")
    return ax


def draw_surface(ax: Axes, heights: Floats, spacing: tuple[float, float]) -> Axes:
    """Draw a height map as an image with the y axis upwards. Each pixel is centred on a grid point."""
    heights, unit = to_readable_height_unit(heights)
    image = ax.imshow(heights, extent=map_extent(heights.shape, spacing), origin="lower", cmap=HEIGHT_COLOUR_MAP)
    add_colour_bar(ax, image, f"height ({unit})")
    ax.set(xlabel="x (µm)", ylabel="y (µm)")
    return ax


def draw_spectrum(ax: Axes, harmonics: tuple[Floats, Floats], bins: tuple[Floats, Floats]) -> Axes:
    """Draw a power spectral density on logarithmic axes: one curve of all harmonics, and one of means over bins."""
    wave_number, density = harmonics
    is_positive = density > 0
    if not is_positive.any():
        raise ValueError("the spectrum must not be 0 everywhere, because there would be nothing to draw")
    ax.loglog(wave_number[is_positive], density[is_positive], color="0.75", linewidth=0.6)
    bin_wave_number, bin_density = bins
    is_positive_bin = bin_density > 0
    ax.loglog(bin_wave_number[is_positive_bin], bin_density[is_positive_bin], color="0.1", linewidth=1.4)
    # Without a lower limit, densities that are only round-off would fill most of the axis.
    max_density = float(density.max())
    ax.set_ylim(max(float(bin_density[is_positive_bin].min()) / 3, 1e-16 * max_density), 3 * max_density)
    ax.set_xlabel("wave number q (1/µm)")
    set_log_tick_labels(ax)
    ax.set_ylabel("power spectral density C1D (µm³)")
    wavelength_axis = ax.secondary_xaxis("top", functions=(wave_number_to_wavelength, wave_number_to_wavelength))
    wavelength_axis.set_xlabel("wavelength (µm)")
    return ax


def draw_scan_comparison(ax: Axes, comparison: Any) -> Axes:
    """Draw, for each wavelength octave, the rms height common to two scans and the rms noise of a single scan."""
    for name, style, label in (("common", "o-", "in both"), ("noise", "s--", "noise of one")):
        heights = 1000 * getattr(comparison, name)
        ax.loglog(
            comparison.wavelength[heights > 0], heights[heights > 0], style, markersize=3, linewidth=1, label=label
        )
    if math.isfinite(comparison.limit):
        ax.axvline(comparison.limit, color="0.5", linewidth=0.8)
    ax.set(xlabel="shortest wavelength of an octave (µm)", ylabel="rms height in the octave (nm)")
    set_log_tick_labels(ax)
    ax.legend()
    return ax


def add_scale_bar(ax: Axes, box: tuple[float, float, float, float], **style: Any) -> None:
    """Draw a scale bar with a round length in the lower right corner of a map.

    `box` contains the edges of the map's image (µm).
    """
    from matplotlib.patheffects import withStroke

    left, right, bottom, top = box
    max_length = _MAX_SCALE_BAR_FRACTION * (right - left)
    power_of_ten = 10.0 ** math.floor(math.log10(max_length))
    length = max(factor * power_of_ten for factor in (1, 2, 5) if factor * power_of_ten <= max_length)
    x, y = right - 0.05 * (right - left) - length, bottom + 0.05 * (top - bottom)
    white_outline = [withStroke(linewidth=2.5, foreground="black")]
    ax.plot([x, x + length], [y, y], color="white", linewidth=1.5, path_effects=white_outline, solid_capstyle="butt")
    unit_length, unit = (1000.0, "mm") if length >= 1000 else (1.0, "µm") if length >= 1 else (0.001, "nm")
    length_text = f"{length / unit_length:g} {unit}"
    style |= {"color": "white", "path_effects": white_outline, "ha": "center", "va": "bottom"}
    ax.text(x + length / 2, y + 0.015 * (top - bottom), length_text, **style)


def map_extent(
    shape: tuple[int, ...], spacing: tuple[float, ...], first_point: tuple[float, float] = (0.0, 0.0)
) -> tuple[float, float, float, float]:
    """Return the edges (left, right, bottom, top; µm) of an image whose pixels are centred on the points of a map.

    `first_point` contains the coordinates y and x (µm) of the first grid point.
    """
    (bottom, top), (left, right) = (
        (start - 0.5 * step, start + (count - 0.5) * step)
        for count, step, start in zip(shape, spacing, first_point, strict=True)
    )
    return left, right, bottom, top


def wave_number_to_wavelength(wave_number: Any) -> Any:
    """Convert wave numbers q (1/µm) to wavelengths λ (µm) by λ = 2π/q, or wavelengths to wave numbers."""
    with np.errstate(divide="ignore"):
        return 2 * math.pi / np.asarray(wave_number, dtype=np.float64)


def add_colour_bar(ax: Axes, image: Any, text: str) -> None:
    """Add a colour bar with the label `text` to the right of an image."""
    figure = ax.get_figure()
    assert figure is not None
    figure.colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), label=text)


def set_log_tick_labels(axes: Axes) -> None:
    """Label logarithmic axes with plain numbers if they span up to three decades, or else with powers of ten."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    for axis in (axes.xaxis, axes.yaxis):
        if axis.get_scale() != "log":
            continue
        low, high = axis.get_view_interval()
        if high > 1e3 * low:
            axis.set_major_locator(LogLocator(numticks=8))
            axis.set_minor_locator(NullLocator())
        elif low >= 1e-4 and high <= 1e5:
            subs = (1.0,) if high > 100 * low else (1.0, 3.0) if high > 20 * low else (1.0, 2.0, 5.0)
            axis.set_major_locator(LogLocator(subs=subs))
            axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
            axis.set_minor_locator(NullLocator())


# ---- Contact ---------------------------------------------------------------------------------------------------------


def draw_contact_area(ax: Axes, load: Floats, area: Floats) -> Axes:
    """Draw the true contact area (µm²) against the normal load (mN)."""
    if not ((load > 0) & (area > 0)).any():
        raise ValueError("the surfaces do not touch at any load, so there is nothing to draw")
    ax.set(xscale="log", yscale="log", xlabel="normal load (mN)")
    ax.plot(load, area, color="#009e73", marker="o", markersize=3)
    set_log_tick_labels(ax)
    ax.set_ylabel("true contact area (µm²)")
    return ax


def draw_friction(
    ax: Axes, load: Floats, coefficient: Floats, *, mu0: ArrayLike, tau0: ArrayLike, direction: ArrayLike
) -> Axes:
    """Draw friction coefficients against the load (mN): one curve per combination of direction, mu0 and tau0."""
    if not np.isfinite(coefficient).any():
        raise ValueError("no load has a friction coefficient, so there is nothing to draw")
    ax.set(xscale="log", xlabel="normal load (mN)")
    label_lists = _friction_parameter_labels(mu0, tau0)
    if np.ndim(direction):
        label_lists.append([f"{angle:g}°" for angle in np.asarray(direction).tolist()])
    legend_labels = [", ".join(filter(None, labels)) for labels in product(*label_lists)]
    curves = np.reshape(coefficient, (-1, load.size))
    for legend_label, curve in zip(legend_labels, curves, strict=True):
        ax.plot(load, curve, marker="o", markersize=3, label=legend_label)
    ax.set_ylabel("coefficient of static friction")
    set_log_tick_labels(ax)
    if 1 < len(curves) <= MAX_LEGEND_LINES:
        ax.legend(frameon=False, fontsize="small")
    return ax


def _friction_parameter_labels(mu0: ArrayLike, tau0: ArrayLike) -> list[list[str]]:
    """Return a legend label for each pair of mu0 and tau0.

    Returns an empty list for a single pair.
    """
    parameters = np.broadcast_arrays(np.asarray(mu0, dtype=np.float64), np.asarray(tau0, dtype=np.float64))
    if parameters[0].ndim == 0:
        return []
    pairs = zip(parameters[0].ravel().tolist(), parameters[1].ravel().tolist(), strict=True)
    return [
        [
            f"μ0 = {mu0_value:g}" + (f", τ0 = {1000 * tau0_value:g} MPa" if tau0_value else "")
            for mu0_value, tau0_value in pairs
        ]
    ]


def draw_contact_pressure(ax: Axes, pressure: Floats, heights: Floats, spacing: tuple[float, ...]) -> Axes:
    """Draw the contact pressure (GPa) and the lower surface's heights: maps for surfaces, curves for profiles."""
    if pressure.ndim == 1:
        return _draw_profile_contact_pressure(ax, pressure, heights, spacing[-1])
    extent = map_extent(pressure.shape, spacing)
    ax.imshow(heights, extent=extent, origin="lower", cmap="gray")
    positive_pressure = np.where(pressure > 0, pressure, np.nan)
    image = ax.imshow(
        positive_pressure, extent=extent, origin="lower", cmap=PRESSURE_COLOUR_MAP, vmin=0, interpolation="nearest"
    )
    add_colour_bar(ax, image, "pressure (GPa)")
    ax.set(xticks=[], yticks=[])
    add_scale_bar(ax, extent)
    return ax


def _draw_profile_contact_pressure(ax: Axes, pressure: Floats, heights: Floats, spacing: float) -> Axes:
    x = np.arange(pressure.size) * spacing
    heights, unit = to_readable_height_unit(heights)
    ax.plot(x, heights, color="0.6", linewidth=0.8)
    ax.set_xlabel("x (µm)")
    ax.set_ylabel(f"height of the lower surface ({unit})", color="0.4")
    pressure_axes = ax.twinx()
    pressure_axes.fill_between(x, pressure, color="#d55e00", linewidth=0.8, step="mid")
    pressure_axes.set_ylim(bottom=0)
    pressure_axes.set_ylabel("pressure (GPa)", color="#d55e00")
    return ax


def draw_onset(
    ax: Axes, load: Floats, displacement: Floats, slipped_area: Floats, *, sliding_load: float, stiffness: float
) -> Axes:
    """Plot tangential load against displacement or, if displacements are infinite, against slipped area fraction."""
    has_displacement = bool(np.isfinite(displacement).all())
    abscissa = displacement if has_displacement else slipped_area
    axis_label = "slipped fraction of the area"
    if has_displacement:
        abscissa, unit = to_readable_height_unit(abscissa)
        axis_label = f"displacement ({unit})"
        elastic_displacement = sliding_load / stiffness * (1000 if unit == "nm" else 1)
        ax.plot([0, elastic_displacement], [0, sliding_load], color="0.6", linewidth=0.8, label="all sticks")
    ax.plot(np.concatenate([[0.0], abscissa]), np.concatenate([[0.0], load]), marker="o", markersize=3)
    ax.axhline(sliding_load, color="0.3", linewidth=0.8, linestyle="--", label="slides")
    ax.set(xlabel=axis_label, ylabel="tangential load (mN)")
    ax.legend(frameon=False, fontsize="small", loc="lower right")
    return ax
