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
from stiction.mechanics.quantities import QUANTITIES, quantity_names_shown_in
from stiction.studies.assessment import find_smallest_check_limit
from stiction.studies.measured_surfaces import MeasuredBodySettings
from stiction.studies.nodes import InterpolationNodes
from stiction.studies.result import Result
from stiction.studies.study import Study
from stiction.studies.summary import PointSummary
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


def measured_report_content(result: Result, study: Study, name: str, picture: xarray.Dataset | None) -> ReportContent:
    """Return the report on a result for measured bodies. The title consists of the file names and, if given, `name`.

    `picture` is a result of `contact_picture`; by default the picture stored with the result. Raises a `ReportError` if
    the result is too large.
    """
    dataset = result.dataset
    title_of_pair = pair_title(study)
    name = f"{title_of_pair} ({name})" if name else title_of_pair
    packed_arrays = PackedArrays()
    facts = _result_page_data(dataset, result, study)
    facts |= _add_friction_at_nodes(result.nodes, study, packed_arrays) | {"name": name}
    facts["quantities"] = _quantity_records(result.nodes.load_quantities)
    picture = result.contact_picture if picture is None else picture
    num_members = int(facts["repetitions"])
    onset = result.onset
    resolution = result.summary().resolution
    study_lines = (
        [] if resolution is None or resolution.roughness is None else [resolved_wavelengths_text(resolution.roughness)]
    )
    study_lines += [] if onset is None else [f"{onset_text(onset)} {onset_note(onset)}"]
    text = "".join(f"<p>{escape_html(line)}</p>" for line in (*study_lines, *_pull_off_lines(result, study)))
    details_markup = text + "".join(
        _history_markup(side, str(dataset.attrs.get(side, "")), study) for side in ("upper", "lower")
    )
    return ReportContent(
        study=study,
        name=name,
        head=_heading_lines(study, facts),
        pairs_text=f"{format_count(num_members, 'pair')} of pieces of the two surfaces",
        facts=facts,
        packed_arrays=packed_arrays,
        num_members=num_members,
        details_markup=details_markup,
        contact_markup="" if picture is None else contact_panel(picture, facts["directions"][0]),
        pictures_markup=(
            positions_panel(result, facts["asked"][0], format_print_title(study)) if num_members > 1 else ""
        )
        + ("" if onset is None else onset_panels(onset, format_print_title(study)))
        + height_factor_panels(result, format_print_title(study))
        + adhesion_panel(result.loading_cycle, format_print_title(study)),
    )


_MEMBER_KIND_TEXTS = {None: "pairs", "shifts": "positions of the two surfaces", "surrogates": "pairs of surrogates"}


def _result_page_data(dataset: xarray.Dataset, result: Result, study: Study) -> dict[str, Any]:
    area, loads = float(dataset["nominal_area"]), study.contact.loading_steps().tolist()
    cut_offs = dataset["cut_off"].values.tolist()
    assessments = _assessment_records(result)
    quoted_cutoffs = (
        assessment["at"].get("cut_off", cut_offs[0]) for assessment in assessments if not assessment["covered"]
    )
    quoted_cutoff = next(quoted_cutoffs, cut_offs[0])
    study_loads = [float(load) for load in study.friction.load]
    return {
        "isMeasured": True, "cell": CELL_AXIS_LABELS["cut_off"],
        "cells": {
            "values": cut_offs,
            "texts": [f"cutoff {format_with_unit(value, 'um')}" if value > 0 else "no cutoff" for value in cut_offs],
        },
        "amplitudes": [], "repetitions": int(dataset.sizes["repetition"]), "asked": study_loads,
        "kinds": [_MEMBER_KIND_TEXTS[kind] for kind in result.nodes.member_kinds],
        "loads": {
            "values": loads,
            "texts": [f"{format_with_unit(load, 'mN')} ({format_with_unit(load / area, 'GPa')})" for load in loads],
            "unit": f"; 1 mN is {1000 / area:.4g} MPa",
        },
        "start": {
            "cell": cut_offs.index(quoted_cutoff), "load": int(np.argmin(np.abs(np.array(loads) - study_loads[0]))),
        },
        "answers": assessments, "validity": [], "curves": _CURVE_PANELS,
        "modulus": float(dataset["effective_modulus"]), "area": area,
    }  # fmt: skip


_CURVE_PANELS = {
    "area": {"of": "contact_area_fraction", "title": "true contact area _A_/_A_~0~ (%)", "factor": 100},
    "stiffness": {"of": "stiffness_per_area", "title": "normal stiffness over area (GPa/mm)", "factor": 1},
    "unloading": {"of": "unloading_stiffness_per_area", "title": "normal stiffness over area (GPa/mm)", "factor": 1},
}
"""Quantity, axis title and unit conversion factor for each additional plot against load."""


def _add_friction_at_nodes(nodes: InterpolationNodes, study: Study, packed_arrays: PackedArrays) -> dict[str, Any]:
    """Add friction at the nodes to `packed_arrays`. Array axes: kind, cutoff, rule, motion, load, mu0 and tau0."""
    (rules, angles), axes, member_kinds = list_rules_and_directions(study), nodes.axes, nodes.member_kinds
    motions: list[dict[str, Any]] = [
        {"words": motion_direction_text(angle), "directions": [direction_index]}
        for direction_index, angle in enumerate(angles)
    ]
    if len(angles) > 1:
        motions.insert(0, {"words": averaged_directions_text(angles), "directions": list(range(len(angles)))})
    num_values = (
        len(member_kinds)
        * len(study.surfaces.cell_coordinates()["cut_off"])
        * nodes.loads.size
        * len(rules)
        * len(motions)
    )
    num_values *= axes[0].values.size * axes[1].values.size
    if num_values > MAX_MEASURED_REPORT_VALUES:
        raise ReportError(
            f"the result must have at most {MAX_MEASURED_REPORT_VALUES} coefficients for a report, got {num_values}"
        )
    member_counts: list[int] = []
    arrays_by_name: dict[str, list[Any]] = {name: [] for name in ("shown", "sampling", "status", "answered", "slopes")}
    for node_values in nodes.values:
        member_counts.append(int(node_values["members"]))
        dimensions = ("cut_off", "sliding", "direction", "load", "mu0", "tau0")
        friction_by_direction = node_values["friction_coefficient"].transpose(*dimensions, "statistic").values
        mean_friction = (
            node_values["friction_all_round"]
            .transpose(*(dim for dim in dimensions if dim != "direction"), "statistic")
            .values
        )
        combined_friction = mean_friction.copy()
        if "friction_combined" in node_values:
            combined_friction = (
                node_values["friction_combined"]
                .transpose(*(dim for dim in dimensions if dim != "direction"), "statistic")
                .values
            )
        status, num_solved = (node_values[name].transpose(*dimensions).values for name in ("status", "ok"))
        slopes = node_values["gentle_friction"].transpose("cut_off", "sliding", "direction", "mu0", "tau0").values
        motion_arrays = []
        for motion in motions:
            is_mean_of_directions = len(motion["directions"]) == len(angles)
            sampled_friction = (
                mean_friction if is_mean_of_directions else friction_by_direction[:, :, motion["directions"][0]]
            )
            directions = sorted(motion["directions"])
            motion_arrays.append(
                (
                    combined_friction if is_mean_of_directions else sampled_friction,
                    sampled_friction,
                    _status_codes(status[:, :, directions], sampled_friction[..., 0]),
                    num_solved[:, :, directions].min(axis=2),
                    slopes[:, :, directions].mean(axis=2),
                )
            )
        for name, values in zip(arrays_by_name, zip(*motion_arrays, strict=True), strict=True):
            arrays_by_name[name].append(np.stack(values, axis=2))
    stacked_arrays = {name: np.stack(values) for name, values in arrays_by_name.items()}
    is_interpolated = nodes.find_interpolated_panels(stacked_arrays["shown"])
    displayed_friction, is_combined = stacked_arrays["shown"], np.zeros((len(member_kinds), len(motions)), bool)
    for index, motion in enumerate(motions):
        motion["isWhole"] = len(motion["directions"]) == len(angles)
        motion["angle"] = None if len(motion["directions"]) > 1 else angles[motion["directions"][0]]
        is_combined[0, index] = motion["isWhole"]
    # A value without a combined interval is printed with as many decimals as the mean over all directions.
    mean_friction = displayed_friction[0, :, :, [is_combined[0].argmax()]]
    mean_decimals = np.moveaxis(count_estimate_decimals(*np.moveaxis(mean_friction, -1, 0))[0], 0, 2)
    displayed_friction[
        np.broadcast_to(~is_combined[:, np.newaxis, np.newaxis, :, None, None, None], displayed_friction.shape[:-1]), 1:
    ] = np.nan
    packed_arrays.add_estimates(
        "friction", displayed_friction, decimals=np.broadcast_to(mean_decimals, displayed_friction.shape[:-1])
    )
    packed_arrays.add_estimates("sampling", stacked_arrays["sampling"])
    packed_arrays.add("status", stacked_arrays["status"].astype(np.int8))
    packed_arrays.add("fine", is_interpolated.astype(np.int8))
    packed_arrays.add("answered", stacked_arrays["answered"].astype(float))
    slopes = stacked_arrays["slopes"]
    packed_arrays.add_estimates("slopes", np.stack([slopes, *(np.full(slopes.shape, np.nan),) * 2], axis=-1))
    return {
        "ways": motions,
        "rules": rules,
        "directions": angles,
        "axes": slider_settings(axes, study),
        "error": nodes.interpolation_errors,
        "statuses": [
            {"name": name, "isOk": name == friction.STATUS_OK, "isTrusted": True} for name in ORDERED_STATUSES
        ],
        "combined": [member_kind != "surrogates" for member_kind in member_kinds],
        "memberCounts": member_counts,
        "ranged": bool(axes[0].ranged.size or axes[1].ranged.size),
    }


ORDERED_STATUSES = (friction.STATUS_OK, *sorted(name for name in friction.STATUSES if name != friction.STATUS_OK))
"""Statuses in the order of their codes. If several directions have no value, the lowest code is reported."""


def _status_codes(statuses: Any, values: Floats) -> Any:
    """Return the status code of each mean over directions. Array axes: cutoff, sliding rule, load, mu0 and tau0."""
    codes = np.select([statuses == name for name in ORDERED_STATUSES], range(len(ORDERED_STATUSES)))
    lowest_codes = np.where(codes == 0, len(ORDERED_STATUSES), codes).min(axis=2)
    not_solved_code = ORDERED_STATUSES.index(friction.STATUS_NOT_SOLVED)
    return np.where(
        np.isfinite(values), 0, np.where(lowest_codes == len(ORDERED_STATUSES), not_solved_code, lowest_codes)
    )


def _pull_off_lines(result: Result, study: Study) -> list[str]:
    """Return a list with a sentence about the pull-off force at the first mu0 and tau0; empty if nothing adheres."""
    if not study.contact.adheres:
        return []
    pull_off_estimate = result.summary().points[0].sticking
    return [] if pull_off_estimate is None else [pull_off_text(pull_off_estimate)]


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


def _quantity_records(evaluations: Sequence[xarray.Dataset]) -> list[dict[str, Any]]:
    """Return a record for each quantity except friction, with its values, interval ends, decimals and texts."""
    records = []
    for name in (name for name in quantity_names_shown_in("report") if name in evaluations[0]):
        estimates = np.stack([values[name].transpose("cut_off", "load", "statistic").values for values in evaluations])
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


def _assessment_records(result: Result) -> list[dict[str, Any]]:
    return [
        {
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
        }
        for point in result.summary().points
    ]  # fmt: skip


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
