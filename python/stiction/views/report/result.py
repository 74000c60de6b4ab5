"""Report of a result as an HTML page.

The report contains quantities, intervals, statuses and assessments on a grid of mu0 and tau0, with the number of
decimals to print. The scripts decode the numbers and draw the plots.
"""

from __future__ import annotations

import contextlib
import html
from collections.abc import Callable, Iterator, Mapping
from functools import cache, partial
from pathlib import Path
from string import Template
from typing import TYPE_CHECKING, Any

from stiction.evaluate.intervals import CONFIDENCE_LEVEL
from stiction.solve.executors import evaluate_in_copy
from stiction.summary.evaluation import Evaluation
from stiction.summary.report_data import (
    ReportData,
    ReportDataOfGeneratedSurfaces,
    ReportDataOfMeasuredSurfaces,
    collect_report_data,
    count_coefficients,
    evaluate_generated_values,
    evaluate_measured_values,
)
from stiction.views.report.content import ReportContent
from stiction.views.report.generated import generated_report_content
from stiction.views.report.measured import measured_report_content
from stiction.views.report.page import (
    HtmlPage,
    ReportError,
    escape_html,
    plot_panel_markup,
    read_package_file,
    script_markup,
)
from stiction.views.report.tables import STORED_FLOAT_BYTES, PackedArrays, pack_arrays

if TYPE_CHECKING:
    import xarray

_ARROW_KEYS_HELP = "arrow keys move {}, plus and minus zoom"
PLOT_PANELS: dict[str, tuple[str, str, dict[str, str]]] = {
    "compass": (
        "Friction by direction", "Friction coefficient in every direction",
        {"kind": "plot square crosshair", "more": "arrow keys change the direction"},
    ),
    "over": (
        "Friction coefficient against fractal dimension", "Friction coefficient at the picked load",
        {"more": _ARROW_KEYS_HELP.format("along it")},
    ),
    **{
        name: (f"{words} against load", f"{words} against normal load", {"more": _ARROW_KEYS_HELP.format("the load")})
        for name, words in (
            ("friction", "Friction coefficient"), ("area", "True contact area"), ("stiffness", "Normal stiffness"),
            ("unloading", "Normal stiffness during unloading (ultrasonic),"),
        )
    },
}  # fmt: skip
"""Title, description and further HTML attributes of each plot."""

MAIN_PLOTS = {True: ("friction", "compass"), False: ("over", "friction", "area", "stiffness")}
"""Plots that a page shows while "More" is closed, for measured (True) and for generated surfaces (False)."""


MAX_REPORT_VALUES = {True: 400_000, False: 1_000_000}
"""Maximum number of friction coefficients on a page, for measured (True) and for generated surfaces (False).

The number of coefficients is the product of the numbers of mu0, tau0, loads, cells, sliding rules and directions.
"""


def save_report(
    result: Evaluation | xarray.Dataset, path: str | Path, *, name: str = "", picture: xarray.Dataset | None = None
) -> None:
    """Write the report of a result to a file.

    An older report is replaced as soon as the new report is complete.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
    path : path
    name, picture
        As for `report_page`.

    Raises
    ------
    ReportError
        As for `report_page`; also if the path is a file that is not a report, or cannot be written.
    """
    with evaluate_report(result, name=name, picture=picture) as draw_report, draw_report() as get_page:
        get_page().save(Path(path))


def report_page(result: Evaluation | xarray.Dataset, *, name: str = "", picture: xarray.Dataset | None = None) -> str:
    """Return the report of a result as a single HTML page without external resources.

    `name` is the title; by default it is the name of a built-in study, or the names of the files. `contact_picture`
    returned `picture`; by default it is the picture that is stored with the result. Raises a `ReportError` if the
    dataset is not a result, is too large for a page, or has no members.
    """
    with evaluate_report(result, name=name, picture=picture) as draw_report, draw_report() as get_page:
        return get_page().html()


@contextlib.contextmanager
def evaluate_report(
    result: Evaluation | xarray.Dataset, *, name: str = "", picture: xarray.Dataset | None = None
) -> Iterator[Callable[[], contextlib.AbstractContextManager[Callable[[], HtmlPage]]]]:
    """Evaluate a report in one process, and yield a function that draws its figures in another process.

    The function returns another context, in which a second process draws the figures. This context yields a function
    that waits for both processes and returns the report. It raises the same errors as `report_page`. If Matplotlib is
    not imported yet, open the second context after the import, so that this process imports it while the numbers are
    evaluated.
    """
    result = Evaluation.of(result)
    collect_data_once = cache(partial(_collect_data, result, picture))
    # If the evaluation fails, no error is raised here, because drawing the report raises the same error.
    with contextlib.suppress(ValueError):
        collect_data_once()
    with evaluate_in_copy(partial(_compose_content, result, collect_data_once, name)) as get_content:
        yield partial(_draw_report, collect_data_once, get_content)


_AnyReportData = ReportDataOfMeasuredSurfaces | ReportDataOfGeneratedSurfaces
_ComposedContent = tuple[ReportContent, dict[str, Any], PackedArrays]
"""Content of a page, data for the page scripts, and encoded arrays."""


def _collect_data(result: Evaluation, picture: xarray.Dataset | None) -> _AnyReportData:
    """Collect the data of a report, or raise a `ReportError` if the report cannot be rendered."""
    _check_can_render(result)
    return collect_report_data(result, picture)


@contextlib.contextmanager
def _draw_report(
    get_data: Callable[[], _AnyReportData], get_content: Callable[[], _ComposedContent]
) -> Iterator[Callable[[], HtmlPage]]:
    """Draw a report's figures in a forked process; yield a function that waits for the figures and builds the page."""
    from stiction.views.report.pictures import draw_panels

    with evaluate_in_copy(lambda: draw_panels(get_data())) as get_panel_markup:
        yield lambda: _build_page(get_data(), get_panel_markup(), *get_content())


def _build_page(
    data: _AnyReportData, panel_markup: Mapping[bool, str], content: ReportContent, facts: dict[str, Any],
    packed_arrays: PackedArrays,
) -> HtmlPage:  # fmt: skip
    """Build the HTML page of a report from all its parts: data, panels with figures, texts, scripts and arrays."""
    return _render_page(data, content, panel_markup, script_markup(facts, packed_arrays.texts))


def _compose_content(result: Evaluation, get_data: Callable[[], _AnyReportData], name: str) -> _ComposedContent:
    """Evaluate a result for a report; return the texts of the page, the data for its scripts, and encoded arrays."""
    data = get_data()
    if isinstance(data, ReportDataOfMeasuredSurfaces):
        content = measured_report_content(data, evaluate_measured_values(result), name)
    else:
        content = generated_report_content(data, evaluate_generated_values(result), name)
    packed_arrays = pack_arrays(content.arrays)
    facts = content.facts | {"quantities": [table.to_record() for table in content.quantities]}
    facts |= {"tables": packed_arrays.offsets, "formats": packed_arrays.formats, "leading": STORED_FLOAT_BYTES}
    return content, facts, packed_arrays


def _check_can_render(result: Evaluation) -> None:
    """Raise a `ReportError` if there are too many coefficients, or if no generated pair is solved at all loads."""
    try:
        study = result.study
    except ValueError as error:
        raise ReportError(str(error)) from None
    if not study.is_measured and not (result.members.size and result.num_solved):
        raise ReportError("the result must have at least one member that is solved at every load, got no such member")
    max_count = MAX_REPORT_VALUES[study.is_measured]
    if (count := count_coefficients(result)) > max_count:
        cells = "loads, cutoffs" if study.is_measured else "fractal dimensions, amplitudes"
        raise ReportError(
            f"the result must have at most {max_count} coefficients for a report, got {count}; choose fewer "
            f"{cells} or directions"
        )


def _render_page(
    data: _AnyReportData, content: ReportContent, panel_markup: Mapping[bool, str], scripts: str
) -> HtmlPage:  # fmt: skip
    """Return a report page: the page template, filled with content, panels and scripts."""
    notices_markup = _incompleteness_notices(data, content.name)
    main_plots = MAIN_PLOTS[data.study.is_measured]
    plot_panels = {
        name: plot_panel_markup(name, title, description, **options)
        for name, (title, description, options) in PLOT_PANELS.items()
    }
    body = Template(read_package_file("result.html")).substitute(
        unfinished=notices_markup,
        percent=f"{100 * CONFIDENCE_LEVEL:g} %",
        members=escape_html(content.members_text),
        touching=panel_markup[True],
        pictures=panel_markup[False],
        study=f"<h2>The study</h2>{content.description_markup}{_study_file_markup(data.description.file_text)}",
        panels="".join(plot_panels[name] for name in main_plots),
        others="".join(text for name, text in plot_panels.items() if name not in main_plots),
    )
    return HtmlPage(
        name=content.name,
        head=content.heading_lines,
        body=body,
        versions=f"Computed by stiction {data.version}",
        scripts=scripts,
    )


def _incompleteness_notices(data: ReportData, name: str) -> str:
    """Return notices, as HTML, on surface pairs that are not computed yet or that have no solution.

    Returns "" if all members are solved.
    """
    num_repetitions, notices = data.study.ensemble.repetitions, []
    if data.num_members < num_repetitions:
        notices.append(
            f"{name} is unfinished: {data.num_members} of {data.study.member_names.with_count(num_repetitions)}."
        )
    if (num_unsolved := data.num_members - data.num_solved) > 0:
        count_text = data.study.member_names.with_count(num_unsolved)
        notices.append(f"{name}: {count_text} without a solution at every load left out.")
    return "".join(f'<p class="notice">{escape_html(line)}</p>' for line in notices)


def _study_file_markup(file_text: str) -> str:
    return (
        "<details><summary>The whole study file (TOML)</summary>"
        f'<pre tabindex="0">{html.escape(file_text)}</pre></details>'
    )
