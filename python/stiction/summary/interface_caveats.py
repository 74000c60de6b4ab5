"""Caveats about a calibrated interface, and about inputs whose ranges differ between friction tests and pair."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping

from stiction._number_format import format_with_unit
from stiction.study.input_distributions import parse_study_input
from stiction.study.inputs import Inputs
from stiction.study.interfaces import (
    CAUTIONS_HEADER_ENTRY,
    FAULTS_HEADER_ENTRY,
    HARDNESS_HEADER_ENTRY,
    InterfaceStrength,
    shared_input_name,
)
from stiction.study.shared_inputs import SharedInput, are_central_values_equal, find_shared_inputs
from stiction.summary.assessment import Caveat, Severity

SEVERITIES_OF_HEADER_ENTRIES: dict[str, Severity] = {FAULTS_HEADER_ENTRY: "fault", CAUTIONS_HEADER_ENTRY: "caution"}
"""Severity of the caveats in an interface file, by the header entry that contains them."""

_EQUAL_SIZE_EFFECTS_REMEDY = "give --indent for both or for neither, and run stiction calibrate again"
_EQUAL_RANGES_REMEDY = "give the same range in both; if the bodies differ, give different central values"


def find_interface_caveats(
    strength: InterfaceStrength | None,
    name: str,
    inputs: Inputs,
    pair_checksum: str = "",
    caveats_of_missing_file: Mapping[str, str] | None = None,
) -> Iterator[Caveat]:
    """Yield caveats about a pair's interface, and about inputs whose ranges differ between its tests and the pair.

    `strength` is None if the file of the interface is missing or has changed. `name` is the name of the interface.
    `pair_checksum` identifies the pair among the tested pairs. `caveats_of_missing_file` contains the caveats that the
    study stores for an interface file that was moved or deleted. Without the file, no input is shared with the tests.
    """
    texts = caveats_of_missing_file if strength is None else strength.about
    if texts is None:
        yield Caveat(
            f"the file of interface {name} is missing or has changed, so its caveats are unknown",
            "restore the file, or run stiction pair again with the present file",
            "caution",
        )
        return
    for entry, severity in SEVERITIES_OF_HEADER_ENTRIES.items():
        if text := texts.get(entry):
            yield Caveat(f"interface {name}: {text}", "correct the tests, and run stiction calibrate again", severity)
    if strength is not None:
        yield from find_range_caveats(strength, inputs, pair_checksum)


def find_range_caveats(strength: InterfaceStrength, inputs: Inputs, pair_checksum: str) -> Iterator[Caveat]:
    """Yield a caveat for each input with equal central values, but different ranges, in a pair and its tests.

    A further caveat is yielded if only the pair or only the tests have the size effect of small contacts.

    Ranges with different central values belong to two quantities, such as the hardnesses of two materials. If an input
    is exact in the tests, the samples of the interface contain no error of this input, so that the range of the pair
    applies, and its error is independent.
    """
    yield from _find_size_effect_difference(strength, inputs)
    estimates = {name: entry.estimate for name, entry in inputs.entries.items()}
    shared_inputs = find_shared_inputs(strength, estimates, pair_checksum)
    for name, shared_input in shared_inputs.items():
        if shared_input.has_equal_ranges:
            continue
        entry = inputs.entries[name]
        tested_text = _get_tested_range_text(shared_input, strength, entry.unit)
        yield Caveat(
            f"{entry.label} is {entry.text}, but {tested_text} in the tests of the interface; these count as two "
            "ranges of one quantity, and the narrower one applies",
            _EQUAL_RANGES_REMEDY,
            "caution",
        )
    for name, entry in inputs.uncertain.items():
        if name not in shared_inputs and any(
            tested_name == name and are_central_values_equal(value, entry.estimate.value)
            for tested_name, value in strength.exact_inputs
        ):
            yield Caveat(
                f"{entry.label} is {entry.text}, but exact in the tests of the interface; its error widens the "
                "interval in full, although most of it would cancel if the tests had the same range",
                _EQUAL_RANGES_REMEDY,
                "caution",
            )


def _find_size_effect_difference(strength: InterfaceStrength, inputs: Inputs) -> Iterator[Caveat]:
    """Yield a caveat if only the pair, or only its friction tests, include the size effect of small contacts."""
    tested_names = {name.partition(" ")[0] for name in strength.fits[0].scores}
    tested_names |= {name for name, _ in strength.exact_inputs}
    if "hardness" not in tested_names or "yield_exponent" not in inputs.entries:
        return
    has_tested_size_effect, has_size_effect = "size_effect" in tested_names, "size_effect" in inputs.entries
    if has_tested_size_effect == has_size_effect:
        return
    names = ("the pair", "the tests of the interface")
    name_with, name_without = names if has_size_effect else names[::-1]
    yield Caveat(
        f"{name_with} include{'s' if has_size_effect else ''} the hardness increase of small contacts (--indent), "
        f"unlike {name_without}; τ0 of the interface belongs to another true area",
        _EQUAL_SIZE_EFFECTS_REMEDY,
        "caution",
    )


def _get_tested_range_text(shared_input: SharedInput, strength: InterfaceStrength, unit: str) -> str:
    """Return an input's range in friction tests as text: two limits or, for the hardness, the user's text."""
    tested = shared_input.tested
    with contextlib.suppress(KeyError, ValueError):
        hardness = parse_study_input("hardness", strength.about[HARDNESS_HEADER_ENTRY])
        if shared_input.score_name == shared_input_name("hardness", hardness, ""):
            return hardness.text
    return " to ".join(format_with_unit(limit, unit) for limit in (tested.low, tested.high))
