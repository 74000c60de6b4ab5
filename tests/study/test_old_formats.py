"""Test studies in the format of earlier versions, which had a section `[known]`."""

import tomllib
from pathlib import Path

import pytest
from stiction import __version__, material, pair, self_affine_surface
from stiction._units import quantity
from stiction.study.inputs import Inputs, find_interface
from stiction.study.study import parse_study
from stiction.study.values import StudyError

OLD_STUDY_TEXTS = {
    path.stem: path.read_text("utf-8") for path in (Path(__file__).parent / "old_studies").glob("*.toml")
}
OLD_STUDY_OF_MATERIALS = OLD_STUDY_TEXTS["materials"]
FILM_NAME = "MoS2 on bearing steel, dry air"


def parse_old_study(known="", contact="", friction="mu0 = [0.2]"):
    """Parse a study in the old format after replacing lines in `[known]`, `[contact]` and `[friction]`."""
    text = f"""{OLD_STUDY_OF_MATERIALS[: OLD_STUDY_OF_MATERIALS.index("[contact]")]}
[contact]
mechanics = "half-space"
{contact}

[friction]
{friction}
load = ["0.0324 mN"]

[known]
{known}
"""
    return parse_study(text, "old")


@pytest.mark.parametrize("name", OLD_STUDY_TEXTS)
def test_inputs_in_a_study_file_of_the_old_format_keep_the_original_central_values(name):
    study, tables = parse_study(OLD_STUDY_TEXTS[name], "old"), tomllib.loads(OLD_STUDY_TEXTS[name])
    contact = tables["contact"]
    assert study.contact.effective_modulus == float(quantity(contact["effective_modulus"], "pressure"))
    assert study.contact.compliance_share == contact["compliance_share"]
    assert study.contact.hardness == float(quantity(contact["hardness"], "pressure"))
    assert study.contact.junction_growth == contact.get("junction_growth")
    assert study.friction.mu0 == tuple(tables["friction"]["mu0"])
    assert "[known]" not in study.to_toml()
    assert parse_study(study.to_toml(), "new") == study


def test_study_file_of_the_old_format_takes_input_ranges_from_material_names():
    study = parse_study(OLD_STUDY_OF_MATERIALS, "old")
    inputs = Inputs.from_study(study)
    brass = material("brass")
    for name, value in (("hardness", brass.hardness), ("young_lower", brass.young_modulus)):
        estimate = inputs.uncertain[name].estimate
        assert (estimate.low, estimate.high) == (value.low, value.high)
    assert inputs.entries["hardness"].label == "the hardness of the brass"
    assert inputs.entries["junction_growth"].text == "0..27"
    assert study.friction.creep.text == "0.02..0.05"


@pytest.mark.parametrize(("contact", "known", "text"), [
    ('hardness = "1.269 GPa"', 'hardness = "120 HV ± 10 %"', "120 HV ± 10 %"),
    ('hardness = "2 GPa"', 'hardness = "2 GPa"', "2 GPa"), ('hardness = "2 GPa"', "", "2 GPa"),
    ('hardness = "1.1 GPa"', 'hardness = "1 GPa ± 10 %"', "1.1 GPa (1 GPa ± 10 %)"),
    ('hardness = "1 GPa"\nmaterials = ["steel", "brass"]', "", "1 GPa"),
])  # fmt: skip
def test_hardness_in_a_study_file_of_the_old_format_keeps_the_original_range(contact, known, text):
    assert parse_old_study(known, contact).contact.hardness.text == text


def test_effective_modulus_of_an_old_study_keeps_the_range_of_the_modulus():
    study = parse_old_study(
        'effective_modulus = "80 GPa ± 5 %"', 'effective_modulus = "80 GPa"\ncompliance_share = 0.3'
    )
    assert (study.contact.effective_modulus.text, study.contact.compliance_share) == ("80 GPa ± 5 %", 0.3)


def test_young_moduli_of_an_old_study_replace_the_effective_modulus():
    modulus = 1 / ((1 - 0.3**2) / 200 + (1 - 0.25**2) / 70)
    share = modulus * (1 - 0.25**2) / 70
    known = 'young = ["200 GPa ± 5 %", "70 GPa"]\npoisson = ["0.3", "0.25"]'
    contact = f'effective_modulus = "{modulus!r} GPa"\ncompliance_share = {share!r}\npoisson_ratio = [0.3, 0.25]'
    study = parse_old_study(known, contact)
    assert study.contact.effective_modulus == pytest.approx(modulus, rel=1e-15)
    assert study.contact.compliance_share == pytest.approx(share, rel=1e-15)
    assert [value.text for value in study.contact.young] == ["200 GPa ± 5 %", "70 GPa"]
    assert set(Inputs.from_study(study).uncertain) == {"young_upper"}


def test_old_effective_modulus_that_contradicts_the_materials_keeps_the_relative_range_of_the_materials():
    study = parse_old_study("", 'effective_modulus = "40 GPa"\nmaterials = ["steel", "brass"]')
    estimate = Inputs.from_study(study).uncertain["effective_modulus"].estimate
    assert study.contact.effective_modulus == 40
    assert (estimate.low / 40, estimate.high / 40) == pytest.approx((0.969, 1.032), abs=0.003)


@pytest.mark.usefixtures("all_input_samples")
def test_interface_of_an_old_study_defines_mu0_and_tau0():
    friction = 'mu0 = [0.001]\ntau0 = ["0.02479 GPa"]'
    known = f'mu0 = "5.005e-05..0.00195"\ntau0 = "24.3..25.3 MPa"\ninterface = "{FILM_NAME}"'
    study = parse_old_study(known, friction=friction)
    assert f'interface = "{FILM_NAME}"' in study.to_toml()
    assert "mu0" not in study.to_toml()
    assert (study.friction.mu0[0], float(study.friction.tau0[0])) == (0.001, 0.02479)
    assert find_interface(study) is not None


def test_missing_interface_file_of_an_old_study_does_not_change_the_ranges_of_mu0_and_tau0():
    known = 'mu0 = "0.1..0.3"\ntau0 = "24.3..25.3 MPa"\ninterface = "/nowhere/film.csv"'
    study = parse_old_study(known, friction='mu0 = [0.21]\ntau0 = ["0.02479 GPa"]')
    inputs = Inputs.from_study(study)
    assert find_interface(study) is None
    assert (inputs.central("mu0"), inputs.quantile("mu0", 0.025)) == (0.21, pytest.approx(0.1, rel=1e-3))
    assert study.friction.interface.name == "film.csv"
    assert parse_study(study.to_toml(), "new") == study


@pytest.mark.parametrize(("known", "contact", "friction", "message"), [
    ('hardness = "1 GPa ± 10 %"', 'hardness = "0.6 GPa"', "mu0 = [0.2]",
     "old: contact.hardness: must be within known.hardness, '1 GPa ± 10 %', got '0.6 GPa'"),
    ('hardness = "2 GPa"', 'hardness = "0.6 GPa"', "mu0 = [0.2]",
     "old: contact.hardness: must be within known.hardness, '2 GPa', got '0.6 GPa'"),
    ('effective_modulus = "80 GPa ± 5 %"', 'effective_modulus = "40 GPa"', "mu0 = [0.2]",
     "old: contact.effective_modulus: must be within known.effective_modulus, '80 GPa ± 5 %', got '40 GPa'"),
    ('mu0 = "0.2 ± 0.02"', "", "mu0 = [0.4]", "old: friction.mu0: must be within known.mu0, '0.2 ± 0.02', got '0.4'"),
    ('mu0 = "0.2 ± 0.02"', "", "mu0 = [0.2, 0.3]",
     "old: friction.mu0: must have one value, because known.mu0 is '0.2 ± 0.02', got [0.2, 0.3]"),
])  # fmt: skip
def test_old_study_with_contradictory_inputs_is_rejected_with_one_sentence(known, contact, friction, message):
    with pytest.raises(StudyError) as error_info:
        parse_old_study(known, contact, friction)
    assert str(error_info.value) == message


def test_old_study_with_an_invalid_range_is_rejected_with_the_name_of_the_new_entry():
    with pytest.raises(StudyError, match=r"^old: friction.tau0: .*unit of pressure"):
        parse_old_study('tau0 = "20..80"', friction='mu0 = [0.2]\ntau0 = ["40 MPa"]')


def test_uncertain_inputs_in_an_old_study_of_generated_surfaces_are_ignored():
    assert parse_study('[known]\nmu0 = "0.1..0.3"\n[ensemble]\nrepetitions = 7\n', "old").ensemble.repetitions == 7


def test_old_result_without_a_checksum_can_be_extended(tmp_path):
    maps = [
        self_affine_surface(seed, hurst_exponent=0.8, rms=0.02, shape=(40, 40), spacing=0.1, shortest_wavelength=0.6)
        for seed in (1, 2)
    ]
    options = {"effective_modulus": "80 GPa", "hardness": "2 GPa ± 10 %", "mu0": 0.2, "load": "10 MPa", "onset": 0}
    value = pair(*maps, **options, shifts=1, cutoff="none", directory=tmp_path).value
    file = tmp_path / "study.toml"
    tables = file.read_text("utf-8").partition("\n\n")[2].replace('yield_exponent = "uniform 1 .. 1.5"\n', "")
    tables = tables.replace('hardness = "2 GPa ± 10 %"', 'hardness = "2 GPa"')
    header = f"# Written by stiction {__version__}."
    file.write_text(f'{header}\n\n{tables}\n[known]\nhardness = "2 GPa ± 10 %"\n', "utf-8")
    result = pair(*maps, **options, shifts=2, cutoff="none", directory=tmp_path)
    assert result.members.tolist() == [0, 1]
    assert result.study.contact.hardness.text == "2 GPa ± 10 %"
    assert "[known]" not in file.read_text("utf-8")
    assert result.value != value
