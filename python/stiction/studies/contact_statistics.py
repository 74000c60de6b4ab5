"""Statistics of the contacts of one pair of bodies: their sizes, pressures, places, and the slopes that they lie on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.mechanics.contact import Contacts
from stiction.surfaces.profile import Profile, combine_missing
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.mechanics.half_space_problem import ContactSolution

STEEPEST = 0.1  # the fraction of a body whose slopes are its steepest

QUANTILES = tuple(round(0.05 * step, 2) for step in range(1, 20))
"""Quantiles of the areas of contacts, and of the pressures over the true area, that are kept."""

SMALL = 4  # grid cells of the largest contact that a scan hardly resolves


@dataclass(frozen=True, eq=False)
class Slopes:
    """Slopes of a pair at every point of its grid, along (y and) x."""

    upper: list[Floats]
    lower: list[Floats]
    steep: dict[str, NDArray[np.bool_]]  # where each body is steepest, as a mask
    limits: dict[str, float]  # the slope from which on it is
    measured: Any = ...  # points that were measured in both

    @classmethod
    def of(cls, upper: Profile | Surface, lower: Profile | Surface) -> Slopes:
        """Those of a pair on one grid, by natural cubic splines."""
        along = {side: slopes_of(body) for side, body in (("upper", upper), ("lower", lower))}
        magnitude = {side: np.sqrt(sum(np.square(each) for each in values)) for side, values in along.items()}
        missing = combine_missing(upper, lower)
        measured = ... if missing is None else ~missing
        limits = {side: float(np.quantile(each[measured], 1 - STEEPEST)) for side, each in magnitude.items()}
        steep = {side: magnitude[side] > limit for side, limit in limits.items()}
        return cls(along["upper"], along["lower"], steep, limits, measured)

    def of_gap(self, angles: Floats) -> tuple[float, Floats]:
        """Root-mean-square gradient of the gap, and its root-mean-square slope along directions (degrees)."""
        gap = [(above - below)[self.measured] for above, below in zip(self.upper, self.lower, strict=True)]
        squares = [float(np.square(each).mean()) for each in gap]
        if len(gap) == 1:
            return float(np.sqrt(squares[0])), np.full(angles.size, np.sqrt(squares[0]))
        radians = np.radians(angles)
        along = (
            squares[1] * np.cos(radians) ** 2
            + squares[0] * np.sin(radians) ** 2
            + float((gap[0] * gap[1]).mean()) * np.sin(2 * radians)
        )
        return float(np.sqrt(sum(squares))), np.sqrt(np.maximum(along, 0.0))


def slopes_of(body: Profile | Surface) -> list[Floats]:
    """Slopes at every point, along (y and) x."""
    from stiction.mechanics.patches import slopes

    return slopes(body.heights, body.spacings, periodic=False)


@dataclass(frozen=True, eq=False)
class Table:
    """The contacts of a pair at one load, one row each, and the pressures over the true area; lengths in µm."""

    x: Floats  # middle, weighted with the pressure; y is 0 of profiles
    y: Floats
    force: Floats  # mN
    area: Floats  # on the ground plan
    slope_x: Floats  # mean slope; a contact opposes the directions in which it rises
    slope_y: Floats
    cells: Floats  # how many cells of the grid it covers
    at_edge: NDArray[np.bool_]  # whether it reaches the edge of the grid
    pressure: Floats  # (p,), GPa
    weight: Floats  # (p,), how much of the true area each pressure stands for

    def statistics(self) -> dict[str, Any]:
        """What a result keeps of them: fractions of the load, and quantiles of areas and pressures."""
        order = np.argsort(self.pressure, kind="stable")
        below = np.cumsum(self.weight[order])
        return {name: of_table(self) for name, of_table in OF_CONTACTS.items()} | {
            "patch_area": _quantiles(self.area),
            "pressure": np.interp(
                QUANTILES, (below - self.weight[order] / 2) / below[-1], self.pressure[order]
            ),
        }  # fmt: skip


def _quantiles(values: Floats) -> Floats:
    """What `numpy.quantile` gives at `QUANTILES`, in a tenth of its time for a few values."""
    ordered, place = np.sort(values), np.array(QUANTILES) * (values.size - 1)
    below = place.astype(np.intp)
    low, high, part = ordered[below], ordered[np.minimum(below + 1, values.size - 1)], place - below
    return np.where(part < 0.5, low + (high - low) * part, high - (high - low) * (1 - part))


OF_CONTACTS: dict[str, Callable[[Table], float]] = {
    "share_on_largest": lambda table: table.force.max() / table.force.sum(),
    "share_at_edge": lambda table: table.force[table.at_edge].sum() / table.force.sum(),
    "fraction_on_small": lambda table: table.force[table.cells <= SMALL].sum() / table.force.sum(),
}
"""Formulas of the statistics of the contacts of a member at a load, by their names in `QUANTITIES`."""


def patches_of(pressed: ContactSolution) -> Table:
    """The patches of a half-space contact."""
    problem, pressure, patch = pressed.problem, pressed.values, pressed.patch - 1
    total = np.bincount(patch, weights=pressure)

    def mean(values: Floats) -> Floats:
        return np.asarray(np.bincount(patch, weights=pressure * values) / total, np.float64)

    indices = np.unravel_index(pressed.points, problem.gap.shape)
    places = [(index * step).astype(np.float64) for index, step in zip(indices, problem.spacing, strict=True)]
    along = [each[pressed.points] for each in problem.slope]
    nothing = np.zeros(pressure.size)
    edge = np.zeros(pressure.size, dtype=bool)
    for index, size in zip(indices, problem.gap.shape, strict=True):
        edge |= (index == 0) | (index == size - 1)
    return Table(
        x=mean(places[-1]), y=mean(places[0] if len(places) == 2 else nothing),
        force=np.asarray(problem.cell * total, np.float64),
        area=np.asarray(problem.cell * np.bincount(patch, weights=pressed.share), np.float64), slope_x=mean(along[-1]),
        slope_y=mean(along[0] if len(along) == 2 else nothing), cells=np.bincount(patch).astype(np.float64),
        at_edge=np.bincount(patch, weights=edge) > 0, pressure=pressure, weight=np.ones(pressure.size),
    )  # fmt: skip


def asperities_of(touching: Contacts, body: Profile | Surface) -> Table:
    """The contacts of the asperity model, on one of both bodies, which have one grid."""
    spacing, extent = body.spacings, np.atleast_1d(body.extent)
    normal = touching.normal
    steep = -normal[:, :2] / normal[:, 2:]
    x, y = touching.centre[:, 0], touching.centre[:, 1]
    half = touching.axes[:, 0]
    if len(spacing) == 1:
        cells = 2 * half / spacing[0]
        at_edge = (x - half < 0) | (x + half > extent[0])
    else:
        cells = touching.area / float(np.prod(spacing))
        at_edge = (x - half < 0) | (x + half > extent[1]) | (y - half < 0) | (y + half > extent[0])
    return Table(
        x=x, y=y if len(spacing) == 2 else np.zeros(x.size), force=touching.force * normal[:, 2], area=touching.area,
        slope_x=steep[:, 0], slope_y=steep[:, 1] if len(spacing) == 2 else np.zeros(x.size), cells=cells,
        at_edge=at_edge, pressure=touching.force / touching.area, weight=touching.area,
    )  # fmt: skip


def on_steepest(table: Table, found: Slopes) -> dict[str, float]:
    """The fraction of the load on the steepest tenth of each body, contact by contact."""
    magnitude = np.hypot(table.slope_x, table.slope_y)
    total = table.force.sum()
    return {
        f"share_on_steepest_{side}": float(table.force[magnitude > limit].sum() / total)
        for side, limit in found.limits.items()
    }


def pressed_on_steepest(pressed: ContactSolution, found: Slopes) -> dict[str, float]:
    """The same, point by point of a half-space."""
    total = pressed.values.sum()
    return {
        f"share_on_steepest_{side}": float(pressed.values[mask.ravel()[pressed.points]].sum() / total)
        for side, mask in found.steep.items()
    }
