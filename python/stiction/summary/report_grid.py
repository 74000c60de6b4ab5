"""Grid of loads, mu0 and tau0 for the sliders of a report, and evaluation of a result on this grid."""

from __future__ import annotations

import math
import warnings
from collections.abc import Collection
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.evaluate.load_range import choose_loads_in_range
from stiction.evaluate.point import sort_sliding_rules
from stiction.mechanics.friction import CENTRAL_SHEAR_RATIO
from stiction.study.inputs import SAME_VALUE_TOLERANCE, Inputs
from stiction.summary.assessment import MIN_STRENGTH_RATIO_NEAR_BULK
from stiction.summary.evaluation import Evaluation

if TYPE_CHECKING:
    import xarray

    from stiction.evaluate.member_values import MemberKind
    from stiction.study.study import Study

MEASURED_MU0_VALUES = (0.0, 0.1, 0.2, 0.3, 0.4, 0.6, 0.8)
GENERATED_MU0_VALUES = (0.0, 0.2, 0.4, 0.6, 0.8, 1.0)
"""Values of mu0 that a report on generated surfaces shows in addition to the mu0 of the study.

Reports on generated surfaces have more loads, and therefore fewer mu0 and tau0.
"""

# Maximum number of tau0 steps of the slider in a report, for measured (True) and for generated surfaces (False).
MAX_TAU0_STEPS = {True: 6, False: 5}
MAX_SHOWN_MU0_OR_TAU0 = 9
MAX_TAU0_OVER_MODULUS = 0.02
MAX_TAU0_OVER_HARDNESS = MIN_STRENGTH_RATIO_NEAR_BULK / CENTRAL_SHEAR_RATIO
"""Largest tau0 in a report, as a fraction of the hardness, unless the study has a larger tau0."""

NUM_REPORT_LOADS = 40
QUANTITIES_BESIDES_FRICTION = ("contact_count", "gentle_friction")


@dataclass(frozen=True, eq=False)
class ParameterAxis:
    """Values of mu0, or of tau0 (GPa), that a slider of a report offers, in ascending order.

    `has_range` is true for numbers that the study gives with a range. All other numbers are exact.
    """

    values: Floats
    has_range: NDArray[np.bool_]

    def find_index(self, value: float) -> int:
        """Return the index of the value on the axis that is closest to a given value."""
        return int(np.abs(self.values - value).argmin())


class ReportGrid:
    """Values among which the reader of a report can choose: loads, mu0, tau0, directions and kinds of surface pairs.

    Attributes
    ----------
    axes : pair of ParameterAxis
        Values of mu0 and tau0.
    loads : ndarray of float, mN
        The computed loads of measured bodies, or `NUM_REPORT_LOADS` loads in equal ratios for generated bodies.
    member_kinds : list of str or None
        Kinds of members ("shifts", "surrogates") of measured bodies, starting with the quoted kind. None stands for all
        members.
    motions : list of list of int
        Indices of the directions over which each reported motion averages. Measured surfaces start with the mean over
        all directions.
    """

    def __init__(self, result: Evaluation) -> None:
        self.result, self.study = result, result.study
        self.axes = build_parameter_axes(self.study)

    @cached_property
    def loads(self) -> Floats:
        """Loads (mN) that a report offers; empty if the bodies never touch."""
        if self.study.is_measured:
            return np.asarray(self.study.contact.loading_steps())
        try:
            smallest_load, largest_load = (float(f"{load:.3g}") for load in choose_loads_in_range(self.result, 2))
        except ValueError:
            return np.zeros(0)
        return np.array([float(f"{load:.5g}") for load in np.geomspace(smallest_load, largest_load, NUM_REPORT_LOADS)])

    @cached_property
    def member_kinds(self) -> list[MemberKind | None]:
        """Kinds of surface pairs in a report: ["shifts", "surrogates"], or [None] if all pairs are of the same kind."""
        if "surrogate" not in self.result.head.coords:
            return [None]
        surrogate = self.result.dataset["surrogate"].values.astype(bool)
        return ["shifts", "surrogates"] if surrogate.any() and not surrogate.all() else [None]

    @property
    def motions(self) -> list[list[int]]:
        """Groups of directions over which a report averages friction, as lists of indices: all directions, or only one.

        Reports on generated surfaces contain no mean over all directions.
        """
        directions = list(range(len(self.study.contact.direction_angles())))
        single_directions = [[index] for index in directions]
        return [directions, *single_directions] if self.study.is_measured and len(directions) > 1 else single_directions

    @property
    def num_coefficients(self) -> int:
        """Number of friction coefficients in a report, for all combinations of load, mu0, tau0 and other choices."""
        cell_sizes = [values.size for values in self.study.surfaces.cell_coordinates().values()]
        num_curves = math.prod(cell_sizes) * len(self.study.contact.sliding_rules()) * len(self.motions)
        return len(self.member_kinds) * num_curves * self.loads.size * math.prod(axis.values.size for axis in self.axes)

    def evaluate(self) -> tuple[xarray.Dataset, ...]:
        """Evaluate friction with intervals for each load, mu0 and tau0 of the grid, and for each kind of surface pair.

        Members of measured bodies have combined intervals, except surrogates that were computed in addition to shifted
        maps.
        """
        names: Collection[str] | None = QUANTITIES_BESIDES_FRICTION if self.study.is_measured else None
        mu0, tau0 = (axis.values for axis in self.axes)
        tables = []
        for kind in self.member_kinds:
            with warnings.catch_warnings():
                # Warnings about a large tau0 are suppressed, because the report itself marks each large tau0.
                warnings.simplefilter("ignore", UserWarning)
                at = at_load(self.result, self.loads, mu0=mu0, tau0=tau0, member_kind=kind, names=names)
            has_combined = kind != "surrogates"
            table = add_uncertainty(at, self.result, budget=False, tests=False) if has_combined else at
            tables.append(sort_sliding_rules(table, self.study))
        return tuple(tables)

    def evaluate_study_inputs(self) -> tuple[xarray.Dataset, ...]:
        """Evaluate contact quantities of measured bodies at each load of a report, for the study's first mu0 and tau0.

        There is one dataset for each kind of surface pair.
        """
        other_kinds = [at_load(self.result, self.loads, member_kind=kind) for kind in self.member_kinds[1:]]
        tables = [self.result.at_report_loads, *other_kinds]
        return tuple(table.isel(mu0=0, tau0=0).sel(load=self.loads) for table in tables)


def build_parameter_axes(study: Study) -> tuple[ParameterAxis, ParameterAxis]:
    """Return the mu0 and tau0 (GPa) that a report offers: the values of the study, and round numbers from 0."""
    friction, is_measured = study.friction, study.is_measured
    names_with_range = set(Inputs.from_study(study).uncertain) | ({"mu0", "tau0"} if friction.interface else set())
    mu0, tau0 = np.array(friction.mu0, float), np.array([float(strength) for strength in friction.tau0])
    modulus, hardness = float(study.contact.effective_modulus), study.contact.hardness
    max_tau0 = MAX_TAU0_OVER_MODULUS * modulus
    max_tau0 = max_tau0 if hardness is None else min(max_tau0, MAX_TAU0_OVER_HARDNESS * float(hardness))
    # If a study of generated surfaces has several tau0, the report ends at the largest tau0 of the study.
    max_tau0 = tau0[-1] if tau0.size > 1 and not is_measured else max(max_tau0, tau0[-1])
    round_tau0 = _list_round_numbers(max_tau0, MAX_TAU0_STEPS[is_measured])
    round_mu0 = np.array(MEASURED_MU0_VALUES if is_measured else GENERATED_MU0_VALUES)
    return (
        _build_axis_of_study_and_round_values(mu0, round_mu0, has_range="mu0" in names_with_range),
        _build_axis_of_study_and_round_values(tau0, round_tau0, has_range="tau0" in names_with_range),
    )


def _list_round_numbers(largest: float, max_count: int) -> Floats:
    """Return equally spaced round numbers from 0 to `largest`, in steps of 1, 2 or 5 times a power of 10.

    The step is the smallest for which `largest` is at most `max_count` steps.
    """
    exponent = math.floor(math.log10(largest / max_count))
    step = next(
        step for factor in (1, 2, 5, 10) if (step := float(f"{factor}e{exponent}")) * max_count >= largest * (1 - 1e-9)
    )
    return np.array([float(f"{step * index:.12g}") for index in range(int(largest / step * (1 + 1e-9)) + 1)])


def _build_axis_of_study_and_round_values(
    study_values: Floats, round_values: Floats, *, has_range: bool
) -> ParameterAxis:
    if study_values.size > MAX_SHOWN_MU0_OR_TAU0:
        study_values = study_values[
            np.unique(np.linspace(0, study_values.size - 1, MAX_SHOWN_MU0_OR_TAU0).round().astype(int))
        ]
    difference = np.abs(round_values[:, np.newaxis] - study_values).min(axis=1)
    axis_values = np.union1d(study_values, round_values[difference > 2 * SAME_VALUE_TOLERANCE * round_values])
    return ParameterAxis(axis_values, has_range & (axis_values > 0) & np.isin(axis_values, study_values))
