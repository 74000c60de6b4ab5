"""One rough body carried over another: friction under given loads at many lateral positions, and their mean."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Unpack, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, choice, part_of_one
from stiction._core import __version__
from stiction.mechanics import friction
from stiction.mechanics.model import (
    THICKNESS,
    ContactKeywords,
    ContactModel,
    Shear,
    check_modulus,
    check_pair,
    model_of,
    shows_model,
)
from stiction.mechanics.quantities import AREAL_VALIDITY, VALIDITY, attributes_of
from stiction.studies import intervals
from stiction.studies.executors import in_order
from stiction.studies.positions import Asked, Pair, overlap, places_on_lines, places_on_maps
from stiction.studies.pressing import Load, Mechanics, checked_loads
from stiction.surfaces.pairing import lower_piece
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

SHEARS: tuple[Shear, ...] = get_args(Shear)

DIRECTIONS = (0.0, 90.0, 180.0, 270.0)
"""Degrees, of surfaces, if none are asked for."""

QUANTITIES = (
    "friction_coefficient", "tangential_load", "contact_area", "contact_count", "normal_stiffness", "approach",
    "share_opposing", *VALIDITY,
)  # fmt: skip

_OF_SURFACES = (
    "friction_coefficient", "tangential_load", "lateral_load", "contact_area", "contact_count", "approach", *VALIDITY,
    *AREAL_VALIDITY,
)  # fmt: skip


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
        effective_modulus and sliding alone. Of surfaces also `direction`, by default 0, 90, 180 and 270 degrees.

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
        positions = _on_maps(upper, lower, offsets, contact)
    else:
        positions = _on_lines(upper, lower, offsets, contact, mechanics)
    model = positions.models[0]
    material = {"mu0": _listed("mu0", mu0), "tau0": _listed("tau0", tau0)}
    friction.check_shear_strength(material["tau0"], model.effective_modulus)
    fraction = part_of_one("compliance_share", compliance_share) if mechanics == "half-space" else None
    asked = Asked(checked_loads(loads), load, **material, models=positions.models, compliance_share=fraction)
    count = int(np.prod(list(positions.sizes.values())))
    computed = in_order(asked.at, positions.pairs, total=count, what="positions", executor=executor, progress=progress)
    of_asperities = {"detection": model.detection, "law": str(model.law), "curvature": model.curvature}
    return _dataset(positions, asked, material, list(computed)).assign_attrs(
        mechanics=mechanics, **(of_asperities if fraction is None else {"compliance_share": fraction}),
        sliding=model.sliding, **positions.histories, stiction_version=__version__,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Positions:
    """Pairs at every position, the models of every motion, and what a dataset says of them."""

    models: tuple[ContactModel, ...]
    pairs: Iterator[Pair]
    sizes: dict[str, int]  # dimensions of the positions
    names: tuple[str, ...]  # of the quantities
    coordinates: dict[str, Any]  # of motions first
    histories: dict[str, str]


def _on_lines(upper: Any, lower: Any, offsets: ArrayLike, contact: Any, mechanics: Mechanics) -> _Positions:
    uppers, lowers = _profiles("upper", upper), _profiles("lower", lower)
    if len(uppers) != len(lowers):
        raise ValueError(f"upper and lower must be as many profiles, got {len(uppers)} and {len(lowers)}")
    if len({(len(each), each.spacing) for each in uppers}) > 1:
        raise ValueError("the profiles of upper must all be on the same grid, or a load would not mean the same")
    check_modulus(contact, *uppers, *lowers)
    for name in ("shear", "direction"):
        if name in contact:
            raise ValueError(f"{name} must not be given: a traverse of profiles has both directions")
    if mechanics == "half-space" and (wrong := contact.keys() - {"effective_modulus", "sliding"}):
        raise ValueError(f"{min(wrong)} must not be given for half-planes: it is of asperities")
    model = model_of(contact)
    model = replace(model, detection=model.detection or "gap-minimum").for_profiles()
    offset = places_on_lines(offsets, uppers, lowers) * uppers[0].spacing
    area = uppers[0].extent * THICKNESS
    return _Positions(
        tuple(replace(model, shear=shear) for shear in SHEARS),
        ((above, lower_piece(below, at, above)) for above, below in zip(uppers, lowers, strict=True) for at in offset),
        {"line": len(uppers), "offset": offset.size},
        QUANTITIES,
        {
            "shear": ("shear", list(SHEARS), {"long_name": "where the upper body is about to move"}),
            "line": ("line", np.arange(len(uppers)), attributes_of("line")),
            "offset": ("offset", offset, {"units": "um", "long_name": "offset of the upper body along +x"}),
            "nominal_area": ((), area, {"units": "um^2", "long_name": "extent of the slider times 1 um"}),
        },
        {"upper": "\n".join(uppers[0].history), "lower": "\n".join(lowers[0].history)},
    )


def _on_maps(upper: Any, lower: Any, offsets: ArrayLike, contact: Any) -> _Positions:
    check_pair(upper, lower)
    check_modulus(contact, upper, lower)
    model = model_of(contact)
    if model.direction is None and model.shear == "+x" and "shear" not in contact:
        model = replace(model, direction=DIRECTIONS)
    model = model.for_surfaces()
    angles = np.atleast_1d(model.angles())
    places = places_on_maps(offsets, upper, lower)
    y, x = places.T * np.array(upper.spacing)[:, np.newaxis]
    area = np.array([np.prod(overlap(upper, lower, place)[0].extent) for place in places.tolist()])
    return _Positions(
        tuple(replace(model, shear="+x", direction=angle) for angle in angles.tolist()),
        (overlap(upper, lower, place) for place in places.tolist()),
        {"offset": len(places)},
        _OF_SURFACES,
        {
            "direction": ("direction", angles, attributes_of("direction")),
            "x": ("offset", x, {"units": "um", "long_name": "offset of the upper body along +x"}),
            "y": ("offset", y, {"units": "um", "long_name": "offset of the upper body along +y"}),
            "nominal_area": ("offset", area, {"units": "um^2", "long_name": "overlap of both maps"}),
        },
        {"upper": "\n".join(upper.history), "lower": "\n".join(lower.history)},
    )


def _profiles(name: str, value: Profile | Sequence[Profile]) -> list[Profile]:
    profiles = [value] if isinstance(value, Profile) else list(value)
    if not profiles or not all(isinstance(each, Profile) for each in profiles):
        raise ValueError(f"{name} must be a Profile or a list of them, got {type(value).__name__}")
    return profiles


def _listed(name: str, given: ArrayLike) -> Floats:
    values = friction.friction_parameter(name, given)
    if values.ndim > 1 or not values.size:
        raise ValueError(f"{name} must be a number or a list of numbers, got {values!r}")
    return values


def _dataset(
    positions: _Positions, asked: Asked, material: dict[str, Floats], computed: list[dict[str, NDArray[Any]]]
) -> xarray.Dataset:
    import xarray

    listed = {name: values.size for name, values in material.items() if values.ndim}
    motion = next(iter(positions.coordinates))
    sizes = {motion: len(asked.models), **positions.sizes, "load": asked.loads.size, **listed}
    variables = {}
    for name in (*positions.names, "status"):
        nothing = np.full(computed[0]["status"].shape, np.nan)
        values = np.stack([each.get(name, nothing) for each in computed], axis=1)
        variables[name] = (tuple(sizes), values.reshape(tuple(sizes.values())), attributes_of(name))
    coordinates = positions.coordinates | {
        "load": ("load", asked.loads, attributes_of("load")),
        **{
            name: ((name,) if name in listed else (), values, attributes_of(name))
            for name, values in material.items()
        },
        "effective_modulus": ((), float(asked.models[0].effective_modulus), attributes_of("effective_modulus")),
    }  # fmt: skip
    title = "stiction traverse" if motion == "shear" else "stiction traverse of surfaces"
    return xarray.Dataset(variables, coordinates, {"title": title})


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
