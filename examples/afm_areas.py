"""Compute the friction of two AFM maps in all directions; usage: python afm_areas.py [UPPER LOWER].

UPPER and LOWER are instrument files. Without them, the script writes synthetic files.
"""

import sys
from pathlib import Path

from stiction import Study, run, self_affine_surface, write_surface
from stiction.companions.contact_picture import contact_picture
from stiction.views.figures import draw_figures
from stiction.views.text import result_text


def write_synthetic_file(side):
    """Write a synthetic AFM file of a lapped face."""
    face = self_affine_surface(
        5, hurst_exponent=0.8, rms=0.01, shape=(128, 128), spacing=0.02, longest_wavelength=0.6,
        shortest_wavelength=0.1, side=side,
    )  # fmt: skip
    Path(f"{side}.npy").unlink(missing_ok=True)
    write_surface(face, f"{side}.npy")
    return {"file": f"{side}.npy", "unit": "um", "spacing": "0.02 um"}


has_files = len(sys.argv) == 3
upper, lower = ({"file": name} for name in sys.argv[1:]) if has_files else map(write_synthetic_file, ("upper", "lower"))
study = Study().with_changes(
    {
        "surfaces.kind": "measured",
        "surfaces.press": "areas",
        "surfaces.upper": upper,
        "surfaces.lower": lower,
        "contact.mechanics": "half-space",
        "contact.effective_modulus": "10 GPa",
        "contact.hardness": "0.6 GPa",
        "contact.yield_exponent": "uniform 0.7 .. 1.6",
        "contact.junction_growth": "slip-line",
        "contact.load": ["20 uN", "60 uN", "200 uN"],
        "friction.mu0": [0.1],
        "friction.tau0": ["20 MPa"],
        "friction.load": ["60 uN"],
        "ensemble.repetitions": 16 if has_files else 8,  # number of relative positions of the two maps
    }
)
result = run(study)
print(result_text(result.summary()))
draw_figures(result, Path(), picture=contact_picture(result))
