"""Cached properties without locks."""

from __future__ import annotations

import functools
import sys
from functools import cached_property as cached_property
from typing import TYPE_CHECKING, Any

if not TYPE_CHECKING and sys.version_info < (3, 12):

    class cached_property(functools.cached_property):  # noqa: N801
        """`functools.cached_property` of Python 3.12 and later.

        That of Python 3.11 holds a lock of the class while it computes: threads with different objects wait for each
        other, and a child that is forked meanwhile waits for ever.
        """

        def __get__(self, instance: Any, owner: type[Any] | None = None) -> Any:
            """Return the value of an object, computed the first time."""
            if instance is None:
                return self
            name, values = self.attrname, instance.__dict__
            assert name is not None, "the class has given it its name"
            if name not in values:
                values[name] = self.func(instance)
            return values[name]
