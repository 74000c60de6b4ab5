"""Measure the memory use of commands on results that are larger than the available memory.

Each command runs in a new process. The results have 10 000 repetitions of small surfaces, and 200 repetitions of
figure6.
"""

import contextlib
import subprocess
import sys
import tempfile
import time
from pathlib import Path

STUDY_ARGUMENTS_BY_TITLE = {
    "10 000 of quick": ["quick", "ensemble.repetitions=10000", "surfaces.points=500", "surfaces.directions=4",
                        "surfaces.frequencies=6"],
    "200 of figure6": ["figure6", "ensemble.repetitions=200"],
}  # fmt: skip
RESULT_OPENING_CODE = "from stiction import *; r = open_result('out');"
COMMAND_ARGUMENTS_BY_NAME = {
    "run": [],
    "friction_map": [RESULT_OPENING_CODE + "friction_map(r, [0.001, 0.01])"],
    "area_map": [RESULT_OPENING_CODE + "area_map(r, [0.001, 0.01])"],
    "stiffness_map": [RESULT_OPENING_CODE + "stiffness_map(r, [0.001, 0.01])"],
    "plot": ["plot", "out"],
    "report": ["report", "out"],
    "export": ["export", "out", "out.nc"],
    "info": ["info", "out"],
    "at": ["at", "out", "--load", "1 uN", "--d", "1.3", "--mu0", "0.4"],
}


def measure_peak_memory(directory: str, arguments: list[str]) -> float:
    """Return the peak memory (MiB) of a command together with its child processes."""
    process = subprocess.Popen([sys.executable, *arguments], cwd=directory, stdout=subprocess.DEVNULL)
    peak_memory = 0.0
    while process.poll() is None:
        peak_memory = max(peak_memory, sum(map(resident_memory, find_process_tree(process.pid))))
        time.sleep(0.02)
    assert process.returncode == 0, arguments
    return peak_memory / 1024


def find_process_tree(pid: int) -> list[int]:
    """Return the ids of a process and all its descendants."""
    parents = {}
    for stat_file in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            parents[int(stat_file.parent.name)] = int(stat_file.read_text().rpartition(")")[2].split()[1])
    process_ids = [pid]
    for process_id in process_ids:
        process_ids += [child for child, parent in parents.items() if parent == process_id]
    return process_ids


def resident_memory(pid: int) -> int:
    """Return the resident memory (KiB) of a process, including shared pages."""
    with contextlib.suppress(OSError, StopIteration):
        lines = Path(f"/proc/{pid}/status").read_text().splitlines()
        return int(next(line for line in lines if line.startswith("VmRSS")).split()[1])
    return 0


def run_benchmark() -> list[tuple[str, str]]:
    rows = []
    for study_title, (study_name, *settings) in STUDY_ARGUMENTS_BY_TITLE.items():
        with tempfile.TemporaryDirectory() as directory:
            set_options = [argument for setting in settings for argument in ("--set", setting)]
            for command, arguments in COMMAND_ARGUMENTS_BY_NAME.items():
                if command == "run":
                    command_line = ["-m", "stiction", "run", study_name, "--output", "out", *set_options]
                elif command.endswith("map"):
                    command_line = ["-c", *arguments]
                else:
                    command_line = ["-m", "stiction", *arguments]
                rows.append((f"{study_title}: {command}", f"{measure_peak_memory(directory, command_line):.0f} MiB"))
    return rows
