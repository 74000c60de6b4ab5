"""Inputs of a study, such as hardness and mu0, each with central value, distribution, label and unit."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from types import MappingProxyType
from typing import Any

from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction._units import exact_quantity_text
from stiction.mechanics.friction import FrictionLaw
from stiction.mechanics.hardness import CENTRAL_SIZE_EFFECT_LENGTH, MAX_SIZE_EFFECT_LENGTH, MIN_SIZE_EFFECT_LENGTH
from stiction.mechanics.materials import Material, material, softest_material
from stiction.study.input_distributions import INPUT_KINDS, InputValue, UncertainInput, parse_input_value
from stiction.study.interfaces import InterfaceSettings, InterfaceStrength
from stiction.study.moduli import MODULUS_NAMES, UncertainModulus
from stiction.study.study import Study
from stiction.surfaces.pairing import SIDES

SAME_VALUE_TOLERANCE = 1e-3

_LABELS_BY_INPUT_NAME = {
    "mu0": "μ0", "tau0": "τ0", "effective_modulus": "E*", "hardness": "the hardness",
    "junction_growth": "the junction growth α", "yield_exponent": "the yield exponent m",
    "area_loss": "the area loss under shear", "size_effect": "the indentation size effect",
    "creep": "the creep exponent", "young": "Young's modulus", "poisson": "Poisson's ratio",
}  # fmt: skip

SIZE_EFFECT_LENGTH_INPUT = UncertainInput(
    CENTRAL_SIZE_EFFECT_LENGTH, MIN_SIZE_EFFECT_LENGTH, MAX_SIZE_EFFECT_LENGTH, "log-normal",
    f"{MIN_SIZE_EFFECT_LENGTH:g}..{MAX_SIZE_EFFECT_LENGTH:g} um",
)  # fmt: skip
"""Distribution of the characteristic length h* (µm) of the indentation size effect of metals."""

_SLIP_LINE_LABEL = "the ratio of hardness to shear strength"


@dataclass(frozen=True)
class StudyInput:
    """Input of a study, such as the hardness, with its label, unit, central value and distribution.

    Attributes
    ----------
    label : str
        Name for messages and reports, such as "the hardness of the brass".
    unit : str
        "GPa", "µm", or "" for a number.
    central : float
        Value that is used to compute contacts.
    estimate : UncertainInput
        Distribution of the input.
    text : str
        Entry of the study, such as "120 HV ± 10 %".
    """

    label: str
    unit: str
    central: float
    estimate: UncertainInput
    text: str


@dataclass(frozen=True)
class Inputs:
    """All inputs of a study, keyed by name: mu0, tau0, effective modulus, hardness, creep exponent and others.

    The names are "mu0", "tau0", "effective_modulus", "hardness", "junction_growth", "yield_exponent", "area_loss",
    "creep", "size_effect" if the depth of the indentation is given, and, if Young's moduli and Poisson's ratios are
    given, "young_upper", "poisson_upper", "young_lower" and "poisson_lower". Bodies of the same material share the
    inputs of the upper body.

    Attributes
    ----------
    entries : mapping of str to StudyInput
        All inputs that the study has.
    interface : InterfaceSettings or None
        Entry of the interface that defines mu0 and tau0 jointly.
    """

    entries: Mapping[str, StudyInput]
    interface: InterfaceSettings | None
    _modulus: UncertainModulus

    @classmethod
    def from_study(cls, study: Study) -> Inputs:
        """Return the inputs of a study.

        Studies with equal inputs share one object.
        """
        contact, friction = study.contact, study.friction
        values = {
            "mu0": friction.mu0[0], "tau0": friction.tau0[0], "effective_modulus": contact.effective_modulus,
            "hardness": contact.hardness, "junction_growth": contact.junction_growth or None,
            "yield_exponent": contact.yield_exponent, "area_loss": contact.area_loss or None,
            "creep": friction.creep if friction.wait else None,
        }  # fmt: skip
        entries = tuple(
            (name, value if isinstance(value, InputValue) else parse_input_value(name, value))
            for name, value in values.items()
            if value is not None
        )
        bodies = () if contact.young is None else (*zip(contact.young, contact.poisson or (), strict=True),)
        has_size_effect = contact.indent is not None
        return _build_inputs(entries, bodies, find_materials(study), friction.interface, has_size_effect)

    @classmethod
    def from_values(
        cls, values: Mapping[str, InputValue], bodies: tuple[tuple[InputValue, InputValue], ...] = (),
        materials: tuple[Material, ...] = (),
    ) -> Inputs:  # fmt: skip
        """Create inputs from given values instead of from a study.

        The values must include E*.

        `bodies` contains Young's modulus and Poisson's ratio of the upper and of the lower body, if they are given.
        """
        return _build_inputs(tuple(values.items()), bodies, materials, None, has_size_effect=False)

    @property
    def uncertain(self) -> Mapping[str, StudyInput]:
        """Inputs of the study that are not exact, keyed by name."""
        return {name: entry for name, entry in self.entries.items() if not entry.estimate.is_exact}

    def estimate(self, name: str) -> UncertainInput | None:
        """Return the distribution of an input, or None if the study has no such input."""
        entry = self.entries.get(name)
        return None if entry is None else entry.estimate

    @property
    def strength(self) -> InterfaceStrength | None:
        """Joint distribution of mu0 and tau0 from the study's interface, or None if the study has no interface.

        The value is also None if the interface file is missing or changed.
        """
        return None if self.interface is None else self.interface.load()

    def friction_law(self, mu0: Any, tau0: Any) -> FrictionLaw:
        """Return the friction law for given mu0 and tau0 (GPa).

        Junction growth or area loss have their central values in the study.
        """
        growth, area_loss = (self.entries.get(name) for name in ("junction_growth", "area_loss"))
        if growth is None:
            return FrictionLaw(mu0, tau0, area_loss=0.0 if area_loss is None else area_loss.central)
        return FrictionLaw(mu0, tau0, growth.central, growth.estimate.uses_slip_lines)

    def central(self, name: str) -> float:
        """Return the central value of an input, in core units (GPa, or µm for a length).

        Contacts are computed with this value.
        """
        return self.entries[name].central

    def quantile(self, name: str, probability: ArrayLike) -> Floats:
        """Return quantiles of an input at given probabilities, in core units (GPa, or µm for a length)."""
        return self.entries[name].estimate.quantile(probability)

    def relative_modulus(self, samples: Mapping[str, Floats]) -> Floats | float:
        """Return E* for samples of the inputs, divided by E* at the central values of the inputs."""
        return self._modulus.relative_modulus(samples)

    def replaced(self, **values: float) -> Inputs:
        """Return a copy of the inputs with changed central values, such as ``hardness=1.2`` (GPa).

        A value that differs from the value of the study has no uncertainty. If it is mu0 or tau0, the joint
        distribution of both no longer applies.
        """
        entries, interface = dict(self.entries), self.interface
        for name, value in values.items():
            entry = entries[name]
            if math.isclose(entry.central, value, rel_tol=SAME_VALUE_TOLERANCE):
                continue
            text = exact_quantity_text(value, entry.unit) if entry.unit else repr(float(value))
            estimate = UncertainInput(value, value, value, "exact", text)
            entries[name] = replace(entry, central=value, estimate=estimate, text=text)
            interface = None if name in ("mu0", "tau0") else interface
        return replace(self, entries=MappingProxyType(entries), interface=interface)


@lru_cache(maxsize=64)
def _build_inputs(
    values: tuple[tuple[str, InputValue], ...], bodies: tuple[tuple[InputValue, InputValue], ...],
    materials: tuple[Material, ...], interface: InterfaceSettings | None, has_size_effect: bool,
) -> Inputs:  # fmt: skip
    entries: dict[str, StudyInput] = {}
    for name, value in values:
        if name == "effective_modulus" and bodies:
            continue
        label = _build_hardness_label(value.estimate, materials) if name == "hardness" else _LABELS_BY_INPUT_NAME[name]
        label = _SLIP_LINE_LABEL if value.estimate.uses_slip_lines else label
        entries[name] = _build_input(name, label, value)
    if has_size_effect:
        entries["size_effect"] = StudyInput(
            _LABELS_BY_INPUT_NAME["size_effect"],
            "µm",
            SIZE_EFFECT_LENGTH_INPUT.value,
            SIZE_EFFECT_LENGTH_INPUT,
            SIZE_EFFECT_LENGTH_INPUT.text,
        )
    is_one_material = bool(materials) and materials[0] == materials[1]
    for index, side in enumerate(SIDES[: 1 if is_one_material else 2] if bodies else ()):
        for name, value in zip(MODULUS_NAMES, bodies[index], strict=True):
            body = materials[index].name if materials else f"{side} body"
            entries[f"{name}_{side}"] = _build_input(name, f"{_LABELS_BY_INPUT_NAME[name]} of the {body}", value)
    modulus_value = dict(values)["effective_modulus"]
    modulus = UncertainModulus(
        float(modulus_value),
        effective_modulus=None if bodies else modulus_value.estimate,
        bodies=tuple(dict(zip(MODULUS_NAMES, (value.estimate for value in body), strict=True)) for body in bodies),
        is_one_material=is_one_material,
    )
    return Inputs(MappingProxyType(entries), interface, modulus)


def _build_hardness_label(hardness: UncertainInput, materials: tuple[Material, ...]) -> str:
    """Return the label of the hardness, with a material's name if the hardness certainly belongs to this material."""
    label, softer_material = _LABELS_BY_INPUT_NAME["hardness"], softest_material(*materials)
    if softer_material is None:
        return label
    material_of_hardness = find_material_of_hardness(hardness, materials)
    return f"{label} of the {'softer body' if material_of_hardness is None else material_of_hardness.name}"


def find_material_of_hardness(hardness: UncertainInput, materials: tuple[Material, ...]) -> Material | None:
    """Return the material to which a given hardness certainly belongs, or None if the material is uncertain.

    A measured hardness may belong to the body that the table of materials lists as the harder one.
    """
    softer_material = softest_material(*materials)
    if softer_material is None or softer_material.hardness is None:
        return None
    return softer_material if has_hardness_of_table(hardness, softer_material) or len(set(materials)) == 1 else None


def has_hardness_of_table(hardness: UncertainInput, body: Material) -> bool:
    """Return whether a hardness has the same limits as the hardness of a material in the table of materials."""
    return body.hardness is not None and (hardness.low, hardness.high) == (body.hardness.low, body.hardness.high)


def _build_input(name: str, label: str, value: InputValue) -> StudyInput:
    return StudyInput(label, "GPa" if INPUT_KINDS[name] else "", float(value), value.estimate, value.text)


def find_materials(study: Study) -> tuple[Material, ...]:
    """Return the materials of both bodies of a study.

    Returns an empty tuple if a name is missing or unknown.
    """
    try:
        return tuple(material(name) for name in study.contact.materials or ())
    except ValueError:
        return ()


def find_interface(study: Study) -> InterfaceStrength | None:
    """Return the joint distribution of mu0 and tau0 from the study's interface, or None without an interface.

    The result is None if the study names no interface, or if the interface file is missing or changed.
    """
    return Inputs.from_study(study).strength
