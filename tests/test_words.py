"""Tests of tools/words.py, which samples and checks the names and sentences of the tree."""

import importlib.util
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]


@pytest.fixture(scope="module")
def words_tool():
    spec = importlib.util.spec_from_file_location("words", ROOT / "tools/words.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_words_script_joins_consecutive_lines_of_a_comment(words_tool):
    source = "# A comment that goes on\n# over two lines.\nx = 1  # a comment after code that is long enough\n"
    assert list(words_tool.comments({"dev": source})) == [
        ("dev:1", "A comment that goes on over two lines."),
        ("dev:3", "a comment after code that is long enough"),
    ]


def test_words_check_rejects_a_line_of_a_paragraph_that_starts_with_a_percent_sign(words_tool):
    page = (
        "% A comment.\n\nThe area rises by 5\n% in this case.\n\n```sh\nx\n%%sh\n```\n\n- It falls by 5\n  % again.\n"
    )
    faults = list(words_tool.find_dropped_line_faults({"page.md": page}))
    assert [fault.split(": ")[0] for fault in faults] == ["page.md:4", "page.md:12"]


def test_words_script_lists_docstrings_of_constants(words_tool):
    source = '"""Module."""\n\nLIMIT = 3\n"""Largest number of rows."""\n'
    assert list(words_tool.docstring_summaries({"dev": source})) == [
        ("dev:module", "Module."),
        ("dev:4", "Largest number of rows."),
    ]


def test_words_script_groups_names_by_kind_and_counts_each_name_once_per_file(words_tool):
    source = "LIMIT = 1\n\nclass Row:\n    def read(self, file):\n        size = 1\n        size = 2\n"
    spellings = {kind: {name for _, name in items} for kind, items in words_tool.names_by_kind({"dev": source}).items()}
    assert spellings.pop("variable") == {"self", "file", "size"}
    assert spellings == {"function": {"read"}, "class": {"Row"}, "constant": {"LIMIT"}, "test": set()}


@pytest.mark.parametrize("name", ["said", "_said", "SAID"])
def test_words_script_reports_a_name_only_in_directories_that_reject_the_name(words_tool, name):
    files = {"tests/x.py": f"{name} = 1\n", "packaging/x.py": f"{name} = 1\n"}
    faults = list(words_tool.find_name_faults(files, {"tests": ["said"]}))
    assert len(faults) == 1
    assert faults[0].startswith(f"tests/x.py:1: {name} ")


def test_words_script_reports_docstrings_that_start_with_a_rejected_word(words_tool):
    files = {"dev": '"""What a file contains."""\n\n\ndef read():\n    """Return what a file contains."""\n'}
    assert len(list(words_tool.find_first_word_faults(files, {"all": ["What"]}))) == 1


def test_words_script_reports_test_names_that_begin_with_an_article_instead_of_the_tested_unit(words_tool):
    files = {
        "tests/test_x.py": "def test_the_profile_reader_accepts_csv_files():\n    pass\n\n\n"
        "def test_profile_reader_accepts_csv_files():\n    pass\n"
    }
    assert len(list(words_tool.find_test_name_faults(files, {"all": ["the"]}))) == 1


def test_words_script_reports_constants_and_classes_defined_in_several_modules(words_tool):
    files = {
        "packaging/a.py": "SIZE = 1\nROOT = 2\nclass Row: pass\n",
        "packaging/b.py": "_SIZE = 3\nROOT = 2\nclass _Row: pass\n",
    }
    assert words_tool.modules_by_repeated_constant(files) == {"SIZE": set(files)}
    assert words_tool.modules_by_repeated_class(files) == {"Row": set(files)}
    assert list(words_tool.find_repetition_faults(words_tool.modules_by_repeated_class(files), ["Row"])) == []


SAMPLED_FILES = [
    "tools/words.py", "tests/test_words.py", "python/stiction/_errors.py", "python/stiction/_checks.py",
    "CONTRIBUTING.md",
]  # fmt: skip


def test_words_script_draws_a_sample_that_depends_only_on_the_seed(tmp_path):
    """Sample a repository with a few files of this tree, because sampling the whole tree takes long."""
    for name in SAMPLED_FILES:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_bytes((ROOT / name).read_bytes())
    git = ["git", "-c", "user.name=tests", "-c", "user.email=tests@localhost", "-c", "commit.gpgsign=false"]
    subprocess.run([*git, "init", "--quiet"], cwd=tmp_path, check=True)
    for path in ("tests", "."):
        subprocess.run([*git, "add", path], cwd=tmp_path, check=True)
        subprocess.run([*git, "commit", "--quiet", f"--message=tests: add {path}"], cwd=tmp_path, check=True)
    command = [sys.executable, str(tmp_path / "tools/words.py"), "sample", "--number", "10"]
    first_sample, repeated_sample, other_sample = (
        subprocess.check_output([*command, "--seed", seed], text=True, cwd=tmp_path) for seed in ("1", "1", "2")
    )
    assert first_sample == repeated_sample != other_sample
    assert first_sample.count("\n|  | ") == 20
