"""Evaluation of a result: friction and contact quantities, from stored sums of contact forces and contact areas."""

from __future__ import annotations

import difflib
import math
from collections.abc import Collection, Sequence
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any, Literal, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._arguments import convert_friction_parameters, split_texts
from stiction._checks import check_bool, check_instance, make_read_only, parse_names, validate_whole_number
from stiction._units import loads_to_core_units, short_repr, to_core_units
from stiction._warnings import warn_caller
from stiction.companions.contact_forces import compute_contact_forces
from stiction.companions.contact_picture import build_contact_table, compute_loading_cycle, load_contact_picture
from stiction.companions.height_scale import (
    ScaledBodies,
    compute_results_at_height_factors,
    evaluate_at_height_factors,
    group_stored_factors,
    parse_height_factors,
)
from stiction.companions.onset import load_stored_onset, scale_onset
from stiction.companions.resolution import evaluate_at_cutoffs
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty, evaluate_alternatives
from stiction.evaluate.computed_loads import find_loads_without_values
from stiction.evaluate.load_range import choose_default_loads, choose_loads_in_range, replace_zero_load
from stiction.evaluate.maps import iterate_solved_pieces, warn_if_given_tau0_is_large
from stiction.evaluate.member_values import member_values
from stiction.mechanics.quantities import QUANTITIES
from stiction.solve.alternative_preparations import AlternativeName, load_stored_alternatives
from stiction.solve.member_sums import MemberSums
from stiction.solve.store import StoreError
from stiction.summary.assessment import Caveat
from stiction.summary.input_caveats import find_study_caveats
from stiction.summary.joint_table import (
    DEFAULT_JOINT_UNITS,
    JointTable,
    UnitSystem,
    add_load,
    build_joint_table,
    choose_joint_loads,
    parse_closure_start,
)
from stiction.summary.missing_loads import missing_loads_text
from stiction.summary.summary import PointSummary, Summary, summarize

MAX_REACHED_LOADS = 100_000

if TYPE_CHECKING:
    import pandas
    import xarray

    from stiction.solve.store import StoredResult

NUM_OVERVIEW_FRACTAL_DIMENSIONS = 4


class Evaluation(MemberSums):
    """Result of a study: friction, computed from stored sums of contact forces and areas, and other stored results."""

    @cached_property
    def num_solved(self) -> int:
        """Number of surface pairs (members) for which the solver succeeded at all loading steps."""
        return sum(piece.sizes["repetition"] for piece in iterate_solved_pieces(self, ["normal_elastic"]))

    # ---- Stored alongside --------------------------------------------------------------------------------------------

    @property
    def onset(self) -> xarray.Dataset | None:
        """Onset of sliding of a measured pair, for the first load, the first mu0 and the first tau0 of its study.

        The tangential loads are scaled so that the sliding load is μ_s F. None if the onset is not stored, or if the
        result has no coefficient.
        """
        return self.load_companion(self._load_scaled_onset)

    def _load_scaled_onset(self, stored: StoredResult) -> xarray.Dataset | None:
        onset = load_stored_onset(stored)
        return None if onset is None else self.scale_onset(onset)

    def scale_onset(self, onset: xarray.Dataset) -> xarray.Dataset | None:
        """Scale the tangential loads of a computed onset so that sliding starts at μ_s F for friction at all contacts.

        Returns None if the result has no coefficient, and the unchanged onset if the result does not include the rule
        "all".
        """
        summary, friction = self._study_summary, self.study.friction
        if isinstance(summary, ValueError):
            return None
        conditions = {name: float(getattr(friction, name)[0]) for name in ("load", "mu0", "tau0")}
        coefficients = {
            rule.rule: rule
            for point in summary.reported_points
            if all(point.at[name] == value for name, value in conditions.items())
            for rule in point.rules
        }
        if "all" not in coefficients:
            return onset
        coefficient = coefficients["all"]
        return scale_onset(onset, coefficient) if math.isfinite(coefficient.value) and coefficient.value > 0 else None

    @property
    def values_at_cutoffs(self) -> xarray.Dataset | None:
        """Friction coefficients of a few surface pairs at several cutoff wavelengths, or None if none were computed."""
        return self.load_companion(evaluate_at_cutoffs)

    @property
    def alternatives(self) -> dict[AlternativeName, Self]:
        """Stored results in which the scans were prepared in another way, keyed by the name of the preparation."""
        return {name: self.of(sums) for name, sums in load_stored_alternatives(self).items()}

    @property
    def contact_picture(self) -> xarray.Dataset | None:
        """Heights, contacts and pressures of a typical surface pair, or None if no contact map is stored."""
        return self.load_companion(load_contact_picture)

    @property
    def loading_cycle(self) -> xarray.Dataset | None:
        """Load, contact area and approach of a typical adhesive surface pair during loading and subsequent unloading.

        None for other results. The cycle is computed on first use.
        """
        return self.compute_once(compute_loading_cycle)

    @property
    def contact_forces(self) -> xarray.Dataset | None:
        """Contact of two profiles in the asperity model: both profiles, and the contact forces on the upper profile.

        None for maps, for the half-space model, and if no pair has contacts. The forces are computed on first use.
        """
        return self.compute_once(compute_contact_forces)

    @property
    def height_factors(self) -> dict[ScaledBodies, list[float]]:
        """Factors by which heights were multiplied for stored results, keyed by body: "both", "upper" or "lower"."""
        return {} if self.stored is None else group_stored_factors(self.stored)

    @cached_property
    def input_caveats(self) -> tuple[Caveat, ...]:
        """Caveats about the scans and other inputs of measured bodies; the caveats do not depend on the load.

        The files are read on first use.
        """
        return find_study_caveats(self.study, list(self.alternatives))

    # ---- Evaluation at a load ----------------------------------------------------------------------------------------

    def reached_loads(self, steps: int = 80) -> NDArray[np.float64]:
        """Return loads (mN) in geometric progression, up to the largest load that the surface pairs reach on average.

        Raises a `ValueError` if there is no contact.
        """
        steps = validate_whole_number("steps", steps, minimum=1, maximum=MAX_REACHED_LOADS)
        return choose_loads_in_range(self, steps)

    @cached_property
    def default_loads(self) -> NDArray[np.float64]:
        """Loads (mN) listed in the study or, if it lists none, a few loads in the range that the result covers.

        Raises a `ValueError` if there is no contact.
        """
        return make_read_only(choose_default_loads(self))

    @property
    def at_study_loads(self) -> xarray.Dataset:
        """Friction and other quantities at each load, mu0 and tau0 of the study, with intervals and uncertainty budget.

        If the study has a range of fractal dimensions, only `NUM_OVERVIEW_FRACTAL_DIMENSIONS` of them are evaluated.
        """
        return self.compute_once(Evaluation._evaluate_at_study_loads)

    @property
    def _at_all_dimensions(self) -> xarray.Dataset:
        """Friction and contact quantities for all fractal dimensions, at the loads, mu0 and tau0 of the study."""
        return self.compute_once(Evaluation._evaluate_at_all_dimensions)

    def _evaluate_at_all_dimensions(self) -> xarray.Dataset:
        return self.at(budget=True)

    def _evaluate_at_study_loads(self) -> xarray.Dataset:
        quantities = self._at_all_dimensions
        if self.study.is_measured:
            return quantities
        surfaces: Any = self.study.surfaces
        if isinstance(surfaces.fractal_dimension, tuple):
            return quantities
        # A curve over a range of fractal dimensions needs only a few points.
        num_dimensions = quantities.sizes["fractal_dimension"]
        shown_indices = np.unique(
            np.linspace(0, num_dimensions - 1, min(NUM_OVERVIEW_FRACTAL_DIMENSIONS, num_dimensions)).round().astype(int)
        )
        return quantities.isel(fractal_dimension=shown_indices)

    @property
    def at_report_loads(self) -> xarray.Dataset:
        """Friction and contact quantities of measured bodies, with intervals, at all requested and all computed loads.

        mu0 and tau0 are those of the study. At the loads of the study, the dataset agrees with `at_study_loads`, which
        also contains predictions and the uncertainty budget. The arrays are read-only.
        """
        return self.compute_once(Evaluation._evaluate_at_report_loads)

    def _evaluate_at_report_loads(self) -> xarray.Dataset:
        import xarray

        study_points = self.at_study_loads
        other_loads = np.setdiff1d(self.study.contact.loading_steps(), study_points["load"].values)
        if not other_loads.size:
            return study_points
        other_points = add_uncertainty(at_load(self, other_loads), self, budget=False, tests=False)
        points = [study_points[list(other_points.data_vars)], other_points]
        options: Any = {"data_vars": "minimal", "coords": "minimal", "compat": "override", "combine_attrs": "override"}
        return xarray.concat(points, "load", **options).sortby("load")

    def at(
        self, load: str | ArrayLike | None = None, *, mu0: ArrayLike | None = None, tau0: str | ArrayLike | None = None,
        load_definition: Any = None, quantities: Collection[str] | None = None, per_member: bool = False,
        budget: bool = False, height_scale: str | ArrayLike | None = None,
        scaled: Literal["both", "upper", "lower"] = "both", compute: bool = False,
    ) -> xarray.Dataset:  # fmt: skip
        """Evaluate friction and contact quantities with intervals for given loads, given mu0 and given tau0.

        No contacts are computed again, unless `compute` requires other factors of the heights.

        For measured bodies at elastic loads, `friction_combined` has the combined 95 % interval. All other coefficients
        have the interval of the mean over positions. Between computed loads, values are interpolated, and the
        intervals include the interpolation error.

        With `height_scale`, the dataset contains friction, true area and stiffness for factors of the heights, as for
        other surface finishes. Results between stored factors are interpolated. Results at other factors are computed
        if `compute` is true.

        Parameters
        ----------
        load : str or array_like of float, mN, optional
            Loads such as "10 mN" or, except for generated profiles, "10 MPa" on the nominal area; by default the loads
            of the study. Several loads are a list, ["3 MPa", "10 MPa"], or a text, "3 MPa,10 MPa".
        mu0 : str or array_like of float, optional
            Such as 0.3, [0.3, 0.4] or "0.3,0.4".
        tau0 : str or array_like of float, GPa, optional
            Such as "50 MPa", ["10 MPa", "50 MPa"] or "10 MPa,50 MPa". Intervals include the range of mu0 or tau0 in
            the study only at its central value, and any other value is exact.
        load_definition : {"mean", "elastic", "normal"}, optional
            Definition of the load, as for `at_load`.
        quantities : collection of str, optional
            Names of quantities to evaluate besides friction, such as ["contact_area"]; by default all, which
            ``list(result.at())`` lists. Quantities that show whether the model is valid, such as "share_beyond_hertz",
            are also evaluated only if they are named; a summary contains no caveats about omitted quantities.
        per_member : bool
            True to return the values of each member, as `member_values` does, instead of means and intervals.
        budget : bool
            True to add the uncertainty budget of measured bodies, which takes most of the time.
        height_scale : float, array_like or str, optional
            Factors of the heights from 0.01 to 100, such as 0.5, "0.5,1,2" or "0.25..4".
        scaled : {"both", "upper", "lower"}
            Surfaces whose heights are scaled.
        compute : bool
            True to compute missing factors.

        Raises
        ------
        ValueError
            If an argument is outside its range, or if a factor of the heights has not been computed. The message
            then states how long the computation would take.

        Examples
        --------
        >>> from stiction import pair, self_affine_surface
        >>> a, b = (
        ...     self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, side=side)
        ...     for side in ("upper", "lower")
        ... )
        >>> result = pair(a, b, load="10 MPa", effective_modulus="80 GPa", hardness="2 GPa", mu0=0.2, shifts=2)
        >>> at = result.at(height_scale=[0.5, 1, 2], compute=True)
        >>> gradient = at["rms_gradient"].sel(statistic="mean").values
        >>> (gradient / gradient[1]).round(6).tolist()
        [0.5, 1.0, 2.0]
        """
        for name, value in (("per_member", per_member), ("budget", budget)):
            check_bool(name, value)
        if per_member and (budget or height_scale is not None):
            raise ValueError("per_member must be False if budget or height_scale is given")
        if quantities is not None:
            if per_member or budget or height_scale is not None:
                raise ValueError("quantities must be None if per_member, budget or height_scale is given")
            quantities = parse_names("quantities", quantities)
            if unknown_names := [name for name in quantities if name not in QUANTITIES]:
                suggestions = difflib.get_close_matches(unknown_names[0], QUANTITIES, n=1)
                hint = f"; did you mean {suggestions[0]!r}?" if suggestions else ""
                raise ValueError(
                    "quantities must be names of variables of the dataset, as listed by list(result.at()), "
                    f"got {short_repr(unknown_names[0])}{hint}"
                )
        if height_scale is not None:
            return self._evaluate_at_height_factors(height_scale, load, mu0, tau0, load_definition, scaled, compute)
        loads = self.default_loads if load is None else self._to_forces(load)
        mu0, tau0 = convert_friction_parameters(mu0, tau0)
        if per_member:
            load_definition = "elastic" if load_definition is None else load_definition
            values = member_values(self, loads, mu0=mu0, tau0=tau0, load_definition=load_definition)
        else:
            values = at_load(self, loads, mu0=mu0, tau0=tau0, load_definition=load_definition, names=quantities)
            values = add_uncertainty(values, self, budget=budget)
        warn_if_given_tau0_is_large(self, tau0)
        # A copy is returned, because other results share the cached arrays.
        return values.copy(deep=True)

    def _evaluate_at_height_factors(
        self, factors: Any, load: Any, mu0: Any, tau0: Any, load_definition: Any, scaled: Any, compute: bool
    ) -> xarray.Dataset:
        check_bool("compute", compute)
        if not (load_definition is None or (isinstance(load_definition, str) and load_definition == "elastic")):
            raise ValueError(
                f"load_definition must be 'elastic' if height_scale is given, got {short_repr(load_definition)}"
            )
        if self.stored is None:
            raise ValueError("height_scale needs a stored result, as returned by pair() or open_result()")
        factors = parse_height_factors(factors)
        loads = self.default_loads if load is None else self._to_forces(load)
        mu0, tau0 = convert_friction_parameters(mu0, tau0)
        if compute:
            compute_results_at_height_factors(self.stored, factors, scaled)
        return evaluate_at_height_factors(self.stored, factors, loads, mu0=mu0, tau0=tau0, scaled=scaled)

    @cached_property
    def nominal_area(self) -> float | None:
        """Nominal area (µm²) of one surface pair, or None for generated profiles."""
        if self.study.is_measured:
            return float(self.head["nominal_area"])
        surfaces: Any = self.study.surfaces
        return float(surfaces.nominal_area) if self.study.is_areal else None

    def _to_forces(self, load: Any) -> Any:
        """Convert loads, given as forces or pressures, to forces (mN).

        A load that is given as a pressure is multiplied by the nominal area.
        """
        area, load = self.nominal_area, split_texts("load", load)
        return to_core_units("load", load, "force") if area is None else loads_to_core_units("load", load, area)

    def contacts(
        self, load: str | ArrayLike | None = None, *, members: int | Sequence[int] | None = None
    ) -> pandas.DataFrame:
        """Return a table with one row per contact, for a typical surface pair or for surface pairs with given indices.

        Parameters
        ----------
        load : str or array_like of float, mN, optional
            Elastic normal loads, as for `at`; by default the first load of the study.
        members : int or sequence of int, optional
            By default the member whose true area is nearest to the mean, at each load.

        Returns
        -------
        pandas.DataFrame
            Columns: member; the cell (fractal_dimension and amplitude_um of generated bodies, cut_off_um of measured
            bodies); load_mN; centre x_um and y_um, force_mN (normal load), area_um2 (projected), mean_pressure_GPa and
            mean slopes slope_x and slope_y of the contact; and at_edge, True if the contact reaches the edge of the
            grid. y_um and slope_y are 0 for profiles.

        Raises
        ------
        ValueError
            If there is no such member or no contact, or if files of the study are missing.
        """
        loads = self.default_loads[:1] if load is None else self._to_forces(load)
        return build_contact_table(self, loads, members)

    def joint_table(
        self, load: str | ArrayLike | None = None, *, mu0: ArrayLike | None = None, tau0: str | ArrayLike | None = None,
        units: UnitSystem = DEFAULT_JOINT_UNITS, closure_from: str | float | None = None,
        reference_load: str | float | None = None,
    ) -> JointTable:  # fmt: skip
        """Return the joint table of a measured pair: closure, stiffness, friction and true area at several pressures.

        Finite-element programs describe a joint by these properties.

        Parameters
        ----------
        load : str or array_like of float, mN, optional
            Loads as for `at`; by default the computed loads, and loads between them.
        mu0 : float, optional
        tau0 : str or float, GPa, optional
            By default the first values of the study.
        units : {"mm,N,MPa", "m,N,Pa", "um,mN,GPa"}
            Units of length, force and pressure.
        closure_from : str or float, mN, optional
            Load from which the closure is counted, "0.1 MPa". By default, the closure is counted from first contact.
        reference_load : str or float, mN, optional
            Load of `JointTable.reference`, added to the loads of the table; by default the lowest load of the pair.

        Raises
        ------
        ValueError
            If the bodies were generated, no load has a closure, or `closure_from` or `reference_load` is outside the
            computed loads.

        Warns
        -----
        UserWarning
            If some of the given loads are outside the computed loads, so that the table has no rows for them.

        Examples
        --------
        >>> from stiction import pair, self_affine_surface
        >>> a, b = (
        ...     self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, side=side)
        ...     for side in ("upper", "lower")
        ... )
        >>> table = pair(a, b, load="10 MPa", effective_modulus="80 GPa", mu0=0.2, shifts=3, onset=0).joint_table()
        >>> table.reference.pressure.value, table.reference.estimates["closure"].unit
        (10.0, 'mm')
        """
        loads = choose_joint_loads(self.study, self.nominal_area)
        given_loads = [] if load is None else np.atleast_1d(self._to_forces(load)).ravel().tolist()
        loads = loads if load is None else np.array(given_loads, float)
        start_load = None
        if closure_from is not None:
            start_load = parse_closure_start(closure_from, self.study, self.nominal_area)
            loads, start_load = add_load(np.atleast_1d(loads), start_load)
        if reference_load is not None:
            (positive_load,) = replace_zero_load(self, np.array([self._to_forces(reference_load)], float)).tolist()
            loads, reference_load = add_load(loads, positive_load)
            given_loads.append(reference_load)
        friction = self.study.friction
        strengths: dict[str, Any] = {
            "mu0": friction.mu0[:1] if mu0 is None else mu0,
            "tau0": friction.tau0[:1] if tau0 is None else tau0,
        }
        at = self.at(loads, **strengths)
        for name, values in strengths.items():
            if at.sizes.get(name, 1) > 1:
                raise ValueError(f"{name} must be a single value, got {short_repr(values)}")
        missing_loads = [value for value in find_loads_without_values(self, at) if value in given_loads]
        if missing_loads:
            message = missing_loads_text(self, at, missing_loads)
            if len(missing_loads) == len(set(given_loads)) or reference_load in missing_loads:
                raise ValueError(message)
            warn_caller(message)
        points = self.summarize_dataset(at).reported_points
        assessments = {float(point.at["load"]): point.assessment for point in points}
        return build_joint_table(at, self.study, units, assessments, start_load, reference_load)

    # ---- Reported values ---------------------------------------------------------------------------------------------

    def summary(
        self, load: str | ArrayLike | None = None, *, mu0: ArrayLike | None = None, tau0: str | ArrayLike | None = None
    ) -> Summary:
        """Summarize the result for given loads, mu0 and tau0.

        By default, these are the loads, mu0 and tau0 of the study. The default summary is computed only once.

        Raises
        ------
        ValueError
            If no member is in contact or could be computed at the loads of the study, or if an argument is invalid.
        """
        if load is None and mu0 is None and tau0 is None:
            if isinstance(self._study_summary, ValueError):
                # The traceback is reset, because it would grow each time the same error is raised.
                raise self._study_summary.with_traceback(None)
            summary = self._study_summary
            return replace(summary, at=summary.at.copy(), onset=self.onset, values_at_cutoffs=self.values_at_cutoffs)
        return self.summarize_dataset(self.at(load, mu0=mu0, tau0=tau0, budget=True))

    def summary_at(self, loads: ArrayLike, mu0: float, tau0: float) -> Summary:
        """Summarize the result at given loads (mN), for one mu0 and one tau0 (GPa) that were fitted to friction tests.

        `summary` also accepts texts with units, and warns if the unit of tau0 is probably wrong.
        """
        return self.summarize_dataset(add_uncertainty(at_load(self, loads, mu0=mu0, tau0=tau0), self, budget=True))

    def complete_summary(self) -> Summary:
        """Summarize the result for all loads, mu0, tau0 and fractal dimensions of the study.

        `summary` leaves out most fractal dimensions of a range. Raises a `ValueError` as `summary` does.
        """
        summary = self.summary()
        has_all_cells = all(summary.at.sizes[name] == size for name, size in self._at_all_dimensions.sizes.items())
        return summary if has_all_cells else self.summarize_dataset(self._at_all_dimensions)

    def summarize_dataset(self, at: xarray.Dataset) -> Summary:
        """Summarize a dataset returned by `at` with `budget=True`, or a selection from this dataset."""
        import xarray

        check_instance("at", at, xarray.Dataset, "a dataset from Result.at")
        alternatives = {
            name: summarize(values, self.alternatives[name].study)
            for name, values in evaluate_alternatives(self, at).items()
        }
        return summarize(at, self.study, input_caveats=self.input_caveats, alternatives=alternatives)

    @cached_property
    def _study_summary(self) -> Summary | ValueError:
        """Summary at the loads of the study, or an error that states why there is no friction coefficient.

        The error is cached too, because it takes as long to compute as a summary.
        """
        try:
            return self.summarize_dataset(self.at_study_loads)
        except StoreError:
            # An error of stored files is raised instead of cached, because the user may repair the files.
            raise
        except ValueError as error:
            return error

    @property
    def _first_reported_point(self) -> PointSummary:
        return self.summary().first

    @property
    def value(self) -> float:
        """Static friction coefficient at the first reported load, mu0 and tau0; NaN if there is no coefficient."""
        return self._first_reported_point.value

    @property
    def interval(self) -> tuple[float, float]:
        """Limits of the 95 % interval of `value`, due to uncertain inputs, positions and unresolved roughness."""
        return self._first_reported_point.lower, self._first_reported_point.upper

    @property
    def interval_of_mean(self) -> tuple[float, float]:
        """Limits of the 95 % interval of the mean over positions, without the uncertainty of the inputs."""
        lower, upper = self._first_reported_point.rules[0].interval_of_mean
        return lower, upper

    @property
    def prediction_interval(self) -> tuple[float, float]:
        """Limits of the 95 % prediction interval of a single test at one position in one direction of motion."""
        lower, upper = self._first_reported_point.rules[0].prediction_interval
        return lower, upper

    @property
    def budget(self) -> pandas.DataFrame:
        """Uncertainty budget: table of inputs, each with the interval that would remain if the input were exact.

        The most important input comes first. Columns: input, lower, upper, width (averaged over possible numbers of the
        input) and fraction (of the combined interval's width that would vanish).
        """
        import pandas

        point = self._first_reported_point
        total_width = point.upper - point.lower
        rows = [
            (entry.label, entry.lower, entry.upper, entry.width, 1 - entry.width / total_width)
            for entry in point.budget
        ]
        return pandas.DataFrame(rows, columns=["input", "lower", "upper", "width", "fraction"])

    @property
    def assessment(self) -> str:
        """Assessment of `value`: "Quote it", "Quote with care" or "Do not quote"."""
        return self._first_reported_point.assessment

    @property
    def caveats(self) -> tuple[Caveat, ...]:
        """Caveats about `value` with their remedies, the most severe caveats first."""
        return self._first_reported_point.caveats
