"""The tables `[surfaces]` of areas: of two measured maps, or with the spectra of two files; and their members."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from stiction.studies.measured_files import Body, Facts, MeasuredBodies, Member
from stiction.surfaces.joined import JoinedSpectrum
from stiction.surfaces.pairing import IsotropicPairs, MapPairs
from stiction.surfaces.preparation import ProfileTrend, SurfaceTrend, levelled, rotated, turned_over
from stiction.surfaces.profile import Profile, part
from stiction.surfaces.spectral_pairs import SpectrumPairs, spectrum_of
from stiction.surfaces.surface import Surface


class MeasuredAreas(MeasuredBodies):
    """Areas of two measured maps, pressed at several relative positions."""

    case: ClassVar[str] = "areas of measured maps"
    pressed: ClassVar[str] = "Areas"

    press: Literal["areas"] = Field(default="areas", description="Areas at several relative positions.")
    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="What is taken off each map and each piece that is pressed."
    )
    rotate: float = Field(default=0.0, ge=-360, le=360, description="Degrees by which the upper map is turned.")
    surrogates: int = Field(
        default=0, ge=0, le=1_000_000,
        description="How many members, the first ones, are pairs of surrogates: other surfaces of the same spectra.",
    )  # fmt: skip

    gap: Literal[True] | None = Field(
        default=None, description="Said of one file that is both: the gap of two faces, pressed as it is."
    )
    positions: tuple[tuple[int, int], ...] | None = Field(
        default=None, description="Rows and columns by which the upper of two prepared maps lies beyond the lower one."
    )

    @property
    def first_scanned(self) -> int:
        """Number of the first member that is a pair of pieces of the maps."""
        return self.surrogates

    def members(self, scans: tuple[Body, Body], wavelength: float, seed: int) -> Areas | AreasAt:
        """Pieces of two maps at relative positions, the first ones of their surrogates."""
        upper, lower = self.filtered(scans, wavelength)
        if not (isinstance(upper, Surface) and isinstance(lower, Surface)):
            raise ValueError('surfaces.press: "areas" are of two maps, and one of the files is a profile')
        if self.gap:
            return AreasAt(*faces_of(levelled(lower, self.level)), ((0, 0),))
        if self.positions is not None:
            return AreasAt(upper, lower, self.positions)
        pairs = (
            MapPairs(upper, lower, self.level, seed)
            if self.prepared
            else pairs_of_maps(upper, lower, self.level, seed, turned=self.rotate)
        )
        return Areas(pairs, scans, self.surrogates)


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


def faces_of(gap: Surface) -> tuple[Surface, Surface]:
    """A flat face, and a rough one from which it is as far as two faces are from each other."""
    flat, steps = np.zeros_like(gap.heights), (*gap.history, "a gap, below a flat face")
    lower = Surface(0.0 - gap.heights, spacing=gap.spacing, history=steps, missing=gap.missing)
    return Surface(flat, spacing=gap.spacing, history=("a flat face",), missing=gap.missing), lower


def pairs_of_maps(upper: Surface, lower: Surface, level: SurfaceTrend, seed: int, *, turned: float = 0.0) -> MapPairs:
    """Pieces of two maps, both levelled, the upper one turned in its plane by an angle (degrees), and over."""
    above = levelled(upper, level)
    return MapPairs(turned_over(rotated(above, turned) if turned else above), levelled(lower, level), level, seed)


@dataclass(frozen=True, eq=False)
class Areas:
    """Members that are pairs of areas."""

    pairs: MapPairs | IsotropicPairs | SpectrumPairs
    scans: tuple[Body, Body]
    surrogates: int | None = None  # how many members, the first ones, are pairs of surrogates; by default all

    def member(self, index: int) -> Member:
        """A pair of surrogates, or of pieces of maps at a relative position."""
        pairs, made = self.pairs, self.surrogates
        if made is None or index < made:
            return Member(pairs.surrogates(index), np.nan, np.nan, surrogate=True)
        assert isinstance(pairs, MapPairs)
        shift = index - made
        if shift >= pairs.most():
            raise ValueError(f"the maps have {pairs.most()} relative positions, and member {index} is beyond them")
        return Member(pairs.pair(shift), *pairs.moved(shift))

    def facts(self) -> Facts:
        """What all members share."""
        pairs = self.pairs
        scans: Any = self.scans
        if isinstance(pairs, SpectrumPairs):  # as if two points were the shortest wave
            spacings = [np.array([max(body.shortest, pairs.finest) / 2]) for body in (pairs.upper, pairs.lower)]
            extents = [np.array([pairs.side])] * 2
        else:
            spacings = [np.atleast_1d(scan.spacing) for scan in scans]
            extents = [np.atleast_1d(scan.extent) for scan in scans]
        return Facts(pairs.upper, pairs.lower, pairs.area, pairs.shape, pairs.spacing, pairs.used, spacings, extents)


@dataclass(frozen=True, eq=False)
class AreasAt:
    """Members that are what of two maps lies above each other, as they are, at given positions in rows and columns."""

    upper: Surface
    lower: Surface
    positions: tuple[tuple[int, int], ...]

    def member(self, index: int) -> Member:
        """The maps at one of the positions."""
        dy, dx = self.lower.spacing
        rows, columns = self.positions[index]
        return Member(overlap(self.upper, self.lower, (rows, columns)), columns * dx, rows * dy)

    def facts(self) -> Facts:
        """What the first member is; others may have another size."""
        piece, both = self.member(0).pair[0], (self.upper, self.lower)
        assert isinstance(piece, Surface)
        return Facts(
            *both, float(np.prod(piece.extent)), piece.heights.shape, piece.spacing,
            [piece.heights.size / body.heights.size for body in both], [np.array(body.spacing) for body in both],
            [np.array(body.extent) for body in both],
        )  # fmt: skip


def overlap(upper: Surface, lower: Surface, place: tuple[int, int]) -> tuple[Surface, Surface]:
    """What of two maps lies above each other when the upper is moved by rows and columns over the lower."""
    of_upper, of_lower = [], []
    for size_upper, size_lower, moved in zip(upper.heights.shape, lower.heights.shape, place, strict=True):
        first, last = max(0, moved), min(size_lower, moved + size_upper)
        of_lower.append(slice(first, max(first, last)))
        of_upper.append(slice(first - moved, max(first, last) - moved))
    one, other = (
        Surface(body.heights[at], spacing=body.spacing, history=body.history, missing=part(body.missing, at))
        for body, at in ((upper, tuple(of_upper)), (lower, tuple(of_lower)))
    )
    return one, other
