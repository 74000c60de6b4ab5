import os
import subprocess
import sys
from pathlib import Path

import matplotlib.figure
import pytest
from command import stiction_command
from stiction import _dask
from stiction.studies import processes
from stiction.views import drawing, figures

TINY = [
    "--set", "surfaces.fractal_dimension=[1.1, 1.4]", "--set", "surfaces.points=4000", "--set", "surfaces.extent=2 um",
    "--set", "ensemble.repetitions=3", "--set", "contact.approach.count=5",
]  # fmt: skip


def test_a_new_command_draws_in_another_process_what_one_process_draws(tmp_path):
    """Numbers are computed by a process that loads neither tables nor pictures."""
    for name in ("one", "other"):
        (tmp_path / name).mkdir()
    code = "import sys; from stiction.cli.application import start; status = start(); print(*sys.modules); exit(status)"
    done = subprocess.run(
        [sys.executable, "-c", code, "run", "quick", *TINY],
        cwd=tmp_path / "one", capture_output=True, text=True, check=True,
    )  # fmt: skip
    *said, loaded = done.stdout.splitlines()
    assert "stiction.studies.store" in loaded.split()
    assert not {"xarray", "pandas", "matplotlib", "zarr", "scipy"} & set(loaded.split())
    here = stiction_command("run", "quick", *TINY, cwd=tmp_path / "other")
    assert said[1:] == here.stdout.splitlines()[1:]
    pictures = sorted((tmp_path / "other/quick").glob("*.png"))
    assert len(pictures) == 4
    for picture in pictures:
        assert picture.read_bytes() == (tmp_path / "one/quick" / picture.name).read_bytes()


def nothing_drawn(store, directory):
    return [directory / store], "answers"


def test_what_draws_is_this_process_where_there_is_no_other(tmp_path, monkeypatch):
    def no_process(*_, **__):
        raise BlockingIOError(11, "Resource temporarily unavailable")

    monkeypatch.setattr(drawing, "_NEEDED", ["not loaded"])
    monkeypatch.setattr(processes.subprocess, "Popen", no_process)
    monkeypatch.setattr(drawing, "_drawn", nothing_drawn)
    with drawing.drawing(Path("r.zarr"), tmp_path) as draw:
        assert draw() == ([tmp_path / "r.zarr"], "answers")


def test_what_another_process_cannot_draw_is_said_as_here(tmp_path):
    taken = tmp_path / "quick" / "area.png"
    taken.parent.mkdir()
    taken.write_text("mine")
    done = subprocess.run(
        [sys.executable, "-m", "stiction", "run", "quick", *TINY],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 2
    assert (
        done.stderr
        == "stiction: quick/area.png: exists already and is something else; remove it, or choose another name\n"
    )
    assert taken.read_text() == "mine"


@pytest.fixture
def pictures(monkeypatch, tmp_path):
    """Four of them; what draws each writes its process, but the failing one fails, wherever it is drawn."""

    def draw(path, failing):
        if failing:
            raise ValueError(f"{path.name} cannot be")
        path.write_text(str(os.getpid()))
        return path

    def as_asked(failing):
        paths = [tmp_path / f"{number}.png" for number in range(4)]
        found = [(path, lambda path=path: draw(path, path.name == failing)) for path in paths]
        monkeypatch.setattr(figures, "pictures", lambda dataset, directory: iter(found))
        return paths

    return as_asked


@pytest.mark.skipif(sys.platform != "linux", reason="one process is no copy of another elsewhere")
@pytest.mark.parametrize("cores", [1, 2])
def test_two_processes_draw_where_there_are_two_cores(pictures, tmp_path, monkeypatch, cores):
    monkeypatch.setattr(drawing, "available_cores", lambda: cores)
    paths = pictures(None)
    assert drawing.draw(None, tmp_path) == paths
    assert len({path.read_text() for path in paths}) == cores


@pytest.mark.parametrize("failing", ["0.png", "1.png"])
def test_a_picture_that_fails_is_an_error_here_wherever_it_is_drawn(pictures, tmp_path, monkeypatch, failing):
    monkeypatch.setattr(drawing, "available_cores", lambda: 2)
    pictures(failing)
    with pytest.raises(ValueError, match=failing):
        drawing.draw(None, tmp_path)


def test_dask_is_hidden_until_it_is_shown_unless_it_is_there(monkeypatch):
    for name in ("dask", "xarray"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    _dask.hide_dask()
    assert sys.modules["dask"] is None
    _dask.show_dask()
    assert "dask" not in sys.modules
    monkeypatch.setitem(sys.modules, "xarray", matplotlib)
    _dask.hide_dask()
    assert "dask" not in sys.modules


def test_a_process_that_got_ready_draws_without_dask():
    code = (
        "import sys; from stiction.views.drawing import _get_ready; _get_ready(); "
        "import xarray; (xarray.DataArray([1.0, 2.0]) * 2).sum(); print(sys.modules['dask'])"
    )
    assert subprocess.check_output([sys.executable, "-c", code], text=True) == "None\n"


def test_pictures_are_drawn_by_the_files_of_their_paths(small_result, tmp_path):
    found = list(figures.pictures(small_result.isel(amplitude=[0]), tmp_path))
    assert [path for path, _ in found] == figures.save_figures(small_result.isel(amplitude=[0]), Path(tmp_path))
