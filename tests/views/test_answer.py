"""What may be quoted of a result: each caveat has a case that raises it and one that does not."""

import math

import numpy as np
import pytest
from stiction.studies.assessment import METAL_YIELD_PRESSURE_RATIO, YIELD_PRESSURE_RATIO, Caveat
from stiction.studies.point import points
from stiction.studies.summary import ORIGIN, summarize, summarize_point
from stiction.views.point import averaged_directions_text
from stiction.views.sentence import KAPPA, READINGS_DIFFER, finer_text, inputs_text, sentence_text, slopes_text
from stiction.views.text import coefficients_text
from support.synthetic_results import generated_result, generated_study, measured_result, measured_study


def one(at, study):
    result = summarize(at, study).points
    assert len(result) == 1
    return result[0]


def texts(said):
    return "; ".join(caveat.text for caveat in said.caveats)


def test_measured_surfaces_quote_friction_at_all_contacts_first():
    message = one(measured_result(), measured_study(hardness=3.0))
    assert [rule.rule for rule in message.rules] == ["all", "opposing"]
    assert (message.value, message.lower, message.upper) == pytest.approx((0.21, 0.1995, 0.2205))
    assert (message.verdict, message.caveats) == ("Quote it", ())
    for words in (
        "μ_s = 0.21 [0.20, 0.22] with friction at all contacts",
        "0.110 [0.104, 0.116] with friction at opposing contacts only",
        "10 mN (1 MPa)", "μ0 = 0.2", "τ0 = 50 MPa", "E* = 100 GPa", "hardness 3 GPa", "points 100 nm apart",
        "the mean over 4 directions and 16 positions", "roughness contributes",
    ):  # fmt: skip
        assert words in sentence_text(message)
    assert sentence_text(message).endswith(".")
    assert (message.rules[0].low, message.rules[0].high) == (0.04, 0.19)  # of several members
    assert one(measured_result(all_rub=0.1, half=1.2), measured_study()).lower == 0
    at = measured_result()
    at["friction_coefficient"] *= 9  # of single directions, and not of all
    assert one(at, measured_study()).value == 0.21


def test_generated_surfaces_quote_the_rule_of_the_paper():
    message = summarize(generated_result(), generated_study()).points
    assert [item.at["fractal_dimension"] for item in message] == [1.1] * 4 + [1.4] * 4
    assert [rule.rule for rule in message[0].rules] == ["opposing"]
    assert "D = 1.1" in sentence_text(message[0])
    assert "elastic" not in inputs_text(message[0])


def test_summary_has_a_point_for_every_condition():
    message = summarize(measured_result(loads=(1.0, 10.0), mu0=(0.2, 0.3), tau0=(0.0, 0.05)), measured_study()).points
    assert [(item.at["load"], item.at["mu0"], item.at["tau0"]) for item in message] == [
        (load, mu0, tau0) for load in (1.0, 10.0) for mu0 in (0.2, 0.3) for tau0 in (0.0, 0.05)
    ]
    message = summarize(measured_result(cut_offs=(0.0, 0.5)), measured_study()).points
    assert ["low-pass filtered at 500 nm" in sentence_text(item) for item in message] == [False, True]


FAULTS = {
    "steep": ({"rms_gradient": 1.1}, {"rms_gradient": 0.9}, "gradient"),
    "pressure": (
        {"mean_pressure": 1.1 * YIELD_PRESSURE_RATIO * 100}, {"mean_pressure": 0.9 * METAL_YIELD_PRESSURE_RATIO * 100},
        "pressure",
    ),
    "edge": ({"share_at_edge": 0.55}, {"share_at_edge": 0.45}, "edge"),
    "points": ({"contact_count": 1e4, "contact_area": 90.0}, {"contact_count": 1e4, "contact_area": 110.0}, "points"),
    "contacts": ({"contact_count": 0.6, "members": 16}, {"contact_count": 12.0}, "contacts"),
    "few contacts": ({"contact_count": 4.9}, {"contact_count": 12.0}, "4.9 contacts on average are too few"),
    "one contact": ({"share_on_largest": 0.51}, {"share_on_largest": 0.39}, "one contact carries 51 %"),
    "below 0": ({"all_rub": -0.01}, {"all_rub": 0.01}, "below 0"),
    "beyond Hertz": ({"share_beyond_hertz": 0.6}, {"share_beyond_hertz": 0.4}, "Hertz"),
    "below the grid": ({"share_below_grid": 0.6}, {"share_below_grid": 0.4}, "spacing"),
    "wide": ({"half": 0.55}, {"half": 0.45}, "interval"),
    "no interval": ({"half": np.nan}, {}, "no interval"),
    "few answers": ({"ok": 7}, {"ok": 8}, "of 16 members"),
    "area": ({"contact_area_fraction": 1.01}, {"contact_area_fraction": 0.99}, "true area"),
    "merged": ({"share_overlapping": 0.6}, {"share_overlapping": 0.05}, "overlap"),
}  # fmt: skip


def test_sentence_contains_assessment_caveats_version_and_adhesion():
    caveat = Caveat("a parabola carries the load", "try --level quadratic", "caution")
    (point,) = summarize(
        measured_result().assign_attrs(stiction_version="1.2.3"), measured_study(), input_caveats=[caveat]
    ).points
    sentence = sentence_text(point)
    assert f"assessment: {point.verdict} ({caveat.text}" in sentence
    assert "stiction 1.2.3" in sentence
    assert "no adhesion" in sentence


@pytest.mark.parametrize("name", FAULTS)
def test_point_with_fault_has_no_number_in_its_sentence(name):
    raising, silent, word = FAULTS[name]
    message = one(measured_result(**raising), measured_study())
    assert message.verdict == "Do not quote"
    assert word in " ".join(caveat.text for caveat in message.caveats if caveat.severity == "fault")
    assert "μ_s =" not in sentence_text(message)
    assert word in sentence_text(message)
    assert one(measured_result(**silent), measured_study()).verdict == "Quote it"


CAUTIONS = {
    "pressure": ({"mean_pressure": 1.1 * METAL_YIELD_PRESSURE_RATIO * 100}, "harder than 1.1 GPa"),
    "small contacts": ({"fraction_on_small": 0.6}, "at most 4 points"),
    "few contacts": ({"contact_count": 9.0}, "few"),
    "one contact": ({"share_on_largest": 0.45}, "one contact carries"),
    "merging": ({"share_overlapping": 0.2}, "overlap"),
}


@pytest.mark.parametrize("name", CAUTIONS)
def test_point_with_caution_gives_the_reason(name):
    raising, words = CAUTIONS[name]
    message = one(measured_result(**raising), measured_study())
    assert message.verdict == "Quote with care"
    assert words in texts(message)
    assert "μ_s = 0.21" in sentence_text(message)


def test_much_coarser_scan_is_a_caveat():
    for spacing, words in (([0.4, 0.1], "the lower scan is 4 times coarser than the upper"), ([0.2, 0.1], "")):
        at = measured_result().assign_attrs(upper_spacing_um=[0.1, 0.1], lower_spacing_um=spacing)
        message = one(at, measured_study())
        assert words in texts(message)
        assert message.verdict == ("Quote with care" if words else "Quote it")


def test_pieces_much_smaller_than_the_scan_are_a_caveat():
    created = measured_study()
    created = created.with_changes({"surfaces.press": "surrogates"})
    for shape, verdict in ((300, "Quote with care"), (600, "Quote it")):
        at = measured_result().assign_attrs(shape=[shape, shape], spacing_um=[0.1, 0.1])
        for side in ("upper", "lower"):
            at = at.assign_attrs({f"{side}_spacing_um": [0.1], f"{side}_extent_um": [100.0]})
        message = one(at, created)
        assert message.verdict == verdict
        words = "pieces of 30 µm are pressed, without the longer wavelengths of the scan of 100 µm"
        assert (words in texts(message)) == (shape == 300)


@pytest.mark.parametrize(
    ("numbers", "study"),
    [
        ({"contact_count": 9.0, "contact_area_fraction": 0.4}, {}),  # few contacts that have merged are many
        ({"mean_pressure": 20.0}, {"hardness": 2.0}),
        ({"mean_pressure": 20.0}, {"mechanics": "asperities", "law": "jackson-green"}),
    ],
)
def test_caveat_is_absent_without_its_reason(numbers, study):
    assert one(measured_result(**numbers), measured_study(**study)).verdict == "Quote it"


@pytest.mark.parametrize("kind", ["measured", "generated"])
def test_material_without_yield_has_no_caveat_about_pressure(kind):
    at, study = (measured_result(), measured_study()) if kind == "measured" else (generated_result(), generated_study())
    at["mean_pressure"] = 0 * at["mean_pressure"] + 2e-4
    for modulus, has_caveat in ((0.003, False), (0.2, False)):
        study = study.with_changes({"contact.effective_modulus": f"{modulus} GPa"})
        at = at.assign_coords(effective_modulus=modulus)
        assert any("pressure" in caveat.text for caveat in summarize(at, study).points[0].caveats) == has_caveat
    at["mean_pressure"] = 0 * at["mean_pressure"] + 0.02
    assert any("pressure" in caveat.text for caveat in summarize(at, study).points[0].caveats)


def test_soft_surfaces_are_compared_with_known_hardness():
    study = measured_study(mechanics="asperities")
    study = study.with_changes({"contact.materials": ["mild steel", "brass"]})
    at = measured_result(mean_pressure=2.0).assign_coords(effective_modulus=0.05)
    assert any("brass yields" in caveat.text for caveat in summarize(at, study).points[0].caveats)


def test_pressure_of_generated_surfaces_is_at_most_a_caution():
    for pressure, verdict in ((0.4, "Quote it"), (0.6, "Quote with care")):
        message = summarize(generated_result(mean_pressure=pressure), generated_study()).points
        assert {item.verdict for item in message} == {verdict}


def test_missing_coefficient_has_its_status_as_reason():
    message = one(measured_result(status="not-reached", all_rub=np.nan, opposing=np.nan, ok=0), measured_study())
    assert (message.status, message.verdict) == ("not-reached", "Do not quote")
    assert "no solved load is as large" in sentence_text(message)
    text = coefficients_text([one(measured_result(all_rub=np.nan, opposing=np.nan), measured_study())])
    assert text.startswith("μ_s = none")
    assert "ok" not in text.splitlines()[0]


def test_caveats_about_inputs_are_listed_and_faults_come_first():
    beside = Caveat("a parabola carries the load", "try --level quadratic", "caution")
    at = measured_result(share_at_edge=0.6)
    message = summarize_point(next(points(at)), measured_study(), [beside])
    assert [caveat.severity for caveat in message.caveats] == ["fault", "caution"]
    assert message.caveats[1] == beside


@pytest.mark.parametrize(
    ("directions", "words"),
    [
        ([0.0], "the upper body moves to +x"),
        ([30.0], "the upper body moves at 30°"),
        ([0.0, 45.0], "the mean over 0° and 45°"),
        ([90.0, 270.0], "the mean over both directions along y"),
        (list(range(0, 360, 30)), "the mean over 12 directions all round"),
        (list(range(0, 180, 30)), "the mean over 0°, 30°, 60°, 90°, 120° and 150°"),
    ],
)
def test_averaged_members_are_described(directions, words):
    assert averaged_directions_text(directions) == words


def test_profiles_have_two_directions_and_a_nominal_pressure():
    message = one(measured_result(directions=(0.0, 180.0)), measured_study(press="lines", mechanics="asperities"))
    assert "the mean over both directions and 16 positions" in sentence_text(message)
    assert "(1 MPa)" not in sentence_text(message)  # of spheres on a strip as thick as somebody chose
    for study in ({"mechanics": "asperities", "law": "hertz-cylinder"}, {"mechanics": "half-space"}):
        message = one(measured_result(directions=(0.0, 180.0)), measured_study(press="lines", **study))
        assert "(1 MPa)" in sentence_text(message)


def test_reading_of_load_is_given_if_it_matters():
    for difference, message in ((2 * READINGS_DIFFER, True), (READINGS_DIFFER / 2, False)):
        sentence = sentence_text(one(measured_result(reading_difference=difference), measured_study()))
        assert ("the load is the elastic contact force" in sentence) == message
        assert ("with another definition of the load μ_s differs by 2 %" in sentence) == message


def test_small_slope_estimate_lists_neglected_effects():
    gradient, pressure = 0.2, 100 * 0.2 / KAPPA
    fitting = measured_result(rms_gradient=gradient, mean_pressure=pressure)
    for at, hardness, words in (
        (fitting, None, []),
        (fitting, 5.0, ["hardness is not considered"]),
        (measured_result(rms_gradient=gradient, mean_pressure=pressure / 2), None, ["does not apply"]),
    ):
        study = measured_study(hardness=hardness)
        message = slopes_text(one(at, study))
        assert "0.21 with friction at all contacts" in message
        for name in ("hardness", "does not apply"):
            assert (name in message) == any(name in word for word in words)
    without = measured_result(rms_gradient=gradient, mean_pressure=pressure / 2, tau0=(0.0,))
    assert "does not apply" not in slopes_text(one(without, measured_study()))


@pytest.mark.parametrize("is_floor", [True, False])
def test_first_of_two_readings_has_an_interval_over_both(is_floor):
    cut_offs = (0.5, 0.0) if is_floor else (0.0, 0.5)
    at = measured_result(cut_offs=cut_offs, loads=(1.0, 10.0), half=0.02, all_rub=0.25)
    for name in ("friction_all_round", "friction_coefficient"):
        at[name][{"cut_off": 1}] *= 0.84
    known = at["friction_all_round"].isel(cut_off=[0, 1])  # a budget in which the hardness decides
    at["friction_known"] = known
    at["friction_if_known"] = known.expand_dims(input=["hardness"])
    at["width_if_known"] = known.sel(statistic="mean", drop=True).expand_dims(input=["hardness"]) * 0.02
    at = at.assign_coords(input_words=("input", ["the hardness"]))
    severity = "caution" if is_floor else "fault"
    caveat = Caveat("waves below 400 nm have 40 % of the slope", "--cutoff '400 nm'", severity, 0.4, True)
    study = measured_study(hardness=2.0).with_changes({"surfaces.both_readings": True})
    result = summarize(at, study, input_caveats=[caveat]).points
    assert [one.covered for one in result] == [False, False, True, True]
    assert [one.at["cut_off"] for one in result] == [cut_offs[0]] * 2 + [cut_offs[1]] * 2
    for one in [item for item in result if not item.covered]:
        assert one.verdict == ("Quote with care" if is_floor else "Do not quote")
        assert (one.value, one.lower, one.upper) == pytest.approx((0.25, 0.21 * 0.98, 0.25 * 1.02))
        words = "with" if is_floor else "without"
        assert one.caveats[0].text.startswith(f"{caveat.text}; {words} them μ_s is 0.210 [0.206, 0.214]")
        assert [(left.words, left.lower) for left in one.budget] == [
            (ORIGIN, pytest.approx(0.245)), ("the hardness", pytest.approx(0.2058)),
        ]  # fmt: skip
        assert one.most.words == ORIGIN
        assert (one.bracket is None) == (not is_floor)
    alone = summarize(at, measured_study(hardness=2.0))
    assert alone.headlines == list(alone.points)


def test_filtered_reading_preserves_faults_of_the_unfiltered_scan():
    at = measured_result(cut_offs=(0.5, 0.0), half=0.02, all_rub=0.25)
    at["friction_all_round"].loc[{"cut_off": 0.0, "statistic": "upper"}] = 2.0  # an interval too wide to quote
    study = measured_study(hardness=2.0).with_changes({"surfaces.both_readings": True})
    quoted, other = summarize(at, study).points
    assert other.verdict == quoted.verdict == "Do not quote"
    assert any(fault.text.startswith("as measured: ") for fault in quoted.faults)


# ---- Materials and finer scans --------------------------------------------------------------------------------------


def with_materials(hardness, names=("mild steel", "brass")):
    study = measured_study(hardness=hardness)
    return study.with_changes({"contact.materials": list(names)})


def test_bracket_with_hardness_has_two_ends():
    one = summarize(measured_result(all_rub=0.24, half=0.01), measured_study(hardness=2.0)).points[0]
    limit = 0.2 + 0.05 / 2
    # The interval's end, and what is above the limit a fifth more for the load that moves between many contacts.
    assert one.bracket == pytest.approx((limit, limit + (0.24 * 1.01 - limit) * math.exp(0.2)))
    assert "a finer scan would give 0.225 (μ0 + τ0/H) to 0.246" in sentence_text(one)
    alike = summarize(measured_result(all_rub=0.2, half=1e-4, tau0=(0.0,)), measured_study(hardness=2.0)).points[0]
    assert "a finer scan would give 0.200 (μ0 + τ0/H)" in sentence_text(alike)
    assert summarize(measured_result(), measured_study()).points[0].bracket is None
    asperities = measured_study(hardness=2.0, mechanics="asperities")
    assert summarize(measured_result(), asperities).points[0].bracket is None
    # The ends meet where slopes put the answer below the limit.
    low, high = summarize(measured_result(all_rub=0.22, half=0.01), measured_study(hardness=2.0)).points[0].bracket
    assert low == pytest.approx(0.22)
    assert low < high
    # Nothing is said of finer scans where nothing is to be quoted.
    one = summarize(measured_result(all_rub=47.0, rms_gradient=300.0), measured_study(hardness=2.0)).points[0]
    assert (one.verdict, one.bracket) == ("Do not quote", None)
    assert "finer scan" not in coefficients_text([one])


@pytest.mark.parametrize(("reference", "said"), [("1.1 GPa", "1.1 GPa;"), ("0.9..1.3 GPa", "1.1 GPa (0.9..1.3 GPa);")])
def test_hardness_is_given_with_its_range(reference, said):
    study = measured_study(hardness=1.1).with_changes({"known.hardness": reference})
    assert f"hardness {said}" in sentence_text(one(measured_result(), study)).replace(", points", ";")


def test_generated_surrogates_are_reported():
    one = summarize(measured_result(members=16), measured_study(press="surrogates")).points[0]
    assert "16 pairs of random surfaces with these spectra" in sentence_text(one)
    assert "random" not in sentence_text(summarize(measured_result(members=16), measured_study()).points[0])


def test_materials_are_named_with_range_of_softer_hardness():
    one = summarize(measured_result(load_share_at_hardness=0.9), with_materials(0.625)).points[0]
    assert "mild steel on brass" in inputs_text(one)
    assert "hardness 625 MPa (230 MPa to 1.7 GPa)" in inputs_text(one)


@pytest.mark.parametrize(
    ("tau0", "message"),
    [(0.01, None), (0.05, "τ0 is 42 % of the shear strength of the softer body, 120 MPa"), (0.13, "seizure")],
)
def test_junction_growth_is_a_caveat_above_a_twentieth_of_friction(tau0, message):
    at = measured_result(load_share_at_hardness=0.9, mu0=(0.1 if tau0 < 0.02 else 0.2,), tau0=(tau0,))
    caveats = summarize(at, with_materials(0.625)).points[0].caveats
    grown = [caveat.text for caveat in caveats if "junction growth" in caveat.text]
    assert len(grown) == (message is not None)
    assert message is None or message in grown[0]
    elastic = (
        summarize(measured_result(load_share_at_hardness=0.0, tau0=(tau0,)), with_materials(0.625)).points[0].caveats
    )
    assert not any("junction growth" in item.text for item in elastic)


def test_zero_tau0_is_a_caveat():
    at = measured_result(tau0=(0.0,))
    at["friction_all_round"] = at["friction_all_round"] / 0.21 * 0.2012
    caveats = [caveat.text for caveat in summarize(at, measured_study()).points[0].caveats]
    assert caveats == ["τ0 is 0, so the coefficient is the given μ0; the surfaces add 0.001"]


@pytest.mark.parametrize(
    ("pressure", "severity"), [(2.0, ["fault"]), (1.0, ["caution"]), (0.2, [])], ids=["all", "some", "none"]
)
def test_materials_beyond_yield_are_named(pressure, severity):
    study = measured_study(mechanics="asperities")
    study = study.with_changes({"contact.materials": ["mild steel", "brass"]})
    caveats = summarize(measured_result(mean_pressure=pressure), study).points[0].caveats
    result = [caveat for caveat in caveats if "brass" in caveat.text]
    assert [caveat.severity for caveat in result] == severity
    assert all("brass yields at 230 MPa to 1.7 GPa" in caveat.text for caveat in result)


@pytest.mark.parametrize(
    "study", [with_materials(2.0), with_materials(0.625, ("one", "another")), measured_study(hardness=2.0)]
)
def test_measured_hardness_has_no_range(study):
    one = summarize(measured_result(load_share_at_hardness=0.9), study).points[0]
    assert "known" not in inputs_text(one)
    assert not any("softer material" in caveat.text for caveat in one.caveats)


def test_bracket_is_absent_with_a_fault():
    one = summarize(measured_result(all_rub=47.0, rms_gradient=300.0), measured_study(hardness=2.0)).points[0]
    assert (one.verdict, one.bracket) == ("Do not quote", None)
    assert "finer scan" not in coefficients_text([one])


def test_bracket_contains_value_below_plastic_limit():
    low, high = summarize(measured_result(all_rub=0.22, half=0.01), measured_study(hardness=2.0)).points[0].bracket
    assert low == pytest.approx(0.22)
    assert low < high


@pytest.mark.parametrize("changes", [{"contact_count": 4.9}, {"share_on_largest": 0.51}])
def test_few_merged_contacts_are_not_a_fault(changes):
    assert one(measured_result(**changes), measured_study()).verdict == "Do not quote"
    assert one(measured_result(**changes, contact_area_fraction=0.35), measured_study()).verdict != "Do not quote"


def test_contribution_of_roughness_is_the_remainder():
    study = measured_study(hardness=3.0)
    message = one(measured_result(all_rub=0.23), study)
    assert message.from_roughness == pytest.approx(0.23 - 0.2 - 0.05 / 3.0)
    assert message.hardness == 3.0
    assert one(measured_result(all_rub=0.23), measured_study()).from_roughness == pytest.approx(0.03)
    assert summarize(generated_result(), generated_study()).points[0].from_roughness is None


def test_bracket_names_its_hardness():
    message = finer_text(one(measured_result(), measured_study(hardness=3.0)))
    assert message.startswith("with H = 3 GPa a finer scan would give 0.21")
    assert finer_text(one(measured_result(), measured_study())) == ""


def test_generated_surfaces_are_assessed_by_contacts_and_tau0():
    message = summarize(generated_result(contact_count=7.0), generated_study()).points[0]
    assert "7 contacts on average are few" in texts(message)
    assert summarize(generated_result(contact_count=3.0), generated_study()).points[0].verdict == "Do not quote"
    assert "τ0 is 0, so the coefficient is the given μ0" in texts(
        summarize(generated_result(friction=0.4), generated_study()).points[0]
    )


def test_caveat_has_the_number_that_was_checked_and_its_limit():
    (caveat,) = one(measured_result(share_at_edge=0.6), measured_study()).caveats
    assert (caveat.name, caveat.value, caveat.limit) == ("share_at_edge", pytest.approx(0.6), 0.5)
    assert caveat.text == "60 % of the load is on contacts at the edge"
