"""Text about requested loads at which no friction coefficient is available."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiction._number_format import format_load
from stiction.evaluate.computed_loads import find_computed_load_range
from stiction.evaluate.point import has_nominal_area
from stiction.study.study import find_step_dimension
from stiction.summary.assessment import STATUS_EXPLANATIONS

if TYPE_CHECKING:
    import xarray

    from stiction.solve.member_sums import MemberSums


def missing_loads_text(result: MemberSums, values: xarray.Dataset, missing_loads: Sequence[float]) -> str:
    """Return a sentence on loads without a coefficient: which loads, why, and how to compute other loads.

    `values` is a dataset of `Result.at`, or a selection from it.
    """
    study = result.study
    load_range = find_computed_load_range(result, values)

    def describe_load(load: float) -> str:
        return format_load(load, load / float(values["nominal_area"]) if has_nominal_area(values, study) else math.nan)

    load_texts = list(map(describe_load, missing_loads))
    listed_texts = f"{', '.join(load_texts[:-1])} and {load_texts[-1]}" if len(load_texts) > 1 else load_texts[0]
    is_inside_range = any(load_range[0] <= load <= load_range[1] for load in missing_loads)
    reason = (
        STATUS_EXPLANATIONS[str(values["status"].sel(load=missing_loads[0]).values.flat[0])][0]
        if is_inside_range and "status" in values
        else f"the computed loads are {' to '.join(map(describe_load, load_range))}"
    )
    remedy = (
        "repeat stiction pair with --load"
        if study.is_measured
        else f"change contact.{find_step_dimension(result.head)} in the study"
    )
    return f"no values at {listed_texts}: {reason}; to compute other loads, {remedy}"
