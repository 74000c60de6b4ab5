"""Sources of members for measured surfaces: pairs of lines, map pieces or surrogates."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, Protocol

import numpy as np

from stiction._caching import cached_property
from stiction.mechanics.model import PROFILE_WIDTH
from stiction.mechanics.quantities import MAX_STORED_VALUE
from stiction.study.measured_bodies import BodyPair, MeasuredBody
from stiction.study.stored_values import POSITIVE_STORED_VALUE_BOUNDS, AttributeSpec
from stiction.surfaces.pairing import (
    SIDES,
    IsotropicSurfacePairs,
    LinePairs,
    MapPairs,
    SurfacePairsFromSpectra,
    piece_below_slider,
    quasi_random_point,
)
from stiction.surfaces.preparation import SurfaceTrend, flipped, levelled, rotated
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


@dataclass(frozen=True)
class EnsembleMember:
    """Member of a study: two bodies, their relative shift (µm), line number, and whether the bodies are surrogates."""

    pair: BodyPair
    x: float
    y: float
    line: int = 0
    surrogate: bool = False


@dataclass(frozen=True)
class SharedMemberProperties:
    """Bodies, area and grid that all members of a study have in common.

    Lengths are in µm. Lists contain one number per axis: (x,) for profiles, (y, x) for surfaces.
    """

    upper: MeasuredBody
    lower: MeasuredBody
    area: float
    shape: Sequence[int]
    spacing: Sequence[float]
    piece_fractions: Sequence[float]
    scans: Sequence[Any]


BODY_ATTRIBUTE_SPECS: dict[str, AttributeSpec] = {
    **{side: AttributeSpec(dtype=str) for side in SIDES},
    "shape": AttributeSpec(dtype=int, sizes=(1, 2), bounds=(1, MAX_STORED_VALUE)),
    "spacing_um": AttributeSpec(sizes=(1, 2), bounds=POSITIVE_STORED_VALUE_BOUNDS),
    "fraction_used": AttributeSpec(sizes=(2,), bounds=(0, MAX_STORED_VALUE)),
    **{
        f"{side}_{name}_um": AttributeSpec(sizes=(1, 2), bounds=POSITIVE_STORED_VALUE_BOUNDS)
        for side in SIDES
        for name in ("spacing", "extent")
    },
    # Interpolated fraction of a scan, and size of its largest unmeasured region (in maps µm², in profiles µm).
    **{f"{side}_filled": AttributeSpec(sizes=(2,), bounds=(0, MAX_STORED_VALUE), is_required=False) for side in SIDES},
    # Fraction of a scan's points that are missing and lie between measured points.
    **{f"{side}_pierced": AttributeSpec(sizes=(1,), bounds=(0, 1), is_required=False) for side in SIDES},
    # Ratio of the rms slopes of a map across and along its lay, stored if both maps have a lay.
    **{f"{side}_lay": AttributeSpec(sizes=(1,), bounds=(1, MAX_STORED_VALUE), is_required=False) for side in SIDES},
    # Two numbers: drift of ln(rms slope) along a scan, and contribution of the scan to the gap's mean square slope.
    **{f"{side}_drift": AttributeSpec(sizes=(2,), bounds=(0, MAX_STORED_VALUE), is_required=False) for side in SIDES},
}
"""Specifications of the attributes in a result that describe measured bodies. Values for several axes are in the order
of array axes.
"""


@dataclass(frozen=True)
class BodyAttributes:
    """Nominal area, grid, processing history and other attributes of measured bodies, as stored in a result.

    Both are empty for generated bodies.
    """

    nominal_area: float | None = None  # µm², of one member
    attributes: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def from_values(cls, nominal_area: float, values: Mapping[str, Any]) -> BodyAttributes:
        """Create body attributes from a nominal area (µm²) and named values, converted to the stored data types."""
        return cls(nominal_area, {name: BODY_ATTRIBUTE_SPECS[name].encode(value) for name, value in values.items()})


class MemberSource(Protocol):
    """Source of the members of a study: returns the pair of bodies of the member with a given index."""

    def member(self, index: int) -> EnsembleMember:
        """Return the member (pair of bodies) with a given index.

        Raises a `ValueError` if the source has fewer members.
        """

    def find_shared_properties(self) -> SharedMemberProperties:
        """Return the bodies, the nominal area and the grid that all members have in common."""


MAX_CACHED_LINE_PAIRS = 4


@dataclass(frozen=True, eq=False)
class LineMemberSource:
    """Source of members that are pairs of profiles, or pairs of lines of height maps."""

    pairs: LinePairs
    scans: tuple[MeasuredBody, MeasuredBody]
    offsets: int = 1
    # Relative positions (µm); None for positions from a quasi-random sequence.
    positions: tuple[float, ...] | None = None

    def member(self, index: int) -> EnsembleMember:
        """Return the member with a given index: the slider, and the part of the counterface under the slider."""
        pairs, num_offsets = self.pairs, self.offsets if self.positions is None else len(self.positions)
        line, offset_index = divmod(index, num_offsets) if pairs.has_several_pairs else (0, index)
        max_pair_count = pairs.max_pair_count()
        if max_pair_count is not None and line >= max_pair_count:
            raise ValueError(
                f"the surfaces have {max_pair_count} pairs of lines, but member {index} needs pair {line + 1}"
            )
        slider, counterface = self._get_pair(line)
        max_steps = len(counterface) - len(slider)
        if self.positions is not None:
            if offset_index >= num_offsets:
                raise ValueError(
                    f"surfaces.positions has {num_offsets} positions, "
                    f"but member {index} needs position {offset_index + 1}"
                )
            return self._member_at(slider, counterface, round(self.positions[offset_index] / slider.spacing), line)
        if max_steps == 0 and offset_index > 0:
            raise ValueError("several positions require a slider that is shorter than its counterface; give a travel")
        # If there is only one pair of lines, the slider is shifted, because both lines may come from the same scan.
        is_unshifted = pairs.has_several_pairs and num_offsets == 1 and pairs.travel is None
        if is_unshifted or max_steps == 0:
            offset_steps = 0
        elif num_offsets == 1 and pairs.travel is not None and offset_index == 0:
            # With a travel but only one relative position, the slider is placed at the end of the travel.
            offset_steps = max_steps
        else:
            offset_steps = 1 + min(int(quasi_random_point(offset_index + 1, 1)[0] * max_steps), max_steps - 1)
        return self._member_at(slider, counterface, offset_steps, line)

    @cached_property
    def _get_pair(self) -> Callable[[int], tuple[Profile, Profile]]:
        """Cached function that returns the pair of lines with a given number.

        Several members use each pair.
        """
        return functools.lru_cache(MAX_CACHED_LINE_PAIRS)(self.pairs.pair)

    def _member_at(self, slider: Profile, counterface: Profile, steps: int, line: int) -> EnsembleMember:
        """Return the member whose slider is shifted by `steps` grid points from the start of the counterface."""
        offset = steps * slider.spacing
        pair = slider, piece_below_slider(counterface, offset, slider)
        return EnsembleMember(
            pair, offset, self.pairs.position_across_lines(line), line=line, surrogate=self.pairs.surrogates != "none"
        )

    def find_shared_properties(self) -> SharedMemberProperties:
        """Return the profiles, the nominal area and the grid that all members have in common."""
        slider, counterface = self.pairs.pair(0)
        return _find_properties_shared_by_line_members(slider, counterface, len(slider) / len(counterface), self.scans)


def _find_properties_shared_by_line_members(
    slider: Profile, counterface: Profile, used_fraction: float, scans: tuple[Any, Any]
) -> SharedMemberProperties:
    """Return the profiles, the nominal area and the grid that all members of a study of profiles have in common.

    `used_fraction` is the fraction of the upper scan that the slider covers.
    """
    return SharedMemberProperties(
        slider, counterface, slider.extent * PROFILE_WIDTH, [len(slider)], [slider.spacing],
        [used_fraction, len(slider) / len(counterface)], scans,
    )  # fmt: skip


def build_map_pairs(
    upper: Surface, lower: Surface, level: SurfaceTrend, seed: int, *, rotation: float = 0.0,
    shifts: tuple[tuple[float, float], ...] | None = None,
) -> MapPairs:  # fmt: skip
    """Level two height maps, flip the upper map, and return a source of members: pairs of overlapping map pieces.

    The upper map is also rotated by an angle in degrees.
    """
    levelled_upper = levelled(upper, level)
    return MapPairs(
        flipped(rotated(levelled_upper, rotation) if rotation else levelled_upper),
        levelled(lower, level),
        level,
        seed,
        shifts,
    )


@dataclass(frozen=True, eq=False)
class MapMemberSource:
    """Source of ensemble members, each a pair of height maps: pieces of two scans, or surrogates of both scans."""

    pairs: MapPairs | IsotropicSurfacePairs | SurfacePairsFromSpectra
    scans: tuple[MeasuredBody, MeasuredBody]
    # Members with an index below this number are pairs of surrogates; None if all members are pairs of surrogates.
    surrogates: int | None = None

    def member(self, index: int) -> EnsembleMember:
        """Return the member with a given index: two surrogates, or two overlapping pieces of the maps."""
        pairs, num_surrogates = self.pairs, self.surrogates
        if num_surrogates is None or index < num_surrogates:
            return EnsembleMember(pairs.surrogates(index), np.nan, np.nan, surrogate=True)
        assert isinstance(pairs, MapPairs)
        shift_index = index - num_surrogates
        if shift_index >= pairs.max_pair_count():
            raise ValueError(
                f"the maps have {pairs.max_pair_count()} relative positions, but member {index} needs position "
                f"{shift_index + 1}"
            )
        return EnsembleMember(pairs.pair(shift_index), *pairs.map_shift(shift_index))

    def find_shared_properties(self) -> SharedMemberProperties:
        """Return the height maps, the nominal area and the grid that all members have in common."""
        pairs = self.pairs
        scans: Sequence[Any] = self.scans
        # The shortest wavelength of a scan is two grid spacings.
        if isinstance(pairs, SurfacePairsFromSpectra):
            wavelengths = (max(body.shortest, pairs.shortest_cutoff) for body in (pairs.upper, pairs.lower))
            scans = [
                SimpleNamespace(spacing=shortest_wavelength / 2, extent=pairs.side_length)
                for shortest_wavelength in wavelengths
            ]
        return SharedMemberProperties(
            pairs.upper, pairs.lower, pairs.piece_area, pairs.shape, pairs.spacing, pairs.piece_fractions, scans
        )


@dataclass(frozen=True, eq=False)
class GapMemberSource:
    """Source of the single member of a measured gap: a flat face above a rough face."""

    flat: Surface
    rough: Surface

    def member(self, index: int) -> EnsembleMember:
        """Return the single member of this source: a flat face and a rough face."""
        if index > 0:
            raise ValueError(f"member index of a gap must be 0, got {index}; a gap has a single relative position")
        return EnsembleMember((self.flat, self.rough), 0.0, 0.0)

    def find_shared_properties(self) -> SharedMemberProperties:
        """Return the faces, the nominal area and the grid of the source's only member."""
        faces = self.flat, self.rough
        return SharedMemberProperties(
            *faces, float(np.prod(self.rough.extent)), self.rough.heights.shape, self.rough.spacing, [1.0, 1.0], faces
        )  # fmt: skip
