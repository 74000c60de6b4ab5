"""Profiles, surfaces and spectra drawn into axes of matplotlib."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from stiction._checks import Floats

HEIGHT_MAP = "cividis"

_FINE = 0.5
"""Heights (µm) below which they are drawn in nm."""

_BAR = 0.3
"""About how much of the width the bar of the scale takes at most."""


def in_fine_unit(heights: Floats) -> tuple[Floats, str]:
    """Heights in nm where they span little, else in µm, and the unit."""
    return (heights * 1000, "nm") if np.ptp(heights) < _FINE else (heights, "µm")


def draw_profile(ax: Axes, x: Floats, heights: Floats) -> Axes:
    """Heights over x, as they are: the vertical scale is another."""
    heights, unit = in_fine_unit(heights)
    ax.plot(x, heights, color="0.2", linewidth=0.8)
    ax.set_xlim(0, float(x[-1]))
    ax.set_xlabel("x (µm)")
    ax.set_ylabel(f"height ({unit})")
    return ax


def draw_surface(ax: Axes, heights: Floats, spacing: tuple[float, float]) -> Axes:
    """A map of heights, each point in the middle of its cell, y upwards."""
    heights, unit = in_fine_unit(heights)
    image = ax.imshow(heights, extent=box_of(heights.shape, spacing), origin="lower", cmap=HEIGHT_MAP)
    colour_bar(ax, image, f"height ({unit})")
    ax.set_xlabel("x (µm)")
    ax.set_ylabel("y (µm)")
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
    plain_ticks(ax.xaxis, float(middle[0]), float(middle[-1]))
    ax.set_ylabel("power spectral density C1D (µm³)")
    above = ax.secondary_xaxis("top", functions=(_wavelength, _wavelength))
    above.set_xlabel("wavelength (µm)")
    return ax


def scale_bar(ax: Axes, width: float, height: float) -> None:
    """A bar of a round length in the lower right corner of a map that begins at (0, 0) and is so large (µm)."""
    from matplotlib.patheffects import withStroke

    wanted = _BAR * width
    power = 10.0 ** math.floor(math.log10(wanted))
    length = max(factor * power for factor in (1, 2, 5) if factor * power <= wanted)
    x, y = 0.95 * width - length, 0.06 * height
    halo = [withStroke(linewidth=3, foreground="black")]
    ax.plot([x, x + length], [y, y], color="white", linewidth=2, path_effects=halo, solid_capstyle="butt")
    shown = f"{length:g} µm" if length >= 1 else f"{1000 * length:g} nm"
    ax.text(x + length / 2, y + 0.02 * height, shown, color="white", path_effects=halo, ha="center", va="bottom")


def box_of(shape: tuple[int, ...], spacing: tuple[float, ...]) -> tuple[float, float, float, float]:
    """Left, right, bottom and top of a map whose cells are whole (µm)."""
    return 0.0, shape[1] * spacing[1], 0.0, shape[0] * spacing[0]


def _wavelength(wave_number: Any) -> Any:
    with np.errstate(divide="ignore"):
        return 2 * math.pi / np.asarray(wave_number, dtype=np.float64)


def colour_bar(ax: Axes, image: Any, text: str) -> None:
    """A bar of colours as high as the map beside it."""
    figure = ax.get_figure()
    assert figure is not None
    figure.colorbar(image, cax=ax.inset_axes((1.03, 0.0, 0.04, 1.0)), label=text)


def plain_ticks(axis: Any, low: float, high: float) -> None:
    """Give a logarithmic axis of less than two decades plain numbers."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

    if high < 100 * low:
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0) if high < 10 * low else (1.0, 3.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_locator(NullLocator())
