"""Tests of axes that are not lengths, codes for missing points within heights, and maps with a declared size."""

import numpy as np
import pytest
from stiction import FormatError, read_measurement, read_surface
from stiction.surfaces.measured.reading import read_with_interpretation

RNG = np.random.default_rng(11)
PROFILE = np.round(np.cumsum(RNG.normal(size=240)) / 50, 4)
MAP = np.round(np.cumsum(np.cumsum(RNG.normal(size=(24, 60)), axis=0), axis=1)[:, 10:40] / 100, 4)


def write_columns(path, names, step=0.5, first_position=0):
    rows = "".join(f"{first_position + index * step:g};{z}\n" for index, z in enumerate(PROFILE))
    path.write_text(f"{names}\n{rows}", encoding="utf-8")
    return path


def write_map(path, heights):
    path.write_text("".join(",".join(f"{z:.10g}" for z in row) + "\n" for row in heights))
    return path


def get_error_message(path, **options):
    with pytest.raises(FormatError) as error_info:
        read_measurement(path, **options)
    return str(error_info.value)


def read_caveats(path, **options):
    return {caveat.name: str(caveat) for caveat in read_with_interpretation(path, **options).caveats}


# ---- Axes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name", ["time", "t", "Zeit", "t [-]", "angle", "Winkel", "theta", "frequency", "q", "load", "scan time"]
)
def test_column_of_another_quantity_is_not_read_as_positions(tmp_path, name):
    path = write_columns(tmp_path / "a.csv", f"{name};z")
    assert f"has positions in a column named {name!r}" in get_error_message(path, unit="um")
    assert "choose only the heights (--columns 1) and give their spacing" in get_error_message(path, unit="um")
    assert read_measurement(path, unit="um", columns="z", spacing="0.5 um").heights.tolist() == PROFILE.tolist()


@pytest.mark.parametrize("name", ["wavelength (nm)", "lag (um)", "frequency (m)"])
def test_axis_of_a_spectrum_in_a_unit_of_length_is_not_read_as_positions(tmp_path, name):
    assert "is not a length" in get_error_message(write_columns(tmp_path / "a.csv", f"{name};z (um)"))


@pytest.mark.parametrize("name", ["PSD", "power spectral density", "ACF", "probability"])
def test_column_of_a_spectrum_is_not_read_as_heights(tmp_path, name):
    assert "is not a height" in get_error_message(write_columns(tmp_path / "a.csv", f"x;{name}"), unit="um")


@pytest.mark.parametrize("name", ["sample", "frame", "Pixel", "data point", "Messpunkt", "lfd. Nr.", "idx"])
@pytest.mark.parametrize("step", [1, 10])
def test_column_of_positions_that_may_be_point_numbers_has_a_caveat(tmp_path, name, step):
    path = write_columns(tmp_path / "a.csv", f"{name};z", step, first_position=5 * (step - 1))
    assert "numbering" in read_caveats(path, unit="um")


@pytest.mark.parametrize("name", ["x", "position", "t (um)", "distance", "Weg", "lateral", "X-Achse"])
def test_position_column_with_a_known_name_has_no_caveat(tmp_path, name):
    assert not read_caveats(write_columns(tmp_path / "a.csv", f"{name};z"), unit="um")


@pytest.mark.parametrize("name", ["tempo", "Tiempo", "時間", "azimuth", "motor steps", "Dehnung", "shot", "v", ""])
def test_position_column_with_an_unknown_name_and_no_unit_has_a_caveat_unless_chosen_explicitly(tmp_path, name):
    path = write_columns(tmp_path / "a.csv", f"{name};z")
    if name == "motor steps":
        assert "has positions in 'steps'" in get_error_message(path, unit="um")
        return
    assert "choose it by --columns 0,1 if it contains positions" in read_caveats(path, unit="um")["positions"]
    assert not read_caveats(path, unit="um", columns=(0, 1))
    if name:
        assert not read_caveats(write_columns(tmp_path / "b.csv", f"{name} (um);z (um)"))


@pytest.mark.parametrize(
    "name", ["Distanza", "posição", "longueur", "odległość", "Положение", "距離", "위치", "avstånd"]
)
def test_position_column_with_a_name_in_another_language_has_no_caveat(tmp_path, name):
    assert not read_caveats(write_columns(tmp_path / "a.csv", f"{name};z"), unit="um")


@pytest.mark.parametrize("line", ["X_Dimension\tTime", "X axis: Time", "X quantity = angle", "X label: frequency"])
def test_positions_are_rejected_if_a_header_line_declares_another_quantity_along_x(tmp_path, line):
    path = write_columns(tmp_path / "a.csv", f"{line}\nX_Value;Laser")
    assert f"has positions in '{line.split()[-1]}', which is not a supported unit" in get_error_message(path, unit="mm")


@pytest.mark.parametrize(
    "name",
    [
        "1000*z",
        "10^3 z",
        "z/1000",
        "-z",
        "log z",
        "|z|",
        "z/Sq",
        "z·10³",
        "z normalised",
        "abs(z)",
        "exp(-z)",
        "exp z",
        "z, 0.1x",
    ],
)
def test_column_of_calculated_heights_has_a_caveat(tmp_path, name):
    path = write_columns(tmp_path / "a.csv", f"x (um);{name} (um)")
    assert list(read_caveats(path)) == ["scale"]


@pytest.mark.parametrize("name", ["z x0.1", "z x.5", "heights x5"])
def test_height_column_whose_name_contains_a_factor_such_as_x10_has_a_caveat(tmp_path, name):
    assert list(read_caveats(write_columns(tmp_path / "a.csv", f"x (um);{name} (um)"))) == ["scale"]


@pytest.mark.parametrize("name", ["z | µm", "z abs (µm)", "exp. height (µm)"])
def test_height_column_whose_name_has_an_abbreviation_or_a_vertical_bar_has_no_caveat(tmp_path, name):
    assert not read_caveats(write_columns(tmp_path / "a.csv", f"x (um);{name}"))


# ---- Codes ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "codes", [(-9999, -9998), (-999, -999.9, -1000), (-524287, -524288), (32767, -32768), (-9999, 9999, 9998)]
)
def test_codes_for_missing_points_are_reported_with_their_number_of_occurrences(tmp_path, codes):
    heights = MAP.copy()
    for code_index, code in enumerate(codes):
        heights[3 + code_index :: 7, 2 + 3 * code_index] = code
    texts = [
        str(caveat)
        for caveat in read_with_interpretation(
            write_map(tmp_path / "a.csv", heights), unit="um", spacing="1 mm"
        ).caveats
        if caveat.name == "repeated-extreme"
    ]
    assert sorted(codes) == sorted(float(text.split("--missing-value ")[1].split()[0]) for text in texts)


@pytest.mark.parametrize(
    ("codes", "reported"),
    [
        ([2.2, 2.2, -2.2, -2.2], [-2.2, 2.2]),
        ([-2.2, -2.2], [-2.2]),
        ([-9999], [-9999]),  # a well-known code, although it occurs only once
        ([32767, -32768], [-32768, 32767]),
        ([2.2], []),
        ([2.2, 2.3], []),
        ([1.1, 1.1], []),
    ],
)
def test_repeated_or_well_known_missing_value_code_outside_the_range_of_heights_is_reported(tmp_path, codes, reported):
    heights = np.round(np.interp(MAP, (MAP.min(), MAP.max()), (-1, 1)), 4)
    heights[3 : 3 + len(codes), 5] = codes
    reading = read_with_interpretation(write_map(tmp_path / "a.csv", heights), unit="um", spacing="1 mm")
    texts = [str(caveat) for caveat in reading.caveats if caveat.name == "repeated-extreme"]
    assert [float(text.split("--missing-value ")[1].split()[0]) for text in texts] == reported


@pytest.mark.parametrize("kind", ["scattered zeros", "block of zeros", "two values between the others"])
def test_height_much_more_frequent_than_similar_heights_is_reported(tmp_path, kind):
    heights = MAP.copy()
    if kind == "scattered zeros":
        heights.ravel()[::16] = 0
    elif kind == "block of zeros":
        heights[5:9, 4:13] = 0
    else:
        heights.ravel()[::23], heights.ravel()[5::31] = 0.0501, -0.0501
    text = read_caveats(write_map(tmp_path / "a.csv", heights), unit="um", spacing="1 mm")["repeated-height"]
    assert "times as frequent as similar heights" in text
    assert "--missing-value" in text


@pytest.mark.parametrize("fraction", [0.03, 0.06])
@pytest.mark.parametrize("deviation", [0.04, 0.1, 1.0])
def test_excess_of_exact_zeros_among_other_heights_has_a_caveat(tmp_path, deviation, fraction):
    rng = np.random.default_rng(5)
    heights = np.round(deviation * rng.normal(size=(40, 40)), 3)
    heights[rng.random(heights.shape) < fraction] = 0
    assert "repeated-height" in read_caveats(write_map(tmp_path / "a.csv", heights), unit="um", spacing="1 mm")


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("round_heights", [np.round, np.trunc, np.floor])
@pytest.mark.parametrize("deviation", [6.0, 25.0, 120.0])
def test_zeros_that_result_from_rounding_are_not_reported_as_a_repeated_height(
    tmp_path, deviation, round_heights, seed
):
    heights = round_heights(deviation * np.random.default_rng(seed).normal(size=(60, 50)))
    assert "repeated-height" not in read_caveats(write_map(tmp_path / "a.csv", heights), unit="nm", spacing="1 um")


@pytest.mark.parametrize("copies", [2, 3])
@pytest.mark.parametrize("kind", ["profile", "map"])
def test_repeated_sequence_of_heights_is_reported(tmp_path, kind, copies):
    if kind == "profile":
        path = tmp_path / "a.csv"
        path.write_text("".join(f"{z}\n" for z in [*PROFILE] * copies))
    else:
        path = write_map(tmp_path / "a.csv", np.concatenate([MAP] * copies))
    assert f"follow each other {copies} times" in read_caveats(path, unit="um", spacing="1 mm")["repeated-rows"]


def test_sinusoidal_profile_is_not_reported_as_a_repeated_sequence(tmp_path):
    (tmp_path / "a.csv").write_text("".join(f"{np.sin(np.pi * index / 25):.4f}\n" for index in range(200)))
    assert not read_caveats(tmp_path / "a.csv", unit="um", spacing="1 um")


def test_exact_zeros_in_a_profile_are_reported(tmp_path):
    heights = PROFILE.copy()
    heights[7::20] = 0
    path = tmp_path / "a.txt"
    path.write_text("".join(f"{z:.4f}\n" for z in heights))
    assert "exactly 0" in read_caveats(path, unit="um", spacing="1 um")["repeated-height"]


@pytest.mark.parametrize("axis", [0, 1])
def test_map_rows_equal_to_the_previous_row_are_reported(tmp_path, axis):
    heights = MAP.copy() if axis == 0 else MAP.T.copy()
    heights[10:13] = heights[9]
    path = write_map(tmp_path / "a.csv", heights if axis == 0 else heights.T)
    kind = "rows" if axis == 0 else "columns"
    assert (
        f"3 of {heights.shape[0]} {kind} are equal to the {kind[:-1]} before"
        in read_caveats(path, unit="um", spacing="1 um")["repeated-rows"]
    )


@pytest.mark.parametrize("axis", [0, 1])
def test_row_or_column_of_equal_heights_in_a_map_is_reported(tmp_path, axis):
    heights = MAP.copy() if axis == 0 else MAP.T.copy()
    heights[7] = 0
    path = write_map(tmp_path / "a.csv", heights if axis == 0 else heights.T)
    assert "have equal heights" in read_caveats(path, unit="um", spacing="1 mm")["repeated-rows"]


@pytest.mark.parametrize("decimals", [1, 2, 4])
def test_equal_heights_in_a_part_of_a_profile_are_reported(tmp_path, decimals):
    heights = np.round(PROFILE, decimals)
    path = tmp_path / "a.txt"
    path.write_text("".join(f"{z:g}\n" for z in heights))
    assert "repeated-rows" not in read_caveats(path, unit="um", spacing="1 um")
    heights[60:100] = heights[60]
    path.write_text("".join(f"{z:g}\n" for z in heights))
    assert "heights in a row are equal" in read_caveats(path, unit="um", spacing="1 um")["repeated-rows"]


@pytest.mark.parametrize("axis", [0, 1])
def test_map_with_every_row_listed_twice_is_reported(tmp_path, axis):
    path = write_map(tmp_path / "a.csv", np.repeat(MAP, 2, axis))
    assert "equal to the" in read_caveats(path, unit="um", spacing="1 mm")["repeated-rows"]


@pytest.mark.parametrize("kind", ["clipped", "filled with the lowest height"])
def test_frequent_extreme_height_of_a_map_is_reported(tmp_path, kind):
    rng = np.random.default_rng(8)
    heights = np.round(rng.normal(size=(40, 40)), 4)
    heights = np.minimum(heights, 1.5) if kind == "clipped" else np.where(rng.random((40, 40)) < 0.05, -4.0, heights)
    assert (
        "exactly" in read_caveats(write_map(tmp_path / "a.csv", heights), unit="um", spacing="1 mm")["repeated-height"]
    )


@pytest.mark.parametrize("digit", [1e-4, 1e-3, 1e-2, 0.05])
def test_rounded_heights_have_no_caveat_about_repeated_values(tmp_path, digit):
    rng = np.random.default_rng(2)
    heights = np.round(np.cumsum(np.cumsum(rng.normal(size=(80, 80)), axis=0), axis=1) / 50 / digit) * digit
    assert not read_caveats(write_map(tmp_path / "a.csv", heights), unit="um", spacing="1 mm")


@pytest.mark.parametrize("word", [".", "-", "...", "+", "-9,99E+99"])
def test_missing_value_option_accepts_words_that_resemble_numbers(tmp_path, word):
    path = tmp_path / "a.csv"
    rows = "".join(f"{index / 2};{word if index % 17 == 3 else z}\n" for index, z in enumerate(PROFILE))
    path.write_text(f"x (um);z (um)\n{rows}")
    profile = read_measurement(path, missing="mask", missing_value=(word,))
    assert profile.missing.tolist() == [index % 17 == 3 for index in range(PROFILE.size)]


# ---- Formats that declare their size --------------------------------------------------------------------------------


@pytest.mark.parametrize("per_line", [7, 30])
@pytest.mark.parametrize("suffix", [".grd", ".asc", ".txt"])
def test_surfer_grid_is_read_with_the_spacings_of_its_header(tmp_path, suffix, per_line):
    heights = MAP.copy()
    heights[2, 3] = np.nan
    numbers = ["1.70141e+38" if np.isnan(z) else f"{z:.4f}" for z in heights.ravel()]
    lines = [" ".join(numbers[index : index + per_line]) for index in range(0, len(numbers), per_line)]
    path = tmp_path / f"a{suffix}"
    path.write_text("\n".join(["DSAA", "30 24", "0 14.5", "0 5.75", "-3 3", *lines, ""]))
    surface = read_surface(path, unit="um", missing="mask")
    assert surface.spacings == pytest.approx((0.25, 0.5))
    assert np.argwhere(surface.missing).tolist() == [[2, 3]]
    assert np.array_equal(surface.heights[surface.missing == 0], MAP[surface.missing == 0])
    assert "has a spacing of 0.25 µm, but the option spacing is 0.5 um" in get_error_message(
        path, unit="um", missing="mask", spacing="0.5 um"
    )


@pytest.mark.parametrize(
    ("header", "message"),
    [("30 23\n0 1\n0 1\n0 1", "declares 23 rows of 30 heights, but has 720 heights"),
     ("30 24\n1 1\n0 1\n0 1", "range of x or y whose end is not above its start"),
     ("30\n0 1\n0 1\n0 1", "lacks the counts and ranges")],
)  # fmt: skip
def test_surfer_grid_with_an_impossible_header_is_rejected(tmp_path, header, message):
    path = tmp_path / "a.grd"
    path.write_text(f"DSAA\n{header}\n" + "\n".join(f"{z:.4f}" for z in MAP.ravel()))
    assert message in get_error_message(path, unit="um")


@pytest.mark.parametrize(
    ("header", "message"),
    [("\\*File list\n\\Samps/line: 30\n\\*File list end\nHeight(nm)", "is a NanoScope list with one height per line"),
     ("a surface\nGRD 30 24 SUR WVL 0.6328 SSZ 1000 NDA -32768", "is a CODE V interferogram"),
     ("ISO 5436 - 2000 own\nPRF 0 own\nCX I 720 mm 1.0 D 5.0e-04\nCZ A 720 um 1.0e-4 L\n", "file (ISO 5436-2)"),
     ("1 2\nSG 0.0 PRF\nCX M 7.2e+002 MM 1.0 D\nCZ M 7.2e+002 UM 1.0e-006 L\nEOR\n", "file (ISO 5436-2)"),
     ("P2\n30 24\n255", "is an image as text"),
     ("ply\nformat ascii 1.0\nelement vertex 720\nelement face 9\nend_header", "is a mesh with faces")],
)  # fmt: skip
def test_heights_of_a_map_in_a_single_column_are_not_read_as_a_profile(tmp_path, header, message):
    path = tmp_path / "a.txt"
    path.write_text(header + "\n" + "\n".join(f"{1000 * z:.0f}" for z in MAP.ravel()))
    assert message in get_error_message(path, unit="nm", spacing="1 um")


@pytest.mark.parametrize("numbers", [[240, 0.5], [0.5, 240], [240, 0.5, 1]])
def test_point_count_at_the_top_of_a_column_is_not_read_as_a_height(tmp_path, numbers):
    path = tmp_path / "a.txt"
    path.write_text("".join(f"{z:g}\n" for z in [*numbers, *PROFILE]))
    assert f"begins with {len(numbers)} numbers" in get_error_message(path, unit="um", spacing="0.5 um")


def test_last_height_that_equals_the_given_spacing_has_a_caveat(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("".join(f"{z:.4f}\n" for z in [*PROFILE, 0.125]))
    text = read_caveats(path, unit="um", spacing="0.125 um")["first-number"]
    assert "the last number, 0.125, equals the option spacing" in text
