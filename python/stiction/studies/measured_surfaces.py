"""The table `[surfaces]` of a study of two measured files: how they are read and prepared, and how members are made."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, PlainValidator

from stiction._checks import Floats
from stiction._text import named
from stiction._units import Quantity, quantity, shortened
from stiction.studies.values import CutOffs, LengthOrZero, Table, array_of, as_written, read_length, written
from stiction.surfaces.joined import JoinedSpectrum
from stiction.surfaces.measured.raw import LENGTH_UNITS
from stiction.surfaces.measured.reading import read_measurement
from stiction.surfaces.measured.spectrum_file import is_spectrum, read_spectrum
from stiction.surfaces.pairing import Surrogates
from stiction.surfaces.profile import Along, Profile
from stiction.surfaces.surface import Surface

Column = int | str

Body = Profile | Surface | JoinedSpectrum
"""What a file may hold."""

LONGEST_PATH = 4096
"""Characters."""

MOST_OFFSETS = 100_000
"""Largest number of positions on a pair of lines."""


def _unit(value: object) -> str:
    if not isinstance(value, str) or value not in LENGTH_UNITS:
        raise ValueError(f"must be a unit of length ({', '.join(LENGTH_UNITS)}) or two, got {shortened(value)}")
    return value


def _column(value: object) -> Column:
    if isinstance(value, bool) or not isinstance(value, (str, int)) or (isinstance(value, int) and value < 0):
        raise ValueError(f"must be a name or a number from 0 on, got {shortened(value)}")
    return value


def _one_or_two(read: Callable[[object], Any]) -> PlainValidator:
    """A value, a list of two, or none."""

    def values(value: object) -> Any:
        if not isinstance(value, (list, tuple)):
            return None if value is None else read(value)
        if len(value) != 2:
            raise ValueError(f"must be one value or a list of two, got {shortened(value)}")
        return read(value[0]), read(value[1])

    return PlainValidator(values)


class MeasuredFile(Table):
    """A file that holds a measured profile or surface, and how it is read, or a spectrum of several."""

    file: str = Field(min_length=1, max_length=LONGEST_PATH, description="Name of the file.")
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
    columns: Annotated[Column | tuple[Column, Column] | None, _one_or_two(_column)] = Field(
        default=None, description="Columns of positions and of heights, or of heights, of a table."
    )
    missing: Literal["error", "interpolate"] = Field(
        default="error", description="What to do about points without a height."
    )

    def read(self) -> Body:
        """The profile, surface or joined spectrum that the file holds, µm.

        Raises
        ------
        ValueError
            If the file cannot be read, or is not the one whose checksum the study has.
        """
        if self.sha256 is not None and self.checksum() != self.sha256:
            raise ValueError(
                f"{named(self.file)}: is another file than that which the study was made for: its SHA-256 is not "
                f"{self.sha256[:12]}...; remove sha256 from the study to begin another one with it"
            )
        return _body(self.model_copy(update={"sha256": self.checksum()}))

    def checksum(self) -> str:
        """SHA-256 of the bytes of the file.

        Raises
        ------
        ValueError
            If it cannot be read.
        """
        try:
            with Path(self.file).open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest()
        except OSError as error:
            raise ValueError(f"{named(self.file)}: cannot be read: {error.strerror}") from None

    def located(self, directory: Path) -> MeasuredFile:
        """The same with an absolute name; one that is not absolute is relative to the directory."""
        return self.model_copy(update={"file": str((directory / self.file).absolute())})

    def known(self) -> MeasuredFile:
        """The same with the checksum of the file as it is."""
        return self if self.sha256 is not None else self.model_copy(update={"sha256": self.checksum()})


@functools.lru_cache(maxsize=2)
def _body(file: MeasuredFile) -> Body:
    """The body in a file, known by its checksum, so that the two of a study are taken apart once."""
    if is_spectrum(Path(file.file)):
        for name in ("unit", "spacing", "channel", "columns"):
            if getattr(file, name) is not None:
                raise ValueError(f"{named(file.file)}: is a spectrum, which has no {name} to be given")
        return read_spectrum(file.file)
    return read_measurement(
        file.file,
        unit=file.unit,
        spacing=written(file.spacing),
        missing=file.missing,
        channel=file.channel,
        columns=file.columns,
    )


class MeasuredBodies(Table):
    """What studies of measured surfaces have in common."""

    kind: Literal["measured"] = Field(default="measured", description="Two measured files.")
    upper: MeasuredFile = Field(description="The slider: a table of `file` and how it is read.")
    lower: MeasuredFile = Field(description="What it is carried over; the same file may be both.")
    cut_off: CutOffs = Field(
        default=(quantity("0 um", "length"),),
        description="Waves shorter than this are taken off both bodies (Gaussian); 0 keeps all. "
        "A list is a dimension of the result.",
    )

    def cells(self) -> dict[str, Floats]:
        """The dimensions of a result that come before its members, and their values."""
        return {"cut_off": array_of(self.cut_off)}

    def located(self, directory: Path) -> Self:
        """The same with absolute names of files; those that are not absolute are relative to the directory."""
        update = {"upper": self.upper.located(directory), "lower": self.lower.located(directory)}
        return self.model_copy(update=update)

    def known(self) -> Self:
        """The same with the checksums of the files as they are."""
        return self.model_copy(update={"upper": self.upper.known(), "lower": self.lower.known()})


class MeasuredAreas(MeasuredBodies):
    """Areas of two measured maps, pressed at several relative positions."""

    case: ClassVar[str] = "areas of measured maps"

    press: Literal["areas"] = Field(default="areas", description="Areas at several relative positions.")
    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="What is taken off each map and each piece that is pressed."
    )
    rotate: float = Field(default=0.0, ge=-360, le=360, description="Degrees by which the upper map is turned.")
    surrogates: int = Field(
        default=0,
        ge=0,
        le=1_000_000,
        description="How many members, the first ones, are pairs of surrogates: other surfaces of the same spectra.",
    )

    @property
    def is_areal(self) -> bool:
        """Whether members are pairs of areas."""
        return True


class MeasuredLines(MeasuredBodies):
    """Lines of two measured files, the upper carried along the lower."""

    case: ClassVar[str] = "lines of measured files"

    press: Literal["lines"] = Field(default="lines", description="Lines of both, the upper carried along the lower.")
    level: Literal["line", "quadratic", "mean", "none"] = Field(
        default="line", description="What is taken off each line."
    )
    along: Along = Field(default="x", description="Whether lines of maps are rows or columns.")
    offsets: int = Field(
        default=1,
        ge=1,
        le=MOST_OFFSETS,
        description="Positions on each pair of lines; of two profiles without surrogates every member is a position.",
    )
    travel: LengthOrZero | None = Field(
        default=None,
        description="The largest offset; by default half of the length of one pair, and none of several pairs.",
    )
    replace: Surrogates = Field(
        default="none", description="Which of the two is replaced by its surrogate, a new one for each line."
    )

    @property
    def is_areal(self) -> bool:
        """Whether members are pairs of areas."""
        return False


class MeasuredSurrogates(MeasuredBodies):
    """Other areas of the spectra of two maps, of two profiles, or where one file is a spectrum that several scans have.

    But for two maps, they are alike in all directions.
    """

    case: ClassVar[str] = "surrogates of measured files"

    press: Literal["surrogates"] = Field(default="surrogates", description="Other areas of the same spectra.")
    level: Literal["plane", "quadratic", "mean"] = Field(
        default="plane", description="What is taken off each file; a plane of a profile is a line."
    )

    @property
    def is_areal(self) -> bool:
        """Whether members are pairs of areas."""
        return True


Measured = MeasuredAreas | MeasuredLines | MeasuredSurrogates
"""The table `[surfaces]` of a study of two measured files."""
