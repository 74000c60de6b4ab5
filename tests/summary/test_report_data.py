"""Tests of the data of a report, and of the description of a study."""

from pathlib import Path

import pytest
import xarray
from stiction import Result, Study, run
from stiction.study.interfaces import InterfaceSettings
from stiction.study.study import parse_study_of_dataset
from stiction.study.study_description import describe_study
from stiction.summary.report_data import collect_report_data, evaluate_generated_values
from support.generated_studies import SMALL_STUDY, empty_dataset
from support.studies_of_files import run_pair_of_maps


@pytest.fixture(scope="module")
def maps_dataset(tmp_path_factory):
    return run_pair_of_maps(tmp_path_factory.mktemp("maps"))


def test_description_of_a_generated_study_lists_its_differences_from_the_defaults():
    study = Study.named("quick").with_changes({"ensemble.repetitions": 3})
    description = describe_study(study)
    assert description.name == "quick"
    assert description.file_text == study.to_toml()
    assert dict(description.changed_settings) == {
        "surfaces.fractal_dimension.count": str(study.surfaces.fractal_dimensions().size),
        "ensemble.repetitions": "3",
    }
    assert describe_study(study.with_changes({"surfaces.points": 77})).name == "study"
    assert describe_study(Study()).changed_settings == []


def test_description_of_a_measured_study_contains_file_names_without_directories(maps_dataset):
    study = parse_study_of_dataset(maps_dataset)
    directory = str(Path(study.surfaces.upper.file).parent)
    description = describe_study(study)
    assert directory in study.to_toml()
    assert directory not in description.file_text
    assert description.name == "upper-maps.npy on lower-maps.npy"


def test_description_of_a_study_contains_no_directories_of_scans_or_interfaces(maps_dataset):
    study = parse_study_of_dataset(maps_dataset)
    surfaces = study.surfaces
    directory = str(Path(surfaces.upper.file).parent)
    upper = surfaces.upper.model_copy(update={"others": (surfaces.lower,)})
    interface = InterfaceSettings(file=f"{directory}/steel.csv", mu0=0.2, tau0="20..80 MPa")
    changes = {"friction.interface": interface.model_dump()}
    study = study.model_copy(update={"surfaces": surfaces.model_copy(update={"upper": upper})}).with_changes(changes)
    description = describe_study(study)
    assert study.to_toml().count(directory) == 4
    assert directory not in description.file_text
    assert 'interface = { file = "steel.csv", mu0' in description.file_text


def test_report_data_of_measured_surfaces_equal_the_values_of_the_result(maps_dataset):
    result = Result.of(maps_dataset)
    report_data = collect_report_data(result)
    assert report_data.num_members == report_data.num_solved == 4
    assert report_data.summary.points == result.summary().points
    assert report_data.cut_offs == [0.0]
    assert float(report_data.positions["load"]) == float(result.study.friction.load[0])
    assert (report_data.contact_picture, report_data.loading_cycle, report_data.height_factors) == (None, None, {})
    slopes = {"contact_slope_x": ("contact", [0.1, -0.1, 0.2]), "contact_slope_y": ("contact", [0.0, 0.1, 0.0])}
    picture = xarray.Dataset(slopes)
    data_with_picture = collect_report_data(result, picture)
    assert data_with_picture.contact_picture is picture
    assert data_with_picture.num_opposing_contacts == 2
    single_member = collect_report_data(Result.of(maps_dataset.isel(repetition=[0])))
    assert single_member.positions is None


def test_report_data_of_generated_surfaces_without_contact_contain_no_coefficients():
    report_data = collect_report_data(Result.of(empty_dataset(SMALL_STUDY)))
    assert report_data.loads.size == 0
    assert (report_data.contact_forces, report_data.onset) == (None, None)
    assert evaluate_generated_values(Result.of(empty_dataset(SMALL_STUDY))) is None
    assert report_data.dimensions.tolist() == SMALL_STUDY.surfaces.fractal_dimensions().tolist()


def test_report_data_of_generated_surfaces_contain_the_onset_of_the_study():
    changes = {"ensemble.repetitions": 2, "surfaces.points": 2000, "surfaces.fractal_dimension": [1.3, 1.4]}
    report_data = collect_report_data(run(Study.named("presliding").with_changes(changes)))
    assert report_data.onset.sizes["fractal_dimension"] == 2
    assert report_data.onset.sizes["load"] == 3
    assert report_data.contact_forces is not None
