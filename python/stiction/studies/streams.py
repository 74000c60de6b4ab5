"""Results in pieces: blocks of repetitions, of which one is in memory at a time, whether the result is or is not."""

from __future__ import annotations

from collections.abc import Hashable, Iterable, Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray

PIECE = 2**26
"""Bytes of a result that are in memory at a time."""

TURNED = 256
"""Repetitions whose values change places at a time, so that they stay in the processor's cache."""


def repetitions_of_piece(dataset: xarray.Dataset) -> int:
    """How many are in memory at a time: a power of two, as that in the chunks of a store is.

    It depends on the shape of the result alone, so that sums over pieces have the same bits wherever it lies.
    """
    size = sum(each.dtype.itemsize * each.size for each in dataset.data_vars.values())
    of_one = max(1, size // max(1, dataset.sizes["repetition"]))
    return 1 << max(0, (PIECE // of_one).bit_length() - 1)


def pieces(dataset: xarray.Dataset, names: Iterable[Hashable] | None = None) -> Iterator[xarray.Dataset]:
    """Some variables of a result, or all, of so many repetitions at a time, in order, in memory."""
    some = dataset if names is None else dataset[list(names)]
    size = repetitions_of_piece(dataset)
    for first in range(0, dataset.sizes["repetition"], size):
        yield some.isel(repetition=slice(first, first + size)).load()


def repetitions_last(array: xarray.DataArray, dims: Sequence[str]) -> NDArray[Any]:
    """Values over some dimensions, and over repetitions as neighbours in memory, where they are summed faster."""
    there = array.transpose(*dims, "repetition").values
    here = np.empty(there.shape, there.dtype)
    for first in range(0, there.shape[-1], TURNED):
        here[..., first : first + TURNED] = there[..., first : first + TURNED]
    return here


def means(dataset: xarray.Dataset, names: Iterable[str] | None = None) -> xarray.Dataset:
    """Means over the repetitions of some variables of a result, or of all that are over repetitions."""
    import xarray

    kept = [name for name in (dataset.data_vars if names is None else names) if "repetition" in dataset[name].dims]
    total: dict[str, xarray.Variable] = {}
    for piece in pieces(dataset, [str(name) for name in kept]):
        for name in map(str, kept):
            dims = [str(dim) for dim in piece[name].dims if dim != "repetition"]
            added = xarray.Variable(dims, repetitions_last(piece[name], dims).sum(axis=-1))
            total[name] = added if name not in total else total[name] + added
    count = dataset.sizes["repetition"]
    coordinates = {name: each for name, each in dataset.coords.items() if "repetition" not in each.dims}
    variables = {name: (each.dims, each.values / count, dataset[name].attrs) for name, each in total.items()}
    return xarray.Dataset(variables, coordinates, dataset.attrs)
