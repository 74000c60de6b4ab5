"""Check the items of the list in docs/project/releasing.md, each with a function of this script.

    python packaging/release.py                  report what is done and what is missing
    python packaging/release.py --tagged         check the tag that its workflow releases
    python packaging/release.py --address URL    write the public address of the sources into all files

The exit status is 1 if anything is missing. Only --address changes files.
"""

import argparse
import re
import sys
import tomllib
from collections.abc import Callable, Iterator

from prove import PROJECT_METADATA, ROOT, exit_with_error, run_command
from wheel import DIST_DIRECTORY, VERIFIED_COMMIT_FILE, describe_commit

VERSION = PROJECT_METADATA["version"]
RELEASE_VERSION = VERSION.removesuffix(".dev0")
"""Version of the next release."""
RELATIVE_LINK_PATTERN = re.compile(r"(?<=\]\()(?!https?:|#)([^)\s]+)(?=\))")
"""Pattern of relative links in Markdown."""

PROJECT_URL_NAMES = ("Source", "Documentation", "Issues", "Changelog")

ReleaseCheck = Callable[[], str | None]
RELEASE_CHECKS: list[tuple[str, ReleaseCheck]] = []


def register_check(item_text: str) -> Callable[[ReleaseCheck], ReleaseCheck]:
    """Return a decorator that registers a function as the check of an item in the release list.

    The check returns a description of the missing step, or None.
    """

    def register(check_function: ReleaseCheck) -> ReleaseCheck:
        RELEASE_CHECKS.append((item_text, check_function))
        return check_function

    return register


def read_file(name: str) -> str:
    return (ROOT / name).read_text(encoding="utf-8")


@register_check("the version is that of a release")
def version_problem() -> str | None:
    return None if re.fullmatch(r"\d+\.\d+\.\d+", VERSION) else f"pyproject.toml says {VERSION}"


@register_check("the changelog has it, with its date")
def changelog_date_problem() -> str | None:
    match = re.search(rf"^## {re.escape(RELEASE_VERSION)}(.*)$", read_file("CHANGELOG.md"), re.MULTILINE)
    if match is None:
        return f"CHANGELOG.md has no ## {RELEASE_VERSION}"
    if not re.fullmatch(r" \(\d{4}-\d{2}-\d{2}\)", match[1]):
        return f"## {RELEASE_VERSION}{match[1]} should read ## {RELEASE_VERSION} (YYYY-MM-DD)"
    return None


@register_check("CITATION.cff has the version, the date and the address")
def citation_problem() -> str | None:
    citation_text = read_file("CITATION.cff")
    version_heading = re.search(
        rf"^## {re.escape(RELEASE_VERSION)} \((\d.*)\)$", read_file("CHANGELOG.md"), re.MULTILINE
    )
    expected_lines = [
        f"version: {RELEASE_VERSION}",
        f"date-released: {version_heading[1] if version_heading else 'YYYY-MM-DD'}",
        "repository-code: http",
    ]
    return missing_names_message("CITATION.cff has no", (line for line in expected_lines if line not in citation_text))


@register_check("the addresses of the project are public ones")
def project_url_problem() -> str | None:
    problem = missing_names_message(
        "[project.urls] has no", (name for name in PROJECT_URL_NAMES if name not in PROJECT_METADATA["urls"])
    )
    return problem and f"{problem}: ./dev release --address URL"


@register_check("links of README.md work on PyPI")
def readme_link_problem() -> str | None:
    relative_links = RELATIVE_LINK_PATTERN.findall(read_file("README.md"))
    return (
        f"{len(relative_links)} are relative, for example {relative_links[0]}: ./dev release --address URL"
        if relative_links
        else None
    )


@register_check("the conda recipe asks for what pyproject.toml does")
def conda_recipe_problem() -> str | None:
    return missing_names_message("packaging/conda/recipe.yaml has no", missing_recipe_lines())


def missing_recipe_lines() -> Iterator[str]:
    """Yield the lines that the conda recipe lacks."""
    lines = {line.strip() for line in read_file("packaging/conda/recipe.yaml").splitlines()}
    if f'version: "{RELEASE_VERSION}"' not in lines:
        yield f'version: "{RELEASE_VERSION}"'
    python_requirement = f"python{PROJECT_METADATA['requires-python']}"
    for requirement in (python_requirement, *PROJECT_METADATA["dependencies"]):
        name, version_bound = re.fullmatch(r"([\w-]+)(>=.+)", requirement).groups()  # type: ignore[union-attr]
        expected_line = f"- {'matplotlib-base' if name == 'matplotlib' else name} {version_bound}"
        if expected_line not in lines:
            yield expected_line


@register_check("packaging/tested.txt has a version of every dependency")
def tested_versions_problem() -> str | None:
    tested_packages = {
        line.split("==")[0].lower() for line in read_file("packaging/tested.txt").splitlines() if "==" in line
    }
    required_packages = [re.split(">=", item)[0].lower() for item in PROJECT_METADATA["dependencies"]]
    return missing_names_message(
        "./dev tested, for it lacks", (name for name in required_packages if name not in tested_packages)
    )


@register_check("nothing is uncommitted")
def uncommitted_changes_problem() -> str | None:
    changed_files = run_command("git", "status", "--porcelain").splitlines()
    return f"{len(changed_files)} files are changed or new" if changed_files else None


@register_check("source distribution and wheels of this commit are built and proven, with the tests")
def wheel_problem() -> str | None:
    verification = VERIFIED_COMMIT_FILE.read_text(encoding="utf-8") if VERIFIED_COMMIT_FILE.exists() else ""
    if verification != f"{describe_commit()} with the tests\n":
        return f"./dev wheel, for {verification.strip() or 'nothing'} was proven"
    return None if list(DIST_DIRECTORY.glob("*.whl")) else f"{DIST_DIRECTORY.relative_to(ROOT)} is empty"


def find_tag_problem() -> str | None:
    tags = run_command("git", "tag", "--points-at", "HEAD").split()
    return None if f"v{VERSION}" in tags else f"git tag v{VERSION}; this commit has {', '.join(tags) or 'none'}"


def missing_names_message(description: str, missing_names: Iterator[str]) -> str | None:
    joined_names = ", ".join(missing_names)
    return f"{description} {joined_names}" if joined_names else None


def run_checks(*, is_tagged: bool) -> bool:
    """Print the state of each item in the release list, and return whether all items are done.

    The workflow of a tag builds and verifies separately, so these lines are left out for a tag.
    """
    checks = [item for item in RELEASE_CHECKS if not (is_tagged and item[1] is wheel_problem)]
    if is_tagged:
        checks.append((f"the tag v{VERSION} is on this commit", find_tag_problem))
    num_open_items = 0
    for item_text, check_function in checks:
        problem = check_function()
        num_open_items += problem is not None
        print(f"[{' ' if problem else 'x'}] {item_text}{f': {problem}' if problem else ''}")
    if not is_tagged:
        print(
            f"then: git tag --sign v{VERSION}; git push origin v{VERSION}"
            if not num_open_items
            else f"{num_open_items} are open"
        )
    return num_open_items == 0


def write_repository_address(url: str) -> None:
    """Write the address of the repository to pyproject.toml, CITATION.cff and the links in README.md."""
    if not re.fullmatch(r"https://[\w.-]+/[\w.-]+/[\w.-]+", url):
        exit_with_error(f"--address must be that of a repository, https://HOST/OWNER/NAME, got {url!r}")
    name = url.rpartition("/")[2]
    lines = [
        f'Source = "{url}"', f'Documentation = "https://{name}.readthedocs.io"', f'Issues = "{url}/issues"',
        f'Changelog = "{url}/blob/main/CHANGELOG.md"',
    ]  # fmt: skip
    project_text = read_file("pyproject.toml")
    urls_heading = re.search(r"^\[project\.urls\]\n(?:Paper = .*\n)?", project_text, re.MULTILINE)
    if urls_heading is None or tomllib.loads(project_text)["project"]["urls"].keys() & set(PROJECT_URL_NAMES):
        exit_with_error("pyproject.toml has addresses already")
    (ROOT / "pyproject.toml").write_text(
        project_text[: urls_heading.end()]
        + "".join(f"{line}\n" for line in lines)
        + project_text[urls_heading.end() :],
        encoding="utf-8",
    )
    citation = read_file("CITATION.cff").replace("type: software\n", f"type: software\nrepository-code: {url}\n", 1)
    (ROOT / "CITATION.cff").write_text(citation, encoding="utf-8")
    readme = re.sub(r"(?<=\]\()(?=[^)\s]+\.png\))(?!https?:)", f"{url}/raw/main/", read_file("README.md"))
    (ROOT / "README.md").write_text(RELATIVE_LINK_PATTERN.sub(rf"{url}/blob/main/\1", readme), encoding="utf-8")


def main() -> None:
    parser = argparse.ArgumentParser(description="Walk the list of docs/project/releasing.md.")
    parser.add_argument("--tagged", action="store_true", help="for the tag that is being released")
    parser.add_argument("--address", metavar="URL", help="write the public address of the sources where it belongs")
    options = parser.parse_args()
    if options.address:
        write_repository_address(options.address)
    elif not run_checks(is_tagged=options.tagged):
        sys.exit(1)


if __name__ == "__main__":
    main()
