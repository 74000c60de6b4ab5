"""Displacement of an elastic half-space under pressures on a grid, and what resembles the inverse of that."""

from __future__ import annotations

import itertools
import math
import weakref
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cached_property
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

from stiction._checks import Floats

Singles = NDArray[np.float32]

ROWS = 1024
"""Of a line that is folded: as many measure fastest."""

STENCIL_SUM = 0.04
"""Of the weights of the stencil, over the one of the point itself: patches are many points wide."""

IN_CACHE = 2**17
"""Complex numbers that are transformed at a time on areas: half of that to twice as many measure fastest."""

OF_A_THREAD = 4 * IN_CACHE
"""Complex numbers of which there are so many for each thread: to begin one takes as long as a part of them."""

MOST_KEPT = 2**20
"""Points of a grid whose kernels are kept when nobody uses them: 35 MB; a quarter of a free load takes to make them."""

FEWEST_POINTS = 16
"""Along an axis of the coarsest grid."""


class Grids:
    """The grid of a problem and coarser ones down to some 16 points an axis, for as many problems as have that shape.

    Attributes
    ----------
    levels : list of (shape, spacing)
        From the grid itself on, each with about half of the points along an axis.
    """

    def __init__(
        self, shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, *, periodic: bool
    ) -> None:
        self.effective_modulus, self.periodic = effective_modulus, periodic
        self.levels = [(shape, spacing)]
        self._kernels: dict[int, Kernel] = {}
        while (coarser := tuple(_halved(n, periodic) for n in shape)) != shape:
            steps = [(n / m if periodic else 2) if n != m else 1 for n, m in zip(shape, coarser, strict=True)]
            shape, spacing = coarser, tuple(a * b for a, b in zip(spacing, steps, strict=True))
            self.levels.append((shape, spacing))

    @cached_property
    def even_deviation(self) -> float:
        """µm/GPa, root-mean-square deviation of displacements under an even pressure, which only a free grid has."""
        shape, spacing = self.levels[0]
        moved = _up_to_corners(shape, spacing, self.effective_modulus)[(slice(1, None),) * len(shape)]
        for axis in range(moved.ndim):  # by what lies on both sides of a point
            moved = moved + np.flip(moved, axis)
        return float(np.std(moved))

    def kernel(self, level: int = 0) -> Kernel:
        """Of a level, made when first asked for; large ones of coarser grids are not kept."""
        if level in self._kernels:
            return self._kernels[level]
        kernel = Kernel(*self.levels[level], self.effective_modulus, periodic=self.periodic)
        if level == 0 or math.prod(kernel.shape) <= MOST_KEPT:
            self._kernels[level] = kernel
        return kernel


_shared: weakref.WeakValueDictionary[tuple[Any, ...], Grids] = weakref.WeakValueDictionary()
_last: deque[Grids] = deque(maxlen=1)


def grids_of(shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, *, periodic: bool) -> Grids:
    """The grids of a problem: the same ones as long as anyone holds them, as a curve does, and the last ones if small.

    One pair after the other on one grid, as of shifts or repetitions, then shares their kernels.
    """
    key = shape, spacing, effective_modulus, periodic
    grids = _shared.get(key)
    if grids is None:
        grids = _shared[key] = Grids(shape, spacing, effective_modulus, periodic=periodic)
    if math.prod(shape) <= MOST_KEPT:
        _last.append(grids)
    return grids


class Kernel:
    """Displacement of a half-space under pressures on a grid, and what resembles its inverse.

    Periodic: 2/(E*|k|), 0 for k = 0. Free: a uniformly loaded cell (Love 1929; on a line the logarithm), on a grid of
    twice the size. Inner iterations work on small steps in single precision; `displacement` is in double. The near
    inverse is periodic for both: that is half the transform, and ends that feel each other do no harm there.
    """

    def __init__(
        self, shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, *, periodic: bool
    ) -> None:
        self.shape, self.spacing, self.effective_modulus, self.periodic = shape, spacing, effective_modulus, periodic
        if periodic:
            self.padded = shape
            with np.errstate(divide="ignore"):
                self.compliance = np.divide(1.0, self._stiffness())
            self.compliance.flat[0] = 0.0
        else:
            # Even numbers, so that waves of the influence, which is symmetric, are the cosines of a quarter of it.
            self.padded = tuple(2 * int(scipy.fft.next_fast_len(n, real=True)) for n in shape)
            beyond = [(0, n // 2 + 1 - used) for n, used in zip(self.padded, shape, strict=True)]
            quarter = np.pad(_influence(shape, spacing, effective_modulus), beyond, mode="edge")
            self.compliance = scipy.fft.dctn(quarter, type=1, overwrite_x=True)
        self.stencil = _stencil(spacing, effective_modulus) if len(shape) == 2 else None
        self._response = _filter(self.compliance, shape, self.padded)

    @cached_property
    def _near_inverse(self) -> _Filter | _FoldedFilter:
        return _filter(self._stiffness(), self.shape, self.shape)

    def _stiffness(self) -> Floats:
        """E*|k|/2, GPa/µm."""
        return 0.5 * self.effective_modulus * _wave_numbers(self.shape, self.spacing)

    def displacement(self, pressure: Floats, room: Room | None = None) -> Floats:
        """µm, of a pressure in GPa."""
        return _filtered(pressure, self.compliance, self.padded, room)

    def among(self, points: NDArray[np.integer[Any]]) -> Floats:
        """µm/GPa, (n, n), of a cell's pressure on each other one, of points given by their indices (n, dimensions)."""
        away = np.abs(points[:, np.newaxis] - points)
        return np.asarray(self._influence[tuple(np.moveaxis(away, -1, 0))])

    @cached_property
    def _influence(self) -> Floats:
        """On the points so many rows and columns away."""
        if not self.periodic:
            return _influence(self.shape, self.spacing, self.effective_modulus)
        whole = scipy.fft.irfftn(self.compliance, self.padded)
        return np.ascontiguousarray(whole[tuple(slice(n) for n in self.shape)])

    def response(self, step: Singles, room: Room | None = None) -> Singles:
        """As `displacement`, of a step of pressure, in single precision."""
        return self._response(step, room)

    def preconditioned(self, residual: Singles) -> Singles:
        """E*|k|/2 times a residual of displacement."""
        return self._near_inverse(residual)


class Room:
    """Memory for the waves of one transform after the other: what is new the system has to clear."""

    def __init__(self) -> None:
        self._numbers = np.empty(0, np.complex128)

    def array(self, shape: tuple[int, int], kind: np.dtype[Any]) -> NDArray[Any]:
        """Of complex numbers, whatever they are, in single or double precision; it is used again for the next one."""
        if self._numbers.size != (count := math.prod(shape)):
            self._numbers = np.empty(count, np.complex128)
        return self._numbers.view(kind)[:count].reshape(shape)


def _filtered(
    values: NDArray[Any], factors: NDArray[Any], padded: tuple[int, ...], room: Room | None = None
) -> NDArray[Any]:
    """Values times factors of their waves, on a grid that zeros fill up.

    An area that zeros fill up is taken a few columns, then a few rows at a time, which stay in the cache and are shared
    by threads. Rows without values, of which there are many where little touches, have no waves along them. Without
    zeros everything is done in place, which is faster than parts that are copied. Factors of areas that are filled up
    are given from the longest wave along y to the shortest, and the same for waves the other way.
    """
    if values.ndim == 1 or padded == values.shape:
        waves = scipy.fft.rfft(values, padded[-1])
        if values.ndim == 2:
            waves = scipy.fft.fft(waves, axis=0, overwrite_x=True)
        waves *= factors
        if values.ndim == 2:
            waves = scipy.fft.ifft(waves, axis=0, overwrite_x=True)
        result = scipy.fft.irfft(waves, padded[-1], overwrite_x=True)
        return np.ascontiguousarray(result[..., : values.shape[-1]])
    rows, columns = values.shape
    filled = np.flatnonzero(values.any(axis=1))
    count = padded[1] // 2 + 1
    # At first the waves along x of filled rows, one after the other; then those of all rows in their place.
    waves = (room or Room()).array((rows, count), np.result_type(values, np.complex64))

    def along_x(part: slice) -> None:
        waves[part] = scipy.fft.rfft(values[filled[part]], padded[1])

    def along_y(part: slice) -> None:
        block = np.zeros((padded[0], part.stop - part.start), waves.dtype)
        block[filled] = waves[: filled.size, part]
        block = scipy.fft.fft(block, axis=0, overwrite_x=True)
        block[: len(factors)] *= factors[:, part]
        block[len(factors) :] *= factors[-2:0:-1, part]
        waves[:, part] = scipy.fft.ifft(block, axis=0, overwrite_x=True)[:rows]

    def back(part: slice) -> None:
        result[part] = scipy.fft.irfft(waves[part], padded[1], overwrite_x=True)[:, :columns]

    with _threads(count * padded[0]) as each_of:
        if filled.size:
            each_of(along_x, _parts(filled.size, count))
        each_of(along_y, _parts(count, padded[0]))
        result = np.empty(values.shape, values.dtype)
        each_of(back, _parts(rows, count))
    return result


def _parts(count: int, size: int) -> list[slice]:
    """Some of `count` pieces of so many numbers at a time."""
    parts = -(-count * size // IN_CACHE)
    ends = [count * part // parts for part in range(parts + 1)]
    return [slice(*pair) for pair in itertools.pairwise(ends)]


@contextmanager
def _threads(size: int) -> Iterator[Callable[[Callable[[slice], None], list[slice]], object]]:
    """What does some work for every part of so many numbers, on as many threads as `scipy.fft` is told to use."""
    threads = min(scipy.fft.get_workers(), size // OF_A_THREAD)
    if threads <= 1:
        yield lambda work, parts: deque(map(work, parts), maxlen=0)
        return
    with ThreadPoolExecutor(threads) as pool:
        yield lambda work, parts: deque(pool.map(work, parts), maxlen=0)  # which raises what a part did


def _filter(factors: Floats, shape: tuple[int, ...], padded: tuple[int, ...]) -> _Filter | _FoldedFilter:
    return _Filter(factors, padded) if len(shape) == 2 else _FoldedFilter(factors, shape, padded)


class _Filter:
    """Factors of the waves of an area, in single precision."""

    def __init__(self, factors: Floats, padded: tuple[int, ...]) -> None:
        self.factors, self.padded = factors.astype(np.float32), padded

    def __call__(self, values: Singles, room: Room | None = None) -> Singles:
        return _filtered(values, self.factors, self.padded, room)


class _FoldedFilter:
    """The same of the waves of a line, folded to an area, of which several rows are transformed at once.

    Bailey, Journal of Supercomputing 4 (1990) 23: point columns*i + j, wave rows*b + a; transforms along i to a, turned
    by exp(-2πi a j/points), then along j to b.
    """

    def __init__(self, factors: Floats, shape: tuple[int, ...], padded: tuple[int, ...]) -> None:
        (self.used,), (self.points,) = shape, padded
        self.rows = _divisor_near(self.points, ROWS)
        columns = self.points // self.rows
        first = np.arange(self.rows // 2 + 1)[:, np.newaxis]
        wave = first + self.rows * np.arange(columns)
        self.factors = factors[np.minimum(wave, self.points - wave)].astype(np.float32)
        self.turn = np.exp(-2j * np.pi / self.points * (first * np.arange(columns))).astype(np.complex64)
        self.turn_back = self.turn.conj()

    def __call__(self, values: Singles, room: Room | None = None) -> Singles:
        if self.used != self.points:
            values = np.concatenate((values, np.zeros(self.points - self.used, np.float32)))
        waves = scipy.fft.rfft(values.reshape(self.rows, -1), axis=0)
        waves *= self.turn
        waves = scipy.fft.fft(waves, axis=1, overwrite_x=True)
        waves *= self.factors
        waves = scipy.fft.ifft(waves, axis=1, overwrite_x=True)
        waves *= self.turn_back
        result: Singles = scipy.fft.irfft(waves, self.rows, axis=0, overwrite_x=True).ravel()
        return result[: self.used]


def _divisor_near(number: int, wanted: int) -> int:
    """The divisor of a number that is nearest to another by ratio."""
    small = [n for n in range(1, int(number**0.5) + 1) if number % n == 0]
    return min([*small, *(number // n for n in small)], key=lambda n: max(n / wanted, wanted / n))


def _wave_numbers(shape: tuple[int, ...], spacing: tuple[float, ...]) -> Floats:
    squares = np.square(2 * np.pi * scipy.fft.rfftfreq(shape[-1], spacing[-1]))
    for axis in range(len(shape) - 2, -1, -1):
        other = np.square(2 * np.pi * scipy.fft.fftfreq(shape[axis], spacing[axis]))
        squares = other.reshape(-1, *[1] * squares.ndim) + squares
    return np.asarray(np.sqrt(squares))


def _stencil(spacing: tuple[float, ...], effective_modulus: float) -> Floats:
    """E*|k|/2 of a point on the points around it, (9,), whose sum is small."""
    shape = (2 * FEWEST_POINTS, 2 * FEWEST_POINTS)
    near = np.roll(scipy.fft.irfft2(0.5 * effective_modulus * _wave_numbers(shape, spacing), shape), (1, 1), (0, 1))
    stencil: Floats = np.minimum(near[:3, :3].ravel(), 0.0)
    stencil[4] = stencil.sum() / (STENCIL_SUM - 1)
    return stencil


def _up_to_corners(shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float) -> Floats:
    """Displacement of the origin under 1 GPa from there to each corner of cells, half a cell away from it and more.

    The first corners are on the other side, where it counts as negative.
    """
    corners = [(np.arange(n + 1) - 0.5) * step for n, step in zip(shape, spacing, strict=True)]
    if len(shape) == 1:
        (x,) = corners
        # The integral of -2/(π E*) ln|x|; the unit of the logarithm shifts all alike.
        return np.asarray(-2 / (np.pi * effective_modulus) * x * (np.log(np.abs(x)) - 1.0))
    y, x = corners[0][:, np.newaxis], corners[1][np.newaxis, :]
    # The integral of 1/(π E* r) (Johnson, Contact Mechanics (1985), eq. 3.25).
    integral = y / np.abs(x)
    np.arcsinh(integral, out=integral)
    integral *= x
    other = x / np.abs(y)
    np.arcsinh(other, out=other)
    other *= y
    integral += other
    integral /= np.pi * effective_modulus
    return np.asarray(integral)


def _influence(shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float) -> Floats:
    """Displacement of points so many rows and columns away under 1 GPa on a cell, or on a line."""
    influence = _up_to_corners(shape, spacing, effective_modulus)
    for axis in range(len(shape)):
        influence = np.diff(influence, axis=axis)
    return influence


def _halved(n: int, periodic: bool) -> int:
    """Points of the next coarser grid along an axis."""
    if n < 2 * FEWEST_POINTS:
        return n
    if n % 2 == 0 or not periodic:
        return (n + 1) // 2
    return int(scipy.fft.next_fast_len((n + 1) // 2, real=True))
