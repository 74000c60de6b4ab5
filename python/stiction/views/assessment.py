"""Text about a result's assessment: its caveats, their remedies, and the measurement that would help most."""

from __future__ import annotations

import math
import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from stiction._number_format import format_with_unit
from stiction.evaluate.combined_intervals import (
    LOWER_SCANS_INPUT_NAME,
    POSITIONS_INPUT_NAME,
    UNRESOLVED_ROUGHNESS_INPUT_NAME,
    UPPER_SCANS_INPUT_NAME,
)
from stiction.solve.alternative_preparations import ALTERNATIVE_LABELS, SPIKES_ALTERNATIVE, TIP_ALTERNATIVE
from stiction.summary.assessment import ASSESSMENTS_BY_SEVERITY, WIDE_INTERVAL_CHECK_NAME, Caveat
from stiction.summary.summary import POSSIBLE_NOISE_INPUT_NAME, PointSummary
from stiction.views.layout import Paragraph, ShortenedList, WrappedText
from stiction.views.point import point_load_text

COMPLETE_OUTPUT_METHOD = "summary()"
MAX_CAVEAT_GROUPS = 6


def assessment_paragraph(
    points: Sequence[PointSummary], max_lines: int | None = None, *, max_groups: int | None = None,
    complete_command: str = COMPLETE_OUTPUT_METHOD,
) -> Paragraph:  # fmt: skip
    """Return a paragraph with the assessments of result points, and with their caveats and remedies.

    For a single point, the paragraph also names the measurement that would help most. Similar caveats of several points
    are grouped. At most `max_lines` lines of caveats are printed or, without `max_lines`, at most `max_groups` groups.
    Faults come first and are always printed. `complete_command` names the option, command or method that shows all
    caveats.
    """
    if len({(point.assessment, point.caveats) for point in points}) == 1:
        caveat_lines, num_faults = [_caveat_line(caveat) for caveat in points[0].caveats], len(points[0].faults)
        return [
            WrappedText(_common_assessment_text(points), hanging_indent="  "),
            ShortenedList(caveat_lines, max(num_faults, 1), None, max_lines, "caveat", complete_command),
        ]
    groups = _group_similar_caveats(points)
    num_fault_groups = sum(group[0][1].severity == "fault" for group in groups)
    group_lines = [
        _caveat_line(
            _merge_caveats([caveat for _, caveat in group]), _count_text([point for point, _ in group], points)
        )
        for group in groups
    ]
    max_shown = max_groups if max_lines is None else None
    return [
        f"{count_assessments_text(points)}.",
        ShortenedList(group_lines, max(num_fault_groups, 1), max_shown, max_lines, "caveat", complete_command),
    ]


def _common_assessment_text(points: Sequence[PointSummary]) -> str:
    """Return the assessment that several result points have in common.

    For a single point, a sentence on the measurement that would help most follows.
    """
    point = points[0]
    if point.is_unloaded:
        return f"{point.assessment} a coefficient"
    measurement_text = most_useful_measurement_text(point) if len(points) == 1 else ""
    return f"{point.assessment}. {measurement_text}" if measurement_text else point.assessment


def count_assessments(points: Sequence[PointSummary]) -> dict[str, int]:
    """Return the number of result points with each assessment, starting with "Do not quote"."""
    assessment_counts = Counter(point.assessment for point in points)
    return {
        assessment: assessment_counts[assessment]
        for assessment in ASSESSMENTS_BY_SEVERITY.values()
        if assessment_counts[assessment]
    }


def count_assessments_text(points: Sequence[PointSummary]) -> str:
    """Format how many result points have each assessment, as in "Quote it (3 of 4)"."""
    return ", ".join(f"{text} ({count} of {len(points)})" for text, count in count_assessments(points).items())


def _count_text(affected_points: Sequence[PointSummary], points: Sequence[PointSummary]) -> str:
    """Return text that counts the result points with a caveat, such as " (2 of 4)".

    The load of a single point follows, as in " (1 of 4: 10 MPa)", if the points have several loads.
    """
    load_text = ""
    if len(affected_points) == 1 and len({point.at["load"] for point in points}) > 1:
        (point,) = affected_points
        has_pressure = math.isfinite(point.nominal_pressure)
        load_text = format_with_unit(point.nominal_pressure, "GPa") if has_pressure else point_load_text(point)
        load_text = f": {load_text}"
    return f" ({len(affected_points)} of {len(points)}{load_text})"


def _group_similar_caveats(points: Sequence[PointSummary]) -> list[list[tuple[PointSummary, Caveat]]]:
    """Group caveats that have the same severity, and the same text except for numbers. Faults come first.

    Each caveat comes with its result point.
    """
    groups: dict[tuple[str, str], list[tuple[PointSummary, Caveat]]] = {}
    for point in points:
        for caveat in point.caveats:
            group_key = caveat.severity, _CAVEAT_NUMBER_PATTERN.sub("", caveat.text)
            groups.setdefault(group_key, []).append((point, caveat))
    return sorted(groups.values(), key=lambda group: group[0][1].severity != "fault")


_CAVEAT_NUMBER_PATTERN = re.compile(r"(\d+(?:\.\d+)?(?:e[+-]?\d+)?)( ?(?:%|(?:[kMGmµn]?(?:Pa|N|m|m²)\b))?)")
"""Pattern of a number with its unit. Caveats whose texts differ only in such numbers are grouped."""

_PREFIX_FACTORS = {"n": 1e-9, "µ": 1e-6, "m": 1e-3, "k": 1e3, "M": 1e6, "G": 1e9}


def _merge_caveats(group: Sequence[Caveat]) -> Caveat:
    """Merge similar caveats into one caveat, whose text has ranges instead of the numbers that differ."""
    numbers_by_position = zip(*(_CAVEAT_NUMBER_PATTERN.findall(caveat.text) for caveat in group), strict=True)
    range_texts = iter(
        [
            _range_text(sorted(set(differing_numbers), key=_number_with_unit))
            for differing_numbers in numbers_by_position
        ]
    )
    return replace(group[0], text=_CAVEAT_NUMBER_PATTERN.sub(lambda _: next(range_texts), group[0].text))


def _number_with_unit(number: tuple[str, str]) -> float:
    """Convert a number and its unit, both given as text, to the unit without its prefix, such as Pa for kPa."""
    unit = number[1].strip()
    return float(number[0]) * (_PREFIX_FACTORS.get(unit[0], 1.0) if len(unit) > 1 and unit not in ("Pa", "m²") else 1.0)


def _range_text(numbers: Sequence[tuple[str, str]]) -> str:
    """Format numbers with units, given in ascending order, as a range such as "95 to 116 MPa"."""
    (smallest, low_unit), (largest, high_unit) = numbers[0], numbers[-1]
    if (smallest, low_unit) == (largest, high_unit):
        return f"{smallest}{low_unit}"
    return f"{smallest}{'' if low_unit == high_unit else low_unit} to {largest}{high_unit}"


def _caveat_line(caveat: Caveat, suffix: str = "") -> WrappedText:
    marker = "!" if caveat.severity == "fault" else "-"
    return WrappedText(f"{marker} {caveat.text}{suffix}; {caveat.remedy}", indent="  ", hanging_indent="  ")


def most_useful_measurement_text(point: PointSummary) -> str:
    """Return a sentence on the measurement that would help most, such as "With a finer scan, ...", if there is one."""
    dominant_input = point.dominant_input
    if dominant_input is None or any(fault.name != WIDE_INTERVAL_CHECK_NAME for fault in point.faults):
        return ""
    reduced_limits = str(dominant_input.interval)
    # An interval whose limits are equal after rounding is printed as one number.
    if reduced_limits == str(point.rules[0].interval) or " to " not in reduced_limits:
        return ""
    condition = _CONDITION_TEXTS.get(dominant_input.label, f"If {dominant_input.label} were known")
    return f"{condition}, the interval would be [{reduced_limits.replace(' to ', ', ')}]."


_CONDITION_TEXTS = {
    POSSIBLE_NOISE_INPUT_NAME: "If one place were scanned twice",
    POSITIONS_INPUT_NAME: "With more positions",
    UNRESOLVED_ROUGHNESS_INPUT_NAME: "With a finer scan",
    ALTERNATIVE_LABELS[SPIKES_ALTERNATIVE]: "With a scan without spikes",
    ALTERNATIVE_LABELS[TIP_ALTERNATIVE]: "With a sharper tip",
    UPPER_SCANS_INPUT_NAME: "With scans of more places of the upper part",
    LOWER_SCANS_INPUT_NAME: "With scans of more places of the lower part",
}  # fmt: skip
"""Phrases for the measurement that would remove each source of uncertainty other than an uncertain input."""
