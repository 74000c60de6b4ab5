import contextlib
import functools
import gc
import os
import signal
from pathlib import Path

# Limit linear algebra to one thread, because tests run in one process per core already.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import hypothesis
import numpy as np
import pytest
from stiction import Profile, random_phases, run, weierstrass_mandelbrot
from stiction.study.input_distributions import NUM_INPUT_SAMPLES
from support.command import disable_companion_files, disable_drawing, disable_reports
from support.generated_studies import SMALL_STUDY
from support.input_samples import use_few_samples, use_input_samples, use_nuisance_points

# Spare the garbage collector modules and test items, which live until the end, during collection and all tests.
gc.disable()


def pytest_collection_finish():
    gc.freeze()
    gc.enable()


# Restore the handler of SIGINT, which background jobs of a shell ignore, but which some tests send to themselves.
signal.signal(signal.SIGINT, signal.default_int_handler)

# Generated examples have no time limit, because other processes may occupy the cores.
hypothesis.settings.register_profile(
    "without time limits", deadline=None, suppress_health_check=[hypothesis.HealthCheck.too_slow]
)
hypothesis.settings.load_profile("without time limits")


@pytest.fixture(scope="session", autouse=True)
def few_input_samples(request):
    """Draw few samples of inputs, and few nuisance points of calibrations, except in tests of the documentation."""
    draws_all = request.config.option.markexpr in ("docs", "soak")
    with contextlib.nullcontext() if draws_all else use_few_samples():
        yield


@pytest.fixture
def all_input_samples():
    """Draw as many samples of inputs as for users, and as many nuisance points. Create results during the test only."""
    with use_input_samples(NUM_INPUT_SAMPLES), use_nuisance_points(1):
        yield


@pytest.fixture(scope="session")
def find_measured_file():
    """Return a function that returns the path of a measured file, or skips the test if the file is absent."""
    directory = Path(os.environ.get("STICTION_TEST_DATA", Path(__file__).parents[2] / "shared" / "data"))

    def find_file(name):
        if not (directory / name).exists():
            pytest.skip(f"the measured file {name} is not in this tree")
        return directory / name

    return find_file


@pytest.fixture(scope="session")
def create_rough_profiles():
    """Return a function that generates an upper and a lower profile with a given fractal dimension."""

    @functools.lru_cache(maxsize=8)
    def create_pair(dimension, *, points=12_000, repetition=0, amplitude=0.1, band_limit=None):
        return tuple(
            weierstrass_mandelbrot(
                random_phases(11, repetition=repetition, side=side), dimension, points=points,
                extent=points * 40 / 150_000, band_limit=band_limit,
            ).with_amplitude(amplitude)
            for side in ("upper", "lower")
        )  # fmt: skip

    return create_pair


@pytest.fixture(scope="session")
def create_circular_arc():
    """Return a function that generates a circular arc, the profile of a cylinder or a sphere."""

    def create_arc(apex, radius, spacing, points, side):
        x = np.arange(points) * spacing - apex
        sagitta = np.square(x) / (radius + np.sqrt(radius**2 - np.square(x)))
        return Profile(sagitta if side == "upper" else -sagitta, spacing=spacing)

    return create_arc


@pytest.fixture(scope="session")
def small_result():
    """Return the dataset of `SMALL_STUDY`; tests must not change it."""
    return run(SMALL_STUDY).dataset


@pytest.fixture(scope="module")
def no_figures():
    """Return a context manager in which commands write no figures, for faster tests of other output."""

    @contextlib.contextmanager
    def without_figures():
        with pytest.MonkeyPatch.context() as patch, disable_drawing():
            patch.setattr("stiction.views.figures.draw_figures", lambda *_, **__: [])
            yield

    return without_figures


@pytest.fixture
def disable_figures(no_figures):
    """Make commands write no figures during a test."""
    with no_figures():
        yield


@pytest.fixture(scope="module")
def no_contact_pictures():
    """Disable the contact pictures that are stored with results, for faster tests of values and intervals."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stiction.pipeline.contact_picture", lambda _: None)
        yield


@pytest.fixture(scope="module")
def no_companion_files():
    """Disable contact pictures, cutoff studies and onsets of pairs, for faster tests of values and intervals."""
    with disable_companion_files():
        yield


@pytest.fixture
def omit_companion_files():
    """Disable contact pictures, cutoff studies and onsets of pairs during a test, for faster tests of other output."""
    with disable_companion_files():
        yield


@pytest.fixture
def no_reports():
    """Replace the reports that commands write by empty pages during a test, for faster tests of other output."""
    with disable_reports():
        yield


@pytest.fixture(scope="module")
def few_fitted_lines():
    """Fit the Hurst exponent of at most 12 lines of a map along each axis, for faster tests of text and figures."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("stiction.surfaces.lines.MAX_FITTED_LINES", 12)
        yield
