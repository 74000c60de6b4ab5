"""What tests of stores and of parts share."""

import pytest
from stiction.studies import tasks


@pytest.fixture
def computed(monkeypatch):
    """The repetitions that are computed."""
    numbers, sums = [], tasks.member_sums

    def record(study, number):
        numbers.append(number)
        return sums(study, number)

    monkeypatch.setattr(tasks, "member_sums", record)
    return numbers
