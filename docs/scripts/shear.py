"""Compare computed shear tests with Barton's law, and write images/shear_barton.png and generated/shear_barton.md.

The script takes about two minutes on one core.
"""

import math
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from stiction import Surface, self_affine_surface, shear_test
from stiction.surfaces.joint_roughness import measure_joint_roughness

DOCS_DIRECTORY = Path(__file__).parents[1]

JRC_VALUES = (4, 8, 12, 16, 18)
JRC_RANGE_HALF_WIDTH = (
    1.0  # half of the JRC range that each of the ten typical profiles of Barton and Choubey represents
)
BASIC_ANGLE = 31.0  # degrees
NORMAL_STRESS, WALL_STRENGTH = 1.0, 150.0  # MPa
NUM_POINTS, SPACING = 200, 500.0  # µm
NUM_FACES = 4
SHEAR_TEST_OPTIONS = {
    "path": "10 mm", "steps": 20, "load": f"{NORMAL_STRESS} MPa", "mu0": math.tan(math.radians(BASIC_ANGLE)),
    "young": "30 GPa", "poisson": 0.25, "hardness": f"{WALL_STRENGTH} MPa", "strips": 0,
}  # fmt: skip
ORANGE, BLUE = "#D55E00", "#0072B2"


def create_face(seed: int, jrc: float) -> Surface:
    """Return a face with a given JRC, which follows from Z2 along x at a sampling interval of 1.27 mm."""
    face = self_affine_surface(
        seed,
        hurst_exponent=0.8,
        rms=1000.0,
        shape=(NUM_POINTS, NUM_POINTS),
        spacing=SPACING,
        shortest_wavelength=2000.0,
    )
    z2 = 10 ** ((jrc - 32.2) / 32.47)
    return Surface(face.heights * z2 / measure_joint_roughness(face, 0).z2, spacing=SPACING)


def compute_friction_and_dilation_angles(seed: int, jrc: float) -> list[float]:
    """Return the peak friction angle, the angle at 10 mm and the dilation angle at the peak, all in degrees."""
    face = create_face(seed, jrc)
    shear_result = shear_test(Surface(-face.heights[::-1], spacing=SPACING), face, **SHEAR_TEST_OPTIONS)
    coefficients = shear_result.attrs["peak"], shear_result.attrs["end"]
    return [*(math.degrees(math.atan(value)) for value in coefficients), shear_result.attrs["peak_dilation_angle_deg"]]


def main() -> None:
    rows, barton_angles = [], []
    for jrc in JRC_VALUES:
        rows.append(np.array([compute_friction_and_dilation_angles(seed, jrc) for seed in range(1, NUM_FACES + 1)]))
        barton_angles.append(BASIC_ANGLE + jrc * math.log10(WALL_STRENGTH / NORMAL_STRESS))
    header = "| JRC | Barton's peak angle | computed peak | at 10 mm | dilation angle at the peak |"
    lines = [header, "|---|---|---|---|---|"]
    for jrc, barton_angle, angles in zip(JRC_VALUES, barton_angles, rows, strict=True):
        cells = [f"{column.min():.0f}° to {column.max():.0f}°" for column in angles.T]
        lines.append(f"| {jrc} | {barton_angle:.0f}° | {' | '.join(cells)} |")
    (DOCS_DIRECTORY / "generated/shear_barton.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    figure = Figure(figsize=(4.2, 3.0), dpi=200, layout="constrained")
    axes = figure.subplots()
    half_width = JRC_RANGE_HALF_WIDTH * math.log10(WALL_STRENGTH / NORMAL_STRESS)
    barton_limits = np.subtract(barton_angles, half_width), np.add(barton_angles, half_width)
    axes.fill_between(
        JRC_VALUES, *barton_limits, color="0.4", alpha=0.25, linewidth=0, label=f"JRC ± {JRC_RANGE_HALF_WIDTH:g}"
    )
    axes.plot(JRC_VALUES, barton_angles, color="0.4", label="Barton's law")
    for column, colour, label in ((0, ORANGE, "computed, peak"), (1, BLUE, "computed, at 10 mm")):
        computed_angles = np.array([angles[:, column] for angles in rows])
        axes.plot(np.repeat(JRC_VALUES, NUM_FACES), computed_angles.ravel(), ".", color=colour, label=label)
    axes.axhline(BASIC_ANGLE, color="0.7", linewidth=0.7, linestyle="--")
    axes.text(JRC_VALUES[-1], BASIC_ANGLE - 1, "basic friction angle", color="0.4", ha="right", va="top")
    axes.set(xlabel="JRC of the lower face (Tse & Cruden)", ylabel="friction angle (degrees)", ylim=(0, 90))
    axes.legend(frameon=False, loc="lower left", ncols=2, fontsize=8, columnspacing=1)
    figure.savefig(DOCS_DIRECTORY / "images/shear_barton.png")


if __name__ == "__main__":
    main()
