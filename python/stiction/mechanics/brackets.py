"""How an elastic answer goes on below the finest wave that was seen, and brackets of area and friction."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.surfaces.hurst import HurstEstimate, estimate_hurst_exponent
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import ScaleDependentRoughness, interval_power_laws
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray as xr

LEAST_SPREAD = 0.1  # of the logarithm of κ = A E* h'/F, by which two resolutions differ however many contacts there are
FINER = tuple(2.0**-power for power in range(11))  # wavelengths of continued answers over the shortest of the scan


def kappa_spread(contact_count: Floats) -> Floats:
    """Factor within which κ of a finer scan is that of this one, in 95 of 100 pairs, from the number of contacts.

    Measured as mean and two standard deviations of logarithms: 0.6 with 2 contacts, 0.35 with 5, 0.2 with 16, 0.1 with
    40, of pairs of Hurst exponents 0.4 and 0.8 seen with waves from 32 points on and from 4 points on.
    """
    return np.asarray(np.exp(np.maximum(1 / np.sqrt(np.maximum(contact_count, 1)), LEAST_SPREAD)))


def rms_gradient(gap: Profile | Surface, *, periodic: bool) -> float:
    """Root-mean-square gradient of a gap, of slopes as the half-space takes them."""
    from stiction.mechanics.patches import slopes

    each_way = slopes(gap.heights, gap.spacings, periodic=periodic)
    return math.sqrt(sum(float(np.mean(np.square(each))) for each in each_way))


def gap_exponent(gap: Profile | Surface, periodic: bool) -> HurstEstimate | None:
    """The Hurst exponent of a gap; None where its spectrum has no self-affine band."""
    try:
        return estimate_hurst_exponent(gap, periodic=periodic)
    except ValueError:
        return None


def plastic_wavelength(
    roughness: ScaleDependentRoughness, estimate: HurstEstimate | None, gradient: float, spread: float
) -> tuple[float, float, float]:
    """Wavelength down to which waves have a gradient, known within a factor, and its interval; NaN without one."""
    if math.isnan(gradient):
        return math.nan, math.nan, math.nan
    middle, rougher, smoother = (None,) * 3 if estimate is None else interval_power_laws(estimate)
    return (
        roughness.wavelength_of(gradient, middle),
        roughness.wavelength_of(gradient * spread, smoother),
        roughness.wavelength_of(gradient / spread, rougher),
    )


def continued(
    roughness: ScaleDependentRoughness, estimate: HurstEstimate | None, shortest: float, gradient: float
) -> Floats:
    """Gradients of finer scans from that of this one on, (wavelength, statistic); NaN without an exponent."""
    finer = np.array(FINER) * shortest
    if estimate is None:
        return np.full((finer.size, 3), np.nan)
    # Of the scan's own slopes, so that the line begins where they end.
    own = gradient / float(roughness.gradient_at(shortest))
    gradients = own * np.stack([roughness.continued(finer, line) for line in interval_power_laws(estimate)], axis=1)
    gradients[:, 1:] = np.sort(gradients[:, 1:], axis=1)
    return gradients


def elastic_area(gradients: Floats, area_of_slope: Floats, spread: Floats) -> Floats:
    """Area fractions (wavelength, load, statistic) of the ground plan, from those at a gradient of one."""
    within = np.stack([np.ones(spread.shape), 1 / spread, spread], axis=1)
    return area_of_slope[:, np.newaxis] * within / gradients[:, np.newaxis, [0, 2, 1]]


def interface_stretch(gradient: Floats) -> Floats:
    """Area of the interface over its ground plan, 1 + h'²/8, where both bodies share the gap's slope equally."""
    return np.asarray(1 + np.square(gradient) / 8)


def friction_stretch(gradient: Floats, dimensions: int) -> Floats:
    """Factor on mu_s where all contacts rub: 1 + h'²/16, for the slopes across the motion; 1 on lines, without any."""
    return np.asarray(1 + np.square(gradient) / 16 if dimensions == 2 else np.ones(np.shape(gradient)))


def most_area(area: ArrayLike, contact_count: ArrayLike) -> Floats:
    """Largest true area of finer scans of a pair that yields, in F/H, from that of this scan and its contacts.

    Finer waves move the load from one contact to another, so that elastic rims of those that yield may grow; a scan of
    which all is elastic is bound by κ alone. Measured: all of 300 pairs of 256² points with 2 to 40 contacts.
    """
    own = np.maximum(np.asarray(area, dtype=np.float64), 1.0)
    spread = kappa_spread(np.asarray(contact_count, dtype=np.float64))
    return np.asarray(np.minimum(own * spread, 1 + (own - 1) * np.square(spread)))


def friction_bracket(
    value: float, mu0: float, adhesion: float, contacts: float, upper: float | None = None
) -> tuple[float, float]:
    """Ends of mu_s of every finer scan of a pair that yields, from mu_s where all rubs, mu0, tau0/H and contacts.

    The upper end is by default that of the value, and otherwise that of an upper end of its interval.
    """
    most = value if upper is None else upper
    if adhesion > 0:
        most += adhesion * float(most_area((most - mu0) / adhesion, contacts)) - max(most - mu0, adhesion)
    return min(mu0 + adhesion, value), most


def with_brackets(result: xr.Dataset, hardness: float, parameters: tuple[float, float] | None) -> xr.Dataset:
    """A dataset of `resolution` with the plastic limit and the ends between which finer scans lie, where all rubs."""
    loads, area = result.normal_load.values, result.contact_area.values
    nominal = result.attrs["nominal_area_um2"]
    least = loads / hardness
    most = least * most_area(area / least, result.contact_count.values)
    over = ("cut_off", "normal_load", "end")
    found: dict[str, tuple[tuple[str, ...], Floats, str, str]] = {
        "plastic_area": (over[1:2], least, "µm²", "least true area, F/H"),
        "plastic_area_fraction": (over[1:2], least / nominal, "1", "least true over nominal area, F/(H A0)"),
        "bracket_area_fraction": (
            over, _ends(least / nominal, most / nominal), "1", "true over nominal area of every finer scan"
        ),
    }  # fmt: skip
    if parameters is not None:
        mu0, tau0 = parameters
        limit = np.full(loads.size, mu0 + tau0 / hardness)
        friction = result.friction_coefficient.sel(sliding="all").transpose(*over[:2]).values
        ends = _ends(limit, friction + tau0 * (most - area) / loads)
        found["plastic_friction_coefficient"] = over[1:2], limit, "1", "mu0 + tau0/H, least where all contacts rub"
        found["bracket_friction_coefficient"] = over, ends, "1", "mu_s of every finer scan where all contacts rub"
    said = {
        name: (dims, values, {"units": unit, "long_name": words}) for name, (dims, values, unit, words) in found.items()
    }
    return result.assign(said).assign_coords(end=("end", ["lower", "upper"]))


def _ends(least: Floats, most: Floats) -> Floats:
    return np.stack([np.broadcast_to(least, most.shape), most], axis=-1)
