"""What tests of stores and of parts share."""

import pytest
from stiction.studies import runner


@pytest.fixture
def computed(monkeypatch):
    """The repetitions that are computed."""
    numbers, sums = [], runner.member_sums

    def record(study, number):
        numbers.append(number)
        return sums(study, number)

    monkeypatch.setattr(runner, "member_sums", record)
    return numbers
