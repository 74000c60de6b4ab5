"""Tests of imports: each layer imports from lower layers only, and imports are lazy."""

import ast
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import stiction
import typer
from stiction.cli import application

PACKAGE_FOLDER = Path(stiction.__file__).parent
LAYERS = ("surfaces", "mechanics", "studies", "views", "app", "cli")
"""Layers from low to high. Each layer may import from itself and from lower layers."""

MODULE_IMPORTING_VIEWS = "studies/result.py"
"""Module in a layer below the views; its methods may import views, because a result draws figures and reports."""

ALLOWED_DEPENDENCIES = {
    "numpy",
    "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection",
}  # fmt: skip
"""Dependencies that an import of all public names loads; packages for plots, files and clusters must be absent."""

DEPENDENCIES_OF_HELP = {"typer", "click", "shellingham", "annotated_doc", "typing_extensions"}
"""Dependencies that `stiction --help` imports. Numeric packages must not be among them."""


def imported_names(source):
    """Yield the full names that a module imports from the package, also inside functions."""
    for node in ast.walk(ast.parse((PACKAGE_FOLDER / source).read_text("utf-8"))):
        names = []
        if isinstance(node, ast.Import):
            names = [name.name for name in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{source} imports {node.module} relatively; write the full name"
            # The package defines its public names last, which is too late for imports of its own modules.
            assert node.module != "stiction", (
                f"{source}, line {node.lineno}: import names from the module that defines them"
            )
            names = [f"{node.module}.{name.name}" for name in node.names]
        assert "stiction" not in names
        yield from (name for name in names if name.split(".")[0] == "stiction")


@pytest.mark.parametrize("layer", ["", *LAYERS])
def test_layers_import_only_from_lower_layers(layer):
    """Check also that modules which all layers use do not import from any layer."""
    paths = (PACKAGE_FOLDER / layer).rglob("*.py") if layer else PACKAGE_FOLDER.glob("_*.py")
    allowed_layers = LAYERS[: LAYERS.index(layer) + 1] if layer else ()
    for source in sorted(path.relative_to(PACKAGE_FOLDER) for path in paths):
        for name in imported_names(source):
            imported_layer = name.split(".")[1]
            if source.as_posix() == MODULE_IMPORTING_VIEWS and imported_layer == "views":
                continue
            assert imported_layer.startswith("_") or imported_layer in allowed_layers or source.name == "__main__.py", (
                f"{source}: {name}"
            )


MODULES_RESTRICTED_FOR_VIEWS = {
    "at_load", "budget", "contact_forces", "contact_picture", "ensemble_means", "height_scale", "intervals",
    "junction_growth", "maps", "member_means", "member_solution", "member_values", "members", "nodes", "onset",
    "pipeline", "runner", "store",
}  # fmt: skip
"""Modules of studies that read stored results and files, evaluate results, compute statistics or solve contacts.

Views use `Result` and `Summary` instead, and import only constants from these modules.
"""

ALLOWED_IMPORTS_OF_VIEWS = {
    "height_scale.ScaledBodies", "nodes.NodeAxis", "onset.OnsetValues",
}  # fmt: skip
"""Types that views may import from these modules."""


def test_views_import_neither_stores_nor_readers_nor_statistics():
    modules = {path.stem for path in (PACKAGE_FOLDER / "studies").glob("*.py")}
    assert modules >= MODULES_RESTRICTED_FOR_VIEWS
    for source in sorted(path.relative_to(PACKAGE_FOLDER) for path in (PACKAGE_FOLDER / "views").rglob("*.py")):
        if source.as_posix() == "views/pair.py":  # The module of `stiction.pair` is not a view.
            continue
        for name in imported_names(source):
            *layers, module, imported = name.split(".")
            if layers == ["stiction", "studies"] and module in MODULES_RESTRICTED_FOR_VIEWS:
                assert imported.isupper() or f"{module}.{imported}" in ALLOWED_IMPORTS_OF_VIEWS, f"{source}: {name}"


def loaded_dependencies(code):
    code = f"import sys; before = set(sys.modules); {code}; print(*(set(sys.modules) - before))"
    message = subprocess.check_output([sys.executable, "-c", code], text=True).splitlines()[-1]
    loaded = {name.split(".")[0] for name in message.split()}
    return {name for name in loaded - set(sys.stdlib_module_names) - {"stiction"} if not name.startswith("_")}


def test_importing_the_package_loads_no_dependencies():
    assert loaded_dependencies("import stiction") == set()
    assert loaded_dependencies("from stiction import *") <= ALLOWED_DEPENDENCIES


def test_command_line_module_imports_nothing_before_the_command_starts():
    """Check this because importing anything before the command starts would delay its handling of Ctrl-C."""
    body = ast.parse(Path(stiction.__file__).read_text("utf-8")).body
    assert not [node for node in body if isinstance(node, (ast.Import, ast.ImportFrom))]


def test_options_help_and_version_load_no_numeric_packages():
    for option in ("--help", "--version"):
        assert loaded_dependencies(
            f"sys.argv[1:] = ['{option}']; from stiction.cli.application import run_command_line; run_command_line()"
        ) <= (DEPENDENCIES_OF_HELP)


def test_studies_command_loads_no_modules_for_tables_or_figures_or_readers():
    code = "sys.argv[1:] = ['studies']; from stiction.cli.application import run_command_line; run_command_line()"
    assert loaded_dependencies(code) <= ALLOWED_DEPENDENCIES | DEPENDENCIES_OF_HELP


def test_module_for_exported_files_loads_no_matplotlib():
    assert "matplotlib" not in loaded_dependencies("import stiction.views.files")


def test_style_sheet_of_the_app_loads_neither_matplotlib_nor_pandas():
    """Check this because the page of the app is not drawn until its style sheet has arrived."""
    code = (
        "import asyncio, pathlib, starlette.requests, stiction.app.server; "
        "server = stiction.app.server.Server(pathlib.Path(), pathlib.Path(), 0); "
        "request = starlette.requests.Request({'type': 'http', 'path_params': {'kind': 'css'}}); "
        "assert asyncio.run(server.get_asset(request)).body"
    )
    assert not {"matplotlib", "pandas"} & loaded_dependencies(code)


def test_preview_of_a_scan_loads_neither_matplotlib_nor_pydantic(tmp_path):
    """Check this because the import of these packages would take longer than the preview of a small map."""
    np.save(tmp_path / "map.npy", np.random.default_rng(1).standard_normal((16, 16)))
    options = {"unit": "um", "spacing": "1 um"}
    code = (
        "from stiction.app.preview import preview_scan; "
        f"assert 'Sq' in preview_scan({str(tmp_path / 'map.npy')!r}, {options})"
    )
    assert not {"matplotlib", "pydantic"} & loaded_dependencies(code)


def test_stub_of_the_package_lists_public_names_with_their_modules():
    tree = ast.parse((PACKAGE_FOLDER / "__init__.pyi").read_text("utf-8"))
    assert {name.name: node.module for node in tree.body for name in node.names} == stiction._MODULES_BY_PUBLIC_NAME


def test_public_names_are_imported_from_their_defining_modules():
    """Check that the stub of the package names the defining module of each public name."""
    tree = ast.parse((PACKAGE_FOLDER / "__init__.pyi").read_text("utf-8"))
    for name, module in {name.asname: node.module for node in tree.body for name in node.names}.items():
        assert name in stiction.__all__
        assert name == "__version__" or getattr(stiction, name).__module__ == module


@pytest.mark.parametrize("layer", ["app", "cli"])
def test_public_names_are_not_defined_in_command_line_and_app_layers(layer):
    tree = ast.parse((PACKAGE_FOLDER / "__init__.pyi").read_text("utf-8"))
    assert [node.module for node in tree.body if node.module.startswith(f"stiction.{layer}")] == []


def test_command_group_lists_every_command_and_finds_its_module():
    group = typer.main.get_command(application.app)
    modules_by_command = {
        name: module for value in application.COMMANDS_BY_GROUP.values() for name, (module, _) in value.items()
    }
    assert group.list_commands(None) == list(modules_by_command)
    for name, module in modules_by_command.items():
        command = group.get_command(None, name)
        assert command.name == name
        assert command.callback.__module__ == f"stiction.cli.{module}"
    assert group.get_command(None, "juggle") is None


@pytest.mark.parametrize("folder", ["python", "tests", "benchmarks", "docs", "examples"])
def test_docstrings_do_not_begin_like_a_continuation_of_the_line_above(folder):
    """Check this because a docstring must be understandable without the line above it."""
    paths = sorted((Path(__file__).parent.parent / folder).rglob("*.py"))
    assert [path for path in paths if re.search(r'^ *"""Of ', path.read_text("utf-8"), re.MULTILINE)] == []
