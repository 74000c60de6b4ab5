"""Words that output uses for the members of a study, such as positions or repetitions."""

from __future__ import annotations

from typing import NamedTuple


class MemberNames(NamedTuple):
    """Word that output uses for the members of a study, in singular and plural, as in "position" and "positions"."""

    singular: str
    plural: str

    def with_count(self, count: float) -> str:
        """Format a number of members with the word for them, as in "16 positions"."""
        return f"{count:.0f} {self.singular if count == 1 else self.plural}"


MIXED_MEMBER_NAMES = MemberNames("member", "members")
"""Word for members of mixed kinds: positions together with pairs of surrogates."""

REPETITION_NAMES = MemberNames("repetition", "repetitions")
POSITION_NAMES = MemberNames("position", "positions")
SURROGATE_PAIR_NAMES = MemberNames("pair of surrogates", "pairs of surrogates")
