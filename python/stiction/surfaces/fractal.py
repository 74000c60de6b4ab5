"""Fractal profiles and height maps: the Weierstrass-Mandelbrot function of Hanaor, Gan & Einav (2016), Eq. 1."""

from __future__ import annotations

import math
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

import stiction._core
from stiction._checks import Floats, check_choice, float_array, make_read_only, validate_number, validate_whole_number
from stiction._units import short_repr
from stiction.surfaces.profile import MAX_POINTS, MIN_POINTS, Profile, Side
from stiction.surfaces.spectrum import ProfileMoments
from stiction.surfaces.surface import Surface, parse_lengths, parse_shape

FractalConvention = Literal["paper", "classical"]
BandLimit = Literal["nyquist"]
SIDE_SEED_KEYS = {"lower": 0, "upper": 1}


def random_phases(
    seed: int, *, repetition: int = 0, side: Side = "lower", directions: int = 40, frequencies: int = 40
) -> Floats:
    """Generate the random phases (rad) of one Weierstrass-Mandelbrot surface.

    Parameters
    ----------
    seed, repetition : int
        Numbers, at least 0, that select the surface.
    side : {"lower", "upper"}
        Body of the pair.
    directions, frequencies : int
        Shape of the array: M and n_max of Eq. 1, at least 1.

    Returns
    -------
    phases : (directions, frequencies) ndarray of float, rad
        Independent random numbers, uniform on [0, 2π).

    Raises
    ------
    ValueError
        If an argument is outside its range.

    See Also
    --------
    weierstrass_mandelbrot : Profile with these phases.

    Notes
    -----
    The phases depend only on (seed, repetition, side). They are the upper 53 bits of the 64-bit words of
    ``PCG64(SeedSequence([seed, repetition, side]))`` times 2π/2^53, in row-major order, with side 0 for the lower and 1
    for the upper body. NumPy guarantees these words across versions, unlike the streams of its ``Generator``.

    Examples
    --------
    >>> from stiction import random_phases
    >>> random_phases(2016, directions=1, frequencies=2)
    array([[6.07702677, 2.1342465 ]])
    """
    check_choice("side", side, Side)
    seed = validate_whole_number("seed", seed, minimum=0)
    repetition = validate_whole_number("repetition", repetition, minimum=0)
    directions = validate_whole_number("directions", directions, minimum=1)
    frequencies = validate_whole_number("frequencies", frequencies, minimum=1)
    random_words = np.random.PCG64(np.random.SeedSequence([seed, repetition, SIDE_SEED_KEYS[side]]))
    random_bits = random_words.random_raw(directions * frequencies) >> np.uint64(11)
    phases = random_bits.astype(np.float64) * (2 * math.pi / 2**53)
    return phases.reshape(directions, frequencies)


def hurst_from_fractal_dimension(fractal_dimension: float, *, convention: FractalConvention = "paper") -> float:
    """Return the Hurst exponent of a Weierstrass-Mandelbrot profile with the fractal dimension D.

    It is 4 - 2D in the paper's convention and 2 - D in the classical convention.
    """
    check_choice("convention", convention, FractalConvention)
    dimension = validate_number("fractal_dimension", fractal_dimension)
    if not 1 <= dimension < 2:
        raise ValueError(f"fractal_dimension must be at least 1 and below 2, got {short_repr(fractal_dimension)}")
    return 4 - 2 * dimension if convention == "paper" else 2 - dimension


def weierstrass_mandelbrot_family(
    phases: ArrayLike,
    fractal_dimensions: ArrayLike,
    *,
    length_scale: float = 1.0,
    gamma: float = 1.5,
    extent: float = 40.0,
    points: int = 150_000,
    convention: FractalConvention = "paper",
    band_limit: BandLimit | None = None,
) -> Floats:
    r"""Compute Weierstrass-Mandelbrot profiles with equal phases, one for each of several fractal dimensions.

    Parameters
    ----------
    phases : (directions, frequencies) array_like of float, rad
        Phases φ, such as those of `random_phases`; the shape is (M, n_max).
    fractal_dimensions : (k,) array_like of float
        D of every profile, at least 1 and below 2.
    length_scale : float, µm
        L, the longest wavelength.
    gamma : float
        γ, ratio of successive frequencies, above 1.
    extent : float, µm
        Length of the profiles; point j lies at j extent / points.
    points : int
        Number of points, at least 4.
    convention, band_limit
        As for `weierstrass_mandelbrot`.

    Returns
    -------
    heights : (k, points) ndarray of float, µm
        Unscaled heights with y(0) = 0, one row per fractal dimension.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the phases of the highest frequencies cannot be resolved.

    See Also
    --------
    weierstrass_mandelbrot : Single profile, with the equation.

    Notes
    -----
    The rows share the phases, so they differ only in the fractal dimension. Hanaor, Gan & Einav, Tribology
    International 93 (2016) 229, Eq. 1.

    Examples
    --------
    >>> from stiction import random_phases, weierstrass_mandelbrot_family
    >>> weierstrass_mandelbrot_family(random_phases(1), [1.1, 1.3], points=2000).shape
    (2, 2000)
    """
    points = validate_whole_number("points", points, minimum=MIN_POINTS, maximum=MAX_POINTS)
    fractal_dimensions = float_array("fractal_dimensions", fractal_dimensions, ndim=1)
    family = np.empty((fractal_dimensions.size, points))
    fill_profile_family(
        family, phases, fractal_dimensions, length_scale=length_scale, gamma=gamma, extent=extent,
        convention=convention, band_limit=band_limit,
    )  # fmt: skip
    return family


def fill_profile_family(
    family: Floats, phases: ArrayLike, fractal_dimensions: ArrayLike, *, length_scale: float, gamma: float,
    extent: float, convention: FractalConvention, band_limit: BandLimit | None,
) -> Floats:  # fmt: skip
    """Compute the profiles of `weierstrass_mandelbrot_family`, and write their heights to the rows of `family`.

    Returns the mean, minimum and maximum of each profile, (k, 3).
    """
    phase_array = float_array("phases", phases, ndim=2)
    dimensions = float_array("fractal_dimensions", fractal_dimensions, ndim=1)
    extent = validate_number("extent", extent, unit="µm", above=0)
    num_frequencies = phase_array.shape[1]
    scale, gamma = _validate_length_scale_and_gamma(length_scale, gamma, band_limit)
    amplitudes = [
        _compute_frequency_amplitudes(dimension, num_frequencies, scale, gamma, convention) for dimension in dimensions
    ]
    return stiction._core.harmonic_profiles(
        phase_array, np.array(amplitudes).reshape(len(amplitudes), num_frequencies), family,
        spacing=extent / family.shape[1], length_scale=scale, gamma=gamma, band_limited=band_limit == "nyquist",
    )  # fmt: skip


def _validate_length_scale_and_gamma(length_scale: Any, gamma: Any, band_limit: Any) -> tuple[float, float]:
    if band_limit is not None:
        check_choice("band_limit", band_limit, BandLimit)
    return validate_number("length_scale", length_scale, unit="µm", above=0), validate_number("gamma", gamma, above=1)


def _compute_frequency_amplitudes(
    dimension: Any, frequencies: int, scale: float, gamma: float, convention: FractalConvention
) -> Floats:
    """Return the amplitude (µm) of each frequency in the Weierstrass-Mandelbrot function (Eq. 1 of the paper)."""
    hurst = hurst_from_fractal_dimension(dimension, convention=convention)
    return np.array(stiction._core.frequency_weights(hurst, frequencies, gamma, scale))


def weierstrass_mandelbrot(
    phases: ArrayLike,
    fractal_dimension: float,
    *,
    length_scale: float = 1.0,
    gamma: float = 1.5,
    extent: float = 40.0,
    points: int = 150_000,
    convention: FractalConvention = "paper",
    band_limit: BandLimit | None = None,
) -> Profile:
    r"""Generate a Weierstrass-Mandelbrot profile (Eq. 1 of the paper).

    Parameters
    ----------
    phases : (directions, frequencies) array_like of float, rad
        Phases φ, such as those of `random_phases`; the shape is (M, n_max).
    fractal_dimension : float
        D, at least 1 and below 2.
    length_scale : float, µm
        L, the longest wavelength.
    gamma : float
        γ, ratio of successive frequencies, above 1.
    extent : float, µm
        Length of the profile; point j lies at j extent / points.
    points : int
        Number of points, at least 4.
    convention : {"paper", "classical"}
        Definition of the fractal dimension D: the Hurst exponent is 4 - 2D ("paper") or 2 - D ("classical").
    band_limit : {None, "nyquist"}
        None keeps the harmonics above the grid's Nyquist frequency, as the paper does; they are aliased.
        "nyquist" drops them.

    Returns
    -------
    profile : Profile
        Unscaled heights (µm) with y(0) = 0; see `Profile.with_amplitude`.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the phases of the highest frequencies cannot be resolved.

    See Also
    --------
    weierstrass_mandelbrot_family : Heights for several fractal dimensions.
    weierstrass_mandelbrot_surface : Equation 1 over an area.

    Notes
    -----
    .. math:: y(x) = L^H \ln γ \sum_{m,n} γ^{-(n-1)H}
              \left\{\cos φ_{mn} - \cos\left[\frac{2πγ^{n-1}x}{L} \cos\frac{πm}{M} + φ_{mn}\right]\right\}

    Hanaor, Gan & Einav, Tribology International 93 (2016) 229, Eq. 1.

    Examples
    --------
    >>> from stiction import random_phases, weierstrass_mandelbrot
    >>> profile = weierstrass_mandelbrot(random_phases(1), 1.3, points=1000)
    >>> len(profile), profile.extent
    (1000, 40.0)
    """
    family = weierstrass_mandelbrot_family(
        phases, [validate_number("fractal_dimension", fractal_dimension)], length_scale=length_scale, gamma=gamma,
        extent=extent, points=points, convention=convention, band_limit=band_limit,
    )  # fmt: skip
    return Profile(make_read_only(family[0]), spacing=float(extent) / points)


def weierstrass_mandelbrot_surface(
    phases: ArrayLike,
    fractal_dimension: float,
    *,
    shape: tuple[int, int],
    extent: float | tuple[float, float] = 40.0,
    length_scale: float = 1.0,
    gamma: float = 1.5,
    convention: FractalConvention = "paper",
    band_limit: BandLimit | None = None,
) -> Surface:
    r"""Generate a Weierstrass-Mandelbrot height map (Eq. 1 of the paper, evaluated over an area).

    Without a band limit, the first row is the profile with the same phases.

    Parameters
    ----------
    phases : (directions, frequencies) array_like of float, rad
        Phases φ, such as those of `random_phases`; the shape is (M, n_max).
    fractal_dimension : float
        D of the profiles, at least 1 and below 2.
    shape : (int, int)
        Rows (along y) and columns (along x).
    extent : float or (float, float), µm
        Lengths along y and x; one number for both. Rows are extent_y / rows apart, columns extent_x / columns.
    length_scale : float, µm
        L, the longest wavelength.
    gamma : float
        γ, ratio of successive frequencies, above 1.
    convention : {"paper", "classical"}
        As for `weierstrass_mandelbrot`.
    band_limit : {None, "nyquist"}
        As for `weierstrass_mandelbrot`; "nyquist" drops the harmonics above the Nyquist frequency of either axis.

    Returns
    -------
    surface : Surface
        Unscaled heights (µm) with y(0, 0) = 0; see `Surface.with_amplitude`.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the phases of the highest frequencies cannot be resolved.

    See Also
    --------
    weierstrass_mandelbrot : Profile, with the equation.

    Notes
    -----
    The phase of harmonic (m, n) is :math:`2πγ^{n-1}/L (x \cos(πm/M) + y \sin(πm/M)) + φ_{mn}`.
    Hanaor, Gan & Einav, Tribology International 93 (2016) 229, Fig. 3.

    Examples
    --------
    >>> from stiction import random_phases, weierstrass_mandelbrot_surface
    >>> surface = weierstrass_mandelbrot_surface(random_phases(1), 1.3, shape=(64, 128), extent=(2.0, 4.0))
    >>> surface.heights.shape, surface.spacing
    ((64, 128), (0.03125, 0.03125))
    """
    phase_array = float_array("phases", phases, ndim=2)
    if not phase_array.size:
        raise ValueError(f"phases must have at least one direction and one frequency, got shape {phase_array.shape}")
    num_frequencies = phase_array.shape[1]
    rows, columns = parse_shape(shape, min_count=2)
    extents = parse_lengths("extent", extent)
    scale, gamma = _validate_length_scale_and_gamma(length_scale, gamma, band_limit)
    amplitudes = _compute_frequency_amplitudes(fractal_dimension, num_frequencies, scale, gamma, convention)
    heights = np.empty((rows, columns))
    spacing = extents[0] / rows, extents[1] / columns
    stiction._core.harmonic_surface(
        phase_array, amplitudes, heights, spacing_y=spacing[0], spacing_x=spacing[1], length_scale=scale,
        gamma=gamma, band_limited=band_limit == "nyquist",
    )  # fmt: skip
    return Surface(make_read_only(heights), spacing=spacing)


def weierstrass_mandelbrot_moments(
    fractal_dimension: float,
    *,
    directions: int = 40,
    frequencies: int = 40,
    length_scale: float = 1.0,
    gamma: float = 1.5,
    convention: FractalConvention = "paper",
    shortest_wavelength: float = 0.0,
) -> ProfileMoments:
    """Compute the exact spectral moments of Weierstrass-Mandelbrot profiles.

    Parameters
    ----------
    fractal_dimension : float
        D, at least 1 and below 2.
    directions, frequencies : int
        M and n_max, at least 1.
    length_scale : float, µm
        L, the longest wavelength.
    gamma : float
        γ, ratio of successive frequencies, above 1.
    convention : {"paper", "classical"}
        As for `weierstrass_mandelbrot`.
    shortest_wavelength : float, µm
        Harmonics shorter than this are excluded: use twice the spacing for ``band_limit="nyquist"``, 0 to include all.
        Aliasing on a grid is not considered.

    Returns
    -------
    moments : ProfileMoments
        Variances of height (µm²), slope and curvature (1/µm²) along x.

    Raises
    ------
    ValueError
        If an argument is outside its range.

    See Also
    --------
    spectral_moments : Moments of a given profile.

    Notes
    -----
    With amplitudes a and wave numbers k of the harmonics, the moments are Σ a² k^(2j) / 2 for j = 0, 1, 2.

    Examples
    --------
    >>> from stiction import weierstrass_mandelbrot_moments
    >>> moments = weierstrass_mandelbrot_moments(1.5, directions=1, frequencies=1)
    >>> round(moments.height, 6)  # half the square of one amplitude, ln 1.5
    0.082201
    """
    directions = validate_whole_number("directions", directions, minimum=1)
    frequencies = validate_whole_number("frequencies", frequencies, minimum=1)
    scale, gamma = _validate_length_scale_and_gamma(length_scale, gamma, None)
    shortest = validate_number("shortest_wavelength", shortest_wavelength, unit="µm")
    amplitudes = _compute_frequency_amplitudes(fractal_dimension, frequencies, scale, gamma, convention)
    m = np.arange(1, directions + 1)
    cosines = np.where(2 * m == directions, 0.0, np.cos(np.pi * m / directions))
    wave_numbers = 2 * np.pi / scale * np.outer(cosines, gamma ** np.arange(frequencies))
    is_included = (wave_numbers != 0) & (np.abs(wave_numbers) * shortest <= 2 * np.pi)
    variances = np.where(is_included, 0.5 * amplitudes**2, 0.0)
    return ProfileMoments(*(float((variances * wave_numbers ** (2 * j)).sum()) for j in range(3)))
