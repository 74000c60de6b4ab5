"""Text that others wrote, made fit to be shown on a terminal."""

from __future__ import annotations

import os
import unicodedata

LONGEST_NAME = 300
"""Characters of a path in a message."""

LONGEST_WORD = 80
"""Characters of a key, a version or a name in a message."""

LONGEST_LINE = 1000
"""Characters of a line of a message, whatever is in it."""

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
