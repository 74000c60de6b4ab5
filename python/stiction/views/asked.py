"""A result at the loads of its study: what the terminal, its table and a notebook show first."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from stiction._checks import Floats
from stiction.studies.at_load import at_load, reached_loads
from stiction.studies.budget import with_uncertainty
from stiction.studies.maps import study_of_result
from stiction.studies.onset import onset_beside
from stiction.studies.resolution import resolution_at
from stiction.studies.store import Stored

if TYPE_CHECKING:
    import xarray

DIMENSIONS = 4  # fractal dimensions of an overview if the study has a range of them
LOADS = 3  # loads of an overview if the study does not ask for any
SMALL = 2**28  # bytes


def in_memory(result: xarray.Dataset | Stored) -> xarray.Dataset | Stored:
    """Return a small stored result as a dataset, because it is read several times, and other results unchanged.

    Junction growth takes the areas at other hardnesses, which a dataset does not contain.
    """
    if not isinstance(result, Stored) or result.nbytes >= SMALL or result.study.contact.junction_growth:
        return result
    return result.dataset()


def asked_loads(result: xarray.Dataset | Stored) -> Floats:
    """The loads (mN) of its study, or if that has none, a few that are reached; an error if nothing touches."""
    friction = study_of_result(result).friction
    if friction.load:
        return np.array([float(load) for load in friction.load])
    ends = np.log10(reached_loads(result, 2))
    loads = 10 ** (ends[0] + (ends[1] - ends[0]) * np.linspace(0.2, 0.8, LOADS))
    return np.unique([float(f"{load:.0e}") for load in loads])


def once(result: Any, read: Callable[[Any], Any]) -> Any:
    """What a function reads of a result, of a stored one once."""
    return result.once(read) if isinstance(result, Stored) else read(result)


def over_and_onset(result: xarray.Dataset | Stored) -> dict[str, Any]:
    """Answers over cut-offs, and onset of sliding, that lie beside a stored result; empty of a dataset."""
    if not isinstance(result, Stored):
        return {}
    return {"over": result.once(resolution_at), "onset": result.once(onset_beside)}


def at_asked_loads(result: xarray.Dataset | Stored) -> xarray.Dataset:
    """Return a result at `asked_loads`, mu0 and tau0 of its study; a stored one is read once."""
    return once(result, _at_asked_loads)  # type: ignore[no-any-return]


def _at_asked_loads(result: xarray.Dataset | Stored) -> xarray.Dataset:
    study, stored, result = study_of_result(result), result, in_memory(result)
    loads = asked_loads(result)
    if study.is_measured:
        return with_uncertainty(at_load(result, loads.tolist()), stored)
    at = at_load(result, loads)
    surfaces: Any = study.surfaces
    if isinstance(surfaces.fractal_dimension, tuple):
        return at
    # A range is a curve, of which a few values are shown; a list has the values that were asked for.
    number = at.sizes["fractal_dimension"]
    shown = np.unique(np.linspace(0, number - 1, min(DIMENSIONS, number)).round().astype(int))
    return at.isel(fractal_dimension=shown)
