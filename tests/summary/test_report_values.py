"""Test the arrays of a report of measured surfaces, from tables whose numbers differ between directions."""

from types import SimpleNamespace

import numpy as np
import pytest
import xarray
from stiction.summary.report_values import STATUSES_BY_CODE, evaluate_measured_report
from support.synthetic_results import measured_result, measured_study

DIRECTIONS = (0.0, 90.0, 180.0, 270.0)
MOTION_DIRECTIONS = [[0, 1, 2, 3], [0], [1], [2], [3]]


def evaluate_report(*tables):
    study = measured_study(hardness=2.0)
    tables = [
        table.assign(friction_combined=table["mean_friction"] * xarray.DataArray([1.0, 0.8, 1.2], dims="statistic"))
        for table in tables
    ]
    grid = SimpleNamespace(
        study=study, motions=MOTION_DIRECTIONS, axes=(), loads=np.array([10.0]), member_kinds=[None] * len(tables),
        evaluate=lambda: tables, evaluate_study_inputs=lambda: [table.isel(mu0=0, tau0=0) for table in tables],
    )  # fmt: skip
    return evaluate_measured_report(grid)


@pytest.fixture
def table():
    table = measured_result(directions=DIRECTIONS)
    table["ok"] = table["ok"] * xarray.DataArray([1, 2, 3, 4], dims="direction")
    return table


def test_mean_over_directions_reports_the_pair_count_of_the_direction_with_the_fewest_pairs(table):
    num_solved = evaluate_report(table).num_solved
    assert num_solved[0, 0, 0, :, 0, 0, 0].tolist() == [16, 16, 32, 48, 64]


def test_mean_coefficient_is_a_lower_limit_if_the_softer_body_shears_in_one_direction(table):
    table["status"].loc[{"direction": 90.0}] = "bulk-shear"
    codes = evaluate_report(table).status_codes[0, 0, 0, :, 0, 0, 0]
    assert [STATUSES_BY_CODE[code] for code in codes] == ["bulk-shear", "ok", "bulk-shear", "ok", "ok"]


def test_report_has_combined_intervals_only_for_quoted_means_over_directions(table):
    values = evaluate_report(table, table)
    assert values.has_combined.tolist() == [[True, False, False, False, False], [False] * 5]
    limits = values.friction[:, 0, 0, :, 0, 0, 0, 1:]
    np.testing.assert_array_equal(np.isfinite(limits).all(axis=-1), values.has_combined)
    assert np.isfinite(values.sampling[..., 1:]).all()
