"""What the server is told of a result by a process of its own: the answer, and what can be saved, as files."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from stiction.app.jobs import FAULTS, without_paths
from stiction.studies.pair import Pair
from stiction.studies.result import Result, open_result
from stiction.studies.runner import first_result
from stiction.studies.study import Study
from stiction.views.answer import headlines
from stiction.views.files import result_csv
from stiction.views.report import report_page
from stiction.views.rows import answer_record, record_text

_ARGUMENTS = {"upper": "upper_material", "lower": "lower_material", "adhesion": "work_of_adhesion"}
"""Arguments of `Pair` that are called otherwise than their options."""

_REPEATED = ("load", "unit", "spacing", "channel", "columns", "missing_value", "accept", "tip")
"""Arguments whose options may be given more than once."""


def first_study(files: list[Path], options: list[tuple[str, str]]) -> Study | None:
    """The study of a first answer, by asperities, of what a command line of `pair` would ask for with these options."""
    given: dict[str, Any] = {}
    for name, text in options:
        given.setdefault(_ARGUMENTS.get(name, name.replace("-", "_")), []).append(text)
    asked = {name: each if name in _REPEATED else each[0] for name, each in given.items()}
    asked |= {name: kind(asked[name]) for name, kind in (("shifts", int), ("rotate", float)) if name in asked}
    return Pair(upper=files[0], lower=files[1], **asked).first_study


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
    at, study, command = result.at_study_loads, result.study, asked["command"]
    answer = answer_record(headlines(result.answers)[0])
    texts = {"page.html": report_page(result, name=asked["name"])}
    if result.path is not None and command:
        about: Any = {"beside": result.input_caveats, "over": result.over_cut_offs, "onset": result.onset}
        texts |= {
            "result.json": record_text(command, at, study, **about),
            "result.csv": result_csv(result),
            "study.toml": (result.path / "study.toml").read_text("utf-8"),
        }
    files = Path(asked["files"])
    files.mkdir(parents=True)
    for name, text in texts.items():
        (files / name).write_text(without_paths(text, asked["root"]), "utf-8", "replace")
    return {"answer": answer, "finished": int(result.members.size), "total": study.ensemble.repetitions}


if __name__ == "__main__":
    main()
