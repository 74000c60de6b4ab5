"""Several writers of one store: workers that write, and parts that share it."""

import contextlib
import dataclasses
import itertools
import os
import shutil
import threading
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import numcodecs
import numpy as np
import pytest
import xarray
from command import assert_refused, stiction_command
from stiction import Study, run
from stiction.studies import blocks, layout, runner, store
from stiction.studies.lock import is_locked, locked
from stiction.studies.processes import processes
from stiction.studies.store import StoreError

STUDY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 2},
        "surfaces.points": 300,
        "surfaces.extent": "2 um",
        "surfaces.directions": 4,
        "surfaces.frequencies": 6,
        "contact.approach.count": 4,
        "ensemble.repetitions": 22,
        "figures.draw": [],
    }
)


class Inline(ThreadPoolExecutor):
    """Computes in order, in the thread that asks."""

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@pytest.fixture(autouse=True)
def blocks_of_four(monkeypatch):
    monkeypatch.setattr(layout, "FEWEST_BLOCKS", 5)
    assert layout.block_of(STUDY) == 4


@pytest.fixture(scope="module")
def undisturbed():
    return run(STUDY)


@pytest.fixture
def computed(monkeypatch):
    """The repetitions that are computed."""
    repetitions, sums = [], runner.repetition_sums

    def record(study, repetition):
        repetitions.append(repetition)
        return sums(study, repetition)

    monkeypatch.setattr(runner, "repetition_sums", record)
    return repetitions


def assert_same_bits(one, other):
    xarray.testing.assert_identical(one, other)
    for name in one.variables:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


def assert_nothing_is_left(path):
    assert not list(path.rglob("*.partial"))
    assert not list(path.parent.rglob("*.lock"))


def sums_of(*repetitions):
    each = [runner.repetition_sums(STUDY, repetition) for repetition in repetitions]
    return {name: np.stack([one[name] for one in each], axis=2) for name in each[0]}


# ---- Blocks ---------------------------------------------------------------------------------------------------------


def test_a_store_has_a_file_of_each_variable_for_many_repetitions(tmp_path, undisturbed):
    path = tmp_path / "r.zarr"
    assert_same_bits(run(STUDY, store=path), undisturbed)
    assert_same_bits(store.read(path), undisturbed)
    assert sorted(os.listdir(path / "contact_area")) == [*(f"c.0.0.{block}.0" for block in range(6)), "zarr.json"]
    assert store.info(path).versions["schema"] == "2"
    with xarray.open_zarr(path, consolidated=False) as stored:
        assert stored["complete"].values.all()
        for name, variable in undisturbed.variables.items():
            assert stored[name].variable.identical(variable), name
    assert_nothing_is_left(path)


def test_repetitions_are_put_beside_those_of_their_block(tmp_path, undisturbed, computed):
    path = tmp_path / "r.zarr"
    for total in (6, 7, 22):
        study = STUDY.with_changes({"ensemble.repetitions": total})
        if total == 6:
            with pytest.MonkeyPatch.context() as patch:
                patch.setattr(layout, "FEWEST_BLOCKS", 1)
                run(study, store=path)
        else:
            run(study, store=path)
    assert sorted(computed) == list(range(22))
    assert_same_bits(store.read(path), undisturbed)


def test_a_store_of_schema_1_is_read_and_continued_with_a_repetition_in_each_chunk(tmp_path, undisturbed, monkeypatch):
    path = tmp_path / "r.zarr"
    with monkeypatch.context() as before:
        before.setattr(layout, "SCHEMA", 1)
        before.setattr(layout, "FEWEST_BLOCKS", 100)
        attributes = layout.layout
        before.setattr(
            store, "layout", lambda study, block, given=None: attributes(study, block, given or _schema_1(study))
        )
        run(STUDY.with_changes({"ensemble.repetitions": 5}), store=path)
    assert store.info(path).versions["schema"] == "1"
    assert_same_bits(run(STUDY, store=path), undisturbed)
    assert store.info(path).versions["schema"] == "1"
    assert (path / "contact_area" / "c.0.0.21.0").exists()
    assert_same_bits(store.read(path), undisturbed)


def test_a_store_that_is_compressed_harder_is_read_and_continued(tmp_path, undisturbed):
    path = tmp_path / "r.zarr"
    with pytest.MonkeyPatch.context() as before:
        before.setattr(layout, "_LEVEL", 0)
        before.setattr(layout, "_zstd", numcodecs.Zstd(level=0, checksum=True))
        own = runner.computed(STUDY, path, part=(1, 2))
    stored = (path / "contact_area" / "c.0.0.0.0").read_bytes()
    with pytest.warns(UserWarning, match="12 of 22"):
        assert_same_bits(store.read(path), own)
    runner.computed(STUDY, path, part=(2, 2))
    assert_same_bits(store.read(path), undisturbed)
    assert (path / "contact_area" / "c.0.0.0.0").read_bytes() == stored


def _schema_1(study):
    """What the root of a store said before there were blocks."""
    from stiction import __version__

    return {"title": "stiction study", "stiction_version": __version__, "stiction_schema": 1}


def test_a_damaged_block_is_named_and_can_be_computed_again(tmp_path, undisturbed):
    path = tmp_path / "r.zarr"
    run(STUDY, store=path)
    (path / "contact_area" / "c.0.0.2.0").write_bytes(b"junk")
    with pytest.raises(
        StoreError, match=r"damaged: contact_area/c\.0\.0\.2\.0(?s:.)*repetitions 8 to 11 computed again"
    ):
        store.read(path)
    (path / "complete" / "c.2").unlink()
    assert_same_bits(run(STUDY, store=path), undisturbed)


def test_two_writers_of_a_block_keep_what_each_has(tmp_path, undisturbed):
    """As when a worker that was given up for lost comes back: neither takes from the other, in whatever order."""
    with store.opened(tmp_path / "r.zarr", STUDY) as kept:
        everything = [sums_of(*each) for each in ((4, 5), (5, 6), (7,))]
        start = threading.Barrier(3)

        def write(each):
            start.wait()
            kept.writing.save(*each)

        with ThreadPoolExecutor(3) as pool:
            list(pool.map(write, zip(((4, 5), (5, 6), (7,)), everything, strict=True)))
        assert kept.writing.blocks.finished(22).tolist() == [4, 5, 6, 7]
    with pytest.warns(UserWarning, match="4 of 22"):
        assert_same_bits(store.read(tmp_path / "r.zarr"), undisturbed.isel(repetition=slice(4, 8)))


def test_a_block_that_somebody_else_holds_is_waited_for_and_then_refused(tmp_path, monkeypatch):
    monkeypatch.setattr(blocks, "PATIENCE", 0.1)
    with store.opened(tmp_path / "r.zarr", STUDY) as kept, locked(tmp_path / "r.zarr" / "complete" / "block-0.lock"):
        kept.writing.save([4], sums_of(4))
        with pytest.raises(StoreError, match=r"somebody else has been writing block 0 for 0\.1 s"):
            kept.writing.save([0], sums_of(0))


# ---- Workers --------------------------------------------------------------------------------------------------------


def test_workers_write_where_they_see_the_store(tmp_path, undisturbed, monkeypatch):
    monkeypatch.setattr(runner, "MOST_SUBMITTED", 2)
    said = []
    with processes(2) as pool:
        result = runner.computed(STUDY, tmp_path / "r.zarr", executor=pool, say=said.append)
    assert_same_bits(result, undisturbed)
    assert "the workers write them" in said[0]
    assert_nothing_is_left(tmp_path / "r.zarr")


class Elsewhere(Inline):
    """Another machine, on which the store is not."""

    def submit(self, function, /, *args, **kwargs):
        args = [self.moved(each) if isinstance(each, blocks.Writing) else each for each in args]
        return super().submit(function, *args, **kwargs)

    def moved(self, writing):
        return dataclasses.replace(writing, blocks=dataclasses.replace(writing.blocks, path=Path("/nowhere")))


def test_workers_that_do_not_see_the_store_send_their_repetitions(tmp_path, undisturbed, monkeypatch):
    saved, save = [], store.Store.save
    monkeypatch.setattr(store.Store, "save", lambda self, *each: saved.append(each[0]) or save(self, *each))
    said = []
    assert_same_bits(runner.computed(STUDY, tmp_path / "r.zarr", executor=Elsewhere(), say=said.append), undisturbed)
    assert "the workers do not see the store, so this process writes them" in said[0]
    assert sorted(itertools.chain(*saved)) == list(range(22))


def test_a_lock_that_somebody_removes_ends_the_command(tmp_path):
    with store.opened(tmp_path / "r.zarr", STUDY) as kept:
        (tmp_path / "r.zarr" / "complete" / kept.writing.writer).unlink()
        with pytest.raises(StoreError, match=r"somebody removed writer-.*\.lock, by which its writer is known"):
            kept.save([0], sums_of(0))


def test_what_a_worker_stored_before_it_died_is_not_computed_again(tmp_path, computed):
    """Its task is given to another one, because nobody was told."""
    with store.opened(tmp_path / "r.zarr", STUDY) as kept:
        text = STUDY.to_toml()
        assert runner.task(runner.__version__, text, [4, 6], kept.writing) == (2, None)
        assert runner.task(runner.__version__, text, [4, 5, 6, 7], kept.writing) == (4, None)
        assert runner.task(runner.__version__, text, [4, 5, 6, 7], kept.writing) == (4, None)
    assert computed == [4, 6, 5, 7]


def test_the_store_is_known_by_its_root_and_by_the_lock_of_who_opened_it(tmp_path):
    path = tmp_path / "r.zarr"
    with store.opened(path, STUDY) as kept:
        assert kept.writing.is_shared()
        shutil.copytree(path, tmp_path / "copy.zarr")
        elsewhere = blocks.Blocks(tmp_path / "copy.zarr", path, 4)
        assert not blocks.Writing(elsewhere, kept.writing.root, kept.writing.writer).is_shared()
        assert not blocks.Writing(kept.writing.blocks, kept.writing.root + 1, kept.writing.writer).is_shared()
    assert not kept.writing.is_shared()
    assert not kept.writing.save([4], sums_of(4))
    assert store.info(path).finished == 0
    assert not is_locked(path / "none")


# ---- Parts ----------------------------------------------------------------------------------------------------------


def test_parts_meet_in_one_store(tmp_path, undisturbed, computed):
    """Each computes its own blocks, twice nothing; what one leaves is computed by whoever comes without a part."""
    path = tmp_path / "r.zarr"
    own = {}
    for part in ((2, 3), (1, 3)):
        del computed[:]
        result = runner.computed(STUDY, path, part=part)
        own[part] = result["repetition"].values.tolist()
        assert sorted(computed) == own[part]
        runner.computed(STUDY, path, part=part)
        assert sorted(computed) == own[part]
        xarray.testing.assert_identical(result, undisturbed.isel(repetition=own[part]))
    assert own == {(2, 3): [*range(4, 8), *range(16, 20)], (1, 3): [*range(4), *range(12, 16)]}
    assert store.info(path).finished == 16
    del computed[:]
    assert_same_bits(run(STUDY, store=path), undisturbed)
    assert sorted(computed) == [8, 9, 10, 11, 20, 21]
    assert_nothing_is_left(path)


def test_parts_that_begin_at_the_same_moment(tmp_path, undisturbed):
    parts = [(each, 4) for each in range(1, 5)]
    with ThreadPoolExecutor(4) as pool:
        list(pool.map(lambda part: runner.computed(STUDY, tmp_path / "r.zarr", part=part), parts))
    assert store.info(tmp_path / "r.zarr").finished == 22
    assert_same_bits(store.read(tmp_path / "r.zarr"), undisturbed)
    assert_nothing_is_left(tmp_path / "r.zarr")


def test_who_may_be_there_at_a_time(tmp_path, monkeypatch):
    """Parts beside each other, no part twice, and nobody else; nor a part beside somebody who has it alone."""
    path = tmp_path / "r.zarr"
    monkeypatch.setattr(store, "PATIENCE", 0.5)
    with contextlib.ExitStack() as others:
        for part in ((1, 3), (2, 3)):
            others.enter_context(store.opened(path, STUDY, part))
        with pytest.raises(StoreError, match="somebody else is computing part 2/3 of it"):
            runner.computed(STUDY, path, part=(2, 3))
        with pytest.raises(StoreError, match="somebody else is writing it"):
            run(STUDY, store=path)
        more = STUDY.with_changes({"ensemble.repetitions": 30})  # which changes the metadata
        with pytest.raises(StoreError, match="somebody else is writing it"):
            runner.computed(more, path, part=(3, 3))
        with pytest.raises(StoreError, match="another study"):
            runner.computed(STUDY.with_changes({"ensemble.seed": 1}), path, part=(3, 3))
    with store.opened(path, STUDY), pytest.raises(StoreError, match="somebody else is writing it"):
        runner.computed(STUDY, path, part=(1, 3))
    assert_nothing_is_left(path)


def test_the_command_computes_a_part(tmp_path, undisturbed):
    (tmp_path / "s.toml").write_text(STUDY.to_toml())
    for part in ("0/2", "3/2", "1", "a/b", "1/2/3", "-1/2"):
        assert_refused(
            stiction_command("run", "s.toml", f"--part={part}", cwd=tmp_path), "--part must be one of so many"
        )
    for number in (1, 2):
        done = stiction_command("run", "s.toml", "--part", f"{number}/2", "--store", "shared", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert f"part {number}/2 is finished" in done.stdout
    assert "22 of 22 are in shared/result.zarr" in done.stdout
    done = stiction_command("run", "s.toml", "--output", "shared", cwd=tmp_path)
    assert "holds this study already" in done.stdout
    assert_same_bits(store.read(Path(tmp_path, "shared", "result.zarr")), undisturbed)
