"""Statistics of the contacts between two bodies: sizes, pressures, positions and slopes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats
from stiction.mechanics.contact import Contacts
from stiction.mechanics.patches import grid_slopes
from stiction.surfaces.profile import Profile, combine_missing_masks
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.mechanics.half_space_problem import ContactSolution

STEEP_POINT_FRACTION = 0.1

QUANTILE_PROBABILITIES = tuple(round(0.05 * step, 2) for step in range(1, 20))
"""Probabilities of the stored quantiles of contact areas and contact pressures. The pressures are weighted by area."""

MAX_CELLS_OF_SMALL_CONTACT = 4


@dataclass(frozen=True, eq=False)
class PairSlopeStatistics:
    """Slope statistics of two bodies: their steepest points, limits of steepness, and mean square slopes of the gap."""

    steep_masks: dict[str, NDArray[np.bool_]]
    steepness_limits: dict[str, float]
    gap_mean_squares: list[float]  # along y and x, or along x
    # Mean product of the gap's slopes along y and along x; 0 for profiles.
    gap_mean_product: float

    @classmethod
    def from_pair(cls, upper: Profile | Surface, lower: Profile | Surface) -> PairSlopeStatistics:
        """Compute slope statistics of two bodies on the same grid. Slopes are those of natural cubic splines.

        Large arrays are overwritten instead of allocated, because the operating system clears new memory.
        """
        slopes_by_side = {side: compute_slopes(body) for side, body in (("upper", upper), ("lower", lower))}
        missing_mask = combine_missing_masks(upper, lower)
        is_measured = ... if missing_mask is None else ~missing_mask
        magnitude, buffer = np.empty(upper.heights.shape), np.empty(upper.heights.shape)
        steepness_limits, steep_masks = {}, {}
        for side, slopes in slopes_by_side.items():
            np.square(slopes[0], out=magnitude)
            for slope in slopes[1:]:
                magnitude += np.square(slope, out=buffer)
            np.sqrt(magnitude, out=magnitude)
            np.copyto(buffer, magnitude)
            steepness_limits[side] = float(
                np.quantile(buffer[is_measured], 1 - STEEP_POINT_FRACTION, overwrite_input=True)
            )
            steep_masks[side] = magnitude > steepness_limits[side]
        gap_slopes = [
            np.subtract(above, below, out=above) for above, below in zip(*slopes_by_side.values(), strict=True)
        ]
        del slopes_by_side, slopes, magnitude
        if missing_mask is not None:
            gap_slopes, buffer = [slope[is_measured] for slope in gap_slopes], buffer[is_measured]
        mean_squares = [float(np.square(slope, out=buffer).mean()) for slope in gap_slopes]
        mean_product = (
            float(np.multiply(gap_slopes[0], gap_slopes[1], out=buffer).mean()) if len(gap_slopes) == 2 else 0.0
        )
        return cls(steep_masks, steepness_limits, mean_squares, mean_product)

    def compute_gap_slopes(self, angles: Floats) -> tuple[float, Floats]:
        """Return the gap's rms gradient, and its rms slope along each direction (degrees from +x towards +y)."""
        mean_squares = self.gap_mean_squares
        if len(mean_squares) == 1:
            return float(np.sqrt(mean_squares[0])), np.full(angles.size, np.sqrt(mean_squares[0]))
        radians = np.radians(angles)
        mean_squares_by_direction = (
            mean_squares[1] * np.cos(radians) ** 2
            + mean_squares[0] * np.sin(radians) ** 2
            + self.gap_mean_product * np.sin(2 * radians)
        )
        return float(np.sqrt(sum(mean_squares))), np.sqrt(np.maximum(mean_squares_by_direction, 0.0))


def compute_slopes(body: Profile | Surface) -> list[Floats]:
    """Compute the slopes of a body at all grid points, along y and x (maps) or along x (profiles)."""
    return grid_slopes(body.heights, body.spacings, periodic=False)


@dataclass(frozen=True, eq=False)
class ContactList:
    """Arrays with one item per contact between two bodies at one load, and the distribution of contact pressure."""

    # Pressure-weighted mean position of each contact (µm). For profiles, y and the slope along y are 0.
    x: Floats
    y: Floats
    force: Floats  # mN
    area: Floats  # projected, µm²
    # Mean slopes of each contact along x and y. A contact opposes motion in a direction of positive slope.
    slope_x: Floats
    slope_y: Floats
    # Number of grid cells that each contact covers. It need not be a whole number if the contact is an asperity.
    cells: Floats
    at_edge: NDArray[np.bool_]
    # Contact pressures (GPa), and for each pressure a weight proportional to the area on which it acts.
    pressure: Floats
    weight: Floats

    def compute_statistics(self) -> dict[str, Any]:
        """Compute the contact statistics that a result stores, such as quantiles of contact area and pressure."""
        statistics = _core.contact_statistics(
            self.force, self.area, self.cells, self.at_edge, self.pressure, self.weight,
            probabilities=np.array(QUANTILE_PROBABILITIES), max_small_cells=MAX_CELLS_OF_SMALL_CONTACT,
        )  # fmt: skip
        return {name: values[0] for name, values in statistics.items()}


def compute_patch_statistics(
    solutions: Sequence[ContactSolution], slopes: PairSlopeStatistics
) -> dict[str, NDArray[np.float64]]:
    """Compute the contact statistics of a result from half-space solutions, as arrays with one row per load.

    Load fractions on the steepest points are on the steepest 10 % of the grid points of each body.
    """
    problem, contacts = solutions[0].problem, [solution.arrays for solution in solutions]
    statistics: dict[str, NDArray[np.float64]] = _core.patch_statistics(
        contacts, shape=problem.gap.shape, spacing=problem.spacing, probabilities=np.array(QUANTILE_PROBABILITIES),
        max_small_cells=MAX_CELLS_OF_SMALL_CONTACT,
    )  # fmt: skip
    return statistics | {
        f"share_on_steepest_{side}": _core.load_fractions_on_marked_points(contacts, is_steep)
        for side, is_steep in slopes.steep_masks.items()
    }


def tabulate_contact_patches(solution: ContactSolution) -> ContactList:
    """Return the contact patches of a half-space solution, with the load, area, position and slope of each patch."""
    problem, pressure, patch_index = solution.problem, solution.values, solution.patch - 1
    pressure_sums = np.bincount(patch_index, weights=pressure)

    def average_in_each_patch(values: Floats) -> Floats:
        return np.asarray(np.bincount(patch_index, weights=pressure * values) / pressure_sums, np.float64)

    indices = np.unravel_index(solution.points, problem.gap.shape)
    positions = [(index * step).astype(np.float64) for index, step in zip(indices, problem.spacing, strict=True)]
    slope_components = [slope[solution.points] for slope in problem.interface_slopes]
    zeros = np.zeros(pressure.size)
    is_at_edge = np.zeros(pressure.size, dtype=bool)
    for index, size in zip(indices, problem.gap.shape, strict=True):
        is_at_edge |= (index == 0) | (index == size - 1)
    return ContactList(
        x=average_in_each_patch(positions[-1]), y=average_in_each_patch(positions[0] if len(positions) == 2 else zeros),
        force=np.asarray(problem.cell_area * pressure_sums, np.float64),
        area=np.asarray(problem.cell_area * np.bincount(patch_index, weights=solution.share), np.float64),
        slope_x=average_in_each_patch(slope_components[-1]),
        slope_y=average_in_each_patch(slope_components[0] if len(slope_components) == 2 else zeros),
        cells=np.bincount(patch_index).astype(np.float64),
        at_edge=np.bincount(patch_index, weights=is_at_edge) > 0, pressure=pressure, weight=np.ones(pressure.size),
    )  # fmt: skip


def tabulate_asperity_contacts(contacts: Contacts, body: Profile | Surface) -> ContactList:
    """Return the contacts of the asperity model, with the load, area, position and slope of each contact."""
    spacing, extent = body.spacings, np.atleast_1d(body.extent)
    normals = contacts.normal
    contact_slopes = -normals[:, :2] / normals[:, 2:]
    x, y = contacts.centre[:, 0], contacts.centre[:, 1]
    half_width = contacts.axes[:, 0]
    if len(spacing) == 1:
        width_in_cells = 2 * half_width / spacing[0]
        at_edge = (x - half_width < 0) | (x + half_width > extent[0])
    else:
        width_in_cells = contacts.area / float(np.prod(spacing))
        at_edge = (
            (x - half_width < 0) | (x + half_width > extent[1]) | (y - half_width < 0) | (y + half_width > extent[0])
        )
    return ContactList(
        x=x, y=y if len(spacing) == 2 else np.zeros(x.size), force=contacts.force * normals[:, 2], area=contacts.area,
        slope_x=contact_slopes[:, 0], slope_y=contact_slopes[:, 1] if len(spacing) == 2 else np.zeros(x.size),
        cells=width_in_cells,
        at_edge=at_edge, pressure=contacts.force / contacts.area, weight=contacts.area,
    )  # fmt: skip


def compute_steep_contact_load_fraction(table: ContactList, slopes: PairSlopeStatistics) -> dict[str, float]:
    """Return, for each body, the load fraction on contacts that are steeper than 90 % of the body's grid points."""
    magnitude = np.hypot(table.slope_x, table.slope_y)
    total_load = table.force.sum()
    return {
        f"share_on_steepest_{side}": float(table.force[magnitude > limit].sum() / total_load)
        for side, limit in slopes.steepness_limits.items()
    }


def compute_sample_quantiles(values: Floats, probabilities: Sequence[float]) -> Floats:
    """Compute quantiles along the first axis of an array, ignoring NaN.

    The quantiles equal those of `numpy.nanquantile`, which loops over columns and takes ten times as long.
    """
    sorted_values, last_index = np.sort(values, axis=0), np.maximum((~np.isnan(values)).sum(axis=0) - 1, 0)
    position = np.multiply.outer(np.array(probabilities), last_index)
    lower_indices = position.astype(np.intp)
    value_below, value_above = (
        np.take_along_axis(sorted_values, index, axis=0)
        for index in (lower_indices, np.minimum(lower_indices + 1, last_index))
    )
    weight = position - lower_indices
    return np.asarray(
        np.where(
            weight < 0.5,
            value_below + (value_above - value_below) * weight,
            value_above - (value_above - value_below) * (1 - weight),
        )
    )
