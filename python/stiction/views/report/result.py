"""Report on a result as an HTML page.

The report contains values, intervals, statuses, assessments and numbers of decimals at nodes of mu0 and tau0. The
scripts decode the numbers, interpolate between nodes and draw.
"""

from __future__ import annotations

from pathlib import Path
from string import Template

import xarray

from stiction._number_format import format_percent, format_with_unit
from stiction.mechanics import friction
from stiction.studies.assessment import STATUS_EXPLANATIONS
from stiction.studies.intervals import CONFIDENCE_LEVEL
from stiction.studies.result import Result
from stiction.views.figures.ensemble import COLOUR_BAR_TICKS
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
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
from stiction.views.report.tables import STORED_FLOAT_BYTES
from stiction.views.style import SLIDING_RULE_LABELS

BETWEEN_NODES_STATUS = "between-nodes"
"""Status of a coefficient that is not interpolated between nodes."""

STATUS_LABELS = {
    friction.STATUS_OK: "", friction.STATUS_NOT_REACHED: "load not reached",
    friction.STATUS_BELOW_RANGE: "below the loads computed", friction.STATUS_NO_CONTACT: "no contact",
    friction.STATUS_NOT_SOLVED: "not solved", friction.STATUS_SELF_LOCKED: "self-locked: no load is supported",
    friction.STATUS_SEIZURE: "seizure: junctions grow without limit",
    BETWEEN_NODES_STATUS: "not resolved between nodes",
}  # fmt: skip
"""Texts for the statuses in the legend of the map; `STATUS_EXPLANATIONS` contains the reasons."""

NOT_INTERPOLATED_REASON = (
    "the coefficient or its interval changes too much between the values of μ0 and τ0 at which the library evaluated it"
)

_ARROW_KEYS_HELP = "arrow keys move {}, plus and minus zoom"
PLOT_PANELS: dict[str, tuple[str, str, dict[str, str]]] = {
    "compass": (
        "Friction by direction", "Friction coefficient in every direction",
        {"kind": "plot square crosshair", "more": "arrow keys change the direction"},
    ),
    "over": ("", "Friction coefficient at the picked load", {"more": _ARROW_KEYS_HELP.format("along it")}),
    **{
        name: (f"{words} against load", f"{words} against normal load", {"more": _ARROW_KEYS_HELP.format("the load")})
        for name, words in (
            ("friction", "Friction coefficient"), ("area", "True contact area"), ("stiffness", "Normal stiffness"),
            ("unloading", "Normal stiffness during unloading (ultrasonic),"),
        )
    },
}  # fmt: skip
"""Title, description and additional HTML attributes of each plot."""

MAIN_PLOTS = {True: ("friction", "compass"), False: ("over", "friction", "area", "stiffness")}
"""Plots that are shown before "More" is opened, for measured bodies (True) and for generated bodies (False)."""


def save_report(
    result: Result | xarray.Dataset, path: str | Path, *, name: str = "", picture: xarray.Dataset | None = None
) -> None:
    """Write the report on a result. An older report with the same name is replaced when the new one is complete.

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
    _report_page_of_result(Result.of(result), name, picture).save(Path(path))


def report_page(result: Result | xarray.Dataset, *, name: str = "", picture: xarray.Dataset | None = None) -> str:
    """Return the report on a result as HTML without external resources.

    `name` is the title; by default it is the name of a built-in study, or the names of the files. `picture` is a result
    of `contact_picture`; by default the picture stored with the result. Raises a `ReportError` if the dataset is not a
    result, is too large for a page, or has no members.
    """
    return _report_page_of_result(Result.of(result), name, picture).html()


def _report_page_of_result(result: Result, name: str, picture: xarray.Dataset | None) -> HtmlPage:
    try:
        study = result.study
    except ValueError as error:
        raise ReportError(str(error)) from None
    content = (
        measured_report_content(result, name, picture)
        if study.is_measured else generated_report_content(result, name)
    )  # fmt: skip
    facts = {
        "percent": f"{100 * CONFIDENCE_LEVEL:g} %", "ticks": COLOUR_BAR_TICKS,
        "ruleDescriptions": SLIDING_RULE_DESCRIPTIONS, "ruleNames": SLIDING_RULE_LABELS,
        "why": {
            name: {"short": short_label, "why": _status_reason(name)} for name, short_label in STATUS_LABELS.items()
        },
        "tau0Sane": 1000 * friction.MAX_SHEAR_STRENGTH_RATIO * float(study.contact.effective_modulus),
        "saneText": format_with_unit(friction.MAX_SHEAR_STRENGTH_RATIO * float(study.contact.effective_modulus), "GPa"),
        "tables": content.packed_arrays.offsets, "leading": STORED_FLOAT_BYTES,
        "errorText": _interpolation_error_text(content.facts.get("error")),
    }  # fmt: skip
    main_plots = MAIN_PLOTS[study.is_measured]
    plot_panels = {
        name: plot_panel_markup(name, title, description, **options)
        for name, (title, description, options) in PLOT_PANELS.items()
    }
    return HtmlPage(
        name=content.name,
        head=content.head,
        body=Template(read_package_file("result.html")).substitute(
            percent=f"{100 * CONFIDENCE_LEVEL:g} %",
            pairs=escape_html(content.pairs_text),
            unfinished=content.incompleteness_notices(),
            touching=content.contact_markup,
            pictures=content.pictures_markup,
            study=content.study_description(),
            panels="".join(plot_panels[name] for name in main_plots),
            others="".join(text for name, text in plot_panels.items() if name not in main_plots),
        ),
        versions=f"Computed by stiction {result.version}",
        scripts=script_markup(facts | content.facts, content.packed_arrays.encoded_texts()),
    )


def _status_reason(status: str) -> str:
    return NOT_INTERPOLATED_REASON if status == BETWEEN_NODES_STATUS else STATUS_EXPLANATIONS.get(status, ("",))[0]


def _interpolation_error_text(error: tuple[float, float] | None) -> str:
    """Return a clause that states the measured interpolation error, or an empty string if there is none."""
    if error is None:
        return ""
    value_error, end_error = (format_percent(item) for item in error)
    return (
        f"at other values that were evaluated, coefficients differ by up to {value_error}, and ends of intervals by "
        f"up to {end_error} of the interval."
    )
