"""Named checks of heights and spacing that hardly any surface has, for all formats and for bodies in memory."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._repr import with_unit
from stiction.surfaces.measured.raw import Caveat

MIN_REPEATS = 2  # points at an extreme value that may be a code for missing points
FAR = 2.0  # range of all other heights by which such a value is away from them
MIN_DISTINCT = 5  # different values among the others, below which a surface is one of steps
MAX_CODES = 3  # codes that one scan may have
MIN_POINTS = 20  # points of a scan; fewer are an example
MIN_SPACING, MAX_SPACING, MAX_EXTENT = 1e-4, 1e4, 1e6  # µm: an ångström, a centimetre and a metre


@dataclass(frozen=True)
class Scan:
    """What is checked: heights in µm, NaN where they are missing, and how they were written."""

    heights: Floats
    spacing: tuple[float, ...]  # µm, along (y and) x
    factor: float = 1.0  # from the numbers of the file to µm
    from_text: bool = True  # whether the numbers were written in words, so that counts are whole numbers

    @cached_property
    def known(self) -> Floats:
        """Heights that are not missing."""
        absent = np.isnan(self.heights)
        return self.heights[~absent] if absent.any() else self.heights.ravel()

    @cached_property
    def span(self) -> float:
        """Range of the heights."""
        return float(self.known.max() - self.known.min())


class Check(NamedTuple):
    """A check by its name: yields its findings, and the option or the edit that settles them."""

    name: str
    find: Callable[[Scan], Iterator[str]]
    cure: str


def caveats_of(scan: Scan) -> tuple[Caveat, ...]:
    """Return the doubts about a scan by all checks."""
    if scan.heights.size < MIN_POINTS:
        return ()
    found = [(check, text) for check in CHECKS[:1] for text in check.find(scan)]
    codes = [float(text.partition("|")[2]) * scan.factor for _, text in found]
    if codes:  # which say nothing of the heights
        is_code = np.isclose(scan.heights[..., np.newaxis], codes, rtol=1e-9, atol=0.0).any(axis=-1)
        scan = replace(scan, heights=np.where(is_code, np.nan, scan.heights))
    found += [(check, text) for check in CHECKS[1:] for text in check.find(scan)]
    return tuple(
        Caveat(check.name, text.partition("|")[0], check.cure.replace("{}", text.partition("|")[2]))
        for check, text in found
    )


def _repeated_extremes(scan: Scan) -> Iterator[str]:
    """Find extreme values that repeat to the last digit, far from all others."""
    heights = scan.known
    for _ in range(MAX_CODES):
        found = _code(heights)
        if found is None:
            return
        value, count, away = found
        number = float(f"{value / scan.factor:.12g}")
        yield (
            f"{count} of {scan.heights.size} heights are exactly {number:.12g}, {with_unit(away, 'µm')} away from all "
            f"others, as a code for missing points is|{number:.12g}"
        )
        heights = heights[heights != value]


def _code(heights: Floats) -> tuple[float, int, float] | None:
    """Return an extreme value that repeats, its count, and its distance from all others."""
    if heights.size < 2 * MIN_DISTINCT:
        return None
    for sign in (1.0, -1.0):
        value = float(heights.min() if sign > 0 else heights.max())
        at = heights == value
        count = int(np.count_nonzero(at))
        if not MIN_REPEATS <= count < heights.size:
            continue
        low, high = _range_without(heights, at)
        away = low - value if sign > 0 else value - high
        if away > FAR * (high - low) and np.unique(heights[~at][:1000]).size >= MIN_DISTINCT:
            return value, count, away
    return None


def _range_without(heights: Floats, at: NDArray[np.bool_]) -> tuple[float, float]:
    kept = ~at
    return (float(np.min(heights, where=kept, initial=np.inf)), float(np.max(heights, where=kept, initial=-np.inf)))


def _whole_numbers(scan: Scan) -> Iterator[str]:
    """Find heights that are all whole numbers of a µm or more."""
    if scan.factor < 1 or not scan.from_text:
        return
    first = scan.heights.flat[:MIN_POINTS] / scan.factor
    if not np.array_equal(first[~np.isnan(first)], np.round(first[~np.isnan(first)])):
        return
    numbers = scan.known / scan.factor
    if numbers.size >= MIN_POINTS and np.ptp(numbers) >= MIN_DISTINCT and np.array_equal(numbers, np.round(numbers)):
        yield f"all heights are whole numbers of {with_unit(scan.factor, 'µm')}, as counts of a converter are"


def _sizes(scan: Scan) -> Iterator[str]:
    """Find scans of metres, and spacings below an ångström."""
    for axis, points, step in zip("xy", scan.heights.shape[::-1], scan.spacing[::-1], strict=False):
        if points * step >= MAX_EXTENT:
            yield f"the scan is {points * step / 1e6:.3g} m long along {axis}"
        elif step >= MAX_SPACING:
            yield f"points are {with_unit(step, 'µm')} apart along {axis}"
        if step < MIN_SPACING:
            yield f"points are {step * 1e6:.3g} pm apart along {axis}, less than an atom"


def _tall(scan: Scan) -> Iterator[str]:
    """Find heights that span more than the scan is long."""
    longest = max(points * step for points, step in zip(scan.heights.shape, scan.spacing, strict=True))
    if scan.span > longest:
        yield f"heights span {with_unit(scan.span, 'µm')} over a scan of {with_unit(longest, 'µm')}"


CHECKS = (
    Check("repeated-extreme", _repeated_extremes, "--missing-value {} takes them for missing points"),
    Check("whole-numbers", _whole_numbers, "multiply counts by their height first; see the header and the manual"),
    Check("size", _sizes, "check the unit of the spacing, --unit and --spacing"),
    Check("tall", _tall, "check the units of heights and spacing, --unit and --spacing"),
)
"""Checks of all scans, by name."""

OF_FILES = ("x3p-increment", "numbering", "truncated", "first-number", "unit-not-needed", "spacing", "points", "scale")
"""Names of the doubts that readers of files have besides."""

CAVEATS = (*(check.name for check in CHECKS), *OF_FILES)
