"""Datasets and a browser for the tests of reports and figures."""

import pytest
from stiction.study.study import parse_study_of_dataset
from support import browser
from support.studies_of_files import run_pair_of_maps, run_pair_of_profiles


@pytest.fixture(scope="session")
def generated_dataset(small_result):
    return small_result


@pytest.fixture(scope="session")
def maps_dataset(tmp_path_factory):
    return run_pair_of_maps(tmp_path_factory.mktemp("maps"))


@pytest.fixture(scope="session")
def dataset_with_interface_for_opposing_contacts(maps_dataset):
    """Return the result of two maps with an interface that was fitted with friction at opposing contacts only."""
    interface = {"file": "film.csv", "mu0": "0.3", "tau0": "0 MPa", "sliding": "opposing"}
    study = parse_study_of_dataset(maps_dataset).with_changes({"friction.interface": interface})
    return maps_dataset.assign_attrs(study=study.to_toml())


@pytest.fixture(scope="session")
def profiles_dataset(tmp_path_factory):
    return run_pair_of_profiles(tmp_path_factory.mktemp("lines"))


def _omit_report_panels(patch):
    patch.setattr("stiction.views.report.pictures.draw_panels", lambda _: {True: "", False: ""})


@pytest.fixture(scope="module")
def no_report_panels():
    """Omit the figures of reports, for faster tests of their numbers and texts."""
    with pytest.MonkeyPatch.context() as patch:
        _omit_report_panels(patch)
        yield


@pytest.fixture
def omit_report_panels(monkeypatch):
    """Omit the figures of reports during a test, for faster tests of their numbers and texts."""
    _omit_report_panels(monkeypatch)


@pytest.fixture(scope="module")
def driver(tmp_path_factory):
    with browser.start_browser(tmp_path_factory.mktemp("profile")) as driver:
        yield driver
