"""Press terrain around the Jacksboro fault at a scale of 1 µm to 1 m. Without tau0, friction has no length scale."""

import math

import numpy as np
from matplotlib.cbook import get_sample_data
from stiction import Surface, levelled, nondimensional, pair
from stiction.views.characterisation import characterisation_text
from stiction.views.figures.roughness import characterisation_figure

METRES_PER_DEGREE = 111_200  # metres per degree of latitude

# The file has elevations in whole metres on a grid of 1/1200 degree, with the first row in the north.
elevation_model = get_sample_data("jacksboro_fault_dem.npz")
y_spacing = float(elevation_model["dy"]) * METRES_PER_DEGREE
x_spacing = float(elevation_model["dx"]) * METRES_PER_DEGREE * math.cos(math.radians(float(elevation_model["ymin"])))
surface = levelled(
    Surface(
        elevation_model["elevation"][::-1].astype(np.float64),
        spacing=(y_spacing, x_spacing),
        history=("terrain about the Jacksboro fault, 1 m as 1 µm",),
    ),
    "plane",
)

print(characterisation_text(surface), end="")
characterisation_figure(surface).savefig("fault_surface.png")

# Press lines of the terrain against other lines, with E* = 40 GPa, as for rock.
# Loads are made nondimensional with E* and the length L of a line: F/(E* L²).
length = surface.extent[1]
loads = np.geomspace(1e-7, 1e-4, 4) * 40.0 * length**2
options = {"effective_modulus": "40 GPa", "mu0": 0.6, "cutoff": "none", "onset": 0}
result = pair(surface, surface, load=loads, lines=24, **options)
mean_values = nondimensional(result.at()[["friction_coefficient"]], length=length)["friction_coefficient"]
for friction_at_load in mean_values.sel(sliding="opposing", direction=0.0).squeeze().transpose("load", ...):
    mean_friction, lower, upper = friction_at_load.values
    print(f"F/(E* L²) = {float(friction_at_load['load']):.0e}: mu_s = {mean_friction:.2f} [{lower:.2f}, {upper:.2f}]")
