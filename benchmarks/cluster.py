"""What does one task of a cluster cost, in seconds and bytes, and what can the process that collects them take in?"""

import pickle
import tempfile
import time
from pathlib import Path

from measure import seconds
from stiction import Study, __version__, run
from stiction.studies import runner
from stiction.studies.processes import processes

STUDY = Study.named("figure6")


class Given:
    """A task that computes nothing: it returns a copy of what stands in a file, which every process reads once."""

    def __init__(self, path: str) -> None:
        self.path = path

    def __call__(self, *_: object) -> dict:
        if self.path not in _read:
            _read[self.path] = pickle.loads(Path(self.path).read_bytes())
        return {name: values.copy() for name, values in _read[self.path].items()}


_read: dict[str, dict] = {}


def taken_in(count: int) -> float:
    """Repetitions a second that a driver takes from two workers and stores, when they compute nothing."""
    study = STUDY.with_changes({"ensemble.repetitions": count})
    real = runner.task
    with tempfile.TemporaryDirectory() as folder, processes(2) as executor:
        sums = Path(folder) / "sums.pickle"
        sums.write_bytes(pickle.dumps(runner.repetition_sums(STUDY, 0)))
        runner.task = Given(str(sums))
        try:
            start = time.perf_counter()
            run(study, executor=executor, store=Path(folder) / "result.zarr")
            return count / (time.perf_counter() - start)
        finally:
            runner.task = real


def rows() -> list[tuple[str, str]]:
    text = STUDY.to_toml()
    runner.task(__version__, text, 0)
    cost = seconds(lambda: runner.task(__version__, text, 1), 5)
    size = len(pickle.dumps(runner.repetition_sums(STUDY, 0), protocol=5))
    rate = taken_in(600)
    return [
        ("one repetition of figure6, 50 pairs", f"{cost:.3f} s"),
        ("what it sends back", f"{size / 1e3:.0f} kB"),
        ("repetitions that the driver takes in and stores", f"{rate:.0f} a second"),
        ("workers that keep it busy", f"{rate * cost:.0f}"),
        ("a million repetitions with them", f"{1e6 / rate / 3600:.1f} hours"),
    ]
