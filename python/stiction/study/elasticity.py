"""Elastic constants of a pair of bodies, from elastic moduli or from names of materials."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from stiction._arguments import parse_numbers, parse_quantities, parse_quantity
from stiction._errors import ArgumentError
from stiction._units import short_repr
from stiction.mechanics.closed_forms import effective_modulus
from stiction.mechanics.materials import (
    MaterialValue,
    are_material_names_equal,
    compliance_fraction,
    is_coating_formula,
    material,
    softest_material,
)

NUM_MATERIAL_DIGITS = 3
# If elastic constants have this number of digits, E* of any two materials is correct to three digits.
NUM_ELASTIC_CONSTANT_DIGITS = 6


@dataclass(frozen=True)
class PairElasticity:
    """Elastic constants of a pair of bodies, and the hardness of the softer body."""

    effective_modulus: float  # E*, GPa
    # Fraction of the elastic compliance that is due to the lower body, or 0.5 if only E* is given.
    compliance_share: float = 0.5
    poisson_ratio: float | None = None  # of the softer body
    hardness: MaterialValue | None = None  # GPa, of the softer body
    source: str = ""
    hardness_source: str = ""
    materials: tuple[str, str] | None = None  # upper, lower
    poisson_ratios: tuple[float, float] | None = None  # upper, lower
    alias_note: str = ""


def determine_elasticity(
    effective_modulus: Any = None, young: Any = None, poisson: Any = None, upper_material: str | None = None,
    lower_material: str | None = None,
) -> PairElasticity:  # fmt: skip
    """Return the elastic constants of a pair, from E*, from two materials, or from moduli and Poisson's ratios.

    Raises a `ValueError` if none or several of these alternatives are given, or if a value is invalid.
    """
    modulus, upper_name, lower_name = effective_modulus, upper_material, lower_material
    for side, name in (("upper", upper_name), ("lower", lower_name)):
        if not isinstance(name, str | None):
            raise ArgumentError(
                f"{{{side}_material}} must be the name of a material, got {{got}}", got=short_repr(name)
            )
    materials_text = "{upper_material} and {lower_material}"
    sources = {"{effective_modulus}": modulus, "{young}": young, materials_text: upper_name or lower_name}
    given_sources = [source for source, value in sources.items() if value is not None]
    if young is not None and bool(upper_name) != bool(lower_name):
        return _combine_material_with_moduli(upper_name, lower_name, young, poisson)
    if len(given_sources) != 1:
        raise ArgumentError(
            f"give {{effective_modulus}}, or {{young}} and {{poisson}}, or {materials_text}"
            + (f", not both {' and '.join(given_sources)}" if given_sources else "")
        )
    if upper_name or lower_name:
        if poisson is not None:
            raise ArgumentError(
                f"{{poisson}} must not be given together with {materials_text}, which define Poisson's ratios"
            )
        return _combine_materials(str(upper_name or lower_name), str(lower_name or upper_name))
    poisson_ratios = None if poisson is None else parse_numbers("poisson", poisson)
    if poisson_ratios is not None and (
        len(poisson_ratios) > 2 or not all(0 <= ratio <= 0.5 for ratio in poisson_ratios)
    ):
        raise ArgumentError("{poisson} must be one or two numbers from 0 to 0.5, got {got}", got=repr(poisson))
    if modulus is not None:
        if poisson_ratios is not None and len(poisson_ratios) > 1:
            raise ArgumentError(
                "{poisson} must be a single number (for the softer body) if {effective_modulus} is given, got {got}",
                got=repr(poisson),
            )
        modulus_value = float(parse_quantity("effective_modulus", modulus, "pressure"))
        if not modulus_value > 0:
            raise ArgumentError("{effective_modulus} must be above 0, got {got}", got=repr(modulus))
        return PairElasticity(modulus_value, poisson_ratio=None if poisson_ratios is None else poisson_ratios[0])
    moduli = [float(value) for value in parse_quantities("young", young, "pressure")]
    if len(moduli) > 2:
        raise ArgumentError("{young} must be one or two moduli, got {got}", got=repr(young))
    if poisson_ratios is None:
        raise ArgumentError(
            "{young} needs {poisson}: one value for both bodies, or the values of the upper and the lower body"
        )
    (upper_modulus, lower_modulus), (upper_ratio, lower_ratio) = (2 * moduli)[:2], (2 * poisson_ratios)[:2]
    return _combine_moduli(upper_modulus, upper_ratio, lower_modulus, lower_ratio)


def _combine_material_with_moduli(upper: str | None, lower: str | None, young: Any, poisson: Any) -> PairElasticity:
    moduli = [float(value) for value in parse_quantities("young", young, "pressure")]
    poisson_ratios = [] if poisson is None else parse_numbers("poisson", poisson)
    if len(moduli) != 1 or len(poisson_ratios) != 1 or not 0 <= poisson_ratios[0] <= 0.5:
        side, other_side = ("upper", "lower") if upper else ("lower", "upper")
        raise ArgumentError(
            f"{{{side}_material}} determines the elastic constants of the {side} body, so {{young}} and {{poisson}} "
            f'must be single values for the {other_side} body, as in "3 MPa" and "0.5"; or omit {{{side}_material}}'
        )
    name = "upper_material" if upper else "lower_material"
    known_material = _load_material(name, str(upper or lower))
    moduli_and_ratios = [
        (_round_to_three_digits(known_material.young_modulus), _round_to_three_digits(known_material.poisson_ratio)),
        (moduli[0], poisson_ratios[0]),
    ]
    (upper_modulus, upper_ratio), (lower_modulus, lower_ratio) = moduli_and_ratios if upper else moduli_and_ratios[::-1]
    is_softer = known_material.hardness is not None and known_material.young_modulus <= moduli[0]
    return replace(
        _combine_moduli(upper_modulus, upper_ratio, lower_modulus, lower_ratio),
        hardness=known_material.hardness if is_softer else None,
        source=f"{known_material.name}: E {moduli_and_ratios[0][0]:g} GPa, ν {moduli_and_ratios[0][1]:g}",
        hardness_source=f"hardness {_round_to_three_digits(known_material.hardness):g} GPa "
        f"({known_material.hardness.source})"
        if is_softer else "the other body's hardness is not known",
    )  # fmt: skip


def _combine_moduli(upper: float, upper_ratio: float, lower: float, lower_ratio: float) -> PairElasticity:
    modulus = float(effective_modulus(upper, upper_ratio, lower, lower_ratio))
    return PairElasticity(
        modulus, compliance_share=modulus * (1 - lower_ratio**2) / lower,
        poisson_ratio=upper_ratio if upper <= lower else lower_ratio, poisson_ratios=(upper_ratio, lower_ratio),
    )  # fmt: skip


def _combine_materials(upper: str, lower: str) -> PairElasticity:
    """Return the elastic constants of a pair of materials, and the hardness of the softer material.

    The hardness is None if the softer material does not yield.
    """
    upper_body, lower_body = _load_material("upper_material", upper), _load_material("lower_material", lower)
    modulus = _round_to_three_digits(effective_modulus(upper_body, lower_body))
    softer_material = softest_material(upper_body, lower_body) or min(
        (upper_body, lower_body), key=lambda body: body.young_modulus
    )
    hardness, hardness_source = softer_material.hardness, f"{softer_material.name} does not yield"
    if hardness is not None:
        range_text = "" if hardness.low == hardness.high else f", of {hardness.low:g} to {hardness.high:g} GPa"
        hardness_source = f"hardness {_round_to_three_digits(hardness):g} GPa{range_text} ({hardness.source})"
    return PairElasticity(
        modulus, compliance_share=_round_to_three_digits(compliance_fraction(upper_body, lower_body)),
        poisson_ratio=float(softer_material.poisson_ratio),
        hardness=hardness,
        source=f"{upper_body.name} on {lower_body.name}: E* {modulus:g} GPa", hardness_source=hardness_source,
        materials=(upper_body.name, lower_body.name),
        poisson_ratios=(
            _round_to_three_digits(upper_body.poisson_ratio), _round_to_three_digits(lower_body.poisson_ratio)
        ),
        alias_note=_format_alias_note(dict.fromkeys(((upper, upper_body.name), (lower, lower_body.name)))),
    )  # fmt: skip


def _format_alias_note(name_pairs: Iterable[tuple[str, str]]) -> str:
    """Return a note on material names that are aliases, as in '"100Cr6" is taken as bearing steel'."""
    aliases = [
        f'"{alternative}"{{}} as {name}'
        for alternative, name in name_pairs
        if not are_material_names_equal(alternative, name)
        or (alternative.isupper() and is_coating_formula(alternative))
    ]
    text = ", ".join(alias.format("" if index else " is taken") for index, alias in enumerate(aliases))
    return f"{text} (stiction materials lists others)" if len(aliases) == 1 else text


def _load_material(argument: str, name: str) -> Any:
    """Return the material that a user names in an argument, or raise an `ArgumentError` with advice.

    If the name looks like a file name, the error says which arguments are files.
    """
    try:
        return material(name)
    except ValueError as error:
        if (Path(name).suffix and not name.endswith(".")) or "/" in name:
            raise ArgumentError(
                f"{{{argument}}} must be the name of a material such as steel, got {{got}}; "
                "the first two arguments are the files",
                got=repr(name),
            ) from None
        raise ArgumentError(
            f"{{{argument}}} {{why}}; for another material, give {{young}}, {{poisson}} and {{hardness}} as numbers",
            why=str(error).removeprefix("name "),
        ) from None


def derive_elasticity(young: Sequence[float], poisson: Sequence[float], *, is_named: bool) -> PairElasticity:
    """Compute the elastic constants of a pair from Young's moduli (GPa) and Poisson's ratios of both bodies.

    If the materials are given by name, E* is rounded to three digits.
    """
    elasticity = _combine_moduli(young[0], poisson[0], young[1], poisson[1])
    if not is_named:
        return elasticity
    return replace(
        elasticity,
        effective_modulus=_round_to_three_digits(elasticity.effective_modulus),
        compliance_share=_round_to_three_digits(elasticity.compliance_share),
    )


def format_material_value(value: MaterialValue, unit: str = "", *, digits: int = NUM_MATERIAL_DIGITS) -> str:
    """Format a property of a material with its range for a study file, as in "0.625 GPa (0.23..1.7 GPa)"."""
    unit = f" {unit}" if unit else ""
    if value.low == value.high:
        return f"{value.low:g}{unit}"
    return f"{float(value):.{digits}g}{unit} ({value.low:g}..{value.high:g}{unit})"


def _round_to_three_digits(value: float) -> float:
    """Round a number to three significant digits, the accuracy of material data."""
    return float(f"{value:.3g}")
