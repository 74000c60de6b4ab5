"""The page of a result, or of two of a kind side by side: what it says, and the numbers that it carries.

Of generated bodies the page has the means over the members and the sums of every member, and `numbers.js` does with
them what `friction_map`, `area_map` and `stiffness_map` do. Of measured bodies it has the sums of every member at every
load, and does what `at_load` does where each member carries the load before sliding. So every mu0 and tau0 is at hand,
with intervals.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction.mechanics import friction
from stiction.studies.intervals import AROUND, CONFIDENCE, FEWEST_NEIGHBOURS, FEWEST_OF_SAMPLE
from stiction.studies.store import Stored
from stiction.studies.study import study_of
from stiction.views.doubts import ADVICE, VERDICTS
from stiction.views.figures.ensemble import COLOUR_QUANTILES, TICKS
from stiction.views.point import RULES
from stiction.views.report.generated import page_of_generated
from stiction.views.report.measured import CONTACT_BYTES, page_of_measured
from stiction.views.report.page import BYTES, Page, PageResult, ReportError, escaped, panel

if TYPE_CHECKING:
    import xarray

    Results = xarray.Dataset | Stored | Sequence[xarray.Dataset | Stored]

MOST_RESULTS = 2  # on one page
LOAD_STEPS = 80  # loads of a map

STATUSES = {
    friction.STATUS_OK: "", friction.STATUS_NOT_REACHED: "load not reached",
    friction.STATUS_BELOW_RANGE: "below the loads computed", friction.STATUS_NO_CONTACT: "no contact",
    friction.STATUS_NOT_SOLVED: "not solved", friction.STATUS_SELF_LOCKED: "self-locked: no load is carried",
}  # fmt: skip
"""What the legend of the map says of each status; why it is so, `ADVICE` says."""

_ALONG = "arrow keys move {}, plus and minus look closer"
_SPECTRA = (
    '<p class="caption">Density of the squared height over waves of all directions, after a Hann window, of the pieces '
    "that are shown above.</p>"
)

PANELS: dict[str, tuple[str, str, dict[str, str]]] = {
    "contacts": ("Where they touch", "The two bodies with their true contacts", {}),
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
    "positions": ("Single positions", "Friction coefficient of each pair", {}),
    "spectra": ("Spectra", "Power spectra of both bodies over wave number", {"below": _SPECTRA}),
}  # fmt: skip
"""Title of each plot, what is seen, and what else its markup has."""

FIRST = {True: ("friction", "compass"), False: ("over", "friction", "area", "stiffness")}
"""Plots of measured and of generated bodies that stand before "More"."""


def save_report(
    result: Results, path: str | Path, *, names: Sequence[str] = (), picture: xarray.Dataset | None = None
) -> None:
    """Write the page of a result; an older report of that name is replaced when the new one is whole.

    Parameters
    ----------
    result : xarray.Dataset or Stored, or two of them
        As for `report_page`.
    path : path
    names, picture
        As for `report_page`.

    Raises
    ------
    ReportError
        As `report_page`, and if the path holds something that is no report or cannot be written.
    """
    _report(result, names, picture).save(Path(path))


def report_page(result: Results, *, names: Sequence[str] = (), picture: xarray.Dataset | None = None) -> str:
    """The page of a result, or of two side by side, as HTML, which needs nothing else.

    Both are of generated or both of measured bodies. The names are what each is called on the page; a built-in study,
    and a pair of files, have names of their own. A single result has a picture as `contact_picture` returns it, that
    beside a stored result by default. Raises a `ReportError` if there are more than two, they are not of a kind, one is
    too large for a page or has no members, or one of its numbers is not what a page can show.
    """
    return _report(result, names, picture).html()


def _report(result: Results, names: Sequence[str], picture: xarray.Dataset | None) -> Page:
    import xarray

    results: list[Any] = list(result) if isinstance(result, (list, tuple)) else [result]
    for each in results:
        if not isinstance(each, (xarray.Dataset, Stored)):
            raise ReportError(f"result must be a Dataset, a stored result or a list of them, got {type(each).__name__}")
    if not 1 <= len(results) <= MOST_RESULTS:
        raise ReportError(f"a page is of one result or two, got {len(results)}")
    named = [*names, *[""] * len(results)][: len(results)]
    try:
        studies = [each.study if isinstance(each, Stored) else study_of(each) for each in results]
    except ValueError as error:
        raise ReportError(str(error)) from None
    if len({study.is_measured for study in studies}) > 1:
        raise ReportError("two results side by side are both of generated or both of measured bodies")
    alone = len(results) == 1
    made = [
        page_of_measured(each, study, name, picture if alone else None, with_picture=alone)
        if study.is_measured else page_of_generated(each, study, name)
        for each, study, name in zip(results, studies, named, strict=True)
    ]  # fmt: skip
    return _page(made)


def _page(results: list[PageResult]) -> Page:
    studies = [result.study for result in results]
    modulus = [float(study.contact.effective_modulus) for study in studies]
    facts = {
        "confidence": CONFIDENCE,
        "fewest": FEWEST_OF_SAMPLE,
        "fewestNeighbours": FEWEST_NEIGHBOURS,
        "stepsAround": AROUND,
        "statuses": {name: {"short": short, "why": ADVICE.get(name, ("",))[0]} for name, short in STATUSES.items()},
        "bytes": BYTES,
        "pictureBytes": CONTACT_BYTES,
        "ticks": TICKS,
        "colourQuantiles": COLOUR_QUANTILES,
        "loadSteps": LOAD_STEPS,
        "advice": ADVICE,
        "verdicts": VERDICTS,
        "mu0": list(studies[0].friction.mu0),
        "tau0": [1000 * float(value) for value in studies[0].friction.tau0],
        "mu0Most": max(1.0, *(study.friction.mu0[-1] for study in studies)),
        "tau0Most": max(
            max(1000 * float(study.friction.tau0[-1]), 20 * own) for study, own in zip(studies, modulus, strict=True)
        ),  # MPa
        "tau0Sane": 1000 * friction.SHEAR_STRENGTH_LIMIT * min(modulus),
        "ruleWords": RULES,
        "results": [result.facts for result in results],
    }
    several, shown = len(results) > 1, FIRST[studies[0].is_measured]
    return Page(
        name=" and ".join(result.name for result in results),
        head=[f"{f'{result.name}: ' if several else ''}{line}" for result in results for line in result.head],
        words={
            "percent": f"{100 * CONFIDENCE:g} %",
            "pairs": escaped(" and ".join(result.pairs for result in results)),
            "unfinished": "".join(result.unfinished() for result in results),
            "touching": _panels("contacts"),
            "panels": _panels(*shown),
            "others": _panels(*(name for name in PANELS if name not in (*shown, "contacts"))),
            "pictures": "".join(result.pictures for result in results),
            "studies": "".join(result.described(several) for result in results),
        },
        facts=facts,
        numbers={f"{name}-{r}": text for r, result in enumerate(results) for name, text in result.numbers.items()},
        versions=f"Computed by stiction {', '.join(sorted({result.version for result in results}))}",
    )


def _panels(*names: str) -> str:
    """Markup of plots."""
    return "".join(
        panel(name, title, seen, **({"below": _caption(name)} | more))
        for name, (title, seen, more) in ((name, PANELS[name]) for name in names)
    )


def _caption(name: str) -> str:
    live = ' aria-live="polite"' if name == "contacts" else ""
    return f'<p class="caption" id="{name}-caption"{live}></p>'
