"""Tests of the data frame of results, and of their CSV and JSON output."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pandas
import pytest
from stiction import Study, run
from stiction._estimate import Interval
from stiction.summary.assessment import Caveat
from stiction.summary.summary import UncertaintyBudgetEntry, summarize
from stiction.views.json_record import SCHEMA_VERSION
from stiction.views.rows import summary_json, summary_table, values_frame
from stiction.views.spreadsheet import frame_to_csv
from support.synthetic_results import (
    QUANTITIES_AT_LOAD,
    generated_result,
    generated_study,
    measured_result,
    measured_study,
    value_and_ends,
)

MULTI_VALUE_ARGUMENTS = {"loads": (1.0, 10.0), "mu0": (0.2, 0.3), "tau0": (0.0, 0.05), "cut_offs": (0.0, 0.2)}


def parse_csv(text):
    return list(csv.DictReader(text.splitlines()))


@pytest.mark.parametrize(("contact_status", "expected_status"), [("ok", "no-mean"), ("complete", "complete")])
def test_missing_area_fraction_has_a_status_that_follows_from_the_contact_status(contact_status, expected_status):
    dataset = measured_result(loads=(1.0, 1e3))
    fractions = dataset["contact_area_fraction"]
    dataset["contact_area_fraction"] = fractions.where(fractions["load"] < 10.0)
    dataset["contact_status"] = "load", np.where(fractions["load"] < 10.0, "ok", contact_status)
    rows = values_frame(dataset)
    rows = rows[rows["name"] == "contact_area_fraction"]
    assert rows["status"].tolist() == ["ok", expected_status]
    assert np.isfinite(rows["value"]).tolist() == [True, False]


def test_data_frame_of_a_result_contains_every_numeric_variable():
    dataset = measured_result(**MULTI_VALUE_ARGUMENTS)
    rows = values_frame(dataset)
    numeric_names = [name for name, table in dataset.data_vars.items() if table.dtype.kind in "if"]
    assert set(rows["name"]) == set(numeric_names)
    for name in numeric_names:
        size = dataset[name].size // (3 if "statistic" in dataset[name].dims else 1)
        assert (rows["name"] == name).sum() == size
    area_row = rows[(rows["name"] == "contact_area") & (rows["load"] == 10.0) & (rows["cut_off"] == 0.2)]
    assert area_row[["value", "lower", "upper", "unit"]].values.tolist() == [[*value_and_ends(100.0), "um2"]]
    assert area_row["mu0"].isna().all()
    friction = rows[rows["name"] == "friction_by_axis"]
    assert set(friction["axis"]) == {0.0, 90.0}
    assert set(friction["sliding"]) == {"all", "opposing"}


def test_table_of_values_states_the_kind_of_each_interval():
    dataset = measured_result()
    combined_dataset = dataset.assign(
        {name: dataset[name].assign_attrs(interval_kind="combined") for name in ("contact_area", "mean_pressure")}
    )
    for values, kind in (dataset, "mean"), (combined_dataset, "combined"):
        rows = values_frame(values).set_index("name")
        assert set(rows.loc[["contact_area", "mean_pressure"], "kind"]) == {kind}
        assert set(rows.loc[["contact_count"], "kind"]) == {"mean"}


def test_data_frame_of_a_result_contains_the_status_of_each_value():
    dataset = measured_result(loads=(1.0, 10.0))
    dataset["status"].loc[{"load": 10.0}] = "not-reached"
    dataset["friction_coefficient"].loc[{"load": 10.0}] = np.nan
    rows = values_frame(dataset)
    rows = rows[rows["name"] == "friction_coefficient"]
    assert set(rows[rows["load"] == 10.0]["status"]) == {"not-reached"}
    assert set(rows[rows["load"] == 1.0]["status"]) == {"ok"}


def test_csv_table_has_a_row_with_assessment_and_caveats_for_each_direction():
    input_caveat = Caveat("a parabola, which carries the load", "take it off", "caution")
    rows = parse_csv(
        frame_to_csv(
            summary_table(
                summarize(measured_result(**MULTI_VALUE_ARGUMENTS), measured_study(), input_caveats=[input_caveat])
            )
        )
    )
    assert len(rows) == 2 * 2 * 2 * 2 * 2 * (1 + 2 + 4)
    first_row = rows[0]
    assert first_row["upper body to (degree)"] == "all directions"
    assert float(first_row["coefficient of static friction"]) == 0.21
    assert float(first_row["coefficient of static friction: upper"]) == pytest.approx(0.2205)
    assert {float(row["tau0 (MPa)"]) for row in rows} == {0.0, 50.0}
    assert {row["upper body to (degree)"] for row in rows} == {
        "all directions",
        "along 0",
        "along 90",
        "0",
        "90",
        "180",
        "270",
    }
    area_column = next(name for name in first_row if name.endswith("(um2)"))
    assert {float(row[area_column]) for row in rows} == {QUANTITIES_AT_LOAD["contact_area"]}
    assert {row["assessment"] for row in rows} == {"Quote with care"}
    assert {row["caveats"] for row in rows} == {"a parabola, which carries the load: take it off"}
    rows = parse_csv(frame_to_csv(summary_table(summarize(generated_result(), generated_study()))))
    assert len(rows) == 2 * 2 * 2
    assert {row["fractal dimension"] for row in rows} == {"1.1", "1.4"}
    assert {row["sliding"] for row in rows} == {"opposing"}


DATASETS_AND_STUDIES = {
    "maps": (measured_result(**MULTI_VALUE_ARGUMENTS), measured_study()),
    "missing": (measured_result(status="no-contact", all_contacts=np.nan, opposing=np.nan, ok=0), measured_study()),
    "generated": (generated_result(), generated_study()),
    "one point": (generated_result().isel(fractal_dimension=[0], load=[0], tau0=[0]), generated_study()),
}


def test_exported_csv_table_has_all_fractal_dimensions_even_if_the_summary_has_fewer(tmp_path):
    dimensions = {"start": 1.2, "stop": 1.8, "count": 7}
    changes = {"surfaces.points": 2000, "ensemble.repetitions": 2, "surfaces.fractal_dimension": dimensions}
    result = run(Study.named("quick").with_changes(changes))
    assert result.summary().at.sizes["fractal_dimension"] < 7
    result.export(tmp_path / "table.csv")
    for table in (pandas.read_csv(tmp_path / "table.csv"), result.to_dataframe()):
        np.testing.assert_allclose(table["fractal dimension"].unique(), np.linspace(1.2, 1.8, 7))


@pytest.mark.parametrize("case_name", DATASETS_AND_STUDIES)
def test_json_record_has_equal_keys_for_results_of_all_kinds(case_name):
    dataset, study = DATASETS_AND_STUDIES[case_name]
    record = json.loads(summary_json("at", summarize(dataset, study)))
    assert list(record)[:3] == ["schema", "stiction", "command"]
    assert (record["schema"], record["command"]) == (SCHEMA_VERSION, "at")
    assert len(record["values"]) == len(values_frame(dataset))
    for value in record["values"]:
        assert list(value) == ["name", "value", "unit", "lower", "upper", "kind", "at", "status"]
        assert value["value"] is None or math.isfinite(value["value"])
        assert isinstance(value["status"], str)
        if None not in (value["lower"], value["value"], value["upper"]):
            assert value["lower"] <= value["value"] <= value["upper"]
    area_value = next(value for value in record["values"] if value["name"] == "contact_area")
    assert not {"sliding", "direction", "mu0", "axis"} & set(area_value["at"])


def test_json_record_has_null_for_infinite_limits_of_intervals():
    summary = summarize(measured_result(), measured_study())
    point = summary.points[0]
    unbounded_interval = UncertaintyBudgetEntry(0.25, 0.2, math.inf, label="the hardness", width=math.inf)
    rules = tuple(replace(rule, upper=math.inf, prediction_interval=Interval(0.1, math.inf)) for rule in point.rules)
    point = replace(
        point, rules=rules, budget=(unbounded_interval,), bracket=(0.2, math.inf), contributions=(0.2, math.inf, 0.0),
        roughness_contribution=-math.inf,
    )  # fmt: skip
    text = summary_json("pair", replace(summary, points=(point,)))
    (json_point,) = json.loads(text, parse_constant=pytest.fail)["points"]
    assert json_point["rules"][0]["coefficient"]["upper"] is None
    assert json_point["rules"][0]["text"].endswith("∞)")
    (entry,) = json_point["budget"]
    assert (entry["input"], entry["width"]) == ("the hardness", None)
    assert [entry["coefficient"][name] for name in ("value", "lower", "upper")] == [0.25, 0.2, None]
    assert (
        json_point["finer_scans"]["to"],
        json_point["contributions"]["adhesion"],
        json_point["roughness_contribution"],
    ) == (None, None, None)


def test_json_record_contains_the_assessment_and_caveats_and_values():
    record = json.loads(
        summary_json(
            "pair", summarize(measured_result(share_at_edge=0.6, half_width_ratio=0.02), measured_study()), positions=3
        )
    )
    (json_point,) = record["points"]
    assert json_point["assessment"] == "Do not quote"
    assert json_point["caveats"][0]["severity"] == "fault"
    assert {"text", "remedy", "severity"} == set(json_point["caveats"][0])
    assert json_point["sentence"].startswith("There is no coefficient to quote")
    assert [rule["rule"] for rule in json_point["rules"]] == ["all", "opposing"]
    assert json_point["rules"][0]["coefficient"]["value"] == 0.21
    assert (record["kind"], record["positions"], record["nominal_area"]) == ("pair", 3, 10_000.0)
