"""What a pair says of how it begins to slide: a sentence, a table and a record of the curve beside its result."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import finite, percent, prefix, quoted, with_interval, with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.point import STATISTICS

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

HALF = 0.5
AMPLITUDES = (0.5, 0.9)  # amplitudes of cycles over the sliding load


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
    words = "; ".join(parts)
    return words[0].upper() + words[1:] + "."


def _length_scale(table: xarray.DataArray) -> tuple[float, str]:
    """Return the factor from µm to the unit in which a mean has the fewest zeros, and this unit."""
    value = _ends(table)[0]
    factor, unit = prefix(value if math.isfinite(value) else 0.0, "um")
    return 1 / factor, unit


def _stiffness_scale(table: xarray.DataArray) -> tuple[float, str]:
    """Return the factor from mN/µm to the unit of a mean stiffness, and this unit."""
    return (1e-3, "N/µm") if _ends(table)[0] >= LARGE_STIFFNESS else (1.0, "mN/µm")


LARGE_STIFFNESS = 1e4  # in mN/µm, from which on it is printed in N/µm


def onset_rows(onset: xarray.Dataset) -> list[list[str]]:
    """A table of means and intervals, headings first."""
    a = onset.attrs
    head = f"{with_unit(float(a['load_mN']), 'mN')}, μ0 = {float(a['mu0']):g}, τ0 = {_strength(float(a['tau0_GPa']))}"
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
        ["load on it (%)", _cell(half["slipped_load"], 100.0)],
        *(
            [f"energy of a cycle of {each:g} of it (pJ)", _cell(onset["energy_lost"].sel(fraction=each), 1000.0)]
            for each in AMPLITUDES
        ),
    ]
    return [["onset of sliding", head], *(row for row in rows if row[1] != "none")]


def onset_note(onset: xarray.Dataset) -> str:
    """What the numbers are means of, and what they assume."""
    a = onset.attrs
    members = int(a["members"])
    count = "one member" if members == 1 else f"{members} members"
    words = f"The onset of sliding is for {count}, with friction at all contacts."
    if not int(a.get("poisson_given", 1)) and np.isfinite(onset["stiffness"].values[0]):
        words += f" Poisson's ratio is assumed to be {float(np.ravel(a['poisson_ratio'])[0]):g}."
    return words


def onset_record(onset: xarray.Dataset) -> dict[str, Any]:
    """The curve, its numbers and the parameters of models fitted to it, as JSON has them: mN, µm, GPa."""

    def records(of: xarray.Dataset, *names: str) -> dict[str, Any]:
        return {name: dict(zip(STATISTICS, map(finite, _ends(of[name])), strict=True)) for name in names}

    numbers = records(onset, "sliding_load", "displacement_at_sliding", "stiffness", "unloading_stiffness")
    of_curve = ("tangential_load", "displacement", "slipped_area", "slipped_load", "energy_lost")
    curve = [
        {"fraction": float(fraction), **records(onset.sel(fraction=fraction), *of_curve)}
        for fraction in onset["fraction"].values
    ]
    known = {str(name): value for name, value in onset.attrs.items()}
    models = {
        model: {name.removeprefix(f"{model}_"): float(value) for name, value in known.items() if name.startswith(model)}
        for model in ("iwan", "lugre")
    }
    return {
        "sentence": onset_text(onset), "load": float(known["load_mN"]), "mu0": float(known["mu0"]),
        "tau0": float(known["tau0_GPa"]), "members": int(known["members"]),
        "poisson_ratio": np.ravel(known["poisson_ratio"]).astype(float).tolist(), **numbers,
        **{model: parameters or None for model, parameters in models.items()}, "curve": curve,
    }  # fmt: skip


def _ends(table: xarray.DataArray, factor: float = 1.0) -> tuple[float, float, float]:
    mean, lower, upper = (factor * float(table.sel(statistic=each)) for each in STATISTICS)
    return mean, lower, upper


def _cell(table: xarray.DataArray, factor: float = 1.0) -> str:
    return with_interval(*_ends(table, factor))


def words_of(name: str, study: Study) -> str:
    """What tables call a quantity: creep, and what slips, with the strengths at which the study keeps them."""
    onset, words = study.contact.onset, QUANTITIES[name].short
    if name == "normal_stiffness" and study.contact.hardness is not None:
        return f"{words} while loading"
    if onset is None or name not in ("displacement_at_sliding", "fraction_slipped"):
        return words
    return f"{words} at μ0 = {onset.mu0:g}, τ0 = {_strength(float(onset.tau0))}"


def _strength(tau0: float) -> str:
    return with_unit(tau0, "GPa") if tau0 else "0"
