"""Test the keys of each kind of study, and studies stored by earlier versions."""

import pickle
from pathlib import Path

import pytest
from stiction import HertzCylinder, HertzSphere, JacksonGreen, Study
from stiction.solve.store import STUDY_FILE
from stiction.study.contact_settings import CONTACT_SETTINGS_CLASSES, HertzCylinderSettings, JacksonGreenSettings
from stiction.study.study import FRICTION_SETTINGS_CLASSES, parse_study
from stiction.study.values import StudyError

STORED_STUDIES = {
    path.stem: path.read_text("utf-8") for path in (Path(__file__).parent / "stored_studies").glob("*.toml")
}
"""Texts of studies that version 0.1.0.dev0 stored, by the kind of their contact model."""


@pytest.mark.parametrize("case_name", STORED_STUDIES)
def test_study_of_each_kind_is_unchanged_by_writing_and_reading(case_name):
    study = parse_study(STORED_STUDIES[case_name], "stored")
    assert study.contact.place.removeprefix("the ").replace(" ", "_") == case_name
    assert study.to_toml().strip() == STORED_STUDIES[case_name].strip()
    assert pickle.loads(pickle.dumps(study)) == study


def test_stored_study_with_a_key_of_another_contact_model_is_rejected():
    text = STORED_STUDIES["half-space_of_measured_areas"].replace("[friction]", 'law = "hertz-sphere"\n\n[friction]')
    with pytest.raises(StudyError) as error_info:
        parse_study(text, STUDY_FILE)
    assert error_info.value.faults == (
        (
            "contact.law",
            'belongs to asperities, not to the half-space of measured areas; the key requires mechanics = "asperities"',
        ),
    )  # fmt: skip


def test_contact_models_have_separate_classes_of_contact_settings():
    cases = [case for cases in CONTACT_SETTINGS_CLASSES.values() for case in cases.values()]
    assert len(set(cases)) == len({case.place for case in cases}) == 8
    for bodies, cases_by_model in CONTACT_SETTINGS_CLASSES.items():
        for model, case in cases_by_model.items():
            assert case.model_fields["mechanics"].default == model
            assert case.place.endswith(bodies)
    assert len({case.place for case in FRICTION_SETTINGS_CLASSES}) == len(FRICTION_SETTINGS_CLASSES)


@pytest.mark.parametrize(
    ("changes", "study_key", "message"),
    [
        ({"contact.hardness": "1 GPa"}, "contact.hardness", "belongs to the half-space, not to asperities of"),
        ({"contact.materials": ["a", "b"]}, "contact.materials", "belongs to measured surfaces, not to asperities of"),
        ({"contact.load": ["1 mN"]}, "contact.load", "belongs to measured surfaces and the half-space of generated"),
        ({"friction.wait": ["1 h"]}, "friction.wait", "belongs to measured surfaces, not to asperities of generated"),
        ({"friction.load": ["1 mN"]}, "friction.load", "belongs to measured surfaces and the half-space of generated"),
        ({"surfaces.press": "lines"}, "surfaces.press", "belongs to areas of measured maps and lines of measured"),
        (
            {"surfaces.generator": "self-affine"},
            "surfaces.generator",
            "belongs to Weierstrass-Mandelbrot surfaces and self-affine surfaces, not to fractal profiles; the key "
            'requires kind = "surface"',
        ),
        ({"contact.law": {"name": "jackson-green"}}, "contact.law.yield_strength", "must be given"),
    ],
)
def test_error_about_a_key_of_another_kind_of_study_names_that_kind(changes, study_key, message):
    with pytest.raises(StudyError) as error_info:
        Study().with_changes(changes)
    assert error_info.value.faults[0][0] == study_key
    assert error_info.value.faults[0][1].startswith(message)


@pytest.mark.parametrize(
    ("law", "entry"),
    [
        (HertzSphere(), "hertz-sphere"),
        (HertzCylinder(width=2.0), HertzCylinderSettings(name="hertz-cylinder", width="2 um")),
        (
            JacksonGreen(0.5, 0.3),
            JacksonGreenSettings(name="jackson-green", yield_strength="0.5 GPa", poisson_ratio=0.3),
        ),
    ],
)
def test_contact_law_is_stored_as_a_toml_table_of_the_study(law, entry):
    study = Study().with_changes({"contact.law": entry if isinstance(entry, str) else entry.model_dump()})
    assert study.contact.law == entry
    assert type(study.contact.contact_model().law) in (str, type(law))
    if not isinstance(entry, str):
        assert isinstance(entry, (HertzCylinderSettings, JacksonGreenSettings))
        assert entry.law() == law
        assert pickle.loads(pickle.dumps(entry)) == entry
