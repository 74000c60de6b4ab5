"""Test the onset of sliding of a measured pair: means over members, the slip map and stored files."""

import io
import math

import numpy as np
import pandas
import pytest
import xarray
from stiction import (
    Profile,
    Study,
    approach_at_load,
    contacts,
    half_space,
    open_result,
    pair,
    self_affine,
    self_affine_surface,
)
from stiction._estimate import Estimate
from stiction._number_format import format_with_unit
from stiction._threads import thread_pool_executor
from stiction.companions.onset import (
    ONSET_FILE,
    TRACTION_TOLERANCE,
    compute_onset,
    format_backbone_csv,
    load_stored_onset,
    read_onset_summary,
    scale_onset,
)
from stiction.evaluate.intervals import average_independent_values
from stiction.mechanics.presliding import fit_iwan
from stiction.solve.runner import compute_missing_blocks
from stiction.solve.store import export, open_stored_result
from stiction.study.members import read_measured_bodies
from stiction.views.layout import format_paragraph
from stiction.views.onset import onset_paragraph, onset_record, onset_rows, onset_text
from stiction.views.report import report_page
from support.command import disable_drawing
from support.images import find_pixel_centres
from support.rough_surfaces import rough_maps
from support.studies_of_files import create_study_from_files, pair_study, write_maps, write_profiles


def compute_study_onset(study, **options):
    with thread_pool_executor(1) as executor:
        return compute_onset(study, executor, **options)


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    directory = tmp_path_factory.mktemp("maps")
    contact_keys = (
        'hardness = "4 GPa"\ncompliance_share = 0.3\npoisson = [0.3, 0.4]\nload = ["2 mN"]\ndirection = [0, 180]'
    )
    return create_study_from_files(
        directory, spacing=write_maps(directory), members=4, contact=contact_keys
    ).with_changes({"friction.tau0": ["50 MPa"]})


@pytest.fixture(scope="module")
def onset(study):
    return compute_study_onset(study, members=3)


def test_onset_of_sliding_of_a_result_is_the_mean_over_all_pairs_of_surfaces(study, onset):
    curves, exact_displacements = [], []
    for index in range(3):
        curve = half_space(
            *read_measured_bodies(study).member(index, 0.0).pair, [2.0], effective_modulus=100.0, hardness=4.0,
            compliance_share=0.3,
        )  # fmt: skip
        steps = onset["fraction"].values.tolist()
        options = {"mu0": 0.3, "tau0": 0.05, "steps": steps, "poisson": [0.3, 0.4]}
        curves.append(curve.onset(0, **options, tolerance=TRACTION_TOLERANCE))
        exact_displacements.append(curve.onset(0, **options).displacement)
    # The onset of a study has a looser solver tolerance, with which displacements change by at most 1e-6.
    np.testing.assert_allclose(
        onset["displacement"].sel(statistic="mean"), np.mean(exact_displacements, axis=0), rtol=1e-6
    )
    for name in ("displacement", "slipped_area", "tangential_load"):
        expected = average_independent_values(np.array([getattr(member_onset, name) for member_onset in curves]))[0]
        np.testing.assert_allclose(onset[name].sel(statistic="mean"), expected, rtol=1e-9, err_msg=name)
    mean, lower, upper = average_independent_values(np.array([member_onset.stiffness for member_onset in curves]))
    np.testing.assert_allclose(onset["stiffness"], [mean, lower, upper], rtol=1e-9)
    assert onset.attrs["members"] == 3


def test_slipped_area_increases_up_to_the_whole_contact_area_at_the_sliding_load(onset):
    mean = onset.sel(statistic="mean")
    assert float(mean["slipped_area"][-1]) == 1
    assert float(mean["tangential_load"][-1]) == float(mean["sliding_load"])
    assert float(mean["displacement"][-1]) == pytest.approx(float(mean["displacement_at_sliding"]))
    for name in ("displacement", "slipped_area", "energy_lost"):
        assert (np.diff(mean[name]) >= 0).all()
    assert onset.attrs["iwan_largest_residual"] < 0.1
    assert onset.attrs["lugre_sigma0_mN_per_um"] > 0


def test_onset_displacement_is_finite_for_asperities_and_undefined_for_half_planes(tmp_path):
    spacing = write_profiles(tmp_path)
    for mechanics, load in (("asperities", "20 uN"), ("half-space", "2 mN")):
        lines = create_study_from_files(tmp_path, "lines", mechanics, spacing=spacing, members=8, load=load)
        result = compute_study_onset(lines)
        assert result.attrs["members"] >= 6
        assert math.isfinite(float(result["displacement_at_sliding"].sel(statistic="mean"))) == (
            mechanics == "asperities"
        )
        assert ("iwan_chi" in result.attrs) == (mechanics == "asperities")
        assert "slips" in onset_text(read_onset_summary(result))


def test_onset_of_sliding_of_a_result_with_several_cutoffs_is_computed_at_the_reported_cutoff():
    roughness = {"hurst_exponent": 0.7, "rms": 0.01, "longest_wavelength": 5.0, "shortest_wavelength": 0.05}
    noise = 1e-3 * np.random.default_rng(1).normal(size=(2, 3000))
    profiles = [
        Profile(self_affine(seed, points=3000, spacing=0.01, **roughness).heights + item, spacing=0.01)
        for seed, item in enumerate(noise)
    ]
    options = {"load": "10 MPa", "mu0": 0.2, "effective_modulus": "80 GPa", "offsets": 8}
    study = pair_study(*profiles, **options)
    quoted_cutoff, other_cutoff = study.surfaces.cell_coordinates()["cut_off"].tolist()
    assert quoted_cutoff > other_cutoff == 0
    onset_by_cutoff = {
        cutoff: compute_study_onset(study.with_changes({"surfaces.cut_off": [f"{cutoff!r} um"]}))
        for cutoff in (quoted_cutoff, other_cutoff)
    }
    result = compute_study_onset(study)
    xarray.testing.assert_identical(result, onset_by_cutoff[quoted_cutoff])
    assert float(abs(result["displacement"] - onset_by_cutoff[other_cutoff]["displacement"]).max()) > 0


def test_onset_of_sliding_of_a_result_is_none_if_mu0_and_tau0_are_zero_or_surfaces_are_generated(study):
    assert compute_study_onset(study.with_changes({"friction.mu0": [0.0], "friction.tau0": ["0 MPa"]})) is None
    assert compute_study_onset(Study.named("quick")) is None


def test_slip_map_contains_the_load_at_which_each_point_slips(study, onset, monkeypatch):
    upper, lower = read_measured_bodies(study).member(0, 0.0).pair
    curve = half_space(upper, lower, [2.0], effective_modulus=100.0, hardness=4.0, compliance_share=0.3)
    member_onset = curve.onset(0, mu0=0.3, tau0=0.05, steps=onset["fraction"].values.tolist(), poisson=[0.3, 0.4])
    expected = (member_onset.slip_load() / member_onset.sliding_load).reshape(lower.heights.shape)
    np.testing.assert_allclose(onset["slip"], expected, rtol=1e-6)
    in_contact = curve.contact(0).pressure > 0
    np.testing.assert_array_equal(np.isfinite(onset["slip"]), in_contact)
    slipped_fraction = curve.contact(0).pressure[onset["slip"].values <= 0.5].sum() / curve.contact(0).pressure.sum()
    assert slipped_fraction == pytest.approx(
        member_onset.slipped_load[onset["fraction"].values.tolist().index(0.5)], rel=1e-9
    )
    np.testing.assert_allclose(onset["lower_height"], lower.heights, rtol=1e-6)
    monkeypatch.setattr("stiction.companions.onset.MAX_PICTURE_SIDE_POINTS", 8)
    coarse_slip = compute_study_onset(study, members=1)["slip"].values
    assert coarse_slip.shape == (8, 8)
    for row, column in np.ndindex(8, 8):
        block = expected[5 * row : 5 * row + 5, 5 * column : 5 * column + 5]
        finite_values = block[np.isfinite(block)]
        assert coarse_slip[row, column] == pytest.approx(
            finite_values.min() if finite_values.size else np.nan, nan_ok=True
        )


def test_onset_result_of_the_asperity_model_lists_every_contact(tmp_path):
    study = create_study_from_files(tmp_path, mechanics="asperities", spacing=write_maps(tmp_path), members=2)
    result = compute_study_onset(study, members=1)
    pair = read_measured_bodies(study).member(0, 0.0).pair
    approach = approach_at_load(*pair, 2.0, mu0=0.0, effective_modulus=100.0, sliding="all")
    contact_list = contacts(*pair, float(approach), effective_modulus=100.0, sliding="all")
    np.testing.assert_allclose(result["contact_x"], contact_list.centre[:, 0], rtol=1e-9)
    np.testing.assert_allclose(result["contact_area"], contact_list.area, rtol=1e-6)
    assert float(result["contact_slip"].max()) == 1
    assert "slip" not in result


def test_figures_and_report_show_slip_map(study, onset, tmp_path):
    compute_missing_blocks(study, tmp_path)
    export(onset, tmp_path / ONSET_FILE)
    result = open_result(tmp_path)
    assert {"onset", "slip"} <= set(result.figures())
    figure = result.figure("slip")
    full_image, detail_image = (axes.images[-1] for axes in figure.axes[:2])
    assert np.ma.count(full_image.get_array()) == np.isfinite(onset["slip"]).sum()
    assert np.ma.count(detail_image.get_array()) > 0
    # Pixels are centred on grid points.
    for centres, name in zip(find_pixel_centres(full_image), ("slip_x", "slip_y"), strict=True):
        np.testing.assert_allclose(centres, onset[name], atol=1e-12)
    page = report_page(open_stored_result(tmp_path))
    for heading in ("Onset of sliding", "Order of slip", "light points slip first"):
        assert heading in page
    assert page.count('<div class="figure"><svg role="img"') == 3
    export(onset.drop_vars(["slip", "lower_height"]), tmp_path / ONSET_FILE, replace=True)
    assert "slip" not in open_result(tmp_path).figures()
    with disable_drawing():
        assert "Order of slip" not in report_page(open_stored_result(tmp_path))


def test_stored_onset_of_sliding_for_another_mu0_is_ignored(study, onset, tmp_path):
    compute_missing_blocks(study, tmp_path)
    stored_result = open_stored_result(tmp_path)
    assert load_stored_onset(stored_result) is None
    export(onset, tmp_path / ONSET_FILE)
    assert load_stored_onset(stored_result).identical(onset)
    onset_at_other_mu0 = onset.assign_attrs(mu0=0.4)
    export(onset_at_other_mu0, tmp_path / ONSET_FILE, replace=True)
    assert load_stored_onset(stored_result) is None


def test_onset_csv_table_starts_at_zero_tangential_load_and_displacement(onset):
    table = pandas.read_csv(io.StringIO(format_backbone_csv(onset)))
    assert (table.iloc[0] == 0).all()
    np.testing.assert_allclose(table["displacement (um)"][1:], onset["displacement"].sel(statistic="mean"), rtol=1e-8)


def test_onset_table_and_json_record_have_equal_displacements(onset):
    values = read_onset_summary(onset)
    record = onset_record(values)
    assert "Pre-sliding displacement " in onset_text(values)
    assert record["iwan"]["chi"] == onset.attrs["iwan_chi"]
    assert len(record["curve"]) == onset.sizes["fraction"]
    for scale in (1.0, 1e3):
        scaled_onset = onset.assign({name: scale * onset[name] for name in ("displacement_at_sliding", "stiffness")})
        rows = dict(onset_rows(read_onset_summary(scaled_onset))[1:])
        (name,) = (name for name in rows if name.startswith("pre-sliding displacement"))
        value = float(rows[name].split()[0]) * {"nm": 1e-3, "µm": 1.0, "mm": 1e3}[name.split("(")[1][:-1]]
        assert value == pytest.approx(scale * record["displacement_at_sliding"]["value"], rel=0.1)


def test_onset_text_states_its_load_if_the_study_has_several_loads(study, onset):
    values = read_onset_summary(onset)
    assert "at a load of" not in onset_text(values, study)
    loads = [f"{factor * values.load!r} mN" for factor in (1, 1.5)]
    study_of_loads = study.with_changes({"friction.load": loads, "contact.load": loads})
    assert onset_text(values, study_of_loads).endswith(f"(at a load of {format_with_unit(values.load, 'mN')}).")


def test_onset_text_states_the_sliding_rule_of_the_onset_if_the_interface_has_another_rule(study, onset):
    values = read_onset_summary(onset)
    interface = {"file": "film.csv", "mu0": 0.3, "tau0": "0 MPa", "sliding": "opposing"}
    texts = [
        format_paragraph(onset_paragraph(values, displayed_study, verbose=False))
        for displayed_study in (study, study.with_changes({"friction.interface": interface}))
    ]
    assert "friction at all contacts" not in texts[0]
    assert "These values assume friction at all contacts." in " ".join(texts[1].split())


@pytest.mark.parametrize(
    ("law", "is_stated"), [({}, False), ({"law": "jackson-green", "yield_strength": "1 GPa"}, True)]
)
def test_onset_text_states_that_the_stiffness_is_hertzian_if_the_contact_law_is_not(law, is_stated):
    bodies = [
        self_affine_surface(3, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, side=side)
        for side in ("upper", "lower")
    ]
    options = {"mechanics": "asperities", "young": "100 GPa", "poisson": 0.3, "mu0": 0.2, "shifts": 2, "onset": 2}
    result = pair(*bodies, load="10 MPa", **options, **law)
    for verbose in (False, True):
        summary = result.summary()
        paragraph = onset_paragraph(summary.onset_values, summary.study, verbose=verbose)
        text = " ".join(format_paragraph(paragraph).split())
        assert ("law jackson-green, but the stiffness of elastic Hertzian contacts" in text) == is_stated


def test_sliding_load_is_the_friction_coefficient_times_the_normal_load(tmp_path):
    bodies = rough_maps(5, hurst_exponent=0.7, rms=0.01, points=64, spacing=0.05, shortest_wavelength=0.3)
    options = {
        "load": "50 MPa", "hardness": "120 HV ± 10 %", "mu0": "0.1..0.3", "tau0": "50 MPa", "effective_modulus": 80.0,
        "junction_growth": "0..27", "shifts": 4, "cutoff": "none",
    }  # fmt: skip
    result = pair(*bodies, **options, onset=2, directory=tmp_path / "pair")
    coefficient, values = result.summary().first.rules[0], result.summary().onset_values
    assert values.sliding_load.kind == "combined"
    limits = np.array([coefficient.value, coefficient.lower, coefficient.upper]) * values.load
    sliding_load = values.sliding_load
    np.testing.assert_allclose([sliding_load.value, sliding_load.lower, sliding_load.upper], limits, rtol=1e-12)
    stored_onset = load_stored_onset(open_stored_result(tmp_path / "pair"))
    stored_load = float(stored_onset["sliding_load"].sel(statistic="mean"))
    factor = limits[0] / stored_load
    assert factor > 1.02
    for name, power in (("energy_lost", 2), ("tangential_load", 1), ("displacement", 1), ("slipped_area", 0)):
        scaled_values, expected = (
            onset_table[name].sel(statistic="mean").values for onset_table in (result.onset, stored_onset)
        )
        np.testing.assert_allclose(scaled_values, expected * factor**power, rtol=1e-12, err_msg=name)
    np.testing.assert_array_equal(result.onset["stiffness"], stored_onset["stiffness"])
    table = pandas.read_csv(tmp_path / "pair" / "onset.csv")
    for suffix, limit in zip(("", ": lower", ": upper"), limits, strict=True):
        assert table[f"tangential load (mN){suffix}"].iloc[-1] == pytest.approx(limit, rel=1e-8)
    record = onset_record(values)
    assert record["curve"][-1]["tangential_load"]["value"] == record["sliding_load"]["value"]


def test_pair_function_replaces_an_onset_table_of_an_earlier_call(tmp_path):
    bodies = rough_maps(5, hurst_exponent=0.7, rms=0.01, points=48, spacing=0.05, shortest_wavelength=0.3)
    options = {
        "load": "50 MPa", "hardness": "1.2 GPa", "mu0": "0.1..0.3", "tau0": "50 MPa", "effective_modulus": 80.0,
        "junction_growth": 9, "shifts": 2, "cutoff": "none", "onset": 1, "directory": tmp_path / "pair",
    }  # fmt: skip
    pair(*bodies, **options)
    file = tmp_path / "pair/onset.csv"
    scaled_csv = file.read_text("utf-8")
    unscaled_csv = format_backbone_csv(load_stored_onset(open_stored_result(tmp_path / "pair")))
    assert scaled_csv != unscaled_csv
    file.write_text(unscaled_csv, encoding="utf-8")
    pair(*bodies, **options)
    assert file.read_text("utf-8") == scaled_csv


def test_scaling_an_onset_scales_the_iwan_sliding_load_but_not_the_fitted_stiffnesses(onset):
    coefficient = Estimate(0.5, 0.4, 0.7, kind="combined")
    scaled_onset = scale_onset(onset, coefficient)
    factor = 1.0 / float(onset["sliding_load"].sel(statistic="mean"))  # the load is 2 mN
    assert scaled_onset.attrs["iwan_sliding_load_mN"] == pytest.approx(
        factor * onset.attrs["iwan_sliding_load_mN"], rel=1e-12
    )
    unchanged_names = ("iwan_stiffness_mN_per_um", "lugre_sigma0_mN_per_um")
    for name in unchanged_names:
        assert scaled_onset.attrs[name] == onset.attrs[name]
    for name in ("iwan_chi", "iwan_beta", "iwan_largest_residual", "lugre_largest_residual"):
        assert scaled_onset.attrs[name] == onset.attrs[name]
    curve = scaled_onset.sel(statistic="mean")
    displacement, load = (curve[name].values for name in ("displacement", "tangential_load"))
    fit = fit_iwan(displacement, load, sliding_load=1.0, stiffness=scaled_onset.attrs["iwan_stiffness_mN_per_um"])
    assert fit.chi == pytest.approx(scaled_onset.attrs["iwan_chi"], abs=1e-6)
    assert fit.beta == pytest.approx(scaled_onset.attrs["iwan_beta"], rel=1e-6)
