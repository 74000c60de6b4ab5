"""Joint tables as CSV, JSON, and input files (cards) for Abaqus, CalculiX, Ansys and LIGGGHTS."""

from __future__ import annotations

import math
import textwrap
from collections.abc import Collection, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from stiction._core import __version__
from stiction._estimate import MAX_SIGNIFICANT_DIGITS, Estimate, estimate_column_titles
from stiction._number_format import format_with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.summary.joint_table import (
    EVIDENCE_OF_MODEL_ERROR,
    FRICTION_PERCENTILES_BY_NAME,
    JOINT_TITLES,
    MODEL_ERROR_TEXT,
    STIFFNESS_OVER_MEASURED_STIFFNESS,
    describe_negative_closures,
)
from stiction.views.json_record import record_json
from stiction.views.spreadsheet import frame_to_csv

if TYPE_CHECKING:
    import pandas

    from stiction.summary.joint_table import JointRow, JointTable

CARD_WIDTH = 100  # characters
CURVE_DIGITS = 6
"""Number of significant digits of pressures and closures in cards, from which other programs compute stiffnesses."""
_ASCII_REPLACEMENTS = {
    "μ": "mu", "τ": "tau", "α": "alpha", "ν": "nu", "±": "+-", "²": "^2", "µ": "u", "–": "-", "′": "'", "×": "x",
}  # fmt: skip


MODEL_ERROR_COLUMNS = {
    "stiffness of closure: model error (not in the interval)": MODEL_ERROR_TEXT,
    "tangential stiffness: model error (not in the interval)": "not validated",
}
"""Cells of a table that are the same in all rows: the model errors, which no interval contains."""

MODEL_ERRORS = [
    {
        "name": "closure_stiffness", "computed_over_measured": list(STIFFNESS_OVER_MEASURED_STIFFNESS),
        "in_interval": False, "evidence": EVIDENCE_OF_MODEL_ERROR,
    },
    {
        "name": "tangential_stiffness_per_area", "computed_over_measured": None, "in_interval": False,
        "evidence": "not validated",
    },
]  # fmt: skip
"""The model errors as JSON objects."""


def closure_start_title(start_pressure: Estimate) -> str:
    """Return the title of the table column that states at which pressure closure is 0."""
    return estimate_column_titles("closure counted from", start_pressure.unit)["value"]


# ---- Tables ----------------------------------------------------------------------------------------------------------


def joint_frame(tables: Sequence[JointTable]) -> pandas.DataFrame:
    """Return joint tables as a data frame: one row per pressure, mu0 and tau0, and units in the column names."""
    import pandas

    return pandas.concat([_single_joint_frame(table) for table in tables], ignore_index=True)


def _single_joint_frame(table: JointTable) -> pandas.DataFrame:
    import pandas

    columns: dict[str, list[Any]] = {}
    for name, title in JOINT_TITLES.items():
        estimates = [row.estimates[name] for row in table.rows]
        titles = estimate_column_titles(
            title, next((estimate.unit for estimate in estimates if estimate.unit != "1"), "1")
        )
        columns[titles["value"]] = [estimate.value for estimate in estimates]
        if any(estimate.has_interval for estimate in estimates):
            columns[titles["lower"]] = [estimate.lower for estimate in estimates]
            columns[titles["upper"]] = [estimate.upper for estimate in estimates]
        if any(estimate.kind for estimate in estimates):
            columns[f"{title}: kind"] = [estimate.kind for estimate in estimates]
    constant_columns = {closure_start_title(table.closure_from): table.closure_from.value, **MODEL_ERROR_COLUMNS}
    columns |= {title: [cell] * len(table.rows) for title, cell in constant_columns.items()}
    columns["assessment of mu_s"] = [row.assessment for row in table.rows]
    columns["computed"] = [int(row.is_computed) for row in table.rows]
    tau0 = table.units.convert(Estimate(table.tau0, unit="GPa"))
    for title, value in {
        "mu0": table.mu0, estimate_column_titles("tau0", tau0.unit)["value"]: tau0.value, "sliding": table.sliding
    }.items():  # fmt: skip
        columns[title] = [value] * len(table.rows)
    return pandas.DataFrame(columns)


def joint_csv(tables: Sequence[JointTable]) -> str:
    """Return the rows of joint tables as CSV; the notes on the tables are left out."""
    return frame_to_csv(joint_frame(tables))


def joint_json(tables: Sequence[JointTable], sources: Sequence[str]) -> str:
    """Return joint tables for one or more mu0 and tau0 as JSON, with their notes.

    `sources` contains one sentence on the pair for each table.
    """
    estimate_records, assessments = [], []
    for table in tables:
        for row in table.rows:
            at = {"load": row.load, "mu0": table.mu0, "tau0": table.tau0}
            # In JSON, loads and tau0 are in core units, like the coordinates of all estimates.
            assessments.append(at | {"load_unit": "mN", "tau0_unit": "GPa", "assessment": row.assessment})
            for name, estimate in row.estimates.items():
                depends_on_rule = estimate.name in QUANTITIES and "sliding" in QUANTITIES[estimate.name].along
                coordinates = at | ({"sliding": table.sliding} if depends_on_rule else {})
                if name in FRICTION_PERCENTILES_BY_NAME:
                    coordinates["percentile"] = FRICTION_PERCENTILES_BY_NAME[name]
                estimate_records.append(estimate.to_record(coordinates))
    table = tables[0]
    units = {"length": table.units.length, "force": table.units.force, "pressure": table.units.pressure}
    return (
        record_json(
            "export", estimate_records, kind="joint", units=units, sliding=table.sliding, assessments=assessments,
            closure_from=table.closure_from.to_record(), model_errors=MODEL_ERRORS, notes=_list_notes(tables),
            sentence="\n".join(sources),
        )
        + "\n"
    )  # fmt: skip


def _list_notes(tables: Sequence[JointTable]) -> list[str]:
    """Return the notes of joint tables; a note that only some tables have begins with the mu0 and tau0 of its table."""
    shared_notes = [note for note in tables[0].notes if all(note in table.notes for table in tables)]
    return shared_notes + [
        f"μ0 = {table.mu0:.4g}, τ0 = {format_with_unit(table.tau0, 'GPa')}: {note}"
        for table in tables
        for note in table.notes
        if note not in shared_notes
    ]


# ---- Cards -----------------------------------------------------------------------------------------------------------


def abaqus_card(table: JointTable, source: str) -> str:
    """Return an input card for Abaqus or CalculiX that defines a surface interaction."""
    row = table.reference
    friction, stiffness = row.friction(50), row.estimates["tangential_stiffness_per_area"]
    has_stick_slope = math.isfinite(stiffness.value)
    lines = [
        *_describe_source(table, source, "** ", omitted=describe_negative_closures(table.rows, table.closure_from)),
        *_comment_table(table, "** ", given=("closure", "friction_50")),
        *_format_comment(
            "Pressure, closure. The slave surface needs TYPE=NODE TO SURFACE in CalculiX. "
            f"{_describe_curve_start(table)} Above the last pressure the curve is not known. Unloading follows the "
            "same curve, although it is stiffer if contacts have yielded.", "** ",
        ),
        "*SURFACE INTERACTION, NAME=JOINT",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TABULAR",
        "0, 0",
        *(f"{_format_value(pressure)}, {_format_value(closure)}" for pressure, closure in _list_curve(table)),
    ]  # fmt: skip
    if not math.isfinite(friction.value):
        return "\n".join([*lines, "** No *FRICTION, because there is no median of mu_s: see the notes above."]) + "\n"
    lines += [
        *_format_comment(
            f"CalculiX: the median of mu_s and the stick slope (tangential stiffness) at {_pressure_text(row)}, "
            "because *FRICTION holds one coefficient and one stick slope for all pressures. For a 5 % fractile of the "
            f"sliding load, replace the coefficient by {_format_value(row.friction(5))}; for a 95 % fractile, by "
            f"{_format_value(row.friction(95))}.", "** ",
        ),
        *([] if has_stick_slope else _format_comment("No stick slope: see the notes above.", "** ")),
        "*FRICTION",
        _format_value(friction) + (f", {_format_value(stiffness)}" if has_stick_slope else ""),
        *_format_comment(
            "Abaqus: replace *FRICTION and its line by the following lines, without the asterisks in front: the median "
            "of mu_s, no slip rate, and the pressure. For the tangential stiffness, add the parameter ELASTIC SLIP: "
            "mu_s times the pressure over the tangential stiffness, at one pressure.", "** ",
        ),
        "** *FRICTION",
    ]  # fmt: skip
    lines += [f"** {_format_value(row.friction(50))}, , {_format_value(row.pressure)}" for row in table.rows]
    return "\n".join(lines) + "\n"


def ansys_card(table: JointTable, source: str) -> str:
    """Return the input card for Ansys: a gasket material (closure curve), and friction as a function of pressure."""
    reference, curve = table.reference, _list_curve(table)
    stiffness = reference.estimates["tangential_stiffness_per_area"]
    lines = [
        *_describe_source(table, source, "! ", omitted=describe_negative_closures(table.rows, table.closure_from)),
        *_comment_table(table, "! ", given=("closure", "friction_50")),
        *_format_comment(
            "Material 1: closure and pressure of interface elements (INTER192 to INTER195). "
            f"{_describe_curve_start(table)} The elements have no friction: use either this material or contact "
            "elements with material 2. Unloading follows the same curve, although it is stiffer if contacts have "
            "yielded.", "! ",
        ),
        f"TB,GASKET,1,,{len(curve)},COMP",
        *(f"TBPT,,{_format_value(closure)},{_format_value(pressure)}" for pressure, closure in curve),
    ]  # fmt: skip
    if math.isfinite(stiffness.value):
        lines += [
            *_format_comment(f"Transverse shear stiffness; one value only, that at {_pressure_text(reference)}.", "! "),
            "TB,GASKET,1,,,TSS",
            f"TBDATA,1,{_format_value(stiffness)}",
        ]
    if math.isfinite(reference.friction(50).value):
        lines += [
            *_format_comment(
                "Material 2: median of mu_s against pressure, for contact elements with the penalty method "
                "(KEYOPT(2)=1). Set FKN and FKT of the contact to minus the normal and minus the tangential stiffness "
                "at the pressure of your joint (table above): negative numbers are absolute, positive ones are "
                "factors, and a contact element has one value each.", "! ",
            ),
            "TB,FRIC,2,,,ISO",
        ]  # fmt: skip
        for row in table.rows:
            pressure, coefficient = _format_value(row.pressure), _format_value(row.friction(50))
            lines += [f"TBFIELD,NPRES,{pressure}", f"TBDATA,1,{coefficient}"]
    return "\n".join(lines) + "\n"


def liggghts_card(table: JointTable, source: str) -> str:
    """Return material properties for LIGGGHTS, taken from a joint table at the pressure `JointTable.reference`."""
    row = table.reference
    stiffnesses = {"kn": row.estimates["closure_stiffness"], "kt": row.estimates["tangential_stiffness_per_area"]}
    lines = [
        *_describe_source(table, source, "# "),
        *_comment_table(table, "# "),
        *_format_comment(
            f"LIGGGHTS holds one value each, here at {_pressure_text(row)} and for one atom type. Its kn and kt (model "
            "hooke/stiffness) are forces over lengths: multiply the stiffnesses below by the area that a contact "
            "between two grains represents. A dependence on the pressure must be updated by your script, from the "
            "table above.", "# ",
        ),
        *(
            f"variable {name}_per_area equal {_format_value(stiffness)}"
            for name, stiffness in stiffnesses.items()
            if math.isfinite(stiffness.value)
        ),
    ]  # fmt: skip
    if math.isfinite(row.friction(50).value):
        friction = _format_value(row.friction(50))
        lines.append(f"fix joint_friction all property/global coefficientFriction peratomtypepair 1 {friction}")
    return "\n".join(lines) + "\n"


def _list_curve(table: JointTable) -> list[tuple[Estimate, Estimate]]:
    """Return the closure curve for an input card, as pairs (pressure, closure); the pair (0, 0) is left out.

    Other programs require increasing closures. If the closure is counted from a pressure, a straight line leads from
    the origin to this pressure, so that the curve has no soft start. The closures of the curve then exceed those of the
    table by `_find_start_closure`.
    """
    start_closure, curve = _find_start_closure(table), []
    last_closure = 0.0
    for row in table.rows:
        closure = row.estimates["closure"]
        closure = replace(
            closure, value=closure.value + start_closure, lower=closure.lower + start_closure,
            upper=closure.upper + start_closure,
        )  # fmt: skip
        if row.pressure.value >= table.closure_from.value and closure.value > last_closure:
            curve.append((row.pressure, closure))
            last_closure = closure.value
    return curve


def _find_start_closure(table: JointTable) -> float:
    """Return the closure to add to an input card's curve, which then begins with a straight line from the origin.

    The line ends at the pressure from which closure is counted, and has the closure stiffness at this pressure. The
    result is 0 if closure is counted from first contact.
    """
    start_rows = [row for row in table.rows if row.pressure.value == table.closure_from.value]
    return start_rows[0].pressure.value / start_rows[0].estimates["closure_stiffness"].value if start_rows else 0.0


def _describe_curve_start(table: JointTable) -> str:
    """Return a sentence on the straight line with which an input card's closure curve begins."""
    start_closure = _find_start_closure(table)
    if start_closure == 0:
        return "Below the first pressure the curve is a straight line."
    return (
        f"Below {table.closure_from.value:.6g} {table.units.pressure}, from which the closure is counted, the curve is "
        f"a straight line with the stiffness at this pressure; its {start_closure:.4g} {table.units.length} are added "
        "to all closures."
    )


def _format_value(estimate: Estimate) -> str:
    """Return the value of an estimate as text for an input card.

    Pressures and closures have more digits than other quantities.
    """
    digits = CURVE_DIGITS if estimate.name in ("nominal_pressure", "closure") else MAX_SIGNIFICANT_DIGITS
    return f"{estimate.value:.{digits}g}"


def _pressure_text(row: JointRow) -> str:
    return f"{_format_value(row.pressure)} {row.pressure.unit}"


def _format_comment(text: str, prefix: str) -> list[str]:
    ascii_text = (
        "".join(_ASCII_REPLACEMENTS.get(character, character) for character in text).encode("ascii", "replace").decode()
    )
    return [f"{prefix}{line}" for line in textwrap.wrap(ascii_text, CARD_WIDTH, break_long_words=False)]


def _describe_source(table: JointTable, source: str, prefix: str, omitted: Collection[str] = ()) -> list[str]:
    """Return the first comment lines of an input card: version, units, notes of the joint table, and pair.

    Notes in `omitted` are left out.
    """
    units = table.units
    comment_texts = [
        f"Contact properties of a joint, computed with stiction {__version__}.",
        f"Units: {units.length}, {units.force}, {units.pressure}; stiffness {units.pressure}/{units.length}.",
        *(note for note in table.notes if note not in omitted),
        f"Pair: {source}",
    ]
    return [line for text in comment_texts for line in _format_comment(text, prefix)]


_CARD_COLUMNS = (
    "nominal_pressure", "closure", "closure_stiffness", "tangential_stiffness_per_area",
    "friction_5", "friction_50", "friction_95",
)  # fmt: skip
"""Names of the estimates that a card lists in comments.

More estimates would exceed the line limit of Abaqus (256 characters).
"""


def _comment_table(table: JointTable, prefix: str, given: Collection[str] = ()) -> list[str]:
    """Return, as comment lines for an input card, the main columns of a joint table with their intervals.

    The card itself contains the estimates named in `given`, so only their intervals are listed. The interval of a
    closure belongs to the closure in the card, and is empty for pressures that the card does not contain.
    """
    curve_closures = {pressure.value: closure for pressure, closure in _list_curve(table)}
    missing_closure = Estimate(math.nan, name="closure")

    def has_shown_column(name: str) -> bool:
        estimates = [row.estimates[name] for row in table.rows]
        return any(estimate.has_interval if name in given else math.isfinite(estimate.value) for estimate in estimates)

    names = [name for name in _CARD_COLUMNS if has_shown_column(name)]
    titles = "; ".join("interval of the " * (name in given) + JOINT_TITLES[name] for name in names)
    lines = _format_comment(f"Table: {titles}; assessment of mu_s. In brackets: 95 % intervals.", prefix)
    for row in table.rows:
        cells = []
        for name in names:
            estimate, digits = row.estimates[name], MAX_SIGNIFICANT_DIGITS
            if name == "closure" and name in given:
                estimate = curve_closures.get(row.pressure.value, missing_closure)
            value = _format_value(estimate) if name == "nominal_pressure" else f"{estimate.value:.{digits}g}"
            interval = f"[{estimate.lower:.{digits}g}, {estimate.upper:.{digits}g}]" if estimate.has_interval else ""
            cells.append(interval if name in given else f"{value} {interval}".rstrip())
        lines.append(prefix + "; ".join([*cells, row.assessment]))
    return lines
