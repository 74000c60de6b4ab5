"""Small studies of two height files, and their results."""

import numpy as np
from stiction import run, self_affine, self_affine_surface
from stiction.study.pair_options import validate_option_values
from stiction.study.pair_study import build_study_from_options
from stiction.study.study import parse_study

SIDES = ("upper", "lower")


def pair_study(upper, lower, **options):
    """Return the study of two bodies. Options have the names of the fields of `PairOptions`."""
    return build_study_from_options(validate_option_values({"upper": upper, "lower": lower, **options}))


def write_heights(directory, generate_surface, suffix="", seed=3, **options):
    """Generate two surfaces, and write their heights to upper.npy and lower.npy.

    `suffix` is inserted before the dot.
    """
    for side in SIDES:
        np.save(
            directory / f"{side}{suffix}.npy", generate_surface(seed, hurst_exponent=0.8, side=side, **options).heights
        )


def write_maps(directory, shape=(48, 48), rms=0.02):
    """Write two rough maps, and return their grid spacing."""
    write_heights(directory, self_affine_surface, rms=rms, shape=shape, spacing=0.1, shortest_wavelength=0.6)
    return "0.1 um"


def write_profiles(directory, points=1200):
    """Write two rough profiles, and return their grid spacing."""
    write_heights(directory, self_affine, rms=0.05, points=points, spacing=0.02, shortest_wavelength=0.2)
    return "0.02 um"


def create_study_from_files(
    directory, press="areas", mechanics="half-space", *, spacing, members=6, load="2 mN", more="", contact="", kind=""
):
    """Return a study of the files upper.npy and lower.npy in a directory. `kind` is a suffix of the file names."""
    files = "\n".join(
        f'{side} = {{ file = "{directory}/{side}{kind}.npy", unit = "um", spacing = "{spacing}" }}' for side in SIDES
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


RESULT_STUDY_CHANGES = {"contact.effective_modulus": "10 GPa", "friction.mu0": [0.3, 0.5]}


def run_pair_of_maps(directory, cut_off='["0 um"]'):
    """Return the result of two maps at four shifts, in four directions, and at three loads, two of them requested."""
    write_heights(
        directory, self_affine_surface, "-maps", 4, rms=0.02, shape=(48, 48), spacing=0.1, shortest_wavelength=0.8
    )
    contact = 'load = ["0.05 mN", "0.1 mN", "0.5 mN"]\ndirection = [0, 90, 180, 270]'
    options = {"spacing": "0.1 um", "members": 4, "load": "0.1 mN", "contact": contact, "kind": "-maps"}
    study = create_study_from_files(directory, more=f"cut_off = {cut_off}", **options)
    return run(study.with_changes(RESULT_STUDY_CHANGES | {"friction.load": ["0.1 mN", "0.5 mN"]})).dataset


def run_pair_of_profiles(directory):
    """Return the result of two profiles with the asperity model."""
    write_heights(directory, self_affine, "-lines", 4, rms=0.02, points=600, spacing=0.1)
    contact = 'load = ["1 uN", "10 uN", "100 uN"]'
    options = {"spacing": "0.1 um", "members": 12, "load": "10 uN", "contact": contact, "kind": "-lines"}
    return run(
        create_study_from_files(directory, "lines", "asperities", **options).with_changes(RESULT_STUDY_CHANGES)
    ).dataset
