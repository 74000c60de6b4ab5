"""Pages made from the package at each build of the documentation: names, keys of study files, options of commands."""

from __future__ import annotations

import inspect
import re
from pathlib import Path

import stiction

ENTRY = re.compile(r"^\.\. (?:autoclass|autofunction|py:data):: (\S+)$", re.MULTILINE)
"""A name in a page of the reference."""


def pages(docs: Path) -> dict[str, str]:
    """Text by the name of its file."""
    return {"names.md": names(docs)}


# ---- Names ----------------------------------------------------------------------------------------------------------

GROUPS = ("surfaces", "roughness", "mechanics", "closed_forms", "studies", "measured", "files")
"""Pages of the Python reference, ``docs/api_GROUP.md``."""


def names(docs: Path) -> str:
    """A table for each group: every name and the first line of what it says of itself."""
    lines = []
    for group in GROUPS:
        text = (docs / f"api_{group}.md").read_text("utf-8")
        title = re.search(r"^# (.*)$", text, re.MULTILINE)
        assert title is not None
        lines += [f"## [{title[1]}](../api_{group}.md)", "", "| name | |", "|---|---|"]
        lines += [f"| {_link(name)} | {_summary(name)} |" for name in ENTRY.findall(text)]
        lines.append("")
    return "\n".join(lines)


def _link(name: str) -> str:
    full = name if name.startswith("stiction.") else f"stiction.{name}"
    return f"[`{full.split('.')[-1]}`](#{full})"


def _summary(name: str) -> str:
    """The first paragraph of a docstring."""
    found: object = stiction
    parts = name.removeprefix("stiction.").split(".")
    if len(parts) > 1:
        module = __import__(f"stiction.{'.'.join(parts[:-1])}", fromlist=["_"])
        found, parts = module, parts[-1:]
    for part in parts:
        found = getattr(found, part)
    if isinstance(found, str):
        return "The version of the package."
    first = (inspect.getdoc(found) or "").split("\n\n")[0]
    return " ".join(first.split()).replace("|", r"\|")
