"""Solution of one member at all loads: forces and areas summed over contacts, contact statistics, single contacts."""

from __future__ import annotations

import contextlib
import functools
import math
import threading
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats, make_read_only
from stiction._errors import NoSolutionError
from stiction.mechanics.candidates import candidates
from stiction.mechanics.contact import contacts
from stiction.mechanics.friction import STATUS_OK, STATUSES
from stiction.mechanics.half_space import (
    STIFFNESS_TO_SOLUTION_TIME_RATIO,
    HalfSpaceCurve,
    half_space,
    solve_at_zero_load,
    solve_together_or_separately,
)
from stiction.mechanics.law import HertzCylinder, parse_contact_law
from stiction.mechanics.load_curve import LoadCurve, press
from stiction.mechanics.loading import SurfacePair, find_approaches_at_loads
from stiction.mechanics.mindlin import punch_stiffness
from stiction.mechanics.model import ContactModel, ShearDirection
from stiction.mechanics.quantities import (
    ADHESION_QUANTITIES,
    AREAL_SUM_QUANTITIES,
    DIRECTED_SUM_QUANTITIES,
    GAP_QUANTITIES,
    HALF_SPACE_SUM_QUANTITIES,
    ONSET_QUANTITIES,
    QUANTITIES,
    QUANTITIES_SUMMED_AT_ZERO_LOAD,
    STIFFNESS_PER_AREA_FACTOR,
    SUM_QUANTITIES,
)
from stiction.mechanics.solution_record import SolutionRecord
from stiction.solve.contact_statistics import (
    QUANTILE_PROBABILITIES,
    ContactList,
    PairSlopeStatistics,
    compute_patch_statistics,
    compute_steep_contact_load_fraction,
    tabulate_asperity_contacts,
    tabulate_contact_patches,
)
from stiction.solve.layout import ArraysByName, list_variable_names, variable_specs
from stiction.study.contact_settings import AsperityModelSettings, CommonContactSettings, HalfSpaceSettings
from stiction.study.members import (
    MAX_BATCH_BYTES,
    count_grid_points,
    fill_profile_family,
    generate_profile_pairs,
    generate_unscaled_surface,
    get_first_pair,
    read_measured_bodies,
    scale_surface_to_amplitude,
)
from stiction.study.study import Study
from stiction.surfaces.pairing import SIDES
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

HALF_WIDTH_OF_STIFFNESS_FINITE_DIFFERENCE = 0.02
"""Half width of the central difference that gives the normal stiffness of asperities, as a fraction of the approach."""

APPROACH_DISTANCE_ACROSS_LOAD_JUMP = 1e-11
"""Distance between the approaches just before and just after a jump in the load, as a fraction of the approach.

The distance exceeds the tolerance of `find_approaches_at_loads`.
"""


NUM_UNLOADING_MEMBERS, NUM_UNLOADING_CUTOFFS = 4, 2
"""Numbers of members, and of cutoffs per member, for which the unloading stiffness of yielding maps is computed.

For lines, the unloading stiffness of all members is computed, because it differs more between members and takes less
time.
"""

NUM_ELASTIC_MAP_MEMBERS, NUM_ELASTIC_LARGE_MAP_MEMBERS, NUM_ELASTIC_PROFILE_MEMBERS = 4, 2, 16
"""Numbers of members for which the elastic area of yielding bodies is also computed: for maps, large maps and profiles.
"""

MIN_LARGE_MAP_POINTS = 2**19
"""Minimum number of grid points of a large map.

Large maps need few members: for 384² points, the areas of members differ by 0.1 % if all contacts yield, and by 2 % if
some contacts yield.
"""


def solve_at_loads(
    study: Study, upper: Profile | Surface, lower: Profile | Surface, *, record: SolutionRecord | None = None,
    computes_unloading: bool = False, computes_elastic_area: bool = False,
) -> ArraysByName:  # fmt: skip
    """Solve the contact of two bodies at a study's loads. Return sums of forces and areas, and contact statistics.

    Only measured bodies have contact statistics. Arrays that depend on the motion have the shape (rules, directions,
    loads); all others have the shape (loads,). At loads for which the solver fails, values are NaN and the number of
    contacts is 0. Computing the unloading stiffness takes about a third of the time. The elastic area of yielding
    bodies needs a second solution at each load.
    """
    contact = study.contact
    num_loads, motion_shape = (
        contact.loading_steps().size,
        (len(contact.sliding_rules()), contact.direction_angles().size),
    )
    values = {
        name: _build_unsolved_values(name, motion_shape, num_loads)
        for name in list_variable_names(study)
        if name not in GAP_QUANTITIES
    }
    slopes = PairSlopeStatistics.from_pair(upper, lower) if study.is_measured else None
    if isinstance(contact, HalfSpaceSettings):
        _solve_half_space(contact, upper, lower, values, slopes, record, computes_unloading=computes_unloading)
        if computes_elastic_area and "elastic_area" in values:
            solve_elastic = functools.partial(
                half_space, upper, lower, **contact.solver_arguments() | {"hardness": None}, record=record
            )
            for load_indices, curve in solve_together_or_separately(solve_elastic, contact.loading_steps()):
                values["elastic_area"][load_indices] = curve.contact_area
    else:
        _solve_asperities(contact, upper, lower, values, slopes)
    if slopes is not None:
        rms_gradient, rms_slopes = slopes.compute_gap_slopes(contact.direction_angles())
        values |= {"rms_gradient": np.asarray(rms_gradient), "rms_slope": rms_slopes}
    return values


def _build_unsolved_values(name: str, motion_shape: tuple[int, int], num_loads: int) -> NDArray[Any]:
    """Return placeholders for loads without a solution: NaN, the count 0 or the status "not-solved"."""
    sizes = {
        "sliding": motion_shape[0],
        "direction": motion_shape[1],
        "step": num_loads,
        "fraction_below": len(QUANTILE_PROBABILITIES),
    }
    shape = tuple(sizes[dimension] for dimension in QUANTITIES[name].along)
    if name == "status":
        return np.full(shape, STATUSES.index("not-solved"))
    return np.zeros(shape, np.int64) if QUANTITIES[name].dtype is int else np.full(shape, np.nan)


def _list_profile_directions(contact: CommonContactSettings) -> list[ShearDirection]:
    """Return the directions of motion of profiles in a section `[contact]`: "+x", "-x" or both."""
    return ["+x" if math.cos(math.radians(angle)) > 0 else "-x" for angle in contact.direction_angles()]


def _solve_half_space(
    contact: HalfSpaceSettings,
    upper: Any,
    lower: Any,
    values: ArraysByName,
    slopes: PairSlopeStatistics | None,
    record: SolutionRecord | None,
    *,
    computes_unloading: bool,
) -> None:
    """Solve the contact of two bodies at all loads in the half-space model, and write the results to `values`.

    A failure at one load does not affect the other loads.
    """
    is_areal = isinstance(upper, Surface)
    directions: Any = contact.direction_angles().tolist() if is_areal else _list_profile_directions(contact)
    sliding_rules = contact.sliding_rules()
    solve = functools.partial(
        half_space,
        upper,
        lower,
        **contact.solver_arguments(),
        direction=directions if is_areal else "+x",
        sliding=sliding_rules[0],
        record=record,
    )
    sum_names = (*HALF_SPACE_SUM_QUANTITIES, *(ADHESION_QUANTITIES[:1] if contact.adheres else ()))

    for load_indices, curve in solve_together_or_separately(solve, contact.loading_steps()):
        directed_sums = curve.compute_directed_sums(directions, sliding_rules)
        for name in sum_names:
            values[name][..., load_indices] = directed_sums[name] if name in directed_sums else getattr(curve, name)
        if slopes is None:
            continue
        values["status"][load_indices] = STATUSES.index("ok")
        values["normal_stiffness"][load_indices] = curve.stiffness
        values["closure"][load_indices] = curve.closure
        values["closure_stiffness"][load_indices] = curve.closure_stiffness * STIFFNESS_PER_AREA_FACTOR
        if computes_unloading or curve.hardness is None:
            values["unloading_stiffness"][load_indices] = curve.unloading_stiffness
            values["unloading_closure_stiffness"][load_indices] = (
                curve.unloading_closure_stiffness * STIFFNESS_PER_AREA_FACTOR
            )
        values["error"][load_indices] = curve.error
        statistics = compute_patch_statistics([curve.at(index) for index in range(load_indices.size)], slopes)
        for name, statistic in statistics.items():
            values[name][load_indices] = statistic
    if contact.adheres:
        solution_at_no_load = solve_at_zero_load(solve)
        if solution_at_no_load is not None:
            values["pull_off"][...], values["pull_off_is_bound"][...] = solution_at_no_load.pull_off_bound
            directed_sums = solution_at_no_load.compute_directed_sums(directions, sliding_rules)
            for name in QUANTITIES_SUMMED_AT_ZERO_LOAD:
                values[name][...] = directed_sums[QUANTITIES[name].sum_under_load][..., 0]


def _solve_asperities(
    contact: AsperityModelSettings, upper: Any, lower: Any, values: ArraysByName, slopes: Any
) -> None:
    """Solve the contact of two bodies at all loads in the asperity model, and write the results to `values`.

    The loads are elastic loads. With the detection criterion "cell", the load jumps at some approaches. Contact sums at
    a load within a jump are interpolated between the states just before and just after the jump.
    """
    model, is_areal = contact.contact_model(), isinstance(upper, Surface)
    # Two maps have one load curve for all directions of motion; two profiles have one load curve per direction.
    if is_areal:
        models = [replace(model, direction=contact.direction_angles().tolist(), shear="+x").for_surfaces()]
    else:
        models = [
            replace(model, shear=direction, direction=None).for_profiles()
            for direction in _list_profile_directions(contact)
        ]
    first_model = replace(models[0], direction=0.0) if is_areal else models[0]
    # Without friction, the normal load equals the elastic load.
    approach, status = find_approaches_at_loads(
        SurfacePair(upper, lower), contact.loading_steps(), mu0=0.0, tau0=0.0, model=first_model
    )
    values["status"][:] = [STATUSES.index(item) for item in status.tolist()]
    solved_loads = np.flatnonzero(status == STATUS_OK)
    if not solved_loads.size:
        return
    # The load curve can jump only with the detection method `cell`, in which a contact can begin with a load above 0.
    approach_fractions = [
        1 - HALF_WIDTH_OF_STIFFNESS_FINITE_DIFFERENCE,
        1 - APPROACH_DISTANCE_ACROSS_LOAD_JUMP * (first_model.detection == "cell"),
        1,
        1 + HALF_WIDTH_OF_STIFFNESS_FINITE_DIFFERENCE,
    ]
    approaches, index = np.unique(np.outer(approach_fractions, approach[solved_loads]), return_inverse=True)
    lower_index, index_before_jump, load_index, upper_index = index.reshape(len(approach_fractions), solved_loads.size)
    bodies = precompute_candidates(upper, lower, float(approaches[-1]), first_model)
    press_bodies: Any = functools.partial(press, *bodies)
    list_contacts: Any = functools.partial(contacts, *bodies)

    def interpolate_at_jump(name: str, curve: Any) -> Floats:
        elastic_load, sums = curve.normal_elastic, getattr(curve, name)
        load_jump, load_rise = (
            elastic_load[load_index] - elastic_load[index_before_jump],
            contact.loading_steps()[solved_loads] - elastic_load[index_before_jump],
        )
        load_fraction = np.clip(
            np.divide(load_rise, load_jump, out=np.ones(solved_loads.size), where=load_jump > 0), 0, 1
        )
        interpolated = sums[..., index_before_jump] + load_fraction * (
            sums[..., load_index] - sums[..., index_before_jump]
        )
        return np.asarray(np.rint(interpolated) if QUANTITIES[name].dtype is int else interpolated)

    names = [name for name in (*SUM_QUANTITIES, *AREAL_SUM_QUANTITIES) if name in values]
    for rule, sliding in enumerate(contact.sliding_rules()):
        curves: list[Any] = [press_bodies(approaches, model=replace(item, sliding=sliding)) for item in models]
        for name in names:
            if name not in DIRECTED_SUM_QUANTITIES:
                values[name][solved_loads] = interpolate_at_jump(name, curves[0])
            else:
                values[name][rule][..., solved_loads] = np.concatenate(
                    [np.atleast_2d(interpolate_at_jump(name, curve)) for curve in curves]
                )
    is_cylinder = isinstance(parse_contact_law(first_model.law), HertzCylinder)
    elastic_load = curves[0].normal_elastic
    stiffness = (elastic_load[upper_index] - elastic_load[lower_index]) / (
        approaches[upper_index] - approaches[lower_index]
    )
    values["approach"][solved_loads] = values["closure"][solved_loads] = approach[solved_loads]
    values["normal_stiffness"][solved_loads] = stiffness
    values["closure_stiffness"][solved_loads] = stiffness / np.prod(upper.extent) * STIFFNESS_PER_AREA_FACTOR
    for load in solved_loads:
        asperity_contacts = list_contacts(float(approach[load]), model=first_model)
        values["unloading_closure_stiffness"][load] = values["closure_stiffness"][load] if is_cylinder else (
            punch_stiffness(asperity_contacts.axes, float(first_model.effective_modulus)).sum()
            / np.prod(upper.extent) * STIFFNESS_PER_AREA_FACTOR
        )  # fmt: skip
        table = tabulate_asperity_contacts(asperity_contacts, upper)
        for name, value in (table.compute_statistics() | compute_steep_contact_load_fraction(table, slopes)).items():
            values[name][load] = value


def precompute_candidates(upper: Any, lower: Any, max_approach: float, model: ContactModel) -> tuple[Any, ...]:
    """Find all contact candidates of two bodies up to an approach (µm), so that later calls need not search again.

    Returns the candidates, or both bodies unchanged if contacts are not detected as minima of the gap.
    """
    if model.detection != "gap-minimum":
        return upper, lower
    return (candidates(upper, lower, deepest=max_approach, curvature=model.curvature),)


# ---- Contact at a single load ----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class PressedPair:
    """Two bodies in contact at one normal load without friction, with the solution of the contact."""

    upper: Any
    lower: Any
    curve: HalfSpaceCurve | LoadCurve
    model: ContactModel | None = None  # None in the half-space model

    @classmethod
    def solve(cls, study: Study, pair: tuple[Any, Any], load: float) -> PressedPair | None:
        """Solve the contact of two bodies at a normal load (mN), without friction, or return None on failure."""
        upper, lower = pair
        contact = study.contact
        if isinstance(contact, HalfSpaceSettings):
            try:
                curve = half_space(upper, lower, [load], **contact.solver_arguments(), sliding="all")
            except NoSolutionError:
                return None
            return cls(upper, lower, curve)
        model = replace(contact.contact_model(), shear="+x", direction=None, sliding="all")
        model = model.for_profiles() if isinstance(upper, Profile) else replace(model, direction=0.0).for_surfaces()
        approach, status = find_approaches_at_loads(
            SurfacePair(upper, lower), np.array([load]), mu0=0.0, tau0=0.0, model=model
        )
        if status[0] != STATUS_OK:
            return None
        bodies: Any = precompute_candidates(upper, lower, float(approach[0]), model)
        load_curve: LoadCurve = press(*bodies, approach, model=model)  # type: ignore[call-overload]
        return cls(upper, lower, load_curve, model=model)

    def tabulate_contacts(self) -> ContactList:
        """Return the list of single contacts between both bodies: load, area, position and slope of each contact."""
        if isinstance(self.curve, HalfSpaceCurve):
            return tabulate_contact_patches(self.curve.at(0))
        assert self.model is not None
        contacts_at_approach = contacts(self.upper, self.lower, float(self.curve.approach[0]), model=self.model)
        return tabulate_asperity_contacts(contacts_at_approach, self.lower)


# ---- Members of a study ----------------------------------------------------------------------------------------------

CACHE_LINE_BYTES = 64  # bytes
TANGENTIAL_LOAD_FRACTION_OF_STORED_SLIP = 0.5

MEMBER_TIME_COEFFICIENTS = {
    "onset": 1e-3, "generation": 1.45e-7, "profile": 6.6e-9, "asperities": 3e-8, "point": 1.35e-7, "area": 2e-3,
    "line": 3.6e-4, "half-space": 1e-3, "half-plane": 8e-4,
}  # fmt: skip
"""Approximate computing times (s) on one core, from which the number of members in a block is determined.

"onset" is the time of one onset of sliding. "profile", "asperities" and "point" are times per grid point of generated
profiles, of generated maps, and of measured maps with the asperity model. "generation" is the additional time per grid
point in which profiles are generated for all cells together. "area" and "line" are times per load of asperities on
measured maps and lines. "half-space" and "half-plane" are times per load in addition to the time of the solution.
"""

SOLUTION_TIME_COEFFICIENTS = {False: (6e-8, 1.25), True: (5e-8, 1.15)}
"""Power law of the time (s) of a half-space solution on one core: coefficient, and exponent of the point count.

The keys are False for lines and True for periodic maps. The time includes the stiffness.
"""

TIME_FACTOR_OF_NONPERIODIC_MAPS = 2.0
"""Factor by which half-space solutions of non-periodic maps take longer, because of their padded transforms.

With 384² and 768² points, the factor was 2.1 and 2.6. The power law, this factor and the number of iterations give
0.09, 0.5, 3.3 and 21 s for one load with 384², 768², 1536² and 3072² points; measured were 0.12, 0.7, 3.3 and 29 s on
a busy host.
"""

MAX_POINTS_WITHIN_CACHE = 2**20

TIME_FACTOR_OF_LARGE_MAPS_IN_TWO_THREADS = 1.8
"""Factor by which solutions of maps above `MAX_POINTS_WITHIN_CACHE` points take longer if two threads compute them.

Two solutions at once share the bandwidth of the memory. With 1536² points, each took nearly twice the time.
"""

ITERATION_TIME_COEFFICIENTS = {False: (2.4e-8, 0.97), True: (1.1e-8, 1.1)}
"""Power law of the time (s) of an iteration with adhesion on one core: coefficient, and exponent of the point count.

The keys are False for lines and True for maps.
"""

ITERATIONS_PER_LOAD = 15
MAX_POINTS_WITHOUT_ITERATION_GROWTH, ITERATION_GROWTH_EXPONENT = 2**18, 0.2
"""Number of grid points above which maps need more iterations without adhesion, and exponent of this number.

Pairs of self-affine maps (H = 0.8) with 384², 768², 1536² and 3072² points needed on average 15, 16, 21 and 29
iterations per load. The fit gives 15, 18, 23 and 31.
"""

STIFFNESS_TIME_FACTOR = 1 + STIFFNESS_TO_SOLUTION_TIME_RATIO
UNLOADING_STIFFNESS_TIME_FRACTION = STIFFNESS_TO_SOLUTION_TIME_RATIO / STIFFNESS_TIME_FACTOR
ELASTIC_AREA_TIME_FRACTION = 1.2 / STIFFNESS_TIME_FACTOR
"""Times of the unloading stiffness and of the elastic area, as fractions of the time of solution and stiffness.

With 512² to 1536² points, the elastic area took 1.0 to 1.3 times the time of the solution with a hardness, because its
contact has smaller patches.
"""

# Maximum number of adhesion iterations for profiles (False) and maps (True), including steps of minimizations.
MAX_ADHESION_ITERATIONS = {False: 10_700, True: 3100}
ADHESION_ITERATIONS_AT_UNIT_ELASTICITY_RATIO = {False: 100_000, True: 5000}
"""Number of iterations for the adhesion of a gap with E* Sq Sdq / (4 w) = 1, for lines (False) and maps (True).

The factors were fitted to 62 pairs with 64 to 256² points. The number is inversely proportional to this ratio, up to a
maximum. Bodies near complete contact need the most iterations: 1600 to 2500 with 256² points, and 3100 with 512². They
take the time of as many iterations on the full grid: a step of an energy minimization takes about twice the time of an
iteration, but almost half of the iterations take place on coarser grids.
"""

_reusable_arrays = threading.local()


def compute_member_arrays(study: Study, index: int, record: SolutionRecord | None = None) -> ArraysByName:
    """Compute all variables of one member at all loading steps, as arrays without an axis for members.

    The half-space model reports its iterations and its finished loads to the record.

    Measured bodies also have the `MEMBER_COORDINATE_TYPES`. Values are NaN at loads for which the solver fails. Raises
    a `ValueError` if the bodies cannot be loaded.
    """
    arrays: ArraysByName = {
        name: np.empty(shape, dtype) for name, (shape, dtype) in get_array_shapes_and_types(study).items()
    }
    for cell_index, cell_arrays in (
        _solve_measured_member(study, index, arrays, record)
        if study.is_measured
        else _solve_generated_member(study, index, record)
    ):
        for name, values in cell_arrays.items():
            arrays[name][cell_index] = values.reshape(arrays[name][cell_index].shape)
    return arrays


@functools.lru_cache(maxsize=4)
def get_array_shapes_and_types(study: Study) -> dict[str, tuple[tuple[int, ...], np.dtype[Any]]]:
    """Return shape and data type of each variable of one member, keyed by the variable's name."""
    num_cell_dims = len(study.surfaces.cell_coordinates())
    return {
        name: ((*spec.shape[:num_cell_dims], *spec.shape[num_cell_dims + 1 :]), spec.dtype)
        for name, spec in variable_specs(study, [0]).items()
    }


def estimate_member_time(study: Study, member: int | None = None) -> float:
    """Estimate the time (s) on one core to compute one member of a study.

    `member` is the index of the member. Without an index, the time is that of most members, for which neither the
    elastic area of yielding bodies nor the unloading stiffness of yielding maps is computed.
    """
    num_cells = math.prod(values.size for values in study.surfaces.cell_coordinates().values())
    num_loads = study.contact.loading_steps().size
    num_points, is_areal = count_grid_points(study), study.is_areal
    if study.uses_half_space and study.contact.adheres:
        return num_cells * (
            (num_loads + 1) * estimate_solution_time(study)
            + _estimate_adhesion_iterations(study) * _estimate_iteration_time(study)
        )
    if study.uses_half_space:
        additional_solver_time = _estimate_additional_work(study, member) * _estimate_solver_time(study)
        return num_loads * (num_cells * estimate_solution_time(study) + additional_solver_time)
    if study.is_measured:
        return num_cells * (
            MEMBER_TIME_COEFFICIENTS["area"] * num_loads + MEMBER_TIME_COEFFICIENTS["point"] * num_points
            if is_areal
            else MEMBER_TIME_COEFFICIENTS["line"] * num_loads
        )
    onset_time = num_cells * num_loads * MEMBER_TIME_COEFFICIENTS["onset"] if study.contact.onset else 0.0
    time_per_point = (
        num_cells * MEMBER_TIME_COEFFICIENTS["asperities"]
        if is_areal
        else MEMBER_TIME_COEFFICIENTS["generation"] + num_cells * MEMBER_TIME_COEFFICIENTS["profile"]
    )
    return num_points * time_per_point + onset_time + 1e-4


def sum_over_members(
    estimate: Callable[[Study, int | None], float], study: Study, member_ranges: Iterable[range]
) -> float:
    """Sum an estimate, such as computing time or solver iterations, over all members in several index ranges."""
    value_of_most_members, total = estimate(study, None), 0.0
    early_members = _find_members_with_additional_work(study)
    for members in member_ranges:
        overlap = range(members.start, min(members.stop, early_members.stop))
        total += len(members) * value_of_most_members
        total += sum(estimate(study, member) - value_of_most_members for member in overlap)
    return total


def estimate_thread_time_factor(study: Study) -> float:
    """Estimate the factor by which the computing time of a member grows if other threads compute as well.

    The factor was measured without adhesion.
    """
    is_map_without_adhesion = study.uses_half_space and study.is_areal and not study.contact.adheres
    is_large_map = is_map_without_adhesion and count_grid_points(study) > MAX_POINTS_WITHIN_CACHE
    return TIME_FACTOR_OF_LARGE_MAPS_IN_TWO_THREADS if is_large_map else 1.0


def estimate_member_iterations(study: Study, member: int | None = None) -> float:
    """Estimate the total number of solver iterations for all loads of one member in the half-space model.

    Without adhesion, the number includes the iterations by which `HalfSpaceCurve` counts stiffnesses. `member` is the
    index of the member as in `estimate_member_time`.
    """
    num_cells = math.prod(values.size for values in study.surfaces.cell_coordinates().values())
    num_loads = study.contact.loading_steps().size
    if not study.contact.adheres:
        num_solutions = num_loads * (num_cells + _estimate_additional_work(study, member))
        stiffness_factor = STIFFNESS_TIME_FACTOR if study.is_measured else 1.0
        return num_solutions * stiffness_factor * ITERATIONS_PER_LOAD * _estimate_iteration_growth(study)
    return num_cells * ((num_loads + 1) * ITERATIONS_PER_LOAD + _estimate_adhesion_iterations(study))


def _estimate_iteration_growth(study: Study) -> float:
    """Estimate the ratio of the solver iterations of a contact without adhesion to `ITERATIONS_PER_LOAD`."""
    if not study.is_areal:
        return 1.0
    return math.pow(max(1.0, count_grid_points(study) / MAX_POINTS_WITHOUT_ITERATION_GROWTH), ITERATION_GROWTH_EXPONENT)


def _estimate_additional_work(study: Study, member: int | None) -> float:
    """Estimate the work for a member's elastic area and unloading stiffness, as a number of contact solutions per load.

    For lines, the time of a solution includes the unloading stiffness, which all members have.
    """
    if member is None or member not in _find_members_with_additional_work(study):
        return 0.0
    num_cells = math.prod(values.size for values in study.surfaces.cell_coordinates().values())
    has_elastic_area = "elastic_area" in list_variable_names(study) and member in find_elastic_members(study)
    work = ELASTIC_AREA_TIME_FRACTION * num_cells if has_elastic_area else 0.0
    if study.is_areal and member - study.surfaces.first_scan_member_index < NUM_UNLOADING_MEMBERS:
        work += UNLOADING_STIFFNESS_TIME_FRACTION * min(num_cells, NUM_UNLOADING_CUTOFFS)
    return work


def _find_members_with_additional_work(study: Study) -> range:
    """Return an index range that contains all members whose elastic area or unloading stiffness must be computed.

    The range may contain other members.
    """
    if not (study.is_measured and study.uses_half_space) or study.contact.hardness is None:
        return range(0)
    num_unloading_members = study.surfaces.first_scan_member_index + NUM_UNLOADING_MEMBERS if study.is_areal else 0
    return range(max(find_elastic_members(study).stop, num_unloading_members))


def _estimate_adhesion_iterations(study: Study) -> float:
    """Estimate how many iterations adhesion adds by slower convergence and by the search for the pull-off force."""
    factor = ADHESION_ITERATIONS_AT_UNIT_ELASTICITY_RATIO[study.is_areal]
    min_ratio = factor / MAX_ADHESION_ITERATIONS[study.is_areal]
    return factor / max(_estimate_elasticity_to_adhesion_ratio(study), min_ratio)


def estimate_solution_time(study: Study) -> float:
    """Estimate the time (s) on one core of a half-space solution at one load."""
    is_areal = study.is_areal
    additional_time = MEMBER_TIME_COEFFICIENTS["half-space" if is_areal else "half-plane"]
    if study.contact.adheres:
        return additional_time + ITERATIONS_PER_LOAD * _estimate_iteration_time(study)
    return additional_time + _estimate_solver_time(study)


def _estimate_solver_time(study: Study) -> float:
    """Estimate the time (s) on one core to solve one load without adhesion and to compute the stiffness."""
    is_areal = study.is_areal
    coefficient, exponent = SOLUTION_TIME_COEFFICIENTS[is_areal]
    num_points = count_grid_points(study)
    is_free_map = is_areal and isinstance(study.contact, HalfSpaceSettings) and study.contact.boundary == "free"
    factor = TIME_FACTOR_OF_NONPERIODIC_MAPS if is_free_map else 1.0
    return factor * _estimate_iteration_growth(study) * coefficient * math.pow(num_points, exponent)


def _estimate_iteration_time(study: Study) -> float:
    coefficient, exponent = ITERATION_TIME_COEFFICIENTS[study.is_areal]
    return coefficient * math.pow(count_grid_points(study), exponent)


@functools.lru_cache(maxsize=16)
def _estimate_elasticity_to_adhesion_ratio(study: Study) -> float:
    """Estimate the ratio of elastic energy to work of adhesion, E* Sq Sdq / (4 w), for the first member's gap.

    By the Cauchy-Schwarz inequality, this ratio is at least the elastic energy per area of complete contact, divided by
    w. Returns 0 if files are missing.
    """
    contact, gap = study.contact, np.zeros((0, 0))
    with contextlib.suppress(ValueError, OSError):
        upper, lower = get_first_pair(study)
        gap = np.asarray(upper.heights - lower.heights)
    if not gap.size:
        return 0.0
    spacings = np.broadcast_to(upper.spacing, gap.ndim)
    slopes = [np.diff(gap, axis=axis) / spacing for axis, spacing in enumerate(spacings)]
    gradient = math.sqrt(sum(float(np.mean(np.square(slope))) for slope in slopes))
    return float(contact.effective_modulus) * float(gap.std()) * gradient / (4 * float(contact.work_of_adhesion or 0))


# ---- Generated bodies ------------------------------------------------------------------------------------------------


def _solve_generated_member(
    study: Study, repetition: int, record: SolutionRecord | None
) -> Iterator[tuple[Any, ArraysByName]]:
    """Compute forces and areas of a generated member, summed over contacts, at each fractal dimension and amplitude.

    Yields the indices of one or several cells with their contact sums.
    """
    if not (study.is_areal or study.uses_half_space or study.contact.onset):
        yield from _solve_profile_batches(study, repetition)
        return
    press_pair = functools.partial(solve_at_loads, record=record) if study.uses_half_space else _solve_at_approaches
    cells: Any = study.surfaces.cell_coordinates()
    dimensions, amplitudes = cells["fractal_dimension"], cells["amplitude"]
    if not study.is_areal:
        for a, amplitude in enumerate(amplitudes):
            for d, pair in enumerate(generate_profile_pairs(study, repetition, dimensions, amplitude)):
                yield (d, a), press_pair(study, *pair)
        return
    for d, dimension in enumerate(dimensions):
        upper, lower = (generate_unscaled_surface(study, repetition, side, dimension) for side in SIDES)
        for a, amplitude in enumerate(amplitudes):
            yield (
                (d, a),
                press_pair(study, *(scale_surface_to_amplitude(study, body, amplitude) for body in (upper, lower))),
            )


def _solve_at_approaches(study: Study, upper: Profile | Surface, lower: Profile | Surface) -> ArraysByName:
    """Compute forces and areas, summed over the contacts of two bodies in the asperity model, at each approach."""
    steps, models = _list_loading_steps(study.contact), _list_contact_models(study.contact)
    bodies: Any = upper, lower
    if isinstance(upper, Surface):
        models = tuple(model.for_surfaces() for model in models)
        bodies = (candidates(upper, lower, deepest=float(steps[-1]), curvature=models[0].curvature),)
    curves: list[Any] = [press(*bodies, steps, model=model) for model in models]  # type: ignore[call-overload]
    sums = {
        name: np.stack([getattr(curve, name) for curve in curves])
        if name in DIRECTED_SUM_QUANTITIES
        else getattr(curves[0], name)
        for name in study.contact_sum_names()
        if name not in ONSET_QUANTITIES
    }
    return sums | _compute_onsets(study, curves[0]) if study.contact.onset else sums


def _compute_onsets(study: Study, curve: LoadCurve) -> ArraysByName:
    """Compute the tangential stiffness, the displacement at sliding and the slipped load fraction at each approach.

    The bodies move in the first direction of the section `[contact]`.
    """
    contact = study.contact
    assert isinstance(contact, AsperityModelSettings)
    assert contact.onset is not None
    onsets = {name: np.zeros(curve.approach.size) for name in ONSET_QUANTITIES}
    for index in np.flatnonzero(curve.normal_elastic > 0).tolist():
        onset = curve.onset(
            index, mu0=contact.onset.mu0, tau0=float(contact.onset.tau0), direction=contact.directions_of_motion()[0],
            steps=[TANGENTIAL_LOAD_FRACTION_OF_STORED_SLIP], poisson=contact.onset.poisson_ratio,
        )  # fmt: skip
        onset_quantities = (onset.stiffness, onset.displacement_at_sliding, float(onset.slipped_load[0]))
        for name, value in zip(ONSET_QUANTITIES, onset_quantities, strict=True):
            onsets[name][index] = value
    return onsets


@functools.lru_cache(maxsize=4)
def _list_contact_models(contact: Any) -> tuple[ContactModel, ...]:
    return tuple(contact.contact_model(rule) for rule in contact.sliding_rules())


@functools.lru_cache(maxsize=4)
def _list_loading_steps(contact: Any) -> Floats:
    return make_read_only(contact.loading_steps())


def _solve_profile_batches(study: Study, repetition: int) -> Iterator[tuple[slice, ArraysByName]]:
    """Compute forces and areas, summed over contacts, of generated profiles in the asperity model, batch by batch.

    Each batch contains several fractal dimensions.

    Yields the range of fractal dimensions in a batch, with contact sums as arrays of the shape (fractal dimensions,
    amplitudes, sliding rules, steps). Quantities that do not depend on the motion have a single sliding rule.
    """
    surfaces: Any = study.surfaces
    steps, models = _list_loading_steps(study.contact), _list_contact_models(study.contact)
    dimensions, amplitudes = surfaces.fractal_dimensions(), surfaces.amplitudes()
    batch_size = min(dimensions.size, max(1, MAX_BATCH_BYTES // (8 * surfaces.points)))
    height_buffer = _get_reused_array((2 * batch_size + 2, surfaces.points))
    for batch_start in range(0, dimensions.size, batch_size):
        batch_dimensions = dimensions[batch_start : batch_start + batch_size]
        upper_heights, lower_heights = (
            height_buffer[: batch_dimensions.size],
            height_buffer[batch_size : batch_size + batch_dimensions.size],
        )
        columns = _core.press_profile_batches(
            upper_heights, fill_profile_family(study, upper_heights, batch_dimensions, repetition, "upper"),
            lower_heights, fill_profile_family(study, lower_heights, batch_dimensions, repetition, "lower"),
            spacing=surfaces.spacing, amplitudes=amplitudes, measure=surfaces.amplitude_measure, approaches=steps,
            scratch=height_buffer[-2:],
            models=[model.for_profiles().core() for model in models],
        )  # fmt: skip
        shape = batch_dimensions.size, amplitudes.size, len(models), steps.size
        sums_by_name = {name: columns[name].reshape(shape) for name in study.contact_sum_names()}
        yield (
            slice(batch_start, batch_start + batch_dimensions.size),
            {name: sums if name in DIRECTED_SUM_QUANTITIES else sums[:, :, :1] for name, sums in sums_by_name.items()},
        )


def _get_reused_array(shape: tuple[int, ...]) -> Floats:
    """Return an uninitialised array that a thread reuses in all its tasks, to save the time of allocation.

    The array is aligned to cache lines of the processor, so that vector writes do not cross cache lines.
    """
    reusable_array: Floats | None = getattr(_reusable_arrays, "memory", None)
    if reusable_array is None or reusable_array.shape != shape:
        buffer = np.empty(math.prod(shape) + CACHE_LINE_BYTES // 8)
        offset = -buffer.__array_interface__["data"][0] % CACHE_LINE_BYTES // 8
        _reusable_arrays.memory = reusable_array = buffer[offset : offset + math.prod(shape)].reshape(shape)
    return reusable_array


# ---- Measured bodies -------------------------------------------------------------------------------------------------


def _solve_measured_member(
    study: Study, index: int, arrays: ArraysByName, record: SolutionRecord | None
) -> Iterator[tuple[int, ArraysByName]]:
    """Compute contact statistics and sums of forces and areas of one measured member at each cutoff.

    Yields the index of each cutoff with its contact sums. Writes the coordinates of the member to `arrays`.
    """
    is_early = index - study.surfaces.first_scan_member_index < NUM_UNLOADING_MEMBERS
    computes_unloading = is_early or not study.is_areal
    computes_elastic_area = index in find_elastic_members(study)
    bodies = read_measured_bodies(study)
    for cell_index, wavelength in enumerate(study.surfaces.cell_coordinates()["cut_off"]):
        member = bodies.member(index, float(wavelength))
        arrays |= {name: np.asarray(getattr(member, name)) for name in ("x", "y", "line", "surrogate")}
        yield (
            cell_index,
            solve_at_loads(
                study,
                *member.pair,
                record=record,
                computes_unloading=computes_unloading and cell_index < NUM_UNLOADING_CUTOFFS,
                computes_elastic_area=computes_elastic_area,
            ),
        )


def find_elastic_members(study: Study) -> range:
    """Return the indices of the members that are solved again without yielding, to compute their elastic area."""
    count = NUM_ELASTIC_PROFILE_MEMBERS
    if study.is_areal:
        is_large = count_grid_points(study) >= MIN_LARGE_MAP_POINTS
        count = NUM_ELASTIC_LARGE_MAP_MEMBERS if is_large else NUM_ELASTIC_MAP_MEMBERS
    first_index: int = study.surfaces.first_scan_member_index
    first_index = first_index if first_index < study.ensemble.repetitions else 0
    return range(first_index, first_index + count)
