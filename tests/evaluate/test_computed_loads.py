"""Tests of the range of computed loads, and of loads without values."""

import numpy as np
import pytest
from stiction import Result, run
from stiction.evaluate.computed_loads import (
    find_computed_load_range,
    find_loads_outside_range,
    find_loads_without_values,
)
from support.generated_studies import SMALL_STUDY


@pytest.fixture(scope="module")
def result():
    return run(SMALL_STUDY.with_changes({"ensemble.repetitions": 3}))


def test_range_of_computed_loads_of_a_fractal_dimension_ignores_other_dimensions(result):
    elastic_loads = result.mean_elastic_loads
    lowest_load, highest_load = find_computed_load_range(result)
    assert highest_load == elastic_loads.max()
    assert lowest_load == elastic_loads.where(elastic_loads > 0).min()
    values = result.at(1e-3).isel(fractal_dimension=[0])
    assert find_computed_load_range(result, values)[1] == elastic_loads.isel(fractal_dimension=0).max()


def test_range_of_computed_loads_ignores_pairs_without_a_solution(result):
    elastic_loads = result.dataset["normal_elastic"]
    first_loads, last_loads = elastic_loads["repetition"].values[[0, -1]]
    is_solved = (elastic_loads["repetition"] != first_loads) | (
        elastic_loads["approach"] < elastic_loads["approach"][-1]
    )
    is_solved &= elastic_loads["repetition"] != last_loads
    incomplete = Result.of(result.dataset.assign(normal_elastic=elastic_loads.where(is_solved)))
    expected = elastic_loads.where(is_solved).mean("repetition")
    lowest_load, highest_load = find_computed_load_range(incomplete)
    assert lowest_load == pytest.approx(float(expected.where(expected > 0).min()))
    assert highest_load == pytest.approx(float(expected.max()))
    loads = [0.99 * highest_load, 1.01 * highest_load]
    assert find_loads_outside_range(incomplete, incomplete.at(loads)) == loads[1:]
    assert incomplete.reached_loads()[-1] == highest_load


def test_load_outside_the_computed_loads_has_no_values_even_for_self_locked_surfaces(result):
    highest_load = find_computed_load_range(result)[1]
    loads = [1e-3, 2 * highest_load]
    values = result.at(loads)
    assert find_loads_without_values(result, values) == loads[1:]
    values["status"].loc[{"load": loads[1], "fractal_dimension": values["fractal_dimension"][0]}] = "self-locked"
    assert find_loads_without_values(result, values) == loads[1:]


def test_computed_load_at_which_surfaces_are_self_locked_counts_as_a_load_with_values(result):
    values = result.at(1e-3)
    values["status"][:] = np.array("self-locked", values["status"].dtype)
    assert find_loads_without_values(result, values) == []
    values["status"][:] = np.array("not-solved", values["status"].dtype)
    assert find_loads_without_values(result, values) == [1e-3]
