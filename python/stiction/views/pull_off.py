"""Format the pull-off force of adhering bodies as a sentence and as a record."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiction._number_format import finite, prefix, with_interval, with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.pull_off import STICKING_PRESSURE, Sticking, ValueWithInterval


def pull_off_text(sticking: Sticking, inputs: str = "") -> str:
    """Return whether bodies stick without a load, with pull-off force, pressure and friction.

    `inputs` are mu0 and tau0 of the friction, if the result has several values.
    """
    bound = "at least " if sticking.is_bound else ""
    limit = f"{with_unit(STICKING_PRESSURE, 'GPa')}, the weight of 1.3 mm of steel"
    where = {"yes": "", "no": f", less than {limit}", "uncertain": f"; the threshold is {limit}"}[sticking.sticks]
    return (
        f"Sticks without a load: {sticking.sticks}. Pull-off force {bound}{_shown(sticking.pull_off, 'pull_off')}, "
        f"{_shown(sticking.pressure, 'pull_off_pressure')} on the nominal area{where}; friction at no load "
        f"{_shown(sticking.friction, 'friction_at_no_load')}{inputs and f' with {inputs}'}."
    )


def pull_off_record(sticking: Sticking) -> dict[str, Any]:
    """Return the fields for JSON, in mN and GPa."""
    intervals = {
        "pull_off": sticking.pull_off,
        "pull_off_pressure": sticking.pressure,
        "friction_at_no_load": sticking.friction,
    }
    names = ("value", "lower", "upper")
    values = {key: dict(zip(names, map(finite, interval), strict=True)) for key, interval in intervals.items()}
    return {"sticks": sticking.sticks, "pull_off_is_bound": sticking.is_bound, **values}


def _shown(interval: ValueWithInterval, name: str) -> str:
    """Return a mean with its interval, in the unit with the fewest zeros."""
    factor, unit = prefix(interval[0], QUANTITIES[name].unit) if np.isfinite(interval[0]) else (1.0, "")
    value, lower, upper = (item / factor for item in interval)
    return f"{with_interval(value, lower, upper)} {unit}".replace(" no interval", "").rstrip()
