"""Content of a report on a result, before it is rendered."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiction._number_format import format_percent, format_significant, format_with_unit
from stiction.evaluate.intervals import CONFIDENCE_LEVEL
from stiction.mechanics import friction
from stiction.study.study import Study
from stiction.summary.assessment import MAX_AFFECTED_FRACTION, STATUS_EXPLANATIONS
from stiction.summary.nodes import NodeAxis
from stiction.summary.report_data import GeneratedReportData, MeasuredReportData
from stiction.views.figures.ensemble import COLOUR_BAR_TICKS
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
from stiction.views.report.tables import QuantityTable, ReportArray
from stiction.views.style import SLIDING_RULE_LABELS


@dataclass(frozen=True, eq=False)
class ReportContent:
    """Content of a report.

    Attributes
    ----------
    name : str
        Title.
    heading_lines : list of str
        Lines below the title.
    members_text : str
        Number and kind of members.
    description_markup : str
        Markup that describes the study and its surfaces.
    facts : dict
        Data for the scripts: texts and numbers.
    arrays : dict
        Data for the scripts: arrays of numbers, by name.
    quantities : sequence of QuantityTable
        Quantities that do not depend on mu0 and tau0.
    """

    name: str
    heading_lines: list[str]
    members_text: str
    description_markup: str
    facts: dict[str, Any]
    arrays: Mapping[str, ReportArray]
    quantities: Sequence[QuantityTable] = ()


BETWEEN_NODES_STATUS = "between-nodes"
"""Status of a coefficient that is not interpolated between nodes."""

STATUS_LABELS = {
    friction.STATUS_OK: "", friction.STATUS_NOT_REACHED: "load not reached",
    friction.STATUS_BELOW_RANGE: "below the loads computed", friction.STATUS_NO_CONTACT: "no contact",
    friction.STATUS_NOT_SOLVED: "not solved", friction.STATUS_SELF_LOCKED: "self-locked: no load is supported",
    friction.STATUS_SEIZURE: "seizure: junctions grow without limit",
    friction.STATUS_DOWNHILL: "slides downhill without a tangential load",
    BETWEEN_NODES_STATUS: "not resolved between nodes",
}  # fmt: skip
"""Texts for the statuses in the legend of the map; `STATUS_EXPLANATIONS` contains the reasons."""

NOT_INTERPOLATED_REASON = (
    "the coefficient or its interval changes too much between the values of μ0 and τ0 at which the library evaluated it"
)

BEYOND_MODEL_TEXT = (
    f"beyond the model: over {format_percent(MAX_AFFECTED_FRACTION)} of the load beyond Hertz (overlap > radius / 10) "
    "or on radii below the grid spacing"
)


def common_facts(data: MeasuredReportData | GeneratedReportData) -> dict[str, Any]:
    """Return the facts that the pages of generated and measured surfaces have in common."""
    modulus, values = float(data.study.contact.effective_modulus), data.values
    return {
        "axes": None if values is None else _slider_settings(values.axes, data.study),
        "percent": f"{100 * CONFIDENCE_LEVEL:g} %", "ticks": COLOUR_BAR_TICKS,
        "ruleDescriptions": SLIDING_RULE_DESCRIPTIONS, "ruleNames": SLIDING_RULE_LABELS,
        "why": {
            name: {"short": short_label, "why": _status_reason(name)} for name, short_label in STATUS_LABELS.items()
        },
        "strength": _strength_limit(modulus), "beyondModel": BEYOND_MODEL_TEXT,
        "rules": data.rules, "directions": data.directions,
        "error": None if values is None else values.interpolation_errors,
        "errorText": "" if values is None else _interpolation_error_text(*values.interpolation_errors),
    }  # fmt: skip


def _status_reason(status: str) -> str:
    return NOT_INTERPOLATED_REASON if status == BETWEEN_NODES_STATUS else STATUS_EXPLANATIONS.get(status, ("",))[0]


def _strength_limit(modulus: float) -> dict[str, Any]:
    """Return the largest plausible tau0 (MPa), and a notice about larger values."""
    ratio = friction.MAX_SHEAR_STRENGTH_RATIO
    text = f"τ0 is above {format_percent(ratio)} of the effective modulus, {format_with_unit(ratio * modulus, 'GPa')}."
    return {"limit": 1000 * ratio * modulus, "text": text}


def _interpolation_error_text(value_error: float, end_error: float) -> str:
    """Return a sentence fragment that states the measured interpolation error."""
    value_text, end_text = (
        text if text.startswith("less than") else f"up to {text}"
        for text in map(format_percent, (value_error, end_error))
    )
    return (
        f"at other evaluated μ0 and τ0, interpolated coefficients differ from evaluated ones by {value_text}, and "
        f"interval limits by {end_text} of the interval width."
    )


def _slider_settings(axes: tuple[NodeAxis, NodeAxis], study: Study) -> dict[str, Any]:
    """Return the nodes of mu0 and tau0 (MPa) for a page, with the step and the initial value of each slider."""
    initial_values = (
        study.friction.mu0[0 if study.is_measured else len(study.friction.mu0) // 2],
        float(study.friction.tau0[0]),
    )
    facts = {}
    for name, axis, initial_value, unit in zip(("mu0", "tau0"), axes, initial_values, (1.0, 1e3), strict=True):
        max_value = unit * float(axis.rising[-1])
        facts[name] = {
            "rising": (unit * axis.rising).tolist(),
            "bounds": (unit * np.array(axis.ranged_node_intervals)).reshape(-1, 2).tolist(),
            "most": max_value, "mostText": format_significant(max_value, 4),
            "step": 0.01 if name == "mu0" else float(f"{max_value / 200:.0e}"),
            "start": float(f"{unit * float(initial_value):.12g}"),
        }  # fmt: skip
    return facts
