"""How generated pairs begin to slide: what a result keeps of each, and what is read off at a load."""

import re

import numpy as np
import pytest
from stiction import Study, contacts, open_result, pair_of, press, run
from stiction.mechanics.quantities import ONSET
from stiction.studies.evaluation import at_load
from stiction.studies.study import StudyError
from stiction.views.report import report_page
from stiction.views.text import quantities_text

SMALL = {
    "ensemble.repetitions": 4, "surfaces.points": 4000, "surfaces.fractal_dimension": [1.1, 1.4],
    "contact.approach": ["0 nm", "5 nm", "10 nm", "20 nm", "40 nm"],
}  # fmt: skip
AREAS = {
    "surfaces.kind": "surface", "surfaces.generator": "self-affine", "surfaces.shape": [48, 48],
    "surfaces.extent": ["4 um", "4 um"], "surfaces.shortest_wavelength": "0.6 um", "surfaces.fractal_dimension": [1.2],
    "surfaces.amplitude": ["20 nm"], "contact.direction": [30.0, 90.0], "contact.sliding": ["all", "opposing"],
    "ensemble.repetitions": 2, "contact.approach": ["5 nm", "20 nm"],
}  # fmt: skip
STRENGTHS = {"mu0": 0.3, "tau0": "20 MPa", "poisson_ratio": 0.25}


@pytest.fixture(scope="module")
def study():
    return Study.named("presliding").with_changes(SMALL | {"contact.onset": STRENGTHS})


@pytest.fixture(scope="module")
def result(study):
    return run(study).dataset


def test_onset_of_member_equals_its_curve(study, result):
    for index, dimension in ((0, 1.1), (3, 1.4)):
        upper, lower = pair_of(study, index, fractal_dimension=dimension, amplitude=0.1)
        steps = study.contact.steps()
        curve = press(upper, lower, steps, model=study.contact.model())
        own = result.sel(fractal_dimension=dimension, repetition=index).isel(amplitude=0)
        for place in np.flatnonzero(curve.contact_count):
            onset = curve.onset(place, mu0=0.3, tau0=0.02, steps=[0.5], poisson=0.25)
            assert float(own["tangential_stiffness"][place]) == pytest.approx(onset.stiffness, rel=1e-12)
            assert float(own["displacement_at_sliding"][place]) == pytest.approx(
                onset.displacement_at_sliding, rel=1e-12
            )
            assert float(own["fraction_slipped"][place]) == pytest.approx(onset.slipped_load[0], rel=1e-12)
    untouched = result["contact_count"].values == 0
    assert untouched.any()
    assert not any(result[name].values[untouched].any() for name in ONSET)


def test_sums_are_unchanged_by_onset(study, result):
    """They come by another way, pair by pair in place of whole families."""
    plain = run(study.with_changes({"contact.onset": None, "figures.draw": ["area"]})).dataset
    assert not set(ONSET) & set(plain.data_vars)
    for name in plain.data_vars:
        np.testing.assert_allclose(result[name], plain[name], rtol=1e-11, err_msg=name)


def test_onset_of_maps_uses_first_direction():
    study = Study.named("presliding").with_changes(AREAS | {"contact.onset": {"mu0": 0.4}})
    computed = run(study).dataset
    assert computed["displacement_at_sliding"].dims == ("fractal_dimension", "amplitude", "repetition", "approach")
    upper, lower = pair_of(study, 1, fractal_dimension=1.2, amplitude=0.02)
    curve = press(upper, lower, [0.02])
    for direction, same in ((30.0, True), (90.0, False)):
        stiffness = curve.onset(0, mu0=0.4, direction=direction, steps=[0.5]).stiffness
        assert (float(computed["tangential_stiffness"][0, 0, 1, 1]) == pytest.approx(stiffness, rel=1e-9)) == same


def test_onset_at_load_weighs_members_by_load(result):
    """Where a step is reached exactly, by the sums there."""
    step = result.isel(approach=3)
    normal = step["normal_elastic"] + 0.3 * step["normal_frictional"] + 0.02 * step["normal_adhesive"]
    for place in range(2):
        here = {"fractal_dimension": place, "amplitude": 0}
        load = float(normal.isel(here).mean())
        at = at_load(result, [load], mu0=0.3, tau0=0.02).isel(here | {"load": 0, "mu0": 0, "tau0": 0})
        weight = normal.isel(here).values / normal.isel(here).values.sum()
        for name in ("displacement_at_sliding", "fraction_slipped"):
            values = step[name].isel(here).values
            mean, lower, upper = at[name].values
            assert mean == pytest.approx(weight @ values, rel=1e-9)
            assert lower < mean < upper
        stiffness = step["tangential_stiffness"].isel(here).values.mean()
        assert float(at["tangential_stiffness"].sel(statistic="mean")) == pytest.approx(stiffness, rel=1e-9)


def test_displacement_at_sliding_is_proportional_to_deepest_overlap():
    study = Study.named("presliding").with_changes(SMALL | {"contact.onset": {"mu0": 0.4, "poisson_ratio": 0.0}})
    twice = study.with_changes({"contact.onset": {"mu0": 0.8, "poisson_ratio": 0.0}})
    one, two = run(study).dataset, run(twice).dataset
    np.testing.assert_allclose(two["displacement_at_sliding"], 2 * one["displacement_at_sliding"], rtol=1e-12)
    for name in ("fraction_slipped", "tangential_stiffness"):
        np.testing.assert_allclose(two[name], one[name], rtol=1e-9)
    # With no ratio of stiffnesses the creep is mu0 times the deepest overlap, upwards.
    upper, lower = pair_of(study, 2, fractal_dimension=1.4, amplitude=0.1)
    listed = contacts(upper, lower, 0.02, model=study.contact.model())
    deepest = (listed.overlap * listed.normal[:, 2]).max()
    creep = one["displacement_at_sliding"].sel(fractal_dimension=1.4, repetition=2, approach=0.02).item()
    assert creep == pytest.approx(0.4 * deepest, rel=1e-9)


def test_table_figure_and_report_show_onset(study, tmp_path):
    run(study, store=tmp_path / "result")
    result = open_result(tmp_path / "result")
    creep = "creep before sliding at mu0 = 0.3, tau0 = 20 MPa (um)"
    assert {creep, f"{creep}: lower", "tangential stiffness at rest (mN/um)"} <= set(result.to_dataframe().columns)
    text = " ".join(quantities_text(at_load(result.source, [1e-3]).isel(fractal_dimension=0), study).split())
    assert "creep before sliding at μ0 = 0.3, τ0 = 20 MPa (nm)" in text
    assert "load that slips at half of sliding at μ0 =" in text
    assert result.figures() == ["onset"]
    panels = result.figure("onset").axes
    assert [panel.get_ylabel() for panel in panels] == [
        "pre-sliding displacement (nm)", "slip at half the sliding load (%)", "tangential stiffness (mN/µm)",
    ]  # fmt: skip
    assert all(np.isfinite(line.get_ydata()).any() for line in panels[0].get_lines()[::2])
    page = report_page(result.source)
    assert "How the pairs begin to slide" in page
    assert "How the pairs begin to slide" not in report_page(run(Study.named("quick").with_changes(SMALL)))


BAD = [
    ({"contact.onset": {"mu0": 0.0}}, "mu0 and tau0 must not both be 0"),
    ({"contact.onset": {"tau0": "3 mN"}}, r"contact\.onset\.tau0: .*pressure"),
    ({"contact.onset": {"load": 1.0}}, r"contact\.onset\.load: unknown key"),
    ({"contact.onset": {}, "contact.law": "hertz-cylinder"}, "must not be given with cylinders"),
    ({"contact.mechanics": "half-space", "contact.onset": {"mu0": 0.4}}, "belongs to asperities of generated surfaces"),
]


@pytest.mark.parametrize(("changes", "words"), BAD)
def test_study_rejects_bad_onset(changes, words):
    with pytest.raises(StudyError, match=words) as refused:
        Study().with_changes(changes)
    assert not re.search(r"Traceback|\n.*\n.*\n", str(refused.value))


def test_onset_figure_requires_onset():
    with pytest.raises(StudyError, match=r"needs contact\.onset"):
        Study().with_changes({"figures.draw": ["onset"]})
