"""One rough area on another at several relative positions: a pair of maps in memory, and means over it."""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import Executor
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._checks import choice, number, part_of_one, whole_number
from stiction._units import exact
from stiction.mechanics import friction
from stiction.mechanics.friction import SIX
from stiction.mechanics.model import Sliding, modulus_for, warn_of_one_body
from stiction.mechanics.quantities import attributes_of
from stiction.studies import intervals
from stiction.studies.contact_tables import COMPASS
from stiction.studies.measured_files import MeasuredFile
from stiction.studies.member_values import by_slopes, piece_at
from stiction.studies.members import about, bodies_of
from stiction.studies.pair import SEED, SHIFTS, SURROGATES, given_study
from stiction.studies.pressing import Mechanics, checked_loads
from stiction.studies.runner import run
from stiction.studies.surface_tables import MeasuredAreas, MeasuredSurrogates
from stiction.surfaces.pairing import MapPairs
from stiction.surfaces.preparation import SurfaceTrend
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

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
        Both of one kind; heights of the upper body are up, as `turned_over` makes them. Maps may differ in size and
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
    choice("mechanics", mechanics, Mechanics)
    choice("level", level, SurfaceTrend)
    if hardness is not None and mechanics != "half-space":
        raise ValueError(f"hardness is for the half-space, got mechanics={mechanics!r}")
    modulus = modulus_for(effective_modulus, upper, lower)
    angles = np.array([number("directions", each, unit="degrees") % 360 for each in np.atleast_1d(directions)])
    if not angles.size or np.unique(angles).size < angles.size:
        raise ValueError(f"directions must be one or several different angles, got {directions!r}")
    contact: dict[str, Any] = {
        "mechanics": mechanics, "effective_modulus": exact(modulus, "GPa"), "direction": angles.tolist(),
    }  # fmt: skip
    share = part_of_one("compliance_share", compliance_share)
    if mechanics == "half-space":
        contact["compliance_share"] = share
        if hardness is not None:
            contact["hardness"] = exact(number("hardness", hardness, unit="GPa", above=0), "GPa")
    steps = checked_loads(loads)
    rub, stick = (np.atleast_1d(friction.listed_parameter(*each)) for each in (("mu0", mu0), ("tau0", tau0)))
    friction.check_shear_strength(stick, modulus)
    surfaces, count, made = _surfaces(upper, lower, shifts, surrogates, level)
    study = given_study(surfaces, contact, steps, repetitions=count + made, seed=whole_number("seed", seed, least=0))
    if isinstance(upper, Surface) and isinstance(lower, Surface):
        warn_of_one_body(upper, lower, moved=True)
    members = bodies_of(study).members(0.0)
    members.facts()  # which refuses maps of too few points
    pairs = getattr(members, "pairs", None)
    if isinstance(pairs, MapPairs) and len({pairs.origins(index) for index in range(count)}) < count:
        raise ValueError(f"shifts must be fewer on maps of {pairs.upper.heights.shape} points, got {shifts!r}")
    result = run(study, executor=executor, progress=progress).isel(cut_off=0, drop=True)
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
    six = {name: sums[name].broadcast_like(sums["tangential_elastic"]) for name in SIX}
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
        count = whole_number("surrogates", SURROGATES if surrogates is None else surrogates, least=1)
        return MeasuredSurrogates(**bodies, level=level, prepared=True), 0, count
    made = whole_number("surrogates", 0 if surrogates is None else surrogates, least=0)
    count = 0 if shifts == 0 and made else whole_number("shifts", SHIFTS if shifts is None else shifts, least=1)
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
        statistics = np.stack(intervals.of_sample(first.values), axis=-1)
        if str(name).startswith(("share_", "fraction_")):
            statistics = np.minimum(statistics, 1.0)
        variables[str(name)] = ((*first.dims[1:], "statistic"), statistics, values.attrs)
    ok = (result["status"] == friction.STATUS_OK).sum("repetition")
    coordinates = {name: each for name, each in result.coords.items() if "repetition" not in each.dims}
    return xarray.Dataset(
        variables
        | {"ok": ok.assign_attrs(long_name="shifts with an answer"), "shifts": ((), result.sizes["repetition"])},
        coordinates | {"statistic": ["mean", "lower", "upper"]},
        result.attrs,
    )
