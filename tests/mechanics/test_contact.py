import math
import warnings

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from reference import pressing
from stiction import (
    HertzCylinder,
    HertzSphere,
    JacksonGreen,
    Profile,
    contacts,
    gentle_friction,
    press,
    random_phases,
    slope_friction,
    weierstrass_mandelbrot,
)
from support.threads import releases_interpreter_lock

CONTACT_SUM_NAMES = (
    "contact_count", "contact_area", "normal_elastic", "tangential_elastic",
    "normal_frictional", "tangential_frictional", "normal_adhesive", "tangential_adhesive",
)  # fmt: skip

# Tolerances for a slow reference, which uses another spline solver and another order of operations.
REFERENCE_TOLERANCES = {"cell": 1e-9, "gap-minimum": 1e-7}
REFERENCE_FUNCTIONS = {"cell": pressing.find_contacts, "gap-minimum": pressing.find_contacts_at_minima}
# The curvature of a spline on a circle has an error of second order in spacing / radius, which is 1e-3 here.
CIRCLE_TOLERANCE = 1e-6
MIRROR_TOLERANCE = 1e-9
EXCHANGE_TOLERANCE = 1e-8
SCALING_TOLERANCE = 1e-8
ROUND_OFF = 1e-12


def stack_contact_sums(curve):
    return np.array([getattr(curve, name) for name in CONTACT_SUM_NAMES], dtype=float)


def assert_close(actual, expected, tolerance):
    """Assert that all values agree within a relative tolerance."""
    assert np.all(np.abs(actual - expected) <= tolerance * np.abs(expected)), (actual, expected)


class TestProfilesAgainstReference:
    @pytest.mark.parametrize("detection", ["cell", "gap-minimum"])
    @pytest.mark.parametrize("curvature", ["convex", "signed"])
    @pytest.mark.parametrize("bodies", ["rough on rough", "flat on rough", "rough on flat"])
    @pytest.mark.parametrize("dimension", [1.0, 1.7])
    def test_load_curve_of_profiles_agrees_with_the_reference_implementation(
        self, create_rough_profiles, dimension, bodies, curvature, detection
    ):
        upper, lower = create_rough_profiles(dimension, points=150_000)
        flat = Profile(np.full(len(upper), 0.37), spacing=upper.spacing)
        upper = flat if bodies.startswith("flat") else upper
        lower = flat if bodies.endswith("flat") else lower
        approaches = [0.001, 0.004, 0.02]
        reference_function = REFERENCE_FUNCTIONS[detection]
        is_signed = curvature == "signed"
        rows = [
            reference_function(upper.heights, lower.heights, upper.spacing, approach, signed=is_signed)
            for approach in approaches
        ]
        assert sum(map(len, rows)) >= 5
        for shear, sigma in (("+x", 1), ("-x", -1)):
            curve = press(upper, lower, approaches, curvature=curvature, shear=shear, detection=detection)
            expected = np.transpose([list(pressing.sum_contacts(row, sigma).values()) for row in rows])
            assert_close(stack_contact_sums(curve), expected, REFERENCE_TOLERANCES[detection])

    def test_contacts_of_profiles_agree_with_the_reference_implementation(self, create_rough_profiles):
        upper, lower = create_rough_profiles(1.4)
        table = contacts(upper, lower, 0.01, effective_modulus=3.0)
        rows = pressing.find_contacts(upper.heights, lower.heights, upper.spacing, 0.01, effective_modulus=3.0)
        assert len(table) == len(rows) > 10
        assert np.array_equal(table.index, rows[:, 0])
        computed_rows = np.column_stack([table.normal[:, [0, 2]], table.overlap, table.radius, table.force, table.area])
        assert np.allclose(computed_rows, rows[:, 1:], rtol=REFERENCE_TOLERANCES["cell"], atol=0)

    def test_load_curve_is_independent_of_height_offset(self, create_rough_profiles):
        upper, lower = create_rough_profiles(1.2)
        raised_profile = Profile(upper.heights + 1024.0, spacing=upper.spacing)
        # The addition of 1024 rounds the heights to 2^-43 µm, 1e-12 of the amplitude. Curvatures are affected most.
        assert_close(
            stack_contact_sums(press(raised_profile, lower, [0.01])),
            stack_contact_sums(press(upper, lower, [0.01])),
            1e-5,
        )


class TestProfilesAgainstExactSolutions:
    def test_contact_of_two_circles_equals_hertz_solution(self, create_circular_arc):
        spacing, points, modulus = 0.002, 1000, 7.0
        for apexes, radii in (
            ((1.0005, 1.0005), (2.0, 3.0)),
            ((1.0307, 0.9411), (2.0, 3.0)),
            ((0.95, 1.0), (5.0, 2.5)),
        ):
            upper = create_circular_arc(apexes[0], radii[0], spacing, points, "upper")
            lower = create_circular_arc(apexes[1], radii[1], spacing, points, "lower")
            contact_gap = (upper.heights - lower.heights).min()
            for approach in (1e-4, 1e-3, 1e-2):
                centre_distance = np.array([apexes[0] - apexes[1], radii[0] + radii[1] - contact_gap - approach])
                overlap = sum(radii) - np.hypot(*centre_distance)
                radius = radii[0] * radii[1] / sum(radii)
                table = contacts(upper, lower, approach, effective_modulus=modulus)
                assert len(table) == 1
                assert_close(table.force, 4 / 3 * modulus * math.sqrt(radius) * overlap**1.5, CIRCLE_TOLERANCE)
                assert_close(table.area, math.pi * radius * overlap, CIRCLE_TOLERANCE)
                assert np.allclose(
                    table.normal[0, [0, 2]], centre_distance / np.hypot(*centre_distance), atol=CIRCLE_TOLERANCE
                )

    def test_contact_of_a_ball_in_a_cup_equals_hertz_solution(self, create_circular_arc):
        spacing, points = 0.002, 1000
        ball = create_circular_arc(1.0307, 2.0, spacing, points, "upper")
        cup = Profile(-create_circular_arc(0.9811, 5.0, spacing, points, "lower").heights, spacing=spacing)
        contact_gap = (ball.heights - cup.heights).min()
        centre_distance = np.array([1.0307 - 0.9811, 2.0 - 5.0 - contact_gap - 1e-3])
        overlap = np.hypot(*centre_distance) - 3.0
        radius = 1 / (1 / 2.0 - 1 / 5.0)
        table = contacts(ball, cup, 1e-3, curvature="signed")
        assert len(table) == 1
        assert_close(table.force, 4 / 3 * 10.0 * math.sqrt(radius) * overlap**1.5, CIRCLE_TOLERANCE)
        assert np.allclose(
            table.normal[0, [0, 2]], -centre_distance / np.hypot(*centre_distance), atol=CIRCLE_TOLERANCE
        )
        assert len(contacts(ball, cup, 1e-3, curvature="convex")) == 0

    def test_contact_area_vanishes_at_first_contact(self, create_circular_arc):
        upper = create_circular_arc(1.0307, 2.0, 0.002, 1000, "upper")
        lower = create_circular_arc(0.9411, 3.0, 0.002, 1000, "lower")
        curve = press(upper, lower, [0.0, 1e-3])
        # The arcs first touch between grid points, so contacts may overlap by the height difference within a cell.
        assert curve.contact_area[0] < 1e-3 * curve.contact_area[1]

    @pytest.mark.parametrize("detection", ["cell", "gap-minimum"])
    def test_crests_of_profiles_come_into_contact_in_order_of_height(self, detection):
        # A flat lies above waves on a slope of 1e-3. Each crest is 1e-3 wavelengths below its neighbour.
        x = np.arange(4000) * 0.001 + 0.3003
        lower = Profile(0.01 * np.cos(2 * np.pi * x) + 1e-3 * x, spacing=0.001)
        upper = Profile(np.zeros(4000), spacing=0.001)
        steps = np.array([0.2e-3, 0.9e-3, 1.1e-3, 1.9e-3, 2.1e-3])
        assert press(upper, lower, steps, detection=detection).contact_count.tolist() == [1, 1, 2, 2, 3]

    def test_friction_of_a_single_opposing_contact_equals_friction_of_a_wedge(self, create_circular_arc):
        upper = create_circular_arc(0.9411, 2.0, 0.002, 1000, "upper")
        lower = create_circular_arc(1.0307, 3.0, 0.002, 1000, "lower")
        mu0 = np.array([0.0, 0.1, 0.4, 1.0])
        table, curve = contacts(upper, lower, 1e-3), press(upper, lower, [1e-3])
        assert table.opposing.tolist() == [True]
        theta = math.atan2(-table.normal[0, 0], table.normal[0, 2])
        assert theta > 0.01
        coefficient = curve.friction_coefficient(mu0=mu0)[:, 0]
        assert_close(coefficient, np.tan(theta + np.arctan(mu0)), ROUND_OFF)
        tau0 = 0.2
        coefficient_with_adhesion = mu0 + tau0 * table.area[0] / table.force[0]
        coefficient = curve.friction_coefficient(mu0=mu0, tau0=tau0)[:, 0]
        assert_close(coefficient, np.tan(theta + np.arctan(coefficient_with_adhesion)), ROUND_OFF)
        pressure = table.force / table.area
        assert_close(coefficient, slope_friction(theta, mu0=mu0, tau0=tau0, mean_pressure=pressure), ROUND_OFF)
        assert press(upper, lower, [1e-3], shear="-x").friction_coefficient(mu0=0.4).tolist() == [0]

    @pytest.mark.parametrize("detection", ["cell", "gap-minimum"])
    @pytest.mark.parametrize("is_ball_below", [True, False])
    @pytest.mark.parametrize("slope", [0.0, 1e-3, 0.1, 0.3])
    def test_contact_of_a_ball_on_a_tilted_plane_equals_hertz_solution(
        self, create_circular_arc, slope, is_ball_below, detection
    ):
        radius, spacing, points = 12.0, 0.01, 2001
        ball = create_circular_arc(10.003, radius, spacing, points, "lower" if is_ball_below else "upper")
        plane = Profile(1.0 + slope * ball.x, spacing=spacing)
        upper, lower = (plane, ball) if is_ball_below else (ball, plane)
        contact_gap = (upper.heights - lower.heights).min()
        height = 1.0 + slope * 10.003 + (-contact_gap - 1e-3) * (1 if is_ball_below else 0)
        centre = -radius if is_ball_below else radius - contact_gap - 1e-3
        overlap = radius - abs(height - centre) / math.hypot(1, slope)
        table = contacts(upper, lower, 1e-3, detection=detection)
        assert len(table) == 1
        assert_close(table.force, 4 / 3 * 10.0 * math.sqrt(radius) * overlap**1.5, CIRCLE_TOLERANCE)
        assert np.allclose(table.normal[0], np.array([-slope, 0, 1]) / math.hypot(1, slope), atol=1e-12)

    @pytest.mark.parametrize("detection", ["cell", "gap-minimum"])
    def test_ball_on_a_slightly_curved_profile_carries_the_load_of_a_ball_on_a_flat(
        self, create_circular_arc, detection
    ):
        # The radius is 5e7 to 5e13 µm. A difference of such lengths would lose an overlap of 10 pm.
        ball = create_circular_arc(10.003, 12.0, 0.01, 2001, "lower")
        approaches = [1e-5, 1e-4, 1e-3]
        curve_on_flat = press(Profile(np.ones(2001), spacing=0.01), ball, approaches, detection=detection)
        assert curve_on_flat.contact_count.tolist() == [1, 1, 1]
        for bow in (1e-12, 1e-10, 1e-8, 1e-6):
            bowed_profile = Profile(1 + bow * ((ball.x - 10) / 10) ** 2, spacing=0.01)
            curve = press(bowed_profile, ball, approaches, detection=detection)
            assert curve.contact_count.tolist() == [1, 1, 1]
            assert_close(curve.normal_elastic, curve_on_flat.normal_elastic, 1e-9 + 0.3 * bow)

    def test_two_flats_have_no_contact(self):
        flat = Profile(np.zeros(20), spacing=0.1)
        curve = press(flat, flat, [0.0, 0.1])
        assert curve.contact_count.tolist() == [0, 0]
        assert curve.status(mu0=0.4).tolist() == ["no-contact", "no-contact"]
        assert np.isnan(curve.friction_coefficient(mu0=0.4)).all()

    def test_normal_and_tangential_loads_equal_reference_sums_over_contacts(self, create_rough_profiles):
        upper, lower = create_rough_profiles(1.45)
        rows = pressing.find_contacts(upper.heights, lower.heights, upper.spacing, 0.01)
        for shear, sigma in (("+x", 1), ("-x", -1)):
            curve = press(upper, lower, [0.01], shear=shear)
            for mu0, tau0 in ((0.0, 0.0), (0.4, 0.0), (0.3, 0.2), (1.0, 0.01)):
                normal, tangential = pressing.sum_loads(rows, sigma, mu0, tau0)
                assert_close(curve.normal_load(mu0=mu0, tau0=tau0), normal, REFERENCE_TOLERANCES["cell"])
                assert_close(curve.tangential_load(mu0=mu0, tau0=tau0), tangential, REFERENCE_TOLERANCES["cell"])

    def test_contact_on_a_steep_flank_is_self_locked_if_mu0_is_large(self):
        x = np.arange(400) * 0.01
        lower = Profile(-np.sqrt(3) * np.sqrt((x - 2.0013) ** 2 + 0.01), spacing=0.01)
        upper = Profile(np.sqrt(3) * np.sqrt((x - 1.6) ** 2 + 0.01), spacing=0.01)
        curve = press(upper, lower, [0.01])
        assert curve.contact_count[0] == 1
        assert curve.status(mu0=[0.1, 1.0])[:, 0].tolist() == ["ok", "self-locked"]
        assert np.isnan(curve.friction_coefficient(mu0=1.0)[0])


@st.composite
def random_profile_pairs(draw):
    """Generate pairs of rough profiles with a few hundred points, as sums of harmonics with random amplitudes."""
    points = draw(st.integers(60, 300))
    spacing = draw(st.floats(0.01, 0.1))
    x = np.arange(points) * spacing
    profiles = []
    for _ in range(2):
        heights = np.zeros(points)
        for n in range(1, 6):
            amplitude = draw(st.floats(0.001, 0.03)) / n
            phase = draw(st.floats(0, 6.28))
            heights += amplitude * np.sin(2 * np.pi * n * x / (13.1 * spacing) + phase)
        profiles.append(Profile(heights, spacing=spacing))
    return profiles


def is_insensitive_to_round_off(upper, lower, approach, choices):
    """Return whether round-off can change neither the number of contacts nor the set of opposing contacts."""
    table = contacts(upper, lower, approach, **choices)
    if choices["detection"] == "cell":
        offset = table.centre[:, 0] - table.index * upper.spacing
        near_edge = np.abs(np.abs(offset) - upper.spacing / 2) < 1e-7 * upper.spacing
    else:
        near_edge = table.overlap < 1e-7 * approach
    return len(table) > 0 and not (near_edge | (np.abs(table.normal[:, 0]) < 1e-7)).any()


CONTACT_LAWS_BY_NAME = {
    "hertz-sphere": HertzSphere(),
    "hertz-cylinder": HertzCylinder(width=0.7),
    "jackson-green": JacksonGreen(yield_strength=0.2, poisson_ratio=0.3),
}
MODEL_OPTION_STRATEGY = st.fixed_dictionaries(
    {
        "shear": st.sampled_from(["+x", "-x"]),
        "curvature": st.sampled_from(["convex", "signed"]),
        "detection": st.sampled_from(["cell", "gap-minimum"]),
    }
)
GIVEN_RANDOM_PAIRS = given(pair=random_profile_pairs(), approach=st.floats(1e-3, 0.05), choices=MODEL_OPTION_STRATEGY)
HYPOTHESIS_SETTINGS = settings(max_examples=25, derandomize=True)
OPPOSITE_DIRECTIONS = {"+x": "-x", "-x": "+x"}


def reverse_shear_options(choices):
    return choices | {"shear": OPPOSITE_DIRECTIONS[choices["shear"]]}


def mirrored_pair(pair):
    return [Profile(p.heights[::-1], spacing=p.spacing) for p in pair]


def exchanged_pair(pair):
    return [Profile(-p.heights, spacing=p.spacing) for p in reversed(pair)]


@pytest.mark.parametrize("law", CONTACT_LAWS_BY_NAME.values(), ids=CONTACT_LAWS_BY_NAME)
class TestProfileScalingAndSymmetry:
    @pytest.mark.parametrize(
        ("transform", "tolerance"), [(mirrored_pair, MIRROR_TOLERANCE), (exchanged_pair, EXCHANGE_TOLERANCE)]
    )
    @GIVEN_RANDOM_PAIRS
    @HYPOTHESIS_SETTINGS
    def test_load_curve_is_invariant_under_mirroring_and_exchange_of_bodies(
        self, law, pair, approach, choices, transform, tolerance
    ):
        assume(is_insensitive_to_round_off(*pair, approach, choices))
        sums_of_transformed_pair = stack_contact_sums(
            press(*transform(pair), [approach], law=law, **reverse_shear_options(choices))
        )
        assert_close(
            sums_of_transformed_pair, stack_contact_sums(press(*pair, [approach], law=law, **choices)), tolerance
        )

    @GIVEN_RANDOM_PAIRS
    @HYPOTHESIS_SETTINGS
    def test_load_curve_of_profiles_scales_with_their_size(self, law, pair, approach, choices):
        """Forces and areas of spheres scale with the square of the size; for cylinders they scale with the size."""
        assume(is_insensitive_to_round_off(*pair, approach, choices))
        size = 3.7
        scaled_pair = [Profile(size * p.heights, spacing=size * p.spacing) for p in pair]
        factor = size if isinstance(law, HertzCylinder) else size**2
        assert_close(
            stack_contact_sums(press(*scaled_pair, [size * approach], law=law, **choices)),
            np.array([1, *[factor] * 7])[:, None] * stack_contact_sums(press(*pair, [approach], law=law, **choices)),
            SCALING_TOLERANCE,
        )

    @GIVEN_RANDOM_PAIRS
    @HYPOTHESIS_SETTINGS
    def test_load_curve_of_profiles_scales_with_the_modulus(self, law, pair, approach, choices):
        """If all strengths scale with the modulus, so do forces, and friction depends only on tau0/E*."""
        soft_law, stiff_law = law, law
        if isinstance(law, JacksonGreen):
            stiff_law = JacksonGreen(yield_strength=3 * law.yield_strength, poisson_ratio=law.poisson_ratio)
        soft_curve = press(*pair, [approach], law=soft_law, effective_modulus=5.0, **choices)
        stiff_curve = press(*pair, [approach], law=stiff_law, effective_modulus=15.0, **choices)
        assert_close(stiff_curve.normal_elastic, 3 * soft_curve.normal_elastic, ROUND_OFF)
        assert_close(stiff_curve.tangential_frictional, 3 * soft_curve.tangential_frictional, ROUND_OFF)
        assert_close(stiff_curve.contact_area, soft_curve.contact_area, ROUND_OFF)
        coefficients = [
            c.friction_coefficient(mu0=0.3, tau0=0.01 * c.effective_modulus) for c in (stiff_curve, soft_curve)
        ]
        assert np.allclose(
            *coefficients, rtol=1e-10, atol=0, equal_nan=True
        )  # nearly self-locking contacts amplify errors of mu_s

    @GIVEN_RANDOM_PAIRS
    @HYPOTHESIS_SETTINGS
    def test_load_curve_of_profiles_equals_sums_over_the_table_of_contacts(self, law, pair, approach, choices):
        table = contacts(*pair, approach, law=law, **choices)
        curve = press(*pair, [approach / 2, approach], law=law, **choices)
        assert curve.contact_count[1] == len(table)
        assert curve.contact_area[1] == pytest.approx(table.area.sum(), rel=ROUND_OFF)
        load = table.force * table.normal[:, 2]
        assert curve.normal_elastic[1] == pytest.approx(load.sum(), rel=ROUND_OFF)
        opposing_force = table.force[table.opposing] @ table.tangent[table.opposing, 2]
        assert curve.normal_frictional[1] == pytest.approx(opposing_force, rel=ROUND_OFF)
        if len(table):
            relative_overlap = table.overlap / table.radius
            validity = curve.validity
            assert validity.relative_overlap[1] == pytest.approx(
                (load * relative_overlap).sum() / load.sum(), rel=ROUND_OFF
            )
            assert validity.share_beyond_hertz[1] == pytest.approx(
                load[relative_overlap > 0.1].sum() / load.sum(), rel=ROUND_OFF
            )
            is_smaller_than_spacing = table.radius < pair[0].spacing
            assert validity.share_below_grid[1] == pytest.approx(
                load[is_smaller_than_spacing].sum() / load.sum(), rel=ROUND_OFF
            )
            assert 0 <= validity.share_crossed[1] <= 1


class TestGapMinimumDetection:
    """Tests of results that depend on the grid with detection="cell", but not with detection="gap-minimum"."""

    POINT_COUNTS = (37_500, 75_000, 150_000, 300_000, 600_000)
    # First contact is defined by grid points, so an approach of 10 nm increases by at most g'' Δx² / 8.
    # Therefore three digits agree for each pair, and more digits for a sum over pairs.
    PAIR_TOLERANCE = 1e-3
    SUM_TOLERANCE = 2e-4

    @pytest.fixture(scope="class")
    @classmethod
    def curves_by_points(cls):
        """Return sums (quantity, approach) of several pairs by the number of points, for the first 8 frequencies."""
        result = {}
        for points in cls.POINT_COUNTS:
            result[points] = []
            for dimension in (1.0, 1.3, 1.6):
                for repetition in range(4):
                    upper, lower = (
                        weierstrass_mandelbrot(
                            random_phases(5, repetition=repetition, side=side, frequencies=8), dimension, points=points
                        ).with_amplitude(0.1)
                        for side in ("upper", "lower")
                    )
                    result[points].append(
                        stack_contact_sums(press(upper, lower, [0.01, 0.02, 0.04], detection="gap-minimum"))
                    )
            result[points] = np.array(result[points])
        return result

    def test_contact_area_and_loads_are_independent_of_the_grid(self, curves_by_points):
        finest_curve = curves_by_points[self.POINT_COUNTS[-1]]
        assert np.all(finest_curve[:, 0] >= 1)
        for points in self.POINT_COUNTS[:-1]:
            assert_close(curves_by_points[points][:, 1:], finest_curve[:, 1:], self.PAIR_TOLERANCE)
            assert_close(
                curves_by_points[points][:, 1:].sum(axis=0), finest_curve[:, 1:].sum(axis=0), self.SUM_TOLERANCE
            )

    def test_error_of_the_load_curve_decreases_with_the_square_of_the_grid_spacing(self, curves_by_points):
        # The position of first contact within a cell is random. Therefore mean errors over the pairs are compared.
        finest_curve, coarser_curve = curves_by_points[self.POINT_COUNTS[-1]], self.POINT_COUNTS[:-1]
        errors = [
            np.abs(curves_by_points[points][:, 1:3] / finest_curve[:, 1:3] - 1).mean() for points in coarser_curve
        ]
        convergence_order = -np.polyfit(np.log(coarser_curve), np.log(errors), 1)[0]
        assert 1.7 < convergence_order < 2.3

    def test_contact_areas_by_both_detection_methods_agree_on_fine_grids(self):
        differences = []
        for points, approach in ((150_000, 0.02), (600_000, 0.005), (2_400_000, 0.00125)):
            areas = []
            for repetition in range(6):
                upper, lower = (
                    weierstrass_mandelbrot(
                        random_phases(5, repetition=repetition, side=side, frequencies=6), 1.2, points=points // 10,
                        extent=4.0,
                    ).with_amplitude(0.1)
                    for side in ("upper", "lower")
                )  # fmt: skip
                curves_by_detection = [
                    press(upper, lower, [approach], detection=detection) for detection in ("cell", "gap-minimum")
                ]
                areas.append(
                    [float(curves_by_detection[0].contact_area[0]), float(curves_by_detection[1].contact_area[0])]
                )
            area_by_cells, area_by_minima = np.array(areas).sum(axis=0)
            differences.append(abs(area_by_cells / area_by_minima - 1))
        assert differences[-1] < 0.01
        assert differences[-1] < differences[0]


class TestProfileContactArguments:
    def test_array_axes_of_mu0_and_tau0_precede_the_array_axis_of_approaches(self, create_rough_profiles):
        curve = press(*create_rough_profiles(1.2), [0.005, 0.01, 0.02])
        assert curve.normal_load(mu0=0.1).shape == (3,)
        assert curve.normal_load(mu0=[0.1, 0.2], tau0=0.1).shape == (2, 3)
        assert curve.friction_coefficient(mu0=np.ones((2, 1)) * 0.1, tau0=[0, 0.1, 0.2, 0.3]).shape == (2, 4, 3)
        assert curve.status(mu0=[0.1, 0.2]).shape == (2, 3)

    def test_normal_load_method_warns_if_tau0_seems_to_be_in_mpa(self, create_rough_profiles):
        curve = press(*create_rough_profiles(1.2), [0.01])
        with pytest.warns(UserWarning, match="meant in MPa"):
            curve.normal_load(mu0=0.4, tau0=200)

    @pytest.mark.parametrize(
        ("effective_modulus", "tau0", "words"),
        [
            (1.5e-3, 0.3e-3, None),
            (1.5e-3, 1.4e-3, None),
            (1.5e-3, 0.3, "tau0 = 300 MPa is above the effective modulus 1.5 MPa; was it meant in kPa?"),
            (100.0, 9.0, None),
            (100.0, 20.0, "tau0 = 20 GPa is above a tenth of the effective modulus 100 GPa; was it meant in MPa?"),
        ],
    )
    def test_warning_about_a_large_tau0_depends_on_the_modulus_and_suggests_the_unit_that_was_meant(
        self, effective_modulus, tau0, words
    ):
        with warnings.catch_warnings(record=True) as caught_warnings:
            warnings.simplefilter("always")
            gentle_friction(0.1, rms_gradient=0.1, tau0=tau0, effective_modulus=effective_modulus)
        assert [str(warning.message) for warning in caught_warnings] == ([words] if words else [])

    @pytest.mark.parametrize(
        "invalid_arguments", [{"mu0": -0.1}, {"mu0": math.nan}, {"mu0": "x"}, {"mu0": 0.1, "tau0": -1}]
    )
    def test_friction_coefficient_rejects_invalid_parameters(self, create_rough_profiles, invalid_arguments):
        curve = press(*create_rough_profiles(1.2), [0.01])
        with pytest.raises(ValueError, match=list(invalid_arguments)[-1]):
            curve.friction_coefficient(**invalid_arguments)

    @pytest.mark.parametrize("call", [contacts, lambda upper, lower, at, **k: press(upper, lower, [at], **k)])
    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"approach": -0.001}, r"approach must be at least 0 and finite, got -0.001"),
            ({"approach": math.nan}, "approach"),
            ({"effective_modulus": 0}, "effective_modulus"),
            ({"effective_modulus": math.inf}, "effective_modulus"),
            ({"law": "jkr"}, "law must be one of"),
            ({"detection": "best"}, "detection must be one of"),
            ({"curvature": "any"}, "curvature must be one of 'convex', 'signed', got 'any'"),
            ({"shear": "+y"}, "shear must be one of"),
        ],
    )
    def test_press_function_and_contacts_function_reject_invalid_arguments(
        self, create_rough_profiles, call, change, message
    ):
        upper, lower = create_rough_profiles(1.2)
        arguments = {"approach": 0.01} | change
        with pytest.raises(ValueError, match=message):
            call(upper, lower, arguments.pop("approach"), **arguments)

    def test_press_function_rejects_profiles_on_different_grids(self, create_rough_profiles):
        upper, lower = create_rough_profiles(1.2)
        with pytest.raises(ValueError, match="equal numbers of points"):
            press(Profile(upper.heights[:-1], spacing=upper.spacing), lower, [0.01])
        with pytest.raises(ValueError, match="equal spacings"):
            press(Profile(upper.heights, spacing=1.01 * upper.spacing), lower, [0.01])

    @pytest.mark.parametrize(
        ("approaches", "message"),
        [
            ([0.2, 0.1], "increase"),
            ([0.1, 0.1], "increase"),
            ([], "empty"),
            (0.1, "1 dimension"),
            ([0.1, np.nan], "finite"),
        ],
    )
    def test_press_function_rejects_invalid_approaches(self, create_rough_profiles, approaches, message):
        with pytest.raises(ValueError, match=message):
            press(*create_rough_profiles(1.2), approaches)

    def test_arrays_of_results_are_read_only(self, create_rough_profiles):
        curve = press(*create_rough_profiles(1.2), [0.01])
        table = contacts(*create_rough_profiles(1.2), 0.01)
        arrays = [
            value for result in (curve, table) for value in vars(result).values() if isinstance(value, np.ndarray)
        ]
        assert not any(array.flags.writeable for array in arrays)


def test_press_function_releases_the_interpreter_lock(create_rough_profiles):
    upper, lower = create_rough_profiles(1.5)
    approaches = np.linspace(1e-4, 0.04, 20)
    assert releases_interpreter_lock(lambda: press(upper, lower, approaches))
