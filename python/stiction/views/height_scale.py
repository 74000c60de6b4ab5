"""Friction and true area over factors of the heights: as text for the terminal, and as a record."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction._number_format import percent, prefix, quoted, significant, with_unit
from stiction.mechanics.friction import STATUS_OK
from stiction.studies.height_scale import FOLDER, Scaled, stored_factors
from stiction.studies.point import (
    STATISTICS,
    by_rule,
    contact_status_of,
    has_nominal_area,
    is_unloaded,
    points,
    value_of,
)
from stiction.studies.result import Result
from stiction.views import rows
from stiction.views.point import RULES, load_text
from stiction.views.text import aligned, fitted

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

SCALED: dict[Scaled, str] = {"both": "both surfaces", "upper": "the upper surface", "lower": "the lower surface"}
CAVEAT = (
    "Only the heights change. A finish that also removes or adds wavelengths needs a scan of its own; a scale cannot "
    "describe it."
)


def scales_beside(result: Result) -> dict[Scaled, list[float]]:
    """Return the factors that are stored alongside a result, by the surfaces that are scaled, if there are any."""
    stored, study = result.stored, result.study
    if stored is None or not study.is_measured or not (stored.path / FOLDER).is_dir():
        return {}
    if stored.count < study.ensemble.repetitions:
        return {}
    found: dict[Scaled, list[float]] = {scaled: list(stored_factors(stored, scaled)) for scaled in SCALED}
    return {scaled: factors for scaled, factors in found.items() if len(factors) > 1}


def height_scale_text(at: xarray.Dataset, study: Study) -> str:
    """Return a table for each load, mu0 and tau0 of what `at_height_scale` gives: a row for each factor."""
    scaled = SCALED[at.attrs["scaled"]]
    lines = [
        fitted(
            f"Heights of {scaled} times a factor; 1 is the pair as measured. The gradient is the rms gradient of the "
            "gap. Intervals: 95 %, combined."
        )
    ]
    rules = [rule for rule in RULES if rule in np.atleast_1d(at["sliding"].values)]
    is_areal = study.is_areal
    has_rms = "upper_rms" in at
    for point in points(at):
        material = f"μ0 = {float(point['mu0']):g}, τ0 = {with_unit(float(point['tau0']), 'GPa')}"
        rms = ["Sq of both" if is_areal else "Pq of both"] if has_rms else []
        rubbing = {"all": "μ_s all contacts", "opposing": "μ_s opposing contacts"}
        has_fraction = has_nominal_area(point, study) and "contact_area_fraction" in point
        held = ["pull-off"] if "pull_off_pressure" in point else []
        area = "A/A0" if has_fraction else "A (µm²)"
        table = [["factor", "gradient", *rms, *(rubbing[rule] for rule in rules), area, *held]]
        table += [_row(point.isel(height_scale=place), rules, study) for place in range(point.sizes["height_scale"])]
        load = load_text(point.drop_vars("pull_off", errors="ignore"), study)
        lines += ["", fitted(f"At {load}, {material}:"), aligned(table)]
    lines += ["", fitted(CAVEAT)]
    return "\n".join(lines) + "\n"


def _row(one: xarray.Dataset, rules: list[str], study: Study) -> list[str]:
    """Return the cells of one factor."""
    cells = [f"{float(one['height_scale']):.4g}", significant(value_of(one, "rms_gradient"), 3)]
    if "upper_rms" in one:
        heights = [float(one[f"{side}_rms"]) for side in ("upper", "lower")]
        core, unit = prefix(max(heights), "um")
        cells.append(f"{', '.join(f'{each / core:.3g}' for each in heights)} {unit}")
    for rule in rules:
        known = by_rule(one["friction_combined"], rule)
        values = [float(known.sel(statistic=each)) for each in STATISTICS]
        cells.append("sticks" if is_unloaded(one) else quoted(*values))
    if not has_nominal_area(one, study) or "contact_area_fraction" not in one:
        cells.append(significant(value_of(one, "contact_area"), 3))
    elif (status := contact_status_of(one, study)) != STATUS_OK:
        cells.append(status)
    else:
        cells.append(percent(value_of(one, "contact_area_fraction")))
    return [*cells, with_unit(value_of(one, "pull_off_pressure"), "GPa")] if "pull_off_pressure" in one else cells


def height_scale_record(at: xarray.Dataset, study: Study) -> str:
    """Return what `at_height_scale` gives as a record of `stiction at`."""
    about = {"kind": "pair", "scaled": at.attrs["scaled"], "solved": at.attrs["solved"].tolist()}
    about |= {name: float(at[name]) for name in ("effective_modulus", "nominal_area") if name in at.coords}
    return rows.record("at", rows.values_of(rows.frame(at)), **about)
