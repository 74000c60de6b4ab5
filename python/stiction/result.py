"""`Result`: friction and other quantities of a study as numbers, tables, figures and reports."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction._checks import check_bool, parse_path
from stiction._errors import ArgumentError
from stiction._repr import figure_html, preformatted_html, render_png
from stiction._units import short_repr
from stiction.solve.store import open_stored_result
from stiction.summary.evaluation import Evaluation
from stiction.summary.joint_table import DEFAULT_JOINT_UNITS, UnitSystem
from stiction.views.files import is_card, write_joint_table, write_result, write_table_at
from stiction.views.report import save_report
from stiction.views.rows import summary_table
from stiction.views.sentence import quotable_sentences
from stiction.views.style import MATPLOTLIB_STYLE
from stiction.views.text import study_result_text

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure
    from numpy.typing import ArrayLike


class Result(Evaluation):
    """Result of a study of generated or measured surfaces, as returned by `run`, `pair` and `open_result`.

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

    @property
    def sentence(self) -> str:
        """Sentences to quote, one line per load, with all conditions under which the coefficient holds.

        If a coefficient must not be quoted, the line contains the reason. If there are several mu0 or tau0, each
        combination has a line. For generated surfaces, only the first combination of D, amplitude, mu0 and tau0 has
        lines.
        """
        return "\n".join(quotable_sentences(self.summary()))

    # ---- Tables, figures and reports ---------------------------------------------------------------------------------

    def to_dataframe(self) -> pandas.DataFrame:
        """Return coefficients and other quantities as a table with the rows and columns of the CSV file.

        There is one row per load, mu0, tau0, sliding rule and motion (all directions, an axis or a direction).
        """
        return summary_table(self.complete_summary())

    def figures(self) -> list[str]:
        """Return the names of all figures that the method `figure` can draw for this result."""
        return [name for name, _ in self._list_drawing_functions()]

    def figure(self, name: str) -> Figure:
        """Draw a figure of the result with Matplotlib.

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

        drawing_functions = dict(self._list_drawing_functions())
        if not isinstance(name, str) or name not in drawing_functions:
            raise ValueError(f"name must be one of {', '.join(map(repr, drawing_functions))}, got {short_repr(name)}")
        with mpl.rc_context(MATPLOTLIB_STYLE):
            figure: Figure = drawing_functions[name]()
        # This method makes a notebook show the figure without pyplot.
        vars(figure)["_repr_png_"] = partial(render_png, figure)
        return figure

    def _list_drawing_functions(self) -> Sequence[tuple[str, Any]]:
        # The module of `select_figures` imports Matplotlib, so it is imported only here.
        from stiction.views.figures.standard import select_figures

        return list(select_figures(self))

    def save_report(self, path: str | Path) -> Path:
        """Save the interactive HTML report of the result, and return its path."""
        path = parse_path("path", path)
        save_report(self, path, name=self.path.resolve().name if self.path else "result")
        return path

    def export(
        self, path: str | Path, *, load: str | ArrayLike | None = None, mu0: ArrayLike | None = None,
        tau0: str | ArrayLike | None = None, joint: bool = False, units: UnitSystem | None = None,
        closure_from: str | float | None = None,
    ) -> None:  # fmt: skip
        """Write the result to a new file: the whole result for ``.nc``, or a table for ``.csv`` and ``.tex``.

        Parameters
        ----------
        path : path
        load : str or array_like of float, mN, optional
            Loads of the table, as for `at`; by default the loads of the study, or of `joint_table`. For a card, the
            single load of the coefficient and stiffnesses that the card contains once; by default the load of the
            study.
        mu0 : str or array_like of float, optional
        tau0 : str or array_like of float, GPa, optional
            By default the values of the study. A card needs a single mu0 and a single tau0.
        joint : bool
            True to write the table of `joint_table` for each mu0 and tau0 to a ``.csv`` or ``.json`` file. Cards of
            other programs contain one table in any case: ``.inp`` of Abaqus and CalculiX, ``.mac`` of Ansys and
            ``.liggghts``.
        units : {"mm,N,MPa", "m,N,Pa", "um,mN,GPa"}, optional
            Units of joint tables and cards; by default the first.
        closure_from : str or float, mN, optional
            Load from which joint tables and cards count the closure, "0.1 MPa". By default, they count from first
            contact, which is a single point; in a model of the joint, use a small pressure.

        Raises
        ------
        ValueError
            If the file exists or cannot be written, if its name has another ending, or if there are several loads, mu0
            or tau0 for a card.
        """
        path = parse_path("path", path)
        check_bool("joint", joint)
        if joint or is_card(path):
            chosen_units = DEFAULT_JOINT_UNITS if units is None else units
            write_joint_table(
                self, path, chosen_units, load=load, mu0=mu0, tau0=tau0, closure_from=closure_from
            )  # fmt: skip
            return
        for name, value in (("units", units), ("closure_from", closure_from)):
            if value is not None:
                raise ArgumentError(f"{{{name}}} applies only to joint tables and cards, got {{value}}", value=value)
        if load is None and mu0 is None and tau0 is None:
            write_result(self, path)
        else:
            write_table_at(self, path, load=load, mu0=mu0, tau0=tau0)

    # ---- Display in a terminal or a notebook -------------------------------------------------------------------------

    def __repr__(self) -> str:
        """Return the text of the result that a terminal shows."""
        try:
            return study_result_text(self.summary()).rstrip()
        except ValueError as error:
            # There is no coefficient if the surfaces do not touch, or if no member is finished.
            return f"no coefficient: {error}"

    def _repr_html_(self) -> str:
        """Return a figure and the text of the result as HTML."""
        figure_names = self.figures()
        figure_name = next((name for name in ("contacts", "friction", *figure_names) if name in figure_names), None)
        return (
            f"<div>{preformatted_html(repr(self))}{figure_html(self.figure(figure_name)) if figure_name else ''}</div>"
        )


def open_result(directory: str | Path) -> Result:
    """Open a finished or unfinished result that `run`, `pair` or a command wrote to a directory.

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
    >>> directory = tempfile.mkdtemp()
    >>> _ = run(Study.named("quick").with_changes(small), store=directory)
    >>> dict(open_result(directory).dataset.sizes)["repetition"]
    2
    """
    return Result(open_stored_result(parse_path("directory", directory)))
