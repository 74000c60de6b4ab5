"""Which waves of a scan were seen and may be trusted, and one spectrum of several scans: rows, text and CSV."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import instrument_limit, scale_dependent_roughness
from stiction.surfaces.surface import Surface
from stiction.views.digits import finite, percent, with_unit

if TYPE_CHECKING:
    from stiction.surfaces.joined import JoinedSpectrum

OCTAVES = 4
"""Cut-offs at which the slope is told: two points and their doubles."""


def scale_rows(
    body: Profile | Surface, *, tip_radius: float | None = None, periodic: bool = False
) -> list[tuple[str, str]]:
    """Slope over the shortest wave that is counted, and from which wave on the scan may be trusted, in words.

    The body is not flat, and `periodic` as in `power_spectrum`; the tip is that of the stylus or the probe, µm.
    """
    found = scale_dependent_roughness(body, periodic=periodic)
    limit = instrument_limit(body, tip_radius=tip_radius, periodic=periodic)
    pixels = limit.pixels
    below = percent(float(found.fraction_below(2 * pixels)))
    slopes = ", ".join(
        f"{float(found.gradient_at(wave)):.3g} from {with_unit(float(wave), 'um')}"
        for wave in pixels * 2.0 ** np.arange(OCTAVES)
        if wave < found.wavelength[0]
    )
    rows = [
        ("waves", f"{with_unit(pixels, 'um')} (two points) to {with_unit(float(found.wavelength[0]), 'um')}"),
        ("", f"those below {with_unit(2 * pixels, 'um')} make {below} of the mean square slope"),
        ("slope of waves", slopes),
    ]
    reached = _REASONS[limit.reason]
    if limit.reason == "pixels":
        rows.append(("instrument", f"no noise floor{'' if tip_radius is None else ', and its tip follows all'}"))
    else:
        wave = with_unit(limit.wavelength, "um")
        rows.append(("instrument", f"not to be trusted below {wave}: {reached}; --cutoff '{wave}' takes that off"))
    return rows


_REASONS = {
    "pixels": "two points",
    "noise floor": "the spectrum ends flat, like noise",
    "tip": "sharper than the tip follows",
}


def scale_values(body: Profile | Surface, *, tip_radius: float | None = None) -> dict[str, tuple[float, str]]:
    """The same as numbers with units."""
    found = scale_dependent_roughness(body)
    limit = instrument_limit(body, tip_radius=tip_radius)
    return {
        "shortest_wave": (limit.pixels, "um"),
        "slope_in_shortest_octave": (float(found.fraction_below(2 * limit.pixels)), "1"),
        "noise_floor_below": (limit.noise, "um"),
        "tip_follows_down_to": (limit.tip, "um"),
    }


# ---- Together --------------------------------------------------------------------------------------------------------


def joined_text(joined: JoinedSpectrum) -> str:
    """What each scan gives to one spectrum, how far it is off the others, and the slope over wavelength."""
    from stiction.views.text import aligned, fitted

    rows = [["scan", "waves taken", "ended by", "beside the others"]]
    for name, (shortest, longest), reason, off, chance in zip(
        joined.names, joined.bands, joined.reasons, joined.disagreement, joined.chance, strict=True
    ):
        beside = "no overlap" if math.isnan(off) else f"{off:.2f} times as much power"
        beside += ", of few waves" if 2 * chance > math.log(MUCH) else ""
        rows.append([name, f"{with_unit(shortest, 'um')} to {with_unit(longest, 'um')}", reason, beside])
    found = joined.roughness()
    slopes = [["waves from", "h'", "h'' (1/µm)"]]
    waves = found.wavelength[:: max(1, found.wavelength.size // MOST_ROWS)]
    slopes += [
        [
            with_unit(float(wave), "um"),
            f"{float(found.gradient_at(wave)):.3g}",
            f"{float(found.curvature_at(wave)):.3g}",
        ]
        for wave in waves
    ]
    said = ""
    if (joined.count == 0).any():
        said = "Between some scans there are waves that none has; a power law joins them.\n"
    if spectra_differ(joined):
        said += "Scans differ by more than a factor of two in power: heights are scaled otherwise, or waves are cut.\n"
    return "\n\n".join([aligned(rows), aligned(slopes)]) + "\n" + (fitted(said) + "\n" if said else "")


def spectra_differ(joined: JoinedSpectrum) -> bool:
    """Whether a scan is off the others by more than a factor of two in power, whatever chance does."""
    with np.errstate(invalid="ignore"):
        return bool((np.abs(np.log(joined.disagreement)) - 2 * joined.chance > math.log(MUCH)).any())


MOST_ROWS = 12
"""Wavelengths at which slopes are told."""

MUCH = 2.0
"""Factor between spectra of one surface, above which it is said."""


def joined_record(joined: JoinedSpectrum) -> dict[str, Any]:
    """The same as JSON has it: µm."""
    found = joined.roughness()
    scans = [
        {
            "file": name, "shortest_um": band[0], "longest_um": band[1], "ended_by": reason,
            "power_over_others": finite(float(off)),
        }
        for name, band, reason, off in zip(joined.names, joined.bands, joined.reasons, joined.disagreement, strict=True)
    ]  # fmt: skip
    curve = {
        "wavelength_um": found.wavelength, "rms_gradient": found.gradient, "rms_curvature_per_um": found.curvature,
        "density_um4": joined.density, "waves": joined.count,
    }  # fmt: skip
    return {"scans": scans, "spectrum": {name: [float(each) for each in values] for name, values in curve.items()}}
