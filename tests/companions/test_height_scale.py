"""Test results with scaled heights: scaling laws, solutions of scaled bodies, interpolation and stored factors."""

from __future__ import annotations

import re

import numpy as np
import pytest
from stiction import joined_spectrum, open_result, pair, self_affine, self_affine_surface, write_surface
from stiction.companions import height_scale
from stiction.companions.height_scale import (
    MAX_FACTOR,
    MIN_FACTOR,
    MissingHeightFactorsError,
    compute_results_at_height_factors,
    evaluate_at_height_factors,
    find_missing_factors,
    open_results_by_factor,
    parse_height_factors,
    scale_study_heights,
)
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.solve.store import STUDY_FILE, open_stored_result
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.views.report import report_page
from stiction.views.style import axis_label
from support.command import disable_drawing
from support.generated_studies import TINY_STUDY
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_companion_files")

SCALING_TOLERANCE = 1e-9
SOLUTION_TOLERANCE = 1e-3  # for solutions of one problem in different units
MAX_FRICTION_ERROR, MAX_AREA_ERROR = 0.005, 0.02
PAIR_OPTIONS = {"load": "20 MPa", "mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "80 GPa", "shifts": 3, "onset": 0}
HARDNESS_OPTION = {"hardness": "2 GPa"}


def create_smooth_maps(points=48, rms=0.02):
    return rough_maps(7, points=points, rms=rms, shortest_wavelength=0.6)


def scale_heights(bodies, upper, lower=None):
    factors = upper, upper if lower is None else lower
    return [body.changed(body.heights * factor, "scaled") for body, factor in zip(bodies, factors, strict=True)]


def get_mean_values(table, rule="all"):
    table = table.sel(statistic="mean")
    return np.squeeze((table.sel(sliding=rule) if "sliding" in table.dims else table).values)


def get_requested_loads(result):
    return [float(load) for load in result.study.friction.load]


@pytest.fixture(scope="module")
def bodies():
    return create_smooth_maps()


@pytest.fixture(scope="module")
def result(bodies):
    """Return a result with stored height factors: both surfaces scaled by 0.5 and 2, and the upper scaled by 2."""
    pair_result = pair(*bodies, **PAIR_OPTIONS | HARDNESS_OPTION)
    compute_results_at_height_factors(pair_result.source, [0.5, 2])
    compute_results_at_height_factors(pair_result.source, [2], "upper")
    return pair_result


# ---- Laws ------------------------------------------------------------------------------------------------------------


def test_result_at_a_height_factor_of_1_equals_the_unscaled_result(result):
    scaled_table = evaluate_at_height_factors(result.source, 1, get_requested_loads(result)).isel(height_scale=0)
    expected = add_uncertainty(at_load(result.source, get_requested_loads(result)), result.source).isel(cut_off=0)
    for name in ("mean_friction", "friction_combined", "contact_area_fraction", "normal_stiffness", "rms_gradient"):
        assert np.array_equal(scaled_table[name], expected[name].transpose(*scaled_table[name].dims), equal_nan=True), (
            name
        )


def test_area_of_plastic_contacts_equals_load_divided_by_hardness_at_every_height_factor(bodies):
    pair_result = pair(*bodies, **PAIR_OPTIONS | {"hardness": "0.1 GPa", "effective_modulus": "1000 GPa"})
    table = pair_result.at(height_scale=[0.5, 1, 4], compute=True)
    assert get_mean_values(table["contact_area_fraction"]) == pytest.approx(0.02 / 0.1, rel=0.02)


@pytest.mark.parametrize("hardness", [{}, {"hardness": "0.2 GPa"}])
def test_scaling_heights_has_the_same_effect_as_scaling_modulus(hardness):
    flat_surfaces, kwargs = (
        create_smooth_maps(rms=0.002),
        PAIR_OPTIONS | hardness | {"load": "2 MPa"},
    )  # tolerance for slopes, which increase the true area by 1e-4
    table = pair(*flat_surfaces, **kwargs).at(height_scale=[0.5, 2], compute=True)
    for index, factor in enumerate((0.5, 2)):
        stiffer_table = pair(*flat_surfaces, **kwargs | {"effective_modulus": f"{80 * factor} GPa"}).at()
        assert get_mean_values(table["contact_area"])[index] == pytest.approx(
            get_mean_values(stiffer_table["contact_area"]), rel=SOLUTION_TOLERANCE
        )
        stiffness = factor * get_mean_values(table["normal_stiffness"])[index]
        assert stiffness == pytest.approx(get_mean_values(stiffer_table["normal_stiffness"]), rel=SOLUTION_TOLERANCE)


# ---- Against scaled bodies -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("scaled_bodies", "factors"), [("both", (2, 2)), ("upper", (2, 1))])
def test_result_at_a_stored_height_factor_equals_the_result_of_scaled_surfaces(bodies, result, scaled_bodies, factors):
    table = evaluate_at_height_factors(result.source, [2], get_requested_loads(result), scaled=scaled_bodies).isel(
        height_scale=0
    )
    scaled_result = pair(*scale_heights(bodies, *factors), **PAIR_OPTIONS | HARDNESS_OPTION)
    expected = add_uncertainty(
        at_load(scaled_result.source, get_requested_loads(scaled_result)), scaled_result.source
    ).isel(cut_off=0)
    for name in ("mean_friction", "friction_combined", "contact_area", "normal_stiffness", "rms_gradient"):
        np.testing.assert_allclose(
            table[name], expected[name].transpose(*table[name].dims), rtol=SCALING_TOLERANCE, err_msg=name
        )
    assert float(table["upper_rms"]) == pytest.approx(
        2 * float(result.at(height_scale=1)["upper_rms"][0]), rel=SCALING_TOLERANCE
    )


def test_results_with_scaled_heights_are_equal_for_scan_files_and_surfaces_in_memory(bodies, result, tmp_path):
    for side, body in zip(("upper", "lower"), bodies, strict=True):
        write_surface(body, tmp_path / f"{side}.npy")
    pair_result = pair(tmp_path / "upper.npy", tmp_path / "lower.npy", **PAIR_OPTIONS | HARDNESS_OPTION)
    table_of_files, expected = pair_result.at(height_scale=2, compute=True), result.at(height_scale=2)
    np.testing.assert_allclose(
        table_of_files["friction_combined"], expected["friction_combined"], rtol=SCALING_TOLERANCE
    )


def test_height_factor_scales_every_scan_of_each_face(bodies):
    scans = [bodies, rough_maps(8, shortest_wavelength=0.6)]
    uppers, lowers = ([scan[side] for scan in scans] for side in (0, 1))
    pair_result = pair(uppers, lowers, **PAIR_OPTIONS | HARDNESS_OPTION)
    table = pair_result.at(height_scale=2, compute=True)
    scaled_scans = [scale_heights(scan, 2) for scan in scans]
    expected = pair(
        [scan[0] for scan in scaled_scans], [scan[1] for scan in scaled_scans], **PAIR_OPTIONS | HARDNESS_OPTION
    )
    assert get_mean_values(table["contact_area"]) == pytest.approx(
        get_mean_values(expected.at()["contact_area"]), rel=SCALING_TOLERANCE
    )


def test_power_spectrum_is_scaled_by_the_square_of_the_height_factor():
    surface = rough_maps(3, points=64, rms=0.02, shortest_wavelength=0.6)[0]
    spectrum = joined_spectrum([surface])
    kwargs = PAIR_OPTIONS | HARDNESS_OPTION | {"shifts": None, "direction": [0.0, 180.0]}
    kwargs = {name: value for name, value in kwargs.items() if value is not None}
    pair_result = pair(spectrum, spectrum, **kwargs)
    table = pair_result.at(height_scale=[1, 2], compute=True)
    assert get_mean_values(table["rms_gradient"])[1] == pytest.approx(
        2 * get_mean_values(table["rms_gradient"])[0], rel=SCALING_TOLERANCE
    )
    assert table["upper_rms"].values[1] == pytest.approx(2 * table["upper_rms"].values[0], rel=SCALING_TOLERANCE)


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_heights_of_profiles_can_be_scaled_in_both_contact_models(mechanics):
    profiles = [self_affine(2, hurst_exponent=0.8, rms=0.05, points=600, spacing=0.05, side=side) for side in
             ("upper", "lower")]  # fmt: skip
    kwargs = {
        "load": "0.1 mN",
        "mu0": 0.3,
        "effective_modulus": "10 GPa",
        "mechanics": mechanics,
        "offsets": 6,
        "onset": 0,
    }
    table = pair(*profiles, **kwargs).at(height_scale=0.5, compute=True)
    expected = pair(*scale_heights(profiles, 0.5), **kwargs).at().isel(cut_off=0)
    for name in ("mean_friction", "contact_area", "rms_gradient"):
        reference = expected[name].transpose(*table[name].dims[1:])
        np.testing.assert_allclose(table[name].isel(height_scale=0), reference, rtol=SCALING_TOLERANCE, err_msg=name)


def test_pull_off_force_decreases_with_the_height_factor():
    smooth_surfaces = rough_maps(
        3, points=40, rms=0.003, spacing=0.01, longest_wavelength=0.2, shortest_wavelength=0.04
    )
    pair_result = pair(
        *smooth_surfaces, load="2 MPa", mu0=0.3, effective_modulus=80.0, shifts=2, onset=0, work_of_adhesion="50 mJ/m^2"
    )
    table = pair_result.at(height_scale=[0.25, 1], compute=True)
    pull_off = get_mean_values(table["pull_off"])
    assert pull_off[0] > pull_off[1] > 0


# ---- Between factors -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("hardness", [{}, HARDNESS_OPTION])
def test_interpolation_between_height_factors_has_at_most_the_documented_error(hardness):
    pair_result = pair(*create_smooth_maps(rms=0.01), **PAIR_OPTIONS | hardness | {"load": "100 MPa"})
    compute_results_at_height_factors(pair_result.source, "0.5..2")
    factors = np.array([0.6, 1.7])
    table = pair_result.at(height_scale=factors)
    for index, factor in enumerate(factors):
        exact_table = pair(
            *scale_heights(create_smooth_maps(rms=0.01), factor), **PAIR_OPTIONS | hardness | {"load": "100 MPa"}
        ).at()
        coefficient, area = (
            get_mean_values(table["mean_friction"])[index],
            get_mean_values(table["contact_area"])[index],
        )
        assert coefficient == pytest.approx(get_mean_values(exact_table["mean_friction"]), rel=MAX_FRICTION_ERROR)
        assert area == pytest.approx(get_mean_values(exact_table["contact_area"]), rel=MAX_AREA_ERROR)
    combined_intervals = table["friction_combined"]
    assert (combined_intervals.sel(statistic="lower") <= combined_intervals.sel(statistic="mean")).all()
    assert (combined_intervals.sel(statistic="mean") <= combined_intervals.sel(statistic="upper")).all()


def test_interval_interpolated_between_height_factors_contains_the_direct_solution():
    bodies = [
        self_affine_surface(
            30, side=side, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, shortest_wavelength=0.4
        )
        for side in ("upper", "lower")
    ]
    options = {
        "load": "30 MPa", "effective_modulus": 80.0, "onset": 0, "cutoff": "none", "mu0": 0.2, "tau0": 0.05,
        "shifts": 3, "direction": [0, 90],
    }  # fmt: skip
    result = pair(*bodies, **options)
    result.at(height_scale=[1, 2**0.5], compute=True)
    factors = [1.19, 1.26]
    table = result.at(height_scale=factors).squeeze()
    for index, factor in enumerate(factors):
        direct_values = pair(*scale_heights(bodies, factor), **options).at().squeeze()
        for name in ("mean_friction", "friction_combined", "stiffness_per_area", "contact_area"):
            _, lower, upper = np.moveaxis(table[name].isel(height_scale=index).values, -1, 0)
            value = direct_values[name].sel(statistic="mean").values
            assert ((lower <= value) & (value <= upper)).all()
            assert (lower >= 0).all()
    # Without interpolation error, the width would be linear in the logarithm of the height factor.
    areas = result.at(height_scale=[1, 2**0.25, 2**0.5])["contact_area"].squeeze()
    width = np.log(areas.sel(statistic="upper") / areas.sel(statistic="lower")).values
    assert width[1] > 1.01 * (width[0] + width[2]) / 2


def test_search_for_missing_height_factors_finds_only_factors_that_interpolation_requires():
    assert find_missing_factors(np.array([0.5, 1.0]), np.array([0.5, 1.0])).size == 0
    assert find_missing_factors(np.array([1.2]), np.array([1.0, 1.41421])).size == 0
    assert find_missing_factors(np.array([1.2]), np.array([1.0, 2.0])).tolist() == [1.2]
    fine_factors = np.round(np.geomspace(0.25, 4, 50), 6)
    assert find_missing_factors(fine_factors, np.ones(1)).tolist() == [
        0.25, 0.353553, 0.5, 0.707107, 1.41421, 2.0, 2.82843, 4.0,
    ]  # fmt: skip
    ends = find_missing_factors(np.geomspace(MIN_FACTOR, MAX_FACTOR, 99), np.ones(1))
    assert (ends[0], ends[-1]) == (MIN_FACTOR, MAX_FACTOR)


def test_interpolation_next_to_a_height_factor_without_solution_is_nan():
    solved_factors = np.array([0.5, 1.0, 2.0])
    values = np.array([[1.0, np.nan], [2.0, 2.0], [4.0, 4.0]])
    assert (
        height_scale._interpolate_between_factors(values, solved_factors, 0.7, (0, 1))[1]
        != height_scale._interpolate_between_factors(values, solved_factors, 0.7, (0, 1))[1]
    )
    np.testing.assert_allclose(
        height_scale._interpolate_between_factors(values, solved_factors, 1.5, (1, 2)), [3.0, 3.0]
    )
    zeros = np.array([[0.0], [0.0], [1.0]])
    assert height_scale._interpolate_between_factors(zeros, solved_factors, 0.7, (0, 1)) == 0.0


# ---- Input -----------------------------------------------------------------------------------------------------------


def test_height_factors_can_be_given_as_numbers_or_lists_or_ranges():
    assert parse_height_factors("0.5..2").tolist() == [0.5, 0.707107, 1.0, 1.41421, 2.0]
    assert parse_height_factors("0.3 .. 0.6").tolist() == [0.3, 0.353553, 0.5, 0.6]
    assert parse_height_factors("2,0.5,1").tolist() == parse_height_factors([2, 0.5, 1]).tolist() == [0.5, 1.0, 2.0]
    assert parse_height_factors(1 / 3).tolist() == [0.333333]


@pytest.mark.parametrize(
    "factors",
    [
        0,
        -1,
        0.001,
        1000,
        np.nan,
        np.inf,
        [],
        "",
        "a",
        "a..b",
        "4..0.25",
        "1..1",
        "0..4",
        "1..2..3",
        "1,5",
        "nan",
        "1..inf",
    ],
)
def test_height_factors_outside_the_allowed_range_are_rejected(factors):
    with pytest.raises(ValueError, match="height_scale"):
        parse_height_factors(factors)


def test_height_factor_is_rejected_if_the_product_with_the_factor_of_a_scan_is_too_large():
    body = MeasuredBodySettings.model_validate([{"file": "a.csv"}, {"file": "b.csv", "height_factor": 50.0}])
    assert [scan.height_factor for scan in body.with_height_factor(2.0).scans] == [2.0, 100.0]
    with pytest.raises(ValueError, match=r"height_factor must be from 0\.01 to 100, got 500 for b\.csv"):
        body.with_height_factor(10.0)


def test_scaling_of_heights_rejects_unsuitable_results_and_invalid_options(bodies, result):
    with pytest.raises(ValueError, match="two measured surfaces, got generated surfaces"):
        scale_study_heights(TINY_STUDY, 2.0, "both")
    gap = pair(gap=bodies[0], **{name: value for name, value in PAIR_OPTIONS.items() if name != "shifts"})
    with pytest.raises(ValueError, match="got the gap of one body"):
        gap.at(height_scale=2)
    with pytest.raises(ValueError, match="scaled must be one of"):
        result.at(height_scale=1, scaled="left")
    with pytest.raises(ValueError, match="load_definition must be 'elastic'"):
        result.at(height_scale=1, load_definition="normal")
    with pytest.raises(ValueError, match="needs a stored result"):
        type(result)(result.dataset).at(height_scale=1)
    with pytest.raises(ValueError, match=r"height_factor must be from 0\.01 to 100, got 200"):
        scale_study_heights(scale_study_heights(result.study, 50.0, "both"), 4.0, "both")


def test_missing_height_factors_raise_an_error_with_the_estimated_time(result):
    with pytest.raises(
        MissingHeightFactorsError,
        match=r"^height_scale needs results at .*, about .*; give compute=True to compute them$",
    ) as error_info:
        result.at(height_scale="0.25..4")
    assert error_info.value.factors.tolist() == [0.25, 0.353553, 0.707107, 1.41421, 2.82843, 4.0]
    assert error_info.value.seconds > 0


# ---- Stored factors --------------------------------------------------------------------------------------------------


def test_results_at_finished_height_factors_are_preserved_after_an_interrupt(bodies, tmp_path):
    pair_result = pair(*bodies, directory=tmp_path, **PAIR_OPTIONS | HARDNESS_OPTION)
    announcements = []

    def interrupt_at_second_line(line):
        announcements.append(line)
        if len(announcements) == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        compute_results_at_height_factors(pair_result.source, [0.5, 2, 4], announce=interrupt_at_second_line)
    assert announcements == ["heights times 0.5 (1 of 3)", "heights times 2 (2 of 3)"]
    assert list(open_results_by_factor(pair_result.source, "both")) == [0.5, 1.0]
    compute_results_at_height_factors(pair_result.source, [0.5, 2, 4], announce=announcements.append)
    assert announcements[2:] == ["heights times 2 (1 of 2)", "heights times 4 (2 of 2)"]
    assert open_result(tmp_path).at(height_scale=[0.5, 2, 4]).sizes["height_scale"] == 3


def test_results_at_stored_height_factors_are_reused_for_new_mu0_but_not_for_new_modulus(bodies, tmp_path):
    kwargs = PAIR_OPTIONS | HARDNESS_OPTION
    first_result = pair(*bodies, directory=tmp_path, **kwargs)
    compute_results_at_height_factors(first_result.source, [2])
    result_at_other_mu0 = pair(*bodies, directory=tmp_path, **kwargs | {"mu0": 0.4})
    table = result_at_other_mu0.at(height_scale=[1, 2])
    assert table["mu0"].values.tolist() == [0.4]
    assert (get_mean_values(table["mean_friction"]) > 2 / 6.05).all()
    stiffer_result = pair(*bodies, directory=tmp_path, replace=True, **kwargs | {"effective_modulus": "160 GPa"})
    assert list(open_results_by_factor(stiffer_result.source, "both")) == [1.0]
    table = stiffer_result.at(height_scale=2, compute=True)
    exact_table = pair(*scale_heights(bodies, 2), **kwargs | {"effective_modulus": "160 GPa"}).at()
    assert get_mean_values(table["contact_area"]) == pytest.approx(
        get_mean_values(exact_table["contact_area"]), rel=SCALING_TOLERANCE
    )


def test_interval_for_uncertain_hardness_at_a_height_factor_equals_the_interval_for_scaled_heights(bodies):
    kwargs = PAIR_OPTIONS | {"hardness": "1..3 GPa"}
    table = pair(*bodies, **kwargs).at(height_scale=2, compute=True).isel(height_scale=0)
    scaled_result = pair(*scale_heights(bodies, 2), **kwargs)
    expected = add_uncertainty(
        at_load(scaled_result.source, get_requested_loads(scaled_result)), scaled_result.source
    ).isel(cut_off=0)
    np.testing.assert_allclose(
        table["friction_combined"], expected["friction_combined"].transpose(*table["friction_combined"].dims)
    )


def test_stored_study_without_a_height_factor_can_be_opened(bodies, tmp_path):
    pair_result = pair(*bodies, directory=tmp_path, **PAIR_OPTIONS | HARDNESS_OPTION)
    text = (tmp_path / STUDY_FILE).read_text()
    (tmp_path / STUDY_FILE).write_text(re.sub(r",? *height_factor = [0-9.]+", "", text))
    assert open_stored_result(tmp_path).study == pair_result.study
    doubled_study = scale_study_heights(pair_result.study, 2.0, "upper")
    assert doubled_study.to_toml().count("height_factor = 2.0") == 1


# ---- Views -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("mechanics", "quantity"), [("asperities", "contact_area"), ("half-space", "contact_area_fraction")]
)
def test_height_factor_figures_show_area_fractions_only_if_the_nominal_area_is_meaningful(mechanics, quantity):
    upper, lower = (
        self_affine(2, hurst_exponent=0.8, rms=0.05, points=600, spacing=0.05, side=side) for side in ("upper", "lower")
    )
    options = {"load": "0.1 mN", "mu0": 0.3, "effective_modulus": "10 GPa", "mechanics": mechanics}
    result = pair(upper, lower, offsets=6, onset=0, **options)
    compute_results_at_height_factors(result.source, [0.5])
    for name in ("friction", "height_scale"):
        assert result.figure(name).axes[1].get_ylabel() == axis_label(quantity)
    assert bool(result.figure("friction").axes[0].child_axes) == (mechanics == "half-space")


def test_figure_and_report_show_stored_height_factors(bodies, result, tmp_path):
    assert {"height_scale", "height_scale_upper"} <= set(result.figures())
    axes = result.figure("height_scale").axes
    assert axes[0].lines[0].get_xdata() == pytest.approx(
        get_mean_values(result.at(height_scale=[0.5, 1, 2])["rms_gradient"])
    )
    with disable_drawing():
        page = report_page(result.source)
    assert "Another finish of both surfaces" in page
    assert "Another finish of the upper surface" in page
    assert "Another finish of the lower surface" not in page
    unscaled_result = pair(*bodies, directory=tmp_path, **PAIR_OPTIONS | HARDNESS_OPTION)
    assert "height_scale" not in unscaled_result.figures()
    with disable_drawing():
        assert "Another finish" not in report_page(unscaled_result.source)
