"""Named checks for implausible heights and spacings, applied to files and to surfaces passed as objects."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._repr import format_with_unit
from stiction.surfaces.measured.raw import FileCaveat

# The largest or smallest height may be a code for missing points if at least this many points have this height.
MIN_MISSING_CODE_REPEATS = 2
# Minimum distance of a code for missing points from all other heights, relative to the range of the other heights.
MIN_MISSING_CODE_DISTANCE = 2.0
# A repeated height counts as a code for missing points only if there are at least this many other heights.
MIN_DISTINCT_HEIGHTS = 5
MAX_MISSING_CODES = 3  # maximum number of codes for missing points in a scan
MIN_CHECKED_POINTS = 20  # minimum number of points for a check; smaller arrays are assumed to be examples
# Minimum spacing (one ångström), maximum spacing (one centimetre) and maximum extent (one metre), in µm.
MIN_SPACING, MAX_SPACING, MAX_EXTENT = 1e-4, 1e4, 1e6


@dataclass(frozen=True)
class ScannedHeights:
    """Heights (µm, NaN at missing points) and spacing, with the conversion factor and the source of the numbers."""

    heights: Floats
    spacing: tuple[float, ...]  # µm, along (y and) x
    factor: float = 1.0  # conversion factor from the numbers in the file to µm
    from_text: bool = True  # True if the numbers were read from text; integers in text may be counts instead of heights

    @cached_property
    def non_missing_heights(self) -> Floats:
        """Heights that are not missing."""
        is_missing = np.isnan(self.heights)
        return self.heights[~is_missing] if is_missing.any() else self.heights.ravel()

    @cached_property
    def height_range(self) -> float:
        """Range of the heights that are not missing."""
        return float(self.non_missing_heights.max() - self.non_missing_heights.min())


class PlausibilityCheck(NamedTuple):
    """Check for implausible data: its name, a function that yields findings, and the remedy for these findings."""

    name: str
    find: Callable[[ScannedHeights], Iterator[str]]
    remedy: str


def find_caveats(scan: ScannedHeights) -> tuple[FileCaveat, ...]:
    """Apply all checks to a scan, and return the resulting caveats."""
    if scan.heights.size < MIN_CHECKED_POINTS:
        return ()
    findings = [(check, text) for check in PLAUSIBILITY_CHECKS[:1] for text in check.find(scan)]
    codes = [float(text.partition("|")[2]) * scan.factor for _, text in findings]
    if codes:  # the other checks ignore heights that may be codes for missing points
        is_code = np.isclose(scan.heights[..., np.newaxis], codes, rtol=1e-9, atol=0.0).any(axis=-1)
        scan = replace(scan, heights=np.where(is_code, np.nan, scan.heights))
    findings += [(check, text) for check in PLAUSIBILITY_CHECKS[1:] for text in check.find(scan)]
    return tuple(
        FileCaveat(check.name, text.partition("|")[0], check.remedy.replace("{}", text.partition("|")[2]))
        for check, text in findings
    )


def _find_repeated_extremes(scan: ScannedHeights) -> Iterator[str]:
    """Find extreme values that repeat exactly and are far from all other heights."""
    heights = scan.non_missing_heights
    for _ in range(MAX_MISSING_CODES):
        missing_code = _find_missing_point_marker(heights)
        if missing_code is None:
            return
        value, count, distance = missing_code
        number = float(f"{value / scan.factor:.12g}")
        yield (
            f"{count} of {scan.heights.size} heights are exactly {number:.12g}, which is "
            f"{format_with_unit(distance, 'µm')} from all others, like a code for missing points|{number:.12g}"
        )
        heights = heights[heights != value]


def _find_missing_point_marker(heights: Floats) -> tuple[float, int, float] | None:
    """Return a repeated extreme value, its count, and its distance from the other heights.

    Returns None if there is no such value.
    """
    if heights.size < 2 * MIN_DISTINCT_HEIGHTS:
        return None
    for sign in (1.0, -1.0):
        value = float(heights.min() if sign > 0 else heights.max())
        is_extreme = heights == value
        count = int(np.count_nonzero(is_extreme))
        if not MIN_MISSING_CODE_REPEATS <= count < heights.size:
            continue
        low, high = _range_without_excluded(heights, is_extreme)
        distance = low - value if sign > 0 else value - high
        if (
            distance > MIN_MISSING_CODE_DISTANCE * (high - low)
            and np.unique(heights[~is_extreme][:1000]).size >= MIN_DISTINCT_HEIGHTS
        ):
            return value, count, distance
    return None


def _range_without_excluded(heights: Floats, is_excluded: NDArray[np.bool_]) -> tuple[float, float]:
    is_included = ~is_excluded
    return (
        float(np.min(heights, where=is_included, initial=np.inf)),
        float(np.max(heights, where=is_included, initial=-np.inf)),
    )


def _find_whole_number_heights(scan: ScannedHeights) -> Iterator[str]:
    """Find scans whose heights are all integers in a unit of 1 µm or larger."""
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
    """Find scans at least a metre long, spacings of at least a centimetre, and spacings below an ångström."""
    for axis, points, step in zip("xy", scan.heights.shape[::-1], scan.spacing[::-1], strict=False):
        if points * step >= MAX_EXTENT:
            yield f"the scan is {points * step / 1e6:.3g} m long along {axis}"
        elif step >= MAX_SPACING:
            yield f"points are {format_with_unit(step, 'µm')} apart along {axis}"
        if step < MIN_SPACING:
            yield f"points are {step * 1e6:.3g} pm apart along {axis}, closer than atoms"


def _find_excessive_height_range(scan: ScannedHeights) -> Iterator[str]:
    """Find scans whose heights span more than the length of the longest side."""
    length = max(points * step for points, step in zip(scan.heights.shape, scan.spacing, strict=True))
    if scan.height_range > length:
        height_range = format_with_unit(scan.height_range, "µm")
        yield f"heights span {height_range}, but the scan is only {format_with_unit(length, 'µm')} long"


PLAUSIBILITY_CHECKS = (
    PlausibilityCheck("repeated-extreme", _find_repeated_extremes, "--missing-value {} treats them as missing points"),
    PlausibilityCheck(
        "whole-numbers",
        _find_whole_number_heights,
        "multiply counts by their height first; see the header and the manual",
    ),
    PlausibilityCheck("size", _find_implausible_sizes, "check the unit of the spacing, --unit and --spacing"),
    PlausibilityCheck(
        "tall", _find_excessive_height_range, "check the units of heights and spacing, --unit and --spacing"
    ),
)
"""Checks that are applied to every scan."""

READER_CAVEAT_NAMES = (
    "x3p-increment",
    "numbering",
    "truncated",
    "first-number",
    "unit-not-needed",
    "spacing",
    "points",
    "scale",
    "wrapped",
)
"""Names of the caveats that the file readers add to the caveats of the checks."""

FILE_CAVEAT_NAMES = (*(check.name for check in PLAUSIBILITY_CHECKS), *READER_CAVEAT_NAMES)
