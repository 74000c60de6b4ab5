"""How finely a pair was seen: the study over cut-offs is the same pair, and waves are those of its gap."""

import numpy as np
import pytest
from stiction import Study, run, self_affine_surface
from stiction.studies.evaluation import at_load
from stiction.studies.members import load_bodies
from stiction.studies.resolution import (
    CUTOFF_STUDY_FOLDER,
    build_cutoff_study,
    evaluate_cutoffs,
    find_resolved_roughness,
)
from stiction.studies.runner import compute_missing
from stiction.studies.store import open_stored
from stiction.surfaces.scale import scale_dependent_roughness
from stiction.surfaces.surface import Surface
from stiction.views.resolution import cut_off_rows, plastic_limit, resolution_limits, wavelengths_text, yield_estimates
from support.measured_studies import study_of, write_maps, write_profiles


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("maps")


@pytest.fixture(scope="module")
def study(folder):
    spacing = write_maps(folder, shape=(128, 128))
    return study_of(folder, spacing=spacing, members=5, contact='hardness = "4 GPa"\ndirection = [0, 180]')


def test_resolution_study_has_fewer_members_and_loads(study):
    over = build_cutoff_study(study)
    assert over.surfaces.cells()["cut_off"] == pytest.approx([0, 0.2, 0.4], rel=1e-3)
    assert over.ensemble.repetitions == 4
    assert over.contact.steps().tolist() == [2.0]
    assert over.contact.hardness == study.contact.hardness
    assert over.surfaces.upper == study.surfaces.upper


def test_resolution_study_continues_at_doubled_cutoffs(study):
    over = build_cutoff_study(study.with_changes({"surfaces.cut_off": ["0.2 um"]}))
    assert over.surfaces.cells()["cut_off"] == pytest.approx([0.2, 0.4], rel=1e-3)


def test_resolution_study_is_none_without_cutoffs_to_compare(study, tmp_path):
    assert build_cutoff_study(Study.named("quick")) is None
    assert build_cutoff_study(study.with_changes({"surfaces.cut_off": ["0 um", "0.3 um"]})) is None
    assert (
        build_cutoff_study(study.with_changes({"contact.mechanics": "asperities", "contact.law": "hertz-sphere"}))
        is None
    )
    small = study_of(tmp_path, spacing=write_maps(tmp_path))  # 48 points: a thirtieth is less than two of them
    assert build_cutoff_study(small) is None


def test_stored_resolution_is_read_only_with_its_result(study, tmp_path):
    few = study.with_changes({"contact.load": ["2 mN"], "ensemble.repetitions": 2})
    compute_missing(few, tmp_path)
    assert evaluate_cutoffs(open_stored(tmp_path)) is None
    over = build_cutoff_study(few)
    compute_missing(over, tmp_path / CUTOFF_STUDY_FOLDER)
    result = evaluate_cutoffs(open_stored(tmp_path))
    expected = at_load(run(over), [2.0])
    np.testing.assert_array_equal(result["friction_all_round"].values, expected["friction_all_round"].values)
    point = result.isel(load=0, mu0=0, tau0=1)
    rows = cut_off_rows(point, few)
    assert [row[0] for row in rows[1:]] == ["none", "200 nm", "400 nm", "plastic limit"]
    assert rows[-1][-1] == f"{0.3 + 0.05 / 4:.3f}"
    assert plastic_limit(point, few) == pytest.approx(0.3 + 0.05 / 4)
    least = resolution_limits(point, few)["area_fraction"]
    area = result["contact_area_fraction"].sel(statistic="mean").values
    assert least == pytest.approx(2.0 / 4 / float(result["nominal_area"]))
    assert (area > least).all()
    # With another pair beside it, it is none of this one.
    softer = tmp_path / "softer"
    compute_missing(few.with_changes({"contact.hardness": "3 GPa"}), softer)
    compute_missing(over, softer / CUTOFF_STUDY_FOLDER)
    assert evaluate_cutoffs(open_stored(softer)) is None


def test_wavelengths_are_those_of_the_gap(study):
    result = find_resolved_roughness(study)
    upper, lower = load_bodies(study).member(0, 0.0).pair
    gap = Surface(upper.heights - lower.heights, spacing=upper.spacing)
    roughness = scale_dependent_roughness(gap)
    assert result.shortest == pytest.approx(0.2)
    assert result.longest == pytest.approx(max(gap.extent))
    assert result.fraction_below(0.8) == pytest.approx(float(roughness.fraction_below(0.8)))
    assert wavelengths_text(result).startswith("Wavelengths from 200 nm to 9.6 µm; those below 400 nm contribute ")
    assert find_resolved_roughness(Study.named("quick")) is None


def test_wavelengths_begin_at_the_cutoff(study):
    assert find_resolved_roughness(study.with_changes({"surfaces.cut_off": ["0.5 um"]})).shortest == pytest.approx(0.5)


def test_plastic_wavelength_follows_pressure(study):
    result = find_resolved_roughness(study)
    reached = [result.find_plastic_wavelength(ratio, 100.0)[0] for ratio in (0.5, 0.8, 0.95)]
    assert np.all(np.diff(reached) < 0)
    value, lower, upper = result.find_plastic_wavelength(0.8, 100.0)
    assert lower < value < upper


def test_elastic_scan_lists_plastic_wavelengths_for_hardnesses(tmp_path):
    for side in ("upper", "lower"):
        created = self_affine_surface(3, hurst_exponent=0.7, rms=0.03, shape=(192, 192), spacing=0.1, side=side)
        np.save(tmp_path / f"{side}.npy", created.heights)
    soft = study_of(tmp_path, spacing="0.1 um", members=2, contact='direction = [0, 180]\nload = ["2 mN"]')
    point = at_load(run(soft), [2.0]).isel(cut_off=0, load=0, mu0=0, tau0=1)
    table = yield_estimates(point, soft, find_resolved_roughness(soft))
    pressure = float(point["mean_pressure"].sel(statistic="mean"))
    assert [row[0] for row in table] == [0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]
    assert [row[4] for row in table] == pytest.approx([0.3 + 0.05 / row[0] for row in table])
    for hardness, wave, *_ in table:
        if hardness < 0.9 * pressure:
            assert wave > 0.2  # within the scan
        elif hardness > 1.1 * pressure:
            assert not wave > 0.5
    finer = resolution_limits(point.expand_dims("cut_off"), soft)
    assert np.all(np.diff(finer["finer_area_fraction"][:, 0]) < 0)


def test_missing_scan_files_have_no_wavelengths(tmp_path):
    spacing = write_profiles(tmp_path)
    lines = study_of(tmp_path, "lines", spacing=spacing, members=3)
    assert find_resolved_roughness(lines).shortest == pytest.approx(0.04)
    (tmp_path / "upper.npy").unlink()
    assert find_resolved_roughness(lines.with_changes({"ensemble.repetitions": 2})) is None
