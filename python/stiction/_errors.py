"""Errors that call arguments by their names, in a function, or by their options, in a command."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class _Names(dict[str, Any]):
    """Values of a sentence by name; every other name is an argument, called as a function says."""

    def __init__(self, values: dict[str, Any], called: Callable[[str], str]) -> None:
        super().__init__(values)
        self._called = called

    def __missing__(self, name: str) -> str:
        return self._called(name)


class ArgumentError(ValueError):
    """A wrong argument: a sentence with `{name}` for each argument that it speaks of, beside its own values."""

    def __init__(self, sentence: str, **values: Any) -> None:
        super().__init__(sentence.format_map(_Names(values, str)))
        self._sentence, self._values = sentence, values

    def said(self, called: Callable[[str], str]) -> str:
        """The sentence with arguments called otherwise, as by their options on a command line."""
        return self._sentence.format_map(_Names(self._values, called))
