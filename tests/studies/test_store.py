"""A result in its folder: what is there, what is continued, and what is refused."""

import contextlib
import errno
import io
import itertools
import os
import random
import shutil
import signal
import subprocess
import sys
import time
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from stiction import Result, _files, run
from stiction.studies import layout, runner, store
from stiction.studies.runner import compute_missing
from stiction.studies.store import BLOCKS_FOLDER, STUDY_FILE, Block, ExportError, StoreError, export
from support.generated_studies import TINY, InlineExecutor, assert_same_bits, rewrite_variable, with_repetitions

pytestmark = pytest.mark.usefixtures("blocks_of_four")


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """A finished folder, to be copied."""
    path = tmp_path_factory.mktemp("finished") / "r"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "choose_block_size", lambda study: 4)
        compute_missing(TINY, path)
    return path


@pytest.fixture
def whole(finished, tmp_path):
    """A finished folder of one's own."""
    return shutil.copytree(finished, tmp_path / "r")


def files(path):
    """(name, (inode, time)) of every block."""
    return {file.name: (file.stat().st_ino, file.stat().st_mtime_ns) for file in (path / BLOCKS_FOLDER).iterdir()}


def block_of(path, first):
    return next((path / BLOCKS_FOLDER).glob(f"{first:07d}-*.nc"))


def put(file, content):
    """Put a file in the place of a block, with the checksum of what it holds."""
    first, last, _ = file.stem.split("-")
    file.unlink()
    path = file.with_name(Block(int(first), int(last), zlib.crc32(content)).name)
    path.write_bytes(content)
    return path


def assert_nothing_is_left(path):
    assert not list(path.rglob("*.partial"))


# ---- Written and read -----------------------------------------------------------------------------------------------


def test_store_returns_what_was_written(tmp_path, undisturbed):
    path = tmp_path / "deep" / "r"
    assert_same_bits(run(TINY, store=path).dataset, undisturbed)
    assert_same_bits(store.read(path), undisturbed)
    assert sorted(os.listdir(path)) == [BLOCKS_FOLDER, STUDY_FILE]
    assert [file[:15] for file in sorted(files(path))] == [f"{k:07d}-{min(k + 3, 21):07d}" for k in range(0, 22, 4)]
    known = store.info(path)
    assert (known.study, known.finished) == (TINY, 22)
    assert known.size == sum(file.stat().st_size for file in (path / BLOCKS_FOLDER).iterdir())


def test_equal_members_have_equal_bytes(tmp_path, whole):
    compute_missing(TINY, tmp_path / "again", executor=InlineExecutor())
    assert files(whole).keys() == files(tmp_path / "again").keys()


def test_xarray_opens_blocks(whole, undisturbed):
    pytest.importorskip("dask")
    block_of(whole, 8).unlink()
    with xarray.open_mfdataset(str(whole / BLOCKS_FOLDER / "*.nc")) as opened:
        present = opened.load()
    expected = undisturbed.isel(repetition=[*range(8), *range(12, 22)])
    for name, variable in expected.variables.items():
        assert present[name].variable.identical(variable), name
    assert present.attrs == undisturbed.attrs


def test_block_is_a_complete_result(whole, undisturbed):
    assert_same_bits(store.read(block_of(whole, 4)), undisturbed.isel(repetition=slice(4, 8)))


def test_store_preserves_every_bit(tmp_path, monkeypatch):
    """Zeros, signed or not, what has no answer, and the smallest numbers."""
    values = itertools.cycle([-0.0, np.nan, 0.0, 5e-324, 1e99])
    shape = run(with_repetitions(1), executor=InlineExecutor()).dataset["contact_area"].values[:, :, 0].shape
    sums = {
        name: np.full(shape, 7 if name.endswith("_count") else 0.0 if name in ("contact_area", "normal_elastic") else x)
        for name, x in zip(TINY.sums(), values, strict=False)
    }
    monkeypatch.setattr(runner, "member_sums", lambda *_: sums)
    result = run(with_repetitions(1), store=tmp_path).dataset
    for name in sums:
        assert result[name].values.tobytes() == sums[name].tobytes(), name


def test_pieces_of_directory_and_dataset_are_equal(whole, undisturbed, monkeypatch):
    monkeypatch.setattr(layout, "MAX_PIECE_BYTES", 9 * layout.member_bytes(TINY))
    block_of(whole, 4).unlink()
    present = undisturbed.isel(repetition=[*range(4), *range(8, 22)])
    both = list(zip(Result(store.open_stored(whole)).pieces(), Result(present).pieces(), strict=True))
    assert [piece.sizes["repetition"] for piece, _ in both] == [8, 8, 2]
    for piece, other in both:
        assert_same_bits(piece, other)
    (piece,) = Result(undisturbed.isel(repetition=slice(2))).pieces(["contact_area"])
    assert list(piece.data_vars) == ["contact_area"]


def test_result_of_one_piece_is_read_once(whole, undisturbed, monkeypatch):
    """And what becomes of it in the hands of a caller is not what the next one sees."""
    stored, reads = store.open_stored(whole), []
    decode_members = store.decode_members
    monkeypatch.setattr(store, "decode_members", lambda content: reads.append(content) or decode_members(content))
    stored.dataset()["contact_area"].values[:] = 7.0
    assert len(reads) == len(stored.blocks)
    (piece,) = stored.pieces()
    assert_same_bits(piece, undisturbed)
    assert_same_bits(stored.dataset(), undisturbed)
    with pytest.raises(ValueError, match="read-only"):
        piece["contact_area"].values[:] = 7.0
    assert len(reads) == len(stored.blocks)


def test_result_larger_than_memory_is_reported(whole, monkeypatch):
    monkeypatch.setattr(store, "MAX_RESULT_BYTES", 1000)
    with pytest.raises(StoreError, match="GiB of memory"):
        store.open_stored(whole).dataset()


# ---- Continued and extended -----------------------------------------------------------------------------------------


def test_complete_result_is_read_without_computing(whole, undisturbed, computed):
    before = files(whole)
    assert_same_bits(run(TINY, store=whole).dataset, undisturbed)
    assert files(whole) == before
    other = TINY.with_changes({"friction.mu0": [0.2], "figures.draw": ["area"]})
    assert run(other, store=whole).dataset.attrs["study"] == other.to_toml()
    assert store.info(whole).study == other
    assert computed == []


def test_missing_blocks_are_computed(whole, undisturbed, computed):
    for first in (4, 20):
        block_of(whole, first).unlink()
    before = files(whole)
    with pytest.warns(UserWarning, match="16 of 22"):
        assert_same_bits(store.read(whole), undisturbed.isel(repetition=[*range(4), *range(8, 20)]))
    assert_same_bits(run(TINY, store=whole).dataset, undisturbed)
    assert sorted(computed) == [4, 5, 6, 7, 20, 21]
    assert before.items() <= files(whole).items()


def test_additional_repetitions_compute_only_new_members(tmp_path, undisturbed, computed):
    recorded = {}
    for total in (6, 7, 22):
        result = run(with_repetitions(total), store=tmp_path).dataset
        assert_same_bits(result.assign_attrs(undisturbed.attrs), undisturbed.isel(repetition=slice(total)))
        assert recorded.items() <= files(tmp_path).items()
        recorded = files(tmp_path)
    assert sorted(computed) == list(range(22))
    with pytest.raises(StoreError, match=r"repetition 21 is finished, and ensemble\.repetitions = 21"):
        run(with_repetitions(21), store=tmp_path)


def test_overlapping_blocks_are_accepted(whole, undisturbed, monkeypatch):
    """As writers leave them whose blocks differ: each repetition is read once."""
    others = whole.with_name("others")
    for size, first in ((3, 3), (7, 7), (5, 5)):
        monkeypatch.setattr(runner, "choose_block_size", lambda study, size=size: size)
        shutil.rmtree(others, ignore_errors=True)
        compute_missing(TINY, others)
        shutil.copy(block_of(others, first), whole / BLOCKS_FOLDER)
    block_of(whole, 4).unlink()
    assert_same_bits(store.read(whole), undisturbed)


def test_concurrent_writers_give_the_same_result(tmp_path, undisturbed):
    with ThreadPoolExecutor(4) as pool:
        results = list(pool.map(lambda _: run(TINY, store=tmp_path / "r", executor=InlineExecutor()).dataset, range(4)))
    for result in results:
        assert_same_bits(result, undisturbed)
    assert len(files(tmp_path / "r")) == 6
    assert_nothing_is_left(tmp_path)


@pytest.mark.parametrize(
    "change", [{"ensemble.seed": 1}, {"surfaces.gamma": 1.6}, {"contact.effective_modulus": "11 GPa"}], ids=str
)
def test_other_study_is_rejected_with_its_changed_keys(whole, change):
    before = files(whole)
    with pytest.raises(StoreError, match=next(iter(change))):
        run(TINY.with_changes(change), store=whole)
    assert files(whole) == before


def test_edited_study_file_does_not_change_blocks(whole):
    text = (whole / STUDY_FILE).read_text()
    (whole / STUDY_FILE).write_text(text.replace("seed = 2_016", "seed = 2_017"))
    with pytest.raises(StoreError, match=r"another study than study\.toml: ensemble\.seed"):
        store.read(whole)
    with pytest.raises(StoreError, match=r"ensemble\.seed"):
        run(TINY.with_changes({"ensemble.seed": 2017}), store=whole)
    (whole / STUDY_FILE).unlink()
    with pytest.raises(StoreError, match=r"no study\.toml"):
        store.read(whole)
    run(TINY, store=whole)
    assert store.info(whole).study == TINY


def test_result_of_another_version_is_read_but_not_continued(whole, undisturbed, monkeypatch):
    monkeypatch.setattr(store, "__version__", "9.9")
    assert_same_bits(run(TINY, store=whole).dataset, undisturbed)
    with pytest.raises(StoreError, match=r"was created by stiction .*this version, 9\.9"):
        run(with_repetitions(23), store=whole)


def test_result_of_another_machine_is_not_continued_if_steps_differ(whole, monkeypatch):
    steps = type(TINY.contact).steps
    monkeypatch.setattr(type(TINY.contact), "steps", lambda self: steps(self) * (1 + 2e-16))
    with pytest.raises(StoreError, match="whose steps differ"):
        run(with_repetitions(23), store=whole)


def test_foreign_study_file_without_blocks_is_preserved(tmp_path, undisturbed):
    (tmp_path / STUDY_FILE).write_text("# by hand\n" + TINY.to_toml())
    with pytest.raises(StoreError, match="contains another study"):
        run(TINY.with_changes({"ensemble.seed": 1}), store=tmp_path)
    assert_same_bits(run(TINY, store=tmp_path).dataset, undisturbed)
    assert (tmp_path / STUDY_FILE).read_text().startswith("# by hand")
    shutil.rmtree(tmp_path / BLOCKS_FOLDER)
    (tmp_path / STUDY_FILE).write_text(f"{store.STUDY_FILE_MARK} 0.1.0.\n" + TINY.to_toml())
    assert run(with_repetitions(1).with_changes({"ensemble.seed": 1}), store=tmp_path).dataset.sizes["repetition"] == 1


# ---- Damaged --------------------------------------------------------------------------------------------------------


def test_flipped_bit_is_detected_and_block_named(whole, undisturbed, computed):
    file = block_of(whole, 4)
    content = file.read_bytes()
    places = random.Random(4).sample(range(8 * len(content)), 60)
    for place in [0, 8 * len(content) - 1, *places]:
        damaged = bytearray(content)
        damaged[place // 8] ^= 1 << place % 8
        file.write_bytes(damaged)
        with pytest.raises(StoreError, match=f"{file.name}: does not match its checksum; remove that file"):
            store.read(whole)
    file.unlink()
    assert_same_bits(run(TINY, store=whole).dataset, undisturbed)
    assert computed == [4, 5, 6, 7]


def test_swapped_blocks_are_detected(whole, tmp_path):
    content = block_of(whole, 8).read_bytes()
    put(block_of(whole, 4), content)
    with pytest.raises(StoreError, match="contains other repetitions than its name states"):
        store.read(whole)
    other = tmp_path / "other"
    compute_missing(TINY.with_changes({"ensemble.seed": 1}), other)
    put(block_of(whole, 4), block_of(other, 4).read_bytes())
    with pytest.raises(StoreError, match=r"is of another study than study\.toml: ensemble\.seed"):
        store.read(whole)


def emptied(file):
    file.write_bytes(b"")


def directory(file):
    file.unlink()
    file.mkdir()


@pytest.mark.parametrize("damage", [emptied, directory])
def test_invalid_block_is_reported_in_one_sentence(whole, damage):
    damage(block_of(whole, 4))
    with pytest.raises(StoreError, match=r"0000004-0000007-.*recompute repetitions 4 to 7") as refused:
        store.read(whole)
    assert len(str(refused.value).splitlines()) == 1


def test_foreign_files_are_left_unchanged(whole, undisturbed):
    names = ["notes.txt", "0000004-0000007.nc", "0000007-0000004-00000000.nc", ".hidden", "4-7-00000000.nc"]
    for name in names:
        (whole / BLOCKS_FOLDER / name).write_text("mine")
    (whole / "more").mkdir()
    assert_same_bits(run(TINY, store=whole).dataset, undisturbed)
    assert {*names} <= files(whole).keys()


@pytest.mark.parametrize("where", ["nothing", "file", "empty", "loop"])
def test_directory_without_result_is_reported_in_one_sentence(tmp_path, where):
    path = tmp_path / where
    if where == "file":
        path.write_text("no result")
    elif where == "empty":
        path.mkdir()
    elif where == "loop":
        path.symlink_to(path)
    with pytest.raises(StoreError) as refused:
        store.read(path)
    assert str(refused.value).startswith(str(path))
    if where in ("file", "loop"):
        with pytest.raises(StoreError, match=str(path)):
            run(TINY, store=path)


# ---- Files of others -------------------------------------------------------------------------------------------------


def replaced(name, make):
    """A lie: a variable is replaced by another one over the same dimensions."""

    return lambda file: rewrite_variable(file, name, make)


def attribute(name, value):
    def lie(file):
        file.attrs[name] = value

    return lie


def external(file):
    del file["contact_area"]
    file["contact_area"] = h5py.ExternalLink("other.nc", "contact_area")


def outside(file):
    shape = file["contact_area"].shape
    del file["contact_area"]
    file.create_dataset("contact_area", shape, "f8", external=[("/etc/passwd", 0, h5py.h5f.UNLIMITED)])


def virtual(file):
    shape = file["contact_area"].shape
    del file["contact_area"]
    layout = h5py.VirtualLayout(shape, "f8")
    layout[...] = h5py.VirtualSource("other.nc", "contact_area", shape)
    file.create_virtual_dataset("contact_area", layout)


def never_written(file):
    shape = file["contact_area"].shape
    del file["contact_area"]
    file.create_dataset("contact_area", shape, "f8")


LIES = {
    "no variable": lambda file: file.__delitem__("contact_area"),
    "another shape": replaced("contact_area", lambda values: values[..., :2]),
    "no study": lambda file: file.attrs.__delitem__("study"),
    "a study that is none": attribute("study", "seed"),
    "a link to another file": external,
    "bytes of another file": outside,
    "numbers of another file": virtual,
    "numbers of no file": never_written,
}


@pytest.mark.parametrize("lie", LIES.values(), ids=LIES)
def test_block_that_contradicts_its_study_is_reported_in_one_sentence(whole, lie):
    file = block_of(whole, 4)
    with h5py.File(file, "r+") as opened:
        lie(opened)
    content = file.read_bytes()
    away = whole / "result.nc"
    away.write_bytes(content)
    with pytest.raises(StoreError, match=r"result\.nc: ") as refused:
        store.read(away)
    assert len(str(refused.value).splitlines()) <= 2
    put(file, content)
    with pytest.raises(StoreError, match="recompute repetitions 4 to 7"):
        store.read(whole)


def test_units_and_names_come_from_the_package(whole, undisturbed):
    file = block_of(whole, 4)
    with h5py.File(file, "r+") as opened:
        opened["approach"].attrs["units"] = "seconds since 1970-01-01"
        opened["contact_area"].attrs["scale_factor"] = "ten"
        opened["contact_area"].attrs["_FillValue"] = 0.0
        opened.attrs["more"] = "x" * 100_000
    put(file, file.read_bytes())
    assert_same_bits(store.read(whole), undisturbed)


# ---- Disks ----------------------------------------------------------------------------------------------------------


def test_full_disk_loses_nothing(tmp_path, undisturbed, monkeypatch):
    """At whatever file it fills up there is one message, and it goes on from there."""
    write, space = _files.Path.write_bytes, 0

    def write_while_there_is_space(self, content):
        nonlocal space
        space -= 1
        if space < 0:
            write(self, content[:3])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(self, content)

    monkeypatch.setattr(_files.Path, "write_bytes", write_while_there_is_space)
    for space, kept in ((0, 0), (1, 0), (2, 8), (1, 12)):  # noqa: B007, which the disk has
        with pytest.raises(StoreError, match="cannot be written: No space left on device") as full:
            run(TINY, store=tmp_path, executor=InlineExecutor())
        if kept:
            assert store.open_stored(tmp_path).finished.size == kept
            assert f"{kept} of 22 repetitions are finished and kept" in str(full.value)
        assert_nothing_is_left(tmp_path)
    monkeypatch.undo()
    assert_same_bits(run(TINY, store=tmp_path).dataset, undisturbed)


def test_removed_directory_is_not_created_again(tmp_path, monkeypatch):
    path, replace = tmp_path / "r", store.write_block

    def put_and_remove(where, first, written, count):
        replace(where, first, written, count)
        if first == 4:
            path.rename(tmp_path / "moved")

    monkeypatch.setattr(runner, "write_block", put_and_remove)
    with pytest.raises(StoreError, match="was removed or replaced"):
        run(TINY, store=path, executor=InlineExecutor())
    assert os.listdir(tmp_path) == ["moved"]
    assert store.info(tmp_path / "moved").finished == 8


def test_complete_result_on_read_only_disk_is_read(whole, computed, monkeypatch):
    def refused(*_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(_files, "remove_stale_partials", refused)
    other = TINY.with_changes({"friction.mu0": [0.2]})
    assert run(other, store=whole).dataset.attrs["study"] == other.to_toml()
    assert computed == []
    for study, folder in ((with_repetitions(23), whole), (TINY, whole.with_name("new"))):
        with pytest.raises(StoreError, match="cannot be written: Read-only file system"):
            run(study, store=folder)


# ---- Interrupted ----------------------------------------------------------------------------------------------------


def test_partial_files_of_dead_processes_are_removed(whole):
    gone = subprocess.Popen([sys.executable, "-c", ""])
    gone.wait()
    here, _, mine = _files.PARTIAL_NAME.fullmatch(_files.new_partial_name()).groups()
    names = {
        f".stiction-{here}-{gone.pid}-00000000-00000000.partial": False,
        f".stiction-{here}-{os.getpid()}-00000000-00000000.partial": False,  # of an earlier process of that number
        f".stiction-{here}-{os.getpid()}-{mine}-00000000.partial": True,
        f".stiction-{here}-{os.getppid()}-00000000-00000000.partial": True,
        ".stiction-00000000-1-00000000-00000000.partial": True,  # on another machine, until it is old
        ".stiction-00000000-1-00000000-00000001.partial": False,
        "mine.partial": True,
    }
    for folder, name in itertools.product((whole, whole / BLOCKS_FOLDER), names):
        (folder / name).write_text("half")
        if name.endswith("1.partial"):
            os.utime(folder / name, (0, 0))
    run(TINY, store=whole)
    for folder in (whole, whole / BLOCKS_FOLDER):
        assert {name for name in os.listdir(folder) if name.endswith(".partial")} == {n for n in names if names[n]}


def test_removed_partial_file_is_written_again(tmp_path, undisturbed, monkeypatch):
    replace, swept = Path.replace, []

    def sweep(self, target):
        if self.suffix == ".partial" and not swept:
            swept.append(self)
            self.unlink()
        return replace(self, target)

    compute_missing(with_repetitions(4), tmp_path)
    monkeypatch.setattr(Path, "replace", sweep)
    (tmp_path / STUDY_FILE).write_text(f"{store.STUDY_FILE_MARK} 0.1.0.\n" + TINY.to_toml())
    assert_same_bits(run(TINY, store=tmp_path).dataset, undisturbed)
    assert swept


def test_interrupt_during_write_leaves_no_file(tmp_path, monkeypatch):
    def interrupted(file):
        close(file)
        raise KeyboardInterrupt

    close = os.close
    monkeypatch.setattr(os, "close", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(TINY, store=tmp_path / "r")
    assert_nothing_is_left(tmp_path)


KILLED = """
import os, signal, sys
from concurrent.futures import Future
from pathlib import Path
from stiction import Study, run
from stiction.studies import runner
runner.block_size = lambda study: 4
class InlineExecutor:
    def submit(self, function, *args):
        future = Future()
        future.set_result(function(*args))
        return future
def run_until(step):
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
    for name in ("write_bytes", "replace", "mkdir", "unlink", "touch"):
        counted(name)
    run(Study.from_toml("s.toml"), store="r", executor=InlineExecutor())
import xarray  # before the children, which need not import it again
for step in range(1, 1000):
    child = os.fork()
    if child == 0:
        run_until(step)
        os._exit(0)
    status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    print(step, status, flush=True)
    if status == 0:
        break
"""


def test_run_resumes_after_kill_at_any_disk_operation(tmp_path, undisturbed):
    """What changes the disk is counted; the n-th change does not come, and of a file half is written."""
    (tmp_path / "s.toml").write_text(TINY.to_toml())
    completed = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", KILLED], cwd=tmp_path, capture_output=True, text=True, check=False
    )
    assert completed.returncode == 0, completed.stderr
    statuses = [int(line.split()[1]) for line in completed.stdout.splitlines()]
    assert statuses[-1] == 0
    assert set(statuses[:-1]) == {-signal.SIGKILL}
    assert len(statuses) > 5
    assert_same_bits(run(TINY, store=tmp_path / "r").dataset, undisturbed)
    assert_nothing_is_left(tmp_path)


# ---- Exported -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["dataset", "folder"])
def test_export_equals_computed_dataset(whole, undisturbed, tmp_path, monkeypatch, kind):
    monkeypatch.setattr(layout, "MAX_PIECE_BYTES", 9 * layout.member_bytes(TINY))
    file = tmp_path / "r.nc"
    export(undisturbed if kind == "dataset" else store.open_stored(whole).dataset(), file)
    assert_same_bits(store.read(file), undisturbed)
    assert_same_bits(xarray.load_dataset(file, engine="h5netcdf"), undisturbed)
    with pytest.raises(ExportError, match="exists already"):
        export(undisturbed, file)


def test_foreign_netcdf_file_is_rejected(tmp_path, undisturbed):
    means = undisturbed.mean("repetition")
    export(means, tmp_path / "means.nc")
    xarray.testing.assert_identical(xarray.load_dataset(tmp_path / "means.nc", engine="h5netcdf"), means)
    for content in (b"", b"\x89HDF\r\n\x1a\n", os.urandom(1000), (tmp_path / "means.nc").read_bytes()):
        (tmp_path / "x.nc").write_bytes(content)
        with pytest.raises(StoreError, match=r"x\.nc: "):
            store.read(tmp_path / "x.nc")


def test_equal_members_have_equal_bytes_at_any_time(undisturbed):
    """Files are named by their bytes, in which old versions of h5py put the second."""
    first, second = io.BytesIO(), io.BytesIO()
    store.write_dataset(undisturbed, first)
    time.sleep(1.01)
    store.write_dataset(undisturbed, second)
    assert first.getvalue() == second.getvalue()


def test_block_equals_file_written_by_xarray(undisturbed):
    """Every dimension, kind, attribute and number, and no more bytes; xarray itself asks Dask for locks."""
    part = undisturbed.isel(repetition=slice(4, 8))
    kinds = part.assign_coords(
        place=("repetition", [True, False, True, False]), words=("approach", [*"abcd"]), area=3.0
    )
    for dataset in (part, kinds, part.mean("repetition")):
        ours, theirs = io.BytesIO(), io.BytesIO()
        store.write_dataset(dataset, ours)
        dataset.to_netcdf(
            theirs, engine="h5netcdf", encoding={name: {"_FillValue": None} for name in dataset.variables}
        )
        xarray.testing.assert_identical(xarray.load_dataset(ours, engine="h5netcdf"), dataset)
        with h5py.File(ours) as one, h5py.File(theirs) as other:
            assert set(one) == set(other)
            assert one.attrs.keys() == other.attrs.keys()
            for name in one:
                assert one[name].dtype == other[name].dtype
                assert one[name].attrs.keys() == other[name].attrs.keys()
    image = io.BytesIO()
    store.write_dataset(part, image)
    assert (
        store.encode_members(TINY, range(4, 8), {name: part[name].values for name in TINY.sums()}) == image.getvalue()
    )


INTERRUPTED = r"""
import os, signal, sys, threading
from stiction import Study
from stiction.studies import runner
study, sums, interrupted = Study.from_toml("s.toml"), runner.member_sums, threading.Event()
def tell(word):  # in one piece: print() writes the end of a line by itself, and another thread between both
    os.write(1, f"{word}\n".encode())
def held(study, member):
    if member >= 20:
        tell("held")
        interrupted.wait()
    return sums(study, member)
def interrupt(*of):
    interrupted.set()
    signal.default_int_handler(*of)
signal.signal(signal.SIGINT, interrupt)
runner.member_sums = held
runner.block_size = lambda study: 8
tell("begun")
try:
    runner.compute_missing(study, "r", announce=lambda text: tell("ready"))
except KeyboardInterrupt:
    sys.exit(130)
"""


def test_interrupt_ends_run_soon_and_preserves_blocks(tmp_path):
    study = with_repetitions(1000)
    (tmp_path / "s.toml").write_text(study.to_toml())
    with (
        subprocess.Popen(
            [sys.executable, "-c", INTERRUPTED], cwd=tmp_path, stdout=subprocess.PIPE, start_new_session=True
        ) as process,
        contextlib.ExitStack() as whatever_happens,
    ):
        whatever_happens.callback(process.kill)  # which does nothing to one that has ended
        assert process.stdout.readline() == b"begun\n"
        expected = {b"ready\n", b"held\n"}  # each thread is held, and says so, in any order
        while expected and (line := process.stdout.readline()):
            expected.discard(line)
        process.send_signal(signal.SIGINT)
        assert process.wait(300) == 130
    stored = store.open_stored(tmp_path / "r")
    assert 8 <= stored.finished.size < 500  # and not all, however busy the machine is
    assert_nothing_is_left(tmp_path)
    computed = run(with_repetitions(int(stored.finished[-1]) + 1)).dataset
    assert_same_bits(stored.dataset().assign_attrs(computed.attrs), computed.isel(repetition=stored.finished))


def test_result_without_finished_members_is_a_store_error(tmp_path):
    store.create_or_open(tmp_path, TINY)
    with pytest.raises(StoreError, match="none of the 22 repetitions is finished"):
        Result(store.open_stored(tmp_path)).at_study_loads  # noqa: B018
