"""Height step to which an instrument or a file format rounds the heights of a scan."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats

# Tolerance of equal height differences, as a fraction of the height range. Single-precision round-off is smaller.
_EQUAL_DIFFERENCE_TOLERANCE = 1e-6
_MIN_REPETITIONS_OF_ROUNDED_DIFFERENCE = 5
_MIN_FRACTION_OF_REPEATED_DIFFERENCES = 0.5
_MIN_FRACTION_OF_MULTIPLES, _MULTIPLE_TOLERANCE_IN_STEPS = 0.9, 0.05
# A height difference of 0, as in a clipped map, is a multiple of every rounding step.
# At least this fraction of nonzero height differences must be multiples of a rounding step: by chance, 0.1 of them are.
_MIN_FRACTION_OF_NONZERO_MULTIPLES = 0.5
# A rounding step is accepted only if the heights have at least four levels.
_MAX_STEP_TO_HEIGHT_RANGE_RATIO = 1 / 3 + 1e-6


def find_height_step(heights: Floats) -> float:
    """Find the step (µm) to which the heights of a scan are rounded.

    Returns 0 if the heights are not rounded.

    The step is also found if a line, a plane or a parabola was subtracted after the rounding.

    Parameters
    ----------
    heights : (n,) or (rows, columns) ndarray of float, µm
        NaN at missing points.

    Returns
    -------
    step : float, µm
        0 if the heights are not rounded, if they have fewer than four levels, or if the second differences are so much
        larger than the step that rounding does not matter.

    Notes
    -----
    Second differences of rounded heights are multiples of the step, and the differences of one step in both directions
    are frequent. A subtracted parabola changes all second differences along an axis by the same amount, so their median
    is subtracted. Single spikes do not have equal second differences of both signs.
    """
    is_measured = np.isfinite(heights)
    tolerance = _EQUAL_DIFFERENCE_TOLERANCE * float(np.ptp(heights[is_measured])) if is_measured.any() else 0.0
    if not tolerance > 0:
        return 0.0
    differences = np.concatenate([_compute_centred_second_differences(heights, axis) for axis in range(heights.ndim)])
    whole_numbers, repetition_counts = _count_whole_numbers(np.rint(differences / tolerance))
    is_repeated = repetition_counts >= _MIN_REPETITIONS_OF_ROUNDED_DIFFERENCE
    if repetition_counts[is_repeated].sum() <= _MIN_FRACTION_OF_REPEATED_DIFFERENCES * differences.size:
        return 0.0
    positive_numbers, negative_numbers = (
        whole_numbers[is_repeated & (whole_numbers > 0)],
        -whole_numbers[is_repeated & (whole_numbers < 0)],
    )
    has_both_signs = np.isin(
        positive_numbers, np.concatenate([negative_numbers - 1, negative_numbers, negative_numbers + 1])
    )
    if not has_both_signs.any():
        return 0.0
    repeated_number = float(positive_numbers[has_both_signs].min())
    step = float(np.median(differences[np.rint(differences / tolerance) == repeated_number]))
    if step > _MAX_STEP_TO_HEIGHT_RANGE_RATIO * tolerance / _EQUAL_DIFFERENCE_TOLERANCE:
        return 0.0
    multiples = differences / step
    is_multiple = np.abs(multiples - np.rint(multiples)) <= _MULTIPLE_TOLERANCE_IN_STEPS
    is_rounded = (
        is_multiple.mean() >= _MIN_FRACTION_OF_MULTIPLES
        and is_multiple[np.abs(multiples) > _MULTIPLE_TOLERANCE_IN_STEPS].mean() >= _MIN_FRACTION_OF_NONZERO_MULTIPLES
    )
    return step if is_rounded else 0.0


def _count_whole_numbers(numbers: Floats) -> tuple[Floats, NDArray[np.intp]]:
    """Return the distinct whole numbers of an array in ascending order, with the count of each number."""
    lowest_number = numbers.min(initial=0)
    if not numbers.max(initial=0) - lowest_number < numbers.size:
        return np.unique(numbers, return_counts=True)
    counts = np.bincount((numbers - lowest_number).astype(np.intp))
    indices = np.flatnonzero(counts)
    return indices + lowest_number, counts[indices]


def _compute_centred_second_differences(heights: Floats, axis: int) -> Floats:
    """Return the second differences of measured heights along an axis, minus the median of these differences."""
    differences = np.diff(heights, 2, axis=axis)
    differences = differences[np.isfinite(differences)]
    return differences - np.quantile(differences, 0.5, method="lower") if differences.size else differences
