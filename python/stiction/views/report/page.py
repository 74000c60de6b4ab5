"""Template of a self-contained HTML page, and functions that return HTML.

`result.py` and `surface.py` define the content of a page. Markup, style sheet and scripts are in this directory:
`numbers.js` decodes and prints numbers, `plots.js` draws, `common.js` contains controls and file output, and
`result.js` contains the state and the texts of a result. The scripts read constants of the library from the facts.
Texts from files are escaped in the markup by `escape_html`; the scripts insert them only as text nodes.
"""

from __future__ import annotations

import datetime
import html
from collections.abc import Mapping
from dataclasses import dataclass
from importlib import metadata, resources
from pathlib import Path
from string import Template
from typing import Any

from stiction._core import __version__
from stiction._files import replace_file_atomically
from stiction._number_format import to_json
from stiction._text import printable_text
from stiction.views.files import REPORT_FILE_SIGNATURE

_LICENCE_URL = "https://www.gnu.org/licenses/gpl-3.0.txt"
SCRIPT_FILES = ("numbers.js", "plots.js", "common.js", "result.js")


class ReportError(ValueError):
    """Error raised if a report cannot be rendered or written."""


@dataclass(frozen=True)
class HtmlPage:
    """HTML page: its title, subtitle lines, main content, scripts, and the version of stiction."""

    name: str
    head: list[str]
    body: str
    versions: str
    scripts: str = ""

    def html(self) -> str:
        """Return the complete page as HTML."""
        return REPORT_FILE_SIGNATURE + Template(read_package_file("page.html")).substitute(
            name=escape_html(self.name),
            head="".join(f"<p>{escape_html(line)}</p>" for line in self.head),
            body=self.body,
            style=read_package_file("page.css"),
            scripts=self.scripts,
            licence=html.escape(metadata.distribution("stiction").read_text("licenses/LICENSE") or _LICENCE_URL),
            versions=escape_html(
                f"{self.versions}; page by stiction {__version__}, {datetime.date.today().isoformat()}."
            ),
        )

    def save(self, path: Path) -> None:
        """Write the page to a file.

        Raises a `ReportError` if the file exists and is not a report.
        """
        with replace_file_atomically(path, REPORT_FILE_SIGNATURE.encode(), ReportError) as partial:
            partial.write_bytes(self.html().encode("utf-8", "replace"))


def read_package_file(name: str) -> str:
    """Return the text of a file that is part of this Python package."""
    return (resources.files(__package__) / name).read_text("utf-8")


def script_markup(facts: dict[str, Any], packed_arrays: Mapping[str, str]) -> str:
    """Return the HTML script elements of a page: scripts, data (`facts`, as JSON), and encoded number arrays."""
    # Without "<", the JSON text contains no tag that would end the script element.
    facts_json = to_json(facts).replace("<", "\\u003c")
    script_template = '<script type="application/octet-stream" id="packed-{}">{}</script>\n'
    packed_numbers = "".join(script_template.format(*item) for item in packed_arrays.items())
    text = "\n".join(map(read_package_file, SCRIPT_FILES))
    return (
        f'<script type="application/json" id="facts">{facts_json}</script>\n{packed_numbers}<script>\n{text}</script>\n'
    )


MAX_SHOWN_LINE_LENGTH = 400  # characters


def escape_html(text: object) -> str:
    """Convert text to a single line of HTML: escape it, limit its length, and remove control characters."""
    return html.escape(printable_text(str(text), MAX_SHOWN_LINE_LENGTH))


def format_count(count: int, singular: str, plural: str | None = None) -> str:
    """Return a count with its noun, in the singular for 1 and in the plural otherwise."""
    return f"{count} {singular if count == 1 else plural or f'{singular}s'}"


def plot_panel_markup(name: str, title: str, description: str, *, more: str, kind: str = "plot") -> str:
    """Return a plot panel as HTML: title, caption, and a description with keyboard help for screen readers."""
    return (
        f'<section class="panel" aria-labelledby="{name}-title"><h2 id="{name}-title">{title}</h2>'
        f'<div id="{name}" class="{kind}" role="application" tabindex="0" aria-label="{description}; {more}"></div>'
        f'<p class="caption" id="{name}-caption"></p></section>'
    )
