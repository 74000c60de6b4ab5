"""Measure the coverage of intervals of pairs of maps, and write docs/generated/map_intervals.md."""

from pathlib import Path

import numpy as np
from stiction import Result, run, self_affine_surface
from stiction.evaluate.at_load import at_load
from stiction.evaluate.member_values import member_values
from stiction.study.pair_options import validate_option_values
from stiction.study.pair_study import build_study_from_options

TABLE_FILE = Path(__file__).parent.parent / "generated/map_intervals.md"
NUM_PAIRS, NUM_SHIFTS, SAMPLE_SIZE = 40, 400, 16
STUDY_OPTIONS = {
    "load": "30 MPa", "mu0": 0.3, "tau0": "100 MPa", "effective_modulus": "10 GPa", "direction": [0],
    "mechanics": "asperities", "cutoff": "none",
}  # fmt: skip


def select_area_and_friction(dataset):
    """Return A/A0, and mu_s towards +x under both sliding rules, as arrays over pairs of maps or statistics."""
    friction = dataset["friction_coefficient"].isel(cut_off=0, direction=0, load=0, mu0=0, tau0=0)
    area = dataset["contact_area_fraction"].isel(cut_off=0, load=0)
    return np.stack([area, friction.sel(sliding="opposing"), friction.sel(sliding="all")])


def main():
    pair_means, intervals = [], {"shifts": [], "surrogates": []}
    for pair in range(NUM_PAIRS):
        upper, lower = (
            self_affine_surface(
                17, repetition=pair, hurst_exponent=0.8, rms=0.02, shape=(192, 192), spacing=0.1, side=side,
                longest_wavelength=3.2, shortest_wavelength=0.4,
            )
            for side in ("upper", "lower")
        )  # fmt: skip
        options = {
            "upper": upper,
            "lower": lower,
            "shifts": NUM_SHIFTS,
            "surrogates": SAMPLE_SIZE,
            "seed": pair,
            **STUDY_OPTIONS,
        }
        result = run(build_study_from_options(validate_option_values(options)))
        loads = result.default_loads
        pair_means.append(
            np.nanmean(select_area_and_friction(member_values(result, loads, member_kind="shifts")), axis=-1)
        )
        sampled_result = Result(
            result.dataset.isel(repetition=slice(2 * SAMPLE_SIZE))
        )  # contains all surrogates, and as many shifts
        for member_kind, interval_results in intervals.items():
            interval_results.append(select_area_and_friction(at_load(sampled_result, loads, member_kind=member_kind)))
        if pair:
            TABLE_FILE.write_text(format_table(np.array(pair_means), intervals), encoding="utf-8")


def format_table(pair_means, intervals):
    """Return a table with the coverage and the median width of each interval, from the pairs computed so far."""
    num_pairs, overall_means = len(pair_means), pair_means.mean(axis=0)
    overall_mean_by_pair = np.broadcast_to(overall_means, pair_means.shape)
    rows = [
        ("16 shifts", f"mean over all {NUM_SHIFTS} shifts of the same two maps", intervals["shifts"], pair_means),
        ("16 shifts", f"mean over all {num_pairs} pairs", intervals["shifts"], overall_mean_by_pair),
        ("16 surrogates", f"mean over all {num_pairs} pairs", intervals["surrogates"], overall_mean_by_pair),
    ]
    lines = [
        "| interval from | true value | A/A0 | μ_s, friction at opposing contacts | μ_s, friction at all contacts |",
        "|---|---|---|---|---|",
    ]
    for members_text, true_mean_text, interval_results, true_means in rows:
        interval_means, lower_limits, upper_limits = np.moveaxis(np.array(interval_results), -1, 0)
        is_inside = (lower_limits <= true_means) & (true_means <= upper_limits)
        width = np.median((upper_limits - lower_limits) / interval_means, axis=0)
        cells = [f"{100 * is_inside[:, k].mean():.0f} %, {100 * width[k]:.1f} %" for k in range(3)]
        lines.append(f"| {members_text} | {true_mean_text} | {' | '.join(cells)} |")
    cells = [
        f"{100 * relative_deviation:.1f} %" for relative_deviation in pair_means.std(axis=0, ddof=1) / overall_means
    ]
    lines.append(f"| | standard deviation of the {num_pairs} pairs' own means | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
