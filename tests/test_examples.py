"""What the documents and docstrings show runs as it stands."""

import doctest
import importlib
import pkgutil
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import stiction

ROOT = Path(__file__).parents[1]
MODULES = [
    module.name for module in pkgutil.walk_packages(stiction.__path__, "stiction.") if "__main__" not in module.name
]


@pytest.mark.parametrize("name", MODULES)
def test_docstring_examples(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


@pytest.mark.parametrize("path", sorted((ROOT / "examples").glob("*.py")), ids=lambda path: path.name)
def test_example_scripts(path, tmp_path):
    done = subprocess.run(
        [sys.executable, path], cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout


def blocks(document, language):
    return re.findall(rf"```{language}\n(.*?)```", (ROOT / document).read_text(encoding="utf-8"), re.DOTALL)


@pytest.mark.parametrize("code", blocks("docs/measured.md", "python"))
def test_python_of_the_page_on_measured_surfaces(code, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "measured.md", "exec"), {})
    assert "turned over" in capsys.readouterr().out


def test_table_and_commands_of_the_page_on_measured_surfaces(tmp_path):
    example = [sys.executable, ROOT / "examples/characterise_profile.py"]
    said = subprocess.run(example, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=True).stdout
    assert blocks("docs/measured.md", "text") == [said]
    for side in ("upper", "lower"):
        scan = stiction.self_affine(1, hurst_exponent=0.8, rms=0.1, points=4000, spacing=0.05, side=side)
        stiction.write_profile(scan, tmp_path / f"{side}.csv")
    np.save(tmp_path / "map.npy", np.random.default_rng(1).normal(size=(30, 60)))
    commands = [line.split(" #")[0] for block in blocks("docs/measured.md", "sh") for line in block.splitlines()]
    for command in commands:
        shell = command.replace("stiction ", f"{sys.executable} -m stiction ", 1)
        done = subprocess.run(shell, shell=True, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, (command, done.stderr)
    assert {"lapped.png", "curved.png", "map.png"} <= {path.name for path in tmp_path.iterdir()}


@pytest.mark.parametrize("code", blocks("README.md", "python"))
def test_python_of_the_readme(code, capsys):
    exec(compile(code, "README.md", "exec"), {})
    assert capsys.readouterr().out


def test_commands_of_the_readme(tmp_path):
    """Every stiction command, made small."""
    small = "--set surfaces.points=4000 --set 'surfaces.extent=2 um'"
    run = f"{small} --set 'surfaces.fractal_dimension=[1.1, 1.4]' --set ensemble.repetitions=2"
    lines = [line.split(" #")[0].strip() for block in blocks("README.md", "sh") for line in block.splitlines()]
    commands = [line for line in lines if line.startswith("stiction ")]
    assert len(commands) >= 5
    for command in commands:
        shell = command.replace("stiction ", f"{sys.executable} -m stiction ", 1)
        if " run " in shell:
            shell = (
                shell.replace(" --set ensemble.repetitions=10", "").replace("--cluster 8", "--cluster 2") + f" {run}"
            )
        if shell.endswith(" claims"):
            shell += f" {small} --set ensemble.repetitions=20"
        done = subprocess.run(shell, shell=True, cwd=tmp_path, capture_output=True, text=True, timeout=120, check=False)
        assert done.returncode == 0, (command, done.stderr)
