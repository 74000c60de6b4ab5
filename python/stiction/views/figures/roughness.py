"""Curves of one measured profile or surface, which its figure and its page draw."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction._drawing import HEIGHT_MAP
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.lines import LineRoughness
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectrum import PowerSpectrum
from stiction.surfaces.surface import Surface
from stiction.views.characterisation import Characterisation, characterisation_of, length_text
from stiction.views.style import AXES, FULL_WIDTH, MILLIMETRE, STYLE, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_POINTS = 1500  # points of a profile that are drawn; of more, means of neighbours
HEIGHTS = 40  # bins of the distribution of heights
MEASURED, FITTED = "#0072b2", "#d55e00"  # colours of what was measured, and of what was fitted to it
MILLIMETRES = 1000.0  # lengths (µm) from which on an axis of a figure is in mm


@dataclass(frozen=True)
class Series:
    """One curve of a panel; `lower` and `upper` bound a band about it."""

    name: str
    x: Floats
    value: Floats
    fitted: bool = False
    lower: Floats | None = None
    upper: Floats | None = None


@dataclass(frozen=True)
class Panel:
    """Curves over one axis, with its titles as pages have them: _x_ is italic, C^2D^ raised."""

    id: str
    name: str
    series: list[Series]
    x: str
    y: str
    log: bool = True
    notes: list[str] = field(default_factory=list)


def panels(found: Characterisation) -> list[Panel]:
    """Heights of a profile, spectra, and how heights are distributed."""
    law = found.law
    one = found.spectrum is not None
    series = [Series("measured", found.binned.wave_number, found.binned.density)]
    notes = ["no self-affine band found" if found.fit is None else "no power law"]
    if law is not None:
        q = np.geomspace(2 * math.pi / law.longest_wavelength, 2 * math.pi / law.shortest_wavelength, 40)
        interval = f"[{law.lower:.2f}, {law.upper:.2f}]"
        series.append(Series(f"q^(-{2 - one}-2H), H = {law.value:.2f} {interval}", q, law.density(q), fitted=True))
        notes = [_dimensions(law)]
    unit = "µm³" if one else "µm⁴"
    spectrum = Panel("spectrum", "Spectrum", series, WAVES, f"density _C_ ({unit})", notes=notes)
    if isinstance(found.body, Profile):
        return [_heights(found.body), spectrum, _distribution(found.body.heights)]
    lines = [each for axis, line in zip("xy", found.lines, strict=True) for each in _line_series(axis, line)]
    by_line = Panel("lines", "Spectra of lines", lines, WAVES, "density _C_ (µm³)")
    return [spectrum, by_line, _distribution(found.body.heights)]


WAVES = "wave number _q_ (1/µm)"


def _dimensions(law: HurstEstimate) -> str:
    classical = f"{law.fractal_dimension_classical:.2f} (classical), " if law.value <= 1 else ""
    return f"D = {classical}{law.fractal_dimension_paper:.2f} (paper)"


def _heights(profile: Profile) -> Panel:
    """Heights along a profile; of a long one means of neighbours between their lowest and their highest."""
    every = -(-len(profile) // MOST_POINTS)
    heights = profile.heights - profile.heights.min()
    groups = np.pad(1000 * heights, (0, -len(profile) % every), mode="edge").reshape(-1, every)
    x = np.asarray(profile.spacing * (every * np.arange(len(groups)) + (every - 1) / 2), dtype=float)
    ends = {"lower": groups.min(axis=1), "upper": groups.max(axis=1)} if every > 1 else {}
    series = [Series("", x, groups.mean(axis=1), **ends)]
    return Panel("heights", "Heights", series, "position _x_ (µm)", "height above the lowest point (nm)", log=False)


def _distribution(heights: Floats) -> Panel:
    """How heights are distributed, beside normally distributed ones."""
    about = 1000 * (heights - heights.mean()).ravel()
    rms = float(about.std())
    density, edges = np.histogram(about, HEIGHTS, density=True)
    x = (edges[1:] + edges[:-1]) / 2
    normal = np.exp(-((x / rms) ** 2) / 2) / (rms * math.sqrt(2 * math.pi))
    series = [Series("measured", x, density), Series("Gaussian of the same rms", x, normal, fitted=True)]
    names = "height about the mean (nm)", "density (1/nm)"
    return Panel("distribution", "Distribution of heights", series, *names, log=False)


def _line_series(axis: str, line: LineRoughness) -> list[Series]:
    """The mean spectrum of the lines along an axis, and its power law, if it is one."""
    spectrum = line.spectrum.in_bins()
    found = [Series(f"along {axis}", spectrum.wave_number, spectrum.density)]
    if line.is_straight and line.band is not None:
        exponent, scatter = float(line.hurst_exponents.mean()), float(line.hurst_exponents.std())
        first, last = (2 * math.pi / end for end in line.band[::-1])
        inside = (spectrum.wave_number >= first) & (spectrum.wave_number <= last) & (spectrum.density > 0)
        # Through the mean spectrum, on average over the band.
        level = np.log(spectrum.wave_number[inside] ** (1 + 2 * exponent) * spectrum.density[inside]).mean()
        q = np.geomspace(first, last, 40)
        name = f"q^(-1-2H), H = {exponent:.2f} ± {scatter:.2f}"
        found.append(Series(name, q, np.exp(level) * q ** (-1 - 2 * exponent), fitted=True))
    return found


# ---- The figure ------------------------------------------------------------------------------------------------------


def characterisation_figure(body: Profile | Surface | Characterisation, **options: Any) -> Figure:
    """The figure of a profile, 80 mm wide, or of a surface, 170 mm wide: heights, their distribution, and spectra.

    The parameters are those of `characterisation_text`.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    found = characterisation_of(body, **options)
    drawn = {panel.id: panel for panel in panels(found)}
    is_line = isinstance(found.body, Profile)
    with mpl.rc_context(STYLE):
        size = (WIDTH, 88 * MILLIMETRE) if is_line else (FULL_WIDTH, 112 * MILLIMETRE)
        figure = Figure(figsize=size, layout="constrained")
        if is_line:
            first, second = figure.subfigures(2, 1, squeeze=False, height_ratios=[1, 1.7])[:, 0]
            axes = first.subplot_mosaic([["heights", "distribution"]], width_ratios=[1.7, 1])
            axes |= second.subplot_mosaic([["spectrum"]])
        else:
            first, second = figure.subfigures(1, 2, squeeze=False, width_ratios=[1, 1.1])[0]
            axes = first.subplot_mosaic([["heights"], ["distribution"]], height_ratios=[2, 1])
            axes |= second.subplot_mosaic([["spectrum"], ["lines"]])
        for name, panel in drawn.items():
            _draw(axes[name], panel, found.spectrum)
        if isinstance(found.body, Surface):
            _draw_map(first, axes["heights"], found.body)
    return figure


def _draw(axes: Axes, panel: Panel, harmonics: PowerSpectrum | None) -> None:
    """Curves of a panel; those of a spectrum with the band of its fit, and the harmonics of a profile behind it."""
    from matplotlib.ticker import MaxNLocator

    many = panel.id == "lines"
    if panel.id == "spectrum" and harmonics is not None:
        shown = harmonics.density > 0
        axes.plot(
            harmonics.wave_number[shown], harmonics.density[shown], ".", color="0.8", markersize=1, markeredgewidth=0,
            rasterized=True, label="harmonics",
        )  # fmt: skip
    scale = 1000 if panel.id == "heights" and panel.series[0].x[-1] >= MILLIMETRES else 1
    for at, series in enumerate(panel.series):
        shown = series.value > 0 if panel.log else np.full(series.value.shape, True)
        colour = FITTED if series.fitted else MEASURED
        if many:
            colour = AXES["xy"[sum(not each.fitted for each in panel.series[: at + 1]) - 1]]
        style: dict[str, Any] = {"linestyle": "--", "linewidth": 1.2} if series.fitted else {"linewidth": 0.7}
        if panel.id == "spectrum" and not series.fitted:
            style = {"linewidth": 0.6, "marker": "o", "markersize": 2}
        name = re.sub(r"^q\^\((.*)\), H", r"$q^{\1}$, $H$", series.name)
        axes.plot(series.x[shown] / scale, series.value[shown], color=colour, label=name or None, **style)
        if series.lower is not None and series.upper is not None:
            axes.fill_between(series.x / scale, series.lower, series.upper, color=colour, alpha=0.4, linewidth=0)
        if panel.id == "spectrum" and series.fitted:
            axes.axvspan(series.x[0], series.x[-1], color=FITTED, alpha=0.12, linewidth=0, label="fitted band")
    x = panel.x.replace("(µm)", "(mm)") if scale > 1 else panel.x
    axes.set(xlabel=_as_math(x), ylabel=_as_math(panel.y))
    for note in panel.notes:
        axes.plot([], [], " ", label=note.replace("D =", "$D$ ="))
    if panel.log:
        axes.set(xscale="log", yscale="log")
        wavelength = axes.secondary_xaxis("top", functions=(_other, _other))
        wavelength.set_xlabel(r"wavelength $\lambda$ (µm)")
        density = panel.series[0].value[panel.series[0].value > 0]
        axes.set_ylim(max(density.min() / 5, 1e-14 * density.max()), 5 * density.max())
        axes.legend(loc="lower left", handlelength=1.5, borderaxespad=0.3, labelspacing=0.3)
    else:
        axes.yaxis.set_major_locator(MaxNLocator(4))
        axes.xaxis.set_major_locator(MaxNLocator(4))
        if panel.id == "distribution":
            axes.set_title("dashed: Gaussian", fontsize=6, pad=2)
        title = "set_xlabel" if panel.id == "distribution" else "set_ylabel"
        getattr(axes, title)("height (nm)")


def _as_math(title: str) -> str:
    return re.sub(r"_(\w)_", r"$\1$", title)


def _draw_map(figure: Any, axes: Axes, surface: Surface) -> None:
    from matplotlib.ticker import MaxNLocator

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


def _other(value: Any) -> Floats:
    """Wave number of a wavelength, and the other way round; 0 is tried by the axis and means nothing."""
    array = np.asarray(value, dtype=np.float64)
    return np.asarray(2 * math.pi / np.where(array == 0, np.finfo(float).tiny * 10, array))
