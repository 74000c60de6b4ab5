"""Reading one point of what `at_load` gives: its numbers, and in words what it is a point of."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.half_space import ADHESION_RANGE, resolved_range
from stiction.studies.at_load import ABOVE_NOMINAL, COMPLETE, NO_LOAD
from stiction.views.digits import with_unit

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

RULES = {"all": "if all contacts rub", "opposing": "if only climbing contacts rub (the paper's rule)"}
"""The sliding rules in words. Of measured bodies the first comes first, because mu0 is measured on smooth faces."""


@dataclass(frozen=True)
class RuleValue:
    """Coefficient of static friction by one sliding rule."""

    rule: str  # "all" or "opposing"
    value: float  # mean over the directions of the result, and the 95 % interval of everything known
    lower: float
    upper: float
    positions: tuple[float, float] = (math.nan, math.nan)  # of the mean over positions alone
    next_test: tuple[float, float] = (math.nan, math.nan)  # between which one test lies, in one direction
    low: float = math.nan  # four of five single members lie between this and the next
    high: float = math.nan
    slopes: float = math.nan  # by the slopes of the gap alone (`gentle_friction`); NaN of generated bodies


def points(at: xarray.Dataset) -> Iterator[xarray.Dataset]:
    """Every cell, load, mu0 and tau0 of what `at_load` gives, one after the other."""
    cells = [name for name in CELLS if name in at.dims]
    dims = [*cells, *(name for name in ("load", "mu0", "tau0") if name in at.dims)]
    for place in np.ndindex(*(at.sizes[name] for name in dims)):
        yield at.isel(dict(zip(dims, place, strict=True)))


CELLS = ("fractal_dimension", "amplitude", "cut_off")  # dimensions of cells of any study
STATISTICS = ("mean", "lower", "upper")  # a mean and the ends of its 95 % interval


def shape_coordinate(study: Study, dimension: float) -> tuple[str, float]:
    """Return what the roughness exponent of a study is called and its value: H of self-affine surfaces, else D."""
    has_hurst = getattr(study.surfaces, "generator", "") == "self-affine"
    return ("H", round(2 - dimension, 12)) if has_hurst else ("D", dimension)


def by_rule(table: Any, rule: str) -> Any:
    """A table of results by one sliding rule, which may be the only one."""
    return table.sel(sliding=rule) if "sliding" in table.dims else table


def value_of(point: xarray.Dataset, name: str) -> float:
    """The mean of a quantity at a point, over directions too where it depends on them; NaN where there is none."""
    if name not in point.variables:
        return math.nan
    table = point[name]
    if "statistic" in table.dims:
        table = table.sel(statistic="mean")
    known = table.values[np.isfinite(table.values)]
    return float(known.mean()) if known.size else math.nan


def contact_status_of(point: xarray.Dataset, study: Study) -> str:
    """Return the status of the true area at a point: "ok", "complete", or "above-nominal" of asperities."""
    if "contact_status" in point:
        return str(point["contact_status"].values)
    above = value_of(point, "contact_area_fraction") > 1
    return (COMPLETE if study.by_half_space else ABOVE_NOMINAL) if above else STATUS_OK


def pressure_of(point: xarray.Dataset) -> float:
    """Mean pressure in contact (GPa)."""
    if "mean_pressure" in point:
        return value_of(point, "mean_pressure")
    area = value_of(point, "contact_area")
    load = value_of(point, "contact_load") if "contact_load" in point else float(point["load"])
    return load / area if area > 0 else math.nan


def rules_of(study: Study) -> list[str]:
    """The sliding rules of a study, the one to quote first."""
    order = list(RULES) if study.is_measured else list(reversed(RULES))
    return sorted(study.contact.rules(), key=order.index)


def has_nominal_area(point: xarray.Dataset, study: Study) -> bool:
    """Whether load over nominal area has a meaning, which it has not for spheres on a strip of arbitrary thickness."""
    if "nominal_area" not in point.coords:
        return False
    return study.is_areal or study.by_half_space or "cylinder" in law_of(study)


def law_of(study: Study) -> str:
    """The contact law of asperities, in whatever words; empty of a half-space."""
    return str(study.contact.law or "").lower()


def is_capped(study: Study) -> bool:
    """Whether pressures have a limit."""
    return study.contact.hardness is not None or "jackson" in law_of(study)


def modulus_of(point: xarray.Dataset, study: Study) -> float:
    """E* in GPa."""
    return float(point["effective_modulus"] if "effective_modulus" in point.coords else study.contact.effective_modulus)


def materials_text(study: Study) -> str:
    """What the bodies are made of, "mild steel on brass"; empty where their names are not known."""
    names = study.contact.materials
    return "" if names is None else " on ".join(names)


def range_of(point: xarray.Dataset, study: Study) -> tuple[float, float]:
    """The range of adhesion (µm) that was asked for, and that which the grid resolves, if that is longer."""
    contact: Any = study.contact
    asked = float(contact.adhesion_range or ADHESION_RANGE)
    step = float(np.max(point.attrs.get("spacing_um", 0.0)))
    return asked, max(asked, resolved_range(float(contact.work_of_adhesion), step, modulus_of(point, study)))


def adhesion_text(point: xarray.Dataset, study: Study) -> str:
    """The work of adhesion of a study and its range: "adhesion 50 mJ/m² over 0.5 nm"."""
    work = 1e6 * float(study.contact.work_of_adhesion or 0.0)
    return f"adhesion {work:.3g} mJ/m² over {with_unit(range_of(point, study)[1], 'um')}"


def is_unloaded(point: xarray.Dataset) -> bool:
    """Return whether the load of a point is negligible beside the pull-off force."""
    return "pull_off" in point and float(point["load"]) < NO_LOAD * value_of(point, "pull_off")


def load_text(point: xarray.Dataset, study: Study) -> str:
    """The load of a point, and over the nominal area: "10 mN (100 MPa)"."""
    load = float(point["load"])
    if is_unloaded(point):
        return "no load"
    if not has_nominal_area(point, study):
        return with_unit(load, "mN")
    return f"{with_unit(load, 'mN')} ({with_unit(load / float(point['nominal_area']), 'GPa')})"


def over_text(directions: Any) -> str:
    """What a mean over directions (degrees) is a mean over."""
    degrees = np.sort(np.asarray(directions, dtype=float) % 360)
    if degrees.size == 1:
        return f"the upper body moves {way_text(float(degrees[0]))}"
    gaps = np.diff(np.append(degrees, degrees[0] + 360))
    if np.allclose(gaps, 360 / degrees.size):
        if degrees.size == 2:
            axis = {0.0: "x", 90.0: "y"}.get(float(degrees[0]), f"{degrees[0]:g}°")
            return f"the mean over both senses of {axis}"
        return f"the mean over {degrees.size} directions all round"
    named = [f"{each:g}°" for each in degrees]
    return f"the mean over {', '.join(named[:-1])} and {named[-1]}"


def way_text(direction: float) -> str:
    """A direction in words: "to +x", "at 30°"."""
    axes = {0.0: "+x", 90.0: "+y", 180.0: "\N{MINUS SIGN}x", 270.0: "\N{MINUS SIGN}y"}
    return f"to {axes[direction]}" if direction in axes else f"at {direction:g}°"
