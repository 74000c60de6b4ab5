"""HTTP with patience: connections are few, and who does not finish a request in time is let go."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

MOST = 100
"""Connections at a time; a window needs up to six."""

PATIENCE = 5.0
"""Seconds for the head of a request."""


class PatientProtocol(H11Protocol):
    """HTTP/1.1 on a bounded number of connections, each of which asks for something soon."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection, or refuse it where there are too many."""
        super().connection_made(transport)
        if len(self.connections) > MOST:
            transport.abort()
        else:
            self._look(None)

    def _look(self, last: Any) -> None:
        """End a connection that waits for the same request as when it was looked at last."""
        if self.transport.is_closing():
            return
        waiting = (self.cycle or self) if self.cycle is None or self.cycle.response_complete else None
        if waiting is not None and waiting is last:
            self.transport.abort()
        else:
            self.loop.call_later(PATIENCE, self._look, waiting)
