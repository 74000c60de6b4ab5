"""One rough body carried over another: friction under given loads at many lateral positions, and their mean."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, choice, float_array, part_of_one
from stiction._core import __version__
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE, Sums, Validity
from stiction.mechanics.half_space import half_space
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import (
    THICKNESS,
    ContactKeywords,
    ContactModel,
    Shear,
    check_modulus,
    model_of,
    shows_model,
)
from stiction.mechanics.quantities import VALIDITY, attributes_of
from stiction.studies import intervals
from stiction.studies.executors import in_order
from stiction.studies.pressing import STIFFNESS_STEP, Load, Mechanics, checked_loads, solved
from stiction.studies.traverse_surfaces import traverse_surfaces
from stiction.surfaces.pairing import lower_piece
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

SHEARS: tuple[Shear, ...] = get_args(Shear)

_JUST_BEFORE = 1e-11
"""Fraction of an approach by which the step before it is closer to first touch: beyond the tolerance of `crossing`."""

QUANTITIES = (
    "friction_coefficient", "tangential_load", "contact_area", "contact_count", "normal_stiffness", "approach",
    "share_opposing", *VALIDITY,
)  # fmt: skip

_DIMS = ("shear", "line", "offset", "load")


@shows_model
def traverse(
    upper: Profile | Sequence[Profile] | Surface,
    lower: Profile | Sequence[Profile] | Surface,
    loads: ArrayLike,
    *,
    mu0: ArrayLike,
    tau0: ArrayLike = 0.0,
    offsets: ArrayLike = 0.0,
    mechanics: Mechanics = "asperities",
    load: Load = "normal",
    compliance_share: float = 0.5,
    executor: Executor | None = None,
    progress: bool = False,
    **contact: Unpack[ContactKeywords],
) -> xarray.Dataset:
    """Friction of two profiles under given loads, in both shear directions, at lateral positions along each other.

    Parameters
    ----------
    upper, lower : Profile or list of Profile, or Surface
        The slider and what it is carried over, on the same spacing; of lists, each upper with the lower of its place:
        the lines of two maps, or surrogates.
    loads : (l,) array_like of float, mN
        Above 0, on the whole slider, or text, "10 mN" or a list of such; its nominal area is its extent times 1 µm.
    mu0 : float or (m,) array_like of float
        Molecular friction coefficient.
    tau0 : float or (t,) array_like of float, GPa
        Adhesive shear strength.
    offsets : (o,) array_like of float, µm
        Positions of the slider's first point on the lower profile, rising, rounded to whole spacings. The whole slider
        must be over the lower profile. Of surfaces (o, 2), positions (x, y) of the upper map's first point on the lower
        map, which may be negative: what lies above each other is pressed, at least 16 rows and columns.
    mechanics : {"asperities", "half-space"}
        Of profiles also elastic half-planes, `half_space` with free boundaries: bodies of one section all along their
        third direction, as grooves are.
    load : {"normal", "elastic"}
        What the loads are: of asperities each position's normal load at the onset of sliding, with what friction on
        slopes adds, or its elastic load before. Half-planes have elastic loads.
    compliance_share : float
        Of `half_space`.
    executor : concurrent.futures.Executor, optional
        Where positions are computed; a thread for each core by default.
    progress : bool
        Whether to draw a progress bar on the terminal.
    **contact
        effective_modulus, law, detection and curvature, as for `press`; but `detection` is "gap-minimum" unless it is
        given, because contacts of a single position must not depend on the grid. `shear` is both. Of half-planes
        effective_modulus and sliding alone. Of surfaces also
        `direction`, by default 0, 90, 180 and 270 degrees, and a single mu0 and tau0.

    Returns
    -------
    xarray.Dataset
        friction_coefficient, tangential_load (mN), contact_area (µm²), contact_count, normal_stiffness (mN/µm, dF_N/dδ
        over 2 % of the approach on both sides), approach (µm), share_opposing (of the load, on contacts that oppose the
        motion), the figures of `Validity`, and status, over shear, line, offset (µm) and load (mN), and over mu0 and
        tau0 (GPa) if lists of them are given. The status is "ok", "no-contact", "self-locked", "not-reached" or
        "below-range" (more than the load is carried at an approach of 0); all else is NaN unless it is "ok". Where F_N
        jumps over a load, values are between those before and behind the jump, in the proportion that carries the load.
        Of half-planes the coefficient is F_T/F_N at this pressing; approach, normal_stiffness and the figures of
        `Validity` are NaN, for a free half-plane has no approach; the status is "not-solved" where a solution did not
        reach its tolerance. Of surfaces over direction (degrees), offset and load: also lateral_load (mN) and the
        figures of `SurfaceValidity`, but no stiffness; where F_N jumps, values are those behind the jump.

    Raises
    ------
    ValueError
        If the lists differ in length, a slider is not over its lower profile at an offset, or an argument is outside
        its range.

    Examples
    --------
    >>> from stiction import cropped, self_affine, traverse, traverse_mean
    >>> upper, lower = (
    ...     self_affine(1, hurst_exponent=0.8, rms=0.05, points=4000, spacing=0.01, shortest_wavelength=0.2, side=side)
    ...     for side in ("upper", "lower")
    ... )
    >>> result = traverse(cropped(upper, 0, 20), lower, [0.01, 0.1], mu0=0.3, offsets=[0.0, 5.0, 10.0, 15.0])
    >>> dict(result.sizes)
    {'shear': 2, 'line': 1, 'offset': 4, 'load': 2}
    >>> traverse_mean(result)["friction_coefficient"].dims
    ('shear', 'load', 'statistic')
    """
    choice("mechanics", mechanics, Mechanics)
    choice("load", load, Load)
    if isinstance(upper, Surface) or isinstance(lower, Surface):
        if mechanics != "asperities":
            raise ValueError(f"mechanics of surfaces must be 'asperities', got {mechanics!r}; see pressed_maps")
        return traverse_surfaces(
            upper, lower, loads, mu0=mu0, tau0=tau0, offsets=offsets, executor=executor, progress=progress,
            load=load, contact=dict(contact),
        )  # fmt: skip
    uppers, lowers = _pairs(upper, lower)
    check_modulus(contact, *uppers, *lowers)
    model = _model(mechanics, contact)
    load_values = checked_loads(loads)
    material = {"mu0": _listed("mu0", mu0), "tau0": _listed("tau0", tau0)}
    friction.check_shear_strength(material["tau0"], model.effective_modulus)
    places = _places(offsets, uppers, lowers)
    spacing = uppers[0].spacing
    chosen: dict[str, Any] = {"loads": load_values, **material, "model": model}
    position: Any = functools.partial(_position, **chosen, load=load)
    if mechanics == "half-space":
        fraction = part_of_one("compliance_share", compliance_share)
        position = functools.partial(_half_planes, **chosen, compliance_share=fraction)
    members = [(line, place) for line in range(len(uppers)) for place in range(places.size)]
    pairs = (
        (uppers[line], lower_piece(lowers[line], places[place] * spacing, uppers[line])) for line, place in members
    )
    computed = in_order(position, pairs, total=len(members), what="positions", executor=executor, progress=progress)
    shape = len(SHEARS), len(uppers), places.size, load_values.size
    arrays = _gathered(shape, material, members, computed)
    return _dataset(arrays, uppers, lowers, np.asarray(places * spacing, np.float64), load_values, material, model, {
        "mechanics": mechanics,
        **({"compliance_share": float(compliance_share)} if mechanics == "half-space" else {
            "detection": model.detection, "law": str(model.law), "curvature": model.curvature,
        }),
    })  # fmt: skip


def _pairs(upper: Any, lower: Any) -> tuple[list[Profile], list[Profile]]:
    uppers, lowers = _profiles("upper", upper), _profiles("lower", lower)
    if len(uppers) != len(lowers):
        raise ValueError(f"upper and lower must be as many profiles, got {len(uppers)} and {len(lowers)}")
    if len({(len(each), each.spacing) for each in uppers}) > 1:
        raise ValueError("the profiles of upper must all be on the same grid, or a load would not mean the same")
    return uppers, lowers


def _model(mechanics: Mechanics, contact: Any) -> ContactModel:
    for name in ("shear", "direction"):
        if name in contact:
            raise ValueError(f"{name} must not be given: a traverse of profiles has both directions")
    if mechanics == "half-space":
        for name in contact:
            if name not in ("effective_modulus", "sliding"):
                raise ValueError(f"{name} must not be given for half-planes: it is of asperities")
    model = model_of(contact)
    return replace(model, detection=model.detection or "gap-minimum").for_profiles()


def _listed(name: str, given: ArrayLike) -> Floats:
    values = friction.friction_parameter(name, given)
    if values.ndim > 1 or not values.size:
        raise ValueError(f"{name} must be a number or a list of numbers, got {values!r}")
    return values


def _gathered(
    shape: tuple[int, ...], material: dict[str, Floats], members: list[tuple[int, int]], computed: Any
) -> dict[str, NDArray[Any]]:
    shape = (*shape, *(values.size for values in material.values() if values.ndim))
    arrays: dict[str, NDArray[Any]] = {name: np.full(shape, np.nan) for name in QUANTITIES}
    arrays["status"] = np.full(shape, friction.STATUS_OK, dtype=STATUS_DTYPE)
    for (line, place), values in zip(members, computed, strict=True):
        for name, value in values.items():
            arrays[name][:, line, place] = value.reshape(arrays[name][:, line, place].shape)
    return arrays


def _dataset(
    arrays: dict[str, NDArray[Any]],
    uppers: list[Profile],
    lowers: list[Profile],
    offsets: Floats,
    loads: Floats,
    material: dict[str, Floats],
    model: ContactModel,
    attributes: dict[str, Any],
) -> xarray.Dataset:
    import xarray

    listed = tuple(name for name, values in material.items() if values.ndim)
    dims = (*_DIMS, *listed)
    area = uppers[0].extent * THICKNESS
    coordinates: dict[str, Any] = {
        "shear": ("shear", list(SHEARS), {"long_name": "where the upper body is about to move"}),
        "line": ("line", np.arange(len(uppers)), {"units": "1", "long_name": "pair of lines"}),
        "offset": ("offset", offsets, {"units": "um", "long_name": "offset of the upper body along +x"}),
        "load": ("load", loads, attributes_of("load")),
        **{
            name: ((name,) if name in listed else (), values, attributes_of(name))
            for name, values in material.items()
        },
        "effective_modulus": ((), float(model.effective_modulus), attributes_of("effective_modulus")),
        "nominal_area": ((), area, {"units": "um^2", "long_name": "extent of the slider times 1 um"}),
    }  # fmt: skip
    variables = {name: (dims, values, attributes_of(name)) for name, values in arrays.items()}
    return xarray.Dataset(variables, coordinates, {
        "title": "stiction traverse", **attributes, "sliding": model.sliding,
        "upper": "\n".join(uppers[0].history), "lower": "\n".join(lowers[0].history),
        "stiction_version": __version__,
    })  # fmt: skip


def _position(
    pair: tuple[Profile, Profile], *, loads: Floats, mu0: Floats, tau0: Floats, model: ContactModel, load: Load
) -> Any:
    """Each quantity and the status at one position, (shear, load, mu0, tau0) each."""
    bodies = Bodies(*pair)
    shape = (len(SHEARS), loads.size, mu0.size, tau0.size)
    values = {name: np.full(shape, np.nan) for name in QUANTITIES}
    status = np.empty(shape, dtype=STATUS_DTYPE)
    for row, m, t in np.ndindex(len(SHEARS), mu0.size, tau0.size):
        directed = replace(model, shear=SHEARS[row])
        material = float(mu0.flat[m]), float(tau0.flat[t])
        carrying = material if load == "normal" else (0.0, 0.0)
        approach, status[row, :, m, t] = crossing(bodies, loads, mu0=carrying[0], tau0=carrying[1], model=directed)
        ok = np.flatnonzero(status[row, :, m, t] == friction.STATUS_OK)
        if ok.size:
            at = _at_approaches(bodies, approach[ok], loads[ok], carrying, material, directed)
            for name, value in at.items():
                values[name][row, ok, m, t] = value
    return {**values, "status": status}


def _at_approaches(
    bodies: Bodies,
    approach: Floats,
    loads: Floats,
    carrying: tuple[float, float],
    material: tuple[float, float],
    model: ContactModel,
) -> dict[str, Any]:
    """Each quantity where a position carries its loads, by friction `carrying` or by none."""
    fractions = [1 - STIFFNESS_STEP, 1 - _JUST_BEFORE, 1, 1 + STIFFNESS_STEP]
    steps, place = np.unique(np.outer(fractions, approach), return_inverse=True)
    low, before, behind, high = place.reshape(len(fractions), approach.size)
    curve = bodies.pressed(steps, model)
    normal = friction.normal_load(curve, *carrying)
    rise = loads - normal[before], normal[behind] - normal[before]
    at = rubbing = _across(curve, before, behind, rise)
    if model.sliding != "opposing":
        rubbing = _across(bodies.pressed(steps, replace(model, sliding="opposing")), before, behind, rise)
    tangential = friction.tangential_load(at, *material)
    carried = loads if carrying == material else friction.normal_load(at, *material)
    return {
        "friction_coefficient": tangential / carried,
        "tangential_load": tangential,
        "contact_area": at.contact_area,
        "contact_count": at.contact_count,
        "normal_stiffness": (normal[high] - normal[low]) / (steps[high] - steps[low]),
        "approach": approach,
        # t_x of an opposing contact is -σ n_z, so this sum per unit mu0 is their F n_z.
        "share_opposing": rubbing.tangential_frictional / rubbing.normal_elastic,
        **vars(Validity.of(at)),
    }


def _half_planes(
    pair: tuple[Profile, Profile], *, loads: Floats, mu0: Floats, tau0: Floats, model: ContactModel,
    compliance_share: float,
) -> dict[str, Any]:  # fmt: skip
    """As `_position`, of elastic half-planes."""
    shape = (len(SHEARS), loads.size, mu0.size, tau0.size)
    values: dict[str, Any] = {name: np.full(shape, np.nan) for name in QUANTITIES}
    status = np.full(shape, friction.STATUS_NOT_SOLVED, dtype=STATUS_DTYPE)
    solve = functools.partial(
        half_space, *pair, effective_modulus=model.effective_modulus, compliance_share=compliance_share,
        sliding=model.sliding,
    )  # fmt: skip
    material = {"mu0": mu0.reshape(-1, 1), "tau0": tau0.reshape(1, -1)}
    for at, solution in solved(solve, loads):
        for row, shear in enumerate(SHEARS):
            curve = solution.with_direction(shear)
            rubbing = curve.with_sliding("opposing")
            # (mu0, tau0, load), where results have the load first.
            tangential, of_curve = curve.tangential_load(**material), curve.status(**material)
            ok = of_curve == friction.STATUS_OK
            row_values = {
                "friction_coefficient": curve.friction_coefficient(**material),
                "tangential_load": tangential,
                "contact_area": curve.contact_area,
                "contact_count": curve.contact_count,
                "share_opposing": rubbing.tangential_frictional / rubbing.normal_elastic,
            }
            for name, value in row_values.items():
                values[name][row, at] = np.moveaxis(np.where(ok, value, np.nan), -1, 0)
            status[row, at] = np.moveaxis(of_curve, -1, 0)
    return {**values, "status": status}


def _across(curve: Sums, before: Any, behind: Any, rise: tuple[Floats, Floats]) -> Sums:
    """The sums of a curve at loads between two steps each: linear, as an ensemble is read off, where F_N jumps."""
    to_load, jump = rise
    share = np.clip(np.divide(to_load, jump, out=np.ones_like(jump), where=jump > 0), 0.0, 1.0)
    return curve.each(lambda values: values[before] + share * (values[behind] - values[before]))


def traverse_mean(result: xarray.Dataset) -> xarray.Dataset:
    """Means over the positions of a traverse, with 95 % intervals.

    Parameters
    ----------
    result : xarray.Dataset
        What `traverse` returns of profiles.

    Returns
    -------
    xarray.Dataset
        The quantities of the traverse over shear, load, mu0 and tau0 where there are lists of them, and statistic
        ("mean", "lower", "upper"), over those positions whose status is "ok", and over shear and load how many these
        are (ok) and how many there are (positions). A mean over some positions only is that of those which have an
        answer. The interval is NaN for fewer than 8 positions, or lines if there are several, and where all are equal.

    Notes
    -----
    All positions carry the same load, so the mean coefficient is the ratio of mean tangential to normal load.
    Neighbouring positions have asperities in common and are not independent: the interval is over all correlations of
    neighbours that the values allow. Positions on the same line are alike however far apart, so with several lines it
    is that of the means of the lines. It never goes beyond the values themselves. In trials of lognormal and bounded
    values, and of values of which half are zero, 64 positions cover 92 to 97 % for correlations up to 0.8 and are 1.0
    to 1.2 times as wide as the best that is possible; 16 cover 82 to 87 % where the correlation is 0.8, and are 1.6
    times as wide where it is 0. It says how well the mean over these two profiles is known, not what other pieces of
    the same surfaces would give; that takes more profiles, or surrogates.

    Examples
    --------
    >>> from stiction import self_affine_surface, traverse, traverse_mean
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> result = traverse([upper.row(0)], [lower.row(0)], ["10 uN"], mu0=0.3)
    >>> traverse_mean(result)["contact_area"].dims
    ('shear', 'load', 'statistic')
    """
    import xarray

    others = tuple(name for name in ("mu0", "tau0") if name in result.dims)
    if "direction" in result.dims:
        raise ValueError("result must be a traverse of profiles, got one of surfaces")
    data = result.transpose("shear", "load", *others, "line", "offset")
    shape = tuple(data.sizes[name] for name in ("shear", "load", *others))
    ok = data["status"].values == friction.STATUS_OK
    lines = np.repeat(np.arange(data.sizes["line"]), data.sizes["offset"])
    means = {}
    for name in QUANTITIES:
        values = data[name].values
        statistics = np.full((*shape, 3), np.nan)
        for at in np.ndindex(shape):
            known = ok[at].ravel()
            statistics[at] = intervals.of_positions(values[at].ravel()[known], lines[known])
        means[name] = (("shear", "load", *others, "statistic"), statistics, dict(data[name].attrs))
    counts = {
        "ok": (
            ("shear", "load", *others), ok.sum(axis=(-2, -1)),
            {"units": "1", "long_name": "positions that have an answer"},
        ),
        "positions": ((), ok.shape[-2] * ok.shape[-1], {"units": "1", "long_name": "positions"}),
    }  # fmt: skip
    kept = {name: each.variable for name, each in data.coords.items() if name not in ("line", "offset")}
    return xarray.Dataset(means | counts, kept | {"statistic": ["mean", "lower", "upper"]}, dict(result.attrs))


def _profiles(name: str, value: Profile | Sequence[Profile]) -> list[Profile]:
    profiles = [value] if isinstance(value, Profile) else list(value)
    if not profiles or not all(isinstance(each, Profile) for each in profiles):
        raise ValueError(f"{name} must be a Profile or a list of them, got {type(value).__name__}")
    return profiles


def _places(offsets: ArrayLike, uppers: list[Profile], lowers: list[Profile]) -> NDArray[np.intp]:
    """Offsets in whole spacings, at which every slider is over its lower profile."""
    spacing = uppers[0].spacing
    values = np.atleast_1d(float_array("offsets", offsets))
    if values.ndim != 1 or not values.size or not (values >= 0).all() or not (np.diff(values) > 0).all():
        raise ValueError(f"offsets must be numbers of at least 0 µm that rise, got {offsets!r}")
    places = np.rint(values / spacing).astype(np.intp)
    if not (np.diff(places) > 0).all():
        raise ValueError(
            f"offsets must be at least a spacing apart, {spacing:g} µm, got {values.size} offsets of which two are "
            f"{np.diff(values).min():.3g} µm apart"
        )
    for line, (above, below) in enumerate(zip(uppers, lowers, strict=True)):
        if places[-1] + len(above) > len(below):
            raise ValueError(
                f"the slider must be over the lower profile: line {line} has {above.extent:g} µm of it and "
                f"{below.extent:g} µm below, so that offsets are at most {(len(below) - len(above)) * spacing:g} µm, "
                f"got {places[-1] * spacing:g} µm"
            )
    return places
