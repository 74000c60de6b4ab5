"""Kill writers of one result at random moments: commands, Dask workers, and parts of a run.

At each kill it is noted what is finished. From then on no new command computes that again, nothing that was finished
is lost or has other bits, and no file of a block changes. A folder lives for some kills; then the bits of many
repetitions are those of an undisturbed computation, what was left half-written is gone after one more run, and a new
folder is begun.
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

KILLS = 200
OF_A_FOLDER = 20  # kills, before a new one is begun: so that many fall into its beginning
SAMPLE = 300  # repetitions of a folder that are computed once more at the end
ROUNDS = {"writers": ("threads", "scheduler"), "parts": ("parts",)}
PATIENCE = 600.0

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

# Every process notes what it computes, has small blocks, and dawdles before and after each file gets its name.
RECORDING = """
import os, sys
if "storm" in os.environ and "stiction" in " ".join(sys.orig_argv):
    import pathlib, random, time
    from stiction.studies import runner
    runner.BLOCK_TIME = 0.02
    sums = runner.member_sums
    def noted(study, member):
        with open(os.environ["storm"], "ab", buffering=0) as file:
            file.write(f"{member} {os.getpid()}\\n".encode())
        time.sleep(1e-3)  # or files would come faster than they are looked at
        return sums(study, member)
    runner.member_sums = noted
    def dawdling(function, seconds):
        def slow(*arguments, **options):
            time.sleep(random.expovariate(1 / seconds))
            result = function(*arguments, **options)
            time.sleep(random.expovariate(1 / seconds))
            return result
        return slow
    for name, seconds in (("replace", 0.02), ("write_bytes", 0.01), ("mkdir", 0.05), ("touch", 0.05)):
        setattr(pathlib.Path, name, dawdling(getattr(pathlib.Path, name), seconds))
"""


class Storm:
    def __init__(self, folder: Path, chance: random.Random, rounds: tuple[str, ...]) -> None:
        self.folder, self.chance, self.rounds = folder, chance, rounds
        self.repetitions = STUDY.ensemble.repetitions
        self.first_write = 1.0  # seconds that it lately took
        self.path = folder / "out"
        self.log = folder / "computed"
        (folder / "site").mkdir()
        (folder / "site" / "sitecustomize.py").write_text(RECORDING)
        (folder / "s.toml").write_text(STUDY.to_toml())
        self.environment = os.environ | {"PYTHONPATH": str(folder / "site"), "storm": str(self.log)}
        self.files: dict[str, tuple[int, int]] = {}
        self.bits: dict[int, int] = {}  # of every repetition that was ever seen to be finished
        self.begun: dict[int, frozenset[int]] = {}  # what was finished when each command that lives was begun
        self.kills: collections.Counter[str] = collections.Counter()
        self.half_written = 0
        self.computed = 0
        self.processes: list[subprocess.Popen[bytes]] = []
        self.dask: list[subprocess.Popen[bytes]] = []
        self.address = ""

    def start(self, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "stiction", "run", "s.toml", "--output", "out", *options]
        command += ["--set", f"ensemble.repetitions={self.repetitions}"]
        finished = frozenset(self.finished())
        process = self.process(command)
        self.begun[process.pid] = finished
        return process

    def process(self, command: list[str]) -> subprocess.Popen[bytes]:
        process = subprocess.Popen(
            command, cwd=self.folder, env=self.environment, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=(self.folder / "said").open("ab"),
        )  # fmt: skip
        self.processes.append(process)
        return process

    def wait(self, *processes: subprocess.Popen[bytes]) -> None:
        """Some moment of the time until something is written, or then some moment of the next half second."""
        before, began = self.written(), time.monotonic()
        early = self.chance.random() < 0.3
        until = began + (self.chance.uniform(0, 1.2 * self.first_write) if early else PATIENCE)
        while time.monotonic() < until and self.written() == before:
            assert all(process.poll() is None for process in processes), f"a run ended by itself: {self.last_said()}"
            time.sleep(0.002)
        if not early:
            assert self.written() != before, "nothing is written"
            self.first_write = time.monotonic() - began
            time.sleep(self.chance.uniform(0, 0.5))

    def last_said(self) -> str:
        return (self.folder / "said").read_text()[-1000:]

    def written(self) -> int:
        return sum(1 for _ in (self.path / store.BLOCKS_FOLDER).glob("*.nc"))

    def kill(self, what: str, process: subprocess.Popen[bytes]) -> None:
        assert process.poll() is None, f"{what} ended by itself: {process.returncode}: {self.last_said()}"
        if self.chance.random() < 0.2:
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
        process.kill()
        process.wait()
        self.kills[what] += 1
        self.half_written += bool(list(self.path.rglob(f".stiction-*-{process.pid}-*.partial")))
        self.look()

    def round(self) -> None:
        self.repetitions += self.chance.choice([0, self.chance.randint(1, 1000)])
        what = self.chance.choice(self.rounds)
        match what:
            case "threads":
                process = self.start("--workers", "2")
                self.wait(process)
                self.kill(what, process)
            case "scheduler":
                self.start_scheduler()
                process = self.start("--scheduler", self.address)
                self.wait(process)
                if self.chance.random() < 0.5:
                    self.kill("a worker of Dask", self.dask.pop())
                    self.add_worker()
                    time.sleep(self.chance.uniform(0, 3))  # in which another one may have begun
                self.kill("--scheduler", process)
            case "parts":
                parts = {i: self.start("--part", f"{i}/4", "--workers", "1") for i in range(1, 5)}
                self.wait(*parts.values())
                again = self.chance.randint(1, 4)
                self.kill("--part", parts[again])
                parts[again] = self.start("--part", f"{again}/4", "--workers", "1")
                self.wait(*parts.values())
                for item in self.chance.sample(sorted(parts), 4):
                    self.kill("--part", parts[item])
                    time.sleep(self.chance.uniform(0, 0.3))

    def start_scheduler(self) -> None:
        if self.address:
            return
        file = self.folder / "scheduler.json"
        binary = str(Path(sys.executable).with_name("dask"))
        options = ["--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--scheduler-file", str(file)]
        self.dask = [self.process([binary, "scheduler", *options])]
        while not file.exists():
            time.sleep(0.1)
        self.address = json.loads(file.read_text())["address"]
        for _ in range(2):
            self.add_worker()

    def add_worker(self) -> None:
        code = "import stiction.studies.runner; from distributed.cli.dask_worker import main; main()"
        options = [self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        self.dask.append(self.process([sys.executable, "-c", code, *options]))

    def finished(self) -> list[int]:
        try:
            return store.open_stored(self.path).finished.tolist()
        except store.StoreError:
            assert not self.bits
            return []

    def look(self) -> None:
        """That all blocks are whole, none has changed, and no command has computed what was finished at its begin."""
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
                bits = crc([values[:, :, place] for values in members.arrays.values()])
                assert self.bits.setdefault(number, bits) == bits, "other bits than before"
        self.files |= now
        assert self.bits.keys() <= set(self.finished())
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        for number, by in map(str.split, lines[self.computed :]):
            if int(by) in self.begun:  # a worker of Dask goes on for commands that are dead
                assert int(number) not in self.begun[int(by)], f"{number} was computed again"
        self.computed = len(lines)

    def in_the_end(self) -> str:
        self.look()
        for number in self.chance.sample(sorted(self.bits), min(SAMPLE, len(self.bits))):
            sums = member_solution.member_sums(STUDY, number)
            assert crc(list(sums.values())) == self.bits[number], f"repetition {number} has other bits"
        for process in self.dask:
            process.kill()
            process.wait()
        store.create_or_open(self.path, STUDY.with_changes({"ensemble.repetitions": self.repetitions}))
        left = [file for file in self.path.rglob("*.partial") if str(os.getpid()) not in file.name]
        assert not left, f"left: {left[:3]}"
        errors = [line for line in (self.folder / "said").read_text().splitlines() if "Error" in line]
        return (
            f"{len(self.bits)} repetitions finished in {len(self.files)} files; {self.computed} computed; "
            f"{self.half_written} kills left something half-written; none lost; same bits"
            + (f"; {errors[0]}" if errors else "")
        )


def crc(values: list[np.ndarray]) -> int:
    return zlib.crc32(b"".join(np.ascontiguousarray(value).tobytes() for value in values))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=KILLS, help="of each kind")
    parser.add_argument("--kind", choices=ROUNDS, action="append", help="of writers that write; both by default")
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the moments")
    arguments = parser.parse_args()
    for kind in arguments.kind or ROUNDS:
        kills: collections.Counter[str] = collections.Counter()
        chance = random.Random(arguments.seed)
        while kills.total() < arguments.kills:
            with tempfile.TemporaryDirectory(prefix="stiction-storm-") as folder:
                storm = Storm(Path(folder), chance, ROUNDS[kind])
                try:
                    while storm.kills.total() < OF_A_FOLDER and (kills + storm.kills).total() < arguments.kills:
                        storm.round()
                        storm.look()
                    kills = kills + storm.kills
                    print(f"storm: {kind}: {kills.total()} kills; {storm.in_the_end()}", flush=True)
                finally:
                    for process in storm.processes:
                        process.kill()
                        process.wait()
        counts = ", ".join(f"{count} {what}" for what, count in kills.most_common())
        print(f"storm: {kind}: seed {arguments.seed}; killed: {counts}", flush=True)


if __name__ == "__main__":
    main()
