"""Layout of results as xarray datasets with units, long names, and the study as an attribute.

A result contains sums over the contacts of each member, at every step, sliding rule and direction. Its dimensions are
the cells of the study (fractal dimension and amplitude of generated bodies, cutoff of measured bodies), the members
(`repetition`), the sliding rules and directions that are lists, and the step (approach or load).
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction._checks import check_instance, make_read_only, validate_number
from stiction._core import __version__
from stiction.mechanics.friction import STATUSES
from stiction.mechanics.quantities import (
    DISTRIBUTION_QUANTITIES,
    GAP_QUANTITIES,
    LOAD_STEP_QUANTITIES,
    QUANTITIES,
    quantity_attributes,
)
from stiction.solve.contact_statistics import QUANTILE_PROBABILITIES
from stiction.study.generated_surfaces import GeneratedSurfaceSettings
from stiction.study.member_sources import BodyAttributes
from stiction.study.study import Study, parse_study_of_dataset

if TYPE_CHECKING:
    import xarray

RESULT_TITLE = "stiction study"
MAX_MEMBER_PIECE_BYTES = 2**26  # bytes

MEMBER_COORDINATE_TYPES: dict[str, np.dtype[Any]] = {
    "x": np.dtype(np.float64), "y": np.dtype(np.float64), "line": np.dtype(np.int64), "surrogate": np.dtype(np.bool_),
}  # fmt: skip
"""Data types of the coordinates of measured members: shifts x and y, line number, and whether it is a surrogate."""

ArraysByName = dict[str, NDArray[Any]]

_Value = TypeVar("_Value")


@dataclass(frozen=True)
class ArraySpec:
    """Dimensions, shape, data type and attributes of an array that is stored in a result."""

    dims: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: np.dtype[Any]
    attributes: dict[str, Any]

    @property
    def nbytes(self) -> int:
        """Size of the array in bytes."""
        return self.dtype.itemsize * math.prod(self.shape)


def coordinate_specs_and_values(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None
) -> dict[str, tuple[ArraySpec, NDArray[Any]]]:
    """Return the specification and the values of each coordinate of a result, keyed by coordinate name.

    The coordinates are in the order of the dimensions. `repetitions` selects the members, by default all.
    """
    values_by_name: dict[str, NDArray[Any]] = {
        **study.surfaces.cell_coordinates(),
        "repetition": np.arange(study.ensemble.repetitions) if repetitions is None else np.array(repetitions, np.int64),
        **{name: np.array(entries) for name, entries in study.motion_coordinates().items()},
        study.step_quantity: study.contact.loading_steps(),
    }
    if study.is_measured:
        values_by_name["fraction_below"] = np.array(QUANTILE_PROBABILITIES)
    extra_attributes: dict[str, dict[str, str]] = {
        "load": {"long_name": "normal load of the elastic contact, without friction"}
    }
    if not study.is_measured:
        surfaces: Any = study.surfaces
        extra_attributes["fractal_dimension"] = {"convention": surfaces.convention}
        extra_attributes["amplitude"] = {"measure": surfaces.amplitude_measure}
    return {
        name: (
            ArraySpec((name,), array.shape, array.dtype, quantity_attributes(name) | extra_attributes.get(name, {})),
            array,
        )
        for name, array in values_by_name.items()
    }


def variable_specs(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp] | None = None, names: Collection[str] | None = None
) -> dict[str, ArraySpec]:
    """Return dimensions, shape, data type and attributes of each variable of a result, keyed by its name.

    `repetitions` selects the members, and `names` selects the variables; by default, all are included. Names of other
    variables are ignored.
    """
    sizes = {name: values.size for name, (_, values) in coordinate_specs_and_values(study, repetitions).items()}
    variables = {}
    for name in list_variable_names(study):
        if names is not None and name not in names:
            continue
        dims = _list_dims(study, name)
        dtype = np.dtype(QUANTITIES[name].dtype)
        attributes: dict[str, Any] = dict(quantity_attributes(name))
        if name == "status":
            attributes |= {"flag_values": np.arange(len(STATUSES)), "flag_meanings": " ".join(STATUSES)}
        variables[name] = ArraySpec(dims, tuple(sizes[dim] for dim in dims), dtype, attributes)
    return variables


def compute_bytes_per_member(study: Study) -> int:
    """Return the memory (bytes) that all arrays of one member take."""
    return sum(spec.nbytes for spec in variable_specs(study, [0]).values())


def compute_members_per_piece(size: int) -> int:
    """Return how many members of `size` bytes fit into `MAX_MEMBER_PIECE_BYTES`, as a power of 2 that is at least 1."""
    return 1 << max(0, (MAX_MEMBER_PIECE_BYTES // max(1, size)).bit_length() - 1)


def list_variable_names(study: Study) -> tuple[str, ...]:
    """Return the names of all variables of a result, such as forces and areas summed over contacts."""
    if not study.is_measured:
        return study.contact_sum_names()
    return tuple(
        dict.fromkeys((*study.contact_sum_names(), *LOAD_STEP_QUANTITIES, *DISTRIBUTION_QUANTITIES, *GAP_QUANTITIES))
    )


def _list_dims(study: Study, name: str) -> tuple[str, ...]:
    """Return the dimensions of a stored variable, such as cutoff, member, direction and load.

    Sliding rules and directions are dimensions only if the study has lists of them.
    """
    dims = {"step": study.step_quantity, "fraction_below": "fraction_below"} | {
        motion: motion for motion in study.motion_coordinates()
    }
    return (
        *study.surfaces.cell_coordinates(),
        "repetition",
        *(dims[axis] for axis in QUANTITIES[name].along if axis in dims),
    )


def stack_members(study: Study, members: Sequence[ArraysByName]) -> ArraysByName:
    """Stack the arrays of members along a new axis, which follows the axes of cutoffs or kinds of surfaces."""
    axis = len(study.surfaces.cell_coordinates())
    return {
        name: np.stack([member[name] for member in members], axis=0 if name in MEMBER_COORDINATE_TYPES else axis)
        for name in members[0]
    }


def build_dataset(
    study: Study, repetitions: Sequence[int] | NDArray[np.intp], arrays: Mapping[str, NDArray[Any]],
    bodies: BodyAttributes | None = None, names: Collection[str] | None = None,
) -> xarray.Dataset:  # fmt: skip
    """Build the dataset of a result from the arrays that `stack_members` returned, and check the array shapes.

    The dataset has the variables in `names`, by default all.
    """
    import xarray

    variables = variable_specs(study, repetitions, names)
    for name, spec in variables.items():
        if name not in arrays or arrays[name].shape != spec.shape:
            raise ValueError(f"{name} of the result must have the shape {spec.shape}")
    coordinates: dict[str, Any] = {
        name: xarray.Variable(spec.dims, values, spec.attributes)
        for name, (spec, values) in coordinate_specs_and_values(study, repetitions).items()
    }
    bodies = bodies or BodyAttributes()
    if study.is_measured:
        coordinates |= {
            name: xarray.Variable(("repetition",), np.asarray(arrays[name], dtype), quantity_attributes(name))
            for name, dtype in MEMBER_COORDINATE_TYPES.items()
        }
        modulus = float(study.contact.effective_modulus)
        for name, value in (("nominal_area", bodies.nominal_area), ("effective_modulus", modulus)):
            coordinates[name] = xarray.Variable((), value, quantity_attributes(name))
    return xarray.Dataset(
        {name: xarray.Variable(spec.dims, arrays[name], spec.attributes) for name, spec in variables.items()},
        coordinates,
        {"title": RESULT_TITLE, "study": study.to_toml(), "stiction_version": __version__} | bodies.attributes,
    )


# ---- Nondimensional results ------------------------------------------------------------------------------------------

_MODULUS_AND_LENGTH_POWERS_BY_UNIT = {
    "mN": (1, 2, "(E* L²)"),
    "mN/um": (1, 1, "(E* L)"),
    "mN/GPa": (0, 2, "L²"),
    "GPa": (1, 0, "E*"),
    "um^2": (0, 2, "L²"),
    "um": (0, 1, "L"),
}
"""Divisor of quantities with a given unit in nondimensional results: exponents of E* and of L, and divisor as text."""


def nondimensional(
    result: xarray.Dataset, *, length: float | None = None, effective_modulus: float | None = None
) -> xarray.Dataset:
    """Make all quantities in a dataset dimensionless: divide them by powers of E* and of a length L.

    Parameters
    ----------
    result : xarray.Dataset
        Dataset of a result, or of `friction_map`, `area_map`, `stiffness_map` or `Result.at`.
    length : float, µm, optional
        L; by default the length scale in the study, or the longest wavelength of self-affine surfaces. Measured bodies
        have no length scale, so L must be given.
    effective_modulus : float, GPa, optional
        E*; by default the modulus of the result.

    Returns
    -------
    xarray.Dataset
        The values divided by powers of E* and L. The attribute `long_name` states the divisor; units are "1".

    Raises
    ------
    ValueError
        If length or modulus is missing or not above 0, or if a variable has an unknown unit.

    Notes
    -----
    With the law of spheres, nondimensional loads, areas and friction do not change if all lengths of the surfaces are
    scaled by a factor, and the coefficient depends only on tau0/E*. For the law of cylinders this requires that the
    width is scaled too.

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
        study = parse_study_of_dataset(result)
        if length is None and isinstance(study.surfaces, GeneratedSurfaceSettings):
            length = study.surfaces.max_wavelength()
        result_modulus: Any = float(study.contact.effective_modulus)
    else:
        result_modulus = float(result["effective_modulus"]) if "effective_modulus" in result.coords else None
    effective_modulus = result_modulus if effective_modulus is None else effective_modulus
    if length is None:
        raise ValueError("length must be given, because the result has no length scale")
    if effective_modulus is None:
        raise ValueError("effective_modulus must be given, because the result does not contain it")
    length = validate_number("length", length, unit="µm", above=0)
    modulus_value = validate_number("effective_modulus", effective_modulus, unit="GPa", above=0)

    def divide_by_units(name: str, variable: xarray.Variable) -> xarray.Variable:
        units = variable.attrs.get("units", "1")
        if units in ("1", "degree"):
            return variable
        if units not in _MODULUS_AND_LENGTH_POWERS_BY_UNIT:
            raise ValueError(f"{name} has the unknown unit {units!r}")
        modulus_power, length_power, divisor = _MODULUS_AND_LENGTH_POWERS_BY_UNIT[units]
        attributes = {
            **variable.attrs,
            "units": "1",
            "long_name": f"{variable.attrs.get('long_name', name)} / {divisor}",
        }
        return xarray.Variable(
            variable.dims, variable.values / (modulus_value**modulus_power * length**length_power), attributes
        )

    return xarray.Dataset(
        {str(name): divide_by_units(str(name), array.variable) for name, array in result.data_vars.items()},
        {str(name): divide_by_units(str(name), array.variable) for name, array in result.coords.items()},
        # The dimensionless dataset has no attribute `study`, because the lengths and pressures in it have units.
        {name: value for name, value in result.attrs.items() if name != "study"}
        | {"length_um": length, "effective_modulus_GPa": modulus_value},
    )


def arrange_axes(variable: xarray.Variable, dims: Iterable[str]) -> NDArray[Any]:
    """Return the values of a variable as an array, with the dimensions in the given order.

    Transposing the array is several times faster than transposing the variable.
    """
    return variable.values.transpose([variable.dims.index(dim) for dim in dims])


def share_read_only(value: _Value) -> _Value:
    """Return a copy of a cached dataset with read-only arrays, which several callers can share.

    Values of other types are returned unchanged.
    """
    import xarray

    if not isinstance(value, xarray.Dataset):
        return value
    dataset = value.copy()
    for variable in dataset.variables.values():
        if not isinstance(variable, xarray.IndexVariable):
            variable.data = make_read_only(variable.values.view())
    return dataset
