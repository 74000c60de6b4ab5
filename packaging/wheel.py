"""Build the source distribution and a wheel from it for each installed Python, and verify all of them.

`./dev wheel` runs this; `./dev wheel --quick` leaves out the tests, which otherwise run with the Python of ./dev.
Releases are built by cibuildwheel, which needs containers. This script needs no
containers, and finds most problems before a release.
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tempfile
from pathlib import Path

from prove import ARCHIVE_STEM, PYPROJECT, ROOT, check_equal_names, exit_with_error, print_message, run_command

DIST_DIRECTORY = ROOT / "build/wheel/dist"
UNVERIFIED_DIRECTORY = ROOT / "build/wheel/unproven"
VERIFIED_COMMIT_FILE = ROOT / "build/wheel/proven.txt"
"""File with the hash of the last commit whose wheels were verified, which packaging/release.py reads."""

MIN_PYTHON_MINOR = 11
MAX_PYTHON_MINOR = 14

INTERPRETER_CHECK_SCRIPT = """
import os, sys, sysconfig, ensurepip
header = os.path.join(sysconfig.get_path("include"), "Python.h")
sys.exit(sys.version_info[:2] != (3, int(sys.argv[1])) or not os.path.exists(header))
"""


def find_interpreters() -> dict[str, Path]:
    """Return one suitable interpreter for each Python version, such as "3.11", from PATH or pyenv."""
    interpreters = {}
    pyenv_directory = Path(os.environ.get("PYENV_ROOT", Path.home() / ".pyenv")) / "versions"
    for minor in range(MIN_PYTHON_MINOR, MAX_PYTHON_MINOR + 1):
        running_interpreter = [Path(sys.executable)] if sys.version_info[:2] == (3, minor) else []
        installed_interpreters = [
            *sorted(pyenv_directory.glob(f"3.{minor}.*/bin/python")),
            Path(shutil.which(f"python3.{minor}") or "/none"),
        ]
        for python in (*running_interpreter, *installed_interpreters):
            if python.exists() and can_build_wheel(python, minor):
                interpreters[f"3.{minor}"] = python
                break
    return interpreters


def can_build_wheel(python: Path, minor: int) -> bool:
    completed = subprocess.run([python, "-c", INTERPRETER_CHECK_SCRIPT, str(minor)], check=False, capture_output=True)
    return completed.returncode == 0


def describe_commit() -> str:
    """Return the hash of the current commit, with a mark if there are uncommitted changes."""
    return run_command("git", "describe", "--always", "--dirty", "--abbrev=40", "--match", "nothing").strip()


def build_sdist(directory: Path) -> Path:
    run_command(sys.executable, "-m", "build", "--sdist", "--outdir", directory, ROOT)
    return directory / f"{ARCHIVE_STEM}.tar.gz"


def check_sdist(sdist: Path) -> int:
    """Check that a source distribution contains only tracked files of the allow-list, and return their number."""
    patterns = [
        f":(top,glob){pattern.lstrip('/')}" for pattern in PYPROJECT["tool"]["scikit-build"]["sdist"]["include"]
    ]
    tracked_files = run_command("git", "ls-files", "-z", "--", *patterns).split("\0")[:-1]
    with tarfile.open(sdist) as archive:
        archived_files = [name.removeprefix(f"{ARCHIVE_STEM}/") for name in archive.getnames()]
    check_equal_names(
        "the source distribution, of the tracked files in sdist.include", archived_files, [*tracked_files, "PKG-INFO"]
    )
    return len(tracked_files)


def build_wheel(sdist: Path, python: Path, directory: Path) -> Path:
    """Build a wheel from the unpacked source distribution, in a directory whose name has a space."""
    sources, wheel_directory = directory / "the sources", directory / "built"
    shutil.unpack_archive(sdist, sources)
    environment = directory / "building"
    run_command(python, "-m", "venv", environment)
    run_command(
        environment / "bin/python", "-m", "pip", "wheel", "--quiet", "--disable-pip-version-check", "--no-deps",
        "--wheel-dir", wheel_directory, sources / ARCHIVE_STEM, cwd=directory,
    )  # fmt: skip
    (wheel,) = wheel_directory.glob("*.whl")
    return wheel


def repair_wheel(unrepaired_wheel: Path, directory: Path) -> Path:
    """Add the oldest manylinux tag that the symbols in a wheel allow. Exit if a library would be bundled."""
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    run_command(
        sys.executable,
        "-m",
        "auditwheel",
        "repair",
        "--wheel-dir",
        directory / "repaired",
        unrepaired_wheel,
        cwd=directory,
        env=environment,
    )
    (wheel,) = (directory / "repaired").glob("*.whl")
    if not re.fullmatch(rf"{ARCHIVE_STEM}-cp(\d+)-cp\1-(manylinux\w+\.?)+\.whl", wheel.name):
        exit_with_error(f"{wheel.name}: not the name of a manylinux wheel for one Python")
    return wheel


def verify_wheel(wheel: Path, python: Path, *, with_tests: bool) -> bool:
    """Verify a wheel in a new process of its Python version, which creates the test environments."""
    command: list[str | Path] = [python, ROOT / "packaging/prove.py", *([] if with_tests else ["--quick"]), wheel]
    return subprocess.run(command, check=False, cwd=ROOT).returncode == 0


def main() -> None:
    parser = argparse.ArgumentParser(description="Build the source distribution and wheels, and prove them.")
    parser.add_argument("--quick", action="store_true", help="without the tests")
    options = parser.parse_args()
    # Files in the archives have the time of the commit, so that builds are reproducible.
    os.environ["SOURCE_DATE_EPOCH"] = run_command("git", "log", "-1", "--format=%ct").strip()
    VERIFIED_COMMIT_FILE.unlink(missing_ok=True)
    for directory in (DIST_DIRECTORY, UNVERIFIED_DIRECTORY):
        shutil.rmtree(directory, ignore_errors=True)
        directory.mkdir(parents=True)
    interpreters = find_interpreters()
    print_message(f"for Python {', '.join(interpreters)}; {missing_versions_text(interpreters)}")
    failed_versions = []
    with tempfile.TemporaryDirectory(prefix="stiction-wheel-") as temporary_directory:
        directory = Path(temporary_directory).resolve()
        sdist = build_sdist(directory)
        num_files = check_sdist(sdist)
        run_command(sys.executable, "-m", "twine", "check", "--strict", sdist)
        print_message(
            f"{sdist.name}: the {num_files} tracked files that it should hold, {sdist.stat().st_size / 1000:.0f} kB"
        )
        for version, python in interpreters.items():
            version_directory = directory / version
            version_directory.mkdir()
            print_message(f"building the wheel for Python {version} from it")
            wheel = repair_wheel(build_wheel(sdist, python, version_directory), version_directory)
            run_command(sys.executable, "-m", "twine", "check", "--strict", wheel)
            # The wheel is kept even if the verification fails, because building it takes a long time.
            unverified_wheel = Path(shutil.copy(wheel, UNVERIFIED_DIRECTORY))
            with_tests = not options.quick and python == Path(sys.executable)
            if verify_wheel(unverified_wheel, python, with_tests=with_tests):
                shutil.move(unverified_wheel, DIST_DIRECTORY)
            else:
                failed_versions.append(unverified_wheel.name)
        shutil.copy(sdist, DIST_DIRECTORY)
    for archive in sorted(DIST_DIRECTORY.iterdir()):
        print_message(f"{archive.relative_to(ROOT)}")
    if failed_versions:
        exit_with_error(
            f"not proven, and left in {UNVERIFIED_DIRECTORY.relative_to(ROOT)}: {', '.join(failed_versions)}"
        )
    VERIFIED_COMMIT_FILE.write_text(
        f"{describe_commit()} {'without' if options.quick else 'with'} the tests\n", encoding="utf-8"
    )


def missing_versions_text(interpreters: dict[str, Path]) -> str:
    missing_versions = [
        f"3.{minor}" for minor in range(MIN_PYTHON_MINOR, MAX_PYTHON_MINOR + 1) if f"3.{minor}" not in interpreters
    ]
    return f"missing: {', '.join(missing_versions)}" if missing_versions else "all supported versions"


if __name__ == "__main__":
    main()
