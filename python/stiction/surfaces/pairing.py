"""Two scans as a slider and what it is carried over: lines that are paired, levelled and brought to one grid."""

from __future__ import annotations

from typing import Literal

from stiction._checks import choice, number, whole_number
from stiction.surfaces.preparation import ProfileTrend, cropped, levelled, resampled, turned_over
from stiction.surfaces.profile import Along, Profile, Side
from stiction.surfaces.self_affine import surrogate
from stiction.surfaces.surface import Surface

LINES = 128
"""Pairs of lines by default: a second or two of computing, and enough for an interval."""

Surrogates = Literal["none", "upper", "lower", "both"]


def paired_lines(
    upper: Profile | Surface,
    lower: Profile | Surface,
    *,
    travel: float | None = None,
    level: ProfileTrend | None = "line",
    lines: int = LINES,
    along: Along = "x",
    surrogates: Surrogates = "none",
    seed: int = 2016,
) -> tuple[list[Profile], list[Profile]]:
    """Two scans as what `traverse` takes: sliders, turned over, and what they are carried over, a pair for each line.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Scans, both with heights out of the material; of different grids the finer is taken for both.
    travel : float, µm, optional
        The largest offset that shall be possible: sliders are shortened to leave it. By default one pair has half of
        the lower profile, or what the upper one leaves of it. Several pairs have none: of lines of different lengths
        the longer is cut to the shorter, each at another place, so that together they are from all over it.
    level : {"line", "mean", "quadratic"} or None
        What is taken off each line, and off each slider once more when it has its length, so that it lies level.
    lines : int
        How many pairs of lines are taken from surfaces, in equal distances, or of surrogates; two profiles are one
        pair. Lines of two surfaces are a third of their width apart, so that a surface can be paired with itself.
    along : {"x", "y"}
        Whether lines of surfaces are rows or columns.
    surrogates : {"none", "upper", "lower", "both"}
        Which of the two are replaced by their `surrogate`, a new one for each line.
    seed : int
        Of the surrogates.

    Returns
    -------
    (list of Profile, list of Profile)
        All sliders on the same grid, and so are the lower profiles.

    Raises
    ------
    ValueError
        If an argument is outside its range, or travel leaves less than half of the shorter profile as a slider.
    """
    choice("along", along, Along)
    choice("surrogates", surrogates, Surrogates)
    if level is not None:
        choice("level", level, ProfileTrend)
    count = whole_number("lines", lines, least=1)
    both = isinstance(upper, Surface) and isinstance(lower, Surface)
    if surrogates == "none":
        count = min([count, *(_width(each, along) for each in (upper, lower) if isinstance(each, Surface))])
        if isinstance(upper, Profile) and isinstance(lower, Profile):
            count = 1
    uppers = _lines("upper", upper, count, along)
    lowers = _lines("lower", lower, count, along, apart=both)
    spacing = min(uppers[0].spacing, lowers[0].spacing)
    for repetition in range(count):
        above, below = uppers[repetition], lowers[repetition]
        if level is not None:
            above, below = levelled(above, level), levelled(below, level)
        if surrogates in ("upper", "both"):
            above = _stand_in(above, seed, repetition, "upper")
        if surrogates in ("lower", "both"):
            below = _stand_in(below, seed, repetition, "lower")
        uppers[repetition] = resampled(turned_over(above), spacing)
        lowers[repetition] = resampled(below, spacing)
    points, track = len(uppers[0]), len(lowers[0])
    if travel is None:
        if count > 1:
            return _of_one_length(uppers, lowers, level)
        left = max(track - points, track // 2)
    else:
        left = round(number("travel", travel, unit="µm") / spacing)
    slider = min(points, track - left)
    if left < 0 or 2 * slider < min(points, track) - 1:
        most = (track - min(points, track) // 2) * spacing
        raise ValueError(f"travel must be from 0 to {most:g} µm, or too little is left of the slider, got {travel!r}")
    uppers = [each if slider == points else cropped(each, 0.0, slider * spacing) for each in uppers]
    return [each if level is None else levelled(each, level) for each in uppers], lowers


def _of_one_length(
    uppers: list[Profile], lowers: list[Profile], level: ProfileTrend | None
) -> tuple[list[Profile], list[Profile]]:
    """Pairs of which the longer profile is cut to the shorter, at places all over it, and levelled again."""
    length = min(len(uppers[0]), len(lowers[0]))

    def cut(profile: Profile, place: float) -> Profile:
        first = round(place * (len(profile) - length))
        if len(profile) == length:
            return profile
        piece = cropped(profile, first * profile.spacing, (first + length) * profile.spacing)
        return piece if level is None else levelled(piece, level)

    # Multiples of the golden ratio: neighbouring pairs lie apart, and any number of them is evenly spread.
    places = [pair * _GOLDEN % 1 for pair in range(len(uppers))]
    pairs = zip(uppers, lowers, places, strict=True)
    cuts = [(cut(upper, place), cut(lower, place)) for upper, lower, place in pairs]
    return [upper for upper, _ in cuts], [lower for _, lower in cuts]


_GOLDEN = (5**0.5 - 1) / 2


def _width(surface: Surface, along: Along) -> int:
    """Lines of a surface."""
    return int(surface.heights.shape[0 if along == "x" else 1])


def _lines(name: str, body: Profile | Surface, count: int, along: Along, *, apart: bool = False) -> list[Profile]:
    """So many lines in equal distances, beginning with the first, or a third of the width on and going round."""
    if isinstance(body, Profile):
        return [body] * count
    if not isinstance(body, Surface):
        raise ValueError(f"{name} must be a Profile or a Surface, got {type(body).__name__}")
    line = body.row if along == "x" else body.column
    width = _width(body, along)
    start = max(width // 3, 1) if apart else 0
    return [line((start + place * width // count) % width) for place in range(count)]


def _stand_in(profile: Profile, seed: int, repetition: int, side: Side) -> Profile:
    made = surrogate(profile, seed, repetition=repetition, side=side)
    step = f"replaced by its surrogate of seed {seed}, repetition {repetition}"
    return Profile(made.heights, spacing=made.spacing, history=(*profile.history, step))


def lower_piece(lower: Profile, offset: float, slider: Profile) -> Profile:
    """What is below a slider at an offset (µm)."""
    first = round(offset / lower.spacing)
    return Profile(lower.heights[first : first + len(slider)], spacing=lower.spacing)
