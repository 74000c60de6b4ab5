"""Tables for contact laws: the numbers of pressing by hand, what must rise, the fitted laws, and the command."""

import csv

import numpy as np
import pytest
import xarray
from stiction import half_space, pair_of, run
from stiction.studies.friction_table import friction_table, table_study
from support.command import assert_rejected, call_stiction, check_stiction

SMALL = {
    "hurst_exponents": [0.6, 0.8], "rms": [0.01, 0.03], "pressures": [0.003, 0.01, 0.03, 0.1], "points": 48,
    "shortest_wavelength": 0.625, "repetitions": 4, "mu0": [0.3], "tau0": [0.0, 0.05],
}  # fmt: skip

SOLVED = 1e-4  # sums of two solutions to 1e-6 that begin differently


@pytest.fixture(scope="module")
def dataset():
    return run(table_study(**SMALL)).dataset


@pytest.fixture(scope="module")
def table(dataset):
    return friction_table(dataset)


def test_friction_table_equals_direct_computation(dataset, table):
    study = table_study(**SMALL)
    loads = [item * 100 for item in SMALL["pressures"]]
    curves = {rule: [] for rule in ("opposing", "all")}
    for repetition in range(4):
        upper, lower = pair_of(study, repetition, fractal_dimension=1.4, amplitude=0.03)
        assert upper.heights.std() == pytest.approx(0.03)
        for rule, result in curves.items():
            result.append(
                half_space(upper, lower, loads, boundary="periodic", direction=[0.0, 90.0, 180.0, 270.0], sliding=rule)
            )
    at = table.sel(hurst_exponent=0.6, method="nearest").sel(rms=0.03, method="nearest")
    area = np.mean([curve.contact_area for curve in curves["all"]], axis=0) / 100
    np.testing.assert_allclose(at["contact_area_fraction"].sel(statistic="mean"), area, rtol=SOLVED)
    for rule, result in curves.items():
        normal, tangential = (
            np.mean([getattr(curve, f"{part}_load")(mu0=0.3, tau0=0.05) for curve in result], axis=(0, 1))
            for part in ("normal", "tangential")
        )
        mean = at["friction_coefficient"].sel(sliding=rule, mu0=0.3, tau0=0.05, statistic="mean")
        np.testing.assert_allclose(mean, tangential / normal, rtol=SOLVED)
    # dF/dδ of the patches as they are, without those that appear: no more than that of the curve.
    fixed = np.mean([curve.stiffness for curve in curves["all"]], axis=0) / 100
    ratio = at["normal_stiffness"].sel(statistic="mean").values[1:-1] / fixed[1:-1]
    assert ((ratio > 0.8) & (ratio < 1.3)).all()


def test_negative_load_leaves_stiffness_law_undefined(dataset, table):
    """Its approach falls with the load."""
    other = dataset.copy(deep=True)
    other["approach"].values[0, 0, 1] *= -1
    result = friction_table(other)
    for name in ("stiffness_factor", "stiffness_exponent", "stiffness_deviation"):
        assert np.isnan(result[name].isel(hurst_exponent=1, rms=0)).all()
        assert result[name].isel(hurst_exponent=0).equals(table[name].isel(hurst_exponent=0))


def test_tabulated_quantities_increase_with_pressure(table):
    mean = table.sel(statistic="mean")
    for name in ("contact_area_fraction", "normal_stiffness", "approach"):
        assert (mean[name].diff("pressure") > 0).all(), name
    # Rougher surfaces touch less, and friction without adhesion rises with slope and with mu0.
    assert (mean["contact_area_fraction"].diff("rms") < 0).all()
    assert (mean["contact_area_fraction"].diff("hurst_exponent") > 0).all()
    assert (mean["friction_coefficient"].diff("tau0") > 0).all()
    lower, upper = (table["contact_area_fraction"].sel(statistic=item) for item in ("lower", "upper"))
    assert ((lower < mean["contact_area_fraction"]) & (mean["contact_area_fraction"] < upper)).all()


def test_fitted_laws_pass_through_light_pressures(table):
    for place in np.ndindex(2, 2):
        at = table.isel(hurst_exponent=place[0], rms=place[1])
        mean = at.sel(statistic="mean")
        light = mean["contact_area_fraction"].values <= 0.1
        p = table["pressure"].values[light]
        off = np.abs(mean["contact_area_fraction"].values[light] / (float(mean["area_factor"]) * p) - 1).max()
        assert off == pytest.approx(float(at["area_deviation"]))
        assert off < 0.25
        assert 0.6 < float(mean["stiffness_exponent"]) < 1.1


def test_exact_power_law_is_recovered(dataset):
    """With areas and approaches that follow laws exactly."""
    created = dataset.copy(deep=True)
    pressure = created["load"].values / 100
    created["contact_area"].values[...] = 100 * 1.5 * pressure
    created["approach"].values[...] = 0.02 * np.log(pressure) + 1  # k = p / 0.02
    result = friction_table(created)
    assert result["area_factor"].values == pytest.approx(1.5)
    assert result["area_deviation"].values == pytest.approx(0, abs=1e-12)
    assert result["stiffness_factor"].values == pytest.approx(50)
    assert result["stiffness_exponent"].values == pytest.approx(1)


def test_intervals_equal_a_jackknife(dataset, table):
    """Two pairs are left out in turn by hand; the width is held to the spread of the pairs' own coefficients."""
    at = table["friction_coefficient"].isel(hurst_exponent=0, rms=0, mu0=0, tau0=0, pressure=3).sel(sliding="all")
    mean, lower, upper = at.values
    assert lower < mean < upper
    parts = dataset.isel(fractal_dimension=1, amplitude=0, load=3).sel(sliding="all").mean("direction")
    each = (parts["tangential_elastic"] + 0.3 * parts["tangential_frictional"]) / (
        parts["normal_elastic"] + 0.3 * parts["normal_frictional"]
    )
    error = float(each.std(ddof=1)) / 2
    assert 2 * error < upper - mean < 14 * error


def test_friction_table_rejects_study_of_profiles(small_result):
    with pytest.raises(ValueError, match="must be of a study of surfaces by the half-space"):
        friction_table(small_result)


ASKED = [
    "--effective-modulus", "10 GPa", "--hurst", "0.8", "--rms", "20 nm", "--load", "3 MPa,10 MPa,30 MPa",
    "--points", "32", "--wavelengths", "0.625 um,2.5 um", "--repetitions", "3",
]  # fmt: skip


def test_table_command_equals_library(tmp_path):
    check_stiction("table", *ASKED, cwd=tmp_path)
    study = table_study(
        hurst_exponents=[0.8], rms=[0.02], pressures=[0.003, 0.01, 0.03], points=32, shortest_wavelength=0.625,
        repetitions=3,
    )  # fmt: skip
    expected = friction_table(run(study))
    with xarray.open_dataset(tmp_path / "table" / "table.nc", engine="h5netcdf") as stored:
        for name in expected.data_vars:
            np.testing.assert_allclose(stored[name].values, expected[name].values, rtol=1e-9, err_msg=name)
    rows = list(csv.DictReader((tmp_path / "table" / "table.csv").read_text().splitlines()))
    assert len(rows) == 2 * 3 * 3
    assert [float(row["pressure (MPa)"]) for row in rows[::3]] == pytest.approx([3, 10, 30, 3, 10, 30])
    one = expected["friction_coefficient"].isel(sliding=0, hurst_exponent=0, rms=0, pressure=0, mu0=0, tau0=0)
    assert float(rows[0]["mu_s"]) == pytest.approx(float(one[0]))
    laws = list(csv.DictReader((tmp_path / "table" / "laws.csv").read_text().splitlines()))
    assert float(laws[0]["c of k/A0 = b p^c"]) == pytest.approx(float(expected["stiffness_exponent"][0, 0, 0]))
    # The same command goes on, also with other materials.
    check_stiction("table", *ASKED, "--mu0", "0.1", cwd=tmp_path)
    assert len((tmp_path / "table" / "table.csv").read_text().splitlines()) == 1 + 2 * 3


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (["--load", "1 mN"], "--load must be a pressure"),
        (["--wavelengths", "1 um"], "--wavelengths must be two lengths"),
        (["--hurst", "rough"], "--hurst must be a number or several"),
    ],
)
def test_table_command_rejects_bad_options(tmp_path, changes, words):
    assert_rejected(call_stiction("table", *ASKED, *changes, cwd=tmp_path), words)
    assert not (tmp_path / "table" / "table.nc").exists()
