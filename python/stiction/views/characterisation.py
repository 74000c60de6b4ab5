"""Table that characterises a profile or surface; the same rows serve for text, JSON, CSV and reports."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from stiction._estimate import Estimate, estimate_column_titles
from stiction._number_format import format_percent, format_with_unit
from stiction.mechanics.friction import STATUS_OK
from stiction.summary.assessment import Caveat
from stiction.summary.characterisation import ASSUMED_MU0, Characterisation
from stiction.summary.input_caveats import INSTRUMENT_LIMIT_REASON_TEXTS
from stiction.surfaces.lines import LineRoughness
from stiction.surfaces.missing_data import MIN_OUTLIER_SIGMAS
from stiction.surfaces.parameters import PROFILE_PARAMETERS, ROUGHNESS_PARAMETERS, ParameterDefinition
from stiction.surfaces.profile import Profile
from stiction.surfaces.scale import InstrumentLimit
from stiction.surfaces.sections import DEFAULT_SECTION_COUNT, SectionLengthError, SectionParameters
from stiction.surfaces.spectrum import PowerSpectrum, find_spectral_peak, spectral_moments
from stiction.surfaces.surface import Surface
from stiction.views.json_record import caveat_record, record_json
from stiction.views.layout import wrap_text
from stiction.views.point import SLIDING_RULE_DESCRIPTIONS
from stiction.views.spreadsheet import frame_to_csv

NUM_SLOPE_WAVELENGTHS = 4  # 2, 4, 8, ... grid spacings
NEGLIGIBLE_SLOPE_FRACTION = 0.01
_MIN_PEAK_DENSITY_RATIO = 3.0
_MIN_NUM_LONGER_WAVELENGTHS = 4
_MIN_PEAK_FOURTH_MOMENT_FRACTION = 0.1
_MIN_REPORTED_DISPERSION_RATIO = 2.0

_PRINTED_UNITS_BY_JSON_UNIT = {"1": "", "um2": " µm²", "1/um": " 1/µm", "1/um2": " 1/µm²", "degrees": "°"}
# Exceptions from the rule of `_json_unit`: in JSON, dimensionless parameters have the unit "1".
_JSON_UNIT_EXCEPTIONS = {"": "1"}


class TableRow(NamedTuple):
    """Row of a characterisation table: its label, the texts to print, and the numbers for JSON and CSV.

    Rows on the lines of a surface have two texts, for x and for y.
    """

    label: str
    texts: tuple[str, ...]
    values: tuple[Estimate, ...] = ()
    is_detail: bool = False


HEADLINE_PARAMETERS = (
    "Pq", "Pt", "Pdq", "Ra", "Rq", "Rz", "Rsk", "RSm", "Wq", "Sq", "Sa", "Sz", "Ssk", "Sdq", "Sal", "Str", "Std",
)  # fmt: skip
"""Roughness parameters that the terminal prints without `--verbose`."""


@dataclass(frozen=True, eq=False)
class CharacterisationTable:
    """Table of the roughness parameters of one scan, and of its spectrum, Hurst exponent and instrument limits."""

    scan: Characterisation

    @cached_property
    def rows(self) -> list[TableRow]:
        """Rows of the characterisation table that describe the whole profile or surface."""
        points, spacings = np.shape(self.scan.body.heights)[::-1], np.atleast_1d(self.scan.body.spacing)[::-1]
        rows = [
            TableRow("" if index else "history", (step,), is_detail=True)
            for index, step in enumerate(self.scan.body.history)
        ]
        for index, (count, step) in enumerate(zip(points, spacings.tolist(), strict=True)):
            direction_text = f" along {'xy'[index]}" if self.scan.spectrum is None else ""
            text = f"{count}{direction_text}, {length_text(step)} apart, over {length_text(count * step)}"
            rows.append(TableRow("" if index else "points", (text,)))
        if self.scan.body.missing is not None:
            rows.append(TableRow("", ("missing heights are interpolated along lines in the following values",)))
        count = int(self.scan.defects.outliers.sum())
        text = (
            f"{_describe_outliers(count)}; excluded from the spectrum; "
            f"--outliers mask removes {'them' if count > 1 else 'it'}"
        )
        rows.append(TableRow("outliers", (text if count else "none",), (Estimate(count, name="outliers"),)))
        rows += [*self._parameter_rows(), TableRow("friction by slope", (self._friction_text(),))]
        if self.scan.spectrum is not None and isinstance(body := self.scan.body_without_outliers, Profile):
            moments = spectral_moments(body, periodic=self.scan.periodic)
            rows += [
                row._replace(is_detail=True)
                for row in (
                    _parameter_table_row("m0", moments.height, "um2"), _parameter_table_row("m2", moments.slope),
                    _parameter_table_row("m4", moments.curvature, "1/um2"),
                    _parameter_table_row(
                        "nayak_parameter", moments.nayak_parameter, label="Nayak's parameter",
                        label_suffix=" (m0 m4 / m2²)",
                    ),
                )
            ]  # fmt: skip
            rows += _spectral_peak_rows("peak", self.scan.spectrum)
        rows += [*self._wavelength_rows(), *self._hurst_rows()]
        if self.scan.spectrum is not None:
            window_text = "without a window, periodic" if self.scan.periodic else "after a Hann window"
            rows.append(TableRow("spectrum", (f"{window_text}; moments over all of its wavelengths",), is_detail=True))
        rows += [
            TableRow("" if index else "caveats", (f"{item.text}; {item.remedy}",))
            for index, item in enumerate(self.scan.caveats)
        ]
        return rows

    def _parameter_rows(self) -> list[TableRow]:
        rows = self._rows_of_parameter_values(self.scan.parameters.values)
        result = self.scan.section_parameters
        if result is None:
            filter_steps = self.scan.scale_limited_body.history[len(self.scan.body.history) :]
            no_filters = "none: S-F surface with all wavelengths; --ls and --lc set filters"
            filters_text = ", then ".join(filter_steps) if filter_steps else no_filters
            return [TableRow("filters", (filters_text,)), *rows]
        if isinstance(result, SectionLengthError):
            names = [item.name for letter in "RW" for item in PROFILE_PARAMETERS[letter]]
            missing_entries = tuple(
                Estimate(math.nan, name=name, unit=_json_unit(ROUGHNESS_PARAMETERS[name]), status="no-section")
                for name in names
            )
            reason = str(result).replace("cutoff lc", "--lc")
            return [*rows, TableRow("R and W parameters", (f"none: {reason}",), missing_entries)]
        rows.append(TableRow("filters", (_filters_text(result),), _filter_values(result)))
        return [*rows, *self._rows_of_parameter_values(result.values)]

    def _rows_of_parameter_values(self, values: Mapping[str, float]) -> list[TableRow]:
        rows = []
        for name, value in values.items():
            rows.append(self._parameter_row(ROUGHNESS_PARAMETERS[name], value))
            if name == "Std":
                steepest_direction = self.scan.areal_analysis[2]
                text = f"{steepest_direction:.1f}°, direction in which lines are steepest on average"
                rows.append(
                    TableRow(
                        "",
                        (text,),
                        (Estimate(steepest_direction, name="steepest_direction", unit="degrees"),),
                        is_detail=True,
                    )
                )
        return rows

    def _parameter_row(self, parameter: ParameterDefinition, value: float) -> TableRow:
        name = parameter.name
        row = _parameter_table_row(name, value, _json_unit(parameter))._replace(
            is_detail=name not in HEADLINE_PARAMETERS
        )
        if name in ("Pdq", "Sdq"):
            neighbours_entry = Estimate(self.scan.rms_slope_between_neighbours, name=f"{name}_neighbours")
            text = f"{row.texts[0]} (seven points), {neighbours_entry.value:.4g} (neighbours)"
            return TableRow(name, (text,), (*row.values, neighbours_entry))
        if name == "Std":
            text = f"{value:.0f}° from +x towards +y, for the strongest wavelengths; the lay is perpendicular"
            return row._replace(texts=(text,))
        if name in ("Sal", "Str") and math.isnan(value):
            return row._replace(texts=(self._missing_autocorrelation_text(name),))
        if math.isnan(value):
            return row._replace(texts=(f"none: needs {parameter.needs}",))
        if parameter.is_fraction:
            return row._replace(texts=(f"{100 * value:.4g} %",))
        return row

    def _missing_autocorrelation_text(self, name: str) -> str:
        """Return the text for Sal or Str if the autocorrelation stays above 0.2 at distances of up to half the map."""
        autocorrelation_length = getattr(self.scan.parameters, "Sal", math.nan)
        if name == "Sal":
            return "none: no decay to 0.2 within half the map"
        if math.isnan(autocorrelation_length):
            return "none, without Sal"
        max_ratio = autocorrelation_length / (np.min(self.scan.body.extent) / 2)
        return f"below {max_ratio:.2g}: no decay to 0.2 along the lay within half the map"

    def _friction_text(self) -> str:
        if not self.scan.friction_estimates:
            return "none: the surface has no slopes"
        if not all(map(math.isfinite, self.scan.friction_estimates)):
            return "none: contacts on such steep slopes are self-locking"
        axis_texts = (" along x", " along y") if len(self.scan.friction_estimates) == 2 else ("",)
        coefficients_text = ", ".join(
            f"{value:.3f}{axis}" for value, axis in zip(self.scan.friction_estimates, axis_texts, strict=True)
        )
        return (
            f"{SLIDING_RULE_DESCRIPTIONS['all']}: μ0; {SLIDING_RULE_DESCRIPTIONS['opposing']}: {coefficients_text} "
            f"if μ0 = {ASSUMED_MU0:g}; small-slope estimates for two such surfaces without τ0"
        )

    def _wavelength_rows(self) -> list[TableRow]:
        result, limit = self.scan.roughness, self.scan.instrument_limit
        fraction = float(result.fraction_below(2 * limit.pixels))
        longest_wavelength = float(result.wavelength[0])
        slopes = ", ".join(
            f"{float(result.gradient_at(wavelength)):.3g} from {format_with_unit(float(wavelength), 'um')}"
            for wavelength in limit.pixels * 2.0 ** np.arange(NUM_SLOPE_WAVELENGTHS)
            if wavelength < longest_wavelength
        )
        shortest_entry = Estimate(limit.pixels, name="shortest_resolved_wavelength", unit="um")
        octave_entry = Estimate(fraction, name="slope_in_shortest_octave")
        cutoff_text = format_with_unit(limit.cut_off, "um")
        wavelength = format_with_unit(limit.wavelength, "um") + (f" along {limit.axis}" if limit.axis else "")
        contribution_text = f"{format_percent(limit.slope_fraction)} of the mean square slope"
        if limit.reason == "pixels":
            limit_text = "only the grid spacing"
        elif limit.slope_fraction < NEGLIGIBLE_SLOPE_FRACTION:
            limit_text = (
                f"below {wavelength} {INSTRUMENT_LIMIT_REASON_TEXTS[limit.reason]}: negligible, {contribution_text}"
            )
        else:
            assessment = "unreliable" if limit.origin == "instrument" else "perhaps not from the surface"
            reason = f"{INSTRUMENT_LIMIT_REASON_TEXTS[limit.reason]}, {contribution_text}"
            limit_text = f"{assessment} below {wavelength}: {reason}; --cutoff '{cutoff_text}' removes this fraction"
        if self.scan.textured and (limit.reason == "pixels" or limit.origin == "instrument"):
            limit_text += "; no line or hump to attribute to the surface (--texture)"
        shortest_octave_text = (
            f"below {format_with_unit(2 * limit.pixels, 'um')}: {format_percent(fraction)} of the mean square slope"
        )
        tip_wavelength = math.nan if self.scan.tip_limit is None else self.scan.tip_limit.tip
        limit_entries = (
            Estimate(limit.noise, name="noise_wavelength", unit="um"),
            Estimate(tip_wavelength, name="tip_wavelength", unit="um"),
        )
        return [
            TableRow(
                "wavelengths",
                (f"{format_with_unit(limit.pixels, 'um')} (two grid spacings) to {length_text(longest_wavelength)}",),
                (shortest_entry,),
            ),
            TableRow("", (shortest_octave_text,), (octave_entry,)),
            TableRow("cumulative slope", (slopes,)),
            *self._period_rows(),
            TableRow("instrument", (limit_text,), limit_entries),
            *([] if self.scan.tip_limit is None else [TableRow("tip", (_tip_limit_text(self.scan.tip_limit),))]),
        ]

    def _period_rows(self) -> list[TableRow]:
        period = self.scan.instrument_limit.period
        if not period > 0:
            return []
        direction_text = "" if isinstance(self.scan.body, Profile) else ", along x or y"
        text = (
            f"period {length_text(period)}{direction_text}, with its harmonics: "
            "attributed to the surface, such as a feed mark"
        )
        return [TableRow("texture", (text,), (Estimate(period, name="texture_period", unit="um"),))]

    def _hurst_rows(self) -> list[TableRow]:
        names = ("hurst_exponent", "1"), ("shortest_wavelength", "um"), ("longest_wavelength", "um")
        fit = self.scan.power_law_fit
        if fit is None or self.scan.valid_power_law is None:
            reason, status = "no self-affine band was found; choose one from the spectrum with --band", "no-band"
            if fit is not None:
                reason, status = (
                    "the spectrum is not a power law; "
                    f"the best fit deviates by a factor of {self.scan.power_law_misfit:.1f}",
                    "no-line",
                )
            missing_entries = tuple(Estimate(math.nan, name=name, unit=unit, status=status) for name, unit in names)
            rows = [
                TableRow("Hurst exponent H", (f"none: {reason}",), missing_entries),
                TableRow("fractal dimension D", ("none: there is no H",)),
            ]
        else:
            interval_text = f"{fit.value:.3f} [{fit.lower:.3f}, {fit.upper:.3f}] (95 %)"
            wave_name = "harmonics" if fit.dimensions == 1 else "wavelengths"
            band_limits = fit.shortest_wavelength, fit.longest_wavelength
            source = f"{'given' if self.scan.band else 'automatic'}; {fit.harmonics} {wave_name}"
            band_text = f"{' to '.join(map(length_text, band_limits))} ({source})"
            classical_text = f"{fit.fractal_dimension_classical:.3f} (classical, 2 - H)"
            value = Estimate(fit.value, fit.lower, fit.upper, name=names[0][0], kind="fit")
            rows = [
                TableRow("Hurst exponent H", (interval_text,), (value,)),
                TableRow(
                    "fitted band",
                    (band_text,),
                    tuple(Estimate(band_limits[index], name=names[index + 1][0], unit="um") for index in (0, 1)),
                ),
                TableRow("fractal dimension D", (classical_text if fit.value <= 1 else "none: 2 - H is below 1",)),
                TableRow("", (f"{fit.fractal_dimension_paper:.3f} (paper, (4 - H)/2)",)),
            ]
            if fit.dispersion > _MIN_REPORTED_DISPERSION_RATIO:
                text = f"{math.sqrt(fit.dispersion):.1f} times the expected scatter: see the spectrum"
                rows.append(TableRow("scatter", (text,)))
            if fit.value > 1:
                text = "H above 1 indicates a smooth surface: form, a filter, a blunt tip or waviness"
                rows.append(TableRow("caution", (text,)))
        if (
            fit is not None
            and (peak_ratio := self._density_ratio_at_longest_wavelength(fit.longest_wavelength))
            > _MIN_PEAK_DENSITY_RATIO
        ):
            peak_text = f"the band starts on a peak at {length_text(fit.longest_wavelength)}"
            rows.append(
                TableRow(
                    "caution",
                    (f"{peak_text}, {peak_ratio:.1f} times the density at longer wavelengths: waviness or grooves",),
                )
            )
        return rows

    def _density_ratio_at_longest_wavelength(self, longest: float) -> float:
        """Return the spectral density near the wavelength `longest` (µm), divided by the density at longer wavelengths.

        The ratio is 0 if the spectrum has too few longer wavelengths.
        """
        spectrum = self.scan.binned_spectrum if self.scan.spectrum is None else self.scan.spectrum
        q, band_start = spectrum.wave_number, 2 * math.pi / longest
        # The longest wavelengths are excluded, because the window function or levelling changes their density.
        is_longer = (q > 2.5 * q[0]) & (q < band_start / 1.5)
        is_at_start = (q >= band_start / 1.2) & (q < band_start * 1.2)
        if is_longer.sum() < _MIN_NUM_LONGER_WAVELENGTHS or not is_at_start.any():
            return 0.0
        return float(spectrum.density[is_at_start].mean() / spectrum.density[is_longer].mean())

    @cached_property
    def line_table_rows(self) -> list[TableRow]:
        """Rows of the characterisation table that describe the lines of a surface along x and along y."""
        if not self.scan.line_roughnesses:
            return []
        line_directions, moments = self.scan.line_roughnesses, self.scan.areal_analysis[1]
        band_texts = [
            "none" if line.band is None else " to ".join(map(length_text, line.band)) for line in line_directions
        ]
        columns: list[tuple[str, list[str]]] = [
            ("number", [f"{line.lines}" for line in line_directions]),
            ("Pq", [length_text(line.Pq) for line in line_directions]),
            ("Pdq, seven points", [f"{line.Pdq:.4g}" for line in line_directions]),
            ("Pdq, neighbours", [f"{line.Pdq_neighbours:.4g}" for line in line_directions]),
            ("m0", [f"{moment.height:.4g} µm²" for moment in moments]),
            ("m2", [f"{moment.slope:.4g}" for moment in moments]),
            ("m4", [f"{moment.curvature:.4g} 1/µm²" for moment in moments]),
            ("Nayak's parameter", [f"{moment.nayak_parameter:.4g}" for moment in moments]),
            ("Hurst exponent H", [_line_hurst_exponent_text(line) for line in line_directions]),
            ("fitted band", band_texts),
            (
                "misfit",
                ["none" if math.isnan(line.misfit) else f"factor {line.misfit:.2f}" for line in line_directions],
            ),
        ]
        if self.scan.band is None and line_directions[0].band != line_directions[1].band:
            columns.append(("band found in", [f"{line.with_band} of {line.fitted} lines" for line in line_directions]))
        rows = [
            TableRow("lines", ("along x", "along y")),
            *(TableRow(f"  {name}", tuple(values)) for name, values in columns),
        ]
        for axis, line in zip("xy", line_directions, strict=True):
            rows += _spectral_peak_rows(f"  peak along {axis}", line.spectrum, line.fitted)
        mean_exponents = [float(line.hurst_exponents.mean()) for line in line_directions if line.is_straight]
        if (
            self.scan.valid_power_law is not None
            and mean_exponents
            and not any(
                self.scan.valid_power_law.lower < mean_exponent < self.scan.valid_power_law.upper
                for mean_exponent in mean_exponents
            )
        ):
            text = "H of lines is outside the interval for the map: it depends on the band, see the spectra"
            rows.append(TableRow("  caution", (text,)))
        lines_note = (
            "a straight line is subtracted from each line; Pq and Pdq: rms over lines; H: mean ± standard deviation"
        )
        spectrum_note = "m0 to m4: from the spectrum of the map after a Hann window, over all wavelengths"
        return [*rows, TableRow("", (lines_note,)), TableRow("", (spectrum_note,))]


def find_outlier_caveats(
    scans: Sequence[Characterisation], names: Sequence[str], *, consequence: str, option: str
) -> list[Caveat]:
    """Return one caveat for each scan that has outliers, which are excluded from the scan's spectrum.

    `consequence` is a clause about the numbers that exclude the outliers. `option` is the option that removes the
    outliers from the scan.
    """
    outlier_counts = [int(scan.excluded_outliers.sum()) for scan in scans]
    return [
        Caveat(
            f"{name}: {_describe_outliers(count)}; {consequence}",
            f"{option} removes {'them' if count > 1 else 'it'}",
            "caution",
        )
        for name, count in zip(names, outlier_counts, strict=True)
        if count
    ]


def _describe_outliers(count: int) -> str:
    points_text = f"{count} points" if count > 1 else "1 point"
    return f"{points_text} more than {MIN_OUTLIER_SIGMAS:g} robust standard deviations from the neighbours"


def to_characterisation(body: Profile | Surface | Characterisation, **options: Any) -> Characterisation:
    """Return the characterisation of a body.

    An existing `Characterisation` is returned unchanged.
    """
    return body if isinstance(body, Characterisation) else Characterisation(body, **options)


def characterisation_text(
    body: Profile | Surface | Characterisation, *, headline_only: bool = False, **options: Any
) -> str:
    """Return the processing history, roughness parameters, spectral moments and Hurst exponent of a scan as text.

    Parameters
    ----------
    body : Profile, Surface or Characterisation
        Levelled, not flat, with at least 7 points along each axis.
    headline_only : bool
        True to format only the rows for the first screen of a terminal, and the number of all other rows.
    **options
        `band`, `tip_radius` and `periodic` of a `Characterisation`.

    Raises
    ------
    ValueError
        If the body is flat or too small, or the band contains too few wavelengths. A missing self-affine band is
        reported in the text.

    Examples
    --------
    >>> from stiction import self_affine
    >>> from stiction.views.characterisation import characterisation_text
    >>> profile = self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01)
    >>> print(characterisation_text(profile).splitlines()[0])
    points              4000, 10 nm apart, over 40 µm
    """
    result = to_characterisation(body, **options)
    table = CharacterisationTable(result)
    rows = [*table.rows, *(row._replace(is_detail=True) for row in table.line_table_rows)]
    shown_rows = [row for row in rows if not (headline_only and row.is_detail)]
    lines = [
        wrap_text(f"{row.label:<19} {'  '.join(f'{item:<23}' for item in row.texts)}".rstrip(), hanging_indent=" " * 20)
        for row in shown_rows
    ]
    if len(shown_rows) < len(rows):
        lines.append(f"{len(rows) - len(shown_rows)} more lines: --verbose shows all")
    return "\n".join([*lines, ""])


def length_text(value: float) -> str:
    """Return a length (µm) as text in the unit that gives one to three digits before the decimal point."""
    for unit, unit_length in (("pm", 1e-6), ("nm", 1e-3), ("µm", 1.0), ("mm", 1e3)):
        if value < 999.95 * unit_length or unit == "mm":
            break
    return f"{value / unit_length:.4g} {unit}"


def _json_unit(parameter: ParameterDefinition) -> str:
    """Return the unit of a roughness parameter as it is written in JSON output."""
    return _JSON_UNIT_EXCEPTIONS.get(parameter.unit, parameter.unit.replace("µm", "um").replace("²", "2"))


def _tip_limit_text(limit: InstrumentLimit) -> str:
    """Return text on the wavelength below which the scan does not resolve the surface because of the tip.

    No cutoff is suggested, because filtering does not restore these wavelengths.
    """
    if math.isnan(limit.tip):
        return "resolves all wavelengths"
    tip_text = f"does not resolve wavelengths below {format_with_unit(limit.tip, 'um')}"
    if limit.reason != "tip":
        return f"{tip_text}, which are unreliable in any case"
    contribution_text = f"{format_percent(limit.slope_fraction)} of the mean square slope"
    is_negligible = limit.slope_fraction < NEGLIGIBLE_SLOPE_FRACTION
    return f"{tip_text}: {'negligible, ' if is_negligible else ''}{contribution_text}"


def _filters_text(result: SectionParameters) -> str:
    """Return text on the filters and the evaluation length used for the roughness parameters."""
    filters = result.filters
    short_cutoff_text = "no λs" if filters.ls is None else f"λs {length_text(filters.ls)}"
    filter_kind = "robust Gaussian regression" if filters.robust else "Gaussian"
    fewer_sections_text = "" if filters.sections == DEFAULT_SECTION_COUNT else f" instead of {DEFAULT_SECTION_COUNT}"
    sections_text = f"section{'s' * (filters.sections != 1)}{fewer_sections_text} of {length_text(filters.lc)}"
    cutoffs_text = f"λc {length_text(filters.lc)}, {short_cutoff_text}"
    return f"{filter_kind}, {cutoffs_text} ({filters.reason}); {filters.sections} {sections_text}"


def _filter_values(result: SectionParameters) -> tuple[Estimate, ...]:
    filters = result.filters
    short_cutoff = math.nan if filters.ls is None else filters.ls
    cutoffs = (
        Estimate(filters.lc, name="lc", unit="um"),
        Estimate(short_cutoff, name="ls", unit="um", status="none" if filters.ls is None else STATUS_OK),
    )
    return *cutoffs, Estimate(filters.sections, name="sections")


def _parameter_table_row(
    name: str, value: float, unit: str = "1", *, label: str = "", label_suffix: str = ""
) -> TableRow:
    text = length_text(value) if unit == "um" else f"{value:.4g}{_PRINTED_UNITS_BY_JSON_UNIT[unit]}"
    if math.isnan(value):
        text = "none"
    status = "none" if math.isnan(value) else STATUS_OK
    return TableRow(label or name, (f"{text}{label_suffix}",), (Estimate(value, name=name, unit=unit, status=status),))


def _spectral_peak_rows(label: str, spectrum: PowerSpectrum, lines: int = 1) -> list[TableRow]:
    result = find_spectral_peak(spectrum, lines=lines)
    if result is None or result[1] < _MIN_PEAK_FOURTH_MOMENT_FRACTION:
        return []
    wavelength_text, percentage = length_text(result[0]), 100 * result[1]
    return [
        TableRow(
            label,
            (
                f"at {wavelength_text}, with {percentage:.0f} % of m4: from the instrument or a pattern; "
                "see the spectrum",
            ),
        )
    ]


def _line_hurst_exponent_text(line: LineRoughness) -> str:
    if not line.hurst_exponents.size:
        return "none"
    mean, exponent_scatter = line.hurst_exponents.mean(), line.hurst_exponents.std()
    return (
        f"{mean:.3f} ± {exponent_scatter:.3f}{' (smooth)' if mean > 1 else ''}" if line.is_straight else "none, no line"
    )


# ---- JSON and CSV ----------------------------------------------------------------------------------------------------

CharacterisedFiles = Sequence[tuple[str, Characterisation]]


def _list_estimates(result: Characterisation) -> list[Estimate]:
    return [value for row in CharacterisationTable(result).rows for value in row.values]


def characterisation_json(files: CharacterisedFiles, readings: Sequence[dict[str, Any]] = ()) -> str:
    """Return the characterisations of files as JSON, including how each file was read."""
    estimate_records = [value.to_record({"file": file}) for file, result in files for value in _list_estimates(result)]
    return record_json(
        "characterise",
        estimate_records,
        kind="surface",
        surfaces=[_file_record(*item) for item in files],
        files=list(readings),
    )


def _file_record(file: str, result: Characterisation) -> dict[str, Any]:
    body = result.body
    return {
        "file": file, "type": "profile" if isinstance(body, Profile) else "surface",
        "points": list(np.shape(body.heights)), "spacing_um": np.atleast_1d(body.spacing).tolist(),
        "extent_um": np.atleast_1d(body.extent).tolist(), "history": list(body.history),
        "caveats": list(map(caveat_record, result.caveats)),
    }  # fmt: skip


def characterisation_csv(files: CharacterisedFiles) -> str:
    """Return the characterisations of several files as CSV: one row per file, and empty cells for missing numbers."""
    import pandas

    rows = []
    for file, result in files:
        file_record = _file_record(file, result)
        row = {"file": file, "type": file_record["type"]}
        for title, key in (("points", "points"), ("spacing (um)", "spacing_um")):
            row[title] = " x ".join(f"{item:.12g}" for item in file_record[key])
        for value in _list_estimates(result):
            titles = estimate_column_titles(value.name, value.unit)
            row[titles["value"]] = value.value
            if value.kind:
                row |= {titles[field]: getattr(value, field) for field in ("lower", "upper")}
        rows.append(row)
    return frame_to_csv(pandas.DataFrame(rows))
