"""The table `[surfaces]` of a study: generated profiles and areas, and members made of two measured files."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, get_args

import numpy as np
from pydantic import Field

from stiction._units import shortened
from stiction.mechanics.model import THICKNESS
from stiction.studies.generated_surfaces import Generated, Profiles, SelfAffineSurfaces, WeierstrassMandelbrotSurfaces
from stiction.studies.measured_files import Body, Facts, MeasuredBodies, Member
from stiction.studies.values import LengthOrZero, chosen, fault_at
from stiction.surfaces.joined import JoinedSpectrum
from stiction.surfaces.pairing import (
    IsotropicPairs,
    LinePairs,
    MapPairs,
    SpectrumPairs,
    Surrogates,
    lower_piece,
    spectrum_of,
    spread,
)
from stiction.surfaces.preparation import ProfileTrend, SurfaceTrend, levelled, rotated, turned_over
from stiction.surfaces.profile import Along, Profile, part
from stiction.surfaces.surface import Surface

MOST_OFFSETS = 100_000  # largest number of positions on a pair of lines


class MeasuredLines(MeasuredBodies):
    """Lines of two measured files, the upper carried along the lower."""

    case: ClassVar[str] = "lines of measured files"
    pressed: ClassVar[str] = "Lines"
    is_areal: ClassVar[bool] = False

    press: Literal["lines"] = Field(default="lines", description="Lines of both, the upper carried along the lower.")
    level: Literal["line", "quadratic", "mean", "none"] = Field(
        default="line", description="What is taken off each line."
    )
    along: Along = Field(default="x", description="Whether lines of maps are rows or columns.")
    offsets: int = Field(
        default=1, ge=1, le=MOST_OFFSETS,
        description="Positions on each pair of lines; of two profiles without surrogates every member is a position.",
    )  # fmt: skip
    travel: LengthOrZero | None = Field(
        default=None,
        description="The largest offset; by default half of the length of one pair, and none of several pairs.",
    )
    replace: Surrogates = Field(
        default="none", description="Which of the two is replaced by its surrogate, a new one for each line."
    )

    positions: tuple[int, ...] | None = Field(
        default=None, description="Points of the lower of two prepared profiles before the slider, one position each."
    )

    def members(self, scans: tuple[Body, Body], wavelength: float, seed: int) -> Lines | LinesAt:
        """Lines of both scans, or of what replaces them, at positions on each other."""
        if self.positions is not None:
            uppers, lowers = (scan if isinstance(scan, tuple) else (scan,) for scan in scans)
            return LinesAt(uppers, lowers, self.positions)
        upper, lower = self.filtered(scans, wavelength)
        level: ProfileTrend | None = None if self.level == "none" else self.level
        travel = None if self.travel is None else float(self.travel)
        several = self.replace != "none" or isinstance(upper, Surface) or isinstance(lower, Surface)
        pairs = LinePairs(upper, lower, travel, level, self.along, self.replace, seed, several=several)
        return Lines(pairs, scans, self.offsets)


@dataclass(frozen=True, eq=False)
class Lines:
    """Members that are pairs of lines."""

    pairs: LinePairs
    scans: tuple[Body, Body]
    offsets: int = 1  # positions on each pair, where there are several pairs; of one pair every member is a position

    def member(self, index: int) -> Member:
        """A slider at a position on what it is carried over."""
        pairs, offsets = self.pairs, self.offsets
        line, place = divmod(index, offsets) if pairs.several else (0, index)
        most = pairs.most()
        if most is not None and line >= most:
            raise ValueError(f"the surfaces have {most} pairs of lines, and member {index} is on pair {line + 1}")
        slider, track = pairs.pair(line)
        room = len(track) - len(slider)
        if room == 0 and place > 0:
            raise ValueError("several positions need a travel, for which the slider is shortened")
        # A line on itself is no pair at 0; several lines are not on themselves.
        alone = pairs.several and offsets == 1 and pairs.travel is None
        if alone or room == 0:
            steps = 0
        elif offsets == 1 and pairs.travel is not None and place == 0:
            steps = room  # one position: the travel that was asked for
        else:
            steps = 1 + min(int(spread(place + 1, 1)[0] * room), room - 1)
        offset = steps * slider.spacing
        pair = slider, lower_piece(track, offset, slider)
        return Member(pair, offset, pairs.place(line), line=line, surrogate=pairs.surrogates != "none")

    def facts(self) -> Facts:
        """What all members share."""
        slider, track = self.pairs.pair(0)
        return _facts_of_lines(slider, track, len(slider) / len(track), self.scans)


@dataclass(frozen=True, eq=False)
class LinesAt:
    """Members that are profiles as they are: each upper one at given positions (points) on the lower of its place."""

    uppers: tuple[Any, ...]
    lowers: tuple[Any, ...]
    positions: tuple[int, ...]

    def member(self, index: int) -> Member:
        """A slider at one of the positions, those of a pair one after the other."""
        line, place = divmod(index, len(self.positions))
        slider, offset = self.uppers[line], self.positions[place] * self.uppers[line].spacing
        return Member((slider, lower_piece(self.lowers[line], offset, slider)), offset, 0.0, line=line)

    def facts(self) -> Facts:
        """What all members share, those of the first pair."""
        slider, track = self.uppers[0], self.lowers[0]
        return _facts_of_lines(slider, track, 1.0, (slider, track))


def _facts_of_lines(slider: Profile, track: Profile, used: float, scans: tuple[Any, Any]) -> Facts:
    """What all members of lines share, and which fraction of the upper scan a slider is."""
    return Facts(
        slider, track, slider.extent * THICKNESS, [len(slider)], [slider.spacing], [used, len(slider) / len(track)],
        [np.atleast_1d(scan.spacing) for scan in scans], [np.atleast_1d(scan.extent) for scan in scans],
    )  # fmt: skip


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
            # A flat face, and a rough one from which it is as far as two faces are from each other.
            gap = levelled(lower, self.level)
            grid: dict[str, Any] = {"spacing": gap.spacing, "missing": gap.missing}
            flat = Surface(np.zeros_like(gap.heights), history=("a flat face",), **grid)
            rough = Surface(0.0 - gap.heights, history=(*gap.history, "a gap, below a flat face"), **grid)
            return AreasAt(flat, rough, ((0, 0),))
        if self.positions is not None:
            return AreasAt(upper, lower, self.positions)
        pairs = (
            MapPairs(upper, lower, self.level, seed)
            if self.prepared
            else pairs_of_maps(upper, lower, self.level, seed, turned=self.rotate)
        )
        return Areas(pairs, scans, self.surrogates)


class MeasuredSurrogates(MeasuredBodies):
    """Other areas of the spectra of two maps, or alike in all directions of two profiles or of several scans."""

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


Measured = MeasuredAreas | MeasuredLines | MeasuredSurrogates
"""What a study of two measured files presses; a new kind of members is one more of these."""

Surfaces = Generated | Measured  # the table `[surfaces]` of a study
SURFACES: tuple[type[Surfaces], ...] = get_args(Surfaces)  # every case of the table


def _by(key: str, *cases: type[Surfaces]) -> tuple[str, dict[str, type[Surfaces]]]:
    return key, {case.model_fields[key].default: case for case in cases}


_CASES = {
    "profile": _by("kind", Profiles),
    "surface": _by("generator", WeierstrassMandelbrotSurfaces, SelfAffineSurfaces),
    "measured": _by("press", *get_args(Measured)),
}
"""By its key `kind` another key that says which case a table is of, and the cases, the first of them by default."""


def surfaces_case(given: Mapping[str, Any]) -> type[Surfaces]:
    """The case of a table, by its keys `kind`, `generator` and `press`."""
    key, cases = _CASES[chosen("kind", given, _CASES)]
    return cases[chosen(key, given, cases)]


def pressed(surfaces: type[Surfaces]) -> str:
    """What is pressed: generated or measured, lines or areas."""
    kind = "measured" if issubclass(surfaces, Measured) else "generated"
    return f"{kind} {'areas' if surfaces.is_areal else 'lines'}"


def read_surfaces(value: object) -> Surfaces:
    """A table of the case that it says."""
    if isinstance(value, SURFACES):
        return value
    if not isinstance(value, Mapping):
        raise ValueError(f"must be a table, got {shortened(value)}")
    case = surfaces_case(value)
    for key in value:
        owners = [each.case for each in SURFACES if key in each.model_fields]
        if owners and key not in case.model_fields:
            raise fault_at(str(key), f"belongs to {' and '.join(owners)}, not to {case.case}")
    return case.model_validate(value)
