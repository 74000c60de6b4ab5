"""Pairs of random surfaces of two spectra, of which at least one is of several scans."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from stiction.surfaces.cut_off import cut_off
from stiction.surfaces.joined import LONGEST, JoinedSpectrum, joined_spectrum
from stiction.surfaces.pairing import MOST_POINTS, SquarePairs
from stiction.surfaces.preparation import SurfaceTrend, levelled
from stiction.surfaces.profile import Profile, Side
from stiction.surfaces.surface import Surface

POINTS_OF_A_WAVE = 4  # points of the shortest wave of the surfaces that are made


def spectrum_of(scan: Profile | Surface | JoinedSpectrum) -> JoinedSpectrum:
    """The spectrum of a scan that is to be pressed on one of several: alike in all directions, where it is trusted."""
    return scan if isinstance(scan, JoinedSpectrum) else joined_spectrum([scan], names=["one scan"])


@dataclass(frozen=True, eq=False)
class SpectrumPairs(SquarePairs):
    """Pairs of pieces of random, periodic surfaces of two spectra, alike in all directions.

    The points are a quarter of the shortest wave apart, and there are `MOST_POINTS` of them along each axis or as many
    as the longest wave has in `LONGEST` of a side; longer waves are left out. So with a cut-off the surfaces are the
    larger.
    """

    upper: JoinedSpectrum  # random phases are the same whether a surface is turned over or not
    lower: JoinedSpectrum
    level: SurfaceTrend = "plane"  # what is taken off each piece
    seed: int = 2016
    cut_off: float = 0.0  # µm, waves shorter than this are taken off; 0 for none
    finest: float = 0.0  # µm, shortest of several cut-offs, which decides the grid: members are the same at each

    @cached_property
    def _step(self) -> float:  # type: ignore[override]
        return max(min(self.upper.shortest, self.lower.shortest), self.finest) / POINTS_OF_A_WAVE

    @cached_property
    def _whole(self) -> int:  # type: ignore[override]
        longest = max(self.upper.longest, self.lower.longest) / LONGEST
        return min(MOST_POINTS, int(longest / self._step))

    @property
    def side(self) -> float:
        """Side of the surfaces that pieces are taken from, µm."""
        return self._whole * self._step

    @property
    def used(self) -> tuple[float, float]:
        """The fraction of a surface that a piece is."""
        part = float(np.prod(self.shape)) / self._whole**2
        return part, part

    def surrogates(self, index: int) -> tuple[Surface, Surface]:
        """Pieces of a pair, both levelled."""
        return self._piece(self.upper, index, "upper"), self._piece(self.lower, index, "lower")

    def _piece(self, body: JoinedSpectrum, index: int, side: Side) -> Surface:
        shape = (self._whole, self._whole)
        whole = body.surface(self.seed, shape=shape, spacing=self.spacing, repetition=index, side=side)
        if self.cut_off > 0:
            whole = cut_off(whole, self.cut_off, periodic=True)
        rows, columns = self.shape
        piece = Surface(whole.heights[:rows, :columns], spacing=self.spacing, history=whole.history)
        return levelled(piece, self.level)
