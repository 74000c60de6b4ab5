"""What a result looks like: an xarray dataset with units, names and the study it is of.

A result holds sums over contacts of every member of its study, at every step, sliding rule and direction. Its
dimensions are the cells of the study (fractal dimension and amplitude of generated bodies, the cut-off of measured
ones), the members (`repetition`), the motions of which there is a list, and the step (approach or load).
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import check_instance, number
from stiction._core import __version__
from stiction.mechanics.friction import STATUSES
from stiction.mechanics.quantities import DISTRIBUTIONS, GAP, QUANTITIES, STATISTICS, attributes_of
from stiction.studies.contact_statistics import QUANTILES
from stiction.studies.measured_surfaces import BodyAttributes
from stiction.studies.study import Study

if TYPE_CHECKING:
    import xarray

TITLE = "stiction study"  # of every result
MAX_PIECE_BYTES = 2**26  # bytes of a result that are in memory at a time, where it is read piece by piece

MEMBER_COORDINATES: dict[str, np.dtype[Any]] = {
    "x": np.dtype(np.float64), "y": np.dtype(np.float64), "line": np.dtype(np.int64), "surrogate": np.dtype(np.bool_),
}  # fmt: skip
"""Coordinates along `repetition` that say what a member of measured bodies is, with their kind."""

Arrays = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class ArraySpec:
    """An array of a result before there is any: its dimensions and their sizes, its kind, units and names."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    attributes: dict[str, Any]

    @property
    def size(self) -> int:
        """Bytes."""
        return self.dtype.itemsize * math.prod(self.shape)


def list_coordinates(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None
) -> dict[str, tuple[ArraySpec, NDArray[Any]]]:
    """The coordinates of a result, or of some of its repetitions, with their values, in the order of its dimensions."""
    values: dict[str, NDArray[Any]] = {
        **study.surfaces.cells(),
        "repetition": np.arange(study.ensemble.repetitions) if repetitions is None else np.array(repetitions, np.int64),
        **{name: np.array(each) for name, each in study.motions().items()},
        study.step: study.contact.steps(),
    }
    if study.is_measured:
        values["fraction_below"] = np.array(QUANTILES)
    more: dict[str, dict[str, str]] = {"load": {"long_name": "normal load of the elastic contact, without friction"}}
    if not study.is_measured:
        surfaces: Any = study.surfaces
        more["fractal_dimension"] = {"convention": surfaces.convention}
        more["amplitude"] = {"measure": surfaces.amplitude_measure}
    return {
        name: (ArraySpec((name,), each.shape, each.dtype, attributes_of(name) | more.get(name, {})), each)
        for name, each in values.items()
    }


def list_variables(study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None) -> dict[str, ArraySpec]:
    """The variables of a result, or of some of its repetitions."""
    sizes = {name: each.size for name, (_, each) in list_coordinates(study, repetitions).items()}
    found = {}
    for name in variable_names(study):
        dims = _dims(study, name)
        dtype = np.dtype(QUANTITIES[name].dtype)
        attributes: dict[str, Any] = dict(attributes_of(name))
        if name == "status":
            attributes |= {"flag_values": np.arange(len(STATUSES)), "flag_meanings": " ".join(STATUSES)}
        found[name] = ArraySpec(dims, tuple(sizes[dim] for dim in dims), dtype, attributes)
    return found


def member_bytes(study: Study) -> int:
    """Bytes of the numbers of one member."""
    return sum(each.size for each in list_variables(study, [0]).values())


def piece_length(size: int) -> int:
    """How many members of so many bytes are in memory at a time, a power of two."""
    return 1 << max(0, (MAX_PIECE_BYTES // max(1, size)).bit_length() - 1)


def variable_names(study: Study) -> tuple[str, ...]:
    """Names of the variables of a result: the study's sums, and of measured bodies the statistics of contacts."""
    if not study.is_measured:
        return study.sums()
    return tuple(dict.fromkeys((*study.sums(), *STATISTICS, *DISTRIBUTIONS, *GAP)))


def _dims(study: Study, name: str) -> tuple[str, ...]:
    """Return the dimensions of a stored variable; of one sliding rule or direction there is no dimension."""
    dims = {"step": study.step, "fraction_below": "fraction_below"} | {motion: motion for motion in study.motions()}
    return (*study.surfaces.cells(), "repetition", *(dims[each] for each in QUANTITIES[name].along if each in dims))


def stack_members(study: Study, members: Sequence[Arrays]) -> Arrays:
    """Arrays of several members as those of a result: one more axis, behind the cells."""
    axis = len(study.surfaces.cells())
    return {
        name: np.stack([each[name] for each in members], axis=0 if name in MEMBER_COORDINATES else axis)
        for name in members[0]
    }


def build_dataset(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp], arrays: Mapping[str, NDArray[Any]],
    about: BodyAttributes | None = None,
) -> xarray.Dataset:  # fmt: skip
    """The dataset of some repetitions, from arrays as `stack_members` makes them, of the shapes that the study says."""
    import xarray

    variables = list_variables(study, repetitions)
    for name, each in variables.items():
        if name not in arrays or arrays[name].shape != each.shape:
            raise ValueError(f"{name} of the result is not what its study says: {each.shape} wanted")
    coordinates: dict[str, Any] = {
        name: xarray.Variable(each.dims, values, each.attributes)
        for name, (each, values) in list_coordinates(study, repetitions).items()
    }
    about = about or BodyAttributes()
    if study.is_measured:
        coordinates |= {
            name: xarray.Variable(("repetition",), np.asarray(arrays[name], dtype), attributes_of(name))
            for name, dtype in MEMBER_COORDINATES.items()
        }
        modulus = float(study.contact.effective_modulus)
        for name, value in (("nominal_area", about.nominal_area), ("effective_modulus", modulus)):
            coordinates[name] = xarray.Variable((), value, attributes_of(name))
    return xarray.Dataset(
        {name: xarray.Variable(each.dims, arrays[name], each.attributes) for name, each in variables.items()},
        coordinates,
        {"title": TITLE, "study": study.to_toml(), "stiction_version": __version__} | about.attributes,
    )


# ---- Without units ---------------------------------------------------------------------------------------------------

_SCALES = {
    "mN": (1, 2, "(E* L²)"),
    "mN/um": (1, 1, "(E* L)"),
    "mN/GPa": (0, 2, "L²"),
    "GPa": (1, 0, "E*"),
    "um^2": (0, 2, "L²"),
    "um": (0, 1, "L"),
}
"""Powers of E* and L that a quantity of each unit is divided by, and how that is written."""


def nondimensional(
    result: xarray.Dataset, *, length: float | None = None, effective_modulus: float | None = None
) -> xarray.Dataset:
    """Divide loads, areas, pressures and lengths of a dataset by E* and L, so that all values are dimensionless.

    Parameters
    ----------
    result : xarray.Dataset
        The dataset of a result, or what `friction_map`, `area_map`, `stiffness_map` or `Result.at` returns.
    length : float, µm, optional
        L; by default the length scale of the result's study, or the longest wavelength of self-affine surfaces.
        Measured bodies have no length scale, so L must be given.
    effective_modulus : float, GPa, optional
        E*; by default that of the result.

    Returns
    -------
    xarray.Dataset
        The same values divided by powers of E* and L, which their `long_name` says; units are "1".

    Raises
    ------
    ValueError
        If length or modulus are not above 0, are needed and not given, or something has an unknown unit.

    Notes
    -----
    With spheres (not with cylinders, whose width is a length of its own) loads, areas and friction of surfaces that are
    scaled by a factor in all lengths are the same numbers: the coefficient depends on tau0/E* alone.

    Examples
    --------
    >>> from stiction import Study, friction_map, nondimensional, run
    >>> study = Study.named("quick").with_changes({"ensemble.repetitions": 1, "surfaces.points": 4000})
    >>> friction = nondimensional(friction_map(run(study), [0.001]))  # mN, with E* = 10 GPa and L = 1 µm
    >>> float(friction["load"][0]), friction["load"].attrs["long_name"]
    (0.0001, 'normal load / (E* L²)')
    """
    import xarray

    check_instance("result", result, xarray.Dataset, "an xarray.Dataset")
    if "study" in result.attrs:
        from stiction.studies.generated_surfaces import Generated
        from stiction.studies.study import study_of

        study = study_of(result)
        if length is None and isinstance(study.surfaces, Generated):
            length = study.surfaces.longest()
        own_modulus: Any = float(study.contact.effective_modulus)
    else:
        own_modulus = float(result["effective_modulus"]) if "effective_modulus" in result.coords else None
    effective_modulus = own_modulus if effective_modulus is None else effective_modulus
    if length is None:
        raise ValueError("length must be given: the result has no length scale of its own")
    if effective_modulus is None:
        raise ValueError("effective_modulus must be given: the result has none")
    length = number("length", length, unit="µm", above=0)
    modulus = number("effective_modulus", effective_modulus, unit="GPa", above=0)

    def scaled(name: str, variable: xarray.Variable) -> xarray.Variable:
        units = variable.attrs.get("units", "1")
        if units in ("1", "degree"):
            return variable
        if units not in _SCALES:
            raise ValueError(f"{name} has the unit {units!r}, which no result has")
        of_modulus, of_length, by = _SCALES[units]
        attributes = {**variable.attrs, "units": "1", "long_name": f"{variable.attrs.get('long_name', name)} / {by}"}
        return xarray.Variable(variable.dims, variable.values / (modulus**of_modulus * length**of_length), attributes)

    return xarray.Dataset(
        {str(name): scaled(str(name), each.variable) for name, each in result.data_vars.items()},
        {str(name): scaled(str(name), each.variable) for name, each in result.coords.items()},
        # Without the study, whose numbers have units.
        {name: value for name, value in result.attrs.items() if name != "study"}
        | {"length_um": length, "effective_modulus_GPa": modulus},
    )
