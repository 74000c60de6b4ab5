"""A study of a second that has several dimensions, amplitudes, repetitions and approaches."""

from stiction import Study

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
