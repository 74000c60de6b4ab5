"""Test the study of one pair at several cutoff wavelengths, and the wavelengths that its gap contains."""

import numpy as np
import pytest
from stiction import Study, run, self_affine_surface
from stiction.companions.resolution import (
    CUTOFF_STUDY_DIRECTORY,
    build_cutoff_study,
    estimate_yield_wavelengths,
    evaluate_at_cutoffs,
    find_plastic_limit,
    find_resolution_effect,
    find_resolution_limits,
    find_resolved_roughness,
)
from stiction.evaluate.at_load import at_load
from stiction.solve.runner import compute_missing_blocks
from stiction.solve.store import open_stored_result
from stiction.study.members import read_measured_bodies
from stiction.surfaces.scale import scale_dependent_roughness
from stiction.surfaces.surface import Surface
from stiction.views.resolution import cut_off_note, cut_off_rows, resolved_wavelengths_text
from support.studies_of_files import create_study_from_files, write_maps, write_profiles


@pytest.fixture(scope="module")
def directory(tmp_path_factory):
    return tmp_path_factory.mktemp("maps")


@pytest.fixture(scope="module")
def study(directory):
    spacing = write_maps(directory, shape=(128, 128))
    return create_study_from_files(
        directory, spacing=spacing, members=5, contact='hardness = "4 GPa"\ndirection = [0, 180]'
    )


def test_cutoff_study_has_fewer_pairs_and_loads_than_the_original_study(study):
    cutoff_study = build_cutoff_study(study)
    assert cutoff_study.surfaces.cell_coordinates()["cut_off"] == pytest.approx([0, 0.2, 0.4], rel=1e-3)
    assert cutoff_study.ensemble.repetitions == 4
    assert cutoff_study.contact.loading_steps().tolist() == [2.0]
    assert cutoff_study.contact.hardness == study.contact.hardness
    assert cutoff_study.surfaces.upper == study.surfaces.upper


def test_cutoff_study_of_a_filtered_study_starts_at_the_cutoff_of_the_filter(study):
    cutoff_study = build_cutoff_study(study.with_changes({"surfaces.cut_off": ["0.2 um"]}))
    assert cutoff_study.surfaces.cell_coordinates()["cut_off"] == pytest.approx([0.2, 0.4], rel=1e-3)


def test_cutoff_study_uses_surrogates_only_if_all_pairs_are_surrogates(study):
    mixed_study = build_cutoff_study(study.with_changes({"surfaces.surrogates": 3}))
    assert (mixed_study.ensemble.repetitions, mixed_study.surfaces.surrogates) == (2, 0)
    surrogate_study = build_cutoff_study(study.with_changes({"surfaces.surrogates": 5}))
    assert (surrogate_study.ensemble.repetitions, surrogate_study.surfaces.surrogates) == (4, 4)


def test_cutoff_study_is_none_if_there_are_no_cutoffs_to_compare(study, tmp_path):
    assert build_cutoff_study(Study.named("quick")) is None
    assert build_cutoff_study(study.with_changes({"surfaces.cut_off": ["0 um", "0.3 um"]})) is None
    assert (
        build_cutoff_study(study.with_changes({"contact.mechanics": "asperities", "contact.law": "hertz-sphere"}))
        is None
    )
    small_study = create_study_from_files(tmp_path, spacing=write_maps(tmp_path))
    assert build_cutoff_study(small_study) is None


def test_cutoff_study_stored_for_another_hardness_is_ignored(study, tmp_path):
    small_study = study.with_changes({"contact.load": ["2 mN"], "ensemble.repetitions": 2})
    compute_missing_blocks(small_study, tmp_path)
    assert evaluate_at_cutoffs(open_stored_result(tmp_path)) is None
    cutoff_study = build_cutoff_study(small_study)
    compute_missing_blocks(cutoff_study, tmp_path / CUTOFF_STUDY_DIRECTORY)
    result = evaluate_at_cutoffs(open_stored_result(tmp_path))
    expected = at_load(run(cutoff_study), [2.0])
    np.testing.assert_array_equal(result["mean_friction"].values, expected["mean_friction"].values)
    point = result.isel(load=0, mu0=0, tau0=1)
    effect = find_resolution_effect(result, small_study, result.isel(tau0=[1]))
    assert f"means over {effect.members:.0f} positions, at a load of 2 mN." in cut_off_note(effect, small_study)
    rows = cut_off_rows(effect, 4.0)
    assert [row[0] for row in rows[1:]] == ["none", "200 nm", "400 nm", "plastic limit"]
    assert rows[-1][-1] == f"{0.3 + 0.05 / 4:.3f}"
    # The limit applies to friction at all contacts even if the interface was fitted at opposing contacts.
    interface = {"file": "film.csv", "mu0": 0.3, "tau0": "50 MPa", "sliding": "opposing"}
    opposing_study = small_study.with_changes({"friction.interface": interface})
    opposing_rows = cut_off_rows(find_resolution_effect(result, opposing_study, result.isel(tau0=[1])), 4.0)
    assert opposing_rows[0][-2:] == [*reversed(rows[0][-2:])] == ["μ_s opposing contacts", "μ_s all contacts"]
    assert dict(zip(opposing_rows[0], opposing_rows[-1], strict=True))["μ_s all contacts"] == rows[-1][-1]
    min_friction, min_area_fraction = find_plastic_limit(point, small_study)
    assert min_friction == pytest.approx(0.3 + 0.05 / 4)
    assert min_area_fraction == pytest.approx(2.0 / 4 / float(result["nominal_area"]))
    limits = find_resolution_limits(point, small_study)
    assert limits.plastic_limit == (min_friction, min_area_fraction)
    area = result["contact_area_fraction"].sel(statistic="mean").values
    assert (area > min_area_fraction).all()
    softer_directory = tmp_path / "softer"
    compute_missing_blocks(small_study.with_changes({"contact.hardness": "3 GPa"}), softer_directory)
    compute_missing_blocks(cutoff_study, softer_directory / CUTOFF_STUDY_DIRECTORY)
    assert evaluate_at_cutoffs(open_stored_result(softer_directory)) is None


def test_resolved_wavelengths_of_a_study_equal_wavelengths_computed_from_the_gap(study):
    wavelengths = find_resolved_roughness(study)
    upper, lower = read_measured_bodies(study).member(0, 0.0).pair
    gap = Surface(upper.heights - lower.heights, spacing=upper.spacing)
    roughness = scale_dependent_roughness(gap)
    assert wavelengths.shortest == pytest.approx(0.2)
    assert wavelengths.longest == pytest.approx(max(gap.extent))
    assert wavelengths.shortest_octave_fraction == pytest.approx(float(roughness.fraction_below(0.4)))
    assert resolved_wavelengths_text(wavelengths).startswith(
        "Wavelengths from 200 nm to 9.6 µm; wavelengths below 400 nm contribute "
    )
    assert find_resolved_roughness(Study.named("quick")) is None


def test_shortest_resolved_wavelength_of_filtered_scans_is_the_cutoff(study):
    assert find_resolved_roughness(study.with_changes({"surfaces.cut_off": ["0.5 um"]})).shortest == pytest.approx(0.5)


def test_longest_yielding_wavelength_decreases_with_pressure(study):
    result = find_resolved_roughness(study)
    plastic_wavelengths = [result.find_yield_wavelength(ratio, 100.0)[0] for ratio in (0.5, 0.8, 0.95)]
    assert np.all(np.diff(plastic_wavelengths) < 0)
    value, lower, upper = result.find_yield_wavelength(0.8, 100.0)
    assert lower < value < upper


def test_longest_yielding_wavelength_is_listed_for_each_hardness(tmp_path):
    for side in ("upper", "lower"):
        surface = self_affine_surface(3, hurst_exponent=0.7, rms=0.03, shape=(192, 192), spacing=0.1, side=side)
        np.save(tmp_path / f"{side}.npy", surface.heights)
    elastic_study = create_study_from_files(
        tmp_path, spacing="0.1 um", members=2, contact='direction = [0, 180]\nload = ["2 mN"]'
    )
    point = at_load(run(elastic_study), [2.0]).isel(cut_off=0, load=0, mu0=0, tau0=1)
    table = estimate_yield_wavelengths(point, elastic_study, find_resolved_roughness(elastic_study))
    pressure = float(point["mean_pressure"].sel(statistic="mean"))
    assert [estimate.hardness for estimate in table] == [0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0]
    assert [estimate.friction for estimate in table] == pytest.approx([0.3 + 0.05 / row.hardness for row in table])
    for estimate in table:
        if estimate.hardness < 0.9 * pressure:
            assert estimate.wavelength.value > 0.2
        elif estimate.hardness > 1.1 * pressure:
            assert not estimate.wavelength.value > 0.5
    limits = find_resolution_limits(point.expand_dims("cut_off"), elastic_study)
    assert np.all(np.diff(limits.area_fractions[:, 0]) < 0)


def test_resolved_wavelengths_are_none_if_a_scan_file_is_missing(tmp_path):
    spacing = write_profiles(tmp_path)
    line_study = create_study_from_files(tmp_path, "lines", spacing=spacing, members=3)
    assert find_resolved_roughness(line_study).shortest == pytest.approx(0.04)
    (tmp_path / "upper.npy").unlink()
    assert find_resolved_roughness(line_study.with_changes({"ensemble.repetitions": 2})) is None
