"""Tests of the output of results: results that have no values, and numbers of members."""

import io
import json
import sys
from types import SimpleNamespace

import pytest
from stiction import Study, pair, self_affine_surface
from stiction.cli.application import print_message
from stiction.cli.result_output import print_pair_values, print_resolution_and_onset, print_result, print_result_json
from stiction.solve.store import StoreError
from support.command import check_stiction
from support.synthetic_results import measured_study


def result_whose_summary_raises(raised_error, study):
    def summary():
        raise raised_error

    return SimpleNamespace(study=study, summary=summary, path=None)


@pytest.mark.parametrize("study", [measured_study(), Study()], ids=["measured", "generated"])
def test_output_of_a_result_without_contact_states_the_reason_once(capsys, study):
    result = result_whose_summary_raises(ValueError("the surfaces do not touch"), study)
    for print_values in (print_result, print_pair_values):
        print_values(result)
        assert capsys.readouterr().out == "μ_s  none: the surfaces do not touch\n"
    print_resolution_and_onset(result)
    assert capsys.readouterr().out == ""
    print_result_json(result, "pair", dry=True)
    record = json.loads(capsys.readouterr().out)
    assert (record["values"], record["remark"], record["dry"]) == ([], "the surfaces do not touch", True)


def test_message_on_a_terminal_starts_at_the_beginning_of_the_line(monkeypatch):
    terminal = io.StringIO("repetitions 0/100")
    terminal.seek(0, io.SEEK_END)
    terminal.isatty = lambda: True
    for name in ("stderr", "__stderr__"):
        monkeypatch.setattr(sys, name, terminal)
    print_message("computing")
    assert terminal.getvalue().split("\r")[-1] == "\x1b[2Kstiction: computing\n"


def test_printing_a_damaged_result_raises_the_store_error_instead_of_reporting_no_contact():
    with pytest.raises(StoreError, match="damaged"):
        print_result(result_whose_summary_raises(StoreError("damaged"), measured_study()))


def test_info_command_states_the_numbers_of_surrogates_and_positions(tmp_path):
    bodies = [
        self_affine_surface(3, hurst_exponent=0.8, rms=0.3, shape=(32, 32), spacing=1.0, side=side)
        for side in ("upper", "lower")
    ]
    pair(
        *bodies, load="20 kPa", effective_modulus="80 GPa", mu0=0.1, cutoff="none", onset=0, shifts=3, surrogates=2,
        directory=tmp_path / "pair",
    )  # fmt: skip
    text = check_stiction("info", "pair", cwd=tmp_path).stdout
    assert text.startswith("members      5 of 5 finished: 2 pairs of surrogates, then 3 positions\n")
