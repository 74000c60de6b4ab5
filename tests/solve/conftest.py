"""Fixtures for tests of stored results and of runs that compute a part of a result."""

import pytest
from stiction import run
from stiction.solve import runner
from support.generated_studies import TINY_STUDY


@pytest.fixture
def write_blocks_of_four_members(monkeypatch):
    """Limit the blocks of stored results to four members."""
    monkeypatch.setattr(runner, "choose_block_size", lambda study: 4)


@pytest.fixture(scope="session")
def uninterrupted_dataset():
    """Return the dataset of the study `TINY_STUDY`, computed in a single run. Tests must not change it."""
    return run(TINY_STUDY).dataset


@pytest.fixture
def computed_repetitions(monkeypatch):
    """Return a list to which each repetition is appended when it is computed."""
    numbers, sums = [], runner.compute_member_arrays

    def record_repetition(study, number, *record):
        numbers.append(number)
        return sums(study, number, *record)

    monkeypatch.setattr(runner, "compute_member_arrays", record_repetition)
    return numbers
