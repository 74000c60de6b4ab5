"""Search for the approach at which two surfaces support a given load."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core
from stiction._checks import Floats, float_array
from stiction._units import short_repr, to_core_units
from stiction.mechanics import friction
from stiction.mechanics.candidates import Candidates, candidates
from stiction.mechanics.friction import ContactSums
from stiction.mechanics.model import (
    ContactModel,
    ContactModelArguments,
    add_model_keywords_to_signature,
    check_pair,
    make_pair_model,
)
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

# Smallest computed approach, as a fraction of the gap's range: at this approach, one contact carries the whole load.
_MIN_APPROACH_TO_GAP_RANGE = 1e-6
# Ratio of successive approach distances: a load is missed if the bodies carry it only between two distances.
_SUCCESSIVE_APPROACH_RATIO = 1.1
# Number of approach distances per batch; the next batch is computed only while a requested load is not reached.
_APPROACHES_PER_BATCH = 16
_CANDIDATE_APPROACH_FACTOR = 5.0


@add_model_keywords_to_signature
def approach_at_load(
    upper: Profile | Surface,
    lower: Profile | Surface,
    loads: ArrayLike,
    *,
    mu0: float,
    tau0: float = 0.0,
    **contact: Unpack[ContactModelArguments],
) -> Floats:
    """Find, for each given normal load, the smallest approach (µm) at which two surfaces support this load.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Two profiles or two surfaces on the same grid.
    loads : array_like of float, mN
        Normal loads above 0, of any shape; or a string, "10 mN", or a list of strings.
    mu0 : float
        Molecular friction coefficient. Friction on slopes supports part of the normal load.
    tau0 : float, GPa
        Adhesive shear strength.
    **contact
        As for `press`, with one direction.

    Returns
    -------
    approach : ndarray of float, µm
        Approach at which F_N first reaches the load from below, with the shape of the loads. NaN if the load is not
        reached before all points touch, because friction locks the contacts or there are no contacts. NaN also if the
        surfaces support more than the load at an approach of 0. `Result.at` distinguishes these cases.

    Raises
    ------
    ValueError
        If the grids differ or an argument is outside its range.

    See Also
    --------
    press : Loads at given approaches.
    half_space : Boundary-element solution at given loads.

    Notes
    -----
    F_N is sampled at approaches that increase by a tenth. Within the first step that crosses a load upwards, the
    crossing is computed to 1e-12. If F_N jumps over a load, as for D >= 1.5 and with detection="cell", the result is
    the approach after the jump.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, approach_at_load
    >>> x = np.arange(201) * 0.01 - 1.003
    >>> ball, flat = Profile(-(x**2) / 2, spacing=0.01), Profile(np.zeros(201), spacing=0.01)
    >>> load = 4 / 3 * 10.0 * 0.01**1.5  # Hertz at an overlap of 10 nm
    >>> float(approach_at_load(flat, ball, load, mu0=0.3, detection="gap-minimum").round(4))
    0.01
    """
    target_loads = float_array("loads", to_core_units("loads", loads, "force"))
    if not (target_loads > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {short_repr(loads)}")
    model = make_pair_model(upper, lower, contact)
    if model.angles().ndim > 0:
        raise ValueError(
            f"direction must be a single angle, because the normal load depends on the direction, "
            f"got {short_repr(model.direction)}"
        )
    mu0, tau0 = friction.validate_mu0_and_tau0(mu0, tau0, model.effective_modulus)
    approach, _ = find_approaches_at_loads(
        SurfacePair(upper, lower), target_loads.ravel(), mu0=mu0, tau0=tau0, model=model
    )
    return approach.reshape(target_loads.shape)


class SurfacePair:
    """Pair of surfaces that stores the minima of its gap, so that later calls of `press` can reuse the minima."""

    def __init__(self, upper: Profile | Surface, lower: Profile | Surface) -> None:
        check_pair(upper, lower)
        self.upper, self.lower = upper, lower
        self._cached_candidates: Candidates | None = None

    def press(self, approaches: Floats, model: ContactModel) -> ContactSums:
        """Compute the sums of areas and forces over all contacts at each approach (µm).

        Gap minima of earlier calls are used if possible.
        """
        arguments: dict[str, Any] = {"approaches": approaches}
        if isinstance(self.upper, Surface):
            arguments["directions"] = model.directions()
        return ContactSums.from_columns(self._call_core(stiction._core.press, float(approaches[-1]), model, arguments))

    def find_approaches_between(
        self,
        loads: Floats,
        lower_approaches: Floats,
        upper_approaches: Floats,
        mu0: float,
        tau0: float,
        model: ContactModel,
    ) -> Floats:
        """Find the approach (µm), between two given approaches, that supports each load (mN)."""
        arguments = {"loads": loads, "left": lower_approaches, "right": upper_approaches, "mu0": mu0, "tau0": tau0}
        return np.asarray(
            self._call_core(stiction._core.approaches_at, float(upper_approaches.max()), model, arguments)
        )

    def _call_core(
        self, function: Callable[..., Any], deepest: float, model: ContactModel, arguments: dict[str, Any]
    ) -> Any:
        """Call a function of the C++ core with the stored minima of the gap between the surfaces.

        With "cell" detection, pass both surfaces instead.
        """
        model = make_pair_model(self.upper, self.lower, {"model": model})
        arguments = arguments | {"model": model.core()}
        if model.detection == "cell":
            return function(self.upper.heights, self.lower.heights, spacing=self.upper.spacing, **arguments)
        cached_candidates = self._cached_candidates
        if (
            cached_candidates is None
            or cached_candidates.deepest < deepest
            or cached_candidates.curvature != model.curvature
        ):
            # Candidates are searched for beyond the requested approach: later calls may request larger approaches.
            cached_candidates = candidates(
                self.upper, self.lower, deepest=_CANDIDATE_APPROACH_FACTOR * deepest, curvature=model.curvature
            )
            self._cached_candidates = cached_candidates
        return function(cached_candidates.core, **arguments)


def find_approaches_at_loads(
    bodies: SurfacePair, loads: Floats, *, mu0: float, tau0: float, model: ContactModel
) -> tuple[Floats, NDArray[np.str_]]:
    """Return the smallest approach (µm) that supports each load (mN), and a status: "ok", or why there is none."""

    def normal_load(sums: ContactSums) -> Floats:
        return friction.FrictionLaw(mu0, tau0).load("normal", sums)

    approaches = np.zeros(1)
    contact_sums = bodies.press(approaches, model)
    normal_loads = normal_load(contact_sums)
    is_exceeded = normal_loads[0] >= loads
    is_pending = ~is_exceeded
    lower_approach, upper_approach = np.full(loads.size, np.nan), np.full(loads.size, np.nan)
    has_touched = bool(contact_sums.contact_count.any())
    # If the surfaces are parallel, `max_approach` is 0, and no approach is computed.
    max_approach = float(np.ptp(bodies.upper.heights - bodies.lower.heights))
    num_approaches = (
        round(-np.log(_MIN_APPROACH_TO_GAP_RANGE) / np.log(_SUCCESSIVE_APPROACH_RATIO)) + 1 if max_approach > 0 else 0
    )
    sampled_approaches = max_approach * np.geomspace(_MIN_APPROACH_TO_GAP_RANGE, 1.0, num_approaches)
    for batch_start in range(0, num_approaches, _APPROACHES_PER_BATCH):
        if not is_pending.any():
            break
        approach_batch = sampled_approaches[batch_start : batch_start + _APPROACHES_PER_BATCH]
        contact_sums = bodies.press(approach_batch, model)
        approaches = np.append(approaches[-1], approach_batch)
        normal_loads = np.append(normal_loads[-1], normal_load(contact_sums))
        has_touched = has_touched or bool(contact_sums.contact_count.any())
        is_crossing = (normal_loads[:-1, np.newaxis] < loads) & (normal_loads[1:, np.newaxis] >= loads)
        newly_reached = is_crossing.any(axis=0) & is_pending
        index = is_crossing.argmax(axis=0)[newly_reached]
        lower_approach[newly_reached], upper_approach[newly_reached] = approaches[index], approaches[index + 1]
        is_pending &= ~newly_reached
    is_reached = ~(is_pending | is_exceeded)
    is_locked = bool(contact_sums.contact_count[-1] > 0 and normal_loads[-1] <= 0)
    status = friction.choose_statuses(touched=has_touched, reached=is_reached, below=is_exceeded, locked=is_locked)
    approach = np.full(loads.size, np.nan)
    if is_reached.any():
        approach[is_reached] = bodies.find_approaches_between(
            loads[is_reached], lower_approach[is_reached], upper_approach[is_reached], mu0, tau0, model
        )
    return approach, status
