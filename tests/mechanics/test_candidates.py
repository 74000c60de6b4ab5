import dataclasses
import pickle
import signal
import time

import numpy as np
import pytest
import stiction._core
from scipy.interpolate import CubicSpline
from stiction import (
    Candidates,
    ContactModel,
    JacksonGreen,
    Profile,
    Surface,
    candidates,
    contacts,
    press,
    random_phases,
    weierstrass_mandelbrot,
    weierstrass_mandelbrot_surface,
)
from stiction.mechanics.friction import STATUS_DTYPE, ContactSums, choose_statuses
from stiction.mechanics.law import CONTACT_LAWS, CONTACT_LAWS_BY_NAME, LawName
from stiction.mechanics.model import ContactModelArguments
from stiction.mechanics.quantities import QUANTITIES, SUM_QUANTITIES

# Relative difference between results that use different spline solvers for the same heights.
SPLINE_TOLERANCE = 1e-9
# Processor time (s), on which other processes have no effect.
SIGNAL_DELAY = 0.2
MAX_DELAY_AFTER_SIGNAL = 1.0


@pytest.fixture(scope="module")
def rough_profiles():
    return tuple(
        weierstrass_mandelbrot(random_phases(4, side=side), 1.3, points=20_000, extent=8.0).with_amplitude(0.1)
        for side in ("upper", "lower")
    )


class TestContactCandidates:
    @pytest.mark.parametrize("curvature", ["convex", "signed"])
    def test_pressing_candidates_gives_the_same_loads_as_pressing_the_surfaces(self, rough_profiles, curvature):
        contact_candidates = candidates(*rough_profiles, deepest=0.03, curvature=curvature)
        steps = [0.0, 0.001, 0.02]
        curve_of_candidates = press(contact_candidates, steps, shear="-x")
        curve_of_surfaces = press(*rough_profiles, steps, shear="-x", detection="gap-minimum", curvature=curvature)
        for name in SUM_QUANTITIES:
            assert np.array_equal(getattr(curve_of_candidates, name), getattr(curve_of_surfaces, name)), name
        table = contacts(contact_candidates, 0.02)
        assert set(table.index) <= set(contact_candidates.index)
        assert np.array_equal(
            table.force,
            contacts(*rough_profiles, 0.02, model=ContactModel(detection="gap-minimum", curvature=curvature)).force,
        )

    def test_candidates_lie_at_minima_of_the_gap(self, rough_profiles):
        upper, lower = rough_profiles
        contact_candidates = candidates(upper, lower, deepest=0.03)
        assert isinstance(contact_candidates, Candidates)
        assert (contact_candidates.gap <= 0.03).all()
        assert (contact_candidates.position[:, 1] == 0).all()
        assert (
            np.abs(contact_candidates.position[:, 0] - lower.x[contact_candidates.index] - lower.spacing / 2)
            <= lower.spacing / 2
        ).all()
        grid = upper.heights - lower.heights
        spline = CubicSpline(lower.x, grid, bc_type="natural")
        x = contact_candidates.position[:, 0]
        assert np.abs(spline(x) - grid.min() - contact_candidates.gap).max() < SPLINE_TOLERANCE * np.ptp(grid)
        assert np.abs(spline(x, 1)).max() < SPLINE_TOLERANCE * np.abs(spline(lower.x, 1)).max()
        assert (spline(x, 2) > 0).all()
        assert (contact_candidates.radii[:, 0] == contact_candidates.radii[:, 1]).all()
        assert not contact_candidates.gap.flags.writeable

    def test_press_function_rejects_options_that_differ_from_those_of_the_candidate_search(self, rough_profiles):
        contact_candidates = candidates(*rough_profiles, deepest=0.03)
        with pytest.raises(
            ValueError, match=r"approach must be at most 0.03 µm, the limit of the candidates, got 0.04 µm"
        ):
            press(contact_candidates, [0.04])
        with pytest.raises(
            ValueError, match=r"^detection must be 'gap-minimum', as in the search for the candidates, got 'cell'"
        ):
            press(contact_candidates, [0.01], detection="cell")
        with pytest.raises(
            ValueError, match=r"^curvature must be 'convex', as in the search for the candidates, got 'signed'"
        ):
            contacts(contact_candidates, 0.01, curvature="signed")
        with pytest.raises(ValueError, match="deepest"):
            candidates(*rough_profiles, deepest="deep")
        with pytest.raises(ValueError, match="lower must not be given together with candidates"):
            press(contact_candidates, rough_profiles[1], [0.01])
        with pytest.raises(ValueError, match="must have equal spacings"):
            candidates(rough_profiles[0], Profile(rough_profiles[1].heights, spacing=1.0), deepest=0.1)


class TestContactModel:
    def test_press_arguments_override_fields_of_the_contact_model(self, rough_profiles):
        assert set(ContactModelArguments.__annotations__) == {"model"} | {
            field.name for field in dataclasses.fields(ContactModel)
        }
        model = ContactModel(effective_modulus=20.0, detection="gap-minimum")
        curve_of_model = press(*rough_profiles, [0.01], model=model, shear="-x")
        curve_of_keywords = press(*rough_profiles, [0.01], effective_modulus=20.0, detection="gap-minimum", shear="-x")
        assert curve_of_model.effective_modulus == 20.0
        assert np.array_equal(curve_of_model.tangential_elastic, curve_of_keywords.tangential_elastic)

    def test_pickled_contact_model_gives_the_results_of_the_original(self, rough_profiles):
        model = ContactModel(law=JacksonGreen(yield_strength=0.5, poisson_ratio=0.3), shear="-x")
        curve = press(*rough_profiles, [0.01], model=model)
        unpickled_model = pickle.loads(pickle.dumps(model))
        assert unpickled_model == model
        assert hash(unpickled_model) == hash(model)
        assert press(*rough_profiles, [0.01], model=unpickled_model).contact_area == curve.contact_area
        assert (
            press(*rough_profiles, [0.01], model=dataclasses.replace(unpickled_model, shear="+x")).contact_area
            == curve.contact_area
        )

    def test_contact_model_rejects_invalid_fields(self, rough_profiles):
        with pytest.raises(ValueError, match="direction must have at least one element"):
            ContactModel(direction=[])
        with pytest.raises(ValueError, match="effective_modulus must be"):
            ContactModel(effective_modulus=True)
        with pytest.raises(ValueError, match="model must be a ContactModel, got dict"):
            press(*rough_profiles, [0.01], model={})
        with pytest.raises(ValueError, match="detection must be one of 'cell', 'gap-minimum', got 'both'"):
            ContactModel(detection="both")
        with pytest.raises(TypeError, match="'modulus'"):
            press(*rough_profiles, [0.01], modulus=3.0)


def test_names_of_contact_sums_equal_those_of_the_core_and_names_of_contact_laws_are_unique():
    assert tuple(field.name for field in dataclasses.fields(ContactSums)) == SUM_QUANTITIES
    assert {*SUM_QUANTITIES} <= {*QUANTITIES}
    assert tuple(CONTACT_LAWS_BY_NAME) == LawName.__args__
    assert len({law.name for law in CONTACT_LAWS}) == len(CONTACT_LAWS)
    for law in CONTACT_LAWS:
        with pytest.raises(ValueError, match=f"law {law.name} requires the parameter effective_modulus"):
            stiction._core.force_and_area(law.name, {}, overlap=0.1, radius=1.0)


def test_status_of_a_coefficient_names_the_first_condition_that_is_not_met():
    arguments = [
        (False, False, False, False), (True, True, False, False), (True, False, True, False),
        (True, False, False, True), (True, False, False, False),
    ]  # fmt: skip
    has_touched, is_reached, is_below_range, self_locked = np.array(arguments).T
    status = choose_statuses(touched=has_touched, reached=is_reached, below=is_below_range, locked=self_locked)
    assert status.tolist() == ["no-contact", "ok", "below-range", "self-locked", "not-reached"]
    assert status.dtype == STATUS_DTYPE


def create_noise_bodies(body, shape):
    return [body(np.random.default_rng(seed).random(shape), spacing=1.0) for seed in (1, 2)]


@pytest.mark.parametrize(
    "call",
    [
        lambda: press(
            *create_noise_bodies(Profile, 1_000_000),
            np.linspace(0.5, 1.5, 800),
            detection="gap-minimum",
            curvature="signed",
        ),
        lambda: press(
            *create_noise_bodies(Surface, (1024, 1024)),
            np.linspace(0.01, 1.5, 800),
            direction=range(0, 360, 2),
            sliding="all",
        ),
        lambda: weierstrass_mandelbrot(random_phases(1, directions=2000), 1.5, points=2_000_000),
        lambda: weierstrass_mandelbrot_surface(random_phases(1, directions=2000), 1.5, shape=(2000, 2000)),
    ],
    ids=["press", "press areas", "profile", "surface"],
)
def test_press_function_stops_on_ctrl_c_during_a_long_computation(call):
    previous_handler, start = signal.signal(signal.SIGPROF, signal.default_int_handler), time.process_time()
    try:
        with pytest.raises(KeyboardInterrupt):  # noqa: PT012, the signal arrives after an unknown time
            signal.setitimer(signal.ITIMER_PROF, SIGNAL_DELAY)
            call()
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, previous_handler)
    assert time.process_time() - start < SIGNAL_DELAY + MAX_DELAY_AFTER_SIGNAL
