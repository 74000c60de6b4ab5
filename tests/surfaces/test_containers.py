"""Tests of files that contain several arrays, sheets or channels, and of files without a signature."""

import io

import numpy as np
import pytest
from stiction import FormatError, read_measurement, read_surface

HEIGHTS = np.random.default_rng(5).normal(size=(6, 9))
CONTAINERS = ["npz", "mat", "h5"]


def write_arrays(path, **arrays):
    """Write named arrays in the format of the file name extension."""
    if path.suffix == ".npz":
        np.savez(path, **arrays)
    elif path.suffix == ".mat":
        pytest.importorskip("scipy.io").savemat(path, arrays)
    else:
        with pytest.importorskip("h5py").File(path, "w") as file:
            for name, array in arrays.items():
                file[name] = array
    return path


def get_error_message(path, **options):
    with pytest.raises(FormatError) as error_info:
        read_measurement(path, unit="um", **options)
    return str(error_info.value)


@pytest.mark.parametrize("suffix", CONTAINERS)
def test_array_in_a_container_is_oriented_like_the_same_array_in_an_npy_file(tmp_path, suffix):
    pytest.importorskip("SurfaceTopography")
    np.save(tmp_path / "map.npy", HEIGHTS)
    options = {"unit": "um", "spacing": ("2 um", "1 um")}
    expected = read_surface(tmp_path / "map.npy", **options)
    surface = read_surface(write_arrays(tmp_path / f"map.{suffix}", z=HEIGHTS), **options)
    assert np.array_equal(surface.heights, expected.heights)
    assert surface.spacings == expected.spacings


@pytest.mark.parametrize("suffix", CONTAINERS)
def test_container_with_several_arrays_is_rejected_with_a_list_of_names_unless_an_array_is_chosen(tmp_path, suffix):
    pytest.importorskip("SurfaceTopography")
    x, y = np.meshgrid(np.arange(9.0), np.arange(6.0))
    path = write_arrays(tmp_path / f"map.{suffix}", X=x, Y=y, Z=HEIGHTS)
    assert "contains the channels 0 (X), 1 (Y), 2 (Z); choose one" in get_error_message(path, spacing="1 um")
    assert np.array_equal(read_surface(path, unit="um", spacing="1 um", channel="Z").heights, HEIGHTS)


@pytest.mark.parametrize("suffix", CONTAINERS)
@pytest.mark.parametrize(
    "name",
    ["mask", "valid_mask", "x", "branch_indexes", "labels", "phase", "slope_x", "velocity", "current_nA", "amplitude"],
)
def test_array_named_after_another_quantity_is_read_only_if_the_array_is_chosen(tmp_path, suffix, name):
    pytest.importorskip("SurfaceTopography")
    path = write_arrays(tmp_path / f"map.{suffix}", **{name: HEIGHTS})
    assert f"contains the channels 0 ({name}); choose one" in get_error_message(path, spacing="1 um")


@pytest.mark.parametrize("suffix", CONTAINERS)
def test_array_of_zeros_and_ones_is_not_read_as_heights(tmp_path, suffix):
    pytest.importorskip("SurfaceTopography")
    path = write_arrays(tmp_path / f"map.{suffix}", z=(HEIGHTS > 0).astype(np.uint8))
    assert "has a channel 0 (z) with only 0 and 1, like a mask" in get_error_message(path, spacing="1 um")


def test_two_columns_of_an_array_in_a_container_are_read_as_a_profile(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = write_arrays(tmp_path / "scan.npz", scan=np.column_stack([np.arange(40) * 0.5, np.resize(HEIGHTS, 40)]))
    profile = read_measurement(path, unit="um")
    assert profile.spacing == pytest.approx(0.5)
    assert np.array_equal(profile.heights, np.resize(HEIGHTS, 40))


def test_container_without_an_array_of_heights_is_rejected(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = write_arrays(tmp_path / "map.h5", z=HEIGHTS[0])
    assert "contains no matrix of numbers that may be heights" in get_error_message(path, spacing="1 um")


@pytest.mark.parametrize("suffix", [".bin", ".xls", ".dat", ".raw"])
def test_file_without_a_format_signature_is_not_read_as_a_map(tmp_path, suffix):
    pytest.importorskip("SurfaceTopography")
    path = tmp_path / f"scan{suffix}"
    path.write_bytes(np.random.default_rng(2).integers(0, 256, 2 * 32 * 32, dtype=np.uint8).tobytes())
    assert "is not a profile or surface in a known format" in get_error_message(path, spacing="1 um")


def test_elevation_model_is_read_if_its_extension_declares_the_format(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = tmp_path / "scan.hgt"
    path.write_bytes(np.arange(500, 1524, dtype=">i2").tobytes())
    assert read_surface(path, unit="nm", spacing="1 um").heights.shape == (32, 32)


# ---- Workbooks ------------------------------------------------------------------------------------------------------


def write_workbook(path, **sheets):
    workbook = pytest.importorskip("openpyxl").Workbook()
    workbook.remove(workbook.active)
    for title, rows in sheets.items():
        sheet = workbook.create_sheet(title)
        for row in rows:
            sheet.append(row)
    content = io.BytesIO()
    workbook.save(content)
    path.write_bytes(content.getvalue())
    return path


def test_workbook_column_of_unevaluated_formulas_is_rejected(tmp_path):
    rows = [["x (um)", "raw", "z (um)"]]
    rows += [[index / 2, z, f"=B{index + 2}*2"] for index, z in enumerate(HEIGHTS.ravel().tolist())]
    path = write_workbook(tmp_path / "a.xlsx", one=rows)
    assert "has words in column 2 (z (um)): 'unevaluated formula' (54)" in get_error_message(path)
    only_formulas = write_workbook(tmp_path / "b.xlsx", one=[["z (um)"], *([row[2]] for row in rows[1:])])
    assert "has formulas without values, so save it in a spreadsheet program" in get_error_message(only_formulas)


@pytest.mark.parametrize("cutoff_sheet", ["Certificate", "DATA"])
def test_material_ratio_curves_of_a_mitutoyo_workbook_are_not_read_as_heights(tmp_path, cutoff_sheet):
    z = HEIGHTS.ravel().tolist()
    rows = [
        [None, None, index / 100, 99 - index, index / 2000, height, index / 90, 99 - index]
        for index, height in enumerate(z)
    ]
    rows[0][:2] = "Ra     0.641  µm      ", "CUT 2.5mm" if cutoff_sheet == "DATA" else "N 4"
    certificate = [["Cut-off", "2.5mm"]] if cutoff_sheet == "Certificate" else [["number", "7"]]
    profile = read_measurement(write_workbook(tmp_path / "a.xlsx", Certificate=certificate, DATA=rows))
    assert profile.heights == pytest.approx(z)
    assert profile.spacing == pytest.approx(0.5)


def test_channel_is_selected_by_its_complete_name_including_a_remark_in_brackets(tmp_path):
    rows = [[index / 2, z, -z, 2 * z] for index, z in enumerate(HEIGHTS.ravel().tolist())]
    path = write_workbook(tmp_path / "a.xlsx", one=[["x (um)", "z (trace)", "z (retrace)", "phase"], *rows])
    assert "has no column named 'z (backward)'" in get_error_message(path, columns="z (backward)")
