"""Compute the friction of two AFM maps line by line in both directions; usage: python afm_pair.py [UPPER LOWER].

UPPER and LOWER are instrument files. Without them, the script creates synthetic maps.
"""

import sys

import numpy as np
from stiction import Surface, pair, read_surface, self_affine


def create_synthetic_map(side):
    """Return a synthetic map of 10 µm with independent lines, unlike the lines of a measured map."""
    lines = [
        self_affine(
            3, hurst_exponent=0.85, rms=0.02, points=512, spacing=10 / 512, shortest_wavelength=0.1, side=side,
            repetition=line,
        ).heights
        for line in range(64)
    ]  # fmt: skip
    return Surface(np.array(lines), spacing=10 / 512, history=(f"stand-in for a map of the {side} body",))


upper, lower = map(read_surface, sys.argv[1:]) if len(sys.argv) == 3 else map(create_synthetic_map, ("upper", "lower"))
loads = np.geomspace(1e-3, 1e-1, 3)  # mN
options = {"mu0": 0.2, "tau0": "50 MPa", "effective_modulus": "5 GPa", "cutoff": "none", "onset": 0}
result = pair(upper, lower, load=loads, lines=32, **options)
friction_table = result.at().sel(sliding="opposing", direction=0.0).isel(cut_off=0, mu0=0, tau0=0)
for load in friction_table["load"].values:
    friction_at_load = friction_table.sel(load=load)
    mean_friction, lower_limit, upper_limit = friction_at_load["friction_coefficient"].values
    fraction_beyond_hertz = float(friction_at_load["share_beyond_hertz"].sel(statistic="mean"))
    print(
        f"{1000 * load:8.3g} µN: μ_s = {mean_friction:.2f} [{lower_limit:.2f}, {upper_limit:.2f}], "
        f"{fraction_beyond_hertz:.0%} of the load beyond Hertz"
    )
for name, file_name in (("friction", "afm_friction.png"), ("contact", "afm_contact.png")):
    result.figure(name).savefig(file_name)
