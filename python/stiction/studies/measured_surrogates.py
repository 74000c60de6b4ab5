"""The table `[surfaces]` of random surfaces that have the spectra of two measured files."""

from __future__ import annotations

from typing import ClassVar, Literal

from pydantic import Field

from stiction.studies.measured_areas import Areas, pairs_of_maps
from stiction.studies.measured_files import Body, MeasuredBodies
from stiction.surfaces.joined import JoinedSpectrum
from stiction.surfaces.pairing import IsotropicPairs
from stiction.surfaces.preparation import ProfileTrend, levelled, turned_over
from stiction.surfaces.profile import Profile
from stiction.surfaces.spectral_pairs import SpectrumPairs, spectrum_of
from stiction.surfaces.surface import Surface


class MeasuredSurrogates(MeasuredBodies):
    """Other areas of the spectra of two maps, of two profiles, or where one file is a spectrum that several scans have.

    But for two maps, they are alike in all directions.
    """

    case: ClassVar[str] = "surrogates of measured files"
    pressed: ClassVar[str] = "Surfaces with the spectra of both"

    press: Literal["surrogates"] = Field(default="surrogates", description="Other areas of the same spectra.")
    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="What is taken off each file; a plane of a profile is a line."
    )

    def members(self, scans: tuple[Body, Body], wavelength: float, seed: int) -> Areas:
        """Pairs of random surfaces with given spectra."""
        one, other = scans
        if isinstance(one, JoinedSpectrum) or isinstance(other, JoinedSpectrum):
            finest = float(self.cells()["cut_off"][0])
            return Areas(
                SpectrumPairs(spectrum_of(one), spectrum_of(other), self.level, seed, wavelength, finest), scans
            )
        upper, lower = self.filtered(scans, wavelength)
        if isinstance(upper, Surface) and isinstance(lower, Surface):
            return Areas(pairs_of_maps(upper, lower, self.level, seed), scans)
        if not (isinstance(upper, Profile) and isinstance(lower, Profile)):
            raise ValueError('surfaces.press: "surrogates" are of two maps or of two profiles, not of one of each')
        if self.prepared:
            return Areas(IsotropicPairs(upper, lower, self.level, seed), scans)
        trend: ProfileTrend = "line" if self.level == "plane" else self.level
        return Areas(IsotropicPairs(turned_over(levelled(upper, trend)), levelled(lower, trend), "plane", seed), scans)
