"""Studies of two measured files, made small, for the tests of everything that comes after the sums."""

import numpy as np
from stiction import self_affine, self_affine_surface
from stiction.studies.study import study_from_text


def write_maps(folder, shape=(48, 48), rms=0.02):
    for name, side in (("upper", "upper"), ("lower", "lower")):
        body = self_affine_surface(
            3, hurst_exponent=0.8, rms=rms, shape=shape, spacing=0.1, shortest_wavelength=0.6, side=side
        )
        np.save(folder / f"{name}.npy", body.heights)
    return "0.1 um"


def write_profiles(folder, points=1200):
    for name, side in (("upper", "upper"), ("lower", "lower")):
        body = self_affine(
            3, hurst_exponent=0.8, rms=0.05, points=points, spacing=0.02, shortest_wavelength=0.2, side=side
        )
        np.save(folder / f"{name}.npy", body.heights)
    return "0.02 um"


def study_of(folder, press="areas", mechanics="half-space", *, spacing, members=6, load="2 mN", more="", contact=""):
    """A study of the files upper.npy and lower.npy in a folder."""
    return study_from_text(
        f"""
[surfaces]
kind = "measured"
press = "{press}"
upper = {{ file = "{folder}/upper.npy", unit = "um", spacing = "{spacing}" }}
lower = {{ file = "{folder}/lower.npy", unit = "um", spacing = "{spacing}" }}
{more}

[contact]
mechanics = "{mechanics}"
effective_modulus = "100 GPa"
{contact}

[friction]
mu0 = [0.3]
tau0 = ["0 MPa", "50 MPa"]
load = ["{load}"]

[ensemble]
repetitions = {members}
""",
        "test",
    )
