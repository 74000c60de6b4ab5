"""Write a synthetic scan of a lapped part as an instrument would, then read, level and characterise the scan."""

from pathlib import Path

import numpy as np
from stiction import Profile, levelled, read_profile, self_affine, write_profile
from stiction.views.characterisation import characterisation_text
from stiction.views.figures.roughness import characterisation_figure

# Create a ground profile whose peaks are worn to a plateau with finer roughness, on a tilted table.
ground_profile = self_affine(3, hurst_exponent=0.8, rms=0.2, points=8000, spacing=0.05, longest_wavelength=40.0)
lapped_profile = self_affine(4, hurst_exponent=0.8, rms=0.01, points=8000, spacing=0.05, longest_wavelength=40.0)
heights = np.minimum(ground_profile.heights, 0.05 + lapped_profile.heights) + 0.002 * ground_profile.x

scan = Path("lapped.csv")
scan.unlink(missing_ok=True)
write_profile(Profile(heights, spacing=0.05), scan)

profile = levelled(read_profile(scan), "line")
print(characterisation_text(profile), end="")
characterisation_figure(profile).savefig("characterise_profile.png")
