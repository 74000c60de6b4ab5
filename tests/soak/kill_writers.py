"""Kill processes at random moments while they write one result: commands, Dask workers, and parts of a run.

After each kill, the script checks that no finished repetition is lost or changed, that no block file has changed, and
that no later command computes a finished repetition again. After several kills, it compares a sample of repetitions
with a computation without kills, checks that partial files are removed, and starts with a new folder.
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
from stiction.studies import member_solution, store
from stiction.studies.store import decode_members

DEFAULT_KILLS = 200
KILLS_PER_FOLDER = 20  # This number is small, so that many kills happen while a folder is new.
MAX_CHECKED_REPETITIONS = 300  # At most this number of repetitions of a folder is computed again for comparison.
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

# Each process records the repetitions that it computes, writes small blocks, and sleeps around file operations.
SITECUSTOMIZE = """
import os, sys
if "storm" in os.environ and "stiction" in " ".join(sys.orig_argv):
    import pathlib, random, time
    from stiction.studies import runner
    runner.TARGET_BLOCK_TIME = 0.02
    sums = runner.compute_member_sums
    def record(study, member):
        with open(os.environ["storm"], "ab", buffering=0) as file:
            file.write(f"{member} {os.getpid()}\\n".encode())
        time.sleep(1e-3)  # slows the computation, so that each file can be checked
        return sums(study, member)
    runner.compute_member_sums = record
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


class WriterKillRun:
    """Result folder with the processes that write it, and a record of finished repetitions and kills."""

    def __init__(self, folder: Path, random_generator: random.Random, executors: tuple[str, ...]) -> None:
        self.folder, self.random, self.executors = folder, random_generator, executors
        self.repetitions = STUDY.ensemble.repetitions
        self.first_write = 1.0  # seconds from the start of a command to its first block, measured last
        self.path = folder / "out"
        self.log = folder / "computed"
        (folder / "site").mkdir()
        (folder / "site" / "sitecustomize.py").write_text(SITECUSTOMIZE)
        (folder / "s.toml").write_text(STUDY.to_toml())
        self.environment = os.environ | {"PYTHONPATH": str(folder / "site"), "storm": str(self.log)}
        self.files: dict[str, tuple[int, int]] = {}
        self.bits: dict[int, int] = {}  # checksum of each finished repetition
        # repetitions that were finished when a command started, by the process id of the command
        self.finished_at_start: dict[int, frozenset[int]] = {}
        self.kills: collections.Counter[str] = collections.Counter()
        self.num_partial_files = 0
        self.computed = 0
        self.processes: list[subprocess.Popen[bytes]] = []
        self.dask: list[subprocess.Popen[bytes]] = []
        self.address = ""

    def start_command(self, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "stiction", "run", "s.toml", "--output", "out", *options]
        command += ["--set", f"ensemble.repetitions={self.repetitions}"]
        finished = frozenset(self.finished())
        process = self.start_process(command)
        self.finished_at_start[process.pid] = finished
        return process

    def start_process(self, command: list[str]) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            command, cwd=self.folder, env=self.environment, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=(self.folder / "output").open("ab"),
        )  # fmt: skip
        self.processes.append(process)
        return process

    def wait_for_write(self, *processes: subprocess.Popen[bytes]) -> None:
        """Wait a random time that ends before the next write, or up to half a second after it."""
        blocks_before, began = self.count_blocks(), time.monotonic()
        early = self.random.random() < 0.3
        until = began + (self.random.uniform(0, 1.2 * self.first_write) if early else MAX_WAITING_SECONDS)
        while time.monotonic() < until and self.count_blocks() == blocks_before:
            assert all(process.poll() is None for process in processes), f"a run ended by itself: {self.last_output()}"
            time.sleep(0.002)
        if not early:
            assert self.count_blocks() != blocks_before, "nothing is written"
            self.first_write = time.monotonic() - began
            time.sleep(self.random.uniform(0, 0.5))

    def last_output(self) -> str:
        return (self.folder / "output").read_text()[-1000:]

    def count_blocks(self) -> int:
        return sum(1 for _ in (self.path / store.BLOCKS_FOLDER).glob("*.nc"))

    def kill(self, target: str, process: subprocess.Popen[bytes]) -> None:
        assert process.poll() is None, f"{target} ended by itself: {process.returncode}: {self.last_output()}"
        if self.random.random() < 0.2:
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
        process.kill()
        process.wait()
        self.kills[target] += 1
        self.num_partial_files += bool(list(self.path.rglob(f".stiction-*-{process.pid}-*.partial")))
        self.check_blocks()

    def run_and_kill(self) -> None:
        self.repetitions += self.random.choice([0, self.random.randint(1, 1000)])
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
                    self.kill("a worker of Dask", self.dask.pop())
                    self.add_worker()
                    time.sleep(self.random.uniform(0, 3))  # Another worker may start in this time.
                self.kill("--scheduler", process)
            case "parts":
                parts = {i: self.start_command("--part", f"{i}/4", "--workers", "1") for i in range(1, 5)}
                self.wait_for_write(*parts.values())
                again = self.random.randint(1, 4)
                self.kill("--part", parts[again])
                parts[again] = self.start_command("--part", f"{again}/4", "--workers", "1")
                self.wait_for_write(*parts.values())
                for item in self.random.sample(sorted(parts), 4):
                    self.kill("--part", parts[item])
                    time.sleep(self.random.uniform(0, 0.3))

    def start_scheduler(self) -> None:
        if self.address:
            return
        file = self.folder / "scheduler.json"
        binary = str(Path(sys.executable).with_name("dask"))
        options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
        self.dask = [self.start_process([binary, "scheduler", *options])]
        while not file.exists():
            time.sleep(0.1)
        self.address = json.loads(file.read_text())["address"]
        for _ in range(2):
            self.add_worker()

    def add_worker(self) -> None:
        code = "import stiction.studies.runner; from distributed.cli.dask_worker import main; main()"
        options = [self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        self.dask.append(self.start_process([sys.executable, "-c", code, *options]))

    def finished(self) -> list[int]:
        try:
            return store.open_stored(self.path).finished.tolist()
        except store.StoreError:
            assert not self.bits
            return []

    def check_blocks(self) -> None:
        """Check that blocks are complete and unchanged, and that no command computed a finished repetition again."""
        if not (self.path / store.BLOCKS_FOLDER).exists():
            assert not self.bits
            return
        now = {
            file.name: (file.stat().st_ino, file.stat().st_mtime_ns)
            for file in (self.path / store.BLOCKS_FOLDER).glob("[0-9]*.nc")
        }
        assert self.files.keys() <= now.keys(), f"lost: {sorted(self.files.keys() - now.keys())[:5]}"
        for name in now.keys() - self.files.keys():
            content = (self.path / store.BLOCKS_FOLDER / name).read_bytes()
            assert name.endswith(f"-{zlib.crc32(content):08x}.nc"), f"{name} is torn"
            members = decode_members(content)
            for place, number in enumerate(members.numbers.tolist()):
                bits = checksum([values[:, :, place] for values in members.arrays.values()])
                assert self.bits.setdefault(number, bits) == bits, "other bits than before"
        self.files |= now
        assert self.bits.keys() <= set(self.finished())
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        for number, by in map(str.split, lines[self.computed :]):
            # A Dask worker may continue tasks of killed commands, so only processes of commands are checked.
            if int(by) in self.finished_at_start:
                assert int(number) not in self.finished_at_start[int(by)], f"{number} was computed again"
        self.computed = len(lines)

    def check_and_describe(self) -> str:
        self.check_blocks()
        for number in self.random.sample(sorted(self.bits), min(MAX_CHECKED_REPETITIONS, len(self.bits))):
            sums = member_solution.compute_member_sums(STUDY, number)
            assert checksum(list(sums.values())) == self.bits[number], f"repetition {number} has other bits"
        for process in self.dask:
            process.kill()
            process.wait()
        store.create_or_open(self.path, STUDY.with_changes({"ensemble.repetitions": self.repetitions}))
        left = [file for file in self.path.rglob("*.partial") if str(os.getpid()) not in file.name]
        assert not left, f"left: {left[:3]}"
        errors = [line for line in (self.folder / "output").read_text().splitlines() if "Error" in line]
        return (
            f"{len(self.bits)} repetitions finished in {len(self.files)} files; {self.computed} computed; "
            f"{self.num_partial_files} kills left something half-written; none lost; same bits"
            + (f"; {errors[0]}" if errors else "")
        )


def checksum(values: list[np.ndarray]) -> int:
    return zlib.crc32(b"".join(np.ascontiguousarray(value).tobytes() for value in values))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=DEFAULT_KILLS, help="of each kind")
    parser.add_argument(
        "--kind", choices=EXECUTORS_BY_KIND, action="append", help="of writers that write; both by default"
    )
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the moments")
    arguments = parser.parse_args()
    for kind in arguments.kind or EXECUTORS_BY_KIND:
        kills: collections.Counter[str] = collections.Counter()
        random_generator = random.Random(arguments.seed)
        while kills.total() < arguments.kills:
            with tempfile.TemporaryDirectory(prefix="stiction-storm-") as folder:
                test = WriterKillRun(Path(folder), random_generator, EXECUTORS_BY_KIND[kind])
                try:
                    while test.kills.total() < KILLS_PER_FOLDER and (kills + test.kills).total() < arguments.kills:
                        test.run_and_kill()
                        test.check_blocks()
                    kills = kills + test.kills
                    print(f"storm: {kind}: {kills.total()} kills; {test.check_and_describe()}", flush=True)
                finally:
                    for process in test.processes:
                        process.kill()
                        process.wait()
        counts = ", ".join(f"{count} {target}" for target, count in kills.most_common())
        print(f"storm: {kind}: seed {arguments.seed}; killed: {counts}", flush=True)


if __name__ == "__main__":
    main()
