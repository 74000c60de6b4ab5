"""Tests of mated faces, whose gap is 0 without a displacement and which slide downhill if displaced up a slope."""

import numpy as np
import pytest
from stiction import Profile, Surface, pair, self_affine, self_affine_surface

pytestmark = pytest.mark.usefixtures("no_companion_files")


@pytest.fixture(scope="module")
def mated_faces():
    lower = self_affine_surface(5, side="lower", hurst_exponent=0.8, rms=6.0, shape=(64, 64), spacing=15.625)
    return Surface(-lower.heights[::-1], spacing=lower.spacing), lower


def press_mated_faces(faces, offset, **options):
    options = {"load": "1 MPa", "young": "30 GPa", "poisson": 0.25, "onset": 0, "hardness": "1 GPa"} | options
    return pair(*faces, positions=[f"{offset},0 um"], direction=[0, 90, 180, 270], **options)


@pytest.mark.parametrize("hardness", ["1 GPa", "0.8..1.2 GPa", None])
def test_mated_faces_are_in_complete_contact(hardness):
    heights = np.random.default_rng(1).integers(-3, 4, size=(16, 16)) * 1.0
    faces = Surface(heights.mean() - heights[::-1], spacing=3125.0), Surface(heights - heights.mean(), spacing=3125.0)
    result = press_mated_faces(faces, "0 um", mu0=0.6, tau0="1 MPa", hardness=hardness, level="mean")
    point = result.at()
    assert (point["rms_gradient"].sel(statistic="mean") == 0).all()
    assert (point["contact_status"] == "complete").all()
    # In complete contact, the coefficient is mu0 plus the ratio of tau0 to the nominal pressure.
    assert result.value == pytest.approx(0.6 + 1.0 / 1.0, rel=1e-3)


def test_motion_at_a_negative_tangential_load_has_no_friction_coefficient(mated_faces):
    result = press_mated_faces(mated_faces, "15.625 um", mu0=0.2)
    friction = result.at().sel(sliding="all").squeeze(drop=True)
    coefficient = friction["friction_coefficient"].sel(statistic="mean")
    assert friction["status"].sel(direction=180).item() == "downhill"
    assert coefficient.sel(direction=0) > 0.3
    assert coefficient.sel(direction=180).isnull()
    assert friction["friction_by_axis"].sel(axis=0.0).isnull().all()
    assert friction["friction_by_axis"].sel(axis=90.0, statistic="mean") > 0
    assert (friction["spread_low"] >= 0).all()


def test_mean_coefficient_is_not_reported_if_the_slider_moves_downhill_in_one_direction(mated_faces):
    result = press_mated_faces(mated_faces, "15.625 um", mu0=0.2)
    assert np.isnan(result.value)
    assert result.assessment == "Do not quote"
    (point,) = result.summary().points
    assert point.status == "downhill"
    assert np.isnan(point.rules[0].by_direction[180.0].value)
    assert point.rules[1].value > 0  # friction only at opposing contacts is never negative


def test_result_for_a_direction_that_leads_downhill_has_no_friction_coefficient(mated_faces):
    options = {"direction": 180, "mu0": 0.2, "load": "1 MPa", "young": "30 GPa", "poisson": 0.25, "onset": 0}
    point = pair(*mated_faces, positions=["15.625 um,0 um"], **options).at().sel(sliding="all")
    assert (point["status"] == "downhill").all()
    assert point["friction_coefficient"].isnull().all()
    assert point["mean_friction"].isnull().all()


def test_unmated_faces_with_small_mu0_have_a_coefficient_even_if_a_direction_leads_downhill():
    """Check that friction is reported although, in one direction, its mean over all positions is below 0 by chance."""
    faces = [
        self_affine_surface(7, side=side, hurst_exponent=0.8, rms=0.05, shape=(96, 96), spacing=0.1)
        for side in ("upper", "lower")
    ]
    result = pair(*faces, load="10 MPa", effective_modulus="80 GPa", mu0=0.002, shifts=8, onset=0)
    assert 0 <= result.value < 0.05


def test_mated_maps_add_a_caveat_unless_their_mating_position_is_given(mated_faces):
    options = {"load": "1 MPa", "young": "30 GPa", "poisson": 0.25, "onset": 0, "hardness": "1 GPa", "mu0": 0.6}
    options["mechanics"], options["cutoff"] = "half-space", "none"

    def list_caveat_texts(*faces, **more):
        return [caveat.text for caveat in pair(*faces, **options | more).input_caveats]

    text = "the faces fit into each other, but the result is a mean over positions at which they do not"
    assert text in list_caveat_texts(*mated_faces, shifts=2)
    assert text not in list_caveat_texts(*mated_faces, positions=["0 um,0 um"])
    unrelated_face = self_affine_surface(6, hurst_exponent=0.8, rms=6.0, shape=(64, 64), spacing=15.625)
    assert text not in list_caveat_texts(mated_faces[0], unrelated_face, shifts=2)
    assert text not in list_caveat_texts(unrelated_face, unrelated_face, shifts=2)


def test_pair_of_mated_profiles_has_a_caveat_about_mated_faces(mated_faces):
    options = {"load": "1 MPa", "effective_modulus": "16 GPa", "mu0": 0.6, "onset": 0, "cutoff": "none"}
    lower = self_affine_surface(5, hurst_exponent=0.8, rms=6.0, shape=(4, 256), spacing=15.625).row(0)
    for faces, more in (((Profile(-lower.heights, spacing=15.625), lower), {}), (mated_faces, {"lines": 2})):
        texts = [caveat.text for caveat in pair(*faces, **options | more).input_caveats]
        assert any("the faces fit into each other" in text for text in texts)


def test_maps_generated_from_two_spectra_have_no_caveat_about_mated_faces():
    profile = self_affine(5, hurst_exponent=0.8, rms=0.02, points=64, spacing=0.1, longest_wavelength=3.2)
    options = {"load": "1 MPa", "effective_modulus": "10 GPa", "mu0": 0.6, "onset": 0, "mechanics": "asperities"}
    caveats = pair(profile, profile, lay="isotropic", **options).input_caveats
    assert not any("fit into each other" in caveat.text for caveat in caveats)
