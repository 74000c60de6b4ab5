import shutil
from pathlib import Path

import pytest
import stiction
import xarray
from command import assert_refused, stiction_command
from stiction import Study, study_names
from stiction.studies import store

TINY = [
    "--set", "surfaces.fractal_dimension=[1.1, 1.4]", "--set", "surfaces.points=4000", "--set", "surfaces.extent=2 um",
    "--set", "ensemble.repetitions=3", "--set", "contact.approach.count=5",
]  # fmt: skip


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    where = tmp_path_factory.mktemp("ran")
    done = stiction_command("run", "quick", *TINY, "--workers", 2, cwd=where)
    assert done.returncode == 0, done.stderr
    return where, done


def test_run_writes_the_result_and_its_figures_where_it_says(ran):
    where, done = ran
    written = ["result.zarr", *(f"friction_mu0_{mu0}.png" for mu0 in ("0.1", "0.4", "1")), "area.png"]
    assert sorted(p.name for p in (where / "quick").iterdir()) == sorted(written)
    assert done.stdout.startswith("to compute: 3 repetitions, up to 2.88 kB in 39 files (")
    wrote = [line for line in done.stdout.splitlines() if line.startswith("wrote")]
    assert wrote == [f"wrote {Path('quick') / name}" for name in written]
    dataset = store.read(where / "quick" / "result.zarr")
    assert dataset.sizes == {"fractal_dimension": 2, "amplitude": 1, "repetition": 3, "approach": 5}
    assert float(dataset["contact_count"].sum()) > 0


def test_run_again_does_not_compute_again(ran):
    where, _ = ran
    done = stiction_command("run", "quick", *TINY, cwd=where)
    assert done.returncode == 0
    assert "holds this study already" in done.stdout


def test_run_does_not_overwrite_another_study(ran):
    where, _ = ran
    assert_refused(
        stiction_command("run", "quick", *TINY, "--set", "ensemble.seed=1", cwd=where),
        "another study",
        "2_016 there, 1 here",
    )


def test_more_repetitions_are_added(ran, tmp_path):
    shutil.copytree(ran[0] / "quick", tmp_path / "quick")
    done = stiction_command("run", "quick", *TINY, "--set", "ensemble.repetitions=5", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "3 of its 5 repetitions were there already" in done.stdout
    assert_refused(stiction_command("run", "quick", *TINY, cwd=tmp_path), "ensemble.repetitions = 3", "at least 5")


def test_info_shows_study_progress_size_versions_and_validity(ran, tmp_path):
    shutil.copytree(ran[0] / "quick", tmp_path / "quick")
    (tmp_path / "quick" / "result.zarr" / "complete" / "c.1").unlink()
    done = stiction_command("info", "quick", cwd=tmp_path)
    assert done.returncode == 0
    for words in (
        "surfaces.points = 4_000",
        'surfaces.extent = "2 um"',
        "2 of 3 finished",
        "MiB",
        f"stiction {stiction.__version__}, schema 2",
        "share beyond hertz",
        "at 40 nm",
    ):
        assert words in done.stdout, done.stdout
    assert "gamma" not in done.stdout
    done = stiction_command("plot", "quick", cwd=tmp_path)
    assert done.returncode == 0
    assert "2 of 3 repetitions are finished" in done.stderr


def test_export_writes_a_file_once(ran):
    where, _ = ran
    done = stiction_command("export", "quick", "quick.nc", cwd=where)
    assert done.returncode == 0, done.stderr
    with xarray.open_dataset(where / "quick.nc", engine="h5netcdf") as exported:
        xarray.testing.assert_identical(exported.load(), store.read(where / "quick" / "result.zarr"))
    assert_refused(stiction_command("export", "quick", "quick.nc", cwd=where), "quick.nc: exists already")


def test_plot_draws_again(ran):
    where, _ = ran
    (where / "quick" / "area.png").unlink()
    done = stiction_command("plot", "quick", cwd=where)
    assert done.returncode == 0
    assert (where / "quick" / "area.png").exists()


def test_claims_judges_every_claim_and_leaves_its_figures_and_tables(tmp_path):
    small = ["surfaces.points=4000", "surfaces.extent=2 um", "contact.approach.count=6", "ensemble.repetitions=20"]
    settings = [argument for setting in small for argument in ("--set", setting)]
    done = stiction_command("claims", *settings, "--repetitions", "21", "--output", "judged", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    verdicts = [line.rsplit(maxsplit=1)[1] for line in done.stdout.splitlines() if line[:1].isdigit()]
    assert len(verdicts) == 8
    assert set(verdicts) <= {"TRUE", "FALSE", "UNDECIDED", "UNDEFINED"}
    for name in ("claims.md", "variants.md", "figure2/profiles.png", "figure8/area.png", "variants/Ra/result.zarr"):
        assert (tmp_path / "judged" / name).exists(), name
    heads = (tmp_path / "judged/columns.md").read_text(encoding="utf-8").splitlines()[0]
    assert heads == "| | lines, 20 repetitions | lines, 21 repetitions | the same by bands |"


def test_a_study_file_runs_as_the_study_it_is(tmp_path):
    study = Study().with_changes(
        {
            "surfaces.fractal_dimension": [1.2],
            "surfaces.points": 4000,
            "surfaces.extent": "2 um",
            "contact.approach": ["5 nm", "10 nm"],
            "ensemble.repetitions": 1,
        }
    )
    (tmp_path / "mine.toml").write_text(study.to_toml(), encoding="utf-8")
    done = stiction_command("run", "mine.toml", "--output", "there", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert store.info(tmp_path / "there" / "result.zarr").study == study


def test_studies_lists_and_prints(tmp_path):
    listed = stiction_command("studies", cwd=tmp_path).stdout.splitlines()
    assert [line.split()[0] for line in listed] == study_names()
    printed = stiction_command("studies", "figure5", cwd=tmp_path).stdout
    (tmp_path / "figure5.toml").write_text(printed, encoding="utf-8")
    assert Study.from_toml(tmp_path / "figure5.toml") == Study.named("figure5")


def test_version_and_help(tmp_path):
    assert stiction_command("--version", cwd=tmp_path).stdout.strip() == f"stiction {stiction.__version__}"
    for command in ([], ["run"], ["plot"], ["info"], ["export"], ["studies"], ["characterise"]):
        done = stiction_command(*command, "--help", cwd=tmp_path)
        assert done.returncode == 0
        assert "Usage" in done.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "figure7b"], ["no built-in study", "figure6"]),
        (["run", "none.toml"], ["none.toml", "cannot be read"]),
        (["run", "binary.toml"], ["binary.toml", "not a text file"]),
        (["run", "quick", "--set", "ensemble.repetitons=3"], ["ensemble.repetitons", "unknown key", "'repetitions'"]),
        (["run", "quick", "--set", "surfaces.extent=200 parrots"], ["surfaces.extent", "parrots"]),
        (["run", "quick", "--set", "surfaces.extent=200"], ["surfaces.extent", "200"]),
        (["run", "quick", "--set", "surfaces.extent=10**10**10 nm"], ["surfaces.extent"]),
        (["run", "quick", "--set", "surfaces.fractal_dimension=[2.0]"], ["surfaces.fractal_dimension[0]"]),
        (["run", "quick", "--set", "ensemble.seed"], ["KEY=VALUE"]),
        (["run", "quick", "--workers", "0"], ["stiction: ", "--workers"]),
        (["run", "quick", "--output", "file"], ["file is a file"]),
        (["run", "quick", "--output", "file/deeper"], ["cannot be written"]),
        (["run", "quick", "--output", "/proc/stiction"], ["cannot be written"]),
        (["plot", "nowhere"], ["stiction: nowhere: no such directory"]),
        (["info", "nowhere"], ["stiction: nowhere: no such directory"]),
        (["report", "nowhere"], ["stiction: nowhere: no such directory"]),
        (["export", "nowhere", "a.nc"], ["stiction: nowhere: no such directory"]),
        (["info", "."], ["is not a result"]),
        (["studies", "figure7b"], ["no built-in study"]),
        (["juggle"], ["stiction: ", "juggle", "--help"]),
        (["run"], ["stiction: ", "NAME_OR_FILE", "try stiction run --help"]),
    ],
)
def test_bad_input_is_one_message_and_status_2(tmp_path, arguments, words):
    (tmp_path / "binary.toml").write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe\x00")
    (tmp_path / "file").write_text("")
    assert_refused(stiction_command(*arguments, cwd=tmp_path), *words)
