"""A pair of bodies of a study pressed to one load: its curve, and its contacts as a table."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics.candidates import candidates
from stiction.mechanics.contact import contacts
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.half_space import HalfSpaceCurve, half_space
from stiction.mechanics.load_curve import LoadCurve, press
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import ContactModel
from stiction.studies.contact_statistics import Table, asperities_of, patches_of
from stiction.studies.contact_tables import ByAsperities, ByHalfSpace
from stiction.studies.study import Study
from stiction.surfaces.profile import Profile


@dataclass(frozen=True, eq=False)
class OneLoad:
    """A pair under one elastic load."""

    upper: Any
    lower: Any
    curve: HalfSpaceCurve | LoadCurve  # of this load alone, pushed along +x
    model: ContactModel | None = None  # how asperities were pressed

    @classmethod
    def of(cls, study: Study, pair: tuple[Any, Any], load: float) -> OneLoad | None:
        """The pair pressed as its study says, to a load (mN); None where it has no answer."""
        upper, lower = pair
        contact = study.contact
        if isinstance(contact, ByHalfSpace):
            try:
                curve = half_space(upper, lower, [load], **contact.solid(), sliding="all")
            except RuntimeError:
                return None
            return cls(upper, lower, curve)
        assert isinstance(contact, ByAsperities)
        model = replace(contact.model(), shear="+x", direction=None, sliding="all")
        model = model.for_profiles() if isinstance(upper, Profile) else replace(model, direction=0.0).for_surfaces()
        approach, status = crossing(Bodies(upper, lower), np.array([load]), mu0=0.0, tau0=0.0, model=model)
        if status[0] != STATUS_OK:
            return None
        pushed: LoadCurve
        if model.detection == "gap-minimum":
            touching = candidates(upper, lower, deepest=float(approach[0]), curvature=model.curvature)
            pushed = press(touching, approach, model=model)
        else:
            pushed = press(upper, lower, approach, model=model)
        return cls(upper, lower, pushed, model=model)

    def table(self) -> Table:
        """The contacts, one row each."""
        if isinstance(self.curve, HalfSpaceCurve):
            return patches_of(self.curve.at(0))
        spacing = (self.lower.spacing,) if isinstance(self.lower, Profile) else self.lower.spacing
        extent = (self.lower.extent,) if isinstance(self.lower, Profile) else self.lower.extent
        assert self.model is not None
        touching = contacts(self.upper, self.lower, float(self.curve.approach[0]), model=self.model)
        return asperities_of(touching, spacing, extent)

    def pressure(self) -> Floats | None:
        """GPa, over the grid of a half-space; None of asperities."""
        if not isinstance(self.curve, HalfSpaceCurve):
            return None
        pressed = self.curve.at(0)
        return pressed.on_grid(pressed.values)
