"""Compute friction and true area of two faces as functions of the roughness of the upper face, which is polished."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import pair, self_affine_surface
from stiction.views.style import AREA_COLOUR, MATPLOTLIB_STYLE, SHEAR_STRENGTH_COLOURS

plt.rcParams.update(MATPLOTLIB_STYLE)

UPPER_RMS_HEIGHTS = (0.1, 0.05, 0.02, 0.01)  # Sq of the upper face in µm; Sq of the lower face is 0.1 µm
PAIR_OPTIONS = {
    "load": "20 MPa", "mu0": 0.2, "tau0": "0 MPa,500 MPa", "effective_modulus": "115 GPa", "shifts": 6,
    "cutoff": "none", "onset": 0,
}  # fmt: skip


def create_face(side, rms):
    """Return a lapped face with a given Sq (µm)."""
    return self_affine_surface(
        9, hurst_exponent=0.8, rms=rms, shape=(192, 192), spacing=0.2, longest_wavelength=8.0, shortest_wavelength=1.0,
        side=side,
    )  # fmt: skip


lower = create_face("lower", 0.1)
tables = [
    pair(create_face("upper", rms), lower, **PAIR_OPTIONS).at().isel(cut_off=0, load=0, mu0=0)
    for rms in UPPER_RMS_HEIGHTS
]

figure, (friction_axes, area_axes) = plt.subplots(1, 2, figsize=(6.2, 3.3), layout="constrained")
for tau0, colour in zip((0.0, 0.5), SHEAR_STRENGTH_COLOURS, strict=True):
    for rule, style, rule_text in (("opposing", "-", "opposing contacts"), ("all", "--", "all contacts")):
        # Average over all directions, which cancels the effect of a tilt.
        mean_friction, lower_limit, upper_limit = np.transpose(
            [table["mean_friction"].sel(sliding=rule, tau0=tau0) for table in tables]
        )
        friction_axes.fill_between(UPPER_RMS_HEIGHTS, lower_limit, upper_limit, color=colour, alpha=0.15, linewidth=0)
        label = rf"{rule_text}, $\tau_0$ = {1000 * tau0:.0f} MPa"
        friction_axes.plot(UPPER_RMS_HEIGHTS, mean_friction, style, color=colour, marker="o", markersize=3, label=label)
area_percent, lower_limit, upper_limit = 100 * np.transpose([table["contact_area_fraction"] for table in tables])
area_axes.fill_between(UPPER_RMS_HEIGHTS, lower_limit, upper_limit, color=AREA_COLOUR, alpha=0.2, linewidth=0)
area_axes.plot(UPPER_RMS_HEIGHTS, area_percent, "o-", markersize=3, color=AREA_COLOUR)
friction_axes.set(ylabel=r"$\mu_s$, mean over directions", ylim=(0, None))
area_axes.set(ylabel="true area (%)", ylim=(0, None))
for axes in (friction_axes, area_axes):
    axes.set(
        xlabel="Sq of the upper face (µm)",
        xscale="log",
        xticks=UPPER_RMS_HEIGHTS,
        xticklabels=map(str, UPPER_RMS_HEIGHTS),
    )
    axes.minorticks_off()
figure.legend(
    loc="outside lower center", ncols=2, handlelength=3,
    title=r"steel, Sq of the lower face 0.1 µm, $\mu_0$ = 0.2, 20 MPa; shaded: 95 % intervals of the mean",
)  # fmt: skip
figure.savefig("polishing.png", dpi=200)
for rms, percent, table in zip(UPPER_RMS_HEIGHTS, area_percent, tables, strict=True):
    gradient = float(table["rms_gradient"].sel(statistic="mean"))
    print(f"Sq = {rms:.2f} µm: A/A0 = {percent:.2f} %, h' of the gap = {gradient:.3f}")
