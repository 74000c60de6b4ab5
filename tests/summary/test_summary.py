"""Test the summary of a result, which the command, the function and the methods share."""

import contextlib
import json
import sys
import traceback
from collections import Counter

import numpy as np
import pytest
import xarray
from stiction import Result, Study, open_result, pair, run, self_affine_surface, write_surface
from stiction.cli import application
from stiction.summary import evaluation
from support.generated_studies import TINY_STUDY, empty_dataset

COMMAND_OPTIONS = [
    "--effective-modulus", "80 GPa", "--hardness", "2 GPa", "--mu0", "0.2", "--tau0", "50 MPa", "--load", "20 MPa",
    "--load", "40 MPa", "--shifts", "3", "--onset", "1", "--workers", "1",
]  # fmt: skip


@pytest.fixture(scope="module")
def surface_directory(tmp_path_factory):
    path = tmp_path_factory.mktemp("summary")
    for seed, side in enumerate(("upper", "lower")):
        surface = self_affine_surface(seed, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1, side=side)
        write_surface(surface, path / f"{side}.csv")
    return path


def run_command(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["stiction", *map(str, arguments)])
    assert application.run_command_line() == 0


@pytest.fixture(scope="module")
def call_counts(surface_directory):
    """Return how often one `stiction pair` calls each function that reads the whole result or its files."""
    counts = Counter()
    with pytest.MonkeyPatch.context() as monkeypatch:

        def patch_to_count_calls(module, name):
            function = getattr(module, name)

            def count_and_evaluate(*args, **kwargs):
                counts[name] += kwargs.get("budget", True)
                return function(*args, **kwargs)

            monkeypatch.setattr(module, name, count_and_evaluate)

        patch_to_count_calls(evaluation, "summarize")
        patch_to_count_calls(evaluation, "add_uncertainty")
        patch_to_count_calls(evaluation, "find_study_caveats")
        monkeypatch.setattr("matplotlib.figure.Figure.draw", lambda *_: None)
        run_command(
            monkeypatch,
            "pair",
            surface_directory / "upper.csv",
            surface_directory / "lower.csv",
            *COMMAND_OPTIONS,
            "-o",
            surface_directory / "pair",
        )
    return counts


def test_pair_function_computes_summary_and_uncertainty_and_input_caveats_only_once(call_counts):
    assert call_counts == {"summarize": 1, "add_uncertainty": 1, "find_study_caveats": 1}


def test_result_computes_summary_and_onset_and_resolution_only_once(surface_directory, call_counts):
    result = open_result(surface_directory / "pair")
    first_summary, second_summary = result.summary(), result.summary()
    assert first_summary.points is second_summary.points
    assert np.shares_memory(*(summary.onset["sliding_load"].values for summary in (first_summary, second_summary)))
    assert first_summary.values_at_cutoffs.sizes["cut_off"] > 1


def change_in_place(dataset):
    """Set all arrays of a dataset to 0 unless they are read-only, and remove all its variables and attributes."""
    for variable in dataset.variables.values():
        with contextlib.suppress(ValueError):  # the array is read-only
            variable.values[...] = variable.dtype.type(0)
    for name in list(dataset.data_vars):
        del dataset[name]
    dataset.attrs.clear()


@pytest.fixture(scope="module")
def evaluated_result(surface_directory, call_counts):
    """Return a result whose summary is cached, with the text of this summary."""
    result = open_result(surface_directory / "pair")
    return result, repr(result)


DATASET_GETTERS_BY_NAME = {
    "stored": (
        lambda result: result.head,
        lambda result: next(result.pieces()),
        lambda result: result.mean_elastic_loads.to_dataset(),
        lambda result: result.contact_picture,
        lambda result: result.onset,
        lambda result: result.values_at_cutoffs,
    ),
    "at": (lambda result: result.at(),),
    "per_member": (lambda result: result.at(per_member=True),),
    "between": (lambda result: result.at(["20 MPa", "30 MPa"], mu0=0.3),),
    "study": (lambda result: result.at_study_loads,),
    "report": (lambda result: result.at_report_loads,),
    "summary": (lambda result: result.summary().at,),
}
"""Functions that return a dataset of a result. The stored datasets are returned without evaluating the result."""


@pytest.mark.parametrize("dataset_getters", DATASET_GETTERS_BY_NAME.values(), ids=DATASET_GETTERS_BY_NAME.keys())
def test_changing_a_returned_dataset_does_not_change_later_results(
    surface_directory, evaluated_result, dataset_getters
):
    result, summary_text = evaluated_result
    for get_dataset in dataset_getters:
        expected = get_dataset(result).copy(deep=True)
        change_in_place(get_dataset(result))
        xarray.testing.assert_identical(get_dataset(result), expected)
    assert repr(result) == summary_text
    reopened_result = open_result(surface_directory / "pair")
    for get_dataset in dataset_getters:
        change_in_place(get_dataset(reopened_result))
    assert repr(reopened_result) == summary_text


def test_changing_the_returned_array_of_loads_does_not_change_later_results(surface_directory, call_counts):
    result = open_result(surface_directory / "pair")
    expected = result.default_loads.tolist()
    for loads in (result.default_loads, result.reached_loads(3), result.members):
        with contextlib.suppress(ValueError):  # the array is read-only
            loads[:] = 1
    assert result.default_loads.tolist() == expected
    assert result.members.tolist() == [0, 1, 2]


def test_caveat_about_steep_scans_contains_the_rms_gradient_of_the_summary():
    surfaces = (
        self_affine_surface(seed, hurst_exponent=0.8, rms=1.0, shape=(32, 32), spacing=0.1, side=side)
        for seed, side in enumerate(("upper", "lower"))
    )
    result = pair(*surfaces, effective_modulus="80 GPa", mu0=0.2, load="10 MPa", shifts=2)
    point = result.summary().first
    (caveat,) = (caveat for caveat in point.caveats if caveat.name == "rms_gradient")
    assert caveat.value == pytest.approx(point.quantities["rms_gradient"].value)
    assert caveat.value > 1


def test_summary_of_a_result_without_contact_raises_the_same_error_on_every_call():
    result = Result(empty_dataset(TINY_STUDY))
    errors, traceback_lengths = [], set()
    for _ in range(3):
        with pytest.raises(ValueError, match="no pair of this result is in contact") as error_info:
            result.summary()
        errors.append(error_info.value)
        traceback_lengths.add(len(traceback.extract_tb(error_info.tb)))
    assert errors[0] is errors[1] is errors[2]
    assert len(traceback_lengths) == 1  # the traceback of an error must not contain frames of earlier calls


def test_summary_at_explicitly_given_study_inputs_equals_the_default_summary(surface_directory, call_counts):
    """Compare the summary at default values with the summary at the same values given explicitly."""
    result = open_result(surface_directory / "pair")
    default_summary = result.summary()
    explicit_summary = result.summary(["20 MPa", "40 MPa"], mu0=0.2, tau0="50 MPa")
    for default_point, explicit_point in zip(default_summary.points, explicit_summary.points, strict=True):
        assert default_point.assessment == explicit_point.assessment
        assert default_point.caveats == explicit_point.caveats
        default_interval, explicit_interval = (
            result_point.quantities["friction_combined"] for result_point in (default_point, explicit_point)
        )
        limits = [explicit_interval.value, *explicit_interval.interval]
        np.testing.assert_allclose([default_interval.value, *default_interval.interval], limits, rtol=1e-12)
        assert (
            (default_interval.name, default_interval.kind)
            == (explicit_interval.name, explicit_interval.kind)
            == ("friction_combined", "combined")
        )
    assert (result.value, result.interval) == (
        default_summary.first.value,
        (default_summary.first.lower, default_summary.first.upper),
    )


def test_summary_at_another_mu0_has_input_caveats_and_the_combined_interval_at_this_mu0(surface_directory, call_counts):
    result = open_result(surface_directory / "pair")
    point = result.summary("20 MPa", mu0=0.3).first
    combined_interval = result.at("20 MPa", mu0=0.3)["friction_combined"].sel(sliding="all").squeeze()
    np.testing.assert_allclose([point.value, point.lower, point.upper], combined_interval.values, rtol=1e-12)
    expected_caveats = [caveat.text for caveat in result.input_caveats if point.at["cut_off"] < caveat.cut_off]
    assert set(expected_caveats) <= {caveat.text for caveat in point.caveats}


def test_mean_of_friction_coefficients_of_single_pairs_equals_the_reported_mean(surface_directory, call_counts):
    result = open_result(surface_directory / "pair")
    members = result.at("20 MPa", per_member=True)
    means = result.at("20 MPa")
    assert members.sizes["repetition"] == 3
    mean = means["mean_friction"].sel(statistic="mean")
    member_mean = members["friction_coefficient"].mean(("repetition", "direction")).transpose(*mean.dims)
    np.testing.assert_allclose(member_mean, mean, rtol=1e-12)
    with pytest.raises(ValueError, match="per_member must be False if budget"):
        result.at("20 MPa", per_member=True, budget=True)


def test_info_command_and_at_command_print_the_same_assessment_and_caveats(
    surface_directory, call_counts, monkeypatch, capsys
):
    records = []
    for arguments in (["info", surface_directory / "pair", "--json"], ["at", surface_directory / "pair", "--json"]):
        capsys.readouterr()
        run_command(monkeypatch, *arguments)
        records.append(json.loads(capsys.readouterr().out)["points"])
    for info_answer, at_answer in zip(*records, strict=True):
        assert [info_answer[name] for name in ("assessment", "caveats", "rules")] == [
            at_answer[name] for name in ("assessment", "caveats", "rules")
        ]


def test_at_command_advises_against_quoting_a_result_from_few_contacts(tmp_path, monkeypatch, capsys):
    study = Study.named("quick").with_changes({"ensemble.repetitions": 8, "surfaces.points": 3000})
    run(study, store=tmp_path / "study")
    capsys.readouterr()
    arguments = ("--load", "0.002 mN", "--d", "1.3", "--mu0", "0.4", "--tau0", "20 MPa", "--json")
    run_command(monkeypatch, "at", tmp_path / "study", *arguments)
    (json_point,) = json.loads(capsys.readouterr().out)["points"]
    assert json_point["assessment"] == "Do not quote"
    assert "too few contacts, 1.9 on average" in [caveat["text"] for caveat in json_point["caveats"]]
