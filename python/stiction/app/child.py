"""`python -m stiction.app.child`: a command that ends with whoever began it, and takes no more than its share.

Its arguments are the first line of its standard input, a list as JSON: what takes a second to import is there by then.
It runs until that pipe closes: because somebody pressed "stop", or because the server is gone, by whatever way. Beside
all commands of `stiction` there is `look FILE UNIT SPACING MISSING`: what a scan holds.
"""

import json
import os
import resource
import runpy
import signal
import sys
import threading
import time
from importlib import import_module

from stiction.app.look import look

SHARE = 0.75
"""Of the memory of the machine, that a command may take."""

PATIENCE = 5.0
"""Seconds that a command has to write what it has computed, once it is to end."""

NEEDED = ("scipy.stats", "stiction.studies.netcdf", "stiction.studies.members", "stiction.views.rows")
"""What all commands import that compute or read results."""


def _end_with_the_pipe() -> None:
    while os.read(0, 4096):
        pass
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(PATIENCE)
    os._exit(130)


def main() -> None:
    """Run the command that the first line is."""
    memory = int(SHARE * os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"))
    resource.setrlimit(resource.RLIMIT_AS, (memory, resource.getrlimit(resource.RLIMIT_AS)[1]))
    for name in NEEDED:
        import_module(name)
    if not (line := sys.stdin.buffer.readline()):  # there was nothing to do
        return
    arguments = json.loads(line)
    threading.Thread(target=_end_with_the_pipe, daemon=True).start()
    if arguments[0] == "look":
        print(json.dumps(look(*arguments[1:])))
        return
    sys.argv = ["stiction", *arguments]
    runpy.run_module("stiction", run_name="__main__")


if __name__ == "__main__":
    main()
