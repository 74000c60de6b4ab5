"""Onset of sliding, as a sentence, a table and a JSON record."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import (
    choose_prefixed_unit,
    format_estimate,
    format_percent,
    format_with_interval,
    format_with_unit,
)
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.onset import PRESLIDING_PARAMETERS
from stiction.studies.point import MEAN_AND_LIMITS

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study
    from stiction.views.resolution import Paragraph

HALF_SLIDING_LOAD_FRACTION = 0.5
CYCLE_AMPLITUDES = (0.5, 0.9)  # amplitudes of cyclic tangential loading, relative to the sliding load


def onset_text(onset: xarray.Dataset) -> str:
    """Return a sentence with the pre-sliding displacement, the slipping fraction and the tangential stiffness."""
    displacement_phrases, displacement = [], onset["displacement_at_sliding"]
    if math.isfinite(_mean_with_limits(displacement)[0]):
        factor, unit = _length_display_factor(displacement)
        displacement_phrases.append(
            f"pre-sliding displacement {format_estimate(*_mean_with_limits(displacement, factor))} {unit}"
        )
    slipped_area = _mean_with_limits(onset["slipped_area"].sel(fraction=HALF_SLIDING_LOAD_FRACTION))
    displacement_phrases.append(f"{format_percent(slipped_area[0])} of the contact slips at half of the sliding load")
    factor, unit = _stiffness_display_factor(onset["stiffness"])
    if math.isfinite((stiffness_interval := _mean_with_limits(onset["stiffness"], factor))[0]):
        displacement_phrases.append(f"initial tangential stiffness {format_estimate(*stiffness_interval)} {unit}")
    text = "; ".join(displacement_phrases)
    return text[0].upper() + text[1:] + "."


def _length_display_factor(table: xarray.DataArray) -> tuple[float, str]:
    """Return the factor that converts µm to the unit in which a mean length has the fewest zeros, and this unit."""
    value = _mean_with_limits(table)[0]
    prefix_factor, unit = choose_prefixed_unit(value if math.isfinite(value) else 0.0, "um")
    return 1 / prefix_factor, unit


def _stiffness_display_factor(table: xarray.DataArray) -> tuple[float, str]:
    """Return the factor that converts mN/µm to the unit in which a mean stiffness is printed, and this unit."""
    return (1e-3, "N/µm") if _mean_with_limits(table)[0] >= MIN_STIFFNESS_PRINTED_IN_NEWTON else (1.0, "mN/µm")


MIN_STIFFNESS_PRINTED_IN_NEWTON = 1e4  # stiffnesses above this limit (mN/µm) are printed in N/µm


def onset_rows(onset: xarray.Dataset) -> list[list[str]]:
    """Return table rows with means and intervals for the onset of sliding; the first row contains the headings."""
    half_load_onset = onset.sel(fraction=HALF_SLIDING_LOAD_FRACTION)
    length_factor, length_unit = _length_display_factor(onset["displacement_at_sliding"])
    (stiffness_factor, stiffness_unit), (unloading_factor, unloading_unit) = (
        _stiffness_display_factor(onset[name]) for name in ("stiffness", "unloading_stiffness")
    )
    tables = {
        "sliding load (mN)": (onset["sliding_load"], 1.0),
        f"pre-sliding displacement ({length_unit})": (onset["displacement_at_sliding"], length_factor),
        f"tangential stiffness ({stiffness_unit})": (onset["stiffness"], stiffness_factor),
        f"normal stiffness during unloading, as measured by ultrasound ({unloading_unit})": (
            onset["unloading_stiffness"],
            unloading_factor,
        ),
        "contact that slips at half of the sliding load (%)": (half_load_onset["slipped_area"], 100.0),
        "load on the slipping contact (%)": (half_load_onset["slipped_load"], 100.0),
        **{
            f"energy dissipated in a cycle of {amplitude:g} times the sliding load (pJ)": (
                onset["energy_lost"].sel(fraction=amplitude),
                1000.0,
            )
            for amplitude in CYCLE_AMPLITUDES
        },
    }
    rows = [[label, format_with_interval(*_mean_with_limits(*table))] for label, table in tables.items()]
    load, tau0 = format_with_unit(float(onset.attrs["load_mN"]), "mN"), _tau0_text(float(onset.attrs["tau0_GPa"]))
    header = f"{load}, μ0 = {float(onset.attrs['mu0']):g}, τ0 = {tau0}"
    return [["onset of sliding", header], *(row for row in rows if row[1] != "none")]


def onset_note(onset: xarray.Dataset) -> str:
    """Return a note about the number of averaged members and the assumptions for the onset of sliding."""
    attributes = onset.attrs
    members = int(attributes["members"])
    count_text = "one member" if members == 1 else f"{members} members"
    text = f"The onset of sliding is for {count_text}, with friction at all contacts."
    if not int(attributes.get("poisson_given", 1)) and np.isfinite(onset["stiffness"].values[0]):
        text += f" Poisson's ratio is assumed to be {float(np.ravel(attributes['poisson_ratio'])[0]):g}."
    return text


def onset_paragraph(onset: xarray.Dataset, *, verbose: bool) -> Paragraph:
    """Return a sentence about the onset of sliding and, if `verbose`, a note about the assumptions and a table."""
    return [f"{onset_text(onset)} {onset_note(onset)}", onset_rows(onset)] if verbose else [onset_text(onset)]


def onset_record(onset: xarray.Dataset) -> dict[str, Any]:
    """Return the load-displacement curve, its characteristic values and the fitted models as a JSON record (mN, µm)."""

    def mean_and_limits_records(dataset: xarray.Dataset, *names: str) -> dict[str, Any]:
        return {name: dict(zip(MEAN_AND_LIMITS, _mean_with_limits(dataset[name]), strict=True)) for name in names}

    characteristic_values = mean_and_limits_records(
        onset, "sliding_load", "displacement_at_sliding", "stiffness", "unloading_stiffness"
    )
    curve_names = ("tangential_load", "displacement", "slipped_area", "slipped_load", "energy_lost")
    curve = [
        {"fraction": float(fraction), **mean_and_limits_records(onset.sel(fraction=fraction), *curve_names)}
        for fraction in onset["fraction"].values
    ]
    attributes = {str(name): value for name, value in onset.attrs.items()}
    model_records = {
        model: {name: float(attributes[f"{model}_{name}"]) for name in names if f"{model}_{name}" in attributes}
        for model, names in PRESLIDING_PARAMETERS.items()
    }
    return {
        "sentence": onset_text(onset),
        "load": float(attributes["load_mN"]),
        "mu0": float(attributes["mu0"]),
        "tau0": float(attributes["tau0_GPa"]),
        "members": int(attributes["members"]),
        "poisson_ratio": np.ravel(attributes["poisson_ratio"]).astype(float).tolist(),
        **characteristic_values,
        **{model: parameters or None for model, parameters in model_records.items()},
        "curve": curve,
    }


def _mean_with_limits(table: xarray.DataArray, factor: float = 1.0) -> tuple[float, float, float]:
    mean, lower, upper = (factor * float(table.sel(statistic=statistic)) for statistic in MEAN_AND_LIMITS)
    return mean, lower, upper


def quantity_label(name: str, study: Study) -> str:
    """Return the label of a quantity; labels for the onset of sliding include mu0 and tau0."""
    onset, text = study.contact.onset, QUANTITIES[name].table_label
    if name == "normal_stiffness" and study.contact.hardness is not None:
        return f"{text} while loading"
    if onset is None or name not in ("displacement_at_sliding", "fraction_slipped"):
        return text
    return f"{text} at μ0 = {onset.mu0:g}, τ0 = {_tau0_text(float(onset.tau0))}"


def _tau0_text(tau0: float) -> str:
    return format_with_unit(tau0, "GPa") if tau0 else "0"
