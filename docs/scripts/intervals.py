"""Measure the coverage of intervals for traverses, and their width relative to that of the best possible interval."""

import sys
from pathlib import Path

import numpy as np
from scipy.special import stdtrit
from stiction.evaluate.intervals import average_correlated_values

DOCS_DIRECTORY = Path(__file__).parent.parent
sys.path.insert(0, str(DOCS_DIRECTORY.parent / "tests"))

from reference.neighbours import (  # noqa: E402
    DISTRIBUTION_NAMES,
    coverage_and_width,
    estimate_true_mean,
    simulate_correlated_positions,
)

NUM_TRIALS = 2000
POSITION_COUNTS = (8, 16, 32, 64, 200)
POSITION_CORRELATIONS = (0.0, 0.4, 0.8)
SHOWN_DISTRIBUTIONS = [name for name in DISTRIBUTION_NAMES if name != "bounded"]
"""Distributions in the table. Coverages for bounded values differ from those for normal values by at most 0.04."""
MIN_COVERAGE, MAX_WIDTH_RATIO = 0.94, 1.5
"""Limits of coverage and width ratio beyond which numbers are bold. The standard error of a coverage is 0.005."""


def uncorrelated_interval(values):
    """Return Student's interval of the mean, which assumes uncorrelated positions."""
    half_width = stdtrit(values.size - 1, 0.975) * values.std(ddof=1) / np.sqrt(values.size)
    return values.mean(), values.mean() - half_width, values.mean() + half_width


def lag_one_corrected_interval(values):
    """Return Student's interval of the mean, corrected for the estimated correlation of neighbouring positions."""
    num_positions, deviations = values.size, values - values.mean()
    correlation = deviations[1:] @ deviations[:-1] / (deviations @ deviations) + 1 / num_positions
    correlation = min(max(correlation, 0.0), 1 - 2 / num_positions)
    variance_factor = (1 + correlation) / (1 - correlation)
    half_width = (
        stdtrit(max(num_positions / variance_factor - 1, 1), 0.975)
        * np.sqrt(variance_factor / num_positions)
        * values.std(ddof=1)
    )
    return values.mean(), values.mean() - half_width, values.mean() + half_width


def cosine_transform_interval(values):
    """Return Student's interval of the mean from the first cosine coefficients, which are nearly independent."""
    num_positions = values.size
    num_coefficients = max(4, round(0.41 * num_positions ** (2 / 3)))
    cosine_basis = np.cos(
        np.pi * np.arange(1, num_coefficients + 1)[:, np.newaxis] * (np.arange(num_positions) + 0.5) / num_positions
    )
    standard_error = np.sqrt(2 / num_positions * np.square(cosine_basis @ values).mean() / num_positions)
    return (
        values.mean(),
        values.mean() - stdtrit(num_coefficients, 0.975) * standard_error,
        values.mean() + stdtrit(num_coefficients, 0.975) * standard_error,
    )


INTERVAL_METHODS = {
    "this project": average_correlated_values,
    "independent": uncorrelated_interval,
    "lag one": lag_one_corrected_interval,
    "cosines": cosine_transform_interval,
}


def main():
    lines = [
        "| values | positions | correlation | " + " | ".join(INTERVAL_METHODS) + " |",
        "|" + "---|" * (3 + len(INTERVAL_METHODS)),
    ]
    for distribution in SHOWN_DISTRIBUTIONS:
        for positions in POSITION_COUNTS:
            for correlation in POSITION_CORRELATIONS:
                generator = np.random.default_rng(
                    [positions, int(10 * correlation), DISTRIBUTION_NAMES.index(distribution)]
                )
                true_mean, best_width = estimate_true_mean(distribution, positions, correlation, generator)
                values = simulate_correlated_positions(distribution, NUM_TRIALS, positions, correlation, generator)
                values = values[(values != values[:, :1]).any(axis=1)]
                cells = []
                for method in INTERVAL_METHODS.values():
                    coverage, relative_width, _ = coverage_and_width(method, values, true_mean, best_width)
                    cells.append(
                        f"{_format_bold(f'{coverage:.3f}', coverage < MIN_COVERAGE)}, "
                        f"{_format_bold(f'{relative_width:.2f}', relative_width > MAX_WIDTH_RATIO)}"
                    )
                lines.append(f"| {distribution} | {positions} | {correlation:g} | {' | '.join(cells)} |")
    (DOCS_DIRECTORY / "generated/intervals.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def _format_bold(text, is_bold):
    return f"**{text}**" if is_bold else text


if __name__ == "__main__":
    main()
