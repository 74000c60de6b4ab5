"""Effect of polishing one of two faces: friction and true area as functions of the roughness of the upper face."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import pressed_maps, self_affine_surface
from stiction.studies.traverse import overlap_area
from stiction.views.style import AREA, STRENGTHS, STYLE

plt.rcParams.update(STYLE)

FINISHES = (0.1, 0.05, 0.02, 0.01)  # Sq of the upper face, µm; that of the lower stays 0.1
MATERIAL = {"mu0": 0.2, "tau0": [0.0, 0.5], "effective_modulus": 115.0, "shifts": 6}


def face(side, rms):
    """Return a lapped face with a given Sq."""
    return self_affine_surface(
        9, hurst_exponent=0.8, rms=rms, shape=(192, 192), spacing=0.2, longest_wavelength=8.0, shortest_wavelength=1.0,
        side=side,
    )  # fmt: skip


lower = face("lower", 0.1)
rows = []
for rms in FINISHES:
    upper = face("upper", rms)
    load = 0.02 * overlap_area(upper, lower)  # 20 MPa
    rows.append(pressed_maps(upper, lower, [load], **MATERIAL))


def mean_over_shifts(values):
    """Return the mean and twice its standard error."""
    return float(values.mean()), 2 * float(values.std("repetition", ddof=1)) / np.sqrt(values.sizes["repetition"])


figure, (left, right) = plt.subplots(1, 2, figsize=(6.2, 3.3), layout="constrained")
for tau0, colour in zip((0.0, 0.5), STRENGTHS, strict=True):
    for rule, style, words in (("opposing", "-", "opposing contacts rub"), ("all", "--", "all rub")):
        # Mean over all directions of each shift, so that asymmetric slopes cancel.
        found = [each["friction_coefficient"].sel(sliding=rule, tau0=tau0).squeeze().mean("direction") for each in rows]
        middle, error = np.transpose([mean_over_shifts(each) for each in found])
        left.fill_between(FINISHES, middle - error, middle + error, color=colour, alpha=0.15, linewidth=0)
        label = rf"{words}, $\tau_0$ = {1000 * tau0:.0f} MPa"
        left.plot(FINISHES, middle, style, color=colour, marker="o", markersize=3, label=label)
area, error = np.transpose([mean_over_shifts(100 * each["contact_area_fraction"].squeeze()) for each in rows])
right.fill_between(FINISHES, area - error, area + error, color=AREA, alpha=0.2, linewidth=0)
right.plot(FINISHES, area, "o-", markersize=3, color=AREA)
left.set(ylabel=r"$\mu_s$, mean about the compass", ylim=(0, None))
right.set(ylabel="true area (%)", ylim=(0, None))
for axes in (left, right):
    axes.set(xlabel="Sq of the upper face (µm)", xscale="log", xticks=FINISHES, xticklabels=map(str, FINISHES))
    axes.minorticks_off()
figure.legend(
    loc="outside lower center", ncols=2, handlelength=3,
    title=r"steel, Sq of the lower face 0.1 µm, $\mu_0$ = 0.2, 20 MPa; shaded: two standard errors",
)  # fmt: skip
figure.savefig("polishing.png", dpi=200)
for rms, percent, each, own in zip(FINISHES, area, error, rows, strict=True):
    gradient = float(own["rms_gradient"].mean())
    print(f"Sq = {rms:.2f} µm: A/A0 = {percent:.2f} +- {each:.2f} %, h' of the gap = {gradient:.3f}")
