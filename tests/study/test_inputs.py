"""Test the entries of a study for inputs that may be uncertain, each of which has one entry."""

import json
import pickle
from pathlib import Path

import pytest
from stiction import Study, material, materials, pair, self_affine_surface
from stiction.study.elasticity import determine_elasticity
from stiction.study.inputs import Inputs
from stiction.study.study import find_member_differences, parse_study
from stiction.study.values import StudyError
from support.command import check_stiction

STUDY_TEXT = (Path(__file__).parent / "stored_studies/half-space_of_measured_areas.toml").read_text("utf-8")
STUDY = parse_study(STUDY_TEXT, "stored")
MODULUS_STUDY = STUDY.with_changes({"contact.effective_modulus": "80 GPa"})


def compute_pair(directory=None, **options):
    maps = [
        self_affine_surface(seed, hurst_exponent=0.8, rms=0.02, shape=(32, 32), spacing=0.1, shortest_wavelength=0.6)
        for seed in (1, 2)
    ]
    values = {"load": "10 MPa", "mu0": 0.2, "cutoff": "none", "shifts": 3, "onset": 0, "directory": directory}
    return pair(*maps, **values | ({} if "upper" in options else {"effective_modulus": "80 GPa"}) | options)


@pytest.mark.parametrize(("study_key", "entry", "central", "limits"), [
    ("contact.hardness", "120 HV ± 10 %", 1.269, (1.0204, 1.5180)),
    ("contact.hardness", "0.6 GPa (0.2..1.7 GPa)", 0.6, (0.2, 1.7)), ("contact.hardness", "2 GPa", 2.0, (2.0, 2.0)),
    ("contact.effective_modulus", "80 GPa ± 5 %", 80.0, (72.16, 87.84)), ("contact.junction_growth", 9, 9.0, (9, 9)),
    ("contact.junction_growth", "11 (0..27)", 11.0, (0, 27)), ("contact.junction_growth", "0 (0..9)", 0.0, (0, 9)),
    ("contact.junction_growth", "slip-line", 5.6, (5.14, 6.05)),
    ("contact.junction_growth", "slip-line 5.3..5.7", 5.5, (5.3, 5.7)),
    ("friction.mu0", "0.2 ± 0.02", 0.2, (0.1608, 0.2392)),
    ("friction.mu0", 0.3, 0.3, (0.3, 0.3)), ("friction.mu0", ["0.2..0.4"], 0.3, (0.2, 0.4)),
    ("friction.tau0", "20..80 MPa", 0.04, (0.02, 0.08)), ("friction.tau0", "50 MPa", 0.05, (0.05, 0.05)),
    ("friction.creep", "0.02..0.05", 0.035, (0.02, 0.05)), ("contact.yield_exponent", 1.2, 1.2, (1.2, 1.2)),
    ("contact.yield_exponent", "uniform 0.7 .. 1.6", 1.15, (0.7, 1.6)),
    ("contact.yield_exponent", "1.1..1.3", 1.2, (1.1, 1.3)),
])  # fmt: skip
def test_study_entry_contains_both_the_central_value_and_the_range_of_an_input(study_key, entry, central, limits):
    study = STUDY.with_changes({study_key: entry})
    name = study_key.partition(".")[2]
    for equal_study in (study, parse_study(study.to_toml(), "text"), pickle.loads(pickle.dumps(study))):
        assert equal_study == study
        inputs = Inputs.from_study(equal_study)
        assert inputs.central(name) == pytest.approx(central)
        estimate = inputs.entries[name].estimate
        assert (estimate.low, estimate.high) == pytest.approx(limits, rel=1e-4)
        assert (name in inputs.uncertain) == (limits[0] < limits[1])


@pytest.mark.parametrize(("changes", "study_key", "reason"), [
    ({"contact.hardness": "2 GPa (0.2..1.7 GPa)"}, "contact.hardness", "must be one number, followed by a range"),
    ({"contact.hardness": "1..2 GPa (0.2..3 GPa)"}, "contact.hardness", "must be one number, followed by a range"),
    ({"contact.hardness": "0 GPa"}, "contact.hardness", "must be above 0, got '0 GPa'"),
    ({"contact.hardness": 2.0}, "contact.hardness", "must be a pressure with its unit"),
    ({"contact.hardness": "20 kg"}, "contact.hardness", "unit of pressure .*; HV and HRC are also accepted"),
    ({"contact.junction_growth": "slip-line 4"}, "contact.junction_growth", "shear strength from 5 to 6.5"),
    ({"contact.junction_growth": "0..200"}, "contact.junction_growth", "must be from 0 to 100, also at the limits"),
    ({"contact.poisson": ["0.4..0.6", 0.3]}, "contact.poisson",
     "must be from 0 to 0.5, also at the limits of its uncertainty"),
    ({"contact.young": "80 GPa", "contact.effective_modulus": "80 GPa"}, "contact.effective_modulus",
     "must not be given together with young, from which effective_modulus is computed"),
    ({"contact.young": "80 GPa", "contact.compliance_share": 0.5}, "contact.compliance_share",
     "must not be given together with young, from which compliance_share is computed"),
    ({"contact.young": "80 GPa", "contact.poisson": None}, "contact.poisson", "must be given together with young"),
    (
        {"friction.mu0": ["0.2 ± 0.02", 0.3]}, "friction.mu0",
        "must be a list of exact values, or one value with a range or an uncertainty",
    ),
    ({"friction.interface": "MoS2 on bearing steel, dry air", "friction.mu0": [0.2]}, "friction.mu0",
     "must not be given together with interface, which determines mu0 and tau0"),
    ({"friction.interface": "no such film"}, "friction.interface", "must be a file or one of "),
    ({"friction.creep": None}, "", "friction.wait: needs .* add friction.creep"),
    ({"contact.yield_exponent": "0.2..1.2"}, "contact.yield_exponent", "must be from 0.5 to 10, also at the limits"),
    ({"contact.yield_exponent": True}, "contact.yield_exponent", "must be a number, or a string with a range or an un"),
    ({"contact.junction_growth": 0, "contact.work_of_adhesion": "50 mJ/m^2"}, "contact.yield_exponent",
     "must not be given if work_of_adhesion is above 0, because the area of adhesive contacts is computed by ca"),
])  # fmt: skip
def test_study_rejects_entries_that_are_impossible_or_contradict_each_other(changes, study_key, reason):
    with pytest.raises(StudyError, match=reason) as error_info:
        STUDY.with_changes(changes)
    assert len(str(error_info.value).splitlines()) == 1
    assert error_info.value.faults[0][0].partition("[")[0] == study_key


def test_study_of_generated_surfaces_rejects_an_uncertain_input():
    with pytest.raises(StudyError, match=r"contact.effective_modulus: must be exact for generated surfaces, got '8"):
        Study().with_changes({"contact.effective_modulus": "80 GPa ± 5 %"})


@pytest.mark.parametrize("name", ["mild steel", "copper", "silicon", "PTFE"])
def test_elastic_constants_of_two_materials_give_the_same_modulus_and_compliance_fraction_as_material_names(name):
    for other_material in materials():
        elasticity = determine_elasticity(upper_material=name, lower_material=other_material.name)
        body, counterface = (material(material_name) for material_name in (name, other_material.name))
        study = STUDY.with_changes({
            "contact.materials": [name, other_material.name],
            "contact.young": [f"{body_material.young_modulus:.6g} GPa" for body_material in (body, counterface)],
            "contact.poisson": [float(f"{body_material.poisson_ratio:.6g}") for body_material in (body, counterface)],
        })  # fmt: skip
        contact = study.contact
        derived = (float(contact.effective_modulus), contact.compliance_share)
        assert derived == (elasticity.effective_modulus, elasticity.compliance_share)


def test_study_of_a_pair_of_materials_contains_the_ranges_of_both_materials():
    inputs = Inputs.from_study(compute_pair(upper="steel", lower="brass").study)
    steel, brass = material("steel"), material("brass")
    values = {
        "hardness": brass.hardness, "young_upper": steel.young_modulus, "poisson_upper": steel.poisson_ratio,
        "young_lower": brass.young_modulus,
    }  # fmt: skip
    for name, value in values.items():
        estimate = inputs.uncertain[name].estimate
        assert (estimate.low, estimate.high) == (value.low, value.high)
    growth = inputs.uncertain["junction_growth"]
    assert (growth.central, growth.estimate.low, growth.estimate.high) == (5.6, 5.14, 6.05)
    assert growth.label == "the ratio of hardness to shear strength"
    assert inputs.entries["hardness"].label == "the hardness of the brass"
    assert inputs.entries["young_upper"].label == "Young's modulus of the mild steel"
    assert "poisson_lower" not in inputs.uncertain  # for brass, the source states one value without a range


@pytest.mark.parametrize(("materials", "hardness", "label"), [
    (("steel", "grey cast iron"), None, "the hardness of the mild steel"),
    (("steel", "grey cast iron"), "180 HV ± 10 %", "the hardness of the softer body"),
    (("steel", "steel"), "180 HV ± 10 %", "the hardness of the mild steel"),
])  # fmt: skip
def test_label_of_a_given_hardness_names_a_material_only_if_both_bodies_are_of_that_material(
    materials, hardness, label
):
    upper, lower = materials
    study = compute_pair(upper=upper, lower=lower, hardness=hardness).study
    assert Inputs.from_study(study).entries["hardness"].label == label


def test_moduli_are_separate_uncertain_inputs_if_only_one_body_is_given_by_a_material_name():
    study = compute_pair(upper="steel", young="3 MPa ± 5 %", poisson="0.5", effective_modulus=None).study
    inputs = Inputs.from_study(study)
    assert set(inputs.uncertain) >= {"young_upper", "young_lower"}
    assert inputs.central("young_lower") == 0.003
    assert inputs.entries["young_upper"].text == "209 GPa (207..212 GPa)"


def test_effective_modulus_relative_to_its_central_value_follows_both_sampled_young_moduli():
    inputs = Inputs.from_study(STUDY)
    samples = {name: inputs.quantile(name, [0.025, 0.975]) for name in ("young_upper", "young_lower")}
    lower, upper = inputs.relative_modulus(samples)
    assert lower == pytest.approx(0.965, abs=0.01)
    assert upper == pytest.approx(1.035, abs=0.01)
    assert inputs.relative_modulus({}) == 1
    exact_inputs = Inputs.from_study(MODULUS_STUDY)
    assert not {"young_upper", "effective_modulus"} & set(exact_inputs.uncertain)


def test_replaced_input_has_no_uncertainty_unless_the_new_value_equals_the_study_value():
    inputs = Inputs.from_study(STUDY.with_changes({"friction.mu0": "0.2 ± 0.02", "friction.tau0": "50 MPa ± 20 %"}))
    assert inputs.replaced(mu0=0.2, hardness=0.625).uncertain == inputs.uncertain
    changed_inputs = inputs.replaced(mu0=0.3, hardness=0.5)
    assert set(inputs.uncertain) - set(changed_inputs.uncertain) == {"mu0", "hardness"}
    assert (changed_inputs.central("mu0"), changed_inputs.central("hardness"), changed_inputs.central("tau0")) == (
        0.3,
        0.5,
        0.05,
    )
    assert changed_inputs.quantile("hardness", [0.1, 0.9]).tolist() == [0.5, 0.5]


@pytest.mark.usefixtures("all_input_samples")
def test_replacing_mu0_of_an_interface_removes_its_correlation_with_tau0():
    study = STUDY.with_changes({"friction.interface": "MoS2 on bearing steel, dry air"})
    inputs = Inputs.from_study(study)
    assert (inputs.central("mu0"), inputs.central("tau0")) == (0.001, 0.02479)
    assert inputs.strength is not None
    assert inputs.replaced(mu0=0.001, tau0=0.02479).strength is not None
    assert inputs.replaced(mu0=0.2).strength is None
    assert set(inputs.replaced(mu0=0.2).uncertain) == set(inputs.uncertain) - {"mu0"}


def test_studies_that_differ_only_in_ranges_of_inputs_can_share_stored_contact_solutions():
    first_study, second_study = (
        STUDY.with_changes({"contact.hardness": text}) for text in ("1.1..1.21 GPa", "1.154 GPa")
    )
    assert first_study.contact.hardness == 1.154
    assert first_study != second_study
    assert find_member_differences(first_study, second_study) == []
    assert (
        find_member_differences(first_study, STUDY.with_changes({"contact.hardness": "2 GPa"}))[0][0]
        == "contact.hardness"
    )
    assert find_member_differences(STUDY, STUDY.with_changes({"contact.yield_exponent": 1.1})) == []
    by_modulus = STUDY.with_changes({"contact.effective_modulus": "78.7 GPa"})
    assert by_modulus.contact.compliance_share == STUDY.contact.compliance_share == 0.657
    assert find_member_differences(STUDY, by_modulus) == []


@pytest.mark.parametrize(("options", "text"), [
    ({"hardness": "2 GPa"}, "uniform 0.7 .. 1.6"), ({"hardness": "2 GPa", "yield_exponent": 1.1}, "1.1"), ({}, None),
    ({"hardness": "4 GPa", "work_of_adhesion": "50 mJ/m^2", "adhesion_range": "20 nm"}, None),
])  # fmt: skip
def test_yielding_pair_has_a_range_of_the_yield_exponent_by_default(options, text):
    exponent = compute_pair(**options).study.contact.yield_exponent
    assert (exponent and exponent.text) == text


@pytest.mark.parametrize(("options", "reason"), [
    ({"hardness": "2 GPa", "yield_exponent": "0..1"}, "yield_exponent must be from 0.5 to 10"),
    ({"yield_exponent": 1.2}, "yield_exponent needs hardness"),
])  # fmt: skip
def test_pair_rejects_an_impossible_yield_exponent(options, reason):
    with pytest.raises(ValueError, match=reason):
        compute_pair(**options)


@pytest.fixture(scope="module")
def study_file(tmp_path_factory):
    """Study file of a pair in which all inputs are uncertain."""
    options = {"hardness": "1 GPa ± 10 %", "mu0": "0.2 ± 0.01", "tau0": "50 MPa ± 20 %", "load": "50 MPa"}
    directory = tmp_path_factory.mktemp("pair")
    study = compute_pair(directory / "result", upper="steel", lower="brass", junction_growth="0..20", **options).study
    (directory / "study.toml").write_text(study.to_toml(), "utf-8")
    return directory / "study.toml"


@pytest.mark.parametrize(("study_key", "entry", "text", "label"), [
    ("contact.hardness", '"0.6 GPa"', "hardness 600 MPa, ", "the hardness of the softer body"),
    ("contact.hardness", '"0.5..0.7 GPa"', "hardness 592 MPa (0.5..0.7 GPa), ", "the hardness of the softer body"),
    ("contact.effective_modulus", '"40 GPa"', "E* = 40 GPa, ", "Young's modulus of the mild steel"),
    ("contact.effective_modulus", '"40 GPa ± 5 %"', "E* = 40 GPa, ", "E*"),
    ("contact.young", '["300 GPa ± 3 %", "150 GPa"]', "E* = 112 GPa, ", "Young's modulus of the mild steel"),
    ("contact.poisson", '["0.2..0.4", 0.2]', "E* = 74.2 GPa, ", "Poisson's ratio of the mild steel"),
    ("contact.junction_growth", "9", "α = 9, ", "the junction growth α"),
    ("contact.junction_growth", '"9..15"', "α = 9..15, ", "the junction growth α"),
    ("friction.mu0", "[0.25]", "μ0 = 0.25, ", "μ0"),
    ("friction.mu0", '"0.25 ± 0.02"', "μ0 = 0.25 (0.25 ± 0.02), ", "μ0"),
    ("friction.tau0", '["20 MPa"]', "τ0 = 20 MPa, ", "τ0"),
    ("friction.tau0", '"20..30 MPa"', "τ0 = 24.5 MPa (20..30 MPa), ", "τ0"),
])  # fmt: skip
@pytest.mark.usefixtures("disable_figures", "omit_companion_files")
def test_study_entry_set_on_the_command_line_appears_in_output_and_uncertainty_budget(
    study_file, tmp_path, monkeypatch, study_key, entry, text, label
):
    # Print nothing, because `info` would print the result.
    monkeypatch.setattr("stiction.cli.result_output.print_result", lambda *_, **__: None)
    arguments = ["--set", f"{study_key}={entry}", "--output", "changed"]
    check_stiction("run", study_file, *arguments, cwd=tmp_path, without_report=True)
    document = json.loads(check_stiction("info", "changed", "--json", cwd=tmp_path).stdout)
    point = document["points"][0]
    assert text in point["sentence"]
    study = parse_study(document["study"], "json")
    assert Study.from_toml(tmp_path / "changed/study.toml") == study
    labels = {uncertain_input.label for uncertain_input in Inputs.from_study(study).uncertain.values()}
    is_uncertain = "±" in entry or ".." in entry
    assert (label in labels) == is_uncertain
    budget = {row["input"] for row in point["budget"]}
    assert {label for label in budget if label.startswith(("the", "Y", "P", "E", "μ", "τ"))} <= labels
    assert (label in budget) == is_uncertain
