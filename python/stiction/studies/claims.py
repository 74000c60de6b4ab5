"""What the paper says of its own results, each claim as numbers with intervals and a verdict by a fixed rule.

Hanaor, Gan & Einav, Tribology International 93 (2016) 229. A claim has one or more parts, and a part is a number that
the claim wants within a range. A part is true where the number's 95 % interval lies within that range, false where it
lies outside, and undecided where an end of the range lies in the interval. A claim is true if all of its parts are,
false if one of them is, and undecided otherwise. The numbers and ranges were written down before any was computed.

Intervals are percentiles over resampled ensembles (bootstrap over the repetitions). A fractal dimension at which a
quantity has no value, or has none in more than one of forty resampled ensembles, because friction locks itself or the
load is not reached, is left out of the number, and the outcome says so.

That rule is at fault in two ways. The largest of many noisy values grows with the noise, so that its interval may
exclude the value itself; and above D = 1.65 a few pairs that nearly lock themselves carry a mean. So beside it stands
another (`Ruling` "bands"): the interval of an extreme over D is that of bands which hold all its values at once, and
D is at most 1.65 where asperities on profiles touch.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stiction._checks import choice, number
from stiction.mechanics.model import Sliding
from stiction.studies.claim_parts import PARTS, Band, Part
from stiction.studies.resampled import FLATTER, STEEPER, Resampled, Ruling, has_amplitudes
from stiction.studies.result import generated
from stiction.studies.study import Study, study_of

if TYPE_CHECKING:
    import xarray

Verdict = Literal["true", "false", "undecided", "undefined"]
FEWEST_REPETITIONS = 20
"""Fewer resample too narrowly for a verdict."""

CLAIMS = {
    1: "The true contact area is linear in the load, for every D.",
    2: "Friction grows with D, most for D > 1.5, and mu0 amplifies it.",
    3: "tau0 raises friction everywhere, most at low D and low load; up to 1 MPa it cannot be told from none.",
    4: "At high tau0 friction has a minimum at an intermediate D, about 1.3 to 1.5.",
    5: "At high D, friction is higher at low load.",
    6: "Friction can be lower than mu0.",
    7: "A larger amplitude lowers A/F_N, and at tau0 = 200 MPa friction; flatter surfaces show the rise at high D "
    "less, and the adhesion at low D more.",
    8: "mu0 and tau0 hardly change the area at a load, and the normal stiffness.",
}

VARIANTS: Mapping[str, Mapping[str, Any]] = {
    "default": {},
    "Ra": {"surfaces.amplitude_measure": "Ra"},
    "signed": {"contact.curvature": "signed"},
    "gap-minimum": {"contact.detection": "gap-minimum"},
    "band-limited": {"surfaces.band_limit": "nyquist"},
}
"""Choices that the paper leaves open, each as a change of the default ones."""


@dataclass(frozen=True)
class Column:
    """Other bodies or mechanics that the claims are judged on: a built-in study with changes, and a sliding rule.

    Attributes
    ----------
    study : str
    changes : mapping
        Of keys of the study.
    sliding : {"opposing", "all"}
    share : int
        Repetitions on lines with asperities for each one of these, which cost more.
    place : str
        Directory of the result; columns that differ in the sliding rule alone have one.
    """

    study: str
    changes: Mapping[str, Any]
    sliding: Sliding
    share: int
    place: str

    def of(self, repetitions: int) -> Study:
        """The study, with its share of the repetitions."""
        fewer = max(FEWEST_REPETITIONS, repetitions // self.share)
        return Study.named(self.study).with_changes({**self.changes, "ensemble.repetitions": fewer})


_AMPLITUDES = {"surfaces.amplitude": ["0.05 um", "0.1 um", "0.2 um"]}
_AREAS = {**_AMPLITUDES, "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 15}}
_HALF_PLANES = {
    "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.5, "count": 6},
    "surfaces.points": 65_536,
    "contact.load": {"start": "0.01 mN", "stop": "1 mN", "count": 5, "spacing": "geometric"},
}
_HALF_SPACES = {
    **_AMPLITUDES,
    "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 8},
    "surfaces.shape": [256, 256],
    "contact.mechanics": "half-space",
    "contact.load": {"start": "0.1 mN", "stop": "3 mN", "count": 5, "spacing": "geometric"},
}
_GAP_MINIMA = {"contact.detection": "gap-minimum"}
_ALL_RUB = {**_GAP_MINIMA, "contact.sliding": "all", "surfaces.fractal_dimension.count": 15}

COLUMNS: Mapping[str, Column] = {
    "lines, asperities, gap minima": Column("figure7", _GAP_MINIMA, "opposing", 20, "gap-minima"),
    "the same, all rub": Column("figure7", _ALL_RUB, "all", 20, "all-rub"),
    "areas, asperities": Column("figure6-areal", _AREAS, "opposing", 80, "areas"),
    "areas, asperities, all rub": Column("figure6-areal", _AREAS, "all", 80, "areas"),
    "half-planes": Column("figure6-half-plane", _HALF_PLANES, "opposing", 100, "half-planes"),
    "half-planes, all rub": Column("figure6-half-plane", _HALF_PLANES, "all", 100, "half-planes"),
    "half-spaces": Column("figure6-areal", _HALF_SPACES, "opposing", 66, "half-spaces"),
    "half-spaces, all rub": Column("figure6-areal", _HALF_SPACES, "all", 66, "half-spaces"),
}
"""By name."""


class ClaimsError(ValueError):
    """A study that claims cannot be judged on."""


def check(study: Study) -> None:
    """Raise a `ClaimsError`, before anything is computed, if claims cannot be judged on a study's result."""
    if "direction" in study.motions():
        raise ClaimsError("claims are judged on motion in one direction, and contact.direction is a list")
    if study.ensemble.repetitions < FEWEST_REPETITIONS:
        raise ClaimsError(
            f"claims need at least {FEWEST_REPETITIONS} ensemble.repetitions, got {study.ensemble.repetitions}"
        )
    steps = study.contact.steps()
    if steps.size < 3:
        raise ClaimsError(f"claims need at least 3 values of contact.{study.contact.step}, got {steps.size}")
    if study.contact.mechanics == "asperities" and not has_amplitudes(generated(study).amplitudes()):
        raise ClaimsError(f"claims need amplitudes of {FLATTER:g} and {STEEPER:g} µm among surfaces.amplitude")


def claims_study() -> Study:
    """The study that the claims are judged on: 50 fractal dimensions, three amplitudes, 100 repetitions."""
    return Study.named("figure7")


def variant_study(name: str) -> Study:
    """The same with another choice, at 15 fractal dimensions."""
    return claims_study().with_changes({"surfaces.fractal_dimension.count": 15, **VARIANTS[name]})


@dataclass(frozen=True)
class Outcome:
    """A part as it came out.

    Attributes
    ----------
    part : Part
    value, lower, upper : float
        The number and its 95 % interval; NaN where there is none.
    verdict : {"true", "false", "undecided", "undefined"}
    left_out : tuple of float
        Fractal dimensions without a value.
    """

    part: Part
    value: float
    lower: float
    upper: float
    verdict: Verdict
    left_out: tuple[float, ...]

    @classmethod
    def of(cls, part: Part, resampled: Resampled) -> Outcome:
        """Measure a part; it is undefined where the ensemble itself has no number."""
        resampled.left_out.clear()
        with np.errstate(divide="ignore", invalid="ignore"):
            values = part.measure(resampled)
        left_out = tuple(sorted(resampled.left_out))
        if isinstance(values, Band):
            value, lower, upper = values.value, values.lower, values.upper
        else:
            value, lower, upper = float(values[0]), math.nan, math.nan
            if math.isfinite(value):
                lower, upper = (float(end) for end in np.nanquantile(values[1:], [0.025, 0.975]))
        if not math.isfinite(value):
            return cls(part, math.nan, math.nan, math.nan, "undefined", left_out)
        inside = part.least < lower and upper < part.most
        outside = upper < part.least or lower > part.most
        return cls(part, value, lower, upper, "true" if inside else "false" if outside else "undecided", left_out)


def judge(
    dataset: xarray.Dataset,
    *,
    amplitude: float = 0.1,
    sliding: Sliding | None = None,
    ruling: Ruling = "percentiles",
) -> list[Outcome]:
    """Judge every part of every claim by a result.

    Parameters
    ----------
    dataset : xarray.Dataset
        Of a study such as `claims_study()`: fractal dimensions from 1 to 1.7, amplitudes 0.05, 0.1 and 0.2 µm.
    amplitude : float, µm
        The one that the claims which are not about amplitudes are judged at.
    sliding : {"opposing", "all"}, optional
        One of the result's sliding rules, by default the first.
    ruling : {"percentiles", "bands"}
        Of extremes over D, see above; bands are for D up to 1.65 where profiles touch at asperities.

    Raises
    ------
    ValueError
        If the result lacks an amplitude that is needed, or has fewer than 20 repetitions or 3 approaches.
    """
    check(study_of(dataset))
    choice("ruling", ruling, Ruling)
    amplitude = number("amplitude", amplitude, unit="µm", above=0)
    resampled = Resampled(dataset, amplitude, sliding=sliding, ruling=ruling)
    return [Outcome.of(part, resampled) for part in PARTS]


def verdict_of(claim: int, outcomes: list[Outcome]) -> Verdict:
    """True if all parts of a claim are, false if one is, undefined if one is and none is false; else undecided."""
    verdicts = {outcome.verdict for outcome in outcomes if outcome.part.claim == claim}
    for verdict in ("false", "undefined", "undecided"):
        if verdict in verdicts:
            return verdict
    return "true"
