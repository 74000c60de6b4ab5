"""Test the onset of sliding in studies of generated surfaces: stored quantities, and their values at given loads."""

import re

import numpy as np
import pytest
from stiction import Study, contacts, open_result, pair_of, press, run
from stiction.evaluate.at_load import at_load
from stiction.mechanics.quantities import ONSET_QUANTITIES
from stiction.study.study import StudyError
from stiction.views.layout import format_paragraph
from stiction.views.quantities import quantities_paragraph
from stiction.views.report import report_page
from support.command import disable_drawing

PROFILE_STUDY_CHANGES = {
    "ensemble.repetitions": 4, "surfaces.points": 4000, "surfaces.fractal_dimension": [1.1, 1.4],
    "contact.approach": ["0 nm", "5 nm", "10 nm", "20 nm", "40 nm"],
}  # fmt: skip
SURFACE_STUDY_CHANGES = {
    "surfaces.kind": "surface", "surfaces.generator": "self-affine", "surfaces.shape": [48, 48],
    "surfaces.extent": ["4 um", "4 um"], "surfaces.shortest_wavelength": "0.6 um", "surfaces.fractal_dimension": [1.2],
    "surfaces.amplitude": ["20 nm"], "contact.direction": [30.0, 90.0], "contact.sliding": ["all", "opposing"],
    "ensemble.repetitions": 2, "contact.approach": ["5 nm", "20 nm"],
}  # fmt: skip
ONSET_OPTIONS = {"mu0": 0.3, "tau0": "20 MPa", "poisson_ratio": 0.25}


@pytest.fixture(scope="module")
def study():
    return Study.named("presliding").with_changes(PROFILE_STUDY_CHANGES | {"contact.onset": ONSET_OPTIONS})


@pytest.fixture(scope="module")
def result(study):
    return run(study).dataset


def test_stored_onset_of_sliding_of_a_pair_equals_the_onset_of_its_load_curve(study, result):
    for index, dimension in ((0, 1.1), (3, 1.4)):
        upper, lower = pair_of(study, index, fractal_dimension=dimension, amplitude=0.1)
        steps = study.contact.loading_steps()
        curve = press(upper, lower, steps, model=study.contact.contact_model())
        member = result.sel(fractal_dimension=dimension, repetition=index).isel(amplitude=0)
        for step in np.flatnonzero(curve.contact_count):
            onset = curve.onset(step, mu0=0.3, tau0=0.02, steps=[0.5], poisson=0.25)
            assert float(member["tangential_stiffness"][step]) == pytest.approx(onset.stiffness, rel=1e-12)
            assert float(member["displacement_at_sliding"][step]) == pytest.approx(
                onset.displacement_at_sliding, rel=1e-12
            )
            assert float(member["fraction_slipped"][step]) == pytest.approx(onset.slipped_load[0], rel=1e-12)
    has_no_contact = result["contact_count"].values == 0
    assert has_no_contact.any()
    assert not any(result[name].values[has_no_contact].any() for name in ONSET_QUANTITIES)


def test_computing_the_onset_of_sliding_leaves_other_results_of_a_study_unchanged(study, result):
    """With an onset, each pair is computed alone; otherwise pairs of several dimensions are computed together."""
    dataset_without_onset = run(study.with_changes({"contact.onset": None, "figures.draw": ["area"]})).dataset
    assert not set(ONSET_QUANTITIES) & set(dataset_without_onset.data_vars)
    for name in dataset_without_onset.data_vars:
        np.testing.assert_allclose(result[name], dataset_without_onset[name], rtol=1e-11, err_msg=name)


def test_onset_of_sliding_of_generated_maps_is_computed_in_the_first_direction():
    study = Study.named("presliding").with_changes(SURFACE_STUDY_CHANGES | {"contact.onset": {"mu0": 0.4}})
    dataset = run(study).dataset
    assert dataset["displacement_at_sliding"].dims == ("fractal_dimension", "amplitude", "repetition", "approach")
    upper, lower = pair_of(study, 1, fractal_dimension=1.2, amplitude=0.02)
    curve = press(upper, lower, [0.02])
    for direction, is_equal in ((30.0, True), (90.0, False)):
        stiffness = curve.onset(0, mu0=0.4, direction=direction, steps=[0.5]).stiffness
        assert (float(dataset["tangential_stiffness"][0, 0, 1, 1]) == pytest.approx(stiffness, rel=1e-9)) == is_equal


def test_onset_displacement_of_generated_surfaces_is_averaged_over_pairs_weighted_by_normal_load(result):
    """Compare with means at a solved approach, weighted by the normal load of each member."""
    result_at_step = result.isel(approach=3)
    normal_loads = (
        result_at_step["normal_elastic"]
        + 0.3 * result_at_step["normal_frictional"]
        + 0.02 * result_at_step["normal_adhesive"]
    )
    for dimension_index in range(2):
        selection = {"fractal_dimension": dimension_index, "amplitude": 0}
        load = float(normal_loads.isel(selection).mean())
        point = at_load(result, [load], mu0=0.3, tau0=0.02).isel(selection | {"load": 0, "mu0": 0, "tau0": 0})
        weight = normal_loads.isel(selection).values / normal_loads.isel(selection).values.sum()
        for name in ("displacement_at_sliding", "fraction_slipped"):
            values = result_at_step[name].isel(selection).values
            mean, lower, upper = point[name].values
            assert mean == pytest.approx(weight @ values, rel=1e-9)
            assert lower < mean < upper
        stiffness = result_at_step["tangential_stiffness"].isel(selection).values.mean()
        assert float(point["tangential_stiffness"].sel(statistic="mean")) == pytest.approx(stiffness, rel=1e-9)


def test_displacement_at_sliding_is_mu0_times_the_largest_overlap():
    study = Study.named("presliding").with_changes(
        PROFILE_STUDY_CHANGES | {"contact.onset": {"mu0": 0.4, "poisson_ratio": 0.0}}
    )
    doubled_study = study.with_changes({"contact.onset": {"mu0": 0.8, "poisson_ratio": 0.0}})
    dataset, doubled_dataset = run(study).dataset, run(doubled_study).dataset
    np.testing.assert_allclose(
        doubled_dataset["displacement_at_sliding"], 2 * dataset["displacement_at_sliding"], rtol=1e-12
    )
    for name in ("fraction_slipped", "tangential_stiffness"):
        np.testing.assert_allclose(doubled_dataset[name], dataset[name], rtol=1e-9)
    # With a Poisson ratio of 0, the pre-sliding displacement is mu0 times the largest vertical overlap.
    upper, lower = pair_of(study, 2, fractal_dimension=1.4, amplitude=0.1)
    contact_list = contacts(upper, lower, 0.02, model=study.contact.contact_model())
    largest_overlap = (contact_list.overlap * contact_list.normal[:, 2]).max()
    displacement = dataset["displacement_at_sliding"].sel(fractal_dimension=1.4, repetition=2, approach=0.02).item()
    assert displacement == pytest.approx(0.4 * largest_overlap, rel=1e-9)


def test_onset_of_sliding_appears_in_table_and_text_and_figure_and_report(study, tmp_path):
    run(study, store=tmp_path / "result")
    result = open_result(tmp_path / "result")
    column = "pre-sliding displacement at mu0 = 0.3, tau0 = 20 MPa (um)"
    assert {column, f"{column}: lower", "initial tangential stiffness (mN/um)"} <= set(result.to_dataframe().columns)
    text = " ".join(format_paragraph(quantities_paragraph(result.summary(1e-3).points[:1])).split())
    assert "pre-sliding displacement at μ0 = 0.3, τ0 = 20 MPa" in text
    assert "load that slips at half of sliding at μ0 =" in text
    assert result.figures() == ["onset"]
    panels = result.figure("onset").axes
    assert [panel.get_ylabel() for panel in panels] == [
        "pre-sliding displacement (nm)", "slip at half the sliding load (%)", "tangential stiffness (mN/µm)",
    ]  # fmt: skip
    assert all(np.isfinite(line.get_ydata()).any() for line in panels[0].get_lines()[::2])
    report = report_page(result.source)
    assert "Onset of sliding against fractal dimension" in report
    with disable_drawing():
        report_without_onset = report_page(run(Study.named("quick").with_changes(PROFILE_STUDY_CHANGES)))
    assert "Onset of sliding against fractal dimension" not in report_without_onset


REJECTED_STUDY_CHANGE_CASES = [
    ({"contact.onset": {"mu0": 0.0}}, "mu0 and tau0 must not both be 0"),
    ({"contact.onset": {"tau0": "3 mN"}}, r"contact\.onset\.tau0: .*pressure"),
    ({"contact.onset": {"load": 1.0}}, r"contact\.onset\.load: unknown key"),
    ({"contact.onset": {}, "contact.law": "hertz-cylinder"}, 'must not be given with the law "hertz-cylinder"'),
    ({"contact.mechanics": "half-space", "contact.onset": {"mu0": 0.4}}, "belongs to asperities of generated surfaces"),
]


@pytest.mark.parametrize(("changes", "pattern"), REJECTED_STUDY_CHANGE_CASES)
def test_study_rejects_invalid_onset_settings(changes, pattern):
    with pytest.raises(StudyError, match=pattern) as error_info:
        Study().with_changes(changes)
    assert not re.search(r"Traceback|\n.*\n.*\n", str(error_info.value))


def test_onset_figure_requires_a_study_with_onset_settings():
    with pytest.raises(StudyError, match=r"needs contact\.onset"):
        Study().with_changes({"figures.draw": ["onset"]})
