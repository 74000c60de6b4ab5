"""What a study answers, as text: coefficients of static friction at a few loads, and everything at one point."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.mechanics import friction
from stiction.studies.maps import area_map, friction_map, stiffness_map
from stiction.studies.study import step_of, study_of
from stiction.views.digits import with_interval
from stiction.views.figures import reached_loads

if TYPE_CHECKING:
    import xarray

DIMENSIONS = 4
"""Fractal dimensions that the table shows, at most."""

LOADS = 3

HALF = 0.5
"""Share of the load that is beyond Hertz, or on radii below the grid, from which on a value is marked."""


def answers(dataset: xarray.Dataset) -> xarray.Dataset:
    """Friction of a result at a few loads and fractal dimensions, for the middle mu0 and the ends of tau0.

    Parameters
    ----------
    dataset : xarray.Dataset
        What `run` returns; of several amplitudes the middle one is taken, of several directions the first.

    Returns
    -------
    xarray.Dataset
        As `friction_map` gives it.
    """
    study = study_of(dataset)
    dimensions = dataset.sizes["fractal_dimension"]
    shown = np.unique(np.linspace(0, dimensions - 1, min(DIMENSIONS, dimensions)).round().astype(int))
    part = dataset.isel(fractal_dimension=shown, amplitude=[(dataset.sizes["amplitude"] - 1) // 2])
    if "direction" in part.dims:
        part = part.isel(direction=0)
    mu0, tau0 = study.friction.mu0, np.unique([float(study.friction.tau0[i]) for i in (0, -1)])
    return friction_map(part, _loads(part), mu0=[mu0[len(mu0) // 2]], tau0=tau0)


def _loads(dataset: xarray.Dataset) -> Floats:
    """Light, middle and heavy loads among those that are reached, by one digit."""
    ends = np.log10(reached_loads(dataset, 2))
    wanted = 10 ** (ends[0] + (ends[1] - ends[0]) * np.linspace(0.2, 0.8, LOADS))
    return np.unique([float(f"{load:.0e}") for load in wanted])


def answers_text(dataset: xarray.Dataset) -> str:
    """A table of mu_s [95 %] over load and fractal dimension, one for each tau0 and sliding rule."""
    try:
        found = answers(dataset)
    except ValueError as error:  # nothing touches
        return f"mu_s         none: {error}"
    rules = found["sliding"].values.tolist() if "sliding" in found.dims else [None]
    dimensions = found["fractal_dimension"].values
    lines, marked = [], False
    for rule in rules:
        for t, tau0 in enumerate(found["tau0"].values):
            at = (found if rule is None else found.sel(sliding=rule)).isel(amplitude=0, mu0=0, tau0=t)
            title = f"mu_s [95 %] at mu0 = {float(found['mu0'][0]):g}, tau0 = {1000 * tau0:g} MPa"
            lines.append(title + (f", sliding: {rule}" if rule else "") + _amplitude(dataset, found))
            table = [["", *(f"D = {dimension:.3g}" for dimension in dimensions)]]
            for load in found["load"].values:
                cells = [_cell(at.sel(load=load).isel(fractal_dimension=d)) for d in range(dimensions.size)]
                marked = marked or any(cell.endswith("*") for cell in cells)
                table.append([f"  {load:g} mN", *cells])
            widths = [max(map(len, column)) + 2 for column in zip(*table, strict=True)]
            lines += ["".join(map(str.ljust, row, widths)).rstrip() for row in table]
    if marked:
        lines.append("* beyond the model: more than half of the load on overlaps > R/10, or on radii < spacing")
    return "\n".join(lines)


def _amplitude(dataset: xarray.Dataset, found: xarray.Dataset) -> str:
    several = dataset.sizes["amplitude"] > 1
    return f", amplitude {1000 * float(found['amplitude'][0]):g} nm" if several else ""


def _cell(at: xarray.Dataset) -> str:
    if str(at["status"].values) != friction.STATUS_OK:
        return str(at["status"].values)
    text = with_interval(*(float(at[name]) for name in ("friction_coefficient", "lower", "upper")))
    return text + ("*" if _beyond(at) else "")


def _beyond(at: xarray.Dataset) -> bool:
    return any(float(at[name]) > HALF for name in ("share_beyond_hertz", "share_below_grid"))


# ---- One point -------------------------------------------------------------------------------------------------------


def point(
    dataset: xarray.Dataset,
    *,
    load: float,
    fractal_dimension: float,
    mu0: float,
    tau0: float,
    amplitude: float | None = None,
) -> list[dict[str, Any]]:
    """What a result says at one load (mN), for one mu0 and tau0 (GPa), at the nearest fractal dimension it has.

    Returns
    -------
    list of dict
        For each sliding rule and direction of the result: where it is (``sliding``, ``direction``,
        ``fractal_dimension``, ``amplitude``), the ``status``, the figures of validity, and for friction coefficient,
        true contact area (µm²) and normal stiffness (mN/µm) a list of value, lower and upper end. A stiffness that a
        result cannot have is left out.
    """
    part = dataset.sel(fractal_dimension=[fractal_dimension], method="nearest")
    wanted = float(dataset["amplitude"][0]) if amplitude is None else amplitude
    part = part.sel(amplitude=[wanted], method="nearest")
    asked: dict[str, Any] = {"loads": [load], "mu0": [mu0], "tau0": [tau0]}
    maps = {"friction_coefficient": friction_map(part, **asked), "contact_area": area_map(part, **asked)}
    try:
        maps["normal_stiffness"] = stiffness_map(part, **asked)
    except ValueError:
        if step_of(dataset) == "approach" and dataset.sizes["approach"] > 2:
            raise
    first = maps["friction_coefficient"]
    motions = [name for name in ("sliding", "direction") if name in first.dims]
    places = [dict(zip(motions, where, strict=True)) for where in np.ndindex(*(first.sizes[name] for name in motions))]
    found = []
    for where in places:
        one = first.isel(where).squeeze()
        entry: dict[str, Any] = {name: one[name].values.item() for name in (*motions, "fractal_dimension", "amplitude")}
        entry["status"] = str(one["status"].values)
        entry["validity"] = {
            name: float(one[name]) for name in ("share_beyond_hertz", "share_below_grid") if np.isfinite(one[name])
        }
        for name, table in maps.items():
            here = table.isel({motion: index for motion, index in where.items() if motion in table.dims}).squeeze()
            entry[name] = [float(here[each]) for each in (name, "lower", "upper")]
        found.append(entry)
    return found


TITLES = {
    "friction_coefficient": "mu_s",
    "contact_area": "true contact area (µm²)",
    "normal_stiffness": "normal stiffness (mN/µm)",
}

_REASONS = {
    "not-reached": "no approach of the study carries this load; a larger contact.approach does",
    "below-range": "the first approach of the study already carries more; a smaller contact.approach does not",
    "self-locked": "friction holds the contacts whatever the load",
    "no-contact": "the bodies do not touch",
}


def point_text(found: list[dict[str, Any]], *, load: float, mu0: float, tau0: float) -> str:
    """What `point` found, in words."""
    first = found[0]
    lines = [
        f"at F_N = {load:.4g} mN, D = {first['fractal_dimension']:.4g}, amplitude {1000 * first['amplitude']:.4g} nm, "
        f"mu0 = {mu0:g}, tau0 = {1000 * tau0:g} MPa, means and 95 % intervals"
    ]
    for entry in found:
        motion = [f"sliding: {entry['sliding']}"] if "sliding" in entry else []
        motion += [f"direction {entry['direction']:g}°"] if "direction" in entry else []
        if motion:
            lines.append(", ".join(motion))
        if entry["status"] != friction.STATUS_OK:
            lines.append(f"  no answer: {entry['status']}: {_REASONS.get(entry['status'], '')}")
            continue
        lines += [f"  {TITLES[name]:<26}{with_interval(*entry[name])}" for name in TITLES if name in entry]
        for name, words in (("share_beyond_hertz", "on overlaps > R/10"), ("share_below_grid", "on radii < spacing")):
            if name in entry["validity"]:
                share = entry["validity"][name]
                caution = ": beyond the model, do not quote it" if share > HALF else ""
                lines.append(f"  {f'load {words}':<26}{100 * share:.0f} %{caution}")
    return "\n".join(lines)
