"""Load instead of approach: how far two bodies come together under a given normal load."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Unpack

import numpy as np
from numpy.typing import ArrayLike, NDArray

import stiction._core
from stiction._checks import Floats, float_array
from stiction._units import to_core_units
from stiction.mechanics import friction
from stiction.mechanics.candidates import Candidates, candidates
from stiction.mechanics.friction import Sums
from stiction.mechanics.model import ContactKeywords, ContactModel, check_pair, model_for_pair, shows_model
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

_LEAST = 1e-6  # smallest sampled approach, in ranges of the gap; below it the load is that of the first contact alone
_STEP = 1.1  # ratio of neighbouring sampled approaches: a load that is crossed and lost again within one may be missed
_STEPS_AT_A_TIME = 16  # sampled approaches between two looks at whether all loads are reached; deeper ones cost more
_FURTHER = 5.0  # how much further than they are asked for candidates are looked for


@shows_model
def approach_at_load(
    upper: Profile | Surface,
    lower: Profile | Surface,
    loads: ArrayLike,
    *,
    mu0: float,
    tau0: float = 0.0,
    **contact: Unpack[ContactKeywords],
) -> Floats:
    """Approach at which two bodies first carry given normal loads.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Both of one kind, on the same grid.
    loads : array_like of float, mN
        Above 0, of any shape; or text, "10 mN" or a list of such.
    mu0 : float
        Molecular friction coefficient; friction on slopes carries a part of the normal load.
    tau0 : float, GPa
        Adhesive shear strength.
    **contact
        As for `press`, with one direction.

    Returns
    -------
    ndarray, µm
        Of the shape of the loads: where F_N first reaches the load from below. NaN where it is not reached before all
        points are in touch, because friction locks the contacts or there are none, and where more than the load is
        carried at an approach of 0 already; `traverse` tells these apart.

    Notes
    -----
    F_N is sampled in steps of a tenth of the approach; within the first step that crosses a load upwards the
    crossing is found to 1e-12. Where F_N jumps over a load, as it does at D >= 1.5 and with detection="cell", the
    approach is the one behind the jump.

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
    wanted = float_array("loads", to_core_units("loads", loads, "force"))
    if not (wanted > 0).all():
        raise ValueError(f"loads must be above 0 mN, got {loads!r}")
    model = model_for_pair(upper, lower, contact)
    if model.angles().ndim > 0:
        raise ValueError(f"direction must be one, because F_N depends on it, got {model.direction!r}")
    mu0, tau0 = friction.one_material(mu0, tau0, model.effective_modulus)
    approach, _ = crossing(Bodies(upper, lower), wanted.ravel(), mu0=mu0, tau0=tau0, model=model)
    return approach.reshape(wanted.shape)


class Bodies:
    """Two bodies that are pressed together again and again; the gap minima of a curvature are found once."""

    def __init__(self, upper: Profile | Surface, lower: Profile | Surface) -> None:
        check_pair(upper, lower)
        self.upper, self.lower = upper, lower
        self._found: Candidates | None = None

    def pressed(self, approaches: Floats, model: ContactModel) -> Sums:
        """The sums of `press`; whatever has been found before, they are the same to the bit."""
        given: dict[str, Any] = {"approaches": approaches}
        if isinstance(self.upper, Surface):
            given["directions"] = model.directions()
        return Sums.of(self._by(stiction._core.press, float(approaches[-1]), model, given))

    def rising_through(
        self, loads: Floats, left: Floats, right: Floats, mu0: float, tau0: float, model: ContactModel
    ) -> Floats:
        """Approaches between `left`, where F_N is below loads, and `right`, where it is not."""
        given = {"loads": loads, "left": left, "right": right, "mu0": mu0, "tau0": tau0}
        return np.asarray(self._by(stiction._core.approaches_at, float(right.max()), model, given))

    def _by(self, function: Callable[..., Any], deepest: float, model: ContactModel, given: dict[str, Any]) -> Any:
        """What a function of the core says of both bodies, or of their minima up to an approach."""
        model = model_for_pair(self.upper, self.lower, {"model": model})
        given = given | {"model": model.core()}
        if model.detection == "cell":
            return function(self.upper.heights, self.lower.heights, spacing=self.upper.spacing, **given)
        found = self._found
        if found is None or found.deepest < deepest or found.curvature != model.curvature:
            # Further, because what is asked for next is often deeper.
            found = candidates(self.upper, self.lower, deepest=_FURTHER * deepest, curvature=model.curvature)
            self._found = found
        return function(found.core, **given)


def crossing(
    bodies: Bodies, loads: Floats, *, mu0: float, tau0: float, model: ContactModel
) -> tuple[Floats, NDArray[np.str_]]:
    """Approaches (l,) that first carry loads (l,), and the status of each: "ok", or why it is NaN."""

    def carried(sums: Sums) -> Floats:
        return friction.load_of("normal", sums, mu0, tau0)

    steps = np.zeros(1)
    curve = bodies.pressed(steps, model)
    normal = carried(curve)
    below = normal[0] >= loads
    todo = ~below
    left, right = np.full(loads.size, np.nan), np.full(loads.size, np.nan)
    touched = bool(curve.contact_count.any())
    # In equal ratios up to where all points are in touch; there are none for parallel bodies.
    most = float(np.ptp(bodies.upper.heights - bodies.lower.heights))
    count = round(-np.log(_LEAST) / np.log(_STEP)) + 1 if most > 0 else 0
    sampled = most * np.geomspace(_LEAST, 1.0, count)
    for first in range(0, count, _STEPS_AT_A_TIME):
        if not todo.any():
            break
        chunk = sampled[first : first + _STEPS_AT_A_TIME]
        curve = bodies.pressed(chunk, model)
        steps = np.append(steps[-1], chunk)
        normal = np.append(normal[-1], carried(curve))
        touched = touched or bool(curve.contact_count.any())
        crosses = (normal[:-1, np.newaxis] < loads) & (normal[1:, np.newaxis] >= loads)
        found = crosses.any(axis=0) & todo
        index = crosses.argmax(axis=0)[found]
        left[found], right[found] = steps[index], steps[index + 1]
        todo &= ~found
    reached = ~(todo | below)
    locked = bool(curve.contact_count[-1] > 0 and normal[-1] <= 0)
    status = friction.status_of(touched=touched, reached=reached, below=below, locked=locked)
    approach = np.full(loads.size, np.nan)
    if reached.any():
        approach[reached] = bodies.rising_through(loads[reached], left[reached], right[reached], mu0, tau0, model)
    return approach, status
