"""Which differences between two studies make their members differ."""

from __future__ import annotations

from stiction._units import shortened
from stiction.studies.study import Study, differences

Difference = tuple[str, str, str]
"""A dotted key, and what it is in either study."""

MOST_LISTED = 4


def computed_otherwise(one: Study, other: Study) -> list[Difference]:
    """List what makes the members of two studies differ.

    What friction and figures are asked for is applied to the sums afterwards. Measured files are known by their
    checksums, wherever they lie.
    """
    return [
        each
        for each in differences(one, other)
        if (each[0].startswith(("surfaces.", "contact.")) or each[0] == "ensemble.seed")
        and not each[0].endswith((".upper.file", ".lower.file"))
    ]


def listed(differ: list[Difference]) -> str:
    """Write differences for a message, a line for each of the first few."""
    lines = [f"{key} = {shortened(there)} there, {shortened(here)} here" for key, there, here in differ[:MOST_LISTED]]
    if len(differ) > MOST_LISTED:
        lines.append(f"... and {len(differ) - MOST_LISTED} more")
    return "\n".join(lines)
