"""The summary of a result: computed once, complete, and the same from every way to ask for it."""

import json
import sys
from collections import Counter

import numpy as np
import pytest
from stiction import Study, open_result, run, self_affine_surface, write_surface
from stiction.cli import application
from stiction.studies import budget, input_caveats, summary

PAIR = [
    "--effective-modulus", "80 GPa", "--hardness", "2 GPa", "--mu0", "0.2", "--tau0", "50 MPa", "--load", "20 MPa",
    "--load", "40 MPa", "--shifts", "3", "--onset", "1", "--workers", "1",
]  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    where = tmp_path_factory.mktemp("summary")
    for seed, side in enumerate(("upper", "lower")):
        surface = self_affine_surface(seed, hurst_exponent=0.8, rms=0.02, shape=(64, 64), spacing=0.1, side=side)
        write_surface(surface, where / f"{side}.csv")
    return where


def run_command(monkeypatch, *arguments):
    monkeypatch.setattr(sys, "argv", ["stiction", *map(str, arguments)])
    assert application.start() == 0


@pytest.fixture(scope="module")
def calls(folder):
    """How often one `stiction pair` calls functions that each take the whole result or its files."""
    counts = Counter()
    with pytest.MonkeyPatch.context() as monkeypatch:

        def count(module, name):
            function = getattr(module, name)

            def counted(*args, **kwargs):
                counts[name] += kwargs.get("budget", True)
                return function(*args, **kwargs)

            monkeypatch.setattr(module, name, counted)

        count(summary, "summarize")
        count(budget, "add_uncertainty")
        count(input_caveats, "find_study_caveats")
        run_command(monkeypatch, "pair", folder / "upper.csv", folder / "lower.csv", *PAIR, "-o", folder / "pair")
    return counts


def test_pair_computes_summary_values_and_input_caveats_once(calls):
    assert calls == {"summarize": 1, "add_uncertainty": 1, "find_study_caveats": 1}


def test_result_keeps_its_summary_and_adds_what_is_stored_alongside(folder, calls):
    result = open_result(folder / "pair")
    first, second = result.summary(), result.summary()
    assert first.points is second.points
    assert first.onset is second.onset is not None
    assert first.over_cut_offs.sizes["cut_off"] > 1


def test_summary_at_the_study_values_is_that_of_the_study(folder, calls):
    """The same assessment, caveats and intervals, however it is asked for."""
    result = open_result(folder / "pair")
    own = result.summary()
    named = result.summary(["20 MPa", "40 MPa"], mu0=0.2, tau0="50 MPa")
    for one, other in zip(own.points, named.points, strict=True):
        assert one.verdict == other.verdict
        assert one.caveats == other.caveats
        np.testing.assert_allclose(one.quantity("friction_combined"), other.quantity("friction_combined"), rtol=1e-12)
    assert (result.value, result.interval) == (own.first.value, (own.first.lower, own.first.upper))


def test_summary_at_another_mu0_has_a_combined_interval_and_input_caveats(folder, calls):
    result = open_result(folder / "pair")
    point = result.summary("20 MPa", mu0=0.3).first
    at = result.at("20 MPa", mu0=0.3)["friction_combined"].sel(sliding="all").squeeze()
    np.testing.assert_allclose([point.value, point.lower, point.upper], at.values, rtol=1e-12)
    stored = [caveat.text for caveat in result.input_caveats if point.at["cut_off"] < caveat.cut_off]
    assert set(stored) <= {caveat.text for caveat in point.caveats}


def test_at_per_member_averages_to_the_means(folder, calls):
    result = open_result(folder / "pair")
    members = result.at("20 MPa", per_member=True)
    means = result.at("20 MPa")
    assert members.sizes["repetition"] == 3
    mean = means["friction_all_round"].sel(statistic="mean")
    own = members["friction_coefficient"].mean(("repetition", "direction")).transpose(*mean.dims)
    np.testing.assert_allclose(own, mean, rtol=1e-12)
    with pytest.raises(ValueError, match="per_member must be False with budget"):
        result.at("20 MPa", per_member=True, budget=True)


def test_at_command_has_the_assessment_and_caveats_of_pair(folder, calls, monkeypatch, capsys):
    records = []
    for arguments in (["info", folder / "pair", "--json"], ["at", folder / "pair", "--json"]):
        capsys.readouterr()
        run_command(monkeypatch, *arguments)
        records.append(json.loads(capsys.readouterr().out)["answers"])
    for one, other in zip(*records, strict=True):
        assert [one[name] for name in ("verdict", "caveats", "rules")] == [
            other[name] for name in ("verdict", "caveats", "rules")
        ]


def test_at_command_rejects_few_contacts_at_a_load_of_its_own(tmp_path, monkeypatch, capsys):
    study = Study.named("quick").with_changes({"ensemble.repetitions": 8, "surfaces.points": 3000})
    run(study, store=tmp_path / "study")
    capsys.readouterr()
    arguments = ("--load", "0.002 mN", "--d", "1.3", "--mu0", "0.4", "--tau0", "20 MPa", "--json")
    run_command(monkeypatch, "at", tmp_path / "study", *arguments)
    (answer,) = json.loads(capsys.readouterr().out)["answers"]
    assert answer["verdict"] == "Do not quote"
    assert "1.9 contacts on average are too few" in [caveat["text"] for caveat in answer["caveats"]]
