"""Commands `stiction run`, which computes a study, and `stiction studies`, which lists built-in studies."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction._units import short_repr
from stiction.cli.application import command, print_output
from stiction.cli.options import PartOption, SchedulerOption, VerboseOption, WorkersOption, option

if TYPE_CHECKING:
    from stiction.study.study import Study


ChangesOption = Annotated[
    list[str] | None, option("--set KEY=VALUE", "Change a value, such as ensemble.repetitions=10. Repeatable.")
]


@command(
    "run",
    "stiction run quick",
    "stiction run mine.toml --output results --workers 2",
    "stiction run figure6 --set ensemble.repetitions=10 \\",
    "    --set 'contact.effective_modulus=70 GPa' --output stiffer",
    "stiction run pair --set ensemble.repetitions=64  # more positions of a pair",
)
def run_study_command(
    study: Annotated[
        str, typer.Argument(metavar="STUDY", help="Built-in study, study file (TOML), or directory of a result.")
    ],
    output: Annotated[Path | None, option("--output -o DIR", "Directory for the results.", "./NAME")] = None,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    part: PartOption = None,
    overrides: ChangesOption = None,
    verbose: VerboseOption = False,
) -> None:
    """Compute a study, draw its figures and print its friction at a few loads.

    Repetitions (for a pair, positions) that already exist in the output directory are kept.
    """
    from stiction.cli.execution import compute_result_in_directory, open_executor, parse_part
    from stiction.cli.result_output import print_result, write_figures
    from stiction.study.values import MAX_LISTED_FAULTS, StudyError

    chosen_study, directory = _load_study(study)
    try:
        chosen_study = chosen_study.with_changes(parse_overrides(overrides or []))
    except StudyError as error:
        lines = [f"--set {key}: {reason}" if key else f"--set {reason}" for key, reason in error.faults]
        raise StudyError("\n".join(lines[:MAX_LISTED_FAULTS]), error.faults) from None
    directory = directory if output is None else output
    part_number = parse_part(part)
    with open_executor(workers, scheduler) as executor:
        result = compute_result_in_directory(chosen_study, directory, executor, part=part_number)
    if part_number is None:
        print_output("")
        print_result(result, verbose=verbose)
        print_output("")
        write_figures(result, directory)


@command("studies", "stiction studies", "stiction studies figure6 > mine.toml", "stiction studies --keys")
def studies(
    name: Annotated[str | None, typer.Argument(metavar="NAME", help="Study to print.", show_default=False)] = None,
    keys: Annotated[bool, option("--keys", "List the keys of study files: defaults, values and meanings.")] = False,
) -> None:
    """List the built-in studies, print one as a study file, or list the keys of study files."""
    from stiction.study.study import Study, read_study_description, study_names
    from stiction.study.values import StudyError
    from stiction.views.layout import wrap_text
    from stiction.views.study_keys import study_keys_text

    if keys:
        if name is not None:
            raise StudyError(f"--keys must not be combined with the name of a study, got {short_repr(name)}")
        print_output(study_keys_text())
        return
    if name is not None:
        print_output(Study.named(name).to_toml())
        return
    names = study_names()
    width = max(map(len, names)) + 2
    for name in names:
        print_output(wrap_text(f"{name:<{width}}{read_study_description(name)}", hanging_indent=" " * width))


def _load_study(text: str) -> tuple[Study, Path]:
    """Load a study by its name, or from a file or a directory, and return it with its default result directory."""
    from stiction.study.study import Study, study_names
    from stiction.study.values import StudyError

    if text in study_names():
        return Study.named(text), Path(text)
    path = Path(text)
    if (path / "study.toml").is_file():
        return Study.from_toml(path / "study.toml"), path
    if path.suffix or path.exists() or len(path.parts) > 1:
        # If the directory of a study file contains a result, the result belongs to the study and is continued.
        return Study.from_toml(path), path.parent if (path.parent / "blocks").is_dir() else Path(path.stem)
    try:
        return Study.named(text), path
    except StudyError as error:
        suggestions = difflib.get_close_matches(text, study_names(), n=1)
        raise StudyError(f"{error}" + (f"; did you mean {suggestions[0]}?" if suggestions else "")) from None


def parse_overrides(assignments: list[str]) -> dict[str, Any]:
    """Parse the assignments KEY=VALUE of the option `--set`, and return a dict of the values, keyed by KEY."""
    from stiction.study.values import StudyError

    overrides = {}
    for assignment in assignments:
        study_key, equals_sign, value = assignment.partition("=")
        if not equals_sign or not study_key.strip():
            raise StudyError(f"--set must be KEY=VALUE, such as ensemble.repetitions=10, got {short_repr(assignment)}")
        overrides[study_key.strip()] = _parse_toml_value(value.strip())
    return overrides


def _parse_toml_value(text: str) -> Any:
    """Parse a TOML value.

    A text that is not TOML is returned unchanged, so that quantities need no quotes.
    """
    from stiction.study.values import parse_toml

    try:
        parsed_value = parse_toml(f"value = {text}")
    except ValueError:
        return text
    return parsed_value["value"] if len(parsed_value) == 1 else text
