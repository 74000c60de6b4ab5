"""Uncertain inputs of a measured pair, and the true area of the pair as a function of hardness and E*.

The first members of the pair are also computed at other hardnesses and moduli (nodes). Between the nodes, the area is
interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from dataclasses import dataclass, field
from functools import cached_property, partial
from itertools import product
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.evaluate.load_range import has_only_negligible_loads
from stiction.mechanics.half_space import HalfSpaceCurve, half_space, solve_together_or_separately
from stiction.mechanics.hardness import interpolate_area_per_load
from stiction.mechanics.quantities import QUANTITIES
from stiction.mechanics.resolution import KAPPA_AT_SMALL_LOADS
from stiction.solve.companion_study import TimeAnnouncer
from stiction.solve.member_solution import estimate_solution_time
from stiction.solve.store import AREAS_BY_HARDNESS_FILE, StoredResult, export, read_companion_file
from stiction.study.contact_tables import HalfSpaceSettings
from stiction.study.members import count_grid_points, load_bodies
from stiction.study.stored_values import VariableSpec
from stiction.study.study import Study
from stiction.study.uncertain_inputs import (
    compute_relative_modulus,
    find_creep_exponent,
    find_junction_growth,
    find_uncertain_inputs,
)

if TYPE_CHECKING:
    import xarray

    from stiction.solve.member_sums import MemberSums

NUM_MAP_MEMBERS, NUM_LARGE_MAP_MEMBERS, NUM_PROFILE_MEMBERS = 4, 2, 16
"""Numbers of members that are computed at the nodes, for maps, large maps and profiles."""

MIN_LARGE_MAP_POINTS = 2**19
"""Number of grid points above which a map is large.

Large maps need few members: for 384² points, the areas of members differ by 0.1 % if all contacts yield, and by 2 % if
some contacts yield.
"""

MIN_ERROR_MEMBERS = 2  # minimum number of members from which the error of the interpolated area is estimated

HARDNESS_NODE_POSITIONS_BY_MODULI_COUNT = {
    1: (0.0, 0.15, 0.35, 0.65, 0.85, 1.0),
    3: (0.0, 0.1, 0.25, 0.4, 0.6, 0.75, 0.9, 1.0),
}
"""Positions of the nodes within the range of ln H, as fractions from 0 to 1, for one or three moduli.

The hardness of the study and infinite hardness (elastic bodies) are additional nodes.
"""

MAX_NEGLECTED_MODULUS_HALF_RANGE = 0.2
"""Largest half width of the range of ln E* for which contacts are not computed at other moduli.

The area at another modulus is then derived from the dependence of the area on the load.
"""

# relative difference up to which two nodes count as equal, to allow for round-off
EQUAL_NODE_TOLERANCE = 1e-9

JUNCTION_GROWTH_NODE_SPACING, NUM_JUNCTION_GROWTH_NODES = 0.6, 3
"""Spacing in ln H and number of additional nodes below the hardness range for junction growth.

Below these nodes, all contacts are assumed to be plastic, with an area proportional to 1/H.
"""

NUM_AREA_TABLE_STEPS = 2**15  # number of steps of ln H in a table of areas
# range of a table: below the smallest node by the first factor, and above the largest node by the second factor
AREA_TABLE_MARGIN_FACTORS = 1e3, 4.0

NODE_QUANTILES = (0.005, 0.995)
"""Quantiles of an input that define the outermost nodes."""


# ---- Area as a function of hardness ----------------------------------------------------------------------------------


def choose_hardness_and_modulus_nodes(study: Study) -> tuple[Floats, Floats]:
    """Return the hardnesses H/e (GPa) and the relative moduli e for which true areas are computed.

    A relative modulus is E* divided by the E* in the study. The last hardness is infinite (elastic bodies). There are
    no hardnesses if the hardness and E* are exact or have narrow ranges, and the study has neither dwell times nor
    junction growth.
    """
    inputs, creep, hardness = find_uncertain_inputs(study), find_creep_exponent(study), study.contact.hardness
    # The half width of the range of ln E* is the root sum of squares of the half widths due to each input.
    log_half_widths = [
        np.ptp(np.log(compute_relative_modulus(study, {name: entry.estimate.quantile(NODE_QUANTILES)}))) / 2
        for name, entry in inputs.items()
        if name not in ("mu0", "tau0", "hardness", "junction_growth")
    ]
    half_range = float(np.hypot.reduce([0.0, *log_half_widths]))
    moduli = np.exp([-half_range, 0.0, half_range]) if half_range > MAX_NEGLECTED_MODULUS_HALF_RANGE else np.ones(1)
    if hardness is None:
        return np.array([np.inf] if moduli.size > 1 else []), moduli
    if "hardness" not in inputs and creep is None and moduli.size == 1 and find_junction_growth(study) is None:
        return np.zeros(0), moduli
    hardness_range = (
        inputs["hardness"].estimate.quantile(NODE_QUANTILES) if "hardness" in inputs else np.repeat(float(hardness), 2)
    )
    if creep is not None:
        hardness_factors = np.power.outer([1.0, *study.friction.wait], -creep.quantile(NODE_QUANTILES))
        hardness_range = hardness_range * [hardness_factors.min(), hardness_factors.max()]
    half_width = np.hypot(np.ptp(np.log(hardness_range)) / 2, np.log(moduli[-1]))
    relative_nodes = (
        np.exp(half_width * (2 * np.array(HARDNESS_NODE_POSITIONS_BY_MODULI_COUNT[moduli.size]) - 1))
        if half_width > 0
        else np.ones(0)
    )
    nodes = np.sqrt(hardness_range.prod()) * relative_nodes
    # A node is removed if it differs from the hardness of the study only by round-off.
    nodes = nodes[~np.isclose(nodes, float(hardness), rtol=EQUAL_NODE_TOLERANCE, atol=0.0)]
    nodes = np.unique([*nodes, float(hardness), np.inf])
    return np.unique([*_choose_nodes_for_junction_growth(study, float(nodes[0])), *nodes]), moduli


def _choose_nodes_for_junction_growth(study: Study, min_hardness: float) -> Floats:
    """Return hardness nodes (GPa) below the smallest hardness. Junction growth requires these additional nodes."""
    if find_junction_growth(study) is None:
        return np.zeros(0)
    return np.asarray(
        min_hardness * np.exp(-JUNCTION_GROWTH_NODE_SPACING * np.arange(1, NUM_JUNCTION_GROWTH_NODES + 1))
    )


def compute_areas_at_nodes(study: Study, executor: Executor) -> xarray.Dataset | None:
    """Compute true areas (µm²) of the first members at all nodes and loads. Return None if there are no nodes."""
    import xarray

    hardnesses, moduli = choose_hardness_and_modulus_nodes(study)
    if not hardnesses.size:
        return None
    loads = np.array([float(load) for load in study.friction.load])
    num_members = _choose_num_area_members(study)
    tasks = list(product(range(num_members), moduli.tolist(), hardnesses.tolist()))
    solutions = np.array(list(executor.map(partial(_solve_member_areas, study, loads), tasks)))
    areas = solutions.reshape(num_members, moduli.size, hardnesses.size, -1, loads.size)
    dims = ("repetition", "relative_modulus", "hardness", "load")
    return xarray.Dataset(
        {name: (dims, areas[..., index, :], {"units": "um^2"}) for index, name in enumerate(_list_area_names(study))},
        {
            "hardness": ("hardness", hardnesses, {"units": "GPa", "long_name": "hardness over the relative modulus"}),
            "relative_modulus": ("relative_modulus", moduli, {"units": "1"}),
            "load": ("load", loads, {"units": "mN"}),
        },
        {"title": "true area over hardness and E*"},
    )  # fmt: skip


def count_contact_solutions_at_nodes(study: Study) -> int:
    """Return the number of contact problems that `compute_areas_at_nodes` solves."""
    hardnesses, moduli = choose_hardness_and_modulus_nodes(study)
    return (
        hardnesses.size * moduli.size * _choose_num_area_members(study) * len(study.friction.load)
        if hardnesses.size
        else 0
    )


def _choose_num_area_members(study: Study) -> int:
    num_map_members = NUM_LARGE_MAP_MEMBERS if count_grid_points(study) >= MIN_LARGE_MAP_POINTS else NUM_MAP_MEMBERS
    return min(num_map_members if study.is_areal else NUM_PROFILE_MEMBERS, study.ensemble.repetitions)


def _list_area_names(study: Study) -> tuple[str, ...]:
    """Return the names of the area variables that are computed at each node."""
    return ("contact_area", "opposing_area") if find_junction_growth(study) is not None else ("contact_area",)


def _solve_member_areas(study: Study, loads: Floats, task: tuple[int, float, float]) -> Floats:
    """Compute the true areas (µm²) of a member for one hardness and one modulus, with shape (areas, loads).

    `task` contains the index of the member, the relative modulus, and the hardness divided by the relative modulus.
    With junction growth, the second area is the area of contacts that oppose the motion, weighted by slope factors and
    averaged over directions. Areas are NaN at loads that the member cannot carry.
    """
    index, modulus, hardness_over_modulus = task
    bodies, contact, hardness = load_bodies(study), study.contact, modulus * hardness_over_modulus
    surfaces: Any = study.surfaces
    upper, lower = bodies.member(index, surfaces.reported_cut_off()).pair
    assert isinstance(contact, HalfSpaceSettings), "the mechanics must be half-space"
    modulus *= float(contact.effective_modulus)
    solver_arguments = contact.solver_arguments() | {
        "hardness": hardness if np.isfinite(hardness) else None,
        "effective_modulus": modulus,
    }
    carried_indices = np.flatnonzero(loads < hardness * float(bodies.attributes().nominal_area or 0.0))
    areas = np.full((len(_list_area_names(study)), loads.size), np.nan)
    solver_arguments |= {"direction": contact.direction_angles().tolist()} if study.is_areal and len(areas) > 1 else {}
    for indices, curve in (
        solve_together_or_separately(
            partial(half_space, upper, lower, **solver_arguments, sliding="all"), loads[carried_indices]
        )
        if carried_indices.size
        else ()
    ):
        areas[0, carried_indices[indices]] = curve.contact_area
        if len(areas) > 1:
            areas[1, carried_indices[indices]] = _compute_weighted_opposing_area(curve, is_areal=study.is_areal)
    return areas


def _compute_weighted_opposing_area(curve: HalfSpaceCurve, *, is_areal: bool) -> Floats:
    """Return, for each load, the slope-weighted area (µm²) of the contacts that oppose the motion."""
    opposing_curve = curve.with_sliding("opposing")
    direction_curves = [opposing_curve] if is_areal else [opposing_curve, opposing_curve.with_direction("-x")]
    sums = np.mean([direction.tangential_adhesive for direction in direction_curves], axis=0)
    return np.asarray(sums.reshape(-1, sums.shape[-1]).mean(axis=0))


def load_areas_at_nodes(result: StoredResult) -> xarray.Dataset | None:
    """Load the true areas stored with a result. Return None if they are missing or were computed at other nodes."""
    study = result.study
    hardnesses, moduli = choose_hardness_and_modulus_nodes(study) if study.is_measured else (np.zeros(0), np.ones(1))
    expected_nodes = hardnesses, moduli, np.array([float(load) for load in study.friction.load])
    names = ("hardness", "relative_modulus", "load")
    area_dims = ("repetition", "relative_modulus", "hardness", "load")
    area_bounds = QUANTITIES["contact_area"].stored_bounds
    specs = {name: VariableSpec(dims=(name,), bounds=(0.0, math.inf)) for name in names} | {
        name: VariableSpec(dims=area_dims, bounds=area_bounds, may_be_nan=True) for name in _list_area_names(study)
    }
    stored_dataset = read_companion_file(result.path / AREAS_BY_HARDNESS_FILE, specs) if hardnesses.size else None
    if stored_dataset is None:
        return None
    stored_nodes = [stored_dataset[name].values for name in names]
    is_equal = all(
        first.shape == second.shape and np.allclose(first, second, rtol=1e-9)
        for first, second in zip(stored_nodes, expected_nodes, strict=True)
    )
    return stored_dataset if is_equal else None


_Value = TypeVar("_Value")


@dataclass(frozen=True, eq=False)
class AreasAtNodes:
    """Member-averaged true areas at the loads of the study, for several hardnesses and relative moduli."""

    loads: Floats  # loads of the study (l,), mN
    hardnesses: Floats  # hardnesses divided by relative moduli, H/e, at the nodes (n,), GPa
    moduli: Floats  # relative moduli e at the nodes (m,)
    areas: Floats  # products of relative modulus and area per load, e A/F, at the nodes (l, m, n), 1/GPa
    opposing_areas: Floats | None  # areas per load A/F of contacts that oppose the motion (l, n), 1/GPa
    errors: Floats  # standard errors of the area at each node, relative to the area in the study (l, n)
    tables: dict[Any, TabulatedAreaFunction] = field(
        default_factory=dict
    )  # cached tables of A/F, shared by interpolators

    @classmethod
    def from_result(cls, result: StoredResult) -> AreasAtNodes | None:
        """Load the true areas stored with a result, or return None if none are stored for the current nodes."""
        if (stored_areas := load_areas_at_nodes(result)) is None:
            return None
        means = stored_areas.mean("repetition")
        means = (means * means["relative_modulus"] / means["load"]).transpose("load", "relative_modulus", "hardness")
        moduli, hardness = stored_areas["relative_modulus"].values, result.study.contact.hardness
        return cls(
            stored_areas["load"].values, stored_areas["hardness"].values, moduli, means["contact_area"].values,
            means["opposing_area"].values[:, moduli.size // 2] if "opposing_area" in means else None,
            _estimate_node_errors(stored_areas, None if hardness is None else float(hardness)),
        )  # fmt: skip

    def interpolate_at_loads(self, areas: Floats, loads: Floats) -> Floats:
        """Interpolate areas of shape (loads, ...) with a power law between successive loads of the study.

        Areas are constant outside the loads of the study.
        """
        position = np.interp(np.log(loads), np.log(self.loads), np.arange(self.loads.size))
        lower_indices = np.floor(position).astype(int)
        weight = (position - lower_indices).reshape(-1, *[1] * (areas.ndim - 1))
        # At a load of the study, the areas at the next larger load must not be used, because they may be NaN.
        return np.asarray(areas[lower_indices] ** (1 - weight) * areas[np.ceil(position).astype(int)] ** weight)

    def errors_at_nearest_load(self, loads: Floats) -> Floats:
        """Return the errors at the study load that is nearest to each given load."""
        return np.asarray(self.errors[np.abs(self.loads - loads[:, np.newaxis]).argmin(axis=1)])


def has_areas_at_nodes(result: MemberSums) -> bool:
    """Return whether true areas at several hardnesses or moduli are stored with a result."""
    return result.load_companion(AreasAtNodes.from_result) is not None


def compute_missing_areas(
    result: MemberSums, executor: Executor, *, announce_time: TimeAnnouncer = lambda _: None
) -> None:
    """Compute the true areas at other hardnesses and moduli that a stored result requires, unless they are stored.

    Raises a `ValueError` if files of the bodies are missing.
    """
    folder = result.path
    if folder is None or not lacks_areas_at_nodes(result):
        return
    announce_time(estimate_areas_time(result.study))
    if (areas := compute_areas_at_nodes(result.study, executor)) is not None:
        export(areas, folder / AREAS_BY_HARDNESS_FILE, replace=True)


def estimate_areas_time(study: Study) -> float:
    """Estimate the time (s) that one core needs to compute the areas at other hardnesses and moduli."""
    return count_contact_solutions_at_nodes(study) * estimate_solution_time(study) if study.uses_half_space else 0.0


def lacks_areas_at_nodes(result: MemberSums) -> bool:
    """Return whether a result requires true areas at hardnesses or moduli other than its own, and has none."""
    hardnesses, _ = choose_hardness_and_modulus_nodes(result.study)
    return bool(hardnesses.size) and not has_only_negligible_loads(result) and not has_areas_at_nodes(result)


TablePositions = tuple[NDArray[np.intp], Floats]
"""Index of the table step below each given hardness, and distance of the hardness from this step as a fraction."""


class TabulatedAreaFunction:
    """Function that computes A/F from ln H, for many hardnesses much faster than `interpolate_area_per_load`.

    Areas at many hardnesses are interpolated linearly in a table of A/F with `NUM_AREA_TABLE_STEPS` equal steps of ln
    H, with a relative error below 1e-5. Areas at few hardnesses, or outside the table, are computed exactly.
    """

    def __init__(self, nodes: Floats, at_nodes: Floats, elastic: Floats) -> None:
        self._arguments = nodes, at_nodes, elastic
        # limits of ln H in the table
        self.limits = (
            math.log(nodes[0] / AREA_TABLE_MARGIN_FACTORS[0]),
            math.log(nodes[-1] * AREA_TABLE_MARGIN_FACTORS[1]),
        )

    @cached_property
    def _area_per_load_table(self) -> tuple[Floats, Floats]:
        """Values of A/F at equal steps of ln H, and the differences between successive values."""
        areas = interpolate_area_per_load(np.exp(np.linspace(*self.limits, NUM_AREA_TABLE_STEPS + 1)), *self._arguments)
        return areas, np.diff(areas, axis=-1)

    def __call__(self, log_hardness: Floats, table_positions: TablePositions | None) -> Floats:
        """Return A/F (1/GPa), with shape (..., h), for logarithms of hardnesses (GPa), with shape (h,).

        `table_positions` is the result of `find_table_positions` for the limits of the table.
        """
        if table_positions is None:
            return interpolate_area_per_load(np.exp(log_hardness), *self._arguments)
        (step_indices, fractions), (areas, differences) = table_positions, self._area_per_load_table
        return np.asarray(areas.take(step_indices, axis=-1) + differences.take(step_indices, axis=-1) * fractions)


def find_table_positions(log_hardness: Floats, first: float, last: float) -> TablePositions | None:
    """Find the positions of values of ln H in a table with equal steps of ln H from `first` to `last`.

    The result is None if a hardness is outside the table, or if the hardnesses are too few to justify a table.
    """
    is_large = log_hardness.size > NUM_AREA_TABLE_STEPS // 8
    if not (is_large and first < log_hardness.min() and log_hardness.max() < last):
        return None
    position = (log_hardness - first) * (NUM_AREA_TABLE_STEPS / (last - first))
    step_indices = position.astype(np.intp)
    return step_indices, position - step_indices


@dataclass(frozen=True)
class AreaInterpolator:
    """Interpolator for the true area at each load as a function of hardness and E*.

    By similarity, the solution at (F, E*, H) equals the solution at (F/e, E*/e, H/e). If e is the ratio of E* to the E*
    in the study, the second solution has the E* of the study, but another load and hardness. A is the true area, and F
    is the load.
    """

    hardness: float | None  # hardness of the study (GPa), or None for elastic bodies
    node_hardnesses: Floats  # hardnesses divided by relative moduli, H/e, at the nodes (n,), GPa
    node_areas: Floats  # products of relative modulus and area per load, e A/F, at the nodes (loads, m, n), 1/GPa
    elastic_areas: Floats  # products of relative modulus and area per load, e A/F, for elastic bodies (loads, m), 1/GPa
    moduli: Floats  # relative moduli e at the nodes (m,)
    growth: Floats  # logarithmic derivatives d ln(A/F) / d ln F (loads,)
    errors: Floats  # standard errors of the area at each node, relative to the area in the study (loads, n)
    pressures: Floats  # nominal pressures (loads,), GPa
    opposing_areas: Floats | None = None  # areas per load A/F of contacts that oppose the motion (loads, n)
    tables: dict[Any, TabulatedAreaFunction] = field(default_factory=dict)  # cached tables of A/F, see `_sheared_area`
    # inputs and values stored by `get_or_compute`
    cache: dict[Any, tuple[tuple[Any, ...], Any]] = field(default_factory=dict)

    @classmethod
    def from_result(
        cls, loads: Floats, ratio: Floats, gradient: float, growth: Floats, study: Study, result: MemberSums
    ) -> AreaInterpolator:
        """Create an interpolator for a result. Areas that are stored with the result are used if available.

        Parameters
        ----------
        loads : (l,) array of float, mN
        ratio : (l,) array of float, 1/GPa
            Mean true area divided by the load.
        gradient : float
            Rms gradient of the gap.
        growth : (l,) array of float
            d ln(A/F) / d ln F.
        study : Study
        result : Result
        """
        own_hardness = None if study.contact.hardness is None else float(study.contact.hardness)
        pressures = loads / float(result.head["nominal_area"])
        areas_at_nodes = result.load_companion(AreasAtNodes.from_result)
        # With junction growth, the friction at all loads depends on the areas at the nodes.
        has_growth = bool(study.contact.junction_growth)
        if areas_at_nodes is not None and (has_growth or set(loads.tolist()) <= set(areas_at_nodes.loads.tolist())):
            areas, hardnesses = (
                areas_at_nodes.interpolate_at_loads(areas_at_nodes.areas, loads),
                areas_at_nodes.hardnesses,
            )
            is_carried = np.asarray(np.isfinite(areas).all(axis=(0, 1)))
            if is_carried[-1] and (own_hardness is None or is_carried.sum() > 1):
                is_finite = is_carried & np.isfinite(hardnesses)
                opposing_areas = areas_at_nodes.opposing_areas
                if opposing_areas is not None:
                    opposing_areas = areas_at_nodes.interpolate_at_loads(opposing_areas[:, is_finite], loads)
                return cls(
                    own_hardness, hardnesses[is_finite], areas[..., is_finite], areas[..., -1], areas_at_nodes.moduli,
                    growth if areas_at_nodes.moduli.size == 1 else np.zeros(loads.size),
                    areas_at_nodes.errors_at_nearest_load(loads)[:, is_finite], pressures, opposing_areas,
                    areas_at_nodes.tables,
                )  # fmt: skip
        elastic_ratio = ratio[:, np.newaxis]
        if own_hardness is None:
            no_areas = np.zeros((loads.size, 0))
            return cls(
                None, np.zeros(0), no_areas[:, np.newaxis], elastic_ratio, np.ones(1), growth, no_areas, pressures
            )
        # Without nodes, the model `interpolate_area_per_load` is scaled to the area at the hardness of the study.
        # Surfaces that fit perfectly are in complete contact under any load.
        elastic_areas = (
            np.full((loads.size, 1), KAPPA_AT_SMALL_LOADS / (float(study.contact.effective_modulus) * gradient))
            if gradient > 0
            else 1 / pressures[:, np.newaxis]
        )
        no_areas = np.zeros((loads.size, 1))
        return cls(
            own_hardness,
            np.array([own_hardness]),
            elastic_ratio[..., np.newaxis],
            elastic_areas,
            np.ones(1),
            growth,
            no_areas,
            pressures,
        )

    def area_ratio(self, load: int, hardness: Floats | None, modulus: Floats | float) -> Floats:
        """Return the area for given hardnesses (GPa) and relative moduli, divided by the area for the central inputs.

        Both areas are true contact areas at the same load.
        """
        if hardness is None or self.hardness is None:
            areas, study_areas = self.elastic_areas[load][:, np.newaxis], self.elastic_areas[load][:, np.newaxis]
        else:
            table = self.node_hardnesses, self.node_areas[load], self.elastic_areas[load]
            ratio = np.asarray(hardness / modulus)
            areas = interpolate_area_per_load(ratio.ravel(), *table).reshape(-1, *(ratio.shape or (1,)))
            own_hardness = np.array([self.hardness])
            study_areas = self.get_or_compute(
                ("own", load), (), lambda: interpolate_area_per_load(own_hardness, *table)
            )
        modulus_factor = np.power(modulus, -(1.0 + self.growth[load]))
        return np.asarray(
            modulus_factor
            * _interpolate_between_moduli(areas, self.moduli, modulus)
            / study_areas[self.moduli.size // 2]
        )

    def area_ratio_error(self, load: int, hardness: Floats) -> Floats:
        """Return the relative standard error of `area_ratio` for given H/e (GPa), where e is the relative modulus."""
        return np.asarray(np.interp(np.log(hardness), np.log(self.node_hardnesses), self.errors[load]))

    def growth_ratio(
        self, load: int, rule: str, hardness: Floats, pressure_under_shear: Floats, modulus: Floats | float = 1.0
    ) -> Floats:
        """Return the ratio of the true contact area at the onset of sliding to the true contact area before shear.

        Parameters
        ----------
        load : int
            Index of the load.
        rule : {"all", "opposing"}
            With "opposing", only contacts that oppose the motion are sheared. The result is then an upper bound,
            because H' is also applied to the other contacts.
        hardness, pressure_under_shear : array of float, GPa
            H, and H' from `hardness_under_shear`; H' is NaN at seizure.
        modulus : array_like of float
            Ratio of E* to the E* in the study.

        Returns
        -------
        array of float
            Infinite at seizure: H' is NaN, or the nominal area cannot carry the load at H'.
        """

        def compute_ratio(pressure: Floats) -> Floats:
            return self._sheared_area(load, rule, pressure, modulus) / self._area_before_shear(
                load, rule, hardness, modulus
            )

        # if the interface seizes, the lowest pressure is NaN
        min_pressure = self.get_or_compute(
            "lowest", (pressure_under_shear,), lambda: pressure_under_shear.min(initial=np.inf)
        )
        if min_pressure > self.pressures.max():
            return compute_ratio(pressure_under_shear)
        # Where no load is carried, the pressure is replaced by H.
        # The resulting array and its positions in the table are used for all loads.
        replaced_pressure = self.get_or_compute(
            "carrying",
            (pressure_under_shear, hardness),
            lambda: np.where(pressure_under_shear > self.pressures.min(), pressure_under_shear, hardness),
        )
        return np.where(pressure_under_shear > self.pressures[load], compute_ratio(replaced_pressure), np.inf)

    def _sheared_area(self, load: int, rule: str, hardness: Floats, modulus: Floats | float) -> Floats:
        """Return the true area of the contacts under shear, in arbitrary units."""
        key = float(self.pressures[load]), rule, float(self.node_hardnesses[0])
        if key not in self.tables:
            areas, elastic_areas, central_index = self.node_areas[load], self.elastic_areas[load], self.moduli.size // 2
            # `opposing_areas` contains areas only for the E* of the study.
            if rule == "opposing" and self.opposing_areas is not None:
                elastic_areas = (
                    elastic_areas[[central_index]] * self.opposing_areas[load, -1] / areas[central_index, -1]
                )
                areas = self.opposing_areas[[load]]
            self.tables[key] = TabulatedAreaFunction(self.node_hardnesses, areas, elastic_areas)
        area_function = self.tables[key]
        # The result is cached, because calls for consecutive loads and sliding rules pass the same arrays.
        log_hardness = self.get_or_compute("log hardness", (hardness, modulus), lambda: np.log(hardness / modulus))
        table_positions = self.get_or_compute(
            "places",
            (log_hardness, *area_function.limits),
            lambda: find_table_positions(log_hardness.ravel(), *area_function.limits),
        )
        sampled_areas = area_function(log_hardness.ravel(), table_positions).reshape(-1, *log_hardness.shape)
        return _interpolate_between_moduli(sampled_areas, self.moduli, modulus)

    def _area_before_shear(self, load: int, rule: str, hardness: Floats, modulus: Floats | float) -> Floats:
        """Return the true area of the contacts before shear, in the units of `_sheared_area`."""

        def compute_uncached_area() -> Floats:
            return self._sheared_area(load, rule, hardness, modulus)

        # The result is cached, because the same arrays of samples are used for many values of mu0 and tau0.
        return (
            self.get_or_compute(("before", load, rule), (hardness, modulus), compute_uncached_area)
            if hardness.size > 1
            else compute_uncached_area()
        )

    def get_or_compute(self, name: Any, inputs: tuple[Any, ...], compute: Callable[[], _Value]) -> _Value:
        """Return the cached value with the given name. If an input has changed, compute the value again.

        Numbers are compared by value, and arrays by identity.
        """
        if name in self.cache:
            old_inputs, cached_value = self.cache[name]
            if all(map(_are_same_input, old_inputs, inputs)):
                return cached_value  # type: ignore[no-any-return]
        cached_value = compute()
        self.cache[name] = inputs, cached_value
        return cached_value


def _are_same_input(first: Any, second: Any) -> bool:
    """Return whether two inputs are the same object or equal numbers."""
    return first is second or (isinstance(first, float) and isinstance(second, float) and first == second)


def _estimate_node_errors(solved: xarray.Dataset, hardness: float | None) -> Floats:
    """Estimate the relative standard error of the area ratio at each node.

    This ratio is the area at the node divided by the area for the hardness in the study.

    The errors have the shape (loads, n).
    """
    area = solved["contact_area"].sel(relative_modulus=1.0, method="nearest")
    area = area.transpose("load", "hardness", "repetition")
    count = area.sizes["repetition"]
    if hardness is None or count < MIN_ERROR_MEMBERS:
        return np.zeros(area.shape[:2])
    log_area_ratio = np.log((area / area.sel(hardness=hardness, method="nearest")).values)
    return np.asarray(log_area_ratio.std(axis=-1, ddof=1) / np.sqrt(count))


def _interpolate_between_moduli(values: Floats, moduli: Floats, modulus: Floats | float) -> Floats:
    """Interpolate positive values between three moduli with a parabola in ln(value) and ln E*.

    If there is only one modulus, the values are constant.
    """
    if len(values) == 1:
        return np.asarray(values[0])
    log_at_softer, log_at_central, log_at_stiffer = np.log(values)
    position = np.log(modulus) / np.log(moduli[-1])
    return np.asarray(
        np.exp(
            log_at_central
            + position * (log_at_stiffer - log_at_softer) / 2
            + position**2 * (log_at_stiffer + log_at_softer - 2 * log_at_central) / 2
        )
    )
