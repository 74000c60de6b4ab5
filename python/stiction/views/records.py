"""Results as JSON, one schema for every command: a list of values, each with its unit, its interval and where it is.

A record has ``schema`` (this number grows when a reader would have to change), ``stiction`` (the version), ``command``,
what it is about, and ``values``. A value has ``name``, ``value``, ``unit`` ("1" if it has none), ``lower`` and
``upper`` (the 95 % interval), ``at`` (where it is, in µm, mN and GPa) and ``status``. What there is none of is null.
"""

from __future__ import annotations

import dataclasses
import itertools
import json
import math
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._core import __version__
from stiction.mechanics.friction import STATUS_OK
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

if TYPE_CHECKING:
    import xarray

    from stiction.studies.claims import Outcome
    from stiction.studies.store import StoreInfo
    from stiction.surfaces.hurst import HurstEstimate

SCHEMA = 1


def record(command: str, values: list[dict[str, Any]], **about: Any) -> str:
    """A record as JSON text."""
    whole = {"schema": SCHEMA, "stiction": __version__, "command": command, **about, "values": values}
    return json.dumps(whole, ensure_ascii=False, allow_nan=False, indent=1)


def entry(
    name: str, value: float, unit: str = "1", *, lower: float = math.nan, upper: float = math.nan,
    at: dict[str, Any] | None = None, status: str = STATUS_OK,
) -> dict[str, Any]:  # fmt: skip
    """One value."""
    return {
        "name": name, "value": _finite(value), "unit": unit, "lower": _finite(lower), "upper": _finite(upper),
        "at": at or {}, "status": status,
    }  # fmt: skip


def _finite(value: float) -> float | None:
    return float(value) if math.isfinite(value) else None


# ---- Studies ---------------------------------------------------------------------------------------------------------


def study_record(kept: StoreInfo, found: xarray.Dataset | None) -> str:
    """What `stiction info` says of a study; `found` is what `answers` gives."""
    values = [] if found is None else _map_values(found, "friction_coefficient")
    return record(
        "info", values, kind="study", study=kept.study.to_toml(), finished=kept.finished,
        repetitions=kept.study.ensemble.repetitions, bytes=kept.size, versions=dict(kept.versions),
    )  # fmt: skip


def _map_values(found: xarray.Dataset, name: str) -> list[dict[str, Any]]:
    """Every point of what `friction_map` gives."""
    table = found[name]
    values = []
    for place in _places(table):
        one = found.isel(place)
        values.append(
            entry(
                name, float(one[name]), str(table.attrs["units"]), lower=float(one["lower"]), upper=float(one["upper"]),
                at=_at(one[name], place), status=str(one["status"].values),
            )
        )  # fmt: skip
    return values


def point_record(found: list[dict[str, Any]], **at: float) -> str:
    """What `stiction at` says."""
    units = {"friction_coefficient": "1", "contact_area": "um2", "normal_stiffness": "mN/um"}
    values = []
    for one in found:
        where = {
            name: value for name, value in one.items() if isinstance(value, (int, float, str)) and name != "status"
        }
        for name, unit in units.items():
            if name in one:
                value, lower, upper = one[name]
                values.append(entry(name, value, unit, lower=lower, upper=upper, at=where | at, status=one["status"]))
        values += [entry(name, share, at=where | at, status=one["status"]) for name, share in one["validity"].items()]
    return record("at", values, kind="study")


# ---- Pairs -----------------------------------------------------------------------------------------------------------


def pair_record(mean: xarray.Dataset, loads: Any) -> str:
    """What `stiction pair` says: every mean at the loads that were asked for."""
    values: list[dict[str, Any]] = []
    for load in np.atleast_1d(loads):
        at = mean.sel(load=[load], method="nearest")
        for name, table in at.items():
            if "statistic" in table.dims and "load" in table.dims:
                values += _mean_values(str(name), table)
        values += [
            entry("positions_with_an_answer", float(at["ok"].isel(p)), at=_at(at["ok"], p)) for p in _places(at["ok"])
        ]
    unloaded = [str(name) for name, table in mean.items() if "statistic" in table.dims and "load" not in table.dims]
    values += [value for name in unloaded for value in _mean_values(name, mean[name])]
    about = {
        name: str(mean.attrs[name])
        for name in ("title", "mechanics", "upper", "lower", "detection", "law", "curvature")
        if name in mean.attrs and name not in mean.dims
    }
    positions = int((mean["positions"] if "positions" in mean else mean["shifts"]).max())
    return record(
        "pair", values, kind="pair", positions=positions, effective_modulus=float(mean["effective_modulus"]), **about
    )


def _mean_values(name: str, table: xarray.DataArray) -> list[dict[str, Any]]:
    values = []
    for place in _places(table.isel(statistic=0)):
        one = table.isel(place)
        mean, lower, upper = (float(one.sel(statistic=each)) for each in ("mean", "lower", "upper"))
        unit = str(table.attrs.get("units", "1"))
        values.append(
            entry(
                name,
                mean,
                unit,
                lower=lower,
                upper=upper,
                at=_at(one, place),
                status=STATUS_OK if mean == mean else "no-mean",
            )
        )
    return values


_ABOUT = ("statistic", "effective_modulus", "nominal_area")
"""Coordinates that do not say where a value is."""


def _places(table: xarray.DataArray) -> list[dict[str, int]]:
    dims = [str(dim) for dim in table.dims]
    ranges = (range(table.sizes[dim]) for dim in dims)
    return [dict(zip(dims, place, strict=True)) for place in itertools.product(*ranges)]


def _at(table: xarray.DataArray, place: dict[str, int]) -> dict[str, Any]:
    """Coordinates of one value, those of its own dimensions and single ones."""
    one = table.isel({dim: index for dim, index in place.items() if dim in table.dims})
    return {str(name): each.values.item() for name, each in one.coords.items() if each.ndim == 0 and name not in _ABOUT}


# ---- Measured surfaces -----------------------------------------------------------------------------------------------


def characterisation(body: Profile | Surface, band: tuple[float, float] | None = None) -> list[dict[str, Any]]:
    """Roughness of one profile or surface as values.

    Parameters
    ----------
    body : Profile or Surface
        Levelled.
    band : (float, float), µm, optional
        Wavelengths to fit the Hurst exponent to.
    """
    from stiction.surfaces.roughness import roughness_parameters
    from stiction.surfaces.spectrum import spectral_moments
    from stiction.surfaces.surface_parameters import surface_parameters

    if isinstance(body, Profile):
        parameters: Any = roughness_parameters(body)
        neighbours = roughness_parameters(body, derivative="neighbours").Pdq
        moments = spectral_moments(body)
        extra = [
            entry("Pdq_neighbours", neighbours), entry("m0", moments.height, "um2"), entry("m2", moments.slope),
            entry("m4", moments.curvature, "1/um2"), entry("nayak_parameter", moments.nayak_parameter),
        ]  # fmt: skip
    else:
        parameters = surface_parameters(body)
        extra = []
    values = [
        entry(each.name, getattr(parameters, each.name), _unit(each.name)) for each in dataclasses.fields(parameters)
    ]
    return values + extra + _hurst(body, band)


_LENGTHS = ("Pa", "Pq", "Pt", "Sq", "Sa", "Sz", "Sal", "Sk", "Spk", "Svk")


def _unit(name: str) -> str:
    return "um" if name in _LENGTHS else "degrees" if name == "Std" else "1"


def _hurst(body: Profile | Surface, band: tuple[float, float] | None) -> list[dict[str, Any]]:
    from stiction.surfaces.hurst import hurst_exponent_of

    names = ("hurst_exponent", "shortest_wavelength", "longest_wavelength")
    try:
        estimate: HurstEstimate = hurst_exponent_of(body, band=band)
    except ValueError:
        if band is not None:
            raise
        return [
            entry(name, math.nan, unit, status="no-band") for name, unit in zip(names, ("1", "um", "um"), strict=True)
        ]
    return [
        entry(names[0], estimate.value, lower=estimate.lower, upper=estimate.upper),
        entry(names[1], estimate.shortest_wavelength, "um"),
        entry(names[2], estimate.longest_wavelength, "um"),
    ]


def characterisation_record(bodies: Sequence[tuple[str, Profile | Surface, list[dict[str, Any]]]]) -> str:
    """What `stiction characterise` says of files: each by its name, what it holds, and its values."""
    values = [value | {"at": {"file": file}} for file, _, each in bodies for value in each]
    surfaces = [_surface(file, body) for file, body, _ in bodies]
    return record("characterise", values, kind="surface", surfaces=surfaces)


def _surface(file: str, body: Profile | Surface) -> dict[str, Any]:
    return {
        "file": file, "holds": "profile" if isinstance(body, Profile) else "surface",
        "points": list(np.shape(body.heights)), "spacing_um": np.atleast_1d(body.spacing).tolist(),
        "extent_um": np.atleast_1d(body.extent).tolist(), "history": list(body.history),
    }  # fmt: skip


def characterisation_csv(bodies: Sequence[tuple[str, Profile | Surface, list[dict[str, Any]]]]) -> str:
    """A row for each file, a column for each value with its unit; empty where a file has none."""
    columns: dict[str, str] = {}
    for _, _, values in bodies:
        for value in values:
            unit = "" if value["unit"] == "1" else f" ({value['unit']})"
            columns.setdefault(value["name"], f"{value['name']}{unit}")
    header = ["file", "holds", "points", "spacing (um)"]
    for name, title in columns.items():
        header += [title, f"{name} lower", f"{name} upper"] if name == "hurst_exponent" else [title]
    rows = [header]
    for file, body, values in bodies:
        about = _surface(file, body)
        known = {value["name"]: value for value in values}
        row = [_quoted(file), about["holds"], _joined(about["points"]), _joined(about["spacing_um"])]
        for name in columns:
            keys = ("value", "lower", "upper") if name == "hurst_exponent" else ("value",)
            row += [_cell(known.get(name, {}).get(key)) for key in keys]
        rows.append(row)
    return "".join(",".join(row) + "\n" for row in rows)


def _joined(numbers: Sequence[float]) -> str:
    return " x ".join(f"{number:.12g}" for number in numbers)


def _cell(value: float | None) -> str:
    return "" if value is None else f"{value:.9g}"


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if any(each in text for each in ',"\n') else text


# ---- Claims ----------------------------------------------------------------------------------------------------------


def claims_record(outcomes: Sequence[Outcome]) -> str:
    """What `stiction claims` says: the status of each number is its verdict."""
    from stiction.studies.claims import CLAIMS, verdict_of

    values = [
        entry(
            each.part.name, each.value, lower=each.lower, upper=each.upper, status=each.verdict,
            at={"claim": each.part.claim, "statement": each.part.statement, "least": _finite(each.part.least),
                "most": _finite(each.part.most), "left_out": list(each.left_out)},
        )
        for each in outcomes
    ]  # fmt: skip
    claims = [
        {"claim": number, "statement": statement, "verdict": verdict_of(number, list(outcomes))}
        for number, statement in CLAIMS.items()
    ]
    return record("claims", values, kind="claims", claims=claims)
