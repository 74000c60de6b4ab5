"""Common schema of the JSON records that commands print.

A record contains ``schema`` (a number that increases with every incompatible change), ``stiction`` (the version),
``command``, a description of the inputs, and ``values``. Each value is the object that `Estimate.to_record` returns:
``name``, ``value``, ``unit`` ("1" if dimensionless), ``lower`` and ``upper`` (the 95 % interval), ``kind`` (of the
interval), ``at`` (its coordinates in µm, mN, GPa and degrees) and ``status``. Missing values are null.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from stiction._core import __version__
from stiction._number_format import to_json

if TYPE_CHECKING:
    from stiction.summary.assessment import Caveat

SCHEMA_VERSION = 2


def record_json(command: str, values: list[dict[str, Any]], **fields: Any) -> str:
    """Return the output of a command as JSON text: command name, version of stiction, results and further fields."""
    record = {"schema": SCHEMA_VERSION, "stiction": __version__, "command": command, **fields, "values": values}
    return to_json(record, ensure_ascii=False, indent=1)


def caveat_record(caveat: Caveat) -> dict[str, str]:
    """Return a caveat as the fields of a JSON object."""
    return {"text": caveat.text, "remedy": caveat.remedy, "severity": caveat.severity}
