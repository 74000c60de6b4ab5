"""Small studies and results of two measured files."""

import numpy as np
from stiction import run, self_affine, self_affine_surface
from stiction.studies.study import parse_study

SIDES = ("upper", "lower")


def write(folder, make, kind="", seed=3, **options):
    """Write the heights of two surfaces to files."""
    for side in SIDES:
        np.save(folder / f"{side}{kind}.npy", make(seed, hurst_exponent=0.8, side=side, **options).heights)


def write_maps(folder, shape=(48, 48), rms=0.02):
    write(folder, self_affine_surface, rms=rms, shape=shape, spacing=0.1, shortest_wavelength=0.6)
    return "0.1 um"


def write_profiles(folder, points=1200):
    write(folder, self_affine, rms=0.05, points=points, spacing=0.02, shortest_wavelength=0.2)
    return "0.02 um"


def study_of(
    folder, press="areas", mechanics="half-space", *, spacing, members=6, load="2 mN", more="", contact="", kind=""
):
    """Return a study of the files upper.npy and lower.npy in a directory; `kind` is a suffix of their names."""
    files = "\n".join(
        f'{side} = {{ file = "{folder}/{side}{kind}.npy", unit = "um", spacing = "{spacing}" }}' for side in SIDES
    )
    return parse_study(
        f"""
[surfaces]
kind = "measured"
press = "{press}"
{files}
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
        kind.removeprefix("-") or "test",
    )


OF_RESULTS = {"contact.effective_modulus": "10 GPa", "friction.mu0": [0.3, 0.5]}


def maps_result(folder, cut_off='["0 um"]'):
    """Return the result of two maps at four shifts, four directions and three loads, two of them requested."""
    write(folder, self_affine_surface, "-maps", 4, rms=0.02, shape=(48, 48), spacing=0.1, shortest_wavelength=0.8)
    contact = 'load = ["0.05 mN", "0.1 mN", "0.5 mN"]\ndirection = [0, 90, 180, 270]'
    how = {"spacing": "0.1 um", "members": 4, "load": "0.1 mN", "contact": contact, "kind": "-maps"}
    study = study_of(folder, more=f"cut_off = {cut_off}", **how)
    return run(study.with_changes(OF_RESULTS | {"friction.load": ["0.1 mN", "0.5 mN"]})).dataset


def lines_result(folder):
    """Return the result of two profiles with the asperity model."""
    write(folder, self_affine, "-lines", 4, rms=0.02, points=600, spacing=0.1)
    contact = 'load = ["1 uN", "10 uN", "100 uN"]'
    how = {"spacing": "0.1 um", "members": 12, "load": "10 uN", "contact": contact, "kind": "-lines"}
    return run(study_of(folder, "lines", "asperities", **how).with_changes(OF_RESULTS)).dataset
