"""Several processes, machines or parts that share a folder."""

import itertools
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

import pytest
import xarray
from stiction import run
from stiction.studies import runner, store
from stiction.studies.runner import SharedFolder, compute_missing
from support.generated_studies import TINY, InlineExecutor, assert_same_bits, with_repetitions

pytestmark = pytest.mark.usefixtures("blocks_of_four")


def test_parts_complete_one_result(tmp_path, undisturbed, computed):
    """Each computes its own blocks, twice nothing; what one leaves is computed by whoever comes without a part."""
    own = {(2, 3): [*range(4, 8), *range(16, 20)], (1, 3): [*range(4), *range(12, 16)]}
    for part, expected in own.items():
        del computed[:]
        for _ in range(2):
            assert compute_missing(TINY, tmp_path, part=part) == 8
        assert sorted(computed) == expected
    present = store.open_stored(tmp_path).dataset()
    xarray.testing.assert_identical(present, undisturbed.isel(repetition=sorted(itertools.chain(*own.values()))))
    del computed[:]
    assert_same_bits(run(TINY, store=tmp_path).dataset, undisturbed)
    assert sorted(computed) == [8, 9, 10, 11, 20, 21]
    assert not list(tmp_path.rglob("*.partial"))


def test_parts_of_other_counts_are_compatible(tmp_path, undisturbed):
    compute_missing(with_repetitions(10), tmp_path, part=(1, 2))
    compute_missing(TINY, tmp_path, part=(3, 5))
    compute_missing(TINY, tmp_path, part=(1, 1))
    assert_same_bits(store.read(tmp_path), undisturbed)


@pytest.mark.parametrize("part", [(0, 2), (3, 2), (1, 0)])
def test_fill_rejects_bad_part(tmp_path, part):
    with pytest.raises(ValueError, match="part must be K of N"):
        compute_missing(TINY, tmp_path / "r", part=part)
    assert not (tmp_path / "r").exists()


class Workers(Executor):
    """Workers of a cluster, on another machine; `sees` is whether the folder is there too."""

    def __init__(self, sees):
        self.sees = sees

    def submit(self, function, /, *args):
        if not self.sees:
            args = [replace(arg, path=Path("/nowhere")) if isinstance(arg, SharedFolder) else arg for arg in args]
            if isinstance(getattr(function, "__self__", None), SharedFolder):  # SharedFolder.is_visible
                function = SharedFolder(Path("/nowhere"), "").is_visible
        return InlineExecutor().submit(function, *args)


def test_workers_write_to_shared_directory_or_return_blocks(tmp_path, undisturbed, monkeypatch):
    written, completed = [], []
    monkeypatch.setattr(
        runner, "write_block", lambda path, first, *rest: written.append(first) or store.write_block(path, first, *rest)
    )
    task = runner.compute_block
    monkeypatch.setattr(runner, "compute_block", lambda *args: completed.append(task(*args)) or completed[-1])
    for where, executor, who in (
        ("here", InlineExecutor(), "in 6 files"),
        ("shared", Workers(True), "in 6 files"),
        ("apart", Workers(False), "this process writes the files"),
    ):
        del written[:], completed[:]
        events = []
        compute_missing(TINY, tmp_path / where, executor=executor, announce=events.append)
        assert len(events) == 1
        assert events[0].startswith("computing 22 repetitions: ")
        assert "in 6 files" in events[0]
        assert events[0].endswith(who)
        assert written == list(range(0, 22, 4))
        assert [content is None for content in completed] == [where == "shared"] * 6
        assert_same_bits(store.read(tmp_path / where), undisturbed)
        assert not list((tmp_path / where).rglob("*.partial"))


def test_failed_member_loses_no_blocks(tmp_path, monkeypatch):
    sums = runner.member_sums

    def fail(study, number):
        if number == 6:
            raise ValueError("member 6")
        return sums(study, number)

    monkeypatch.setattr(runner, "member_sums", fail)
    with pytest.raises(ValueError, match="member 6"):
        run(TINY, store=tmp_path, executor=InlineExecutor())
    assert store.open_stored(tmp_path).finished.tolist() == [*range(4), *range(8, 22)]
