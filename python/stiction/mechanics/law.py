"""Contact laws: normal force and area of a single asperity contact as functions of the overlap.

A law is a frozen dataclass whose fields are its parameters with their units. The class determines the name of the law
and its table in a study file. The core has a law with the same name and parameters. The effective modulus is common to
all laws and is passed separately.
"""

from __future__ import annotations

import re
from dataclasses import MISSING, dataclass, field, fields
from typing import Any, ClassVar, Literal

import stiction._core
from stiction._checks import check_choice, validate_number
from stiction._units import short_repr


def parameter_field(unit: str, *, default: Any = MISSING) -> Any:
    """Return a dataclass field for a parameter of a contact law, with its unit ("µm", "GPa" or "") and its default."""
    return field(default=default, metadata={"unit": unit})


@dataclass(frozen=True)
class ContactLaw:
    """Base class of the contact laws, which give the force and the area of a single contact.

    `CONTACT_LAWS` lists all laws.
    """

    name: ClassVar[str]

    def __init_subclass__(cls) -> None:
        """Derive the name of a law from the name of its class, such as "jackson-green" from JacksonGreen."""
        cls.name = re.sub(r"(?<!^)(?=[A-Z])", "-", cls.__name__).lower()

    def parameters(self, effective_modulus: float) -> dict[str, float]:
        """Return the parameters that the C++ core needs for this contact law, including E* (GPa)."""
        parameters = {item.name: validate_number(item.name, getattr(self, item.name)) for item in fields(self)}
        return {
            "effective_modulus": validate_number("effective_modulus", effective_modulus, unit="GPa", above=0),
            **parameters,
        }


@dataclass(frozen=True)
class HertzSphere(ContactLaw):
    """Hertz law of elastic spheres: F = 4/3 E* R^(1/2) overlap^(3/2), A = π R overlap.

    Exact for contact radii a << R.

    Notes
    -----
    Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24.

    Examples
    --------
    >>> from stiction import HertzSphere, force_and_area
    >>> force_and_area(HertzSphere(), overlap=0.25, radius=1.0, effective_modulus=3.0)[0]
    0.5
    """


@dataclass(frozen=True)
class HertzCylinder(ContactLaw):
    """Hertz law of elastic parallel cylinders of width w: F = π/4 E* overlap w, A = 2 w (R overlap)^(1/2).

    Parameters
    ----------
    width : float, µm
        Width w along the cylinders; the profiles of the model have a width of 1 µm.

    Notes
    -----
    Johnson, Contact Mechanics (1985), section 4.2(c). The overlap is that of the undeformed circles, a²/R. The approach
    of distant points in a line contact depends on the size of the bodies.

    Examples
    --------
    >>> from stiction import HertzCylinder, force_and_area
    >>> force, area = force_and_area(HertzCylinder(), overlap=0.01, radius=1.0)
    >>> round(force, 6), round(area, 6)
    (0.07854, 0.2)
    """

    width: float = parameter_field("µm", default=1.0)


@dataclass(frozen=True)
class JacksonGreen(ContactLaw):
    """Jackson-Green law of elastic-perfectly plastic spheres, fitted to finite element results.

    Hertz up to 1.9 critical overlaps, ω_c = (π C S_y / 2 E*)² R with C = 1.295 exp(0.736 ν). Above, the contact grows
    faster, and the mean pressure tends to a hardness that decreases from 2.84 S_y as the contact radius a grows.

    Parameters
    ----------
    yield_strength : float, GPa
        Yield strength S_y of the softer body, below a tenth of the effective modulus.
    poisson_ratio : float
        Poisson's ratio ν of the softer body, from 0 to 0.5.

    Notes
    -----
    Jackson & Green, Journal of Tribology 127 (2005) 343. Fitted up to a = 0.41 R; at the transition the load jumps by
    less than 1 %. Valid for loading only.

    Examples
    --------
    >>> from stiction import JacksonGreen, force_and_area
    >>> force, area = force_and_area(JacksonGreen(yield_strength=0.1, poisson_ratio=0.3), overlap=0.01, radius=1.0)
    >>> round(force, 6), round(area, 6)  # less than 0.0133 mN and more than 0.0314 µm² of elastic spheres
    (0.009971, 0.045495)
    """

    yield_strength: float = parameter_field("GPa")
    poisson_ratio: float = parameter_field("")


CONTACT_LAWS: tuple[type[ContactLaw], ...] = (HertzSphere, HertzCylinder, JacksonGreen)
# Contact laws without required parameters, which a study can specify by their names alone.
LawName = Literal["hertz-sphere", "hertz-cylinder"]
CONTACT_LAWS_BY_NAME: dict[str, ContactLaw] = {
    law.name: law() for law in CONTACT_LAWS if all(item.default is not MISSING for item in fields(law))
}


def parse_contact_law(law: ContactLaw | LawName) -> ContactLaw:
    """Return the contact law with a given name, or a given law unchanged.

    Other arguments raise a `ValueError`.
    """
    if isinstance(law, str):
        check_choice("law", law, LawName)
        return CONTACT_LAWS_BY_NAME[law]
    if not isinstance(law, ContactLaw):
        raise ValueError(f"law must be a contact law or the name of a contact law, got {short_repr(law)}")
    return law


def force_and_area(
    law: ContactLaw | LawName, *, overlap: float, radius: float, effective_modulus: float = 10.0
) -> tuple[float, float]:
    """Compute the normal force and the area of one contact.

    Parameters
    ----------
    law : HertzSphere, HertzCylinder or JacksonGreen, or "hertz-sphere" or "hertz-cylinder"
        Contact law.
    overlap : float, µm
        Overlap of the undeformed bodies, above 0.
    radius : float, µm
        Effective radius, 1/R = 1/R_u + 1/R_l, above 0.
    effective_modulus : float, GPa
        E*, see `effective_modulus`.

    Returns
    -------
    force : float, mN
        Normal force.
    area : float, µm²
        Contact area.

    Raises
    ------
    ValueError
        If an argument is outside its range, or there is no such law.

    See Also
    --------
    hertz_sphere, hertz_cylinder : Closed forms for arrays.

    Examples
    --------
    >>> from stiction import force_and_area
    >>> force, area = force_and_area("hertz-sphere", overlap=0.01, radius=1.0)
    >>> round(force, 6), round(area, 6)
    (0.013333, 0.031416)
    """
    checked_law = parse_contact_law(law)
    return stiction._core.force_and_area(
        checked_law.name,
        checked_law.parameters(effective_modulus),
        overlap=validate_number("overlap", overlap, unit="µm", above=0),
        radius=validate_number("radius", radius, unit="µm", above=0),
    )
