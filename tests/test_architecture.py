"""Tests that ARCHITECTURE.md lists the modules of the tree."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
ARCHITECTURE_PAGE = ROOT / "ARCHITECTURE.md"
FILE_PATTERNS_BY_FOLDER = {
    "python/stiction": "*.py",
    "python/stiction/surfaces": "**/*.py",
    "python/stiction/mechanics": "**/*.py",
    "python/stiction/studies": "**/*.py",
    "python/stiction/views": "**/*.py",
    "python/stiction/app": "**/*.py",
    "python/stiction/cli": "**/*.py",
    "cpp/include/stiction": "*.hpp",
}


@pytest.mark.parametrize("folder", FILE_PATTERNS_BY_FOLDER)
def test_architecture_page_lists_the_modules_of_each_folder(folder):
    section = re.search(
        rf"^### `{folder}`\n(.*?)(?=^### |\Z)", ARCHITECTURE_PAGE.read_text("utf-8"), re.DOTALL | re.MULTILINE
    )
    listed_modules = re.findall(r"^\| `([\w.]+)` \| \S", section[1], re.MULTILINE)
    paths = (path.relative_to(ROOT / folder) for path in (ROOT / folder).glob(FILE_PATTERNS_BY_FOLDER[folder]))
    modules = sorted(".".join(path.with_suffix("").parts) for path in paths if path.stem != "__init__")
    assert sorted(listed_modules) == modules


def test_architecture_page_refers_only_to_existing_files():
    text = ARCHITECTURE_PAGE.read_text("utf-8")
    names = re.findall(r"`((?:python|tests|cpp|docs|benchmarks|packaging|tools|examples)/[\w./]+)`", text)
    assert len(names) > 15
    assert [name for name in names if not (ROOT / name).exists()] == []
