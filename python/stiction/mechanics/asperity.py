"""Every point of a profile as an asperity: Hanaor, Gan & Einav (2016), Eqs. 2 and 3."""

from __future__ import annotations

from dataclasses import dataclass

import stiction._core
from stiction._checks import Floats, choice, read_only
from stiction.surfaces.fractal import Side
from stiction.surfaces.profile import Profile


@dataclass(frozen=True, eq=False)
class Asperities:
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
    """

    slope: Floats
    curvature: Floats
    normal: Floats
    radius: Floats
    centre: Floats


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
    """
    choice("side", side, Side)
    arrays = stiction._core.asperities(profile.heights, spacing=profile.spacing, side=side)
    return Asperities(*(read_only(array) for array in arrays))
