"""Test pairs of maps at several relative positions against direct solutions at each position."""

import re

import numpy as np
import pytest
import stiction
from stiction import (
    Surface,
    approach_at_load,
    contacts,
    flipped,
    gentle_friction,
    half_space,
    isotropic_surface,
    levelled,
    press,
    run,
    self_affine_surface,
    surrogate,
)
from stiction.evaluate.at_load import at_load
from stiction.evaluate.member_values import member_values
from stiction.mechanics.patches import grid_slopes
from stiction.solve.contact_statistics import QUANTILE_PROBABILITIES
from stiction.surfaces.pairing import MIN_PIECE_SIDE_POINTS, MapPairs
from support.rough_surfaces import rough_maps, self_affine_map
from support.studies_of_files import pair_study

pytestmark = pytest.mark.usefixtures("no_companion_files")

LOADS = (0.02, 0.1)
ASPERITY_OPTIONS = {"mechanics": "asperities", "level": "mean", "direction": [0, 45]}
ROOT_TOLERANCE = 1e-9  # relative error of values at a load, whose approach is found to 1e-12
SOLUTION_TOLERANCE = 1e-4  # relative difference between two solutions, which differ at the edges of contact patches


def rough_surface(side="lower", seed=3, shape=(64, 64), rms=0.02, shortest=0.4):
    return self_affine_surface(
        seed, hurst_exponent=0.8, rms=rms, shape=shape, spacing=0.1, longest_wavelength=3.2,
        shortest_wavelength=shortest, side=side,
    )  # fmt: skip


def surface_pair(**changes):
    return rough_surface("upper", **changes), rough_surface("lower", **changes)


def run_pair(upper, lower, loads=(0.1,), **options):
    """Return the result of pressing two surfaces without a low-pass filter."""
    study_options = {"mu0": 0.3, "effective_modulus": 10.0, "cutoff": "none"} | options
    return run(pair_study(flipped(upper), lower, load=list(loads), **study_options))


def read_member_values(result, member_kind=None):
    return member_values(result, result.default_loads, member_kind=member_kind).isel(cut_off=0)


def pair_levelled_maps(upper, lower):
    """Return the pairs of map pieces that a study presses, cut from the levelled maps."""
    return MapPairs(flipped(levelled(flipped(upper), "plane")), levelled(lower, "plane"))


def test_map_pairs_are_cut_from_overlaps_of_shifted_maps():
    """Compare with the middle 48 by 48 points of the overlap, cut by hand."""
    upper, lower = surface_pair()
    pairs = MapPairs(upper, lower)
    x, y = pairs.map_shift(2)
    rows, columns = round(y / 0.1), round(x / 0.1)
    top_row, left_column = max(0, rows) + (64 - abs(rows) - 48) // 2, columns + (64 - columns - 48) // 2
    upper_piece = Surface(
        upper.heights[top_row - rows : top_row - rows + 48, left_column - columns : left_column - columns + 48],
        spacing=0.1,
    )
    lower_piece = Surface(lower.heights[top_row : top_row + 48, left_column : left_column + 48], spacing=0.1)
    for piece, expected in zip(pairs.pair(2), (upper_piece, lower_piece), strict=True):
        np.testing.assert_allclose(levelled(piece, "plane").heights, levelled(expected, "plane").heights, atol=1e-15)


class TestListedPositions:
    """Test listed positions (x, y) of the upper map relative to the lower map."""

    def create_maps(self):
        return rough_maps(hurst_exponent=0.8, rms=0.03, shape=(64, 80), spacing=(0.05, 0.04), shortest_wavelength=0.4)

    def test_friction_at_map_positions_equals_friction_from_pressing_the_overlaps(self):
        upper, lower = self.create_maps()
        positions = [(0.8, -0.5), (-0.4, 1.0)]
        result = run_pair(upper, lower, [0.02, 0.1], positions=positions, **ASPERITY_OPTIONS)
        assert result.dataset["x"].values.tolist() == [0.8, -0.4]
        assert result.dataset["y"].values.tolist() == [-0.5, 1.0]
        # The overlaps have 54 by 60 and 44 by 70 points, and both pieces are cut to the common size of 44 by 60 points.
        assert result.nominal_area == pytest.approx(44 * 0.05 * 60 * 0.04)
        windows = [
            ((slice(15, 59), slice(0, 60)), (slice(5, 49), slice(20, 80))),
            ((slice(0, 44), slice(15, 75)), (slice(20, 64), slice(5, 65))),
        ]
        values = read_member_values(result)
        for member, member_windows in enumerate(windows):
            upper_piece, lower_piece = (
                Surface(body.heights[window], spacing=body.spacing)
                for body, window in zip((upper, lower), member_windows, strict=True)
            )
            for angle in (0, 45):
                member_values = (
                    values.isel(repetition=member).sel(direction=angle, sliding="opposing", mu0=0.3).squeeze("tau0")
                )
                assert (member_values["status"] == "ok").all()
                curve = press(
                    upper_piece,
                    lower_piece,
                    approach_at_load(upper_piece, lower_piece, [0.02, 0.1], mu0=0.0),
                    direction=angle,
                )
                np.testing.assert_allclose(
                    curve.friction_coefficient(mu0=0.3), member_values["friction_coefficient"], rtol=1e-9
                )
                np.testing.assert_allclose(
                    curve.lateral_load(mu0=0.3), member_values["lateral_load"], rtol=1e-9, atol=1e-12
                )

    def test_map_pair_at_a_single_position_uses_the_complete_overlap(self):
        result = run_pair(*self.create_maps(), [0.1], positions=[(0.0, 0.0)], **ASPERITY_OPTIONS)
        assert result.dataset.attrs["shape"].tolist() == [64, 80]
        assert result.dataset.sizes["repetition"] == 1

    def test_positions_can_be_given_as_lists_or_strings_or_arrays(self):
        upper, lower = self.create_maps()
        studies = [
            pair_study(upper, lower, load=[0.1], mu0=0.3, effective_modulus=10.0, positions=positions)
            for positions in ([(0.8, -0.5), (0.0, 1.0)], "0.8 um,-0.5 um,0 um,1 um", np.array([[0.8, -0.5], [0, 1]]))
        ]
        assert {study.surfaces.positions for study in studies} == {((0.8, -0.5), (0.0, 1.0))}

    @pytest.mark.parametrize(
        ("changes", "pattern"),
        [
            ({"positions": [(2.6, 0.0)]}, "at least 16 rows and columns"),
            ({"positions": [(9.0, 0.0)]}, "rows and columns, got 64 rows and 0 columns"),
            ({"positions": [1.0, 2.0, 3.0]}, "positions must be pairs of x and y for maps, got 3 values"),
            ({"positions": [(1e300, 0.0)]}, "positions"),
            ({"positions": [(0.0, 0.0), (0.0, 0.0)]}, "positions must differ"),
            ({"positions": [(0.0, 0.0)], "shifts": 2}, "shifts must not be given with positions"),
            ({"direction": "north"}, "direction"),
        ],
    )
    def test_pair_function_rejects_invalid_positions_for_maps(self, changes, pattern):
        options = {"load": [0.1], "mu0": 0.3, "effective_modulus": 10.0}
        with pytest.raises(ValueError, match=pattern):
            stiction.pair(*self.create_maps(), **options | changes)

    def test_map_paired_with_a_profile_is_pressed_line_by_line_at_the_given_positions(self):
        upper, lower = self.create_maps()
        options = {"lines": 2, "positions": [0.0, 0.8]}
        study = pair_study(upper, lower.row(0), load=[0.01], mu0=0.3, effective_modulus=10.0, **options)
        result = run(study).dataset
        assert result["x"].values.tolist() == [0.0, 0.8, 0.0, 0.8]
        assert result["line"].values.tolist() == [0, 0, 1, 1]
        assert result.attrs["shape"].tolist() == [60]


def test_slope_statistics_of_a_pair_equal_slope_statistics_of_its_gap():
    upper, lower = surface_pair()
    result = run_pair(upper, lower, direction=[0, 45, 90], shifts=2, mechanics="asperities")
    gap = np.subtract(*(body.heights for body in pair_levelled_maps(upper, lower).pair(1)))
    slopes_y, slopes_x = np.gradient(gap, 0.1)
    member = read_member_values(result).isel(repetition=1)
    # Finite differences underestimate slopes of the shortest wavelength, which has four points.
    assert float(member["rms_gradient"]) == pytest.approx(np.sqrt((slopes_x**2 + slopes_y**2).mean()), rel=0.1)
    assert float(member["rms_slope"][1]) == pytest.approx(np.sqrt(((slopes_x + slopes_y) ** 2 / 2).mean()), rel=0.1)
    assert member["rms_slope"][0] ** 2 + member["rms_slope"][2] ** 2 == pytest.approx(
        float(member["rms_gradient"]) ** 2
    )
    mean = result.at()["gentle_friction"].sel(sliding="opposing", direction=90.0).squeeze()
    slopes = result.at().sel(statistic="mean")
    expected = gentle_friction(
        0.3, rms_gradient=float(slopes["rms_gradient"].squeeze()), rms_slope=float(slopes["rms_slope"].squeeze()[2])
    )
    assert float(mean) == pytest.approx(float(expected))


def test_mean_over_positions_has_a_student_t_interval_on_the_logarithmic_scale():
    upper, lower = surface_pair()
    result = run_pair(upper, lower, direction=[0, 90], shifts=5, mechanics="asperities")
    incomplete = result.dataset.copy(deep=True)
    for values in incomplete.data_vars.values():
        if values.dtype.kind == "f" and "load" in values.dims:
            values.loc[{"repetition": 2}] = np.nan
    incomplete["status"].loc[{"repetition": 2}] = 5
    table = at_load(incomplete, [0.1]).isel(cut_off=0)
    values = np.delete(read_member_values(result)["friction_coefficient"].values[:, 0, 0, 0, 0, 0], 2)
    mean_friction, lower_end, upper_end = table["friction_coefficient"].values[0, 0, 0, 0, 0]
    half_width = 3.182446305 * values.std(ddof=1) / 2  # Student's t for 3 degrees of freedom
    factor = np.exp(half_width / values.mean())
    assert (values >= 0).all()
    assert mean_friction == pytest.approx(values.mean())
    assert (lower_end, upper_end) == pytest.approx((values.mean() / factor, values.mean() * factor))
    assert (int(table["ok"].values[0, 0, 0, 0, 0]), int(table["members"])) == (4, 5)
    result_of_two_shifts = run_pair(upper, lower, shifts=2, mechanics="asperities").at()
    assert result_of_two_shifts["contact_area"].sel(statistic="upper").isnull().all()


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_contact_statistics_of_a_pair_equal_sums_over_its_contacts(mechanics):
    upper, lower = surface_pair()
    result = run_pair(upper, lower, LOADS, direction=[30], shifts=2, mechanics=mechanics)
    member = read_member_values(result).isel(repetition=1).sel(load=0.1)
    bodies = pair_levelled_maps(upper, lower).pair(1)
    if mechanics == "half-space":
        contact = half_space(*bodies, [0.1]).contact(0)
        force = np.bincount(contact.patches.ravel(), weights=contact.pressure.ravel())[1:] * 0.01
        area = np.bincount(contact.patches.ravel(), weights=contact.share.ravel())[1:] * 0.01
    else:
        contact_list = contacts(*bodies, float(member["approach"]))
        force, area = contact_list.force * contact_list.normal[:, 2], contact_list.area
    assert force.size == int(member["contact_count"])
    assert force.sum() == pytest.approx(0.1, rel=1e-6)
    # The projected area is the true area times the cosine of the slope.
    assert area.sum() == pytest.approx(float(member["contact_area"]), rel=0.02)
    assert float(member["share_on_largest"]) == pytest.approx(force.max() / force.sum(), rel=1e-6)
    assert member["patch_area"].values == pytest.approx(np.quantile(area, QUANTILE_PROBABILITIES), rel=1e-6)
    median_pressure = float(member["pressure"].sel(fraction_below=0.5, method="nearest"))
    assert 0 < median_pressure < float(member["pressure"].sel(fraction_below=0.9, method="nearest"))
    mean = 0.1 / float(member["contact_area"])
    assert 0.5 * mean < median_pressure < 1.5 * mean


def test_load_fraction_carried_by_the_steepest_slopes_equals_its_definition():
    upper, lower = surface_pair()
    result = read_member_values(run_pair(upper, lower, direction=[0], shifts=2))
    bodies = pair_levelled_maps(upper, lower).pair(0)
    solution, body = half_space(*bodies, [0.1]).contact(0), bodies[0]
    gradient = np.hypot(*grid_slopes(body.heights, body.spacing, periodic=False))
    fraction = solution.pressure[gradient > np.quantile(gradient, 0.9)].sum() / solution.pressure.sum()
    assert float(result["share_on_steepest_upper"][0, 0]) == pytest.approx(fraction, abs=SOLUTION_TOLERANCE)
    assert 0 <= float(result["share_on_steepest_lower"][0, 0]) < 0.5


class TestSurrogatePairs:
    def test_adding_surrogates_does_not_change_pairs_of_the_maps_themselves(self):
        upper, lower = surface_pair()
        options = {"direction": [0, 30, 90, 180], "mechanics": "asperities"}
        result_of_shifts = run_pair(upper, lower, LOADS, shifts=3, **options)
        result = run_pair(upper, lower, LOADS, shifts=3, surrogates=4, seed=7, **options)
        assert result.dataset["surrogate"].values.tolist() == [True] * 4 + [False] * 3
        shifts, surrogate_members = read_member_values(result, "shifts"), read_member_values(result, "surrogates")
        for name, expected in read_member_values(result_of_shifts).data_vars.items():
            np.testing.assert_array_equal(shifts[name].values, expected.values)
        for index in range(4):
            bodies = [
                crop_to_middle(surrogate(levelled(body, "plane"), 7, repetition=index, side=side))
                for body, side in ((upper, "upper"), (lower, "lower"))
            ]
            approaches = approach_at_load(*bodies, LOADS, mu0=0.0)
            area = press(*bodies, approaches).contact_area
            assert surrogate_members["contact_area"].values[index] == pytest.approx(area, rel=ROOT_TOLERANCE)
        means = [at_load(result, LOADS, member_kind=kind) for kind in ("shifts", "surrogates")]
        assert float(means[1]["contact_area"][0, 0, 0]) == pytest.approx(
            float(surrogate_members["contact_area"][:, 0].mean())
        )
        assert [int(mean["members"]) for mean in means] == [3, 4]
        assert at_load(result, LOADS).equals(means[0])
        with pytest.raises(ValueError, match=r"member_kind must be '(shifts|surrogates)' for this result"):
            at_load(result_of_shifts, LOADS, member_kind="surrogates")

    def test_surrogates_of_profiles_are_pressed_as_isotropic_surfaces(self):
        bodies = [rough_surface(side, shape=(64, 512)).row(5) for side in ("upper", "lower")]
        options = {"direction": [0], "mechanics": "asperities", "lay": "isotropic"}
        result = run_pair(*bodies, [1.0], surrogates=3, seed=5, **options)
        assert result.dataset["surrogate"].values.all()
        assert result.dataset.attrs["shape"].tolist() == [384, 384]
        upper, lower = (
            isotropic_surface(levelled(body, "line"), 5, shape=(512, 512), repetition=2, side=side)
            for body, side in zip(bodies, ("upper", "lower"), strict=True)
        )
        area = press(
            *(pieces := (crop_to_middle(upper), crop_to_middle(lower))), approach_at_load(*pieces, [1.0], mu0=0.0)
        ).contact_area
        assert float(read_member_values(result)["contact_area"][2, 0]) == pytest.approx(
            float(area[0]), rel=ROOT_TOLERANCE
        )
        assert int(result.at()["members"]) == 3
        with pytest.raises(ValueError, match="shifts is for the areas of two maps"):
            run_pair(*bodies, [1.0], shifts=3, **options)


def crop_to_middle(body):
    """Return the middle three quarters of a surface along each axis, levelled by a plane."""
    rows, columns = (points - points // 4 for points in body.heights.shape)
    top, left = (body.heights.shape[0] - rows) // 2, (body.heights.shape[1] - columns) // 2
    middle_piece = Surface(body.heights[top : top + rows, left : left + columns], spacing=body.spacing)
    return levelled(middle_piece, "plane")


@pytest.mark.parametrize(
    ("changes", "pattern"),
    [
        ({"load": [0.0]}, "load must be"),
        ({"direction": [0, 0]}, "direction"),
        ({"shifts": 0}, "shifts must be a whole number of at least 1"),
        ({"shifts": 5000}, "the maps have .* relative positions"),
        ({"seed": 1.5, "surrogates": 2}, "seed must be a whole number"),
        ({"level": "cubic"}, "level must be"),
        ({"mechanics": "asperities", "hardness": 1.0}, "hardness needs mechanics half-space"),
    ],
)
def test_pair_function_rejects_invalid_input_for_maps(changes, pattern):
    with pytest.raises(ValueError, match=pattern):
        stiction.pair(*surface_pair(), **{"load": [0.1], "mu0": 0.3, "effective_modulus": 10.0} | changes)


def test_pair_function_rejects_maps_that_are_too_small():
    small_surface = Surface(np.zeros((MIN_PIECE_SIDE_POINTS, 30)), spacing=1.0)
    with pytest.raises(ValueError, match="overlap in at least 16 rows and columns"):
        pair_study(small_surface, small_surface, load=[0.1], mu0=0.3, effective_modulus=10.0)


# ---- Caveats about orientation and about scattered missing points ----------------------------------------------------

CAVEAT_OPTIONS = {
    "load": "20 MPa", "effective_modulus": 80.0, "mu0": 0.2, "tau0": "400 MPa", "shifts": 4, "onset": 0,
    "cutoff": "none",
}  # fmt: skip


def build_map(seed, *, stretch=1.0, missing=None):
    heights = 0.3 * self_affine_map(seed, 0.8, (48, 48), longest=16, stretch=stretch).heights
    return Surface(heights, spacing=0.5, missing=missing)


def find_caveat_texts(upper, lower, word, **changes):
    result = stiction.pair(upper, lower, **CAVEAT_OPTIONS | changes)
    return [caveat.text for caveat in result.caveats if word in caveat.text]


@pytest.mark.parametrize(("stretches", "has_caveat"), [((20, 20), True), ((20, 1), False), ((1, 1), False)])
def test_pair_of_maps_with_lay_has_a_caveat_about_the_orientation_of_the_lays(stretches, has_caveat):
    upper, lower = (build_map(seed, stretch=stretch) for seed, stretch in enumerate(stretches, start=1))
    assert len(find_caveat_texts(upper, lower, "orientation")) == has_caveat
    if has_caveat:
        assert find_caveat_texts(upper, lower, "orientation", rotate=90.0) == []


def test_caveat_about_scattered_missing_points_estimates_the_lost_contact_area():
    rng = np.random.default_rng(1)
    scattered, blob = rng.random((48, 48)) < 0.3, np.zeros((48, 48), bool)
    blob[5:30, 10:40] = True
    (text,) = find_caveat_texts(build_map(1, missing=scattered), build_map(2), "holes")
    # A point is missing between two measured points along x or y with the probability 0.3 (1 - (1 - 0.7**2)**2).
    assert text.startswith("22 % of the points")
    assert "up to 28 % too small" in text
    assert find_caveat_texts(build_map(1, missing=blob), build_map(2), "holes") == []
    assert find_caveat_texts(build_map(1), build_map(2), "holes") == []


@pytest.mark.parametrize("shortest_wavelength", [2.0, 8.0])
def test_contact_area_lost_at_missing_points_is_at_most_the_estimate_in_their_caveat(shortest_wavelength):
    rng = np.random.default_rng(3)
    maps = [
        self_affine_surface(
            9, hurst_exponent=0.8, rms=0.1, shape=(64, 64), spacing=0.5, shortest_wavelength=shortest_wavelength,
            side=side,
        )
        for side in ("upper", "lower")
    ]  # fmt: skip
    pierced_maps = [
        Surface(complete_map.heights, spacing=0.5, missing=rng.random((64, 64)) < 0.3) for complete_map in maps
    ]
    complete_result, pierced_result = (stiction.pair(*map_pair, **CAVEAT_OPTIONS) for map_pair in (maps, pierced_maps))
    (text,) = (caveat.text for caveat in pierced_result.caveats if "holes" in caveat.text)
    limit = float(re.findall(r"up to (\S+) % too small", text)[0]) / 100
    areas = [
        float(result.at()["contact_area_fraction"].sel(statistic="mean").squeeze())
        for result in (complete_result, pierced_result)
    ]
    assert 0.2 < 1 - areas[1] / areas[0] < limit
