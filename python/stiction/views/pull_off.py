"""Pull-off force of adhesive bodies as a sentence and JSON."""

from __future__ import annotations

import math
from typing import Any

from stiction._estimate import Estimate
from stiction._number_format import format_with_unit
from stiction.evaluate.pull_off import MIN_STICKING_PRESSURE, PullOffValues


def pull_off_text(estimate: PullOffValues, inputs: str = "") -> str:
    """Return a sentence on adhesion at zero load: pull-off force, pull-off pressure, and friction.

    `inputs` describes mu0 and tau0 of the friction if the result has several mu0 or tau0.
    """
    bound_text = "at least " if estimate.is_bound else ""
    threshold_value_text = f"{format_with_unit(MIN_STICKING_PRESSURE, 'GPa')}, the weight of 1.3 mm of steel"
    threshold_text = {
        "yes": "",
        "no": f", less than {threshold_value_text}",
        "uncertain": f"; the threshold is {threshold_value_text}",
    }[estimate.sticking_assessment]
    area_text = (
        f"; its interval includes the effect of {' and '.join(estimate.area_inputs)} on the area, not on the attraction"
        if estimate.area_inputs
        else ""
    )
    return (
        f"Sticks without a load: {estimate.sticking_assessment}. Pull-off force {bound_text}"
        f"{_text_with_unit(estimate.force)}, "
        f"{_text_with_unit(estimate.pressure)} on the nominal area{threshold_text}; friction at "
        f"no load {_text_with_unit(estimate.friction)}{inputs and f' with {inputs}'}{area_text}."
    )


def pull_off_record(estimate: PullOffValues) -> dict[str, Any]:
    """Return pull-off force, pull-off pressure and friction at zero load as the fields of a JSON object."""
    return {
        "sticks": estimate.sticking_assessment,
        "force_is_bound": estimate.is_bound,
        "force": estimate.force.to_record(),
        "pressure": estimate.pressure.to_record(),
        "friction": estimate.friction.to_record(),
    }


def _text_with_unit(estimate: Estimate) -> str:
    """Return an estimate and its interval as text, with a unit prefix that suits the size of the estimate."""
    scaled_estimate = estimate.in_prefixed_unit()
    return "none" if math.isnan(estimate.value) else f"{scaled_estimate.text()} {scaled_estimate.unit}"
