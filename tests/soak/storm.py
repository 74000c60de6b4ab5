"""Writers of one store killed at random moments: commands, their workers, workers of a scheduler, parts of four.

At each kill it is noted what is finished and what its victim had in hand. From then on nobody computes what is
finished, but for commands that are dead: a worker of Dask ends a task whose command was killed, and may not store it.
After each round nothing that was finished is lost or has other bits, and no process is left. A store lives for some
kills; then the bits of many repetitions are those of an undisturbed computation, and a new store is begun.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
import os
import random
import re
import secrets
import signal
import subprocess
import sys
import tempfile
import time
import zlib
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from stiction import Study
from stiction.studies import runner, store
from stiction.studies.dataset import empty_dataset
from stiction.studies.layout import block_of

KILLS = 200
OF_A_STORE = 20
"""Kills, before a new one is begun: so that many fall into its beginning."""

SAMPLE = 300
"""Repetitions of a store that are computed once more at the end."""

ROUNDS = {"writers": ("threads", "processes", "workers", "scheduler"), "parts": ("parts",)}

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

# Every process notes what it computes, has its tasks stored soon, and dawdles before and after each file gets its name.
RECORDING = """
import os, sys
if "storm" in os.environ and "stiction" in " ".join(sys.orig_argv):
    import pathlib, random, threading, time
    from stiction.studies import blocks, runner, store
    runner.TASK = 0.2
    store.PATIENCE = blocks.PATIENCE = 600  # the machine may have other work
    sums = runner.repetition_sums
    def noted(study, repetition):
        if study.surfaces.fractal_dimensions().size > 1:  # or it is done to say how long it takes
            with open(os.environ["storm"], "ab", buffering=0) as file:
                file.write(f"{repetition} {asked.by}\\n".encode())
        return sums(study, repetition)
    runner.repetition_sums = noted
    asked, is_shared = threading.local(), blocks.Writing.is_shared
    def known(writing):
        asked.by = writing.writer  # the command's that the task is of
        return is_shared(writing)
    blocks.Writing.is_shared = known
    def dawdling(function, seconds):
        def slow(*arguments, **options):
            time.sleep(random.expovariate(1 / seconds))
            result = function(*arguments, **options)
            time.sleep(random.expovariate(1 / seconds))
            return result
        return slow
    for name, seconds in (("replace", 0.003), ("mkdir", 0.01), ("rename", 0.1)):
        setattr(pathlib.Path, name, dawdling(getattr(pathlib.Path, name), seconds))
    blocks.Writing.save = dawdling(blocks.Writing.save, 0.1)  # so that some die before they say that it is done
"""


class Storm:
    def __init__(self, folder: Path, chance: random.Random, rounds: tuple[str, ...]) -> None:
        self.folder, self.chance, self.rounds = folder, chance, rounds
        self.repetitions = STUDY.ensemble.repetitions
        self.first_write = 1.0  # seconds that it lately took
        self.finished: frozenset[int] = frozenset()  # at the last kill
        self.dead: set[str] = set()  # commands that were killed, by their locks
        self.for_nobody = 0
        self.phases: collections.Counter[str] = collections.Counter()
        self.path = folder / "out" / "result.zarr"
        self.log = folder / "computed"
        (folder / "site").mkdir()
        (folder / "site" / "sitecustomize.py").write_text(RECORDING)
        (folder / "s.toml").write_text(STUDY.to_toml())
        self.environment = os.environ | {"PYTHONPATH": str(folder / "site"), "storm": str(self.log)}
        self.bits: dict[int, int] = {}  # of every repetition that was ever seen to be finished
        self.files: dict[int, tuple[int, int]] = {}
        self.partial: set[int] = set()
        self.kills: collections.Counter[str] = collections.Counter()
        self.computed = 0
        self.dask: list[subprocess.Popen[bytes]] = []
        self.address = ""

    def start(self, *options: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "stiction", "run", "s.toml", "--store", "out", *options]
        command += ["--set", f"ensemble.repetitions={self.repetitions}"]
        return self.process(command)

    def process(self, command: list[str]) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            command, cwd=self.folder, env=self.environment, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=(self.folder / "said").open("ab"),
        )  # fmt: skip

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
        with contextlib.suppress(FileNotFoundError):
            return max((file.stat().st_mtime_ns for file in (self.path / "complete").glob("c.*")), default=0)
        return 0

    def kill(self, what: str, process: subprocess.Popen[bytes]) -> None:
        assert process.poll() is None, f"{what} ended by itself: {process.returncode}"
        if self.chance.random() < 0.2:
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
        kids = children(process.pid)
        self.note(what, process.pid, *kids)
        process.kill()
        process.wait()
        until = time.monotonic() + PATIENCE
        while any(map(alive, kids)) and time.monotonic() < until:
            time.sleep(0.02)
        assert not any(map(alive, kids)), "a worker outlived its command"

    def note(self, what: str, *victims: int) -> None:
        """What is computed up to now, what is finished, and what victims have in hand."""
        self.check()
        self.kills[what] += 1
        held = locks(self.folder, victims)
        self.phases[phase(held)] += 1
        self.dead |= {name for name in held if name.startswith("writer-")}

    def round(self) -> None:
        self.repetitions += self.chance.choice([0, self.chance.randint(1, 1000)])  # which changes the metadata
        what = self.chance.choice(self.rounds)
        match what:
            case "threads":
                process = self.start("--workers", "2")
                self.wait(process)
                self.kill(what, process)
            case "processes" | "workers":
                process = self.start("--cluster", "2")
                self.wait(process)
                for _ in range(2 * (what == "workers")):
                    if kids := children(process.pid):
                        victim = self.chance.choice(kids)
                        self.note("a worker of --cluster", victim)
                        os.kill(victim, signal.SIGKILL)
                    time.sleep(self.chance.uniform(0, 3))  # in which another one may have begun
                self.kill("--cluster", process)
            case "scheduler":
                self.start_scheduler()
                process = self.start("--scheduler", self.address)
                self.wait(process)
                if self.chance.random() < 0.5:
                    victim = self.dask.pop()
                    self.kill("a worker of Dask", victim)
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
                for each in self.chance.sample(sorted(parts), 4):
                    self.kill("--part", parts[each])
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
        import json

        self.address = json.loads(file.read_text())["address"]
        for _ in range(2):
            self.add_worker()

    def add_worker(self) -> None:
        code = "import stiction.studies.runner; from distributed.cli.dask_worker import main; main()"
        options = [self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard"]
        self.dask.append(self.process([sys.executable, "-c", code, *options]))

    def check(self) -> None:
        """That nobody has computed what was finished at the last kill; and what is finished now."""
        finished = self.all_finished()  # before the log is read, which has all of them then
        lines = self.log.read_text().splitlines() if self.log.exists() else []
        twice: dict[str, list[int]] = {}
        for repetition, by in map(str.split, lines[self.computed :]):
            if int(repetition) in self.finished:
                twice.setdefault(by, []).append(int(repetition))
        self.for_nobody += sum(len(twice.pop(by, [])) for by in self.dead)
        assert not twice, f"computed though finished: {twice}"
        assert self.finished <= finished, f"lost: {sorted(self.finished - finished)[:5]}"
        self.computed, self.finished = len(lines), finished

    def all_finished(self) -> frozenset[int]:
        if not self.path.exists():
            return frozenset()
        blocks = store.Blocks(self.path, self.path, block_of(STUDY))
        return frozenset(blocks.finished(self.repetitions).tolist())

    def look(self) -> None:
        if not self.path.exists():
            assert not self.bits
            return
        size = block_of(STUDY)
        finished = store.Blocks(self.path, self.path, size)
        template = empty_dataset(STUDY, [0]).data_vars
        now = finished.finished(self.repetitions)
        lost = self.bits.keys() - set(now.tolist())
        assert not lost, f"lost: {sorted(lost)[:5]}"
        for block in np.unique(now // size).tolist():
            status = (self.path / "complete" / f"c.{block}").stat()
            if self.files.get(block) == (status.st_ino, status.st_mtime_ns):
                continue
            self.files[block] = status.st_ino, status.st_mtime_ns
            values = [
                finished.read(str(name), each.dtype, (*each.shape[:2], *each.shape[3:]), block)
                for name, each in template.items()
            ]
            flags = np.flatnonzero(finished.flags(block))
            if flags.size < size:
                self.partial.add(block)
            for place in flags.tolist():
                bits = crc([each[:, :, place] for each in values])
                assert self.bits.setdefault(block * size + place, bits) == bits, "other bits than before"

    def in_the_end(self) -> str:
        size = block_of(STUDY)
        first = [each for each in sorted(self.bits) if each // size in self.partial][:SAMPLE]
        for repetition in {*first, *self.chance.sample(sorted(self.bits), min(SAMPLE, len(self.bits)))}:
            sums = runner.repetition_sums(STUDY, repetition)
            assert crc(list(sums.values())) == self.bits[repetition], f"repetition {repetition} has other bits"
        errors = [line for line in (self.folder / "said").read_text().splitlines() if "Error" in line]
        return (
            f"{len(self.bits)} repetitions finished in blocks of {size}, {len(self.partial)} of them seen half full; "
            f"{self.computed} computed, none that was finished but {self.for_nobody} for dead commands; "
            "none lost; same bits" + (f"; {errors[0]}" if errors else "")
        )


def locks(folder: Path, victims: Sequence[int]) -> set[str]:
    """Names of the files in a folder that processes have open."""
    open_files = []
    for victim in victims:
        for file in Path(f"/proc/{victim}/fd").glob("*"):
            with contextlib.suppress(OSError):
                open_files.append(Path(os.readlink(file)))
    return {file.name for file in open_files if folder in file.parents}


def phase(held: set[str]) -> str:
    """What processes are at that hold these locks."""
    for pattern, words in (
        (r"block-.*\.lock", "writing a block"), (r"writer-.*\.lock", "computing"),
        (r"result\.zarr\.partial", "laying out a new store"), (r"result\.zarr\.lock", "opening, or changing metadata"),
    ):  # fmt: skip
        if any(re.fullmatch(pattern, name) for name in held):
            return words
    return "holding no lock"


def crc(values: list[np.ndarray]) -> int:
    return zlib.crc32(b"".join(np.ascontiguousarray(each).tobytes() for each in values))


def children(pid: int) -> list[int]:
    found = []
    for stat in Path("/proc").glob("[0-9]*/stat"):
        with contextlib.suppress(OSError):
            fields = stat.read_text().rpartition(")")[2].split()
            if int(fields[1]) == pid and fields[0] != "Z":
                found.append(int(stat.parent.name))
    return found


def alive(pid: int) -> bool:
    with contextlib.suppress(OSError):
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    return False


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kills", type=int, default=KILLS, help="of each kind")
    parser.add_argument("--kind", choices=ROUNDS, action="append", help="of writers that write; both by default")
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the moments")
    arguments = parser.parse_args()
    for kind in arguments.kind or ROUNDS:
        kills: collections.Counter[str] = collections.Counter()
        phases: collections.Counter[str] = collections.Counter()
        chance = random.Random(arguments.seed)
        while kills.total() < arguments.kills:
            with tempfile.TemporaryDirectory(prefix="stiction-storm-") as folder:
                storm = Storm(Path(folder), chance, ROUNDS[kind])
                try:
                    while storm.kills.total() < OF_A_STORE and (kills + storm.kills).total() < arguments.kills:
                        storm.round()
                        storm.check()
                        storm.look()
                    kills, phases = kills + storm.kills, phases + storm.phases
                    print(f"storm: {kind}: {kills.total()} kills; {storm.in_the_end()}", flush=True)
                finally:
                    for process in storm.dask:
                        process.kill()
        print(
            f"storm: {kind}: seed {arguments.seed}; killed: {said(kills)}; while they were: {said(phases)}", flush=True
        )


def said(counts: collections.Counter[str]) -> str:
    return ", ".join(f"{count} {what}" for what, count in counts.most_common())


if __name__ == "__main__":
    main()
