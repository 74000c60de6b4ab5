"""Area and friction as functions of the shortest resolved wavelength, with bounds for finer scans if bodies yield."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, check_instance, float_array, validate_number
from stiction._units import short_repr
from stiction.mechanics import brackets
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.friction import LOAD_SUM_NAMES, FrictionLaw, validate_friction_parameter
from stiction.mechanics.half_space import BoundaryCondition, half_space, solve_together_or_separately
from stiction.mechanics.model import DEFAULT_EFFECTIVE_MODULUS, Direction, SlidingRule, check_pair, modulus_or_default
from stiction.mechanics.quantities import quantity_attributes
from stiction.surfaces.cut_off import MAX_CUTOFF_FRACTION, cut_off
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import ScaleDependentRoughness, instrument_limit, scale_dependent_roughness
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray as xr

TYPICAL_HARDNESSES = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""Default hardnesses (GPa) for which the plastic wavelength is computed, from polymers and soft metals to ceramics."""

_MAX_CUTOFF_RATIO = 1 / 30
# The first sliding rule is "all", because most measured mu0 refer to friction at all contacts.
_SLIDING_RULES: tuple[SlidingRule, ...] = ("all", "opposing")
_FOUR_DIRECTIONS = (0.0, 90.0, 180.0, 270.0)
_PLASTIC_WAVELENGTH_DESCRIPTION = "wavelength at which the elastic mean pressure reaches the hardness"
# On Gaussian maps, the area coefficient κ = A E* h'/F at small loads is 2.05 to 2.5.
KAPPA_AT_SMALL_LOADS = 2.2
_DIRECTION_INDEPENDENT_FIELDS = ("contact_area", "contact_count", "load_share_at_hardness", "error")
_VARIABLE_NAMES_BY_FIELD = {"load_share_at_hardness": "load_fraction_at_hardness"}


def resolution(
    upper: Profile | Surface,
    lower: Profile | Surface,
    loads: ArrayLike,
    *,
    hardness: float | None,
    cut_offs: float | Sequence[float] | None = None,
    mu0: float | None = None,
    tau0: float = 0.0,
    effective_modulus: float | None = None,
    boundary: BoundaryCondition = "free",
    compliance_share: float = 0.5,
    direction: Direction | Sequence[Direction] | None = None,
    tip_radius: float | None = None,
    tolerance: float = 1e-6,
    progress: Callable[[int, int], object] | None = None,
) -> xr.Dataset:
    r"""Compute area and friction of a pair at several cutoffs (µm), and bounds on area and friction for finer scans.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Two profiles or two surfaces on the same grid, as for `half_space`.
    loads : (k,) array_like of float, mN
        Above 0 and strictly increasing.
    hardness : float, GPa, or None
        Largest pressure, the hardness of the softer body. None stands for elastic bodies: the result then has no limit,
        and the dataset contains the limiting wavelengths for typical hardnesses.
    cut_offs : float or sequence of float, µm, optional
        Wavelengths for `cut_off`; the unfiltered scan, 0, is always included. By default 0, four points, and doubled
        up to a thirtieth of the shortest side.
    mu0 : float, optional
        Molecular friction coefficient. Friction is evaluated if it is given.
    tau0 : float, GPa
        Adhesive shear strength.
    effective_modulus, boundary, compliance_share, tolerance
        As for `half_space`.
    direction : {"+x", "-x"} or float, or a sequence of these, optional
        Directions over which the loads are averaged: by default four directions on surfaces, and both on profiles.
    tip_radius : float, µm, optional
        Tip radius of the instrument, for `instrument_limit`.
    progress : callable, optional
        Called with the number of solved contact problems and their total number.

    Returns
    -------
    result : xarray.Dataset
        Over `cut_off` (µm), `normal_load` (mN) and `sliding` ("all", "opposing"): `rms_gradient` of the gap,
        `contact_area`, `contact_area_fraction`, `mean_pressure`, `contact_count`, `load_fraction_at_hardness`, the six
        sums, and with mu0 `friction_coefficient`. NaN if no solution was found.

        Over `normal_load`: `elastic_kappa`, and with a hardness `plastic_area`, `plastic_area_fraction` and
        `plastic_friction_coefficient`, which limit all finer scans.

        With a hardness, over cutoffs, loads and `end` ("lower", "upper"): `bracket_area_fraction` and, for "all",
        `bracket_friction_coefficient`, which contain all finer scans of this pair.

        Over `hardness` (GPa), `normal_load` and `statistic` (value, lower, upper): `plastic_wavelength` (µm), at which
        the elastic mean pressure reaches the hardness. It is the longest wavelength if this wavelength alone gives the
        pressure, and NaN if the power law never reaches the required rms gradient.

        The attributes contain the instrument limit of the scans, the Hurst exponent of the gap with its interval, and
        the histories.

        Over `finer_wavelength` (µm) and `statistic`: `continued_rms_gradient`, and also over loads
        `continued_elastic_area_fraction` and `continued_elastic_friction_coefficient` ("all"), extrapolated by the
        Hurst exponent.

    Raises
    ------
    ValueError
        As for `half_space` and `cut_off`, or if the gap is constant.

    See Also
    --------
    resolution_friction : Friction for other values of mu0 and tau0.
    spectral_resolution : Closed form for independent surfaces, from their spectra.

    Notes
    -----
    A finer scan has larger slopes, so the elastic area, :math:`A = κ F/(E^* h')`, does not converge. The hardness H
    limits the pressure below the wavelength at which :math:`h'(λ) = κ H/E^*`. Then

    .. math:: F/H \le A \le A_{scan}, \qquad μ_0 + τ_0/H \le μ_s \le μ_{s,scan}

    in the mean over pairs with friction at all contacts, up to terms of second order in slopes. For a single pair with
    n contacts the upper limit is :math:`F/H + (A - F/H)\,e^{2/\sqrt n}` instead of A, with 1/√n at least 0.1. With
    friction at opposing contacts only, the slope term has no such limit, so the result depends on the resolution. Below
    the fitted band, h' is extrapolated by the Hurst exponent of the gap, within its interval, with a factor on κ that
    increases as the number of contacts decreases.

    Examples
    --------
    >>> from stiction import resolution, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (128, 128), "spacing": 0.02}
    >>> upper, lower = (self_affine_surface(1, side=side, **rough) for side in ("upper", "lower"))
    >>> found = resolution(upper, lower, [0.1], hardness=4.0, effective_modulus=100.0, mu0=0.2, tau0=0.1)
    >>> found.cut_off.values.round(3)
    array([0.  , 0.08])
    >>> round(float(found.plastic_friction_coefficient[0]), 3)
    0.225
    """
    check_pair(upper, lower)
    effective_modulus = modulus_or_default(effective_modulus, upper, lower)
    body_pair = _BodyPair(upper, lower, boundary)
    cut_off_lengths = body_pair.choose_cut_offs(cut_offs)
    if hardness is not None:
        hardness = validate_number("hardness", hardness, unit="GPa", above=0)
    parameters = None if mu0 is None else _validate_strengths(mu0, tau0)
    is_areal = isinstance(upper, Surface)
    if direction is None:
        direction = _FOUR_DIRECTIONS if is_areal else ("+x", "-x")
    directions: tuple[Direction, ...] = tuple(direction) if np.ndim(direction) else (direction,)  # type: ignore[assignment,arg-type]
    solver_options: dict[str, Any] = {
        "effective_modulus": effective_modulus, "boundary": boundary, "compliance_share": compliance_share,
        "direction": directions if is_areal else directions[0], "sliding": "all", "tolerance": tolerance,
    }  # fmt: skip
    load_array = float_array("loads", loads, ndim=1)
    report = progress or (lambda num_done, total: None)
    count = len(cut_off_lengths) + (hardness is not None)
    solutions = []
    for num_done, cut_off_length in enumerate(cut_off_lengths):
        report(num_done, count)
        solutions.append(
            _solve_at_loads(
                *body_pair.bodies_with_cut_off(cut_off_length),
                load_array,
                directions,
                hardness=hardness,
                **solver_options,
            )
        )
    elastic_solution = solutions[0]
    if hardness is not None:
        report(len(cut_off_lengths), count)
        elastic_solution = _solve_at_loads(upper, lower, load_array, directions, hardness=None, **solver_options)
    report(count, count)
    result = _make_cutoff_dataset(body_pair, cut_off_lengths, load_array, solutions, effective_modulus, hardness)
    if parameters is not None:
        result = result.assign(friction_coefficient=resolution_friction(result, mu0=parameters[0], tau0=parameters[1]))
    rough_bodies = [body for body in (upper, lower) if not body.is_flat]
    limits = [instrument_limit(body, tip_radius=tip_radius, periodic=body_pair.periodic) for body in rough_bodies]
    largest_limit = max(limits, key=lambda limit: limit.wavelength)
    result.attrs |= {"instrument_limit_um": largest_limit.wavelength, "instrument_limit_reason": largest_limit.reason}
    return _add_plastic_limits(result, body_pair, load_array, elastic_solution, effective_modulus, hardness, parameters)


def resolution_friction(result: xr.Dataset, *, mu0: float, tau0: float = 0.0) -> xr.DataArray:
    """Return the friction coefficient for any mu0 and tau0, from a dataset that `resolution` returned.

    Parameters
    ----------
    result : xarray.Dataset
        Dataset of `resolution`.
    mu0 : float
        Molecular friction coefficient, at least 0.
    tau0 : float, GPa
        Adhesive shear strength, at least 0.

    Returns
    -------
    coefficient : xarray.DataArray
        Friction coefficient over `cut_off` (µm), `normal_load` (mN) and `sliding` ("all", "opposing"): the ratio of the
        tangential and the normal load, both averaged over the directions. NaN if no solution was found.

    Raises
    ------
    ValueError
        If mu0 or tau0 is negative.

    See Also
    --------
    resolution : Computation of the dataset.

    Examples
    --------
    >>> from stiction import resolution, resolution_friction, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (128, 128), "spacing": 0.02}
    >>> upper, lower = (self_affine_surface(1, side=side, **rough) for side in ("upper", "lower"))
    >>> found = resolution(upper, lower, [0.1], hardness=4.0, effective_modulus=100.0, cut_offs=[])
    >>> resolution_friction(found, mu0=0.3).sel(sliding="all").values.round(2)
    array([[0.3]])
    """
    import xarray as xr

    check_instance("result", result, xr.Dataset, "an xarray.Dataset of resolution")
    mu, tau = _validate_strengths(mu0, tau0)
    normal_load, tangential_load = (FrictionLaw(mu, tau).load(load, result) for load in ("normal", "tangential"))
    mu_s = np.divide(tangential_load, normal_load, out=np.full_like(normal_load, np.nan), where=normal_load > 0)
    coefficients = result.normal_elastic.copy(data=mu_s)
    coefficients.attrs = {"units": "1", "long_name": "coefficient of static friction", "mu0": mu, "tau0_GPa": tau}
    ordered_coefficients: xr.DataArray = coefficients.transpose("sliding", "cut_off", "normal_load")
    return ordered_coefficients


def _validate_strengths(mu0: Any, tau0: Any) -> tuple[float, float]:
    mu, tau = (
        float(validate_friction_parameter(name, validate_number(name, value)))
        for name, value in (("mu0", mu0), ("tau0", tau0))
    )
    return mu, tau


# ---- Contact solutions ----------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _BodyPair:
    upper: Profile | Surface
    lower: Profile | Surface
    boundary: BoundaryCondition

    @property
    def periodic(self) -> bool:
        return self.boundary == "periodic"

    @property
    def nominal_area(self) -> float:
        """Nominal area (µm²) of the pair.

        A profile counts as 1 µm wide.
        """
        return math.prod(self.upper.spacings) * self.upper.heights.size

    @property
    def shortest_cutoff_wavelength(self) -> float:
        """Shortest possible cutoff (µm): twice the largest grid spacing."""
        return 2 * max(self.upper.spacings)

    def compute_gap(self, upper: Profile | Surface, lower: Profile | Surface) -> Profile | Surface:
        return replace(upper, heights=upper.heights - lower.heights, history=())

    def choose_cut_offs(self, cut_offs: float | Sequence[float] | None) -> list[float]:
        side_length = min(size * step for size, step in zip(self.upper.heights.shape, self.upper.spacings, strict=True))
        if cut_offs is None:
            default_cut_offs = 2 * self.shortest_cutoff_wavelength * 2.0 ** np.arange(40)
            return [0.0, *default_cut_offs[default_cut_offs <= _MAX_CUTOFF_RATIO * side_length * (1 + 1e-9)].tolist()]
        lengths = float_array("cut_offs", np.atleast_1d(cut_offs), ndim=1).tolist()
        if any(
            length != 0
            and not self.shortest_cutoff_wavelength * (1 - 1e-9) <= length <= MAX_CUTOFF_FRACTION * side_length
            for length in lengths
        ):
            raise ValueError(
                f"cut_offs must be 0, or between {self.shortest_cutoff_wavelength:g} µm (two grid spacings) and "
                f"{MAX_CUTOFF_FRACTION * side_length:g} µm (a third of the shortest side), got {short_repr(cut_offs)}"
            )
        return sorted({0.0, *lengths})

    def bodies_with_cut_off(self, length: float) -> tuple[Any, Any]:
        if length == 0:
            return self.upper, self.lower
        return tuple(
            body if body.is_flat else cut_off(body, length, periodic=self.periodic) for body in (self.upper, self.lower)
        )  # type: ignore[return-value]


def _solve_at_loads(
    upper: Any, lower: Any, loads: Floats, directions: tuple[Direction, ...], **options: Any
) -> dict[str, Floats]:
    """Solve the contact of two bodies at all loads (mN), and return a dict of results such as the contact area.

    Results of the contact have the shape (load,), sums have the shape (rule, load) and are averaged over directions.
    Both are NaN at loads for which no solution was found.
    """
    results = {name: np.full(loads.size, np.nan) for name in _DIRECTION_INDEPENDENT_FIELDS}
    results |= {name: np.full((len(_SLIDING_RULES), loads.size), np.nan) for name in LOAD_SUM_NAMES}
    for indices, curve in solve_together_or_separately(functools.partial(half_space, upper, lower, **options), loads):
        for name in _DIRECTION_INDEPENDENT_FIELDS:
            results[name][indices] = getattr(curve, name)
        for rule_index, sliding in enumerate(_SLIDING_RULES):
            curve_for_rule = curve if sliding == curve.sliding else curve.with_sliding(sliding)
            curves = [curve_for_rule]
            if curve.direction.ndim == 0:
                curves = [curve_for_rule.with_direction(direction) for direction in directions]
            for name in LOAD_SUM_NAMES:
                sums = [np.atleast_2d(getattr(directed_curve, name)) for directed_curve in curves]
                results[name][rule_index, indices] = np.mean(sums, axis=(0, 1))
    return results


# ---- Results as functions of the cutoff ------------------------------------------------------------------------------


def _make_cutoff_dataset(
    body_pair: _BodyPair, lengths: list[float], loads: Floats, solutions: list[dict[str, Floats]], modulus: float,
    hardness: float | None,
) -> xr.Dataset:  # fmt: skip
    """Return a dataset with contact area, mean pressure, and force and area sums for each cutoff (µm).

    Values are NaN where the solver failed.
    """
    import xarray as xr

    gaps = [body_pair.compute_gap(*body_pair.bodies_with_cut_off(length)) for length in lengths]
    gradient = np.array([brackets.gap_rms_gradient(gap, periodic=body_pair.periodic) for gap in gaps])
    values = {
        name: np.array([solution[name] for solution in solutions])
        for name in (*_DIRECTION_INDEPENDENT_FIELDS, *LOAD_SUM_NAMES)
    }
    area = values["contact_area"]
    with np.errstate(divide="ignore", invalid="ignore"):
        values |= {"contact_area_fraction": area / body_pair.nominal_area, "mean_pressure": loads / area}
        kappa = area * modulus * gradient[:, np.newaxis] / loads
    dimensions = ("cut_off", "normal_load")
    variables: dict[str, Any] = {
        "shortest_wavelength": (
            "cut_off", [max(length, body_pair.shortest_cutoff_wavelength) for length in lengths],
            _variable_attributes("µm", "shortest resolved wavelength"),
        ),
        "rms_gradient": ("cut_off", gradient, quantity_attributes("rms_gradient")),
        "kappa": (dimensions, kappa, _variable_attributes("1", "A E* h'/F")),
        **{
            _VARIABLE_NAMES_BY_FIELD.get(name, name): (dimensions, column, quantity_attributes(name))
            for name, column in values.items() if name not in LOAD_SUM_NAMES
        },
        **{
            name: (("sliding", *dimensions), np.moveaxis(values[name], 1, 0), quantity_attributes(name))
            for name in LOAD_SUM_NAMES
        },
    }  # fmt: skip
    return xr.Dataset(
        variables,
        coords={
            "cut_off": ("cut_off", lengths, _variable_attributes("µm", "cutoff wavelength, 0 for none")),
            "normal_load": ("normal_load", loads, _variable_attributes("mN", "elastic normal load")),
            "sliding": ("sliding", list(_SLIDING_RULES), {"long_name": "contacts with friction"}),
        },
        attrs={
            "model": "elastic half-space" + (", perfectly plastic at the hardness" if hardness is not None else ""),
            "effective_modulus_GPa": modulus, "hardness_GPa": math.nan if hardness is None else hardness,
            "nominal_area_um2": body_pair.nominal_area, "boundary": body_pair.boundary,
            "upper_history": "; ".join(body_pair.upper.history), "lower_history": "; ".join(body_pair.lower.history),
        },
    )  # fmt: skip


def _variable_attributes(unit: str, text: str) -> dict[str, str]:
    return {"units": unit, "long_name": text}


# ---- Plastic limits -------------------------------------------------------------------------------------------------


def _add_plastic_limits(
    result: xr.Dataset, body_pair: _BodyPair, loads: Floats, elastic_solution: dict[str, Floats], modulus: float,
    hardness: float | None, strengths: tuple[float, float] | None,
) -> xr.Dataset:  # fmt: skip
    """Add the elastic areas of finer scans and the yield wavelength to a `resolution` dataset.

    Contacts yield if wavelengths down to the yield wavelength are included.
    """
    gap = body_pair.compute_gap(body_pair.upper, body_pair.lower)
    roughness = scale_dependent_roughness(gap, periodic=body_pair.periodic)
    hurst_estimate = brackets.estimate_gap_hurst_exponent(gap, body_pair.periodic)
    area = elastic_solution["contact_area"]
    kappa = area * modulus * float(result.rms_gradient[0]) / loads
    kappa_uncertainty = brackets.kappa_uncertainty_factor(elastic_solution["contact_count"])
    if hardness is not None:
        result = brackets.add_finer_scan_bounds(result, hardness, strengths)
    hardnesses = TYPICAL_HARDNESSES if hardness is None else (hardness,)
    gradients_at_hardness = [zip(kappa * item / modulus, kappa_uncertainty, strict=True) for item in hardnesses]
    plastic_wavelengths = np.array([
        [brackets.plastic_wavelength(roughness, hurst_estimate, *bounds) for bounds in item]
        for item in gradients_at_hardness
    ])  # fmt: skip
    gradient = float(result.rms_gradient[0])
    gradients = brackets.extrapolated_gradients(
        roughness, hurst_estimate, body_pair.shortest_cutoff_wavelength, gradient
    )
    area_of_slope = (
        kappa * loads / (modulus * body_pair.nominal_area * brackets.developed_interface_area_ratio(np.array(gradient)))
    )
    area_fractions = brackets.elastic_area_fraction(gradients, area_of_slope, kappa_uncertainty)
    # The slope correction hardly depends on the uncertainty of the gradient, so only the central gradient is used.
    central_gradients = gradients[:, :1, np.newaxis]
    dimensions = ("finer_wavelength", "normal_load", "statistic")
    quantities: dict[str, tuple[Any, Floats, str, str]] = {
        "elastic_kappa": (dimensions[1], kappa, "1", "A E* h'/F of the elastic solution of the scan"),
        "elastic_area_fraction": (
            dimensions[1], area / body_pair.nominal_area, "1", "ratio of real to nominal area of the elastic solution"
        ),
        "plastic_wavelength": (
            ("hardness", *dimensions[1:]), plastic_wavelengths, "µm", _PLASTIC_WAVELENGTH_DESCRIPTION
        ),
        "continued_rms_gradient": (dimensions[::2], gradients, "1", "gradient of the gap, extrapolated"),
        "continued_elastic_area_fraction": (
            dimensions, area_fractions * brackets.developed_interface_area_ratio(central_gradients), "1",
            "elastic ratio of real to nominal area, extrapolated",
        ),
    }  # fmt: skip
    if strengths is not None:
        friction = strengths[0] + strengths[1] * area_fractions * body_pair.nominal_area / loads[:, np.newaxis]
        friction = friction * brackets.transverse_slope_factor(central_gradients, roughness.dimensions)
        description = "elastic mu_s with friction at all contacts, extrapolated"
        quantities["continued_elastic_friction_coefficient"] = dimensions, friction, "1", description
    finer_wavelengths = np.array(brackets.EXTRAPOLATED_WAVELENGTH_RATIOS) * body_pair.shortest_cutoff_wavelength
    variables = {
        name: (dims, values, _variable_attributes(unit, description))
        for name, (dims, values, unit, description) in quantities.items()
    }
    extended_result = result.assign(variables).assign_coords(
        hardness=("hardness", list(hardnesses), _variable_attributes("GPa", "hardness")),
        statistic=("statistic", ["value", "lower", "upper"]),
        finer_wavelength=(
            "finer_wavelength",
            finer_wavelengths,
            _variable_attributes("µm", "shortest wavelength of a finer scan"),
        ),
    )
    if hurst_estimate is not None:
        extended_result.attrs |= {
            "hurst_exponent": hurst_estimate.value, "hurst_exponent_lower": hurst_estimate.lower,
            "hurst_exponent_upper": hurst_estimate.upper, "hurst_caution": hurst_estimate.caution or "",
            "band_um": (hurst_estimate.shortest_wavelength, hurst_estimate.longest_wavelength),
        }  # fmt: skip
    return extended_result


# ---- Closed-form estimates from spectra -----------------------------------------------------------------------------


def spectral_resolution(
    upper: ScaleDependentRoughness,
    lower: ScaleDependentRoughness | None,
    *,
    pressure: float,
    hardness: float | None,
    mu0: float,
    tau0: float = 0.0,
    effective_modulus: float = DEFAULT_EFFECTIVE_MODULUS,
    kappa: float = KAPPA_AT_SMALL_LOADS,
    wavelengths: ArrayLike | None = None,
) -> xr.Dataset:
    r"""Estimate true area and friction of two surfaces in closed form as functions of the shortest resolved wavelength.

    Parameters
    ----------
    upper, lower : ScaleDependentRoughness
        Roughness of both surfaces, from `scale_dependent_roughness` or from the method `roughness` of a
        `JoinedSpectrum`. None stands for a flat lower surface.
    pressure : float, GPa
        Load over nominal area, above 0.
    hardness : float, GPa, or None
        Hardness of the softer body, above the pressure; None stands for elastic bodies.
    mu0 : float
        Molecular friction coefficient, at least 0.
    tau0 : float, GPa
        Adhesive shear strength, at least 0.
    effective_modulus : float, GPa
        E*, see `effective_modulus`.
    kappa : float
        A E* h'/F of the elastic contact.
    wavelengths : array_like of float, µm, optional
        Shortest wavelengths; by default the wavelengths of both surfaces.

    Returns
    -------
    result : xarray.Dataset
        Over `wavelength` (µm, descending): `rms_gradient` of the gap, `contact_area_fraction`, `mean_pressure`, and
        also over `sliding` ("all", "opposing") `friction_coefficient`. `plastic_wavelength` (µm) is the wavelength at
        which the elastic pressure reaches the hardness; NaN if there is none.

    Raises
    ------
    ValueError
        If an argument is outside its range, or the roughness does not belong to a surface.

    See Also
    --------
    resolution : Solution for a given pair of scans.
    gentle_friction : Friction at opposing contacts.

    Notes
    -----
    .. math:: h'^2 = h'^2_u + h'^2_l, \qquad A/A_0 = \max(κ p/(E^* h'),\; p/H) \le 1, \qquad μ_s = μ_0 + τ_0 A/F

    with friction at all contacts, and `gentle_friction` with friction at opposing contacts. The surfaces are
    independent, Gaussian and isotropic, and the load is small. Near the wavelength at which both terms are equal, a
    half-space with the same hardness has an area larger by some tenths, because part of it yields already.

    Examples
    --------
    >>> from stiction import scale_dependent_roughness, self_affine_surface, spectral_resolution
    >>> body = self_affine_surface(1, hurst_exponent=0.8, rms=0.05, shape=(256, 256), spacing=0.04)
    >>> roughness = scale_dependent_roughness(body, periodic=True)
    >>> found = spectral_resolution(
    ...     roughness, roughness, pressure=0.02, hardness=2.0, mu0=0.2, tau0=0.05, effective_modulus=100.0
    ... )
    >>> round(float(found.friction_coefficient.sel(sliding="all")[-1]), 3)
    0.225
    """
    import xarray as xr

    bodies = [upper] if lower is None else [upper, lower]
    for body in bodies:
        if not isinstance(body, ScaleDependentRoughness) or body.dimensions != 2:
            raise ValueError(
                "the upper and the lower body must be ScaleDependentRoughness objects computed from surfaces"
            )
    p = validate_number("pressure", pressure, unit="GPa", above=0)
    max_pressure = np.inf if hardness is None else validate_number("hardness", hardness, unit="GPa", above=p)
    modulus = validate_number("effective_modulus", effective_modulus, unit="GPa", above=0)
    area_coefficient = validate_number("kappa", kappa, above=0)
    if wavelengths is None:
        wavelengths = np.concatenate([body.wavelength for body in bodies])
    wavelength_array = np.unique(float_array("wavelengths", wavelengths, ndim=1))[::-1]
    slopes = np.array([body.gradient_at(wavelength_array) for body in bodies])
    gradient = np.sqrt(np.square(slopes).sum(axis=0))
    is_rough = gradient > 0
    wavelength_array, slopes, gradient = wavelength_array[is_rough], slopes[:, is_rough], gradient[is_rough]
    if not wavelength_array.size:
        raise ValueError(
            f"wavelengths must be at most the longest wavelength of the bodies, got {short_repr(wavelengths)}"
        )
    area = np.minimum(np.maximum(area_coefficient * p / (modulus * gradient), p / max_pressure), 1.0)
    slope_ratio = slopes.min(axis=0) / slopes.max(axis=0) if lower is not None else np.zeros(wavelength_array.size)
    friction = [
        gentle_friction(
            mu0, tau0, rms_gradient=gradient, effective_modulus=modulus, kappa=area * modulus * gradient / p,
            sliding=rule, slope_ratio=slope_ratio,
        )
        for rule in _SLIDING_RULES
    ]  # fmt: skip
    yielding_indices = np.flatnonzero(modulus * gradient / area_coefficient >= max_pressure)
    plastic_wavelength = float(wavelength_array[yielding_indices[0]]) if yielding_indices.size else np.nan
    values = {"rms_gradient": gradient, "contact_area_fraction": area, "mean_pressure": p / area}
    return xr.Dataset(
        {
            **{name: ("wavelength", column, quantity_attributes(name)) for name, column in values.items()},
            "friction_coefficient": (
                ("sliding", "wavelength"), np.array(friction), quantity_attributes("friction_coefficient"),
            ),
            "plastic_wavelength": ((), plastic_wavelength, _variable_attributes("µm", _PLASTIC_WAVELENGTH_DESCRIPTION)),
        },
        coords={
            "wavelength": ("wavelength", wavelength_array, _variable_attributes("µm", "shortest included wavelength")),
            "sliding": ("sliding", list(_SLIDING_RULES), {"long_name": "contacts with friction"}),
        },
        attrs={
            "pressure_GPa": p, "hardness_GPa": float(max_pressure), "effective_modulus_GPa": modulus,
            "kappa": area_coefficient,
        },
    )  # fmt: skip
