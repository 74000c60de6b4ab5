"""Number of threads for computations."""

from __future__ import annotations

import os


def num_usable_cores() -> int:
    """Return the number of cores that this process may use."""
    num_cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count()
    return num_cores or 1
