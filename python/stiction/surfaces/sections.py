"""Roughness and waviness parameters of a profile with the filters and setting classes of ISO 21920."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from stiction._checks import Floats, check_bool, check_choice, validate_number, validate_whole_number
from stiction._repr import format_with_unit
from stiction._units import short_repr
from stiction.surfaces.filters import gaussian_low_pass, robust_gaussian_low_pass
from stiction.surfaces.material_ratio import core_parameters, heights_at_material_ratios
from stiction.surfaces.parameters import PROFILE_PARAMETERS, RoughnessParameterSet
from stiction.surfaces.profile import Profile
from stiction.surfaces.profile_elements import mean_profile_element
from stiction.surfaces.roughness import (
    SEVEN_POINT_WEIGHTS,
    DerivativeFormula,
    describe_levelling,
    height_and_slope_parameters,
)
from stiction.surfaces.spectrum import ROUND_OFF_FACTOR
from stiction.surfaces.surface import BodyLike, as_body, reject_flat_body

DEFAULT_SECTION_COUNT = 5
_RDC_MATERIAL_RATIOS = 0.2, 0.8


class SettingClass(NamedTuple):
    """Setting class of ISO 21920: default cutoffs, tip radius, spacing, and upper limits of Ra and RSm (µm)."""

    name: str
    section_length: float
    short_cutoff: float
    tip_radius: float
    spacing: float
    largest_mean_height: float
    largest_element: float


SETTING_CLASSES = (
    SettingClass("Sc1", 80.0, 2.5, 2.0, 0.5, 0.02, 40.0),
    SettingClass("Sc2", 250.0, 2.5, 2.0, 0.5, 0.1, 130.0),
    SettingClass("Sc3", 800.0, 2.5, 2.0, 0.5, 2.0, 400.0),
    SettingClass("Sc4", 2500.0, 8.0, 5.0, 1.5, 10.0, 1300.0),
    SettingClass("Sc5", 8000.0, 25.0, 10.0, 5.0, math.inf, math.inf),
)
"""Setting classes of ISO 21920-3, selected by limits of Ra and, for periodic profiles, of RSm (as in ISO 4288)."""

_INITIAL_SETTING_CLASS_INDEX = 2


class SectionLengthError(ValueError):
    """Error raised if a profile is too short, or its spacing is too large, for sections of the required length."""


@dataclass(frozen=True, repr=False)
class SectionFilters:
    """Filter cutoffs and number of sections for computing R- and W-parameters, and the reason for these cutoffs.

    Attributes
    ----------
    lc : float, µm
        Cutoff wavelength λc between waviness and roughness, and section length.
    ls : float, µm, optional
        Cutoff wavelength λs of the S-filter; None if no S-filter is applied.
    sections : int
        Number of section lengths in the evaluation length.
    robust : bool
        True if the L-filter is the robust Gaussian regression.
    start, stop : int
        First point and exclusive end of the evaluation length.
    reason : str
        Reason for the choice of lc and ls.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, section_parameters
    >>> turned = Profile(np.sin(2 * np.pi * np.arange(10000) / 200), spacing=0.5)
    >>> section_parameters(turned).filters
    SectionFilters: lc 800 µm, ls 2.5 µm, 5 sections; Sc3 of ISO 21920-3, for Ra 0.6363 µm and RSm 100 µm
    """

    lc: float
    ls: float | None
    sections: int
    robust: bool
    start: int
    stop: int
    reason: str

    def __repr__(self) -> str:
        """Return a line with the cutoffs (µm), the number of sections, and the reason for the choice of the cutoffs."""
        ls_text = "no ls" if self.ls is None else f"ls {self.ls:g} µm"
        robust_text = ", robust" if self.robust else ""
        return f"SectionFilters: lc {self.lc:g} µm, {ls_text}, {self.sections} sections{robust_text}; {self.reason}"


@dataclass(frozen=True, repr=False)
class SectionParameters(RoughnessParameterSet):
    """Roughness parameters (R) and waviness parameters (W) of a profile, named as in ISO 21920-2.

    The reference page on roughness parameters lists the names, formulas and units.

    Attributes
    ----------
    filters : SectionFilters
        Cutoffs and evaluation length for which the parameters were computed.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, section_parameters
    >>> turned = Profile(np.sin(2 * np.pi * np.arange(10000) / 200), spacing=0.5)
    >>> round(section_parameters(turned).Rz, 2)
    2.0
    """

    filters: SectionFilters = None  # type: ignore[assignment]

    def _extra_table_rows(self) -> dict[str, str]:
        filters = self.filters
        ls_text = "none" if filters.ls is None else format_with_unit(filters.ls, "µm")
        settings_text = f"λc {format_with_unit(filters.lc, 'µm')}, λs {ls_text}, {filters.sections} sections"
        return super()._extra_table_rows() | {"filters": f"{settings_text}: {filters.reason}"}


def section_parameters(
    profile: BodyLike, *, lc: float | str | None = None, ls: float | str | None = None,
    sections: int = DEFAULT_SECTION_COUNT, robust: bool = False, derivative: DerivativeFormula = "seven-point",
    spacing: Any = None, unit: str = "um",
) -> SectionParameters:  # fmt: skip
    r"""Compute the roughness (R) and waviness (W) parameters of a profile, as technical drawings specify them.

    Parameters
    ----------
    profile : Profile or array_like of float
        Profile without form (see `levelled`). Missing points have no weight in the filters; the parameters use their
        interpolated heights.
    lc : float (µm) or str, optional
        Cutoff wavelength λc of the L-filter, which is also the section length. The default is that of the setting class
        (0.08, 0.25, 0.8, 2.5 or 8 mm), the larger of the lengths for Ra (up to 0.02, 0.1, 2, 10 µm and above) and for
        RSm (up to 0.04, 0.13, 0.4, 1.3 mm and above). The search starts at 0.8 mm, or at the longest section length
        that fits into the profile, and continues until the parameters belong to the class with which they were
        computed. If two neighbouring classes qualify, the shorter is used.
    ls : float (µm) or str, optional
        Cutoff wavelength λs of the S-filter; 0 for none. The default is that of the setting class, 2.5, 8 or 25 µm.
        There is no S-filter by default if λs is below two points or the section length belongs to no class.
    sections : int
        Largest number of sections that are evaluated, in the middle of the profile.
    robust : bool
        True to use the robust Gaussian regression filter for λc.
    derivative : {"seven-point", "neighbours"}
        As for `roughness_parameters`.
    spacing : float (µm) or str
        Distance between the points of an array, such as 0.5 or "39 nm"; required for arrays.
    unit : str
        Unit of the heights of an array.

    Returns
    -------
    parameters : SectionParameters
        R- and W-parameters (heights and widths in µm), and the filters that were used.

    Raises
    ------
    ValueError
        If the profile is shorter than one section length, or a cutoff is outside its range.

    See Also
    --------
    roughness_parameters : P-parameters, without filters.
    filtered : The filters.

    Notes
    -----
    The parameters are those of ISO 21920-2, with the defaults of ISO 21920-3.

    The waviness profile is the mean line of the L-filter, and the roughness profile is the deviation from it. Heights
    are measured from the mean line, not from their own mean. Rz, Rp and Rv are means over the sections; other
    R-parameters refer to the evaluation length. W-parameters refer to the whole profile, from which the form was
    removed.

    A profile element consists of a hill that rises above a tenth of Rp and a dale that falls below a tenth of Rv, in
    either order; see `profile_elements`. Rk, Rpk, Rvk, Rmrk1 and Rmrk2 use the same roughness profile as Ra.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, section_parameters
    >>> turned = Profile(np.sin(2 * np.pi * np.arange(10000) / 200), spacing=0.5)  # feed 0.1 mm
    >>> found = section_parameters(turned)
    >>> round(found.Ra, 2), round(found.RSm, 1), found.filters.reason
    (0.64, 100.0, 'Sc3 of ISO 21920-3, for Ra 0.6363 µm and RSm 100 µm')
    """
    profile = as_body("profile", profile, Profile, spacing=spacing, unit=unit)
    reject_flat_body(profile)
    check_choice("derivative", derivative, DerivativeFormula)
    check_bool("robust", robust)
    sections = validate_whole_number("sections", sections, minimum=1)
    short_cutoff = None if ls is None else validate_number("ls", ls, unit="µm")
    if short_cutoff is not None and short_cutoff < 0:
        raise ValueError(f"ls must be 0 or above, got {short_repr(ls)}")
    if lc is not None:
        result = _compute_with_cutoff(
            profile, validate_number("lc", lc, unit="µm", above=0), short_cutoff, sections, robust, derivative
        )
        return result
    return _compute_with_setting_class(profile, short_cutoff, sections, robust, derivative)


def _compute_with_setting_class(
    profile: Profile, ls: float | None, sections: int, robust: bool, derivative: DerivativeFormula
) -> SectionParameters:
    """Compute R- and W-parameters with the setting class (ISO 21920) that belongs to the resulting Ra and RSm."""
    section_lengths = [setting.section_length for setting in SETTING_CLASSES]
    if section_lengths[0] > profile.extent * ROUND_OFF_FACTOR:
        raise SectionLengthError(_format_too_short_message(profile, section_lengths[0]))
    min_length, max_length = _min_section_length(profile.spacing), profile.extent * ROUND_OFF_FACTOR
    possible_classes = [
        index
        for index, length in enumerate(section_lengths)
        if min_length <= length * ROUND_OFF_FACTOR and length <= max_length
    ]
    if not possible_classes:
        raise SectionLengthError(_format_too_coarse_message(profile))
    results_by_class: dict[int, SectionParameters] = {}

    def find_matching_setting_class(index: int) -> int:
        """Return the index of the setting class that matches Ra and RSm, both computed with setting class `index`."""
        if index not in results_by_class:
            lc = SETTING_CLASSES[index].section_length
            results_by_class[index] = _compute_with_cutoff(profile, lc, ls, sections, robust, derivative)
        result = results_by_class[index]
        class_by_height = next(
            k for k, setting in enumerate(SETTING_CLASSES) if result.Ra <= setting.largest_mean_height
        )
        class_by_element = next(
            k for k, setting_class in enumerate(SETTING_CLASSES) if not result.RSm > setting_class.largest_element
        )
        return max(class_by_height, class_by_element)

    index, visited_classes = (
        min(possible_classes, key=lambda item: abs(item - _INITIAL_SETTING_CLASS_INDEX)),
        set[int](),
    )
    while (matching_class := find_matching_setting_class(index)) != index and index not in visited_classes:
        visited_classes.add(index)
        next_class = index + 1 if matching_class > index else index - 1
        if next_class not in possible_classes:
            remedy = (
                _format_too_short_remedy(profile) if matching_class > index else _format_too_coarse_message(profile)
            )
            raise SectionLengthError(
                f"{_format_setting_class_reasons(results_by_class[index])} require a section length of "
                f"{_format_length(section_lengths[matching_class])}; {remedy}"
            )
        index = next_class
    # If two neighbouring setting classes each give results that belong to the other class, the higher class is used.
    if matching_class != index:
        index = max(index, max(visited_classes & {index - 1, index, index + 1}))
    elif index - 1 in possible_classes and find_matching_setting_class(index - 1) == index - 1:
        index -= 1
    result = results_by_class[index]
    reason = f"{SETTING_CLASSES[index].name} of ISO 21920-3, for {_format_setting_class_reasons(result)}"
    return replace(result, filters=replace(result.filters, reason=reason))


def _format_setting_class_reasons(parameters: SectionParameters) -> str:
    """Format the Ra and RSm that determine a profile's setting class, as in "Ra 0.4 µm and RSm 50 µm"."""
    spacing_text = "" if math.isnan(parameters.RSm) else f" and RSm {format_with_unit(parameters.RSm, 'µm')}"
    return f"Ra {format_with_unit(parameters.Ra, 'µm')}{spacing_text}"


def _format_length(length: float) -> str:
    return format_with_unit(length, "µm")


def _min_section_length(spacing: float) -> float:
    """Return the length (µm) of the shortest section: seven points at `spacing` (µm), as the slope formula requires."""
    return SEVEN_POINT_WEIGHTS.size * spacing


def _format_too_short_message(profile: Profile, length: float) -> str:
    return f"one section length is {_format_length(length)}, and {_format_too_short_remedy(profile)}"


def _format_too_short_remedy(profile: Profile) -> str:
    return f"the profile is {_format_length(profile.extent)} long: measure a longer one, or choose a shorter cutoff lc"


def _format_too_coarse_message(profile: Profile) -> str:
    return (
        f"its points are {_format_length(profile.spacing)} apart, and a section needs at least "
        f"{SEVEN_POINT_WEIGHTS.size}: measure more finely, or choose a longer cutoff lc"
    )


def _compute_with_cutoff(
    profile: Profile, lc: float, ls: float | None, sections: int, robust: bool, derivative: DerivativeFormula
) -> SectionParameters:
    """Compute R- and W-parameters with the cutoff λc = `lc` (µm), which is also the section length."""
    spacing = profile.spacing
    if lc > profile.extent * ROUND_OFF_FACTOR:
        raise SectionLengthError(_format_too_short_message(profile, lc))
    if lc * ROUND_OFF_FACTOR < _min_section_length(spacing):
        raise ValueError(
            f"lc must be at least {_min_section_length(spacing):g} µm ({SEVEN_POINT_WEIGHTS.size} points), "
            f"got {lc:g} µm"
        )
    is_ls_given = ls is not None
    if ls is None:
        ls = next(
            (setting.short_cutoff for setting in SETTING_CLASSES if math.isclose(setting.section_length, lc)), 0.0
        )
        ls = ls if ls >= 2 * spacing else 0.0
    elif ls and not 2 * spacing <= ls * ROUND_OFF_FACTOR <= lc:
        raise ValueError(
            f"ls must be 0, or between {2 * spacing:g} µm (two grid spacings) and {lc:g} µm (lc), got {ls:g} µm"
        )
    primary_profile = (
        profile.changed(gaussian_low_pass(profile, ls, samples_weights=True), "S-filter") if ls else profile
    )
    waviness = (
        robust_gaussian_low_pass(primary_profile, lc)
        if robust
        else gaussian_low_pass(primary_profile, lc, samples_weights=True)
    )
    section_count = min(sections, math.floor(profile.extent / lc * ROUND_OFF_FACTOR))
    points = min(round(section_count * lc / spacing), len(profile))
    start = (len(profile) - points) // 2
    evaluation_range = slice(start, start + points)
    roughness = (primary_profile.heights - waviness)[evaluation_range]
    section_ends = [min(round(index * lc / spacing), points) for index in range(section_count + 1)]
    values = {
        f"R{stem}": value
        for stem, value in _compute_roughness_values(roughness, section_ends, spacing, derivative).items()
    } | {f"W{stem}": value for stem, value in _compute_waviness_values(waviness, spacing, derivative).items()}
    names = [parameter.name for letter in "RW" for parameter in PROFILE_PARAMETERS[letter]]
    reason = f"lc{' and ls' * is_ls_given} given"
    filters = SectionFilters(lc, ls or None, section_count, robust, start, start + points, reason)
    return SectionParameters({name: values[name] for name in names}, describe_levelling(profile.history), filters)


def _compute_roughness_values(
    z: Floats, ends: list[int], spacing: float, derivative: DerivativeFormula
) -> dict[str, float]:
    section_heights = [z[start:stop] for start, stop in itertools.pairwise(ends)]
    peak, pit = (float(np.mean([(sign * heights).max() for heights in section_heights])) for sign in (1, -1))
    mean_spacing, mean_height = mean_profile_element(z, peak, pit)
    core, (upper, lower) = core_parameters(z), heights_at_material_ratios(z, _RDC_MATERIAL_RATIOS).tolist()
    values: dict[str, Any] = {
        "z": peak + pit, "p": peak, "v": pit, "Sm": mean_spacing * spacing, "c": mean_height,
        "mr": float(np.mean(z > 0)),
        "dc": upper - lower, "k": core.core_height, "pk": core.reduced_peak_height, "vk": core.reduced_pit_depth,
        "mrk1": core.upper_core_ratio, "mrk2": core.lower_core_ratio,
    }  # fmt: skip
    return height_and_slope_parameters(z, spacing, derivative) | values


def _compute_waviness_values(z: Floats, spacing: float, derivative: DerivativeFormula) -> dict[str, float]:
    mean_spacing, mean_height = mean_profile_element(z, float(z.max()), float(-z.min()))
    return height_and_slope_parameters(z, spacing, derivative) | {"Sm": mean_spacing * spacing, "c": mean_height}
