"""One rough area carried over another: friction under given loads at many positions and in many directions."""

from __future__ import annotations

import functools
from concurrent.futures import Executor
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array
from stiction._core import __version__
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE
from stiction.mechanics.load_curve import SurfaceLoadCurve, press
from stiction.mechanics.loading import Bodies, crossing
from stiction.mechanics.model import ContactModel, check_modulus, check_pair, model_of
from stiction.mechanics.quantities import AREAL_VALIDITY, VALIDITY, attributes_of
from stiction.studies.executors import in_order
from stiction.studies.pressing import Load, checked_loads
from stiction.surfaces.pairing import FEWEST_POINTS
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

DIRECTIONS = (0.0, 90.0, 180.0, 270.0)
"""Degrees, if none are asked for."""

_QUANTITIES = (
    "friction_coefficient", "tangential_load", "lateral_load", "contact_area", "contact_count", "approach",
    *VALIDITY, *AREAL_VALIDITY,
)  # fmt: skip

_DIMS = ("direction", "offset", "load")


def traverse_surfaces(
    upper: Any,
    lower: Any,
    loads: ArrayLike,
    *,
    mu0: Any,
    tau0: Any,
    offsets: ArrayLike,
    executor: Executor | None,
    progress: bool,
    load: Load,
    contact: dict[str, Any],
) -> xarray.Dataset:
    """`traverse` of two surfaces."""
    import xarray

    check_pair(upper, lower)
    check_modulus(contact, upper, lower)
    model = model_of(contact)
    if model.direction is None and model.shear == "+x" and "shear" not in contact:
        model = replace(model, direction=DIRECTIONS)
    model = model.for_surfaces()
    angles = np.atleast_1d(model.angles())
    load_values = checked_loads(loads)
    mu0, tau0 = friction.one_material(mu0, tau0, model.effective_modulus)
    places = _places(offsets, upper, lower)
    position = functools.partial(_position, loads=load_values, mu0=mu0, tau0=tau0, model=model, load=load)
    pairs = (overlap(upper, lower, (int(row), int(column))) for row, column in places)
    computed = in_order(position, pairs, total=len(places), what="positions", executor=executor, progress=progress)
    shape = (angles.size, len(places), load_values.size)
    arrays: dict[str, NDArray[Any]] = {name: np.full(shape, np.nan) for name in _QUANTITIES}
    arrays["status"] = np.full(shape, friction.STATUS_OK, dtype=STATUS_DTYPE)
    for place, values in enumerate(computed):
        for name, value in values.items():
            arrays[name][:, place] = value
    along_y, along_x = upper.spacing
    sizes = [overlap(upper, lower, (int(row), int(column)))[0].extent for row, column in places]
    coordinates: dict[str, Any] = {
        "direction": ("direction", angles, attributes_of("direction")),
        "load": ("load", load_values, attributes_of("load")),
        "x": ("offset", places[:, 1] * along_x, {"units": "um", "long_name": "offset of the upper body along +x"}),
        "y": ("offset", places[:, 0] * along_y, {"units": "um", "long_name": "offset of the upper body along +y"}),
        "nominal_area": (
            "offset", np.array([y * x for y, x in sizes]), {"units": "um^2", "long_name": "overlap of both maps"},
        ),
        "mu0": ((), mu0, attributes_of("mu0")),
        "tau0": ((), tau0, attributes_of("tau0")),
        "effective_modulus": ((), float(model.effective_modulus), attributes_of("effective_modulus")),
    }  # fmt: skip
    return xarray.Dataset(
        {name: (_DIMS, arrays[name], attributes_of(name)) for name in (*_QUANTITIES, "status")},
        coordinates,
        {
            "title": "stiction traverse of surfaces",
            "law": str(model.law),
            "detection": str(model.detection),
            "curvature": str(model.curvature),
            "sliding": model.sliding,
            "upper": "\n".join(upper.history),
            "lower": "\n".join(lower.history),
            "stiction_version": __version__,
        },
    )


def overlap(upper: Surface, lower: Surface, place: tuple[int, int]) -> tuple[Surface, Surface]:
    """What of two maps lies above each other when the upper is moved by rows and columns over the lower."""
    of_upper, of_lower = [], []
    for size_upper, size_lower, moved in zip(upper.heights.shape, lower.heights.shape, place, strict=True):
        first, last = max(0, moved), min(size_lower, moved + size_upper)
        of_lower.append(slice(first, max(first, last)))
        of_upper.append(slice(first - moved, max(first, last) - moved))
    return (
        Surface(upper.heights[tuple(of_upper)], spacing=upper.spacing, history=upper.history),
        Surface(lower.heights[tuple(of_lower)], spacing=lower.spacing, history=lower.history),
    )


def _places(offsets: ArrayLike, upper: Surface, lower: Surface) -> NDArray[np.intp]:
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
    if (common < FEWEST_POINTS).any():
        x, y = values[(common < FEWEST_POINTS).any(axis=1)][0]
        raise ValueError(
            f"offsets must leave at least {FEWEST_POINTS} rows and columns of both maps above each other, got ({x:g}, "
            f"{y:g}) µm"
        )
    return np.asarray(places)


def _position(
    pair: tuple[Surface, Surface], *, loads: Floats, mu0: float, tau0: float, model: ContactModel, load: Load
) -> dict[str, NDArray[Any]]:
    """Each quantity and the status at one position, (direction, load) each."""
    bodies = Bodies(*pair)
    angles = np.atleast_1d(model.angles())
    values: dict[str, NDArray[Any]] = {name: np.full((angles.size, loads.size), np.nan) for name in _QUANTITIES}
    status = np.empty((angles.size, loads.size), dtype=STATUS_DTYPE)
    for row, angle in enumerate(angles):
        directed = replace(model, shear="+x", direction=float(angle))
        carrying = {"mu0": mu0, "tau0": tau0} if load == "normal" else {"mu0": 0.0, "tau0": 0.0}
        approach, status[row] = crossing(bodies, loads, **carrying, model=directed)
        ok = np.flatnonzero(status[row] == friction.STATUS_OK)
        if not ok.size:
            continue
        steps, place = np.unique(approach[ok], return_inverse=True)
        curve = press(*pair, steps, model=directed)
        assert isinstance(curve, SurfaceLoadCurve)
        tangential = curve.tangential_load(mu0=mu0, tau0=tau0)
        row_values = {
            "friction_coefficient": tangential / curve.normal_load(mu0=mu0, tau0=tau0),
            "tangential_load": tangential,
            "lateral_load": curve.lateral_load(mu0=mu0, tau0=tau0),
            "contact_area": curve.contact_area,
            "contact_count": curve.contact_count,
            "approach": steps,
            **vars(curve.validity),
        }
        for name, value in row_values.items():
            values[name][row, ok] = value[place]
    return {**values, "status": status}
