"""Tests of the closed form for the area of yielding contacts against elastic-plastic height maps."""

import importlib
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("tamaas")
pytestmark = pytest.mark.docs
SCRIPTS_DIRECTORY = Path(__file__).parents[1] / "docs/scripts"

# Mean pressure (over Young's modulus), A/A0 and elastic A/A0 on the same grid, by tamaas, of cases in
# docs/scripts/yielding_exponent.py.
TAMAAS_AREA_FRACTIONS = {
    "map 1": [
        (0.001346, 0.08069, 0.04881),
        (0.002711, 0.1656, 0.09665),
        (0.004112, 0.2476, 0.1434),
        (0.005826, 0.3365, 0.2004),
    ],
    "map 2": [
        (0.0008283, 0.07994, 0.0464),
        (0.001692, 0.1672, 0.08947),
        (0.002511, 0.2296, 0.1347),
        (0.003627, 0.309, 0.1871),
    ],
    "map 3": [
        (0.001675, 0.09102, 0.04416),
        (0.003179, 0.1656, 0.09619),
        (0.004757, 0.2617, 0.1508),
        (0.006646, 0.3587, 0.2272),
    ],
    "map 4": [
        (0.0009277, 0.08269, 0.06162),
        (0.001896, 0.1644, 0.1246),
        (0.002929, 0.2412, 0.178),
        (0.004327, 0.3257, 0.2356),
    ],
}


@pytest.fixture(scope="module")
def script():
    if not SCRIPTS_DIRECTORY.exists():
        pytest.skip("the directory docs is not in this tree")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(SCRIPTS_DIRECTORY)
        yield importlib.import_module("yielding_exponent")


@pytest.fixture(scope="module")
def areas_by_map(script):
    """Areas of each stored map, true and with the pressure cap."""
    return {
        name: script.find_map_areas(
            script.CASES[name], dict(zip(("pressure", "area", "elastic_area"), zip(*rows, strict=True), strict=True))
        )
        for name, rows in TAMAAS_AREA_FRACTIONS.items()
    }


def test_limiting_pressures_to_the_hardness_underestimates_the_contact_area_of_yielding_maps(areas_by_map):
    ratios = np.concatenate([case.capped / case.true for case in areas_by_map.values()])
    assert ratios.max() < 0.92
    assert 0.75 < ratios.mean() < 0.85


def test_yield_onset_formula_for_contact_area_agrees_with_elastic_plastic_solutions(script, areas_by_map):
    deviations = np.concatenate(
        [case.deviations(script.combine_areas_from_onset, 1.25) for case in areas_by_map.values()]
    )
    assert np.abs(deviations).mean() < 0.06
    assert abs(deviations.mean()) < 0.04


def test_fitted_yield_exponents_of_maps_are_close_to_1(areas_by_map):
    exponents = np.array([case.fit_exponent() for case in areas_by_map.values()])
    assert 0.9 < exponents.mean() < 1.3
    assert exponents.min() > 0.6
    assert exponents.max() < 1.6


def test_elastic_areas_computed_by_the_tamaas_library_agree_with_the_half_space_model(areas_by_map):
    for name, rows in TAMAAS_AREA_FRACTIONS.items():
        np.testing.assert_allclose(np.array(rows)[:, 2], areas_by_map[name].elastic, rtol=0.07)


def test_area_of_an_elastic_plastic_solution_on_a_coarse_grid_exceeds_the_area_with_the_pressure_cap(script):
    case = script.RoughMap(4, (1, 1.5), 1.5, area_fractions=(0.2,), num_points=16, num_layers=6)
    areas = script.find_map_areas(case, script.run_case(case))
    assert areas.pressure_ratio[0] > 0.7
    assert areas.capped[0] < 0.92 * areas.true[0]
