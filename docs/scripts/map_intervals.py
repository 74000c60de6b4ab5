"""Measure the coverage of intervals of pairs of maps: writes docs/generated/map_intervals.md."""

from pathlib import Path

import numpy as np
from stiction import pressed_maps, pressed_maps_mean, self_affine_surface
from stiction.studies.traverse import overlap_area

OUT = Path(__file__).parent.parent / "generated/map_intervals.md"
PAIRS, SHIFTS, TAKEN = 40, 400, 16
PRESSURE = 0.03  # GPa
MATERIAL = {"mu0": 0.3, "tau0": 0.1, "directions": [0.0], "mechanics": "asperities"}


def numbers(dataset):
    """Return A/A0 and mu_s along +x for both rules, along the last axis."""
    friction = dataset["friction_coefficient"].isel(direction=0, load=0, mu0=0, tau0=0)
    area = dataset["contact_area_fraction"].isel(load=0)
    return np.stack([area, friction.sel(sliding="opposing"), friction.sel(sliding="all")])


def main():
    populations, intervals = [], {"shifts": [], "surrogates": []}
    for pair in range(PAIRS):
        upper, lower = (
            self_affine_surface(
                17, repetition=pair, hurst_exponent=0.8, rms=0.02, shape=(192, 192), spacing=0.1, side=side,
                longest_wavelength=3.2, shortest_wavelength=0.4,
            )
            for side in ("upper", "lower")
        )  # fmt: skip
        load = [PRESSURE * overlap_area(upper, lower)]
        result = pressed_maps(upper, lower, load, shifts=SHIFTS, surrogates=TAKEN, seed=pair, **MATERIAL)
        populations.append(np.nanmean(numbers(result.isel(repetition=slice(SHIFTS))), axis=-1))
        shifts = pressed_maps_mean(result.isel(repetition=np.arange(TAKEN)))  # prefixes are the results of fewer shifts
        intervals["shifts"].append(numbers(shifts))
        intervals["surrogates"].append(numbers(pressed_maps_mean(result, surrogates=True)))
        if pair:
            OUT.write_text(table(np.array(populations), intervals), encoding="utf-8")


def table(own, intervals):
    """Return a table of coverage and median width of each interval, for the pairs so far."""
    pairs, all_pairs = len(own), own.mean(axis=0)
    everybody = np.broadcast_to(all_pairs, own.shape)
    rows = [
        ("16 shifts", f"all {SHIFTS} shifts of the same two maps", intervals["shifts"], own),
        ("16 shifts", f"the mean of all {pairs} pairs", intervals["shifts"], everybody),
        ("16 surrogates", f"the mean of all {pairs} pairs", intervals["surrogates"], everybody),
    ]
    lines = ["| interval over | held against | A/A0 | μ_s, opposing | μ_s, all |", "|---|---|---|---|---|"]
    for of, truth, result, expected in rows:
        mean, low, high = np.moveaxis(np.array(result), -1, 0)
        inside = (low <= expected) & (expected <= high)
        width = np.median((high - low) / mean, axis=0)
        cells = [f"{100 * inside[:, k].mean():.0f} %, {100 * width[k]:.1f} %" for k in range(3)]
        lines.append(f"| {of} | {truth} | {' | '.join(cells)} |")
    cells = [f"{100 * each:.1f} %" for each in own.std(axis=0, ddof=1) / all_pairs]
    lines.append(f"| | standard deviation of the {pairs} pairs' own means | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
