"""Low-pass filter for profiles and height maps: the Gaussian filter of ISO 16610."""

from __future__ import annotations

from stiction._checks import check_bool
from stiction.surfaces.filters import gaussian_low_pass, validate_cutoff
from stiction.surfaces.surface import AnyBody, as_body

# Largest cutoff as a fraction of the shortest side: a longer cutoff leaves fewer than three wavelengths on this side.
MAX_CUTOFF_FRACTION = 1 / 3


def cut_off(body: AnyBody, wavelength: float, *, periodic: bool = False) -> AnyBody:
    r"""Apply a low-pass filter to a profile or a height map to simulate an instrument of lower resolution.

    Parameters
    ----------
    body : Profile or Surface
        Body to filter.
    wavelength : float, µm
        Cutoff wavelength, at which half of the amplitude is transmitted. It must be from half of the finer spacing to a
        third of the shortest side.
    periodic : bool
        True if the body is periodic. Otherwise a tilt is preserved up to the ends.

    Returns
    -------
    smooth : Profile or Surface
        The filtered body on the same grid, with the step added to its history.

    Raises
    ------
    ValueError
        If the wavelength is outside its range.

    See Also
    --------
    filtered : L-filters and robust filters.
    instrument_limit : Shortest wavelength of a scan that can be trusted.

    Notes
    -----
    This is the S-filter of `filtered` (ISO 16610-21 and ISO 16610-61). At wavelength λ it transmits the fraction
    :math:`\exp[-\ln 2\,(λ_c/λ)^2]` of the amplitude.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, cut_off
    >>> wave = Profile(np.cos(2 * np.pi * np.arange(200) / 20), spacing=0.1)  # wavelength 2 µm
    >>> round(float(cut_off(wave, 2.0, periodic=True).heights[0]), 6)
    0.5
    """
    check_bool("periodic", periodic)
    body = as_body("body", body)
    cutoff_length = validate_cutoff("wavelength", wavelength, body, longest=MAX_CUTOFF_FRACTION)
    history_entry = f"low-pass filtered at {cutoff_length:g} µm (cutoff wavelength of a Gaussian filter)"
    return body.changed(gaussian_low_pass(body, cutoff_length, periodic=periodic), history_entry)  # type: ignore[return-value]
