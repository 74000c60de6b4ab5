"""Two scans as pairs of bodies: lines that are paired, pieces of two maps, and stand-ins of the same spectrum.

Pair `index` depends on the scans, the choices and the index alone, so that any number of pairs begins with the same
ones, wherever each is made.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stiction._caching import cached_property
from stiction._checks import choice, number, whole_number
from stiction.surfaces.cut_off import cut_off
from stiction.surfaces.joined_spectrum import MAX_WAVELENGTH_FRACTION, JoinedSpectrum, joined_spectrum
from stiction.surfaces.preparation import (
    ProfileTrend,
    SurfaceTrend,
    cropped,
    flipped,
    levelled,
    resampled,
    resampled_piece,
)
from stiction.surfaces.profile import Along, Profile, Side, index_mask
from stiction.surfaces.surface import Surface, as_body
from stiction.surfaces.surrogates import isotropic_surface, surrogate

DEFAULT_LINES = 128  # pairs of lines by default: a second or two of computing, and enough for an interval
SHIFT_DIVISOR = (
    4  # maps are moved over each other by a quarter of their length at most: three quarters lie above each other
)
MIN_PIECE_POINTS = 16  # rows and columns that are pressed
MAX_SURROGATE_POINTS = 512  # rows and columns of the surfaces that are made of profiles
Surrogates = Literal["none", "upper", "lower", "both"]
SIDES: tuple[Side, Side] = ("upper", "lower")
_GOLDEN = (5**0.5 - 1) / 2
_PLASTIC = 1.324717957244746
_OF_FOUR = 1.1673039782614187  # the real root of x^5 = x + 1
GRID_POINTS_PER_WAVELENGTH = 4  # points of the shortest wave of the surfaces that are made


def quasi_random_point(index: int, dimensions: int) -> tuple[float, ...]:
    """Point `index` of a sequence that fills the unit cube evenly, by powers of the golden ratio and its kin."""
    if dimensions == 1:
        return ((index * _GOLDEN) % 1,)
    base = _PLASTIC if dimensions == 2 else _OF_FOUR
    return tuple((0.5 + index * base**-power) % 1 for power in range(1, dimensions + 1))


# ---- Lines -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LinePairs:
    """Pairs of lines of two scans, or of surrogates of lines, as `paired_lines` makes them."""

    upper: Profile | Surface
    lower: Profile | Surface
    travel: float | None = None
    level: ProfileTrend | None = "line"
    along: Along = "x"
    surrogates: Surrogates = "none"
    seed: int = 2016
    several: bool = False
    count: int | None = None  # how many there will be, in equal distances; else evenly spread however many there are

    def most(self) -> int | None:
        """How many different pairs there are; None without end."""
        if self.surrogates != "none":
            return None
        widths = [self._width(each) for each in (self.upper, self.lower) if isinstance(each, Surface)]
        return min(widths, default=1)

    def place(self, index: int) -> float:
        """Where the upper line of a pair lies across its surface, µm; 0 of profiles."""
        if not isinstance(self.upper, Surface):
            return 0.0
        across = self.upper.spacing[0 if self.along == "x" else 1]
        return self._row(self.upper, index) * across

    def pair(self, index: int) -> tuple[Profile, Profile]:
        """One pair, both on the same spacing."""
        apart = isinstance(self.upper, Surface) and isinstance(self.lower, Surface)
        lines = self._line(self.upper, index), self._line(self.lower, index, apart=apart)
        if self.level is not None:
            lines = levelled(lines[0], self.level), levelled(lines[1], self.level)
        above, below = (
            self._stand_in(line, index, side) if self.surrogates in (side, "both") else line
            for line, side in zip(lines, SIDES, strict=True)
        )
        spacing = min(above.spacing, below.spacing)
        above, below = resampled(flipped(above), spacing), resampled(below, spacing)
        if self.several and self.travel is None:
            return _of_one_length(above, below, index, self.level)
        return self._slider(above, len(below)), below

    def _slider(self, above: Profile, track: int) -> Profile:
        points, spacing = len(above), above.spacing
        if self.travel is None:
            left = max(track - points, track // 2)
        else:
            left = round(number("travel", self.travel, unit="µm") / spacing)
        slider = min(points, track - left)
        if left < 0 or 2 * slider < min(points, track) - 1:
            most = (track - min(points, track) // 2) * spacing
            raise ValueError(
                f"travel must be from 0 to {most:g} µm, or too little is left of the slider, got {self.travel!r}"
            )
        short = above if slider == points else cropped(above, 0.0, slider * spacing)
        return short if self.level is None else levelled(short, self.level)

    def _line(self, body: Profile | Surface, index: int, *, apart: bool = False) -> Profile:
        """A line of a surface, evenly spread over it, or a third of the width further on and going round."""
        if isinstance(body, Profile):
            return body
        line = body.row if self.along == "x" else body.column
        return line(self._row(body, index, apart=apart))

    def _row(self, surface: Surface, index: int, *, apart: bool = False) -> int:
        """Which of the lines of a surface; each is taken once before any is taken again."""
        width = self._width(surface)
        start = max(width // 3, 1) if apart else 0
        if self.count is not None:
            return (start + index * width // self.count) % width
        # About the golden ratio of the width, but a step that shares no factor with it.
        step = max(1, round(width * _GOLDEN))
        while math.gcd(step, width) > 1:
            step += 1
        return (start + index * step) % width

    def _width(self, surface: Surface) -> int:
        return int(surface.heights.shape[0 if self.along == "x" else 1])

    def _stand_in(self, profile: Profile, index: int, side: Side) -> Profile:
        made = surrogate(profile, self.seed, repetition=index, side=side)
        return profile.changed(made.heights, f"replaced by its surrogate of seed {self.seed}, repetition {index}")


def paired_lines(
    upper: Profile | Surface,
    lower: Profile | Surface,
    *,
    travel: float | None = None,
    level: ProfileTrend | None = "line",
    lines: int = DEFAULT_LINES,
    along: Along = "x",
    surrogates: Surrogates = "none",
    seed: int = 2016,
) -> tuple[list[Profile], list[Profile]]:
    """Two scans as what `traverse` takes: sliders, turned over, and what they are carried over, a pair for each line.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Scans, both with heights out of the material; of different grids the finer is taken for both.
    travel : float, µm, optional
        The largest offset that shall be possible: sliders are shortened to leave it. By default one pair has half of
        the lower profile, or what the upper one leaves of it. Several pairs have none: of lines of different lengths
        the longer is cut to the shorter, each at another place, so that together they are from all over it.
    level : {"line", "mean", "quadratic"} or None
        What is taken off each line, and off each slider once more when it has its length, so that it lies level.
    lines : int
        How many pairs of lines are taken from surfaces, evenly spread, or of surrogates; two profiles are one pair.
        Lines of two surfaces are a third of their width apart, so that a surface can be paired with itself.
    along : {"x", "y"}
        Whether lines of surfaces are rows or columns.
    surrogates : {"none", "upper", "lower", "both"}
        Which of the two are replaced by their `surrogate`, a new one for each line.
    seed : int
        Of the surrogates.

    Returns
    -------
    (list of Profile, list of Profile)
        All sliders on the same grid, and so are the lower profiles.

    Raises
    ------
    ValueError
        If an argument is outside its range, or travel leaves less than half of the shorter profile as a slider.

    Examples
    --------
    >>> from stiction import paired_lines, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> lines = paired_lines(upper, lower, lines=4)
    >>> [len(each) for each in lines[:2]]
    [4, 4]
    """
    choice("along", along, Along)
    choice("surrogates", surrogates, Surrogates)
    if level is not None:
        choice("level", level, ProfileTrend)
    count = whole_number("lines", lines, least=1)
    for name, body in (("upper", upper), ("lower", lower)):
        as_body(name, body)
    most = LinePairs(upper, lower, along=along, surrogates=surrogates).most()
    count = count if most is None else min(count, most)
    pairs = LinePairs(upper, lower, travel, level, along, surrogates, seed, several=count > 1, count=count)
    made = [pairs.pair(index) for index in range(count)]
    return [above for above, _ in made], [below for _, below in made]


def _of_one_length(upper: Profile, lower: Profile, index: int, level: ProfileTrend | None) -> tuple[Profile, Profile]:
    """A pair of which the longer profile is cut to the shorter, at a place of its own, and levelled again."""
    length = min(len(upper), len(lower))

    def cut(profile: Profile) -> Profile:
        if len(profile) == length:
            return profile
        first = round(quasi_random_point(index, 1)[0] * (len(profile) - length))
        piece = cropped(profile, first * profile.spacing, (first + length) * profile.spacing)
        return piece if level is None else levelled(piece, level)

    return cut(upper), cut(lower)


def piece_below_slider(lower: Profile, offset: float, slider: Profile) -> Profile:
    """What is below a slider at an offset (µm)."""
    first = round(offset / lower.spacing)
    below = slice(first, first + len(slider))
    return Profile(lower.heights[below], spacing=lower.spacing, missing=index_mask(lower.missing, below))


# ---- Areas -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class MapPairs:
    """Pairs of pieces of two maps that are moved over each other, or of their surrogates, all of one size.

    Pieces have three quarters of the shorter length along each axis, on the finer spacing, and lie all over both maps.
    Of maps of one size the upper is moved so that a map on itself never lies on itself nor on its mirror image.
    """

    upper: Surface  # heights of the upper body are up, as `flipped` makes them
    lower: Surface
    level: SurfaceTrend = "plane"  # what is taken off each piece
    seed: int = 2016  # of surrogates

    @cached_property
    def spacing(self) -> tuple[float, float]:
        """µm, of rows and columns: the finer of both maps."""
        (uy, ux), (ly, lx) = self.upper.spacing, self.lower.spacing
        return min(uy, ly), min(ux, lx)

    @cached_property
    def _points(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Points along y and x that each map has on the finer spacing."""
        return tuple(  # type: ignore[return-value]
            tuple(
                points if own == step else math.floor((points - 1) * own / step + 1e-9) + 1
                for points, own, step in zip(body.heights.shape, body.spacing, self.spacing, strict=True)
            )
            for body in (self.upper, self.lower)
        )

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of each piece; a `ValueError` if these are too few to be pressed."""
        rows, columns = (
            (least := min(lengths)) - least // SHIFT_DIVISOR for lengths in zip(*self._points, strict=True)
        )
        if min(rows, columns) < MIN_PIECE_POINTS:
            raise ValueError(
                f"at least {MIN_PIECE_POINTS} rows and columns must lie above each other, got maps of "
                f"{self.upper.heights.shape} and {self.lower.heights.shape} points"
            )
        return rows, columns

    @property
    def area(self) -> float:
        """Nominal area of each piece, µm²."""
        return float(np.prod(self.shape) * np.prod(self.spacing))

    @property
    def used(self) -> tuple[float, float]:
        """The fraction of the upper and of the lower map that a piece is."""
        pieces = np.prod(self.shape)
        return tuple(float(pieces / np.prod(points)) for points in self._points)  # type: ignore[return-value]

    def most(self) -> int:
        """How many relative positions there are at the most: of maps of one size those that the shifts can take."""
        rooms = [max(upper, lower) - size for upper, lower, size in zip(*self._points, self.shape, strict=True)]
        same = self._points[0] == self._points[1]
        return (2 * rooms[0] + 1) * (rooms[1] // 2 + 1) if same else (rooms[0] + 1) * (rooms[1] + 1)

    def origins(self, index: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """First row and column of the upper and of the lower piece, on the finer spacing."""
        rooms = [(upper - size, lower - size) for upper, lower, size in zip(*self._points, self.shape, strict=True)]
        if self._points[0] == self._points[1]:
            along_x, along_y = quasi_random_point(index, 2)
            moved = round(rooms[0][0] * (2 * along_y - 1)), round(rooms[1][0] * (0.5 + 0.5 * along_x))
            lower = tuple(max(0, step) + (room[0] - abs(step)) // 2 for step, room in zip(moved, rooms, strict=True))
            upper = tuple(first - step for first, step in zip(lower, moved, strict=True))
        else:
            at = quasi_random_point(index, 4)
            upper = tuple(round(room[0] * at[axis]) for axis, room in enumerate(rooms))
            lower = tuple(round(room[1] * at[2 + axis]) for axis, room in enumerate(rooms))
        return upper, lower  # type: ignore[return-value]

    def moved(self, index: int) -> tuple[float, float]:
        """How far the upper map is moved along x and y, µm."""
        upper, lower = self.origins(index)
        dy, dx = self.spacing
        return (lower[1] - upper[1]) * dx, (lower[0] - upper[0]) * dy

    def pair(self, index: int) -> tuple[Surface, Surface]:
        """The pieces of one relative position, both levelled."""
        upper, lower = self.origins(index)
        return self._cut(self.upper, upper), self._cut(self.lower, lower)

    def surrogates(self, index: int) -> tuple[Surface, Surface]:
        """Pieces of a pair of surrogates of the whole maps, both levelled."""
        upper, lower = (
            self._cut(surrogate(body, self.seed, repetition=index, side=side), _middle(points, self.shape))
            for body, side, points in zip((self.upper, self.lower), SIDES, self._points, strict=True)
        )
        return upper, lower

    def _cut(self, body: Surface, origin: tuple[int, int]) -> Surface:
        return levelled(resampled_piece(body, self.spacing, origin, self.shape), self.level)


class SquarePairs:
    """Pairs of square pieces of random surfaces, of so many points along each side and a step (µm) between them."""

    _whole: int
    _step: float

    @property
    def spacing(self) -> tuple[float, float]:
        """µm, of rows and columns."""
        return self._step, self._step

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of each piece; a `ValueError` if these are too few to be pressed."""
        points = self._whole - self._whole // SHIFT_DIVISOR
        if points < MIN_PIECE_POINTS:
            raise ValueError(
                f"at least {MIN_PIECE_POINTS} rows and columns must be pressed, got {points} at a spacing of "
                f"{self._step:g} µm"
            )
        return points, points

    @property
    def area(self) -> float:
        """Nominal area of each piece, µm²."""
        return float(np.prod(self.shape) * np.prod(self.spacing))


@dataclass(frozen=True, eq=False)
class IsotropicPairs(SquarePairs):
    """Pairs of isotropic surfaces of which two profiles may be sections."""

    upper: Profile  # levelled, heights of the upper body up
    lower: Profile
    level: SurfaceTrend = "plane"  # what is taken off each piece
    seed: int = 2016

    @cached_property
    def _both(self) -> tuple[Profile, Profile]:
        step = min(self.upper.spacing, self.lower.spacing)
        return resampled(self.upper, step), resampled(self.lower, step)

    @cached_property
    def _step(self) -> float:  # type: ignore[override]
        return self._both[0].spacing

    @cached_property
    def _whole(self) -> int:  # type: ignore[override]
        return min(*(len(each) for each in self._both), MAX_SURROGATE_POINTS)

    @property
    def used(self) -> tuple[float, float]:
        """The length of a surface over that of the upper and of the lower profile."""
        upper, lower = (self._whole / len(each) for each in self._both)
        return upper, lower

    def surrogates(self, index: int) -> tuple[Surface, Surface]:
        """Pieces of a pair, both levelled."""
        shape = (self._whole, self._whole)
        upper, lower = (
            levelled(
                resampled_piece(
                    isotropic_surface(body, self.seed, shape=shape, repetition=index, side=side),
                    self.spacing, _middle(shape, self.shape), self.shape,
                ),
                self.level,
            )
            for body, side in zip(self._both, SIDES, strict=True)
        )  # fmt: skip
        return upper, lower


def to_joined_spectrum(scan: Profile | Surface | JoinedSpectrum) -> JoinedSpectrum:
    """The spectrum of a scan that is to be pressed on one of several: alike in all directions, where it is trusted."""
    return scan if isinstance(scan, JoinedSpectrum) else joined_spectrum([scan], names=["one scan"])


@dataclass(frozen=True, eq=False)
class SpectrumPairs(SquarePairs):
    """Pairs of pieces of random, periodic surfaces of two spectra, alike in all directions.

    Points are a quarter of the shortest wave apart, so that with a cut-off the surfaces are the larger.
    """

    upper: JoinedSpectrum  # random phases are the same whether a surface is turned over or not
    lower: JoinedSpectrum
    level: SurfaceTrend = "plane"  # what is taken off each piece
    seed: int = 2016
    cut_off: tuple[float, float] = (0.0, 0.0)  # µm, cutoff wavelengths of the upper and the lower body; 0 for none
    finest: float = 0.0  # µm, shortest of several cut-offs, which decides the grid: members are the same at each

    @cached_property
    def _step(self) -> float:  # type: ignore[override]
        return max(min(self.upper.shortest, self.lower.shortest), self.finest) / GRID_POINTS_PER_WAVELENGTH

    @cached_property
    def _whole(self) -> int:  # type: ignore[override]
        longest = max(self.upper.longest, self.lower.longest) / MAX_WAVELENGTH_FRACTION
        return min(MAX_SURROGATE_POINTS, int(longest / self._step))

    @property
    def side(self) -> float:
        """Side of the surfaces that pieces are taken from, µm."""
        return self._whole * self._step

    @property
    def used(self) -> tuple[float, float]:
        """The fraction of a surface that a piece is."""
        fraction = float(np.prod(self.shape)) / self._whole**2
        return fraction, fraction

    def surrogates(self, index: int) -> tuple[Surface, Surface]:
        """Pieces of a pair, both levelled."""
        return self._piece(self.upper, index, "upper"), self._piece(self.lower, index, "lower")

    def _piece(self, body: JoinedSpectrum, index: int, side: Side) -> Surface:
        shape = (self._whole, self._whole)
        whole = body.surface(self.seed, shape=shape, spacing=self.spacing, repetition=index, side=side)
        if (wavelength := self.cut_off[SIDES.index(side)]) > 0:
            whole = cut_off(whole, wavelength, periodic=True)
        rows, columns = self.shape
        piece = Surface(whole.heights[:rows, :columns], spacing=self.spacing, history=whole.history)
        return levelled(piece, self.level)


def _middle(points: tuple[int, int], shape: tuple[int, int]) -> tuple[int, int]:
    """First row and column of a piece in the middle."""
    return (points[0] - shape[0]) // 2, (points[1] - shape[1]) // 2
