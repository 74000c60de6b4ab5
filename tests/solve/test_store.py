"""Test stored results: writing, reading, continuing, damaged files, full disks and interrupts."""

import contextlib
import errno
import io
import itertools
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import threading
import time
import zlib
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import h5py
import numpy as np
import pytest
import xarray
from stiction import Result, Study, __version__, _files, run
from stiction.solve import layout, runner, store
from stiction.solve.runner import compute_missing_blocks
from stiction.solve.store import BLOCKS_DIRECTORY, STUDY_FILE, BlockFile, ExportError, StoreError, export
from stiction.study.study import parse_study
from support.generated_studies import TINY_STUDY, InlineExecutor, assert_same_bits, rewrite_variable, with_repetitions
from support.studies_of_files import create_study_from_files, write_maps

pytestmark = pytest.mark.usefixtures("write_blocks_of_four_members")


@pytest.fixture(scope="module")
def finished_directory(tmp_path_factory):
    """Return the directory of a complete result; tests must not change it."""
    path = tmp_path_factory.mktemp("finished") / "r"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(runner, "choose_block_size", lambda study: 4)
        compute_missing_blocks(TINY_STUDY, path)
    return path


@pytest.fixture
def directory_copy(finished_directory, tmp_path):
    """Return a copy of the directory of a complete result, which the test may change."""
    return shutil.copytree(finished_directory, tmp_path / "r")


def read_block_states(path):
    """Return the inode and modification time of each block file by name."""
    return {file.name: (file.stat().st_ino, file.stat().st_mtime_ns) for file in (path / BLOCKS_DIRECTORY).iterdir()}


def find_block_file(path, first_repetition):
    return next((path / BLOCKS_DIRECTORY).glob(f"{first_repetition:07d}-*.nc"))


def replace_block_content(file, content):
    """Replace the content of a block file, and rename the file by the checksum of the new content."""
    first_repetition, last_repetition, _ = file.stem.split("-")
    file.unlink()
    path = file.with_name(BlockFile(int(first_repetition), int(last_repetition), zlib.crc32(content)).file_name)
    path.write_bytes(content)
    return path


def assert_no_partial_files(path):
    assert not list(path.rglob("*.partial"))


# ---- Write and read -------------------------------------------------------------------------------------------------


def test_stored_result_equals_the_computed_dataset(tmp_path, uninterrupted_dataset):
    path = tmp_path / "deep" / "r"
    assert_same_bits(run(TINY_STUDY, store=path).dataset, uninterrupted_dataset)
    assert_same_bits(store.read(path), uninterrupted_dataset)
    assert sorted(os.listdir(path)) == [BLOCKS_DIRECTORY, STUDY_FILE]
    assert [file[:15] for file in sorted(read_block_states(path))] == [
        f"{k:07d}-{min(k + 3, 21):07d}" for k in range(0, 22, 4)
    ]
    info = store.info(path)
    assert (info.study, info.finished) == (TINY_STUDY, 22)
    assert info.size == sum(file.stat().st_size for file in (path / BLOCKS_DIRECTORY).iterdir())


def test_stored_result_that_lacks_a_quantity_added_in_a_newer_version_can_be_read(tmp_path):
    study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path), members=2)
    expected = run(study, store=tmp_path / "r").dataset
    file = find_block_file(tmp_path / "r", 0)
    content = file.read_bytes()
    image = io.BytesIO(content)
    with h5py.File(image, "r+") as block:
        del block["unloading_closure_stiffness"]
    replace_block_content(file, image.getvalue())
    dataset = store.open_stored_result(tmp_path / "r").dataset()
    assert np.isnan(dataset["unloading_closure_stiffness"]).all()
    for name in set(expected.data_vars) - {"unloading_closure_stiffness"}:
        assert dataset[name].identical(expected[name]), name


def test_two_runs_of_a_study_write_blocks_with_equal_checksums(tmp_path, directory_copy):
    compute_missing_blocks(TINY_STUDY, tmp_path / "again", executor=InlineExecutor())
    assert read_block_states(directory_copy).keys() == read_block_states(tmp_path / "again").keys()


def test_xarray_can_open_blocks_of_a_stored_result(directory_copy, uninterrupted_dataset):
    pytest.importorskip("dask")
    find_block_file(directory_copy, 8).unlink()
    with xarray.open_mfdataset(str(directory_copy / BLOCKS_DIRECTORY / "*.nc")) as opened_blocks:
        opened_dataset = opened_blocks.load()
    expected = uninterrupted_dataset.isel(repetition=[*range(8), *range(12, 22)])
    for name, variable in expected.variables.items():
        assert opened_dataset[name].variable.identical(variable), name
    assert opened_dataset.attrs == uninterrupted_dataset.attrs


def test_single_block_can_be_read_as_a_result(directory_copy, uninterrupted_dataset):
    assert_same_bits(store.read(find_block_file(directory_copy, 4)), uninterrupted_dataset.isel(repetition=slice(4, 8)))


def test_storing_a_result_preserves_its_values_bit_for_bit(tmp_path, monkeypatch):
    """Store values with signed zeros, the smallest positive number and a large number."""
    values = itertools.cycle([-0.0, 0.0, 5e-324, 1e99])
    shape = run(with_repetitions(1), executor=InlineExecutor()).dataset["contact_area"].values[:, :, 0].shape
    sums = {
        name: np.full(shape, 7 if name.endswith("_count") else 0.0 if name in ("contact_area", "normal_elastic") else x)
        for name, x in zip(TINY_STUDY.contact_sum_names(), values, strict=False)
    }
    monkeypatch.setattr(runner, "compute_member_arrays", lambda *_: sums)
    result = run(with_repetitions(1), store=tmp_path).dataset
    for name in sums:
        assert result[name].values.tobytes() == sums[name].tobytes(), name


def test_storing_a_result_preserves_all_bits_of_values_at_loads_without_solution():
    text = (Path(__file__).parents[1] / "study/stored_studies/half-space_of_generated_lines.toml").read_text("utf-8")
    study = parse_study(text, "half-space").with_changes({"ensemble.repetitions": 1})
    arrays = {}
    for name, spec in layout.variable_specs(study).items():
        arrays[name] = np.ones(spec.shape, spec.dtype)
        arrays[name][..., 0] = 0 if spec.dtype.kind == "i" else np.nan
    stored_arrays = store.decode_members(store.encode_members(study, [0], arrays)).arrays
    for name, values in arrays.items():
        assert stored_arrays[name].tobytes() == values.tobytes(), name


def test_encoding_a_block_waits_until_another_thread_has_imported_the_packages():
    """Check the lock, because an import of xarray in two threads at the same time fails now and then."""
    arrays = {name: np.ones(spec.shape, spec.dtype) for name, spec in layout.variable_specs(TINY_STUDY, [0]).items()}
    with ThreadPoolExecutor(1) as pool:
        with store._dataset_package_import_lock:
            block = pool.submit(store.encode_members, TINY_STUDY, [0], arrays)
            with pytest.raises(TimeoutError):
                block.result(timeout=0.2)
        assert block.result(timeout=60)


def test_stored_result_that_is_read_in_pieces_equals_the_computed_dataset(
    directory_copy, uninterrupted_dataset, monkeypatch
):
    monkeypatch.setattr(layout, "MAX_MEMBER_PIECE_BYTES", 9 * layout.compute_bytes_per_member(TINY_STUDY))
    find_block_file(directory_copy, 4).unlink()
    incomplete_dataset = uninterrupted_dataset.isel(repetition=[*range(4), *range(8, 22)])
    piece_pairs = list(
        zip(Result(store.open_stored_result(directory_copy)).pieces(), Result(incomplete_dataset).pieces(), strict=True)
    )
    assert [piece.sizes["repetition"] for piece, _ in piece_pairs] == [8, 8, 2]
    for piece, expected_piece in piece_pairs:
        assert_same_bits(piece, expected_piece)
    (piece,) = Result(uninterrupted_dataset.isel(repetition=slice(2))).pieces(["contact_area"])
    assert list(piece.data_vars) == ["contact_area"]


def test_reading_one_variable_of_a_large_result_decodes_no_other_variable(
    directory_copy, uninterrupted_dataset, monkeypatch
):
    monkeypatch.setattr(layout, "MAX_MEMBER_PIECE_BYTES", 9 * layout.compute_bytes_per_member(TINY_STUDY))
    stored_result, decoded_contents, read_names = store.open_stored_result(directory_copy), [], set()
    decode_members, read_variable = store.decode_members, store._read_variable
    monkeypatch.setattr(
        store, "decode_members", lambda content: decoded_contents.append(content) or decode_members(content)
    )
    pieces_of_one_variable = list(stored_result.pieces(["normal_elastic"]))
    assert len(decoded_contents) == len(stored_result.blocks)
    monkeypatch.setattr(
        store, "_read_variable", lambda file, name, *shape: read_names.add(name) or read_variable(file, name, *shape)
    )
    pieces_of_two_variables = list(stored_result.pieces(["normal_elastic", "contact_count"]))
    assert len(decoded_contents) == len(stored_result.blocks)
    assert read_names == {"normal_elastic", "contact_count"}
    expected_pieces = Result(uninterrupted_dataset).pieces(["normal_elastic", "contact_count"])
    for piece_of_one_variable, piece_of_two_variables, expected in zip(
        pieces_of_one_variable, pieces_of_two_variables, expected_pieces, strict=True
    ):
        assert_same_bits(piece_of_two_variables, expected)
        assert_same_bits(piece_of_one_variable, expected[["normal_elastic"]])
    path = find_block_file(directory_copy, 8)
    path.write_bytes(find_block_file(directory_copy, 20).read_bytes())
    with pytest.raises(StoreError, match=rf"{path.name}: has normal_elastic with the shape .* instead of"):
        list(stored_result.pieces(["normal_elastic"]))
    path.unlink()
    with pytest.raises(StoreError, match=rf"{path.name}: cannot be read"):
        list(stored_result.pieces(["normal_elastic"]))


def test_stored_result_that_fits_in_one_piece_is_read_from_disk_once(
    directory_copy, uninterrupted_dataset, monkeypatch
):
    """Check also that a caller who changes the dataset does not change the cached result."""
    stored_result, decoded_contents = store.open_stored_result(directory_copy), []
    decode_members = store.decode_members
    monkeypatch.setattr(
        store, "decode_members", lambda content: decoded_contents.append(content) or decode_members(content)
    )
    stored_result.dataset()["contact_area"].values[:] = 7.0
    assert len(decoded_contents) == len(stored_result.blocks)
    (piece,) = stored_result.pieces()
    assert_same_bits(piece, uninterrupted_dataset)
    assert_same_bits(stored_result.dataset(), uninterrupted_dataset)
    with pytest.raises(ValueError, match="read-only"):
        piece["contact_area"].values[:] = 7.0
    assert len(decoded_contents) == len(stored_result.blocks)


def test_reading_a_result_larger_than_memory_is_rejected(directory_copy, monkeypatch):
    monkeypatch.setattr(store, "MAX_RESULT_BYTES", 1000)
    with pytest.raises(StoreError, match="GiB of memory"):
        store.open_stored_result(directory_copy).dataset()


# ---- Continue and extend -------------------------------------------------------------------------------------------


def test_reading_a_complete_result_computes_nothing(directory_copy, uninterrupted_dataset, computed_repetitions):
    states_before = read_block_states(directory_copy)
    assert_same_bits(run(TINY_STUDY, store=directory_copy).dataset, uninterrupted_dataset)
    assert read_block_states(directory_copy) == states_before
    study_at_other_mu0 = TINY_STUDY.with_changes({"friction.mu0": [0.2], "figures.draw": ["area"]})
    assert run(study_at_other_mu0, store=directory_copy).dataset.attrs["study"] == study_at_other_mu0.to_toml()
    assert store.info(directory_copy).study == study_at_other_mu0
    assert computed_repetitions == []


def test_continued_run_computes_only_missing_blocks(directory_copy, uninterrupted_dataset, computed_repetitions):
    for first_repetition in (4, 20):
        find_block_file(directory_copy, first_repetition).unlink()
    states_before = read_block_states(directory_copy)
    with pytest.warns(UserWarning, match="16 of 22"):
        assert_same_bits(store.read(directory_copy), uninterrupted_dataset.isel(repetition=[*range(4), *range(8, 20)]))
    assert_same_bits(run(TINY_STUDY, store=directory_copy).dataset, uninterrupted_dataset)
    assert sorted(computed_repetitions) == [4, 5, 6, 7, 20, 21]
    assert states_before.items() <= read_block_states(directory_copy).items()


def test_continued_run_with_more_repetitions_computes_only_the_new_repetitions(
    tmp_path, uninterrupted_dataset, computed_repetitions
):
    states_before = {}
    for num_repetitions in (6, 7, 22):
        result = run(with_repetitions(num_repetitions), store=tmp_path).dataset
        assert_same_bits(
            result.assign_attrs(uninterrupted_dataset.attrs),
            uninterrupted_dataset.isel(repetition=slice(num_repetitions)),
        )
        assert states_before.items() <= read_block_states(tmp_path).items()
        states_before = read_block_states(tmp_path)
    assert sorted(computed_repetitions) == list(range(22))
    with pytest.raises(StoreError, match=r"repetition 21 is finished, and ensemble\.repetitions = 21"):
        run(with_repetitions(21), store=tmp_path)


def test_stored_blocks_that_contain_the_same_repetitions_are_accepted(
    directory_copy, uninterrupted_dataset, monkeypatch
):
    """Blocks overlap if writers used different block sizes; each repetition is read once."""
    other_directory = directory_copy.with_name("others")
    for size, first_repetition in ((3, 3), (7, 7), (5, 5)):
        monkeypatch.setattr(runner, "choose_block_size", lambda study, size=size: size)
        shutil.rmtree(other_directory, ignore_errors=True)
        compute_missing_blocks(TINY_STUDY, other_directory)
        shutil.copy(find_block_file(other_directory, first_repetition), directory_copy / BLOCKS_DIRECTORY)
    find_block_file(directory_copy, 4).unlink()
    assert_same_bits(store.read(directory_copy), uninterrupted_dataset)


def test_concurrent_writers_store_the_same_result(tmp_path, uninterrupted_dataset):
    with ThreadPoolExecutor(4) as pool:
        results = list(
            pool.map(lambda _: run(TINY_STUDY, store=tmp_path / "r", executor=InlineExecutor()).dataset, range(4))
        )
    for result in results:
        assert_same_bits(result, uninterrupted_dataset)
    assert len(read_block_states(tmp_path / "r")) == 6
    assert_no_partial_files(tmp_path)


@pytest.mark.parametrize(
    "change", [{"ensemble.seed": 1}, {"surfaces.gamma": 1.6}, {"contact.effective_modulus": "11 GPa"}], ids=str
)
def test_run_function_rejects_the_stored_result_of_another_study_and_names_the_changed_key(directory_copy, change):
    states_before = read_block_states(directory_copy)
    with pytest.raises(StoreError, match=next(iter(change))):
        run(TINY_STUDY.with_changes(change), store=directory_copy)
    assert read_block_states(directory_copy) == states_before


def test_edited_study_file_that_contradicts_the_stored_blocks_is_rejected(directory_copy):
    text = (directory_copy / STUDY_FILE).read_text()
    (directory_copy / STUDY_FILE).write_text(text.replace("seed = 2_016", "seed = 2_017"))
    with pytest.raises(StoreError, match=r"does not match study\.toml: ensemble\.seed"):
        store.read(directory_copy)
    with pytest.raises(StoreError, match=r"ensemble\.seed"):
        run(TINY_STUDY.with_changes({"ensemble.seed": 2017}), store=directory_copy)
    (directory_copy / STUDY_FILE).unlink()
    with pytest.raises(StoreError, match=r"no study\.toml"):
        store.read(directory_copy)
    run(TINY_STUDY, store=directory_copy)
    assert store.info(directory_copy).study == TINY_STUDY


def test_result_of_another_version_can_be_read_but_not_continued(directory_copy, uninterrupted_dataset, monkeypatch):
    monkeypatch.setattr(store, "__version__", "9.9")
    assert_same_bits(run(TINY_STUDY, store=directory_copy).dataset, uninterrupted_dataset)
    with pytest.raises(StoreError, match=r"was created by stiction .*this version, 9\.9"):
        run(with_repetitions(23), store=directory_copy)


def test_stored_result_is_not_continued_if_its_load_steps_differ_from_those_of_the_study(directory_copy, monkeypatch):
    steps = type(TINY_STUDY.contact).loading_steps
    monkeypatch.setattr(type(TINY_STUDY.contact), "loading_steps", lambda self: steps(self) * (1 + 2e-16))
    with pytest.raises(StoreError, match="so its coordinates, such as loads, differ slightly"):
        run(with_repetitions(23), store=directory_copy)


def test_study_file_written_by_hand_is_not_overwritten_even_if_no_blocks_are_stored(tmp_path, uninterrupted_dataset):
    (tmp_path / STUDY_FILE).write_text("# by hand\n" + TINY_STUDY.to_toml())
    with pytest.raises(StoreError, match="contains another study"):
        run(TINY_STUDY.with_changes({"ensemble.seed": 1}), store=tmp_path)
    assert_same_bits(run(TINY_STUDY, store=tmp_path).dataset, uninterrupted_dataset)
    assert (tmp_path / STUDY_FILE).read_text().startswith("# by hand")


def test_study_file_written_by_stiction_is_replaced_if_no_blocks_are_stored(tmp_path):
    store.create_or_open_result(tmp_path, TINY_STUDY)
    assert run(with_repetitions(1).with_changes({"ensemble.seed": 1}), store=tmp_path).dataset.sizes["repetition"] == 1


def edit_study_file(file, kind):
    text = file.read_text()
    if kind == "link":
        file.rename(file.with_name("mine.toml"))
        file.symlink_to("mine.toml")
    elif kind == "first line only":
        file.write_text(f"{store.STUDY_FILE_SIGNATURE} 0.1.0.\n\n{text.partition(chr(10) * 2)[2]}")
    else:
        old_text, new_text = {"number": ("= 2_016", "= 2_017"), "comment": ("[surfaces]", "# Tuesday\n[surfaces]")}[
            kind
        ]
        assert old_text in text
        file.write_text(text.replace(old_text, new_text))


@pytest.mark.parametrize("kind", ["number", "comment", "link", "first line only"])
def test_edited_study_file_in_a_directory_without_blocks_is_solved_but_not_overwritten(tmp_path, kind):
    store.create_or_open_result(tmp_path, TINY_STUDY)
    edit_study_file(tmp_path / STUDY_FILE, kind)
    text = (tmp_path / STUDY_FILE).read_text()
    with pytest.raises(StoreError, match=r"contains another study in a study\.toml that was written or edited by hand"):
        run(with_repetitions(1), store=tmp_path)
    edited_study = Study.from_toml(tmp_path / STUDY_FILE)
    run(edited_study, store=tmp_path)
    assert (tmp_path / STUDY_FILE).read_text() == text
    assert (tmp_path / STUDY_FILE).is_symlink() == (kind == "link")
    with pytest.raises(StoreError, match="written or edited by hand"):
        run(edited_study.with_changes({"friction.mu0": [0.3]}), store=tmp_path)
    assert (tmp_path / STUDY_FILE).read_text() == text


# ---- Damage ---------------------------------------------------------------------------------------------------------


def test_flipped_bit_in_a_block_is_reported_with_its_file_name(
    directory_copy, uninterrupted_dataset, computed_repetitions
):
    file = find_block_file(directory_copy, 4)
    content = file.read_bytes()
    bit_indices = random.Random(4).sample(range(8 * len(content)), 60)
    for bit_index in [0, 8 * len(content) - 1, *bit_indices]:
        damaged_content = bytearray(content)
        damaged_content[bit_index // 8] ^= 1 << bit_index % 8
        file.write_bytes(damaged_content)
        with pytest.raises(StoreError, match=f"{file.name}: does not match its checksum; remove that file"):
            store.read(directory_copy)
    file.unlink()
    assert_same_bits(run(TINY_STUDY, store=directory_copy).dataset, uninterrupted_dataset)
    assert computed_repetitions == [4, 5, 6, 7]


def test_swapped_blocks_and_blocks_of_another_result_are_detected(directory_copy, tmp_path):
    content = find_block_file(directory_copy, 8).read_bytes()
    replace_block_content(find_block_file(directory_copy, 4), content)
    with pytest.raises(StoreError, match="does not contain the members that its file name states"):
        store.read(directory_copy)
    other_directory = tmp_path / "other"
    compute_missing_blocks(TINY_STUDY.with_changes({"ensemble.seed": 1}), other_directory)
    replace_block_content(find_block_file(directory_copy, 4), find_block_file(other_directory, 4).read_bytes())
    with pytest.raises(StoreError, match=r"does not match study\.toml: ensemble\.seed"):
        store.read(directory_copy)


def truncate_file(file):
    file.write_bytes(b"")


def replace_by_directory(file):
    file.unlink()
    file.mkdir()


@pytest.mark.parametrize("damage", [truncate_file, replace_by_directory])
def test_invalid_block_is_reported_with_a_one_line_error(directory_copy, damage):
    damage(find_block_file(directory_copy, 4))
    with pytest.raises(StoreError, match=r"0000004-0000007-.*recompute members 4 to 7") as error_info:
        store.read(directory_copy)
    assert len(str(error_info.value).splitlines()) == 1


def test_run_leaves_files_of_other_programs_in_its_directory_unchanged(directory_copy, uninterrupted_dataset):
    names = ["notes.txt", "0000004-0000007.nc", "0000007-0000004-00000000.nc", ".hidden", "4-7-00000000.nc"]
    for name in names:
        (directory_copy / BLOCKS_DIRECTORY / name).write_text("mine")
    (directory_copy / "more").mkdir()
    assert_same_bits(run(TINY_STUDY, store=directory_copy).dataset, uninterrupted_dataset)
    assert {*names} <= read_block_states(directory_copy).keys()


@pytest.mark.parametrize("kind", ["nothing", "file", "empty", "loop"])
def test_directory_without_result_is_reported_with_a_one_line_error(tmp_path, kind):
    path = tmp_path / kind
    if kind == "file":
        path.write_text("no result")
    elif kind == "empty":
        path.mkdir()
    elif kind == "loop":
        path.symlink_to(path)
    with pytest.raises(StoreError) as error_info:
        store.read(path)
    assert str(error_info.value).startswith(str(path))
    if kind in ("file", "loop"):
        with pytest.raises(StoreError, match=str(path)):
            run(TINY_STUDY, store=path)


# ---- Foreign files --------------------------------------------------------------------------------------------------


def make_variable_rewriter(name, change_values):
    """Return a function that changes the values of one variable in a block file."""

    return lambda file: rewrite_variable(file, name, change_values)


def make_attribute_setter(name, value):
    def set_attribute(file):
        file.attrs[name] = value

    return set_attribute


def replace_by_link_to_other_file(file):
    del file["contact_area"]
    file["contact_area"] = h5py.ExternalLink("other.nc", "contact_area")


def read_variable_from_bytes_of_other_file(file):
    shape = file["contact_area"].shape
    del file["contact_area"]
    file.create_dataset("contact_area", shape, "f8", external=[("/etc/passwd", 0, h5py.h5f.UNLIMITED)])


def replace_by_virtual_dataset_of_other_file(file):
    shape = file["contact_area"].shape
    del file["contact_area"]
    layout = h5py.VirtualLayout(shape, "f8")
    layout[...] = h5py.VirtualSource("other.nc", "contact_area", shape)
    file.create_virtual_dataset("contact_area", layout)


def create_unwritten_variable(file):
    shape = file["contact_area"].shape
    del file["contact_area"]
    file.create_dataset("contact_area", shape, "f8")


BLOCK_FILE_CHANGES = {
    "no variable": lambda file: file.__delitem__("contact_area"),
    "another shape": make_variable_rewriter("contact_area", lambda values: values[..., :2]),
    "an infinite area": make_variable_rewriter("contact_area", lambda values: np.full_like(values, np.inf)),
    "no study text": lambda file: file.attrs.__delitem__("study"),
    "an invalid study text": make_attribute_setter("study", "seed"),
    "a link to another file": replace_by_link_to_other_file,
    "bytes of another file": read_variable_from_bytes_of_other_file,
    "numbers of another file": replace_by_virtual_dataset_of_other_file,
    "numbers that were never written": create_unwritten_variable,
}


@pytest.mark.parametrize("change", BLOCK_FILE_CHANGES.values(), ids=BLOCK_FILE_CHANGES)
def test_block_file_that_contradicts_its_study_is_reported_with_a_one_line_error(directory_copy, change):
    file = find_block_file(directory_copy, 4)
    with h5py.File(file, "r+") as opened_file:
        change(opened_file)
    content = file.read_bytes()
    copy = directory_copy / "result.nc"
    copy.write_bytes(content)
    with pytest.raises(StoreError, match=r"result\.nc: ") as error_info:
        store.read(copy)
    assert len(str(error_info.value).splitlines()) <= 2
    replace_block_content(file, content)
    with pytest.raises(StoreError, match="recompute members 4 to 7"):
        store.read(directory_copy)


def test_units_of_variables_in_block_files_are_ignored(directory_copy, uninterrupted_dataset):
    file = find_block_file(directory_copy, 4)
    with h5py.File(file, "r+") as opened_file:
        opened_file["approach"].attrs["units"] = "seconds since 1970-01-01"
        opened_file["contact_area"].attrs["scale_factor"] = "ten"
        opened_file["contact_area"].attrs["_FillValue"] = 0.0
        opened_file.attrs["more"] = "x" * 100_000
    replace_block_content(file, file.read_bytes())
    assert_same_bits(store.read(directory_copy), uninterrupted_dataset)


# ---- Disks ----------------------------------------------------------------------------------------------------------


def test_run_on_full_disk_preserves_finished_blocks(tmp_path, uninterrupted_dataset, monkeypatch):
    """Let the disk fill up after 0, 1, 2 and 1 more files; each run reports the error, and the next run resumes."""
    write, num_writes = _files.Path.write_bytes, 0

    def write_until_full(self, content):
        nonlocal num_writes
        num_writes -= 1
        if num_writes < 0:
            write(self, content[:3])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
        return write(self, content)

    monkeypatch.setattr(_files.Path, "write_bytes", write_until_full)
    for num_writes, num_finished in ((0, 0), (1, 0), (2, 8), (1, 12)):  # noqa: B007 (read by write_until_full)
        with pytest.raises(StoreError, match="cannot be written: No space left on device") as error_info:
            run(TINY_STUDY, store=tmp_path, executor=InlineExecutor())
        if num_finished:
            assert store.open_stored_result(tmp_path).finished_members.size == num_finished
            assert f"{num_finished} of 22 repetitions are finished and kept" in str(error_info.value)
        assert_no_partial_files(tmp_path)
    monkeypatch.undo()
    assert_same_bits(run(TINY_STUDY, store=tmp_path).dataset, uninterrupted_dataset)


def test_run_does_not_recreate_a_result_directory_removed_during_the_run(tmp_path, monkeypatch):
    path, write_block = tmp_path / "r", store.write_block

    def write_and_move_directory(directory, first_repetition, written, count):
        write_block(directory, first_repetition, written, count)
        if first_repetition == 4:
            path.rename(tmp_path / "moved")

    monkeypatch.setattr(runner, "write_block", write_and_move_directory)
    with pytest.raises(StoreError, match="was removed or replaced"):
        run(TINY_STUDY, store=path, executor=InlineExecutor())
    assert os.listdir(tmp_path) == ["moved"]
    assert store.info(tmp_path / "moved").finished == 8


def test_run_reports_a_study_file_removed_during_the_run(tmp_path, monkeypatch):
    write_block = store.write_block

    def write_and_remove_study_file(directory, first_repetition, written, count):
        write_block(directory, first_repetition, written, count)
        (directory / STUDY_FILE).unlink(missing_ok=True)

    monkeypatch.setattr(runner, "write_block", write_and_remove_study_file)
    with pytest.raises(StoreError, match="files were removed while the study was running; run the study again"):
        run(TINY_STUDY, store=tmp_path, executor=InlineExecutor())


def test_empty_study_file_is_reported_and_restored_by_the_next_run(directory_copy, computed_repetitions):
    study_text = (directory_copy / STUDY_FILE).read_text(encoding="utf-8")
    (directory_copy / STUDY_FILE).write_text("\n")
    with pytest.raises(StoreError, match="is empty; run the study again in this directory to restore the file"):
        store.read(directory_copy)
    run(TINY_STUDY, store=directory_copy)
    assert computed_repetitions == []
    assert (directory_copy / STUDY_FILE).read_text(encoding="utf-8") == study_text


def test_complete_result_on_a_read_only_disk_can_be_read(directory_copy, computed_repetitions, monkeypatch):
    def fail_read_only(*_):
        raise OSError(errno.EROFS, os.strerror(errno.EROFS))

    monkeypatch.setattr(_files, "remove_stale_partial_files", fail_read_only)
    study_at_other_mu0 = TINY_STUDY.with_changes({"friction.mu0": [0.2]})
    assert run(study_at_other_mu0, store=directory_copy).dataset.attrs["study"] == study_at_other_mu0.to_toml()
    assert computed_repetitions == []
    for study, directory in ((with_repetitions(23), directory_copy), (TINY_STUDY, directory_copy.with_name("new"))):
        with pytest.raises(StoreError, match="cannot be written: Read-only file system"):
            run(study, store=directory)


# ---- Interrupts -----------------------------------------------------------------------------------------------------


def test_partial_files_of_ended_processes_are_removed_by_the_next_run(directory_copy):
    ended_process = subprocess.Popen([sys.executable, "-c", ""])
    ended_process.wait()
    machine, _, process_token = _files.PARTIAL_FILE_NAME_PATTERN.fullmatch(_files.new_partial_file_name()).groups()
    is_kept = {
        f".stiction-{machine}-{ended_process.pid}-00000000-00000000.partial": False,
        # The file of an earlier process that had the same process id.
        f".stiction-{machine}-{os.getpid()}-00000000-00000000.partial": False,
        f".stiction-{machine}-{os.getpid()}-{process_token}-00000000.partial": True,
        f".stiction-{machine}-{os.getppid()}-00000000-00000000.partial": True,
        # The file of another machine, which is not old enough to be removed.
        ".stiction-00000000-1-00000000-00000000.partial": True,
        ".stiction-00000000-1-00000000-00000001.partial": False,
        "mine.partial": True,
    }
    for directory, name in itertools.product((directory_copy, directory_copy / BLOCKS_DIRECTORY), is_kept):
        (directory / name).write_text("half")
        if name.endswith("1.partial"):
            os.utime(directory / name, (0, 0))
    run(TINY_STUDY, store=directory_copy)
    for directory in (directory_copy, directory_copy / BLOCKS_DIRECTORY):
        assert {name for name in os.listdir(directory) if name.endswith(".partial")} == {
            n for n in is_kept if is_kept[n]
        }


def test_partial_file_removed_by_another_process_is_written_again(tmp_path, uninterrupted_dataset, monkeypatch):
    replace, removed_files = Path.replace, []

    def remove_and_replace(self, target):
        if self.suffix == ".partial" and not removed_files:
            removed_files.append(self)
            self.unlink()
        return replace(self, target)

    compute_missing_blocks(with_repetitions(4), tmp_path)
    store.create_or_open_result(tmp_path, TINY_STUDY)
    monkeypatch.setattr(Path, "replace", remove_and_replace)
    assert_same_bits(run(TINY_STUDY, store=tmp_path).dataset, uninterrupted_dataset)
    assert removed_files


def test_interrupt_during_a_write_leaves_no_partial_file(tmp_path, monkeypatch):
    def close_and_interrupt(file):
        close(file)
        raise KeyboardInterrupt

    close = os.close
    monkeypatch.setattr(os, "close", close_and_interrupt)
    with pytest.raises(KeyboardInterrupt):
        run(TINY_STUDY, store=tmp_path / "r")
    assert_no_partial_files(tmp_path)


SCRIPT_THAT_KILLS_RUNS = """
import os, signal, sys
from concurrent.futures import Future
from pathlib import Path
from stiction import Study, run
from stiction.solve import runner
runner.choose_block_size = lambda study: 4
class InlineExecutor:
    def submit(self, function, *args):
        future = Future()
        future.set_result(function(*args))
        return future
def run_until(step):
    left = step
    def count_calls(name):
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
        count_calls(name)
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


def test_run_that_was_killed_at_any_disk_operation_can_be_resumed(tmp_path, uninterrupted_dataset):
    """Kill each run at its first, second, ... disk operation, with half of the file written; the next run resumes."""
    (tmp_path / "s.toml").write_text(TINY_STUDY.to_toml())
    completed = subprocess.run(
        [sys.executable, "-W", "ignore", "-c", SCRIPT_THAT_KILLS_RUNS],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert completed.returncode == 0, completed.stderr
    statuses = [int(line.split()[1]) for line in completed.stdout.splitlines()]
    assert statuses[-1] == 0
    assert set(statuses[:-1]) == {-signal.SIGKILL}
    assert len(statuses) > 5
    assert_same_bits(run(TINY_STUDY, store=tmp_path / "r").dataset, uninterrupted_dataset)
    assert_no_partial_files(tmp_path)


# ---- Several runs in one directory -----------------------------------------------------------------------------------

CHANGES_TO_ANOTHER_STUDY = [{"ensemble.seed": 1}, {"contact.effective_modulus": "11 GPa"}, {"friction.mu0": [0.3]}]


class WaitingExecutor(InlineExecutor):
    """Executor whose first task waits for the event `proceed`."""

    def __init__(self):
        super().__init__()
        self.has_started, self.proceed = threading.Event(), threading.Event()

    def submit(self, function, /, *args, **kwargs):
        self.has_started.set()
        assert self.proceed.wait(60)
        return super().submit(function, *args, **kwargs)


@pytest.mark.parametrize("change", CHANGES_TO_ANOTHER_STUDY, ids=str)
def test_run_of_another_study_is_rejected_while_a_run_uses_the_directory(tmp_path, uninterrupted_dataset, change):
    executor, other_study = WaitingExecutor(), TINY_STUDY.with_changes(change)
    with ThreadPoolExecutor(1) as threads:
        first_run = threads.submit(run, TINY_STUDY, executor=executor, store=tmp_path)
        try:
            assert executor.has_started.wait(60)
            study_text = (tmp_path / STUDY_FILE).read_text()
            (claim_file,) = tmp_path.glob("*.partial")
            with pytest.raises(StoreError, match=rf"is in use by another run.* remove {re.escape(str(claim_file))}"):
                run(other_study, store=tmp_path)
            assert (tmp_path / STUDY_FILE).read_text() == study_text
            assert_same_bits(run(TINY_STUDY, store=tmp_path).dataset, uninterrupted_dataset)
        finally:
            executor.proceed.set()
        assert_same_bits(first_run.result().dataset, uninterrupted_dataset)
    assert store.info(tmp_path).study == TINY_STUDY
    assert_no_partial_files(tmp_path)


def test_new_directory_accepts_only_one_of_two_studies_started_at_the_same_time(tmp_path):
    for index in range(10):
        studies = [with_repetitions(4).with_changes({"ensemble.seed": seed}) for seed in (1, 2)]
        barrier = threading.Barrier(2)

        def run_after_barrier(study, directory=tmp_path / str(index), barrier=barrier):
            barrier.wait()
            try:
                return run(study, store=directory, executor=InlineExecutor())
            except StoreError:
                return None

        with ThreadPoolExecutor(2) as threads:
            results = list(threads.map(run_after_barrier, studies))
        winners = [study for study, result in zip(studies, results, strict=True) if result is not None]
        assert len(winners) == 1
        assert_same_bits(store.read(tmp_path / str(index)), run(winners[0]).dataset)


SCRIPT_THAT_WAITS = r"""
import os, time
from pathlib import Path
from stiction import Study, run
from stiction.solve import runner
# One write for each line: the lines of print() may mix with lines of another thread.
runner.compute_member_arrays = lambda *_: os.write(1, b"computing\n") and time.sleep(600)
run(Study.from_toml("s.toml"), store="r")
"""


def test_killed_run_does_not_leave_its_directory_locked(tmp_path, uninterrupted_dataset):
    (tmp_path / "s.toml").write_text(TINY_STUDY.with_changes({"ensemble.seed": 1}).to_toml())
    with subprocess.Popen(
        [sys.executable, "-c", SCRIPT_THAT_WAITS], cwd=tmp_path, stdout=subprocess.PIPE, text=True
    ) as process:
        try:
            assert process.stdout.readline() == "computing\n"
            with pytest.raises(StoreError, match="is in use by another run"):
                run(TINY_STUDY, store=tmp_path / "r")
        finally:
            process.kill()
    assert_same_bits(run(TINY_STUDY, store=tmp_path / "r").dataset, uninterrupted_dataset)
    assert_no_partial_files(tmp_path)


# ---- Export ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["dataset", "directory"])
def test_exported_dataset_equals_the_computed_dataset(
    directory_copy, uninterrupted_dataset, tmp_path, monkeypatch, kind
):
    monkeypatch.setattr(layout, "MAX_MEMBER_PIECE_BYTES", 9 * layout.compute_bytes_per_member(TINY_STUDY))
    file = tmp_path / "r.nc"
    export(uninterrupted_dataset if kind == "dataset" else store.open_stored_result(directory_copy).dataset(), file)
    assert_same_bits(store.read(file), uninterrupted_dataset)
    assert_same_bits(xarray.load_dataset(file, engine="h5netcdf"), uninterrupted_dataset)
    with pytest.raises(ExportError, match="already exists"):
        export(uninterrupted_dataset, file)


def test_reading_a_netcdf_file_of_another_program_raises_store_error(tmp_path, uninterrupted_dataset):
    means = uninterrupted_dataset.mean("repetition")
    export(means, tmp_path / "means.nc")
    xarray.testing.assert_identical(xarray.load_dataset(tmp_path / "means.nc", engine="h5netcdf"), means)
    for content in (b"", b"\x89HDF\r\n\x1a\n", os.urandom(1000), (tmp_path / "means.nc").read_bytes()):
        (tmp_path / "x.nc").write_bytes(content)
        with pytest.raises(StoreError, match=r"x\.nc: "):
            store.read(tmp_path / "x.nc")


def test_dataset_files_written_at_different_times_are_byte_identical(uninterrupted_dataset):
    """File names contain a checksum of the bytes; old versions of h5py store the time of writing in the file."""
    first_file, second_file = io.BytesIO(), io.BytesIO()
    store.write_dataset(uninterrupted_dataset, first_file)
    time.sleep(1.01)
    store.write_dataset(uninterrupted_dataset, second_file)
    assert first_file.getvalue() == second_file.getvalue()


def test_encoding_a_block_rejects_arrays_of_the_wrong_shape(uninterrupted_dataset):
    arrays = {name: uninterrupted_dataset[name].values for name in TINY_STUDY.contact_sum_names()}
    with pytest.raises(ValueError, match=r"contact_count must have the shape \(.*\), got \(.*\)"):
        store.encode_members(TINY_STUDY, range(22), arrays | {"contact_count": arrays["contact_count"][..., :1]})


def find_dimensions_by_scale(file, name):
    """Return the names of a variable's dimensions in an open netCDF file, found by the dimension scales."""
    if file[name].is_scale:
        return [name]
    return [axis[0].name.removeprefix("/") for axis in file[name].dims]


def find_dimensions_by_number(file, name):
    """Return the names of a variable's dimensions in an open netCDF file, found by the numbers in attributes."""
    names = {
        int(scale.attrs["_Netcdf4Dimid"]): dimension_name for dimension_name, scale in file.items() if scale.is_scale
    }
    if file[name].is_scale:
        return [names[int(file[name].attrs["_Netcdf4Dimid"])]]
    numbers = [int(number) for number in file[name].attrs.get("_Netcdf4Coordinates", [])]
    assert numbers[:1] == ([int(file[name].attrs["_Netcdf4Dimid"])] if numbers else [])
    return [names[number] for number in numbers]


def test_stored_block_has_the_same_content_as_a_file_written_by_xarray(uninterrupted_dataset):
    """Compare the variables, types and attributes of files that the store and xarray write."""
    dataset_part = uninterrupted_dataset.isel(repetition=slice(4, 8))
    dataset_of_types = dataset_part.assign_coords(
        place=("repetition", [True, False, True, False]), words=("approach", [*"abcd"]), area=3.0
    )
    dataset_of_dimensions = xarray.Dataset(
        {"empty": (("row", "column"), np.zeros((3, 0))), "numbers": ("row", np.arange(3))},
        {"point": ("point", [0.5, 1.5])}, {"count": 3, "factor": 2.5, "words": ["a", "b"], "steps": [1, 2]},
    )  # fmt: skip
    for dataset in (dataset_part, dataset_of_types, dataset_part.mean("repetition"), dataset_of_dimensions):
        store_file, xarray_file = io.BytesIO(), io.BytesIO()
        store.write_dataset(dataset, store_file)
        dataset.to_netcdf(
            xarray_file, engine="h5netcdf", encoding={name: {"_FillValue": None} for name in dataset.variables}
        )
        xarray.testing.assert_identical(xarray.load_dataset(store_file, engine="h5netcdf"), dataset)
        with h5py.File(store_file) as store_variables, h5py.File(xarray_file) as xarray_variables:
            assert set(store_variables) == set(xarray_variables)
            assert store_variables.attrs.keys() == xarray_variables.attrs.keys()
            for name in store_variables:
                assert store_variables[name].dtype == xarray_variables[name].dtype
                assert store_variables[name].attrs.keys() == xarray_variables[name].attrs.keys()
                for file in (store_variables, xarray_variables):
                    assert find_dimensions_by_number(file, name) == find_dimensions_by_scale(file, name)
                assert find_dimensions_by_scale(store_variables, name) == find_dimensions_by_scale(
                    xarray_variables, name
                )
    block = io.BytesIO()
    store.write_dataset(dataset_part, block)
    assert (
        store.encode_members(
            TINY_STUDY, range(4, 8), {name: dataset_part[name].values for name in TINY_STUDY.contact_sum_names()}
        )
        == block.getvalue()
    )


SCRIPT_WITH_INTERRUPT = r"""
import os, signal, sys, threading
from stiction import Study
from stiction.solve import runner
study, sums, interrupted = Study.from_toml("s.toml"), runner.compute_member_arrays, threading.Event()
def write_line(word):  # one write for each line: the lines of print() may mix with lines of another thread
    os.write(1, f"{word}\n".encode())
def sum_or_wait(study, member):
    if member >= 20:
        write_line("waiting")
        interrupted.wait()
    return sums(study, member)
def interrupt(*of):
    interrupted.set()
    signal.default_int_handler(*of)
signal.signal(signal.SIGINT, interrupt)
runner.compute_member_arrays = sum_or_wait
runner.choose_block_size = lambda study: 8
write_line("started")
try:
    runner.compute_missing_blocks(study, "r", announce=lambda text: write_line("ready"))
except KeyboardInterrupt:
    sys.exit(130)
"""


def test_interrupt_stops_the_run_and_preserves_finished_blocks(tmp_path):
    study = with_repetitions(1000)
    (tmp_path / "s.toml").write_text(study.to_toml())
    with (
        subprocess.Popen(
            [sys.executable, "-c", SCRIPT_WITH_INTERRUPT], cwd=tmp_path, stdout=subprocess.PIPE, start_new_session=True
        ) as process,
        contextlib.ExitStack() as cleanup,
    ):
        cleanup.callback(process.kill)  # `kill` has no effect if the process has ended
        assert process.stdout.readline() == b"started\n"
        # The lines may have any order, because different threads print them.
        pending_lines = {b"ready\n", b"waiting\n"}
        while pending_lines and (line := process.stdout.readline()):
            pending_lines.discard(line)
        process.send_signal(signal.SIGINT)
        assert process.wait(300) == 130
    stored_result = store.open_stored_result(tmp_path / "r")
    # The interrupt leaves many of the 1000 repetitions unfinished, even on a busy machine.
    assert 8 <= stored_result.finished_members.size < 500
    assert_no_partial_files(tmp_path)
    expected = run(with_repetitions(int(stored_result.finished_members[-1]) + 1)).dataset
    assert_same_bits(
        stored_result.dataset().assign_attrs(expected.attrs), expected.isel(repetition=stored_result.finished_members)
    )


def test_reading_a_result_without_finished_pairs_raises_store_error(tmp_path):
    store.create_or_open_result(tmp_path, TINY_STUDY)
    with pytest.raises(StoreError, match="none of the 22 repetitions is finished"):
        Result(store.open_stored_result(tmp_path)).at_study_loads  # noqa: B018


@pytest.mark.parametrize("newline", ["\n", "\r\n"], ids=["LF", "CRLF"])
@pytest.mark.parametrize("has_checksum", [False, True])
def test_result_can_be_extended_if_its_study_file_lacks_a_checksum_or_has_other_line_endings(
    tmp_path, newline, has_checksum
):
    run(with_repetitions(1), store=tmp_path)
    file = tmp_path / STUDY_FILE
    text = file.read_text("utf-8")
    if not has_checksum:
        text = f"{store.STUDY_FILE_SIGNATURE} {__version__}.\n\n" + text.partition("\n\n")[2]
    file.write_text(text, encoding="utf-8", newline=newline)
    assert run(with_repetitions(2), store=tmp_path).members.tolist() == [0, 1]
