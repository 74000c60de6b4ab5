"""Exceptions for invalid arguments, and for solvers that find no solution."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any


class _PlaceholderValues(dict[str, Any]):
    """Mapping from the placeholders in an error message to the texts that replace them.

    Any other placeholder is replaced by its argument's name.
    """

    def __init__(self, values: dict[str, Any], translate: Callable[[str], str]) -> None:
        super().__init__(values)
        self._translate = translate

    def __missing__(self, name: str) -> str:
        return self._translate(name)


class ArgumentError(ValueError):
    """Error raised for an invalid argument.

    Its message contains placeholders for values and argument names.
    """

    def __init__(self, message: str, **values: Any) -> None:
        super().__init__(message.format_map(_PlaceholderValues(values, str)))
        self._message, self._values = message, values

    @classmethod
    def for_argument(cls, name: str, reason: str) -> ArgumentError:
        """Create an error whose message is an argument name followed by `reason`, such as "must be positive"."""
        return cls(f"{{{name}}} {{reason}}", reason=reason)

    def translated_message(self, translate: Callable[[str], str]) -> str:
        """Return the error message with other argument names, for example with the names of command-line options."""
        return self._message.format_map(_PlaceholderValues(self._values, translate))


class NoSolutionError(RuntimeError):
    """Error raised if a solver finds no solution.

    Callers that can continue without the solution catch only this error. All other errors end the computation, for
    example if a thread cannot start.
    """
