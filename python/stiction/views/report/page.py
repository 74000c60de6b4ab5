"""One page for a browser, whole in itself: its frame, and how numbers are packed into it.

`result.py` and `surface.py` say what a page is of: facts, words and numbers. Markup, style and scripts stand beside
this file: `numbers.js` computes and knows nothing of a page, `plots.js` draws, `common.js` has controls and files, and
`result.js` and `surface.js` the state and the words of a page. Every constant that they share with the library is
handed to them in the facts. Text that comes from a file is escaped in one place each: markup here by `escaped`, in the
scripts because they make text nodes alone.
"""

from __future__ import annotations

import base64
import datetime
import html
import json
import zlib
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
from stiction.studies.study import Study, differences

MARK = "<!doctype html>\n<!-- A report of stiction -->\n"  # every report begins so; no other file is written over
SCRIPTS = ("numbers.js", "plots.js", "common.js")  # scripts of every page, before its own


class ReportError(ValueError):
    """A page that cannot be made or written."""


@dataclass(frozen=True)
class Page:
    """What a page is of.

    Attributes
    ----------
    name : str
        Title and heading.
    head : list of str
        Lines under the heading.
    words : dict
        Of its markup, as HTML.
    facts : dict
        What its script knows.
    numbers : dict
        Packed by `packed` or `deflated`, by name.
    versions : str
        Of what computed the result.
    kind : {"result", "surface"}
        Whose markup and script it has.
    """

    name: str
    head: list[str]
    words: Mapping[str, str]
    facts: dict[str, Any]
    numbers: Mapping[str, str]
    versions: str
    kind: str = "result"

    def html(self) -> str:
        """The whole page."""
        folder = resources.files(__package__)

        def part(name: str) -> str:
            return (folder / name).read_text("utf-8")

        numbers = "\n".join(
            f'<script type="application/octet-stream" id="packed-{name}">{text}</script>'
            for name, text in {**self.numbers, "licence": deflated(_licence().encode())}.items()
        )
        return MARK + Template(part("page.html")).substitute(
            name=escaped(self.name),
            head="".join(f"<p>{escaped(line)}</p>" for line in self.head),
            body=Template(part(f"{self.kind}.html")).substitute(self.words),
            style=part("page.css"),
            script="\n".join(part(name) for name in (*SCRIPTS, f"{self.kind}.js")),
            # No "<", so that nothing in it ends the element or begins another.
            facts=json.dumps(self.facts, allow_nan=False).replace("<", "\\u003c"),
            packed=numbers,
            versions=escaped(f"{self.versions}; page by stiction {__version__}, {datetime.date.today().isoformat()}."),
        )

    def save(self, path: Path) -> None:
        """Write the page; an older report of that name is replaced when the new one is whole.

        Raises
        ------
        ReportError
            If the path holds something that is no report or cannot be written.
        """
        with replaced_file(path, MARK.encode(), ReportError) as partial:
            partial.write_bytes(self.html().encode("utf-8", "replace"))


MOST_TEXT = 400  # most characters of a line that comes from a file


def escaped(text: object) -> str:
    """Text as markup: one line, no control characters, not without end."""
    return html.escape(printable(str(text), MOST_TEXT))


CLOSER = "plus and minus look closer, 0 shows all"
_COMPRESSION = 7  # a sixth of the time of 9 for half a per cent more bytes


def packed(values: ArrayLike, leading: int) -> str:
    """Doubles as text, rounded to some of their leading bytes: all first bytes, then all second ones, and so on.

    Bytes of the same place are alike, signs and exponents most, so this order takes the least room.
    """
    bits = np.ascontiguousarray(values, np.float64).ravel().view(np.uint64)
    dropped = 8 * (8 - leading)
    if dropped:
        bits = bits + np.uint64(1 << (dropped - 1))
    planes = bits.astype(">u8").view(np.uint8).reshape(-1, 8)[:, :leading].T
    return deflated(planes.tobytes())


def deflated(content: bytes) -> str:
    """Bytes as text, compressed."""
    return base64.b64encode(zlib.compress(content, _COMPRESSION)).decode("ascii")


def counted(count: int, one: str, many: str | None = None) -> str:
    """A number of things."""
    return f"{count} {one if count == 1 else many or f'{one}s'}"


def listed(values: ArrayLike) -> Any:
    """Numbers for JSON, which has no NaN."""
    array = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(array), array, np.asarray(None)).tolist()


def panel(
    name: str, title: str, seen: str = "", *, more: str = CLOSER, kind: str = "plot", above: str = "", below: str = ""
) -> str:
    """Markup of a plot with its title, what is seen and what keys do for screen readers, and what is around it."""
    return (
        f'<section class="panel" aria-labelledby="{name}-title"><h2 id="{name}-title">{title}</h2>{above}'
        f'<div id="{name}" class="{kind}" role="application" tabindex="0" aria-label="{seen or title}; {more}"></div>'
        f"{below}</section>"
    )


def _licence() -> str:
    text = metadata.distribution("stiction").read_text("licenses/LICENSE")
    return text or "https://www.gnu.org/licenses/gpl-3.0.txt"


# ---- A result of a page ---------------------------------------------------------------------------------------------


BYTES = {"means": 8, "sums": 5}  # leading bytes of a double that are kept: all of them, and 2e-9 of a sum

CELLS = {
    "fractal_dimension": {"title": "fractal dimension _D_", "name": "D", "unit": "", "factor": 1.0},
    "cut_off": {"title": "cut-off wavelength (µm)", "name": "cut-off", "unit": "µm", "factor": 1.0},
}
"""How the first dimension of cells is called."""


@dataclass(frozen=True, eq=False)
class PageResult:
    """One result of a page: its study, what it is called, what the page says and knows of it, and its numbers.

    `details` and `pictures` are markup, of the study and of figures that do not move.
    """

    study: Study
    name: str
    head: list[str]
    pairs: str
    facts: dict[str, Any]
    numbers: dict[str, str]
    version: str
    there: int
    details: str = ""
    pictures: str = ""

    def unfinished(self) -> str:
        """A notice, as markup, where members are missing."""
        total, said = self.study.ensemble.repetitions, []
        if self.there < total:
            said.append(f"{self.name} is unfinished: {self.there} of {total} repetitions.")
        if (unsolved := self.there - self.facts["repetitions"]) > 0:
            said.append(f"{self.name}: {counted(unsolved, 'repetition')} without a solution at every load left out.")
        return "".join(f'<p class="notice">{escaped(line)}</p>' for line in said)

    def described(self, several: bool) -> str:
        """The study as differences from the defaults, and whole, as markup."""
        of = f" {escaped(self.name)}" if several else ""
        whole = (
            "<details><summary>The whole study file (TOML)</summary>"
            f'<pre tabindex="0">{html.escape(_without_folders(self.study).to_toml())}</pre></details>'
        )
        if self.study.is_measured:
            return f"<h2>The study{of}</h2>{self.details}{whole}"
        changes = [f"{key} = {value}" for key, _, value in differences(Study(), self.study)]
        lines = "".join(f"<li><code>{escaped(line)}</code></li>" for line in changes)
        said = f"<p>The defaults, but</p><ul>{lines}</ul>" if changes else "<p>All values are the defaults.</p>"
        return f"<h2>The study{of}</h2>{said}{whole}"


def _without_folders(study: Study) -> Study:
    """A study that names its files alone: whoever is sent a page has other folders."""
    if not study.is_measured:
        return study
    bodies: Any = study.surfaces
    named = {side: getattr(bodies, side) for side in ("upper", "lower")}
    named = {side: each.model_copy(update={"file": Path(each.file).name}) for side, each in named.items()}
    return study.model_copy(update={"surfaces": bodies.model_copy(update=named)})


def motions_of(study: Study) -> tuple[list[str], list[float]]:
    """Sliding rules and directions (degrees) of a study, in the order of the sums."""
    return list(study.contact.rules()), [float(angle) for angle in study.contact.degrees()]


def way(angle: float) -> str:
    """Where the upper body moves to."""
    axes = {0.0: "+x", 90.0: "+y", 180.0: "\N{MINUS SIGN}x", 270.0: "\N{MINUS SIGN}y"}
    return axes.get(angle, f"{angle:g}° from +x")
