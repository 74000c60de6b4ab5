"""Small files that lie beside a result, as `export` wrote them, and damaged."""

import random

import h5py
import pytest
import xarray
from stiction.studies import contact_picture, onset
from stiction.studies.contact_picture import load_contact_picture
from stiction.studies.executors import thread_executor
from stiction.studies.onset import compute_onset, load_onset
from stiction.studies.runner import compute_missing
from stiction.studies.store import CHECKSUM_SEAL, StoreError, export, open_stored, read
from support.measured_studies import study_of, write_maps

FILES = {"picture.nc": load_contact_picture, "onset.nc": load_onset}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """A result of two maps, and what lies beside it by its file."""
    folder = tmp_path_factory.mktemp("maps")
    more = 'load = ["2 mN"]\ndirection = [0, 180]'
    study = study_of(folder, spacing=write_maps(folder, shape=(32, 32)), members=2, contact=more)
    compute_missing(study, folder / "r")
    stored = open_stored(folder / "r")
    with thread_executor(1) as executor:
        of = {"picture.nc": contact_picture.contact_picture(stored), "onset.nc": compute_onset(study, executor)}
    assert set(of) == {contact_picture.PICTURE_FILE, onset.ONSET_FILE}
    return stored, of


@pytest.fixture
def stored(made):
    stored, of = made
    for name, dataset in of.items():
        (stored.path / name).unlink(missing_ok=True)
        export(dataset, stored.path / name)
    return stored


@pytest.mark.parametrize("name", FILES)
def test_file_stored_alongside_is_read_or_none(made, stored, name):
    xarray.testing.assert_identical(FILES[name](stored), made[1][name])
    (stored.path / name).unlink()
    assert FILES[name](stored) is None


@pytest.mark.parametrize("name", ["picture.nc", "onset.nc", "result.nc"])
def test_flipped_bit_is_detected_before_the_file_is_opened(stored, name, monkeypatch):
    path = stored.path / name
    if name == "result.nc":
        export(stored.dataset(), path)
    content = path.read_bytes()
    assert content[-len(CHECKSUM_SEAL) - 8 : -8] == CHECKSUM_SEAL
    monkeypatch.setattr(h5py, "File", None)  # in which it may run for ever
    sealed = 8 * (len(content) - len(CHECKSUM_SEAL) - 8)
    for place in [0, sealed - 1, 8 * len(content) - 1, *random.Random(5).sample(range(sealed), 50)]:
        damaged = bytearray(content)
        damaged[place // 8] ^= 1 << place % 8
        path.write_bytes(damaged)
        with pytest.raises(StoreError, match=rf"{name}: does not match its checksum"):
            FILES.get(name, lambda stored: read(stored.path / "result.nc"))(stored)
    path.unlink()


@pytest.mark.parametrize(("name", "variable"), [("picture.nc", "lower_height"), ("onset.nc", "displacement")])
def test_file_without_a_variable_is_rejected_in_one_sentence(stored, name, variable):
    with h5py.File(stored.path / name, "r+") as file:
        del file[variable]
    with pytest.raises(StoreError, match=rf"{name}: .*remove it and run the study again") as refused:
        FILES[name](stored)
    assert len(str(refused.value).splitlines()) == 1


def test_onset_with_other_steps_is_ignored(stored):
    with h5py.File(stored.path / "onset.nc", "r+") as file:
        file["fraction"][0] = 0.07
    assert load_onset(stored) is None
