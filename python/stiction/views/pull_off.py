"""Whether bodies that adhere stick together without a load, as a sentence and as a record."""

from __future__ import annotations

from typing import Any

import numpy as np

from stiction._number_format import finite, prefix, with_interval, with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.pull_off import STICKING_PRESSURE, Sticking, Three


def sticking_text(sticking: Sticking, inputs: str = "") -> str:
    """Return whether bodies stick, with forces and pressures, in one or two sentences.

    `inputs` names the mu0 and tau0 of the friction, where there are several.
    """
    least = "at least " if sticking.is_bound else ""
    limit = f"{with_unit(STICKING_PRESSURE, 'GPa')}, the weight of 1.3 mm of steel"
    where = {"yes": "", "no": f", less than {limit}", "uncertain": f"; the threshold is {limit}"}[sticking.sticks]
    return (
        f"Sticks without a load: {sticking.sticks}. Pull-off force {least}{_shown(sticking.pull_off, 'pull_off')}, "
        f"{_shown(sticking.pressure, 'pull_off_pressure')} on the nominal area{where}; friction at no load "
        f"{_shown(sticking.friction, 'friction_at_no_load')}{inputs and f' with {inputs}'}."
    )


def sticking_record(sticking: Sticking) -> dict[str, Any]:
    """Return the fields for JSON, in mN and GPa."""
    named = {
        "pull_off": sticking.pull_off,
        "pull_off_pressure": sticking.pressure,
        "friction_at_no_load": sticking.friction,
    }
    names = ("value", "lower", "upper")
    values = {key: dict(zip(names, map(finite, three), strict=True)) for key, three in named.items()}
    return {"sticks": sticking.sticks, "pull_off_is_bound": sticking.is_bound, **values}


def _shown(three: Three, name: str) -> str:
    """Return a mean with its interval, in the unit with the fewest zeros."""
    factor, unit = prefix(three[0], QUANTITIES[name].unit) if np.isfinite(three[0]) else (1.0, "")
    value, lower, upper = (each / factor for each in three)
    return f"{with_interval(value, lower, upper)} {unit}".replace(" no interval", "").rstrip()
