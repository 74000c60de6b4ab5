"""The page of two measured surfaces, of what `stiction pair` writes.

Of maps it carries the sums that normal and tangential load are made of, at every position, so every mu0 and tau0 is at
hand. Of lines each position carries the load with its friction on slopes, so the page has the values of the result.
"""

from __future__ import annotations

import base64
import html
import zlib
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction._text import printable
from stiction.mechanics.friction import STATUS_OK
from stiction.studies.intervals import CONFIDENCE, FEWEST_OF_SAMPLE
from stiction.surfaces.surface import Surface
from stiction.surfaces.surface_spectrum import surface_spectrum
from stiction.views.figures import SHARE_LIMIT
from stiction.views.report.page import Page, ReportError, packed

if TYPE_CHECKING:
    import xarray

MAPS = "stiction pair of maps"
LINES = "stiction traverse"
"""Titles of what `pair` writes."""

SUMS = (
    "normal_elastic", "normal_frictional", "normal_adhesive", "tangential_elastic", "tangential_frictional",
    "tangential_adhesive",
)  # fmt: skip
"""In the order of `coefficientOf`."""

MOST_VALUES = 2_000_000
"""Numbers of a page."""

MOST_PIXELS = 256
"""Rows or columns of the heights that are drawn."""

MOST_CONTACTS = 400
"""That are drawn at a load: those with the largest forces."""

CONTACT_BYTES = 4
"""Leading bytes of a double that are kept of what is only drawn."""

MOST_TEXT = 20_000
"""Characters of the table in words."""

QUANTITIES = {
    "contact_area_fraction": ("true area A/A0", "%", 100.0),
    "contact_area": ("true area A", "µm²", 1.0),
    "contact_count": ("contacts", "", 1.0),
    "normal_stiffness": ("normal stiffness", "mN/µm", 1.0),
    "approach": ("approach", "nm", 1000.0),
    "rms_gradient": ("rms gradient of the gap", "", 1.0),
    "share_on_largest": ("load on the contact that carries most", "%", 100.0),
    "share_at_edge": ("load on contacts that the edge cuts", "%", 100.0),
    "load_share_at_hardness": ("load where the pressure is the hardness", "%", 100.0),
    "share_beyond_hertz": ("load beyond Hertz (overlap > radius / 10)", "%", 100.0),
    "share_below_grid": ("load on radii below the grid spacing", "%", 100.0),
    "share_overlapping": ("load on ellipses that overlap", "%", 100.0),
    "error": ("error of the solution", "", 1.0),
}
"""What the page says of each load beside friction: words, unit and factor to it."""

WARNED = ("share_on_largest", "share_at_edge", "share_beyond_hertz", "share_below_grid", "share_overlapping")

RULES = {
    "opposing": ("opposing contacts rub, the others do not (the paper's rule)", "opposing"),
    "all": ("all contacts rub", "all"),
}


def pair_page(result: xarray.Dataset) -> Page:
    """The page of a result of `pair`, with its table in words.

    Raises
    ------
    ReportError
        If something that a page needs is not in the result, or it is too large.
    """
    is_maps = result.attrs["title"] == MAPS
    for name in (*_NEEDED, *((*SUMS, *_OF_MAPS) if is_maps else _OF_LINES)):
        if name not in result.variables:
            raise ReportError(f"the result has no {name}; press the surfaces again with this version to make a page")
    for name in ("loads_mN", "upper", "lower"):
        if name not in result.attrs:
            raise ReportError(f"the result does not say its {name}; it is not what `stiction pair` writes")
    modulus, area = (np.ravel(result[name].values) for name in ("effective_modulus", "nominal_area"))
    loads = result["load"].values
    for name, values, is_list in (
        ("effective_modulus", modulus, False), ("nominal_area", area, False), ("load", loads, True),
        ("loads_mN", np.ravel(result.attrs["loads_mN"]), True), ("mu0", 1 + np.ravel(result["mu0"].values), True),
        ("tau0", 1 + np.ravel(result["tau0"].values), True),
    ):  # fmt: skip
        is_number = values.dtype.kind in "fi" and values.size > 0 and bool((np.isfinite(values) & (values > 0)).all())
        if not is_number or (values.size > 1 and not (is_list and (np.diff(values) > 0).all())):
            raise ReportError(f"the result has a {name} that is no number, or numbers that do not rise")
    try:
        facts, numbers = (_of_maps if is_maps else _of_lines)(result)
        words = _words(result)
    except (KeyError, IndexError, TypeError, AttributeError) as error:
        raise ReportError(f"the result is not what `stiction pair` writes: {printable(error)}") from None
    return _page(result, is_maps, float(modulus[0]), float(area[0]), facts, numbers, words)


_NEEDED = ("effective_modulus", "nominal_area", "load", "mu0", "tau0", "friction_coefficient", "contact_area")
_OF_MAPS = ("sliding", "direction", "rms_gradient", "rms_slope")
_OF_LINES = ("shear", "line", "offset", "status")


def _words(result: xarray.Dataset) -> str:
    """The table that `pair` prints of its result."""
    loads = np.atleast_1d(result.attrs["loads_mN"])
    if result.attrs["title"] == MAPS:
        from stiction.studies.map_pair import means_of_all
        from stiction.views.map_pair import map_pair_text

        return map_pair_text(result, means_of_all(result), loads)
    from stiction.views.traverse import means, traverse_text

    return traverse_text(result, means(result), loads)


def _page(
    result: xarray.Dataset,
    is_maps: bool,
    modulus: float,
    area: float,
    facts: dict[str, Any],
    numbers: dict[str, str],
    words: str,
) -> Page:
    loads, asked = result["load"].values, float(np.atleast_1d(result.attrs["loads_mN"])[0])
    common: dict[str, Any] = {
        "kind": "maps" if is_maps else "lines",
        "confidence": CONFIDENCE,
        "fewest": FEWEST_OF_SAMPLE,
        "modulus": modulus,
        "mu0": _listed(np.atleast_1d(result["mu0"].values)),
        "tau0": _listed(np.atleast_1d(result["tau0"].values)),
        "contactBytes": CONTACT_BYTES,
        "bytes": {},
        "loads": _listed(loads),
        "pressures": _listed(1000 * loads / area),
        "asked": int(np.argmin(np.abs(loads - asked))),
    }
    common |= {"mu0Most": max(1.0, *common["mu0"]), "tau0Most": max(20 * modulus, 1000 * max(common["tau0"]))}
    of = str(result.attrs.get("files", "two measured surfaces"))
    bodies = [f"{side}: {'; '.join(str(result.attrs[side]).splitlines()[:8])}" for side in ("upper", "lower")]
    one_law = "law" in result.attrs and "mechanics" not in result.dims
    law = "" if is_maps or not one_law else f", law {result.attrs['law']}"
    interval = (
        "Intervals are over positions of these two surfaces, which have heights in common: other pieces of them may "
        "differ by more."
    )
    return Page(
        kind="pair",
        name=of,
        head=[*bodies, f"E* = {modulus:g} GPa{law}. {'Areas' if is_maps else 'Lines'}, {area:.4g} µm²."],
        words={
            "interval": interval,
            "percent": f"{100 * CONFIDENCE:g} %",
            "words": html.escape("\n".join(printable(line, 400) for line in words[:MOST_TEXT].splitlines())),
        },
        facts=common | facts,
        numbers=numbers,
        versions=f"Computed by stiction {result.attrs.get('stiction_version', 'unknown')}",
    )


def _listed(values: Any) -> Any:
    """Numbers for JSON, which has no NaN."""
    array = np.asarray(values, dtype=np.float64)
    return np.where(np.isfinite(array), array, np.asarray(None)).tolist()


def _quantities(result: xarray.Dataset) -> list[dict[str, Any]]:
    return [
        {
            "name": name, "words": words[0].upper() + words[1:], "unit": unit, "factor": factor,
            "limit": SHARE_LIMIT if name in WARNED else None,
        }
        for name, (words, unit, factor) in QUANTITIES.items()
        if name in result
        and not (name == "contact_area" and "contact_area_fraction" in result)
        and not (name == "load_share_at_hardness" and "hardness_GPa" not in result.attrs)
    ]  # fmt: skip


def _check_size(*arrays: Floats) -> None:
    values = sum(int(np.size(array)) for array in arrays)
    if values > MOST_VALUES:
        raise ReportError(f"the result has {values} numbers, more than the {MOST_VALUES} that a page can hold")


# ---- Maps ------------------------------------------------------------------------------------------------------------


def _of_maps(result: xarray.Dataset) -> tuple[dict[str, Any], dict[str, str]]:
    if "mechanics" not in result.dims:
        result = result.expand_dims(mechanics=[str(result.attrs["mechanics"])])
    order = ("mechanics", "sliding", "direction", "shift", "load")
    sums = [
        result[name].expand_dims({dim: result[dim] for dim in order if dim not in result[name].dims}).transpose(*order)
        for name in SUMS
    ]
    numbers = np.stack([each.values for each in sums])
    _check_size(numbers)
    surrogate = result["surrogate"].values if "surrogate" in result.coords else np.zeros(result.sizes["shift"], bool)
    kinds = [
        {"words": words, "places": np.flatnonzero(surrogate == is_surrogate).tolist()}
        for is_surrogate, words in ((False, "shifts of the two maps"), (True, "pairs of surrogates"))
        if (surrogate == is_surrogate).any()
    ]
    rules = [str(each) for each in result["sliding"].values]
    if not set(rules) <= set(RULES):
        raise ReportError(f"the result has sliding rules that are unknown: {printable(rules)}")
    quantities = _quantities(result)
    by_place = ("mechanics", "shift", "load")
    contact = {}
    for each in quantities:
        variable = result[each["name"]]
        variable = variable.expand_dims({dim: result[dim] for dim in by_place if dim not in variable.dims})
        contact[each["name"]] = _listed(variable.transpose(*by_place).values)
    facts = {
        "mechanics": [printable(each) for each in result["mechanics"].values],
        "series": [{"name": rule, "words": RULES[rule][0], "short": RULES[rule][1]} for rule in rules],
        "directions": _listed(result["direction"].values),
        "kinds": kinds,
        "shape": [result.sizes[dim] for dim in order[1:]],
        "quantities": quantities,
        "contact": contact,
        "positionsAre": "position",
        "gap": _gap(result),
        "picture": None,
        "contacts": None,
        "spectra": None,
    }
    packs = {"sums": packed(numbers, 8)}
    if "lower_height" in result and "contact_x" in result:
        drawn, more = _pictured(result)
        facts |= drawn
        packs |= more
    return facts, packs


def _gap(result: xarray.Dataset) -> dict[str, Any] | None:
    """What friction by the slope alone is made of."""
    gradient, slope = result["rms_gradient"], result["rms_slope"]
    if "mechanics" in gradient.dims:
        gradient, slope = gradient.isel(mechanics=0), slope.isel(mechanics=0)
    if not ((gradient > 0).all() and (slope > 0).all()):
        return None
    from inspect import signature

    from stiction.mechanics.closed_forms import gentle_friction

    return {
        "gradient": _listed(gradient.values),
        "slope": _listed(slope.transpose("direction", "shift").values),
        "kappa": float(signature(gentle_friction).parameters["kappa"].default),
    }


_COLUMNS = ("x", "y", "force", "slope_x", "slope_y")


def _pictured(result: xarray.Dataset) -> tuple[dict[str, Any], dict[str, str]]:
    """Heights of both bodies at one position as bytes, their spectra, and the contacts there."""
    shift = int(result.attrs["pictured_shift"])
    along_y, along_x = result["height_y"].values, result["height_x"].values
    bodies = [result[f"{side}_height"].transpose("height_y", "height_x").values for side in ("lower", "upper")]
    _check_size(*bodies)
    if not all(np.isfinite(body).all() for body in (*bodies, along_y, along_x)) or min(bodies[0].shape) < 2:
        raise ReportError("the result has heights that are no numbers")
    dy, dx = float(along_y[1] - along_y[0]), float(along_x[1] - along_x[0])
    every = -(-max(bodies[0].shape) // MOST_PIXELS)
    ranges, packs, spectra = [], {}, []
    for side, body in zip(("lower", "upper"), bodies, strict=True):
        thin = body[::every, ::every]
        low, high = float(thin.min()), float(thin.max())
        levels = np.rint(255 * (thin - low) / ((high - low) or 1)).astype(np.uint8)
        packs[side] = base64.b64encode(zlib.compress(levels.tobytes(), 9)).decode("ascii")
        ranges.append([low, high])
        if high > low and min(body.shape) >= _FEWEST_WAVES:
            radial = surface_spectrum(Surface(body, spacing=(dy, dx))).radial()
            spectra.append(
                {
                    "name": f"{side} body",
                    "wavelength": _listed(2 * np.pi / radial.wave_number[::-1]),
                    "density": _listed(radial.density[::-1]),
                }
            )
    rows, columns = thin.shape
    lists, listed, first = [], [], 0
    own = result["contact_shift"].values == shift
    of_load, of_mechanics = result["contact_load"].values, result["contact_mechanics"].values
    table = np.stack([result[f"contact_{name}"].values for name in _COLUMNS]).astype(np.float64)
    if not np.isfinite(table).all():
        raise ReportError("the result has contacts that are no numbers")
    for mechanics in range(result.sizes["mechanics"]):
        for load in np.unique(of_load):
            rows_of = np.flatnonzero(own & (of_load == load) & (of_mechanics == mechanics))
            drawn = rows_of[np.argsort(-table[2][rows_of], kind="stable")[:MOST_CONTACTS]]
            listed.append(table[:, drawn])
            lists.append(
                {
                    "mechanics": mechanics, "load": int(load), "first": first, "count": int(drawn.size),
                    "all": int(rows_of.size),
                }
            )  # fmt: skip
            first += drawn.size
    packs["contacts"] = packed(np.concatenate(listed, axis=1) if listed else np.empty(0), CONTACT_BYTES)
    return {
        "picture": {
            "rows": rows, "columns": columns, "ranges": ranges, "shift": shift,
            "extent": [rows * every * dy, columns * every * dx],
        },
        "contacts": {"columns": list(_COLUMNS), "lists": lists},
        "spectra": spectra or None,
    }, packs  # fmt: skip


_FEWEST_WAVES = 16


# ---- Lines -----------------------------------------------------------------------------------------------------------


def _of_lines(result: xarray.Dataset) -> tuple[dict[str, Any], dict[str, str]]:
    from stiction.studies.traverse import of_each_mechanics, traverse_mean
    from stiction.views.traverse import NAMES

    # Of several mechanics the page shows the first, the exact one.
    result = of_each_mechanics(result)[0]
    mechanics = NAMES["half-space"]
    if result.attrs.get("mechanics", "asperities") == "asperities":
        mechanics = f"asperities, law {printable(result.attrs.get('law', ''))}"
    whole = result
    for name in ("mu0", "tau0"):
        if name not in whole.dims:
            whole = whole.expand_dims(name)
    area = float(result["nominal_area"])
    mean = traverse_mean(result)
    for name in ("mu0", "tau0"):
        if name not in mean.dims:
            mean = mean.expand_dims(name)
    mean["contact_area_fraction"] = mean["contact_area"] / area
    sizes = whole.sizes
    materials = sizes["mu0"] * sizes["tau0"]
    known = whole["friction_coefficient"].where(whole["status"] == STATUS_OK)
    values = np.asarray(known.transpose("shear", "load", "mu0", "tau0", "line", "offset").values)
    _check_size(values, mean["friction_coefficient"].values)
    quantities = _quantities(mean)
    names = ["friction_coefficient", *(each["name"] for each in quantities)]
    facts = {
        "mechanics": [mechanics],
        "series": [
            {"name": str(way), "words": f"the upper body moves to {way}", "short": f"to {way}"}
            for way in ("+x" if each == "+x" else "-x" for each in result["shear"].values)
        ],
        "directions": [0.0],
        "kinds": [{"words": "positions and lines", "places": []}],
        "quantities": quantities,
        "means": {
            name: _listed(
                mean[name].transpose("shear", "load", "mu0", "tau0", "statistic").values.reshape(
                    sizes["shear"], sizes["load"], materials, 3
                )
            )
            for name in names
        },
        "coefficients": _listed(values.reshape(sizes["shear"], sizes["load"], materials, -1)),
        "positionsAre": "position, line after line",
        "gap": None,
        "picture": None,
        "contacts": None,
        "spectra": None,
    }  # fmt: skip
    return facts, {}
