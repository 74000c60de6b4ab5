"""Names of the members of a study in texts for users: repetitions, positions or pairs of surrogates."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from stiction.studies.study import Study

GENERAL_MEMBER_NAMES = ("member", "members")
"""Singular and plural of the general name, for studies whose members are positions and pairs of surrogates."""

REPETITION_NAMES = ("repetition", "repetitions")
POSITION_NAMES = ("position", "positions")
SURROGATE_PAIR_NAMES = ("pair of surrogates", "pairs of surrogates")


def find_member_names(study: Study) -> tuple[str, str]:
    """Return the singular and the plural of the name of the members of a study."""
    if not study.is_measured:
        return REPETITION_NAMES
    surfaces: Any = study.surfaces
    if surfaces.press == "surrogates":
        return SURROGATE_PAIR_NAMES
    return GENERAL_MEMBER_NAMES if surfaces.press == "areas" and surfaces.surrogates else POSITION_NAMES


def count_members_text(study: Study, count: float) -> str:
    """Return a number of members as text, as in "16 positions"."""
    return f"{count:.0f} {find_member_names(study)[count != 1]}"
