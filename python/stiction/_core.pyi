"""
The C++ core of stiction. Exact types and layouts only; the package around it is the friendly side.
"""

from __future__ import annotations
import numpy
import numpy.typing
import typing

__all__: list[str] = [
    "HertzCylinder",
    "HertzSphere",
    "JacksonGreen",
    "PressureSearch",
    "asperities",
    "check",
    "contacts",
    "force_and_area",
    "frequency_weights",
    "harmonic_profiles",
    "press",
    "scale_to_amplitude",
]

class HertzSphere:
    def __init__(self, *, effective_modulus: typing.SupportsFloat | typing.SupportsIndex) -> None: ...

class HertzCylinder:
    def __init__(
        self,
        *,
        effective_modulus: typing.SupportsFloat | typing.SupportsIndex,
        width: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...

class JacksonGreen:
    def __init__(
        self,
        *,
        effective_modulus: typing.SupportsFloat | typing.SupportsIndex,
        yield_strength: typing.SupportsFloat | typing.SupportsIndex,
        poisson_ratio: typing.SupportsFloat | typing.SupportsIndex,
    ) -> None: ...

class PressureSearch:
    def __init__(
        self,
        pressure: numpy.typing.NDArray[numpy.float64],
        *,
        total: typing.SupportsFloat | typing.SupportsIndex,
        hardness: typing.SupportsFloat | typing.SupportsIndex,
        line: bool,
        periodic: bool,
    ) -> None: ...
    def advance(self, response: numpy.typing.NDArray[numpy.float32]) -> bool: ...
    def balance(self) -> float: ...
    def residual(self) -> numpy.typing.NDArray[numpy.float32]: ...
    def restart(self, potential: numpy.typing.NDArray[numpy.float64]) -> None: ...
    def settle(self) -> None: ...
    def step(
        self, preconditioned: numpy.typing.NDArray[numpy.float32], response: numpy.typing.NDArray[numpy.float32]
    ) -> numpy.typing.NDArray[numpy.float32]: ...
    @property
    def approach(self) -> float: ...
    @property
    def plain(self) -> bool: ...
    @property
    def pressure(self) -> numpy.typing.NDArray[numpy.float64]: ...

def asperities(
    heights: numpy.typing.NDArray[numpy.float64], *, spacing: typing.SupportsFloat | typing.SupportsIndex, upper: bool
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

def check(law: HertzSphere | HertzCylinder | JacksonGreen) -> None:
    """
    Raise a ValueError for a bad parameter.
    """

def contacts(
    upper: numpy.typing.NDArray[numpy.float64],
    lower: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    approach: typing.SupportsFloat | typing.SupportsIndex,
    law: HertzSphere | HertzCylinder | JacksonGreen,
    by_cell: bool,
    convex_only: bool,
    shear: typing.SupportsInt | typing.SupportsIndex,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    Every contact at one approach [µm]: a dict of columns.
    """

def force_and_area(
    law: HertzSphere | HertzCylinder | JacksonGreen,
    overlap: typing.SupportsFloat | typing.SupportsIndex,
    radius: typing.SupportsFloat | typing.SupportsIndex,
) -> tuple[float, float]:
    """
    Force [mN] and area [µm²] of one contact.
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
) -> None:
    """
    Eq. 1 for every row of weights, into `profiles` (rows, points) [µm].
    """

def press(
    upper: numpy.typing.NDArray[numpy.float64],
    lower: numpy.typing.NDArray[numpy.float64],
    approaches: numpy.typing.NDArray[numpy.float64],
    *,
    spacing: typing.SupportsFloat | typing.SupportsIndex,
    law: HertzSphere | HertzCylinder | JacksonGreen,
    by_cell: bool,
    convex_only: bool,
    shear: typing.SupportsInt | typing.SupportsIndex,
) -> dict[str, numpy.ndarray[typing.Any, numpy.dtype[typing.Any]]]:
    """
    Sums over the contacts at each approach [µm]: a dict of columns.
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

__version__: str = "0.1.0"
