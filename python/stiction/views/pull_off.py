"""Pull-off force of adhering bodies, as a sentence and as a JSON record."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiction._number_format import choose_prefixed_unit, format_with_interval, format_with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.pull_off import MIN_STICKING_PRESSURE, PullOffValues, ValueWithInterval


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
        f"{_format_interval(estimate.pull_off, 'pull_off')}, "
        f"{_format_interval(estimate.pressure, 'pull_off_pressure')} on the nominal area{threshold_text}; friction at "
        f"no load {_format_interval(estimate.friction, 'friction_at_no_load')}{inputs and f' with {inputs}'}."
    )


def pull_off_record(estimate: PullOffValues) -> dict[str, Any]:
    """Return the pull-off force (mN), the pull-off pressure (GPa) and the friction at zero load (mN) as JSON fields."""
    intervals = {
        "pull_off": estimate.pull_off,
        "pull_off_pressure": estimate.pressure,
        "friction_at_no_load": estimate.friction,
    }
    names = ("value", "lower", "upper")
    values = {key: dict(zip(names, interval, strict=True)) for key, interval in intervals.items()}
    return {"sticks": estimate.sticking_assessment, "pull_off_is_bound": estimate.is_bound, **values}


def _format_interval(interval: ValueWithInterval, name: str) -> str:
    """Return a mean with its interval, in the unit with the fewest zeros."""
    prefix_factor, unit = (
        choose_prefixed_unit(interval[0], QUANTITIES[name].unit) if np.isfinite(interval[0]) else (1.0, "")
    )
    value, lower, upper = (item / prefix_factor for item in interval)
    return f"{format_with_interval(value, lower, upper)} {unit}".replace(" no interval", "").rstrip()
