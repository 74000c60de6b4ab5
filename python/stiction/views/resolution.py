"""Effect of the scan resolution on a pair: cutoff study, plastic limit, and extrapolation to shorter wavelengths."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import format_estimate, format_percent, format_with_unit
from stiction.mechanics.brackets import friction_stretch, interface_stretch
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.resolution import TYPICAL_HARDNESSES, spectral_resolution
from stiction.studies.point import (
    contact_status_of,
    hardness_of,
    modulus_of,
    plastic_adhesion,
    points,
    pressure_of,
    rules_of,
    value_of,
)
from stiction.studies.resolution import ResolvedRoughness, find_resolved_roughness
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.pairing import to_joined_spectrum

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

Rows = list[list[str]]
RULE_TITLES = {"all": "all contacts", "opposing": "opposing contacts"}


# ---- Waves -----------------------------------------------------------------------------------------------------------


def wavelengths_text(scan: ResolvedRoughness) -> str:
    """Return the range of resolved wavelengths, and the contribution of the shortest octave to the slope."""
    fraction = format_percent(scan.fraction_below(2 * scan.shortest))
    return (
        f"Wavelengths from {format_with_unit(scan.shortest, 'um')} to {format_with_unit(scan.longest, 'um')}; "
        f"wavelengths below {format_with_unit(2 * scan.shortest, 'um')} contribute {fraction} of the gap's mean square "
        f"slope h'\N{SUPERSCRIPT TWO}."
    )


# ---- Cutoffs ---------------------------------------------------------------------------------------------------------


def cut_off_rows(dataset: xarray.Dataset, study: Study) -> Rows:
    """Return a table with one row per cutoff of `evaluate_cutoffs`, for one load, mu0 and tau0; headings come first.

    The last row is the plastic limit if there is a hardness.
    """
    rules = rules_of(study)
    rows = [["cutoff", "h'", "A/A0", "mean pressure", *(f"μ_s {RULE_TITLES[rule]}" for rule in rules)]]
    for point in points(dataset):
        friction = point["friction_all_round"]
        cut_off, status = float(point["cut_off"]), contact_status_of(point, study)
        rows.append(
            [
                format_with_unit(cut_off, "um") if cut_off else "none",
                format_estimate(value_of(point, "rms_gradient")),
                format_percent(value_of(point, "contact_area_fraction")) if status == STATUS_OK else status,
                format_with_unit(pressure_of(point), "GPa"),
                *(_coefficient(float(friction.sel(sliding=rule, statistic="mean"))) for rule in rules),
            ]
        )
    limit = plastic_limit(dataset, study)
    if limit is not None:
        hardness = hardness_of(study)
        area = float(dataset["load"]) / hardness / float(dataset["nominal_area"])
        rows.append(["plastic limit", "", format_percent(area), format_with_unit(hardness, "GPa"), f"{limit:.3f}"])
    return rows


def _coefficient(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "none"


def plastic_limit(point: xarray.Dataset, study: Study) -> float | None:
    """Return mu0 + tau0/H', the lower bound for finer scans with friction at all contacts; None without a hardness."""
    adhesion = plastic_adhesion(point, study)
    return None if adhesion is None else float(point["mu0"]) + adhesion


def cut_off_records(dataset: xarray.Dataset, study: Study) -> list[dict[str, Any]]:
    """Return the results at each cutoff as JSON records, in µm and GPa."""
    records = []
    for point in points(dataset):
        numbers = {name: value_of(point, name) for name in ("rms_gradient", "contact_area_fraction")}
        numbers["mean_pressure"] = pressure_of(point)
        for rule in rules_of(study):
            numbers[f"friction_{rule}"] = value_of(point.sel(sliding=rule), "friction_all_round")
        coordinates: dict[str, Any] = {name: float(point[name]) for name in ("cut_off", "load", "mu0", "tau0")}
        records.append(coordinates | numbers)
    return records


def cut_off_note(dataset: xarray.Dataset, study: Study) -> str:
    """Return the note below the table of cutoffs."""
    members = value_of(dataset, "members")
    text = f"Both surfaces are low-pass filtered at the cutoff; means over {members:.0f} members."
    if plastic_limit(dataset, study) is not None:
        text += " No finer scan exceeds the plastic limit. With friction at opposing contacts there is no such limit."
    return text


# ---- Without a hardness ----------------------------------------------------------------------------------------------


def yield_estimates(
    point: xarray.Dataset, study: Study, scan: ResolvedRoughness
) -> list[tuple[float, float, float, float, float]]:
    """Estimate the wavelength at which the pressure reaches each of the typical hardnesses H, and mu0 + tau0/H.

    At this wavelength (µm), the elastic mean pressure E* h'(λ)/κ, with κ of this result, equals the hardness (GPa). The
    wavelength is NaN if the slope never becomes large enough.
    """
    modulus, pressure = modulus_of(point, study), pressure_of(point)
    if not pressure > 0:
        return []
    count = value_of(point, "contact_count")
    mu0, tau0 = float(point["mu0"]), float(point["tau0"])
    return [
        (hardness, *scan.find_plastic_wavelength(hardness / pressure, count), mu0 + tau0 / hardness)
        for hardness in TYPICAL_HARDNESSES
        if hardness < modulus / 2
    ]


def yield_rows(point: xarray.Dataset, study: Study, scan: ResolvedRoughness) -> Rows:
    """Return a table of `yield_estimates`, with headings first; empty if there are no estimates."""
    rows = []
    for hardness, wave, low, high, limit in yield_estimates(point, study, scan):
        if math.isnan(wave):
            reached = "never, for these slopes"
        elif wave > scan.shortest:
            reached = "this scan already"
        else:
            ends = ", ".join(format_with_unit(end, "um") for end in (low, min(high, scan.shortest)))
            reached = f"{format_with_unit(wave, 'um')} [{ends}]"
        rows.append([format_with_unit(hardness, "GPa"), reached, f"{limit:.3f}"])
    return [["if the hardness is", "it yields at a wavelength of", "μ_s all contacts, at least"], *rows] if rows else []


ELASTIC_CAVEAT = (
    "This result is elastic: a finer scan has steeper slopes and less area, without a limit. A hardness sets a limit: "
    "give --hardness, or materials by name."
)


def yield_records(point: xarray.Dataset, study: Study, scan: ResolvedRoughness) -> list[dict[str, Any]]:
    """Return `yield_estimates` as records, in GPa and µm."""
    return [
        {
            "load": float(point["load"]),
            "mu0": float(point["mu0"]),
            "tau0": float(point["tau0"]),
            "hardness": hardness,
            "reached_at_um": wave,
            "lower": low,
            "upper": high,
            "friction_all_at_least": limit,
        }
        for hardness, wave, low, high, limit in yield_estimates(point, study, scan)
    ]


# ---- Whole record ------------------------------------------------------------------------------------------------


def resolution_record(
    dataset: xarray.Dataset, study: Study, cutoff_dataset: xarray.Dataset | None
) -> dict[str, Any] | None:
    """Return a JSON record of the resolution: wavelengths, cutoffs and, without a hardness, yield estimates."""
    scan = find_resolved_roughness(study)
    if scan is None and cutoff_dataset is None:
        return None
    record: dict[str, Any] = {}
    if scan is not None:
        record["waves"] = {
            "shortest_um": scan.shortest,
            "longest_um": scan.longest,
            "rms_gradient": scan.gradient,
            "fraction_of_mean_square_slope_in_shortest_octave": scan.fraction_below(2 * scan.shortest),
            "hurst_exponent": None if scan.estimate is None else scan.estimate.value,
        }
        if study.uses_half_space and study.contact.hardness is None:
            unfiltered = dataset.isel(cut_off=[0]) if "cut_off" in dataset.dims else dataset
            record["yielding"] = [
                estimate for point in points(unfiltered) for estimate in yield_records(point, study, scan)
            ]
    if cutoff_dataset is not None:
        record["cut_offs"] = cut_off_records(cutoff_dataset, study)
    return record


def resolution_limits(dataset: xarray.Dataset, study: Study) -> dict[str, Any]:
    """Return the limits for the figure of results against cutoff, as a dictionary of arrays.

    `dataset` is a result of `evaluate_cutoffs` at one load, mu0 and tau0. Keys: ``friction`` and ``area_fraction``, the
    plastic limit (None without a hardness); ``shortest``, the shortest resolved wavelength in µm (None if files are
    missing); ``wavelength`` (µm), ``finer_area_fraction`` and ``finer_friction`` (rule "all"), arrays (n, 3) with
    value, lower and upper end of the elastic result extrapolated by the Hurst exponent (empty with a hardness);
    ``spectral``, the result of `spectral_resolution` for joined spectra of several scans (None for single scans).
    """
    limit, scan = plastic_limit(dataset, study), find_resolved_roughness(study)
    table: dict[str, Any] = {
        "friction": limit,
        "area_fraction": None,
        "shortest": None if scan is None else scan.shortest,
        "wavelength": np.empty(0),
        "finer_area_fraction": np.empty((0, 3)),
        "finer_friction": np.empty((0, 3)),
        "spectral": _spectral_estimate(dataset, study),
    }
    area, load = float(dataset["nominal_area"]), float(dataset["load"])
    if limit is not None:
        hardness = hardness_of(study)
        return table | {"area_fraction": load / hardness / area}
    fraction = value_of(dataset.isel(cut_off=0), "contact_area_fraction")
    if scan is None or not fraction > 0 or not study.uses_half_space:
        return table
    wavelengths, gradients, fractions = scan.extrapolate(fraction, value_of(dataset.isel(cut_off=0), "contact_count"))
    steepness = gradients[:, :1]
    friction = float(dataset["mu0"]) + float(dataset["tau0"]) * fractions / interface_stretch(steepness) * area / load
    friction *= friction_stretch(steepness, scan.roughness.dimensions)
    return table | {"wavelength": wavelengths, "finer_area_fraction": fractions, "finer_friction": friction}


def _spectral_estimate(dataset: xarray.Dataset, study: Study) -> xarray.Dataset | None:
    """Return the closed-form estimate for two spectra, if at least one of them joins several scans."""
    files = [getattr(study.surfaces, side, None) for side in ("upper", "lower")]
    try:
        bodies = [file.read() for file in files if file is not None]
    except (ValueError, OSError):
        return None
    pressure, hardness = float(dataset["load"]) / float(dataset["nominal_area"]), hardness_of(study)
    if not any(isinstance(body, JoinedSpectrum) for body in bodies) or hardness <= pressure:
        return None
    upper, lower = (to_joined_spectrum(body).roughness() for body in bodies)
    return spectral_resolution(
        upper, lower, pressure=pressure, hardness=None if math.isnan(hardness) else hardness, mu0=float(dataset["mu0"]),
        tau0=float(dataset["tau0"]), effective_modulus=modulus_of(dataset, study),
    )  # fmt: skip
