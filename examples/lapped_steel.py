"""Compute the static friction of lapped steel on lapped steel over the load, for profiles of three finishes."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import effective_modulus, pair, self_affine
from stiction.views.style import MATPLOTLIB_STYLE, axis_label

plt.rcParams.update(MATPLOTLIB_STYLE)

STEEL_MODULUS = float(effective_modulus(210.0, 0.3, 210.0, 0.3))  # GPa
PRESSURES = np.geomspace(1.0, 100.0, 9)  # MPa
NUM_SCANS = 6  # number of scans of each face; each scan of the upper face is pressed on each scan of the lower face

figure, axes = plt.subplots(figsize=(4.2, 3.0), layout="constrained")
for rms, grey in ((0.02, "0.0"), (0.05, "0.35"), (0.1, "0.6")):  # µm
    faces = {
        side: [
            self_affine(
                7, hurst_exponent=0.8, rms=rms, points=8000, spacing=0.125, side=side, repetition=repetition,
                longest_wavelength=50.0, shortest_wavelength=2.0,
            )
            for repetition in range(NUM_SCANS)
        ]
        for side in ("upper", "lower")
    }  # fmt: skip
    result = pair(
        faces["upper"], faces["lower"], load=[f"{pressure:.4g} MPa" for pressure in PRESSURES], mu0=0.15,
        tau0="200 MPa", effective_modulus=STEEL_MODULUS, cutoff="none", onset=0,
    )  # fmt: skip
    friction = result.at()["mean_friction"].sel(sliding="opposing").squeeze()
    mean_friction, lower, upper = friction.transpose("statistic", "load").values
    print(
        f"Rq = {1000 * rms:3.0f} nm: mu_s = {mean_friction[4]:.3f} [{lower[4]:.3f}, {upper[4]:.3f}] "
        f"at {PRESSURES[4]:g} MPa"
    )
    axes.fill_between(PRESSURES, lower, upper, color=grey, alpha=0.15, linewidth=0)
    axes.plot(PRESSURES, mean_friction, color=grey)
    axes.annotate(f"Rq = {1000 * rms:.0f} nm", (PRESSURES[-1], mean_friction[-1]), (3, -2), textcoords="offset points")
axes.set(
    xscale="log", xlim=(1, 300), xlabel="pressure on the nominal area (MPa)", ylabel=axis_label("friction_coefficient")
)
axes.set(title=r"lapped steel, $\mu_0$ = 0.15, $\tau_0$ = 200 MPa")
figure.savefig("lapped_steel.png", dpi=200)
