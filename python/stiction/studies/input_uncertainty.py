"""What is known of an input, a number, a value with its uncertainty or a range, as text and as draws.

JCGM 101 (2008): distributions are propagated by draws. A range of a quantity of scale (a hardness, a modulus, a
strength) is log-normal with 95 % between its ends, one of a coefficient normal and cut at 0; a value with a standard
uncertainty is normal and cut at 0; a range from 0 is uniform.
"""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field, ValidationInfo, field_validator

from stiction._arguments import MAX_NUMBER
from stiction._checks import Floats, read_only
from stiction._units import exact_text, quantity, short_repr
from stiction.studies.values import Table, as_tuple

if TYPE_CHECKING:
    pass

Distribution = Literal["exact", "normal", "log-normal", "uniform"]
Z_95 = 1.959963984540054  # standard deviations from the middle of a normal distribution to the ends of its 95 %
NUM_SAMPLES = 2**14  # samples of the inputs: equal inputs have budget fractions that differ by less than 0.01
MIN_DEVIATION = 1e-9  # smallest standard uncertainty over the value
UNCERTAIN_TEXT = re.compile(r"\.\.|±|\+/?-|(?<![^\W\d_])(HV|HRC)(?![^\W\d_])")
"""Part of a text that is more than a number with a unit."""

_ROCKWELL = {20: 238, 25: 266, 30: 302, 35: 345, 40: 392, 45: 446, 50: 513, 55: 595, 60: 697, 65: 832, 68: 940}
"""Vickers hardness of steels of a Rockwell hardness C, ISO 18265 (2013), table A.1, and ASTM E140."""

ROCKWELL_ERROR = 0.05  # half of the relative range of a hardness that is converted from Rockwell's: 10 to 20 HV
_VICKERS = 9.80665e-3 / 0.9272  # mean pressure (GPa) of 1 HV: kgf per mm² of ground plan, 0.9272 of the faces
_RANGE = re.compile(r"\s*(uniform\s+)?(.+?)\s*\.\.\s*(.+?)\s*")
_WITH_UNCERTAINTY = re.compile(r"\s*(.+?)\s*(?:±|\+-|\+/-)\s*(.+?)\s*")
_UNIT = re.compile(r"(?<![^\W\d_])(?!inf\b|nan\b)[^\W\d_]+\s*$", re.IGNORECASE)
_TEST_LOAD = re.compile(r"(?<![^\W\d_])HV\s*[0-9]+(\.[0-9]+)?(?![0-9.]*\s*[^\W\d_])")  # "HV10", "HV 0.5": kgf
Kind = Literal["", "pressure", "modulus", "hardness"]
MAX_POISSON = 0.5  # Poisson's ratio of a body that keeps its volume
MAX_GROWTH = 100.0  # largest α of junction growth: 27 is von Mises with H of three yield strengths
MAX_CREEP = 0.5  # largest exponent of creep: a hardness that falls by three within a decade of time is that of a melt


@dataclass(frozen=True)
class UncertainInput:
    """What is known of an input, in core units."""

    value: float  # the number, or the middle of a range: geometric where its distribution is log-normal
    low: float  # end of its 95 % interval, of a uniform distribution of all
    high: float
    distribution: Distribution
    text: str  # as a person wrote it
    maximum: float = math.inf  # value above which it cannot be

    @property
    def is_exact(self) -> bool:
        """Whether it is a number."""
        return self.distribution == "exact"

    @property
    def short_text(self) -> str:
        """Short text: a number in up to six digits, or the range as it was given."""
        return f"{self.value:g}" if self.is_exact else self.text

    def agrees_with(self, text: str) -> bool:
        """Whether a text says the same of a hardness, in whatever unit."""
        try:
            other = self if text == self.text else parse_input("", text, "hardness")
        except ValueError:
            return False
        return self.distribution == other.distribution and np.allclose([self.low, self.high], [other.low, other.high])

    def quantile(self, probability: ArrayLike) -> Floats:
        """Values below which it lies with these probabilities."""
        part = np.asarray(probability, dtype=np.float64)
        return np.minimum(self._quantile(part), self.maximum)

    def _quantile(self, part: Floats) -> Floats:
        from scipy.special import ndtr, ndtri

        if self.is_exact:
            return np.full(part.shape, self.value)
        if self.distribution == "uniform":
            return np.asarray(self.low + part * (self.high - self.low))
        if self.distribution == "log-normal":
            return np.asarray(self.value * np.exp(ndtri(part) / Z_95 * 0.5 * math.log(self.high / self.low)))
        deviation = (self.high - self.low) / (2 * Z_95)
        below = ndtr(-self.value / deviation)  # what is cut off at 0
        return np.asarray(np.maximum(self.value + deviation * ndtri(below + part * (1 - below)), 0.0))


def parse_input(name: str, given: Any, kind: Kind = "") -> UncertainInput:
    """Read a number, "0.2±0.02", "20..80 MPa" or "150 HV"; numbers are in core units; a `ValueError` if it is none."""
    if isinstance(given, UncertainInput):
        return given
    if not isinstance(given, str):
        value = _one(name, given, kind)
        return UncertainInput(value, value, value, "exact", exact_text(value, "GPa") if kind else repr(value))
    text = " ".join(given.split())
    found = _read(name, _TEST_LOAD.sub("HV", text) if kind == "hardness" else text, kind)
    if not found.high <= MAX_NUMBER:
        raise ValueError(f"{name} must be at most {MAX_NUMBER:g} with its uncertainty, got {short_repr(text)}")
    if found.distribution == "normal" and found.high - found.low < 2 * Z_95 * MIN_DEVIATION * found.value:
        raise ValueError(f"{name} must have a larger uncertainty or none, got {short_repr(text)}")
    return replace(found, text=text)


def _read(name: str, text: str, kind: Kind) -> UncertainInput:
    """What is known of an input, from a text with single blanks."""
    converted = text.find("HRC") >= 0 and kind == "hardness"
    if match := _RANGE.fullmatch(text):
        flat, first, last = match.groups()
        low, high = (_one(name, end, kind) for end in _with_units(first, last))
        if not 0 <= low < high:
            raise ValueError(f"{name} must be a range from a smaller to a larger value, got {short_repr(text)}")
        if kind in ("hardness", "modulus") and low == 0:
            raise ValueError(f"{name} must be above 0, got {short_repr(text)}")
        if converted:
            return _widened(low, high, text)
        if flat or low == 0:
            return UncertainInput(0.5 * (low + high), low, high, "uniform", text)
        if kind:
            return UncertainInput(math.sqrt(low * high), low, high, "log-normal", text)
        return UncertainInput(0.5 * (low + high), low, high, "normal", text)
    if match := _WITH_UNCERTAINTY.fullmatch(text):
        first, last = match.groups()
        if last.endswith("%"):
            value = _one(name, first, kind)
            deviation = value * _one(name, last[:-1].strip(), "") / 100
            deviation = math.hypot(deviation, ROCKWELL_ERROR * value / Z_95) if converted else deviation
        elif converted:
            middle, steps = (_number(name, _UNIT.sub("", each).strip()) for each in (first, last))
            ends = (middle - Z_95 * steps, middle + Z_95 * steps)
            if not min(_ROCKWELL) <= ends[0] <= ends[1] <= max(_ROCKWELL):
                limits = f"{min(_ROCKWELL)} to {max(_ROCKWELL)} HRC"
                raise ValueError(f"{name} must be from {limits} with its uncertainty, got {short_repr(text)}")
            low, high = (_one(name, f"{end:g} HRC", kind) for end in ends)
            return _widened(low, high, text)
        else:
            value, deviation = (_one(name, each, kind) for each in _with_units(first, last))
        if not deviation > 0:
            raise ValueError(f"{name} must have an uncertainty above 0, got {short_repr(text)}")
        if kind in ("hardness", "modulus") and value < Z_95 * deviation:
            raise ValueError(
                f"{name} must be at least twice its standard uncertainty, since it is above 0, got "
                f"{short_repr(text)}; give the range that is meant, low..high"
            )
        return UncertainInput(value, value - Z_95 * deviation, value + Z_95 * deviation, "normal", text)
    value = _one(name, text, kind)
    if text.endswith("HRC"):
        return _widened(value, value, text)
    return UncertainInput(value, value, value, "exact", text)


def _widened(low: float, high: float, text: str) -> UncertainInput:
    """A hardness between ends that were converted from Rockwell's, with the uncertainty of the conversion."""
    half = math.hypot(0.5 * math.log(high / low), ROCKWELL_ERROR)
    value = math.sqrt(low * high)
    return UncertainInput(value, value * math.exp(-half), value * math.exp(half), "log-normal", text)


def _number(name: str, text: str) -> float:
    """A number of at most `MAX_NUMBER` that is not negative."""
    try:
        value = float(text)
    except ValueError:
        raise ValueError(f"{name} must be a number, got {short_repr(text)}") from None
    if not 0 <= value <= MAX_NUMBER:
        raise ValueError(f"{name} must be finite and from 0 to {MAX_NUMBER:g}, got {short_repr(text)}")
    return value


def _one(name: str, given: Any, kind: str) -> float:
    """A number that is not negative, with a unit where it is of a kind and text."""
    if isinstance(given, str) and not kind:
        return _number(name, given)
    scale = _UNIT.search(given) if kind == "hardness" and isinstance(given, str) else None
    if scale and scale[0] in ("HV", "HRC"):
        number = _number(name, given[: scale.start()].strip())
        if scale[0] == "HRC":
            if not min(_ROCKWELL) <= number <= max(_ROCKWELL):
                raise ValueError(
                    f"{name} must be from {min(_ROCKWELL)} to {max(_ROCKWELL)} HRC, got {short_repr(given)}"
                )
            number = math.exp(float(np.interp(number, list(_ROCKWELL), np.log(list(_ROCKWELL.values())))))
        return number * _VICKERS
    scales = "; also taken are HV and HRC" if kind == "hardness" else ""
    kind = "pressure" if kind else ""
    try:
        value = float(quantity(given, kind)) if kind and isinstance(given, str) else float(given)
    except (TypeError, ValueError, OverflowError) as error:
        said = f"{error}{scales}" if kind and isinstance(given, str) else f"must be a number, got {short_repr(given)}"
        raise ValueError(f"{name} {said}") from None
    if not (math.isfinite(value) and value >= 0):
        raise ValueError(f"{name} must be finite and not negative, got {short_repr(given)}")
    return value


def _with_units(first: str, last: str) -> tuple[str, str]:
    """Two texts, of which one unit may be for both."""
    units = [_UNIT.search(each) for each in (first, last)]
    if units[0] is None and units[1] is not None:
        return f"{first} {units[1][0]}", last
    if units[0] is not None and units[1] is None and units[0][0].strip() in ("HV", "HRC"):
        return first, f"{last} {units[0][0]}"
    return first, last


@functools.lru_cache(maxsize=32)
def sobol_points(dimensions: int, count: int = NUM_SAMPLES, *, seed: int = 0) -> Floats:
    """(count, dimensions) points of a scrambled Sobol sequence inside the unit cube; `count` is a power of two."""
    from scipy.stats import qmc

    points = qmc.Sobol(dimensions, rng=np.random.default_rng(seed)).random_base2(round(math.log2(count)))
    return read_only(np.clip(points, 1e-9, 1 - 1e-9))


def stratified_points(dimensions: int) -> Floats:
    """Return (NUM_SAMPLES, dimensions) points of a Sobol sequence in the unit cube, one in each stratum of a column."""
    return sobol_points(dimensions, NUM_SAMPLES, seed=2016)


def draw_samples(inputs: Mapping[str, UncertainInput]) -> dict[str, Floats]:
    """(NUM_SAMPLES,) values of each input."""
    points = stratified_points(len(inputs))
    return {name: each.quantile(points[:, place]) for place, (name, each) in enumerate(inputs.items())}


# ---- As a table of a study -------------------------------------------------------------------------------------------

KINDS: dict[str, Kind] = {
    "mu0": "", "tau0": "pressure", "hardness": "hardness", "effective_modulus": "modulus", "young": "modulus",
    "poisson": "", "creep": "", "junction_growth": "",
}  # fmt: skip
"""Inputs that may be ranges, and what they are."""


def parse_study_input(name: str, given: Any) -> UncertainInput:
    """Read what is known of an input by its name in `KINDS`; errors begin without the name."""
    found = parse_input("", given, KINDS[name])
    if name == "poisson":
        if found.high > MAX_POISSON:
            raise ValueError(f"must be from 0 to {MAX_POISSON:g} with its uncertainty, got {short_repr(given)}")
        found = replace(found, maximum=MAX_POISSON)
    if name == "junction_growth" and found.high > MAX_GROWTH:
        raise ValueError(f"must be from 0 to {MAX_GROWTH:g}, got {short_repr(given)}")
    if name == "creep" and found.high > MAX_CREEP:
        raise ValueError(f"must be at most {MAX_CREEP:g}, got {short_repr(given)}")
    return found


_Text = Annotated[str, Field(min_length=1, max_length=80)]
_Texts = Annotated[tuple[_Text, ...], as_tuple, Field(min_length=1, max_length=2)]


class UncertainInputsTable(Table):
    """What is known of inputs that are no single numbers; the study computes at their middle."""

    mu0: _Text | None = Field(default=None, description="Molecular friction coefficient, a range or value ± deviation.")
    tau0: _Text | None = Field(default=None, description="Adhesive shear strength.")
    hardness: _Text | None = Field(default=None, description="Of the softer body.")
    effective_modulus: _Text | None = Field(default=None, description="E*.")
    young: _Texts | None = Field(default=None, description="Young's modulus of the upper and the lower body.")
    poisson: _Texts | None = Field(default=None, description="Poisson's ratio of the upper and the lower body.")
    junction_growth: _Text | None = Field(default=None, description="α of junction growth, p² + α s² = H².")
    creep: _Text | None = Field(default=None, description="Exponent m of indentation creep: H = H(1 s) (t/1 s)^-m.")
    interface: str | None = Field(
        default=None, min_length=1, max_length=4096,
        description="Name or file of a strength, which is μ0 and τ0 jointly; without the file their ranges count.",
    )  # fmt: skip

    @field_validator("*")
    @classmethod
    def _says_what_is_parse_input(cls, value: Any, info: ValidationInfo) -> Any:
        texts = (value,) if isinstance(value, str) else value or ()
        for text in texts if info.field_name != "interface" else ():
            try:
                parse_study_input(str(info.field_name), text)
            except ValueError as error:
                raise ValueError(str(error).strip()) from None
        return value
