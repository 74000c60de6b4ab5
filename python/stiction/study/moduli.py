"""Effective modulus E* with its uncertainty, entered directly or computed from the elastic constants of both bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from stiction._arguments import split_values
from stiction._checks import Floats
from stiction._errors import ArgumentError
from stiction.mechanics.materials import MAX_RUBBER_MODULUS, Material, MaterialValue, material
from stiction.study.elasticity import PairElasticity, determine_elasticity
from stiction.study.input_distributions import (
    MAX_POISSON_RATIO,
    UNCERTAINTY_PATTERN,
    InputDistribution,
    UncertainInput,
    parse_study_input,
)
from stiction.surfaces.pairing import SIDES

MODULUS_NAMES = ("young", "poisson")

DEFAULT_YIELD_EXPONENT = "uniform 0.7 .. 1.6"
ELASTOMER_AREA_LOSS = "0..0.3"
"""Default range of the fraction of the true area that elastomers lose under shear before they slide.

docs/howto/elastomers.md lists published cases.
"""


def find_default_area_loss(effective_modulus: float) -> str | None:
    """Return the default range of the fraction of the true contact area that rubber loses under shear.

    The range is a text, as in study files.

    Returns None if E* (GPa) is too large for rubber.
    """
    return ELASTOMER_AREA_LOSS if effective_modulus < MAX_RUBBER_MODULUS else None


@dataclass(frozen=True)
class UncertainModulus:
    """Effective modulus E* with its uncertainty, entered directly or as the elastic constants of both bodies.

    Attributes
    ----------
    central_modulus : float, GPa
        E* at the central values of the inputs.
    effective_modulus : UncertainInput or None
        E* (GPa), if E* is given directly.
    bodies : tuple of mapping of str to UncertainInput
        "young" (GPa) and "poisson" of the upper and of the lower body, if given instead of E*.
    is_one_material : bool
        True if both bodies are the same material, so that one sample of the moduli applies to both.
    """

    central_modulus: float
    effective_modulus: UncertainInput | None = None
    bodies: tuple[Mapping[str, UncertainInput], ...] = ()
    is_one_material: bool = False

    @property
    def all_inputs(self) -> dict[str, UncertainInput]:
        """Elastic constants that the user gives, exact or uncertain, keyed by name, such as "young_upper"."""
        sides = SIDES[:1] if self.is_one_material else SIDES
        inputs = {
            f"{name}_{side}": body[name]
            for side, body in zip(sides, self.bodies, strict=False)
            for name in MODULUS_NAMES
        }
        if self.effective_modulus is not None:
            inputs["effective_modulus"] = self.effective_modulus
        return inputs

    @property
    def inputs(self) -> dict[str, UncertainInput]:
        """Uncertain elastic constants, keyed by names such as "effective_modulus" or "young_upper"."""
        return {name: value for name, value in self.all_inputs.items() if not value.is_exact}

    def relative_modulus(self, samples: Mapping[str, Floats]) -> Floats | float:
        """Return E* for random samples of the elastic constants, as a ratio to E* for the central values."""
        if "effective_modulus" in samples:
            return samples["effective_modulus"] / self.central_modulus
        sides = [SIDES[0]] * 2 if self.is_one_material else SIDES
        central_compliances = [_compute_compliance(body["young"].value, body["poisson"].value) for body in self.bodies]
        sampled_compliances = [
            _compute_compliance(*(samples.get(f"{name}_{side}", body[name].value) for name in MODULUS_NAMES))
            for side, body in zip(sides, self.bodies, strict=False)
        ]
        return sum(central_compliances) / sum(sampled_compliances) if self.bodies else 1.0


def _compute_compliance(young: Any, poisson: Any) -> Any:
    return (1 - poisson**2) / young


def find_material_moduli(body: Material) -> dict[str, UncertainInput]:
    """Return distributions of Young's modulus (GPa) and Poisson's ratio of a material, from their published ranges."""
    poisson = replace(_build_input_from_range(body.poisson_ratio, "normal"), maximum=MAX_POISSON_RATIO)
    return {"young": _build_input_from_range(body.young_modulus, "log-normal"), "poisson": poisson}


def _build_input_from_range(value: MaterialValue, distribution: InputDistribution) -> UncertainInput:
    low, high = float(value.low), float(value.high)
    return UncertainInput(float(value), low, high, distribution if low < high else "exact", f"{low:g}..{high:g}")


def parse_elasticity(
    effective_modulus: Any = None, young: Any = None, poisson: Any = None, upper_material: str | None = None,
    lower_material: str | None = None,
) -> tuple[PairElasticity, UncertainModulus]:  # fmt: skip
    """Parse a pair's elastic constants; return their central values, and E* with its uncertainty.

    The arguments have the meanings of `determine_elasticity`, but may be ranges or have an uncertainty. Raises a
    `ValueError` if arguments are missing, contradictory or invalid.
    """
    arguments = {"effective_modulus": effective_modulus, "young": young, "poisson": poisson}
    inputs = {name: _parse_inputs(name, value) for name, value in arguments.items() if value is not None}
    central_values = {
        name: [item.value for item in values]
        if any(UNCERTAINTY_PATTERN.search(item.text) for item in values)
        else arguments[name]
        for name, values in inputs.items()
    }
    elasticity_arguments = {
        name: values[0] if isinstance(values, list) and len(values) == 1 else values
        for name, values in central_values.items()
    }
    elasticity = determine_elasticity(
        **elasticity_arguments, upper_material=upper_material, lower_material=lower_material
    )
    central_modulus = elasticity.effective_modulus
    if "effective_modulus" in inputs:
        return elasticity, UncertainModulus(central_modulus, inputs["effective_modulus"][0])
    if "young" in inputs:
        pairs_of_moduli = zip((2 * inputs["young"])[:2], (2 * inputs["poisson"])[:2], strict=True)
        bodies = [{"young": e, "poisson": nu} for e, nu in pairs_of_moduli]
        if upper_material or lower_material:
            bodies[0 if upper_material else 1] = find_material_moduli(material(str(upper_material or lower_material)))
        return elasticity, UncertainModulus(central_modulus, bodies=tuple(bodies))
    materials = [material(str(name)) for name in (upper_material or lower_material, lower_material or upper_material)]
    bodies = [find_material_moduli(body) for body in materials]
    is_one_material = materials[0] == materials[1]
    return elasticity, UncertainModulus(central_modulus, bodies=tuple(bodies), is_one_material=is_one_material)


def _parse_inputs(name: str, value: Any) -> list[UncertainInput]:
    values = [value] if name == "effective_modulus" else split_values(value)
    if not values:
        raise ArgumentError(f"{{{name}}} must have at least one value, got {{got}}", got=repr(value))
    try:
        return [parse_study_input(name, item) for item in values]
    except ValueError as error:
        raise ArgumentError.for_argument(name, str(error).strip()) from None
