"""Rough bodies in memory at positions on each other: lines carried along, maps moved, and means over the positions."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal, Unpack, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, check_choice, check_instance, float_array, fraction, number, whole_number
from stiction._core import __version__
from stiction._units import exact_quantity, to_core_units
from stiction.mechanics import friction
from stiction.mechanics.friction import RATIOS, SIX_SUMS, STATUSES, compute_load, compute_loads, validity_ratio
from stiction.mechanics.model import (
    THICKNESS,
    ContactKeywords,
    ContactModel,
    Shear,
    Sliding,
    check_modulus,
    check_pair,
    make_model,
    modulus_for,
    shows_model,
    warn_if_same_body,
)
from stiction.mechanics.quantities import AREAL_SUMS, AREAL_VALIDITY, QUANTITIES, SUMS, VALIDITY, attributes_of
from stiction.studies import intervals
from stiction.studies.contact_tables import COMPASS, entry_of
from stiction.studies.evaluation import OverMembers, by_slopes, piece_at
from stiction.studies.intervals import Crossing
from stiction.studies.measured_surfaces import (
    SHIFTS,
    SURROGATES,
    MeasuredAreas,
    MeasuredFile,
    MeasuredLines,
    MeasuredSurrogates,
    overlap,
)
from stiction.studies.members import about, bodies_of
from stiction.studies.runner import run
from stiction.studies.study import SEED, given_study
from stiction.surfaces.pairing import MIN_PIECE_POINTS, MapPairs
from stiction.surfaces.preparation import SurfaceTrend
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

AROUND = (0.03, 0.3, 0.6, 0.72, 0.8, 0.87, 0.93, 1.0, 1.07, 1.15, 1.25, 1.4, 1.8, 3.0, 30.0)
"""Elastic loads over a normal load that are pressed to find it, close together where friction on slopes adds little."""

Load = Literal["normal", "elastic"]
Mechanics = Literal["half-space", "asperities"]
SHEARS: tuple[Shear, ...] = get_args(Shear)
DIRECTIONS = (0.0, 90.0, 180.0, 270.0)  # degrees, of surfaces, if none are asked for

_OF_PROFILES = (
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
    executor, progress
        As for `run`.
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
        "below-range" (more than the load is carried at an approach of 0); all else is NaN unless it is "ok". At a
        normal load values are between those of two elastic loads, which is right to 2e-3. Where the load jumps with the
        approach, as contacts by cells let it, values are in proportion between both sides of the jump; at a normal load
        most are then right to 2e-3, but single ones are not, where the elastic load falls before it jumps.
        Of half-planes the coefficient is F_T/F_N at this pressing; approach, normal_stiffness and the figures of
        `Validity` are NaN, for a free half-plane has no approach; the status is "not-solved" where a solution did not
        reach its tolerance. Of surfaces over direction (degrees), offset and load: also lateral_load (mN) and the
        figures of `SurfaceValidity`, but no stiffness.

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
    check_choice("mechanics", mechanics, Mechanics)
    check_choice("load", load, Load)
    areal = isinstance(upper, Surface) or isinstance(lower, Surface)
    if areal and mechanics != "asperities":
        raise ValueError(f"mechanics of surfaces must be 'asperities', got {mechanics!r}; see pressed_maps")
    positions = (_on_maps if areal else _on_lines)(upper, lower, offsets, contact, mechanics)
    model, wanted = positions.model, _checked_loads(loads)
    material = friction.parameter_list("mu0", mu0), friction.parameter_list("tau0", tau0)
    friction.check_shear_strength(material[1], model.effective_modulus)
    table: dict[str, Any] = {
        "mechanics": mechanics,
        "effective_modulus": exact_quantity(model.effective_modulus, "GPa"),
    }
    attributes: dict[str, Any]
    if mechanics == "half-space":
        attributes = {"compliance_share": fraction("compliance_share", compliance_share)}
        table |= attributes
    else:
        attributes = {"detection": model.detection, "law": str(model.law), "curvature": model.curvature}
        table |= {"law": entry_of(model.law), "detection": model.detection, "curvature": model.curvature}
    if areal:
        table["direction"] = np.atleast_1d(model.angles()).tolist()
    # By half-planes loads are elastic, as they are where friction does not carry.
    by_normal = load == "normal" and mechanics == "asperities"
    steps = np.unique(np.outer(wanted, AROUND)) if by_normal else wanted
    study = given_study(positions.surfaces, table, steps, repetitions=int(np.prod(list(positions.sizes.values()))))
    result = run(study, executor=executor, progress=progress).dataset.isel(cut_off=0, drop=True)
    result = result.transpose("direction", "repetition", "sliding", "load", ...)
    found = _read(result, model.sliding, wanted, [np.atleast_1d(each) for each in material], by_normal=by_normal)
    return _dataset(positions, wanted, material, found).assign_attrs(
        mechanics=mechanics, **attributes, sliding=model.sliding, upper=result.attrs["upper"],
        lower=result.attrs["lower"], stiction_version=__version__,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Positions:
    """Bodies at every position, how they are pressed, and what a dataset says of them."""

    model: ContactModel
    surfaces: MeasuredLines | MeasuredAreas
    sizes: dict[str, int]  # dimensions of the positions
    names: tuple[str, ...]  # of the quantities
    coordinates: dict[str, Any]  # of motions first


def _on_lines(upper: Any, lower: Any, offsets: ArrayLike, contact: Any, mechanics: Mechanics) -> _Positions:
    uppers, lowers = _profiles("upper", upper), _profiles("lower", lower)
    if len(uppers) != len(lowers):
        raise ValueError(f"upper and lower must be as many profiles, got {len(uppers)} and {len(lowers)}")
    if len({(len(each), each.spacing) for each in uppers}) > 1:
        raise ValueError("the profiles of upper must all be on the same grid, or a load would not mean the same")
    for pair in zip(uppers, lowers, strict=True):
        check_pair(*pair)
    check_modulus(contact, *uppers, *lowers)
    for name in ("shear", "direction"):
        if name in contact:
            raise ValueError(f"{name} must not be given: a traverse of profiles has both directions")
    if mechanics == "half-space" and (wrong := contact.keys() - {"effective_modulus", "sliding"}):
        raise ValueError(f"{min(wrong)} must not be given for half-planes: it is of asperities")
    model = make_model(contact)
    places = _places_on_lines(offsets, uppers, lowers)
    return _Positions(
        replace(model, detection=model.detection or "gap-minimum").for_profiles(),
        MeasuredLines(
            upper=MeasuredFile.of_lines(uppers, "upper"), lower=MeasuredFile.of_lines(lowers, "lower"), prepared=True,
            positions=tuple(places.tolist()),
        ),
        {"line": len(uppers), "offset": places.size},
        _OF_PROFILES,
        {
            "shear": ("shear", list(SHEARS), {"long_name": "where the upper body is about to move"}),
            "line": ("line", np.arange(len(uppers)), attributes_of("line")),
            "offset": (
                "offset", places * uppers[0].spacing, {"units": "um", "long_name": "offset of the upper body along +x"},
            ),
            "nominal_area": (
                (), uppers[0].extent * THICKNESS, {"units": "um^2", "long_name": "extent of the slider times 1 um"},
            ),
        },
    )  # fmt: skip


def _on_maps(upper: Any, lower: Any, offsets: ArrayLike, contact: Any, _: Mechanics) -> _Positions:
    check_pair(upper, lower)
    check_modulus(contact, upper, lower)
    model = make_model(contact)
    if model.direction is None and model.shear == "+x" and "shear" not in contact:
        model = replace(model, direction=DIRECTIONS)
    model = model.for_surfaces()
    places = _places_on_maps(offsets, upper, lower)
    y, x = places.T * np.array(upper.spacing)[:, np.newaxis]
    area = np.array([np.prod(overlap(upper, lower, place)[0].extent) for place in places.tolist()])
    return _Positions(
        model,
        MeasuredAreas(
            upper=MeasuredFile.holding(upper, "upper"), lower=MeasuredFile.holding(lower, "lower"), prepared=True,
            positions=tuple(map(tuple, places.tolist())),
        ),
        {"offset": len(places)},
        _OF_SURFACES,
        {
            "direction": ("direction", np.atleast_1d(model.angles()), attributes_of("direction")),
            "x": ("offset", x, {"units": "um", "long_name": "offset of the upper body along +x"}),
            "y": ("offset", y, {"units": "um", "long_name": "offset of the upper body along +y"}),
            "nominal_area": ("offset", area, {"units": "um^2", "long_name": "overlap of both maps"}),
        },
    )  # fmt: skip


def _profiles(name: str, value: Profile | Sequence[Profile]) -> list[Profile]:
    several = isinstance(value, Sequence) and not isinstance(value, str)
    profiles: Any = value if several else [value]
    if not profiles or not all(isinstance(each, Profile) for each in profiles):
        raise ValueError(f"{name} must be a Profile or a list of them, got {type(value).__name__}")
    return list(profiles)


def _places_on_lines(offsets: ArrayLike, uppers: list[Profile], lowers: list[Profile]) -> NDArray[np.intp]:
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


def _places_on_maps(offsets: ArrayLike, upper: Surface, lower: Surface) -> NDArray[np.intp]:
    """Offsets (x, y) in whole rows and columns, with enough of both maps above each other."""
    values = float_array("offsets", offsets)
    if values.ndim == 0 and values == 0:
        values = np.zeros((1, 2))
    if values.ndim == 1 and values.size == 2:
        values = values[np.newaxis]
    if values.ndim != 2 or values.shape[1] != 2 or not len(values):
        raise ValueError(f"offsets of surfaces must be (x, y) or a list of these, µm, got {offsets!r}")
    if not (np.abs(values) < 1e9 * np.array(upper.spacing[::-1])).all():
        raise ValueError(f"offsets must not move the maps further apart than they are long, got {offsets!r}")
    places = np.rint(values[:, ::-1] / np.array(upper.spacing)).astype(np.intp)
    moved_to, below = np.array(upper.heights.shape), np.array(lower.heights.shape)
    common = np.minimum(places + moved_to, below) - np.maximum(places, 0)
    if (common < MIN_PIECE_POINTS).any():
        x, y = values[(common < MIN_PIECE_POINTS).any(axis=1)][0]
        raise ValueError(
            f"offsets must leave at least {MIN_PIECE_POINTS} rows and columns of both maps above each other, "
            f"got ({x:g}, {y:g}) µm"
        )
    return np.asarray(places)


def _checked_loads(loads: ArrayLike) -> Floats:
    """Loads (mN) above 0, each once and rising."""
    values = np.unique(np.atleast_1d(float_array("loads", to_core_units("loads", loads, "force"))))
    if not values.size or not (values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {loads!r}")
    return values


# ---- At the loads of each position ----------------------------------------------------------------------------------


def _read(
    result: xarray.Dataset, sliding: Sliding, loads: Floats, material: Sequence[Floats], *, by_normal: bool
) -> dict[str, NDArray[Any]]:
    """Each quantity of a result and its status at given loads, (motions, positions, loads, mu0, tau0)."""
    mu0, tau0 = material
    has = result.data_vars

    def steps_of(name: str, rule: Sliding = sliding) -> Floats:
        """A variable over motions, positions and steps."""
        values = result[name].sel(sliding=rule) if "sliding" in result[name].dims else result[name]
        array = values.values.astype(np.float64)
        if "direction" in values.dims:
            return array
        return np.broadcast_to(array, (result.sizes["direction"], *array.shape))

    both = compute_loads({name: steps_of(name) for name in SIX_SUMS}, mu0, tau0)
    normal, tangential = (np.moveaxis(each, 2, -1) for each in both)  # (motions, positions, mu0, tau0, steps)
    with np.errstate(invalid="ignore"):
        off = Crossing.of(np.where(normal > 0, normal, np.nan), loads, ratio=True) if by_normal else None

    def at(values: Floats, *, sums: bool = True) -> Floats:
        """A quantity (motions, positions, [mu0, tau0,] steps) at the loads."""
        if values.ndim == 3:
            values = np.broadcast_to(values[:, :, np.newaxis, np.newaxis], normal.shape)
        return np.moveaxis(values if off is None else off.at(values, sums=sums), -1, 2)

    sums = {name: at(steps_of(name)) for name in (*SUMS, *AREAL_SUMS) if name in has and name not in SIX_SUMS[1:]}
    elastic, carried = sums["normal_elastic"], at(normal)
    why = np.array(STATUSES)[result["status"].values[:, np.searchsorted(result["load"].values, loads)]]
    why = why[..., np.newaxis, np.newaxis]
    if off is None:
        touched, locked = sums["contact_count"] != 0, np.isfinite(carried)
        status = friction.combine_status(touched=touched, reached=carried > 0, locked=locked)
    else:
        reached, below = (np.moveaxis(each, -1, 2) for each in (off.reached, off.below))
        last = np.where(np.isfinite(normal), normal, -np.inf).max(axis=-1)
        locked = np.isfinite(normal).any(axis=-1) & (last <= 0)
        status = friction.combine_status(touched=True, reached=reached, locked=locked[:, :, np.newaxis], below=below)
    status = np.where((status != friction.STATUS_OK) & (why != friction.STATUS_OK), why, status)
    found = {name: sums[name] for name in ("contact_area", "contact_count")} | {"tangential_load": at(tangential)}
    with np.errstate(invalid="ignore", divide="ignore"):
        found["friction_coefficient"] = found["tangential_load"] / carried
        found["share_opposing"] = at(steps_of("tangential_frictional", "opposing")) / elastic
        if "overlap_load" in has:
            found["approach"] = at(steps_of("approach"), sums=False)
            found["normal_stiffness"] = at(steps_of("normal_stiffness"))
            if off is not None:  # and what friction adds between two steps
                before = np.broadcast_to(steps_of("normal_elastic")[:, :, np.newaxis, np.newaxis], normal.shape)
                found["normal_stiffness"] *= np.moveaxis(off.slope(normal, before), -1, 2)
        if "lateral_elastic" in has:
            found["lateral_load"] = compute_load("lateral", sums, mu0[:, np.newaxis], tau0)
    found |= {name: validity_ratio(name, sums) for name, (part, _) in RATIOS.items() if part in sums}
    known = {name: np.where(status == friction.STATUS_OK, each, np.nan) for name, each in found.items()}
    return known | {"status": status}


def _dataset(
    positions: _Positions, loads: Floats, material: tuple[Floats, Floats], found: dict[str, NDArray[Any]]
) -> xarray.Dataset:
    import xarray

    both = dict(zip(("mu0", "tau0"), material, strict=True))
    listed = {name: values.size for name, values in both.items() if values.ndim}
    motion = next(iter(positions.coordinates))
    sizes = {motion: found["status"].shape[0], **positions.sizes, "load": loads.size, **listed}
    variables = {}
    for name in (*positions.names, "status"):
        values = found.get(name, np.full(found["status"].shape, np.nan))
        variables[name] = (tuple(sizes), values.reshape(tuple(sizes.values())), attributes_of(name))
    coordinates = positions.coordinates | {
        "load": ("load", loads, attributes_of("load")),
        **{name: ((name,) if name in listed else (), values, attributes_of(name)) for name, values in both.items()},
        "effective_modulus": ((), float(positions.model.effective_modulus), attributes_of("effective_modulus")),
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
    Neighbouring positions have asperities in common: the interval is over all correlations of neighbours that the
    values allow, with several lines over those of their means, and never beyond the values themselves. It says how well
    the mean over these two profiles is known, not what other pieces of the same surfaces would give; that takes more
    profiles, or surrogates.

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

    check_instance("result", result, xarray.Dataset, "an xarray.Dataset of traverse")
    others = tuple(name for name in ("mu0", "tau0") if name in result.dims)
    if "direction" in result.dims:
        raise ValueError("result must be a traverse of profiles, got one of surfaces")
    over = ("shear", "load", *others)
    data = result.transpose("line", "offset", *over)
    ok = data["status"].values == friction.STATUS_OK
    lines, offsets, *_ = ok.shape
    members = OverMembers(np.arange(lines * offsets), np.repeat(np.arange(lines), offsets))
    means: dict[str, Any] = {}
    for name in _OF_PROFILES:
        known = np.where(ok, data[name].values, np.nan).reshape(-1, *ok.shape[2:])
        means[name] = ((*over, "statistic"), members.mean(known), dict(data[name].attrs))
    counts = {
        "ok": (over, ok.sum(axis=(0, 1)), {"units": "1", "long_name": "positions that have an answer"}),
        "positions": ((), lines * offsets, {"units": "1", "long_name": "positions"}),
    }
    kept = {name: each.variable for name, each in data.coords.items() if name not in ("line", "offset")}
    return xarray.Dataset(means | counts, kept | {"statistic": ["mean", "lower", "upper"]}, dict(result.attrs))


# ---- Maps ------------------------------------------------------------------------------------------------------------

RULES: tuple[Sliding, Sliding] = ("opposing", "all")  # sliding rules, in the order of the dimension
_DIMS = ("sliding", "direction", "repetition", "fraction_below", "load", "mu0", "tau0")


def pressed_maps(
    upper: Surface | Profile,
    lower: Surface | Profile,
    loads: ArrayLike,
    *,
    mu0: ArrayLike,
    tau0: ArrayLike = 0.0,
    directions: Sequence[float] = COMPASS,
    shifts: int | None = None,
    surrogates: int | None = None,
    seed: int = SEED,
    level: SurfaceTrend = "plane",
    mechanics: Mechanics = "half-space",
    effective_modulus: float | None = None,
    compliance_share: float = 0.5,
    hardness: float | None = None,
    executor: Executor | None = None,
    progress: bool = False,
) -> xarray.Dataset:
    """True area and friction of two maps at given loads, at several relative positions, by both sliding rules.

    Parameters
    ----------
    upper, lower : Surface or Profile
        Both of one kind; heights of the upper body are up, as `flipped` makes them. Maps may differ in size and
        spacing: pieces lie all over both, on the finer spacing. Profiles stand for isotropic surfaces, of which
        `isotropic_surface` makes surrogates.
    loads : (l,) array_like of float, mN
        Above 0: the elastic load Σ F n_z on what lies above each other, whose area is `nominal_area`.
    mu0 : float or (m,) array_like of float
        Molecular friction coefficient.
    tau0 : float or (t,) array_like of float, GPa
        Adhesive shear strength.
    directions : sequence of float, degrees
        Where the upper body is about to move, from +x towards +y.
    shifts : int
        Relative positions: the upper map is moved along +x by an eighth to a quarter of its length and along y by up to
        a quarter of it either way. So a map on itself never lies on itself, nor on its mirror image. What lies above
        each other is cut to one size for all, levelled and pressed. 16 by default of maps; profiles have none.
    surrogates : int
        Pairs of surrogates of the whole maps (`surrogate`) or of profiles, of which pieces of the same size are pressed
        as well: other surfaces of this kind. None by default of maps, 16 of profiles.
    seed : int
        Of the surrogates.
    level : {"plane", "quadratic", "mean"}
        What is taken off each piece that is pressed.
    mechanics : {"half-space", "asperities"}
        `half_space` with free boundaries, or `press`.
    effective_modulus : float, GPa
        As for `half_space`: it must be given of bodies that were read from files.
    compliance_share, hardness
        Of `half_space`.
    executor, progress
        As for `run`.

    Returns
    -------
    xarray.Dataset
        friction_coefficient, normal_load and tangential_load (mN) and status over sliding, direction, repetition (a
        shift or a pair of surrogates), load (mN), mu0 and tau0 (GPa); the six sums that these are made of;
        share_opposing over direction, repetition and load; over repetition and load contact_area (µm²),
        contact_area_fraction, mean_pressure (GPa), contact_count, normal_stiffness (mN/µm), approach (µm), fractions of
        the load on the contact that carries most, on contacts at the edge and of few points and on the steepest tenth
        of each body, of the half-space its error and the shares of load and area at the hardness, of asperities the
        figures of `SurfaceValidity`; over fraction_below as well patch_area (µm², of the contacts) and pressure (GPa,
        of the true area). Of the gap of each: rms_gradient, rms_slope along each direction, and what `gentle_friction`
        makes of them. Coordinates x and y (µm) are how far the upper map moved, and surrogate says which shifts are
        none but pairs of surrogates.
        The status is "ok", "self-locked", "no-contact", "not-reached", "below-range", or "not-solved" where the
        half-space did not reach its tolerance; all else is NaN unless it is "ok".

    Raises
    ------
    ValueError
        If the maps have too few points for so many shifts, or an argument is outside its range.

    Notes
    -----
    The load is what the bodies press on each other before anything slides. F_N, which the onset of sliding changes by
    the vertical part of friction on slopes, is normal_load, and the coefficient is F_T / F_N at this pressing. So area,
    contacts and stiffness do not depend on direction, mu0 and tau0, and both mechanics are compared at one load.

    Examples
    --------
    >>> from stiction import pressed_maps, pressed_maps_mean, self_affine_surface
    >>> lower, upper = (
    ...     self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1, side=side)
    ...     for side in ("lower", "upper")
    ... )
    >>> result = pressed_maps(upper, lower, [0.1], mu0=0.3, shifts=4, mechanics="asperities")
    >>> pressed_maps_mean(result)["friction_coefficient"].dims
    ('sliding', 'direction', 'load', 'mu0', 'tau0', 'statistic')
    """
    check_choice("mechanics", mechanics, Mechanics)
    check_choice("level", level, SurfaceTrend)
    if hardness is not None and mechanics != "half-space":
        raise ValueError(f"hardness is for the half-space, got mechanics={mechanics!r}")
    modulus = modulus_for(effective_modulus, upper, lower)
    angles = np.array([number("directions", each, unit="degrees") % 360 for each in np.atleast_1d(directions)])
    if not angles.size or np.unique(angles).size < angles.size:
        raise ValueError(f"directions must be one or several different angles, got {directions!r}")
    contact: dict[str, Any] = {
        "mechanics": mechanics, "effective_modulus": exact_quantity(modulus, "GPa"), "direction": angles.tolist(),
    }  # fmt: skip
    share = fraction("compliance_share", compliance_share)
    if mechanics == "half-space":
        contact["compliance_share"] = share
        if hardness is not None:
            contact["hardness"] = exact_quantity(number("hardness", hardness, unit="GPa", above=0), "GPa")
    steps = _checked_loads(loads)
    rub, stick = (np.atleast_1d(friction.parameter_list(*each)) for each in (("mu0", mu0), ("tau0", tau0)))
    friction.check_shear_strength(stick, modulus)
    surfaces, count, made = _surfaces(upper, lower, shifts, surrogates, level)
    study = given_study(surfaces, contact, steps, repetitions=count + made, seed=whole_number("seed", seed, minimum=0))
    if isinstance(upper, Surface) and isinstance(lower, Surface):
        warn_if_same_body(upper, lower, moved=True)
    members = bodies_of(study).members(0.0)
    members.facts()  # which refuses maps of too few points
    pairs = getattr(members, "pairs", None)
    if isinstance(pairs, MapPairs) and len({pairs.origins(index) for index in range(count)}) < count:
        raise ValueError(f"shifts must be fewer on maps of {pairs.upper.heights.shape} points, got {shifts!r}")
    result = run(study, executor=executor, progress=progress).dataset.isel(cut_off=0, drop=True)
    # Relative positions first.
    sums = result.isel(repetition=np.r_[made : made + count, :made], sliding=[1, 0]).drop_vars(["repetition", "line"])
    facts = {name: sums.attrs[name] for name in ("shape", "spacing_um", "upper", "lower", "stiction_version")}
    attributes = {
        "title": "stiction pair of maps", "mechanics": mechanics, "level": level, "seed": seed,
        "of_profiles": int(isinstance(upper, Profile)), "compliance_share": share,
        **({} if hardness is None else {"hardness_GPa": hardness}), **facts,
    }  # fmt: skip
    # Surrogates are not moved.
    sums = sums.assign_coords({name: sums[name].fillna(0.0) for name in ("x", "y")})
    sums.attrs = attributes
    found = piece_at(sums, sums["load"].values, rub, stick, "elastic", ratio=False)
    if "unanswered_count" in sums:
        unanswered = sums["unanswered_count"] / sums["grid_minimum_count"]
        found["share_unanswered"] = unanswered.assign_attrs(attributes_of("share_unanswered"))
    slopes = sums["rms_slope"].transpose("repetition", "direction").values
    gentle = by_slopes(["repetition"], sums["rms_gradient"].values, slopes, RULES, rub, stick, modulus)
    six = {name: sums[name].broadcast_like(sums["tangential_elastic"]) for name in SIX_SUMS}
    return found.assign(six | gentle).transpose(*_DIMS, missing_dims="ignore")


def overlap_area(upper: Surface | Profile, lower: Surface | Profile) -> float:
    """The nominal area (µm²) of what `pressed_maps` presses of two maps, or of surfaces made of two profiles."""
    surfaces, count, made = _surfaces(upper, lower, None, None, "plane")
    return float(about(given_study(surfaces, {}, np.ones(1), repetitions=count + made)).nominal_area or 0.0)


def _surfaces(
    upper: Any, lower: Any, shifts: int | None, surrogates: int | None, level: SurfaceTrend
) -> tuple[MeasuredAreas | MeasuredSurrogates, int, int]:
    """Both bodies in a study, how many relative positions there are, and how many pairs of surrogates."""
    of_profiles = isinstance(upper, Profile) and isinstance(lower, Profile)
    bodies: dict[str, Any] = {}
    for name, body in (("upper", upper), ("lower", lower)):
        if not of_profiles and not isinstance(body, Surface):
            raise ValueError(f"{name} must be a Surface, got {type(body).__name__}")
        bodies[name] = MeasuredFile.holding(body, name)
    if of_profiles:
        if shifts:
            raise ValueError(f"shifts are of maps; of profiles surrogates are pressed, got shifts={shifts!r}")
        count = whole_number("surrogates", SURROGATES if surrogates is None else surrogates, minimum=1)
        return MeasuredSurrogates(**bodies, level=level, prepared=True), 0, count
    made = whole_number("surrogates", 0 if surrogates is None else surrogates, minimum=0)
    count = 0 if shifts == 0 and made else whole_number("shifts", SHIFTS if shifts is None else shifts, minimum=1)
    return MeasuredAreas(**bodies, level=level, surrogates=made, prepared=True), count, made


def pressed_maps_mean(result: xarray.Dataset, *, surrogates: bool | None = None) -> xarray.Dataset:
    """Means over the shifts of two maps, or over pairs of surrogates, with 95 % intervals.

    Parameters
    ----------
    result : xarray.Dataset
        What `pressed_maps` returns.
    surrogates : bool, optional
        Whether over the pairs of surrogates; by default where there are no shifts.

    Raises
    ------
    ValueError
        If there are none of these.

    Returns
    -------
    xarray.Dataset
        Its quantities without repetition, with statistic ("mean", "lower", "upper"), over those shifts that have an
        answer, and how many these are (ok, over the dimensions of the status) of how many (shifts).

    Notes
    -----
    The interval is Student's t over the shifts, NaN for fewer than 3, not below 0 where no value is, and of fractions
    not above 1. Over shifts it says how well the mean over all shifts of *these two maps* is known: they have heights
    in common, and of other pieces of the surfaces it knows nothing. Over surrogates, which are independent, it says how
    well the mean over surfaces with *the spectra of these maps* is known.

    Examples
    --------
    >>> from stiction import pressed_maps, pressed_maps_mean, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> result = pressed_maps(upper, lower, ["1 mN"], mu0=0.3, shifts=3, mechanics="asperities")
    >>> pressed_maps_mean(result)["contact_area"].dims
    ('load', 'statistic')
    """
    import xarray

    check_instance("result", result, xarray.Dataset, "an xarray.Dataset of pressed_maps")
    made = result["surrogate"].values.astype(bool)
    wanted = bool(made.all()) if surrogates is None else surrogates
    if not (made == wanted).any():
        raise ValueError(f"surrogates must be {not wanted} where there are no others, got {surrogates!r}")
    result = result.isel(repetition=np.flatnonzero(made == wanted))
    variables: dict[str, Any] = {}
    for name, values in result.data_vars.items():
        if values.dtype.kind != "f" or "repetition" not in values.dims:
            continue
        first = values.transpose("repetition", ...)
        statistics = np.stack(intervals.sample_mean(first.values), axis=-1)
        statistics = np.minimum(statistics, QUANTITIES[str(name)].bounds[1])
        variables[str(name)] = ((*first.dims[1:], "statistic"), statistics, values.attrs)
    ok = (result["status"] == friction.STATUS_OK).sum("repetition")
    coordinates = {name: each for name, each in result.coords.items() if "repetition" not in each.dims}
    return xarray.Dataset(
        variables
        | {"ok": ok.assign_attrs(long_name="shifts with an answer"), "shifts": ((), result.sizes["repetition"])},
        coordinates | {"statistic": ["mean", "lower", "upper"]},
        result.attrs,
    )
