"""Report on measured surfaces: friction at nodes of mu0 and tau0, other quantities at every load, and assessments."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray

from stiction._checks import Floats
from stiction._number_format import format_with_unit
from stiction._text import printable_text
from stiction.mechanics import friction
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.assessment import find_smallest_check_limit
from stiction.studies.measured_surfaces import MeasuredBodySettings
from stiction.studies.nodes import InterpolationNodes
from stiction.studies.result import Result
from stiction.studies.study import Study
from stiction.studies.summary import PointSummary, Summary
from stiction.studies.values_at_nodes import ORDERED_STATUSES, MeasuredValuesAtNodes, evaluate_measured_nodes
from stiction.views.figures.standard import format_print_title, pair_title
from stiction.views.onset import onset_note, onset_text
from stiction.views.point import averaged_directions_text, material_names_text, motion_direction_text
from stiction.views.pull_off import pull_off_text
from stiction.views.report.page import (
    CELL_AXIS_LABELS,
    MAX_SHOWN_LINE_LENGTH,
    ReportContent,
    ReportError,
    escape_html,
    format_count,
    list_rules_and_directions,
    slider_settings,
)
from stiction.views.report.pictures import (
    adhesion_panel,
    contact_panel,
    height_factor_panels,
    onset_panels,
    positions_panel,
)
from stiction.views.report.reading import LISTED_READING_OPTIONS, file_reading_table
from stiction.views.report.tables import PackedArrays, count_estimate_decimals, estimate_with_unit_text
from stiction.views.resolution import resolved_wavelengths_text
from stiction.views.sentence import quotable_sentence, small_slope_estimate_text
from stiction.views.text import dwell_time_text, uncertainty_budget_text

# Maximum number of friction coefficients on a page.
# The number of coefficients is the product of the numbers of nodes, loads, cutoffs, rules and directions.
MAX_MEASURED_REPORT_VALUES = 400_000

_UNIT_LABELS = {"um^2": "µm²", "mN/um": "mN/µm", "1": ""}  # labels of units for which no SI prefix is chosen


def measured_report_content(result: Result, name: str, picture: xarray.Dataset | None) -> ReportContent:
    """Return the report on a result for measured bodies. The title consists of the file names and, if given, `name`.

    `picture` is a result of `contact_picture`; by default the picture stored with the result. Raises a `ReportError` if
    the result is too large.
    """
    study, summary, nodes = result.study, result.summary(), result.nodes
    if nodes.num_coefficients > MAX_MEASURED_REPORT_VALUES:
        raise ReportError(
            f"the result must have at most {MAX_MEASURED_REPORT_VALUES} coefficients for a report, got "
            f"{nodes.num_coefficients}"
        )
    values = evaluate_measured_nodes(nodes)
    packed_arrays, num_members = PackedArrays(), result.members.size
    _pack_friction(values, packed_arrays)
    pair_name, title = pair_title(study), format_print_title(study)
    name = f"{pair_name} ({name})" if name else pair_name
    facts = _result_page_data(result.head, summary, num_members, nodes.member_kinds)
    facts |= _node_page_data(nodes, values, study)
    facts |= {"name": name, "quantities": _quantity_records(values.load_quantities)}
    picture = result.contact_picture if picture is None else picture
    return ReportContent(
        study=study,
        name=name,
        head=_heading_lines(study, facts),
        pairs_text=f"{format_count(num_members, 'pair')} of pieces of the two surfaces",
        facts=facts,
        packed_arrays=packed_arrays,
        num_members=num_members,
        details_markup=_summary_markup(summary)
        + "".join(_history_markup(side, str(result.head.attrs.get(side, "")), study) for side in ("upper", "lower")),
        contact_markup="" if picture is None else contact_panel(picture, facts["directions"][0]),
        pictures_markup=(positions_panel(result, facts["asked"][0], title) if num_members > 1 else "")
        + ("" if summary.onset is None else onset_panels(summary.onset, title))
        + height_factor_panels(result, title)
        + adhesion_panel(result.loading_cycle, title),
    )


_MEMBER_KIND_TEXTS: dict[str | None, str] = {
    None: "pairs",
    "shifts": "positions of the two surfaces",
    "surrogates": "pairs of surrogates",
}


def _result_page_data(
    head: xarray.Dataset, summary: Summary, num_members: int, member_kinds: Sequence[str | None]
) -> dict[str, Any]:
    study = summary.study
    area, loads = float(head["nominal_area"]), study.contact.loading_steps().tolist()
    cut_offs = head["cut_off"].values.tolist()
    study_loads = [float(load) for load in study.friction.load]
    return {
        "isMeasured": True, "cell": CELL_AXIS_LABELS["cut_off"],
        "cells": {
            "values": cut_offs,
            "texts": [f"cutoff {format_with_unit(value, 'um')}" if value > 0 else "no cutoff" for value in cut_offs],
        },
        "amplitudes": [], "repetitions": num_members, "asked": study_loads,
        "kinds": [_MEMBER_KIND_TEXTS[kind] for kind in member_kinds],
        "loads": {
            "values": loads,
            "texts": [f"{format_with_unit(load, 'mN')} ({format_with_unit(load / area, 'GPa')})" for load in loads],
            "unit": f"; 1 mN is {1000 / area:.4g} MPa",
        },
        "start": {
            "cell": cut_offs.index(summary.first.at.get("cut_off", cut_offs[0])),
            "load": int(np.argmin(np.abs(np.array(loads) - study_loads[0]))),
        },
        "answers": [_assessment_record(point) for point in summary.points], "validity": [], "curves": _CURVE_PANELS,
        "modulus": float(head["effective_modulus"]), "area": area,
    }  # fmt: skip


_CURVE_PANELS: dict[str, dict[str, Any]] = {
    "area": {"of": "contact_area_fraction", "title": "true contact area _A_/_A_~0~ (%)", "factor": 100},
    "stiffness": {"of": "stiffness_per_area", "title": "normal stiffness over area (GPa/mm)", "factor": 1},
    "unloading": {"of": "unloading_stiffness_per_area", "title": "normal stiffness over area (GPa/mm)", "factor": 1},
}
"""Quantity, axis title and unit conversion factor for each additional plot against load."""


def _pack_friction(values: MeasuredValuesAtNodes, packed_arrays: PackedArrays) -> None:
    """Add friction at the nodes. Values without a combined interval have the decimals of the mean over directions."""
    mean_decimals, _ = count_estimate_decimals(*np.moveaxis(values.friction[0, :, :, :1], -1, 0))
    packed_arrays.add_estimates(
        "friction", values.friction, decimals=np.broadcast_to(mean_decimals, values.friction.shape[:-1])
    )
    packed_arrays.add_estimates("sampling", values.sampling)
    packed_arrays.add("status", values.status_codes.astype(np.int8))
    packed_arrays.add("fine", values.is_interpolated.astype(np.int8))
    packed_arrays.add("answered", values.num_solved.astype(float))
    no_limit = np.full(values.slopes.shape, np.nan)
    packed_arrays.add_estimates("slopes", np.stack([values.slopes, no_limit, no_limit], axis=-1))


def _node_page_data(nodes: InterpolationNodes, values: MeasuredValuesAtNodes, study: Study) -> dict[str, Any]:
    rules, angles = list_rules_and_directions(study)
    return {
        "ways": [
            {
                "words": averaged_directions_text(angles)
                if len(motion) > 1
                else motion_direction_text(angles[motion[0]]),
                "directions": motion,
                "isWhole": len(motion) == len(angles),
                "angle": None if len(motion) > 1 else angles[motion[0]],
            }
            for motion in nodes.motions
        ],
        "rules": rules,
        "directions": angles,
        "axes": slider_settings(nodes.axes, study),
        "error": nodes.interpolation_errors,
        "statuses": [
            {"name": name, "isOk": name == friction.STATUS_OK, "isTrusted": True} for name in ORDERED_STATUSES
        ],
        "combined": [kind != "surrogates" for kind in nodes.member_kinds],
        "memberCounts": values.member_counts,
        "ranged": any(axis.ranged.size for axis in nodes.axes),
    }


def _summary_markup(summary: Summary) -> str:
    """Return paragraphs about the resolved wavelengths, the onset of sliding and the pull-off force."""
    lines = []
    if summary.resolution is not None and summary.resolution.roughness is not None:
        lines.append(resolved_wavelengths_text(summary.resolution.roughness))
    if summary.onset_values is not None:
        lines.append(f"{onset_text(summary.onset_values)} {onset_note(summary.onset_values)}")
    if summary.study.contact.adheres and (pull_off_values := summary.points[0].sticking) is not None:
        lines.append(pull_off_text(pull_off_values))
    return "".join(f"<p>{escape_html(line)}</p>" for line in lines)


def _heading_lines(study: Study, facts: dict[str, Any]) -> list[str]:
    surfaces: Any = study.surfaces
    hardness = study.contact.hardness
    model_name = "half-space" if study.uses_half_space else "asperity"
    plasticity_text = "" if hardness is None else f", hardness {format_with_unit(hardness, 'GPa')}"
    if study.contact.junction_growth:
        plasticity_text += (
            f", junction growth α = {study.known.junction_growth or format(study.contact.junction_growth, 'g')}"
        )
    modulus_text = format_with_unit(facts["modulus"], "GPa")
    materials_text = f"{material_names_text(study).capitalize()}. " if material_names_text(study) else ""
    size_text = (
        f"nominal area {facts['area']:.4g} µm²" if study.is_areal else f"length {facts['area']:.4g} µm, width 1 µm"
    )
    return [
        f"{materials_text}{surfaces.pressed}, {size_text}, pressed with the {model_name} model; "
        f"E* = {modulus_text}{plasticity_text}."
    ]


def _history_markup(side: str, history: str, study: Study) -> str:
    lines = "".join(f"<li>{escape_html(line)}</li>" for line in history.splitlines()[:20])
    body_files = getattr(study.surfaces, side)
    readings = "".join(_scan_reading_table(scan) for scan in body_files.scans[:MAX_FILE_READING_TABLES])
    num_omitted = len(body_files.scans) - MAX_FILE_READING_TABLES
    readings += (
        f"<p>{num_omitted} more scans are in the JSON of <code>stiction pair</code>.</p>" if num_omitted > 0 else ""
    )
    file_text = f"<p>The {side} body: <code>{escape_html(body_files.name)}</code></p>"
    return file_text + (f"<ul>{lines}</ul>" if lines else "") + readings


MAX_FILE_READING_TABLES = 4  # maximum number of scans per body for which the report shows how the files were read


def _scan_reading_table(scan: MeasuredBodySettings) -> str:
    """Return a table that shows how a file was read, or an empty string if there is no readable file."""
    with contextlib.suppress(ValueError, OSError):
        if (reading := scan.reading) is not None:
            return file_reading_table(reading, {name: getattr(scan, name) for name in LISTED_READING_OPTIONS})
    return ""


def _quantity_records(estimates_by_name: dict[str, Floats]) -> list[dict[str, Any]]:
    """Return a record for each quantity except friction, with its values, interval ends, decimals and texts."""
    records = []
    for name, estimates in estimates_by_name.items():
        if not np.isfinite(estimates[0]).any() or (
            name == "load_share_at_hardness" and not np.nan_to_num(estimates[0]).any()
        ):
            continue
        quantity = QUANTITIES[name]
        unit = "%" if quantity.percent else _UNIT_LABELS.get(quantity.unit, quantity.unit)
        factor = next((curve_panel["factor"] for curve_panel in _CURVE_PANELS.values() if curve_panel["of"] == name), 1)
        texts = [
            [[estimate_with_unit_text(point, unit) for point in row] for row in load_rows]
            for load_rows in estimates.tolist()
        ]
        limit = find_smallest_check_limit(name)
        points = factor * estimates
        decimals, upper_decimals = count_estimate_decimals(*np.moveaxis(points, -1, 0))
        records.append({
            "name": name, "words": quantity.table_label[0].upper() + quantity.table_label[1:], "points": points,
            "decimals": decimals.tolist(), "upperDecimals": upper_decimals.tolist(), "texts": texts,
            "isBeyond": (estimates[..., 0] > (np.inf if limit is None else limit)).tolist(),
        })  # fmt: skip
    return records


def _assessment_record(point: PointSummary) -> dict[str, Any]:
    return {
        "at": point.at, "loadText": format_with_unit(point.at["load"], "mN"), "verdict": point.verdict,
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
        "most": " ".join(filter(None, (uncertainty_budget_text(point), dwell_time_text(point)))) or None,
    }  # fmt: skip


_FRICTION_CONTRIBUTION_LABELS = ("μ0", "τ0 on the true area", "slopes")


def _contribution_record(point: PointSummary) -> dict[str, Any] | None:
    """Return the coefficient for friction at all contacts, its interval, and its contributions as numbers and text."""
    all_contacts_estimate = next((rule for rule in point.rules if rule.rule == "all"), None)
    if point.parts is None or all_contacts_estimate is None or not math.isfinite(all_contacts_estimate.value):
        return None
    contribution_texts = []
    for index, (contribution, label) in enumerate(zip(point.parts, _FRICTION_CONTRIBUTION_LABELS, strict=True)):
        sign = (" \N{MINUS SIGN} " if contribution <= -0.0005 else " + ") if index else ""
        contribution_texts.append(f"{sign}{abs(contribution):.3f} ({label})")
    return {
        "parts": point.parts,
        "ends": [all_contacts_estimate.lower, all_contacts_estimate.upper],
        "value": all_contacts_estimate.value,
        "texts": contribution_texts,
    }
