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
    "PressureSearch",
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

class PressureSearch:
    def __init__(
        self,
        pressure: numpy.typing.NDArray[numpy.float64],
        *,
        total: typing.SupportsFloat | typing.SupportsIndex,
        bound: numpy.typing.NDArray[numpy.float64],
        line: bool,
    ) -> None: ...
    def advance(self, response: numpy.typing.NDArray[numpy.float32]) -> bool: ...
    def balance(self) -> float: ...
    def residual(self) -> numpy.typing.NDArray[numpy.float32]: ...
    def restart(self, potential: numpy.typing.NDArray[numpy.float64]) -> None: ...
    def settle(self) -> None: ...
    def sharpened(
        self, stencil: numpy.typing.NDArray[numpy.float64], columns: typing.SupportsInt | typing.SupportsIndex
    ) -> numpy.typing.NDArray[numpy.float32]: ...
    def step(
        self, preconditioned: numpy.typing.NDArray[numpy.float32], response: numpy.typing.NDArray[numpy.float32]
    ) -> numpy.typing.NDArray[numpy.float32]: ...
    def work(self) -> float: ...
    @property
    def approach(self) -> float: ...
    @property
    def plain(self) -> bool: ...
    @property
    def pressure(self) -> numpy.typing.NDArray[numpy.float64]: ...

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
