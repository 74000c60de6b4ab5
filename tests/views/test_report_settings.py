"""Tests of numbers in reports, compared in a browser with `Result.at` at random settings of six kinds of results."""

import numpy as np
import pytest
from stiction import Result, Study, pair, run, self_affine_surface
from stiction.views.report import save_report
from support import browser

pytest.importorskip("selenium", reason="selenium is not installed")
pytestmark = browser.BROWSER_MARKS

NUM_FRICTION_PARAMETER_PAIRS = 10
NUM_SETTINGS = 50
MAX_PACKING_ERROR = 1e-6
HALF_PLANE_STUDY_OVERRIDES = {
    "contact.mechanics": "half-space", "contact.load": {"start": "10 uN", "stop": "1 mN", "count": 5},
    "contact.sliding": ["opposing", "all"], "surfaces.points": 512, "surfaces.extent": "5 um",
    "ensemble.repetitions": 4, "surfaces.band_limit": "nyquist", "surfaces.fractal_dimension": [1.1, 1.4],
}  # fmt: skip
SURFACE_STUDY_CHANGES = {
    "ensemble.repetitions": 6, "surfaces.kind": "surface", "surfaces.shape": [24, 24], "contact.direction": [0, 90],
    "surfaces.extent": ["1.5 um", "1.5 um"], "surfaces.band_limit": "nyquist", "contact.approach.count": 8,
    "surfaces.fractal_dimension": [1.2, 1.5], "surfaces.amplitude": ["50 nm"],
}  # fmt: skip
READ_POINT_SCRIPT = """
const [mu0, tau0, rule, cell, load, way] = arguments;
const at = frictionAt(facts.rules[rule], cell, load, placeAt(parameters, mu0, tau0), way);
return [at.status, at.value, at.lower, at.upper];
"""


def compute_pair_with_junction_growth(directory):
    """Return the result of a pair whose contacts yield and grow, with uncertain inputs."""
    upper, lower = (
        self_affine_surface(3, hurst_exponent=0.8, rms=0.03, shape=(48, 48), spacing=0.1, side=side)
        for side in ("upper", "lower")
    )
    return pair(
        upper, lower, load="20 MPa", mu0="0.2 ± 0.02", tau0="30 MPa", effective_modulus="80 GPa", hardness="1..2 GPa",
        junction_growth="0..27", shifts=4, cutoff="none", onset=0, directory=directory / "growth",
    )  # fmt: skip


@pytest.fixture(scope="module", params=["profiles", "half-planes", "surfaces", "maps", "lines", "growing contacts"])
def result_and_driver(request, driver, tmp_path_factory):
    """Return a result, and a browser in which the report of the result is open."""
    directory = tmp_path_factory.mktemp("settings")
    result_factories = {
        "profiles": lambda: Result(request.getfixturevalue("generated_dataset")),
        "half-planes": lambda: run(Study.named("quick").with_changes(HALF_PLANE_STUDY_OVERRIDES)),
        "surfaces": lambda: run(Study().with_changes(SURFACE_STUDY_CHANGES)),
        "maps": lambda: Result(request.getfixturevalue("maps_dataset")),
        "lines": lambda: Result(request.getfixturevalue("profiles_dataset")),
        "growing contacts": lambda: compute_pair_with_junction_growth(directory),
    }
    result = result_factories[request.param]()
    save_report(result, directory / "report.html")
    browser.open_page(driver, directory / "report.html")
    return result, driver


def compute_expected_point(table, facts, rule, cell, load, way):
    """Return the status, the value and the interval limits that the library computes at a setting of the controls."""
    indices_by_dim = {"load": load, "mu0": 0, "tau0": 0, "sliding": rule}
    indices_by_dim |= {"cut_off": cell} if facts["isMeasured"] else {"fractal_dimension": cell, "amplitude": 0}
    direction_choice = facts["ways"][way]
    name = "friction_combined" if facts["isMeasured"] and direction_choice["isWhole"] else "friction_coefficient"
    indices_by_dim |= {"direction": direction_choice["directions"][0]}
    point = table[name].isel({dim: index for dim, index in indices_by_dim.items() if dim in table[name].dims})
    return [float(point.sel(statistic=statistic)) for statistic in ("mean", "lower", "upper")]


def test_numbers_in_a_report_agree_with_the_library_at_random_settings(result_and_driver):
    result, driver = result_and_driver
    facts, parameters, loads = driver.execute_script("return [facts, parameters, loads]")
    random, num_values = np.random.default_rng(7), 0
    for _ in range(NUM_FRICTION_PARAMETER_PAIRS):
        mu0, tau0 = (float(random.choice(parameters[name]["values"])) for name in ("mu0", "tau0"))
        table = result.at(loads, mu0=[mu0], tau0=[float(f"{tau0 / 1000:.12g}")])
        for _ in range(NUM_SETTINGS // NUM_FRICTION_PARAMETER_PAIRS):
            sizes = [len(facts["rules"]), len(facts["cells"]["values"]), len(loads), len(facts["ways"])]
            setting_indices = [int(random.integers(size)) for size in sizes]
            status, *numbers = driver.execute_script(READ_POINT_SCRIPT, mu0, tau0, *setting_indices)
            expected = compute_expected_point(table, facts, *setting_indices)
            assert (status == "ok") == np.isfinite(expected[0])
            if status != "ok":
                continue
            # The WebDriver returns NaN and infinity as None.
            displayed_numbers = np.array([np.nan if number is None else number for number in numbers])
            expected = [number if np.isfinite(number) else np.nan for number in expected]
            np.testing.assert_allclose(displayed_numbers, expected, rtol=MAX_PACKING_ERROR, atol=1e-12)
            num_values += 1
    assert num_values > NUM_SETTINGS / 4
