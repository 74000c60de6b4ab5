"""Output of results to files, whose extensions select the formats."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._arguments import convert_friction_parameters, split_texts
from stiction._errors import ArgumentError
from stiction._files import check_creatable, check_replaceable, create_file_atomically, replace_file_atomically
from stiction._number_format import format_with_unit
from stiction._text import printable_path
from stiction._units import loads_to_core_units, short_repr
from stiction.summary.evaluation import Evaluation
from stiction.summary.joint_table import DEFAULT_JOINT_UNITS, JointTable, JointUnits, UnitSystem
from stiction.summary.summary import Summary
from stiction.views.joint import abaqus_card, ansys_card, joint_csv, joint_json, liggghts_card
from stiction.views.latex import latex_table
from stiction.views.rows import summary_table
from stiction.views.sentence import quotable_sentences
from stiction.views.shear import shear_parameters_csv, shear_parameters_json
from stiction.views.spreadsheet import frame_to_csv
from stiction.views.style import FIGURE_FILE_SIGNATURES

if TYPE_CHECKING:
    import xarray

RESULT_TABLE_NAME = "result.csv"
REPORT_FILE_SIGNATURE = "<!doctype html>\n<!-- A report of stiction -->\n"
"""First bytes of every report, by which the program recognizes a file that it may replace."""

OUTPUT_FILE_SIGNATURES = {
    RESULT_TABLE_NAME: b"coefficient of static friction: lower",
    "report.html": REPORT_FILE_SIGNATURE.encode(),
    "friction.png": FIGURE_FILE_SIGNATURES[".png"],
}
"""Names of the files that `pair` writes into its directory, each with bytes that identify output of `pair`."""


def check_all_replaceable(directory: Path, file_marks: Mapping[str, bytes]) -> None:
    """Raise a `ValueError` if a file that would be replaced exists, but was not written by stiction.

    Files of stiction contain the mark that `file_marks` lists for their name.
    """
    for name, file_mark in file_marks.items():
        check_replaceable(directory / name, file_mark, ValueError)


def replace_text_file(path: Path, text: str, file_mark: bytes) -> None:
    """Write a text file; if a file of this name exists, replace it only if it contains `file_mark`.

    Raises a `ValueError` if the existing file lacks the mark.
    """
    with replace_file_atomically(path, file_mark, ValueError) as partial_path:
        partial_path.write_text(text, encoding="utf-8")


def write_new_text_file(path: Path, text: str) -> None:
    """Write a text file, or raise a `ValueError` if the file exists or cannot be written."""
    with create_file_atomically(path, ValueError) as partial_path:
        partial_path.write_text(text, encoding="utf-8")


def summary_csv(summary: Summary) -> str:
    """Return the summary of a result as CSV, with columns for friction coefficients and for other quantities."""
    return frame_to_csv(summary_table(summary))


def result_csv(result: Evaluation) -> str:
    """Return a result at the loads of its study as CSV, with columns for friction coefficients and other quantities."""
    return summary_csv(result.complete_summary())


EXPORT_WRITERS: dict[str, tuple[str, Callable[[Evaluation, Path], None]]] = {
    ".nc": ("the whole result", Evaluation.to_netcdf),
    ".csv": ("a table", lambda result, path: write_new_text_file(path, result_csv(result))),
    ".tex": ("a LaTeX table", lambda result, path: write_new_text_file(path, latex_table(result.summary()))),
}
"""Description and writer of each format in which a result can be written, by file name extension."""

TABLE_FORMATS: dict[str, tuple[str, Callable[[Summary], str]]] = {
    ".csv": ("a table", summary_csv),
    ".tex": ("a LaTeX table", latex_table),
}
"""Formats of a table at given loads: description and function that writes the table, by file name extension."""


CARD_FORMATS: dict[str, tuple[str, Callable[[JointTable, str], str]]] = {
    ".inp": ("Abaqus and CalculiX", abaqus_card),
    ".mac": ("Ansys", ansys_card),
    ".liggghts": ("LIGGGHTS", liggghts_card),
}
"""Input cards of other programs: name of the program and function that writes the card, by file name extension."""

JOINT_TABLE_FORMATS: dict[str, tuple[str, Callable[[Sequence[JointTable], Sequence[str]], str]]] = {
    ".csv": ("a table", lambda tables, _: joint_csv(tables)),
    ".json": ("a table", joint_json),
}
"""Formats of joint tables, by extension: description, and function that formats tables for several mu0 and tau0.

The arguments of the function are the tables and, for each table, a sentence on the pair.
"""

JOINT_FORMAT_DESCRIPTIONS = {
    extension: description for extension, (description, _) in (JOINT_TABLE_FORMATS | CARD_FORMATS).items()
}


def write_result(result: Evaluation, path: Path) -> None:
    """Write a result to a new file.

    The file extension selects the format.

    Raises a `ValueError` if the file exists, if it cannot be written, or if the extension is not in `EXPORT_WRITERS`.
    """
    check_file_extension(
        path,
        {extension: description for extension, (description, _) in EXPORT_WRITERS.items()}
        | {extension: f"a card for {program}" for extension, (program, _) in CARD_FORMATS.items()},
    )
    EXPORT_WRITERS[path.suffix.lower()][1](result, path)


def write_table_at(result: Evaluation, path: Path, *, load: Any, mu0: Any, tau0: Any) -> None:
    """Write results at given loads, mu0 and tau0 as a table to a new file, in a format of `TABLE_FORMATS`.

    Raises a `ValueError` as `write_result` does.
    """
    check_file_extension(path, {extension: description for extension, (description, _) in TABLE_FORMATS.items()})
    check_creatable(path, ValueError)
    write_new_text_file(path, TABLE_FORMATS[path.suffix.lower()][1](result.summary(load, mu0=mu0, tau0=tau0)))


def write_joint_table(
    result: Evaluation, path: Path, units: UnitSystem = DEFAULT_JOINT_UNITS, *, load: Any = None, mu0: Any = None,
    tau0: Any = None, closure_from: Any = None,
) -> None:  # fmt: skip
    """Write joint tables (one for each mu0 and tau0) to a new file, or one table as an input card for another program.

    `load` contains the loads of the tables, by default all. A card contains all loads; `load` is the load of the
    coefficient and stiffnesses that a card contains once. `closure_from` is the load from which the closure is counted,
    by default 0 (first contact). Raises a `ValueError` as `write_result` does, if the result has no joint table, or if
    there are several loads, mu0 or tau0 for a card.
    """
    check_joint_file(path, units)
    mu0_values, tau0_values = choose_joint_parameters(result, path, mu0, tau0)
    loads = {"reference_load": choose_card_load(result, load)} if is_card(path) else {"load": load}
    tables = [
        result.joint_table(mu0=mu0_value, tau0=tau0_value, units=units, closure_from=closure_from, **loads)
        for mu0_value in mu0_values
        for tau0_value in tau0_values
    ]
    sentences = [
        quotable_sentences(result.summary([table.reference.load], mu0=table.mu0, tau0=table.tau0))[0]
        for table in tables
    ]
    extension = path.suffix.lower()
    text = (
        CARD_FORMATS[extension][1](tables[0], sentences[0])
        if is_card(path)
        else JOINT_TABLE_FORMATS[extension][1](tables, sentences)
    )
    write_new_text_file(path, text)


def choose_joint_parameters(
    result: Evaluation, path: Path, mu0: Any = None, tau0: Any = None
) -> tuple[list[float], list[float]]:
    """Return the mu0 and tau0 (GPa) for a joint file: those that the caller gives or, by default, all in the study.

    Raises a `ValueError` if a card would have several mu0 or tau0.
    """
    friction = result.study.friction
    mu0_values, tau0_values = (
        np.atleast_1d(study_values if values is None else values).astype(float).tolist()
        for values, study_values in zip(
            convert_friction_parameters(mu0, tau0), (friction.mu0, friction.tau0), strict=True
        )
    )
    for name, values, unit in (("mu0", mu0_values, "1"), ("tau0", tau0_values, "GPa")):
        if is_card(path) and result.study.is_measured and len(values) > 1:
            raise ArgumentError(
                f"{{{name}}} must be a single value for a card, which has one coefficient per pressure; choose one of "
                f"{', '.join(format_with_unit(value, unit) for value in values)}"
            )
    return mu0_values, tau0_values


def choose_card_load(result: Evaluation, load: Any = None) -> float | None:
    """Return the one load (mN) for which an input card states the friction coefficient and the stiffnesses.

    The load is the given load or, by default, the load of the study. For generated surfaces, which have no card, the
    result is None.

    Raises a `ValueError` if there are several loads or none.
    """
    area = result.nominal_area
    if area is None or not result.study.is_measured:
        return None
    given_loads = result.default_loads if load is None else loads_to_core_units("load", split_texts("load", load), area)
    if not np.size(given_loads):
        raise ArgumentError("{load} must have at least one value, got {got}", got=short_repr(load))
    loads = np.unique(given_loads).tolist()
    if len(loads) != 1:
        pressures = [format_with_unit(value / area, "GPa") for value in loads]
        raise ArgumentError(
            "{load} must be a single load for a card, which has one tangential stiffness for all pressures; choose one "
            f"of {', '.join(pressures)}"
        )
    return float(loads[0])


SHEAR_PARAMETER_FORMATS = {".csv": ("a table", shear_parameters_csv), ".json": ("a table", shear_parameters_json)}
"""Formats of the joint-model parameters of a shear test, by extension: description and formatting function."""


def write_shear_parameters(test: xarray.Dataset, path: Path, units: UnitSystem = DEFAULT_JOINT_UNITS) -> None:
    """Write parameters for joint models, computed from a shear test, to a new file (`SHEAR_PARAMETER_FORMATS`).

    Raises a `ValueError` as `write_result` does.
    """
    check_file_extension(
        path, {extension: description for extension, (description, _) in SHEAR_PARAMETER_FORMATS.items()}
    )
    write_new_text_file(path, SHEAR_PARAMETER_FORMATS[path.suffix.lower()][1](test, units))


def check_joint_file(path: Path, units: UnitSystem = DEFAULT_JOINT_UNITS) -> None:
    """Check the file name and the units of a joint table before the table is computed.

    Raises the same errors as `write_joint_table`.
    """
    check_file_extension(path, JOINT_FORMAT_DESCRIPTIONS)
    JointUnits.parse(units)
    check_creatable(path, ValueError)


def is_card(path: Path) -> bool:
    """Return whether a file has the extension of an input card for another program."""
    return path.suffix.lower() in CARD_FORMATS


def check_file_extension(path: Path, descriptions: Mapping[str, str]) -> None:
    """Raise a `ValueError` if a file name ends in none of the extensions that `descriptions` lists."""
    if path.suffix.lower() not in descriptions:
        allowed_extensions = " or ".join(f"{extension} ({text})" for extension, text in descriptions.items())
        raise ValueError(f"{printable_path(path)}: the file name must end in {allowed_extensions}")
