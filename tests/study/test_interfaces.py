"""Test interfaces given by name or by file: their effect on the interval of a pair, and damaged files."""

from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas
import pytest
from stiction import (
    Ball,
    FrictionTest,
    Study,
    calibrate,
    interface,
    interfaces,
    open_result,
    pair,
    read_interface,
    self_affine_surface,
    write_interface,
    write_surface,
)  # fmt: skip
from stiction._estimate import Estimate
from stiction.evaluate.at_load import at_load
from stiction.evaluate.budget import add_uncertainty
from stiction.evaluate.point import list_rules_with_reported_first
from stiction.solve.member_sums import MemberSums
from stiction.study.input_distributions import Z_95
from stiction.study.inputs import find_interface
from stiction.study.interfaces import compute_coverage_at_bound, compute_credible_interval
from stiction.study.study import parse_study
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
from stiction.views.rows import point_record
from stiction.views.sentence import contributions_text, quotable_sentence
from support.command import assert_rejected, call_stiction, check_stiction

pytestmark = pytest.mark.usefixtures("no_companion_files")

INTERFACE_KINDS = ("measured", "lumped", "bound")

MAX_SAMPLING_ERROR = 0.04
"""Largest error of an interval limit due to 4000 random samples, as a fraction of the interval width."""

INTERVAL_NAMES = ("friction_combined", "mean_friction")
PAIR_OPTIONS = {"load": "20 MPa", "effective_modulus": "3 GPa", "shifts": 4, "onset": 0}


def rough_surfaces():
    return [
        self_affine_surface(seed, hurst_exponent=0.8, rms=0.005, shape=(48, 48), spacing=0.1, side=side)
        for side, seed in (("upper", 1), ("lower", 2))
    ]


@pytest.fixture(scope="module")
def film_file(tmp_path_factory):
    """Return the path of an interface file with correlated mu0 and tau0, which tests on a ball determined."""
    path = tmp_path_factory.mktemp("film") / "film"
    ball = Ball("5 mm", "3 GPa")
    tests = [
        FrictionTest(ball, load, coefficient=y, uncertainty=0.05 * y)
        for load in (100.0, 300.0, 1000.0, 2000.0)
        for y in [0.15 + 0.012 * ball.area_per_load(load)]
    ]
    write_interface(calibrate(tests), path)
    return path


@pytest.fixture(scope="module")
def opposing_film_file(film_file):
    """Return the path of the same interface, marked as fitted with friction at opposing contacts only."""
    film = interface(film_file)
    path = film_file.with_name("opposing_film")
    write_interface(replace(film, fits=(replace(film.fits[0], sliding="opposing"),)), path)
    return path


@pytest.fixture(scope="module")
def result(film_file):
    return pair(*rough_surfaces(), interface=film_file, **PAIR_OPTIONS)


@pytest.fixture(scope="module")
def opposing_result(opposing_film_file):
    return pair(*rough_surfaces(), interface=opposing_film_file, **PAIR_OPTIONS)


@pytest.mark.parametrize("name", [*interfaces()])
def test_repr_of_an_interface_without_known_contact_area_shows_no_combination_of_mu0_and_tau0(name):
    law = interface(name)
    lines = repr(law).splitlines()
    assert lines[0] == "Interface"
    assert "A/F" not in repr(law)
    (strength,) = (line for line in lines if line.startswith("  tau0  "))
    assert strength.endswith("] MPa")
    value, lower, upper = (1e3 * limit for limit in law.tau0)
    assert strength.split()[1:4] == [f"{value:.4g}", f"[{lower:.4g},", f"{upper:.4g}]"]
    assert np.isnan(law.identified).all()


def test_changing_the_returned_list_does_not_change_the_published_interfaces():
    name, entry = next(iter(interfaces().items()))
    value = entry["mu0"]
    interfaces()[name]["mu0"] = "0.9"
    interfaces().clear()
    assert interfaces()[name]["mu0"] == value


def test_pair_function_samples_mu0_and_tau0_of_an_interface_jointly(film_file, result) -> None:
    _, adhesion, _ = result.summary().points[0].contributions
    fit = interface(film_file).fits[0]
    area = adhesion / np.median(fit.tau0)
    friction = fit.mu0 + fit.tau0 * area
    relative = np.diff(result.interval_of_mean)[0] / 2 / Z_95 / result.value
    friction = friction * (1 + relative * np.random.default_rng(0).standard_normal(friction.size))
    expected = np.quantile(friction, [0.025, 0.975]) * result.value / np.median(fit.mu0 + fit.tau0 * area)
    assert result.interval == pytest.approx(expected, abs=MAX_SAMPLING_ERROR * np.ptp(expected))
    assert result.budget["input"].tolist()[0] == "the interface"
    interface_row = result.budget.loc[0]
    assert (interface_row.lower, interface_row.upper) == pytest.approx(
        result.interval_of_mean, abs=0.1 * np.ptp(result.interval)
    )
    (mu0,), (tau0,) = result.study.friction.mu0, result.study.friction.tau0
    uncorrelated_result = pair(*rough_surfaces(), mu0=mu0.text, tau0=tau0.text, **PAIR_OPTIONS)
    assert np.ptp(uncorrelated_result.interval) > 1.2 * np.ptp(result.interval)
    assert "interface film (measured, friction at all contacts)" in result.sentence


@pytest.mark.parametrize(("entry", "severity"), [("quote with care", "caution"), ("do not quote", "fault")])
def test_caveats_in_an_interface_file_apply_to_pairs_with_this_interface(tmp_path, film_file, entry, severity) -> None:
    write_interface(interface(film_file).with_caveats(entry, ["rough at 1 mN: few contacts"]), tmp_path / "film")
    result = pair(*rough_surfaces(), interface=tmp_path / "film", **PAIR_OPTIONS)
    (caveat,) = [caveat for caveat in result.caveats if caveat.text == "interface film: rough at 1 mN: few contacts"]
    assert caveat.severity == severity
    assert result.assessment != "Quote it"


def test_coefficient_is_marked_if_the_interface_was_calibrated_for_the_other_sliding_rule(
    result, opposing_result
) -> None:
    remark = ", for which the interface was not calibrated"
    for each, rule in ((result, "opposing contacts only"), (opposing_result, "all contacts")):
        first, second = " ".join(repr(each).split()).split(" friction at ")[1:3]
        assert remark not in first
        assert second.startswith(rule + remark)
        assert each.summary().first.calibrated_rule == each.summary().first.rules[0].rule
    assert remark not in repr(pair(*rough_surfaces(), mu0=0.2, tau0="50 MPa", **PAIR_OPTIONS))


def test_contributions_of_mu0_and_adhesion_are_summed_if_the_interface_does_not_separate_them(tmp_path, result) -> None:
    film = replace(interface(result.study.friction.interface.file), separated=False)
    write_interface(film, tmp_path / "sum")
    unseparated_result = pair(*rough_surfaces(), interface=tmp_path / "sum", **PAIR_OPTIONS)
    point, separated_point = unseparated_result.summary().first, result.summary().first
    assert list(separated_point.contribution_terms) == ["mu0", "adhesion", "slopes"]
    mu0, adhesion, slopes = separated_point.contributions
    assert point.contribution_terms == pytest.approx({"mu0_and_adhesion": mu0 + adhesion, "slopes": slopes})
    assert point.roughness_contribution is None
    label = "μ0 and τ0 on the area at the onset of sliding, not separated by the tests"
    assert f"{mu0 + adhesion:.3f} ({label})" in contributions_text(point)
    sum_text = Estimate(*film.identified).text()
    assert f"its tests determine only μ0 + τ0 A/F = {sum_text}" in unseparated_result.sentence
    assert "μ0 = " in result.sentence
    assert not any(f"{symbol} = " in unseparated_result.sentence for symbol in ("μ0", "τ0"))
    assert point_record(point)["contributions"] == point.contribution_terms
    note = f"the tests determine only μ0 + τ0 A/F = {sum_text}"
    record, separated_record = point_record(point), point_record(separated_point)
    assert (record["strengths_separated"], separated_record["strengths_separated"]) == (False, True)
    assert note in record["assumptions"][-1]
    assert not any("μ0" in text for text in separated_record["assumptions"])
    assert all(note in text for text in unseparated_result.to_dataframe()["assumptions"])


def test_pair_result_lists_first_the_coefficient_for_the_sliding_rule_of_the_interface(result, opposing_result) -> None:
    point, other_point = opposing_result.summary().first, result.summary().first
    assert [rule.rule for rule in point.rules] == ["opposing", "all"]
    assert [rule.rule for rule in other_point.rules] == ["all", "opposing"]
    assert opposing_result.value == other_point.rules[1].value < 0.7 * result.value
    assert opposing_result.interval == tuple(other_point.rules[1].interval)
    budget = opposing_result.budget
    assert budget["input"].tolist()[0] == "the interface"
    assert (budget["lower"] <= opposing_result.value).all()
    assert (budget["upper"] >= opposing_result.value).all()
    assert not any("opposing" in caveat.text for caveat in opposing_result.caveats)


def test_csv_table_and_quotable_sentence_and_joint_table_start_with_the_rule_of_the_interface(
    opposing_result, tmp_path
) -> None:
    opposing_result.export(tmp_path / "pair.csv")
    table = pandas.read_csv(tmp_path / "pair.csv")
    assert table["sliding"].drop_duplicates().tolist() == ["opposing", "all"]
    point = opposing_result.summary().first
    first_coefficient_text, second_coefficient_text = (
        f"{rule} with {SLIDING_RULE_DESCRIPTIONS[rule.rule]}" for rule in point.rules
    )
    sentence = quotable_sentence(replace(point, caveats=()))
    assert sentence.startswith(f"μ_s = {first_coefficient_text}, at")
    assert second_coefficient_text not in sentence
    assert repr(opposing_result).startswith(f"μ_s = {first_coefficient_text.replace(' with ', '  ')}\n")
    joint_values = opposing_result.joint_table("20 MPa").reference.estimates
    assert joint_values["friction_combined"].value == pytest.approx(opposing_result.value)


def test_sliding_rule_of_an_interface_is_still_listed_first_after_its_file_was_removed(
    opposing_film_file, tmp_path
) -> None:
    copy = shutil.copy(opposing_film_file, tmp_path)
    stored_result = pair(*rough_surfaces(), interface=copy, **PAIR_OPTIONS)
    Path(copy).unlink()
    reopened = open_result(stored_result.path)
    assert find_interface(reopened.study) is None
    assert (reopened.summary().first.rules[0].rule, reopened.value) == ("opposing", stored_result.value)


@pytest.mark.parametrize("entries", [{}, {"quote with care": "a trend"}, {"do not quote": "few contacts"}], ids=str)
def test_study_keeps_the_caveats_of_an_interface_whose_file_was_moved_or_deleted(tmp_path, film_file, entries) -> None:
    law = interface(film_file)
    for entry, text in entries.items():
        law = law.with_caveats(entry, [text])
    write_interface(law, tmp_path / "film")
    stored_result = pair(*rough_surfaces(), interface=tmp_path / "film", **PAIR_OPTIONS)
    film = tmp_path / "film"
    moved_file = film.rename(tmp_path / "moved_film")
    for is_deleted in (False, True):
        if is_deleted:
            moved_file.rename(film).unlink()
            assert not list(tmp_path.glob("*film"))
        reopened = open_result(stored_result.path)
        assert find_interface(reopened.study) is None
        assert (reopened.assessment, reopened.caveats) == (stored_result.assessment, stored_result.caveats)
        assert [caveat.text for caveat in reopened.caveats if "film" in caveat.text] == [
            f"interface film: {text}" for text in entries.values()
        ]


def test_caveats_of_an_interface_are_unknown_in_an_older_study_whose_interface_file_was_removed(
    tmp_path, film_file
) -> None:
    copy = Path(shutil.copy(film_file, tmp_path))
    stored_result = pair(*rough_surfaces(), interface=copy, **PAIR_OPTIONS)
    text = stored_result.study.to_toml()
    new_entries = ', faults = "", cautions = "", separated = true, junction_growth = ""'
    assert text.count(new_entries) == 1
    (stored_result.path / "study.toml").write_text(text.replace(new_entries, ""))
    assert open_result(stored_result.path).caveats == stored_result.caveats
    copy.unlink()
    reopened = open_result(stored_result.path)
    assert any("interface film is missing or has changed" in caveat.text for caveat in reopened.caveats)
    assert reopened.assessment != "Quote it"


def test_caveats_of_an_interface_are_unknown_if_its_file_was_replaced_by_another_law(tmp_path, film_file) -> None:
    write_interface(interface(film_file), tmp_path / "film")
    stored_result = pair(*rough_surfaces(), interface=tmp_path / "film", **PAIR_OPTIONS)
    write_interface(
        calibrate([FrictionTest(Ball("5 mm", "3 GPa"), 9.0, coefficient=1, uncertainty=0.1)]), tmp_path / "film"
    )
    reopened = open_result(stored_result.path)
    assert any("interface film is missing or has changed" in caveat.text for caveat in reopened.caveats)
    assert reopened.assessment != "Quote it"


def test_caveats_of_an_interface_apply_if_the_scans_of_the_pair_were_removed(tmp_path, film_file) -> None:
    write_interface(interface(film_file).with_caveats("do not quote", ["few contacts"]), tmp_path / "film")
    scans = [tmp_path / f"{side}.npy" for side in ("upper", "lower")]
    for body, path in zip(rough_surfaces(), scans, strict=True):
        write_surface(body, path)
    stored_result = pair(*scans, interface=tmp_path / "film", **PAIR_OPTIONS)
    for path in scans:
        path.unlink()
    reopened = open_result(stored_result.path)
    assert "interface film: few contacts" in [caveat.text for caveat in reopened.caveats]
    assert reopened.assessment == "Do not quote"


def test_contributions_of_mu0_and_adhesion_stay_summed_if_the_interface_file_is_missing(tmp_path, film_file) -> None:
    write_interface(replace(interface(film_file), separated=False), tmp_path / "sum")
    stored_result = pair(*rough_surfaces(), interface=tmp_path / "sum", **PAIR_OPTIONS)
    (tmp_path / "sum").unlink()
    point = open_result(stored_result.path).summary().first
    assert point.contribution_terms == stored_result.summary().first.contribution_terms
    assert list(point.contribution_terms) == ["mu0_and_adhesion", "slopes"]


def test_resampled_fit_contains_samples_in_proportion_to_their_weights(film_file) -> None:
    fit = interface(film_file).fits[0]
    names = ("mu0", "tau0", "hardness", "junction_growth", "area_per_load")
    equal = fit.resample(np.full(fit.mu0.size, 1000.0))
    for name in names:
        np.testing.assert_array_equal(getattr(equal, name), getattr(fit, name))
    index = int(np.argmax(fit.mu0))
    weighted = fit.resample(np.where(np.arange(fit.mu0.size) == index, np.log(fit.mu0.size - 1), 0.0))
    is_selected = weighted.mu0 == fit.mu0[index]
    assert is_selected.sum() == pytest.approx(fit.mu0.size / 2, abs=1)
    np.testing.assert_array_equal(weighted.tau0[is_selected], fit.tau0[index])
    assert weighted.fits_at_bounds is fit.fits_at_bounds


def test_interface_entry_without_a_sliding_rule_has_the_rule_of_its_file(opposing_result) -> None:
    text = opposing_result.study.to_toml()
    assert text.count(', sliding = "opposing"') == 1
    old_study = parse_study(text.replace(', sliding = "opposing"', ""), "an older study")
    assert find_interface(old_study) is find_interface(opposing_result.study) is not None
    assert list_rules_with_reported_first(old_study) == ["opposing", "all"]


def test_interface_is_ignored_if_mu0_of_the_study_is_changed(result) -> None:
    study = result.study
    stored_study = Study.from_toml(result.path / "study.toml")
    assert find_interface(stored_study) is find_interface(study) is not None
    assert find_interface(stored_study.with_changes({"friction.mu0": [0.3]})) is None


def test_interval_at_another_mu0_equals_the_interval_of_a_study_with_this_mu0(result) -> None:
    study = result.study.with_changes({"friction.mu0": [0.3]})
    changed_sums = MemberSums.of(result).with_study(study)
    table = result.at(mu0=[0.3], budget=True)
    expected = add_uncertainty(at_load(changed_sums, table["load"].values), changed_sums)
    assert table["input_label"].values.tolist() == ["τ0", "positions", "unresolved roughness"]
    for name in ("friction_combined", "remaining_interval"):
        np.testing.assert_array_equal(table[name].values, expected[name].values)
    widths = [np.ptp(table[name].sel(sliding="all", statistic=["lower", "upper"]).values) for name in INTERVAL_NAMES]
    assert widths[0] > 1.2 * widths[1]


def test_mu0_and_tau0_have_independent_ranges_if_the_interface_file_is_missing(film_file, tmp_path) -> None:
    copy = shutil.copy(film_file, tmp_path)
    result = pair(*rough_surfaces(), interface=copy, **PAIR_OPTIONS)
    joint_interval, path = result.interval, result.path
    Path(copy).unlink()
    completed = check_stiction("at", path, "--load", "20 MPa", "--json", cwd=tmp_path)
    (json_point,) = json.loads(completed.stdout)["points"]
    coefficient = json_point["rules"][0]["coefficient"]
    assert np.ptp([coefficient["lower"], coefficient["upper"]]) > 1.2 * np.ptp(joint_interval)
    assert "which is missing" in completed.stdout


def test_result_with_mu0_and_tau0_intervals_of_an_older_version_keeps_the_joint_distribution(tmp_path) -> None:
    test = FrictionTest(Ball("5 mm", "3 GPa"), 100.0, coefficient=0.4, uncertainty=0.02)
    write_interface(calibrate([test]), tmp_path / "film")
    options = {"interface": tmp_path / "film", "directory": tmp_path / "r", **PAIR_OPTIONS}
    stored_result = pair(*rough_surfaces(), **options)
    study_file = tmp_path / "r" / "study.toml"
    text = study_file.read_text()
    entry = stored_result.study.friction.interface
    old_text = text
    for name, interval in (("mu0", "0.00713..0.411"), ("tau0", "0.0321..5.13 MPa")):
        central_text = getattr(entry, name).text.partition(" (")[0]
        old_text = old_text.replace(getattr(entry, name).text, f"{central_text} ({interval})")
    assert old_text.count("0.00713..0.411") == old_text.count("0.0321..5.13 MPa") == 1
    study_file.write_text(old_text)
    reopened = open_result(tmp_path / "r")
    assert find_interface(reopened.study) is not None
    assert reopened.study == stored_result.study
    assert (reopened.value, reopened.interval) == (stored_result.value, stored_result.interval)
    assert "which is missing" not in reopened.sentence
    assert pair(*rough_surfaces(), **options).interval == stored_result.interval
    other_test = replace(test, coefficient=0.41)
    write_interface(calibrate([other_test]), tmp_path / "film")
    changed = open_result(tmp_path / "r")
    assert find_interface(changed.study) is None
    assert changed.study.friction.mu0[0].text.endswith(" (0.00713..0.411)")


@pytest.mark.parametrize("name", sorted(interfaces()))
def test_named_interface_has_kind_and_source_and_is_accepted_by_the_pair_function(name) -> None:
    entry = interfaces()[name]
    assert set(entry) == {"kind", "tau0", "mu0", "pressure", "conditions", "motion", "source"}
    assert entry["kind"] in INTERFACE_KINDS
    assert entry["motion"] in ("static", "kinetic")
    assert (entry["kind"] == "lumped") == (entry["tau0"] == "0 MPa")
    result = pair(*rough_surfaces(), interface=name, **PAIR_OPTIONS)
    assert f"interface {name} ({entry['kind']}, {entry['motion']}" in result.sentence
    assert result.interval[0] <= result.value <= result.interval[1]


@pytest.mark.parametrize(
    ("options", "pattern"),
    [
        ({}, "give mu0 or interface"),
        ({"mu0": 0.2, "interface": "steel on ice"}, "mu0 must not be combined with interface"),
        ({"interface": "steel on butter"}, "interface must be a file or one of"),
        ({"interface": 3}, "interface must be a name, or a file"),
    ],
)
def test_pair_function_rejects_an_interface_combined_with_mu0(options, pattern) -> None:
    with pytest.raises(ValueError, match=pattern):
        pair(*rough_surfaces(), **PAIR_OPTIONS, **options)


def test_repeated_pair_command_accepts_another_published_interface_or_an_interface_file(film_file, tmp_path) -> None:
    options = {**PAIR_OPTIONS, "directory": tmp_path / "r"}
    first_name, second_name = list(interfaces())[:2]
    values = [
        pair(*rough_surfaces(), interface=source, **options).value
        for source in (first_name, second_name, film_file, first_name)
    ]
    assert len(set(values)) == 3
    assert values[3] == values[0]


def test_interfaces_command_lists_interfaces_that_the_pair_command_accepts(tmp_path) -> None:
    output = call_stiction("interfaces", cwd=tmp_path).stdout
    record = json.loads(call_stiction("interfaces", "--json", cwd=tmp_path).stdout)
    assert [item["name"] for item in record["interfaces"]] == list(interfaces())
    assert all(f"{name}\n  {entry['kind']}, " in output for name, entry in interfaces().items())
    for side, body in zip(("upper", "lower"), rough_surfaces(), strict=True):
        write_surface(body, tmp_path / f"{side}.csv")
    options = ("pair", "upper.csv", "lower.csv", "--load", "20 MPa", "--effective-modulus", "3 GPa", "--shifts", "2")
    completed = check_stiction(
        *options, "--interface", "steel on ice", "--onset", 0, cwd=tmp_path, without_figures=True, without_report=True
    )
    assert "interface steel on ice (lumped, kinetic)" in " ".join(completed.stdout.split())
    assert_rejected(call_stiction(*options, cwd=tmp_path), "give --mu0 or --interface")
    assert_rejected(call_stiction(*options, "--interface", "x", "--mu0", 1, cwd=tmp_path), "--mu0 must not be combined")


def test_calibrated_interface_is_accepted_by_the_pair_function_and_stored_with_the_result(film_file, result) -> None:
    result_of_loaded_interface = pair(*rough_surfaces(), interface=interface(film_file), **PAIR_OPTIONS)
    assert result_of_loaded_interface.interval == pytest.approx(result.interval, rel=1e-6)
    assert (result_of_loaded_interface.path / "interface.csv").is_file()


FILE_DAMAGES = {
    "a scan": lambda text: "0" * 50_000_001,
    "another first line": lambda text: text.replace("# stiction interface", "# stiction interfaces", 1),
    "an unknown rule": lambda text: text.replace("# sliding: ", "# sliding: sideways "),
    "a long cell": lambda text: text.rstrip("\n") + "\n" + "1" * 200_000 + ",1,nan\n",
    "a quote": lambda text: text.rstrip("\n") + '\n"1,1,nan\n',
    "no rows": lambda text: text.partition("mu0,")[0],
}


@pytest.mark.parametrize("kind", FILE_DAMAGES)
def test_damaged_interface_file_is_reported_by_name_and_is_not_listed(film_file, tmp_path, kind) -> None:
    (tmp_path / "bad").write_text(FILE_DAMAGES[kind](film_file.read_text()))
    with pytest.raises(ValueError, match=r"bad is (not an|a damaged) interface"):
        read_interface(tmp_path / "bad")
    shutil.copy(film_file, tmp_path / "good")
    completed = check_stiction("interfaces", ".", "--json", cwd=tmp_path)
    assert [entry["name"] for entry in json.loads(completed.stdout)["interfaces"]] == ["good"]


def test_calibration_functions_reject_arguments_of_wrong_types(film_file) -> None:
    for function, pattern in (
        (lambda: calibrate(5), "tests must be a sequence of FrictionTest"),
        (lambda: calibrate([5]), "tests must be a sequence of FrictionTest"),
        (lambda: read_interface(film_file).predict(3, 5.0), "result must be"),
        (lambda: write_interface("x", "y"), "interface must be an Interface"),
        (lambda: read_interface(3), "path must be a path, got int"),
        (lambda: interface(3), "interface must be a name or a path"),
        (lambda: Ball("5 mm", "0 GPa"), "effective_modulus must be above 0"),
        (lambda: FrictionTest(Ball("5 mm", "3 GPa"), 1.0, coefficient=1e300), "coefficient must be"),
        (
            lambda: FrictionTest(SimpleNamespace(nominal_area=1e4), "2 MPa", force="20 N"),
            "coefficient must be given instead of force",
        ),
    ):
        with pytest.raises(ValueError, match=pattern):
            function()


def test_rejected_pair_call_for_another_study_leaves_the_stored_interface_file_unchanged(film_file, tmp_path) -> None:
    film = interface(film_file)
    first_result = pair(*rough_surfaces(), interface=film, directory=tmp_path / "r", **PAIR_OPTIONS)
    content = (tmp_path / "r" / "interface.csv").read_bytes()
    ball = Ball("5 mm", "3 GPa")
    other_film = calibrate([FrictionTest(ball, load, coefficient=0.4, uncertainty=0.02) for load in (10.0, 1000.0)])
    with pytest.raises(ValueError, match="contains another study"):
        pair(*reversed(rough_surfaces()), interface=other_film, directory=tmp_path / "r", **PAIR_OPTIONS)
    assert (tmp_path / "r" / "interface.csv").read_bytes() == content
    assert first_result.interval == open_result(tmp_path / "r").interval


def test_pair_function_creates_no_directory_if_too_many_positions_are_requested(tmp_path) -> None:
    with pytest.raises(ValueError, match=r"the maps have \d+ relative positions"):
        pair(*rough_surfaces(), mu0=0.2, directory=tmp_path / "r", **PAIR_OPTIONS | {"shifts": 400_000})
    assert not (tmp_path / "r").exists()


@pytest.mark.parametrize("text", ["a#1", "a,b", '"a"', "a: b", "\udcff", "a\0b", "=1+1", "# c"])
def test_interface_file_preserves_one_line_entries_and_escapes_control_characters(tmp_path, text):
    write_interface(interface("MoS2 on bearing steel, dry air"), tmp_path / "a.csv", {"operator": text})
    expected_text = {"\udcff": "\\udcff", "a\0b": "a\\x00b"}.get(text, text)
    assert read_interface(tmp_path / "a.csv").about["operator"] == expected_text


@pytest.mark.parametrize("key", ["sliding", "a: b", "a\nb", "", "\udcff"])
def test_interface_entry_that_a_file_cannot_represent_is_rejected_on_writing(tmp_path, key):
    with pytest.raises(ValueError, match="each key of `about` must be printable and have no colon"):
        write_interface(interface("MoS2 on bearing steel, dry air"), tmp_path / "a.csv", {key: "x"})


@pytest.mark.parametrize(
    "key",
    [
        "sliding", "area_per_load", "variation", "separated", "common error of the tests", "rows with mu0 = 0",
        "rows with tau0 = 0", "exact inputs of the tests", "do not quote", "quote with care",
    ],
)  # fmt: skip
def test_message_about_a_reserved_key_of_an_interface_file_quotes_all_reserved_keys(tmp_path, key):
    with pytest.raises(ValueError, match=f"must not be one of .*'{key}'.*, got '{key}'"):
        write_interface(interface("MoS2 on bearing steel, dry air"), tmp_path / "a.csv", {key: "x"})


@pytest.mark.parametrize("seed", range(20))
def test_coverage_at_a_bound_of_zero_decreases_with_the_density_of_samples_at_zero(seed) -> None:
    random = np.random.default_rng(seed)
    assert compute_coverage_at_bound(random.random(4000)) > 0.9
    assert compute_coverage_at_bound(np.abs(random.normal(0, 1, 4000))) > 0.93
    assert compute_coverage_at_bound(np.abs(random.normal(1, 0.4, 4000))) == 0
    samples = random.normal(1, 1, 20_000)
    # At 0, the density is exp(-1/2) of its maximum, so the region up to 1.96 standard deviations has 1.686 left.
    assert compute_coverage_at_bound(samples[samples > 0][:4000]) == pytest.approx(0.908, abs=0.03)
    assert compute_coverage_at_bound(random.normal(10, 1, 4000)) == 0


@pytest.mark.parametrize("mean", np.linspace(0, 4, 9))
def test_interval_of_a_nonnegative_number_contains_95_to_98_percent_of_its_samples(mean) -> None:
    samples = np.random.default_rng(1).normal(mean, 1, 200_000)
    samples = samples[samples > 0][:50_000]
    _, low, high = compute_credible_interval(samples, 0.0)
    assert 0.945 < np.mean((low <= samples) & (samples <= high)) < 0.98


def test_interface_file_contains_the_fits_in_which_mu0_or_tau0_is_zero(tmp_path) -> None:
    test = FrictionTest(Ball("5 mm", "3 GPa"), 100.0, coefficient=0.4, uncertainty=0.02)
    strength = calibrate([test])
    write_interface(strength, tmp_path / "film")
    stored = read_interface(tmp_path / "film")
    for (expected, coverage), (fit, stored_coverage) in zip(strength.sampled_fits, stored.sampled_fits, strict=True):
        assert stored_coverage == pytest.approx(coverage, abs=1e-6)
        for name in ("mu0", "tau0", "area_per_load"):
            np.testing.assert_allclose(getattr(fit, name), getattr(expected, name), rtol=1e-8)
    assert stored.possible_zeros == ("mu0", "tau0")
    assert not {"rows with mu0 = 0", "rows with tau0 = 0"} & stored.about.keys()
    # A file without these rows has the same intervals, apart from the scatter of the samples.
    lines = (tmp_path / "film").read_text().splitlines()
    is_old = [
        not line.startswith("# rows") and not line.startswith("0,") and line.split(",")[1:2] != ["0"] for line in lines
    ]
    (tmp_path / "old").write_text("\n".join(line for line, keep in zip(lines, is_old, strict=True) if keep) + "\n")
    old = read_interface(tmp_path / "old")
    assert old.at(1.0) == pytest.approx(strength.at(1.0), rel=0.02)


def test_interface_file_with_fewer_rows_than_its_stated_count_is_reported_as_damaged(tmp_path) -> None:
    test = FrictionTest(Ball("5 mm", "3 GPa"), 100.0, coefficient=0.4, uncertainty=0.02)
    write_interface(calibrate([test]), tmp_path / "film")
    text = (tmp_path / "film").read_text().replace("rows with mu0 = 0: 4000", "rows with mu0 = 0: 400000")
    (tmp_path / "film").write_text(text)
    with pytest.raises(ValueError, match="film is a damaged interface file"):
        read_interface(tmp_path / "film")
