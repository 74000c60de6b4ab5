"""Build the source distribution, from it alone the wheel, and prove that both are what they should be.

`./dev wheel` runs this. What a rule forbids ends it with a message and exit status 1.
"""

import email
import os
import re
import shlex
import shutil
import subprocess
import sys
import sysconfig
import tarfile
import tempfile
import tomllib
import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import NoReturn

ROOT = Path(__file__).resolve().parents[1]
DIST = ROOT / "build/wheel/dist"
PYPROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
PROJECT = PYPROJECT["project"]
STEM = f"{PROJECT['name']}-{PROJECT['version']}"

# The dynamic libraries that every Linux with glibc has.
SYSTEM_LIBRARY = re.compile(r"(libc|libm|libstdc\+\+|libgcc_s|ld-linux[\w-]*)\.so\.\d+")
COMPILER = re.compile(r"([\w-]+-)?(cc|c\+\+|gcc|g\+\+|clang|clang\+\+|cpp|ld|as|cmake|ninja|g?make)(-[\d.]+)?")
SYSTEM_PATH = [Path(folder) for folder in ("/usr/local/sbin", "/usr/local/bin", "/usr/sbin", "/usr/bin")]

# Run where compilers, Eigen and GSL are out of sight, and once where they are not: prints those that it sees.
LOOK = """
import os, shutil, sys
path = os.environ["PATH"] + os.pathsep + sys.argv[1]
for name in ("cc", "c++", "gcc", "g++", "clang++", "cmake"):
    if program := shutil.which(name, path=path):
        print(program)
for root in sys.argv[2:]:
    for folder, _, names in os.walk(root):
        for name in names:
            whole = os.path.join(folder, name)
            found = name.startswith("libgsl") or whole.endswith(("/gsl/gsl_version.h", "/Eigen/Core"))
            if found and os.path.isfile(whole):
                print(whole)
"""


def say(what: str) -> None:
    print(f"wheel: {what}", flush=True)


def fail(what: str) -> NoReturn:
    print(f"wheel: {what}", file=sys.stderr)
    sys.exit(1)


def call(
    *command: str | Path,
    cwd: Path = ROOT,
    env: Mapping[str, str] = os.environ,
    quiet: bool = True,
    within: Iterable[str] = (),
) -> str:
    """Run a command, within another, and return what it said; end with that if it fails."""
    whole = [*within, *map(str, command)]
    said = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT} if quiet else {}
    done = subprocess.run(whole, check=False, cwd=cwd, env=env, text=True, **said)  # type: ignore[call-overload]
    if done.returncode != 0:
        fail(f"{(done.stdout or '').strip()}\n{shlex.join(map(str, command))} ended with {done.returncode}".strip())
    return done.stdout or ""


def compare(what: str, found: Iterable[str], expected: Iterable[str]) -> None:
    """End where two sets of names differ, saying how. `what` names the thing and what it should hold."""
    extra, missing = sorted(set(found) - set(expected)), sorted(set(expected) - set(found))
    if extra:
        fail(f"{what}: there is also {', '.join(extra)}")
    if missing:
        fail(f"{what}: missing {', '.join(missing)}")


# ---- The source distribution ----------------------------------------------------------------------------------------


def build_sdist(folder: Path) -> Path:
    call(sys.executable, "-m", "build", "--sdist", "--outdir", folder, ROOT)
    return folder / f"{STEM}.tar.gz"


def check_sdist(sdist: Path) -> list[str]:
    """That it holds the tracked files of the allow-list and no others; returns their names."""
    patterns = [
        f":(top,glob){pattern.lstrip('/')}" for pattern in PYPROJECT["tool"]["scikit-build"]["sdist"]["include"]
    ]
    tracked = call("git", "ls-files", "-z", "--", *patterns).split("\0")[:-1]
    with tarfile.open(sdist) as archive:
        names = [name.removeprefix(f"{STEM}/") for name in archive.getnames()]
    compare("the source distribution, of the tracked files in sdist.include", names, [*tracked, "PKG-INFO"])
    return tracked


# ---- The wheel ------------------------------------------------------------------------------------------------------


def build_wheel(sdist: Path, folder: Path) -> Path:
    """From the unpacked source distribution, in a folder whose name has a space."""
    sources = folder / "the sources"
    shutil.unpack_archive(sdist, sources)
    call(sys.executable, "-m", "build", "--wheel", "--outdir", folder / "built", sources / STEM, cwd=folder)
    (built,) = (folder / "built").glob("*.whl")
    return built


def repair(built: Path, folder: Path) -> Path:
    """Give it the oldest manylinux tag that its symbols allow."""
    tools = os.environ | {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"}
    call(sys.executable, "-m", "auditwheel", "show", built, cwd=folder, env=tools)
    call(sys.executable, "-m", "auditwheel", "repair", "--wheel-dir", folder / "repaired", built, cwd=folder, env=tools)
    (wheel,) = (folder / "repaired").glob("*.whl")
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    if not re.fullmatch(rf"{STEM}-{python}-{python}-(manylinux\w+\.?)+\.whl", wheel.name):
        fail(f"{wheel.name}: not the name of a manylinux wheel for {python}")
    return wheel


def check_wheel(wheel: Path, tracked: list[str], folder: Path) -> None:
    """That it holds the package, its licences and nothing else, and an extension that needs nothing else."""
    package = [name.removeprefix("python/") for name in tracked if name.startswith("python/stiction/")]
    extension = f"stiction/_core{sysconfig.get_config_var('EXT_SUFFIX')}"
    about = ["METADATA", "WHEEL", "RECORD", "entry_points.txt", *(f"licenses/{n}" for n in PROJECT["license-files"])]
    with zipfile.ZipFile(wheel) as archive:
        names = [name for name in archive.namelist() if not name.endswith("/")]
        compare(
            "the wheel, of the package and its licences",
            names,
            [*package, extension, *(f"{STEM}.dist-info/{name}" for name in about)],
        )
        check_metadata(archive.read(f"{STEM}.dist-info/METADATA"))
        check_extension(Path(archive.extract(extension, folder)))


def check_metadata(text: bytes) -> None:
    said = email.message_from_bytes(text)
    for field, key in (
        ("Name", "name"),
        ("Version", "version"),
        ("Requires-Python", "requires-python"),
        ("License-Expression", "license"),
    ):
        if said[field] != PROJECT[key]:
            fail(f"the metadata say {field}: {said[field]}, pyproject.toml {PROJECT[key]}")


def check_extension(extension: Path) -> None:
    dynamic = call("readelf", "--wide", "--dynamic", extension)
    needed = re.findall(r"\(NEEDED\).*\[(.*)\]", dynamic)
    foreign = [library for library in needed if not SYSTEM_LIBRARY.fullmatch(library)]
    if foreign or not needed:
        fail(f"the extension needs {', '.join(foreign) or 'no library at all'}")
    if re.search(r"\((RPATH|RUNPATH)\)", dynamic):
        fail("the extension looks for libraries in a folder of its own")
    exported = [line.split()[0] for line in call("nm", "-D", "--defined-only", "-P", extension).splitlines()]
    compare("symbols that the extension exports", exported, ["PyInit__core"])


# ---- Where it is installed ------------------------------------------------------------------------------------------


class Elsewhere:
    """A new environment where neither this tree nor compilers, Eigen or GSL can be seen."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.bin = folder / "environment/bin"
        tools = folder / "tools"
        tools.mkdir()
        for name in ("sh", "cat", "setsid", "mount", "umount"):  # what the tests use
            if found := shutil.which(name):
                (tools / name).symlink_to(found)
        kept = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "VIRTUAL_ENV"))}
        self.environment = kept | {"PATH": f"{self.bin}{os.pathsep}{tools}"}
        self.mounts = self.hides()
        call(sys.executable, "-m", "venv", folder / "environment")

    def hides(self) -> bool:
        """Whether mounts can hide; they need root, and are seen by nobody else."""
        able = os.geteuid() == 0 and shutil.which("unshare") is not None
        return able and subprocess.run(["unshare", "--mount", "true"], check=False, capture_output=True).returncode == 0

    def hiding(self) -> str:
        """Shell commands that hide folders under empty ones, and programs and libraries under /dev/null."""
        folders = [ROOT, *map(Path, ("/usr/include", "/usr/local/include", "/usr/share/eigen3", "/usr/lib/gcc"))]
        programs = [
            program
            for place in {*SYSTEM_PATH, *map(Path, os.environ["PATH"].split(os.pathsep))}
            if place.is_dir()
            for program in place.iterdir()
            if COMPILER.fullmatch(program.name)
        ]
        libraries = [path for place in ("/usr/lib", "/usr/local/lib") for path in Path(place).rglob("libgsl*")]
        files = {path.resolve() for path in (*programs, *libraries) if path.is_file()}
        mount = shutil.which("mount")
        lines = [f"{mount} -t tmpfs none {shlex.quote(str(path))}" for path in folders if path.is_dir()]
        lines += [f"{mount} --bind /dev/null {shlex.quote(str(path))}" for path in sorted(files)]
        return "\n".join(["set -e", *lines, 'exec "$@"'])

    def call(self, *command: str | Path, cwd: Path | None = None, quiet: bool = True) -> str:
        unshare, shell = shutil.which("unshare") or "", shutil.which("sh") or ""
        hidden = (unshare, "--mount", "--propagation", "private", shell, "-c", self.hiding(), shell)
        within = hidden if self.mounts else ()
        return call(*command, cwd=cwd or self.folder, env=self.environment, quiet=quiet, within=within)

    def check_hidden(self) -> None:
        """That nothing is seen here of what is seen outside."""
        system = os.pathsep.join(map(str, SYSTEM_PATH))
        if self.mounts:
            seen_outside = call(sys.executable, "-c", LOOK, system, "/usr").splitlines()
            for part in ("c++", "cmake", "libgsl.a", "gsl_version.h", "Eigen/Core"):
                if not any(path.endswith(part) for path in seen_outside):
                    fail(f"no {part} was found here, so that hiding it shows nothing")
            seen = self.call(self.bin / "python", "-I", "-c", LOOK, system, "/usr", "/opt", ROOT)
        else:
            seen = self.call(self.bin / "python", "-I", "-c", LOOK, "")
        if seen:
            fail(f"these are not hidden: {', '.join(seen.split())}")

    def install(self, *wanted: str) -> None:
        """From wheels alone, so that nothing is compiled."""
        pip = (self.bin / "python", "-m", "pip", "install", "--quiet", "--disable-pip-version-check")
        self.call(*pip, "--only-binary=:all:", *wanted)

    def check_installed(self) -> None:
        """That it is the wheel that is imported."""
        code = "import stiction, stiction._core as core; print(stiction.__version__, stiction.__file__, core.__file__)"
        version, *files = self.call(self.bin / "python", "-I", "-c", code).split()
        for file in files:
            if self.folder / "environment" not in Path(file).parents:
                fail(f"{file} is imported, which is not the installed wheel")
        if version != PROJECT["version"]:
            fail(f"version {version} is imported, not {PROJECT['version']}")

    def run_quick(self) -> None:
        self.call(self.bin / "stiction", "run", "quick", "--output", "quick")
        for name in ("result.zarr", "area.png"):
            if not (self.folder / "quick" / name).exists():
                fail(f"stiction run quick wrote no {name}")

    def run_tests(self, sdist: Path) -> None:
        """The tests of the source distribution, without its sources."""
        shutil.unpack_archive(sdist, self.folder / "tests")
        sources = self.folder / "tests" / STEM
        for part in ("python", "cpp"):
            shutil.rmtree(sources / part)
        self.call(self.bin / "python", "-I", "-m", "pytest", "-q", "-p", "no:cacheprovider", cwd=sources, quiet=False)


def main() -> None:
    # The times of files in the archives are those of the commit, so that they can be built again.
    os.environ["SOURCE_DATE_EPOCH"] = call("git", "log", "-1", "--format=%ct").strip()
    shutil.rmtree(DIST, ignore_errors=True)
    with tempfile.TemporaryDirectory(prefix="stiction-wheel-") as temporary:
        folder = Path(temporary).resolve()
        say("building the source distribution")
        sdist = build_sdist(folder)
        tracked = check_sdist(sdist)
        say(f"{sdist.name}: the {len(tracked)} tracked files that it should hold, {sdist.stat().st_size / 1000:.0f} kB")
        say("building the wheel from it")
        wheel = repair(build_wheel(sdist, folder), folder)
        check_wheel(wheel, tracked, folder)
        call(sys.executable, "-m", "twine", "check", "--strict", sdist, wheel)
        say(f"{wheel.name}: the package alone, {wheel.stat().st_size / 1000:.0f} kB; no foreign library or symbol")
        elsewhere = Elsewhere(folder)
        elsewhere.check_hidden()
        by = "a mount namespace and PATH" if elsewhere.mounts else "PATH alone"
        say(f"installing it where neither compilers nor Eigen nor GSL are seen, hidden by {by}")
        elsewhere.install(str(wheel))
        elsewhere.check_installed()
        say("stiction run quick")
        elsewhere.run_quick()
        say("the tests of the source distribution")
        elsewhere.install(f"{wheel}[test]")
        elsewhere.check_installed()
        elsewhere.run_tests(sdist)
        DIST.mkdir(parents=True)
        for made in (sdist, wheel):
            shutil.copy(made, DIST)
            say(f"{(DIST / made.name).relative_to(ROOT)}")


if __name__ == "__main__":
    main()
