"""Pages made from the package at each build of the documentation: names, keys of study files, options of commands."""

from __future__ import annotations

import importlib
import inspect
import math
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Literal, get_args, get_origin

import stiction
import typer
from stiction import Study
from stiction._units import Quantity
from stiction.cli.application import COMMANDS, app
from stiction.studies import study_values
from stiction.studies.study import study_names, study_summary
from stiction.studies.study_tables import _KEYS, _WORDS
from stiction.studies.study_values import MOST_DEGREES

ENTRY = re.compile(r"^\.\. (?:autoclass|autofunction|py:data):: (\S+)$", re.MULTILINE)
"""A name in a page of the reference."""


def pages(docs: Path) -> dict[str, str]:
    """Text by the name of its file."""
    return {
        "names.md": names(docs),
        "study_keys.md": study_keys(),
        "commands.md": commands(),
        "built_in.md": built_in(),
    }


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
        lines += [f"## [{title[1]}](api_{group}.md)", "", "| name | |", "|---|---|"]
        lines += [_row(f"`{name.split('.')[-1]}`", _summary(name)) for name in ENTRY.findall(text)]
        lines.append("")
    return "\n".join(lines)


def targets(docs: Path) -> dict[str, str]:
    """What the reference calls each name, by the name as pages write it."""
    found = (name for group in GROUPS for name in ENTRY.findall((docs / f"api_{group}.md").read_text("utf-8")))
    return {name.split(".")[-1]: name if name.startswith("stiction.") else f"stiction.{name}" for name in found}


def _summary(name: str) -> str:
    """The first paragraph of a docstring."""
    found: object = stiction
    parts = name.removeprefix("stiction.").split(".")
    if len(parts) > 1:
        found, parts = importlib.import_module(f"stiction.{'.'.join(parts[:-1])}"), parts[-1:]
    for part in parts:
        found = getattr(found, part)
    if isinstance(found, str):
        return "The version of the package."
    first = (inspect.getdoc(found) or "").split("\n\n")[0]
    return " ".join(first.split())


# ---- Keys of study files --------------------------------------------------------------------------------------------

_QUANTITIES = (
    (study_values.Length, "a length above 0"),
    (study_values.LengthOrZero, "a length, at least 0"),
    (study_values.Modulus, "a pressure above 0"),
    (study_values.Strength, "a pressure, at least 0"),
    (study_values.Force, "a force above 0"),
    (study_values.Extent, "one or two lengths above 0"),
    (study_values.Directions, f'`"+x"`, `"-x"` or degrees from {-MOST_DEGREES} to {MOST_DEGREES}'),
    (study_values.Rules, '`"opposing"`, `"all"`'),
)
"""What the validators of a study ask of quantities, in words."""


def study_keys() -> str:
    """A table for each part of a study file: key, default, what is allowed, meaning."""
    lines = []
    for part, field in Study.model_fields.items():
        table = field.annotation
        assert isinstance(table, type)
        lines += [
            f"## `[{part}]`",
            "",
            f"{table.__doc__}",
            "",
            "| key | default | allowed | meaning |",
            "|---|---|---|---|",
        ]
        for key, entry in table.model_fields.items():  # type: ignore[attr-defined]
            allowed = _joined(_allowed(entry.annotation, entry.metadata))
            owners = _KEYS.get(key)
            of = f" Only of {' and '.join(_WORDS[each] for each in owners)}." if owners else ""
            lines.append(_row(f"`{key}`", _toml(entry.default), allowed, f"{entry.description}{of}"))
        lines.append("")
    return "\n".join(lines)


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|").replace("E*", r"E\*") for cell in cells) + " |"


def _allowed(annotation: Any, metadata: Sequence[Any] = ()) -> list[str]:
    """What a value may be, one phrase for each way."""
    for kind, words in _QUANTITIES:
        if annotation is kind or any(each in metadata for each in kind.__metadata__[:1]):
            return [words]
    if get_origin(annotation) is Literal:
        return [f'`"{value}"`' for value in get_args(annotation)]
    if isinstance(annotation, type) and issubclass(annotation, study_values.Table):
        if "start" in annotation.model_fields:
            spacing = ", spacing" if "spacing" in annotation.model_fields else ""
            return [f"a range `{{ start, stop, count{spacing} }}`"]
        return [f"a table of {', '.join(f'`{name}`' for name in annotation.model_fields)}"]
    if get_origin(annotation) is tuple:
        items = [each for each in get_args(annotation) if each is not Ellipsis]
        of = _joined(list(dict.fromkeys(words for each in items for words in _allowed(each))))
        for one, many in _PLURALS:
            of = of.replace(one, many)
        return [f"a list of {of}" if Ellipsis in get_args(annotation) else f"a list of {len(items)} {of}"]
    if hasattr(annotation, "__metadata__"):  # an alias of Annotated
        return _allowed(annotation.__origin__, annotation.__metadata__)
    if get_origin(annotation) is not None:  # a union
        ways = [_allowed(each) for each in get_args(annotation) if each is not type(None)]
        return list(dict.fromkeys(words for way in ways for words in way))
    ends = {name: getattr(each, name) for each in _flat(metadata) for name in _ENDS if hasattr(each, name)}
    what = {int: "a whole number", float: "a number"}[annotation]
    return [" ".join([what, *(f"{_ENDS[name]} {_number(end)}" for name, end in ends.items())])]


_PLURALS = tuple((f"a {one}", f"{one}s") for one in ("length", "pressure", "force", "number", "whole number"))
_ENDS = {"ge": "from", "gt": "above", "le": "to", "lt": "to below"}


def _flat(metadata: Sequence[Any]) -> list[Any]:
    """Constraints, also those within a Field."""
    return [part for each in metadata for part in (each, *getattr(each, "metadata", ()))]


def _number(end: float) -> str:
    power = round(math.log2(end)) if end > 1e9 else 0
    return f"2^{power}" if power and 2**power == end else f"{end:,}".replace(",", " ")


def _joined(words: list[str]) -> str:
    return ", ".join(words[:-1]) + " or " + words[-1] if len(words) > 1 else words[0]


def _toml(value: Any) -> str:
    """A default as a study file has it."""
    if value is None:
        return "none"
    return f"`{_toml_text(value)}`"


def _toml_text(value: Any) -> str:
    if isinstance(value, Quantity):
        return f'"{value.text}"'
    if isinstance(value, tuple):
        return f"[{', '.join(map(_toml_text, value))}]"
    if isinstance(value, study_values.Table):
        entries = ((name, _toml_text(getattr(value, name))) for name in type(value).model_fields)
        return f"{{ {', '.join(f'{name} = {text}' for name, text in entries)} }}"
    return f'"{value}"' if isinstance(value, str) else f"{value}"


# ---- Commands -------------------------------------------------------------------------------------------------------


def commands() -> str:
    """Every command: usage, arguments and options, and what its help ends with."""
    for module in {module for group in COMMANDS.values() for module, _ in group.values()}:
        importlib.import_module(f"stiction.cli.{module}")
    known: Any = typer.main.get_command(app)
    lines = []
    for name in (name for group in COMMANDS.values() for name in group):
        command = known.commands[name]
        context = command.context_class(command, info_name=f"stiction {name}")
        usage = command.get_usage(context).partition(":")[2].strip()
        lines += [f"## `stiction {name}`", "", *_paragraphs(command.help or ""), "", "```text", usage, "```", ""]
        for kind in ("argument", "option"):
            rows = [_parameter(each) for each in command.get_params(context) if each.param_type_name == kind]
            if rows:
                lines += [f"| {kind} | default | meaning |", "|---|---|---|", *rows, ""]
        shown = re.findall(r"^  (stiction .*)$", command.epilog or "", re.MULTILINE)
        lines += ["```text", *shown, "```", ""]
    return "\n".join(lines)


def _paragraphs(text: str) -> list[str]:
    return [" ".join(each.split()) + "\n" for each in text.split("\n\n")]


def _parameter(parameter: Any) -> str:
    shown = parameter.metavar or ""
    if parameter.param_type_name == "argument":
        return _row(f"`{shown}`", "" if parameter.required else "none", parameter.help or "")
    names = ", ".join(f"`{each}`" for each in sorted(parameter.opts, key=len, reverse=True))
    value = "" if parameter.is_flag else f" `{shown}`"
    default = parameter.show_default if isinstance(parameter.show_default, str) else parameter.default
    if parameter.name == "help" or parameter.is_flag:
        default = ""
    words = "required" if parameter.required else "none" if default in (None, False) else str(default)
    return _row(names + value, words, parameter.help or "")


# ---- Built-in studies -----------------------------------------------------------------------------------------------


def built_in() -> str:
    """A table of the studies by their names."""
    return "\n".join(["| study | |", "|---|---|", *(_row(f"`{name}`", study_summary(name)) for name in study_names())])
