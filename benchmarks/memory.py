"""How much memory do commands take on results that they do not hold?

Each in a process of its own: 10 000 repetitions as large as quick's, of small surfaces, and 200 of figure6.
"""

import os
import subprocess
import sys
import tempfile

STUDIES = {
    "10 000 of quick": ["quick", "ensemble.repetitions=10000", "surfaces.points=500", "surfaces.directions=4",
                        "surfaces.frequencies=6"],
    "200 of figure6": ["figure6", "ensemble.repetitions=200"],
}  # fmt: skip
MAP = "import sys; from stiction import *; from stiction.studies import store; r = store.read('out/result.zarr');"
COMMANDS = {
    "run": [],
    "friction_map": [MAP + "friction_map(r, [0.001, 0.01])"],
    "area_map": [MAP + "area_map(r, [0.001, 0.01])"],
    "stiffness_map": [MAP + "stiffness_map(r, [0.001, 0.01])"],
    "plot": ["plot", "out"],
    "report": ["report", "out"],
    "export": ["export", "out", "out.nc"],
    "info": ["info", "out"],
}


def peak(folder: str, arguments: list[str]) -> float:
    """MiB of a process."""
    process = subprocess.Popen([sys.executable, *arguments], cwd=folder, stdout=subprocess.DEVNULL)
    _, status, used = os.wait4(process.pid, 0)
    assert status == 0, arguments
    return used.ru_maxrss / 1024


def rows() -> list[tuple[str, str]]:
    found = []
    for what, (name, *changes) in STUDIES.items():
        with tempfile.TemporaryDirectory() as folder:
            sets = [word for change in changes for word in ("--set", change)]
            for command, arguments in COMMANDS.items():
                if command == "run":
                    words = ["-m", "stiction", "run", name, "--output", "out", *sets]
                elif command.endswith("map"):
                    words = ["-c", *arguments]
                else:
                    words = ["-m", "stiction", *arguments]
                found.append((f"{what}: {command}", f"{peak(folder, words):.0f} MiB"))
    return found
