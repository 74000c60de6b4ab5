"""Effect of the scan resolution on a measured pair: friction at several cutoffs, and extrapolation to finer scans."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction._estimate import Estimate
from stiction._units import exact_quantity_text
from stiction.evaluate.at_load import at_load
from stiction.evaluate.point import (
    compute_plastic_friction,
    effective_modulus_at,
    find_contact_status,
    get_study_hardness,
    iterate_points,
    list_rules_with_reported_first,
    mean_contact_pressure,
    mean_over_directions,
)
from stiction.mechanics import brackets
from stiction.mechanics.resolution import TYPICAL_HARDNESSES, spectral_resolution
from stiction.solve.companion_study import CompanionStudy
from stiction.solve.store import STUDY_FILE, StoredResult
from stiction.study.inputs import Inputs
from stiction.study.members import find_body_attributes, read_measured_bodies
from stiction.study.study import Study
from stiction.surfaces.hurst import HurstEstimate
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.missing_data import find_outliers, with_interpolated_points
from stiction.surfaces.pairing import to_joined_spectrum
from stiction.surfaces.scale import ScaleDependentRoughness, scale_dependent_roughness

if TYPE_CHECKING:
    import xarray

    from stiction.study.measured_bodies import ScanCutoffs

CUTOFF_STUDY_DIRECTORY = "resolution"
# Maximum number of members of a cutoff study: fewer for height maps, which take much longer to solve than lines.
MAX_CUTOFF_STUDY_MAP_MEMBERS = 4
MAX_CUTOFF_STUDY_LINE_MEMBERS = 16
# Maximum number of cutoffs in a cutoff study; each cutoff above 0 is twice the next smaller one.
MAX_CUTOFFS = 4
FOUR_DIGIT_ROUNDING_ERROR = 5e-4
MAX_CUTOFF_TO_SIDE_RATIO = 1 / 30


def build_cutoff_study(study: Study) -> Study | None:
    """Return a study that computes a measured pair at several cutoffs, for few members and the requested loads.

    The first cutoff is the cutoff of the original study. The second cutoff is the shortest resolved wavelength if the
    scans are unfiltered, or twice the first cutoff if they are filtered. Each further cutoff is twice the previous one.
    The members are the first members that consist of scans or, if there are none, surrogates. Returns None for
    generated bodies, for the asperity model, if the original study has several cutoffs, or if the scans are too short
    for a second cutoff.
    """
    if not study.is_measured or not study.uses_half_space:
        return None
    cutoffs = study.surfaces.cell_coordinates()["cut_off"].tolist()
    if len(cutoffs) > 1:
        return None
    attributes = find_body_attributes(study).attributes
    max_spacing = max(float(np.max(attributes[f"{side}_spacing_um"])) for side in ("upper", "lower"))
    side = min(float(np.min(attributes[f"{side}_extent_um"])) for side in ("upper", "lower"))
    candidate_cutoffs = (
        2 * max_spacing * 2.0 ** np.arange(MAX_CUTOFFS)
        if cutoffs[0] == 0
        else cutoffs[0] * 2.0 ** np.arange(1, MAX_CUTOFFS)
    )
    # Cutoffs are rounded up, so that none is shorter than two grid spacings, the shortest wavelength of a grid.
    rounded_cutoffs = [
        cutoffs[0],
        *(
            float(f"{cutoff * (1 + FOUR_DIGIT_ROUNDING_ERROR):.4g}")
            for cutoff in candidate_cutoffs
            if cutoff <= MAX_CUTOFF_TO_SIDE_RATIO * side
        ),
    ]
    if len(rounded_cutoffs) < 2:
        return None
    first_member = _find_first_scan_member(study)
    num_members = min(
        study.ensemble.repetitions - first_member,
        MAX_CUTOFF_STUDY_MAP_MEMBERS if study.is_areal else MAX_CUTOFF_STUDY_LINE_MEMBERS,
    )
    changes: dict[str, Any] = {
        "surfaces.cut_off": [exact_quantity_text(cutoff, "um") for cutoff in rounded_cutoffs],
        "contact.load": [load.text for load in study.friction.load],
        "ensemble.repetitions": num_members,
    }
    if study.surfaces.first_scan_member_index:
        changes["surfaces.surrogates"] = 0 if first_member else num_members
    return study.with_changes(changes)


def find_cutoff_study(study: Study, path: Path) -> CompanionStudy | None:
    """Return the cutoff study of a measured pair, with the directory in which the results of this study are stored.

    Returns None if the pair allows only one cutoff.
    """
    cutoff_study = build_cutoff_study(study)
    return None if cutoff_study is None else CompanionStudy(cutoff_study, path / CUTOFF_STUDY_DIRECTORY)


def _find_first_scan_member(study: Study) -> int:
    """Return the index of the first member that consists of scans instead of surrogates.

    Returns 0 if all members are surrogates.
    """
    index = study.surfaces.first_scan_member_index
    return index if index < study.ensemble.repetitions else 0


def evaluate_at_cutoffs(result: StoredResult) -> xarray.Dataset | None:
    """Evaluate friction and contact quantities of a measured pair at each cutoff of the stored cutoff study.

    Loads, mu0 and tau0 are those of the pair. Returns None if no cutoff study of this pair is stored.
    """
    study = result.study
    if not study.is_measured:
        return None
    if not (result.path / CUTOFF_STUDY_DIRECTORY / STUDY_FILE).exists():
        return None
    try:
        cutoff_study = find_cutoff_study(study, result.path)
    except ValueError:
        # `find_cutoff_study` fails if a scan file is missing.
        return None
    cutoff_sums = None if cutoff_study is None else cutoff_study.open(allow_unfinished=True)
    if cutoff_sums is None:
        return None
    return at_load(
        cutoff_sums,
        [float(load) for load in study.friction.load],
        mu0=list(study.friction.mu0),
        tau0=[float(strength) for strength in study.friction.tau0],
    )


# ---- Resolved roughness ---------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class ResolvedRoughness:
    """Roughness of the gap at the wavelengths that the scans contain, and its extrapolation to shorter wavelengths."""

    # Shortest resolved wavelength (µm): the cutoff or two grid spacings, whichever is larger.
    shortest: float
    two_points: float  # two grid spacings, µm
    longest: float  # µm
    gradient: float
    roughness: ScaleDependentRoughness
    # Estimate of the Hurst exponent; None if the spectrum has no self-affine band.
    estimate: HurstEstimate | None

    @property
    def shortest_octave_fraction(self) -> float:
        """Fraction of the gap's mean square slope that comes from the octave of the shortest wavelengths."""
        return float(self.roughness.fraction_below(2 * self.shortest))

    def find_yield_wavelength(self, ratio: float, contact_count: float) -> tuple[float, float, float]:
        """Estimate the cutoff (µm) at which the elastic pressure is `ratio` times the pressure without a cutoff.

        The scans contain all wavelengths from the shortest resolved one. Returns the cutoff with its lower and upper
        limit.
        """
        gradient = ratio * float(self.roughness.gradient_at(self.shortest))
        kappa_factor = float(brackets.kappa_uncertainty_factor(np.array(contact_count)))
        return brackets.plastic_wavelength(self.roughness, self.estimate, gradient, kappa_factor)

    def extrapolate_to_finer_scans(self, area_fraction: float, contact_count: float) -> tuple[Floats, Floats, Floats]:
        """Extrapolate the gap's rms gradient, and the area fraction of elastic contacts, to finer scans.

        Returns the shortest wavelengths (µm) of the finer scans, the gradients, and the area fractions. Gradients and
        area fractions are triples of value, lower limit and upper limit.
        """
        gradients = brackets.extrapolated_gradients(self.roughness, self.estimate, self.shortest, self.gradient)
        flat_fraction = np.array([area_fraction * self.gradient]) / brackets.developed_interface_area_ratio(
            np.array(self.gradient)
        )
        area_fractions = brackets.elastic_area_fraction(
            gradients, flat_fraction, brackets.kappa_uncertainty_factor(np.array([contact_count]))
        )[:, 0]
        area_fractions = area_fractions * brackets.developed_interface_area_ratio(gradients[:, :1])
        return np.array(brackets.EXTRAPOLATED_WAVELENGTH_RATIOS) * self.shortest, gradients, area_fractions


def find_resolved_roughness(study: Study) -> ResolvedRoughness | None:
    """Compute the roughness of the gap at the wavelengths that the scans contain, and extrapolate to shorter ones.

    Returns None if the bodies are generated or scan files are missing.
    """
    if not study.is_measured:
        return None
    try:
        return _compute_resolved_roughness(study)
    except (ValueError, OSError):
        return None


@functools.lru_cache(maxsize=4)
def _compute_resolved_roughness(study: Study) -> ResolvedRoughness:
    surfaces: Any = study.surfaces
    bodies = read_measured_bodies(study)
    cut_off = surfaces.reported_cut_off()
    upper, lower = bodies.member(_find_first_scan_member(study), cut_off).pair
    gap = replace(upper, heights=upper.heights - lower.heights, history=(), missing=None)
    gap = with_interpolated_points(gap, find_outliers(gap.heights))
    attributes = bodies.attributes.attributes
    spacings = [*gap.spacings, *(float(np.max(attributes[f"{side}_spacing_um"])) for side in ("upper", "lower"))]
    roughness = scale_dependent_roughness(gap)
    return ResolvedRoughness(
        shortest=max(2 * max(spacings), cut_off), two_points=2 * max(spacings), longest=float(np.max(gap.extent)),
        gradient=brackets.gap_rms_gradient(gap, periodic=False), roughness=roughness,
        estimate=brackets.estimate_gap_hurst_exponent(gap, periodic=False),
    )  # fmt: skip


# ---- Limits that finer scans would have ----------------------------------------------------------------------------


def find_plastic_limit(point: xarray.Dataset, study: Study) -> tuple[float, float] | None:
    """Return lower bounds of mu_s and of the true area fraction for all finer scans, if the bodies yield.

    With friction at all contacts, the bound of mu_s is mu0 + tau0/H'. If the interface is stronger than the softer body
    with shear strength k, the bound is k/(H/2). The bound of the area fraction is p/H, where p is the nominal pressure.
    Returns None if the contacts cannot yield.
    """
    if (plastic_friction := compute_plastic_friction(point, study)) is None:
        return None
    area_fraction = float(point["load"]) / (get_study_hardness(study) * float(point["nominal_area"]))
    return plastic_friction, area_fraction


@dataclass(frozen=True)
class YieldWavelengthEstimate:
    """Cutoff below which elastic contacts would yield at a given hardness, and the friction of yielding contacts."""

    hardness: float
    # Cutoff (µm) below which elastic contacts would yield; NaN if the mean pressure stays below the hardness.
    wavelength: Estimate
    friction: float


@dataclass(frozen=True)
class CutoffResult:
    """Friction, roughness, area fraction and pressure of a pair at one cutoff, load, mu0 and tau0."""

    at: dict[str, float]
    values: dict[str, float]
    contact_status: str
    cutoffs: ScanCutoffs  # µm


@dataclass(frozen=True, eq=False)
class ResolutionEffect:
    """Effect of scan resolution: friction of a measured pair at several cutoffs, and friction limits for finer scans.

    Attributes
    ----------
    roughness : ResolvedRoughness, optional
    cutoffs : tuple of CutoffResult
        Means over a few members at several cutoffs; empty without a cutoff study.
    members : float
        Number of members of the cutoff study.
    plastic_limit : (float, float), optional
        Lower bounds for finer scans, at the first load, mu0 and tau0: coefficient with friction at all contacts, and
        area fraction. None if the study has no hardness.
    yielding : tuple of (dict, tuple of YieldWavelengthEstimate)
        Estimates for typical hardnesses at the load, mu0 and tau0 of each point; empty with a hardness.
    """

    roughness: ResolvedRoughness | None
    cutoffs: tuple[CutoffResult, ...] = ()
    members: float = math.nan
    plastic_limit: tuple[float, float] | None = None
    yielding: tuple[tuple[dict[str, float], tuple[YieldWavelengthEstimate, ...]], ...] = ()


def find_resolution_effect(at: xarray.Dataset, study: Study, cutoffs: xarray.Dataset | None) -> ResolutionEffect | None:
    """Return how friction depends on scan resolution: friction at several cutoffs, and limits for finer scans.

    `cutoffs` is the dataset that `evaluate_at_cutoffs` or, for several cutoffs, `Result.at` returned. Without this
    dataset, the function returns None if the roughness of the gap is not known either.
    """
    roughness = find_resolved_roughness(study)
    if roughness is None and cutoffs is None:
        return None
    yield_estimates: list[tuple[dict[str, float], tuple[YieldWavelengthEstimate, ...]]] = []
    if roughness is not None and study.uses_half_space and study.contact.hardness is None:
        for point in iterate_points(at.isel(cut_off=[0]) if "cut_off" in at.dims else at):
            coordinates = {name: float(point[name]) for name in ("load", "mu0", "tau0")}
            yield_estimates.append((coordinates, estimate_yield_wavelengths(point, study, roughness)))
    if cutoffs is None:
        return ResolutionEffect(roughness, yielding=tuple(yield_estimates))
    first_loads = cutoffs.isel(dict.fromkeys(("load", "mu0", "tau0"), 0))
    return ResolutionEffect(
        roughness=roughness, cutoffs=tuple(_build_cutoff_result(point, study) for point in iterate_points(cutoffs)),
        members=mean_over_directions(cutoffs, "members"),
        plastic_limit=find_plastic_limit(first_loads, study), yielding=tuple(yield_estimates),
    )  # fmt: skip


def _build_cutoff_result(point: xarray.Dataset, study: Study) -> CutoffResult:
    numbers = {name: mean_over_directions(point, name) for name in ("rms_gradient", "contact_area_fraction")}
    numbers["mean_pressure"] = mean_contact_pressure(point)
    for rule in list_rules_with_reported_first(study):
        numbers[f"friction_{rule}"] = mean_over_directions(point.sel(sliding=rule), "mean_friction")
    at = {name: float(point[name]) for name in ("cut_off", "load", "mu0", "tau0")}
    surfaces: Any = study.surfaces
    return CutoffResult(at, numbers, find_contact_status(point, study), surfaces.get_scan_cut_offs(at["cut_off"]))


def estimate_yield_wavelengths(
    point: xarray.Dataset, study: Study, resolved_roughness: ResolvedRoughness
) -> tuple[YieldWavelengthEstimate, ...]:
    """Estimate the cutoff (µm) at which the elastic pressure equals the hardness, for several typical hardnesses.

    At such a wavelength λ, the elastic mean pressure E* h'(λ)/κ equals the hardness, where κ is the value for this
    result.
    """
    modulus, pressure = effective_modulus_at(point, study), mean_contact_pressure(point)
    if not pressure > 0:
        return ()
    contact_count = mean_over_directions(point, "contact_count")
    law = Inputs.from_study(study).friction_law(float(point["mu0"]), float(point["tau0"]))
    return tuple(
        YieldWavelengthEstimate(
            hardness,
            Estimate(
                *resolved_roughness.find_yield_wavelength(hardness / pressure, contact_count),
                name="yield_wavelength",
                unit="um",
                kind="fit",
            ),
            law.plastic_coefficient(hardness),
        )
        for hardness in TYPICAL_HARDNESSES
        if hardness < modulus / 2
    )


@dataclass(frozen=True, eq=False)
class ResolutionLimits:
    """Friction coefficients of a pair at several cutoffs under one load, and limits of the coefficient for finer scans.

    Attributes
    ----------
    points : xarray.Dataset
        Values at the cutoffs.
    plastic_limit : (float, float) or None
        Coefficient and area fraction at the plastic limit, as returned by `find_plastic_limit`.
    shortest : float or None, µm
        Shortest wavelength that the scans resolve at any of the cutoffs, or None if the files are missing.
    wavelengths : (n,) ndarray of float, µm
        Shortest wavelengths of finer scans; empty with a hardness.
    friction, area_fractions : (n, 3) ndarray of float
        Elastic results of finer scans, extrapolated with the Hurst exponent: value, lower and upper limit. The
        coefficients are computed with friction at all contacts.
    spectral : xarray.Dataset or None
        Result of `spectral_resolution` for joined spectra of several scans.
    """

    points: xarray.Dataset
    plastic_limit: tuple[float, float] | None
    shortest: float | None
    spectral: xarray.Dataset | None
    wavelengths: Floats = field(default_factory=lambda: np.empty(0))
    friction: Floats = field(default_factory=lambda: np.empty((0, 3)))
    area_fractions: Floats = field(default_factory=lambda: np.empty((0, 3)))


def find_resolution_limits(points: xarray.Dataset, study: Study) -> ResolutionLimits:
    """Estimate limits of the friction coefficient that finer scans would give, at one load, mu0 and tau0.

    The estimates are computed from the results at several cutoff wavelengths, and from the spectra of the scans.
    """
    roughness = find_resolved_roughness(study)
    shortest_cutoff = float(np.min(points["cut_off"].values)) if "cut_off" in points.coords else 0.0
    limits = ResolutionLimits(
        points,
        plastic_limit=find_plastic_limit(points, study),
        shortest=None if roughness is None else max(roughness.two_points, shortest_cutoff),
        spectral=_estimate_friction_from_spectra(points, study),
    )
    first_point = points.isel(cut_off=0)
    area_fraction = mean_over_directions(first_point, "contact_area_fraction")
    if limits.plastic_limit is not None or roughness is None or not area_fraction > 0 or not study.uses_half_space:
        return limits
    wavelengths, gradients, area_fractions = roughness.extrapolate_to_finer_scans(
        area_fraction, mean_over_directions(first_point, "contact_count")
    )
    nominal_pressure = float(points["load"]) / float(points["nominal_area"])
    flat_area_fractions = area_fractions / brackets.developed_interface_area_ratio(gradients[:, :1])
    coefficients = float(points["mu0"]) + float(points["tau0"]) * flat_area_fractions / nominal_pressure
    coefficients *= brackets.transverse_slope_factor(gradients[:, :1], roughness.roughness.dimensions)
    return replace(limits, wavelengths=wavelengths, friction=coefficients, area_fractions=area_fractions)


def _estimate_friction_from_spectra(dataset: xarray.Dataset, study: Study) -> xarray.Dataset | None:
    """Estimate the friction of a pair from the joined spectra of its scans, without solving the contact.

    A joined spectrum combines several scans of a body.

    Returns None if neither body has a joined spectrum.
    """
    files = [getattr(study.surfaces, side, None) for side in ("upper", "lower")]
    try:
        bodies = [file.read() for file in files if file is not None]
    except (ValueError, OSError):
        return None
    pressure, hardness = float(dataset["load"]) / float(dataset["nominal_area"]), get_study_hardness(study)
    if not any(isinstance(body, JoinedSpectrum) for body in bodies) or hardness <= pressure:
        return None
    upper, lower = (to_joined_spectrum(body).roughness() for body in bodies)
    return spectral_resolution(
        upper, lower, pressure=pressure, hardness=None if math.isnan(hardness) else hardness, mu0=float(dataset["mu0"]),
        tau0=float(dataset["tau0"]), effective_modulus=effective_modulus_at(dataset, study),
    )  # fmt: skip
