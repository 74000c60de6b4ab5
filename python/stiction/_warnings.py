"""Warnings that show the line of the user's program instead of a line of the package."""

from __future__ import annotations

import os
import sys
import warnings
from pathlib import Path

_PACKAGE_PREFIX = str(Path(__file__).parent) + os.sep


def warn_caller(message: str, category: type[Warning] = UserWarning) -> None:
    """Issue a warning that refers to the line outside the package from which the package was called."""
    stack_level = outermost_level = 1
    frame = sys._getframe().f_back
    # The whole stack is searched, because frames of other packages may lie between two frames of this package.
    while frame is not None:
        stack_level += 1
        if frame.f_code.co_filename.startswith(_PACKAGE_PREFIX):
            outermost_level = stack_level
        frame = frame.f_back
    warnings.warn(message, category, stacklevel=outermost_level + 1)
