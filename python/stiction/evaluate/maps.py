"""Means of friction and contact quantities over an ensemble of surface pairs, interpolated at given normal loads.

An ensemble value at a load is a ratio of means over the repetitions, not a mean of ratios. Repetitions without contact
count as zeros. A load is reached where mean(F_N), interpolated linearly between the steps, first exceeds the load;
values are not extrapolated. Members for which the solver failed at a load are omitted.
"""

from __future__ import annotations

import itertools
import operator
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import Executor
from functools import partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats
from stiction._units import short_repr
from stiction.evaluate import intervals
from stiction.evaluate.contact_area import iterate_pieces_with_true_areas
from stiction.mechanics import friction
from stiction.mechanics.friction import STATUS_DTYPE, ContactSums, FrictionLaw, compute_ratios
from stiction.mechanics.quantities import QUANTITIES, SUM_QUANTITIES, VALIDITY_RATIO_OPERANDS, quantity_attributes
from stiction.solve.executors import executor_or_thread_pool
from stiction.solve.layout import arrange_axes
from stiction.solve.member_sums import MemberSums
from stiction.study.study import find_step_dimension

if TYPE_CHECKING:
    import xarray

DatasetTransformation: TypeAlias = "Callable[[xarray.Dataset], xarray.Dataset]"
MAX_VALUES_IN_MEMORY = 2**18
MAP_CELL_DIMENSION_NAMES = ("fractal_dimension", "amplitude", "cut_off")
# A result has the dimension `sliding` only for several sliding rules, and `direction` only for several directions.
MOTION_DIMENSION_NAMES = ("sliding", "direction")
_LOAD_VARIABLES = ("contact_count", *friction.LOAD_SUM_NAMES[:3])

_VARIABLES_BY_QUANTITY = {
    "friction_coefficient": ("contact_count", *friction.LOAD_SUM_NAMES),
    "normal_stiffness": _LOAD_VARIABLES,
}
"""Contact sums from which each derived quantity is computed. Quantities without an entry are stored directly."""

_SUM_NAMES_FOR_RATIOS = ("contact_area", "contact_load", *sorted(VALIDITY_RATIO_OPERANDS))
"""Contact sums from which ratios are computed, such as the mean pressure and the validity indicators."""


def _list_required_variables(quantity: str) -> tuple[str, ...]:
    """Return the names of the stored variables from which a quantity is computed."""
    return _VARIABLES_BY_QUANTITY.get(quantity, tuple(dict.fromkeys((*_LOAD_VARIABLES, quantity))))


def friction_map(
    result: MemberSums | xarray.Dataset,
    loads: ArrayLike,
    *,
    mu0: ArrayLike | None = None,
    tau0: ArrayLike | None = None,
) -> xarray.Dataset:
    """Compute the friction coefficient mean(F_T) / mean(F_N) of an ensemble at given normal loads.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
        Result of a study of generated surfaces. One piece of a stored result is in memory at a time.
    loads : (l,) array_like of float, mN
        Normal loads, above 0.
    mu0 : (m,) array_like of float, optional
        Molecular friction coefficients; by default the values in the study.
    tau0 : (t,) array_like of float, GPa, optional
        Adhesive shear strengths; by default the values in the study.

    Returns
    -------
    xarray.Dataset
        friction_coefficient, lower and upper (95 % interval from the repetitions; NaN for a single repetition), status,
        mean_pressure and, for the asperity model, the quantities of `Validity`. The dimensions are fractal_dimension,
        amplitude, load (mN), mu0 and tau0 (GPa), preceded by sliding and direction if the result has them. The status
        is "ok", "no-contact", "self-locked" (mean(F_N) is not above 0 at the largest approach), "not-reached" (no
        approach carries the load), "below-range" (the smallest approach carries more than the load) or "downhill" (the
        mean tangential load is negative). The coefficient is NaN unless the status is "ok".

    Raises
    ------
    ValueError
        If an argument is outside its range.

    See Also
    --------
    area_map, stiffness_map : True contact area and normal stiffness.
    friction_table : Friction against pressure, and fitted laws.

    Examples
    --------
    >>> from stiction import Study, friction_map, run
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> friction_map(run(Study.named("quick").with_changes(small)), [1e-3], mu0=0.4)["friction_coefficient"].dims
    ('fractal_dimension', 'amplitude', 'load', 'mu0', 'tau0')
    """
    return _evaluate_ensemble_quantity(result, loads, mu0, tau0, "friction_coefficient")


def area_map(
    result: MemberSums | xarray.Dataset,
    loads: ArrayLike,
    *,
    mu0: ArrayLike | None = None,
    tau0: ArrayLike | None = None,
) -> xarray.Dataset:
    """Compute the mean true contact area of the ensemble at given normal loads.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
        Result of a study of generated surfaces.
    loads : (l,) array_like of float, mN
        Normal loads, above 0.
    mu0 : (m,) array_like of float, optional
        Molecular friction coefficients; by default the values in the study.
    tau0 : (t,) array_like of float, GPa, optional
        Adhesive shear strengths; by default the values in the study.

    Returns
    -------
    areas : xarray.Dataset
        contact_area (µm²), with the interval, the status and the dimensions of `friction_map`.

    Raises
    ------
    ValueError
        As for `friction_map`.

    See Also
    --------
    friction_map : Friction coefficient, with the dimensions and the status.

    Examples
    --------
    >>> from stiction import Study, area_map, run
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> area_map(run(Study.named("quick").with_changes(small)), [1e-3])["contact_area"].dims
    ('fractal_dimension', 'amplitude', 'load', 'mu0', 'tau0')
    """
    return _evaluate_ensemble_quantity(result, loads, mu0, tau0, "contact_area")


def stiffness_map(
    result: MemberSums | xarray.Dataset,
    loads: ArrayLike,
    *,
    mu0: ArrayLike | None = None,
    tau0: ArrayLike | None = None,
) -> xarray.Dataset:
    """Compute the normal stiffness of the ensemble at given normal loads.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
        Result of a study of generated surfaces.
    loads : (l,) array_like of float, mN
        Normal loads, above 0.
    mu0 : (m,) array_like of float, optional
        Molecular friction coefficients; by default the values in the study.
    tau0 : (t,) array_like of float, GPa, optional
        Adhesive shear strengths; by default the values in the study.

    Returns
    -------
    stiffnesses : xarray.Dataset
        normal_stiffness (mN/µm), with the interval, the status and the dimensions of `friction_map`.

    Raises
    ------
    ValueError
        As for `friction_map`, and also if there are fewer than three approaches or loads, or for free half-planes,
        which have no approach.

    See Also
    --------
    friction_map : Friction coefficient, with the dimensions and the status.

    Notes
    -----
    The stiffness is d mean(F_N) / dδ. The derivative is computed from the parabola through an approach and its two
    neighbours, so the spacing of the approaches limits its resolution. The stiffness can be negative, because the load
    is not monotone in the approach. In half-space studies, whose steps are loads, the stiffness is the mean over the
    pairs at equal elastic load.

    Examples
    --------
    >>> from stiction import Study, run, stiffness_map
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> stiffness_map(run(Study.named("quick").with_changes(small)), [1e-3])["normal_stiffness"].dims
    ('fractal_dimension', 'amplitude', 'load', 'mu0', 'tau0')
    """
    result = MemberSums.of(result)
    head = result.head
    step_dimension = find_step_dimension(head)
    if head.sizes.get(step_dimension, 0) < 3:
        step_name = "approaches" if step_dimension == "approach" else "loads"
        raise ValueError(
            f"at least 3 {step_name} are required to compute a stiffness, got {head.sizes.get(step_dimension, 0)}"
        )
    if step_dimension == "load" and any(piece["approach"].isnull().any() for piece in result.pieces(["approach"])):
        raise ValueError(
            "a free half-plane has an infinite approach and therefore no stiffness; use periodic boundaries"
        )
    return _evaluate_ensemble_quantity(result, loads, mu0, tau0, "normal_stiffness")


def find_cell_dimensions(dataset: xarray.Dataset) -> list[str]:
    """Return the dataset dimensions that distinguish surfaces: fractal dimension and amplitude, or cutoff."""
    return [name for name in MAP_CELL_DIMENSION_NAMES if name in dataset.dims]


def move_repetitions_last(variable: xarray.Variable, dims: Sequence[str]) -> NDArray[Any]:
    """Return the values of a variable as a contiguous array, with the repetitions on the last axis.

    The array is contiguous, so that sums are fast.
    """
    return np.ascontiguousarray(arrange_axes(variable, (*dims, "repetition")))


def iterate_solved_pieces(
    result: MemberSums, names: Iterable[str] | None = None, transform: DatasetTransformation | None = None
) -> Iterator[xarray.Dataset]:
    """Yield datasets of groups of members, leaving out members for which the solver failed at any load."""
    for piece in iterate_pieces_with_true_areas(result, names):
        elastic_loads = piece.variables["normal_elastic"]
        is_solved = np.isfinite(
            move_repetitions_last(elastic_loads, [str(dim) for dim in elastic_loads.dims if dim != "repetition"])
        )
        is_solved = is_solved.reshape(-1, is_solved.shape[-1]).all(axis=0)
        solved_piece = piece if is_solved.all() else piece.isel(repetition=np.flatnonzero(is_solved))
        yield solved_piece if transform is None else transform(solved_piece)


def _evaluate_ensemble_quantity(
    result: MemberSums | xarray.Dataset, loads: ArrayLike, mu0: ArrayLike | None, tau0: ArrayLike | None, name: str
) -> xarray.Dataset:
    sums = MemberSums.of(result)
    dataset = evaluate_ensemble_quantities(sums, loads, mu0, tau0, [name])[name]
    warn_if_given_tau0_is_large(sums, tau0)
    return dataset


def evaluate_ensemble_quantities(
    result: MemberSums, loads: ArrayLike, mu0: ArrayLike | None, tau0: ArrayLike | None, names: Sequence[str],
    transform: DatasetTransformation | None = None, *, includes_ratios: bool = True,
) -> dict[str, xarray.Dataset]:  # fmt: skip
    """Evaluate ensemble means at given mean normal loads, and return one dataset per quantity.

    Each dataset has the structure of a dataset that `friction_map` returns. `transform` is applied to the members
    first. Without `includes_ratios`, the ratios of contact sums are omitted. Each piece of the result is read twice.
    """
    load_values = np.atleast_1d(friction.validate_friction_parameter("loads", loads))
    if load_values.ndim != 1:
        raise ValueError(f"loads must be a number or a list of numbers, got shape {load_values.shape}")
    if not load_values.size or not (load_values > 0).all():
        raise ValueError(f"loads must be a list of numbers above 0 mN, got {short_repr(loads)}")
    dataset = result.head
    strengths = choose_mu0_and_tau0(result, mu0, tau0)
    missing_dimensions = [name for name in ("repetition", find_step_dimension(dataset)) if not dataset.sizes.get(name)]
    missing_dimensions += [
        name for name in MAP_CELL_DIMENSION_NAMES if name in dataset.dims and not dataset.sizes[name]
    ]
    if missing_dimensions or not find_cell_dimensions(dataset):
        raise ValueError(f"the dataset has no dimension {(missing_dimensions or ['fractal_dimension'])[0]!r}")
    for name in itertools.chain.from_iterable(map(_list_required_variables, names)):
        if name not in dataset:
            raise ValueError(f"the dataset has no variable {name!r}")
    quantities = _EnsembleQuantities(
        dataset if transform is None else transform(dataset), names, load_values, *strengths, includes_ratios
    )
    # The first pass over the members finds the loading steps at which the second pass computes the intervals.
    averages, ratio_operands, count = _average_sums(
        iterate_solved_pieces(result, quantities.required_variables(), transform),
        names,
        quantities.other_sum_names,
        quantities.step_dimension,
    )
    if not count:
        raise ValueError("no member of the result has a solution at every load")
    cells = list(np.ndindex(quantities.cells))
    num_curve_values = quantities.mu0.size * quantities.tau0.size * dataset.sizes[quantities.step_dimension]
    batch_size = max(1, MAX_VALUES_IN_MEMORY // max(1, num_curve_values))
    with executor_or_thread_pool(None) as pool:

        def average_cell(cell_index: tuple[int, ...]) -> intervals.MeansAtLoads:
            normal_load, *values = (curve[..., 0] for curve in quantities.compute_curves(cell_index, averages))
            return intervals.MeansAtLoads(normal_load, values, count, load_values)

        means_by_cell = dict(zip(cells, pool.map(average_cell, cells), strict=True))
        for piece in iterate_solved_pieces(result, quantities.required_variables(), transform):
            piece_sums = _compute_sums(piece, names, quantities.step_dimension)

            def add_members_to_cell(cell_index: tuple[int, ...], sums: Sequence[ContactSums]) -> None:
                for batch_start in range(0, sums[0].contact_count.shape[-1], batch_size):
                    normal_load, *values = quantities.compute_curves(
                        cell_index, sums, slice(batch_start, batch_start + batch_size)
                    )
                    means_by_cell[cell_index].add_repetitions(normal_load, values)

            list(pool.map(add_members_to_cell, cells, itertools.repeat(piece_sums)))
            del piece, piece_sums
        return quantities.build_datasets(means_by_cell, averages, ratio_operands, pool)


class _EnsembleQuantities:
    """Ensemble means of quantities at given mean normal loads (mN), for each combination of mu0 and tau0 (GPa)."""

    def __init__(
        self, head: xarray.Dataset, names: Sequence[str], loads: Floats, mu0: Floats, tau0: Floats,
        includes_ratios: bool,
    ) -> None:  # fmt: skip
        self.head, self.names, self.loads, self.mu0, self.tau0 = head, names, loads, mu0, tau0
        self.step_dimension = find_step_dimension(head)
        self.dims = [*(motion for motion in MOTION_DIMENSION_NAMES if motion in head.dims), *find_cell_dimensions(head)]
        self.cells = tuple(head.sizes[dim] for dim in self.dims)
        self.shape = (*self.cells, loads.size, mu0.size, tau0.size)
        self.ratio_sum_names = [name for name in _SUM_NAMES_FOR_RATIOS if includes_ratios and name in head]
        self.other_sum_names = [name for name in self.ratio_sum_names if name not in SUM_QUANTITIES]

    def required_variables(self) -> tuple[str, ...]:
        """Return the names of the stored variables from which the quantities are computed."""
        variables = [name for quantity in self.names for name in _list_required_variables(quantity)]
        if "normal_stiffness" in self.names and self.step_dimension == "load":
            # The stiffness is the derivative of the load with respect to the approach.
            variables.append("approach")
        return tuple(dict.fromkeys([*variables, *self.ratio_sum_names]))

    def compute_curves(
        self, cell: tuple[int, ...], sums: Sequence[ContactSums], selected_members: slice = slice(None)
    ) -> list[Floats]:
        """Return the normal load (mN) and the other quantities at all loading steps, for the selected members.

        `cell` indexes sliding rule, direction and surfaces, and `sums` comes from `_compute_sums`. The first axis of
        each array runs over all pairs of mu0 and tau0.
        """
        contact_sums, *quantity_sums = (
            curve_sums.apply(operator.itemgetter((*cell, slice(None), selected_members))) for curve_sums in sums
        )
        law = FrictionLaw(self.mu0[:, np.newaxis, np.newaxis, np.newaxis], self.tau0[:, np.newaxis, np.newaxis])
        normal_load = law.load("normal", contact_sums)
        values = (
            np.broadcast_to(_compute_quantity_values(sums_of_quantity, name, law), normal_load.shape)
            for name, sums_of_quantity in zip(self.names, quantity_sums, strict=True)
        )
        return [array.reshape(-1, *normal_load.shape[2:]) for array in (normal_load, *values)]

    def build_datasets(
        self, means_by_cell: dict[tuple[int, ...], intervals.MeansAtLoads], averages: Sequence[ContactSums],
        ratio_operands: Mapping[str, Floats], pool: Executor,
    ) -> dict[str, xarray.Dataset]:  # fmt: skip
        """Return one dataset per quantity: means and intervals for each sliding rule, direction and kind of surface.

        `averages` and `ratio_operands` come from `_average_sums`. The threads of `pool` evaluate the cells.
        """
        import xarray

        estimates = np.full((len(self.names), 3, *self.shape), np.nan)
        status = np.full(self.shape, friction.STATUS_OK, dtype=STATUS_DTYPE)

        def evaluate_cell(cell: tuple[int, ...], means: intervals.MeansAtLoads) -> dict[str, NDArray[Any]]:
            """Store mean quantities for one kind of surface, one direction and one sliding rule; return ratios."""
            for index, statistics in enumerate(estimates):
                for array, curve_values in zip(statistics, (means.mean(index), *means.interval(index)), strict=True):
                    array[cell] = _reshape_curves(curve_values, self.shape)
            cell_averages = averages[0].apply(operator.itemgetter((*cell, slice(None), 0)))
            normal_load = self.compute_curves(cell, averages)[0][..., 0]
            # Friction locks the bodies together if the normal load is not positive even at the largest approach.
            is_locked = (cell_averages.contact_count[-1] > 0) & (normal_load[:, -1:] <= 0)
            cell_status = friction.choose_statuses(
                touched=bool(cell_averages.contact_count.any()), reached=means.crossing.reached,
                below=means.crossing.below, locked=is_locked,
            )  # fmt: skip
            status[cell] = _reshape_curves(cell_status, self.shape)
            if not self.ratio_sum_names:
                return {}
            curves = {name: getattr(cell_averages, name) for name in self.ratio_sum_names if name in SUM_QUANTITIES}
            curves |= {name: values[cell] for name, values in ratio_operands.items()}
            sums_at_loads = {
                name: means.crossing.interpolate(np.broadcast_to(curve, normal_load.shape))
                for name, curve in curves.items()
            }
            ratios = compute_ratios(sums_at_loads, self.loads)
            return {name: _reshape_curves(ratio, self.shape) for name, ratio in ratios.items()}

        ratios_by_cell = list(pool.map(evaluate_cell, means_by_cell.keys(), means_by_cell.values()))
        coordinates: dict[str, Any] = {name: self.head[name].variable for name in self.dims}
        dimensions = (("load", self.loads), ("mu0", self.mu0), ("tau0", self.tau0))
        coordinates |= {name: (name, axis, quantity_attributes(name)) for name, axis in dimensions}
        dims = tuple(coordinates)
        scalar_motions = [motion for motion in MOTION_DIMENSION_NAMES if motion in self.head.coords]
        coordinates |= {motion: self.head[motion].variable for motion in scalar_motions}
        common_variables: dict[str, Any] = {
            "status": (dims, status, quantity_attributes("status")),
            **{
                name: (dims, np.reshape([cell[name] for cell in ratios_by_cell], self.shape), quantity_attributes(name))
                for name in ratios_by_cell[0]
            },
        }
        datasets = {}
        for name, statistics in zip(self.names, estimates, strict=True):
            if name == "friction_coefficient" or QUANTITIES[name].weighted:
                statistics /= self.loads[:, np.newaxis, np.newaxis]
            if name == "friction_coefficient":
                is_downhill = statistics[0] < -friction.NEGLIGIBLE_COEFFICIENT
                statistics[:, is_downhill] = np.nan
                status[is_downhill] = friction.STATUS_DOWNHILL
            mean, lower, upper = statistics
            unit, title = QUANTITIES[name].unit, QUANTITIES[name].words
            variables = {
                name: (dims, mean, {"units": unit, "long_name": title}),
                "lower": (
                    dims,
                    lower,
                    {"units": unit, "long_name": f"lower limit of the 95 % interval of the {title}"},
                ),
                "upper": (
                    dims,
                    upper,
                    {"units": unit, "long_name": f"upper limit of the 95 % interval of the {title}"},
                ),
            }
            datasets[name] = xarray.Dataset(variables | common_variables, coordinates, dict(self.head.attrs))
        return datasets


def _reshape_curves(curve_table: NDArray[Any], shape: tuple[int, ...]) -> NDArray[Any]:
    """Convert an array (curves, loads), with one curve per pair of mu0 and tau0, to the shape (loads, mu0, tau0)."""
    return np.moveaxis(curve_table.reshape(*shape[-2:], shape[-3]), -1, 0)


def _compute_sums(dataset: xarray.Dataset, names: Sequence[str], step_dimension: str) -> list[ContactSums]:
    """Return forces and areas summed over the contacts of each member, and further sums that the quantities require.

    The first axes of each sum are sliding rule and direction. If a quantity is stored directly, it replaces the area in
    the returned sums.
    """
    get_values_or_nan = partial(_get_values_or_nan, dataset, step_dimension=step_dimension)
    columns = {name: get_values_or_nan(name) for name in SUM_QUANTITIES}
    sums = ContactSums.from_columns(columns)

    def compute_quantity_sums(name: str) -> ContactSums:
        if QUANTITIES[name].weighted:
            return ContactSums.from_columns(
                columns | {load: columns[load] * get_values_or_nan(name) for load in _LOAD_VARIABLES[1:]}
            )
        if name not in _VARIABLES_BY_QUANTITY:
            return ContactSums.from_columns(columns | {"contact_area": get_values_or_nan(name)})
        if name != "normal_stiffness":
            return sums
        approach_step = compute_derivative(get_values_or_nan("approach")) if step_dimension == "load" else 1.0
        return ContactSums.from_columns(
            columns | {load: compute_derivative(columns[load]) / approach_step for load in _LOAD_VARIABLES[1:]}
        )

    def compute_derivative(values: NDArray[Any]) -> Floats:
        return np.asarray(np.gradient(values, dataset[step_dimension].values, axis=-2, edge_order=2))

    return [sums, *map(compute_quantity_sums, names)]


def _get_values_or_nan(dataset: xarray.Dataset, name: str, step_dimension: str) -> NDArray[Any]:
    """Return a variable with repetitions on the last axis, or NaN if the dataset lacks this variable.

    All other axes are in a fixed order.
    """
    dims = [
        *(motion for motion in MOTION_DIMENSION_NAMES if motion in dataset.dims),
        *find_cell_dimensions(dataset),
        step_dimension,
        "repetition",
    ]
    shape = [dataset.sizes[dim] for dim in dims]
    if name not in dataset:
        return np.broadcast_to(np.nan, shape)
    variable = dataset.variables[name]
    own_dims = [dim for dim in dims if dim in variable.dims]
    values = move_repetitions_last(variable, own_dims[:-1]).astype(float, copy=False)
    return np.broadcast_to(values.reshape([dataset.sizes[dim] if dim in own_dims else 1 for dim in dims]), shape)


def _compute_quantity_values(sums: ContactSums, quantity: str, law: FrictionLaw) -> Floats:
    if not (quantity in _VARIABLES_BY_QUANTITY or QUANTITIES[quantity].weighted):
        return sums.contact_area
    return law.load("tangential" if quantity == "friction_coefficient" else "normal", sums)


def _average_sums(
    pieces: Iterable[xarray.Dataset], names: Sequence[str], operand_names: Sequence[str], step_dimension: str
) -> tuple[list[ContactSums], dict[str, Floats], int]:
    """Average the forces and areas summed over contacts, and the operands of ratios, over all members.

    Returns averages of the sums, averages of the operands of ratios, and the number of members. The averages of the
    sums have an axis of length 1 for the members.
    """
    total_sums: list[ContactSums] = []
    total_operands: dict[str, Floats] = dict.fromkeys(operand_names, np.zeros(()))
    count = 0
    for piece in pieces:
        count += piece.sizes["repetition"]
        piece_sums = [
            sums.apply(lambda values: values.sum(axis=-1, keepdims=True))
            for sums in _compute_sums(piece, names, step_dimension)
        ]
        total_sums = [
            ContactSums(**{name: getattr(first, name) + getattr(second, name) for name in SUM_QUANTITIES})
            for first, second in zip(total_sums, piece_sums, strict=True)
        ] if total_sums else piece_sums  # fmt: skip
        for name in operand_names:
            total_operands[name] = total_operands[name] + _get_values_or_nan(piece, name, step_dimension).sum(axis=-1)
        del piece
    averages = [total.apply(lambda values: values / max(count, 1)) for total in total_sums]
    return averages, {name: values / max(count, 1) for name, values in total_operands.items()}, count


def warn_if_given_tau0_is_large(result: MemberSums, tau0: ArrayLike | None) -> None:
    """Warn if a tau0 (GPa) given by the user is so large that its unit is probably wrong.

    By default, the tau0 of the study are checked. A tau0 fitted to friction tests causes no warning.
    """
    if tau0 is not None and "study" not in result.head.attrs:
        return
    study = result.study
    study_values = [float(value) for value in study.friction.tau0]
    entered_values = friction.validate_friction_parameter("tau0", study_values if tau0 is None else tau0)
    if study.friction.interface is not None:
        entered_values = np.setdiff1d(entered_values, study_values)
    friction.warn_if_tau0_is_large(entered_values, float(study.contact.effective_modulus))


def choose_mu0_and_tau0(result: MemberSums, mu0: ArrayLike | None, tau0: ArrayLike | None) -> tuple[Floats, Floats]:
    """Return mu0 and tau0 (GPa) as arrays: the given numbers or, by default, the numbers of the study."""
    if mu0 is None or tau0 is None or "study" in result.head.attrs:
        study = result.study
        mu0 = study.friction.mu0 if mu0 is None else mu0
        tau0 = [float(value) for value in study.friction.tau0] if tau0 is None else tau0
    arrays_by_name = {
        name: np.atleast_1d(friction.validate_friction_parameter(name, strengths)).ravel()
        for name, strengths in (("mu0", mu0), ("tau0", tau0))
    }
    for name, array in arrays_by_name.items():
        if not array.size:
            raise ValueError(f"{name} must have at least one value, got none")
    return arrays_by_name["mu0"], arrays_by_name["tau0"]
