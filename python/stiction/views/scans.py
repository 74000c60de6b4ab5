"""Text, JSON and figure of the joined spectrum of several scans, and of the noise of two repeated scans."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._drawing import set_log_tick_labels
from stiction._number_format import format_percent, format_with_unit
from stiction.mechanics.closed_forms import effective_modulus
from stiction.mechanics.materials import material
from stiction.mechanics.resolution import KAPPA_AT_SMALL_LOADS
from stiction.summary.assessment import Caveat
from stiction.summary.input_caveats import MAX_DENSITY_RATIO_OF_JOINED_SPECTRA, have_different_spectra
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.repeated_scans import RepeatedScans
from stiction.surfaces.scale import MAX_NEGLIGIBLE_NOISE_FRACTION
from stiction.views.json_record import caveat_record
from stiction.views.layout import format_table, wrap_text
from stiction.views.spreadsheet import frame_to_csv
from stiction.views.style import (
    ALL_CONTACTS_COLOUR,
    AREA_COLOUR,
    MATPLOTLIB_STYLE,
    NOT_OPPOSING_CONTACT_COLOUR,
    OPPOSING_CONTACT_COLOUR,
    PAGE_WIDTH,
    literal_text,
    new_figure,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MAX_SLOPE_ROWS = 12

COMPARED_MATERIALS = ("PMMA", "bearing steel", "titanium alloy", "brass", "aluminium")
"""Materials for which the figure draws a line at hardness / E*, where both bodies are made of the material."""

SCAN_COLOURS = (NOT_OPPOSING_CONTACT_COLOUR, AREA_COLOUR, OPPOSING_CONTACT_COLOUR, "#cc79a7", "#56b4e9", "#e69f00")
MAX_LABEL_LENGTH = 24  # characters


# ---- Joined spectrum -------------------------------------------------------------------------------------------------


def joined_spectrum_text(joined: JoinedSpectrum, caveats: Sequence[Caveat] = ()) -> str:
    """Return a joined spectrum as text: a table of the scans, a table of slopes and curvatures, and caveats."""
    rows = [["scan", "wavelengths used", "limited by", "compared with the others"]]
    for name, (shortest, longest), reason, power_ratio, expected_deviation in zip(
        joined.names, joined.bands, joined.reasons, joined.disagreement, joined.chance, strict=True
    ):
        deviation = "no overlap" if math.isnan(power_ratio) else f"{power_ratio:.2f} times as much power"
        deviation += (
            ", from few wavelengths" if 2 * expected_deviation > math.log(MAX_DENSITY_RATIO_OF_JOINED_SPECTRA) else ""
        )
        rows.append(
            [name, f"{format_with_unit(shortest, 'um')} to {format_with_unit(longest, 'um')}", reason, deviation]
        )
    roughness = joined.roughness()
    slope_table = [["wavelengths above", "h'", "h'' (1/µm)"]]
    for wavelength in roughness.wavelength[:: max(1, roughness.wavelength.size // MAX_SLOPE_ROWS)]:
        slope_and_curvature = (roughness.gradient_at(wavelength), roughness.curvature_at(wavelength))
        slope_table.append(
            [format_with_unit(float(wavelength), "um"), *(f"{float(number):.3g}" for number in slope_and_curvature)]
        )
    text = ""
    if (joined.count == 0).any():
        text = "Some wavelengths between the scans are in no scan; a power law fills the gap.\n"
    if have_different_spectra(joined):
        text += (
            "The scans differ by more than a factor of two in power: a height calibration is wrong, or wavelengths are "
            "missing.\n"
        )
    notes = (wrap_text(text) + "\n" if text else "") + _caveat_lines(caveats)
    return "\n\n".join([format_table(rows), format_table(slope_table)]) + "\n" + notes


def _caveat_lines(caveats: Sequence[Caveat]) -> str:
    return "".join(f"{wrap_text(f'{caveat.text}; {caveat.remedy}')}\n" for caveat in caveats)


def joined_spectrum_record(joined: JoinedSpectrum, caveats: Sequence[Caveat] = ()) -> dict[str, Any]:
    """Return a joined spectrum and its caveats as fields of a JSON record, with lengths in µm."""
    roughness = joined.roughness()
    scans = [
        {
            "file": name,
            "shortest_um": band[0],
            "longest_um": band[1],
            "limited_by": reason,
            "power_over_others": float(power_ratio) if math.isfinite(power_ratio) else None,
        }
        for name, band, reason, power_ratio in zip(
            joined.names, joined.bands, joined.reasons, joined.disagreement, strict=True
        )
    ]
    curve = {
        "wavelength_um": roughness.wavelength,
        "rms_gradient": roughness.gradient,
        "rms_curvature_per_um": roughness.curvature,
        "density_um4": joined.density,
        "wavelength_count": joined.count,
    }
    spectrum = {name: [float(item) for item in values] for name, values in curve.items()}
    return {"scans": scans, "spectrum": spectrum, "caveats": list(map(caveat_record, caveats))}


def joined_spectrum_figure(joined: JoinedSpectrum) -> Figure:
    """Draw a figure 170 mm wide: joined spectrum, cumulative slope and curvature, and contact pressure.

    The pressure is computed for contact with a second surface of the same kind. The elastic pressure divided by E* is
    h'/κ of the gap, as in `spectral_resolution`. A material yields where this ratio reaches its hardness divided by E*;
    shorter wavelengths then have no effect.
    """
    import matplotlib as mpl

    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = new_figure(66, width=PAGE_WIDTH)
        spectra_axes, slopes_axes, pressure_axes = figure.subplots(1, 3)
        _draw_spectra_panel(spectra_axes, joined)
        roughness = joined.roughness()
        slopes_axes.plot(
            roughness.wavelength, roughness.gradient, color=ALL_CONTACTS_COLOUR, linewidth=1, label="slope $h'$"
        )
        axis_text = "curvature $h''$ (1/µm)"
        slopes_axes.plot(
            roughness.wavelength, roughness.curvature, "--", color=OPPOSING_CONTACT_COLOUR, linewidth=1, label=axis_text
        )
        slopes_axes.set_title("cumulative, down to this wavelength", pad=2)
        slopes_axes.legend(loc="upper left")
        _draw_pressure_panel(pressure_axes, joined)
        for axes in (spectra_axes, slopes_axes, pressure_axes):
            axes.set(xscale="log", yscale="log", xlabel="wavelength (µm)")
            axes.set_xlim(1.15 * joined.longest, joined.shortest / 1.15)
            set_log_tick_labels(axes)
    return figure


def _draw_spectra_panel(axes: Axes, joined: JoinedSpectrum) -> None:
    wavelengths = 2 * math.pi / joined.wave_number
    for scan_index, (name, power_ratio) in enumerate(zip(joined.names, joined.ratio, strict=True)):
        label = name if len(name) <= MAX_LABEL_LENGTH else f"…{name[1 - MAX_LABEL_LENGTH :]}"
        axes.plot(
            wavelengths,
            power_ratio * joined.density,
            "o",
            color=SCAN_COLOURS[scan_index % len(SCAN_COLOURS)],
            markersize=2.5,
            label=literal_text(label),
        )
    axes.plot(wavelengths, joined.density, color="black", linewidth=0.8, label="joined")
    is_gap = joined.count == 0
    if is_gap.any():
        axes.plot(wavelengths[is_gap], joined.density[is_gap], "x", color="black", markersize=3, label="no scan")
    axes.set_ylabel("$C^{2D}$ (µm$^4$)")
    axes.set_title("spectrum", pad=2)
    axes.legend(loc="lower left", handlelength=1.2)


def _draw_pressure_panel(axes: Axes, joined: JoinedSpectrum) -> None:
    roughness = joined.roughness()
    elastic_pressure = math.sqrt(2) * roughness.gradient / KAPPA_AT_SMALL_LOADS
    axes.plot(roughness.wavelength, elastic_pressure, color="black", linewidth=1)
    for index, name in enumerate(COMPARED_MATERIALS):
        body_material = material(name)
        young_modulus, poisson_ratio = float(body_material.young_modulus), float(body_material.poisson_ratio)
        relative_hardness = float(body_material.hardness or 0.0) / float(
            effective_modulus(young_modulus, poisson_ratio, young_modulus, poisson_ratio)
        )
        if not elastic_pressure[0] < relative_hardness < elastic_pressure[-1]:
            continue
        limit_wavelength = np.exp(
            np.interp(math.log(relative_hardness), np.log(elastic_pressure), np.log(roughness.wavelength))
        )
        colour = SCAN_COLOURS[index % len(SCAN_COLOURS)]
        axes.plot(
            [limit_wavelength, joined.shortest], [relative_hardness, relative_hardness], color=colour, linewidth=0.8
        )
        axes.annotate(
            f"{name} yields",
            (joined.shortest, relative_hardness),
            (0, -1),
            textcoords="offset points",
            ha="right",
            va="top",
            fontsize=6,
            color=colour,
        )
    axes.set_ylabel("mean pressure $p_c/E^*$, same material")
    axes.set_title("$A/A_0 = p/p_c$, $\\mu_s = \\mu_0 + \\tau_0/p_c$", pad=2)


# ---- Repeated scans of one place -------------------------------------------------------------------------------------


def repeated_scans_text(comparison: RepeatedScans, caveats: Sequence[Caveat] = ()) -> str:
    """Return the comparison of two scans as text: noise in each octave, shift, cutoff to limit noise, and caveats."""
    rows = [["wavelengths", "in both", "noise of one scan", "noise fraction of the mean square"]]
    for wavelength, common_height, noise_height in np.transpose(
        [comparison.wavelength, comparison.common, comparison.noise]
    ).tolist():
        fraction = noise_height**2 / (noise_height**2 + common_height**2) if noise_height or common_height else 0.0
        octave_text = f"{format_with_unit(wavelength, 'um')} to {format_with_unit(2 * wavelength, 'um')}"
        rows.append(
            [
                octave_text,
                format_with_unit(common_height, "um"),
                format_with_unit(noise_height, "um"),
                format_percent(fraction),
            ]
        )
    shift_text = ", ".join(
        f"{axis} = {format_with_unit(item, 'um')}" for axis, item in zip("xy", comparison.shift[::-1], strict=False)
    )
    text = (
        f"The second scan starts at {shift_text} of the first scan. The correlation is {comparison.correlation:.4g}, "
        f"the noise of a single scan {format_with_unit(comparison.noise_rms, 'um')}."
    )
    paragraphs = f"{wrap_text(text)}\n{wrap_text(describe_mean_scan_noise(comparison))}\n{_caveat_lines(caveats)}"
    return f"{format_table(rows)}\n\n{paragraphs}"


def describe_mean_scan_noise(comparison: RepeatedScans) -> str:
    """Return a sentence on the noise in the mean of both scans, and on the cutoff that limits this noise."""
    if math.isnan(comparison.limit):
        return "At any cutoff, more than a tenth of the mean square slope of the mean scan is noise."
    if comparison.slope_fraction <= MAX_NEGLIGIBLE_NOISE_FRACTION:
        return "All wavelengths of the mean scan can be used: less than a tenth of its mean square slope is noise."
    return (
        f"{format_percent(comparison.slope_fraction)} of the mean square slope of the mean scan is noise: "
        f"--cutoff '{format_with_unit(comparison.limit, 'um')}' limits noise to a tenth."
    )


def repeated_scans_record(comparison: RepeatedScans, caveats: Sequence[Caveat] = ()) -> dict[str, Any]:
    """Return the comparison of two scans and its caveats as the fields of a JSON record, with lengths in µm."""
    octaves = {"wavelength_um": comparison.wavelength, "noise_um": comparison.noise, "common_um": comparison.common}
    return {
        "shift_um": list(comparison.shift), "correlation": comparison.correlation, "noise_um": comparison.noise_rms,
        "limit_um": None if math.isnan(comparison.limit) else comparison.limit,
        "noise_slope_fraction": comparison.slope_fraction,
        "octaves": {name: item.tolist() for name, item in octaves.items()},
        "caveats": list(map(caveat_record, caveats)),
    }  # fmt: skip


def octave_noise_csv(comparison: RepeatedScans) -> str:
    """Return the comparison of two scans as CSV: noise and common roughness in each octave of wavelength.

    A comment in the first line describes the noise of the averaged scan.
    """
    import pandas

    columns = {
        "wavelength (um)": comparison.wavelength,
        "noise (um)": comparison.noise,
        "common (um)": comparison.common,
    }
    return f"# {describe_mean_scan_noise(comparison)}\n{frame_to_csv(pandas.DataFrame(columns), float_format='%.6g')}"


def repeated_scans_figure(comparison: RepeatedScans) -> Figure:
    """Draw a figure 85 mm wide: spectra of the noise of two scans, and of the roughness that both scans contain."""
    import matplotlib as mpl

    with mpl.rc_context(MATPLOTLIB_STYLE):
        figure = new_figure(66, width=PAGE_WIDTH / 2)
        comparison.plot(figure.subplots())
    return figure
