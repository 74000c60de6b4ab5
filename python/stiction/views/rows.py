"""Results as rows, for other programs: one frame of an answer, from which CSV and JSON are made.

JSON has one schema for every command. A record has ``schema`` (this number grows when a reader would have to change),
``stiction`` (the version), ``command``, what it is about, and ``values``. A value has ``name``, ``value``, ``unit``
("1" if it has none), ``lower`` and ``upper`` (the 95 % interval), ``at`` (where it is, in µm, mN, GPa and degrees) and
``status``. Of results there are ``answers`` besides: what may be quoted of each point, with its doubts. What there is
none of is null.
"""

from __future__ import annotations

import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._core import __version__
from stiction._number_format import duration, finite, quoted
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.quantities import QUANTITIES, column_of, shown_in
from stiction.studies.point import CELLS, rules_of
from stiction.studies.summary import PointSummary, Summary
from stiction.views.onset import onset_record, words_of
from stiction.views.pull_off import sticking_record
from stiction.views.resolution import resolution_record
from stiction.views.sentence import assumptions_of, covers_text, sentence_text
from stiction.views.spreadsheet import csv_of_frame

if TYPE_CHECKING:
    import pandas
    import xarray


SCHEMA = 1
_KEYS = (*CELLS, "load", "mu0", "tau0")  # coordinates that say where a row of the CSV is

PLACE = ("height_scale", *_KEYS, "sliding", "direction", "axis", "fraction_below", "input", "wait")
"""Coordinates that say where a value is, in the order of their columns."""

_FRICTION = {
    "friction_all_round": "all directions", "friction_by_axis": "axis", "friction_coefficient": "direction",
}  # fmt: skip
"""Coefficients that are rows of the CSV, and what the motion of each is called."""

_COLUMNS = ("name", "value", "unit", "lower", "upper", "interval", "status")

_MOTIONS = {"axis": "along {:g}".format, "direction": "{:g}".format}


# ---- The frame -------------------------------------------------------------------------------------------------------


def frame(at: xarray.Dataset) -> pandas.DataFrame:
    """Return every number of what `at_load` gives: a row for each, with its name, unit, interval, status and place.

    Parameters
    ----------
    at : xarray.Dataset
        What `at_load` returns.

    Returns
    -------
    pandas.DataFrame
        Columns ``name``, ``value``, ``unit``, ``lower``, ``upper``, ``interval`` (which one it is, "" for none),
        ``status``, and those of `PLACE` that the result has: in µm, mN, GPa and degrees. A place that a value does not
        depend on is NaN. The order of names is that of `QUANTITIES`; the first has the interval to show.
    """
    import pandas

    numbers = [str(name) for name, table in at.data_vars.items() if table.dtype.kind in "if"]
    order = {name: place for place, name in enumerate(QUANTITIES)}
    parts = [_rows_of(at, name) for name in sorted(numbers, key=lambda name: order.get(name, len(order)))]
    whole = pandas.concat(parts, ignore_index=True)
    places = [name for name in PLACE if name in whole]
    return whole[[*_COLUMNS, *places]]


def _rows_of(at: xarray.Dataset, name: str) -> pandas.DataFrame:
    """A row for each number of one table; made of its arrays, because datasets take ten times as long."""
    import pandas

    table = at.variables[name]
    dims = [str(dim) for dim in table.dims if dim != "statistic"]
    shape = tuple(at.sizes[dim] for dim in dims)

    def along(own: xarray.Variable) -> Any:
        """Values of some of the dimensions, one for each row."""
        there = own.transpose(*(dim for dim in dims if dim in own.dims)).values
        places = tuple(slice(None) if dim in own.dims else None for dim in dims)
        return np.broadcast_to(there[places], shape).ravel()

    columns: dict[str, Any] = {"name": name}
    columns |= dict.fromkeys(("value", "lower", "upper"), math.nan)
    if "statistic" in table.dims:
        for place, each in enumerate(at["statistic"].values):
            own = table.isel(statistic=place)
            columns["value" if each == "mean" else str(each)] = along(own).astype(float)
    else:
        columns["value"] = along(table).astype(float)
    has_interval = "statistic" in table.dims and name in QUANTITIES
    columns["interval"] = QUANTITIES[name].interval if has_interval else ""
    own_unit = QUANTITIES[name].unit if name in QUANTITIES else "1"
    columns["unit"] = str(table.attrs.get("units", own_unit)).replace("um^2", "um2") or "1"
    if name == "contact_area_fraction" and "contact_status" in at:
        columns["status"] = along(at.variables["contact_status"])
    elif "status" in at and set(at["status"].dims) <= set(dims):
        columns["status"] = along(at.variables["status"])
    else:
        columns["status"] = np.where(np.isfinite(columns["value"]), STATUS_OK, "no-mean")
    directed = name in QUANTITIES and QUANTITIES[name].directed
    for each in PLACE:
        # Of one sliding rule or direction the coordinate is single: a column all the same.
        single = each in at.coords and not at.coords[each].ndim
        if each in dims or (single and (directed or each not in ("sliding", "direction"))):
            columns[each] = along(at.variables[each])
    return pandas.DataFrame(columns)


# ---- CSV -------------------------------------------------------------------------------------------------------------


def csv_text(summary: Summary) -> str:
    """`table_of` for spreadsheets."""
    return csv_of_frame(table_of(summary))


def table_of(summary: Summary) -> pandas.DataFrame:
    """A row for each cell, load, mu0, tau0, sliding rule and motion; units in the header.

    The interval of the coefficient is the combined one, which only the mean of all directions has; the sampling
    interval of the mean over members has columns of its own. Rows of the reading to quote come first.

    Each row has the coefficient of static friction of its motion (all directions, an axis or a direction), the
    quantities of its load, and the verdict and the doubts of its answer.
    """
    import pandas

    at, study = summary.at, summary.study
    rows = frame(at)
    keys = [name for name in _KEYS if name in rows]
    parts: list[pandas.DataFrame] = []
    for name, motion in _FRICTION.items():
        if name not in at or (name != "friction_all_round" and parts and motion not in at[name].dims):
            continue  # of one direction, which is all of them
        own = rows[rows["name"] == name]
        column = own[motion].map(_MOTIONS[motion]) if motion in at[name].dims else _FRICTION["friction_all_round"]
        own = own.assign(motion=column, sliding=own["sliding"] if "sliding" in own else rules_of(study)[0])
        parts.append(own[[*keys, "sliding", "motion", "status", "value", "lower", "upper"]])
    table = pandas.concat(parts, ignore_index=True)
    title = "coefficient of static friction"
    ends = {f"{title}: {end}": f"{title}: sampling {end}" for end in ("lower", "upper")}
    table = table.rename(columns={"value": title} | dict(zip(("lower", "upper"), ends.values(), strict=True)))
    for name in _of_loads(at):
        own = rows[rows["name"] == name]
        on = [key for key in (*keys, "sliding") if key in own and own[key].notna().all()]
        words = words_of(name, study).replace("μ", "mu").replace("τ", "tau")
        unit = "" if own["unit"].iloc[0] == "1" else f" ({own['unit'].iloc[0]})"
        columns = {"value": f"{words}{unit}", "lower": f"{words}{unit}: lower", "upper": f"{words}{unit}: upper"}
        table = table.merge(own[[*on, *columns]].rename(columns=columns), on=on, how="left")
    table = table.merge(_verdicts(summary.points, keys), on=[*keys, "sliding"], how="left")
    of_mean = [name for name in table if name in ends or name.startswith("mu_s ")]
    table.loc[table["motion"] != _FRICTION["friction_all_round"], of_mean] = math.nan
    others = [str(name) for name in table if name not in ends]
    place = others.index(title) + 1
    table = table[[*others[:place], *ends, *others[place:]]]
    for key in keys:
        table[key] *= column_of(key)[1]
    return table.rename(columns={key: column_of(key)[0] for key in keys} | {"motion": "upper body to (degree)"})


def _of_loads(at: xarray.Dataset) -> list[str]:
    """Return the quantities of the columns of a CSV file, without those that depend on one of several directions."""
    return [name for name in shown_in("csv") if name in at and at[name].sizes.get("direction", 1) == 1]


def _verdicts(found: Sequence[PointSummary], keys: Sequence[str]) -> pandas.DataFrame:
    import pandas

    rules = [(one, rule, rule is one.rules[0]) for one in found for rule in one.rules]
    waited = {
        f"mu_s after {duration(each.seconds)}{end}": [
            getattr(one.waited[index], name) if first else math.nan for one, _, first in rules
        ]
        for index, each in enumerate(found[0].waited if found else ())
        for name, end in (("value", ""), ("lower", ": lower"), ("upper", ": upper"))
    }
    return pandas.DataFrame(
        {
            **{key: [one.at[key] for one, *_ in rules] for key in keys},
            "sliding": [rule.rule for _, rule, _ in rules],
            **{
                f"coefficient of static friction: {end}": [getattr(rule, end) for _, rule, _ in rules]
                for end in ("lower", "upper")
            },
            **waited,
            "mu_s from roughness": [
                math.nan if one.from_roughness is None or not first else one.from_roughness for one, _, first in rules
            ],
            "headline": [not one.covered for one, *_ in rules],
            "assumptions": ["; ".join(assumptions_of(one.study)) for one, *_ in rules],
            "contact status": [one.contact_status for one, *_ in rules],
            "verdict": [one.verdict for one, *_ in rules],
            "doubts": ["; ".join(f"{doubt.text}: {doubt.cure}" for doubt in one.doubts) for one, *_ in rules],
        }
    )


# ---- JSON ------------------------------------------------------------------------------------------------------------


def record(command: str, values: list[dict[str, Any]], **about: Any) -> str:
    """A record as JSON text."""
    whole = {"schema": SCHEMA, "stiction": __version__, "command": command, **about, "values": values}
    return json.dumps(whole, ensure_ascii=False, allow_nan=False, indent=1)


def entry(
    name: str, value: float, unit: str = "1", *, lower: float = math.nan, upper: float = math.nan,
    interval: str | None = None, at: dict[str, Any] | None = None, status: str = STATUS_OK,
) -> dict[str, Any]:  # fmt: skip
    """One value."""
    return {
        "name": name, "value": finite(value), "unit": unit, "lower": finite(lower), "upper": finite(upper),
        **({} if interval is None else {"interval": interval}), "at": at or {}, "status": status,
    }  # fmt: skip


def record_text(command: str, summary: Summary, /, **about: Any) -> str:
    """Return the record of a command on a result: every value, the points with their caveats, resolution and onset."""
    at, study = summary.at, summary.study
    about = {"kind": "pair" if study.is_measured else "study", **about}
    about |= {name: str(at.attrs[name]) for name in ("upper", "lower", "reading") if name in at.attrs}
    for name in ("effective_modulus", "nominal_area"):
        if name in at.coords:
            about[name] = float(at[name])
    resolution = resolution_record(at, study, summary.over_cut_offs)
    about |= {} if resolution is None else {"resolution": resolution}
    about |= {} if summary.onset is None else {"onset": onset_record(summary.onset)}
    about["answers"] = [answer_record(one) for one in summary.points]
    return record(command, values_of(frame(at)), **about)


def values_of(rows: pandas.DataFrame) -> list[dict[str, Any]]:
    """The values of a record, from a frame."""
    values = []
    for row in rows.to_dict("records"):
        own = {name: row.pop(name) for name in _COLUMNS}
        where = {name: place for name, place in row.items() if place == place}  # without NaN
        values.append(entry(**own, at=where))
    return values


def answer_record(one: PointSummary) -> dict[str, Any]:
    """What may be quoted of a point."""
    return {
        "at": one.at,
        "headline": not one.covered,  # or the other reading of a scan, which the interval of a headline covers
        "status": one.status,
        "rules": [
            {
                "rule": rule.rule, "text": quoted(rule.value, rule.lower, rule.upper),
                "value": finite(rule.value), "lower": finite(rule.lower),
                "upper": finite(rule.upper), "members_from": finite(rule.low), "members_to": finite(rule.high),
                "by_slopes_alone": finite(rule.slopes),
                **{name: {"lower": finite(low), "upper": finite(high)}
                   for name, (low, high) in (("of_positions", rule.positions), ("next_test", rule.next_test))},
            }
            for rule in one.rules
        ],
        "parts": None if one.parts is None else dict(zip(("mu0", "adhesion", "slopes"), one.parts, strict=True)),
        "budget": [
            {"if_known": left.words, "lower": left.lower, "upper": left.upper, "width": left.width}
            for left in one.budget
        ],
        "waited": [{name: finite(value) for name, value in vars(each).items()} for each in one.waited],
        "scans": dict(zip(("upper", "lower"), one.scans, strict=True)),
        "contact_status": one.contact_status,
        "sticking": None if one.sticking is None else sticking_record(one.sticking),
        "verdict": one.verdict,
        "sentence": sentence_text(one),
        "from_roughness": one.from_roughness, "assumptions": list(assumptions_of(one.study)),
        "interval_covers": covers_text(one),
        "finer_scans": None if one.bracket is None else {
            "from": one.bracket[0], "to": one.bracket[1], "rule": "all", "hardness": one.hardness,
        },
        "doubts": [{"text": each.text, "cure": each.cure, "severity": each.severity} for each in one.doubts],
    }  # fmt: skip
