"""The C++ core of stiction. Exact types and layouts only; the package around it is the friendly side."""

from __future__ import annotations
import collections.abc
import numpy
from numpy import float64
from numpy.typing import NDArray
import typing

class Candidates:
    """Places where two bodies may touch, found once for any number of presses."""
    def __len__(self) -> int: ...
    def columns(self) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]: ...
    @property
    def deepest(self) -> float:
        """Approach [µm] up to which they were looked for."""

class ContactModel:
    """How two bodies are pressed together."""
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
    """Where two maps may touch, found once for any number of presses."""
    def __len__(self) -> int: ...
    def columns(self) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]: ...
    @property
    def deepest(self) -> float:
        """Approach [µm] up to which they were looked for."""

class HalfSpaceGrids:
    """The grid of a problem, coarser ones, and their kernels, for as many problems as have it."""
    def __init__(
        self,
        shape: collections.abc.Sequence[int],
        spacing: collections.abc.Sequence[float],
        *,
        effective_modulus: float,
        periodic: bool,
    ) -> None: ...
    def displacement(self, pressure: NDArray[float64], *, threads: int = 1) -> NDArray[float64]:
        """Displacement [µm] of each point under a pressure [GPa]."""
    def linear_answer(self, free: NDArray[numpy.bool], *, threads: int = 1) -> tuple[NDArray[float64], float]:
        """Pressures [GPa] of sum 1 under which all free points move alike, and by how much [µm]."""
    @property
    def periodic(self) -> bool: ...

class HalfSpaceSolution:
    """A pressure and what is known of it."""
    @property
    def approach(self) -> float: ...
    @property
    def error(self) -> float: ...
    @property
    def iterations(self) -> int: ...
    @property
    def pressure(self) -> NDArray[float64]: ...

class HalfSpaceSolver:
    """The pressures of one gap at one load after the other."""
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
    ) -> HalfSpaceSolution:
        """The pressure with a given mean [GPa] over the grid."""
    def at_approach(
        self,
        approach: float,
        *,
        near: NDArray[float64] | None = None,
        threads: int = 1,
        progress: collections.abc.Callable[[int, float], typing.Any] | None = None,
    ) -> HalfSpaceSolution:
        """The pressure at an approach [µm]."""

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
    """Approaches [µm] in brackets at which the normal load rises through loads [mN]."""

@typing.overload
def approaches_at(
    found: Candidates,
    *,
    loads: NDArray[float64],
    left: NDArray[float64],
    right: NDArray[float64],
    mu0: float,
    tau0: float,
    model: ContactModel,
) -> NDArray[float64]:
    """The same, of candidates."""

@typing.overload
def approaches_at(
    found: ArealCandidates,
    *,
    loads: NDArray[float64],
    left: NDArray[float64],
    right: NDArray[float64],
    mu0: float,
    tau0: float,
    model: ContactModel,
) -> NDArray[float64]:
    """The same, of candidates of two maps."""

def areal_quantities() -> list[tuple[str, str, str]]:
    """Name, unit and words of each of the sums that only areas have."""

def asperities(
    heights: NDArray[float64], *, spacing: float, side: str
) -> tuple[NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64], NDArray[float64]]:
    """Slope, curvature [1/µm], normal, radius [µm] and centre [µm] at every point of a profile."""

def build() -> dict[str, str]:
    """What the core was built with, and what it uses of this machine: compiler, instruction_set, gsl."""

@typing.overload
def candidates(
    upper: NDArray[float64], lower: NDArray[float64], *, spacing: float, deepest: float, curvature: str
) -> Candidates:
    """The gap minima of two profiles up to a deepest approach [µm]."""

@typing.overload
def candidates(
    upper: NDArray[float64],
    lower: NDArray[float64],
    *,
    spacing: typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"],
    deepest: float,
    curvature: str,
) -> ArealCandidates:
    """The gap minima of two maps up to a deepest approach [µm]; spacing of rows, then of columns."""

@typing.overload
def contacts(
    upper: NDArray[float64], lower: NDArray[float64], *, spacing: float, approach: float, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Every contact at one approach [µm]: a dict of columns."""

@typing.overload
def contacts(
    found: Candidates, *, approach: float, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """The same, of candidates."""

@typing.overload
def contacts(
    found: ArealCandidates, *, approach: float, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Every contact of two maps at one approach [µm]: a dict of columns."""

def force_and_area(
    law: str, parameters: collections.abc.Mapping[str, float], *, overlap: float, radius: float
) -> tuple[float, float]:
    """Force [mN] and area [µm²] of one contact, by a law of this name with all of its parameters."""

def frequency_weights(hurst_exponent: float, frequencies: int, gamma: float, length_scale: float) -> list[float]:
    """Amplitudes of the frequencies of Eq. 1 [µm]."""

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
    """Eq. 1 for every row of weights, into `profiles` (rows, points) [µm]. Returns mean, lowest and highest of each."""

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
    """Eq. 1 over an area, into `heights` (rows, columns) [µm]."""

def natural_slopes(
    heights: NDArray[float64], *, spacing: typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"]
) -> typing.Annotated[list[NDArray[float64]], "FixedSize(2)"]:
    """Slopes of a map along columns and along rows by natural cubic splines; spacing of rows, then of columns."""

def patch_sums(
    force: NDArray[float64],
    area: NDArray[float64],
    slope_y: NDArray[float64] | None,
    slope_x: NDArray[float64],
    patch: NDArray[numpy.int32],
    directions: collections.abc.Sequence[typing.Annotated[collections.abc.Sequence[float], "FixedSize(2)"]],
) -> dict[str, typing.Any]:
    """Sums over the points of each patch, by name, and along directions (x, y)."""

def patches_of(
    pressure: NDArray[float64], *, periodic: bool, hardness: float
) -> tuple[NDArray[numpy.int64], NDArray[float64], NDArray[float64], NDArray[numpy.int32]]:
    """Of each point under pressure: place, pressure [GPa], share of its cell in contact, and patch, from 1 on."""

@typing.overload
def press(
    upper: NDArray[float64],
    lower: NDArray[float64],
    *,
    spacing: float,
    approaches: NDArray[float64],
    model: ContactModel,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Sums over the contacts at each approach [µm]: a dict of columns."""

@typing.overload
def press(
    found: Candidates, *, approaches: NDArray[float64], model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """The same, of candidates."""

@typing.overload
def press(
    found: ArealCandidates, *, approaches: NDArray[float64], model: ContactModel, directions: NDArray[float64]
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Sums over the contacts of two maps: a dict of columns, direction by direction and in it by approach."""

def press_families(
    upper: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    upper_levels: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    lower: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    lower_levels: typing.Annotated[NDArray[float64], "[m, n]", "flags.c_contiguous"],
    *,
    spacing: float,
    amplitudes: NDArray[float64],
    measure: str,
    approaches: NDArray[float64],
    models: collections.abc.Sequence[ContactModel],
    scratch: typing.Annotated[NDArray[float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """Sums of every pair of rows at each amplitude [µm] by each model at each approach [µm]: a dict of columns. Both families are used up."""

def quantities() -> list[tuple[str, str, str]]:
    """Name, unit and words of each of the sums."""

def scale_to_amplitude(heights: NDArray[float64], amplitude: float, measure: str, scaled: NDArray[float64]) -> bool:
    """Heights [µm] about a mean of zero with a measure of `amplitude` [µm], into `scaled`; False for a flat profile."""

__version__: str
