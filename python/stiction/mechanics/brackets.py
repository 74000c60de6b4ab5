"""Bounds on contact area and friction in finer scans, and extrapolation of rms gradients to shorter wavelengths."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.mechanics.friction import FrictionLaw
from stiction.mechanics.patches import grid_slopes
from stiction.surfaces.hurst import HurstEstimate, estimate_hurst_exponent
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import ScaleDependentRoughness, fitted_and_limiting_power_laws
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray as xr

# Minimum half width of the 95 % interval for the change of ln κ by a finer scan; κ = A E* h'/F is the area coefficient.
MIN_LOG_KAPPA_SPREAD = 0.1
EXTRAPOLATED_WAVELENGTH_RATIOS = tuple(2.0**-power for power in range(11))


def kappa_uncertainty_factor(contact_count: Floats) -> Floats:
    """Return the largest factor (95 % probability) by which a finer scan may raise or lower κ = A E* h'/F.

    The coefficient κ = A E* h'/F relates the real contact area A to the load F and to the rms gradient h'.

    The factor was fitted to the mean plus two standard deviations of ln κ: 0.6 with 2 contacts, 0.35 with 5, 0.2 with
    16 and 0.1 with 40. The pairs had Hurst exponents of 0.4 and 0.8, and shortest wavelengths of 32 and of 4 points.
    """
    return np.asarray(np.exp(np.maximum(1 / np.sqrt(np.maximum(contact_count, 1)), MIN_LOG_KAPPA_SPREAD)))


def gap_rms_gradient(gap: Profile | Surface, *, periodic: bool) -> float:
    """Compute the rms gradient of a gap from slopes at grid points, as the half-space model does."""
    gap_slopes = grid_slopes(gap.heights, gap.spacings, periodic=periodic)
    return math.sqrt(sum(float(np.mean(np.square(slope))) for slope in gap_slopes))


def estimate_gap_hurst_exponent(gap: Profile | Surface, periodic: bool) -> HurstEstimate | None:
    """Estimate the Hurst exponent of a gap.

    Returns None if its spectrum has no self-affine band.
    """
    try:
        return estimate_hurst_exponent(gap, periodic=periodic)
    except ValueError:
        return None


def plastic_wavelength(
    roughness: ScaleDependentRoughness, estimate: HurstEstimate | None, gradient: float, spread: float
) -> tuple[float, float, float]:
    """Return the cutoff (µm) at which a gap has the rms gradient `gradient`, with lower and upper limit.

    The limits follow from the Hurst exponent's interval and from a relative uncertainty of the gradient by the factor
    `spread`. NaN is returned if there is no such wavelength.
    """
    if math.isnan(gradient):
        return math.nan, math.nan, math.nan
    best_estimate, rougher_estimate, smoother_estimate = (
        (None,) * 3 if estimate is None else fitted_and_limiting_power_laws(estimate)
    )
    return (
        roughness.wavelength_of(gradient, best_estimate),
        roughness.wavelength_of(gradient * spread, smoother_estimate),
        roughness.wavelength_of(gradient / spread, rougher_estimate),
    )


def extrapolated_gradients(
    roughness: ScaleDependentRoughness, estimate: HurstEstimate | None, shortest_wavelength: float, gradient: float
) -> Floats:
    """Extrapolate the rms gradient of a scan to shorter wavelengths.

    Return an estimate and two limits for each wavelength. All numbers are NaN if `estimate` is None.
    """
    finer_wavelengths = np.array(EXTRAPOLATED_WAVELENGTH_RATIOS) * shortest_wavelength
    if estimate is None:
        return np.full((finer_wavelengths.size, 3), np.nan)
    # A factor makes the extrapolated rms gradient equal to that of the scan at the scan's shortest wavelength.
    gradient_ratio = gradient / float(roughness.gradient_at(shortest_wavelength))
    gradients = gradient_ratio * np.stack(
        [roughness.continued(finer_wavelengths, power_law) for power_law in fitted_and_limiting_power_laws(estimate)],
        axis=1,
    )
    gradients[:, 1:] = np.sort(gradients[:, 1:], axis=1)
    return gradients


def elastic_area_fraction(gradients: Floats, area_of_slope: Floats, spread: Floats) -> Floats:
    """Return the ratio of true to nominal contact area of elastic contacts at given rms gradients.

    The axes of the array are wavelengths, loads, and estimate and limits. `area_of_slope` is the area fraction at an
    rms gradient of 1, and `spread` the factor of its uncertainty.
    """
    spread_factors = np.stack([np.ones(spread.shape), 1 / spread, spread], axis=1)
    return area_of_slope[:, np.newaxis] * spread_factors / gradients[:, np.newaxis, [0, 2, 1]]


def developed_interface_area_ratio(gradient: Floats) -> Floats:
    """Return the ratio of developed to projected interface area for two equally rough surfaces.

    The ratio is 1 + h'²/8. Here h' is the rms gradient of the gap, and the interface has half of this gradient.
    """
    return np.asarray(1 + np.square(gradient) / 8)


def transverse_slope_factor(gradient: Floats, dimensions: int) -> Floats:
    """Return the factor by which slopes across the direction of motion raise mu_s if friction acts at all contacts.

    All contacts include those whose slopes do not oppose the motion.

    The factor is 1 + h'²/16 for height maps whose gap has the rms gradient h', and 1 for profiles.
    """
    return np.asarray(1 + np.square(gradient) / 16 if dimensions == 2 else np.ones(np.shape(gradient)))


def max_area_for_finer_scans(area: ArrayLike, plastic_area: ArrayLike, contact_count: ArrayLike) -> Floats:
    """Return an upper bound of the true contact area in any finer scan, if the contacts yield.

    `area` is the area of this scan, and `plastic_area` is F/H in the same unit. Shorter wavelengths redistribute the
    load between contacts, so the elastic rims of yielding contacts may grow. The limit does not apply to a scan without
    yielding, which is limited only by κ. None of 300 pairs of 256² points with 2 to 40 contacts exceeded the limit.
    """
    plastic_areas = np.asarray(plastic_area, dtype=np.float64)
    scan_area = np.maximum(area, plastic_areas)
    factor = kappa_uncertainty_factor(np.asarray(contact_count, dtype=np.float64))
    return np.asarray(np.minimum(scan_area * factor, plastic_areas + (scan_area - plastic_areas) * np.square(factor)))


def friction_range_for_finer_scans(
    value: float, mu0: float, adhesion: float, contact_count: float, upper: float | None = None
) -> tuple[float, float]:
    """Return the lowest and highest mu_s in finer scans, if contacts yield and friction acts at all contacts.

    `value` is mu_s of this scan, and `adhesion` is tau0/H. The upper limit is computed from `value`, or from `upper` if
    given.
    """
    highest_friction = value if upper is None else upper
    return min(mu0 + adhesion, value), float(
        max_friction_for_finer_scans(highest_friction, mu0, adhesion, contact_count)
    )


def max_friction_for_finer_scans(
    value: Floats | float, mu0: Floats | float, adhesion: Floats | float, contact_count: float
) -> Floats:
    """Return an upper bound of mu_s in any finer scan, if the contacts yield.

    `value` is mu_s of this scan.
    """
    adhesive_friction = np.asarray(value - mu0)
    friction_increase = max_area_for_finer_scans(adhesive_friction, adhesion, contact_count) - np.maximum(
        adhesive_friction, adhesion
    )
    return np.asarray(np.where(np.asarray(adhesion) > 0, value + friction_increase, value))


def add_finer_scan_bounds(result: xr.Dataset, hardness: float, strengths: tuple[float, float] | None) -> xr.Dataset:
    """Add the area F/H, the friction of yielding contacts, and bounds for finer scans to a `resolution` dataset."""
    loads, area = result.normal_load.values, result.contact_area.values
    nominal_area = result.attrs["nominal_area_um2"]
    plastic_area = loads / hardness
    largest_area = max_area_for_finer_scans(area, plastic_area, result.contact_count.values)
    dimensions = ("cut_off", "normal_load", "end")
    variables: dict[str, tuple[tuple[str, ...], Floats, str, str]] = {
        "plastic_area": (dimensions[1:2], plastic_area, "µm²", "smallest real contact area, F/H"),
        "plastic_area_fraction": (
            dimensions[1:2], plastic_area / nominal_area, "1", "smallest ratio of real to nominal area, F/(H A0)"
        ),
        "bracket_area_fraction": (
            dimensions, _stack_bounds(plastic_area / nominal_area, largest_area / nominal_area), "1",
            "ratio of real to nominal area of every finer scan",
        ),
    }  # fmt: skip
    if strengths is not None:
        law = FrictionLaw(*strengths)
        plastic_friction = np.full(loads.size, law.plastic_coefficient(hardness))
        friction = result.friction_coefficient.sel(sliding="all").transpose(*dimensions[:2]).values
        friction_bounds = _stack_bounds(plastic_friction, friction + law.force(0.0, largest_area - area) / loads)
        variables["plastic_friction_coefficient"] = (
            dimensions[1:2],
            plastic_friction,
            "1",
            "mu0 + tau0/H, smallest with friction at all contacts",
        )
        variables["bracket_friction_coefficient"] = (
            dimensions,
            friction_bounds,
            "1",
            "mu_s of every finer scan with friction at all contacts",
        )
    labelled_variables = {
        name: (dims, values, {"units": unit, "long_name": description})
        for name, (dims, values, unit, description) in variables.items()
    }
    return result.assign(labelled_variables).assign_coords(end=("end", ["lower", "upper"]))


def _stack_bounds(lower: Floats, upper: Floats) -> Floats:
    return np.stack([np.broadcast_to(lower, upper.shape), upper], axis=-1)
