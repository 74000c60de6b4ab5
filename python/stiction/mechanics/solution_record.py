"""Record of a half-space computation: the number of iterations, and the results of finished steps."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import stiction._core as _core
from stiction._errors import NoSolutionError

StepResult = dict[str, Any]
"""Named arrays, numbers and strings that are the result of a step, or the state in the middle of a step."""


class SolutionRecord:
    """Record that counts the solver iterations of a computation, and runs its steps.

    A step, such as the contact at one load, depends only on the inputs of the computation and on earlier steps. A
    subclass may therefore store the results of steps: a computation that is repeated reads them instead of computing
    them again, and its result has the same bits.
    """

    def __init__(self) -> None:
        self.counter = _core.IterationCounter()

    def __reduce__(self) -> tuple[type[SolutionRecord], tuple[()]]:
        """Copy and pickle a record as a new record."""
        return SolutionRecord, ()

    def run_step(self, compute: Callable[[], StepResult], error_type: type[NoSolutionError]) -> StepResult:
        """Return the result of the next step. An error of the given type also counts as a result."""
        return compute()

    def read_state(self) -> StepResult | None:
        """Return the stored state of the current step if an earlier computation was interrupted during the step."""
        return None

    def offer_state(self, get_state: Callable[[], StepResult]) -> None:
        """Store the state of the current step if the last state was stored some time ago."""
