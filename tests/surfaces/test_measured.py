import hashlib
import io
import os
import zipfile
from collections import Counter

import fuzzing
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
from stiction.surfaces.measured import npy as npy_files
from stiction.surfaces.measured import raw

HEIGHTS = [0.5, -0.25, 1.0, 0.125, 2.0]


@pytest.fixture
def file(tmp_path):
    """file(content, name): a path with that content."""

    def write(content, name="scan.csv", encoding="utf-8"):
        path = tmp_path / name
        path.write_bytes(content if isinstance(content, bytes) else content.encode(encoding))
        return path

    return write


def refusal(path, read=read_profile, **options):
    """What a file is refused with: one sentence that begins with its name."""
    with pytest.raises(FormatError) as caught:
        read(path, **options)
    said = str(caught.value)
    assert said.startswith(f"{path}: ")
    assert "\n" not in said
    return said


# ---- Text -----------------------------------------------------------------------------------------------------------

TEXTS = {
    "comma": "x (um),z (um)\n0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n",
    "brackets, nm": "x [µm], z [nm]\n0,500\n0.1,-250\n0.2,1e3\n0.3,1.25E+2\n0.4,2000\n",
    "semicolon": "x (um);z (um)\n0;0.5\n0.1;-.25\n0.2;1.\n0.3;0.125\n0.4;2\n",
    "decimal comma": "x (mm);z (µm)\r\n0,0000;0,5\r\n0,0001;-0,25\r\n0,0002;1\r\n0,0003;0,125\r\n0,0004;2,0\r\n",
    "decimal comma and tab": "x/um\tz/um\n0,0\t0,5\n0,1\t-0,25\n0,2\t1\n0,3\t0,125\n0,4\t2,0\n",
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
    "old line ends": "x (um),z (um)\r0,0.5\r0.1,-0.25\r0.2,1\r0.3,0.125\r0.4,2\r",
}  # fmt: skip


@pytest.mark.parametrize("text", TEXTS.values(), ids=TEXTS.keys())
@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16", "latin-1"])
def test_texts_of_many_kinds_are_the_same_profile(file, text, encoding):
    if encoding == "latin-1":
        text = text.replace("μ", "µ")
    profile = read_profile(file(text, encoding=encoding))
    assert profile.heights.tolist() == HEIGHTS
    assert profile.spacing == pytest.approx(0.1, rel=1e-15)
    assert profile.history[0] == "read from scan.csv"


def test_what_the_file_does_not_say_must_be_given(file):
    bare = file("0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n")
    assert 'does not say in which unit its heights are; give the unit, as in "um"' in refusal(bare)
    assert read_profile(bare, unit="um").heights.tolist() == HEIGHTS
    assert read_profile(bare, unit=("mm", "um")).spacing == pytest.approx(100)
    half = file("x,z (um)\n0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n")
    assert "in which unit its positions are" in refusal(half)
    assert read_profile(half, unit="um").spacing == pytest.approx(0.1)
    column = file("0.5\n-0.25\n1\n0.125\n2\n")
    assert 'give the spacing of its points, as in "0.5 um"' in refusal(column, unit="um")
    assert read_profile(column, unit="um", spacing="100 nm").spacing == 0.1


@pytest.mark.parametrize(
    "above",
    [
        "Length,1500.0 um\n", "Length (um),1500\n", "Length (um): 1500\n", "Range 524nm\nx,z\n", "x (um),z (nm)\nx,z\n",
        "Radius: 2.5 µm, ID 3\n", "a text of no use\n", "um\n-----\nx,z\n", "z (um)\n",
    ],
)  # fmt: skip
def test_units_of_other_things_are_not_those_of_the_columns(file, above):
    data = "0,0.5\n0.1,-0.25\n0.2,1\n0.3,0.125\n0.4,2\n"
    assert "does not say in which unit its heights are" in refusal(file(above + data))
    if "z (um)" not in above:
        column = "\n".join(line.split(",")[1] for line in data.split())
        said = refusal(file(above + column), spacing="1 um")
        assert "does not say in which unit its heights are" in said


def test_file_and_caller_must_not_contradict_each_other(file):
    path = file(TEXTS["brackets, nm"])
    assert "says that its heights are in nm, but unit says um" in refusal(path, unit="um")
    assert read_profile(path, unit=("um", "nm")).heights.tolist() == HEIGHTS
    assert "its positions that the spacing is 0.1 µm, but spacing says 0.2 um" in refusal(path, spacing="0.2 um")
    assert read_profile(path, spacing="100 nm").spacing == 0.1
    column = file(TEXTS["one column"])
    assert "says that its spacing is 0.1 µm, but spacing says 0.3 um" in refusal(column, spacing="0.3 um")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "is empty"),
        (" \n\r\n", "nothing but blanks"),
        ("x (um),z (um)\n", "no numbers were found"),
        ("a text\nwithout numbers\n", "no numbers were found"),
        ("x (um),z (um)\n0,1\n0.1,2\n", "holds 2 point(s)"),
        ("x (V),z (um)\n0,1\n0.1,2\n0.2,1\n0.3,5\n", "unit 'V'"),
        ("x (um),y (um),z (um)\n" + "0,0.1,2\n" * 9, "has 3 columns of numbers that may be positions and several"),
        ("z (um)\n" + "0,0.1,2,3\n" * 9, "holds 9 rows of 4 columns; a profile has one column"),
        ("x (um),z (um)\n0,1\n0.1,2\n0.2,1,7\n0.3,5\n0.4,6.5\n", "the 3. line of data has 3 column(s) and most have 2"),
        ("x (um),z (um)\n0,1\n0.1,2\noops,1\n0.3,5\n0.4,6.5\n", "line 4 ('oops,1') stands between numbers"),
        ("x (um),z (um)\n0,1\n0.1,2\n0.2,1\n0.3,5\nend of data\n", "line 6 ('end of data'), after the data, is none"),
        ("z in um\n0,5\n1\n2,5\n3,5\n", "may be two columns or one with decimal commas"),
        ("0,5\n1,5\n2,5\n3,5\n", "may be two columns or one with decimal commas"),
        ("x (um)\tz (nm)\n" + "".join(f"1,{i:03}\t{i}\n" for i in range(9)), "as in '1,008', may be decimal or part"),
        ("x (um);z (um)\n1.000,5;0,1\n1.001,5;0,2\n1.002,5;0,3\n1.003,5;0,2\n", "no numbers were found"),
        ('x (um),z (um)\n"1,000.5",0.1\n"1,001.5",0.2\n"1,002.5",0.3\n', "no numbers were found"),
        ("x (um),z (um)\n0,1\n0.1,2\n0.25,1\n0.3,5\n0.4,1\n", "is not uniform: point 3 is at 0.25 µm, 0.05 µm away"),
        ("x (um),z (um)\n0,1\n0,2.5\n0,1\n0,5\n", "first and last point at the same position"),
        (
            "x (um),z (um)\n" + "".join(f"{0.3 * i:.0f},1.5\n" for i in range(99)),
            "too few digits to tell their spacing",
        ),
        ("x (um),z (um)\n0,1\n0.1,***\n0.2,1\n0.3,\n0.4,1\n", "has 2 missing points of 5, the first at 2"),
        ("x (um),z (um)\n0,1\n,2\n0.2,1\n0.3,4\n0.4,1\n", "no usable position at point 2"),
        ("x (um),z (um)\n0,nan\n1,nan\n2,nan\n3,nan\n", "all points are missing"),
        ("x (um),z (um)\n0,1\n1,1e999\n2,5\n3,0.5\n", "none of a surface (1 such values)"),
        ("x (m),z (um)\n0,1\n1e300,1\n2e300,5\n3e300,0.5\n", "no usable position"),
        ("x (m),z (um)\n0,1\n100,1\n200,5\n300,0.5\n", "has a spacing of 1e+08 µm"),
    ],
)
def test_texts_that_are_no_profile_are_refused_with_the_reason(file, text, said):
    assert said in refusal(file(text))


def test_positions_printed_with_few_digits_are_uniform_within_them(file):
    true = 0.156245 * np.arange(9600)
    for printed in (
        [f"{x:.1f}" for x in true],
        [f"{np.floor(10 * x) / 10:.1f}" for x in true],
        [f"{x:.6g}" for x in true],
    ):
        path = file("x (um),z (um)\n" + "".join(f"{x},{i % 7}.5\n" for i, x in enumerate(printed)))
        profile = read_profile(path)
        assert profile.spacing == (float(printed[-1]) - float(printed[0])) / 9599
        assert abs(profile.spacing - 0.156245) < 0.1 / 9599
    printed = [f"{x:.1f}" for x in true]
    printed[5000] = f"{float(printed[5000]) + 0.2:.1f}"
    assert "point 5001 is at" in refusal(file("x (um),z (um)\n" + "".join(f"{x},1.5\n" for x in printed)))


def test_a_spacing_said_in_words_that_disagrees_is_reported_with_both_numbers(file):
    data = "x (um),z (um)\n" + "".join(f"{0.1 * i:.1f},{i % 3}.5\n" for i in range(50))
    with pytest.warns(FormatWarning, match=r"said to be 0.2 µm, but its positions are 0.1 µm apart"):
        profile = read_profile(file("Spacing,0.2 um\n" + data))
    assert profile.spacing == pytest.approx(0.1)
    assert profile.history[1] == "spacing 0.1 µm from its positions, where it says 0.2 µm"
    assert "as it says" in read_profile(file("Resolution,0.10 um/sample\n" + data)).history[1]
    assert "says" not in read_profile(file("Resolution,20 nm\n" + data)).history[1]  # of heights, perhaps


def test_missing_points_are_interpolated_inside_and_left_out_at_the_ends(file):
    path = file("x (um),z (nm)\n0,\n0.1,1000\n0.2,NaN\n0.3,***\n0.4,4000\n0.5,0\n0.6,--\n")
    profile = read_profile(path, missing="interpolate")
    assert profile.heights.tolist() == [1, 2, 3, 4, 0]
    assert profile.history[-2:] == ("2 missing points interpolated", "2 missing points at its ends left out")


def test_a_matrix_in_text_is_a_surface(file):
    path = file("heights in nm\n" + "1\t2\t3\t0\n4\t5\t6\t0\n", "map.txt")
    surface = read_surface(path, spacing=("2 um", "0.5 um"))
    assert surface.heights.tolist() == [[0.001, 0.002, 0.003, 0], [0.004, 0.005, 0.006, 0]]
    assert surface.spacing == (2.0, 0.5)
    assert "holds no spacing" in refusal(path, read_surface)
    for table in (
        "x (um),y (um),z (um)\n" + "0,1,2\n" * 5,
        "0,1,2\n" * 5,
        "x (um),a (um),b (um),c (um)\n" + "0,1,2,3\n" * 5,
    ):
        assert "may be positions and several heights" in refusal(file(table), read_surface, unit="um", spacing="1 um")
    assert "read_profile() reads profiles" in refusal(file(TEXTS["comma"]), read_surface)


def test_a_measurement_is_what_its_file_holds(file):
    profile = read_measurement(file(TEXTS["brackets, nm"]), spacing=("100 nm", "0.1 um"))
    assert isinstance(profile, Profile)
    assert profile.heights.tolist() == HEIGHTS
    assert "which has one spacing; two are given" in refusal(
        file(TEXTS["comma"]), read_measurement, spacing=("1 um", "0.1 um")
    )
    surface = read_measurement(file(npy(np.arange(6.0).reshape(2, 3)), "a.npy"), unit="nm", spacing=("2 um", "1 um"))
    assert isinstance(surface, Surface)
    assert surface.heights.tolist() == [[0, 0.001, 0.002], [0.003, 0.004, 0.005]]
    assert surface.spacing == (2.0, 1.0)


@pytest.mark.parametrize("shape", [(5, 1), (1, 5)])
def test_a_matrix_of_one_row_or_column_is_a_profile(file, shape):
    path = file(npy(np.reshape(HEIGHTS, shape)), "a.npy")
    for read in (read_profile, read_measurement):
        assert read(path, unit="um", spacing="1 um").heights.tolist() == HEIGHTS
    assert "holds a profile of 5 points" in refusal(path, read_surface, unit="um", spacing="1 um")


def test_positions_are_no_heights_of_a_matrix(file):
    heights = np.random.default_rng(2).normal(size=(20, 30))
    x, y = 0.5 * np.arange(30), 0.25 * np.arange(20)
    options = {"read": read_surface, "unit": "um", "spacing": "1 um"}
    labelled = np.block([[np.zeros((1, 1)), x[np.newaxis]], [y[:, np.newaxis], heights]])
    for matrix, said in (
        (np.c_[y, heights[:, :2]], "20 rows of 3 columns, of which the first column counts evenly"),
        (np.array([x, heights[0]]), "2 rows of 30 columns, of which the first row counts evenly"),
        (labelled, "of which the first row and column count evenly, as positions do; leave the heights alone"),
    ):
        assert said in refusal(file(npy(matrix), "a.npy"), **options)
        text = "\n".join(" ".join(f"{value:.6f}" for value in row) for row in matrix)
        if matrix.shape[1] > 3:
            assert said in refusal(file(text, "a.txt"), **options)
    tilted = heights.copy()
    tilted[0] = x  # a lost line that was levelled
    for matrix in (heights, tilted, x + y[:, np.newaxis]):
        assert np.array_equal(read_surface(file(npy(matrix), "a.npy"), unit="um", spacing="1 um").heights, matrix)


def test_a_spacing_said_above_a_matrix_is_one_of_those_given(file):
    path = file("Spacing: 0.5 um\nheights in nm\n1 2 3 0\n4 5 6 0\n", "map.txt")
    assert read_surface(path, spacing=("2 um", "500 nm")).spacing == (2.0, 0.5)
    assert "says that its spacing is 0.5 µm, but 2 µm and 1 µm are given" in refusal(
        path, read_surface, spacing=("2 um", "1 um")
    )


# ---- NumPy arrays and writing ---------------------------------------------------------------------------------------


def test_a_generated_profile_comes_back_to_the_bit(tmp_path):
    profile = weierstrass_mandelbrot(random_phases(3), 1.4, points=5000, extent=7.0).with_amplitude(0.1)
    write_profile(profile, tmp_path / "a.csv")
    write_profile(profile, tmp_path / "a.npy")
    for again in (
        read_profile(tmp_path / "a.csv"),
        read_profile(tmp_path / "a.npy", unit="um", spacing=f"{profile.spacing!r} um"),
    ):
        assert np.array_equal(again.heights, profile.heights)
        assert again.spacing == profile.spacing
    assert "# history: scaled to height 0.1 µm\n" in (tmp_path / "a.csv").read_text(encoding="utf-8")
    assert sorted(path.name for path in tmp_path.iterdir()) == ["a.csv", "a.npy"]


def test_a_surface_comes_back_to_the_bit(tmp_path):
    surface = Surface(np.random.default_rng(1).normal(size=(30, 40)), spacing=(0.5, 0.25))
    write_surface(surface, tmp_path / "a.npy")
    again = read_surface(tmp_path / "a.npy", unit="um", spacing=("0.5 um", "0.25 um"))
    assert np.array_equal(again.heights, surface.heights)
    assert again.spacing == surface.spacing


def test_nothing_is_written_over_or_by_halves(tmp_path, monkeypatch):
    profile = Profile(HEIGHTS, spacing=0.1)
    (tmp_path / "a.csv").write_text("mine", encoding="utf-8")
    for path, said in (
        (tmp_path / "a.csv", "exists already; remove it, or choose another name"),
        (tmp_path / "a.xls", "must end in .csv or .npy"),
        (tmp_path / "nowhere" / "a.csv", "cannot be written: No such file"),
    ):
        with pytest.raises(FormatError, match=said):
            write_profile(profile, path)
    assert (tmp_path / "a.csv").read_text(encoding="utf-8") == "mine"
    with pytest.raises(ValueError, match="profile must be a Profile, got list"):
        write_profile([1.0], tmp_path / "b.csv")
    monkeypatch.setattr(np, "save", lambda file, _: (file.write(b"half"), file.flush(), os.close(-1)))
    with pytest.raises(FormatError, match="cannot be written"):
        write_surface(Surface(np.eye(3), spacing=1.0), tmp_path / "b.npy")
    assert [path.name for path in tmp_path.iterdir()] == ["a.csv"]


def npy(array):
    stream = io.BytesIO()
    np.save(stream, array)
    return stream.getvalue()


@pytest.mark.parametrize(
    ("content", "name", "said"),
    [
        (npy(np.zeros(9)), "a.npy", "does not say in which unit"),
        (npy(np.array([1, None])), "a.npy", "damaged .npy file, or one of objects"),
        (npy(np.zeros(9))[:-5], "a.npy", "damaged"),
        (npy(np.zeros(9, complex)), "a.npy", "array of complex128"),
        (npy(np.zeros((2, 2, 2))), "a.npy", "shape (2, 2, 2)"),
        (npy(np.zeros((5, 5))), "a.npy", "5 rows of 5 columns"),
        (npy(np.zeros(9)), "a.csv", "is named .csv, but what it holds is a NumPy array (.npy)"),
        (b"0,1\n", "a.npy", "is named .npy, but what it holds is not a NumPy array (.npy)"),
        (b"0,1\n", "a.x3p", "is named .x3p, but what it holds is not a zip archive"),
        (bytes(range(256)) * 9, "a.csv", "is binary, not text"),
        (b"\x93NUMPY\x01\x00" + b"\xff" * 300, "a.npy", "damaged"),
        (b"PK\x03\x04" + b"\xff" * 300, "a.x3p", "damaged X3P"),
        (b"no such format", "a.abc", "SurfaceTopography"),
    ],
)
def test_files_that_are_not_what_they_should_be_are_refused(file, content, name, said):
    assert said in refusal(file(content, name))


def test_what_cannot_be_opened_is_refused(tmp_path):
    assert "No such file" in refusal(tmp_path / "none.csv")
    assert "is a directory" in refusal(tmp_path)
    os.mkfifo(tmp_path / "pipe.csv")  # which would be waited for
    assert "is not a file" in refusal(tmp_path / "pipe.csv")


def test_what_is_too_large_is_refused_before_it_is_read(tmp_path, monkeypatch):
    for name, size in (("a.csv", raw.MOST_TEXT_BYTES + 1), ("a.npy", raw.MOST_BYTES + 1)):
        with (tmp_path / name).open("wb") as file:
            file.truncate(size)  # of holes
        assert f"has {size} bytes" in refusal(tmp_path / name)
    monkeypatch.setattr(npy_files, "MOST_POINTS", 8)
    (tmp_path / "b.npy").write_bytes(npy(np.zeros(9)))
    assert "holds 9 points; at most 8" in refusal(tmp_path / "b.npy")


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"unit": "furlong"}, "unit must be a unit of length"),
        ({"unit": ("um",)}, "unit must be"),
        ({"unit": 3}, "unit must be"),
        ({"spacing": 0.1}, "spacing needs a length with its unit"),
        ({"spacing": "0.1 MPa"}, "spacing has the unit 'MPa'"),
        ({"spacing": "0 um"}, "spacing must be above 0"),
        ({"missing": "zero"}, "missing must be one of 'error', 'interpolate'"),
    ],
)
def test_bad_arguments_are_named(file, options, said):
    for read in (read_profile, read_surface, read_measurement):
        with pytest.raises(ValueError, match=said) as caught:
            read(file(TEXTS["comma"]), **options)
        assert not isinstance(caught.value, FormatError)


def test_without_the_package_for_instruments_its_installation_is_told(file, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "SurfaceTopography", None)
    assert 'pip install "stiction[formats]"' in refusal(file(b"?File list", "a.di"), read_surface)


# ---- X3P ------------------------------------------------------------------------------------------------------------


def x3p(
    heights, *, spacing=(2e-6, 1e-6), stored="D", increment=1.0, valid=None, positions=None, listed=False, change=()
):
    """An X3P file of heights in metres, by the words of the standard."""
    heights = np.atleast_2d(heights)
    rows, columns = heights.shape
    form = {"I": "<i2", "L": "<i4", "F": "<f4", "D": "<f8"}[stored]
    values = np.round(heights / increment).astype(form) if stored in "IL" else heights.astype(form)
    if positions is not None:
        table = np.empty(values.size, dtype=[("x", "<f8"), ("z", form)])
        table["x"], table["z"] = positions, values.ravel()
        values = table
    data = values.tobytes()
    x_axis = "<AxisType>I</AxisType>" if positions is None else "<AxisType>A</AxisType>"
    link = "<ValidPointsLink>bindata/valid.bin</ValidPointsLink>" if valid is not None else ""
    points = (
        f"<DataLink><PointDataLink>bindata/data.bin</PointDataLink>"
        f"<MD5ChecksumPointData>{hashlib.md5(data).hexdigest().upper()}</MD5ChecksumPointData>{link}</DataLink>"
    )
    if listed:
        points = "".join(f"<Datum>{'' if np.isnan(z) else repr(float(z))}</Datum>" for z in heights.ravel())
        points = f"<DataList>{points}</DataList>"
    main = (
        '<?xml version="1.0" encoding="UTF-8"?><p:ISO5436_2 xmlns:p="http://www.opengps.eu/2008/ISO5436_2"><Record1>'
        f"<Revision>ISO5436 - 2000</Revision><FeatureType>{'PRF' if rows == 1 else 'SUR'}</FeatureType><Axes>"
        f"<CX>{x_axis}<DataType>D</DataType><Increment>{spacing[1] if positions is None else 1.0!r}</Increment></CX>"
        f"<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>{spacing[0]!r}</Increment></CY>"
        f"<CZ><AxisType>A</AxisType><DataType>{stored}</DataType><Increment>{increment!r}</Increment></CZ></Axes>"
        f"</Record1><Record3><MatrixDimension><SizeX>{columns}</SizeX><SizeY>{rows}</SizeY><SizeZ>1</SizeZ>"
        f"</MatrixDimension>{points}</Record3></p:ISO5436_2>"
    )
    for old, new in change:
        assert old in main
        main = main.replace(old, new)
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("main.xml", main)
        archive.writestr("bindata/data.bin", data)
        if valid is not None:
            archive.writestr("bindata/valid.bin", np.packbits(valid, bitorder="little").tobytes())
    return stream.getvalue()


METRES = 1e-6 * np.random.default_rng(5).normal(size=(6, 9))


@pytest.mark.parametrize(("stored", "off"), [("D", 1e-15), ("F", 1e-6), ("L", 1e-6), ("I", 1e-3)])
def test_x3p_surfaces_and_profiles(file, stored, off):
    options = {"stored": stored, "increment": {"L": 1e-12, "I": 1e-9}.get(stored, 1.0)}
    surface = read_surface(file(x3p(METRES, **options), "a.x3p"))
    assert np.abs(surface.heights - 1e6 * METRES).max() <= off
    assert surface.spacing == pytest.approx((2.0, 1.0))
    profile = read_profile(file(x3p(METRES[0], **options), "b.x3p"), unit="m", spacing="1 um")
    assert np.abs(profile.heights - 1e6 * METRES[0]).max() <= off
    x = 3e-6 + 5e-7 * np.arange(9)
    with_positions = read_profile(file(x3p(METRES[0], positions=x, **options), "c.x3p"))
    assert np.array_equal(with_positions.heights, profile.heights)
    assert with_positions.spacing == pytest.approx(0.5)


def test_increments_of_x3p_multiply_whole_numbers(file):
    whole = x3p(METRES, stored="I", increment=1e-9, change=[("<Increment>1e-09</Increment>", "")])
    assert "has whole numbers for Z, but no Increment" in refusal(file(whole, "a.x3p"), read_surface)
    for increment in ("", "<Increment>0.0</Increment>"):  # which numbers with decimals do not need
        path = file(x3p(METRES, change=[("<Increment>1.0</Increment>", increment)]), "a.x3p")
        assert np.abs(read_surface(path).heights - 1e6 * METRES).max() < 1e-15


def test_x3p_with_a_namespace_for_all_its_elements(file):
    change = [("<p:ISO5436_2 xmlns:p=", "<ISO5436_2 xmlns="), ("</p:ISO", "</ISO")]
    assert read_surface(file(x3p(METRES, change=change), "a.x3p")).heights.shape == METRES.shape


def test_x3p_profiles_that_do_not_run_along_x_are_refused(file):
    along_y = "<CY><AxisType>A</AxisType><DataType>D</DataType></CY>"
    old = "<CY><AxisType>I</AxisType><DataType>D</DataType><Increment>2e-06</Increment></CY>"
    points = "".join(
        f"<Datum>{1e-6 * i!r};{y!r};{z!r}</Datum>" for i, (y, z) in enumerate((1e-6 * np.eye(9)[:, :2]).tolist())
    )
    data = x3p(METRES[0], listed=True, positions=np.arange(9.0), change=[(old, along_y)])
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        main = archive.read("main.xml").decode()
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("main.xml", main[: main.index("<Datum>")] + points + main[main.index("</DataList>") :])
    assert "points move along y as well" in refusal(file(stream.getvalue(), "a.x3p"))


def test_x3p_agrees_with_another_reader(file):
    topography = pytest.importorskip("SurfaceTopography")
    path = file(x3p(METRES), "a.x3p")
    with topography.open_topography(str(path)) as reader:
        other = reader.topography()
    surface = read_surface(path)
    factor = {"m": 1e6, "µm": 1.0}[other.unit]
    assert np.abs(surface.heights - factor * other.heights().T).max() < 1e-12
    assert surface.spacing == pytest.approx(tuple(factor * each for each in reversed(other.pixel_size)))


def test_missing_points_of_x3p(file):
    valid = np.ones(METRES.shape, dtype=bool)
    valid[2, 4] = False
    path = file(x3p(METRES, valid=valid.ravel()), "a.x3p")
    assert "has 1 missing points of 54, the first at 3 5" in refusal(path, read_surface)
    surface = read_surface(path, missing="interpolate")
    assert surface.heights[2, 4] == pytest.approx(1e6 * (METRES[2, 3] + METRES[2, 5]) / 2)
    assert surface.history[-1] == "1 missing points interpolated"
    gaps = np.where(np.arange(9) == 4, np.nan, METRES[0])
    for data in (x3p(gaps), x3p(gaps, listed=True)):
        profile = read_profile(file(data, "b.x3p"), missing="interpolate")
        assert profile.heights[4] == pytest.approx(1e6 * (METRES[0, 3] + METRES[0, 5]) / 2)
    corner = np.where(np.arange(54).reshape(6, 9) == 0, np.nan, METRES)
    assert "1 missing points at its edges" in refusal(file(x3p(corner), "c.x3p"), read_surface, missing="interpolate")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("<FeatureType>SUR", "<FeatureType>PCL"), "feature type 'PCL'"),
        (("<SizeX>9", "<SizeX>10"), "says it holds 60 points of 8 bytes, but has 432 bytes"),
        (("<SizeX>9", "<SizeX>-9"), "where a number of points should be"),
        (("<SizeX>9", "<SizeX>99999999"), "from 1 to 100000000 can be read"),
        (("<SizeZ>1", "<SizeZ>2"), "holds 2 layers"),
        (("<Increment>2e-06", "<Increment>two"), "has 'two' where a number should be"),
        (("<Increment>2e-06", "<Increment>nan"), "has a spacing of nan"),
        (("<DataType>D", "<DataType>Q"), "stored as 'Q'"),
        (("bindata/data.bin", "../../data.bin"), "lacks '../../data.bin'"),
        (("MD5ChecksumPointData>", "X>"), None),
        (("<MD5ChecksumPointData>", "<MD5ChecksumPointData>0"), "do not have the checksum"),
        (("<Record1>", "<Record9>"), "damaged X3P file (ParseError"),
        (("<p:ISO", '<!DOCTYPE a [<!ENTITY b "c">]><p:ISO'), "document type of its own"),
    ],
)
def test_x3p_that_contradicts_itself_is_refused(file, change, said):
    path = file(x3p(METRES, change=[change]), "a.x3p")
    if said is None:
        read_surface(path)
    else:
        assert said in refusal(path, read_surface)


# ---- Measured files and damaged ones --------------------------------------------------------------------------------


def test_a_stylus_profile(measured):
    path = measured("dektak-1.csv")
    profile = read_profile(path)
    assert len(profile) == 9600
    assert profile.spacing == pytest.approx(1499.8 / 9599, rel=1e-12)
    assert profile.history[1] == "spacing 0.1562454 µm from its positions, where it says 0.156 µm"
    assert np.std(levelled(profile, "line").heights) == pytest.approx(0.0942, abs=5e-5)
    assert read_profile(path, spacing="0.15625 um").extent == 1500.0
    assert "0.1562454 µm, but spacing says 0.156 um" in refusal(path, spacing="0.156 um")


def test_a_surface_of_an_atomic_force_microscope(measured):
    pytest.importorskip("SurfaceTopography")
    surface = read_surface(measured("di-4.di"))
    assert surface.heights.shape == (512, 512)
    assert surface.extent == pytest.approx((10.0, 10.0))
    level = levelled(surface, "plane")
    assert np.std(level.heights) == pytest.approx(0.0794, abs=5e-5)
    along_x = [np.var(levelled(level.row(index), "line").heights) for index in range(512)]
    assert np.sqrt(np.mean(along_x)) == pytest.approx(0.0388, abs=5e-5)


def test_any_damaged_file_is_read_or_refused_in_one_sentence(tmp_path):
    pristine = {
        "a.csv": "".join([TEXTS["text above"], *(f"{i / 10},{i % 7}.5,\n" for i in range(5, 40))]).encode(),
        "b.txt": TEXTS["decimal comma and tab"].encode(),
        "c.npy": npy(np.arange(20.0)),
        "d.x3p": x3p(METRES[0]),
        "e.x3p": x3p(METRES[0], listed=True),
        "f.x3p": x3p(METRES[0], positions=1e-6 * np.arange(9)),
    }
    outcomes = Counter()
    for index in range(1500):
        random = np.random.default_rng([4, index])
        name = str(random.choice(list(pristine)))
        outcomes[fuzzing.fuzz_measured(random, name, pristine[name], tmp_path)] += 1
    assert outcomes["read"] > 100
    assert outcomes["refused"] > 500
