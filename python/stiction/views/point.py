"""Texts about one result point (one load, mu0 and tau0): sliding rule, materials, load and directions."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import choose_prefixed_unit, format_load, format_with_unit
from stiction.mechanics.friction import STATUS_BULK_SHEAR, STATUS_OK

if TYPE_CHECKING:
    from collections.abc import Callable

    from stiction.evaluate.point import SlidingRuleCoefficient
    from stiction.study.measured_bodies import ScanCutoffs
    from stiction.study.study import Study
    from stiction.summary.summary import PointSummary

SLIDING_RULE_DESCRIPTIONS = {"all": "friction at all contacts", "opposing": "friction at opposing contacts only"}
"""Phrases that describe the sliding rules in sentences."""

SLIDING_RULE_TITLES = {"all": "all contacts", "opposing": "opposing contacts"}
"""Short descriptions of the sliding rules, for column headings."""

COORDINATE_LABELS = {"fractal_dimension": "D", "hurst_exponent": "H", "mu0": "μ0", "tau0": "τ0", "cut_off": "cutoff"}
"""Printed labels of the coordinates of a result point. Other coordinates are printed with their names."""

_COORDINATE_UNITS = {"load": "mN", "tau0": "GPa", "amplitude": "um", "cut_off": "um"}


CONTRIBUTION_LABELS = {
    "mu0": "μ0", "adhesion": "τ0 on the area at the onset of sliding", "slopes": "slopes",
    "mu0_and_adhesion": "μ0 and τ0 on the area at the onset of sliding, not separated by the tests",
}  # fmt: skip
"""Labels of the contributions to a coefficient, by the names of `PointSummary.contribution_terms`."""


def sliding_rule_text(point: PointSummary, rule: str) -> str:
    """Return a phrase on a sliding rule, with a remark if mu0 and tau0 were not calibrated under this rule."""
    text = SLIDING_RULE_DESCRIPTIONS[rule]
    if point.calibrated_rule in (None, rule):
        return text
    return f"{text}, for which the interface was not calibrated"


def coordinate_text(name: str, value: float) -> str:
    """Return the value of a coordinate, such as tau0, as text with its unit, as in "50 MPa"."""
    return format_with_unit(value, _COORDINATE_UNITS[name]) if name in _COORDINATE_UNITS and value else f"{value:.4g}"


def point_coordinate_text(point: PointSummary, name: str) -> str:
    """Return one coordinate of a result point, such as the load, as text with its unit.

    For the cutoff, both bodies are named if their cutoffs differ.
    """
    if name == "cut_off" and point.cutoffs is not None:
        return cutoff_text(point.cutoffs)
    return coordinate_text(name, point.at[name])


def cutoff_text(cut_offs: ScanCutoffs, format_length: Callable[[float], str] | None = None) -> str:
    """Return the cutoffs of a pair as text: "2 µm", "2 µm (upper) and 5 µm (lower)" or "5 µm (lower only)".

    `cut_offs` contains the cutoffs (µm, 0 for no filter) of all scans of the upper and of the lower body. The scans of
    a body may have different cutoffs, as in "1 µm to 2 µm". Without a filter, the text is "none".
    """
    format_length = format_length or (lambda length: format_with_unit(length, "um"))
    body_texts = []
    for cutoff_lengths in cut_offs:
        ends = [format_length(length) if length else "none" for length in (min(cutoff_lengths), max(cutoff_lengths))]
        body_texts.append(" to ".join(dict.fromkeys(ends)))
    upper, lower = body_texts
    if upper == lower:
        return upper
    if "none" in body_texts:
        return f"{lower} (lower only)" if upper == "none" else f"{upper} (upper only)"
    return f"{upper} (upper) and {lower} (lower)"


def nominal_area_text(area: float) -> str:
    """Return a nominal area (µm²) as text with four digits and a suitable unit, as in "2304 mm²"."""
    factor, unit = choose_prefixed_unit(area, "um^2")
    return f"{area / factor:.4g} {unit}"


def material_names_text(study: Study) -> str:
    """Return the materials of a pair, as in "mild steel on brass".

    Returns "" if no material is given.
    """
    material_names = study.contact.materials
    return "" if material_names is None else " on ".join(material_names)


def point_load_text(point: PointSummary) -> str:
    """Return the load of a result point, together with its nominal pressure, as text.

    Returns "no load" if the load is negligible.
    """
    return "no load" if point.is_unloaded else format_load(point.at["load"], point.nominal_pressure)


def coefficient_text(point: PointSummary, coefficient: SlidingRuleCoefficient) -> str:
    """Return the coefficient at a result point as text with its interval, or the reason why there is none.

    The text starts with "≥" if the coefficient is only a lower limit.
    """
    if math.isfinite(coefficient.value):
        return f"≥ {coefficient}" if coefficient.status == STATUS_BULK_SHEAR else str(coefficient)
    return "none" if point.status == STATUS_OK else point.status


def averaged_directions_text(directions: Any) -> str:
    """Return a phrase for the directions of motion (degrees) over which a coefficient is averaged."""
    degrees = np.sort(np.asarray(directions, dtype=float) % 360)
    if degrees.size == 1:
        return f"the upper body moves {motion_direction_text(float(degrees[0]))}"
    angular_gaps = np.diff(np.append(degrees, degrees[0] + 360))
    if np.allclose(angular_gaps, 360 / degrees.size):
        if degrees.size == 2:
            axis = {0.0: "x", 90.0: "y"}.get(float(degrees[0]), f"{degrees[0]:g}°")
            return f"the mean over both directions along {axis}"
        return f"the mean over {degrees.size} directions all round"
    direction_texts = [f"{angle:g}°" for angle in degrees]
    return f"the mean over {', '.join(direction_texts[:-1])} and {direction_texts[-1]}"


def motion_direction_text(direction: float) -> str:
    """Return a phrase for a direction of motion (degrees), as in "to +x" or "at 30°"."""
    axis_names = {0.0: "+x", 90.0: "+y", 180.0: "\N{MINUS SIGN}x", 270.0: "\N{MINUS SIGN}y"}
    return f"to {axis_names[direction]}" if direction in axis_names else f"at {direction:g}°"
