"""Start and shutdown of the app, which serves its page from a private directory and opens the page in a browser."""

from __future__ import annotations

import asyncio
import logging
import signal
import socket
import tempfile
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any, ClassVar

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from stiction.app.server import Server

WORKING_DIRECTORY_PREFIX = "stiction-app-"

SERVER_IDLE_TIMEOUT = 90.0
"""Time (s) without a request after which the server exits; hidden windows send only one request per minute."""

FIRST_WINDOW_TIMEOUT = 600.0  # s

REQUEST_HEADER_TIMEOUT = 20.0  # s
MAX_IDLE_CONNECTIONS = 64
"""Maximum number of connections without a complete request head. Beyond it, the oldest connection is closed."""


class TimeLimitedConnection(H11Protocol):
    """HTTP connection that is closed if the headers of its request do not arrive in time."""

    idle_timers: ClassVar[dict[TimeLimitedConnection, asyncio.TimerHandle]] = {}

    def connection_made(self, transport: Any) -> None:
        """Start the timeout of a new connection. If more than `MAX_IDLE_CONNECTIONS` are idle, close the oldest."""
        super().connection_made(transport)
        self.idle_timers[self] = self.loop.call_later(REQUEST_HEADER_TIMEOUT, self._abort)
        if len(self.idle_timers) > MAX_IDLE_CONNECTIONS:
            # Two nested `call_soon` calls let the loop read waiting requests before it closes the oldest connection.
            self.loop.call_soon(self.loop.call_soon, self._close_oldest)

    def data_received(self, data: bytes) -> None:
        """Stop the timer of a connection as soon as the headers of its request are complete."""
        super().data_received(data)
        if self.cycle is not None:
            self._cancel_idle_timer()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop the timer of a connection that was closed."""
        self._cancel_idle_timer()
        super().connection_lost(exc)

    def _close_oldest(self) -> None:
        if len(self.idle_timers) > MAX_IDLE_CONNECTIONS:
            next(iter(self.idle_timers))._abort()

    def _cancel_idle_timer(self) -> None:
        if (timer := self.idle_timers.pop(self, None)) is not None:
            timer.cancel()

    def _abort(self) -> None:
        self._cancel_idle_timer()
        self.transport.abort()


def run(*, print_message: Callable[[str], None], keep: bool = False, demo: bool = False) -> None:
    """Serve the page of the app until Ctrl-C, or until no browser shows the page (see `is_server_abandoned`)."""
    with (
        tempfile.TemporaryDirectory(prefix=WORKING_DIRECTORY_PREFIX) as directory,
        socket.create_server(("127.0.0.1", 0)) as listener,
    ):
        server = Server(Path(directory).resolve(), Path.cwd(), listener.getsockname()[1], has_demo=demo)
        address = f"{server.origin}/?token={server.token}"
        config = uvicorn.Config(
            server,
            http=TimeLimitedConnection,
            ws="none",
            backlog=MAX_IDLE_CONNECTIONS,
            lifespan="on",
            log_config=None,
            access_log=False,
            proxy_headers=False,
            server_header=False,
            timeout_graceful_shutdown=2,
            h11_max_incomplete_event_size=2**14,
        )
        # Any program on this machine can send malformed requests, so Uvicorn's warning about them is of no use.
        logging.getLogger("uvicorn.error").setLevel(logging.ERROR)
        http_server = uvicorn.Server(config)
        print_message(f"{address}\nThis address works once, in one browser. Press Ctrl-C to stop the server.")
        with suppress(KeyboardInterrupt):
            asyncio.run(_serve(http_server, server, listener, address, keep))


async def _serve(
    http_server: uvicorn.Server, server: Server, listener: socket.socket, address: str, keep: bool
) -> None:
    loop = asyncio.get_running_loop()

    def request_shutdown() -> None:
        server.shut_down()
        http_server.should_exit = True

    for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, request_shutdown)
    # Uvicorn must not handle signals: it would end the process before the app's directory is removed.
    http_server.capture_signals = suppress  # type: ignore[method-assign,assignment]
    server.last_request_time = loop.time()
    task = asyncio.create_task(http_server.serve(sockets=[listener]))
    await asyncio.to_thread(webbrowser.open, address)
    while not task.done():
        await asyncio.wait([task], timeout=0.5)
        if not keep and is_server_abandoned(server, loop.time()):
            request_shutdown()


def is_server_abandoned(server: Server, current_time: float) -> bool:
    """Return whether the page of the app is no longer open in a browser, or was not opened in time.

    An open page sends requests. Without a request, the time limit is `SERVER_IDLE_TIMEOUT`, or `FIRST_WINDOW_TIMEOUT`
    before the page has been opened.
    """
    return current_time - server.last_request_time > (
        SERVER_IDLE_TIMEOUT if server.has_window else FIRST_WINDOW_TIMEOUT
    )
