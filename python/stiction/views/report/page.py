"""HTML page in a single file: its frame, and packing of numbers.

`result.py` and `surface.py` say what a page is of. Markup, style and scripts stand beside this file: `nodes.js`
unpacks and interpolates, `plots.js` draws, `common.js` has controls and files, and `result.js` the state
and the words of a result. Every constant that they share with the library is handed to them in the facts. Text of files
is escaped in one place each: markup here by `escaped`, in the scripts because they make text nodes alone.
"""

from __future__ import annotations

import datetime
import html
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path
from string import Template
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from stiction._core import __version__
from stiction._files import replaced_file
from stiction._text import printable
from stiction.studies.nodes import Axis
from stiction.studies.study import Study, differences
from stiction.views.report.tables import Tables

MARK = "<!doctype html>\n<!-- A report of stiction -->\n"  # every report begins so; no other file is written over
_LICENCE = "https://www.gnu.org/licenses/gpl-3.0.txt"
SCRIPTS = ("nodes.js", "plots.js", "common.js", "result.js")


class ReportError(ValueError):
    """Error of a page that cannot be made or written."""


@dataclass(frozen=True)
class Page:
    """Page: title, lines below it, markup of its main part and scripts, and version that computed its result."""

    name: str
    head: list[str]
    body: str
    versions: str
    scripts: str = ""

    def html(self) -> str:
        """Return the complete page."""
        return MARK + Template(part("page.html")).substitute(
            name=escaped(self.name),
            head="".join(f"<p>{escaped(line)}</p>" for line in self.head),
            body=self.body,
            style=part("page.css"),
            scripts=self.scripts,
            licence=html.escape(metadata.distribution("stiction").read_text("licenses/LICENSE") or _LICENCE),
            versions=escaped(f"{self.versions}; page by stiction {__version__}, {datetime.date.today().isoformat()}."),
        )

    def save(self, path: Path) -> None:
        """Write the page in place of an older report; a `ReportError` if something else is there, or it cannot be."""
        with replaced_file(path, MARK.encode(), ReportError) as partial:
            partial.write_bytes(self.html().encode("utf-8", "replace"))


def part(name: str) -> str:
    """Return the text of a file of this package."""
    return (resources.files(__package__) / name).read_text("utf-8")


def scripts(facts: dict[str, Any], numbers: Mapping[str, str]) -> str:
    """Return the markup of the scripts of a result, its facts, and the numbers of `packed`."""
    # No "<", so that nothing in it ends the element or begins another.
    known = json.dumps(facts, allow_nan=False).replace("<", "\\u003c")
    box = '<script type="application/octet-stream" id="packed-{}">{}</script>\n'
    boxes = "".join(box.format(*each) for each in numbers.items())
    text = "\n".join(map(part, SCRIPTS))
    return f'<script type="application/json" id="facts">{known}</script>\n{boxes}<script>\n{text}</script>\n'


MOST_TEXT = 400  # most characters of a line that comes from a file


def escaped(text: object) -> str:
    """Return a text as markup: one line of limited length without control characters."""
    return html.escape(printable(str(text), MOST_TEXT))


def counted(count: int, one: str, many: str | None = None) -> str:
    """Return a number with its noun."""
    return f"{count} {one if count == 1 else many or f'{one}s'}"


def listed(values: ArrayLike) -> Any:
    """Return numbers for JSON, with None for NaN."""
    array = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(array), array, np.asarray(None)).tolist()


def panel(name: str, title: str, seen: str, *, more: str, kind: str = "plot") -> str:
    """Return the markup of a plot: title, description and keys for screen readers, and an empty caption."""
    return (
        f'<section class="panel" aria-labelledby="{name}-title"><h2 id="{name}-title">{title}</h2>'
        f'<div id="{name}" class="{kind}" role="application" tabindex="0" aria-label="{seen}; {more}"></div>'
        f'<p class="caption" id="{name}-caption"></p></section>'
    )


# ---- A result of a page ---------------------------------------------------------------------------------------------


AXES = {
    "fractal_dimension": {"title": "fractal dimension _D_", "name": "D"},
    "cut_off": {"title": "cut-off wavelength (µm)", "name": "cut-off"},
}
"""How the first dimension of cells is called."""


@dataclass(frozen=True, eq=False)
class PageResult:
    """Content of a page: `details` is markup of its study, `touching` and `pictures` that of figures."""

    study: Study
    name: str
    head: list[str]
    pairs: str
    facts: dict[str, Any]
    tables: Tables
    there: int
    details: str = ""
    touching: str = ""
    pictures: str = ""

    def unfinished(self) -> str:
        """Return a notice, as markup, if members are missing."""
        total, said = self.study.ensemble.repetitions, []
        if self.there < total:
            said.append(f"{self.name} is unfinished: {self.there} of {total} repetitions.")
        if (unsolved := self.there - self.facts["repetitions"]) > 0:
            said.append(f"{self.name}: {counted(unsolved, 'repetition')} without a solution at every load left out.")
        return "".join(f'<p class="notice">{escaped(line)}</p>' for line in said)

    def described(self) -> str:
        """Return the study as markup: its differences from the defaults, and all keys."""
        whole = (
            "<details><summary>The whole study file (TOML)</summary>"
            f'<pre tabindex="0">{html.escape(_without_folders(self.study).to_toml())}</pre></details>'
        )
        if self.study.is_measured:
            return f"<h2>The study</h2>{self.details}{whole}"
        changes = [f"{key} = {value}" for key, _, value in differences(Study(), self.study)]
        lines = "".join(f"<li><code>{escaped(line)}</code></li>" for line in changes)
        said = f"<p>The defaults, but</p><ul>{lines}</ul>" if changes else "<p>All values are the defaults.</p>"
        return f"<h2>The study</h2>{said}{whole}"


def _without_folders(study: Study) -> Study:
    """Return a study whose files have no folders, because readers of a page have other folders."""
    if not study.is_measured:
        return study
    bodies: Any = study.surfaces
    sides = {side: getattr(bodies, side) for side in ("upper", "lower")}
    named = {side: each.model_copy(update={"file": Path(each.file).name}) for side, each in sides.items()}
    return study.model_copy(update={"surfaces": bodies.model_copy(update=named)})


def motions_of(study: Study) -> tuple[list[str], list[float]]:
    """Return sliding rules and directions (degrees) of a study, in the order of the sums."""
    return list(study.contact.rules()), [float(angle) for angle in study.contact.degrees()]


def axes_facts(axes: tuple[Axis, Axis], study: Study) -> dict[str, Any]:
    """Return the nodes of mu0 and of tau0 (MPa) as a page has them, with the step of a slider and where it starts."""
    own = study.friction.mu0[0 if study.is_measured else len(study.friction.mu0) // 2], float(study.friction.tau0[0])
    found = {}
    for name, axis, start, unit in zip(("mu0", "tau0"), axes, own, (1.0, 1e3), strict=True):
        most = unit * float(axis.rising[-1])
        found[name] = {
            "rising": (unit * axis.rising).tolist(), "bounds": (unit * np.array(axis.bounds)).reshape(-1, 2).tolist(),
            "most": most, "step": 0.01 if name == "mu0" else float(f"{most / 200:.0e}"),
            "start": float(f"{unit * float(start):.12g}"),
        }  # fmt: skip
    return found
