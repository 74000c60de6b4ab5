"""Friction tables for other programs, as text and CSV."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._estimate import Estimate, estimate_column_titles
from stiction._number_format import format_with_unit
from stiction.evaluate.point import SLIDING_RULE_ORDER
from stiction.mechanics.quantities import STIFFNESS_PER_AREA_FACTOR, STIFFNESS_PER_AREA_UNIT, column_title_and_factor
from stiction.summary.assessment import ASSESSMENTS_BY_SEVERITY
from stiction.summary.friction_table import MAX_DEVIATION_FROM_FITTED_LAW
from stiction.views.layout import format_table, wrap_text
from stiction.views.point import SLIDING_RULE_TITLES
from stiction.views.spreadsheet import frame_to_csv

if TYPE_CHECKING:
    import xarray

    from stiction.summary.summary import Summary

_COLUMN_TITLES = {
    "friction_coefficient": ("mu_s", 1.0), "contact_area_fraction": ("A/A0 (%)", 100.0),
    "normal_stiffness": (f"stiffness over area ({STIFFNESS_PER_AREA_UNIT})", 1.0), "approach": ("approach (um)", 1.0),
    "stiffness_factor": (f"b of k/A0 = b p^c ({STIFFNESS_PER_AREA_UNIT} at 1 GPa)", 1.0),
}  # fmt: skip
"""Column titles that replace the titles of `column_title_and_factor`, each with a unit conversion factor."""

MAX_LISTED_REMEDIES = 3
_LOAD_QUANTITIES = tuple(_COLUMN_TITLES)[:4]
_LAW_PARAMETERS = ("area_factor", "stiffness_factor", "stiffness_exponent")
_PRINTED_LAW_UNITS = (("1/GPa", 1.0), ("GPa/um", STIFFNESS_PER_AREA_FACTOR), ("1", 1.0))
_COORDINATE_COLUMNS = ("sliding", "hurst_exponent", "rms", "pressure", "mu0", "tau0")
_LAW_QUANTITIES = (*_LAW_PARAMETERS, "area_deviation", "stiffness_deviation")


def friction_table_csv(table: xarray.Dataset) -> str:
    """Return the dataset of `friction_table` as CSV: columns with units, and one row per combination of inputs.

    Tables that an earlier version computed have no column of assessments.
    """
    names = [name for name in (*_LOAD_QUANTITIES, "assessment") if name in table]
    return _format_law_table(table[names], _COORDINATE_COLUMNS)


def fitted_laws_csv(table: xarray.Dataset) -> str:
    """Return the fitted laws of true area (A/A0 = a p) and stiffness (k/A0 = b p^c) as CSV: one row per roughness."""
    return _format_law_table(table[list(_LAW_QUANTITIES)], _COORDINATE_COLUMNS[1:3])


def _format_law_table(law_table: xarray.Dataset, columns_by_name: tuple[str, ...]) -> str:
    import xarray

    columns: dict[str, Any] = {}
    for name, values in law_table.data_vars.items():
        if name == "assessment":
            columns[name] = values
            continue
        title, factor = _COLUMN_TITLES.get(str(name)) or column_title_and_factor(str(name))
        if "statistic" not in values.dims:
            columns[title] = values * factor
            continue
        for field, column_title in estimate_column_titles(title).items():
            statistic = "mean" if field == "value" else field
            columns[column_title] = values.sel(statistic=statistic, drop=True) * factor
    frame = xarray.Dataset(columns).to_dataframe(dim_order=list(columns_by_name)).reset_index()
    for name in columns_by_name:
        if (factor := column_title_and_factor(name)[1]) != 1:
            frame[name] *= factor
    frame = frame.rename(columns={name: column_title_and_factor(name)[0] for name in columns_by_name})
    return frame_to_csv(frame)


def friction_table_text(table: xarray.Dataset, rules: Sequence[str] = SLIDING_RULE_ORDER) -> str:
    """Return a friction table as text: one row per roughness, with fitted laws, their misfit, and coefficients."""
    pressure_range = " to ".join(format_with_unit(float(table["pressure"][i]), "GPa") for i in (0, -1))
    laws_text = "A/A0 = a p and k/A0 = b p^c with p in GPa; 95 % intervals over the repetitions"
    lines = [wrap_text(f"Pressures of {pressure_range}; {laws_text}"), ""]
    headings = [f"μ_s {SLIDING_RULE_TITLES[rule]}" for rule in rules]
    rows = [["H, Sq", "a (1/GPa)", "b (GPa/µm)", "c", *headings, "largest deviation"]]
    for indices in np.ndindex(table.sizes["hurst_exponent"], table.sizes["rms"]):
        roughness_table = table.isel(hurst_exponent=indices[0], rms=indices[1])
        deviations = [float(roughness_table[f"{name}_deviation"]) for name in ("area", "stiffness")]
        coefficients = roughness_table["friction_coefficient"].sel(statistic="mean")
        rows.append(
            [
                f"{float(roughness_table['hurst_exponent']):.3g}, "
                f"{format_with_unit(float(roughness_table['rms']), 'um')}",
                *(
                    Estimate(*roughness_table[name].values.tolist()).in_unit(unit, factor).text()
                    for name, (unit, factor) in zip(_LAW_PARAMETERS, _PRINTED_LAW_UNITS, strict=True)
                ),
                *(_coefficient_range_text(coefficients.sel(sliding=rule)) for rule in rules),
                ", ".join("none" if np.isnan(deviation) else f"{100 * deviation:.0f} %" for deviation in deviations),
            ]
        )
    lines.append(format_table(rows))
    if max(float(table[f"{name}_deviation"].max()) for name in ("area", "stiffness")) > MAX_DEVIATION_FROM_FITTED_LAW:
        lines += ["", wrap_text("Where a law deviates by more than 10 %, use the tabulated values instead.")]
    return "\n".join(lines) + "\n"


def table_assessment_text(table: xarray.Dataset, summary: Summary) -> str:
    """Return text that counts a table's coefficients by assessment, and states the most frequent remedies.

    `summary` contains the caveats about the coefficients in the table. The text is empty if every coefficient may be
    quoted.
    """
    assessments = table["assessment"].values.ravel().tolist()
    if set(assessments) <= {ASSESSMENTS_BY_SEVERITY[""]}:
        return ""
    assessment_counts = Counter(assessments)
    counts_text = ", ".join(
        f"{text} ({assessment_counts[text]})" for text in ASSESSMENTS_BY_SEVERITY.values() if assessment_counts[text]
    )
    num_points_by_remedy = Counter(
        remedy for point in summary.points for remedy in {fault.remedy for fault in point.faults}
    )
    remedies = "; ".join(remedy for remedy, _ in num_points_by_remedy.most_common(MAX_LISTED_REMEDIES))
    text = f"Assessment of {len(assessments)} coefficients (column assessment): {counts_text}."
    return wrap_text(f"{text} What helps: {remedies}." if remedies else text)


def _coefficient_range_text(coefficients: xarray.DataArray) -> str:
    finite_coefficients = coefficients.values[np.isfinite(coefficients.values)]
    if not finite_coefficients.size:
        return "none"
    smallest_text, largest_text = f"{finite_coefficients.min():.3g}", f"{finite_coefficients.max():.3g}"
    return smallest_text if smallest_text == largest_text else f"{smallest_text} to {largest_text}"
