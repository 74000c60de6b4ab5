"""`stiction app`: a page on this computer where two scans are dropped."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from stiction.cli.application import command, say

if TYPE_CHECKING:
    from stiction.studies.study import Study


@command("app", "stiction app", "stiction app --demo")
def app(
    demo: Annotated[bool, typer.Option("--demo", help="Begin with two surfaces of its own.")] = False,
    keep: Annotated[bool, typer.Option("--keep", help="Go on when no window is open any more.")] = False,
) -> None:
    """Open a page in the browser: drop two scans, and see their friction.

    It answers to this computer alone, sends nothing anywhere, and ends 90 seconds after its last window was closed.
    """
    try:
        from stiction.app.run import run
    except ImportError:
        raise ValueError('app needs the packages starlette and uvicorn: pip install "stiction[app]"') from None
    run(say=say, first_study=first_study, keep=keep, demo=demo)


def first_study(files: list[Path], options: list[tuple[str, str]]) -> Study | None:
    """The study of a first answer, by asperities, of what a command line of `pair` would ask for with these options."""
    from stiction.studies.pair import Pair

    given: dict[str, Any] = {}
    for name, text in options:
        given.setdefault({"upper": "upper_material", "lower": "lower_material"}.get(name, name), []).append(text)
    asked = {name: each if name in ("load", "unit", "spacing") else each[0] for name, each in given.items()}
    asked |= {name: kind(asked[name]) for name, kind in (("shifts", int), ("rotate", float)) if name in asked}
    return Pair(upper=files[0], lower=files[1], **asked).first_study
