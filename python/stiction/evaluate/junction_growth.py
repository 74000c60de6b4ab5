"""Effect of junction growth, the growth of the true area under shear, on the values of members."""

from __future__ import annotations

from collections.abc import Collection
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.evaluate.contact_area import build_area_functions
from stiction.evaluate.maps import MOTION_DIMENSIONS, find_cell_dimensions
from stiction.mechanics import friction
from stiction.mechanics.closed_forms import hardness_under_shear
from stiction.mechanics.quantities import is_requested, quantity_attributes
from stiction.solve.member_sums import MemberSums

if TYPE_CHECKING:
    import xarray

ADHESIVE_SUMS = ("normal_adhesive", "tangential_adhesive")  # contact sums that increase with junction growth


def compute_area_growth_ratio(result: MemberSums, loads: Floats, mu0: Floats, tau0: Floats) -> Floats:
    """Return the ratio of the true area at the onset of sliding to the true area before shear.

    The ratio has the shape (cells, loads, mu0, tau0), and is infinite at seizure: H' is NaN, or the nominal area cannot
    carry the load at H'. The pressure H' is also applied to contacts that do not oppose the motion, so that the ratio
    is an upper bound under the sliding rule "opposing".
    """
    areas, alpha = result.compute_once(build_area_functions), float(result.study.contact.junction_growth or 0)
    hardness = areas[0].hardness
    assert hardness is not None, "contacts that do not yield do not grow"
    pressure = hardness_under_shear(hardness, mu0[:, np.newaxis], tau0, alpha)
    loads = loads[:, np.newaxis, np.newaxis]
    is_carried = pressure > loads / areas[0].nominal_area
    grown_areas = [area(loads, hardness=np.where(is_carried, pressure, hardness)) / area(loads) for area in areas]
    return np.where(is_carried, np.stack(grown_areas), np.inf)


def apply_junction_growth(
    members: xarray.Dataset, result: MemberSums, names: Collection[str] | None = None
) -> xarray.Dataset:
    """Recompute member values after junction growth. The adhesive forces then act on the grown contact area."""
    mu0, tau0 = members["mu0"].values, members["tau0"].values
    growth_ratios = compute_area_growth_ratio(result, members["load"].values, mu0, tau0)
    with np.errstate(invalid="ignore"):
        added_strength = np.where(tau0 > 0, tau0 * (growth_ratios - 1), 0.0)[:, np.newaxis, np.newaxis, np.newaxis]
    dims = (*find_cell_dimensions(members), "repetition", *MOTION_DIMENSIONS, "load", "mu0", "tau0")
    with np.errstate(invalid="ignore"):
        normal, tangential = (
            members[f"{name}_load"].transpose(*dims).values
            + added_strength * members[f"{name}_adhesive"].transpose(*dims[:-2]).values[..., np.newaxis, np.newaxis]
            for name in ("normal", "tangential")
        )
    status = members["status"].transpose(*dims).values.copy()
    has_coefficient = status == friction.STATUS_OK
    status[has_coefficient & (normal <= 0)] = friction.STATUS_SELF_LOCKED
    status[has_coefficient & np.isinf(added_strength)] = friction.STATUS_SEIZURE
    with np.errstate(invalid="ignore", divide="ignore"):
        coefficient = np.where(status == friction.STATUS_OK, tangential / normal, np.nan)
    values = {
        "friction_coefficient": coefficient, "normal_load": normal, "tangential_load": tangential, "status": status
    }  # fmt: skip
    grown_variables: dict[str, Any] = {name: (dims, each, members[name].attrs) for name, each in values.items()}
    if is_requested("contact_area_at_onset", names):
        growth_at_onset = np.where(np.isfinite(growth_ratios), growth_ratios, np.nan)[:, np.newaxis]
        area_dims = tuple(dim for dim in dims if dim not in MOTION_DIMENSIONS)
        area = members["contact_area"].transpose(*area_dims[:-2]).values[..., np.newaxis, np.newaxis] * growth_at_onset
        grown_variables["contact_area_at_onset"] = (area_dims, area, quantity_attributes("contact_area_at_onset"))
    return members.drop_vars(ADHESIVE_SUMS).assign(grown_variables)
