"""What a pair says of the finest wave that was seen: cut-offs, the limit that a hardness sets, and what lies beyond."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._number_format import finite, percent, quoted, with_unit
from stiction.mechanics.brackets import friction_stretch, interface_stretch
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.resolution import TYPICAL_HARDNESSES, spectral_resolution
from stiction.studies.point import (
    contact_status_of,
    hardness_of,
    modulus_of,
    plastic_adhesion,
    points,
    pressure_of,
    rules_of,
    value_of,
)
from stiction.studies.resolution import Seen, seen
from stiction.surfaces.joined_spectrum import JoinedSpectrum
from stiction.surfaces.pairing import to_joined_spectrum

if TYPE_CHECKING:
    import xarray

    from stiction.studies.study import Study

Rows = list[list[str]]
RULE_TITLES = {"all": "all contacts", "opposing": "opposing contacts"}


# ---- Waves -----------------------------------------------------------------------------------------------------------


def waves_text(found: Seen) -> str:
    """Which waves were seen, and how much of the slope is in the shortest octave of them."""
    part = percent(found.fraction_below(2 * found.shortest))
    return (
        f"Wavelengths from {with_unit(found.shortest, 'um')} to {with_unit(found.longest, 'um')}; those below "
        f"{with_unit(2 * found.shortest, 'um')} contribute {part} of the gap's mean square slope h'\N{SUPERSCRIPT TWO}."
    )


# ---- Cut-offs --------------------------------------------------------------------------------------------------------


def cut_off_rows(at: xarray.Dataset, study: Study) -> Rows:
    """A table over cut-offs of what `resolution_at` gives at one load, mu0 and tau0, headings first.

    The plastic limit is its last row.
    """
    rules = rules_of(study)
    rows = [["cutoff", "h'", "A/A0", "mean pressure", *(f"μ_s {RULE_TITLES[rule]}" for rule in rules)]]
    for point in points(at):
        friction = point["friction_all_round"]
        cut_off, status = float(point["cut_off"]), contact_status_of(point, study)
        rows.append([
            with_unit(cut_off, "um") if cut_off else "none",
            quoted(value_of(point, "rms_gradient")),
            percent(value_of(point, "contact_area_fraction")) if status == STATUS_OK else status,
            with_unit(pressure_of(point), "GPa"),
            *(_coefficient(float(friction.sel(sliding=rule, statistic="mean"))) for rule in rules),
        ])  # fmt: skip
    limit = plastic_limit(at, study)
    if limit is not None:
        hardness = hardness_of(study)
        area = float(at["load"]) / hardness / float(at["nominal_area"])
        rows.append(["plastic limit", "", percent(area), with_unit(hardness, "GPa"), f"{limit:.3f}"])
    return rows


def _coefficient(value: float) -> str:
    return f"{value:.3f}" if math.isfinite(value) else "none"


def plastic_limit(point: xarray.Dataset, study: Study) -> float | None:
    """Return mu0 + tau0/H', below which no finer scan comes with friction at all contacts; None without a hardness."""
    adhesion = plastic_adhesion(point, study)
    return None if adhesion is None else float(point["mu0"]) + adhesion


def cut_off_records(at: xarray.Dataset, study: Study) -> list[dict[str, Any]]:
    """The same table as numbers: µm, GPa."""
    records = []
    for point in points(at):
        numbers = {name: value_of(point, name) for name in ("rms_gradient", "contact_area_fraction")}
        numbers["mean_pressure"] = pressure_of(point)
        for rule in rules_of(study):
            numbers[f"friction_{rule}"] = value_of(point.sel(sliding=rule), "friction_all_round")
        where: dict[str, Any] = {name: float(point[name]) for name in ("cut_off", "load", "mu0", "tau0")}
        records.append(where | {name: finite(value) for name, value in numbers.items()})
    return records


def cut_off_note(at: xarray.Dataset, study: Study) -> str:
    """What the table is of, and what it says."""
    members = value_of(at, "members")
    words = f"Both surfaces are low-pass filtered at the cutoff; means over {members:.0f} members."
    if plastic_limit(at, study) is not None:
        words += " No finer scan passes the plastic limit. With friction at opposing contacts there is no such limit."
    return words


# ---- Without a hardness ----------------------------------------------------------------------------------------------


def yielding(point: xarray.Dataset, study: Study, found: Seen) -> list[tuple[float, float, float, float, float]]:
    """For typical hardnesses (GPa): waves (µm) at which the mean pressure is so much, the interval, and mu0 + tau0/H.

    The elastic mean pressure is E* h'(λ)/κ, with κ as in this result; NaN where no wave has such a slope.
    """
    modulus, pressure = modulus_of(point, study), pressure_of(point)
    if not pressure > 0:
        return []
    count = value_of(point, "contact_count")
    mu0, tau0 = float(point["mu0"]), float(point["tau0"])
    return [
        (hardness, *found.yields_at(hardness / pressure, count), mu0 + tau0 / hardness)
        for hardness in TYPICAL_HARDNESSES
        if hardness < modulus / 2
    ]


def yielding_rows(point: xarray.Dataset, study: Study, found: Seen) -> Rows:
    """A table of what typical hardnesses would give, headings first; empty where nothing is known."""
    rows = []
    for hardness, wave, low, high, limit in yielding(point, study, found):
        if math.isnan(wave):
            reached = "never, for these slopes"
        elif wave > found.shortest:
            reached = "this scan already"
        else:
            ends = ", ".join(with_unit(end, "um") for end in (low, min(high, found.shortest)))
            reached = f"{with_unit(wave, 'um')} [{ends}]"
        rows.append([with_unit(hardness, "GPa"), reached, f"{limit:.3f}"])
    return [["if the hardness is", "it yields at a wavelength of", "μ_s all contacts, at least"], *rows] if rows else []


ELASTIC = (
    "This result is elastic: a finer scan has steeper slopes and less area, without a limit. A hardness sets the "
    "limit; give --hardness, or materials by name."
)


def yielding_records(point: xarray.Dataset, study: Study, found: Seen) -> list[dict[str, Any]]:
    """The same as numbers: GPa, µm."""
    return [
        {
            "load": float(point["load"]), "mu0": float(point["mu0"]), "tau0": float(point["tau0"]),
            "hardness": hardness, "reached_at_um": finite(wave), "lower": finite(low), "upper": finite(high),
            "friction_all_at_least": limit,
        }
        for hardness, wave, low, high, limit in yielding(point, study, found)
    ]  # fmt: skip


# ---- All of it -------------------------------------------------------------------------------------------------------


def resolution_record(at: xarray.Dataset, study: Study, over: xarray.Dataset | None) -> dict[str, Any] | None:
    """What JSON says of the resolution: waves, cut-offs and, without a hardness, where it would yield."""
    found = seen(study)
    if found is None and over is None:
        return None
    record: dict[str, Any] = {}
    if found is not None:
        record["waves"] = {
            "shortest_um": found.shortest, "longest_um": found.longest, "rms_gradient": finite(found.gradient),
            "fraction_of_mean_square_slope_in_shortest_octave": finite(found.fraction_below(2 * found.shortest)),
            "hurst_exponent": None if found.estimate is None else finite(found.estimate.value),
        }  # fmt: skip
        if study.by_half_space and study.contact.hardness is None:
            scan = at.isel(cut_off=[0]) if "cut_off" in at.dims else at
            record["yielding"] = [each for point in points(scan) for each in yielding_records(point, study, found)]
    if over is not None:
        record["cut_offs"] = cut_off_records(over, study)
    return record


def limits(at: xarray.Dataset, study: Study) -> dict[str, Any]:
    """What a picture over cut-offs draws besides: the limit of a hardness, and what is continued, as plain arrays.

    Of what `resolution_at` gives at one load, mu0 and tau0: friction and area_fraction, the plastic limit (None without
    a hardness); shortest (µm), below which nothing was seen (None where the files are gone); wavelength (µm),
    finer_area_fraction and finer_friction ("all"), each (n, 3) value, lower, upper, of the elastic answer continued by
    the Hurst exponent (empty with a hardness); spectral, what `spectral_resolution` says of spectra that several scans
    have (None of single scans).
    """
    limit, found = plastic_limit(at, study), seen(study)
    table: dict[str, Any] = {
        "friction": limit, "area_fraction": None, "shortest": None if found is None else found.shortest,
        "wavelength": np.empty(0), "finer_area_fraction": np.empty((0, 3)), "finer_friction": np.empty((0, 3)),
        "spectral": _spectral(at, study),
    }  # fmt: skip
    area, load = float(at["nominal_area"]), float(at["load"])
    if limit is not None:
        hardness = hardness_of(study)
        return table | {"area_fraction": load / hardness / area}
    fraction = value_of(at.isel(cut_off=0), "contact_area_fraction")
    if found is None or not fraction > 0 or not study.by_half_space:
        return table
    waves, gradients, fractions = found.finer(fraction, value_of(at.isel(cut_off=0), "contact_count"))
    steepness = gradients[:, :1]
    friction = float(at["mu0"]) + float(at["tau0"]) * fractions / interface_stretch(steepness) * area / load
    friction *= friction_stretch(steepness, found.roughness.dimensions)
    return table | {"wavelength": waves, "finer_area_fraction": fractions, "finer_friction": friction}


def _spectral(at: xarray.Dataset, study: Study) -> xarray.Dataset | None:
    """The closed form of two spectra of which at least one is of several scans."""
    files = [getattr(study.surfaces, side, None) for side in ("upper", "lower")]
    try:
        bodies = [file.read() for file in files if file is not None]
    except (ValueError, OSError):
        return None
    pressure, hardness = float(at["load"]) / float(at["nominal_area"]), hardness_of(study)
    if not any(isinstance(body, JoinedSpectrum) for body in bodies) or hardness <= pressure:
        return None
    upper, lower = (to_joined_spectrum(body).roughness() for body in bodies)
    return spectral_resolution(
        upper, lower, pressure=pressure, hardness=None if math.isnan(hardness) else hardness, mu0=float(at["mu0"]),
        tau0=float(at["tau0"]), effective_modulus=modulus_of(at, study),
    )  # fmt: skip
