"""Profiles, surfaces, spectra, curves of contact and the onset of sliding drawn into axes of matplotlib."""

from __future__ import annotations

import math
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stiction._checks import Floats

HEIGHT_MAP = "gray"
_FINE = 0.5  # heights (µm) below which they are drawn in nm
_BAR = 0.25  # about how much of the width the bar of the scale takes at most
PRESSURE_MAP = "inferno"
MOST_LINES = 12  # largest number of lines that have a legend


def in_fine_unit(heights: Floats) -> tuple[Floats, str]:
    """Heights in nm where they span little, else in µm, and the unit."""
    return (heights * 1000, "nm") if np.ptp(heights) < _FINE else (heights, "µm")


def draw_profile(ax: Axes, x: Floats, heights: Floats) -> Axes:
    """Heights over x, as they are: the vertical scale is another."""
    heights, unit = in_fine_unit(heights)
    ax.plot(x, heights, color="0.2", linewidth=0.8)
    ax.set(xlim=(0, float(x[-1])), xlabel="x (µm)", ylabel=f"height ({unit})")
    return ax


def draw_surface(ax: Axes, heights: Floats, spacing: tuple[float, float]) -> Axes:
    """A map of heights, each point in the middle of its cell, y upwards."""
    heights, unit = in_fine_unit(heights)
    image = ax.imshow(heights, extent=box_of(heights.shape, spacing), origin="lower", cmap=HEIGHT_MAP)
    colour_bar(ax, image, f"height ({unit})")
    ax.set(xlabel="x (µm)", ylabel="y (µm)")
    return ax


def draw_spectrum(ax: Axes, harmonics: tuple[Floats, Floats], bins: tuple[Floats, Floats]) -> Axes:
    """Wave numbers and density on logarithmic scales, of all harmonics and of their means over bins."""
    wave_number, density = harmonics
    each = density > 0
    if not each.any():
        raise ValueError("the spectrum is 0 everywhere, so there is nothing to draw")
    ax.loglog(wave_number[each], density[each], color="0.75", linewidth=0.6)
    middle, mean = bins
    seen = mean > 0
    ax.loglog(middle[seen], mean[seen], color="0.1", linewidth=1.4)
    # Harmonics of round-off alone would take most of the height.
    top = float(density.max())
    ax.set_ylim(max(float(mean[seen].min()) / 3, 1e-16 * top), 3 * top)
    ax.set_xlabel("wave number q (1/µm)")
    few_ticks(ax)
    ax.set_ylabel("power spectral density C1D (µm³)")
    above = ax.secondary_xaxis("top", functions=(wavelength_of, wavelength_of))
    above.set_xlabel("wavelength (µm)")
    return ax


def draw_repeated(ax: Axes, found: Any) -> Axes:
    """Heights in octaves of the wavelength of what two scans have in common, and of the noise of one."""
    for name, style, label in (("common", "o-", "in both"), ("noise", "s--", "noise of one")):
        heights = 1000 * getattr(found, name)
        ax.loglog(found.wavelength[heights > 0], heights[heights > 0], style, markersize=3, linewidth=1, label=label)
    if math.isfinite(found.limit):
        ax.axvline(found.limit, color="0.5", linewidth=0.8)
    ax.set(xlabel="shortest wavelength of an octave (µm)", ylabel="rms height in it (nm)")
    few_ticks(ax)
    ax.legend()
    return ax


def scale_bar(ax: Axes, box: tuple[float, float, float, float], **style: Any) -> None:
    """A bar of a round length in the lower right corner of a map with these ends: left, right, bottom, top (µm)."""
    from matplotlib.patheffects import withStroke

    left, right, bottom, top = box
    wanted = _BAR * (right - left)
    power = 10.0 ** math.floor(math.log10(wanted))
    length = max(factor * power for factor in (1, 2, 5) if factor * power <= wanted)
    x, y = right - 0.05 * (right - left) - length, bottom + 0.05 * (top - bottom)
    halo = [withStroke(linewidth=2.5, foreground="black")]
    ax.plot([x, x + length], [y, y], color="white", linewidth=1.5, path_effects=halo, solid_capstyle="butt")
    shown = f"{length:g} µm" if length >= 1 else f"{1000 * length:g} nm"
    style |= {"color": "white", "path_effects": halo, "ha": "center", "va": "bottom"}
    ax.text(x + length / 2, y + 0.015 * (top - bottom), shown, **style)


def box_of(shape: tuple[int, ...], spacing: tuple[float, ...]) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of a map whose cells are whole (µm)."""
    return 0.0, shape[1] * spacing[1], 0.0, shape[0] * spacing[0]


def wavelength_of(wave_number: Any) -> Any:
    """Wavelength of a wave number, and the other way round."""
    with np.errstate(divide="ignore"):
        return 2 * math.pi / np.asarray(wave_number, dtype=np.float64)


def colour_bar(ax: Axes, image: Any, text: str) -> None:
    """A bar of colours as high as the map beside it."""
    figure = ax.get_figure()
    assert figure is not None
    figure.colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), label=text)


def few_ticks(axes: Axes) -> None:
    """Give logarithmic scales plain numbers over two decades or less, and powers of ten alone over more than three."""
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


def draw_area(ax: Axes, load: Floats, area: Floats) -> Axes:
    """True area (µm²) against the load (mN)."""
    if not ((load > 0) & (area > 0)).any():
        raise ValueError("nothing touches, so there is nothing to draw")
    ax.set(xscale="log", yscale="log", xlabel="normal load (mN)")
    ax.plot(load, area, color="#009e73", marker="o", markersize=3)
    few_ticks(ax)
    ax.set_ylabel("true contact area (µm²)")
    return ax


def draw_friction(
    ax: Axes, load: Floats, coefficient: Floats, *, mu0: ArrayLike, tau0: ArrayLike, direction: ArrayLike
) -> Axes:
    """Friction coefficients against the load (mN), a line for each material (tau0 in GPa) and direction (degrees)."""
    if not np.isfinite(coefficient).any():
        raise ValueError("no load has a friction coefficient, so there is nothing to draw")
    ax.set(xscale="log", xlabel="normal load (mN)")
    axes = _of_material(mu0, tau0)
    if np.ndim(direction):
        axes.append([f"{angle:g}°" for angle in np.asarray(direction).tolist()])
    names = [", ".join(filter(None, each)) for each in product(*axes)]
    lines = np.reshape(coefficient, (-1, load.size))
    for name, line in zip(names, lines, strict=True):
        ax.plot(load, line, marker="o", markersize=3, label=name)
    ax.set_ylabel("coefficient of static friction")
    few_ticks(ax)
    if 1 < len(lines) <= MOST_LINES:
        ax.legend(frameon=False, fontsize="small")
    return ax


def _of_material(mu0: ArrayLike, tau0: ArrayLike) -> list[list[str]]:
    """Names along the axes of mu0 and tau0, which are broadcast against each other."""
    both = np.broadcast_arrays(np.asarray(mu0, dtype=np.float64), np.asarray(tau0, dtype=np.float64))
    if both[0].ndim == 0:
        return []
    pairs = zip(both[0].ravel().tolist(), both[1].ravel().tolist(), strict=True)
    return [[f"μ0 = {rub:g}" + (f", τ0 = {1000 * stick:g} MPa" if stick else "") for rub, stick in pairs]]


def draw_contact(ax: Axes, pressure: Floats, heights: Floats, spacing: tuple[float, ...]) -> Axes:
    """Pressure (GPa) over the heights of the lower body: a map with a bar for its scale, or both along a line."""
    if pressure.ndim == 1:
        return _draw_line(ax, pressure, heights, spacing[-1])
    box = box_of(pressure.shape, spacing)
    ax.imshow(heights, extent=box, origin="lower", cmap="gray")
    pressed = np.where(pressure > 0, pressure, np.nan)
    image = ax.imshow(pressed, extent=box, origin="lower", cmap=PRESSURE_MAP, vmin=0, interpolation="nearest")
    colour_bar(ax, image, "pressure (GPa)")
    ax.set(xticks=[], yticks=[])
    scale_bar(ax, box)
    return ax


def _draw_line(ax: Axes, pressure: Floats, heights: Floats, spacing: float) -> Axes:
    x = np.arange(pressure.size) * spacing
    heights, unit = in_fine_unit(heights)
    ax.plot(x, heights, color="0.6", linewidth=0.8)
    ax.set_xlabel("x (µm)")
    ax.set_ylabel(f"height of the lower body ({unit})", color="0.4")
    other = ax.twinx()
    other.fill_between(x, pressure, color="#d55e00", linewidth=0.8, step="mid")
    other.set_ylim(bottom=0)
    other.set_ylabel("pressure (GPa)", color="#d55e00")
    return ax


def draw_onset(
    ax: Axes, load: Floats, displacement: Floats, slipped_area: Floats, *, sliding_load: float, stiffness: float
) -> Axes:
    """Tangential load against displacement; against the slipped area where there is no displacement."""
    has_displacement = bool(np.isfinite(displacement).all())
    along = displacement if has_displacement else slipped_area
    text = "slipped fraction of the area"
    if has_displacement:
        along, unit = in_fine_unit(along)
        text = f"displacement ({unit})"
        elastic = sliding_load / stiffness * (1000 if unit == "nm" else 1)
        ax.plot([0, elastic], [0, sliding_load], color="0.6", linewidth=0.8, label="all sticks")
    ax.plot(np.concatenate([[0.0], along]), np.concatenate([[0.0], load]), marker="o", markersize=3)
    ax.axhline(sliding_load, color="0.3", linewidth=0.8, linestyle="--", label="slides")
    ax.set(xlabel=text, ylabel="tangential load (mN)")
    ax.legend(frameon=False, fontsize="small", loc="lower right")
    return ax
