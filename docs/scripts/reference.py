"""Generate the reference pages of the documentation: public names, keys of study files, and options of commands."""

from __future__ import annotations

import importlib
import inspect
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import stiction
import typer
from stiction.cli.application import COMMANDS_BY_GROUP, app
from stiction.study.study import Study, read_study_description, study_names
from stiction.surfaces.parameters import PROFILE_PARAMETERS, SURFACE_PARAMETERS
from stiction.views.study_keys import markdown_row, study_keys_markdown

API_ENTRY_PATTERN = re.compile(r"^\.\. (?:autoclass|autofunction|py:data):: (\S+)$", re.MULTILINE)
"""Pattern of the directive that documents a name on a reference page."""
CLAIMS_COLUMN_TITLES = ("claim or test", "verdict", "statement, and its test numbers")
CLAIMS_BY_SURFACE_COLUMN_TITLES = (
    "claim or test", "profiles, 100 repetitions", "profiles, 2000 repetitions", "height maps, asperities, 25",
    "half-planes, 20", "half-spaces, 30",
)  # fmt: skip
"""Titles of those columns of `generated/columns.md` that the page about friction shows."""


def render_pages(docs: Path) -> dict[str, str]:
    """Return the text of each reference page by file name."""
    return {
        "names.md": render_api_tables(docs),
        "commands.md": render_command_sections(),
        "built_in.md": render_study_table(),
        "parameters.md": render_parameter_tables(),
        "claims.md": verdict_table(docs / "generated/claims.md", CLAIMS_COLUMN_TITLES),
        "columns.md": verdict_table(docs / "generated/columns.md", CLAIMS_BY_SURFACE_COLUMN_TITLES),
    }


def _markdown_row(*cells: str) -> str:
    return markdown_row(cells)


def verdict_table(table: Path, titles: Sequence[str]) -> str:
    """Return the columns of a table of claims that have the given titles, with one row per claim."""
    header, separator, *rows = (
        [cell.strip() for cell in row.split("|")[1:-1]] for row in table.read_text("utf-8").splitlines()
    )
    columns = [header.index(title) for title in titles]
    header = [cell.split(", and its")[0].removesuffix(" or test") for cell in header]
    claims = [row for row in rows if row[0].startswith("**")]
    return (
        "\n".join(
            _markdown_row(*(_verdict_badge(row[column]).strip("*") for column in columns))
            for row in (header, separator, *claims)
        )
        + "\n"
    )


def _verdict_badge(cell: str) -> str:
    return re.sub(r"^\*\*(true|false|undecided|undefined)\*\*$", r'<span class="verdict verdict-\1">\1</span>', cell)


# ---- Names ----------------------------------------------------------------------------------------------------------

PAGE_GROUPS = ("surfaces", "roughness", "mechanics", "closed_forms", "studies", "measured", "files")
"""Groups of the Python reference. Each group has a page ``docs/reference/api_GROUP.md``."""


def render_api_tables(docs: Path) -> str:
    """Return one table per group of the Python reference: public names with the summaries of their docstrings."""
    lines = []
    for group in PAGE_GROUPS:
        text = (docs / f"reference/api_{group}.md").read_text("utf-8")
        title = re.search(r"^# (.*)$", text, re.MULTILINE)
        assert title is not None
        lines += [f"## [{title[1]}](api_{group}.md)", "", "| name | description |", "|---|---|"]
        lines += [
            _markdown_row(f"`{name.split('.')[-1]}`", _docstring_summary(name))
            for name in API_ENTRY_PATTERN.findall(text)
        ]
        lines.append("")
    return "\n".join(lines)


def find_link_targets(docs: Path) -> dict[str, str]:
    """Return the link target of each public name, by name."""
    public_names = (
        name
        for group in PAGE_GROUPS
        for name in API_ENTRY_PATTERN.findall((docs / f"reference/api_{group}.md").read_text("utf-8"))
    )
    return {name.split(".")[-1]: name if name.startswith("stiction.") else f"stiction.{name}" for name in public_names}


def list_command_and_key_names() -> set[str]:
    """Return the names of all commands, and of all keys and sections of study files."""
    keys = {key.split(".")[-1] for key in re.findall(r"^\| `([\w.]+)` \|", study_keys_markdown(), re.MULTILINE)}
    return {name for group in COMMANDS_BY_GROUP.values() for name in group} | keys | {*Study.model_fields}


def _docstring_summary(name: str) -> str:
    """Return the first paragraph of the docstring of a public name."""
    public_object: object = stiction
    attribute_names = name.removeprefix("stiction.").split(".")
    if len(attribute_names) > 1:
        public_object, attribute_names = (
            importlib.import_module(f"stiction.{'.'.join(attribute_names[:-1])}"),
            attribute_names[-1:],
        )
    for attribute_name in attribute_names:
        public_object = getattr(public_object, attribute_name)
    if isinstance(public_object, str):
        return "The version of the package."
    first_paragraph = (inspect.getdoc(public_object) or "").split("\n\n")[0]
    return " ".join(first_paragraph.split())


# ---- Commands -------------------------------------------------------------------------------------------------------


def render_command_sections() -> str:
    """Return one section per command: usage, arguments, options, and epilogue."""
    command_group: Any = typer.main.get_command(app)
    lines = []
    for name in (name for group in COMMANDS_BY_GROUP.values() for name in group):
        command = command_group.get_command(command_group.context_class(command_group), name)
        context = command.context_class(command, info_name=f"stiction {name}")
        usage = command.get_usage(context).partition(":")[2].strip()
        lines += [f"## `stiction {name}`", "", *_split_paragraphs(command.help or ""), "", "```text", usage, "```", ""]
        for parameter_kind in ("argument", "option"):
            rows = [
                _parameter_row(param)
                for param in command.get_params(context)
                if param.param_type_name == parameter_kind
            ]
            if rows:
                lines += [f"| {parameter_kind} | default | meaning |", "|---|---|---|", *rows, ""]
        examples = re.findall(r"^  (stiction (?:.*\\\n)*.*)$", command.epilog or "", re.MULTILINE)
        lines += ["```text", *examples, "```", ""]
    return "\n".join(lines)


def _split_paragraphs(text: str) -> list[str]:
    return [" ".join(paragraph.split()) + "\n" for paragraph in text.split("\n\n")]


def _parameter_row(parameter: Any) -> str:
    placeholder = parameter.metavar or ""
    if parameter.param_type_name == "argument":
        return _markdown_row(f"`{placeholder}`", "" if parameter.required else "none", parameter.help or "")
    flags = ", ".join(f"`{flag}`" for flag in sorted(parameter.opts, key=len, reverse=True))
    choices = [] if parameter.is_flag else placeholder.strip("<>[]{}").split("|")
    value = f" {' or '.join(f'`{choice}`' for choice in choices)}" if choices else ""
    default = parameter.show_default if isinstance(parameter.show_default, str) else parameter.default
    if parameter.name == "help" or parameter.is_flag:
        default = ""
    default_text = "required" if parameter.required else "none" if default in (None, False) else str(default)
    return _markdown_row(flags + value, default_text, parameter.help or "")


# ---- Roughness parameters -------------------------------------------------------------------------------------------

_PROFILE_TITLES = {"P": "primary profile", "R": "roughness profile", "W": "waviness profile"}


def render_parameter_tables() -> str:
    """Return tables of roughness parameters, one per kind of generated profile, and one for surfaces."""
    tables = {f"Parameters of the {name}": PROFILE_PARAMETERS[letter] for letter, name in _PROFILE_TITLES.items()}
    lines = []
    for title, parameters in (tables | {"Parameters of a surface": SURFACE_PARAMETERS}).items():
        lines += [
            f"## {title}",
            "",
            _markdown_row("name", "meaning", "formula", "unit", "needs", "source"),
            f"|{6 * '---|'}",
        ]
        for parameter in parameters:
            formula = f"${parameter.formula}$".replace("|", r"\vert ")
            lines.append(
                _markdown_row(
                    f"*{parameter.name}*",
                    parameter.meaning,
                    formula,
                    parameter.unit or "1",
                    parameter.needs,
                    parameter.source,
                )
            )
        lines.append("")
    return "\n".join(lines)


# ---- Built-in studies -----------------------------------------------------------------------------------------------


def render_study_table() -> str:
    """Return a table of the built-in studies."""
    return "\n".join(
        [
            "| study | description |",
            "|---|---|",
            *(_markdown_row(f"`{name}`", read_study_description(name)) for name in study_names()),
        ]
    )
