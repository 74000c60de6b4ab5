"""C++ core of stiction. It accepts only exact types and array layouts; the Python package does all conversions."""

from __future__ import annotations
import collections.abc
import numpy
from numpy import float64
from numpy.typing import NDArray
import typing

class Candidates:
    """Contact candidates of two profiles, valid for all approaches up to `deepest`."""
    def __len__(self) -> int: ...
    def columns(self) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]: ...
    @property
    def deepest(self) -> float:
        """Largest approach [µm] for which the candidates are complete."""

class ContactModel:
    """Contact law, detection method and sliding rule for a pair of surfaces."""
    def __init__(
        self,
        *,
        law: str,
        parameters: collections.abc.Mapping[str, float],
        detection: str,
        curvature: str,
        direction: typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"],
        sliding: str,
    ) -> None: ...

class ArealCandidates:
    """Contact candidates of two maps, valid for all approaches up to `deepest`."""
    def __len__(self) -> int: ...
    def columns(self) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]: ...
    @property
    def deepest(self) -> float:
        """Largest approach [µm] for which the candidates are complete."""

class IterationCounter:
    """Number of solver iterations, which other threads may read during a calculation."""
    def __init__(self) -> None: ...
    def add(self, iterations: int) -> None:
        """Add iterations of an earlier calculation whose result is reused."""
    @property
    def count(self) -> int: ...

class HalfSpaceGrids:
    """Grid hierarchy and elastic kernels, shared by all contact problems on the same grid."""
    def __init__(
        self,
        shape: collections.abc.Sequence[int],
        spacing: collections.abc.Sequence[float],
        *,
        effective_modulus: float,
        periodic: bool,
    ) -> None: ...
    def displacement(self, pressure: NDArray[float64], *, threads: int = 1) -> NDArray[float64]:
        """Compute the displacement [µm] of each point under a pressure [GPa]."""
    def fixed_contact_responses(
        self, contacts: list[NDArray[numpy.int64]], uniform_displacement: NDArray[float64], *, threads: int = 1
    ) -> list[tuple[float, float]]:
        """Return two displacements [µm] for the points of each contact, under pressures [GPa] with a sum of 1 that displace all of its points equally: the displacement of these points, and Σ pressure · uniform_displacement."""
    def linear_response(self, in_contact: NDArray[numpy.bool], *, threads: int = 1) -> tuple[NDArray[float64], float]:
        """Compute the pressures [GPa] with a sum of 1 that displace all contact points equally. Also returns the displacement [µm]."""
    @property
    def periodic(self) -> bool: ...

class HalfSpaceSolution:
    """Solution of a contact problem: pressures [GPa], approach [µm], relative error and number of iterations."""
    @property
    def approach(self) -> float: ...
    @property
    def error(self) -> float: ...
    @property
    def iterations(self) -> int: ...
    @property
    def potential(self) -> NDArray[float64]:
        """Gap plus displacement [µm] at the points whose pressure bound is above 0, or an empty array."""
    @property
    def pressure(self) -> NDArray[float64]: ...

class HalfSpaceSolver:
    """Solver for the contact of a half-space with a given gap, at successive loads."""
    def __init__(
        self,
        gap: NDArray[float64],
        grids: HalfSpaceGrids,
        *,
        bound: NDArray[float64],
        tolerance: float,
        threads: int = 1,
    ) -> None: ...
    def at(
        self,
        mean_pressure: float,
        *,
        near: NDArray[float64] | None = None,
        threads: int = 1,
        progress: collections.abc.Callable[[int, float], typing.Any] | None = None,
        counter: IterationCounter | None = None,
    ) -> HalfSpaceSolution:
        """Solve the contact problem at a mean pressure [GPa]. The solver starts from `near`, the pressures at another load, if given."""
    def at_approach(
        self,
        approach: float,
        *,
        near: NDArray[float64] | None = None,
        threads: int = 1,
        progress: collections.abc.Callable[[int, float], typing.Any] | None = None,
        counter: IterationCounter | None = None,
    ) -> HalfSpaceSolution:
        """Solve the contact problem at an approach [µm]. The solver starts from `near`, the pressures at another load, if given."""
    def contacts_at(
        self,
        mean_pressures: NDArray[float64],
        *,
        near: NDArray[float64] | None = None,
        hardness: float,
        threads: int = 1,
        progress: collections.abc.Callable[[int, int, float], typing.Any] | None = None,
        counter: IterationCounter | None = None,
    ) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
        """Solve for each of several mean pressures over the grid [GPa], up to the first without a solution. Returns concatenated arrays of `patches_of`, and one element per contact of the other arrays."""
    def contacts_at_approaches(
        self,
        approaches: NDArray[float64],
        *,
        near: NDArray[float64] | None = None,
        hardness: float,
        threads: int = 1,
        progress: collections.abc.Callable[[int, int, float], typing.Any] | None = None,
        counter: IterationCounter | None = None,
    ) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
        """Solve for each of several approaches [µm]; see `contacts_at`."""

class MinimizationState:
    """State between two steps of an energy minimization, from which it can be resumed."""
    def __init__(self, fields: dict[str, typing.Any]) -> None:
        """Restore a state from the arrays and numbers of `fields`."""
    def fields(self) -> dict[str, typing.Any]:
        """Return the arrays and numbers of the state."""
    @property
    def approach(self) -> float: ...
    @property
    def number(self) -> int: ...

class EnergyMinimizer:
    """Energy of an adhesive contact under a constant load, minimized by conjugate gradients."""
    def __init__(
        self,
        gap: NDArray[float64],
        grids: HalfSpaceGrids,
        *,
        max_attraction: float,
        range: float,
        hardness: float,
        threads: int = 1,
    ) -> None: ...
    def start(
        self, pressure: NDArray[float64], attraction: NDArray[float64], load: float, *, threads: int = 1
    ) -> MinimizationState:
        """Return the state at the start of a minimization under a mean pressure [GPa]."""
    def step(
        self,
        state: MinimizationState,
        load: float,
        *,
        max_residual: float,
        max_accepted_residual: float,
        min_contact_load: float,
        threads: int = 1,
    ) -> str:
        """Perform a step. Returns "unfinished", or why no step was performed: "balanced", "separated" or "stalled"."""
    def stresses(self, state: MinimizationState) -> tuple[NDArray[float64], NDArray[float64]]:
        """Return the pressure and the attraction [GPa] at each grid point."""

@typing.overload
def approaches_at(
    upper: NDArray[float64],
    lower: NDArray[float64],
    *,
    spacing: float,
    loads: NDArray[float64],
    left: NDArray[float64],
    right: NDArray[float64],
    mu0: float,
    tau0: float,
    model: ContactModel,
) -> NDArray[float64]:
    """Find the approaches [µm] between `left` and `right` at which two profiles reach the loads [mN]."""

@typing.overload
def approaches_at(
    candidates: Candidates,
    *,
    loads: NDArray[float64],
    left: NDArray[float64],
    right: NDArray[float64],
    mu0: float,
    tau0: float,
    model: ContactModel,
) -> NDArray[float64]:
    """Find the approaches [µm] between `left` and `right` at which candidates of two profiles reach the loads [mN]."""

@typing.overload
def approaches_at(
    candidates: ArealCandidates,
    *,
    loads: NDArray[float64],
    left: NDArray[float64],
    right: NDArray[float64],
    mu0: float,
    tau0: float,
    model: ContactModel,
) -> NDArray[float64]:
    """Find the approaches [µm] between `left` and `right` at which candidates of two maps reach the loads [mN]."""

def areal_quantities() -> list[tuple[str, str, str]]:
    """Return name, unit and description of the contact sums that exist only for areal contact."""

def asperities(
    heights: NDArray[float64], *, spacing: float, side: str
) -> tuple[NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64]]:
    """Compute slope, curvature [1/µm], normal, radius [µm] and centre [µm] at every point of a profile."""

def build() -> dict[str, str]:
    """Return build information of the core: compiler, instruction_set and gsl."""

@typing.overload
def candidates(
    upper: NDArray[float64], lower: NDArray[float64], *, spacing: float, deepest: float, curvature: str
) -> Candidates:
    """Find the contact candidates of two profiles up to the approach `deepest` [µm]: the minima of the gap."""

@typing.overload
def candidates(
    upper: NDArray[float64],
    lower: NDArray[float64],
    *,
    spacing: typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"],
    deepest: float,
    curvature: str,
) -> ArealCandidates:
    """Find the contact candidates of two maps up to the approach `deepest` [µm]: the minima of the gap. `spacing` is (Δy, Δx) [µm]."""

def contact_statistics(
    force: NDArray[float64],
    area: NDArray[float64],
    cells: NDArray[float64],
    at_edge: NDArray[numpy.bool],
    pressure: NDArray[float64],
    weight: NDArray[float64],
    *,
    probabilities: NDArray[float64],
    max_small_cells: float,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Compute load fractions, and quantiles of area and pressure, of the contacts at one load."""

@typing.overload
def contacts(
    upper: NDArray[float64], lower: NDArray[float64], *, spacing: float, approach: float, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """List the contacts of two profiles at one approach [µm], as a dict of columns."""

@typing.overload
def contacts(
    candidates: Candidates, *, approach: float, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """List the contacts of stored candidates at one approach [µm], as a dict of columns."""

@typing.overload
def contacts(
    candidates: ArealCandidates, *, approach: float, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """List the contacts of two maps at one approach [µm], as a dict of columns."""

def convert_cells(text: bytes, separator: str, values: NDArray[float64], *, threads: int = 1) -> list[int]:
    """Parse the cells of a text as numbers, and write the numbers to `values`. Returns the indices of the cells that are not numbers."""

def find_rows(text: bytes, separator: str) -> tuple[NDArray[numpy.int64], NDArray[numpy.int64]]:
    """Find the rows of a text. Returns the offsets at which rows start and the last row ends, and the number of cells in each row."""

def force_and_area(
    law: str, parameters: collections.abc.Mapping[str, float], *, overlap: float, radius: float
) -> tuple[float, float]:
    """Compute force [mN] and area [µm²] of one contact for a named law with all of its parameters."""

def frequency_weights(hurst_exponent: float, frequencies: int, gamma: float, length_scale: float) -> list[float]:
    """Compute the amplitude [µm] of each frequency in Eq. 1."""

def harmonic_profiles(
    phases: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    weights: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    profiles: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    *,
    spacing: float,
    length_scale: float,
    gamma: float,
    band_limited: bool,
) -> NDArray[float64]:
    """Compute a profile by Eq. 1 for each row of weights, and write the heights [µm] to `profiles` (rows, points). Returns (mean, min, max) of each profile."""

def harmonic_surface(
    phases: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    weights: NDArray[float64],
    heights: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    *,
    spacing_y: float,
    spacing_x: float,
    length_scale: float,
    gamma: float,
    band_limited: bool,
) -> None:
    """Compute a height map by the areal form of Eq. 1, and write it to `heights` (rows, columns) [µm]."""

def interpolate_table(
    table: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    rows: NDArray[float64],
    columns: NDArray[float64],
) -> NDArray[float64]:
    """Interpolate a table linearly at pairs of fractional row and column indices. Indices outside the table are moved to its edge. The value is NaN if an index is NaN."""

def jackknife_sums(
    loads: NDArray[float64],
    values: NDArray[float64],
    *,
    curve: NDArray[numpy.int64],
    step: NDArray[numpy.int64],
    fraction: NDArray[float64],
    load: NDArray[float64],
    mean: NDArray[float64],
    slope: NDArray[float64],
    total_repetitions: int,
) -> NDArray[float64]:
    """Compute power sums of jackknife values (10, points) from curves of loads and values (curves, steps, repetitions)."""

def load_fractions_on_marked_points(
    contacts: list[tuple[NDArray[numpy.int64], NDArray[float64], NDArray[float64], NDArray[numpy.int32]]],
    marks: NDArray[numpy.bool],
) -> NDArray[float64]:
    """Return the load fraction on marked grid points of several half-space contacts."""

def natural_slopes(
    heights: NDArray[float64], *, spacing: typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"]
) -> typing.Annotated[list[NDArray[float64]], "FixedSize(2)"]:
    """Compute the slopes (dz/dy, dz/dx) of a map from natural cubic splines. `spacing` is (Δy, Δx) [µm]."""

def patch_statistics(
    contacts: list[tuple[NDArray[numpy.int64], NDArray[float64], NDArray[float64], NDArray[numpy.int32]]],
    *,
    shape: collections.abc.Sequence[int],
    spacing: collections.abc.Sequence[float],
    probabilities: NDArray[float64],
    max_small_cells: float,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Compute load fractions, and quantiles of area and pressure, of the patches of several half-space contacts. Each contact is a tuple of arrays as from `patches_of`."""

def patch_sums(
    contacts: list[tuple[NDArray[numpy.int64], NDArray[float64], NDArray[float64], NDArray[numpy.int32]]],
    slope_y: NDArray[float64] | None,
    slope_x: NDArray[float64],
    *,
    cell_area: float,
    directions: collections.abc.Sequence[typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"]],
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Compute force and area sums over the points of each patch of several contacts, some of them for each direction (x, y). Each contact is a tuple of arrays as from `patches_of`."""

def patches_of(
    pressure: NDArray[float64], *, periodic: bool, hardness: float
) -> tuple[NDArray[numpy.int64], NDArray[float64], NDArray[float64], NDArray[numpy.int32]]:
    """Return the points under pressure: index, pressure [GPa], contact fraction of the cell, and patch number (from 1)."""

def periodic_slopes(
    heights: NDArray[float64], *, spacing: typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"]
) -> typing.Annotated[list[NDArray[float64]], "FixedSize(2)"]:
    """Compute the slopes (dz/dy, dz/dx) of a periodic map from Fourier transforms. `spacing` is (Δy, Δx) [µm]."""

@typing.overload
def press(
    upper: NDArray[float64],
    lower: NDArray[float64],
    *,
    spacing: float,
    approaches: NDArray[float64],
    model: ContactModel,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Compute the contact sums of two profiles at each approach [µm], as a dict of columns."""

@typing.overload
def press(
    candidates: Candidates, *, approaches: NDArray[float64], model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Compute the contact sums of stored candidates at each approach [µm], as a dict of columns."""

@typing.overload
def press(
    candidates: ArealCandidates, *, approaches: NDArray[float64], model: ContactModel, directions: NDArray[float64]
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Compute the contact sums of two maps, as a dict of columns with rows ordered by direction, then approach [µm]."""

def press_profile_batches(
    upper: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    upper_statistics: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    lower: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    lower_statistics: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    *,
    spacing: float,
    amplitudes: NDArray[float64],
    measure: str,
    approaches: NDArray[float64],
    models: collections.abc.Sequence[ContactModel],
    scratch: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Compute the contact sums of each pair of rows, for each amplitude [µm], model and approach [µm], as a dict of columns. The heights are overwritten."""

def quantities() -> list[tuple[str, str, str]]:
    """Return name, unit and description of the contact sums."""

def scale_to_amplitude(heights: NDArray[float64], amplitude: float, measure: str, scaled: NDArray[float64]) -> bool:
    """Write heights of zero mean and the given amplitude [µm] to `scaled`. Returns False for a flat profile."""

__version__: str
