"""Text and JSON on the friction and true contact area of a pair whose heights are multiplied by given factors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction._number_format import choose_prefixed_unit, format_load, format_significant, format_with_unit
from stiction.evaluate.point import (
    find_contact_status,
    has_nominal_area,
    is_unloaded,
    iterate_points,
    mean_over_directions,
    nominal_pressure_at,
    read_estimate,
    select_sliding_rule,
    sort_sliding_rules,
)
from stiction.mechanics.friction import STATUS_OK
from stiction.views import rows
from stiction.views.json_record import record_json
from stiction.views.layout import format_table, wrap_text
from stiction.views.quantities import percent_text

if TYPE_CHECKING:
    import xarray

    from stiction.companions.height_scale import ScaledBodies
    from stiction.study.study import Study

NAMES_OF_SCALED_SURFACES: dict[ScaledBodies, str] = {
    "both": "both surfaces",
    "upper": "the upper surface",
    "lower": "the lower surface",
}
HEIGHT_SCALE_NOTE = (
    "Only the heights change. A surface finish that also adds or removes wavelengths needs its own scan, "
    "because a factor cannot describe it."
)


def height_scale_text(dataset: xarray.Dataset, study: Study) -> str:
    """Return text tables of a pair's friction and true area: one row per factor by which heights are multiplied."""
    scaled_surfaces = NAMES_OF_SCALED_SURFACES[dataset.attrs["scaled"]]
    lines = [
        wrap_text(
            f"Heights of {scaled_surfaces} are multiplied by a factor; 1 is the measured pair. The gradient is the rms "
            "gradient of the gap. Intervals: 95 %, combined."
        )
    ]
    dataset = sort_sliding_rules(dataset, study)
    rules = np.atleast_1d(dataset["sliding"].values).tolist()
    is_areal = study.is_areal
    has_rms = "upper_rms" in dataset
    for point in iterate_points(dataset):
        material_text = f"μ0 = {float(point['mu0']):g}, τ0 = {format_with_unit(float(point['tau0']), 'GPa')}"
        rms_headings = ["Sq of both" if is_areal else "Pq of both"] if has_rms else []
        headings = {"all": "μ_s all contacts", "opposing": "μ_s opposing contacts"}
        has_fraction = has_nominal_area(point, study) and "contact_area_fraction" in point
        pull_off_heading = ["pull-off"] if "pull_off_pressure" in point else []
        area_heading = "A/A0" if has_fraction else "A (µm²)"
        table = [
            ["factor", "gradient", *rms_headings, *(headings[rule] for rule in rules), area_heading, *pull_off_heading]
        ]
        table += [
            _height_factor_row(point.isel(height_scale=index), rules, study)
            for index in range(point.sizes["height_scale"])
        ]
        load_description = format_load(float(point["load"]), nominal_pressure_at(point, study))
        lines += ["", wrap_text(f"At {load_description}, {material_text}:"), format_table(table)]
    lines += ["", wrap_text(HEIGHT_SCALE_NOTE)]
    return "\n".join(lines) + "\n"


def _height_factor_row(point: xarray.Dataset, rules: list[str], study: Study) -> list[str]:
    """Return the cells of one table row: height factor, rms gradient, friction, true area and others."""
    table_cells = [
        f"{float(point['height_scale']):.4g}",
        format_significant(mean_over_directions(point, "rms_gradient"), 3),
    ]
    if "upper_rms" in point:
        rms_heights = [float(point[f"{side}_rms"]) for side in ("upper", "lower")]
        height_unit, unit = choose_prefixed_unit(max(rms_heights), "um")
        table_cells.append(f"{', '.join(f'{height / height_unit:.3g}' for height in rms_heights)} {unit}")
    for rule in rules:
        combined_friction = select_sliding_rule(point["friction_combined"], rule)
        table_cells.append("sticks" if is_unloaded(point) else str(read_estimate(combined_friction)))
    if not has_nominal_area(point, study) or "contact_area_fraction" not in point:
        table_cells.append(format_significant(mean_over_directions(point, "contact_area"), 3))
    elif (status := find_contact_status(point, study)) != STATUS_OK:
        table_cells.append(status)
    else:
        fraction = read_estimate(point["contact_area_fraction"])
        table_cells.append(
            f"{fraction.in_unit('%', 0.01)} %" if fraction.has_interval else percent_text(fraction.value)
        )
    return (
        [*table_cells, format_with_unit(mean_over_directions(point, "pull_off_pressure"), "GPa")]
        if "pull_off_pressure" in point
        else table_cells
    )


def height_scale_json(dataset: xarray.Dataset, study: Study) -> str:
    """Return as JSON a pair's friction and other quantities for each factor by which heights are multiplied."""
    fields = {"kind": "pair", "scaled": dataset.attrs["scaled"], "solved": dataset.attrs["solved"].tolist()}
    fields |= {name: float(dataset[name]) for name in ("effective_modulus", "nominal_area") if name in dataset.coords}
    frame = rows.values_frame(sort_sliding_rules(dataset, study))
    return record_json("at", rows.value_records(frame), **fields)
