"""Press a worn map and its surrogate, each against itself, to show the effect of the height distribution."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import Surface, levelled, pair, self_affine_surface, surface_parameters, surrogate
from stiction.views.style import MATPLOTLIB_STYLE

plt.rcParams.update(MATPLOTLIB_STYLE)

# Create a rough surface whose peaks are worn to a plateau with finer roughness.
rough_face, fine_face = (
    self_affine_surface(
        6, hurst_exponent=0.8, rms=rms, shape=(192, 192), spacing=0.02, longest_wavelength=0.8,
        shortest_wavelength=0.1, side=side,
    )
    for rms, side in ((0.02, "lower"), (0.002, "upper"))
)  # fmt: skip
worn_face = levelled(
    Surface(np.minimum(rough_face.heights, 0.01 + fine_face.heights), spacing=rough_face.spacing), "plane"
)
surrogate_body = surrogate(worn_face, 2016)
PAIR_OPTIONS = {
    "load": "3 MPa,10 MPa,30 MPa", "effective_modulus": "10 GPa", "mu0": 0.3, "tau0": "50 MPa", "shifts": 8,
    "direction": [0, 90, 180, 270], "cutoff": "none", "onset": 0,
}  # fmt: skip

figure, axes = plt.subplots(1, 2, figsize=(6.0, 2.8), layout="constrained")
for name, body, colour in (("worn", worn_face, "0.0"), ("surrogate", surrogate_body, "0.55")):
    axes[0].hist(1000 * body.heights.ravel(), 80, histtype="step", density=True, color=colour, label=name)
    parameters = surface_parameters(body)
    table = pair(body, body, **PAIR_OPTIONS).at().isel(cut_off=0, mu0=0, tau0=0)
    area = 100 * table["contact_area_fraction"].values
    axes[1].fill_between([3, 10, 30], area[:, 1], area[:, 2], color=colour, alpha=0.2, linewidth=0)
    axes[1].plot([3, 10, 30], area[:, 0], "o-", markersize=3, color=colour, label=f"{name} on itself")
    # The results are means over directions and positions, with their intervals.
    friction, lower_limit, upper_limit = table["mean_friction"].sel(sliding="all").isel(load=1).values
    print(f"{name}: Sq {1000 * parameters.Sq:.1f} nm, Ssk {parameters.Ssk:.2f}, Sdq {parameters.Sdq:.3f}; at 10 MPa")
    print(f"  A/A0 = {area[1, 0]:.2f} % [{area[1, 1]:.2f}, {area[1, 2]:.2f}]")
    print(f"  mu_s, all contacts: {friction:.3f} [{lower_limit:.3f}, {upper_limit:.3f}]")
axes[0].set(xlabel="height (nm)", ylabel="density (1/nm)")
axes[1].set(xlabel="pressure (MPa)", ylabel="true area (%)", xscale="log", yscale="log")
axes[1].set(xticks=[3, 10, 30], xticklabels=["3", "10", "30"], yticks=[0.3, 1, 3], yticklabels=["0.3", "1", "3"])
axes[1].minorticks_off()
for axis in axes:
    axis.legend(fontsize=7, frameon=False)
figure.savefig("afm_surrogate.png", dpi=200)
