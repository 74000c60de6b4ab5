"""Tests of imports: each layer imports from lower layers only, and imports are lazy."""

import ast
import functools
import json
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import stiction
import typer
from stiction.cli import application
from support.sources import parse_file

PACKAGE_DIRECTORY = Path(stiction.__file__).parent
FACADE_MODULES = ("result", "pipeline", "measured_pair", "direct_shear")
"""Modules that users hold. They may import all layers except the user interfaces, and no layer imports them."""

LAYERS = (
    "surfaces", "mechanics", "study", "solve", "evaluate", "companions", "calibration", "summary", "views", "facade",
    "app", "cli",
)  # fmt: skip
"""Layers from low to high. Each layer may import from itself and from lower layers only."""

SLOW_PACKAGES = {"matplotlib", "PIL", "starlette", "uvicorn"}
"""Third-party packages that load slowly. Only modules that need one of them may be imported inside functions."""

ALLOWED_DEPENDENCIES = {
    "numpy",
    "pydantic", "pydantic_core", "annotated_types", "typing_extensions", "typing_inspection",
}  # fmt: skip
"""Third-party packages that an import of all public names may load. Those for plots, files and clusters are absent."""

DEPENDENCIES_IMPORTED_BY_HELP = {"typer", "click", "shellingham", "annotated_doc", "typing_extensions"}
"""Third-party packages that `stiction --help` may import, none of which is numeric."""


def list_imported_names(source):
    """Yield the full name of everything that a module imports from the package, also inside functions."""
    for node in ast.walk(parse_file(PACKAGE_DIRECTORY / source)):
        names = []
        if isinstance(node, ast.Import):
            names = [name.name for name in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{source} imports {node.module} relatively; write the full name"
            # Public names are defined after all modules are loaded, so modules cannot import them from the package.
            assert node.module != "stiction", (
                f"{source}, line {node.lineno}: import names from the module that defines them"
            )
            names = [f"{node.module}.{name.name}" for name in node.names]
        assert "stiction" not in names
        yield from (name for name in names if name.split(".")[0] == "stiction")


MODULES = {
    ".".join(path.relative_to(PACKAGE_DIRECTORY).with_suffix("").parts).removesuffix(".__init__"): path
    for path in sorted(PACKAGE_DIRECTORY.rglob("*.py"))
}
"""Files of all modules of the package, by module name."""


@functools.cache
def list_imported_modules(module, *, only_top_level=False):
    """Return the package's modules that a module imports, also inside functions and for type checkers."""
    tree = parse_file(MODULES[module])
    found = set()
    for node in tree.body if only_top_level else ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("stiction."):
            base = node.module.removeprefix("stiction.")
            found |= {name if (name := f"{base}.{alias.name}") in MODULES else base for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {
                alias.name.removeprefix("stiction.") for alias in node.names if alias.name.startswith("stiction.")
            }
    return frozenset(found & set(MODULES))


def find_layer(module):
    """Return the layer of a module, or "" for a module that all layers may use."""
    top_level_name = module.split(".")[0]
    return "facade" if top_level_name in FACADE_MODULES else "" if top_level_name.startswith("_") else top_level_name


@pytest.mark.parametrize("layer", ["", *LAYERS])
def test_layers_import_only_from_lower_layers(layer):
    """Check also that modules which all layers use do not import from any layer."""
    allowed_layers = {"", *(LAYERS[: LAYERS.index(layer) + 1] if layer else ())}
    for module in (name for name in MODULES if find_layer(name) == layer and name != "__main__"):
        for imported in list_imported_modules(module):
            assert find_layer(imported) in allowed_layers, f"{module} imports {imported}"


def test_layers_of_the_package_include_every_package_directory():
    assert {path.parent.name for path in PACKAGE_DIRECTORY.glob("*/__init__.py")} == {*LAYERS} - {"facade"}
    assert {name for name in MODULES if "." not in name and not name.startswith("_")} == {*LAYERS, *FACADE_MODULES} - {
        "facade"
    }


def find_circular_imports(imports):
    """Return the modules that import each other in a circle, found by removing modules without open imports."""
    open_imports = {name: set(imported) for name, imported in imports.items()}
    while finished_modules := {name for name, imported in open_imports.items() if not imported & set(open_imports)}:
        open_imports = {name: imported for name, imported in open_imports.items() if name not in finished_modules}
    return open_imports


def test_import_check_reports_circular_imports():
    assert set(find_circular_imports({"a": {"b"}, "b": {"c"}, "c": {"b"}, "d": set()})) == {"a", "b", "c"}


def test_package_has_no_circular_imports():
    """Count imports inside functions and for type checkers, because both tie modules to each other."""
    assert find_circular_imports({name: list_imported_modules(name) - {name} for name in MODULES}) == {}


def find_slow_modules():
    """Return the modules of the package whose import loads a slow package."""
    slow_modules = set()
    for name, path in MODULES.items():
        for node in parse_file(path).body:
            names = [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            names += [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if {module_name.split(".")[0] for module_name in names} & SLOW_PACKAGES:
                slow_modules.add(name)
    while importing_modules := {
        name for name in set(MODULES) - slow_modules if list_imported_modules(name, only_top_level=True) & slow_modules
    }:
        slow_modules |= importing_modules
    return slow_modules


def test_imports_inside_functions_are_limited_to_modules_that_are_slow_to_import():
    """Exempt `cli`: its functions import what they run, so that help texts load none of it."""
    slow_modules = find_slow_modules()
    for module, path in MODULES.items():
        if find_layer(module) == "cli":
            continue
        for function in ast.walk(parse_file(path)):
            if not isinstance(function, ast.FunctionDef):
                continue
            for node in ast.walk(function):
                if isinstance(node, ast.ImportFrom) and node.module.startswith("stiction."):
                    base = node.module.removeprefix("stiction.")
                    names = {f"{base}.{alias.name}" for alias in node.names} & set(MODULES) or {base}
                    assert names <= slow_modules, f"{module}.{function.name} imports {node.module}"


def test_modules_import_other_modules_by_their_absolute_names():
    for source in (path.relative_to(PACKAGE_DIRECTORY) for path in MODULES.values()):
        list(list_imported_names(source))


MODULES_THAT_VIEWS_MUST_NOT_CALL = {
    "companions.contact_forces", "companions.contact_picture", "companions.height_scale", "companions.onset",
    "evaluate.maps", "evaluate.member_means", "evaluate.member_values", "solve.member_solution", "solve.runner",
    "solve.store", "study.members", "summary.report_grid",
}  # fmt: skip
"""Modules from which views import constants only: modules that read files, evaluate results or solve contacts.

Views use `Evaluation` and `Summary` instead.
"""

ALLOWED_IMPORTS_OF_VIEWS = {
    "companions.height_scale.ScaledBodies", "summary.report_grid.ParameterAxis", "companions.onset.OnsetSummary",
}  # fmt: skip
"""Types that views may import from the restricted modules."""


def test_views_call_no_modules_that_read_files_or_evaluate_results_or_solve_contacts():
    assert set(MODULES) >= MODULES_THAT_VIEWS_MUST_NOT_CALL
    for source in sorted(path.relative_to(PACKAGE_DIRECTORY) for path in (PACKAGE_DIRECTORY / "views").rglob("*.py")):
        for name in list_imported_names(source):
            module, _, imported = name.removeprefix("stiction.").rpartition(".")
            if module in MODULES_THAT_VIEWS_MUST_NOT_CALL:
                assert imported.isupper() or f"{module}.{imported}" in ALLOWED_IMPORTS_OF_VIEWS, f"{source}: {name}"


def select_dependencies(modules):
    """Return the third-party packages among loaded modules."""
    packages = {name.split(".")[0] for name in modules}
    return {name for name in packages - set(sys.stdlib_module_names) - {"stiction"} if not name.startswith("_")}


def list_loaded_dependencies(code):
    """Return the third-party packages that code loads in a new process."""
    code = f"import sys; before = set(sys.modules); {code}; print(*(set(sys.modules) - before))"
    message = subprocess.check_output([sys.executable, "-c", code], text=True).splitlines()[-1]
    return select_dependencies(message.split())


def test_importing_the_package_loads_no_dependencies():
    assert list_loaded_dependencies("import stiction") == set()
    assert list_loaded_dependencies("from stiction import *") <= ALLOWED_DEPENDENCIES


def test_command_line_module_imports_nothing_before_the_command_starts():
    """Check that `stiction/__init__.py` imports nothing, because imports would delay the handling of Ctrl-C."""
    body = ast.parse(Path(stiction.__file__).read_text("utf-8")).body
    assert not [node for node in body if isinstance(node, (ast.Import, ast.ImportFrom))]


MODULES_WITH_PAIR_OPTIONS = {"pair", "shear", "characterise", "calibrate", "table"}
"""Modules of commands with options that are declared in `study.pair_options`, which needs NumPy."""

MODULE_BY_COMMAND = {
    name: module for group in application.COMMANDS_BY_GROUP.values() for name, (module, _) in group.items()
}

LISTING_SCRIPT = """
import contextlib, io, json, sys
before = set(sys.modules)
loaded = []
for code in json.loads(sys.argv[1]):
    with contextlib.redirect_stdout(io.StringIO()):
        exec(code)
    loaded.append(sorted(set(sys.modules) - before))
print(json.dumps(loaded))
"""
"""Script that runs pieces of code in succession, and prints the modules that are loaded after each piece."""


def list_dependencies_of_steps(code_by_step):
    """Return the third-party packages that are loaded after each step, when the code of all steps runs in one process.

    The step that may load the fewest packages must be the first. A package that a step loads is listed for this step
    and for all later ones, so that no step hides what another one loads.
    """
    command = [sys.executable, "-c", LISTING_SCRIPT, json.dumps(list(code_by_step.values()))]
    modules = json.loads(subprocess.check_output(command, text=True))
    return dict(zip(code_by_step, map(select_dependencies, modules), strict=True))


@pytest.fixture(scope="module")
def dependencies_by_command():
    """Third-party packages that are loaded after each command, by its arguments."""
    helps = sorted(MODULE_BY_COMMAND, key=lambda name: MODULE_BY_COMMAND[name] in MODULES_WITH_PAIR_OPTIONS)
    commands = [("--help",), ("--version",), *((name, "--help") for name in helps), ("studies",)]
    code = "from stiction.cli.application import run_command_line; sys.argv[1:] = {!r}; run_command_line()"
    return list_dependencies_of_steps({command: code.format(command) for command in commands})


@pytest.mark.parametrize("option", ["--help", "--version"])
def test_help_option_and_version_option_load_no_numeric_packages(option, dependencies_by_command):
    assert dependencies_by_command[option,] <= DEPENDENCIES_IMPORTED_BY_HELP


@pytest.mark.parametrize("command", MODULE_BY_COMMAND)
def test_help_of_a_command_loads_numpy_only_for_pair_options(command, dependencies_by_command):
    numpy_if_needed = {"numpy"} if MODULE_BY_COMMAND[command] in MODULES_WITH_PAIR_OPTIONS else set()
    allowed_dependencies = DEPENDENCIES_IMPORTED_BY_HELP | ALLOWED_DEPENDENCIES - {"numpy"} | numpy_if_needed
    assert dependencies_by_command[command, "--help"] <= allowed_dependencies


def test_studies_command_loads_no_packages_that_write_tables_or_draw_figures_or_read_scans(dependencies_by_command):
    assert dependencies_by_command["studies",] <= ALLOWED_DEPENDENCIES | DEPENDENCIES_IMPORTED_BY_HELP


def test_sampling_uncertain_inputs_does_not_load_scipy_stats():
    code = "from stiction.study.input_distributions import generate_stratified_points; generate_stratified_points(10)"
    assert "scipy" not in list_loaded_dependencies(code)


SMALL_STUDY_CHANGES = (
    "surfaces.fractal_dimension=[1.1]", "surfaces.points=1000", "surfaces.extent=1 um", "ensemble.repetitions=2",
    "contact.approach.count=3", 'figures.draw=["area"]',
)  # fmt: skip


def test_commands_load_dask_only_for_a_cluster(tmp_path):
    """Check that xarray does not import an installed Dask in local runs. The import takes longer than some studies."""
    pytest.importorskip("distributed")

    def run_small_study(*options):
        changes = [f"--set={change}" for change in SMALL_STUDY_CHANGES]
        command = [sys.executable, "-X", "importtime", "-m", "stiction", "run", "quick", *changes, *options]
        return subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False).stderr

    assert not re.search(r"\| +dask\b", run_small_study())
    assert re.search(r"\| +dask\b", message := run_small_study("--scheduler", "host"))
    assert "the address of a Dask scheduler must have the form" in message


HALF_PLANE_PAIR_CODE = """
import sys
from stiction import pair, self_affine
upper, lower = (self_affine(seed, points=400, spacing=0.1, hurst_exponent=0.8, rms=0.02) for seed in (1, 2))
options = {"load": "10 MPa", "effective_modulus": "80 GPa", "mu0": 0.2, "mechanics": "half-space"}
result = pair(upper, lower, offsets=3, onset=1, cutoff="none", **options)
assert result.onset is not None
assert not {"scipy.ndimage", "scipy.optimize"} & set(sys.modules)
"""


def test_pair_of_profiles_as_half_planes_loads_neither_scipy_ndimage_nor_scipy_optimize():
    """Check this because both imports together take 0.3 s.

    These profiles have no outliers to group, and the onset of half-planes has no displacements to fit.
    """
    subprocess.run([sys.executable, "-c", HALF_PLANE_PAIR_CODE], check=True)


STYLE_SHEET_CODE = """
import asyncio, pathlib, starlette.requests, stiction.app.server
server = stiction.app.server.Server(pathlib.Path(), pathlib.Path(), 0)
request = starlette.requests.Request({'type': 'http', 'path_params': {'kind': 'css'}})
assert asyncio.run(server.get_asset(request)).body
"""


@pytest.fixture(scope="module")
def dependencies_by_step(tmp_path_factory):
    """Third-party packages that are loaded after a preview, the style sheet of the app, and two modules of views."""
    path = tmp_path_factory.mktemp("scan") / "map.npy"
    np.save(path, np.random.default_rng(1).standard_normal((16, 16)))
    preview = f"preview_scan({str(path)!r}, {{'unit': 'um', 'spacing': '1 um'}})"
    code_by_step = {
        "preview": f"from stiction.app.preview import preview_scan; assert 'Sq' in {preview}",
        "style sheet": STYLE_SHEET_CODE,
        "files": "import stiction.views.files",
        "report": "import stiction.views.report",
    }
    return list_dependencies_of_steps(code_by_step)


@pytest.mark.parametrize("module", ["files", "report"])
def test_modules_for_exports_and_reports_do_not_load_matplotlib(module, dependencies_by_step):
    """Check reports because their numbers are evaluated in a forked process while Matplotlib is imported."""
    assert "matplotlib" not in dependencies_by_step[module]


def test_style_sheet_of_the_app_loads_neither_matplotlib_nor_pandas(dependencies_by_step):
    """Check that slow imports do not delay the style sheet, without which a browser does not draw the page."""
    assert not {"matplotlib", "pandas"} & dependencies_by_step["style sheet"]


def test_preview_of_a_scan_loads_neither_matplotlib_nor_pydantic(dependencies_by_step):
    """Check that a preview does not import two packages whose import takes longer than the preview of a small map."""
    assert not {"matplotlib", "pydantic"} & dependencies_by_step["preview"]


def test_stub_of_the_package_lists_public_names_with_their_modules():
    tree = ast.parse((PACKAGE_DIRECTORY / "__init__.pyi").read_text("utf-8"))
    assert {name.name: node.module for node in tree.body for name in node.names} == stiction._MODULES_BY_PUBLIC_NAME


def test_public_names_are_imported_from_their_defining_modules():
    """Check that the stub of the package names the defining module of each public name."""
    tree = ast.parse((PACKAGE_DIRECTORY / "__init__.pyi").read_text("utf-8"))
    for name, module in {name.asname: node.module for node in tree.body for name in node.names}.items():
        assert name in stiction.__all__
        assert name == "__version__" or getattr(stiction, name).__module__ == module


@pytest.mark.parametrize("layer", ["app", "cli"])
def test_public_names_are_not_defined_in_modules_of_the_command_line_or_the_app(layer):
    tree = ast.parse((PACKAGE_DIRECTORY / "__init__.pyi").read_text("utf-8"))
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


@pytest.mark.parametrize("directory", ["python", "tests", "benchmarks", "docs", "examples"])
def test_docstrings_never_have_of_as_their_first_word(directory):
    """Check that no docstring starts with "Of". Each must be understandable without the line above it."""
    paths = sorted((Path(__file__).parent.parent / directory).rglob("*.py"))
    assert [path for path in paths if re.search(r'^ *"""Of ', path.read_text("utf-8"), re.MULTILINE)] == []
