"""Report on measured surfaces with sliders for mu0 and tau0: friction, other quantities, and assessments."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import format_load, format_with_unit
from stiction._text import printable_text
from stiction.mechanics import friction
from stiction.mechanics.quantities import QUANTITIES, STIFFNESS_PER_AREA_QUANTITIES
from stiction.study.member_names import POSITION_NAMES, SURROGATE_PAIR_NAMES
from stiction.summary.report_data import MAX_DESCRIBED_FILE_READINGS, BodyHistory, ReportDataOfMeasuredSurfaces
from stiction.summary.report_values import STATUSES_BY_CODE, ReportValuesOfMeasuredSurfaces, is_shown_in_report
from stiction.summary.summary import PointSummary, Summary
from stiction.views.assessment import most_useful_measurement_text
from stiction.views.onset import onset_note, onset_text
from stiction.views.point import (
    CONTRIBUTION_LABELS,
    SLIDING_RULE_DESCRIPTIONS,
    averaged_directions_text,
    cutoff_text,
    material_names_text,
    motion_direction_text,
    nominal_area_text,
)
from stiction.views.pull_off import pull_off_text
from stiction.views.quantities import quantity_label
from stiction.views.report.content import ReportContent, common_script_data
from stiction.views.report.page import MAX_SHOWN_LINE_LENGTH, escape_html
from stiction.views.report.reading import LISTED_READING_OPTIONS, file_reading_table
from stiction.views.report.tables import EstimateArray, QuantityEstimates, ReportArray
from stiction.views.resolution import resolved_wavelengths_text
from stiction.views.sentence import (
    area_loss_text,
    dwell_time_text,
    junction_growth_text,
    quotable_sentence,
    small_slope_estimate_text,
)

if TYPE_CHECKING:
    from stiction.study.study import Study


def measured_report_content(
    data: ReportDataOfMeasuredSurfaces, values: ReportValuesOfMeasuredSurfaces, name: str
) -> ReportContent:
    """Return the title, texts and script data of a report on measured surfaces.

    The title contains the file names.
    """
    pair_name = data.description.name
    name = f"{pair_name} ({name})" if name else pair_name
    histories = [_history_markup(side, history) for side, history in data.bodies.items()]
    return ReportContent(
        name=name,
        facts=common_script_data(data, values.axes) | _page_script_data(data, values) | {"name": name},
        arrays=_friction_arrays(values),
        quantities=_list_quantity_tables(data.study, values),
        members_text=f"{data.study.member_names.with_count(data.num_members)} of the two surfaces",
        heading_lines=_heading_lines(data),
        description_markup=_summary_markup(data.summary) + "".join(histories),
    )


_MEMBER_KIND_TEXTS = {"shifts": POSITION_NAMES.plural, "surrogates": SURROGATE_PAIR_NAMES.plural}


def _page_script_data(data: ReportDataOfMeasuredSurfaces, values: ReportValuesOfMeasuredSurfaces) -> dict[str, Any]:
    study, summary, area = data.study, data.summary, data.nominal_area
    surfaces: Any = study.surfaces
    loads, angles = values.loads.tolist(), data.directions
    pressures = [load / area if data.study.has_nominal_area else math.nan for load in loads]
    study_loads = [float(load) for load in study.friction.load]
    return {
        "isMeasured": True,
        "cells": {
            "values": data.cut_offs,
            "texts": [f"cutoff {cutoff_text(surfaces.get_scan_cut_offs(value))}" for value in data.cut_offs],
        },
        "amplitudes": [], "repetitions": data.num_solved, "asked": study_loads,
        "kinds": [_MEMBER_KIND_TEXTS.get(kind or "", study.member_names.plural) for kind in values.member_kinds],
        "loads": {
            "values": loads,
            "texts": [format_load(*items) for items in zip(loads, pressures, strict=True)],
            "unit": f"; 1 mN is {1000 / area:.4g} MPa" if data.study.has_nominal_area else "",
        },
        "start": {
            "cell": data.cut_offs.index(summary.first.at.get("cut_off", data.cut_offs[0])),
            "load": int(np.argmin(np.abs(np.array(loads) - study_loads[0]))),
        },
        "ways": [
            {
                "words": averaged_directions_text(angles)
                if len(motion) > 1
                else motion_direction_text(angles[motion[0]]),
                "directions": motion,
                "isWhole": len(motion) == len(angles),
                "angle": None if len(motion) > 1 else angles[motion[0]],
            }
            for motion in values.motions
        ],
        "statuses": [
            {"name": name, "hasValue": name in friction.STATUSES_WITH_COEFFICIENT, "isTrusted": True}
            for name in STATUSES_BY_CODE
        ],
        "combined": [kind != "surrogates" for kind in values.member_kinds],
        "memberCounts": values.member_counts,
        "ranged": any(axis.has_range.any() for axis in values.axes), "ruleNote": _rule_note(study),
        "points": [_assessment_record(point) for point in summary.points], "validity": [],
        "curves": _CURVE_PANELS[data.study.has_nominal_area],
        "modulus": data.effective_modulus, "area": area,
    }  # fmt: skip


def _rule_note(study: Study) -> str:
    """Return a sentence that states which sliding rule applies to the study's mu0 and tau0."""
    if study.friction.interface is None:
        return (
            "If μ0 was measured on smooth surfaces, friction acts at all contacts. "
            "In other cases, it is not known which rule is valid."
        )
    rule = SLIDING_RULE_DESCRIPTIONS[study.friction.interface.fitted_rule]
    return f"μ0 and τ0 of the interface {study.friction.interface.name} belong to {rule}."


_CURVE_PANELS: dict[bool, dict[str, dict[str, Any]]] = {
    True: {
        "area": {"of": "contact_area_fraction", "title": "true contact area _A_/_A_~0~ (%)", "factor": 100},
        "stiffness": {"of": "stiffness_per_area", "title": "normal stiffness over area (GPa/mm)", "factor": 1e-3},
        "unloading": {
            "of": "unloading_stiffness_per_area", "title": "normal stiffness over area (GPa/mm)", "factor": 1e-3,
        },
    },
    False: {
        "area": {"of": "contact_area", "title": "true contact area _A_ (µm²)", "factor": 1},
        "stiffness": {"of": "normal_stiffness", "title": "normal stiffness (mN/µm)", "factor": 1},
    },
}  # fmt: skip
"""Quantity, axis title and unit conversion factor for each additional plot against load.

The keys specify whether the study has a nominal area.
"""


def _friction_arrays(values: ReportValuesOfMeasuredSurfaces) -> dict[str, ReportArray]:
    """Return the friction data that the page stores: arrays of coefficients, intervals and statuses.

    Coefficients without an interval are printed with the decimals of the mean over directions.
    """
    no_limit = np.full(values.slopes.shape, np.nan)
    return {
        "friction": EstimateArray(values.friction, reference=values.friction[0, :, :, :1]),
        "sampling": EstimateArray(values.sampling),
        "status": values.status_codes.astype(np.int8),
        "answered": values.num_solved.astype(float),
        "slopes": EstimateArray(np.stack([values.slopes, no_limit, no_limit], axis=-1)),
    }


def _summary_markup(summary: Summary) -> str:
    """Return HTML paragraphs on the wavelengths that scans resolve, on the onset of sliding, and on pull-off force."""
    lines = []
    if summary.resolution is not None and summary.resolution.roughness is not None:
        lines.append(resolved_wavelengths_text(summary.resolution.roughness))
    if summary.onset_values is not None:
        lines.append(
            f"{onset_text(summary.onset_values, summary.study)} {onset_note(summary.onset_values, summary.study)}"
        )
    if summary.study.contact.adheres and (pull_off_values := summary.points[0].pull_off) is not None:
        lines.append(pull_off_text(pull_off_values))
    return "".join(f"<p>{escape_html(line)}</p>" for line in lines)


def _heading_lines(data: ReportDataOfMeasuredSurfaces) -> list[str]:
    study, area = data.study, data.nominal_area
    surfaces: Any = study.surfaces
    hardness = study.contact.hardness
    model_name = "half-space" if study.uses_half_space else "asperity"
    plasticity_text = "" if hardness is None else f", hardness {format_with_unit(hardness, 'GPa')}"
    if growth := study.contact.junction_growth:
        plasticity_text += f", junction growth: {junction_growth_text(growth.estimate)}"
    if loss := study.contact.area_loss:
        plasticity_text += f", {area_loss_text(study, loss.estimate)}"
    modulus_text = format_with_unit(data.effective_modulus, "GPa")
    materials_text = f"{material_names_text(study).capitalize()}. " if material_names_text(study) else ""
    size_text = f"nominal area {nominal_area_text(area)}" if study.is_areal else f"length {area:.4g} µm, width 1 µm"
    return [
        f"{materials_text}{surfaces.pressed}, {size_text}, pressed with the {model_name} model; "
        f"E* = {modulus_text}{plasticity_text}."
    ]


MAX_LISTED_PROCESSING_STEPS = 20


def _history_markup(side: str, history: BodyHistory) -> str:
    lines = "".join(f"<li>{escape_html(line)}</li>" for line in history.steps[:MAX_LISTED_PROCESSING_STEPS])
    readings = "".join(
        file_reading_table(reading, {name: getattr(scan, name) for name in LISTED_READING_OPTIONS})
        for scan, reading in history.readings
    )
    num_omitted = history.num_scans - MAX_DESCRIBED_FILE_READINGS
    readings += (
        f"<p>{num_omitted} more scans are in the JSON of <code>stiction pair</code>.</p>" if num_omitted > 0 else ""
    )
    file_text = f"<p>The {side} body: <code>{escape_html(history.name)}</code></p>"
    return file_text + (f"<ul>{lines}</ul>" if lines else "") + readings


def _list_quantity_tables(study: Study, values: ReportValuesOfMeasuredSurfaces) -> list[QuantityEstimates]:
    """Return, for each quantity of the report except friction, an object that contains its estimates."""
    tables = []
    curve_panels = _CURVE_PANELS[study.has_nominal_area].values()
    factors = {curve_panel["of"]: curve_panel["factor"] for curve_panel in curve_panels}
    for name, estimates in values.load_quantities.items():
        if not study.has_nominal_area and name in ("contact_area_fraction", *STIFFNESS_PER_AREA_QUANTITIES):
            continue
        if not is_shown_in_report(name, estimates[0]):
            continue
        quantity = QUANTITIES[name]
        label = quantity_label(name, study)
        words = label[0].upper() + label[1:]
        limit = values.check_limits[name]
        tables.append(QuantityEstimates(name, words, quantity.table_unit, estimates, factors.get(name, 1), limit))
    return tables


def _assessment_record(point: PointSummary) -> dict[str, Any]:
    return {
        "at": point.at, "loadText": format_with_unit(point.at["load"], "mN"), "assessment": point.assessment,
        "covered": point.covered,
        "sentence": printable_text(quotable_sentence(point), MAX_SHOWN_LINE_LENGTH * 4),
        "caveats": [
            {
                name: printable_text(getattr(caveat, name), MAX_SHOWN_LINE_LENGTH)
                for name in ("text", "remedy", "severity")
            }
            for caveat in point.caveats
        ],
        "slopes": small_slope_estimate_text(point),
        "bar": _contribution_record(point),
        "most": " ".join(filter(None, (most_useful_measurement_text(point), dwell_time_text(point)))) or None,
    }  # fmt: skip


def _contribution_record(point: PointSummary) -> dict[str, Any] | None:
    """Return the coefficient for friction at all contacts, its interval, and contributions of mu0, tau0 and slopes.

    Returns None if the coefficient or its contributions are unknown.
    """
    all_contacts_estimate = next((rule for rule in point.rules if rule.rule == "all"), None)
    if point.contributions is None or all_contacts_estimate is None or not math.isfinite(all_contacts_estimate.value):
        return None
    contribution_texts, terms = [], point.contribution_terms
    for index, (name, contribution) in enumerate(terms.items()):
        sign = (" \N{MINUS SIGN} " if contribution <= -0.0005 else " + ") if index else ""
        contribution_texts.append(f"{sign}{abs(contribution):.3f} ({CONTRIBUTION_LABELS[name]})")
    return {
        "contributions": list(terms.values()),
        "ends": [all_contacts_estimate.lower, all_contacts_estimate.upper],
        "value": all_contacts_estimate.value,
        "texts": contribution_texts,
    }
