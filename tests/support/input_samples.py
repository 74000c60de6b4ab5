"""Number of samples of uncertain inputs in tests."""

import contextlib

import pytest
from stiction.evaluate import combined_intervals, shear_intervals
from stiction.study import input_distributions, inputs, interfaces


@contextlib.contextmanager
def use_input_samples(count):
    """Return a context manager in which uncertain inputs have the given number of samples, a power of two."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (input_distributions, combined_intervals, shear_intervals):
            patch.setattr(module, "NUM_INPUT_SAMPLES", count)
        _clear_caches()
        yield
    _clear_caches()


def _clear_caches():
    """Remove cached values that were computed from another number of samples."""
    combined_intervals._compute_test_scores.cache_clear()
    for module in (inputs, interfaces):
        for value in vars(module).values():
            if hasattr(value, "cache_clear") and value.__module__ == module.__name__:
                value.cache_clear()
