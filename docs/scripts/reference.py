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
from pydantic_core import PydanticUndefined
from stiction._units import Quantity
from stiction.cli.application import COMMANDS, app
from stiction.mechanics.law import NAMED
from stiction.studies import values
from stiction.studies.contact_tables import CONTACTS, KEYS, LAW_TABLES
from stiction.studies.known import KnownTable
from stiction.studies.measured_surfaces import MeasuredFile
from stiction.studies.study import FRICTION_KEYS, SURFACES, Ensemble, Figures, Friction, study_names, study_summary

ENTRY = re.compile(r"^\.\. (?:autoclass|autofunction|py:data):: (\S+)$", re.MULTILINE)
"""A name in a page of the reference."""


def pages(docs: Path) -> dict[str, str]:
    """Text by the name of its file."""
    return {
        "names.md": names(docs),
        "study_keys.md": study_keys(),
        "commands.md": commands(),
        "built_in.md": built_in(),
        "claims.md": verdicts(docs / "generated/claims.md", [0, 1, 2]),
        "columns.md": verdicts(docs / "generated/columns.md", [0, 1, 2, 5, 7, 9]),
    }


def verdicts(table: Path, columns: Sequence[int]) -> str:
    """Claims of a table of claims and their numbers, and these columns."""
    head, rule, *rows = (
        [cell.strip() for cell in row.split("|")[1:-1]] for row in table.read_text("utf-8").splitlines()
    )
    head = [cell.split(", and its")[0] or "claim" for cell in head]
    claims = [row for row in rows if row[0].startswith("**")]
    return "\n".join(_row(*(_verdict(row[column]) for column in columns)) for row in (head, rule, *claims)) + "\n"


def _verdict(cell: str) -> str:
    return re.sub(r"^\*\*(true|false|undecided|undefined)\*\*$", r'<span class="verdict verdict-\1">\1</span>', cell)


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
    (values.Length, "a length above 0"),
    (values.LengthOrZero, "a length, at least 0"),
    (values.Modulus, "a pressure above 0"),
    (values.Strength, "a pressure, at least 0"),
    (values.Force, "a force above 0"),
    (values.Time, "a time above 0"),
)
"""What the validators of a study ask of quantities, in words."""

_DEGREES = f"degrees from {-values.MOST_DEGREES} to {values.MOST_DEGREES}"
_ALLOWED = {
    "law": " or ".join([*(f'`"{name}"`' for name in NAMED), *(f'a table of name `"{name}"`' for name in LAW_TABLES)]),
    "sliding": '`"opposing"`, `"all"` or a list of both',
    "unit": "a unit of length or a list of two",
    "spacing": "a length above 0 or a list of two",
    "channel": "a name or a number from 0",
    "columns": "a name or a number from 0, or a list of two",
    "sha256": "64 hexadecimal digits",
    "file": "a name",
    "upper": "a table, see below",
    "lower": "a table, see below",
}
"""What keys may be whose values are read by functions of their own."""

_PRESSED = "How each pair is pressed together; measured areas by the half-space unless `mechanics` says otherwise."
_TABLES: tuple[tuple[str, str, tuple[Any, ...], values.Keys], ...] = (
    ("`[surfaces]`, generated", "Fractal profiles, or areas of two kinds.", SURFACES[:3], {}),
    ("`[surfaces]`, measured", "Two measured files, and how pairs are made of them.", SURFACES[3:], {}),
    ("`upper` and `lower` of measured surfaces", f"{MeasuredFile.__doc__}", (MeasuredFile,), {}),
    ("`[contact]`", _PRESSED, tuple(CONTACTS.values()), KEYS),
    ("`[friction]`", f"{Friction.__doc__}", (Friction,), FRICTION_KEYS),
    ("`[known]`", f"{KnownTable.__doc__}", (KnownTable,), {}),
    ("`[ensemble]`", f"{Ensemble.__doc__}", (Ensemble,), {}),
    ("`[figures]` of generated surfaces", f"{Figures.__doc__}", (Figures,), {}),
)
"""Tables of a study file, their cases, and where their keys may stand."""


def study_keys() -> str:
    """A table for each part of a study file: key, default, what is allowed, meaning and for which cases."""
    lines = []
    for title, words, cases, places in _TABLES:
        lines += [f"## {title}", "", words, "", "| key | default | allowed | meaning |", "|---|---|---|---|"]
        owners: dict[tuple[str, str, str, str], list[str]] = {}
        for case in cases:
            for key, entry in case.model_fields.items():
                if not entry.repr:  # of bodies in memory, which no file of a study has
                    continue
                for place, default in places.get(key, {getattr(case, "case", ""): entry.default}).items():
                    owners.setdefault(_entry(key, default, entry, cases), []).append(place)
        keys = list(dict.fromkeys(row[0] for row in owners))
        for (key, default, allowed, meaning), names in sorted(owners.items(), key=lambda item: keys.index(item[0][0])):
            everywhere = "" in names or (key.strip("`") not in places and len(names) == len(cases))
            of = "" if everywhere else f" Of {_listed(list(dict.fromkeys(names)))}."
            lines.append(_row(key, default, allowed, meaning + of))
        lines.append("")
    return "\n".join(lines)


def _entry(key: str, usual: Any, entry: Any, cases: tuple[Any, ...]) -> tuple[str, str, str, str]:
    """Key, default, what is allowed, meaning; a key that says of which case a table is has a row for all of them."""
    default = "required" if usual in (values.REQUIRED, PydanticUndefined) else _toml(usual)
    if key not in ("generator", "press", "mechanics"):
        return f"`{key}`", default, _allowed_of(key, entry), str(entry.description)
    fields = [case.model_fields[key] for case in cases if key in case.model_fields]
    meanings = dict.fromkeys(f'`"{field.default}"`: {str(field.description).removesuffix(".")}' for field in fields)
    allowed = list(dict.fromkeys(f'`"{field.default}"`' for field in fields))
    return f"`{key}`", _toml(fields[0].default), _joined(allowed), "; ".join(meanings) + "."


def _allowed_of(key: str, entry: Any) -> str:
    if key == "direction":
        one = f'`"+x"`, `"-x"` or {_DEGREES}'
        return f"{one}, or a list of these"
    return _ALLOWED.get(key) or _joined(_allowed(entry.annotation, entry.metadata))


def _listed(words: list[str]) -> str:
    return ", ".join(words[:-1]) + " and " + words[-1] if len(words) > 1 else words[0]


def _row(*cells: str) -> str:
    return "| " + " | ".join(cell.replace("|", r"\|").replace("E*", r"E\*") for cell in cells) + " |"


def _allowed(annotation: Any, metadata: Sequence[Any] = ()) -> list[str]:
    """What a value may be, one phrase for each way."""
    if annotation is values.Quantity:  # whose validator asks for more
        return ["a length"]
    for kind, words in _QUANTITIES:
        if annotation is kind or any(each in metadata for each in kind.__metadata__[:1]):
            return [words]
    if get_origin(annotation) is Literal:
        return [f'`"{value}"`' for value in get_args(annotation)]
    if isinstance(annotation, type) and issubclass(annotation, values.Table):
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
    what = {bool: "`true` or `false`", int: "a whole number", float: "a number", str: "a name"}[annotation]
    return [" ".join([what, *(f"{_ENDS[name]} {_number(end)}" for name, end in ends.items())])]


_PLURALS = tuple(
    (f"a {one}", f"{one}s") for one in ("length", "pressure", "force", "time", "number", "whole number", "name")
)
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
    if isinstance(value, values.Table):
        entries = ((name, _toml_text(getattr(value, name))) for name in type(value).model_fields)
        return f"{{ {', '.join(f'{name} = {text}' for name, text in entries)} }}"
    return f'"{value}"' if isinstance(value, str) else f"{value}"


# ---- Commands -------------------------------------------------------------------------------------------------------


def commands() -> str:
    """Every command: usage, arguments and options, and what its help ends with."""
    known: Any = typer.main.get_command(app)
    lines = []
    for name in (name for group in COMMANDS.values() for name in group):
        command = known.get_command(known.context_class(known), name)
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
