"""Pressure between a rigid gap and an elastic half-space: kernels, and the solver from coarse grids to fine ones.

Polonsky & Keer, Wear 231 (1999) 206, for projected conjugate gradients; here preconditioned by E*|k|/2 on the points
that are free to move, and begun from the solution on every second point.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy.fft
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats

Singles = NDArray[np.float32]

COARSE_TOLERANCE = 1e-2
"""Of the solutions on coarser grids, whose own distance from the finest is larger."""

FEWEST_POINTS = 16
"""Along an axis of the coarsest grid."""

MOST_ITERATIONS = 2000
"""On the finest grid; a hundred are many."""

MOST_COARSE_ITERATIONS = 100
"""A coarse solution is only a start."""

COMPLIANCE_TOLERANCE = 1e-4
"""Of displacements that should be equal, relative to the compliance."""

MOST_CERTIFICATES = 20
"""New evaluations in double precision before a solution is given up: round-off is the reason."""


class Kernel:
    """Displacement of a half-space under pressures on a grid, and what resembles its inverse.

    Periodic: 2/(E*|k|), 0 for k = 0. Free: a uniformly loaded cell (Love 1929; on a line the logarithm), on a grid of
    twice the size. Inner iterations work on small steps in single precision; `displacement` is in double.
    """

    def __init__(
        self, shape: tuple[int, ...], spacing: tuple[float, ...], effective_modulus: float, *, periodic: bool
    ) -> None:
        self.shape, self.periodic = shape, periodic
        self.transforms = 0
        if periodic:
            self.padded = shape
        else:
            self.padded = tuple(scipy.fft.next_fast_len(2 * n - 1, real=True) for n in shape)
        stiffness = 0.5 * effective_modulus * _wave_numbers(self.padded, spacing)
        if periodic:
            with np.errstate(divide="ignore"):
                self.compliance = np.divide(1.0, stiffness)
            self.compliance.flat[0] = 0.0
        else:
            influence = _influence(self.padded, shape, spacing, effective_modulus)
            self.compliance = np.ascontiguousarray(scipy.fft.rfftn(influence).real)
        self._compliance = self.compliance.astype(np.float32)
        self._stiffness = stiffness.astype(np.float32)

    def _filtered(self, values: NDArray[Any], factors: NDArray[Any]) -> NDArray[Any]:
        self.transforms += 2
        axes = range(len(self.shape) - 1)
        waves = scipy.fft.rfft(values, self.padded[-1], axis=-1)
        for axis in axes:
            waves = scipy.fft.fft(waves, self.padded[axis], axis=axis, overwrite_x=True)
        waves *= factors
        for axis in axes:
            waves = scipy.fft.ifft(waves, axis=axis, overwrite_x=True)
            if self.padded[axis] != self.shape[axis]:
                waves = waves[tuple([slice(None)] * axis + [slice(self.shape[axis])])]
        result: NDArray[Any] = scipy.fft.irfft(waves, self.padded[-1], axis=-1, overwrite_x=True)
        if self.padded[-1] != self.shape[-1]:
            result = np.ascontiguousarray(result[..., : self.shape[-1]])
        return result

    def displacement(self, pressure: Floats) -> Floats:
        """µm, of a pressure in GPa."""
        return self._filtered(pressure, self.compliance)

    def response(self, step: Singles) -> Singles:
        """The same of a step of pressure, in single precision."""
        return self._filtered(step, self._compliance)

    def preconditioned(self, residual: Singles) -> Singles:
        """E*|k|/2 times a residual of displacement."""
        return self._filtered(residual, self._stiffness)


def _wave_numbers(shape: tuple[int, ...], spacing: tuple[float, ...]) -> Floats:
    squares = np.square(2 * np.pi * scipy.fft.rfftfreq(shape[-1], spacing[-1]))
    for axis in range(len(shape) - 2, -1, -1):
        other = np.square(2 * np.pi * scipy.fft.fftfreq(shape[axis], spacing[axis]))
        squares = other.reshape(-1, *[1] * squares.ndim) + squares
    return np.asarray(np.sqrt(squares))


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
    ) -> None:
        self.periodic, self.tolerance, self.spacing = periodic, tolerance, spacing
        self.hardness = np.inf if hardness is None else hardness
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

    @property
    def transforms(self) -> float:
        """Real transforms taken so far, in those of the finest grid."""
        most = self.gaps[0].size
        return float(
            sum(
                kernel.transforms * kernel_size / most
                for kernel, kernel_size in zip(self.kernels, [gap.size for gap in self.gaps], strict=True)
            )
        )

    def at(self, mean_pressure: float) -> Solution:
        """The pressure with a given mean over the grid."""
        scale = self.scale(mean_pressure)
        start = np.full(self.gaps[-1].shape, mean_pressure)
        coarse = max(COARSE_TOLERANCE, self.tolerance) * scale
        for level in range(len(self.gaps) - 1, 0, -1):
            solution = self._solve(level, start, mean_pressure * start.size, coarse, MOST_COARSE_ITERATIONS)
            start = _resampled(solution.pressure, self.gaps[level - 1].shape, periodic=self.periodic)
        solution = self._solve(0, start, mean_pressure * start.size, self.tolerance * scale, MOST_ITERATIONS)
        total = mean_pressure * self.gaps[0].size
        error = max(solution.error / scale, abs(float(solution.pressure.sum()) / total - 1.0))
        return Solution(solution.pressure, solution.approach, error, solution.iterations)

    def _solve(self, level: int, start: Floats, total: float, tolerance: float, most: int) -> Solution:
        gap, kernel = self.gaps[level], self.kernels[level]
        search = _core.PressureSearch(
            (start * (total / start.sum())).ravel(),
            total=total,
            hardness=self.hardness,
            line=gap.ndim == 1,
            periodic=self.periodic,
        )
        search.restart((kernel.displacement(search.pressure.reshape(gap.shape)) + gap).ravel())
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
            if not search.plain:
                residual = kernel.preconditioned(residual.reshape(gap.shape)).ravel()
            step = search.step(residual, response)
            response = kernel.response(step.reshape(gap.shape)).ravel()
            if not search.advance(response):
                response = nothing
            exact = False
            iterations += 1
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
