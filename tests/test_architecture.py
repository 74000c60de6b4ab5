"""Tests that ARCHITECTURE.md names the packages and files of the tree, and that modules say what they do."""

import ast
import re
from pathlib import Path

from support.sources import parse_file

ROOT = Path(__file__).parents[1]
PACKAGE_DIRECTORY = ROOT / "python/stiction"
ARCHITECTURE_PAGE = ROOT / "ARCHITECTURE.md"


def test_architecture_page_has_a_table_row_for_each_subpackage():
    text = ARCHITECTURE_PAGE.read_text("utf-8")
    packages = {path.parent.name for path in PACKAGE_DIRECTORY.glob("*/__init__.py")}
    package_table = re.search(r"^\| package \|.*?\n\n", text, re.DOTALL | re.MULTILINE)[0]
    rows = re.findall(r"^\| ((?:`\w+`(?:, )?)+) \| \S", package_table, re.MULTILINE)
    assert {name for row in rows for name in re.findall(r"\w+", row)} == packages


def test_architecture_page_refers_only_to_existing_files():
    text = ARCHITECTURE_PAGE.read_text("utf-8")
    names = re.findall(r"`((?:python|tests|cpp|docs|benchmarks|packaging|tools|examples)/[\w./]+)`", text)
    names += [
        f"python/stiction/{name}"
        for name in re.findall(r"`(\w+/\w+\.py)`", text)
        if (PACKAGE_DIRECTORY / name.split("/")[0]).is_dir()
    ]
    assert len(names) > 15
    assert [name for name in names if not (ROOT / name).exists()] == []


def test_modules_state_their_purpose_in_their_first_line():
    paths = [path for path in PACKAGE_DIRECTORY.rglob("*.py") if path.name != "__init__.py"]
    assert [path for path in paths if not ast.get_docstring(parse_file(path))] == []
    headers = sorted((ROOT / "cpp/include/stiction").glob("*.hpp"))
    assert [path for path in headers if not path.read_text("utf-8").startswith("// ")] == []


MODULES_WITH_THE_FRICTION_LAW = {"mechanics/friction.py", "calibration/fit.py"}
"""Modules that multiply mu0 or tau0: the friction law, and the linear equations that a calibration solves for both."""


def multiplies_mu0_or_tau0(node):
    if not (isinstance(node, ast.BinOp) and isinstance(node.op, (ast.Mult, ast.Div))):
        return False
    # Accept divisions by mu0 or tau0, which only compare a value with mu0 or tau0.
    operands = (node.left, node.right) if isinstance(node.op, ast.Mult) else (node.left,)
    names = {getattr(operand, "id", getattr(operand, "attr", None)) for operand in operands}
    is_conversion_of_units = isinstance(node.left, ast.Constant) or isinstance(node.right, ast.Constant)
    return bool({"mu0", "tau0"} & names) and not is_conversion_of_units


def test_friction_law_is_the_only_module_that_multiplies_by_mu0_and_tau0():
    sources = {path.relative_to(PACKAGE_DIRECTORY).as_posix(): path for path in PACKAGE_DIRECTORY.rglob("*.py")}
    assert {
        name
        for name, path in sources.items()
        if any(multiplies_mu0_or_tau0(node) for node in ast.walk(parse_file(path)))
    } == MODULES_WITH_THE_FRICTION_LAW


MODULES_THAT_BUILD_FRICTION_LAWS = {
    "study/inputs.py", "study/interfaces.py", "evaluate/response.py", "evaluate/combined_intervals.py",
    "evaluate/shear_intervals.py", "evaluate/maps.py", "evaluate/ensemble_means.py", "companions/contact_forces.py",
    "direct_shear.py",
}  # fmt: skip
"""Modules outside of `mechanics` and `calibration` that may build a friction law.

The law of a study comes from its inputs. The others build it from samples, for generated surfaces, or without a study.
"""


def test_friction_law_of_a_study_is_built_from_the_inputs_of_the_study():
    sources = {path.relative_to(PACKAGE_DIRECTORY).as_posix(): path for path in PACKAGE_DIRECTORY.rglob("*.py")}
    calling_modules = {
        name
        for name, path in sources.items()
        for node in ast.walk(parse_file(path))
        if isinstance(node, ast.Call) and getattr(node.func, "id", getattr(node.func, "attr", "")) == "FrictionLaw"
    }
    assert {name for name in calling_modules if not name.startswith(("mechanics/", "calibration/"))} == (
        MODULES_THAT_BUILD_FRICTION_LAWS
    )
