"""Loads at which a result can be evaluated: the range of computed loads, default loads, and negligible loads."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from stiction._checks import Floats
from stiction.evaluate.point import NEGLIGIBLE_LOAD_RATIO
from stiction.solve.member_sums import MemberSums
from stiction.study.study import find_step_dimension

if TYPE_CHECKING:
    import xarray

NUM_DEFAULT_LOADS = 3


def choose_loads_in_range(result: MemberSums | xarray.Dataset, steps: int = 80) -> Floats:
    """Return a geometric series of `steps` loads (mN) between the smallest and the largest load of a result."""
    elastic_loads = MemberSums.of(result).mean_elastic_loads
    highest_load = float(elastic_loads.max())
    if not highest_load > 0:
        raise ValueError("no pair of this result is in contact at any loading step, so there is nothing to draw")
    lowest_load = float(
        elastic_loads.isel({find_step_dimension(elastic_loads.to_dataset(name="load_of_step")): 0}).max()
    )
    if not 1e-6 * highest_load < lowest_load < 0.5 * highest_load:
        lowest_load = 1e-6 * highest_load if lowest_load < highest_load / 2 else highest_load / 10
    return np.asarray(np.geomspace(lowest_load, highest_load, steps))


def choose_default_loads(result: MemberSums) -> Floats:
    """Return the loads (mN) of the study or, if the study lists no loads, a few loads in the range of the result.

    Raises a `ValueError` if there is no contact.
    """
    settings = result.study.friction
    if settings.load:
        return np.array([float(load) for load in settings.load])
    log_limits = np.log10(choose_loads_in_range(result, 2))
    loads = 10 ** (log_limits[0] + (log_limits[1] - log_limits[0]) * np.linspace(0.2, 0.8, NUM_DEFAULT_LOADS))
    return np.unique([float(f"{load:.0e}") for load in loads])


def has_only_negligible_loads(result: MemberSums) -> bool:
    """Return whether all loads of the study are negligible compared with the largest mean pull-off force."""
    study = result.study
    if not (study.contact.adheres and study.friction.load):
        return False
    return float(study.friction.load[-1]) < NEGLIGIBLE_LOAD_RATIO * max(_average_pull_off_by_piece(result))


def replace_zero_load(result: MemberSums, loads: Floats) -> Floats:
    """Sort loads (mN) and remove duplicates. For adhesive bodies, replace the load 0 by a negligible load."""
    if result.study.contact.adheres and 0 in loads:
        loads = np.where(loads == 0, result.compute_once(find_negligible_load), loads)
    return np.unique(loads)


def find_negligible_load(result: MemberSums) -> float:
    """Return a load (mN) far below the pull-off force: the smallest loading step, or a smaller load if needed."""
    negligible_load = NEGLIGIBLE_LOAD_RATIO * min(_average_pull_off_by_piece(result))
    smallest_step = float(result.study.contact.loading_steps()[0])
    return smallest_step if smallest_step < negligible_load else 0.1 * negligible_load


def _average_pull_off_by_piece(result: MemberSums) -> list[float]:
    """Return the mean pull-off force (mN) of each group of members that is read into memory together."""
    return [float(np.nanmean(piece["pull_off"].values)) for piece in result.pieces(["pull_off"])]
