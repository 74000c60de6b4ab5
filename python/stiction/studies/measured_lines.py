"""The table `[surfaces]` of two measured files that are pressed as lines, and the members that it makes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from stiction.mechanics.model import THICKNESS
from stiction.studies.measured_files import Body, Facts, MeasuredBodies, Member
from stiction.studies.values import LengthOrZero
from stiction.surfaces.pairing import LinePairs, Surrogates, lower_piece, spread
from stiction.surfaces.preparation import ProfileTrend
from stiction.surfaces.profile import Along
from stiction.surfaces.surface import Surface

MOST_OFFSETS = 100_000  # largest number of positions on a pair of lines


class MeasuredLines(MeasuredBodies):
    """Lines of two measured files, the upper carried along the lower."""

    case: ClassVar[str] = "lines of measured files"
    pressed: ClassVar[str] = "Lines"
    is_areal: ClassVar[bool] = False

    press: Literal["lines"] = Field(default="lines", description="Lines of both, the upper carried along the lower.")
    level: Literal["line", "quadratic", "mean", "none"] = Field(
        default="line", description="What is taken off each line."
    )
    along: Along = Field(default="x", description="Whether lines of maps are rows or columns.")
    offsets: int = Field(
        default=1, ge=1, le=MOST_OFFSETS,
        description="Positions on each pair of lines; of two profiles without surrogates every member is a position.",
    )  # fmt: skip
    travel: LengthOrZero | None = Field(
        default=None,
        description="The largest offset; by default half of the length of one pair, and none of several pairs.",
    )
    replace: Surrogates = Field(
        default="none", description="Which of the two is replaced by its surrogate, a new one for each line."
    )

    positions: tuple[int, ...] | None = Field(
        default=None, description="Points of the lower of two prepared profiles before the slider, one position each."
    )

    def members(self, scans: tuple[Body, Body], wavelength: float, seed: int) -> Lines | LinesAt:
        """Lines of both scans, or of what replaces them, at positions on each other."""
        if self.positions is not None:
            uppers, lowers = (scan if isinstance(scan, tuple) else (scan,) for scan in scans)
            return LinesAt(uppers, lowers, self.positions)
        upper, lower = self.filtered(scans, wavelength)
        level: ProfileTrend | None = None if self.level == "none" else self.level
        travel = None if self.travel is None else float(self.travel)
        several = self.replace != "none" or isinstance(upper, Surface) or isinstance(lower, Surface)
        pairs = LinePairs(upper, lower, travel, level, self.along, self.replace, seed, several=several)
        return Lines(pairs, scans, self.offsets)


@dataclass(frozen=True, eq=False)
class Lines:
    """Members that are pairs of lines."""

    pairs: LinePairs
    scans: tuple[Body, Body]
    offsets: int = 1  # positions on each pair, where there are several pairs; of one pair every member is a position

    def member(self, index: int) -> Member:
        """A slider at a position on what it is carried over."""
        pairs, offsets = self.pairs, self.offsets
        line, place = divmod(index, offsets) if pairs.several else (0, index)
        most = pairs.most()
        if most is not None and line >= most:
            raise ValueError(f"the surfaces have {most} pairs of lines, and member {index} is on pair {line + 1}")
        slider, track = pairs.pair(line)
        room = len(track) - len(slider)
        if room == 0 and place > 0:
            raise ValueError("several positions need a travel, for which the slider is shortened")
        # A line on itself is no pair at 0; several lines are not on themselves.
        alone = pairs.several and offsets == 1 and pairs.travel is None
        if alone or room == 0:
            steps = 0
        elif offsets == 1 and pairs.travel is not None and place == 0:
            steps = room  # one position: the travel that was asked for
        else:
            steps = 1 + min(int(spread(place + 1, 1)[0] * room), room - 1)
        offset = steps * slider.spacing
        pair = slider, lower_piece(track, offset, slider)
        return Member(pair, offset, pairs.place(line), line=line, surrogate=pairs.surrogates != "none")

    def facts(self) -> Facts:
        """What all members share."""
        slider, track = self.pairs.pair(0)
        scans: Any = self.scans
        return Facts(
            slider, track, slider.extent * THICKNESS, [len(slider)], [slider.spacing], [len(slider) / len(track)] * 2,
            [np.atleast_1d(scan.spacing) for scan in scans], [np.atleast_1d(scan.extent) for scan in scans],
        )  # fmt: skip


@dataclass(frozen=True, eq=False)
class LinesAt:
    """Members that are profiles as they are: each upper one at given positions (points) on the lower of its place."""

    uppers: tuple[Any, ...]
    lowers: tuple[Any, ...]
    positions: tuple[int, ...]

    def member(self, index: int) -> Member:
        """A slider at one of the positions, those of a pair one after the other."""
        line, place = divmod(index, len(self.positions))
        slider, offset = self.uppers[line], self.positions[place] * self.uppers[line].spacing
        return Member((slider, lower_piece(self.lowers[line], offset, slider)), offset, 0.0, line=line)

    def facts(self) -> Facts:
        """What all members share, those of the first pair."""
        slider, track = both = self.uppers[0], self.lowers[0]
        return Facts(
            slider, track, slider.extent * THICKNESS, [len(slider)], [slider.spacing], [1.0, len(slider) / len(track)],
            [np.atleast_1d(body.spacing) for body in both], [np.atleast_1d(body.extent) for body in both],
        )  # fmt: skip
