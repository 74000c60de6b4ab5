"""Friction and true area of a measured pair over the scale of its heights, as another finish would leave them.

Each factor of the heights is a study of its own, stored alongside the result. Between factors, results are
interpolated.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from concurrent.futures import Executor
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from stiction._arguments import parse_numbers, reject_decimal_commas
from stiction._checks import Floats, check_choice, float_array
from stiction._errors import ArgumentError
from stiction._text import format_duration
from stiction._units import short_repr
from stiction.mechanics.friction import STATUS_OK
from stiction.mechanics.quantities import attributes_of
from stiction.studies.budget import add_uncertainty
from stiction.studies.evaluation import ABOVE_NOMINAL, at_load, is_unloaded
from stiction.studies.executors import enter_executor
from stiction.studies.hardness import (
    AREAS_FILE,
    choose_area_nodes,
    compute_areas_over_hardness,
    count_solutions,
    load_areas_over_hardness,
)
from stiction.studies.measured_surfaces import MAX_HEIGHT_FACTOR as MAX_FACTOR
from stiction.studies.measured_surfaces import MIN_HEIGHT_FACTOR as MIN_FACTOR
from stiction.studies.member_solution import cost_of_member, cost_of_solution
from stiction.studies.members import first_pair
from stiction.studies.pipeline import remove_result
from stiction.studies.result import Result
from stiction.studies.runner import compute_missing
from stiction.studies.store import STUDY_FILE, StoredResult, StoreError, export, open_stored
from stiction.studies.study import Study, find_member_differences
from stiction.surfaces.pairing import SIDES

if TYPE_CHECKING:
    import xarray

HEIGHT_SCALE_FOLDER = "height_scale"
"""In the folder of a result: a folder for each factor of the heights."""

FACTOR_STEP = 0.5
"""Steps of log2 of the factors that are solved over a range; results are interpolated between neighbors so close."""

FACTOR_DIGITS = 6  # significant digits of a factor, by which its folder is named

ScaledSides = Literal["both", "upper", "lower"]
"""Surfaces whose heights are scaled."""

_INTERPOLATED_VARIABLES = (
    "friction_all_round", "friction_by_axis", "friction_combined", "friction_next_test", "spread_low", "spread_high",
    "contact_area", "contact_area_fraction", "contact_count", "mean_pressure", "normal_stiffness",
    "stiffness_per_area", "rms_gradient", "rms_slope", "pull_off", "pull_off_pressure",
)  # fmt: skip
"""Variables of `at_load` that are given over factors."""


class MissingFactorsError(ArgumentError):
    """Factors of the heights are not computed yet.

    Attributes
    ----------
    factors : ndarray of float
        Factors to compute.
    seconds : float
        Estimated time of one core to compute them.
    """

    def __init__(self, factors: Floats, seconds: float) -> None:
        several = f"{factors.size} factors from {factors[0]:g} to {factors[-1]:g}"
        which = several if factors.size > 1 else f"the factor {factors[0]:g}"
        super().__init__(
            "{height_scale} needs {which} computed, about {time} of one core: give {compute=True}",
            which=which, time=format_duration(seconds),
        )  # fmt: skip
        self.factors, self.seconds = factors, seconds


def parse_factors(factors: Any) -> Floats:
    """Return factors of the heights in rising order, rounded to `FACTOR_DIGITS` significant digits.

    Parameters
    ----------
    factors : float, array_like or str
        Factors from 0.01 to 100, also as text, "0.5,1,2", or a range, "0.25..4", of which there are the ends and the
        powers of the square root of 2 between them.

    Raises
    ------
    ArgumentError
        If a factor is no number or outside its range, or a range does not rise.
    """
    values = _parse_factor_text(factors) if isinstance(factors, str) else float_array("height_scale", factors)
    values = np.unique([float(f"{each:.{FACTOR_DIGITS}g}") for each in np.ravel(values).tolist()])
    if not values.size or not ((values >= MIN_FACTOR) & (values <= MAX_FACTOR)).all():
        allowed = f"from {MIN_FACTOR:g} to {MAX_FACTOR:g}"
        raise ArgumentError("{height_scale} must be {allowed}, got {got}", allowed=allowed, got=short_repr(factors))
    return values


def _parse_factor_text(text: str) -> Floats:
    """Return the factors of a text: of a list, or the ends of a range and those that are solved between them."""
    try:
        if ".." not in text:
            if text.count(",") == 1:
                reject_decimal_commas("height_scale", text)
            return np.array(parse_numbers("height_scale", text, integers=True))
        low, high = (float(each) for each in text.split(".."))
        if not MIN_FACTOR <= low < high <= MAX_FACTOR:
            raise ValueError
    except ArgumentError:
        raise
    except ValueError:
        raise ArgumentError(
            '{height_scale} must be factors, as in "0.5,1,2", or a rising range from {least:g} to {most:g}, as in '
            '"0.25..4", got {got}',
            least=MIN_FACTOR, most=MAX_FACTOR, got=short_repr(text),
        ) from None  # fmt: skip
    nodes = _list_enclosing_powers(low, high)
    return np.array([low, *nodes[(nodes > low) & (nodes < high)], high])


def _list_enclosing_powers(low: float, high: float) -> Floats:
    """Return powers of 2, in steps of `FACTOR_STEP` of the exponent, that enclose a range of factors."""
    first, last = math.floor(math.log2(low) / FACTOR_STEP), math.ceil(math.log2(high) / FACTOR_STEP)
    powers = np.exp2(FACTOR_STEP * np.arange(first, last + 1)).clip(MIN_FACTOR, MAX_FACTOR)
    return np.unique([float(f"{each:.{FACTOR_DIGITS}g}") for each in powers.tolist()])


def find_missing_factors(factors: Floats, solved: Floats) -> Floats:
    """Return the factors to solve, so that each one is solved or lies between neighbors a step apart."""
    wanted = np.array([each for each in factors.tolist() if _find_neighbors(solved, each) is None])
    if not wanted.size:
        return wanted
    nodes = np.setdiff1d(_list_enclosing_powers(wanted[0], wanted[-1]), solved)
    return nodes if nodes.size < wanted.size else wanted


def _find_neighbors(solved: Floats, factor: float) -> tuple[int, int] | None:
    """Return the places of the solved factors around one, twice the same if it is solved; None if they are too far."""
    right = int(np.searchsorted(solved, factor))
    if right < solved.size and solved[right] == factor:
        return right, right
    near = 0 < right < solved.size and math.log2(solved[right] / solved[right - 1]) < FACTOR_STEP * 1.001
    return (right - 1, right) if near else None


def scale_study_heights(study: Study, factor: float, scaled: ScaledSides) -> Study:
    """Return a study of the same measured pair with heights times a factor.

    Raises
    ------
    ValueError
        If the study is not of two measured bodies.
    """
    if not study.is_measured or study.is_gap:
        kind = "the gap of one body" if study.is_measured else "generated surfaces"
        raise ArgumentError("{height_scale} needs two measured surfaces, got {kind}", kind=kind)
    check_choice("scaled", scaled, ScaledSides)
    sides = SIDES if scaled == "both" else (scaled,)
    surfaces: Any = study.surfaces
    changed = surfaces.with_files(lambda file, side: file.with_height_factor(factor) if side in sides else file)
    return study.model_copy(update={"surfaces": changed})


def find_factor_folder(path: Path, factor: float, scaled: ScaledSides) -> Path:
    """Return the folder of a factor in that of a result."""
    return path / HEIGHT_SCALE_FOLDER / f"{scaled}-{factor:.6g}"


def open_stored_factors(result: StoredResult, scaled: ScaledSides) -> dict[float, StoredResult]:
    """Return the finished studies of a result over factors, in rising order, each with the friction of the result.

    That of 1 is the result itself.
    """
    found = {1.0: result}
    for folder in (result.path / HEIGHT_SCALE_FOLDER).glob(f"{scaled}-*"):
        try:
            factor = float(folder.name.removeprefix(f"{scaled}-"))
            stored = open_stored(folder)
        except (StoreError, ValueError):
            continue
        wanted = scale_study_heights(result.study, factor, scaled)
        if find_member_differences(stored.study, wanted):
            continue
        stored = StoredResult(stored.path, wanted, stored.blocks)  # with the friction of the result
        if stored.count == wanted.ensemble.repetitions and not _lacks_hardness(stored):
            found[factor] = stored
    return dict(sorted(found.items()))


def _lacks_hardness(stored: StoredResult) -> bool:
    """Return whether a study has ranges of hardness or E*, and is not solved over them yet."""
    wants = bool(choose_area_nodes(stored.study)[0].size) and not is_unloaded(Result(stored))
    return wants and load_areas_over_hardness(stored) is None


def estimate_factor_time(study: Study, count: int) -> float:
    """Estimate the time of one core that so many factors take."""
    others = count_solutions(study) * cost_of_solution(study) if study.uses_half_space else 0.0
    return count * (study.ensemble.repetitions * cost_of_member(study) + others)


def compute_factors(
    result: StoredResult, factors: Any, scaled: ScaledSides = "both", executor: Executor | None = None, *,
    progress: bool = False, announce: Callable[[str], Any] = lambda _: None,
) -> None:  # fmt: skip
    """Compute factors of the heights, or others around them, that a stored result lacks.

    Each factor is a stored study of its own, so that whoever is interrupted keeps those that are finished. `announce`
    is given a line before each. Errors are those of `evaluate_height_scale` and of `compute_missing`.
    """
    missing = find_missing_factors(parse_factors(factors), np.array(list(open_stored_factors(result, scaled))))
    with enter_executor(executor) as workers:
        for number, factor in enumerate(missing.tolist(), 1):
            announce(f"heights times {factor:g} ({number} of {missing.size})")
            study, folder = (
                scale_study_heights(result.study, factor, scaled),
                find_factor_folder(result.path, factor, scaled),
            )
            there = open_stored(folder) if (folder / STUDY_FILE).exists() else None
            if there and find_member_differences(there.study, study):
                remove_result(there)  # of another pair
            compute_missing(study, folder, executor=workers, progress=progress)
            stored = open_stored(folder)
            if _lacks_hardness(stored) and (areas := compute_areas_over_hardness(stored.study, workers)) is not None:
                export(areas, folder / AREAS_FILE, replace=True)


# ---- At a load -------------------------------------------------------------------------------------------------------


def evaluate_height_scale(
    result: StoredResult, factors: Any, loads: Any, *, mu0: Any = None, tau0: Any = None, scaled: ScaledSides = "both"
) -> xarray.Dataset:
    """Return friction, true area and stiffness of a measured pair over factors of its heights.

    Parameters
    ----------
    result : StoredResult
    factors : float, array_like or str
        From 0.01 to 100, as `parse_factors` reads them; 1 is the pair as measured.
    loads : array_like of float, mN
    mu0, tau0 : array_like of float, optional
        Those of the study by default; GPa.
    scaled : {"both", "upper", "lower"}
        Surfaces whose heights are scaled.

    Returns
    -------
    xarray.Dataset
        Of the quoted cutoff, over height_scale and the dimensions of `at_load`: friction_all_round and friction_by_axis
        with the sampling interval, friction_combined with the combined one, true area, number of contacts, mean
        pressure, stiffness, and rms_gradient and rms_slope of the gap; upper_rms and lower_rms (µm) are the
        root-mean-square heights of the two bodies of the first member, where their files are there. The attribute
        solved has the factors that are computed.

    Raises
    ------
    NotComputedError
        If a factor is neither computed nor between computed ones a step apart.
    ValueError
        If the study is not of two measured surfaces or not finished, or a factor is outside its range.

    Notes
    -----
    Between computed factors, positive variables are interpolated by a monotone cubic of their logarithms over the
    logarithm of the factor, and others by one of their values.
    """
    import xarray

    factors, study = parse_factors(factors), result.study
    scale_study_heights(study, 1.0, scaled)
    if result.count < study.ensemble.repetitions:
        raise ArgumentError("{height_scale} needs a finished result")
    there = open_stored_factors(result, scaled)
    solved = np.array(list(there))
    if (missing := find_missing_factors(factors, solved)).size:
        raise MissingFactorsError(missing, estimate_factor_time(study, missing.size))
    around = [places for each in factors.tolist() if (places := _find_neighbors(solved, each))]
    points = [
        add_uncertainty(at_load(each, loads, mu0=mu0, tau0=tau0), each, budget=False).isel(cut_off=0)
        for each in map(Result, there.values())
    ]
    first = points[list(there).index(1.0)]
    variables: dict[str, Any] = {}
    for name in (each for each in _INTERPOLATED_VARIABLES if all(each in point for point in points)):
        values = np.stack([point[name].transpose(*first[name].dims).values for point in points])
        read = np.stack([_interpolate_factors(values, solved, *each) for each in zip(factors, around, strict=True)])
        if "statistic" in first[name].dims:  # which is the last dimension
            read[..., 1], read[..., 2] = np.minimum(read[..., 1], read[..., 0]), np.maximum(read[..., 2], read[..., 0])
        variables[name] = (("height_scale", *first[name].dims), read, first[name].attrs)
    if all("contact_status" in point for point in points):
        dims = first["contact_status"].dims
        statuses = np.stack([point["contact_status"].transpose(*dims).values for point in points])
        other = STATUS_OK if study.uses_half_space else ABOVE_NOMINAL
        read = np.stack([np.where(statuses[i] == statuses[j], statuses[i], other) for i, j in around])
        variables["contact_status"] = (("height_scale", *dims), read, first["contact_status"].attrs)
    for side, rms in _compute_rms_heights(study).items():
        own = rms * (factors if scaled in ("both", side) else np.ones(factors.size))
        variables[f"{side}_rms"] = ("height_scale", own, attributes_of(f"{side}_rms"))
    own_dims = set(np.concatenate([np.ravel(each[0]) for each in variables.values()]).tolist())
    coordinates: dict[str, Any] = {str(name): each for name, each in first.coords.items() if set(each.dims) <= own_dims}
    coordinates["height_scale"] = ("height_scale", factors, attributes_of("height_scale"))
    return xarray.Dataset(variables, coordinates, first.attrs | {"scaled": scaled, "solved": solved})


def _compute_rms_heights(study: Study) -> dict[str, float]:
    """Return the root-mean-square heights (µm) of the bodies of the first member; none where files are gone."""
    try:
        return {side: float(np.std(body.heights)) for side, body in zip(SIDES, first_pair(study), strict=True)}
    except (ValueError, OSError):
        return {}


def _interpolate_factors(values: Floats, solved: Floats, factor: float, around: tuple[int, int]) -> Floats:
    """Return values over solved factors (first axis) at another one; NaN where they are at one of its neighbors."""
    from scipy.interpolate import PchipInterpolator

    left, right = around
    if left == right:
        return np.asarray(values[left])
    flat = values.reshape(solved.size, -1)
    finite = np.isfinite(flat)
    found = np.full(flat.shape[1], np.nan)
    answered = finite[left] & finite[right]
    x = np.log(solved)
    for there in np.unique(finite[:, answered], axis=1).T:
        own = answered & (finite == there[:, np.newaxis]).all(axis=0)
        positive = own & (flat[there] > 0).all(axis=0)
        for which, to, back in ((positive, np.log, np.exp), (own & ~positive, np.asarray, np.asarray)):
            if which.any():
                curve = PchipInterpolator(x[there], to(flat[np.ix_(there, which)]))
                found[which] = back(curve(math.log(factor)))
    return found.reshape(values.shape[1:])
