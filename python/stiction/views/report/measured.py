"""What a page knows of a result of measured bodies: their members' sums at every load, the answers, and the picture."""

from __future__ import annotations

from inspect import signature
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._checks import Floats
from stiction._text import printable
from stiction.mechanics.closed_forms import gentle_friction
from stiction.mechanics.quantities import HELD, QUANTITIES
from stiction.studies.contact_picture import coming_and_going
from stiction.studies.member_values import PER_AREA
from stiction.studies.onset import onset_beside
from stiction.studies.resolution import seen
from stiction.studies.store import Stored
from stiction.studies.study import Study
from stiction.surfaces.spectrum import surface_spectrum
from stiction.surfaces.surface import Surface
from stiction.views.answer import answers, slopes_text
from stiction.views.asked import at_asked_loads
from stiction.views.digits import with_unit
from stiction.views.doubts import Doubt, limit_of
from stiction.views.figures.standard import hardness_of, once, picture_of, title_of, words_of
from stiction.views.inputs import doubts_of_study
from stiction.views.onset import onset_note, onset_text
from stiction.views.point import adhesion_text, over_text, rules_of, value_of
from stiction.views.point import points as points_of
from stiction.views.report.page import (
    CELLS,
    MOST_TEXT,
    PageResult,
    ReportError,
    counted,
    deflated,
    escaped,
    listed,
    motions_of,
    packed,
    way,
)
from stiction.views.report.pictures import adhesion_panel, onset_panels
from stiction.views.report.sums import PAGE_RATIOS, sums_of_members
from stiction.views.resolution import waves_text
from stiction.views.text import budget_text, waited_text

if TYPE_CHECKING:
    import xarray

MOST_VALUES = 4_000_000  # numbers of measured bodies in a page

_OF_LOAD = {
    "contact_area_fraction": "contact_area", "contact_area": "contact_area", "contact_count": "contact_count",
    "contact_load": "contact_load",
    "mean_pressure": "contact_area", "normal_stiffness": "normal_stiffness", **PER_AREA, "approach": "approach",
    "closure": "closure", "closure_stiffness": "closure_stiffness",
    "share_on_largest": "share_on_largest", "share_at_edge": "share_at_edge",
    "fraction_on_small": "fraction_on_small", "load_share_at_hardness": "load_share_at_hardness",
    "share_beyond_hertz": "", "share_below_grid": "", "share_overlapping": "",
}  # fmt: skip
"""Quantities that the page has at each load beside friction, and the variable of each, or none where it is a ratio."""

_UNITS = {"um^2": "µm²", "mN/um": "mN/µm", "1": ""}  # names of units that have no prefixes


def page_of_measured(
    result: xarray.Dataset | Stored, study: Study, name: str, picture: xarray.Dataset | None, *, with_picture: bool
) -> PageResult:
    """What a page says of a result of measured bodies, called by a name, or by those of its files where this is empty.

    A picture is what `contact_picture` returns; `with_picture`, of a result that has the page for itself, that beside a
    stored result is taken where none is given. Raises a `ReportError` if the result is too large.
    """
    dataset = result.dataset() if isinstance(result, Stored) else result
    step = study.step
    quantities = _quantities(dataset)
    plain = list(
        dict.fromkeys(["normal_elastic", *(part for each in quantities for part in (each["of"], *each["over"]))])
    )
    found = sums_of_members(dataset, ["cut_off"], step, plain)
    if found.sums.size > MOST_VALUES:
        raise ReportError(f"the result has {found.sums.size} numbers, more than the {MOST_VALUES} that a page can hold")
    files = title_of(study)
    name = (f"{files} ({name})" if with_picture else name) if name else files
    facts = found.facts | _facts_of(dataset, result, study) | {"name": name, "quantities": quantities}
    numbers = {"means": packed(found.means, 8), "sums": packed(found.sums, 8)}
    picture = picture_of(result) if picture is None and with_picture else picture
    if picture is not None:
        more, packs = pictured(picture)
        facts |= more
        numbers |= packs
    members = int(facts["repetitions"])
    onset = result.once(onset_beside) if isinstance(result, Stored) else None
    version = result.version if isinstance(result, Stored) else dataset.attrs.get("stiction_version", "unknown")
    said = "".join(f"<p>{escaped(line)}</p>" for line in (*_beside(study, onset), *_held(result, study)))
    details = said + "".join(_history(side, str(dataset.attrs.get(side, "")), study) for side in ("upper", "lower"))
    return PageResult(
        study=study, name=name, head=_head(study, facts),
        pairs=f"{counted(members, 'pair')} of pieces of the two surfaces",
        facts=facts, numbers=numbers, version=str(version), there=members, details=details,
        pictures=("" if onset is None else onset_panels(onset, words_of(study)))
        + adhesion_panel(once(result, coming_and_going), words_of(study)),
    )  # fmt: skip


def _facts_of(dataset: xarray.Dataset, result: xarray.Dataset | Stored, study: Study) -> dict[str, Any]:
    surfaces: Any = study.surfaces
    of_friction: Any = study.friction
    loads = dataset[study.step].values.tolist()
    asked = [float(load) for load in of_friction.load]
    rules, angles = motions_of(study)
    ways = [{"words": f"to {way(angle)}", "directions": [d]} for d, angle in enumerate(angles)]
    if len(angles) > 1:
        ways.insert(0, {"words": over_text(angles), "directions": list(range(len(angles)))})
    return {
        "reading": "elastic", "interval": "sample" if surfaces.is_areal else "neighbours", "hasIntervals": True,
        "cell": CELLS["cut_off"], "dimensions": dataset["cut_off"].values.tolist(), "convention": "",
        "amplitudes": [1.0], "measure": "", "repetitions": int(dataset.sizes["repetition"]), "steps": loads,
        "loads": [loads[0], loads[-1]], "rules": rules, "directions": angles, "ways": ways, "validity": {},
        "modulus": float(dataset["effective_modulus"]), "area": float(dataset["nominal_area"]),
        "kinds": _kinds(dataset), "lines": dataset["line"].values.tolist() if "line" in dataset.coords else None,
        "offsets": [listed(dataset[axis].values) for axis in ("x", "y")] if "x" in dataset.coords else None,
        "asked": asked, "answers": _answers(result, study), "gap": _gap(dataset), "picture": None,
        "spectra": None,
    }  # fmt: skip


def _beside(study: Study, onset: xarray.Dataset | None) -> list[str]:
    """Which waves were seen, and how the pair begins to slide, where that is kept beside the result."""
    found = seen(study)
    words = [] if found is None else [waves_text(found)]
    return words if onset is None else [*words, f"{onset_text(onset)} {onset_note(onset)}"]


def _held(result: xarray.Dataset | Stored, study: Study) -> list[str]:
    """What holds bodies that adhere, at the first mu0 and tau0 by the rule to quote."""
    if not study.contact.adheres:
        return []
    point = next(points_of(at_asked_loads(result)))
    point = point.sel(sliding=rules_of(study)[0]) if "sliding" in point.dims else point
    found = [with_unit(value_of(point, name), QUANTITIES[name].unit) for name in HELD]
    return [
        f"With {adhesion_text(point, study)}: pull-off force {found[0]} ({found[1]}), friction at no load {found[2]}."
    ]


def _head(study: Study, facts: dict[str, Any]) -> list[str]:
    surfaces: Any = study.surfaces
    hardness = hardness_of(study)
    how = "the elastic half-space" if study.by_half_space else "asperities"
    limited = "" if hardness is None else f", hardness {with_unit(hardness, 'GPa')}"
    modulus = with_unit(facts["modulus"], "GPa")
    return [f"{surfaces.pressed} of {facts['area']:.4g} µm², pressed by {how}; E* = {modulus}{limited}."]


def _history(side: str, history: str, study: Study) -> str:
    """How a file was read and prepared, as markup."""
    lines = "".join(f"<li>{escaped(line)}</li>" for line in history.splitlines()[:20])
    file = escaped(getattr(study.surfaces, side).name)
    return f"<p>The {side} body: <code>{file}</code></p>" + (f"<ul>{lines}</ul>" if lines else "")


def _kinds(dataset: xarray.Dataset) -> list[dict[str, Any]]:
    """Shifts and surrogates, and which members are of each."""
    surrogate = np.zeros(dataset.sizes["repetition"], np.bool_)
    if "surrogate" in dataset.coords:
        surrogate = dataset["surrogate"].values.astype(bool)
    words = {False: "positions of the two surfaces", True: "pairs of surrogates"}
    return [
        {"words": words[which], "members": np.flatnonzero(surrogate == which).tolist()}
        for which in (False, True) if (surrogate == which).any()
    ]  # fmt: skip


def _quantities(dataset: xarray.Dataset) -> list[dict[str, Any]]:
    found = []
    for name, variable in _OF_LOAD.items():
        of, over = (variable, ()) if variable else PAGE_RATIOS[name]
        if not {of, *over} <= set(dataset.data_vars) or not np.isfinite(dataset[of].values).any():
            continue
        if name == "load_share_at_hardness" and not dataset[of].values.any():
            continue
        quantity = QUANTITIES[name]
        unit = "%" if "share" in name or "fraction" in name else _UNITS.get(quantity.unit, quantity.unit)
        words = quantity.short[0].upper() + quantity.short[1:]
        found.append(
            {"name": name, "words": words, "of": of, "over": list(over), "unit": unit, "limit": limit_of(name)}
        )
    return found


def _answers(result: xarray.Dataset | Stored, study: Study) -> list[dict[str, Any]]:
    """Verdict, sentence and doubts at every load that was asked for, mu0, tau0 and cut-off."""
    at = at_asked_loads(result)
    said = []
    for point, answer in zip(points_of(at), answers(at, study, beside=doubts_of_study(study)), strict=True):
        said.append(
            {
                "at": {name: float(value) for name, value in answer.at.items()},
                "verdict": answer.verdict, "covered": answer.covered,
                "sentence": printable(answer.sentence, MOST_TEXT * 4),
                "doubts": [_doubt(each) for each in answer.doubts],
                "slopes": slopes_text(answer, point, study),
                "intervals": {rule.rule: listed([rule.lower, rule.upper]) for rule in answer.rules},
                "parts": None if answer.parts is None else listed(answer.parts),
                "most": " ".join(filter(None, (budget_text(answer), waited_text(answer)))) or None,
            }
        )  # fmt: skip
    return said


def _doubt(doubt: Doubt) -> dict[str, str]:
    text, cure = (printable(words, MOST_TEXT) for words in (doubt.text, doubt.cure))
    return {"text": text, "cure": cure, "severity": doubt.severity}


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


# ---- Heights, spectra and contacts ----------------------------------------------------------------------------------


MOST_PIXELS = 256  # rows or columns of the heights that are drawn
MOST_CONTACTS = 2000  # contacts that are drawn: those with the largest forces
CONTACT_BYTES = 4  # leading bytes of a double that are kept of what is only drawn
MOST_POINTS = 700  # of a line as it is drawn
AROUND = 5  # contacts near the strongest that are magnified with it, where they are not far
CLOSEST = 60  # points of a line on both sides of the strongest contact that are magnified, at least

COLUMNS = ("x", "y", "force", "patch_area", "slope_x", "slope_y", "at_edge")
"""Variables of each contact, without the prefix `contact_`."""

FEWEST_WAVES = 16  # rows and columns from which on a map has a spectrum


def pictured(picture: xarray.Dataset) -> tuple[dict[str, Any], dict[str, str]]:
    """Facts and packed numbers of a picture as `contact_picture` makes it."""
    table = np.stack([picture[f"contact_{name}"].values for name in COLUMNS]).astype(np.float64)
    order = np.argsort(-table[2], kind="stable")
    drawn = order[:MOST_CONTACTS]
    facts = {
        "load": float(picture.attrs["load_mN"]), "member": int(picture.attrs["member"]),
        "moved": listed([float(picture.attrs[name]) for name in ("x", "y")]),
        "contacts": {"columns": list(COLUMNS), "count": int(drawn.size), "all": int(table.shape[1])},
    }  # fmt: skip
    packs = {"contacts": packed(table[:, drawn], CONTACT_BYTES)}
    if "gap" in picture:
        return {"picture": facts | {"lines": _lines(picture, table[:, drawn])}}, packs
    dy, dx = (float(np.diff(picture[name].values[:2])[0]) for name in ("height_y", "height_x"))
    bodies = [picture[f"{side}_height"].transpose("height_y", "height_x").values for side in ("lower", "upper")]
    levels, ends, extent = grey(bodies[0], (dy, dx))
    ranks = np.append(0, np.empty(order.size, np.int64))
    ranks[1 + order] = 1 + np.arange(order.size)
    place = ranks[picture["patch"].transpose("height_y", "height_x").values]
    packs |= {"lower": deflated(levels.tobytes()), "patches": deflated(_thinned(place).astype("<u2").tobytes())}
    spectra = []
    for side, body in zip(("lower", "upper"), bodies, strict=True):
        if np.ptp(body) > 0 and min(body.shape) >= FEWEST_WAVES:
            radial = surface_spectrum(Surface(body, spacing=(dy, dx))).radial()
            spectra.append(
                {"name": f"{side} body", "waveNumber": listed(radial.wave_number), "density": listed(radial.density)}
            )
    rows, columns = levels.shape
    facts |= {"rows": rows, "columns": columns, "range": ends, "extent": extent}
    return {"picture": facts, "spectra": spectra or None}, packs


def _thinned(ranks: NDArray[Any]) -> NDArray[Any]:
    """Ranks of contacts from 1 on over as many pixels as heights have, the strongest of each, and 0 for none."""
    every, most = -(-max(ranks.shape) // MOST_PIXELS), np.iinfo(np.uint16).max
    ranks = np.where((ranks == 0) | (ranks > MOST_CONTACTS), most, ranks)
    ranks = np.pad(ranks, [(0, -size % every) for size in ranks.shape], constant_values=most)
    rows, columns = (size // every for size in ranks.shape)
    found = ranks.reshape(rows, every, columns, every).min(axis=(1, 3))
    return np.asarray(np.where(found == most, 0, found))


def _lines(picture: xarray.Dataset, table: Floats) -> dict[str, Any]:
    """Two lines in contact, in few points whole and in more about the strongest contact: x, lower and upper heights."""
    x, lower = picture["height_x"].values, picture["lower_height"].values
    gap = picture["gap"].values
    there = np.isfinite(gap)  # over holes it is drawn straight
    upper = lower + np.interp(x, x[there], gap[there]).clip(0)
    inside = np.flatnonzero(table[6] == 0)
    apart = np.sort(np.abs(table[0] - table[0][inside[0] if inside.size else 0]))
    middle = float(table[0][inside[0] if inside.size else 0])
    widest = 4 * float(table[3].max())  # of lines 1 µm thick an area is a length
    half = np.clip(1.3 * apart[min(AROUND, apart.size - 1)], max(CLOSEST * (x[1] - x[0]), widest), x[-1] / 7)
    start = float(np.clip(middle - half, 0, max(x[-1] - 2 * half, 0)))
    ends = np.searchsorted(x, [start, start + 2 * half])

    def part(which: slice) -> list[Any]:
        size = x[which].size
        at = np.unique(np.linspace(0, size - 1, min(size, MOST_POINTS)).round().astype(int))
        return [np.round(each[which][at], 5).tolist() for each in (x, lower, upper)]

    return {"whole": part(slice(None)), "close": part(slice(*ends))}


def grey(heights: Floats, spacing: tuple[float, float]) -> tuple[NDArray[np.uint8], list[float], list[float]]:
    """Heights (µm) as bytes between the lowest and the highest, of few pixels; both ends; and the lengths they fill."""
    every = -(-max(heights.shape) // MOST_PIXELS)
    thin = heights[::every, ::every]
    low, high = float(thin.min()), float(thin.max())
    levels = np.rint(255 * (thin - low) / ((high - low) or 1)).astype(np.uint8)
    return levels, [low, high], [count * every * step for count, step in zip(thin.shape, spacing, strict=True)]
