"""Compare maps with surrogates that are generated from one section of each map; write docs/generated/isotropic.md."""

from pathlib import Path

import numpy as np
from stiction import Surface, half_space, isotropic_surface, levelled, self_affine_surface

TABLE_FILE = Path(__file__).parent.parent / "generated/isotropic.md"
MAP_SIDE_POINTS, PIECE_SIDE_POINTS, SPACING = 1024, 256, 0.1  # numbers of points per side, and spacing (µm)
NUM_PAIRS = 6
"""Number of pairs of profiles, and number of pairs of pieces."""
MU0, TAU0 = 0.4, 0.1  # mu0, and tau0 (GPa), which is 1 % of E*
PRESSURE = 0.02  # GPa


def create_map(side, hurst, stretch):
    """Return a map with an rms gradient of 0.15 and wavelengths from 0.8 to 6.4 µm, which is stretched along y."""
    body = self_affine_surface(
        11,
        hurst_exponent=hurst,
        rms=0.1,
        shape=(MAP_SIDE_POINTS, MAP_SIDE_POINTS),
        spacing=SPACING,
        side=side,
        longest_wavelength=6.4,
        shortest_wavelength=0.8,
    )
    slopes_along_y, slopes_along_x = np.gradient(body.heights, stretch * SPACING, SPACING)
    heights = 0.15 * body.heights / np.sqrt((slopes_along_x**2 + slopes_along_y**2).mean())
    return Surface(heights, spacing=(stretch * SPACING, SPACING))


def compute_pair_results(upper, lower):
    """Return A/A0 (%), and mu_s (rule "opposing", mean over four directions) without and with tau0."""
    area = np.prod(upper.extent)
    curve = half_space(upper, lower, [PRESSURE * area], direction=[0.0, 90.0, 180.0, 270.0])
    coefficients = [curve.friction_coefficient(mu0=MU0, tau0=tau0)[:, 0].mean() for tau0 in (0.0, TAU0)]
    return 100 * curve.contact_area[0] / area, *coefficients


def cut_piece_pairs(upper, lower):
    """Yield pairs of pieces that are cut from different places of two maps."""
    count = MAP_SIDE_POINTS // PIECE_SIDE_POINTS
    for index in range(NUM_PAIRS):
        j, i = divmod(index, count)
        window = np.s_[
            j * PIECE_SIDE_POINTS : (j + 1) * PIECE_SIDE_POINTS, i * PIECE_SIDE_POINTS : (i + 1) * PIECE_SIDE_POINTS
        ]
        yield tuple(levelled(Surface(body.heights[window], spacing=body.spacing), "plane") for body in (upper, lower))


def generate_surrogate_pairs(upper, lower, line_method):
    for index in range(NUM_PAIRS):
        line_index = index * MAP_SIDE_POINTS // NUM_PAIRS
        sections = [levelled(getattr(body, line_method)(line_index), "line") for body in (upper, lower)]
        yield tuple(
            levelled(
                isotropic_surface(
                    section, 5, shape=(PIECE_SIDE_POINTS, PIECE_SIDE_POINTS), repetition=index, side=side
                ),
                "plane",
            )
            for section, side in zip(sections, ("upper", "lower"), strict=True)
        )


def main():
    lines = [
        "| H | wavelengths along y / along x | surfaces from | A/A0 (%) | ratio to the map | μ_s, τ0 = 0 | ratio to "
        "the map "
        "| μ_s, τ0 = 1 % of E* | ratio to the map |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for hurst, stretch in [(0.4, 1), (0.5, 1), (0.6, 1), (0.7, 1), (0.8, 1), (0.9, 1), (0.8, 2), (0.8, 4)]:
        bodies = [create_map(side, hurst, stretch) for side in ("upper", "lower")]
        pairs_by_origin = {
            "the map": list(cut_piece_pairs(*bodies)),
            "sections along x": list(generate_surrogate_pairs(*bodies, "row")),
        }
        if stretch > 1:
            pairs_by_origin["sections along y"] = list(generate_surrogate_pairs(*bodies, "column"))
        map_mean = None
        for origin, pairs in pairs_by_origin.items():
            pair_results = np.array([compute_pair_results(*pair) for pair in pairs])
            mean, standard_errors = pair_results.mean(axis=0), pair_results.std(axis=0, ddof=1) / np.sqrt(NUM_PAIRS)
            map_mean = mean if map_mean is None else map_mean
            cells = []
            for value, standard_error, ratio in zip(mean, standard_errors, mean / map_mean, strict=True):
                cells += [f"{value:.3f} ± {standard_error:.3f}", "" if origin == "the map" else f"{ratio:.2f}"]
            lines.append(f"| {hurst} | {stretch} | {origin} | {' | '.join(cells)} |")
            print(lines[-1], flush=True)
    TABLE_FILE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
