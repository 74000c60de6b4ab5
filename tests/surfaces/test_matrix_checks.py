"""Tests of tables without column names that do not contain a matrix of heights."""

import numpy as np
import pytest
from stiction import FormatError, FormatWarning, read_measurement, read_surface
from stiction.surfaces.measured.reading import read_with_interpretation

READ_OPTIONS = {"unit": "um", "spacing": "0.5 um"}


def create_map(rows, columns, seed=3):
    """Return a smooth random map of the given shape."""
    rng = np.random.default_rng(seed)
    heights = rng.normal(size=(rows + 6, columns + 6))
    for axis in (0, 1):
        heights = sum(np.roll(heights, shift, axis) for shift in range(-3, 4))
    return np.round(heights[3:-3, 3:-3] / 7, 4)


HEIGHTS = create_map(15, 20)
X, Y = (item.ravel() * 0.5 for item in np.meshgrid(np.arange(20), np.arange(15)))
POINT_NUMBERS = np.arange(HEIGHTS.size)
SURFACE_NORMALS = np.column_stack([0.6 * np.sin(X), 0.6 * np.cos(X), 0.8 + 0 * X])
COLUMNS_BESIDE_XYZ = {
    "colours": np.column_stack([POINT_NUMBERS % 256, 0 * POINT_NUMBERS + 90, 0 * POINT_NUMBERS]),
    "one whole intensity": (POINT_NUMBERS % 100)[:, None],
    "intensity below one": (np.sqrt(POINT_NUMBERS % 97) / 10)[:, None],
    "normals": SURFACE_NORMALS,
    "colours and normals": np.column_stack(
        [POINT_NUMBERS % 256, POINT_NUMBERS % 7, POINT_NUMBERS % 9, SURFACE_NORMALS]
    ),
}


def to_text(columns, separator=" "):
    return "".join(separator.join(f"{value:.6g}" for value in row) + "\n" for row in np.asarray(columns))


def get_error_message(path, **options):
    with pytest.raises(FormatError) as error_info:
        read_measurement(path, **options)
    return str(error_info.value)


@pytest.mark.parametrize("separator", [" ", ",", ";", "\t"])
@pytest.mark.parametrize("kind", COLUMNS_BESIDE_XYZ)
def test_point_list_with_extra_columns_is_rejected_unless_x_y_and_z_are_chosen(tmp_path, kind, separator):
    path = tmp_path / "a.txt"
    path.write_text(to_text(np.column_stack([X, Y, HEIGHTS.ravel(), COLUMNS_BESIDE_XYZ[kind]]), separator))
    assert "columns 0 and 1 are the coordinates of a grid; choose x, y and z (--columns 0,1,2)" in get_error_message(
        path, **READ_OPTIONS
    )
    surface = read_surface_of_columns(path, (0, 1, 2))
    assert np.allclose(surface.heights, HEIGHTS, atol=1e-5)


def read_surface_of_columns(path, columns):
    surface = read_measurement(path, **READ_OPTIONS, columns=columns)
    assert surface.spacings == pytest.approx((0.5, 0.5))
    return surface


def test_error_about_row_numbers_in_a_point_list_states_which_columns_to_choose(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text(to_text(np.column_stack([POINT_NUMBERS + 1, X, Y, HEIGHTS.ravel()])))
    assert "(--columns 1,2,3)" in get_error_message(path, **READ_OPTIONS)
    assert np.allclose(read_surface_of_columns(path, (1, 2, 3)).heights, HEIGHTS, atol=1e-5)


def test_array_of_points_on_a_grid_is_not_read_as_a_map_of_three_columns(tmp_path):
    path = tmp_path / "a.npy"
    np.save(path, np.column_stack([X, Y, HEIGHTS.ravel()]))
    assert "choose x, y and z (--columns 0,1,2)" in get_error_message(path, **READ_OPTIONS)
    assert np.array_equal(read_surface_of_columns(path, (0, 1, 2)).heights, HEIGHTS)


@pytest.mark.parametrize(
    ("kind", "message"),
    [("colours", "column 3 has only whole numbers"), ("normals", "columns 3 to 5 are unit vectors")],
)
def test_scattered_points_with_extra_columns_are_not_read_as_a_map(tmp_path, kind, message):
    rng, path = np.random.default_rng(1), tmp_path / "a.txt"
    positions = rng.uniform(0, 9, (POINT_NUMBERS.size, 2))
    normals = SURFACE_NORMALS + 0
    normals[:, 2] = np.sqrt(1 - (normals[:, :2] ** 2).sum(axis=1)) * np.where(POINT_NUMBERS % 5, 1, -1)
    other_columns = normals if kind == "normals" else COLUMNS_BESIDE_XYZ[kind]
    path.write_text(to_text(np.column_stack([positions, HEIGHTS.ravel(), other_columns])))
    assert message in get_error_message(path, **READ_OPTIONS)


@pytest.mark.parametrize("decimals", [0, 1, 4])
@pytest.mark.parametrize("shape", [(300, 6), (12, 40), (30, 4)])
def test_map_of_rounded_heights_is_read(tmp_path, decimals, shape):
    path, heights = tmp_path / "a.csv", np.round(20 * create_map(*shape) / 5, decimals)
    path.write_text(to_text(heights, ","))
    with np.errstate(all="ignore"):
        assert np.array_equal(read_surface(path, **READ_OPTIONS, accept=("whole-numbers", "tall")).heights, heights)


# ---- Blocks and statistics ------------------------------------------------------------------------------------------


@pytest.mark.parametrize("rows_below", [1, 3, 15])
def test_second_matrix_below_an_empty_line_is_not_read_as_rows_of_the_first_matrix(tmp_path, rows_below):
    path = tmp_path / "a.txt"
    path.write_text(to_text(HEIGHTS) + "\n" + to_text(2 * create_map(rows_below, 20, seed=8)))
    message = get_error_message(path, **READ_OPTIONS)
    assert f"has 2 blocks of rows with empty lines between them (15 from line 1, {rows_below} from line 17)" in message


@pytest.mark.parametrize("numbers_below", [1, 3, 150])
def test_numbers_below_an_empty_line_are_not_appended_to_a_profile(tmp_path, numbers_below):
    path, line = tmp_path / "a.txt", HEIGHTS.ravel()[:150, None]
    path.write_text(to_text(line) + "\n" + to_text(line[:numbers_below] / 2))
    assert f"150 from line 1, {numbers_below} from line 152" in get_error_message(path, **READ_OPTIONS)


def test_empty_lines_between_all_rows_are_ignored(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text(to_text(HEIGHTS).replace("\n", "\n\n"))
    assert np.allclose(read_surface(path, **READ_OPTIONS).heights, HEIGHTS)


def test_point_count_above_an_empty_line_is_not_read_as_a_height(tmp_path):
    path, line = tmp_path / "a.txt", HEIGHTS.ravel()[:, None]
    path.write_text(f"{line.size}\n\n{to_text(line)}")
    assert np.allclose(read_measurement(path, **READ_OPTIONS).heights, line[:, 0])


FUNCTIONS_BY_STATISTIC = {
    "means": lambda z, axis: z.mean(axis),
    "standard deviations": lambda z, axis: z.std(axis),
    "maxima": lambda z, axis: z.max(axis),
    "ranges": lambda z, axis: np.ptp(z, axis),
    "sums": lambda z, axis: z.sum(axis),
}


@pytest.mark.parametrize("side", ["last row", "first row", "last column", "first column"])
@pytest.mark.parametrize("kind", FUNCTIONS_BY_STATISTIC)
def test_row_or_column_of_statistics_beside_a_matrix_is_not_read_as_heights(tmp_path, kind, side):
    axis = 0 if side.endswith("row") else 1
    lines = [HEIGHTS, np.expand_dims(FUNCTIONS_BY_STATISTIC[kind](HEIGHTS, axis), axis)]
    path = tmp_path / "a.csv"
    path.write_text(to_text(np.round(np.concatenate(lines if side[:4] == "last" else lines[::-1], axis=axis), 4), ","))
    assert f"has {kind} in its {side}; leave only heights" in get_error_message(path, **READ_OPTIONS)


def test_several_rows_of_statistics_are_not_read_as_heights(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(
        to_text(np.vstack([HEIGHTS, *(statistic(HEIGHTS, 0) for statistic in FUNCTIONS_BY_STATISTIC.values())]), ",")
    )
    assert "in its last rows; leave only heights" in get_error_message(path, **READ_OPTIONS)


@pytest.mark.parametrize("heights", [np.tile(HEIGHTS[0], (12, 1)), np.pad(HEIGHTS, 2), np.eye(12), np.zeros((9, 9))])
def test_maps_whose_last_rows_or_columns_resemble_statistics_are_read(tmp_path, heights):
    path = tmp_path / "a.csv"
    path.write_text(to_text(heights, ","))
    assert np.array_equal(read_surface(path, **READ_OPTIONS, accept="repeated-height").heights, heights)


# ---- Profiles in lines ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("per_line", [4, 5, 8, 10, 12, 16, 20])
def test_profile_with_several_heights_per_text_line_adds_a_caveat(tmp_path, per_line):
    path, profile = tmp_path / "a.txt", np.cumsum(np.random.default_rng(4).normal(size=240)) / 50
    path.write_text(to_text(profile.reshape(-1, per_line)))
    assert [caveat.name for caveat in read_with_interpretation(path, **READ_OPTIONS).caveats][:1] == ["wrapped"]
    with pytest.warns(FormatWarning, match=f"like a profile in lines of {per_line}"):
        read_measurement(path, **READ_OPTIONS)


@pytest.mark.parametrize("shape", [(15, 20), (60, 5), (30, 30), (10, 8)])
@pytest.mark.parametrize("step", [1, 4, 12])
def test_map_with_few_columns_has_no_caveat_about_a_wrapped_profile(tmp_path, shape, step):
    path = tmp_path / "a.txt"
    path.write_text(to_text(create_map(step * shape[0], shape[1])[::step]))
    assert not read_with_interpretation(path, unit="nm", spacing="0.5 um").caveats


def test_profile_whose_number_of_points_differs_from_its_header_has_a_caveat(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text("Number of points: 300\nspacing: 0.5 um\nz (um)\n" + to_text(HEIGHTS.ravel()[:299, None]))
    assert "declares 300 points, but 299 heights are read" in str(read_with_interpretation(path).caveats[0])


@pytest.mark.parametrize("order", [(3, 0, 1, 2), (3, 4, 5, 0, 1, 2), (0, 2, 1, 3), (2, 0, 1, 3)])
def test_grid_coordinates_are_found_among_columns_of_other_quantities(tmp_path, order):
    columns = np.column_stack(
        [X, Y, HEIGHTS.ravel(), np.sqrt(POINT_NUMBERS % 97) / 10, np.cos(X * Y), np.sin(POINT_NUMBERS**2)]
    )
    path = tmp_path / "a.txt"
    path.write_text(to_text(columns[:, order]))
    shuffled_indices = np.random.default_rng(4).permutation(POINT_NUMBERS)
    (tmp_path / "b.txt").write_text(to_text(columns[shuffled_indices][:, order]))
    assert "are the coordinates of a grid" in get_error_message(tmp_path / "b.txt", **READ_OPTIONS)
    x, y, z = (order.index(place) for place in (0, 1, 2))
    message = get_error_message(path, **READ_OPTIONS)
    assert f"columns {min(x, y)} and {max(x, y)} are the coordinates of a grid" in message
    assert np.array_equal(read_measurement(path, unit="um", columns=(x, y, z)).heights, HEIGHTS)


@pytest.mark.parametrize("axis", [0, 1])
def test_matrix_whose_last_row_or_column_contains_only_index_numbers_is_rejected(tmp_path, axis):
    path = tmp_path / "a.txt"
    heights = create_map(24, 18)
    numbers = np.arange(heights.shape[axis])
    path.write_text(to_text(np.insert(heights, heights.shape[1 - axis], numbers, axis=1 - axis)))
    name, number_name = ("column", "row") if axis == 0 else ("row", "column")
    message = get_error_message(path, **READ_OPTIONS)
    expected = f"and the last {name} has numbers with equal steps, like positions or {number_name} numbers; remove that"
    assert expected in message


@pytest.mark.parametrize("first_number", [0, 1])
def test_row_and_column_numbers_of_a_matrix_are_not_read_as_positions(tmp_path, first_number):
    path = tmp_path / "a.csv"
    rows = [
        ["", *range(first_number, first_number + 20)],
        *([first_number + index, *row] for index, row in enumerate(HEIGHTS.tolist())),
    ]
    path.write_text("".join(",".join(map(str, row)) + "\n" for row in rows))
    assert "contains no spacing" in get_error_message(path, unit="um")
    assert np.array_equal(read_surface(path, **READ_OPTIONS).heights, HEIGHTS)


def test_rows_narrower_than_the_matrix_below_are_rejected(tmp_path):
    path = tmp_path / "a.txt"
    heights = create_map(16, 19)
    path.write_text(
        f"Columns 1 through 8\n\n{to_text(heights[:, :8])}\nColumns 9 through 19\n\n{to_text(heights[:, 8:])}"
    )
    assert "15 more lines of numbers do not belong to the same table as lines 22 to 37" in get_error_message(
        path, **READ_OPTIONS
    )


@pytest.mark.parametrize("names", ["", "x (um) z (um)\n", "24 18\nx (um) z (um)\n"])
@pytest.mark.parametrize("words", ["Ra 0.07 x z\n", "mean\n", "a b\nc d\n"])
def test_profile_row_above_a_line_of_words_is_rejected_instead_of_skipped(tmp_path, names, words):
    path = tmp_path / "a.txt"
    rows = [f"{x:.1f} {z:.4f}\n" for x, z in zip(X[:20], HEIGHTS[0], strict=True)]
    path.write_text(names + rows[0] + words + "".join(rows[1:]))
    line = names.count("\n") + 1
    message = get_error_message(path, unit="um")
    assert f"line {line} (" in message
    assert f"a point of the profile that starts in line {line + 1 + words.count(chr(10))}, but there is text" in message


@pytest.mark.parametrize("line", ["0 1", "1 2", "0.5 0.5", "20 1", "10 0.07"])
def test_two_numbers_above_the_column_names_are_not_read_as_a_row(tmp_path, line):
    path = tmp_path / "a.txt"
    path.write_text(f"{line}\nx (um) z (um)\n" + "".join(f"{x} {z}\n" for x, z in zip(X[:20], HEIGHTS[0], strict=True)))
    assert np.array_equal(read_measurement(path).heights, HEIGHTS[0])


@pytest.mark.parametrize("point", [".", ","])
@pytest.mark.parametrize(("cut", "names"), [(0, []), (1, ["truncated"]), (4, ["truncated"]), (5, ["truncated"])])
def test_number_that_is_truncated_at_the_end_of_a_profile_has_a_caveat(tmp_path, cut, names, point):
    path = tmp_path / "a.txt"
    text = "".join(f"{x / 2:.4f};{z:.4f}\n" for x, z in enumerate(HEIGHTS.ravel()[:120])).replace(".", point)
    path.write_text(text[: len(text) - cut - 1])
    assert [caveat.name for caveat in read_with_interpretation(path, unit="um").caveats] == names


@pytest.mark.parametrize("form", [".4g", ".0f"])
def test_short_last_number_has_no_caveat_if_other_numbers_vary_in_decimals_or_have_none(tmp_path, form):
    path = tmp_path / "a.txt"
    path.write_text("\n".join(f"{z * 100:{form}}" for z in [*HEIGHTS.ravel()[:120], 0.5]))
    names = [caveat.name for caveat in read_with_interpretation(path, unit="nm", spacing="0.5 um").caveats]
    assert "truncated" not in names


def test_smooth_profile_wrapped_into_few_lines_has_a_caveat(tmp_path):
    path = tmp_path / "a.txt"
    heights = create_map(1, 125)[0]
    path.write_text(to_text(heights.reshape(5, 25)))
    assert [caveat.name for caveat in read_with_interpretation(path, **READ_OPTIONS).caveats] == ["wrapped"]


@pytest.mark.parametrize("shape", [(3, 32), (4, 25), (8, 12), (17, 16)])
@pytest.mark.parametrize("seed", range(4))
def test_rough_profile_wrapped_into_many_lines_has_a_caveat(tmp_path, shape, seed):
    path, rng = tmp_path / "a.txt", np.random.default_rng(seed)
    profile = np.convolve(rng.normal(size=shape[0] * shape[1] + 20), np.hanning(9), "same")[10:-10]
    path.write_text(to_text(profile.reshape(shape)))
    assert [caveat.name for caveat in read_with_interpretation(path, **READ_OPTIONS).caveats][:1] == ["wrapped"]


@pytest.mark.parametrize("shape", [(4, 25), (7, 25)])
def test_rough_profile_wrapped_into_few_lines_has_a_caveat(tmp_path, shape):
    path = tmp_path / "a.txt"
    for seed in range(40):
        rng = np.random.default_rng(seed)
        profile = np.convolve(rng.normal(size=shape[0] * shape[1] + 20), np.hanning(9), "same")[10:-10]
        path.write_text(to_text((profile + 0.25 * rng.normal(size=profile.size)).reshape(shape)))
        assert "wrapped" in [caveat.name for caveat in read_with_interpretation(path, **READ_OPTIONS).caveats], seed


@pytest.mark.parametrize("seed", range(10))
def test_map_with_lay_along_its_rows_has_no_caveat_about_a_wrapped_profile(tmp_path, seed):
    path, rng = tmp_path / "a.txt", np.random.default_rng(seed)
    grooves = np.convolve(rng.normal(size=46), np.hanning(5), "same")[3:-3, np.newaxis]
    path.write_text(to_text(grooves + np.cumsum(rng.normal(size=(40, 24)), axis=1) / 20))
    assert "wrapped" not in [caveat.name for caveat in read_with_interpretation(path, **READ_OPTIONS).caveats]


# ---- Coordinates that are not in columns ----------------------------------------------------------------------------


def test_rows_of_coordinates_above_a_row_of_heights_are_rejected(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text(to_text(np.stack([X, Y, HEIGHTS.ravel()])))
    assert "has 3 rows, of which rows 0 and 1, counted from 0, are the coordinates" in get_error_message(
        path, **READ_OPTIONS
    )


@pytest.mark.parametrize("order", ["C", "F"])
def test_single_column_that_lists_coordinates_before_heights_is_rejected(tmp_path, order):
    path = tmp_path / "a.txt"
    columns = [column.reshape(HEIGHTS.shape).ravel(order) for column in (X, Y, HEIGHTS)]
    path.write_text(to_text(np.concatenate(columns)[:, np.newaxis]))
    assert "lists all x, then all y and all z" in get_error_message(path, **READ_OPTIONS)


def test_single_column_that_lists_positions_before_heights_is_rejected(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text(to_text(np.concatenate([np.arange(120) / 2, HEIGHTS.ravel()[:120]])[:, np.newaxis]))
    assert "lists all x and then all z" in get_error_message(path, **READ_OPTIONS)


def test_profile_that_starts_with_a_ramp_is_read_completely(tmp_path):
    path = tmp_path / "a.txt"
    path.write_text(to_text(np.concatenate([np.arange(120) / 100, HEIGHTS.ravel()[:151]])[:, np.newaxis]))
    assert read_measurement(path, **READ_OPTIONS).heights.size == 271
