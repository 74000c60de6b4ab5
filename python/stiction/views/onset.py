"""Format the onset of sliding: a sentence, a table and a JSON record."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import finite, percent, prefix, quoted, with_interval, with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.onset import MODELS
from stiction.studies.point import MEAN_AND_ENDS

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

HALF = 0.5
AMPLITUDES = (0.5, 0.9)  # tangential load amplitudes of cycles, relative to the sliding load


def onset_text(onset: xarray.Dataset) -> str:
    """Return a sentence with the pre-sliding displacement, the contact that slips, and the tangential stiffness."""
    parts, displacement = [], onset["displacement_at_sliding"]
    if math.isfinite(_ends(displacement)[0]):
        factor, unit = _length_scale(displacement)
        parts.append(f"pre-sliding displacement {quoted(*_ends(displacement, factor))} {unit}")
    slipped = _ends(onset["slipped_area"].sel(fraction=HALF))
    parts.append(f"{percent(slipped[0])} of the contact slips at half of the sliding load")
    factor, unit = _stiffness_scale(onset["stiffness"])
    if math.isfinite((ends := _ends(onset["stiffness"], factor))[0]):
        parts.append(f"initial tangential stiffness {quoted(*ends)} {unit}")
    text = "; ".join(parts)
    return text[0].upper() + text[1:] + "."


def _length_scale(table: xarray.DataArray) -> tuple[float, str]:
    """Return the factor from µm to the unit in which a mean has the fewest zeros, and this unit."""
    value = _ends(table)[0]
    factor, unit = prefix(value if math.isfinite(value) else 0.0, "um")
    return 1 / factor, unit


def _stiffness_scale(table: xarray.DataArray) -> tuple[float, str]:
    """Return the factor from mN/µm to the unit of a mean stiffness, and this unit."""
    return (1e-3, "N/µm") if _ends(table)[0] >= LARGE_STIFFNESS else (1.0, "mN/µm")


LARGE_STIFFNESS = 1e4  # mN/µm, above which a stiffness is printed in N/µm


def onset_rows(onset: xarray.Dataset) -> list[list[str]]:
    """Return a table of means and intervals, headings first."""
    attributes = onset.attrs
    load, tau0 = with_unit(float(attributes["load_mN"]), "mN"), _strength(float(attributes["tau0_GPa"]))
    head = f"{load}, μ0 = {float(attributes['mu0']):g}, τ0 = {tau0}"
    half = onset.sel(fraction=HALF)
    (length, length_unit), (rigid, rigid_unit), (normal, normal_unit) = (
        _length_scale(onset["displacement_at_sliding"]),
        _stiffness_scale(onset["stiffness"]),
        _stiffness_scale(onset["unloading_stiffness"]),
    )
    rows = [
        ["sliding load (mN)", _cell(onset["sliding_load"])],
        [f"pre-sliding displacement ({length_unit})", _cell(onset["displacement_at_sliding"], length)],
        [f"tangential stiffness ({rigid_unit})", _cell(onset["stiffness"], rigid)],
        [f"normal stiffness, unloading or by ultrasound ({normal_unit})", _cell(onset["unloading_stiffness"], normal)],
        ["contact that slips at half of the sliding load (%)", _cell(half["slipped_area"], 100.0)],
        ["load on the slipping contact (%)", _cell(half["slipped_load"], 100.0)],
        *(
            [
                f"energy dissipated in a cycle of {amplitude:g} times the sliding load (pJ)",
                _cell(onset["energy_lost"].sel(fraction=amplitude), 1000.0),
            ]
            for amplitude in AMPLITUDES
        ),
    ]
    return [["onset of sliding", head], *(row for row in rows if row[1] != "none")]


def onset_note(onset: xarray.Dataset) -> str:
    """Return a note on the averaged members and the assumptions."""
    attributes = onset.attrs
    members = int(attributes["members"])
    count = "one member" if members == 1 else f"{members} members"
    text = f"The onset of sliding is for {count}, with friction at all contacts."
    if not int(attributes.get("poisson_given", 1)) and np.isfinite(onset["stiffness"].values[0]):
        text += f" Poisson's ratio is assumed to be {float(np.ravel(attributes['poisson_ratio'])[0]):g}."
    return text


def onset_record(onset: xarray.Dataset) -> dict[str, Any]:
    """Return the curve, its characteristic values and the fitted model parameters as a JSON record (mN, µm, GPa)."""

    def records(dataset: xarray.Dataset, *names: str) -> dict[str, Any]:
        return {name: dict(zip(MEAN_AND_ENDS, map(finite, _ends(dataset[name])), strict=True)) for name in names}

    numbers = records(onset, "sliding_load", "displacement_at_sliding", "stiffness", "unloading_stiffness")
    of_curve = ("tangential_load", "displacement", "slipped_area", "slipped_load", "energy_lost")
    curve = [
        {"fraction": float(fraction), **records(onset.sel(fraction=fraction), *of_curve)}
        for fraction in onset["fraction"].values
    ]
    attributes = {str(name): value for name, value in onset.attrs.items()}
    models = {
        model: {name: float(attributes[f"{model}_{name}"]) for name in names if f"{model}_{name}" in attributes}
        for model, names in MODELS.items()
    }
    return {
        "sentence": onset_text(onset), "load": float(attributes["load_mN"]), "mu0": float(attributes["mu0"]),
        "tau0": float(attributes["tau0_GPa"]), "members": int(attributes["members"]),
        "poisson_ratio": np.ravel(attributes["poisson_ratio"]).astype(float).tolist(), **numbers,
        **{model: parameters or None for model, parameters in models.items()}, "curve": curve,
    }  # fmt: skip


def _ends(table: xarray.DataArray, factor: float = 1.0) -> tuple[float, float, float]:
    mean, lower, upper = (factor * float(table.sel(statistic=statistic)) for statistic in MEAN_AND_ENDS)
    return mean, lower, upper


def _cell(table: xarray.DataArray, factor: float = 1.0) -> str:
    return with_interval(*_ends(table, factor))


def quantity_label(name: str, study: Study) -> str:
    """Return the label of a quantity, with the strengths at which the study computed the onset of sliding."""
    onset, text = study.contact.onset, QUANTITIES[name].short
    if name == "normal_stiffness" and study.contact.hardness is not None:
        return f"{text} while loading"
    if onset is None or name not in ("displacement_at_sliding", "fraction_slipped"):
        return text
    return f"{text} at μ0 = {onset.mu0:g}, τ0 = {_strength(float(onset.tau0))}"


def _strength(tau0: float) -> str:
    return with_unit(tau0, "GPa") if tau0 else "0"
