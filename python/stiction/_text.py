"""Text that others wrote, made fit to be shown on a terminal."""

from __future__ import annotations

import math
import os
import unicodedata

LONGEST_NAME = 300  # characters of a path in a message
LONGEST_WORD = 80  # characters of a key, a version or a name in a message
LONGEST_LINE = 1000  # characters of a line of a message, whatever is in it

# Control characters, formats such as a change of the direction of writing, surrogates, and separators of lines.
_UNFIT = {"Cc", "Cf", "Cs", "Zl", "Zp"}


def printable(text: object, most: int = LONGEST_WORD) -> str:
    r"""Text on one line: what a terminal would obey is spelt out, and what is too long is cut in its middle.

    Examples
    --------
    >>> printable("a\nb\x1b[31m")
    'a\\nb\\x1b[31m'
    >>> printable("a" * 10 + "b" * 10, most=11)
    'aaaa...bbbb'
    """
    said = str(text)
    if len(said) > most:
        half = (most - 3) // 2
        said = f"{said[:half]}...{said[-half:]}"
    if said.isprintable():
        return said
    return "".join(ascii(each)[1:-1] if unicodedata.category(each) in _UNFIT else each for each in said)


def named(path: str | os.PathLike[str]) -> str:
    """Name of a file or directory, for a message."""
    return printable(os.fspath(path), LONGEST_NAME)


def bytes_text(size: float) -> str:
    """A number of bytes in three digits: "23 kB"."""
    power = min(4, max(1, int(math.log(max(size, 1), 1000))))
    return f"{size / 1000**power:.3g} {' kMGT'[power]}B"


def duration_text(seconds: float) -> str:
    """Seconds in a unit that suits them: "1.5 min"."""
    for most, unit in ((60, "s"), (60, "min"), (48, "hours")):
        if seconds < most:
            return f"{seconds:.2g} {unit}"
        seconds /= most if unit != "hours" else 24
    return f"{seconds:.3g} days"
