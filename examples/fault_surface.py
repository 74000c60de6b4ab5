"""Terrain around the Jacksboro fault, 1 m as 1 µm: slopes, Hurst exponents and friction at tau0 = 0 have no scale."""

import math

import numpy as np
from matplotlib.cbook import get_sample_data
from stiction import Surface, levelled, nondimensional, paired_lines, traverse, traverse_mean
from stiction.views.characterisation import characterisation_text
from stiction.views.figures.roughness import characterisation_figure

METRES_PER_DEGREE = 111_200  # of latitude

# Elevations in whole metres on a grid of 1/1200 degree, the first row in the north.
terrain = get_sample_data("jacksboro_fault_dem.npz")
north_south = float(terrain["dy"]) * METRES_PER_DEGREE
east_west = float(terrain["dx"]) * METRES_PER_DEGREE * math.cos(math.radians(float(terrain["ymin"])))
surface = levelled(
    Surface(
        terrain["elevation"][::-1].astype(np.float64),
        spacing=(north_south, east_west),
        history=("terrain about the Jacksboro fault, 1 m as 1 µm",),
    ),
    "plane",
)

print(characterisation_text(surface), end="")
characterisation_figure(surface).savefig("fault_surface.png")

# Lines against other lines, E* = 40 GPa; the dimensionless load is F/(E* L²) with the length L of a line.
uppers, lowers = paired_lines(surface, surface, lines=24)
loads = np.geomspace(1e-7, 1e-4, 4) * 40.0 * uppers[0].extent ** 2
mean = traverse_mean(traverse(uppers, lowers, loads, mu0=0.6, effective_modulus=40.0))
for at in nondimensional(mean, length=uppers[0].extent).sel(shear="+x").transpose("load", ...)["friction_coefficient"]:
    middle, lower, upper = at.values
    print(f"F/(E* L²) = {float(at['load']):.0e}: mu_s = {middle:.2f} [{lower:.2f}, {upper:.2f}]")
