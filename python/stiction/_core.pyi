"""
The C++ core of stiction. Exact types and layouts only; the package around it is the friendly side.
"""

from __future__ import annotations
import collections.abc
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "ArealCandidates",
    "Candidates",
    "ContactModel",
    "HalfSpaceGrids",
    "HalfSpaceSolution",
    "HalfSpaceSolver",
    "approaches_at",
    "areal_quantities",
    "asperities",
    "build",
    "candidates",
    "contacts",
    "force_and_area",
    "frequency_weights",
    "harmonic_profiles",
    "harmonic_surface",
    "natural_slopes",
    "press",
    "press_families",
    "quantities",
    "scale_to_amplitude",
]

class Candidates:
    """
    Places where two bodies may touch, found once for any number of presses.
    """
    def __len__(self) -> int: ...
    def columns(self) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]: ...
    @property
    def deepest(self) -> float:
        """
        Approach [µm] up to which they were looked for.
        """

class ContactModel:
    """
    How two bodies are pressed together.
    """
    def __init__(
        self,
        *,
        law: str,
        parameters: collections.abc.Mapping[str, typing.SupportsFloat | typing.SupportsIndex],
        detection: str,
        curvature: str,
        direction: typing.Annotated[
            collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"
        ],
        sliding: str,
    ) -> None: ...

class ArealCandidates:
    """
    Where two maps may touch, found once for any number of presses.
    """
    def __len__(self) -> int: ...
    def columns(self) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]: ...
    @property
    def deepest(self) -> float:
        """
        Approach [µm] up to which they were looked for.
        """

class HalfSpaceGrids:
    """
    The grid of a problem, coarser ones, and their kernels, for as many problems as have it.
    """
    def __init__(
        self,
        shape: collections.abc.Sequence[typing.SupportsInt | typing.SupportsIndex],
        spacing: collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex],
        *,
        effective_modulus: typing.SupportsFloat | typing.SupportsIndex,
        periodic: bool,
    ) -> None: ...
    def displacement(
        self, pressure: numpy.typing.NDArray[numpy.float64], *, threads: typing.SupportsInt | typing.SupportsIndex = 1
    ) -> numpy.typing.NDArray[numpy.float64]:
        """
        Displacement [µm] of each point under a pressure [GPa].
        """
    def linear_compliance(
        self, free: numpy.typing.NDArray[numpy.bool], *, threads: typing.SupportsInt | typing.SupportsIndex = 1
    ) -> float:
        """
        dδ/dp [µm/GPa] for the sum of pressures over free points under which all of them move alike.
        """
    @property
    def periodic(self) -> bool: ...

class HalfSpaceSolution:
    """
    A pressure and what is known of it.
    """
    @property
    def approach(self) -> float: ...
    @property
    def error(self) -> float: ...
    @property
    def iterations(self) -> int: ...
    @property
    def pressure(self) -> numpy.typing.NDArray[numpy.float64]: ...

class HalfSpaceSolver:
    """
    The pressures of one gap at one load after the other.
    """
    def __init__(
        self,
        gap: numpy.typing.NDArray[numpy.float64],
        grids: HalfSpaceGrids,
        *,
        bound: numpy.typing.NDArray[numpy.float64],
        tolerance: typing.SupportsFloat | typing.SupportsIndex,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
    ) -> None: ...
    def at(
        self,
        mean_pressure: typing.SupportsFloat | typing.SupportsIndex,
        *,
        near: numpy.typing.NDArray[numpy.float64] | None = None,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
        progress: collections.abc.Callable[[int, float], typing.Any] | None = None,
    ) -> HalfSpaceSolution:
        """
        The pressure with a given mean [GPa] over the grid.
        """
    def at_approach(
        self,
        approach: typing.SupportsFloat | typing.SupportsIndex,
        *,
        near: numpy.typing.NDArray[numpy.float64] | None = None,
        threads: typing.SupportsInt | typing.SupportsIndex = 1,
        progress: collections.abc.Callable[[int, float], typing.Any] | None = None,
    ) -> HalfSpaceSolution:
        """
        The pressure at an approach [µm].
        """

@typing.overload
def approaches_at(
    upper: numpy.typing.NDArray[numpy.float64],
    lower: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    loads: numpy.typing.NDArray[numpy.float64],
    left: numpy.typing.NDArray[numpy.float64],
    right: numpy.typing.NDArray[numpy.float64],
    mu0: typing.SupportsFloat | typing.SupportsIndex,
    tau0: typing.SupportsFloat | typing.SupportsIndex,
    model: ContactModel,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Approaches [µm] in brackets at which the normal load rises through loads [mN].
    """

@typing.overload
def approaches_at(
    found: Candidates,
    *,
    loads: numpy.typing.NDArray[numpy.float64],
    left: numpy.typing.NDArray[numpy.float64],
    right: numpy.typing.NDArray[numpy.float64],
    mu0: typing.SupportsFloat | typing.SupportsIndex,
    tau0: typing.SupportsFloat | typing.SupportsIndex,
    model: ContactModel,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    The same, of candidates.
    """

@typing.overload
def approaches_at(
    found: ArealCandidates,
    *,
    loads: numpy.typing.NDArray[numpy.float64],
    left: numpy.typing.NDArray[numpy.float64],
    right: numpy.typing.NDArray[numpy.float64],
    mu0: typing.SupportsFloat | typing.SupportsIndex,
    tau0: typing.SupportsFloat | typing.SupportsIndex,
    model: ContactModel,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    The same, of candidates of two maps.
    """

def areal_quantities() -> list[tuple[str, str, str]]:
    """
    Name, unit and words of each of the sums that only areas have.
    """

def asperities(
    heights: numpy.typing.NDArray[numpy.float64], *, spacing: typing.SupportsFloat | typing.SupportsIndex, side: str
) -> tuple[
    numpy.typing.NDArray[numpy.float64],
    numpy.typing.NDArray[numpy.float64],
    numpy.typing.NDArray[numpy.float64],
    numpy.typing.NDArray[numpy.float64],
    numpy.typing.NDArray[numpy.float64],
]:
    """
    Slope, curvature [1/µm], normal, radius [µm] and centre [µm] at every point of a profile.
    """

def build() -> dict[str, str]:
    """
    What the core was built with, and what it uses of this machine: compiler, instruction_set, gsl.
    """

@typing.overload
def candidates(
    upper: numpy.typing.NDArray[numpy.float64],
    lower: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    deepest: typing.SupportsFloat | typing.SupportsIndex,
    curvature: str,
) -> Candidates:
    """
    The gap minima of two profiles up to a deepest approach [µm].
    """

@typing.overload
def candidates(
    upper: numpy.typing.NDArray[numpy.float64],
    lower: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"],
    deepest: typing.SupportsFloat | typing.SupportsIndex,
    curvature: str,
) -> ArealCandidates:
    """
    The gap minima of two maps up to a deepest approach [µm]; spacing of rows, then of columns.
    """

@typing.overload
def contacts(
    upper: numpy.typing.NDArray[numpy.float64],
    lower: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    approach: typing.SupportsFloat | typing.SupportsIndex,
    model: ContactModel,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    Every contact at one approach [µm]: a dict of columns.
    """

@typing.overload
def contacts(
    found: Candidates, *, approach: typing.SupportsFloat | typing.SupportsIndex, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    The same, of candidates.
    """

@typing.overload
def contacts(
    found: ArealCandidates, *, approach: typing.SupportsFloat | typing.SupportsIndex, model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    Every contact of two maps at one approach [µm]: a dict of columns.
    """

def force_and_area(
    law: str,
    parameters: collections.abc.Mapping[str, typing.SupportsFloat | typing.SupportsIndex],
    *,
    overlap: typing.SupportsFloat | typing.SupportsIndex,
    radius: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[float, float]:
    """
    Force [mN] and area [µm²] of one contact, by a law of this name with all of its parameters.
    """

def frequency_weights(
    hurst_exponent: typing.SupportsFloat | typing.SupportsIndex,
    frequencies: typing.SupportsInt | typing.SupportsIndex,
    gamma: typing.SupportsFloat | typing.SupportsIndex,
    length_scale: typing.SupportsFloat | typing.SupportsIndex,
) -> list[float]:
    """
    Amplitudes of the frequencies of Eq. 1 [µm].
    """

def harmonic_profiles(
    phases: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.c_contiguous"],
    weights: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.c_contiguous"],
    profiles: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    length_scale: typing.SupportsFloat | typing.SupportsIndex,
    gamma: typing.SupportsFloat | typing.SupportsIndex,
    band_limited: bool,
) -> numpy.typing.NDArray[numpy.float64]:
    """
    Eq. 1 for every row of weights, into `profiles` (rows, points) [µm]. Returns mean, lowest and highest of each.
    """

def harmonic_surface(
    phases: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.c_contiguous"],
    weights: numpy.typing.NDArray[numpy.float64],
    heights: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    *,
    spacing_y: typing.SupportsFloat | typing.SupportsIndex,
    spacing_x: typing.SupportsFloat | typing.SupportsIndex,
    length_scale: typing.SupportsFloat | typing.SupportsIndex,
    gamma: typing.SupportsFloat | typing.SupportsIndex,
    band_limited: bool,
) -> None:
    """
    Eq. 1 over an area, into `heights` (rows, columns) [µm].
    """

def natural_slopes(
    heights: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.Annotated[collections.abc.Sequence[typing.SupportsFloat | typing.SupportsIndex], "FixedSize(2)"],
) -> typing.Annotated[list[numpy.typing.NDArray[numpy.float64]], "FixedSize(2)"]:
    """
    Slopes of a map along columns and along rows by natural cubic splines; spacing of rows, then of columns.
    """

@typing.overload
def press(
    upper: numpy.typing.NDArray[numpy.float64],
    lower: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    approaches: numpy.typing.NDArray[numpy.float64],
    model: ContactModel,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    Sums over the contacts at each approach [µm]: a dict of columns.
    """

@typing.overload
def press(
    found: Candidates, *, approaches: numpy.typing.NDArray[numpy.float64], model: ContactModel
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    The same, of candidates.
    """

@typing.overload
def press(
    found: ArealCandidates,
    *,
    approaches: numpy.typing.NDArray[numpy.float64],
    model: ContactModel,
    directions: numpy.typing.NDArray[numpy.float64],
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    Sums over the contacts of two maps: a dict of columns, direction by direction and in it by approach.
    """

def press_families(
    upper: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    upper_levels: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.c_contiguous"],
    lower: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
    lower_levels: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.c_contiguous"],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    amplitudes: numpy.typing.NDArray[numpy.float64],
    measure: str,
    approaches: numpy.typing.NDArray[numpy.float64],
    models: collections.abc.Sequence[ContactModel],
    scratch: typing.Annotated[numpy.typing.NDArray[numpy.float64], "[m, n]", "flags.writeable", "flags.c_contiguous"],
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    Sums of every pair of rows at each amplitude [µm] by each model at each approach [µm]: a dict of columns. Both families are used up.
    """

def quantities() -> list[tuple[str, str, str]]:
    """
    Name, unit and words of each of the sums.
    """

def scale_to_amplitude(
    heights: numpy.typing.NDArray[numpy.float64],
    amplitude: typing.SupportsFloat | typing.SupportsIndex,
    measure: str,
    scaled: numpy.typing.NDArray[numpy.float64],
) -> bool:
    """
    Heights [µm] about a mean of zero with a measure of `amplitude` [µm], into `scaled`; False for a flat profile.
    """

__version__: str
