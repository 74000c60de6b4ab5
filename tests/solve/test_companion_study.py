"""Test companion studies, which are stored in subdirectories of a result.

The time for missing members is announced, and members of another study are removed.
"""

from __future__ import annotations

import pytest
from stiction import pair
from stiction.companions.height_scale import scale_study_heights
from stiction.solve.companion_study import CompanionStudy
from stiction.solve.executors import executor_or_thread_pool
from stiction.solve.member_solution import estimate_member_time
from stiction.solve.runner import compute_missing_blocks
from support.rough_surfaces import rough_maps

pytestmark = pytest.mark.usefixtures("no_contact_pictures")

PAIR_OPTIONS = {"load": "20 MPa", "mu0": 0.2, "effective_modulus": "80 GPa", "shifts": 3, "onset": 0}


@pytest.fixture(scope="module")
def study_and_scaled_study():
    """Return a study of two maps, and a copy of it with doubled heights."""
    study = pair(*rough_maps(7, points=48, rms=0.02, shortest_wavelength=0.6), **PAIR_OPTIONS).study
    return study, scale_study_heights(study, 2.0, "both")


@pytest.fixture
def thread_pool():
    with executor_or_thread_pool(None) as executor:
        yield executor


def test_companion_study_prints_the_estimated_time_of_its_missing_pairs_only(
    study_and_scaled_study, thread_pool, tmp_path
):
    study, _ = study_and_scaled_study
    announced_times = []
    compute_missing_blocks(study, tmp_path, part=(1, 3), executor=thread_pool)
    CompanionStudy(study, tmp_path).complete(thread_pool, announce_time=announced_times.append)
    assert announced_times == [2 * estimate_member_time(study)]
    CompanionStudy(study, tmp_path).complete(thread_pool, announce_time=announced_times.append)
    assert len(announced_times) == 1


def test_changed_companion_study_replaces_the_stored_pairs_of_the_former_study(
    study_and_scaled_study, thread_pool, tmp_path
):
    study, study_of_doubled_heights = study_and_scaled_study
    announced_times = []
    CompanionStudy(study, tmp_path).complete(thread_pool)
    result = CompanionStudy(study_of_doubled_heights, tmp_path).complete(
        thread_pool, announce_time=announced_times.append
    )
    assert announced_times == [3 * estimate_member_time(study_of_doubled_heights)]
    assert result.members.tolist() == [0, 1, 2]
    assert result.study.surfaces.upper.height_factor == 2.0


def test_companion_study_is_opened_only_if_all_its_pairs_are_stored(study_and_scaled_study, thread_pool, tmp_path):
    study, study_of_doubled_heights = study_and_scaled_study
    companion_study = CompanionStudy(study, tmp_path)
    assert companion_study.open() is None
    compute_missing_blocks(study, tmp_path, part=(1, 3), executor=thread_pool)
    assert companion_study.open() is None
    assert companion_study.open(allow_unfinished=True).members.size == 1
    companion_study.complete(thread_pool)
    assert companion_study.open().members.size == 3
    assert CompanionStudy(study_of_doubled_heights, tmp_path).open() is None


def test_companion_study_has_mu0_and_tau0_of_its_main_study(study_and_scaled_study, thread_pool, tmp_path):
    study, _ = study_and_scaled_study
    CompanionStudy(study, tmp_path).complete(thread_pool)
    other_friction = study.with_changes({"friction.mu0": [0.7]})
    assert CompanionStudy(other_friction, tmp_path).open().study.friction.mu0 == (0.7,)


def test_damaged_companion_study_is_not_opened(study_and_scaled_study, thread_pool, tmp_path):
    study, _ = study_and_scaled_study
    CompanionStudy(study, tmp_path).complete(thread_pool)
    (tmp_path / "study.toml").write_text("no study", encoding="utf-8")
    assert CompanionStudy(study, tmp_path).open() is None
