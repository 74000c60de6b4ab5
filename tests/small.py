"""A study of a second that has several dimensions, amplitudes, repetitions and approaches."""

import numpy as np
from stiction import Study
from stiction.studies.measured_surfaces import About
from stiction.studies.result import OF_MEMBERS, dataset_of, variables_of

SMALL = Study.named("quick").with_changes(
    {
        "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.6, "count": 4},
        "surfaces.amplitude": ["50 nm", "100 nm"],
        "surfaces.points": 20_000,
        "surfaces.extent": "5 um",
        "contact.approach.count": 10,
        "ensemble.repetitions": 12,
    }
)


def empty_dataset(study):
    """The result of a study before anything is computed: zeros, with units, names and attributes in place."""
    numbers = np.arange(study.ensemble.repetitions)
    arrays = {name: np.zeros(each.shape, each.dtype) for name, each in variables_of(study, numbers).items()}
    if study.is_measured:
        arrays |= {name: np.zeros(numbers.size, dtype) for name, dtype in OF_MEMBERS.items()}
    return dataset_of(study, numbers, arrays, About(nominal_area=1.0) if study.is_measured else None)
