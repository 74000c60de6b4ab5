"""The numbers of a page: sums over contacts of every member, and their means, in the order of `numbers.js`."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction.mechanics.friction import RATIOS, SIX
from stiction.mechanics.quantities import DIRECTED
from stiction.studies.maps import MOTIONS, solved_pieces

if TYPE_CHECKING:
    import xarray

    from stiction.studies.store import Stored

AT_HARDNESS = ("load_share_at_hardness", "area_share_at_hardness")

PAGE_RATIOS: dict[str, tuple[str, tuple[str, ...]]] = RATIOS | {name: (name, ()) for name in AT_HARDNESS}
"""Numerator of each figure of a page, and sums that are its denominator."""


@dataclass(frozen=True, eq=False)
class PageSums:
    """Arrays of a page, and which variables they hold.

    Attributes
    ----------
    means, sums : ndarray
        Variables one after the other, those without motions first and then those of each motion: means over the
        members (variable, cell, cell, step), and sums (variable, cell, cell, member, step), both possibly empty.
    facts : dict
        `variables` of the means and `perRepetition` of the sums: {"plain", "directed"} names in their order.
    members : int
        That have a solution at every step.
    """

    means: NDArray[Any]
    sums: NDArray[Any]
    facts: dict[str, Any] = field(default_factory=dict)
    members: int = 0

    def plain_means(self) -> dict[str, NDArray[Any]]:
        """Means (cell, cell, step) of what has nothing to do with motions, by name."""
        return dict(zip(self.facts["variables"]["plain"], self.means, strict=False))


def with_two_cells(dataset: xarray.Dataset, cells: list[str]) -> xarray.Dataset:
    """A result with exactly two dimensions of cells, `first` and `second`, before its members."""
    renamed = dataset.rename(dict(zip(cells, ("first", "second"), strict=False)))
    return renamed if len(cells) == 2 else renamed.expand_dims("second", axis=1)


# ---- Generated bodies ------------------------------------------------------------------------------------------------


def sums_of_ensemble(
    result: xarray.Dataset | Stored, cells: list[str], step: str, motions: int, *, has_sums: bool
) -> PageSums:
    """Means over the members, and the sums of each if they are to be there, of pieces of which one is in memory."""
    total: Any = 0.0
    members = 0
    kept = []
    facts: dict[str, Any] = {}
    for piece in solved_pieces(result):
        if not piece.sizes["repetition"]:
            continue
        steps = piece[step].values
        ordered = with_two_cells(piece, cells)
        directed = [dim for dim in MOTIONS if dim in ordered.dims]
        ordered = ordered.transpose(*directed, "first", "second", "repetition", step)
        means, sums, facts = _of_piece(ordered, steps, motions)
        members += piece.sizes["repetition"]
        total = total + means * piece.sizes["repetition"]
        if has_sums:
            kept.append(sums)
    return PageSums(total / max(members, 1), np.concatenate(kept, axis=3) if kept else np.empty(0), facts, members)


def _of_piece(data: xarray.Dataset, steps: Floats, motions: int) -> tuple[NDArray[Any], NDArray[Any], dict[str, Any]]:
    """Means and sums, those that have nothing to do with the motion once, and the others for each."""
    columns = {str(name): values.values for name, values in data.data_vars.items() if values.dtype.kind in "fi"}
    compliance = None
    has_stiffness = steps.size >= 3
    if has_stiffness and "approach" in columns:
        has_stiffness = bool(np.isfinite(columns["approach"]).all())
        if has_stiffness:
            compliance = np.gradient(columns["approach"], steps, axis=-1, edge_order=2)
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


# ---- Measured bodies -------------------------------------------------------------------------------------------------


def sums_of_members(dataset: xarray.Dataset, cells: list[str], step: str, plain: list[str]) -> PageSums:
    """The sums of every member of measured bodies, and some statistics of its contacts.

    Plain variables, over cells, members and loads alone, are kept.
    """
    data = with_two_cells(dataset, cells)
    dims = ("first", "second", "repetition", step)
    directed = [name for name in SIX if name in DIRECTED]
    columns = [np.asarray(data[name].transpose(*dims).values, np.float64) for name in plain]
    motions = [dim for dim in MOTIONS if dim in data.dims]
    by_name = {name: data[name].transpose(*motions, *dims).values for name in directed}
    shape = columns[0].shape
    count = int(np.prod([data.sizes[dim] for dim in motions]))
    flat = {name: values.reshape(count, *shape) for name, values in by_name.items()}
    columns += [flat[name][m] for m in range(count) for name in directed]
    facts = {
        "variables": {"plain": [], "directed": []},
        "perRepetition": {"plain": plain, "directed": directed},
        "hasStiffness": False,
    }
    return PageSums(np.empty(0), np.stack(columns), facts)
