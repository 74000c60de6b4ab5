"""Direct shear tests as text, CSV and JSON."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._estimate import Estimate, estimate_column_titles
from stiction._number_format import choose_prefixed_unit, format_percent, format_significant, format_with_unit
from stiction.mechanics.friction import (
    CENTRAL_SHEAR_RATIO,
    STATUS_DOWNHILL,
    STATUS_NO_CONTACT,
    STATUS_NOT_REACHED,
    STATUS_NOT_SOLVED,
    STATUS_OK,
    STATUS_SELF_LOCKED,
)
from stiction.mechanics.quantities import STIFFNESS_PER_AREA_FACTOR, STIFFNESS_PER_AREA_UNIT
from stiction.mechanics.shear import CLOSURE_NAMES
from stiction.summary.assessment import MIN_CONTACTS_PER_MEMBER_WITHOUT_CAVEAT, MIN_LOAD_FRACTION_AT_HARDNESS
from stiction.summary.joint_table import FIRST_CONTACT_NOTE, JOINT_TITLES, MODEL_ERROR_NOTE, JointUnits, UnitSystem
from stiction.surfaces.joint_roughness import MAX_Z2, MIN_Z2, SAMPLING_INTERVAL
from stiction.views.joint import closure_start_title
from stiction.views.json_record import record_json
from stiction.views.layout import format_table, wrap_text
from stiction.views.spreadsheet import frame_to_csv

if TYPE_CHECKING:
    import pandas
    import xarray

MAX_PRINTED_DISPLACEMENTS = 13
MIN_PRINTED_ANGLE_RANGE = 1.0  # degrees
MAX_EDGE_LOAD_FRACTION = 0.2
MAX_YIELDED_LOAD_FRACTION = 0.5
MAX_INITIAL_AREA_FRACTION = 0.5
# Largest peak friction coefficient that Barton and Choubey (1977) recommend for use in design.
MAX_DESIGN_PEAK_COEFFICIENT = math.tan(math.radians(70))
# Registered faces get a caveat if both ratios exceed these limits: rms gap / its noise, and rms gap / (Z2 · spacing).
MAX_GAP_NOISE_RATIO, MIN_GAP_TO_HEIGHT_CHANGE_RATIO = 3.0, 0.01
MIN_FIT_CORRELATION = 0.5

_CSV_COLUMNS = {
    "friction_coefficient": ("mu", 1.0), "shear_stress": ("shear stress (MPa)", 1e3),
    "dilation": ("dilation (um)", 1.0),
    "contact_area_fraction": ("contact area over overlap", 1.0), "normal_load": ("normal load (mN)", 1.0),
    "overlap_area": ("overlap (um2)", 1.0), "load_fraction_at_hardness": ("load fraction at the hardness", 1.0),
    "load_fraction_at_edges": ("load fraction at the edges", 1.0),
}  # fmt: skip
_PARAMETER_TITLES = {
    "peak_friction_angle": "peak friction angle", "peak_friction_coefficient": "peak friction coefficient",
    "displacement_at_peak": "displacement at the peak", "dilation_angle_at_peak": "dilation angle at the peak",
    "peak_shear_stress": "shear strength", "normal_stress_at_shear_strength": "normal stress at the shear strength",
    "displacement_at_shear_strength": "displacement at the shear strength",
    "end_friction_angle": "friction angle at the end", "end_displacement": "displacement at the end",
    "end_dilation": "dilation at the end", "jrc": "JRC", "z2": "Z2",
}  # fmt: skip
"""Column titles of the parameters of a joint model that hold at the normal stress of a shear test."""

_PARAMETER_NOTES = [
    f"Closure: decrease of the mean gap since first contact. {FIRST_CONTACT_NOTE}.",
    MODEL_ERROR_NOTE,
    "No published shear test has been compared with a computed one, and no interval contains the error of the model.",
]
"""Sentences on the definition of the closure and on the error of the model, for files with parameters of a joint."""

CSV_SIGNATURE = _CSV_COLUMNS["load_fraction_at_hardness"][0].encode()
"""Bytes by which the program recognizes a CSV file of a shear test that it may replace."""

_STATUS_TEXTS: dict[str, str] = {
    STATUS_DOWNHILL: "slides by itself", STATUS_SELF_LOCKED: "locks", STATUS_NO_CONTACT: "no contact",
    STATUS_NOT_REACHED: "load not reached", STATUS_NOT_SOLVED: "no solution",
}  # fmt: skip
_NO_PEAK_REASONS: dict[str, str] = {
    STATUS_SELF_LOCKED: "the faces lock: no tangential load moves them before the asperities fail",
    STATUS_NOT_REACHED: "the asperities cannot carry the load",
    STATUS_NOT_SOLVED: "the contact has no solution",
}


def curve_estimate(test: xarray.Dataset, name: str, index: int) -> Estimate:
    """Return a quantity of a shear test at one displacement, as an estimate with its interval."""
    return replace(_read_variable(test, name, "displacement", index), status=str(test["status"].values[index]))


def _read_variable(test: xarray.Dataset, name: str, dimension: str, index: int) -> Estimate:
    """Return an element of a shear test's dataset as an estimate, with its interval if the dataset has one."""
    value, limits = float(test[name][index]), [math.nan, math.nan]
    if f"{name}_interval" in test:
        limits = test[f"{name}_interval"].isel({dimension: index}).values.tolist()
    return Estimate(
        value, *limits, name=name, unit=test[name].attrs["units"],
        kind="" if np.isnan(limits).any() else "combined", status="no-value" if math.isnan(value) else STATUS_OK,
    )  # fmt: skip


def headline_estimates(test: xarray.Dataset) -> dict[str, Estimate]:
    """Return a shear test's coefficients at the peak and at the end, and other quantities at the peak."""
    attributes = test.attrs
    return {
        name: Estimate(
            float(attributes[attribute]), float(attributes.get(f"{attribute}_lower", math.nan)),
            float(attributes.get(f"{attribute}_upper", math.nan)), name=name, unit=unit,
            kind="combined" if f"{attribute}_lower" in attributes else "", status=str(status),
        )
        for name, attribute, unit, status in (
            ("peak_friction_coefficient", "peak", "1", attributes["peak_status"]),
            ("displacement_at_peak", "peak_displacement_um", "um", attributes["peak_status"]),
            ("dilation_angle_at_peak", "peak_dilation_angle_deg", "deg", attributes["peak_status"]),
            ("peak_shear_stress", "peak_shear_stress_GPa", "GPa", attributes["peak_status"]),
            ("end_friction_coefficient", "end", "1", test["status"].values[-1]),
        )
    }  # fmt: skip


def shear_values(test: xarray.Dataset) -> list[dict[str, Any]]:
    """Return results of a shear test as JSON fields: at the peak, at the end, and at each displacement.

    The last fields are closure and stiffness of closure at each normal stress at the start.
    """
    return [
        *(estimate.to_record() for estimate in headline_estimates(test).values()),
        *(
            curve_estimate(test, name, index).to_record({"displacement": displacement})
            for index, displacement in enumerate(test["displacement"].values.tolist())
            for name in ("friction_coefficient", "shear_stress", "dilation", "contact_area_fraction", "normal_load")
        ),
        *(
            _read_variable(test, name, "normal_stress", index).to_record({"normal_stress": normal_stress})
            for index, normal_stress in enumerate(
                test["normal_stress"].values.tolist() if "normal_stress" in test else ()
            )
            for name in CLOSURE_NAMES
        ),
    ]


def list_caveats(test: xarray.Dataset) -> list[str]:
    """Return the caveats about a shear test as sentences."""
    status, displacement = test["status"].values, test["displacement"].values
    caveats = _list_fit_caveats(test.attrs)
    if test.attrs.get("interface_rule") == "opposing":
        caveats.append(
            "μ0 and τ0 of the interface were fitted with friction at opposing contacts only, but a shear test has "
            "friction at all contacts: fit them with stiction calibrate --sliding all."
        )
    caveats += [f"{line[0].upper()}{line[1:]}." for line in test.attrs.get("interface_caveats", "").splitlines()]
    if (reason := _NO_PEAK_REASONS.get(str(test.attrs["peak_status"]))) is not None:
        first_displacement = displacement[int(np.argmax(status == test.attrs["peak_status"]))]
        displacement_text = format_with_unit(first_displacement, "um")
        caveats.append(f"There is no peak: at a displacement of {displacement_text}, {reason}.")
    elif test.attrs["peak_status"] == STATUS_OK:
        peak = int(np.nanargmax(test["friction_coefficient"].values))
        if peak == displacement.size - 1:
            caveats.append("The coefficient is largest at the end of the path: choose a longer path.")
        elif _find_shear_strength(test) == displacement.size - 1:
            load_ratio, area_ratio = (
                float(test[name][-1] / test[name][peak]) for name in ("normal_load", "overlap_area")
            )
            caveats.append(
                "The shear stress is largest at the end of the path, because "
                + (
                    "the normal load rises: choose a longer path."
                    if load_ratio * area_ratio > 1
                    else "the overlap shrinks: choose a shorter path, or shear longer faces."
                )
            )
        if float(test.attrs["peak"]) > MAX_DESIGN_PEAK_COEFFICIENT:
            caveats.append("The peak is above 70°, the usual limit of rock joints: real asperities break before.")
        if peak == 0 and float(test["contact_area_fraction"][0]) > MAX_INITIAL_AREA_FRACTION:
            caveats.append(
                f"The peak is before the faces move, when {format_percent(float(test['contact_area_fraction'][0]))} of "
                "the overlap is in contact: real faces fit less well than scans that are identical."
            )
        elif peak == 1:
            caveats.append(_describe_early_peak(test))
        at_hardness = float(test["load_fraction_at_hardness"][peak])
        if math.isnan(float(test.attrs["hardness_GPa"])):
            caveats.append(
                "Without a hardness, the asperities cannot fail, so the peak is an upper limit: give the strength of "
                "the asperities as the hardness."
            )
        elif at_hardness > MAX_YIELDED_LOAD_FRACTION:
            caveats.append(
                f"At the peak, {format_percent(at_hardness)} of the load is on asperities at their strength. They are "
                "flattened; breakage, gouge and wear are not included."
            )
        if test.attrs.get("body_shears_first") and at_hardness > MIN_LOAD_FRACTION_AT_HARDNESS:
            limit = format_significant(2 / CENTRAL_SHEAR_RATIO, 2)
            caveats.append(
                "For metal, the peak may be too high: by slip lines, as in pair, asperities at their strength shear "
                f"before they slide, at a coefficient of about {limit}. Repeat the test with --mu0 {limit} and no "
                "--tau0. For rock, this limit does not hold."
            )
        contact_count = round(float(test["contact_count"][peak]))
        contact_text = "one contact carries" if contact_count == 1 else f"{contact_count} contacts carry"
        if contact_count < MIN_CONTACTS_PER_MEMBER_WITHOUT_CAVEAT:
            caveats.append(
                f"At the peak, {contact_text} the load, so the result depends on chance: shear longer faces, or "
                "several profiles."
            )
    edge_fractions = test["load_fraction_at_edges"].values
    edge_fraction = float(np.max(edge_fractions, initial=0.0, where=np.isfinite(edge_fractions)))
    if edge_fraction > MAX_EDGE_LOAD_FRACTION:
        caveats.append(
            f"Up to {format_percent(edge_fraction)} of the load is at the edges of the faces: a free tilt takes the "
            "load off the edges, a shorter path keeps them apart."
        )
    caveats += _list_interval_caveats(test)
    for name, words in ((STATUS_DOWNHILL, "slide by themselves"), (STATUS_NO_CONTACT, "lose contact")):
        if (status == name).any():
            displacement_text = format_with_unit(displacement[int(np.argmax(status == name))], "um")
            count_text = f"{int((status == name).sum())} of {status.size} displacements"
            caveats.append(f"At {count_text}, first at {displacement_text}, the faces {words}.")
    return caveats


def _describe_early_peak(test: xarray.Dataset) -> str:
    """Return the caveat about a peak at the first displacement.

    Finer scans of faces that fit perfectly have ever earlier peaks, because finer asperities are steeper.
    """
    spacing = float(test["displacement"][1])
    if "x" in test.coords and spacing >= 1.5 * float(test["x"][1] - test["x"][0]):
        return "The peak is at the first displacement, so the true peak may be higher and earlier: use more steps."
    rise = spacing * float(test.attrs["rising_slope"])
    if "gap" in test and float(np.nanstd(test["gap"].values)) < MIN_GAP_TO_HEIGHT_CHANGE_RATIO * rise:
        return (
            "The peak is at the first displacement, and the faces fit perfectly: a finer scan would give a higher and "
            f"earlier peak again. Report the peak with its spacing ({format_with_unit(spacing, 'um')}), or scan both "
            "faces: real faces have a gap, which limits the peak."
        )
    return "The peak is at the first displacement, so the true peak may be higher and earlier: use a finer scan."


_INTERVAL_LABELS = {
    "friction_coefficient": ("friction coefficient", "displacements"), "dilation": ("dilation", "displacements"),
    "closure": ("closure", "normal stresses"), "closure_stiffness": ("stiffness of closure", "normal stresses"),
}  # fmt: skip


def _list_interval_caveats(test: xarray.Dataset) -> list[str]:
    """Return a list with a caveat if some intervals are open or missing because the contact has no finite solution."""
    open_texts = []
    for name, (label, points) in _INTERVAL_LABELS.items():
        if f"{name}_interval" not in test:
            continue
        lower, upper = test[f"{name}_interval"].values
        is_open = np.isfinite(test[name].values) & (np.isnan(lower) | ((lower == 0) & np.isinf(upper)))
        if is_open.any():
            open_texts.append(f"{label} at {int(is_open.sum())} of {is_open.size} {points}")
    if not open_texts:
        return []
    places = ["at a limit of the uncertain inputs"] * (test.attrs["uncertain_inputs"] != "")
    places += ["on all strips but at most one"] * (test.attrs["strips"] > 0)
    return [
        "Intervals are open or missing, because the contact has no finite solution "
        f"{' or '.join(places)}: {', '.join(open_texts)}."
    ]


def _list_fit_caveats(attributes: Mapping[Any, Any]) -> list[str]:
    """Return a list with a caveat if two faces fit poorly: their slopes differ, or their gap exceeds the noise."""
    correlation, is_registered = float(attributes["fit_correlation"]), "registration_rms_gap_um" in attributes
    if correlation < MIN_FIT_CORRELATION:
        if not is_registered:
            return [
                f"The slopes of the faces agree poorly where the path starts (correlation {correlation:.2f}): register "
                "the faces, or check how they were scanned."
            ]
        return [
            f"The slopes of the faces agree poorly even where they fit best (correlation {correlation:.2f}): check "
            "which faces belong together, whether the rows of one scan run backwards, and any crop."
        ]
    if not is_registered:
        return []
    rms_gap, noise = float(attributes["registration_rms_gap_um"]), attributes.get("registration_gap_noise_um", math.nan)
    height_change = float(attributes["z2"]) * float(attributes["sampling_interval_um"])
    if not rms_gap > max(MAX_GAP_NOISE_RATIO * float(noise), MIN_GAP_TO_HEIGHT_CHANGE_RATIO * height_change):
        return []
    return [
        f"Even where the faces fit best, their gap (rms {format_with_unit(rms_gap, 'um')}) is larger than their noise "
        f"({format_with_unit(float(noise), 'um')}): the gap lowers the peak, so check that it is real."
    ]


def shear_text(test: xarray.Dataset, *, verbose: bool = False) -> str:
    """Return a shear test as text: results at the peak and at the end, caveats, and a table by displacement."""
    lines = [wrap_text(line, hanging_indent="  ") for line in headline_lines(test)]
    lines += ["", format_table(curve_rows(test, _select_rows(test, verbose=verbose)))]
    caveats = list_caveats(test)
    if caveats:
        lines += ["", *(wrap_text(f"- {caveat}", hanging_indent="  ") for caveat in caveats)]
    return "\n".join(lines)


def headline_lines(test: xarray.Dataset) -> list[str]:
    """Return lines on a shear test: results at its peak and end, uncertainty, lower face, closure, registration."""
    estimates, end = headline_estimates(test), float(test["displacement"][-1])
    lines = []
    if estimates["peak_friction_coefficient"].status == STATUS_OK:
        lines += _peak_lines(estimates)
    end_status = estimates["end_friction_coefficient"].status
    end_text = (
        f"μ = {estimates['end_friction_coefficient'].text()}"
        if end_status == STATUS_OK
        else _STATUS_TEXTS[end_status]
    )  # fmt: skip
    dilation = float(test["dilation"][-1])
    dilation_text = "" if math.isnan(dilation) else f", dilation {format_with_unit(dilation, 'um')}"
    lines.append(f"end:  {end_text} at {format_with_unit(end, 'um')}{dilation_text}")
    if estimates["peak_friction_coefficient"].status == STATUS_OK:
        strength = estimates["peak_shear_stress"].in_prefixed_unit()
        lines.append(
            f"shear strength: {strength.text()} {strength.unit} at "
            f"{format_with_unit(float(test['displacement'][_find_shear_strength(test)]), 'um')}"
        )
    lines.append(_interval_text(test.attrs))
    lines.append(_roughness_text(test.attrs))
    if "closure_stiffness" in test and not math.isnan(float(test["closure_stiffness"][-1])):
        stiffness = _read_variable(test, "closure_stiffness", "normal_stress", -1)
        stress_text = format_with_unit(float(test["normal_stress"][-1]), "GPa")
        lines.append(f"stiffness of closure at the start: {stiffness.text()} {stiffness.unit} at {stress_text}")
    if not math.isnan(float(test.attrs["closure_misfit"])):
        lines.append(_closure_text(test.attrs))
    if "registration_rms_gap_um" in test.attrs:
        lines.append(_registration_text(test.attrs))
    return lines


def _find_shear_strength(test: xarray.Dataset) -> int:
    """Return the index of the displacement at which the shear stress has its maximum, the shear strength.

    At a variable normal stress, the friction coefficient may be largest at another displacement.
    """
    return int(np.nanargmax(test["shear_stress"].values))


def _peak_lines(values: Mapping[str, Estimate]) -> list[str]:
    coefficient, displacement = values["peak_friction_coefficient"], values["displacement_at_peak"].in_prefixed_unit()
    friction_angle = math.degrees(math.atan(coefficient.value))
    angle = values["dilation_angle_at_peak"]
    limits = (
        f" [{angle.lower:.0f}°, {angle.upper:.0f}°]" if angle.upper - angle.lower >= MIN_PRINTED_ANGLE_RANGE else ""
    )
    distance = displacement.text(1) if displacement.has_interval else format_significant(displacement.value, 3)
    return [
        f"peak: μ = {coefficient.text()} at {distance} {displacement.unit} (friction angle {friction_angle:.0f}°)",
        f"dilation angle at the peak: {angle.value:.0f}°{limits}",
    ]


def _interval_text(attributes: Mapping[Any, Any]) -> str:
    """Return a line that lists the sources of uncertainty in the intervals of a shear test."""
    inputs, strips = str(attributes["uncertain_inputs"]), int(attributes["strips"])
    if not inputs and not strips:
        return "no intervals: the inputs count as exact, and the faces are not sheared in strips"
    sources = [inputs] * bool(inputs) + [f"scatter between {strips} strips of the faces"] * bool(strips)
    return f"95 % intervals: {', '.join(sources)}"


def _roughness_text(attributes: Mapping[Any, Any]) -> str:
    interval = format_with_unit(float(attributes["sampling_interval_um"]), "um")
    jrc = float(attributes["jrc"])
    jrc_text = (
        f"no JRC (Z2 {MIN_Z2:g} to {MAX_Z2:g} at {format_with_unit(SAMPLING_INTERVAL, 'um')})"
        if math.isnan(jrc)
        else f"JRC {jrc:.0f}"
    )
    z2, rising_slope, falling_slope = (float(attributes[name]) for name in ("z2", "rising_slope", "falling_slope"))
    return (
        f"lower face: Z2 = {z2:.2g} at {interval}, {jrc_text}; along the motion, mean rising slope {rising_slope:.2g}, "
        f"falling slope {falling_slope:.2g}"
    )


def _closure_text(attributes: Mapping[Any, Any]) -> str:
    stiffness = STIFFNESS_PER_AREA_FACTOR * float(attributes["closure_initial_stiffness_GPa_per_um"])
    maximum = format_with_unit(float(attributes["maximum_closure_um"]), "um")
    return (
        f"closure at the start: Bandis' law fitted up to the load, K = {format_significant(stiffness, 2)} "
        f"{STIFFNESS_PER_AREA_UNIT}, V = {maximum} "
        f"(closure within {format_percent(float(attributes['closure_misfit']))})"
    )


def _registration_text(attributes: Mapping[Any, Any]) -> str:
    shifts = [
        f"{format_with_unit(float(attributes[name]), 'um')} along {axis}"
        for axis in ("x", "y")
        if (name := f"registration_shift_{axis}_um") in attributes
    ]
    gap_before, gap_after = (
        format_with_unit(float(attributes[name]), "um")
        for name in ("rms_gap_before_registration_um", "registration_rms_gap_um")
    )
    return (
        f"registered: shift {', '.join(shifts)}, rotation {attributes['registration_rotation_deg']:.2f}°; rms gap "
        f"{gap_after} (before: {gap_before}), correlation of the slopes {attributes['fit_correlation']:.2f}"
    )


def _select_rows(test: xarray.Dataset, *, verbose: bool) -> list[int]:
    """Return the indices of the displacements to print.

    If there are many, evenly spaced displacements and the peak are selected, unless `verbose` is true.
    """
    count = test.sizes["displacement"]
    if count <= MAX_PRINTED_DISPLACEMENTS or verbose:
        return list(range(count))
    indices = np.unique(np.rint(np.linspace(0, count - 1, MAX_PRINTED_DISPLACEMENTS - 1)).astype(int))
    if test.attrs["peak_status"] == STATUS_OK:
        indices = np.union1d(indices, [int(np.nanargmax(test["friction_coefficient"].values))])
    return [int(index) for index in indices]


def curve_rows(test: xarray.Dataset, indices: Iterable[int]) -> list[list[str]]:
    """Return a shear test as table rows: headings, and one row for each displacement in `indices`."""
    columns = [
        _format_column(
            test, name, float(np.max(np.abs(test[name].values), initial=0.0, where=np.isfinite(test[name].values)))
        )
        for name in ("displacement", "dilation", "shear_stress")
    ]
    if test.attrs["normal_stiffness_GPa_per_um"] > 0:
        normal_stress = (test["normal_load"] / test["overlap_area"]).assign_attrs(units="GPa")
        columns.append(_format_column({"normal_stress": normal_stress}, "normal_stress", float(normal_stress.max())))
    (title, displacements), *other_columns = columns
    rows = [[title.replace("displacement", "u"), "μ", "contact", *(title for title, _ in other_columns)]]
    for index in indices:
        status, contact = str(test["status"].values[index]), float(test["contact_area_fraction"][index])
        coefficient = curve_estimate(test, "friction_coefficient", index).text()
        rows.append(
            [
                displacements[index], coefficient if status == STATUS_OK else _STATUS_TEXTS[status],
                "none" if math.isnan(contact) else format_percent(contact),
                *(numbers[index] for _, numbers in other_columns),
            ]
        )  # fmt: skip
    return rows


def _format_column(test: Any, name: str, largest: float) -> tuple[str, list[str]]:
    """Return the heading and numbers of a table column, in the prefixed unit that suits the largest number."""
    factor, unit = choose_prefixed_unit(largest, test[name].attrs["units"])
    number_texts = [format_significant(value / factor, 3) for value in test[name].values]
    return f"{name.replace('_', ' ')} ({unit})", number_texts


# ---- Parameters of joint models --------------------------------------------------------------------------------------


def shear_parameters_csv(test: xarray.Dataset, units: UnitSystem) -> str:
    """Return as CSV the parameters for joint models that follow from a shear test: one row per normal stress.

    Closure and stiffness are in all rows. All other parameters are only in the last row, which is at the normal stress
    of the test.
    """
    import pandas

    rows = _list_parameter_rows(test, units)
    names = list(rows[-1])
    columns: dict[str, list[float]] = {}
    for name in names:
        estimates = [row.get(name, Estimate(math.nan)) for row in rows]
        title = "normal stress" if name == "normal_stress" else (_PARAMETER_TITLES | JOINT_TITLES)[name]
        titles = estimate_column_titles(title, estimates[-1].unit)
        columns[titles["value"]] = [estimate.value for estimate in estimates]
        if any(estimate.has_interval for estimate in estimates):
            columns[titles["lower"]] = [estimate.lower for estimate in estimates]
            columns[titles["upper"]] = [estimate.upper for estimate in estimates]
    frame = pandas.DataFrame(columns)
    # Closures are measured from the first contact of the faces, at a pressure of 0.
    frame[closure_start_title(rows[-1]["normal_stress"])] = 0.0
    frame["intervals"] = _interval_text(test.attrs)
    return frame_to_csv(frame)


def shear_parameters_json(test: xarray.Dataset, units: UnitSystem) -> str:
    """Return as JSON the parameters for joint models that follow from a shear test, with inputs, units and caveats."""
    parsed_units = JointUnits.parse(units)
    records = [
        estimate.to_record({"normal_stress": row["normal_stress"].value})
        for row in _list_parameter_rows(test, units)
        for name, estimate in row.items()
        if name != "normal_stress"
    ]
    unit_names = {"length": parsed_units.length, "force": parsed_units.force, "pressure": parsed_units.pressure}
    return (
        record_json(
            "export", records, kind="shear_joint", units=unit_names, inputs=describe_inputs(test),
            intervals=_interval_text(test.attrs), notes=_PARAMETER_NOTES, caveats=list_caveats(test),
        )
        + "\n"
    )  # fmt: skip


def describe_inputs(test: xarray.Dataset) -> dict[str, Any]:
    """Return the attributes of a shear test (inputs and summary numbers) as JSON fields."""
    return {str(name): value for name, value in test.attrs.items() if name != "key"}


def _list_parameter_rows(test: xarray.Dataset, units: UnitSystem) -> list[dict[str, Estimate]]:
    """Return the parameters for joint models in a unit system: one dictionary for each normal stress."""
    parsed_units = JointUnits.parse(units)
    rows = [
        {
            "normal_stress": Estimate(stress, name="normal_stress", unit="GPa"),
            **{name: _read_variable(test, name, "normal_stress", index) for name in CLOSURE_NAMES},
        }
        for index, stress in enumerate(test["normal_stress"].values.tolist())
    ]
    rows[-1] |= _estimate_parameters(test)
    return [{name: parsed_units.convert(estimate) for name, estimate in row.items()} for row in rows]


def _estimate_parameters(test: xarray.Dataset) -> dict[str, Estimate]:
    """Return the parameters for joint models (µm, GPa) that a shear test gives at its normal stress."""
    values, end, status = headline_estimates(test), test.sizes["displacement"] - 1, str(test.attrs["peak_status"])
    normal_stress = displacement = math.nan
    if status == STATUS_OK:
        index = _find_shear_strength(test)
        normal_stress = float(test["normal_load"][index] / test["overlap_area"][index])
        displacement = float(test["displacement"][index])
    jrc = float(test.attrs["jrc"])
    parameters = {
        **values,
        "peak_friction_angle": _to_angle(values["peak_friction_coefficient"]),
        "end_friction_angle": _to_angle(values["end_friction_coefficient"]),
        "normal_stress_at_shear_strength": Estimate(normal_stress, unit="GPa", status=status),
        "displacement_at_shear_strength": Estimate(displacement, unit="um", status=status),
        "end_displacement": Estimate(float(test["displacement"][end]), unit="um"),
        "end_dilation": _read_variable(test, "dilation", "displacement", end),
        "jrc": Estimate(jrc, status="outside-range" if math.isnan(jrc) else STATUS_OK),
        "z2": Estimate(float(test.attrs["z2"])),
    }
    return {name: replace(parameters[name], name=name) for name in _PARAMETER_TITLES}


def _to_angle(coefficient: Estimate) -> Estimate:
    """Convert a friction coefficient to a friction angle in degrees."""
    numbers = (coefficient.value, coefficient.lower, coefficient.upper)
    value, lower, upper = (math.degrees(math.atan(number)) for number in numbers)
    return replace(coefficient, value=value, lower=lower, upper=upper, unit="deg")


def shear_csv(test: xarray.Dataset) -> str:
    """Return a shear test as CSV with units, one row per displacement."""
    return frame_to_csv(_shear_frame(test))


def _shear_frame(test: xarray.Dataset) -> pandas.DataFrame:
    import pandas as pd

    columns: dict[str, Any] = {"displacement (um)": test["displacement"].values}
    for name, (title, factor) in _CSV_COLUMNS.items():
        columns[title] = test[name].values * factor
        if f"{name}_interval" in test:
            for end, values in zip(("lower", "upper"), test[f"{name}_interval"].values, strict=True):
                columns[f"{title}: {end}"] = values * factor
    columns["status"] = test["status"].values
    return pd.DataFrame(columns)
