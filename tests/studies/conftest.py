"""What tests of stores and of parts share."""

import pytest
from stiction import run
from stiction.studies import runner
from support.generated_studies import TINY


@pytest.fixture
def blocks_of_four(monkeypatch):
    """Blocks of a result hold four members."""
    monkeypatch.setattr(runner, "block_size", lambda study: 4)


@pytest.fixture(scope="session")
def undisturbed():
    """The result of `TINY`; nothing may change it."""
    return run(TINY).dataset


@pytest.fixture
def computed(monkeypatch):
    """The repetitions that are computed."""
    numbers, sums = [], runner.member_sums

    def record(study, number):
        numbers.append(number)
        return sums(study, number)

    monkeypatch.setattr(runner, "member_sums", record)
    return numbers
