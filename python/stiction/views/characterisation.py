"""What a profile or a surface is like, as a table for the terminal."""

from __future__ import annotations

import math

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.hurst import HurstEstimate, hurst_exponent_of
from stiction.surfaces.lines import BENT, LineRoughness
from stiction.surfaces.peak import peak_of
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import roughness_parameters, surface_parameters
from stiction.surfaces.spectrum import PowerSpectrum, power_spectrum, spectral_moments, surface_spectrum
from stiction.surfaces.surface import Surface
from stiction.views.scale_rows import scale_rows
from stiction.views.text import fitted

Rows = list[tuple[str, ...]]
"""Of each line its name and its value, or two of them."""


def characterisation_text(
    profile: Profile, *, band: tuple[float, float] | None = None, tip_radius: float | None = None,
    periodic: bool = False,
) -> str:  # fmt: skip
    """History, parameters, moments and Hurst exponent of a profile, a line for each, with units.

    Parameters
    ----------
    profile : Profile
        Not flat, and of at least 7 points.
    band : (float, float), µm, optional
        Shortest and longest wavelength to fit the Hurst exponent to; without one it is found.
    tip_radius : float, µm, optional
        Of the stylus or the probe.
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
    return _table(characterisation_rows(profile, band=band, tip_radius=tip_radius, periodic=periodic))


def characterisation_rows(
    profile: Profile, *, band: tuple[float, float] | None = None, tip_radius: float | None = None,
    periodic: bool = False,
) -> Rows:  # fmt: skip
    """Names and values of the lines of `characterisation_text`; a line without a name goes on with the one before."""
    parameters = roughness_parameters(profile)
    neighbours = roughness_parameters(profile, derivative="neighbours").Pdq
    moments = spectral_moments(profile, periodic=periodic)
    estimate = estimate_of(profile, band, periodic)
    rows: Rows = [
        *_history(profile),
        ("points", f"{len(profile)}, {length_text(profile.spacing)} apart, over {length_text(profile.extent)}"),
        ("Pa", f"{length_text(parameters.Pa)}"),
        ("Pq", f"{length_text(parameters.Pq)}"),
        ("Pt", f"{length_text(parameters.Pt)}"),
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
    rows += scale_rows(profile, tip_radius=tip_radius, periodic=periodic)
    rows += _hurst_rows(estimate, band, spectrum.wave_number, spectrum.density)
    window = "as it is, periodic" if periodic else "after a Hann window"
    rows.append(("spectrum", f"{window}; moments over all of its wavelengths"))
    return rows


def _by_slope(body: Profile | Surface) -> str:
    """What its slopes alone say of friction against another body of the same roughness."""
    found = friction_by_slope(body)
    if not found:
        return "none, without slopes"
    axes = (" along x,", " along y,") if len(found) == 2 else (",",)
    values = " ".join(f"{value:.3f}{axis}" for value, axis in zip(found, axes, strict=True))
    return f"{values} against its like, where mu0 is {PAPERS_MU0:g} (gentle_friction)"


def friction_by_slope(body: Profile | Surface) -> list[float]:
    """The coefficient of a body against its like by their slopes alone, along x and, of a surface, y; none if flat."""
    from stiction.mechanics.closed_forms import gentle_friction
    from stiction.studies.contact_statistics import slopes_of

    # Of the gap of two such bodies, along x first.
    squares = [2 * float(np.square(along).mean()) for along in slopes_of(body)][::-1]
    if not min(squares) > 0:
        return []
    return [
        float(gentle_friction(PAPERS_MU0, rms_gradient=math.sqrt(sum(squares)), rms_slope=math.sqrt(square)))
        for square in squares
    ]


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
            f"{length_text(estimate.shortest_wavelength)} to {length_text(estimate.longest_wavelength)} "
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
                f"the band begins on a peak at {length_text(longest)}, {rise:.1f} times what is longer: waves, grooves",
            )
        )
    return rows


PAPERS_MU0 = 0.4
"""Of the friction that slopes alone say."""

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
    where, part = length_text(found[0]), 100 * found[1]
    return f"at {where}, with {part:.0f} % of m4: of the instrument, or a pattern; see the spectrum"


_PEAK_SHARE = 0.1
"""Of m4, that is worth saying."""


def _history(body: Profile | Surface) -> list[tuple[str, str]]:
    return [("history" if at == 0 else "", step) for at, step in enumerate(body.history)]


def _table(rows: Rows) -> str:
    return "".join(
        fitted(f"{name:<19} {'  '.join(f'{each:<23}' for each in values)}".rstrip(), hang=" " * 20) + "\n"
        for name, *values in rows
    )


_SCATTERED = 2.0
"""Dispersion that is worth saying."""


def estimate_of(body: Profile | Surface, band: tuple[float, float] | None, periodic: bool) -> HurstEstimate | None:
    """None if no band is given and none is found; whatever else is wrong has been said before."""
    try:
        return hurst_exponent_of(body, band=band, periodic=periodic)
    except ValueError:
        if band is not None:
            raise
        return None


def length_text(value: float) -> str:
    """A length, µm, in the unit that gives it one to three digits before the point."""
    for unit, size in (("pm", 1e-6), ("nm", 1e-3), ("µm", 1.0), ("mm", 1e3)):
        if value < 999.95 * size or unit == "mm":
            break
    return f"{value / size:.4g} {unit}"


def surface_characterisation_text(
    surface: Surface, along_x: LineRoughness, along_y: LineRoughness, *, band: tuple[float, float] | None = None,
    tip_radius: float | None = None,
) -> str:  # fmt: skip
    """History, parameters, moments and Hurst exponent of a surface as it is, and what its lines are like, with units.

    Parameters
    ----------
    surface : Surface
        Not flat, and of at least 7 by 7 points.
    along_x, along_y : LineRoughness
        Of the surface, by `line_roughness`.
    band : (float, float), µm, optional
        Shortest and longest wavelength that the exponents are fitted to, if it was given.
    tip_radius : float, µm, optional
        Of the probe.

    Raises
    ------
    ValueError
        If the surface is flat or too small, or a given band holds too few waves.
    """
    return _table(surface_characterisation_rows(surface, along_x, along_y, band=band, tip_radius=tip_radius))


def surface_characterisation_rows(
    surface: Surface, along_x: LineRoughness, along_y: LineRoughness, *, band: tuple[float, float] | None = None,
    tip_radius: float | None = None,
) -> Rows:  # fmt: skip
    """Names and values of the lines of `surface_characterisation_text`; rows of lines have one along x and along y."""
    (dy, dx), (width_y, width_x) = surface.spacing, surface.extent
    found, other = surface_parameters(surface), surface_parameters(surface, derivative="neighbours")
    spectrum = surface_spectrum(surface)
    radial = spectrum.radial(RADIAL_BINS)
    moments = [spectrum.moments(direction) for direction in (0, 90)]
    estimate = estimate_of(surface, band, False)
    rows: Rows = [
        *_history(surface),
        ("points", f"{surface.heights.shape[1]} along x, {length_text(dx)} apart, over {length_text(width_x)}"),
        ("", f"{surface.heights.shape[0]} along y, {length_text(dy)} apart, over {length_text(width_y)}"),
        ("Sq", length_text(found.Sq)),
        ("Sa", length_text(found.Sa)),
        ("Sz", length_text(found.Sz)),
        ("Ssk", f"{found.Ssk:.3f}"),
        ("Sku", f"{found.Sku:.3f}"),
        ("Sdq", f"{found.Sdq:.4g} (seven points), {other.Sdq:.4g} (neighbours)"),
        ("friction by slope", _by_slope(surface)),
        ("Sdr", f"{100 * found.Sdr:.4g} %"),
        ("Sal", "none: no decay to 0.2 within half the map" if math.isnan(found.Sal) else length_text(found.Sal)),
        ("Str", _str(found.Sal, found.Str, surface)),
        ("Std", f"{found.Std:.0f}° from +x towards +y, of the strongest waves; a lay runs across"),
        ("Sk, Spk, Svk", f"{length_text(found.Sk)}, {length_text(found.Spk)}, {length_text(found.Svk)}"),
        ("Smr1, Smr2", f"{100 * found.Smr1:.1f} %, {100 * found.Smr2:.1f} %"),
        *scale_rows(surface, tip_radius=tip_radius),
        *_hurst_rows(estimate, band, radial.wave_number, radial.density),
        ("lines", "along x", "along y"),
    ]
    sides = ((along_x, moments[0]), (along_y, moments[1]))
    columns: list[tuple[str, list[str]]] = [
        ("number", [f"{line.lines}" for line, _ in sides]),
        ("Pq", [length_text(line.Pq) for line, _ in sides]),
        ("Pdq, seven points", [f"{line.Pdq:.4g}" for line, _ in sides]),
        ("Pdq, neighbours", [f"{line.Pdq_neighbours:.4g}" for line, _ in sides]),
        ("m0", [f"{moment.height:.4g} µm²" for _, moment in sides]),
        ("m2", [f"{moment.slope:.4g}" for _, moment in sides]),
        ("m4", [f"{moment.curvature:.4g} 1/µm²" for _, moment in sides]),
        ("Nayak's parameter", [f"{moment.nayak_parameter:.4g}" for _, moment in sides]),
        ("Hurst exponent H", [_line_hurst(line) for line, _ in sides]),
        (
            "fitted band",
            ["none" if line.band is None else " to ".join(map(length_text, line.band)) for line, _ in sides],
        ),
        ("scatter", [_misfit(line) for line, _ in sides]),
    ]
    if band is None and along_x.band != along_y.band:
        columns.append(("band found in", [f"{line.with_band} of {line.fitted} lines" for line, _ in sides]))
    rows += [(f"  {name}", *values) for name, values in columns]
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
    return rows


RADIAL_BINS = 20


def _str(shortest: float, ratio: float, surface: Surface) -> str:
    if math.isnan(ratio) and not math.isnan(shortest):
        return f"below {shortest / (min(surface.extent) / 2):.2g}: no decay to 0.2 along the lay within half the map"
    return "none, without Sal" if math.isnan(ratio) else f"{ratio:.3f}"


def _misfit(line: LineRoughness) -> str:
    """How far the mean spectrum is off its line."""
    if math.isnan(line.misfit):
        return "none"
    return f"factor {line.misfit:.2f}" + (", no line" if line.misfit > BENT else "")


def _line_hurst(line: LineRoughness) -> str:
    values = line.hurst_exponents
    if not values.size:
        return "none"
    return f"{values.mean():.3f} ± {values.std():.3f}" + (" (smooth)" if values.mean() > 1 else "")
