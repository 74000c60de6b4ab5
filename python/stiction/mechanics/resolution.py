"""How an answer depends on the finest wave that was seen, and the limit that a hardness sets to it."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import Floats, float_array, number
from stiction.mechanics import brackets
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.friction import SIX, friction_parameter, load_of
from stiction.mechanics.half_space import Boundary, half_space, solved
from stiction.mechanics.model import EFFECTIVE_MODULUS, Direction, Sliding, check_pair, modulus_for
from stiction.mechanics.quantities import attributes_of
from stiction.surfaces.cut_off import MAX_CUTOFF_FRACTION, cut_off
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import ScaleDependentRoughness, instrument_limit, scale_dependent_roughness
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray as xr

TYPICAL_HARDNESSES = (0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0)
"""GPa, from polymers and soft metals to ceramics: where none is given, each has a wavelength at which it is reached."""

_COARSEST = 1 / 30  # longest cut-off by default, in shortest sides
_RULES: tuple[Sliding, ...] = ("all", "opposing")  # all contacts first, because mu0 is measured on faces where all rub
_AROUND = (0.0, 90.0, 180.0, 270.0)
_AT_HARDNESS = "wavelength at which the elastic mean pressure reaches the hardness"
KAPPA = 2.2  # A E* h'/F at light load: 2.1 to 2.4 on Gaussian areas
_NUMBERS = ("contact_area", "contact_count", "load_share_at_hardness", "error")  # numbers of a curve
_NAMES = {
    "load_share_at_hardness": "load_fraction_at_hardness"
}  # variables of the result that have another name beside its sums


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
    boundary: Boundary = "free",
    compliance_share: float = 0.5,
    direction: Direction | Sequence[Direction] | None = None,
    tip_radius: float | None = None,
    tolerance: float = 1e-6,
    progress: Callable[[int, int], object] | None = None,
) -> xr.Dataset:
    r"""Area, pressure and friction of a pair over cut-off wavelengths, and the plastic limit of any finer scan.

    Parameters
    ----------
    upper, lower : Profile or Surface
        As for `half_space`.
    loads : (k,) array_like of float, mN
        Above 0 and strictly increasing.
    hardness : float, GPa, or None
        Of the softer body, the most that the pressure can be. None is elastic: then the answer has no limit, and the
        dataset says for typical hardnesses from which wavelength on it cannot be.
    cut_offs : float or sequence of float, µm, optional
        Wavelengths for `cut_off`, 0 being the scan as it is, which is always there. By default 0, four points and its
        doubles up to a thirtieth of the shortest side.
    mu0, tau0 : float, GPa for tau0
        With a mu0, friction is evaluated; the sums serve any other, see `resolution_friction`.
    effective_modulus, boundary, compliance_share, tolerance
        As for `half_space`.
    direction : {"+x", "-x"} or float, or a sequence of these, optional
        Over which friction is averaged, its loads one by one: by default the four sides of an area, both of a line.
    tip_radius : float, µm, optional
        Of the instrument, for `instrument_limit`.
    progress : callable, optional
        Called with how many solutions are there and how many there will be.

    Returns
    -------
    xarray.Dataset
        Over `cut_off` (µm), `normal_load` (mN) and `sliding` ("all", "opposing"): `rms_gradient` of the gap,
        `contact_area`, `contact_area_fraction`, `mean_pressure`, `contact_count`, `load_fraction_at_hardness`, the six
        sums, and with a mu0 `friction_coefficient`. NaN where no solution was found.

        Over `normal_load`: `elastic_kappa`, and with a hardness `plastic_area`, `plastic_area_fraction` and
        `plastic_friction_coefficient`: what no finer scan can pass.

        With a hardness, over cut-offs, loads and `end` ("lower", "upper"): `bracket_area_fraction` and, of "all",
        `bracket_friction_coefficient`, between which every finer scan of this pair lies.

        Over `hardness` (GPa), `normal_load` and `statistic` (value, lower, upper): `plastic_wavelength` (µm), at which
        the mean pressure of the elastic answer reaches the hardness; the longest where even
        that does, NaN where the power law never does.

        The attributes have the wavelength below which the scans are of the instrument, the Hurst exponent of the gap
        with its interval, and the histories.

        Over `finer_wavelength` (µm) and `statistic`: `continued_rms_gradient`, and over loads too
        `continued_elastic_area_fraction` and `continued_elastic_friction_coefficient` ("all"), by the Hurst exponent.

    Raises
    ------
    ValueError
        As `half_space` and `cut_off`, or if the bodies touch everywhere alike.

    Notes
    -----
    A finer scan has steeper slopes, so that the elastic area, :math:`A = κ F/(E^* h')`, never settles. Pressures are
    capped by the hardness H from the wavelength on at which :math:`h'(λ) = κ H/E^*`, and with it

    .. math:: F/H \le A \le A_{scan}, \qquad μ_0 + τ_0/H \le μ_s \le μ_{s,scan}

    in the mean over pairs where all contacts rub, but for terms of second order in slopes. Of one pair with n contacts
    the bracket ends not at A but at :math:`F/H + (A - F/H)\,e^{2/\sqrt n}`, and 1/√n is at least 0.1. The opposing
    rule's slope term has no such limit: its number belongs to a resolution. Finer than the fitted band, h' is continued
    by the gap's Hurst exponent, within its interval and, the fewer contacts, a larger factor on κ.

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
    effective_modulus = modulus_for(effective_modulus, upper, lower)
    pair = _Pair(upper, lower, boundary)
    lengths = pair.cut_offs(cut_offs)
    if hardness is not None:
        hardness = number("hardness", hardness, unit="GPa", above=0)
    parameters = None if mu0 is None else _strengths(mu0, tau0)
    areal = isinstance(upper, Surface)
    if direction is None:
        direction = _AROUND if areal else ("+x", "-x")
    along: tuple[Direction, ...] = tuple(direction) if np.ndim(direction) else (direction,)  # type: ignore[assignment,arg-type]
    options: dict[str, Any] = {
        "effective_modulus": effective_modulus, "boundary": boundary, "compliance_share": compliance_share,
        "direction": along if areal else along[0], "sliding": "all", "tolerance": tolerance,
    }  # fmt: skip
    steps = float_array("loads", loads, ndim=1)
    tell = progress or (lambda done, of: None)
    count = len(lengths) + (hardness is not None)
    answers = []
    for done, length in enumerate(lengths):
        tell(done, count)
        answers.append(_answer(*pair.cut_off_at(length), steps, along, hardness=hardness, **options))
    elastic = answers[0]
    if hardness is not None:
        tell(len(lengths), count)
        elastic = _answer(upper, lower, steps, along, hardness=None, **options)
    tell(count, count)
    result = _over_cut_offs(pair, lengths, steps, answers, effective_modulus, hardness)
    if parameters is not None:
        result = result.assign(friction_coefficient=resolution_friction(result, mu0=parameters[0], tau0=parameters[1]))
    rough = [body for body in (upper, lower) if not body.is_flat]
    limits = [instrument_limit(body, tip_radius=tip_radius, periodic=pair.periodic) for body in rough]
    worst = max(limits, key=lambda limit: limit.wavelength)
    result.attrs |= {"instrument_limit_um": worst.wavelength, "instrument_limit_reason": worst.reason}
    return _with_limits(result, pair, steps, elastic, effective_modulus, hardness, parameters)


def resolution_friction(result: xr.Dataset, *, mu0: float, tau0: float = 0.0) -> xr.DataArray:
    """mu_s of a dataset of `resolution` for any mu0 and tau0 (GPa), the loads of its directions averaged one by one.

    Examples
    --------
    >>> from stiction import resolution, resolution_friction, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (128, 128), "spacing": 0.02}
    >>> upper, lower = (self_affine_surface(1, side=side, **rough) for side in ("upper", "lower"))
    >>> found = resolution(upper, lower, [0.1], hardness=4.0, effective_modulus=100.0, cut_offs=[])
    >>> resolution_friction(found, mu0=0.3).sel(sliding="all").values.round(2)
    array([[0.3]])
    """
    mu, tau = _strengths(mu0, tau0)
    normal, tangential = (load_of(load, result, mu, tau) for load in ("normal", "tangential"))
    mu_s = np.divide(tangential, normal, out=np.full_like(normal, np.nan), where=normal > 0)
    found = result.normal_elastic.copy(data=mu_s)
    found.attrs = {"units": "1", "long_name": "coefficient of static friction", "mu0": mu, "tau0_GPa": tau}
    ordered: xr.DataArray = found.transpose("sliding", "cut_off", "normal_load")
    return ordered


def _strengths(mu0: Any, tau0: Any) -> tuple[float, float]:
    mu, tau = (float(friction_parameter(name, number(name, each))) for name, each in (("mu0", mu0), ("tau0", tau0)))
    return mu, tau


# ---- Solving --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class _Pair:
    upper: Profile | Surface
    lower: Profile | Surface
    boundary: Boundary

    @property
    def periodic(self) -> bool:
        return self.boundary == "periodic"

    @property
    def nominal_area(self) -> float:
        """µm²; a profile is 1 µm thick."""
        return math.prod(self.upper.spacings) * self.upper.heights.size

    @property
    def shortest(self) -> float:
        """µm, two points of the coarser spacing."""
        return 2 * max(self.upper.spacings)

    def gap(self, upper: Profile | Surface, lower: Profile | Surface) -> Profile | Surface:
        return replace(upper, heights=upper.heights - lower.heights, history=())

    def cut_offs(self, wanted: float | Sequence[float] | None) -> list[float]:
        side = min(size * step for size, step in zip(self.upper.heights.shape, self.upper.spacings, strict=True))
        if wanted is None:
            doubles = 2 * self.shortest * 2.0 ** np.arange(40)
            return [0.0, *doubles[doubles <= _COARSEST * side * (1 + 1e-9)].tolist()]
        lengths = float_array("cut_offs", np.atleast_1d(wanted), ndim=1).tolist()
        if any(each != 0 and not self.shortest * (1 - 1e-9) <= each <= MAX_CUTOFF_FRACTION * side for each in lengths):
            raise ValueError(
                f"cut_offs must be 0 or from two points, {self.shortest:g} µm, to a third of the shortest side, "
                f"{MAX_CUTOFF_FRACTION * side:g} µm, got {wanted!r}"
            )
        return sorted({0.0, *lengths})

    def cut_off_at(self, length: float) -> tuple[Any, Any]:
        if length == 0:
            return self.upper, self.lower
        return tuple(
            body if body.is_flat else cut_off(body, length, periodic=self.periodic) for body in (self.upper, self.lower)
        )  # type: ignore[return-value]


def _answer(upper: Any, lower: Any, loads: Floats, along: tuple[Direction, ...], **options: Any) -> dict[str, Floats]:
    """Numbers (load,) and six sums (rule, load), means over directions, by name; NaN where no solution is found."""
    found = {name: np.full(loads.size, np.nan) for name in _NUMBERS}
    found |= {name: np.full((len(_RULES), loads.size), np.nan) for name in SIX}
    for at, curve in solved(functools.partial(half_space, upper, lower, **options), loads):
        for name in _NUMBERS:
            found[name][at] = getattr(curve, name)
        for rule, sliding in enumerate(_RULES):
            by_rule = curve if sliding == curve.sliding else curve.with_sliding(sliding)
            ways = [by_rule] if curve.direction.ndim else [by_rule.with_direction(each) for each in along]
            for name in SIX:
                found[name][rule, at] = np.mean([np.atleast_2d(getattr(each, name)) for each in ways], axis=(0, 1))
    return found


# ---- Over cut-offs --------------------------------------------------------------------------------------------------


def _over_cut_offs(
    pair: _Pair, lengths: list[float], loads: Floats, answers: list[dict[str, Floats]], modulus: float,
    hardness: float | None,
) -> xr.Dataset:  # fmt: skip
    """Areas, pressures and sums, NaN where there is no solution."""
    import xarray as xr

    gaps = [pair.gap(*pair.cut_off_at(length)) for length in lengths]
    gradient = np.array([brackets.rms_gradient(gap, periodic=pair.periodic) for gap in gaps])
    over = {name: np.array([each[name] for each in answers]) for name in (*_NUMBERS, *SIX)}
    area = over["contact_area"]
    with np.errstate(divide="ignore", invalid="ignore"):
        over |= {"contact_area_fraction": area / pair.nominal_area, "mean_pressure": loads / area}
        kappa = area * modulus * gradient[:, np.newaxis] / loads
    grid = ("cut_off", "normal_load")
    variables: dict[str, Any] = {
        "shortest_wavelength": (
            "cut_off", [max(each, pair.shortest) for each in lengths], _said("µm", "shortest wave seen")
        ),
        "rms_gradient": ("cut_off", gradient, attributes_of("rms_gradient")),
        "kappa": (grid, kappa, _said("1", "A E* h'/F")),
        **{_NAMES.get(name, name): (grid, each, attributes_of(name)) for name, each in over.items() if name not in SIX},
        **{name: (("sliding", *grid), np.moveaxis(over[name], 1, 0), attributes_of(name)) for name in SIX},
    }  # fmt: skip
    return xr.Dataset(
        variables,
        coords={
            "cut_off": ("cut_off", lengths, _said("µm", "wavelength cut off, 0 for none")),
            "normal_load": ("normal_load", loads, _said("mN", "elastic normal load")),
            "sliding": ("sliding", list(_RULES), {"long_name": "which contacts rub"}),
        },
        attrs={
            "model": "elastic half-space" + (", perfectly plastic at the hardness" if hardness is not None else ""),
            "effective_modulus_GPa": modulus, "hardness_GPa": math.nan if hardness is None else hardness,
            "nominal_area_um2": pair.nominal_area, "boundary": pair.boundary,
            "upper_history": "; ".join(pair.upper.history), "lower_history": "; ".join(pair.lower.history),
        },
    )  # fmt: skip


def _said(unit: str, text: str) -> dict[str, str]:
    return {"units": unit, "long_name": text}


# ---- Limits ---------------------------------------------------------------------------------------------------------


def _with_limits(
    result: xr.Dataset, pair: _Pair, loads: Floats, elastic: dict[str, Floats], modulus: float, hardness: float | None,
    parameters: tuple[float, float] | None,
) -> xr.Dataset:  # fmt: skip
    """The plastic limit, the wavelength at which it is reached, and the elastic answer down to it."""
    gap = pair.gap(pair.upper, pair.lower)
    roughness = scale_dependent_roughness(gap, periodic=pair.periodic)
    estimate = brackets.gap_exponent(gap, pair.periodic)
    area = elastic["contact_area"]
    kappa = area * modulus * float(result.rms_gradient[0]) / loads
    spread = brackets.kappa_spread(elastic["contact_count"])
    if hardness is not None:
        result = brackets.with_brackets(result, hardness, parameters)
    hardnesses = TYPICAL_HARDNESSES if hardness is None else (hardness,)
    steep = [zip(kappa * each / modulus, spread, strict=True) for each in hardnesses]
    reached = np.array([[brackets.plastic_wavelength(roughness, estimate, *one) for one in each] for each in steep])
    own = float(result.rms_gradient[0])
    gradients = brackets.continued(roughness, estimate, pair.shortest, own)
    flat = kappa * loads / (modulus * pair.nominal_area * brackets.interface_stretch(np.array(own)))
    ground = brackets.elastic_area(gradients, flat, spread)
    middle = gradients[:, :1, np.newaxis]  # steepness hardly differs within the interval
    grid = ("finer_wavelength", "normal_load", "statistic")
    tables: dict[str, tuple[Any, Floats, str, str]] = {
        "elastic_kappa": (grid[1], kappa, "1", "A E* h'/F of the elastic answer at the scan"),
        "elastic_area_fraction": (
            grid[1], area / pair.nominal_area, "1", "true over nominal area of the elastic answer"
        ),
        "plastic_wavelength": (("hardness", *grid[1:]), reached, "µm", _AT_HARDNESS),
        "continued_rms_gradient": (grid[::2], gradients, "1", "gradient of the gap by its Hurst exponent"),
        "continued_elastic_area_fraction": (
            grid, ground * brackets.interface_stretch(middle), "1", "elastic true over nominal area by the same"
        ),
    }  # fmt: skip
    if parameters is not None:
        friction = parameters[0] + parameters[1] * ground * pair.nominal_area / loads[:, np.newaxis]
        friction = friction * brackets.friction_stretch(middle, roughness.dimensions)
        words = "elastic mu_s by the same where all contacts rub"
        tables["continued_elastic_friction_coefficient"] = grid, friction, "1", words
    finer = np.array(brackets.FINER) * pair.shortest
    variables = {name: (dims, values, _said(unit, words)) for name, (dims, values, unit, words) in tables.items()}
    found = result.assign(variables).assign_coords(
        hardness=("hardness", list(hardnesses), _said("GPa", "hardness")),
        statistic=("statistic", ["value", "lower", "upper"]),
        finer_wavelength=("finer_wavelength", finer, _said("µm", "shortest wave of a finer scan")),
    )
    if estimate is not None:
        found.attrs |= {
            "hurst_exponent": estimate.value, "hurst_exponent_lower": estimate.lower,
            "hurst_exponent_upper": estimate.upper, "hurst_caution": estimate.caution or "",
            "band_um": (estimate.shortest_wavelength, estimate.longest_wavelength),
        }  # fmt: skip
    return found


# ---- From spectra alone, by the closed form of the slopes ------------------------------------------------------------


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
    friction = [
        gentle_friction(
            mu0, tau0, rms_gradient=gradient, effective_modulus=modulus, kappa=area * modulus * gradient / p,
            sliding=rule, slope_ratio=ratio,
        )
        for rule in _RULES
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
            "plastic_wavelength": ((), reached, _said("µm", _AT_HARDNESS)),
        },
        coords={
            "wavelength": ("wavelength", lengths, _said("µm", "shortest wave that is counted")),
            "sliding": ("sliding", list(_RULES), {"long_name": "which contacts rub"}),
        },
        attrs={"pressure_GPa": p, "hardness_GPa": float(most), "effective_modulus_GPa": modulus, "kappa": factor},
    )  # fmt: skip
