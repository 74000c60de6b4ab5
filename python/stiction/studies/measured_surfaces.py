"""Classes for the table `[surfaces]` of a study of measured bodies, including files, reading options and members."""

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
from stiction._files import UnreadableFileError, check_is_file, describe_os_error
from stiction._text import printable_path
from stiction._units import Quantity, quantity, short_repr
from stiction.mechanics.model import PROFILE_WIDTH
from stiction.mechanics.quantities import MAX_STORED_VALUE
from stiction.studies.member_names import GENERAL_MEMBER_NAMES, POSITION_NAMES, SURROGATE_PAIR_NAMES, MemberNames
from stiction.studies.stored_values import POSITIVE_STORED_VALUE, AttributeSpec
from stiction.studies.values import (
    CutOffs,
    Length,
    LengthOrZero,
    SettingsTable,
    SettingsTableVariant,
    SignedLength,
    as_tuple,
    as_written,
    format_quantities,
    make_key_error,
    read_length,
    require_distinct,
    to_value_array,
)
from stiction.surfaces.cut_off import MAX_CUTOFF_FRACTION, cut_off
from stiction.surfaces.filters import validate_cutoff
from stiction.surfaces.interchange import extract_heights
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.measured.interpret import MissingPointTreatment, OutlierTreatment
from stiction.surfaces.measured.plausibility import FILE_CAVEAT_NAMES, ScannedHeights, find_caveats
from stiction.surfaces.measured.raw import LENGTH_UNITS, FileCaveat
from stiction.surfaces.measured.reading import FileReading, read_with_interpretation
from stiction.surfaces.measured.spectrum_file import is_spectrum_file, read_spectrum, write_spectrum
from stiction.surfaces.measured.writing import heights_with_nan, write_profile, write_surface
from stiction.surfaces.missing_data import find_largest_gap
from stiction.surfaces.pairing import (
    SIDES,
    IsotropicSurfacePairs,
    LinePairs,
    MapPairs,
    SpectralSurfacePairs,
    SurrogateBodies,
    piece_below_slider,
    quasi_random_point,
    to_joined_spectrum,
)
from stiction.surfaces.preparation import ProfileTrend, SurfaceTrend, flipped, levelled, rotated
from stiction.surfaces.profile import LineOrientation, Profile
from stiction.surfaces.surface import Surface, parse_lengths
from stiction.surfaces.tip import sharpened

ColumnNameOrIndex = int | str
MeasuredBody = Profile | Surface | JoinedSpectrum  # kinds of bodies in a file
MAX_FILE_NAME_LENGTH = 4096  # maximum length of a file name in characters
MachiningProcess = Literal["turned", "milled", "ground", "honed", "lapped", "sanded", "blasted", "eroded"]
MACHINING_PROCESSES: tuple[str, ...] = get_args(MachiningProcess)
BodyPair = tuple[Profile, Profile] | tuple[Surface, Surface]
CutoffPair = tuple[float, float]  # cutoffs of the upper and the lower scan, µm
ScanCutoffs = tuple[tuple[float, ...], tuple[float, ...]]  # cutoffs of all upper and of all lower scans, µm


def _parse_unit(value: object) -> str:
    if not isinstance(value, str) or value not in LENGTH_UNITS:
        raise ValueError(f"must be one or two units of length ({', '.join(LENGTH_UNITS)}), got {short_repr(value)}")
    return value


def _parse_column(value: object) -> ColumnNameOrIndex:
    if isinstance(value, bool) or not isinstance(value, (str, int)) or (isinstance(value, int) and value < 0):
        raise ValueError(f"must be a name or a whole number of at least 0, got {short_repr(value)}")
    return value


def _parse_missing_values(value: object) -> tuple[float | str, ...] | None:
    """Parse the numbers and words that mark missing points in a file."""
    if value is None:
        return None
    entries: Any = value.split(",") if isinstance(value, str) else value
    entries = entries if isinstance(entries, (list, tuple)) else [entries]
    if not entries or not all(
        isinstance(entry, (str, int, float)) and not isinstance(entry, bool) for entry in entries
    ):
        raise ValueError(f"must be a number, a word, or a list of numbers and words, got {short_repr(value)}")
    return tuple(entry.strip() if isinstance(entry, str) else entry for entry in entries)


def _parse_caveats(value: object) -> tuple[str, ...] | None:
    """Parse a list of caveat names."""
    if value is None:
        return None
    names = [entry.strip() for entry in value.split(",")] if isinstance(value, str) else value
    if not isinstance(names, (list, tuple)) or not set(names) <= set(FILE_CAVEAT_NAMES):
        raise ValueError(f"must be one of {', '.join(FILE_CAVEAT_NAMES)}, or a list of these, got {short_repr(value)}")
    return tuple(names)


def _parse_crop(value: object) -> tuple[Quantity, ...] | None:
    if value is None:
        return None
    texts = value.split(",") if isinstance(value, str) else value
    if not isinstance(texts, (list, tuple)) or len(texts) not in (2, 4):
        raise ValueError(f'must be "x0,x1" or "x0,x1,y0,y1", got {short_repr(value)}')
    return tuple(quantity(text.strip() if isinstance(text, str) else text, "length") for text in texts)


def _build_one_or_list_validator(read: Callable[[object], Any], max_count: int = 2) -> PlainValidator:
    """Return a validator that accepts None, a single value, or a list of 2 to `max_count` values."""

    def parse_one_or_list(value: object) -> Any:
        if not isinstance(value, (list, tuple)):
            return None if value is None else read(value)
        if not 2 <= len(value) <= max_count:
            allowed = "two" if max_count == 2 else f"two to {max_count}"
            raise ValueError(f"must be one value or a list of {allowed}, got {short_repr(value)}")
        return tuple(map(read, value))

    return PlainValidator(parse_one_or_list)


MIN_HEIGHT_FACTOR, MAX_HEIGHT_FACTOR = 0.01, 100.0  # limits of `height_factor`
MAX_TIP_CORRECTION = 10.0  # largest value of `tip_correction`


class BodyInMemory:
    """Wrapper for a measured body that is in memory rather than in a file.

    The class is not a dataclass, so that copies of a study share the body.
    """

    def __init__(self, body: Any) -> None:
        self.body = body


class MeasuredBodySettings(SettingsTable):
    """Entry for a measured profile, surface or joined spectrum. The data are in a file or in memory."""

    model_config = ConfigDict(arbitrary_types_allowed=True)

    def __eq__(self, value: object) -> bool:
        """Compare all fields. A body in memory is compared by its checksum and its history."""
        return isinstance(value, MeasuredBodySettings) and self._comparison_key() == value._comparison_key()

    def __hash__(self) -> int:
        return hash(self._comparison_key())

    def _comparison_key(self) -> tuple[Any, ...]:
        history = () if self.body is None else self.body.body.history
        return *(value for name, value in self if name != "body"), history

    file: str = Field(min_length=1, max_length=MAX_FILE_NAME_LENGTH, description="Name of the file.")
    sha256: str | None = Field(
        default=None,
        pattern="^[0-9a-f]{64}$",
        description="SHA-256 checksum; a file of this name with another checksum is rejected.",
    )
    unit: Annotated[str | tuple[str, str] | None, _build_one_or_list_validator(_parse_unit)] = Field(
        default=None, description="Unit of all lengths in the file, or units of positions and heights."
    )
    spacing: Annotated[
        Quantity | tuple[Quantity, Quantity] | None, _build_one_or_list_validator(read_length), as_written
    ] = Field(default=None, description="Distance between neighbouring points, or between rows and between columns.")
    channel: Annotated[
        ColumnNameOrIndex | None, PlainValidator(lambda value: None if value is None else _parse_column(value))
    ] = Field(default=None, description="Channel or sheet to read, if the file has several.")
    columns: Annotated[
        ColumnNameOrIndex | tuple[ColumnNameOrIndex, ...] | None,
        _build_one_or_list_validator(_parse_column, max_count=3),
    ] = Field(
        default=None, description="Columns to read from a table: positions and heights; x, y and z; or heights only."
    )
    missing: MissingPointTreatment = Field(default="error", description="Treatment of points without a height.")
    outliers: OutlierTreatment = Field(
        default="keep", description="Treatment of isolated outliers: keep them, or mark them as missing."
    )
    crop: Annotated[tuple[Quantity, ...] | None, PlainValidator(_parse_crop), as_written] = Field(
        default=None, description="Region to read: first and last x, and for maps first and last y."
    )
    missing_value: Annotated[tuple[float | str, ...] | None, PlainValidator(_parse_missing_values)] = Field(
        default=None, description="Numbers (as written in the file) or words that mark points without a height."
    )
    accept: Annotated[tuple[str, ...] | None, PlainValidator(_parse_caveats)] = Field(
        default=None, description="Names of caveats about the file that are accepted."
    )
    tip: Length | None = Field(
        default=None, description="Radius of the stylus or probe, which limits the wavelengths that it resolves."
    )
    tip_correction: float | None = Field(
        default=None,
        gt=0,
        le=MAX_TIP_CORRECTION,
        description="Multiple of the tip correction (scan minus tip reconstruction) to subtract from the heights. "
        "`pair` uses it in its secondary study of a blunt tip.",
    )
    texture: MachiningProcess | None = Field(
        default=None,
        description="Machining process: lines and humps in the spectrum are then attributed to the surface.",
    )
    max_cut_off: LengthOrZero | None = Field(
        default=None, description="Largest cutoff of the filter for this scan; 0 for no filter, unlimited by default."
    )
    height_factor: float = Field(
        default=1.0,
        ge=MIN_HEIGHT_FACTOR,
        le=MAX_HEIGHT_FACTOR,
        description="Factor by which the heights are multiplied, for example to study another finish.",
    )
    body: BodyInMemory | None = Field(default=None, repr=False, description="Body in memory (Python only).")
    others: Annotated[tuple[MeasuredBodySettings, ...], as_tuple] | None = Field(
        default=None,
        description="Further scans at other places on the same part; in a list of files, all files after the first.",
    )

    @model_validator(mode="before")
    @classmethod
    def _parse_scan_list(cls, value: Any) -> Any:
        if not isinstance(value, (list, tuple)) or not value:
            return value
        first_table, *other_tables = ({"file": item} if isinstance(item, str) else item for item in value)
        return {**first_table, "others": tuple(other_tables)} if isinstance(first_table, Mapping) else first_table

    @property
    def scans(self) -> tuple[MeasuredBodySettings, ...]:
        """All scans of the body, i.e. the scan in this file followed by scans of other places."""
        return self, *(self.others or ())

    @property
    def name(self) -> str:
        """File name without its folder. If there are further scans, their number is appended."""
        return Path(self.file).name + (f" and {len(self.others)} more" if self.others else "")

    def _apply_to_scans(self, change: Callable[[MeasuredBodySettings], MeasuredBodySettings]) -> MeasuredBodySettings:
        return change(self).model_copy(update={"others": self.others and tuple(map(change, self.others))})

    @classmethod
    def from_body(cls, body: Any, name: str) -> MeasuredBodySettings:
        """Create an entry for a body in memory. Objects from other libraries are also accepted.

        Raises an `ArgumentError` if the body is invalid.
        """
        if not isinstance(body, JoinedSpectrum):
            try:
                heights, spacing, history, missing = extract_heights(name, body)
            except ValueError as error:
                raise ArgumentError(f"{{{name}}}{{why}}", why=str(error).removeprefix(name)) from None
            body_class: Any = Profile if heights.ndim == 1 else Surface
            body = body_class(
                heights, spacing=spacing[0] if body_class is Profile else parse_lengths("spacing", spacing),
                history=history, missing=missing,
            )  # fmt: skip
        return cls(file=name, sha256=_compute_checksum(body), body=BodyInMemory(body))

    def with_saved_bodies(self, folder: Path, side: str) -> MeasuredBodySettings:
        """Write bodies that are in memory to files in a folder. The returned entry refers to these files."""
        return self._apply_to_scans(lambda scan: scan._with_saved_body(folder, side))

    def _with_saved_body(self, folder: Path, side: str) -> MeasuredBodySettings:
        if self.body is None:
            return self
        assert self.sha256 is not None
        body = self.body.body
        file_extension = "csv" if isinstance(body, JoinedSpectrum) else "npy"
        path = (folder / "bodies" / self.sha256[:12] / f"{side}.{file_extension}").absolute()
        if not path.exists():
            path.parent.mkdir(parents=True, exist_ok=True)
            write_body: Any = (
                write_spectrum
                if file_extension == "csv"
                else write_profile
                if body.heights.ndim == 1
                else write_surface
            )
            write_body(body, path)
        has_missing = not isinstance(body, JoinedSpectrum) and body.missing is not None
        options = {
            name: getattr(self, name) for name in ("tip", "tip_correction", "texture", "max_cut_off", "height_factor")
        }
        return MeasuredBodySettings(
            file=str(path), missing="mask" if has_missing else "error", **options
        ).with_checksums()

    def read(self) -> MeasuredBody:
        """Read the profile, surface or spectrum (µm).

        Raises a `ValueError` if the checksum of the file differs.
        """
        return _scale_heights(self.height_factor, self._read_unscaled())  # type: ignore[no-any-return]

    def _read_unscaled(self) -> MeasuredBody:
        """Read the body without multiplying its heights by the height factor."""
        if self.body is not None:
            return _correct_for_tip(self, self.body.body)
        checksum = self.checksum()
        if self.sha256 is not None and checksum != self.sha256:
            raise ValueError(
                f"{printable_path(self.file)} has changed since the study was created: its SHA-256 is not "
                f"{self.sha256[:12]}...; remove sha256 from the study to start a new study with this file"
            )
        return _read_body(self._identify_content(checksum))

    def _identify_content(self, checksum: str) -> _ScanFile:
        """Return the key under which the content of the file is cached."""
        unrelated_keys = {"others": None, "height_factor": 1.0, "max_cut_off": None, "texture": None}
        return _ScanFile(
            self.model_copy(update={"file": Path(self.file).name, "sha256": checksum} | unrelated_keys), Path(self.file)
        )

    def with_height_factor(self, factor: float) -> MeasuredBodySettings:
        """Return a copy of the entry in which the heights of all scans are multiplied by a factor.

        Raises a `ValueError` if the product with the existing factor of a scan is out of range.
        """
        for scan in self.scans:
            total_factor = factor * scan.height_factor
            if not MIN_HEIGHT_FACTOR <= total_factor <= MAX_HEIGHT_FACTOR:
                allowed_range = f"from {MIN_HEIGHT_FACTOR:g} to {MAX_HEIGHT_FACTOR:g}"
                raise ValueError(f"height_factor must be {allowed_range}, got {total_factor:g} for {scan.name}")
        return self._apply_to_scans(lambda scan: scan.model_copy(update={"height_factor": factor * scan.height_factor}))

    def without_folders(self) -> MeasuredBodySettings:
        """Return a copy of the entry in which all scans have only the names of their files."""
        return self._apply_to_scans(lambda scan: scan.model_copy(update={"file": Path(scan.file).name}))

    def with_masked_outliers(self, *, interpolate: bool) -> MeasuredBodySettings:
        """Return a copy of the entry in which the outliers of all scans become missing points.

        If `interpolate` is true, the heights of these points are interpolated unless missing points are masked already.
        """

        def mask_outliers(scan: MeasuredBodySettings) -> MeasuredBodySettings:
            missing = "interpolate" if interpolate and scan.missing == "error" else scan.missing
            return scan.model_copy(update={"outliers": "mask", "missing": missing})

        return self._apply_to_scans(mask_outliers)

    def with_tip_correction(self, factor: float) -> MeasuredBodySettings:
        """Return a copy of the entry in which all scans with a tip radius have the given tip correction."""
        return self._apply_to_scans(
            lambda scan: scan if scan.tip is None else scan.model_copy(update={"tip_correction": factor})
        )

    @property
    def bodies(self) -> list[Profile | Surface]:
        """Scans of the body that are profiles or surfaces. Spectra are omitted."""
        return [body for scan in self.scans if isinstance(body := scan.read(), (Profile, Surface))]

    def limit_cut_off(self, wavelength: float) -> float:
        """Return the cutoff wavelength (µm) of the pair, limited to the largest cutoff allowed for this scan."""
        return wavelength if self.max_cut_off is None else min(wavelength, float(self.max_cut_off))

    def find_interpolated_fraction_and_gap(self) -> Floats:
        """Return the fraction of points that were interpolated, and the size of the largest data gap.

        The size is an area (µm²) for height maps, and a length (µm) for profiles.
        """
        if self.missing != "interpolate" or self.body is not None or is_spectrum_file(Path(self.file)):
            return np.zeros(2)
        body = self.model_copy(update={"missing": "mask"}).read()
        if isinstance(body, JoinedSpectrum) or body.missing is None:
            return np.zeros(2)
        return np.array([body.missing.mean(), find_largest_gap(body.missing)[0] * np.prod(body.spacing)])

    @property
    def reading(self) -> FileReading[Any] | None:
        """Interpretation of the file, such as columns and units, or None for a spectrum or a body in memory."""
        if self.body is not None or is_spectrum_file(Path(self.file)):
            return None
        return _load_reading(self._identify_content(self.checksum()))

    @property
    def caveats(self) -> tuple[FileCaveat, ...]:
        """Caveats about how the file was read, or about the heights of a body in memory."""
        if (reading := self.reading) is not None:
            return tuple(reading.caveats)
        body = None if self.body is None else self.body.body
        if not isinstance(body, (Profile, Surface)):
            return ()
        return find_caveats(ScannedHeights(heights_with_nan(body), body.spacings, from_text=False))

    def checksum(self) -> str:
        """Compute the SHA-256 checksum of the file contents.

        Raises a `ValueError` if the file cannot be read.
        """
        path = Path(self.file)
        try:
            check_is_file(path)  # reading from a device or a pipe may never end
            with path.open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest()
        except UnreadableFileError as error:
            raise ValueError(f"{printable_path(path)}: {error}") from None
        except OSError as error:
            raise ValueError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None

    def file_stamp(self) -> tuple[int, int] | None:
        """Return the modification time (ns) and the size of the file, or None if the file does not exist."""
        try:
            file_status = None if self.body else Path(self.file).stat()
        except OSError:
            return None
        return file_status and (file_status.st_mtime_ns, file_status.st_size)

    def with_absolute_paths(self, directory: Path) -> MeasuredBodySettings:
        """Return a copy of the entry with absolute paths. Relative paths are resolved against `directory`."""
        return self._apply_to_scans(
            lambda scan: (
                scan if scan.body else scan.model_copy(update={"file": str((directory / scan.file).absolute())})
            )
        )

    def with_checksums(self) -> MeasuredBodySettings:
        """Return a copy of the entry with all checksums, computing those that are missing."""
        return self._apply_to_scans(
            lambda scan: scan if scan.sha256 is not None else scan.model_copy(update={"sha256": scan.checksum()})
        )


def _scale_heights(factor: float, body: Any) -> Any:
    """Return a body whose heights are multiplied by a factor."""
    if factor == 1:
        return body
    if isinstance(body, JoinedSpectrum):
        return dataclasses.replace(body, density=body.density * factor**2)
    return body.changed(body.heights * factor, f"heights times {factor:g}")


def _compute_checksum(body: MeasuredBody) -> str:
    """Compute the SHA-256 checksum of the numbers of a body in memory.

    The history is not included, because it only describes the body, and later versions may describe it in other words.
    """
    if isinstance(body, JoinedSpectrum):
        arrays = body.wave_number, body.density, body.count, body.contribution, body.ratio
        content = repr((body.bands, body.names)).encode() + b"".join(values.tobytes() for values in arrays)
    else:
        content = repr((body.heights.shape, body.spacing)).encode() + heights_with_nan(body).tobytes()
    return hashlib.sha256(content).hexdigest()


@dataclass(frozen=True)
class _ScanFile:
    """Scan file, identified by its name without the folder, its checksum and the options for reading it."""

    settings: MeasuredBodySettings
    path: Path = field(compare=False)


@functools.lru_cache(maxsize=16)
def _read_body(file: _ScanFile) -> MeasuredBody:
    """Read the body from a file.

    The cache key contains the checksum and the reading options, so a file is read once for each combination.
    """
    settings = file.settings
    if is_spectrum_file(file.path):
        for name in ("unit", "spacing", "channel", "columns", "crop"):
            if getattr(settings, name) is not None:
                raise ValueError(
                    f"{printable_path(file.path)} is a spectrum, which has no {name}; remove the key {name}"
                )
        return read_spectrum(file.path)
    return _correct_for_tip(settings, _load_reading(file).body)


def _correct_for_tip(file: MeasuredBodySettings, body: MeasuredBody) -> MeasuredBody:
    """Subtract the multiple of the tip correction that a file entry specifies, if any, from the heights of a scan."""
    if file.tip is None or file.tip_correction is None or isinstance(body, JoinedSpectrum):
        return body
    return sharpened(body, float(file.tip), file.tip_correction)


@functools.lru_cache(maxsize=16)
def _load_reading(file: _ScanFile) -> FileReading[Profile | Surface]:
    settings = file.settings
    return read_with_interpretation(
        file.path, unit=settings.unit, spacing=format_quantities(settings.spacing), missing=settings.missing,
        channel=settings.channel, columns=settings.columns, outliers=settings.outliers,
        crop=format_quantities(settings.crop), missing_value=settings.missing_value, accept=settings.accept,
    )  # fmt: skip


@dataclass(frozen=True)
class EnsembleMember:
    """Two measured bodies that form a member, with their shift (µm), line index and surrogate flag."""

    pair: BodyPair
    x: float
    y: float
    line: int = 0
    surrogate: bool = False


@dataclass(frozen=True)
class SharedMemberProperties:
    """Properties that all members of a study have in common.

    Lengths are in µm, one per axis: (x,) for profiles, (y, x) for surfaces.
    """

    upper: MeasuredBody
    lower: MeasuredBody
    area: float
    shape: Sequence[int]
    spacing: Sequence[float]
    used_fractions: Sequence[float]
    scans: Sequence[Any]  # scans before they are divided into members


BODY_ATTRIBUTE_SPECS: dict[str, AttributeSpec] = {
    **{side: AttributeSpec(dtype=str) for side in SIDES},  # history of the body
    "shape": AttributeSpec(dtype=int, sizes=(1, 2), bounds=(1, MAX_STORED_VALUE)),
    "spacing_um": AttributeSpec(sizes=(1, 2), bounds=POSITIVE_STORED_VALUE),
    "fraction_used": AttributeSpec(sizes=(2,), bounds=(0, MAX_STORED_VALUE)),
    **{
        f"{side}_{name}_um": AttributeSpec(sizes=(1, 2), bounds=POSITIVE_STORED_VALUE)
        for side in SIDES
        for name in ("spacing", "extent")
    },
    # fraction of interpolated points, and area (µm²) or length (µm) of the largest gap
    **{f"{side}_filled": AttributeSpec(sizes=(2,), bounds=(0, MAX_STORED_VALUE), is_required=False) for side in SIDES},
    # fraction of the points that are missing between two measured points
    **{f"{side}_pierced": AttributeSpec(sizes=(1,), bounds=(0, 1), is_required=False) for side in SIDES},
    # ratio of the rms slopes of a map across and along its lay, if both maps have a lay
    **{f"{side}_lay": AttributeSpec(sizes=(1,), bounds=(1, MAX_STORED_VALUE), is_required=False) for side in SIDES},
    # change of ln(rms slope) along a single scan, and fraction of the mean square slope of the gap that it contributes
    **{f"{side}_drift": AttributeSpec(sizes=(2,), bounds=(0, MAX_STORED_VALUE), is_required=False) for side in SIDES},
}
"""Attributes of a result that describe measured bodies. A value for each axis is in the order of the array axes."""


@dataclass(frozen=True)
class BodyAttributes:
    """Metadata that a result stores for measured bodies. All fields are empty for generated bodies."""

    nominal_area: float | None = None  # nominal area of each member (µm²)
    attributes: dict[str, Any] = field(default_factory=dict)  # values by name, as in `BODY_ATTRIBUTE_SPECS`

    @classmethod
    def from_values(cls, nominal_area: float, values: Mapping[str, Any]) -> BodyAttributes:
        """Convert values of all body attributes, or of all but the optional ones, to the types that a result stores."""
        return cls(nominal_area, {name: BODY_ATTRIBUTE_SPECS[name].encode(value) for name, value in values.items()})


class MemberSource(Protocol):
    """Members of a study of two bodies. Each member index identifies one pair of bodies."""

    def member(self, index: int) -> EnsembleMember:
        """Return the member with the given index.

        Raises a `ValueError` if there are fewer members.
        """

    def find_shared_properties(self) -> SharedMemberProperties:
        """Return the properties that all members have in common."""


class CommonMeasuredSurfaceSettings(SettingsTableVariant):
    """Keys of `[surfaces]` that all studies of measured surfaces share."""

    bodies: ClassVar[str] = "measured areas"  # term for the bodies in error messages
    is_areal: ClassVar[bool] = True
    """True if members are independent pairs of height maps rather than profiles."""
    pressed: ClassVar[str]
    """Name of the members in reports."""

    kind: Literal["measured"] = Field(default="measured", description="Kind of surfaces: two measured files.")
    upper: MeasuredBodySettings = Field(
        description="Slider: a table with `file` and reading options, or "
        "a list of tables for several places on the part."
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
        """Name of the members in texts for users."""
        return POSITION_NAMES

    def cell_coordinates(self) -> dict[str, Floats]:
        """Return the cutoffs (µm) for which a result is computed."""
        return {"cut_off": to_value_array(self.cut_off)}

    def reported_cut_off(self) -> float:
        """Return the cutoff (µm) of the reported result, which is the first cutoff in the study."""
        return float(self.cell_coordinates()["cut_off"][0])

    def get_scan_cut_offs(self, wavelength: float) -> ScanCutoffs:
        """Return the cutoffs (µm, 0 for no filter) of the scans of each body, for a cutoff of the pair."""
        upper, lower = (tuple(scan.limit_cut_off(wavelength) for scan in getattr(self, side).scans) for side in SIDES)
        return upper, lower

    def with_changed_files(self, change: Callable[[MeasuredBodySettings, str], MeasuredBodySettings]) -> Self:
        """Return a copy of the table in which each file is replaced by `change(file, side)`."""
        return self.model_copy(update={side: change(getattr(self, side), side) for side in SIDES})

    @property
    def first_scan_member_index(self) -> int:
        """Index of the first member that consists of scans rather than surrogates."""
        return 0

    @property
    def scan_counts(self) -> tuple[int, int]:
        """Number of scans of each body, as a pair (upper, lower)."""
        return len(self.upper.scans), len(self.lower.scans)

    def scan_indices_of_members(self, members: Any) -> tuple[Any, Any]:
        """Return, for each member, the index of its upper scan and the index of its lower scan.

        Successive members use all pairs of scans in turn.
        """
        upper, lower = self.scan_counts
        pair_index = members % (upper * lower)
        return pair_index % upper, (pair_index + pair_index // math.lcm(upper, lower)) % lower

    def build_member_source(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair, seed: int
    ) -> MemberSource:
        """Low-pass filter each scan at its own cutoff (µm, 0 for no filter), and form members from the filtered scans.

        Raises a `ValueError` if there are no members.
        """
        raise NotImplementedError

    def filter_scans(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair
    ) -> Iterator[Profile | Surface]:
        """Yield both scans after low-pass filtering each scan at its own cutoff (µm, 0 for no filter)."""
        for scan, wavelength in zip(scans, cut_offs, strict=True):
            if isinstance(scan, JoinedSpectrum):
                press = type(self).model_fields["press"].default
                raise ValueError(f'surfaces.press must be "surrogates" for a spectrum, got "{press}"')
            if wavelength > 0:
                validate_cutoff("cutoff", wavelength, scan, longest=MAX_CUTOFF_FRACTION)
            yield cut_off(scan, wavelength) if wavelength > 0 else scan


# ---- Lines -----------------------------------------------------------------------------------------------------------

DEFAULT_NUM_SHIFTS = 16  # default number of relative positions of two height maps
DEFAULT_NUM_SURROGATES = 16  # default number of pairs of surrogate profiles
MAX_RELATIVE_POSITIONS = 100_000  # maximum number of positions for a pair of lines or maps


class MeasuredLineSettings(CommonMeasuredSurfaceSettings):
    """Keys of `[surfaces]` for lines from two measured files. Each upper line slides along a lower line."""

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
    replace: SurrogateBodies = Field(
        default="none", description="Bodies that are replaced by their surrogates, with a new surrogate for each line."
    )

    positions: (
        Annotated[
            tuple[LengthOrZero, ...], as_tuple, Field(min_length=1, max_length=MAX_RELATIVE_POSITIONS),
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
        """Return members that consist of lines from both scans or from their surrogates, at several positions."""
        upper, lower = self.filter_scans(scans, cut_offs)
        level: ProfileTrend | None = None if self.level == "none" else self.level
        positions = None if self.positions is None else tuple(map(float, self.positions))
        travel = max(positions) if positions else None if self.travel is None else float(self.travel)
        has_several_pairs = self.replace != "none" or isinstance(upper, Surface) or isinstance(lower, Surface)
        pairs = LinePairs(
            upper, lower, travel, level, self.along, self.replace, seed, has_several_pairs=has_several_pairs
        )
        return LineMemberSource(pairs, scans, self.offsets, positions)


@dataclass(frozen=True, eq=False)
class LineMemberSource:
    """Members of a study that presses profiles or lines of height maps."""

    pairs: LinePairs
    scans: tuple[MeasuredBody, MeasuredBody]
    # number of relative positions of each pair of lines, if there are several pairs
    offsets: int = 1
    # relative positions (µm) of each pair, or None for a quasi-random sequence
    positions: tuple[float, ...] | None = None

    def member(self, index: int) -> EnsembleMember:
        """Return a member, which consists of a slider and the section of the counterface below the slider."""
        pairs, num_offsets = self.pairs, self.offsets if self.positions is None else len(self.positions)
        line, offset_index = divmod(index, num_offsets) if pairs.has_several_pairs else (0, index)
        max_pair_count = pairs.max_pair_count()
        if max_pair_count is not None and line >= max_pair_count:
            raise ValueError(
                f"the surfaces have {max_pair_count} pairs of lines, but member {index} needs pair {line + 1}"
            )
        slider, counterface = pairs.pair(line)
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
        # Offset 0 is excluded for a single pair, because the two lines may be identical.
        is_unshifted = pairs.has_several_pairs and num_offsets == 1 and pairs.travel is None
        if is_unshifted or max_steps == 0:
            offset_steps = 0
        elif num_offsets == 1 and pairs.travel is not None and offset_index == 0:
            offset_steps = max_steps  # a single relative position is placed at the end of the travel
        else:
            offset_steps = 1 + min(int(quasi_random_point(offset_index + 1, 1)[0] * max_steps), max_steps - 1)
        return self._member_at(slider, counterface, offset_steps, line)

    def _member_at(self, slider: Profile, counterface: Profile, steps: int, line: int) -> EnsembleMember:
        """Return the member whose slider starts `steps` points after the start of the counterface."""
        offset = steps * slider.spacing
        pair = slider, piece_below_slider(counterface, offset, slider)
        return EnsembleMember(
            pair, offset, self.pairs.position_across_lines(line), line=line, surrogate=self.pairs.surrogates != "none"
        )

    def find_shared_properties(self) -> SharedMemberProperties:
        """Return the properties that all members have in common."""
        slider, counterface = self.pairs.pair(0)
        return _find_shared_line_properties(slider, counterface, len(slider) / len(counterface), self.scans)


def _find_shared_line_properties(
    slider: Profile, counterface: Profile, used_fraction: float, scans: tuple[Any, Any]
) -> SharedMemberProperties:
    """Return the properties shared by all members of a study of lines.

    `used_fraction` is the fraction of the upper scan that the slider covers.
    """
    return SharedMemberProperties(
        slider, counterface, slider.extent * PROFILE_WIDTH, [len(slider)], [slider.spacing],
        [used_fraction, len(slider) / len(counterface)], scans,
    )  # fmt: skip


class MeasuredMapSettings(CommonMeasuredSurfaceSettings):
    """Keys of `[surfaces]` for two measured height maps at several relative positions."""

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
            tuple[Annotated[tuple[SignedLength, SignedLength], as_tuple], ...], as_tuple,
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
        """Name of the members in texts for users. It is general if some members are pairs of surrogates."""
        return GENERAL_MEMBER_NAMES if self.surrogates else POSITION_NAMES

    @property
    def first_scan_member_index(self) -> int:
        """Index of the first member that consists of pieces of the measured maps. Earlier members are surrogates."""
        return self.surrogates

    def build_member_source(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair, seed: int
    ) -> MapMemberSource | GapMemberSource:
        """Return the members, which are surrogates followed by pairs of map pieces, or a single measured gap."""
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
    """Keys of `[surfaces]` for surrogates, which are random height maps with the spectra of two scans."""

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
        """Name of the members in texts for users."""
        return SURROGATE_PAIR_NAMES

    def build_member_source(
        self, scans: tuple[MeasuredBody, MeasuredBody], cut_offs: CutoffPair, seed: int
    ) -> MapMemberSource:
        """Return the members. Each is a pair of random height maps with the spectra of two scans."""
        first, second = scans
        if isinstance(first, JoinedSpectrum) or isinstance(second, JoinedSpectrum):
            shortest_cutoff = float(self.cell_coordinates()["cut_off"].min())
            return MapMemberSource(
                SpectralSurfacePairs(
                    to_joined_spectrum(first), to_joined_spectrum(second), self.level, seed, cut_offs, shortest_cutoff
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


def build_map_pairs(
    upper: Surface, lower: Surface, level: SurfaceTrend, seed: int, *, rotation: float = 0.0,
    shifts: tuple[tuple[float, float], ...] | None = None,
) -> MapPairs:  # fmt: skip
    """Level two maps, and cut them into pieces that form pairs.

    The upper map is flipped, and rotated by an angle in degrees.
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
    """Members of a study that presses height maps or surrogates of scans."""

    pairs: MapPairs | IsotropicSurfacePairs | SpectralSurfacePairs
    scans: tuple[MeasuredBody, MeasuredBody]
    # number of pairs of surrogates (the first members); None if all members are surrogates
    surrogates: int | None = None

    def member(self, index: int) -> EnsembleMember:
        """Return a member, which is a pair of surrogates or a pair of overlapping map pieces."""
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
        """Return the properties that all members have in common."""
        pairs = self.pairs
        scans: Sequence[Any] = self.scans
        if isinstance(pairs, SpectralSurfacePairs):  # a scan resolves wavelengths of at least two points
            wavelengths = (max(body.shortest, pairs.finest_spacing) for body in (pairs.upper, pairs.lower))
            scans = [SimpleNamespace(spacing=shortest / 2, extent=pairs.side_length) for shortest in wavelengths]
        return SharedMemberProperties(
            pairs.upper, pairs.lower, pairs.area, pairs.shape, pairs.spacing, pairs.used_fractions, scans
        )


@dataclass(frozen=True, eq=False)
class GapMemberSource:
    """Source of the only member in a study of a measured gap: a flat face and a rough face, separated by the gap."""

    flat: Surface
    rough: Surface

    def member(self, index: int) -> EnsembleMember:
        """Return the ensemble member that consists of the flat face and the rough face."""
        if index > 0:
            raise ValueError(f"a gap has only member 0, got member {index}")
        return EnsembleMember((self.flat, self.rough), 0.0, 0.0)

    def find_shared_properties(self) -> SharedMemberProperties:
        """Return the properties that all members have in common."""
        faces = self.flat, self.rough
        return SharedMemberProperties(
            *faces, float(np.prod(self.rough.extent)), self.rough.heights.shape, self.rough.spacing, [1.0, 1.0], faces
        )  # fmt: skip


MeasuredSurfaceSettings = MeasuredMapSettings | MeasuredLineSettings | SurrogateSettings
"""Table `[surfaces]` of a study of measured files, with a class for each kind of member."""
