"""What asperities say of a pair of areas within a second, while the half-space is being solved."""

from __future__ import annotations

from stiction.studies.members import about
from stiction.studies.pressed import member_sums
from stiction.studies.result import dataset_of, stacked
from stiction.studies.study import Study
from stiction.views.digits import quoted
from stiction.views.point import RULES
from stiction.views.result import Result

MEMBERS = 4  # whose mean is the first answer


def first_result(study: Study) -> Result:
    """What the first members of a study of asperities give, in memory; a `ValueError` if they cannot be pressed."""
    members = range(min(MEMBERS, study.ensemble.repetitions))
    arrays = stacked(study, [member_sums(study, member) for member in members])
    return Result(dataset_of(study, members, arrays, about(study)))


def first_text(study: Study) -> str:
    """The answer that the first members of a study of asperities give, in a line; an error if nothing touches."""
    one = first_result(study).answers[0]
    return f"at first, by asperities: μ_s = {quoted(one.value)} {RULES[one.rule]}"
