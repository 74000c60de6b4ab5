"""Begin the server in a private folder, open a browser, and end when no window is open any more."""

from __future__ import annotations

import asyncio
import fcntl
import shutil
import signal
import socket
import tempfile
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path

import uvicorn

from stiction.app.protocol import PatientProtocol
from stiction.app.server import Server

PREFIX = "stiction-app-"
LOCK = "lock"

ALONE = 60.0
"""Seconds without a window after which the server ends."""

FIRST = 600.0
"""Seconds that it waits for the first one."""


@contextmanager
def private_folder() -> Iterator[Path]:
    """A folder that nobody else reads, gone afterwards; and those of servers that were killed are gone now.

    Whoever is alive holds the lock in its folder, and the system lets go of it for those who are not.
    """
    for left in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError), (left / LOCK).open("rb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(left, ignore_errors=True)
    folder = Path(tempfile.mkdtemp(prefix=PREFIX)).resolve()
    with (folder / LOCK).open("wb") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            yield folder
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def run(*, say: Callable[[str], None], keep: bool = False, demo: bool = False) -> None:
    """Serve the page until its last window has been closed for a minute, or somebody interrupts."""
    with private_folder() as root, socket.create_server(("127.0.0.1", 0)) as listening:
        server = Server(root, Path.cwd(), listening.getsockname()[1], has_demo=demo)
        address = f"{server.origin}/?token={server.token}"
        config = uvicorn.Config(
            server, http=PatientProtocol, ws="none", lifespan="on", log_config=None, access_log=False,
            proxy_headers=False, server_header=False, timeout_graceful_shutdown=2, h11_max_incomplete_event_size=2**14,
        )  # fmt: skip
        serving = uvicorn.Server(config)
        say(f"{address}\nopens in one browser, once; Ctrl-C ends it")
        with suppress(KeyboardInterrupt):
            asyncio.run(_serve(serving, server, listening, address, keep))


async def _serve(serving: uvicorn.Server, server: Server, listening: socket.socket, address: str, keep: bool) -> None:
    loop = asyncio.get_running_loop()

    def end() -> None:
        server.closed.set()
        serving.should_exit = True

    for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, end)
    # Our own handlers: uvicorn would raise a signal once more, and the folder would stay.
    serving.capture_signals = suppress  # type: ignore[method-assign,assignment]
    task = asyncio.create_task(serving.serve(sockets=[listening]))
    await asyncio.to_thread(webbrowser.open, address)
    seen, patience = loop.time(), FIRST
    while not task.done():
        await asyncio.wait([task], timeout=0.5)
        if server.windows:
            seen, patience = loop.time(), ALONE
        elif not keep and loop.time() - seen > patience:
            end()
