"""Content of a report before it is rendered as HTML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiction._number_format import format_percent, format_with_unit
from stiction.evaluate.intervals import CONFIDENCE_LEVEL
from stiction.mechanics import friction
from stiction.study.study import Study
from stiction.summary.assessment import MAX_AFFECTED_FRACTION, STATUS_EXPLANATIONS
from stiction.summary.report_data import ReportDataOfGeneratedSurfaces, ReportDataOfMeasuredSurfaces
from stiction.summary.report_grid import ParameterAxis
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
from stiction.views.report.tables import QuantityEstimates, ReportArray
from stiction.views.style import COLOUR_BAR_TICKS, SLIDING_RULE_LABELS


@dataclass(frozen=True, eq=False)
class ReportContent:
    """Content of a report before rendering as HTML: title, texts, and data for the page scripts.

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
    quantities : sequence of QuantityEstimates
        Quantities that do not depend on mu0 and tau0.
    """

    name: str
    heading_lines: list[str]
    members_text: str
    description_markup: str
    facts: dict[str, Any]
    arrays: Mapping[str, ReportArray]
    quantities: Sequence[QuantityEstimates] = ()


STATUS_LABELS = {
    friction.STATUS_OK: "", friction.STATUS_NOT_REACHED: "load not reached",
    friction.STATUS_BELOW_RANGE: "below the loads computed", friction.STATUS_NO_CONTACT: "no contact",
    friction.STATUS_NOT_SOLVED: "not solved", friction.STATUS_SELF_LOCKED: "self-locked: no load is supported",
    friction.STATUS_SEIZURE: "seizure: junctions grow without limit",
    friction.STATUS_BULK_SHEAR: "bulk shear: the coefficient is a lower limit",
    friction.STATUS_DOWNHILL: "slides downhill without a tangential load",
}  # fmt: skip
"""Legend labels of the statuses in a friction chart. `STATUS_EXPLANATIONS` contains the reasons for statuses."""

BEYOND_MODEL_TEXT = (
    f"beyond the model: over {format_percent(MAX_AFFECTED_FRACTION)} of the load beyond Hertz (overlap > radius / 10) "
    "or on radii below the grid spacing"
)


def common_script_data(
    data: ReportDataOfMeasuredSurfaces | ReportDataOfGeneratedSurfaces, axes: tuple[ParameterAxis, ParameterAxis] | None
) -> dict[str, Any]:
    """Return data for the scripts that all reports contain, such as slider values, labels and statuses.

    `axes` contains the numbers of mu0 and tau0 for the sliders, or is None if no pair is in contact.
    """
    modulus = float(data.study.contact.effective_modulus)
    return {
        "axes": None if axes is None else _slider_settings(axes, data.study),
        "percent": f"{100 * CONFIDENCE_LEVEL:g} %", "ticks": COLOUR_BAR_TICKS,
        "ruleDescriptions": SLIDING_RULE_DESCRIPTIONS, "ruleNames": SLIDING_RULE_LABELS,
        "why": {
            name: {"short": short_label, "why": STATUS_EXPLANATIONS.get(name, ("",))[0]}
            for name, short_label in STATUS_LABELS.items()
        },
        "strength": _shear_strength_limit(modulus), "beyondModel": BEYOND_MODEL_TEXT,
        "rules": data.rules, "directions": data.directions,
    }  # fmt: skip


def _shear_strength_limit(modulus: float) -> dict[str, Any]:
    """Return the largest plausible tau0 (MPa), and the text that a report shows if a slider is set above it."""
    ratio = friction.MAX_SHEAR_STRENGTH_RATIO
    text = f"τ0 is above {format_percent(ratio)} of the effective modulus, {format_with_unit(ratio * modulus, 'GPa')}."
    return {"limit": 1000 * ratio * modulus, "text": text}


def _slider_settings(axes: tuple[ParameterAxis, ParameterAxis], study: Study) -> dict[str, Any]:
    """Return settings of the mu0 and tau0 (MPa) sliders: all values, initial value, and values with an input range."""
    initial_values = (
        study.friction.mu0[0 if study.is_measured else len(study.friction.mu0) // 2],
        float(study.friction.tau0[0]),
    )
    facts = {}
    for name, axis, initial_value, unit in zip(("mu0", "tau0"), axes, initial_values, (1.0, 1e3), strict=True):
        slider_values = np.array([float(f"{unit * value:.12g}") for value in axis.values])
        facts[name] = {
            "values": slider_values.tolist(), "start": float(slider_values[axis.find_index(initial_value)]),
            "ranged": slider_values[axis.has_range].tolist(),
        }  # fmt: skip
    return facts
