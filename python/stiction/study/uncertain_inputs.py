"""Uncertain inputs of a study, and the relative modulus that follows from them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING

from stiction._checks import Floats
from stiction.mechanics.materials import Material, material, softest_material
from stiction.study.input_distributions import UncertainInput, parse_study_input, parse_uncertain_input
from stiction.study.moduli import UncertainModulus, find_material_hardness, find_material_moduli
from stiction.study.study import Study
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    pass

_MODULUS_LABELS = {"young": "Young's modulus", "poisson": "Poisson's ratio"}


THREE_DIGIT_ROUNDING_ERROR = 0.006  # largest relative error of a number rounded to three digits


@dataclass(frozen=True)
class LabelledUncertainInput:
    """Uncertain input of a study, together with a label for messages and reports."""

    label: str
    estimate: UncertainInput


def find_uncertain_inputs(study: Study) -> dict[str, LabelledUncertainInput]:
    """Return the uncertain inputs of a study by name, or an empty dict for generated surfaces."""
    if not study.is_measured:
        return {}
    uncertainty_settings, contact = study.known, study.contact
    bodies = find_materials(study)
    inputs: dict[str, LabelledUncertainInput] = {}
    for name, label, kind in (("mu0", "μ0", ""), ("tau0", "τ0", "pressure")):
        if (text := getattr(uncertainty_settings, name)) is not None:
            inputs[name] = LabelledUncertainInput(label, parse_uncertain_input(name, text, kind))  # type: ignore[arg-type]
    moduli = find_moduli(study).inputs
    if "effective_modulus" in moduli:
        inputs["effective_modulus"] = LabelledUncertainInput("E*", moduli.pop("effective_modulus"))
    if contact.hardness is not None:
        softer_material = softest_material(*bodies)
        label = f"the hardness of the {softer_material.name}" if softer_material else "the hardness"
        if uncertainty_settings.hardness is not None:
            inputs["hardness"] = LabelledUncertainInput(
                label, parse_uncertain_input("hardness", uncertainty_settings.hardness, "hardness")
            )
        elif (
            softer_material
            and softer_material.hardness
            and abs(float(contact.hardness) / softer_material.hardness - 1) < THREE_DIGIT_ROUNDING_ERROR
        ):
            inputs["hardness"] = LabelledUncertainInput(label, find_material_hardness(softer_material.hardness))
    if (growth := find_junction_growth(study)) is not None:
        inputs["junction_growth"] = LabelledUncertainInput("the junction growth α", growth)
    for key, value in moduli.items():
        name, _, side = key.partition("_")
        label = f"{_MODULUS_LABELS[name]} of the {bodies[SIDES.index(side)].name if bodies else f'{side} body'}"
        inputs[key] = LabelledUncertainInput(label, value)
    return {name: entry for name, entry in inputs.items() if not entry.estimate.is_exact}


def find_junction_growth(study: Study) -> UncertainInput | None:
    """Return the junction growth α with its uncertainty, or None if there is no junction growth."""
    growth = study.contact.junction_growth
    return _parse_junction_growth(study.known.junction_growth or growth, growth) if growth else None


@lru_cache(maxsize=32)
def _parse_junction_growth(text: str | float, central_value: float) -> UncertainInput:
    """Parse the junction growth α and its range.

    The result is cached, because a report needs α for each coefficient.
    """
    return replace(parse_uncertain_input("junction_growth", text), value=central_value)


def find_creep_exponent(study: Study) -> UncertainInput | None:
    """Return the uncertain exponent of indentation creep, or None if the study has no dwell times."""
    return parse_uncertain_input("creep", study.known.creep) if study.friction.wait and study.known.creep else None


def find_yield_exponent(study: Study) -> UncertainInput | None:
    """Return the exponent of the yielding area with its uncertainty, or None if the study does not name it."""
    exponent = study.contact.yield_exponent
    return None if exponent is None else replace(exponent.estimate, value=float(exponent))


def find_moduli(study: Study) -> UncertainModulus:
    """Return the elastic moduli of a study, with their uncertainties."""
    uncertainty_settings, materials, central_modulus = (
        study.known,
        find_materials(study),
        float(study.contact.effective_modulus),
    )
    if uncertainty_settings.effective_modulus is not None:
        return UncertainModulus(
            central_modulus,
            parse_uncertain_input("effective_modulus", uncertainty_settings.effective_modulus, "modulus"),
        )
    if uncertainty_settings.young is not None and uncertainty_settings.poisson is not None:
        pairs = [
            (
                uncertainty_settings.young[i % len(uncertainty_settings.young)],
                uncertainty_settings.poisson[i % len(uncertainty_settings.poisson)],
            )
            for i in range(2)
        ]
        bodies = [
            {"young": parse_uncertain_input("young", e, "modulus"), "poisson": parse_study_input("poisson", nu)}
            for e, nu in pairs
        ]
        return UncertainModulus(central_modulus, bodies=tuple(bodies))
    bodies = [find_material_moduli(body) for body in materials]
    return UncertainModulus(
        central_modulus, bodies=tuple(bodies), is_one_material=bool(materials) and materials[0] == materials[1]
    )


def find_materials(study: Study) -> tuple[Material, ...]:
    """Return the materials of both bodies, or an empty tuple if a name is missing or unknown."""
    try:
        return tuple(material(name) for name in study.contact.materials or ())
    except ValueError:
        return ()


def compute_relative_modulus(study: Study, samples: Mapping[str, Floats]) -> Floats | float:
    """Compute E* from samples of the uncertain inputs, and divide it by the E* of the study."""
    return find_moduli(study).relative_modulus(samples)
