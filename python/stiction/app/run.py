"""Begin the server in a private folder, open a browser, and end when no window is open any more."""

from __future__ import annotations

import asyncio
import signal
import socket
import tempfile
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import uvicorn

from stiction.app.server import Server

PREFIX = "stiction-app-"

ALONE = 90.0
"""Seconds without a question of a window after which the server ends; browsers let a hidden one ask once a minute."""

FIRST = 600.0  # seconds that it waits for the first one


def run(*, say: Callable[[str], None], keep: bool = False, demo: bool = False) -> None:
    """Serve the page until its last window has been closed for a while, unless it is kept, or somebody interrupts."""
    with tempfile.TemporaryDirectory(prefix=PREFIX) as folder, socket.create_server(("127.0.0.1", 0)) as listening:
        server = Server(Path(folder).resolve(), Path.cwd(), listening.getsockname()[1], has_demo=demo)
        address = f"{server.origin}/?token={server.token}"
        config = uvicorn.Config(
            server, http="h11", ws="none", lifespan="on", log_config=None, access_log=False,
            proxy_headers=False, server_header=False, timeout_graceful_shutdown=2, h11_max_incomplete_event_size=2**14,
        )  # fmt: skip
        serving = uvicorn.Server(config)
        say(f"{address}\nopens in one browser, once; Ctrl-C ends it")
        with suppress(KeyboardInterrupt):
            asyncio.run(_serve(serving, server, listening, address, keep))


async def _serve(serving: uvicorn.Server, server: Server, listening: socket.socket, address: str, keep: bool) -> None:
    loop = asyncio.get_running_loop()

    def end() -> None:
        serving.should_exit = True

    for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, end)
    # Our own handlers: uvicorn would raise a signal once more, and the folder would stay.
    serving.capture_signals = suppress  # type: ignore[method-assign,assignment]
    server.asked = loop.time()
    task = asyncio.create_task(serving.serve(sockets=[listening]))
    await asyncio.to_thread(webbrowser.open, address)
    while not task.done():
        await asyncio.wait([task], timeout=0.5)
        if not keep and is_left(server, loop.time()):
            end()


def is_left(server: Server, now: float) -> bool:
    """Whether no window has asked for so long that there is none any more, or none has come."""
    return now - server.asked > (ALONE if server.has_window else FIRST)
