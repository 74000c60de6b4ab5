"""Small files that lie beside a result, as `export` wrote them, as somebody changed them, and damaged."""

import random

import h5py
import numpy as np
import pytest
import xarray
from measured_studies import study_of, write_maps
from stiction.studies import contact_picture, onset
from stiction.studies.contact_picture import picture_beside
from stiction.studies.executors import threads
from stiction.studies.export import export
from stiction.studies.netcdf import SEAL
from stiction.studies.onset import onset_beside, onset_of_result
from stiction.studies.runner import fill
from stiction.studies.store import StoreError, open_stored, read
from tiny import rewritten

FILES = {"picture.nc": picture_beside, "onset.nc": onset_beside}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A result of two maps, and what lies beside it by its file."""
    folder = tmp_path_factory.mktemp("maps")
    more = 'load = ["2 mN"]\ndirection = [0, 180]'
    study = study_of(folder, spacing=write_maps(folder, shape=(32, 32)), members=2, contact=more)
    fill(study, folder / "r")
    stored = open_stored(folder / "r")
    with threads(1) as executor:
        of = {"picture.nc": contact_picture.contact_picture(stored), "onset.nc": onset_of_result(study, executor)}
    assert set(of) == {contact_picture.FILE, onset.FILE}
    return stored, of


@pytest.fixture
def stored(made):
    stored, of = made
    for name, dataset in of.items():
        (stored.path / name).unlink(missing_ok=True)
        export(dataset, stored.path / name)
    return stored


@pytest.mark.parametrize("name", FILES)
def test_it_is_what_was_written_or_nothing(made, stored, name):
    xarray.testing.assert_identical(FILES[name](stored), made[1][name])
    (stored.path / name).unlink()
    assert FILES[name](stored) is None


@pytest.mark.parametrize("name", ["picture.nc", "onset.nc", "result.nc"])
def test_a_flipped_bit_is_found_before_the_library_opens_the_file(stored, name, monkeypatch):
    path = stored.path / name
    if name == "result.nc":
        export(stored, path)
    content = path.read_bytes()
    assert content[-len(SEAL) - 8 : -8] == SEAL
    monkeypatch.setattr(h5py, "File", None)  # in which it may run for ever
    sealed = 8 * (len(content) - len(SEAL) - 8)
    for place in [0, sealed - 1, 8 * len(content) - 1, *random.Random(5).sample(range(sealed), 50)]:
        damaged = bytearray(content)
        damaged[place // 8] ^= 1 << place % 8
        path.write_bytes(damaged)
        with pytest.raises(StoreError, match=rf"{name}: is not what was written"):
            FILES.get(name, lambda stored: read(stored.path / "result.nc"))(stored)
    path.unlink()


def gone(file, name):
    del file[name]


def without_words(file, name):
    file.attrs["load_mN"] = "x" * 10_000
    del name


def without_number(file, name):
    del file.attrs["load_mN"], name


def infinite_number(file, name):
    file.attrs["load_mN"] = np.inf
    del name


def several_numbers(file, name):
    file.attrs["load_mN"] = [2.0, 2.0]
    del name


def other_numbers(file, name):
    file.attrs["lugre_sigma0_mN_per_um"] = np.arange(9.0)
    del name


def bytes_for_a_number(file, name):
    file.attrs["lugre_sigma0_mN_per_um"] = np.void(b"x")
    del name


def words_of_a_model(file, name):
    file.attrs["lugre_sigma0_mN_per_um"] = "ten"
    del name


def unknown_number(file, name):
    file.attrs["load_mN"] = np.nan
    del name


def elsewhere(file, name):
    del file[name]
    file[name] = h5py.ExternalLink("other.nc", name)


def put(change):
    """A lie: the values of a variable are others."""

    return lambda file, name: rewritten(file, name, change)


LIES = {
    "gone": gone,
    "elsewhere": elsewhere,
    "text": put(lambda values: values.astype("S8")),
    "complex": put(lambda values: values * 1j),
    "half as long": put(lambda values: values.astype("f2")),
    "cut": put(lambda values: values[1:]),
    "empty": put(lambda values: values[:0]),
    "one more dimension": put(lambda values: values[np.newaxis]),
    "infinite": put(lambda values: np.full(values.shape, np.inf)),
    "that overflow": put(lambda values: np.full(values.shape, 1e308)),
    "without a number": without_number,
    "with words for a number": without_words,
    "with an infinite number": infinite_number,
    "with several numbers for one": several_numbers,
    "with other numbers for one": other_numbers,
    "with bytes for a number": bytes_for_a_number,
    "with words of a model": words_of_a_model,
    "with an unknown number": unknown_number,
}


@pytest.mark.parametrize("lie", LIES.values(), ids=LIES)
@pytest.mark.parametrize(("name", "variable"), [("picture.nc", "lower_height"), ("onset.nc", "displacement")])
def test_one_that_lies_is_one_sentence(stored, name, variable, lie):
    with h5py.File(stored.path / name, "r+") as file:
        lie(file, variable)
    with pytest.raises(StoreError, match=rf"{name}: .*to have it made again, remove it") as refused:
        FILES[name](stored)
    assert len(str(refused.value).splitlines()) == 1


@pytest.mark.parametrize("name", FILES)
def test_units_and_scales_are_not_taken_from_a_file(made, stored, name):
    with h5py.File(stored.path / name, "r+") as file:
        for each in file.values():
            each.attrs["scale_factor"] = "ten"
            each.attrs["units"] = "days since 2000-01-01"
    for each, values in FILES[name](stored).data_vars.items():
        np.testing.assert_array_equal(values, made[1][name][each])


def test_a_map_of_what_slips_first_is_taken_whole(stored):
    assert {"slip", "lower_height"} <= set(onset_beside(stored).data_vars)
    with h5py.File(stored.path / "onset.nc", "r+") as file:
        del file["lower_height"]
    assert "slip" not in onset_beside(stored)


def test_an_onset_of_other_steps_or_words_is_not_taken(stored):
    with h5py.File(stored.path / "onset.nc", "r+") as file:
        file["fraction"][0] = 0.07
    assert onset_beside(stored) is None
    with h5py.File(stored.path / "onset.nc", "r+") as file:
        file["statistic"][1] = "upper"
    with pytest.raises(StoreError, match=r"onset\.nc: has another statistic"):
        onset_beside(stored)
