"""Cutting off the short waves of a profile or a surface by the Gaussian filter of ISO 16610."""

from __future__ import annotations

from stiction._checks import truth
from stiction.surfaces.filters import checked_cutoff, gaussian_mean
from stiction.surfaces.surface import AnyBody, as_body

MAX_CUTOFF_FRACTION = (
    1 / 3
)  # longest wavelength that can be cut off, as a fraction of the shortest side: longer waves are too few


def cut_off(body: AnyBody, wavelength: float, *, periodic: bool = False) -> AnyBody:
    r"""A profile or a surface without its short waves, as a coarser instrument would see it.

    Parameters
    ----------
    body : Profile or Surface
    wavelength : float, µm
        Of which half the amplitude is left: from two points (of the finer spacing) to a third of the shortest side.
    periodic : bool
        Whether the body ends where it begins. If not, a straight line or a plane that it contains stays as it is up to
        its ends.

    Returns
    -------
    Profile or Surface
        On the same grid; the step is added to its history.

    Notes
    -----
    The S-filter of `filtered`. A wave of length λ is left with :math:`\exp[-\ln 2\,(λ_c/λ)^2]` of its amplitude.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, cut_off
    >>> wave = Profile(np.cos(2 * np.pi * np.arange(200) / 20), spacing=0.1)  # of length 2 µm
    >>> round(float(cut_off(wave, 2.0, periodic=True).heights[0]), 6)
    0.5
    """
    truth("periodic", periodic)
    body = as_body("body", body)
    length = checked_cutoff("wavelength", wavelength, body, longest=MAX_CUTOFF_FRACTION)
    step = f"waves shorter than {length:g} µm cut off (Gaussian filter, 50 % at {length:g} µm)"
    return body.changed(gaussian_mean(body, length, periodic=periodic), step)  # type: ignore[return-value]
