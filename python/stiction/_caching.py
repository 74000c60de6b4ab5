"""`cached_property`: computed attribute of an object, cached without a lock."""

from __future__ import annotations

import functools
import sys
from functools import cached_property as cached_property
from typing import TYPE_CHECKING, Any

if not TYPE_CHECKING and sys.version_info < (3, 12):

    class cached_property(functools.cached_property):  # noqa: N801
        """Cached property without the lock that `functools.cached_property` has in Python 3.11.

        In Python 3.11, `functools.cached_property` locks its class while it computes. Threads that use different
        objects then wait for each other, and a child process that is forked in the meantime waits forever.
        """

        def __get__(self, instance: Any, owner: type[Any] | None = None) -> Any:
            """Return the value of the property, which is computed on the first access and then cached."""
            if instance is None:
                return self
            name, values = self.attrname, instance.__dict__
            assert name is not None, "set by __set_name__"
            if name not in values:
                values[name] = self.func(instance)
            return values[name]
