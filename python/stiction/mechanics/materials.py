"""Elastic moduli, Poisson's ratios and hardnesses of materials, each as a range with its source."""

from __future__ import annotations

import difflib
import math
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

MaterialKind = Literal["metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "rock"]


class MaterialValue(float):
    """A property of a material: the middle of what is known, as a number, with the range and its source.

    Attributes
    ----------
    low, high : float
        Between which it lies in the source; equal where the source has one number. The number itself is their geometric
        mean.
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
        """A value between two ends, above 0."""
        value = super().__new__(cls, math.sqrt(low * high) if low != high else low)
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
    kind : {"metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "rock"}
    young_modulus : MaterialValue, GPa
    poisson_ratio : MaterialValue
    hardness : MaterialValue, GPa
        Indentation hardness, the mean pressure at which the surface yields; it depends on treatment and on the size of
        the indentation, smaller ones being harder.
    aliases : tuple of str
        Other names that `material` takes.

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
    hardness: MaterialValue
    aliases: tuple[str, ...] = ()

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

    Returns
    -------
    Material

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
    return tuple(sorted(_TABLE, key=lambda each: (_ORDER.index(each.kind), each.name.casefold())))


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


def softer_hardness(upper: Material, lower: Material) -> MaterialValue:
    """The hardness (GPa) of the softer of two bodies, which yields first.

    Examples
    --------
    >>> from stiction import material, softer_hardness
    >>> float(softer_hardness(material("mild steel"), material("brass"))) == float(material("brass").hardness)
    True
    """
    return min(_checked("upper", upper).hardness, _checked("lower", lower).hardness)


def _checked(name: str, body: Any) -> Material:
    if not isinstance(body, Material):
        raise ValueError(f"{name} must be a Material, as material() gives it, got {type(body).__name__}")
    return body


def _bare(name: str) -> str:
    return "".join(character for character in name.casefold() if character.isalnum())


@cache
def _by_name() -> dict[str, Material]:
    return {_bare(name): each for each in _TABLE for name in _names(each)}


def _names(each: Material) -> tuple[str, ...]:
    """The name of a material and its other names."""
    return each.name, *each.aliases


# ---- Sources --------------------------------------------------------------------------------------------------------

NOT_SEEN = "not looked up"
"""Behind a source whose number was written from memory: the work itself, or a copy of its table, was not at hand."""

_CALLISTER = "Callister & Rethwisch, Fundamentals of Materials Science and Engineering, 3rd ed. (2008), appendix B"
_DOWLING = "Dowling, Mechanical Behavior of Materials, 4th ed. (2012), table 5.2"
_GERE = "Gere, Mechanics of Materials, 5th ed. (2001), typical moduli and Poisson's ratios"
_ELEMENTS = "Wikipedia, Elastic properties of the elements (web)"
_HARDNESSES = "Wikipedia, Hardnesses of the elements (data page), after Samsonov (1968)"
_BRINELL = "material-properties.org, Hardness of chemical elements (web)"
_STRENGTH = (
    "3 times yield to 3.3 times tensile strength (Tabor, The Hardness of Metals, 1951) of Callister & Rethwisch, "
    "Fundamentals of Materials Science and Engineering, 3rd ed. (2008), appendix B"
)
_TENSILE = (
    "cold worked: 3.3 times the tensile strength of Callister & Rethwisch, Fundamentals of Materials Science and "
    "Engineering, 3rd ed. (2008), appendix B"
)
_YIELD = (
    "3 times the yield strength (Tabor, The Hardness of Metals, 1951) of Callister & Rethwisch, Fundamentals of "
    "Materials Science and Engineering, 3rd ed. (2008), appendix B"
)
_CALLISTER_8 = "Callister & Rethwisch, Materials Science and Engineering, 8th ed. (2010), table B.3"
_MAKEITFROM = "MakeItFrom.com (web)"
_CERAMIQUE = "Céramique Technique, comparative table of mechanical properties (web)"
_SI3N4 = "review of silicon nitride, Int. J. Mol. Sci. 23 (2022) 6551, table 1"
_BEARING = "suppliers' data sheets of AISI 52100 (web)"
_SCHOTT = "SCHOTT, Optical Glass Data Sheets, N-BK7, as PM Optics has them (web)"
_MINERALS = "of bulk and shear moduli in tables of rock physics (web): quartz 37 and 44 GPa, calcite 77 and 32 GPa"
_MATWEB = "MatWeb, diamond (web)"


def _unseen(source: str) -> str:
    return f"{source} ({NOT_SEEN})"


_KAYE = _unseen("Kaye & Laby, Tables of Physical and Chemical Constants, 16th ed. (1995), section 2.2.2")
_CALLISTER_NU = _unseen("Callister & Rethwisch, 8th ed. (2010), table B.3")
_CERAMICS = _unseen("Callister & Rethwisch, 8th ed. (2010), table 12.6")
_OLIVER = _unseen("Oliver & Pharr, J. Mater. Res. 7 (1992) 1564")
_ROBERTSON = _unseen("Robertson, Diamond-like amorphous carbon, Mater. Sci. Eng. R 37 (2002) 129")
_BROZ = _unseen("Broz, Cook & Whitney, Am. Mineral. 91 (2006) 135")
_GOODMAN = _unseen("Goodman, Introduction to Rock Mechanics, 2nd ed. (1989), table 6.1")
_POLYMERS = _unseen("3 times the yield strength of Callister & Rethwisch, 8th ed. (2010), table B.4")


def _of(
    kind: MaterialKind,
    name: str,
    young: tuple[float, float, str],
    poisson: tuple[float, float, str],
    hardness: tuple[float, float, str],
    *aliases: str,
) -> Material:
    return Material(name, kind, MaterialValue(*young), MaterialValue(*poisson), MaterialValue(*hardness), aliases)


_ORDER: tuple[MaterialKind, ...] = ("metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "rock")

_TABLE = (
    # Metals
    _of("metal", "aluminium", (69, 70.3, f"{_CALLISTER}; {_DOWLING}"), (0.33, 0.345, f"{_GERE}; {_DOWLING}"),
        (0.16, 0.35, _HARDNESSES), "aluminum"),
    _of("metal", "aluminium alloy 6061-T6", (69, 69, _CALLISTER), (0.33, 0.33, _GERE), (0.83, 1.02, _STRENGTH),
        "6061", "aluminum 6061", "aluminium alloy", "aluminum alloy", "aluminum alloy 6061-T6"),
    _of("metal", "aluminium alloy 7075-T6", (71, 71, _CALLISTER), (0.33, 0.33, _GERE), (1.52, 1.89, _STRENGTH),
        "7075", "aluminum 7075", "aluminum alloy 7075-T6"),
    _of("metal", "bearing steel", (190, 210, _BEARING), (0.27, 0.3, _BEARING), (6.4, 7.8, f"{_BEARING}: 58 to 64 HRC"),
        "100Cr6", "AISI 52100", "52100", "hardened steel"),
    _of("metal", "brass", (100.6, 110, f"{_KAYE}, which {_DOWLING} rounds to 101; {_GERE}"), (0.35, 0.35, _DOWLING),
        (0.23, 1.7, "3 times yield to 3.3 times tensile strength (Tabor, The Hardness of Metals, 1951) of Diversified "
         "Bronze, C26000: 76 and 524 MPa"), "cartridge brass", "C26000"),
    _of("metal", "bronze", (110, 110, f"{_MAKEITFROM}: C51000"), (0.34, 0.34, f"{_MAKEITFROM}: C51000"),
        (0.39, 1.85, "3 times yield to 3.3 times tensile strength (Tabor, The Hardness of Metals, 1951) of BTI Metals, "
         "C51000, annealed to hard: 130 and 560 MPa"), "phosphor bronze", "C51000"),
    _of("metal", "chromium", (279, 279, _ELEMENTS), (0.21, 0.21, _KAYE), (1.06, 1.06, _HARDNESSES)),
    _of("metal", "copper", (110, 130, f"{_GERE}; {_DOWLING}"), (0.34, 0.343, f"{_GERE}; {_DOWLING}"),
        (0.34, 1.14, f"annealed: {_HARDNESSES}; {_TENSILE}")),
    _of("metal", "gold", (77, 78, _KAYE), (0.42, 0.44, _KAYE), (0.19, 0.73, f"annealed: {_BRINELL}; {_TENSILE}")),
    _of("metal", "grey cast iron", (66, 138, _CALLISTER), (0.2, 0.3, _GERE),
        (1.4, 2.6, _unseen("SAE J431, Automotive Gray Iron Castings: 143 to 269 HB")), "gray cast iron", "cast iron"),
    _of("metal", "iron", (211, 212, f"{_ELEMENTS}; {_DOWLING}"), (0.293, 0.293, _DOWLING), (0.608, 0.608, _HARDNESSES)),
    _of("metal", "lead", (13.5, 16.1, f"{_CALLISTER}; {_DOWLING}"), (0.44, 0.44, _DOWLING),
        (0.038, 0.05, f"{_BRINELL}; upper end: {_unseen('Samsonov, 1968')}")),
    _of("metal", "low-alloy steel", (207, 207, _CALLISTER), (0.27, 0.3, _GERE), (1.25, 5.8, _STRENGTH),
        "4140", "4340", "alloy steel"),
    _of("metal", "magnesium", (44.7, 45, f"{_DOWLING}; {_ELEMENTS}"), (0.291, 0.35, f"{_DOWLING}; {_GERE}"),
        (0.26, 0.26, _HARDNESSES)),
    _of("metal", "mild steel", (207, 212, f"{_CALLISTER}; {_DOWLING}"), (0.29, 0.3, f"{_DOWLING}; {_GERE}"),
        (0.63, 1.65, _STRENGTH), "steel", "low-carbon steel", "carbon steel", "1020", "A36"),
    _of("metal", "molybdenum", (329, 329, _ELEMENTS), (0.293, 0.32, _KAYE), (1.4, 2.74, _HARDNESSES)),
    _of("metal", "nickel", (200, 210, f"{_ELEMENTS}; {_GERE}"), (0.31, 0.31, _GERE), (0.44, 1.52, _STRENGTH)),
    _of("metal", "niobium", (105, 105, _ELEMENTS), (0.397, 0.397, _KAYE), (0.87, 1.32, _HARDNESSES)),
    _of("metal", "platinum", (168, 171, _KAYE), (0.377, 0.39, _KAYE),
        (0.4, 0.55, f"{_BRINELL}; upper end: {_unseen('Samsonov, 1968')}")),
    _of("metal", "silver", (74, 83, f"{_unseen('Callister & Rethwisch, 8th ed. (2010), table B.2')}; {_ELEMENTS}"),
        (0.367, 0.37, _KAYE), (0.25, 0.98, f"annealed: {_HARDNESSES}; {_TENSILE}")),
    _of("metal", "stainless steel", (193, 200, f"{_CALLISTER}; {_MAKEITFROM}, 304"),
        (0.28, 0.3, f"{_MAKEITFROM}, 304; {_GERE}"),
        (0.61, 3.5, f"3 times the yield strength of ASTM A213, 304: 205 MPa; {_MAKEITFROM}, 304, half-hard: 360 HB"),
        "304", "316", "AISI 304", "AISI 316"),
    _of("metal", "tantalum", (185, 185.7, _KAYE), (0.342, 0.35, _KAYE), (0.873, 1.2, _HARDNESSES)),
    _of("metal", "tin", (44.3, 50, f"{_CALLISTER}; {_ELEMENTS}"), (0.33, 0.357, _KAYE), (0.051, 0.075, _HARDNESSES)),
    _of("metal", "titanium", (116, 120, f"{_ELEMENTS}; {_DOWLING}"), (0.33, 0.361, f"{_GERE}; {_DOWLING}"),
        (0.83, 3.42, _HARDNESSES)),
    _of("metal", "titanium alloy Ti-6Al-4V", (114, 114, "eCourses, Multimedia Engineering Mechanics, appendix (web)"),
        (0.33, 0.33, _GERE), (2.5, 3.9, _STRENGTH), "Ti-6Al-4V", "Ti64", "titanium alloy"),
    _of("metal", "tungsten", (411, 411, _DOWLING), (0.28, 0.28, _DOWLING), (3.43, 4.6, _unseen("Samsonov, 1968"))),
    _of("metal", "vanadium", (128, 128, _ELEMENTS), (0.365, 0.365, _KAYE), (0.628, 0.64, _HARDNESSES)),
    _of("metal", "zinc", (104.5, 108, f"{_CALLISTER}; {_ELEMENTS}"), (0.249, 0.25, _KAYE),
        (0.327, 0.412, _HARDNESSES)),
    # Ceramics
    _of("ceramic", "alumina", (380, 400, f"{_CALLISTER}; {_DOWLING}"), (0.22, 0.22, _DOWLING),
        (12, 20, f"{_CERAMIQUE}; GGS Ceramic, Alumina ceramic hardness"),
        "aluminium oxide", "aluminum oxide", "Al2O3"),
    _of("ceramic", "diamond", (700, 1200, f"{_CALLISTER}; {_MATWEB}"), (0.1, 0.29, _MATWEB), (88, 147, _MATWEB)),
    _of("ceramic", "silicon carbide", (396, 483, f"{_DOWLING}; {_CALLISTER}"), (0.22, 0.22, _DOWLING),
        (19.8, 25.4, _CERAMICS), "SiC"),
    _of("ceramic", "silicon nitride", (300, 315, _CERAMIQUE), (0.24, 0.27, _MAKEITFROM), (11, 16, _SI3N4), "Si3N4"),
    _of("ceramic", "tungsten carbide", (550, 630, f"Wikipedia, Tungsten carbide (web); {_MAKEITFROM}"),
        (0.24, 0.24, _MAKEITFROM), (16.4, 22, f"{_MAKEITFROM}: 1670 HK; Wikipedia, Tungsten carbide"),
        "WC", "cemented carbide"),
    _of("ceramic", "zirconia", (200, 220, _CERAMIQUE), (0.23, 0.317, _CALLISTER_NU), (11, 16, _CERAMIQUE), "ZrO2"),
    # Glasses
    _of("glass", "fused silica", (70, 73, f"{_DOWLING}; {_CALLISTER}"), (0.18, 0.18, _DOWLING), (8.3, 9.5, _OLIVER),
        "silica", "quartz glass", "fused quartz"),
    _of("glass", "N-BK7 glass", (82, 82, _SCHOTT), (0.206, 0.206, _SCHOTT), (6.0, 6.0, _SCHOTT),
        "BK7", "optical glass"),
    _of("glass", "soda-lime glass", (69, 70, f"{_DOWLING}; {_GERE}"), (0.2, 0.2, f"{_DOWLING}; {_GERE}"),
        (5.5, 6.1, f"{_CERAMICS}; {_OLIVER}"), "glass", "window glass", "float glass"),
    # Semiconductors
    _of("semiconductor", "silicon", (130, 188, _ELEMENTS),
        (0.064, 0.28, _unseen("Hopcroft, Nix & Kenny, J. Microelectromech. Syst. 19 (2010) 229")),
        (9, 13, _unseen("Pharr, Oliver & Harding, J. Mater. Res. 6 (1991) 1129")), "Si"),
    # Coatings
    _of("coating", "diamond-like carbon", (100, 300, _ROBERTSON), (0.2, 0.3, _ROBERTSON), (10, 30, _ROBERTSON),
        "DLC", "a-C:H", "hydrogenated amorphous carbon"),
    _of("coating", "tetrahedral amorphous carbon", (490, 760, _ROBERTSON), (0.12, 0.2, _ROBERTSON),
        (50, 80, _ROBERTSON), "ta-C", "hydrogen-free diamond-like carbon"),
    # Polymers
    _of("polymer", "HDPE", (0.7, 1.4, _GERE), (0.4, 0.42, f"{_GERE}; {_DOWLING}"), (0.078, 0.1, _POLYMERS),
        "polyethylene", "high-density polyethylene", "PE"),
    _of("polymer", "nylon 6,6", (1.59, 3.79, _CALLISTER), (0.4, 0.41, f"{_GERE}; {_DOWLING}"), (0.13, 0.25, _YIELD),
        "nylon", "polyamide", "PA", "PA66"),
    _of("polymer", "PEEK", (3.6, 4.0, f"Wikipedia, Polyether ether ketone (web); {_MAKEITFROM}"),
        (0.36, 0.42, _unseen("Rae, Brown & Orler, Polymer 48 (2007) 598")),
        (0.27, 0.3, "3 times the tensile strength of Wikipedia, Polyether ether ketone (web)"),
        "polyether ether ketone"),
    _of("polymer", "PET", (2.76, 4.14, _CALLISTER), (0.37, 0.44, _unseen("Mark, Polymer Data Handbook, 1999")),
        (0.17, 0.19, _POLYMERS), "polyethylene terephthalate", "polyester"),
    _of("polymer", "PMMA", (2.24, 3.24, _CALLISTER), (0.35, 0.35, _DOWLING), (0.16, 0.22, _YIELD),
        "acrylic", "plexiglas", "perspex", "polymethyl methacrylate"),
    _of("polymer", "polycarbonate", (2.38, 2.4, f"{_CALLISTER}; {_DOWLING}"), (0.38, 0.38, _DOWLING),
        (0.17, 0.21, _POLYMERS), "PC"),
    _of("polymer", "polypropylene", (1.14, 1.55, _CALLISTER), (0.4, 0.4, _CALLISTER_NU), (0.093, 0.112, _YIELD), "PP"),
    _of("polymer", "polystyrene", (2.28, 3.28, _CALLISTER), (0.33, 0.33, _CALLISTER_8), (0.075, 0.207, _YIELD), "PS"),
    _of("polymer", "PTFE", (0.4, 0.55, _CALLISTER), (0.46, 0.46, _CALLISTER_8), (0.041, 0.046, _YIELD),
        "teflon", "polytetrafluoroethylene"),
    _of("polymer", "PVC", (2.41, 4.14, _CALLISTER), (0.38, 0.38, _CALLISTER_8), (0.122, 0.134, _YIELD),
        "polyvinyl chloride"),
    # Rocks and what they are made of
    _of("rock", "calcite", (84.3, 84.3, _MINERALS), (0.32, 0.32, _MINERALS), (1.0, 2.5, _BROZ)),
    _of("rock", "granite", (49.6, 73.8, f"{_DOWLING}; {_GOODMAN}"), (0.21, 0.22, f"{_DOWLING}; {_GOODMAN}"),
        (6.5, 14, f"its feldspar to its quartz: {_BROZ}")),
    _of("rock", "limestone", (55.8, 69, f"{_GOODMAN}; {_DOWLING}"), (0.28, 0.3, f"{_DOWLING}; {_GOODMAN}"),
        (1.0, 2.5, f"its calcite: {_BROZ}")),
    _of("rock", "marble", (55.8, 55.8, _GOODMAN), (0.25, 0.25, _GOODMAN), (1.0, 2.5, f"its calcite: {_BROZ}")),
    _of("rock", "quartz", (94.5, 94.5, _MINERALS), (0.074, 0.074, _MINERALS), (10.8, 14, f"{_BROZ}; {_OLIVER}")),
)  # fmt: skip
