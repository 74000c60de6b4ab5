"""Section `[surfaces]` of a study of measured bodies: scan files, reading options, and pairs to compute."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import Annotated, Any, ClassVar, Literal, Self

import numpy as np
from pydantic import AfterValidator, Field, model_validator

from stiction._checks import Floats
from stiction._units import quantity
from stiction.study.measured_bodies import CutoffPair, MeasuredBody, MeasuredBodySettings, ScanCutoffs
from stiction.study.member_names import MIXED_MEMBER_NAMES, POSITION_NAMES, SURROGATE_PAIR_NAMES, MemberNames
from stiction.study.member_sources import (
    GapMemberSource,
    LineMemberSource,
    MapMemberSource,
    MemberSource,
    build_map_pairs,
)
from stiction.study.values import (
    CutOffs,
    LengthOrZero,
    SettingsSectionVariant,
    SignedLength,
    list_to_tuple_validator,
    make_key_error,
    require_distinct,
    to_value_array,
)
from stiction.surfaces.cut_off import MAX_CUTOFF_FRACTION, cut_off
from stiction.surfaces.filters import validate_cutoff
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.pairing import (
    SIDES,
    IsotropicSurfacePairs,
    LinePairs,
    SurfacePairsFromSpectra,
    SurrogateBodies,
    to_joined_spectrum,
)
from stiction.surfaces.preparation import ProfileTrend, flipped, levelled
from stiction.surfaces.profile import LineOrientation, Profile
from stiction.surfaces.surface import Surface


class CommonMeasuredSurfaceSettings(SettingsSectionVariant):
    """Keys of the section `[surfaces]` that all studies of measured surfaces have."""

    bodies: ClassVar[str] = "measured areas"
    is_areal: ClassVar[bool] = True
    """True if the members are pairs of height maps, and False if they are pairs of profiles."""
    pressed: ClassVar[str]
    """Name of the pressed bodies in reports, such as "Profiles"."""

    kind: Literal["measured"] = Field(default="measured", description="Kind of surfaces: two measured files.")
    upper: MeasuredBodySettings = Field(
        description="Slider: a section with `file` and reading options, or "
        "a list of sections for several places on the part."
    )
    lower: MeasuredBodySettings = Field(description="Counterface; may be the same file as the slider.")
    cut_off: CutOffs = Field(
        default=(quantity("0 um", "length"),),
        description="Cutoff wavelength of the Gaussian low-pass filter for both bodies; 0 for no filter. With a list, "
        "the cutoff is a dimension of the result, and the result at the first value is quoted.",
    )
    vouched: Literal[True] | None = Field(
        default=None, description="True if all wavelengths are attributed to the surfaces, whatever their spectra."
    )

    both_readings: Literal[True] | None = Field(
        default=None,
        description="True if `pair` added a second cutoff because some wavelengths may not belong to the surface: the "
        "interval at the first cutoff then also covers the interval at the second.",
    )

    @property
    def member_names(self) -> MemberNames:
        """Word that output uses for the members: positions, or pairs of surrogates."""
        return POSITION_NAMES

    def cell_coordinates(self) -> dict[str, Floats]:
        """Return the cutoff wavelengths (µm) of the study.

        A result has one cell per cutoff.
        """
        return {"cut_off": to_value_array(self.cut_off)}

    def reported_cut_off(self) -> float:
        """Return the cutoff (µm) whose result is quoted: the first cutoff of the study."""
        return float(self.cell_coordinates()["cut_off"][0])

    def get_scan_cut_offs(self, wavelength: float) -> ScanCutoffs:
        """Return the cutoff (µm) of each scan of both bodies: `wavelength`, or the scan's maximum cutoff if smaller."""
        upper, lower = (
            tuple(scan.select_cut_off_of_scan(wavelength) for scan in getattr(self, side).scans) for side in SIDES
        )
        return upper, lower

    def with_changed_files(self, change: Callable[[MeasuredBodySettings, str], MeasuredBodySettings]) -> Self:
        """Return a copy of the section with both bodies replaced by `change(body, side)`."""
        return self.model_copy(update={side: change(getattr(self, side), side) for side in SIDES})

    @property
    def first_scan_member_index(self) -> int:
        """Index of the first member that consists of scans. Members with a smaller index are surrogates."""
        return 0

    @property
    def scan_counts(self) -> tuple[int, int]:
        """Numbers of scans of the upper and of the lower body."""
        return len(self.upper.scans), len(self.lower.scans)

    def scan_indices_of_members(self, members: Any) -> tuple[Any, Any]:
        """Return two indices for each member: of the upper and of the lower scan from which the member is cut.

        Successive members use all combinations of upper and lower scans in turn.
        """
        upper, lower = self.scan_counts
        pair_index = members % (upper * lower)
        return pair_index % upper, (pair_index + pair_index // math.lcm(upper, lower)) % lower

    def build_member_source(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair, seed: int
    ) -> MemberSource:
        """Return a source of members that are cut from two scans after low-pass filtering at `cut_offs` (µm).

        Raises a `ValueError` if the scans form no members.
        """
        raise NotImplementedError

    def filter_scans(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair
    ) -> Iterator[Profile | Surface]:
        """Yield the upper and the lower scan, each low-pass filtered at its cutoff (µm; 0 means no filter)."""
        for scan, wavelength in zip(scans, cut_offs, strict=True):
            if isinstance(scan, JoinedSpectrum):
                press = type(self).model_fields["press"].default
                raise ValueError(f'surfaces.press must be "surrogates" for a spectrum, got "{press}"')
            if wavelength > 0:
                validate_cutoff("cutoff", wavelength, scan, longest=MAX_CUTOFF_FRACTION)
            yield cut_off(scan, wavelength) if wavelength > 0 else scan


# ---- Lines -----------------------------------------------------------------------------------------------------------

DEFAULT_NUM_SHIFTS = 16
DEFAULT_NUM_SURROGATES = 16
MAX_RELATIVE_POSITIONS = 100_000


class MeasuredLineSettings(CommonMeasuredSurfaceSettings):
    """Keys of the section `[surfaces]` for measured profiles, or for lines of measured maps.

    The upper profile is the slider.
    """

    place: ClassVar[str] = "lines of measured files"
    pressed: ClassVar[str] = "Profiles"
    bodies: ClassVar[str] = "measured lines"
    is_areal: ClassVar[bool] = False

    press: Literal["lines"] = Field(
        default="lines", description="Profiles, or lines of height maps; the upper one slides along the lower one."
    )
    level: Literal["line", "quadratic", "mean", "none"] = Field(
        default="line", description="Form to remove from each line."
    )
    along: LineOrientation = Field(default="x", description="Direction of the lines in a map: rows or columns.")
    offsets: int = Field(
        default=1, ge=1, le=MAX_RELATIVE_POSITIONS,
        description="Number of positions on each pair of lines. For two profiles without surrogates, each member is "
        "one position.",
    )  # fmt: skip
    travel: LengthOrZero | None = Field(
        default=None,
        description="Largest offset; by default half the length of a single pair, and 0 for several pairs.",
    )
    lay_assumed: Literal[True] | None = Field(
        default=None,
        description="True if `pair` assumed the lay of two profiles: the result has a caveat if the lay matters.",
    )
    replace: SurrogateBodies = Field(
        default="none", description="Bodies that are replaced by their surrogates, with a new surrogate for each line."
    )

    positions: (
        Annotated[
            tuple[LengthOrZero, ...], list_to_tuple_validator, Field(min_length=1, max_length=MAX_RELATIVE_POSITIONS),
            AfterValidator(require_distinct),
        ]
        | None
    ) = Field(
        default=None,
        description="Positions of the slider on the lower line, instead of `offsets` and `travel`. The slider is "
        "shortened if it would extend beyond the end of the line.",
    )  # fmt: skip

    @model_validator(mode="after")
    def _require_one_position_key(self) -> Self:
        if self.positions is not None and (self.offsets > 1 or self.travel is not None):
            raise make_key_error("positions", "must not be given with offsets or travel")
        return self

    def build_member_source(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair, seed: int
    ) -> LineMemberSource:
        """Return the source of members: pairs of profiles, of scan lines or of surrogates, at several positions."""
        upper, lower = self.filter_scans(scans, cut_offs)
        level: ProfileTrend | None = None if self.level == "none" else self.level
        positions = None if self.positions is None else tuple(map(float, self.positions))
        travel = max(positions) if positions else None if self.travel is None else float(self.travel)
        has_several_pairs = self.replace != "none" or isinstance(upper, Surface) or isinstance(lower, Surface)
        pairs = LinePairs(
            upper, lower, travel, level, self.along, self.replace, seed, has_several_pairs=has_several_pairs
        )
        return LineMemberSource(pairs, scans, self.offsets, positions)


class MeasuredMapSettings(CommonMeasuredSurfaceSettings):
    """Keys of the section `[surfaces]` for two measured height maps at several relative positions."""

    place: ClassVar[str] = "areas of measured maps"
    pressed: ClassVar[str] = "Height maps"

    press: Literal["areas"] = Field(default="areas", description="Height maps at several relative positions.")
    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="Form to remove from each map and from each pressed piece."
    )
    rotate: float = Field(default=0.0, ge=-360, le=360, description="Rotation of the upper map, degrees.")
    surrogates: int = Field(
        default=0, ge=0, le=1_000_000,
        description="Number of members that are pairs of surrogates: random surfaces with the same spectra. They come "
        "first.",
    )  # fmt: skip

    gap: Literal[True] | None = Field(
        default=None, description="True if the single file is the gap between two faces, which is pressed unchanged."
    )
    positions: (
        Annotated[
            tuple[Annotated[tuple[SignedLength, SignedLength], list_to_tuple_validator], ...], list_to_tuple_validator,
            Field(min_length=1, max_length=MAX_RELATIVE_POSITIONS), AfterValidator(require_distinct),
        ]
        | None
    ) = Field(
        default=None,
        description="Shifts (x, y) of the first point of the upper map relative to the first point of the lower map. "
        "At all positions, areas of the size of the smallest overlap are pressed.",
    )  # fmt: skip

    @property
    def member_names(self) -> MemberNames:
        """Word that output uses for the members: positions, pairs of surrogates, or both."""
        return MIXED_MEMBER_NAMES if self.surrogates else POSITION_NAMES

    @property
    def first_scan_member_index(self) -> int:
        """Index of the first member that consists of scans. Members with a smaller index are surrogates."""
        return self.surrogates

    def build_member_source(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair, seed: int
    ) -> MapMemberSource | GapMemberSource:
        """Return the source of members: pairs of surrogates or of map pieces, or one member from a measured gap."""
        upper, lower = self.filter_scans(scans, cut_offs)
        if not (isinstance(upper, Surface) and isinstance(lower, Surface)):
            raise ValueError('surfaces.press must be "lines" or "surrogates" for a profile, got "areas"')
        if self.gap:
            gap = levelled(lower, self.level)
            grid_arguments: dict[str, Any] = {"spacing": gap.spacing, "missing": gap.missing}
            flat_face = Surface(np.zeros_like(gap.heights), history=("a flat face",), **grid_arguments)
            rough_face = Surface(
                0.0 - gap.heights, history=(*gap.history, "a gap, below a flat face"), **grid_arguments
            )
            return GapMemberSource(flat_face, rough_face)
        shifts = None if self.positions is None else tuple((float(x), float(y)) for x, y in self.positions)
        pairs = build_map_pairs(upper, lower, self.level, seed, rotation=self.rotate, shifts=shifts)
        return MapMemberSource(pairs, scans, self.surrogates)


class SurrogateSettings(CommonMeasuredSurfaceSettings):
    """Keys of the section `[surfaces]` for surrogates: random height maps with the spectra of two scans."""

    place: ClassVar[str] = "surrogates of measured files"
    pressed: ClassVar[str] = "Random height maps with the spectra of the two scans"

    press: Literal["surrogates"] = Field(
        default="surrogates", description="Random height maps with the spectra of the two scans."
    )

    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="Form to remove from each file; a plane is a straight line for a profile."
    )

    @property
    def member_names(self) -> MemberNames:
        """Word that output uses for the members: pairs of surrogates."""
        return SURROGATE_PAIR_NAMES

    def build_member_source(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair, seed: int
    ) -> MapMemberSource:
        """Return the source of ensemble members: pairs of random height maps with the spectra of two scans."""
        upper_scan, lower_scan = scans
        if isinstance(upper_scan, JoinedSpectrum) or isinstance(lower_scan, JoinedSpectrum):
            shortest_cutoff = float(self.cell_coordinates()["cut_off"].min())
            return MapMemberSource(
                SurfacePairsFromSpectra(
                    to_joined_spectrum(upper_scan),
                    to_joined_spectrum(lower_scan),
                    self.level,
                    seed,
                    cut_offs,
                    shortest_cutoff,
                ),
                scans,
            )
        upper, lower = self.filter_scans(scans, cut_offs)
        if isinstance(upper, Surface) and isinstance(lower, Surface):
            return MapMemberSource(build_map_pairs(upper, lower, self.level, seed), scans)
        if not (isinstance(upper, Profile) and isinstance(lower, Profile)):
            raise ValueError('surfaces.press = "surrogates" needs two maps or two profiles, got a map and a profile')
        trend: ProfileTrend = "line" if self.level == "plane" else self.level
        return MapMemberSource(
            IsotropicSurfacePairs(flipped(levelled(upper, trend)), levelled(lower, trend), "plane", seed), scans
        )


MeasuredSurfaceSettings = MeasuredMapSettings | MeasuredLineSettings | SurrogateSettings
"""Section `[surfaces]` of a study of measured files: one class for lines, for maps and for surrogates."""
