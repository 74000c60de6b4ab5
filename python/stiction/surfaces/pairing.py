"""Pairs of surfaces that are made from two scans: lines, pieces of maps, or surrogates.

A pair depends only on the scans, the options and its index. Neither the number of pairs nor the process
that computes a pair affects the pair.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from stiction._caching import cached_property
from stiction._checks import check_choice, validate_number, validate_whole_number
from stiction._units import short_repr
from stiction.surfaces.cut_off import cut_off
from stiction.surfaces.joined_spectrum import MAX_WAVELENGTH_TO_SIDE, JoinedSpectrum, joined_spectrum
from stiction.surfaces.preparation import (
    ProfileTrend,
    SurfaceTrend,
    cropped,
    flipped,
    levelled,
    resample_piece,
    resampled,
)
from stiction.surfaces.profile import LineOrientation, Profile, Side, select_from_mask
from stiction.surfaces.surface import Surface, as_body
from stiction.surfaces.surrogates import isotropic_surface, surrogate

# Default number of line pairs: a result and its interval then take one or two seconds to compute.
DEFAULT_NUM_LINE_PAIRS = 128
# The largest shift is the map length divided by this number, so that three quarters of two maps always overlap.
MAX_SHIFT_DIVISOR = 4
MIN_PIECE_SIDE_POINTS = 16
MAX_SURROGATE_SIDE_POINTS = 512
SurrogateBodies = Literal["none", "upper", "lower", "both"]
SIDES: tuple[Side, Side] = ("upper", "lower")
_GOLDEN_RATIO = (5**0.5 - 1) / 2
# Constants of two- and four-dimensional quasi-random sequences: the real roots of x^3 = x + 1 and of x^5 = x + 1.
_PLASTIC_NUMBER = 1.324717957244746
_QUINTIC_ROOT = 1.1673039782614187
GRID_POINTS_PER_WAVELENGTH = 4


def quasi_random_point(index: int, dimensions: int) -> tuple[float, ...]:
    """Return a point of a quasi-random sequence in the unit cube, given the index of the point.

    The sequence is an additive recurrence with the golden ratio.
    """
    if dimensions == 1:
        return ((index * _GOLDEN_RATIO) % 1,)
    recurrence_base = _PLASTIC_NUMBER if dimensions == 2 else _QUINTIC_ROOT
    return tuple((0.5 + index * recurrence_base**-power) % 1 for power in range(1, dimensions + 1))


# ---- Lines -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class LinePairs:
    """Pairs (upper line, lower line) from two scans, or from surrogates of such lines.

    `paired_lines` describes the options.
    """

    upper: Profile | Surface
    lower: Profile | Surface
    travel: float | None = None
    level: ProfileTrend | None = "line"
    along: LineOrientation = "x"
    surrogates: SurrogateBodies = "none"
    seed: int = 2016
    has_several_pairs: bool = False
    # Number of line pairs; None if it is unlimited.
    count: int | None = None

    def max_pair_count(self) -> int | None:
        """Return how many different line pairs two scans provide, or None for surrogates (no limit)."""
        if self.surrogates != "none":
            return None
        line_counts = [self._count_lines(body) for body in (self.upper, self.lower) if isinstance(body, Surface)]
        return min(line_counts, default=1)

    def position_across_lines(self, index: int) -> float:
        """Return the distance (µm) from the upper map's first line to the upper line of a pair; 0 for profiles."""
        if not isinstance(self.upper, Surface):
            return 0.0
        line_distance = self.upper.spacing[0 if self.along == "x" else 1]
        return self._choose_row_or_column(self.upper, index) * line_distance

    def pair(self, index: int) -> tuple[Profile, Profile]:
        """Return the line pair with a given index, as two profiles with equal spacing."""
        is_lower_shifted = isinstance(self.upper, Surface) and isinstance(self.lower, Surface)
        lines = self._extract_line(self.upper, index), self._extract_line(self.lower, index, shifted=is_lower_shifted)
        if self.level is not None:
            lines = levelled(lines[0], self.level), levelled(lines[1], self.level)
        upper_line, lower_line = (
            self._generate_surrogate_line(line, index, side) if self.surrogates in (side, "both") else line
            for line, side in zip(lines, SIDES, strict=True)
        )
        spacing = min(upper_line.spacing, lower_line.spacing)
        upper_line, lower_line = resampled(flipped(upper_line), spacing), resampled(lower_line, spacing)
        if self.has_several_pairs and self.travel is None:
            return _crop_to_equal_length(upper_line, lower_line, index, self.level)
        return self._cut_slider(upper_line, len(lower_line)), lower_line

    def _cut_slider(self, upper_line: Profile, track_points: int) -> Profile:
        upper_points, spacing = len(upper_line), upper_line.spacing
        if self.travel is None:
            start = max(track_points - upper_points, track_points // 2)
        else:
            start = round(validate_number("travel", self.travel, unit="µm") / spacing)
        slider_points = min(upper_points, track_points - start)
        if start < 0 or 2 * slider_points < min(upper_points, track_points) - 1:
            max_travel = (track_points - min(upper_points, track_points) // 2) * spacing
            raise ValueError(
                f"travel must be between 0 and {max_travel:g} µm, got {short_repr(self.travel)}; a longer travel would "
                "leave a slider shorter than half of the shorter profile"
            )
        slider_profile = (
            upper_line if slider_points == upper_points else cropped(upper_line, 0.0, slider_points * spacing)
        )
        return slider_profile if self.level is None else levelled(slider_profile, self.level)

    def _extract_line(self, body: Profile | Surface, index: int, *, shifted: bool = False) -> Profile:
        """Return the line that a body contributes to a line pair: a row or column of a map, or the profile itself.

        With `shifted`, line 0 is a third of the width away from the edge.
        """
        if isinstance(body, Profile):
            return body
        extract_line = body.row if self.along == "x" else body.column
        return extract_line(self._choose_row_or_column(body, index, shifted=shifted))

    def _choose_row_or_column(self, surface: Surface, index: int, *, shifted: bool = False) -> int:
        """Return the row or column number of the line that a map contributes to line pair `index`.

        Every line is used once before a line is used again.
        """
        line_count = self._count_lines(surface)
        start = max(line_count // 3, 1) if shifted else 0
        if self.count is not None:
            return (start + index * line_count // self.count) % line_count
        # The step between line numbers is near 0.618 · `line_count` and coprime to `line_count`, so all lines are used.
        step = max(1, round(line_count * _GOLDEN_RATIO))
        while math.gcd(step, line_count) > 1:
            step += 1
        return (start + index * step) % line_count

    def _count_lines(self, surface: Surface) -> int:
        return int(surface.heights.shape[0 if self.along == "x" else 1])

    def _generate_surrogate_line(self, profile: Profile, index: int, side: Side) -> Profile:
        random_profile = surrogate(profile, self.seed, repetition=index, side=side)
        return profile.changed(
            random_profile.heights, f"replaced by its surrogate of seed {self.seed}, repetition {index}"
        )


def paired_lines(
    upper: Profile | Surface,
    lower: Profile | Surface,
    *,
    travel: float | None = None,
    level: ProfileTrend | None = "line",
    lines: int = DEFAULT_NUM_LINE_PAIRS,
    along: LineOrientation = "x",
    surrogates: SurrogateBodies = "none",
    seed: int = 2016,
) -> tuple[list[Profile], list[Profile]]:
    """Return two lists of profiles to press: flipped lines of the upper scan, and lines of the lower scan.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Scans, both with heights that point out of the material. If the grids differ, the finer one is used for both.
    travel : float, µm, optional
        Largest offset, by which sliders are shortened. The default for a single pair is half the length of the lower
        profile, or its excess length over the upper profile if this is larger. The default for several pairs is no
        travel: the longer line of a pair is cropped to the length of the shorter line, at positions that vary from pair
        to pair.
    level : {"line", "mean", "quadratic"} or None
        Trend to subtract from every line, and again from every slider after it is cropped.
    lines : int
        Number of pairs of lines, evenly spaced over the surfaces, or of pairs of surrogates; two profiles are one pair.
        The lines of two surfaces are offset by a third of the width, so that a surface can be paired with itself.
    along : {"x", "y"}
        Direction of the lines: "x" for rows, "y" for columns.
    surrogates : {"none", "upper", "lower", "both"}
        Bodies that are replaced by a `surrogate`, with a new surrogate for every line.
    seed : int
        Seed of the surrogates.

    Returns
    -------
    sliders, counterfaces : list of Profile
        Flipped upper lines and lower lines, as many of each as there are pairs, all with equal spacing.

    Raises
    ------
    ValueError
        If an argument is outside its range, or if travel leaves less than half of the shorter profile as a slider.

    See Also
    --------
    press : Loads and contact area of a pair.
    pair : Friction of two scans at many relative positions.

    Examples
    --------
    >>> from stiction import paired_lines, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> lines = paired_lines(upper, lower, lines=4)
    >>> [len(each) for each in lines[:2]]
    [4, 4]
    """
    check_choice("along", along, LineOrientation)
    check_choice("surrogates", surrogates, SurrogateBodies)
    if level is not None:
        check_choice("level", level, ProfileTrend)
    count = validate_whole_number("lines", lines, minimum=1)
    for name, body in (("upper", upper), ("lower", lower)):
        as_body(name, body)
    max_count = LinePairs(upper, lower, along=along, surrogates=surrogates).max_pair_count()
    count = count if max_count is None else min(count, max_count)
    line_pairs = LinePairs(
        upper, lower, travel, level, along, surrogates, seed, has_several_pairs=count > 1, count=count
    )
    profiles = [line_pairs.pair(index) for index in range(count)]
    return [upper_line for upper_line, _ in profiles], [lower_line for _, lower_line in profiles]


def _crop_to_equal_length(
    upper: Profile, lower: Profile, index: int, level: ProfileTrend | None
) -> tuple[Profile, Profile]:
    """Crop the longer profile of a pair to the length of the shorter profile, and level the cropped profile again.

    The position depends on `index`.
    """
    length = min(len(upper), len(lower))

    def crop_and_level(profile: Profile) -> Profile:
        if len(profile) == length:
            return profile
        start_index = round(quasi_random_point(index, 1)[0] * (len(profile) - length))
        cropped_profile = cropped(profile, start_index * profile.spacing, (start_index + length) * profile.spacing)
        return cropped_profile if level is None else levelled(cropped_profile, level)

    return crop_and_level(upper), crop_and_level(lower)


def piece_below_slider(lower: Profile, offset: float, slider: Profile) -> Profile:
    """Return the part of the lower profile below a slider that starts at the distance `offset` (µm)."""
    start_index = round(offset / lower.spacing)
    selected_range = slice(start_index, start_index + len(slider))
    return Profile(
        lower.heights[selected_range], spacing=lower.spacing, missing=select_from_mask(lower.missing, selected_range)
    )


# ---- Areas -----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class MapPairs:
    """Pairs of pieces from two height maps or from their surrogates, at several relative shifts.

    All pieces have the same size.

    A piece has three quarters of the shorter length along each axis, on the finer spacing. The positions of the pieces
    are spread over both maps. For maps of equal size, the shifts avoid contact of a map with itself or its mirror
    image.
    """

    # Map of the upper body after flipping: heights are positive upwards, and the material lies above the surface.
    upper: Surface
    lower: Surface
    level: SurfaceTrend = "plane"
    seed: int = 2016
    shifts: tuple[tuple[float, float], ...] | None = None  # µm

    @cached_property
    def spacing(self) -> tuple[float, float]:
        """Spacings (µm) along y and x of every piece: along each axis, the smaller of the two maps' spacings."""
        (uy, ux), (ly, lx) = self.upper.spacing, self.lower.spacing
        return min(uy, ly), min(ux, lx)

    @cached_property
    def _map_shapes(self) -> tuple[tuple[int, int], tuple[int, int]]:
        """Shape (rows, columns) of each map after resampling to the grid spacing of the map pieces."""
        return tuple(  # type: ignore[return-value]
            tuple(
                points
                if old_spacing == new_spacing
                else math.floor((points - 1) * old_spacing / new_spacing + 1e-9) + 1
                for points, old_spacing, new_spacing in zip(body.heights.shape, body.spacing, self.spacing, strict=True)
            )
            for body in (self.upper, self.lower)
        )

    @cached_property
    def _shifts_in_points(self) -> tuple[tuple[int, int], ...]:
        """Shifts of the upper map as whole numbers of grid points (rows, columns), rounded from shifts in µm."""
        dy, dx = self.spacing
        return tuple((round(y / dy), round(x / dx)) for x, y in self.shifts or ())

    def _find_overlap(self, steps: tuple[int, int]) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return the overlap of two shifted maps: its first row and column in the lower map, and its shape."""
        starts = tuple(max(0, step) for step in steps)
        ends = (
            min(lower_points, step + upper_points)
            for upper_points, lower_points, step in zip(*self._map_shapes, steps, strict=True)
        )
        return starts, tuple(end - start for end, start in zip(ends, starts, strict=True))  # type: ignore[return-value]

    @cached_property
    def shape(self) -> tuple[int, int]:
        """Number of rows and number of columns, which are the same for all pieces.

        Raises a `ValueError` if the pieces would be too small.
        """
        if self.shifts is not None:
            overlap_shapes = [self._find_overlap(steps)[1] for steps in self._shifts_in_points]
            rows, columns = (min(lengths) for lengths in zip(*overlap_shapes, strict=True))
        else:
            rows, columns = (
                (shortest_length := min(lengths)) - shortest_length // MAX_SHIFT_DIVISOR
                for lengths in zip(*self._map_shapes, strict=True)
            )
        if self.shifts is not None and min(rows, columns) < MIN_PIECE_SIDE_POINTS:
            raise ValueError(
                f"positions must leave an overlap of at least {MIN_PIECE_SIDE_POINTS} rows and columns, "
                f"got {max(rows, 0)} rows and {max(columns, 0)} columns"
            )
        if min(rows, columns) < MIN_PIECE_SIDE_POINTS:
            raise ValueError(
                f"the maps must overlap in at least {MIN_PIECE_SIDE_POINTS} rows and columns, got maps of "
                f"{self.upper.heights.shape} and {self.lower.heights.shape} points"
            )
        return rows, columns

    @property
    def piece_area(self) -> float:
        """Nominal area (µm²) of a piece."""
        return float(np.prod(self.shape) * np.prod(self.spacing))

    @property
    def piece_fractions(self) -> tuple[float, float]:
        """Two ratios: area of a piece to area of the upper map, and area of a piece to area of the lower map."""
        piece_size = np.prod(self.shape)
        return tuple(float(piece_size / np.prod(map_shape)) for map_shape in self._map_shapes)  # type: ignore[return-value]

    def max_pair_count(self) -> int:
        """Return the number of different relative positions of both maps."""
        if self.shifts is not None:
            return len(self.shifts)
        margins = [
            max(upper_points, lower_points) - overlap_points
            for upper_points, lower_points, overlap_points in zip(*self._map_shapes, self.shape, strict=True)
        ]
        equal_size = self._map_shapes[0] == self._map_shapes[1]
        return (2 * margins[0] + 1) * (margins[1] // 2 + 1) if equal_size else (margins[0] + 1) * (margins[1] + 1)

    def piece_origins(self, index: int) -> tuple[tuple[int, int], tuple[int, int]]:
        """Return (first row, first column) on the resampled grid, for the upper and for the lower piece of a pair."""
        if self.shifts is not None:
            overlap_start, overlap_shape = self._find_overlap(self._shifts_in_points[index])
            lower_origin = tuple(
                start + (n - m) // 2 for start, n, m in zip(overlap_start, overlap_shape, self.shape, strict=True)
            )
            upper_origin = tuple(
                start - shift_along_axis
                for start, shift_along_axis in zip(lower_origin, self._shifts_in_points[index], strict=True)
            )
            return upper_origin, lower_origin  # type: ignore[return-value]
        margins = [
            (upper - overlap_shape, lower - overlap_shape)
            for upper, lower, overlap_shape in zip(*self._map_shapes, self.shape, strict=True)
        ]
        if self._map_shapes[0] == self._map_shapes[1]:
            fraction_x, fraction_y = quasi_random_point(index, 2)
            shift = round(margins[0][0] * (2 * fraction_y - 1)), round(margins[1][0] * (0.5 + 0.5 * fraction_x))
            lower = tuple(
                max(0, shift_along_axis) + (margin[0] - abs(shift_along_axis)) // 2
                for shift_along_axis, margin in zip(shift, margins, strict=True)
            )
            upper = tuple(
                overlap_start - shift_along_axis for overlap_start, shift_along_axis in zip(lower, shift, strict=True)
            )
        else:
            fractions = quasi_random_point(index, 4)
            upper = tuple(round(margin[0] * fractions[axis]) for axis, margin in enumerate(margins))
            lower = tuple(round(margin[1] * fractions[2 + axis]) for axis, margin in enumerate(margins))
        return upper, lower  # type: ignore[return-value]

    def map_shift(self, index: int) -> tuple[float, float]:
        """Return the shift (µm) of the upper map along x and along y for the pair with a given index."""
        upper_origin, lower_origin = self.piece_origins(index)
        dy, dx = self.spacing
        return (lower_origin[1] - upper_origin[1]) * dx, (lower_origin[0] - upper_origin[0]) * dy

    def pair(self, index: int) -> tuple[Surface, Surface]:
        """Return the pair with a given index: upper piece and lower piece, both levelled."""
        upper_origin, lower_origin = self.piece_origins(index)
        return self._cut_piece(self.upper, upper_origin), self._cut_piece(self.lower, lower_origin)

    def surrogates(self, index: int) -> tuple[Surface, Surface]:
        """Generate a surrogate of each map for the pair `index`, and return a levelled piece of each surrogate."""
        upper, lower = (
            self._cut_piece(
                surrogate(body, self.seed, repetition=index, side=side),
                _find_origin_of_middle_map_piece(points, self.shape),
            )
            for body, side, points in zip((self.upper, self.lower), SIDES, self._map_shapes, strict=True)
        )
        return upper, lower

    def _cut_piece(self, body: Surface, origin: tuple[int, int]) -> Surface:
        return levelled(resample_piece(body, self.spacing, origin, self.shape), self.level)


class SquarePiecePairs:
    """Base class for pairs of square pieces, cut from random height maps with the same spacing along x and y."""

    _count_points_per_side: int
    _grid_spacing: float

    @property
    def spacing(self) -> tuple[float, float]:
        """Spacings (µm) of rows and columns in the generated height maps."""
        return self._grid_spacing, self._grid_spacing

    @property
    def shape(self) -> tuple[int, int]:
        """Number of rows and number of columns, which are the same for all pieces.

        Raises a `ValueError` if the pieces would be too small.
        """
        points = self._count_points_per_side - self._count_points_per_side // MAX_SHIFT_DIVISOR
        if points < MIN_PIECE_SIDE_POINTS:
            raise ValueError(
                f"pressed pieces must have at least {MIN_PIECE_SIDE_POINTS} rows and columns, got {points} at a "
                f"spacing of {self._grid_spacing:g} µm"
            )
        return points, points

    @property
    def piece_area(self) -> float:
        """Nominal area (µm²) of a piece."""
        return float(np.prod(self.shape) * np.prod(self.spacing))


@dataclass(frozen=True, eq=False)
class IsotropicSurfacePairs(SquarePiecePairs):
    """Pairs of pieces of random isotropic height maps; each map has the spectrum of one of two profiles."""

    upper: Profile
    lower: Profile
    level: SurfaceTrend = "plane"
    seed: int = 2016

    @cached_property
    def _resampled_profiles(self) -> tuple[Profile, Profile]:
        step = min(self.upper.spacing, self.lower.spacing)
        return resampled(self.upper, step), resampled(self.lower, step)

    @cached_property
    def _grid_spacing(self) -> float:  # type: ignore[override]
        return self._resampled_profiles[0].spacing

    @cached_property
    def _count_points_per_side(self) -> int:  # type: ignore[override]
        return min(*(len(profile) for profile in self._resampled_profiles), MAX_SURROGATE_SIDE_POINTS)

    @property
    def piece_fractions(self) -> tuple[float, float]:
        """Two ratios: side length of a piece to the upper profile's length, and to the lower profile's length."""
        upper, lower = (self._count_points_per_side / len(profile) for profile in self._resampled_profiles)
        return upper, lower

    def surrogates(self, index: int) -> tuple[Surface, Surface]:
        """Generate a random map from each profile for the pair `index`, and return a levelled piece of each map."""
        shape = (self._count_points_per_side, self._count_points_per_side)
        upper, lower = (
            levelled(
                resample_piece(
                    isotropic_surface(body, self.seed, shape=shape, repetition=index, side=side),
                    self.spacing, _find_origin_of_middle_map_piece(shape, self.shape), self.shape,
                ),
                self.level,
            )
            for body, side in zip(self._resampled_profiles, SIDES, strict=True)
        )  # fmt: skip
        return upper, lower


def to_joined_spectrum(scan: Profile | Surface | JoinedSpectrum) -> JoinedSpectrum:
    """Return the isotropic spectrum of a scan, at the wavelengths that the scan resolves reliably.

    A joined spectrum is returned unchanged.
    """
    return scan if isinstance(scan, JoinedSpectrum) else joined_spectrum([scan], names=["one scan"])


@dataclass(frozen=True, eq=False)
class SurfacePairsFromSpectra(SquarePiecePairs):
    """Pairs of pieces of random, periodic, isotropic height maps, one map for each of two given spectra.

    The spacing is a quarter of the shortest wavelength, so a longer cutoff wavelength gives a larger surface.
    """

    # Flipping the upper body does not change its spectrum.
    upper: JoinedSpectrum
    lower: JoinedSpectrum
    level: SurfaceTrend = "plane"
    seed: int = 2016
    # Cutoff wavelengths (µm) of the upper and the lower body, or 0 for an unfiltered body.
    cut_off: tuple[float, float] = (0.0, 0.0)
    # Shortest cutoff (µm) of a study. It determines the grid of the generated surfaces at every cutoff.
    shortest_cutoff: float = 0.0

    @cached_property
    def _grid_spacing(self) -> float:  # type: ignore[override]
        return max(min(self.upper.shortest, self.lower.shortest), self.shortest_cutoff) / GRID_POINTS_PER_WAVELENGTH

    @cached_property
    def _count_points_per_side(self) -> int:  # type: ignore[override]
        longest_period = max(self.upper.longest, self.lower.longest) / MAX_WAVELENGTH_TO_SIDE
        return min(MAX_SURROGATE_SIDE_POINTS, int(longest_period / self._grid_spacing))

    @property
    def side_length(self) -> float:
        """Side length (µm) of the generated height maps."""
        return self._count_points_per_side * self._grid_spacing

    @property
    def piece_fractions(self) -> tuple[float, float]:
        """Ratio of a piece's area to the area of the generated map, given twice: for the upper and the lower map."""
        fraction = float(np.prod(self.shape)) / self._count_points_per_side**2
        return fraction, fraction

    def surrogates(self, index: int) -> tuple[Surface, Surface]:
        """Generate a random map from each spectrum for the pair `index`, and return a levelled piece of each map."""
        return self._generate_piece(self.upper, index, "upper"), self._generate_piece(self.lower, index, "lower")

    def _generate_piece(self, body: JoinedSpectrum, index: int, side: Side) -> Surface:
        shape = (self._count_points_per_side, self._count_points_per_side)
        surface = body.surface(self.seed, shape=shape, spacing=self.spacing, repetition=index, side=side)
        if (cut_off_wavelength := self.cut_off[SIDES.index(side)]) > 0:
            surface = cut_off(surface, cut_off_wavelength, periodic=True)
        rows, columns = self.shape
        piece = Surface(surface.heights[:rows, :columns], spacing=self.spacing, history=surface.history)
        return levelled(piece, self.level)


def _find_origin_of_middle_map_piece(points: tuple[int, int], shape: tuple[int, int]) -> tuple[int, int]:
    """Return the row and the column at which a centred piece of a height map begins."""
    return (points[0] - shape[0]) // 2, (points[1] - shape[1]) // 2
