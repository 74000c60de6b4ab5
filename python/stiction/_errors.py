"""Exceptions for invalid arguments and failed solvers, and a check for an incompatible compiled core."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

UNFIT_CORE_MESSAGE = (
    "the compiled part of stiction (_core) does not fit its Python files: build it again with ./dev setup or "
    "pip install ."
)


def is_caused_by_unfit_core(text: str) -> bool:
    """Return whether an error message shows that the compiled core lacks a function or class that the package needs.

    Only the text is reliable, because an error from a worker process lacks the attributes that name the module.
    """
    return re.search(r"'stiction\._core['.]", text) is not None


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
