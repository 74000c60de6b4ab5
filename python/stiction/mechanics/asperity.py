"""Every point of a profile as an asperity: Hanaor, Gan & Einav (2016), Eqs. 2 and 3."""

from __future__ import annotations

from dataclasses import dataclass, field

import stiction._core
from stiction._checks import Floats, choice, read_only
from stiction._shown import Readable
from stiction.surfaces.profile import Profile, Side


@dataclass(frozen=True, eq=False, repr=False)
class Asperities(Readable):
    """Osculating spheres of a profile, one per point; all arrays are read-only.

    Attributes
    ----------
    slope : (n,) ndarray
        f' of the natural cubic spline, dimensionless.
    curvature : (n,) ndarray, 1/µm
        f'' of the spline; zero at both ends.
    normal : (n, 3) ndarray
        Unit vector (x, y, z) out of the solid, z being height; y is 0.
    radius : (n,) ndarray, µm
        Positive where the solid is convex, infinite where the curvature is zero.
    centre : (n, 3) ndarray, µm
        Sphere centre; not finite where the radius is not.

    Examples
    --------
    >>> from stiction import asperities, random_phases, weierstrass_mandelbrot
    >>> asperities(weierstrass_mandelbrot(random_phases(1), 1.2, points=2000), "lower").normal.shape
    (2000, 3)
    """

    slope: Floats
    curvature: Floats = field(metadata={"unit": "1/µm"})
    normal: Floats
    radius: Floats = field(metadata={"unit": "µm"})
    centre: Floats = field(metadata={"unit": "µm"})


def asperities(profile: Profile, side: Side) -> Asperities:
    """Sphere at every point of a profile.

    Parameters
    ----------
    profile : Profile
    side : {"lower", "upper"}
        Whether the solid lies below the profile (the lower body) or above it.

    Raises
    ------
    ValueError
        If the side is unknown.

    Notes
    -----
    With q = sqrt(1 + f'²), the lower body has n = (-f', 0, 1)/q and R = -q³/f'', the upper one both negated, and the
    centre is x - R n. The end condition f'' = 0 makes radii within about ten points of an end unreliable.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, asperities
    >>> arc = Profile(-((np.arange(21) * 0.1 - 1.0) ** 2) / 4, spacing=0.1)  # of radius 2
    >>> float(asperities(arc, "lower").radius[10].round(2))
    2.0
    """
    choice("side", side, Side)
    arrays = stiction._core.asperities(profile.heights, spacing=profile.spacing, side=side)
    return Asperities(*(read_only(array) for array in arrays))
