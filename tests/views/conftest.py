"""Results for the tests of reports and figures."""

import pytest
from support import browser
from support.measured_studies import lines_result, maps_result


@pytest.fixture(scope="session")
def result(small_result):
    return small_result


@pytest.fixture(scope="session")
def maps(tmp_path_factory):
    return maps_result(tmp_path_factory.mktemp("maps"))


@pytest.fixture(scope="session")
def lines(tmp_path_factory):
    return lines_result(tmp_path_factory.mktemp("lines"))


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with browser.browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver
