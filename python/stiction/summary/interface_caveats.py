"""Caveats about the interface of a pair: unknown ranges, and inputs whose ranges differ from those of the tests."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator
from typing import TYPE_CHECKING

from stiction._number_format import format_with_unit
from stiction.study.input_distributions import parse_study_input
from stiction.study.inputs import Inputs
from stiction.study.interfaces import HARDNESS_HEADER_ENTRY, InterfaceStrength, shared_input_name
from stiction.study.shared_inputs import SharedInput, compare_ranges
from stiction.summary.assessment import Caveat

if TYPE_CHECKING:
    from stiction.study.study import Study


def find_interface_caveats(study: Study, strength: InterfaceStrength, name: str = "") -> Iterator[Caveat]:
    """Yield the caveats about the interface with a given name, if a study uses this interface for its pair."""
    if strength.has_unknown_range:
        yield Caveat(
            f"the interval does not include the uncertainty of μ0 and τ0, because the interface {name} has no known "
            "range",
            "measure μ0 and τ0 (stiction calibrate), or give --mu0 and --tau0 with their ranges", "caution",
        )  # fmt: skip
    yield from _find_range_caveats(study, strength)


def _find_range_caveats(study: Study, strength: InterfaceStrength) -> Iterator[Caveat]:
    """Yield a caveat for each input to which the pair and the tests of its interface give different ranges.

    Ranges that do not overlap certainly belong to two quantities, and need no caveat.
    """
    inputs = Inputs.from_study(study).entries
    estimates = {name: entry.estimate for name, entry in inputs.items()}
    for name, shared_input in compare_ranges(strength, estimates, study.pair_checksum).items():
        if shared_input.has_equal_ranges:
            continue
        entry, tested_text = inputs[name], _get_tested_range_text(shared_input, strength, inputs[name].unit)
        ranges_text = f"{entry.label} is {entry.text}, but {tested_text} in the tests of the interface"
        if shared_input.is_one_quantity:
            yield Caveat(
                f"{ranges_text}; these count as two ranges of one quantity, and the narrower one applies",
                "give the same range in both; if the bodies differ, also give different central values", "caution",
            )  # fmt: skip
        elif shared_input.has_overlapping_ranges:
            yield Caveat(
                f"{ranges_text}; these count as two quantities with independent errors",
                "if the bodies have the same value, give the same range in both, which narrows the interval",
                "caution",
            )


def _get_tested_range_text(shared_input: SharedInput, strength: InterfaceStrength, unit: str) -> str:
    """Return the range of an input in the tests: the text of a hardness, or both limits in the given unit."""
    tested = shared_input.tested
    with contextlib.suppress(KeyError, ValueError):
        hardness = parse_study_input("hardness", strength.about[HARDNESS_HEADER_ENTRY])
        if shared_input.score_name == shared_input_name("hardness", hardness, ""):
            return hardness.text
    return " to ".join(format_with_unit(limit, unit) for limit in (tested.low, tested.high))
