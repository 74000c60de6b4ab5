"""What a profile or a surface is like: one record for text, JSON, CSV, figure and page."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from stiction._number_format import percent, with_unit
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.friction import STATUS_OK
from stiction.studies.assessment import Doubt
from stiction.studies.contact_statistics import slopes_of
from stiction.studies.input_caveats import REASONS, doubts_of_scan
from stiction.surfaces.filters import checked_cutoff, filtered
from stiction.surfaces.hurst import HurstEstimate, estimate_hurst_exponent
from stiction.surfaces.lines import MAX_MISFIT, LineRoughness, lines_along_both, power_law_misfit
from stiction.surfaces.measured.writing import heights_with_nan
from stiction.surfaces.missing_data import MIN_OUTLIER_DEVIATIONS, find_outliers
from stiction.surfaces.parameters import PARAMETERS, PROFILE_PARAMETERS, Parameter
from stiction.surfaces.profile import Profile
from stiction.surfaces.roughness import (
    RoughnessParameters,
    SurfaceParameters,
    rms_gradient,
    roughness_parameters,
    surface_parameters,
)
from stiction.surfaces.scale import (
    InstrumentLimit,
    ScaleDependentRoughness,
    instrument_limit,
    scale_dependent_roughness,
)
from stiction.surfaces.sections import DEFAULT_SECTIONS, SectionError, SectionParameters, section_parameters
from stiction.surfaces.spectrum import (
    PowerSpectrum,
    ProfileMoments,
    RadialSpectrum,
    find_peak,
    power_spectrum,
    spectral_moments,
    surface_spectrum,
)
from stiction.surfaces.surface import Surface
from stiction.views.rows import entry, record
from stiction.views.spreadsheet import csv_of_frame
from stiction.views.text import fitted

PAPERS_MU0 = 0.4  # molecular friction coefficient of the friction that slopes alone give
RADIAL_BINS = 20  # bins to a decade of a surface's spectrum
OCTAVES = 4  # number of cut-offs at which the slope is told: two points and their doubles
HARMLESS = 0.01  # share of the mean square slope below which untrusted waves do not matter
_PEAKED = 3.0  # density over that of longer waves from which a band begins on a peak and not behind a roll-off
_FEWEST = 4  # fewest longer waves that such a peak is compared with
_PEAK_SHARE = 0.1  # share of m4 from which a peak is reported
_SCATTERED = 2.0  # dispersion from which the scatter of a spectrum about its fit is reported
_HANN_CHANCE = 2.0  # variance of the logarithm of a bin of a windowed spectrum, times its harmonics

_SYMBOLS = {"1": "", "um2": " µm²", "1/um": " 1/µm", "1/um2": " 1/µm²", "degrees": "°"}  # units of JSON as text
_UNITS = {"": "1"}  # units of parameters as JSON has them; of others "um" is written for "µm" and "2" for "²"


class Row(NamedTuple):
    """A line of the table: its label, one text or one along x and one along y, and the values of JSON and CSV in it."""

    label: str
    texts: tuple[str, ...]
    values: tuple[dict[str, Any], ...] = ()


@dataclass(frozen=True, eq=False)
class Characterisation:
    """What a levelled profile or surface is like; everything is computed once, when it is asked for.

    Attributes
    ----------
    body : Profile or Surface
        Not flat, and of at least 7 points along each axis.
    band : (float, float), µm, optional
        Shortest and longest wavelength to fit Hurst exponents to; without one it is found.
    tip_radius : float, µm, optional
        Radius of the stylus or the probe.
    periodic : bool
        As in `power_spectrum`.
    lc, ls : float, µm, optional
        Cutoff wavelengths of the R- and W-parameters of a profile, as in `section_parameters`, or of the S-parameters
        of a surface, which has no filters without them.
    robust : bool
        Whether the L-filter is the robust one.

    Raises
    ------
    ValueError
        Where something is asked for: if the body is flat or too small, a given band holds too few waves, or a given
        cutoff does not suit the profile.
    """

    body: Profile | Surface
    band: tuple[float, float] | None = None
    tip_radius: float | None = None
    periodic: bool = False
    textured: bool = False
    """Whether the body was machined, so that lines and humps in its spectrum are its own."""
    lc: float | None = None
    ls: float | None = None
    robust: bool = False

    @cached_property
    def parameters(self) -> RoughnessParameters | SurfaceParameters:
        """Parameters of heights and slopes."""
        body = self.scale_limited
        return roughness_parameters(body) if isinstance(body, Profile) else surface_parameters(body)

    @cached_property
    def scale_limited(self) -> Profile | Surface:
        """Profile as it is, or the S-L surface of the given cutoffs, of which the parameters are computed."""
        body = self.body
        if isinstance(body, Profile):
            return body
        if self.lc is None and self.robust:
            raise ValueError("the robust filter of a surface needs a cutoff lc")
        if self.lc is not None and self.ls and self.ls >= self.lc:
            raise ValueError(f"ls must be below lc, {self.lc:g} µm, got {self.ls:g} µm")
        if self.ls:
            body = filtered(body, cutoff=checked_cutoff("ls", self.ls, body, longest=1), kind="S")
        if self.lc is not None:
            body = filtered(body, cutoff=checked_cutoff("lc", self.lc, body, longest=1), kind="L", robust=self.robust)
        return body

    @cached_property
    def slope_of_neighbours(self) -> float:
        """Root-mean-square slope or gradient of neighbouring points."""
        body = self.scale_limited
        if isinstance(body, Profile):
            return roughness_parameters(body, derivative="neighbours").Pdq
        return rms_gradient(body, "neighbours")

    @cached_property
    def sections(self) -> SectionParameters | SectionError | None:
        """R- and W-parameters of a profile, or why a profile has none by default; None of a surface."""
        if not isinstance(self.body, Profile):
            return None
        try:
            return section_parameters(self.body, lc=self.lc, ls=self.ls, robust=self.robust)
        except SectionError as error:
            if self.lc is not None:
                raise
            return error

    @cached_property
    def spectrum(self) -> PowerSpectrum | None:
        """Spectrum of a profile."""
        return power_spectrum(self.body, periodic=self.periodic) if isinstance(self.body, Profile) else None

    @cached_property
    def _area(self) -> tuple[RadialSpectrum, tuple[ProfileMoments, ...], float]:
        """Radial spectrum of a surface, moments along x and y, and the direction of its steepest lines."""
        assert isinstance(self.body, Surface)
        spectrum = surface_spectrum(self.body)
        moments = tuple(spectrum.moments(direction) for direction in (0, 90))
        return spectrum.radial(RADIAL_BINS), moments, spectrum.steepest_direction()

    @cached_property
    def binned(self) -> PowerSpectrum | RadialSpectrum:
        """Means of the spectrum in bins of log q."""
        return self._area[0] if self.spectrum is None else self.spectrum.in_bins()

    @cached_property
    def lines(self) -> tuple[LineRoughness, ...]:
        """Roughness of a surface along x and y."""
        return () if isinstance(self.body, Profile) else lines_along_both(self.body, band=self.band)

    @cached_property
    def fit(self) -> HurstEstimate | None:
        """Power law of the spectrum, however straight it is; None if no band is given and none is found."""
        try:
            return estimate_hurst_exponent(self.body, band=self.band, periodic=self.periodic)
        except ValueError:
            if self.band is not None:
                raise
            return None

    @cached_property
    def misfit(self) -> float:
        """Factor by which the spectrum is off its power law; NaN without one."""
        if self.fit is None:
            return math.nan
        ends = self.fit.shortest_wavelength, self.fit.longest_wavelength
        dimensions, chance = self.fit.dimensions, _HANN_CHANCE
        return power_law_misfit(self.binned, ends, self.fit.value, dimensions=dimensions, chance=chance)

    @property
    def law(self) -> HurstEstimate | None:
        """Power law of a spectrum that is one."""
        return None if self.misfit > MAX_MISFIT else self.fit

    @cached_property
    def roughness(self) -> ScaleDependentRoughness:
        """Slope and curvature over wavelength."""
        return scale_dependent_roughness(self.body, periodic=self.periodic)

    @cached_property
    def limit(self) -> InstrumentLimit:
        """Shortest wave that is to be trusted."""
        return instrument_limit(
            self.body, tip_radius=self.tip_radius, periodic=self.periodic, texture=self.textured
        )  # fmt: skip

    @cached_property
    def friction(self) -> tuple[float, ...]:
        """Coefficient against its like by slopes alone, along x and, of a surface, y; none if flat along one."""
        # The gap of two such bodies has twice the mean square; along x first.
        squares = [2 * float(np.square(along).mean()) for along in slopes_of(self.body)][::-1]
        return tuple(
            float(gentle_friction(PAPERS_MU0, rms_gradient=math.sqrt(sum(squares)), rms_slope=math.sqrt(square)))
            for square in squares
            if min(squares) > 0
        )

    # ---- The table ---------------------------------------------------------------------------------------------------

    @cached_property
    def rows(self) -> list[Row]:
        """The record of the whole body."""
        points, steps = np.shape(self.body.heights)[::-1], np.atleast_1d(self.body.spacing)[::-1]
        rows = [Row("" if at else "history", (step,)) for at, step in enumerate(self.body.history)]
        for at, (count, step) in enumerate(zip(points, steps.tolist(), strict=True)):
            along = f" along {'xy'[at]}" if self.spectrum is None else ""
            text = f"{count}{along}, {length_text(step)} apart, over {length_text(count * step)}"
            rows.append(Row("" if at else "points", (text,)))
        if self.body.missing is not None:
            rows.append(Row("", ("what follows is of heights with straight lines over the holes",)))
        count = int(find_outliers(heights_with_nan(self.body)).sum())
        single = f"{count} single points" if count > 1 else "a single point"
        text = f"{single} beyond {MIN_OUTLIER_DEVIATIONS:g} deviations of the neighbours; --outliers mask masks"
        rows.append(Row("outliers", (text if count else "none",), (entry("outliers", count),)))
        rows += [*self._parameter_rows(), Row("friction by slope", (self._friction_text(),))]
        if self.spectrum is not None and isinstance(self.body, Profile):
            moments = spectral_moments(self.body, periodic=self.periodic)
            rows += [
                _row("m0", moments.height, "um2"), _row("m2", moments.slope), _row("m4", moments.curvature, "1/um2"),
                _row("nayak_parameter", moments.nayak_parameter, label="Nayak's parameter", words=" (m0 m4 / m2²)"),
            ]  # fmt: skip
            rows += _peak_rows("peak", self.spectrum)
        rows += [*self._scale_rows(), *self._hurst_rows()]
        if self.spectrum is not None:
            window = "as it is, periodic" if self.periodic else "after a Hann window"
            rows.append(Row("spectrum", (f"{window}; moments over all of its wavelengths",)))
        rows += [Row("" if at else "caveats", (f"{each.text}; {each.cure}",)) for at, each in enumerate(self.doubts)]
        return rows

    @cached_property
    def doubts(self) -> list[Doubt]:
        """Caveats about the scan: heights, form, spikes, and wavelengths that may not be the surface's."""
        return doubts_of_scan(self.body, tip_radius=self.tip_radius, textured=self.textured)

    def _parameter_rows(self) -> list[Row]:
        rows = self._rows_of(self.parameters.values)
        found = self.sections
        if found is None:
            steps = self.scale_limited.history[len(self.body.history) :]
            words = ", then ".join(steps) if steps else "none: S-F surface of all wavelengths; --ls and --lc filter"
            return [Row("filters", (words,)), *rows]
        if isinstance(found, SectionError):
            names = [each.name for letter in "RW" for each in PROFILE_PARAMETERS[letter]]
            gone = tuple(entry(name, math.nan, _unit(PARAMETERS[name]), status="no-section") for name in names)
            why = str(found).replace("cutoff lc", "--lc")
            return [*rows, Row("R and W parameters", (f"none: {why}",), gone)]
        rows.append(Row("filters", (_filters_text(found),), _filters_values(found)))
        return [*rows, *self._rows_of(found.values)]

    def _rows_of(self, values: Mapping[str, float]) -> list[Row]:
        rows = []
        for name, value in values.items():
            rows.append(self._parameter_row(PARAMETERS[name], value))
            if name == "Std":
                steepest = self._area[2]
                text = f"{steepest:.1f}°, along which lines are steepest on the mean"
                rows.append(Row("", (text,), (entry("steepest_direction", steepest, "degrees"),)))
        return rows

    def _parameter_row(self, parameter: Parameter, value: float) -> Row:
        name = parameter.name
        row = _row(name, value, _unit(parameter))
        if name in ("Pdq", "Sdq"):
            other = entry(f"{name}_neighbours", self.slope_of_neighbours)
            text = f"{row.texts[0]} (seven points), {other['value']:.4g} (neighbours)"
            return Row(name, (text,), (*row.values, other))
        if name == "Std":
            text = f"{value:.0f}° from +x towards +y, of the strongest wavelengths; a lay runs across"
            return row._replace(texts=(text,))
        if name in ("Sal", "Str") and math.isnan(value):
            return row._replace(texts=(self._without_decay(name),))
        if math.isnan(value):
            return row._replace(texts=(f"none: needs {parameter.needs}",))
        if parameter.is_fraction:
            return row._replace(texts=(f"{100 * value:.4g} %",))
        return row

    def _without_decay(self, name: str) -> str:
        """Words for a length or a ratio of the autocorrelation that the map is too small for."""
        shortest = getattr(self.parameters, "Sal", math.nan)
        if name == "Sal":
            return "none: no decay to 0.2 within half the map"
        if math.isnan(shortest):
            return "none, without Sal"
        most = shortest / (np.min(self.body.extent) / 2)
        return f"below {most:.2g}: no decay to 0.2 along the lay within half the map"

    def _friction_text(self) -> str:
        if not self.friction:
            return "none, without slopes"
        if not all(map(math.isfinite, self.friction)):
            return "none: slopes so steep that contacts on them hold at any tangential load"
        axes = (" along x,", " along y,") if len(self.friction) == 2 else (",",)
        values = " ".join(f"{value:.3f}{axis}" for value, axis in zip(self.friction, axes, strict=True))
        return (
            f"{values} of two such bodies, estimated from slopes alone; friction only at contacts whose slope opposes "
            f"the motion (the rule of the paper), μ0 = {PAPERS_MU0:g} (gentle_friction)"
        )

    def _scale_rows(self) -> list[Row]:
        found, limit = self.roughness, self.limit
        share = float(found.fraction_below(2 * limit.pixels))
        longest = float(found.wavelength[0])
        slopes = ", ".join(
            f"{float(found.gradient_at(wave)):.3g} from {with_unit(float(wave), 'um')}"
            for wave in limit.pixels * 2.0 ** np.arange(OCTAVES)
            if wave < longest
        )
        shortest = entry("shortest_wave", limit.pixels, "um")
        octave = entry("slope_in_shortest_octave", share)
        off = with_unit(limit.cut_off, "um")
        wave, part = with_unit(limit.wavelength, "um"), f"{percent(limit.slope_fraction)} of the mean square slope"
        if limit.reason == "pixels":
            words = f"nothing but its pixels{'' if self.tip_radius is None else ', and its tip follows all'}"
        elif limit.slope_fraction < HARMLESS:
            words = f"below {wave} {REASONS[limit.reason]}: harmless, {part}"
        else:
            whose = "not to be trusted" if limit.origin == "instrument" else "perhaps not the surface's"
            words = f"{whose} below {wave}: {REASONS[limit.reason]}, {part}; --cutoff '{off}' takes that off"
        below = f"those below {with_unit(2 * limit.pixels, 'um')} make {percent(share)} of the mean square slope"
        limits = entry("noise_floor_below", limit.noise, "um"), entry("tip_follows_down_to", limit.tip, "um")
        return [
            Row("waves", (f"{with_unit(limit.pixels, 'um')} (two points) to {length_text(longest)}",), (shortest,)),
            Row("", (below,), (octave,)), Row("slope of waves", (slopes,)), *self._period_rows(),
            Row("instrument", (words,), limits),
        ]  # fmt: skip

    def _period_rows(self) -> list[Row]:
        period = self.limit.period
        if not period > 0:
            return []
        along = "" if isinstance(self.body, Profile) else ", along x or y"
        text = f"period {length_text(period)}{along}, with its harmonics: the surface's, as of a feed"
        return [Row("texture", (text,), (entry("texture_period", period, "um"),))]

    def _hurst_rows(self) -> list[Row]:
        names = ("hurst_exponent", "1"), ("shortest_wavelength", "um"), ("longest_wavelength", "um")
        fit = self.fit
        if fit is None or self.law is None:
            why, status = "no self-affine band was found; look at the spectrum, then give a band", "no-band"
            if fit is not None:
                why, status = f"the spectrum is no line; the nearest is off by a factor of {self.misfit:.1f}", "no-line"
            gone = tuple(entry(name, math.nan, unit, status=status) for name, unit in names)
            rows = [Row("Hurst exponent H", (f"none: {why}",), gone), Row("fractal dimension D", ("none, without H",))]
        else:
            interval = f"{fit.value:.3f} [{fit.lower:.3f}, {fit.upper:.3f}] (95 %)"
            waves = "harmonics" if fit.dimensions == 1 else "waves"
            ends = fit.shortest_wavelength, fit.longest_wavelength
            source = f"{'given' if self.band else 'found'}; {fit.harmonics} {waves}"
            band = f"{' to '.join(map(length_text, ends))} ({source})"
            classical = f"{fit.fractal_dimension_classical:.3f} (classical, 2 - H)"
            value = entry(names[0][0], fit.value, lower=fit.lower, upper=fit.upper)
            rows = [
                Row("Hurst exponent H", (interval,), (value,)),
                Row("fitted band", (band,), tuple(entry(names[at + 1][0], ends[at], "um") for at in (0, 1))),
                Row("fractal dimension D", (classical if fit.value <= 1 else "none: 2 - H is below 1",)),
                Row("", (f"{fit.fractal_dimension_paper:.3f} (paper, (4 - H)/2)",)),
            ]
            if fit.dispersion > _SCATTERED:
                text = f"{math.sqrt(fit.dispersion):.1f} times that of chance: see the spectrum"
                rows.append(Row("scatter", (text,)))
            if fit.value > 1:
                text = "H above 1 indicates a smooth surface: form, a filter, a blunt tip or waviness"
                rows.append(Row("caution", (text,)))
        if fit is not None and (rise := self._rise(fit.longest_wavelength)) > _PEAKED:
            start = f"the band begins on a peak at {length_text(fit.longest_wavelength)}"
            rows.append(Row("caution", (f"{start}, {rise:.1f} times what is longer: waves, grooves",)))
        return rows

    def _rise(self, longest: float) -> float:
        """Density where a band begins over that of longer wavelengths; 0 where these are too few."""
        whole = self.binned if self.spectrum is None else self.spectrum
        q, start = whole.wave_number, 2 * math.pi / longest
        longer = (q > 2.5 * q[0]) & (q < start / 1.5)  # without what the window and levelling decide
        begins = (q >= start / 1.2) & (q < start * 1.2)
        if longer.sum() < _FEWEST or not begins.any():
            return 0.0
        return float(whole.density[begins].mean() / whole.density[longer].mean())

    @cached_property
    def line_rows(self) -> list[Row]:
        """Rows about the lines of a surface along x and along y."""
        if not self.lines:
            return []
        sides, moments = self.lines, self._area[1]
        bands = ["none" if line.band is None else " to ".join(map(length_text, line.band)) for line in sides]
        columns: list[tuple[str, list[str]]] = [
            ("number", [f"{line.lines}" for line in sides]),
            ("Pq", [length_text(line.Pq) for line in sides]),
            ("Pdq, seven points", [f"{line.Pdq:.4g}" for line in sides]),
            ("Pdq, neighbours", [f"{line.Pdq_neighbours:.4g}" for line in sides]),
            ("m0", [f"{moment.height:.4g} µm²" for moment in moments]),
            ("m2", [f"{moment.slope:.4g}" for moment in moments]),
            ("m4", [f"{moment.curvature:.4g} 1/µm²" for moment in moments]),
            ("Nayak's parameter", [f"{moment.nayak_parameter:.4g}" for moment in moments]),
            ("Hurst exponent H", [_line_hurst(line) for line in sides]),
            ("fitted band", bands),
            ("off the line", ["none" if math.isnan(line.misfit) else f"factor {line.misfit:.2f}" for line in sides]),
        ]
        if self.band is None and sides[0].band != sides[1].band:
            columns.append(("band found in", [f"{line.with_band} of {line.fitted} lines" for line in sides]))
        rows = [Row("lines", ("along x", "along y")), *(Row(f"  {name}", tuple(values)) for name, values in columns)]
        for axis, line in zip("xy", sides, strict=True):
            rows += _peak_rows(f"  peak along {axis}", line.spectrum, line.fitted)
        means = [float(line.hurst_exponents.mean()) for line in sides if line.is_straight]
        if self.law is not None and means and not any(self.law.lower < mean < self.law.upper for mean in means):
            text = "H of lines is outside the interval of the map's: it depends on the band, see the spectra"
            rows.append(Row("  caution", (text,)))
        lines = "each line levelled by a line; Pq and Pdq: rms over lines; H: mean ± standard deviation"
        spectrum = "m0 to m4: of the map's spectrum after a Hann window, over all of its wavelengths"
        return [*rows, Row("", (lines,)), Row("", (spectrum,))]


def characterisation_of(body: Profile | Surface | Characterisation, **options: Any) -> Characterisation:
    """The record of a body, or a record as it is."""
    return body if isinstance(body, Characterisation) else Characterisation(body, **options)


def characterisation_text(body: Profile | Surface | Characterisation, **options: Any) -> str:
    """History, parameters, moments and Hurst exponent of a profile or a surface, a line for each, with units.

    Parameters
    ----------
    body : Profile, Surface or Characterisation
        Levelled, not flat, and of at least 7 points along each axis.
    **options
        `band`, `tip_radius` and `periodic` of a `Characterisation`.

    Raises
    ------
    ValueError
        If the body is flat or too small, or a given band holds too few waves. That no band is found is said in the
        text.

    Examples
    --------
    >>> from stiction import self_affine
    >>> from stiction.views.characterisation import characterisation_text
    >>> profile = self_affine(1, hurst_exponent=0.7, rms=0.1, points=4000, spacing=0.01)
    >>> print(characterisation_text(profile).splitlines()[0])
    points              4000, 10 nm apart, over 40 µm
    """
    found = characterisation_of(body, **options)
    return "".join(
        fitted(f"{row.label:<19} {'  '.join(f'{each:<23}' for each in row.texts)}".rstrip(), hang=" " * 20) + "\n"
        for row in (*found.rows, *found.line_rows)
    )


def length_text(value: float) -> str:
    """A length, µm, in the unit that gives it one to three digits before the point."""
    for unit, size in (("pm", 1e-6), ("nm", 1e-3), ("µm", 1.0), ("mm", 1e3)):
        if value < 999.95 * size or unit == "mm":
            break
    return f"{value / size:.4g} {unit}"


def _unit(parameter: Parameter) -> str:
    """Return the unit of a parameter as JSON has it."""
    return _UNITS.get(parameter.unit, parameter.unit.replace("µm", "um").replace("²", "2"))


def _filters_text(found: SectionParameters) -> str:
    """Return the filters and the evaluation length in words."""
    own = found.filters
    short = "no λs" if own.ls is None else f"λs {length_text(own.ls)}"
    kind = "robust Gaussian regression" if own.robust else "Gaussian"
    fewer = "" if own.sections == DEFAULT_SECTIONS else f" instead of {DEFAULT_SECTIONS}"
    section = f"section{'s' * (own.sections != 1)}{fewer} of {length_text(own.lc)}"
    return f"{kind}, λc {length_text(own.lc)}, {short} ({own.reason}); {own.sections} {section}"


def _filters_values(found: SectionParameters) -> tuple[dict[str, Any], ...]:
    own = found.filters
    short = math.nan if own.ls is None else own.ls
    cutoffs = entry("lc", own.lc, "um"), entry("ls", short, "um", status="none" if own.ls is None else STATUS_OK)
    return *cutoffs, entry("sections", own.sections)


def _row(name: str, value: float, unit: str = "1", *, label: str = "", words: str = "") -> Row:
    text = length_text(value) if unit == "um" else f"{value:.4g}{_SYMBOLS[unit]}"
    if math.isnan(value):
        text = "none"
    status = "none" if math.isnan(value) else STATUS_OK
    return Row(label or name, (f"{text}{words}",), (entry(name, value, unit, status=status),))


def _peak_rows(label: str, spectrum: PowerSpectrum, lines: int = 1) -> list[Row]:
    found = find_peak(spectrum, lines=lines)
    if found is None or found[1] < _PEAK_SHARE:
        return []
    where, part = length_text(found[0]), 100 * found[1]
    return [Row(label, (f"at {where}, with {part:.0f} % of m4: of the instrument, or a pattern; see the spectrum",))]


def _line_hurst(line: LineRoughness) -> str:
    if not line.hurst_exponents.size:
        return "none"
    mean, scatter = line.hurst_exponents.mean(), line.hurst_exponents.std()
    return f"{mean:.3f} ± {scatter:.3f}{' (smooth)' if mean > 1 else ''}" if line.is_straight else "none, no line"


# ---- JSON and CSV ----------------------------------------------------------------------------------------------------

Files = Sequence[tuple[str, Characterisation]]  # names of files and their records


def _values(found: Characterisation) -> list[dict[str, Any]]:
    return [value for row in found.rows for value in row.values]


def characterisation_record(files: Files, readings: Sequence[dict[str, Any]] = ()) -> str:
    """Return records of files as JSON, with what was understood of each file."""
    values = [value | {"at": {"file": file}} for file, found in files for value in _values(found)]
    return record(
        "characterise", values, kind="surface", surfaces=[_about(*each) for each in files], files=list(readings)
    )


def _about(file: str, found: Characterisation) -> dict[str, Any]:
    body = found.body
    return {
        "file": file, "holds": "profile" if isinstance(body, Profile) else "surface",
        "points": list(np.shape(body.heights)), "spacing_um": np.atleast_1d(body.spacing).tolist(),
        "extent_um": np.atleast_1d(body.extent).tolist(), "history": list(body.history),
        "caveats": [{"text": each.text, "cure": each.cure, "severity": each.severity} for each in found.doubts],
    }  # fmt: skip


def characterisation_csv(files: Files) -> str:
    """A row for each file, a column for each value with its unit; empty where a file has none."""
    import pandas

    rows = []
    for file, found in files:
        about = _about(file, found)
        row = {"file": file, "holds": about["holds"]}
        for title, key in (("points", "points"), ("spacing (um)", "spacing_um")):
            row[title] = " x ".join(f"{each:.12g}" for each in about[key])
        for value in _values(found):
            name = value["name"]
            row[name if value["unit"] == "1" else f"{name} ({value['unit']})"] = value["value"]
            if name == "hurst_exponent":
                row |= {f"{name} {end}": value[end] for end in ("lower", "upper")}
        rows.append(row)
    return csv_of_frame(pandas.DataFrame(rows))
