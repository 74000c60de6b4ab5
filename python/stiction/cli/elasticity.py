"""What both bodies are made of, from the options that say it: numbers, or materials by their names."""

from __future__ import annotations

from dataclasses import dataclass

from stiction.cli.options import listed, numbers, quantity_of
from stiction.mechanics.closed_forms import effective_modulus


@dataclass(frozen=True)
class Elasticity:
    """Elasticity of a pair, and what is known of its softer body."""

    effective_modulus: float  # GPa
    compliance_share: float = 0.5  # the lower body's fraction, one half unless both bodies are known
    poisson_ratio: float | None = None  # of the softer body
    hardness: float | None = None  # of the softer body, GPa
    source: str = ""  # where the numbers are from, if they are those of materials
    materials: tuple[str, str] | None = None  # what the upper and the lower body are made of
    poisson_ratios: tuple[float, float] | None = None  # of the upper and the lower body


def elasticity_of(
    modulus: str | None,
    young: str | None,
    poisson: str | None,
    upper: str | None = None,
    lower: str | None = None,
) -> Elasticity:
    """What `--effective-modulus`, or `--young` and `--poisson`, or `--upper` and `--lower` say, of which one is needed.

    Raises a `ValueError` if none or several of these are given, or a value is none.
    """
    ways = {"--effective-modulus": modulus, "--young": young, "--upper and --lower": upper or lower}
    chosen = [way for way, value in ways.items() if value is not None]
    if len(chosen) != 1:
        raise ValueError(
            "give --effective-modulus, or --young and --poisson, or --upper and --lower"
            + (f", not both {' and '.join(chosen)}" if chosen else "")
        )
    if upper or lower:
        if poisson is not None:
            raise ValueError("--poisson must not be given beside --upper and --lower, which say it")
        return _of_materials(str(upper or lower), str(lower or upper))
    ratios = None if poisson is None else numbers("--poisson", poisson)
    if ratios is not None and (len(ratios) > 2 or not all(0 <= ratio <= 0.5 for ratio in ratios)):
        raise ValueError(f"--poisson must be one or two numbers from 0 to 0.5, got {poisson!r}")
    if modulus is not None:
        if ratios is not None and len(ratios) > 1:
            raise ValueError(f"--poisson beside --effective-modulus is of the softer body alone, got {poisson!r}")
        return Elasticity(
            quantity_of("--effective-modulus", modulus, "pressure"), poisson_ratio=None if ratios is None else ratios[0]
        )
    moduli = [quantity_of("--young", part, "pressure") for part in listed(str(young))]
    if len(moduli) > 2:
        raise ValueError(f"--young must be one modulus or two, got {young!r}")
    if ratios is None:
        raise ValueError("--young needs --poisson, of both bodies or of one after the other")
    (of_upper, of_lower), (upper_ratio, lower_ratio) = (2 * moduli)[:2], (2 * ratios)[:2]
    return _of_two(of_upper, upper_ratio, of_lower, lower_ratio)


def _of_two(upper: float, upper_ratio: float, lower: float, lower_ratio: float) -> Elasticity:
    """Elasticity of two bodies with Young's moduli (GPa) and Poisson's ratios."""
    modulus = float(effective_modulus(upper, upper_ratio, lower, lower_ratio))
    return Elasticity(
        modulus,
        compliance_share=modulus * (1 - lower_ratio**2) / lower,
        poisson_ratio=upper_ratio if upper <= lower else lower_ratio,
        poisson_ratios=(upper_ratio, lower_ratio),
    )


def _of_materials(upper: str, lower: str) -> Elasticity:
    """Elasticity of two bodies by the names of their materials, and the hardness of the softer one, in three digits."""
    from stiction.mechanics.materials import compliance_fraction, material, softer_hardness

    above, below = material(upper), material(lower)
    softer, hardness = min((above, below), key=lambda body: body.hardness), softer_hardness(above, below)
    ends = "" if hardness.low == hardness.high else f", of {hardness.low:g} to {hardness.high:g} GPa"
    modulus, most = _rounded(effective_modulus(above, below)), _rounded(hardness)
    return Elasticity(
        modulus,
        compliance_share=_rounded(compliance_fraction(above, below)),
        poisson_ratio=float(softer.poisson_ratio),
        hardness=most,
        source=f"{above.name} on {below.name}: E* {modulus:g} GPa, hardness {most:g} GPa{ends} ({hardness.source}); "
        "--hardness says what was measured",
        materials=(above.name, below.name),
        poisson_ratios=(_rounded(above.poisson_ratio), _rounded(below.poisson_ratio)),
    )


def _rounded(value: float) -> float:
    """A number in three digits, of which more are not known of a material."""
    return float(f"{value:.3g}")
