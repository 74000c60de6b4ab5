"""Regular expressions that are compiled when they are first used."""

from __future__ import annotations

import re
from collections.abc import Callable

from stiction._caching import cached_property


class LazyPattern:
    """Regular expression that is compiled when it is first used.

    Most files need few of the long patterns that describe headers. Compiling all of them would take longer than reading
    a small file.
    """

    def __init__(self, pattern: str, flags: int | re.RegexFlag = 0) -> None:
        self.pattern, self.flags = pattern, flags

    @cached_property
    def compiled_pattern(self) -> re.Pattern[str]:
        """Regular expression object, compiled on first access."""
        return re.compile(self.pattern, self.flags)

    def match(self, text: str) -> re.Match[str] | None:
        """Return the match of the pattern at the start of a text, or None if the pattern does not match there."""
        return self.compiled_pattern.match(text)

    def fullmatch(self, text: str) -> re.Match[str] | None:
        """Return the match of the pattern with a whole text, or None if the pattern does not match the whole text."""
        return self.compiled_pattern.fullmatch(text)

    def search(self, text: str) -> re.Match[str] | None:
        """Return the first match of the pattern in a text, or None if there is no match."""
        return self.compiled_pattern.search(text)

    def findall(self, text: str) -> list[str]:
        """Return all matches in a text. If the pattern has a group, return the text in this group for each match."""
        return self.compiled_pattern.findall(text)

    def split(self, text: str) -> list[str]:
        """Split a text at every match of the pattern, and return the parts of the text."""
        return self.compiled_pattern.split(text)

    def sub(self, replacement: str | Callable[[re.Match[str]], str], text: str) -> str:
        """Replace all matches of the pattern in a text."""
        return self.compiled_pattern.sub(replacement, text)
