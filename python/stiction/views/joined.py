"""One spectrum of several scans, as text and JSON."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from stiction.surfaces.joined import JoinedSpectrum
from stiction.views.digits import with_unit
from stiction.views.text import aligned, fitted


def joined_text(joined: JoinedSpectrum) -> str:
    """What each scan gives to one spectrum, how far it is off the others, and the slope over wavelength."""
    rows = [["scan", "waves taken", "ended by", "beside the others"]]
    for name, (shortest, longest), reason, off, chance in zip(
        joined.names, joined.bands, joined.reasons, joined.disagreement, joined.chance, strict=True
    ):
        beside = "no overlap" if math.isnan(off) else f"{off:.2f} times as much power"
        beside += ", of few waves" if 2 * chance > math.log(MUCH) else ""
        rows.append([name, f"{with_unit(shortest, 'um')} to {with_unit(longest, 'um')}", reason, beside])
    found = joined.roughness()
    slopes = [["waves from", "h'", "h'' (1/µm)"]]
    for wave in found.wavelength[:: max(1, found.wavelength.size // MOST_ROWS)]:
        numbers = (found.gradient_at(wave), found.curvature_at(wave))
        slopes.append([with_unit(float(wave), "um"), *(f"{float(number):.3g}" for number in numbers)])
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


MOST_ROWS = 12  # wavelengths at which slopes are told
MUCH = 2.0  # factor between spectra of one surface, above which it is said


def joined_record(joined: JoinedSpectrum) -> dict[str, Any]:
    """The same as JSON has it: µm."""
    found = joined.roughness()
    scans = [
        {
            "file": name, "shortest_um": band[0], "longest_um": band[1], "ended_by": reason,
            "power_over_others": float(off) if math.isfinite(off) else None,
        }
        for name, band, reason, off in zip(joined.names, joined.bands, joined.reasons, joined.disagreement, strict=True)
    ]  # fmt: skip
    curve = {
        "wavelength_um": found.wavelength, "rms_gradient": found.gradient, "rms_curvature_per_um": found.curvature,
        "density_um4": joined.density, "waves": joined.count,
    }  # fmt: skip
    return {"scans": scans, "spectrum": {name: [float(each) for each in values] for name, values in curve.items()}}
