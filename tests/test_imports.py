"""Tests of imports: each layer imports from lower layers only, and imports are lazy."""

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

SHOWS_ITSELF = "studies/result.py"
"""The one module with methods that import views: a result draws its figures and writes its report."""

LOADED = {
    "numpy",
    "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection",
}  # fmt: skip
"""What all of its public names load of others; plots, files and clusters would take seconds."""

LOADED_BY_HELP = {"typer", "click", "shellingham", "annotated_doc", "typing_extensions"}
"""What `stiction --help` loads: no numbers, so that it answers at once."""


def imported(source):
    """Yield the full names that a module imports from the package, also inside functions."""
    for node in ast.walk(ast.parse((PACKAGE / source).read_text("utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [name.name for name in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{source} does not say from where it imports {node.module}"
            # What the package re-exports is there when all of it is imported: too late for its own modules.
            assert node.module != "stiction", f"{source}, line {node.lineno}: import it from where it is made"
            names = [f"{node.module}.{name.name}" for name in node.names]
        assert "stiction" not in names
        yield from (name for name in names if name.split(".")[0] == "stiction")


@pytest.mark.parametrize("room", ["", *ROOMS])
def test_layers_import_only_from_lower_layers(room):
    """Modules that serve all layers import from none."""
    paths = (PACKAGE / room).rglob("*.py") if room else PACKAGE.glob("_*.py")
    allowed = ROOMS[: ROOMS.index(room) + 1] if room else ()
    for source in sorted(path.relative_to(PACKAGE) for path in paths):
        for name in imported(source):
            known = name.split(".")[1]
            if source.as_posix() == SHOWS_ITSELF and known == "views":
                continue
            assert known.startswith("_") or known in allowed or source.name == "__main__.py", f"{source}: {name}"


COMPUTED = ("studies.store", "studies.intervals", "studies.runner", "studies.complete")
"""Modules that read stored results, compute statistics or solve: a view takes what `Result` and `Summary` have."""

STILL_COMPUTED = {"views/report/result.py": "studies.intervals", "views/pair.py": "studies.complete"}
"""Exceptions: a report with statistics of its own, and `stiction.pair`, which is no view."""


def test_views_import_no_store_and_no_statistics():
    for source in sorted(path.relative_to(PACKAGE) for path in (PACKAGE / "views").rglob("*.py")):
        for name in imported(source):
            module = name.removeprefix("stiction.")
            if STILL_COMPUTED.get(source.as_posix(), "nothing") not in module:
                assert not module.startswith(COMPUTED), f"{source}: {name}"


def loaded_of_others(code):
    code = f"import sys; before = set(sys.modules); {code}; print(*(set(sys.modules) - before))"
    message = subprocess.check_output([sys.executable, "-c", code], text=True).splitlines()[-1]
    loaded = {name.split(".")[0] for name in message.split()}
    return {name for name in loaded - set(sys.stdlib_module_names) - {"stiction"} if not name.startswith("_")}


def test_import_loads_no_dependencies():
    assert loaded_of_others("import stiction") == set()
    assert loaded_of_others("from stiction import *") <= LOADED


def test_package_imports_nothing_before_the_command():
    """Imports of the package would run before the command can handle Ctrl-C."""
    body = ast.parse(Path(stiction.__file__).read_text("utf-8")).body
    assert not [node for node in body if isinstance(node, (ast.Import, ast.ImportFrom))]


def test_help_and_version_load_no_numeric_packages():
    for option in ("--help", "--version"):
        assert loaded_of_others(
            f"sys.argv[1:] = ['{option}']; from stiction.cli.application import run_command_line; run_command_line()"
        ) <= (LOADED_BY_HELP)


def test_studies_command_loads_no_tables_figures_or_readers():
    code = "sys.argv[1:] = ['studies']; from stiction.cli.application import run_command_line; run_command_line()"
    assert loaded_of_others(code) <= LOADED | LOADED_BY_HELP


def test_stub_lists_each_public_name_with_the_module_that_package_imports():
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text("utf-8"))
    assert {name.name: node.module for node in tree.body for name in node.names} == stiction._MODULES


def test_public_names_are_imported_from_their_modules():
    """The stub names the defining module: type checkers and Python read the same list."""
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text("utf-8"))
    for name, module in {name.asname: node.module for node in tree.body for name in node.names}.items():
        assert name in stiction.__all__
        assert name == "__version__" or getattr(stiction, name).__module__ == module


@pytest.mark.parametrize("room", ["app", "cli"])
def test_public_names_are_not_in_command_layers(room):
    tree = ast.parse((PACKAGE / "__init__.pyi").read_text("utf-8"))
    assert [node.module for node in tree.body if node.module.startswith(f"stiction.{room}")] == []


def test_help_lists_every_command_with_its_module():
    group = typer.main.get_command(application.app)
    listed = {name: module for value in application.COMMANDS.values() for name, (module, _) in value.items()}
    assert group.list_commands(None) == list(listed)
    for name, module in listed.items():
        command = group.get_command(None, name)
        assert command.name == name
        assert command.callback.__module__ == f"stiction.cli.{module}"
    assert group.get_command(None, "juggle") is None


@pytest.mark.parametrize("folder", ["python", "tests", "benchmarks", "docs", "examples"])
def test_docstrings_do_not_begin_with_of(folder):
    """A docstring is read without the line above it."""
    paths = sorted((Path(__file__).parent.parent / folder).rglob("*.py"))
    assert [path for path in paths if re.search(r'^ *"""Of ', path.read_text("utf-8"), re.MULTILINE)] == []
