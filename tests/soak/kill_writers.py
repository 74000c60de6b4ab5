"""Kill processes at random moments while they write one result: commands, Dask workers, and parts of a run.

After each kill, the script checks that no finished repetition is lost or changed, that no block file has changed, and
that no later command computes a finished repetition again. After several kills, it compares a sample of repetitions
with a computation without kills, checks that partial files are removed, and starts with a new directory.
"""

from __future__ import annotations

import argparse
import collections
import json
import os
import random
import secrets
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from pathlib import Path

import numpy as np
from stiction import Study
from stiction.solve import member_solution, store
from stiction.solve.store import decode_members

DEFAULT_NUM_KILLS = 200
KILLS_PER_DIRECTORY = 20  # small, so that many kills happen while a directory is new
MAX_CHECKED_REPETITIONS = 300
EXECUTORS_BY_KIND = {"writers": ("threads", "scheduler"), "parts": ("parts",)}
MAX_WAITING_SECONDS = 600.0

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 2},
        "surfaces.points": 1000,
        "surfaces.extent": "4 um",
        "surfaces.directions": 8,
        "surfaces.frequencies": 12,
        "contact.approach.count": 4,
        "ensemble.repetitions": 200_000,
        "figures.draw": [],
    }
)

# Make each process record the repetitions that it computes, write small blocks, and sleep around file operations.
SITECUSTOMIZE_CODE = """
import os, sys
if "storm" in os.environ and "stiction" in " ".join(sys.orig_argv):
    import pathlib, random, time
    from stiction.solve import runner
    runner.TARGET_BLOCK_TIME = 0.02
    sums = runner.compute_member_arrays
    def record(study, member):
        with open(os.environ["storm"], "ab", buffering=0) as file:
            file.write(f"{member} {os.getpid()}\\n".encode())
        time.sleep(1e-3)  # slows the computation, so that each file can be checked
        return sums(study, member)
    runner.compute_member_arrays = record
    def add_delays(function, seconds):
        def call_with_delays(*arguments, **options):
            time.sleep(random.expovariate(1 / seconds))
            result = function(*arguments, **options)
            time.sleep(random.expovariate(1 / seconds))
            return result
        return call_with_delays
    for name, seconds in (("replace", 0.02), ("write_bytes", 0.01), ("mkdir", 0.05), ("touch", 0.05)):
        setattr(pathlib.Path, name, add_delays(getattr(pathlib.Path, name), seconds))
"""


class WriterKillTest:
    """Result directory, the processes that write it, and a record of finished repetitions and kills."""

    def __init__(self, directory: Path, random_generator: random.Random, executors: tuple[str, ...]) -> None:
        self.directory, self.random, self.executors = directory, random_generator, executors
        self.num_repetitions = STUDY.ensemble.repetitions
        self.time_to_first_write = 1.0  # s, latest measured value
        self.result_directory = directory / "out"
        self.log_file = directory / "computed"
        (directory / "site").mkdir()
        (directory / "site" / "sitecustomize.py").write_text(SITECUSTOMIZE_CODE)
        (directory / "s.toml").write_text(STUDY.to_toml())
        self.environment = os.environ | {"PYTHONPATH": str(directory / "site"), "storm": str(self.log_file)}
        self.known_files: dict[str, tuple[int, int]] = {}
        self.checksums: dict[int, int] = {}
        # repetitions that were finished when a command started, by the process id of the command
        self.finished_at_start: dict[int, frozenset[int]] = {}
        self.kills: collections.Counter[str] = collections.Counter()
        self.num_partial_files = 0
        self.num_computed = 0
        self.processes: list[subprocess.Popen[bytes]] = []
        self.dask_processes: list[subprocess.Popen[bytes]] = []
        self.address = ""

    def start_command(self, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "stiction", "run", "s.toml", "--output", "out", *options]
        command += ["--set", f"ensemble.repetitions={self.num_repetitions}"]
        finished_repetitions = frozenset(self.read_finished_repetitions())
        process = self.start_process(command)
        self.finished_at_start[process.pid] = finished_repetitions
        return process

    def start_process(self, command: list[str]) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            command, cwd=self.directory, env=self.environment, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=(self.directory / "output").open("ab"),
        )  # fmt: skip
        self.processes.append(process)
        return process

    def wait_for_write(self, *processes: subprocess.Popen[bytes]) -> None:
        """Wait for a random time, which ends before the next write or at most half a second after it."""
        blocks_before, start_time = self.count_blocks(), time.monotonic()
        is_early = self.random.random() < 0.3
        end_time = start_time + (
            self.random.uniform(0, 1.2 * self.time_to_first_write) if is_early else MAX_WAITING_SECONDS
        )
        while time.monotonic() < end_time and self.count_blocks() == blocks_before:
            assert all(process.poll() is None for process in processes), (
                f"a run ended by itself: {self.read_last_output()}"
            )
            time.sleep(0.002)
        if not is_early:
            assert self.count_blocks() != blocks_before, "nothing is written"
            self.time_to_first_write = time.monotonic() - start_time
            time.sleep(self.random.uniform(0, 0.5))

    def read_last_output(self) -> str:
        return (self.directory / "output").read_text()[-1000:]

    def count_blocks(self) -> int:
        return sum(1 for _ in (self.result_directory / store.BLOCKS_DIRECTORY).glob("*.nc"))

    def kill(self, target: str, process: subprocess.Popen[bytes]) -> None:
        assert process.poll() is None, f"{target} ended by itself: {process.returncode}: {self.read_last_output()}"
        if self.random.random() < 0.2:
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
        process.kill()
        process.wait()
        self.kills[target] += 1
        self.num_partial_files += bool(list(self.result_directory.rglob(f".stiction-*-{process.pid}-*.partial")))
        self.check_blocks()

    def run_and_kill(self) -> None:
        self.num_repetitions += self.random.choice([0, self.random.randint(1, 1000)])
        executor = self.random.choice(self.executors)
        match executor:
            case "threads":
                process = self.start_command("--workers", "2")
                self.wait_for_write(process)
                self.kill(executor, process)
            case "scheduler":
                self.start_scheduler()
                process = self.start_command("--scheduler", self.address)
                self.wait_for_write(process)
                if self.random.random() < 0.5:
                    self.kill("a worker of Dask", self.dask_processes.pop())
                    self.add_worker()
                    time.sleep(self.random.uniform(0, 3))
                self.kill("--scheduler", process)
            case "parts":
                part_processes = {i: self.start_command("--part", f"{i}/4", "--workers", "1") for i in range(1, 5)}
                self.wait_for_write(*part_processes.values())
                restarted_part = self.random.randint(1, 4)
                self.kill("--part", part_processes[restarted_part])
                part_processes[restarted_part] = self.start_command("--part", f"{restarted_part}/4", "--workers", "1")
                self.wait_for_write(*part_processes.values())
                for part_number in self.random.sample(sorted(part_processes), 4):
                    self.kill("--part", part_processes[part_number])
                    time.sleep(self.random.uniform(0, 0.3))

    def start_scheduler(self) -> None:
        if self.address:
            return
        file = self.directory / "scheduler.json"
        dask_program = str(Path(sys.executable).with_name("dask"))
        options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
        self.dask_processes = [self.start_process([dask_program, "scheduler", *options])]
        while not file.exists():
            time.sleep(0.1)
        self.address = json.loads(file.read_text())["address"]
        for _ in range(2):
            self.add_worker()

    def add_worker(self) -> None:
        code = "import stiction.solve.runner; from distributed.cli.dask_worker import main; main()"
        options = [self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        self.dask_processes.append(self.start_process([sys.executable, "-c", code, *options]))

    def read_finished_repetitions(self) -> list[int]:
        try:
            return store.open_stored_result(self.result_directory).finished_members.tolist()
        except store.StoreError:
            assert not self.checksums
            return []

    def check_blocks(self) -> None:
        """Check that blocks are complete and unchanged, and that commands computed no finished repetition again."""
        if not (self.result_directory / store.BLOCKS_DIRECTORY).exists():
            assert not self.checksums
            return
        current_files = {
            file.name: (file.stat().st_ino, file.stat().st_mtime_ns)
            for file in (self.result_directory / store.BLOCKS_DIRECTORY).glob("[0-9]*.nc")
        }
        assert self.known_files.keys() <= current_files.keys(), (
            f"lost: {sorted(self.known_files.keys() - current_files.keys())[:5]}"
        )
        for name in current_files.keys() - self.known_files.keys():
            content = (self.result_directory / store.BLOCKS_DIRECTORY / name).read_bytes()
            assert name.endswith(f"-{zlib.crc32(content):08x}.nc"), f"{name} is torn"
            members = decode_members(content)
            for member_index, number in enumerate(members.numbers.tolist()):
                block_checksum = compute_checksum([values[:, :, member_index] for values in members.arrays.values()])
                assert self.checksums.setdefault(number, block_checksum) == block_checksum, "other bits than before"
        self.known_files |= current_files
        assert self.checksums.keys() <= set(self.read_finished_repetitions())
        lines = self.log_file.read_text().splitlines() if self.log_file.exists() else []
        for number, process_id in map(str.split, lines[self.num_computed :]):
            # Check only processes of commands, because a Dask worker may continue the tasks of killed commands.
            if int(process_id) in self.finished_at_start:
                assert int(number) not in self.finished_at_start[int(process_id)], f"{number} was computed again"
        self.num_computed = len(lines)

    def check_and_summarise_result(self) -> str:
        self.check_blocks()
        for number in self.random.sample(sorted(self.checksums), min(MAX_CHECKED_REPETITIONS, len(self.checksums))):
            sums = member_solution.compute_member_arrays(STUDY, number)
            assert compute_checksum(list(sums.values())) == self.checksums[number], (
                f"repetition {number} has other bits"
            )
        for process in self.dask_processes:
            process.kill()
            process.wait()
        store.create_or_open_result(
            self.result_directory, STUDY.with_changes({"ensemble.repetitions": self.num_repetitions})
        )
        partial_files = [file for file in self.result_directory.rglob("*.partial") if str(os.getpid()) not in file.name]
        assert not partial_files, f"left: {partial_files[:3]}"
        errors = [line for line in (self.directory / "output").read_text().splitlines() if "Error" in line]
        return (
            f"{len(self.checksums)} repetitions finished in {len(self.known_files)} files; "
            f"{self.num_computed} computed; "
            f"{self.num_partial_files} kills left something half-written; none lost; same bits"
            + (f"; {errors[0]}" if errors else "")
        )


def compute_checksum(values: list[np.ndarray]) -> int:
    return zlib.crc32(b"".join(np.ascontiguousarray(value).tobytes() for value in values))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=DEFAULT_NUM_KILLS, help="of each kind")
    parser.add_argument(
        "--kind", choices=EXECUTORS_BY_KIND, action="append", help="of writers that write; both by default"
    )
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the moments")
    arguments = parser.parse_args()
    for kind in arguments.kind or EXECUTORS_BY_KIND:
        kills: collections.Counter[str] = collections.Counter()
        random_generator = random.Random(arguments.seed)
        while kills.total() < arguments.kills:
            with tempfile.TemporaryDirectory(prefix="stiction-storm-") as directory:
                test = WriterKillTest(Path(directory), random_generator, EXECUTORS_BY_KIND[kind])
                try:
                    while test.kills.total() < KILLS_PER_DIRECTORY and (kills + test.kills).total() < arguments.kills:
                        test.run_and_kill()
                        test.check_blocks()
                    kills = kills + test.kills
                    print(f"storm: {kind}: {kills.total()} kills; {test.check_and_summarise_result()}", flush=True)
                finally:
                    for process in test.processes:
                        process.kill()
                        process.wait()
        counts = ", ".join(f"{count} {target}" for target, count in kills.most_common())
        print(f"storm: {kind}: seed {arguments.seed}; killed: {counts}", flush=True)


if __name__ == "__main__":
    main()
