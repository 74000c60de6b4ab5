"""The page of a result: what it says, and the numbers that it carries.

Of generated bodies the page has the means over the members and the sums of every member, and `numbers.js` does with
them what `friction_map`, `area_map` and `stiffness_map` do. Of measured bodies it has the sums of every member at every
load, and does what `at_load` does where each member carries the load before sliding. So every mu0 and tau0 is at hand,
with intervals.
"""

from __future__ import annotations

from pathlib import Path
from string import Template

import xarray
from numpy.polynomial.chebyshev import chebinterpolate
from scipy.special import stdtrit

from stiction.mechanics import friction
from stiction.studies.assessment import ADVICE, VERDICTS
from stiction.studies.intervals import AROUND, CONFIDENCE, FEWEST_NEIGHBOURS, FEWEST_OF_SAMPLE
from stiction.studies.result import Result
from stiction.views.figures.ensemble import COLOUR_QUANTILES, TICKS
from stiction.views.point import RULES
from stiction.views.report.generated import page_of_generated
from stiction.views.report.measured import page_of_measured
from stiction.views.report.page import Page, ReportError, escaped, panel, part, scripts

LOAD_STEPS = 80  # loads of a map
STUDENT_DEGREE = 24  # degree from which on quantiles of Student's t are exact to 1e-13

STATUSES = {
    friction.STATUS_OK: "", friction.STATUS_NOT_REACHED: "load not reached",
    friction.STATUS_BELOW_RANGE: "below the loads computed", friction.STATUS_NO_CONTACT: "no contact",
    friction.STATUS_NOT_SOLVED: "not solved", friction.STATUS_SELF_LOCKED: "self-locked: no load is carried",
    friction.STATUS_SEIZURE: "seizure: junctions grow without limit",
}  # fmt: skip
"""What the legend of the map says of each status; why it is so, `ADVICE` says."""

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
    """The page of a result as HTML, which needs nothing else.

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
    modulus = float(study.contact.effective_modulus)
    facts = {
        "confidence": CONFIDENCE, "student": _student(), "fewest": FEWEST_OF_SAMPLE,
        "fewestNeighbours": FEWEST_NEIGHBOURS, "stepsAround": AROUND, "ticks": TICKS,
        "colourQuantiles": COLOUR_QUANTILES, "loadSteps": LOAD_STEPS, "advice": ADVICE, "verdicts": VERDICTS,
        "ruleWords": RULES,
        "statuses": {name: {"short": short, "why": ADVICE.get(name, ("",))[0]} for name, short in STATUSES.items()},
        "mu0": list(study.friction.mu0),
        "tau0": [1000 * float(value) for value in study.friction.tau0],
        "mu0Most": max(1.0, study.friction.mu0[-1]),
        "tau0Most": max(1000 * float(study.friction.tau0[-1]), 20 * modulus),  # MPa
        "tau0Sane": 1000 * friction.SHEAR_STRENGTH_LIMIT * modulus,
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
        scripts=scripts(facts | made.facts, made.numbers),
    )  # fmt: skip


def _student() -> list[float]:
    """Chebyshev coefficients of the upper end of the interval of Student's t over the inverse of its freedom."""
    return chebinterpolate(lambda x: stdtrit(2 / (1 + x), 0.5 + CONFIDENCE / 2), STUDENT_DEGREE).tolist()  # type: ignore[no-any-return]
