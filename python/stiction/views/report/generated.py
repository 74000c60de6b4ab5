"""What a page knows of a result of generated bodies: means over its members, their sums, and some pairs to look at.

Both are in the order of `numbers.js`: variables one after the other, plain ones first, then those of each motion.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._number_format import with_unit
from stiction.mechanics.friction import RATIOS, SIX
from stiction.mechanics.quantities import AREAL_VALIDITY, AT_HARDNESS, DIRECTED, ONSET, QUANTITIES, VALIDITY
from stiction.studies.assessment import HALF, LIMITS_OF_CONTACTS, checks_of_ensemble
from stiction.studies.at_load import reached_loads
from stiction.studies.maps import MOTIONS, solved_pieces
from stiction.studies.point import rules_of
from stiction.studies.result import Result
from stiction.studies.study import Study, study_names
from stiction.views.point import way_text
from stiction.views.report.page import AXES, BYTES, PageResult, ReportError, counted, motions_of, packed
from stiction.views.report.pictures import dimension_panel, profiles_panel

MOST_MEANS = 1_000_000
"""Pairs of surfaces times steps times motions, of which a page can make a map between two pictures."""

MOST_SUMS = 12_000_000
"""Sums of single members in a page, of four bytes each when compressed; without them it has no intervals."""

PER_MEMBER = 7  # sums of each member at each step
MOST_OVERLAP = 0.1  # mean of overlap / radius above which the page warns; of the fractions it is `HALF`
CELLS = ("fractal_dimension", "amplitude")

PAGE_RATIOS: dict[str, tuple[str, tuple[str, ...]]] = RATIOS | {name: (name, ()) for name in AT_HARDNESS}
"""Numerator of each figure of a page, and sums that are its denominator."""


def page_of_generated(result: Result, study: Study, name: str) -> PageResult:
    """What a page says of a result of generated bodies, called by a name, or by that of its study where this is empty.

    Raises a `ReportError` if it is too large for a page or has no members.
    """
    step, head = study.step, result.head
    there = result.members.size
    rules, angles = motions_of(study)
    motions = len(rules) * len(angles)
    values = motions * math.prod(head.sizes[dim] for dim in (*CELLS, step))
    if values > MOST_MEANS:
        raise ReportError(
            f"the result has {values} pairs times {'approaches' if step == 'approach' else 'loads'}, more than "
            f"the {MOST_MEANS} that a page can hold; choose fewer fractal dimensions, amplitudes, directions or steps"
        )
    has_sums = there > 1 and values * there * PER_MEMBER <= MOST_SUMS
    averages, sums, facts, members = _sums_of(result, step, motions, has_sums=has_sums)
    if not members:
        raise ReportError("no member of the result has a solution at every load")
    means = dict(zip(facts["variables"]["plain"], averages, strict=False))
    facts |= _facts_of(head, means, study, result)
    facts |= {
        "name": name or _name_of(study), "bytes": BYTES, "hasIntervals": members > 1 and sums.size > 0,
        "repetitions": members,
        "kinds": [{"words": "pairs of surfaces", "members": list(range(members))}],
    }  # fmt: skip
    return PageResult(
        study=study, name=facts["name"], head=_head(study), pairs=_pairs(study, facts), facts=facts,
        numbers={"means": packed(averages, BYTES["means"]), "sums": packed(sums, BYTES["sums"])}, there=there,
        pictures=_pictures(result, study, head, means),
    )  # fmt: skip


def _sums_of(
    result: Result, step: str, motions: int, *, has_sums: bool
) -> tuple[NDArray[Any], NDArray[Any], dict[str, Any], int]:
    """Means over the members that are solved at every step, sums of each, names of the variables, number of members.

    Means are over (variable, cell, cell, step), sums over (variable, cell, cell, member, step), and empty unless they
    are to be there. One piece of the result is in memory at a time.
    """
    total: Any = 0.0
    members, kept = 0, []
    facts: dict[str, Any] = {}
    for piece in solved_pieces(result):
        if number := piece.sizes["repetition"]:
            directed = [dim for dim in MOTIONS if dim in piece.dims]
            ordered = piece.transpose(*directed, *CELLS, "repetition", step)
            means, sums, facts = _of_piece(ordered, piece[step].values, motions)
            members, total = members + number, total + means * number
            kept += [sums] * has_sums
    return total / max(members, 1), np.concatenate(kept, axis=3) if kept else np.empty(0), facts, members


def _of_piece(data: xarray.Dataset, steps: Floats, motions: int) -> tuple[NDArray[Any], NDArray[Any], dict[str, Any]]:
    columns = {str(name): values.values for name, values in data.data_vars.items() if values.dtype.kind in "fi"}
    approach = columns.get("approach")
    has_stiffness = steps.size >= 3 and (approach is None or bool(np.isfinite(approach).all()))
    along = np.gradient(approach, steps, axis=-1, edge_order=2) if has_stiffness and approach is not None else None

    def stiffness(values: NDArray[Any]) -> Any:
        found = np.gradient(values, steps, axis=-1, edge_order=2)
        return np.mean(found if along is None else found / along, axis=2)

    needed = {part for of, over in PAGE_RATIOS.values() if {of, *over} <= set(columns) for part in (of, *over)}
    plain = sorted({"contact_area", "normal_elastic", "contact_count"} | needed)
    of_sums, directed = ["contact_area", "normal_elastic"], [name for name in SIX if name in DIRECTED]
    parts = ("frictional", "adhesive") if has_stiffness else ()
    averages, sums = [columns[name].mean(axis=2) for name in plain], [columns[name] for name in of_sums]
    averages += [stiffness(columns["normal_elastic"])] if has_stiffness else []
    sums += [] if along is None else [along]
    by_motion = {name: columns[name].reshape(motions, *columns[name].shape[-4:]) for name in directed}
    for m in range(motions):
        averages += [by_motion[name][m].mean(axis=2) for name in directed]
        averages += [stiffness(by_motion[f"normal_{part}"][m]) for part in parts]
        sums += [by_motion[name][m] for name in directed]
    facts = {
        "variables": {
            "plain": plain + ["stiffness_elastic"] * has_stiffness,
            "directed": directed + [f"stiffness_{part}" for part in parts],
        },
        "perRepetition": {"plain": of_sums + ["compliance"] * (along is not None), "directed": directed},
        "hasStiffness": has_stiffness,
    }
    return np.stack(averages), np.stack(sums), facts


def _pictures(result: Result, study: Study, head: xarray.Dataset, means: dict[str, NDArray[Any]]) -> str:
    """Two of the profiles in contact, and how pairs begin to slide if the study asks for it."""
    if not (touching := means["contact_count"].any(axis=(0, 1))).any():
        return ""
    panels = []
    if not (study.is_areal or study.by_half_space):
        steps = head["approach"].values[touching]
        panels.append(profiles_panel(study, float(steps[steps.size // 2])))
    if set(ONSET) & set(study.sums()):
        panels.append(dimension_panel(result.dataset))
    return "".join(panels)


def _facts_of(head: xarray.Dataset, means: dict[str, NDArray[Any]], study: Study, result: Result) -> dict[str, Any]:
    surfaces: Any = study.surfaces
    counts: NDArray[np.bool_] = means["contact_count"] > 0  # (dimension, amplitude, step)
    rules, angles = motions_of(study)
    convention = " (classical)" if surfaces.convention == "classical" else ""
    return {
        "reading": "mean", "interval": "jackknife", "quantities": [], "answers": [], "asked": [], "combined": [],
        "gap": None,
        "cell": AXES["fractal_dimension"] | {"title": f"{AXES['fractal_dimension']['title']}{convention}"},
        "dimensions": head["fractal_dimension"].values.tolist(),
        "amplitudes": head["amplitude"].values.tolist(),
        "convention": convention, "measure": surfaces.amplitude_measure, "rules": rules, "directions": angles,
        "steps": head[study.step].values.tolist(),
        "ways": [{"words": way_text(angle), "directions": [d]} for d, angle in enumerate(angles)],
        "validity": _validity(means),
        "checks": checks_of_ensemble(study), "limits": LIMITS_OF_CONTACTS,
        "nominalArea": float(np.prod(surfaces.extents())) if study.is_areal else None,
        "quotedRule": rules_of(study)[0],
        "touched": counts.any(axis=2).tolist(),
        "touchedAtLast": counts[:, :, -1].tolist(),
        "loads": _loads(result) if counts.any() else [],
    }  # fmt: skip


def _validity(means: dict[str, NDArray[Any]]) -> dict[str, dict[str, Any]]:
    figures = {}
    for name in (*VALIDITY, *AREAL_VALIDITY, *AT_HARDNESS):
        of, over = PAGE_RATIOS[name]
        if not {of, *over} <= means.keys() or (not over and not means[of].any()):
            continue
        quantity = QUANTITIES[name]
        figures[name] = {
            "words": quantity.short[0].upper() + quantity.short[1:], "isShare": quantity.percent,
            "limit": HALF if quantity.percent else MOST_OVERLAP, "isDrawn": "hatch" in quantity.shown, "of": of,
            "over": over,
        }  # fmt: skip
    return figures


def _loads(result: Result) -> list[float]:
    """Lowest and highest load of the map, mN, in three digits; none where none is carried."""
    try:
        return [float(f"{load:.3g}") for load in reached_loads(result, 2)]
    except ValueError:
        return []


def _name_of(study: Study) -> str:
    """That of the built-in study that it is, but for the number of repetitions; else what it is of."""
    same = {"ensemble.repetitions": study.ensemble.repetitions}
    return next((name for name in study_names() if Study.named(name).with_changes(same) == study), "study")


def _head(study: Study) -> list[str]:
    rules, angles = motions_of(study)
    surfaces: Any = study.surfaces
    contact: Any = study.contact
    lengths = surfaces.extents() if study.is_areal else (float(surfaces.extent),)
    how = "the elastic half-space" if study.by_half_space else "asperities"
    law = "" if study.by_half_space else f", law {contact.model(rules[0]).law}"
    return [
        f"{surfaces.place[0].upper()}{surfaces.place[1:]}, {' x '.join(f'{length:g}' for length in lengths)} µm, "
        f"pressed by {how}{law}; E* = {with_unit(float(contact.effective_modulus), 'GPa')}; contacts that rub: "
        f"{' and '.join(rules)}; motion {', '.join(map(way_text, angles))}."
    ]


def _pairs(study: Study, facts: dict[str, Any]) -> str:
    dimensions, amplitudes, steps = (len(facts[name]) for name in ("dimensions", "amplitudes", "steps"))
    number = counted(facts["repetitions"], "pair of surfaces", "pairs of surfaces")
    where = f"{'each of ' if dimensions > 1 else ''}{counted(dimensions, 'fractal dimension')}"
    where += f" and {counted(amplitudes, 'amplitude')}" if amplitudes > 1 else ""
    how = counted(steps, "load") if study.by_half_space else counted(steps, "approach", "approaches")
    return f"{number} at {where}, pressed together at {how}"
