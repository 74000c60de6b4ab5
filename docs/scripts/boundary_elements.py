"""Measure the error of neglecting asperity interaction, and write generated/boundary_elements.md.

The script takes about three minutes on two cores.
"""

import sys
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
from scipy.stats import t as student

DOCS_DIRECTORY = Path(__file__).parents[1]
sys.path.insert(0, str(DOCS_DIRECTORY.parent / "tests"))

from reference.boundary_elements import (  # noqa: E402  also used by tests
    EFFECTIVE_MODULUS,
    PERIOD,
    RMS_SLOPE,
    SOLVER_TOLERANCE,
    PeriodicAsperities,
    PeriodicHalfSpace,
    band_limited_profile,
)

HURST_EXPONENTS = (0.5, 0.75, 1.0)
PAIR_COUNTS_BY_BANDWIDTH = {8: (64, 24), 32: (32, 24), 128: (16, 12)}
"""Number of points per shortest wavelength, and number of repetitions, by bandwidth."""
RELATIVE_LOADS = np.geomspace(0.002, 0.2, 9)
"""Mean pressures in units of E* times the rms slope."""
TABLE_LOAD_INDICES = (0, 4, 8)
SEED = 2016
NUM_CHECKED_PROFILES = 3

FRACTION_COLUMN, COUNT_COLUMN, STIFFNESS_COLUMN = range(3)


def compute_profile_results(
    bandwidth: int, hurst: float, repetition: int, refinement: int = 1, tolerance: float = SOLVER_TOLERANCE
) -> np.ndarray:
    """Return contact fraction, contact count and stiffness (GPa/µm) as an array (loads, 3 models, 3 quantities).

    The models are boundary elements, the asperity model, and the asperity model with interaction.
    """
    points, _ = PAIR_COUNTS_BY_BANDWIDTH[bandwidth]
    generator = np.random.default_rng([SEED, repetition])
    heights = band_limited_profile(generator, hurst, bandwidth, refinement * points)
    half_space_solver, asperity_solver = (
        PeriodicHalfSpace(heights, PERIOD, tolerance=tolerance),
        PeriodicAsperities(heights, PERIOD),
    )
    pressures = RELATIVE_LOADS * EFFECTIVE_MODULUS * RMS_SLOPE
    return np.array(
        [
            (
                half_space_solver.contact_response(p),
                asperity_solver.contact_response(p),
                asperity_solver.interacting_response(p),
            )
            for p in pressures
        ]
    )


def mean_with_interval(ratios: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the geometric mean over the first axis and the limits of its 95 % t interval, ignoring NaN."""
    log_ratios = np.log(ratios)
    n = np.isfinite(log_ratios).sum(axis=0)
    mean = np.nanmean(log_ratios, axis=0)
    half_width = student.ppf(0.975, n - 1) * np.nanstd(log_ratios, axis=0, ddof=1) / np.sqrt(n)
    return np.exp(mean), np.exp(mean - half_width), np.exp(mean + half_width)


def format_ratios(ratios: np.ndarray) -> str:
    mean, lower_limit, upper_limit = (float(value) for value in mean_with_interval(ratios))
    return f"{mean:.2f} ({lower_limit:.2f} to {upper_limit:.2f})"


def render_load_rows(results: dict) -> list[str]:
    rows = [
        "| longest / shortest wavelength | H | p̄ / (E* h') | A/A0 | contacts: boundary elements, asperity model "
        "| asperity model: area | asperity model: stiffness | with interaction: area | with interaction: stiffness |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for (bandwidth, hurst), pair_results in results.items():
        for k in TABLE_LOAD_INDICES:
            half_space_values, model_values, interacting_model_values = (
                pair_results[:, k, model_index] for model_index in range(3)
            )
            cells = [
                f"{bandwidth}",
                f"{hurst:g}",
                f"{RELATIVE_LOADS[k]:g}",
                f"{half_space_values[:, FRACTION_COLUMN].mean():.3f}",
                f"{half_space_values[:, COUNT_COLUMN].mean():.3g}, {model_values[:, COUNT_COLUMN].mean():.3g}",
                *(
                    format_ratios(compared_values[:, quantity] / half_space_values[:, quantity])
                    for compared_values in (model_values, interacting_model_values)
                    for quantity in (FRACTION_COLUMN, STIFFNESS_COLUMN)
                ),
            ]
            rows.append(f"| {' | '.join(cells)} |")
    return rows


def render_count_rows(results: dict) -> list[str]:
    """Return table rows with area ratios by the number of contacts. Each repetition counts once per row."""
    contact_count_ranges = ((1, 1), (1.5, 2), (2.5, 4), (4.5, 8), (8.5, 16), (16.5, 32), (32.5, 64), (64.5, 1000))
    rows = [
        "| contacts per period, boundary elements | "
        + " | ".join(
            f"{model_name}, {bandwidth}"
            for model_name in ("asperity model", "with interaction")
            for bandwidth in PAIR_COUNTS_BY_BANDWIDTH
        )
        + " |",
        "|---" * (2 * len(PAIR_COUNTS_BY_BANDWIDTH) + 1) + "|",
    ]
    for min_contacts, max_contacts in contact_count_ranges:
        cells = []
        for model_index, (bandwidth, (_, repetitions)) in product((1, 2), PAIR_COUNTS_BY_BANDWIDTH.items()):
            ratios = []
            for k in range(repetitions):
                selected_results = np.concatenate([results[bandwidth, hurst][k] for hurst in HURST_EXPONENTS])
                selected_results = selected_results[
                    (selected_results[:, 0, COUNT_COLUMN] >= min_contacts)
                    & (selected_results[:, 0, COUNT_COLUMN] <= max_contacts)
                ]
                if len(selected_results):
                    ratios.append(
                        np.exp(
                            np.log(
                                selected_results[:, model_index, FRACTION_COLUMN]
                                / selected_results[:, 0, FRACTION_COLUMN]
                            ).mean()
                        )
                    )
            cells.append(format_ratios(np.array(ratios)) if len(ratios) >= 6 else "")
        range_text = (
            f"{max_contacts:g}"
            if max_contacts <= 2
            else f"{np.ceil(min_contacts):g} to {max_contacts:g}"
            if max_contacts < 1000
            else f"above {min_contacts:.0f}"
        )
        rows.append(f"| {range_text} | {' | '.join(cells)} |")
    return rows


def render_check_rows(results: dict, check_results: dict) -> list[str]:
    rows = [
        "| longest / shortest wavelength | points per shortest wavelength | area, at any load | area, from 0.02 on "
        "| stiffness, at any load | area and stiffness, tolerance 1e-10 to 1e-12 |",
        "|---|---|---|---|---|---|",
    ]
    for bandwidth, (points, _) in PAIR_COUNTS_BY_BANDWIDTH.items():
        finer_grid_changes, tighter_tolerance_changes = (
            np.zeros((RELATIVE_LOADS.size, 3)),
            np.zeros((RELATIVE_LOADS.size, 3)),
        )
        for check_name, max_changes in (("finer", finer_grid_changes), ("tighter", tighter_tolerance_changes)):
            for hurst in HURST_EXPONENTS:
                results_and_check = (
                    results[bandwidth, hurst][:NUM_CHECKED_PROFILES],
                    check_results[check_name, bandwidth, hurst],
                )
                log_ratios_before, log_ratios_after = (
                    np.log(values[:, :, 1] / values[:, :, 0]).mean(axis=0) for values in results_and_check
                )
                np.maximum(max_changes, np.abs(log_ratios_after - log_ratios_before), out=max_changes)
        heavy_load_changes = finer_grid_changes[TABLE_LOAD_INDICES[1] :, FRACTION_COLUMN]
        rows.append(
            f"| {bandwidth} | {points} to {2 * points} | {100 * finer_grid_changes[:, FRACTION_COLUMN].max():.1f} % "
            f"| {100 * heavy_load_changes.max():.1f} % | {100 * finer_grid_changes[:, STIFFNESS_COLUMN].max():.1f} % "
            f"| {100 * tighter_tolerance_changes[:, [FRACTION_COLUMN, STIFFNESS_COLUMN]].max():.0g} % |"
        )
    return rows


def main() -> None:
    bandwidths_and_exponents = list(product(PAIR_COUNTS_BY_BANDWIDTH, HURST_EXPONENTS))
    with ProcessPoolExecutor(2) as pool:
        jobs = {
            (bandwidth, hurst): [
                pool.submit(compute_profile_results, bandwidth, hurst, k)
                for k in range(PAIR_COUNTS_BY_BANDWIDTH[bandwidth][1])
            ]
            for bandwidth, hurst in reversed(bandwidths_and_exponents)
        }
        options_by_check = {"finer": {"refinement": 2}, "tighter": {"tolerance": 1e-12}}
        check_jobs = {
            (check_name, *bandwidth_and_exponent): [
                pool.submit(compute_profile_results, *bandwidth_and_exponent, k, **arguments)
                for k in range(NUM_CHECKED_PROFILES)
            ]
            for check_name, arguments in options_by_check.items()
            for bandwidth_and_exponent in bandwidths_and_exponents
        }
        results = {
            bandwidth_and_exponent: np.array([job.result() for job in jobs[bandwidth_and_exponent]])
            for bandwidth_and_exponent in bandwidths_and_exponents
        }
        check_results = {key: np.array([job.result() for job in values]) for key, values in check_jobs.items()}
    tables = (render_load_rows(results), render_count_rows(results), render_check_rows(results, check_results))
    headings = (
        "Area and stiffness of the asperity model, without and with interaction, divided by those of the boundary "
        "elements, with 95 % intervals. A/A0 is the result of the boundary elements. The numbers of contacts are for a "
        "period of four longest wavelengths.",
        "Ratios of the area for different numbers of contacts. The columns are for longest / shortest wavelengths of "
        "8, 32 and 128. The ratios are means over all H and loads; there is no value for fewer than 6 repetitions.",
        f"Effect of the grid and the solver: largest change of the mean ratio of {NUM_CHECKED_PROFILES} profiles, "
        "over all H.",
    )
    text = "\n\n".join(f"{heading}\n\n" + "\n".join(rows) for heading, rows in zip(headings, tables, strict=True))
    (DOCS_DIRECTORY / "generated/boundary_elements.md").write_text(text + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
