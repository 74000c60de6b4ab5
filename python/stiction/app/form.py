"""Form of the app: HTML of its fields, parsing of the user's entries, and messages that name form fields."""

from __future__ import annotations

import html
import json
import re
from collections.abc import Iterable, Mapping
from typing import Any, Literal

from stiction._errors import ArgumentError
from stiction.study.pair_options import (
    PAIR_OPTIONS,
    READING_OPTION_NAMES,
    FormField,
    format_command_line_name,
    split_option_text,
)
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS

_OPTION_NAMES_BY_FLAG = {format_command_line_name(name).removeprefix("--"): name for name in PAIR_OPTIONS}
"""Python name of each option, keyed by the command-line name without dashes."""

FORM_FIELDS_BY_FLAG: dict[str, FormField] = {
    flag: field for flag, name in _OPTION_NAMES_BY_FLAG.items() if (field := PAIR_OPTIONS[name].field) is not None
}
"""Form field of each option, keyed by the option name without dashes."""

FILE_READING_FLAGS = tuple(flag for flag in FORM_FIELDS_BY_FLAG if _OPTION_NAMES_BY_FLAG[flag] in READING_OPTION_NAMES)
"""Names of the reading options that have a form field for each scan."""

FLAGS_SHARED_BY_SCANS = tuple(
    flag
    for flag, field in FORM_FIELDS_BY_FLAG.items()
    if field.place == "scan" and not PAIR_OPTIONS[_OPTION_NAMES_BY_FLAG[flag]].is_repeatable
)
"""Names of the options that have a form field for each scan, although a single setting applies to both scans."""


SHEAR_FORM_FLAGS = ("path", "direction", "normal-stiffness", "register")
"""Names of the shear test options that have a form field of their own."""

SHEAR_FLAGS = (
    *FILE_READING_FLAGS, "upper", "lower", "young", "poisson", "hardness", "load", "mu0", "tau0", "interface", "tilt",
)  # fmt: skip
"""Names of the options that shear tests and pairs have in common."""


def fields_html(place: Literal["scan", "more"]) -> str:
    """Return the form fields in one section of the app's form as HTML."""
    return "\n".join(_field_html(flag, field) for flag, field in FORM_FIELDS_BY_FLAG.items() if field.place == place)


def _field_html(flag: str, field: FormField) -> str:
    if field.choices:
        choices = [("", field.default_label), *field.choices]
        choice_options = "".join(
            f'<option value="{html.escape(value)}">{html.escape(text)}</option>' for value, text in choices
        )
        return f'<label>{html.escape(field.label)} <select name="{flag}">{choice_options}</select></label>'
    size_attribute = f' size="{field.size}"' if field.size else ""
    mode_attribute = f' inputmode="{field.keyboard}"' if field.keyboard else ""
    input_element = f'<input name="{flag}"{mode_attribute} placeholder="{html.escape(field.example)}"{size_attribute}>'
    return f"<label>{html.escape(field.label)} {input_element}</label>"


def page_data_json() -> str:
    """Return the data for the script of the app's page as JSON, escaped for an HTML attribute.

    The data are units of plain numbers, options with one value for both scans, and descriptions of the sliding rules.
    """
    page_data = {
        "units": {flag: f" {field.unit}" for flag, field in FORM_FIELDS_BY_FLAG.items() if field.unit},
        "shared": FLAGS_SHARED_BY_SCANS,
        "shear": SHEAR_FLAGS,
        "ruleDescriptions": SLIDING_RULE_DESCRIPTIONS,
    }
    return html.escape(json.dumps(page_data, ensure_ascii=False))


def group_option_values(options: Iterable[tuple[str, str]]) -> dict[str, Any]:
    """Convert form entries (pairs of option name and text) to keyword arguments of `MeasuredPair.from_values`."""
    texts_by_name: dict[str, list[str]] = {}
    for flag, text in options:
        texts_by_name.setdefault(_OPTION_NAMES_BY_FLAG[flag], []).append(text)
    return {name: texts if PAIR_OPTIONS[name].is_repeatable else texts[0] for name, texts in texts_by_name.items()}


def format_error(error: Exception) -> str:
    """Return the message of an error with option names instead of Python argument names."""
    return error.translated_message(format_command_line_name) if isinstance(error, ArgumentError) else str(error)


def parse_reading_options(texts_by_flag: Mapping[str, str]) -> dict[str, str | tuple[str, ...]]:
    """Convert the texts of nonempty form fields to keyword arguments of `read_measurement`."""
    option_texts = {flag.replace("-", "_"): texts_by_flag.get(flag) for flag in FILE_READING_FLAGS}
    return {name: split_option_text(name, text) for name, text in option_texts.items() if text}


_OPTION_PATTERN = re.compile(r"--([a-z0-9-]+)(?: ([\w,-]+))?")
"""Pattern of an option name, with the next word, which may be the value of the option."""

_PYTHON_ARGUMENT_PATTERN = re.compile(r'\b\w+="[^"]*" \((--[^()]*)\)')
"""Pattern of a Python argument that is followed by the equivalent option in brackets."""


def find_first_option_name(message: str) -> str:
    """Return the option name at the start of an error message.

    Returns "" if the form has no field for this option.
    """
    match = _OPTION_PATTERN.match(message)
    return match[1] if match and match[1] in FORM_FIELDS_BY_FLAG else ""


def replace_option_names(message: str) -> str:
    """Replace option names and option values in the message of a command by the labels in the app's form."""

    def field_label(match: re.Match[str]) -> str:
        field = FORM_FIELDS_BY_FLAG.get(match[1])
        if field is None:
            return match[0]
        label, value = f'"{field.label.partition(",")[0]}"', match[2]
        choice_text = dict(field.choices).get(value)
        return f"{label}: {choice_text}" if choice_text else label if value is None else f"{label} {value}"

    return _OPTION_PATTERN.sub(field_label, _PYTHON_ARGUMENT_PATTERN.sub(r"\1", message))


def replace_option_names_in_caveats(record: dict[str, Any]) -> dict[str, Any]:
    """Replace option names in the caveats of a JSON record by the labels of form fields."""
    caveats = [{name: replace_option_names(text) for name, text in caveat.items()} for caveat in record["caveats"]]
    return record | {"caveats": caveats}


def replace_option_names_in_preview(preview: dict[str, Any]) -> dict[str, Any]:
    """Replace option names in the messages of a scan preview by the labels of form fields."""
    return preview | {name: replace_option_names(preview[name]) for name in ("error", "warning") if name in preview}
