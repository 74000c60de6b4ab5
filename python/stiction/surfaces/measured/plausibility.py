"""Checks of scans for implausible heights and spacings; each check yields a caveat with its own name."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._repr import format_with_unit
from stiction.surfaces.measured.raw import FileCaveat

MIN_MISSING_CODE_REPEATS = 2
# Minimum distance of a code for missing points from all other heights, as a multiple of the range of these heights.
MIN_MISSING_CODE_DISTANCE = 2.0
MIN_REPEATED_CODE_DISTANCE, MIN_KNOWN_CODE_DISTANCE = 0.5, 0.25
KNOWN_MISSING_CODES = frozenset(
    [sign * number for sign in (1, -1) for number in (999, 9999, 99999, 999999)]
    + [-(2**15), 2**15 - 1, 2**16 - 1, -(2**31), 2**31 - 1, 2**32 - 1]
)
MIN_DISTINCT_HEIGHTS = 5
MAX_MISSING_CODES_PER_EXTREME = 4
MIN_CODE_TO_MEDIAN_DEVIATION_RATIO = 3.0
MAX_SAMPLED_HEIGHTS = 65_536
MIN_COMPARED_HEIGHTS = 20
NUM_COMPARED_HEIGHTS_PER_SIDE = 12
# A height is too frequent if its count is at least a · m + b · √m, with these a and b and the usual count m.
# The usual count m of a height is the median count of the next lower and the next higher heights, whose number on each
# side is `NUM_COMPARED_HEIGHTS_PER_SIDE`.
MIN_RATIO_TO_USUAL_HEIGHT_COUNT, MIN_EXCESS_OVER_ROOT_OF_USUAL_HEIGHT_COUNT = 4.0, 6.0
MIN_FRACTION_OF_REPEATED_HEIGHT, MAX_FRACTION_OF_REPEATED_HEIGHT = 0.005, 0.4
# Zeros are too frequent if their count is at least 2 m + a · √(2 m) + b, with these a and b and the usual count m.
# The usual count m of heights near 0 is the largest mean count of the nearest 1, 3 or 12 heights on each side of 0.
MIN_EXCESS_OVER_ROOT_OF_USUAL_ZERO_COUNT, MIN_EXCESS_ZERO_COUNT, NUM_HEIGHTS_COMPARED_WITH_ZERO = 3.0, 4, (1, 3, 12)
# If a larger fraction of the rows of a map are repeated, the map is probably a profile that was extended along y.
MAX_FRACTION_OF_REPEATED_ROWS = 0.9
# A run of equal heights in a profile gets a caveat if the probability that rounding causes it is at most 1e-4.
MIN_EQUAL_RUN_LENGTH, MAX_PROBABILITY_OF_EQUAL_RUN = 8, 1e-4
# If the height range in the header is too large by a power of 1000 (within 10 %), the unit of the heights is wrong.
MAX_RATIO_TO_DECLARED_HEIGHT_RANGE, MAX_UNIT_FACTOR_DEVIATION, FACTOR_BETWEEN_UNITS = 10.0, 0.1, 1000.0
MIN_CHECKED_POINTS = 20
MIN_SPACING, MAX_SPACING, MAX_EXTENT = 1e-4, 1e4, 1e6  # µm


@dataclass(frozen=True)
class ScannedHeights:
    """Heights (µm, NaN at missing points) and spacing of a scan, and whether the heights were read from a text file."""

    heights: Floats
    spacing: tuple[float, ...]  # µm, along y and x
    factor: float = 1.0  # number in the file to µm
    # False if heights were passed as an array. They may have been computed, so some plausibility checks do not apply.
    from_file: bool = True
    declared_range: float | None = None  # µm, stated in the header
    # True if heights were read from text, where whole numbers may be counts of an analogue-to-digital converter.
    from_text: bool = True

    @cached_property
    def non_missing_heights(self) -> Floats:
        """Heights (µm) at all points that are not missing."""
        is_missing = np.isnan(self.heights)
        return self.heights[~is_missing] if is_missing.any() else self.heights.ravel()

    @cached_property
    def extremes(self) -> tuple[float, float]:
        """Lowest and highest measured height (µm) of the scan."""
        return float(self.non_missing_heights.min()), float(self.non_missing_heights.max())

    @property
    def height_range(self) -> float:
        """Distance (µm) from the lowest to the highest measured height."""
        return self.extremes[1] - self.extremes[0]


class PlausibilityCheck(NamedTuple):
    """Plausibility check of a scan: its name, its function (which yields descriptions of problems), and a remedy."""

    name: str
    find: Callable[[ScannedHeights], Iterator[str]]
    remedy: str


def find_caveats(scan: ScannedHeights) -> tuple[FileCaveat, ...]:
    """Apply all plausibility checks to a scan, and return a caveat for each problem that a check finds."""
    if scan.heights.size < MIN_CHECKED_POINTS:
        return ()
    findings = [(check, text) for check in PLAUSIBILITY_CHECKS[:1] for text in check.find(scan)]
    codes = [float(text.partition("|")[2]) * scan.factor for _, text in findings]
    if codes:
        is_code = np.isclose(scan.heights[..., np.newaxis], codes, rtol=1e-9, atol=0.0).any(axis=-1)
        scan = replace(scan, heights=np.where(is_code, np.nan, scan.heights))
    findings += [(check, text) for check in PLAUSIBILITY_CHECKS[1:] for text in check.find(scan)]
    return tuple(
        FileCaveat(check.name, text.partition("|")[0], check.remedy.replace("{}", text.partition("|")[2]))
        for check, text in findings
    )


def _find_repeated_extremes(scan: ScannedHeights) -> Iterator[str]:
    """Report extreme heights that may be codes for missing points, because they are far from all other heights."""
    for code, count, distance in _find_missing_point_codes(scan):
        number = _to_number_in_file(code, scan)
        yield (
            f"{count} of {scan.heights.size} heights {'are' if count > 1 else 'is'} exactly {number:.12g}, which is "
            f"{format_with_unit(distance, 'µm')} from all others, like a code for missing points|{number:.12g}"
        )


def _to_number_in_file(height: float, scan: ScannedHeights) -> float:
    """Convert a height (µm) back to the number that the file contains."""
    return float(f"{height / scan.factor:.12g}")


def _find_missing_point_codes(scan: ScannedHeights) -> list[tuple[float, int, float]]:
    """Return extreme heights that may be codes for missing points, each with its count and distance from other heights.

    Several codes may be at the same end of the height range, and their distances from each other are not limited. The
    distance of codes in a file from the other heights may be smaller if each code repeats or is a known code.
    """
    heights, extremes = scan.non_missing_heights, scan.extremes
    if heights.size < 2 * MIN_DISTINCT_HEIGHTS:
        return []
    # A code for missing points must be far from the median height, unless most heights are equal.
    sample = heights[:: max(1, heights.size // MAX_SAMPLED_HEIGHTS)]
    median = float(np.median(sample))
    max_near_deviation = MIN_CODE_TO_MEDIAN_DEVIATION_RATIO * float(np.median(np.abs(sample - median)))
    near_sample = sample[np.abs(sample - median) <= max_near_deviation]
    can_be_close = scan.from_file and any(
        _to_number_in_file(extreme, scan) in KNOWN_MISSING_CODES
        or np.count_nonzero(heights == extreme) >= MIN_MISSING_CODE_REPEATS
        for extreme in extremes
    )
    min_distance = MIN_KNOWN_CODE_DISTANCE if can_be_close else MIN_MISSING_CODE_DISTANCE
    max_gap = min_distance * float(np.ptp(near_sample))
    has_gap = max(float(near_sample.min()) - extremes[0], extremes[1] - float(near_sample.max())) > max_gap
    if near_sample.size > MIN_DISTINCT_HEIGHTS and not has_gap:
        return []
    is_far = (heights < median - max_near_deviation) | (heights > median + max_near_deviation)
    # In sorted order, a large gap separates a code for missing points from the other heights.
    gaps = np.diff(np.sort(np.concatenate([heights[is_far], [near_sample.min(), near_sample.max()]])))
    if not is_far.any() or (near_sample.size > MIN_DISTINCT_HEIGHTS and not (gaps > max_gap).any()):
        return []
    near_heights = heights[~is_far]
    far_heights, counts = np.unique(heights[is_far], return_counts=True)
    count_by_height = dict(zip(far_heights.tolist(), counts.tolist(), strict=True))
    low_codes, high_codes = (
        far_heights[far_heights < near_heights.min()].tolist(),
        far_heights[far_heights > near_heights.max()].tolist(),
    )
    ordered_heights = np.array([*low_codes, near_heights.min(), near_heights.max(), *high_codes])
    if np.unique(near_heights[:1000]).size < MIN_DISTINCT_HEIGHTS:
        return []
    code_counts = sorted(
        itertools.product(
            range(min(MAX_MISSING_CODES_PER_EXTREME, len(low_codes)) + 1),
            range(min(MAX_MISSING_CODES_PER_EXTREME, len(high_codes)) + 1),
        ),
        key=sum,
    )[1:]
    candidates = []
    for num_low_codes, num_high_codes in code_counts:
        remaining_values = ordered_heights[num_low_codes : ordered_heights.size - num_high_codes]
        code_groups = [low_codes[:num_low_codes], high_codes[len(high_codes) - num_high_codes :]]
        distances = [float(remaining_values[0]) - code for code in code_groups[0]] + [
            code - float(remaining_values[-1]) for code in code_groups[1]
        ]
        candidates.append((code_groups, distances, float(np.ptp(remaining_values))))
    for code_groups, distances, other_range in candidates:
        if (
            min(sum(count_by_height[code] for code in codes) for codes in code_groups if codes)
            >= MIN_MISSING_CODE_REPEATS
            and min(distances) > MIN_MISSING_CODE_DISTANCE * other_range
        ):
            return [
                (code, count_by_height[code], distance)
                for code, distance in zip([*code_groups[0], *code_groups[1]], distances, strict=True)
            ]
    if not can_be_close or np.unique(near_heights[:1000]).size < MIN_COMPARED_HEIGHTS:
        return []
    min_distance_by_code = {
        code: MIN_KNOWN_CODE_DISTANCE
        if _to_number_in_file(code, scan) in KNOWN_MISSING_CODES
        else MIN_REPEATED_CODE_DISTANCE
        if count_by_height[code] >= MIN_MISSING_CODE_REPEATS
        else math.inf
        for code in {*low_codes[:MAX_MISSING_CODES_PER_EXTREME], *high_codes[-MAX_MISSING_CODES_PER_EXTREME:]}
    }
    for code_groups, distances, other_range in reversed(candidates):
        codes = [*code_groups[0], *code_groups[1]]
        if all(
            distance > min_distance_by_code[code] * other_range for code, distance in zip(codes, distances, strict=True)
        ):
            return [(code, count_by_height[code], distance) for code, distance in zip(codes, distances, strict=True)]
    return []


def _find_repeated_heights(scan: ScannedHeights) -> Iterator[str]:
    """Report heights that occur much more often than similar heights, such as filled-in zeros or clipped heights."""
    if not scan.from_file:
        return
    heights = scan.non_missing_heights
    step = max(1, heights.size // MAX_SAMPLED_HEIGHTS)
    distinct_heights, repeat_counts = np.unique(heights[:: step + (step + 1) % 2], return_counts=True)
    if distinct_heights.size < MIN_COMPARED_HEIGHTS:
        return
    height_count = int(repeat_counts.sum())
    if text := _describe_frequent_zeros(distinct_heights, repeat_counts):
        yield text
    frequent_indices = np.flatnonzero(repeat_counts >= MIN_FRACTION_OF_REPEATED_HEIGHT * height_count)
    for height_index in frequent_indices[
        np.argsort(repeat_counts[frequent_indices])[::-1][:MAX_MISSING_CODES_PER_EXTREME]
    ].tolist():
        neighbours = np.delete(
            repeat_counts[
                max(0, height_index - NUM_COMPARED_HEIGHTS_PER_SIDE) : height_index + NUM_COMPARED_HEIGHTS_PER_SIDE + 1
            ],
            min(height_index, NUM_COMPARED_HEIGHTS_PER_SIDE),
        )
        usual_count = float(np.median(neighbours))
        repeated_fraction = repeat_counts[height_index] / height_count
        if (
            distinct_heights[height_index] != 0
            and repeat_counts[height_index]
            >= MIN_RATIO_TO_USUAL_HEIGHT_COUNT * usual_count
            + MIN_EXCESS_OVER_ROOT_OF_USUAL_HEIGHT_COUNT * usual_count**0.5
            and repeated_fraction <= MAX_FRACTION_OF_REPEATED_HEIGHT
        ):
            repeated_number = float(f"{distinct_heights[height_index] / scan.factor:.12g}")
            yield (
                f"{100 * repeated_fraction:.2g} % of the heights are exactly {repeated_number:.12g}, which is "
                f"{repeat_counts[height_index] / usual_count:.2g} times as frequent as similar heights, like a code "
                f"for missing points|{repeated_number:.12g}"
            )


def _describe_frequent_zeros(distinct_heights: Floats, counts: NDArray[np.int64]) -> str | None:
    """Return a description if heights of exactly 0 are much more frequent than similar heights, and None otherwise.

    Rounding towards zero makes the height 0 twice as frequent as other heights.
    """
    zero_index = int(np.searchsorted(distinct_heights, 0.0))
    height_count = int(counts.sum())
    if zero_index == distinct_heights.size or distinct_heights[zero_index] != 0:
        return None
    if not MIN_FRACTION_OF_REPEATED_HEIGHT <= counts[zero_index] / height_count <= MAX_FRACTION_OF_REPEATED_HEIGHT:
        return None
    first_index, end_index = (
        max(0, zero_index - NUM_COMPARED_HEIGHTS_PER_SIDE),
        zero_index + NUM_COMPARED_HEIGHTS_PER_SIDE + 1,
    )
    near_counts, distances = counts[first_index:end_index], np.abs(distinct_heights[first_index:end_index])
    step = float(np.diff(distinct_heights[first_index:end_index]).min())
    usual_count = max(
        float(near_counts[(distances > 0) & (distances < (num_nearest + 0.5) * step)].sum()) / (2 * num_nearest)
        for num_nearest in NUM_HEIGHTS_COMPARED_WITH_ZERO
    )
    if (
        counts[zero_index]
        < 2 * usual_count + MIN_EXCESS_OVER_ROOT_OF_USUAL_ZERO_COUNT * (2 * usual_count) ** 0.5 + MIN_EXCESS_ZERO_COUNT
    ):
        return None
    return (
        f"{100 * counts[zero_index] / height_count:.2g} % of the heights are exactly 0, which is "
        f"{counts[zero_index] / max(usual_count, 1.0):.2g} times as frequent as similar heights, like a code for "
        "missing points|0"
    )


def _find_repeated_rows(scan: ScannedHeights) -> Iterator[str]:
    """Report repeated rows, columns or points, which may not have been measured."""
    if not scan.from_file:
        return
    if scan.heights.ndim == 1:
        run_ends = np.flatnonzero(np.diff(scan.heights) != 0)
        runs = np.diff(run_ends, prepend=-1, append=scan.heights.size - 1)
        longest_run = int(runs.max())
        equal_fraction = (scan.heights.size - runs.size - (longest_run - 1)) / scan.heights.size
        if MIN_EQUAL_RUN_LENGTH <= longest_run < scan.heights.size / 2 and (
            scan.heights.size * equal_fraction ** (longest_run - 1) < MAX_PROBABILITY_OF_EQUAL_RUN
        ):
            yield f"{longest_run} heights in a row are equal, like points that were not measured"
    if (copies := _count_copies(scan.heights)) > 1:
        kind = "points" if scan.heights.ndim == 1 else "rows"
        yield f"the same {scan.heights.shape[0] // copies} {kind} follow each other {copies} times"
    if scan.heights.ndim == 1:
        return
    for kind, lines in (("rows", scan.heights), ("columns", scan.heights.T)):
        if min(lines.shape) < MIN_DISTINCT_HEIGHTS or np.unique(lines[:, : lines.shape[1] // 2 + 1][0]).size < (
            MIN_DISTINCT_HEIGHTS
        ):
            continue
        rows = np.flatnonzero((lines[1:, :8] == lines[:-1, :8]).all(axis=1))
        is_repeated = (lines[rows + 1] == lines[rows]).all(axis=1) & (np.ptp(lines[rows + 1], axis=1) > 0)
        line_count = int(is_repeated.sum())
        if 0 < line_count <= MAX_FRACTION_OF_REPEATED_ROWS * lines.shape[0]:
            text = f"{line_count} of {lines.shape[0]} {kind} are equal to the {kind[:-1]} before"
            yield f"{text}, like {kind} that were not measured"
        flat_rows = np.flatnonzero((lines[:, :8] == lines[:, :1]).all(axis=1))
        line_count = int((np.ptp(lines[flat_rows], axis=1) == 0).sum())
        if 0 < line_count <= MAX_FRACTION_OF_REPEATED_ROWS * lines.shape[0]:
            yield f"{line_count} of {lines.shape[0]} {kind} have equal heights, like {kind} that were not measured"


def _count_copies(heights: Floats) -> int:
    """Return 2 or 3 if a list of heights consists of two or three copies of a sequence, and 1 otherwise.

    The repetitions of a wave with a short period are not counted.
    """
    for copies in (2, 3):
        length = heights.shape[0] // copies
        if (
            length < MIN_DISTINCT_HEIGHTS
            or heights.shape[0] % copies
            or not np.array_equal(heights[length], heights[0], equal_nan=True)
        ):
            continue
        first_copy, periods = heights[:length], range(1, length // 2 + 1)
        if all(
            np.array_equal(copy_heights, first_copy, equal_nan=True) for copy_heights in np.split(heights, copies)
        ) and not any(
            np.array_equal(first_copy[period:], first_copy[: length - period], equal_nan=True) for period in periods
        ):
            return copies
    return 1


def _find_whole_number_heights(scan: ScannedHeights) -> Iterator[str]:
    """Report a scan whose heights are all integers in a unit of 1 µm or larger."""
    if scan.factor < 1 or not scan.from_text:
        return
    sample = scan.heights.flat[:MIN_CHECKED_POINTS] / scan.factor
    if not np.array_equal(sample[~np.isnan(sample)], np.round(sample[~np.isnan(sample)])):
        return
    numbers = scan.non_missing_heights / scan.factor
    if (
        numbers.size >= MIN_CHECKED_POINTS
        and np.ptp(numbers) >= MIN_DISTINCT_HEIGHTS
        and np.array_equal(numbers, np.round(numbers))
    ):
        yield f"all heights are multiples of {format_with_unit(scan.factor, 'µm')}, like counts of a converter"


def _find_implausible_sizes(scan: ScannedHeights) -> Iterator[str]:
    """Report a scan that is at least a metre long, or a spacing of at least a centimetre or below an ångström."""
    for axis, points, axis_spacing in zip("xy", scan.heights.shape[::-1], scan.spacing[::-1], strict=False):
        if points * axis_spacing >= MAX_EXTENT:
            yield f"the scan is {points * axis_spacing / 1e6:.3g} m long along {axis}"
        elif axis_spacing >= MAX_SPACING:
            yield f"points are {format_with_unit(axis_spacing, 'µm')} apart along {axis}"
        if axis_spacing < MIN_SPACING:
            yield f"points are {axis_spacing * 1e6:.3g} pm apart along {axis}, closer than atoms"


def _find_excessive_height_range(scan: ScannedHeights) -> Iterator[str]:
    """Report a scan whose height range exceeds its longest side."""
    longest_side = max(points * step for points, step in zip(scan.heights.shape, scan.spacing, strict=True))
    if scan.height_range > longest_side:
        height_range = format_with_unit(scan.height_range, "µm")
        yield f"heights span {height_range}, but the scan is only {format_with_unit(longest_side, 'µm')} long"


def _find_contradicted_height_range(scan: ScannedHeights) -> Iterator[str]:
    """Report heights whose range is far larger than the declared range, or smaller by a power of 1000.

    A declared range that is larger by any other factor may be the measuring range of the instrument.
    """
    if not scan.declared_range or not scan.height_range:
        return
    ratio = scan.height_range / scan.declared_range
    steps = math.log(ratio, FACTOR_BETWEEN_UNITS)
    is_in_other_unit = (
        round(steps) < 0 and abs(ratio / FACTOR_BETWEEN_UNITS ** round(steps) - 1) < MAX_UNIT_FACTOR_DEVIATION
    )
    if ratio > MAX_RATIO_TO_DECLARED_HEIGHT_RANGE or is_in_other_unit:
        height_range, declared_range = (
            format_with_unit(scan.height_range, "µm"),
            format_with_unit(scan.declared_range, "µm"),
        )
        yield f"heights span {height_range}, but the header declares a range of {declared_range}"


PLAUSIBILITY_CHECKS = (
    PlausibilityCheck("repeated-extreme", _find_repeated_extremes, "--missing-value {} treats them as missing points"),
    PlausibilityCheck(
        "repeated-height",
        _find_repeated_heights,
        "--missing-value {} treats them as missing points; accept it if the surface is flat there",
    ),
    PlausibilityCheck("repeated-rows", _find_repeated_rows, "read the other part only (--crop), or accept it"),
    PlausibilityCheck(
        "whole-numbers",
        _find_whole_number_heights,
        "multiply counts by their height first; see the header and the manual",
    ),
    PlausibilityCheck("size", _find_implausible_sizes, "check the unit of the spacing, --unit and --spacing"),
    PlausibilityCheck(
        "tall", _find_excessive_height_range, "check the units of heights and spacing, --unit and --spacing"
    ),
    PlausibilityCheck(
        "range",
        _find_contradicted_height_range,
        "check the unit of the heights, --unit and --missing-value; accept it if the range is another quantity",
    ),
)
"""Plausibility checks that are applied to every scan."""

READER_CAVEAT_NAMES = (
    "x3p-increment",
    "numbering",
    "positions",
    "truncated",
    "first-number",
    "unit-not-needed",
    "spacing",
    "points",
    "scale",
    "wrapped",
)
"""Names of the caveats that arise while a file is read, before the plausibility checks of the scan."""

FILE_CAVEAT_NAMES = (*(check.name for check in PLAUSIBILITY_CHECKS), *READER_CAVEAT_NAMES)
