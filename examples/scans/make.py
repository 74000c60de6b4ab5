"""Write the sample scans in this directory, which are generated faces in the file formats of instruments.

    python examples/scans/make.py DIRECTORY

There are two stylus profiles of honed steel and two of lapped steel as text, and two interferometer maps of ground
steel as X3P. They have the tilt of an unlevelled specimen, instrument noise, and heights in whole converter steps. The
honed profiles are long enough and have little enough noise for the assessment "Quote it".
"""

import hashlib
import sys
import zipfile
from pathlib import Path

import numpy as np
from stiction import self_affine, self_affine_surface

TRACE_OPTIONS = {
    "lapped": {"points": 4000, "spacing": 0.1, "waves": (40.0, 1.0), "noise": 0.3, "step": 0.1},
    "honed": {"points": 6000, "spacing": 0.2, "waves": (60.0, 4.0), "noise": 0.02, "step": 0.01},
}
"""Number of points, lengths (µm), noise (nm) and converter step (nm) of the trace of each finish."""
MAP_SIDE_POINTS = 256
PIXEL_SIZE = 0.2  # µm
ADC_HEIGHT_STEP = 5e-11  # m
SIDES = ("upper", "lower")

MAIN_XML = """<?xml version="1.0" encoding="UTF-8"?>
<p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2">
<Record1><Revision>ISO5436 - 2000</Revision><FeatureType>SUR</FeatureType><Axes>
<CX><AxisType>I</AxisType><DataType>D</DataType><Increment>{pixel!r}</Increment><Offset>0.0</Offset></CX>
<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>{pixel!r}</Increment><Offset>0.0</Offset></CY>
<CZ><AxisType>A</AxisType><DataType>I</DataType><Increment>{step!r}</Increment><Offset>0.0</Offset></CZ>
</Axes></Record1>
<Record2><Comment>Generated, not measured: stiction, examples/scans/make.py</Comment></Record2>
<Record3><MatrixDimension><SizeX>{columns}</SizeX><SizeY>{rows}</SizeY><SizeZ>1</SizeZ></MatrixDimension>
<DataLink><PointDataLink>bindata/data.bin</PointDataLink>
<MD5ChecksumPointData>{checksum}</MD5ChecksumPointData></DataLink></Record3>
<Record4><ChecksumFile>md5checksum.hex</ChecksumFile></Record4>
</p:ISO5436_2>
"""


def stylus_trace_text(finish: str, side: str) -> str:
    """Return a text file of a stylus instrument, with positions in µm and heights in nm."""
    points, spacing, num_waves, noise_deviation, height_step = TRACE_OPTIONS[finish].values()
    face = self_affine(
        11 if finish == "lapped" else 21,
        hurst_exponent=0.8,
        rms=0.05,
        points=points,
        spacing=spacing,
        longest_wavelength=num_waves[0],
        shortest_wavelength=num_waves[1],
        side=side,
    )
    noise = np.random.default_rng(SIDES.index(side)).normal(0.0, noise_deviation, points)
    heights = np.round((1000.0 * face.heights + 0.4 * face.x + noise) / height_step) * height_step
    lines = [f"{x:.1f},{z:.{1 if height_step > 0.05 else 2}f}\n" for x, z in zip(face.x, heights, strict=True)]
    return "".join([f"# generated, not measured: {finish} steel, stylus\n", "x (um),z (nm)\n", *lines])


def create_map_quantised_by_adc(side: str) -> np.ndarray:
    """Return an interferometer map with heights in whole converter steps. The grinding marks run along y."""
    face = self_affine_surface(
        12,
        hurst_exponent=0.8,
        rms=0.05,
        shape=(MAP_SIDE_POINTS, MAP_SIDE_POINTS),
        spacing=(PIXEL_SIZE / 5.0, PIXEL_SIZE),  # square pixels stretch the map five times along y
        longest_wavelength=6.0,
        shortest_wavelength=1.0,
        side=side,
    )
    y, x = np.indices((MAP_SIDE_POINTS, MAP_SIDE_POINTS)) * PIXEL_SIZE
    noise = np.random.default_rng(SIDES.index(side)).normal(0.0, 1e-4, (MAP_SIDE_POINTS, MAP_SIDE_POINTS))
    heights = face.heights + 2e-3 * x - 1e-3 * y + noise
    return np.round((heights - heights.mean()) * 1e-6 / ADC_HEIGHT_STEP).astype("<i2")


def write_x3p(path: Path, height_steps: np.ndarray) -> None:
    """Write a surface as a file of ISO 25178-72. Every call writes the same bytes."""
    data = height_steps.tobytes()
    rows, columns = height_steps.shape
    checksum = hashlib.md5(data, usedforsecurity=False).hexdigest()
    main_xml = MAIN_XML.format(
        pixel=PIXEL_SIZE * 1e-6, step=ADC_HEIGHT_STEP, columns=columns, rows=rows, checksum=checksum
    ).encode()
    checksum_text = f"{hashlib.md5(main_xml, usedforsecurity=False).hexdigest()} *main.xml\n".encode()
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED, compresslevel=9) as archive:
        for name, content in (("main.xml", main_xml), ("bindata/data.bin", data), ("md5checksum.hex", checksum_text)):
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)


def main(directory: Path) -> None:
    """Write the six scan files."""
    directory.mkdir(parents=True, exist_ok=True)
    for side in SIDES:
        for finish in TRACE_OPTIONS:
            (directory / f"{finish}_{side}.csv").write_text(stylus_trace_text(finish, side), encoding="utf-8")
        write_x3p(directory / f"ground_{side}.x3p", create_map_quantised_by_adc(side))


if __name__ == "__main__":
    main(Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent)
