"""Caveats about inputs: each caveat has a case that raises it and one that does not."""

import numpy as np
import pytest
from stiction import Profile, Surface, instrument_limit, pair, self_affine
from stiction.studies.input_caveats import FORM, HIGHEST_MU0, SPIKE, WHOLE_PART, find_input_caveats
from stiction.studies.measured_surfaces import MeasuredFile
from support.studies_of_files import pair_study
from support.synthetic_results import measured_study


@pytest.fixture(autouse=True)
def files_without_caveats(monkeypatch):
    """The files of `measured_study` do not exist; caveats of reading have their own tests."""
    monkeypatch.setattr(MeasuredFile, "caveats", ())


@pytest.fixture(scope="module")
def rough():
    return self_affine(1, hurst_exponent=0.8, rms=0.05, points=2000, spacing=0.05, longest_wavelength=5.0)


def texts(upper, lower, *, mu0=(0.2,), loads=()):
    return [caveat.text for caveat in find_input_caveats(upper, lower, measured_study(mu0=mu0), loads)]


def test_heights_beyond_the_length_are_a_caveat(rough):
    tall = Profile(rough.heights * 1000, spacing=rough.spacing)
    assert any(text.startswith("upper: heights span") for text in texts(tall, rough))
    slab = Surface(np.eye(8), spacing=1.0)
    assert texts(slab, slab) == []
    assert texts(Surface(10 * np.eye(8), spacing=1.0), slab) == ["upper: heights span 10 µm over 8 µm"]
    # Those that no scan has are a fault.
    tall = Profile(rough.heights * 1e6, spacing=rough.spacing)
    result = find_input_caveats(tall, rough, measured_study())
    assert [caveat.severity for caveat in result if "heights span" in caveat.text] == ["fault"]


def test_remaining_form_is_a_caveat(rough):
    x = np.linspace(-1, 1, 2000)
    for height, has_caveat in ((1.0, True), (0.01, False)):
        bowed = Profile(rough.heights + height * x**2, spacing=rough.spacing)
        assert any("lower: form (a parabola) is" in text for text in texts(rough, bowed)) == has_caveat
    assert 0 < FORM < 1
    bowed = Profile(rough.heights + x**2, spacing=rough.spacing)
    study = measured_study()
    study = study.with_changes({"surfaces.level": "quadratic"})  # which takes it off
    assert find_input_caveats(rough, bowed, study) == ()


def test_spikes_are_counted(rough):
    heights = rough.heights.copy()
    heights[[500, 1200]] += 2 * SPIKE * np.abs(np.diff(heights, 2)).max()
    message = texts(Profile(heights, spacing=rough.spacing), rough)
    assert [text for text in message if "as sharp as usual" in text] == [
        "upper: 6 points are more than 12 times as sharp as usual, and would come into contact first"
    ]


def test_caveat_of_both_surfaces_is_listed_once(rough):
    tall = Profile(rough.heights * 1000, spacing=rough.spacing)
    message = texts(tall, tall)
    assert len(message) == len(set(message))
    assert all(text.startswith("both scans: ") for text in message)


def test_huge_coefficients_and_loads_are_caveats(rough):
    assert texts(rough, rough, mu0=(HIGHEST_MU0,), loads=[0.9 * WHOLE_PART * 100 * rough.extent]) == []
    assert "μ0 = 30" in texts(rough, rough, mu0=(0.2, 30.0))[0]
    load = 1.1 * WHOLE_PART * 100 * rough.extent
    assert "above a tenth of E*" in texts(rough, rough, loads=[load])[0]


def test_noise_and_peaks_are_caveats_without_cutoff():
    rng = np.random.default_rng(5)
    created = self_affine(1, hurst_exponent=0.8, rms=0.05, points=4096, spacing=0.01, shortest_wavelength=0.5)
    noisy = Profile(created.heights + 2e-4 * rng.normal(size=4096), spacing=0.01)
    humming = Profile(created.heights + 5e-4 * np.sin(2 * np.pi * np.arange(4096) / 8), spacing=0.01)
    for body, word in ((noisy, "as for noise"), (humming, "has a line")):
        caveat = next(item for item in find_input_caveats(body, body, measured_study()) if word in item.text)
        limit = instrument_limit(body)
        assert caveat.cut_off == limit.cut_off < limit.noise < 0.6
        assert caveat.severity == ("fault" if limit.slope_fraction > 0.1 else "caution")
        vouched = measured_study().with_changes({"surfaces.vouched": True})
        assert not any(word in item.text for item in find_input_caveats(body, body, vouched))
    # A floor from which hardly any slope comes.
    faint = Profile(created.heights + 1e-5 * np.random.default_rng(1).normal(size=4096), spacing=0.01)
    assert instrument_limit(faint).reason == "noise floor"
    assert not any("like noise" in text for text in texts(faint, faint))
    assert any("of the mean square slope" in text for text in texts(noisy, noisy))


def test_cutoff_above_a_third_of_a_scan_is_no_cure():
    noise = Profile(0.1 * np.random.default_rng(2).normal(size=960), spacing=0.5)
    short = self_affine(3, points=200, spacing=0.5, hurst_exponent=0.7, rms=0.01, shortest_wavelength=5.0)
    cutoff = instrument_limit(noise).cut_off
    assert short.extent / 3 < cutoff < noise.extent / 3
    (cure,) = (item.cure for item in find_input_caveats(noise, short, measured_study()) if "noise" in item.text)
    assert "--cutoff '" not in cure
    assert "the longest cutoff of both scans is 33.3 µm" in cure
    with pytest.raises(ValueError, match=r"cutoff must be .*, 33.3333 µm, got"):
        pair(noise, short, load="10 MPa", mu0=0.2, effective_modulus="80 GPa", cutoff=f"{cutoff:g} um")


def test_wavelengths_below_the_tip_are_a_caveat():
    scan = self_affine(
        3, points=3000, spacing=0.01, hurst_exponent=0.7, rms=0.01, longest_wavelength=5.0, shortest_wavelength=0.05
    )
    common = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa"}
    study = pair_study(scan, scan, tip="20 um", **common)
    assert instrument_limit(scan, tip_radius=20.0).reason == "tip"
    # Without them it would be smoother still, and further from the surface that the tip smoothed.
    assert study.surfaces.cells()["cut_off"].tolist() == [0.0]
    (caveat,) = find_input_caveats(scan, scan, study)
    assert "does not resolve: the surface is steeper" in caveat.text
    assert instrument_limit(scan, tip_radius=20.0).slope_fraction > 0.1
    assert caveat.severity == "fault"  # an elastic answer has no limit
    plastic = study.with_changes({"contact.mechanics": "half-space", "contact.hardness": "2 GPa"})
    assert [item.severity for item in find_input_caveats(scan, scan, plastic)] == ["caution"]
    # With a tip too, the noise floor is evaluated with and without filtering.
    noisy = Profile(scan.heights + 1e-3 * np.random.default_rng(1).normal(size=3000), spacing=0.01)
    study = pair_study(noisy, noisy, tip="20 um", **common)
    assert study.surfaces.cells()["cut_off"].tolist() == [instrument_limit(noisy).cut_off, 0.0]
    result = find_input_caveats(noisy, noisy, study)
    assert [item.severity for item in result if "of the mean square slope" in item.text] == ["caution", "fault"]
    with pytest.raises(ValueError, match="tip"):
        pair_study(scan, scan, tip="20", **common)
