"""Results of two small measured bodies, computed in a second: maps as areas, and profiles as lines."""

import numpy as np
from stiction import run, self_affine, self_affine_surface
from stiction.studies.study import study_from_text

COMMON = """
[contact]
mechanics = "{mechanics}"
effective_modulus = "10 GPa"
load = [{loads}]
{direction}
[friction]
mu0 = [0.3, 0.5]
tau0 = ["0 MPa", "50 MPa"]
load = [{asked}]
[ensemble]
repetitions = {members}
"""


def bodies(folder, kind, press, more=""):
    """The table [surfaces] of two files in a folder."""
    lines = [f'{side} = {{ file = "{folder}/{side}-{kind}.npy", unit = "um", spacing = "0.1 um" }}' for side in SIDES]
    return "\n".join(["[surfaces]", 'kind = "measured"', f'press = "{press}"', *lines, more])


SIDES = ("upper", "lower")


def maps_result(folder, mechanics="half-space", cut_off='["0 um"]'):
    """Areas of two maps at four shifts, in four directions, at three loads of which two are asked for."""
    for side in SIDES:
        made = self_affine_surface(
            4, hurst_exponent=0.8, rms=0.02, shape=(48, 48), spacing=0.1, shortest_wavelength=0.8, side=side
        )
        np.save(folder / f"{side}-map.npy", made.heights)
    text = bodies(folder, "map", "areas", f"cut_off = {cut_off}") + COMMON.format(
        mechanics=mechanics, loads='"0.05 mN", "0.1 mN", "0.5 mN"', direction="direction = [0, 90, 180, 270]",
        asked='"0.1 mN", "0.5 mN"', members=4,
    )  # fmt: skip
    return run(study_from_text(text, "maps"))


def lines_result(folder, members=12):
    """Positions of one profile on another, by asperities."""
    for side in SIDES:
        made = self_affine(4, hurst_exponent=0.8, rms=0.02, points=600, spacing=0.1, side=side)
        np.save(folder / f"{side}-line.npy", made.heights)
    text = bodies(folder, "line", "lines") + COMMON.format(
        mechanics="asperities", loads='"1 uN", "10 uN", "100 uN"', direction="", asked='"10 uN"', members=members
    )
    return run(study_from_text(text, "lines"))
