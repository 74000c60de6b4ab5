"""Which page a result has."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from stiction._files import replaced_file
from stiction.views.report.page import MARK, ReportError
from stiction.views.report.pair import LINES, MAPS, pair_page
from stiction.views.report.study import MOST_RESULTS, study_page

if TYPE_CHECKING:
    import xarray


def save_report(
    dataset: xarray.Dataset | Sequence[xarray.Dataset], path: str | Path, *, names: Sequence[str] = ()
) -> None:
    """Write the page of a result; an older report of that name is replaced when the new one is whole.

    Parameters
    ----------
    dataset : xarray.Dataset, or two of them
        As for `report_page`.
    path : path
    names : sequence of str
        As for `report_page`.

    Raises
    ------
    ReportError
        As `report_page`, and if the path holds something that is no report or cannot be written.
    """
    with replaced_file(Path(path), MARK.encode(), ReportError) as partial:
        partial.write_bytes(report_page(dataset, names=names).encode("utf-8", "replace"))


def report_page(dataset: xarray.Dataset | Sequence[xarray.Dataset], *, names: Sequence[str] = ()) -> str:
    """The page of a result, or of two studies side by side, as HTML, which needs nothing else.

    Parameters
    ----------
    dataset : xarray.Dataset, or two of them
        What `run` returns, or what `stiction pair` writes.
    names : sequence of str
        What each is called on the page; a built-in study has its own name otherwise.

    Raises
    ------
    ReportError
        If there are more than two, one is too large for a page or has no repetitions, or one of its numbers is not
        finite.
    """
    import xarray

    datasets: list[xarray.Dataset] = list(dataset) if isinstance(dataset, (list, tuple)) else [cast("Any", dataset)]
    for each in datasets:
        if not isinstance(each, xarray.Dataset):
            raise ReportError(f"dataset must be an xarray.Dataset or a list of them, got {type(each).__name__}")
    if not 1 <= len(datasets) <= MOST_RESULTS:
        raise ReportError(f"a page is of one result or two, got {len(datasets)}")
    named = [*names, *[""] * len(datasets)][: len(datasets)]
    pairs = [data for data in datasets if data.attrs.get("title") in (MAPS, LINES) and "study" not in data.attrs]
    if len(pairs) == 1 == len(datasets):
        return pair_page(pairs[0]).html()
    if pairs:
        raise ReportError("two results side by side are of studies; a page of a pair has one")
    return study_page(datasets, named).html()
