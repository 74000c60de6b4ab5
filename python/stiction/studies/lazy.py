"""The dataset of a stored result, of which variables are read when something of them is asked for."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from stiction.studies.blocks import Blocks
from stiction.studies.dataset import Array, attributes_of_result, variables_of
from stiction.studies.study import Study

MOST_LOADED = 2**28
"""Bytes of a result that is read into memory at once; of a larger one whatever is asked for, when it is."""


def stored_dataset(
    study: Study,
    version: str,
    blocks: Blocks,
    coordinates: Mapping[str, tuple[Array, NDArray[Any]]],
    repetitions: NDArray[np.intp],
) -> xarray.Dataset:
    """The dataset of some repetitions of a store, all of them finished."""
    variables = {
        name: xarray.Variable(
            each.dims, indexing.LazilyIndexedArray(Stored(blocks, name, each, repetitions)), each.attributes
        )
        for name, each in variables_of(study).items()
    }
    ordered = {
        name: xarray.Variable(each.dims, values, each.attributes) for name, (each, values) in coordinates.items()
    }
    dataset = xarray.Dataset(variables, ordered, attributes_of_result(study) | {"stiction_version": version})
    return dataset.load() if dataset.nbytes <= MOST_LOADED else dataset


class Stored(BackendArray):
    """A variable of some repetitions of a store, read and checked whenever something of it is asked for."""

    def __init__(self, blocks: Blocks, name: str, variable: Array, repetitions: NDArray[np.intp]) -> None:
        self._blocks = blocks
        self._name = name
        self._repetitions = repetitions
        self._of_one = (*variable.shape[:2], *variable.shape[3:])
        self.shape = (*variable.shape[:2], repetitions.size, *variable.shape[3:])
        self.dtype = variable.dtype

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(key, self.shape, indexing.IndexingSupport.OUTER, self._some)

    def _some(self, key: tuple[Any, ...]) -> NDArray[Any]:
        """By integers, slices and arrays of integers, each along its own dimension."""
        wanted = self._repetitions[key[2]]
        numbers = np.atleast_1d(wanted)
        at = sum(not isinstance(each, (int, np.integer)) for each in key[:2])  # axis of the repetitions
        none = _outer(np.empty((*self.shape[:2], 0, *self.shape[3:]), self.dtype), (*key[:2], slice(0), *key[3:]))
        result = np.empty((*none.shape[:at], numbers.size, *none.shape[at + 1 :]), self.dtype)
        block_of_each = numbers // self._blocks.size
        # Neighbours of one block at a time.
        ends = [0, *(np.flatnonzero(np.diff(block_of_each)) + 1).tolist(), numbers.size]
        for first, last in itertools.pairwise(ends if numbers.size else []):
            block = int(block_of_each[first])
            whole = self._blocks.read(self._name, self.dtype, self._of_one, block)
            there = _slice(numbers[first:last] - block * self._blocks.size)
            place: list[Any] = [*(slice(None),) * at, slice(first, last)]
            result[tuple(place)] = _outer(whole, (*key[:2], there, *key[3:]))
        return result if wanted.ndim else result.squeeze(axis=at)


def _slice(indices: NDArray[np.intp]) -> slice | NDArray[np.intp]:
    """Indices of which each is the next, as a slice, which copies faster."""
    return slice(indices[0], indices[-1] + 1) if (np.diff(indices) == 1).all() else indices


def _outer(values: NDArray[Any], key: tuple[Any, ...]) -> NDArray[Any]:
    """Indexed along each dimension by itself."""
    for axis in reversed(range(len(key))):
        index: list[Any] = [*(slice(None),) * axis, key[axis]]
        values = values[tuple(index)]
    return values
