"""Between which ends every finer scan of a pair that yields lies."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats
from stiction.mechanics.continuation import kappa_spread

if TYPE_CHECKING:
    import xarray as xr


def most_area(area: ArrayLike, contact_count: ArrayLike) -> Floats:
    """Largest true area of finer scans of a pair that yields, in units of F/H, from that of this scan and its contacts.

    In the mean over pairs finer scans have less. Of one pair with few contacts finer waves move the load from one to
    another, so that what is above F/H, the elastic rims of contacts that have yielded, may grow. It falls as the square
    of the elastic pressure over the hardness, and the pressure is that of κ, see `kappa_spread`. A scan of which all is
    elastic is bound by κ alone.

    Measured: all of 300 pairs of 256² points, seen with waves from 16 points to 4, with 2 to 40 contacts.
    """
    own = np.maximum(np.asarray(area, dtype=np.float64), 1.0)
    spread = kappa_spread(np.asarray(contact_count, dtype=np.float64))
    return np.asarray(np.minimum(own * spread, 1 + (own - 1) * np.square(spread)))


def with_brackets(result: xr.Dataset, hardness: float, parameters: tuple[float, float] | None) -> xr.Dataset:
    """A dataset of `resolution` with the plastic limit and the ends between which finer scans lie.

    Of friction, for a mu0 and a tau0 (GPa), where all contacts rub.
    """
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
