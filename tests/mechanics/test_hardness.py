"""Tests of the contact area in a range of hardness, against direct solutions and limits."""

from __future__ import annotations

import numpy as np
import pytest
from stiction import half_space
from stiction.evaluate.hardness_nodes import HARDNESS_NODE_POSITIONS_BY_MODULI_COUNT
from stiction.mechanics.hardness import MIXING_EXPONENT_FACTOR, MIXING_EXPONENT_POWER, interpolate_area_per_load
from support.rough_surfaces import rough_maps

FRICTION_TOLERANCE, AREA_TOLERANCE = 0.01, 0.03
"""Largest relative errors of friction and area between hardness nodes, for maps of 96 by 96 points with few
contacts."""


# The contact is fully plastic, partly plastic, or nearly elastic.
@pytest.mark.parametrize("rms", [0.05, 0.007, 0.0015])
def test_contact_area_interpolated_over_hardness_agrees_with_direct_solutions(rms: float) -> None:
    upper, lower = rough_maps(rms=rms, points=96, spacing=0.05, shortest_wavelength=0.3)

    def solve_area_per_load(hardness: float | None) -> float:
        load = 0.02 * 4.8**2
        curve = half_space(
            upper, lower, [load], effective_modulus=80.0, sliding="all", boundary="periodic", hardness=hardness
        )
        return float(curve.contact_area[0] / curve.normal_elastic[0])

    elastic_area = solve_area_per_load(None)
    nodes = 0.23 * (1.7 / 0.23) ** np.sort([*HARDNESS_NODE_POSITIONS_BY_MODULI_COUNT[1], 0.5])
    expected = np.geomspace(0.23, 1.7, 9)
    result = interpolate_area_per_load(
        expected, nodes, [solve_area_per_load(float(node)) for node in nodes], elastic_area
    )
    direct_solutions = np.array([solve_area_per_load(float(item)) for item in expected])
    assert result == pytest.approx(direct_solutions, rel=AREA_TOLERANCE)
    assert 0.2 + 0.05 * result == pytest.approx(0.2 + 0.05 * direct_solutions, rel=FRICTION_TOLERANCE)


def test_contact_area_interpolated_over_hardness_equals_its_formula() -> None:
    random = np.random.default_rng(4)
    nodes, elastic_areas = np.sort(random.uniform(0.2, 3.0, 7)), np.array([0.3, 1.1])
    areas_at_nodes = random.uniform(0.8, 1.2, (2, 7)) / nodes
    hardness = random.uniform(0.1, 4.0, 50)

    def interpolated_area_per_load(pressure: float, area: float) -> float:
        exponent = MIXING_EXPONENT_FACTOR * (pressure * area) ** MIXING_EXPONENT_POWER
        return float((pressure**-exponent + area**exponent) ** (1 / exponent))

    expected = [
        [
            interpolated_area_per_load(hardness_value, area)
            * np.exp(
                np.interp(
                    np.log(hardness_value),
                    np.log(nodes),
                    np.log([a / interpolated_area_per_load(n, area) for n, a in zip(nodes, row, strict=True)]),
                )
            )
            for hardness_value in hardness
        ]
        for row, area in zip(areas_at_nodes, elastic_areas, strict=True)
    ]
    np.testing.assert_allclose(
        interpolate_area_per_load(hardness, nodes, areas_at_nodes, elastic_areas), expected, rtol=1e-13
    )


def test_area_interpolated_over_hardness_equals_solved_areas_at_the_nodes_and_in_the_elastic_limit() -> None:
    assert interpolate_area_per_load([0.5], [0.5, 1.0], [2.1, 1.1], 0.3)[0] == pytest.approx(2.1)
    area_at_hardness_node = interpolate_area_per_load([1e3], [1e2, 1e4], [0.3, 0.3], 0.3)
    assert area_at_hardness_node[0] == pytest.approx(0.3)
    areas = interpolate_area_per_load([0.5, 1.0], [0.5], [[2.1], [2.2]], [0.3, 0.3])
    assert areas.shape == (2, 2)
