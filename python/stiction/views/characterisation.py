"""What a profile or a surface is like: a table for the terminal, and a figure for print."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.surfaces.hurst import HurstEstimate, hurst_exponent_of
from stiction.surfaces.lines import BENT, LineRoughness
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import RoughnessParameters, roughness_parameters
from stiction.surfaces.spectrum import PowerSpectrum, peak_of, power_spectrum, spectral_moments
from stiction.surfaces.surface import Surface
from stiction.surfaces.surface_parameters import surface_parameters
from stiction.surfaces.surface_spectrum import surface_spectrum
from stiction.views.style import MILLIMETRE, STYLE, WIDTH, lay_out

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
        ("friction by slope", _by_slope(profile)),
        ("m0", f"{moments.height:.4g} µm²"),
        ("m2", f"{moments.slope:.4g}"),
        ("m4", f"{moments.curvature:.4g} 1/µm²"),
        ("Nayak's parameter", f"{moments.nayak_parameter:.4g} (m0 m4 / m2²)"),
    ]
    spectrum = power_spectrum(profile, periodic=periodic)
    if peak := _peak(spectrum):
        rows.append(("peak", peak))
    rows += _hurst_rows(estimate, band, spectrum.wave_number, spectrum.density)
    window = "as it is, periodic" if periodic else "after a Hann window"
    rows.append(("spectrum", f"{window}; moments over all of its wavelengths"))
    return _table(rows)


def _by_slope(body: Profile | Surface) -> str:
    """What its slopes alone say of friction against another body of the same roughness."""
    from stiction.mechanics.closed_forms import gentle_friction
    from stiction.mechanics.patches import slopes

    spacing = (body.spacing,) if isinstance(body, Profile) else body.spacing
    # Of the gap of two such bodies, along x first.
    squares = [2 * float(np.square(along).mean()) for along in slopes(body.heights, spacing, periodic=False)][::-1]
    if not min(squares) > 0:
        return "none, without slopes"
    found = [
        float(gentle_friction(_MU0, rms_gradient=math.sqrt(sum(squares)), rms_slope=math.sqrt(square)))
        for square in squares
    ]
    axes = (" along x,", " along y,") if len(found) == 2 else (",",)
    values = " ".join(f"{value:.3f}{axis}" for value, axis in zip(found, axes, strict=True))
    return f"{values} against its like, where mu0 is {_MU0:g} (gentle_friction)"


def _hurst_rows(
    estimate: HurstEstimate | None, band: tuple[float, float] | None, wave_number: Floats, density: Floats
) -> list[tuple[str, str]]:
    """Exponent, band, dimension of a fit, and in words what speaks against it."""
    if estimate is None:
        none = "no self-affine band was found; look at the spectrum, then give a band"
        return [("Hurst exponent H", f"none: {none}"), ("fractal dimension D", "none, without H")]
    harmonics = "harmonics" if estimate.dimensions == 1 else "waves"
    classical = f"{estimate.fractal_dimension_classical:.3f}" if estimate.value <= 1 else "none: 2 - H is below 1"
    rows = [
        ("Hurst exponent H", f"{estimate.value:.3f} [{estimate.lower:.3f}, {estimate.upper:.3f}] (95 %)"),
        (
            "fitted band",
            f"{_length(estimate.shortest_wavelength)} to {_length(estimate.longest_wavelength)} "
            f"({'found' if band is None else 'given'}; {estimate.harmonics} {harmonics})",
        ),
        ("fractal dimension D", f"{classical} (classical, 2 - H)" if estimate.value <= 1 else classical),
        ("", f"{estimate.fractal_dimension_paper:.3f} (paper, (4 - H)/2)"),
    ]
    if estimate.dispersion > _SCATTERED:
        rows.append(("scatter", f"{math.sqrt(estimate.dispersion):.1f} times that of chance: no straight line, see it"))
    if estimate.value > 1:
        rows.append(("caution", "H above 1 is not self-affine but smooth: form, a filter, a tip, or waves"))
    longest = estimate.longest_wavelength
    if (rise := _rise(wave_number, density, longest)) > _PEAKED:
        rows.append(
            (
                "caution",
                f"the band begins on a peak at {_length(longest)}, {rise:.1f} times what is longer: waves, grooves",
            )
        )
    return rows


_MU0 = 0.4
"""Of the friction that slopes alone say; the paper's."""

_PEAKED = 3.0
"""Times the density at longer wavelengths, above which a band begins on a peak and not behind a roll-off."""


def _rise(wave_number: Floats, density: Floats, longest: float) -> float:
    """By how much a spectrum is higher where a band begins than at longer wavelengths, of which it has enough."""
    start = 2 * math.pi / longest
    trusted = wave_number > 2.5 * wave_number[0]  # of a window and of levelling
    longer = trusted & (wave_number < start / 1.5)
    begins = (wave_number >= start / 1.2) & (wave_number < start * 1.2)
    if longer.sum() < _FEWEST or not begins.any():
        return 0.0
    return float(density[begins].mean() / density[longer].mean())


_FEWEST = 4
"""Values whose mean is more than chance."""


def _peak(spectrum: PowerSpectrum, lines: int = 1) -> str:
    """Words on a peak that the moments are of, or none."""
    found = peak_of(spectrum, lines=lines)
    if found is None or found[1] < _PEAK_SHARE:
        return ""
    return (
        f"at {_length(found[0])}, with {100 * found[1]:.0f} % of m4: of the instrument, or a pattern; see the spectrum"
    )


_PEAK_SHARE = 0.1
"""Of m4, that is worth saying."""


def _history(body: Profile | Surface) -> list[tuple[str, str]]:
    return [("history" if at == 0 else "", step) for at, step in enumerate(body.history)]


def _table(rows: list[tuple[str, str]]) -> str:
    return "".join(f"{name:<19} {value}".rstrip() + "\n" for name, value in rows)


_SCATTERED = 2.0
"""Dispersion that is worth saying."""


def _estimate(body: Profile | Surface, band: tuple[float, float] | None, periodic: bool) -> HurstEstimate | None:
    """None if no band is given and none is found; whatever else is wrong has been said before."""
    try:
        return hurst_exponent_of(body, band=band, periodic=periodic)
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


def surface_characterisation_text(
    surface: Surface, along_x: LineRoughness, along_y: LineRoughness, *, band: tuple[float, float] | None = None
) -> str:
    """History, parameters, moments and Hurst exponent of a surface as it is, and what its lines are like, with units.

    Parameters
    ----------
    surface : Surface
        Not flat, and of at least 7 by 7 points.
    along_x, along_y : LineRoughness
        Of the surface, by `line_roughness`.
    band : (float, float), µm, optional
        Shortest and longest wavelength that the exponents are fitted to, if it was given.

    Raises
    ------
    ValueError
        If the surface is flat or too small, or a given band holds too few waves.
    """
    (dy, dx), (width_y, width_x) = surface.spacing, surface.extent
    found, other = surface_parameters(surface), surface_parameters(surface, derivative="neighbours")
    spectrum = surface_spectrum(surface)
    radial = spectrum.radial(_RADIAL_BINS)
    moments = [spectrum.moments(direction) for direction in (0, 90)]
    estimate = _estimate(surface, band, False)
    rows = [
        *_history(surface),
        ("points", f"{surface.heights.shape[1]} along x, {_length(dx)} apart, over {_length(width_x)}"),
        ("", f"{surface.heights.shape[0]} along y, {_length(dy)} apart, over {_length(width_y)}"),
        ("Sq", _length(found.Sq)),
        ("Sa", _length(found.Sa)),
        ("Sz", _length(found.Sz)),
        ("Ssk", f"{found.Ssk:.3f}"),
        ("Sku", f"{found.Sku:.3f}"),
        ("Sdq", f"{found.Sdq:.4g} (seven points), {other.Sdq:.4g} (neighbours)"),
        ("friction by slope", _by_slope(surface)),
        ("Sdr", f"{100 * found.Sdr:.4g} %"),
        ("Sal", "none: no decay to 0.2 within half the map" if math.isnan(found.Sal) else _length(found.Sal)),
        ("Str", _str(found.Sal, found.Str, surface)),
        ("Std", f"{found.Std:.0f}° from +x towards +y, of the strongest waves; a lay runs across"),
        ("Sk, Spk, Svk", f"{_length(found.Sk)}, {_length(found.Spk)}, {_length(found.Svk)}"),
        ("Smr1, Smr2", f"{100 * found.Smr1:.1f} %, {100 * found.Smr2:.1f} %"),
        *_hurst_rows(estimate, band, radial.wave_number, radial.density),
        ("lines", _beside("along x", "along y")),
    ]
    sides = ((along_x, moments[0]), (along_y, moments[1]))
    columns: list[tuple[str, list[str]]] = [
        ("number", [f"{line.lines}" for line, _ in sides]),
        ("Pq", [_length(line.Pq) for line, _ in sides]),
        ("Pdq, seven points", [f"{line.Pdq:.4g}" for line, _ in sides]),
        ("Pdq, neighbours", [f"{line.Pdq_neighbours:.4g}" for line, _ in sides]),
        ("m0", [f"{moment.height:.4g} µm²" for _, moment in sides]),
        ("m2", [f"{moment.slope:.4g}" for _, moment in sides]),
        ("m4", [f"{moment.curvature:.4g} 1/µm²" for _, moment in sides]),
        ("Nayak's parameter", [f"{moment.nayak_parameter:.4g}" for _, moment in sides]),
        ("Hurst exponent H", [_line_hurst(line) for line, _ in sides]),
        ("fitted band", ["none" if line.band is None else " to ".join(map(_length, line.band)) for line, _ in sides]),
        ("scatter", [_misfit(line) for line, _ in sides]),
    ]
    if band is None and along_x.band != along_y.band:
        columns.append(("band found in", [f"{line.with_band} of {line.fitted} lines" for line, _ in sides]))
    rows += [(f"  {name}", _beside(*values)) for name, values in columns]
    rows += [
        (f"  peak along {axis}", peak)
        for axis, line in (("x", along_x), ("y", along_y))
        if (peak := _peak(line.spectrum, line.fitted))
    ]
    means = [float(line.hurst_exponents.mean()) for line, _ in sides if line.hurst_exponents.size]
    if estimate is not None and means and not any(estimate.lower < mean < estimate.upper for mean in means):
        rows.append(
            ("  caution", "H of lines is outside the interval of the map's: it depends on the band, see the spectra")
        )
    rows.append(("", "each line levelled by a line; Pq and Pdq: rms over lines; H: mean ± standard deviation"))
    rows.append(("", "m0 to m4: of the map's spectrum after a Hann window, over all of its wavelengths"))
    return _table(rows)


_RADIAL_BINS = 20


def _str(shortest: float, ratio: float, surface: Surface) -> str:
    if math.isnan(ratio) and not math.isnan(shortest):
        return f"below {shortest / (min(surface.extent) / 2):.2g}: no decay to 0.2 along the lay within half the map"
    return "none, without Sal" if math.isnan(ratio) else f"{ratio:.3f}"


def _misfit(line: LineRoughness) -> str:
    """How far the mean spectrum is off its line."""
    if math.isnan(line.misfit):
        return "none"
    return f"factor {line.misfit:.2f}" + (", no line" if line.misfit > BENT else "")


def _beside(one: str, other: str) -> str:
    return f"{one:<24} {other}"


def _line_hurst(line: LineRoughness) -> str:
    values = line.hurst_exponents
    if not values.size:
        return "none"
    return f"{values.mean():.3f} ± {values.std():.3f}" + (" (smooth)" if values.mean() > 1 else "")


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
        lay_out(figure)
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
    """A map of a surface, the distribution of its heights, its radial spectrum and that of its lines; 80 mm wide.

    The parameters are those of `surface_characterisation_text`.
    """
    import matplotlib as mpl
    from matplotlib.figure import Figure

    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(WIDTH, 160 * MILLIMETRE), layout="constrained")
        top, middle, bottom = figure.subfigures(3, 1, squeeze=False, height_ratios=[1.1, 1, 1])[:, 0]
        image, heights = top.subplots(1, 2, width_ratios=[1.8, 1])
        _map_panel(top, image, surface)
        _heights_panel(heights, surface.heights)
        heights.set_ylabel(f"height ({_in_height_unit(surface.heights)[1]})")
        heights.tick_params(labelleft=True)
        _radial_panel(middle.subplots(), surface, _estimate(surface, band, False))
        _line_spectra_panel(bottom.subplots(), along_x, along_y)
        lay_out(figure)
    return figure


def _radial_panel(axes: Axes, surface: Surface, estimate: HurstEstimate | None) -> None:
    radial = surface_spectrum(surface).radial(_RADIAL_BINS)
    shown = radial.density > 0
    axes.loglog(
        radial.wave_number[shown], radial.density[shown], "o-", color="C0", markersize=2, linewidth=0.6,
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
    axes.axvspan(*ends, color="C1", alpha=0.12, linewidth=0, label="fitted band")
    interval = f"[{estimate.lower:.2f}, {estimate.upper:.2f}]"
    axes.plot(
        ends, estimate.density(ends), "--", color="C1", linewidth=1.2,
        label=f"${law}$, $H$ = {estimate.value:.2f} {interval}",
    )  # fmt: skip
    classical = f"{estimate.fractal_dimension_classical:.2f} (classical), " if estimate.value <= 1 else ""
    axes.plot([], [], " ", label=f"$D$ = {classical}{estimate.fractal_dimension_paper:.2f} (paper)")


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
