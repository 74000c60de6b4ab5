"""Errors of arguments, named as function parameters or as command-line options, and errors of solvers."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class _MessageValues(dict[str, Any]):
    """Mapping from message placeholders to values. An unknown placeholder is treated as the name of an argument."""

    def __init__(self, values: dict[str, Any], translate: Callable[[str], str]) -> None:
        super().__init__(values)
        self._translate = translate

    def __missing__(self, name: str) -> str:
        return self._translate(name)


class ArgumentError(ValueError):
    """Error for an invalid argument. Placeholders in its message are replaced by values or by argument names."""

    def __init__(self, message: str, **values: Any) -> None:
        super().__init__(message.format_map(_MessageValues(values, str)))
        self._message, self._values = message, values

    def translated_message(self, translate: Callable[[str], str]) -> str:
        """Return the message with argument names translated, for example to command-line options."""
        return self._message.format_map(_MessageValues(self._values, translate))


class NoSolutionError(RuntimeError):
    """Error raised if a solver finds no solution.

    Callers that go on without the solution catch only this error. All other errors end the computation, for example
    if a thread cannot start.
    """
