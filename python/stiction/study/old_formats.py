"""Conversion of study files of earlier versions to the current format.

Earlier studies had the central values of uncertain inputs in `[contact]` and `[friction]`, and their ranges in a
section `[known]`. The ranges of materials were looked up by name.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from stiction._text import printable_path
from stiction._units import exact_quantity_text, short_repr
from stiction.mechanics.materials import Material, material, softest_material
from stiction.study.elasticity import NUM_ELASTIC_CONSTANT_DIGITS, derive_elasticity, format_material_value
from stiction.study.input_distributions import InputValue, parse_input_value
from stiction.study.interfaces import InterfaceSettings
from stiction.study.moduli import MODULUS_NAMES, UncertainModulus
from stiction.study.values import StudyError

MAX_MATERIAL_ROUNDING_ERROR = 0.006
"""Largest relative difference between a material's hardness and the rounded hardness in an old study file."""


def convert_old_study(data: Mapping[str, Any], source: str) -> Mapping[str, Any]:
    """Convert the sections of a study file to the current format, or return them unchanged if they are up to date.

    Raises a `StudyError` if the study contradicts itself.
    """
    names = ("surfaces", "contact", "friction", "known")
    surfaces, contact, friction, known = ({} if data.get(name) is None else data[name] for name in names)
    if not all(isinstance(section, Mapping) for section in (surfaces, contact, friction, known)):
        return data
    if "known" not in data and "poisson_ratio" not in contact:
        return data
    other_sections = {name: section for name, section in data.items() if name != "known"}
    # In old studies of generated surfaces, all inputs were exact.
    if surfaces.get("kind") != "measured":
        return other_sections
    try:
        new_sections = _convert_contact_section(dict(contact), known), _convert_friction_section(friction, known)
        return other_sections | dict(zip(("contact", "friction"), new_sections, strict=True))
    except _ContradictionError as error:
        raise StudyError(f"{printable_path(source)}: {error}") from None


class _ContradictionError(Exception):
    """Error raised if the central value of an input in an old study file lies outside the range of this input."""


def _convert_contact_section(contact: dict[str, Any], known: Mapping[str, Any]) -> dict[str, Any]:
    materials = _find_materials(contact)
    if contact.get("hardness") is not None:
        hardness = _parse_input_or_none("hardness", contact["hardness"])
        softer_material = softest_material(*materials)
        if known.get("hardness") is not None:
            contact["hardness"] = _merge_value_and_range("contact.hardness", contact["hardness"], known["hardness"])
        elif hardness is not None and softer_material is not None and softer_material.hardness is not None:
            value = softer_material.hardness
            is_rounded = math.isclose(hardness, value, rel_tol=MAX_MATERIAL_ROUNDING_ERROR)
            if is_rounded and value.low < value.high and value.low <= hardness <= value.high:
                contact["hardness"] = f"{hardness.text} ({value.low:g}..{value.high:g} GPa)"
    if contact.get("junction_growth") and known.get("junction_growth") is not None:
        contact["junction_growth"] = _merge_value_and_range(
            "contact.junction_growth", contact["junction_growth"], known["junction_growth"]
        )
    contact |= {} if "poisson_ratio" not in contact else {"poisson": contact.pop("poisson_ratio")}
    if known.get("effective_modulus") is not None:
        key = "contact.effective_modulus"
        contact["effective_modulus"] = _merge_value_and_range(
            key, contact.get("effective_modulus"), known["effective_modulus"]
        )
        return contact
    if known.get("young") is not None and known.get("poisson") is not None:
        return _replace_effective_modulus(contact, {name: known[name] for name in MODULUS_NAMES}, is_one_material=False)
    if not materials:
        return contact
    bodies = {
        "young": [
            format_material_value(body.young_modulus, "GPa", digits=NUM_ELASTIC_CONSTANT_DIGITS) for body in materials
        ],
        "poisson": [
            format_material_value(body.poisson_ratio, digits=NUM_ELASTIC_CONSTANT_DIGITS) for body in materials
        ],
    }
    return _replace_effective_modulus(contact, bodies, is_one_material=materials[0] == materials[1])


def _replace_effective_modulus(
    contact: dict[str, Any], bodies: Mapping[str, Any], *, is_one_material: bool
) -> dict[str, Any]:
    """Replace E* in an old study file by the file's Young's moduli and Poisson's ratios, if E* follows from them.

    If the moduli and ratios give another E*, the E* of the file is kept, with the range that follows from the ranges of
    the moduli.
    """
    modulus = _parse_input_or_none("effective_modulus", contact.get("effective_modulus", "10 GPa"))
    values = {
        name: [_parse_input_or_none(name, entry) for entry in (entries if isinstance(entries, list) else [entries])]
        for name, entries in bodies.items()
    }
    if modulus is None or any(entry is None for entries in values.values() for entry in entries):
        return contact | dict(bodies)
    pairs: dict[str, Any] = {
        name: (2 * entries)[:2] if len(entries) == 1 else entries for name, entries in values.items()
    }
    elasticity = derive_elasticity(*(pairs[name] for name in MODULUS_NAMES), is_named="materials" in contact)
    compliance_share = contact.get("compliance_share", elasticity.compliance_share)
    if math.isclose(elasticity.effective_modulus, modulus, rel_tol=1e-12) and math.isclose(
        elasticity.compliance_share, compliance_share, rel_tol=1e-12
    ):
        other_entries = {
            key: value for key, value in contact.items() if key not in ("effective_modulus", "compliance_share")
        }
        return other_entries | {name: [entry.text for entry in entries] for name, entries in pairs.items()}
    estimates = tuple({name: pairs[name][index].estimate for name in MODULUS_NAMES} for index in range(2))
    uncertain_modulus = UncertainModulus(float(modulus), bodies=estimates, is_one_material=is_one_material)
    half_widths = [
        np.ptp(np.log(uncertain_modulus.relative_modulus({name: estimate.quantile([0.025, 0.975])}))) / 2
        for name, estimate in uncertain_modulus.inputs.items()
    ]
    uncertainty_factor = math.exp(float(np.hypot.reduce([0.0, *half_widths])))
    low, high = (
        exact_quantity_text(float(f"{modulus * ratio:.4g}"), "GPa")
        for ratio in (1 / uncertainty_factor, uncertainty_factor)
    )
    return contact | ({} if low == high else {"effective_modulus": f"{modulus.text} ({low}..{high})"})


def _convert_friction_section(friction: Mapping[str, Any], known: Mapping[str, Any]) -> dict[str, Any]:
    converted_section = dict(friction)
    if known.get("creep") is not None:
        converted_section["creep"] = known["creep"]
    for name in ("mu0", "tau0"):
        if (text := known.get(name)) is None:
            continue
        values = friction.get(name, ["0 MPa"] if name == "tau0" else [])
        if not isinstance(values, list) or len(values) != 1:
            reason = f"must have one value, because known.{name} is {text!r}, got {short_repr(values)}"
            raise _ContradictionError(f"friction.{name}: {reason}")
        converted_section[name] = _merge_value_and_range(f"friction.{name}", values[0], text)
    if (source := known.get("interface")) is None:
        return converted_section
    strengths = [
        _parse_input_or_none(name, value[0] if isinstance(value, list) and value else value)
        for name, value in (("mu0", converted_section.get("mu0")), ("tau0", converted_section.get("tau0", "0 MPa")))
    ]
    try:
        interface_entry: Any = InterfaceSettings.from_source(str(source))
    except ValueError:
        interface_entry = None
    if interface_entry is not None and [float(interface_entry.mu0), float(interface_entry.tau0)] == strengths:
        interface_entry = str(source)
    else:
        # If the interface file is missing or has changed, the converted study itself contains mu0 and tau0.
        interface_entry = {"file": str(source)} | {
            name: None if value is None else value.text for name, value in zip(("mu0", "tau0"), strengths, strict=True)
        }
    return {key: value for key, value in converted_section.items() if key not in ("mu0", "tau0")} | {
        "interface": interface_entry
    }


def _find_materials(contact: Mapping[str, Any]) -> tuple[Material, ...]:
    try:
        return tuple(material(name) for name in contact.get("materials") or ())
    except (ValueError, TypeError):
        return ()


def _parse_input_or_none(name: str, entry: Any) -> InputValue | None:
    """Parse an input in an old study file, or return None if the input is invalid."""
    try:
        return parse_input_value(name, entry)
    except ValueError:
        return None


def _merge_value_and_range(key: str, central: Any, text: Any) -> Any:
    """Combine the central value and the range of an input in one text, such as "0.3 (0.2..0.4)".

    Raises a `_ContradictionError` if the central value is outside the range.
    """
    name = key.partition(".")[2]
    central_value, value = _parse_input_or_none(name, central), _parse_input_or_none(name, text)
    if central_value is None or value is None:
        return text if central_value is not None or central is None else central
    if math.isclose(central_value, value, rel_tol=1e-9):
        return text
    low, high = value.estimate.low, value.estimate.high
    if not low <= central_value <= high:
        raise _ContradictionError(f"{key}: must be within known.{name}, {value.text!r}, got {central_value.text!r}")
    return f"{central_value.text} ({value.text})"
