"""Two maps at several relative positions: the same numbers as pressing by hand, and what must not change."""

import numpy as np
import pytest
import xarray
from stiction import (
    Surface,
    approach_at_load,
    contacts,
    gentle_friction,
    half_space,
    isotropic_surface,
    levelled,
    press,
    pressed_maps,
    pressed_maps_mean,
    run,
    self_affine_surface,
    surrogate,
)
from stiction.mechanics.patches import slopes
from stiction.studies.contact_statistics import QUANTILES
from stiction.studies.evaluation import member_values
from stiction.studies.pair import pair_study
from stiction.surfaces.pairing import MIN_PIECE_POINTS, MapPairs

ANGLES = (0.0, 30.0, 90.0, 180.0)
MATERIAL = {"mu0": [0.3, 0.4], "tau0": [0.0, 0.05]}
LOADS = (0.02, 0.1)
ROUND_OFF = 1e-9  # of the same sums at an approach that is found to 1e-12, or on lengths that are ten times as large
SOLVED = 1e-4  # area and friction of two solutions to 1e-6: points at a patch's edge may be in or out


def surface(side="lower", seed=3, shape=(64, 64), rms=0.02, shortest=0.4):
    return self_affine_surface(
        seed, hurst_exponent=0.8, rms=rms, shape=shape, spacing=0.1, longest_wavelength=3.2,
        shortest_wavelength=shortest, side=side,
    )  # fmt: skip


def pair(**changes):
    return surface("upper", **changes), surface("lower", **changes)


def numbers(result):
    return {name: values.values for name, values in result.data_vars.items() if values.dtype.kind == "f"}


def test_pieces_are_the_overlap_of_shifted_maps():
    """Rows and columns of the upper that lie on those of the lower, cut to 48 by 48 in the middle."""
    upper, lower = pair()
    pairs = MapPairs(upper, lower)
    x, y = pairs.moved(2)
    rows, columns = round(y / 0.1), round(x / 0.1)
    top, left = max(0, rows) + (64 - abs(rows) - 48) // 2, columns + (64 - columns - 48) // 2
    above = Surface(upper.heights[top - rows : top - rows + 48, left - columns : left - columns + 48], spacing=0.1)
    below = Surface(lower.heights[top : top + 48, left : left + 48], spacing=0.1)
    for piece, cut in zip(pairs.pair(2), (above, below), strict=True):
        np.testing.assert_allclose(levelled(piece, "plane").heights, levelled(cut, "plane").heights, atol=1e-15)


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_pressed_maps_equals_study_bit_for_bit(mechanics):
    """Scans that are level already are levelled once more by a study, which changes their last digits."""
    upper, lower = (levelled(body, "plane") for body in pair())
    hardness = {"hardness": 1.5} if mechanics == "half-space" else {}
    chosen = {"mechanics": mechanics, "effective_modulus": 20.0, "shifts": 2, "surrogates": 1, **hardness}
    study = pair_study(upper, lower, load=list(LOADS), mu0=0.3, direction=[0, 90], **chosen)
    prepared = study.surfaces.model_copy(update={"prepared": True})
    study = study.model_copy(update={"surfaces": prepared})
    expected = member_values(run(study), LOADS, mu0=[0.3], tau0=[0.0], of="shifts").isel(cut_off=0)
    result = pressed_maps(upper, lower, LOADS, mu0=0.3, directions=[0.0, 90.0], **chosen).isel(repetition=slice(2))
    assert (result["status"] == "ok").all()
    shared = {*expected.data_vars} & {*numbers(result)}
    assert len(shared) > 15
    for name in shared:
        present = expected[name].transpose(*result[name].dims)
        if "sliding" in present.dims:
            present = present.sel(sliding=result["sliding"])
        np.testing.assert_allclose(result[name].values, present.values, rtol=1e-15, err_msg=name)


def test_gap_has_its_own_slopes():
    upper, lower = pair()
    result = pressed_maps(upper, lower, [0.1], mu0=0.3, directions=[0.0, 45.0, 90.0], shifts=2, mechanics="asperities")
    gap = np.subtract(*(body.heights for body in MapPairs(upper, lower).pair(1)))
    along_y, along_x = np.gradient(gap, 0.1)
    at = result.isel(repetition=1)
    # Differences of neighbours miss the shortest waves, of four points.
    assert float(at["rms_gradient"]) == pytest.approx(np.sqrt((along_x**2 + along_y**2).mean()), rel=0.1)
    assert float(at["rms_slope"][1]) == pytest.approx(np.sqrt(((along_x + along_y) ** 2 / 2).mean()), rel=0.1)
    assert at["rms_slope"][0] ** 2 + at["rms_slope"][2] ** 2 == pytest.approx(float(at["rms_gradient"]) ** 2)
    alone = gentle_friction(0.3, rms_gradient=float(at["rms_gradient"]), rms_slope=float(at["rms_slope"][2]))
    assert float(at["gentle_friction"].sel(sliding="opposing", direction=90.0).squeeze()) == pytest.approx(float(alone))


def test_means_have_students_intervals_of_the_logarithm():
    upper, lower = pair()
    result = pressed_maps(upper, lower, LOADS, mu0=0.3, shifts=5, mechanics="asperities")
    result["friction_coefficient"].values[0, 0, 2] = np.nan
    result["status"].values[0, 0, 2] = "not-solved"
    mean = pressed_maps_mean(result)
    values = np.delete(result["friction_coefficient"].values[0, 0, :, 0, 0, 0], 2)
    middle, lower_end, upper_end = mean["friction_coefficient"].values[0, 0, 0, 0, 0]
    half = 3.182446305 * values.std(ddof=1) / 2  # Student's t of 3 degrees of freedom
    factor = np.exp(half / values.mean())
    assert (values >= 0).all()
    assert middle == pytest.approx(values.mean())
    assert (lower_end, upper_end) == pytest.approx((values.mean() / factor, values.mean() * factor))
    assert int(mean["ok"][0, 0, 0, 0, 0]), int(mean["shifts"]) == (4, 5)
    two = pressed_maps_mean(pressed_maps(upper, lower, LOADS, mu0=0.3, shifts=2, mechanics="asperities"))
    assert np.isnan(two["contact_area"].sel(statistic="upper")).all()


@pytest.mark.parametrize("mechanics", ["half-space", "asperities"])
def test_distributions_are_weighted_by_load(mechanics):
    upper, lower = pair()
    result = pressed_maps(upper, lower, LOADS, mu0=0.3, directions=[30.0], shifts=2, mechanics=mechanics)
    at = result.isel(repetition=1).sel(load=0.1)
    bodies = MapPairs(upper, lower).pair(1)
    if mechanics == "half-space":
        contact = half_space(*bodies, [0.1]).contact(0)
        force = np.bincount(contact.patches.ravel(), weights=contact.pressure.ravel())[1:] * 0.01
        area = np.bincount(contact.patches.ravel(), weights=contact.share.ravel())[1:] * 0.01
    else:
        touching = contacts(*bodies, float(at["approach"]))
        force, area = touching.force * touching.normal[:, 2], touching.area
    assert force.size == int(at["contact_count"])
    assert force.sum() == pytest.approx(0.1, rel=1e-6)
    # Areas on the ground plan are smaller by the cosines of slopes.
    assert area.sum() == pytest.approx(float(at["contact_area"]), rel=0.02)
    assert float(at["share_on_largest"]) == pytest.approx(force.max() / force.sum(), rel=1e-6)
    assert at["patch_area"].values == pytest.approx(np.quantile(area, QUANTILES), rel=1e-6)
    middle = float(at["pressure"].sel(fraction_below=0.5, method="nearest"))
    assert 0 < middle < float(at["pressure"].sel(fraction_below=0.9, method="nearest"))
    mean = 0.1 / float(at["contact_area"])
    assert 0.5 * mean < middle < 1.5 * mean


def test_load_fraction_on_steepest_slopes_equals_definition():
    upper, lower = pair()
    result = pressed_maps(upper, lower, [0.1], mu0=0.3, shifts=2, directions=[0.0])
    bodies = MapPairs(upper, lower).pair(0)
    first, body = half_space(*bodies, [0.1]).contact(0), bodies[0]
    steep = np.hypot(*slopes(body.heights, body.spacing, periodic=False))
    share = first.pressure[steep > np.quantile(steep, 0.9)].sum() / first.pressure.sum()
    assert float(result["share_on_steepest_upper"][0, 0]) == pytest.approx(share, abs=SOLVED)
    assert 0 <= float(result["share_on_steepest_lower"][0, 0]) < 0.5


class TestSurrogates:
    def test_surrogates_leave_shifts_unchanged(self):
        upper, lower = pair()
        chosen = {"mu0": 0.3, "directions": ANGLES, "mechanics": "asperities"}
        alone = pressed_maps(upper, lower, LOADS, shifts=3, **chosen)
        both = pressed_maps(upper, lower, LOADS, shifts=3, surrogates=4, seed=7, **chosen)
        assert both["surrogate"].values.tolist() == [False] * 3 + [True] * 4
        shifts, created = both.isel(repetition=slice(3)), both.isel(repetition=slice(3, None))
        xarray.testing.assert_identical(shifts.drop_attrs(), alone.drop_attrs())
        for index in range(4):
            bodies = [
                window_of(surrogate(body, 7, repetition=index, side=side))
                for body, side in ((upper, "upper"), (lower, "lower"))
            ]
            approaches = approach_at_load(*bodies, LOADS, mu0=0.0)
            area = press(*bodies, approaches).contact_area
            assert created["contact_area"].values[index] == pytest.approx(area, rel=ROUND_OFF)
        means = [pressed_maps_mean(both, surrogates=value) for value in (False, True)]
        assert float(means[1]["contact_area"][0, 0]) == pytest.approx(float(created["contact_area"][:, 0].mean()))
        assert [int(mean["shifts"]) for mean in means] == [3, 4]
        assert pressed_maps_mean(both).equals(means[0])
        with pytest.raises(ValueError, match="surrogates must be False where there are no others"):
            pressed_maps_mean(alone, surrogates=True)

    def test_surrogates_of_profiles_are_isotropic_surfaces(self):
        bodies = [surface(side, shape=(64, 512)).row(5) for side in ("upper", "lower")]
        chosen = {"mu0": 0.3, "directions": [0.0], "mechanics": "asperities"}
        result = pressed_maps(*bodies, [1.0], surrogates=3, seed=5, **chosen)
        assert result["surrogate"].values.all()
        assert result.attrs["shape"].tolist() == [384, 384]
        upper, lower = (
            isotropic_surface(body, 5, shape=(512, 512), repetition=2, side=side)
            for body, side in zip(bodies, ("upper", "lower"), strict=True)
        )
        area = press(
            *(created := (window_of(upper), window_of(lower))), approach_at_load(*created, [1.0], mu0=0.0)
        ).contact_area
        assert float(result["contact_area"][2, 0]) == pytest.approx(float(area[0]), rel=ROUND_OFF)
        assert int(pressed_maps_mean(result)["shifts"]) == 3
        with pytest.raises(ValueError, match="shifts are of maps"):
            pressed_maps(*bodies, [1.0], shifts=3, **chosen)


def window_of(body):
    """The middle three quarters of a surface, level."""
    rows, columns = (points - points // 4 for points in body.heights.shape)
    top, left = (body.heights.shape[0] - rows) // 2, (body.heights.shape[1] - columns) // 2
    cut = Surface(body.heights[top : top + rows, left : left + columns], spacing=body.spacing)
    return levelled(cut, "plane")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"loads": [0.0]}, "loads must be a list of numbers above 0 mN"),
        ({"directions": [0.0, 360.0]}, "directions must be one or several different angles"),
        ({"shifts": 0}, "shifts must be a whole number of at least 1"),
        ({"shifts": 5000}, "shifts must be fewer on maps of"),
        ({"seed": 1.5, "surrogates": 2}, "seed must be a whole number"),
        ({"level": "cubic"}, "level must be one of"),
        ({"mechanics": "asperities", "hardness": 1.0}, "hardness is for the half-space"),
        ({"lower": surface().row(0)}, "lower must be a Surface, got Profile"),
    ],
)
def test_pressed_maps_rejects_bad_input(changes, words):
    upper, lower = pair()
    arguments = {"upper": upper, "lower": lower, "loads": [0.1], "mu0": 0.3} | changes
    with pytest.raises(ValueError, match=words):
        pressed_maps(**arguments)


def test_pressed_maps_rejects_small_maps():
    small = Surface(np.zeros((MIN_PIECE_POINTS, 30)), spacing=1.0)
    with pytest.raises(ValueError, match="at least 16 rows and columns must lie above each other"):
        pressed_maps(small, small, [0.1], mu0=0.3)
