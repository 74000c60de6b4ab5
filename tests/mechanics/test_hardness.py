"""Tests of the area of yielding contacts in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from stiction.mechanics.hardness import yielded_area

YIELD_EXPONENTS = (0.5, 1.0, 1.25, 2.0, 10.0)


@pytest.mark.parametrize("exponent", YIELD_EXPONENTS)
def test_yielded_area_equals_the_elastic_area_up_to_half_of_the_hardness_and_is_continuous(exponent: float) -> None:
    assert yielded_area(3.0, [1e-6, 0.7, 1.5], 1.0, exponent).tolist() == [3.0, 3.0, 3.0]
    assert yielded_area(3.0, 1.5 * (1 + 1e-9), 1.0, exponent) == pytest.approx(3.0, rel=1e-8)
    assert yielded_area(3.0, 5.0, np.inf, exponent) == 3.0


@pytest.mark.parametrize("exponent", YIELD_EXPONENTS)
def test_yielded_area_satisfies_its_equation_and_grows_with_the_load(exponent: float) -> None:
    elastic_area, hardness, load = 3.0, 0.8, np.array([1.3, 2.0, 4.0, 20.0])
    area = yielded_area(elastic_area, load, hardness, exponent)
    expected_power = elastic_area**exponent + (load / hardness) ** exponent - (elastic_area / 2) ** exponent
    assert area**exponent == pytest.approx(expected_power, rel=1e-13)
    assert (np.diff(area) > 0).all()


def test_yielded_area_of_fully_plastic_contacts_equals_load_divided_by_hardness() -> None:
    assert yielded_area(1e-9, 4.0, 2.0, 1.25) == pytest.approx(2.0, rel=1e-9)


def test_yielded_area_broadcasts_its_arguments() -> None:
    assert yielded_area(np.ones((3, 1)), np.ones(4), 1.0, np.full((2, 1, 1), 1.25)).shape == (2, 3, 4)
