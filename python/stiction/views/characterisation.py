"""What a profile or a surface is like: a table for the terminal, and a figure for print."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.surfaces.hurst import HurstEstimate, hurst_exponent_of
from stiction.surfaces.lines import LineRoughness
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import RoughnessParameters, roughness_parameters
from stiction.surfaces.spectrum import power_spectrum, spectral_moments
from stiction.surfaces.surface import Surface
from stiction.views.figures import MILLIMETRE, STYLE, WIDTH

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


def characterisation_text(profile: Profile, *, band: tuple[float, float] | None = None, periodic: bool = False) -> str:
    """History, parameters, moments and Hurst exponent of a profile, a line for each, with units.

    Parameters
    ----------
    profile : Profile
        Not flat, and of at least 7 points.
    band : (float, float), µm, optional
        Shortest and longest wavelength to fit the Hurst exponent to; without one it is found.
    periodic : bool
        As in `power_spectrum`.

    Raises
    ------
    ValueError
        If the profile is flat or too short, or a given band holds too few harmonics. That no band is found is said
        in the text.

    Examples
    --------
    >>> from stiction import self_affine
    >>> from stiction.views.characterisation import characterisation_text
    >>> profile = self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01)
    >>> print(characterisation_text(profile).splitlines()[0])
    points              4000, 10 nm apart, over 40 µm
    """
    parameters = roughness_parameters(profile)
    neighbours = roughness_parameters(profile, derivative="neighbours").Pdq
    moments = spectral_moments(profile, periodic=periodic)
    estimate = _estimate(profile, band, periodic)
    rows = [
        *_history(profile),
        ("points", f"{len(profile)}, {_length(profile.spacing)} apart, over {_length(profile.extent)}"),
        ("Pa", f"{_length(parameters.Pa)}"),
        ("Pq", f"{_length(parameters.Pq)}"),
        ("Pt", f"{_length(parameters.Pt)}"),
        ("Psk", f"{parameters.Psk:.3f}"),
        ("Pku", f"{parameters.Pku:.3f}"),
        ("Pdq", f"{parameters.Pdq:.4g} (seven points), {neighbours:.4g} (neighbours)"),
        ("m0", f"{moments.height:.4g} µm²"),
        ("m2", f"{moments.slope:.4g}"),
        ("m4", f"{moments.curvature:.4g} 1/µm²"),
        ("Nayak's parameter", f"{moments.nayak_parameter:.4g} (m0 m4 / m2²)"),
    ]
    if estimate is None:
        rows.append(("Hurst exponent H", "none: no self-affine band was found; look at the spectrum, then give a band"))
    else:
        rows += [
            ("Hurst exponent H", f"{estimate.value:.3f} [{estimate.lower:.3f}, {estimate.upper:.3f}] (95 %)"),
            (
                "fitted band",
                f"{_length(estimate.shortest_wavelength)} to {_length(estimate.longest_wavelength)} "
                f"({'found' if band is None else 'given'}; {estimate.harmonics} harmonics)",
            ),
            ("fractal dimension D", f"{estimate.fractal_dimension_classical:.3f} (classical, 2 - H)"),
            ("", f"{estimate.fractal_dimension_paper:.3f} (paper, (4 - H)/2)"),
        ]
        if estimate.dispersion > _SCATTERED:
            rows.append(
                ("scatter", f"{math.sqrt(estimate.dispersion):.1f} times that of chance: no straight line, see it")
            )
    window = "as it is, periodic" if periodic else "after a Hann window"
    rows.append(("spectrum", f"{window}; moments over all of its wavelengths"))
    return _table(rows)


def _history(body: Profile | Surface) -> list[tuple[str, str]]:
    return [("history" if at == 0 else "", step) for at, step in enumerate(body.history)]


def _table(rows: list[tuple[str, str]]) -> str:
    return "".join(f"{name:<19} {value}".rstrip() + "\n" for name, value in rows)


_SCATTERED = 2.0
"""Dispersion that is worth saying."""


def _estimate(profile: Profile, band: tuple[float, float] | None, periodic: bool) -> HurstEstimate | None:
    """None if no band is given and none is found; whatever else is wrong has been said before."""
    try:
        return hurst_exponent_of(profile, band=band, periodic=periodic)
    except ValueError:
        if band is not None:
            raise
        return None


def _length(value: float) -> str:
    """A length, µm, in the unit that gives it one to three digits before the point."""
    for unit, size in (("pm", 1e-6), ("nm", 1e-3), ("µm", 1.0), ("mm", 1e3)):
        if value < 999.95 * size or unit == "mm":
            break
    return f"{value / size:.4g} {unit}"


def surface_characterisation_text(surface: Surface, along_x: LineRoughness, along_y: LineRoughness) -> str:
    """History and Sq of a surface as it is, and what its lines along x and along y are like, with units.

    Parameters
    ----------
    surface : Surface
    along_x, along_y : LineRoughness
        Of the surface, by `line_roughness`.
    """
    (dy, dx), (width_y, width_x) = surface.spacing, surface.extent
    rows = [
        *_history(surface),
        ("points", f"{surface.heights.shape[1]} along x, {_length(dx)} apart, over {_length(width_x)}"),
        ("", f"{surface.heights.shape[0]} along y, {_length(dy)} apart, over {_length(width_y)}"),
        ("Sq", _length(float(surface.heights.std()))),
        ("lines", _beside("along x", "along y")),
    ]
    for name, value in (
        ("number", lambda line: f"{line.lines}"),
        ("Pq", lambda line: _length(line.Pq)),
        ("Pdq, seven points", lambda line: f"{line.Pdq:.4g}"),
        ("Pdq, neighbours", lambda line: f"{line.Pdq_neighbours:.4g}"),
        ("Hurst exponent H", _line_hurst),
        ("fitted band", lambda line: "none" if line.band is None else " to ".join(map(_length, line.band))),
        ("band found in", lambda line: f"{line.with_band} of {line.fitted} lines"),
    ):
        rows.append((f"  {name}", _beside(value(along_x), value(along_y))))
    rows.append(("", "each line levelled by a line; Pq and Pdq: rms over lines; H: mean ± standard deviation"))
    return _table(rows)


def _beside(one: str, other: str) -> str:
    return f"{one:<24} {other}"


def _line_hurst(line: LineRoughness) -> str:
    values = line.hurst_exponents
    return f"{values.mean():.3f} ± {values.std():.3f}" if values.size else "none"


# ---- Figure ----------------------------------------------------------------------------------------------------------


def characterisation_figure(
    profile: Profile, *, band: tuple[float, float] | None = None, periodic: bool = False
) -> Figure:
    """A profile, the distribution of its heights, and its spectrum with the fitted power law; 80 mm wide.

    The parameters are those of `characterisation_text`.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    parameters = roughness_parameters(profile)
    estimate = _estimate(profile, band, periodic)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 88 * MILLIMETRE), layout="constrained")
        top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=[1, 1.7])[:, 0]
        line, heights = top.subplots(1, 2, width_ratios=[2.6, 1], sharey=True)
        _profile_panel(line, profile, parameters)
        _heights_panel(heights, profile.heights)
        _spectrum_panel(bottom.subplots(), profile, estimate, periodic)
        figure.draw_without_rendering()  # lays it out in this style
    return figure


def _profile_panel(axes: Axes, profile: Profile, parameters: RoughnessParameters) -> None:
    unit, size = ("mm", 1e3) if profile.extent >= 2000 else ("µm", 1.0)
    axes.plot(profile.x / size, _in_height_unit(profile.heights)[0], color="C0", linewidth=0.4, rasterized=True)
    axes.set_xlim(0, profile.extent / size)
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_title(
        f"$Pq$ = {_length(parameters.Pq)}, $Psk$ = {parameters.Psk:.2f}, $Pku$ = {parameters.Pku:.2f}",
        fontsize=6, loc="left", pad=2,
    )  # fmt: skip
    axes.set_ylabel(f"height ({_in_height_unit(profile.heights)[1]})")


def _in_height_unit(heights: Floats) -> tuple[Floats, str]:
    """Heights about their mean, in a unit in which they are no long numbers."""
    heights = heights - heights.mean()
    return (1000 * heights, "nm") if np.abs(heights).max() < 0.5 else (heights, "µm")


def _heights_panel(axes: Axes, heights: Floats) -> None:
    from matplotlib.ticker import MaxNLocator

    heights, unit = _in_height_unit(heights.ravel())
    rms = float(np.sqrt(np.mean(heights**2)))
    axes.hist(heights, bins=_HEIGHT_BINS, density=True, orientation="horizontal", color="0.75")
    at = np.linspace(heights.min(), heights.max(), 200)
    normal = np.exp(-((at / rms) ** 2) / 2) / (rms * math.sqrt(2 * math.pi))
    axes.plot(normal, at, color="C1", linewidth=0.8)
    axes.set_xlabel(f"density (1/{unit})")
    axes.xaxis.set_major_locator(MaxNLocator(2))
    axes.xaxis.set_major_formatter("{x:g}")
    axes.set_title("line: normal", fontsize=6, pad=2)
    axes.tick_params(labelleft=False)


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
        color="C0",
        markersize=2,
        linewidth=0.6,
        label="means, ten to a decade",
    )
    axes.set_ylim(max(lowest / 3, 1e-14 * spectrum.density.max()), 3 * spectrum.density.max())
    _label_spectrum(axes)
    if estimate is not None:
        ends = 2 * math.pi / np.array([estimate.longest_wavelength, estimate.shortest_wavelength])
        axes.axvspan(*ends, color="C1", alpha=0.12, linewidth=0, label="fitted band")
        interval = f"[{estimate.lower:.2f}, {estimate.upper:.2f}]"
        axes.plot(
            ends, estimate.density(ends), "--", color="C1", linewidth=1.2,
            label=f"$q^{{-1-2H}}$, $H$ = {estimate.value:.2f} {interval}",
        )  # fmt: skip
        axes.plot(
            [], [], " ",
            label=f"$D$ = {estimate.fractal_dimension_classical:.2f} (classical), "
            f"{estimate.fractal_dimension_paper:.2f} (paper)",
        )  # fmt: skip
    else:
        axes.plot([], [], " ", label="no self-affine band found")
    axes.legend(loc="lower left", handlelength=1.5, borderaxespad=0.3, labelspacing=0.3)


def _label_spectrum(axes: Axes) -> None:
    from matplotlib.ticker import NullFormatter

    axes.set_xlabel("wave number $q = 2\\pi/\\lambda$ (1/µm)")
    axes.set_ylabel("$C^{1D}$ (µm³)")
    wavelength = axes.secondary_xaxis("top", functions=(_other, _other))
    wavelength.set_xlabel(r"wavelength $\lambda$ (µm)")
    lowest, highest = axes.get_xlim()
    if highest > 10 * lowest:  # the powers of ten are enough, and the others would overlap
        for axis in (axes.xaxis, wavelength.xaxis):
            axis.set_minor_formatter(NullFormatter())


def surface_characterisation_figure(surface: Surface, along_x: LineRoughness, along_y: LineRoughness) -> Figure:
    """A map of a surface, the distribution of its heights, and the mean spectra of its lines; 80 mm wide.

    The parameters are those of `surface_characterisation_text`.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 105 * MILLIMETRE), layout="constrained")
        top, bottom = figure.subfigures(2, 1, squeeze=False, height_ratios=[1.1, 1])[:, 0]
        image, heights = top.subplots(1, 2, width_ratios=[1.8, 1])
        _map_panel(top, image, surface)
        _heights_panel(heights, surface.heights)
        heights.set_ylabel(f"height ({_in_height_unit(surface.heights)[1]})")
        heights.tick_params(labelleft=True)
        _line_spectra_panel(bottom.subplots(), along_x, along_y)
        figure.draw_without_rendering()  # lays it out in this style
    return figure


def _map_panel(figure: Any, axes: Axes, surface: Surface) -> None:
    from matplotlib.ticker import MaxNLocator

    unit, size = ("mm", 1e3) if max(surface.extent) >= 2000 else ("µm", 1.0)
    heights, height_unit = _in_height_unit(surface.heights)
    along_y, along_x = (length / size for length in surface.extent)
    lowest, highest = np.quantile(heights, [0.001, 0.999])  # or a grain of dust takes all the colours
    image = axes.imshow(
        heights, extent=(0, along_x, 0, along_y), origin="lower", cmap="cividis", vmin=lowest, vmax=highest,
        aspect="equal" if 1 / 4 < along_x / along_y < 4 else "auto",
    )  # fmt: skip
    bar = figure.colorbar(image, ax=axes, location="top", extend="both", aspect=30, pad=0.02)
    bar.locator = MaxNLocator(5)
    bar.set_label(f"height ({height_unit}), $Sq$ = {_length(float(surface.heights.std()))}")
    axes.set_xlabel(f"$x$ ({unit})")
    axes.set_ylabel(f"$y$ ({unit})")


def _line_spectra_panel(axes: Axes, along_x: LineRoughness, along_y: LineRoughness) -> None:
    axes.set_xscale("log")
    axes.set_yscale("log")
    for name, colour, line in (("x", "C0", along_x), ("y", "C1", along_y)):
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
