"""What both bodies of a pair are made of, from arguments that say it: numbers, or materials by their names."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stiction._arguments import parse_numbers, parse_quantities, parse_quantity
from stiction._errors import ArgumentError
from stiction._units import short_repr
from stiction.mechanics.closed_forms import effective_modulus
from stiction.mechanics.materials import compliance_fraction, is_name_of, material, softer_material


@dataclass(frozen=True)
class Elasticity:
    """Elasticity of a pair, and what is known of its softer body."""

    effective_modulus: float  # GPa
    compliance_share: float = 0.5  # the lower body's fraction, one half unless both bodies are known
    poisson_ratio: float | None = None  # of the softer body
    hardness: float | None = None  # of the softer body, GPa
    source: str = ""  # where the modulus is from, if it is that of materials
    hardness_source: str = ""
    materials: tuple[str, str] | None = None  # what the upper and the lower body are made of
    poisson_ratios: tuple[float, float] | None = None  # of the upper and the lower body
    renamed: str = ""  # which materials were given by another of their names


def elasticity_of(
    effective_modulus: Any = None, young: Any = None, poisson: Any = None, upper_material: str | None = None,
    lower_material: str | None = None,
) -> Elasticity:  # fmt: skip
    """What a modulus, or Young's moduli and Poisson's ratios, or materials say, of which one is needed.

    Raises a `ValueError` if none or several of these are given, or a value is none.
    """
    modulus, upper, lower = effective_modulus, upper_material, lower_material
    for place, name in (("upper", upper), ("lower", lower)):
        if not isinstance(name, str | None):
            raise ArgumentError(
                f"{{{place}_material}} must be the name of a material, got {{got}}", got=short_repr(name)
            )
    named = "{upper_material} and {lower_material}"
    ways = {"{effective_modulus}": modulus, "{young}": young, named: upper or lower}
    chosen = [way for way, value in ways.items() if value is not None]
    if young is not None and bool(upper) != bool(lower):
        return _of_one_material(upper, lower, young, poisson)
    if len(chosen) != 1:
        raise ArgumentError(
            f"give {{effective_modulus}}, or {{young}} and {{poisson}}, or {named}"
            + (f", not both {' and '.join(chosen)}" if chosen else "")
        )
    if upper or lower:
        if poisson is not None:
            raise ArgumentError(f"{{poisson}} must not be given beside {named}, which say it")
        return _of_materials(str(upper or lower), str(lower or upper))
    ratios = None if poisson is None else parse_numbers("poisson", poisson)
    if ratios is not None and (len(ratios) > 2 or not all(0 <= ratio <= 0.5 for ratio in ratios)):
        raise ArgumentError("{poisson} must be one or two numbers from 0 to 0.5, got {got}", got=repr(poisson))
    if modulus is not None:
        if ratios is not None and len(ratios) > 1:
            raise ArgumentError(
                "{poisson} beside {effective_modulus} is of the softer body alone, got {got}", got=repr(poisson)
            )
        value = float(parse_quantity("effective_modulus", modulus, "pressure"))
        if not value > 0:
            raise ArgumentError("{effective_modulus} must be above 0, got {got}", got=repr(modulus))
        return Elasticity(value, poisson_ratio=None if ratios is None else ratios[0])
    moduli = [float(each) for each in parse_quantities("young", young, "pressure")]
    if len(moduli) > 2:
        raise ArgumentError("{young} must be one modulus or two, got {got}", got=repr(young))
    if ratios is None:
        raise ArgumentError("{young} needs {poisson}, of both bodies or of one after the other")
    (of_upper, of_lower), (upper_ratio, lower_ratio) = (2 * moduli)[:2], (2 * ratios)[:2]
    return _of_two(of_upper, upper_ratio, of_lower, lower_ratio)


def _of_one_material(upper: str | None, lower: str | None, young: Any, poisson: Any) -> Elasticity:
    moduli = [float(each) for each in parse_quantities("young", young, "pressure")]
    ratios = [] if poisson is None else parse_numbers("poisson", poisson)
    if len(moduli) != 1 or len(ratios) != 1 or not 0 <= ratios[0] <= 0.5:
        raise ArgumentError(
            'beside one material {young} and {poisson} are of the other body, as in "3 MPa" and "0.5", one of each'
        )
    name = "upper_material" if upper else "lower_material"
    known = _material(name, str(upper or lower))
    bodies = [(_rounded(known.young_modulus), _rounded(known.poisson_ratio)), (moduli[0], ratios[0])]
    (one, one_ratio), (other, other_ratio) = bodies if upper else bodies[::-1]
    softer = known.hardness is not None and known.young_modulus <= moduli[0]
    return replace(
        _of_two(one, one_ratio, other, other_ratio),
        hardness=_rounded(known.hardness) if softer else None,
        source=f"{known.name}: E {bodies[0][0]:g} GPa, ν {bodies[0][1]:g}",
        hardness_source=f"hardness {_rounded(known.hardness):g} GPa ({known.hardness.source})"
        if softer else "the other body's hardness is not known",
    )  # fmt: skip


def _of_two(upper: float, upper_ratio: float, lower: float, lower_ratio: float) -> Elasticity:
    modulus = float(effective_modulus(upper, upper_ratio, lower, lower_ratio))
    return Elasticity(
        modulus, compliance_share=modulus * (1 - lower_ratio**2) / lower,
        poisson_ratio=upper_ratio if upper <= lower else lower_ratio, poisson_ratios=(upper_ratio, lower_ratio),
    )  # fmt: skip


def _of_materials(upper: str, lower: str) -> Elasticity:
    """Elasticity of two bodies by the names of their materials, and the hardness of the softer one if it yields."""
    above, below = _material("upper_material", upper), _material("lower_material", lower)
    modulus = _rounded(effective_modulus(above, below))
    softer = softer_material(above, below) or min((above, below), key=lambda body: body.young_modulus)
    hardness, said = softer.hardness, f"{softer.name} does not yield"
    if hardness is not None:
        ends = "" if hardness.low == hardness.high else f", of {hardness.low:g} to {hardness.high:g} GPa"
        said = f"hardness {_rounded(hardness):g} GPa{ends} ({hardness.source})"
    return Elasticity(
        modulus, compliance_share=_rounded(compliance_fraction(above, below)),
        poisson_ratio=float(softer.poisson_ratio), hardness=None if hardness is None else _rounded(hardness),
        source=f"{above.name} on {below.name}: E* {modulus:g} GPa", hardness_source=said,
        materials=(above.name, below.name),
        poisson_ratios=(_rounded(above.poisson_ratio), _rounded(below.poisson_ratio)),
        renamed=_renamed(dict.fromkeys(((upper, above.name), (lower, below.name)))),
    )  # fmt: skip


def _renamed(names: Iterable[tuple[str, str]]) -> str:
    """Return which materials are meant by names, as given, that are not their own; empty if all are."""
    others = [f'"{given}"{{}} as {name}' for given, name in names if not is_name_of(given, name)]
    words = ", ".join(text.format("" if index else " is taken") for index, text in enumerate(others))
    return f"{words} (stiction materials lists others)" if len(others) == 1 else words


def _material(argument: str, name: str) -> Any:
    """A material by its name, or an error that calls the argument by its own; a file is none."""
    try:
        return material(name)
    except ValueError as error:
        if (Path(name).suffix and not name.endswith(".")) or "/" in name:
            why = "is a material, such as steel; the files come first"
            raise ArgumentError(f"{{{argument}}} {why}, got {{got}}", got=repr(name)) from None
        raise ArgumentError(f"{{{argument}}} {{why}}", why=str(error).removeprefix("name ")) from None


def _rounded(value: float) -> float:
    """A number in three digits, of which more are not known of a material."""
    return float(f"{value:.3g}")
