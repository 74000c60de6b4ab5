"""`stiction claims`: what the paper claims, judged by its own studies."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import Annotated, Any

from stiction.cli.application import command, tell
from stiction.cli.options import Json, option
from stiction.cli.running import Scheduler, Workers
from stiction.cli.studies import Changes, changes_of
from stiction.studies.study import Study

PAPERS_FIGURES = ("figure2", "figure3", "figure5", "figure6", "figure7", "figure8")
"""Studies of the paper's."""


@command("claims", "stiction claims", "stiction claims --json > claims.json")
def claims_command(
    output: Annotated[Path, option("--output -o", "DIR", "Where the results go.")] = Path("claims"),
    repetitions: Annotated[
        int | None,
        option("--repetitions", "N", "Judge on this many repetitions as well.", "100, the paper's", least=20),
    ] = None,
    columns: Annotated[
        bool,
        option(
            "--columns", None, "Judge areas, half-planes and half-spaces too, on a fraction of the repetitions each."
        ),
    ] = False,
    workers: Workers = None,
    scheduler: Scheduler = None,
    changes: Changes = None,
    as_json: Json = False,
) -> None:
    """Judge what the paper claims by its own studies, and by other choices where it leaves them open."""
    from stiction.cli.running import executor_of
    from stiction.cli.showing import said_by
    from stiction.studies import claims
    from stiction.studies.resampled import FLATTER
    from stiction.views import tables

    replaced = changes_of(changes or [])
    said = said_by(as_json)
    for name in claims.VARIANTS:
        claims.check(claims.variant_study(name).with_changes(replaced))
    others, beside = {}, {}
    with executor_of(workers, scheduler) as executor:
        for name in PAPERS_FIGURES:
            dataset = _result(Study.named(name).with_changes(replaced), output / name, executor, said, drawn=True)
            if Study.named(name) == claims.claims_study():
                result, outcomes = dataset, claims.judge(dataset)
                last = outcomes
        for name in claims.VARIANTS:
            study = claims.variant_study(name).with_changes(replaced)
            dataset = _result(study, output / "variants" / name, executor, said)
            others[name] = claims.judge(dataset)
            if name == "default":
                others["amplitude 0.05 µm"] = claims.judge(dataset, amplitude=FLATTER)
        most = result.sizes["repetition"]
        beside[f"lines, {most} repetitions"] = outcomes
        if repetitions is not None:
            most = repetitions
            study = claims.claims_study().with_changes({**replaced, "ensemble.repetitions": most})
            result = _result(study, output / "columns/lines", executor, said)
            beside[f"lines, {most} repetitions"] = last = claims.judge(result)
        beside["the same by bands"] = claims.judge(result, ruling="bands")
        del result
        for name, column in claims.COLUMNS.items() if columns else ():
            study = column.of(most)
            dataset = _result(study, output / "columns" / column.place, executor, said)
            beside[f"{name}, {study.ensemble.repetitions}"] = claims.judge(
                dataset, sliding=column.sliding, ruling="bands"
            )
    for file, text in (
        ("claims.md", tables.claims_markdown(outcomes)),
        ("variants.md", tables.variants_markdown(others)),
        ("columns.md", tables.columns_markdown(beside)),
    ):
        (output / file).write_text(text, encoding="utf-8")
        said(f"wrote {output / file}")
    tell(tables.claims_record(last) if as_json else tables.claims_text(last))


def _result(
    study: Study, directory: Path, executor: Executor, said: Callable[[str], None], *, drawn: bool = False
) -> Any:
    """The result of a study in a directory, of which what is there already is not computed again."""
    from stiction.cli.running import fill_folder
    from stiction.cli.showing import draw_result

    stored = fill_folder(study, directory, executor, said=said)
    if drawn:
        draw_result(stored, directory, said)
    return stored.dataset()
