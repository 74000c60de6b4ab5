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

MARK = "<!doctype html>\n<!-- A report of stiction -->\n"
"""Every report begins so; no other file is written over."""

SCRIPTS = ("numbers.js", "plots.js", "common.js")
"""Scripts of every page, before its own."""


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


MOST_TEXT = 400
"""Most characters of a line that comes from a file."""


def escaped(text: object) -> str:
    """Text as markup: one line, no control characters, not without end."""
    return html.escape(printable(str(text), MOST_TEXT))


_COMPRESSION = 7
"""A sixth of the time of 9 for half a per cent more bytes."""


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


def _licence() -> str:
    text = metadata.distribution("stiction").read_text("licenses/LICENSE")
    return text or "https://www.gnu.org/licenses/gpl-3.0.txt"
