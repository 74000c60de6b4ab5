"""Text and JSON on how scan resolution affects friction, with results at cutoffs, plastic limit and extrapolation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from stiction._estimate import Estimate
from stiction._number_format import format_percent, format_with_unit
from stiction.mechanics.friction import STATUS_OK
from stiction.views.layout import Paragraph, Table, TextRows, WrappedText
from stiction.views.point import SLIDING_RULE_TITLES, cutoff_text
from stiction.views.quantities import percent_text

if TYPE_CHECKING:
    from stiction.companions.resolution import ResolutionEffect, ResolvedRoughness, YieldWavelengthEstimate
    from stiction.study.study import Study


def resolution_paragraphs(resolution: ResolutionEffect, hardness: float | None, study: Study) -> list[Paragraph]:
    """Return paragraphs on resolved wavelengths, on friction at several cutoffs, and on the onset of yield.

    The last paragraph is returned only if no hardness is given.
    """
    paragraphs: list[Paragraph] = []
    scan = resolution.roughness
    if scan is not None:
        paragraphs.append([resolved_wavelengths_text(scan)])
    if resolution.cutoffs:
        table = Table(cut_off_rows(resolution, hardness))
        paragraphs.append([table, WrappedText(cut_off_note(resolution, study), indent="  ")])
    if scan is not None and resolution.yielding and (rows := yield_wavelength_rows(resolution.yielding[0][1], scan)):
        paragraphs.append([ELASTIC_RESULT_CAVEAT, Table(rows)])
    return paragraphs


# ---- Resolved wavelengths --------------------------------------------------------------------------------------------


def resolved_wavelengths_text(scan: ResolvedRoughness) -> str:
    """Return a sentence on resolved wavelengths, and on what the shortest octave adds to the mean square slope."""
    fraction = format_percent(scan.shortest_octave_fraction)
    return (
        f"Wavelengths from {format_with_unit(scan.shortest, 'um')} to {format_with_unit(scan.longest, 'um')}; "
        f"wavelengths below {format_with_unit(2 * scan.shortest, 'um')} contribute {fraction} of the gap's mean square "
        f"slope h'\N{SUPERSCRIPT TWO}."
    )


# ---- Cutoffs ---------------------------------------------------------------------------------------------------------


def cut_off_rows(resolution: ResolutionEffect, hardness: float | None) -> TextRows:
    """Return table rows with the friction at each cutoff wavelength, for the study's first load, mu0 and tau0.

    The last row is the plastic limit if there is a hardness (GPa).
    """
    first_values = resolution.cutoffs[0].at
    rules_by_name = {f"friction_{rule}": rule for rule in SLIDING_RULE_TITLES}
    rules = [rules_by_name[name] for name in resolution.cutoffs[0].values if name in rules_by_name]
    rows = [["cutoff", "h'", "A/A0", "mean pressure", *(f"μ_s {SLIDING_RULE_TITLES[rule]}" for rule in rules)]]
    for point in resolution.cutoffs:
        if any(point.at[name] != first_values[name] for name in ("load", "mu0", "tau0")):
            continue
        values, status = point.values, point.contact_status
        rows.append(
            [
                cutoff_text(point.cutoffs),
                str(Estimate(values["rms_gradient"])),
                percent_text(values["contact_area_fraction"]) if status == STATUS_OK else status,
                format_with_unit(values["mean_pressure"], "GPa"),
                *(_coefficient_text(values[f"friction_{rule}"]) for rule in rules),
            ]
        )
    if resolution.plastic_limit is not None and hardness is not None:
        friction_limit, area_limit = resolution.plastic_limit
        cells = ["plastic limit", "", percent_text(area_limit), format_with_unit(hardness, "GPa")]
        rows.append([*cells, *[""] * rules.index("all"), f"{friction_limit:.3f}"])
    return rows


def _coefficient_text(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "none"


def cut_off_note(resolution: ResolutionEffect, study: Study) -> str:
    """Return a note on a table of friction at cutoffs: surface pairs, load, meaning of the plastic limit."""
    count_text = study.member_names.with_count(resolution.members)
    load_text = format_with_unit(resolution.cutoffs[0].at["load"], "mN")
    text = f"The surfaces are low-pass filtered at the cutoff; means over {count_text}, at a load of {load_text}."
    if resolution.plastic_limit is not None:
        text += (
            " If small contacts are as hard as large ones, no finer scan gives less than the plastic limit. With "
            "friction at opposing contacts there is no such limit."
        )
    return text


# ---- Estimates of yielding for studies without a hardness ------------------------------------------------------------


def yield_wavelength_rows(estimates: Sequence[YieldWavelengthEstimate], scan: ResolvedRoughness) -> TextRows:
    """Return table rows by hardness: the wavelength below which contacts yield, and a lower bound on friction.

    Returns an empty list without estimates.
    """
    rows = []
    for estimate in estimates:
        wavelength = estimate.wavelength
        if math.isnan(wavelength.value):
            wavelength_text = "none, for these slopes"
        elif wavelength.value > scan.shortest:
            wavelength_text = "already in this scan"
        else:
            limits = wavelength.lower, min(wavelength.upper, scan.shortest)
            limit_texts = ", ".join(format_with_unit(limit, "um") for limit in limits)
            wavelength_text = f"{format_with_unit(wavelength.value, 'um')} [{limit_texts}]"
        rows.append([format_with_unit(estimate.hardness, "GPa"), wavelength_text, f"{estimate.friction:.3f}"])
    return [["hardness", "contacts yield below a wavelength of", "μ_s all contacts, at least"], *rows] if rows else []


ELASTIC_RESULT_CAVEAT = (
    "This result assumes elastic contact: finer scans have steeper slopes and less true area, without a limit. A "
    "hardness sets a limit: specify --hardness, or the names of the materials."
)


# ---- JSON record -----------------------------------------------------------------------------------------------------


def resolution_record(resolution: ResolutionEffect) -> dict[str, Any]:
    """Return the effect of scan resolution as JSON fields: wavelengths, friction at each cutoff, and onset of yield.

    The onset of yield is included only if no hardness is given.
    """
    record: dict[str, Any] = {}
    if (scan := resolution.roughness) is not None:
        record["wavelengths"] = {
            "shortest_um": scan.shortest,
            "longest_um": scan.longest,
            "rms_gradient": scan.gradient,
            "fraction_of_mean_square_slope_in_shortest_octave": scan.shortest_octave_fraction,
            "hurst_exponent": None if scan.estimate is None else scan.estimate.value,
        }
    if resolution.yielding:
        record["yielding"] = [
            coordinates
            | {
                "hardness": estimate.hardness, "wavelength": estimate.wavelength.to_record(),
                "min_friction": estimate.friction,
            }
            for coordinates, estimates in resolution.yielding
            for estimate in estimates
        ]  # fmt: skip
    if resolution.cutoffs:
        record["cutoffs"] = [point.at | point.values for point in resolution.cutoffs]
    return record
