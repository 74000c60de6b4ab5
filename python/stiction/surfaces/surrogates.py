"""Surrogates: random profiles and height maps with the spectrum of a measured profile or height map."""

from __future__ import annotations

import math

import numpy as np

from stiction._checks import Floats, check_bool
from stiction.surfaces.fractal import random_phases
from stiction.surfaces.profile import Profile, Side, reject_missing_points
from stiction.surfaces.spectrum import RadialSpectrum, power_spectrum, surface_spectrum
from stiction.surfaces.surface import AnyBody, Surface, as_body, parse_shape, reject_flat_body

_RINGS_PER_DECADE = 12
# Weight of the smoothness penalty, which dominates the fit in rings with fewer harmonics than this number.
_SMOOTHNESS_PENALTY = 2.0
_DENSITY_ROUND_OFF_FRACTION = 1e-14
# Maximum number of iterations in the fit of a surrogate's spectrum; about ten are usually enough.
_MAX_SPECTRUM_FIT_STEPS = 1000
_LOG_DENSITY_TOLERANCE = 1e-6
# Default limit for points per side of a surrogate: 512 × 512 points take tenths of a second in a half-space solution.
_MAX_DEFAULT_SIDE_POINTS = 512


def surrogate(
    body: AnyBody, seed: int, *, repetition: int = 0, side: Side = "lower", periodic: bool = False
) -> AnyBody:
    """Generate a profile or map that has the spectrum of a given profile or map, but random phases.

    Surrogates with different seeds or repetitions form an ensemble for a measured surface.

    Parameters
    ----------
    body : Profile or Surface
        Body to imitate. Level the body first unless it is periodic, because a tilt would become a wave as long as the
        body.
    seed, repetition : int
        Numbers, at least 0, that select the random phases.
    side : {"lower", "upper"}
        Body of the pair. `random_phases` returns the phases for `seed`, `repetition` and `side`.
    periodic : bool
        True if the given body is periodic. Its spectrum is then preserved except for round-off.

    Returns
    -------
    result : Profile or Surface
        Periodic body with the same number of points, mean, and Pq or Sq.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the body is flat.

    See Also
    --------
    isotropic_surface : Areal surrogate of a profile.

    Notes
    -----
    A profile that is not periodic is extended by its mirror image, which avoids a jump. The spectrum of the extended
    profile is then averaged to the wave numbers of the original. The surrogate is scaled to the Pq of the profile. The
    corners at both ends of the mirror image add a spectrum of 1/q⁴, and every density is averaged with half of each
    neighbour. Therefore the surrogate has no sharp spectral lines, and too much power at short wavelengths if H is near
    1.5 or above.

    A mirror image of a surface would mix the directions of its waves, so a Hann window is applied along both axes. The
    spectrum is then that of the central part, smoothed over neighbouring wave vectors. The contribution of wavelengths
    as long as the map is not preserved.

    Random phases preserve the spectrum only. The heights become normally distributed: the surrogate of a worn or
    plateau-honed profile has no skewness, and grooves and other features are spread over the whole length. Theiler et
    al., Physica D 58 (1992) 77.

    Examples
    --------
    >>> from stiction import roughness_parameters, self_affine, surrogate
    >>> measured = self_affine(1, hurst_exponent=0.8, rms=0.1, points=1000, spacing=0.01)
    >>> ensemble = [surrogate(measured, 2016, repetition=repetition) for repetition in range(10)]
    >>> round(roughness_parameters(ensemble[0]).Pq / roughness_parameters(measured).Pq, 12)
    1.0
    """
    body = as_body("body", body)
    check_bool("periodic", periodic)
    reject_flat_body(body)
    reject_missing_points(body, "a surrogate")
    if isinstance(body, Surface):
        return _surface_surrogate(body, seed, repetition, side, periodic)  # type: ignore[return-value]
    profile, mean = body, body.heights.mean()
    heights = profile.heights - mean
    points = heights.size
    if periodic:
        amplitude = np.abs(np.fft.rfft(heights))
    else:
        # Mirroring avoids a jump between the ends but adds odd harmonics: each even neighbour gets half of their power.
        mirrored_power = np.abs(np.fft.rfft(np.concatenate([heights, heights[::-1]]))) ** 2 / 2
        mirrored_power = np.append(mirrored_power, mirrored_power[-2])
        harmonic_indices = 2 * np.arange(points // 2 + 1)
        amplitude = np.sqrt(
            mirrored_power[harmonic_indices] / 2
            + mirrored_power[np.abs(harmonic_indices - 1)] / 4
            + mirrored_power[harmonic_indices + 1] / 4
        )
    phases = random_phases(seed, repetition=repetition, side=side, directions=points // 2, frequencies=1)[:, 0]
    transform = np.zeros(points // 2 + 1, dtype=np.complex128)
    transform[1:] = amplitude[1:] * np.exp(1j * phases)
    if points % 2 == 0:
        transform[-1] = math.copysign(amplitude[-1], math.cos(phases[-1]))
    surrogate_heights = np.fft.irfft(transform, points)
    surrogate_heights *= math.sqrt(np.mean(heights**2) / np.mean(surrogate_heights**2))
    return Profile(surrogate_heights + mean, spacing=profile.spacing)  # type: ignore[return-value]


def _surface_surrogate(surface: Surface, seed: int, repetition: int, side: Side, periodic: bool) -> Surface:
    from scipy.fft import ifft2, ifftshift

    amplitude = np.sqrt(ifftshift(surface_spectrum(surface, periodic=periodic).density))
    rows, columns = amplitude.shape
    phases = random_phases(seed, repetition=repetition, side=side, directions=rows, frequencies=columns)
    # Opposite wave vectors get opposite phases, so that the heights are real.
    opposite_phases = np.roll(phases[::-1, ::-1], (1, 1), axis=(0, 1))
    heights = ifft2(amplitude * np.exp(1j * (phases - opposite_phases))).real
    is_real = np.zeros((rows, columns), dtype=bool)
    is_real[np.ix_([0, rows // 2] if rows % 2 == 0 else [0], [0, columns // 2] if columns % 2 == 0 else [0])] = True
    heights += ifft2(np.where(is_real, amplitude * (np.sign(np.cos(phases)) - 1), 0)).real
    heights *= surface.heights.std() / heights.std()
    return Surface(heights + surface.heights.mean(), spacing=surface.spacing)


def isotropic_spectrum(profile: Profile, *, periodic: bool = False) -> RadialSpectrum:
    r"""Estimate the spectrum C2D of an isotropic surface from a profile of this surface.

    Parameters
    ----------
    profile : Profile
        Profile along any line of the surface. Level it first unless it is periodic.
    periodic : bool
        As for `power_spectrum`.

    Returns
    -------
    spectrum : RadialSpectrum
        Densities (µm⁴) in rings of the wave number (1/µm), from the profile's first harmonic to the corners of the
        grid. The count is the number of the profile's harmonics in every ring.

    Raises
    ------
    ValueError
        If the profile is flat.

    See Also
    --------
    isotropic_surface : Random surface with this spectrum.

    Notes
    -----
    The spectrum of a section integrates over the wave numbers across it,

    .. math:: C^{1D}(k) = \frac1π \int_0^{π/Δx} C^{2D}(\sqrt{k^2 + s^2})\,ds,

    which is an Abel integral if the spectrum ends before the Nyquist wave number. Its inverse is
    :math:`C^{2D}(q) = -2 \int_q^\infty dC^{1D}/dk\,(k^2 - q^2)^{-1/2} dk`, but the derivative of a measured spectrum is
    dominated by scatter. Instead, C2D is constant in every ring and fitted by maximum likelihood: for the section
    spectrum :math:`C_k` it minimises :math:`\sum_k P_k / C_k + \ln C_k` (Whittle, Arkiv för Matematik 2 (1953) 423)
    plus a small penalty on the curvature of its logarithm. It is scaled so that sections have the mean square slope of
    the profile; the surface has twice that mean square gradient.

    Examples
    --------
    >>> from stiction import isotropic_spectrum, self_affine
    >>> profile = self_affine(1, hurst_exponent=0.8, rms=0.1, points=4096, spacing=0.01, periodic=True)
    >>> spectrum = isotropic_spectrum(profile, periodic=True)
    >>> bool((spectrum.density > 0).all())
    True
    """
    profile = as_body("profile", profile, Profile)
    edges, density, count = _fit_ring_densities(profile, periodic)
    return RadialSpectrum(wave_number=np.sqrt(edges[1:] * edges[:-1]), density=density, count=count)


def isotropic_surface(
    profile: Profile,
    seed: int,
    *,
    shape: tuple[int, int] | None = None,
    repetition: int = 0,
    side: Side = "lower",
    periodic: bool = False,
) -> Surface:
    """Generate an isotropic Gaussian height map with the spectrum of a profile, to replace the profile by a map.

    An ensemble of areal surrogates represents the surface from which the profile was measured, *if* this surface is
    isotropic. A profile across the grooves of a ground surface yields hills instead of grooves, with an rms gradient
    that is larger by the square root of two.

    Parameters
    ----------
    profile : Profile
        Profile along any line of the surface. Level it first unless it is periodic.
    seed, repetition : int
        Numbers, at least 0, that select the random surface.
    shape : (int, int), optional
        Rows and columns, at least 4 each; by default the number of points of the profile, at most 512. Wavelengths
        longer than the surface are excluded.
    side : {"lower", "upper"}
        Body of the pair. `random_phases` returns the random numbers for `seed`, `repetition` and `side`.
    periodic : bool
        True if the given profile is periodic. The generated surface is always periodic.

    Returns
    -------
    surface : Surface
        Surface with the profile's spacing along both axes and zero mean. Its mean spectrum is `isotropic_spectrum`.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the profile is flat.

    See Also
    --------
    surrogate : Random profile or map with the spectrum of a given one.

    Examples
    --------
    >>> from stiction import isotropic_surface, self_affine
    >>> profile = self_affine(1, hurst_exponent=0.8, rms=0.1, points=1000, spacing=0.01, longest_wavelength=1.0)
    >>> isotropic_surface(profile, 2016, shape=(128, 128)).extent
    (1.28, 1.28)
    """
    profile = as_body("profile", profile, Profile)
    default_size = min(len(profile), _MAX_DEFAULT_SIDE_POINTS)
    rows, columns = parse_shape((default_size, default_size) if shape is None else shape, min_count=4)
    edges, density, _ = _fit_ring_densities(profile, periodic)
    q_y, q_x = (2 * math.pi * np.fft.fftfreq(points, profile.spacing) for points in (rows, columns))
    q = np.hypot(q_y[:, np.newaxis], q_x)
    # The ring index 0 stands for wavelengths longer than the profile.
    ring_index = np.searchsorted(edges, q, side="right")
    power = np.concatenate([[0.0], density, density[-1:]])[ring_index] * (rows * columns / profile.spacing**2)
    history_entry = f"an isotropic surface of its spectrum, seed {seed}, repetition {repetition}"
    heights, spacings = gaussian_heights(power, seed, repetition, side), (profile.spacing, profile.spacing)
    return Surface(heights, spacing=spacings, history=(*profile.history, history_entry))


def gaussian_heights(power: Floats, seed: int, repetition: int, side: Side) -> Floats:
    """Generate periodic Gaussian heights from the expected power of each wave vector."""
    from scipy.fft import ifft2

    rows, columns = power.shape
    random_values = random_phases(seed, repetition=repetition, side=side, directions=rows, frequencies=2 * columns)
    phases, uniform_numbers = random_values[:, :columns], random_values[:, columns:] / (2 * math.pi)
    # The heights are the real part of the transform, which has half of the power, so the power is multiplied by 2.
    coefficients = np.sqrt(-2 * power * np.log1p(-uniform_numbers)) * np.exp(1j * phases)
    return np.asarray(ifft2(coefficients, overwrite_x=True).real)


def _fit_ring_densities(profile: Profile, periodic: bool) -> tuple[Floats, Floats, Floats]:
    """Fit an isotropic density C2D, constant in each ring of wave vectors, to the spectrum of a profile.

    Returns the edges of the rings, the densities, and the numbers of harmonics.
    """
    check_bool("periodic", periodic)
    reject_flat_body(profile)
    reject_missing_points(profile, "an isotropic surrogate")
    spectrum = power_spectrum(profile, periodic=periodic)
    # A harmonic represents all wave numbers that differ from its own wave number by up to half a step.
    wave_number, resolution, nyquist_wave_number = spectrum.wave_number, spectrum.resolution, math.pi / profile.spacing
    bins = np.floor(_RINGS_PER_DECADE * np.log10(wave_number / wave_number[0]) + 1e-9)
    first_harmonics = np.flatnonzero(np.diff(bins, prepend=-1))
    edges = np.append(wave_number[first_harmonics] - resolution / 2, nyquist_wave_number)
    bin_index = np.searchsorted(edges, wave_number, side="right") - 1
    bin_index = np.minimum(bin_index, edges.size - 2)
    wave_count = np.bincount(bin_index, spectrum.count).astype(np.float64)
    measured_density = np.bincount(bin_index, spectrum.count * spectrum.density) / wave_count
    measured_density = np.maximum(measured_density, _DENSITY_ROUND_OFF_FRACTION * measured_density.max())
    # A further ring covers the corners of the Fourier grid, where both wave numbers approach the Nyquist wave number.
    edges = np.append(edges, math.sqrt(2) * nyquist_wave_number * (1 + 1e-9))
    # Mean spectral density of scan lines in each bin, for surfaces with the density 1 in one ring and 0 in all others.
    transverse_wave_number = np.minimum(
        np.sqrt(np.maximum(edges**2 - wave_number[:, np.newaxis] ** 2, 0)), nyquist_wave_number
    )
    ring_responses = np.diff(transverse_wave_number, axis=1) / math.pi
    response = np.zeros((wave_count.size, edges.size - 1))
    np.add.at(response, bin_index, spectrum.count[:, np.newaxis] * ring_responses)
    response /= wave_count[:, np.newaxis]
    density = np.full(edges.size - 1, 1.0)
    density[: measured_density.size] = measured_density / np.sqrt(edges[:-2] * edges[1:-1])
    density[-1] = density[-2]
    density = _fit_densities(response, measured_density, wave_count, density)
    predicted_density = response @ density
    slope_weights = np.bincount(bin_index, spectrum.count * wave_number**2)
    density *= float(slope_weights @ measured_density / (slope_weights @ predicted_density))
    return edges, density, np.append(wave_count, 0.0)


def _fit_densities(response: Floats, measured_density: Floats, count: Floats, density: Floats) -> Floats:
    """Fit the spectral densities of rings of wave vectors to a profile's spectrum by penalised maximum likelihood.

    The likelihood is maximized by Fisher scoring.
    """

    def compute_misfit_and_penalty(log_density: Floats) -> float:
        predicted_density = response @ np.exp(log_density)
        return float(
            count @ (measured_density / predicted_density + np.log(predicted_density))
            + _SMOOTHNESS_PENALTY / 2 * np.square(second_difference @ log_density).sum()
        )

    second_difference = np.diff(np.eye(density.size), 2, axis=0)
    log_density = np.log(density)
    lowest_cost = compute_misfit_and_penalty(log_density)
    for _ in range(_MAX_SPECTRUM_FIT_STEPS):
        contributions = response * np.exp(log_density)
        fitted_density = contributions.sum(axis=1)
        gradient = contributions.T @ (
            count * (1 - measured_density / fitted_density) / fitted_density
        ) + _SMOOTHNESS_PENALTY * second_difference.T @ (second_difference @ log_density)
        relative_contributions = contributions / fitted_density[:, np.newaxis]
        step = np.linalg.solve(
            (relative_contributions.T * count) @ relative_contributions
            + _SMOOTHNESS_PENALTY * second_difference.T @ second_difference,
            gradient,
        )
        step *= min(1.0, 2 / np.abs(step).max())
        while (current_cost := compute_misfit_and_penalty(log_density - step)) > lowest_cost and np.abs(
            step
        ).max() > _LOG_DENSITY_TOLERANCE:
            step /= 2
        if current_cost > lowest_cost or np.abs(step).max() <= _LOG_DENSITY_TOLERANCE:
            break
        log_density, lowest_cost = log_density - step, current_cost
    return np.asarray(np.exp(log_density))
