"""Tests of spacings, factors and units in header lines: they are applied, applied with a caveat, or rejected."""

import numpy as np
import pytest
from stiction import FormatError
from stiction.surfaces.measured.reading import read_with_interpretation

RNG = np.random.default_rng(7)
PROFILE = np.round(np.cumsum(RNG.normal(size=120)) / 50, 4)
ROWS = "".join(f"{at / 2000:.4f};{z}\n" for at, z in enumerate(PROFILE))  # columns of x (mm) and heights (µm)
MAP = np.round(np.cumsum(np.cumsum(RNG.normal(size=(40, 40)), axis=0), axis=1)[::3, ::2] / 100, 4)
PROFILE_TEXT = "".join(f"{z:.4f}\n" for z in PROFILE)
MAP_TEXT = "".join("\t".join(f"{z:.4f}" for z in row) + "\n" for row in MAP)


@pytest.fixture
def read_text(tmp_path):
    """Return a function that reads a profile or surface from a text."""

    def read(text, **options):
        (tmp_path / "a.txt").write_text(text, encoding="utf-8")
        return read_with_interpretation(tmp_path / "a.txt", **options)

    return read


def get_error_message(read_text, text, **options):
    with pytest.raises(FormatError) as error_info:
        read_text(text, **options)
    return str(error_info.value)


def read_caveat_names(reading):
    return [caveat.name for caveat in reading.caveats]


# ---- Spacings -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    ["Spacing: 0.5 um", "Point spacing;0,5;µm", "Step size = 0.5 um", "Sampling interval (um): 0.5", "dx = 5e-7 m",
     "Resolution: 0.5 um per pixel", "X step: 0.5 um (nominal)", "Punktabstand: 0,5 µm", "Data interval = 500 nm/pt",
     "Increment: 0.5 um", "Pixelgröße: 0,5 µm"],
)  # fmt: skip
def test_header_line_that_can_only_mean_the_spacing_is_used_without_a_caveat(read_text, line):
    reading = read_text(f"{line}\nUnit: um\n{PROFILE_TEXT}")
    assert reading.body.spacing == pytest.approx(0.5)
    assert not reading.caveats


@pytest.mark.parametrize(
    "line",
    [
        "Pitch: 0.5 um",
        "Step: 0.5 um",
        "Interval: 0.5 um",
        "Scan pitch 0.5 um",
        "Abstand: 0,5 µm",
        "Sample spacing 3 mm",
    ],
)
def test_header_length_that_may_be_the_specimen_length_adds_a_caveat_unless_the_spacing_is_given(read_text, line):
    reading = read_text(f"{line}\nUnit: um\n{PROFILE_TEXT}")
    assert read_caveat_names(reading) == ["spacing"]
    assert repr(line) in reading.caveats[0].text
    reading = read_text(f"{line}\nUnit: um\n{PROFILE_TEXT}", spacing="2 um")
    assert reading.body.spacing == 2.0
    assert not reading.caveats


@pytest.mark.parametrize(
    "line",
    ["Measurement spacing 2 mm between tracks", "Scan step 0.2 mm in y", "Interval 2.5 mm between tracks",
     "Spacing: 0.5 um (between tracks)", "Step 0.18 um high", "Spacing 2 mm, 20 tracks apart"],
)  # fmt: skip
def test_header_line_with_other_words_after_a_length_is_not_used_as_spacing(read_text, line):
    message = get_error_message(read_text, f"{line}\nUnit: um\n{PROFILE_TEXT}")
    assert "contains heights only; give the spacing" in message
    assert f"its header line {line!r}" in message
    assert read_text(f"{line}\nUnit: um\n{PROFILE_TEXT}", spacing="0.5 um").body.spacing == 0.5


@pytest.mark.parametrize("line", ["Resolution 0.1 um/digit", "Resolution: 10 nm/bit", "Resolution: 5 nm per LSB"])
def test_height_resolution_in_a_header_is_not_used_as_spacing(read_text, line):
    assert "contains heights only" in get_error_message(read_text, f"{line}\nUnit: um\n{PROFILE_TEXT}")


TWO_SPACINGS = [
    "Pixel size: 0.5 µm x 10 µm", "Pixel size: 0.5 x 10 um", "Pixel size (um): 0.5 10", "Pixel size\t0.5 um\t10 um",
    "Spacing: 0.5 µm, 10 µm", "Increment: 0.5 um; 10 um", "Pixelgröße: 0,5 µm × 10 µm", "Pixel size: 0.5,10 um",
    "Pixel size 0.5 um by 10 um",
]  # fmt: skip
HEADER_LINES_WITH_TWO_SPACINGS = [
    "pixel size: 0.5 um in x, 10 um in y", "Step size: 0.5 um (x), 10 um (y)", "Pixel size: 10 um in y, 0.5 um in x",
    "Resolution: 0.5 um/px, 10 um/line", "Pitch X: 0.5 um; Pitch Y: 10 um", "dx = 0.5 um dy = 10 um",
    "X step: 0.5 um\nRow step: 10 um", "Sampling interval: 0.5 µm\nProfile distance: 10 µm",
    "Punktabstand: 0,5 µm\nZeilenabstand: 10 µm",
]  # fmt: skip


@pytest.mark.parametrize("line", TWO_SPACINGS)
def test_two_header_spacings_without_axes_are_rejected_unless_the_option_gives_both_spacings(read_text, line):
    text = f"{line}\nZ unit: um\n{MAP_TEXT}"
    assert f"its header line {line!r} does not name the axes of its spacings" in get_error_message(read_text, text)
    message = get_error_message(read_text, text, spacing="0.5 um")
    assert f"declares two spacings in its header line {line!r}, which differ from the option spacing, 0.5" in message
    assert read_text(text, spacing=("10 um", "0.5 um")).body.spacings == (10.0, 0.5)


@pytest.mark.parametrize("line", HEADER_LINES_WITH_TWO_SPACINGS)
def test_two_header_spacings_with_axis_names_are_assigned_to_these_axes(read_text, line):
    reading = read_text(f"{line}\nZ unit: um\n{MAP_TEXT}")
    assert reading.body.spacings == pytest.approx((10.0, 0.5))
    assert not reading.caveats


@pytest.mark.parametrize("line", ["Pixel size: 0.5 µm x 0.5 µm", "Pixel size: 500 nm x 0.5 um", "Pixel size: 0.5 um"])
def test_equal_header_spacings_along_both_axes_are_used(read_text, line):
    assert read_text(f"{line}\nZ unit: um\n{MAP_TEXT}").body.spacings == pytest.approx((0.5, 0.5))


@pytest.mark.parametrize(
    "lines", ["Track distance = 0.002 mm\nPixel size: 0.5 um\n", "Pixel size: 0.5 um\ndy = 2 um\n"]
)
def test_pixel_size_that_contradicts_the_spacing_of_rows_is_not_used(read_text, lines):
    assert "contains no spacing" in get_error_message(read_text, lines + MAP_TEXT, unit="um")
    options = {"unit": "um", "spacing": ("2 um", "0.5 um")}
    assert read_text(lines + MAP_TEXT, **options).body.spacings == pytest.approx((2.0, 0.5))


@pytest.mark.parametrize("lines", ["Pixel size: 2 um\nLine spacing: 2 um\n", "Pixel size: 2 um\ndy = 0.002 mm\n"])
def test_pixel_size_that_agrees_with_the_spacing_of_rows_is_used(read_text, lines):
    assert read_text(lines + MAP_TEXT, unit="um").body.spacings == pytest.approx((2.0, 2.0))


# ---- Factors --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "line",
    ["Scale factor 1.0e-03", "Factor: 0.001", "Heights multiplied by 1000",
     "Values have been divided by 1000", "Sensitivity: 0.25 um/V", "Calibration: 2.5 V per µm", "z ×10⁻³", "z*1000",
     "values x 1000", "Scaling: 1000", "Resolution: 10 nm/bit", "z·10³", "10^-3", "Scale: 0.001", "Gain: 1000",
     "values times 1000", "facteur: 0.001", "係数 0.001", "коэффициент 0.001", "exponent: -3", "1 digit = 0.01 um",
     "1 LSB = 0.5 nm", "Counts per um: 100", "Height per gray level: 0.02 um", "normalized by 0.8 um", "in 10 nm",
     "units of 0.1 um", "in thousandths of um", "normalised to 1", "z times 3", "LSB: 0.5 nm",
     "add_offset 0 scale_factor 0.001", "times 1e3", "z/1000", "Z: 10 nm per step",
     "Conversion 0.01", "Umrechnung: 0.001", "Vertical magnification 0.001", "Überhöhung 10", "Z LSB: 0.01",
     "z = 0.01 * value", "height = counts / 100",
     "Vergrößerung 10:1", "Vertical scale 1000:1", "Exponent: 1", "Z exponent: 1.0", "z x0.1 (um)",
     "z x5", "height x 0.5"],
)  # fmt: skip
def test_header_line_that_describes_a_height_factor_in_words_adds_a_caveat(read_text, line):
    reading = read_text(f"{line}\n{PROFILE_TEXT}", unit="um", spacing="0.5 um")
    assert read_caveat_names(reading) == ["scale"]


@pytest.mark.parametrize("factor", ["1.0e-03", "1.0e+03"])
def test_height_factor_in_a_line_above_a_matrix_adds_a_caveat(read_text, factor):
    reading = read_text(f"z =\n\n   {factor} *\n\n{MAP_TEXT}", unit="um", spacing="0.5 um")
    assert read_caveat_names(reading) == ["scale"]
    assert reading.body.heights.tolist() == MAP.tolist()


@pytest.mark.parametrize(
    "line",
    ["Exponent: 0", "z x1", "z x 1.0 (um)",
     "Factor: 1", "Objective: x100", "Magnification x1000", "1024 x 1000 points", "Form factor 0.5", "Speed: 2 mm/s",
     "Pixel size: 0.5 um x 0.5 um", "Feedback gain: 0.3", "Gain: 45 dB", "Scale: 1", "Speed: 0.5 mm/s in 2 mm", "100",
     "Scan in 0.5 um steps", "Sampling times 3", "Conversion of 12 files", "Maßstab 1:1", "Vertical magnification 1",
     "Scaled to 1:1", "divided by 1.0", "values times 1", "# history: multiplied by 2 um, as declared in the file"],
)  # fmt: skip
def test_header_factor_that_does_not_apply_to_heights_has_no_caveat(read_text, line):
    assert not read_text(f"{line}\n{MAP_TEXT}", unit="um", spacing="0.5 um").caveats


def test_height_unit_with_a_factor_of_one_is_read_without_a_caveat(read_text):
    reading = read_text(f"heights in 1 nm\n{MAP_TEXT}", spacing="0.5 um")
    assert (reading.unit, reading.caveats) == ("nm", ())


# ---- Units ----------------------------------------------------------------------------------------------------------

UNKNOWN_UNITS = ["ft", "mils", "thou", "dm", "LSB", "bar", "a. u.", "0.1 um", "x 10 um", "1/10 um", "um x 10^-3", '"']


@pytest.mark.parametrize("unit", UNKNOWN_UNITS)
@pytest.mark.parametrize("names", ["x (mm);z ({})\n", "x [mm];z [{}]\n", "x;z\n(mm);({})\n"])
def test_unit_option_does_not_replace_an_unknown_unit_of_a_column(read_text, names, unit):
    message = get_error_message(read_text, names.format(unit) + ROWS, unit=("mm", "um"))
    shown_unit = "inch" if unit == '"' else unit
    assert f"has heights in {shown_unit!r}, which is not a supported unit of length" in message


@pytest.mark.parametrize(
    "names", ['x/mm;z/"\n', 'x_mm;z_"\n', 'x;z\nmm;"\n', 'x in mm;z in "\n', 'x (mm);z\nZ unit = "\n', 'x/mm;"z/"\n']
)
def test_inch_mark_after_a_column_name_is_rejected_as_an_unknown_unit(read_text, names):
    message = get_error_message(read_text, names + ROWS, unit=("mm", "um"))
    assert "has heights in 'inch', which is not a supported unit of length" in message


@pytest.mark.parametrize("names", ["k/1/um;z/um\n", "elapsed/1/um;z (um)\n", "x 1/um;z um\n"])
def test_positions_in_a_unit_of_reciprocal_length_are_rejected(read_text, names):
    assert "has positions in '1/um', which is not a supported unit of length" in get_error_message(
        read_text, names + ROWS
    )


def test_quotation_marks_around_column_names_are_not_inch_marks(read_text):
    assert read_text(f'"x/mm";"z/um"\n{ROWS}').body.heights.tolist() == PROFILE.tolist()


@pytest.mark.parametrize("unit", UNKNOWN_UNITS[:-1])
@pytest.mark.parametrize("line", ["Unit: {}", "Z-axis unit = {}", "Einheit: {}", "z ({})", "Heights in {}"])
def test_unit_option_does_not_replace_an_unknown_unit_in_a_header_line(read_text, line, unit):
    message = get_error_message(read_text, f"{line.format(unit)}\n{PROFILE_TEXT}", unit="um", spacing="0.5 um")
    assert f"has heights in {unit!r}, which is not a supported unit of length" in message


@pytest.mark.parametrize("unit", ["mm/1000", "1e-3 mm", "10^-6 m", "мкм", "微米", "µm RMS", "Mikrometer"])
def test_unit_with_a_power_of_ten_or_with_unusual_characters_is_read(read_text, unit):
    assert read_text(f"x (mm);z ({unit})\n{ROWS}").body.heights.tolist() == PROFILE.tolist()


@pytest.mark.parametrize(
    "name",
    [
        "z in mils",
        "Z-Axis_in",
        "z, km",
        "Height_digit",
        "z MPa",
        "Height, µrad",
        "z in 0.1 um",
        "z (hundredths of mm)",
        "z µm/s",
    ],
)
def test_unit_option_does_not_replace_an_unsupported_unit_at_the_end_of_a_column_name(read_text, name):
    message = get_error_message(read_text, f"x (mm);{name}\n{ROWS}", unit=("mm", "um"))
    assert "which is not a supported unit of length" in message


@pytest.mark.parametrize(
    ("names", "unit"),
    [("x (mm);z_100nm", "100nm"), ("x mm;z 10 nm", "10 nm"), ("x_mm;z_0.1_um", "0.1_um"), ("x mm;z mm/100", "mm/100"),
     ("X_mm;Z_x10nm", "x10nm"), ("x mm;z nm/nm", "nm/nm"), ("x_mm;z_Volt", "Volt"), ("x.mm;z.mils", "mils"),
     ("x position mm;z grey levels", "grey levels"), ("Distance mm;Height Schritte", "Schritte"),
     ("x-mm;surface height-km", "km"), ("x mm;Height u m", "u m"), ("X;Z\nmm;0.1 um", "0.1 um"),
     ("Distance;Height\nmm;foo", "foo"), ("x_mm;z_foo", "foo")],
)  # fmt: skip
def test_unit_option_does_not_replace_an_unsupported_unbracketed_unit_of_a_column(read_text, names, unit):
    message = get_error_message(read_text, f"{names}\n{ROWS}", unit=("mm", "um"))
    assert f"has heights in {unit!r}, which is not a supported unit of length" in message


@pytest.mark.parametrize(
    "names", ["X_my;Z_my", "x pollici;z pollici", "X_10nm;Z_10nm", "Position, \\mum;Height, \\mum"]
)
def test_unit_option_does_not_replace_an_unknown_header_unit_that_applies_to_all_columns(read_text, names):
    assert "which is not a supported unit of length" in get_error_message(read_text, f"{names}\n{ROWS}", unit="um")


@pytest.mark.parametrize("name", ["height_1e-6m", "z 10⁻⁶ m", "z 10^-6 m", "z_1e-3mm", "z mm/1000", "z.um", "Z - um"])
def test_power_of_ten_is_read_from_a_unit_that_is_not_in_brackets(read_text, name):
    assert read_text(f"x (mm);{name}\n{ROWS}").body.heights == pytest.approx(PROFILE)


@pytest.mark.parametrize("names", ["x left;z left", "X Profil1;Z Profil1", "x_mm;z_filtered", "x mm;Profile 10 um"])
def test_words_after_a_column_name_are_ignored_unless_these_words_are_units(read_text, names):
    assert read_text(f"{names}\n{ROWS}", unit=("mm", "um")).body.heights.tolist() == PROFILE.tolist()


@pytest.mark.parametrize("line", ["Z: MM", "z_my", "Height foo", "Z: 10 nm", "z 1e-4 m", "z = x10 nm", "Y unit: V"])
def test_unit_option_does_not_replace_an_unsupported_unit_above_the_heights(read_text, line):
    message = get_error_message(read_text, f"{line}\n{PROFILE_TEXT}", unit="um", spacing="0.5 um")
    assert "which is not a supported unit of length" in message


@pytest.mark.parametrize("line", ["Height map", "Height (trace)", "Z: 12.5 mm", "Height: 200 um\nWidth: 200 um"])
def test_header_line_that_names_heights_but_no_unit_is_ignored(read_text, line):
    options = {} if "Width" in line else {"spacing": "5 um"}
    assert read_text(f"{line}\n{MAP_TEXT}", unit="um", **options).body.heights.tolist() == MAP.tolist()


def test_header_unit_of_y_is_not_used_for_the_heights_of_a_map(read_text):
    assert not read_text(f"Y unit: mm\n{MAP_TEXT}", unit="um", spacing="5 um").caveats


@pytest.mark.parametrize("names", ["x (um);z (raw)", "x um;Height raw", "x;z\num;raw"])
def test_column_of_raw_heights_without_a_unit_has_a_caveat(read_text, names):
    rows = "".join(f"{index / 2:.1f};{z}\n" for index, z in enumerate(PROFILE))
    assert read_caveat_names(read_text(f"{names}\n{rows}", unit="um")) == ["scale"]


@pytest.mark.parametrize("name", ["data points", "z min", "height left", "Channel A", "Profile, left"])
def test_last_word_of_a_column_name_is_ignored_if_the_word_is_no_unit(read_text, name):
    assert read_text(f"x (mm);{name}\n{ROWS}", unit=("mm", "um")).body.heights.tolist() == PROFILE.tolist()


def test_unit_with_a_power_of_ten_after_the_column_names_is_read(read_text):
    rows = "".join(f"{500 * index};{1000 * z:.1f}\n" for index, z in enumerate(PROFILE))
    reading = read_text(f"x in 1e-9 m;z in 1e-9 m\n{rows}")
    assert reading.body.spacing == pytest.approx(0.5)
    assert reading.body.heights == pytest.approx(PROFILE)


def test_header_names_beyond_the_number_of_columns_are_ignored(read_text):
    rows = "".join(f"{index / 2000:.4f}\t{z}\n" for index, z in enumerate(PROFILE))
    names = "x (mm)\tslope error (urad)\tx (mm)\tHGT error (nm)\tHGT (um)"
    assert "has heights in 'urad'" in get_error_message(read_text, f"PV (um)\tPV error (nm)\n{names}\n{rows}")
    assert read_text(f"x (mm)\tz (nm)\tslope (urad)\n{rows}").body.heights == pytest.approx(PROFILE / 1000)


def test_single_letter_after_a_column_name_is_a_unit_if_another_column_has_a_unit(read_text):
    assert "has heights in 's'" in get_error_message(read_text, f"Position mm;Height s\n{ROWS}", unit=("mm", "um"))


def test_html_entity_in_a_unit_is_decoded(read_text):
    rows = "".join(f"{index / 2:.1f}\t{z}\n" for index, z in enumerate(PROFILE))
    assert read_text(f"x (&micro;m)\tz (&micro;m)\n{rows}").body.spacing == pytest.approx(0.5)


def test_unit_option_does_not_replace_a_unit_that_contains_a_number(read_text):
    message = get_error_message(read_text, f"Height unit 10 nm\n{PROFILE_TEXT}", unit="um", spacing="0.5 um")
    assert "has heights in '10 nm'" in message


@pytest.mark.parametrize(("line", "unit"), [("Z: grey levels", "grey levels"), ("z = V", "V")])
def test_unit_after_z_in_a_header_line_is_rejected_unless_it_is_a_unit_of_length(read_text, line, unit):
    message = get_error_message(read_text, f"{line}\n{PROFILE_TEXT}", unit="um", spacing="0.5 um")
    assert f"has heights in {unit!r}" in message
    assert read_text(f"Z: nm\n{PROFILE_TEXT}", spacing="0.5 um").unit == "nm"


def test_header_range_that_equals_the_range_of_the_heights_determines_the_height_unit(read_text):
    header = f"X Amplitude: 200 nm\nY Amplitude: 140 nm\nZ Amplitude: {np.ptp(MAP):.4f} nm\n"
    reading = read_text(header + MAP_TEXT)
    assert reading.body.heights == pytest.approx(MAP / 1000)
    assert "declares its heights in nm, but the option unit is um" in get_error_message(
        read_text, header + MAP_TEXT, unit="um"
    )
    other_range = header.replace(f"{np.ptp(MAP):.4f}", f"{1.5 * np.ptp(MAP):.4f}")
    assert "does not contain the unit of its heights" in get_error_message(read_text, other_range + MAP_TEXT)


@pytest.mark.parametrize(
    ("factor", "unit", "has_caveat"),
    [(1, "um", False), (1, "nm", True), (1, "mm", True), (0.05, "um", True), (0.2, "um", False), (40, "um", False)],
)
@pytest.mark.parametrize("name", ["Z range", "Height range", "Peak to valley"])
def test_heights_that_contradict_the_range_in_the_header_have_a_caveat(read_text, name, factor, unit, has_caveat):
    header = f"{name}: {factor * np.ptp(MAP):.4g} {unit}\nUnit: um\n"
    reading = read_text(header + MAP_TEXT, spacing="0.5 um")
    assert read_caveat_names(reading) == ["range"] * has_caveat
    assert not read_text(header + MAP_TEXT, spacing="0.5 um", accept="range").caveats


@pytest.mark.parametrize("remark", ["raw", "trace", "Filtered", "level 2", "-"])
def test_remark_in_a_column_name_is_not_a_unit(read_text, remark):
    assert read_text(f"x (mm);z ({remark})\n{ROWS}", unit=("mm", "um")).body.heights.tolist() == PROFILE.tolist()


def test_unit_of_positions_in_a_header_line_is_rejected_unless_it_is_a_unit_of_length(read_text):
    assert read_text(f"X unit: mm\nx;z\n{ROWS}", unit="um").body.spacing == pytest.approx(0.5)
    assert "has positions in 's', which is not" in get_error_message(read_text, f"X unit: s\nx;z\n{ROWS}", unit="um")


# ---- Units of several quantities ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("header", "unit"),
    [("Units: mm, nm\nx;z", "nm"), ("Units: x=mm, z=nm\nx;z", "nm"), ("mm;nm\nPosition;Height", "nm"),
     ("# x;z\n# mm;nm", "nm"), ('[{"name": "x", "unit": "mm"}, {"name": "z", "unit": "nm"}]', "nm"),
     ("name: x\nunit: mm\nname: z\nunit: mm\nx;z", "mm")],
)  # fmt: skip
def test_column_units_in_a_line_separate_from_the_column_names_are_read(read_text, header, unit):
    reading = read_text(f"{header}\n{ROWS}")
    assert (reading.unit, reading.body.spacing) == (unit, pytest.approx(0.5))


def test_units_are_read_from_a_header_in_which_blanks_separate_names_and_units(read_text):
    rows = ROWS.replace(";", " ")
    assert read_text(f"DISTANCE mm DEPTH nm\n{rows}").unit == "nm"
    assert "has heights in 'FEET'" in get_error_message(read_text, f"DISTANCE mm DEPTH FEET\n{rows}", unit=("mm", "um"))


@pytest.mark.parametrize(
    "header",
    ["Units: x=mm, z=PSIA\nx;z", "mm;PSIA\nPosition;Height", "name: x\nunit: mm\nname: z\nunit: PSIA\nx;z",
     "units.z: V\nx;z", "figure units: z = V\nx;z", "Channel unit: 1/mm\nx;z", "unit_z = V\nx;z"],
)  # fmt: skip
def test_unit_option_does_not_replace_an_unsupported_unit_in_a_header_of_several_quantities(read_text, header):
    message = get_error_message(read_text, f"{header}\n{ROWS}", unit=("mm", "um"))
    assert "which is not a supported unit of length" in message


def test_header_unit_that_contradicts_the_unit_of_a_column_has_a_caveat(read_text):
    reading = read_text(f"Units: nm\nx (mm);z (um)\n{ROWS}")
    assert (reading.unit, read_caveat_names(reading)) == ("um", ["scale"])


@pytest.mark.parametrize("line", ["unit: 0.1 um", "Z unit: 10 um", "Units: x 10 um", "z in 0.1 um"])
def test_header_unit_with_a_factor_has_a_caveat_if_the_columns_have_units(read_text, line):
    reading = read_text(f"{line}\nx (mm);z (um)\n{ROWS}")
    assert (reading.unit, read_caveat_names(reading)) == ("um", ["scale"])


@pytest.mark.parametrize("line", ["unit: 1 um", "unit: um", "units: metric"])
def test_header_unit_that_agrees_with_the_unit_of_a_column_has_no_caveat(read_text, line):
    assert not read_text(f"{line}\nx (mm);z (um)\n{ROWS}").caveats


@pytest.mark.parametrize("name", ["Profile (nmi)", "Depth [nmi]", "Signal (nmi)", "Height (nmi)"])
def test_unit_option_does_not_replace_an_unknown_unit_of_a_single_column(read_text, name):
    assert "has heights in 'nmi', which is not a supported unit" in get_error_message(
        read_text, f"{name}\n{PROFILE_TEXT}", unit="um", spacing="0.5 um"
    )


@pytest.mark.parametrize("name", ["Profile (raw)", "Profile (left)", "Profile (AFM)", "Data (mean)"])
def test_remark_after_the_name_of_a_single_column_is_not_a_unit(read_text, name):
    assert read_text(f"{name}\n{PROFILE_TEXT}", unit="um", spacing="0.5 um").unit == "um"


# ---- Slopes ---------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "header",
    ["L(mm)  R1 slope x 1E6  /urad", "#slope profile along the central axis\nx;y", "x[mm]  slope_error[urad]",
     "Type: slope", "second column contains slopes\nx;y",
     "scan 3\n05/08/2011 at 9:33\nNo ref/No gravity\n817.1\n-1.0\n120"],
)  # fmt: skip
@pytest.mark.parametrize("columns", [None, (0, 1)])
def test_column_of_slopes_is_rejected_even_if_a_unit_of_length_is_given(read_text, header, columns):
    message = get_error_message(read_text, f"{header}\n{ROWS.replace(';', ' ')}", unit=("mm", "nm"), columns=columns)
    assert "slope" in message or "has heights in 'urad'" in message


@pytest.mark.parametrize("line", ["Slope: 0.3 mrad", "Rms slope (rad): 0.02", "Slope removed", "Slope error: 2 urad"])
def test_header_line_about_the_slope_of_the_surface_is_ignored(read_text, line):
    assert read_text(f"{line}\nx;z\n{ROWS}", unit=("mm", "um")).body.heights.tolist() == PROFILE.tolist()


@pytest.mark.parametrize(("file_format", "is_rejected"), [(1, True), (3, True), (2, False)])
def test_file_is_rejected_if_the_description_next_to_it_declares_slopes(tmp_path, file_format, is_rejected):
    (tmp_path / "dabam-900.txt").write_text(f'{{\n  "FILE_FORMAT": {file_format},\n  "X1_FACTOR": 1.0e-3\n}}\n')
    (tmp_path / "dabam-900.dat").write_text(ROWS.replace(";", " "))
    if is_rejected:
        with pytest.raises(FormatError, match=f"slopes, not heights, according to FILE_FORMAT {file_format}"):
            read_with_interpretation(tmp_path / "dabam-900.dat", unit=("mm", "um"))
    else:
        reading = read_with_interpretation(tmp_path / "dabam-900.dat", unit=("mm", "um"))
        assert reading.body.heights.tolist() == PROFILE.tolist()


# ---- Names and units of columns -------------------------------------------------------------------------------------


@pytest.mark.parametrize("names", ["y (um) x (um) z (um)", "Y [um] X [um] Height [um]", "# y (um) x (um) z (um)"])
def test_column_names_with_units_in_brackets_are_read_if_separated_by_single_blanks(read_text, names):
    rows = "".join(f"{y * 0.5} {x * 0.25} {MAP[y, x]}\n" for y in range(14) for x in range(20))
    body = read_text(f"{names}\n{rows}").body
    assert body.spacing == (0.5, 0.25)
    np.testing.assert_array_equal(body.heights, MAP)


@pytest.mark.parametrize("third_line", ["Smp;Avg", ";part a", '"Smp";"Smp"', "part a;part a"])
def test_header_line_below_the_lines_of_names_and_units_is_ignored(read_text, third_line):
    body = read_text(f"Position;Height\nmm;um\n{third_line}\n{ROWS}").body
    np.testing.assert_array_equal(body.heights, PROFILE)
    assert body.spacing == pytest.approx(0.5)
    message = get_error_message(read_text, f"Position;Height\nmm;um\n{third_line}\n{ROWS}", unit=("mm", "nm"))
    assert "declares its heights in um, but the option unit is nm" in message


@pytest.mark.parametrize("row", ["{x};mm;{z};um\n", "{x};mm;{z};µm\n"])
def test_unit_written_beside_each_number_applies_to_that_number(read_text, row):
    text = "".join(row.format(x=index / 2000, z=z) for index, z in enumerate(PROFILE))
    body = read_text(text).body
    np.testing.assert_array_equal(body.heights, PROFILE)
    assert body.spacing == pytest.approx(0.5)
    assert "but the option unit is nm" in get_error_message(read_text, text, unit=("mm", "nm"), columns=(0, 2))


@pytest.mark.parametrize("columns", [None, (0,)])
def test_heights_with_different_units_beside_the_numbers_are_rejected(read_text, columns):
    text = "".join(f"{z};um\n" if index % 9 else f"{1000 * z:.1f};nm\n" for index, z in enumerate(PROFILE))
    message = get_error_message(read_text, text, unit="um", spacing="0.5 um", columns=columns)
    assert "has numbers in several units in column 1: 'um' (106) and 'nm' (14)" in message
