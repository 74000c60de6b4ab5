"""Direct shear test: contacts of two faces while the upper face is displaced in steps.

Each step is a half-space contact. The normal load is constant, or rises with the dilation at a constant stiffness.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_instance
from stiction._errors import ArgumentError, NoSolutionError
from stiction.mechanics.friction import (
    LOAD_SUM_NAMES,
    NEGLIGIBLE_COEFFICIENT,
    STATUS_DOWNHILL,
    STATUS_DTYPE,
    STATUS_NO_CONTACT,
    STATUS_NOT_REACHED,
    STATUS_NOT_SOLVED,
    STATUS_OK,
    STATUS_SELF_LOCKED,
    FrictionLaw,
    Status,
)
from stiction.mechanics.half_space import BoundaryCondition, HalfSpaceCurve, TiltMode, half_space
from stiction.mechanics.half_space_problem import solver_thread_count
from stiction.mechanics.model import ContactModel
from stiction.mechanics.patches import grid_slopes, patch_sums
from stiction.mechanics.quantities import STIFFNESS_PER_AREA_FACTOR, STIFFNESS_PER_AREA_UNIT, quantity_attributes
from stiction.mechanics.solution_record import SolutionRecord, StepResult
from stiction.surfaces.profile import Profile, combine_missing_masks, select_from_mask
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray as xr

MIN_OVERLAP_POINTS = 16
"""Minimum number of grid points along each axis in the overlap of the faces at the end of the path."""

MIN_STRIP_POINTS, MIN_STRIPS, MAX_STRIPS = 32, 4, 8
"""Minimum width of a strip in points; minimum and maximum number of strips into which faces are cut by default."""

MIN_STRIP_AREA_FRACTION = 0.5

NORMAL_LOAD_TOLERANCE = 1e-4
"""Accepted deviation of the normal load from its target, as a fraction of the initial load."""

MAX_SOLUTIONS_PER_DISPLACEMENT = 40
MAX_RATIO_OF_SUCCESSIVE_TRIAL_LOADS = 4.0
# The faces of a joint count as locked if the elastic load exceeds this multiple of the required normal load.
MAX_ELASTIC_TO_REQUIRED_LOAD_RATIO = 100.0
# The faces of a joint count as separated if the elastic load is below this fraction of the initial load.
MIN_ELASTIC_TO_INITIAL_LOAD_RATIO = 1e-4

MAX_ROUND_OFF_GAP_VARIATION = 1e-9
"""Largest variation of a gap that is attributed to round-off, as a fraction of the height of the face."""

NUM_CLOSURE_LOADS = 8
MAX_TO_MIN_CLOSURE_LOAD_RATIO = 50.0

CLOSURE_NAMES = "closure", "closure_stiffness"
"""Names of the quantities of a shear test over the normal stress at the start of the path."""

_STEP_QUANTITIES = (
    *LOAD_SUM_NAMES, "contact_area", "overlap_area", "contact_count", "load_fraction_at_hardness",
    "load_fraction_at_edges", "height",
    "elastic_energy",
)  # fmt: skip
_DATASET_QUANTITIES = tuple(name for name in _STEP_QUANTITIES if name not in ("contact_area", "height"))
_VARIABLE_ATTRIBUTES: dict[str, dict[str, str]] = {
    "displacement": {"units": "um", "long_name": "displacement of the upper face along the path"},
    "friction_coefficient": {"units": "1", "long_name": "tangential load over normal load, against the motion"},
    "shear_stress": {"units": "GPa", "long_name": "tangential load over the overlap of the faces"},
    "dilation": {"units": "um", "long_name": "rise of the upper face since the start of the path"},
    "contact_area_fraction": {"units": "1", "long_name": "fraction of the overlap that is in contact"},
    "normal_load": {"units": "mN", "long_name": "normal load"},
    "overlap_area": {"units": "um2", "long_name": "overlap of the faces"},
    "contact_count": {"units": "1", "long_name": "number of contact patches"},
    "load_fraction_at_hardness": {"units": "1", "long_name": "fraction of the load at the hardness"},
    "load_fraction_at_edges": {"units": "1", "long_name": "fraction of the load at the edges of the faces"},
    "elastic_energy": {"units": "nJ", "long_name": "elastic energy of the faces"},
    "normal_stress": {"units": "GPa", "long_name": "normal stress on the overlap at the start of the path"},
    "closure": {"units": "um", "long_name": "closure at the start of the path"},
    "closure_stiffness": {"units": STIFFNESS_PER_AREA_UNIT, "long_name": "stiffness of closure at the start"},
    "gap": {"units": "um", "long_name": "gap between the faces at the start, at first contact"},
}


@dataclass(frozen=True, eq=False)
class ShearBox:
    """Direct shear test: two faces, and the load, stiffness and direction of the test.

    Attributes
    ----------
    upper, lower : Profile or Surface
        Faces on the same grid spacing. The upper face has been flipped.
    load : float, mN
        Normal load, or initial normal load with a stiffness.
    stiffness : float, mN/µm
        Increase of the normal load per dilation; 0 for a constant load.
    direction : float, degrees
        Direction of the motion of the upper face, from +x towards +y.
    law : FrictionLaw
        mu0 and tau0 of the contacts.
    """

    upper: Profile | Surface
    lower: Profile | Surface
    load: float
    stiffness: float
    direction: float
    law: FrictionLaw
    effective_modulus: float
    compliance_share: float = 0.5
    hardness: float | None = None
    boundary: BoundaryCondition = "free"
    tilt: TiltMode = "fixed"
    tolerance: float = 1e-6

    @cached_property
    def _motion_vector(self) -> Floats:
        """Unit vector of the motion, in the order of the array axes: y and x, or only x for profiles."""
        angle = math.radians(self.direction)
        vector = np.array([math.sin(angle), math.cos(angle)])[-self.lower.heights.ndim :]
        return np.where(np.abs(vector) < NEGLIGIBLE_COEFFICIENT, 0.0, vector)

    @property
    def initial_overlap_area(self) -> float:
        """Area (µm²) of the initial overlap, without grid points that are missing on one of the faces."""
        return _compute_measured_area(*self.faces_at(np.zeros(self.lower.heights.ndim, np.int64)))

    def choose_offsets(self, path: float, steps: int) -> NDArray[np.int64]:
        """Return the offsets of the upper face along its path, in grid points; array of shape (offsets, axes).

        The offsets are spread evenly over the path (µm) and rounded to grid points, without repetitions.
        """
        num_points = int(np.abs(path * self._motion_vector / self.lower.spacings).sum()) + 1
        displacements = np.linspace(0.0, path, min(steps, num_points) + 1)
        rounded_offsets = np.rint(displacements[:, np.newaxis] * self._motion_vector / self.lower.spacings).astype(
            np.int64
        )
        offsets: NDArray[np.int64] = rounded_offsets[
            np.append(True, np.any(np.diff(rounded_offsets, axis=0) != 0, axis=1))
        ]
        if len(offsets) < 2:
            raise ValueError(f"the sliding path must be at least one grid spacing, got {path:g} µm")
        if self.boundary == "free":
            overlaps = [self._find_overlap(offset) for offset in offsets]
            overlap = min(int(np.min(shape)) for _, _, shape in overlaps)
            if overlap < MIN_OVERLAP_POINTS:
                raise ValueError(
                    f"the sliding path must leave an overlap of at least {MIN_OVERLAP_POINTS} points along each axis, "
                    f"got {path:g} µm, which leaves {max(overlap, 0)} points"
                )
        return offsets

    @property
    def can_have_strips(self) -> bool:
        """True if the faces can be cut into strips, that is, if they are height maps without periodic continuation."""
        return self.lower.heights.ndim > 1 and self.boundary != "periodic"

    def find_max_strips(self, offsets: NDArray[np.int64], min_points: int = MIN_OVERLAP_POINTS) -> int:
        """Return the largest number of strips whose overlaps are at least `min_points` wide.

        Returns 0 if no strip fits.

        Strips move sideways if the motion is oblique to the grid.
        """
        if not self.can_have_strips:
            return 0
        axis = self._strip_axis
        drift = int(np.abs(offsets[:, axis]).max())
        width = min(int(face.heights.shape[axis]) for face in (self.upper, self.lower))
        return width // (min_points + drift)

    @property
    def _strip_axis(self) -> int:
        """Axis across which both faces are cut into strips that run along the motion."""
        return int(np.argmin(np.abs(self._motion_vector)))

    def cut_strips(self, offsets: NDArray[np.int64], count: int | None = None) -> list[ShearBox]:
        """Cut both faces into strips that run along the motion.

        Returns one shear test per strip, with unchanged normal stress.

        By default `MIN_STRIPS` to `MAX_STRIPS` strips, or none if the faces are too narrow. Strips with few measured
        points are left out. `offsets` are the positions of the test.
        """
        if count is None:
            count = min(self.find_max_strips(offsets, MIN_STRIP_POINTS), MAX_STRIPS)
            count = count if count >= MIN_STRIPS else 0
        if count == 0:
            return []
        axis = self._strip_axis
        width = min(face.heights.shape[axis] for face in (self.upper, self.lower))
        edges = np.rint(np.linspace(0, width, count + 1)).astype(int)
        strips = []
        for strip_start, strip_end in itertools.pairwise(map(int, edges)):
            selection = tuple(
                slice(strip_start, strip_end) if grid_axis == axis else slice(None) for grid_axis in range(2)
            )
            faces = self.upper, self.lower
            if any(face.missing is not None and face.missing[selection].all() for face in faces):
                continue
            upper, lower = (_select_face_region(face, selection) for face in faces)
            strip = replace(self, upper=upper, lower=lower)
            area_fraction = strip.initial_overlap_area / self.initial_overlap_area
            if area_fraction >= MIN_STRIP_AREA_FRACTION / count:
                strips.append(replace(strip, load=self.load * area_fraction, stiffness=self.stiffness * area_fraction))
        return strips

    def displacements(self, offsets: NDArray[np.int64]) -> Floats:
        """Convert offsets of the upper face (grid points) to displacements (µm) along the shear path."""
        return np.asarray((offsets * self.lower.spacings) @ self._motion_vector)

    def _find_overlap(self, offset: NDArray[np.int64]) -> tuple[list[int], list[int], list[int]]:
        """Return the first overlapping grid point of each face, upper face first, and the shape of the overlap."""
        lower_start = [max(0, int(step)) for step in offset]
        upper_start = [start - int(step) for start, step in zip(lower_start, offset, strict=True)]
        shape = [
            min(lower - lower_first, upper - upper_first)
            for lower, upper, lower_first, upper_first in zip(
                self.lower.heights.shape, self.upper.heights.shape, lower_start, upper_start, strict=True
            )
        ]
        return upper_start, lower_start, shape

    def faces_at(self, offset: NDArray[np.int64]) -> tuple[Any, Any]:
        """Return the overlapping regions of the upper and the lower face at an offset in grid points."""
        if self.boundary == "periodic":
            axes = tuple(range(offset.size))
            heights = np.roll(self.upper.heights, tuple(map(int, offset)), axes)
            upper = replace(self.upper, heights=heights, history=())
            return upper, replace(self.lower, history=())
        *starts, shape = self._find_overlap(offset)
        upper, lower = (
            _select_face_region(body, _slice_grid_region(start, shape))
            for body, start in zip((self.upper, self.lower), starts, strict=True)
        )
        return upper, lower

    def solve_contact(self, offset: NDArray[np.int64], elastic_loads: ArrayLike) -> HalfSpaceCurve:
        """Solve the contact of the faces at an offset in grid points, under given vertical contact forces (mN)."""
        upper, lower = _close_round_off_gap(*self.faces_at(offset))
        return half_space(
            upper, lower, np.atleast_1d(elastic_loads), effective_modulus=self.effective_modulus,
            compliance_share=self.compliance_share, hardness=self.hardness, boundary=self.boundary, tilt=self.tilt,
            sliding="all", tolerance=self.tolerance,
        )  # fmt: skip

    @cached_property
    def _slopes(self) -> tuple[list[Floats], list[Floats]]:
        """Slopes of the upper and of the lower face along each axis, at all grid points."""
        upper_slopes, lower_slopes = (
            grid_slopes(body.heights, body.spacings, periodic=self.boundary == "periodic")
            for body in (self.upper, self.lower)
        )
        return upper_slopes, lower_slopes

    def _find_edges(self, offset: NDArray[np.int64]) -> Floats:
        """Return an array over the overlap that marks the grid points at the edge of exactly one face.

        A point is 0 at an edge of the upper face only, 1 at an edge of the lower face only, and NaN elsewhere.
        """
        if self.boundary == "periodic":
            return np.full(self.lower.heights.shape, np.nan)
        upper_start, lower_start, shape = self._find_overlap(offset)
        edges = np.full(shape, np.nan)
        for axis, count in enumerate(shape):
            line = np.moveaxis(edges, axis, 0)
            points_before = lower_start[axis] - upper_start[axis]
            points_after = self.lower.heights.shape[axis] - self.upper.heights.shape[axis] - points_before
            for end, lower_excess in ((0, points_before), (count - 1, points_after)):
                if lower_excess != 0:
                    line[end] = 0.0 if lower_excess > 0 else 1.0
        return edges

    def _compute_interface_slopes(self, offset: NDArray[np.int64], tilt: Floats) -> list[Floats]:
        """Return the slopes of the interface between the deformed faces along each axis, at the points of the overlap.

        An edge of a face that touches the other face is pushed along the normal of the other face.
        """
        if self.boundary == "periodic":
            axes = tuple(range(offset.size))
            upper_slopes = [np.roll(slope, tuple(map(int, offset)), axes) for slope in self._slopes[0]]
            lower_slopes = self._slopes[1]
        else:
            *starts, shape = self._find_overlap(offset)
            upper_slopes, lower_slopes = (
                [slope[_slice_grid_region(start, shape)] for slope in slopes]
                for slopes, start in zip(self._slopes, starts, strict=True)
            )
        edges = self._find_edges(offset)
        weight = np.where(np.isnan(edges), self.compliance_share, edges)
        return [
            (1 - weight) * lower + weight * (upper + slope)
            for upper, lower, slope in zip(upper_slopes, lower_slopes, tilt, strict=True)
        ]

    def solve(
        self, offsets: NDArray[np.int64], record: SolutionRecord, progress: Callable[[int, int], object] | None = None
    ) -> list[StepResult]:
        """Solve the contact of the faces at each offset of the upper face, in order.

        If the record stores steps, finished steps are not computed again.
        """
        rows: list[StepResult] = []
        for index, offset in enumerate(offsets):
            if progress is not None:
                progress(index, len(offsets))
            solve_step = partial(self._solve_step, offset, rows[0] if rows else None, rows[-1] if rows else None)
            rows.append(record.run_step(solve_step, NoSolutionError))
        if progress is not None:
            progress(len(offsets), len(offsets))
        return rows

    def _solve_step(
        self, offset: NDArray[np.int64], first_row: StepResult | None, previous_row: StepResult | None
    ) -> StepResult:
        """Solve the contact at an offset of the upper face, so that the normal load with friction equals the target."""
        upper, lower = self.faces_at(offset)
        gap, missing = upper.heights - lower.heights, combine_missing_masks(upper, lower)
        first_contact_height = -float((gap if missing is None else gap[~missing]).min())
        overlap_area = _compute_measured_area(upper, lower)
        max_load = math.inf if self.hardness is None else self.hardness * overlap_area
        rows: list[StepResult] = []
        if self.stiffness and first_row is not None and not math.isfinite(float(first_row["height"])):
            # With a normal stiffness, the load depends on the first step's height; it is unknown if that height is NaN.
            missing_values = dict.fromkeys((*_STEP_QUANTITIES, "elastic_load"), math.nan)
            return missing_values | {"overlap_area": overlap_area, "status": STATUS_NOT_SOLVED}

        def compute_excess_load(elastic_load: float) -> tuple[float, float]:
            """Return the normal load minus the target load, and the target load (both mN).

            `elastic_load` (mN) is the load without friction. The normal load includes vertical forces due to friction.
            """
            curve = self.solve_contact(offset, elastic_load)
            rows.append(self._collect_results(curve, offset, first_contact_height, elastic_load))
            if first_row is None:
                return self._compute_normal_load(rows[-1]) - self.load, self.load
            rise = float(rows[-1]["height"]) - float(first_row["height"])
            target = self.load + (self.stiffness * rise if self.stiffness else 0.0)
            return self._compute_normal_load(rows[-1]) - target, target

        load_guess = self.load if previous_row is None else float(previous_row["elastic_load"])
        load_guess = load_guess if math.isfinite(load_guess) else self.load
        try:
            status = _search_elastic_load(compute_excess_load, load_guess, self.load, max_load)
        except NoSolutionError:
            status = STATUS_NOT_SOLVED
        row = rows[-1] if rows and status == STATUS_OK else dict.fromkeys((*_STEP_QUANTITIES, "elastic_load"), math.nan)
        return row | {"overlap_area": overlap_area, "status": status}

    def _collect_results(
        self, curve: HalfSpaceCurve, offset: NDArray[np.int64], first_contact_height: float, elastic_load: float
    ) -> StepResult:
        """Return the results of one solved step, such as the contact forces and the upper face's height, as a dict."""
        solution = curve.at(0)
        problem, pressure = solution.problem, solution.on_grid(solution.values)
        displacement = problem.grids.displacement(pressure, threads=solver_thread_count())
        slopes = [slope.ravel() for slope in self._compute_interface_slopes(offset, curve.tilt[0])]
        forces, areas = solution.values * problem.cell_area, solution.share * problem.cell_area
        is_at_edge = np.isfinite(self._find_edges(offset)).ravel()[solution.points]
        directions = ContactModel(direction=self.direction).directions()
        sums = patch_sums([solution.arrays], slopes, problem.cell_area, directions)
        return {
            **{name: float(np.squeeze(total)) for name, total in sums.totals("all").items() if name in LOAD_SUM_NAMES},
            "contact_area": float(areas.sum()),
            "contact_count": float(curve.contact_count[0]),
            "load_fraction_at_hardness": float(curve.load_share_at_hardness[0]),
            "load_fraction_at_edges": float(forces[is_at_edge].sum() / forces.sum()),
            "height": first_contact_height - float(curve.closure[0]),
            "elastic_energy": 0.5 * float((pressure * displacement).sum()) * problem.cell_area,
            "elastic_load": elastic_load,
        }

    def _compute_normal_load(self, row: StepResult) -> float:
        return float(self.law.load("normal", row))

    def solve_closure(self, record: SolutionRecord) -> xr.Dataset:
        """Return closure and closure stiffness before shearing, at several stresses up to the initial normal stress.

        The dataset has the dimension `normal_stress` (GPa). All values are NaN if the contact has no solution, and
        values at loads of at least the hardness times the area. The stiffness is also NaN where it is infinite, in full
        contact.
        """
        import xarray as xr

        loads = self.load * np.geomspace(1 / MAX_TO_MIN_CLOSURE_LOAD_RATIO, 1.0, NUM_CLOSURE_LOADS)
        offset = np.zeros(self.lower.heights.ndim, np.int64)

        max_load = math.inf if self.hardness is None else self.hardness * self.initial_overlap_area
        can_be_carried = loads < max_load

        def solve_closures() -> StepResult:
            values = {name: np.full(loads.size, math.nan) for name in CLOSURE_NAMES}
            if can_be_carried.any():
                curve = self.solve_contact(offset, loads[can_be_carried])
                stiffness = curve.closure_stiffness * STIFFNESS_PER_AREA_FACTOR
                values["closure"][can_be_carried] = curve.closure
                values["closure_stiffness"][can_be_carried] = np.where(np.isfinite(stiffness), stiffness, math.nan)
            return dict(values)

        try:
            values = record.run_step(solve_closures, NoSolutionError)
        except NoSolutionError:
            values = dict.fromkeys(CLOSURE_NAMES, np.full(loads.size, math.nan))
        stress = "normal_stress", loads / self.initial_overlap_area, _VARIABLE_ATTRIBUTES["normal_stress"]
        variables = {name: ("normal_stress", values[name], _VARIABLE_ATTRIBUTES[name]) for name in CLOSURE_NAMES}
        return xr.Dataset(variables, {"normal_stress": stress})

    @property
    def initial_gap(self) -> xr.DataArray:
        """Gap (µm) between the faces at the start of the path and at first contact, with NaN at missing points.

        The positions (µm) along `gap_y` and `gap_x` start at the first point of the overlap.
        """
        import xarray as xr

        upper, lower = _close_round_off_gap(*self.faces_at(np.zeros(self.lower.heights.ndim, np.int64)))
        missing = combine_missing_masks(upper, lower)
        gap = upper.heights - lower.heights
        gap = gap if missing is None else np.where(missing, math.nan, gap)
        attributes = {"units": "um", "long_name": "position from the first point of the gap"}
        coordinates = {
            axis: (axis, np.arange(count) * step, attributes)
            for axis, count, step in zip(("gap_y", "gap_x")[-gap.ndim :], gap.shape, lower.spacings, strict=True)
        }
        return xr.DataArray(gap - np.nanmin(gap), coordinates, tuple(coordinates), attrs=_VARIABLE_ATTRIBUTES["gap"])

    def solve_peak_pressure(
        self, test: xr.Dataset, offsets: NDArray[np.int64], rows: list[StepResult], record: SolutionRecord
    ) -> xr.DataArray | None:
        """Return a map of the contact pressure (GPa) at the peak of the shear curve, where friction is largest.

        Returns None without a peak.
        """
        import xarray as xr

        if test.attrs["peak_status"] != STATUS_OK:
            return None
        index = int(np.nanargmax(test["friction_coefficient"].values))

        def solve_pressure() -> StepResult:
            return {
                "pressure": self.solve_contact(offsets[index], float(rows[index]["elastic_load"])).contact(0).pressure
            }

        pressure = record.run_step(solve_pressure, NoSolutionError)["pressure"]
        starts = self._find_overlap(offsets[index])[1] if self.boundary == "free" else [0] * pressure.ndim
        coordinates = {
            axis: (axis, (start + np.arange(count)) * step, {"units": "um", "long_name": "position on the lower face"})
            for axis, start, count, step in zip(
                ("y", "x")[-pressure.ndim :], starts, pressure.shape, self.lower.spacings, strict=True
            )
        }
        attributes = {"units": "GPa", "long_name": "contact pressure at the peak"}
        return xr.DataArray(pressure, coordinates, tuple(coordinates), attrs=attributes)

    def to_dataset(self, offsets: NDArray[np.int64], rows: list[StepResult]) -> xr.Dataset:
        """Return the results of all steps of a shear test as a dataset whose dimension is the shear displacement."""
        import xarray as xr

        columns = {name: np.array([float(row[name]) for row in rows]) for name in _STEP_QUANTITIES}
        normal, tangential = (self.law.load(load, columns) for load in ("normal", "tangential"))
        tangential = np.where(np.abs(tangential) > self.tolerance * normal, tangential, 0.0)
        coefficient, status = tangential / normal, np.array([str(row["status"]) for row in rows], STATUS_DTYPE)
        status[coefficient < 0] = STATUS_DOWNHILL
        variables = {
            "friction_coefficient": np.where(status == STATUS_OK, coefficient, np.nan),
            "shear_stress": tangential / columns["overlap_area"],
            "dilation": columns["height"] - columns["height"][0],
            "contact_area_fraction": columns["contact_area"] / columns["overlap_area"],
            "normal_load": normal,
            **{name: columns[name] for name in _DATASET_QUANTITIES},
        }
        displacement = "displacement", self.displacements(offsets), _VARIABLE_ATTRIBUTES["displacement"]
        dataset = xr.Dataset(
            {
                name: ("displacement", values, _VARIABLE_ATTRIBUTES.get(name) or quantity_attributes(name))
                for name, values in variables.items()
            }
            | {"status": ("displacement", status)},
            {"displacement": displacement},
        )
        return dataset.assign_attrs(summarize_curve(dataset))


def _slice_grid_region(start: list[int], shape: list[int]) -> tuple[slice, ...]:
    return tuple(slice(start_index, start_index + count) for start_index, count in zip(start, shape, strict=True))


def _select_face_region(face: Any, selection: tuple[slice, ...]) -> Any:
    """Cut a range of grid rows and columns out of a face, and return this part as a new face."""
    return replace(face, heights=face.heights[selection], history=(), missing=select_from_mask(face.missing, selection))


def _close_round_off_gap(upper: Any, lower: Any) -> tuple[Any, Any]:
    """Return both faces; if their gap varies only by round-off, the upper face gets the heights of the lower face."""
    missing = combine_missing_masks(upper, lower)
    gap = upper.heights - lower.heights if missing is None else (upper.heights - lower.heights)[~missing]
    if np.ptp(gap) > MAX_ROUND_OFF_GAP_VARIATION * np.ptp(lower.heights):
        return upper, lower
    return replace(upper, heights=lower.heights), lower


def _compute_measured_area(upper: Profile | Surface, lower: Profile | Surface) -> float:
    missing = combine_missing_masks(upper, lower)
    count = lower.heights.size if missing is None else int((~missing).sum())
    return count * math.prod(lower.spacings)


def _search_elastic_load(
    compute_excess_load: Callable[[float], tuple[float, float]], load_guess: float, load: float, max_load: float
) -> Status:
    """Vary the load without friction (mN) until the load with friction reaches its target, and return a status.

    The load without friction is the elastic load. `compute_excess_load` returns the excess of the normal load over its
    target, and the target, at an elastic load (mN). The method is a bracketed secant method. The last call of
    `compute_excess_load` is at the elastic load that was found.
    """
    lower_load_limit, upper_load_limit = 0.0, max_load
    trial_load, last_trial = min(load_guess, 0.9 * max_load), None
    for _ in range(MAX_SOLUTIONS_PER_DISPLACEMENT):
        load_excess, target = compute_excess_load(trial_load)
        if abs(load_excess) <= NORMAL_LOAD_TOLERANCE * load:
            return STATUS_OK
        lower_load_limit, upper_load_limit = (
            (trial_load, upper_load_limit) if load_excess < 0 else (lower_load_limit, trial_load)
        )
        if load_excess < 0 and trial_load > MAX_ELASTIC_TO_REQUIRED_LOAD_RATIO * max(target, load):
            return STATUS_SELF_LOCKED
        if load_excess > 0 and trial_load < MIN_ELASTIC_TO_INITIAL_LOAD_RATIO * load:
            return STATUS_NO_CONTACT
        if lower_load_limit > (1 - NORMAL_LOAD_TOLERANCE) * max_load:
            return STATUS_NOT_REACHED
        # In the first step, the normal load is assumed to be proportional to the elastic load.
        slope = (
            (load_excess + target) / trial_load
            if last_trial is None
            else (load_excess - last_trial[1]) / (trial_load - last_trial[0])
        )
        last_trial = trial_load, load_excess
        step = trial_load - load_excess / slope if slope > 0 else (0.0 if load_excess > 0 else math.inf)
        step = min(
            max(step, trial_load / MAX_RATIO_OF_SUCCESSIVE_TRIAL_LOADS),
            trial_load * MAX_RATIO_OF_SUCCESSIVE_TRIAL_LOADS,
        )
        if not lower_load_limit < step < upper_load_limit:
            step = (trial_load + (upper_load_limit if load_excess < 0 else lower_load_limit)) / 2
        trial_load = step
    return STATUS_NOT_SOLVED


def compute_dilation_angles(displacement: Floats, dilation: Floats) -> Floats:
    """Return the dilation angle (degrees) at each displacement, from the slope d(dilation)/d(displacement).

    The slope at a displacement is the slope of the line through its two neighbours. At an end of the path, it is the
    slope of the line to the only neighbour.
    """
    index = np.arange(displacement.size)
    previous_index, next_index = np.maximum(index - 1, 0), np.minimum(index + 1, displacement.size - 1)
    slopes = (dilation[..., next_index] - dilation[..., previous_index]) / (
        displacement[next_index] - displacement[previous_index]
    )
    return np.asarray(np.degrees(np.arctan(slopes)))


def check_gap(test: xr.Dataset) -> None:
    """Raise an `ArgumentError` if a shear-test dataset lacks the gap of the faces, as in files of earlier versions."""
    if "gap" not in test:
        raise ArgumentError(
            "the shear test must contain the gap of the faces and their closure, got a dataset without a gap; if an "
            "earlier version stored the test, repeat the test with stiction shear --replace, or with "
            "shear_test(..., replace=True)"
        )


def shear_gap(test: xr.Dataset) -> Profile | Surface:
    """Return the gap between the two faces of a shear test at the start of its path, as a profile or a height map.

    The gap is 0 where the faces first touch, and large where they are open. Registered faces are in the position of
    best fit. `pair(gap=...)` computes the closure of a map of the gap, for any hardness and load.

    Parameters
    ----------
    test : xarray.Dataset
        Result of `shear_test`.

    Returns
    -------
    Profile or Surface
        Gap (µm), as a profile if the faces are profiles, and otherwise as a height map.

    Raises
    ------
    ValueError
        If the dataset contains no gap.

    Examples
    --------
    >>> from stiction import Surface, self_affine_surface, shear_gap, shear_test
    >>> lower, noise = (
    ...     self_affine_surface(seed, hurst_exponent=0.8, rms=rms, shape=(64, 64), spacing=50.0)
    ...     for seed, rms in ((1, 20.0), (2, 1.0))
    ... )
    >>> upper = Surface(-(lower.heights + noise.heights)[::-1], spacing=lower.spacing)
    >>> gap = shear_gap(shear_test(upper, lower, path="0.1 mm", load="1 MPa", mu0=0.6, effective_modulus="16 GPa"))
    >>> float(gap.heights.min()), float(gap.heights.std().round(2))
    (0.0, 0.99)
    """
    import xarray as xr

    check_instance("test", test, xr.Dataset, "a dataset from shear_test")
    check_gap(test)
    gap = test["gap"]
    spacing = tuple(float(test[axis][1]) for axis in gap.dims)
    missing = np.isnan(gap.values)
    body_type: Any = Surface if gap.ndim == 2 else Profile
    body: Profile | Surface = body_type(
        np.where(missing, 0.0, gap.values), spacing=spacing if gap.ndim == 2 else spacing[0],
        history=("gap between two faces at first contact",), missing=missing if missing.any() else None,
    )  # fmt: skip
    return body


def summarize_curve(dataset: xr.Dataset) -> dict[str, Any]:
    """Summarize a shear curve as attributes: coefficient, displacement and status at the peak, and final coefficient.

    The peak is NaN if the faces lock. The final coefficient is NaN if the faces slide without a tangential load.
    """
    peak_names = "peak", "peak_displacement_um", "peak_dilation_angle_deg", "peak_shear_stress_GPa"
    summary: dict[str, Any] = dict.fromkeys((*peak_names, "end"), math.nan)
    coefficient, status = dataset["friction_coefficient"].values, dataset["status"].values
    summary["end"] = float(coefficient[-1])
    failure_statuses = [
        name for name in (STATUS_SELF_LOCKED, STATUS_NOT_REACHED, STATUS_NOT_SOLVED) if (status == name).any()
    ]
    summary["peak_status"] = (
        failure_statuses[0] if failure_statuses else STATUS_OK if np.isfinite(coefficient).any() else str(status[0])
    )
    if summary["peak_status"] == STATUS_OK:
        index = int(np.nanargmax(coefficient))
        displacement, dilation = dataset["displacement"].values, dataset["dilation"].values
        peak_values = (
            coefficient[index], displacement[index], compute_dilation_angles(displacement, dilation)[index],
            np.nanmax(dataset["shear_stress"].values),
        )  # fmt: skip
        summary |= {name: float(value) for name, value in zip(peak_names, peak_values, strict=True)}
    return summary
