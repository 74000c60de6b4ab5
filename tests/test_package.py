import dataclasses
import inspect
import re
import tomllib
from pathlib import Path

import numpy as np
import pytest
import stiction
from stiction import ContactModel, _core
from support.threads import releases_interpreter_lock

ROOT = Path(__file__).parents[1]


def test_version_is_the_same_in_all_files():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    assert stiction.__version__ == _core.__version__ == project["version"]
    release = project["version"].removesuffix(".dev0")
    assert f"## {release} (" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"version: {release}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_public_names_of_the_package_are_sorted_and_exist():
    assert stiction.__all__ == sorted(stiction.__all__)
    assert all(hasattr(stiction, name) for name in stiction.__all__)


PUBLIC_FUNCTION_NAMES = [
    name for name in stiction.__all__ if inspect.isfunction(inspect.unwrap(getattr(stiction, name)))
]
"""Public functions."""


def parse_sections(docstring):
    """Return the numpydoc sections of a docstring by title."""
    _, *parts = re.split(r"^(\w[\w ]*)\n-+$", docstring, flags=re.MULTILINE)
    return dict(zip(parts[::2], parts[1::2], strict=True))


@pytest.mark.parametrize("name", PUBLIC_FUNCTION_NAMES)
def test_docstring_of_a_public_function_has_all_sections(name):
    function = getattr(stiction, name)
    sections = parse_sections(inspect.getdoc(function))
    entries = re.findall(r"^(\S.*?)(?: : .*)?$", sections.get("Parameters", ""), re.MULTILINE)
    documented_names = {item.strip() for entry in entries for item in entry.split(",")}
    if "**contact" in documented_names:
        documented_names |= {"model", *(field.name for field in dataclasses.fields(ContactModel))}
    signature = inspect.signature(function)
    assert set(signature.parameters) - documented_names == set()
    assert ("Returns" in sections) == (signature.return_annotation != "None")
    assert ">>>" in sections["Examples"]


def test_core_functions_reject_arrays_with_wrong_dtypes():
    heights = np.zeros(8)
    options = {"spacing": 1.0, "approaches": np.array([0.1]), "model": ContactModel().core()}
    _core.press(heights, heights, **options)
    for invalid_heights in (heights.tolist(), heights.astype(np.float32), np.zeros(16)[::2]):
        with pytest.raises(TypeError, match="incompatible function arguments"):
            _core.press(invalid_heights, heights, **options)


def test_profile_generation_releases_the_interpreter_lock():
    phases = stiction.random_phases(1)
    assert releases_interpreter_lock(lambda: stiction.weierstrass_mandelbrot(phases, 1.5, points=100_000))
