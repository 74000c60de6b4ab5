"""Results as CSV and JSON for other programs, built from the same data frame.

Records of results have the schema of `json_record`, and also contain ``points``: the coefficient to quote at each
result point, with its caveats.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._estimate import Estimate, estimate_column_titles, to_file_unit
from stiction._number_format import format_time
from stiction.evaluate.point import CELL_DIMENSIONS, list_rules_with_reported_first
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.quantities import (
    QUANTITIES,
    column_title_and_factor,
    find_interval_kind,
    quantity_names_shown_in,
)
from stiction.summary.summary import PointSummary, Summary
from stiction.surfaces.pairing import SIDES
from stiction.views.json_record import caveat_record, record_json
from stiction.views.onset import onset_record
from stiction.views.pull_off import pull_off_record
from stiction.views.quantities import quantity_label
from stiction.views.resolution import resolution_record
from stiction.views.sentence import (
    covered_inputs_text,
    find_covered_range,
    list_assumptions,
    quotable_sentence,
    strength_note,
)

if TYPE_CHECKING:
    import pandas
    import xarray

    from stiction.study.study import Study


_POINT_COORDINATES = (*CELL_DIMENSIONS, "load", "mu0", "tau0")

COORDINATE_ORDER = (
    "height_scale",
    *_POINT_COORDINATES,
    "sliding",
    "direction",
    "axis",
    "fraction_below",
    "input",
    "dwell_time",
    "percentile",
)
"""Coordinates on which numbers of a result may depend, in the order of their columns."""

_COEFFICIENT_COLUMNS = {
    "mean_friction": "all directions",
    "friction_by_axis": "axis",
    "friction_coefficient": "direction",
}
"""Entry of the CSV column `motion` for each variable with coefficients: a text, or the name of a coordinate."""

_VALUE_COLUMNS = ("name", "value", "unit", "lower", "upper", "kind", "status")

_DIRECTION_LABEL_FORMATTERS = {"axis": "along {:g}".format, "direction": "{:g}".format}


# ---- Data frame ------------------------------------------------------------------------------------------------------


def values_frame(dataset: xarray.Dataset) -> pandas.DataFrame:
    """Return the numbers in a dataset as a data frame: one row per number, with interval, status and coordinates.

    Parameters
    ----------
    dataset : xarray.Dataset
        Result of `at_load`.

    Returns
    -------
    pandas.DataFrame
        Columns ``name``, ``value``, ``unit``, ``lower``, ``upper``, ``kind`` (of the interval, "" for none),
        ``status``, and the coordinates of `COORDINATE_ORDER` that the result has, in µm, mN, GPa and degrees. A
        coordinate on which a value does not depend is NaN. Names have the order of `QUANTITIES`.
    """
    import pandas

    names = [str(name) for name, table in dataset.data_vars.items() if table.dtype.kind in "if"]
    quantity_order = {name: position for position, name in enumerate(QUANTITIES)}
    frames = [
        _quantity_rows(dataset, name)
        for name in sorted(names, key=lambda name: quantity_order.get(name, len(quantity_order)))
    ]
    complete_frame = pandas.concat(frames, ignore_index=True)
    coordinates = [name for name in COORDINATE_ORDER if name in complete_frame]
    return complete_frame[[*_VALUE_COLUMNS, *coordinates]]


def _quantity_rows(dataset: xarray.Dataset, name: str) -> pandas.DataFrame:
    """Return a data frame of one quantity, with one row for each combination of coordinates on which it depends."""
    import pandas

    return pandas.DataFrame(_quantity_columns(dataset, name))


def _quantity_columns(dataset: xarray.Dataset, name: str) -> dict[str, Any]:
    """Return a dictionary of the data-frame columns of a quantity.

    A column with the same entry in all rows is given by this entry instead of an array. The columns are created from
    NumPy arrays, because xarray datasets are ten times slower.
    """
    table = dataset.variables[name]
    dims = [str(dim) for dim in table.dims if dim != "statistic"]
    shape = tuple(dataset.sizes[dim] for dim in dims)

    def broadcast_to_rows(variable: xarray.Variable) -> Any:
        """Repeat a variable's values so that each row of the data frame has a value, and return a flat array."""
        values = variable.transpose(*(dim for dim in dims if dim in variable.dims)).values
        slices = tuple(slice(None) if dim in variable.dims else None for dim in dims)
        return np.broadcast_to(values[slices], shape).ravel()

    columns: dict[str, Any] = {"name": name}
    columns |= dict.fromkeys(("value", "lower", "upper"), math.nan)
    if "statistic" in table.dims:
        for position, statistic in enumerate(dataset["statistic"].values):
            variable = table.isel(statistic=position)
            columns["value" if statistic == "mean" else str(statistic)] = broadcast_to_rows(variable).astype(float)
    else:
        columns["value"] = broadcast_to_rows(table).astype(float)
    has_interval = "statistic" in table.dims and name in QUANTITIES
    columns["kind"] = find_interval_kind(name, table.attrs) if has_interval else ""
    unit = QUANTITIES[name].unit if name in QUANTITIES else "1"
    columns["unit"] = to_file_unit(str(table.attrs.get("units", unit)))
    if name == "contact_area_fraction" and "contact_status" in dataset:
        status = broadcast_to_rows(dataset.variables["contact_status"])
        is_missing = (status == STATUS_OK) & ~np.isfinite(columns["value"])
        columns["status"] = np.where(is_missing, "no-mean", status)
    elif "status" in dataset and set(dataset.variables["status"].dims) <= set(dims):
        columns["status"] = broadcast_to_rows(dataset.variables["status"])
    else:
        columns["status"] = np.where(np.isfinite(columns["value"]), STATUS_OK, "no-mean")
    is_directed = name in QUANTITIES and QUANTITIES[name].is_directed
    for coordinate in COORDINATE_ORDER:
        # With a single sliding rule or direction, only quantities that depend on it get a column for it.
        is_scalar = coordinate in dataset.coords and not dataset.variables[coordinate].ndim
        if coordinate in dims or (is_scalar and (is_directed or coordinate not in ("sliding", "direction"))):
            columns[coordinate] = broadcast_to_rows(dataset.variables[coordinate])
    return columns


# ---- CSV -------------------------------------------------------------------------------------------------------------


def summary_table(summary: Summary) -> pandas.DataFrame:
    """Return a table of coefficients, with one row for each combination of result point, sliding rule and motion.

    The column titles contain the units. Each row has the coefficient of static friction for its motion (all directions,
    an axis or a direction), the quantities at its load, and the assessment and caveats. The combined interval exists
    only for the mean over all directions. The interval of the mean over members has separate columns. Rows of the
    default rule come first.
    """
    import pandas

    dataset, study = summary.at, summary.study
    coordinate_names: list[str] = []
    frames: list[pandas.DataFrame] = []
    for name, motion_label in _COEFFICIENT_COLUMNS.items():
        if name not in dataset or (name != "mean_friction" and frames and motion_label not in dataset[name].dims):
            # With a single direction of motion, coefficients by direction equal the mean and get no columns.
            continue
        selected_rows = _quantity_rows(dataset, name)
        coordinate_names = coordinate_names or [
            coordinate_name for coordinate_name in _POINT_COORDINATES if coordinate_name in selected_rows
        ]
        motion_column = (
            selected_rows[motion_label].map(_DIRECTION_LABEL_FORMATTERS[motion_label])
            if motion_label in dataset[name].dims
            else _COEFFICIENT_COLUMNS["mean_friction"]
        )
        selected_rows = selected_rows.assign(
            motion=motion_column,
            sliding=selected_rows["sliding"]
            if "sliding" in selected_rows
            else list_rules_with_reported_first(study)[0],
        )
        frames.append(selected_rows[[*coordinate_names, "sliding", "motion", "status", "value", "lower", "upper"]])
    table = pandas.concat(frames, ignore_index=True)
    title = "coefficient of static friction"
    titles = estimate_column_titles(title)
    mean_titles = estimate_column_titles(f"{title}, interval of the mean")
    interval_titles = {titles[end]: mean_titles[end] for end in ("lower", "upper")}
    table = table.rename(columns=mean_titles | {"value": title})
    table = _merge_quantities(table, dataset, study, (*coordinate_names, "sliding"))
    coefficients = _build_coefficient_columns(summary.points)
    assessments = _assessment_table(summary.points, coordinate_names, coefficients)
    table = table.merge(assessments, on=[*coordinate_names, "sliding"], how="left")
    table.loc[table["motion"] != _COEFFICIENT_COLUMNS["mean_friction"], [*interval_titles, *coefficients]] = math.nan
    other_columns = [str(name) for name in table if name not in interval_titles]
    column_index = other_columns.index(title) + 1
    table = table[[*other_columns[:column_index], *interval_titles, *other_columns[column_index:]]]
    for key in coordinate_names:
        table[key] *= column_title_and_factor(key)[1]
    return table.rename(
        columns={key: column_title_and_factor(key)[0] for key in coordinate_names}
        | {"motion": "upper body to (degree)"}
    )


def _merge_quantities(
    table: pandas.DataFrame, dataset: xarray.Dataset, study: Study, keys: Sequence[str]
) -> pandas.DataFrame:
    """Add the other quantities of a CSV file to a table of coefficients, as columns with their interval limits.

    `keys` are the columns that identify the rows of a quantity, if the quantity depends on them. Quantities with the
    same rows are added in one step, because each step takes several milliseconds.
    """
    import pandas

    titles = [str(name) for name in table]
    columns_by_keys: dict[tuple[str, ...], list[dict[str, Any]]] = {}
    for name in _csv_quantities(dataset):
        rows = _quantity_columns(dataset, name)
        quantity_keys = tuple(key for key in keys if key in rows and pandas.notna(rows[key]).all())
        label = quantity_label(name, study).replace("μ", "mu").replace("τ", "tau")
        columns = {title: rows[column] for column, title in estimate_column_titles(label, rows["unit"]).items()}
        titles += columns
        groups = columns_by_keys.setdefault(quantity_keys, [])
        for group in groups:
            if all(np.array_equal(group[key], rows[key]) for key in quantity_keys):
                group |= columns
                break
        else:
            groups.append({key: rows[key] for key in quantity_keys} | columns)
    for quantity_keys, groups in columns_by_keys.items():
        for group in groups:
            table = table.merge(pandas.DataFrame(group), on=[*quantity_keys], how="left")
    return table[titles]


def _csv_quantities(dataset: xarray.Dataset) -> list[str]:
    """Return the names of the quantities that a CSV file contains.

    Quantities that depend on the direction are left out.
    """
    return [
        name
        for name in quantity_names_shown_in("csv")
        if name in dataset and dataset[name].sizes.get("direction", 1) == 1
    ]


def _build_coefficient_columns(points: Sequence[PointSummary]) -> dict[str, list[float]]:
    """Return a dictionary of columns: friction coefficient after each dwell time, and contribution of roughness.

    Each column has one number per result point and sliding rule, which is NaN for all rules except the reported rule.
    """
    rows = [(point, rule is point.rules[0]) for point in points for rule in point.rules]
    coefficients_after_dwell = {
        title: [getattr(point.after_dwell[index], field) if is_quoted else math.nan for point, is_quoted in rows]
        for index, aged_estimate in enumerate(points[0].after_dwell if points else ())
        for field, title in estimate_column_titles(f"mu_s after {format_time(aged_estimate.seconds)}").items()
    }
    roughness_contributions = [
        math.nan if point.roughness_contribution is None or not is_quoted else point.roughness_contribution
        for point, is_quoted in rows
    ]
    return {**coefficients_after_dwell, "mu_s from roughness": roughness_contributions}


def _assessment_table(
    points: Sequence[PointSummary], keys: Sequence[str], coefficients: Mapping[str, Sequence[float]]
) -> pandas.DataFrame:
    import pandas

    rules = [(point, rule) for point in points for rule in point.rules]
    return pandas.DataFrame(
        {
            **{key: [point.at[key] for point, _ in rules] for key in keys},
            "sliding": [rule.rule for _, rule in rules],
            **{
                title: [getattr(rule, field) for _, rule in rules]
                for field, title in estimate_column_titles("coefficient of static friction").items()
                if field != "value"
            },
            **coefficients,
            **_build_cutoff_columns([point for point, _ in rules]),
            "reported": [not point.covered for point, _ in rules],
            "assumptions": ["; ".join(_list_assumptions_in_file(point)) for point, _ in rules],
            "contact status": [point.contact_status for point, _ in rules],
            "assessment": [point.assessment for point, _ in rules],
            "caveats": ["; ".join(f"{caveat.text}: {caveat.remedy}" for caveat in point.caveats) for point, _ in rules],
        }
    )


def _list_assumptions_in_file(point: PointSummary) -> list[str]:
    """Return the assumptions that an output file lists for the coefficient at one load, mu0 and tau0.

    If mu0 and tau0 are not known separately, a note on them is added.
    """
    return [*list_assumptions(point.study), *filter(None, [strength_note(point)])]


def _build_cutoff_columns(points: Sequence[PointSummary]) -> dict[str, list[float]]:
    """Return two columns: the longest cutoff (µm) of the upper body's scans, and that of the lower body's scans.

    Returns no columns if both bodies have equal cutoffs at every result point.
    """
    cutoffs = [tuple(map(max, point.cutoffs)) if point.cutoffs is not None else (0.0, 0.0) for point in points]
    if all(upper == lower for upper, lower in cutoffs):
        return {}
    return {
        f"{side} body cutoff (um)": list(body_cutoffs)
        for side, body_cutoffs in zip(SIDES, zip(*cutoffs, strict=True), strict=True)
    }


# ---- JSON ------------------------------------------------------------------------------------------------------------


def summary_json(command: str, summary: Summary, /, **fields: Any) -> str:
    """Return a summary as the JSON output of a command: result points with caveats, cutoffs, and onset of sliding."""
    if summary.no_points_reason:
        return record_json(command, [], **fields, remark=summary.no_points_reason)
    dataset, study = summary.at, summary.study
    fields = {"kind": "pair" if study.is_measured else "study", **fields}
    fields |= {f"{side}_body": str(dataset.attrs[side]) for side in SIDES if side in dataset.attrs}
    fields |= {name: str(dataset.attrs[name]) for name in ("load_definition",) if name in dataset.attrs}
    for name in ("effective_modulus", "nominal_area"):
        if name in dataset.coords:
            fields[name] = float(dataset[name])
    fields |= {} if summary.resolution is None else {"resolution": resolution_record(summary.resolution)}
    fields |= {} if summary.onset_values is None else {"onset": onset_record(summary.onset_values)}
    fields["points"] = [point_record(point) for point in summary.points]
    return record_json(command, value_records(values_frame(dataset)), **fields)


def value_records(rows: pandas.DataFrame) -> list[dict[str, Any]]:
    """Convert the rows of a data frame to the list of objects in the field `values` of a JSON output."""
    estimate_records = []
    for row in rows.to_dict("records"):
        selected_values = {name: row.pop(name) for name in _VALUE_COLUMNS}
        # If a quantity does not depend on a coordinate, the coordinate is NaN and is left out.
        coordinates = {name: value for name, value in row.items() if value == value}
        estimate_records.append(Estimate(**selected_values).to_record(coordinates))
    return estimate_records


def point_record(point: PointSummary) -> dict[str, Any]:
    """Return friction at one load, mu0 and tau0 as JSON fields: coefficient, intervals, assessment and caveats."""
    return {
        "at": point.at,
        "ranges": {name: find_covered_range(point, name) or None for name in ("mu0", "tau0")},
        "cutoffs": None if point.cutoffs is None else _build_body_fields(map(list, point.cutoffs)),
        # False at a cutoff other than the reported one, whose interval already covers this result point.
        "reported": not point.covered,
        "status": point.status,
        "rules": [
            {
                "rule": rule.rule,
                "text": str(rule),
                "coefficient": rule.to_record({"sliding": rule.rule}),
                "mean": rule.mean.to_record({"sliding": rule.rule}),
                "prediction": rule.prediction.to_record({"sliding": rule.rule}),
                "members_from": rule.low,
                "members_to": rule.high,
                "small_slope_estimate": rule.slopes,
            }
            for rule in point.rules
        ],
        "contributions": point.contribution_terms or None,
        "calibrated_rule": point.calibrated_rule,
        "budget": [
            {"input": entry.label, "coefficient": entry.to_record({"input": entry.label}), "width": entry.width}
            for entry in point.budget
        ],
        "after_dwell": [
            aged_estimate.to_record({"dwell_time": aged_estimate.seconds}) for aged_estimate in point.after_dwell
        ],
        "rate_and_state": _rate_and_state_record(point),
        "scans": _build_body_fields(point.scans),
        "contact_status": point.contact_status,
        "pull_off": None if point.pull_off is None else pull_off_record(point.pull_off),
        "assessment": point.assessment,
        "sentence": quotable_sentence(point),
        "roughness_contribution": point.roughness_contribution,
        # False if friction tests determine only the sum μ0 + τ0 A/F, so that many pairs of mu0 and tau0 are possible.
        "strengths_separated": point.are_strengths_separated,
        "assumptions": _list_assumptions_in_file(point),
        "interval_covers": covered_inputs_text(point),
        "finer_scans": None
        if point.bracket is None
        else {"from": point.bracket[0], "to": point.bracket[1], "rule": "all", "hardness": point.hardness},
        "caveats": list(map(caveat_record, point.caveats)),
    }


def _rate_and_state_record(point: PointSummary) -> dict[str, Any] | None:
    """Return the parameters b and D_c of rate-and-state friction as JSON.

    Returns None if the study has no dwell times.
    """
    if not math.isfinite(point.ageing):
        return None
    return {"b": Estimate(point.ageing, name="b").to_record(), "D_c": point.contact_size.to_record()}


def _build_body_fields(values: Iterable[Any]) -> dict[str, Any]:
    """Return a property of each body, such as its cutoffs, as the JSON fields "upper_body" and "lower_body"."""
    return {f"{side}_body": value for side, value in zip(SIDES, values, strict=True)}
