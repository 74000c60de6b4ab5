"""The numbers of a page of generated bodies: sums of every member, and their means, in the order of `numbers.js`."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
import xarray
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.mechanics.friction import RATIOS, SIX
from stiction.mechanics.quantities import DIRECTED
from stiction.studies.maps import MOTIONS, solved_pieces
from stiction.studies.store import Stored

AT_HARDNESS = ("load_share_at_hardness", "area_share_at_hardness")

PAGE_RATIOS: dict[str, tuple[str, tuple[str, ...]]] = RATIOS | {name: (name, ()) for name in AT_HARDNESS}
"""Numerator of each figure of a page, and sums that are its denominator."""

CELLS = ("fractal_dimension", "amplitude")


class PageSums(NamedTuple):
    """Means over the members, and sums of each: variables one after the other, plain ones first, then of each motion.

    Means are over (variable, cell, cell, step), sums over (variable, cell, cell, member, step), both possibly empty;
    `facts` name the variables, and `members` counts those that have a solution at every step.
    """

    means: NDArray[Any]
    sums: NDArray[Any]
    facts: dict[str, Any]
    members: int

    def plain_means(self) -> dict[str, NDArray[Any]]:
        """Means (cell, cell, step) of what has nothing to do with motions, by name."""
        return dict(zip(self.facts["variables"]["plain"], self.means, strict=False))


def sums_of_ensemble(result: xarray.Dataset | Stored, step: str, motions: int, *, has_sums: bool) -> PageSums:
    """Means over the members, and the sums of each if they are to be there, of pieces of which one is in memory."""
    total: Any = 0.0
    members = 0
    kept = []
    facts: dict[str, Any] = {}
    for piece in solved_pieces(result):
        if not piece.sizes["repetition"]:
            continue
        directed = [dim for dim in MOTIONS if dim in piece.dims]
        ordered = piece.transpose(*directed, *CELLS, "repetition", step)
        means, sums, facts = _of_piece(ordered, piece[step].values, motions)
        members += piece.sizes["repetition"]
        total = total + means * piece.sizes["repetition"]
        if has_sums:
            kept.append(sums)
    return PageSums(total / max(members, 1), np.concatenate(kept, axis=3) if kept else np.empty(0), facts, members)


def _of_piece(data: xarray.Dataset, steps: Floats, motions: int) -> tuple[NDArray[Any], NDArray[Any], dict[str, Any]]:
    """Means and sums, those that have nothing to do with the motion once, and the others for each."""
    columns = {str(name): values.values for name, values in data.data_vars.items() if values.dtype.kind in "fi"}
    approach = columns.get("approach")
    has_stiffness = steps.size >= 3 and (approach is None or bool(np.isfinite(approach).all()))
    compliance = None
    if has_stiffness and approach is not None:
        compliance = np.gradient(approach, steps, axis=-1, edge_order=2)
    figures = [name for name, (of, over) in PAGE_RATIOS.items() if {of, *over} <= set(columns)]
    needed = {part for name in figures for part in (PAGE_RATIOS[name][0], *PAGE_RATIOS[name][1])}
    plain = sorted({"contact_area", "normal_elastic", "contact_count"} | needed)
    directed = [name for name in SIX if name in DIRECTED]

    def of_motion(name: str, m: int) -> NDArray[Any]:
        values = columns[name]
        return np.asarray(values.reshape(motions, *values.shape[-4:])[m])

    def stiffness(name: str, m: int) -> NDArray[Any]:
        values = np.gradient(of_motion(name, m) if name in directed else columns[name], steps, axis=-1, edge_order=2)
        return np.asarray(values if compliance is None else values / compliance)

    averages = [columns[name].mean(axis=2) for name in plain]
    sums = [columns[name] for name in ("contact_area", "normal_elastic")]
    of_sums: dict[str, list[str]] = {"plain": ["contact_area", "normal_elastic"], "directed": directed}
    of_means: dict[str, list[str]] = {"plain": list(plain), "directed": list(directed)}
    parts = ("frictional", "adhesive")
    if has_stiffness:
        of_means["plain"].append("stiffness_elastic")
        averages.append(stiffness("normal_elastic", 0).mean(axis=2))
        of_means["directed"] += [f"stiffness_{part}" for part in parts]
        if compliance is not None:
            of_sums["plain"].append("compliance")
            sums.append(compliance)
    for m in range(motions):
        averages += [of_motion(name, m).mean(axis=2) for name in directed]
        if has_stiffness:
            averages += [stiffness(f"normal_{part}", m).mean(axis=2) for part in parts]
        sums += [of_motion(name, m) for name in directed]
    facts = {"variables": of_means, "perRepetition": of_sums, "hasStiffness": has_stiffness}
    return np.stack(averages), np.stack(sums), facts
