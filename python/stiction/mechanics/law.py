"""Contact laws: what one asperity contact carries.

A law is a small object; the effective modulus, which all laws share, is given where it is used.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

import stiction._core as _core
from stiction._checks import choice, number

CoreLaw = _core.HertzSphere | _core.HertzCylinder | _core.JacksonGreen


class Law(Protocol):
    """Anything that makes itself a law of the core, for an effective modulus in GPa."""

    def core(self, effective_modulus: float) -> CoreLaw:
        """The law of the core."""
        ...


@dataclass(frozen=True)
class HertzSphere:
    """Elastic spheres: F = 4/3 E* R^(1/2) overlap^(3/2), A = π R overlap. Exact within a << R.

    Notes
    -----
    Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24.

    Examples
    --------
    >>> from stiction import HertzSphere, force_and_area
    >>> force_and_area(HertzSphere(), overlap=0.25, radius=1.0, effective_modulus=3.0)[0]
    0.5
    """

    def core(self, effective_modulus: float) -> CoreLaw:
        """The law of the core."""
        return _core.HertzSphere(effective_modulus=effective_modulus)


@dataclass(frozen=True)
class HertzCylinder:
    """Elastic parallel cylinders: F = π/4 E* overlap w, A = 2 w (R overlap)^(1/2). Exact within a << R.

    Parameters
    ----------
    width : float, µm
        w, along the cylinders; the model's profiles are 1 µm thick.

    Notes
    -----
    Johnson, Contact Mechanics (1985), eq. 4.45. The overlap is that of the undeformed circles, a²/R; the approach of
    distant points of a line contact depends on the size of the bodies and has no value of its own.
    """

    width: float = 1.0

    def core(self, effective_modulus: float) -> CoreLaw:
        """The law of the core."""
        return _core.HertzCylinder(effective_modulus=effective_modulus, width=number("width", self.width))


@dataclass(frozen=True)
class JacksonGreen:
    """Spheres that yield: elastic, perfectly plastic, fitted to finite elements.

    Hertz up to 1.9 critical overlaps, ω_c = (π C S_y / 2 E*)² R with C = 1.295 exp(0.736 ν); above, contact spreads and
    the mean pressure tends to a hardness that falls from 2.84 S_y as the contact radius a grows.

    Parameters
    ----------
    yield_strength : float, GPa
        S_y of the softer body, below a tenth of the effective modulus.
    poisson_ratio : float
        ν of that body, from 0 to 0.5.

    Notes
    -----
    Jackson & Green, Journal of Tribology 127 (2005) 343. Fitted up to a = 0.41 R; at the transition the load jumps by
    less than 1 %. Loading only.
    """

    yield_strength: float
    poisson_ratio: float

    def core(self, effective_modulus: float) -> CoreLaw:
        """The law of the core."""
        return _core.JacksonGreen(
            effective_modulus=effective_modulus,
            yield_strength=number("yield_strength", self.yield_strength),
            poisson_ratio=number("poisson_ratio", self.poisson_ratio),
        )


LawName = Literal["hertz-sphere", "hertz-cylinder"]
"""Laws that need no parameters have a name."""

_NAMED: dict[str, Law] = {"hertz-sphere": HertzSphere(), "hertz-cylinder": HertzCylinder()}


def core_law(law: Law | LawName, *, effective_modulus: float) -> CoreLaw:
    """The core's law of a law or its name, with E* in GPa; a bad parameter is a ValueError that names it."""
    if isinstance(law, str):
        choice("law", law, LawName)
        law = _NAMED[law]
    if not hasattr(law, "core"):
        raise ValueError(f"law must be a contact law or the name of one, got {law!r}")
    core = law.core(number("effective_modulus", effective_modulus, unit="GPa", above=0))
    _core.check(core)
    return core


def force_and_area(
    law: Law | LawName, *, overlap: float, radius: float, effective_modulus: float = 10.0
) -> tuple[float, float]:
    """Normal force (mN) and area (µm²) of one contact.

    Parameters
    ----------
    law : HertzSphere, HertzCylinder, JacksonGreen, or a name
    overlap : float, µm
        Above 0.
    radius : float, µm
        Effective radius, 1/R = 1/R_u + 1/R_l, above 0.
    effective_modulus : float, GPa

    Raises
    ------
    ValueError
        If an argument or a parameter of the law is outside its range.
    """
    core = core_law(law, effective_modulus=effective_modulus)
    return _core.force_and_area(
        core, number("overlap", overlap, unit="µm", above=0), number("radius", radius, unit="µm", above=0)
    )
