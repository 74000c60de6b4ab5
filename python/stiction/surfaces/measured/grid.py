"""Points x, y, z on a grid as a matrix of heights."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from stiction._checks import Floats
from stiction.surfaces.measured.raw import FormatError

EXACT = 1e-3  # steps by which positions are off a grid that is meant to be exact
OFF_GRID = 0.05  # steps by which a point may be off the grid, beyond its printed digits
MAX_NODES = 4  # nodes of a grid for each point that is listed
MIN_DIGITS = 2.0  # printed digits of a step of positions that are rounded
SPREAD = 1.2  # printed digits over which positions that are rounded scatter about a grid, 1 but for its fitted step
ROUNDED = 4.0  # ratio of gaps between positions, of which the larger are steps and the smaller roundings


def gridded(
    x: Floats, y: Floats, z: Floats, digits: Sequence[Callable[[], Floats] | None]
) -> tuple[Floats, tuple[float, float], str]:
    """Return heights (rows, columns), NaN at nodes that are not listed, spacings (Δy, Δx), and a step of the history.

    Rows are in the order of rising y, columns of rising x. A `FormatError` if the points are on no grid.
    """
    (dx, columns), (dy, rows) = (_axis(name, at, of) for name, at, of in zip("xy", (x, y), digits, strict=True))
    shape = (int(rows.max()) + 1, int(columns.max()) + 1)
    nodes = shape[0] * shape[1]
    if nodes > MAX_NODES * z.size + 10:
        raise FormatError(
            f"lists {z.size} points that are on no grid: it would have {shape[0]} × {shape[1]} nodes; "
            "interpolate them onto one, or export a matrix"
        )
    place = rows * shape[1] + columns
    if np.unique(place).size < place.size:
        twice = int(np.flatnonzero(np.bincount(place, minlength=nodes)[place] > 1)[0])
        raise FormatError(f"lists more than one point at x {x[twice]:g}, y {y[twice]:g}")
    heights = np.full(nodes, np.nan)
    heights[place] = z
    absent = nodes - z.size
    step = f"{z.size} points on a grid of {shape[0]} × {shape[1]}" + (f", {absent} nodes absent" if absent else "")
    return heights.reshape(shape), (dy, dx), step


def _axis(name: str, at: Floats, digits: Callable[[], Floats] | None) -> tuple[float, np.ndarray]:
    """Return the step of a grid along an axis, and the number of the node of each point."""
    if not np.isfinite(at).all():
        raise FormatError(f"lists a point without {name}")
    step = _even_step(at, digits) or step_of(at)
    if step is None:
        raise FormatError(f"lists points of one {name}: they are a profile; choose its columns by columns (--columns)")
    nodes = np.round((at - at.min()) / step)
    count = int(nodes.max())
    step = float(at.max() - at.min()) / count
    off = np.abs(at - at.min() - nodes * step)
    if off.max() > EXACT * step:  # measured: neither end is better known than the rest
        step, first = (float(each) for each in np.polyfit(nodes, at, 1))
        off = np.abs(at - first - nodes * step)
    worst = int(np.argmax(off))
    allowed = OFF_GRID * step
    if off[worst] > allowed and digits is not None:
        allowed += float(np.max(digits()))
    if off[worst] > allowed or (count > 1 and off[worst] > 0.3 * step):
        raise FormatError(
            f"lists points that are on no grid: point {worst}, from 0 on, is at {name} {at[worst]:g}, "
            f"{off[worst] / step:.2g} steps of {step:g} off; interpolate them onto a grid, or export a matrix"
        )
    return step, nodes.astype(np.int64)


def _even_step(at: Floats, digits: Callable[[], Floats] | None) -> float | None:
    """Return the step of a grid of which every node is listed and rounded to printed digits, None if there is none."""
    places = np.unique(at)
    if digits is None or places.size < 3:
        return None
    nodes = np.arange(places.size)
    step = float(np.polyfit(nodes, places, 1)[0])
    digit = float(np.max(digits()))
    is_even = step >= MIN_DIGITS * digit and np.ptp(places - step * nodes) <= SPREAD * digit
    return step if is_even else None


def step_of(at: Floats) -> float | None:
    """Return the step between positions that repeat, each a little off: the median of the gaps that are no rounding."""
    places = np.unique(at)
    gaps = np.diff(places)
    if not gaps.size:
        return None
    # Gaps are steps, multiples of steps where nodes are absent, or much smaller differences of rounding.
    ordered = np.sort(gaps)
    ratios = ordered[1:] / ordered[:-1]
    if ratios.size and ratios.max() > ROUNDED:
        edges = np.flatnonzero(gaps > ordered[int(np.argmax(ratios))]) + 1
        places = np.array([float(each.mean()) for each in np.split(places, edges)])
    return float(np.median(np.diff(places)))
