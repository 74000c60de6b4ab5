"""What asperities say of a pair of areas within a second, while the half-space is being solved."""

from __future__ import annotations

from stiction.studies.members import about
from stiction.studies.pressed import member_sums
from stiction.studies.result import dataset_of, stacked
from stiction.studies.study import Study
from stiction.views.digits import quoted, with_unit
from stiction.views.point import RULES
from stiction.views.result import Result

MEMBERS = 4  # whose mean is the first answer
LINES = 3  # answers that are shown, at most


def first_result(study: Study) -> Result:
    """What the first members of a study of asperities give, in memory; a `ValueError` if they cannot be pressed."""
    members = range(min(MEMBERS, study.ensemble.repetitions))
    arrays = stacked(study, [member_sums(study, member) for member in members])
    return Result(dataset_of(study, members, arrays, about(study)))


def first_text(study: Study) -> str:
    """The answers that the first members of a study of asperities give, a line each; an error if nothing touches."""
    result = first_result(study)
    members = result.dataset.sizes["repetition"]
    lines = [f"at first, by asperities at {members} positions, while the half-space is solved:"]
    for one in result.answers[:LINES]:
        rules = ", ".join(
            f"{quoted(rule.value, rule.lower, rule.upper)} {RULES[rule.rule]}" for rule in one.rules
        )  # fmt: skip
        lines.append(f"μ_s = {rules}, at {with_unit(one.at['load'], 'mN')}")
    return "\n".join(lines)
