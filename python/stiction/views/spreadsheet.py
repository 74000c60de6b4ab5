"""Tables as CSV for spreadsheet programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import pandas

FORMULA_STARTS = ("=", "+", "-", "@", "\t", "\r")
"""First characters that make a spreadsheet program evaluate a text as a formula."""


def csv_of_frame(frame: pandas.DataFrame, *, float_format: str = "%.9g") -> str:
    """Return a table as CSV; a text that a spreadsheet would take for a formula begins with an apostrophe."""
    frame = frame.rename(columns=_as_text)
    for name in frame.columns[[not _is_numeric(kind) for kind in frame.dtypes]]:
        frame[name] = frame[name].map(_as_text)
    text: str = frame.to_csv(index=False, float_format=float_format)
    return text


def _is_numeric(kind: Any) -> bool:
    return getattr(kind, "kind", "O") in "iufb"


def _as_text(value: Any) -> Any:
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULA_STARTS) else value
