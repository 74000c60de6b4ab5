import re
import shlex
import shutil
from pathlib import Path

import pytest
import stiction
import typer
from stiction import Study, study_names
from stiction.cli.application import COMMANDS, app
from stiction.studies import store
from support.command import assert_rejected, call_stiction, check_stiction

TINY = [
    "--set", "surfaces.fractal_dimension=[1.1, 1.4]", "--set", "surfaces.points=4000", "--set", "surfaces.extent=2 um",
    "--set", "ensemble.repetitions=3", "--set", "contact.approach.count=5",
]  # fmt: skip


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    where = tmp_path_factory.mktemp("ran")
    completed = check_stiction("run", "quick", *TINY, "--workers", 2, cwd=where, without_figures=True)
    return where, completed


def test_run_writes_result_and_figures_to_output(ran):
    where, completed = ran
    figures = {"friction_mu0_0.1.png", "friction_mu0_0.4.png", "friction_mu0_1.png", "area.png"}
    assert {path.name for path in (where / "quick").iterdir()} == {"study.toml", "blocks", *figures}
    wrote = [line.removeprefix("wrote ") for line in completed.stdout.splitlines() if line.startswith("wrote")]
    assert set(wrote) == {"quick", *(str(Path("quick") / name) for name in figures)}
    assert "μ_s [95 %] at amplitude " in completed.stdout
    dataset = store.read(where / "quick")
    assert dataset.sizes == {"fractal_dimension": 2, "amplitude": 1, "repetition": 3, "approach": 5}
    assert float(dataset["contact_count"].sum()) > 0


def test_run_of_complete_result_only_draws(ran):
    where, _ = ran
    for again in (("quick", *TINY), ("quick/study.toml",), ("quick/study.toml", "--output", "quick")):
        completed = check_stiction("run", *again, cwd=where, without_figures=True)
        assert "already contains this study" in completed.stdout
    (where / "quick" / "area.png").unlink()
    check_stiction("plot", "quick", cwd=where, without_figures=True)
    assert (where / "quick" / "area.png").exists()


def test_run_adds_repetitions_and_reports_missing_ones(ran, tmp_path):
    assert_rejected(call_stiction("run", "quick", *TINY, "--set", "ensemble.seed=1", cwd=ran[0]), "ensemble.seed")
    shutil.copytree(ran[0] / "quick", tmp_path / "quick")
    completed = check_stiction(
        "run", "quick", *TINY, "--set", "ensemble.repetitions=5", cwd=tmp_path, without_figures=True
    )
    assert "3 of 5 repetitions already existed" in completed.stdout
    assert_rejected(call_stiction("run", "quick", *TINY, cwd=tmp_path), "ensemble.repetitions")
    last = sorted((tmp_path / "quick" / "blocks").iterdir())[-1]
    last.unlink()
    completed = check_stiction("info", "quick", cwd=tmp_path)
    for words in ("surfaces.points = 4_000", 'surfaces.extent = "2 um"', " of 5 finished", "MiB", stiction.__version__):
        assert words in completed.stdout, completed.stdout
    assert "gamma" not in completed.stdout
    completed = check_stiction("plot", "quick", cwd=tmp_path, without_figures=True)
    assert "of 5 repetitions are finished" in completed.stderr


def test_run_in_parts_equals_single_run(ran, tmp_path):
    for part in ("1/2", "2/2"):
        completed = check_stiction("run", "quick", *TINY, "--part", part, cwd=tmp_path)
        assert f"part {part} is finished" in completed.stdout
        assert "μ_s" not in completed.stdout
    assert store.read(tmp_path / "quick").equals(store.read(ran[0] / "quick"))


def test_run_of_study_file_equals_study(tmp_path):
    study = Study().with_changes(
        {
            "surfaces.fractal_dimension": [1.2], "surfaces.points": 4000, "surfaces.extent": "2 um",
            "contact.approach": ["5 nm", "10 nm"], "ensemble.repetitions": 1,
        }
    )  # fmt: skip
    (tmp_path / "mine.toml").write_text(study.to_toml(), encoding="utf-8")
    check_stiction("run", "mine.toml", "--output", "there", cwd=tmp_path, without_figures=True)
    assert store.info(tmp_path / "there").study == study


def test_studies_lists_and_prints(tmp_path):
    listed = call_stiction("studies", cwd=tmp_path).stdout.splitlines()
    assert [line.split()[0] for line in listed] == study_names()
    assert all(re.fullmatch(r"[\w-]+ +[A-Z][^#]+\.", line) for line in listed)
    printed = call_stiction("studies", "figure5", cwd=tmp_path).stdout
    (tmp_path / "figure5.toml").write_text(printed, encoding="utf-8")
    assert Study.from_toml(tmp_path / "figure5.toml") == Study.named("figure5")


def test_version_and_help_are_printed(tmp_path):
    version, built = call_stiction("--version", cwd=tmp_path).stdout.splitlines()
    assert version == f"stiction {stiction.__version__}"
    assert all(value in built for value in stiction._core.build().values())
    completed = check_stiction("--help", cwd=tmp_path)
    for name, sentence in (item for group in COMMANDS.values() for item in group.items()):
        assert re.search(rf"^  {name} +{re.escape(sentence[1])}$", completed.stdout, re.MULTILINE)


# ---- Help ------------------------------------------------------------------------------------------------------------

NAMES = [name for group in COMMANDS.values() for name in group]


@pytest.mark.parametrize("name", NAMES)
def test_help_has_valid_examples_and_exit_statuses(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    command = typer.main.get_command(app).get_command(None, name)
    text = command.get_help(command.context_class(command, info_name=f"stiction {name}"))
    assert "Exit status: 0" in text
    for braces in ("{", "}", "<", "default: (", "[x", "x>="):
        assert braces not in text
    if name != "pair":
        assert max(map(len, text.splitlines())) <= 80
    lines = re.findall(rf"^ +(stiction {name}.*)$", text.replace("\\\n", ""), re.MULTILINE)
    assert lines
    for line in lines:
        words = shlex.split(line.partition(" > ")[0].partition("  #")[0])[2:]
        command.make_context(name, [word for word in words if word != "*.csv"] + ["x.csv"] * ("*.csv" in words))


def test_completion_offers_commands_and_options(monkeypatch, tmp_path):
    for words, at, expected in (("stiction ru", "1", "run"), ("stiction pair --mu", "2", "--mu0")):
        for name, value in (("_STICTION_COMPLETE", "complete_bash"), ("COMP_WORDS", words), ("COMP_CWORD", at)):
            monkeypatch.setenv(name, value)
        assert expected in call_stiction(cwd=tmp_path).stdout.split()


# ---- Refusals --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["run", "figure7b"], ["no built-in study", "figure6"]),
        (["run", "quik"], ["did you mean quick?"]),
        (["run", "quick", "--part", "3/2"], ["--part"]),
        (["run", "quick", "--workers", "2", "--scheduler", "tcp://a:1"], ["--workers", "--scheduler"]),
        (["run", "quick", "--cluster", "2"], ["--cluster"]),
        (["run", "none.toml"], ["none.toml", "cannot be read"]),
        (["run", "binary.toml"], ["binary.toml", "not a text file"]),
        (["run", "quick", "--set", "ensemble.repetitons=3"], ["ensemble.repetitons", "unknown key", "'repetitions'"]),
        (["run", "quick", "--set", "surfaces.extent=200 parrots"], ["surfaces.extent", "parrots"]),
        (["run", "quick", "--set", "ensemble.seed"], ["KEY=VALUE"]),
        (["run", "quick", "--workers", "0"], ["stiction: ", "--workers"]),
        (["run", "quick", "--output", "file"], ["file is a file"]),
        (["run", "quick", "--output", "file/deeper"], ["cannot be written"]),
        (["plot", "nowhere"], ["stiction: nowhere: no such directory"]),
        (["info", "."], ["is not a result"]),
        (["studies", "figure7b"], ["no built-in study"]),
        (["juggle"], ["stiction: ", "juggle", "--help"]),
        (["run"], ["stiction: ", "STUDY", "try stiction run --help"]),
    ],
)
def test_commands_reject_bad_input(tmp_path, arguments, words):
    (tmp_path / "binary.toml").write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe\x00")
    (tmp_path / "file").write_text("")
    assert_rejected(call_stiction(*arguments, cwd=tmp_path), *words)
