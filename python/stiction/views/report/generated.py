"""Report on generated surfaces: quantities at nodes of mu0 and tau0, statuses, assessments and figures."""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._number_format import choose_prefixed_unit, format_with_unit
from stiction.mechanics import friction
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.assessment import Caveat, LimitCheck
from stiction.studies.figure_values import evaluate_onset_over_dimension
from stiction.studies.nodes import InterpolationNodes, NodeAxis
from stiction.studies.point import list_sliding_rules_reported_first
from stiction.studies.result import Result
from stiction.studies.study import Study, find_table_differences, study_names
from stiction.studies.values_at_nodes import (
    GENERATED_STATUSES,
    GeneratedValuesAtNodes,
    evaluate_generated_nodes,
    get_validity_limit,
)
from stiction.views.figures.ensemble import COLOUR_RANGE_QUANTILES
from stiction.views.point import motion_direction_text
from stiction.views.report.page import (
    CELL_AXIS_LABELS,
    ReportContent,
    ReportError,
    format_count,
    list_rules_and_directions,
    slider_settings,
)
from stiction.views.report.pictures import contact_forces_panel, onset_by_dimension_panel
from stiction.views.report.tables import PackedArrays

# Maximum number of friction coefficients on a page.
# The number of coefficients is the product of the numbers of nodes, loads, cells, rules and directions.
MAX_GENERATED_REPORT_VALUES = 1_000_000
SURFACE_PARAMETER_DIMENSIONS = ("fractal_dimension", "amplitude")


def generated_report_content(result: Result, name: str) -> ReportContent:
    """Return the report on a result for generated surfaces. The default title is the name of the study.

    Raises a `ReportError` if it is too large for a page or has no members.
    """
    study, nodes, num_members = result.study, result.nodes, result.members.size
    if not num_members or not (num_solved := result.num_solved):
        raise ReportError("the result must have a member with a solution at every load, got none")
    packed_arrays = PackedArrays()
    name = name or _built_in_study_name(study)
    facts = _study_page_data(result.head, study, nodes.loads) | {"name": name, "repetitions": num_solved}
    facts |= {
        "hasIntervals": num_solved > 1,
        "kinds": ["pairs of surfaces"],
        "combined": [True],
        "answers": [],
        "asked": [],
    }
    if nodes.loads.size:
        if nodes.num_coefficients > MAX_GENERATED_REPORT_VALUES:
            raise ReportError(
                f"the result must have at most {MAX_GENERATED_REPORT_VALUES} coefficients at nodes for a report, got "
                f"{nodes.num_coefficients}; choose fewer fractal dimensions, amplitudes or directions"
            )
        facts |= _pack_values(nodes, evaluate_generated_nodes(nodes, num_solved), packed_arrays)
    return ReportContent(
        study=study,
        name=name,
        head=_heading_lines(study),
        pairs_text=_describe_pairs(study, facts),
        facts=facts,
        packed_arrays=packed_arrays,
        num_members=num_members,
        pictures_markup=_render_picture_panels(result),
    )


def _study_page_data(head: xarray.Dataset, study: Study, loads: Floats) -> dict[str, Any]:
    surfaces: Any = study.surfaces
    rules, angles = list_rules_and_directions(study)
    convention = " (classical)" if surfaces.convention == "classical" else ""
    dimensions, amplitudes = (head[name].values for name in SURFACE_PARAMETER_DIMENSIONS)
    return {
        "isMeasured": False,
        "rules": rules,
        "directions": angles,
        "cell": CELL_AXIS_LABELS["fractal_dimension"]
        | {
            "title": f"{CELL_AXIS_LABELS['fractal_dimension']['title']}{convention}",
            "label": f"Fractal dimension D{convention}",
        },
        "cells": {"values": dimensions.tolist(), "texts": [f"D = {dimension:.3f}" for dimension in dimensions]},
        "amplitudes": [format_with_unit(amplitude, "um") for amplitude in amplitudes],
        "measure": "total height" if surfaces.amplitude_measure == "height" else surfaces.amplitude_measure,
        "loads": {"values": loads.tolist(), "texts": [format_with_unit(load, "mN") for load in loads], "unit": ""},
        "ways": [
            {"words": motion_direction_text(angle), "directions": [direction_index], "isWhole": True, "angle": angle}
            for direction_index, angle in enumerate(angles)
        ],
        "quotedRule": list_sliding_rules_reported_first(study)[0],
        "start": {"cell": dimensions.size // 2, "load": loads.size // 2},
        "validity": [],
        "statuses": [],
        "quantities": [],
        "ranged": False,
        "curves": {},
        "hasStiffness": False,
        "area": None,
        "steps": int(head.sizes[study.step_quantity]),
    }


def _pack_values(
    nodes: InterpolationNodes, values: GeneratedValuesAtNodes, packed_arrays: PackedArrays
) -> dict[str, Any]:
    """Add all quantities at the nodes. The array axes are cell, amplitude, rule, motion, load, mu0 and tau0."""
    for name, estimates in values.estimates.items():
        packed_arrays.add_estimates(name, estimates)
    for index, means in enumerate(values.validity.values()):
        packed_arrays.add(f"validity_{index}", means)
    packed_arrays.add("status", values.status_codes.astype(np.int8))
    packed_arrays.add("fine", values.is_interpolated.astype(np.int8))
    packed_arrays.add("judgement", values.assessment_indices.astype(float))
    reasons = [reason for assessment in values.assessments for reason in assessment]
    for name in sorted({each.shown_name for each in reasons if isinstance(each, LimitCheck) and "{}" in each.text}):
        packed_arrays.add(f"number_{name}", values.checked_numbers[name])
    points = values.estimates["friction"]
    mapped_quantities = {name: estimates[..., 0] for name, estimates in values.estimates.items()} | {
        "width": _relative_half_widths(points)
    }
    return {
        "axes": slider_settings(nodes.axes, nodes.study),
        "statuses": [
            {"name": name, "isOk": name == friction.STATUS_OK, "isTrusted": is_trusted}
            for name, is_trusted in GENERATED_STATUSES
        ],
        "validity": [_validity_record(name) for name in values.validity],
        "judgements": [
            {"verdict": verdict, "caveats": [_caveat_or_check_record(reason) for reason in assessment]}
            for verdict, assessment in zip(values.verdicts, values.assessments, strict=True)
        ],
        "hasStiffness": "stiffness" in values.estimates,
        "start": _choose_initial_cell_and_load(values.is_valid, points, nodes.axes, nodes.study),
        "maps": _add_colour_ranges(mapped_quantities, packed_arrays),
        "error": nodes.interpolation_errors,
    }


def _validity_record(name: str) -> dict[str, Any]:
    """Return how a page prints a quantity that shows whether the contact model is valid, and its limit."""
    quantity = QUANTITIES[name]
    return {
        "words": quantity.table_label[0].upper() + quantity.table_label[1:],
        "limit": get_validity_limit(name),
        "isDrawn": "hatch" in quantity.shown,
        "factor": 100 if quantity.percent else 1,
        "decimals": 0 if quantity.percent else 2,
        "unit": " %" if quantity.percent else "",
    }


def _relative_half_widths(points: Floats) -> Floats:
    """Return the half-widths of intervals relative to the absolute values of their means."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((points[..., 2] - points[..., 1]) / (2 * np.abs(points[..., 0])))


def _add_colour_ranges(quantities: dict[str, Floats], packed_arrays: PackedArrays) -> list[str]:
    """Add a colour range for each quantity with positive values. Return the names of these quantities.

    The axes of a range are amplitude, rule, motion, mu0 and tau0.
    """
    names = []
    for name, values in quantities.items():
        positive_values = np.where(values > 0, values, np.nan)
        if not np.isfinite(positive_values).any():
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # some nodes have no value, which causes warnings about NaN
            low, high = np.nanquantile(positive_values, COLOUR_RANGE_QUANTILES, axis=(0, 4))
        packed_arrays.add(f"colours_{name}_low", low)
        packed_arrays.add(f"colours_{name}_high", np.maximum(high, 1.05 * low))
        names.append(name)
    return names


def _choose_initial_cell_and_load(
    is_sound: NDArray[np.bool_], points: Floats, axes: tuple[NodeAxis, NodeAxis], study: Study
) -> dict[str, int]:
    """Choose the initial cell and load of a page: those with the smallest relative interval of a valid value."""
    strengths = study.friction.mu0[len(study.friction.mu0) // 2], float(study.friction.tau0[0])
    node_indices = [int(np.abs(axis.values - value).argmin()) for axis, value in zip(axes, strengths, strict=True)]
    index: tuple[Any, ...] = (slice(None), 0, 0, 0, slice(None), *node_indices)
    width = np.where(is_sound[index] & (points[(*index, 0)] > 0), _relative_half_widths(points)[index], np.nan)
    if not np.isfinite(width).any():
        return {"cell": is_sound.shape[0] // 2, "load": is_sound.shape[4] // 2}
    cell, load = np.unravel_index(np.nanargmin(width), width.shape)
    return {"cell": int(cell), "load": int(load)}


# ---- The assessment --------------------------------------------------------------------------------------------------


def _caveat_or_check_record(reason: Caveat | LimitCheck) -> dict[str, Any]:
    """Return a caveat or check as a record: text, remedy, severity, and the format of the number in the text."""
    number_format = _number_format_of_check(reason) if isinstance(reason, LimitCheck) and "{}" in reason.text else None
    return {"text": reason.text, "remedy": reason.remedy, "severity": reason.severity, "number": number_format}


def _number_format_of_check(check: LimitCheck) -> dict[str, Any]:
    """Return how a page formats the number in the text of a check: source table, factor, decimals and unit."""
    name, format_name = check.shown_name, check.shown
    if format_name == "percent":
        return {"table": name, "factor": 100, "decimals": 0, "unit": " %"}
    if format_name in ("digits", "digit"):
        return {"table": name, "factor": 1, "decimals": 1 if format_name == "digits" else 3, "unit": ""}
    prefix_factor, unit = choose_prefixed_unit(check.limit, format_name)
    decimals = max(0, 1 - math.floor(math.log10(check.limit / prefix_factor)))
    return {"table": name, "factor": 1 / prefix_factor, "decimals": decimals, "unit": f" {unit}"}


# ---- Texts and figures -----------------------------------------------------------------------------------------------


def _render_picture_panels(result: Result) -> str:
    """Draw two of the profiles in contact and, if the study includes it, the onset of sliding."""
    panels = []
    if result.contact_forces is not None:
        panels.append(contact_forces_panel(result.contact_forces))
    if result.nodes.loads.size and (onset := evaluate_onset_over_dimension(result)) is not None:
        panels.append(onset_by_dimension_panel(onset, result.study))
    return "".join(panels)


def _built_in_study_name(study: Study) -> str:
    """Return the name of the built-in study that equals this study apart from the repetitions, or "study"."""
    for name in study_names():
        if {key for key, *_ in find_table_differences(Study.named(name), study)} <= {"ensemble.repetitions"}:
            return name
    return "study"


def _heading_lines(study: Study) -> list[str]:
    rules, angles = list_rules_and_directions(study)
    surfaces: Any = study.surfaces
    contact: Any = study.contact
    side_lengths = surfaces.extents() if study.is_areal else (float(surfaces.extent),)
    model_name = "half-space" if study.uses_half_space else "asperity"
    law_text = "" if study.uses_half_space else f", law {contact.contact_model(rules[0]).law}"
    return [
        f"{surfaces.place[0].upper()}{surfaces.place[1:]}, {' x '.join(f'{length:g}' for length in side_lengths)} µm, "
        f"pressed with the {model_name} model{law_text}; "
        f"E* = {format_with_unit(float(contact.effective_modulus), 'GPa')}; "
        f"contacts with friction: {' and '.join(rules)}; motion {', '.join(map(motion_direction_text, angles))}."
    ]


def _describe_pairs(study: Study, facts: dict[str, Any]) -> str:
    num_dimensions, num_amplitudes, num_steps = len(facts["cells"]["values"]), len(facts["amplitudes"]), facts["steps"]
    pair_count_text = format_count(facts["repetitions"], "pair of surfaces", "pairs of surfaces")
    cells_text = f"{'each of ' if num_dimensions > 1 else ''}{format_count(num_dimensions, 'fractal dimension')}"
    cells_text += f" and {format_count(num_amplitudes, 'amplitude')}" if num_amplitudes > 1 else ""
    steps_text = (
        format_count(num_steps, "load") if study.uses_half_space else format_count(num_steps, "approach", "approaches")
    )
    return f"{pair_count_text} at {cells_text}, pressed together at {steps_text}"
