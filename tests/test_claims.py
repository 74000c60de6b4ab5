"""Tests of `./dev claims`; for each part of a claim, data are created for which the part is true or false."""

import importlib.util
import math
import sys
from pathlib import Path

import numpy as np
import pytest
from stiction import Study, area_map, friction_map, run, stiffness_map
from support.generated_studies import empty_dataset

CLAIMS_SCRIPT = Path(__file__).parents[1] / "docs/scripts/claims.py"
if not CLAIMS_SCRIPT.exists():
    pytest.skip("the directory docs is not in this tree", allow_module_level=True)
pytestmark = pytest.mark.docs
_CLAIMS_MODULE_SPEC = importlib.util.spec_from_file_location("claims", CLAIMS_SCRIPT)
claims = sys.modules["claims"] = importlib.util.module_from_spec(_CLAIMS_MODULE_SPEC)
_CLAIMS_MODULE_SPEC.loader.exec_module(claims)
CLAIMS, CLAIM_PARTS, ClaimPartOutcome, ClaimPart, judge_claims = (
    claims.CLAIMS,
    claims.CLAIM_PARTS,
    claims.ClaimPartOutcome,
    claims.ClaimPart,
    claims.judge_claims,
)
render_claims, render_claim_variants, claim_verdict = (
    claims.render_claims,
    claims.render_claim_variants,
    claims.claim_verdict,
)

SMALL_CLAIMS_STUDY = claims.claims_study().with_changes(
    {
        "surfaces.fractal_dimension.count": 8,
        "surfaces.points": 10_000,
        "surfaces.extent": "5 um",
        "contact.approach.count": 16,
        "ensemble.repetitions": 40,
    }
)


@pytest.fixture(scope="module")
def result():
    return run(SMALL_CLAIMS_STUDY).dataset


@pytest.fixture(scope="module")
def resampled_means(result):
    return claims.ResampledMeans(result, 0.1)


def test_studies_for_the_claims_have_the_settings_of_the_paper():
    study = claims.claims_study()
    assert study.surfaces.fractal_dimensions().size == 50
    assert study.ensemble.repetitions == 100
    assert study.with_changes({"surfaces.amplitude": ["0.1 um"]}).surfaces == Study().surfaces
    for name, changes in claims.STUDY_VARIANTS.items():
        variant = claims.variant_study(name)
        assert (variant.surfaces.fractal_dimensions().size, variant.ensemble.repetitions) == (15, 100)
        assert (variant == claims.variant_study("default")) == (not changes)


def test_first_resampled_ensemble_has_friction_and_area_and_stiffness_of_the_original_ensemble(result, resampled_means):
    load = resampled_means.middle_load
    for quantity, tau0, expected in (
        ("friction", 0.0, friction_map(result, [load], mu0=[0.4], tau0=[0.0])["friction_coefficient"]),
        ("friction", 0.2, friction_map(result, [load], mu0=[0.4], tau0=[0.2])["friction_coefficient"]),
        ("area", 0.0, area_map(result, [load], mu0=[0.4], tau0=[0.0])["contact_area"]),
        ("stiffness", 0.2, stiffness_map(result, [load], mu0=[0.4], tau0=[0.2])["normal_stiffness"]),
    ):
        for amplitude in (0.05, 0.1, 0.2):
            resampled_values = resampled_means.evaluate_at(quantity, load, tau0=tau0, amplitude=amplitude)[0]
            reference = expected.sel(amplitude=amplitude).values[:, 0, 0, 0]
            assert np.isfinite(reference).sum() >= 6
            assert np.allclose(resampled_values, reference, rtol=1e-12, equal_nan=True)


def test_resampled_intervals_agree_with_intervals_of_the_friction_map(result, resampled_means):
    resampled_values = resampled_means.evaluate_at("friction", resampled_means.middle_load)[1:]
    lower, upper = np.quantile(resampled_values, [0.025, 0.975], axis=0)
    expected_map = friction_map(result, [resampled_means.middle_load], mu0=[0.4], tau0=[0.0]).sel(amplitude=0.1)
    ratio = (np.log(upper / lower) / np.log(expected_map["upper"] / expected_map["lower"]).values.ravel())[:6]
    assert ratio.min() > 0.6
    assert ratio.max() < 1.5


def test_light_middle_and_heavy_loads_are_inside_the_computed_loads_of_every_fractal_dimension(result, resampled_means):
    mean_loads = result["normal_elastic"].sel(amplitude=0.1).mean("repetition")
    assert (
        float(mean_loads.isel(approach=0).max())
        < resampled_means.light_load
        < resampled_means.middle_load
        < resampled_means.heavy_load
    )
    assert resampled_means.heavy_load < float(mean_loads.max("approach").min())
    assert resampled_means.middle_load**2 == pytest.approx(
        (resampled_means.light_load * resampled_means.heavy_load), rel=1e-9
    )


def judge_values(values, lower_bound, upper_bound):
    class ResampledMeansStandIn(claims.ResampledMeans):
        def __init__(self):
            self.excluded_dimensions = set()

    return ClaimPartOutcome.judge(
        ClaimPart("1a", "a number", lower_bound, upper_bound, lambda _: np.asarray(values, dtype=float)),
        ResampledMeansStandIn(),
    )


def test_verdict_on_a_part_of_a_claim_is_derived_from_its_interval():
    values = np.concatenate([[1.0], np.linspace(0.5, 1.5, 400)])
    assert judge_values(values, 0.0, math.inf).verdict == "true"
    assert judge_values(values, 2.0, math.inf).verdict == "false"
    assert judge_values(values, 1.4, math.inf).verdict == "undecided"
    assert judge_values(values, -math.inf, 0.4).verdict == "false"
    assert judge_values(values, 0.6, 1.7).verdict == "undecided"
    assert judge_values(values, 0.4, 1.6).verdict == "true"
    assert judge_values(values, 0.4, 1.6).lower == pytest.approx(0.525, abs=0.003)
    assert judge_values([math.nan] * 401, 0.0, 1.0).verdict == "undefined"


def test_verdict_on_a_claim_is_derived_from_verdicts_on_its_parts():
    def judge_claim_of_parts(*names):
        part = ClaimPart("4a", "", 0, 1, lambda _: np.zeros(1))
        return claim_verdict(4, [ClaimPartOutcome(part, 0, 0, 0, name, ()) for name in names])

    assert judge_claim_of_parts("true", "true") == "true"
    assert judge_claim_of_parts("true", "undecided") == "undecided"
    assert judge_claim_of_parts("undecided", "false", "true") == "false"
    assert judge_claim_of_parts("undefined", "true") == "undefined"


def test_parts_of_claims_have_unique_names():
    assert {part.claim_number for part in CLAIM_PARTS} == set(CLAIMS)
    assert len({part.name for part in CLAIM_PARTS}) == len(CLAIM_PARTS)
    assert all(part.min_value < part.max_value for part in CLAIM_PARTS)


def create_result(**sum_functions):
    """Return a result in which the loads are equal at all dimensions D and all amplitudes a.

    Functions of (D, a, load) may replace the sums.
    """
    study = SMALL_CLAIMS_STUDY.with_changes({"ensemble.repetitions": 40})
    result = empty_dataset(study)
    factor = np.random.default_rng(3).lognormal(0, 0.02, size=40)[:, np.newaxis]
    load = np.broadcast_to(1e3 * study.contact.loading_steps() ** 1.5 * factor, result["normal_elastic"].shape)
    dimension = study.surfaces.fractal_dimensions()[:, np.newaxis, np.newaxis, np.newaxis]
    amplitude = study.surfaces.amplitudes()[:, np.newaxis, np.newaxis]
    default_functions = {"contact_area": lambda d, a, f: f, "tangential_elastic": lambda d, a, f: 0.3 * f}
    result["normal_elastic"].values[...] = load
    result["contact_count"].values[...] = 1
    for name, sum_function in (default_functions | sum_functions).items():
        result[name].values[...] = sum_function(dimension, amplitude, load)
    return result


def judge_part(name, result, **options):
    """Return the outcome of one part of a claim."""
    (part,) = (part for part in CLAIM_PARTS if part.name == name)
    return ClaimPartOutcome.judge(part, claims.ResampledMeans(result, 0.1, **options))


def frictional_sum_functions(coefficient):
    return {"tangential_elastic": lambda d, a, f: coefficient(d, a, f) * f}


def adhesive_sum_functions(coefficient):
    """Return sums in which tau0 = 1 GPa increases the coefficient by a given amount."""
    return {"tangential_adhesive": lambda d, a, f: coefficient(d, a, f) * f}


# For each part of a claim: sums for which the part is true, and sums for which it is false.
TRUE_AND_FALSE_DATA = {
    "1a": ({}, {"contact_area": lambda d, a, f: np.sqrt(f)}),
    "1b": ({}, {"contact_area": lambda d, a, f: f**0.7}),
    "2a": (frictional_sum_functions(lambda d, a, f: 0.3 * d), frictional_sum_functions(lambda d, a, f: 0.3 / d)),
    "2b": (
        frictional_sum_functions(lambda d, a, f: 0.3 * np.exp(4 * np.maximum(d - 1.5, 0))),
        frictional_sum_functions(lambda d, a, f: 0.3 * np.exp(4 * np.minimum(d - 1.5, 0))),
    ),
    "2c": (
        {"tangential_frictional": lambda d, a, f: 0.2 * d * f},
        {"tangential_frictional": lambda d, a, f: 0.4 / d * f},
    ),
    "3a": (
        adhesive_sum_functions(lambda d, a, f: 0.5),
        adhesive_sum_functions(lambda d, a, f: np.where(d < 1.65, 0.5, -0.5)),
    ),
    "3b": (adhesive_sum_functions(lambda d, a, f: 2 - d), adhesive_sum_functions(lambda d, a, f: d)),
    "3c": (adhesive_sum_functions(lambda d, a, f: f**-0.2), adhesive_sum_functions(lambda d, a, f: f**0.2)),
    "3d": (adhesive_sum_functions(lambda d, a, f: 1), adhesive_sum_functions(lambda d, a, f: 30)),
    "4a": (adhesive_sum_functions(lambda d, a, f: 2 + (d - 1.4) ** 2), adhesive_sum_functions(lambda d, a, f: 2 + d)),
    "4b": (adhesive_sum_functions(lambda d, a, f: 2 + (d - 1.4) ** 2), adhesive_sum_functions(lambda d, a, f: 4 - d)),
    "4c": (
        adhesive_sum_functions(lambda d, a, f: 2 + (d - 1.4) ** 2),
        adhesive_sum_functions(lambda d, a, f: 2 + (d - 1.2) ** 2),
    ),
    "5": (
        frictional_sum_functions(lambda d, a, f: 0.3 * f**-0.1),
        frictional_sum_functions(lambda d, a, f: 0.3 * f**0.1),
    ),
    "6": (frictional_sum_functions(lambda d, a, f: 0.3), frictional_sum_functions(lambda d, a, f: 0.5)),
    "7a": ({"contact_area": lambda d, a, f: f / a}, {"contact_area": lambda d, a, f: f * a}),
    "7b": (adhesive_sum_functions(lambda d, a, f: 0.1 / a), adhesive_sum_functions(lambda d, a, f: 10 * a)),
    "7c": (
        frictional_sum_functions(lambda d, a, f: 0.3 * np.exp(10 * a * d)),
        frictional_sum_functions(lambda d, a, f: 0.3 * np.exp(0.1 * d / a)),
    ),
    "7d": (adhesive_sum_functions(lambda d, a, f: 0.1 / a), adhesive_sum_functions(lambda d, a, f: 10 * a)),
    "8a": ({}, {"normal_frictional": lambda d, a, f: -0.4 * f}),
    "8b": ({}, {"normal_adhesive": lambda d, a, f: -2 * f}),
    "8c": ({}, {"normal_frictional": lambda d, a, f: -0.4 * f}),
    "8d": ({}, {"normal_adhesive": lambda d, a, f: -2 * f}),
}


@pytest.mark.parametrize("name", TRUE_AND_FALSE_DATA)
def test_verdict_on_a_part_of_a_claim_is_true_only_if_the_data_support_it(name):
    outcomes = [judge_part(name, create_result(**sum_functions)) for sum_functions in TRUE_AND_FALSE_DATA[name]]
    assert [(outcome.verdict, outcome.excluded_dimensions) for outcome in outcomes] == [("true", ()), ("false", ())]


def test_number_computed_for_a_part_of_a_claim_equals_the_number_in_the_synthetic_data():
    def compute_part_value(name, **sum_functions):
        return judge_part(name, create_result(**sum_functions)).value

    assert compute_part_value("1b", contact_area=lambda d, a, f: f**0.7) == pytest.approx(0.7, abs=1e-3)
    assert compute_part_value("2b", **TRUE_AND_FALSE_DATA["2b"][0]) == pytest.approx(4, rel=1e-6)
    # tau0 = 200 MPa adds 0.2 (2 - D) to the coefficient. The part compares means over D = 1 to 1.2 and 1.6 to 1.7.
    assert compute_part_value("3b", **TRUE_AND_FALSE_DATA["3b"][0]) == pytest.approx(0.2 * (0.9 - 0.35), rel=1e-9)
    assert compute_part_value("3d", **TRUE_AND_FALSE_DATA["3d"][0]) == pytest.approx(0.001 / 0.3, rel=1e-9)
    assert compute_part_value("7a", **TRUE_AND_FALSE_DATA["7a"][0]) == pytest.approx(0.25, rel=1e-9)
    assert compute_part_value("7d", **TRUE_AND_FALSE_DATA["7d"][0]) == pytest.approx(0.2 * (2 - 0.5), rel=1e-9)
    assert compute_part_value("8d", **TRUE_AND_FALSE_DATA["8d"][1]) > 0.25


def test_synthetic_data_cover_every_part_of_a_claim():
    assert list(TRUE_AND_FALSE_DATA) == [part.name for part in CLAIM_PARTS]


def test_confidence_band_of_a_noisy_minimum_is_wider_than_its_percentile_interval():
    # The friction does not depend on D except for noise, which lowers the smallest value over D.
    noise = np.random.default_rng(1).lognormal(0, 0.5, size=(8, 1, 40, 1))
    result = create_result(**frictional_sum_functions(lambda d, a, f: 0.2 * noise))
    bands, percentiles = (
        judge_part("6", result, interval_method=interval_method) for interval_method in ("bands", "percentiles")
    )
    assert bands.lower < bands.value < bands.upper
    assert percentiles.upper - percentiles.value < 0.5 * (bands.upper - bands.value)


def test_generated_table_of_claims_has_a_column_for_each_contact_model_and_sliding_rule():
    table = CLAIMS_SCRIPT.parents[1] / "generated/columns.md"
    headings = [cell.strip() for cell in table.read_text("utf-8").splitlines()[0].split("|")[1:-1]]
    assert headings[-len(claims.CLAIMS_TABLE_COLUMNS) :] == list(claims.column_titles(2000).values())


def test_verdicts_in_a_column_use_the_sliding_rule_and_contact_model_of_the_column():
    assert {column.to_study(2000).contact.mechanics for column in claims.CLAIMS_TABLE_COLUMNS.values()} == {
        "asperities",
        "half-space",
    }
    column = claims.CLAIMS_TABLE_COLUMNS["half-spaces"]
    study = column.to_study(100)
    assert study.ensemble.repetitions == claims.MIN_REPETITIONS
    assert study.surfaces == claims.CLAIMS_TABLE_COLUMNS["half-spaces, friction at all contacts"].to_study(100).surfaces
    result = empty_dataset(study)
    load = study.contact.loading_steps()
    for name, values in {
        "normal_elastic": load,
        "contact_area": load**0.9,
        "approach": load ** (2 / 3),
        "normal_frictional": -0.1 * load,
    }.items():
        result[name].values[...] = values
    for rule, share in (("opposing", 0.2), ("all", 0.4)):
        result["tangential_elastic"].loc[{"sliding": rule}] = share * load
    for rule, share in (("opposing", 0.2), ("all", 0.4)):
        outcomes_by_name = {
            item.part.name: item for item in judge_claims(result, sliding=rule, interval_method="bands")
        }
        # At mu0 = 0.4, the normal load F_N is 0.96 of the elastic load.
        assert outcomes_by_name["6"].value == pytest.approx(share / 0.96 / 0.4, rel=1e-9)
        assert outcomes_by_name["1b"].value == pytest.approx(0.9, rel=1e-9)
        # F_N = c L and L = δ^1.5, so dF_N/dδ at equal F_N is proportional to c^(2/3), up to interpolation errors.
        assert outcomes_by_name["8c"].value == pytest.approx(1 - (0.9 / 0.99) ** (2 / 3), abs=0.01)
    with pytest.raises(ValueError, match="sliding"):
        judge_claims(create_result(), sliding="all")


def test_verdict_is_undefined_if_the_range_of_a_claim_has_only_one_fractal_dimension():
    result = create_result().sel(fractal_dimension=slice(1.0, 1.501))
    verdicts_by_name = {outcome.part.name: outcome.verdict for outcome in judge_claims(result)}
    undefined_parts = {name for name, verdict in verdicts_by_name.items() if verdict == "undefined"}
    assert undefined_parts == {"2b", "3b", "4b", "5", "7c"}
    result = create_result(**adhesive_sum_functions(lambda d, a, f: 3 - d)).sel(fractal_dimension=slice(1.0, 1.501))
    assert judge_part("4c", result).verdict == "undefined"


def test_verdict_by_confidence_bands_is_undefined_if_friction_is_finite_at_few_fractal_dimensions():
    assert judge_part("3b", create_result(), interval_method="bands").verdict == "undefined"
    with pytest.raises(ValueError, match="interval_method"):
        judge_claims(create_result(), interval_method="means")


def test_verdict_is_undefined_if_friction_is_undefined_at_most_fractal_dimensions_of_a_claim():
    sum_functions = {"normal_frictional": lambda d, a, f: np.where(d > 1.45, -5.0, 0.0) * f}
    outcomes_by_name = {outcome.part.name: outcome for outcome in judge_claims(create_result(**sum_functions))}
    assert outcomes_by_name["5"].verdict == "undefined"
    assert outcomes_by_name["2a"].excluded_dimensions == pytest.approx((1.5,))
    assert outcomes_by_name["2a"].verdict != "undefined"


def test_judging_claims_rejects_studies_with_too_few_repetitions_or_approaches_or_amplitudes():
    for change, match in (
        ({"ensemble.repetitions": 19}, "20 ensemble.repetitions"),
        ({"contact.approach": ["1 nm", "2 nm"]}, "3 values of contact.approach"),
        ({"surfaces.amplitude": ["0.1 um"]}, "amplitudes of 0.05"),
    ):
        with pytest.raises(ValueError, match=match):
            claims.check_study_suits_claims(SMALL_CLAIMS_STUDY.with_changes(change))


def test_tables_of_claims_contain_every_part_of_each_claim(result):
    outcomes = judge_claims(result)
    for text in (render_claims(outcomes), render_claim_variants({"one": outcomes})):
        for part in CLAIM_PARTS:
            assert f"{part.name} " in text
    rows = [line for line in render_claims(outcomes).splitlines() if line.startswith("|")]
    assert {line.replace("\\|", "").count("|") for line in rows} == {6}


def test_judging_claims_rejects_a_result_without_the_requested_roughness_amplitude(result):
    with pytest.raises(ValueError, match=r"no amplitude of 0\.3 µm"):
        judge_claims(result, amplitude=0.3)


def test_tables_of_claims_are_written_from_stored_results(tmp_path):
    small_study_changes = {"surfaces.points": 4000, "surfaces.extent": "2 um", "contact.approach.count": 6}
    claims.write_tables(tmp_path, tmp_path, changes=small_study_changes | {"ensemble.repetitions": 20})
    text = (tmp_path / "claims.md").read_text(encoding="utf-8")
    assert text.count("| **") == 2 * len(CLAIMS)
    claims.write_tables(tmp_path, tmp_path)
    assert (tmp_path / "claims.md").read_text(encoding="utf-8") == text
    assert "| amplitude 0.05 µm |" in (tmp_path / "variants.md").read_text(encoding="utf-8").splitlines()[0]
