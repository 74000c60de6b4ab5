"""Run the examples of docstrings, pages and scripts unchanged."""

import ast
import codeop
import contextlib
import doctest
import fcntl
import functools
import importlib
import importlib.util
import io
import json
import os
import pkgutil
import re
import runpy
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tomllib
from itertools import chain
from pathlib import Path
from types import SimpleNamespace
from typing import NamedTuple, get_args

import numpy as np
import pytest
import stiction
from markdown_it import MarkdownIt
from matplotlib.testing.compare import compare_images
from stiction import Study
from stiction.solve import store
from stiction.views.study_keys import study_keys_markdown
from support.command import call_stiction, check_stiction
from support.input_samples import use_few_samples

ROOT = Path(__file__).parents[1]
MODULE_NAMES = [
    module.name for module in pkgutil.walk_packages(stiction.__path__, "stiction.") if "__main__" not in module.name
]


@pytest.mark.parametrize("name", MODULE_NAMES)
def test_docstring_examples_give_the_documented_output(name):
    assert doctest.testmod(importlib.import_module(name)).failed == 0


@pytest.fixture(scope="module")
def run_script_once(tmp_path_factory):
    """Return a function that runs a script in an empty directory, once for all tests, and returns its output."""

    @functools.cache
    def run_script(path):
        out, directory = io.StringIO(), tmp_path_factory.mktemp(path.stem)
        with use_few_samples(), contextlib.chdir(directory), contextlib.redirect_stdout(out):
            runpy.run_path(str(path), run_name="__main__")
        return out.getvalue()

    return run_script


# ---- Pages ----------------------------------------------------------------------------------------------------------

PAGE_FILES = [
    path
    for path in (ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").rglob("*.md")))
    if path.exists() and not {"generated", "built"} & set(path.parts)
]

LANGUAGES_RUN_BY_TESTS = {"python", "sh"}
LANGUAGES_RUN_BY_DOCS_BUILD = {"{code-cell} ipython3"}  # `./dev docs` runs these cells and fails if a cell fails.
LANGUAGES_WITHOUT_CODE = {
    "text",
    "{eval-rst}",
    "{figure}",
    "{image}",
    "{include}",
    "{literalinclude}",
    "{toctree}",
    "{glossary}",
}
"""Languages of blocks that are not run: output, diagrams, and included pages and files, which other tests check."""


class CodeBlock(NamedTuple):
    kind: str
    text: str


@functools.cache
def find_code_blocks(page):
    """Return all code blocks of a documentation page."""
    values = []
    for token in MarkdownIt().parse(page.read_text(encoding="utf-8")):
        if token.type == "fence":
            kind = token.info.strip()
            values.append(CodeBlock(kind if kind.startswith("{code-cell}") else kind.split(" ")[0], token.content))
        elif token.type == "code_block":
            values.append(CodeBlock("indented", token.content))
    return values


def parametrize_pages(pages):
    return pytest.mark.parametrize("page", pages, ids=lambda page: page.name)


@parametrize_pages(PAGE_FILES)
def test_documentation_page_contains_only_code_blocks_that_a_test_runs(page):
    unknown_blocks = [
        block
        for block in find_code_blocks(page)
        if block.kind not in LANGUAGES_RUN_BY_TESTS | LANGUAGES_RUN_BY_DOCS_BUILD | LANGUAGES_WITHOUT_CODE
    ]
    assert not unknown_blocks, f"no test runs these blocks of {page.name}; use python, sh or {{code-cell}} blocks"
    if any(block.kind in LANGUAGES_RUN_BY_DOCS_BUILD for block in find_code_blocks(page)):
        assert page.is_relative_to(ROOT / "docs")
        assert "file_format: mystnb" in page.read_text(encoding="utf-8").split("---")[1], (
            "without this header, the code cells of the page would be shown but not run"
        )


@parametrize_pages(PAGE_FILES)
def test_documentation_page_has_colon_fences_only_at_the_start_of_lines(page):
    lines = page.read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if ":::" in line and not line.lstrip().startswith(":::")] == []


NOTEBOOK_CELL_OPTIONS = r"\A(---\n(.*\n)*?---\n|(:.*\n)+)"
"""Pattern of the options at the start of a code cell, such as tags that hide the cell on the built page."""


def find_prompt_error(code):
    """Return the error message of the first statement that an interactive prompt rejects, or None."""
    lines = []
    for line in [*code.splitlines(), ""]:
        lines.append(line)
        try:
            is_complete = codeop.compile_command("\n".join(lines)) is not None
        except SyntaxError as error:
            return f"{error}: {line}"
        if is_complete:
            lines = []
    return None


@parametrize_pages(PAGE_FILES)
def test_python_block_of_a_page_can_be_pasted_into_an_interactive_prompt(page):
    for block in find_code_blocks(page):
        if block.kind not in {"python", *LANGUAGES_RUN_BY_DOCS_BUILD} or re.search(r"^%%\w+", block.text, re.MULTILINE):
            continue
        prompt_error = find_prompt_error(re.sub(NOTEBOOK_CELL_OPTIONS, "", block.text))
        assert prompt_error is None, f"{page.name}: {prompt_error}; put an empty line after each loop and function"


@parametrize_pages(PAGE_FILES)
def test_hidden_code_cell_starts_with_a_comment_that_only_the_html_page_needs_the_cell(page):
    for block in find_code_blocks(page):
        options = re.match(NOTEBOOK_CELL_OPTIONS, block.text)
        if block.kind in LANGUAGES_RUN_BY_DOCS_BUILD and options and re.search("remove-(cell|input)", options[0]):
            assert block.text[options.end() :].startswith("# for the built page only: ")


SMALL_STUDY_CHANGES = {
    "surfaces.fractal_dimension": [1.1, 1.4],
    "surfaces.points": 4000,
    "surfaces.extent": "2 um",
    "contact.approach.count": 6,
    "friction.mu0": [0.4],
    "ensemble.repetitions": 2,
}


PROFILE_NAMES = {"upper.csv", "lower.csv", "lapped_upper.csv", "lapped_lower.csv"}
"""Names of the scan files that contain profiles. Other files on pages may contain height maps."""
NUM_PROFILE_POSITIONS = 8


def reduce_study_size(command):
    """Return a command with a smaller study, whose number of repetitions still depends on that in the command."""
    match shlex.split(command)[1]:
        case "run" if shlex.split(command)[2] != "pair":
            changes = dict(SMALL_STUDY_CHANGES)
        case "run":
            more_positions = f"ensemble.repetitions={NUM_PROFILE_POSITIONS + 6}"
            return re.sub(r"ensemble\.repetitions=\d+", more_positions, command)
        case "pair" if {Path(word).name for word in shlex.split(command)[2:4]} <= PROFILE_NAMES:
            return f"{command} --offsets {NUM_PROFILE_POSITIONS}"
        case _:
            return command
    if options := re.search(r"ensemble\.repetitions=(\d+)", command):
        changes["ensemble.repetitions"] = max(2, int(options[1]) // 500)
    return command + "".join(f" --set {shlex.quote(f'{study_key}={value}')}" for study_key, value in changes.items())


COMMANDS_WITHOUT_DRAWINGS = {"pair", "run"}
"""Commands whose figures and reports are empty here. The build of the documentation and tests/views draw them."""


def run_command(line, cwd):
    """Run a line that calls stiction. For other commands, check that the files that they name exist."""
    line = line.split(" #")[0].strip()
    match shlex.split(line):
        case ["stiction", "app", *_]:
            pass  # The tests of the app run this command, which waits until its window is closed.
        case ["stiction", *_]:
            command_words, _, output_file = reduce_study_size(line).partition(" > ")
            # Commands that start processes on a cluster need their own Python interpreter.
            if re.search("--(cluster|scheduler)", command_words):
                completed = subprocess.run(
                    [sys.executable, "-m", *shlex.split(command_words)], cwd=cwd, capture_output=True, text=True,
                    timeout=240, check=False,
                )  # fmt: skip
            else:
                words = shlex.split(command_words)[1:]
                is_drawn = words[0] not in COMMANDS_WITHOUT_DRAWINGS
                completed = call_stiction(*words, cwd=cwd, without_figures=not is_drawn, without_report=not is_drawn)
            assert completed.returncode == 0, (line, completed.stderr)
            if output_file:
                (cwd / output_file.strip()).write_text(completed.stdout, encoding="utf-8")
            for study in cwd.glob("*.toml"):
                study.write_text(Study.from_toml(study).with_changes(SMALL_STUDY_CHANGES).to_toml(), encoding="utf-8")
        case ["./dev", command, *_]:
            assert command in list_dev_commands() or not DEV_SCRIPT.exists()
        case ["pip", "install", what]:
            package = re.fullmatch(r"(?:stiction(?:-[\w.*-]+\.(?:whl|tar\.gz))?|\.)(?:\[(\w+(?:,\w+)*)\])?", what)
            assert package, line
            project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
            assert set((package[1] or "").split(",")) <= {"", *project["optional-dependencies"]}
        case ["ccx", "block"]:
            assert (cwd / "block.inp").exists()  # A test of joint tables runs the finite-element model in CalculiX.
        case ["cp", source, "."]:
            shutil.copy(ROOT / source, cwd)
        case ["cmake" | "build/rough", *_]:
            pass  # ctest installs the library, and builds and runs the program of the page with it.
        case _:
            raise AssertionError(f"no test runs the command {line!r}; add a case for it")


DEV_SCRIPT = ROOT / "dev"


def list_dev_commands():
    """Return the commands in the usage of `dev`, or an empty set without this file, as in an installed package."""
    usage = ast.get_docstring(ast.parse(DEV_SCRIPT.read_text(encoding="utf-8"))) if DEV_SCRIPT.exists() else ""
    return set(re.findall(r"^\./dev (\w+)", usage, re.MULTILINE))


def split_command_lines(block):
    return [line for line in block.text.replace("\\\n", " ").splitlines() if line.strip() and not line.startswith("#")]


def run_page(page, cwd):
    """Run the blocks of a page in order, all in one directory."""
    for block in find_code_blocks(page):
        if block.kind == "sh":
            for line in split_command_lines(block):
                run_command(line, cwd)
        if block.kind == "python":
            exec(compile(block.text, page.name, "exec"), {})


def has_code(page):
    return any(block.kind in LANGUAGES_RUN_BY_TESTS for block in find_code_blocks(page))


def is_notebook(page):
    """Return whether the code cells of a page are run by the build of the documentation."""
    return any(block.kind in LANGUAGES_RUN_BY_DOCS_BUILD for block in find_code_blocks(page))


LITERAL_PAGES = [
    page
    for page in PAGE_FILES
    if page in (ROOT / "README.md", ROOT / "docs/index.md") or page.parent == ROOT / "docs/tutorials"
]
"""Pages whose commands are run unchanged, in a copy of the tree.

The build of the documentation runs the cells of tutorials that are notebooks unchanged, in a directory that contains
only the example scans.
"""


SCRIPTS_RUN_BY_PAGES = {
    name
    for page in LITERAL_PAGES
    for block in find_code_blocks(page)
    if block.kind == "sh"
    for name in re.findall(r"^python examples/(\w+\.py)$", block.text, re.MULTILINE)
}
"""Example scripts that the test of a literal page runs as a command."""


@pytest.mark.docs
@pytest.mark.usefixtures("few_fitted_lines")
@pytest.mark.parametrize(
    "path",
    [path for path in sorted((ROOT / "examples").glob("*.py")) if path.name not in SCRIPTS_RUN_BY_PAGES],
    ids=lambda path: path.name,
)
def test_example_scripts_finish_without_error(path, run_script_once):
    assert run_script_once(path)


@parametrize_pages([page for page in LITERAL_PAGES if is_notebook(page)])
def test_notebook_names_only_files_that_are_in_the_tree(page):
    names = [name for block in find_code_blocks(page) for name in re.findall(r"examples/[\w./]+", block.text)]
    assert [name for name in names if not (ROOT / name).exists()] == []


DEV_STUB = """#!/bin/sh
# Stand-in for ./dev that creates .venv without a network, with the package that is being tested.
[ "$1" = run ] && shift || exit 2
if [ ! -d .venv ]; then
    {python} -m venv --without-pip .venv
    echo "import site; site.addsitedir('{packages}')" > "$(echo .venv/lib/python*/site-packages)/tested.pth"
    printf '#!/bin/sh\nexec "{clone}/.venv/bin/python" -m stiction "$@"\n' > .venv/bin/stiction
    chmod +x .venv/bin/stiction
fi
exec .venv/bin/stiction run "$@"
"""


def split_command_words(block):
    """Return the words of each shell command in a block, without comments."""
    return [shlex.split(line, comments=True) for line in split_command_lines(block)]


def shell_script(page, finished_commands=()):
    """Return all shell and Python blocks of a page as one script, without commands that are finished already."""
    parts = ["set -e"]
    for block in find_code_blocks(page):
        if block.kind == "sh":
            commands = split_command_words(block)
            new_commands = [command for command in commands if command not in finished_commands]
            parts += [block.text] if new_commands == commands else map(shlex.join, new_commands)
        elif block.kind == "python":
            parts.append(f"python - <<'END_OF_BLOCK'\n{block.text}END_OF_BLOCK")
    return "\n".join(parts) + "\n"


def run_in_new_terminal(script, directory):
    """Run a script in a bash whose environment names no directory of the tested package."""
    environment = {"PATH": os.defpath, "HOME": str(directory), "LANG": "C.UTF-8", "MPLBACKEND": "agg"}
    return subprocess.run(
        ["bash", "-c", script], cwd=directory, env=environment, capture_output=True, text=True, timeout=600, check=False
    )


@pytest.fixture(scope="module")
def clone_after_readme(tmp_path_factory):
    """Run the blocks of README in order in one terminal, in a copy of the tree. Return the copy and the process.

    All test processes share the copy of the process that starts first.
    """
    directory = tmp_path_factory.getbasetemp()
    directory = directory.parent if "PYTEST_XDIST_WORKER" in os.environ else directory
    clone, outcome_file = directory / "clone", directory / "readme.json"
    with (directory / "clone.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not outcome_file.exists():
            shutil.copytree(ROOT / "examples", clone / "examples")
            stub = DEV_STUB.format(python=sys.executable, clone=clone, packages=sysconfig.get_path("purelib"))
            (clone / "dev").write_text(stub, encoding="utf-8")
            (clone / "dev").chmod(0o755)
            completed = run_in_new_terminal(shell_script(ROOT / "README.md"), clone)
            outcome = {name: getattr(completed, name) for name in ("returncode", "stdout", "stderr")}
            outcome_file.write_text(json.dumps(outcome), encoding="utf-8")
    return clone, SimpleNamespace(**json.loads(outcome_file.read_text(encoding="utf-8")))


@pytest.mark.docs
@pytest.mark.timeout(900)
@pytest.mark.skipif(not (ROOT / "README.md").exists(), reason="README.md is not in this tree")
def test_commands_of_readme_work_in_order_in_a_fresh_clone(clone_after_readme):
    _, completed = clone_after_readme
    assert completed.returncode == 0, completed.stderr
    (shown_output,) = [block.text for block in find_code_blocks(ROOT / "README.md") if block.kind == "text"]
    assert shown_output in completed.stdout


@pytest.mark.docs
@pytest.mark.timeout(900)
@parametrize_pages([page for page in LITERAL_PAGES if page.name != "README.md" and has_code(page)])
def test_commands_of_index_and_tutorials_work_after_the_commands_of_the_readme(page, clone_after_readme, tmp_path):
    clone, _ = clone_after_readme
    shutil.copytree(clone, tmp_path / "clone", symlinks=True)
    readme_blocks = [block for block in find_code_blocks(ROOT / "README.md") if block.kind == "sh"]
    script = shell_script(page, list(chain.from_iterable(map(split_command_words, readme_blocks))))
    completed = run_in_new_terminal(f". .venv/bin/activate\n{script}", tmp_path / "clone")
    assert completed.returncode == 0, completed.stderr
    assert completed.stdout


PAGES_RUN_BY_OTHER_TESTS = {"calibration.md", "cluster.md"}
"""Pages whose blocks run in a test that also compares output, or that starts a scheduler."""


@pytest.mark.docs
@pytest.mark.usefixtures("few_fitted_lines")
@parametrize_pages(
    [
        page
        for page in PAGE_FILES
        if has_code(page) and page not in LITERAL_PAGES and page.name not in PAGES_RUN_BY_OTHER_TESTS
    ]
)
def test_code_on_a_documentation_page_is_run_without_error(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name in ("upper", "lower", "lapped"):
        side = "lower" if name == "lapped" else name
        scan = stiction.self_affine(1, hurst_exponent=0.8, rms=0.1, points=4000, spacing=0.05, side=side)
        stiction.write_profile(scan, tmp_path / f"{name}.csv")
    fine_profile = stiction.self_affine(1, hurst_exponent=0.8, rms=0.1, points=4000, spacing=0.05)
    stiction.write_profile(fine_profile, tmp_path / "fine.csv")
    stiction.write_profile(stiction.Profile(fine_profile.heights[::4], spacing=0.2), tmp_path / "coarse.csv")
    shutil.copytree(ROOT / "examples/scans", tmp_path / "examples/scans")
    np.save(tmp_path / "map.npy", np.random.default_rng(1).normal(size=(30, 60)))
    for side in ("upper", "lower"):
        fine_profile = stiction.self_affine_surface(
            1, hurst_exponent=0.8, rms=0.1, shape=(128, 128), spacing=0.2, longest_wavelength=8, side=side
        )
        stiction.write_surface(
            stiction.Surface(fine_profile.heights[::4, ::4], spacing=0.8), tmp_path / f"{side}_scope.csv"
        )
        stiction.write_surface(
            stiction.Surface(fine_profile.heights[:48, :48], spacing=0.2), tmp_path / f"{side}_probe.csv"
        )
    # The code cells of this page, which the documentation build runs, create a result that later commands read.
    if page.name == "pair.md":
        run_command(
            "stiction pair upper.csv lower.csv --effective-modulus '115 GPa' --mu0 0.2 --load '10 mN'", tmp_path
        )
    with use_few_samples():
        run_page(page, tmp_path)


@pytest.mark.docs
@pytest.mark.skipif(not (ROOT / "docs").exists(), reason="the directory docs is not in this tree")
def test_page_about_measured_surfaces_shows_the_output_of_its_example(run_script_once):
    table = run_script_once(ROOT / "examples/characterise_profile.py")
    shown_outputs = [
        block.text for block in find_code_blocks(ROOT / "docs/howto/characterise.md") if block.kind == "text"
    ]
    # Skip the line before the table, which states how the file was read.
    assert table in [text.partition("\n")[2] for text in shown_outputs]


@pytest.mark.skipif(not (ROOT / "docs").exists(), reason="the directory docs is not in this tree")
def test_page_about_the_model_shows_the_numbers_computed_for_two_contacts():
    page = (ROOT / "docs/explanation/theory.md").read_text(encoding="utf-8")
    section = " ".join(page.partition("### Two contacts in numbers\n")[2].partition("\n## Asperity")[0].split())
    force, area = stiction.hertz_sphere(0.020, 50, 115)
    mu0, tau0, angle = 0.2, 0.1, np.radians(5)
    friction = mu0 * force + tau0 * area
    force_z, force_x = force * np.cos(angle), force * np.sin(angle)
    friction_z, friction_x = friction * np.sin(angle), friction * np.cos(angle)
    climbed = (force_z - friction_z, force_x + friction_x)
    descended = (force_z + friction_z, friction_x - force_x)
    all_contacts = np.add(climbed, descended)
    opposing = (climbed[0] + force_z, climbed[1])
    alone = stiction.slope_friction(angle, mu0=mu0, tau0=tau0, mean_pressure=force / area)
    mean_friction = friction / force
    small_slope = (mean_friction / 2 + np.tan(angle) / 2) / (1 - mean_friction * np.tan(angle) / 2)
    assert climbed[1] / climbed[0] == pytest.approx(alone)
    assert all_contacts[1] / all_contacts[0] == pytest.approx(mean_friction)
    assert opposing[1] / opposing[0] == pytest.approx(small_slope)
    for text in (
        f"F = {force:.3f} mN, A = {area:.3f} µm², and the friction force μ0 F + τ0 A = {friction:.3f} mN",
        f"so μ0 + τ0 A/F is {mean_friction:.3f}",
        f"| {force_z:.3f} − {friction_z:.3f} = {climbed[0]:.3f} "
        f"| {force_x:.3f} + {friction_x:.3f} = {climbed[1]:.3f} | alone {alone:.3f} |",
        f"| {force_z:.3f} + {friction_z:.3f} = {descended[0]:.3f} "
        f"| −{force_x:.3f} + {friction_x:.3f} = {descended[1]:.3f} |",
        f"| {all_contacts[0]:.3f} | {all_contacts[1]:.3f} | **{mean_friction:.3f}** |",
        f"| {climbed[0]:.3f} + {force_z:.3f} = {opposing[0]:.3f} | {opposing[1]:.3f} | **{small_slope:.3f}** |",
        f"carries only its elastic {force_z:.3f} mN",
        f"with m = {mean_friction:.3f} and 2S = tan 5°, the closed form also gives μ_s = {small_slope:.3f}",
    ):
        assert text in section


@pytest.mark.docs
@pytest.mark.skipif(not (ROOT / "docs").exists(), reason="the directory docs is not in this tree")
def test_page_about_friction_tests_shows_the_output_of_its_commands(tmp_path, monkeypatch):
    """Run all blocks, and compare each shown output with that of the last command before it, and the figure."""
    monkeypatch.chdir(tmp_path)
    shutil.copytree(ROOT / "examples/scans", tmp_path / "examples/scans")
    pending_commands, num_compared = [], 0
    for block in find_code_blocks(ROOT / "docs/howto/calibration.md"):
        match block.kind:
            case "python":
                exec(compile(block.text, "calibration.md", "exec"), {})
            case "sh":
                pending_commands += split_command_lines(block)
            case "text":
                outputs = [check_stiction(*shlex.split(line)[1:], cwd=tmp_path).stdout for line in pending_commands]
                shown_words = block.text.split()
                if shown_words[-1] == "...":
                    assert outputs[-1].split()[: len(shown_words) - 1] == shown_words[:-1]
                else:
                    assert outputs[-1].split() == shown_words
                pending_commands = []
                num_compared += 1
    assert not pending_commands
    assert num_compared == 4
    shown_figure = ROOT / "docs/images/pmma_glass.png"
    difference = compare_images(str(shown_figure), str(tmp_path / "pmma_glass.png"), MAX_GREY_DIFFERENCE)
    assert difference is None, f"{difference}; copy the new figure to {shown_figure}"


@pytest.mark.skipif(not DEV_SCRIPT.exists(), reason="the script dev is not in this tree")
def test_usage_text_of_the_dev_script_lists_all_commands():
    commands = set(re.findall(r'^    "(\w+)": ', DEV_SCRIPT.read_text(encoding="utf-8"), re.MULTILINE))
    assert commands == list_dev_commands()


SBATCH_SCRIPT = """#!/bin/sh
job=$(cat "$1")
setsid sh -c "$job" >/dev/null 2>&1 &
echo Submitted batch job $!
"""
SCANCEL_SCRIPT = """#!/bin/sh
kill -- "-$1"
"""


SLURM_TASK_ENVIRONMENT = {
    "SLURM_CPUS_PER_TASK": "1",
    "SLURM_ARRAY_TASK_ID": "2",
    "SLURM_ARRAY_TASK_COUNT": "2",
    "SHARED": "shared",
}
"""Environment variables that Slurm sets in each task of an array job."""


@pytest.mark.docs
@parametrize_pages([page for page in PAGE_FILES if page.name == "cluster.md"])
# The package distributed closes sockets and event loops late, so pytest would report resource warnings.
@pytest.mark.filterwarnings("ignore")
def test_code_on_the_documentation_page_about_clusters_is_run_without_error(page, tmp_path, monkeypatch):
    """Run the page with a local Dask scheduler, and with a stand-in for Slurm that starts jobs on this machine."""
    distributed = pytest.importorskip("distributed")
    for name, script_text in (("sbatch", SBATCH_SCRIPT), ("scancel", SCANCEL_SCRIPT)):
        (tmp_path / name).write_text(script_text, encoding="utf-8")
        (tmp_path / name).chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    num_computed = 0
    with distributed.LocalCluster(n_workers=1, processes=False, protocol="tcp", dashboard_address=None) as cluster:

        def replace_cluster_settings(text):
            text = text.replace("tcp://head-node:8786", cluster.scheduler_address).replace("16GB", "1GB")
            for name, value in SLURM_TASK_ENVIRONMENT.items():
                text = text.replace(f"${name}", value)
            return re.sub(r"\b(cores|processes|jobs)=\d+", r"\1=1", text)

        for block in find_code_blocks(page):
            for part in split_command_lines(block) if block.kind == "sh" else [block.text]:
                if block.kind == "sh":
                    run_command(replace_cluster_settings(part), tmp_path)
                elif block.kind == "python":
                    (tmp_path / "page.py").write_text(replace_cluster_settings(part), encoding="utf-8")
                    completed = subprocess.run(
                        [sys.executable, "page.py"], cwd=tmp_path, capture_output=True, text=True, timeout=120,
                        check=False,
                    )  # fmt: skip
                    assert completed.returncode == 0, completed.stderr
                if (tmp_path / "big").exists():
                    assert store.info(tmp_path / "big").finished == 2
                    # Remove the result, or else the next command would have nothing to compute.
                    shutil.rmtree(tmp_path / "big")
                    num_computed += 1
    assert num_computed == 3


def test_reference_documentation_lists_every_public_name():
    pages = sorted((ROOT / "docs/reference").glob("api_*.md"))
    if not pages:
        pytest.skip("the directory docs is not in this tree")
    entry = re.compile(r"^\.\. (?:autoclass|autofunction):: (\S+)$", re.MULTILINE)
    listed_names = [name for page in pages for name in entry.findall(page.read_text(encoding="utf-8"))]
    assert len(listed_names) == len(set(listed_names))
    assert [name for name in stiction.__all__ if name not in [*listed_names, "__version__"]] == []


def load_script(name):
    """Return a script of the documentation as a module."""
    path = ROOT / f"docs/scripts/{name}.py"
    if not path.exists():
        pytest.skip("the directory docs is not in this tree")
    spec = importlib.util.spec_from_file_location(name, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


MAX_GREY_DIFFERENCE = 5.0
"""Largest rms difference of grey levels (0 to 255). If the approach changes by 10 nm, the difference is 13."""


@pytest.mark.docs
@pytest.mark.parametrize("name", ["conventions", "conventions_areas", "spectrum_ends"])
def test_drawings_of_the_documentation_equal_the_output_of_their_scripts(tmp_path, name):
    if not (ROOT / "docs/images").exists():
        pytest.skip("the directory of pictures is not in this tree")
    load_script(name).save_figures(tmp_path)
    assert list(tmp_path.iterdir())
    for path in tmp_path.iterdir():
        difference = compare_images(str(ROOT / "docs/images" / path.name), str(path), MAX_GREY_DIFFERENCE)
        assert difference is None, f"{difference}; run docs/scripts/{name}.py and check the new drawing"


def test_constants_named_in_the_guide_to_extensions_exist():
    directories = ("python", "tests", "docs/scripts")
    sources = "".join(path.read_text("utf-8") for directory in directories for path in (ROOT / directory).rglob("*.py"))
    constants = re.findall(r"`([A-Z][A-Z_]+)`", (ROOT / "docs/howto/extending.md").read_text("utf-8"))
    assert len(constants) > 5
    assert [name for name in constants if not re.search(rf"^{name}\b", sources, re.MULTILINE)] == []


def test_reference_documentation_lists_every_key_and_every_option_and_every_study():
    reference = load_script("reference")
    pages = reference.render_pages(ROOT / "docs")
    tables = [
        item for table in Study.model_fields.values() for item in get_args(table.annotation) or [table.annotation]
    ]
    for table in tables:
        for study_key, entry in table.model_fields.items():
            assert entry.description, (
                f"{study_key} needs a description, which is printed in the reference of study files"
            )
            assert f"| `{study_key}` |" in study_keys_markdown()
    written_page = ROOT / "docs/generated/study_keys.md"
    assert written_page.read_text("utf-8") == study_keys_markdown(), (
        "write stiction.views.study_keys.study_keys_markdown() to this file"
    )
    for name in stiction.study_names():
        assert f"| `{name}` | " in pages["built_in.md"]
    for group in reference.COMMANDS_BY_GROUP.values():
        for name in group:
            assert f"## `stiction {name}`" in pages["commands.md"]
    assert "| `--set` `KEY=VALUE` |" in pages["commands.md"]
    for name in (name for name in stiction.__all__ if name != "__version__"):
        assert f"| `{name}` | " in pages["names.md"]
