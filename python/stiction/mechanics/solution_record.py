"""Record of a half-space computation: the results of finished steps, and the number of solver iterations."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import stiction._core as _core
from stiction._errors import NoSolutionError

StepResult = dict[str, Any]
"""Result of a step, or the state within a step: named arrays, numbers and strings."""


class SolutionRecord:
    """Record that runs the steps of a computation, and counts the iterations of the solver.

    Without adhesion, the counter includes the stiffnesses, each as a fraction of the iterations of its solution.

    A step, such as the contact at one load, depends only on the inputs of the computation and on earlier steps. A
    subclass may therefore store the results of steps: a computation that is repeated reads them instead of computing
    them again, and its result has the same bits.
    """

    def __init__(self) -> None:
        self.counter = _core.IterationCounter()

    def __reduce__(self) -> tuple[type[SolutionRecord], tuple[()]]:
        """Return the constructor call of an empty record, so that copies and pickles of a record contain no steps."""
        return SolutionRecord, ()

    def run_step(self, compute: Callable[[], StepResult], error_type: type[NoSolutionError]) -> StepResult:
        """Return the result of the next step: the stored result or, if none is stored, the computed result.

        If `compute` raises an error of the type `error_type`, the error is stored, and is raised again whenever the
        step is repeated. This class stores nothing.
        """
        return compute()

    def read_state(self) -> StepResult | None:
        """Return the state that an interrupted run stored during the current step, or None if no state is stored."""
        return None

    def offer_state(self, get_state: Callable[[], StepResult]) -> None:
        """Store the state of the current step, but not sooner than a minimum time after the last stored state."""
