"""Static friction of lapped steel on lapped steel as a function of load, for three finishes of generated profiles."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import effective_modulus, flipped, self_affine, traverse, traverse_mean
from stiction.views.style import STYLE, label

plt.rcParams.update(STYLE)

STEEL = float(effective_modulus(210.0, 0.3, 210.0, 0.3))  # GPa
LOADS = np.geomspace(1.0, 100.0, 9)  # mN on 1 mm by 1 µm: 1 to 100 MPa of nominal pressure

figure, axes = plt.subplots(figsize=(4.2, 3.0), layout="constrained")
for rms, grey in ((0.02, "0.0"), (0.05, "0.35"), (0.1, "0.6")):  # µm
    faces = {
        side: [
            self_affine(
                7, hurst_exponent=0.8, rms=rms, points=8000, spacing=0.125, side=side, repetition=repetition,
                longest_wavelength=50.0, shortest_wavelength=2.0,
            )
            for repetition in range(24)
        ]
        for side in ("upper", "lower")
    }  # fmt: skip
    uppers = [flipped(face) for face in faces["upper"]]
    mean = traverse_mean(traverse(uppers, faces["lower"], LOADS, mu0=0.15, tau0=0.2, effective_modulus=STEEL))
    friction = mean["friction_coefficient"].sel(shear="+x")
    middle, lower, upper = (friction.sel(statistic=each).values for each in ("mean", "lower", "upper"))
    print(f"Rq = {1000 * rms:3.0f} nm: mu_s = {middle[4]:.3f} [{lower[4]:.3f}, {upper[4]:.3f}] at {LOADS[4]:g} mN")
    axes.fill_between(LOADS, lower, upper, color=grey, alpha=0.15, linewidth=0)
    axes.plot(LOADS, middle, color=grey)
    axes.annotate(f"Rq = {1000 * rms:.0f} nm", (LOADS[-1], middle[-1]), (3, -2), textcoords="offset points")
axes.set(
    xscale="log", xlim=(1, 300), xlabel="normal load $F_N$ (mN) on 1 mm by 1 µm", ylabel=label("friction_coefficient")
)
axes.set(title=r"lapped steel, $\mu_0$ = 0.15, $\tau_0$ = 200 MPa")
figure.savefig("lapped_steel.png", dpi=200)
