"""Tests of `stiction materials`, which prints the properties of materials and their sources."""

import json

import pytest
from stiction import materials
from support.command import assert_rejected, call_stiction, check_stiction


def test_materials_command_lists_all_materials_within_terminal_width(tmp_path):
    completed = check_stiction("materials", cwd=tmp_path, columns=80)
    assert max(map(len, completed.stdout.splitlines())) <= 80
    for entry in materials():
        assert f"\n{entry.name} " in completed.stdout
        assert " ".join((entry.hardness or entry.young_modulus).source.split()) in " ".join(completed.stdout.split())


def test_materials_command_accepts_any_alias_of_a_material(tmp_path):
    completed = call_stiction("materials", "steel", "--json", cwd=tmp_path)
    (entry,) = json.loads(completed.stdout)["materials"]
    assert entry["name"] == "mild steel"
    assert "steel" in entry["aliases"]
    hardness = entry["hardness"]["estimate"]
    assert (hardness["kind"], hardness["unit"]) == ("range", "GPa")
    assert hardness["lower"] < hardness["value"] < hardness["upper"]
    assert hardness["value"] == pytest.approx((hardness["lower"] * hardness["upper"]) ** 0.5)
    assert "Tabor" in entry["hardness"]["source"]
    assert "gold   77–78 [1]  0.42–0.44 [1]  0.19–0.73 [2]" in check_stiction("materials", "gold", cwd=tmp_path).stdout
    assert_rejected(call_stiction("materials", "unobtainium", cwd=tmp_path), "unobtainium")
