"""How finely a measured pair was seen: a second, small study over cut-offs, and the gap's slopes over wavelength."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction._units import exact_text
from stiction.mechanics import brackets
from stiction.studies.evaluation import at_load
from stiction.studies.members import body_attributes, load_bodies
from stiction.studies.result import Result
from stiction.studies.store import STUDY_FILE, StoredResult, StoreError, open_stored
from stiction.studies.study import Study, find_member_differences
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.scale import ScaleDependentRoughness, scale_dependent_roughness

if TYPE_CHECKING:
    import xarray

CUTOFF_STUDY_FOLDER = "resolution"  # in the folder of a result: that of the same pair over cut-offs
NUM_AREAL_MEMBERS = 4  # of areas; the first ones of the result, so that what changes with the cut-off is not chance
NUM_LINE_MEMBERS = 16  # of lines
MAX_CUTOFFS = 4  # times that the shortest cut-off, of two points, is doubled at most
FOUR_DIGIT_ERROR = 5e-4  # relative change of a number by rounding it to four digits, at most
MAX_RELATIVE_CUTOFF = 1 / 30  # longest cut-off over the shortest side of the scans: longer waves are too few


def build_cutoff_study(study: Study) -> Study | None:
    """The study of the same pair over cut-offs, two points and their doubles, for few members and the loads asked for.

    None of generated bodies, of asperities, of several cut-offs, and where the scans are too short for any.
    """
    if not study.is_measured or not study.uses_half_space:
        return None
    own = study.surfaces.cells()["cut_off"].tolist()
    facts = body_attributes(study).attributes
    step = max(float(np.max(facts[f"{side}_spacing_um"])) for side in ("upper", "lower"))
    side = min(float(np.min(facts[f"{side}_extent_um"])) for side in ("upper", "lower"))
    if len(own) > 1:
        return None
    doubles = 2 * step * 2.0 ** np.arange(MAX_CUTOFFS) if own[0] == 0 else own[0] * 2.0 ** np.arange(1, MAX_CUTOFFS)
    # Rounded up, because less than two points is no wave.
    lengths = [
        own[0],
        *(float(f"{each * (1 + FOUR_DIGIT_ERROR):.4g}") for each in doubles if each <= MAX_RELATIVE_CUTOFF * side),
    ]
    if len(lengths) < 2:
        return None
    changes: dict[str, Any] = {
        "surfaces.cut_off": [exact_text(each, "um") for each in lengths],
        "contact.load": [load.text for load in study.friction.load],
        "ensemble.repetitions": min(
            study.ensemble.repetitions, NUM_AREAL_MEMBERS if study.is_areal else NUM_LINE_MEMBERS
        ),
    }  # fmt: skip
    if study.surfaces.first_scanned:
        changes["surfaces.surrogates"] = 0
    return study.with_changes(changes)


def evaluate_cutoffs(result: StoredResult) -> xarray.Dataset | None:
    """What a result, or that in its folder, says over cut-offs at the loads of its study; None without one."""
    study = result.study
    if not study.is_measured:
        return None
    loads = [float(load) for load in study.friction.load]
    if study.surfaces.cells()["cut_off"].size > 1:
        return at_load(Result(result), loads)
    folder = Path(result.path) / CUTOFF_STUDY_FOLDER
    if not (folder / STUDY_FILE).exists():
        return None
    try:
        beside = open_stored(folder)
        wanted = build_cutoff_study(study)
    except (StoreError, ValueError):
        return None
    if not beside.finished.size or wanted is None or find_member_differences(beside.study, wanted):
        return None
    return at_load(
        Result(beside), loads, mu0=list(study.friction.mu0), tau0=[float(each) for each in study.friction.tau0]
    )


# ---- Without pressing anything ---------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ResolvedRoughness:
    """What of the gap of a pair was seen: its waves, and how it goes on below them."""

    shortest: float  # µm, of the pressed bodies: two points, or the cut-off
    longest: float  # µm, their longest side
    gradient: float  # root-mean-square gradient of the gap of one member
    roughness: ScaleDependentRoughness
    estimate: HurstEstimate | None  # of the gap; None where its spectrum has no self-affine band

    def fraction_below(self, wavelength: float) -> float:
        """Fraction of the gap's mean square gradient that is of waves shorter than this (µm)."""
        return float(self.roughness.fraction_below(wavelength))

    def yields_at(self, ratio: float, contact_count: float) -> tuple[float, float, float]:
        """Wavelength (µm), with interval, down to which waves make the elastic pressure so many times the scan's."""
        gradient = ratio * float(self.roughness.gradient_at(self.shortest))
        spread = float(brackets.kappa_spread(np.array(contact_count)))
        return brackets.plastic_wavelength(self.roughness, self.estimate, gradient, spread)

    def finer(self, area_fraction: float, contact_count: float) -> tuple[Floats, Floats, Floats]:
        """Wavelengths (µm) of finer, elastic scans, and (value, lower, upper) of their gradients and area fractions."""
        gradients = brackets.extrapolated_gradients(self.roughness, self.estimate, self.shortest, self.gradient)
        flat = np.array([area_fraction * self.gradient]) / brackets.interface_stretch(np.array(self.gradient))
        ground = brackets.elastic_area(gradients, flat, brackets.kappa_spread(np.array([contact_count])))[:, 0]
        ground = ground * brackets.interface_stretch(gradients[:, :1])
        return np.array(brackets.WAVELENGTH_RATIOS) * self.shortest, gradients, ground


def find_resolved_roughness(study: Study) -> ResolvedRoughness | None:
    """What was seen of the gap of a measured pair; None of generated bodies, and where the files are gone."""
    if not study.is_measured:
        return None
    try:
        return _find_resolved_roughness(study)
    except (ValueError, OSError):
        return None


@functools.lru_cache(maxsize=4)
def _find_resolved_roughness(study: Study) -> ResolvedRoughness:
    surfaces: Any = study.surfaces
    bodies = load_bodies(study)
    wavelength = surfaces.quoted_cut_off()
    # Two maps themselves, where there are such members.
    first = surfaces.first_scanned
    index = first if first < study.ensemble.repetitions else 0
    upper, lower = bodies.member(index, wavelength).pair
    gap = replace(upper, heights=upper.heights - lower.heights, history=(), missing=None)
    facts = bodies.attributes().attributes
    steps = [*gap.spacings, *(float(np.max(facts[f"{each}_spacing_um"])) for each in ("upper", "lower"))]
    roughness = scale_dependent_roughness(gap)
    return ResolvedRoughness(
        shortest=max(2 * max(steps), wavelength), longest=float(np.max(gap.extent)),
        gradient=brackets.rms_gradient(gap, periodic=False), roughness=roughness,
        estimate=brackets.gap_exponent(gap, periodic=False),
    )  # fmt: skip
