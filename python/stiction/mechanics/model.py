"""How two bodies are pressed together: one object from a study file to the core."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Literal, TypedDict

import stiction._core
from stiction._checks import choice, number
from stiction.mechanics.law import Law, LawName, law_of
from stiction.surfaces.profile import Profile

Detection = Literal["cell", "gap-minimum"]
Curvature = Literal["convex", "signed"]
Shear = Literal["+x", "-x"]

EFFECTIVE_MODULUS = 10.0
"""GPa, of the paper."""


@dataclass(frozen=True, kw_only=True)
class ContactModel:
    """How two bodies are pressed together: what `contacts`, `press`, `approach_at_load` and `traverse` take as `model`.

    Keywords of these functions take precedence over the model's.

    Parameters
    ----------
    effective_modulus : float, GPa
        E*, with 1/E* = (1 - ν1²)/E1 + (1 - ν2²)/E2.
    law : HertzSphere, HertzCylinder or JacksonGreen, or "hertz-sphere" or "hertz-cylinder"
        What one contact carries.
    detection : {"cell", "gap-minimum"}
        "cell" (Eq. 5): a grid point owns a contact whose centre lies in its own cell. "gap-minimum": contacts are at
        the local minima of the splined gap, which do not depend on the grid where it resolves the surfaces.
    curvature : {"convex", "signed"}
        Whether both bodies must be convex at a contact, or one may be a wider cup.
    shear : {"+x", "-x"}
        Where the upper body is about to move.

    Raises
    ------
    ValueError
        If an argument is outside its range.

    Examples
    --------
    >>> from stiction import ContactModel, JacksonGreen
    >>> steel = ContactModel(effective_modulus=115.0, law=JacksonGreen(yield_strength=0.3, poisson_ratio=0.3))
    >>> steel.detection
    'cell'
    """

    effective_modulus: float = EFFECTIVE_MODULUS
    law: Law | LawName = "hertz-sphere"
    detection: Detection = "cell"
    curvature: Curvature = "convex"
    shear: Shear = "+x"

    def __post_init__(self) -> None:
        choice("detection", self.detection, Detection)
        choice("curvature", self.curvature, Curvature)
        choice("shear", self.shear, Shear)
        number("effective_modulus", self.effective_modulus, unit="GPa", above=0)
        self.core()

    def core(self) -> stiction._core.ContactModel:
        """The model of the core."""
        law = law_of(self.law)
        return stiction._core.ContactModel(
            law=law.name,
            parameters=law.parameters(self.effective_modulus),
            detection=self.detection,
            curvature=self.curvature,
            direction=DIRECTIONS[self.shear],
        )


DIRECTIONS: dict[Shear, tuple[float, float]] = {"+x": (1.0, 0.0), "-x": (-1.0, 0.0)}
"""As horizontal unit vectors (x, y)."""


class ContactKeywords(TypedDict, total=False):
    """A contact model as keywords: the model itself, and what shall differ from it."""

    model: ContactModel
    effective_modulus: float
    law: Law | LawName
    detection: Detection
    curvature: Curvature
    shear: Shear


def model_of(keywords: ContactKeywords, default: ContactModel | None = None) -> ContactModel:
    """The contact model that keywords give; what they leave open is the default's."""
    changes: dict[str, Any] = dict(keywords)
    model = changes.pop("model", default or ContactModel())
    if not isinstance(model, ContactModel):
        raise ValueError(f"model must be a ContactModel, got {type(model).__name__}")
    if unknown := changes.keys() - ContactKeywords.__annotations__.keys():
        raise TypeError(f"unexpected keyword argument {min(unknown)!r}")
    return replace(model, **changes) if changes else model


def check_pair(upper: Any, lower: Any) -> None:
    """Two profiles on one grid; how many points they have is for the core to see."""
    for name, body in (("upper", upper), ("lower", lower)):
        if not isinstance(body, Profile):
            raise ValueError(f"{name} must be a Profile, got {type(body).__name__}")
    if upper.spacing != lower.spacing:
        raise ValueError(f"upper and lower must have equal spacings, got {upper.spacing!r} and {lower.spacing!r} µm")
