"""Writers of one store killed at random moments: commands, their workers, workers of a scheduler, parts of four.

After each round: nothing that was finished is lost, has other bits or was computed again; no process is left. At the
end the bits of many repetitions are those of an undisturbed computation.
"""

from __future__ import annotations

import argparse
import collections
import contextlib
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
from stiction.studies import runner, store
from stiction.studies.dataset import empty_dataset
from stiction.studies.layout import block_of

KILLS = 200
SAMPLE = 2000
"""Repetitions that are computed once more at the end."""

PATIENCE = 60.0

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 3},
        "surfaces.points": 3000,
        "surfaces.extent": "4 um",
        "surfaces.directions": 8,
        "surfaces.frequencies": 12,
        "contact.approach.count": 6,
        "ensemble.repetitions": 100_000,
        "figures.draw": [],
    }
)

# Every process notes what it computes.
RECORDING = """
import os, sys
if "storm" in os.environ and "stiction" in " ".join(sys.orig_argv):
    from stiction.studies import runner
    sums = runner.repetition_sums
    def noted(study, repetition):
        if study.surfaces.fractal_dimensions().size > 1:  # or it is done to say how long it takes
            with open(os.environ["storm"], "ab", buffering=0) as file:
                file.write(b"%d\\n" % repetition)
        return sums(study, repetition)
    runner.repetition_sums = noted
"""


class Storm:
    def __init__(self, folder: Path, chance: random.Random) -> None:
        self.folder, self.chance = folder, chance
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
        return self.process(command)

    def process(self, command: list[str]) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            command, cwd=self.folder, env=self.environment, start_new_session=True,
            stdout=subprocess.DEVNULL, stderr=(self.folder / "said").open("ab"),
        )  # fmt: skip

    def wait(self, *processes: subprocess.Popen[bytes]) -> None:
        """Until something is written, seldom less; then any moment."""
        before, until = (
            self.written(),
            time.monotonic() + (self.chance.uniform(0, 4) if self.chance.random() < 0.2 else 60),
        )
        while time.monotonic() < until and self.written() == before:
            assert all(process.poll() is None for process in processes), "a run ended by itself"
            time.sleep(0.002)
        time.sleep(self.chance.uniform(0, 1))

    def written(self) -> int:
        with contextlib.suppress(FileNotFoundError):
            return max(file.stat().st_mtime_ns for file in (self.path / "complete").iterdir() if file.suffix != ".lock")
        return 0

    def kill(self, what: str, process: subprocess.Popen[bytes]) -> None:
        assert process.poll() is None, f"{what} ended by itself: {process.returncode}"
        if self.chance.random() < 0.2:
            process.send_signal(signal.SIGSTOP)
            time.sleep(0.2)
        kids = children(process.pid)
        process.kill()
        process.wait()
        self.kills[what] += 1
        until = time.monotonic() + PATIENCE
        while any(map(alive, kids)) and time.monotonic() < until:
            time.sleep(0.02)
        assert not any(map(alive, kids)), "a worker outlived its command"

    def round(self) -> None:
        what = self.chance.choice(["threads", "processes", "workers", "scheduler", "parts", "parts"])
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
                        os.kill(self.chance.choice(kids), signal.SIGKILL)
                        self.kills["a worker of --cluster"] += 1
                    time.sleep(self.chance.uniform(0, 2))
                self.kill("--cluster", process)
            case "scheduler":
                self.start_scheduler()
                process = self.start("--scheduler", self.address)
                self.wait(process)
                if self.chance.random() < 0.5:
                    victim = self.dask.pop()
                    self.kill("a worker of Dask", victim)
                    self.add_worker()
                    time.sleep(self.chance.uniform(0, 2))
                self.kill("--scheduler", process)
            case "parts":
                parts = {i: self.start("--part", f"{i}/4", "--workers", "1") for i in range(1, 5)}
                self.wait(*parts.values())
                again = self.chance.randint(1, 4)
                self.kill("--part", parts[again])
                parts[again] = self.start("--part", f"{again}/4", "--workers", "1")
                self.wait(*parts.values())
                for process in parts.values():
                    self.kill("--part", process)
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

    def check(self, before: frozenset[int]) -> None:
        computed = [int(line) for line in self.log.read_text().split()] if self.log.exists() else []
        self.log.unlink(missing_ok=True)
        self.computed += len(computed)
        twice = before & set(computed)
        assert not twice, f"computed though finished: {sorted(twice)[:5]}"
        self.look()

    def look(self) -> None:
        if not self.path.exists():
            assert not self.bits
            return
        size = block_of(STUDY)
        finished = store.Blocks(self.path, self.path, size)
        template = empty_dataset(STUDY, [0]).data_vars
        now = finished.finished(STUDY.ensemble.repetitions)
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
        said = [
            line for line in (self.folder / "said").read_text().splitlines() if "Error" in line and "stiction" in line
        ]
        kinds = ", ".join(f"{count} of {what}" for what, count in self.kills.most_common())
        return (
            f"{sum(self.kills.values())} kills ({kinds}); "
            f"{len(self.bits)} repetitions finished in blocks of {size}, {len(self.partial)} blocks in several goes; "
            f"{self.computed} computed, none that was finished; none lost; same bits{'; ' + said[0] if said else ''}"
        )


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
    parser.add_argument("--kills", type=int, default=KILLS)
    parser.add_argument("--seed", type=int, default=secrets.randbelow(2**31), help="of the moments")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="stiction-storm-") as folder:
        storm = Storm(Path(folder), random.Random(arguments.seed))
        try:
            while sum(storm.kills.values()) < arguments.kills:
                before = frozenset(storm.bits)
                storm.round()
                storm.check(before)
                print(f"storm: {dict(storm.kills)}, {len(storm.bits)} finished", flush=True)
            print(f"storm: {storm.in_the_end()}, seed {arguments.seed}")
        finally:
            for process in storm.dask:
                process.kill()


if __name__ == "__main__":
    main()
