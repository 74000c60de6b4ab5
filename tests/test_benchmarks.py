"""Test the command line of the benchmarks."""

import sys
from pathlib import Path

import pytest

BENCHMARK_DIRECTORY = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def benchmark_runner(monkeypatch):
    monkeypatch.syspath_prepend(BENCHMARK_DIRECTORY)
    monkeypatch.delitem(sys.modules, "run", raising=False)
    import run

    yield run
    sys.modules.pop("run")


def test_benchmark_script_accepts_known_names_or_no_names(benchmark_runner, capsys):
    assert benchmark_runner.parse_names([]) == []
    assert benchmark_runner.parse_names(["pair", "app"]) == ["pair", "app"]
    with pytest.raises(SystemExit):
        benchmark_runner.parse_names(["pairs"])
    assert "'pairs' is not among pair, against" in capsys.readouterr().err
