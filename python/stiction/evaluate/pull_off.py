"""Adhesion without external load: pull-off force, pull-off pressure, and friction at zero load."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from stiction._estimate import Estimate
from stiction.evaluate.point import read_estimate, select_sliding_rule
from stiction.study.inputs import Inputs
from stiction.study.moduli import MODULUS_NAMES

if TYPE_CHECKING:
    import xarray

    from stiction.study.study import Study

MIN_STICKING_PRESSURE = 1e-7
"""Minimum pull-off pressure (GPa) of bodies that stick.

The value is 100 Pa, the weight per area of a steel plate that is 1.3 mm thick.
"""


@dataclass(frozen=True)
class PullOffValues:
    """Pull-off force (mN), pull-off pressure (GPa) and friction force at zero load (mN), with 95 % intervals."""

    force: Estimate
    pressure: Estimate
    friction: Estimate
    # True if only a lower bound of the pull-off force is known for some members of the pair.
    is_bound: bool
    area_inputs: tuple[str, ...] = ()

    @property
    def sticking_assessment(self) -> Literal["yes", "no", "uncertain"]:
        """Assessment of whether the bodies stick together without a load: "yes", "no" or "uncertain".

        The assessment is "yes" if the interval of the pull-off pressure is above `MIN_STICKING_PRESSURE`, "no" if the
        interval is below, and "uncertain" if it contains this pressure.
        """
        pressure = self.pressure
        lower, upper = (limit if math.isfinite(limit) else pressure.value for limit in pressure.interval)
        if lower > MIN_STICKING_PRESSURE:
            return "yes"
        return "no" if upper < MIN_STICKING_PRESSURE and not self.is_bound else "uncertain"


def find_pull_off_values(point: xarray.Dataset, study: Study, rule: str) -> PullOffValues | None:
    """Return pull-off force, pull-off pressure and friction at zero load.

    Returns None if the bodies do not adhere.
    """
    if "pull_off" not in point or "pull_off_pressure" not in point:
        return None
    force, pressure, friction = (
        read_estimate(select_sliding_rule(point[quantity_name], rule))
        for quantity_name in ("pull_off", "pull_off_pressure", "friction_at_no_load")
    )
    bound_fraction = float(point["share_of_pull_off_bounds"].sel(statistic="mean"))
    area_inputs = tuple(
        entry.label
        for input_name, entry in Inputs.from_study(study).uncertain.items()
        if input_name == "hardness" or input_name.startswith(("effective_modulus", *MODULUS_NAMES))
    )
    return PullOffValues(force, pressure, friction, bound_fraction > 0, area_inputs if friction.value else ())
