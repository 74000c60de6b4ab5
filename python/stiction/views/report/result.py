"""Report of a result.

It contains what the library evaluated at nodes of mu0 and tau0: values, intervals, statuses, assessments and decimals.
The scripts unpack these, interpolate between nodes and draw.
"""

from __future__ import annotations

from pathlib import Path
from string import Template

import xarray

from stiction._number_format import percent, with_unit
from stiction.mechanics import friction
from stiction.studies.assessment import ADVICE
from stiction.studies.intervals import CONFIDENCE
from stiction.studies.result import Result
from stiction.views.figures.ensemble import COLOUR_BAR_TICKS
from stiction.views.point import RULE_DESCRIPTIONS
from stiction.views.report.generated import page_of_generated
from stiction.views.report.measured import page_of_measured
from stiction.views.report.page import Page, ReportError, escaped, panel, part, scripts
from stiction.views.report.tables import FLOAT_BYTES
from stiction.views.style import RULE_LABELS

BETWEEN = "between-nodes"
"""Status of a coefficient that is not interpolated."""

STATUSES = {
    friction.STATUS_OK: "", friction.STATUS_NOT_REACHED: "load not reached",
    friction.STATUS_BELOW_RANGE: "below the loads computed", friction.STATUS_NO_CONTACT: "no contact",
    friction.STATUS_NOT_SOLVED: "not solved", friction.STATUS_SELF_LOCKED: "self-locked: no load is carried",
    friction.STATUS_SEIZURE: "seizure: junctions grow without limit",
    BETWEEN: "not resolved between nodes",
}  # fmt: skip
"""What the legend of the map says of each status; why it is so, `ADVICE` says."""

BETWEEN_WHY = "the coefficient changes too much between the values of μ0 and τ0 at which the library evaluated it"

_ALONG = "arrow keys move {}, plus and minus look closer"
PANELS: dict[str, tuple[str, str, dict[str, str]]] = {
    "compass": (
        "Friction around the compass", "Friction coefficient in every direction",
        {"kind": "plot square crosshair", "more": "arrow keys turn the direction"},
    ),
    "over": ("", "Friction coefficient at the picked load", {"more": _ALONG.format("along it")}),
    **{
        name: (f"{words} against load", f"{words} against normal load", {"more": _ALONG.format("the load")})
        for name, words in (
            ("friction", "Friction coefficient"), ("area", "True contact area"), ("stiffness", "Normal stiffness"),
            ("unloading", "Normal stiffness, unloading or by ultrasound,"),
        )
    },
}  # fmt: skip
"""Title of each plot, what is seen, and what else its markup has."""

FIRST = {True: ("friction", "compass"), False: ("over", "friction", "area", "stiffness")}
"""Plots of measured and of generated bodies that stand before "More"."""


def save_report(
    result: Result | xarray.Dataset, path: str | Path, *, name: str = "", picture: xarray.Dataset | None = None
) -> None:
    """Write the page of a result; an older report of that name is replaced when the new one is whole.

    Parameters
    ----------
    result : Result, or xarray.Dataset of member sums
    path : path
    name, picture
        As for `report_page`.

    Raises
    ------
    ReportError
        As `report_page`, and if the path holds something that is no report or cannot be written.
    """
    _page(Result.of(result), name, picture).save(Path(path))


def report_page(result: Result | xarray.Dataset, *, name: str = "", picture: xarray.Dataset | None = None) -> str:
    """Return the report of a result as HTML without external resources.

    The name is what it is called on the page; a built-in study, and a pair of files, have names of their own. A picture
    is what `contact_picture` returns, that beside a stored result by default. Raises a `ReportError` if the result is
    none, is too large for a page or has no members.
    """
    return _page(Result.of(result), name, picture).html()


def _page(result: Result, name: str, picture: xarray.Dataset | None) -> Page:

    try:
        study = result.study
    except ValueError as error:
        raise ReportError(str(error)) from None
    made = (
        page_of_measured(result, study, name, picture)
        if study.is_measured else page_of_generated(result, study, name)
    )  # fmt: skip
    facts = {
        "percent": f"{100 * CONFIDENCE:g} %", "ticks": COLOUR_BAR_TICKS,
        "ruleWords": RULE_DESCRIPTIONS, "ruleNames": RULE_LABELS,
        "why": {
            name: {"short": short, "why": BETWEEN_WHY if name == BETWEEN else ADVICE.get(name, ("",))[0]}
            for name, short in STATUSES.items()
        },
        "tau0Sane": 1000 * friction.SHEAR_STRENGTH_LIMIT * float(study.contact.effective_modulus),
        "saneText": with_unit(friction.SHEAR_STRENGTH_LIMIT * float(study.contact.effective_modulus), "GPa"),
        "tables": made.tables.offsets, "leading": FLOAT_BYTES, "errorText": _error_text(made.facts.get("error")),
    }  # fmt: skip
    shown = FIRST[study.is_measured]
    plots = {name: panel(name, title, seen, **more) for name, (title, seen, more) in PANELS.items()}
    return Page(
        name=made.name,
        head=made.head,
        body=Template(part("result.html")).substitute(
            percent=f"{100 * CONFIDENCE:g} %", pairs=escaped(made.pairs), unfinished=made.unfinished(),
            touching=made.touching, pictures=made.pictures, study=made.described(),
            panels="".join(plots[name] for name in shown),
            others="".join(text for name, text in plots.items() if name not in shown),
        ),
        versions=f"Computed by stiction {result.version}",
        scripts=scripts(facts | made.facts, made.tables.packed()),
    )  # fmt: skip


def _error_text(error: tuple[float, float] | None) -> str:
    """Return the error of interpolation that the library measured, in words."""
    if error is None:
        return ""
    values, ends = (percent(each) for each in error)
    return (
        f"at other values that were evaluated, values differ by up to {values}, ends by up to {ends} of the interval."
    )
