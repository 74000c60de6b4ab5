"""Effect of the scan resolution on a pair: cutoff study, plastic limit, and extrapolation to shorter wavelengths."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stiction._number_format import format_estimate, format_percent, format_with_unit
from stiction.mechanics.friction import STATUS_OK
from stiction.studies.point import contact_status_of, hardness_of, points, pressure_of, rules_of, value_of
from stiction.studies.resolution import ResolvedRoughness, plastic_limit, yield_estimates

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study
    from stiction.studies.summary import Summary

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


def resolution_record(summary: Summary) -> dict[str, Any] | None:
    """Return a JSON record of the resolution: wavelengths, cutoffs and, without a hardness, yield estimates."""
    dataset, study, cutoff_dataset = summary.at, summary.study, summary.over_cut_offs
    scan = summary.resolved_roughness
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
