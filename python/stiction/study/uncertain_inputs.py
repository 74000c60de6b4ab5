"""Functions that return single inputs of a study."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

from stiction._checks import Floats
from stiction.study.input_distributions import UncertainInput
from stiction.study.inputs import Input, Inputs
from stiction.study.study import Study


def find_uncertain_inputs(study: Study) -> dict[str, Input]:
    """Return the uncertain inputs of a study by name, apart from the creep exponent."""
    inputs = Inputs.from_study(study)
    return {name: entry for name, entry in inputs.uncertain.items() if name != "creep"}


def find_junction_growth(study: Study) -> UncertainInput | None:
    """Return the junction growth α with its uncertainty, or None if there is no junction growth."""
    return _find_estimate(study, "junction_growth")


def find_creep_exponent(study: Study) -> UncertainInput | None:
    """Return the uncertain exponent of indentation creep, or None if the study has no dwell times."""
    entry = Inputs.from_study(study).entries.get("creep")
    return None if entry is None else entry.estimate


def compute_relative_modulus(study: Study, samples: Mapping[str, Floats]) -> Floats | float:
    """Compute E* from samples of the uncertain inputs, and divide it by the E* of the study."""
    return Inputs.from_study(study).relative_modulus(samples)


def _find_estimate(study: Study, name: str) -> UncertainInput | None:
    entry = Inputs.from_study(study).entries.get(name)
    return None if entry is None else replace(entry.estimate, value=entry.central)
