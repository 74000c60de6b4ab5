"""Quantities of a result at one point: a combination of load, mu0, tau0, and roughness (or cutoff)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import KW_ONLY, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._estimate import Estimate, Interval
from stiction.evaluate.member_means import AREA_ABOVE_NOMINAL_STATUS, FULL_CONTACT_STATUS
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.half_space import DEFAULT_ADHESION_RANGE
from stiction.mechanics.half_space_problem import min_resolved_adhesion_range
from stiction.mechanics.quantities import QUANTITIES, find_interval_kind
from stiction.study.inputs import Inputs

if TYPE_CHECKING:
    import xarray

    from stiction.study.study import Study


UNKNOWN_INTERVAL = Interval(math.nan, math.nan)
NEGLIGIBLE_LOAD_RATIO = 0.01
"""Ratio of load to pull-off force below which the load is negligible, so that a coefficient has no meaning."""


@dataclass(frozen=True)
class SlidingRuleCoefficient(Estimate):
    """Friction coefficient under one sliding rule, averaged over directions of motion, with its intervals.

    If there is no combined interval, the limits are the interval of the mean.
    """

    _: KW_ONLY
    rule: str  # "all" or "opposing"
    # Status of the coefficient: "ok", or the status of a direction of motion without a friction coefficient.
    status: str = STATUS_OK
    interval_of_mean: Interval = UNKNOWN_INTERVAL
    prediction_interval: Interval = UNKNOWN_INTERVAL
    # 10 % and 90 % quantiles of the friction coefficients of single members.
    low: float = math.nan
    high: float = math.nan
    # Small-slope estimate of the coefficient (`gentle_friction`), or NaN for generated bodies.
    slopes: float = math.nan
    is_outside_asperity_model: bool = False
    # Friction coefficients averaged over both directions along an axis, keyed by the angle of the axis (degrees).
    by_axis: Mapping[float, Estimate] = field(default_factory=dict, repr=False)
    # Mean friction coefficient and the interval of this mean, keyed by the direction of motion (degrees).
    by_direction: Mapping[float, Estimate] = field(default_factory=dict, repr=False)

    @property
    def mean(self) -> Estimate:
        """Mean friction coefficient as an `Estimate`, whose limits are the interval of the mean."""
        return Estimate(self.value, *self.interval_of_mean, **_get_estimate_fields("mean_friction", {}))

    @property
    def prediction(self) -> Estimate:
        """Mean friction coefficient as an `Estimate`, whose limits are the prediction interval of a single test."""
        return Estimate(self.value, *self.prediction_interval, **_get_estimate_fields("friction_prediction", {}))


def iterate_points(at: xarray.Dataset) -> Iterator[xarray.Dataset]:
    """Yield one dataset for each combination of roughness (or cutoff), load, mu0 and tau0 in a dataset."""
    cell_dims = [name for name in CELL_DIMENSIONS if name in at.dims]
    dims = [*cell_dims, *(name for name in ("load", "mu0", "tau0") if name in at.dims)]
    # Dropping the indexes of the coordinates more than halves the time of each selection below.
    at = at.drop_indexes([name for name in dims if name in at.xindexes])
    for indices in np.ndindex(*(at.sizes[name] for name in dims)):
        yield at.isel(dict(zip(dims, indices, strict=True)))


def read_number(point: xarray.Dataset, name: str) -> float:
    """Read a quantity without an interval, such as the load (mN), from a dataset for one load, mu0 and tau0."""
    # Reading `point.variables[name]` is much faster than reading `point[name]`, an `xarray.DataArray`.
    return float(point.variables[name].values)


SLIDING_RULE_ORDER = ("all", "opposing")
"""Sliding rules in the order of output, if measured bodies have no interface.

The first rule is reported. It lets friction act at all contacts, because mu0 is measured on smooth faces.
"""

CELL_DIMENSIONS = ("fractal_dimension", "amplitude", "cut_off")
MEAN_AND_LIMITS = ("mean", "lower", "upper")


def get_roughness_exponent(study: Study, dimension: float) -> tuple[str, float]:
    """Return symbol and value of the roughness exponent: H for self-affine surfaces, D for all other surfaces."""
    has_hurst = getattr(study.surfaces, "generator", "") == "self-affine"
    return ("H", round(2 - dimension, 12)) if has_hurst else ("D", dimension)


def select_sliding_rule(table: Any, rule: str) -> Any:
    """Return the values in an array that belong to one sliding rule.

    An array without the dimension `sliding` is returned unchanged.
    """
    return table.sel(sliding=rule) if "sliding" in table.dims else table


def find_statistic_indices(table: xarray.Dataset | xarray.DataArray) -> list[int]:
    """Return the indices of mean, lower and upper limit along the dimension `statistic`."""
    statistics = table.coords.variables["statistic"].values.tolist()
    return [statistics.index(name) for name in MEAN_AND_LIMITS]


def read_estimate(table: xarray.DataArray) -> Estimate:
    """Convert an array with a value, a lower limit and an upper limit to an `Estimate`.

    All other dimensions must have size 1.
    """
    fields = _get_estimate_fields(table.name, table.attrs)
    if "statistic" not in table.dims:
        return Estimate(table.item(), **fields | {"kind": ""})
    return Estimate(*table.values.ravel()[find_statistic_indices(table)].astype(float).tolist(), **fields)


def _get_estimate_fields(name: Any, attributes: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the name, the unit and the interval kind of an estimate, from the name and attributes of its variable."""
    return {
        "name": str(name), "unit": QUANTITIES[str(name)].unit, "kind": find_interval_kind(str(name), attributes),
    }  # fmt: skip


def read_estimates_along(table: xarray.DataArray, dimension: str) -> dict[float, Estimate]:
    """Return the estimates along one dimension of an array, keyed by the coordinate along this dimension."""
    rows = table.variable.transpose(dimension, "statistic").values[:, find_statistic_indices(table)].astype(float)
    fields = _get_estimate_fields(table.name, table.attrs)
    return {
        coordinate: Estimate(*row, **fields)
        for coordinate, row in zip(table[dimension].values.tolist(), rows.tolist(), strict=True)
    }


@dataclass(frozen=True)
class PointQuantities:
    """Quantities at one load, mu0 and tau0 under one sliding rule, each kind of quantity in a dict keyed by name.

    If there are several directions, quantities that depend on the direction are not included.
    """

    estimates: dict[str, Estimate]
    numbers: dict[str, float]
    distributions: dict[str, dict[float, Estimate]]


def read_point_quantities(point: xarray.Dataset, rule: str) -> PointQuantities:
    """Return all quantities without a direction, at one load, mu0 and tau0, under one sliding rule.

    Selections from an `xarray.Variable` are much faster than selections from an `xarray.DataArray`.
    """
    statistics = find_statistic_indices(point)
    rule_index = point.variables["sliding"].values.tolist().index(rule) if "sliding" in point.dims else 0
    quantities = PointQuantities({}, {}, {})
    for name in map(str, point.data_vars):
        variable = point.variables[name]
        indices = {"sliding": rule_index} if "sliding" in variable.dims else {}
        if variable.sizes.get("direction") == 1:
            indices["direction"] = 0
        variable = variable.isel(indices) if indices else variable
        if variable.dims == ("statistic",):
            limits = variable.values[statistics].astype(float).tolist()
            quantities.estimates[name] = Estimate(*limits, **_get_estimate_fields(name, variable.attrs))
        elif not variable.dims and variable.dtype.kind in "if":
            quantities.numbers[name] = float(variable.values)
        elif set(variable.dims) == {"fraction_below", "statistic"}:
            quantities.distributions[name] = read_estimates_along(
                select_sliding_rule(point[name], rule), "fraction_below"
            )
    return quantities


def mean_over_directions(point: xarray.Dataset, name: str) -> float:
    """Return a quantity at one load, mu0 and tau0, averaged over all directions of motion.

    Returns NaN if the quantity is missing.
    """
    if name not in point.variables:
        return math.nan
    variable = point.variables[name]
    values = variable.values
    if "statistic" in variable.dims:
        mean_index = point.variables["statistic"].values.tolist().index("mean")
        values = values.take(mean_index, axis=variable.dims.index("statistic"))
    finite_values = values[np.isfinite(values)]
    return float(finite_values.mean()) if finite_values.size else math.nan


def find_contact_status(point: xarray.Dataset, study: Study) -> str:
    """Return the contact area status: "ok", "complete" (half-space model) or "above-nominal" (asperity model)."""
    if "contact_status" in point:
        return str(point["contact_status"].values)
    is_above_nominal = mean_over_directions(point, "contact_area_fraction") > 1
    return (
        (FULL_CONTACT_STATUS if study.uses_half_space else AREA_ABOVE_NOMINAL_STATUS) if is_above_nominal else STATUS_OK
    )


def mean_contact_pressure(point: xarray.Dataset) -> float:
    """Return the mean contact pressure (GPa) at one load, mu0 and tau0."""
    return mean_over_directions(point, "mean_pressure")


def list_rules_with_reported_first(study: Study) -> list[str]:
    """Return the sliding rules of a study, starting with the rule that results report by default.

    With an interface, the reported rule is the rule under which mu0 and tau0 were fitted. For generated bodies, the
    reported rule is the first rule of the study.
    """
    rules = SLIDING_RULE_ORDER if study.is_measured else study.contact.sliding_rules()
    fitted_rule = None if study.friction.interface is None else study.friction.interface.fitted_rule
    return sorted(study.contact.sliding_rules(), key=lambda rule: (rule != fitted_rule, rules.index(rule)))


def sort_sliding_rules(table: Any, study: Study) -> Any:
    """Sort the sliding rules in a dataset of measured bodies. The rule that results report by default comes first.

    Other tables are returned unchanged.
    """
    rules = list_rules_with_reported_first(study)
    is_sorted = not study.is_measured or "sliding" not in table.dims or table["sliding"].values.tolist() == rules
    return table if is_sorted else table.sel(sliding=rules)


def has_nominal_area(point: xarray.Dataset, study: Study) -> bool:
    """Return whether the contact model of two bodies defines their nominal area."""
    return "nominal_area" in point.coords and study.has_nominal_area


def nominal_pressure_at(point: xarray.Dataset, study: Study) -> float:
    """Return the nominal pressure (GPa), which is the load divided by the nominal area.

    Returns NaN if the contact model has no nominal area.
    """
    return (
        read_number(point, "load") / read_number(point, "nominal_area") if has_nominal_area(point, study) else math.nan
    )


def get_contact_law_name(study: Study) -> str:
    """Return the name of the contact law in lower case, or "" for the half-space model, which has no contact law."""
    return str(study.contact.law or "").lower()


def has_limited_pressure(study: Study) -> bool:
    """Return whether a hardness or a yield strength limits the contact pressure."""
    return study.contact.hardness is not None or "jackson" in get_contact_law_name(study)


def effective_modulus_at(point: xarray.Dataset, study: Study) -> float:
    """Return the effective modulus E* (GPa) of the two bodies in a result."""
    has_modulus = "effective_modulus" in point.coords
    return read_number(point, "effective_modulus") if has_modulus else float(study.contact.effective_modulus)


def get_adhesion_ranges(point: xarray.Dataset, study: Study) -> tuple[float, float]:
    """Return two ranges (µm) of the attraction: the range given in the study, and the range used in the computation.

    The range of the computation is larger if the grid does not resolve the range of the study.
    """
    contact: Any = study.contact
    given_range = float(contact.adhesion_range or DEFAULT_ADHESION_RANGE)
    grid_spacing = float(np.max(point.attrs.get("spacing_um", 0.0)))
    return given_range, max(
        given_range,
        min_resolved_adhesion_range(float(contact.work_of_adhesion), grid_spacing, effective_modulus_at(point, study)),
    )


def is_unloaded(point: xarray.Dataset) -> bool:
    """Return whether the load of `point` is negligible compared with the pull-off force."""
    return "pull_off" in point and read_number(point, "load") < NEGLIGIBLE_LOAD_RATIO * mean_over_directions(
        point, "pull_off"
    )


def get_study_hardness(study: Study) -> float:
    """Return the hardness (GPa) of a study.

    Returns NaN if the study has no hardness.
    """
    hardness = study.contact.hardness
    return math.nan if hardness is None else float(hardness)


def get_contact_hardness(point: xarray.Dataset, study: Study) -> float:
    """Return the hardness (GPa) of the contacts at the load of `point`.

    Returns NaN if the study has no hardness.

    The hardness of the contacts differs from the hardness of the study if the depth of the indentation is known.
    """
    return mean_over_directions(point, "contact_hardness") if "contact_hardness" in point else get_study_hardness(study)


def compute_plastic_friction(point: xarray.Dataset, study: Study) -> float | None:
    """Return the friction coefficient of the pair if all contacts yielded and friction acted at all of them.

    Returns None if contacts cannot yield.

    The coefficient is a lower limit if the interface is stronger than the softer body. The coefficient is NaN at
    seizure, and None if the study has no hardness.
    """
    hardness = get_contact_hardness(point, study)
    if math.isnan(hardness) or not study.uses_half_space:
        return None
    law = Inputs.from_study(study).friction_law(read_number(point, "mu0"), read_number(point, "tau0"))
    return float(law.plastic_coefficient(hardness))


def is_stronger_than_body(point: xarray.Dataset, study: Study) -> bool:
    """Return whether the softer body would shear before its yielding contacts slide."""
    if study.contact.hardness is None:
        return False
    law = Inputs.from_study(study).friction_law(read_number(point, "mu0"), read_number(point, "tau0"))
    return bool(law.is_stronger_than_body(get_contact_hardness(point, study)))
