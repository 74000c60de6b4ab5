"""Roughness and waviness parameters of a profile: filters, section lengths and setting classes of ISO 21920."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from stiction._checks import Floats, check_bool, check_choice, number, whole_number
from stiction._repr import with_unit
from stiction.surfaces.filters import gaussian_mean, robust_mean
from stiction.surfaces.material_ratio import core_parameters, heights_at
from stiction.surfaces.parameters import PROFILE_PARAMETERS, ParameterSet
from stiction.surfaces.profile import Profile
from stiction.surfaces.profile_elements import mean_element
from stiction.surfaces.roughness import SEVEN_POINTS, Derivative, describe_levelling, profile_moments
from stiction.surfaces.spectrum import ROUND_OFF_FACTOR
from stiction.surfaces.surface import BodyLike, as_body, reject_flat

DEFAULT_SECTIONS = 5  # section lengths in the evaluation length by default
_HEIGHT_DIFFERENCE = 0.2, 0.8  # material ratios of Rdc


class SettingClass(NamedTuple):
    """Default settings of a setting class, and the largest Ra and RSm that it is for; lengths in µm."""

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
"""Setting classes of ISO 21920-3, with the limits of Ra and, of periodic profiles, RSm that ISO 4288 chooses by."""

_FIRST_CLASS = 2  # class that the search for the right one starts from


class SectionError(ValueError):
    """A profile is too short or too coarse for the section length."""


@dataclass(frozen=True, repr=False)
class SectionFilters:
    """Filters and sections of roughness and waviness parameters, and the reason for them.

    Attributes
    ----------
    lc : float, µm
        Cutoff wavelength between waviness and roughness, λc: the section length.
    ls : float, µm, optional
        Cutoff wavelength of the S-filter, λs; None without one.
    sections : int
        Section lengths in the evaluation length.
    robust : bool
        Whether the L-filter is the robust Gaussian regression.
    start, stop : int
        First point of the evaluation length, and the point behind its last.
    reason : str
        How lc and ls were chosen.

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
        """Return cutoffs (µm), number of sections and the reason in one line."""
        shortest = "no ls" if self.ls is None else f"ls {self.ls:g} µm"
        kind = ", robust" if self.robust else ""
        return f"SectionFilters: lc {self.lc:g} µm, {shortest}, {self.sections} sections{kind}; {self.reason}"


@dataclass(frozen=True, repr=False)
class SectionParameters(ParameterSet):
    """Parameters of the roughness profile (R) and the waviness profile (W) of ISO 21920-2.

    Attributes
    ----------
    filters : SectionFilters
        Cutoffs and evaluation length that the values hold for.

    See the table of parameters for names, formulas and units.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, section_parameters
    >>> turned = Profile(np.sin(2 * np.pi * np.arange(10000) / 200), spacing=0.5)
    >>> round(section_parameters(turned).Rz, 2)
    2.0
    """

    filters: SectionFilters = None  # type: ignore[assignment]

    def _shown_words(self) -> dict[str, str]:
        found = self.filters
        short = "none" if found.ls is None else with_unit(found.ls, "µm")
        lengths = f"λc {with_unit(found.lc, 'µm')}, λs {short}, {found.sections} sections"
        return super()._shown_words() | {"filters": f"{lengths}: {found.reason}"}


def section_parameters(
    profile: BodyLike, *, lc: float | str | None = None, ls: float | str | None = None,
    sections: int = DEFAULT_SECTIONS, robust: bool = False, derivative: Derivative = "seven-point",
    spacing: Any = None, unit: str = "um",
) -> SectionParameters:  # fmt: skip
    r"""Compute the R- and W-parameters of a profile as on drawings, by ISO 21920-2 with the defaults of ISO 21920-3.

    Parameters
    ----------
    profile : Profile or array_like of float
        Without form (see `levelled`). Missing points have no weight in the filters; the parameters take the heights
        that bridge them.
    lc : float, µm, optional
        Cutoff wavelength λc of the L-filter, which is also the section length. By default that of the setting class
        (0.08, 0.25, 0.8, 2.5 or 8 mm) that Ra (up to 0.02, 0.1, 2, 10 µm and above) and RSm (up to 0.04, 0.13, 0.4,
        1.3 mm and above) call for, the larger of both. The search starts at 0.8 mm, or the longest that the profile
        holds, and goes class by class until the parameters fit to the class that they were computed for; of two
        neighbouring classes that fit, it takes the shorter.
    ls : float, µm, optional
        Cutoff wavelength λs of the S-filter; 0 for none. By default that of the setting class, 2.5, 8 or 25 µm, and
        none where that is less than two points or the section length is of no class.
    sections : int
        Largest number of sections to evaluate, from the middle of the profile.
    robust : bool
        Take the robust Gaussian regression filter for λc.
    derivative : {"seven-point", "neighbours"}
        As for `roughness_parameters`.
    spacing, unit : optional
        Distance between the points of an array, and the unit of its heights.

    Returns
    -------
    SectionParameters

    Raises
    ------
    ValueError
        If the profile is shorter than one section length, or a cutoff is outside its range.

    Notes
    -----
    The waviness profile is the mean line of the L-filter, and the roughness profile the deviation from it. Heights are
    measured from the mean line and not from their own mean. Rz, Rp and Rv are means over the sections, other
    R-parameters are taken over the evaluation length, and W-parameters over the whole profile, from which the form was
    removed.

    A profile element is a hill that rises above a tenth of Rp and a dale that falls below a tenth of Rv, in either
    order; see `profile_elements`. Rk, Rpk, Rvk, Rmrk1 and Rmrk2 take the same roughness profile as Ra.

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
    reject_flat(profile)
    check_choice("derivative", derivative, Derivative)
    check_bool("robust", robust)
    sections = whole_number("sections", sections, minimum=1)
    short = None if ls is None else number("ls", ls, unit="µm")
    if short is not None and short < 0:
        raise ValueError(f"ls must be 0 or above, got {ls!r}")
    if lc is not None:
        found = _with_cutoff(profile, number("lc", lc, unit="µm", above=0), short, sections, robust, derivative)
        return found
    return _by_class(profile, short, sections, robust, derivative)


def _by_class(
    profile: Profile, ls: float | None, sections: int, robust: bool, derivative: Derivative
) -> SectionParameters:
    """Compute the parameters for the setting class that fits to the Ra and RSm that it gives."""
    lengths = [each.section_length for each in SETTING_CLASSES]
    if lengths[0] > profile.extent * ROUND_OFF_FACTOR:
        raise SectionError(_too_short(profile, lengths[0]))
    fine, long = _fewest_points(profile.spacing), profile.extent * ROUND_OFF_FACTOR
    fitting = [index for index, length in enumerate(lengths) if fine <= length * ROUND_OFF_FACTOR and length <= long]
    if not fitting:
        raise SectionError(_too_coarse(profile))
    known: dict[int, SectionParameters] = {}

    def fitted(index: int) -> int:
        """Return the class of the Ra and RSm that a class gives."""
        if index not in known:
            lc = SETTING_CLASSES[index].section_length
            known[index] = _with_cutoff(profile, lc, ls, sections, robust, derivative)
        found = known[index]
        by_height = next(k for k, each in enumerate(SETTING_CLASSES) if found.Ra <= each.largest_mean_height)
        by_element = next(k for k, each in enumerate(SETTING_CLASSES) if not found.RSm > each.largest_element)
        return max(by_height, by_element)

    index, visited = min(fitting, key=lambda each: abs(each - _FIRST_CLASS)), set[int]()
    while (wanted := fitted(index)) != index and index not in visited:
        visited.add(index)
        following = index + 1 if wanted > index else index - 1
        if following not in fitting:
            why = _longer(profile) if wanted > index else _too_coarse(profile)
            raise SectionError(
                f"{_reasons(known[index])} call for a section length of {_words(lengths[wanted])}; {why}"
            )
        index = following
    if wanted != index:  # two classes call for each other
        index = max(index, max(visited & {index - 1, index, index + 1}))
    elif index - 1 in fitting and fitted(index - 1) == index - 1:
        index -= 1
    found = known[index]
    reason = f"{SETTING_CLASSES[index].name} of ISO 21920-3, for {_reasons(found)}"
    return replace(found, filters=replace(found.filters, reason=reason))


def _reasons(found: SectionParameters) -> str:
    """Return Ra and RSm in words."""
    elements = "" if math.isnan(found.RSm) else f" and RSm {with_unit(found.RSm, 'µm')}"
    return f"Ra {with_unit(found.Ra, 'µm')}{elements}"


def _words(length: float) -> str:
    return with_unit(length, "µm")


def _fewest_points(spacing: float) -> float:
    """Return the shortest section length for a spacing."""
    return SEVEN_POINTS.size * spacing


def _too_short(profile: Profile, length: float) -> str:
    return f"one section length is {_words(length)}, and {_longer(profile)}"


def _longer(profile: Profile) -> str:
    return f"the profile is {_words(profile.extent)} long: measure a longer one, or choose a shorter cutoff lc"


def _too_coarse(profile: Profile) -> str:
    return (
        f"its points are {_words(profile.spacing)} apart, and a section needs at least {SEVEN_POINTS.size}: "
        "measure more finely, or choose a longer cutoff lc"
    )


def _with_cutoff(
    profile: Profile, lc: float, ls: float | None, sections: int, robust: bool, derivative: Derivative
) -> SectionParameters:
    """Compute the parameters for a section length (µm)."""
    spacing = profile.spacing
    if lc > profile.extent * ROUND_OFF_FACTOR:
        raise SectionError(_too_short(profile, lc))
    if lc * ROUND_OFF_FACTOR < _fewest_points(spacing):
        raise ValueError(
            f"lc must be at least {SEVEN_POINTS.size} points, {_fewest_points(spacing):g} µm, got {lc:g} µm"
        )
    given = ls is not None
    if ls is None:
        ls = next((each.short_cutoff for each in SETTING_CLASSES if math.isclose(each.section_length, lc)), 0.0)
        ls = ls if ls >= 2 * spacing else 0.0
    elif ls and not 2 * spacing <= ls * ROUND_OFF_FACTOR <= lc:
        raise ValueError(f"ls must be 0 or from two points, {2 * spacing:g} µm, to lc, {lc:g} µm, got {ls:g} µm")
    primary = profile if not ls else profile.changed(gaussian_mean(profile, ls), "S-filter")
    waviness = robust_mean(primary, lc) if robust else gaussian_mean(primary, lc)
    count = min(sections, math.floor(profile.extent / lc * ROUND_OFF_FACTOR))
    points = min(round(count * lc / spacing), len(profile))
    start = (len(profile) - points) // 2
    inside = slice(start, start + points)
    roughness = (primary.heights - waviness)[inside]
    ends = [min(round(index * lc / spacing), points) for index in range(count + 1)]
    values = {f"R{stem}": value for stem, value in _roughness(roughness, ends, spacing, derivative).items()} | {
        f"W{stem}": value for stem, value in _waviness(waviness, spacing, derivative).items()
    }
    names = [each.name for letter in "RW" for each in PROFILE_PARAMETERS[letter]]
    reason = f"lc{' and ls' * given} given"
    filters = SectionFilters(lc, ls or None, count, robust, start, start + points, reason)
    return SectionParameters({name: values[name] for name in names}, describe_levelling(profile.history), filters)


def _roughness(z: Floats, ends: list[int], spacing: float, derivative: Derivative) -> dict[str, float]:
    pieces = [z[start:stop] for start, stop in itertools.pairwise(ends)]
    peak, pit = (float(np.mean([(sign * piece).max() for piece in pieces])) for sign in (1, -1))
    apart, tall = mean_element(z, peak, pit)
    stratified, (upper, lower) = core_parameters(z), heights_at(z, _HEIGHT_DIFFERENCE).tolist()
    values: dict[str, Any] = {
        "z": peak + pit, "p": peak, "v": pit, "Sm": apart * spacing, "c": tall, "mr": float(np.mean(z > 0)),
        "dc": upper - lower, "k": stratified.height, "pk": stratified.peaks, "vk": stratified.valleys,
        "mrk1": stratified.upper_ratio, "mrk2": stratified.lower_ratio,
    }  # fmt: skip
    return profile_moments(z, spacing, derivative) | values


def _waviness(z: Floats, spacing: float, derivative: Derivative) -> dict[str, float]:
    apart, tall = mean_element(z, float(z.max()), float(-z.min()))
    return profile_moments(z, spacing, derivative) | {"Sm": apart * spacing, "c": tall}
