"""Forces and areas summed over the contacts of each member of a study, in memory or in a directory."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np
from numpy.typing import NDArray

from stiction._checks import check_callable, check_instance, make_read_only, parse_names, parse_path
from stiction._units import short_repr
from stiction.solve.layout import arrange_axes, compute_members_per_piece, share_read_only
from stiction.solve.store import StoredResult, export
from stiction.study.study import Study, parse_study_of_dataset

if TYPE_CHECKING:
    import xarray

_Value = TypeVar("_Value")


class MemberSums:
    """Forces and areas summed over the contacts of each member of a study, from which friction is evaluated.

    Parameters
    ----------
    source : xarray.Dataset or StoredResult
        Sums of all members in memory, or an open directory.
    """

    def __init__(self, source: xarray.Dataset | StoredResult) -> None:
        self.source = source
        self._companions: dict[Callable[[StoredResult], Any], Any] = {}
        self._computed: dict[Callable[[Any], Any], Any] = {}

    @classmethod
    def of(cls, sums: MemberSums | xarray.Dataset | StoredResult) -> Self:
        """Wrap a dataset, a stored result or another `MemberSums` object in an instance of this class."""
        import xarray

        if isinstance(sums, cls):
            return sums
        if isinstance(sums, MemberSums):
            converted_sums = cls(sums.source)
            # The converted object shares all cached arrays with the original object.
            vars(converted_sums).update(vars(sums))
            return converted_sums
        check_instance("result", sums, (xarray.Dataset, StoredResult), "a Result, or an xarray.Dataset of member sums")
        return cls(sums)

    def with_study(self, study: Study) -> MemberSums:
        """Return the same forces and areas with another study, for example for evaluation with other mu0 and tau0."""
        sums = MemberSums(self.source)
        sums.study = study
        return sums

    @property
    def stored(self) -> StoredResult | None:
        """Stored result, or None if the result is only in memory."""
        return self.source if isinstance(self.source, StoredResult) else None

    @cached_property
    def study(self) -> Study:
        """Study that defines mu0, tau0 and the other inputs with which friction is evaluated."""
        return self.source.study if isinstance(self.source, StoredResult) else parse_study_of_dataset(self.source)

    @property
    def path(self) -> Path | None:
        """Directory of the stored result, or None if the result is only in memory."""
        return None if self.stored is None else self.stored.path

    @cached_property
    def dataset(self) -> xarray.Dataset:
        """Dataset with the forces and areas of all members, summed over contacts.

        Raises a `StoreError` if the sums take more than 2 GiB.
        """
        return self.source.dataset() if isinstance(self.source, StoredResult) else self.source

    @property
    def head(self) -> xarray.Dataset:
        """Dataset with the coordinates and attributes of the result, and with the sums of at least one member.

        For a stored result, the dataset contains the sums of the first finished member only. Raises a `StoreError` if
        no member is finished.
        """
        return self._first_member.copy() if isinstance(self.source, StoredResult) else self.source

    @cached_property
    def _first_member(self) -> xarray.Dataset:
        assert isinstance(self.source, StoredResult)
        # `StoredResult.dataset` raises the error for a result without finished members.
        return share_read_only(self.source.first_member() if self.source.num_finished else self.source.dataset())

    @cached_property
    def members(self) -> NDArray[np.intp]:
        """Indices of the finished members."""
        if isinstance(self.source, StoredResult):
            return make_read_only(self.source.finished_members)
        return make_read_only(np.asarray(self.source["repetition"].values, dtype=np.intp).view())

    @property
    def version(self) -> str:
        """Version of stiction with which the result was computed."""
        if isinstance(self.source, StoredResult):
            return self.source.version
        return str(self.source.attrs.get("stiction_version", "unknown"))

    def pieces(self, names: Iterable[str] | None = None) -> Iterator[xarray.Dataset]:
        """Yield the result as datasets of several members each, so that only one dataset is in memory at a time.

        `names` lists the variables of a piece, by default all variables. The pieces depend only on the study, so that
        sums over the pieces are bitwise reproducible.
        """
        if names is not None:
            first_members = self._first_member if isinstance(self.source, StoredResult) else self.source
            names, variables = parse_names("names", names), first_members.variables
            if unknown_names := [name for name in names if name not in variables]:
                raise ValueError(f"names must be variables of the result, got {short_repr(unknown_names[0])}")
        if isinstance(self.source, StoredResult):
            yield from self.source.pieces(names)
            return
        count = self.source.sizes["repetition"]
        piece_size = compute_members_per_piece(
            sum(variable.nbytes for variable in self.source.data_vars.values()) // max(1, count)
        )
        selected_dataset = self.source if names is None else self.source[list(names)]
        for piece_start in range(0, count, piece_size):
            yield selected_dataset.isel(repetition=slice(piece_start, piece_start + piece_size))

    def means(self, names: Iterable[str]) -> xarray.Dataset:
        """Return means of variables over all solved members at each loading step, or NaN where no member was solved.

        Only one piece of the result is in memory at a time.
        """
        import xarray

        names, sums, counts = parse_names("names", names), dict[str, xarray.Variable](), dict[str, xarray.Variable]()
        for piece in self.pieces(names):
            for name in names:
                variable = piece.variables[name]
                dims = [str(dim) for dim in variable.dims if dim != "repetition"]
                # Summing over repetitions is faster if the repetitions are contiguous in memory.
                values = np.ascontiguousarray(arrange_axes(variable, (*dims, "repetition")))
                is_solved = ~np.isnan(values)
                piece_sum = xarray.Variable(dims, np.where(is_solved, values, 0).sum(axis=-1))
                piece_count = xarray.Variable(dims, is_solved.sum(axis=-1))
                sums[name] = piece_sum if name not in sums else sums[name] + piece_sum
                counts[name] = piece_count if name not in counts else counts[name] + piece_count
        head = self.head
        coordinates = {
            name: head.variables[name] for name in head.coords if "repetition" not in head.variables[name].dims
        }
        with np.errstate(invalid="ignore"):
            variables = {
                name: (value.dims, value.values / counts[name].values, head.variables[name].attrs)
                for name, value in sums.items()
            }
        return xarray.Dataset(variables, coordinates, head.attrs)

    @cached_property
    def mean_elastic_loads(self) -> xarray.DataArray:
        """Normal load (mN) without friction at each loading step, averaged over all solved members."""
        return share_read_only(self.means(["normal_elastic"]))["normal_elastic"]

    def load_companion(self, read: Callable[[StoredResult], _Value | None]) -> _Value | None:
        """Load data from the directory of the stored result by calling `read`, and cache the data.

        Returns None for results in memory. The arrays of datasets are read-only. The value None is not cached, because
        an unfinished run may add the data later.
        """
        check_callable("read", read)
        if self.stored is None:
            return None
        if read not in self._companions:
            value = read(self.stored)
            if value is None:
                return None
            self._companions[read] = value
        return share_read_only(self._companions[read])  # type: ignore[no-any-return]

    def compute_once(self, compute: Callable[[Self], _Value]) -> _Value:
        """Return `compute(self)`. The first call with a function computes the value, and later calls reuse it.

        The arrays of datasets are read-only.
        """
        check_callable("compute", compute)
        if compute not in self._computed:
            self._computed[compute] = compute(self)
        return share_read_only(self._computed[compute])  # type: ignore[no-any-return]

    def to_netcdf(self, path: str | Path) -> None:
        """Write the result with all variables, coordinates and attributes to a new netCDF file."""
        export(self.dataset, parse_path("path", path))
