import errno
import itertools
import json
import os
import shutil
import signal
import subprocess
import sys
import time
import tracemalloc
from concurrent.futures import Future, ThreadPoolExecutor

import numcodecs
import numpy as np
import pytest
import stiction
import xarray
import zarr
from command import assert_refused, stiction_command
from stiction import Study, _files, run
from stiction.mechanics.quantities import SUMS
from stiction.studies import blocks, layout, runner, store
from stiction.studies.dataset import empty_dataset
from stiction.studies.export import ExportError, export
from stiction.studies.layout import SCHEMA
from stiction.studies.store import StoreError

SMALL = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 3},
        "surfaces.amplitude": ["50 nm", "100 nm"],
        "surfaces.points": 2000,
        "surfaces.extent": "2 um",
        "contact.approach.count": 4,
        "ensemble.repetitions": 4,
    }
)
MORE = SMALL.with_changes({"ensemble.repetitions": 7})


@pytest.fixture(scope="module")
def undisturbed():
    return run(SMALL)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """A finished store, to be copied."""
    path = tmp_path_factory.mktemp("whole") / "result.zarr"
    run(SMALL, store=path)
    return path


@pytest.fixture
def finished(whole, tmp_path):
    """A finished store of one's own."""
    return shutil.copytree(whole, tmp_path / "result.zarr")


@pytest.fixture
def unfinished(finished):
    """Repetitions 0 and 2 of SMALL."""
    for repetition in (1, 3):
        (finished / "complete" / f"c.{repetition}").unlink()
    return finished


@pytest.fixture
def no_computing(monkeypatch):
    monkeypatch.setattr(runner, "repetition_sums", lambda *_: pytest.fail("computed"))


@pytest.fixture
def computed(monkeypatch):
    """The repetitions that are computed."""
    repetitions, sums = [], runner.repetition_sums

    def record(study, repetition):
        repetitions.append(repetition)
        return sums(study, repetition)

    monkeypatch.setattr(runner, "repetition_sums", record)
    return repetitions


class Inline(ThreadPoolExecutor):
    """Computes in order, in the thread that asks; so what is done when is known."""

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        future.set_result(function(*args, **kwargs))
        return future


def assert_same_bits(one, other):
    xarray.testing.assert_identical(one, other)
    for name in one.variables:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


def chunks(path):
    """(repetition, file): inode and time of every chunk of a finished repetition."""
    repetitions = [file.name.removeprefix("c.") for file in (path / "complete").glob("c.*")]
    written = [path / name / f"c.0.0.{repetition}.0" for repetition in repetitions for name in SUMS]
    return {str(file): (file.stat().st_ino, file.stat().st_mtime_ns) for file in written}


def change_root(path, **attributes):
    root = json.loads((path / "zarr.json").read_bytes())
    root["attributes"] |= attributes
    root["attributes"]["checksum"] = layout.checksum(root["attributes"])
    (path / "zarr.json").write_text(json.dumps(root))


# ---- Written, continued, extended -----------------------------------------------------------------------------------


def test_gives_back_what_was_written(tmp_path, undisturbed):
    path = tmp_path / "deep" / "result.zarr"
    assert_same_bits(run(SMALL, store=path), undisturbed)
    assert_same_bits(store.read(path), undisturbed)
    assert os.listdir(path.parent) == ["result.zarr"]


def test_a_store_is_laid_out_as_zarr_would(tmp_path):
    """Of every kind of array: of numbers, counts and flags, over all dimensions that a result may have."""
    study = MORE.with_changes({"contact.sliding": ["opposing", "all"]})
    written = {}
    group = zarr.create_group(zarr.storage.MemoryStore(written), zarr_format=3)
    dataset = empty_dataset(study)
    dataset["complete"] = xarray.Variable(
        "repetition", np.zeros(dataset.sizes["repetition"], np.bool_), {"long_name": "whether it is finished"}
    )
    for name, variable in dataset.variables.items():
        if name != "sliding":
            in_chunk = 4096 if name == "repetition" else 2
            array = group.create_array(
                name,
                shape=variable.shape,
                dtype=variable.dtype,
                chunks=[in_chunk if dim == "repetition" else size for dim, size in variable.sizes.items()],
                fill_value=layout.FILL[variable.dtype.kind],
                compressors=zarr.codecs.ZstdCodec(level=layout._LEVEL, checksum=True),
                chunk_key_encoding={"name": "default", "separator": "."},
                dimension_names=variable.dims,
                attributes=variable.attrs,
            )
            if name in dataset.coords:
                array[...] = variable.values
    expected = {name: buffer.to_bytes() for name, buffer in written.items()}
    found = layout.layout(study, 2)
    assert list(found)[-2:] == ["complete/zarr.json", "zarr.json"]
    assert found.keys() == expected.keys()
    for name in found.keys() - {"zarr.json"}:
        as_read = json.loads if name.endswith("json") else bytes
        assert as_read(found[name]) == as_read(expected[name]), name
    root, as_zarr = (json.loads(each["zarr.json"]) for each in (found, expected))
    assert root | {"attributes": {}} == as_zarr


def test_zarr_and_xarray_read_the_same(whole, undisturbed):
    with xarray.open_zarr(whole, consolidated=False) as stored:
        stored.load()
    assert stored["complete"].values.all()
    for name, variable in undisturbed.variables.items():
        assert stored[name].variable.identical(variable), name
    assert undisturbed.attrs.items() <= stored.attrs.items()


def test_others_see_nothing_in_repetitions_that_are_not_there(unfinished):
    for name in SUMS:
        (unfinished / name / "c.0.0.3.0").unlink()
    with xarray.open_zarr(unfinished, consolidated=False) as stored:
        assert stored["complete"].values.tolist() == [True, False, True, False]
        assert np.isnan(stored["normal_elastic"].values[:, :, 3]).all()
        assert (stored["contact_count"].values[:, :, 3] == -1).all()


def test_every_bit_is_kept(tmp_path):
    """Zeros, signed or not, and values that fill what is missing."""
    study = SMALL.with_changes({"ensemble.repetitions": 1})
    shape = empty_dataset(study)["normal_elastic"].values[:, :, 0].shape
    sums = {name: np.full(shape, -1 if name.endswith("_count") else value) for name, value in
            zip(SUMS, itertools.cycle([-0.0, np.nan, 0.0, np.inf, 5e-324]), strict=False)}  # fmt: skip
    with store.opened(tmp_path / "r.zarr", study) as kept:
        kept.writing.save([0], {name: values[:, :, np.newaxis] for name, values in sums.items()})
    for name in SUMS:
        assert store.read(tmp_path / "r.zarr")[name].values.tobytes() == sums[name].tobytes(), name


def test_a_finished_one_is_read(finished, undisturbed, no_computing):
    before = chunks(finished)
    assert_same_bits(run(SMALL, store=finished), undisturbed)
    assert chunks(finished) == before


def test_an_unfinished_one_is_continued(unfinished, undisturbed, computed):
    before = chunks(unfinished)
    assert_same_bits(run(SMALL, store=unfinished), undisturbed)
    assert sorted(computed) == [1, 3]
    assert before.items() <= chunks(unfinished).items()
    assert_same_bits(store.read(unfinished), undisturbed)


def test_repetitions_are_added(finished, computed):
    before = chunks(finished)
    result = run(MORE, store=finished)
    assert sorted(computed) == [4, 5, 6]
    assert before.items() <= chunks(finished).items()
    assert_same_bits(result, run(MORE))
    assert_same_bits(store.read(finished), result)
    assert xarray.open_zarr(finished, consolidated=False).sizes["repetition"] == 7


def test_repetitions_are_added_to_an_unfinished_one(unfinished, computed):
    assert_same_bits(run(MORE, store=unfinished), run(MORE))
    assert sorted(computed)[:5] == [0, 1, 1, 2, 3]  # 0 and 2 by the undisturbed run alone


def test_fewer_repetitions_only_where_none_is_dropped(unfinished, no_computing, monkeypatch):
    with pytest.raises(StoreError, match=r"ensemble.repetitions = 2 would drop it; ask for at least 3"):
        run(SMALL.with_changes({"ensemble.repetitions": 2}), store=unfinished)
    monkeypatch.undo()
    three = SMALL.with_changes({"ensemble.repetitions": 3})
    assert_same_bits(run(three, store=unfinished), run(three))
    assert store.info(unfinished).finished == store.info(unfinished).study.ensemble.repetitions == 3


def test_an_unfinished_one_is_read_as_far_as_it_is(unfinished, undisturbed):
    with pytest.warns(UserWarning, match="2 of 4 repetitions are finished"):
        part = store.read(unfinished)
    assert_same_bits(part, undisturbed.isel(repetition=[0, 2]))
    assert (store.info(unfinished).finished, store.info(unfinished).study) == (2, SMALL)
    for repetition in (0, 2):
        (unfinished / "complete" / f"c.{repetition}").unlink()
    with pytest.raises(StoreError, match="none of its 4 repetitions"):
        store.read(unfinished)


def test_the_size_is_what_the_disk_gives(finished):
    assert store.info(finished).size > sum(file.stat().st_size for file in finished.rglob("c.*"))


# ---- Refused --------------------------------------------------------------------------------------------------------


def test_another_study_is_refused_by_what_differs(unfinished, no_computing):
    with pytest.raises(StoreError) as refusal:
        run(SMALL.with_changes({"ensemble.seed": 1, "contact.law": "hertz-cylinder"}), store=unfinished)
    assert 'contact.law = "hertz-sphere" there, "hertz-cylinder" here' in str(refusal.value)
    assert "ensemble.seed = 2_016 there, 1 here" in str(refusal.value)
    many = SMALL.with_changes({f"surfaces.{key}": 30 for key in ("gamma", "directions", "frequencies", "points")} | {
        "surfaces.extent": "9 um", "surfaces.amplitude": [f"{each} nm" for each in range(1, 60)]})  # fmt: skip
    with pytest.raises(StoreError, match="and 2 more") as refusal:
        run(many, store=unfinished)
    assert all(len(line) < 200 for line in str(refusal.value).splitlines())


def test_where_nothing_is_finished_another_study_is_begun(tmp_path, undisturbed):
    with pytest.raises(ValueError, match="gamma"):
        run(SMALL.with_changes({"surfaces.gamma": 100.0}), store=tmp_path / "r.zarr")
    assert_same_bits(run(SMALL, store=tmp_path / "r.zarr"), undisturbed)
    assert_same_bits(store.read(tmp_path / "r.zarr"), undisturbed)
    assert os.listdir(tmp_path) == ["r.zarr"]


def test_the_same_study_in_other_words_is_not_refused(unfinished):
    same = SMALL.with_changes({"surfaces.amplitude": ["0.05 um", "0.1 um"]})
    assert run(same, store=unfinished).attrs["study"] == store.read(unfinished).attrs["study"] == same.to_toml()


def test_another_version_must_not_finish_what_this_one_began(unfinished, no_computing):
    change_root(unfinished, stiction_version="0.0.9")
    with pytest.raises(StoreError, match=rf"begun by stiction 0\.0\.9 and this is {stiction.__version__}"):
        run(SMALL, store=unfinished)


def test_what_another_version_finished_is_read(finished, no_computing):
    change_root(finished, stiction_version="0.0.9")
    assert run(SMALL, store=finished).attrs["stiction_version"] == "0.0.9"
    with pytest.raises(StoreError, match=r"begun by stiction 0\.0\.9"):
        run(MORE, store=finished)


def test_another_arithmetic_must_not_finish_what_this_one_began(unfinished, no_computing):
    approach = SMALL.contact.approaches()
    approach[1] = np.nextafter(approach[1], 1)
    file = unfinished / "approach" / "c.0"
    file.write_bytes(layout.encoded(file, approach))
    with pytest.raises(StoreError, match="approach differs in the last digits"):
        run(SMALL, store=unfinished)
    with pytest.warns(UserWarning, match="2 of 4"):
        assert store.read(unfinished)["approach"].values.tolist() == approach.tolist()


def test_a_newer_schema_is_said_so(finished):
    change_root(finished, stiction_schema=SCHEMA + 1, stiction_version="9.1", study="[unheard_of]")
    for use in (store.read, store.info, lambda path: run(SMALL, store=path)):
        with pytest.raises(StoreError, match=rf"has schema {SCHEMA + 1}, written by stiction 9\.1"):
            use(finished)


def test_foreign_things_are_no_results(tmp_path):
    (tmp_path / "empty").mkdir()
    (tmp_path / "file").write_text("mine")
    xarray.Dataset({"a": ("x", [1.0])}).to_zarr(tmp_path / "other", zarr_format=3, consolidated=False)
    before = sorted(tmp_path.rglob("*"))
    for name, use in itertools.product(
        ("empty", "file", "other"), (store.read, store.info, lambda path: run(SMALL, store=path))
    ):
        with pytest.raises(StoreError, match=f"{name}: is not a result of stiction"):
            use(tmp_path / name)
    assert sorted(tmp_path.rglob("*")) == before
    with pytest.raises(StoreError, match="is not a result of stiction"):
        store.read(tmp_path / "none")


def test_a_place_that_cannot_be_written_is_refused_before_anything_is_computed(tmp_path, no_computing):
    (tmp_path / "file").write_text("")
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    for place in ("file/result.zarr", "loop", "loop/result.zarr", "n" * 300):
        with pytest.raises(StoreError, match=r"cannot be written|is not a result"):
            run(SMALL, store=tmp_path / place)


def test_a_link_is_followed(tmp_path, undisturbed):
    (tmp_path / "scratch").mkdir()
    (tmp_path / "result.zarr").symlink_to(tmp_path / "scratch" / "r.zarr")
    run(SMALL, store=tmp_path / "result.zarr")
    assert_same_bits(store.read(tmp_path / "scratch" / "r.zarr"), undisturbed)


# ---- Damaged --------------------------------------------------------------------------------------------------------


def test_no_flipped_bit_goes_unnoticed(finished, undisturbed):
    """In a chunk, a flag, a coordinate and the root: said so, or the result is as it was."""
    noticed = 0
    for name in ("normal_elastic/c.0.0.2.0", "contact_count/c.0.0.0.0", "complete/c.1", "approach/c.0", "zarr.json"):
        content = (finished / name).read_bytes()
        for bit in range(0, 8 * len(content), 8 * len(content) // 30):
            flipped = bytearray(content)
            flipped[bit // 8] ^= 1 << bit % 8
            (finished / name).write_bytes(flipped)
            try:
                result = store.read(finished)
            except StoreError:
                noticed += 1
            else:
                assert_same_bits(result, undisturbed)
        (finished / name).write_bytes(content)
    assert noticed > 75


@pytest.mark.parametrize("name", ["normal_elastic/c.0.0.2.0", "complete/c.2"])
@pytest.mark.parametrize("content", [None, b"", b"junk", np.zeros(3)], ids=["none", "", "junk", "size"])
def test_a_damaged_repetition_is_named_and_can_be_computed_again(finished, undisturbed, name, content):
    if content is None:
        if name.startswith("complete"):
            return  # then it is not finished
        (finished / name).unlink()
    else:
        file = finished / name
        file.write_bytes(content if isinstance(content, bytes) else layout.encoded(file, content))
    for use in (store.read, lambda path: run(SMALL, store=path)):
        with pytest.raises(StoreError, match=rf"is damaged: {name}(?s:.)*remove (.*complete/c\.2) and") as damage:
            use(finished)
    file = str(damage.value).split("remove ")[1].split(" and run")[0]
    os.unlink(file)
    assert_same_bits(run(SMALL, store=finished), undisturbed)


def test_damaged_metadata_are_said_so_and_written_anew(finished, undisturbed):
    array = json.loads((finished / "contact_area" / "zarr.json").read_bytes())
    array["attributes"]["units"] = "um"
    for content in (b"", b"[]", json.dumps(array).encode(), None):
        if content is None:
            shutil.rmtree(finished / "approach")
        else:
            (finished / "contact_area" / "zarr.json").write_bytes(content)
        with pytest.raises(StoreError, match=r"is damaged: (contact_area|approach)/zarr.json; running"):
            store.read(finished)
        assert_same_bits(run(SMALL, store=finished), undisturbed)
        assert_same_bits(store.read(finished), undisturbed)


@pytest.mark.parametrize("content", [b"", b"[]", b"{}", b"\xff", b"[" * 100_000])
def test_a_damaged_root_is_said_so(finished, content):
    (finished / "zarr.json").write_bytes(content)
    for use in (store.read, store.info, lambda path: run(SMALL, store=path)):
        with pytest.raises(StoreError, match="is not a result of stiction, or is damaged"):
            use(finished)
    shutil.rmtree(finished / "complete")


def test_without_flags_it_is_damaged(finished):
    shutil.rmtree(finished / "complete")
    with pytest.raises(StoreError, match="is damaged: complete"):
        store.read(finished)


# ---- Disturbed ------------------------------------------------------------------------------------------------------


def test_a_second_writer_is_refused_at_once(unfinished, undisturbed):
    with store.opened(unfinished, SMALL) as kept:
        for _ in range(2):
            with pytest.raises(StoreError, match="somebody else is writing it"):
                run(SMALL, store=unfinished)
        (unfinished.parent / "s.toml").write_text(SMALL.to_toml())
        command = [sys.executable, "-m", "stiction", "run", "s.toml", "--output", "."]
        done = subprocess.run(command, cwd=unfinished.parent, capture_output=True, text=True, check=False, timeout=60)
        assert done.returncode == 2
        assert "somebody else is writing it" in done.stderr
        sums = runner.repetition_sums(SMALL, 1)
        kept.writing.save([1], {name: values[:, :, np.newaxis] for name, values in sums.items()})
    assert not unfinished.with_name("result.zarr.lock").exists()
    assert_same_bits(run(SMALL, store=unfinished), undisturbed)


def test_of_many_writers_one_writes(tmp_path, undisturbed):
    def write(_):
        try:
            return run(SMALL, store=tmp_path / "r.zarr")
        except StoreError as error:
            return str(error)

    with ThreadPoolExecutor(8) as pool:
        results = list(pool.map(write, range(24)))
    wrote = [result for result in results if not isinstance(result, str)]
    assert wrote
    for result in wrote:
        assert_same_bits(result, undisturbed)
    assert {result for result in results if isinstance(result, str)} <= {
        f"{tmp_path / 'r.zarr'}: somebody else is writing it"
    }
    assert os.listdir(tmp_path) == ["r.zarr"]


@pytest.mark.parametrize("replaced", [False, True])
def test_a_store_that_is_removed_underneath_is_not_made_again(tmp_path, monkeypatch, replaced):
    save = blocks.Writing.save

    def save_and_remove(self, repetitions, sums):
        save(self, repetitions, sums)
        if repetitions[0] == 1:
            (tmp_path / "r.zarr").rename(tmp_path / "moved")
            if replaced:
                (tmp_path / "r.zarr").mkdir()

    monkeypatch.setattr(blocks.Writing, "save", save_and_remove)
    with pytest.raises(StoreError, match="was removed or replaced"):
        run(SMALL, store=tmp_path / "r.zarr", executor=Inline())
    assert not replaced or os.listdir(tmp_path / "r.zarr") == []
    assert replaced or os.listdir(tmp_path) == ["moved"]


def test_removing_it_after_the_last_repetition_is_noticed(tmp_path):
    with pytest.raises(StoreError, match="was removed"), store.opened(tmp_path / "r.zarr", SMALL):
        shutil.rmtree(tmp_path / "r.zarr")


def test_a_full_disk_loses_nothing(tmp_path, undisturbed, monkeypatch):
    """At whatever file it fills up: one message, then continued."""
    write, space = _files.Path.write_bytes, 0

    def write_while_there_is_space(self, content):
        nonlocal space
        space -= 1
        if space < 0:
            write(self, content[:3])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(self, content)

    monkeypatch.setattr(_files.Path, "write_bytes", write_while_there_is_space)
    path, fewest = tmp_path / "r.zarr", 0
    for refusals in itertools.count():
        space = 40 if refusals else 5  # not enough to begin, then for one repetition, then for three
        try:
            result = run(SMALL, store=path, executor=Inline())
            break
        except StoreError as error:
            said = str(error)
        assert "cannot be written: No space left on device" in said
        finished = store.info(path).finished if path.exists() else 0
        assert not path.exists() or f"{finished} of 4 repetitions are finished and kept" in said
        assert fewest <= finished
        fewest = finished
        assert refusals < 20
    assert refusals >= 2
    assert_same_bits(result, undisturbed)
    assert_same_bits(store.read(path), undisturbed)
    assert not list(tmp_path.rglob("*.partial"))


SMALL_DISK = """
import pathlib, resource, sys
from stiction import Study
from stiction.cli import main
import stiction.studies.store, stiction.views.figures
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv.pop()),) * 2)
main()
"""


def test_the_command_says_that_a_file_cannot_be_written_and_goes_on_later(tmp_path, undisturbed):
    """A limit of the system's own on the size of a file, in place of a full disk."""
    (tmp_path / "s.toml").write_text(SMALL.to_toml())
    for limit in (100, 600):
        done = subprocess.run(
            [sys.executable, "-c", SMALL_DISK, "run", "s.toml", "--output", "out", str(limit)],
            cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60,
        )  # fmt: skip
        assert done.returncode == 2
        assert "out/result.zarr: cannot be written: File too large" in done.stderr
        assert len(done.stderr.splitlines()) <= 2
    result = run(SMALL, store=tmp_path / "out" / "result.zarr")
    assert_same_bits(result, undisturbed)


def test_an_export_that_does_not_fit_is_one_message(tmp_path):
    run(SMALL, store=tmp_path / "out" / "result.zarr")
    done = subprocess.run(
        [sys.executable, "-c", SMALL_DISK, "export", "out", "r.nc", "2000"],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=60,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (2, "stiction: r.nc: cannot be written: File too large\n")
    assert os.listdir(tmp_path) == ["out"]


@pytest.fixture
def small_disk(tmp_path):
    """A directory on a file system of 1 MiB."""
    directory = tmp_path / "disk"
    directory.mkdir()
    options = ["-t", "tmpfs", "-o", "size=1m", "tmpfs", directory]
    if os.geteuid() != 0 or not shutil.which("mount") or subprocess.run(["mount", *options], check=False).returncode:
        pytest.skip("a small file system needs root and the right to mount")
    yield directory
    subprocess.run(["umount", "--lazy", directory], check=True)


def test_a_disk_that_is_full(small_disk, tmp_path):
    many = SMALL.with_changes({"ensemble.repetitions": 30})
    path = small_disk / "r.zarr"
    with pytest.raises(
        StoreError, match=r"No space left on device\n(\d+) of 30 repetitions are finished and kept"
    ) as full:
        run(many, store=path)
    kept = store.info(path).finished
    assert f"\n{kept} of 30" in str(full.value)
    assert 5 < kept < 30
    with pytest.raises(StoreError, match=f"{kept} of 30 repetitions are finished and kept"):
        run(many, store=path)
    with pytest.warns(UserWarning, match="repetitions are finished"):
        part = store.read(path)
    with pytest.raises(ExportError, match="cannot be written"):
        export(run(many), small_disk / "r.nc")
    assert os.listdir(small_disk) == ["r.zarr"]
    subprocess.run(["mount", "-o", "remount,size=20m", small_disk], check=True)
    undisturbed = run(many)
    assert_same_bits(part, undisturbed.isel(repetition=part["repetition"].values))
    assert_same_bits(run(many, store=path), undisturbed)


def test_a_disk_that_is_read_only(small_disk):
    for made in (False, True):
        if made:
            run(SMALL.with_changes({"ensemble.repetitions": 1}), store=small_disk / "r.zarr")
        subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
        with pytest.raises(StoreError, match="cannot be written: Read-only file system"):
            run(SMALL, store=small_disk / "r.zarr")
        subprocess.run(["mount", "-o", "remount,rw", small_disk], check=True)


# ---- Killed ---------------------------------------------------------------------------------------------------------

KILLED_EVERYWHERE = """
import itertools, os, shutil, signal, sys, warnings
from concurrent.futures import Future
from pathlib import Path
from stiction import Study, run
from stiction.studies import store
import numcodecs, xarray, zarr

class Inline:
    def submit(self, function, *args):
        future = Future()
        future.set_result(function(*args))
        return future

def in_child(function, *args):
    child = os.fork()
    if child == 0:
        try:
            function(*args)
            os._exit(0)
        except BaseException as error:
            print(repr(error), file=sys.stderr, flush=True)
            os._exit(1)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])

def run_until(step, study):
    # What changes the disk is counted, and the step-th change does not come; of a file half is written.
    left = step
    def counted(name):
        method = getattr(Path, name)
        def change(self, *args, **kwargs):
            nonlocal left
            left -= 1
            if left == 0:
                if name == "write_bytes":
                    method(self, args[0][:len(args[0]) // 2])
                os.kill(os.getpid(), signal.SIGKILL)
            return method(self, *args, **kwargs)
        setattr(Path, name, change)
    for name in ("write_bytes", "replace", "rename", "mkdir", "rmdir", "unlink"):
        counted(name)
    run(study, store="r.zarr", executor=Inline())

def finish(study):
    if before:
        warnings.simplefilter("ignore")
        part = store.read("r.zarr").isel(repetition=slice(before))
        assert all((part[name] == undisturbed[name][:, :, :before]).all() for name in part.data_vars)
    result = run(study, store="r.zarr", executor=Inline())
    assert result.identical(undisturbed)
    assert all(result[name].values.tobytes() == undisturbed[name].values.tobytes() for name in result.variables)
    assert store.read("r.zarr").identical(undisturbed)
    assert xarray.open_zarr("r.zarr", consolidated=False)["complete"].values.all()
    assert not list(Path().rglob("*.partial")) and not Path("r.zarr.lock").exists()

for file in sys.argv[1:]:
    study = Study.from_toml(file)
    undisturbed = run(study, executor=Inline())
    before = store.info("before.zarr").finished if Path("before.zarr").exists() else 0
    for step in itertools.count(1, 9):  # an odd stride: writing and renaming take turns
        shutil.rmtree("r.zarr", ignore_errors=True)
        if before:
            shutil.copytree("before.zarr", "r.zarr")
        status = in_child(run_until, step, study)
        if status == 0:
            break
        assert status == -signal.SIGKILL
        assert (store.info("r.zarr").finished if Path("r.zarr").exists() else 0) >= before
        assert in_child(finish, study) == 0, step
    print(step // 9)
    shutil.rmtree("before.zarr", ignore_errors=True)
    os.rename("r.zarr", "before.zarr")
"""


def test_killed_before_any_change_of_the_disk(tmp_path):
    """While it is begun, and while repetitions are added; and finished after each kill."""
    for repetitions in (1, 2):
        study = SMALL.with_changes({"ensemble.repetitions": repetitions})
        (tmp_path / f"{repetitions}.toml").write_text(study.to_toml())
    done = subprocess.run(
        [sys.executable, "-c", KILLED_EVERYWHERE, "1.toml", "2.toml"],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert all(int(kills) > 3 for kills in done.stdout.split()), done.stdout


def test_a_forked_worker_does_not_hold_the_lock_of_its_parent(tmp_path):
    code = """
import os, signal, sys, time
from stiction import Study
from stiction.studies import store
with store.opened("r.zarr", Study()):
    if os.fork() == 0:
        print(flush=True)
        time.sleep(60)
    time.sleep(60)
"""
    process = subprocess.Popen(
        [sys.executable, "-c", code], cwd=tmp_path, stdout=subprocess.PIPE, start_new_session=True
    )
    try:
        assert process.stdout.readline()
        process.kill()  # and not its child
        process.wait(10)
        with store.opened(tmp_path / "r.zarr", Study()):
            pass
    finally:
        os.killpg(process.pid, signal.SIGKILL)
        process.stdout.close()


def test_interrupting_the_command_keeps_what_is_finished(tmp_path, undisturbed):
    long = SMALL.with_changes({"ensemble.repetitions": 20_000})
    (tmp_path / "s.toml").write_text(long.to_toml())
    process = subprocess.Popen(
        [sys.executable, "-m", "stiction", "run", "s.toml"], cwd=tmp_path, stderr=subprocess.PIPE, text=True
    )
    complete = tmp_path / "s" / "result.zarr" / "complete"
    deadline = time.monotonic() + 30
    while time.monotonic() < deadline and not (complete / "c.3").exists():
        time.sleep(0.01)
    assert process.poll() is None
    process.send_signal(signal.SIGINT)
    _, said = process.communicate(timeout=30)
    kept = store.info(tmp_path / "s" / "result.zarr").finished
    assert process.returncode == 130
    assert said == (
        f"stiction: interrupted; {kept} of 20000 repetitions are finished and kept: "
        "the same command goes on from there\n"
    )
    with pytest.warns(UserWarning, match="of 20000 repetitions"):
        part = store.read(tmp_path / "s" / "result.zarr")
    part = part.isel(repetition=part["repetition"].values < 4)
    assert part.sizes["repetition"] > 0
    for name in SUMS:
        assert part[name].identical(undisturbed.sel(repetition=part["repetition"])[name]), name


# ---- Foreign things -------------------------------------------------------------------------------------------------


def listed(folder):
    """Every file below a folder, and what is in it."""
    return {file: file.read_bytes() if file.is_file() else None for file in sorted(folder.rglob("*"))}


@pytest.mark.parametrize("what", ["folder", "chunk", "flag", "metadata", "root", "extra"])
def test_nothing_is_read_or_written_through_a_link(finished, tmp_path, undisturbed, what):
    outside = tmp_path / "outside"
    name = {"folder": "contact_area", "chunk": "contact_area/c.0.0.2.0", "flag": "complete/c.2",
            "metadata": "contact_area/zarr.json", "root": "zarr.json", "extra": "extra"}[what]  # fmt: skip
    place = finished / name
    if place.exists():
        place.rename(outside)
    else:
        outside.mkdir()
    if outside.is_dir():
        for mine in ("thesis.partial", ".stiction-0123456789abcdef.partial", "c.0.0.3.0"):
            (outside / mine).write_text("mine")
    place.symlink_to(outside)
    kept = listed(outside) if outside.is_dir() else outside.read_bytes()
    if what == "extra":
        assert_same_bits(run(SMALL, store=finished), undisturbed)
    else:
        for use in (store.read, lambda path: run(SMALL, store=path)):
            with pytest.raises(StoreError, match="is a link"):
                use(finished)
    assert kept == (listed(outside) if outside.is_dir() else outside.read_bytes())


@pytest.mark.parametrize("name", ["zarr.json", "contact_area/c.0.0.2.0", "complete/c.2"])
def test_pipes_and_devices_are_not_waited_for(finished, name):
    (finished / name).unlink()
    os.mkfifo(finished / name)
    for use in (store.read, lambda path: run(SMALL, store=path)):
        with pytest.raises(StoreError, match="is no regular file"):
            use(finished)


@pytest.mark.parametrize("name", ["contact_area/c.0.0.2.0", "complete/c.2"])
def test_what_unpacks_to_more_than_it_is_takes_no_memory(finished, name):
    bomb = bytes(numcodecs.Zstd(level=1, checksum=True).encode(np.zeros(50_000_000, np.uint8)))
    liar = bytes.fromhex("28b52ffde4") + (2**60).to_bytes(8, "little") + bytes([1, 0, 0])
    for content in (bomb, liar, bomb[:1000]):
        (finished / name).write_bytes(content)
        tracemalloc.start()
        with pytest.raises(StoreError, match=rf"is damaged: {name}"):
            store.read(finished)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < 5_000_000


def test_metadata_without_an_end_are_refused(finished):
    os.truncate(finished / "zarr.json", layout.MOST_METADATA + 1)
    with pytest.raises(StoreError, match=f"is longer than {layout.MOST_METADATA} bytes"):
        store.info(finished)


def test_a_chunk_of_another_repetition_or_variable_is_noticed(finished):
    for one, other in (
        ("contact_area/c.0.0.1.0", "contact_area/c.0.0.2.0"),
        ("contact_area/c.0.0.1.0", "normal_elastic/c.0.0.1.0"),
        ("complete/c.1", "complete/c.2"),
    ):
        kept = (finished / one).read_bytes()
        (finished / one).write_bytes((finished / other).read_bytes())
        with pytest.raises(StoreError, match=rf"is damaged: {one}: not what was written, or another chunk's"):
            store.read(finished)
        (finished / one).write_bytes(kept)


def test_a_store_whose_chunks_have_no_names_is_read_and_continued(unfinished, undisturbed):
    """As versions before wrote them."""
    for file in unfinished.rglob("c.*"):
        name = f"{file.parent.name}/{file.name}".encode()
        content = file.read_bytes()
        if content.endswith(name):
            file.write_bytes(content[: -len(name) - 8])
    with pytest.warns(UserWarning, match="2 of 4"):
        part = store.read(unfinished)
    assert_same_bits(part, undisturbed.isel(repetition=[0, 2]))
    assert_same_bits(run(SMALL, store=unfinished), undisturbed)


@pytest.mark.parametrize("schema", [True, 1.5, 1.0, "1", "2", None, [1]])
def test_a_schema_is_a_whole_number(finished, schema):
    change_root(finished, stiction_schema=schema)
    for use in (store.read, store.info, lambda path: run(SMALL, store=path)):
        with pytest.raises(StoreError, match="does not say what it is"):
            use(finished)


def test_a_refusal_touches_nothing(unfinished):
    (unfinished / "complete" / "c.1.partial").write_bytes(b"left by a killed writer")
    beside = unfinished.with_name("result.zarr.partial")
    beside.mkdir()
    (beside / "thesis").write_text("mine")
    before = listed(unfinished.parent)
    for other in ({"ensemble.seed": 1}, {"ensemble.repetitions": 1}):
        with pytest.raises(StoreError):
            run(SMALL.with_changes(other), store=unfinished)
        assert listed(unfinished.parent) == before


def test_what_is_not_of_stiction_is_not_removed(finished, undisturbed):
    """Neither in a store without repetitions, nor where a new one is begun, nor beside what is finished."""
    beside = finished.with_name("result.zarr.partial")
    for place in (finished / "thesis", finished / "extra.partial", finished / "contact_area" / "thesis.partial"):
        place.write_text("mine")
    run(SMALL, store=finished)
    for flag in (finished / "complete").glob("c.*"):
        flag.unlink()
    before = listed(finished)
    for name in ("thesis", "extra.partial", "contact_area/thesis.partial"):
        with pytest.raises(StoreError, match=r"holds no finished repetition, but .*, which is not of stiction"):
            run(SMALL, store=finished)
        assert listed(finished) == before
        (finished / name).unlink()
        del before[finished / name]
    beside.mkdir()
    (beside / "thesis").write_text("mine")
    with pytest.raises(StoreError, match=r"result\.zarr\.partial: holds no finished repetition, but thesis"):
        run(SMALL, store=finished)
    assert listed(finished) == before
    (beside / "thesis").unlink()
    assert_same_bits(run(SMALL, store=finished), undisturbed)
    assert not beside.exists()


def test_the_lock_is_that_of_the_store_itself(unfinished, tmp_path):
    """Whoever removes the file beside it, or comes by another name, is held off all the same."""
    (tmp_path / "other").mkdir()
    with store.opened(unfinished, SMALL):
        unfinished.with_name("result.zarr.lock").unlink()
        with pytest.raises(StoreError, match="somebody else is writing it"):
            run(SMALL, store=unfinished)
    with store.opened(tmp_path / "new.zarr", SMALL):
        (tmp_path / "new.zarr.lock").unlink()
        with pytest.raises(StoreError, match="somebody else is writing it"):
            run(SMALL, store=tmp_path / "new.zarr")


def test_a_finished_store_on_a_disk_that_is_read_only_is_drawn_elsewhere(small_disk, tmp_path, undisturbed):
    (tmp_path / "s.toml").write_text(SMALL.with_changes({"figures.draw": ["area"]}).to_toml())
    run(SMALL, store=small_disk / "result.zarr")
    subprocess.run(["mount", "-o", "remount,ro", small_disk], check=True)
    try:
        assert_same_bits(run(SMALL, store=small_disk / "result.zarr"), undisturbed)
        with pytest.raises(StoreError, match="another study"):
            run(SMALL.with_changes({"ensemble.seed": 1}), store=small_disk / "result.zarr")
        with pytest.raises(StoreError, match="Read-only file system"):
            run(MORE, store=small_disk / "result.zarr")
        done = stiction_command("plot", small_disk, "--output", tmp_path / "drawn", cwd=tmp_path)
        assert done.returncode == 0, done.stderr
        assert "area.png" in os.listdir(tmp_path / "drawn")
    finally:
        subprocess.run(["mount", "-o", "remount,rw", small_disk], check=True)


def test_foreign_words_in_a_store_move_no_cursor(finished, tmp_path):
    version = "\x1b]0;owned\x07\x1b[31m9\nstiction: all is well"
    change_root(finished, stiction_version=version, numpy_version="\x1b[2J" * 1000)
    done = stiction_command("info", finished.parent, cwd=tmp_path)
    assert done.returncode == 0
    assert "\x1b" not in done.stdout
    assert not any(line.startswith("stiction: ") for line in done.stdout.splitlines())
    change_root(finished, stiction_schema=SCHEMA + 1)
    done = stiction_command("info", finished.parent, cwd=tmp_path)
    assert_refused(done, "written by stiction \\x1b]0;owned")
    assert len(done.stderr.splitlines()) == 1


# ---- Exported -------------------------------------------------------------------------------------------------------


def test_an_exported_file_is_the_same_to_the_bit(tmp_path, undisturbed):
    changed = undisturbed.copy(deep=True)
    changed["normal_elastic"].values[0, 0, 0] = [np.nan, -0.0, np.inf, 5e-324]
    export(changed, tmp_path / "r.nc")
    with xarray.open_dataset(tmp_path / "r.nc", engine="h5netcdf") as exported:
        assert_same_bits(exported.load(), changed)
    assert list(exported.variables) == list(changed.variables)


def test_an_exported_file_is_not_written_over(tmp_path, undisturbed):
    (tmp_path / "mine.nc").write_text("mine")
    with pytest.raises(ExportError, match=r"mine\.nc: exists already"):
        export(undisturbed, tmp_path / "mine.nc")
    with pytest.raises(ExportError, match="cannot be written: No such file"):
        export(undisturbed, tmp_path / "none" / "r.nc")
    assert (tmp_path / "mine.nc").read_text() == "mine"
    assert os.listdir(tmp_path) == ["mine.nc"]


def test_friction_and_figures_may_change_without_computing_again(finished, no_computing):
    other = SMALL.with_changes({"friction.mu0": [0.25], "figures.draw": ["area"]})
    result = run(other, store=finished)
    assert store.info(finished).study == other
    assert store.read(finished).attrs["study"] == result.attrs["study"] == other.to_toml()
