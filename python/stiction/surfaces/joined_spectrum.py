"""Spectrum of a surface, joined from several scans; each scan contributes the wavelengths at which it is reliable."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stiction._checks import Floats, make_read_only, validate_number, validate_whole_number
from stiction._repr import TextReprMixin
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile, Side
from stiction.surfaces.scale import ScaleDependentRoughness, instrument_limit
from stiction.surfaces.spectrum import surface_spectrum
from stiction.surfaces.surface import Surface, as_body, parse_lengths, parse_shape
from stiction.surfaces.surrogates import gaussian_heights, isotropic_spectrum

# Minimum used wavelength (points) of a scan. At this wavelength, averaging over each pixel removes 5 % of the power.
MIN_POINTS_PER_WAVELENGTH = 8
# Maximum used wavelength, as a fraction of the scan's side. The window function distorts longer wavelengths.
MAX_WAVELENGTH_TO_SIDE = 1 / 3
# Wave vectors per independent density: densities are equal at opposite vectors, and correlated at neighbours.
_WAVE_VECTORS_PER_INDEPENDENT_VALUE = 4.0


@dataclass(frozen=True, eq=False, repr=False)
class JoinedSpectrum(TextReprMixin):
    """Spectrum of an isotropic surface over all wavelengths that at least one of several scans resolves.

    Attributes
    ----------
    wave_number : (n,) ndarray of float, 1/µm
        Centres of bins of equal width in log q, ascending.
    density : (n,) ndarray of float, µm⁴
        C2D: mean over the scans that resolve the bin, weighted by their numbers of wave vectors. In a gap between
        scans, C2D is interpolated by a power law.
    count : (n,) ndarray of float
        Number of wave vectors in every bin, 0 in a gap.
    contribution : (scans, n) ndarray of float
        Fraction of the wave vectors of a bin that comes from a scan.
    ratio : (scans, n) ndarray of float
        Ratio of the density of a scan to the combined density; NaN in bins without data of the scan.
    bands : tuple of (float, float), µm
        Shortest and longest wavelength used from every scan.
    reasons : tuple of str
        Reason for the shortest wavelength of every scan: "pixels", "noise floor", "tip" or "given".
    names : tuple of str
        Names of the scans.

    Examples
    --------
    >>> from stiction import Surface, joined_spectrum, self_affine_surface
    >>> fine = self_affine_surface(1, hurst_exponent=0.8, rms=0.1, shape=(256, 256), spacing=0.01)
    >>> scans = [Surface(fine.heights[::4, ::4], spacing=0.04), Surface(fine.heights[:96, :96], spacing=0.01)]
    >>> len(joined_spectrum(scans).bands)
    2
    """

    wave_number: Floats = field(metadata={"unit": "1/µm"})
    density: Floats = field(metadata={"unit": "µm⁴"})
    count: Floats
    contribution: Floats
    ratio: Floats
    bands: tuple[tuple[float, float], ...] = field(metadata={"unit": "µm"})
    reasons: tuple[str, ...]
    names: tuple[str, ...]

    @property
    def shortest(self) -> float:
        """Shortest wavelength of the spectrum (µm), at the edge of the last bin."""
        return float(2 * math.pi / (self.wave_number[-1] * self._bin_edge_ratio))

    @property
    def longest(self) -> float:
        """Longest wavelength of the spectrum, µm."""
        return float(2 * math.pi / (self.wave_number[0] / self._bin_edge_ratio))

    @property
    def _bin_edge_ratio(self) -> float:
        """Ratio of the wave number at the upper edge of a bin to the wave number at the centre of the bin."""
        return math.sqrt(self.wave_number[1] / self.wave_number[0])

    @property
    def history(self) -> tuple[str, ...]:
        """Description of the spectrum: its wavelengths, and the names and wavelength bands of the joined scans."""
        scans = (
            f"{name} ({shortest:.4g} to {longest:.4g} µm)"
            for name, (shortest, longest) in zip(self.names, self.bands, strict=True)
        )
        names_text = f", from {', '.join(scans)}" if self.names else ""
        return (f"power spectrum at wavelengths of {self.shortest:.4g} to {self.longest:.4g} µm{names_text}",)

    @property
    def disagreement(self) -> Floats:
        """Spectral density of each scan, relative to that of the other scans, as a mean over shared wavelengths.

        The shape is (scans,). The mean is NaN for a scan without overlap.
        """
        is_shared = (self.contribution > 0).sum(axis=0) > 1
        ratios = np.full(len(self.bands), np.nan)
        for scan_index, ratio in enumerate(self.ratio):
            is_compared = is_shared & np.isfinite(ratio)
            weight = self.contribution[scan_index, is_compared]
            if is_compared.any() and (weight < 1).any():
                # A scan is compared with the joined density of the other scans, so its own contribution is removed.
                other_density = (1 - weight * ratio[is_compared]) / (1 - weight)
                with np.errstate(divide="ignore", invalid="ignore"):
                    log_ratios = np.log(ratio[is_compared] / other_density)
                ratios[scan_index] = (
                    math.exp(float(np.average(log_ratios, weights=self.count[is_compared])))
                    if (other_density > 0).all()
                    else np.inf
                )
        return make_read_only(ratios)

    @property
    def chance(self) -> Floats:
        """Standard deviation of ln(`disagreement`) that random scatter alone causes if all scans have equal spectra."""
        is_shared = (self.contribution > 0).sum(axis=0) > 1
        independent_counts = self.contribution * self.count / _WAVE_VECTORS_PER_INDEPENDENT_VALUE
        log_deviations = np.full(len(self.bands), np.nan)
        for scan_index, scan_counts in enumerate(independent_counts):
            is_compared = is_shared & (scan_counts > 0)
            if is_compared.any():
                other_counts = independent_counts[:, is_compared].sum(axis=0) - scan_counts[is_compared]
                weight = self.count[is_compared] / self.count[is_compared].sum()
                log_deviations[scan_index] = math.sqrt(
                    float(np.square(weight) @ (1 / scan_counts[is_compared] + 1 / other_counts))
                )
        return make_read_only(log_deviations)

    def roughness(self) -> ScaleDependentRoughness:
        """Compute the rms slope and rms curvature of the surface as functions of the shortest included wavelength."""
        log_step = math.log(self.wave_number[1] / self.wave_number[0])
        rms_values = []
        for power, factor in ((2, 1.0), (4, 0.25)):
            variance_terms = factor * self.wave_number ** (power + 2) * self.density * log_step / (2 * math.pi)
            # The integral over wave numbers ends at a bin's centre, so only half of this bin's variance counts.
            rms_values.append(np.sqrt(variance_terms.cumsum() - variance_terms / 2))
        return ScaleDependentRoughness(
            wavelength=make_read_only(2 * math.pi / self.wave_number), gradient=make_read_only(rms_values[0]),
            curvature=make_read_only(rms_values[1]), dimensions=2,
        )  # fmt: skip

    def surface(
        self, seed: int, *, shape: tuple[int, int], spacing: float | tuple[float, float], repetition: int = 0,
        side: Side = "lower",
    ) -> Surface:  # fmt: skip
        """Generate a periodic Gaussian height map that has this spectrum, and no power outside its wavelength band.

        Parameters
        ----------
        seed, repetition : int
        side : {"lower", "upper"}
            Seed, repetition and side select the random numbers, as in `random_phases`.
        shape : (int, int)
            Rows and columns, at least 4 each.
        spacing : float or (float, float), µm
        """
        rows, columns = parse_shape(shape, min_count=4)
        spacings = parse_lengths("spacing", spacing)
        q_y, q_x = (
            2 * math.pi * np.fft.fftfreq(points, axis_spacing)
            for points, axis_spacing in zip((rows, columns), spacings, strict=True)
        )
        q = np.hypot(q_y[:, np.newaxis], q_x)
        is_in_band = (q >= self.wave_number[0] / self._bin_edge_ratio) & (
            q <= self.wave_number[-1] * self._bin_edge_ratio
        )
        with np.errstate(divide="ignore"):
            density = np.exp(np.interp(np.log(q), np.log(self.wave_number), np.log(self.density)))
        power = np.where(is_in_band, density, 0.0) * (rows * columns / (spacings[0] * spacings[1]))
        history_entry = f"a random surface of this spectrum, seed {seed}, repetition {repetition}"
        return Surface(
            gaussian_heights(power, seed, repetition, side), spacing=spacings, history=(*self.history, history_entry)
        )


def joined_spectrum(
    scans: Sequence[Profile | Surface],
    *,
    shortest_wavelengths: Sequence[float | None] | None = None,
    tip_radii: Sequence[float | None] | None = None,
    names: Sequence[str] | None = None,
    per_decade: int = 10,
) -> JoinedSpectrum:
    """Join the spectra of several scans of one surface; the scans may come from different instruments.

    Parameters
    ----------
    scans : sequence of Profile or Surface
        Scans of one surface, which must be homogeneous and isotropic. The spectrum of a profile is converted to that of
        the surface by `isotropic_spectrum`. Least-squares lines or planes are subtracted.
    shortest_wavelengths : sequence of float or None, µm, optional
        Shortest wavelength to use from every scan. None stands for the limit from `instrument_limit`, but at least
        eight points.
    tip_radii : sequence of float or None, µm, optional
        Tip radius of every scan.
    names : sequence of str, optional
        Name of every scan; by default "scan 1", "scan 2", ...
    per_decade : int
        Number of wave number bins per decade.

    Returns
    -------
    joined : JoinedSpectrum
        Spectrum C2D (µm⁴) over the wave number (1/µm), with the band and the contribution of every scan.

    Raises
    ------
    ValueError
        If there is no scan, if a scan is flat or has no reliable band, or if an option has the wrong length.

    See Also
    --------
    surface_spectrum : Spectrum of a single map.
    write_spectrum : Storage in a file.

    Notes
    -----
    The band of a scan extends from its limit by pixels, noise or tip (see `instrument_limit`) to a third of its
    shortest side. A constant factor between scans (`disagreement`) indicates a wrong height calibration. A ratio that
    decreases towards short wavelengths indicates an optical limit, a filter or a worn tip; in that case specify the
    shortest wavelength of the scan.

    Jacobs, Junge & Pastewka, Surface Topography: Metrology and Properties 5 (2017) 013001.

    Examples
    --------
    >>> from stiction import Surface, joined_spectrum, self_affine_surface
    >>> fine = self_affine_surface(1, hurst_exponent=0.8, rms=0.1, shape=(256, 256), spacing=0.01)
    >>> scans = [Surface(fine.heights[::4, ::4], spacing=0.04), Surface(fine.heights[:96, :96], spacing=0.01)]
    >>> joined = joined_spectrum(scans)
    >>> [f"{shortest:.2f} to {longest:.2f}" for shortest, longest in joined.bands]
    ['0.32 to 0.85', '0.08 to 0.32']
    """
    if not isinstance(scans, Sequence) or isinstance(scans, str):
        raise ValueError(f"scans must be a sequence of profiles or surfaces, got {type(scans).__name__}")
    bodies = [as_body("scans", scan) for scan in scans]
    if not bodies:
        raise ValueError("scans must contain at least one profile or surface, got none")
    per_decade = validate_whole_number("per_decade", per_decade, minimum=4)
    if names is not None and len(names) != len(bodies):
        raise ValueError(f"names must have one entry for each of the {len(bodies)} scans, got {len(names)}")
    given_shortest_wavelengths = _parse_values_of_scans("shortest_wavelengths", shortest_wavelengths, len(bodies))
    radii = _parse_values_of_scans("tip_radii", tip_radii, len(bodies))
    binned_scans, bands, reasons = [], [], []
    for body, shortest_limit, tip_radius in zip(bodies, given_shortest_wavelengths, radii, strict=True):
        band, reason = _find_reliable_band(body, shortest_limit, tip_radius)
        binned_scans.append(_average_in_bins(body, band, per_decade))
        bands.append(band)
        reasons.append(reason)
    first_bin = min(min(binned_scan) for binned_scan in binned_scans)
    bin_count = max(max(binned_scan) for binned_scan in binned_scans) - first_bin + 1
    count, weighted_density = np.zeros((len(binned_scans), bin_count)), np.zeros((len(binned_scans), bin_count))
    for scan_index, binned_scan in enumerate(binned_scans):
        for index, (wave_vector_count, mean_density) in binned_scan.items():
            count[scan_index, index - first_bin], weighted_density[scan_index, index - first_bin] = (
                wave_vector_count,
                wave_vector_count * mean_density,
            )
    total_count = count.sum(axis=0)
    q = 10 ** ((first_bin + np.arange(bin_count) + 0.5) / per_decade)
    is_occupied = total_count > 0
    density = np.exp(
        np.interp(
            np.log(q),
            np.log(q[is_occupied]),
            np.log(weighted_density.sum(axis=0)[is_occupied] / total_count[is_occupied]),
        )
    )
    with np.errstate(divide="ignore", invalid="ignore"):
        return JoinedSpectrum(
            wave_number=make_read_only(q), density=make_read_only(density), count=make_read_only(total_count),
            contribution=make_read_only(np.where(is_occupied, count / total_count, 0.0)),
            ratio=make_read_only(weighted_density / count / density),
            bands=tuple(bands), reasons=tuple(reasons),
            names=tuple(names or (f"scan {scan_number}" for scan_number in range(1, len(bodies) + 1))),
        )  # fmt: skip


def _parse_values_of_scans(name: str, values: Sequence[float | None] | None, scan_count: int) -> list[float | None]:
    if values is None:
        return [None] * scan_count
    if len(values) != scan_count:
        raise ValueError(f"{name} must have one entry for each of the {scan_count} scans, got {len(values)}")
    return [None if value is None else validate_number(name, value, unit="µm", above=0) for value in values]


def _find_reliable_band(
    body: Profile | Surface, given_limit: float | None, tip_radius: float | None
) -> tuple[tuple[float, float], str]:
    """Return the reliable wavelength band (µm) of a scan, and the reason why shorter wavelengths are not reliable."""
    spacing, side_length = max(body.spacings), float(np.min(body.extent))
    if given_limit is not None:
        shortest_wavelength, reason = given_limit, "given"
    else:
        noise_limit = instrument_limit(body, tip_radius=tip_radius)
        pixel_limit = MIN_POINTS_PER_WAVELENGTH * spacing
        shortest_wavelength, reason = (
            (noise_limit.wavelength, noise_limit.reason)
            if noise_limit.wavelength > pixel_limit
            else (pixel_limit, "pixels")
        )
    longest_wavelength = MAX_WAVELENGTH_TO_SIDE * side_length
    if not shortest_wavelength < longest_wavelength:
        raise ValueError(
            f"scans must have a band of reliable wavelengths, but a scan with a side of {side_length:g} µm has none: "
            f"reliable wavelengths are above {shortest_wavelength:g} µm ({reason}) and below "
            f"{longest_wavelength:g} µm (a third of the side)"
        )
    return (shortest_wavelength, longest_wavelength), reason


def _average_in_bins(
    body: Profile | Surface, band: tuple[float, float], per_decade: int
) -> dict[int, tuple[float, float]]:
    """Average a scan's spectral density in wave-number bins; return each bin's wave-vector count and mean density."""
    min_wave_number, max_wave_number = (2 * math.pi / wavelength for wavelength in reversed(band))
    if isinstance(body, Profile):
        ring_spectrum = isotropic_spectrum(levelled(body, "line"))
        q, density, wave_vector_counts = (
            ring_spectrum.wave_number,
            ring_spectrum.density,
            np.maximum(ring_spectrum.count, 1.0),
        )
    else:
        q, _, density = surface_spectrum(levelled(body, "plane")).waves()
        wave_vector_counts = np.ones(q.size)
    is_in_band = (q >= min_wave_number) & (q <= max_wave_number)
    q, density, wave_vector_counts = q[is_in_band], density[is_in_band], wave_vector_counts[is_in_band]
    bin_indices = np.floor(per_decade * np.log10(q)).astype(np.intp)
    means_by_bin = {}
    for bin_index in np.unique(bin_indices).tolist():
        is_in_bin = bin_indices == bin_index
        bin_centre = 10 ** ((bin_index + 0.5) / per_decade)
        # Within a bin, q³ C(q) is nearly constant, unlike the density C(q): therefore q³ C(q) is averaged.
        mean_density = float(
            np.average(density[is_in_bin] * (q[is_in_bin] / bin_centre) ** 3, weights=wave_vector_counts[is_in_bin])
        )
        if mean_density > 0:
            means_by_bin[int(bin_index)] = float(wave_vector_counts[is_in_bin].sum()), mean_density
    if not means_by_bin:
        raise ValueError(
            f"scans must have power in the reliable band, got a scan without power at wavelengths above {band[0]:g} µm"
        )
    return means_by_bin
