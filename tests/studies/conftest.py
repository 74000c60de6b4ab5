"""Fixtures for tests of stores and of parts."""

import pytest
from stiction import run
from stiction.studies import runner
from support.generated_studies import TINY


@pytest.fixture
def blocks_of_four(monkeypatch):
    """Blocks of a result hold four members."""
    monkeypatch.setattr(runner, "choose_block_size", lambda study: 4)


@pytest.fixture(scope="session")
def undisturbed():
    """Result of `TINY`; tests must not change it."""
    return run(TINY).dataset


@pytest.fixture
def computed(monkeypatch):
    """List of the repetitions that are computed."""
    numbers, sums = [], runner.member_sums

    def record(study, number):
        numbers.append(number)
        return sums(study, number)

    monkeypatch.setattr(runner, "member_sums", record)
    return numbers
