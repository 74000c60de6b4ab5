"""Friction and true area of a measured pair over the scale of its heights, as another finish would leave them.

Each factor of the heights is a study of its own, stored alongside the result; between factors, results are interpolated.
"""

from __future__ import annotations

import math
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, get_args

import numpy as np

from stiction._checks import Floats, choice, float_array
from stiction.studies.at_load import at_load
from stiction.studies.budget import with_uncertainty
from stiction.studies.hardness import FILE as HARDNESS
from stiction.studies.hardness import areas_over_hardness, bodies_wanted, hardness_beside
from stiction.studies.pressed import cost_of_member
from stiction.studies.runner import fill
from stiction.studies.store import STUDY, Stored, StoreError, export, open_stored
from stiction.studies.study import Study, computed_otherwise
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

FOLDER = "height_scale"
"""In the folder of a result: a folder for each factor of the heights."""

NUM_FACTORS = 9
"""Factors that are solved over a range of 16, from 0.25 to 4, in equal ratios."""

MIN_FACTOR, MAX_FACTOR = 0.01, 100.0

Scaled = Literal["both", "upper", "lower"]
"""Surfaces whose heights are scaled."""

_SHOWN = (
    "friction_coefficient", "friction_by_axis", "friction_all_round", "friction_known", "spread_low", "spread_high",
    "contact_area", "contact_area_fraction", "contact_count", "mean_pressure", "normal_stiffness",
    "stiffness_per_area", "rms_gradient", "rms_slope", "pull_off", "pull_off_pressure",
)  # fmt: skip
"""Variables of `at_load` that are given over factors."""


class NotComputedError(ValueError):
    """Factors of the heights are not computed yet.

    Attributes
    ----------
    seconds : float
        Estimated time of one core to compute them.
    """

    def __init__(self, message: str, seconds: float) -> None:
        super().__init__(message)
        self.seconds = seconds


def checked_factors(factors: Any) -> Floats:
    """Return factors of the heights in rising order; a `ValueError` if one is outside its range."""
    values = np.unique(np.atleast_1d(float_array("height_scale", factors)))
    if not values.size or not ((values >= MIN_FACTOR) & (values <= MAX_FACTOR)).all():
        raise ValueError(f"height_scale must be from {MIN_FACTOR:g} to {MAX_FACTOR:g}, got {factors!r}")
    return values


def factors_between(lowest: float, highest: float) -> Floats:
    """Return the factors to solve for a range, in equal ratios, and 1."""
    count = max(2, math.ceil(math.log(highest / lowest) / math.log(16) * (NUM_FACTORS - 1)) + 1)
    between = [float(f"{each:.6g}") for each in np.geomspace(lowest, highest, count)]
    return np.unique([*between, 1.0])


def scaled_study(study: Study, factor: float, scaled: Scaled) -> Study:
    """Return a study of the same measured pair with heights times a factor.

    Raises
    ------
    ValueError
        If the study is not of two measured bodies.
    """
    if not study.is_measured or study.is_gap:
        raise ValueError("height_scale is for two measured surfaces")
    choice("scaled", scaled, Scaled)
    sides = SIDES if scaled == "both" else (scaled,)
    changed: Any = study.surfaces.with_files(
        lambda file, side: file.with_height_factor(factor) if side in sides else file
    )
    return study.model_copy(update={"surfaces": changed})


def folder_of(path: Path, factor: float, scaled: Scaled) -> Path:
    """Return the folder of a factor in that of a result."""
    return path / FOLDER / f"{scaled}-{factor:.6g}"


def stored_factors(result: Stored, scaled: Scaled) -> dict[float, Stored]:
    """Return the finished studies of a result over factors, in rising order; that of 1 is the result itself."""
    found = {1.0: result}
    for folder in (result.path / FOLDER).glob(f"{scaled}-*"):
        try:
            factor = float(folder.name.removeprefix(f"{scaled}-"))
            stored = open_stored(folder)
        except (StoreError, ValueError):
            continue
        wanted = scaled_study(result.study, factor, scaled)
        if stored.count == wanted.ensemble.repetitions and not computed_otherwise(stored.study, wanted):
            found[factor] = stored
    return dict(sorted(found.items()))


def seconds_to_compute(study: Study, count: int) -> float:
    """Estimate the time of one core that so many factors take."""
    hardnesses, moduli = bodies_wanted(study)
    return count * cost_of_member(study) * (study.ensemble.repetitions + hardnesses.size * moduli.size)


def compute_factors(
    result: Stored, factors: Floats, scaled: Scaled, executor: Executor, *, progress: bool = False
) -> None:
    """Compute the factors that are not stored alongside a result, each with its range of hardness."""
    there = stored_factors(result, scaled)
    for factor in factors.tolist():
        if factor not in there:
            study, folder = scaled_study(result.study, factor, scaled), folder_of(result.path, factor, scaled)
            fill(study, folder, executor=executor, progress=progress)
            stored = open_stored(folder)
            if hardness_beside(stored) is None and (areas := areas_over_hardness(stored.study, executor)) is not None:
                export(areas, folder / HARDNESS, replace=True)


# ---- At a load -------------------------------------------------------------------------------------------------------


def at_height_scale(
    result: Stored, factors: Any, loads: Any, *, mu0: Any = None, tau0: Any = None, scaled: Scaled = "both"
) -> xarray.Dataset:
    """Return friction, true area and stiffness of a measured pair over factors of its heights.

    Parameters
    ----------
    result : Stored
    factors : array_like of float
        From 0.01 to 100, within those that are stored; 1 is the pair as measured.
    loads : array_like of float, mN
    mu0, tau0 : array_like of float, optional
        Those of the study by default; GPa.
    scaled : {"both", "upper", "lower"}
        Surfaces whose heights are scaled.

    Returns
    -------
    xarray.Dataset
        Of the quoted cutoff, over height_scale and the dimensions of `at_load`: coefficients with the sampling interval
        and, as friction_known, with the combined one, true area, number of contacts, mean pressure, stiffness, and
        rms_gradient and rms_slope of the gap.

    Raises
    ------
    NotComputedError
        If a factor is outside of those that are stored.
    ValueError
        If the study is not of two measured surfaces, or a factor is outside its range.

    Notes
    -----
    Between stored factors, positive variables are read off on a cubic spline of their logarithms over the logarithm of
    the factor, others on that of their values.
    """
    import xarray

    factors = checked_factors(factors)
    there = stored_factors(result, scaled)
    solved = np.array(list(there))
    if factors[0] < solved[0] or factors[-1] > solved[-1]:
        missing = factors_between(min(factors[0], solved[0]), max(factors[-1], solved[-1]))
        count = missing.size - int(np.isin(missing, solved).sum())
        raise NotComputedError(
            f"heights are solved times {solved[0]:g} to {solved[-1]:g}, and {factors[0]:g} to {factors[-1]:g} is wanted",
            seconds_to_compute(result.study, count),
        )
    points = [_at_quoted(one, loads, mu0=mu0, tau0=tau0) for one in there.values()]
    first = points[list(there).index(1.0)]
    variables: dict[str, Any] = {}
    for name in (each for each in _SHOWN if all(each in point for point in points)):
        values = np.stack([point[name].transpose(*first[name].dims).values for point in points])
        read = np.stack([_between(values, solved, factor) for factor in factors.tolist()])
        variables[name] = (("height_scale", *first[name].dims), read, first[name].attrs)
    coordinates = {
        name: each for name, each in first.coords.items() if name == "nominal_area" or set(each.dims) <= set(first.dims)
    }
    coordinates["height_scale"] = ("height_scale", factors, {"units": "1", "long_name": "factor of the heights"})
    return xarray.Dataset(variables, coordinates, first.attrs | {"scaled": scaled, "solved": solved})


def _at_quoted(result: Stored, loads: Any, **material: Any) -> xarray.Dataset:
    """Return the reading to quote, whose interval covers the other one where wavelengths are doubtful."""
    at = with_uncertainty(at_load(result, loads, **material), result)
    first = at.isel(cut_off=0)
    if not result.study.surfaces.both_readings:
        return first
    ends = {"lower": at["friction_known"].min("cut_off"), "upper": at["friction_known"].max("cut_off")}
    known = first["friction_known"].copy()
    for name, each in ends.items():
        known.loc[{"statistic": name}] = each.sel(statistic=name)
    return first.assign(friction_known=known)


def _between(values: Floats, solved: Floats, factor: float) -> Floats:
    """Return values over solved factors (first axis) at another factor."""
    from scipy.interpolate import CubicSpline, interp1d

    place = np.flatnonzero(np.isclose(solved, factor, rtol=1e-9))
    if place.size:
        return np.asarray(values[place[0]])
    spline = CubicSpline if solved.size > 3 else interp1d
    known = np.isfinite(values).all(axis=0)
    positive = known & (values > 0).all(axis=0)
    x, at = np.log(solved), math.log(factor)
    found = np.full(values.shape[1:], np.nan)
    found[positive] = np.exp(spline(x, np.log(values[:, positive]), axis=0)(at))
    found[known & ~positive] = spline(x, values[:, known & ~positive], axis=0)(at)
    return found
