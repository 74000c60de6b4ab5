"""Which part of the package may know which: a value goes from surfaces to the command, and nothing points back."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest
import stiction

PACKAGE = Path(stiction.__file__).parent
ROOMS = ("surfaces", "mechanics", "studies", "views", "cli")
"""Each may import from itself and from those before it."""

LOADED = {
    "numpy",
    "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection",
}  # fmt: skip
"""What `import stiction` loads of others; it takes a moment, and plots, files and clusters would take seconds."""

SOURCES = sorted(path.relative_to(PACKAGE) for path in PACKAGE.rglob("*.py"))


def imported(source):
    """Full names of what a module imports from the package, inside functions too."""
    for node in ast.walk(ast.parse((PACKAGE / source).read_text("utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names if name.name.split(".")[0] == "stiction")
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{source} does not say from where it imports {node.module}"
            if node.module.split(".")[0] == "stiction":
                yield from (f"{node.module}.{name.name}" for name in node.names)


@pytest.mark.parametrize("source", [path for path in SOURCES if len(path.parts) > 1], ids=str)
def test_nothing_points_back(source):
    allowed = ROOMS[: ROOMS.index(source.parts[0]) + 1]
    for name in imported(source):
        room = name.split(".")[1]
        assert room.startswith("_") or room in allowed, f"{source} imports {name}"


@pytest.mark.parametrize("source", sorted(path for path in SOURCES if path.match("_[!_]*.py")), ids=str)
def test_what_serves_all_rooms_knows_none(source):
    assert [name for name in imported(source) if not name.split(".")[1].startswith("_")] == []


@pytest.mark.parametrize("source", SOURCES, ids=str)
def test_nothing_goes_through_the_face_of_the_package(source):
    """What the package re-exports is there when all of it is imported: too late for its own modules."""
    for node in ast.walk(ast.parse((PACKAGE / source).read_text("utf-8"))):
        if isinstance(node, ast.Import):
            assert "stiction" not in [name.name for name in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.module != "stiction", f"{source}, line {node.lineno}: import it from where it is made"


def test_import_is_light():
    code = "import sys; before = set(sys.modules); import stiction; print(*(set(sys.modules) - before))"
    loaded = {name.split(".")[0] for name in subprocess.check_output([sys.executable, "-c", code], text=True).split()}
    others = {name for name in loaded - set(sys.stdlib_module_names) if not name.startswith("_")}
    assert others - {"stiction"} <= LOADED
