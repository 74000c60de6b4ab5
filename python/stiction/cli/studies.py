"""Commands on studies: run and studies."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Annotated, Any

import typer

from stiction._units import short_repr
from stiction.cli.application import command, tell
from stiction.cli.execution import Part, Scheduler, Workers
from stiction.cli.options import Verbose, option
from stiction.studies.study import Study, study_names, study_summary
from stiction.studies.values import MAX_LISTED_FAULTS, StudyError, toml

Changes = Annotated[
    list[str] | None, option("--set KEY=VALUE", "Change a value, as in ensemble.repetitions=10. Repeatable.")
]


@command(
    "run",
    "stiction run quick",
    "stiction run mine.toml --output results --workers 2",
    "stiction run figure6 --set ensemble.repetitions=10 \\",
    "    --set 'contact.effective_modulus=70 GPa' --output stiffer",
    "stiction run pair --set ensemble.repetitions=64       # more of a pair",
)
def run_command(
    study: Annotated[
        str, typer.Argument(metavar="STUDY", help="A built-in study, a study file (TOML), or a folder with a result.")
    ],
    output: Annotated[Path | None, option("--output -o DIR", "Where the results go.", "./NAME")] = None,
    workers: Workers = None,
    scheduler: Scheduler = None,
    part: Part = None,
    changes: Changes = None,
    verbose: Verbose = False,
) -> None:
    """Compute a study, or what is missing of it, draw it, and print its friction at a few loads; or one part of it."""
    from stiction.cli.execution import executor_of, fill_folder, part_of
    from stiction.cli.result_output import draw_result, show_result

    what, directory = _study(study)
    try:
        what = what.with_changes(changes_of(changes or []))
    except StudyError as error:
        lines = [f"--set {key}: {why}" if key else f"--set {why}" for key, why in error.faults]
        raise StudyError("\n".join(lines[:MAX_LISTED_FAULTS]), error.faults) from None
    directory = directory if output is None else output
    which = part_of(part)
    with executor_of(workers, scheduler) as executor:
        stored = fill_folder(what, directory, executor, part=which)
    if which is None:
        tell("")
        show_result(stored, command="run", verbose=verbose)
        tell("")
        draw_result(stored, directory)


@command("studies", "stiction studies", "stiction studies figure6 > mine.toml", "stiction studies --keys")
def studies(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="The study to print.", show_default=False)] = None,
    keys: Annotated[bool, option("--keys", "List the keys of study files: defaults, values and meanings.")] = False,
) -> None:
    """List the built-in studies, or print one as a study file, or list the keys of study files."""
    if keys:
        from stiction.views.study_keys import study_keys_text

        if name is not None:
            raise StudyError(f"--keys lists the keys of all studies, got {short_repr(name)}")
        tell(study_keys_text())
        return
    if name is not None:
        tell(Study.named(name).to_toml())
        return
    from stiction.views.text import fitted

    names = study_names()
    width = max(map(len, names)) + 2
    for each in names:
        tell(fitted(f"{each:<{width}}{study_summary(each)}", hang=" " * width))


def _study(text: str) -> tuple[Study, Path]:
    """The study to run, and where its results go by default."""
    if text in study_names():
        return Study.named(text), Path(text)
    path = Path(text)
    if (path / "study.toml").is_file():
        return Study.from_toml(path / "study.toml"), path
    if path.suffix or path.exists() or len(path.parts) > 1:
        # A study file in a folder of results goes on there.
        return Study.from_toml(path), path.parent if (path.parent / "blocks").is_dir() else Path(path.stem)
    try:
        return Study.named(text), path
    except StudyError as error:
        near = difflib.get_close_matches(text, study_names(), n=1)
        raise StudyError(f"{error}" + (f"; did you mean {near[0]}?" if near else "")) from None


def changes_of(assignments: list[str]) -> dict[str, Any]:
    """The changes that `--set` stands for, by dotted key."""
    changes = {}
    for assignment in assignments:
        key, equals, value = assignment.partition("=")
        if not equals or not key.strip():
            raise StudyError(f"--set needs KEY=VALUE, as in ensemble.repetitions=10, got {short_repr(assignment)}")
        changes[key.strip()] = _value(value.strip())
    return changes


def _value(text: str) -> Any:
    """A TOML value; anything else is a string, so that quantities need no quotes of their own."""
    try:
        parsed = toml(f"value = {text}")
    except ValueError:
        return text
    return parsed["value"] if len(parsed) == 1 else text
