"""Of what the bodies of a pair are: their elasticity and contact law, from the options that say it."""

from __future__ import annotations

from typing import Any

import typer

from stiction.cli.options import listed, numbers, quantity_of, refuse
from stiction.mechanics.closed_forms import effective_modulus as _effective_modulus
from stiction.mechanics.law import NAMED, JacksonGreen

HARDNESS = 2.84
"""Hardness over yield strength, of the law at small contact radii."""


def elasticity(
    context: typer.Context, modulus: str | None, young: str | None, poisson: str | None, law: str
) -> tuple[float, float | None]:
    """E* in GPa, and Poisson's ratio of the softer body if any is given."""
    if (modulus is None) == (young is None):
        raise ValueError("give --effective-modulus, or --young and --poisson" + (", not both" if young else ""))
    ratios = None if poisson is None else numbers("--poisson", poisson)
    if ratios is not None and (len(ratios) > 2 or not all(0 <= ratio <= 0.5 for ratio in ratios)):
        raise ValueError(f"--poisson must be one or two numbers from 0 to 0.5, got {poisson!r}")
    if modulus is not None:
        if law != JacksonGreen.name:
            refuse(context, "is for --young and --law jackson-green", "poisson")
        if ratios is not None and len(ratios) > 1:
            raise ValueError(f"--poisson beside --effective-modulus is of the softer body alone, got {poisson!r}")
        return quantity_of("--effective-modulus", modulus, "pressure"), None if ratios is None else ratios[0]
    moduli = [quantity_of("--young", part, "pressure") for part in listed(str(young))]
    if len(moduli) > 2:
        raise ValueError(f"--young must be one modulus or two, got {young!r}")
    if ratios is None:
        raise ValueError("--young needs --poisson, of both bodies or of one after the other")
    (first, second), (upper, lower) = (2 * moduli)[:2], (2 * ratios)[:2]
    return float(_effective_modulus(first, upper, second, lower)), upper if first <= second else lower


def law_of(
    context: typer.Context, law: str, yield_strength: str | None, hardness: str | None, ratio: float | None
) -> Any:
    """A contact law by its name and the options that it needs."""
    names = [*NAMED, JacksonGreen.name]
    if law not in names:
        raise ValueError(f"--law must be one of {', '.join(names)}, got {law!r}")
    if law != JacksonGreen.name:
        refuse(context, "is for --law jackson-green", "yield_strength", "hardness")
        return law
    if (yield_strength is None) == (hardness is None):
        raise ValueError("--law jackson-green needs --yield-strength or --hardness, one of them")
    if ratio is None:
        raise ValueError("--law jackson-green needs --poisson, of the softer body")
    strength = (
        quantity_of("--hardness", hardness, "pressure") / HARDNESS
        if hardness is not None
        else quantity_of("--yield-strength", str(yield_strength), "pressure")
    )
    return JacksonGreen(yield_strength=strength, poisson_ratio=ratio)


def compliance_share(modulus: float, young: str | None, poisson: str | None) -> float:
    """Of the lower body: half unless both are given."""
    if young is None or poisson is None:
        return 0.5
    stiffness, ratio = quantity_of("--young", listed(young)[-1], "pressure"), numbers("--poisson", poisson)[-1]
    return float(modulus * (1 - ratio**2) / stiffness)
