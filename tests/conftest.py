import contextlib
import functools
import os
import signal
from pathlib import Path

# Each core has a process of tests: threads of linear algebra in each would wait for one another.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np
import pytest
from stiction import Profile, random_phases, run, weierstrass_mandelbrot
from support.command import disable_drawing
from support.generated_studies import SMALL

# A shell that runs the tests in the background has them and their children ignore Ctrl-C, which some of them press.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def measured():
    """measured(name): path of an instrument file; the test is skipped if it is absent."""
    folder = Path(os.environ.get("STICTION_TEST_DATA", Path(__file__).parents[2] / "shared" / "data"))

    def path(name):
        if not (folder / name).exists():
            pytest.skip(f"the measured file {name} is not here")
        return folder / name

    return path


@pytest.fixture(scope="session")
def rough_pair():
    """rough_pair(D): an upper and a lower profile with a slope spectrum up to the grid."""

    @functools.lru_cache(maxsize=8)
    def pair(dimension, *, points=12_000, repetition=0, amplitude=0.1, band_limit=None):
        return tuple(
            weierstrass_mandelbrot(
                random_phases(11, repetition=repetition, side=side), dimension, points=points,
                extent=points * 40 / 150_000, band_limit=band_limit,
            ).with_amplitude(amplitude)
            for side in ("upper", "lower")
        )  # fmt: skip

    return pair


@pytest.fixture(scope="session")
def circular_arc():
    """circular_arc(apex, radius, spacing, points, side): a cylinder or sphere of exact curvature."""

    def arc(apex, radius, spacing, points, side):
        x = np.arange(points) * spacing - apex
        sagitta = np.square(x) / (radius + np.sqrt(radius**2 - np.square(x)))
        return Profile(sagitta if side == "upper" else -sagitta, spacing=spacing)

    return arc


@pytest.fixture(scope="session")
def small_result():
    """Result of the study `SMALL`; tests must not change it."""
    return run(SMALL).dataset


@pytest.fixture(scope="module")
def no_figures():
    """Context without figures, for tests that do not check figures: it saves most of their time."""

    @contextlib.contextmanager
    def undrawn():
        with pytest.MonkeyPatch.context() as patch, disable_drawing():
            patch.setattr("stiction.views.figures.draw_figures", lambda *_, **__: [])
            yield

    return undrawn


@pytest.fixture
def undrawn(no_figures):
    """Disable figures for a test."""
    with no_figures():
        yield
