"""Elastic moduli, Poisson's ratios and hardnesses of materials, each as a range with its source."""

from __future__ import annotations

import difflib
import math
import tomllib
from dataclasses import dataclass
from functools import cache
from importlib import resources
from typing import Any, Literal, get_args

MaterialKind = Literal["metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "elastomer", "rock"]


class MaterialValue(float):
    """A property of a material: the middle of what is known, as a number, with the range and its source.

    Attributes
    ----------
    low, high : float
        Between which it lies in the source; equal where the source has one number. The number itself is their geometric
        mean, or half of the upper end where the lower one is 0.
    source : str
        Author, title and year.

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
        """Return a value between two ends, which are not negative."""
        middle = low if low == high else math.sqrt(low * high) if low > 0 else high / 2
        value = super().__new__(cls, middle)
        value.low, value.high, value.source = low, high, source
        return value

    def __getnewargs__(self) -> tuple[float, float, str]:  # type: ignore[override]
        return self.low, self.high, self.source

    def __repr__(self) -> str:
        shown = f"{self.low:g}" if self.low == self.high else f"{self.low:g} to {self.high:g}"
        return f"<{shown}, {self.source}>"


@dataclass(frozen=True)
class Material:
    """A solid: what contact needs to know of it.

    Attributes
    ----------
    name : str
    kind : {"metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "elastomer", "rock"}
    young_modulus : MaterialValue, GPa
    poisson_ratio : MaterialValue
    hardness : MaterialValue or None, GPa
        Indentation hardness, the mean pressure at which the surface yields; it depends on treatment and on the size of
        the indentation, smaller ones being harder. None of an elastomer, which does not yield.
    aliases : tuple of str
        Other names that `material` takes.
    junction_growth : MaterialValue or None
        α of p² + α s² = H², by which plastic contacts under shear grow; None where it is taken as 0.

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
    junction_growth: MaterialValue | None = None

    @property
    def plane_strain_modulus(self) -> float:
        """E/(1 - ν²), GPa."""
        return float(self.young_modulus) / (1 - float(self.poisson_ratio) ** 2)


def material(name: str) -> Material:
    """A material by its name, in any case and with spaces, hyphens or none.

    Parameters
    ----------
    name : str
        One of `materials`, or another name of it.

    Raises
    ------
    ValueError
        If there is no such material; the message has the nearest names.

    Examples
    --------
    >>> from stiction import effective_modulus, material
    >>> steel, brass = material("steel"), material("brass")
    >>> round(effective_modulus(steel, brass), 1)
    78.7
    >>> material("brass").hardness.low, material("brass").hardness.high
    (0.23, 1.7)
    """
    known = _by_name()
    if not isinstance(name, str):
        raise ValueError(f"name must be the name of a material, got {name!r}")
    found = known.get(_bare(name))
    if found is None:
        near = difflib.get_close_matches(_bare(name), known, n=3, cutoff=0.5)
        names = [name for each in near for name in _names(known[each]) if _bare(name) == each]
        names = names or [each.name for each in materials()]
        hint = "the nearest are" if near else "there are"
        raise ValueError(f"name must be that of a known material, got {name[:80]!r}; {hint} {', '.join(names)}")
    return found


@cache
def materials() -> tuple[Material, ...]:
    """All materials, those of a kind one after the other.

    Examples
    --------
    >>> from stiction import materials
    >>> [each.name for each in materials() if each.kind == "glass"]
    ['fused silica', 'N-BK7 glass', 'soda-lime glass']
    """
    text = (resources.files("stiction.mechanics") / "materials.toml").read_text(encoding="utf-8")
    table = tomllib.loads(text)
    works = table["sources"]

    def value(row: dict[str, Any], name: str) -> Any:
        if name not in row:
            return None
        low, high, source = row[name]
        return MaterialValue(low, high, source.format_map(works))

    return tuple(
        Material(
            row["name"], kind, value(row, "young_modulus"), value(row, "poisson_ratio"), value(row, "hardness"),
            tuple(row.get("aliases", ())), value(table["junction_growth"], kind),
        )
        for kind in get_args(MaterialKind)
        for row in sorted(table[kind], key=lambda row: row["name"].casefold())
    )  # fmt: skip


def compliance_fraction(upper: Material, lower: Material) -> float:
    """c_l = E* (1 - ν_l²)/E_l, the lower body's fraction of the compliance of a pair.

    Examples
    --------
    >>> from stiction import compliance_fraction, material
    >>> round(compliance_fraction(material("steel"), material("ptfe")), 3)
    0.997
    """
    first, second = (_checked(name, body).plane_strain_modulus for name, body in (("upper", upper), ("lower", lower)))
    return first / (first + second)


def softer_hardness(upper: Material, lower: Material) -> MaterialValue | None:
    """The hardness (GPa) of the softer of two bodies, which yields first; None where one is an elastomer.

    An elastomer does not yield, and keeps the pressure far below the hardness of what it touches.

    Examples
    --------
    >>> from stiction import material, softer_hardness
    >>> float(softer_hardness(material("mild steel"), material("brass"))) == float(material("brass").hardness)
    True
    """
    softer = softer_material(_checked("upper", upper), _checked("lower", lower))
    return None if softer is None else softer.hardness


def softer_material(*bodies: Material) -> Material | None:
    """The material that yields first; None of no bodies, and where one is an elastomer."""
    known = [(each.hardness, each) for each in bodies if each.hardness is not None]
    return min(known, key=lambda pair: pair[0])[1] if known and len(known) == len(bodies) else None


def is_name_of(text: str, name: str) -> bool:
    """Whether a text is the name of a material itself, in any spelling, and not one of its aliases."""
    return _bare(text) == _bare(name)


def _checked(name: str, body: Any) -> Material:
    if not isinstance(body, Material):
        raise ValueError(f"{name} must be a Material, as material() gives it, got {type(body).__name__}")
    return body


def _bare(name: str) -> str:
    return "".join(character for character in name.casefold() if character.isalnum())


@cache
def _by_name() -> dict[str, Material]:
    return {_bare(name): each for each in materials() for name in _names(each)}


def _names(each: Material) -> tuple[str, ...]:
    """The name of a material and its other names."""
    return each.name, *each.aliases
