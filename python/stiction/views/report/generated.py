"""Report on generated surfaces with sliders for mu0 and tau0: friction, other quantities, assessments and figures."""

from __future__ import annotations

import warnings
from collections.abc import Sequence
from typing import Any, TypeGuard

import numpy as np

from stiction._checks import Floats
from stiction._number_format import NumberFormat, format_with_unit, list_number_formats
from stiction.mechanics import friction
from stiction.mechanics.quantities import QUANTITIES
from stiction.study.member_names import REPETITION_NAMES
from stiction.study.study import Study
from stiction.summary.assessment import Caveat, LimitCheck
from stiction.summary.report_data import ReportDataOfGeneratedSurfaces
from stiction.summary.report_values import (
    QUANTITIES_BY_PANEL,
    STATUSES_OF_GENERATED_SURFACES,
    ReportValuesOfGeneratedSurfaces,
    get_validity_limit,
)
from stiction.views.point import coordinate_text, motion_direction_text
from stiction.views.quantities import quantity_label
from stiction.views.report.content import ReportContent, common_script_data
from stiction.views.report.page import escape_html, format_count
from stiction.views.report.tables import QUANTITY_DIGITS, EstimateArray, NumberArray, ReportArray
from stiction.views.style import COLOUR_RANGE_QUANTILES


def generated_report_content(
    data: ReportDataOfGeneratedSurfaces, values: ReportValuesOfGeneratedSurfaces | None, name: str
) -> ReportContent:
    """Return the title, texts and script data of a report on generated surfaces.

    The default title is the name of the study.

    `values` is None if no pair is in contact.
    """
    name = name or data.description.name
    facts = common_script_data(data, None if values is None else values.axes)
    facts |= _page_script_data(data) | {
        "name": name,
        "repetitions": data.num_solved,
        "hasIntervals": data.num_solved > 1,
    }
    facts |= {"kinds": [REPETITION_NAMES.plural], "combined": [True], "points": [], "asked": []}
    arrays: dict[str, ReportArray] = {}
    if values is not None:
        colour_ranges = _compute_colour_ranges(values)
        facts |= _value_script_data(values, data.study) | {"maps": list(colour_ranges)}
        arrays |= _create_report_arrays(values)
        for quantity_name, ends in colour_ranges.items():
            for end, limit_values in zip(("low", "high"), ends, strict=True):
                arrays[f"colours_{quantity_name}_{end}"] = NumberArray(limit_values, list_number_formats("digits"))
    return ReportContent(
        name=name,
        heading_lines=_heading_lines(data),
        members_text=_describe_members(data),
        description_markup=_changed_settings_markup(data.description.changed_settings),
        facts=facts,
        arrays=arrays,
    )


def _page_script_data(data: ReportDataOfGeneratedSurfaces) -> dict[str, Any]:
    study, loads = data.study, data.loads
    surfaces: Any = study.surfaces
    convention = " (classical)" if surfaces.convention == "classical" else ""
    return {
        "isMeasured": False,
        "cell": {
            "title": f"fractal dimension _D_{convention}", "name": "D", "label": f"Fractal dimension D{convention}",
        },
        "cells": {
            "values": data.dimensions.tolist(),
            "texts": [f"D = {coordinate_text('fractal_dimension', number)}" for number in data.dimensions.tolist()],
        },
        "amplitudes": [format_with_unit(amplitude, "um") for amplitude in data.amplitudes],
        "measure": "total height" if surfaces.amplitude_measure == "height" else surfaces.amplitude_measure,
        "loads": {"values": loads.tolist(), "texts": [format_with_unit(load, "mN") for load in loads], "unit": ""},
        "ways": [
            {"words": motion_direction_text(angle), "directions": [direction_index], "isWhole": True, "angle": angle}
            for direction_index, angle in enumerate(data.directions)
        ],
        "start": {"cell": data.dimensions.size // 2, "load": loads.size // 2},
        "means": [],
        "statuses": [],
        "ranged": False,
        "curves": {},
        "hasStiffness": False,
        "area": None,
        "steps": data.num_steps,
    }  # fmt: skip


def _value_script_data(values: ReportValuesOfGeneratedSurfaces, study: Study) -> dict[str, Any]:
    return {
        "statuses": [
            {"name": name, "hasValue": name in friction.STATUSES_WITH_COEFFICIENT, "isTrusted": is_trusted}
            for name, is_trusted in STATUSES_OF_GENERATED_SURFACES
        ],
        "means": [_quantity_record(name, study) for name in values.means],
        "judgements": [
            {"assessment": assessment, "caveats": [_caveat_or_check_record(caveat) for caveat in caveats]}
            for assessment, caveats in zip(values.assessments, values.caveat_sets, strict=True)
        ],
        "hasStiffness": "stiffness" in values.estimates,
        "start": _choose_initial_cell_and_load(values, study),
    }


def _create_report_arrays(values: ReportValuesOfGeneratedSurfaces) -> dict[str, ReportArray]:
    """Return arrays of a report page: friction, other quantities, statuses and assessments at each result point."""
    arrays: dict[str, ReportArray] = {"friction": EstimateArray(values.estimates["friction"])}
    for panel, estimates in values.estimates.items():
        if panel != "friction":
            formats = list_number_formats(QUANTITIES[QUANTITIES_BY_PANEL[panel]].unit)
            arrays[panel] = EstimateArray(estimates, digits=QUANTITY_DIGITS, formats=formats)
    arrays["width"] = NumberArray(_relative_half_widths(values.estimates["friction"]), _WIDTH_FORMATS)
    for name, means in values.means.items():
        quantity = QUANTITIES[name]
        unit = "digits" if quantity.unit == "1" else quantity.unit
        arrays[f"mean_{name}"] = NumberArray(
            means, _MEAN_PERCENT_FORMATS if quantity.percent else list_number_formats(unit)
        )
        arrays[f"beyond_{name}"] = (means > get_validity_limit(name)).astype(np.int8)
    arrays["status"] = values.status_codes.astype(np.int8)
    arrays["judgement"] = values.assessment_indices.astype(float)
    return arrays | _caveat_number_arrays(values)


def _caveat_number_arrays(values: ReportValuesOfGeneratedSurfaces) -> dict[str, ReportArray]:
    """Return, for each number that caveats state, an array of this number at all result points.

    The array is NaN at points without this caveat.
    """
    assessments_by_number: dict[tuple[str, str], list[int]] = {}
    for index, caveats in enumerate(values.caveat_sets):
        for check in filter(_contains_number, caveats):
            assessments_by_number.setdefault((check.shown_name, check.shown), []).append(index)
    return {
        f"number_{name}": NumberArray(
            np.where(np.isin(values.assessment_indices, indices), values.checked_numbers[name], np.nan),
            list_number_formats(kind),
        )
        for (name, kind), indices in sorted(assessments_by_number.items())
    }


def _contains_number(reason: Caveat | LimitCheck) -> TypeGuard[LimitCheck]:
    """Return whether a caveat is a failed check whose text states a number that differs between result points."""
    return isinstance(reason, LimitCheck) and "{}" in reason.text


_WIDTH_FORMATS = (NumberFormat(0.0, 0.01, "±{} %", 2),)
_MEAN_PERCENT_FORMATS = (NumberFormat(0.0, 0.01, "{} %", 2),)


def _quantity_record(name: str, study: Study) -> dict[str, Any]:
    """Return the name and the label of a quantity for the page scripts."""
    label = quantity_label(name, study)
    return {"name": name, "words": label[0].upper() + label[1:]}


def _relative_half_widths(points: Floats) -> Floats:
    """Return, for each interval, half of its width divided by the absolute value of the mean."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((points[..., 2] - points[..., 1]) / (2 * np.abs(points[..., 0])))


def _compute_colour_ranges(values: ReportValuesOfGeneratedSurfaces) -> dict[str, tuple[Floats, Floats]]:
    """Return, for each quantity that has positive values, the limits of the colour scale.

    The axes of the arrays are amplitude, rule, motion, mu0 and tau0.
    """
    mapped_quantities = {name: points[..., 0] for name, points in values.estimates.items()}
    mapped_quantities["width"] = _relative_half_widths(values.estimates["friction"])
    ranges = {}
    for name, means in mapped_quantities.items():
        positive_values = np.where(means > 0, means, np.nan)
        if not np.isfinite(positive_values).any():
            continue
        with warnings.catch_warnings():
            # NumPy warns about slices that contain only NaN, which result from points without a coefficient.
            warnings.simplefilter("ignore", RuntimeWarning)
            lower_limits, upper_limits = np.nanquantile(positive_values, COLOUR_RANGE_QUANTILES, axis=(0, 4))
        ranges[name] = lower_limits, np.maximum(upper_limits, 1.05 * lower_limits)
    return ranges


def _choose_initial_cell_and_load(values: ReportValuesOfGeneratedSurfaces, study: Study) -> dict[str, int]:
    """Return the indices of the surface and of the load that a report shows when it is opened.

    Friction of this surface at this load has the narrowest interval, relative to its mean.
    """
    is_valid, points = values.is_valid, values.estimates["friction"]
    strengths = study.friction.mu0[len(study.friction.mu0) // 2], float(study.friction.tau0[0])
    parameter_indices = [axis.find_index(value) for axis, value in zip(values.axes, strengths, strict=True)]
    index: tuple[Any, ...] = (slice(None), 0, 0, 0, slice(None), *parameter_indices)
    width = np.where(is_valid[index] & (points[(*index, 0)] > 0), _relative_half_widths(points)[index], np.nan)
    if not np.isfinite(width).any():
        return {"cell": is_valid.shape[0] // 2, "load": is_valid.shape[4] // 2}
    cell, load = np.unravel_index(np.nanargmin(width), width.shape)
    return {"cell": int(cell), "load": int(load)}


# ---- The assessment --------------------------------------------------------------------------------------------------


def _caveat_or_check_record(reason: Caveat | LimitCheck) -> dict[str, Any]:
    """Return a caveat or a failed check as a dictionary for the page scripts, with text, remedy and severity.

    The key "number" names the array of the number in the text.
    """
    return {
        "text": reason.text, "remedy": reason.remedy, "severity": reason.severity,
        "number": f"number_{reason.shown_name}" if _contains_number(reason) else None,
    }  # fmt: skip


# ---- Texts and figures -----------------------------------------------------------------------------------------------


def _changed_settings_markup(changed_settings: Sequence[tuple[str, str]]) -> str:
    """Return HTML that lists the settings of a study that differ from the defaults."""
    if not changed_settings:
        return "<p>All values are the defaults.</p>"
    lines = "".join(f"<li><code>{escape_html(f'{key} = {value}')}</code></li>" for key, value in changed_settings)
    return f"<p>The defaults, but</p><ul>{lines}</ul>"


def _heading_lines(data: ReportDataOfGeneratedSurfaces) -> list[str]:
    study = data.study
    surfaces: Any = study.surfaces
    contact: Any = study.contact
    side_lengths = surfaces.extents() if study.is_areal else (float(surfaces.extent),)
    model_name = "half-space" if study.uses_half_space else "asperity"
    law_text = "" if study.uses_half_space else f", law {contact.contact_model(data.rules[0]).law}"
    return [
        f"{surfaces.place[0].upper()}{surfaces.place[1:]}, {' x '.join(f'{length:g}' for length in side_lengths)} µm, "
        f"pressed with the {model_name} model{law_text}; "
        f"E* = {format_with_unit(float(contact.effective_modulus), 'GPa')}; "
        f"contacts with friction: {' and '.join(data.rules)}; "
        f"motion {', '.join(map(motion_direction_text, data.directions))}."
    ]


def _describe_members(data: ReportDataOfGeneratedSurfaces) -> str:
    num_dimensions, num_amplitudes, num_steps = data.dimensions.size, data.amplitudes.size, data.num_steps
    repetitions_text = data.study.member_names.with_count(data.num_solved)
    cells_text = f"{'each of ' if num_dimensions > 1 else ''}{format_count(num_dimensions, 'fractal dimension')}"
    cells_text += f" and {format_count(num_amplitudes, 'amplitude')}" if num_amplitudes > 1 else ""
    steps_text = (
        format_count(num_steps, "load")
        if data.study.uses_half_space
        else format_count(num_steps, "approach", "approaches")
    )
    return f"{repetitions_text} at {cells_text}, pressed together at {steps_text}"
