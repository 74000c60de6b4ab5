"""Surface spectrum combined from several scans. Each scan contributes its reliable band of wavelengths."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from stiction._checks import Floats, read_only, validate_number, validate_whole_number
from stiction._repr import TextRepr
from stiction.surfaces.preparation import levelled
from stiction.surfaces.profile import Profile, Side
from stiction.surfaces.scale import ScaleDependentRoughness, instrument_limit
from stiction.surfaces.spectrum import surface_spectrum
from stiction.surfaces.surface import Surface, as_body, parse_lengths, parse_shape
from stiction.surfaces.surrogates import gaussian_heights, isotropic_spectrum

MIN_POINTS_PER_WAVELENGTH = (
    # Shortest wavelength that is used from a scan, in points.
    # Averaging over a pixel transmits 95 % of the power of this wavelength.
    8
)
MAX_WAVELENGTH_FRACTION = (
    1 / 3
    # Longest wavelength that is used from a scan, as a fraction of the shortest side of the scan.
    # At longer wavelengths, the measured spectrum depends on the window.
)
# Number of wave vectors per independent value. Opposite wave vectors are equal, and the window correlates neighbours.
_WAVE_VECTORS_PER_INDEPENDENT_VALUE = 4.0


@dataclass(frozen=True, eq=False, repr=False)
class JoinedSpectrum(TextRepr):
    """Spectrum of an isotropic surface over all wavelengths that its scans resolve.

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
        return float(2 * math.pi / (self.wave_number[-1] * self._edge_ratio))

    @property
    def longest(self) -> float:
        """Longest wavelength of the spectrum, µm."""
        return float(2 * math.pi / (self.wave_number[0] / self._edge_ratio))

    @property
    def _edge_ratio(self) -> float:
        """Ratio of the wave number at the upper edge of a bin to the wave number at the centre."""
        return math.sqrt(self.wave_number[1] / self.wave_number[0])

    @property
    def history(self) -> tuple[str, ...]:
        """Description of the scans and their wavelength bands."""
        scans = (
            f"{name} ({shortest:.4g} to {longest:.4g} µm)"
            for name, (shortest, longest) in zip(self.names, self.bands, strict=True)
        )
        names_text = f", of {', '.join(scans)}" if self.names else ""
        return (f"spectrum of waves from {self.shortest:.4g} to {self.longest:.4g} µm{names_text}",)

    @property
    def disagreement(self) -> Floats:
        """Mean ratio of the density of each scan to that of all other scans at shared wavelengths, shape (scans,).

        The ratio is NaN for a scan without overlap.
        """
        shared = (self.contribution > 0).sum(axis=0) > 1
        ratios = np.full(len(self.bands), np.nan)
        for scan, ratio in enumerate(self.ratio):
            occupied = shared & np.isfinite(ratio)
            weight = self.contribution[scan, occupied]
            if occupied.any() and (weight < 1).any():
                # The combined density includes the density of the scan itself, which is removed before the comparison.
                others = (1 - weight * ratio[occupied]) / (1 - weight)
                with np.errstate(divide="ignore", invalid="ignore"):
                    logs = np.log(ratio[occupied] / others)
                ratios[scan] = (
                    math.exp(float(np.average(logs, weights=self.count[occupied]))) if (others > 0).all() else np.inf
                )
        return read_only(ratios)

    @property
    def chance(self) -> Floats:
        """Standard deviation of ln(`disagreement`) that chance alone would cause, with shape (scans,)."""
        shared = (self.contribution > 0).sum(axis=0) > 1
        actual = self.contribution * self.count / _WAVE_VECTORS_PER_INDEPENDENT_VALUE
        result = np.full(len(self.bands), np.nan)
        for scan, waves in enumerate(actual):
            occupied = shared & (waves > 0)
            if occupied.any():
                others = actual[:, occupied].sum(axis=0) - waves[occupied]
                weight = self.count[occupied] / self.count[occupied].sum()
                result[scan] = math.sqrt(float(np.square(weight) @ (1 / waves[occupied] + 1 / others)))
        return read_only(result)

    def roughness(self) -> ScaleDependentRoughness:
        """Return the rms slope and curvature as functions of the shortest included wavelength."""
        step = math.log(self.wave_number[1] / self.wave_number[0])
        result = []
        for power, factor in ((2, 1.0), (4, 0.25)):
            part = factor * self.wave_number ** (power + 2) * self.density * step / (2 * math.pi)
            # The integral up to the centre of a bin includes only half of this bin.
            result.append(np.sqrt(part.cumsum() - part / 2))
        return ScaleDependentRoughness(
            wavelength=read_only(2 * math.pi / self.wave_number), gradient=read_only(result[0]),
            curvature=read_only(result[1]), dimensions=2,
        )  # fmt: skip

    def surface(
        self, seed: int, *, shape: tuple[int, int], spacing: float | tuple[float, float], repetition: int = 0,
        side: Side = "lower",
    ) -> Surface:  # fmt: skip
        """Generate a periodic Gaussian surface with this spectrum. Wavelengths outside the spectrum are absent.

        Parameters
        ----------
        seed, repetition : int
        side : {"lower", "upper"}
            Seed, repetition and side select the random numbers, as in `random_phases`.
        shape : (int, int)
            Rows and columns, at least 4 each.
        spacing : float or (float, float), µm
        """
        rows, columns = parse_shape(shape, least=4)
        steps = parse_lengths("spacing", spacing)
        q_y, q_x = (2 * math.pi * np.fft.fftfreq(size, step) for size, step in zip((rows, columns), steps, strict=True))
        q = np.hypot(q_y[:, np.newaxis], q_x)
        inside = (q >= self.wave_number[0] / self._edge_ratio) & (q <= self.wave_number[-1] * self._edge_ratio)
        with np.errstate(divide="ignore"):
            density = np.exp(np.interp(np.log(q), np.log(self.wave_number), np.log(self.density)))
        power = np.where(inside, density, 0.0) * (rows * columns / (steps[0] * steps[1]))
        step = f"a random surface of this spectrum, seed {seed}, repetition {repetition}"
        return Surface(gaussian_heights(power, seed, repetition, side), spacing=steps, history=(*self.history, step))


def joined_spectrum(
    scans: Sequence[Profile | Surface],
    *,
    shortest_wavelengths: Sequence[float | None] | None = None,
    tip_radii: Sequence[float | None] | None = None,
    names: Sequence[str] | None = None,
    per_decade: int = 10,
) -> JoinedSpectrum:
    """Combine the spectra of several scans of a surface, from one instrument or several.

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
    limits = _parse_values_of_scans("shortest_wavelengths", shortest_wavelengths, len(bodies))
    tips = _parse_values_of_scans("tip_radii", tip_radii, len(bodies))
    parts, bands, reasons = [], [], []
    for body, limit, tip in zip(bodies, limits, tips, strict=True):
        band, reason = _reliable_band(body, limit, tip)
        parts.append(_average_in_bins(body, band, per_decade))
        bands.append(band)
        reasons.append(reason)
    first = min(min(part) for part in parts)
    size = max(max(part) for part in parts) - first + 1
    count, total = np.zeros((len(parts), size)), np.zeros((len(parts), size))
    for scan, part in enumerate(parts):
        for index, (waves, level) in part.items():
            count[scan, index - first], total[scan, index - first] = waves, waves * level
    all_waves = count.sum(axis=0)
    q = 10 ** ((first + np.arange(size) + 0.5) / per_decade)
    occupied = all_waves > 0
    density = np.exp(
        np.interp(np.log(q), np.log(q[occupied]), np.log(total.sum(axis=0)[occupied] / all_waves[occupied]))
    )  # interpolate linearly in logarithms across gaps
    with np.errstate(divide="ignore", invalid="ignore"):
        return JoinedSpectrum(
            wave_number=read_only(q), density=read_only(density), count=read_only(all_waves),
            contribution=read_only(np.where(occupied, count / all_waves, 0.0)),
            ratio=read_only(total / count / density),
            bands=tuple(bands), reasons=tuple(reasons),
            names=tuple(names or (f"scan {number}" for number in range(1, len(bodies) + 1))),
        )  # fmt: skip


def _parse_values_of_scans(name: str, values: Sequence[float | None] | None, size: int) -> list[float | None]:
    if values is None:
        return [None] * size
    if len(values) != size:
        raise ValueError(f"{name} must have one entry for each of the {size} scans, got {len(values)}")
    return [None if value is None else validate_number(name, value, unit="µm", above=0) for value in values]


def _reliable_band(body: Profile | Surface, limit: float | None, tip: float | None) -> tuple[tuple[float, float], str]:
    """Return the usable wavelength band of a scan, and the reason for its lower limit."""
    spacing, side = max(body.spacings), float(np.min(body.extent))
    if limit is not None:
        shortest, reason = limit, "given"
    else:
        result = instrument_limit(body, tip_radius=tip)
        pixels = MIN_POINTS_PER_WAVELENGTH * spacing
        shortest, reason = (result.wavelength, result.reason) if result.wavelength > pixels else (pixels, "pixels")
    longest = MAX_WAVELENGTH_FRACTION * side
    if not shortest < longest:
        raise ValueError(
            f"scans must have a reliable band, but the lower limit of a scan of {side:g} µm, {shortest:g} µm "
            f"({reason}), is above its upper limit, {longest:g} µm, a third of its side"
        )
    return (shortest, longest), reason


def _average_in_bins(
    body: Profile | Surface, band: tuple[float, float], per_decade: int
) -> dict[int, tuple[float, float]]:
    """Return the number of wave vectors and the mean density for every bin of a band."""
    shortest, longest = (2 * math.pi / length for length in reversed(band))
    if isinstance(body, Profile):
        ring = isotropic_spectrum(levelled(body, "line"))
        q, density, waves = ring.wave_number, ring.density, np.maximum(ring.count, 1.0)
    else:
        q, _, density = surface_spectrum(levelled(body, "plane")).waves()
        waves = np.ones(q.size)
    inside = (q >= shortest) & (q <= longest)
    q, density, waves = q[inside], density[inside], waves[inside]
    index = np.floor(per_decade * np.log10(q)).astype(np.intp)
    result = {}
    for bin_ in np.unique(index).tolist():
        selected = index == bin_
        middle = 10 ** ((bin_ + 0.5) / per_decade)
        # The spectrum C decreases within a bin, but q³ C is nearly constant.
        level = float(np.average(density[selected] * (q[selected] / middle) ** 3, weights=waves[selected]))
        if level > 0:
            result[int(bin_)] = float(waves[selected].sum()), level
    if not result:
        raise ValueError(
            f"scans must have power in the reliable band, got a scan without power at wavelengths above {band[0]:g} µm"
        )
    return result
