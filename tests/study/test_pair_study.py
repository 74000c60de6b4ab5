"""Test the analysis of the scans of a pair in several threads."""

import os
import threading

import pytest
from stiction import pair
from stiction.study import pair_study
from support.rough_surfaces import rough_maps
from support.thread_limits import allow_one_new_thread

OPTIONS = {"load": ["20 MPa", "50 MPa"], "mu0": 0.2, "effective_modulus": "80 GPa", "shifts": 2, "onset": 0}


def test_interrupted_noise_analysis_does_not_wait_for_other_scans(monkeypatch):
    is_analysed, may_end, has_ended = threading.Event(), threading.Event(), threading.Event()
    first_scan = threading.Lock()

    def analyse(scan):
        if first_scan.acquire(blocking=False):
            is_analysed.wait(30)
            raise KeyboardInterrupt
        is_analysed.set()
        may_end.wait(30)
        has_ended.set()

    monkeypatch.setattr(os, "sched_getaffinity", lambda _: range(2))
    monkeypatch.setattr(pair_study, "_find_noise_wavelengths", analyse)
    try:
        with pytest.raises(KeyboardInterrupt):
            pair(*rough_maps(), **OPTIONS)
        assert is_analysed.is_set()
        assert not has_ended.is_set()
    finally:
        may_end.set()


def test_noise_analysis_uses_fewer_threads_if_not_all_threads_can_start(monkeypatch):
    started = allow_one_new_thread(monkeypatch)
    find_noise = pair_study._find_noise_wavelengths
    analysed_in = []

    def analyse(scan):
        analysed_in.append(threading.current_thread())
        if len(analysed_in) == 2:
            monkeypatch.undo()
        return find_noise(scan)

    monkeypatch.setattr(pair_study, "_find_noise_wavelengths", analyse)
    pair(*rough_maps(), **OPTIONS)
    assert analysed_in == started * 2
