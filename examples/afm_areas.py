"""Two AFM maps pressed as areas, around the compass: python afm_areas.py [UPPER LOWER], instrument files."""

import sys
from pathlib import Path

from stiction import levelled, pressed_maps, read_surface, self_affine_surface, turned_over
from stiction.studies.map_pair import Pieces, joined, means_of_all, overlap_area, with_picture
from stiction.views.map_pair import map_pair_text, save_map_pair_figures


def stand_in(side):
    """What an instrument might give of a lapped face."""
    return self_affine_surface(
        5, hurst_exponent=0.8, rms=0.01, shape=(128, 128), spacing=0.02, longest_wavelength=0.6,
        shortest_wavelength=0.1, side=side,
    )  # fmt: skip


given = len(sys.argv) == 3
upper, lower = map(read_surface, sys.argv[1:]) if given else map(stand_in, ("upper", "lower"))
upper, lower = turned_over(levelled(upper, "plane")), levelled(lower, "plane")
load = 0.01 * overlap_area(upper, lower)  # 10 MPa
choice = {"shifts": 16 if given else 8, "surrogates": 16 if given else 4}
pressed = pressed_maps(upper, lower, [load / 3, load, 3 * load], mu0=0.3, tau0=0.05, **choice)
result = joined([pressed], ["half-space"], load)
result.attrs["files"] = " on ".join(Path(name).name for name in sys.argv[1:]) if given else "lapped on lapped"
result = with_picture(result, Pieces.of(upper, lower, **choice), 0, load)
mean = means_of_all(result)  # over shifts of these maps and, beside it, over surfaces with their spectra
print(map_pair_text(result, mean, [load]))
save_map_pair_figures(result, mean, [load], Path())
