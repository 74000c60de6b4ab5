"""A result as an object for notebooks: the answer, its table, its figures and its page, from one folder or dataset."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import ArrayLike

from stiction._checks import check_bool
from stiction._repr import figure_html, preformatted_html, render_png
from stiction._units import loads_to_core_units, to_core_units
from stiction.studies.at_load import at_load
from stiction.studies.budget import with_uncertainty
from stiction.studies.maps import study_of_result
from stiction.studies.study import Study
from stiction.views import answer, rows, text
from stiction.views.asked import asked_loads, at_asked_loads, over_and_onset
from stiction.views.digits import quoted
from stiction.views.point import RULES

if TYPE_CHECKING:
    import pandas
    import xarray
    from matplotlib.figure import Figure

    from stiction.studies.store import Stored
    from stiction.views.answer import Answer, Doubt

FIRST_MEMBERS = 4  # whose mean is the first answer


@dataclass(frozen=True, eq=False)
class Result:
    """What a study says, generated or measured: `pair` and `read_result` return it, and notebooks show it.

    Attributes
    ----------
    source : xarray.Dataset or Stored
        What `run` returned, or the folder that it wrote.
    beside : tuple of Doubt
        What is doubtful of the bodies themselves, whatever the load.

    Examples
    --------
    >>> from stiction import Result, Study, run
    >>> result = Result(run(Study.named("quick").with_changes({"ensemble.repetitions": 2, "surfaces.points": 3000})))
    >>> sorted(result.dataset.sizes)
    ['amplitude', 'approach', 'fractal_dimension', 'repetition']
    """

    source: xarray.Dataset | Stored
    beside: tuple[Doubt, ...] = ()

    @cached_property
    def study(self) -> Study:
        """The study that it is of."""
        return study_of_result(self.source)

    @property
    def path(self) -> Path | None:
        """The folder that it lies in, if any."""
        return getattr(self.source, "path", None)

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """Every sum of every member, in memory."""
        from stiction.studies.store import Stored

        return self.source.dataset() if isinstance(self.source, Stored) else self.source

    # ---- The answer --------------------------------------------------------------------------------------------------

    @cached_property
    def answers(self) -> list[Answer]:
        """What may be quoted at each load, mu0 and tau0 that the study asks for."""
        return answer.answers(self._asked, self.study, beside=self.beside)

    @property
    def _first(self) -> Answer:
        return answer.headlines(self.answers)[0]

    @property
    def value(self) -> float:
        """The coefficient of static friction to quote first; NaN where there is none."""
        return self._first.value

    @property
    def interval(self) -> tuple[float, float]:
        """The ends of its 95 % interval, of everything that is known: inputs, positions and finer waves."""
        return self._first.lower, self._first.upper

    @property
    def of_positions(self) -> tuple[float, float]:
        """The ends of the 95 % interval of the mean over positions alone, at the middle of all inputs."""
        return self._first.rules[0].positions

    @property
    def next_test(self) -> tuple[float, float]:
        """Between which ends one more test lies with 95 %, in one direction, at one position."""
        return self._first.rules[0].next_test

    @property
    def budget(self) -> pandas.DataFrame:
        """What would be left of the interval if an input were known: a row each, the most important first.

        Columns input, lower, upper, width (the mean over what the input may be) and share (of the width that goes).
        """
        import pandas

        one = self._first
        whole = one.upper - one.lower
        rows = [(left.words, left.lower, left.upper, left.width, 1 - left.width / whole) for left in one.budget]
        return pandas.DataFrame(rows, columns=["input", "lower", "upper", "width", "share"])

    @property
    def verdict(self) -> str:
        """One of "Quote it", "Quote with care" and "Do not quote"."""
        return self._first.verdict

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """Why it is to be quoted with care or not at all, and what to do about it."""
        return self._first.doubts

    @property
    def sentence(self) -> str:
        """The answer in one sentence, with everything that it depends on."""
        return self._first.sentence

    @cached_property
    def _asked(self) -> xarray.Dataset:
        return at_asked_loads(self.source)

    def at(
        self, load: str | ArrayLike | None = None, *, mu0: ArrayLike | None = None, tau0: str | ArrayLike | None = None,
        reading: Any = None, height_scale: str | ArrayLike | None = None,
        scaled: Literal["both", "upper", "lower"] = "both", compute: bool = False,
    ) -> xarray.Dataset:  # fmt: skip
        """Return what `at_load` gives at other loads and materials; nothing is computed again.

        Of measured bodies at elastic loads, `friction_combined` has the combined 95 % interval, and other coefficients
        have the sampling interval of the mean over positions.

        With `height_scale` it is friction, true area and stiffness over factors of the heights, as another finish would
        change them. Each factor that is not stored alongside the result, or between others that are, is one more
        solution of the pair, which `compute` allows.

        Parameters
        ----------
        load : str or array_like of float, mN, optional
            Such as "10 mN", or of measured bodies "10 MPa" on the nominal area; those of the study by default.
        mu0 : array_like of float, optional
        tau0 : str or array_like of float, GPa, optional
            Such as "50 MPa".
        reading : {"mean", "elastic", "normal"}, optional
            Which load is meant.
        height_scale : float, array_like or str, optional
            Factors of the heights from 0.01 to 100, such as 0.5, "0.5,1,2" or "0.25..4".
        scaled : {"both", "upper", "lower"}
            Surfaces whose heights are scaled.
        compute : bool
            Whether factors that are missing are computed.

        Raises
        ------
        ValueError
            If an argument is outside its range, or a factor of the heights is not computed: the error names the time
            that it takes.

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
        if height_scale is not None:
            return self._at_height_scale(height_scale, load, mu0, tau0, reading, scaled, compute)
        loads = asked_loads(self.source) if load is None else self._loads_of(load)
        strengths = to_core_units("tau0", tau0, "pressure")
        at = at_load(self.source, loads, mu0=mu0, tau0=strengths, reading=reading)
        return with_uncertainty(at, self.source, budget=False)

    def _at_height_scale(
        self, factors: Any, load: Any, mu0: Any, tau0: Any, reading: Any, scaled: Any, compute: bool
    ) -> xarray.Dataset:
        from stiction.studies.height_scale import at_height_scale, checked_factors, compute_factors
        from stiction.studies.store import Stored

        check_bool("compute", compute)
        if reading not in (None, "elastic"):
            raise ValueError(f"reading must be 'elastic' with height_scale, got {reading!r}")
        if not isinstance(self.source, Stored):
            raise ValueError("height_scale needs a stored result: one of `pair`, or of `read_result`")
        factors = checked_factors(factors)
        loads = asked_loads(self.source) if load is None else self._loads_of(load)
        strengths = to_core_units("tau0", tau0, "pressure")
        if compute:
            compute_factors(self.source, factors, scaled)
        return at_height_scale(self.source, factors, loads, mu0=mu0, tau0=strengths, scaled=scaled)

    @property
    def nominal_area(self) -> float | None:
        """What is pressed of each member of measured bodies, µm²; None of generated ones."""
        return float(self.dataset["nominal_area"]) if self.study.is_measured else None

    def _loads_of(self, load: Any) -> Any:
        """Loads in mN; of measured bodies text may be a pressure on the nominal area."""
        area = self.nominal_area
        return to_core_units("load", load, "force") if area is None else loads_to_core_units("load", load, area)

    def table(self) -> pandas.DataFrame:
        """What the CSV file holds: a row for each load, mu0, tau0, rule and motion, with intervals and doubts."""
        return rows.table_of(self._asked, self.study, beside=self.beside)

    def contacts(
        self, load: str | ArrayLike | None = None, *, members: int | Sequence[int] | None = None
    ) -> pandas.DataFrame:
        """Every contact of a typical member, or of those that are named: a row for each. They are solved once more.

        Parameters
        ----------
        load : str or array_like of float, mN, optional
            Elastic normal loads, as for `at`; the first one of the study by default.
        members : int or sequence of int, optional
            By default, at each load, the one whose true area is nearest to the median.

        Returns
        -------
        pandas.DataFrame
            member, the cell (fractal_dimension and amplitude_um of generated bodies, cut_off_um of measured ones) and
            load_mN; of the contact its middle x_um and y_um, force_mN (normal load), area_um2 (on the ground plan),
            mean_pressure_GPa, its mean slopes slope_x and slope_y, and whether it is at_edge of the grid. y and its
            slope are 0 of profiles.

        Raises
        ------
        ValueError
            If there is no such member, nothing touches, or the files of the study are not there any more.
        """
        from stiction.studies.contact_picture import contact_frame

        loads = asked_loads(self.source)[:1] if load is None else self._loads_of(load)
        return contact_frame(self.source, loads, members)

    # ---- Pictures ----------------------------------------------------------------------------------------------------

    def figures(self) -> list[str]:
        """Names that `figure` takes."""
        return [name for name, _ in self._drawings()]

    def figure(self, name: str) -> Figure:
        """One of the figures, as matplotlib draws it.

        Parameters
        ----------
        name : str
            One of `figures()`: of measured bodies such as "friction", "compass", "contacts", "positions", "sizes".

        Raises
        ------
        ValueError
            If there is none of that name.
        """
        import matplotlib as mpl

        from stiction.views.style import STYLE

        drawings = dict(self._drawings())
        if name not in drawings:
            raise ValueError(f"name must be one of {', '.join(map(repr, drawings))}, got {name!r}")
        with mpl.rc_context(STYLE):
            figure: Figure = drawings[name]()
        vars(figure)["_repr_png_"] = partial(render_png, figure)  # so that a notebook shows it without pyplot
        return figure

    def _drawings(self) -> Sequence[tuple[str, Any]]:
        from stiction.views.figures.standard import figures_of, picture_of

        return list(figures_of(self.source, picture_of(self.source)))

    def report(self, path: str | Path) -> Path:
        """Write the interactive page of the result, which needs nothing but a browser, and return its path."""
        from stiction.views.report import save_report

        save_report(self.source, Path(path), name=self.path.resolve().name if self.path else "result")
        return Path(path)

    # ---- How it shows itself -----------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        """Show what the terminal shows."""
        try:
            return self._text().rstrip()
        except ValueError as error:  # nothing touches, or nothing is finished
            return f"no answer: {error}"

    def _text(self) -> str:
        if self.study.is_measured:
            return text.result_text(self._asked, self.study, beside=self.beside, **over_and_onset(self.source))
        return text.overview_text(self._asked, self.study)

    def _repr_html_(self) -> str:
        """Show the answer as the terminal does, with a picture."""
        names = self.figures()
        name = next((each for each in ("contacts", "friction", *names) if each in names), None)
        return f"<div>{preformatted_html(repr(self))}{figure_html(self.figure(name)) if name else ''}</div>"


def read_result(directory: str | Path) -> Result:
    """Read what `run`, `pair` or the command wrote into a directory, or what is finished of it.

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
    >>> from stiction import Study, read_result, run
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> folder = tempfile.mkdtemp()
    >>> _ = run(Study.named("quick").with_changes(small), store=folder)
    >>> dict(read_result(folder).dataset.sizes)["repetition"]
    2
    """
    from stiction.studies.store import open_stored
    from stiction.views.inputs import doubts_of_study

    stored = open_stored(Path(directory))
    return Result(stored, doubts_of_study(stored.study))


def first_result(study: Study) -> Result:
    """What the first members of a study of asperities give, in memory; a `ValueError` if they cannot be pressed.

    It is there within a second, while the half-space is being solved.
    """
    from stiction.studies.members import about
    from stiction.studies.pressed import member_sums
    from stiction.studies.result import dataset_of, stacked

    members = range(min(FIRST_MEMBERS, study.ensemble.repetitions))
    arrays = stacked(study, [member_sums(study, member) for member in members])
    return Result(dataset_of(study, members, arrays, about(study)))


def first_text(study: Study) -> str:
    """The answer that the first members of a study of asperities give, in a line; an error if nothing touches."""
    one = first_result(study).answers[0]
    return f"at first, by asperities: μ_s = {quoted(one.value)} {RULES[one.rules[0].rule]}"
