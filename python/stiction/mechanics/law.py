"""Contact laws: what one asperity contact carries."""

from __future__ import annotations

from typing import Literal

from stiction import _core
from stiction._checks import choice, number

LawName = Literal["hertz-sphere"]


def law_of(name: LawName, *, effective_modulus: float) -> _core.HertzSphere:
    """The law of a name, with E* in GPa."""
    choice("law", name, LawName)
    return _core.HertzSphere(effective_modulus=number("effective_modulus", effective_modulus, unit="GPa", above=0))
