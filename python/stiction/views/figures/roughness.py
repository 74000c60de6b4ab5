"""Figures of one measured profile or surface: its heights, how they are distributed, and its spectrum."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.lines import LineRoughness
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import RoughnessParameters, roughness_parameters
from stiction.surfaces.spectrum import power_spectrum, surface_spectrum
from stiction.surfaces.surface import Surface
from stiction.views.characterisation import RADIAL_BINS, estimate_of, length_text
from stiction.views.style import AXES, FULL_WIDTH, HEIGHT_MAP, MILLIMETRE, STYLE, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_LINE = "#0072b2"
"""What was measured."""

_FIT = "#d55e00"
"""What was fitted to it."""

_MILLIMETRES = 1000.0
"""Lengths (µm) from which on an axis is in mm."""


def characterisation_figure(
    profile: Profile, *, band: tuple[float, float] | None = None, periodic: bool = False
) -> Figure:
    """A profile, the distribution of its heights, and its spectrum with the fitted power law; 80 mm wide.

    The parameters are those of `characterisation_text`.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    parameters = roughness_parameters(profile)
    estimate = estimate_of(profile, band, periodic)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 88 * MILLIMETRE), layout="constrained")
        top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=[1, 1.7])[:, 0]
        line, heights = top.subplots(1, 2, width_ratios=[2.6, 1], sharey=True)
        _profile_panel(line, profile, parameters)
        _heights_panel(heights, profile.heights)
        _spectrum_panel(bottom.subplots(), profile, estimate, periodic)
    return figure


def _profile_panel(axes: Axes, profile: Profile, parameters: RoughnessParameters) -> None:
    unit, size = ("mm", 1e3) if profile.extent >= _MILLIMETRES else ("µm", 1.0)
    axes.plot(profile.x / size, _in_height_unit(profile.heights)[0], color=_LINE, linewidth=0.4, rasterized=True)
    axes.set_xlim(0, profile.extent / size)
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_title(
        f"$Pq$ = {length_text(parameters.Pq)}, $Psk$ = ${parameters.Psk:.2f}$, $Pku$ = {parameters.Pku:.2f}",
        fontsize=6, loc="left", pad=2,
    )  # fmt: skip
    axes.set_ylabel(f"height ({_in_height_unit(profile.heights)[1]})")


def _in_height_unit(heights: Floats) -> tuple[Floats, str]:
    """Heights about their mean, in a unit in which they are no long numbers."""
    heights = heights - heights.mean()
    return (1000 * heights, "nm") if np.abs(heights).max() < 0.5 else (heights, "µm")


def _heights_panel(axes: Axes, heights: Floats, *, across: bool = True) -> None:
    """How heights are distributed, with heights up the page beside a profile, or across it."""
    from matplotlib.ticker import MaxNLocator

    heights, unit = _in_height_unit(heights.ravel())
    rms = float(np.sqrt(np.mean(heights**2)))
    axes.hist(
        heights, bins=_HEIGHT_BINS, density=True, orientation="horizontal" if across else "vertical", color="0.75"
    )
    at = np.linspace(heights.min(), heights.max(), 200)
    normal = np.exp(-((at / rms) ** 2) / 2) / (rms * math.sqrt(2 * math.pi))
    axes.plot(*((normal, at) if across else (at, normal)), color=_FIT, linewidth=0.8)
    density, other = (axes.xaxis, axes.yaxis) if across else (axes.yaxis, axes.xaxis)
    density.set_label_text(f"density (1/{unit})")
    density.set_major_locator(MaxNLocator(2))
    density.set_major_formatter("{x:g}")
    axes.set_title("line: Gaussian\nof the same rms" if across else "line: Gaussian of the same rms", fontsize=6, pad=2)
    if across:
        axes.tick_params(labelleft=False)
    else:
        other.set_label_text(f"height ({unit})")


_HEIGHT_BINS = 40


def _spectrum_panel(axes: Axes, profile: Profile, estimate: HurstEstimate | None, periodic: bool) -> None:
    spectrum = power_spectrum(profile, periodic=periodic)
    shown = spectrum.density > 0
    lowest = float(np.quantile(spectrum.density[shown], 0.01))
    axes.loglog(
        spectrum.wave_number[shown], spectrum.density[shown], ".", color="0.75", markersize=1, markeredgewidth=0,
        rasterized=True,
    )  # fmt: skip
    axes.plot([], [], ".", color="0.75", markersize=4, markeredgewidth=0, label="harmonics")
    binned = spectrum.in_bins()
    lowest = min(lowest, float(binned.density[binned.density > 0].min()))
    axes.plot(
        binned.wave_number,
        binned.density,
        "o-",
        color=_LINE,
        markersize=2,
        linewidth=0.6,
        label="means, ten to a decade",
    )
    axes.set_ylim(max(lowest / 3, 1e-14 * spectrum.density.max()), 3 * spectrum.density.max())
    _label_spectrum(axes)
    _fitted_line(axes, estimate, "q^{-1-2H}")
    axes.legend(loc="lower left", handlelength=1.5, borderaxespad=0.3, labelspacing=0.3)


def _label_spectrum(axes: Axes, density: str = "$C^{1D}$ (µm³)") -> None:
    from matplotlib.ticker import NullFormatter

    axes.set_xlabel("wave number $q = 2\\pi/\\lambda$ (1/µm)")
    axes.set_ylabel(density)
    wavelength = axes.secondary_xaxis("top", functions=(_other, _other))
    wavelength.set_xlabel(r"wavelength $\lambda$ (µm)")
    lowest, highest = axes.get_xlim()
    if highest > 10 * lowest:  # the powers of ten are enough, and the others would overlap
        for axis in (axes.xaxis, wavelength.xaxis):
            axis.set_minor_formatter(NullFormatter())


def surface_characterisation_figure(
    surface: Surface, along_x: LineRoughness, along_y: LineRoughness, *, band: tuple[float, float] | None = None
) -> Figure:
    """A map of a surface and the distribution of its heights; beside them its radial spectrum and that of its lines.

    170 mm wide.

    The parameters are those of `surface_characterisation_text`.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(FULL_WIDTH, 112 * MILLIMETRE), layout="constrained")
        left, right = figure.subfigures(1, 2, squeeze=False, width_ratios=[1, 1.1])[0]
        image, heights = left.subplots(2, 1, height_ratios=[2, 1])
        _map_panel(left, image, surface)
        _heights_panel(heights, surface.heights, across=False)
        radial, lines = right.subplots(2, 1)
        _radial_panel(radial, surface, estimate_of(surface, band, False))
        _line_spectra_panel(lines, along_x, along_y)
    return figure


def _radial_panel(axes: Axes, surface: Surface, estimate: HurstEstimate | None) -> None:
    radial = surface_spectrum(surface).radial(RADIAL_BINS)
    shown = radial.density > 0
    axes.loglog(
        radial.wave_number[shown], radial.density[shown], "o-", color=_LINE, markersize=2, linewidth=0.6,
        label="mean over directions",
    )  # fmt: skip
    _fitted_line(axes, estimate, "q^{-2-2H}")
    _label_spectrum(axes, "$C^{2D}$ (µm⁴)")
    axes.legend(loc="lower left", handlelength=1.5, borderaxespad=0.3, labelspacing=0.3)


def _fitted_line(axes: Axes, estimate: HurstEstimate | None, law: str) -> None:
    if estimate is None:
        axes.plot([], [], " ", label="no self-affine band found")
        return
    ends = 2 * math.pi / np.array([estimate.longest_wavelength, estimate.shortest_wavelength])
    axes.axvspan(*ends, color=_FIT, alpha=0.12, linewidth=0, label="fitted band")
    interval = f"[{estimate.lower:.2f}, {estimate.upper:.2f}]"
    axes.plot(
        ends, estimate.density(ends), "--", color=_FIT, linewidth=1.2,
        label=f"${law}$, $H$ = {estimate.value:.2f} {interval}",
    )  # fmt: skip
    classical = f"{estimate.fractal_dimension_classical:.2f} (classical), " if estimate.value <= 1 else ""
    axes.plot([], [], " ", label=f"$D$ = {classical}{estimate.fractal_dimension_paper:.2f} (paper)")


def _map_panel(figure: Any, axes: Axes, surface: Surface) -> None:
    from matplotlib.ticker import MaxNLocator

    unit, size = ("mm", 1e3) if max(surface.extent) >= _MILLIMETRES else ("µm", 1.0)
    heights, height_unit = _in_height_unit(surface.heights)
    along_y, along_x = (length / size for length in surface.extent)
    lowest, highest = np.quantile(heights, [0.001, 0.999])  # or a grain of dust takes all the colours
    image = axes.imshow(
        heights, extent=(0, along_x, 0, along_y), origin="lower", cmap=HEIGHT_MAP, vmin=lowest, vmax=highest,
        aspect="equal" if 1 / 4 < along_x / along_y < 4 else "auto",
    )  # fmt: skip
    bar = figure.colorbar(image, ax=axes, location="top", extend="both", aspect=30, pad=0.02)
    bar.locator = MaxNLocator(5)
    bar.set_label(f"height ({height_unit}), $Sq$ = {length_text(float(surface.heights.std()))}")
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_ylabel(f"$y$ ({unit})")


def _line_spectra_panel(axes: Axes, along_x: LineRoughness, along_y: LineRoughness) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for name, colour, line in (("x", AXES["x"], along_x), ("y", AXES["y"], along_y)):
        spectrum = line.spectrum
        shown = spectrum.density > 0
        axes.plot(
            spectrum.wave_number[shown], spectrum.density[shown], color=colour, linewidth=0.7,
            label=f"mean of {line.lines} lines along ${name}$",
        )  # fmt: skip
        if line.hurst_exponents.size and line.band is not None:
            exponent = float(line.hurst_exponents.mean())
            q = 2 * math.pi / np.array([line.band[1], line.band[0]])
            inside = (spectrum.wave_number >= q[0]) & (spectrum.wave_number <= q[1]) & shown
            # Through the mean spectrum, on average over the band.
            power = spectrum.wave_number[inside] ** (1 + 2 * exponent) * spectrum.density[inside]
            axes.plot(
                q, np.exp(np.log(power).mean()) * q ** (-1 - 2 * exponent), "--", color=colour, linewidth=1,
                label=f"$q^{{-1-2H}}$, $H$ = {exponent:.2f} ± {line.hurst_exponents.std():.2f}",
            )  # fmt: skip
    _label_spectrum(axes)
    axes.legend(loc="lower left", handlelength=1.8, borderaxespad=0.3, labelspacing=0.3)


def _other(value: ArrayLike) -> ArrayLike:
    """Wave number of a wavelength, and the other way round; 0 is tried by the axis and means nothing."""
    array = np.asarray(value, dtype=np.float64)
    return np.asarray(2 * math.pi / np.where(array == 0, np.finfo(float).tiny * 10, array))
