"""Test runs of parts of a study, and of several processes and machines that share a result directory."""

import itertools
from concurrent.futures import Executor
from dataclasses import replace
from pathlib import Path

import pytest
import xarray
from stiction import run
from stiction.solve import runner, store
from stiction.solve.runner import SharedResultDirectory, compute_missing_blocks
from support.generated_studies import TINY_STUDY, InlineExecutor, assert_same_bits, with_repetitions

pytestmark = pytest.mark.usefixtures("write_blocks_of_four_members")


def test_run_divided_into_parts_gives_a_complete_result(tmp_path, uninterrupted_dataset, computed_repetitions):
    """Run two of three parts twice each; then a run without a part computes the remaining repetitions."""
    repetitions_of_parts = {(2, 3): [*range(4, 8), *range(16, 20)], (1, 3): [*range(4), *range(12, 16)]}
    for part, expected in repetitions_of_parts.items():
        del computed_repetitions[:]
        for _ in range(2):
            assert compute_missing_blocks(TINY_STUDY, tmp_path, part=part) == 8
        assert sorted(computed_repetitions) == expected
    partial_dataset = store.open_stored_result(tmp_path).dataset()
    xarray.testing.assert_identical(
        partial_dataset, uninterrupted_dataset.isel(repetition=sorted(itertools.chain(*repetitions_of_parts.values())))
    )
    del computed_repetitions[:]
    assert_same_bits(run(TINY_STUDY, store=tmp_path).dataset, uninterrupted_dataset)
    assert sorted(computed_repetitions) == [8, 9, 10, 11, 20, 21]
    assert not list(tmp_path.rglob("*.partial"))


def test_parts_of_runs_with_different_part_counts_combine_to_a_complete_result(tmp_path, uninterrupted_dataset):
    compute_missing_blocks(with_repetitions(10), tmp_path, part=(1, 2))
    compute_missing_blocks(TINY_STUDY, tmp_path, part=(3, 5))
    compute_missing_blocks(TINY_STUDY, tmp_path, part=(1, 1))
    assert_same_bits(store.read(tmp_path), uninterrupted_dataset)


@pytest.mark.parametrize("part", [(0, 2), (3, 2), (1, 0)])
def test_computation_of_missing_pairs_rejects_an_invalid_part_of_a_run(tmp_path, part):
    with pytest.raises(ValueError, match=r"`part` must be \(K, N\)"):
        compute_missing_blocks(TINY_STUDY, tmp_path / "r", part=part)
    assert not (tmp_path / "r").exists()


class RemoteExecutor(Executor):
    """Executor that runs tasks as on another machine, which may have no access to the shared directory."""

    def __init__(self, has_directory):
        self.has_directory = has_directory

    def submit(self, function, /, *args):
        if not self.has_directory:
            args = [
                replace(arg, path=Path("/nowhere")) if isinstance(arg, SharedResultDirectory) else arg for arg in args
            ]
            if isinstance(getattr(function, "__self__", None), SharedResultDirectory):
                function = SharedResultDirectory(Path("/nowhere"), "").is_accessible
        return InlineExecutor().submit(function, *args)


def test_workers_write_blocks_if_the_directory_is_shared_and_return_blocks_otherwise(
    tmp_path, uninterrupted_dataset, monkeypatch
):
    written_blocks, task_results = [], []
    monkeypatch.setattr(
        runner,
        "write_block",
        lambda path, first, *rest: written_blocks.append(first) or store.write_block(path, first, *rest),
    )
    task = runner.compute_block
    monkeypatch.setattr(runner, "compute_block", lambda *args: task_results.append(task(*args)) or task_results[-1])
    for directory_name, executor, ending in (
        ("here", InlineExecutor(), "in 6 files"),
        ("shared", RemoteExecutor(True), "in 6 files"),
        ("apart", RemoteExecutor(False), "this process writes the files"),
    ):
        del written_blocks[:], task_results[:]
        events = []
        compute_missing_blocks(TINY_STUDY, tmp_path / directory_name, executor=executor, announce=events.append)
        assert len(events) == 1
        assert events[0].startswith("computing 22 repetitions: ")
        assert "in 6 files" in events[0]
        assert events[0].endswith(ending)
        assert written_blocks == list(range(0, 22, 4))
        assert [content is None for content in task_results] == [directory_name == "shared"] * 6
        assert_same_bits(store.read(tmp_path / directory_name), uninterrupted_dataset)
        assert not list((tmp_path / directory_name).rglob("*.partial"))


def test_run_stores_blocks_of_other_pairs_if_the_solution_of_one_pair_fails(tmp_path, monkeypatch):
    sums = runner.compute_member_arrays

    def compute_or_fail(study, number):
        if number == 6:
            raise ValueError("member 6")
        return sums(study, number)

    monkeypatch.setattr(runner, "compute_member_arrays", compute_or_fail)
    with pytest.raises(ValueError, match="member 6"):
        run(TINY_STUDY, store=tmp_path, executor=InlineExecutor())
    assert store.open_stored_result(tmp_path).finished_members.tolist() == [*range(4), *range(8, 22)]
