"""How many repetitions a second are stored by workers that compute nothing, and how many workers is that enough for?

Two workers on this machine, and the process that hands out the work: where they write the blocks themselves, where they
send them, and one at a time as stores had them before there were blocks.
"""

import pickle
import statistics
import tempfile
import time
from pathlib import Path

import numcodecs
import numpy as np
from measure import seconds
from stiction import Study, __version__
from stiction.studies import blocks, layout, runner
from stiction.studies.processes import processes

STUDIES = ("figure6", "figure6-areal", "figure6-half-plane")
REPETITIONS = 1_000_000
SHARE = 3000
"""Of them, that are stored here."""

KINDS = 67
"""Different repetitions, more than in a block: equal ones would compress to nothing."""

TIMES = 3
"""Of which the median is taken, one after another of each kind."""

_task, _is_shared = runner.task, blocks.Writing.is_shared


class Given:
    """A task that computes nothing: its sums stand in a file, which every process reads once."""

    def __init__(self, path: str, shared: bool) -> None:
        self.path = path
        self.shared = shared

    def __call__(self, version: str, text: str, repetitions: list[int], writing: blocks.Writing) -> object:
        if self.path not in _read:
            _read[self.path] = pickle.loads(Path(self.path).read_bytes())
        runner.repetition_sums = lambda _, repetition: _read[self.path][repetition % KINDS]
        return _task(version, text, repetitions, writing if self.shared else None)


_read: dict[str, list[dict]] = {}


def different(sums: dict) -> list[dict]:
    """Sums like those of a repetition: what is zero stays so, other numbers have digits of their own."""
    random = np.random.default_rng(0)

    def other(values: np.ndarray) -> np.ndarray:
        if values.dtype.kind == "i":
            return values + (values > 0) * random.integers(0, 9, values.shape)
        return values * random.lognormal(0, 0.5, values.shape)

    return [{name: other(values) for name, values in sums.items()} for _ in range(KINDS)]


def stored(study: Study, sums: list[dict], *, share: int, shared: bool) -> tuple[float, float]:
    """Repetitions a second, and seconds of the driver's own for one, when workers compute nothing."""
    parts = max(1, study.ensemble.repetitions // share)
    with tempfile.TemporaryDirectory() as folder, processes(2) as executor:
        file = Path(folder) / "sums.pickle"
        file.write_bytes(pickle.dumps(sums))
        runner.task = Given(str(file), shared)
        try:
            runner.computed(study, Path(folder) / "r.zarr", part=(2, parts), executor=executor)  # and all is loaded
            start, own = time.perf_counter(), time.process_time()
            result = runner.computed(study, Path(folder) / "r.zarr", part=(1, parts), executor=executor)
            count = result.sizes["repetition"]
            return count / (time.perf_counter() - start), (time.process_time() - own) / count
        finally:
            runner.task = _task


def stored_before(study: Study, sums: list[dict]) -> float:
    """Repetitions a second as stores had them: a file of each variable for each, compressed harder, by the driver."""
    now = layout.FEWEST_BLOCKS, layout._zstd
    layout.FEWEST_BLOCKS, layout._zstd = 10**9, numcodecs.Zstd(level=0, checksum=True)
    try:
        return stored(study, sums, share=300, shared=False)[0]
    finally:
        layout.FEWEST_BLOCKS, layout._zstd = now


def rows() -> list[tuple[str, str]]:
    found = []
    for name in STUDIES:
        study = Study.named(name).with_changes({"ensemble.repetitions": REPETITIONS})
        half_plane = name == "figure6-half-plane"  # of which one takes a minute and a half
        one = study.with_changes({"surfaces.fractal_dimension": [1.2]}) if half_plane else study
        text = one.to_toml()
        runner.task(__version__, text, [0], None)
        cost = seconds(lambda text=text: runner.task(__version__, text, [1], None), 1 if half_plane else 3)
        cost *= study.surfaces.fractal_dimensions().size if half_plane else 1
        sums = different(runner.repetition_sums(study, 0) if not half_plane else _like(study))
        each = [
            (stored(study, sums, share=SHARE, shared=True), stored(study, sums, share=SHARE, shared=False)[0],
             stored_before(study, sums))
            for _ in range(TIMES)
        ]  # fmt: skip
        rate, own = (statistics.median(one[0][i] for one in each) for i in range(2))
        sent, before = (statistics.median(one[i] for one in each) for i in (1, 2))
        found += [
            (f"a repetition of {name}: time on one core", f"{cost:.3g} s"),
            ("... its sums", f"{runner._size(study) / 1e3:.0f} kB"),
            ("... stored a second by two workers that compute nothing", f"{rate:.0f}"),
            ("... sent by them, and stored by the process that hands out the work", f"{sent:.0f}"),
            ("... one at a time, as before", f"{before:.0f}; {rate / before:.1f} times as many by workers"),
            ("... time of the process that hands out the work, for one", f"{1e6 * own:.0f} µs"),
            ("... workers that keep it busy", f"{cost / own:,.0f}"),
        ]
    return found


def _like(study: Study) -> dict:
    """Sums of a study from those of one fractal dimension."""
    one = runner.repetition_sums(study.with_changes({"surfaces.fractal_dimension": [1.2]}), 0)
    return {name: values.repeat(study.surfaces.fractal_dimensions().size, axis=0) for name, values in one.items()}
