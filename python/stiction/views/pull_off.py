"""Pull-off force of adhering bodies, as a sentence and as a JSON record."""

from __future__ import annotations

import math
from typing import Any

from stiction._estimate import Estimate
from stiction._number_format import format_with_unit
from stiction.evaluate.pull_off import MIN_STICKING_PRESSURE, PullOffValues
from stiction.mechanics.quantities import QUANTITIES


def pull_off_text(estimate: PullOffValues, inputs: str = "") -> str:
    """Return a sentence about adhesion at zero load: pull-off force, pull-off pressure and friction.

    `inputs` describes mu0 and tau0 of the friction if the result has several values of them.
    """
    bound_text = "at least " if estimate.is_bound else ""
    threshold_value_text = f"{format_with_unit(MIN_STICKING_PRESSURE, 'GPa')}, the weight of 1.3 mm of steel"
    threshold_text = {
        "yes": "",
        "no": f", less than {threshold_value_text}",
        "uncertain": f"; the threshold is {threshold_value_text}",
    }[estimate.sticking_assessment]
    return (
        f"Sticks without a load: {estimate.sticking_assessment}. Pull-off force {bound_text}"
        f"{_text_with_unit(estimate.pull_off, 'pull_off')}, "
        f"{_text_with_unit(estimate.pressure, 'pull_off_pressure')} on the nominal area{threshold_text}; friction at "
        f"no load {_text_with_unit(estimate.friction, 'friction_at_no_load')}{inputs and f' with {inputs}'}."
    )


def pull_off_record(estimate: PullOffValues) -> dict[str, Any]:
    """Return the pull-off force (mN), the pull-off pressure (GPa) and the friction at zero load (mN) as JSON fields."""
    return {
        "sticks": estimate.sticking_assessment,
        "pull_off_is_bound": estimate.is_bound,
        "pull_off": vars(estimate.pull_off),
        "pull_off_pressure": vars(estimate.pressure),
        "friction_at_no_load": vars(estimate.friction),
    }


def _text_with_unit(estimate: Estimate, name: str) -> str:
    """Return a quantity with its interval, in the unit with the fewest zeros."""
    scaled_estimate, unit = estimate.in_prefixed_unit(QUANTITIES[name].unit)
    return "none" if math.isnan(estimate.value) else f"{scaled_estimate:.2u} {unit}"
