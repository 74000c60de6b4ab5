"""Keys of study files as tables, made from the models that read them: for the documentation and the terminal."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal, get_args, get_origin

from pydantic_core import PydanticUndefined

from stiction._units import Quantity
from stiction.mechanics.law import LAWS_BY_NAME
from stiction.studies import values
from stiction.studies.contact_tables import CONTACTS, LAW_TABLES, SHARED
from stiction.studies.generated_surfaces import SelfAffineSurfaces
from stiction.studies.input_uncertainty import UncertainInputsTable
from stiction.studies.measured_surfaces import MeasuredFile
from stiction.studies.study import FRICTIONS, SHARED_FRICTION, SURFACES, Ensemble, Figures
from stiction.views.text import fitted

Row = tuple[str, str, str, str]  # key, default, what is allowed, meaning

_QUANTITIES: tuple[tuple[Any, str], ...] = (
    (values.Length, "a length above 0"),
    (values.LengthOrZero, "a length, at least 0"),
    (values.Modulus, "a pressure above 0"),
    (values.Strength, "a pressure, at least 0"),
    (values.Force, "a force above 0"),
    (values.Time, "a time above 0"),
    (values.WorkOfAdhesion, "an energy of an area, at least 0"),
)
"""What the validators of a study ask of quantities, in words."""

_DEGREES = f"degrees from {-values.MOST_DEGREES} to {values.MOST_DEGREES}"
_ALLOWED = {
    "law": " or ".join(
        [*(f'`"{name}"`' for name in LAWS_BY_NAME), *(f'a table of name `"{name}"`' for name in LAW_TABLES)]
    ),
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

_UNCERTAIN = 'a value with its uncertainty or a range, as text: `"0.2±0.02"`, `"20..80 MPa"`'
_KNOWN = {
    UncertainInputsTable.model_fields["mu0"].annotation: _UNCERTAIN,
    UncertainInputsTable.model_fields["young"].annotation: f"a list of one or two such values: {_UNCERTAIN}",
}
"""What texts of the table `[known]` may be, by their types."""

_PRESSED = "How each pair is pressed together; measured areas by the half-space unless `mechanics` says otherwise."
_FRICTION = "What is asked for of measured surfaces, and what figures of generated ones show."
_CONTACTS = tuple(dict.fromkeys(case for cases in CONTACTS.values() for case in cases.values()))
_TABLES: tuple[tuple[str, str, tuple[type[values.Table], ...], tuple[type[values.Case], ...]], ...] = (
    ("`[surfaces]`, generated", "Fractal profiles, or areas of two kinds.", SURFACES[:3], ()),
    ("`[surfaces]`, measured", "Two measured files, and how pairs are made of them.", SURFACES[3:], ()),
    ("`upper` and `lower` of measured surfaces", f"{MeasuredFile.__doc__}", (MeasuredFile,), ()),
    ("`[contact]`", _PRESSED, _CONTACTS, SHARED),
    ("`[friction]`", _FRICTION, FRICTIONS, SHARED_FRICTION),
    ("`[known]`", f"{UncertainInputsTable.__doc__}", (UncertainInputsTable,), ()),
    ("`[ensemble]`", f"{Ensemble.__doc__}", (Ensemble,), ()),
    ("`[figures]` of generated surfaces", f"{Figures.__doc__}", (Figures,), ()),
)
"""Tables of a study file, their cases, and classes of keys that several cases share."""


def key_tables() -> list[tuple[str, str, list[Row]]]:
    """Return title, description and rows of each table of a study file."""
    tables = []
    for title, words, cases, shared in _TABLES:
        owners: dict[Row, list[type[values.Table]]] = {}
        for case in cases:
            for key, entry in case.model_fields.items():
                if entry.repr:  # others are of bodies in memory, which no file of a study has
                    default = PydanticUndefined if entry.is_required() else entry.default
                    owners.setdefault(_entry(key, default, entry, cases), []).append(case)
        keys, rows = list(dict.fromkeys(row[0] for row in owners)), []
        for (key, default, allowed, meaning), own in sorted(owners.items(), key=lambda item: keys.index(item[0][0])):
            of = "" if len(own) == len(cases) else f" Of {_listed(_places(own, cases, shared))}."
            rows.append((key, default, allowed, meaning + of))
        for case in cases:
            if issubclass(case, SelfAffineSurfaces):
                others = case.other_keys.items()
                rows += [(f"`{key}`", "none", allowed, f"{of} Of {case.place}.") for key, (allowed, of) in others]
        tables.append((title, words, rows))
    return tables


def _places(
    owners: Sequence[type[values.Table]], cases: Sequence[type[values.Table]], shared: Sequence[type[values.Case]]
) -> list[str]:
    """Return the names of some cases of a table: of classes that cover several of them, or of the cases themselves."""
    members = {each: {case for case in cases if issubclass(case, each)} for each in shared}
    rest, places = set(owners), []
    for each in sorted(shared, key=lambda each: -len(members[each])):
        if members[each] <= rest:
            places.append(each.place)
            rest -= members[each]
    return places + [case.place for case in cases if case in rest and issubclass(case, values.Case)]


def study_keys() -> str:
    """Return every key of a study file as tables in Markdown."""
    lines = []
    for title, words, rows in key_tables():
        lines += [f"## {title}", "", words, "", "| key | default | allowed | meaning |", "|---|---|---|---|"]
        lines += [*map(markdown_row, rows), ""]
    return "\n".join(lines)


def study_keys_text() -> str:
    """Return every key of a study file for a terminal: a paragraph each, under the title of its table."""
    blocks = []
    for title, _, rows in key_tables():
        lines = [title.replace("`", "")]
        for row in rows:
            key, default, allowed, meaning = (cell.replace("`", "") for cell in row)
            lines.append(fitted(f"{key} = {default}: {allowed}. {meaning}", indent="  ", hang="    "))
        blocks.append("\n".join(lines))
    return "\n\n".join(blocks) + "\n"


def _entry(key: str, usual: Any, entry: Any, cases: tuple[Any, ...]) -> tuple[str, str, str, str]:
    """Key, default, what is allowed, meaning; a key that says of which case a table is has a row for all of them."""
    default = "required" if usual is PydanticUndefined else _toml(usual)
    if key not in ("generator", "press", "mechanics"):
        return f"`{key}`", default, _allowed_of(key, entry), str(entry.description)
    fields = [case.model_fields[key] for case in cases if key in case.model_fields]
    meanings = dict.fromkeys(f'`"{field.default}"`: {str(field.description).removesuffix(".")}' for field in fields)
    allowed = list(dict.fromkeys(f'`"{field.default}"`' for field in fields))
    return f"`{key}`", _toml(fields[0].default), _joined(allowed), "; ".join(meanings) + "."


def _allowed_of(key: str, entry: Any) -> str:
    if entry.annotation in _KNOWN:
        return _KNOWN[entry.annotation]
    if key == "direction":
        one = f'`"+x"`, `"-x"` or {_DEGREES}'
        return f"{one}, or a list of these"
    return _ALLOWED.get(key) or _joined(_allowed(entry.annotation, entry.metadata))


def _listed(words: list[str]) -> str:
    return ", ".join(words[:-1]) + " and " + words[-1] if len(words) > 1 else words[0]


def markdown_row(cells: Sequence[str]) -> str:
    """Return a row of a table in Markdown."""
    return "| " + " | ".join(cell.replace("|", r"\|").replace("E*", r"E\*") for cell in cells) + " |"


def _allowed(annotation: Any, metadata: Sequence[Any] = ()) -> list[str]:
    """What a value may be, one phrase for each way."""
    for kind, words in _QUANTITIES:
        if annotation is kind or any(each in metadata for each in kind.__metadata__[:1]):
            return [words]
    if annotation is Quantity:  # of files, whose lengths are read by functions of their own
        return ["a length"]
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
