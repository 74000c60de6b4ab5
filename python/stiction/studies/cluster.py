"""The workers of a Dask scheduler as an executor, with its failures as errors that a user can act on."""

from __future__ import annotations

import contextlib
import re
import warnings
from collections.abc import Iterator
from concurrent.futures import CancelledError, Executor
from typing import Any

from stiction._text import LONGEST_NAME, printable
from stiction._units import shortened

PATIENCE = "15s"  # how long a scheduler may take to answer


class ClusterError(ValueError):
    """A cluster that is not there, or cannot compute."""


@contextlib.contextmanager
def connected(address: str) -> Iterator[Executor]:
    """Connect to the workers of a scheduler that runs already, by an address such as "tcp://host:8786".

    Raises a `ClusterError` if distributed is not installed, no scheduler answers at the address or it goes away, or the
    workers keep dying.
    """
    distributed = _distributed()
    if not re.fullmatch(r"([a-z]+://)?[^\s/:]+:[0-9]{1,5}|([a-z]+://)\[[0-9a-fA-F:]+\]:[0-9]{1,5}", address):
        raise ClusterError(f"a Dask scheduler has an address such as tcp://host:8786, not {shortened(address)}")
    try:
        client = distributed.Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:
        raise ClusterError(
            f"no Dask scheduler answers at {shortened(address)}: {printable(str(error).splitlines()[0], LONGEST_NAME)}"
        ) from None
    with client, _failures(distributed):
        if not client.nthreads():
            warnings.warn(f"the scheduler at {shortened(address)} has no workers yet; waiting for them", stacklevel=3)
        yield client.get_executor()


def _distributed() -> Any:
    try:
        import distributed
    except ImportError:
        raise ClusterError("a cluster needs the package distributed: pip install 'stiction[cluster]'") from None
    return distributed


@contextlib.contextmanager
def _failures(distributed: Any) -> Iterator[None]:
    try:
        yield
    except distributed.scheduler.KilledWorker as error:
        raise ClusterError(f"a block was given up, because every worker that computed it died: {error}") from None
    except CancelledError:
        raise ClusterError("the scheduler is gone; what was finished is kept, and the same command goes on") from None
