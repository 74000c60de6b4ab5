"""A long run, killed again and again at moments that nobody chose, and what must be true after each kill.

The result equals the undisturbed one bit for bit; the number of finished repetitions never falls; no file of a
finished repetition is written again.
"""

import argparse
import os
import random
import secrets
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import xarray
from stiction import Study, run
from stiction.mechanics.quantities import SUMS
from stiction.studies import store

KILLS = 25
SHORTEST = 25.0
"""Seconds that the undisturbed run takes at least, so that a kill seldom finds it done."""

# Many repetitions of a tenth of a second, so that many kills fall into writes; and fewer than 1024, each a block.
STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 20},
        "surfaces.points": 80_000,
        "surfaces.extent": "6 um",
        "contact.approach.count": 20,
    }
)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--seed", type=int, default=secrets.randbelow(2**31), help="of the moments; by default another each time"
    )
    seed = parser.parse_args().seed
    print(f"soak: seed {seed}", flush=True)
    with tempfile.TemporaryDirectory(prefix="stiction-soak-") as directory:
        print(f"soak: {soaked(Path(directory), random.Random(seed))}, seed {seed}")


def soaked(directory: Path, chance: random.Random) -> str:
    study, undisturbed, seconds = long_study(directory)
    (directory / "study.toml").write_text(study.to_toml(), encoding="utf-8")
    path = directory / "out" / "result.zarr"
    finished, seen, in_writing, half_written = 0, {}, 0, set()
    for kill in range(1, KILLS + 1):
        process = start(directory)
        if chance.random() < 0.2:
            time.sleep(chance.uniform(0, 1))  # mostly while it starts, with the lock that the last one left
        else:
            wait_until_it_writes(path, process)
            time.sleep(chance.uniform(0, 1.2 * seconds / KILLS))  # so that half of the run is left at the last
        assert process.poll() is None, f"kill {kill}: the run ended by itself, status {process.returncode}"
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, f"kill {kill}: status {process.returncode}"
        in_writing += bool(unflagged(path) - half_written)  # what an earlier kill left does not count again
        half_written = unflagged(path)
        now = store.info(path).finished if path.exists() else 0
        assert now >= finished, f"kill {kill}: {finished} repetitions were finished, and now {now}"
        finished = now
        files = finished_files(path)
        assert seen.items() <= files.items(), f"kill {kill}: a file of a finished repetition was written again"
        seen = files
    assert finished < study.ensemble.repetitions
    process = start(directory)
    assert process.wait(600) == 0
    assert seen.items() <= finished_files(path).items(), "a file of a finished repetition was written again"
    for result in (store.read(path), run(study, store=path)):
        xarray.testing.assert_identical(result, undisturbed)
        for name in result.variables:
            assert result[name].values.tobytes() == undisturbed[name].values.tobytes(), name
    return (
        f"{KILLS} kills of a run of {seconds:.0f} s, {in_writing} of them within a repetition being written; "
        f"{finished} of {study.ensemble.repetitions} repetitions finished at the last; same bits, nothing written twice"
    )


def long_study(directory: Path) -> tuple[Study, xarray.Dataset, float]:
    """A study whose undisturbed run takes long enough on this machine, and that run."""
    repetitions = 200
    while True:
        study = STUDY.with_changes({"ensemble.repetitions": repetitions})
        began = time.perf_counter()
        result = run(study, store=directory / f"undisturbed-{repetitions}.zarr")
        seconds = time.perf_counter() - began
        if seconds >= SHORTEST:
            return study, result, seconds
        repetitions = int(repetitions * max(1.5, 1.3 * SHORTEST / seconds))


def wait_until_it_writes(path: Path, process: subprocess.Popen[bytes]) -> None:
    before = flagged_at(path)
    while flagged_at(path) == before and process.poll() is None:
        time.sleep(0.001)


def flagged_at(path: Path) -> int:
    try:
        return (path / "complete").stat().st_mtime_ns
    except FileNotFoundError:
        return 0


def start(directory: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "stiction", "run", "study.toml", "--output", "out"]
    return subprocess.Popen(command, cwd=directory, stdout=subprocess.DEVNULL)


def finished_files(path: Path) -> dict[str, tuple[int, int]]:
    """Inode and time of every file of a finished repetition."""
    files = {}
    for flag in path.glob("complete/c.*"):
        repetition = flag.name.removeprefix("c.")
        if repetition.isdigit():
            for file in (flag, *(path / name / f"c.0.0.{repetition}.0" for name in SUMS)):
                status = os.stat(file)
                files[str(file)] = status.st_ino, status.st_mtime_ns
    return files


def unflagged(path: Path) -> set[str]:
    """Repetitions that were being written."""
    begun = {file.name.split(".")[3] for file in path.glob(f"{SUMS[0]}/c.0.0.*.0")}
    return begun - {file.name.removeprefix("c.") for file in path.glob("complete/c.*")}


if __name__ == "__main__":
    main()
