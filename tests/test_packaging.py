"""Test that packaging files agree with each other and with the sources."""

import importlib.util
import os
import platform
import re
import sys
import sysconfig
import tomllib
from pathlib import Path

import numpy as np
import pytest
import stiction._core
from stiction import read_profile, read_surface

ROOT = Path(__file__).parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
SAMPLE_SCANS_DIRECTORY = ROOT / "examples/scans"


def load_script(path, monkeypatch):
    """Return a script that lies outside of the package as a module."""
    monkeypatch.syspath_prepend(str(path.parent))
    for name in ("prove", "wheel", "release"):
        monkeypatch.delitem(sys.modules, name, raising=False)
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def release_script(monkeypatch):
    return load_script(ROOT / "packaging/release.py", monkeypatch)


@pytest.fixture
def dev_script(tmp_path):
    """Return a copy of the script `dev` as a module, so that its virtual environment is in a temporary directory."""
    (tmp_path / "cpp").mkdir()
    (tmp_path / "dev.py").write_text(read_file("dev"), encoding="utf-8")
    spec = importlib.util.spec_from_file_location("dev", tmp_path / "dev.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def read_file(name):
    if not (ROOT / name).exists():
        pytest.skip(f"{name} is not in this tree")
    return (ROOT / name).read_text(encoding="utf-8")


def test_supported_python_versions_agree_in_all_files():
    matches = [re.search(r":: 3\.(\d+)$", item) for item in PYPROJECT["project"]["classifiers"]]
    minor_versions = [int(item[1]) for item in matches if item]
    assert PYPROJECT["project"]["requires-python"] == f">=3.{minor_versions[0]}"
    assert minor_versions == list(range(minor_versions[0], minor_versions[-1] + 1))
    assert PYPROJECT["tool"]["cibuildwheel"]["build"].split() == [f"cp3{minor}-*" for minor in minor_versions]
    listed_versions = re.search(r"^        python: (\[.*\])$", read_file(".github/workflows/tests.yml"), re.MULTILINE)
    assert listed_versions[1] == str([f"3.{minor}" for minor in minor_versions]).replace("'", '"')


def test_pre_commit_hooks_have_the_versions_of_the_lint_tools():
    pinned_versions = dict(item.split("==") for item in PYPROJECT["dependency-groups"]["lint"])
    revisions = re.findall(
        r"repo: \S+/(?:mirrors-)?([\w-]+?)(?:-pre-commit)?\n    rev: v(\S+)", read_file(".pre-commit-config.yaml")
    )
    assert len(revisions) == 2
    assert all(pinned_versions[name] == revision for name, revision in revisions)


def test_conda_recipe_has_the_dependencies_of_the_package(release_script, monkeypatch):
    assert list(release_script.missing_recipe_lines()) == []
    monkeypatch.setitem(
        release_script.PROJECT_METADATA, "dependencies", [*release_script.PROJECT_METADATA["dependencies"], "numpy>=99"]
    )
    assert list(release_script.missing_recipe_lines()) == ["- numpy >=99"]


def test_documented_glibc_version_equals_the_version_that_the_wheel_check_accepts(release_script):
    major, minor = sys.modules["prove"].MAX_GLIBC
    assert f"glibc {major}.{minor} or newer" in read_file("docs/howto/installing.md")


@pytest.mark.parametrize(
    ("name", "passes"),
    [
        ("manylinux_2_28_x86_64", True),
        ("manylinux_2_34_x86_64", True),
        ("manylinux_2_26_x86_64.manylinux_2_28_x86_64", True),
        ("manylinux_2_35_x86_64", False),
        ("linux_x86_64", False),
    ],
)
def test_wheel_that_requires_a_newer_glibc_is_rejected(release_script, name, passes, capsys):
    wheel = Path(f"stiction-0.1.0-cp311-cp311-{name}.whl")
    if passes:
        sys.modules["prove"].check_min_glibc(wheel)
        return
    with pytest.raises(SystemExit):
        sys.modules["prove"].check_min_glibc(wheel)
    assert name in capsys.readouterr().err


@pytest.mark.skipif(
    platform.libc_ver()[0] != "glibc" or tuple(map(int, platform.libc_ver()[1].split("."))) > (2, 36),
    reason="compilers of systems newer than Debian 12 use newer symbols, and build no wheels for older systems",
)
def test_core_extension_requires_no_symbols_that_the_oldest_supported_systems_lack(release_script):
    core = Path(stiction._core.__file__)
    assert b"GLIBCXX_3.4\0" in core.read_bytes()
    # The assertions of the standard library call a function of GCC 12. Wheels are built without assertions.
    allowed_versions = {"GLIBCXX_3.4.30"} if os.environ.get("STICTION_ASSERTIONS") == "ON" else set()
    assert set(sys.modules["prove"].find_newer_symbol_versions(core)) <= allowed_versions


def test_core_extension_contains_assertions_only_if_the_build_enables_them():
    contains_assertions = b"__assert_fail" in Path(stiction._core.__file__).read_bytes()
    assert contains_assertions == (os.environ.get("STICTION_ASSERTIONS") == "ON")


def test_symbol_check_lists_symbol_versions_above_the_supported_versions(release_script, tmp_path):
    extension = tmp_path / "core.so"
    extension.write_bytes(b"\0GLIBC_2.34\0GLIBCXX_3.4.30\0GLIBCXX_3.4.9\0CXXABI_1.3.14\0GLIBC_2.4\0GLIBC_2.100\0")
    assert sys.modules["prove"].find_newer_symbol_versions(extension) == [
        "CXXABI_1.3.14", "GLIBCXX_3.4.30", "GLIBC_2.100",
    ]  # fmt: skip


def test_release_checks_report_missing_dates_and_versions(release_script, tmp_path, monkeypatch):
    (tmp_path / "CHANGELOG.md").write_text("## 1.2.3 (unreleased)\n", encoding="utf-8")
    monkeypatch.setattr(release_script, "ROOT", tmp_path)
    monkeypatch.setattr(release_script, "RELEASE_VERSION", "1.2.3")
    assert "## 1.2.3 (unreleased) should read" in release_script.changelog_date_problem()
    (tmp_path / "CHANGELOG.md").write_text("## 1.2.3 (2030-01-02)\n", encoding="utf-8")
    assert release_script.changelog_date_problem() is None
    (tmp_path / "CITATION.cff").write_text("version: 1.2.3\ndate-released: 2030-01-01\n", encoding="utf-8")
    assert release_script.citation_problem() == "CITATION.cff has no date-released: 2030-01-02, repository-code: http"
    monkeypatch.setattr(release_script, "VERSION", "1.2.3.dev0")
    assert release_script.version_problem() == "pyproject.toml says 1.2.3.dev0"


def test_release_script_writes_the_repository_address_into_all_files(release_script, tmp_path, monkeypatch):
    monkeypatch.setattr(release_script, "ROOT", tmp_path)
    files = {
        "pyproject.toml": '[project]\nname = "a"\n\n[project.urls]\nPaper = "https://doi.org/1"\n\n[tool]\n',
        "CITATION.cff": "type: software\nversion: 1.2.3\n",
        "README.md": "![A](docs/a.png) [B](docs/b.md#c) [D](https://example.org) [E](#e)\n",
    }
    for name, content in files.items():
        (tmp_path / name).write_text(content, encoding="utf-8")
    with pytest.raises(SystemExit):
        release_script.write_repository_address("example.org/stiction")
    release_script.write_repository_address("https://example.org/them/stiction")
    urls = tomllib.loads((tmp_path / "pyproject.toml").read_text(encoding="utf-8"))["project"]["urls"]
    assert set(urls) == {"Paper", *release_script.PROJECT_URL_NAMES}
    assert "repository-code: https://example.org/them/stiction\n" in (tmp_path / "CITATION.cff").read_text(
        encoding="utf-8"
    )
    root = "https://example.org/them/stiction"
    assert (tmp_path / "README.md").read_text(encoding="utf-8") == (
        f"![A]({root}/raw/main/docs/a.png) [B]({root}/blob/main/docs/b.md#c) [D](https://example.org) [E](#e)\n"
    )
    assert release_script.readme_link_problem() is None


# ---- The sample scans -----------------------------------------------------------------------------------------------

MAX_HEIGHT_DIFFERENCE_IN_STEPS = 1.0
"""Largest difference of a height in converter steps. Processors may round the last bit differently."""


def test_sample_scans_equal_the_output_of_their_script(tmp_path, monkeypatch):
    make_script = load_script(SAMPLE_SCANS_DIRECTORY / "make.py", monkeypatch)
    make_script.main(tmp_path)
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(
        path.name for path in SAMPLE_SCANS_DIRECTORY.iterdir() if path.suffix in (".csv", ".x3p")
    )
    for name, read_scan, converter_step in (
        ("lapped_{}.csv", read_profile, 1e-4), ("honed_{}.csv", read_profile, 1e-5),
        ("ground_{}.x3p", read_surface, 5e-5),
    ):  # fmt: skip
        for side in make_script.SIDES:
            stored_scan, created_scan = (
                read_scan(directory / name.format(side)) for directory in (SAMPLE_SCANS_DIRECTORY, tmp_path)
            )
            assert stored_scan.spacing == created_scan.spacing
            np.testing.assert_allclose(
                stored_scan.heights,
                created_scan.heights,
                rtol=0,
                atol=1.01 * MAX_HEIGHT_DIFFERENCE_IN_STEPS * converter_step,
            )


@pytest.mark.parametrize(("version", "is_running_version"), [("3.11.1", True), ("3.11.10", False), ("3.12.1", False)])
def test_virtual_environment_is_reused_only_by_the_python_version_that_created_it(
    dev_script, monkeypatch, version, is_running_version
):
    dev_script.VENV_BIN.mkdir(parents=True)
    (dev_script.VENV_BIN / "pip").touch()
    (dev_script.VENV / "pyvenv.cfg").write_text(f"home = /usr/bin\nversion = {version}\n", encoding="utf-8")
    monkeypatch.setattr(sys, "version_info", (3, 11, 1, "final", 0))
    assert dev_script.venv_has_running_python() == is_running_version


@pytest.mark.parametrize(
    ("running_version", "is_optimized", "distribution_version", "continues"),
    [
        ((3, 11), False, (3, 11), True),
        ((3, 11), True, (3, 11), False),
        ((3, 12), False, (3, 11), False),
        ((3, 9), True, (3, 11), True),
        ((3, 9), True, (3, 10), False),
    ],
)
def test_dev_script_restarts_itself_once_if_the_python_of_the_linux_distribution_is_faster_or_required(
    dev_script, tmp_path, monkeypatch, running_version, is_optimized, distribution_version, continues
):
    distribution_python = tmp_path / "python3"
    distribution_python.write_text(
        f"#!{sys.executable}\nimport sys, sysconfig\nsys.version_info = {distribution_version}\n"
        f"sysconfig.get_path = lambda name: {str(tmp_path)!r}\nexec(sys.argv[2])\n"
    )
    distribution_python.chmod(0o755)
    (tmp_path / "Python.h").touch()
    calls = []
    monkeypatch.setattr(dev_script, "DISTRIBUTION_PYTHON", str(distribution_python))
    monkeypatch.setattr(sys, "version_info", running_version)
    monkeypatch.setattr(sys, "base_prefix", "/opt/python")
    monkeypatch.setattr(sysconfig, "get_config_var", lambda name: "--enable-optimizations" * is_optimized)
    monkeypatch.setattr(sysconfig, "get_path", lambda name: str(tmp_path))
    monkeypatch.setattr(os, "execv", lambda path, arguments: calls.append(path))
    monkeypatch.setenv(dev_script.CONTINUED_VARIABLE, "")
    for _ in range(2):  # The second call is in the process that continues.
        dev_script.prefer_distribution_python()
    assert calls == [str(distribution_python)] * continues
