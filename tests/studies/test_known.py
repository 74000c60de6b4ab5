"""Numbers, values with uncertainties and ranges: from text to draws, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from stiction.studies.known import draws, known


@pytest.mark.parametrize(
    ("text", "kind", "ends", "distribution"),
    [
        ("0.2±0.02", "", (0.1608, 0.2392), "normal"),
        ("1.1 GPa +- 10 %", "pressure", (0.8844, 1.3156), "normal"),
        ("20..80 MPa", "pressure", (0.02, 0.08), "log-normal"),
        ("500 MPa .. 1.5 GPa", "pressure", (0.5, 1.5), "log-normal"),
        ("0.15..0.25", "", (0.15, 0.25), "normal"),
        ("uniform 0.1..0.3", "", (0.105, 0.295), "uniform"),
        ("0..50 MPa", "pressure", (0.00125, 0.04875), "uniform"),
        (0.3, "", (0.3, 0.3), "exact"),
    ],
)
def test_ninety_five_in_a_hundred_lie_between_the_ends(text, kind, ends, distribution) -> None:
    found = known("input", text, kind)
    assert found.distribution == distribution
    assert found.quantile([0.025, 0.975]) == pytest.approx(ends, rel=1e-3)
    values = draws({"input": found})["input"]
    assert np.quantile(values, [0.025, 0.975]) == pytest.approx(ends, rel=0.01)


def test_nothing_is_below_zero() -> None:
    assert draws({"mu0": known("mu0", "0.01±0.02")})["mu0"].min() >= 0


@pytest.mark.parametrize(
    ("text", "kind", "words"),
    [
        ("0.2 MPa±0.02", "", "mu0 must be a number"),
        ("80..20 MPa", "pressure", "smaller to a larger"),
        ("20..80", "pressure", "unit of pressure"),
        ("-5..3 MPa", "pressure", "not negative"),
        ("nan", "", "finite"),
        ("0.2±0", "", "above 0"),
        (None, "", "must be a number"),
    ],
)
def test_what_is_none_is_refused(text, kind, words) -> None:
    with pytest.raises(ValueError, match=words):
        known("mu0", text, kind)
