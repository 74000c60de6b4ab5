"""Onset of sliding as a sentence, a table and JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from stiction._number_format import format_with_unit
from stiction.companions.onset import OnsetSummary
from stiction.evaluate.point import list_rules_with_reported_first
from stiction.mechanics.law import HertzSphere, parse_contact_law
from stiction.views.layout import Paragraph, Table
from stiction.views.point import coordinate_text

if TYPE_CHECKING:
    from stiction.study.study import Study

# Tangential load at which results are quoted, as a fraction of the sliding load.
QUOTED_TANGENTIAL_LOAD_FRACTION = 0.5
# Amplitudes of the tangential load in cyclic loading, as fractions of the sliding load.
CYCLE_AMPLITUDES = (0.5, 0.9)


def onset_text(onset: OnsetSummary, study: Study | None = None) -> str:
    """Return a sentence on the onset of sliding: pre-sliding displacement, slipped area, and initial stiffness.

    The sentence states the normal load if the study has several loads.
    """
    phrases = []
    displacement = onset.displacement_at_sliding.in_prefixed_unit()
    if math.isfinite(displacement.value):
        phrases.append(f"pre-sliding displacement {displacement.text()} {displacement.unit}")
    slipped_area = onset.curve[QUOTED_TANGENTIAL_LOAD_FRACTION].slipped_area
    phrases.append(f"{slipped_area.in_unit('%', 0.01).text()} % of the contact slips at half the sliding load")
    stiffness = onset.stiffness.in_prefixed_unit()
    if math.isfinite(stiffness.value):
        phrases.append(f"initial tangential stiffness {stiffness.text()} {stiffness.unit}")
    text = "; ".join(phrases)
    if study is not None and len(study.friction.load) > 1:
        text += f" (at a load of {format_with_unit(onset.load, 'mN')})"
    return text[0].upper() + text[1:] + "."


def onset_rows(onset: OnsetSummary) -> list[list[str]]:
    """Return table rows on the onset of sliding: sliding load, displacement, stiffness and others, with intervals.

    The first row contains the headings.
    """
    displacement = onset.displacement_at_sliding.in_prefixed_unit()
    stiffness = onset.stiffness.in_prefixed_unit()
    unloading_stiffness = onset.unloading_stiffness.in_prefixed_unit()
    unloading_label = "normal stiffness during unloading, as measured by ultrasound"
    half_load_point = onset.curve[QUOTED_TANGENTIAL_LOAD_FRACTION]
    estimates = {
        "sliding load (mN)": onset.sliding_load,
        f"pre-sliding displacement ({displacement.unit})": displacement,
        f"initial tangential stiffness ({stiffness.unit})": stiffness,
        f"{unloading_label} ({unloading_stiffness.unit})": unloading_stiffness,
        "contact that slips at half of the sliding load (%)": half_load_point.slipped_area.in_unit("%", 0.01),
        "load on the slipping contact (%)": half_load_point.slipped_load.in_unit("%", 0.01),
        **{
            f"energy dissipated in a cycle of {amplitude:g} times the sliding load (pJ)": (
                onset.curve[amplitude].energy_lost.in_unit("pJ", PICOJOULE)
            )
            for amplitude in CYCLE_AMPLITUDES
        },
    }
    header = f"{format_with_unit(onset.load, 'mN')}, μ0 = {onset.mu0:g}, τ0 = {coordinate_text('tau0', onset.tau0)}"
    rows = [[label, estimate.table_text] for label, estimate in estimates.items() if not math.isnan(estimate.value)]
    return [["onset of sliding", header], *rows]


PICOJOULE = 1e-3  # mN µm


def onset_note(onset: OnsetSummary, study: Study) -> str:
    """Return a note on the onset of sliding: number of averaged surface pairs, and assumptions."""
    count_text = study.member_names.with_count(onset.num_members)
    text = f"The onset of sliding is a mean over {count_text}, with friction at all contacts."
    if not onset.is_poisson_ratio_given and math.isfinite(onset.stiffness.value):
        text += f" Poisson's ratio is assumed to be {onset.poisson_ratio[0]:g}."
    return text + _law_text(study)


def _law_text(study: Study) -> str:
    """Return a sentence on the stiffness used for the onset of sliding; "" for half-spaces and Hertzian contacts.

    This stiffness is that of elastic Hertzian contacts under every contact law.
    """
    contact: Any = study.contact
    if study.uses_half_space:
        return ""
    law = parse_contact_law(contact.contact_model().law)
    if isinstance(law, HertzSphere):
        return ""
    return (
        f" The onset uses the force and the area of the law {law.name}, but the stiffness of elastic Hertzian contacts."
    )


def onset_paragraph(onset: OnsetSummary, study: Study, *, verbose: bool) -> Paragraph:
    """Return a paragraph on the onset of sliding: a sentence and, if `verbose`, a note and a table."""
    if not verbose:
        is_reported_rule = list_rules_with_reported_first(study)[0] == "all"
        rule_text = "" if is_reported_rule else " These values assume friction at all contacts."
        return [onset_text(onset, study) + rule_text + _law_text(study)]
    return [f"{onset_text(onset, study)} {onset_note(onset, study)}", Table(onset_rows(onset))]


def onset_record(onset: OnsetSummary) -> dict[str, Any]:
    """Return the onset of sliding as JSON fields, with the load-displacement curve (mN, µm) and the fitted models."""
    curve_names = ("tangential_load", "displacement", "slipped_area", "slipped_load", "energy_lost")
    characteristic_names = ("sliding_load", "displacement_at_sliding", "stiffness", "unloading_stiffness")
    return {
        "sentence": onset_text(onset),
        "load": onset.load,
        "mu0": onset.mu0,
        "tau0": onset.tau0,
        "members": onset.num_members,
        "poisson_ratio": list(onset.poisson_ratio),
        **{name: getattr(onset, name).to_record() for name in characteristic_names},
        **{model: parameters or None for model, parameters in onset.models.items()},
        "curve": [
            {
                "fraction": fraction,
                **{name: getattr(point, name).to_record({"fraction": fraction}) for name in curve_names},
            }
            for fraction, point in onset.curve.items()
        ],
    }
