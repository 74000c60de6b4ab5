"""One rough area on another at several relative positions: true area and friction around the compass at given loads."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, choice, float_array, number, whole_number
from stiction._core import __version__
from stiction.mechanics import friction
from stiction.mechanics.candidates import candidates
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.contact import SurfaceLoadCurve, contacts, press
from stiction.mechanics.friction import STATUS_DTYPE
from stiction.mechanics.half_space import HalfSpaceCurve, half_space
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import ContactModel
from stiction.mechanics.quantities import AREAL_VALIDITY, VALIDITY, attributes_of
from stiction.studies import intervals
from stiction.studies.executors import in_order
from stiction.surfaces.preparation import levelled
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

Mechanics = Literal["half-space", "asperities"]

TITLE = "stiction pair of maps"
"""Of a result."""

SLIDING = ("opposing", "all")

COMPASS = tuple(30.0 * step for step in range(12))
"""Degrees."""

SHIFTS = 16

REACH = 4
"""The upper map is moved by at most this part of its length: three quarters of both stay above each other."""

FEWEST_POINTS = 16
"""Rows and columns that are pressed."""

_STIFFNESS_STEP = 0.02
"""Share of the approach on both sides of it over which the stiffness of asperities is taken."""

_OF_FRICTION = ("friction_coefficient", "normal_load")
_OF_CONTACT = (
    "contact_area", "contact_area_fraction", "contact_count", "normal_stiffness", "approach", "error",
    "load_share_at_hardness", *VALIDITY, *AREAL_VALIDITY,
)  # fmt: skip

_FRICTION_DIMS = ("sliding", "direction", "shift", "load", "mu0", "tau0")


def pressed_maps(
    upper: Surface,
    lower: Surface,
    loads: ArrayLike,
    *,
    mu0: ArrayLike,
    tau0: ArrayLike = 0.0,
    directions: Sequence[float] = COMPASS,
    shifts: int = SHIFTS,
    mechanics: Mechanics = "half-space",
    effective_modulus: float = 10.0,
    compliance_share: float = 0.5,
    hardness: float | None = None,
    executor: Executor | None = None,
    progress: bool = False,
) -> xarray.Dataset:
    """True area and friction of two maps at given loads, at several relative positions, by both sliding rules.

    Parameters
    ----------
    upper, lower : Surface
        On the same grid; heights of the upper body are up, as `turned_over` makes them.
    loads : (l,) array_like of float, mN
        Above 0: the elastic load Σ F n_z on what lies above each other, see `overlap_area`.
    mu0 : float or (m,) array_like of float
        Molecular friction coefficient.
    tau0 : float or (t,) array_like of float, GPa
        Adhesive shear strength.
    directions : sequence of float, degrees
        Where the upper body is about to move, from +x towards +y.
    shifts : int
        Relative positions: the upper map is moved along +x by an eighth to a quarter of its length and along y by up to
        a quarter of it either way. So a map on itself never lies on itself, nor on its mirror image. What lies above
        each other is cut to one size for all, levelled by a plane and pressed.
    mechanics : {"half-space", "asperities"}
        `half_space` with free boundaries, or `press`.
    effective_modulus : float, GPa
    compliance_share, hardness
        Of `half_space`.
    executor : concurrent.futures.Executor, optional
        Where shifts are computed; a thread for each core by default.
    progress : bool
        Whether to draw a progress bar on the terminal.

    Returns
    -------
    xarray.Dataset
        friction_coefficient, normal_load (mN) and status over sliding, direction, shift, load (mN), mu0 and tau0 (GPa);
        share_opposing over direction, shift and load; over shift and load contact_area (µm²), contact_area_fraction,
        contact_count, normal_stiffness (mN/µm), approach (µm), of the half-space its error and load_share_at_hardness,
        of asperities the figures of `SurfaceValidity`. Of the gap at each shift: rms_gradient, rms_slope along each
        direction, and what `gentle_friction` makes of them. Coordinates x and y (µm) are how far the upper map moved.
        The status is "ok", "self-locked", "no-contact", "not-reached", "below-range", or "not-solved" where the
        half-space did not reach its tolerance; all else is NaN unless it is "ok".

    Raises
    ------
    ValueError
        If the grids differ, the maps have too few points for so many shifts, or an argument is outside its range.

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
    import xarray

    choice("mechanics", mechanics, Mechanics)
    if hardness is not None and mechanics != "half-space":
        raise ValueError(f"hardness is for the half-space, got mechanics={mechanics!r}")
    load_values = np.unique(np.atleast_1d(float_array("loads", loads)))
    if not load_values.size or not (load_values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {loads!r}")
    modulus = number("effective_modulus", effective_modulus, unit="GPa", above=0)
    angles = np.array([number("directions", each, unit="degrees") % 360 for each in np.atleast_1d(directions)])
    if not angles.size or np.unique(angles).size < angles.size:
        raise ValueError(f"directions must be one or several different angles, got {directions!r}")
    material = []
    for name, given in (("mu0", mu0), ("tau0", tau0)):
        values = np.atleast_1d(friction.friction_parameter(name, given))
        if values.ndim > 1 or not values.size:
            raise ValueError(f"{name} must be a number or a list of numbers, got {given!r}")
        material.append(values)
    friction.check_shear_strength(material[1], modulus)
    moved = displacements(upper, lower, shifts)
    half_spaces: dict[str, Any] = {"compliance_share": compliance_share, "hardness": hardness}
    chosen: dict[str, Any] = {
        "loads": load_values, "mu0": material[0], "tau0": material[1], "angles": angles, "modulus": modulus,
    }  # fmt: skip
    pressed: Any = functools.partial(_asperities, **chosen)
    if mechanics == "half-space":
        pressed = functools.partial(_half_space, **chosen, **half_spaces)
    pairs = (window(upper, lower, (int(rows), int(columns))) for rows, columns in moved)
    computed = in_order(pressed, pairs, total=len(moved), what="shifts", executor=executor, progress=progress)
    parts = list(computed)
    variables = {
        name: (_dims(name), np.stack([part[name] for part in parts], axis=_dims(name).index("shift")), _named(name))
        for name in parts[0]
    }
    dy, dx = upper.spacing
    return xarray.Dataset(
        variables,
        {
            "sliding": ("sliding", list(SLIDING), {"long_name": "which contacts rub and push"}),
            "direction": ("direction", angles, attributes_of("direction")),
            "x": ("shift", moved[:, 1] * dx, {"units": "um", "long_name": "how far the upper map is moved along +x"}),
            "y": ("shift", moved[:, 0] * dy, {"units": "um", "long_name": "how far the upper map is moved along +y"}),
            "load": ("load", load_values, attributes_of("load")),
            "mu0": ("mu0", material[0], attributes_of("mu0")),
            "tau0": ("tau0", material[1], attributes_of("tau0")),
            "effective_modulus": ((), modulus, attributes_of("effective_modulus")),
            "nominal_area": (
                (), overlap_area(upper, lower), {"units": "um^2", "long_name": "what lies above each other"},
            ),
        },
        {
            "title": TITLE,
            "mechanics": mechanics,
            "shape": np.array(_window_shape(upper.heights.shape)),
            "spacing_um": np.array(upper.spacing),
            "compliance_share": float(compliance_share),
            **({} if hardness is None else {"hardness_GPa": float(hardness)}),
            "upper": "\n".join(upper.history),
            "lower": "\n".join(lower.history),
            "stiction_version": __version__,
        },
    )  # fmt: skip


def _dims(name: str) -> tuple[str, ...]:
    if name in (*_OF_FRICTION, "status"):
        return _FRICTION_DIMS
    return {
        "share_opposing": ("direction", "shift", "load"),
        "rms_gradient": ("shift",),
        "rms_slope": ("direction", "shift"),
        "gentle_friction": ("sliding", "direction", "shift", "mu0", "tau0"),
    }.get(name, ("shift", "load"))


_NAMES = {
    "normal_load": ("mN", "normal load while sliding starts, friction on slopes included"),
    "contact_area_fraction": ("1", "true contact area over what lies above each other"),
    "error": ("1", "error of the half-space, in deviations of the gap"),
    "load_share_at_hardness": ("1", "share of the load where the pressure is the hardness"),
    "rms_gradient": ("1", "root-mean-square gradient of the gap"),
    "rms_slope": ("1", "root-mean-square slope of the gap along the motion"),
    "gentle_friction": ("1", "friction coefficient by the slope of the gap alone"),
}


def _named(name: str) -> dict[str, str]:
    if name in _NAMES:
        unit, words = _NAMES[name]
        return {"units": unit, "long_name": words}
    return attributes_of(name)


# ---- Where the maps lie ----------------------------------------------------------------------------------------------


def overlap_area(upper: Surface, lower: Surface) -> float:
    """What `pressed_maps` presses of two maps at each shift, µm²."""
    _check(upper, lower)
    rows, columns = _window_shape(upper.heights.shape)
    return float(rows * upper.spacing[0] * columns * upper.spacing[1])


def displacements(upper: Surface, lower: Surface, shifts: int) -> NDArray[np.int64]:
    """(shifts, 2) rows and columns by which the upper map is moved over the lower, evenly spread."""
    _check(upper, lower)
    count = whole_number("shifts", shifts, least=1)
    rows, columns = (points // REACH for points in upper.heights.shape)
    step = np.arange(count)
    # Multiples of the powers of the plastic number, which spread over a square as those of the golden ratio on a line.
    along_x, along_y = ((0.5 + step * _PLASTIC**-power) % 1 for power in (1, 2))
    moved = np.stack([np.rint(rows * (2 * along_y - 1)), np.rint(columns * (0.5 + 0.5 * along_x))], axis=1)
    places = moved.astype(np.int64)
    if len(np.unique(places, axis=0)) < count:
        raise ValueError(f"shifts must be fewer on maps of {upper.heights.shape} points, got {shifts!r}")
    return places


_PLASTIC = 1.324717957244746


def window(upper: Surface, lower: Surface, moved: tuple[int, int]) -> tuple[Surface, Surface]:
    """The middle of what lies above each other when the upper map is moved by rows and columns, both levelled."""
    shape = _window_shape(upper.heights.shape)
    of_upper, of_lower = [], []
    for points, size, step in zip(upper.heights.shape, shape, moved, strict=True):
        first = max(0, step) + (points - abs(step) - size) // 2
        of_lower.append(slice(first, first + size))
        of_upper.append(slice(first - step, first - step + size))
    cut = (
        Surface(upper.heights[tuple(of_upper)], spacing=upper.spacing, history=upper.history),
        Surface(lower.heights[tuple(of_lower)], spacing=lower.spacing, history=lower.history),
    )
    return levelled(cut[0], "plane"), levelled(cut[1], "plane")


def _window_shape(shape: tuple[int, ...]) -> tuple[int, ...]:
    return tuple(points - points // REACH for points in shape)


def _check(upper: Any, lower: Any) -> None:
    for name, body in (("upper", upper), ("lower", lower)):
        if not isinstance(body, Surface):
            raise ValueError(f"{name} must be a Surface, got {type(body).__name__}")
    if upper.heights.shape != lower.heights.shape or upper.spacing != lower.spacing:
        raise ValueError(
            f"upper and lower must be on one grid, as on_common_grid makes it, got {upper.heights.shape} points "
            f"{upper.spacing!r} µm apart and {lower.heights.shape} points {lower.spacing!r} µm apart"
        )
    if min(_window_shape(upper.heights.shape)) < FEWEST_POINTS:
        raise ValueError(
            f"at least {FEWEST_POINTS} rows and columns must lie above each other, got maps of {upper.heights.shape}"
        )


# ---- One position ----------------------------------------------------------------------------------------------------


def _half_space(
    pair: tuple[Surface, Surface],
    *,
    loads: Floats,
    mu0: Floats,
    tau0: Floats,
    angles: Floats,
    modulus: float,
    compliance_share: float,
    hardness: float | None,
) -> dict[str, NDArray[Any]]:
    """Each quantity at one position; a load without a solution leaves the others theirs."""
    solve = functools.partial(
        half_space, *pair, effective_modulus=modulus, compliance_share=compliance_share, hardness=hardness,
        direction=angles.tolist(),
    )  # fmt: skip
    values = _nothing(loads, mu0, tau0, angles, friction.STATUS_NOT_SOLVED)
    curves: list[tuple[NDArray[np.intp], HalfSpaceCurve]] = []
    try:
        curves.append((np.arange(loads.size), solve(loads)))
    except RuntimeError:
        for index in range(loads.size):
            try:
                curves.append((np.array([index]), solve(loads[index : index + 1])))
            except RuntimeError:
                continue
    for at, curve in curves:
        _fill(values, at, curve, curve.with_sliding("all"), mu0, tau0)
        values["normal_stiffness"][at] = curve.stiffness
        for name in ("approach", "error", "load_share_at_hardness"):
            values[name][at] = getattr(curve, name)
    return _completed(values, pair, mu0, tau0, angles, modulus)


def _asperities(
    pair: tuple[Surface, Surface], *, loads: Floats, mu0: Floats, tau0: Floats, angles: Floats, modulus: float
) -> dict[str, NDArray[Any]]:
    """Each quantity at one position."""
    model = ContactModel(effective_modulus=modulus, direction=angles.tolist()).for_surfaces()
    values = _nothing(loads, mu0, tau0, angles, friction.STATUS_OK)
    # Without friction F_N is the elastic load.
    approach, status = crossing(Bodies(*pair), loads, mu0=0.0, tau0=0.0, model=replace(model, direction=0.0))
    values["status"][...] = status[:, np.newaxis, np.newaxis]
    ok = np.flatnonzero(status == friction.STATUS_OK)
    if ok.size:
        shares = [1 - _STIFFNESS_STEP, 1, 1 + _STIFFNESS_STEP]
        steps, place = np.unique(np.outer(shares, approach[ok]), return_inverse=True)
        low, at, high = place.reshape(len(shares), ok.size)
        found = candidates(*pair, deepest=float(steps[-1]), curvature=model.curvature)
        curve, every = (press(found, steps, model=replace(model, sliding=rule)) for rule in ("opposing", "all"))
        assert isinstance(curve, SurfaceLoadCurve)
        assert isinstance(every, SurfaceLoadCurve)
        _fill(values, ok, curve, every, mu0, tau0, at)
        normal = curve.normal_elastic
        values["normal_stiffness"][ok] = (normal[high] - normal[low]) / (steps[high] - steps[low])
        values["approach"][ok] = approach[ok]
        for name, value in vars(curve.validity).items():
            values[name][ok] = value[at]
    return _completed(values, pair, mu0, tau0, angles, modulus)


def _nothing(loads: Floats, mu0: Floats, tau0: Floats, angles: Floats, status: str) -> dict[str, NDArray[Any]]:
    whole = (len(SLIDING), angles.size, loads.size, mu0.size, tau0.size)
    values: dict[str, NDArray[Any]] = {name: np.full(whole, np.nan) for name in _OF_FRICTION}
    values |= {"status": np.full(whole, status, dtype=STATUS_DTYPE)}
    values |= {"share_opposing": np.full((angles.size, loads.size), np.nan)}
    return values | {name: np.full(loads.size, np.nan) for name in _OF_CONTACT}


def _fill(
    values: dict[str, NDArray[Any]],
    where: NDArray[np.intp],
    opposing: HalfSpaceCurve | SurfaceLoadCurve,
    every: HalfSpaceCurve | SurfaceLoadCurve,
    mu0: Floats,
    tau0: Floats,
    at: Any = slice(None),
) -> None:
    """What follows from the sums of both rules, at loads `where`, which are `at` in the curves."""
    material = {"mu0": mu0[:, np.newaxis], "tau0": tau0}
    for rule, curve in enumerate((opposing, every)):
        normal = curve.normal_load(**material)
        tangential = curve.tangential_load(**material)
        status = curve.status(**material)
        with np.errstate(divide="ignore", invalid="ignore"):
            coefficient = np.where(status == friction.STATUS_OK, tangential / normal, np.nan)
        for name, value in (("friction_coefficient", coefficient), ("normal_load", normal), ("status", status)):
            values[name][rule][:, where] = np.moveaxis(value, (0, 1), (2, 3))[:, at]
    # Of Σ F |t·s|, which is the load but for the squares of slopes.
    with np.errstate(divide="ignore", invalid="ignore"):
        share = opposing.tangential_frictional / every.tangential_frictional
    values["share_opposing"][:, where] = share[:, at]
    values["contact_area"][where] = opposing.contact_area[at]
    values["contact_count"][where] = opposing.contact_count[at]


def _completed(
    values: dict[str, NDArray[Any]],
    pair: tuple[Surface, Surface],
    mu0: Floats,
    tau0: Floats,
    angles: Floats,
    modulus: float,
) -> dict[str, NDArray[Any]]:
    """With the share of the area, and what the gap's slopes alone say."""
    from stiction.mechanics.patches import slopes

    upper, lower = pair
    values["contact_area_fraction"] = values["contact_area"] / (upper.extent[0] * upper.extent[1])
    along_y, along_x = slopes(upper.heights - lower.heights, upper.spacing, periodic=False)
    gradient = np.sqrt((along_x**2).mean() + (along_y**2).mean())
    radians = np.radians(angles)
    squares = (
        (along_x**2).mean() * np.cos(radians) ** 2
        + (along_y**2).mean() * np.sin(radians) ** 2
        + (along_x * along_y).mean() * np.sin(2 * radians)
    )
    rms_slope = np.sqrt(np.maximum(squares, 0.0))
    gentle = np.full((len(SLIDING), angles.size, mu0.size, tau0.size), np.nan)
    if gradient > 0 and (rms_slope > 0).all():
        for rule, sliding in enumerate(SLIDING):
            gentle[rule] = gentle_friction(
                mu0[:, np.newaxis], tau0, rms_gradient=gradient, rms_slope=rms_slope[:, np.newaxis, np.newaxis],
                effective_modulus=modulus, sliding=sliding,  # type: ignore[arg-type]
            )  # fmt: skip
    return values | {"rms_gradient": np.asarray(gradient), "rms_slope": rms_slope, "gentle_friction": gentle}


# ---- Means -----------------------------------------------------------------------------------------------------------


def pressed_maps_mean(result: xarray.Dataset) -> xarray.Dataset:
    """Means over the shifts of two maps, with 95 % intervals.

    Parameters
    ----------
    result : xarray.Dataset
        What `pressed_maps` returns.

    Returns
    -------
    xarray.Dataset
        Its quantities without shift, with statistic ("mean", "lower", "upper"), over those shifts that have an answer,
        and how many these are (ok, over the dimensions of the status) of how many (shifts).

    Notes
    -----
    The interval is Student's t over the shifts, NaN for fewer than 3, and not below 0 where no value is. It says how
    well the mean over all shifts of *these two maps* is known. Shifts have heights in common, and other pieces of the
    surfaces may be different: of that it knows nothing.
    """
    import xarray

    variables: dict[str, Any] = {}
    for name, values in result.data_vars.items():
        if values.dtype.kind != "f" or "shift" not in values.dims:
            continue
        first = values.transpose("shift", ...)
        statistics = np.stack(intervals.of_sample(first.values), axis=-1)
        variables[str(name)] = ((*first.dims[1:], "statistic"), statistics, values.attrs)
    ok = (result["status"] == friction.STATUS_OK).sum("shift")
    coordinates = {name: each for name, each in result.coords.items() if "shift" not in each.dims}
    return xarray.Dataset(
        variables | {"ok": ok.assign_attrs(long_name="shifts with an answer"), "shifts": ((), result.sizes["shift"])},
        coordinates | {"statistic": ["mean", "lower", "upper"]},
        result.attrs,
    )


# ---- For pictures ----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class MapContacts:
    """The contacts of two maps at one position and load.

    Attributes
    ----------
    lower : Surface
        What is beneath; positions are on it.
    x, y : (n,) ndarray, µm
        Middle of each contact.
    force : (n,) ndarray, mN
    opposing : (n,) ndarray of bool
    pressure : (rows, columns) ndarray, GPa, or None
        Of the half-space.
    """

    lower: Surface
    x: Floats
    y: Floats
    force: Floats
    opposing: NDArray[np.bool_]
    pressure: Floats | None


def map_contacts(
    upper: Surface,
    lower: Surface,
    load: float,
    *,
    shift: int = 0,
    direction: float = 0.0,
    mechanics: Mechanics = "half-space",
    effective_modulus: float = 10.0,
    compliance_share: float = 0.5,
    hardness: float | None = None,
) -> MapContacts | None:
    """The contacts that `pressed_maps` has at one of its shifts; None where the load has no answer."""
    rows, columns = displacements(upper, lower, shift + 1)[shift]
    pair = window(upper, lower, (int(rows), int(columns)))
    if mechanics == "asperities":
        model = ContactModel(effective_modulus=effective_modulus, direction=direction).for_surfaces()
        approach, status = crossing(Bodies(*pair), np.array([load]), mu0=0.0, tau0=0.0, model=model)
        if status[0] != friction.STATUS_OK:
            return None
        found = contacts(*pair, float(approach[0]), model=model)
        return MapContacts(pair[1], found.centre[:, 0], found.centre[:, 1], found.force, found.opposing, None)
    try:
        curve = half_space(
            *pair, [load], effective_modulus=effective_modulus, compliance_share=compliance_share, hardness=hardness,
            direction=direction,
        )  # fmt: skip
    except RuntimeError:
        return None
    contact = curve.contact(0)
    touching = contact.pressure > 0
    pressure, patch = contact.pressure[touching], contact.patches[touching]
    total = np.bincount(patch, weights=pressure)[1:]
    along_y, along_x = np.nonzero(touching)
    dy, dx = upper.spacing
    opposing = np.zeros(total.size, dtype=bool)
    opposing[patch - 1] = contact.opposing[touching]
    return MapContacts(
        lower=pair[1],
        x=np.bincount(patch, weights=pressure * along_x)[1:] / total * dx,
        y=np.bincount(patch, weights=pressure * along_y)[1:] / total * dy,
        force=np.asarray(total * dx * dy),
        opposing=opposing,
        pressure=contact.pressure,
    )
