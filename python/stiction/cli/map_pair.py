"""`stiction pair` of two maps: their areas are pressed."""

from __future__ import annotations

import functools
import time
from pathlib import Path
from typing import Any

import numpy as np

from stiction.cli.application import say, tell
from stiction.cli.options import check_directory, leave_pair
from stiction.mechanics.half_space import half_space
from stiction.studies.executors import available_cores
from stiction.studies.map_pair import COMPASS, Pieces, joined, means_of_all, pressed_maps, with_picture
from stiction.surfaces.preparation import SurfaceTrend, levelled, on_common_grid, rotated, turned_over
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

AROUND = 10**0.5
"""Ratio of a load that is asked for to those that are solved below and above it, for a curve."""


def prepared(upper: Surface, lower: Surface, *, level: SurfaceTrend, angle: float | None) -> tuple[Surface, Surface]:
    """Two scans as `pressed_maps` takes them."""
    above, below = levelled(upper, level), levelled(lower, level)
    if angle is not None:
        above = rotated(above, angle)
    return on_common_grid(turned_over(above), below)


def map_level(level: str | None) -> SurfaceTrend:
    """What is taken off maps and their pieces."""
    if level not in (None, "plane", "quadratic"):
        raise ValueError(f"--level of maps must be plane or quadratic, got {level!r}; every piece is levelled anyway")
    return "quadratic" if level == "quadratic" else "plane"


def press_areas(
    upper: Surface | Profile,
    lower: Surface | Profile,
    wanted: list[tuple[float, bool]],
    *,
    mechanics: tuple[str, ...],
    mu0: list[float],
    tau0: list[float],
    effective_modulus: float,
    compliance_share: float,
    hardness: float | None,
    directions: list[float] | None,
    shifts: int | None,
    surrogates: int | None,
    seed: int,
    level: SurfaceTrend,
    files: str,
    output: Path,
    table: Path,
    replace: bool,
    as_json: bool,
) -> None:
    """Press, print, write and draw."""
    from stiction.views import map_pair as views

    chosen: dict[str, Any] = {"shifts": shifts, "surrogates": surrogates, "seed": seed, "level": level}
    places = Pieces.of(upper, lower, **chosen)
    area = places.area
    loads = [amount * (area if per_area else 1.0) for amount, per_area in wanted]
    if hardness is not None and max(loads) >= hardness * area:
        raise ValueError(f"--load must be below the hardness times the area, {hardness * area:.4g} mN")
    check_directory(output, table, replace=replace)
    around = _loads_around(loads, None if hardness is None else hardness * area)
    elastic: dict[str, Any] = {"effective_modulus": effective_modulus, "compliance_share": compliance_share}
    bodies = {"upper": upper, "lower": lower}
    for sentence in views.map_doubts(bodies, loads, area, mu0=mu0, effective_modulus=effective_modulus):
        say(sentence)
    if "half-space" in mechanics:
        _say_what_it_costs(places, around[-1], len(around), **elastic, hardness=hardness)
    results = [
        pressed_maps(
            upper, lower, around, mu0=mu0, tau0=tau0, directions=COMPASS if directions is None else directions,
            mechanics=each,  # type: ignore[arg-type]
            hardness=hardness if each == "half-space" else None, progress=True, **chosen, **elastic,
        )
        for each in mechanics
    ]  # fmt: skip
    result = joined(results, mechanics, loads)
    result.attrs |= {"loads_mN": np.array(loads), "files": files}
    shift = views.typical_shift(result, loads[0])
    if shift is not None:
        result = with_picture(result, places, shift, loads[0], hardness=hardness, **elastic)
    mean = means_of_all(result)
    show_map_pair(result, as_json=as_json)
    draw = functools.partial(views.save_map_pair_figures, result, mean, loads, output)
    leave_pair(result, table, views.map_pair_csv(mean, loads), draw, replace=replace, as_json=as_json)


def _loads_around(loads: list[float], most: float | None) -> list[float]:
    """Those that are asked for and, for a curve, one below and one above all of them."""
    around = [min(loads) / AROUND, *loads, max(loads) * AROUND]
    return sorted({load for load in around if most is None or load < most})


def _say_what_it_costs(places: Pieces, load: float, loads: int, **elastic: Any) -> None:
    """How long all solutions take, from one of them."""
    pair = places.pair(0)
    points = " x ".join(str(each) for each in places.shape)
    words = f"half-space: {len(places) * loads} solutions of {points} points"
    started = time.perf_counter()
    try:
        curve = half_space(*pair, [load], direction=COMPASS, **elastic)
        curve.with_sliding("all")
        np.isfinite(curve.stiffness)  # computed when asked for
    except RuntimeError:
        say(f"{words}; the first does not reach its tolerance")
        return
    seconds = (time.perf_counter() - started) * len(places) * loads / available_cores()
    say(f"{words}, about {seconds:.2g} s by the first; --mechanics asperities is faster")


def show_map_pair(result: Any, *, as_json: bool = False) -> None:
    """The table of a pair of maps, or its values as JSON."""
    from stiction.views.map_pair import map_pair_text
    from stiction.views.records import pair_record

    loads, mean = np.atleast_1d(result.attrs["loads_mN"]), means_of_all(result)
    tell(pair_record(mean, loads) if as_json else map_pair_text(result, mean, loads))


def draw_map_pair(result: Any, directory: Path) -> None:
    """The figures of a pair of maps."""
    from stiction.views.map_pair import save_map_pair_figures

    loads = np.atleast_1d(result.attrs["loads_mN"])
    for path in save_map_pair_figures(result, means_of_all(result), loads, directory):
        tell(f"wrote {path}")
