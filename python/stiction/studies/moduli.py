"""What is known of the moduli of a pair: E* itself, or Young's moduli and Poisson's ratios of both bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from stiction._arguments import split_values
from stiction._checks import Floats
from stiction._errors import ArgumentError
from stiction.mechanics.materials import Material, MaterialValue, material
from stiction.studies.elasticity import Elasticity, elasticity_of
from stiction.studies.input_uncertainty import (
    MAX_POISSON,
    UNCERTAIN_TEXT,
    Distribution,
    UncertainInput,
    parse_study_input,
)
from stiction.surfaces.pairing import SIDES

NAMES = ("young", "poisson")


@dataclass(frozen=True)
class Moduli:
    """What is known of E*.

    Attributes
    ----------
    middle : float, GPa
        E* at the middle of what is known.
    effective_modulus : UncertainInput or None
        E*, GPa, where it is known itself.
    bodies : tuple of mapping of str to UncertainInput
        Otherwise "young" (GPa) and "poisson" of the upper and the lower body, if they are known.
    is_one_material : bool
        Whether both bodies are one material, whose moduli are drawn once.
    """

    middle: float
    effective_modulus: UncertainInput | None = None
    bodies: tuple[Mapping[str, UncertainInput], ...] = ()
    is_one_material: bool = False

    @property
    def inputs(self) -> dict[str, UncertainInput]:
        """What is not known exactly, by names such as "young_upper"."""
        sides = SIDES[:1] if self.is_one_material else SIDES
        found = {f"{name}_{side}": body[name] for side, body in zip(sides, self.bodies, strict=False) for name in NAMES}
        if self.effective_modulus is not None:
            found["effective_modulus"] = self.effective_modulus
        return {name: each for name, each in found.items() if not each.is_exact}

    def relative(self, drawn: Mapping[str, Floats]) -> Floats | float:
        """E* over that at the middle, of values by the names of `inputs`."""
        if "effective_modulus" in drawn:
            return drawn["effective_modulus"] / self.middle
        sides = [SIDES[0]] * 2 if self.is_one_material else SIDES
        middle = [_compliance(body["young"].value, body["poisson"].value) for body in self.bodies]
        now = [
            _compliance(*(drawn.get(f"{name}_{side}", body[name].value) for name in NAMES))
            for side, body in zip(sides, self.bodies, strict=False)
        ]
        return sum(middle) / sum(now) if self.bodies else 1.0


def _compliance(young: Any, poisson: Any) -> Any:
    return (1 - poisson**2) / young


def moduli_of_material(body: Material) -> dict[str, UncertainInput]:
    """Young's modulus (GPa) and Poisson's ratio of a material as the ranges of their source."""
    poisson = replace(_of_source(body.poisson_ratio, "normal"), maximum=MAX_POISSON)
    return {"young": _of_source(body.young_modulus, "log-normal"), "poisson": poisson}


def _of_source(value: MaterialValue, distribution: Distribution) -> UncertainInput:
    low, high = float(value.low), float(value.high)
    return UncertainInput(float(value), low, high, distribution if low < high else "exact", f"{low:g}..{high:g}")


def hardness_of_material(value: MaterialValue) -> UncertainInput:
    """Hardness (GPa) of a material as the range of its source."""
    return _of_source(value, "log-normal")


def elasticity_and_moduli(
    effective_modulus: Any = None, young: Any = None, poisson: Any = None, upper_material: str | None = None,
    lower_material: str | None = None,
) -> tuple[Elasticity, Moduli]:  # fmt: skip
    """Return what both bodies are made of at the middle of what is known, and what is known of it.

    Arguments are those of `elasticity_of`; numbers may be ranges or have an uncertainty. Raises a `ValueError` if it is
    too much or too little, or a value is none.
    """
    asked = {"effective_modulus": effective_modulus, "young": young, "poisson": poisson}
    found = {name: _known(name, value) for name, value in asked.items() if value is not None}
    middle = {
        name: [each.value for each in values]
        if any(UNCERTAIN_TEXT.search(each.text) for each in values)
        else asked[name]
        for name, values in found.items()
    }
    one = {
        name: values[0] if isinstance(values, list) and len(values) == 1 else values for name, values in middle.items()
    }
    elasticity = elasticity_of(**one, upper_material=upper_material, lower_material=lower_material)
    value = elasticity.effective_modulus
    if "effective_modulus" in found:
        return elasticity, Moduli(value, found["effective_modulus"][0])
    if "young" in found:
        pairs = zip((2 * found["young"])[:2], (2 * found["poisson"])[:2], strict=True)
        bodies = [{"young": e, "poisson": nu} for e, nu in pairs]
        if upper_material or lower_material:
            bodies[0 if upper_material else 1] = moduli_of_material(material(str(upper_material or lower_material)))
        return elasticity, Moduli(value, bodies=tuple(bodies))
    materials = [material(str(name)) for name in (upper_material or lower_material, lower_material or upper_material)]
    bodies = [moduli_of_material(each) for each in materials]
    is_one_material = materials[0] == materials[1]
    return elasticity, Moduli(value, bodies=tuple(bodies), is_one_material=is_one_material)


def _known(name: str, value: Any) -> list[UncertainInput]:
    several = [value] if name == "effective_modulus" else split_values(value)
    if not several:
        raise ArgumentError(f"{{{name}}} must have at least one value, got {{got}}", got=repr(value))
    try:
        return [parse_study_input(name, each) for each in several]
    except ValueError as error:
        raise ArgumentError(f"{{{name}}} {{why}}", why=str(error).strip()) from None
