"""A table for a contact law of another code: as text for the terminal, and as CSV."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray

from stiction._number_format import with_interval, with_unit
from stiction.mechanics.quantities import column_of
from stiction.studies.friction_table import STRAIGHT
from stiction.views.spreadsheet import csv_of_frame
from stiction.views.text import aligned, fitted

_TITLES = {
    "friction_coefficient": ("mu_s", 1.0), "contact_area_fraction": ("A/A0 (%)", 100.0),
    "normal_stiffness": ("stiffness over area (GPa/um)", 1.0), "approach": ("approach (um)", 1.0),
    "stiffness_factor": ("b of k/A0 = b p^c (GPa/um at 1 GPa)", 1.0),
}  # fmt: skip
"""Columns that a table calls otherwise than `column_of`, and the factor to their units."""

_OF_LOADS = tuple(_TITLES)[:4]
_FACTORS = ("area_factor", "stiffness_factor", "stiffness_exponent")
_PLACES = ("sliding", "hurst_exponent", "rms", "pressure", "mu0", "tau0")
_OF_LAWS = (*_FACTORS, "area_deviation", "stiffness_deviation")


def friction_table_csv(table: xarray.Dataset) -> str:
    """What `friction_table` returns: a row for each rule, H, Sq, pressure, mu0 and tau0; units in the header."""
    return _csv(table[list(_OF_LOADS)], _PLACES)


def laws_csv(table: xarray.Dataset) -> str:
    """The fitted laws A/A0 = a p and k/A0 = b p^c of a `friction_table`, with p in GPa: a row for each H and Sq."""
    return _csv(table[list(_OF_LAWS)], _PLACES[1:3])


def _csv(part: xarray.Dataset, places: tuple[str, ...]) -> str:
    columns: dict[str, Any] = {}
    for name, values in part.data_vars.items():
        title, factor = _TITLES.get(str(name)) or column_of(str(name))
        if "statistic" not in values.dims:
            columns[title] = values * factor
            continue
        for end, statistic in (("", "mean"), (": lower", "lower"), (": upper", "upper")):
            columns[f"{title}{end}"] = values.sel(statistic=statistic, drop=True) * factor
    frame = xarray.Dataset(columns).to_dataframe(dim_order=list(places)).reset_index()
    for name in places:
        if (factor := column_of(name)[1]) != 1:
            frame[name] *= factor
    frame = frame.rename(columns={name: column_of(name)[0] for name in places})
    return csv_of_frame(frame)


def friction_table_text(table: xarray.Dataset) -> str:
    """The fitted laws of each roughness of a `friction_table`, and between which values its coefficients are."""
    ends = " to ".join(with_unit(float(table["pressure"][i]), "GPa") for i in (0, -1))
    laws = "A/A0 = a p and k/A0 = b p^c with p in GPa; 95 % intervals over the pairs"
    lines = [fitted(f"Pressures of {ends}; {laws}"), ""]
    rows = [["H, Sq", "a (1/GPa)", "b (GPa/µm)", "c", "μ_s all contacts", "μ_s opposing contacts", "largest deviation"]]
    for place in np.ndindex(table.sizes["hurst_exponent"], table.sizes["rms"]):
        at = table.isel(hurst_exponent=place[0], rms=place[1])
        off = [float(at[f"{name}_deviation"]) for name in ("area", "stiffness")]
        coefficients = at["friction_coefficient"].sel(statistic="mean")
        rows.append(
            [
                f"{float(at['hurst_exponent']):.3g}, {with_unit(float(at['rms']), 'um')}",
                *(with_interval(*at[name].values.tolist()).replace(" no interval", "") for name in _FACTORS),
                *(_span(coefficients.sel(sliding=rule)) for rule in ("all", "opposing")),
                ", ".join("none" if np.isnan(each) else f"{100 * each:.0f} %" for each in off),
            ]
        )  # fmt: skip
    lines.append(aligned(rows))
    if max(float(table[f"{name}_deviation"].max()) for name in ("area", "stiffness")) > STRAIGHT:
        lines += ["", fitted("Where a law is off by more than 10 %, take the numbers of the table instead.")]
    return "\n".join(lines) + "\n"


def _span(coefficients: xarray.DataArray) -> str:
    known = coefficients.values[np.isfinite(coefficients.values)]
    if not known.size:
        return "none"
    low, high = f"{known.min():.3g}", f"{known.max():.3g}"
    return low if low == high else f"{low} to {high}"
