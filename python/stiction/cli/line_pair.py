"""`stiction pair` of profiles, and of lines of surfaces: one is carried over the other."""

from __future__ import annotations

import functools
import time
from pathlib import Path
from typing import Any

import numpy as np

from stiction.cli.application import say, tell
from stiction.cli.options import check_directory, leave_pair
from stiction.studies.executors import available_cores
from stiction.surfaces.pairing import lower_piece, paired_lines
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

OFFSETS = 64
"""Positions of one pair by default: some seconds of computing, and enough for an interval."""


def press_lines(
    upper: Profile | Surface,
    lower: Profile | Surface,
    wanted: list[tuple[float, bool]],
    *,
    mu0: list[float],
    tau0: list[float],
    effective_modulus: float,
    mechanics: tuple[str, ...],
    compliance_share: float,
    law: Any,
    detection: str,
    curvature: str,
    offsets: int | None,
    travel: float | None,
    level: str | None,
    lines: int,
    along: str,
    surrogates: str,
    seed: int,
    output: Path,
    table: Path,
    replace: bool,
    as_json: bool,
    remark: str = "",
) -> None:
    """Press, print, write and draw; a remark stands below the table."""
    from stiction.studies import traverse as traverses
    from stiction.views import traverse as views

    contact: dict[str, Any] = {
        "effective_modulus": effective_modulus, "law": law, "detection": detection, "curvature": curvature,
    }  # fmt: skip
    uppers, lowers = paired_lines(
        upper, lower, travel=travel, level=level, lines=lines, along=along, surrogates=surrogates, seed=seed,  # type: ignore[arg-type]
    )  # fmt: skip
    room = lowers[0].extent - uppers[0].extent
    positions = offsets if offsets is not None else 1 if len(uppers) > 1 else OFFSETS
    if positions > 1 and not room > 0:
        raise ValueError(f"--offsets {positions} needs a --travel LENGTH, for which the slider is shortened")
    area = uppers[0].extent * traverses.THICKNESS
    loads = [amount * (area if per_area else 1.0) for amount, per_area in wanted]
    for sentence in views.doubts(uppers, lowers, loads, mu0=mu0, **contact):
        say(sentence)
    check_directory(output, table, replace=replace)
    chosen: dict[str, Any] = {
        "mu0": mu0 if len(mu0) > 1 else mu0[0],
        "tau0": tau0 if len(tau0) > 1 else tau0[0],
        # One line on itself is no pair at 0; several are not on themselves.
        "offsets": 0.0 if len(uppers) > 1 and positions == 1 and travel is None
        else room * np.arange(1, positions + 1) / positions,
        "progress": True,
    }  # fmt: skip
    elastic: dict[str, Any] = {"effective_modulus": effective_modulus, "compliance_share": compliance_share}
    around = traverses.loads_around(loads)
    if "half-space" in mechanics:
        around = traverses.loads_around(
            loads, around=traverses.AROUND_HALF_SPACE, steps=traverses.HALF_SPACE_STEPS
        )  # fmt: skip
        pair = uppers[0], lower_piece(lowers[0], float(np.atleast_1d(chosen["offsets"])[-1]), uppers[0])
        _say_what_it_costs(pair, around, len(uppers) * positions, **elastic)
    results = [
        traverses.traverse(
            uppers, lowers, around, mechanics=each,  # type: ignore[arg-type]
            **chosen, **(elastic if each == "half-space" else contact),
        )
        for each in mechanics
    ]  # fmt: skip
    result = results[0] if len(results) == 1 else traverses.joined_traverses(results)
    result.attrs |= {"loads_mN": np.array(loads), "remark": remark}
    mean = views.means(result)
    show_line_pair(result, as_json=as_json)
    draw = functools.partial(
        views.save_traverse_figures, result, mean, loads, output, bodies=(uppers, lowers), **contact
    )  # fmt: skip
    leave_pair(result, table, views.traverse_csv(mean, loads), draw, replace=replace, as_json=as_json)


def _say_what_it_costs(pair: tuple[Profile, Profile], loads: Any, positions: int, **elastic: Any) -> None:
    """How long all solutions take, from one position."""
    from stiction.mechanics.half_space import half_space

    words = f"half-planes: {positions * len(loads)} solutions of {len(pair[0])} points"
    try:
        half_space(*pair, loads[:1], **elastic)  # what is imported at the first time is not counted
        started = time.perf_counter()
        half_space(*pair, loads, **elastic)
    except RuntimeError:
        say(f"{words}; the first does not reach its tolerance")
        return
    say(f"{words}, about {(time.perf_counter() - started) * positions / available_cores():.2g} s by the first position")


def show_line_pair(result: Any, *, as_json: bool = False) -> None:
    """The table of a pair of lines, or its values as JSON."""
    from stiction.views.records import pair_record
    from stiction.views.traverse import means, traverse_text

    loads, mean = np.atleast_1d(result.attrs["loads_mN"]), means(result)
    tell(pair_record(mean, loads) if as_json else traverse_text(result, mean, loads))


def draw_line_pair(result: Any, directory: Path) -> None:
    """The figures of a pair of lines that need no profiles."""
    from stiction.views.traverse import means, save_traverse_figures

    loads = np.atleast_1d(result.attrs["loads_mN"])
    for path in save_traverse_figures(result, means(result), loads, directory):
        tell(f"wrote {path}")
