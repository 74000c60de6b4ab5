"""Results at nodes of mu0 and tau0, between which a report interpolates with cubic polynomials.

The nodes are chosen so that interpolation errors are within the tolerances below. The remaining error is measured
between nodes.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.evaluate.combined_intervals import SAME_INPUT_TOLERANCE
from stiction.evaluate.load_range import choose_loads_in_range
from stiction.solve.alternative_preparations import load_stored_alternatives
from stiction.study.inputs import Inputs

if TYPE_CHECKING:
    import xarray

    from stiction.evaluate.member_values import MemberKind
    from stiction.solve.member_sums import MemberSums
    from stiction.study.study import Study

VALUE_TOLERANCE = 1e-4  # largest relative error of an interpolated value; the report prints up to four digits
INTERVAL_TOLERANCE = 1e-2  # largest error of an interpolated interval limit, relative to the interval width
MAX_SHOWN_ERROR_RATIO = 0.025
"""Largest ratio of interpolation error to interval width for which a report shows the number.

The ratio equals the rounding error of printed limits.
"""

MIN_NODES = 5  # number of interpolation nodes on an axis before refinement
MAX_NODES, MAX_NODES_OF_MEASURED_SURFACES = 7, 10
"""Largest numbers of interpolation nodes on an axis, for generated surfaces and for measured surfaces.

Reports of generated surfaces have more loads and therefore fewer nodes.
"""

NUM_REPORT_LOADS = 40  # number of loads in a report of generated surfaces
# number of loads at which nodes are chosen and errors are measured (generated surfaces)
NUM_SAMPLED_LOADS = 4
NUM_NODE_CHOICE_LOADS = 2  # number of loads at which nodes are chosen (measured surfaces)
# quantities that are evaluated at the nodes in addition to friction (measured surfaces)
ADDITIONAL_NODE_VARIABLES = ("contact_count", "gentle_friction")
# maximum number of mu0 or tau0 values in a study that become nodes; longer lists are thinned
MAX_STUDY_NODES = 9
MAX_AXIS_REFINEMENTS = 4  # maximum number of refinements of an axis
MIN_NODE_DISTANCE = 0.35
"""Smallest distance between an initial node and a value in the study, relative to the node spacing."""

ERROR_CHECK_POSITIONS = (np.array([0.07, 0.23, 0.61]), np.array([0.04, 0.31]))
"""Positions at which errors are measured, as fractions of the ranges of mu0 (first) and tau0 (second)."""

# A value is treated as a node if its distance from the node is below this fraction of the axis length.
NODE_TOLERANCE = 1e-9
MAX_TAU0_OVER_MODULUS = 0.02  # upper end of the tau0 axis as a fraction of E*, if no tau0 in the study is larger
MAX_TAU0_OVER_HARDNESS = 0.7 * 27**-0.5
"""Largest tau0 on the axis relative to the hardness, if the study has no larger value (0.7 of von Mises' strength)."""


@dataclass(frozen=True, eq=False)
class NodeAxis:
    """Nodes along one axis, which is either mu0 or tau0 (GPa).

    Values are interpolated between `rising` nodes. `ranged` nodes are values in the study that have an uncertainty
    range. At all other values, mu0 or tau0 is assumed to be exact.
    """

    rising: Floats
    ranged: Floats = field(default_factory=lambda: np.zeros(0))

    @property
    def values(self) -> Floats:
        """All nodes, i.e. the `rising` nodes followed by the `ranged` nodes."""
        return np.concatenate([self.rising, self.ranged])

    @property
    def ranged_node_intervals(self) -> list[tuple[float, float]]:
        """Interval around each ranged node. All values in the interval are treated as equal to the node."""
        return [
            (float(node / (1 + SAME_INPUT_TOLERANCE)), float(node / (1 - SAME_INPUT_TOLERANCE))) for node in self.ranged
        ]

    def with_added_nodes(self, additional: Sequence[float]) -> NodeAxis:
        """Return a copy of the axis with additional rising nodes."""
        return NodeAxis(np.unique([*self.rising, *additional]), self.ranged)

    def panel_split_points(self) -> Floats:
        """Return the midpoint of each panel between rising nodes, shifted if it would be too close to a ranged node."""
        midpoints = (self.rising[1:] + self.rising[:-1]) / 2
        return np.where(self._is_at_ranged_node(midpoints), 0.5 * (midpoints + self.rising[1:]), midpoints)

    @property
    def panel_midpoints(self) -> Floats:
        """Midpoint of the panel that starts at each node, or the node itself if no panel starts there."""
        return np.concatenate([self.panel_split_points(), self.rising[-1:], self.ranged])

    @property
    def panel_end_indices(self) -> NDArray[np.intp]:
        """Index of the node at which the panel of each node ends, or the node's own index if it has no panel."""
        indices = np.arange(self.values.size)
        return np.where(indices < self.rising.size - 1, indices + 1, indices)

    def _is_at_ranged_node(self, values: Floats) -> Any:
        return np.logical_or.reduce(
            [
                np.zeros(values.shape, bool),
                *((low <= values) & (values <= high) for low, high in self.ranged_node_intervals),
            ]
        )

    def weights(self, value: float, *, cubic: bool = True) -> Floats:
        """Return the weight of each node for the interpolation at a given value of mu0 or tau0."""
        weights = np.zeros(self.values.size)
        for index, (low, high) in enumerate(self.ranged_node_intervals):
            if low <= value <= high:
                weights[self.rising.size + index] = 1.0
                return weights
        distances = np.abs(self.rising - value)
        if distances.min() <= NODE_TOLERANCE * self.rising[-1]:
            weights[distances.argmin()] = 1.0
            return weights
        last_index = self.rising.size - 1
        panel_start = int(np.clip(np.searchsorted(self.rising, value, side="right") - 1, 0, last_index - 1))
        first_node, num_nodes = (
            (min(max(panel_start - 1, 0), last_index - 3), 4) if cubic and last_index >= 3 else (panel_start, 2)
        )
        return self._lagrange_weights(value, np.arange(first_node, first_node + num_nodes))

    def weight_changes_with_extra_node(self, value: float, *, cubic: bool = True) -> list[Floats]:
        """Return the changes in the weights if the interpolation also uses the preceding or the following node.

        A change is 0 at a node, and NaN if there is no such node.
        """
        weights = self.weights(value, cubic=cubic)
        (used_indices,) = np.nonzero(weights)
        if used_indices.size == 1:
            return [np.zeros(weights.size)] * 2
        return [
            self._lagrange_weights(value, np.append(used_indices, node)) - weights
            if 0 <= node < self.rising.size
            else np.full(weights.size, np.nan)
            for node in (used_indices[0] - 1, used_indices[-1] + 1)
        ]

    def _lagrange_weights(self, value: float, indices: NDArray[np.intp]) -> Floats:
        """Return the node weights of the polynomial that interpolates between the rising nodes at `indices`."""
        weights = np.zeros(self.values.size)
        nodes = self.rising[indices]
        for index, node in zip(indices, nodes, strict=True):
            others = nodes[nodes != node]
            weights[index] = np.prod((value - others) / (node - others))
        return weights


class InterpolationNodes:
    """Values of a result at nodes of mu0 and tau0, between which a report interpolates.

    Parameters
    ----------
    result : Result

    Attributes
    ----------
    axes : pair of NodeAxis
        Nodes of mu0 and tau0, chosen for the tolerances.
    loads : ndarray of float, mN
        Loads in a report: the loads of the study for measured bodies, and `NUM_REPORT_LOADS` loads in equal ratios for
        generated bodies.
    kinds : list of str or None
        Kinds of members of measured bodies, starting with the quoted kind. None stands for all members.
    values : tuple of xarray.Dataset
        Values and intervals of each kind at the loads and nodes.
    load_quantities : tuple of xarray.Dataset
        Quantities of measured bodies that depend only on the load, for each kind.
    error : (float, float)
        Largest relative error of interpolated values, and largest error of interval limits relative to the width, at a
        few points between nodes.
    """

    def __init__(self, result: MemberSums) -> None:
        self.result, self.study = result, result.study

    @cached_property
    def loads(self) -> Floats:
        """Loads (mN) that a report shows. The array is empty if no pair of bodies is in contact."""
        if self.study.is_measured:
            return np.asarray(self.study.contact.loading_steps())
        try:
            low, high = (float(f"{load:.3g}") for load in choose_loads_in_range(self.result, 2))
        except ValueError:
            return np.zeros(0)
        return np.array([float(f"{load:.5g}") for load in np.geomspace(low, high, NUM_REPORT_LOADS)])

    @cached_property
    def member_kinds(self) -> list[MemberKind | None]:
        """Kinds of members ("shifts", "surrogates"). The reported friction is that of the first kind."""
        head = self.result.head
        if "surrogate" not in head.coords:
            return [None]
        surrogate = self.result.dataset["surrogate"].values.astype(bool)
        return ["shifts", "surrogates"] if surrogate.any() and not surrogate.all() else [None]

    @property
    def motions(self) -> list[list[int]]:
        """Indices of the directions over which each reported motion averages.

        Measured surfaces start with the mean over all directions.
        """
        directions = list(range(len(self.study.contact.direction_angles())))
        single_directions = [[index] for index in directions]
        return [directions, *single_directions] if self.study.is_measured and len(directions) > 1 else single_directions

    @property
    def num_coefficients(self) -> int:
        """Number of coefficients at all nodes, for all kinds, cells, sliding rules, motions and loads."""
        cell_sizes = [values.size for values in self.study.surfaces.cell_coordinates().values()]
        num_curves = math.prod(cell_sizes) * len(self.study.contact.sliding_rules()) * len(self.motions)
        return len(self.member_kinds) * num_curves * self.loads.size * math.prod(axis.values.size for axis in self.axes)

    @cached_property
    def axes(self) -> tuple[NodeAxis, NodeAxis]:
        """Nodes of mu0 and tau0, chosen so that interpolation errors at a few loads are small."""
        if self.study.is_measured:
            loads = np.unique([*self.loads[[-1]], float(self.study.friction.load[0])])[:NUM_NODE_CHOICE_LOADS]
        else:
            loads = self._sampled_loads
        max_nodes = MAX_NODES_OF_MEASURED_SURFACES if self.study.is_measured else MAX_NODES
        return refine_axes(build_initial_axes(self.study), partial(self._evaluate_friction, loads), max_nodes)

    @cached_property
    def values(self) -> tuple[xarray.Dataset, ...]:
        """Values and intervals for each kind of member, at all loads and nodes."""
        names = ADDITIONAL_NODE_VARIABLES if self.study.is_measured else None
        return tuple(self._evaluate_at_nodes(self.loads, self.axes, kind, names) for kind in self.member_kinds)

    @cached_property
    def load_quantities(self) -> tuple[xarray.Dataset, ...]:
        """Quantities of measured bodies that depend only on the load, for each kind of member."""
        quantities = [
            at_load(self.result, self.loads, mu0=[0.0], tau0=[0.0], member_kind=kind) for kind in self.member_kinds
        ]
        if load_stored_alternatives(
            self.result
        ):  # the intervals of the true area cover those of alternative preparations
            quantities[0] = add_uncertainty(quantities[0], self.result, budget=False, tests=False)
        return tuple(quantities)

    @cached_property
    def interpolation_errors(self) -> tuple[float, float]:
        """Largest interpolation errors of values and interval limits, evaluated at a few points between nodes."""
        loads = self.loads if self.study.is_measured else self._sampled_loads
        table = self._extract_coefficient_table(self.values[0].sel(load=loads))
        return find_largest_errors(self.axes, table, partial(self._evaluate_friction, loads))

    def find_interpolated_panels(self, points: Floats) -> NDArray[np.bool_]:
        """Return a mask that is True for each panel in which values may be interpolated."""
        return find_interpolated_panels(self.axes, points)

    @property
    def _sampled_loads(self) -> Floats:
        return self.loads[:: max(1, self.loads.size // NUM_SAMPLED_LOADS)]

    def _evaluate_at_nodes(
        self, loads: Floats, axes: tuple[NodeAxis, NodeAxis], kind: MemberKind | None, names: Collection[str] | None
    ) -> xarray.Dataset:
        """Evaluate the result at the nodes. For measured bodies, the intervals are combined intervals.

        Only the quoted kind of member has combined intervals. Surrogates in addition to maps do not.
        """
        mu0, tau0 = (axis.values for axis in axes)
        with warnings.catch_warnings():
            # the report itself marks values of tau0 that are large relative to E*
            warnings.simplefilter("ignore", UserWarning)
            at = at_load(self.result, loads, mu0=mu0, tau0=tau0, member_kind=kind, names=names)
        return at if kind == "surrogates" else add_uncertainty(at, self.result, budget=False, tests=False)

    def _evaluate_friction(self, loads: Floats, mu0: Floats, tau0: Floats) -> Floats:
        """Return friction coefficients with their intervals for all combinations of mu0 and tau0."""
        names = ("contact_count",) if self.study.is_measured else ()
        return self._extract_coefficient_table(
            self._evaluate_at_nodes(loads, (NodeAxis(mu0), NodeAxis(tau0)), self.member_kinds[0], names)
        )

    def _extract_coefficient_table(self, at: xarray.Dataset) -> Floats:
        """Return the reported coefficients and their interval limits as an array."""
        name = "friction_combined" if self.study.is_measured else "friction_coefficient"
        return np.asarray(at[name].transpose(..., "load", "mu0", "tau0", "statistic").values)


def build_initial_axes(study: Study) -> tuple[NodeAxis, NodeAxis]:
    """Return the initial nodes of mu0 and tau0 (GPa), from 0 to the largest value that a report shows."""
    ranged_names = set(Inputs.from_study(study).uncertain) | ({"mu0", "tau0"} if study.friction.interface else set())
    modulus, hardness = float(study.contact.effective_modulus), study.contact.hardness
    max_tau0 = MAX_TAU0_OVER_MODULUS * modulus
    max_tau0 = max_tau0 if hardness is None else min(max_tau0, MAX_TAU0_OVER_HARDNESS * float(hardness))
    study_values = {
        "mu0": np.array(study.friction.mu0),
        "tau0": np.array([float(each) for each in study.friction.tau0]),
    }
    largest_values = {"mu0": max(1.0, study_values["mu0"][-1]), "tau0": max(max_tau0, study_values["tau0"][-1])}
    if not study.is_measured and study_values["tau0"].size > 1:
        largest_values["tau0"] = study_values["tau0"][-1]
    return tuple(
        _build_axis(study_values[name], largest_values[name], is_ranged=name in ranged_names)
        for name in ("mu0", "tau0")
    )  # type: ignore[return-value]


def _build_axis(study_values: Floats, largest: float, *, is_ranged: bool) -> NodeAxis:
    if study_values.size > MAX_STUDY_NODES:
        study_values = study_values[
            np.unique(np.linspace(0, study_values.size - 1, MAX_STUDY_NODES).round().astype(int))
        ]
    # The nodes are closer together near 0, where interval limits have the largest curvature.
    default_nodes = largest * np.linspace(0.0, 1.0, MIN_NODES) ** 2
    if is_ranged:
        axis = NodeAxis(default_nodes, study_values[study_values > 0])
        return NodeAxis(
            np.where(
                axis._is_at_ranged_node(default_nodes), default_nodes * (1 + 5 * SAME_INPUT_TOLERANCE), default_nodes
            ),
            axis.ranged,
        )
    node_distances = np.diff(default_nodes)
    min_distance = MIN_NODE_DISTANCE * np.minimum(
        np.append(node_distances[0], node_distances), np.append(node_distances, node_distances[-1])
    )
    is_kept = np.abs(default_nodes[:, np.newaxis] - study_values).min(axis=1) > min_distance
    is_kept[[0, -1]] = True
    return NodeAxis(np.unique([*default_nodes[is_kept], *study_values]))


def refine_axes(
    axes: tuple[NodeAxis, NodeAxis], evaluate: Callable[[Floats, Floats], Floats], max_nodes: int = MAX_NODES
) -> tuple[NodeAxis, NodeAxis]:
    """Add nodes to each axis until interpolation errors are within tolerance along two lines parallel to the axis.

    An axis has at most `max_nodes` rising nodes after refinement. Nodes are added first where the measured error, or
    the estimated error of `find_interpolated_panels`, is largest relative to its tolerance.

    Parameters
    ----------
    axes : pair of NodeAxis
    evaluate : function of mu0 (m,) and tau0 (t,)
        Values, lower and upper ends (..., m, t, 3).
    """
    refined_axes = list(axes)
    for index in range(2):
        other_nodes = refined_axes[1 - index].rising
        cross_nodes = other_nodes[[min(1, other_nodes.size - 1), max(other_nodes.size - 2, 0)]]
        values_by_node: dict[float, Floats] = {}  # cached values with their interval limits, by position on the axis
        for _ in range(MAX_AXIS_REFINEMENTS):
            axis = refined_axes[index]
            midpoints = axis.panel_split_points()
            axis_values = np.concatenate([axis.values, midpoints])
            if (new_values := np.array([value for value in axis_values.tolist() if value not in values_by_node])).size:
                table = (
                    evaluate(new_values, cross_nodes)
                    if index == 0
                    else np.swapaxes(evaluate(cross_nodes, new_values), -2, -3)
                )
                values_by_node |= zip(new_values.tolist(), np.moveaxis(table, -3, 0), strict=True)
            nodes, exact_values = (
                np.stack([values_by_node[value] for value in values.tolist()]) for values in (axis.values, midpoints)
            )
            with np.errstate(invalid="ignore"):
                interpolated = np.stack([np.tensordot(axis.weights(midpoint), nodes, axes=1) for midpoint in midpoints])
                value_changes = [
                    np.tensordot(
                        np.stack([axis.weight_changes_with_extra_node(midpoint)[neighbor] for midpoint in midpoints]),
                        nodes,
                        axes=1,
                    )
                    for neighbor in range(2)
                ]
            estimated_excess = (
                compute_error_to_tolerance_ratio(exact_values + _estimate_errors(*value_changes), exact_values)
                * INTERVAL_TOLERANCE
                / MAX_SHOWN_ERROR_RATIO
            )
            errors = (
                np.maximum(compute_error_to_tolerance_ratio(interpolated, exact_values), estimated_excess)
                .reshape(midpoints.size, -1)
                .max(axis=1)
            )
            candidate_order = np.argsort(-errors)[: max(max_nodes - axis.rising.size, 0)]
            new_nodes = midpoints[candidate_order[errors[candidate_order] > max(1.0, errors.max() / 4)]]
            if not new_nodes.size:
                break
            refined_axes[index] = axis.with_added_nodes(new_nodes.tolist())
    return refined_axes[0], refined_axes[1]


def compute_error_to_tolerance_ratio(estimated: Floats, exact: Floats) -> Floats:
    """Return the error-to-tolerance ratio of the value or of the interval limits, whichever ratio is larger."""
    value, width = np.abs(exact[..., 0]), exact[..., 2] - exact[..., 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        error = np.abs(estimated - exact)
        limit_excess = error[..., 1:].max(axis=-1) / np.maximum(INTERVAL_TOLERANCE * width, VALUE_TOLERANCE * value)
        value_excess = error[..., 0] / (VALUE_TOLERANCE * value)
    return np.maximum(
        np.where(np.isfinite(limit_excess), limit_excess, 0.0), np.where(np.isfinite(value_excess), value_excess, 0.0)
    )


def find_largest_errors(
    axes: tuple[NodeAxis, NodeAxis], table: Floats, evaluate: Callable[[Floats, Floats], Floats]
) -> tuple[float, float]:
    """Return the largest interpolation errors of values and interval limits at a few points between the nodes.

    `axes` and `evaluate` are arguments of `refine_axes`, and `table` (..., m, t, 3) contains the values at the nodes.
    Errors of values are relative to the value, and errors of limits are relative to the interval width. Panels that are
    not interpolated, and intervals narrower than the tolerance of the value, are omitted.
    """
    mu0, tau0 = (
        axis.rising[0] + np.ptp(axis.rising) * fractions
        for axis, fractions in zip(axes, ERROR_CHECK_POSITIONS, strict=True)
    )
    can_interpolate = find_interpolated_panels(axes, table)
    exact = evaluate(mu0, tau0)
    value_errors, limit_errors = [0.0], [0.0]
    for row, column in np.ndindex(mu0.size, tau0.size):
        position = mu0[row], tau0[column]
        panel_indices = [
            int(np.searchsorted(axis.rising, each, side="right") - 1) for axis, each in zip(axes, position, strict=True)
        ]
        interpolated = interpolate_table(axes, np.moveaxis(table, -1, 0), *position)
        exact_point = np.moveaxis(exact[..., row, column, :], -1, 0)
        width = exact_point[2] - exact_point[1]
        with np.errstate(divide="ignore", invalid="ignore"):
            value_error = np.abs(interpolated[0] / exact_point[0] - 1)
            limit_error = np.abs(interpolated[1:] - exact_point[1:]).max(axis=0) / np.maximum(
                width, VALUE_TOLERANCE / INTERVAL_TOLERANCE * np.abs(exact_point[0])
            )
        for errors, error in ((value_errors, value_error), (limit_errors, limit_error)):
            error = error[can_interpolate[..., panel_indices[0], panel_indices[1]] & np.isfinite(error)]
            errors.append(float(error.max(initial=0.0)))
    return max(value_errors), max(limit_errors)


def interpolate_table(axes: tuple[NodeAxis, NodeAxis], table: Floats, mu0: float, tau0: float) -> Floats:
    """Interpolate a table at given mu0 and tau0 (GPa). The last two axes of the table are the nodes of mu0 and tau0.

    The interpolation is cubic, or bilinear if one of the 16 nodes has no value.
    """
    cubic, linear = (
        _compute_weighted_sums(table, axes[0].weights(mu0, cubic=each), axes[1].weights(tau0, cubic=each))
        for each in (True, False)
    )
    return np.where(np.isfinite(cubic), cubic, linear)


def find_interpolated_panels(axes: tuple[NodeAxis, NodeAxis], points: Floats) -> NDArray[np.bool_]:
    """Return a mask that is True for each panel (rectangle between nodes) in which values may be interpolated.

    A panel has the indices of its first corner. Along a ranged node, only the other axis is interpolated. The error in
    the middle of a panel is estimated as the change due to one more node along mu0, plus the change due to one more
    node along tau0. Each is the geometric mean of the changes due to the preceding and the following node. The error of
    a value and of the ends of its interval must be within `MAX_SHOWN_ERROR_RATIO` of the width, or `VALUE_TOLERANCE` of
    the value, at every corner. A number that is defined at only some corners is not interpolated.
    """
    table = np.moveaxis(points, -1, 0)
    (cubic, cubic_error), (linear, linear_error) = (
        _interpolate_at_midpoints(axes, table, cubic=each) for each in (True, False)
    )
    cubic_error = np.where(np.isnan(cubic_error), np.abs(cubic - linear), cubic_error)
    error = np.where(np.isnan(cubic), linear_error, cubic_error)
    value, lower, upper = corners = np.stack(
        [
            table[..., rows[:, np.newaxis], columns]
            for rows in (np.arange(axes[0].values.size), axes[0].panel_end_indices)
            for columns in (np.arange(axes[1].values.size), axes[1].panel_end_indices)
        ],
        axis=1,
    )  # shape (3, 4, ..., m, t)
    width = np.where(np.isinf(upper), 2 * (value - lower), upper - lower)
    tolerance = np.fmax(MAX_SHOWN_ERROR_RATIO * width, VALUE_TOLERANCE * np.abs(value)).min(axis=0)
    return np.asarray((~np.isfinite(corners).any(axis=1) | (error <= tolerance)).all(axis=0))


def _interpolate_at_midpoints(axes: tuple[NodeAxis, NodeAxis], table: Floats, *, cubic: bool) -> tuple[Floats, Floats]:
    """Return interpolated values at the midpoints of the panels, and the estimated errors. Undefined values are NaN."""
    mu0_weights, tau0_weights = (
        np.stack([axis.weights(value, cubic=cubic) for value in axis.panel_midpoints]) for axis in axes
    )
    mu0_corrections, tau0_corrections = (
        np.stack([axis.weight_changes_with_extra_node(value, cubic=cubic) for value in axis.panel_midpoints], axis=1)
        for axis in axes
    )
    mu0_error = _estimate_errors(*(_compute_weighted_sums(table, change, tau0_weights) for change in mu0_corrections))
    tau0_error = _estimate_errors(*(_compute_weighted_sums(table, mu0_weights, change) for change in tau0_corrections))
    return _compute_weighted_sums(table, mu0_weights, tau0_weights), mu0_error + tau0_error


def _estimate_errors(by_node_before: Floats, by_node_after: Floats) -> Floats:
    """Estimate interpolation errors from the changes that adding a node before or after would cause.

    The error is the geometric mean of the two changes, or one change if the other is NaN.
    """
    change_before, change_after = np.abs(by_node_before), np.abs(by_node_after)
    return np.where(
        np.isnan(change_before),
        change_after,
        np.where(np.isnan(change_after), change_before, np.sqrt(change_before * change_after)),
    )


def _compute_weighted_sums(table: NDArray[Any], over_mu0: Floats, over_tau0: Floats) -> Floats:
    """Compute weighted sums of the values at the nodes.

    Weights of mu0 with shape (k, m) and weights of tau0 with shape (l, t) give sums with shape (..., k, l). Weights of
    a single point, with shapes (m,) and (t,), give sums with shape (...).

    A sum is NaN if a node with a weight is not finite.
    """
    is_finite = np.isfinite(table)
    sums = over_mu0 @ np.where(is_finite, table, 0.0) @ over_tau0.T
    num_missing = (over_mu0 != 0).astype(float) @ ~is_finite @ (over_tau0 != 0).astype(float).T
    return np.where(num_missing > 0, np.nan, sums)
