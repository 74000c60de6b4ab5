"""A long run, killed again and again at moments that nobody chose, and what must be true after each kill.

The result equals the undisturbed one bit for bit; the number of finished repetitions never falls; no file of a block
is written again; half-written files are removed by the next run.
"""

import argparse
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
from stiction.studies import store

KILLS = 25
SHORTEST = 25.0  # seconds that the undisturbed run takes at least, so that a kill seldom finds it done

# Many repetitions of a tenth of a second, each a block, so that many kills fall into writes.
STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 20},
        "surfaces.points": 80_000,
        "surfaces.extent": "6 um",
        "contact.approach.count": 20,
        "figures.draw": [],
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
    path = directory / "out"
    finished, seen, half_written = 0, {}, 0
    for kill in range(1, KILLS + 1):
        process = start(directory)
        if chance.random() < 0.2:
            time.sleep(chance.uniform(0, 1))  # mostly while it starts
        else:
            wait_until_it_writes(path, process)
            time.sleep(chance.uniform(0, 1.2 * seconds / KILLS))  # so that half of the run is left at the last
        assert process.poll() is None, f"kill {kill}: the run ended by itself, status {process.returncode}"
        process.send_signal(signal.SIGKILL)
        assert process.wait() == -signal.SIGKILL, f"kill {kill}: status {process.returncode}"
        half_written += any(file.stat().st_size for file in path.rglob(".stiction-*.partial"))
        now = store.info(path).finished if (path / store.STUDY).exists() else 0
        assert now >= finished, f"kill {kill}: {finished} repetitions were finished, and now {now}"
        finished = now
        files = finished_files(path)
        assert seen.items() <= files.items(), f"kill {kill}: a file of a block was written again"
        seen = files
    assert finished < study.ensemble.repetitions
    process = start(directory)
    assert process.wait(600) == 0
    assert seen.items() <= finished_files(path).items(), "a file of a block was written again"
    assert not list(path.rglob(".stiction-*")), "something half-written is left"
    for result in (store.read(path), run(study, store=path)):
        xarray.testing.assert_identical(result, undisturbed)
        for name in result.variables:
            assert result[name].values.tobytes() == undisturbed[name].values.tobytes(), name
    return (
        f"{KILLS} kills of a run of {seconds:.0f} s, {half_written} of them within a file being written; "
        f"{finished} of {study.ensemble.repetitions} repetitions finished at the last; same bits, nothing written twice"
    )


def long_study(directory: Path) -> tuple[Study, xarray.Dataset, float]:
    """A study whose undisturbed run takes long enough on this machine, and that run."""
    repetitions = 200
    while True:
        study = STUDY.with_changes({"ensemble.repetitions": repetitions})
        began = time.perf_counter()
        result = run(study, store=directory / f"undisturbed-{repetitions}")
        seconds = time.perf_counter() - began
        if seconds >= SHORTEST:
            return study, result, seconds
        repetitions = int(repetitions * max(1.5, 1.3 * SHORTEST / seconds))


def wait_until_it_writes(path: Path, process: subprocess.Popen[bytes]) -> None:
    before = len(finished_files(path))
    while len(finished_files(path)) == before and process.poll() is None:
        time.sleep(0.001)


def start(directory: Path) -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "stiction", "run", "study.toml", "--output", "out"]
    return subprocess.Popen(command, cwd=directory, stdout=subprocess.DEVNULL)


def finished_files(path: Path) -> dict[str, tuple[int, int]]:
    """Inode and time of the file of every block."""
    statuses = {file.name: file.stat() for file in (path / store.BLOCKS).glob("[0-9]*.nc")}
    return {name: (status.st_ino, status.st_mtime_ns) for name, status in statuses.items()}


if __name__ == "__main__":
    main()
