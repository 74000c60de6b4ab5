"""Small studies of generated profiles, and helpers for tests of runs and stores."""

from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
import xarray
from stiction import Study
from stiction.solve.layout import MEMBER_COORDINATE_TYPES, build_dataset, variable_specs
from stiction.study.member_sources import BodyAttributes

SMALL_STUDY = Study.named("quick").with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.6, "count": 4},
        "surfaces.amplitude": ["50 nm", "100 nm"],
        "surfaces.points": 20_000,
        "surfaces.extent": "5 um",
        "contact.approach.count": 10,
        "ensemble.repetitions": 12,
    }
)

TINY_STUDY = Study().with_changes(
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


def empty_dataset(study):
    """Return a dataset with the units, names and attributes of a study's result, in which all numbers are zero."""
    numbers = np.arange(study.ensemble.repetitions)
    arrays = {
        name: np.zeros(variable.shape, variable.dtype) for name, variable in variable_specs(study, numbers).items()
    }
    if study.is_measured:
        arrays |= {name: np.zeros(numbers.size, dtype) for name, dtype in MEMBER_COORDINATE_TYPES.items()}
    return build_dataset(study, numbers, arrays, BodyAttributes(nominal_area=1.0) if study.is_measured else None)


def with_repetitions(number, study=TINY_STUDY):
    """Return a copy of a study that has the given number of repetitions."""
    return study.with_changes({"ensemble.repetitions": number})


class InlineExecutor(ThreadPoolExecutor):
    """Executor that runs each task in the calling thread, in the order in which tasks are submitted."""

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


def assert_same_bits(actual, expected):
    """Assert that two datasets are identical, including all bits of their arrays."""
    xarray.testing.assert_identical(actual, expected)
    for name in actual.variables:
        assert actual[name].values.tobytes() == expected[name].values.tobytes(), name


def rewrite_variable(file, name, change):
    """Replace the values of a variable in a netCDF file by `change(values)`, with the same dimensions."""
    scales = [[dim[i] for i in range(len(dim))] for dim in file[name].dims]
    values = change(file[name][...])
    del file[name]
    new_variable = file.create_dataset(name, data=values)
    for axis, scales_of_axis in enumerate(scales[: new_variable.ndim]):
        for scale in scales_of_axis:
            new_variable.dims[axis].attach_scale(scale)
