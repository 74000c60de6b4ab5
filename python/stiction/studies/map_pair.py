"""One rough area on another at several relative positions: true area and friction around the compass at given loads."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
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
from stiction.mechanics.half_space import HalfSpaceContact, HalfSpaceCurve, half_space
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import ContactModel
from stiction.mechanics.quantities import AREAL_VALIDITY, VALIDITY, attributes_of
from stiction.studies import intervals
from stiction.studies.executors import in_order
from stiction.surfaces.isotropic import isotropic_surface
from stiction.surfaces.preparation import SurfaceTrend, levelled, resampled
from stiction.surfaces.profile import Profile, Side
from stiction.surfaces.self_affine import surrogate
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

SURROGATES = 16
"""Of profiles, which have no areas of their own."""

SEED = 2016

MOST_POINTS = 512
"""Rows and columns of the surfaces that are made of profiles."""

REACH = 4
"""The upper map is moved by at most this part of its length: three quarters of both stay above each other."""

FEWEST_POINTS = 16
"""Rows and columns that are pressed."""

_STIFFNESS_STEP = 0.02
"""Share of the approach on both sides of it over which the stiffness of asperities is taken."""

_OF_FRICTION = ("friction_coefficient", "normal_load")
_OF_CONTACT = (
    "contact_area", "contact_area_fraction", "contact_count", "normal_stiffness", "approach", "error",
    "load_share_at_hardness", "share_on_largest", "share_at_edge", "share_on_steepest_upper",
    "share_on_steepest_lower", *VALIDITY, *AREAL_VALIDITY,
)  # fmt: skip

QUANTILES = tuple(round(0.05 * step, 2) for step in range(1, 20))
"""Of contact sizes and pressures."""

_OF_DISTRIBUTION = ("patch_area", "pressure")

STEEPEST = 0.1
"""Share of a body whose slopes are its steepest."""

_OF_CONTACTS = {
    "contact_shift": ("1", "index of the shift that a contact belongs to"),
    "contact_load": ("1", "index of the load that a contact belongs to"),
    "contact_x": ("um", "middle of a contact along x"),
    "contact_y": ("um", "middle of a contact along y"),
    "contact_force": ("mN", "load on a contact"),
    "contact_patch_area": ("um^2", "area of a contact on the ground plan"),
    "contact_slope_x": ("1", "mean slope of a contact along x"),
    "contact_slope_y": ("1", "mean slope of a contact along y; it opposes the directions in which it rises"),
}
"""Of each contact; the first two are whole numbers."""

_FRICTION_DIMS = ("sliding", "direction", "shift", "load", "mu0", "tau0")
FRICTION_SUMS = (
    "normal_elastic", "normal_frictional", "normal_adhesive", "tangential_elastic", "tangential_frictional",
    "tangential_adhesive",
)  # fmt: skip
"""Of which normal and tangential load are made for any mu0 and tau0; see `Sums`."""


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
    effective_modulus: float = 10.0,
    compliance_share: float = 0.5,
    hardness: float | None = None,
    executor: Executor | None = None,
    progress: bool = False,
) -> xarray.Dataset:
    """True area and friction of two maps at given loads, at several relative positions, by both sliding rules.

    Parameters
    ----------
    upper, lower : Surface or Profile
        Both of one kind; heights of the upper body are up, as `turned_over` makes them. Surfaces lie on the same grid.
        Profiles stand for isotropic surfaces, of which `isotropic_surface` makes surrogates.
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
        contact_count, normal_stiffness (mN/µm), approach (µm), share_on_largest (of the load, on the contact that
        carries most), share_on_steepest_upper and _lower (on the steepest tenth of each body), of the half-space its
        error, load_share_at_hardness and share_at_edge (on contacts cut by the edge), of asperities the figures of
        `SurfaceValidity`; over quantile as well patch_area (µm², of the contacts) and pressure (GPa, of the true area).
        Of the gap at each shift: rms_gradient, rms_slope along each direction, and what `gentle_friction` makes of
        them. Every contact over contact: contact_x and _y (µm), _force (mN), _patch_area (µm²), _slope_x and _y, and
        the indices contact_shift and contact_load. Coordinates x and y (µm) are how far the upper map moved, and
        surrogate says which shifts are none but pairs of surrogates.
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
    places = Pieces.of(upper, lower, shifts=shifts, surrogates=surrogates, seed=seed, level=level)
    half_spaces: dict[str, Any] = {"compliance_share": compliance_share, "hardness": hardness}
    chosen: dict[str, Any] = {
        "loads": load_values, "mu0": material[0], "tau0": material[1], "angles": angles, "modulus": modulus,
    }  # fmt: skip
    pressed: Any = functools.partial(_asperities, **chosen)
    if mechanics == "half-space":
        pressed = functools.partial(_half_space, **chosen, **half_spaces)
    computed = in_order(pressed, places, total=len(places), what="shifts", executor=executor, progress=progress)
    parts = list(computed)
    listed = [part.pop("contacts") for part in parts]
    variables = {
        name: (_dims(name), np.stack([part[name] for part in parts], axis=_dims(name).index("shift")), _named(name))
        for name in parts[0]
    }
    variables |= _contact_variables(listed)
    dy, dx = places.spacing
    moved = np.vstack([places.moved, np.zeros((places.surrogates, 2), dtype=np.int64)])
    return xarray.Dataset(
        variables,
        {
            "sliding": ("sliding", list(SLIDING), {"long_name": "which contacts rub and push"}),
            "direction": ("direction", angles, attributes_of("direction")),
            "x": ("shift", moved[:, 1] * dx, {"units": "um", "long_name": "how far the upper map is moved along +x"}),
            "y": ("shift", moved[:, 0] * dy, {"units": "um", "long_name": "how far the upper map is moved along +y"}),
            "surrogate": (
                "shift", np.arange(len(places)) >= len(places.moved),
                {"long_name": "whether it is a pair of surrogates"},
            ),
            "quantile": ("quantile", list(QUANTILES), {"units": "1", "long_name": "share that is smaller"}),
            "load": ("load", load_values, attributes_of("load")),
            "mu0": ("mu0", material[0], attributes_of("mu0")),
            "tau0": ("tau0", material[1], attributes_of("tau0")),
            "effective_modulus": ((), modulus, attributes_of("effective_modulus")),
            "nominal_area": (
                (), places.area, {"units": "um^2", "long_name": "what lies above each other"},
            ),
        },
        {
            "title": TITLE,
            "mechanics": mechanics,
            "shape": np.array(places.shape),
            "spacing_um": np.array(places.spacing),
            "level": level,
            "seed": seed,
            "of_profiles": int(isinstance(upper, Profile)),
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
    if name in FRICTION_SUMS:
        return _FRICTION_DIMS[:4]
    return {
        "share_opposing": ("direction", "shift", "load"),
        "patch_area": ("quantile", "shift", "load"),
        "pressure": ("quantile", "shift", "load"),
        "rms_gradient": ("shift",),
        "rms_slope": ("direction", "shift"),
        "gentle_friction": ("sliding", "direction", "shift", "mu0", "tau0"),
    }.get(name, ("shift", "load"))


_NAMES = {
    "normal_load": ("mN", "normal load while sliding starts, friction on slopes included"),
    "contact_area_fraction": ("1", "true contact area over what lies above each other"),
    "error": ("1", "error of the half-space, in deviations of the gap"),
    "load_share_at_hardness": ("1", "share of the load where the pressure is the hardness"),
    "share_on_largest": ("1", "share of the load on the contact that carries most"),
    "share_on_steepest_upper": ("1", "share of the load on the steepest tenth of the upper body"),
    "share_on_steepest_lower": ("1", "share of the load on the steepest tenth of the lower body"),
    "patch_area": ("um^2", "areas of contacts on the ground plan"),
    "pressure": ("GPa", "pressures over the true area"),
    "share_at_edge": ("1", "share of the load on contacts that reach the edge of the overlap"),
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


@dataclass(frozen=True, eq=False)
class Pieces:
    """The pairs of pieces of two bodies that `pressed_maps` presses, made one after the other.

    Attributes
    ----------
    upper, lower : Surface or Profile
        On one grid.
    moved : (shifts, 2) ndarray of int
        Rows and columns by which the upper map is moved at each shift.
    surrogates, seed : int
    level : {"plane", "quadratic", "mean"}
    whole : (int, int)
        Rows and columns of the maps, or of the surfaces made of profiles.
    spacing : (float, float), µm
    """

    upper: Surface | Profile
    lower: Surface | Profile
    moved: NDArray[np.int64]
    surrogates: int
    seed: int
    level: SurfaceTrend
    whole: tuple[int, int]
    spacing: tuple[float, float]

    @classmethod
    def of(
        cls,
        upper: Surface | Profile,
        lower: Surface | Profile,
        *,
        shifts: int | None = None,
        surrogates: int | None = None,
        seed: int = SEED,
        level: SurfaceTrend = "plane",
    ) -> Pieces:
        """With the arguments of `pressed_maps`."""
        choice("level", level, SurfaceTrend)
        seed = whole_number("seed", seed, least=0)
        if isinstance(upper, Profile) and isinstance(lower, Profile):
            if shifts:
                raise ValueError(f"shifts are of maps; of profiles surrogates are pressed, got shifts={shifts!r}")
            count = whole_number("surrogates", SURROGATES if surrogates is None else surrogates, least=1)
            step = min(upper.spacing, lower.spacing)
            upper, lower = resampled(upper, step), resampled(lower, step)
            points = min(len(upper), len(lower), MOST_POINTS)
            _enough((points, points))
            none = np.zeros((0, 2), dtype=np.int64)
            return cls(upper, lower, none, count, seed, level, (points, points), (step, step))
        _check(upper, lower)
        assert isinstance(upper, Surface)
        assert isinstance(lower, Surface)
        count = whole_number("surrogates", 0 if surrogates is None else surrogates, least=0)
        asked = SHIFTS if shifts is None else shifts
        moved = np.zeros((0, 2), dtype=np.int64) if asked == 0 and count else displacements(upper, lower, asked)
        rows, columns = upper.heights.shape
        return cls(upper, lower, moved, count, seed, level, (rows, columns), upper.spacing)

    def __len__(self) -> int:
        """Return the number of shifts and surrogates."""
        return len(self.moved) + self.surrogates

    @property
    def shape(self) -> tuple[int, ...]:
        """Rows and columns of each piece."""
        return _window_shape(self.whole)

    @property
    def area(self) -> float:
        """Of each piece, µm²."""
        return float(np.prod(self.shape) * np.prod(self.spacing))

    def pair(self, index: int) -> tuple[Surface, Surface]:
        """The pieces of one shift or, after these, of one pair of surrogates."""
        if index < len(self.moved):
            assert isinstance(self.upper, Surface)
            assert isinstance(self.lower, Surface)
            rows, columns = self.moved[index]
            return window(self.upper, self.lower, (int(rows), int(columns)), self.level)
        repetition = index - len(self.moved)
        upper, lower = self._stand_in("upper", repetition), self._stand_in("lower", repetition)
        return window(upper, lower, (0, 0), self.level)

    def _stand_in(self, side: Side, repetition: int) -> Surface:
        body = self.upper if side == "upper" else self.lower
        if isinstance(body, Profile):
            return isotropic_surface(body, self.seed, shape=self.whole, repetition=repetition, side=side)
        return surrogate(body, self.seed, repetition=repetition, side=side)

    def __iter__(self) -> Iterator[tuple[Surface, Surface]]:
        """Each pair of pieces."""
        return (self.pair(index) for index in range(len(self)))


def overlap_area(upper: Surface | Profile, lower: Surface | Profile) -> float:
    """What `pressed_maps` presses of two maps at each shift, µm²."""
    return Pieces.of(upper, lower, shifts=None if isinstance(upper, Profile) else 1).area


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


def window(
    upper: Surface, lower: Surface, moved: tuple[int, int], level: SurfaceTrend = "plane"
) -> tuple[Surface, Surface]:
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
    return levelled(cut[0], level), levelled(cut[1], level)


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
    _enough(upper.heights.shape)


def _enough(shape: tuple[int, ...]) -> None:
    if min(_window_shape(shape)) < FEWEST_POINTS:
        raise ValueError(f"at least {FEWEST_POINTS} rows and columns must lie above each other, got maps of {shape}")


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
) -> dict[str, Any]:
    """Each quantity at one position; a load without a solution leaves the others theirs."""
    solve = functools.partial(
        half_space, *pair, effective_modulus=modulus, compliance_share=compliance_share, hardness=hardness,
        direction=angles.tolist(),
    )  # fmt: skip
    values = _nothing(loads, mu0, tau0, angles, friction.STATUS_NOT_SOLVED)
    steepness = _slopes_of(pair)
    dy, dx = pair[0].spacing
    for at, curve in solved(solve, loads):
        _fill(values, at, curve, curve.with_sliding("all"), mu0, tau0)
        values["normal_stiffness"][at] = curve.stiffness
        for name in ("approach", "error", "load_share_at_hardness"):
            values[name][at] = getattr(curve, name)
        for place, load in enumerate(at):
            contact = curve.contact(place)
            table = _patches(contact, steepness, compliance_share)
            scales = {"x": dx, "y": dy, "force": dx * dy, "patch_area": dx * dy}
            table = {name: scales.get(name, 1.0) * column for name, column in table.items()}
            pressure = contact.pressure[contact.pressure > 0]
            _distribute(values, int(load), table, pressure, np.ones(pressure.size))
            patches = contact.patches
            edges = np.unique(np.concatenate([patches[0], patches[-1], patches[:, 0], patches[:, -1]]))
            carried = np.append(0.0, table["force"])
            values["share_at_edge"][load] = carried[edges].sum() / carried.sum()
            for side, body in steepness.items():
                share = contact.pressure[body.magnitude > body.steep].sum() / pressure.sum()
                values[f"share_on_steepest_{side}"][load] = share
    return _completed(values, steepness, pair, mu0, tau0, angles, modulus)


def solved(solve: Callable[[Floats], HalfSpaceCurve], loads: Floats) -> list[tuple[NDArray[np.intp], HalfSpaceCurve]]:
    """The curves of a half-space and which loads are theirs; a load without a solution is in none."""
    try:
        return [(np.arange(loads.size), solve(loads))]
    except RuntimeError:
        curves = []
        for index in range(loads.size):
            try:
                curves.append((np.array([index]), solve(loads[index : index + 1])))
            except RuntimeError:
                continue
        return curves


@dataclass(frozen=True, eq=False)
class _Slopes:
    """Of a body at each point, along y and x, their magnitude, and that from which on they are its steepest."""

    along_y: Floats
    along_x: Floats
    magnitude: Floats
    steep: float


def _slopes_of(pair: tuple[Surface, Surface]) -> dict[Side, _Slopes]:
    from stiction.mechanics.patches import slopes

    found: dict[Side, _Slopes] = {}
    sides: tuple[Side, Side] = ("upper", "lower")
    for side, body in zip(sides, pair, strict=True):
        along_y, along_x = slopes(body.heights, body.spacing, periodic=False)
        magnitude = np.hypot(along_y, along_x)
        found[side] = _Slopes(along_y, along_x, magnitude, float(np.quantile(magnitude, 1 - STEEPEST)))
    return found


def _patches(contact: HalfSpaceContact, bodies: dict[Side, _Slopes], compliance_share: float) -> dict[str, Floats]:
    """Places (in points), forces (mN per µm² of a point), areas (points) and mean slopes of the contacts."""
    from stiction.mechanics.patches import true_share

    touching = contact.pressure > 0
    pressure, patch = contact.pressure[touching], contact.patches[touching] - 1
    total = np.bincount(patch, weights=pressure)
    above, below = bodies["upper"], bodies["lower"]
    along = [
        (1 - compliance_share) * of_lower[touching] + compliance_share * of_upper[touching]
        for of_lower, of_upper in ((below.along_x, above.along_x), (below.along_y, above.along_y))
    ]
    y, x = np.nonzero(touching)
    x_mean, y_mean, slope_x, slope_y = (
        np.bincount(patch, weights=pressure * each) / total for each in (x, y, *along)
    )  # fmt: skip
    area = np.bincount(patch, weights=true_share(touching, periodic=False))
    columns = (x_mean, y_mean, total, slope_x, slope_y, area)
    names = ("x", "y", "force", "slope_x", "slope_y", "patch_area")
    return {name: np.asarray(column, dtype=np.float64) for name, column in zip(names, columns, strict=True)}


def _distribute(values: dict[str, Any], load: int, table: dict[str, Floats], pressure: Floats, weights: Floats) -> None:
    """Sizes and pressures of the contacts at a load."""
    values["contacts"].append((load, table))
    values["patch_area"][:, load] = np.quantile(table["patch_area"], QUANTILES)
    order = np.argsort(pressure, kind="stable")
    below = np.cumsum(weights[order])
    values["pressure"][:, load] = np.interp(QUANTILES, (below - weights[order] / 2) / below[-1], pressure[order])
    values["share_on_largest"][load] = table["force"].max() / table["force"].sum()


def _contact_variables(listed: list[list[tuple[int, dict[str, Floats]]]]) -> dict[str, Any]:
    """The contacts of all shifts and loads, one row each."""
    columns: dict[str, list[NDArray[Any]]] = {name: [] for name in _OF_CONTACTS}
    for shift, tables in enumerate(listed):
        for load, table in tables:
            size = table["force"].size
            columns["contact_shift"].append(np.full(size, shift))
            columns["contact_load"].append(np.full(size, load))
            for name, column in table.items():
                columns[f"contact_{name}"].append(column)
    kinds: dict[str, Any] = {name: np.int64 if name in ("contact_shift", "contact_load") else float for name in columns}
    return {
        name: (
            "contact",
            np.concatenate([np.empty(0, dtype=kinds[name]), *parts]),
            {"units": _OF_CONTACTS[name][0], "long_name": _OF_CONTACTS[name][1]},
        )
        for name, parts in columns.items()
    }


def _asperities(
    pair: tuple[Surface, Surface], *, loads: Floats, mu0: Floats, tau0: Floats, angles: Floats, modulus: float
) -> dict[str, Any]:
    """Each quantity at one position."""
    model = ContactModel(effective_modulus=modulus, direction=angles.tolist()).for_surfaces()
    values = _nothing(loads, mu0, tau0, angles, friction.STATUS_OK)
    steepness = _slopes_of(pair)
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
        for load in ok:
            touching = contacts(found, float(approach[load]), model=replace(model, direction=0.0))
            slope = -touching.normal[:, :2] / touching.normal[:, 2:]
            table = {
                "x": touching.centre[:, 0], "y": touching.centre[:, 1], "patch_area": touching.area,
                "force": touching.force * touching.normal[:, 2], "slope_x": slope[:, 0], "slope_y": slope[:, 1],
            }  # fmt: skip
            _distribute(values, int(load), table, touching.force / touching.area, touching.area)
            magnitude = np.hypot(*slope.T)  # of both bodies: at a minimum of the gap they are alike
            for side, body in steepness.items():
                steep = table["force"][magnitude > body.steep].sum() / table["force"].sum()
                values[f"share_on_steepest_{side}"][load] = steep
    return _completed(values, steepness, pair, mu0, tau0, angles, modulus)


def _nothing(loads: Floats, mu0: Floats, tau0: Floats, angles: Floats, status: str) -> dict[str, Any]:
    whole = (len(SLIDING), angles.size, loads.size, mu0.size, tau0.size)
    values: dict[str, Any] = {"contacts": []} | {name: np.full(whole, np.nan) for name in _OF_FRICTION}
    values |= {"status": np.full(whole, status, dtype=STATUS_DTYPE)}
    values |= {name: np.full(whole[:3], np.nan) for name in FRICTION_SUMS}
    values |= {"share_opposing": np.full((angles.size, loads.size), np.nan)}
    values |= {name: np.full((len(QUANTILES), loads.size), np.nan) for name in _OF_DISTRIBUTION}
    return values | {name: np.full(loads.size, np.nan) for name in _OF_CONTACT}


def _fill(
    values: dict[str, Any],
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
        for name in FRICTION_SUMS:
            # The elastic load has no direction.
            values[name][rule][:, where] = np.broadcast_to(getattr(curve, name), normal.shape[2:])[:, at]
    # Of Σ F |t·s|, which is the load but for the squares of slopes.
    with np.errstate(divide="ignore", invalid="ignore"):
        share = opposing.tangential_frictional / every.tangential_frictional
    values["share_opposing"][:, where] = share[:, at]
    values["contact_area"][where] = opposing.contact_area[at]
    values["contact_count"][where] = opposing.contact_count[at]


def _completed(
    values: dict[str, Any],
    bodies: dict[Side, _Slopes],
    pair: tuple[Surface, Surface],
    mu0: Floats,
    tau0: Floats,
    angles: Floats,
    modulus: float,
) -> dict[str, Any]:
    """With the share of the area, and what the gap's slopes alone say."""
    values["contact_area_fraction"] = values["contact_area"] / np.prod(pair[0].extent)
    above, below = bodies["upper"], bodies["lower"]
    along_y, along_x = above.along_y - below.along_y, above.along_x - below.along_x
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
        Its quantities without shift, with statistic ("mean", "lower", "upper"), over those shifts that have an answer,
        and how many these are (ok, over the dimensions of the status) of how many (shifts).

    Notes
    -----
    The interval is Student's t over the shifts, NaN for fewer than 3, not below 0 where no value is, and of shares not
    above 1. Over shifts it says how well the mean over all shifts of *these two maps* is known: they have heights in
    common, and of other pieces of the surfaces it knows nothing. Over surrogates, which are independent, it says how
    well the mean over surfaces with *the spectra of these maps* is known.
    """
    import xarray

    result = kind_of(result, surrogates)
    variables: dict[str, Any] = {}
    for name, values in result.data_vars.items():
        if values.dtype.kind != "f" or "shift" not in values.dims:
            continue
        first = values.transpose("shift", ...)
        statistics = np.stack(intervals.of_sample(first.values), axis=-1)
        if str(name).startswith("share_"):
            statistics = np.minimum(statistics, 1.0)
        variables[str(name)] = ((*first.dims[1:], "statistic"), statistics, values.attrs)
    ok = (result["status"] == friction.STATUS_OK).sum("shift")
    coordinates = {name: each for name, each in result.coords.items() if "shift" not in each.dims}
    return xarray.Dataset(
        variables | {"ok": ok.assign_attrs(long_name="shifts with an answer"), "shifts": ((), result.sizes["shift"])},
        coordinates | {"statistic": ["mean", "lower", "upper"]},
        result.attrs,
    )


OF_SURROGATES = " (surrogates)"
"""Behind the name of the mechanics, where means over shifts and over surrogates stand side by side."""


def means_of_all(result: xarray.Dataset) -> xarray.Dataset:
    """`pressed_maps_mean` of a joined result: of its shifts and, as further mechanics, of its surrogates."""
    import xarray

    mean = pressed_maps_mean(result)
    of = result["surrogate"].values if "surrogate" in result.coords else np.zeros(1, dtype=bool)
    if of.all() or not of.any():
        return mean
    others = pressed_maps_mean(result, surrogates=True)
    names = [f"{name}{OF_SURROGATES}" for name in others["mechanics"].values]
    return xarray.concat(
        [mean, others.assign_coords(mechanics=names)], "mechanics", combine_attrs="override", data_vars="all"
    )


def kind_of(result: xarray.Dataset, surrogates: bool | None = None) -> xarray.Dataset:
    """The shifts of a result, or its pairs of surrogates; contacts are left out."""
    of = result["surrogate"].values if "surrogate" in result.coords else np.zeros(result.sizes["shift"], dtype=bool)
    wanted = bool(of.all()) if surrogates is None else surrogates
    if not (of == wanted).any():
        raise ValueError(f"surrogates must be {not wanted} where there are no others, got {surrogates!r}")
    kept = result.drop_dims("contact") if "contact" in result.dims else result
    return kept.isel(shift=np.flatnonzero(of == wanted))


# ---- For pictures ----------------------------------------------------------------------------------------------------

MOST_PICTURED = 512
"""Rows and columns of a map that a result keeps."""

_AROUND_LARGEST = 8
"""Part of the map that is kept of the pressure about the contact that carries most."""


def joined(results: Sequence[xarray.Dataset], mechanics: Sequence[str], loads: ArrayLike) -> xarray.Dataset:
    """Results by several mechanics as one, with a dimension mechanics; contacts are kept at some loads alone."""
    import xarray

    plain = [result.drop_dims("contact") for result in results]
    whole = xarray.concat(
        plain, xarray.Variable("mechanics", list(mechanics)), combine_attrs="override", data_vars="all"
    )
    asked = np.flatnonzero(np.isin(whole["load"].values, loads))
    listed = []
    for index, result in enumerate(results):
        rows = result[list(_OF_CONTACTS)].isel(contact=np.flatnonzero(np.isin(result["contact_load"].values, asked)))
        rows = rows.reset_coords(drop=True)
        rows["contact_mechanics"] = (
            "contact", np.full(rows.sizes["contact"], index), {"units": "1", "long_name": "index of the mechanics"},
        )  # fmt: skip
        listed.append(rows)
    return whole.merge(xarray.concat(listed, "contact", combine_attrs="override", data_vars="all"))


def with_picture(result: xarray.Dataset, places: Pieces, shift: int, load: float, **elastic: Any) -> xarray.Dataset:
    """A joined result with the heights of both pieces at a shift, thinned, and pressures about its largest contact.

    They are upper_height and lower_height over height_y and height_x (µm), and of the half-space zoom_pressure (GPa)
    and zoom_height (µm, of the lower body) over zoom_y and zoom_x, all from the first corner of the pieces on.
    `elastic` are arguments of `half_space`.
    """
    pair = places.pair(shift)
    (rows, columns), (dy, dx) = places.shape, places.spacing
    step = -(-max(rows, columns) // MOST_PICTURED)
    length = {"units": "um"}
    variables: dict[str, Any] = {
        f"{side}_height": (("height_y", "height_x"), body.heights[::step, ::step], length)
        for side, body in zip(("upper", "lower"), pair, strict=True)
    }
    coordinates = {
        "height_y": ("height_y", np.arange(0, rows, step) * dy, length),
        "height_x": ("height_x", np.arange(0, columns, step) * dx, length),
    }
    if "half-space" in result["mechanics"].values:
        try:
            pressure = half_space(*pair, [load], **elastic).contact(0).pressure
        except RuntimeError:
            pressure = None
        if pressure is not None:
            found = contacts_at(result, shift, load, "half-space")
            most = int(np.argmax(found["contact_force"].values))
            box = []
            for size, at in (
                (rows, float(found["contact_y"][most]) / dy),
                (columns, float(found["contact_x"][most]) / dx),
            ):
                part = min(max(size // _AROUND_LARGEST, FEWEST_POINTS), size)
                first = int(np.clip(at - part / 2, 0, size - part))
                box.append(slice(first, first + part))
            variables["zoom_pressure"] = (("zoom_y", "zoom_x"), pressure[tuple(box)], {"units": "GPa"})
            variables["zoom_height"] = (("zoom_y", "zoom_x"), pair[1].heights[tuple(box)], length)
            coordinates["zoom_y"] = ("zoom_y", np.arange(box[0].start, box[0].stop) * dy, length)
            coordinates["zoom_x"] = ("zoom_x", np.arange(box[1].start, box[1].stop) * dx, length)
    return result.assign(variables).assign_coords(coordinates).assign_attrs(pictured_shift=shift, pictured_load_mN=load)


def contacts_at(result: xarray.Dataset, shift: int, load: float, mechanics: str) -> xarray.Dataset:
    """The contacts of a joined result at one shift and load."""
    at = int(np.argmin(np.abs(result["load"].values - load)))
    by = [str(name) for name in result["mechanics"].values].index(mechanics)
    rows = (
        (result["contact_shift"].values == shift)
        & (result["contact_load"].values == at)
        & (result["contact_mechanics"].values == by)
    )
    names = [
        str(name) for name in result.data_vars if str(name).startswith("contact_") and result[name].dims == ("contact",)
    ]
    return result[names].isel(contact=np.flatnonzero(rows))
