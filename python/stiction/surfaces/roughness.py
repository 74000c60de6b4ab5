"""Parameters of a profile's heights and slopes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from stiction._checks import choice
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

Derivative = Literal["seven-point", "neighbours"]


@dataclass(frozen=True)
class RoughnessParameters:
    """Parameters of a primary profile by the names of ISO 21920-2, about its mean.

    Attributes
    ----------
    Pa : float, µm
        Arithmetic mean height: the mean of the absolute heights.
    Pq : float, µm
        Root-mean-square height.
    Pt : float, µm
        Total height: highest minus lowest point.
    Psk : float
        Skewness: below 0 if the valleys are deeper than the peaks are high.
    Pku : float
        Kurtosis, 3 for normally distributed heights.
    Pdq : float
        Root-mean-square slope, by the derivative that was asked for.
    """

    Pa: float
    Pq: float
    Pt: float
    Psk: float
    Pku: float
    Pdq: float


def roughness_parameters(profile: Profile, *, derivative: Derivative = "seven-point") -> RoughnessParameters:
    """Roughness parameters of a profile as it is, about its mean: levelling and filtering are the caller's.

    Parameters
    ----------
    profile : Profile
        Not flat, and of at least 7 points.
    derivative : {"seven-point", "neighbours"}
        How Pdq takes slopes. "seven-point" is that of ISO 4287 and of instruments, at all points that have three
        neighbours on each side; it smooths, and sees nothing of wavelengths near twice the spacing. "neighbours" is
        the difference of two neighbours over the spacing, which most codes for contact take.

    Raises
    ------
    ValueError
        If the profile is flat or has fewer than 7 points, or the derivative is unknown.

    Notes
    -----
    Seven points: :math:`z'_i = (z_{i+3} - 9z_{i+2} + 45z_{i+1} - 45z_{i-1} + 9z_{i-2} - z_{i-3}) / 60Δx`. On a
    sinusoid of wavelength λ it is short by a factor 1 - (2πΔx/λ)^6/140, the difference of neighbours by
    1 - (2πΔx/λ)²/24. The slope of a self-affine profile depends on where its spectrum ends, and so on the derivative.

    Examples
    --------
    >>> from stiction import Profile, roughness_parameters
    >>> roughness_parameters(Profile([0.0, 1.0, 0.0, -1.0, 0.0, 1.0, 0.0, -1.0], spacing=2.0)).Pa
    0.5
    """
    choice("derivative", derivative, Derivative)
    refuse_flat(profile)
    z = profile.heights
    if z.size < SEVEN_POINTS.size:
        raise ValueError(f"profile must have at least {SEVEN_POINTS.size} points, got {z.size}")
    deviation = z - z.mean()
    scale = float(np.abs(deviation).max())
    deviation /= scale  # so that the fourth power neither over- nor underflows
    rms = float(np.sqrt(np.mean(deviation**2)))
    if derivative == "seven-point":
        differences = np.correlate(deviation, SEVEN_POINTS, mode="valid") / 60
    else:
        differences = np.diff(deviation)
    return RoughnessParameters(
        Pa=scale * float(np.mean(np.abs(deviation))),
        Pq=scale * rms,
        Pt=float(np.ptp(z)),
        Psk=float(np.mean((deviation / rms) ** 3)),
        Pku=float(np.mean((deviation / rms) ** 4)),
        Pdq=scale * float(np.sqrt(np.mean(differences**2))) / profile.spacing,
    )


SEVEN_POINTS = np.array([-1.0, 9.0, -45.0, 0.0, 45.0, -9.0, 1.0])


def refuse_flat(body: Profile | Surface) -> None:
    """Refuse a body whose heights are all equal, or so small or large that their products leave the range."""
    name, height = type(body).__name__.lower(), float(np.ptp(body.heights))
    if height == 0:
        raise ValueError(f"a flat {name} has no roughness")
    if not _LEAST_HEIGHT < height < 1 / _LEAST_HEIGHT:
        raise ValueError(
            f"the height of the {name} must be above {_LEAST_HEIGHT:g} and below {1 / _LEAST_HEIGHT:g} µm, "
            f"got {height:g}"
        )


_LEAST_HEIGHT = 1e-50
"""µm. Products of moments go as the fourth power of heights, which must stay in range."""
