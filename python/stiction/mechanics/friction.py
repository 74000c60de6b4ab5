"""Friction as linear algebra: F = elastic + mu0 frictional + tau0 adhesive, for both components of the load.

Hanaor, Gan & Einav (2016), Eqs. 6 and 7 and section 2.5. The functions take any arrays that broadcast, NumPy's or
xarray's, so that a curve, an ensemble and a map go the same way.
"""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array, number

STATUS_OK = "ok"
STATUS_SELF_LOCKED = "self-locked"
STATUS_NO_CONTACT = "no-contact"
STATUS_NOT_REACHED = "not-reached"
STATUS_BELOW_RANGE = "below-range"

SHEAR_STRENGTH_LIMIT = 0.1
"""tau0/E* above which tau0 is nearly always MPa given as GPa."""


def normal_load(sums: Any, mu0: Any, tau0: Any) -> Any:
    """F_N in mN for mu0 (dimensionless) and tau0 in GPa, of whatever carries the six sums."""
    return sums.normal_elastic + mu0 * sums.normal_frictional + tau0 * sums.normal_adhesive


def tangential_load(sums: Any, mu0: Any, tau0: Any) -> Any:
    """F_T in mN for mu0 (dimensionless) and tau0 in GPa, of whatever carries the six sums."""
    return sums.tangential_elastic + mu0 * sums.tangential_frictional + tau0 * sums.tangential_adhesive


def status_of(contact_count: ArrayLike, normal: Floats) -> NDArray[np.str_]:
    """'no-contact' where there is none, else 'self-locked' where F_N <= 0, else 'ok'."""
    locked = np.where(normal > 0, STATUS_OK, STATUS_SELF_LOCKED)
    return np.where(np.asarray(contact_count) == 0, STATUS_NO_CONTACT, locked)


def friction_parameter(name: str, values: ArrayLike) -> Floats:
    """mu0 or tau0 as an array of finite numbers that are not negative."""
    array = float_array(name, values)
    if not (array >= 0).all():
        raise ValueError(f"{name} must not be negative, got {values!r}")
    return array


def check_shear_strength(tau0: Floats, effective_modulus: float) -> None:
    """Warn of a tau0 that is nearly always MPa given as GPa."""
    highest = float(np.max(tau0, initial=0))
    if highest > SHEAR_STRENGTH_LIMIT * effective_modulus:
        warnings.warn(
            f"tau0 = {highest:g} GPa is above a tenth of the effective modulus {effective_modulus:g} GPa; "
            "is it in MPa?",
            stacklevel=3,
        )


def one_material(mu0: Any, tau0: Any, effective_modulus: Any) -> tuple[float, float]:
    """A single mu0 and a single tau0 (GPa), checked as arrays of them are."""
    values = [
        float(friction_parameter(name, number(name, value, unit=unit)))
        for name, value, unit in (("mu0", mu0, ""), ("tau0", tau0, "GPa"))
    ]
    modulus = number("effective_modulus", effective_modulus, unit="GPa", above=0)
    check_shear_strength(np.asarray(values[1]), modulus)
    return values[0], values[1]
