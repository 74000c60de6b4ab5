import functools
import hashlib
import io
import os
import re
import time
import tracemalloc
import zipfile
from collections import Counter

import numpy as np
import pytest
from stiction import (
    FormatError,
    FormatWarning,
    Profile,
    Surface,
    levelled,
    random_phases,
    read_measurement,
    read_profile,
    read_surface,
    weierstrass_mandelbrot,
    write_profile,
    write_surface,
)
from stiction.surfaces.measured import decode as text_files
from stiction.surfaces.measured import excel, raw
from stiction.surfaces.measured import npy as npy_files
from stiction.surfaces.measured import split as split_files
from stiction.surfaces.measured.raw import RawHeights
from stiction.surfaces.measured.reading import READERS
from support import fuzzing

HEIGHTS = [0.5, -0.25, 1.0, 0.125, 2.0]


@pytest.fixture
def write_file(tmp_path):
    """Return a function that writes content to a file with a given name, and returns the path of the file."""

    def write(content, name="scan.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return write


def get_error_message(path, read=read_profile, **options):
    """Return the error message about a file, which must be one sentence that begins with the name of the file."""
    with pytest.raises(FormatError) as error_info:
        read(path, **options)
    message = str(error_info.value)
    assert message.startswith(f"{path}: ")
    assert "\n" not in message
    return message


# ---- Text -----------------------------------------------------------------------------------------------------------


@functools.cache
def create_map_of_many_characters():
    """Return the cells and the heights of a map so long that it is converted in several parts."""
    random = np.random.default_rng(4)
    values = (random.normal(size=(200, 300)) * 10.0 ** random.integers(-3, 3, size=(200, 300))).tolist()
    cells = [[f"{value:.{1 + column % 16}g}" for column, value in enumerate(row)] for row in values]
    for row, column in random.integers(0, (200, 300), size=(400, 2)).tolist():
        cells[row][column] = "NaN"
    return cells, np.array(cells, dtype=float)


def write_map_of_many_characters(write_file, cells, separator="\t", line_end="\n"):
    lines = ["# width 300 um", "# height 200 um", *(separator.join(row) for row in cells)]
    path = write_file(line_end.join(lines) + line_end)
    assert path.stat().st_size > 600_000
    return path


@pytest.mark.parametrize("threads", [1, 2, 3])
@pytest.mark.parametrize(("separator", "line_end"), [("\t", "\n"), (";", "\r\n"), (" ", "\n")])
def test_long_map_has_the_same_heights_for_any_number_of_threads(write_file, monkeypatch, threads, separator, line_end):
    monkeypatch.setattr(split_files, "num_usable_cores", lambda: threads)
    cells, heights = create_map_of_many_characters()
    if separator != " ":
        cells = [[cell.replace("NaN", "") for cell in row] for row in cells]
    path = write_map_of_many_characters(write_file, cells, separator, line_end)
    surface = read_surface(path, unit="um", spacing="1 um", missing="mask", accept="tall")
    np.testing.assert_array_equal(surface.missing, np.isnan(heights))
    np.testing.assert_array_equal(surface.heights[~surface.missing], heights[~np.isnan(heights)])


@pytest.mark.parametrize("threads", [1, 2])
@pytest.mark.parametrize("row", [0, 57, 199])
def test_error_message_about_a_long_map_states_line_and_cell_for_any_number_of_threads(
    write_file, monkeypatch, threads, row
):
    monkeypatch.setattr(split_files, "num_usable_cores", lambda: threads)
    cells = [list(row_cells) for row_cells in create_map_of_many_characters()[0]]
    cells[row][7] = "1.2.3"
    message = get_error_message(
        write_map_of_many_characters(write_file, cells), read_surface, unit="um", spacing="1 um"
    )
    assert f"line {row + 3} (" in message
    assert "has '1.2.3' in cell 8, which is not a number" in message


def test_row_with_too_many_cells_in_a_long_map_is_rejected(write_file):
    cells = [list(row_cells) for row_cells in create_map_of_many_characters()[0]]
    cells[150].append("5")
    message = get_error_message(
        write_map_of_many_characters(write_file, cells), read_surface, unit="um", spacing="1 um"
    )
    assert "line 153 (" in message
    assert "has 301 cells, but most lines have 300" in message


TEXTS_BY_FORMAT = {
    "comma": "x (um),z (um)\n0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n",
    "brackets, nm": "x [µm], z [nm]\n0,500\n0.1,-250\n0.2,1e3\n0.3,1.25E+2\n0.4,2000\n",
    "semicolon": "x (um);z (um)\n0;0.5\n0.1;-.25\n0.2;1.\n0.3;0.125\n0.4;2\n",
    "decimal comma": "x (mm);z (µm)\r\n0,0000;0,5\r\n0,0001;-0,25\r\n0,0002;1\r\n0,0003;0,125\r\n0,0004;2,0\r\n",
    "decimal comma and tab": "x/um\tz/um\n0,0\t0,5\n0,1\t-0,25\n0,2\t1\n0,3\t0,125\n0,4\t2,0\n",
    "bar": "x (um)|z (um)\n0|0,5\n0,1|-0,25\n0,2|1\n0,3|0,125\n0,4|2\n",
    "tab": "Lateral um\tHeight nm\n0\t500\n0.1\t-250\n0.2\t1000\n0.3\t125\n0.4\t2000\n",
    "spaces": "# x (um)   z (um)\n  0.0   0.5\n  0.1  -0.25\n  0.2   1.0\n  0.3   0.125\n  0.4   2.0",
    "units in a line of their own": "x,z\num,nm\n0,500\n0.1,-250\n0.2,1000\n0.3,125\n0.4,2000\n",
    "words": "x in micrometres,z in Nanometer\n0,500\n0.1,-250\n0.2,1000\n0.3,125\n0.4,2000\n",
    "text above": "Made 2024-05-01\nPoints,5\nRa,0.4 um,0.0 um\n\nx (um),z (um)\n"
    "0,0.5,\n0.1,-0.25,\n0.2,1,\n0.3,0.125,\n0.4,2,\n\n",
    "one column": "spacing: 0.1 um\nz (um)\n0.5\n-0.25\n1\n0.125\n2\n",
    "two columns of whole numbers": "x (Å),z (nm)\n0,500\n1000,-250\n2000,1000\n3000,125\n4000,2000\n",
    "Greek mu": "x (μm),z (μm)\n0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n",
    "ångström": "x (um),z (Å)\n0,5000\n0.1,-2500\n0.2,10000\n0.3,1250\n0.4,20000\n",
    "decreasing": "x (um),z (um)\n0.4,2\n0.3,0.125\n0.2,1\n0.1,-0.25\n0,0.5\n",
    "end of a DOS file": "x (um),z (um)\r\n0,0.5\r\n0.1,-0.25\r\n0.2,1\r\n0.3,0.125\r\n0.4,2\r\n\x1a\x1a",
    "three decimals after commas": "x (um);z (um)\n1,000;0,500\n1,100;-0,250\n1,200;1,000\n1,300;0,125\n1,400;2,000\n",
    "thousands": "x (um);z (um)\n1.000,0;0,5\n1.000,1;-0,25\n1.000,2;1\n1.000,3;0,125\n1.000,4;2,0\n",
    "quoted thousands": 'x (um),z (um)\n"1,000.0",0.5\n"1,000.1",-0.25\n"1,000.2",1\n"1,000.3",0.125\n"1,000.4",2\n',
    "quoted decimal commas": 'x (um),z (um)\n"0,0","0,5"\n"0,1","-0,25"\n"0,2",1\n"0,3","0,125"\n"0,4",2\n',
    "words below": "x (um),z (um)\n0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\nend of data\n",
    "old line ends": "x (um),z (um)\r0,0.5\r0.1,-0.25\r0.2,1\r0.3,0.125\r0.4,2\r",
}  # fmt: skip


@pytest.mark.parametrize("text", TEXTS_BY_FORMAT.values(), ids=TEXTS_BY_FORMAT.keys())
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_profile_written_in_any_text_format_is_read_with_equal_heights_and_spacing(write_file, text, encoding):
    if encoding == "latin-1":
        text = text.replace("μ", "µ")
    profile = read_profile(write_file(text, encoding=encoding))
    assert profile.heights.tolist() == HEIGHTS
    assert profile.spacing == pytest.approx(0.1, rel=1e-15)
    assert profile.history[0] == "read from scan.csv"


def test_reader_requires_unit_and_spacing_options_for_a_file_without_unit_and_spacing(write_file):
    file_without_units = write_file("0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n")
    assert 'does not contain the unit of its heights; give the unit, as in "um"' in get_error_message(
        file_without_units
    )
    assert read_profile(file_without_units, unit="um").heights.tolist() == HEIGHTS
    assert read_profile(file_without_units, unit=("mm", "um")).spacing == pytest.approx(100)
    file_without_position_unit = write_file("x,z (um)\n0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n")
    assert "the unit of its positions" in get_error_message(file_without_position_unit)
    assert read_profile(file_without_position_unit, unit="um").spacing == pytest.approx(0.1)
    single_column_file = write_file("0.5\n-0.25\n1\n0.125\n2\n")
    assert 'give the spacing of its points, as in "0.5 um"' in get_error_message(single_column_file, unit="um")
    assert read_profile(single_column_file, unit="um", spacing="100 nm").spacing == 0.1


@pytest.mark.parametrize(
    "text_above",
    [
        "Length,1500.0 um\n", "Length (um),1500\n", "Length (um): 1500\n", "Range 524nm\nx,z\n", "x (um),z (nm)\nx,z\n",
        "Radius: 2.5 µm, ID 3\n", "a text of no use\n", "um\n-----\nx,z\n", "z (um)\n",
    ],
)  # fmt: skip
def test_units_of_other_quantities_in_the_header_do_not_apply_to_columns(write_file, text_above):
    rows_text = "0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n"
    assert "does not contain the unit of its heights" in get_error_message(write_file(text_above + rows_text))
    if "z (um)" not in text_above:
        column = "\n".join(line.split(",")[1] for line in rows_text.split())
        message = get_error_message(write_file(text_above + column), spacing="1 um")
        assert "does not contain the unit of its heights" in message


def test_reader_rejects_options_that_contradict_the_file(write_file):
    path = write_file(TEXTS_BY_FORMAT["brackets, nm"])
    assert "declares its heights in nm, but the option unit is um" in get_error_message(path, unit="um")
    assert read_profile(path, unit=("um", "nm")).heights.tolist() == HEIGHTS
    assert "has positions with a spacing of 0.1 µm, but the option spacing is 0.2 um" in get_error_message(
        path, spacing="0.2 um"
    )
    assert read_profile(path, spacing="100 nm").spacing == 0.1
    column = write_file(TEXTS_BY_FORMAT["one column"])
    assert "declares a spacing of 0.1 µm, but the option spacing is 0.3 um" in get_error_message(
        column, spacing="0.3 um"
    )


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        (" \n\r\n", "only blanks"),
        ("x (um),z (um)\n", "no numbers were found"),
        ("a text\nwithout numbers\n", "no numbers were found"),
        (
            "x (um),z (um)\n0,1\n0.1,2\n",
            "contains too few points, 2; a profile must have at least 4 points, and a map two rows",
        ),
        ("x (V),z (um)\n0,1\n0.1,2\n0.2,1\n0.3,5\n", "has positions in 'V', which is not a supported unit of length"),
        ("x (um),y (um),z (um)\n" + "0,0.1,2\n" * 9, "has 3 columns of numbers that may be positions and several"),
        ("z (um)\n" + "0,0.1,2,3\n" * 9, "contains 9 rows of 4 columns, but a profile has one column"),
        (
            "x (um),z (um)\n0,1\n0.1,2\n0.2,1,7\n0.3,5\n0.4,6.5\n",
            "line 4 ('0.2,1,7') has 3 cells, but most lines have 2",
        ),
        ("x (um),z (um)\n0,1\n0.1,2\noops,1\n0.3,5\n0.4,6.5\n", "line 4 ('oops,1') is between numbers"),
        ("x (um),z (um)\n0,1\n0.1,2\n0.2,1\n0.3,5\n0.4,oops\n", "line 6 ('0.4,oops') is between numbers"),
        ("z in um\n0,5\n1\n2,5\n3,5\n", "may be two columns, or one column with decimal commas"),
        ("x (um)\tz (um)\n0,0\t0,5\n0,1\t03.05\n0,2\t1,5\n", "has '03.05', with a point, but other numbers have"),
        ("0,5\n1,5\n2,5\n3,5\n", "may be two columns, or one column with decimal commas"),
        (
            "x (um)\tz (nm)\n" + "".join(f"1,{i:03}\t{i}\n" for i in range(9)),
            "may be decimal marks or thousands separators, as in '1,008'",
        ),
        (
            "x (um),z (um)\n0,1\n0.1,2\n0.25,1\n0.3,5\n0.4,1\n",
            "is not uniform: point 2, counted from 0, is at 0.25 µm, which is 0.05 µm from where",
        ),
        ("x (um),z (um)\n0,1\n0,2.5\n0,1\n0,5\n", "first and last point at the same position"),
        (
            "x (um),z (um)\n" + "".join(f"{0.3 * i:.0f},1.5\n" for i in range(99)),
            "too few digits to compute their spacing",
        ),
        (
            "x (um),z (um)\n0,1\n0.1,***\n0.2,1\n0.3,\n0.4,1\n",
            "lacks 2 of 5 heights, the first at point 1, counted from 0",
        ),
        ("x (um),z (um)\n0,1\n,2\n0.2,1\n0.3,4\n0.4,1\n", "no usable position at point 1, counted from 0"),
        ("x (um),z (um)\n0,nan\n1,nan\n2,nan\n3,nan\n", "all points are missing"),
        ("x (um),z (um)\n0,1\n1,1e999\n2,5\n3,0.5\n", "impossible height"),
        ("x (m),z (um)\n0,1\n1e300,1\n2e300,5\n3e300,0.5\n", "no usable position"),
        ("x (m),z (um)\n0,1\n100,1\n200,5\n300,0.5\n", "has a spacing of 1e+08 µm"),
    ],
)
def test_text_files_without_a_profile_are_rejected(write_file, text, message):
    assert message in get_error_message(write_file(text))


@pytest.mark.parametrize("rows", [(0,), (1, 3)])
def test_map_rows_without_heights_are_read_as_missing_points(tmp_path, rows):
    lines = ["nan,NaN,nan,nan" if row in rows else "1,2,3.5,4" for row in range(4)]
    (tmp_path / "map.csv").write_text("\n".join(lines))
    is_missing = read_surface(tmp_path / "map.csv", unit="um", spacing="1 um", missing="mask").missing
    assert np.flatnonzero(is_missing.all(axis=1)).tolist() == list(rows)


def test_positions_are_accepted_if_only_rounding_or_truncation_makes_the_spacing_uneven(write_file):
    true_positions = 0.156245 * np.arange(9600)
    for printed_positions in (
        [f"{x:.1f}" for x in true_positions],
        [f"{np.floor(10 * x) / 10:.1f}" for x in true_positions],
        [f"{x:.6g}" for x in true_positions],
    ):
        path = write_file("x (um),z (um)\n" + "".join(f"{x},{i % 7}.5\n" for i, x in enumerate(printed_positions)))
        profile = read_profile(path)
        assert profile.spacing == (float(printed_positions[-1]) - float(printed_positions[0])) / 9599
        assert abs(profile.spacing - 0.156245) < 0.1 / 9599
    printed_positions = [f"{x:.1f}" for x in true_positions]
    printed_positions[5000] = f"{float(printed_positions[5000]) + 0.2:.1f}"
    assert "point 5000, counted from 0, is at" in get_error_message(
        write_file("x (um),z (um)\n" + "".join(f"{x},1.5\n" for x in printed_positions))
    )


def test_header_spacing_that_disagrees_with_the_positions_is_reported(write_file):
    table_text = "x (um),z (um)\n" + "".join(f"{0.1 * i:.1f},{i % 3}.5\n" for i in range(50))
    with pytest.warns(FormatWarning, match=r"declared spacing is 0.2 µm, but the spacing of its positions is 0.1 µm"):
        profile = read_profile(write_file("Spacing,0.2 um\n" + table_text))
    assert profile.spacing == pytest.approx(0.1)
    assert profile.history[1] == "spacing 0.1 µm from its positions, declared as 0.2 µm"
    assert (
        "header and positions agree" in read_profile(write_file("Resolution,0.10 um/sample\n" + table_text)).history[1]
    )
    assert "says" not in read_profile(write_file("Resolution,20 nm\n" + table_text)).history[1]


def test_missing_points_are_interpolated_inside_a_profile_and_removed_at_its_ends(write_file):
    path = write_file("x (um),z (nm)\n0,\n0.1,1000\n0.2,NaN\n0.3,***\n0.4,4000\n0.5,0\n0.6,--\n")
    profile = read_profile(path, missing="interpolate")
    assert profile.heights.tolist() == [1, 2, 3, 4, 0]
    assert profile.history[-2] == "2 missing points at its ends removed"
    assert profile.history[-1] == (
        "2 missing points interpolated, 40 % of all points; the largest gap has 2 points, at x 100 nm to 0.3 µm"
    )


def test_matrix_in_a_text_file_is_read_as_a_surface(write_file):
    path = write_file("heights in nm\n" + "1\t2\t3\t0\n4\t5\t6\t0\n", "map.txt")
    surface = read_surface(path, spacing=("2 um", "0.5 um"))
    assert surface.heights.tolist() == [[0.001, 0.002, 0.003, 0], [0.004, 0.005, 0.006, 0]]
    assert surface.spacing == (2.0, 0.5)
    assert "contains no spacing" in get_error_message(path, read_surface)
    for table in (
        "x (um),y (um),z (um)\n" + "0,1,2\n" * 5,
        "0,1,2\n" * 5,
        "x (um),a (um),b (um),c (um)\n" + "0,1,2,3\n" * 5,
    ):
        assert "may be positions and several heights" in get_error_message(
            write_file(table), read_surface, unit="um", spacing="1 um"
        )
    assert "read profiles with read_profile()" in get_error_message(write_file(TEXTS_BY_FORMAT["comma"]), read_surface)


def test_reading_a_measurement_returns_a_profile_or_a_surface(write_file):
    profile = read_measurement(write_file(TEXTS_BY_FORMAT["brackets, nm"]), spacing=("100 nm", "0.1 um"))
    assert isinstance(profile, Profile)
    assert profile.heights.tolist() == HEIGHTS
    assert "contains a profile, but the option spacing has two lengths; give one spacing" in get_error_message(
        write_file(TEXTS_BY_FORMAT["comma"]), read_measurement, spacing=("1 um", "0.1 um")
    )
    surface = read_measurement(
        write_file(create_npy_bytes(np.arange(6.0).reshape(2, 3)), "a.npy"), unit="nm", spacing=("2 um", "1 um")
    )
    assert isinstance(surface, Surface)
    assert surface.heights.tolist() == [[0, 0.001, 0.002], [0.003, 0.004, 0.005]]
    assert surface.spacing == (2.0, 1.0)


@pytest.mark.parametrize("shape", [(5, 1), (1, 5)])
def test_matrix_of_one_row_or_column_is_read_as_a_profile(write_file, shape):
    path = write_file(create_npy_bytes(np.reshape(HEIGHTS, shape)), "a.npy")
    for read in (read_profile, read_measurement):
        assert read(path, unit="um", spacing="1 um").heights.tolist() == HEIGHTS
    assert "contains a profile of 5 points" in get_error_message(path, read_surface, unit="um", spacing="1 um")


def test_matrix_with_positions_in_a_row_or_column_is_rejected(write_file):
    heights = np.random.default_rng(2).normal(size=(20, 30))
    x, y = 0.5 * np.arange(30), 0.25 * np.arange(20)
    options = {"read": read_surface, "unit": "um", "spacing": "1 um"}
    labelled_matrix = np.block([[np.zeros((1, 1)), x[np.newaxis]], [y[:, np.newaxis], heights]])
    for matrix, message in (
        (np.c_[y, heights[:, :2]], "20 rows of 3 columns, and the first column has numbers with equal steps"),
        (np.array([x, heights[0]]), "2 rows of 30 columns, and the first row has numbers with equal steps"),
        (
            labelled_matrix,
            "and the first row and column have numbers with equal steps, like positions; leave only heights in the",
        ),
    ):
        assert message in get_error_message(write_file(create_npy_bytes(matrix), "a.npy"), **options)
        text = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in matrix)
        if matrix.shape[1] > 3:
            assert message in get_error_message(write_file(text, "a.txt"), **options)
    heights_with_x_row = heights.copy()
    heights_with_x_row[0] = x
    assert "and the first row has numbers with equal steps" in get_error_message(
        write_file(create_npy_bytes(heights_with_x_row), "a.npy"), **options
    )
    heights_with_equal_row = heights.copy()
    heights_with_equal_row[0] = 0.5
    tilted_heights = heights * 1e-3 + 0.3 * x + 0.1 * y[:, np.newaxis]
    for matrix in (heights, heights_with_equal_row, tilted_heights, x + y[:, np.newaxis]):
        path = write_file(create_npy_bytes(matrix), "a.npy")
        surface = read_surface(path, unit="um", spacing="1 um", accept="repeated-height")
        assert np.array_equal(surface.heights, matrix)


def test_spacing_option_that_disagrees_with_the_header_of_a_matrix_is_rejected(write_file):
    path = write_file("Spacing: 0.5 um\nheights in nm\n1 2 3 0\n4 5 6 0\n", "map.txt")
    assert read_surface(path, spacing=("2 um", "500 nm")).spacing == (2.0, 0.5)
    assert "declares a spacing of 0.5 µm, but the option spacing is 2 µm along y and 1 µm along x" in get_error_message(
        path, read_surface, spacing=("2 um", "1 um")
    )


def test_spacing_is_computed_from_the_size_in_a_gwyddion_header(write_file):
    header = "# Channel: Height\n# Width: 0.600 µm\n# Height: 480 nm\n# Value units: m\n"
    path = write_file(header + "1e-9\t2e-9\t3e-9\t0\n" * 3 + "0\t0\t0\t1e-9\n", "map.txt")
    surface = read_surface(path)
    assert surface.spacing == pytest.approx((0.12, 0.15), rel=1e-15)
    assert surface.heights[0].tolist() == [0.001, 0.002, 0.003, 0]
    assert surface.history[1] == "its size is 0.6 µm along x and 480 nm along y (header)"
    # The position 0.600 may stand for 0.6004, but a specified spacing is not rounded.
    assert read_surface(path, spacing=("0.12 um", "0.1501 um")).spacing == (0.12, 0.1501)
    assert "a size that implies a spacing of 0.15 µm, but the option spacing is 0.16 um" in get_error_message(
        path, read_surface, spacing=("0.12 um", "0.16 um")
    )


# ---- Columns and channels -------------------------------------------------------------------------------------------

POSITIONS = [0, 0.1, 0.2, 0.3, 0.4]


def format_columns(*columns, header=""):
    return header + "".join(",".join(f"{value}" for value in row) + "\n" for row in zip(*columns, strict=True))


def test_columns_can_be_selected_by_name_or_number(write_file):
    text = format_columns([0.5, 1, 1.5, 2, 2.5], POSITIONS, [7] * 5, HEIGHTS, header="t (s),x (um),F (mN),z (um)\n")
    path = write_file(text)
    message = get_error_message(path, read_measurement)
    assert "has 4 columns of numbers that may be positions and several heights: 0 (t (s)), 1 (x (um)), 2" in message
    for columns in (("x", "z"), ("X (um)", 3), (1, 3), ["1", "3"]):
        profile = read_measurement(path, columns=columns)
        assert profile.heights.tolist() == HEIGHTS
        assert profile.spacing == pytest.approx(0.1)
        assert profile.history[1] == "columns 1 (x (um)), 3 (z (um))"
    assert read_profile(path, columns="z", spacing="2 um").history[1] == "column 3 (z (um))"
    for columns, expected_message in (
        (("x", "q"), "has no column named 'q'; the file has 0 (t (s)), 1 (x (um)), 2 (F (mN)), 3 (z (um))"),
        (("x", 4), "has no column 4; the column numbers are 0 to 3"),
        (("t", "z"), "has positions in 's', which is not a supported unit of length"),
        (("x", "F"), "has heights in 'mN', which is not a supported unit of length"),
    ):
        assert expected_message in get_error_message(path, columns=columns)
    file_with_repeated_name = write_file(format_columns(POSITIONS, HEIGHTS, HEIGHTS, header="x (um),z (um),z (nm)\n"))
    assert "has more than one column named 'z'; choose by number: 0 (x (um))," in get_error_message(
        file_with_repeated_name, columns=("x", "z")
    )
    assert read_profile(file_with_repeated_name, columns=("x", "Z (um)")).heights.tolist() == HEIGHTS
    assert "has no columns, but columns were selected" in get_error_message(
        write_file(create_x3p_bytes(HEIGHTS_IN_METRES), "a.x3p"), columns=("x", "z")
    )


def test_rounded_positions_in_any_column_are_accepted_as_uniform(write_file):
    # The uniformity of positions is judged by their own digits, not by the digits of the first column.
    true_positions = 0.156245 * np.arange(900)
    lines = "".join(f"{i}.123456,{x:.1f},{i % 7}.5\n" for i, x in enumerate(true_positions))
    profile = read_profile(write_file(lines), columns=(1, 2), unit="um")
    assert profile.spacing == pytest.approx(0.156245, rel=1e-3)
    assert "is not uniform" in get_error_message(
        write_file(lines.replace(",31.2,", ",31.5,")), columns=(1, 2), unit="um"
    )


@pytest.mark.parametrize("separator", [",", ";", "|", "\t"])
def test_index_column_written_by_pandas_is_ignored(write_file, separator):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame({"x (um)": POSITIONS, "z (um)": [*HEIGHTS[:4], np.nan]})
    for table in (frame, frame.rename_axis("index")):
        path = write_file(table.to_csv(sep=separator))
        assert "lacks 1 of 5 heights, the first at point 4, counted from 0" in get_error_message(path)
        profile = read_profile(path, missing="interpolate")
        assert profile.heights.tolist() == HEIGHTS[:4]
        assert profile.history[1] == "the first column, which numbers the rows, removed"
    heights = np.random.default_rng(3).normal(size=(6, 9))
    surface = read_surface(write_file(pandas.DataFrame(heights).to_csv(sep=separator)), unit="um", spacing="1 um")
    assert np.array_equal(surface.heights, heights)
    assert surface.history[1] == "the first row and column, which number columns and rows, removed"
    assert "has 3 columns" in get_error_message(
        write_file(format_columns(POSITIONS, POSITIONS, HEIGHTS, header="index,x (um),z (um)\n"))
    )


def test_array_of_two_columns_is_read_as_positions_and_heights(write_file):
    path = write_file(create_npy_bytes(np.c_[POSITIONS, HEIGHTS]), "a.npy")
    for read in (read_profile, read_measurement):
        profile = read(path, unit=("mm", "nm"))
        assert profile.spacing == pytest.approx(100)
        assert profile.heights.tolist() == pytest.approx([z / 1000 for z in HEIGHTS])
    assert read_profile(path, unit="um", columns=1, spacing="1 um").heights.tolist() == HEIGHTS
    uneven_file = write_file(
        create_npy_bytes(np.c_[[0, 0.1, 0.25, 0.3, 0.4], HEIGHTS]), "b.npy"
    )  # Unless columns are chosen, the array may be a map with two columns.
    assert read_measurement(uneven_file, unit="um", spacing="1 um").heights.shape == (5, 2)
    assert "is not uniform: point 2, counted from 0" in get_error_message(uneven_file, unit="um", columns=(0, 1))


def create_workbook(*sheets, **changes):
    openpyxl = pytest.importorskip("openpyxl")
    book = openpyxl.Workbook()
    book.remove(book.active)
    for name, rows in sheets:
        sheet = book.create_sheet(name)
        for row in rows:
            sheet.append(row)
    stream = io.BytesIO()
    book.save(stream)
    return stream.getvalue()


SHEET_ROWS = [["points", 5], ["made by", "a gauge"], [], [None, "x (um)", "z (um)"]]
SHEET_ROWS += [[None, x, z, None, "a note"] for x, z in zip(POSITIONS, HEIGHTS, strict=True)]


def test_profiles_and_surfaces_are_read_from_workbooks(write_file):
    profile = read_profile(write_file(create_workbook(("one", SHEET_ROWS), ("empty", [])), "a.xlsx"))
    assert profile.heights.tolist() == HEIGHTS
    assert profile.spacing == pytest.approx(0.1)
    assert profile.history[0] == "read from a.xlsx"
    two_channel_file = write_file(
        create_workbook(("raw", SHEET_ROWS), ("Filtered", [[*row[1:3], 5] for row in SHEET_ROWS])), "b.xlsx"
    )
    assert "contains the channels 0 (raw), 1 (Filtered); choose one with" in get_error_message(two_channel_file)
    assert read_profile(two_channel_file, channel="raw").history[1] == "channel 0 (raw) of 0 (raw), 1 (Filtered)"
    assert "has no channel named 'rough'; the file has 0 (raw), 1 (Filtered)" in get_error_message(
        two_channel_file, channel="rough"
    )
    heights = np.random.default_rng(3).normal(size=(6, 9))
    area = read_surface(write_file(create_workbook(("map", heights.tolist())), "c.xlsx"), unit="um", spacing="1 um")
    # The tolerance is that of 16 digits, which openpyxl writes.
    assert np.allclose(area.heights, heights, rtol=1e-15, atol=0)
    gaps = [row if index != 6 else [None, row[1], None] for index, row in enumerate(SHEET_ROWS)]
    assert "lacks 1 of 5 heights, the first at point 2, counted from 0" in get_error_message(
        write_file(create_workbook(("one", gaps)), "d.xlsx")
    )


HEIGHTS_OF_LONG_PROFILE = [*HEIGHTS, *HEIGHTS, 1.5, *HEIGHTS, 0.5]
WORD_TABLES = {
    "words": (["x (um)", "z (um)", "state"], lambda z: [z, "OK" if z > 0 else "NG"]),
    "few words": (["x (um)", "z (um)", "state"], lambda z: [z, None if z > 0 else "NG"]),
    "words as heights": (["x (um)", "z (um)"], lambda z: [z if z > 1 else "NG"]),
    "empty cells": (["x (um)", "z (um)"], lambda z: [z if z > 1 else None]),
}


@pytest.mark.parametrize("table", WORD_TABLES)
def test_words_in_a_workbook_cause_the_same_error_as_in_a_text_file(write_file, table):
    names, cells = WORD_TABLES[table]
    rows = [names, *([index / 4, *cells(z)] for index, z in enumerate(HEIGHTS_OF_LONG_PROFILE))]
    text = "".join(",".join("" if cell is None else str(cell) for cell in row) + "\n" for row in rows)
    workbook, text = write_file(create_workbook(("one", rows)), "a.xlsx"), write_file(text, "a.csv")
    messages = [re.sub(r"\('.*'\) ", "", get_error_message(path)).split(": ", 1)[1] for path in (workbook, text)]
    assert messages[0] == messages[1]
    assert ("NG" in messages[0]) == (table != "empty cells")
    profiles = [read_profile(path, missing="mask", missing_value="NG") for path in (workbook, text)]
    assert profiles[0].heights.tolist() == profiles[1].heights.tolist()
    assert profiles[0].missing.tolist() == profiles[1].missing.tolist()


def test_workbook_columns_are_numbered_as_in_the_sheet(write_file):
    names, cells = WORD_TABLES["words"]
    rows = [
        [None, None, *row]
        for row in (names, *([index / 4, *cells(z)] for index, z in enumerate(HEIGHTS_OF_LONG_PROFILE)))
    ]
    path = write_file(create_workbook(("one", rows)), "a.xlsx")
    message = get_error_message(path)
    assert "has words in column 4 (state)" in message
    assert "(--columns 2,3)" in message
    assert read_profile(path, columns=(2, 3)).heights.tolist() == HEIGHTS_OF_LONG_PROFILE


def test_damaged_and_oversized_workbooks_are_rejected(write_file, monkeypatch):
    workbook = create_workbook(("one", SHEET_ROWS))
    assert "is a workbook without a column of numbers" in get_error_message(
        write_file(create_workbook(("one", [])), "a.xlsx")
    )
    assert "is a damaged workbook" in get_error_message(write_file(workbook[:-60], "a.xlsx"))
    assert "is a damaged workbook" in get_error_message(write_file(create_x3p_bytes(HEIGHTS_IN_METRES), "a.xlsx"))
    assert "extension .xlsx, but its content is not a zip archive" in get_error_message(write_file("1,2\n", "a.xlsx"))
    monkeypatch.setattr(excel, "MAX_WORKBOOK_TAGS", 300_000)
    large_workbook = io.BytesIO()
    with (
        zipfile.ZipFile(io.BytesIO(workbook)) as source,
        zipfile.ZipFile(large_workbook, "w", zipfile.ZIP_DEFLATED) as copy,
    ):
        for name in source.namelist():
            copy.writestr(name, source.read(name).replace(b"<sheetData>", b"<sheetData>" + b"<row>" * 300_000))
    assert "XML tags" in get_error_message(write_file(large_workbook.getvalue(), "a.xlsx"))
    monkeypatch.setattr(excel, "MAX_TEXT_BYTES", 5000)
    assert "at most" in get_error_message(write_file(workbook, "a.xlsx"))
    monkeypatch.setitem(__import__("sys").modules, "openpyxl", None)
    assert "pip install openpyxl" in get_error_message(write_file(workbook, "a.xlsx"))


def test_channel_option_is_rejected_for_files_in_formats_without_channels(write_file):
    assert "has no channels, but channel 1 was selected" in get_error_message(
        write_file(TEXTS_BY_FORMAT["comma"]), channel=1
    )


def test_channel_of_an_instrument_file_can_be_selected(find_measured_file):
    pytest.importorskip("SurfaceTopography")
    path = find_measured_file("di-4.di")
    surface = read_surface(path)
    channels = "0 (ZSensor), 1 (AmplitudeError), 2 (Phase)"
    assert surface.history[1] == f"channel 0 (ZSensor) of {channels}"
    assert np.array_equal(read_surface(path, channel="zsensor").heights, surface.heights)
    assert read_surface(path, channel=1).history[1] == f"channel 1 (AmplitudeError) of {channels}"
    assert "a channel 2 (Phase) that does not contain heights" in get_error_message(path, read_surface, channel="Phase")
    assert "has no channel 3; the channel numbers are 0 to 2" in get_error_message(path, read_surface, channel=3)


def test_units_of_a_text_file_with_an_unknown_file_name_extension_are_read_from_the_header(write_file):
    text = "x (um),z (nm)\n0,500\n0.1,-250\n0.2,1000\n0.3,125\n0.4,2000\n"
    file_with_unknown_suffix = write_file(text, "scan.v2")
    assert read_profile(file_with_unknown_suffix).heights.tolist() == HEIGHTS
    assert "declares its heights in nm, but the option unit is um" in get_error_message(
        file_with_unknown_suffix, unit="um"
    )


def test_custom_reader_is_used_for_files_with_the_registered_suffix(write_file, monkeypatch):
    monkeypatch.setitem(READERS, ".dec", lambda data: RawHeights(np.array(data.split(), dtype=float), unit="um"))
    assert read_measurement(write_file("0.5 -0.25 1 0.125 2", "a.DEC"), spacing="1 um").heights.tolist() == HEIGHTS


# ---- NumPy arrays and writing ---------------------------------------------------------------------------------------


def test_profile_is_unchanged_by_writing_and_reading(tmp_path):
    profile = weierstrass_mandelbrot(random_phases(3), 1.4, points=5000, extent=7.0).with_amplitude(0.1)
    write_profile(profile, tmp_path / "a.csv")
    write_profile(profile, tmp_path / "a.npy")
    for name in ("a.csv", "a.npy"):
        for options in ({}, {"unit": "um", "spacing": f"{profile.spacing!r} um"}):
            profile_read = read_profile(tmp_path / name, **options)
            assert np.array_equal(profile_read.heights, profile.heights)
            assert profile_read.spacing == profile.spacing
            assert profile_read.history[: 1 + len(profile.history)] == (f"read from {name}", *profile.history)
    assert np.array_equal(np.load(tmp_path / "a.npy"), profile.heights)
    assert "# history: scaled to height 0.1 µm\n" in (tmp_path / "a.csv").read_text(encoding="utf-8")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "a.npy"]


@pytest.mark.parametrize("name", ["a.npy", "a.csv"])
def test_surface_is_unchanged_by_writing_and_reading(tmp_path, name):
    heights = np.random.default_rng(1).normal(size=(30, 40)) * 10.0 ** np.arange(-39, 1)
    surface = Surface(heights, spacing=(1 / 3, 1e-3), history=("ground", "levelled by a plane"))
    write_surface(surface, tmp_path / name)
    for options in ({}, {"unit": "um", "spacing": ("0.3333333 um", "1 nm")}):
        surface_read = read_surface(tmp_path / name, **options)
        assert np.array_equal(surface_read.heights, surface.heights)
        assert surface_read.spacing == surface.spacing
        assert surface_read.history == (f"read from {name}", "ground", "levelled by a plane")
    with pytest.raises(FormatError, match="but the option spacing is"):
        read_surface(tmp_path / name, spacing="2 um")
    # The heights of a plane increase in equal steps, but must not be taken for positions.
    plane = Surface(0.1 * np.arange(20.0).reshape(4, 5), spacing=1.0)
    write_surface(plane, tmp_path / f"plane-{name}")
    assert np.array_equal(read_surface(tmp_path / f"plane-{name}").heights, plane.heights)
    assert isinstance(read_measurement(tmp_path / name), Surface)


def test_map_three_points_wide_is_written_only_to_formats_that_can_store_it(tmp_path):
    with pytest.raises(FormatError, match="must have at least 4 columns, but the surface has 3"):
        write_surface(Surface(np.eye(3), spacing=1.0), tmp_path / "a.csv")
    assert not list(tmp_path.iterdir())
    write_surface(Surface(np.eye(3), spacing=1.0), tmp_path / "a.npy")
    assert read_surface(tmp_path / "a.npy").heights.tolist() == np.eye(3).tolist()


def test_metadata_after_the_array_of_an_npy_file_are_read_only_if_written_by_stiction(write_file):
    spacing = np.array((0.5, 0.25), dtype=[("spacing_y_um", float), ("spacing_x_um", float)])
    own_content = (
        create_npy_bytes(np.eye(4)) + create_npy_bytes(spacing) + create_npy_bytes(np.array(["made up\x1b[31m"]))
    )
    assert read_surface(write_file(own_content, "a.npy")).history == ("read from a.npy", "made up\\x1b[31m")
    for foreign_content in (
        create_npy_bytes(np.eye(4)) + create_npy_bytes(spacing),
        create_npy_bytes(np.eye(4)) + create_npy_bytes(np.eye(2)) + create_npy_bytes(np.array(["no"])),
        create_npy_bytes(np.eye(4)) + create_npy_bytes(spacing) + create_npy_bytes(np.arange(3)),
        create_npy_bytes(np.eye(4)) + b"anything",
        create_npy_bytes(np.arange(9.0)) + create_npy_bytes(spacing) + create_npy_bytes(np.array(["of another shape"])),
        own_content[:-3],
    ):
        with pytest.raises(FormatError, match="neither the unit of its heights"):
            read_measurement(write_file(foreign_content, "b.npy"))
    negative_spacing = create_npy_bytes(np.array((-0.5, 0.25), dtype=spacing.dtype))
    with pytest.raises(FormatError, match="has a spacing of -0"):
        read_surface(
            write_file(create_npy_bytes(np.eye(4)) + negative_spacing + create_npy_bytes(np.array([""])), "c.npy")
        )


def test_writing_a_scan_does_not_overwrite_files_or_leave_partial_files(tmp_path, monkeypatch):
    profile = Profile(HEIGHTS, spacing=0.1)
    (tmp_path / "a.csv").write_text("mine", encoding="utf-8")
    for path, message in (
        (tmp_path / "a.csv", "already exists; remove it, or choose another name"),
        (tmp_path / "a.xls", "must end in .csv or .npy"),
        (tmp_path / "nowhere" / "a.csv", "cannot be written: No such file"),
    ):
        with pytest.raises(FormatError, match=message):
            write_profile(profile, path)
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "mine"
    with pytest.raises(ValueError, match="profile must be a Profile, got list"):
        write_profile([1.0], tmp_path / "b.csv")
    monkeypatch.setattr(np, "save", lambda file, _: (file.write(b"half"), file.flush(), os.close(-1)))
    with pytest.raises(FormatError, match="cannot be written"):
        write_surface(Surface(np.eye(3), spacing=1.0), tmp_path / "b.npy")
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def create_npy_bytes(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "name", "message"),
    [
        (create_npy_bytes(np.zeros(9)), "a.npy", "neither the unit of its heights"),
        (
            create_npy_bytes(np.array([1, None])),
            "a.npy",
            "damaged .npy file, or contains Python objects instead of numbers",
        ),
        (create_npy_bytes(np.ones((1, 9))).replace(b"(1, 9), }   ", b"(True, 9), }"), "a.npy", "damaged .npy file"),
        (create_npy_bytes(np.zeros(9))[:-5], "a.npy", "damaged"),
        (create_npy_bytes(np.zeros(9, complex)), "a.npy", "array of type complex128"),
        (create_npy_bytes(np.zeros((2, 2, 2))), "a.npy", "shape (2, 2, 2)"),
        (create_npy_bytes(np.zeros((5, 5))), "a.npy", "5 rows of 5 columns"),
        (
            create_npy_bytes(np.zeros(9)),
            "a.csv",
            "has the file name extension .csv, but its content is a NumPy array (.npy)",
        ),
        (b"0,1\n", "a.npy", "has the file name extension .npy, but its content is not a NumPy array (.npy)"),
        (b"0,1\n", "a.x3p", "has the file name extension .x3p, but its content is not a zip archive"),
        (bytes(range(256)) * 9, "a.csv", "is binary, not text"),
        (b"\x93NUMPY\x01\x00" + b"\xff" * 300, "a.npy", "damaged"),
        (b"\x93NUMPY\x01\x00" + (9002).to_bytes(2, "little") + b"(" * 9000 + b" \n", "a.npy", "damaged"),
        (create_npy_bytes(np.zeros(9)).replace(b"(9,)", b"(-9,)").replace(b" \n", b"\n"), "a.npy", "damaged"),
        (b"PK\x03\x04" + b"\xff" * 300, "a.x3p", "damaged X3P"),
        (b"no such format", "a.abc", "a known format"),
    ],
)
def test_scan_files_with_content_that_is_not_a_scan_are_rejected(write_file, content, name, message):
    assert message in get_error_message(write_file(content, name))


def test_directories_pipes_and_missing_files_are_not_accepted_as_scans(tmp_path):
    assert "No such file" in get_error_message(tmp_path / "none.csv")
    assert "is a directory" in get_error_message(tmp_path)
    os.mkfifo(tmp_path / "pipe.csv")  # a program that reads this pipe would block
    assert "is not a file" in get_error_message(tmp_path / "pipe.csv")


def test_oversized_files_are_rejected_before_reading(tmp_path, monkeypatch):
    for name, size in (("a.csv", raw.MAX_TEXT_BYTES + 1), ("a.npy", raw.MAX_FILE_BYTES + 1)):
        with (tmp_path / name).open("wb") as file:
            file.truncate(size)  # The file has a hole, so it occupies no disk space.
        assert f"has {size} bytes" in get_error_message(tmp_path / name)
    monkeypatch.setattr(npy_files, "MAX_POINTS", 8)
    (tmp_path / "b.npy").write_bytes(create_npy_bytes(np.zeros(9)))
    assert "contains 9 points; at most 8" in get_error_message(tmp_path / "b.npy")


def test_reading_of_a_large_map_does_not_copy_its_text(write_file):
    heights = np.random.default_rng(0).normal(size=(512, 512)).cumsum(axis=1)
    stream = io.StringIO()
    np.savetxt(stream, heights, fmt="%.6f", delimiter="\t")
    path = write_file(stream.getvalue())
    surface = read_surface(path, unit="um", spacing="1 um")
    np.testing.assert_allclose(surface.heights, heights, rtol=0, atol=5.1e-7)
    # The text, the heights and temporary arrays take 2.3 times the size of the file, and 3.1 times with two copies.
    assert measure_peak_memory(lambda: read_surface(path, unit="um", spacing="1 um")) < 2.7 * path.stat().st_size


def test_missing_points_are_found_in_all_pieces_of_a_long_text(write_file):
    heights = np.random.default_rng(0).normal(size=60_000)
    is_missing = np.zeros(heights.size, dtype=bool)
    is_missing[[3, 30_000, -2]] = True
    words = iter(["bad", "--", "NaN"])
    lines = [next(words) if gap else f"{height:.6f}" for height, gap in zip(heights, is_missing, strict=True)]
    path = write_file("z (um)\n" + "\n".join(lines))
    profile = read_profile(path, spacing="1 um", missing="mask")
    assert path.stat().st_size > 2 * text_files.CHARACTERS_CLASSIFIED_PER_STEP
    assert np.array_equal(profile.missing, is_missing)
    np.testing.assert_allclose(profile.heights[~is_missing], heights[~is_missing], rtol=0, atol=5.1e-7)


@pytest.mark.parametrize("separator", [",", ", ", ";", "|", "\t", " "])
def test_text_file_with_more_lines_or_cells_than_the_limit_is_rejected(write_file, monkeypatch, separator):
    monkeypatch.setattr(text_files, "MAX_LINES", 20)
    monkeypatch.setattr(split_files, "MAX_CELLS_PER_LINE", 10)
    wide_row = separator.join(["1.5"] * 5) + "\n"
    assert read_surface(write_file(20 * wide_row), unit="um", spacing="1 um").heights.shape == (20, 5)
    assert "has 21 lines; at most 20" in get_error_message(write_file("1.5\n" * 21))
    assert "cells; at most 10 can be read" in get_error_message(write_file(separator.join(["1.5"] * 11)))


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"unit": "furlong"}, "unit must be a unit of length"),
        ({"unit": ("um",)}, "unit must be"),
        ({"unit": 3}, "unit must be"),
        ({"spacing": 0.1}, "spacing must be a length with its unit"),
        ({"spacing": "0.1 MPa"}, "spacing has the unit 'MPa'"),
        ({"spacing": "0 um"}, "spacing must be above 0"),
        ({"missing": "zero"}, "missing must be one of 'error', 'interpolate', 'mask'"),
        ({"channel": 1.5}, "channel must be a name or a number counted from 0, got 1.5"),
        ({"columns": (1, True)}, "columns must be a name or a number"),
        ({"columns": (0, 1, 2, 3)}, r"columns must be one column \(heights\), two \(positions and heights\)"),
    ],
)
def test_readers_reject_invalid_arguments(write_file, options, message):
    for read in (read_profile, read_measurement, *([] if "columns" in options else [read_surface])):
        with pytest.raises(ValueError, match=message) as error_info:
            read(write_file(TEXTS_BY_FORMAT["comma"]), **options)
        assert not isinstance(error_info.value, FormatError)


def test_missing_instrument_package_is_reported_with_its_install_command(write_file, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "SurfaceTopography", None)
    assert "pip install SurfaceTopography" in get_error_message(write_file(b"?File list", "a.di"), read_surface)


# ---- X3P ------------------------------------------------------------------------------------------------------------


def create_x3p_bytes(
    heights,
    *,
    spacing=(2e-6, 1e-6),
    data_type="D",
    increment=1.0,
    is_valid=None,
    positions=None,
    as_list=False,
    replacements=(),
):
    """Return the bytes of an X3P file as the standard defines it. Heights are in metres."""
    heights = np.atleast_2d(heights)
    rows, columns = heights.shape
    form = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}[data_type]
    values = np.round(heights / increment).astype(form) if data_type in "IL" else heights.astype(form)
    if positions is not None:
        table = np.empty(values.size, dtype=[("x", "<f8"), ("z", form)])
        table["x"], table["z"] = positions, values.ravel()
        values = table
    height_bytes = values.tobytes()
    x_axis = "<AxisType>I</AxisType>" if positions is None else "<AxisType>A</AxisType>"
    link = "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>" if is_valid is not None else ""
    points = (
        f"<DataLink><PointDataLink>bindata/data.bin</PointDataLink>"
        f"<MD5ChecksumPointData>{hashlib.md5(height_bytes).hexdigest().upper()}</MD5ChecksumPointData>{link}</DataLink>"
    )
    if as_list:
        points = "".join(f"<Datum>{'' if np.isnan(z) else repr(float(z))}</Datum>" for z in heights.ravel())
        points = f"<DataList>{points}</DataList>"
    main_text = (
        '<?xml version="1.0" encoding="UTF-8"?><p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1>'
        f"<Revision>ISO5436 - 2000</Revision><FeatureType>{'PRF' if rows == 1 else 'SUR'}</FeatureType><Axes>"
        f"<CX>{x_axis}<DataType>D</DataType><Increment>{spacing[1] if positions is None else 1.0!r}</Increment></CX>"
        f"<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>{spacing[0]!r}</Increment></CY>"
        f"<CZ><AxisType>A</AxisType><DataType>{data_type}</DataType><Increment>{increment!r}</Increment></CZ></Axes>"
        f"</Record1><Record3><MatrixDimension><SizeX>{columns}</SizeX><SizeY>{rows}</SizeY><SizeZ>1</SizeZ>"
        f"</MatrixDimension>{points}</Record3></p:ISO5436_2>"
    )
    for old_text, new_text in replacements:
        assert old_text in main_text
        main_text = main_text.replace(old_text, new_text)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", main_text)
        archive.writestr("bindata/data.bin", height_bytes)
        if is_valid is not None:
            archive.writestr("bindata/valid.bin", np.packbits(is_valid, bitorder="little").tobytes())
    return stream.getvalue()


HEIGHTS_IN_METRES = 1e-6 * np.random.default_rng(5).normal(size=(6, 9))


@pytest.mark.parametrize(("data_type", "max_error"), [("D", 1e-15), ("F", 1e-6), ("L", 1e-6), ("I", 1e-3)])
def test_x3p_surfaces_and_profiles_are_read(write_file, data_type, max_error):
    options = {"data_type": data_type, "increment": {"L": 1e-12, "I": 1e-9}.get(data_type, 1.0)}
    surface = read_surface(write_file(create_x3p_bytes(HEIGHTS_IN_METRES, **options), "a.x3p"))
    assert np.abs(surface.heights - 1e6 * HEIGHTS_IN_METRES).max() <= max_error
    assert surface.spacing == pytest.approx((2.0, 1.0))
    profile = read_profile(
        write_file(create_x3p_bytes(HEIGHTS_IN_METRES[0], **options), "b.x3p"), unit="m", spacing="1 um"
    )
    assert np.abs(profile.heights - 1e6 * HEIGHTS_IN_METRES[0]).max() <= max_error
    x = 3e-6 + 5e-7 * np.arange(9)
    profile_with_positions = read_profile(
        write_file(create_x3p_bytes(HEIGHTS_IN_METRES[0], positions=x, **options), "c.x3p")
    )
    assert np.array_equal(profile_with_positions.heights, profile.heights)
    assert profile_with_positions.spacing == pytest.approx(0.5)


def test_integers_in_an_x3p_file_are_multiplied_by_their_increment(write_file):
    integers_without_increment = create_x3p_bytes(
        HEIGHTS_IN_METRES, data_type="I", increment=1e-9, replacements=[("<Increment>1e-09</Increment>", "")]
    )
    assert "stores Z as integers, but has no Increment" in get_error_message(
        write_file(integers_without_increment, "a.x3p"), read_surface
    )
    default_namespace = [("<p:ISO5436_2 xmlns:p=", "<ISO5436_2 xmlns="), ("</p:ISO", "</ISO")]
    for increment in ("", "<Increment>0.0</Increment>"):
        path = write_file(
            create_x3p_bytes(
                HEIGHTS_IN_METRES, replacements=[("<Increment>1.0</Increment>", increment), *default_namespace]
            ),
            "a.x3p",
        )
        assert np.abs(read_surface(path).heights - 1e6 * HEIGHTS_IN_METRES).max() < 1e-15


@pytest.mark.parametrize("increment", [-1e-9, 1e-320, 1e300])
def test_x3p_file_with_an_impossible_height_factor_is_rejected(write_file, increment):
    new_xml = f"<DataType>L</DataType><Increment>{increment!r}</Increment>"
    replacements = [("<DataType>D</DataType><Increment>1.0</Increment>", new_xml)]
    path = write_file(create_x3p_bytes(HEIGHTS_IN_METRES, replacements=replacements), "a.x3p")
    assert "for Record1/Axes/CZ/Increment; it must be a number from" in get_error_message(path, read_surface)


def test_file_that_is_too_small_for_its_declared_number_of_points_is_rejected(tmp_path, write_file):
    zeros = create_x3p_bytes(np.zeros((1100, 1000)), data_type="I", increment=1e-9)
    path = write_file(zeros, "a.x3p")
    assert "declares 1100000 points, but has only" in get_error_message(path, read_surface)
    heights = 1e-6 * np.random.default_rng(3).normal(size=(1100, 1000))
    heights[np.random.default_rng(4).random(heights.shape) < 0.3] = np.nan
    surface = read_surface(write_file(create_x3p_bytes(heights), "b.x3p"), missing="mask")
    assert np.array_equal(surface.missing, np.isnan(heights))


def test_x3p_profile_that_is_not_along_x_is_rejected(write_file):
    y_axis = "<CY><AxisType>A</AxisType><DataType>D</DataType></CY>"
    old_axis_xml = "<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>2e-06</Increment></CY>"
    points_xml = "".join(
        f"<Datum>{1e-6 * i!r};{y!r};{z!r}</Datum>" for i, (y, z) in enumerate((1e-6 * np.eye(9)[:, :2]).tolist())
    )
    file_bytes = create_x3p_bytes(
        HEIGHTS_IN_METRES[0], as_list=True, positions=np.arange(9.0), replacements=[(old_axis_xml, y_axis)]
    )
    with zipfile.ZipFile(io.BytesIO(file_bytes)) as archive:
        main = archive.read("main.xml").decode()
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("main.xml", main[: main.index("<Datum>")] + points_xml + main[main.index("</DataList>") :])
    assert "y coordinate varies" in get_error_message(write_file(stream.getvalue(), "a.x3p"))


def test_heights_read_from_an_x3p_file_agree_with_the_surfacetopography_library(write_file):
    topography = pytest.importorskip("SurfaceTopography")
    path = write_file(create_x3p_bytes(HEIGHTS_IN_METRES), "a.x3p")
    with topography.open_topography(str(path)) as reader:
        topography_read = reader.topography()
    surface = read_surface(path)
    factor = {"m": 1e6, "µm": 1.0}[topography_read.unit]
    assert np.abs(surface.heights - factor * topography_read.heights().T).max() < 1e-12
    assert surface.spacing == pytest.approx(tuple(factor * item for item in reversed(topography_read.pixel_size)))


def test_missing_points_in_an_x3p_file_are_reported_and_can_be_interpolated(write_file):
    is_valid = np.ones(HEIGHTS_IN_METRES.shape, dtype=bool)
    is_valid[2, 4] = False
    path = write_file(create_x3p_bytes(HEIGHTS_IN_METRES, is_valid=is_valid.ravel()), "a.x3p")
    assert "lacks 1 of 54 heights, the first at row 2, column 4, counted from 0" in get_error_message(
        path, read_surface
    )
    surface = read_surface(path, missing="interpolate")
    assert surface.heights[2, 4] == pytest.approx(1e6 * (HEIGHTS_IN_METRES[2, 3] + HEIGHTS_IN_METRES[2, 5]) / 2)
    assert surface.history[-1].startswith(
        "1 missing points interpolated, 1.9 % of all points; the largest gap has 1 point, at x "
    )
    gaps = np.where(np.arange(9) == 4, np.nan, HEIGHTS_IN_METRES[0])
    for file_bytes in (create_x3p_bytes(gaps), create_x3p_bytes(gaps, as_list=True)):
        profile = read_profile(write_file(file_bytes, "b.x3p"), missing="interpolate")
        assert profile.heights[4] == pytest.approx(1e6 * (HEIGHTS_IN_METRES[0, 3] + HEIGHTS_IN_METRES[0, 5]) / 2)
    corner = np.where(np.arange(54).reshape(6, 9) == 0, np.nan, HEIGHTS_IN_METRES)
    assert "1 missing points at its edges" in get_error_message(
        write_file(create_x3p_bytes(corner), "c.x3p"), read_surface, missing="interpolate"
    )


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("<FeatureType>SUR", "<FeatureType>PCL"), "feature type 'PCL'"),
        (("<SizeX>9", "<SizeX>10"), "declares 60 points of 8 bytes, but has 432 bytes"),
        (("<SizeX>9", "<SizeX>-9"), "where the count of points is expected"),
        (("<SizeX>9", "<SizeX>99999999"), "between 1 and 100000000 can be read"),
        (("<SizeZ>1", "<SizeZ>2"), "contains 2 layers"),
        (("<Increment>2e-06", "<Increment>two"), "has 'two' instead of a number"),
        (("<Increment>2e-06", "<Increment>nan"), "has a spacing of nan"),
        (("<DataType>D", "<DataType>Q"), "data type 'Q'"),
        (("bindata/data.bin", "../../data.bin"), "lacks the archive member '../../data.bin'"),
        (("MD5ChecksumPointData>", "X>"), None),
        (("<MD5ChecksumPointData>", "<MD5ChecksumPointData>0"), "do not match its checksum"),
        (("<Record1>", "<Record9>"), "damaged X3P file (ExpatError"),
        (("<p:ISO", '<!DOCTYPE a [<!ENTITY b "c">]><p:ISO'), "document type declaration in main"),
    ],
)
def test_x3p_file_with_contradictory_metadata_is_rejected(write_file, change, message):
    path = write_file(create_x3p_bytes(HEIGHTS_IN_METRES, replacements=[change]), "a.x3p")
    if message is None:
        read_surface(path)
    else:
        assert message in get_error_message(path, read_surface)


# ---- Measured files and damaged ones --------------------------------------------------------------------------------


def test_measured_stylus_profile_is_read_with_its_header(find_measured_file):
    path = find_measured_file("dektak-1.csv")
    profile = read_profile(path)
    assert len(profile) == 9600
    assert profile.spacing == pytest.approx(1499.8 / 9599, rel=1e-12)
    assert profile.history[1] == "its header gives a tip radius of 2.5 µm (--tip)"
    assert profile.history[2] == "spacing 0.1562454 µm from its positions, declared as 0.156 µm"
    assert np.std(levelled(profile, "line").heights) == pytest.approx(0.0942, abs=5e-5)
    assert read_profile(path, spacing="0.15625 um").extent == 1500.0
    assert "0.1562454 µm, but the option spacing is 0.156 um" in get_error_message(path, spacing="0.156 um")


def test_measured_map_of_an_atomic_force_microscope_is_read(find_measured_file):
    pytest.importorskip("SurfaceTopography")
    surface = read_surface(find_measured_file("di-4.di"))
    assert surface.heights.shape == (512, 512)
    assert surface.extent == pytest.approx((10.0, 10.0))
    levelled_surface = levelled(surface, "plane")
    assert np.std(levelled_surface.heights) == pytest.approx(0.0794, abs=5e-5)
    row_variances = [np.var(levelled(levelled_surface.row(index), "line").heights) for index in range(512)]
    assert np.sqrt(np.mean(row_variances)) == pytest.approx(0.0388, abs=5e-5)


@pytest.mark.parametrize("count", [300, pytest.param(1500, marks=pytest.mark.soak)])
def test_randomly_damaged_files_are_either_read_or_rejected_with_a_one_line_error(tmp_path, count):
    content_by_name = {
        "a.csv": "".join([TEXTS_BY_FORMAT["text above"], *(f"{i / 10},{i % 7}.5,\n" for i in range(5, 40))]).encode(),
        "b.txt": TEXTS_BY_FORMAT["decimal comma and tab"].encode(),
        "c.npy": create_npy_bytes(np.arange(20.0)),
        "d.x3p": create_x3p_bytes(HEIGHTS_IN_METRES[0]),
        "e.x3p": create_x3p_bytes(HEIGHTS_IN_METRES[0], as_list=True),
        "f.x3p": create_x3p_bytes(HEIGHTS_IN_METRES[0], positions=1e-6 * np.arange(9)),
        "g.xlsx": create_workbook(("one", SHEET_ROWS)),
    }  # fmt: skip
    outcomes = Counter()
    for index in range(count):
        random = np.random.default_rng([4, index])
        name = str(random.choice(list(content_by_name)))
        outcomes[fuzzing.fuzz_measurement_file(random, name, content_by_name[name], tmp_path)] += 1
    assert outcomes["read"] > count / 15
    assert outcomes["refused"] > count / 3


# ---- Archives from unknown sources ----------------------------------------------------------------------------------


def create_x3p_archive(main, height_bytes=bytes(432), method=zipfile.ZIP_DEFLATED):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", method) as archive:
        archive.writestr("main.xml", main)
        archive.writestr("bindata/data.bin", height_bytes)
    return stream.getvalue()


def read_main_xml(x3p_content):
    with zipfile.ZipFile(io.BytesIO(x3p_content)) as archive:
        return archive.read("main.xml").decode()


X3P_WITHOUT_CHECKSUM = read_main_xml(create_x3p_bytes(HEIGHTS_IN_METRES)).replace("MD5ChecksumPointData>", "Sum>")


def measure_peak_memory(call):
    tracemalloc.start()
    try:
        call()
        return tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("code", ["utf-8", "utf-16", "utf-16-be"])
@pytest.mark.parametrize(
    "kind", ['<!DOCTYPE a [<!ENTITY b "SUR">]>', '<!DOCTYPE a SYSTEM "file:///etc/passwd">', "<!DOCTYPE a>"]
)
def test_x3p_file_in_any_encoding_is_rejected_because_of_a_document_type_declaration(write_file, code, kind):
    main = X3P_WITHOUT_CHECKSUM.replace("UTF-8", code[:6]).replace("<p:ISO", kind + "<p:ISO").replace(">SUR<", ">&b;<")
    assert "document type declaration in main" in get_error_message(
        write_file(create_x3p_archive(main.encode(code)), "a.x3p"), read_surface
    )


def test_x3p_archive_larger_than_required_by_its_number_of_points_is_not_unpacked(write_file):
    # Two archives unpack to 50 MB instead of 432 bytes. One declares its true size, the other a false size.
    well_declared_archive = create_x3p_archive(X3P_WITHOUT_CHECKSUM, bytes(50_000_000))
    misdeclared_archive = well_declared_archive.replace((50_000_000).to_bytes(4, "little"), (432).to_bytes(4, "little"))
    assert misdeclared_archive != well_declared_archive
    for archive, expected_message in (
        (well_declared_archive, "54 points of 8 bytes, but has 50000000 bytes"),
        (misdeclared_archive, "damaged X3P file (BadZip"),
    ):
        path = write_file(archive, "a.x3p")
        assert (
            measure_peak_memory(
                lambda path=path, expected_message=expected_message: (
                    expected_message in get_error_message(path, read_surface)
                )
            )
            < 5_000_000
        )
        assert expected_message in get_error_message(path, read_surface)
    assert "compression method is not deflate" in get_error_message(
        write_file(create_x3p_archive(X3P_WITHOUT_CHECKSUM, method=zipfile.ZIP_BZIP2), "a.x3p"), read_surface
    )


@pytest.mark.parametrize("number", ["1_0e-6", "١e-6", "0x1p-3", "1e", "1,5", "infinity", "--1", "1e-6e"])
def test_numbers_in_an_x3p_file_must_conform_to_xml_schema(write_file, number):
    main_text = X3P_WITHOUT_CHECKSUM.replace("<Increment>1e-06<", f"<Increment>{number}<")
    assert main_text != X3P_WITHOUT_CHECKSUM
    assert "instead of a number" in get_error_message(write_file(create_x3p_archive(main_text), "a.x3p"), read_surface)
    for valid_number in (" 1E-6 ", "+.000001", "1.e-06"):
        main_text = X3P_WITHOUT_CHECKSUM.replace("<Increment>1e-06<", f"<Increment>{valid_number}<")
        assert read_surface(write_file(create_x3p_archive(main_text), "a.x3p")).spacing[1] == pytest.approx(1.0)


def test_text_file_with_very_long_lines_is_read_quickly(write_file):
    path = write_file("\n".join([",".join(["1.5", "2", "0"] * 10_000)] * 4), "a.csv")
    start_time = time.process_time()
    assert read_surface(path, unit="um", spacing="1 um").heights.shape == (4, 30_000)
    assert time.process_time() - start_time < 4  # This took 0.4 s in a trial.


def test_size_of_x3p_metadata_is_limited(write_file):
    text_with_few_tags, text_with_many_tags, text_with_long_element = (
        X3P_WITHOUT_CHECKSUM.replace("</p:ISO", f"{words}</p:ISO") for words in (
        "<x/>" * 1000, "<x/>" * 150_000, f"<x>{' ' * 5_000_000}</x>"
    ))  # fmt: skip
    assert read_surface(write_file(create_x3p_archive(text_with_few_tags), "a.x3p")).heights.shape == (6, 9)
    assert "more than 100000 elements in main.xml" in get_error_message(
        write_file(create_x3p_archive(text_with_many_tags), "a.x3p"), read_surface
    )
    assert "too many for its points" in get_error_message(
        write_file(create_x3p_archive(text_with_long_element), "a.x3p"), read_surface
    )
    # Listed points may need more memory than a matrix. Their memory is limited by the number of points.
    text_with_list = read_main_xml(create_x3p_bytes(np.zeros(40_000), as_list=True)).replace(
        "<Datum>0.0<", f"<Datum>{'0' * 100}<"
    )
    assert len(text_with_list) > 4_000_000
    assert len(read_profile(write_file(create_x3p_archive(text_with_list), "b.x3p"))) == 40_000
    text_with_wrong_size = text_with_list.replace("40000</SizeX>", "4</SizeX>")
    assert "too many for its points" in get_error_message(write_file(create_x3p_archive(text_with_wrong_size), "b.x3p"))
