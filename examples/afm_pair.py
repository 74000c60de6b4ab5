"""Friction of two AFM maps, line by line, in both directions: python afm_pair.py [UPPER LOWER], instrument files."""

import sys

import numpy as np
from stiction import Surface, paired_lines, read_surface, self_affine, traverse, traverse_mean
from stiction.views.traverse import contact_figure, load_figure


def stand_in(side):
    """Lines like those of a map of 10 µm: independent of each other, which those of a map are not."""
    lines = [
        self_affine(
            3, hurst_exponent=0.85, rms=0.02, points=512, spacing=10 / 512, shortest_wavelength=0.1, side=side,
            repetition=line,
        ).heights
        for line in range(64)
    ]  # fmt: skip
    return Surface(np.array(lines), spacing=10 / 512, history=(f"stand-in for a map of the {side} body",))


upper, lower = map(read_surface, sys.argv[1:]) if len(sys.argv) == 3 else map(stand_in, ("upper", "lower"))
uppers, lowers = paired_lines(upper, lower, lines=32)
material = {"effective_modulus": 5.0, "detection": "gap-minimum"}  # GPa
result = traverse(uppers, lowers, np.geomspace(1e-4, 1e-1, 13), mu0=0.2, tau0=0.05, **material)  # mN, GPa
mean = traverse_mean(result)
for load in mean["load"].values[::4]:
    at = mean.sel(load=load, shear="+x")
    middle, least, most = at["friction_coefficient"].values
    beyond = float(at["share_beyond_hertz"].sel(statistic="mean"))
    print(
        f"{1000 * load:8.3g} µN: mu_s = {middle:.2f} [{least:.2f}, {most:.2f}], {beyond:.0%} of the load beyond Hertz"
    )
load_figure(mean, [0.01]).savefig("afm_friction.png")
approach = float(result["approach"].isel(shear=0, line=0, offset=0, load=8))  # of 10 µN
contact_figure(uppers[0], lowers[0], approach, mu0=0.2, tau0=0.05, **material).savefig("afm_contact.png")
