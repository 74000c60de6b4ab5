"""One result of a page: what it is called, what the page says and knows of it, and its numbers."""

from __future__ import annotations

import html
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from stiction.studies.study import Study, differences
from stiction.views.report.page import counted, escaped

BYTES = {"means": 8, "sums": 5, "profiles": 3, "contacts": 3}
"""Leading bytes of a double that are kept: all of them, 2e-9 of a sum, and 1e-4 of what is only drawn."""

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
