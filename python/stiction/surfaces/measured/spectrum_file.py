"""CSV files that contain the spectrum of a surface, joined from the spectra of several scans."""

from __future__ import annotations

import io
import json
import os
import re
from pathlib import Path
from typing import Any

import numpy as np

from stiction._checks import check_instance, make_read_only, parse_path
from stiction._files import UnreadableFileError, create_file_atomically, read_file_bytes
from stiction._text import printable_path, printable_text
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.measured.raw import MAX_TEXT_BYTES, FormatError

WAVE_NUMBER_COLUMN, DENSITY_COLUMN, WAVE_COUNT_COLUMN = "wave number (1/um)", "C2D (um4)", "waves"
"""Column names of a spectrum file. Tables from other programs need not have the last column."""

# Prefixes of two columns per scan: the scan's fraction of wave vectors, and its density divided by the joined density.
WAVE_VECTOR_FRACTION_COLUMN_PREFIX, DENSITY_RATIO_COLUMN_PREFIX = "fraction of ", "power over the joined of "
_SCAN_LINE_PATTERN = re.compile(
    r"# scan: (?P<name>.+), from (?P<shortest>\S+) to (?P<longest>\S+) um, ended by (?P<reason>.+)"
)
_HASH_LINE_PATTERN = re.compile(r"^#.*\n?", re.MULTILINE)
_NUM_BYTES_WITH_COLUMN_NAMES = 100_000
# Wave numbers in files are rounded, so ln(ratio of successive wave numbers) may vary by this fraction of its mean.
_WAVE_NUMBER_RATIO_TOLERANCE = 1e-3


def write_spectrum(spectrum: JoinedSpectrum, path: str | os.PathLike[str]) -> None:
    """Write a spectrum joined from several scans to a CSV file: density, slope and curvature at each wavelength.

    All numbers are preserved exactly.

    Parameters
    ----------
    spectrum : JoinedSpectrum
        Spectrum to write.
    path : path
        Path ending in .csv. The file must not exist; it appears when it is complete.

    Raises
    ------
    FormatError
        A `ValueError`, if the path has another ending, or the file exists or cannot be written.

    See Also
    --------
    read_spectrum : Inverse function.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from stiction import joined_spectrum, read_spectrum, self_affine_surface, write_spectrum
    >>> scan = self_affine_surface(1, hurst_exponent=0.8, rms=0.1, shape=(128, 128), spacing=0.01)
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "joined.csv"
    >>> write_spectrum(joined_spectrum([scan], names=["probe"]), path)
    >>> read_spectrum(path).names
    ('probe',)
    """
    import pandas

    check_instance("spectrum", spectrum, JoinedSpectrum, "a JoinedSpectrum")
    path = parse_path("path", path)
    if path.suffix.lower() != ".csv":
        raise FormatError(f"{path}: cannot be written: its name must end in .csv")
    names = [_format_scan_name(name) for name in spectrum.names]
    if len(set(names)) < len(names):
        names = [_format_scan_name(f"{name} ({index})") for index, name in enumerate(spectrum.names, 1)]
    roughness = spectrum.roughness()
    columns: dict[str, Any] = {
        "wavelength (um)": roughness.wavelength, "rms gradient down to this wavelength": roughness.gradient,
        "rms curvature down to this wavelength (1/um)": roughness.curvature, WAVE_NUMBER_COLUMN: spectrum.wave_number,
        DENSITY_COLUMN: spectrum.density, WAVE_COUNT_COLUMN: spectrum.count,
    }  # fmt: skip
    for prefix, rows in (
        (WAVE_VECTOR_FRACTION_COLUMN_PREFIX, spectrum.contribution),
        (DENSITY_RATIO_COLUMN_PREFIX, spectrum.ratio),
    ):
        columns |= {f"{prefix}{name}": row for name, row in zip(names, rows, strict=True)}
    scans = [
        f"# scan: {name}, from {shortest!r} to {longest!r} um, ended by {reason}\n"
        for name, (shortest, longest), reason in zip(names, spectrum.bands, spectrum.reasons, strict=True)
    ]
    with create_file_atomically(path, FormatError) as partial_file:
        text = pandas.DataFrame(columns).to_csv(index=False, lineterminator="\n")
        partial_file.write_text("".join(scans) + text, encoding="utf-8")


def _format_scan_name(name: str) -> str:
    """Format the name of a scan as one line of text, or as a JSON string if plain text would not preserve the name."""
    is_plain = name == printable_text(name, len(name)) and name == " ".join(name.split()) and name[:1] not in ("", '"')
    return name if is_plain else json.dumps(name)


def _parse_scan_name(text: str) -> str:
    try:
        name = json.loads(text) if text.startswith('"') else text
    except ValueError:
        return text
    return name if isinstance(name, str) else text


def is_spectrum_file(path: Path) -> bool:
    """Return whether a file is a CSV table with a column of spectral density, as `write_spectrum` writes it."""
    # Reading a pipe would block, so only a file is read.
    if path.suffix.lower() != ".csv" or not path.is_file():
        return False
    try:
        with path.open("rb") as file:
            header_text = file.read(_NUM_BYTES_WITH_COLUMN_NAMES).decode("utf-8-sig", "replace")
    except OSError:
        return False
    names = next((line for line in header_text.splitlines() if line.strip() and not line.startswith("#")), "")
    return DENSITY_COLUMN in names


def read_spectrum(path: str | os.PathLike[str]) -> JoinedSpectrum:
    r"""Read the spectrum of a surface from a CSV file.

    `write_spectrum`, ``stiction characterise --together`` or another program may have written the file.

    Parameters
    ----------
    path : path
        CSV with the columns "wave number (1/um)", ascending with equal ratios, and "C2D (um4)". The integral of C2D
        over the plane of wave numbers, divided by 4π², is the mean square height. Other columns are optional.

    Returns
    -------
    spectrum : JoinedSpectrum
        Spectrum C2D (µm⁴) over the wave number (1/µm).

    Raises
    ------
    FormatError
        A `ValueError`, if the file cannot be read or is not a spectrum.

    See Also
    --------
    write_spectrum : Inverse function.

    Examples
    --------
    >>> import pathlib, tempfile
    >>> from stiction import read_spectrum
    >>> path = pathlib.Path(tempfile.mkdtemp()) / "published.csv"
    >>> _ = path.write_text("wave number (1/um),C2D (um4)\n1,1e-4\n2,3e-6\n4,9e-8\n")
    >>> read_spectrum(path).shortest.__round__(2)
    1.11
    """
    import pandas

    path = parse_path("path", path)
    try:
        text = read_file_bytes(path, MAX_TEXT_BYTES).decode("utf-8-sig", "replace")
        # Numbers are read as text, because pandas before version 3 would round the numbers of a spectrum file.
        table = pandas.read_csv(io.StringIO(_HASH_LINE_PATTERN.sub("", text)), dtype=str)
    except OSError as error:
        raise FormatError(f"{printable_path(path)}: cannot be read: {error.strerror}") from None
    except UnreadableFileError as error:
        raise FormatError(f"{printable_path(path)}: {error}") from None
    except ValueError:
        # Pandas raises ValueError if the text is not a table.
        raise FormatError(f"{printable_path(path)} is not a table with the columns of a spectrum") from None
    scans = [match for line in text.split("\n") if (match := _SCAN_LINE_PATTERN.fullmatch(line.rstrip("\r")))]
    names = [match["name"] for match in scans]
    try:
        q, density = (np.array(table[name], np.float64) for name in (WAVE_NUMBER_COLUMN, DENSITY_COLUMN))
        count = np.array(table[WAVE_COUNT_COLUMN], np.float64) if WAVE_COUNT_COLUMN in table else np.ones(q.size)
        contribution, ratio = (
            np.array([table[f"{prefix}{name}"] for name in names], np.float64).reshape(len(names), q.size)
            for prefix in (WAVE_VECTOR_FRACTION_COLUMN_PREFIX, DENSITY_RATIO_COLUMN_PREFIX)
        )
        bands = tuple((float(match["shortest"]), float(match["longest"])) for match in scans)
    except KeyError as error:
        raise FormatError(
            f"{printable_path(path)} is not a spectrum, because it has no column {error.args[0]!r}"
        ) from None
    except ValueError:
        raise FormatError(
            f"{printable_path(path)} is not a spectrum, because it contains values that are not numbers"
        ) from None
    log_steps = np.diff(np.log(q)) if (q > 0).all() and np.isfinite(q).all() else np.empty(0)
    if (
        not log_steps.size
        or not (log_steps > 0).all()
        or np.ptp(log_steps) > _WAVE_NUMBER_RATIO_TOLERANCE * log_steps.mean() + 1e-12
    ):
        raise FormatError(
            f"{printable_path(path)} is not a spectrum, because {WAVE_NUMBER_COLUMN!r} is not an increasing geometric "
            "sequence"
        )
    if not (density > 0).all() or not np.isfinite(density).all():
        raise FormatError(
            f"{printable_path(path)} is not a spectrum, because a value of {DENSITY_COLUMN!r} is not above 0"
        )
    return JoinedSpectrum(
        wave_number=make_read_only(q), density=make_read_only(density), count=make_read_only(count),
        contribution=make_read_only(contribution), ratio=make_read_only(ratio), bands=bands,
        reasons=tuple(match["reason"] for match in scans), names=tuple(map(_parse_scan_name, names)),
    )  # fmt: skip
