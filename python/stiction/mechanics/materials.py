"""Elastic moduli, Poisson's ratios and hardnesses of materials, each as a range with its source."""

from __future__ import annotations

import difflib
import math
import re
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any, Literal, get_args

from stiction._checks import validate_number
from stiction._units import short_repr

COATING_FORMULAS = (
    "TiN", "TiC", "TiCN", "TiAlN", "AlTiN", "TiB2", "CrN", "CrC", "CrAlN", "AlCrN", "ZrN", "HfN", "TaN", "NbN", "BN",
    "cBN", "B4C", "MoS2", "WS2", "WC/C", "DLC",
)  # fmt: skip
"""Formulas and abbreviations of common coatings."""

_ELEMENT_SYMBOLS = (
    "HHeLiBeBCNOFNeNaMgAlSiPSClArKCaScTiVCrMnFeCoNiCuZnGaGeAsSeBrKrRbSrYZrNbMoTcRuRhPdAgCdInSnSbTeIXeCsBa"
    "LaCePrNdPmSmEuGdTbDyHoErTmYbLuHfTaWReOsIrPtAuHgTlPbBiPoAtRnFrRaAcThPaU"
)
"""Symbols of the chemical elements, without separators."""

_ELEMENT_PATTERN = "|".join(sorted(re.findall("[A-Z][a-z]?", _ELEMENT_SYMBOLS), key=len, reverse=True))
_FORMULA_PATTERN = re.compile(f"(?:(?:{_ELEMENT_PATTERN})[0-9]*)+")
MaterialKind = Literal["metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "elastomer", "rock"]

# These materials yield by slip, at a shear strength that hardly rises with the pressure, as slip-line theory assumes.
# Minerals, ceramics and glass yield differently: their friction is far above the limit of slip-line theory.
SLIP_LINE_KINDS: tuple[MaterialKind, ...] = ("metal", "polymer")

# Bodies with a smaller effective modulus E* (GPa) are assumed to be rubber or gel, which do not yield.
MAX_RUBBER_MODULUS = 0.1


class MaterialValue(float):
    """Property of a material: a representative number, its range and its source.

    Attributes
    ----------
    low, high : float
        Limits of the range in the source, which are equal if the source has a single value. The number is the geometric
        mean of the limits, or half of the upper limit if the lower limit is 0.
    source : str
        Author, title and year of the source.

    Examples
    --------
    >>> from stiction import material
    >>> modulus = material("mild steel").young_modulus
    >>> modulus.low, modulus.high, modulus.low < modulus < modulus.high
    (207, 212, True)
    """

    low: float
    high: float
    source: str

    def __new__(cls, low: float, high: float, source: str) -> MaterialValue:
        """Create a material property from a range of nonnegative numbers."""
        for name, limit in (("low", low), ("high", high)):
            if validate_number(name, limit) < 0:
                raise ValueError(f"{name} must be at least 0, got {short_repr(limit)}")
        representative = low if low == high else math.sqrt(low * high) if low > 0 else high / 2
        value = super().__new__(cls, representative)
        value.low, value.high, value.source = low, high, source
        return value

    def __getnewargs__(self) -> tuple[float, float, str]:  # type: ignore[override]
        return self.low, self.high, self.source

    def __repr__(self) -> str:
        range_text = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        return f"<{range_text}, {self.source}>"


@dataclass(frozen=True)
class Material:
    """Solid material: elastic constants and hardness, each as a range with its source.

    Attributes
    ----------
    name : str
        Name in `materials`.
    kind : {"metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "elastomer", "rock"}
        Group of the material.
    young_modulus : MaterialValue, GPa
        Young's modulus E.
    poisson_ratio : MaterialValue
        Poisson's ratio ν.
    hardness : MaterialValue or None, GPa
        Indentation hardness, the mean pressure at which the surface yields. It depends on the treatment, and increases
        for smaller indentations. None for elastomers, which do not yield.
    aliases : tuple of str
        Other names that `material` accepts.

    Examples
    --------
    >>> from stiction import material
    >>> steel = material("mild steel")
    >>> steel.name, round(float(steel.young_modulus)), round(float(steel.poisson_ratio), 3)
    ('mild steel', 209, 0.295)
    """

    name: str
    kind: MaterialKind
    young_modulus: MaterialValue
    poisson_ratio: MaterialValue
    hardness: MaterialValue | None
    aliases: tuple[str, ...] = ()

    @property
    def plane_strain_modulus(self) -> float:
        """Plane-strain modulus E/(1 - ν²), GPa."""
        return float(self.young_modulus) / (1 - float(self.poisson_ratio) ** 2)


def material(name: str) -> Material:
    """Return a built-in material by its name or an alias.

    Parameters
    ----------
    name : str
        Name or alias of one of the `materials`. Spaces and hyphens are ignored, and so is the case of words. A chemical
        formula must have its case: "TiN" is not tin.

    Returns
    -------
    material : Material
        Moduli and hardness (GPa) and Poisson's ratio, with their ranges and sources.

    Raises
    ------
    ValueError
        If there is no such material; the message contains the nearest names.

    See Also
    --------
    materials : All materials.
    effective_modulus : Modulus of two materials.

    Examples
    --------
    >>> from stiction import effective_modulus, material
    >>> steel, brass = material("steel"), material("brass")
    >>> round(effective_modulus(steel, brass), 1)
    78.7
    >>> material("brass").hardness.low, material("brass").hardness.high
    (0.23, 1.7)
    """
    by_name = _materials_by_name()
    if not isinstance(name, str):
        raise ValueError(f"name must be the name of a material, got {short_repr(name)}")
    found_material = by_name.get(_normalise_name(name))
    if found_material is None or _is_formula_of_another_material(name, found_material):
        matches = difflib.get_close_matches(_normalise_name(name), by_name, n=3, cutoff=0.5)
        suggested_names = [
            name for match in matches for name in _names_and_aliases(by_name[match]) if _normalise_name(name) == match
        ]
        suggested_names = suggested_names or [item.name for item in materials()]
        introduction = "the nearest are" if matches else "there are"
        is_coating = "coat" in name.casefold() or is_coating_formula(name)
        hint = "; for a coating much thinner than the contact width, name its substrate" if is_coating else ""
        raise ValueError(
            "name must be the name of a known material, "
            f"got {short_repr(name)}; {introduction} {', '.join(suggested_names)}{hint}"
        )
    return found_material


@cache
def materials() -> tuple[Material, ...]:
    """Return all built-in materials, sorted by kind and name.

    Returns
    -------
    materials : tuple of Material
        Materials grouped by kind, and sorted by name within a kind.

    See Also
    --------
    material : Single material by its name.

    Examples
    --------
    >>> from stiction import materials
    >>> [solid.name for solid in materials() if solid.kind == "glass"]
    ['fused silica', 'N-BK7 glass', 'soda-lime glass']
    """
    text = (resources.files("stiction.mechanics") / "materials.toml").read_text(encoding="utf-8")
    materials_table = tomllib.loads(text)
    citations = materials_table["sources"]

    def parse_material_value(row: dict[str, Any], name: str) -> Any:
        if name not in row:
            return None
        low, high, source = row[name]
        return MaterialValue(low, high, source.format_map(citations))

    return tuple(
        Material(
            row["name"], kind, parse_material_value(row, "young_modulus"), parse_material_value(row, "poisson_ratio"),
            parse_material_value(row, "hardness"),
            tuple(row.get("aliases", ())),
        )
        for kind in get_args(MaterialKind)
        for row in sorted(materials_table[kind], key=lambda row: row["name"].casefold())
    )  # fmt: skip


def compliance_fraction(upper: Material, lower: Material) -> float:
    """Return the fraction of the elastic compliance of two bodies that is due to the lower body.

    Parameters
    ----------
    upper, lower : Material
        Materials of both bodies.

    Returns
    -------
    fraction : float
        c_l, from 0 to 1: the `compliance_share` of `half_space`.

    Raises
    ------
    ValueError
        If an argument is not a `Material`.

    See Also
    --------
    effective_modulus : Modulus of the pair.

    Notes
    -----
    c_l = E* (1 - ν_l²)/E_l, where E* is the effective modulus, and E_l and ν_l belong to the lower body.

    Examples
    --------
    >>> from stiction import compliance_fraction, material
    >>> round(compliance_fraction(material("steel"), material("ptfe")), 3)
    0.997
    """
    upper_modulus, lower_modulus = (
        _validate_material(name, body).plane_strain_modulus for name, body in (("upper", upper), ("lower", lower))
    )
    return upper_modulus / (upper_modulus + lower_modulus)


def softer_hardness(upper: Material, lower: Material) -> MaterialValue | None:
    """Return the hardness of the softer of two bodies.

    Parameters
    ----------
    upper, lower : Material
        Materials of both bodies.

    Returns
    -------
    hardness : MaterialValue, GPa, or None
        Hardness with its range and source; None if one of the bodies is an elastomer.

    Raises
    ------
    ValueError
        If an argument is not a `Material`.

    Notes
    -----
    The softer body yields first. An elastomer does not yield, and keeps the pressure far below the hardness of its
    counterface.

    Examples
    --------
    >>> from stiction import material, softer_hardness
    >>> float(softer_hardness(material("mild steel"), material("brass"))) == float(material("brass").hardness)
    True
    """
    softer_material = softest_material(_validate_material("upper", upper), _validate_material("lower", lower))
    return None if softer_material is None else softer_material.hardness


def softest_material(*bodies: Material) -> Material | None:
    """Return the material with the lowest hardness.

    Returns None if no material is given or a hardness is missing.
    """
    hardnesses = [(body.hardness, body) for body in bodies if body.hardness is not None]
    return min(hardnesses, key=lambda pair: pair[0])[1] if hardnesses and len(hardnesses) == len(bodies) else None


def are_material_names_equal(text: str, name: str) -> bool:
    """Return True if two names of materials are equal except for case, blanks and punctuation."""
    return _normalise_name(text) == _normalise_name(name)


def is_coating_formula(name: str) -> bool:
    """Return whether a name is the chemical formula of a hard or lubricant coating, ignoring case."""
    return _normalise_name(name) in {_normalise_name(formula) for formula in COATING_FORMULAS}


def _is_formula_of_another_material(name: str, other_material: Material) -> bool:
    """Return whether a name is a chemical formula, such as "TiN", and not the name of a material, such as "tin"."""
    letters = "".join(character for character in name if character.isalnum())
    exact_names = ("".join(filter(str.isalnum, exact_name)) for exact_name in _names_and_aliases(other_material))
    if letters in exact_names or letters in (letters.lower(), letters.upper()):
        return False
    words = re.findall(r"[^\W\d_]+", name)
    has_ordinary_capitals = all(word in (word.lower(), word.upper(), word.capitalize()) for word in words)
    return not has_ordinary_capitals or _FORMULA_PATTERN.fullmatch(letters) is not None


def _validate_material(name: str, body: Any) -> Material:
    if not isinstance(body, Material):
        raise ValueError(f"{name} must be a Material, as returned by material(), got {type(body).__name__}")
    return body


def _normalise_name(name: str) -> str:
    return "".join(character for character in name.casefold() if character.isalnum())


@cache
def _materials_by_name() -> dict[str, Material]:
    return {_normalise_name(name): item for item in materials() for name in _names_and_aliases(item)}


def _names_and_aliases(solid: Material) -> tuple[str, ...]:
    """Return the name and the aliases of a material."""
    return solid.name, *solid.aliases
