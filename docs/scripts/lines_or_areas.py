"""Compare contact area and friction of maps, of their profiles, and of tamaas: docs/generated/lines_or_areas.md."""

from pathlib import Path

import numpy as np
import tamaas
from stiction import approach_at_load, half_space, pair, press, self_affine_surface
from stiction._core import patches_of

TABLE_FILE = Path(__file__).parent.parent / "generated/lines_or_areas.md"
NUM_POINTS, SPACING, PRESSURE, NUM_PAIRS, NUM_LINES, MU0 = 128, 0.1, 0.02, 6, 32, 0.3  # µm, GPa
DIRECTIONS = [0.0, 90.0, 180.0, 270.0]


def generate_surfaces(repetition):
    """Return the two surfaces of a repetition."""
    return tuple(
        self_affine_surface(
            3, repetition=repetition, hurst_exponent=0.8, rms=0.03, shape=(NUM_POINTS, NUM_POINTS), spacing=SPACING,
            longest_wavelength=3.2, shortest_wavelength=0.8, side=side,
        )
        for side in ("upper", "lower")
    )  # fmt: skip


def compute_pair_results(upper, lower):
    """Return A/A0 (%) and mu_s of a pair for each contact model."""
    area = (NUM_POINTS * SPACING) ** 2
    load = [PRESSURE * area]
    results = {}
    for name, boundary in (
        ("height maps: half-space, periodic", "periodic"),
        ("height maps: half-space, free edges", "free"),
    ):
        curve = half_space(upper, lower, load, boundary=boundary, direction=DIRECTIONS)
        results[name] = curve.contact_area[0] / area, curve.friction_coefficient(mu0=MU0).mean()
    curve = press(upper, lower, approach_at_load(upper, lower, load, mu0=0.0), direction=DIRECTIONS)
    results["height maps: asperities"] = curve.contact_area[0] / area, curve.friction_coefficient(mu0=MU0).mean()
    model = tamaas.Model(tamaas.model_type.basic_2d, [NUM_POINTS * SPACING] * 2, [NUM_POINTS, NUM_POINTS])
    model.E, model.nu = 10.0, 0.0
    tamaas.PolonskyKeerRey(model, np.ascontiguousarray(lower.heights - upper.heights), 1e-10).solve(PRESSURE)
    area_fraction = patches_of(np.ascontiguousarray(model.traction), periodic=True, hardness=np.inf)[2]
    results["tamaas: points under pressure"] = area_fraction.size / model.traction.size, np.nan
    results["tamaas: corrected for contact edges"] = area_fraction.sum() / model.traction.size, np.nan
    for name, law, curvature in (
        ("32 profiles: spheres on a strip 1 µm thick", "hertz-sphere", "convex"),
        ("32 profiles: cylinders", "hertz-cylinder", "signed"),
    ):  # fmt: skip
        scan = upper.changed(-upper.heights, "scan of the upper body")
        options = {"law": law, "curvature": curvature, "lines": NUM_LINES, "cutoff": "none", "onset": 0}
        result = pair(scan, lower, load=f"{PRESSURE} GPa", mu0=MU0, effective_modulus="10 GPa", **options)
        result_values = result.at().sel(statistic="mean", sliding="opposing").squeeze()
        results[name] = float(result_values["contact_area_fraction"]), float(result_values["mean_friction"])
    return results


def main():
    tamaas.set_log_level(tamaas.LogLevel.error)
    results = [compute_pair_results(*generate_surfaces(repetition)) for repetition in range(NUM_PAIRS)]
    lines = ["| method | A/A0 (%) | μ_s, friction at opposing contacts |", "|---|---|---|"]
    for name in results[0]:
        values = np.array([pair_results[name] for pair_results in results]) * [100, 1]
        mean, standard_errors = values.mean(axis=0), values.std(axis=0, ddof=1) / np.sqrt(NUM_PAIRS)
        cells = [
            "" if np.isnan(value) else f"{value:.3g} ± {standard_error:.2g}"
            for value, standard_error in zip(mean, standard_errors, strict=True)
        ]
        lines.append(f"| {name} | {' | '.join(cells)} |")
    TABLE_FILE.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
