"""Test the values and caveats of single points of a summary, with numbers that the tests choose."""

import math

import numpy as np
import pytest
import xarray
from stiction.mechanics.friction import CENTRAL_SHEAR_RATIO
from stiction.summary.summary import summarize
from support.synthetic_results import measured_result, measured_study


def summarize_point(dataset, study=None, **options):
    return summarize(dataset, measured_study(hardness=2.0) if study is None else study, **options).points[0]


def find_caveats_with_text(point, text):
    return [(caveat.severity, caveat.text) for caveat in point.caveats if text in caveat.text]


def test_contributions_to_friction_add_up_to_the_coefficient():
    point = summarize_point(measured_result(all_contacts=0.24, contact_area=6.0))
    assert point.contributions == pytest.approx((0.2, 0.05 * 6.0 / 10.0, 0.24 - 0.2 - 0.03))
    assert sum(point.contributions) == pytest.approx(point.value)


def test_median_contact_size_is_the_diameter_of_a_circle_of_the_median_contact_area():
    point = summarize_point(measured_result())
    area = point.distributions["patch_area"][0.5]
    assert math.pi / 4 * point.contact_size.value**2 == pytest.approx(area.value)
    assert math.pi / 4 * point.contact_size.upper**2 == pytest.approx(area.upper)


def test_area_coefficient_kappa_equals_area_times_modulus_times_gradient_divided_by_load():
    point = summarize_point(measured_result(rms_gradient=0.25, mean_pressure=5.0))
    assert point.kappa == pytest.approx(100.0 * 0.25 / 5.0)


@pytest.mark.parametrize(("fraction", "is_dominant"), [(0.95, False), (0.85, True)])
def test_input_is_dominant_only_if_its_exact_value_would_narrow_the_interval_by_a_tenth(fraction, is_dominant):
    dataset = measured_result(half_width_ratio=0.05)
    dataset["friction_at_cutoff"] = dataset["mean_friction"]
    dataset["remaining_interval"] = dataset["mean_friction"].expand_dims(input=["hardness"])
    width = np.ptp(dataset["mean_friction"].sel(sliding="all", statistic=["lower", "upper"]).values)
    widths = xarray.full_like(dataset["mean_friction"].sel(statistic="mean", drop=True), fraction * width)
    dataset["remaining_width"] = widths.expand_dims(input=["hardness"])
    point = summarize_point(dataset.assign_coords(input_label=("input", ["the hardness"])))
    assert (point.dominant_input is not None) == is_dominant


@pytest.mark.parametrize(
    ("fraction", "severity"), [(0.009, None), (0.011, "caution"), (0.024, "caution"), (0.026, "fault")]
)
def test_samples_with_unlimited_friction_are_a_fault_if_the_interval_has_no_upper_limit(fraction, severity):
    study = measured_study(hardness=2.0).with_changes({"contact.junction_growth": "slip-line"})
    dataset = measured_result(load_share_at_hardness=0.5)
    dataset["fraction_unlimited"] = xarray.full_like(dataset["spread_low"], fraction)
    caveats = find_caveats_with_text(
        summarize_point(dataset, study), "of the samples of the inputs, the interface is stronger"
    )
    assert [actual_severity for actual_severity, _ in caveats] == ([severity] if severity else [])
    assert any("no upper limit" in text for _, text in caveats) == (severity == "fault")


@pytest.mark.parametrize(("tau0", "has_caveat"), [(0.26, False), (0.28, True)])
def test_tau0_near_the_shear_strength_of_the_body_has_a_caveat(tau0, has_caveat):
    """With α = 27 and H = 2 GPa, the shear strength is 0.385 GPa."""
    study = measured_study(hardness=2.0).with_changes({"contact.junction_growth": 27, "friction.tau0": [f"{tau0} GPa"]})
    dataset = measured_result(load_share_at_hardness=0.5, tau0=(tau0,))
    dataset["fraction_unlimited"] = xarray.zeros_like(dataset["spread_low"])
    assert bool(find_caveats_with_text(summarize_point(dataset, study), "nearly as strong as the bulk")) == has_caveat
    slip_lines = study.with_changes({"contact.junction_growth": f"slip-line {CENTRAL_SHEAR_RATIO}"})
    assert not find_caveats_with_text(summarize_point(dataset, slip_lines), "nearly as strong as the bulk")


@pytest.mark.parametrize(("pressure", "has_caveat"), [(0.85, False), (0.95, True)])
def test_contact_area_has_a_yielding_caveat_if_the_mean_pressure_is_near_half_the_hardness(pressure, has_caveat):
    study = measured_study(hardness=2.0).with_changes({"contact.yield_exponent": None})
    point = summarize_point(measured_result(mean_pressure=pressure), study)
    assert bool(find_caveats_with_text(point, "yielding below the surface is neglected")) == has_caveat
    assert not find_caveats_with_text(
        summarize_point(measured_result(mean_pressure=pressure)), "yielding below the surface"
    )


@pytest.mark.parametrize(("load_fraction_at_hardness", "has_caveat"), [(0.0, True), (0.9, False)])
def test_drift_of_the_rms_slope_along_a_scan_has_a_caveat_unless_yielded_contacts_carry_most_of_the_load(
    load_fraction_at_hardness, has_caveat
):
    dataset = measured_result(all_contacts=0.4, load_share_at_hardness=load_fraction_at_hardness)
    point = summarize_point(dataset.assign_attrs(upper_drift=(0.1, 0.5)))
    assert bool(find_caveats_with_text(point, "rms slope changes by a factor of 1.1")) == has_caveat


@pytest.mark.parametrize(("ratio", "has_caveat"), [(2.5, False), (3.5, True)])
def test_scan_more_than_three_times_coarser_than_the_other_scan_has_a_caveat(ratio, has_caveat):
    dataset = measured_result().assign_attrs(upper_spacing_um=0.1 * ratio, lower_spacing_um=0.1)
    assert bool(find_caveats_with_text(summarize_point(dataset), "times coarser than the lower")) == has_caveat


def test_friction_range_for_finer_scans_is_omitted_if_another_cutoff_or_preparation_has_a_fault():
    study = measured_study(hardness=2.0).with_changes({"surfaces.both_readings": True})
    dataset = measured_result(cut_offs=(0.5, 0.0), half_width_ratio=0.02, all_contacts=0.25)
    assert summarize_point(dataset, study).bracket is not None
    faulty_dataset = dataset.copy(deep=True)
    faulty_dataset["mean_friction"].loc[{"cut_off": 0.0, "statistic": "upper"}] = 2.0
    assert summarize_point(faulty_dataset, study).bracket is None

    precise_result, wide_result = measured_result(half_width_ratio=0.02), measured_result(half_width_ratio=0.9)
    assert summarize_point(precise_result).bracket is not None
    alternative = summarize(wide_result, measured_study(hardness=2.0))
    point = summarize_point(precise_result, alternatives={"spikes": alternative})
    assert point.bracket is None
    assert find_caveats_with_text(point, "without outliers")[0][0] == "fault"


def test_friction_range_for_finer_scans_starts_at_the_plastic_limit_with_junction_growth():
    study = measured_study(hardness=1.0).with_changes({"contact.junction_growth": 27})
    point = summarize_point(measured_result(all_contacts=0.3, half_width_ratio=0.01), study)
    # The pressure p of plastic contacts satisfies p² + α (mu0 p + tau0)² = H².
    pressure = max(np.roots([1 + 27 * 0.2**2, 2 * 27 * 0.2 * 0.05, 27 * 0.05**2 - 1.0]))
    assert point.bracket[0] == pytest.approx(0.2 + 0.05 / pressure)
    assert point.roughness_contribution == pytest.approx(0.3 - point.bracket[0])
