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
        names = sorted({known[each].name for each in near}) or [each.name for each in materials()]
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
    return {_bare(name): each for each in _TABLE for name in (each.name, *each.aliases)}


# ---- Sources --------------------------------------------------------------------------------------------------------

_ASHBY = "Ashby, Materials Selection in Mechanical Design, 4th ed. (2011), appendix A"
_CALLISTER = "Callister & Rethwisch, Materials Science and Engineering, 8th ed. (2010), appendix B"
_CERAMICS = "Callister & Rethwisch, Materials Science and Engineering, 8th ed. (2010), table 12.6"
_STRENGTH = (
    "3 times yield to 3.3 times tensile strength (Tabor, The Hardness of Metals, 1951) of Callister & Rethwisch, "
    "Materials Science and Engineering, 8th ed. (2010), appendix B"
)
_YIELD = (
    "3 times the yield strength (Tabor, The Hardness of Metals, 1951) of Callister & Rethwisch, Materials Science and "
    "Engineering, 8th ed. (2010), appendix B"
)
_DOWLING = "Dowling, Mechanical Behavior of Materials, 4th ed. (2012), table 5.2"
_KAYE = "Kaye & Laby, Tables of Physical and Chemical Constants, 16th ed. (1995), section 2.2.2"
_KAYE_CALLISTER = "Kaye & Laby, 16th ed. (1995), section 2.2.2; Callister & Rethwisch, 8th ed. (2010), appendix B"
_SAMSONOV = "Samsonov, Handbook of the Physicochemical Properties of the Elements (1968)"
_SOFT_TO_WORKED = (
    "annealed: Samsonov, Handbook of the Physicochemical Properties of the Elements (1968); cold worked: 3.3 times the "
    "tensile strength of Callister & Rethwisch, 8th ed. (2010), appendix B"
)
_MUNRO = "Munro, Evaluated material properties for a sintered α-alumina, J. Am. Ceram. Soc. 80 (1997) 1919"
_OLIVER = "Oliver & Pharr, An improved technique for determining hardness, J. Mater. Res. 7 (1992) 1564"
_ROBERTSON = "Robertson, Diamond-like amorphous carbon, Mater. Sci. Eng. R 37 (2002) 129"
_MAVKO = "Mavko, Mukerji & Dvorkin, The Rock Physics Handbook, 2nd ed. (2009), appendix A"
_BROZ = "Broz, Cook & Whitney, Microhardness, toughness, and modulus of Mohs scale minerals, Am. Mineral. 91 (2006) 135"
_GOODMAN = "Goodman, Introduction to Rock Mechanics, 2nd ed. (1989), table 6.1"
_HOPCROFT = "Hopcroft, Nix & Kenny, What is the Young's modulus of silicon?, J. Microelectromech. Syst. 19 (2010) 229"
_HARRIS = "Harris & Kotzalas, Essential Concepts of Bearing Technology, 5th ed. (2006): 58 to 65 HRC"
_SCHOTT = "SCHOTT, Optical Glass Data Sheets (2015), N-BK7"


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
    _of("metal", "aluminium", (69, 70.3, _KAYE_CALLISTER), (0.33, 0.345, _KAYE_CALLISTER), (0.16, 0.35, _SAMSONOV),
        "aluminum"),
    _of("metal", "aluminium alloy 6061-T6", (69, 69, _CALLISTER), (0.33, 0.33, _CALLISTER), (0.82, 1.03, _STRENGTH),
        "6061", "aluminum 6061", "aluminium alloy", "aluminum alloy", "aluminum alloy 6061-T6"),
    _of("metal", "aluminium alloy 7075-T6", (71, 71, _CALLISTER), (0.33, 0.33, _CALLISTER), (1.5, 1.9, _STRENGTH),
        "7075", "aluminum 7075", "aluminum alloy 7075-T6"),
    _of("metal", "bearing steel", (200, 215, _ASHBY), (0.283, 0.3, _KAYE_CALLISTER), (6.4, 8.2, _HARRIS),
        "100Cr6", "AISI 52100", "52100", "hardened steel"),
    _of("metal", "brass", (100.6, 110, _KAYE_CALLISTER), (0.35, 0.35, _KAYE_CALLISTER), (0.23, 1.7, _STRENGTH),
        "cartridge brass", "C26000"),
    _of("metal", "bronze", (110, 110, _CALLISTER), (0.34, 0.34, _CALLISTER), (0.39, 1.85, _STRENGTH),
        "phosphor bronze", "C51000"),
    _of("metal", "chromium", (279.1, 279.1, _KAYE), (0.21, 0.21, _KAYE), (1.06, 1.06, _SAMSONOV)),
    _of("metal", "copper", (110, 129.8, _KAYE_CALLISTER), (0.34, 0.343, _KAYE_CALLISTER),
        (0.34, 1.15, _SOFT_TO_WORKED)),
    _of("metal", "gold", (77, 78, _KAYE_CALLISTER), (0.42, 0.44, _KAYE_CALLISTER), (0.188, 0.73, _SOFT_TO_WORKED)),
    _of("metal", "grey cast iron", (66, 138, _CALLISTER), (0.26, 0.27, _KAYE_CALLISTER),
        (1.4, 2.6, "SAE J431, Automotive Gray Iron Castings: 143 to 269 HB"), "gray cast iron", "cast iron"),
    _of("metal", "iron", (211.4, 211.4, _KAYE), (0.293, 0.293, _KAYE), (0.608, 0.608, _SAMSONOV)),
    _of("metal", "lead", (13.5, 16.1, _KAYE_CALLISTER), (0.44, 0.44, _KAYE_CALLISTER), (0.038, 0.05, _SAMSONOV)),
    _of("metal", "low-alloy steel", (205, 207, _CALLISTER), (0.29, 0.3, _CALLISTER), (1.25, 5.8, _STRENGTH),
        "4140", "4340", "alloy steel"),
    _of("metal", "magnesium", (44.7, 45, _KAYE_CALLISTER), (0.291, 0.35, _KAYE_CALLISTER), (0.26, 0.26, _SAMSONOV)),
    _of("metal", "mild steel", (207, 212, _KAYE_CALLISTER), (0.29, 0.3, _KAYE_CALLISTER), (0.63, 1.65, _STRENGTH),
        "steel", "low-carbon steel", "carbon steel", "1020", "A36"),
    _of("metal", "molybdenum", (320, 324.8, _KAYE_CALLISTER), (0.293, 0.32, _KAYE_CALLISTER), (1.4, 2.74, _SAMSONOV)),
    _of("metal", "nickel", (199.5, 207, _KAYE_CALLISTER), (0.31, 0.312, _KAYE_CALLISTER), (0.44, 1.55, _STRENGTH)),
    _of("metal", "niobium", (104.9, 104.9, _KAYE), (0.397, 0.397, _KAYE), (0.87, 1.32, _SAMSONOV)),
    _of("metal", "platinum", (168, 171, _KAYE_CALLISTER), (0.377, 0.39, _KAYE_CALLISTER), (0.4, 0.55, _SAMSONOV)),
    _of("metal", "silver", (74, 82.7, _KAYE_CALLISTER), (0.367, 0.37, _KAYE_CALLISTER), (0.25, 0.98, _SOFT_TO_WORKED)),
    _of("metal", "stainless steel", (193, 193, _CALLISTER), (0.3, 0.3, _CALLISTER), (0.61, 2.9, _STRENGTH),
        "304", "316", "AISI 304", "AISI 316"),
    _of("metal", "tantalum", (185, 185.7, _KAYE_CALLISTER), (0.342, 0.35, _KAYE_CALLISTER), (0.873, 1.2, _SAMSONOV)),
    _of("metal", "tin", (44.3, 49.9, _KAYE_CALLISTER), (0.33, 0.357, _KAYE_CALLISTER), (0.051, 0.075, _SAMSONOV)),
    _of("metal", "titanium", (103, 120, f"{_CALLISTER}; {_DOWLING}"), (0.34, 0.361, f"{_CALLISTER}; {_DOWLING}"),
        (0.83, 3.42, _SAMSONOV)),
    _of("metal", "titanium alloy Ti-6Al-4V", (114, 114, _CALLISTER), (0.34, 0.34, _CALLISTER), (2.5, 3.9, _STRENGTH),
        "Ti-6Al-4V", "Ti64", "titanium alloy"),
    _of("metal", "tungsten", (407, 411, _KAYE_CALLISTER), (0.28, 0.28, _KAYE_CALLISTER), (3.43, 4.6, _SAMSONOV)),
    _of("metal", "vanadium", (127.6, 127.6, _KAYE), (0.365, 0.365, _KAYE), (0.628, 0.64, _SAMSONOV)),
    _of("metal", "zinc", (104.5, 108.4, _KAYE_CALLISTER), (0.249, 0.25, _KAYE_CALLISTER), (0.327, 0.412, _SAMSONOV)),
    # Ceramics
    _of("ceramic", "alumina", (386, 446, _MUNRO), (0.22, 0.231, f"{_MUNRO}; {_DOWLING}"),
        (13, 26.5, f"{_MUNRO}; {_CERAMICS}"), "aluminium oxide", "aluminum oxide", "Al2O3"),
    _of("ceramic", "diamond", (700, 1200, _CALLISTER), (0.1, 0.3, _CALLISTER), (103, 130, _CERAMICS)),
    _of("ceramic", "silicon carbide", (396, 460, f"{_DOWLING}; {_ASHBY}"), (0.16, 0.22, f"{_CALLISTER}; {_DOWLING}"),
        (19.8, 25.4, _CERAMICS), "SiC"),
    _of("ceramic", "silicon nitride", (280, 310, _ASHBY), (0.22, 0.3, _CALLISTER), (16.0, 17.2, _CERAMICS), "Si3N4"),
    _of("ceramic", "tungsten carbide", (534.4, 720, f"{_KAYE}; {_ASHBY}"), (0.22, 0.24, _KAYE), (13, 22.1, _CERAMICS),
        "WC", "cemented carbide"),
    _of("ceramic", "zirconia", (200, 205, _CALLISTER), (0.23, 0.317, _CALLISTER), (11, 12.5, _CERAMICS), "ZrO2"),
    # Glasses
    _of("glass", "fused silica", (69.3, 73.1, f"{_KAYE}; {_OLIVER}"), (0.17, 0.18, f"{_KAYE}; {_DOWLING}"),
        (8.3, 9.5, _OLIVER), "silica", "quartz glass", "fused quartz"),
    _of("glass", "N-BK7 glass", (82, 82, _SCHOTT), (0.206, 0.206, _SCHOTT), (6.0, 6.0, _SCHOTT),
        "BK7", "optical glass"),
    _of("glass", "soda-lime glass", (68, 72, _ASHBY), (0.2, 0.23, f"{_CALLISTER}; {_DOWLING}"),
        (5.5, 6.1, f"{_CERAMICS}; {_OLIVER}"), "glass", "window glass", "float glass"),
    # Semiconductors
    _of("semiconductor", "silicon", (130, 188, _HOPCROFT), (0.064, 0.28, _HOPCROFT),
        (9, 13, "Pharr, Oliver & Harding, New evidence for a pressure-induced phase transformation during the "
         "indentation of silicon, J. Mater. Res. 6 (1991) 1129"), "Si"),
    # Coatings
    _of("coating", "diamond-like carbon", (100, 300, _ROBERTSON), (0.2, 0.3, _ROBERTSON), (10, 30, _ROBERTSON),
        "DLC", "a-C:H", "hydrogenated amorphous carbon"),
    _of("coating", "tetrahedral amorphous carbon", (490, 760, _ROBERTSON), (0.12, 0.2, _ROBERTSON),
        (50, 80, _ROBERTSON), "ta-C", "hydrogen-free diamond-like carbon"),
    # Polymers
    _of("polymer", "HDPE", (0.62, 1.08, f"{_CALLISTER}; {_ASHBY}"), (0.42, 0.46, f"{_CALLISTER}; {_DOWLING}"),
        (0.078, 0.1, _YIELD), "polyethylene", "high-density polyethylene", "PE"),
    _of("polymer", "nylon 6,6", (1.59, 3.79, _CALLISTER), (0.39, 0.41, f"{_CALLISTER}; {_DOWLING}"),
        (0.13, 0.25, _YIELD), "nylon", "polyamide", "PA", "PA66"),
    _of("polymer", "PEEK", (3.5, 4.2, _ASHBY), (0.36, 0.42,
        "Rae, Brown & Orler, The mechanical properties of poly(ether-ether-ketone), Polymer 48 (2007) 598"),
        (0.195, 0.29, f"3 times the yield strength (Tabor, The Hardness of Metals, 1951) of {_ASHBY}"),
        "polyether ether ketone"),
    _of("polymer", "PET", (2.76, 4.14, _CALLISTER), (0.37, 0.44, "Mark, Polymer Data Handbook (1999)"),
        (0.17, 0.19, _YIELD), "polyethylene terephthalate", "polyester"),
    _of("polymer", "PMMA", (2.24, 3.24, _CALLISTER), (0.35, 0.44, f"{_CALLISTER}; {_DOWLING}"), (0.16, 0.22, _YIELD),
        "acrylic", "plexiglas", "perspex", "polymethyl methacrylate"),
    _of("polymer", "polycarbonate", (2.0, 2.44, _ASHBY), (0.36, 0.38, f"{_CALLISTER}; {_DOWLING}"),
        (0.17, 0.21, f"{_YIELD}; {_ASHBY}"), "PC"),
    _of("polymer", "polypropylene", (1.14, 1.55, _CALLISTER), (0.4, 0.4, _CALLISTER), (0.093, 0.112, _YIELD), "PP"),
    _of("polymer", "polystyrene", (2.28, 3.28, _CALLISTER), (0.33, 0.33, _CALLISTER), (0.075, 0.207, _YIELD), "PS"),
    _of("polymer", "PTFE", (0.4, 0.55, _CALLISTER), (0.46, 0.46, _CALLISTER), (0.041, 0.046, _YIELD),
        "teflon", "polytetrafluoroethylene"),
    _of("polymer", "PVC", (2.41, 4.14, _CALLISTER), (0.38, 0.38, _CALLISTER), (0.122, 0.135, _YIELD),
        "polyvinyl chloride"),
    # Rocks and what they are made of
    _of("rock", "calcite", (84.3, 84.3, _MAVKO), (0.32, 0.32, _MAVKO), (1.0, 2.5, _BROZ)),
    _of("rock", "granite", (49.6, 73.8, f"{_DOWLING}; {_GOODMAN}"), (0.21, 0.22, f"{_DOWLING}; {_GOODMAN}"),
        (6.5, 14, f"its feldspar to its quartz: {_BROZ}")),
    _of("rock", "limestone", (55.8, 63.7, _GOODMAN), (0.29, 0.3, _GOODMAN), (1.0, 2.5, f"its calcite: {_BROZ}")),
    _of("rock", "marble", (55.8, 55.8, _GOODMAN), (0.25, 0.25, _GOODMAN), (1.0, 2.5, f"its calcite: {_BROZ}")),
    _of("rock", "quartz", (94.5, 95.8, _MAVKO), (0.06, 0.08, _MAVKO), (10.8, 14, f"{_BROZ}; {_OLIVER}")),
)  # fmt: skip
