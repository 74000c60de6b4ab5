"""Tests of the commands `run`, `studies` and `plot`, of help texts and of shell completion."""

import re
import shlex
import shutil
from pathlib import Path

import pytest
import stiction
import typer
from stiction import Study, study_names
from stiction.cli.application import COMMANDS_BY_GROUP, app
from stiction.solve import store
from support.command import assert_rejected, call_stiction, check_stiction

SMALL_STUDY_OPTIONS = [
    "--set", "surfaces.fractal_dimension=[1.1, 1.4]", "--set", "surfaces.points=4000", "--set", "surfaces.extent=2 um",
    "--set", "ensemble.repetitions=3", "--set", "contact.approach.count=5",
]  # fmt: skip


@pytest.fixture(scope="module")
def directory_and_output(tmp_path_factory):
    directory = tmp_path_factory.mktemp("ran")
    completed = check_stiction(
        "run", "quick", *SMALL_STUDY_OPTIONS, "--workers", 2, cwd=directory, without_figures=True
    )
    return directory, completed


def test_run_command_writes_the_result_and_figures_to_the_output_directory(directory_and_output):
    directory, completed = directory_and_output
    figures = {"friction_mu0_0.1.png", "friction_mu0_0.4.png", "friction_mu0_1.png", "area.png"}
    assert {path.name for path in (directory / "quick").iterdir()} == {"study.toml", "blocks", *figures}
    written_names = [line.removeprefix("wrote ") for line in completed.stdout.splitlines() if line.startswith("wrote")]
    assert set(written_names) == {"quick", *(str(Path("quick") / name) for name in figures)}
    assert "μ_s [95 %] at amplitude " in completed.stdout
    dataset = store.read(directory / "quick")
    assert dataset.sizes == {"fractal_dimension": 2, "amplitude": 1, "repetition": 3, "approach": 5}
    assert float(dataset["contact_count"].sum()) > 0


def test_run_command_recomputes_nothing_if_the_result_is_complete(directory_and_output):
    directory, _ = directory_and_output
    for arguments in (
        ("quick", *SMALL_STUDY_OPTIONS),
        ("quick/study.toml",),
        ("quick/study.toml", "--output", "quick"),
    ):
        completed = check_stiction("run", *arguments, cwd=directory, without_figures=True)
        assert "already contains this study" in completed.stdout
    (directory / "quick" / "area.png").unlink()
    check_stiction("plot", "quick", cwd=directory, without_figures=True)
    assert (directory / "quick" / "area.png").exists()


def test_run_command_with_another_mu0_keeps_the_figures_of_the_earlier_mu0(directory_and_output, tmp_path):
    shutil.copytree(directory_and_output[0] / "quick", tmp_path / "quick")
    changes = "--set", "friction.mu0=[0.3]"
    completed = check_stiction("run", "quick", *SMALL_STUDY_OPTIONS, *changes, cwd=tmp_path, without_figures=True)
    message = " ".join(completed.stderr.split())
    assert "its 3 repetitions are kept, and output files with the same names are replaced" in message
    assert {"friction_mu0_0.1.png", "friction_mu0_0.3.png"} <= {path.name for path in (tmp_path / "quick").iterdir()}


def test_run_command_adds_repetitions_and_reports_missing_repetitions(directory_and_output, tmp_path):
    assert_rejected(
        call_stiction("run", "quick", *SMALL_STUDY_OPTIONS, "--set", "ensemble.seed=1", cwd=directory_and_output[0]),
        "ensemble.seed",
    )
    shutil.copytree(directory_and_output[0] / "quick", tmp_path / "quick")
    completed = check_stiction(
        "run", "quick", *SMALL_STUDY_OPTIONS, "--set", "ensemble.repetitions=5", cwd=tmp_path, without_figures=True
    )
    assert "3 of 5 repetitions already existed" in completed.stdout
    assert_rejected(call_stiction("run", "quick", *SMALL_STUDY_OPTIONS, cwd=tmp_path), "ensemble.repetitions")
    last_block = sorted((tmp_path / "quick" / "blocks").iterdir())[-1]
    last_block.unlink()
    completed = check_stiction("info", "quick", cwd=tmp_path)
    for expected_words in (
        "surfaces.points = 4_000",
        'surfaces.extent = "2 um"',
        " of 5 finished",
        "MiB",
        stiction.__version__,
    ):
        assert expected_words in completed.stdout, completed.stdout
    assert "gamma" not in completed.stdout
    completed = check_stiction("plot", "quick", cwd=tmp_path, without_figures=True)
    assert "of 5 repetitions are finished" in completed.stderr


def test_result_of_a_run_in_two_parts_equals_the_result_of_a_single_run(directory_and_output, tmp_path):
    for run_part in ("1/2", "2/2"):
        completed = check_stiction("run", "quick", *SMALL_STUDY_OPTIONS, "--part", run_part, cwd=tmp_path)
        assert f"part {run_part} is finished" in completed.stdout
        assert "μ_s" not in completed.stdout
    assert store.read(tmp_path / "quick").equals(store.read(directory_and_output[0] / "quick"))


def test_run_command_stores_the_study_from_the_given_file(tmp_path):
    study = Study().with_changes(
        {
            "surfaces.fractal_dimension": [1.2], "surfaces.points": 4000, "surfaces.extent": "2 um",
            "contact.approach": ["5 nm", "10 nm"], "ensemble.repetitions": 1,
        }
    )  # fmt: skip
    (tmp_path / "mine.toml").write_text(study.to_toml(), encoding="utf-8")
    check_stiction("run", "mine.toml", "--output", "there", cwd=tmp_path, without_figures=True)
    assert store.info(tmp_path / "there").study == study


def test_studies_command_lists_the_names_of_studies_and_prints_a_study_file(tmp_path):
    listed_lines = call_stiction("studies", cwd=tmp_path).stdout.splitlines()
    assert [line.split()[0] for line in listed_lines] == study_names()
    assert all(re.fullmatch(r"[\w-]+ +[A-Z][^#]+\.", line) for line in listed_lines)
    study_text = call_stiction("studies", "figure5", cwd=tmp_path).stdout
    (tmp_path / "figure5.toml").write_text(study_text, encoding="utf-8")
    assert Study.from_toml(tmp_path / "figure5.toml") == Study.named("figure5")


def test_version_option_prints_details_of_the_build_and_help_option_lists_the_commands(tmp_path):
    version, build_line = call_stiction("--version", cwd=tmp_path).stdout.splitlines()
    assert version == f"stiction {stiction.__version__}"
    assert all(value in build_line for value in stiction._core.build().values())
    completed = check_stiction("--help", cwd=tmp_path)
    for name, application_and_summary in (
        command_item for group in COMMANDS_BY_GROUP.values() for command_item in group.items()
    ):
        assert re.search(rf"^  {name} +{re.escape(application_and_summary[1])}$", completed.stdout, re.MULTILINE)


# ---- Help ------------------------------------------------------------------------------------------------------------

COMMAND_NAMES = [name for group in COMMANDS_BY_GROUP.values() for name in group]


@pytest.mark.parametrize("name", COMMAND_NAMES)
def test_help_texts_contain_valid_examples_and_list_exit_statuses(name, monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    command = typer.main.get_command(app).get_command(None, name)
    text = command.get_help(command.context_class(command, info_name=f"stiction {name}"))
    assert "Exit status: 0" in text
    for markup in ("{", "}", "<", "default: (", "[x", "x>="):
        assert markup not in text
    if name != "pair":
        assert max(map(len, text.splitlines())) <= 80
    examples = re.findall(rf"^ +(stiction {name}.*)$", text.replace("\\\n", ""), re.MULTILINE)
    assert examples
    for example in examples:
        arguments = shlex.split(example.partition(" > ")[0].partition("  #")[0])[2:]
        command.make_context(
            name, [argument for argument in arguments if argument != "*.csv"] + ["x.csv"] * ("*.csv" in arguments)
        )


def test_shell_completion_offers_commands_and_options(monkeypatch, tmp_path):
    for typed_words, word_index, expected in (("stiction ru", "1", "run"), ("stiction pair --mu", "2", "--mu0")):
        for name, value in (
            ("_STICTION_COMPLETE", "complete_bash"),
            ("COMP_WORDS", typed_words),
            ("COMP_CWORD", word_index),
        ):
            monkeypatch.setenv(name, value)
        assert expected in call_stiction(cwd=tmp_path).stdout.split()


# ---- Bad input ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "expected_words"),
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
        (["run", "quick", "--output", "file"], ["file must be a directory"]),
        (["run", "quick", "--output", "file/deeper"], ["cannot be written"]),
        (["plot", "nowhere"], ["stiction: nowhere: no such directory"]),
        (["info", "."], ["is not a result"]),
        (["info", "file"], ["stiction: file is a file, but a result is a directory"]),
        (["studies", "figure7b"], ["no built-in study"]),
        (["juggle"], ["stiction: ", "juggle", "--help"]),
        (["run"], ["stiction: ", "STUDY", "try stiction run --help"]),
    ],
)
def test_commands_reject_invalid_input(tmp_path, arguments, expected_words):
    (tmp_path / "binary.toml").write_bytes(b"\x89PNG\r\n\x1a\n\xff\xfe\x00")
    (tmp_path / "file").write_text("")
    assert_rejected(call_stiction(*arguments, cwd=tmp_path), *expected_words)
