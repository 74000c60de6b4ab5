"""Tests of materials: plausible values, names, and pairs of materials."""

import importlib.util
import math
import pickle
import re
from pathlib import Path

import pytest
from stiction import MaterialValue, compliance_fraction, effective_modulus, material, materials, softer_hardness

ROUND_OFF = 1e-14
FOR_EACH_MATERIAL = pytest.mark.parametrize("listed_material", materials(), ids=lambda item: item.name)


def test_table_of_materials_contains_every_kind_of_material():
    assert len(materials()) >= 30
    kinds = {item.kind for item in materials()}
    assert kinds == {"metal", "ceramic", "glass", "semiconductor", "coating", "polymer", "elastomer", "rock"}
    for name in ("steel", "brass", "silicon", "gold", "diamond-like carbon", "PTFE", "glass", "alumina", "granite"):
        assert material(name).name


@FOR_EACH_MATERIAL
def test_material_values_are_physically_possible_and_have_sources(listed_material):
    values = (listed_material.young_modulus, listed_material.poisson_ratio, listed_material.hardness)
    for value in (value for value in values if value is not None):
        assert 0 < value.low <= value <= value.high
        assert float(value) == pytest.approx(math.sqrt(value.low * value.high), rel=ROUND_OFF)
        assert re.search(r"\(?\b(19|20)\d\d\b|SAE J431|\(web\)", value.source), value.source
    assert (listed_material.hardness is None) == (listed_material.kind == "elastomer")
    if listed_material.hardness is None:
        assert 1e-4 < listed_material.young_modulus.low <= listed_material.young_modulus.high < 0.1
        assert 0.45 <= listed_material.poisson_ratio.low <= listed_material.poisson_ratio.high <= 0.5
        return
    assert 0.1 < listed_material.young_modulus.low <= listed_material.young_modulus.high < 1300
    assert listed_material.poisson_ratio.high < 0.5
    # The limits are a soft metal and the ideal strength of a covalent solid. Cracked rock is softer than its grains.
    assert (
        0.001
        < listed_material.hardness / listed_material.young_modulus
        < (0.2 if listed_material.kind == "rock" else 0.15)
    )
    assert listed_material.young_modulus.high / listed_material.young_modulus.low < 3.1
    assert listed_material.hardness.high / listed_material.hardness.low < 8


@pytest.mark.parametrize(
    ("name", "young", "hardness"),
    [
        # Values from sources outside of the table: Johnson (1985), Contact Mechanics; Hutchings & Shipway (2017).
        ("steel", 207, 1.2), ("tungsten carbide", 600, 15), ("soda-lime glass", 70, 5.6), ("aluminium", 70, 0.25),
        ("silicon nitride", 300, 16), ("PMMA", 3, 0.2), ("gold", 78, 0.3), ("silicon", 165, 11), ("lead", 16, 0.04),
    ],
)  # fmt: skip
def test_ranges_of_modulus_and_hardness_contain_reference_values(name, young, hardness):
    result = material(name)
    assert 0.9 * result.young_modulus.low <= young <= 1.1 * result.young_modulus.high
    assert 0.9 * result.hardness.low <= hardness <= 1.1 * result.hardness.high


@FOR_EACH_MATERIAL
def test_material_lookup_accepts_every_alias_in_any_spelling(listed_material):
    for name in (listed_material.name, *listed_material.aliases):
        assert material(name) is material(name.upper()) is material(name.replace("-", " ")) is listed_material


def test_materials_have_unique_names():
    names = [re.sub(r"[\W_]", "", name).casefold() for item in materials() for name in (item.name, *item.aliases)]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("stainles steel", "the nearest are .*stainless steel"),
        ("aluminum alloy 6063", "aluminium alloy 6061-T6"),
        ("unobtainium??", "known material, got 'unobtainium"),
        ("", "there are aluminium, aluminium alloy"),
        (3, "name must be the name of a material, got 3"),
        ([0.1] * 100, r"^name must be the name of a material, got \[0\.1, [0-9., ]{20,35}\.\.\.$"),
    ],
)
def test_error_about_an_unknown_material_suggests_the_nearest_name(name, message):
    with pytest.raises(ValueError, match=message):
        material(name)


@pytest.mark.parametrize(
    ("name", "hint"),
    [("TiN", "nearest are tin"), ("tiN", "nearest are tin"), ("Ti-N", "nearest are tin"), ("Pa", "nearest are "),
     ("siC", "SiC"), ("CrN", "a coating much thinner"), ("MoS2", "a coating much thinner"), ("TiC", "a coating much"),
     ("TiN coated steel", "a coating much thinner"), ("DLC coating", "a coating much thinner")],
)  # fmt: skip
def test_material_lookup_rejects_formulas_that_only_resemble_a_known_name(name, hint):
    with pytest.raises(ValueError, match=rf"must be the name of a known material, got '{name}'.*{hint}"):
        material(name)


def test_material_lookup_is_case_sensitive_for_formulas_but_not_for_words():
    for name in ("Si", "SiC", "Si3N4", "WC", "Al2O3", "ZrO2", "DLC", "a-C:H", "ta-C", "100Cr6", "Ti-6Al-4V"):
        assert material(name)
    assert material("Tin") is material("tin") is material("TIN")
    assert material("Mild Steel") is material("MILD STEEL") is material("mild-steel")


def test_modulus_and_compliance_and_hardness_of_two_materials_equal_closed_forms():
    steel, brass = material("steel"), material("brass")
    expected_modulus = 1 / sum((1 - item.poisson_ratio**2) / item.young_modulus for item in (steel, brass))
    assert effective_modulus(steel, brass) == pytest.approx(expected_modulus, rel=ROUND_OFF)
    modulus_of_four_numbers = effective_modulus(
        steel.young_modulus, steel.poisson_ratio, brass.young_modulus, brass.poisson_ratio
    )
    assert modulus_of_four_numbers == pytest.approx(expected_modulus, rel=ROUND_OFF)
    lower = compliance_fraction(steel, brass)
    assert lower == pytest.approx(expected_modulus * (1 - brass.poisson_ratio**2) / brass.young_modulus, rel=ROUND_OFF)
    assert lower + compliance_fraction(brass, steel) == pytest.approx(1, rel=ROUND_OFF)
    assert compliance_fraction(steel, steel) == 0.5
    assert softer_hardness(material("alumina"), brass) is brass.hardness
    assert softer_hardness(brass, material("PTFE")) is material("PTFE").hardness
    assert softer_hardness(brass, material("PDMS")) is softer_hardness(material("rubber"), brass) is None


def test_effective_modulus_accepts_two_moduli_and_two_poisson_ratios():
    assert effective_modulus(200.0, 0.0, [200.0, 100.0], 0.0).tolist() == pytest.approx([100, 200 / 3])


@pytest.mark.parametrize(
    "arguments",
    [("steel", "brass"), (material("steel"), 0.3, 200.0, 0.3), (material("steel"), material("gold"), 1.0, 0.3)],
)
def test_effective_modulus_rejects_materials_mixed_with_numbers(arguments):
    with pytest.raises(ValueError, match=r"effective_modulus|young_upper|array of real numbers"):
        effective_modulus(*arguments)
    with pytest.raises(ValueError, match="upper must be a Material"):
        compliance_fraction("steel", material("brass"))
    with pytest.raises(ValueError, match="lower must be a Material"):
        softer_hardness(material("brass"), 3.0)


def test_pickled_material_value_preserves_its_range_and_source():
    value = pickle.loads(pickle.dumps(material("copper").hardness))
    assert isinstance(value, MaterialValue)
    assert (value.low, value.high, value.source) == (0.34, 1.14, material("copper").hardness.source)
    assert "0.34 to 1.14" in repr(value)
    assert repr(MaterialValue(2, 2, "somebody")) == "<2, somebody>"


def test_documented_table_of_materials_is_up_to_date():
    docs = Path(__file__).parents[2] / "docs"
    spec = importlib.util.spec_from_file_location("materials_table", docs / "scripts/materials.py")
    script = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(script)
    assert (docs / "generated/materials.md").read_text(encoding="utf-8") == script.format_table(), (
        "run docs/scripts/materials.py"
    )
    sources = [
        value.source
        for item in materials()
        for value in (item.young_modulus, item.poisson_ratio, item.hardness)
        if value is not None
    ]
    num_unseen = sum("not verified" in source for source in sources)
    message = (
        f"Each of the {len(sources)} values is a range with its source. "
        f"Of these values, {num_unseen} were written from memory, because their sources were not available."
    )
    assert message in " ".join((docs / "reference/materials.md").read_text(encoding="utf-8").split())
