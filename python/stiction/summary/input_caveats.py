"""Caveats about the inputs of a study: heights, form error, spikes, noise, loads, mu0 and tau0."""

from __future__ import annotations

import math
import re
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import format_percent, format_with_unit
from stiction.evaluate.point import has_limited_pressure
from stiction.solve.alternative_preparations import SPIKES_ALTERNATIVE, TIP_ALTERNATIVE, AlternativeName
from stiction.study.inputs import Inputs, find_interface
from stiction.summary.assessment import Caveat, Severity
from stiction.summary.interface_caveats import find_interface_caveats
from stiction.surfaces.cut_off import MAX_CUTOFF_FRACTION
from stiction.surfaces.dominant_form import find_dominant_step, measure_parabola_fraction
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.pairing import SIDES
from stiction.surfaces.preparation import flipped, levelled, rotated
from stiction.surfaces.profile import Profile, combine_missing_masks, select_from_mask
from stiction.surfaces.registration import do_faces_fit
from stiction.surfaces.scale import CUTOFF_TO_REMOVED_WAVELENGTH_RATIO, InstrumentLimit
from stiction.surfaces.scan_defects import (
    MAX_NOISE_SLOPE_FRACTION,
    MIN_SPIKE_HEIGHT_RATIO,
    MIN_SPIKE_SHARPNESS_RATIO,
    ScanDefects,
    find_scan_defects,
)
from stiction.surfaces.spectrum import find_spectral_peak, power_spectrum
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    from stiction.study.measured_bodies import MeasuredBody, MeasuredBodySettings
    from stiction.study.study import Study

INSTRUMENT_LIMIT_REASON_TEXTS = {
    "noise floor": "the spectrum is flat, as for noise",
    "quantisation": "the spectrum is flat, as for quantised heights",
    "line": "the spectrum has a line",
    "roll-up": "the spectrum rises",
    "hump": "the spectrum has a hump",
}
"""Reasons why wavelengths are not attributed to the surface, as clauses of a caveat, by short name."""

# If the height of a scan exceeds its length by more than this factor, the unit of the heights must be wrong.
MAX_HEIGHT_OVER_EXTENT = 10.0
# A larger mu0 is probably a percentage: even clean metals in vacuum reach it only through tau0 and junction growth.
MAX_PLAUSIBLE_MU0 = 2.0

MAX_PARABOLA_HEIGHT_FRACTION = 0.6
"""Largest fraction of the mean square height due to a fitted parabola without a caveat about a form error.

The fraction is about one half for a surface without form error if the longest wavelengths dominate its heights.
"""

MAX_STEP_MEAN_SQUARE_FRACTION = 0.65
"""Largest fraction of the mean square height due to a straight step without a caveat about a step.

The largest fraction of 540 simulated profiles and 540 simulated maps without a step was 0.62.
"""

MAX_SPECTRAL_PEAK_FRACTION = 0.1
REPEATED_SCANS_REMEDY = "two scans of one place show which (stiction characterise --repeated)"
CUTOFF_REMEDY = (
    " if they come from the instrument; use --texture turned, milled, ground, ... or --cutoff none if they belong to "
    f"the surface; {REPEATED_SCANS_REMEDY}"
)
MAX_DENSITY_RATIO_OF_JOINED_SPECTRA = 2.0
MAX_PRESSURE_OVER_MODULUS = 0.1
"""Largest plausible ratio of nominal pressure to E*. A higher load is probably the load on the whole component."""


def find_input_caveats(
    upper: MeasuredBody, lower: MeasuredBody, study: Study, loads: Sequence[float] = (),
    alternatives: Collection[str] = (),
) -> tuple[Caveat, ...]:  # fmt: skip
    """Return the caveats about a study's scans, about its other inputs, and about given loads (mN).

    `alternatives` contains the names of the alternative preparations that the interval includes.
    """
    # Form error causes no caveat in a gap between two faces, nor in scans whose form was subtracted.
    surfaces: Any = study.surfaces
    is_form_subtracted = surfaces.level == "quadratic"
    is_vouched = bool(surfaces.vouched)
    quoted_cutoff = surfaces.reported_cut_off()

    def find_body_caveats(file: MeasuredBodySettings, body: MeasuredBody) -> list[Caveat]:
        """Return the caveats about all scans of a body.

        Caveats of one kind are merged and keep the longest cutoff.
        """
        caveats_by_kind: dict[str, Caveat] = {}
        for scan_entry, scan in zip(file.scans, (body, *(other.read() for other in file.scans[1:])), strict=True):
            scan_caveats = [
                Caveat(caveat.text, f"{caveat.remedy} ({caveat.name})", "caution") for caveat in scan_entry.caveats
            ]
            if isinstance(scan, JoinedSpectrum):
                scan_caveats += _find_spectrum_caveats(scan)
            else:
                scan_caveats += find_scan_caveats(
                    scan, form=not (is_form_subtracted or study.is_gap), step=not study.is_gap,
                    instrument=not is_vouched, tip_radius=file.tip,
                    textured=file.texture is not None, has_second_cutoff=bool(study.surfaces.both_readings),
                    elastic=not has_limited_pressure(study), alternatives=alternatives,
                    cut_off=scan_entry.select_cut_off_of_scan(quoted_cutoff),
                )  # fmt: skip
            for caveat in scan_caveats:
                caveats_by_kind[_get_text_without_numbers(caveat)] = max(
                    caveats_by_kind.get(_get_text_without_numbers(caveat), caveat),
                    caveat,
                    key=lambda caveat: caveat.cut_off,
                )
        return list(caveats_by_kind.values())

    upper_caveats, lower_caveats = map(
        find_body_caveats, (getattr(study.surfaces, side) for side in SIDES), (upper, lower)
    )
    caveat_pairs = [
        (upper_caveat, lower_caveat) for upper_caveat in upper_caveats for lower_caveat in lower_caveats
        if _get_text_without_numbers(upper_caveat) == _get_text_without_numbers(lower_caveat)
        and upper_caveat.severity == lower_caveat.severity
    ]  # fmt: skip
    paired_caveats = {caveat for pair in caveat_pairs for caveat in pair}
    merged_caveats = [
        replace(max(pair, key=lambda caveat: caveat.cut_off), text=_merge_caveat_texts(*pair)) for pair in caveat_pairs
    ]
    unpaired_caveats = [
        [caveat for caveat in body_caveats if caveat not in paired_caveats]
        for body_caveats in (upper_caveats, lower_caveats)
    ]
    names = ("gap" if study.is_gap else "both scans", "upper", "lower")
    named_caveats = zip(names, (merged_caveats, *unpaired_caveats), strict=True)
    caveats = [
        replace(caveat, text=f"{name}: {caveat.text}")
        for name, body_caveats in named_caveats
        for caveat in body_caveats
    ]
    longest_cutoff = MAX_CUTOFF_FRACTION * min(_get_shortest_side_length(body) for body in (upper, lower))
    caveats = [replace(caveat, remedy=_adapt_remedy_to_max_cutoff(caveat, longest_cutoff)) for caveat in caveats]
    caveats += _find_strength_caveats(study)
    area = float(np.prod(np.minimum(_get_axis_extents(upper), _get_axis_extents(lower))))
    modulus = float(study.contact.effective_modulus)
    for load in loads:
        if load / area > MAX_PRESSURE_OVER_MODULUS * modulus:
            pressure = format_with_unit(load / area, "GPa")
            text = f"the load {format_with_unit(load, 'mN')} is {pressure} on {area:.3g} µm², above a tenth of E*"
            caveats.append(Caveat(text, "specify the load on this area, not on the whole part", "caution"))
    caveats += _find_mirror_caveats(upper, lower, study)
    caveats += _find_mated_face_caveats(upper, lower, study)
    return tuple(caveats)


def _find_strength_caveats(study: Study) -> Iterator[Caveat]:
    """Yield caveats about the mu0 and tau0 of a study, and about the interface from which they come."""
    mu0 = max(float(value) for value in study.friction.mu0)
    if mu0 > MAX_PLAUSIBLE_MU0:
        text = f"μ0 = {mu0:g} is above {MAX_PLAUSIBLE_MU0:g}, the largest plausible μ0"
        yield Caveat(text, "specify μ0 as a fraction, not in per cent", "caution")
    if (settings := study.friction.interface) is None:
        return
    interface = find_interface(study)
    if interface is not None and interface.has_unknown_range:
        text = (
            "the interval does not include the uncertainty of μ0 and τ0, because the interface "
            f"{settings.name} has no known range"
        )
        yield Caveat(
            text, "measure μ0 and τ0 (stiction calibrate), or give --mu0 and --tau0 with their ranges", "caution"
        )
    yield from find_interface_caveats(
        interface, settings.name, Inputs.from_study(study), study.pair_checksum, settings.caveats_of_missing_file
    )


def _find_mated_face_caveats(upper: MeasuredBody, lower: MeasuredBody, study: Study) -> Iterator[Caveat]:
    """Yield a caveat if two faces fit into each other, as in a fracture, but the study specifies no position."""
    surfaces: Any = study.surfaces
    # Surrogates have no relative position, so they get no caveat.
    if study.is_gap or surfaces.press == "surrogates" or surfaces.positions:
        return
    facing_body: Any
    if isinstance(upper, Surface) and isinstance(lower, Surface):
        facing_body = flipped(rotated(upper, surfaces.rotate) if surfaces.press == "areas" else upper)
    elif isinstance(upper, Profile) and isinstance(lower, Profile):
        facing_body = flipped(upper)
    else:
        return
    if do_faces_fit(facing_body, lower):
        yield Caveat(
            "the faces fit into each other, but the result is a mean over positions at which they do not",
            "use stiction shear, which moves one face along the other",
            "caution",
        )


MIN_MIRRORED_GAP_REDUCTION = 2.0
"""Minimum factor by which a mirrored upper map must reduce the rms gap for a caveat about mirrored faces."""

_MIRROR_ALTERNATIVES = (
    ("with its columns reversed instead of its rows", "use --rotate {rotation:g}", np.s_[::-1, ::-1]),
    ("with neither rows nor columns reversed", "reverse the rows of the upper file", np.s_[::-1, :]),
    ("with rows and columns reversed", "reverse the columns of the upper file", np.s_[:, ::-1]),
)
"""Mirror images of the upper map: description, remedy, and slices that mirror the map that `flipped` returns."""


def _find_mirror_caveats(upper: MeasuredBody, lower: MeasuredBody, study: Study) -> Iterator[Caveat]:
    """Yield a caveat if two maps at the position (0, 0) would fit much better with a mirrored upper map."""
    surfaces: Any = study.surfaces
    if (
        surfaces.press != "areas"
        or surfaces.gap
        or (0.0, 0.0) not in [tuple(map(float, p)) for p in surfaces.positions or ()]
    ):
        return
    if not (isinstance(upper, Surface) and isinstance(lower, Surface)) or surfaces.rotate % 90:
        return
    facing_map = flipped(rotated(upper, surfaces.rotate))
    if facing_map.heights.shape != lower.heights.shape or not np.allclose(facing_map.spacings, lower.spacings):
        return
    height = _measure_rms_gap(facing_map, lower)
    gaps = [_measure_rms_gap(facing_map, lower, mirrored) for *_, mirrored in _MIRROR_ALTERNATIVES]
    smallest_gap_index = int(np.argmin(gaps))
    if height > MIN_MIRRORED_GAP_REDUCTION * gaps[smallest_gap_index]:
        description, remedy, _ = _MIRROR_ALTERNATIVES[smallest_gap_index]
        gap_text, mirrored_gap_text = (
            format_with_unit(rms_gap, "um") for rms_gap in (height, gaps[smallest_gap_index])
        )
        text = (
            f"the rms height of the gap at the position (0, 0) is {gap_text}, but {mirrored_gap_text} for the upper "
            f"map {description}"
        )
        yield Caveat(text, remedy.format(rotation=(surfaces.rotate + 180) % 360), "caution")


def _measure_rms_gap(facing: Surface, lower: Surface, mirrored: Any = np.s_[:, :]) -> float:
    """Return the rms height (µm) of the levelled gap between two maps, at points that are measured in both maps."""
    missing = combine_missing_masks(
        facing.changed(facing.heights[mirrored], "mirrored", missing=select_from_mask(facing.missing, mirrored)), lower
    )
    gap = levelled(Surface(facing.heights[mirrored] - lower.heights, spacing=lower.spacing, missing=missing), "plane")
    return float(np.std(gap.heights if missing is None else gap.heights[~missing]))


def _adapt_remedy_to_max_cutoff(caveat: Caveat, longest: float) -> str:
    """Return a caveat's remedy or, if the caveat's cutoff exceeds `longest` (µm), the advice to scan a longer part."""
    if not longest < caveat.cut_off < math.inf:
        return caveat.remedy
    return (
        f"scan a longer part, because the longest cutoff for both scans is {format_with_unit(longest, 'um')}; "
        "--cutoff none keeps these wavelengths"
    )


def _get_shortest_side_length(body: MeasuredBody) -> float:
    """Return the length (µm) of a profile, or of the shorter side of a map."""
    return body.extent if isinstance(body, Profile) else min(_get_axis_extents(body))


_NUMBER_PATTERN = re.compile(r"\d[\d.]*")


def _get_text_without_numbers(caveat: Caveat) -> str:
    """Return a caveat's text without its numbers; caveats of the same kind have the same remaining text."""
    return _NUMBER_PATTERN.sub("", caveat.text)


def _merge_caveat_texts(upper: Caveat, lower: Caveat) -> str:
    """Merge the texts of two caveats of the same kind.

    Where numbers differ, the merged text contains both numbers.
    """
    other_numbers = iter(_NUMBER_PATTERN.findall(lower.text))

    def join_two_numbers(own_number: re.Match[str]) -> str:
        other_number = next(other_numbers)
        return own_number[0] if own_number[0] == other_number else f"{own_number[0]} and {other_number}"

    return _NUMBER_PATTERN.sub(join_two_numbers, upper.text)


def find_scan_caveats(
    body: Profile | Surface,
    *,
    form: bool = True,
    step: bool = True,
    instrument: bool = True,
    tip_radius: float | None = None,
    textured: bool = False,
    has_second_cutoff: bool = False,
    elastic: bool = False,
    alternatives: Collection[str] = (),
    periodic: bool = False,
    cut_off: float = 0.0,
) -> list[Caveat]:
    """Return the caveats about a scan: heights, form error, steps, spikes, and wavelengths due to the instrument.

    If `form` or `step` is false, the caveat about a form error or about a step is left out. If `textured` is true, the
    spectrum may have lines and humps. `has_second_cutoff` is true if the study also evaluates the filtered scan, and
    `elastic` is true if the study has no hardness. `alternatives` contains the names of the alternative preparations
    that the interval includes. `periodic` is as for `power_spectrum`. Noise, and the roughness that a tip does not
    reach, are fractions of the roughness after a low-pass filter at `cut_off` (µm, 0 for no filter).
    """
    defects = find_scan_defects(body, tip_radius, textured=textured, periodic=periodic)
    instrument_caveats = _find_instrument_caveats(
        defects, has_second_cutoff, elastic, TIP_ALTERNATIVE in alternatives, cut_off
    )
    return [
        *_find_form_caveats(defects, form=form, step=step, has_masked_result=SPIKES_ALTERNATIVE in alternatives),
        *(instrument_caveats if instrument else ()),
    ]


def find_study_caveats(study: Study, alternatives: Collection[str] = ()) -> tuple[Caveat, ...]:
    """Return the caveats about the scans and other inputs of a study.

    If files of scans are missing, only the caveats about mu0, tau0 and the interface are returned.

    `alternatives` contains the names of the alternative preparations that the interval includes.
    """
    surfaces = study.surfaces
    if surfaces.kind != "measured":
        return ()
    try:
        upper, lower = surfaces.upper.read(), surfaces.lower.read()
    except (ValueError, OSError):
        return tuple(_find_strength_caveats(study))
    return find_input_caveats(upper, lower, study, [float(load) for load in study.friction.load], alternatives)


def find_alternatives(study: Study) -> list[AlternativeName]:
    """Return the names of other preparations of the scans whose coefficients the reported interval must include.

    Scans with spikes require one alternative, and scans with a blunt tip another one. Bodies with a hardness need the
    tip alternative because the interval of their true area does not include finer roughness. Raises a `ValueError` if a
    file cannot be read.
    """
    surfaces: Any = study.surfaces
    quoted_cutoff = surfaces.reported_cut_off()
    scans = [
        (settings, find_scan_defects(body, settings.tip, textured=settings.texture is not None))
        for side in SIDES
        for settings in getattr(surfaces, side).scans
        if not isinstance(body := settings.read(), JoinedSpectrum)
    ]
    names: list[AlternativeName] = []
    if any(settings.outliers == "keep" and defects.num_spikes for settings, defects in scans):
        names.append(SPIKES_ALTERNATIVE)
    if not (study.is_gap or surfaces.vouched) and any(
        not defects.body.is_flat and defects.find_tip_limit(settings.select_cut_off_of_scan(quoted_cutoff)) is not None
        for settings, defects in scans
    ):
        names.append(TIP_ALTERNATIVE)
    return names


def _get_axis_extents(body: MeasuredBody) -> tuple[float, float]:
    """Return the lengths (µm) of a body along its two axes.

    A profile is 1 µm wide, and the extents of a spectrum are infinite.
    """
    if isinstance(body, JoinedSpectrum):
        return np.inf, np.inf
    return (1.0, body.extent) if isinstance(body, Profile) else body.extent


def have_different_spectra(joined: JoinedSpectrum) -> bool:
    """Return whether the spectral density of any scan differs significantly from the others, by over a factor of 2."""
    with np.errstate(invalid="ignore"):
        return bool(
            (
                np.abs(np.log(joined.disagreement)) - 2 * joined.chance > math.log(MAX_DENSITY_RATIO_OF_JOINED_SPECTRA)
            ).any()
        )


def _find_spectrum_caveats(spectrum: JoinedSpectrum) -> Iterator[Caveat]:
    """Yield caveats if scans of one surface have different spectra, or if some wavelengths are missing in all scans."""
    if have_different_spectra(spectrum):
        text = "scans of the surface differ by more than a factor of two in power"
        yield Caveat(text, "compare them with characterise --together, and exclude the wrong one", "caution")
    if (spectrum.count == 0).any():
        yield Caveat("some wavelengths are missing in all scans", "scan the missing wavelengths", "caution")


def _find_instrument_caveats(
    defects: ScanDefects, has_second_cutoff: bool, elastic: bool, has_tip_estimate: bool, cut_off: float
) -> Iterator[Caveat]:
    """Yield caveats about wavelengths that come from the instrument, or that its tip does not resolve."""
    try:
        limit, tip_limit = defects.instrument_limit, defects.find_tip_limit(cut_off)
    except ValueError:
        return
    if 0 < cut_off < limit.cut_off and limit.slope_fraction > 0 and not has_second_cutoff:
        # If the filter of a scan removes only part of its noise, only the noise that the filter transmits is assessed.
        limit = replace(limit, slope_fraction=defects.find_noise_slope_fraction(cut_off))
    shortest_resolved = limit.wavelength if limit.slope_fraction > MAX_NOISE_SLOPE_FRACTION else 0.0
    if shortest_resolved:
        is_known = limit.origin == "instrument"
        source = "where" if is_known else "perhaps from the instrument:"
        text = f"{_describe_slope_fraction(limit)}, {source} {INSTRUMENT_LIMIT_REASON_TEXTS[limit.reason]}"
        remedy = f"--cutoff '{format_with_unit(limit.cut_off, 'um')}' removes this fraction"
        if limit.matters:
            remedy += ", --cutoff none keeps it" if is_known else CUTOFF_REMEDY
            if is_known and defects.textured:
                remedy += "; --texture concerns lines and humps only"
        severity: Severity = "fault" if limit.matters and not (is_known and has_second_cutoff) else "caution"
        yield Caveat(text, remedy, severity, limit.cut_off, has_second_cutoff and limit.matters)
    if (hidden_noise := defects.hidden_noise) is not None:
        text = (
            f"noise or aliasing may contribute {100 * hidden_noise.slope_fraction:.0f} % of the mean square slope: the "
            "spectrum flattens at short wavelengths"
        )
        remedy = (
            f"--cutoff '{format_with_unit(hidden_noise.cut_off, 'um')}' removes this fraction, --cutoff none keeps it"
        )
        yield Caveat(text, f"{remedy}; {REPEATED_SCANS_REMEDY}", "caution", hidden_noise.cut_off, has_second_cutoff)
    if tip_limit is not None:
        text = f"{_describe_slope_fraction(tip_limit)}, which the tip does not resolve: the surface is steeper"
        note = f", and the interval {'includes an estimate of' if has_tip_estimate else 'does not include'} this"
        note = note if elastic or has_tip_estimate else ""
        # Without a hardness, the true area has no lower limit, because finer scans have ever steeper slopes.
        peak_severity: Severity = "fault" if elastic and tip_limit.matters else "caution"
        remedy = "use a sharper tip" + (", or specify a hardness" if elastic else "")
        # A Gaussian filter with the combined cutoff equals two successive filters, one at each cutoff.
        combined_cutoff = math.hypot(cut_off, tip_limit.cut_off)
        yield Caveat(text, remedy, peak_severity, combined_cutoff, interval_note=note)
    body = defects.body_without_outliers
    if not isinstance(body, Profile):
        return
    spectrum = power_spectrum(body, periodic=True) if defects.periodic else power_spectrum(levelled(body, "line"))
    peak = find_spectral_peak(spectrum)
    if peak is not None and peak[1] >= MAX_SPECTRAL_PEAK_FRACTION and peak[0] > shortest_resolved:
        fraction_text, wavelength_text = format_percent(peak[1]), format_with_unit(peak[0], "um")
        text = f"a peak at {wavelength_text}, perhaps from the instrument, contributes {fraction_text} of the curvature"
        yield Caveat(
            text,
            f"--cutoff '{format_with_unit(CUTOFF_TO_REMOVED_WAVELENGTH_RATIO * peak[0], 'um')}' removes the peak",
            "caution",
            peak[0],
        )


def _describe_slope_fraction(limit: InstrumentLimit) -> str:
    """Return a clause that states how much of the mean square slope comes from wavelengths too short to be reliable."""
    # The fraction is rounded to whole per cent, so that similar scans get caveats with the same text.
    fraction_text = f"{100 * limit.slope_fraction:.0f} %"
    axis_text = f" along {limit.axis}" if limit.axis else ""
    wavelength_text = format_with_unit(limit.wavelength, "um")
    return f"{fraction_text} of the mean square slope comes from wavelengths below {wavelength_text}{axis_text}"


def _find_form_caveats(defects: ScanDefects, *, form: bool, step: bool, has_masked_result: bool) -> Iterator[Caveat]:
    body = defects.body
    height, extent = float(np.ptp(body.heights)), float(np.min(body.extent))
    if height > extent / 2:
        text = f"heights span {format_with_unit(height, 'um')} on a length of {format_with_unit(extent, 'um')}"
        yield Caveat(
            text, "check the unit of heights", "fault" if height > MAX_HEIGHT_OVER_EXTENT * extent else "caution"
        )
    dominant_step = find_dominant_step(body) if step else None
    if dominant_step is not None and dominant_step.fraction > MAX_STEP_MEAN_SQUARE_FRACTION:
        text = (
            f"a step of {format_with_unit(dominant_step.height, 'um')} contributes "
            f"{100 * dominant_step.fraction:.0f} % of the mean square height, and one side of the step carries the load"
        )
        yield Caveat(text, "press one side of the step only (--crop)", "caution")
    elif form and (parabola_fraction := _compute_parabola_fraction(body)) > MAX_PARABOLA_HEIGHT_FRACTION:
        percentage = f"{100 * parabola_fraction:.0f} %"
        text = f"form (a parabola) contributes {percentage} of the mean square height, and carries the load"
        yield Caveat(text, "try --level quadratic", "caution")
    if num_spikes := defects.num_spikes:
        points_text, possessive_pronoun = (
            ("1 point is", "its") if num_spikes == 1 else (f"{num_spikes} points are", "their")
        )
        description = (
            f"more than {MIN_SPIKE_SHARPNESS_RATIO:g} times as sharp as usual"
            if isinstance(body, Profile)
            else f"more than {MIN_SPIKE_HEIGHT_RATIO:g} rms heights from {possessive_pronoun} neighbours"
        )
        text = f"{points_text} {description}, and would come into contact first"
        note = "; the interval includes the result for masked outliers" if has_masked_result else ""
        remedy = (
            "if it is an instrument spike, remove it (--outliers mask)"
            if num_spikes == 1
            else "if they are instrument spikes, remove them (--outliers mask)"
        )
        yield Caveat(text, remedy, "caution", interval_note=note)


def _compute_parabola_fraction(body: Profile | Surface) -> float:
    """Return the fraction of the mean square height that a least-squares parabola explains.

    Returns 0 for a flat profile, and for a map whose form is not dominated by a parabola.
    """
    if not isinstance(body, Profile):
        return measure_parabola_fraction(body)
    levelled_heights = levelled(body, "line").heights
    if np.ptp(levelled_heights) == 0:
        return 0.0
    return float(1 - levelled(body, "quadratic").heights.var() / levelled_heights.var())
