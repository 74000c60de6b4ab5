"""How two bodies begin to slide: what slips first, how far they creep before, and what a cycle costs.

Cattaneo, Rendiconti dell'Accademia Nazionale dei Lincei 27 (1938) 342; Mindlin, Journal of Applied Mechanics 16 (1949)
259; for rough bodies Ciavarella, Journal of the Mechanics and Physics of Solids 46 (1998) 2349, and Jäger, Archive of
Applied Mechanics 68 (1998) 377. Unloading and cycles by Masing's rule (1926).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array, number, read_only, whole_number
from stiction._repr import PlotRepr, axes_for
from stiction.mechanics.friction import one_material
from stiction.mechanics.model import ContactModel, Direction

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from stiction.mechanics.presliding import FourParameterIwan, LuGre

SAME_LOAD = 1e-9  # of the sliding load: loads as near as this need no solution of their own
SAME_DISPLACEMENT = 1e-7  # of the displacement at sliding, to which a displacement that is asked for is met


@dataclass(frozen=True)
class Slip:
    """The bodies under one tangential load on its first way up: mN, µm, fractions, and GPa of the points in contact."""

    load: float
    displacement: float
    slipped_area: float
    slipped_load: float
    traction: Floats


class Held(Protocol):
    """Two bodies under a normal load that are about to be pushed; `bound` (GPa) is what points in contact hold."""

    normal_load: float
    sliding_load: float
    stiffness: float
    bound: Floats
    points: NDArray[Any]
    size: int

    def at(self, load: float, near: Slip | None = None) -> Slip:
        """Under a load above 0 and up to the sliding load; `near` is a state to begin from."""

    def dissipated(self, slip: Slip) -> float:
        """What friction has taken on the way up, mN µm: the sum of bound times slip."""


@dataclass(frozen=True, eq=False, repr=False)
class Onset(PlotRepr):
    """How two bodies under a normal load begin to slide as a tangential load grows from 0; all arrays are read-only.

    Made by ``curve.onset(index, mu0=..., tau0=...)`` of a `HalfSpaceCurve`, a `LoadCurve` or a `SurfaceLoadCurve`.

    Parameters
    ----------
    index : int
        Of the curve's loads or approaches, of which any mu0 and tau0 may be asked.
    mu0 : float
        Molecular friction coefficient.
    tau0 : float, GPa
        Adhesive shear strength.
    steps : int or sequence of float
        How many equal steps of the tangential load there are up to the sliding load, or fractions of that, above 0 and
        up to 1. By default 20.
    displacements : (k,) array_like of float, µm, optional
        In place of steps. On the half-space each takes some ten solutions.

    Attributes
    ----------
    tangential_load : (k,) ndarray, mN
        Rising, by default to `sliding_load`.
    displacement : (k,) ndarray, µm
        Of the upper body since the tangential load was 0: of its far points, or of its mean plane where periodic. NaN
        on a free half-plane, whose far points have no limit.
    slipped_area : (k,) ndarray
        Fraction of the true contact area that slips.
    slipped_load : (k,) ndarray
        Fraction of the normal load on what slips.
    normal_load, sliding_load : float, mN
        F, and what all contacts together hold, mu0 F + tau0 A.
    displacement_at_sliding : float, µm
        How far they creep before they slide.
    stiffness : float, mN/µm
        At rest, while all contacts stick.
    mu0 : float
        Molecular friction coefficient.
    tau0 : float, GPa
        Adhesive shear strength.
    direction : float, degrees
        From +x towards +y, where the upper body is pushed.

    Notes
    -----
    The traction q along the motion is at most mu0 p + tau0 on the true contact. Where it is below, points move with the
    upper body; where it is at that bound they slip, and lag behind: on the half-space the same problem as that of
    pressures up to a hardness, with a hardness that differs from point to point. The kernel is that of pressures, with
    E* divided by the mean of (2 - ν)/(2 (1 - ν)) of both bodies, weighed by their compliances (Mindlin 1949); on
    profiles, which are pushed along themselves, E* itself. Left out are how the kernel depends on the direction,
    displacements across the motion, what the traction does to the pressure where the bodies are not alike, and slopes.

    After a reversal the same curve holds, twice as large in both axes and begun from there (Masing). Energies follow
    without integration: what friction takes on the first way up is the sum of bound times slip, and a cycle takes four
    times that.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Surface, half_space
    >>> x = (np.arange(48) - 23.7) / 24
    >>> ball = Surface(-(x**2 + x[:, np.newaxis] ** 2) / 2, spacing=1 / 24)
    >>> flat = Surface(np.zeros((48, 48)), spacing=1 / 24)
    >>> onset = half_space(flat, ball, [2.0]).onset(0, mu0=0.3, steps=[0.5, 1.0])
    >>> onset.tangential_load
    array([0.3, 0.6])
    >>> (onset.displacement / onset.displacement_at_sliding).round(2)  # Mindlin: 1 - (1 - 1/2)^(2/3) = 0.37
    array([0.37, 1.  ])
    """

    tangential_load: Floats = field(metadata={"unit": "mN"})
    displacement: Floats = field(metadata={"unit": "µm"})
    slipped_area: Floats
    slipped_load: Floats
    normal_load: float = field(metadata={"unit": "mN"})
    sliding_load: float = field(metadata={"unit": "mN"})
    displacement_at_sliding: float = field(metadata={"unit": "µm"})
    stiffness: float = field(metadata={"unit": "mN/µm"})
    mu0: float
    tau0: float = field(metadata={"unit": "GPa"})
    direction: float = field(metadata={"unit": "degrees"})
    _held: Held = field(repr=False)
    _slips: tuple[Slip, ...] = field(repr=False)

    def traction(self, index: int) -> Floats:
        """(points,) GPa at `tangential_load[index]`, along the motion: over the grid, row by row; 0 out of contact.

        Of asperities the mean over each contact, (contacts,), in the order of `contacts`.

        Raises
        ------
        ValueError
            If there is no such load.
        """
        return read_only(self._spread(self._slips[self._place(index)].traction, 0.0))

    def slip_load(self) -> Floats:
        """(points,) mN: the first of `tangential_load` at which each point slips; NaN where none does.

        Of asperities that at which the whole contact slides, (contacts,).
        """
        first = np.full(self._held.bound.size, np.nan)
        for slip in reversed(self._slips):
            first[slip.traction >= self._held.bound] = slip.load
        return read_only(self._spread(first, np.nan))

    def energy_lost(self, amplitude: ArrayLike) -> Floats:
        """What a cycle between plus and minus a tangential load takes, mN µm; of the shape of the amplitudes.

        Parameters
        ----------
        amplitude : array_like of float, mN
            From 0 to the sliding load. Loads that are none of `tangential_load` are solved for.

        Raises
        ------
        ValueError
            If an amplitude is negative, or above the sliding load: then they slide, by what the path says.
        """
        loads = self._amplitudes(amplitude)
        lost = [4 * self._held.dissipated(self._at(load)) if load > 0 else 0.0 for load in loads.ravel().tolist()]
        return np.array(lost).reshape(loads.shape)

    def loop(self, amplitude: float) -> tuple[Floats, Floats]:
        """A cycle between plus and minus a tangential load: displacements (µm) and loads (mN), from the top and back.

        Of the points of the curve below the amplitude, by Masing's rule: ask for more steps where it shall be smoother.

        Raises
        ------
        ValueError
            As for `energy_lost`.
        """
        top = self._at(float(self._amplitudes(number("amplitude", amplitude, unit="mN", above=0))))
        below = self.tangential_load < top.load * (1 - SAME_LOAD)
        load = np.concatenate([[0.0], self.tangential_load[below], [top.load]])
        way = np.concatenate([[0.0], self.displacement[below], [top.displacement]])
        down = top.displacement - 2 * way, top.load - 2 * load
        return np.concatenate([down[0], -down[0]]), np.concatenate([down[1], -down[1]])

    def frame(self) -> pandas.DataFrame:
        """The curve as a table from rest on, for `to_csv`: a row a load, each column with its unit.

        `energy_lost` is that of a cycle of this amplitude. It is the backbone of a Masing model.
        """
        import pandas

        columns = {
            "tangential_load_mN": self.tangential_load, "displacement_um": self.displacement,
            "slipped_area": self.slipped_area, "slipped_load": self.slipped_load,
            "energy_lost_mN_um": self.energy_lost(self.tangential_load),
        }  # fmt: skip
        return pandas.DataFrame({name: np.concatenate([[0.0], column]) for name, column in columns.items()})

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the tangential load over the displacement, or over the slipped area where there is no displacement.

        Into given axes, or by default new ones, which are returned.
        """
        from stiction._drawing import draw_onset

        of_curve = {"sliding_load": self.sliding_load, "stiffness": self.stiffness}
        return draw_onset(axes_for(ax), self.tangential_load, self.displacement, self.slipped_area, **of_curve)

    def iwan(self) -> FourParameterIwan:
        """Segalman's four-parameter Iwan model of the curve, see `FourParameterIwan`.

        Raises
        ------
        ValueError
            If there are fewer than three loads, or no displacements.
        """
        from stiction.mechanics.presliding import fitted_iwan

        of_curve = {"sliding_load": self.sliding_load, "stiffness": self.stiffness}
        return fitted_iwan(self.displacement, self.tangential_load, **of_curve)

    def lugre(self) -> LuGre:
        """The bristle stiffness of the LuGre model of the curve, see `LuGre`.

        Raises
        ------
        ValueError
            If there are no displacements.
        """
        from stiction.mechanics.presliding import fitted_lugre

        return fitted_lugre(self.displacement, self.tangential_load, sliding_load=self.sliding_load)

    def _place(self, index: Any) -> int:
        return place_of(index, len(self._slips), "tangential loads")

    def _spread(self, values: Floats, elsewhere: float) -> Floats:
        everywhere = np.full(self._held.size, elsewhere)
        everywhere[self._held.points] = values
        return everywhere

    def _amplitudes(self, amplitude: ArrayLike) -> Floats:
        loads = float_array("amplitude", amplitude)
        if not ((loads >= 0) & (loads <= self.sliding_load * (1 + SAME_LOAD))).all():
            raise ValueError(
                f"amplitude must be from 0 to {self.sliding_load:g} mN, above which it slides, got {amplitude!r}"
            )
        return np.minimum(loads, self.sliding_load)

    def _at(self, load: float) -> Slip:
        """The state at a load, begun from the nearest one that is known."""
        near = min(self._slips, key=lambda slip: abs(slip.load - load))
        return near if abs(near.load - load) <= SAME_LOAD * self.sliding_load else self._held.at(load, near)


def onset_of(
    held: Held, *, mu0: float, tau0: float, direction: float, steps: int | Sequence[float],
    displacements: ArrayLike | None,
) -> Onset:  # fmt: skip
    """The curve of bodies at fractions of the sliding load, or at displacements."""
    at_sliding = held.at(held.sliding_load)
    slips: list[Slip] = []
    if displacements is None:
        for part in fractions_of(steps).tolist():
            slips.append(held.at(part * held.sliding_load, slips[-1] if slips else None) if part < 1 else at_sliding)
    else:
        for one in _displacements(displacements, at_sliding.displacement).tolist():
            slips.append(_at_displacement(held, one, at_sliding, slips[-1] if slips else None))
    columns = {
        name: read_only(np.array([getattr(slip, name) for slip in slips]))
        for name in ("displacement", "slipped_area", "slipped_load")
    }
    return Onset(
        tangential_load=read_only(np.array([slip.load for slip in slips])), **columns, normal_load=held.normal_load,
        sliding_load=held.sliding_load, displacement_at_sliding=at_sliding.displacement, stiffness=held.stiffness,
        mu0=mu0, tau0=tau0, direction=direction, _held=held, _slips=tuple(slips),
    )  # fmt: skip


WEAKEST = 1e-9
"""Least mu0, or tau0 over the modulus, of which the onset of sliding is computed; less is lost in round-off."""


def place_of(index: Any, count: int, what: str) -> int:
    """An index from the front or the back, as one from the front."""
    try:
        place = whole_number("index", index, minimum=-count, maximum=count - 1)
    except ValueError:
        raise ValueError(f"index must be one of the {count} {what}, got {index!r}") from None
    return place % count


def strengths(mu0: Any, tau0: Any, effective_modulus: float) -> tuple[float, float]:
    """mu0 and tau0 (GPa) that hold something."""
    both = one_material(mu0, tau0, effective_modulus)
    if max(both[0], both[1] / effective_modulus) < WEAKEST:
        raise ValueError(
            f"mu0 and tau0 must not both be 0, or below {WEAKEST:g} and that part of the modulus: nothing would hold "
            "the bodies, and they slide at once"
        )
    return both


def heading(direction: Direction, *, line: bool) -> float:
    """Degrees from +x towards +y of one direction, which on profiles is along x."""
    model = ContactModel(direction=direction)
    if model.angles().ndim > 0:
        raise ValueError(f"direction must be one, got {direction!r}")
    if line:
        model.for_profiles()
    return float(model.angles())


def poisson_ratios(poisson: float | Sequence[float]) -> tuple[float, float]:
    """Poisson's ratios of the upper and the lower body, given as one for both or as two."""
    values = float_array("poisson", poisson)
    if values.shape not in ((), (1,), (2,)) or not ((values > -1) & (values <= 0.5)).all():
        raise ValueError(
            f"poisson must be one number or two, of the upper and the lower body, above -1 and at most 0.5, "
            f"got {poisson!r}"
        )
    both = np.broadcast_to(values.ravel(), (2,))
    return float(both[0]), float(both[1])


def fractions_of(steps: int | Sequence[float]) -> Floats:
    """Fractions of the sliding load: as many equal steps up to 1, or what is given."""
    if np.ndim(steps) == 0:
        count = whole_number("steps", steps, minimum=1, maximum=100_000)
        return np.arange(1, count + 1) / count
    parts = float_array("steps", steps, ndim=1)
    if not (parts.size > 0 and (parts > 0).all() and (np.diff(parts) > 0).all()):
        raise ValueError(f"steps must be fractions of the sliding load above 0 and strictly increasing, got {steps!r}")
    if not parts[-1] <= 1:
        raise ValueError(f"steps must be at most 1: above the sliding load it slides, got {steps!r}")
    return parts


def _displacements(displacements: ArrayLike, most: float) -> Floats:
    wanted = float_array("displacements", displacements, ndim=1)
    if not (wanted.size > 0 and (wanted > 0).all() and (np.diff(wanted) > 0).all()):
        raise ValueError(f"displacements must be above 0 µm and strictly increasing, got {displacements!r}")
    if not np.isfinite(most):
        raise ValueError("displacements: a free half-plane has none; give steps, or press with boundary='periodic'")
    if not wanted[-1] <= most:
        raise ValueError(f"displacements must be at most {most:g} µm, from which on it slides, got {displacements!r}")
    return wanted


def _at_displacement(held: Held, wanted: float, at_sliding: Slip, near: Slip | None) -> Slip:
    """The state at a displacement (µm), which grows with the load."""
    from scipy.optimize import brentq

    far = at_sliding.displacement
    known = {1.0: at_sliding}
    if near is not None:
        known[near.load / held.sliding_load] = near

    def excess(part: float) -> float:
        if part == 0:
            return -wanted
        if part not in known:
            nearest = min(known, key=lambda one: abs(one - part))
            known[part] = held.at(part * held.sliding_load, known[nearest])
        return known[part].displacement - wanted

    if wanted >= far * (1 - SAME_DISPLACEMENT):
        return at_sliding
    part = brentq(excess, min(known) if near else 0.0, 1.0, xtol=SAME_DISPLACEMENT * wanted / far, rtol=1e-12)
    return known[part]
