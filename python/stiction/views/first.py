"""What asperities say of a pair of areas within a second, while the half-space is being solved."""

from __future__ import annotations

from stiction.studies.at_load import at_load
from stiction.studies.members import about
from stiction.studies.pressed import member_sums
from stiction.studies.result import dataset_of, stacked
from stiction.studies.study import Study
from stiction.studies.tables import MeasuredFriction
from stiction.views.answer import answers
from stiction.views.digits import two_digits, with_unit
from stiction.views.point import RULES

MEMBERS = 4
"""Whose mean is the first answer."""

LINES = 3
"""Answers that are shown, at most."""


def first_text(study: Study) -> str:
    """The answers that the first members of a study of asperities give, a line each.

    Raises
    ------
    ValueError
        If nothing touches.
    """
    assert isinstance(study.friction, MeasuredFriction)
    members = range(min(MEMBERS, study.ensemble.repetitions))
    arrays = stacked(study, [member_sums(study, member) for member in members])
    result = dataset_of(study, members, arrays, about(study))
    at = at_load(result, [float(load) for load in study.friction.load])
    lines = [f"at first, by asperities at {len(members)} positions, while the half-space is solved:"]
    for one in answers(at, study)[:LINES]:
        rules = ", ".join(
            f"{two_digits(rule.value, rule.lower, rule.upper)} {RULES[rule.rule]}" for rule in one.rules
        )  # fmt: skip
        lines.append(f"μ_s = {rules}, at {with_unit(one.at['load'], 'mN')}")
    return "\n".join(lines)
