import math

import numpy as np
import pytest
from stiction import Study, friction_map, run, stiffness_map
from stiction.studies import claims
from stiction.studies.claims import CLAIMS, PARTS, Outcome, Part, judge, verdict_of
from stiction.studies.ensemble import area_map
from stiction.studies.store import empty_dataset
from stiction.views.tables import claims_markdown, claims_text, variants_markdown

SMALL = claims.claims_study().with_changes(
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
    return run(SMALL)


@pytest.fixture(scope="module")
def resampled(result):
    return claims.Resampled(result, 0.1)


def test_the_studies_are_those_that_the_claims_are_about():
    study = claims.claims_study()
    assert study.surfaces.fractal_dimensions().size == 50
    assert study.ensemble.repetitions == 100
    assert study.with_changes({"surfaces.amplitude": ["0.1 um"]}).surfaces == Study().surfaces
    for name, changes in claims.VARIANTS.items():
        variant = claims.variant_study(name)
        assert (variant.surfaces.fractal_dimensions().size, variant.ensemble.repetitions) == (15, 100)
        assert (variant == claims.variant_study("default")) == (not changes)


def test_the_first_ensemble_is_that_of_the_maps(result, resampled):
    load = resampled.middle
    for what, tau0, expected in (
        ("friction", 0.0, friction_map(result, [load], mu0=[0.4], tau0=[0.0])["friction_coefficient"]),
        ("friction", 0.2, friction_map(result, [load], mu0=[0.4], tau0=[0.2])["friction_coefficient"]),
        ("area", 0.0, area_map(result, [load], mu0=[0.4], tau0=[0.0])["contact_area"]),
        ("stiffness", 0.2, stiffness_map(result, [load], mu0=[0.4], tau0=[0.2])["normal_stiffness"]),
    ):
        for amplitude in (0.05, 0.1, 0.2):
            ours = resampled.at(what, load, tau0=tau0, amplitude=amplitude)[0]
            wanted = expected.sel(amplitude=amplitude).values[:, 0, 0, 0]
            assert np.isfinite(wanted).sum() >= 6
            assert np.allclose(ours, wanted, rtol=1e-12, equal_nan=True)


def test_resampled_intervals_are_as_wide_as_those_of_the_maps(result, resampled):
    found = resampled.at("friction", resampled.middle)[1:]
    lower, upper = np.quantile(found, [0.025, 0.975], axis=0)
    theirs = friction_map(result, [resampled.middle], mu0=[0.4], tau0=[0.0]).sel(amplitude=0.1)
    ratio = (np.log(upper / lower) / np.log(theirs["upper"] / theirs["lower"]).values.ravel())[:6]
    assert ratio.min() > 0.6
    assert ratio.max() < 1.5


def test_loads_lie_between_those_that_every_dimension_reaches(result, resampled):
    elastic = result["normal_elastic"].sel(amplitude=0.1).mean("repetition")
    assert float(elastic.isel(approach=0).max()) < resampled.light < resampled.middle < resampled.heavy
    assert resampled.heavy < float(elastic.max("approach").min())
    assert resampled.middle**2 == pytest.approx((resampled.light * resampled.heavy), rel=1e-9)  # the middle in ratio


def outcome(values, least, most):
    class Fixed(claims.Resampled):
        def __init__(self):
            self.left_out = set()

    return Outcome.of(Part("1a", "a number", least, most, lambda _: np.asarray(values, dtype=float)), Fixed())


def test_a_part_is_judged_by_its_interval():
    values = np.concatenate([[1.0], np.linspace(0.5, 1.5, 400)])
    assert outcome(values, 0.0, math.inf).verdict == "true"
    assert outcome(values, 2.0, math.inf).verdict == "false"
    assert outcome(values, 1.4, math.inf).verdict == "undecided"
    assert outcome(values, -math.inf, 0.4).verdict == "false"
    assert outcome(values, 0.6, 1.7).verdict == "undecided"
    assert outcome(values, 0.4, 1.6).verdict == "true"
    assert outcome(values, 0.4, 1.6).lower == pytest.approx(0.525, abs=0.003)
    assert outcome([math.nan] * 401, 0.0, 1.0).verdict == "undefined"


def test_a_claim_is_as_true_as_its_parts():
    def verdicts(*names):
        part = Part("4a", "", 0, 1, lambda _: np.zeros(1))
        return verdict_of(4, [Outcome(part, 0, 0, 0, name, ()) for name in names])

    assert verdicts("true", "true") == "true"
    assert verdicts("true", "undecided") == "undecided"
    assert verdicts("undecided", "false", "true") == "false"
    assert verdicts("undefined", "true") == "undefined"


def test_every_claim_has_parts_with_names_of_their_own():
    assert {part.claim for part in PARTS} == set(CLAIMS)
    assert len({part.name for part in PARTS}) == len(PARTS)
    assert all(part.least < part.most for part in PARTS)


def made_up(area_exponent=1.0, friction=lambda dimension, load: 0.3 + 0 * dimension * load):
    """A result whose loads rise alike at every dimension, with a given A(F) and mu_s(D, F)."""
    study = SMALL.with_changes({"ensemble.repetitions": 20})
    result = empty_dataset(study)
    factor = np.random.default_rng(3).lognormal(0, 0.02, size=20)[:, np.newaxis]
    load = 1e3 * study.contact.approaches() ** 1.5 * factor
    dimension = study.surfaces.fractal_dimensions()[:, np.newaxis, np.newaxis, np.newaxis]
    result["normal_elastic"].values[...] = load
    result["contact_area"].values[...] = load**area_exponent
    result["tangential_elastic"].values[...] = friction(dimension, load) * load
    result["contact_count"].values[...] = 1
    return result


def verdicts(result):
    return {outcome.part.name: outcome.verdict for outcome in judge(result)}


def test_a_world_in_which_a_claim_holds_is_told_from_one_in_which_it_does_not():
    proportional = verdicts(made_up())
    assert proportional["1a"] == proportional["1b"] == "true"
    curved = judge(made_up(area_exponent=0.7))
    assert curved[1].part.name == "1b"
    assert curved[1].value == pytest.approx(0.7, abs=0.01)
    assert curved[1].verdict == "false"

    rising = made_up(friction=lambda d, load: 0.3 * np.exp(np.where(d > 1.5, 4 * (d - 1.5) + 0.5, d - 1)) + 0 * load)
    assert verdicts(rising)["2a"] == verdicts(rising)["2b"] == "true"
    falling = made_up(friction=lambda d, load: 0.3 * np.exp(1 - d) + 0 * load)
    assert verdicts(falling)["2a"] == "false"
    assert verdicts(falling)["2b"] != "true"

    by_load = {sign: verdicts(made_up(friction=lambda d, load, s=sign: 0.3 * load ** (-0.1 * s))) for sign in (1, -1)}
    assert (by_load[1]["5"], by_load[-1]["5"]) == ("true", "false")
    assert proportional["6"] == "true"
    assert verdicts(made_up(friction=lambda d, load: 0.5 + 0 * d * load))["6"] == "false"

    dip = made_up(friction=lambda d, load: 0.3 + (d - 1.4) ** 2 + 0 * load)
    assert {verdicts(dip)[name] for name in ("4a", "4b", "4c")} == {"true"}
    assert verdicts(falling)["4c"] == "false"


def test_tables_have_every_part(result):
    outcomes = judge(result)
    for text in (claims_text(outcomes), claims_markdown(outcomes), variants_markdown({"one": outcomes})):
        for part in PARTS:
            assert f"{part.name} " in text
    assert claims_text(outcomes).count("wanted") == len(PARTS)
    rows = [line for line in claims_markdown(outcomes).splitlines() if line.startswith("|")]
    assert {line.replace("\\|", "").count("|") for line in rows} == {6}


def test_an_amplitude_that_is_not_there_is_refused(result):
    with pytest.raises(ValueError, match=r"no amplitude of 0\.3 µm"):
        judge(result, amplitude=0.3)
