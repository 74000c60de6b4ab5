"""Profiles at listed positions along each other: the same numbers as pressing each position by itself."""

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
from stiction.studies import intervals
from stiction.studies.pair import pair_study

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


STEPS = (0.03, 0.3, 0.6, 0.72, 0.8, 0.87, 0.93, 1.0, 1.07, 1.15, 1.25, 1.4, 1.8, 3.0, 30.0)
"""Elastic loads over a normal load, close together where friction on slopes adds little."""


def study_of(upper, lower, loads, **options):
    """Return the study of a slider, whose heights are upwards, on a counterface, both unchanged."""
    unchanged = {"level": "none", "cutoff": "none", "positions": [0.0], "effective_modulus": 10.0}
    return pair_study(flipped(upper), lower, load=list(loads), **unchanged | options)


def run_pair(upper, lower, loads, **options):
    return run(study_of(upper, lower, loads, **options))


def at_positions(result, **arguments):
    """Return the values of members by the rule of opposing contacts, without dimensions of one element."""
    at = result.at(per_member=True, **arguments).sel(sliding="opposing").isel(cut_off=0)
    return at.swap_dims(repetition="x").squeeze(("mu0", "tau0"))


@pytest.fixture(scope="module")
def result(pair):
    return run_pair(*pair, LOADS, positions=[0.0, 4.0, 10.0], **FRICTION)


@pytest.mark.parametrize("shear", ["+x", "-x"])
@pytest.mark.parametrize("offset", [0.0, 4.0, 10.0])
def test_pair_at_positions_equals_press_at_each(pair, result, shear, offset):
    upper, lower = pair
    beneath = cropped(lower, offset, offset + 20)
    choices = {"detection": "gap-minimum", "shear": shear}
    where = {"x": offset, "direction": 0.0 if shear == "+x" else 180.0}
    at = at_positions(result).sel(where)
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
    at = at_positions(result, reading="normal").sel(where)
    approaches = approach_at_load(upper, beneath, LOADS, **FRICTION, **choices)
    curve = press(upper, beneath, approaches, **choices)
    np.testing.assert_allclose(at["friction_coefficient"], curve.friction_coefficient(**FRICTION), rtol=BETWEEN)
    np.testing.assert_allclose(at["tangential_load"], at["friction_coefficient"] * LOADS, rtol=EXACT)
    assert (at["status"] == "ok").all()


@pytest.mark.parametrize(("load", "within", "share"), [("elastic", 1e-6, 1.0), ("normal", BETWEEN, 0.75)])
def test_load_jumps_are_interpolated_linearly(rough_pair, load, within, share):
    upper, lower = rough_pair(1.5, repetition=1)
    loads = np.geomspace(1e-4, 3e-3, 12)
    steps = [f"{step} mN" for step in np.unique(np.outer(loads, STEPS))]
    study = study_of(upper, lower, loads, detection="cell", **FRICTION).with_changes({"contact.load": steps})
    at = at_positions(run(study), reading=load).isel(x=0)
    carrying = {"mu0": 0.0} if load == "elastic" else FRICTION
    off = []
    for shear, angle in (("+x", 0.0), ("-x", 180.0)):
        approaches = approach_at_load(upper, lower, loads, detection="cell", shear=shear, **carrying)
        for place in np.flatnonzero(at["status"].sel(direction=angle) == "ok"):
            both = approaches[place] * np.array([1 - 1e-10, 1])
            curve = press(upper, lower, both, detection="cell", shear=shear)
            normal, tangential = curve.normal_load(**carrying), curve.tangential_load(**FRICTION)
            if normal[1] > 1.001 * normal[0]:
                computed = float(at["tangential_load"].sel(direction=angle)[place])
                off.append(abs(computed - np.interp(loads[place], normal, tangential)) / loads[place])
    assert len(off) > 4
    assert np.quantile(off, share) < within


def test_positions_are_rounded_to_the_nearest_point(pair):
    upper, lower = pair
    assert 0.29 / 0.01 < 29  # by round-off
    at = at_positions(run_pair(upper, lower, [0.01], positions=[0.29], **FRICTION)).sel(direction=0.0)
    beneath = Profile(lower.heights[29 : 29 + len(upper)], spacing=0.01)
    expected = approach_at_load(upper, beneath, 0.01, detection="gap-minimum", shear="+x", mu0=0.0)
    assert float(at["approach"].squeeze()) == pytest.approx(float(expected), rel=EXACT)
    assert float(at["x"].squeeze()) == pytest.approx(0.29)


def test_slider_is_shortened_to_reach_the_last_position(pair):
    _, lower = pair
    result = run_pair(flipped(lower), lower, [0.01], positions=[1.0, 12.0], **FRICTION)
    assert result.dataset.attrs["shape"].tolist() == [1800]
    assert float(result.dataset["nominal_area"]) == pytest.approx(18.0)


def test_stiffness_of_two_arcs_equals_hertz(circular_arc):
    upper, lower = (circular_arc(0.5003, 1.0, 1e-3, 1001, side) for side in ("upper", "lower"))
    load = 0.01
    at = at_positions(run_pair(upper, lower, [load], mu0=0.0)).isel(x=0, load=0)
    overlap = (load / (4 / 3 * 10.0 * np.sqrt(0.5))) ** (2 / 3)
    # dF/dδ = 3/2 F/δ; over 2 % of the approach on both sides it is wrong by 1/24 of their square.
    np.testing.assert_allclose(at["normal_stiffness"], 1.5 * load / overlap, rtol=1e-4)


def test_values_of_members_have_units_names_and_history(result):
    at = result.at(per_member=True)
    assert at["contact_area"].attrs["units"] == "um^2"
    assert at["normal_stiffness"].attrs["units"] == "mN/um"
    assert at["load"].attrs["units"] == "mN"
    assert result.nominal_area == pytest.approx(20.0)
    assert (float(at["mu0"][0]), float(at["tau0"][0]), float(at["effective_modulus"])) == (0.3, 0.1, 10.0)
    assert result.study.contact.detection == "gap-minimum"
    assert "turned over" in at.attrs["upper"]
    assert at.attrs["stiction_version"] == stiction.__version__


def test_nondimensional_values_are_invariant_under_scaling(pair):
    def scaled(bodies, loads, length, **options):
        at = run_pair(*bodies, loads, detection="gap-minimum", mu0=0.3, **options).at(per_member=True)
        names = [name for name in at.data_vars if at[name].attrs.get("units") in ("1", "mN", "um", "um^2", "GPa")]
        return nondimensional(at[names], length=length)

    larger = [Profile(3 * item.heights, spacing=3 * item.spacing) for item in pair]
    one = scaled(pair, [0.01], 1.0, positions=[0.0, 5.0], tau0=0.1)
    other = scaled(larger, [0.01 * 9 * 2], 3.0, positions=[0.0, 15.0], tau0=0.2, effective_modulus=20.0)
    assert set(one.variables) == set(other.variables)
    assert {"friction_coefficient", "normal_load", "contact_area", "approach"} <= set(one.data_vars)
    for name in one.variables:
        if one[name].dtype.kind == "f" and name not in ("nominal_area", "contact_area_fraction", "nominal_pressure"):
            np.testing.assert_allclose(other[name], one[name], rtol=1e-6, atol=1e-12, err_msg=name)
            assert one[name].attrs["units"] in ("1", "degree")
    assert one["load"].attrs["long_name"].endswith("/ (E* L²)")


def test_nondimensional_requires_modulus_and_known_units(result):
    at = result.at(per_member=True)[["contact_area"]]
    with pytest.raises(ValueError, match="length must be given"):
        nondimensional(at)
    with pytest.raises(ValueError, match=r"length must be .* above 0"):
        nondimensional(at, length=-1.0)
    without = at.drop_attrs(deep=False).drop_vars("effective_modulus")
    with pytest.raises(ValueError, match="effective_modulus must be given"):
        nondimensional(without, length=1.0)
    at = at.copy()
    at["contact_area"].attrs["units"] = "acre"
    with pytest.raises(ValueError, match="contact_area has the unknown unit 'acre'"):
        nondimensional(at, length=1.0)


# ---- Statuses and means ----------------------------------------------------------------------------------------------


def test_positions_without_result_have_status_and_are_left_out_of_mean():
    x = np.arange(2001) * 0.01 - 10.0
    flat, ball = Profile(np.zeros(2001), spacing=0.01), Profile(-0.05 * x**2, spacing=0.01)
    reached = run_pair(flat, ball, [1e-3, 1e9], mu0=0.3)
    assert at_positions(reached)["status"].isel(x=0, direction=0).values.tolist() == ["ok", "not-reached"]
    nothing = run_pair(flat, flat, [1.0], mu0=0.3)
    assert (nothing.at(per_member=True)["status"] == "no-contact").all()
    # Two bows on a slope of 3, up which the upper body is pushed, or down.
    upper, lower = (Profile(3 * x + bow * x**2, spacing=0.01) for bow in (0.05, -0.05))
    for mu0, status in ((0.3, "ok"), (0.34, "self-locked")):  # mu0 tan θ = 1 at 1/3
        at = at_positions(run_pair(upper, lower, [1e-3], mu0=mu0))
        assert at["status"].isel(x=0).values.ravel().tolist() == [status, "ok"]
    grazed = run_pair(flat, Profile(-0.05 * (x - 0.005) ** 2, spacing=0.01), [1e-12], mu0=0.3)
    at = grazed.at(per_member=True)
    assert (at["status"] == "below-range").all()
    assert at["approach"].isnull().all()
    mean = reached.at().sel(sliding="opposing", direction=0.0).isel(cut_off=0, mu0=0, tau0=0)
    assert mean["ok"].values.tolist() == [1, 0]
    assert mean["friction_coefficient"][1].isnull().all()
    values = mean["contact_area"][0]
    assert np.isfinite(values[0])
    assert values[1:].isnull().all()  # one position has no interval


def test_several_materials_equal_single_materials(pair):
    both = run_pair(*pair, LOADS, mu0=[0.3, 0.5], tau0=[0.0, 0.1], positions=np.arange(9.0))
    values, mean = both.at(per_member=True), both.at()
    for mu0 in (0.3, 0.5):
        for tau0 in (0.0, 0.1):
            alone = both.at(mu0=mu0, tau0=tau0, per_member=True)
            assert values.sel(mu0=[mu0], tau0=[tau0]).identical(alone)
            selected = mean.sel(mu0=mu0, tau0=tau0)["friction_coefficient"]
            np.testing.assert_array_equal(selected, both.at(mu0=mu0, tau0=tau0)["friction_coefficient"][..., 0, 0, :])


def test_mean_accounts_for_correlated_positions(pair):
    at = run_pair(*pair, [0.01], positions=np.arange(10.0), **FRICTION)
    values = at_positions(at)["friction_coefficient"].isel(load=0).sel(direction=0.0).values
    mean = at.at()["friction_coefficient"].isel(cut_off=0, load=0, mu0=0, tau0=0).sel(sliding="opposing", direction=0.0)
    np.testing.assert_allclose(mean, intervals.neighbors_mean(values))


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
        ({"positions": [1.0, 1.0]}, "positions must differ"),
        ({"positions": [-1.0]}, "positions must be at least 0"),
        ({"positions": [26.0]}, "leaves half of the shorter profile as slider"),
        ({"positions": ["2 mN"]}, "positions has the unit 'mN'"),
        ({"positions": [0.0], "offsets": 3}, "offsets must not be given with positions"),
        ({"positions": [0.0], "travel": "1 um"}, "travel must not be given with positions"),
        ({"load": [0.0]}, "load must be"),
        ({"mu0": -1.0}, "mu0 must be at least 0"),
        ({"direction": [0]}, "direction is for areas"),
    ],
)
def test_pair_rejects_bad_positions_of_profiles(pair, arguments, words):
    upper, lower = pair
    options = {"load": [0.01], "mu0": 0.3, "effective_modulus": 10.0, "positions": [0.0]} | arguments
    with pytest.raises(ValueError, match=words):
        stiction.pair(Profile(upper.heights, spacing=0.01), lower, **options)


def test_study_rejects_members_beyond_its_positions(pair):
    study = study_of(*pair, [0.01], mu0=0.3, positions=[0.0, 1.0])
    with pytest.raises(ValueError, match="positions has 2 positions, but member 2 needs position 3"):
        run(study.with_changes({"ensemble.repetitions": 3}))
    with pytest.raises(ValueError, match="must not be given with offsets or travel"):
        study.with_changes({"surfaces.travel": "1 um"})


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


def test_opposing_load_fraction_equals_that_of_contacts():
    upper, lower = two_rough_profiles()
    slider = cropped(upper, 0, 15)
    result = at_positions(run_pair(slider, lower, [0.3], mu0=0.3, positions=[1.0])).isel(x=0, load=0)
    for shear, angle in (("+x", 0.0), ("-x", 180.0)):
        at = result.sel(direction=angle)
        computed = contacts(slider, cropped(lower, 1, 16), float(at["approach"]), detection="gap-minimum", shear=shear)
        load = computed.force * computed.normal[:, 2]
        share = load[computed.opposing].sum() / load.sum()
        assert 0.05 < share < 0.95
        assert np.isclose(float(at["share_opposing"]), share, rtol=1e-6)
    assert float(result["share_opposing"].sum()) == pytest.approx(1.0, abs=0.02)  # but for squares of slopes


# ---- Half-planes -----------------------------------------------------------------------------------------------------

SAME = 1e-12  # relative: the same solution, summed in the same order


@pytest.fixture(scope="module")
def small_pair():
    return cropped(flipped(scan("upper", points=600)), 0, 2), scan("lower", points=600)


@pytest.mark.parametrize("sliding", ["opposing", "all"])
def test_pair_of_half_planes_at_positions_equals_half_space(small_pair, sliding):
    upper, lower = small_pair
    model = {"mechanics": "half-space", "effective_modulus": 8.0}
    result = run_pair(upper, lower, LOADS, positions=[0.0, 2.5], **FRICTION, **model)
    arguments = {"effective_modulus": 8.0, "sliding": sliding}
    values = result.at(per_member=True).sel(sliding=sliding).isel(cut_off=0, mu0=0, tau0=0).swap_dims(repetition="x")
    assert (values["status"] == "ok").all()
    for offset in (0.0, 2.5):
        for shear, angle in (("+x", 0.0), ("-x", 180.0)):
            at = values.sel(x=offset, direction=angle)
            steps = [float(load) for load in result.study.contact.load]
            curve = half_space(upper, cropped(lower, offset, offset + 2), steps, direction=shear, **arguments)
            asked = [steps.index(load) for load in LOADS]
            np.testing.assert_allclose(at["tangential_load"], curve.tangential_load(**FRICTION)[asked], rtol=SAME)
            coefficient = curve.friction_coefficient(**FRICTION)[asked]
            np.testing.assert_allclose(at["friction_coefficient"], coefficient, rtol=SAME)
            np.testing.assert_allclose(at["contact_area"], curve.contact_area[asked], rtol=SAME)
            np.testing.assert_array_equal(at["contact_count"], curve.contact_count[asked])
    both = values["share_opposing"].sum("direction").values
    np.testing.assert_allclose(both, 1, atol=0.02)  # every patch opposes one of the two, but for squares of slopes
    for name in ("approach", "normal_stiffness"):
        assert values[name].isnull().all()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"mechanics": "half-plane"}, "mechanics must be"),
        ({"mechanics": "half-space", "law": "hertz-cylinder"}, "law is for mechanics asperities"),
    ],
)
def test_pair_of_half_planes_rejects_asperity_options(small_pair, arguments, words):
    with pytest.raises(ValueError, match=words):
        pair_study(*small_pair, load=LOADS, effective_modulus=10.0, **FRICTION, **arguments)
