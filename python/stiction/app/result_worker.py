"""What the server is told of a result by a process of its own: the answer, and what can be saved, as files."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from stiction.app.jobs import FAULTS, without_paths
from stiction.studies.pair import Pair
from stiction.studies.pair_options import OPTIONS, name_on_command_line
from stiction.studies.result import Result, open_result
from stiction.studies.runner import first_result
from stiction.studies.study import Study
from stiction.views.files import result_csv
from stiction.views.report import report_page
from stiction.views.rows import answer_record, record_text


def first_study(files: list[Path], options: list[tuple[str, str]]) -> Study | None:
    """The study of a first answer, by asperities, of what a command line of `pair` would ask for with these options."""
    fields = {name_on_command_line(name): name for name in OPTIONS}
    values: dict[str, list[str]] = {}
    for flag, text in options:
        values.setdefault(fields[f"--{flag}"], []).append(text)
    chosen = {name: texts if OPTIONS[name].is_repeatable else texts[0] for name, texts in values.items()}
    return Pair.of(upper=files[0], lower=files[1], **chosen).first_study


def main() -> None:
    """Print the answer of a result, and of how many members; write its page, and at last the rest.

    The argument is JSON: `folder` of the result, or `first` with the scans and options of which a first answer is
    wanted; `name`, the `command` whose last answer it is, `files` for a folder to write, and the private `root`.
    """
    asked = json.loads(sys.argv[1])
    try:
        if "first" in asked:
            study = first_study([Path(each) for each in asked["first"][0]], asked["first"][1])
            result = None if study is None else first_result(study)
        else:
            result = open_result(asked["folder"])
        print(json.dumps(None if result is None else _told(result, asked)))
    except FAULTS as error:
        sys.exit(f"stiction: {error or 'there is not enough memory for this'}")


def _told(result: Result, asked: dict[str, Any]) -> dict[str, Any]:
    command = asked["command"]
    answer = answer_record(result.summary().first)
    texts = {"page.html": report_page(result, name=asked["name"])}
    if result.path is not None and command:
        texts |= {
            "result.json": record_text(command, result.summary()),
            "result.csv": result_csv(result),
            "study.toml": (result.path / "study.toml").read_text("utf-8"),
        }
    files = Path(asked["files"])
    files.mkdir(parents=True)
    for name, text in texts.items():
        (files / name).write_text(without_paths(text, asked["root"]), "utf-8", "replace")
    return {"answer": answer, "finished": int(result.members.size), "total": result.study.ensemble.repetitions}


if __name__ == "__main__":
    main()
