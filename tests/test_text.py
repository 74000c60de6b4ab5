"""Test the printing of text from files, limits of reading files, and safe writing."""

import ast
import itertools
import os
import re
from pathlib import Path

import pytest
import stiction
from stiction import _files
from stiction._files import UnreadableFileError, create_file_atomically, read_file_bytes, replace_file_atomically
from stiction._text import printable_path, printable_text
from support.sources import parse_file


def test_control_characters_are_escaped_before_printing():
    for text in ("\x1b[31m", "a\nb", "\r", "\x07", "\u202e", "\u2028", "\x9b2J", "\ud800", "\x00", "\u200b"):
        message = printable_text(f"one{text}two")
        assert message.isprintable()
        assert message.startswith("one")
        assert message.endswith("two")
    assert printable_text("µm é 漢字 ⟨D⟩") == "µm é 漢字 ⟨D⟩"


def test_long_text_is_shortened_before_printing():
    assert len(printable_text("x" * 10**6)) <= 80
    assert len(printable_path("/" + "y/" * 10**5)) <= 300
    assert printable_text("x" * 80) == "x" * 80


def test_file_reader_limits_the_file_size_and_rejects_special_files(tmp_path):
    (tmp_path / "file").write_bytes(b"x" * 100)
    assert read_file_bytes(tmp_path / "file", 100) == b"x" * 100
    with pytest.raises(UnreadableFileError, match="longer than 99 bytes"):
        read_file_bytes(tmp_path / "file", 99)
    os.mkfifo(tmp_path / "pipe")
    for special_file in (tmp_path / "pipe", _files.Path("/dev/zero")):
        with pytest.raises(UnreadableFileError, match="is not a regular file"):
            read_file_bytes(special_file, 100)
    with pytest.raises(IsADirectoryError):
        read_file_bytes(tmp_path, 100)


@pytest.mark.parametrize(
    "writer", [create_file_atomically, lambda path, failure: replace_file_atomically(path, b"mark", failure)]
)
class TestFileWriting:
    def test_file_writer_uses_unpredictable_temporary_names(self, tmp_path, writer):
        names = []
        for index in range(2):
            with writer(tmp_path / f"f{index}", ValueError) as partial_file:
                assert _files.PARTIAL_FILE_NAME_PATTERN.fullmatch(partial_file.name)
                assert not partial_file.is_symlink()
                names.append(partial_file.name)
                partial_file.write_bytes(b"mark")
        assert names[0] != names[1]
        assert sorted(os.listdir(tmp_path)) == ["f0", "f1"]

    def test_file_writer_does_not_follow_symbolic_links(self, tmp_path, writer, monkeypatch):
        name = _files.new_partial_file_name()
        monkeypatch.setattr(_files, "new_partial_file_name", lambda: name)
        (tmp_path / "target").write_text("mine")
        (tmp_path / name).symlink_to("target")
        with pytest.raises(ValueError, match="already exists"), writer(tmp_path / "f", ValueError):
            pass
        assert (tmp_path / "target").read_text() == "mine"

    def test_file_writer_rejects_directories_and_devices(self, tmp_path, writer, monkeypatch):
        monkeypatch.chdir(tmp_path)
        for directory_or_device in (".", "/dev/null", "/dev/full", "/"):
            with (
                pytest.raises(ValueError, match=re.escape(f"{directory_or_device}: already exists")),
                writer(_files.Path(directory_or_device), ValueError),
            ):
                pass
        assert os.listdir(tmp_path) == []

    def test_written_file_has_the_default_permissions(self, tmp_path, writer):
        (tmp_path / "usual").write_text("")
        with writer(tmp_path / "f", ValueError) as partial:
            partial.write_bytes(b"mark")
        assert (tmp_path / "f").stat().st_mode == (tmp_path / "usual").stat().st_mode


def test_file_with_concurrent_writers_contains_the_complete_text_of_one_writer(tmp_path):
    with replace_file_atomically(tmp_path / "f", b"mark", ValueError) as first_file:
        first_file.write_bytes(b"mark one")
        with replace_file_atomically(tmp_path / "f", b"mark", ValueError) as second_file:
            second_file.write_bytes(b"mark two")
        assert (tmp_path / "f").read_bytes() == b"mark two"
    assert (tmp_path / "f").read_bytes() == b"mark one"


def test_modules_contain_no_string_statements_without_effect():
    """A string as a statement inside a function is usually the lost second half of a message."""
    lost_strings = []
    for path in sorted(Path(stiction.__file__).parent.rglob("*.py")):
        nodes = list(ast.walk(parse_file(path)))
        functions = [node for node in nodes if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)]
        docstring_nodes = {node.body[0] for node in nodes if isinstance(node, ast.ClassDef)}
        for function in functions:
            docstring_nodes |= {function.body[0]}
            docstring_nodes |= {
                node
                for previous_node, node in itertools.pairwise(function.body)
                if is_attribute_assignment(previous_node)
            }
        statements = {node for function in functions for node in ast.walk(function) if isinstance(node, ast.Expr)}
        lost_strings += [
            f"{path.name}:{node.lineno}" for node in statements - docstring_nodes if is_string_node(node.value)
        ]
    assert lost_strings == []


def is_attribute_assignment(node):
    """Return whether a node assigns to an attribute of `self`."""
    targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
    return isinstance(node, ast.Assign | ast.AnnAssign) and (
        isinstance(targets[0], ast.Attribute) and getattr(targets[0].value, "id", "") == "self"
    )


def is_string_node(node):
    return isinstance(node, ast.JoinedStr) or (isinstance(node, ast.Constant) and isinstance(node.value, str))
