"""The table `[surfaces]` of a study of measured bodies: files, how they are read, and the members they make."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any, ClassVar, Literal, Protocol, Self, get_args

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, PlainValidator, model_validator

from stiction._checks import Floats
from stiction._errors import ArgumentError
from stiction._text import printable_path
from stiction._units import Quantity, quantity, short_repr
from stiction.mechanics.model import THICKNESS
from stiction.studies.values import (
    Case,
    CutOffs,
    Length,
    LengthOrZero,
    SignedLength,
    Table,
    array_of,
    as_tuple,
    as_written,
    fault_at,
    read_length,
    require_different,
    written,
)
from stiction.surfaces.cut_off import MAX_CUTOFF_FRACTION, cut_off
from stiction.surfaces.filters import checked_cutoff
from stiction.surfaces.interchange import extract_heights
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.measured.interpret import Missing, Outliers
from stiction.surfaces.measured.plausibility import CAVEATS, Scan, find_caveats
from stiction.surfaces.measured.raw import LENGTH_UNITS, Caveat
from stiction.surfaces.measured.reading import Reading, load_reading
from stiction.surfaces.measured.spectrum_file import is_spectrum, read_spectrum, write_spectrum
from stiction.surfaces.measured.writing import heights_with_nan, write_profile, write_surface
from stiction.surfaces.missing_data import find_largest_gap
from stiction.surfaces.pairing import (
    SIDES,
    IsotropicPairs,
    LinePairs,
    MapPairs,
    SpectrumPairs,
    Surrogates,
    piece_below_slider,
    quasi_random_point,
    to_joined_spectrum,
)
from stiction.surfaces.preparation import ProfileTrend, SurfaceTrend, flipped, levelled, rotated
from stiction.surfaces.profile import Along, Profile
from stiction.surfaces.surface import Surface, parse_lengths

Column = int | str
Body = Profile | Surface | JoinedSpectrum  # what a file may hold
MAX_PATH_LENGTH_OF_FILE = 4096  # characters
Texture = Literal["turned", "milled", "ground", "honed", "lapped", "sanded", "blasted", "eroded"]
TEXTURES: tuple[str, ...] = get_args(Texture)
Pair = tuple[Profile, Profile] | tuple[Surface, Surface]
CutOffPair = tuple[float, float]  # of the upper and of the lower scan, µm


def _unit(value: object) -> str:
    if not isinstance(value, str) or value not in LENGTH_UNITS:
        raise ValueError(f"must be a unit of length ({', '.join(LENGTH_UNITS)}) or two, got {short_repr(value)}")
    return value


def _column(value: object) -> Column:
    if isinstance(value, bool) or not isinstance(value, (str, int)) or (isinstance(value, int) and value < 0):
        raise ValueError(f"must be a name or a number from 0 on, got {short_repr(value)}")
    return value


def _marks(value: object) -> tuple[float | str, ...] | None:
    """Return numbers and words that mark missing points, as a tuple."""
    if value is None:
        return None
    parts: Any = value.split(",") if isinstance(value, str) else value
    parts = parts if isinstance(parts, (list, tuple)) else [parts]
    if not parts or not all(isinstance(part, (str, int, float)) and not isinstance(part, bool) for part in parts):
        raise ValueError(f"must be a number or a word, or a list of them, got {short_repr(value)}")
    return tuple(part.strip() if isinstance(part, str) else part for part in parts)


def _accepted(value: object) -> tuple[str, ...] | None:
    """Return names of caveats as a tuple."""
    if value is None:
        return None
    names = [part.strip() for part in value.split(",")] if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not set(names) <= set(CAVEATS):
        raise ValueError(f"must be one of {', '.join(CAVEATS)}, or a list of them, got {short_repr(value)}")
    return tuple(names)


def _crop(value: object) -> tuple[Quantity, ...] | None:
    if value is None:
        return None
    texts = value.split(",") if isinstance(value, str) else value
    if not isinstance(texts, (list, tuple)) or len(texts) not in (2, 4):
        raise ValueError(f'must be "x0,x1" or "x0,x1,y0,y1", got {short_repr(value)}')
    return tuple(quantity(text.strip() if isinstance(text, str) else text, "length") for text in texts)


def _one_or_two(read: Callable[[object], Any], most: int = 2) -> PlainValidator:
    """A value, a list of two or up to `most`, or none."""

    def values(value: object) -> Any:
        if not isinstance(value, (list, tuple)):
            return None if value is None else read(value)
        if not 2 <= len(value) <= most:
            allowed = "two" if most == 2 else f"two to {most}"
            raise ValueError(f"must be one value or a list of {allowed}, got {short_repr(value)}")
        return tuple(map(read, value))

    return PlainValidator(values)


MIN_HEIGHT_FACTOR, MAX_HEIGHT_FACTOR = 0.01, 100.0  # factors of the heights of a file


class InMemory:
    """A surface in memory, without a file. Not a dataclass, so that a study keeps it as an object when it is copied."""

    def __init__(self, body: Any) -> None:
        self.body = body


class MeasuredFile(Table):
    """A file that holds a measured profile or surface, and how it is read, or a spectrum of several; or such a body."""

    model_config = ConfigDict(arbitrary_types_allowed=True)

    def __eq__(self, other: object) -> bool:
        """Compare all but the body itself, of which the checksum is compared."""
        return isinstance(other, MeasuredFile) and self._compared() == other._compared()

    def __hash__(self) -> int:
        return hash(self._compared())

    def _compared(self) -> tuple[Any, ...]:
        return tuple(value for name, value in self if name != "body")

    file: str = Field(min_length=1, max_length=MAX_PATH_LENGTH_OF_FILE, description="Name of the file.")
    sha256: str | None = Field(
        default=None, pattern="^[0-9a-f]{64}$", description="Checksum; another file of this name is refused."
    )
    unit: Annotated[str | tuple[str, str] | None, _one_or_two(_unit)] = Field(
        default=None, description="Unit of all lengths in the file, or of positions and of heights."
    )
    spacing: Annotated[Quantity | tuple[Quantity, Quantity] | None, _one_or_two(read_length), as_written] = Field(
        default=None, description="Distance of neighbouring points, or of rows and of columns."
    )
    channel: Annotated[Column | None, PlainValidator(lambda value: None if value is None else _column(value))] = Field(
        default=None, description="What to read of a file of several channels or sheets."
    )
    columns: Annotated[Column | tuple[Column, ...] | None, _one_or_two(_column, most=3)] = Field(
        default=None, description="Columns of positions and of heights, of x, y and z, or of heights, of a table."
    )
    missing: Missing = Field(default="error", description="What to do about points without a height.")
    outliers: Outliers = Field(default="keep", description="Whether single points that stand out are missing ones.")
    crop: Annotated[tuple[Quantity, ...] | None, PlainValidator(_crop), as_written] = Field(
        default=None, description="What to read of it: first and last x, and of a map first and last y."
    )
    missing_value: Annotated[tuple[float | str, ...] | None, PlainValidator(_marks)] = Field(
        default=None, description="Numbers, as they stand in the file, or words that mark points without a height."
    )
    accept: Annotated[tuple[str, ...] | None, PlainValidator(_accepted)] = Field(
        default=None, description="Names of caveats of the file that are settled."
    )
    tip: Length | None = Field(
        default=None, description="Radius of the stylus or probe; it says which waves are its own."
    )
    texture: Texture | None = Field(
        default=None, description="How it was machined: lines and humps in its spectrum are then the surface's."
    )
    max_cut_off: LengthOrZero | None = Field(
        default=None, description="Longest cutoff at which this scan is filtered, 0 for none; by default any."
    )
    height_factor: float = Field(
        default=1.0,
        ge=MIN_HEIGHT_FACTOR,
        le=MAX_HEIGHT_FACTOR,
        description="Factor of the heights, as another finish would change them.",
    )
    body: InMemory | None = Field(default=None, repr=False, description="The body itself, in Python.")
    others: Annotated[tuple[MeasuredFile, ...], as_tuple] | None = Field(
        default=None, description="Scans of other places on the same part; a list of files is the first and these."
    )

    @model_validator(mode="before")
    @classmethod
    def _of_a_list(cls, value: Any) -> Any:
        if not isinstance(value, (list, tuple)) or not value:
            return value
        first, *others = ({"file": each} if isinstance(each, str) else each for each in value)
        return {**first, "others": tuple(others)} if isinstance(first, Mapping) else first

    @property
    def scans(self) -> tuple[MeasuredFile, ...]:
        """The file itself, and those of other places on the same part."""
        return self, *(self.others or ())

    @property
    def name(self) -> str:
        """Name of the file without its folder, and how many more there are."""
        return Path(self.file).name + (f" and {len(self.others)} more" if self.others else "")

    def _each(self, change: Callable[[MeasuredFile], MeasuredFile]) -> MeasuredFile:
        return change(self).model_copy(update={"others": self.others and tuple(map(change, self.others))})

    @classmethod
    def holding(cls, body: Any, name: str) -> MeasuredFile:
        """A body in memory by a name; those of other libraries as ours. An `ArgumentError` if it is none."""
        if not isinstance(body, JoinedSpectrum):
            try:
                heights, spacing, history, missing = extract_heights(name, body)
            except ValueError as error:
                raise ArgumentError(f"{{{name}}}{{why}}", why=str(error).removeprefix(name)) from None
            kind: Any = Profile if heights.ndim == 1 else Surface
            body = kind(
                heights, spacing=spacing[0] if kind is Profile else parse_lengths("spacing", spacing), history=history,
                missing=missing,
            )  # fmt: skip
        return cls(file=name, sha256=_checksum(body), body=InMemory(body))

    def kept(self, folder: Path, side: str) -> MeasuredFile:
        """The same in files: that of a body in memory is written into the folder, under its checksum."""
        return self._each(lambda one: one._kept(folder, side))

    def _kept(self, folder: Path, side: str) -> MeasuredFile:
        if self.body is None:
            return self
        assert self.sha256 is not None
        body = self.body.body
        ending = "csv" if isinstance(body, JoinedSpectrum) else "npy"
        path = (folder / "bodies" / self.sha256[:12] / f"{side}.{ending}").absolute()
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            write: Any = (
                write_spectrum if ending == "csv" else write_profile if body.heights.ndim == 1 else write_surface
            )
            write(body, path)
        holes = not isinstance(body, JoinedSpectrum) and body.missing is not None
        own = {name: getattr(self, name) for name in ("tip", "texture", "max_cut_off", "height_factor")}
        return MeasuredFile(file=str(path), missing="mask" if holes else "error", **own).known()

    def read(self) -> Body:
        """The profile, surface or spectrum of the file, µm; a `ValueError` if its checksum is another."""
        return _with_heights_times(self.height_factor, self._read())  # type: ignore[no-any-return]

    def _read(self) -> Body:
        """Return the body as it was measured."""
        if self.body is not None:
            return self.body.body  # type: ignore[no-any-return]
        if self.sha256 is not None and self.checksum() != self.sha256:
            raise ValueError(
                f"{printable_path(self.file)}: is another file than that which the study was made for: its SHA-256 "
                f"is not {self.sha256[:12]}...; remove sha256 from the study to begin another one with it"
            )
        return _body(self.model_copy(update={"sha256": self.checksum(), "others": None, "height_factor": 1.0}))

    def with_height_factor(self, factor: float) -> MeasuredFile:
        """Return the same scans with heights times a factor; a `ValueError` if the product is out of range."""
        whole = factor * self.height_factor
        if not MIN_HEIGHT_FACTOR <= whole <= MAX_HEIGHT_FACTOR:
            limits = f"from {MIN_HEIGHT_FACTOR:g} to {MAX_HEIGHT_FACTOR:g}"
            raise ValueError(f"height_factor must be {limits}, got {whole:g} of {self.name}")
        return self._each(lambda one: one.model_copy(update={"height_factor": factor * one.height_factor}))

    @property
    def bodies(self) -> list[Profile | Surface]:
        """All scans of the part as they were read, without spectra."""
        return [body for scan in self.scans if isinstance(body := scan.read(), (Profile, Surface))]

    def cut_off_at(self, wavelength: float) -> float:
        """Return the cutoff (µm) of this scan where that of the pair is so much."""
        return wavelength if self.max_cut_off is None else min(wavelength, float(self.max_cut_off))

    def filled(self) -> Floats:
        """Share of the points that are interpolated, and area (length, of a profile) of the largest such hole, µm."""
        if self.missing != "interpolate" or self.body is not None or is_spectrum(Path(self.file)):
            return np.zeros(2)
        body = self.model_copy(update={"missing": "mask"}).read()
        if isinstance(body, JoinedSpectrum) or body.missing is None:
            return np.zeros(2)
        return np.array([body.missing.mean(), find_largest_gap(body.missing)[0] * np.prod(body.spacing)])

    @property
    def reading(self) -> Reading[Any] | None:
        """What was understood of the file; None of a spectrum and of a body in memory."""
        if self.body is not None or is_spectrum(Path(self.file)):
            return None
        return _reading(self.model_copy(update={"sha256": self.checksum(), "others": None}))

    @property
    def caveats(self) -> tuple[Caveat, ...]:
        """Doubts about the file, or about a body in memory by its heights and its spacing."""
        if (reading := self.reading) is not None:
            return tuple(reading.caveats)
        body = None if self.body is None else self.body.body
        if not isinstance(body, (Profile, Surface)):
            return ()
        return find_caveats(Scan(heights_with_nan(body), body.spacings, from_text=False))

    def checksum(self) -> str:
        """SHA-256 of the bytes of the file; a `ValueError` if it cannot be read."""
        try:
            with Path(self.file).open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise ValueError(f"{printable_path(self.file)}: cannot be read: {error.strerror}") from None

    def stamp(self) -> tuple[int, int] | None:
        """Time of the last change of the file and its size; None where there is no file."""
        try:
            status = None if self.body else Path(self.file).stat()
        except OSError:
            return None
        return status and (status.st_mtime_ns, status.st_size)

    def with_absolute_paths(self, directory: Path) -> MeasuredFile:
        """The same with absolute names; one that is not absolute is relative to the directory."""
        return self._each(
            lambda one: one if one.body else one.model_copy(update={"file": str((directory / one.file).absolute())})
        )

    def known(self) -> MeasuredFile:
        """The same with the checksums of the files as they are."""
        return self._each(
            lambda one: one if one.sha256 is not None else one.model_copy(update={"sha256": one.checksum()})
        )


def _with_heights_times(factor: float, body: Any) -> Any:
    """Return a body with heights times a factor."""
    if factor == 1:
        return body
    if isinstance(body, JoinedSpectrum):
        return dataclasses.replace(body, density=body.density * factor**2)
    return body.changed(body.heights * factor, f"heights times {factor:g}")


def _checksum(body: Body) -> str:
    """Return the SHA-256 of a body in memory, with its grid and history."""
    if isinstance(body, JoinedSpectrum):
        content = repr(body.history).encode() + body.density.tobytes()
    else:
        content = repr((body.spacing, body.history)).encode() + heights_with_nan(body).tobytes()
    return hashlib.sha256(content).hexdigest()


@functools.lru_cache(maxsize=16)
def _body(file: MeasuredFile) -> Body:
    """The body in a file, known by its checksum, so that those of a study are taken apart once."""
    if is_spectrum(Path(file.file)):
        for name in ("unit", "spacing", "channel", "columns", "crop"):
            if getattr(file, name) is not None:
                raise ValueError(f"{printable_path(file.file)}: is a spectrum, which has no {name} to be given")
        return read_spectrum(file.file)
    return _reading(file).body


@functools.lru_cache(maxsize=16)
def _reading(file: MeasuredFile) -> Reading[Profile | Surface]:
    return load_reading(
        file.file, unit=file.unit, spacing=written(file.spacing), missing=file.missing, channel=file.channel,
        columns=file.columns, outliers=file.outliers, crop=written(file.crop), missing_value=file.missing_value,
        accept=file.accept,
    )  # fmt: skip


@dataclass(frozen=True)
class Member:
    """One member of measured bodies: the pair, how far its upper body is moved (µm), and what kind of pair it is."""

    pair: Pair
    x: float
    y: float
    line: int = 0
    surrogate: bool = False


@dataclass(frozen=True)
class Facts:
    """What a result says of the bodies that members are made of; lengths in µm, along (y and) x."""

    upper: Body
    lower: Body
    area: float
    shape: Sequence[int]
    spacing: Sequence[float]
    used: Sequence[float]
    scans: Sequence[Any]  # of the upper and of the lower body, with their spacings and extents


@dataclass(frozen=True)
class BodyAttributes:
    """What measured bodies say of a result besides its study: nothing, of generated ones."""

    nominal_area: float | None = None  # µm²
    attributes: dict[str, Any] = field(default_factory=dict)


class Members(Protocol):
    """The members that two bodies make, each by its number alone."""

    def member(self, index: int) -> Member:
        """One of them; a `ValueError` if there are fewer."""

    def facts(self) -> Facts:
        """What all members share."""


class MeasuredBodies(Case):
    """What studies of measured surfaces have in common."""

    bodies: ClassVar[str] = "measured areas"  # as the places of keys have them
    is_areal: ClassVar[bool] = True
    """Whether members are pairs of areas, which are independent of each other, and not of lines."""
    pressed: ClassVar[str]
    """What members are, in words."""

    kind: Literal["measured"] = Field(default="measured", description="Two measured files.")
    upper: MeasuredFile = Field(
        description="The slider: a table of `file` and how it is read, or a list of them, of several places on it."
    )
    lower: MeasuredFile = Field(description="What it is carried over; the same file may be both.")
    cut_off: CutOffs = Field(
        default=(quantity("0 um", "length"),),
        description="Waves shorter than this are taken off both bodies (Gaussian); 0 keeps all. "
        "A list is a dimension of the result, whose first value is quoted.",
    )
    vouched: Literal[True] | None = Field(
        default=None, description="Said of bodies whose waves are all the surface's, whatever the spectrum looks like."
    )

    both_readings: Literal[True] | None = Field(
        default=None,
        description="Set where `pair` added a second cutoff because of doubtful waves: the interval at the first one "
        "then covers that at the second.",
    )

    def cells(self) -> dict[str, Floats]:
        """The dimensions of a result that come before its members, and their values."""
        return {"cut_off": array_of(self.cut_off)}

    def quoted_cut_off(self) -> float:
        """Return the cutoff (µm) of the reading to quote, which is the first one."""
        return float(self.cells()["cut_off"][0])

    def with_files(self, change: Callable[[MeasuredFile, str], MeasuredFile]) -> Self:
        """The same with what a function makes of the file of each side."""
        return self.model_copy(update={side: change(getattr(self, side), side) for side in SIDES})

    @property
    def first_scanned(self) -> int:
        """Number of the first member that is a pair of the scans themselves."""
        return 0

    @property
    def scan_counts(self) -> tuple[int, int]:
        """How many scans of the upper and of the lower part there are."""
        return len(self.upper.scans), len(self.lower.scans)

    def scans_of(self, members: Any) -> tuple[Any, Any]:
        """Which scans of the upper and of the lower part members (numbers or arrays) are of: all pairs in turn."""
        upper, lower = self.scan_counts
        cell = members % (upper * lower)
        return cell % upper, (cell + cell // math.lcm(upper, lower)) % lower

    def members(self, scans: tuple[Body, Body], cut_offs: CutOffPair, seed: int) -> Members:
        """Make the members of two scans at cutoffs of each (µm, 0 for none); a `ValueError` if none can be made."""
        raise NotImplementedError

    def filtered(self, scans: tuple[Body, Body], cut_offs: CutOffPair) -> Iterator[Profile | Surface]:
        """Yield both scans, each filtered at its cutoff (µm, 0 for none)."""
        for scan, wavelength in zip(scans, cut_offs, strict=True):
            if isinstance(scan, JoinedSpectrum):
                press = type(self).model_fields["press"].default
                raise ValueError(f'surfaces.press: of a spectrum there are "surrogates" alone, got "{press}"')
            if wavelength > 0:
                checked_cutoff("cutoff", wavelength, scan, longest=MAX_CUTOFF_FRACTION)
            yield cut_off(scan, wavelength) if wavelength > 0 else scan


# ---- Lines -----------------------------------------------------------------------------------------------------------

SHIFTS = 16  # relative positions of two maps by default
SURROGATES = 16  # pairs of surrogates of profiles, which have no areas of their own, by default
MAX_OFFSETS = 100_000  # largest number of positions on a pair of lines


class MeasuredLines(MeasuredBodies):
    """Lines of two measured files, the upper carried along the lower."""

    place: ClassVar[str] = "lines of measured files"
    pressed: ClassVar[str] = "Lines"
    bodies: ClassVar[str] = "measured lines"
    is_areal: ClassVar[bool] = False

    press: Literal["lines"] = Field(default="lines", description="Lines of both, the upper carried along the lower.")
    level: Literal["line", "quadratic", "mean", "none"] = Field(
        default="line", description="What is taken off each line."
    )
    along: Along = Field(default="x", description="Whether lines of maps are rows or columns.")
    offsets: int = Field(
        default=1, ge=1, le=MAX_OFFSETS,
        description="Positions on each pair of lines; of two profiles without surrogates every member is a position.",
    )  # fmt: skip
    travel: LengthOrZero | None = Field(
        default=None,
        description="The largest offset; by default half of the length of one pair, and none of several pairs.",
    )
    replace: Surrogates = Field(
        default="none", description="Which of the two is replaced by its surrogate, a new one for each line."
    )

    positions: (
        Annotated[
            tuple[LengthOrZero, ...], as_tuple, Field(min_length=1, max_length=MAX_OFFSETS),
            AfterValidator(require_different),
        ]
        | None
    ) = Field(
        default=None,
        description="Positions of the slider on the lower line, in place of `offsets` and `travel`; the slider is "
        "shortened if it would reach beyond the end.",
    )  # fmt: skip

    @model_validator(mode="after")
    def _has_one_source_of_positions(self) -> Self:
        if self.positions is not None and (self.offsets > 1 or self.travel is not None):
            raise fault_at("positions", "must not be given with offsets or travel")
        return self

    def members(self, scans: tuple[Body, Body], cut_offs: CutOffPair, seed: int) -> Lines:
        """Lines of both scans, or of their surrogates, at positions on each other."""
        upper, lower = self.filtered(scans, cut_offs)
        level: ProfileTrend | None = None if self.level == "none" else self.level
        positions = None if self.positions is None else tuple(map(float, self.positions))
        travel = max(positions) if positions else None if self.travel is None else float(self.travel)
        several = self.replace != "none" or isinstance(upper, Surface) or isinstance(lower, Surface)
        pairs = LinePairs(upper, lower, travel, level, self.along, self.replace, seed, several=several)
        return Lines(pairs, scans, self.offsets, positions)


@dataclass(frozen=True, eq=False)
class Lines:
    """Members that are pairs of lines."""

    pairs: LinePairs
    scans: tuple[Body, Body]
    offsets: int = 1  # positions on each pair, where there are several pairs; of one pair every member is a position
    positions: tuple[float, ...] | None = None  # positions (µm) on each pair, instead of a quasi-random sequence

    def member(self, index: int) -> Member:
        """Return a slider and the part of its counterface below it."""
        pairs, offsets = self.pairs, self.offsets if self.positions is None else len(self.positions)
        line, place = divmod(index, offsets) if pairs.several else (0, index)
        most = pairs.max_count()
        if most is not None and line >= most:
            raise ValueError(f"the surfaces have {most} pairs of lines, and member {index} is on pair {line + 1}")
        slider, track = pairs.pair(line)
        room = len(track) - len(slider)
        if self.positions is not None:
            if place >= offsets:
                raise ValueError(f"surfaces.positions has {offsets} positions, and member {index} is beyond them")
            return self._member_at(slider, track, round(self.positions[place] / slider.spacing), line)
        if room == 0 and place > 0:
            raise ValueError("several positions need a travel, for which the slider is shortened")
        # A line on itself is no pair at 0; several lines are not on themselves.
        alone = pairs.several and offsets == 1 and pairs.travel is None
        if alone or room == 0:
            steps = 0
        elif offsets == 1 and pairs.travel is not None and place == 0:
            steps = room  # one position: the travel that was asked for
        else:
            steps = 1 + min(int(quasi_random_point(place + 1, 1)[0] * room), room - 1)
        return self._member_at(slider, track, steps, line)

    def _member_at(self, slider: Profile, track: Profile, steps: int, line: int) -> Member:
        """Return the member whose slider is a number of points from the start of its counterface."""
        offset = steps * slider.spacing
        pair = slider, piece_below_slider(track, offset, slider)
        return Member(pair, offset, self.pairs.place(line), line=line, surrogate=self.pairs.surrogates != "none")

    def facts(self) -> Facts:
        """What all members share."""
        slider, track = self.pairs.pair(0)
        return _facts_of_lines(slider, track, len(slider) / len(track), self.scans)


def _facts_of_lines(slider: Profile, track: Profile, used: float, scans: tuple[Any, Any]) -> Facts:
    """What all members of lines share, and which fraction of the upper scan a slider is."""
    return Facts(
        slider, track, slider.extent * THICKNESS, [len(slider)], [slider.spacing], [used, len(slider) / len(track)],
        scans,
    )  # fmt: skip


class MeasuredAreas(MeasuredBodies):
    """Areas of two measured maps, pressed at several relative positions."""

    place: ClassVar[str] = "areas of measured maps"
    pressed: ClassVar[str] = "Areas"

    press: Literal["areas"] = Field(default="areas", description="Areas at several relative positions.")
    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="What is taken off each map and each piece that is pressed."
    )
    rotate: float = Field(default=0.0, ge=-360, le=360, description="Degrees by which the upper map is turned.")
    surrogates: int = Field(
        default=0, ge=0, le=1_000_000,
        description="How many members, the first ones, are pairs of surrogates: other surfaces of the same spectra.",
    )  # fmt: skip

    gap: Literal[True] | None = Field(
        default=None, description="Said of one file that is both: the gap of two faces, pressed as it is."
    )
    positions: (
        Annotated[
            tuple[Annotated[tuple[SignedLength, SignedLength], as_tuple], ...], as_tuple,
            Field(min_length=1, max_length=MAX_OFFSETS), AfterValidator(require_different),
        ]
        | None
    ) = Field(
        default=None,
        description="Shifts (x, y) of the first point of the upper map from that of the lower one; all members have "
        "the size of the smallest overlap.",
    )  # fmt: skip

    @property
    def first_scanned(self) -> int:
        """Number of the first member that is a pair of pieces of the maps."""
        return self.surrogates

    def members(self, scans: tuple[Body, Body], cut_offs: CutOffPair, seed: int) -> Areas | GapMember:
        """Return pieces of two maps at relative positions, the first ones of their surrogates, or the gap."""
        upper, lower = self.filtered(scans, cut_offs)
        if not (isinstance(upper, Surface) and isinstance(lower, Surface)):
            raise ValueError('surfaces.press: "areas" are of two maps, and one of the files is a profile')
        if self.gap:
            gap = levelled(lower, self.level)
            grid: dict[str, Any] = {"spacing": gap.spacing, "missing": gap.missing}
            flat = Surface(np.zeros_like(gap.heights), history=("a flat face",), **grid)
            rough = Surface(0.0 - gap.heights, history=(*gap.history, "a gap, below a flat face"), **grid)
            return GapMember(flat, rough)
        shifts = None if self.positions is None else tuple((float(x), float(y)) for x, y in self.positions)
        pairs = pairs_of_maps(upper, lower, self.level, seed, turned=self.rotate, shifts=shifts)
        return Areas(pairs, scans, self.surrogates)


class MeasuredSurrogates(MeasuredBodies):
    """Other areas of the spectra of two maps, or alike in all directions of two profiles or of several scans."""

    place: ClassVar[str] = "surrogates of measured files"
    pressed: ClassVar[str] = "Surfaces with the spectra of both"

    press: Literal["surrogates"] = Field(default="surrogates", description="Other areas of the same spectra.")
    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="What is taken off each file; a plane of a profile is a line."
    )

    def members(self, scans: tuple[Body, Body], cut_offs: CutOffPair, seed: int) -> Areas:
        """Pairs of random surfaces with given spectra."""
        one, other = scans
        if isinstance(one, JoinedSpectrum) or isinstance(other, JoinedSpectrum):
            finest = float(self.cells()["cut_off"].min())
            return Areas(
                SpectrumPairs(to_joined_spectrum(one), to_joined_spectrum(other), self.level, seed, cut_offs, finest),
                scans,
            )
        upper, lower = self.filtered(scans, cut_offs)
        if isinstance(upper, Surface) and isinstance(lower, Surface):
            return Areas(pairs_of_maps(upper, lower, self.level, seed), scans)
        if not (isinstance(upper, Profile) and isinstance(lower, Profile)):
            raise ValueError('surfaces.press: "surrogates" are of two maps or of two profiles, not of one of each')
        trend: ProfileTrend = "line" if self.level == "plane" else self.level
        return Areas(IsotropicPairs(flipped(levelled(upper, trend)), levelled(lower, trend), "plane", seed), scans)


def pairs_of_maps(
    upper: Surface, lower: Surface, level: SurfaceTrend, seed: int, *, turned: float = 0.0,
    shifts: tuple[tuple[float, float], ...] | None = None,
) -> MapPairs:  # fmt: skip
    """Return pairs of pieces of two maps, both levelled, the upper one rotated by an angle (degrees) and flipped."""
    above = levelled(upper, level)
    return MapPairs(flipped(rotated(above, turned) if turned else above), levelled(lower, level), level, seed, shifts)


@dataclass(frozen=True, eq=False)
class Areas:
    """Members that are pairs of areas."""

    pairs: MapPairs | IsotropicPairs | SpectrumPairs
    scans: tuple[Body, Body]
    surrogates: int | None = None  # how many members, the first ones, are pairs of surrogates; by default all

    def member(self, index: int) -> Member:
        """A pair of surrogates, or of pieces of maps at a relative position."""
        pairs, made = self.pairs, self.surrogates
        if made is None or index < made:
            return Member(pairs.surrogates(index), np.nan, np.nan, surrogate=True)
        assert isinstance(pairs, MapPairs)
        shift = index - made
        if shift >= pairs.max_count():
            raise ValueError(f"the maps have {pairs.max_count()} relative positions, and member {index} is beyond them")
        return Member(pairs.pair(shift), *pairs.moved(shift))

    def facts(self) -> Facts:
        """What all members share."""
        pairs = self.pairs
        scans: Sequence[Any] = self.scans
        if isinstance(pairs, SpectrumPairs):  # as if two points were the shortest wave
            waves = (max(body.shortest, pairs.finest) for body in (pairs.upper, pairs.lower))
            scans = [SimpleNamespace(spacing=shortest / 2, extent=pairs.side) for shortest in waves]
        return Facts(pairs.upper, pairs.lower, pairs.area, pairs.shape, pairs.spacing, pairs.used, scans)


@dataclass(frozen=True, eq=False)
class GapMember:
    """The only member of a gap: a flat face, and a rough face at the measured distance from it."""

    flat: Surface
    rough: Surface

    def member(self, index: int) -> Member:
        """Return the pair of faces."""
        if index > 0:
            raise ValueError(f"a gap has one member, got member {index}")
        return Member((self.flat, self.rough), 0.0, 0.0)

    def facts(self) -> Facts:
        """Return the facts that all members share."""
        both = self.flat, self.rough
        return Facts(
            *both, float(np.prod(self.rough.extent)), self.rough.heights.shape, self.rough.spacing, [1.0, 1.0], both
        )  # fmt: skip


Measured = MeasuredAreas | MeasuredLines | MeasuredSurrogates
"""What a study of two measured files presses; a new kind of members is one more of these."""
