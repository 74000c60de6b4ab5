"""Compute friction and true area of two ground faces as functions of the angle between the lays of the faces."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import Surface, cropped, levelled, on_common_grid, pair, rotated, self_affine_surface
from stiction.views.style import AREA_COLOUR, MATPLOTLIB_STYLE, SHEAR_STRENGTH_COLOURS

plt.rcParams.update(MATPLOTLIB_STYLE)

ANGLES = np.array([0.0, 15.0, 30.0, 45.0, 60.0, 90.0])
MAP_SIDE_LENGTH = 38.4  # µm
PAIR_OPTIONS = {
    "load": "20 MPa", "mu0": 0.2, "tau0": "0 MPa,500 MPa", "effective_modulus": "115 GPa", "shifts": 12,
    "direction": [0, 90, 180, 270], "cutoff": "none", "onset": 0,
}  # fmt: skip


def create_ground_face(side):
    """Return a face on a square grid of 0.2 µm with grooves along y, which are eight times as long as wide."""
    unstretched_surface = self_affine_surface(
        8, hurst_exponent=0.8, rms=0.15, shape=(80, 320), spacing=0.2, longest_wavelength=8.0, shortest_wavelength=0.8,
        side=side,
    )  # fmt: skip
    stretched_surface = Surface(unstretched_surface.heights, spacing=(1.6, 0.2))
    square_grid = Surface(np.zeros((320, 320)), spacing=0.2)
    return levelled(on_common_grid(stretched_surface, square_grid)[0], "plane")


upper, lower = create_ground_face("upper"), create_ground_face("lower")
tables = []
for angle in ANGLES:
    rotated_upper = rotated(upper, angle)
    crop_corner = tuple((extent - MAP_SIDE_LENGTH) / 2 for extent in rotated_upper.extent)
    upper_piece = cropped(rotated_upper, crop_corner, tuple(start + MAP_SIDE_LENGTH for start in crop_corner))
    faces = on_common_grid(upper_piece, cropped(lower, (0.0, 0.0), (MAP_SIDE_LENGTH, MAP_SIDE_LENGTH)))
    tables.append(pair(*faces, **PAIR_OPTIONS).at().isel(cut_off=0, load=0, mu0=0))


figure, (friction_axes, area_axes) = plt.subplots(2, 1, figsize=(5.4, 4.8), sharex=True, layout="constrained")
for tau0, colour in zip((0.0, 0.5), SHEAR_STRENGTH_COLOURS, strict=True):
    for axis, style, direction_text in ((0.0, "-", "across the lower grooves"), (90.0, "--", "along them")):
        # Average over both directions along an axis, which cancels the effect of a tilt.
        selection = {"sliding": "opposing", "tau0": tau0, "axis": axis}
        mean_friction, lower_limit, upper_limit = np.transpose(
            [table["friction_by_axis"].sel(selection) for table in tables]
        )
        friction_axes.fill_between(ANGLES, lower_limit, upper_limit, color=colour, alpha=0.15, linewidth=0)
        label = rf"{direction_text}, $\tau_0$ = {1000 * tau0:.0f} MPa"
        friction_axes.plot(ANGLES, mean_friction, style, color=colour, marker="o", markersize=3, label=label)
area_percent, lower_limit, upper_limit = 100 * np.transpose([table["contact_area_fraction"] for table in tables])
area_axes.fill_between(ANGLES, lower_limit, upper_limit, color=AREA_COLOUR, alpha=0.2, linewidth=0)
area_axes.plot(ANGLES, area_percent, "o-", markersize=3, color=AREA_COLOUR)
friction_axes.set(ylabel=r"$\mu_s$, friction at opposing contacts", ylim=(0, None))
area_axes.set(xlabel="angle between the lays (degrees)", ylabel="true area (%)", ylim=(0, None))
figure.legend(
    loc="outside lower center", ncols=2, handlelength=3,
    title=r"ground steel on ground steel, $\mu_0$ = 0.2, 20 MPa; shaded: 95 % intervals",
)  # fmt: skip
figure.savefig("ground_faces.png", dpi=200)
for angle, percent, table in zip(ANGLES, area_percent, tables, strict=True):
    gradient = float(table["rms_gradient"].sel(statistic="mean"))
    print(f"{angle:3.0f} degrees: A/A0 = {percent:.2f} %, h' = {gradient:.3f}")
