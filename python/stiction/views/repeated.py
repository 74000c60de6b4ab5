"""One place scanned twice, as text and JSON."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.surfaces.repeated import Repeated
from stiction.views.digits import percent, with_unit
from stiction.views.style import FULL_WIDTH, STYLE, new_figure
from stiction.views.text import aligned, fitted

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def repeated_text(found: Repeated) -> str:
    """How both scans lie on each other, noise over wavelength, and from which wave on the mean of both is right."""
    rows = [["waves", "in both", "noise of one", "part of the mean square"]]
    for wave, common, noise in np.transpose([found.wavelength, found.common, found.noise]).tolist():
        part = noise**2 / (noise**2 + common**2) if noise or common else 0.0
        waves = f"{with_unit(wave, 'um')} to {with_unit(2 * wave, 'um')}"
        rows.append([waves, with_unit(common, "um"), with_unit(noise, "um"), percent(part)])
    moved = ", ".join(f"{axis} = {with_unit(each, 'um')}" for axis, each in zip("xy", found.shift[::-1], strict=False))
    said = (
        f"The second scan begins at {moved} of the first. Their correlation is {found.correlation:.4g}, the noise of "
        f"one scan {with_unit(found.noise_rms, 'um')}."
    )
    return f"{aligned(rows)}\n\n{fitted(said)}\n{fitted(limit_text(found))}\n"


def limit_text(found: Repeated) -> str:
    """From which wave on the mean of both scans is right."""
    if math.isnan(found.limit):
        return "Noise has more than a tenth of the mean square slope of their mean, whatever waves are taken off."
    if found.limit <= found.wavelength[0]:
        return "Of their mean all waves are to be trusted: noise has less than a tenth of its mean square slope."
    wave = with_unit(found.limit, "um")
    part = "at most a tenth of the mean square slope"
    return f"Of their mean waves from {wave} on are to be trusted: --cutoff '{wave}' leaves noise {part}."


def repeated_record(found: Repeated) -> dict[str, Any]:
    """The same as JSON has it: µm."""
    octaves = {"wavelength_um": found.wavelength, "noise_um": found.noise, "common_um": found.common}
    return {
        "shift_um": list(found.shift), "correlation": found.correlation, "noise_um": found.noise_rms,
        "limit_um": None if math.isnan(found.limit) else found.limit,
        "octaves": {name: each.tolist() for name, each in octaves.items()},
    }  # fmt: skip


def octaves_csv(found: Repeated) -> str:
    """Octaves as a table, below the limit in words."""
    import pandas

    columns = {"wavelength (um)": found.wavelength, "noise (um)": found.noise, "common (um)": found.common}
    table: str = pandas.DataFrame(columns).to_csv(index=False, float_format="%.6g")
    return f"# {limit_text(found)}\n{table}"


def repeated_figure(found: Repeated) -> Figure:
    """Noise and what is common over the wavelength, 85 mm wide."""
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        figure = new_figure(66, width=FULL_WIDTH / 2)
        found.plot(figure.subplots())
    return figure
