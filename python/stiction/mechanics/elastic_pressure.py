"""Pressure between a rigid gap and an elastic half-space: kernels, and the solver from coarse grids to fine ones.

Polonsky & Keer, Wear 231 (1999) 206, for projected conjugate gradients; here preconditioned by E*|k|/2 on the points
that are free to move, and begun from the solution on every second point.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats

Singles = NDArray[np.float32]

COARSE_TOLERANCE = 3e-3
"""Of the solutions on coarser grids, whose own distance from the finest is larger."""

NEAR = 1.3
"""Ratio of loads up to which an area's pressure at one is a good start at the other."""

SPARSE = 0.3
"""Share of the points of an area under pressure, up to which a stencil stands for the inverse of the kernel."""

ROWS = 1024
"""Of a line that is folded: as many measure fastest."""

STENCIL_SUM = 0.04
"""Of the weights of the stencil, over the one of the point itself: patches are many points wide."""

FEWEST_POINTS = 16
"""Along an axis of the coarsest grid."""

MOST_ITERATIONS = 2000
"""On the finest grid; a hundred are many."""

MOST_COARSE_ITERATIONS = 100
"""A coarse solution is only a start."""

COMPLIANCE_TOLERANCE = 1e-4
"""Of displacements that should be equal, relative to the compliance."""

MOST_LOADS = 60
"""That are tried for one approach; six are many."""

FARTHEST_LOAD = 30.0
"""Ratio of two loads that are tried one after the other."""

MOST_CERTIFICATES = 20
"""New evaluations in double precision before a solution is given up: round-off is the reason."""


class Kernel:
    """Displacement of a half-space under pressures on a grid, and what resembles its inverse.

    Periodic: 2/(E*|k|), 0 for k = 0. Free: a uniformly loaded cell (Love 1929; on a line the logarithm), on a grid of
    twice the size. Inner iterations work on small steps in single precision; `displacement` is in double. The near
    inverse is periodic for both: that is half the transform, and ends that feel each other do no harm there.
    """

    def __init__(
        self, shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, *, periodic: bool
    ) -> None:
        self.shape, self.periodic = shape, periodic
        if periodic:
            self.padded = shape
        else:
            self.padded = tuple(scipy.fft.next_fast_len(2 * n - 1, real=True) for n in shape)
        stiffness = 0.5 * effective_modulus * _wave_numbers(shape, spacing)
        if periodic:
            with np.errstate(divide="ignore"):
                self.compliance = np.divide(1.0, stiffness)
            self.compliance.flat[0] = 0.0
        else:
            influence = _influence(self.padded, shape, spacing, effective_modulus)
            self.compliance = np.ascontiguousarray(scipy.fft.rfftn(influence).real)
        self.stencil = _stencil(spacing, effective_modulus) if len(shape) == 2 else None
        filter_of = _Filter if len(shape) == 2 else _FoldedFilter
        self._response = filter_of(self.compliance, shape, self.padded)
        self._near_inverse = filter_of(stiffness, shape, shape)

    def displacement(self, pressure: Floats) -> Floats:
        """µm, of a pressure in GPa."""
        return _filtered(pressure, self.compliance, self.padded)

    def response(self, step: Singles) -> Singles:
        """The same of a step of pressure, in single precision."""
        return self._response(step)

    def preconditioned(self, residual: Singles) -> Singles:
        """E*|k|/2 times a residual of displacement."""
        return self._near_inverse(residual)


def _filtered(values: NDArray[Any], factors: NDArray[Any], padded: tuple[int, ...]) -> NDArray[Any]:
    """Values times factors of their waves, on a grid that zeros fill up."""
    shape = values.shape
    axes = range(len(shape) - 1)
    waves = scipy.fft.rfft(values, padded[-1], axis=-1)
    for axis in axes:
        waves = scipy.fft.fft(waves, padded[axis], axis=axis, overwrite_x=True)
    waves *= factors
    for axis in axes:
        waves = scipy.fft.ifft(waves, axis=axis, overwrite_x=True)
        if padded[axis] != shape[axis]:
            waves = waves[tuple([slice(None)] * axis + [slice(shape[axis])])]
    result: NDArray[Any] = scipy.fft.irfft(waves, padded[-1], axis=-1, overwrite_x=True)
    if padded[-1] != shape[-1]:
        result = np.ascontiguousarray(result[..., : shape[-1]])
    return result


class _Filter:
    """Factors of the waves of an area, in single precision."""

    def __init__(self, factors: Floats, shape: tuple[int, ...], padded: tuple[int, ...]) -> None:
        self.factors, self.padded = factors.astype(np.float32), padded

    def __call__(self, values: Singles) -> Singles:
        return _filtered(values, self.factors, self.padded)


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

    def __call__(self, values: Singles) -> Singles:
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


def _influence(
    padded: tuple[int, ...], shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float
) -> Floats:
    """Displacement of every point under 1 GPa on the cell at the origin, negative distances wrapped around."""
    distances = []
    for n, used, step in zip(padded, shape, spacing, strict=True):
        index = np.minimum(np.arange(n), n - np.arange(n))
        distances.append(np.minimum(index, used) * step)
    if len(shape) == 1:
        (a,) = spacing
        x = distances[0]
        # The integral of -2/(π E*) ln|x - s| over the cell; the unit of the logarithm shifts all alike.
        ends = [x + 0.5 * a, x - 0.5 * a]
        integral = [end * (np.log(np.abs(end)) - 1.0) for end in ends]
        return np.asarray(-2 / (np.pi * effective_modulus) * (integral[0] - integral[1]))
    b, a = (0.5 * step for step in spacing)
    y, x = distances[0][:, np.newaxis], distances[1][np.newaxis, :]
    total = np.zeros((distances[0].size, distances[1].size))
    # Johnson, Contact Mechanics (1985), eq. 3.25.
    for first, second, third, fourth in ((x + a, y + b, y - b, x - a), (y + b, x + a, x - a, y - b)):
        for at, sign in ((first, 1.0), (fourth, -1.0)):
            total += sign * at * (np.arcsinh(second / np.abs(at)) - np.arcsinh(third / np.abs(at)))
    return total / (np.pi * effective_modulus)


@dataclass(frozen=True)
class Solution:
    """A pressure (GPa), the approach (µm) and what is known of them."""

    pressure: Floats
    approach: float
    error: float
    iterations: int


class Solver:
    """The pressures of one gap at one load after the other."""

    def __init__(
        self,
        gap: Floats,
        spacing: tuple[float, ...],
        effective_modulus: float,
        *,
        periodic: bool,
        hardness: float | None,
        tolerance: float,
        progress: Callable[[int, float], object] | None = None,
    ) -> None:
        self.periodic, self.tolerance, self.spacing, self.progress = periodic, tolerance, spacing, progress
        self.hardness = np.inf if hardness is None else hardness
        self.modulus = effective_modulus
        self.gaps, self.kernels = [], []
        while True:
            self.gaps.append(gap)
            self.kernels.append(Kernel(gap.shape, spacing, effective_modulus, periodic=periodic))
            shape = tuple(_halved(n, periodic) for n in gap.shape)
            if shape == gap.shape:
                break
            if periodic:
                spacing = tuple(s * n / m for s, n, m in zip(spacing, gap.shape, shape, strict=True))
            else:
                spacing = tuple(s * (1 if n == m else 2) for s, n, m in zip(spacing, gap.shape, shape, strict=True))
            gap = _resampled(gap, shape, periodic=periodic)
        # The unit of the error: heights, and displacements under an even pressure where those say nothing or less.
        self.heights_scale = float(self.gaps[0].std())
        self.pressure_scale = 0.0
        if not periodic:
            self.pressure_scale = float(np.std(self.kernels[0].displacement(np.ones(self.gaps[0].shape))))
        elif self.heights_scale == 0:
            self.pressure_scale = max(self.spacing) / effective_modulus

    def scale(self, mean_pressure: float) -> float:
        """µm, in which errors are measured."""
        return max(self.heights_scale, self.pressure_scale * mean_pressure)

    def at(self, mean_pressure: float, *, near: Solution | None = None) -> Solution:
        """The pressure with a given mean over the grid; `near` may be a solution at another load."""
        if near is not None and self._is_near(near, mean_pressure):
            solution = self._finest(near.pressure, mean_pressure)
            if solution.error <= self.tolerance:
                return solution
        start = np.full(self.gaps[-1].shape, mean_pressure)
        coarse = max(COARSE_TOLERANCE, self.tolerance) * self.scale(mean_pressure)
        for level in range(len(self.gaps) - 1, 0, -1):
            solution = self._solve(level, start, mean_pressure * start.size, coarse, MOST_COARSE_ITERATIONS)
            start = _resampled(solution.pressure, self.gaps[level - 1].shape, periodic=self.periodic)
        return self._finest(start, mean_pressure)

    def at_approach(self, approach: float, *, near: Solution | None = None) -> Solution:
        """The pressure at an approach (µm), which grows with the load: by secants over the logarithms of both."""
        # Of two bodies as far apart as the grid is long, less than which any load is.
        longest = max(step * n for step, n in zip(self.spacing, self.gaps[0].shape, strict=True))
        pressure = 0.1 * self.modulus * approach / longest if near is None else float(near.pressure.mean())
        below: tuple[float, float] | None = None
        above: tuple[float, float] | None = None
        for _ in range(MOST_LOADS):
            solution = near = self.at(pressure, near=near)
            miss = abs(solution.approach - approach) / self.scale(pressure)
            if miss <= self.tolerance or not solution.error <= self.tolerance:
                break
            here = math.log(pressure), math.log(solution.approach / approach)
            other = above if here[1] < 0 else below
            if here[1] < 0:
                below = here
            else:
                above = here
            if below is None or above is None or other is None:
                step = max(-math.log(FARTHEST_LOAD), min(math.log(FARTHEST_LOAD), -2 * here[1]))
                pressure *= math.exp(step)
                continue
            # Kept from the ends of the bracket, so that both of them move.
            width = above[0] - below[0]
            secant = below[0] - below[1] * width / (above[1] - below[1])
            pressure = math.exp(min(max(secant, below[0] + 0.05 * width), above[0] - 0.05 * width))
        return Solution(solution.pressure, solution.approach, max(solution.error, miss), solution.iterations)

    def _is_near(self, solution: Solution, mean_pressure: float) -> bool:
        """Whether a solution at another load is a better start than one from coarse grids; on lines it never is."""
        ratio = mean_pressure / solution.pressure.mean()
        return len(self.spacing) == 2 and 1 / NEAR <= ratio <= NEAR

    def _finest(self, start: Floats, mean_pressure: float) -> Solution:
        scale = self.scale(mean_pressure)
        total = mean_pressure * start.size
        solution = self._solve(0, start, total, self.tolerance * scale, MOST_ITERATIONS)
        error = max(solution.error / scale, abs(float(solution.pressure.sum()) / total - 1.0))
        return Solution(solution.pressure, solution.approach, error, solution.iterations)

    def _solve(self, level: int, start: Floats, total: float, tolerance: float, most: int) -> Solution:
        gap, kernel = self.gaps[level], self.kernels[level]
        search = _core.PressureSearch(
            (start * (total / start.sum())).ravel(),
            total=total,
            hardness=self.hardness,
            line=gap.ndim == 1,
        )
        search.restart((kernel.displacement(search.pressure.reshape(gap.shape)) + gap).ravel())
        near = kernel.stencil if np.count_nonzero(search.pressure) < SPARSE * gap.size else None
        nothing = np.empty(0, np.float32)
        response = nothing
        exact, certificates, iterations = True, 0, 0
        while True:
            error = search.balance()
            if error <= tolerance or not np.isfinite(error):
                certificates += 1
                if exact or level > 0 or certificates > MOST_CERTIFICATES:
                    break
                search.settle()
                search.restart((kernel.displacement(search.pressure.reshape(gap.shape)) + gap).ravel())
                exact = True
                continue
            if iterations == most:
                break
            residual = search.residual()
            if near is not None and not search.plain:
                residual = search.sharpened(near, gap.shape[-1])
            elif not search.plain:
                residual = kernel.preconditioned(residual.reshape(gap.shape)).ravel()
            step = search.step(residual, response)
            response = kernel.response(step.reshape(gap.shape)).ravel()
            if not search.advance(response):
                response = nothing
            exact = False
            iterations += 1
            if level == 0 and self.progress is not None:
                self.progress(iterations, error / (tolerance / self.tolerance))
        return Solution(search.pressure.reshape(gap.shape), search.approach, error, iterations)


def linear_compliance(kernel: Kernel, free: NDArray[np.bool_]) -> float:
    """dδ/dp (µm/GPa) for the sum of pressures over free points under which all of them move alike; 0 at full contact.

    Conjugate gradients on pressures of sum 1. The compliance is an energy, so its error is the square of theirs.
    """
    count = int(free.sum())
    if kernel.periodic and count == free.size:
        return 0.0
    pressure = np.where(free, 1.0 / count, 0.0)
    potential = kernel.displacement(pressure)
    step, response = np.zeros(0), np.zeros(0)
    compliance = float((pressure * potential).sum())
    for _ in range(MOST_ITERATIONS):
        residual = np.where(free, potential[free].mean() - potential, 0.0)
        if np.abs(residual).max() <= COMPLIANCE_TOLERANCE * abs(compliance):
            break
        better = np.where(free, kernel.preconditioned(residual.astype(np.float32)), 0.0)
        better -= np.where(free, better.sum() / count, 0.0)
        if step.size:
            better -= np.vdot(better, response) / np.vdot(step, response) * step
        step = better
        response = kernel.response(step.astype(np.float32)).astype(np.float64)
        length = np.vdot(step, residual) / np.vdot(step, response)
        pressure = pressure + length * step
        potential = potential + length * response
        compliance = float((pressure * potential).sum())
    return compliance


def _halved(n: int, periodic: bool) -> int:
    """Points of the next coarser grid along an axis."""
    if n < 2 * FEWEST_POINTS:
        return n
    if n % 2 == 0 or not periodic:
        return (n + 1) // 2
    return int(scipy.fft.next_fast_len((n + 1) // 2, real=True))


def _resampled(values: Floats, shape: tuple[int, ...], *, periodic: bool) -> Floats:
    """Values between points along straight lines, on a grid of as many points over the same length.

    On a free grid of n points the next one has every second, so that its spacing is doubled.
    """
    for axis, (have, want) in enumerate(zip(values.shape, shape, strict=True)):
        if have == want:
            continue
        before: list[Any] = [slice(None)] * axis
        if have == 2 * want or (not periodic and have > want):
            values = values[(*before, slice(None, None, 2))]
            continue
        ratio = have / want if periodic else 0.5
        position = np.arange(want) * ratio
        left = np.minimum(position.astype(np.int64), have - 1)
        right = (left + 1) % have if periodic else np.minimum(left + 1, have - 1)
        weight = (position - left).reshape(-1, *[1] * (values.ndim - axis - 1))
        values = np.take(values, left, axis) * (1 - weight) + np.take(values, right, axis) * weight
    return np.ascontiguousarray(values)
