"""Result of a study, in memory or in a directory. It contains contact sums, from which values are computed."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import check_bool, check_instance
from stiction._repr import figure_html, preformatted_html, render_png
from stiction._units import loads_to_core_units, short_repr, to_core_units
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.layout import compute_members_per_piece
from stiction.studies.store import StoredResult, StoreError, export, open_stored_result
from stiction.studies.study import Study, parse_study_of_dataset

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from stiction.studies.alternatives import AlternativeName
    from stiction.studies.assessment import Caveat
    from stiction.studies.height_scale import ScaledBodies
    from stiction.studies.nodes import InterpolationNodes
    from stiction.studies.summary import PointSummary, Summary

# number of fractal dimensions that represent a range in an overview
NUM_OVERVIEW_FRACTAL_DIMENSIONS = 4

_Read = TypeVar("_Read")


class Result:
    """Result of a study of generated or measured surfaces. It is returned by `run`, `pair` and `open_result`.

    Parameters
    ----------
    source : xarray.Dataset or StoredResult
        Sums of all members in memory, or an open directory.

    Examples
    --------
    >>> from stiction import Study, run
    >>> result = run(Study.named("quick").with_changes({"ensemble.repetitions": 2, "surfaces.points": 3000}))
    >>> sorted(result.dataset.sizes)
    ['amplitude', 'approach', 'fractal_dimension', 'repetition']
    """

    def __init__(self, source: xarray.Dataset | StoredResult) -> None:
        self.source = source
        self._alongside: dict[Callable[[StoredResult], Any], Any] = {}

    @classmethod
    def of(cls, result: Result | xarray.Dataset | StoredResult) -> Result:
        """Convert a dataset of member sums or an opened directory to a result. Return a result unchanged."""
        import xarray

        if isinstance(result, Result):
            return result
        check_instance(
            "result", result, (xarray.Dataset, StoredResult), "a Result, or an xarray.Dataset of member sums"
        )
        return cls(result)

    # ---- Computed members --------------------------------------------------------------------------------------------

    @property
    def stored(self) -> StoredResult | None:
        """Result stored in a directory, or None if the result is in memory."""
        return self.source if isinstance(self.source, StoredResult) else None

    @cached_property
    def study(self) -> Study:
        """Study from which the result was computed."""
        return self.source.study if isinstance(self.source, StoredResult) else parse_study_of_dataset(self.source)

    @property
    def path(self) -> Path | None:
        """Directory of the result, or None if the result is in memory."""
        return None if self.stored is None else self.stored.path

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """Dataset that contains the contact sums of all members in memory.

        Raises a `StoreError` if the sums take more than 2 GiB.
        """
        return self.source.dataset() if isinstance(self.source, StoredResult) else self.source

    @cached_property
    def head(self) -> xarray.Dataset:
        """Dataset with the coordinates and attributes of the result.

        For a stored result, this dataset contains the values of one member only. Raises a `StoreError` if no
        member is finished.
        """
        if not isinstance(self.source, StoredResult):
            return self.source
        # If the result has no members, `StoredResult.dataset` raises an error.
        return self.source.first_member() if self.source.num_finished else self.source.dataset()

    @cached_property
    def members(self) -> NDArray[np.intp]:
        """Indices of the finished members."""
        if isinstance(self.source, StoredResult):
            return self.source.finished_members
        return np.asarray(self.source["repetition"].values, dtype=np.intp)

    @property
    def version(self) -> str:
        """Version of stiction that computed the result."""
        if isinstance(self.source, StoredResult):
            return self.source.version
        return str(self.source.attrs.get("stiction_version", "unknown"))

    def pieces(self, names: Iterable[str] | None = None) -> Iterator[xarray.Dataset]:
        """Yield the result in pieces (groups of members) with the named variables. Only one piece is held in memory.

        The pieces depend only on the study, so that sums over the pieces are bitwise reproducible.
        """
        if isinstance(self.source, StoredResult):
            yield from self.source.pieces(names)
            return
        count = self.source.sizes["repetition"]
        piece_size = compute_members_per_piece(
            sum(each.nbytes for each in self.source.data_vars.values()) // max(1, count)
        )
        selected_dataset = self.source if names is None else self.source[list(names)]
        for piece_start in range(0, count, piece_size):
            yield selected_dataset.isel(repetition=slice(piece_start, piece_start + piece_size))

    def means(self, names: Iterable[str]) -> xarray.Dataset:
        """Average variables over the members that the solver completed at a loading step; NaN if there are none.

        Only one piece of the result is held in memory at a time.
        """
        import xarray

        names, sums, counts = list(names), dict[str, xarray.Variable](), dict[str, xarray.Variable]()
        for piece in self.pieces(names):
            for name in names:
                dims = [str(dim) for dim in piece[name].dims if dim != "repetition"]
                # Summation is fast if the repetitions are contiguous in memory.
                values = np.ascontiguousarray(piece[name].transpose(*dims, "repetition").values)
                is_solved = ~np.isnan(values)
                piece_sum = xarray.Variable(dims, np.where(is_solved, values, 0).sum(axis=-1))
                piece_count = xarray.Variable(dims, is_solved.sum(axis=-1))
                sums[name] = piece_sum if name not in sums else sums[name] + piece_sum
                counts[name] = piece_count if name not in counts else counts[name] + piece_count
        head = self.head
        coordinates = {name: variable for name, variable in head.coords.items() if "repetition" not in variable.dims}
        with np.errstate(invalid="ignore"):
            variables = {
                name: (value.dims, value.values / counts[name].values, head[name].attrs) for name, value in sums.items()
            }
        return xarray.Dataset(variables, coordinates, head.attrs)

    @cached_property
    def mean_elastic_loads(self) -> xarray.DataArray:
        """Elastic load (mN) of each cell at each loading step, averaged over the members solved at this step."""
        return self.means(["normal_elastic"])["normal_elastic"]

    @cached_property
    def num_solved(self) -> int:
        """Number of members that the solver completed at all loads or approaches."""
        from stiction.studies.maps import iterate_solved_pieces

        return sum(piece.sizes["repetition"] for piece in iterate_solved_pieces(self, ["normal_elastic"]))

    def load_companion(self, read: Callable[[StoredResult], _Read | None]) -> _Read | None:
        """Call `read` to load data that are stored alongside the result, and cache the data.

        Returns None for results in memory.

        The value None is not cached, because an unfinished run may add the data later.
        """
        if self.stored is None:
            return None
        if read not in self._alongside:
            value = read(self.stored)
            if value is None:
                return None
            self._alongside[read] = value
        return self._alongside[read]  # type: ignore[no-any-return]

    @property
    def onset(self) -> xarray.Dataset | None:
        """Onset of sliding of a measured pair, computed for the first load, mu0 and tau0 in the study.

        None if the onset is not stored.
        """
        from stiction.studies.onset import load_stored_onset

        return self.load_companion(load_stored_onset)

    @property
    def values_at_cutoffs(self) -> xarray.Dataset | None:
        """Values of the cutoff study: a few members at several cutoffs. None if no cutoff study is stored."""
        from stiction.studies.resolution import evaluate_at_cutoffs

        return self.load_companion(evaluate_at_cutoffs)

    @property
    def alternatives(self) -> dict[AlternativeName, Result]:
        """Stored results for alternative preparations of the scans, by name. The combined interval includes them."""
        from stiction.studies.alternatives import load_alternatives

        return self.load_companion(load_alternatives) or {}

    @property
    def contact_picture(self) -> xarray.Dataset | None:
        """Heights, contacts and pressures of a typical member, or None if no contact picture is stored."""
        from stiction.studies.contact_picture import load_contact_picture

        return self.load_companion(load_contact_picture)

    @cached_property
    def loading_cycle(self) -> xarray.Dataset | None:
        """Load, contact area and approach of a typical adhesive member during loading and unloading.

        The values are computed on first use.
        """
        from stiction.studies.contact_picture import compute_loading_cycle

        return compute_loading_cycle(self)

    @cached_property
    def contact_forces(self) -> xarray.Dataset | None:
        """Two profiles in contact, and the forces on the upper profile at each contact of the asperity model.

        None for maps, for the half-space model, and if no pair has contacts. The forces are computed on first use.
        """
        from stiction.studies.contact_forces import compute_contact_forces

        return compute_contact_forces(self)

    @property
    def height_factors(self) -> dict[ScaledBodies, list[float]]:
        """Stored height factors, in separate lists for both bodies, only the upper body and only the lower body."""
        from stiction.studies.height_scale import group_stored_factors

        return {} if self.stored is None else group_stored_factors(self.stored)

    @cached_property
    def nodes(self) -> InterpolationNodes:
        """Values at nodes of mu0 and tau0, between which a report interpolates."""
        from stiction.studies.nodes import InterpolationNodes

        return InterpolationNodes(self)

    @cached_property
    def input_caveats(self) -> tuple[Caveat, ...]:
        """Caveats about the measured bodies. They apply at all loads.

        The files are read on first use.
        """
        from stiction.studies.input_caveats import find_study_caveats

        return find_study_caveats(self.study, list(self.alternatives))

    # ---- Evaluation at a load ----------------------------------------------------------------------------------------

    def reached_loads(self, steps: int = 80) -> NDArray[np.float64]:
        """Return loads (mN) in a geometric series up to the largest mean load.

        Raises a `ValueError` if there is no contact.
        """
        from stiction.studies.load_range import choose_loads_in_range

        return choose_loads_in_range(self, steps)

    @cached_property
    def default_loads(self) -> NDArray[np.float64]:
        """Loads (mN) in the study, or a few loads within the range of the result if the study has no loads.

        Raises a `ValueError` if there is no contact.
        """
        from stiction.studies.load_range import choose_default_loads

        return choose_default_loads(self)

    @cached_property
    def mean_areas(self) -> NDArray[np.float64]:
        """True area (µm²) at each computed load, averaged over the members."""
        from stiction.studies.member_values import compute_mean_areas

        return compute_mean_areas(self)

    @cached_property
    def at_study_loads(self) -> xarray.Dataset:
        """Values, intervals and uncertainty budget at the loads, mu0 and tau0 of the study.

        If the study has a range of fractal dimensions, only `NUM_OVERVIEW_FRACTAL_DIMENSIONS` values are evaluated.
        """
        values = self.at(budget=True)
        if self.study.is_measured:
            return values
        surfaces: Any = self.study.surfaces
        if isinstance(surfaces.fractal_dimension, tuple):
            return values
        # If the fractal dimensions are a range, a few values suffice for a curve.
        # If they are a list, all values are needed.
        num_dimensions = values.sizes["fractal_dimension"]
        shown_indices = np.unique(
            np.linspace(0, num_dimensions - 1, min(NUM_OVERVIEW_FRACTAL_DIMENSIONS, num_dimensions)).round().astype(int)
        )
        return values.isel(fractal_dimension=shown_indices)

    def at(
        self, load: str | ArrayLike | None = None, *, mu0: ArrayLike | None = None, tau0: str | ArrayLike | None = None,
        reading: Any = None, quantities: Collection[str] | None = None, per_member: bool = False, budget: bool = False,
        height_scale: str | ArrayLike | None = None, scaled: Literal["both", "upper", "lower"] = "both",
        compute: bool = False,
    ) -> xarray.Dataset:  # fmt: skip
        """Evaluate the result with its intervals at any loads, mu0 and tau0.

        The contacts need no new computation.

        For measured bodies at elastic loads, `friction_combined` has the combined 95 % interval. All other coefficients
        have the sampling interval of the mean over positions.

        With `height_scale`, the dataset contains friction, true area and stiffness for factors of the heights, as for
        other surface finishes. Results between stored factors are interpolated. Results at other factors are computed
        if `compute` is true.

        Parameters
        ----------
        load : str or array_like of float, mN, optional
            Loads such as "10 mN" or, for measured bodies, "10 MPa" on the nominal area; by default the loads of the
            study.
        mu0 : array_like of float, optional
        tau0 : str or array_like of float, GPa, optional
            Such as "50 MPa".
        reading : {"mean", "elastic", "normal"}, optional
            Definition of the load, as for `at_load`.
        quantities : collection of str, optional
            Names of quantities to evaluate besides friction, such as ["contact_area"]; all by default. Quantities
            that show whether the model is valid, such as "share_beyond_hertz", are also evaluated only if they are
            named; a summary contains no caveats about omitted quantities.
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
        from stiction.studies.at_load import at_load
        from stiction.studies.budget import add_uncertainty
        from stiction.studies.member_values import member_values

        for name, value in (("per_member", per_member), ("budget", budget)):
            check_bool(name, value)
        if per_member and (budget or height_scale is not None):
            raise ValueError("per_member must be False if budget or height_scale is given")
        if quantities is not None:
            if per_member or budget or height_scale is not None:
                raise ValueError("quantities must be None if per_member, budget or height_scale is given")
            quantities = [quantities] if isinstance(quantities, str) else list(quantities)
            if unknown_names := [name for name in quantities if name not in QUANTITIES]:
                raise ValueError(
                    f"quantities must be names in the table of quantities, got {short_repr(unknown_names[0])}"
                )
        if height_scale is not None:
            return self._evaluate_at_height_factors(height_scale, load, mu0, tau0, reading, scaled, compute)
        loads = self.default_loads if load is None else self._to_forces(load)
        strengths = to_core_units("tau0", tau0, "pressure")
        if per_member:
            return member_values(self, loads, mu0=mu0, tau0=strengths, reading=reading or "elastic")
        return add_uncertainty(
            at_load(self, loads, mu0=mu0, tau0=strengths, reading=reading, names=quantities), self, budget=budget
        )

    def _evaluate_at_height_factors(
        self, factors: Any, load: Any, mu0: Any, tau0: Any, reading: Any, scaled: Any, compute: bool
    ) -> xarray.Dataset:
        from stiction.studies.height_scale import (
            compute_results_at_height_factors,
            evaluate_at_height_factors,
            parse_height_factors,
        )

        check_bool("compute", compute)
        if reading not in (None, "elastic"):
            raise ValueError(f"reading must be 'elastic' if height_scale is given, got {reading!r}")
        if self.stored is None:
            raise ValueError("height_scale needs a stored result, as returned by `pair` or `open_result`")
        factors = parse_height_factors(factors)
        loads = self.default_loads if load is None else self._to_forces(load)
        strengths = to_core_units("tau0", tau0, "pressure")
        if compute:
            compute_results_at_height_factors(self.stored, factors, scaled)
        return evaluate_at_height_factors(self.stored, factors, loads, mu0=mu0, tau0=strengths, scaled=scaled)

    @property
    def nominal_area(self) -> float | None:
        """Nominal area (µm²) of a member of measured bodies, or None for generated bodies."""
        return float(self.head["nominal_area"]) if self.study.is_measured else None

    def _to_forces(self, load: Any) -> Any:
        """Convert loads to mN. For measured bodies, pressures are multiplied by the nominal area."""
        area = self.nominal_area
        return to_core_units("load", load, "force") if area is None else loads_to_core_units("load", load, area)

    def contacts(
        self, load: str | ArrayLike | None = None, *, members: int | Sequence[int] | None = None
    ) -> pandas.DataFrame:
        """Return a table with one row per contact, for a typical member or for the given members.

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
        from stiction.studies.contact_picture import build_contact_table

        loads = self.default_loads[:1] if load is None else self._to_forces(load)
        return build_contact_table(self, loads, members)

    # ---- Reported values ---------------------------------------------------------------------------------------------

    def summary(
        self, load: str | ArrayLike | None = None, *, mu0: ArrayLike | None = None, tau0: str | ArrayLike | None = None
    ) -> Summary:
        """Summarize the values to report at the given loads, mu0 and tau0.

        By default the loads, mu0 and tau0 are the values in the study.
        The default summary is computed only once.

        Raises
        ------
        ValueError
            If no member is in contact or could be computed at the loads of the study, or if an argument is invalid.
        """
        if load is None and mu0 is None and tau0 is None:
            if isinstance(self._study_summary, ValueError):
                raise self._study_summary.with_traceback(None)  # otherwise each call would extend the same traceback
            return replace(self._study_summary, onset=self.onset, values_at_cutoffs=self.values_at_cutoffs)
        return self.summarize_dataset(self.at(load, mu0=mu0, tau0=tau0, budget=True))

    def summarize_dataset(self, at: xarray.Dataset) -> Summary:
        """Summarize a dataset returned by `at` with `budget=True`, or a selection from such a dataset."""
        from stiction.studies.summary import summarize

        alternatives = {
            name: summarize(other.at(at["load"].values, mu0=at["mu0"].values, tau0=at["tau0"].values), other.study)
            for name, other in self.alternatives.items()
        }
        return summarize(at, self.study, input_caveats=self.input_caveats, alternatives=alternatives)

    @cached_property
    def _study_summary(self) -> Summary | ValueError:
        """Summary at the loads of the study, or the error that states why the result has no values.

        The error is cached too, because it takes as long to compute as a summary.
        """
        try:
            return self.summarize_dataset(self.at_study_loads)
        except StoreError:  # The files may be repaired.
            raise
        except ValueError as error:
            return error

    @property
    def _first_reported_point(self) -> PointSummary:
        return self.summary().first

    @property
    def value(self) -> float:
        """Coefficient of static friction at the reported point, or NaN if the result has no coefficient."""
        return self._first_reported_point.value

    @property
    def interval(self) -> tuple[float, float]:
        """Limits of the combined 95 % interval of `value`. It reflects inputs, positions and unresolved roughness."""
        return self._first_reported_point.lower, self._first_reported_point.upper

    @property
    def of_positions(self) -> tuple[float, float]:
        """Limits of the 95 % confidence interval of the mean over positions. Inputs have their central values."""
        lower, upper = self._first_reported_point.rules[0].sampling_interval
        return lower, upper

    @property
    def next_test(self) -> tuple[float, float]:
        """Limits of the 95 % prediction interval for one test at one position in one direction of motion."""
        lower, upper = self._first_reported_point.rules[0].next_test
        return lower, upper

    @property
    def budget(self) -> pandas.DataFrame:
        """Uncertainty budget. Each row contains the interval that would remain if one input were exact.

        The most important input comes first. Columns: input, lower, upper, width (averaged over values of the input)
        and share (fraction of the width that would vanish).
        """
        import pandas

        point = self._first_reported_point
        total_width = point.upper - point.lower
        rows = [
            (entry.words, entry.lower, entry.upper, entry.width, 1 - entry.width / total_width)
            for entry in point.budget
        ]
        return pandas.DataFrame(rows, columns=["input", "lower", "upper", "width", "share"])

    @property
    def verdict(self) -> str:
        """Assessment of `value`: "Quote it", "Quote with care" or "Do not quote"."""
        return self._first_reported_point.verdict

    @property
    def assessment(self) -> str:
        """Alias of `verdict`."""
        return self.verdict

    @property
    def caveats(self) -> tuple[Caveat, ...]:
        """Caveats about `value`, each with a remedy. Faults come first."""
        return self._first_reported_point.caveats

    @property
    def sentence(self) -> str:
        """Sentences to quote, one for each load on a line of its own, with all conditions under which the value holds.

        Loads whose coefficient must not be quoted have a sentence with the reason. If `mu0` and `tau0` have several
        values, each combination has a sentence. For generated surfaces, only the first surfaces, mu0 and tau0 do.
        """
        from stiction.views.sentence import quotable_sentences

        return "\n".join(quotable_sentences(self.summary()))

    # ---- Tables, figures and reports ---------------------------------------------------------------------------------

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the table written to CSV files, with one row per load, mu0, tau0, sliding rule and direction."""
        from stiction.views.rows import summary_table

        return summary_table(self.summary())

    def figures(self) -> list[str]:
        """Return the names of the figures that `figure` can draw."""
        return [name for name, _ in self._list_drawing_functions()]

    def figure(self, name: str) -> Figure:
        """Draw one of the figures with Matplotlib.

        Parameters
        ----------
        name : str
            One of `figures()`; for measured bodies for example "friction", "compass", "contacts" or "sizes".

        Raises
        ------
        ValueError
            If there is no figure of this name.
        """
        import matplotlib as mpl

        from stiction.views.style import MATPLOTLIB_STYLE

        drawing_functions = dict(self._list_drawing_functions())
        if name not in drawing_functions:
            raise ValueError(f"name must be one of {', '.join(map(repr, drawing_functions))}, got {name!r}")
        with mpl.rc_context(MATPLOTLIB_STYLE):
            figure: Figure = drawing_functions[name]()
        vars(figure)["_repr_png_"] = partial(render_png, figure)  # allows a notebook to show the figure without pyplot
        return figure

    def _list_drawing_functions(self) -> Sequence[tuple[str, Any]]:
        from stiction.views.figures.standard import select_figures

        return list(select_figures(self))

    def save_report(self, path: str | Path) -> Path:
        """Save the interactive HTML report of the result, and return its path."""
        from stiction.views.report import save_report

        save_report(self, Path(path), name=self.path.resolve().name if self.path else "result")
        return Path(path)

    def to_netcdf(self, path: str | Path) -> None:
        """Write the result to a new netCDF file, including all variables, coordinates and attributes."""
        export(self.dataset, path)

    def export(self, path: str | Path) -> None:
        """Write the result to a new file: all numbers for ``.nc``, or a table of values for ``.csv`` and ``.tex``.

        Raises
        ------
        ValueError
            If the file exists or cannot be written, or its name has another ending.
        """
        from stiction.views.files import write_result

        write_result(self, Path(path))

    # ---- Display in a terminal or a notebook -------------------------------------------------------------------------

    def __repr__(self) -> str:
        """Return the text that is shown if the result is printed on a terminal."""
        from stiction.views.text import study_result_text

        try:
            return study_result_text(self.summary()).rstrip()
        except ValueError as error:  # an exception means that there is no contact or no finished member
            return f"no answer: {error}"

    def _repr_html_(self) -> str:
        """Return HTML that contains a figure and the text that is shown on a terminal."""
        figure_names = self.figures()
        figure_name = next((each for each in ("contacts", "friction", *figure_names) if each in figure_names), None)
        return (
            f"<div>{preformatted_html(repr(self))}{figure_html(self.figure(figure_name)) if figure_name else ''}</div>"
        )


def open_result(directory: str | Path) -> Result:
    """Open a finished or unfinished result in a directory that was written by `run`, `pair` or a command.

    Parameters
    ----------
    directory : path

    Returns
    -------
    Result

    Raises
    ------
    ValueError
        If there is no result, or it is damaged.

    Examples
    --------
    >>> import tempfile
    >>> from stiction import Study, open_result, run
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> folder = tempfile.mkdtemp()
    >>> _ = run(Study.named("quick").with_changes(small), store=folder)
    >>> dict(open_result(folder).dataset.sizes)["repetition"]
    2
    """
    return Result(open_stored_result(Path(directory)))
