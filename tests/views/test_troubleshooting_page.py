"""Compare the statuses and caveats that the page on troubleshooting quotes with those that the program prints."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from stiction import Ball, FrictionTest, Profile, Surface, calibrate, flipped, self_affine
from stiction.mechanics.friction import STATUS_OK, STATUSES
from stiction.study.input_distributions import parse_input_value
from stiction.study.inputs import Inputs
from stiction.study.measured_bodies import MeasuredBodySettings
from stiction.summary.input_caveats import find_input_caveats, find_scan_caveats
from stiction.summary.interface_caveats import find_interface_caveats
from stiction.summary.summary import summarize
from support.rough_surfaces import rough_maps, self_affine_map
from support.synthetic_results import measured_result, measured_study

TROUBLESHOOTING_PAGE = Path(__file__).parents[2] / "docs/howto/troubleshooting.md"


def list_first_cells(title):
    """Return the first cells of all rows in tables whose first column has the given title."""
    tables = re.findall(
        rf"^\| {title} \|.*\n\|[-|]+\|\n((?:\|.*\n)+)", TROUBLESHOOTING_PAGE.read_text(encoding="utf-8"), re.MULTILINE
    )
    return [line.split(" | ")[0].removeprefix("| ") for table in tables for line in table.splitlines()]


def list_result_caveats():
    """Return the caveats of results with one faulty number each."""
    elastic_study, plastic_study = measured_study(), measured_study(hardness=2.0)
    asperity_study = measured_study(mechanics="asperities", adhesion=None)
    changes = [
        {"rms_gradient": 1.5}, {"contact_count": 7.0}, {"share_on_largest": 0.45}, {"share_at_edge": 0.3},
        {"fraction_on_small": 0.6}, {"contact_area": 1.0}, {"half_width_ratio": 0.6}, {"ok": 7},
    ]  # fmt: skip
    cases = [(measured_result(**change), elastic_study) for change in changes]
    cases += [
        (measured_result(**{name: 0.6}), asperity_study)
        for name in ("share_beyond_hertz", "share_below_grid", "share_overlapping")
    ]
    attributes = {"upper_drift": (0.1, 0.5), "upper_pierced": 0.1, "upper_lay": 5.0, "lower_lay": 5.0}
    attributes |= {"upper_spacing_um": 0.1, "lower_spacing_um": 0.1}
    cases.append((measured_result(all_contacts=0.4).assign_attrs(attributes), elastic_study))
    cases.append((measured_result(mean_pressure=0.95), plastic_study.with_changes({"contact.yield_exponent": None})))
    study_of_profiles = measured_study(press="lines").with_changes({"surfaces.lay_assumed": True})
    cases.append((measured_result(half_width_ratio=0.01), study_of_profiles))
    faulty_alternative = summarize(measured_result(half_width_ratio=0.9), elastic_study)
    summaries = [summarize(dataset, study) for dataset, study in cases]
    summaries += [
        summarize(measured_result(), elastic_study, alternatives={name: faulty_alternative})
        for name in ("spikes", "tip")
    ]
    return [caveat for summary in summaries for caveat in summary.points[0].caveats]


def list_scan_caveats():
    """Return the caveats of scans with one fault each."""
    rng = np.random.default_rng(5)
    smooth_profile = self_affine(1, hurst_exponent=0.8, rms=0.05, points=4096, spacing=0.01, shortest_wavelength=0.5)
    rough_profile = self_affine(3, hurst_exponent=0.7, rms=0.01, points=3000, spacing=0.01, longest_wavelength=5.0)
    (rough_map, *_) = rough_maps(1, hurst_exponent=0.7, rms=0.02, points=96, spacing=0.1, longest_wavelength=9.6)
    noise = rng.normal(size=4096)
    line = np.sin(2 * np.pi * np.arange(4096) / 8)
    step = np.arange(4096) > 1500
    spikes = np.isin(np.arange(4096), [1000, 3000])
    map_spikes = np.isin(np.arange(96 * 96), [1000, 5000]).reshape(96, 96)
    scans = [
        *(
            Profile(smooth_profile.heights + added_heights, spacing=0.01)
            for added_heights in (2e-4 * noise, 5e-4 * line, 2.0 * step, spikes)
        ),
        Surface(rough_map.heights + 0.5 * map_spikes, spacing=0.1),
        Surface(rough_map.heights + 0.002 * rng.normal(size=(96, 96)), spacing=0.1),
    ]
    caveats = [caveat for scan in scans for caveat in find_scan_caveats(scan)]
    return caveats + find_scan_caveats(rough_profile, tip_radius=20.0, elastic=True)


def list_mirror_caveats():
    """Return the caveat about two faces that would fit if the upper face were mirrored."""
    lower = Surface(self_affine_map(5, 0.8, (96, 96), longest=8.0, spacing=(1.0, 1.0)).heights, spacing=1.0)
    upper = Surface(flipped(lower).heights[::-1, ::-1], spacing=1.0)
    study = measured_study().with_changes({"surfaces.positions": [["0 um", "0 um"]]})
    return find_input_caveats(upper, lower, study)


def list_law_caveats():
    """Return caveats of laws that disagree with their tests or with a pair, and of a missing law."""
    ball = Ball("5 mm", "3 GPa ± 10 %")
    loads = np.geomspace(5.0, 2000.0, 8)
    coefficients_of_laws = 0.2 + 0.05 * (-1.0) ** np.arange(8), 0.2 * loads**0.1
    laws = [
        calibrate([FrictionTest(ball, load, y, uncertainty=0.02 * y) for load, y in zip(loads, values, strict=True)])
        for values in coefficients_of_laws
    ]
    inputs = Inputs.from_values({"effective_modulus": parse_input_value("effective_modulus", "3 GPa ± 2 %")})
    laws.append(calibrate([FrictionTest(Ball("5 mm", "3 GPa"), 100.0, coefficient=0.2, uncertainty=0.01)]))
    law_of_yielding_pair = replace(laws[-1], exact_inputs=(("hardness", 2.0),))
    inputs_with_indent = Inputs.from_study(measured_study(hardness=2.0).with_changes({"contact.indent": "2 um"}))
    cases = [*((law, inputs) for law in (*laws, None)), (law_of_yielding_pair, inputs_with_indent)]
    return [caveat for law, pair_inputs in cases for caveat in find_interface_caveats(law, "film", pair_inputs)]


def test_troubleshooting_page_explains_every_status_of_results_without_a_coefficient():
    assert sorted(list_first_cells("status")) == sorted(f"`{status}`" for status in STATUSES if status != STATUS_OK)


def test_caveats_quoted_on_the_troubleshooting_page_are_printed_by_the_program(monkeypatch):
    monkeypatch.setattr(MeasuredBodySettings, "caveats", ())  # the files of `measured_study` do not exist
    texts = [
        caveat.text
        for caveat in (*list_result_caveats(), *list_scan_caveats(), *list_mirror_caveats(), *list_law_caveats())
    ]
    quotes = [quote for cell in list_first_cells("caveat") for quote in cell.split("; or: ")]
    assert len(quotes) > 20
    unknown_quotes = [
        quote
        for quote in quotes
        if not any(re.search(".+".join(map(re.escape, quote.split("…"))), text) for text in texts)
    ]
    assert unknown_quotes == []
