"""Test pairs of profiles at listed positions against direct solutions at each position, and `paired_lines`."""

import numpy as np
import pytest
import stiction
from stiction import (
    Profile,
    Surface,
    approach_at_load,
    contacts,
    cropped,
    flipped,
    half_space,
    levelled,
    nondimensional,
    paired_lines,
    press,
    run,
    self_affine,
    surrogate,
)
from stiction.evaluate import intervals
from support.studies_of_files import pair_study

pytestmark = pytest.mark.usefixtures("no_companion_files")

LOADS = [0.003, 0.03]
INTERFACE_OPTIONS = {"mu0": 0.3, "tau0": 0.1}
ROOT_TOLERANCE = 1e-9  # relative error of values at a load, whose approach is found to 1e-12
INTERPOLATION_TOLERANCE = 2e-3


def rough_profile(side="lower", *, points=3000, repetition=0, spacing=0.01):
    return self_affine(
        5, hurst_exponent=0.8, rms=0.03, points=points, spacing=spacing, shortest_wavelength=20 * spacing,
        longest_wavelength=300 * spacing, side=side, repetition=repetition,
    )  # fmt: skip


@pytest.fixture(scope="module")
def profile_pair():
    return cropped(flipped(rough_profile("upper")), 0, 20), rough_profile("lower")


LOAD_RATIOS = (0.03, 0.3, 0.6, 0.72, 0.8, 0.87, 0.93, 1.0, 1.07, 1.15, 1.25, 1.4, 1.8, 3.0, 30.0)
"""Ratios of the solved elastic loads to the requested normal load, which are dense around 1."""


def create_study(upper, lower, loads, **options):
    """Return the study of a slider on a counterface, without levelling and filtering."""
    default_options = {"level": "none", "cutoff": "none", "positions": [0.0], "effective_modulus": 10.0}
    return pair_study(flipped(upper), lower, load=list(loads), **default_options | options)


def run_pair(upper, lower, loads, **options):
    return run(create_study(upper, lower, loads, **options))


def read_member_values(result, **arguments):
    """Return the values of each position under the rule "opposing", without dimensions of length one."""
    table = result.at(per_member=True, **arguments).sel(sliding="opposing").isel(cut_off=0)
    return table.swap_dims(repetition="x").squeeze(("mu0", "tau0"))


@pytest.fixture(scope="module")
def result(profile_pair):
    return run_pair(*profile_pair, LOADS, positions=[0.0, 4.0, 10.0], **INTERFACE_OPTIONS)


@pytest.mark.parametrize("shear", ["+x", "-x"])
@pytest.mark.parametrize("offset", [0.0, 4.0, 10.0])
def test_pair_and_press_give_equal_results_for_profiles_at_each_position(profile_pair, result, shear, offset):
    upper, lower = profile_pair
    counterface = cropped(lower, offset, offset + 20)
    model = {"detection": "gap-minimum", "shear": shear}
    selection = {"x": offset, "direction": 0.0 if shear == "+x" else 180.0}
    member = read_member_values(result).sel(selection)
    approaches = approach_at_load(upper, counterface, LOADS, mu0=0.0, **model)
    curve = press(upper, counterface, approaches, **model)
    np.testing.assert_allclose(member["approach"], approaches, rtol=ROOT_TOLERANCE)
    np.testing.assert_allclose(
        member["friction_coefficient"], curve.friction_coefficient(**INTERFACE_OPTIONS), rtol=ROOT_TOLERANCE
    )
    np.testing.assert_allclose(
        member["tangential_load"], curve.tangential_load(**INTERFACE_OPTIONS), rtol=ROOT_TOLERANCE
    )
    np.testing.assert_allclose(member["contact_area"], curve.contact_area, rtol=ROOT_TOLERANCE)
    np.testing.assert_array_equal(member["contact_count"], curve.contact_count)
    np.testing.assert_allclose(
        member["share_beyond_hertz"], curve.validity.share_beyond_hertz, rtol=ROOT_TOLERANCE, atol=1e-12
    )
    for index, approach in enumerate(approaches):
        loads_around = press(upper, counterface, [0.98 * approach, 1.02 * approach], **model).normal_elastic
        assert float(member["normal_stiffness"][index]) == pytest.approx(
            (loads_around[1] - loads_around[0]) / (0.04 * approach)
        )
    member = read_member_values(result, load_definition="normal").sel(selection)
    approaches = approach_at_load(upper, counterface, LOADS, **INTERFACE_OPTIONS, **model)
    curve = press(upper, counterface, approaches, **model)
    np.testing.assert_allclose(
        member["friction_coefficient"], curve.friction_coefficient(**INTERFACE_OPTIONS), rtol=INTERPOLATION_TOLERANCE
    )
    np.testing.assert_allclose(member["tangential_load"], member["friction_coefficient"] * LOADS, rtol=ROOT_TOLERANCE)
    assert (member["status"] == "ok").all()


@pytest.mark.parametrize(
    ("load", "tolerance", "quantile_level"), [("elastic", 1e-6, 1.0), ("normal", INTERPOLATION_TOLERANCE, 0.75)]
)
def test_friction_is_interpolated_linearly_where_the_load_jumps_between_approaches(
    create_rough_profiles, load, tolerance, quantile_level
):
    upper, lower = create_rough_profiles(1.5, repetition=1)
    loads = np.geomspace(1e-4, 3e-3, 12)
    steps = [f"{step} mN" for step in np.unique(np.outer(loads, LOAD_RATIOS))]
    study = create_study(upper, lower, loads, detection="cell", **INTERFACE_OPTIONS).with_changes(
        {"contact.load": steps}
    )
    members = read_member_values(run(study), load_definition=load).isel(x=0)
    strengths = {"mu0": 0.0} if load == "elastic" else INTERFACE_OPTIONS
    errors = []
    for shear, angle in (("+x", 0.0), ("-x", 180.0)):
        approaches = approach_at_load(upper, lower, loads, detection="cell", shear=shear, **strengths)
        for index in np.flatnonzero(members["status"].sel(direction=angle) == "ok"):
            close_approaches = approaches[index] * np.array([1 - 1e-10, 1])
            curve = press(upper, lower, close_approaches, detection="cell", shear=shear)
            normal_loads, tangential_loads = curve.normal_load(**strengths), curve.tangential_load(**INTERFACE_OPTIONS)
            if normal_loads[1] > 1.001 * normal_loads[0]:
                tangential_load = float(members["tangential_load"].sel(direction=angle)[index])
                errors.append(
                    abs(tangential_load - np.interp(loads[index], normal_loads, tangential_loads)) / loads[index]
                )
    assert len(errors) > 4
    assert np.quantile(errors, quantile_level) < tolerance


def test_positions_are_rounded_to_the_nearest_grid_point(profile_pair):
    upper, lower = profile_pair
    assert 0.29 / 0.01 < 29  # 0.29/0.01 is slightly below 29 and must not be truncated to 28
    member = read_member_values(run_pair(upper, lower, [0.01], positions=[0.29], **INTERFACE_OPTIONS)).sel(
        direction=0.0
    )
    counterface = Profile(lower.heights[29 : 29 + len(upper)], spacing=0.01)
    expected = approach_at_load(upper, counterface, 0.01, detection="gap-minimum", shear="+x", mu0=0.0)
    assert float(member["approach"].squeeze()) == pytest.approx(float(expected), rel=ROOT_TOLERANCE)
    assert float(member["x"].squeeze()) == pytest.approx(0.29)


def test_slider_is_shortened_to_fit_on_the_counterface_at_the_last_position(profile_pair):
    _, lower = profile_pair
    result = run_pair(flipped(lower), lower, [0.01], positions=[1.0, 12.0], **INTERFACE_OPTIONS)
    assert result.dataset.attrs["shape"].tolist() == [1800]
    assert float(result.dataset["nominal_area"]) == pytest.approx(18.0)


def test_contact_stiffness_of_two_circular_arcs_equals_hertz_solution(create_circular_arc):
    upper, lower = (create_circular_arc(0.5003, 1.0, 1e-3, 1001, side) for side in ("upper", "lower"))
    load = 0.01
    member = read_member_values(run_pair(upper, lower, [load], mu0=0.0)).isel(x=0, load=0)
    overlap = (load / (4 / 3 * 10.0 * np.sqrt(0.5))) ** (2 / 3)
    # Hertz: dF/dδ = 3/2 F/δ. The central difference over ±2 % of the approach has a relative error below 1e-4.
    np.testing.assert_allclose(member["normal_stiffness"], 1.5 * load / overlap, rtol=1e-4)


def test_dataset_of_values_at_each_position_has_units_and_inputs_and_version(result):
    members = result.at(per_member=True)
    assert members["contact_area"].attrs["units"] == "um^2"
    assert members["normal_stiffness"].attrs["units"] == "mN/um"
    assert members["load"].attrs["units"] == "mN"
    assert result.nominal_area == pytest.approx(20.0)
    assert (float(members["mu0"][0]), float(members["tau0"][0]), float(members["effective_modulus"])) == (
        0.3,
        0.1,
        10.0,
    )
    assert result.study.contact.detection == "gap-minimum"
    assert "flipped" in members.attrs["upper"]
    assert members.attrs["stiction_version"] == stiction.__version__


def test_nondimensional_values_are_invariant_under_scaling(profile_pair):
    def compute_nondimensional_members(bodies, loads, length, **options):
        members = run_pair(*bodies, loads, detection="gap-minimum", mu0=0.3, **options).at(per_member=True)
        names = [
            name for name in members.data_vars if members[name].attrs.get("units") in ("1", "mN", "um", "um^2", "GPa")
        ]
        return nondimensional(members[names], length=length)

    scaled_pair = [Profile(3 * item.heights, spacing=3 * item.spacing) for item in profile_pair]
    original = compute_nondimensional_members(profile_pair, [0.01], 1.0, positions=[0.0, 5.0], tau0=0.1)
    scaled_members = compute_nondimensional_members(
        scaled_pair, [0.01 * 9 * 2], 3.0, positions=[0.0, 15.0], tau0=0.2, effective_modulus=20.0
    )
    assert set(original.variables) == set(scaled_members.variables)
    assert {"friction_coefficient", "normal_load", "contact_area", "approach"} <= set(original.data_vars)
    for name in original.variables:
        if original[name].dtype.kind == "f" and name not in (
            "nominal_area",
            "contact_area_fraction",
            "nominal_pressure",
        ):
            np.testing.assert_allclose(scaled_members[name], original[name], rtol=1e-6, atol=1e-12, err_msg=name)
            assert original[name].attrs["units"] in ("1", "degree")
    assert original["load"].attrs["long_name"].endswith("/ (E* L²)")


def test_nondimensional_values_require_a_modulus_and_known_units(result):
    members = result.at(per_member=True)[["contact_area"]]
    with pytest.raises(ValueError, match="length must be given"):
        nondimensional(members)
    with pytest.raises(ValueError, match=r"length must be .* above 0"):
        nondimensional(members, length=-1.0)
    members_without_modulus = members.drop_attrs(deep=False).drop_vars("effective_modulus")
    with pytest.raises(ValueError, match="effective_modulus must be given"):
        nondimensional(members_without_modulus, length=1.0)
    members = members.copy()
    members["contact_area"].attrs["units"] = "acre"
    with pytest.raises(ValueError, match="contact_area has the unknown unit 'acre'"):
        nondimensional(members, length=1.0)


# ---- Statuses and means ----------------------------------------------------------------------------------------------


def test_positions_without_a_coefficient_have_a_status_and_are_omitted_from_the_mean():
    x = np.arange(2001) * 0.01 - 10.0
    flat, ball = Profile(np.zeros(2001), spacing=0.01), Profile(-0.05 * x**2, spacing=0.01)
    reached_result = run_pair(flat, ball, [1e-3, 1e9], mu0=0.3)
    assert read_member_values(reached_result)["status"].isel(x=0, direction=0).values.tolist() == ["ok", "not-reached"]
    separated_result = run_pair(flat, flat, [1.0], mu0=0.3)
    assert (separated_result.at(per_member=True)["status"] == "no-contact").all()
    # Two arcs on a slope of 3: the upper body is pushed up the slope in direction 0, and down in direction 180.
    upper, lower = (Profile(3 * x + curvature * x**2, spacing=0.01) for curvature in (0.05, -0.05))
    for mu0, status in ((0.3, "ok"), (0.34, "self-locked")):  # the contact is self-locking if mu0 exceeds 1/3
        members = read_member_values(run_pair(upper, lower, [1e-3], mu0=mu0))
        assert members["status"].isel(x=0).values.ravel().tolist() == [status, "ok"]
    grazing_result = run_pair(flat, Profile(-0.05 * (x - 0.005) ** 2, spacing=0.01), [1e-12], mu0=0.3)
    members = grazing_result.at(per_member=True)
    assert (members["status"] == "below-range").all()
    assert members["approach"].isnull().all()
    mean = reached_result.at().sel(sliding="opposing", direction=0.0).isel(cut_off=0, mu0=0, tau0=0)
    assert mean["ok"].values.tolist() == [1, 0]
    assert mean["friction_coefficient"][1].isnull().all()
    values = mean["contact_area"][0]
    assert np.isfinite(values[0])
    assert values[1:].isnull().all()


def test_result_for_arrays_of_mu0_and_tau0_equals_results_for_their_single_values(profile_pair):
    result = run_pair(*profile_pair, LOADS, mu0=[0.3, 0.5], tau0=[0.0, 0.1], positions=np.arange(9.0))
    values, mean = result.at(per_member=True), result.at()
    for mu0 in (0.3, 0.5):
        for tau0 in (0.0, 0.1):
            result_of_single_values = result.at(mu0=mu0, tau0=tau0, per_member=True)
            assert values.sel(mu0=[mu0], tau0=[tau0]).identical(result_of_single_values)
            selected_means = mean.sel(mu0=mu0, tau0=tau0)["friction_coefficient"]
            np.testing.assert_array_equal(
                selected_means, result.at(mu0=mu0, tau0=tau0)["friction_coefficient"][..., 0, 0, :]
            )


def test_interval_of_the_mean_over_positions_accounts_for_their_correlation(profile_pair):
    result = run_pair(*profile_pair, [0.01], positions=np.arange(10.0), **INTERFACE_OPTIONS)
    values = read_member_values(result)["friction_coefficient"].isel(load=0).sel(direction=0.0).values
    mean = (
        result.at()["friction_coefficient"]
        .isel(cut_off=0, load=0, mu0=0, tau0=0)
        .sel(sliding="opposing", direction=0.0)
    )
    np.testing.assert_allclose(mean, intervals.average_correlated_values(values))


# ---- From scans to pairs ---------------------------------------------------------------------------------------------


def test_pairing_of_profiles_returns_half_of_the_slider_and_the_complete_counterface():
    upper, lower = rough_profile("upper"), rough_profile("lower")
    (slider,), (counterface,) = paired_lines(upper, lower)
    levelled_upper = levelled(upper, "line")
    np.testing.assert_array_equal(counterface.heights, levelled(lower, "line").heights)
    np.testing.assert_allclose(
        slider.heights, levelled(flipped(cropped(levelled_upper, 0, 15)), "line").heights, atol=1e-15
    )
    assert slider.history[-2:] == ("cropped to 0 to 15 µm", "levelled by a line")
    (short_slider,), (counterface,) = paired_lines(cropped(upper, 0, 5), lower)
    assert (len(short_slider), len(counterface)) == (500, 3000)
    (slider,), (counterface,) = paired_lines(rough_profile("upper", points=800, spacing=0.02), lower)
    assert (slider.spacing, counterface.spacing, len(counterface)) == (0.01, 0.01, 3000)


def test_pairing_of_lines_shortens_the_slider_by_the_travel():
    (slider,), (counterface,) = paired_lines(rough_profile("upper"), rough_profile("lower"), travel=10.0, level=None)
    assert (len(slider), len(counterface)) == (2000, 3000)
    np.testing.assert_array_equal(slider.heights, -rough_profile("upper").heights[:2000])
    for travel in (15.5, -1.0, np.nan, 1e9):
        with pytest.raises(ValueError, match="travel"):
            paired_lines(rough_profile("upper"), rough_profile("lower"), travel=travel)


def small_map():
    lines = [rough_profile("lower", points=400, repetition=line).heights for line in range(9)]
    return Surface(lines, spacing=(0.02, 0.01))


def test_lines_paired_within_one_map_are_a_third_of_the_map_apart():
    surface = small_map()
    uppers, lowers = paired_lines(surface, surface, level=None)
    assert len(uppers) == len(lowers) == 9
    for line in range(9):
        np.testing.assert_array_equal(uppers[line].heights, -surface.heights[line])
        np.testing.assert_array_equal(lowers[line].heights, surface.heights[(line + 3) % 9])
    uppers, lowers = paired_lines(surface, surface, level=None, lines=4, along="y")
    assert [len(upper) for upper in uppers] == [9] * 4
    np.testing.assert_array_equal(uppers[1].heights, -surface.heights[:, 100])
    np.testing.assert_array_equal(lowers[1].heights, surface.heights[:, 233])
    np.testing.assert_array_equal(lowers[3].heights, surface.heights[:, 33])
    for lines in (1, 2):
        uppers, lowers = paired_lines(surface, surface, level=None, lines=lines)
        np.testing.assert_array_equal(uppers[0].heights, -surface.heights[0][: len(uppers[0])])
        np.testing.assert_array_equal(lowers[0].heights, surface.heights[3])
    two_rows = Surface(surface.heights[:2], spacing=0.01)
    np.testing.assert_array_equal(paired_lines(two_rows, two_rows, level=None)[1][1].heights, two_rows.heights[0])
    uppers, lowers = paired_lines(surface, rough_profile("upper"), lines=3)
    assert len(lowers[0]) == 400
    assert uppers[1].history[:1] == ("row 3",)


def test_pairs_of_lines_of_unequal_length_cover_the_longer_profile():
    surface = small_map()
    for lengths in ((400, 3000), (3000, 400)):
        bodies = [surface if length == 400 else rough_profile("upper") for length in lengths]
        uppers, lowers = paired_lines(*bodies, level=None, lines=9)
        assert {len(upper) for upper in (*uppers, *lowers)} == {400}
        pieces = np.array([item.heights for item in (uppers if lengths[0] == 3000 else lowers)])
        long_heights = rough_profile("upper").heights * (-1 if lengths[0] == 3000 else 1)
        starts = [int(np.flatnonzero(np.isclose(long_heights, line[0], rtol=0, atol=0))[0]) for line in pieces]
        np.testing.assert_array_equal(pieces, [long_heights[start : start + 400] for start in starts])
        assert min(starts) == 0
        assert max(starts) > 0.8 * 2600
        assert np.diff(np.sort(starts)).max() < 2 * 2600 / 9
    assert "cropped" in uppers[1].history[-1]
    levelled_pieces, _ = paired_lines(rough_profile("upper"), surface, lines=2)
    np.testing.assert_allclose(levelled(levelled_pieces[1], "line").heights, levelled_pieces[1].heights, atol=1e-12)


def test_pairing_of_lines_replaces_the_selected_profile_by_surrogates():
    upper, lower = rough_profile("upper"), rough_profile("lower")
    uppers, lowers = paired_lines(upper, lower, surrogates="lower", lines=3, seed=9)
    assert len(uppers) == 3
    np.testing.assert_array_equal(uppers[0].heights, uppers[1].heights)
    for line in range(3):
        expected = surrogate(levelled(lower, "line"), 9, repetition=line, side="lower")
        np.testing.assert_array_equal(lowers[line].heights, expected.heights)
    uppers, _ = paired_lines(upper, lower, surrogates="both", lines=2)
    assert not np.array_equal(uppers[0].heights, uppers[1].heights)


@pytest.mark.parametrize(
    ("arguments", "pattern"),
    [
        ({"positions": [1.0, 1.0]}, "positions must differ"),
        ({"positions": [-1.0]}, "positions must be at least 0"),
        ({"positions": [26.0]}, "leave a slider shorter than half of the shorter profile"),
        ({"positions": ["2 mN"]}, "positions has the unit 'mN'"),
        ({"positions": [0.0], "offsets": 3}, "offsets must not be given with positions"),
        ({"positions": [0.0], "travel": "1 um"}, "travel must not be given with positions"),
        ({"load": [0.0]}, "load must be"),
        ({"mu0": -1.0}, "mu0 must be at least 0"),
        ({"direction": [0]}, "direction is for areas"),
    ],
)
def test_pair_function_rejects_invalid_positions_of_profiles(profile_pair, arguments, pattern):
    upper, lower = profile_pair
    options = {"load": [0.01], "mu0": 0.3, "effective_modulus": 10.0, "positions": [0.0]} | arguments
    with pytest.raises(ValueError, match=pattern):
        stiction.pair(Profile(upper.heights, spacing=0.01), lower, **options)


def test_study_of_profiles_rejects_more_pairs_than_positions(profile_pair):
    study = create_study(*profile_pair, [0.01], mu0=0.3, positions=[0.0, 1.0])
    with pytest.raises(ValueError, match="positions has 2 positions, but member 2 needs position 3"):
        run(study.with_changes({"ensemble.repetitions": 3}))
    with pytest.raises(ValueError, match="must not be given with offsets or travel"):
        study.with_changes({"surfaces.travel": "1 um"})


@pytest.mark.parametrize(
    ("arguments", "pattern"), [({"along": "z"}, "along must be one of"), ({"lines": 0}, "lines must be a whole number")]
)
def test_pairing_of_lines_rejects_invalid_arguments(arguments, pattern):
    with pytest.raises(ValueError, match=pattern):
        paired_lines(small_map(), small_map(), **arguments)
    with pytest.raises(ValueError, match="upper must be a Profile or a Surface"):
        paired_lines([1, 2], small_map())


def two_rough_profiles():
    return tuple(
        self_affine(4, hurst_exponent=0.8, rms=0.03, points=2000, spacing=0.01, shortest_wavelength=0.2, side=side)
        for side in ("upper", "lower")
    )


def test_load_fraction_of_opposing_contacts_equals_a_sum_over_the_listed_contacts():
    upper, lower = two_rough_profiles()
    slider = cropped(upper, 0, 15)
    result = read_member_values(run_pair(slider, lower, [0.3], mu0=0.3, positions=[1.0])).isel(x=0, load=0)
    for shear, angle in (("+x", 0.0), ("-x", 180.0)):
        member = result.sel(direction=angle)
        contact_list = contacts(
            slider, cropped(lower, 1, 16), float(member["approach"]), detection="gap-minimum", shear=shear
        )
        load = contact_list.force * contact_list.normal[:, 2]
        fraction = load[contact_list.opposing].sum() / load.sum()
        assert 0.05 < fraction < 0.95
        assert np.isclose(float(member["share_opposing"]), fraction, rtol=1e-6)
    # Each contact opposes one of the two directions, so the load fractions add up to 1, exactly so for small slopes.
    assert float(result["share_opposing"].sum()) == pytest.approx(1.0, abs=0.02)


# ---- Half-planes -----------------------------------------------------------------------------------------------------

SUMMATION_TOLERANCE = 1e-12


@pytest.fixture(scope="module")
def small_pair():
    return cropped(flipped(rough_profile("upper", points=600)), 0, 2), rough_profile("lower", points=600)


@pytest.mark.parametrize("sliding", ["opposing", "all"])
def test_half_plane_results_at_each_position_equal_half_space_solutions(small_pair, sliding):
    upper, lower = small_pair
    model = {"mechanics": "half-space", "effective_modulus": 8.0}
    result = run_pair(upper, lower, LOADS, positions=[0.0, 2.5], **INTERFACE_OPTIONS, **model)
    arguments = {"effective_modulus": 8.0, "sliding": sliding}
    values = result.at(per_member=True).sel(sliding=sliding).isel(cut_off=0, mu0=0, tau0=0).swap_dims(repetition="x")
    assert (values["status"] == "ok").all()
    for offset in (0.0, 2.5):
        for shear, angle in (("+x", 0.0), ("-x", 180.0)):
            member = values.sel(x=offset, direction=angle)
            steps = [float(load) for load in result.study.contact.load]
            curve = half_space(upper, cropped(lower, offset, offset + 2), steps, direction=shear, **arguments)
            load_indices = [steps.index(load) for load in LOADS]
            np.testing.assert_allclose(
                member["tangential_load"],
                curve.tangential_load(**INTERFACE_OPTIONS)[load_indices],
                rtol=SUMMATION_TOLERANCE,
            )
            coefficient = curve.friction_coefficient(**INTERFACE_OPTIONS)[load_indices]
            np.testing.assert_allclose(member["friction_coefficient"], coefficient, rtol=SUMMATION_TOLERANCE)
            np.testing.assert_allclose(
                member["contact_area"], curve.contact_area[load_indices], rtol=SUMMATION_TOLERANCE
            )
            np.testing.assert_array_equal(member["contact_count"], curve.contact_count[load_indices])
    total_fraction = values["share_opposing"].sum("direction").values
    np.testing.assert_allclose(total_fraction, 1, atol=0.02)
    for name in ("approach", "normal_stiffness"):
        assert values[name].isnull().all()


@pytest.mark.parametrize(
    ("arguments", "pattern"),
    [
        ({"mechanics": "half-plane"}, "mechanics must be"),
        ({"mechanics": "half-space", "law": "hertz-cylinder"}, "law is for mechanics asperities"),
    ],
)
def test_pair_study_rejects_an_unknown_contact_model_and_a_contact_law_in_the_half_space_model(
    small_pair, arguments, pattern
):
    with pytest.raises(ValueError, match=pattern):
        pair_study(*small_pair, load=LOADS, effective_modulus=10.0, **INTERFACE_OPTIONS, **arguments)
