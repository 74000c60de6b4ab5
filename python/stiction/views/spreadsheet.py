"""Tables as CSV for spreadsheet programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas

FORMULA_START_CHARACTERS = ("=", "+", "-", "@", "\t", "\r", "\n", "＝", "＋", "－", "＠")
"""Characters at the start of a cell that make a spreadsheet program interpret the cell as a formula."""


def frame_to_csv(frame: pandas.DataFrame, *, float_format: str = "%.9g") -> str:
    """Return a data frame as CSV, with an apostrophe before cells that a spreadsheet would interpret as formulas."""
    frame = frame.rename(columns=_escape_formula)
    for name in frame.columns[[not _is_numeric(dtype) for dtype in frame.dtypes]]:
        frame[name] = frame[name].map(_escape_formula)
    text: str = frame.to_csv(index=False, float_format=float_format)
    return text


def _is_numeric(kind: Any) -> bool:
    return getattr(kind, "kind", "O") in "iufb"


def _escape_formula(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA_START_CHARACTERS) else value
