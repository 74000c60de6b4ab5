"""Area, pressure and friction over the cut-off by the closed form of the slopes, from spectra alone."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import float_array, number
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.model import EFFECTIVE_MODULUS, Sliding
from stiction.mechanics.quantities import attributes_of
from stiction.surfaces.scale import ScaleDependentRoughness

if TYPE_CHECKING:
    import xarray as xr

KAPPA = 2.2  # A E* h'/F at light load: 2.1 to 2.4 on Gaussian areas


def spectral_resolution(
    upper: ScaleDependentRoughness,
    lower: ScaleDependentRoughness | None,
    *,
    pressure: float,
    hardness: float | None,
    mu0: float,
    tau0: float = 0.0,
    effective_modulus: float = EFFECTIVE_MODULUS,
    kappa: float = KAPPA,
    wavelengths: ArrayLike | None = None,
) -> xr.Dataset:
    r"""True area and friction of two rough areas over the shortest wave that is counted; nothing is solved.

    Parameters
    ----------
    upper, lower : ScaleDependentRoughness
        Of areas, as `scale_dependent_roughness` or the `roughness` of a `JoinedSpectrum` gives them; a lower of None is
        flat.
    pressure : float, GPa
        Load over nominal area, above 0.
    hardness : float, GPa, or None
        Of the softer body, above the pressure; None is elastic.
    mu0, tau0 : float, GPa for tau0
    effective_modulus : float, GPa
    kappa : float
        A E* h'/F of the elastic answer.
    wavelengths : array_like of float, µm, optional
        By default those of both bodies.

    Returns
    -------
    xarray.Dataset
        Over `wavelength` (µm, falling): `rms_gradient` of the gap, `contact_area_fraction`, `mean_pressure`, and over
        `sliding` ("all", "opposing") `friction_coefficient`. `plastic_wavelength` (µm) is where the elastic pressure
        reaches the hardness, NaN if it does not.

    Notes
    -----
    .. math:: h'^2 = h'^2_u + h'^2_l, \qquad A/A_0 = \max(κ p/(E^* h'),\; p/H) \le 1, \qquad μ_s = μ_0 + τ_0 A/F

    where all contacts rub, and `gentle_friction` where opposing ones do. Independent, Gaussian, isotropic bodies at
    light load. About the wavelength at which both parts are equal, a half-space of the same hardness has some tenths
    more area, because a part of it yields already.

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
            raise ValueError("upper and lower must be the ScaleDependentRoughness of areas")
    p = number("pressure", pressure, unit="GPa", above=0)
    most = np.inf if hardness is None else number("hardness", hardness, unit="GPa", above=p)
    modulus = number("effective_modulus", effective_modulus, unit="GPa", above=0)
    factor = number("kappa", kappa, above=0)
    if wavelengths is None:
        wavelengths = np.concatenate([body.wavelength for body in bodies])
    lengths = np.unique(float_array("wavelengths", wavelengths, ndim=1))[::-1]
    slopes = np.array([body.gradient_at(lengths) for body in bodies])
    gradient = np.sqrt(np.square(slopes).sum(axis=0))
    rough = gradient > 0
    lengths, slopes, gradient = lengths[rough], slopes[:, rough], gradient[rough]
    if not lengths.size:
        raise ValueError(f"wavelengths must be at most the longest of the bodies, got {wavelengths!r}")
    area = np.minimum(np.maximum(factor * p / (modulus * gradient), p / most), 1.0)
    ratio = slopes.min(axis=0) / slopes.max(axis=0) if lower is not None else np.zeros(lengths.size)
    rules: tuple[Sliding, ...] = ("all", "opposing")
    friction = [
        gentle_friction(
            mu0, tau0, rms_gradient=gradient, effective_modulus=modulus, kappa=area * modulus * gradient / p,
            sliding=rule, slope_ratio=ratio,
        )
        for rule in rules
    ]  # fmt: skip
    elastic = np.flatnonzero(modulus * gradient / factor >= most)
    reached = float(lengths[elastic[0]]) if elastic.size else np.nan
    values = {"rms_gradient": gradient, "contact_area_fraction": area, "mean_pressure": p / area}
    return xr.Dataset(
        {
            **{name: ("wavelength", each, attributes_of(name)) for name, each in values.items()},
            "friction_coefficient": (
                ("sliding", "wavelength"), np.array(friction), attributes_of("friction_coefficient"),
            ),
            "plastic_wavelength": (
                (), reached,
                {"units": "µm", "long_name": "wavelength at which the elastic mean pressure reaches the hardness"},
            ),
        },
        coords={
            "wavelength": ("wavelength", lengths, {"units": "µm", "long_name": "shortest wave that is counted"}),
            "sliding": ("sliding", ["all", "opposing"], {"long_name": "which contacts rub"}),
        },
        attrs={"pressure_GPa": p, "hardness_GPa": float(most), "effective_modulus_GPa": modulus, "kappa": factor},
    )  # fmt: skip
