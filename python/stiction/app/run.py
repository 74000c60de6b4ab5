"""Begin the server in a private folder, open a browser, and end when no window is open any more."""

from __future__ import annotations

import asyncio
import fcntl
import os
import resource
import shutil
import signal
import socket
import stat
import tempfile
import webbrowser
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import uvicorn
from uvicorn.protocols.http.h11_impl import H11Protocol

from stiction.app.server import Server

PREFIX = "stiction-app-"
LOCK = "lock"

ALONE = 90.0
"""Seconds without a question of a window after which the server ends; browsers let a hidden one ask once a minute."""

FIRST = 600.0  # seconds that it waits for the first one
MOST_CONNECTIONS = 100  # at a time
PATIENCE = 5.0  # seconds for the head of a request
SHARE = 0.75  # of the memory of the machine, that the server may take, and each of its commands


class PatientProtocol(H11Protocol):
    """HTTP/1.1 on a bounded number of connections, each of which asks for one thing, and soon."""

    begun = 0.0

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        """Take a connection, in place of the one that has been silent for longest where there are too many."""
        super().connection_made(transport)
        self.begun = self.loop.time()
        if len(self.connections) > MOST_CONNECTIONS:
            silent: Any = [each for each in self.connections if not each.cycle]  # type: ignore[union-attr]
            min(silent, key=lambda each: each.begun).transport.abort()
        self.loop.call_later(PATIENCE, lambda: None if self.cycle else transport.abort())


@contextmanager
def private_folder() -> Iterator[Path]:
    """A folder that nobody else reads, gone afterwards; and those of servers that were killed are gone now.

    Whoever is alive holds the lock in its folder, and the system lets go of it for those who are not.
    """
    for left in Path(tempfile.gettempdir()).glob(f"{PREFIX}*"):
        with suppress(OSError), _own(left / LOCK) as lock:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(left, ignore_errors=True)
    while True:
        folder = Path(tempfile.mkdtemp(prefix=PREFIX)).resolve()
        with (folder / LOCK).open("wb") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)
            if os.fstat(lock.fileno()).st_nlink == 0:  # another one that begins took it for that of a dead one
                continue
            try:
                yield folder
            finally:
                shutil.rmtree(folder, ignore_errors=True)
            return


@contextmanager
def _own(path: Path) -> Iterator[int]:
    """A regular file of this user, opened; an OSError at once if it is anything else, such as a pipe or a link."""
    file = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK)
    try:
        status = os.fstat(file)
        if not stat.S_ISREG(status.st_mode) or status.st_uid != os.geteuid():
            raise PermissionError(path)
        yield file
    finally:
        os.close(file)


def run(*, say: Callable[[str], None], keep: bool = False, demo: bool = False) -> None:
    """Serve the page until its last window has been closed for a while, or somebody interrupts.

    Parameters
    ----------
    say : callable
        What tells the person who began it.
    keep : bool
        Whether it goes on without a window.
    demo : bool
        Whether the page begins with two surfaces of its own.
    """
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
        serving.should_exit = True

    for number in (signal.SIGHUP, signal.SIGTERM, signal.SIGINT):
        loop.add_signal_handler(number, end)
    # Our own handlers: uvicorn would raise a signal once more, and the folder would stay.
    serving.capture_signals = suppress  # type: ignore[method-assign,assignment]
    server.asked = loop.time()
    task = asyncio.create_task(serving.serve(sockets=[listening]))
    await asyncio.to_thread(webbrowser.open, address)
    _limit_memory()  # not of the browser
    while not task.done():
        await asyncio.wait([task], timeout=0.5)
        if not keep and is_left(server, loop.time()):
            end()


def _limit_memory() -> None:
    """Leave some of the memory to others, whatever a command is asked for."""
    memory = int(SHARE * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    most = resource.getrlimit(resource.RLIMIT_AS)[1]
    resource.setrlimit(resource.RLIMIT_AS, (memory if most == resource.RLIM_INFINITY else min(memory, most), most))


def is_left(server: Server, now: float) -> bool:
    """Whether no window has asked for so long that there is none any more, or none has come."""
    return now - server.asked > (ALONE if server.has_window else FIRST)
