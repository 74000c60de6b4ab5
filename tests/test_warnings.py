"""Test that warnings refer to the line of the user's program, however deep in the package they are issued."""

import numpy as np
import pytest
from stiction import (
    FormatWarning,
    FrictionTest,
    calibrate,
    friction_map,
    friction_table,
    half_space,
    pair,
    press,
    read_profile,
    run,
    self_affine_surface,
    table_study,
)

pytestmark = pytest.mark.usefixtures("no_companion_files")


def create_maps():
    return [
        self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(32, 32), spacing=0.1, side=side)
        for side in ("upper", "lower")
    ]


def warn_about_tau0_of_curve(directory):
    press(*create_maps(), [0.01]).normal_load(mu0=0.2, tau0=200.0)


def warn_about_tau0_of_result(directory):
    result = pair(*create_maps(), load="10 MPa", effective_modulus="80 GPa", mu0=0.2, shifts=2, onset=0)
    result.summary("10 MPa", mu0=0.2, tau0="20 GPa")


def warn_about_a_file(directory):
    (directory / "profile.txt").write_text("Z scale: 500 nm\n" + "\n".join(map(str, np.sin(np.arange(99.0)))))
    read_profile(directory / "profile.txt", unit="um", spacing="1 um")


def warn_about_equal_surfaces(directory):
    surface, _ = create_maps()
    half_space(surface, surface, [0.1], effective_modulus=80.0)


@pytest.mark.parametrize(
    ("issue_warning", "category", "text"),
    [
        (warn_about_tau0_of_curve, UserWarning, "was it meant in MPa"),
        (warn_about_tau0_of_result, UserWarning, "was it meant in MPa"),
        (warn_about_a_file, FormatWarning, "profile.txt: "),
        (warn_about_equal_surfaces, UserWarning, "upper"),
    ],
)
def test_warning_refers_to_the_line_that_calls_the_package(tmp_path, issue_warning, category, text):
    with pytest.warns(category, match=text) as caught_warnings:
        issue_warning(tmp_path)
    assert {warning.filename for warning in caught_warnings} == {__file__}


@pytest.mark.filterwarnings("error")
def test_fitted_tau0_causes_no_unit_warning_in_calibration_or_pair():
    options = {"load": "20 MPa", "effective_modulus": "3 GPa", "shifts": 2, "onset": 0}
    tested_pair = pair(*create_maps(), **options, mu0=0.2)
    law = calibrate([FrictionTest(tested_pair, "20 MPa", coefficient=2.0, uncertainty=0.1)], mu0=0.1)
    assert law.tau0[0] > 0.1 * 3
    result = pair(*create_maps(), **options, interface=law)
    assert str(result)
    with pytest.warns(UserWarning, match="tau0 = 5 GPa is above .* was it meant in MPa"):
        result.at(tau0="5 GPa")


@pytest.mark.parametrize(
    "evaluate",
    [
        lambda result: result.at(tau0="5 GPa"),
        lambda result: result.at(tau0="5 GPa", per_member=True),
        lambda result: result.at(tau0="5 GPa", height_scale=1),
        lambda result: result.joint_table(tau0=5.0),
    ],
    ids=["at", "at per member", "at height factors", "joint table"],
)
def test_large_tau0_given_for_a_result_causes_exactly_one_unit_warning(tmp_path, evaluate):
    options = {"load": "20 MPa", "effective_modulus": "3 GPa", "mu0": 0.2, "shifts": 3, "onset": 0}
    result = pair(*create_maps(), **options, directory=tmp_path / "pair")
    with pytest.warns(UserWarning, match="tau0 = 5 GPa is above .* was it meant in MPa") as caught_warnings:
        evaluate(result)
    assert len([warning for warning in caught_warnings if "tau0" in str(warning.message)]) == 1


@pytest.mark.parametrize("evaluate", [friction_map, friction_table], ids=lambda function: function.__name__)
def test_large_tau0_given_for_an_ensemble_causes_exactly_one_unit_warning(evaluate):
    study = table_study(hurst_exponents=[0.8], rms=[0.02], points=32, shortest_wavelength=0.625, repetitions=3)
    arguments = {"loads": [1e-3]} if evaluate is friction_map else {}
    with pytest.warns(UserWarning, match="tau0 = 50 GPa is above .* was it meant in MPa") as caught_warnings:
        evaluate(run(study), **arguments, mu0=0.2, tau0=50.0)
    assert len([warning for warning in caught_warnings if "tau0" in str(warning.message)]) == 1
