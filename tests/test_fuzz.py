"""Test functions, files and stores with a few of the random inputs of `./dev soak fuzz`."""

from collections import Counter

import numpy as np
import pytest
from stiction import run
from support import fuzzing


def test_functions_accept_random_arrays_or_raise_value_error():
    outcomes = Counter(type(fuzzing.fuzz_numeric_function(np.random.default_rng([1, i]))) for i in range(2000))
    assert set(outcomes) == {type(None), ValueError}
    assert min(outcomes.values()) > 500  # Both outcomes, acceptance and ValueError, must be frequent.


def test_random_study_files_are_run_or_rejected_without_traceback(tmp_path):
    outcomes = Counter(fuzzing.fuzz_study_file(np.random.default_rng([2, i]), tmp_path) for i in range(30))
    assert outcomes[2] > 10
    assert outcomes[0] > 1


@pytest.fixture(scope="module")
def stored_result(tmp_path_factory):
    directory = tmp_path_factory.mktemp("pristine")
    run(fuzzing.small_fuzz_study(), store=directory)
    return directory


def test_random_damage_to_a_stored_result_is_detected_or_harmless(tmp_path, stored_result):
    outcomes = Counter(
        fuzzing.fuzz_stored_result(np.random.default_rng([3, i]), stored_result, tmp_path) for i in range(12)
    )
    assert outcomes[2] > 2
