"""A table for a contact law: as text for the terminal, and as CSV for other programs."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction.studies.friction_table import STRAIGHT

if TYPE_CHECKING:
    import xarray

_ENDS = ("", ": lower", ": upper")


def friction_table_csv(table: xarray.Dataset) -> str:
    """A row for each sliding rule, H, Sq, pressure, mu0 and tau0; units in the header.

    Parameters
    ----------
    table : xarray.Dataset
        What `friction_table` returns.
    """
    columns = {
        "friction_coefficient": ("mu_s", 1.0),
        "contact_area_fraction": ("A/A0 (%)", 100.0),
        "normal_stiffness": ("stiffness over area (GPa/um)", 1.0),
        "approach": ("approach (um)", 1.0),
    }
    header = ["rubbing contacts", "H", "Sq (um)", "pressure (MPa)", "mu0", "tau0 (MPa)"]
    header += [f"{title}{end}" for title, _ in columns.values() for end in _ENDS]
    rows = [header]
    dims = ("sliding", "hurst_exponent", "rms", "pressure", "mu0", "tau0")
    units = (None, 1.0, 1.0, 1000.0, 1.0, 1000.0)
    for place in np.ndindex(*(table.sizes[name] for name in dims)):
        at = table.isel(dict(zip(dims, place, strict=True)))
        head = [str(at[name].values) if unit is None else f"{float(at[name]) * unit:.9g}"
                for name, unit in zip(dims, units, strict=True)]  # fmt: skip
        rows.append(
            head + [_number(factor * value) for name, (_, factor) in columns.items() for value in at[name].values]
        )
    return "".join(",".join(row) + "\n" for row in rows)


def laws_csv(table: xarray.Dataset) -> str:
    """The fitted laws A/A0 = a p and k/A0 = b p^c, with p in GPa: a row for each H and Sq.

    Parameters
    ----------
    table : xarray.Dataset
        What `friction_table` returns.
    """
    columns = {
        "area_factor": "a of A/A0 = a p (1/GPa)",
        "stiffness_factor": "b of k/A0 = b p^c (GPa/um at 1 GPa)",
        "stiffness_exponent": "c of k/A0 = b p^c",
    }
    header = ["H", "Sq (um)", *(f"{title}{end}" for title in columns.values() for end in _ENDS)]
    header += ["largest deviation of A/A0", "largest deviation of k/A0"]
    rows = [header]
    for place in np.ndindex(table.sizes["hurst_exponent"], table.sizes["rms"]):
        at = table.isel(hurst_exponent=place[0], rms=place[1])
        values: list[Any] = [at["hurst_exponent"], at["rms"]]
        values += [value for name in columns for value in at[name].values]
        values += [at["area_deviation"], at["stiffness_deviation"]]
        rows.append([_number(float(value)) for value in values])
    return "".join(",".join(row) + "\n" for row in rows)


def _number(value: float) -> str:
    return "" if np.isnan(value) else f"{value:.9g}"


def friction_table_text(table: xarray.Dataset) -> str:
    """The fitted laws of each roughness, and between which values its coefficients are.

    Parameters
    ----------
    table : xarray.Dataset
        What `friction_table` returns.
    """
    pressure = 1000 * table["pressure"].values
    lines = [
        f"pressures of {pressure[0]:.4g} to {pressure[-1]:.4g} MPa; A/A0 = a p and k/A0 = b p^c with p in GPa, "
        "95 % intervals over the pairs",
        "",
    ]
    rows = [["H", "Sq (µm)", "a (1/GPa)", "b (GPa/µm)", "c", "mu_s, opposing", "mu_s, all", "off the laws by"]]
    doubted = False
    for place in np.ndindex(table.sizes["hurst_exponent"], table.sizes["rms"]):
        at = table.isel(hurst_exponent=place[0], rms=place[1])
        off = [float(at[f"{name}_deviation"]) for name in ("area", "stiffness")]
        doubted = doubted or max(off) > STRAIGHT
        coefficients = at["friction_coefficient"].sel(statistic="mean")
        rows.append(
            [
                f"{float(at['hurst_exponent']):.3g}", f"{float(at['rms']):.4g}",
                *(_interval(at[name].values) for name in ("area_factor", "stiffness_factor", "stiffness_exponent")),
                *(_span(coefficients.sel(sliding=rule)) for rule in ("opposing", "all")),
                ", ".join("none" if np.isnan(each) else f"{100 * each:.0f} %" for each in off),
            ]
        )  # fmt: skip
    widths = [max(map(len, column)) + 2 for column in zip(*rows, strict=True)]
    lines += ["".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    if doubted:
        lines += ["", "Where a law is off by more than 10 % the numbers of the table say more than the law."]
    return "\n".join(lines) + "\n"


def _interval(statistics: Any) -> str:
    mean, lower, upper = (float(value) for value in statistics)
    if np.isnan(mean):
        return "none"
    return f"{mean:.3g}" if np.isnan(lower) else f"{mean:.3g} [{lower:.3g}, {upper:.3g}]"


def _span(coefficients: xarray.DataArray) -> str:
    known = coefficients.values[np.isfinite(coefficients.values)]
    return f"{known.min():.3g} to {known.max():.3g}" if known.size else "none"
