"""Report of generated bodies: every quantity at nodes of mu0 and tau0, statuses and assessments, and some pictures."""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._number_format import prefix, with_unit
from stiction.mechanics import friction
from stiction.mechanics.quantities import AREAL_VALIDITY, AT_HARDNESS, ONSET, QUANTITIES, VALIDITY
from stiction.studies.assessment import ADVICE, HALF, LIMITS_OF_CONTACTS, VERDICTS, checks_of_ensemble
from stiction.studies.evaluation import reached_loads
from stiction.studies.maps import friction_map, means, solved_pieces
from stiction.studies.nodes import Axis, at_nodes, axes_of, is_interpolated, largest_errors, refined
from stiction.studies.point import rules_of
from stiction.studies.result import Result
from stiction.studies.study import Study, study_names
from stiction.views.figures.ensemble import COLOUR_QUANTILES
from stiction.views.point import motion_text
from stiction.views.report.page import AXES, PageResult, ReportError, axes_facts, counted, motions_of
from stiction.views.report.pictures import dimension_panel, profiles_panel
from stiction.views.report.tables import Tables

MAX_POINTS = 1_000_000  # coefficients of generated bodies in a page: nodes times loads, cells, rules and directions
LOAD_STEPS = 40  # loads of a map
CHECKED_LOADS = 4  # loads at which the nodes are chosen, and the error between them is measured
MOST_OVERLAP = 0.1  # mean of overlap / radius above which the page warns; of the fractions it is `HALF`
CELLS = ("fractal_dimension", "amplitude")


def page_of_generated(result: Result, study: Study, name: str) -> PageResult:
    """Return the report of a result of generated bodies, called by a name, or by that of its study where it is empty.

    Raises a `ReportError` if it is too large for a page or has no members.
    """
    head, there = result.head, result.members.size
    members = sum(piece.sizes["repetition"] for piece in solved_pieces(result, ["normal_elastic"])) if there else 0
    if not members:
        raise ReportError("no member of the result has a solution at every load")
    counts = means(result, ["contact_count"])["contact_count"].transpose(*CELLS, study.step).values
    tables, loads = Tables(), _loads(result) if (counts > 0).any() else np.zeros(0)
    facts = _facts_of(head, study, loads) | {"name": name or _name_of(study), "repetitions": members}
    facts |= {
        "hasIntervals": members > 1,
        "kinds": ["pairs of surfaces"],
        "combined": [True],
        "answers": [],
        "asked": [],
    }
    if loads.size:
        facts |= _at_nodes(result, study, head, loads, members, tables)
    return PageResult(
        study=study, name=facts["name"], head=_head(study), pairs=_pairs(study, facts), facts=facts, tables=tables,
        there=there, pictures=_pictures(result, study, head, counts),
    )  # fmt: skip


def _facts_of(head: xarray.Dataset, study: Study, loads: Floats) -> dict[str, Any]:
    surfaces: Any = study.surfaces
    rules, angles = motions_of(study)
    convention = " (classical)" if surfaces.convention == "classical" else ""
    dimensions, amplitudes = (head[name].values for name in CELLS)
    return {
        "isMeasured": False, "rules": rules, "directions": angles,
        "cell": AXES["fractal_dimension"] | {
            "title": f"{AXES['fractal_dimension']['title']}{convention}", "label": f"Fractal dimension D{convention}",
        },
        "cells": {"values": dimensions.tolist(), "texts": [f"D = {each:.3f}" for each in dimensions]},
        "amplitudes": [with_unit(each, "um") for each in amplitudes],
        "measure": "total height" if surfaces.amplitude_measure == "height" else surfaces.amplitude_measure,
        "loads": {"values": loads.tolist(), "texts": [with_unit(load, "mN") for load in loads], "unit": ""},
        "ways": [
            {"words": motion_text(angle), "directions": [d], "isWhole": True, "angle": angle}
            for d, angle in enumerate(angles)
        ],
        "quotedRule": rules_of(study)[0], "start": {"cell": dimensions.size // 2, "load": loads.size // 2},
        "validity": [], "statuses": [], "quantities": [], "ranged": False, "curves": {}, "hasStiffness": False,
        "area": None, "steps": int(head.sizes[study.step]),
    }  # fmt: skip


def _at_nodes(
    result: Result, study: Study, head: xarray.Dataset, loads: Floats, members: int, tables: Tables
) -> dict[str, Any]:
    """Put all quantities at nodes into tables, over cell, amplitude, rule, motion, load, mu0 and tau0."""
    rules, angles = motions_of(study)
    axes = _nodes_of(result, study, loads)
    count = math.prod(head.sizes[name] for name in CELLS) * loads.size * len(rules) * len(angles)
    if (size := count * axes[0].values.size * axes[1].values.size) > MAX_POINTS:
        raise ReportError(
            f"the result has {size} coefficients at nodes, more than the {MAX_POINTS} that a page can hold; choose "
            "fewer fractal dimensions, amplitudes or directions"
        )
    at = at_nodes(result, loads, axes)
    points, area = in_order(at["friction_coefficient"]), in_order(at["contact_area"])
    shape: tuple[int, ...] = points.shape[:-1]
    area = np.broadcast_to(area, points.shape)
    contacts = np.broadcast_to(in_order(at["contact_count"])[..., 0], shape)
    quantities: dict[str, Floats] = {"friction": points, "area": area}
    if "normal_stiffness" in at and bool(at["normal_stiffness"].notnull().any()):
        quantities["stiffness"] = np.broadcast_to(in_order(at["normal_stiffness"]), points.shape)
    for name, each in quantities.items():
        tables.add_points(name, each)
    validity: dict[str, Floats] = {}
    figures: list[dict[str, Any]] = []
    for name in (name for name in (*VALIDITY, *AREAL_VALIDITY, *AT_HARDNESS) if name in at):
        own = in_order(at[name])
        own = np.broadcast_to(own if own.ndim == len(shape) else own[..., 0], shape)
        if not np.isfinite(own).any() or (name in AT_HARDNESS and not np.nan_to_num(own).any()):
            continue
        quantity = QUANTITIES[name]
        validity[name] = own
        tables.add(f"validity_{len(figures)}", own)
        figures.append({
            "words": quantity.short[0].upper() + quantity.short[1:],
            "limit": HALF if quantity.percent else MOST_OVERLAP, "isDrawn": "hatch" in quantity.shown,
            "factor": 100 if quantity.percent else 1, "decimals": 0 if quantity.percent else 2,
            "unit": " %" if quantity.percent else "",
        })  # fmt: skip
    status = np.broadcast_to(in_order(at["status"]), shape)
    statuses, codes = _statuses(status, validity, figures)
    tables.add("status", codes.astype(np.int8))
    tables.add("fine", (is_interpolated(axes, points[..., 0]) & is_interpolated(axes, area[..., 0])).astype(np.int8))
    rule = rules.index(rules_of(study)[0])
    numbers = {name: each[:, :, rule] for name, each in validity.items()}
    numbers |= numbers_of(
        points[:, :, rule], area[:, :, rule, ..., 0], contacts[:, :, rule], study, loads, axes, members
    )
    judgements, which = judgements_of(study, status[:, :, rule], numbers)
    tables.add("judgement", which.astype(float))
    for name in sorted({doubt["number"]["table"] for one in judgements for doubt in one["doubts"] if doubt["number"]}):
        tables.add(f"number_{name}", numbers[name])
    sound = codes == 0
    for figure, own in zip(figures, validity.values(), strict=True):
        sound = sound & ~(own > figure["limit"])
    drawn = {name: each[..., 0] for name, each in quantities.items()} | {"width": _relative(points)}
    some = slice(None, None, max(1, loads.size // CHECKED_LOADS))
    error = largest_errors(axes, points[:, :, :, :, some], lambda mu0, tau0: _friction(result, loads[some], mu0, tau0))
    return {
        "axes": axes_facts(axes, study), "statuses": statuses, "validity": figures, "judgements": judgements,
        "hasStiffness": "stiffness" in quantities, "start": _start(sound, points, axes, study),
        "maps": _colours(drawn, tables), "error": error,
    }  # fmt: skip


def _nodes_of(result: Result, study: Study, loads: Floats) -> tuple[Axis, Axis]:
    """Return the axes of the nodes of a result, chosen at some of its loads."""
    some = loads[:: max(1, loads.size // CHECKED_LOADS)]
    return refined(axes_of(study), lambda mu0, tau0: _friction(result, some, mu0, tau0))


def _friction(result: Result, loads: Floats, mu0: Floats, tau0: Floats) -> Floats:
    """Return friction over cell, amplitude, rule, motion, load, mu0, tau0 and statistic."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # as in `at_nodes`
        found = friction_map(result, loads, mu0=mu0, tau0=tau0)
    parts = [found[name] for name in ("friction_coefficient", "lower", "upper")]
    return np.stack([in_order(part) for part in parts], axis=-1)


LEAD = (*CELLS, "sliding", "direction", "load", "mu0", "tau0")


def in_order(table: xarray.DataArray) -> Floats:
    """Return values over `LEAD`, one of dimensions that are missing, and over others after these."""
    table = table.expand_dims([dim for dim in LEAD if dim not in table.dims])
    return np.asarray(table.transpose(*LEAD, ...).values)


def _statuses(
    names: NDArray[Any], validity: dict[str, Floats], figures: Sequence[dict[str, Any]]
) -> tuple[list[dict[str, Any]], NDArray[np.intp]]:
    """Return statuses by their codes, and the codes of points: 0 of a trusted value, 1 of a value beyond the model."""
    statuses = [{"name": friction.STATUS_OK, "isOk": True, "isTrusted": each} for each in (True, False)]
    beyond = np.zeros(names.shape, bool)
    for figure, own in zip(figures, validity.values(), strict=True):
        if figure["isDrawn"]:
            beyond |= own > figure["limit"]
    codes = np.where(beyond, 1, 0)
    for name in (each for each in friction.STATUSES if each != friction.STATUS_OK):
        codes[names == name] = len(statuses)
        statuses.append({"name": name, "isOk": False, "isTrusted": False})
    return statuses, codes


def _relative(points: Floats) -> Floats:
    """Return half the width of intervals (..., 3) over the values."""
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray((points[..., 2] - points[..., 1]) / (2 * np.abs(points[..., 0])))


def _colours(quantities: dict[str, Floats], tables: Tables) -> list[str]:
    """Put the ends of the colours of each quantity into tables, over amplitude, rule, motion, mu0 and tau0."""
    shown = []
    for name, values in quantities.items():
        known = np.where(values > 0, values, np.nan)
        if not np.isfinite(known).any():
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)  # nodes without a value
            low, high = np.nanquantile(known, COLOUR_QUANTILES, axis=(0, 4))
        tables.add(f"colours_{name}_low", low)
        tables.add(f"colours_{name}_high", np.maximum(high, 1.05 * low))
        shown.append(name)
    return shown


def _start(sound: NDArray[np.bool_], points: Floats, axes: tuple[Axis, Axis], study: Study) -> dict[str, int]:
    """Return the cell and load of the narrowest interval at the study's mu0 and tau0, of those that are sound."""
    own = study.friction.mu0[len(study.friction.mu0) // 2], float(study.friction.tau0[0])
    place = [int(np.abs(axis.values - each).argmin()) for axis, each in zip(axes, own, strict=True)]
    at: tuple[Any, ...] = (slice(None), 0, 0, 0, slice(None), *place)
    width = np.where(sound[at] & (points[(*at, 0)] > 0), _relative(points)[at], np.nan)
    if not np.isfinite(width).any():
        return {"cell": sound.shape[0] // 2, "load": sound.shape[4] // 2}
    cell, load = np.unravel_index(np.nanargmin(width), width.shape)
    return {"cell": int(cell), "load": int(load)}


# ---- The assessment --------------------------------------------------------------------------------------------------


def numbers_of(
    points: Floats, area: Floats, contacts: Floats, study: Study, loads: Floats, axes: tuple[Axis, Axis], members: int
) -> dict[str, Floats]:
    """Return the numbers that checks of generated bodies compare with their limits, over (..., load, mu0, tau0).

    They are those that `stiction.studies.assessment` compares at one point.
    """
    value, lower, upper = np.moveaxis(points, -1, 0)
    mu0, tau0 = np.meshgrid(axes[0].values, axes[1].values, indexing="ij")
    surfaces: Any = study.surfaces
    limits, nominal = LIMITS_OF_CONTACTS, float(np.prod(surfaces.extents())) if study.is_areal else math.inf
    with np.errstate(divide="ignore", invalid="ignore"):
        few = np.where(area / nominal > limits["merged"], np.nan, contacts)
        relative = np.where((mu0 > 0) & (tau0 == 0), value / mu0, np.nan)
        return {
            "deficit": -value,
            "missing_interval": (np.isnan(lower) | np.isnan(upper)).astype(float),
            "half_width": (upper - lower) / (2 * value),
            "mean_pressure": np.where(area > 0, loads[:, np.newaxis, np.newaxis] / area, np.nan),
            "contact_count": contacts,
            "contacts_missing_of_all": limits["of_all"] - contacts * members,
            "contacts_missing": limits["least"] - few,
            "contacts_wanting": limits["few"] - few,
            "share_of_mu0": 1 - np.abs(relative - 1),
            "beyond_mu0": value - mu0,
        }


def judgements_of(
    study: Study, status: NDArray[Any], numbers: dict[str, Floats]
) -> tuple[list[dict[str, Any]], NDArray[np.intp]]:
    """Return the assessments of points by status and numbers, (...): each once, and which each point has."""
    reasons: list[dict[str, Any]] = []
    failed = []
    is_ok = (status == friction.STATUS_OK) & np.isfinite(numbers["deficit"])
    for name in np.unique(np.where(is_ok, friction.STATUS_OK, status)).tolist():
        text, cure = ADVICE.get(name, ADVICE[""])
        here = ~is_ok & (status == name)
        if here.any():
            reasons.append({"text": text, "cure": cure, "severity": "fault", "number": None})
            failed.append(np.where(here, len(reasons), 0))
    for group in checks_of_ensemble(study):
        found = np.zeros(status.shape, np.intp)
        for check in group:
            own = numbers.get(check["name"])
            here = np.zeros(status.shape, bool) if own is None else is_ok & (found == 0) & (own > check["limit"])
            if here.any():
                reasons.append({**{key: check[key] for key in ("text", "cure", "severity")}, "number": _number(check)})
                found[here] = len(reasons)
        failed.append(found)
    rows, which = np.unique(np.stack(failed).reshape(len(failed), -1), axis=1, return_inverse=True)
    judgements = []
    for row in rows.T.tolist():
        doubts = [reasons[index - 1] for index in row if index]
        doubts.sort(key=lambda each: each["severity"] != "fault")
        severities = {each["severity"] for each in doubts}
        verdict = VERDICTS["fault" if "fault" in severities else "caution" if severities else ""]
        judgements.append({"verdict": verdict, "doubts": doubts})
    return judgements, which.reshape(status.shape)


def _number(check: dict[str, Any]) -> dict[str, Any] | None:
    """Return which number the text of a check shows, its factor, decimals and unit; None without one."""
    if "{}" not in check["text"]:
        return None
    name, shown = check["about"] or check["name"], check["shown"]
    if shown == "percent":
        return {"table": name, "factor": 100, "decimals": 0, "unit": " %"}
    if shown in ("digits", "digit"):
        return {"table": name, "factor": 1, "decimals": 1 if shown == "digits" else 3, "unit": ""}
    factor, unit = prefix(check["limit"], shown)
    decimals = max(0, 1 - math.floor(math.log10(check["limit"] / factor)))
    return {"table": name, "factor": 1 / factor, "decimals": decimals, "unit": f" {unit}"}


# ---- Words and pictures ----------------------------------------------------------------------------------------------


def _pictures(result: Result, study: Study, head: xarray.Dataset, counts: Floats) -> str:
    """Draw two of the profiles in contact, and the onset of sliding if the study asks for it."""
    if not (touching := (counts > 0).any(axis=(0, 1))).any():
        return ""
    panels = []
    if not (study.is_areal or study.uses_half_space):
        steps = head["approach"].values[touching]
        panels.append(profiles_panel(study, float(steps[steps.size // 2])))
    if set(ONSET) & set(study.sums()):
        panels.append(dimension_panel(result.dataset))
    return "".join(panels)


def _loads(result: Result) -> Floats:
    """Return the loads of the map, mN, in five digits between ends of three; none where none is carried."""
    try:
        low, high = (float(f"{load:.3g}") for load in reached_loads(result, 2))
    except ValueError:
        return np.zeros(0)
    return np.array([float(f"{load:.5g}") for load in np.geomspace(low, high, LOAD_STEPS)])


def _name_of(study: Study) -> str:
    """Return the name of the built-in study that equals it except for the repetitions, else a description."""
    same = {"ensemble.repetitions": study.ensemble.repetitions}
    return next((name for name in study_names() if Study.named(name).with_changes(same) == study), "study")


def _head(study: Study) -> list[str]:
    rules, angles = motions_of(study)
    surfaces: Any = study.surfaces
    contact: Any = study.contact
    lengths = surfaces.extents() if study.is_areal else (float(surfaces.extent),)
    how = "the elastic half-space" if study.uses_half_space else "asperities"
    law = "" if study.uses_half_space else f", law {contact.model(rules[0]).law}"
    return [
        f"{surfaces.place[0].upper()}{surfaces.place[1:]}, {' x '.join(f'{length:g}' for length in lengths)} µm, "
        f"pressed by {how}{law}; E* = {with_unit(float(contact.effective_modulus), 'GPa')}; contacts with friction: "
        f"{' and '.join(rules)}; motion {', '.join(map(motion_text, angles))}."
    ]


def _pairs(study: Study, facts: dict[str, Any]) -> str:
    dimensions, amplitudes, steps = len(facts["cells"]["values"]), len(facts["amplitudes"]), facts["steps"]
    number = counted(facts["repetitions"], "pair of surfaces", "pairs of surfaces")
    where = f"{'each of ' if dimensions > 1 else ''}{counted(dimensions, 'fractal dimension')}"
    where += f" and {counted(amplitudes, 'amplitude')}" if amplitudes > 1 else ""
    how = counted(steps, "load") if study.uses_half_space else counted(steps, "approach", "approaches")
    return f"{number} at {where}, pressed together at {how}"
