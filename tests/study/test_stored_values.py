"""Test that blocks and companion files with a correct checksum but impossible values are rejected or harmless."""

import contextlib
import io
import json
import shutil

import h5py
import numpy as np
import pytest
from stiction import run
from stiction.solve import store
from stiction.solve.store import BLOCKS_DIRECTORY, decode_members
from stiction.study.stored_values import DamagedFileError
from support.command import call_stiction
from support.generated_studies import rewrite_variable, with_repetitions
from support.studies_of_files import create_study_from_files, write_maps, write_profiles


@pytest.fixture(scope="module")
def result_directories(tmp_path_factory):
    """Return the directories of three results: of maps, of profiles and of generated profiles."""
    directory = tmp_path_factory.mktemp("results")
    contact = 'load = ["1 mN", "2 mN"]\ndirection = [0, 90]'
    spacing = write_maps(directory, shape=(24, 24))
    run(create_study_from_files(directory, spacing=spacing, members=2, contact=contact), store=directory / "maps")
    spacing = write_profiles(directory, points=300)
    options = {"spacing": spacing, "members": 2, "load": "10 uN", "contact": 'load = ["1 uN", "10 uN", "100 uN"]'}
    run(create_study_from_files(directory, "lines", "asperities", **options), store=directory / "profiles")
    run(with_repetitions(2), store=directory / "generated")
    return {name: directory / name for name in ("maps", "profiles", "generated")}


def read_first_block(directory):
    return sorted((directory / BLOCKS_DIRECTORY).iterdir())[0].read_bytes()


def replace_in_file(content, name, replacement):
    """Return the bytes of a file with a new variable or, if the name follows "@", with a new attribute.

    `replacement` is a function of the values of the variable, or the new value of the attribute.
    """
    stream = io.BytesIO(content)
    with h5py.File(stream, "r+") as file:
        if name.startswith("@"):
            file.attrs[name[1:]] = replacement
        else:
            rewrite_variable(file, name, replacement)
    return stream.getvalue()


def fill(value):
    return lambda values: np.full_like(values, value)


def cast(dtype):
    return lambda values: values.astype(dtype)


def replace_values_by_text(values):
    return np.full(values.shape, "x", dtype=object)


IMPOSSIBLE_VALUES = [
    ("maps", "contact_area", fill(1e308)), ("maps", "contact_area", fill(-1.0)), ("maps", "contact_area", fill(0.0)),
    ("maps", "contact_area", fill(1e-320)), ("maps", "contact_area", fill(np.nan)),
    ("maps", "contact_area", replace_values_by_text), ("maps", "contact_count", fill(-3)),
    ("maps", "contact_count", cast(float)), ("maps", "tangential_elastic", fill(-np.inf)),
    ("maps", "tangential_elastic", fill(np.nan)), ("maps", "status", fill(99)), ("maps", "status", fill(1)),
    ("maps", "share_on_largest", fill(2.0)), ("maps", "rms_gradient", fill(np.nan)), ("maps", "rms_slope", fill(-1.0)),
    ("maps", "pressure", cast(complex)), ("maps", "nominal_area", fill(0.0)), ("maps", "nominal_area", fill(np.nan)),
    ("maps", "x", replace_values_by_text), ("maps", "line", fill(-1)), ("maps", "repetition", fill(-1)),
    ("maps", "repetition", cast(float)), ("maps", "@spacing_um", np.zeros(2)), ("maps", "@spacing_um", "text"),
    ("maps", "@spacing_um", h5py.Empty("f8")), ("maps", "@spacing_um", np.ones(5)), ("maps", "@shape", np.ones(2)),
    ("maps", "@upper", 1.0), ("maps", "@upper_spacing_um", np.array([np.nan, 1.0])),
    ("maps", "@lower_extent_um", np.array([1e308, 1.0])), ("maps", "@lower_filled", np.ones(1)),
    ("profiles", "normal_stiffness", fill(1e308)), ("profiles", "patch_area", fill(-1e-9)),
    ("generated", "contact_area", fill(np.nan)), ("generated", "load_below_grid", fill(-1.0)),
    ("generated", "crossed_count", replace_values_by_text),
]  # fmt: skip


@pytest.mark.parametrize(("kind", "name", "replacement"), IMPOSSIBLE_VALUES)
def test_stored_block_with_impossible_values_is_rejected_with_the_name_of_the_variable(
    result_directories, kind, name, replacement
):
    content = read_first_block(result_directories[kind])
    decode_members(content)
    with pytest.raises(DamagedFileError, match=name.removeprefix("@")) as error_info:
        decode_members(replace_in_file(content, name, replacement))
    assert len(str(error_info.value).splitlines()) == 1


MISSING_ATTRIBUTES = ["upper", "shape", "spacing_um", "upper_spacing_um", "lower_extent_um"]


@pytest.mark.parametrize("name", MISSING_ATTRIBUTES)
def test_stored_block_without_an_attribute_of_its_surfaces_is_rejected(result_directories, name):
    stream = io.BytesIO(read_first_block(result_directories["maps"]))
    with h5py.File(stream, "r+") as file:
        del file.attrs[name]
    with pytest.raises(DamagedFileError, match=name):
        decode_members(stream.getvalue())


RANDOM_CHANGES = [
    lambda values, random: np.full_like(values, random.choice([np.nan, np.inf, -1.0, 0.0, 1e308, 1e-320, 1e99, 1e-99])),
    lambda values, random: np.where(random.random(values.shape) < 0.3, random.choice([np.nan, -1.0, 0.0]), values),
    lambda values, random: values * 10 ** random.uniform(-120, 120),
    lambda values, random: random.permutation(values.ravel()).reshape(values.shape),
    lambda values, random: -values,
    lambda values, random: values.astype(random.choice(["f4", ">f8", "c16", "i8", "S3"])),
]  # fmt: skip


def change_at_random(content, random):
    """Return the bytes of a file after a random change of a random variable, and the name of the variable."""
    with h5py.File(io.BytesIO(content)) as file:
        names = [name for name in file if file[name].dtype.kind == "f" and file[name].size]
    name = str(random.choice(names))
    change_values = RANDOM_CHANGES[random.integers(len(RANDOM_CHANGES))]
    with np.errstate(all="ignore"):
        return replace_in_file(content, name, lambda values: change_values(values, random)), name


@pytest.mark.parametrize("kind", ["maps", "profiles", "generated"])
def test_randomly_changed_block_is_rejected_or_gives_finite_output(result_directories, tmp_path, kind):
    random, content, num_accepted = np.random.default_rng(7), read_first_block(result_directories[kind]), []
    for _ in range(24):
        changed_content, name = change_at_random(content, random)
        with contextlib.suppress(DamagedFileError):
            decode_members(changed_content)
            num_accepted.append((name, changed_content))
    assert 2 < len(num_accepted) < 22
    for name, changed_content in num_accepted[:1]:
        directory = tmp_path / name
        shutil.copytree(result_directories[kind], directory)
        for block in (directory / BLOCKS_DIRECTORY).iterdir():
            block.unlink()
        num_members = len(decode_members(changed_content).numbers)
        store.write_block(directory, 0, changed_content, num_members)
        load = ["--load", "1 uN"] if kind == "generated" else []
        commands = [["info", "--json"], ["at", *load], ["export", "table.csv"]]
        for arguments in [*commands, *([] if kind == "generated" else [["report"]])]:
            completed = call_stiction(arguments[0], directory, *arguments[1:], cwd=tmp_path, without_figures=True)
            assert completed.returncode in (0, 2), (name, completed)
            assert "Traceback" not in completed.stderr
            if completed.returncode == 0 and arguments[0] == "info":
                json.loads(completed.stdout, parse_constant=pytest.fail)
        (tmp_path / "table.csv").unlink(missing_ok=True)
