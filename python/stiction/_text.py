"""Conversion of texts from files and users to printable texts of limited length for terminal output."""

from __future__ import annotations

import math
import os
import unicodedata

MAX_PATH_LENGTH = 300  # characters
MAX_WORD_LENGTH = 80  # characters
MAX_QUOTED_LINE_LENGTH = 1000  # characters

# Unicode categories: control and format characters, surrogates, line separators and paragraph separators.
_UNPRINTABLE_CATEGORIES = {"Cc", "Cf", "Cs", "Zl", "Zp"}


def printable_text(text: object, max_length: int = MAX_WORD_LENGTH) -> str:
    r"""Return a text as one line, in which control characters are escaped and dots replace the middle of a long text.

    Examples
    --------
    >>> printable_text("a\nb\x1b[31m")
    'a\\nb\\x1b[31m'
    >>> printable_text("a" * 10 + "b" * 10, max_length=11)
    'aaaa...bbbb'
    """
    line = str(text)
    if len(line) > max_length:
        half_length = (max_length - 3) // 2
        line = f"{line[:half_length]}...{line[-half_length:]}"
    if line.isprintable():
        return line
    return "".join(
        ascii(char)[1:-1] if unicodedata.category(char) in _UNPRINTABLE_CATEGORIES else char for char in line
    )


def printable_path(path: str | os.PathLike[str]) -> str:
    """Return a path as one printable line of limited length for a message."""
    return printable_text(os.fspath(path), MAX_PATH_LENGTH)


def format_bytes(size: float) -> str:
    """Format a number of bytes with three significant digits in kB, MB, GB or TB, as in "23 kB"."""
    power = min(4, max(1, int(math.log(max(size, 1), 1000))))
    return f"{size / 1000**power:.3g} {' kMGT'[power]}B"


def format_duration(seconds: float) -> str:
    """Format a duration (s) in s, min, hours or days, as in "1.5 min"."""
    for limit, unit in ((60, "s"), (60, "min"), (48, "hours")):
        if seconds < limit:
            return f"{seconds:.2g} {unit}"
        seconds /= limit if unit != "hours" else 24
    return f"{seconds:.3g} days"
