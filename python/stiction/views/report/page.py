"""Template of a self-contained HTML page, and the encoding of the numbers on the page.

`result.py` and `surface.py` define the content of a page. Markup, style sheet and scripts are in this directory:
`nodes.js` decodes and interpolates numbers, `plots.js` draws, `common.js` contains controls and file output, and
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

import numpy as np

from stiction._core import __version__
from stiction._files import replace_file_atomically
from stiction._number_format import to_json
from stiction._text import printable_text
from stiction.studies.nodes import NodeAxis
from stiction.studies.study import Study, find_table_differences
from stiction.views.report.tables import PackedArrays

REPORT_FILE_SIGNATURE = "<!doctype html>\n<!-- A report of stiction -->\n"
"""Start of every report, by which the program recognises reports that it may replace."""

_LICENCE_URL = "https://www.gnu.org/licenses/gpl-3.0.txt"
SCRIPT_FILES = ("nodes.js", "plots.js", "common.js", "result.js")


class ReportError(ValueError):
    """Error raised for a page that cannot be rendered or written."""


@dataclass(frozen=True)
class HtmlPage:
    """HTML page: title, lines below the title, main part, scripts, and the version that computed the result."""

    name: str
    head: list[str]
    body: str
    versions: str
    scripts: str = ""

    def html(self) -> str:
        """Return the complete page."""
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
        """Write the page. Replace an existing file only if it is a report; otherwise raise a `ReportError`."""
        with replace_file_atomically(path, REPORT_FILE_SIGNATURE.encode(), ReportError) as partial:
            partial.write_bytes(self.html().encode("utf-8", "replace"))


def read_package_file(name: str) -> str:
    """Return the text of a file in this package."""
    return (resources.files(__package__) / name).read_text("utf-8")


def script_markup(facts: dict[str, Any], packed_arrays: Mapping[str, str]) -> str:
    """Return markup with the scripts of a page and the data of a result: `facts` as JSON, and packed numbers."""
    # Escaping "<" ensures that the JSON text cannot close its HTML element or open another one.
    facts_json = to_json(facts).replace("<", "\\u003c")
    script_template = '<script type="application/octet-stream" id="packed-{}">{}</script>\n'
    packed_numbers = "".join(script_template.format(*item) for item in packed_arrays.items())
    text = "\n".join(map(read_package_file, SCRIPT_FILES))
    return (
        f'<script type="application/json" id="facts">{facts_json}</script>\n{packed_numbers}<script>\n{text}</script>\n'
    )


MAX_SHOWN_LINE_LENGTH = 400  # maximum number of characters of a line from a file that the page shows


def escape_html(text: object) -> str:
    """Escape text for HTML, as a single line of limited length without control characters."""
    return html.escape(printable_text(str(text), MAX_SHOWN_LINE_LENGTH))


def format_count(count: int, singular: str, plural: str | None = None) -> str:
    """Return a number with its noun in the singular or plural."""
    return f"{count} {singular if count == 1 else plural or f'{singular}s'}"


def plot_panel_markup(name: str, title: str, description: str, *, more: str, kind: str = "plot") -> str:
    """Return the markup of a plot: title, description and keyboard help for screen readers, and an empty caption."""
    return (
        f'<section class="panel" aria-labelledby="{name}-title"><h2 id="{name}-title">{title}</h2>'
        f'<div id="{name}" class="{kind}" role="application" tabindex="0" aria-label="{description}; {more}"></div>'
        f'<p class="caption" id="{name}-caption"></p></section>'
    )


# ---- Content of a page ----------------------------------------------------------------------------------------------


CELL_AXIS_LABELS = {
    "fractal_dimension": {"title": "fractal dimension _D_", "name": "D"},
    "cut_off": {"title": "cutoff wavelength (µm)", "name": "cutoff"},
}
"""Axis title and short name of the first dimension of the cells."""


@dataclass(frozen=True, eq=False)
class ReportContent:
    """Content of a page. The markup describes the study or shows figures."""

    study: Study
    name: str
    head: list[str]
    pairs_text: str
    facts: dict[str, Any]
    packed_arrays: PackedArrays
    num_members: int
    details_markup: str = ""
    contact_markup: str = ""
    pictures_markup: str = ""

    def incompleteness_notices(self) -> str:
        """Return markup with notices about missing and unsolved members, or an empty string for a complete result."""
        num_repetitions, notices = self.study.ensemble.repetitions, []
        if self.num_members < num_repetitions:
            notices.append(f"{self.name} is unfinished: {self.num_members} of {num_repetitions} repetitions.")
        if (num_unsolved := self.num_members - self.facts["repetitions"]) > 0:
            notices.append(
                f"{self.name}: {format_count(num_unsolved, 'repetition')} without a solution at every load left out."
            )
        return "".join(f'<p class="notice">{escape_html(line)}</p>' for line in notices)

    def study_description(self) -> str:
        """Return markup that describes the study: its differences from the defaults, and all its keys."""
        study_file = (
            "<details><summary>The whole study file (TOML)</summary>"
            f'<pre tabindex="0">{html.escape(_strip_folders(self.study).to_toml())}</pre></details>'
        )
        if self.study.is_measured:
            return f"<h2>The study</h2>{self.details_markup}{study_file}"
        changed_settings = [f"{key} = {value}" for key, _, value in find_table_differences(Study(), self.study)]
        lines = "".join(f"<li><code>{escape_html(line)}</code></li>" for line in changed_settings)
        summary_markup = (
            f"<p>The defaults, but</p><ul>{lines}</ul>" if changed_settings else "<p>All values are the defaults.</p>"
        )
        return f"<h2>The study</h2>{summary_markup}{study_file}"


def _strip_folders(study: Study) -> Study:
    """Remove folders from the file names of a study, because the folders do not exist on other computers."""
    if not study.is_measured:
        return study
    surfaces: Any = study.surfaces
    files = {side: getattr(surfaces, side) for side in ("upper", "lower")}
    renamed_files = {side: file.model_copy(update={"file": Path(file.file).name}) for side, file in files.items()}
    return study.model_copy(update={"surfaces": surfaces.model_copy(update=renamed_files)})


def list_rules_and_directions(study: Study) -> tuple[list[str], list[float]]:
    """Return the sliding rules and the directions (degrees) of a study, in the order in which the sums are stored."""
    return list(study.contact.sliding_rules()), [float(angle) for angle in study.contact.direction_angles()]


def slider_settings(axes: tuple[NodeAxis, NodeAxis], study: Study) -> dict[str, Any]:
    """Return the nodes of mu0 and tau0 (MPa) for a page, with the step and the initial value of each slider."""
    initial_values = (
        study.friction.mu0[0 if study.is_measured else len(study.friction.mu0) // 2],
        float(study.friction.tau0[0]),
    )
    facts = {}
    for name, axis, initial_value, unit in zip(("mu0", "tau0"), axes, initial_values, (1.0, 1e3), strict=True):
        max_value = unit * float(axis.rising[-1])
        facts[name] = {
            "rising": (unit * axis.rising).tolist(),
            "bounds": (unit * np.array(axis.ranged_node_intervals)).reshape(-1, 2).tolist(),
            "most": max_value, "step": 0.01 if name == "mu0" else float(f"{max_value / 200:.0e}"),
            "start": float(f"{unit * float(initial_value):.12g}"),
        }  # fmt: skip
    return facts
