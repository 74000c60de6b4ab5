"""Computation of what a result directory lacks: members and, for a measured pair, companion files and studies.

The contacts of a typical member and the onset of sliding are companion files. The cutoff study and the alternative
preparations of the scans are companion studies, each in a subdirectory.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from concurrent.futures import Executor
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from stiction._core import __version__
from stiction._files import DirectoryClaim, check_replaceable, replace_file_atomically
from stiction._text import format_duration
from stiction.companions.contact_picture import contact_picture
from stiction.companions.onset import (
    ONSET_TABLE_SIGNATURE,
    compute_onset,
    estimate_onset_time,
    format_backbone_csv,
    import_fit_packages,
    load_stored_onset,
)
from stiction.companions.resolution import find_cutoff_study
from stiction.evaluate.load_range import has_only_negligible_loads
from stiction.result import Result
from stiction.solve.alternative_preparations import ALTERNATIVE_LABELS, find_alternative_study
from stiction.solve.member_solution import estimate_member_time
from stiction.solve.runner import complete_blocks, compute_member_sums, compute_preview_sums, prepare_result_directory
from stiction.solve.store import (
    AREAS_BY_HARDNESS_FILE,
    CHECKSUM_PREFIX,
    CONTACT_PICTURE_FILE,
    ONSET_FILE,
    ONSET_TABLE_FILE,
    StoredResult,
    StoreError,
    export,
    import_dataset_packages,
    open_result_to_complete,
    remove_result,
)
from stiction.study.study import Study, find_section_differences, format_study_differences
from stiction.summary.input_caveats import find_alternatives

if TYPE_CHECKING:
    import xarray

LinePrintFunction = Callable[[str], Any]

MIN_ANNOUNCED_TIME = 20.0  # s

_COMPANION_FILE_SIGNATURES = {
    CONTACT_PICTURE_FILE: CHECKSUM_PREFIX,
    AREAS_BY_HARDNESS_FILE: CHECKSUM_PREFIX,
    ONSET_FILE: CHECKSUM_PREFIX,
    ONSET_TABLE_FILE: ONSET_TABLE_SIGNATURE,
}
"""Names of the companion files of a measured pair, each with bytes that identify such a file."""


def _ignore_line(_: str) -> None:
    """Ignore a line of output. Runs that print nothing receive this function instead of `print`."""


def run(
    study: Study, *, executor: Executor | None = None, store: str | Path | None = None, progress: bool = False
) -> Result:
    """Compute a study, and return its result.

    Parameters
    ----------
    study : Study
    executor : concurrent.futures.Executor, optional
        Executor that computes the repetitions, by default with one thread per core. Results are bitwise equal for all
        executors.
    store : path, optional
        Directory for the blocks of repetitions. Workers that can reach the directory write their blocks themselves. A
        directory with repetitions of the same study is resumed: finished repetitions are not computed again, and the
        number of repetitions may increase. Without a store the result is kept in memory.
    progress : bool
        True to draw a progress bar on the terminal, or to print a line every minute if there is no terminal.

    Returns
    -------
    Result
        Its `dataset` has the variables of `LoadCurve` over fractal_dimension, amplitude (µm), repetition and approach
        (µm). Attributes store the units, the study and the version of stiction. Areal surfaces have the variables of
        `SurfaceLoadCurve`, and the half-space has those of `HalfSpaceCurve` over load (mN) instead of approach. A list
        of sliding rules or directions adds the dimension sliding or direction (degrees). Measured bodies have the
        cutoff (µm) instead of fractal_dimension and amplitude, and contact statistics in addition.

    Raises
    ------
    ValueError
        If the study cannot be computed, or its result takes more than 16 GiB of memory without a store. Also if the
        store cannot be written, is damaged, contains another study, or is incomplete and was created by another
        version of stiction.

    Examples
    --------
    >>> from stiction import Study, run
    >>> small = {"ensemble.repetitions": 2, "surfaces.points": 3000}
    >>> run(Study.named("quick").with_changes(small)).dataset["contact_area"].dims
    ('fractal_dimension', 'amplitude', 'repetition', 'approach')
    """
    return Result.of(compute_member_sums(study, executor=executor, store=store, progress=progress))


def compute_preview_result(study: Study) -> Result:
    """Compute an approximate result from the first few members of a study, as a preview.

    Arguments and errors are those of `run`.
    """
    return Result.of(compute_preview_sums(study))


def complete_result(
    study: Study, directory: Path, executor: Executor, *, part: tuple[int, int] | None = None, replace: bool = False,
    onset: int | None = None, progress: bool = False, print_finished: LinePrintFunction = _ignore_line,
    print_remark: LinePrintFunction = _ignore_line, announce: LinePrintFunction = _ignore_line,
    show_result: Callable[[Result], Any] = lambda _: None,
) -> Result:  # fmt: skip
    """Compute the missing members of a study, or one part of them, store them in a directory, and return the result.

    If no part is given, the companion results are computed too.

    With `replace`, the result of another study in the directory is removed. `onset` is the number of members whose
    onset of sliding is computed. `print_finished` receives lines about finished work, `print_remark` receives important
    remarks, and `announce` receives lines about work that is about to start. `show_result` receives the result as soon
    as all blocks are complete.
    """
    for name, signature in (_COMPANION_FILE_SIGNATURES if study.is_measured and part is None else {}).items():
        check_replaceable(directory / name, signature, StoreError)
    existing_result = open_result_to_complete(directory)
    with DirectoryClaim(directory) as claim:
        if replace and existing_result:
            remove_result(existing_result, claim)
        stored_result = prepare_result_directory(study, directory, claim, part)
        num_members = study.ensemble.repetitions
        num_existing = stored_result.num_finished
        differences = (
            find_section_differences(existing_result.study, stored_result.study)
            if existing_result and num_existing
            else []
        )
        existing_text, all_text = map(study.member_names.with_count, (num_existing, num_members))
        if friction_differences := [difference for difference in differences if difference[0].startswith("friction.")]:
            print_remark(
                f"{directory} has results for other friction parameters; its {existing_text} are kept, and output "
                f"files with the same names are replaced\n{format_study_differences(friction_differences)}"
            )
        is_measured = stored_result.study.is_measured
        seconds = (num_members - num_existing) * estimate_member_time(stored_result.study)
        announce_blocks = (
            print_finished if not is_measured else print_remark if seconds > MIN_ANNOUNCED_TIME else announce
        )
        if announce_blocks is print_remark and part is None:
            announce_blocks = partial(_announce_pair_and_cutoff_study, stored_result, print_remark)
        stored_result = complete_blocks(
            stored_result,
            part=part,
            executor=executor,
            progress=progress,
            announce=announce_blocks,
            update=print_remark,
            meanwhile=_import_result_packages,
        )
        if part is not None:
            print_finished(
                f"part {part[0]}/{part[1]} is finished; {stored_result.num_finished} of {all_text} are in {directory}"
            )
            return Result(stored_result)
        result = Result(stored_result)
        if is_measured and not has_only_negligible_loads(result):
            _compute_alternatives(stored_result, executor, progress=progress, print_remark=print_remark)
        if num_existing < num_members and (num_existing or not is_measured):
            print_finished(
                f"wrote {directory}" + (f" ({num_existing} of {all_text} already existed)" if num_existing else "")
            )
        elif num_existing == num_members:
            version_text = (
                "" if stored_result.version == __version__ else f", computed by stiction {stored_result.version}"
            )
            print_finished(f"{directory} already contains this study{version_text}")
        show_result(result)
        if is_measured and (num_existing < num_members or not (stored_result.path / CONTACT_PICTURE_FILE).exists()):
            _write_companion_file(stored_result, CONTACT_PICTURE_FILE, lambda: contact_picture(result))
        compute_companion_files(
            result, executor, onset, progress=progress, announce=announce, print_remark=print_remark
        )
        return result


def _import_result_packages() -> None:
    """Import the packages that store and evaluate the result, while the workers compute members."""
    import_dataset_packages()
    import scipy.fft
    import scipy.special  # noqa: F401


def _announce_pair_and_cutoff_study(stored_result: StoredResult, print_remark: LinePrintFunction, task: str) -> None:
    """Print what is being computed, and the estimated time of the cutoff study that follows."""
    print_remark(task)
    # `find_cutoff_study` fails if a scan file is missing.
    with contextlib.suppress(ValueError):
        cutoff_study = find_cutoff_study(stored_result.study, stored_result.path)
        if cutoff_study is not None and cutoff_study.open() is None:
            study = cutoff_study.study
            seconds = study.ensemble.repetitions * estimate_member_time(study)
            _print_time_if_long(print_remark, "cutoff study after the result", seconds)


def _print_time_if_long(print_remark: LinePrintFunction, task: str, seconds: float) -> None:
    """Print the estimated time of a computation, unless the time is short."""
    if seconds > MIN_ANNOUNCED_TIME:
        print_remark(f"{task}: about {format_duration(seconds)} of one core")


def _compute_alternatives(
    stored_result: StoredResult, executor: Executor, *, progress: bool, print_remark: LinePrintFunction
) -> None:
    """Compute the pair for alternative preparations of its scans, which widen the combined interval of the pair.

    If an alternative cannot be computed, the pair keeps its result, and a remark states the reason.
    """
    try:
        names = find_alternatives(stored_result.study)
    except ValueError:
        # `find_alternatives` fails if a scan file is missing.
        return
    for name in names:
        label = ALTERNATIVE_LABELS[name]
        try:
            alternative_study = find_alternative_study(stored_result.study, stored_result.path, name)
            alternative_study.complete(
                executor,
                progress=progress,
                announce_time=partial(_print_time_if_long, print_remark, f"interval for {label}"),
            )
        except (ValueError, ArithmeticError, OSError, MemoryError) as error:
            print_remark(f"the interval does not include {label}: {error}")


def _write_companion_file(stored_result: StoredResult, name: str, compute: Callable[[], Any]) -> None:
    """Compute a file and write it alongside the result, unless `compute` returns None.

    Nothing is written, either, if a scan file is missing.
    """
    with contextlib.suppress(ValueError):
        if (dataset := compute()) is not None:
            export(dataset, stored_result.path / name, replace=True)


def compute_companion_files(
    result: Result, executor: Executor, onset: int | None = None, *, progress: bool = False,
    announce: LinePrintFunction = _ignore_line, print_remark: LinePrintFunction = _ignore_line,
) -> None:  # fmt: skip
    """Compute the cutoff study and the onset of sliding of a measured pair, unless both are stored already."""
    stored_result = result.stored
    if stored_result is None or not stored_result.study.is_measured:
        return
    try:
        cutoff_study = (
            None if has_only_negligible_loads(result) else find_cutoff_study(stored_result.study, stored_result.path)
        )
        if cutoff_study is not None:
            cutoff_study.complete(
                executor,
                progress=progress,
                announce_time=lambda seconds: (print_remark if seconds > MIN_ANNOUNCED_TIME else announce)(
                    f"cutoff study: about {format_duration(seconds)} of one core"
                ),
                meanwhile=(lambda: None) if onset == 0 else partial(import_fit_packages, stored_result.study),
            )
        stored_onset = load_stored_onset(stored_result)
        if onset == 0 or (stored_onset is not None and onset in (None, int(stored_onset.attrs["members"]))):
            if stored_onset is not None and (stored_result.path / ONSET_TABLE_FILE).exists():
                # The onset table is written again, because its friction coefficient may have changed.
                _write_onset_table(result, stored_onset)
            return
        announce("onset of sliding")
        _print_time_if_long(print_remark, "onset of sliding", estimate_onset_time(stored_result.study, onset))
        new_onset = compute_onset(stored_result.study, executor, members=onset)
    except ValueError as error:
        # A ValueError means that a scan file is missing.
        print_remark(f"cutoff study and onset are not computed: {error}")
        return
    if new_onset is not None:
        export(new_onset, stored_result.path / ONSET_FILE, replace=True)
        _write_onset_table(result, new_onset)


def _write_onset_table(result: Result, onset: xarray.Dataset) -> None:
    """Write a table of the onset of sliding, scaled to the result's coefficient, unless the file is up to date."""
    scaled_onset = result.scale_onset(onset)
    if scaled_onset is None or result.path is None:
        return
    file, text = result.path / ONSET_TABLE_FILE, format_backbone_csv(scaled_onset)
    if file.exists() and file.read_bytes() == text.encode():
        return
    with replace_file_atomically(file, ONSET_TABLE_SIGNATURE, StoreError) as partial_path:
        partial_path.write_text(text, encoding="utf-8")
