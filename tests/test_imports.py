"""Which part of the package may know which: a value goes from surfaces to the command, and nothing points back."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest
import stiction
import typer
from stiction.cli import application

PACKAGE = Path(stiction.__file__).parent
ROOMS = ("surfaces", "mechanics", "studies", "views", "app", "cli")
"""Each may import from itself and from those before it."""

LOADED = {
    "numpy",
    "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection",
}  # fmt: skip
"""What all of its public names load of others; plots, files and clusters would take seconds."""

LOADED_BY_HELP = {"typer", "click", "shellingham", "annotated_doc", "typing_extensions"}
"""What `stiction --help` loads: no numbers, so that it answers at once."""

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


def loaded_of_others(code):
    code = f"import sys; before = set(sys.modules); {code}; print(*(set(sys.modules) - before))"
    said = subprocess.check_output([sys.executable, "-c", code], text=True).splitlines()[-1]
    loaded = {name.split(".")[0] for name in said.split()}
    return {name for name in loaded - set(sys.stdlib_module_names) - {"stiction"} if not name.startswith("_")}


def test_import_is_light():
    assert loaded_of_others("import stiction") == set()
    assert loaded_of_others("from stiction import *") <= LOADED


def test_a_command_can_be_interrupted_at_once():
    """Whatever the package imports by itself comes before the command that answers Ctrl-C without a traceback."""
    body = ast.parse(Path(stiction.__file__).read_text("utf-8")).body
    assert not [node for node in body if isinstance(node, (ast.Import, ast.ImportFrom))]


def test_help_and_version_load_none_of_what_computes():
    for option in ("--help", "--version"):
        assert loaded_of_others(
            f"sys.argv[1:] = ['{option}']; from stiction.cli.application import start; start()"
        ) <= (LOADED_BY_HELP)


def test_listing_studies_loads_no_tables_pictures_or_files():
    code = "sys.argv[1:] = ['studies']; from stiction.cli.application import start; start()"
    assert loaded_of_others(code) <= LOADED | LOADED_BY_HELP


def test_each_public_name_is_taken_from_where_it_is_made():
    """Not from where it is imported to: type checkers and Python read the same list."""
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text("utf-8"))
    for name, module in {name.asname: node.module for node in tree.body for name in node.names}.items():
        assert name in stiction.__all__
        assert name == "__version__" or getattr(stiction, name).__module__ == module


@pytest.mark.parametrize("room", ["app", "cli"])
def test_no_public_name_and_nothing_that_it_needs_is_of_a_command(room):
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text("utf-8"))
    assert [node.module for node in tree.body if node.module.startswith(f"stiction.{room}")] == []


def test_help_lists_every_command_with_the_module_that_adds_it():
    group = typer.main.get_command(application.app)
    listed = {name: module for each in application.COMMANDS.values() for name, (module, _) in each.items()}
    assert group.list_commands(None) == list(listed)
    for name, module in listed.items():
        command = group.get_command(None, name)
        assert command.name == name
        assert command.callback.__module__ == f"stiction.cli.{module}"
    assert group.get_command(None, "juggle") is None


@pytest.mark.parametrize("folder", ["python", "tests", "benchmarks", "docs", "examples"])
def test_docstrings_stand_alone(folder):
    """Each is read without the line above it."""
    paths = sorted((Path(__file__).parent.parent / folder).rglob("*.py"))
    assert [path for path in paths if re.search(r'^ *"""Of ', path.read_text("utf-8"), re.MULTILINE)] == []
