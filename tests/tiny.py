"""A study of a few milliseconds, and what tests of stores and runs share."""

from concurrent.futures import Future, ThreadPoolExecutor

import xarray
from stiction import Study

TINY = Study().with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.7, "count": 3},
        "surfaces.amplitude": ["50 nm", "100 nm"],
        "surfaces.points": 300,
        "surfaces.extent": "2 um",
        "surfaces.directions": 4,
        "surfaces.frequencies": 6,
        "contact.approach.count": 4,
        "ensemble.repetitions": 22,
        "figures.draw": [],
    }
)


class Inline(ThreadPoolExecutor):
    """Computes in order, in the thread that asks, so what is done when is known."""

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def repetitions(number, study=TINY):
    """The study with so many repetitions."""
    return study.with_changes({"ensemble.repetitions": number})


def assert_same_bits(one, other):
    xarray.testing.assert_identical(one, other)
    for name in one.variables:
        assert one[name].values.tobytes() == other[name].values.tobytes(), name


def rewritten(file, name, change):
    """A variable of a netCDF file becomes another one over the same dimensions."""
    scales = [[each[i] for i in range(len(each))] for each in file[name].dims]
    values = change(file[name][...])
    del file[name]
    new = file.create_dataset(name, data=values)
    for axis, each in enumerate(scales[: new.ndim]):
        for scale in each:
            new.dims[axis].attach_scale(scale)
