"""Compute the friction of six pairs of metals with and without junction growth, and write generated/metals.md.

The surfaces are two quarters of a measured AFM map. The script takes a minute on one core.
"""

import math
import os
from pathlib import Path

from stiction import Surface, pair, read_surface

DOCS_FOLDER = Path(__file__).parents[1]
DATA_FOLDER = Path(os.environ.get("STICTION_TEST_DATA", DOCS_FOLDER.parents[1] / "shared/data"))
"""Directory of measured maps."""

PAIRS = [
    ("mild steel", "brass", 0.2, "50 MPa"),
    ("copper", "copper", 0.2, "30 MPa"),
    ("mild steel", "aluminum alloy 6061-T6", 0.2, "50 MPa"),
    ("gold", "gold", 0.1, "20 MPa"),
    ("bearing steel", "bearing steel", 0.2, "100 MPa"),
    ("mild steel", "PMMA", 0.15, "30 MPa"),
]
"""Materials of the two bodies, μ0 and τ0."""

BUDGET_COLUMNS = {
    "the hardness": "fraction of the hardness",
    "the ratio of hardness": "fraction of H/k",
    "the exponent": "fraction of the exponent m",
}
"""First words of inputs in the uncertainty budget, and titles of their columns."""


def read_quarters():
    """Return the first and the last quarter of the map."""
    scan = read_surface(DATA_FOLDER / "di-4.di")
    rows, columns = (size // 2 for size in scan.heights.shape)
    halves = scan.heights[:rows, :columns], scan.heights[rows:, columns:]
    return [Surface(heights, spacing=scan.spacing) for heights in halves]


def compute_friction(bodies, upper, lower, mu0, tau0, **options):
    """Return the coefficient with friction at all contacts, and fractions of its uncertainty."""
    result = pair(*bodies, load="10 MPa", upper=upper, lower=lower, mu0=mu0, tau0=tau0, shifts=6, onset=0, **options)
    point = result.summary().reported_points[0]
    rule = next(entry for entry in point.rules if entry.rule == "all")
    width = rule.upper - rule.lower
    fractions = {
        title: 1 - entry.width / width
        for words, title in BUDGET_COLUMNS.items()
        for entry in point.budget
        if entry.label.startswith(words) and math.isfinite(width)
    }
    upper_text = f"{rule.upper:.3f}]" if math.isfinite(rule.upper) else "∞)"
    return f"{rule.value:.3f} [{rule.lower:.3f}, {upper_text}", fractions


def main():
    titles = ["materials", "μ0", "τ0", "μ_s, no growth", "μ_s, slip lines", *BUDGET_COLUMNS.values()]
    rows = [f"| {' | '.join(titles)} |", "|---" * len(titles) + "|"]
    bodies = read_quarters()
    for upper, lower, mu0, tau0 in PAIRS:
        without_growth, _ = compute_friction(bodies, upper, lower, mu0, tau0, junction_growth=0)
        text, fractions = compute_friction(bodies, upper, lower, mu0, tau0)
        percentages = [
            f"{100 * fractions[title]:.0f} %" if title in fractions else "" for title in BUDGET_COLUMNS.values()
        ]
        rows.append(f"| {upper} on {lower} | {mu0} | {tau0} | {without_growth} | {text} | {' | '.join(percentages)} |")
    (DOCS_FOLDER / "generated/metals.md").write_text("\n".join(rows) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
