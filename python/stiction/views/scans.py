"""Several scans of one surface as one spectrum, and one place that was scanned twice: text, JSON, CSV and figures."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._drawing import set_log_ticks
from stiction._number_format import percent, with_unit
from stiction.mechanics.closed_forms import effective_modulus
from stiction.mechanics.materials import material
from stiction.mechanics.resolution import KAPPA
from stiction.studies.input_caveats import MUCH, spectra_differ
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.repeated_scans import RepeatedScans
from stiction.views.spreadsheet import csv_of_frame
from stiction.views.style import ALL, AREA, FULL_WIDTH, LEANING, OPPOSING, STYLE, new_figure
from stiction.views.text import aligned, fitted

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_ROWS = 12  # wavelengths at which slopes are told

MATERIALS = ("PMMA", "bearing steel", "titanium alloy", "brass", "aluminium")
"""Materials whose hardness over E*, pressed on themselves, is a line."""

SCANS = (LEANING, AREA, OPPOSING, "#cc79a7", "#56b4e9", "#e69f00")  # colours of the scans, one after the other
LONGEST_NAME = 24  # characters of the name of a scan in a figure


# ---- One spectrum ----------------------------------------------------------------------------------------------------


def joined_text(joined: JoinedSpectrum) -> str:
    """What each scan gives to one spectrum, how far it is off the others, and the slope over wavelength."""
    rows = [["scan", "wavelengths used", "limited by", "compared with the others"]]
    for name, (shortest, longest), reason, off, chance in zip(
        joined.names, joined.bands, joined.reasons, joined.disagreement, joined.chance, strict=True
    ):
        beside = "no overlap" if math.isnan(off) else f"{off:.2f} times as much power"
        beside += ", from few wavelengths" if 2 * chance > math.log(MUCH) else ""
        rows.append([name, f"{with_unit(shortest, 'um')} to {with_unit(longest, 'um')}", reason, beside])
    found = joined.roughness()
    slopes = [["wavelengths above", "h'", "h'' (1/µm)"]]
    for wave in found.wavelength[:: max(1, found.wavelength.size // MOST_ROWS)]:
        numbers = (found.gradient_at(wave), found.curvature_at(wave))
        slopes.append([with_unit(float(wave), "um"), *(f"{float(number):.3g}" for number in numbers)])
    said = ""
    if (joined.count == 0).any():
        said = "Some wavelengths between the scans are in none of them; a power law fills the gap.\n"
    if spectra_differ(joined):
        said += (
            "Scans differ by more than a factor of two in power: a scale of heights is wrong, or wavelengths are "
            "missing.\n"
        )
    return "\n\n".join([aligned(rows), aligned(slopes)]) + "\n" + (fitted(said) + "\n" if said else "")


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


def joined_figure(joined: JoinedSpectrum) -> Figure:
    """Spectra over wavelength, slope and curvature down to it, and the mean pressure in contact; 170 mm wide.

    The surface is pressed on one like it. The elastic pressure over E* is h'/κ of the gap, by `spectral_resolution`;
    where it reaches the hardness of a material over E*, the material yields, and finer waves no longer matter.
    """
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        figure = new_figure(66, width=FULL_WIDTH)
        spectra, slopes, pressure = figure.subplots(1, 3)
        _spectra_panel(spectra, joined)
        found = joined.roughness()
        slopes.plot(found.wavelength, found.gradient, color=ALL, linewidth=1, label="slope $h'$")
        words = "curvature $h''$ (1/µm)"
        slopes.plot(found.wavelength, found.curvature, "--", color=OPPOSING, linewidth=1, label=words)
        slopes.set_title("of all waves down to this", pad=2)
        slopes.legend(loc="upper left")
        _pressure_panel(pressure, joined)
        for axes in (spectra, slopes, pressure):
            axes.set(xscale="log", yscale="log", xlabel="wavelength (µm)")
            axes.set_xlim(1.15 * joined.longest, joined.shortest / 1.15)
            set_log_ticks(axes)
    return figure


def _spectra_panel(axes: Axes, joined: JoinedSpectrum) -> None:
    lengths = 2 * math.pi / joined.wave_number
    for scan, (name, ratio) in enumerate(zip(joined.names, joined.ratio, strict=True)):
        short = name if len(name) <= LONGEST_NAME else f"…{name[1 - LONGEST_NAME :]}"
        axes.plot(lengths, ratio * joined.density, "o", color=SCANS[scan % len(SCANS)], markersize=2.5, label=short)
    axes.plot(lengths, joined.density, color="black", linewidth=0.8, label="together")
    gap = joined.count == 0
    if gap.any():
        axes.plot(lengths[gap], joined.density[gap], "x", color="black", markersize=3, label="no scan")
    axes.set_ylabel("$C^{2D}$ (µm$^4$)")
    axes.set_title("spectrum", pad=2)
    axes.legend(loc="lower left", handlelength=1.2)


def _pressure_panel(axes: Axes, joined: JoinedSpectrum) -> None:
    found = joined.roughness()
    elastic = math.sqrt(2) * found.gradient / KAPPA
    axes.plot(found.wavelength, elastic, color="black", linewidth=1)
    for index, name in enumerate(MATERIALS):
        body = material(name)
        young, ratio = float(body.young_modulus), float(body.poisson_ratio)
        limit = float(body.hardness or 0.0) / float(effective_modulus(young, ratio, young, ratio))
        if not elastic[0] < limit < elastic[-1]:
            continue
        start = np.exp(np.interp(math.log(limit), np.log(elastic), np.log(found.wavelength)))
        colour = SCANS[index % len(SCANS)]
        axes.plot([start, joined.shortest], [limit, limit], color=colour, linewidth=0.8)
        axes.annotate(
            f"{name} yields", (joined.shortest, limit), (0, -1), textcoords="offset points", ha="right", va="top",
            fontsize=6, color=colour,
        )  # fmt: skip
    axes.set_ylabel("mean pressure $p_c/E^*$, on its like")
    axes.set_title("$A/A_0 = p/p_c$, $\\mu_s = \\mu_0 + \\tau_0/p_c$", pad=2)


# ---- One place -------------------------------------------------------------------------------------------------------


def repeated_text(found: RepeatedScans) -> str:
    """How both scans lie on each other, noise over wavelength, and from which wave on the mean of both is right."""
    rows = [["wavelengths", "in both", "noise of one scan", "noise fraction of the mean square"]]
    for wave, common, noise in np.transpose([found.wavelength, found.common, found.noise]).tolist():
        part = noise**2 / (noise**2 + common**2) if noise or common else 0.0
        waves = f"{with_unit(wave, 'um')} to {with_unit(2 * wave, 'um')}"
        rows.append([waves, with_unit(common, "um"), with_unit(noise, "um"), percent(part)])
    moved = ", ".join(f"{axis} = {with_unit(each, 'um')}" for axis, each in zip("xy", found.shift[::-1], strict=False))
    said = (
        f"The second scan starts at {moved} of the first one. The correlation is {found.correlation:.4g}, the noise of "
        f"a single scan {with_unit(found.noise_rms, 'um')}."
    )
    return f"{aligned(rows)}\n\n{fitted(said)}\n{fitted(limit_text(found))}\n"


def limit_text(found: RepeatedScans) -> str:
    """From which wave on the mean of both scans is right."""
    if math.isnan(found.limit):
        return "At any cutoff, more than a tenth of the mean square slope of the mean scan is noise."
    if found.limit <= found.wavelength[0]:
        return "All wavelengths of the mean scan can be used: less than a tenth of its mean square slope is noise."
    wave = with_unit(found.limit, "um")
    part = "at most a tenth of the mean square slope"
    return f"Wavelengths of the mean scan above {wave} can be used: --cutoff '{wave}' leaves noise {part}."


def repeated_record(found: RepeatedScans) -> dict[str, Any]:
    """The same as JSON has it: µm."""
    octaves = {"wavelength_um": found.wavelength, "noise_um": found.noise, "common_um": found.common}
    return {
        "shift_um": list(found.shift), "correlation": found.correlation, "noise_um": found.noise_rms,
        "limit_um": None if math.isnan(found.limit) else found.limit,
        "octaves": {name: each.tolist() for name, each in octaves.items()},
    }  # fmt: skip


def octaves_csv(found: RepeatedScans) -> str:
    """Octaves as a table, below the limit in words."""
    import pandas

    columns = {"wavelength (um)": found.wavelength, "noise (um)": found.noise, "common (um)": found.common}
    return f"# {limit_text(found)}\n{csv_of_frame(pandas.DataFrame(columns), float_format='%.6g')}"


def repeated_figure(found: RepeatedScans) -> Figure:
    """Noise and what is common over the wavelength, 85 mm wide."""
    import matplotlib as mpl

    with mpl.rc_context(STYLE):
        figure = new_figure(66, width=FULL_WIDTH / 2)
        found.plot(figure.subplots())
    return figure
