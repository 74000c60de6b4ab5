"""Measured bodies of a study: their keys in a study file, and the reading and preparation of scan files."""

from __future__ import annotations

import dataclasses
import functools
import hashlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import numpy as np
from pydantic import ConfigDict, Field, PlainValidator, model_validator

from stiction._checks import Floats
from stiction._errors import ArgumentError
from stiction._files import UnreadableFileError, check_is_file, describe_os_error
from stiction._text import printable_path
from stiction._units import Quantity, quantity, short_repr
from stiction.study.values import (
    Length,
    LengthOrZero,
    SettingsSection,
    format_quantities,
    list_to_tuple_validator,
    parse_positive_length,
    quantity_serializer,
)
from stiction.surfaces.interchange import extract_heights
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.measured.interpret import MissingPointTreatment, OutlierTreatment
from stiction.surfaces.measured.plausibility import FILE_CAVEAT_NAMES, ScannedHeights, find_caveats
from stiction.surfaces.measured.raw import LENGTH_UNITS, FileCaveat
from stiction.surfaces.measured.reading import FileReading, read_with_interpretation
from stiction.surfaces.measured.spectrum_file import is_spectrum_file, read_spectrum, write_spectrum
from stiction.surfaces.measured.writing import write_profile, write_surface
from stiction.surfaces.missing_data import find_largest_gap
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface, parse_lengths
from stiction.surfaces.tip import sharpened

ColumnNameOrIndex = int | str


MeasuredBody = Profile | Surface | JoinedSpectrum


MAX_FILE_NAME_LENGTH = 4096  # characters


MachiningProcess = Literal["turned", "milled", "ground", "honed", "lapped", "sanded", "blasted", "eroded"]


MACHINING_PROCESSES: tuple[str, ...] = get_args(MachiningProcess)


BodyPair = tuple[Profile, Profile] | tuple[Surface, Surface]


# Cutoff wavelengths (µm) of the upper and the lower scan.
CutoffPair = tuple[float, float]


ScanCutoffs = tuple[tuple[float, ...], tuple[float, ...]]  # µm


def _parse_unit(value: object) -> str:
    if not isinstance(value, str) or value not in LENGTH_UNITS:
        raise ValueError(f"must be one or two units of length (m, mm, um, nm, ...), got {short_repr(value)}")
    return value


def _parse_column(value: object) -> ColumnNameOrIndex:
    if isinstance(value, bool) or not isinstance(value, (str, int)) or (isinstance(value, int) and value < 0):
        raise ValueError(f"must be a name or a whole number of at least 0, got {short_repr(value)}")
    return value


def _parse_missing_values(value: object) -> tuple[float | str, ...] | None:
    """Parse the numbers and words that mark missing points in a scan file, such as -9999 or "BAD"."""
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
    """Parse the names of the caveats that the user has accepted."""
    if value is None:
        return None
    caveat_names = [entry.strip() for entry in value.split(",")] if isinstance(value, str) else value
    if not isinstance(caveat_names, (list, tuple)) or not set(caveat_names) <= set(FILE_CAVEAT_NAMES):
        raise ValueError(f"must be one of {', '.join(FILE_CAVEAT_NAMES)}, or a list of these, got {short_repr(value)}")
    return tuple(caveat_names)


def _parse_crop(value: object) -> tuple[Quantity, ...] | None:
    if value is None:
        return None
    texts = value.split(",") if isinstance(value, str) else value
    if not isinstance(texts, (list, tuple)) or len(texts) not in (2, 4):
        raise ValueError(f'must be "x0,x1" or "x0,x1,y0,y1", got {short_repr(value)}')
    return tuple(quantity(text.strip() if isinstance(text, str) else text, "length") for text in texts)


def _build_one_or_list_validator(read: Callable[[object], Any], max_count: int = 2) -> PlainValidator:
    """Build a pydantic validator that accepts None, a single value, or a list of 2 to `max_count` values."""

    def parse_one_or_list(value: object) -> Any:
        if not isinstance(value, (list, tuple)):
            return None if value is None else read(value)
        if not 2 <= len(value) <= max_count:
            allowed_count = "two" if max_count == 2 else f"two to {max_count}"
            raise ValueError(f"must be a single value or a list of {allowed_count} values, got {short_repr(value)}")
        return tuple(map(read, value))

    return PlainValidator(parse_one_or_list)


MIN_HEIGHT_FACTOR, MAX_HEIGHT_FACTOR = 0.01, 100.0


MAX_TIP_CORRECTION = 10.0


class BodyInMemory:
    """Measured body that the user passes as an object in memory instead of as a file.

    The class is not a dataclass, so that copies of a study share the body.
    """

    def __init__(self, body: Any) -> None:
        self.body = body


class MeasuredBodySettings(SettingsSection):
    """Measured profile, height map or joined spectrum of a study, from a scan file or from memory."""

    model_config = ConfigDict(arbitrary_types_allowed=True)

    def __eq__(self, value: object) -> bool:
        """Compare the settings of two bodies, key by key.

        Bodies in memory are compared by checksum and history.
        """
        return isinstance(value, MeasuredBodySettings) and self._get_compared_values() == value._get_compared_values()

    def __hash__(self) -> int:
        return hash(self._get_compared_values())

    def _get_compared_values(self) -> tuple[Any, ...]:
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
        Quantity | tuple[Quantity, Quantity] | None,
        _build_one_or_list_validator(parse_positive_length),
        quantity_serializer,
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
    crop: Annotated[tuple[Quantity, ...] | None, PlainValidator(_parse_crop), quantity_serializer] = Field(
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
        "`pair` uses it in its companion study of a blunt tip.",
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
    others: Annotated[tuple[MeasuredBodySettings, ...], list_to_tuple_validator] | None = Field(
        default=None,
        description="Further scans at other places on the same part; in a list of files, all files after the first.",
    )

    @model_validator(mode="before")
    @classmethod
    def _parse_scan_list(cls, value: Any) -> Any:
        if not isinstance(value, (list, tuple)) or not value:
            return value
        first_section, *other_sections = ({"file": item} if isinstance(item, str) else item for item in value)
        return (
            {**first_section, "others": tuple(other_sections)} if isinstance(first_section, Mapping) else first_section
        )

    @property
    def scans(self) -> tuple[MeasuredBodySettings, ...]:
        """Scans of the body: the scan in this file, and scans of other places on the same body."""
        return self, *(self.others or ())

    @property
    def name(self) -> str:
        """Name of the body in output: name of its first scan file, and number of further scans."""
        return Path(self.file).name + (f" and {len(self.others)} more" if self.others else "")

    def _apply_to_scans(self, change: Callable[[MeasuredBodySettings], MeasuredBodySettings]) -> MeasuredBodySettings:
        return change(self).model_copy(update={"others": self.others and tuple(map(change, self.others))})

    @classmethod
    def from_body(cls, body: Any, name: str) -> MeasuredBodySettings:
        """Create the study entry of a body in memory, which may be an object of another library.

        Raises an `ArgumentError` if the body is invalid.
        """
        if not isinstance(body, JoinedSpectrum):
            try:
                heights, spacing, history, missing = extract_heights(name, body)
            except ValueError as error:
                raise ArgumentError.for_argument(name, str(error).removeprefix(name).lstrip()) from None
            body_class: Any = Profile if heights.ndim == 1 else Surface
            body = body_class(
                heights, spacing=spacing[0] if body_class is Profile else parse_lengths("spacing", spacing),
                history=history, missing=missing,
            )  # fmt: skip
        return cls(file=name, sha256=_compute_checksum(body), body=BodyInMemory(body))

    def with_saved_bodies(self, directory: Path, side: str) -> MeasuredBodySettings:
        """Write the scans that are in memory to files, and return a copy of the body that refers to these files."""
        return self._apply_to_scans(lambda scan: scan._with_saved_body(directory, side))

    def _with_saved_body(self, directory: Path, side: str) -> MeasuredBodySettings:
        if self.body is None:
            return self
        assert self.sha256 is not None
        body = self.body.body
        file_extension = "csv" if isinstance(body, JoinedSpectrum) else "npy"
        path = (directory / "bodies" / self.sha256[:12] / f"{side}.{file_extension}").absolute()
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
        """Read the profile, height map or spectrum from the file, and multiply its heights by the height factor.

        Raises a `ValueError` if the checksum of the file differs.
        """
        return _scale_heights(self.height_factor, self._read_unscaled())  # type: ignore[no-any-return]

    def _read_unscaled(self) -> MeasuredBody:
        """Read the profile, height map or spectrum from the file without applying the height factor."""
        if self.body is not None:
            return _correct_for_tip(self, self.body.body)
        checksum = self.checksum()
        if self.sha256 is not None and checksum != self.sha256:
            raise ValueError(
                f"{printable_path(self.file)} has changed since the study was created: its SHA-256 is not "
                f"{self.sha256[:12]}...; remove sha256 from the study to start a new study with this file"
            )
        return _load_scanned_body(self._identify_content(checksum))

    def _identify_content(self, checksum: str) -> _ScanFile:
        """Return the cache key of the file: file name, checksum and reading options."""
        unrelated_keys = {"others": None, "height_factor": 1.0, "max_cut_off": None, "texture": None}
        return _ScanFile(
            self.model_copy(update={"file": Path(self.file).name, "sha256": checksum} | unrelated_keys), Path(self.file)
        )

    def with_height_factor(self, factor: float) -> MeasuredBodySettings:
        """Return a copy of the body in which the heights of all scans are multiplied by an additional factor.

        Raises a `ValueError` if the product of this factor and the height factor of a scan is out of range.
        """
        for scan in self.scans:
            total_factor = factor * scan.height_factor
            if not MIN_HEIGHT_FACTOR <= total_factor <= MAX_HEIGHT_FACTOR:
                allowed_range = f"from {MIN_HEIGHT_FACTOR:g} to {MAX_HEIGHT_FACTOR:g}"
                raise ValueError(f"height_factor must be {allowed_range}, got {total_factor:g} for {scan.name}")
        return self._apply_to_scans(lambda scan: scan.model_copy(update={"height_factor": factor * scan.height_factor}))

    def without_directories(self) -> MeasuredBodySettings:
        """Return a copy of the body in which the names of scan files have no directories."""
        return self._apply_to_scans(lambda scan: scan.model_copy(update={"file": Path(scan.file).name}))

    def with_masked_outliers(self, *, interpolate: bool) -> MeasuredBodySettings:
        """Return a copy of the body in which the outliers of all scans are missing points.

        With `interpolate`, the heights at missing points are interpolated in scans that would otherwise reject missing
        points.
        """

        def mask_outliers(scan: MeasuredBodySettings) -> MeasuredBodySettings:
            missing = "interpolate" if interpolate and scan.missing == "error" else scan.missing
            return scan.model_copy(update={"outliers": "mask", "missing": missing})

        return self._apply_to_scans(mask_outliers)

    def with_tip_correction(self, factor: float) -> MeasuredBodySettings:
        """Return a copy of the body whose scans are sharpened by `factor` times the tip correction.

        Scans with an unknown tip radius are unchanged.
        """
        return self._apply_to_scans(
            lambda scan: scan if scan.tip is None else scan.model_copy(update={"tip_correction": factor})
        )

    @property
    def bodies(self) -> list[Profile | Surface]:
        """Profiles and height maps from the scans of the body, without spectra."""
        return [body for scan in self.scans if isinstance(body := scan.read(), (Profile, Surface))]

    def select_cut_off_of_scan(self, wavelength: float) -> float:
        """Return the smaller of two cutoffs (µm): the cutoff of the pair, and the maximum cutoff of this scan."""
        return wavelength if self.max_cut_off is None else min(wavelength, float(self.max_cut_off))

    def find_interpolated_fraction_and_gap(self) -> Floats:
        """Return the fraction of interpolated points, and the size of the largest region of missing points.

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
        """Interpretation of the scan file: columns, units and caveats.

        None for bodies without such a file.
        """
        if self.body is not None or is_spectrum_file(Path(self.file)):
            return None
        return _read_scan_file(self._identify_content(self.checksum()))

    @property
    def caveats(self) -> tuple[FileCaveat, ...]:
        """Caveats about the scan file or, for a body in memory, about its heights."""
        if (reading := self.reading) is not None:
            return tuple(reading.caveats)
        body = None if self.body is None else self.body.body
        if not isinstance(body, (Profile, Surface)):
            return ()
        return find_caveats(ScannedHeights(body.heights_with_nan, body.spacings, from_file=False, from_text=False))

    def checksum(self) -> str:
        """Compute the SHA-256 checksum of the scan file.

        Raises a `ValueError` if the file cannot be read.
        """
        path = Path(self.file)
        try:
            # Reading from a device or a pipe might never end.
            check_is_file(path)
            with path.open("rb") as file:
                return hashlib.file_digest(file, "sha256").hexdigest()
        except UnreadableFileError as error:
            raise ValueError(f"{printable_path(path)}: {error}") from None
        except OSError as error:
            raise ValueError(f"{printable_path(path)}: cannot be read: {describe_os_error(error)}") from None

    def file_stamp(self) -> tuple[int, int] | None:
        """Return modification time (ns) and size (bytes) of the scan file.

        Returns None if the file does not exist.
        """
        try:
            file_status = None if self.body else Path(self.file).stat()
        except OSError:
            return None
        return file_status and (file_status.st_mtime_ns, file_status.st_size)

    def with_absolute_paths(self, directory: Path) -> MeasuredBodySettings:
        """Return a copy of the body with absolute paths of scan files.

        `directory` is the base of relative paths.
        """
        return self._apply_to_scans(
            lambda scan: (
                scan if scan.body else scan.model_copy(update={"file": str((directory / scan.file).absolute())})
            )
        )

    def with_checksums(self) -> MeasuredBodySettings:
        """Return a copy of the body with the checksums of all scan files.

        Missing checksums are computed.
        """
        return self._apply_to_scans(
            lambda scan: scan if scan.sha256 is not None else scan.model_copy(update={"sha256": scan.checksum()})
        )


def _scale_heights(factor: float, body: Any) -> Any:
    """Return a copy of a body with all heights multiplied by a factor."""
    if factor == 1:
        return body
    if isinstance(body, JoinedSpectrum):
        return dataclasses.replace(body, density=body.density * factor**2)
    return body.changed(body.heights * factor, f"heights times {factor:g}")


def _compute_checksum(body: MeasuredBody) -> str:
    """Compute the SHA-256 checksum of the heights of a body in memory.

    The checksum does not depend on the history, which later versions may describe in other words.
    """
    if isinstance(body, JoinedSpectrum):
        arrays = body.wave_number, body.density, body.count, body.contribution, body.ratio
        content = repr((body.bands, body.names)).encode() + b"".join(values.tobytes() for values in arrays)
    else:
        content = repr((body.heights.shape, body.spacing)).encode() + body.heights_with_nan.tobytes()
    return hashlib.sha256(content).hexdigest()


@dataclass(frozen=True)
class _ScanFile:
    """Cache key for the content of a scan file: file name, checksum and reading options.

    The path of the file is not compared.
    """

    settings: MeasuredBodySettings
    path: Path = field(compare=False)


@functools.lru_cache(maxsize=16)
def _load_scanned_body(file: _ScanFile) -> MeasuredBody:
    """Read the body from a scan file, or return a cached body with the same file content and reading options."""
    settings = file.settings
    if is_spectrum_file(file.path):
        for name in ("unit", "spacing", "channel", "columns", "crop"):
            if getattr(settings, name) is not None:
                raise ValueError(
                    f"{printable_path(file.path)} is a spectrum, which has no {name}; remove the key {name}"
                )
        return read_spectrum(file.path)
    return _correct_for_tip(settings, _read_scan_file(file).body)


def _correct_for_tip(file: MeasuredBodySettings, body: MeasuredBody) -> MeasuredBody:
    """Correct a scan for the radius of its tip, with the correction multiplied by the factor in the study."""
    if file.tip is None or file.tip_correction is None or isinstance(body, JoinedSpectrum):
        return body
    return sharpened(body, float(file.tip), file.tip_correction)


@functools.lru_cache(maxsize=16)
def _read_scan_file(file: _ScanFile) -> FileReading[Profile | Surface]:
    settings = file.settings
    return read_with_interpretation(
        file.path, unit=settings.unit, spacing=format_quantities(settings.spacing), missing=settings.missing,
        channel=settings.channel, columns=settings.columns, outliers=settings.outliers,
        crop=format_quantities(settings.crop), missing_value=settings.missing_value, accept=settings.accept,
    )  # fmt: skip
