"""What is known of an input, a number, a value with its uncertainty or a range, as text and as draws.

JCGM 101 (2008): distributions are propagated by draws. A range of a quantity of scale (a hardness, a modulus, a
strength) is log-normal with 95 % between its ends, one of a coefficient normal and cut at 0; a value with a standard
uncertainty is normal and cut at 0; a range from 0 is uniform.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction._units import exactly, quantity, shortened

Distribution = Literal["exact", "normal", "log-normal", "uniform"]

ENDS = 1.959963984540054
"""Standard deviations from the middle of a normal distribution to the ends of its 95 %."""

DRAWS = 4096
"""Points of a scrambled Sobol sequence that stand for what is known."""

_RANGE = re.compile(r"\s*(uniform\s+)?(.+?)\s*\.\.\s*(.+?)\s*")
_WITH_UNCERTAINTY = re.compile(r"\s*(.+?)\s*(?:±|\+-|\+/-)\s*(.+?)\s*")
_UNIT = re.compile(r"[^\W\d_]+\s*$")


@dataclass(frozen=True)
class Known:
    """What is known of an input, in core units.

    Attributes
    ----------
    value : float
        The number, the middle of a range: geometric where its distribution is log-normal.
    low, high : float
        Ends of its 95 % interval, of a uniform distribution of all; equal where the number is exact.
    distribution : {"exact", "normal", "log-normal", "uniform"}
    text : str
        As a person wrote it.

    Examples
    --------
    >>> from stiction.studies.known import known
    >>> known("hardness", "0.5..2 GPa", "pressure").value
    1.0
    >>> known("mu0", "0.2±0.02").distribution
    'normal'
    """

    value: float
    low: float
    high: float
    distribution: Distribution
    text: str

    @property
    def is_exact(self) -> bool:
        """Whether it is a number."""
        return self.distribution == "exact"

    def quantile(self, probability: ArrayLike) -> Floats:
        """Values below which it lies with these probabilities."""
        from scipy.special import ndtr, ndtri

        part = np.asarray(probability, dtype=np.float64)
        if self.is_exact:
            return np.full(part.shape, self.value)
        if self.distribution == "uniform":
            return np.asarray(self.low + part * (self.high - self.low))
        if self.distribution == "log-normal":
            return np.asarray(self.value * np.exp(ndtri(part) / ENDS * 0.5 * math.log(self.high / self.low)))
        deviation = (self.high - self.low) / (2 * ENDS)
        below = ndtr(-self.value / deviation)  # what is cut off at 0
        return np.asarray(np.maximum(self.value + deviation * ndtri(below + part * (1 - below)), 0.0))


def known(name: str, given: Any, kind: Literal["", "pressure"] = "") -> Known:
    """Read a number, "0.2±0.02", "20..80 MPa" or "uniform 0.1..0.3"; numbers are in core units.

    Raises
    ------
    ValueError
        If it is none of these, has a wrong unit, or an end that is not above the other.
    """
    if isinstance(given, Known):
        return given
    if not isinstance(given, str):
        value = _one(name, given, kind)
        return Known(value, value, value, "exact", exactly(value, "GPa") if kind else f"{value:g}")
    text = " ".join(given.split())
    if match := _RANGE.fullmatch(text):
        flat, first, last = match.groups()
        low, high = (_one(name, end, kind) for end in _with_units(first, last))
        if not 0 <= low < high:
            raise ValueError(f"{name} must be a range from a smaller to a larger value, got {shortened(text)}")
        if flat or low == 0:
            return Known(0.5 * (low + high), low, high, "uniform", text)
        if kind:
            return Known(math.sqrt(low * high), low, high, "log-normal", text)
        return Known(0.5 * (low + high), low, high, "normal", text)
    if match := _WITH_UNCERTAINTY.fullmatch(text):
        first, last = match.groups()
        if last.endswith("%"):
            value = _one(name, first, kind)
            deviation = value * _one(name, last[:-1].strip(), "") / 100
        else:
            value, deviation = (_one(name, each, kind) for each in _with_units(first, last))
        if not deviation > 0:
            raise ValueError(f"{name} must have an uncertainty above 0, got {shortened(text)}")
        return Known(value, value - ENDS * deviation, value + ENDS * deviation, "normal", text)
    value = _one(name, text, kind)
    return Known(value, value, value, "exact", text)


def _one(name: str, given: Any, kind: str) -> float:
    """A number that is not negative, with a unit where it is of a kind and text."""
    try:
        value = float(quantity(given, kind)) if kind and isinstance(given, str) else float(given)
    except (TypeError, ValueError) as error:
        said = str(error) if kind and isinstance(given, str) else f"must be a number, got {shortened(given)}"
        raise ValueError(f"{name} {said}") from None
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{name} must be finite and not negative, got {shortened(given)}")
    return value


def _with_units(first: str, last: str) -> tuple[str, str]:
    """Two texts, of which one unit may be for both."""
    unit = _UNIT.search(last)
    return (first if unit is None or _UNIT.search(first) else f"{first} {unit[0]}"), last


def sobol(dimensions: int, count: int = DRAWS, *, seed: int = 0) -> Floats:
    """(count, dimensions) points of a scrambled Sobol sequence inside the unit cube; `count` is a power of two."""
    from scipy.stats import qmc

    points = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(round(math.log2(count)))
    return np.asarray(np.clip(points, 1e-9, 1 - 1e-9))


def draws(inputs: Mapping[str, Known]) -> dict[str, Floats]:
    """(DRAWS,) values of each input."""
    points = sobol(len(inputs))
    return {name: each.quantile(points[:, place]) for place, (name, each) in enumerate(inputs.items())}
