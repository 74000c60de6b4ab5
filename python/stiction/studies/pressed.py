"""One pair of a study pressed together, to every approach or load, along every direction, by every sliding rule."""

from __future__ import annotations

import functools
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats, read_only
from stiction.mechanics.candidates import candidates
from stiction.mechanics.contact import LoadCurve, press
from stiction.mechanics.half_space import HalfSpaceCurve, half_space
from stiction.mechanics.model import ContactModel
from stiction.mechanics.quantities import DIRECTED
from stiction.studies.study import Study
from stiction.studies.study_tables import Contact
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface


def pressed(study: Study, upper: Profile | Surface, lower: Profile | Surface) -> dict[str, NDArray[Any]]:
    """Each sum of a study as an array (steps,), or of those that depend on the motion ([rules], [directions], steps).

    Raises
    ------
    ValueError
        If a load has no solution by the half-space.
    """
    curves = list(_curves(study, upper, lower))
    return {
        name: np.stack([getattr(curve, name) for curve in curves]) if name in DIRECTED else getattr(curves[0], name)
        for name in study.sums()
    }


def pressed_families(
    study: Study, upper: tuple[Floats, Floats], lower: tuple[Floats, Floats], scratch: Floats
) -> dict[str, NDArray[Any]]:
    """What `pressed` has of each pair of two families of profiles, in one call.

    Parameters
    ----------
    study : Study
        Of asperities on profiles.
    upper, lower : (k, points) ndarray and (k, 3) ndarray, µm
        Unscaled heights, which are used up, and what `ProfileGenerator.fill` returns of them.
    scratch : (2, points) ndarray

    Returns
    -------
    dict of ndarray
        Each sum as an array (k, amplitudes, rules, steps); of those that do not depend on the motion there is one rule.
    """
    surfaces, models, steps = study.surfaces, _models(study.contact), _steps(study.contact)
    amplitudes = surfaces.amplitudes()
    columns = _core.press_families(
        *upper,
        *lower,
        spacing=float(surfaces.extent) / surfaces.points,
        amplitudes=amplitudes,
        measure=surfaces.amplitude_measure,
        approaches=steps,
        models=[model.for_profiles().core() for model in models],
        scratch=scratch,
    )
    shape = len(upper[0]), amplitudes.size, len(models), steps.size
    tables = {name: columns[name].reshape(shape) for name in study.sums()}
    return {name: table if name in DIRECTED else table[:, :, :1] for name, table in tables.items()}


def _curves(
    study: Study, upper: Profile | Surface, lower: Profile | Surface
) -> Iterator[LoadCurve] | Iterator[HalfSpaceCurve]:
    """One for each sliding rule."""
    contact = study.contact
    if contact.mechanics == "half-space":
        return _half_spaces(study, upper, lower)
    models, steps = _models(contact), _steps(contact)
    if isinstance(upper, Surface) or isinstance(lower, Surface):
        found = candidates(upper, lower, deepest=float(steps[-1]), curvature=contact.curvature)
        return (press(found, steps, model=model) for model in models)
    return (press(upper, lower, steps, model=model) for model in models)


# A study presses thousands of pairs alike, and to make these takes as long as a tenth of a pair.


@functools.lru_cache(maxsize=4)
def _models(contact: Contact) -> tuple[ContactModel, ...]:
    return tuple(contact.model(rule) for rule in contact.rules())


@functools.lru_cache(maxsize=4)
def _steps(contact: Contact) -> Floats:
    return read_only(contact.steps())


def _half_spaces(study: Study, upper: Profile | Surface, lower: Profile | Surface) -> Iterator[HalfSpaceCurve]:
    contact = study.contact
    rules = contact.rules()
    try:
        curve = half_space(
            upper,
            lower,
            contact.steps(),
            effective_modulus=float(contact.effective_modulus),
            boundary=contact.boundary,
            compliance_share=contact.compliance_share,
            hardness=None if contact.hardness is None else float(contact.hardness),
            direction=contact.ways() if isinstance(contact.direction, tuple) else contact.ways()[0],
            sliding=rules[0],
        )
    except RuntimeError as error:
        raise ValueError(f"the half-space has {error}") from None
    yield curve
    for rule in rules[1:]:
        yield curve.with_sliding(rule)
