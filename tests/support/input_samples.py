"""Number of samples of uncertain inputs, and of nuisance points in calibrations, that tests draw."""

import contextlib

import pytest
from stiction.calibration import fit
from stiction.calibration.fit import FINAL_NUISANCE_POINT_COUNTS as NUISANCE_POINT_COUNTS
from stiction.calibration.fit import MIN_EFFECTIVE_SAMPLES
from stiction.evaluate import combined_intervals, shear_intervals
from stiction.study import input_distributions, inputs, interfaces

NUM_INPUT_SAMPLES_IN_TESTS = 2**10
"""Number of samples of uncertain inputs in most tests: a sixteenth of the number for users."""

FRACTION_OF_NUISANCE_POINTS_IN_TESTS = 0.25
"""Number of nuisance points of a calibration in most tests, as a fraction of the number for users."""


@contextlib.contextmanager
def use_few_samples():
    """Return a context manager with few samples of uncertain inputs, and few nuisance points of calibrations."""
    with use_input_samples(NUM_INPUT_SAMPLES_IN_TESTS), use_nuisance_points(FRACTION_OF_NUISANCE_POINTS_IN_TESTS):
        yield


@contextlib.contextmanager
def use_input_samples(count):
    """Return a context manager in which uncertain inputs have the given number of samples (a power of 2)."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (input_distributions, combined_intervals, shear_intervals):
            patch.setattr(module, "NUM_INPUT_SAMPLES", count)
        _clear_caches()
        yield
    _clear_caches()


@contextlib.contextmanager
def use_nuisance_points(fraction):
    """Return a context manager in which calibrations draw only a fraction of the usual nuisance points."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fit, "FINAL_NUISANCE_POINT_COUNTS", tuple(int(fraction * n) for n in NUISANCE_POINT_COUNTS))
        patch.setattr(fit, "MIN_EFFECTIVE_SAMPLES", fraction * MIN_EFFECTIVE_SAMPLES)
        yield


def _clear_caches():
    """Remove cached results that depend on the number of samples."""
    combined_intervals._compute_test_scores.cache_clear()
    for module in (inputs, interfaces):
        for value in vars(module).values():
            if hasattr(value, "cache_clear") and value.__module__ == module.__name__:
                value.cache_clear()
