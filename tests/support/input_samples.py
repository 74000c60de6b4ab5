"""Number of samples of uncertain inputs in tests."""

import contextlib

import pytest
from stiction.evaluate import combined_intervals, shear_intervals
from stiction.study import input_distributions


@contextlib.contextmanager
def use_input_samples(count):
    """Return a context manager in which uncertain inputs have the given number of samples, a power of two."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (input_distributions, combined_intervals, shear_intervals):
            patch.setattr(module, "NUM_INPUT_SAMPLES", count)
        combined_intervals._compute_test_scores.cache_clear()
        yield
    combined_intervals._compute_test_scores.cache_clear()
