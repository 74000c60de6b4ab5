"""Test the files that are stored alongside a result: the contact picture and the onset of sliding."""

import random

import h5py
import numpy as np
import pytest
import xarray
from stiction._threads import thread_pool_executor
from stiction.companions import contact_picture, onset
from stiction.companions.contact_picture import load_contact_picture
from stiction.companions.onset import compute_onset, load_stored_onset
from stiction.solve.runner import compute_missing_blocks
from stiction.solve.store import CHECKSUM_PREFIX, StoreError, export, open_stored_result, read
from support.studies_of_files import create_study_from_files, write_maps

COMPANION_LOADERS = {"picture.nc": load_contact_picture, "onset.nc": load_stored_onset}


@pytest.fixture(scope="module")
def result_and_datasets(tmp_path_factory):
    """Return a stored result of two maps, and the datasets stored alongside it, by file name."""
    directory = tmp_path_factory.mktemp("maps")
    contact_keys = 'load = ["2 mN"]\ndirection = [0, 180]'
    study = create_study_from_files(
        directory, spacing=write_maps(directory, shape=(32, 32)), members=2, contact=contact_keys
    )
    compute_missing_blocks(study, directory / "r")
    complete_result = open_stored_result(directory / "r")
    with thread_pool_executor(1) as executor:
        datasets = {
            "picture.nc": contact_picture.contact_picture(complete_result),
            "onset.nc": compute_onset(study, executor),
        }
    assert set(datasets) == {contact_picture.CONTACT_PICTURE_FILE, onset.ONSET_FILE}
    return complete_result, datasets


@pytest.fixture
def complete_result(result_and_datasets):
    complete_result, datasets = result_and_datasets
    for name, dataset in datasets.items():
        (complete_result.path / name).unlink(missing_ok=True)
        export(dataset, complete_result.path / name)
    return complete_result


@pytest.mark.parametrize("name", COMPANION_LOADERS)
def test_loading_companion_data_of_a_result_returns_none_if_the_file_is_absent(
    result_and_datasets, complete_result, name
):
    xarray.testing.assert_identical(COMPANION_LOADERS[name](complete_result), result_and_datasets[1][name])
    (complete_result.path / name).unlink()
    assert COMPANION_LOADERS[name](complete_result) is None


@pytest.mark.parametrize("name", COMPANION_LOADERS)
def test_companion_data_equal_the_data_that_xarray_reads_from_the_file(complete_result, name):
    loaded_data = COMPANION_LOADERS[name](complete_result)
    with xarray.open_dataset(complete_result.path / name, engine="h5netcdf", decode_cf=False) as expected_data:
        xarray.testing.assert_equal(loaded_data, expected_data)
        assert list(loaded_data.data_vars) == list(expected_data.data_vars)
        assert list(loaded_data.attrs) == list(expected_data.attrs)
        for variable_name, variable in expected_data.variables.items():
            assert loaded_data[variable_name].attrs == variable.attrs


@pytest.mark.parametrize("name", ["picture.nc", "onset.nc", "result.nc"])
def test_flipped_bit_in_a_stored_file_is_detected_before_the_file_is_opened(complete_result, name, monkeypatch):
    path = complete_result.path / name
    if name == "result.nc":
        export(complete_result.dataset(), path)
    content = path.read_bytes()
    assert content[-len(CHECKSUM_PREFIX) - 8 : -8] == CHECKSUM_PREFIX
    # The damaged file is not opened by HDF5, which might never return.
    monkeypatch.setattr(h5py, "File", None)
    num_checked_bits = 8 * (len(content) - len(CHECKSUM_PREFIX) - 8)
    for bit_index in [
        0,
        num_checked_bits - 1,
        8 * len(content) - 1,
        *random.Random(5).sample(range(num_checked_bits), 50),
    ]:
        damaged_content = bytearray(content)
        damaged_content[bit_index // 8] ^= 1 << bit_index % 8
        path.write_bytes(damaged_content)
        with pytest.raises(StoreError, match=rf"{name}: does not match its checksum"):
            COMPANION_LOADERS.get(name, lambda complete_result: read(complete_result.path / "result.nc"))(
                complete_result
            )
    path.unlink()


@pytest.mark.parametrize(("name", "variable"), [("picture.nc", "lower_height"), ("onset.nc", "displacement")])
def test_stored_file_that_lacks_a_variable_is_rejected_with_a_one_line_error(complete_result, name, variable):
    with h5py.File(complete_result.path / name, "r+") as file:
        del file[variable]
    with pytest.raises(StoreError, match=rf"{name}: .*remove the file, and run the study again") as error_info:
        COMPANION_LOADERS[name](complete_result)
    assert len(str(error_info.value).splitlines()) == 1


IMPOSSIBLE_STORED_VALUES = [
    ("picture.nc", "contact_force", np.nan), ("picture.nc", "contact_force", -1.0), ("picture.nc", "patch", -1),
    ("picture.nc", "height_x", 0.0), ("picture.nc", "contact_x", np.inf), ("picture.nc", "@load_mN", "text"),
    ("picture.nc", "@x", h5py.Empty("f8")), ("onset.nc", "slip_x", 0.0), ("onset.nc", "displacement", 1e308),
    ("onset.nc", "@mu0", np.nan), ("onset.nc", "@members", 0), ("onset.nc", "@poisson_ratio", 0.3),
]  # fmt: skip


@pytest.mark.parametrize(("file_name", "name", "value"), IMPOSSIBLE_STORED_VALUES)
def test_error_about_an_impossible_stored_value_names_the_variable(complete_result, file_name, name, value):
    with h5py.File(complete_result.path / file_name, "r+") as file:
        if name.startswith("@"):
            file.attrs[name[1:]] = value
        else:
            file[name][...] = value
    with pytest.raises(StoreError, match=rf"{file_name}: .*{name.removeprefix('@')}.*remove the file") as error_info:
        COMPANION_LOADERS[file_name](complete_result)
    assert len(str(error_info.value).splitlines()) == 1


def test_stored_onset_of_sliding_is_ignored_if_its_load_steps_are_outdated(complete_result):
    with h5py.File(complete_result.path / "onset.nc", "r+") as file:
        file["fraction"][0] = 0.07
    assert load_stored_onset(complete_result) is None
