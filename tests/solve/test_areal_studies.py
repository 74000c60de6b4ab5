"""Test studies of generated surfaces, and of profiles in contact as elastic half-spaces."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from stiction import (
    Study,
    Surface,
    area_map,
    friction_map,
    nondimensional,
    pair_of,
    press,
    random_phases,
    run,
    self_affine_surface,
    stiffness_map,
    weierstrass_mandelbrot_surface,
)
from stiction.mechanics.half_space import half_space
from stiction.mechanics.quantities import DIRECTED_SUM_QUANTITIES
from stiction.solve import store
from stiction.views.figures.standard import draw_figures, select_figures
from stiction.views.report import report_page

ENSEMBLE_STUDY_CHANGES = {
    "surfaces.fractal_dimension": [1.2, 1.5],
    "surfaces.amplitude": ["50 nm", "100 nm"],
    "ensemble.repetitions": 3,
    "friction.mu0": [0.4],
    "friction.tau0": ["0 MPa", "200 MPa"],
    "contact.sliding": ["opposing", "all"],
}
FRACTAL_STUDY = Study().with_changes(
    ENSEMBLE_STUDY_CHANGES
    | {
        "surfaces.kind": "surface",
        "surfaces.shape": [24, 32],
        "surfaces.extent": ["1.5 um", "2 um"],
        "surfaces.band_limit": "nyquist",
        "contact.direction": ["+x", 90],
        "contact.approach.count": 5,
    }
)
SELF_AFFINE_STUDY = FRACTAL_STUDY.with_changes(
    {
        "surfaces.generator": "self-affine",
        "surfaces.shortest_wavelength": "0.25 um",
        "surfaces.amplitude_measure": "Sq",
        "surfaces.amplitude": ["10 nm", "20 nm"],
    }
)
HALF_SPACE_STUDY = FRACTAL_STUDY.with_changes(
    {
        "contact.mechanics": "half-space",
        "contact.boundary": "periodic",
        "contact.hardness": "1 GPa",
        "contact.compliance_share": 0.3,
        "contact.load": {"start": "0.001 mN", "stop": "0.1 mN", "count": 4},
    }
)
HALF_PLANE_STUDY = Study().with_changes(
    ENSEMBLE_STUDY_CHANGES
    | {
        "surfaces.points": 512,
        "surfaces.extent": "2 um",
        "contact.mechanics": "half-space",
        "contact.load": ["1 uN", "10 uN", "0.1 mN"],
    }
)
STUDIES = {
    "surfaces": FRACTAL_STUDY,
    "self-affine": SELF_AFFINE_STUDY,
    "half-spaces": HALF_SPACE_STUDY,
    "half-planes": HALF_PLANE_STUDY,
}


@pytest.fixture(scope="module", params=STUDIES)
def result(request):
    return run(STUDIES[request.param]).dataset


def compute_curves(study, upper, lower):
    """Compute the load curve under each sliding rule by direct calls of `press` or `half_space`."""
    contact = study.contact
    for rule in contact.sliding_rules():
        if contact.mechanics == "asperities":
            yield press(upper, lower, contact.loading_steps(), direction=contact.direction, sliding=rule)
        else:
            yield half_space(
                upper, lower, contact.loading_steps(), boundary=contact.boundary,
                hardness=contact.hardness and float(contact.hardness), compliance_share=contact.compliance_share,
                direction=contact.direction or "+x", sliding=rule,
            )  # fmt: skip


@pytest.mark.parametrize("name", STUDIES)
def test_figures_and_report_are_drawn_for_every_contact_model(name, tmp_path):
    """Half-space results lack the quantities of asperities that figures use for the limits of the asperity model."""
    study = STUDIES[name]
    direction = {"contact.direction": "+x"} if study.contact.direction else {}
    changes = {"surfaces.amplitude": study.surfaces.amplitude[:1], "contact.sliding": "opposing"}
    result = run(study.with_changes(changes | direction))
    names = {path.stem for path in draw_figures(result, tmp_path)}
    assert {name.split("_")[0] for name in names} >= {"friction", "area"}
    assert report_page(result).startswith("<!doctype html>")


@pytest.mark.parametrize("name", STUDIES)
def test_results_of_a_study_of_maps_equal_load_curves_of_single_pairs(name):
    study = STUDIES[name]
    dataset = run(study).dataset
    step_quantity = study.contact.step_quantity
    for d, a, r in ((0, 1, 0), (1, 0, 2)):
        pair = pair_of(
            study, r, fractal_dimension=dataset["fractal_dimension"].values[d],
            amplitude=dataset["amplitude"].values[a],
        )  # fmt: skip
        member = dataset.isel(fractal_dimension=d, amplitude=a, repetition=r)
        for rule, curve in zip(study.contact.sliding_rules(), compute_curves(study, *pair), strict=True):
            for quantity in study.contact_sum_names():
                is_directed = quantity in DIRECTED_SUM_QUANTITIES
                computed_sum = member[quantity].sel(sliding=rule) if is_directed else member[quantity]
                assert computed_sum.dims == (
                    ("direction", step_quantity) if is_directed and "direction" in dataset.dims else (step_quantity,)
                )
                assert computed_sum.values.tobytes() == getattr(curve, quantity).tobytes(), quantity
    assert (dataset["normal_elastic"].values.max(axis=-1) > 0).all()


def test_surfaces_of_the_nth_pair_of_a_study_equal_directly_generated_surfaces():
    for body, side in zip(
        pair_of(FRACTAL_STUDY, 7, fractal_dimension=1.3, amplitude=0.1), ("upper", "lower"), strict=True
    ):
        generated_surface = weierstrass_mandelbrot_surface(
            random_phases(2016, repetition=7, side=side), 1.3, shape=(24, 32), extent=(1.5, 2.0), band_limit="nyquist"
        ).with_amplitude(0.1)
        assert isinstance(body, Surface)
        assert (body.heights.tobytes(), body.spacing) == (generated_surface.heights.tobytes(), (0.0625, 0.0625))
    _, lower = pair_of(SELF_AFFINE_STUDY, 7, fractal_dimension=1.3, amplitude=0.02)
    generated_surface = self_affine_surface(
        2016, repetition=7, hurst_exponent=2 - 1.3, rms=1.0, shape=(24, 32), spacing=0.0625, shortest_wavelength=0.25
    ).with_amplitude(0.02, "Sq")
    assert lower.heights.tobytes() == generated_surface.heights.tobytes()


@pytest.mark.parametrize("name", STUDIES)
def test_stored_result_of_a_study_of_maps_can_be_read_and_continued(name, tmp_path):
    study = STUDIES[name]
    expected = run(study).dataset
    with ThreadPoolExecutor(2) as pool:
        run(study.with_changes({"ensemble.repetitions": 1}), store=tmp_path / "r", executor=pool)
        continued_dataset = run(study, store=tmp_path / "r", executor=pool).dataset
    assert continued_dataset.identical(expected)
    assert store.read(tmp_path / "r").identical(expected)
    changed_study = study.with_changes({"contact.sliding": "all"})
    with pytest.raises(store.StoreError, match=r"contact\.sliding = "):
        run(changed_study, store=tmp_path / "r")


def test_friction_map_for_both_sliding_rules_contains_the_maps_for_each_rule(result):
    mean_loads = result["normal_elastic"].mean("repetition")
    load = float(mean_loads.isel({mean_loads.dims[-1]: -2}).min())
    maps = friction_map(result, [load])
    assert maps.sizes["sliding"] == 2
    for rule in ("opposing", "all"):
        result_of_rule = result.sel(sliding=rule)
        assert friction_map(result_of_rule, [load]).equals(maps.sel(sliding=rule))
    assert (maps["status"] == "ok").any()
    assert area_map(result, [load])["contact_area"].dims == maps["friction_coefficient"].dims
    nondimensional_coefficient = nondimensional(maps)["friction_coefficient"]
    assert np.array_equal(nondimensional_coefficient.values, maps["friction_coefficient"].values, equal_nan=True)


def test_friction_map_of_a_half_space_study_equals_the_ratio_of_mean_loads():
    """Compare with the ratio at solved loads; mu0 = tau0 = 0, so that friction does not change the normal load."""
    dataset = run(HALF_SPACE_STUDY).dataset
    loads = HALF_SPACE_STUDY.contact.loading_steps()
    maps = friction_map(dataset, loads[1:-1], mu0=[0.0], tau0=[0.0]).squeeze(["mu0", "tau0"])
    expected = dataset["tangential_elastic"].mean("repetition") / dataset["normal_elastic"].mean("repetition")
    slides_downhill = (expected < 0).values[..., 1:-1]
    assert slides_downhill.any()
    assert not slides_downhill.all()
    statuses = maps["status"].transpose(*expected.dims).values
    assert set(statuses[slides_downhill]) == {"downhill"}
    expected = expected.where(expected >= 0)  # a direction in which the slider slides by itself has no coefficient
    # The last solved load is left out: round-off may put a requested load above it.
    assert np.allclose(
        maps["friction_coefficient"].transpose(*expected.dims).values,
        expected.values[..., 1:-1],
        rtol=1e-6,
        atol=1e-9,
        equal_nan=True,
    )


def test_stiffness_map_of_a_half_space_study_equals_the_slope_of_the_load_approach_curve():
    dataset = run(HALF_SPACE_STUDY.with_changes({"contact.sliding": "all", "contact.direction": 90})).dataset
    loads = HALF_SPACE_STUDY.contact.loading_steps()
    stiffness = stiffness_map(dataset, [loads[1]], mu0=[0.0], tau0=[0.0])["normal_stiffness"].squeeze()
    slopes = np.gradient(dataset["approach"].values, loads, axis=-1, edge_order=2)[..., 1]
    assert np.allclose(stiffness.values, (1 / slopes).mean(axis=-1), rtol=1e-6)
    with pytest.raises(ValueError, match="a free half-plane has an infinite approach"):
        stiffness_map(run(HALF_PLANE_STUDY), [0.01])


def test_standard_figures_exist_for_every_sliding_rule_and_direction():
    names = {f"{kind}_{rule}_{angle}" for kind in ("friction_mu0_0.4", "area")
             for rule in ("opposing", "all") for angle in (0, 90)}  # fmt: skip
    assert {name for name, _ in select_figures(run(FRACTAL_STUDY))} == names
