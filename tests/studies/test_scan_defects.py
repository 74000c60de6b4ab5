"""Defects are found once per scan and shared by a pair, its alternative preparations and its caveats."""

from collections import Counter

import numpy as np
import pytest
from stiction import pair
from stiction.studies import scan_defects
from stiction.studies.input_caveats import find_alternatives
from stiction.studies.measured_surfaces import MeasuredBodySettings
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_contact_pictures")


@pytest.fixture
def scan_folder(tmp_path, monkeypatch):
    """Change to a folder with the scans upper.npy and lower.npy."""
    monkeypatch.chdir(tmp_path)
    for side, surface in zip(("upper", "lower"), rough_maps(points=32), strict=True):
        np.save(f"{side}.npy", surface.heights)
    return tmp_path


def test_defects_of_each_scan_are_found_once(scan_folder, monkeypatch):
    num_calls = Counter()

    def count_calls(name):
        function = getattr(scan_defects, name)

        def counted(*arguments, **options):
            num_calls[name] += 1
            return function(*arguments, **options)

        monkeypatch.setattr(scan_defects, name, counted)

    for name in ("instrument_limit", "find_hidden_noise", "find_outliers", "levelled"):
        count_calls(name)
    result = pair(
        "upper.npy", "lower.npy", unit="um", spacing="0.1 um", effective_modulus="80 GPa", hardness="2 GPa", mu0=0.2,
        load="10 MPa", shifts=1, onset=0, direction=[0],
    )  # fmt: skip
    assert find_alternatives(result.study) == []
    assert not any("spike" in caveat.text for caveat in result.input_caveats)
    assert num_calls == {"instrument_limit": 2, "find_hidden_noise": 2, "levelled": 2}


def test_file_is_read_once_for_its_relative_and_its_absolute_path(scan_folder):
    relative, absolute = (
        MeasuredBodySettings(file=str(file), unit="um", spacing="0.1 um")
        for file in ("upper.npy", scan_folder / "upper.npy")
    )
    assert relative.with_checksums().read() is absolute.read()
    assert relative.model_copy(update={"texture": "ground"}).read() is absolute.read()
    assert relative.model_copy(update={"outliers": "mask"}).read() is not absolute.read()
