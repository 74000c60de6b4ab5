"""Test that public functions reject arguments of wrong types with one sentence that names the argument."""

import numpy as np
import pytest
from stiction import (
    Ball,
    FrictionTest,
    Profile,
    Study,
    Surface,
    calibrate,
    compare_repeated_scans,
    gentle_friction,
    open_result,
    pair,
    read_measurement,
    read_spectrum,
    run,
    self_affine_surface,
    write_surface,
)
from stiction.mechanics.materials import MaterialValue
from support.generated_studies import TINY_STUDY, with_repetitions

BODY = self_affine_surface(1, hurst_exponent=0.8, rms=0.02, shape=(32, 32), spacing=0.1, side="upper")
BALL = Ball("5 mm", "3 GPa")
PAIR_OPTIONS = {"load": "2 mN", "mu0": 0.2, "effective_modulus": "80 GPa", "shifts": 2, "onset": 0}
RAGGED_LIST = [[1.0], [2.0, 3.0]]
ONE_LOAD = 1


@pytest.fixture(scope="module")
def result():
    return run(with_repetitions(2))


@pytest.fixture(scope="module")
def calibrated_film():
    loads = (5.0, 20.0, 100.0, 500.0)
    return calibrate(
        [
            FrictionTest(BALL, load, coefficient=0.15 + 0.012 * BALL.area_per_load(load), uncertainty=0.01)
            for load in loads
        ]
    )


INVALID_CALLS = {
    "a ball at a load of None": ("load", lambda: BALL.area_per_load(None)),
    "a ball at a negative load": ("load", lambda: BALL.area_per_load("-1 mN")),
    "a ball with a ragged modulus": ("young", lambda: Ball("5 mm", young=RAGGED_LIST, poisson=0.3)),
    "a material value of text": ("low", lambda: MaterialValue("x", 1.0, "source")),
    "a negative material value": ("high", lambda: MaterialValue(0.0, -1.0, "source")),
    "outliers that are a number": ("outliers", lambda: compare_repeated_scans(BODY, BODY, outliers=1)),
    "a study name that is an array": ("there is no", lambda: Study.named(np.zeros(2))),
    "an order that is a list": ("order", lambda: gentle_friction(0.4, rms_gradient=0.1, order=RAGGED_LIST)),
    "a ragged mask of a profile": ("missing", lambda: Profile([0.0, 1.0, 0.0, 1.0], spacing=1.0, missing=RAGGED_LIST)),
    "a ragged mask of a map": ("missing", lambda: Surface(np.eye(3), spacing=1.0, missing=RAGGED_LIST)),
    "a directory that is a number": ("directory", lambda: open_result(1)),
    "a file name with a null character": ("path", lambda: read_measurement("a\0b")),
    "a file name that is an array": ("path", lambda: write_surface(BODY, np.zeros(2))),
    "a spectrum file of None": ("path", lambda: read_spectrum(None)),
    "accepted caveats that are a number": ("accept", lambda: read_measurement("x.csv", accept=1)),
    "a missing value that is complex": ("missing_value", lambda: read_measurement("x.csv", missing_value=1j)),
    "a run of a number": ("study", lambda: run(1)),
    "an executor that is a number": ("executor", lambda: run(TINY_STUDY, executor=1)),
    "a store that is a number": ("store", lambda: run(TINY_STUDY, store=1)),
    "a contact law with a surrogate character": ("law", lambda: pair(BODY, BODY, law="\ud800", **PAIR_OPTIONS)),
    "a number of 5000 digits": ("lines", lambda: pair(BODY, BODY, lines="9" * 5000, **PAIR_OPTIONS)),
    "a tip radius of zero": ("tip", lambda: pair(BODY, BODY, tip=0, **PAIR_OPTIONS)),
    "a choice to replace that is an array": ("replace", lambda: pair(BODY, BODY, replace=np.zeros(2), **PAIR_OPTIONS)),
    "two units of arrays": (
        "unit", lambda: pair(BODY.heights, BODY.heights, unit="um,nm", spacing="0.1 um", **PAIR_OPTIONS)
    ),
    "a study with an unknown key": ("surfaces.a: unknown key", lambda: Study(surfaces={"a": 1})),
    "a study whose section is a number": ("ensemble: must be a section", lambda: Study(ensemble=1)),
}  # fmt: skip


def assert_one_sentence(name, call):
    with pytest.raises(ValueError) as error_info:  # noqa: PT011
        call()
    message = str(error_info.value)
    assert "\n" not in message
    assert "pydantic" not in message
    assert name in message.partition(" got ")[0]
    assert any(words in message for words in ("must ", "unknown key", "there is no"))


@pytest.mark.parametrize("case", INVALID_CALLS)
def test_public_functions_reject_arguments_of_wrong_types_with_a_message_of_one_sentence(case):
    assert_one_sentence(*INVALID_CALLS[case])


@pytest.mark.parametrize("value", [ONE_LOAD, 1.5, "nothing", None, b"1", np.zeros(2), RAGGED_LIST, lambda: 1])
def test_public_methods_reject_arguments_of_wrong_types_with_a_message_of_one_sentence(result, calibrated_film, value):
    assert_one_sentence("names", lambda: result.means(value))
    assert_one_sentence("names", lambda: list(result.pieces([value])))
    assert_one_sentence("quantities", lambda: result.at(0.1, quantities=[value]))
    assert_one_sentence("name", lambda: result.figure(value))
    assert_one_sentence("at", lambda: result.summarize_dataset(value))
    assert_one_sentence("area_per_load", lambda: calibrated_film.at(value if isinstance(value, str) else [value]))
    if not callable(value):
        assert_one_sentence("coefficient", lambda: calibrated_film.interval_of(value))
        assert_one_sentence("read", lambda: result.load_companion(value))
    if not isinstance(value, str):
        for method in (result.export, result.to_netcdf, result.save_report):
            assert_one_sentence("path", lambda method=method: method(value))
    if value is not ONE_LOAD:
        assert_one_sentence("steps", lambda: result.reached_loads(value))
