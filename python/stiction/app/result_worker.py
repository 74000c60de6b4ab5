"""Worker process of the app: reads a result, prints its coefficients, and writes its report and other files."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from stiction._number_format import to_json
from stiction.app.form import group_option_values, replace_option_names_in_caveats
from stiction.app.jobs import REPORTED_EXCEPTIONS, hide_private_paths
from stiction.pipeline import compute_preview_result
from stiction.result import Result, open_result
from stiction.study.pair_study import MeasuredPair
from stiction.study.study import Study
from stiction.views.files import result_csv
from stiction.views.report import report_page
from stiction.views.rows import point_record, summary_json


def load_preview_study(files: list[Path], options: list[tuple[str, str]]) -> Study | None:
    """Return the study with which the app previews the result of a pair, using the asperity model.

    Returns None if there is no preview.
    """
    return MeasuredPair.from_values(upper=files[0], lower=files[1], **group_option_values(options)).preview_study


def main() -> None:
    """Print coefficients and member count of a result as JSON, and write the report and other files of the result.

    The argument is JSON: `directory` of the result, or `preview` with the scans and options of a `pair` command;
    `name`; the `command` of a final result (empty for an intermediate result); `files`, the directory to write; and the
    private directory `root`.
    """
    request = json.loads(sys.argv[1])
    try:
        if "preview" in request:
            files, options = request["preview"]
            study = load_preview_study([Path(file) for file in files], options)
            result = None if study is None else compute_preview_result(study)
        else:
            result = open_result(request["directory"])
        print(to_json(None if result is None else _write_result_files(result, request)))
    except REPORTED_EXCEPTIONS as error:
        sys.exit(f"stiction: {error or 'not enough memory for this result'}")


def _write_result_files(result: Result, request: dict[str, Any]) -> dict[str, Any]:
    command = request["command"]
    record = replace_option_names_in_caveats(point_record(result.summary().first))
    text_by_file_name = {"page.html": report_page(result, name=request["name"])}
    if result.path is not None and command:
        text_by_file_name |= {
            "result.json": summary_json(command, result.summary()),
            "result.csv": result_csv(result),
            "study.toml": (result.path / "study.toml").read_text("utf-8"),
        }
    files = Path(request["files"])
    files.mkdir(parents=True)
    for name, text in text_by_file_name.items():
        (files / name).write_text(hide_private_paths(text, request["root"]), "utf-8", "replace")
    return {"answer": record, "finished": int(result.members.size), "total": result.study.ensemble.repetitions}


if __name__ == "__main__":
    main()
