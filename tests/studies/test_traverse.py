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
    self_affine,
    surrogate,
    traverse,
    traverse_mean,
)
from stiction.studies import intervals

LOADS = [0.003, 0.03]
FRICTION = {"mu0": 0.3, "tau0": 0.1}
EXACT = 1e-9  # relative: roots are found to 1e-12 of the approach
BETWEEN = 2e-3  # relative, of what is read off between two elastic loads that are pressed, and of friction there


def scan(side="lower", *, points=3000, repetition=0, spacing=0.01):
    return self_affine(
        5, hurst_exponent=0.8, rms=0.03, points=points, spacing=spacing, shortest_wavelength=20 * spacing,
        longest_wavelength=300 * spacing, side=side, repetition=repetition,
    )  # fmt: skip


@pytest.fixture(scope="module")
def pair():
    return cropped(flipped(scan("upper")), 0, 20), scan("lower")


@pytest.fixture(scope="module")
def result(pair):
    return traverse(*pair, LOADS, offsets=[0.0, 4.0, 10.0], **FRICTION)


@pytest.mark.parametrize("shear", ["+x", "-x"])
@pytest.mark.parametrize("offset", [0.0, 4.0, 10.0])
def test_traverse_equals_press_at_each_position(pair, result, shear, offset):
    upper, lower = pair
    beneath = cropped(lower, offset, offset + 20)
    choices = {"detection": "gap-minimum", "shear": shear}
    elastic = traverse(upper, lower, LOADS, offsets=[offset], load="elastic", **FRICTION)
    at = elastic.sel(shear=shear, offset=offset, line=0)
    approaches = approach_at_load(upper, beneath, LOADS, mu0=0.0, **choices)
    curve = press(upper, beneath, approaches, **choices)
    np.testing.assert_allclose(at["approach"], approaches, rtol=EXACT)
    np.testing.assert_allclose(at["friction_coefficient"], curve.friction_coefficient(**FRICTION), rtol=EXACT)
    np.testing.assert_allclose(at["tangential_load"], curve.tangential_load(**FRICTION), rtol=EXACT)
    np.testing.assert_allclose(at["contact_area"], curve.contact_area, rtol=EXACT)
    np.testing.assert_array_equal(at["contact_count"], curve.contact_count)
    np.testing.assert_allclose(at["share_beyond_hertz"], curve.validity.share_beyond_hertz, rtol=EXACT, atol=1e-12)
    for index, approach in enumerate(approaches):
        ends = press(upper, beneath, [0.98 * approach, 1.02 * approach], **choices).normal_elastic
        assert float(at["normal_stiffness"][index]) == pytest.approx((ends[1] - ends[0]) / (0.04 * approach))
    at = result.sel(shear=shear, offset=offset, line=0)
    approaches = approach_at_load(upper, beneath, LOADS, **FRICTION, **choices)
    curve = press(upper, beneath, approaches, **choices)
    np.testing.assert_allclose(at["friction_coefficient"], curve.friction_coefficient(**FRICTION), rtol=BETWEEN)
    np.testing.assert_allclose(at["tangential_load"], at["friction_coefficient"] * LOADS, rtol=EXACT)
    np.testing.assert_allclose(at["approach"], approaches, rtol=BETWEEN)
    np.testing.assert_allclose(at["contact_area"], curve.contact_area, rtol=BETWEEN)
    assert (at["status"] == "ok").all()


@pytest.mark.parametrize(("load", "within", "share"), [("elastic", 1e-6, 1.0), ("normal", BETWEEN, 0.75)])
def test_load_jumps_are_interpolated_linearly(rough_pair, load, within, share):
    upper, lower = rough_pair(1.5, repetition=1)
    loads = np.geomspace(1e-4, 3e-3, 12)
    at = traverse(upper, lower, loads, detection="cell", load=load, **FRICTION).isel(line=0, offset=0)
    carrying = {"mu0": 0.0} if load == "elastic" else FRICTION
    off = []
    for shear in ("+x", "-x"):
        approaches = approach_at_load(upper, lower, loads, detection="cell", shear=shear, **carrying)
        for place in np.flatnonzero(at["status"].sel(shear=shear) == "ok"):
            both = approaches[place] * np.array([1 - 1e-10, 1])
            curve = press(upper, lower, both, detection="cell", shear=shear)
            normal, tangential = curve.normal_load(**carrying), curve.tangential_load(**FRICTION)
            if normal[1] > 1.001 * normal[0]:
                computed = float(at["tangential_load"].sel(shear=shear)[place])
                off.append(abs(computed - np.interp(loads[place], normal, tangential)) / loads[place])
    assert len(off) > 4
    assert np.quantile(off, share) < within


def test_traverse_rounds_offset_to_nearest_point(pair):
    upper, lower = pair
    assert 0.29 / 0.01 < 29  # by round-off
    at = traverse(upper, lower, [0.01], offsets=[0.29], **FRICTION).sel(shear="+x")
    beneath = Profile(lower.heights[29 : 29 + len(upper)], spacing=0.01)
    expected = approach_at_load(upper, beneath, 0.01, detection="gap-minimum", shear="+x", **FRICTION)
    assert float(at["approach"].squeeze()) == pytest.approx(float(expected), rel=BETWEEN)
    assert float(at["offset"].squeeze()) == pytest.approx(0.29)


def test_stiffness_of_two_arcs_equals_hertz(circular_arc):
    upper, lower = (circular_arc(0.5003, 1.0, 1e-3, 1001, side) for side in ("upper", "lower"))
    load = 0.01
    at = traverse(upper, lower, [load], mu0=0.0).isel(line=0, offset=0, load=0)
    overlap = (load / (4 / 3 * 10.0 * np.sqrt(0.5))) ** (2 / 3)
    # dF/dδ = 3/2 F/δ; over 2 % of the approach on both sides it is wrong by 1/24 of their square.
    np.testing.assert_allclose(at["normal_stiffness"], 1.5 * load / overlap, rtol=1e-4)


def test_traverse_result_has_units_names_and_history(result):
    assert result["contact_area"].attrs["units"] == "um^2"
    assert result["normal_stiffness"].attrs["units"] == "mN/um"
    assert result["load"].attrs["units"] == "mN"
    assert float(result["nominal_area"]) == pytest.approx(20.0)
    assert (float(result["mu0"]), float(result["tau0"]), float(result["effective_modulus"])) == (0.3, 0.1, 10.0)
    assert result.attrs["detection"] == "gap-minimum"
    assert "turned over" in result.attrs["upper"]
    assert result.attrs["stiction_version"] == stiction.__version__


def test_nondimensional_traverse_is_invariant_under_scaling(pair):
    larger = [Profile(3 * item.heights, spacing=3 * item.spacing) for item in pair]
    one = nondimensional(traverse(*pair, [0.01], offsets=[0.0, 5.0], **FRICTION), length=1.0)
    other = traverse(
        *larger, [0.01 * 9 * 2], offsets=[0.0, 15.0], mu0=0.3, tau0=0.2, effective_modulus=20.0
    )  # fmt: skip
    other = nondimensional(other, length=3.0)
    assert set(one.variables) == set(other.variables)
    for name in one.variables:
        if one[name].dtype.kind == "f" and name != "nominal_area":  # of the same thickness
            np.testing.assert_allclose(other[name], one[name], rtol=1e-6, atol=1e-12, err_msg=name)
            assert one[name].attrs["units"] == "1"
    assert one["load"].attrs["long_name"] == "normal load / (E* L²)"


def test_nondimensional_requires_modulus_and_known_units(result):
    with pytest.raises(ValueError, match="length must be given"):
        nondimensional(result)
    with pytest.raises(ValueError, match=r"length must be .* above 0"):
        nondimensional(result, length=-1.0)
    with pytest.raises(ValueError, match="effective_modulus must be given"):
        nondimensional(result.drop_vars("effective_modulus"), length=1.0)
    result = result.copy()
    result["contact_area"].attrs["units"] = "acre"
    with pytest.raises(ValueError, match="contact_area has the unit 'acre'"):
        nondimensional(result, length=1.0)


# ---- Statuses and means ----------------------------------------------------------------------------------------------


def test_positions_without_result_have_status_and_are_left_out_of_mean():
    x = np.arange(2001) * 0.01 - 10.0
    flat, ball = Profile(np.zeros(2001), spacing=0.01), Profile(-0.05 * x**2, spacing=0.01)
    reached = traverse(flat, ball, [1e-3, 1e9], mu0=0.3)
    assert reached["status"].values[0, 0, 0].tolist() == ["ok", "not-reached"]
    nothing = traverse(flat, flat, [1.0], mu0=0.3)
    assert (nothing["status"] == "no-contact").all()
    # Two bows on a slope of 3, up which the upper body is pushed, or down.
    upper, lower = (Profile(3 * x + bow * x**2, spacing=0.01) for bow in (0.05, -0.05))
    for mu0, status in ((0.3, "ok"), (0.34, "self-locked")):  # mu0 tan θ = 1 at 1/3
        assert traverse(upper, lower, [1e-3], mu0=mu0)["status"].values.ravel().tolist() == [status, "ok"]
    grazed = Profile(-0.05 * (x - 0.005) ** 2, spacing=0.01)
    at_once = traverse(flat, grazed, [1e-12], mu0=0.3)
    assert (at_once["status"] == "below-range").all()
    assert np.isnan(at_once["approach"]).all()
    mean = traverse_mean(reached)
    assert mean["ok"].sel(shear="+x").values.tolist() == [1, 0]
    assert np.isnan(mean["friction_coefficient"].sel(shear="+x").values[1]).all()
    values = mean["contact_area"].sel(shear="+x").values[0]
    assert np.isfinite(values[0])
    assert np.isnan(values[1:]).all()  # one position has no interval


def test_several_materials_equal_single_materials(pair):
    both = traverse(*pair, LOADS, mu0=[0.3, 0.5], tau0=[0.0, 0.1], offsets=np.arange(9.0))
    assert both["friction_coefficient"].dims == ("shear", "line", "offset", "load", "mu0", "tau0")
    mean = traverse_mean(both)
    for m, mu0 in enumerate([0.3, 0.5]):
        for t, tau0 in enumerate([0.0, 0.1]):
            alone = traverse(*pair, LOADS, mu0=mu0, tau0=tau0, offsets=np.arange(9.0))
            assert both.isel(mu0=m, tau0=t).identical(alone)
            assert mean.isel(mu0=m, tau0=t).equals(traverse_mean(alone))
    several = traverse(*pair, LOADS, mu0=[0.3], offsets=[0.0])
    assert dict(several.sizes) == {"shear": 2, "line": 1, "offset": 1, "load": 2, "mu0": 1}


def test_traverse_mean_accounts_for_correlated_positions(pair):
    upper, lower = pair
    one = traverse([upper] * 8, [lower] * 8, [0.01], offsets=[0.0, 2.0, 4.0, 6.0], **FRICTION)
    lines = np.array([10.0, 11.0, 13.0, 9.0, 12.0, 14.0, 8.0, 10.5])
    one["contact_area"] = (one["contact_area"].dims, lines[:, np.newaxis, np.newaxis] + np.zeros((2, 8, 4, 1)))
    area = traverse_mean(one)["contact_area"].values
    np.testing.assert_allclose(area[0, 0], intervals.neighbors_mean(lines))
    # Fewer answers of a line weigh less.
    one["status"][:, 7, 1:] = "not-reached"
    mean, low, high = traverse_mean(one)["contact_area"].values[0, 0]
    assert mean == pytest.approx((4 * lines[:7].sum() + lines[7]) / 29)
    assert low < mean < high
    one["status"][:, 1:] = "not-reached"
    assert traverse_mean(one)["contact_area"].values[0, 0, 0] == 10.0


# ---- From scans to pairs ---------------------------------------------------------------------------------------------


def test_paired_lines_returns_half_slider_and_track():
    upper, lower = scan("upper"), scan("lower")
    (slider,), (track,) = paired_lines(upper, lower)
    whole = levelled(upper, "line")
    np.testing.assert_array_equal(track.heights, levelled(lower, "line").heights)
    np.testing.assert_allclose(slider.heights, levelled(flipped(cropped(whole, 0, 15)), "line").heights, atol=1e-15)
    assert slider.history[-2:] == ("cropped to 0 to 15 µm", "levelled by a line")
    (short,), (track,) = paired_lines(cropped(upper, 0, 5), lower)
    assert (len(short), len(track)) == (500, 3000)
    (slider,), (track,) = paired_lines(scan("upper", points=800, spacing=0.02), lower)  # on the finer grid of both
    assert (slider.spacing, track.spacing, len(track)) == (0.01, 0.01, 3000)


def test_travel_shortens_the_slider():
    (slider,), (track,) = paired_lines(scan("upper"), scan("lower"), travel=10.0, level=None)
    assert (len(slider), len(track)) == (2000, 3000)
    np.testing.assert_array_equal(slider.heights, -scan("upper").heights[:2000])
    for travel in (15.5, -1.0, np.nan, 1e9):
        with pytest.raises(ValueError, match="travel"):
            paired_lines(scan("upper"), scan("lower"), travel=travel)


def maps():
    lines = [scan("lower", points=400, repetition=line).heights for line in range(9)]
    return Surface(lines, spacing=(0.02, 0.01))


def test_paired_lines_of_surfaces_are_a_third_of_their_width_apart():
    surface = maps()
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
    for lines in (1, 2):  # never a line with itself
        uppers, lowers = paired_lines(surface, surface, level=None, lines=lines)
        np.testing.assert_array_equal(uppers[0].heights, -surface.heights[0][: len(uppers[0])])
        np.testing.assert_array_equal(lowers[0].heights, surface.heights[3])
    two = Surface(surface.heights[:2], spacing=0.01)
    np.testing.assert_array_equal(paired_lines(two, two, level=None)[1][1].heights, two.heights[0])
    uppers, lowers = paired_lines(surface, scan("upper"), lines=3)
    assert len(lowers[0]) == 400
    assert uppers[1].history[:1] == ("row 3",)


def test_paired_lines_of_different_lengths_cover_the_longer():
    surface = maps()
    for lengths in ((400, 3000), (3000, 400)):
        bodies = [surface if length == 400 else scan("upper") for length in lengths]
        uppers, lowers = paired_lines(*bodies, level=None, lines=9)
        assert {len(upper) for upper in (*uppers, *lowers)} == {400}
        longer = np.array([item.heights for item in (uppers if lengths[0] == 3000 else lowers)])
        whole = scan("upper").heights * (-1 if lengths[0] == 3000 else 1)
        starts = [int(np.flatnonzero(np.isclose(whole, line[0], rtol=0, atol=0))[0]) for line in longer]
        np.testing.assert_array_equal(longer, [whole[start : start + 400] for start in starts])
        assert min(starts) == 0
        assert max(starts) > 0.8 * 2600
        assert np.diff(np.sort(starts)).max() < 2 * 2600 / 9
    assert "cropped" in uppers[1].history[-1]
    leveled, _ = paired_lines(scan("upper"), surface, lines=2)
    np.testing.assert_allclose(levelled(leveled[1], "line").heights, leveled[1].heights, atol=1e-12)


def test_surrogates_replace_the_selected_surface():
    upper, lower = scan("upper"), scan("lower")
    uppers, lowers = paired_lines(upper, lower, surrogates="lower", lines=3, seed=9)
    assert len(uppers) == 3
    np.testing.assert_array_equal(uppers[0].heights, uppers[1].heights)
    for line in range(3):
        expected = surrogate(levelled(lower, "line"), 9, repetition=line, side="lower")
        np.testing.assert_array_equal(lowers[line].heights, expected.heights)
    uppers, _ = paired_lines(upper, lower, surrogates="both", lines=2)
    assert not np.array_equal(uppers[0].heights, uppers[1].heights)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"offsets": [1.0, 0.0]}, "offsets must be numbers .* that rise"),
        ({"offsets": [0.0, 0.001]}, "at least a spacing apart"),
        ({"offsets": [11.0]}, "slider must be over the lower profile"),
        ({"loads": [0.0]}, "loads must be"),
        ({"mu0": -1.0}, "mu0 must not be negative"),
        ({"shear": "+x"}, "shear must not be given"),
        ({"direction": "-x"}, "direction must not be given"),
        ({"upper": [1, 2]}, "upper must be a Profile or a list"),
    ],
)
def test_traverse_rejects_bad_arguments(pair, arguments, words):
    upper, lower = pair
    options = {"upper": upper, "lower": lower, "loads": [0.01], "mu0": 0.3} | arguments
    with pytest.raises(ValueError, match=words):
        traverse(options.pop("upper"), options.pop("lower"), options.pop("loads"), **options)


def test_traverse_rejects_lists_of_different_lengths(pair):
    upper, lower = pair
    with pytest.raises(ValueError, match="as many profiles, got 2 and 1"):
        traverse([upper, upper], lower, [0.01], mu0=0.3)
    with pytest.raises(ValueError, match="same grid"):
        traverse([upper, cropped(upper, 0, 10)], [lower, lower], [0.01], mu0=0.3)


@pytest.mark.parametrize(
    ("arguments", "words"), [({"along": "z"}, "along must be one of"), ({"lines": 0}, "lines must be a whole number")]
)
def test_paired_lines_rejects_bad_arguments(arguments, words):
    with pytest.raises(ValueError, match=words):
        paired_lines(maps(), maps(), **arguments)
    with pytest.raises(ValueError, match="upper must be a Profile or a Surface"):
        paired_lines([1, 2], maps())


def two_rough_profiles():
    return tuple(
        self_affine(4, hurst_exponent=0.8, rms=0.03, points=2000, spacing=0.01, shortest_wavelength=0.2, side=side)
        for side in ("upper", "lower")
    )


@pytest.mark.parametrize("sliding", ["opposing", "all"])
def test_opposing_load_fraction_equals_that_of_contacts(sliding):
    upper, lower = two_rough_profiles()
    slider = cropped(upper, 0, 15)
    result = traverse(slider, lower, [0.3], mu0=0.3, offsets=[1.0], sliding=sliding, load="elastic")
    assert result.attrs["sliding"] == sliding
    for shear in ("+x", "-x"):
        at = result.sel(shear=shear, line=0, offset=1.0, load=0.3)
        computed = contacts(slider, cropped(lower, 1, 16), float(at["approach"]), detection="gap-minimum", shear=shear)
        load = computed.force * computed.normal[:, 2]
        share = load[computed.opposing].sum() / load.sum()
        assert 0.05 < share < 0.95
        assert np.isclose(float(at["share_opposing"]), share, rtol=1e-6)
    np.testing.assert_allclose(result["share_opposing"].sum("shear"), 1.0, atol=0.02)  # but for what friction adds


# ---- Half-planes -----------------------------------------------------------------------------------------------------

SAME = 1e-12  # relative: the same solution, summed in the same order


@pytest.fixture(scope="module")
def small_pair():
    return cropped(flipped(scan("upper", points=600)), 0, 2), scan("lower", points=600)


@pytest.mark.parametrize("sliding", ["opposing", "all"])
def test_traverse_of_half_planes_equals_half_space(small_pair, sliding):
    upper, lower = small_pair
    arguments = {"compliance_share": 0.3, "effective_modulus": 8.0, "sliding": sliding}
    result = traverse(upper, lower, LOADS, offsets=[0.0, 2.5], mechanics="half-space", **FRICTION, **arguments)
    assert (result["status"] == "ok").all()
    for offset in (0.0, 2.5):
        for shear in ("+x", "-x"):
            at = result.sel(shear=shear, offset=offset, line=0)
            curve = half_space(upper, cropped(lower, offset, offset + 2), LOADS, direction=shear, **arguments)
            np.testing.assert_allclose(at["tangential_load"], curve.tangential_load(**FRICTION), rtol=SAME)
            np.testing.assert_allclose(at["friction_coefficient"], curve.friction_coefficient(**FRICTION), rtol=SAME)
            np.testing.assert_allclose(at["contact_area"], curve.contact_area, rtol=SAME)
            np.testing.assert_array_equal(at["contact_count"], curve.contact_count)
    both = result["share_opposing"].sum("shear").values
    np.testing.assert_allclose(both, 1, atol=0.02)  # every patch opposes one of the two, but for squares of slopes
    for name in ("approach", "normal_stiffness", "relative_overlap", "share_below_grid"):
        assert np.isnan(result[name]).all()
    assert result.attrs["mechanics"] == "half-space"
    assert "law" not in result.attrs


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"mechanics": "half-plane"}, "mechanics must be"),
        ({"mechanics": "half-space", "law": "hertz-cylinder"}, "law must not be given for half-planes"),
        ({"mechanics": "half-space", "compliance_share": 1.5}, "compliance_share must be from 0 to 1, got 1.5"),
    ],
)
def test_traverse_of_half_planes_rejects_asperity_options(small_pair, arguments, words):
    with pytest.raises(ValueError, match=words):
        traverse(*small_pair, LOADS, **FRICTION, **arguments)


def test_traverse_rejects_half_space_for_surfaces():
    flat = Surface(np.zeros((20, 20)), spacing=0.1)
    with pytest.raises(ValueError, match="mechanics of surfaces must be 'asperities', got 'half-space'"):
        traverse(flat, flat, LOADS, mechanics="half-space", **FRICTION)
