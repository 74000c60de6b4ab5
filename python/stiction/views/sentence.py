"""Sentences on a result: a sentence to quote, its clauses, and details about one load, mu0 and tau0."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from stiction._estimate import Estimate
from stiction._number_format import format_percent, format_significant, format_time, format_with_unit
from stiction.evaluate.point import get_contact_law_name, has_limited_pressure
from stiction.mechanics.closed_forms import DEFAULT_KAPPA
from stiction.mechanics.materials import softest_material
from stiction.study.input_distributions import SLIP_LINE_TEXT, UncertainInput
from stiction.study.inputs import Inputs, find_interface, find_materials, has_hardness_of_table
from stiction.study.member_names import POSITION_NAMES, SURROGATE_PAIR_NAMES
from stiction.study.moduli import find_default_area_loss
from stiction.summary.assessment import estimate_size_effect
from stiction.summary.summary import PointSummary, Summary, has_central_value
from stiction.surfaces.pairing import SIDES
from stiction.views.point import (
    CONTRIBUTION_LABELS,
    SLIDING_RULE_DESCRIPTIONS,
    averaged_directions_text,
    coordinate_text,
    material_names_text,
    point_coordinate_text,
    point_load_text,
)
from stiction.views.pull_off import pull_off_text

if TYPE_CHECKING:
    from stiction.study.interfaces import InterfaceStrength
    from stiction.study.study import Study

MIN_STATED_LOAD_DEFINITION_EFFECT = 0.01
MIN_STATED_FINER_SCAN_RANGE = 0.05
MIN_STATED_KAPPA_DEVIATION = 0.2
"""Largest relative deviation of κ = A E* h'/F from the usual value for which the small-slope estimate applies."""


def finer_scan_text(point: PointSummary) -> str:
    """Return a clause on the range in which the coefficient of finer scans would lie.

    Returns "" if it is unknown.
    """
    if point.bracket is None or point.hardness is None:
        return ""
    lower_bound, upper_bound = (f"{end:.3f}" for end in point.bracket)
    bounds_text = f"{lower_bound} (μ0 + τ0/{'H′' if point.has_junction_growth else 'H'})" + (
        f" to {upper_bound}" if lower_bound != upper_bound else ""
    )
    # The indentation size effect may make small contacts harder.
    bounds_text += ", unless small contacts are harder"
    return f"with H = {format_with_unit(point.hardness, 'GPa')} a finer scan would give {bounds_text}"


def quotable_sentence(point: PointSummary) -> str:
    """Return the sentence to quote, including all inputs, or the reason why the coefficient must not be quoted."""
    assumptions = list_all_assumptions(point)
    if point.is_unloaded and point.pull_off is not None:
        sentence_parts = [
            f"{pull_off_text(point.pull_off).removesuffix('.')}, at {inputs_text(point)}",
            result_point_note(point),
        ]
        return "; ".join([*sentence_parts, f"assumed: {', '.join(assumptions)}"]) + "."
    if point.assessment == "Do not quote":
        fault_texts = "; ".join(caveat.text for caveat in point.faults)
        return f"There is no coefficient to quote at {inputs_text(point)}: {fault_texts}."
    # An interface was calibrated for one sliding rule, so only the coefficient under this rule is stated.
    rules = point.rules[:1] if point.has_values_of_interface else point.rules
    coefficients_text = ", ".join(f"{rule} with {SLIDING_RULE_DESCRIPTIONS[rule.rule]}" for rule in rules)
    sentence_parts = [f"μ_s = {coefficients_text}, at {inputs_text(point)}", result_point_note(point)]
    sentence_parts += [f"assumed: {', '.join(assumptions)}"] if assumptions else []
    sentence_parts += filter(
        None,
        [
            covered_inputs_text(point),
            roughness_contribution_text(point),
            finer_scan_text(point),
            point_assessment_text(point),
        ],
    )
    return "; ".join(sentence_parts) + "."


def quotable_sentences(summary: Summary) -> list[str]:
    """Return the sentences to quote: one per result point or, for generated surfaces, one per load.

    For generated surfaces, the other coordinates are those of the first point. If a coefficient must not be quoted, the
    sentence contains the reason, so that no load is left out.
    """
    points = summary.reported_points
    if not summary.study.is_measured:
        first_coordinates = {name: value for name, value in points[0].at.items() if name != "load"}
        points = [point for point in points if first_coordinates.items() <= point.at.items()]
    return [quotable_sentence(point) for point in points]


def covered_inputs_text(point: PointSummary) -> str:
    """Return a clause that lists the sources of uncertainty in the 95 % interval of a coefficient.

    Returns "" without an interval.
    """
    if math.isnan(point.upper - point.lower) or point.members < 2:
        return ""
    inputs = dict.fromkeys(contribution.label for contribution in point.budget) or [
        f"the mean over {_averaged_members_text(point)}"
    ]
    return f"95 % interval of {', '.join(inputs)}"


def point_assessment_text(point: PointSummary) -> str:
    """Return text on a coefficient: its assessment, its caveats and, if known, the version of stiction used."""
    caveats = "; ".join(caveat.text for caveat in point.caveats)
    text = f"assessment: {point.assessment}" + (f" ({caveats})" if caveats else "")
    version = point.values.attrs.get("stiction_version")
    return f"{text}; computed with stiction {version}" if version else text


def roughness_contribution_text(point: PointSummary) -> str:
    """Return a clause on the contribution of roughness to friction.

    Returns "" if the contribution is unknown.
    """
    if point.roughness_contribution is None or not math.isfinite(point.value):
        return ""
    return f"roughness contributes {round(point.roughness_contribution, 3) + 0.0:.3f} of {point.value:.3f}"


# ---- Conditions ------------------------------------------------------------------------------------------------------


def inputs_text(point: PointSummary, points: Sequence[PointSummary] = ()) -> str:
    """Return the inputs of a coefficient as text, such as load, roughness, mu0, tau0, materials and resolution.

    If the tests of an interface determine only the sum mu0 + tau0 A/F, the text contains this sum instead of mu0 and
    tau0. If `points` is given, the text contains the range of the contact hardness over these points.
    """
    study, items = point.study, [point_load_text(point)]
    if "fractal_dimension" in point.at:
        name, value = point.roughness_exponent
        items.append(f"{name} = {value:.3g}")
    if "amplitude" in point.at:
        items.append(f"amplitude {format_with_unit(point.at['amplitude'], 'um')}")
    if point.are_strengths_separated:
        items.append(f"μ0 = {point.at['mu0']:g}{input_range_text(point, 'mu0')}")
        items.append(f"τ0 = {coordinate_text('tau0', point.at['tau0'])}{input_range_text(point, 'tau0')}")
    if point.has_values_of_interface:
        items.append(_interface_text(point))
    if materials := material_names_text(study):
        items.append(materials)
    items.append(f"E* = {format_with_unit(point.effective_modulus, 'GPa')}")
    hardness = study.contact.hardness
    if hardness is not None:
        value_text = f"{format_with_unit(float(hardness), 'GPa')}{_hardness_range_text(study)}"
        items.append(f"hardness {value_text}{_hardness_source_text(study)}")
        if study.contact.indent is not None:
            items.append(contact_hardness_text(points or [point], float(study.contact.indent)))
        if (growth := study.contact.junction_growth) is not None:
            items.append(junction_growth_text(growth.estimate))
    elif loss := study.contact.area_loss:
        items.append(area_loss_text(study, loss.estimate))
    elif study.is_measured:
        items.append("yielding by Jackson and Green" if "jackson" in get_contact_law_name(study) else "elastic")
    if study.contact.adheres:
        work_of_adhesion = 1e6 * float(study.contact.work_of_adhesion or 0.0)
        range_text = format_with_unit(point.adhesion_range, "um")
        items.append(f"adhesion {work_of_adhesion:.3g} mJ/m² over {range_text}")
    if point.spacings:
        items.append(f"points {' and '.join(format_with_unit(spacing, 'um') for spacing in point.spacings)} apart")
    if point.at.get("cut_off", 0.0) > 0:
        items.append(f"low-pass filtered at {point_coordinate_text(point, 'cut_off')}")
    return ", ".join(items)


def junction_growth_text(growth: UncertainInput) -> str:
    """Return a phrase on junction growth: no growth, growth by slip-line theory, or growth with the factor α."""
    if growth.is_exact and growth.value == 0:
        return "no junction growth"
    if not growth.uses_slip_lines:
        return f"α = {growth.short_text}"
    ratio_text = growth.text.removeprefix(SLIP_LINE_TEXT).strip() or f"{growth.low:g}..{growth.high:g}"
    return f"yield by slip lines with H/k = {ratio_text}"


def contact_hardness_text(points: Sequence[PointSummary], indent: float) -> str:
    """Return a phrase on the depth `indent` (µm) of the hardness measurement, and on the hardness in the contacts.

    The hardness increases with decreasing load. For several result points, the text has the range of the hardness, and
    the interval encloses the intervals of all points.
    """
    hardnesses, lower, upper = zip(
        *(point.values["contact_hardness"].values.ravel().tolist() for point in points), strict=True
    )
    smallest_hardness, largest_hardness, lower_text, upper_text = (
        format_with_unit(hardness, "GPa") for hardness in (min(hardnesses), max(hardnesses), min(lower), max(upper))
    )
    hardness = " to ".join(dict.fromkeys((smallest_hardness, largest_hardness)))
    return f"measured {format_with_unit(indent, 'um')} deep, {hardness} [{lower_text}, {upper_text}] in the contacts"


def area_loss_text(study: Study, loss: UncertainInput) -> str:
    """Return a phrase on the fraction of the true area that elastic contacts lose under shear."""
    is_soft = find_default_area_loss(float(study.contact.effective_modulus)) is not None
    return f"{'elastomer' if is_soft else 'elastic'}, area loss under shear {loss.short_text}"


def input_range_text(point: PointSummary, name: str) -> str:
    """Return the range of mu0 or tau0 in brackets, or "" if the study has no range for this mu0 or tau0."""
    range_text = find_covered_range(point, name)
    return f" ({range_text})" if range_text else ""


def find_covered_range(point: PointSummary, name: str) -> str:
    """Return the range of mu0 or tau0 that a coefficient's interval covers, or "" if there is no such range.

    The range of the study applies only to its central value. Any other value is exact.
    """
    entry = Inputs.from_study(point.study).uncertain.get(name)
    return entry.estimate.text if entry is not None and has_central_value(point.study, point.at, name) else ""


def _interface_text(point: PointSummary) -> str:
    """Return a phrase on the interface that defines mu0 and tau0: name, kind, sliding rule and conditions."""
    study = point.study
    interface, name = find_interface(study), study.friction.interface.name if study.friction.interface else ""
    if interface is None:
        return f"interface {name}, which is missing, so μ0 and τ0 are independent"
    items = [interface.about.get("kind", "measured"), interface.about.get("motion", "")]
    items += [] if point.calibrated_rule is None else [SLIDING_RULE_DESCRIPTIONS[point.calibrated_rule]]
    if not point.are_strengths_separated:
        items.append(f"its tests determine only μ0 + τ0 A/F = {Estimate(*interface.identified).text()}")
    elif zeros := possible_zeros_text(interface, " or "):
        items.append(f"intervals include results for {zeros}")
    items += ["its range is unknown"] if interface.has_unknown_range else []
    return f"interface {name} ({', '.join(filter(None, items))})"


def strength_note(point: PointSummary) -> str:
    """Return a note if friction tests determine mu0 and tau0 only in combination; "" if they separate them.

    The note is for files with numbers for mu0 and tau0, which are then one of many possible pairs.
    """
    interface = find_interface(point.study)
    if point.are_strengths_separated or interface is None:
        return ""
    sum_text = f"μ0 + τ0 A/F = {Estimate(*interface.identified).text()}"
    return f"μ0 and τ0 are medians that are not known separately, because the tests determine only {sum_text}"


def possible_zeros_text(interface: InterfaceStrength, conjunction: str) -> str:
    """Return text that lists which of μ0 and τ0 may be zero according to the tests, such as "μ0 = 0".

    The text is empty if neither may be zero.
    """
    symbols = {"mu0": "μ0", "tau0": "τ0"}
    return conjunction.join(f"{symbols[name]} = 0" for name in interface.possible_zeros)


def _hardness_source_text(study: Study) -> str:
    """Return text that names the material from whose table entry the hardness comes; "" for any other hardness.

    The user may have given the range of the table.
    """
    hardness, softer_material = Inputs.from_study(study).estimate("hardness"), softest_material(*find_materials(study))
    if hardness is None or softer_material is None or not has_hardness_of_table(hardness, softer_material):
        return ""
    return f" as in the table for {softer_material.name}"


def _hardness_range_text(study: Study) -> str:
    """Return the range of the hardness in brackets, or "" if the hardness has no range."""
    hardness_input = Inputs.from_study(study).uncertain.get("hardness")
    if hardness_input is None:
        return ""
    if hardness_input.text == hardness_input.estimate.text:
        return f" ({hardness_input.text})"
    lower_text, upper_text = (
        format_with_unit(end, "GPa") for end in (hardness_input.estimate.low, hardness_input.estimate.high)
    )
    return f" ({lower_text} to {upper_text})"


_LOAD_DEFINITION_TEXTS = {
    "mean": "the load is the mean normal load of all repetitions",
    "elastic": "the load is the elastic contact force, without the contribution of friction on slopes",
    "normal": "the load is the normal load of each repetition or position",
}


def result_point_note(point: PointSummary) -> str:
    """Return a note on a coefficient: averages over directions and surface pairs, scan counts, load definition."""
    study, items = point.study, []
    if study.surfaces.press == "lines" and len(point.directions) == 2:
        items.append("the mean over both directions")
    elif point.directions and (study.is_measured or len(point.directions) > 1):
        items.append(averaged_directions_text(point.directions).removesuffix(" all round"))
    if point.members > 1:
        items = (
            [f"{items[0]} and {_averaged_members_text(point)}"]
            if items
            else [f"the mean over {_averaged_members_text(point)}"]
        )
    items += [_scan_count_text(study)] if study.is_measured else []
    definition_effect = point.load_definition_effect
    if definition_effect > MIN_STATED_LOAD_DEFINITION_EFFECT:
        definition_text = _LOAD_DEFINITION_TEXTS.get(
            str(point.values.attrs.get("load_definition")), "the load has one of three definitions"
        )
        items.append(
            f"{definition_text}; with another definition of the load μ_s differs by {format_percent(definition_effect)}"
        )
    return "; ".join(items)


def shared_conditions_text(points: Sequence[PointSummary]) -> str:
    """Return the conditions that several coefficients share as text: inputs, averaged surface pairs, assumptions."""
    inputs = [inputs_text(point, points).split(", ") for point in points]
    common_inputs = [text for text in inputs[0] if all(text in other_inputs for other_inputs in inputs)]
    common_inputs_note = f"with {', '.join(common_inputs)}; " if common_inputs else ""
    assumptions = list_assumptions(points[0].study)
    assumptions_note = f"; assuming {', '.join(assumptions)}" if assumptions else ""
    return f"{common_inputs_note}{_varying_ranges_note(points)}{result_point_note(points[0])}{assumptions_note}"


def _varying_ranges_note(points: Sequence[PointSummary]) -> str:
    """Return a note if the range of mu0 (or tau0) applies to only one of several values of mu0 (or tau0)."""
    notes = []
    for name, symbol in (("mu0", "μ0"), ("tau0", "τ0")):
        texts = {point.at[name]: input_range_text(point, name) for point in points if point.are_strengths_separated}
        if len(texts) > 1 and any(texts.values()):
            value, range_text = next(item for item in texts.items() if item[1])
            value_text = coordinate_text(name, value) if name == "tau0" else f"{value:g}"
            notes.append(f"{symbol} = {value_text} with the study's range{range_text}, every other {symbol} exact; ")
    return "".join(notes)


def _averaged_members_text(point: PointSummary) -> str:
    """Return the number and kind of the averaged surface pairs as text, as in "8 positions"."""
    study = point.study
    # For maps with positions and surrogates, a result point is the mean over the positions only.
    names = study.member_names if study.surfaces.press != "areas" else POSITION_NAMES
    explanation = " (random surfaces with these spectra)" if study.surfaces.press == "surrogates" else ""
    if num_surrogates := getattr(study.surfaces, "surrogates", 0) if study.surfaces.press == "areas" else 0:
        explanation = f" (without the {SURROGATE_PAIR_NAMES.with_count(num_surrogates)}, which the report lists)"
    return f"{point.members:.0f} {names[1]}{explanation}"


PROFILE_STRIP_TEXT = "a strip 1 µm wide"


def lay_assumption(study: Study) -> str:
    """Return text on the lay that is assumed for measured profiles or for surrogates; "" for other surfaces."""
    if not study.is_measured:
        return ""
    if study.surfaces.press == "lines":
        is_plane = study.uses_half_space or "cylinder" in get_contact_law_name(study)
        return f"{'parallel grooves across the scans' if is_plane else 'contacts of spheres'} on {PROFILE_STRIP_TEXT}"
    return "isotropic surfaces" if study.surfaces.press == "surrogates" else ""


def list_assumptions(study: Study) -> tuple[str, ...]:
    """Return the assumptions of a study about the lay, the contact model and adhesion."""
    if not study.is_measured:
        return ()
    contact = study.contact
    assumptions = [lay] if (lay := lay_assumption(study)) else []
    assumptions += [] if study.uses_half_space else ["contacts that do not interact"]
    assumptions += (
        [] if contact.hardness is not None or "jackson" in get_contact_law_name(study) else ["elastic contact"]
    )
    assumptions += ["no adhesion"] if contact.work_of_adhesion is None else []
    return tuple(assumptions)


def list_all_assumptions(point: PointSummary) -> tuple[str, ...]:
    """Return the assumptions that must be stated together with a quoted coefficient.

    There are none for generated surfaces.
    """
    study = point.study
    if not study.is_measured:
        return ()
    assumptions = [] if study.friction.interface is not None else ["μ0 and τ0 as given"]
    if study.uses_half_space:
        assumptions.append(
            "contact of half-spaces" if study.contact.hardness is None else "contact of yielding half-spaces"
        )
    assumptions += list_assumptions(study)
    if study.contact.work_of_adhesion is not None and not study.contact.adheres:
        assumptions.append("no adhesion")
    is_filtered = point.at.get("cut_off", 0.0) > 0
    assumptions.append(
        f"scans filtered at {point_coordinate_text(point, 'cut_off')}" if is_filtered else "scans not filtered"
    )
    return tuple(assumptions)


def _scan_count_text(study: Study) -> str:
    """Return text on how many scans each body has, with a remark if a body has a single scan."""
    scan_counts = study.surfaces.scan_counts
    if study.is_gap:
        return "one gap at its only position"
    if scan_counts == (1, 1):
        return "one scan of each part"
    text = f"{scan_counts[0]} × {scan_counts[1]} scans of both parts"
    single_scan_sides = [side for side, count in zip(SIDES, scan_counts, strict=True) if count == 1]
    return text + "".join(
        f", but only one of the {side}, so the spread between its places is not included" for side in single_scan_sides
    )


def small_slope_estimate_text(point: PointSummary) -> str:
    """Return a sentence on the small-slope estimate and on its validity.

    Returns "" without an estimate.
    """
    study = point.study
    rules = [rule for rule in point.rules if math.isfinite(rule.slopes)]
    if not rules:
        return ""
    estimates = " and ".join(f"{Estimate(rule.slopes)} with {SLIDING_RULE_DESCRIPTIONS[rule.rule]}" for rule in rules)
    hardness_note = " (the hardness is not considered)" if has_limited_pressure(study) else ""
    if point.at["tau0"] > 0 and abs(point.kappa / DEFAULT_KAPPA - 1) > MIN_STATED_KAPPA_DEVIATION:
        return (
            f"The small-slope estimate does not apply: it assumes A E* h'/F = {DEFAULT_KAPPA:g}, and this pair "
            f"has {format_significant(point.kappa)}. It would be {estimates}{hardness_note}."
        )
    return f"Small-slope estimate: {estimates}{hardness_note}."


def area_size_effect_text(points: Sequence[PointSummary]) -> str:
    """Return a sentence on the first load at which the size effect may reduce the true area below its interval.

    The sentence names the load if there are several result points. The text is empty if the size effect is smaller than
    the intervals, or if a study includes it.
    """
    for point in points:
        area, size_effect = point.quantities.get("contact_area"), estimate_size_effect(point.values, point.study)
        if size_effect is None or area is None:
            continue
        if area.value * (1 - size_effect.area_reduction) < area.lower:
            load_text = f" at {point_load_text(point)}" if len(points) > 1 else ""
            return (
                f"The interval of the true area does not include the size effect{load_text}: small contacts may be "
                f"{size_effect.hardness_text}, and the true area "
                f"{format_percent(size_effect.area_reduction)} smaller (--indent)."
            )
    return ""


# ---- Sentences about a single point ----------------------------------------------------------------------------------


def result_point_detail_sentences(point: PointSummary) -> list[str]:
    """Return sentences on a coefficient: contributions, single tests, dwell times, finer scans and inputs."""
    sentences = (
        [] if point.is_unloaded else [contributions_text(point), single_test_text(point), dwell_time_text(point)]
    )
    if (finer_scans := finer_scan_text(point)) and _are_finer_scans_relevant(point):
        sentences.append(f"{finer_scans[0].upper()}{finer_scans[1:]}.")
    assumptions = list_assumptions(point.study)
    assumptions_note = f" Assumes {', '.join(assumptions)}." if assumptions else ""
    return [*filter(None, sentences), f"At {inputs_text(point)}; {result_point_note(point)}.{assumptions_note}"]


def _are_finer_scans_relevant(point: PointSummary) -> bool:
    """Return whether finer scans may change the coefficient by a large fraction of its interval's width."""
    if point.bracket is None:
        return False
    width = max((rule.upper - rule.lower for rule in point.rules if rule.rule == "all"), default=math.nan)
    return not point.bracket[1] - point.bracket[0] < MIN_STATED_FINER_SCAN_RANGE * width


def roughness_text(point: PointSummary) -> str:
    """Return a sentence on the contributions of roughness and of the other inputs to friction.

    The text is empty if the contribution is unknown.
    """
    if point.roughness_contribution is None:
        return ""
    inputs = "the hardness, μ0 and τ0" if point.hardness is not None and point.at["tau0"] > 0 else "μ0"
    return f"R{roughness_contribution_text(point)[1:]}; the rest is from {inputs}."


def contributions_text(point: PointSummary) -> str:
    """Return a sentence on the contributions of mu0, adhesion and slopes to friction.

    Returns "" if they are unknown.
    """
    terms = {name: round(contribution, 3) + 0.0 for name, contribution in point.contribution_terms.items()}
    text = ""
    for name, contribution in terms.items():
        label = CONTRIBUTION_LABELS[name]
        if name == "mu0" and not math.isclose(contribution, point.at["mu0"], abs_tol=1e-3):
            label += " on the load of the contacts"
        sign = (" \N{MINUS SIGN} " if contribution < 0 else " + ") if text else ""
        text += f"{sign}{abs(contribution):.3f} ({label})"
    return text


def single_test_text(point: PointSummary) -> str:
    """Return a sentence on the prediction interval of single tests, and on the interval of the mean if it differs."""
    estimate = point.rules[0]
    if not math.isfinite(estimate.prediction_interval.lower) or estimate.prediction_interval == estimate.interval:
        return ""
    interval_of_mean = estimate.interval_of_mean
    is_printed = math.isfinite(interval_of_mean.lower) and interval_of_mean != estimate.interval
    sampling_text = f"; interval of the mean: {interval_of_mean}" if is_printed else ""
    return f"Single test, one direction: {estimate.prediction_interval}{sampling_text}."


def dwell_time_text(point: PointSummary) -> str:
    """Return a sentence on friction after dwell times.

    Returns "" if the study has no dwell times.
    """
    estimate_texts = [f"{format_time(aged_estimate.seconds)} {aged_estimate}" for aged_estimate in point.after_dwell]
    ageing_reason = (
        "; none if the hardness falls below the pressure"
        if any(math.isnan(aged_estimate.value) for aged_estimate in point.after_dwell)
        else ""
    )
    rate_text = f"; {format_significant(point.ageing)} for each factor e of time" if math.isfinite(point.ageing) else ""
    rate_and_state = rate_and_state_text(point)
    end = f". {rate_and_state}" if rate_and_state else "."
    return f"After a dwell time: {', '.join(estimate_texts)}{ageing_reason}{rate_text}{end}" if estimate_texts else ""


def rate_and_state_text(point: PointSummary) -> str:
    """Return a sentence on rate-and-state friction: the parameter b (ageing), and the slip distance D_c.

    Returns "" if they are unknown.
    """
    size = point.contact_size
    if not (math.isfinite(point.ageing) and math.isfinite(size.value)):
        return ""
    return (
        f"Rate and state: b = {format_significant(point.ageing)}, from growth of the contact area alone; D_c about "
        f"{format_with_unit(size.value, 'um')}, the median contact size; a is not computed."
    )


def no_values_text(summary: Summary) -> str:
    """Return text with the reason why there is no coefficient in a result."""
    return f"μ_s  none: {summary.no_points_reason}"
