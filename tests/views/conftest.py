"""Datasets and a browser for the tests of reports and figures."""

import pytest
from support import browser
from support.studies_of_files import run_pair_of_maps, run_pair_of_profiles


@pytest.fixture(scope="session")
def generated_dataset(small_result):
    return small_result


@pytest.fixture(scope="session")
def maps_dataset(tmp_path_factory):
    return run_pair_of_maps(tmp_path_factory.mktemp("maps"))


@pytest.fixture(scope="session")
def profiles_dataset(tmp_path_factory):
    return run_pair_of_profiles(tmp_path_factory.mktemp("lines"))


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with browser.start_browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver
