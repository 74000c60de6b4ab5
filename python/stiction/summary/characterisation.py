"""Characterisation of one scan: roughness parameters, spectrum, Hurst exponent, instrument limits and caveats."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from stiction.mechanics.closed_forms import gentle_friction
from stiction.solve.contact_statistics import compute_slopes
from stiction.summary.assessment import Caveat
from stiction.summary.input_caveats import find_scan_caveats
from stiction.surfaces.filters import filtered, validate_cutoff
from stiction.surfaces.hurst import HurstEstimate, estimate_hurst_exponent
from stiction.surfaces.lines import MAX_POWER_LAW_MISFIT, LineRoughness, lines_along_both, power_law_misfit
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import (
    RoughnessParameters,
    SurfaceParameters,
    rms_gradient,
    roughness_parameters,
    surface_parameters,
)
from stiction.surfaces.scale import InstrumentLimit, ScaleDependentRoughness, scale_dependent_roughness
from stiction.surfaces.scan_defects import ScanDefects, find_scan_defects
from stiction.surfaces.sections import SectionLengthError, SectionParameters, section_parameters
from stiction.surfaces.spectrum import PowerSpectrum, ProfileMoments, RadialSpectrum, power_spectrum, surface_spectrum
from stiction.surfaces.surface import Surface

ASSUMED_MU0 = 0.4
RADIAL_BINS_PER_DECADE = 20
# With a Hann window, ln(density) in a bin of n harmonics has the variance `_HANN_LOG_DENSITY_VARIANCE` / n.
_HANN_LOG_DENSITY_VARIANCE = 2.0


@dataclass(frozen=True, eq=False)
class Characterisation:
    """Characterisation of a levelled profile or surface; each property is computed on first use.

    Attributes
    ----------
    body : Profile or Surface
        Body to characterise. It must not be flat, and must have at least 7 points along each axis.
    band : (float, float), µm, optional
        Shortest and longest wavelength for the fit of Hurst exponents. By default the band is chosen automatically.
    tip_radius : float, µm, optional
        Radius of the stylus or probe tip.
    periodic : bool
        As in `power_spectrum`.
    lc, ls : float, µm, optional
        Cutoff wavelengths for the R- and W-parameters of a profile, as in `section_parameters`, or for the S-parameters
        of a surface. A surface without cutoffs is not filtered.
    robust : bool
        True if the L-filter is the robust regression filter.

    Raises
    ------
    ValueError
        When a property is accessed: if the body is flat or too small, if the band contains too few wavelengths, or if a
        cutoff is not suitable for the profile.
    """

    body: Profile | Surface
    band: tuple[float, float] | None = None
    tip_radius: float | None = None
    periodic: bool = False
    textured: bool = False
    """True if the body was machined, so that lines and humps of its spectrum count as part of the surface."""
    lc: float | None = None
    ls: float | None = None
    robust: bool = False

    @cached_property
    def parameters(self) -> RoughnessParameters | SurfaceParameters:
        """Amplitude and slope parameters of the profile or surface, such as Rq or Sq."""
        body = self.scale_limited_body
        return roughness_parameters(body) if isinstance(body, Profile) else surface_parameters(body)

    @cached_property
    def scale_limited_body(self) -> Profile | Surface:
        """Body from which roughness parameters are computed: the unfiltered profile, or the filtered surface."""
        body = self.body
        if isinstance(body, Profile):
            return body
        if self.lc is None and self.robust:
            raise ValueError("lc must be given for the robust filter of a surface")
        if self.lc is not None and self.ls and self.ls >= self.lc:
            raise ValueError(f"ls must be below lc ({self.lc:g} µm), got {self.ls:g} µm")
        if self.ls:
            body = filtered(body, cutoff=validate_cutoff("ls", self.ls, body, longest=1), kind="S")
        if self.lc is not None:
            body = filtered(body, cutoff=validate_cutoff("lc", self.lc, body, longest=1), kind="L", robust=self.robust)
        return body

    @cached_property
    def rms_slope_between_neighbours(self) -> float:
        """Rms slope of a profile, or rms gradient of a surface, from height differences between neighbouring points."""
        body = self.scale_limited_body
        if isinstance(body, Profile):
            return roughness_parameters(body, derivative="neighbours").Pdq
        return rms_gradient(body, "neighbours")

    @cached_property
    def section_parameters(self) -> SectionParameters | SectionLengthError | None:
        """R- and W-parameters of a profile, or the error that prevents the computation; None for a surface."""
        if not isinstance(self.body, Profile):
            return None
        try:
            return section_parameters(self.body, lc=self.lc, ls=self.ls, robust=self.robust)
        except SectionLengthError as error:
            if self.lc is not None:
                raise
            return error

    @property
    def defects(self) -> ScanDefects:
        """Defects of the scan: spikes, and wavelengths that the instrument or its tip does not resolve."""
        return find_scan_defects(self.body, self.tip_radius, textured=self.textured, periodic=self.periodic)

    @property
    def body_without_outliers(self) -> Profile | Surface:
        """Body whose outliers are replaced by interpolated heights; the spectrum is computed from this body."""
        return self.defects.body_without_outliers

    @property
    def excluded_outliers(self) -> NDArray[np.bool_]:
        """Mask of the outliers, that is, of the points that have interpolated heights in `body_without_outliers`."""
        outliers = self.defects.outliers
        return outliers if self.body_without_outliers is not self.body else np.zeros_like(outliers)

    @cached_property
    def spectrum(self) -> PowerSpectrum | None:
        """Power spectrum of a profile, or None for a surface."""
        body = self.body_without_outliers
        return power_spectrum(body, periodic=self.periodic) if isinstance(body, Profile) else None

    @cached_property
    def areal_analysis(self) -> tuple[RadialSpectrum, tuple[ProfileMoments, ...], float]:
        """Radial spectrum of a surface, moments of its profiles along x and y, and its steepest direction (degrees)."""
        assert isinstance(self.body_without_outliers, Surface)
        spectrum = surface_spectrum(self.body_without_outliers)
        moments = tuple(spectrum.moments(direction) for direction in (0, 90))
        return spectrum.radial(RADIAL_BINS_PER_DECADE), moments, spectrum.steepest_direction()

    @cached_property
    def binned_spectrum(self) -> PowerSpectrum | RadialSpectrum:
        """Power spectrum of the body, averaged in bins of ln(wave number)."""
        return self.areal_analysis[0] if self.spectrum is None else self.spectrum.in_bins()

    @cached_property
    def line_roughnesses(self) -> tuple[LineRoughness, ...]:
        """Roughness of a surface along its rows (x) and along its columns (y); empty for a profile."""
        body = self.body_without_outliers
        return () if isinstance(body, Profile) else lines_along_both(body, band=self.band)

    @cached_property
    def power_law_fit(self) -> HurstEstimate | None:
        """Power law fitted to the spectrum regardless of the misfit, or None if no band of wavelengths is suitable."""
        try:
            return estimate_hurst_exponent(self.body_without_outliers, band=self.band, periodic=self.periodic)
        except ValueError:
            if self.band is not None:
                raise
            return None

    @cached_property
    def power_law_misfit(self) -> float:
        """Rms factor by which the spectrum deviates from the fitted power law, or NaN if no power law was fitted."""
        if self.power_law_fit is None:
            return math.nan
        band = self.power_law_fit.shortest_wavelength, self.power_law_fit.longest_wavelength
        dimensions, log_variance = self.power_law_fit.dimensions, _HANN_LOG_DENSITY_VARIANCE
        return power_law_misfit(
            self.binned_spectrum, band, self.power_law_fit.value, dimensions=dimensions, chance=log_variance
        )

    @property
    def valid_power_law(self) -> HurstEstimate | None:
        """Power law fitted to the spectrum, or None if the spectrum deviates too much from any power law."""
        return None if self.power_law_misfit > MAX_POWER_LAW_MISFIT else self.power_law_fit

    @cached_property
    def roughness(self) -> ScaleDependentRoughness:
        """Rms slope and rms curvature of the body as functions of the shortest included wavelength."""
        return scale_dependent_roughness(self.body_without_outliers, periodic=self.periodic)

    @property
    def instrument_limit(self) -> InstrumentLimit:
        """Shortest reliable wavelength of the scan, limited by pixels and noise; the instrument's tip is ignored."""
        return self.defects.instrument_limit

    @property
    def tip_limit(self) -> InstrumentLimit | None:
        """Shortest reliable wavelength of the scan, limited by pixels, noise and tip; None without a tip radius."""
        return self.defects.instrument_limit_with_tip

    @cached_property
    def friction_estimates(self) -> tuple[float, ...]:
        """Small-slope estimates of the friction coefficients along x and y between two bodies with this roughness.

        The tuple is empty if the slopes along an axis are 0.
        """
        # The gap between two equally rough bodies has twice the mean square slope of one body; [::-1] puts x before y.
        mean_square_slopes = [2 * float(np.square(slopes).mean()) for slopes in compute_slopes(self.body)][::-1]
        return tuple(
            float(
                gentle_friction(
                    ASSUMED_MU0, rms_gradient=math.sqrt(sum(mean_square_slopes)), rms_slope=math.sqrt(mean_square_slope)
                )
            )
            for mean_square_slope in mean_square_slopes
            if min(mean_square_slopes) > 0
        )

    @cached_property
    def caveats(self) -> list[Caveat]:
        """Caveats about the scan: height distribution, form error, spikes, and wavelengths that may be noise."""
        return find_scan_caveats(self.body, tip_radius=self.tip_radius, textured=self.textured, periodic=self.periodic)
