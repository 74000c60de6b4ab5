"""Tests of instrument layouts with several encodings, separators, decimal marks and languages."""

import io
import itertools
import re
import warnings

import numpy as np
import pytest
from stiction import FormatError, FormatWarning, Profile, Surface, read_measurement, write_profile, write_surface
from stiction.surfaces.measured.decode import decode_text
from stiction.surfaces.measured.layouts import TEXT_LAYOUTS
from stiction.surfaces.measured.reading import read_with_interpretation
from support import fuzzing

random = np.random.default_rng(8)
NUM_ROWS, NUM_COLUMNS = 7, 9
HEIGHTS = np.round(0.3 * random.normal(size=(NUM_ROWS, NUM_COLUMNS)).cumsum(axis=1), 4)
HEIGHTS_WITH_HOLES = HEIGHTS.copy()
HEIGHTS_WITH_HOLES[0, :2] = HEIGHTS_WITH_HOLES[3, 4] = np.nan
LINE_HEIGHTS = np.round(0.3 * random.normal(size=60).cumsum(), 4)


def format_number(value, comma=False, missing="", form=".4f"):
    text = missing if np.isnan(value) else f"{value:{form}}"
    return text.replace(".", ",") if comma else text


def format_rows(heights, separator="\t", **options):
    return [separator.join(format_number(value, **options) for value in row) for row in heights]


GWYDDION_WORDS = {
    "en": ("Channel:", "Width:", "Height:", "Value units:"),
    "de": ("Kanal:", "Breite:", "Höhe:", "Einheiten:"),
    "fr": ("Canal :", "Largeur :", "Hauteur :", "Unités :"),
    "ja": ("チャネル：", "幅:", "高さ：", "値の単位:"),
    "ru": ("Канал:", "Ширина:", "Высота:", "Единицы измерения:"),
    "cs": ("Kanál:", "Šířka:", "Výška:", "Jednotky hodnot:"),
}


def gwyddion_text(language="en", comma=False, missing="nan", unit="µm", minus="-"):
    channel, width, height, units = GWYDDION_WORDS[language]
    size = (format_number(4.5, comma, form=".3f"), format_number(3.5, comma, form=".3f"))
    header_lines = [f"# {channel} Topo", f"# {width} {size[0]} µm", f"# {height} {size[1]} µm", f"# {units} {unit}"]
    return (
        "\n".join(
            header_lines
            + [line.replace("-", minus) for line in format_rows(HEIGHTS_WITH_HOLES, comma=comma, missing=missing)]
        )
        + "\n"
    )


KEYENCE_WORDS = {
    "en": ("Data type", "XY Calibration", "Horizontal", "Vertical", "Unit", "Output image data", "Height"),
    "de": ("Dateityp", "XY-Justierung", "Horizont.", "Vertikal", "Einheit", "Bilddatenausg.", "Höhe"),
    "ja": ("データ種類", "XYキャリブレーション", "水平", "垂直", "単位", "出力画像データ", "高さ"),
    "zh": ("数据类型", "XY 校准", "水平", "垂直", "单位", "输出图像数据", "高度"),
}


def keyence_text(language="en", separator=",", comma=False, unit="um", quoted=True):
    kind, pixel, across, down, units, output, height = KEYENCE_WORDS[language]
    header_lines = [
        ["Model", "VK-X3000 Series"],
        [kind, "ImageDataCsv"],
        [pixel, format_number(500.0, comma, form=".3f"), "nm"],
        [output, height],
        [across, str(NUM_COLUMNS)],
        [down, str(NUM_ROWS)],
        ["Minimum", format_number(-9.0, comma, form=".3f")],
        [units, unit],
        ["Reference", ""],
    ]
    body = [[format_number(value, comma) for value in row] for row in HEIGHTS_WITH_HOLES]
    lines = [*header_lines, [], [height], *body]
    quote = '"' if quoted else ""
    return "\r\n".join(separator.join(f"{quote}{cell}{quote}" for cell in line) for line in lines) + "\r\n"


def olympus_text(separator=",", comma=False, missing=""):
    names = ["DataLine", *(f"POS = {index + 1}" for index in range(NUM_COLUMNS))]
    resolution = format_number(0.5, comma, form=".3f")
    header_rows = [
        ["Model", "OLS5000"],
        *([f"{axis} Resolution[um]", resolution] for axis in "XY"),
        ["Z Resolution[um]", "1"],
    ]
    body = [
        [str(index + 1), *(format_number(value, comma, missing) for value in row)]
        for index, row in enumerate(HEIGHTS_WITH_HOLES)
    ]
    return "\r\n".join(separator.join(line) for line in [*header_rows, names, *body]) + "\r\n"


def zygo_text(order=1, separator=" ", origin=0, end=True):
    header_lines = [
        "Zygo XYZ Data File - Format 1",
        '0 8 0 0 "x"',
        "0 0 0 0 0 0",
        f"{origin} {origin} {NUM_COLUMNS} {NUM_ROWS}",
    ]
    header_lines += [
        '"a"',
        '"b"',
        '"c"',
        "0 0.5 6.3e-07 0.08 1 0 5e-07 1770655883",
        "1 1 0 0 8 0",
        "0 0",
        "1 1",
        '1 "d"',
        "1 0",
    ]
    points = [
        separator.join(
            [str(column + origin), str(row + origin), format_number(HEIGHTS_WITH_HOLES[row, column], missing="No Data")]
        )
        for row, column in np.ndindex(NUM_ROWS, NUM_COLUMNS)
    ]
    return "\n".join([*header_lines, "#", *points[::order], *["#"] * end]) + "\n"


def wyko_text(real=1, intensity=True, missing="Bad", aspect=False, comma=False):
    header_lines = [f"Wyko ASCII Data File Format 0\t{real}\t1", f"X Size\t{NUM_COLUMNS}", f"Y Size\t{NUM_ROWS}"]
    header_lines += [
        "Block Name\tType\tLength\tValue",
        "Pixel_size\t7\t4\t0.0005",
        "Wavelength\t7\t4\t500",
        "Mult\t7\t4\t2",
    ]
    header_lines += ["Aspect\t7\t4\t1"] * aspect
    scale = 1000 if real else 1000 / 250
    body = format_rows(HEIGHTS_WITH_HOLES.T * scale, missing=missing, form=".6f", comma=comma)
    intensity_lines = ["Intensity\t6\t320", *format_rows(np.abs(HEIGHTS.T))] if intensity else []
    return "\n".join([*header_lines, "RAW_DATA\t3\t320", *body, *intensity_lines]) + "\n"


def esri_text(case=str, code="-9999", separator=" ", size="cellsize 0.5", comma=False):
    header_lines = [
        f"ncols {NUM_COLUMNS}",
        f"nrows {NUM_ROWS}",
        "xllcorner 0",
        "yllcorner 0",
        size,
        f"NODATA_value {code}",
    ]
    header_lines = [case(line) for line in header_lines]
    return (
        "\n".join([*header_lines, *format_rows(HEIGHTS_WITH_HOLES[::-1], separator, missing=code, comma=comma)]) + "\n"
    )


def spip_text(unit="# z-unit = µm", factor=1.0, missing="nan", separator="\t", lengths=("4500", "3500")):
    header_lines = ["# File Format = ASCII", f"# x-pixels = {NUM_COLUMNS}", f"# y-pixels = {NUM_ROWS}"]
    header_lines += [f"# x-length = {lengths[0]}", f"# y-length = {lengths[1]}", unit, "# Start of Data:"]
    return (
        "\n".join([*header_lines, *format_rows(HEIGHTS_WITH_HOLES / factor, separator, missing=missing, form=".6f")])
        + "\n"
    )


def sdf_text(magic="aISO-1.0", profiles=NUM_ROWS, missing="BAD", break_after=NUM_COLUMNS, space=" = "):
    points, values = (NUM_COLUMNS, HEIGHTS_WITH_HOLES.ravel()) if profiles > 1 else (LINE_HEIGHTS.size, LINE_HEIGHTS)
    texts = {"ManufacID": "OWN", "NumPoints": points, "NumProfiles": profiles, "Xscale": "5.0E-7",
            "Yscale": "5.0E-7" if profiles > 1 else "0", "Zscale": "1.0E-6", "DataType": 7}  # fmt: skip
    cells = [format_number(value, missing=missing) for value in values]
    lines = [" ".join(cells[index : index + break_after]) for index in range(0, len(cells), break_after)]
    return (
        "\n".join(
            [magic, *(f"{header_key}{space}{value}" for header_key, value in texts.items()), "*", *lines, "*", "", "*"]
        )
        + "\n"
    )


def tencor_text(numbered=True, separator="\t", pad=""):
    header_lines = [
        "Data\tPLATE",
        f"Number of Points\t{NUM_COLUMNS}",
        f"Number of Traces\t{NUM_ROWS}",
        "X-Resolution\t0.500000",
    ]
    header_lines += ["Y-Resolution\t0.500000", "", "Trace\tData"]
    body = [
        separator.join(
            [*([str(index + 1)] if numbered else []), *(pad + format_number(1e4 * value, form=".1f") for value in row)]
        )
        for index, row in enumerate(HEIGHTS)
    ]
    return "\r\n".join([*header_lines, *body]) + "\r\n"


def triplet_text(order=1, separator=" ", head="", missing=None, comma=False, jitter=0.0):
    grid_indices = [
        (y, x)
        for y, x in np.ndindex(NUM_ROWS, NUM_COLUMNS)
        if missing is not None or not np.isnan(HEIGHTS_WITH_HOLES[y, x])
    ]
    lines = []
    for index, (y, x) in enumerate(grid_indices):
        deviation = jitter * ((index % 3) - 1)
        cells = [
            format_number(0.5 * x + deviation, comma),
            format_number(0.5 * y - deviation, comma),
            format_number(HEIGHTS_WITH_HOLES[y, x], comma, missing or ""),
        ]
        lines.append(separator.join(cells))
    return "\n".join([*[head] * bool(head), *lines[::order]]) + "\n"


def labelled_matrix_text(separator=",", corner="", comma=False, missing="", form=".2f"):
    header_line = separator.join([corner, *(format_number(0.5 * x, comma, form=form) for x in range(NUM_COLUMNS))])
    body = [
        separator.join([format_number(0.5 * y, comma, form=form), line])
        for y, line in enumerate(format_rows(HEIGHTS_WITH_HOLES, separator, comma=comma, missing=missing))
    ]
    return "\n".join([header_line, *body]) + "\n"


def profile_text(separator=";", comma=True, head="x (µm);z (µm)", minus="-", end="\n"):
    lines = [
        f"{format_number(0.5 * index, comma)}{separator}{format_number(z, comma)}"
        for index, z in enumerate(LINE_HEIGHTS)
    ]
    return end.join([head, *lines]).replace("-", minus) + end


MASK_OPTION, MASK_AND_UNIT_OPTIONS = {"missing": "mask"}, {"missing": "mask", "unit": "um"}
EXPORT_FORMATS = {
    "gwyddion": (
        gwyddion_text, MASK_OPTION,
        [{"language": language, "comma": comma} for language, comma in itertools.product(GWYDDION_WORDS, (False, True))]
        + [{"minus": "\u2212"}, {"missing": "***"}, {"missing": "NaN"}],
    ),
    "keyence": (
        keyence_text, MASK_OPTION,
        [{}, {"language": "de", "separator": ";", "comma": True}, {"language": "ja"}, {"language": "zh", "unit": "μm"},
         {"language": "de", "comma": True}, {"language": "en", "separator": "\t"}, {"quoted": False},
         {"language": "de", "separator": ";", "comma": True, "quoted": False}],
    ),
    "olympus": (
        olympus_text, MASK_OPTION,
        [{}, {"separator": ";"}, {"separator": ";", "comma": True}, {"separator": "\t"}, {"missing": "nan"}],
    ),
    "zygo": (zygo_text, MASK_OPTION, [{}, {"order": -1}, {"separator": "\t"}, {"origin": 10}, {"end": False}]),
    "wyko": (
        wyko_text, MASK_OPTION,
        [{}, {"real": 0}, {"intensity": False}, {"aspect": True}, {"missing": "BAD"}, {"comma": True},
         {"missing": "nan"}],
    ),
    "esri": (
        esri_text, {**MASK_AND_UNIT_OPTIONS, "spacing": "0.5 um"},
        [{}, {"case": str.upper}, {"code": "1e+30"}, {"size": "dx 0.5\ndy 0.5"}, {"separator": "\t"},
         {"code": "-32768"}],
    ),
    "spip": (
        spip_text, MASK_OPTION,
        [{}, {"unit": "# Bit2nm = 1000", "factor": 1.0}, {"unit": "# z-unit = nm", "factor": 1e-3}, {"separator": " "},
         {"missing": "***"}, {"unit": "# Bit2nm = 2.5", "factor": 2.5e-3}],
    ),
    "sdf": (
        sdf_text, MASK_OPTION,
        [{}, {"magic": "aNPL-V1.0"}, {"magic": "aBCR-1.0"}, {"magic": "aBC-1.0"}, {"break_after": 4},
         {"space": "   = "}, {"break_after": 1}],
    ),
    "tencor": (
        tencor_text, {"unit": "Å", "spacing": ("0.5 um", "0.5 um")},
        [{}, {"numbered": False}, {"pad": "   "}, {"separator": ","}, {"separator": ";"}],
    ),
    "triplets": (
        triplet_text, MASK_AND_UNIT_OPTIONS,
        [{}, {"order": -1}, {"separator": ";", "comma": True}, {"separator": ",", "head": "x (um),y (um),z (um)"},
         {"separator": "\t", "head": "X\tY\tZ"}, {"missing": "nan"}, {"separator": ",", "missing": "nan"},
         {"jitter": 0.02}],
    ),
    "labelled": (
        labelled_matrix_text, MASK_AND_UNIT_OPTIONS,
        [{}, {"separator": ";", "comma": True}, {"separator": "\t"}, {"corner": "y/x"}, {"missing": "nan"},
         {"form": ".1f"}],
    ),
}  # fmt: skip
ENCODINGS = ("utf-8", "utf-8-sig", "utf-16", "utf-16-le", "utf-16-be", "cp1252", "cp932", "gb18030", "cp1251", "cp1250")


def read_scan_or_none(path, **options):
    """Return the scan in a file, or None if the file is rejected. Warnings about caveats are ignored."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        try:
            return read_measurement(path, **options)
        except FormatError:
            return None


@pytest.mark.parametrize("name", EXPORT_FORMATS)
@pytest.mark.parametrize("encoding", ENCODINGS)
def test_maps_exported_by_instruments_in_any_encoding_are_read_exactly_or_rejected(tmp_path, name, encoding):
    write, options, variants = EXPORT_FORMATS[name]
    num_accepted = 0
    for variant in variants:
        try:
            file_bytes = write(**variant).encode(encoding)
        except UnicodeEncodeError:
            continue
        path = tmp_path / "map.txt"
        path.write_bytes(file_bytes)
        body = read_scan_or_none(path, **options)
        if body is None:
            continue
        num_accepted += 1
        heights = body.heights if body.missing is None else np.where(body.missing, np.nan, body.heights)
        expected = HEIGHTS if name == "tencor" else HEIGHTS_WITH_HOLES
        assert heights.shape == expected.shape, (variant, body.history)
        assert np.allclose(heights, expected, rtol=0, atol=1e-6, equal_nan=True), (variant, body.history)
        assert body.spacing == pytest.approx((0.5, 0.5), rel=1e-2 if variant.get("jitter") else 1e-6)
    if encoding in ("utf-8", "utf-8-sig", "utf-16", "utf-16-le"):
        assert num_accepted == len(variants)


@pytest.mark.parametrize("encoding", ENCODINGS)
@pytest.mark.parametrize(
    "variant",
    [
        {}, {"separator": "\t", "head": "x (µm)\tz (µm)"}, {"separator": ",", "comma": False, "head": "x [µm],z [µm]"},
        {"minus": "\u2212"}, {"end": "\r\n"}, {"head": "Weg [µm];Höhe [µm]"}, {"head": "位置(μm);高さ(μm)"},
        {"separator": " ", "comma": False, "head": "# x (µm)  z (µm)"}, {"head": "x;z\nµm;µm"},
    ],
)  # fmt: skip
def test_profiles_exported_by_instruments_in_any_encoding_are_read_exactly_or_rejected(tmp_path, variant, encoding):
    try:
        file_bytes = profile_text(**variant).encode(encoding)
    except UnicodeEncodeError:
        pytest.skip("no such characters")
    (tmp_path / "line.csv").write_bytes(file_bytes)
    body = read_scan_or_none(tmp_path / "line.csv")
    assert body is not None or encoding in ("cp1251", "cp1250", "gb18030")
    if body is not None:
        assert body.heights.tolist() == LINE_HEIGHTS.tolist()
        assert body.spacing == pytest.approx(0.5)


def test_exported_file_of_each_format_is_recognised_by_exactly_one_layout_parser():
    texts = {
        name: write(**variant) for name, (write, _, variants) in EXPORT_FORMATS.items() for variant in variants[:1]
    }
    for name, text in texts.items():
        result = [layout.name for layout in TEXT_LAYOUTS if layout.recognises(decode_text(text.encode()))]
        assert len(result) == (name not in ("triplets", "labelled")), (name, result)


@pytest.mark.parametrize(
    ("text", "options"),
    [
        (gwyddion_text(unit="V"), {"unit": "nm"}),
        (gwyddion_text(unit="deg"), {}),
        (keyence_text(unit="%"), {"unit": "nm"}),
        ("x(mm)\tSlope (urad)\n" + "".join(f"{x}\t{x % 7}.5\n" for x in range(40)), {"unit": ("mm", "um")}),
        (
            "#x-position [mm]; y-slope [urad]\n" + "".join(f"{x}.0\t{x % 7}.5\n" for x in range(40)),
            {"unit": ("mm", "um")},
        ),
        ("Z unit: V\n" + "".join(f"{x % 7}.5\n" for x in range(40)), {"unit": "um", "spacing": "1 um"}),
        ("x (um),Phase\n" + "".join(f"{x},{x % 7}.5\n" for x in range(40)), {"unit": "um"}),
    ],
)
def test_heights_in_units_that_are_not_lengths_are_rejected(tmp_path, text, options):
    (tmp_path / "a.txt").write_text(text, encoding="utf-8")
    assert read_scan_or_none(tmp_path / "a.txt", **options) is None


def table_text(columns, head="", form=".4f"):
    lines = [" ".join(f"{value:{form}}" for value in row) for row in np.transpose(columns)]
    return "\n".join([*[head] * bool(head), *lines]) + "\n"


def test_positions_in_wide_tables_are_not_read_as_heights(tmp_path):
    x, profiles = 0.5 * np.arange(60), random.normal(size=(12, 60)).cumsum(axis=1)
    measured_positions = x + 1e-3 * random.normal(size=60)
    options = {"unit": "um", "spacing": "0.5 um"}
    path = tmp_path / "a.txt"
    for columns in (
        [x, *profiles],
        [measured_positions, *profiles],
        [x, profiles[0], x, profiles[1]],
        [np.arange(60), *profiles],
    ):
        path.write_text(table_text(columns))
        assert read_scan_or_none(path, **options) is None
        if columns[0] is not measured_positions:
            assert np.allclose(read_scan_or_none(path, columns=(0, 1), unit="um").heights, columns[1], atol=1e-4)
    path.write_text(table_text(np.transpose([x, *profiles])))
    assert read_scan_or_none(path, **options) is None
    path.write_text(table_text(profiles))
    assert read_scan_or_none(path, **options).heights.shape == (60, 12)


def test_counts_and_sizes_in_headers_are_not_read_as_heights(tmp_path):
    path, options = tmp_path / "a.txt", {"unit": "um", "spacing": "0.5 um"}
    column_text = "".join(f"{z:.4f}\n" for z in LINE_HEIGHTS)
    pairs = "".join(f"{0.5 * index:.4f}, {z:.4f}\n" for index, z in enumerate(LINE_HEIGHTS))
    for text in (
        f"60\n{column_text}",
        f"60 (Data size)\n{column_text}",
        f"Points: 60\n{column_text}",
        f"µm µm\n60\n{pairs}",
        f"60\n{pairs}",
    ):
        path.write_text(text, encoding="utf-8")
        assert (
            read_scan_or_none(path, **(options if text.endswith(column_text) else {"unit": "um"})).heights.tolist()
            == LINE_HEIGHTS.tolist()
        )
    path.write_text(f"{NUM_COLUMNS} {NUM_ROWS}\n" + "\n".join(format_rows(HEIGHTS, " ")))
    assert np.array_equal(read_scan_or_none(path, **options).heights, HEIGHTS)
    one_column_text = "".join(f"{z:.4f}\n" for z in HEIGHTS.ravel())
    for text in (f"0.5\n60\n{column_text}", f"{NUM_COLUMNS}\n{NUM_ROWS}\n{one_column_text}"):
        path.write_text(text)
        assert read_scan_or_none(path, **options) is None


def test_first_height_with_fewer_decimals_than_the_other_heights_adds_a_caveat(tmp_path):
    path, options = tmp_path / "a.txt", {"unit": "um", "spacing": "0.5 um"}
    path.write_text("0.5\n" + "".join(f"{z:.4f}\n" for z in LINE_HEIGHTS))
    with pytest.warns(FormatWarning, match="first-number"):
        read_measurement(path, **options)
    assert not read_with_interpretation(path, **options, accept="first-number").caveats
    path.write_text("0.4\n" + "".join(f"{z:g}\n" for z in LINE_HEIGHTS))
    assert not read_with_interpretation(path, **options).caveats


def test_number_near_the_end_of_a_profile_that_equals_the_number_of_heights_adds_a_caveat(tmp_path):
    path, options = tmp_path / "a.txt", {"unit": "um", "spacing": "0.5 um"}
    heights = "".join(f"{z:.4f}\n" for z in LINE_HEIGHTS)
    count = LINE_HEIGHTS.size
    for last_numbers, is_count in (
        (f"{count}", True), (f"{count - 9}", False), (f"0.2500\n{count}", True), (f"{count}\n0.2500\n1.0000", True),
    ):  # fmt: skip
        path.write_text(f"{heights}{last_numbers}\n")
        names = [caveat.name for caveat in read_with_interpretation(path, **options).caveats]
        assert ("first-number" in names) == is_count


@pytest.mark.parametrize("first_number", ["0.5000", "0.0005", "500.0000"])
def test_first_number_that_equals_the_given_spacing_in_any_unit_adds_a_caveat(tmp_path, first_number):
    path, options = tmp_path / "a.txt", {"unit": "um", "spacing": "0.5 um"}
    path.write_text(f"{first_number}\n" + "".join(f"{z:.4f}\n" for z in LINE_HEIGHTS))
    assert "first-number" in [caveat.name for caveat in read_with_interpretation(path, **options).caveats]


def test_words_in_a_line_of_data_are_rejected_with_an_error_that_states_the_line_number(tmp_path):
    path = tmp_path / "a.csv"
    lines = [f"{0.5 * index},{z}" for index, z in enumerate(LINE_HEIGHTS)]
    for line_index in (0, 30, 59):
        changed_lines = lines.copy()
        changed_lines[line_index] = changed_lines[line_index].split(",")[0] + ",Err"
        path.write_text("x (um),z (um)\n" + "\n".join(changed_lines))
        with pytest.raises(
            FormatError, match=rf"line {line_index + 2} .*'Err' is not a number; --missing-value Err treats it"
        ):
            read_measurement(path)
        body = read_measurement(path, missing="interpolate", missing_value="Err")
        assert body.heights.size == (60 if line_index == 30 else 59)


@pytest.mark.parametrize("count", [2, 30])
@pytest.mark.parametrize("first_line", [0, 20, 60])
@pytest.mark.parametrize("cells", ["{z}", "{x},{z}"])
def test_lines_of_repeated_words_are_not_read_as_header_or_footer(tmp_path, cells, first_line, count):
    """Words that are repeated from line to line belong to neither a header nor a footer."""
    path = tmp_path / "a.csv"
    lines = [cells.format(x=0.5 * index, z=z) for index, z in enumerate(LINE_HEIGHTS)]
    lines[first_line:first_line] = [
        cells.format(x="Err", z="Err" if cells == "{z}" else index) for index in range(count)
    ]
    path.write_text("\n".join(lines))
    with pytest.raises(FormatError, match=r"'Err' is not a number; --missing-value Err treats it"):
        read_measurement(path, unit="um")


def test_rows_of_dashes_between_numbers_are_read_as_missing_points(tmp_path):
    path = tmp_path / "a.txt"
    lines = [f"{z}" for z in LINE_HEIGHTS]
    path.write_text("z (um)\n" + "\n".join([*lines[:20], "---", "---", "---", *lines[20:]]))
    body = read_measurement(path, spacing="0.5 um", missing="mask")
    assert np.flatnonzero(body.missing).tolist() == [20, 21, 22]


def test_codes_for_missing_points_are_reported_and_masked_by_the_missing_value_option(tmp_path):
    path = tmp_path / "a.csv"
    for code in ("-9999", "-32768", "99999.0", "0.000"):
        body = [f"{0.5 * index},{code if index in (7, 8, 33) else z + 500}" for index, z in enumerate(LINE_HEIGHTS)]
        path.write_text("x (um),z (um)\n" + "\n".join(body))
        reading = read_with_interpretation(path)
        assert "repeated-extreme" in [caveat.name for caveat in reading.caveats]
        assert f"--missing-value {float(code):g}" in reading.caveats[0].remedy
        with pytest.warns(FormatWarning, match="repeated-extreme"):
            read_measurement(path)
        masked_reading = read_with_interpretation(path, missing_value=float(code), missing="mask", accept="tall")
        assert masked_reading.missing == 3
        assert np.flatnonzero(masked_reading.body.missing).tolist() == [7, 8, 33]
        assert not masked_reading.caveats
        assert read_with_interpretation(path, accept="repeated-extreme,tall").caveats == ()


def test_column_of_validity_flags_marks_missing_points(tmp_path):
    lines = [
        f"{0.5 * index};{-30 if index in (4, 5) else z};{int(index not in (4, 5))}"
        for index, z in enumerate(LINE_HEIGHTS)
    ]
    for head in ("X;Y;valid\n[um];[um];[1/0]", "x (um);z (um);Valid"):
        (tmp_path / "a.hfm").write_text("\n".join([head, *lines]))
        body = read_measurement(tmp_path / "a.hfm", missing="mask")
        assert np.flatnonzero(body.missing).tolist() == [4, 5]


def test_side_by_side_profiles_are_selected_by_the_columns_option(tmp_path):
    path = tmp_path / "a.csv"
    for end in (";", ""):
        lines = [
            f"{0.5 * index};{z};" + (f"{0.25 * index};{-z}" if index < 40 else end)
            for index, z in enumerate(LINE_HEIGHTS)
        ]
        path.write_text("x;y;x;y\num;um;um;um\n" + "\n".join(lines))
        assert read_measurement(path, columns=(0, 1)).heights.tolist() == LINE_HEIGHTS.tolist()
        second_profile = read_measurement(path, columns=(2, 3))
        assert second_profile.heights.tolist() == (-LINE_HEIGHTS[:40]).tolist()
        assert second_profile.spacing == 0.25
        assert read_scan_or_none(path) is None


def test_ambiguous_commas_are_rejected_unless_column_names_show_the_number_of_columns(tmp_path):
    lines = [f"{format_number(0.5 * index, True)},{format_number(z, True)}" for index, z in enumerate(LINE_HEIGHTS)]
    path = tmp_path / "a.csv"
    path.write_text("x (um),z (um)\n" + "\n".join(lines))
    assert read_measurement(path).heights.tolist() == LINE_HEIGHTS.tolist()
    path.write_text("\n".join(lines))
    assert read_scan_or_none(path, unit="um", spacing="0.5 um") is None


def test_titled_blocks_of_numbers_with_equal_widths_are_read_as_channels(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("\n".join(["Height", *format_rows(HEIGHTS), "Phase", *format_rows(2 * HEIGHTS)]))
    with pytest.raises(FormatError, match=r"contains the channels 0 \(Height\), 1 \(Phase\); choose one with"):
        read_measurement(path, unit="um", spacing="0.5 um")
    body = read_measurement(path, unit="um", spacing="9 um", channel="Phase")
    assert np.array_equal(body.heights, 2 * HEIGHTS)


def test_single_lines_of_numbers_below_titles_are_listed_as_channels(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("\n".join(f"Trace {index}\n{line}" for index, line in enumerate(format_rows(HEIGHTS))))
    with pytest.raises(
        FormatError,
        match=rf"contains the channels 0 \(Trace 0\), .*{NUM_ROWS - 1} \(Trace {NUM_ROWS - 1}\); choose one",
    ):
        read_measurement(path, unit="um", spacing="0.5 um")


def test_matrix_with_a_short_last_line_is_rejected(tmp_path):
    path = tmp_path / "a.txt"
    cells = [format_number(value) for value in HEIGHTS.ravel()]
    path.write_text("\n".join(" ".join(cells[index : index + 10]) for index in range(0, len(cells), 10)))
    with pytest.raises(FormatError, match=r"line 7 .* has fewer cells than the lines above it"):
        read_measurement(path, **MASK_AND_UNIT_OPTIONS, spacing="1 um")


def test_missing_unit_and_spacing_are_reported_in_one_message(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("\n".join(format_rows(HEIGHTS)))
    with pytest.raises(FormatError, match=r"unit.*spacing.*--unit um --spacing"):
        read_measurement(path)


def test_height_factor_and_pixel_size_of_a_header_are_applied(tmp_path):
    path = tmp_path / "a.txt"
    header = (
        f"h={NUM_ROWS} w={NUM_COLUMNS}\npixel size=5e-007 m\ndata unit=rad\nheight conversion factor (-> m)=2e-008\n"
    )
    path.write_text(header + "\n".join(format_rows(HEIGHTS, " ")))
    body = read_measurement(path)
    assert np.allclose(body.heights, 0.02 * HEIGHTS)
    assert body.spacing == pytest.approx((0.5, 0.5))
    with pytest.warns(FormatWarning, match="unit-not-needed"):
        read_measurement(path, unit="nm")


def test_description_of_a_file_states_its_layout_and_unit_and_number_of_points(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        "made by hand\nx (um);z (um)\n"
        + "\n".join(f"{0.5 * index};{z}" for index, z in enumerate(LINE_HEIGHTS))
        + "\nend\n"
    )
    reading = read_with_interpretation(path)
    record = reading.to_json_fields()
    assert record["layout"] == "positions and heights"
    assert record["points"] == [60]
    assert record["spacing_um"] == [0.5]
    assert record["heights"] == "column 1 (z (um))"
    assert (record["unit"], record["missing_points"], record["encoding"]) == ("um", 0, "ascii")
    assert (record["lines"], record["lines_above"], record["lines_below"]) == ([3, 62], 2, 1)
    assert str(reading).startswith(
        "positions and heights; 60 points; 0.5 µm apart; heights from column 1 (z (um)) in um; none missing"
    )


def test_map_written_in_any_format_is_read_with_equal_heights_and_spacing(tmp_path):
    surface = Surface(HEIGHTS, spacing=(2.0, 0.5))
    write_surface(surface, tmp_path / "a.csv")
    write_surface(surface, tmp_path / "a.npy")
    topography = pytest.importorskip("SurfaceTopography").Topography(
        HEIGHTS.T, physical_sizes=(0.5 * NUM_COLUMNS, 2.0 * NUM_ROWS), unit="µm"
    )
    topography.to_netcdf(str(tmp_path / "a.nc"))
    topography.to_matrix(str(tmp_path / "a.txt"))
    topography.to_gwy(str(tmp_path / "a.gwy"))
    topography.to_x3p(str(tmp_path / "a.x3p"))
    x, y = np.meshgrid(0.5 * np.arange(NUM_COLUMNS), 2.0 * np.arange(NUM_ROWS))
    np.savetxt(tmp_path / "a.xyz", np.c_[x.ravel(), y.ravel(), HEIGHTS.ravel()], header="x (um) y (um) z (um)")
    stream = io.StringIO()
    np.savetxt(stream, np.block([[np.nan, x[0]], [y[:, :1], HEIGHTS]]), fmt="%.4f", delimiter=";")
    (tmp_path / "b.csv").write_text(stream.getvalue())
    arguments = {"a.txt": {"unit": "um", "spacing": ("2 um", "0.5 um")}, "b.csv": {"unit": "um"}}
    for name in ("a.csv", "a.npy", "a.nc", "a.txt", "a.gwy", "a.x3p", "a.xyz", "b.csv"):
        body = read_scan_or_none(tmp_path / name, **arguments.get(name, {}))
        assert np.allclose(body.heights, HEIGHTS, atol=1e-6), name
        assert body.spacing == pytest.approx((2.0, 0.5)), name


@pytest.mark.parametrize("name", EXPORT_FORMATS)
def test_damaged_instrument_files_give_finite_heights_or_a_format_error(tmp_path, name):
    write, options, _ = EXPORT_FORMATS[name]
    source = np.random.default_rng(len(name))
    path = tmp_path / "a.txt"
    for index in range(60):
        file_bytes = bytearray(write().encode())
        for _ in range(2):
            fuzzing.scramble_bytes(source, file_bytes)
        path.write_bytes(file_bytes)
        # Only FormatError is caught: the test fails if the reader raises any other error.
        body = read_scan_or_none(path, **(options if index % 2 else {}))
        assert body is None or np.isfinite(body.heights).all()


def test_decimal_numbers_are_converted_with_correct_rounding(tmp_path):
    values = np.concatenate([random.normal(size=500) * 10.0 ** random.integers(-12, 3, 500), [1 / 3, 2**-40, 0.1]])
    for form in (repr, "{:.6f}".format, "{:.3e}".format, "{:.18e}".format):
        texts = [form(float(value)) for value in values]
        (tmp_path / "a.txt").write_text("\n".join(texts))
        body = read_scan_or_none(tmp_path / "a.txt", unit="um", spacing="100 um")
        assert body.heights.tolist() == [float(text) for text in texts]


def test_positions_are_accepted_as_uniform_if_deviations_are_within_rounding(tmp_path):
    path = tmp_path / "a.csv"
    for step, form in ((0.5, ".1f"), (0.156245, ".1f"), (0.156245, ".6f")):
        lines = [f"{step * index:{form}},{z}" for index, z in enumerate(np.tile(LINE_HEIGHTS, 20))]
        path.write_text("x (um),z (um)\n" + "\n".join(lines))
        assert read_measurement(path).spacing == pytest.approx(step, rel=1e-3)
    lines[500] = lines[500].replace(lines[500].split(",")[0], f"{step * 500 + 0.05:.6f}")
    path.write_text("x (um),z (um)\n" + "\n".join(lines))
    with pytest.raises(FormatError, match="is not uniform: point 500"):
        read_measurement(path)


# ---- Sizes, units and spacings in headers of all table layouts -------------------------------------------------------


def lines_in_table_shape(shape, heights):
    """Return the text lines of a map, or of its first profile, in a shape of table. Positions are 0.5 apart."""
    count, width = heights.shape
    if shape == "column":
        return [f"{value:.4f}" for value in heights.ravel()]
    if shape == "positions":
        return [f"{0.5 * index:.1f} {value:.4f}" for index, value in enumerate(heights.ravel())]
    if shape == "triplets":
        return [f"{0.5 * x:.1f} {0.5 * y:.1f} {heights[y, x]:.4f}" for y, x in np.ndindex(count, width)]
    if shape == "labelled":
        labels = "\t".join(["", *(f"{0.5 * x:.1f}" for x in range(width))])
        return [labels, *("\t".join([f"{0.5 * y:.1f}", line]) for y, line in enumerate(format_rows(heights)))]
    return format_rows(heights)


@pytest.mark.parametrize("shape", ["column", "positions", "triplets", "labelled", "matrix"])
@pytest.mark.parametrize("declaration", ["factor", "code", "unit", "spacing", "scale", "count"])
def test_declarations_in_a_header_apply_to_columns_and_matrices_and_point_lists(tmp_path, shape, declaration):
    heights = HEIGHTS.copy()
    heights[2, 3:5] = {"code": 77.25, "count": 0.0}.get(declaration, 1.0)
    line = {
        "factor": "Z factor: 0.001 um", "code": "Missing value: 77.25", "unit": "Z unit: nm",
        "scale": "Z scale: 500 nm", "spacing": "x spacing: 0.5 um\ny spacing: 0.5 um", "count": "Bad pixels: 0",
    }[declaration]  # fmt: skip
    has_positions = shape not in ("column", "matrix")
    unit = ("um", "nm") if declaration == "unit" else "um"
    options = {"unit": unit, "missing": "mask"}
    if not has_positions and declaration != "spacing":
        options["spacing"] = "0.5 um"
    path = tmp_path / "a.txt"
    path.write_text("\n".join([line, *lines_in_table_shape(shape, heights)]), encoding="utf-8")
    reading = read_with_interpretation(path, **options)
    body, is_profile = reading.body, shape in ("column", "positions")
    expected = heights.ravel() if is_profile else heights
    scale = {"factor": 1e-3, "unit": 1e-3}.get(declaration, 1.0)
    assert body.heights.shape == expected.shape
    assert np.atleast_1d(body.spacing) == pytest.approx(0.5)
    is_known = expected != 77.25
    assert np.allclose(body.heights[is_known], scale * expected[is_known], rtol=1e-12, atol=0)
    assert (body.missing is None) == (declaration != "code")
    if declaration == "code":
        assert np.array_equal(body.missing, ~is_known)
    assert ("scale" in [caveat.name for caveat in reading.caveats]) == (declaration == "scale")


@pytest.mark.parametrize("shape", ["triplets", "labelled"])
@pytest.mark.parametrize("line", ["Z unit: nm", "Heights in nm", "Height [nm]"])
def test_heights_and_positions_can_have_different_units(tmp_path, shape, line):
    path = tmp_path / "a.txt"
    path.write_text("\n".join([line, *lines_in_table_shape(shape, HEIGHTS)]))
    with pytest.raises(FormatError, match="the unit of its positions"):
        read_measurement(path)
    body = read_measurement(path, unit=("um", "nm"))
    assert body.spacing == pytest.approx((0.5, 0.5))
    assert np.allclose(body.heights, 1e-3 * HEIGHTS)


@pytest.mark.parametrize("declaration", ["x spacing: 0.4 um\ny spacing: 0.5 um", "Width: 9 um\nHeight: 3.5 um"])
@pytest.mark.parametrize("shape", ["triplets", "labelled"])
def test_positions_that_contradict_the_header_are_rejected(tmp_path, shape, declaration):
    path = tmp_path / "a.txt"
    path.write_text("\n".join([declaration, *lines_in_table_shape(shape, HEIGHTS)]))
    with pytest.raises(FormatError, match="but its positions"):
        read_measurement(path, unit="um")


@pytest.mark.parametrize(
    ("line", "factor"),
    [
        ("Z scale: 500 nm", None), ("Data Scale: 5 um", None), ("Height scaling [nm]: 20", None),
        ("Z scale: 2 nm/LSB", 2e-3), ("Z scale (-> m): 2e-9", 2e-3), ("Z scale: 2 nm per count", 2e-3),
        ("Z conversion scale: 2 nm", 2e-3), ("Height multiplier: 2 nm", 2e-3), ("Z scale (nm/count): 2", 2e-3),
    ],
)  # fmt: skip
def test_header_scale_multiplies_heights_only_if_the_header_line_describes_a_conversion(tmp_path, line, factor):
    path = tmp_path / "a.txt"
    path.write_text("\n".join([line, *format_rows(HEIGHTS)]))
    if factor is None:
        with pytest.raises(FormatError, match="the unit of its heights"):
            read_measurement(path, spacing="0.5 um")
        with pytest.warns(FormatWarning, match="scale"):
            body = read_measurement(path, unit="nm", spacing="0.5 um")
        assert not read_with_interpretation(path, unit="nm", spacing="0.5 um", accept="scale").caveats
    else:
        body = read_measurement(path, spacing="0.5 um")
    assert np.allclose(body.heights, (factor or 1e-3) * HEIGHTS, rtol=1e-12)


def test_positions_are_not_read_as_heights_if_the_spacing_is_declared(tmp_path):
    path = tmp_path / "a.txt"
    header_lines = ["# x spacing: 0.25 um", "# y spacing: 0.5 um"]
    for first_column in (0.5 * np.arange(NUM_ROWS), 3 + 0.5 * np.arange(NUM_ROWS)):
        path.write_text("\n".join([*header_lines, *format_rows(np.column_stack([first_column, HEIGHTS]))]))
        body = read_with_interpretation(path, unit="um", accept="tall").body
        assert np.array_equal(body.heights, HEIGHTS)
        assert body.spacing == (0.5, 0.25)
        assert "the first column removed: positions 0.5 um apart, as its header declares" in body.history
    for first_column in (
        np.arange(NUM_ROWS),
        1 + np.arange(NUM_ROWS),
        0.3 * np.arange(NUM_ROWS),
        -0.5 * np.arange(NUM_ROWS),
    ):
        path.write_text("\n".join([*header_lines, *format_rows(np.column_stack([first_column, HEIGHTS]))]))
        with pytest.raises(FormatError, match="first column has numbers with equal steps"):
            read_measurement(path, unit="um")
    path.write_text("\n".join([*header_lines, *format_rows(np.vstack([0.25 * np.arange(NUM_COLUMNS), HEIGHTS]))]))
    with pytest.raises(FormatError, match="first row has numbers with equal steps"):
        read_measurement(path, unit="um")


def test_short_row_above_a_matrix_is_rejected_unless_the_row_states_the_matrix_size(tmp_path):
    path = tmp_path / "a.txt"
    for count in (1, 2):
        lines = format_rows(HEIGHTS)
        lines[:count] = [line.rsplit("\t", 1)[0] for line in lines[:count]]
        path.write_text("\n".join(lines))
        with pytest.raises(FormatError, match=r"line 1 .* has 8 cells, but most lines have 9"):
            read_measurement(path, unit="um", spacing="0.5 um")
    path.write_text("\n".join([f"{NUM_COLUMNS} {NUM_ROWS}", *format_rows(HEIGHTS, " ")]))
    body = read_measurement(path, unit="um", spacing="0.5 um")
    assert np.array_equal(body.heights, HEIGHTS)
    assert f"line 1 ('{NUM_COLUMNS} {NUM_ROWS}') skipped as a count or a size" in body.history


def test_counts_of_missing_points_are_not_read_as_codes_for_missing_points(tmp_path):
    path, options = tmp_path / "a.txt", {"unit": "um", "spacing": "0.5 um", "missing": "mask"}
    integer_heights = np.round(20 * HEIGHTS)
    number = int(integer_heights[integer_heights > 0][0])
    for line, is_code in (
        (f"Bad pixels: {number}", False), (f"Missing points: {number}", False), (f"Invalid data: {number}", False),
        (f"No data value: {number}", True), (f"Missing value = {number}", True), (f"Bad pixel code: {number}", True),
    ):  # fmt: skip
        path.write_text("\n".join([line, *format_rows(integer_heights, form=".0f")]))
        is_missing = read_scan_or_none(path, **options).missing
        assert (is_missing is not None) == is_code, line
        assert not is_code or np.array_equal(is_missing, integer_heights == number)
    heights_with_missing_code = np.where(np.isnan(HEIGHTS_WITH_HOLES), 32767, HEIGHTS_WITH_HOLES)
    path.write_text("\n".join(["No data: 32767", *format_rows(heights_with_missing_code)]))
    assert np.array_equal(read_scan_or_none(path, **options).missing, np.isnan(HEIGHTS_WITH_HOLES))


def test_column_of_flags_is_rejected_if_its_name_does_not_define_the_flags(tmp_path):
    path, flagged_points = tmp_path / "a.txt", (4, 5, 33)
    for name, flag, is_read in (
        ("flag", 1, False), ("status", 0, False), ("z ok [0/1]", 1, False), ("invalid", 1, True), ("valid", 0, True),
        ("flag [1/0]", 0, True),
    ):  # fmt: skip
        body = [
            f"{0.5 * index};{z};{flag if index in flagged_points else 1 - flag}" for index, z in enumerate(LINE_HEIGHTS)
        ]
        path.write_text("\n".join([f"x (um);z (um);{name}", *body]))
        if is_read:
            assert np.flatnonzero(read_measurement(path, missing="mask").missing).tolist() == list(flagged_points)
        else:
            with pytest.raises(FormatError, match=r'name the column "valid" .* or "invalid"'):
                read_measurement(path, missing="mask")
    for value in (0, 1):
        path.write_text(
            "\n".join(["x (um);z (um);flag", *(f"{0.5 * index};{z};{value}" for index, z in enumerate(LINE_HEIGHTS))])
        )
        assert read_measurement(path).heights.tolist() == LINE_HEIGHTS.tolist()


def table_with_words(separator=",", words=("OK", "NG"), word_column=2, names=True):
    """Return a profile with the heights LINE_HEIGHTS and a column of two words, the second at points 4, 5 and 33."""
    lines = [["x(um)", "z(um)"]] * names + [[f"{0.5 * index:.1f}", f"{z}"] for index, z in enumerate(LINE_HEIGHTS)]
    flags = ["judgment"] * names + [words[index in (4, 5, 33)] for index in range(LINE_HEIGHTS.size)]
    return "\n".join(
        separator.join([*cells[:word_column], word, *cells[word_column:]])
        for cells, word in zip(lines, flags, strict=True)
    )


@pytest.mark.parametrize("separator", [",", ";", "\t", " ", ", "])
@pytest.mark.parametrize("words", [("OK", "NG"), ("pass", "fail"), ("", "spike"), ("A1", "B2")])
@pytest.mark.parametrize("word_column", [0, 1, 2])
def test_error_message_states_which_table_column_contains_words(tmp_path, separator, words, word_column):
    if separator == " " and not words[0]:
        words = ("nan", words[1])
    path = tmp_path / "a.csv"
    path.write_text(table_with_words(separator, words, word_column))
    numbers = ",".join(str(index) for index in range(3) if index != word_column)
    with pytest.raises(
        FormatError, match=rf"column {word_column} \(judgment\).*'{words[1]}' \(3\).*--columns {numbers}\)"
    ):
        read_measurement(path)
    profile = read_measurement(path, columns=[index for index in range(3) if index != word_column])
    assert profile.heights.tolist() == LINE_HEIGHTS.tolist()
    assert any("ignored" in step for step in profile.history)
    masked_profile = read_measurement(path, missing_value=words[1], missing="mask")
    assert np.flatnonzero(masked_profile.missing).tolist() == [4, 5, 33]


@pytest.mark.parametrize("words", [("OK", "OK"), ("OK", ""), ("OK", "NG")])
def test_columns_option_can_exclude_a_column_of_words_from_a_table_without_column_names(tmp_path, words):
    path = tmp_path / "a.txt"
    path.write_text(table_with_words(";", words, names=False))
    with pytest.raises(FormatError, match=r"words in column 2: 'OK'"):
        read_measurement(path, unit="um")
    assert read_measurement(path, unit="um", columns=[0, 1]).heights.tolist() == LINE_HEIGHTS.tolist()


def test_column_that_contains_both_heights_and_words_is_not_read_as_flags(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(table_with_words(",", ("Err", "Err")))
    assert read_measurement(path, columns=[0, 1], missing_value="Err").heights.tolist() == LINE_HEIGHTS.tolist()


def test_word_in_the_last_line_of_a_table_is_rejected_because_it_is_not_a_number(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(["x (um),z (um)", *(f"{0.5 * index},{z}" for index, z in enumerate(LINE_HEIGHTS)), "7.0,Err"])
    )
    with pytest.raises(FormatError, match="'Err' is not a number"):
        read_measurement(path)


def test_columns_option_can_exclude_a_column_of_flags_without_a_known_meaning(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join(["x (um),z (um),flag", *(f"{0.5 * index},{z},{index % 2}" for index, z in enumerate(LINE_HEIGHTS))])
    )
    with pytest.raises(FormatError, match=r"--columns"):
        read_measurement(path)
    assert read_measurement(path, columns=[0, 1]).heights.tolist() == LINE_HEIGHTS.tolist()


@pytest.mark.parametrize("count", ["inf", "nan", "1e999", "-3", "2.5", "1e12", "abc", "", "0"])
@pytest.mark.parametrize(
    ("name", "header_key"),
    [("sdf", "NumPoints = "), ("sdf", "NumProfiles = "), ("wyko", "X Size\t"), ("wyko", "Y Size\t"),
     ("esri", "ncols "), ("esri", "nrows "), ("spip", "# x-pixels = "), ("spip", "# y-pixels = ")],
)  # fmt: skip
def test_header_point_counts_that_are_not_whole_numbers_are_rejected(tmp_path, name, header_key, count):
    write, options, _ = EXPORT_FORMATS[name]
    lines = [f"{header_key}{count}" if line.startswith(header_key) else line for line in write().split("\n")]
    (tmp_path / "a.txt").write_text("\n".join(lines))
    with pytest.raises(FormatError) as error_info:
        read_measurement(tmp_path / "a.txt", **options)
    assert "cannot convert" not in str(error_info.value)


@pytest.mark.parametrize(
    ("line", "spacing"),
    [
        ("Pitch,0.25,um", 0.25), ("Pitch;0,25;µm", 0.25), ('"Pitch","0.25","um"', 0.25), ("Pitch\t0.00025\tmm", 0.25),
        ("Pitch,0,25,um", None), ("Pitch,0.25,um,0.5", None), ("Pitch,0.25,Standard", None),
    ],
)  # fmt: skip
def test_spacing_whose_unit_is_in_a_separate_cell_is_read(tmp_path, line, spacing):
    path = tmp_path / "a.csv"
    path.write_text("\n".join([line, "Unit,um", *(f"{value:.4f}" for value in LINE_HEIGHTS)]), encoding="utf-8")
    if spacing is None:
        with pytest.raises(FormatError, match="spacing"):
            read_measurement(path)
    else:
        profile = read_scan_or_none(path)
        assert profile.spacing == pytest.approx(spacing)
        assert np.array_equal(profile.heights, LINE_HEIGHTS)


def test_wsxm_amplitudes_along_x_and_y_are_read_as_the_map_size(tmp_path):
    path = tmp_path / "a.txt"
    header = "WSxM file copyright UAM\nWSxM ASCII Matrix file\nX Amplitude: 4500 nm\nY Amplitude: 3.5 µm\n\n"
    path.write_text(header + "\n".join(format_rows(HEIGHTS)), encoding="utf-8")
    surface = read_scan_or_none(path, unit="nm")
    assert surface.spacing == pytest.approx((0.5, 0.5))
    assert surface.heights == pytest.approx(1e-3 * HEIGHTS)


@pytest.mark.parametrize("line", ["Stylus,Radius: 2.5 µm", "Tip radius (µm): 2.5", "Stylus radius;2,5 µm"])
def test_tip_radius_in_a_header_is_added_to_the_history(tmp_path, line):
    path = tmp_path / "a.csv"
    path.write_text(
        "\n".join([line, "x (µm);z (µm)", *(f"{0.5 * index};{z}" for index, z in enumerate(LINE_HEIGHTS))]), "utf-8"
    )
    assert "its header gives a tip radius of 2.5 µm (--tip)" in read_scan_or_none(path).history


@pytest.mark.parametrize("spacing", [0.25, 0.333, 0.2, 1.26])
def test_rounded_grid_positions_are_read_if_the_spacing_exceeds_two_units_of_the_last_digit(tmp_path, spacing):
    path = tmp_path / "a.xyz"
    order = np.random.default_rng(5).permutation(HEIGHTS.size)
    y, x = (spacing * item.ravel()[order] for item in np.mgrid[:NUM_ROWS, :NUM_COLUMNS])
    z = HEIGHTS.ravel()[order]
    for digits_of_position, can_be_read in ((1, True), (0, spacing > 2)):
        lines = (f"{a:.{digits_of_position}f} {b:.{digits_of_position}f} {c}" for a, b, c in zip(x, y, z, strict=True))
        path.write_text("\n".join(lines))
        if can_be_read:
            surface = read_scan_or_none(path, unit="um")
            assert np.array_equal(surface.heights, HEIGHTS)
            assert surface.spacing == pytest.approx((spacing, spacing), abs=0.1 / (NUM_ROWS - 1))
        else:
            with pytest.raises(FormatError):
                read_measurement(path, unit="um")


def test_points_that_deviate_from_a_grid_by_more_than_rounding_are_rejected(tmp_path):
    path = tmp_path / "a.xyz"
    positions = np.array([0.0, 0.25, 0.5, 0.9, 1.0, 1.25, 1.5])
    y, x = np.meshgrid(positions, positions, indexing="ij")
    path.write_text(
        "\n".join(f"{a:.2f} {b:.2f} 1.{index}" for index, (a, b) in enumerate(zip(x.flat, y.flat, strict=True)))
    )
    with pytest.raises(FormatError, match="not on a grid"):
        read_measurement(path, unit="um")


def test_status_column_of_an_olympus_map_is_not_read_as_heights(tmp_path):
    path = tmp_path / "a.csv"
    lines = olympus_text().splitlines()
    names_index = next(index for index, line in enumerate(lines) if line.startswith("DataLine"))
    lines[names_index] += ",Status"
    lines_with_status = [*lines[: names_index + 1], *(f"{line},1" for line in lines[names_index + 1 :])]
    path.write_text("\n".join(lines_with_status))
    path_without_status = tmp_path / "b.csv"
    path_without_status.write_text(olympus_text())
    assert np.array_equal(
        read_scan_or_none(path, missing="mask").heights, read_scan_or_none(path_without_status, missing="mask").heights
    )
    path.write_text("\n".join([*lines_with_status[:-1], lines_with_status[-1][:-1] + "0"]))
    with pytest.raises(FormatError, match="flags of unknown meaning"):
        read_measurement(path, missing="mask")


IMPOSSIBLE_NUMBERS = ("0", "-1", "-1e-7", "nan", "inf", "1e400", "1e-400", "1e308", "1e-308", "0x10", "")
LINES_WITH_HEADER_NUMBERS = [
    ("sdf", {}, "Xscale = 5.0E-7", "Xscale = "), ("sdf", {}, "Yscale = 5.0E-7", "Yscale = "),
    ("sdf", {}, "Zscale = 1.0E-6", "Zscale = "), ("spip", {}, "# x-length = 4500", "# x-length = "),
    ("spip", {"unit": "# bit2nm = 1000"}, "# bit2nm = 1000", "# bit2nm = "),
    ("wyko", {"real": 0}, "Wavelength\t7\t4\t500", "Wavelength\t7\t4\t"),
    ("wyko", {"real": 0}, "Mult\t7\t4\t2", "Mult\t7\t4\t"),
    ("wyko", {"aspect": True}, "Aspect\t7\t4\t1", "Aspect\t7\t4\t"),
    ("esri", {}, "cellsize 0.5", "cellsize "), ("keyence", {}, '"XY Calibration","500.000"', '"XY Calibration","'),
    ("zygo", {}, "0 0.5 6.3e-07 0.08 1 0 5e-07", "0 0.5 6.3e-07 0.08 1 0 "),
    ("gwyddion", {}, "# Width: 4.500 µm", "# Width: "),
]  # fmt: skip


@pytest.mark.parametrize("number", IMPOSSIBLE_NUMBERS)
@pytest.mark.parametrize(
    ("name", "variant", "line", "start"), LINES_WITH_HEADER_NUMBERS, ids=lambda item: str(item)[:12]
)
def test_impossible_numbers_in_headers_of_instrument_files_are_rejected(tmp_path, name, variant, line, start, number):
    write, options, _ = EXPORT_FORMATS[name]
    text, quote, unit = write(**variant), '"' * (name == "keyence"), " µm" * (name == "gwyddion")
    assert line in text
    (tmp_path / "a.txt").write_text(text.replace(line, start + number + quote + unit), encoding="utf-8")
    options = {
        option_name: value for option_name, value in options.items() if name != "esri" or option_name != "spacing"
    }
    with pytest.raises(FormatError) as error_info:
        read_measurement(tmp_path / "a.txt", **options)
    assert "\n" not in str(error_info.value)
    label = start.strip("# ").split("=")[0].split("\t")[0].split('"')[-3:][0].split(" 6.3")[0].strip(" :")
    if number and name not in ("zygo", "gwyddion"):
        assert label in str(error_info.value)


@pytest.mark.parametrize("number", ["0", "-0.001", "1e-400", "1e400", "0x10", "nan", "inf"])
def test_impossible_height_factor_in_a_header_is_rejected_by_a_message_that_quotes_the_line(tmp_path, number):
    line = f"Z conversion factor (um): {number}"
    (tmp_path / "a.txt").write_text("\n".join([line, "pixel size: 0.5 um", *format_rows(HEIGHTS)]))
    with pytest.raises(FormatError, match=rf"in its header line '{re.escape(line)}'"):
        read_measurement(tmp_path / "a.txt")


@pytest.mark.parametrize("number", ["0", "-0.5", "1e-400", "1e400", "0x10", "nan", "inf"])
@pytest.mark.parametrize("line", ["pixel size: {} um", "dx: {} um\ndy: 0.5 um", "Width: {} um\nHeight: 3.5 um"])
def test_impossible_length_in_a_header_is_rejected_by_a_message_that_quotes_the_line(tmp_path, line, number):
    header = line.format(number)
    (tmp_path / "a.txt").write_text("\n".join([header, *format_rows(HEIGHTS)]))
    with pytest.raises(FormatError, match=rf"header line '{re.escape(header.splitlines()[0])}'"):
        read_measurement(tmp_path / "a.txt", unit="um")


def test_header_lengths_that_are_irrelevant_to_a_profile_may_be_zero(tmp_path):
    header = "dx: 0.5 um\ndy: 0 um\nTip radius: 0 um\nUnit: um"
    (tmp_path / "a.txt").write_text("\n".join([header, *(f"{z:.4f}" for z in LINE_HEIGHTS)]))
    profile = read_scan_or_none(tmp_path / "a.txt", spacing="0.5 um")
    assert profile.heights.tolist() == LINE_HEIGHTS.tolist()
    assert not any("tip radius" in step for step in profile.history)


def test_infinite_code_for_missing_points_matches_only_infinite_heights(tmp_path):
    heights = np.where(np.isnan(HEIGHTS_WITH_HOLES), np.inf, HEIGHTS_WITH_HOLES)
    np.save(tmp_path / "a.npy", heights)
    options = {"unit": "um", "spacing": "0.5 um", "missing": "mask", "missing_value": "inf"}
    assert np.array_equal(read_scan_or_none(tmp_path / "a.npy", **options).missing, np.isnan(HEIGHTS_WITH_HOLES))


@pytest.mark.parametrize("name", ["zygo", "triplets"])
def test_point_listed_twice_is_rejected_unless_both_heights_are_equal(tmp_path, name):
    write, options, _ = EXPORT_FORMATS[name]
    lines = [line for line in write().splitlines() if line != "#" or name == "triplets"]
    if name == "zygo":
        lines.insert(13, "#")
    path = tmp_path / "a.xyz"
    path.write_text("\n".join([*lines, lines[-1]]))
    surface = read_scan_or_none(path, **options)
    assert np.allclose(surface.heights[~surface.missing], HEIGHTS_WITH_HOLES[~surface.missing])
    path.write_text("\n".join([*lines, lines[-1].rpartition(" ")[0] + " 77.0"]))
    with pytest.raises(FormatError, match=r"lists more than one point at .*with heights"):
        read_measurement(path, **options)


def test_small_point_list_that_declares_a_huge_map_is_rejected(tmp_path):
    path, size_line = tmp_path / "a.xyz", f"0 0 {NUM_COLUMNS} {NUM_ROWS}"
    path.write_text(zygo_text().replace(size_line, "0 0 9000 9000"))
    with pytest.raises(FormatError, match="declares in line 4 a map of 9000 rows of 9000 points"):
        read_measurement(path, missing="mask")
    path.write_text("1e-5 1e308 1\n1e-5 1e-5 2\n1e7 1e308 3\n-1e308 -1e308 4\n")
    with pytest.raises(FormatError, match="lists a point without a usable position along x"):
        read_measurement(path, unit="um", missing="mask")


def test_large_map_that_omits_a_third_of_its_points_is_read(tmp_path):
    shape = (1100, 1000)  # large enough to be rejected if only a few points were listed
    rows, columns = np.nonzero(random.random(shape) > 0.33)
    points = "\n".join(f"{x} {y} {(x * y) % 7}.5" for x, y in zip(columns.tolist(), rows.tolist(), strict=True))
    head = zygo_text().split("#")[0].replace(f"0 0 {NUM_COLUMNS} {NUM_ROWS}", f"0 0 {shape[1]} {shape[0]}")
    (tmp_path / "a.xyz").write_text(f"{head}#\n{points}\n#\n")
    surface = read_scan_or_none(tmp_path / "a.xyz", missing="mask")
    assert surface.heights.shape == shape
    assert 0.3 < surface.missing.mean() < 0.36


@pytest.mark.parametrize("name", ['VK-"a","5","nm"', "a\0b", "\udcff", "# x: 5 nm", "ImageDataCsv"])
@pytest.mark.parametrize("extension", ["csv", "npy"])
def test_written_scans_are_read_back_exactly_whatever_their_history_contains(tmp_path, name, extension):
    histories = ((f"read from {name}",), (name, "5 nm", "7 nm", "9 nm", "3 um"))
    for index, history in enumerate(histories):
        surface = Surface(HEIGHTS, spacing=(0.5, 0.25), history=history)
        profile = Profile(LINE_HEIGHTS, spacing=0.25, history=history)
        for body, write in ((surface, write_surface), (profile, write_profile)):
            path = tmp_path / f"{index}{type(body).__name__}.{extension}"
            write(body, path)
            body_read = read_scan_or_none(path)
            assert np.array_equal(body_read.heights, body.heights)
            assert body_read.spacing == body.spacing


@pytest.mark.parametrize(("word", "quoted_word"), [("#DIV/0!", "'#DIV/0!'"), ("(bad)", "'(bad)'"), ("1\t2", r"'1\t2'")])
def test_recommended_missing_value_can_be_pasted_into_a_shell(tmp_path, word, quoted_word):
    rows = format_rows(HEIGHTS, ";")
    first_cell, _, *other_cells = rows[3].split(";")
    rows[3] = ";".join([first_cell, word, *other_cells])
    (tmp_path / "a.csv").write_text("\n".join(rows))
    with pytest.raises(FormatError, match=rf"--missing-value {re.escape(quoted_word)} treats it"):
        read_measurement(tmp_path / "a.csv", unit="um", spacing="0.5 um")


@pytest.mark.parametrize(
    ("word", "advice"),
    [("03. Okt", "converted numbers to dates"), ("2024-10-03", "converted numbers to dates"),
     ("3-Oct", "converted numbers to dates"), ("12:30", "converted numbers to dates"),
     ("1/10", "converted numbers to dates"),
     ("(181.481)", "write negative numbers with a minus sign"), ("3460-", "write negative numbers with a minus sign"),
     ("[0.5", "write the numbers without brackets")],
)  # fmt: skip
def test_number_in_another_notation_is_not_recommended_as_a_code_for_missing_points(tmp_path, word, advice):
    rows = format_rows(HEIGHTS, ";")
    rows[3] = ";".join([word, *rows[3].split(";")[1:]])
    (tmp_path / "a.csv").write_text("\n".join(rows))
    with pytest.raises(FormatError, match=advice) as error_info:
        read_measurement(tmp_path / "a.csv", unit="um", spacing="0.5 um")
    assert "--missing-value" not in str(error_info.value)


def test_wyko_file_with_two_blocks_of_heights_is_rejected(tmp_path):
    text = wyko_text(intensity=False)
    block = text[text.index("RAW_DATA") :]
    (tmp_path / "a.asc").write_text(text + block.replace("RAW_DATA", "OPD"))
    with pytest.raises(FormatError, match="has several blocks of heights, RAW_DATA and OPD; keep one block"):
        read_measurement(tmp_path / "a.asc", missing="mask")
