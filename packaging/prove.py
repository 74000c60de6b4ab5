"""Verify a wheel: its contents, its requirements, and its use without a compiler, Eigen, GSL and FFTW.

    python packaging/prove.py [--quick] WHEEL [TESTS ...]

`--quick` leaves out the tests; TESTS are run instead of all tests. cibuildwheel runs this script for each wheel, and
packaging/wheel.py for wheels that are built without it. A violation gives a message and exit status 1.
"""

import argparse
import email
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parents[1]
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT_METADATA = PYPROJECT["project"]
ARCHIVE_STEM = f"{PROJECT_METADATA['name']}-{PROJECT_METADATA['version']}"

MAX_GLIBC = (2, 34)
"""Newest glibc version that a wheel may require, as documented in docs/howto/installing.md."""

MAX_SYMBOL_VERSIONS = {"GLIBC": MAX_GLIBC, "GLIBCXX": (3, 4, 29), "CXXABI": (1, 3, 13)}
"""Newest symbol versions of glibc and libstdc++ that the extension may require. RHEL 9 (GCC 11) has these versions."""

MAX_IMPORT_SECONDS = 5.0
"""Largest accepted time of `import stiction`. An idle machine takes 0.3 s."""

SYSTEM_LIBRARY_PATTERN = re.compile(r"(libc|libm|libstdc\+\+|libgcc_s|ld-linux[\w-]*)\.so\.\d+")
COMPILER_PATTERN = re.compile(r"([\w-]+-)?(cc|c\+\+|gcc|g\+\+|clang|clang\+\+|cpp|ld|as|cmake|ninja|g?make)(-[\d.]+)?")
SYSTEM_PROGRAM_DIRECTORIES = [
    Path(directory) for directory in ("/usr/local/sbin", "/usr/local/bin", "/usr/sbin", "/usr/bin")
]

# The script runs inside the environment and, once, outside.
INSPECTION_SCRIPT = """
import os, shutil, sys
path = os.environ["PATH"] + os.pathsep + sys.argv[1]
for name in ("cc", "c++", "gcc", "g++", "clang++", "cmake"):
    if program := shutil.which(name, path=path):
        print(program)
for root in sys.argv[2:]:
    for folder, _, names in os.walk(root):
        for name in names:
            whole = os.path.join(folder, name)
            found = name.startswith(("libgsl", "libfftw3")) or whole.endswith(
                ("/gsl/gsl_version.h", "/fftw3.h", "/Eigen/Core")
            )
            if found and os.path.isfile(whole):
                print(whole)
"""


def print_message(message: str) -> None:
    print(f"wheel: {message}", flush=True)


def exit_with_error(message: str) -> NoReturn:
    print(f"wheel: {message}", file=sys.stderr)
    sys.exit(1)


def run_command(
    *command: str | Path,
    cwd: Path = ROOT,
    env: Mapping[str, str] = os.environ,
    quiet: bool = True,
    wrapper_command: Iterable[str] = (),
) -> str:
    """Run a command, optionally inside a wrapper command, and return its output. If it fails, exit with the output."""
    full_command = [*wrapper_command, *map(str, command)]
    output_options = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT} if quiet else {}
    completed = subprocess.run(  # type: ignore[call-overload]
        full_command, check=False, cwd=cwd, env=env, text=True, **output_options
    )
    if completed.returncode != 0:
        text = f"{(completed.stdout or '').strip()}\n{shlex.join(map(str, command))} ended with {completed.returncode}"
        exit_with_error(text.strip())
    return completed.stdout or ""


def check_equal_names(description: str, actual: Iterable[str], expected: Iterable[str]) -> None:
    """Exit with the difference if two sets of names differ. The message describes the names by `description`."""
    unexpected_names, missing_names = sorted(set(actual) - set(expected)), sorted(set(expected) - set(actual))
    if unexpected_names:
        exit_with_error(f"{description}: there is also {', '.join(unexpected_names)}")
    if missing_names:
        exit_with_error(f"{description}: missing {', '.join(missing_names)}")


# ---- Contents -------------------------------------------------------------------------------------------------------


def check_wheel(wheel: Path, directory: Path) -> None:
    """Check that the wheel contains only the package and its licences, and that its extension is self-contained."""
    package_files = [
        str(path.relative_to(ROOT / "python"))
        for path in (ROOT / "python/stiction").rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    ]
    metadata_files = [
        "METADATA",
        "WHEEL",
        "RECORD",
        "entry_points.txt",
        *(f"licenses/{n}" for n in PROJECT_METADATA["license-files"]),
    ]
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if not name.endswith("/")}
        extensions = [name for name in names if re.fullmatch(r"stiction/_core\.cpython-[\w-]+\.so", name)]
        if len(extensions) != 1:
            exit_with_error(f"{wheel.name} holds {len(extensions)} extensions, not one")
        # auditwheel adds a bill of materials, which lists no libraries, because this wheel bundles none.
        bill_of_materials = {name for name in names if name.startswith(f"{ARCHIVE_STEM}.dist-info/sboms/")}
        check_equal_names(
            "the wheel, of the package and its licences",
            names - bill_of_materials,
            [*package_files, *extensions, *(f"{ARCHIVE_STEM}.dist-info/{name}" for name in metadata_files)],
        )
        check_metadata(archive.read(f"{ARCHIVE_STEM}.dist-info/METADATA"))
        extension = Path(archive.extract(extensions[0], directory))
    if sys.platform == "linux":
        check_extension(extension)
        check_min_glibc(wheel)


def check_metadata(text: bytes) -> None:
    metadata = email.message_from_bytes(text)
    for field, key in (
        ("Name", "name"),
        ("Version", "version"),
        ("Requires-Python", "requires-python"),
        ("License-Expression", "license"),
    ):
        if metadata[field] != PROJECT_METADATA[key]:
            exit_with_error(f"the metadata say {field}: {metadata[field]}, pyproject.toml {PROJECT_METADATA[key]}")


def check_min_glibc(wheel: Path) -> None:
    """Check that the wheel runs with the documented minimum version of glibc."""
    glibc_versions = [(int(major), int(minor)) for major, minor in re.findall(r"manylinux_(\d+)_(\d+)_", wheel.name)]
    if not glibc_versions:
        exit_with_error(f"{wheel.name}: not the name of a manylinux wheel")
    if min(glibc_versions) > MAX_GLIBC:
        exit_with_error(f"{wheel.name} needs a newer glibc than the {MAX_GLIBC[0]}.{MAX_GLIBC[1]} that is promised")
    requirement_text = f"glibc {MAX_GLIBC[0]}.{MAX_GLIBC[1]} or newer"
    installation_page = ROOT / "docs/howto/installing.md"
    if installation_page.exists() and requirement_text not in installation_page.read_text(encoding="utf-8"):
        exit_with_error(f"docs/howto/installing.md does not say {requirement_text!r}")


def find_newer_symbol_versions(extension: Path) -> list[str]:
    """Return the symbol versions, such as GLIBCXX_3.4.30, that an extension requires beyond `MAX_SYMBOL_VERSIONS`."""
    names = set(re.findall(rb"(?<=\0)(?:GLIBC|GLIBCXX|CXXABI)_[0-9.]+(?=\0)", extension.read_bytes()))
    newer_versions = []
    for name in sorted(name.decode() for name in names):
        library, version = name.split("_")
        if tuple(map(int, version.split("."))) > MAX_SYMBOL_VERSIONS[library]:
            newer_versions.append(name)
    return newer_versions


def check_extension(extension: Path) -> None:
    if newer_versions := find_newer_symbol_versions(extension):
        exit_with_error(
            f"the extension requires {', '.join(newer_versions)}, but the oldest supported systems have versions up to "
            + ", ".join(f"{library}_{'.'.join(map(str, version))}" for library, version in MAX_SYMBOL_VERSIONS.items())
        )
    dynamic_section = run_command("readelf", "--wide", "--dynamic", extension)
    needed_libraries = re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic_section)
    foreign_libraries = [library for library in needed_libraries if not SYSTEM_LIBRARY_PATTERN.fullmatch(library)]
    if foreign_libraries or not needed_libraries:
        exit_with_error(f"the extension needs {', '.join(foreign_libraries) or 'no library at all'}")
    if re.search(r"\((RPATH|RUNPATH)\)", dynamic_section):
        exit_with_error("the extension looks for libraries in its own directory")
    exported_symbols = [
        line.split()[0] for line in run_command("nm", "-D", "--defined-only", "-P", extension).splitlines()
    ]
    check_equal_names("symbols that the extension exports", exported_symbols, ["PyInit__core"])


# ---- Environment ----------------------------------------------------------------------------------------------------


class IsolatedEnvironment:
    """New environment that hides this tree, compilers, Eigen, GSL and FFTW."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.bin = directory / "environment/bin"
        tools_directory = directory / "tools"
        tools_directory.mkdir()
        for name in ("sh", "bash", "cat", "setsid", "mount", "umount"):  # The tests need these programs.
            if program_path := shutil.which(name):
                (tools_directory / name).symlink_to(program_path)
        inherited_variables = {
            name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))
        }
        self.environment = inherited_variables | {"PATH": f"{self.bin}{os.pathsep}{tools_directory}"}
        self.hides_by_mount = self.can_hide_directories()
        run_command(sys.executable, "-m", "venv", directory / "environment")
        # The option for dependency groups requires pip 25.1.
        self.install_from_wheels("pip>=25.1")

    def can_hide_directories(self) -> bool:
        """Return whether directories can be hidden by mounts. Mounts need root and affect no other process."""
        may_mount = sys.platform == "linux" and os.geteuid() == 0 and shutil.which("unshare") is not None
        return (
            may_mount
            and subprocess.run(["unshare", "--mount", "true"], check=False, capture_output=True).returncode == 0
        )

    def hiding_script(self) -> str:
        """Return shell commands that hide directories behind empty directories, and files behind /dev/null."""
        directories = [ROOT, *map(Path, ("/usr/include", "/usr/local/include", "/usr/share/eigen3", "/usr/lib/gcc"))]
        programs = [
            program
            for directory in {*SYSTEM_PROGRAM_DIRECTORIES, *map(Path, os.environ["PATH"].split(os.pathsep))}
            if directory.is_dir()
            for program in directory.iterdir()
            if COMPILER_PATTERN.fullmatch(program.name)
        ]
        libraries = [
            path
            for directory in ("/usr/lib", "/usr/local/lib")
            for name in ("libgsl*", "libfftw3*")
            for path in Path(directory).rglob(name)
        ]
        files = {path.resolve() for path in (*programs, *libraries) if path.is_file()}
        mount_program = shutil.which("mount")
        mount_commands = [
            f"{mount_program} -t tmpfs none {shlex.quote(str(path))}" for path in directories if path.is_dir()
        ]
        mount_commands += [f"{mount_program} --bind /dev/null {shlex.quote(str(path))}" for path in sorted(files)]
        return "\n".join(["set -e", *mount_commands, 'exec "$@"'])

    def run_isolated(self, *command: str | Path, cwd: Path | None = None, quiet: bool = True) -> str:
        unshare, shell = shutil.which("unshare") or "", shutil.which("sh") or ""
        hiding_command = (unshare, "--mount", "--propagation", "private", shell, "-c", self.hiding_script(), shell)
        wrapper_command = hiding_command if self.hides_by_mount else ()
        return run_command(
            *command, cwd=cwd or self.directory, env=self.environment, quiet=quiet, wrapper_command=wrapper_command
        )

    def check_outside_is_hidden(self) -> None:
        """Check that compilers and libraries that are visible outside the environment are hidden inside it."""
        system_directories = os.pathsep.join(map(str, SYSTEM_PROGRAM_DIRECTORIES))
        if self.hides_by_mount:
            visible_outside = run_command(
                sys.executable, "-c", INSPECTION_SCRIPT, system_directories, "/usr"
            ).splitlines()
            for file_name in ("c++", "cmake", "libgsl.a", "gsl_version.h", "libfftw3.a", "fftw3.h", "Eigen/Core"):
                if not any(path.endswith(file_name) for path in visible_outside):
                    exit_with_error(f"no {file_name} was found here, so that hiding it shows nothing")
            visible_files = self.run_isolated(
                self.bin / "python", "-I", "-c", INSPECTION_SCRIPT, system_directories, "/usr", "/opt", ROOT
            )
        else:
            visible_files = self.run_isolated(self.bin / "python", "-I", "-c", INSPECTION_SCRIPT, "")
        if visible_files:
            exit_with_error(f"these are not hidden: {', '.join(visible_files.split())}")

    def install_from_wheels(self, *requirements: str | Path) -> None:
        """Install packages from wheels only, so that nothing is compiled."""
        pip = (self.bin / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        self.run_isolated(*pip, "--only-binary=:all:", *requirements)

    def check_installed(self) -> None:
        """Check that Python imports the package from the wheel."""
        code = "import stiction, stiction._core as core; print(stiction.__version__, stiction.__file__, core.__file__)"
        version, *files = self.run_isolated(self.bin / "python", "-I", "-c", code).split()
        for file in files:
            if self.directory / "environment" not in Path(file).parents:
                exit_with_error(f"{file} is imported, which is not the installed wheel")
        if version != PROJECT_METADATA["version"]:
            exit_with_error(f"version {version} is imported, not {PROJECT_METADATA['version']}")

    def measure_import_time(self) -> float:
        """Return the shortest of three import times, each measured in a new interpreter."""
        code = "import time; a = time.perf_counter(); import stiction; stiction.press; print(time.perf_counter() - a)"
        return min(float(self.run_isolated(self.bin / "python", "-I", "-c", code)) for _ in range(3))

    def run_quick_study(self) -> None:
        self.run_isolated(self.bin / "stiction", "run", "quick", "--output", "quick")
        for name in ("study.toml", "area.png"):
            if not (self.directory / "quick" / name).exists():
                exit_with_error(f"stiction run quick wrote no {name}")

    def compute_sample_friction(self) -> None:
        """Compute the friction of the sample scans from text files and from files in an instrument format."""
        shutil.copytree(ROOT / "examples/scans", self.directory / "scans")
        for finish, extension, hardness_options in (("lapped", "csv", []), ("ground", "x3p", ["--hardness", "2 GPa"])):
            scans = [f"scans/{finish}_{side}.{extension}" for side in ("upper", "lower")]
            output = self.run_isolated(
                self.bin / "stiction", "pair", *scans, "--young", "210 GPa", "--poisson", "0.3", "--mu0", "0.2",
                "--tau0", "50 MPa", *hardness_options, "--load", "20 mN", "--output", finish,
            )  # fmt: skip
            if not re.search(r"μ_s = 0\.\d+ \[0\.\d+, 0\.\d+\]", output):
                exit_with_error(f"stiction pair of the {finish} scans gave no coefficient:\n{output}")

    def run_tests(self, selected_tests: Iterable[str]) -> None:
        """Run the tests from a copy of the tree without the sources of the package."""
        tree_copy = self.directory / "tests"
        ignored_names = shutil.ignore_patterns("build", ".*", "__pycache__")
        shutil.copytree(ROOT, tree_copy, ignore=ignored_names)
        for source_directory in ("python", "cpp"):
            shutil.rmtree(tree_copy / source_directory)
        self.install_from_wheels("--group", f"{tree_copy / 'pyproject.toml'}:test")
        self.check_installed()
        self.run_isolated(
            self.bin / "python", "-I", "-m", "pytest", "-q", "-p", "no:cacheprovider", "--numprocesses=2",
            "--dist=worksteal", *selected_tests, cwd=tree_copy, quiet=False,
        )  # fmt: skip


def prove_wheel(wheel: Path, *, with_tests: bool, selected_tests: Iterable[str] = ()) -> None:
    start_time = time.perf_counter()
    with tempfile.TemporaryDirectory(prefix="stiction-proof-") as temporary_directory:
        directory = Path(temporary_directory).resolve()
        check_wheel(wheel, directory)
        print_message(
            f"{wheel.name}: the package alone, {wheel.stat().st_size / 1000:.0f} kB; no foreign library or symbol"
        )
        environment = IsolatedEnvironment(directory)
        environment.check_outside_is_hidden()
        hiding_method = "a mount namespace and PATH" if environment.hides_by_mount else "PATH alone"
        print_message(
            f"installing it where neither compilers nor Eigen, GSL and FFTW are seen, hidden by {hiding_method}"
        )
        copied_wheel = shutil.copy(wheel, directory)  # Copy the wheel first, because this tree will be hidden.
        environment.install_from_wheels(copied_wheel)
        environment.check_installed()
        if (seconds := environment.measure_import_time()) > MAX_IMPORT_SECONDS:
            exit_with_error(f"import stiction takes {seconds:.1f} s")
        environment.run_quick_study()
        environment.compute_sample_friction()
        print_message(f"import {seconds:.2f} s; run quick, pair of four sample scans: all right")
        if with_tests:
            print_message("the tests")
            environment.run_tests(selected_tests)
    print_message(f"proven in {time.perf_counter() - start_time:.0f} s{'' if with_tests else ', without the tests'}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Prove one wheel.")
    parser.add_argument("--quick", action="store_true", help="without the tests")
    parser.add_argument("wheel", type=Path)
    parser.add_argument("tests", nargs="*", help="instead of all of them")
    options = parser.parse_args()
    prove_wheel(options.wheel.resolve(), with_tests=not options.quick, selected_tests=options.tests)


if __name__ == "__main__":
    main()
