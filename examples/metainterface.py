"""Compute the friction of 64 spherical caps of silicone on glass against the load, for given heights of the caps.

Two models are compared: an elastic half-space, in which the caps interact, and 64 independent Hertz contacts.
"""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import Surface, effective_modulus, half_space, hertz_sphere
from stiction.views.style import MATPLOTLIB_STYLE

plt.rcParams.update(MATPLOTLIB_STYLE)

# ---- Your measured values --------------------------------------------------------------------------------------------

RADIUS = 500.0  # radius of all caps in µm
PITCH = 1500.0  # distance between neighbouring caps in µm
MODULUS = effective_modulus(young_upper=70.0, poisson_upper=0.22, young_lower=2e-3, poisson_lower=0.5)  # GPa
SHEAR_STRENGTH = 0.3e-3  # shear strength (GPa): the friction of one smooth cap divided by its contact area
LOADS = np.geomspace(20.0, 1000.0, 13)  # loads (mN) on all caps together

random_order = np.random.default_rng(1).permutation(64)
HEIGHTS = {  # µm; yours: np.loadtxt("heights.csv", delimiter=","), an array of 8 rows and 8 columns
    "equal heights": np.zeros((8, 8)),
    "graded heights": (60.0 * np.sqrt((random_order + 0.5) / 64)).reshape(8, 8),
}

# ---- Two models ------------------------------------------------------------------------------------------------------

POINTS_PER_CAP = 96  # points per cap along each axis


def create_map(heights):
    """Return a height map of spherical caps with the given heights of their summits.

    Each cap is displaced by a random fraction of the grid spacing, so that the errors of the grid average out.
    """
    spacing = PITCH / POINTS_PER_CAP
    displacements = spacing * np.random.default_rng(2).uniform(-0.5, 0.5, (2, heights.size))
    cap_offsets = (np.arange(POINTS_PER_CAP) + 0.5) * spacing - PITCH / 2
    caps = [
        height
        + np.sqrt(np.maximum(RADIUS**2 - (cap_offsets[:, None] - dy) ** 2 - (cap_offsets - dx) ** 2, 0.0))
        - RADIUS
        for height, dy, dx in zip(heights.ravel(), *displacements, strict=True)
    ]
    rows, columns = heights.shape
    cap_tiles = np.reshape(caps, (rows, columns, POINTS_PER_CAP, POINTS_PER_CAP)).swapaxes(1, 2)
    return Surface(cap_tiles.reshape(rows * POINTS_PER_CAP, -1), spacing=(spacing, spacing))


def compute_interacting_area(heights):
    """Return the contact area (µm²) at each load if the caps belong to the same elastic half-space."""
    caps = create_map(heights)
    glass = Surface(np.zeros_like(caps.heights), spacing=caps.spacing)
    return half_space(glass, caps, LOADS, effective_modulus=MODULUS, compliance_share=1.0).contact_area


def compute_independent_area(heights):
    """Return the contact area (µm²) at each load if the caps are independent Hertz contacts."""
    approach = np.linspace(0.1, 300.0, 3000)[:, None]  # approach (µm) since the first contact
    overlap = approach - (heights.max() - heights.ravel())
    force, area = np.where(overlap > 0, hertz_sphere(np.maximum(overlap, 1e-9), RADIUS, MODULUS), 0.0)
    return np.interp(LOADS, force.sum(axis=1), area.sum(axis=1))


# ---- Figure and table ------------------------------------------------------------------------------------------------

figure, (friction_axes, coefficient_axes) = plt.subplots(1, 2, figsize=(6.9, 2.9), layout="constrained")
for (name, heights), colour in zip(HEIGHTS.items(), ("#0072b2", "#d55e00"), strict=True):
    interacting_friction = SHEAR_STRENGTH * compute_interacting_area(heights)  # mN
    independent_friction = SHEAR_STRENGTH * compute_independent_area(heights)
    for axes, divisor in ((friction_axes, 1.0), (coefficient_axes, LOADS)):
        axes.plot(LOADS, interacting_friction / divisor, "o", color=colour, markersize=4, label=f"{name}, half-space")
        axes.plot(LOADS, independent_friction / divisor, color=colour, label=f"{name}, independent contacts")
    print(f"{name}: load (mN), friction (mN) of the half-space, friction (mN) of independent contacts")
    for row in list(zip(LOADS, interacting_friction, independent_friction, strict=True))[::4]:
        print(" ".join(f"{value:8.1f}" for value in row))
friction_axes.set(xscale="log", yscale="log", xlabel="load (mN)", ylabel="static friction (mN)")
coefficient_axes.set(xscale="log", xlabel="load (mN)", ylabel=r"$\mu_s$ = friction / load", ylim=(0, None))
figure.legend(*friction_axes.get_legend_handles_labels(), loc="outside lower center", ncols=2)
figure.savefig("metainterface.png", dpi=200)
