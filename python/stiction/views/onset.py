"""What a pair says of how it begins to slide: a sentence, a table and a record of the curve beside its result."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import finite, percent, quoted, with_interval, with_unit
from stiction.mechanics.quantities import QUANTITIES
from stiction.studies.point import STATISTICS

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

HALF = 0.5
AMPLITUDES = (0.5, 0.9)  # amplitudes of cycles over the sliding load


def onset_text(onset: xarray.Dataset) -> str:
    """One sentence: creep before sliding, what slips at half of the load, and the stiffness at rest."""
    parts, creep = [], _ends(onset["displacement_at_sliding"], 1000.0)
    if math.isfinite(creep[0]):
        parts.append(f"it creeps {quoted(*creep)} nm before it slides")
    slipped = _ends(onset["slipped_area"].sel(fraction=HALF), 100.0)
    parts.append(f"at half of the load {percent(slipped[0] / 100)} of the contact slips")
    ends = {words: _ends(onset[name]) for name, words in _STIFFNESSES.items()}
    said = [f"{quoted(*each)} mN/µm {words}" for words, each in ends.items() if math.isfinite(each[0])]
    parts += [f"stiffness at rest {', '.join(said)}"] if said else []
    words = "; ".join(parts)
    return words[0].upper() + words[1:] + "."


_STIFFNESSES = {"stiffness": "tangential", "unloading_stiffness": "normal (unloading, ultrasonic)"}


def onset_rows(onset: xarray.Dataset) -> list[list[str]]:
    """A table of means and intervals, headings first."""
    a = onset.attrs
    head = f"{with_unit(float(a['load_mN']), 'mN')}, μ0 = {float(a['mu0']):g}, τ0 = {_strength(float(a['tau0_GPa']))}"
    half = onset.sel(fraction=HALF)
    rows = [
        ["sliding load (mN)", _cell(onset["sliding_load"])],
        ["creep before sliding (nm)", _cell(onset["displacement_at_sliding"], 1000.0)],
        ["tangential stiffness (mN/µm)", _cell(onset["stiffness"])],
        ["normal stiffness, unloading or by ultrasound (mN/µm)", _cell(onset["unloading_stiffness"])],
        ["contact that slips at half of the load (%)", _cell(half["slipped_area"], 100.0)],
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
    words = f"This onset is that of {'one member' if members == 1 else f'{members} members'}, all contacts rubbing."
    if not int(a.get("poisson_given", 1)) and np.isfinite(onset["stiffness"].values[0]):
        words += f" Poisson's ratio is taken as {float(np.ravel(a['poisson_ratio'])[0]):g}."
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
