"""What a page knows of a result of measured bodies: their members' sums at every load, and the answers."""

from __future__ import annotations

import contextlib
from collections.abc import Sequence
from inspect import signature
from typing import Any

import numpy as np
import xarray

from stiction._checks import Floats
from stiction._number_format import with_unit
from stiction._text import printable
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.friction import SIX
from stiction.mechanics.hardness import EXPONENT, POWER
from stiction.mechanics.quantities import DIRECTED, QUANTITIES, shown_in
from stiction.studies.assessment import limit_of
from stiction.studies.at_load import areas_of, at_load
from stiction.studies.maps import MOTIONS
from stiction.studies.measured_surfaces import MeasuredFile
from stiction.studies.resolution import seen
from stiction.studies.result import Result
from stiction.studies.study import Study
from stiction.views.figures.standard import title_of, words_of
from stiction.views.onset import onset_note, onset_text
from stiction.views.point import materials_text, over_text, way_text
from stiction.views.report.page import (
    AXES,
    MOST_TEXT,
    PageResult,
    ReportError,
    counted,
    escaped,
    listed,
    motions_of,
    packed,
)
from stiction.views.report.pictures import (
    adhesion_panel,
    height_scale_panels,
    onset_panels,
    positions_panel,
    touching_panel,
)
from stiction.views.report.reading import GIVEN, reading_table
from stiction.views.resolution import waves_text
from stiction.views.sentence import sentence_text, slopes_text
from stiction.views.sticking import sticking_text
from stiction.views.text import budget_text, waited_text

MOST_VALUES = 4_000_000  # numbers of measured bodies in a page
EVERY_BYTE = 8  # of a double

_UNITS = {"um^2": "µm²", "mN/um": "mN/µm", "1": ""}  # names of units that have no prefixes


def page_of_measured(result: Result, study: Study, name: str, picture: xarray.Dataset | None) -> PageResult:
    """What a page says of a result of measured bodies, called by a name, or by those of its files where this is empty.

    A picture is what `contact_picture` returns, that beside a stored result by default. Raises a `ReportError` if the
    result is too large.
    """
    dataset = result.dataset
    step = study.step
    sums = _sums(dataset, step)
    if sums.size > MOST_VALUES:
        raise ReportError(f"the result has {sums.size} numbers, more than the {MOST_VALUES} that a page can hold")
    files = title_of(study)
    name = f"{files} ({name})" if name else files
    facts = _facts_of(dataset, result, study)
    facts |= {
        "quantities": _quantities(result, facts), "bytes": dict.fromkeys(("means", "sums"), EVERY_BYTE),
        "name": name, "variables": {"plain": [], "directed": []},
        "perRepetition": {"plain": ["normal_elastic"], "directed": _DIRECTED},
    }  # fmt: skip
    numbers = {"means": packed([], EVERY_BYTE), "sums": packed(sums, EVERY_BYTE)}
    picture = result.contact_picture if picture is None else picture
    members = int(facts["repetitions"])
    onset = result.onset
    beside = [waves_text(found)] if (found := seen(study)) is not None else []
    beside += [] if onset is None else [f"{onset_text(onset)} {onset_note(onset)}"]
    said = "".join(f"<p>{escaped(line)}</p>" for line in (*beside, *_held(result, study)))
    details = said + "".join(_history(side, str(dataset.attrs.get(side, "")), study) for side in ("upper", "lower"))
    return PageResult(
        study=study, name=name, head=_head(study, facts),
        pairs=f"{counted(members, 'pair')} of pieces of the two surfaces",
        facts=facts, numbers=numbers, there=members, details=details,
        touching="" if picture is None else touching_panel(picture, facts["directions"][0]),
        pictures=(positions_panel(result, facts["asked"][0], words_of(study)) if members > 1 else "")
        + ("" if onset is None else onset_panels(onset, words_of(study)))
        + height_scale_panels(result, words_of(study))
        + adhesion_panel(result.coming_and_going, words_of(study)),
    )  # fmt: skip


_DIRECTED = [name for name in SIX if name in DIRECTED]


def _sums(dataset: xarray.Dataset, step: str) -> Floats:
    """Sums of every member (variable, cut-off, member, step): the elastic load, and those of each motion one by one."""
    motions = [dim for dim in MOTIONS if dim in dataset.dims]
    dims = ("cut_off", "repetition", step)
    columns = [dataset["normal_elastic"].transpose(*dims).values]
    by_motion = [dataset[name].transpose(*motions, *dims).values for name in _DIRECTED]
    for place in np.ndindex(*(dataset.sizes[dim] for dim in motions)):
        columns += [values[place] for values in by_motion]
    return np.stack(columns).astype(np.float64)


def _facts_of(dataset: xarray.Dataset, result: Result, study: Study) -> dict[str, Any]:
    surfaces: Any = study.surfaces
    of_friction: Any = study.friction
    loads = dataset[study.step].values.tolist()
    asked = [float(load) for load in of_friction.load]
    rules, angles = motions_of(study)
    ways = [{"words": way_text(angle), "directions": [d]} for d, angle in enumerate(angles)]
    if len(angles) > 1:
        ways.insert(0, {"words": over_text(angles), "directions": list(range(len(angles)))})
    return {
        "reading": "elastic", "interval": "sample" if surfaces.is_areal else "neighbours", "hasIntervals": True,
        "cell": AXES["cut_off"], "dimensions": dataset["cut_off"].values.tolist(), "convention": "",
        "amplitudes": [1.0], "measure": "", "repetitions": int(dataset.sizes["repetition"]), "steps": loads,
        "loads": [loads[0], loads[-1]], "rules": rules, "directions": angles, "ways": ways, "validity": {},
        "modulus": float(dataset["effective_modulus"]), "area": float(dataset["nominal_area"]),
        "kinds": _kinds(dataset), "lines": dataset["line"].values.tolist() if "line" in dataset.coords else None,
        "offsets": [listed(dataset[axis].values) for axis in ("x", "y")] if "x" in dataset.coords else None,
        "asked": asked, "answers": _answers(result), "combined": _combined(result, loads), "gap": _gap(dataset),
        "growth": _growth(result, study),
    }  # fmt: skip


def _growth(result: Result, study: Study) -> dict[str, Any] | None:
    """Return A/F over hardness for each rule and load, from which a page has junction growth; None without growth."""
    alpha = study.contact.junction_growth
    if not alpha:
        return None
    at = at_load(result, study.contact.steps(), mu0=[0.0], tau0=[0.0])
    areas = areas_of(at, result)
    pages: list[list[dict[str, Any]]] = []
    for rule in at["sliding"].values.tolist():
        tables = [areas.sheared(load, rule) for load in range(at.sizes["load"])]
        pages.append([{"areas": listed(values), "elastic": elastic} for values, elastic in tables])
    return {
        "hardness": areas.hardness, "alpha": float(alpha), "mixing": [EXPONENT, POWER], "nodes": areas.nodes.tolist(),
        "tables": pages,
    }  # fmt: skip


def _held(result: Result, study: Study) -> list[str]:
    """What holds bodies that adhere, at the first mu0 and tau0 by the rule to quote."""
    if not study.contact.adheres:
        return []
    sticking = result.summary().points[0].sticking
    return [] if sticking is None else [sticking_text(sticking)]


def _head(study: Study, facts: dict[str, Any]) -> list[str]:
    surfaces: Any = study.surfaces
    hardness = study.contact.hardness
    how = "the elastic half-space" if study.by_half_space else "asperities"
    limited = "" if hardness is None else f", hardness {with_unit(hardness, 'GPa')}"
    modulus = with_unit(facts["modulus"], "GPa")
    made_of = f"{materials_text(study).capitalize()}. " if materials_text(study) else ""
    size = f"{facts['area']:.4g} µm²" if study.is_areal else f"{facts['area']:.4g} µm, 1 µm wide"
    return [f"{made_of}{surfaces.pressed} of {size}, pressed by {how}; E* = {modulus}{limited}."]


def _history(side: str, history: str, study: Study) -> str:
    lines = "".join(f"<li>{escaped(line)}</li>" for line in history.splitlines()[:20])
    part = getattr(study.surfaces, side)
    readings = "".join(_reading_table(scan) for scan in part.scans[:MAX_READINGS])
    more = len(part.scans) - MAX_READINGS
    readings += f"<p>{more} more scans are in the JSON of <code>stiction pair</code>.</p>" if more > 0 else ""
    body = f"<p>The {side} body: <code>{escaped(part.name)}</code></p>"
    return body + (f"<ul>{lines}</ul>" if lines else "") + readings


MAX_READINGS = 4  # scans of a part whose reading a page lists


def _reading_table(scan: MeasuredFile) -> str:
    """Return how a file was read as a table; empty of a body in memory and of a file that is gone."""
    with contextlib.suppress(ValueError, OSError):
        if (reading := scan.reading) is not None:
            return reading_table(reading, {name: getattr(scan, name) for name in GIVEN})
    return ""


def _kinds(dataset: xarray.Dataset) -> list[dict[str, Any]]:
    surrogate = np.zeros(dataset.sizes["repetition"], np.bool_)
    if "surrogate" in dataset.coords:
        surrogate = dataset["surrogate"].values.astype(bool)
    words = {False: "positions of the two surfaces", True: "pairs of surrogates"}
    kinds = [{"words": text, "members": np.flatnonzero(surrogate == which).tolist()} for which, text in words.items()]
    return [kind for kind in kinds if kind["members"]]


def _quantities(result: Result, facts: dict[str, Any]) -> list[dict[str, Any]]:
    kinds: list[Any] = ["shifts", "surrogates"] if len(facts["kinds"]) > 1 else [None]
    tables = [at_load(result, facts["steps"], mu0=[0.0], tau0=[0.0], of=kind) for kind in kinds]
    found = []
    for name in (name for name in shown_in("report") if name in tables[0]):
        means = [table[name].transpose("cut_off", "load", "statistic").values for table in tables]
        if not np.isfinite(means[0]).any() or (name == "load_share_at_hardness" and not np.nan_to_num(means[0]).any()):
            continue
        quantity = QUANTITIES[name]
        unit = "%" if quantity.percent else _UNITS.get(quantity.unit, quantity.unit)
        words = quantity.short[0].upper() + quantity.short[1:]
        limit, values = limit_of(name), [listed(each) for each in means]
        found.append({"name": name, "words": words, "unit": unit, "limit": limit, "means": values})
    return found


def _answers(result: Result) -> list[dict[str, Any]]:
    return [
        {
            "at": answer.at, "verdict": answer.verdict, "covered": answer.covered,
            "sentence": printable(sentence_text(answer), MOST_TEXT * 4),
            "doubts": [
                {name: printable(getattr(each, name), MOST_TEXT) for name in ("text", "cure", "severity")}
                for each in answer.doubts
            ],
            "slopes": slopes_text(answer),
            "intervals": {rule.rule: listed([rule.lower, rule.upper]) for rule in answer.rules},
            "parts": None if answer.parts is None else listed(answer.parts),
            "most": " ".join(filter(None, (budget_text(answer), waited_text(answer)))) or None,
        }
        for answer in result.summary().points
    ]  # fmt: skip


def _combined(result: Result, loads: Sequence[float]) -> list[dict[str, Any]]:
    """Return the ends of the combined intervals over cut-off and load, at each mu0 and tau0 by each sliding rule."""
    table = result.at(loads)["friction_combined"]
    table = table.sel(statistic=["lower", "upper"]).transpose("sliding", "mu0", "tau0", "cut_off", "load", "statistic")
    return [
        {
            "rule": str(own["sliding"].values), "mu0": float(own["mu0"]), "tau0": float(own["tau0"]),
            "ends": listed(own.values),
        }
        for own in (table[place] for place in np.ndindex(table.shape[:3]))
    ]  # fmt: skip


def _gap(dataset: xarray.Dataset) -> dict[str, Any] | None:
    """What friction by the slope alone is made of, over cut-off and member."""
    if not {"rms_gradient", "rms_slope"} <= set(dataset.data_vars):
        return None
    gradient = dataset["rms_gradient"].transpose("cut_off", "repetition").values
    slope = dataset["rms_slope"]
    slope = slope if "direction" in slope.dims else slope.expand_dims("direction")
    return {
        "gradient": listed(gradient),
        "slope": listed(slope.transpose("direction", "cut_off", "repetition").values),
        "kappa": float(signature(gentle_friction).parameters["kappa"].default),
    }
