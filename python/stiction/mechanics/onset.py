"""Onset of sliding: partial slip, pre-sliding displacement, and energy loss per cycle.

Cattaneo, Rendiconti dell'Accademia Nazionale dei Lincei 27 (1938) 342; Mindlin, Journal of Applied Mechanics 16 (1949)
259; for rough bodies Ciavarella, International Journal of Solids and Structures 35 (1998) 2349, and Jäger, Journal of
Tribology 120 (1998) 677. Unloading and cycles by Masing's rule (1926).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from stiction._checks import Floats, float_array, make_read_only, validate_number, validate_whole_number
from stiction._drawing import draw_onset
from stiction._repr import PlotReprMixin, axes_or_new_axes
from stiction._units import short_repr
from stiction.mechanics.friction import validate_mu0_and_tau0
from stiction.mechanics.model import ContactModel, Direction
from stiction.mechanics.presliding import fit_iwan, fit_lugre

if TYPE_CHECKING:
    import pandas
    from matplotlib.axes import Axes

    from stiction.mechanics.presliding import FourParameterIwan, LuGre

# Relative tolerance of tangential loads.
LOAD_TOLERANCE = 1e-9
# Smallest accepted load or displacement, as a fraction of the load or displacement at the onset of sliding.
MIN_SLIDING_FRACTION = 1e-12
# Relative tolerance of tangential displacements.
DISPLACEMENT_TOLERANCE = 1e-7


@dataclass(frozen=True)
class SlipState:
    """Partial slip at one tangential load (mN): displacement (µm), tractions (GPa), and slipped fractions.

    The fractions are those of the area and of the load.

    `point_displacements` are the displacements of the contact points if the solver returned them.
    """

    load: float
    displacement: float
    slipped_area: float
    slipped_load: float
    traction: Floats
    point_displacements: Floats | None = None


class TangentialProblem(Protocol):
    """Contact under a constant normal load and a variable tangential load.

    `bound` is the largest traction (GPa) at each point.
    """

    normal_load: float
    sliding_load: float
    stiffness: float
    bound: Floats
    points: NDArray[Any]
    size: int

    def at(self, load: float, near: SlipState | None = None) -> SlipState:
        """Return the slip state at a tangential load (mN) that does not exceed the sliding load.

        `near` is an initial guess.
        """

    def dissipated_energy(self, slip: SlipState) -> float:
        """Return the energy (mN µm) that friction dissipates in first loading from rest to a slip state."""


@dataclass(frozen=True, eq=False, repr=False)
class Onset(PlotReprMixin):
    """Onset of sliding of two surfaces while the tangential load grows from 0 at a constant normal load.

    Arrays are read-only.

    An onset is returned by ``curve.onset(index, mu0=..., tau0=...)`` of a `HalfSpaceCurve`, `LoadCurve` or
    `SurfaceLoadCurve`.

    Parameters
    ----------
    index : int
        Index of a load or an approach of the curve.
    mu0 : float
        Molecular friction coefficient.
    tau0 : float, GPa
        Adhesive shear strength.
    steps : int or sequence of float
        Number of equal steps of the tangential load up to the sliding load, or fractions of the sliding load, from
        1e-12 to 1. By default 20.
    displacements : (k,) array_like of float, µm, optional
        Displacements instead of steps. On the half-space, about ten contact problems are solved for each displacement.

    Attributes
    ----------
    tangential_load : (k,) ndarray, mN
        Ascending, by default up to `sliding_load`.
    displacement : (k,) ndarray, µm
        Displacement of the upper surface since the tangential load was 0, measured at points far away, or at the mean
        plane if periodic. NaN on a free half-plane, where points far away have no finite displacement. In full periodic
        contact, 0 until the first point slips.
    slipped_area : (k,) ndarray
        Fraction of the real contact area that slips.
    slipped_load : (k,) ndarray
        Fraction of the normal load on slipping points.
    normal_load, sliding_load : float, mN
        F, and the largest tangential load that all contacts together support, mu0 F + tau0 A.
    displacement_at_sliding : float, µm
        Pre-sliding displacement.
    stiffness : float, mN/µm
        Initial tangential stiffness, while all contacts stick.
    mu0 : float
        Molecular friction coefficient.
    tau0 : float, GPa
        Adhesive shear strength.
    direction : float, degrees
        Direction of the tangential load, from +x towards +y.

    Notes
    -----
    The traction q along the motion is at most mu0 p + tau0 on the real contact area. Points with a smaller traction
    move with the upper surface; points at the bound slip and lag behind. On the half-space, q is per projected area:
    at each point, tau0 is multiplied by the fraction in contact and by sqrt(1 + s²), with the slope s of the interface.

    The half-space problem is the normal contact problem with a hardness that differs from point to point. The kernel is
    that of pressures, with E* divided by the mean of (2 - ν)/(2 (1 - ν)) of both bodies, weighted with their
    compliances (Mindlin 1949); on profiles, for loading along the profile, it is E* itself. Not included are the
    dependence of the kernel on the direction, displacements across the motion, the effect of tractions on the pressure
    of dissimilar bodies, and slopes except in the area.

    After a reversal, the same curve applies from the point of reversal, scaled by two in both axes (Masing). The
    energies follow without integration: the dissipation in first loading is the sum of bound times slip, and the
    dissipation in a cycle is four times as large.

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
    _tangential_problem: TangentialProblem = field(repr=False)
    _slips: tuple[SlipState, ...] = field(repr=False)

    def traction(self, index: int) -> Floats:
        """Return the traction (GPa) of each grid point (0 outside the contact) at `tangential_load[index]`.

        For asperities, the mean over each contact is returned, (contacts,), in the order of `contacts`.

        Raises
        ------
        ValueError
            If the index is invalid.
        """
        return make_read_only(self._spread_over_all_points(self._slips[self._resolve_load_index(index)].traction, 0.0))

    def slip_load(self) -> Floats:
        """Return the smallest tangential load (mN) at which each grid point slips.

        Returns NaN if the point never slips.

        For asperities, the load at which each contact slides as a whole is returned, in the order of `contacts`.
        """
        first_slip_load = np.full(self._tangential_problem.bound.size, np.nan)
        for slip in reversed(self._slips):
            first_slip_load[slip.traction >= self._tangential_problem.bound] = slip.load
        return make_read_only(self._spread_over_all_points(first_slip_load, np.nan))

    def energy_lost(self, amplitude: ArrayLike) -> Floats:
        """Return the energy (mN µm) that a load cycle dissipates, for each amplitude of the tangential load.

        Parameters
        ----------
        amplitude : array_like of float, mN
            0, or from 1e-12 of the sliding load to the sliding load. Loads that are not in `tangential_load` are
            solved.

        Raises
        ------
        ValueError
            If an amplitude is outside this range. Above the sliding load, the loss depends on the path.
        """
        loads = self._validate_amplitudes(amplitude)
        losses = [
            4 * self._tangential_problem.dissipated_energy(self._solve_at_load(load)) if load > 0 else 0.0
            for load in loads.ravel().tolist()
        ]
        return np.array(losses).reshape(loads.shape)

    def loop(self, amplitude: float) -> tuple[Floats, Floats]:
        """Return displacements (µm) and tangential loads (mN) over a load cycle with a given amplitude.

        The cycle starts at the maximum. By Masing's rule, it consists of the points of the curve below the amplitude;
        more steps give a smoother cycle.

        Raises
        ------
        ValueError
            As for `energy_lost`.
        """
        turning_point = self._solve_at_load(
            float(self._validate_amplitudes(validate_number("amplitude", amplitude, unit="mN", above=0)))
        )
        is_below = self.tangential_load < turning_point.load * (1 - LOAD_TOLERANCE)
        loading_load = np.concatenate([[0.0], self.tangential_load[is_below], [turning_point.load]])
        loading_displacement = np.concatenate([[0.0], self.displacement[is_below], [turning_point.displacement]])
        unloading_branch = turning_point.displacement - 2 * loading_displacement, turning_point.load - 2 * loading_load
        return np.concatenate([unloading_branch[0], -unloading_branch[0]]), np.concatenate(
            [unloading_branch[1], -unloading_branch[1]]
        )

    def frame(self) -> pandas.DataFrame:
        """Return a table of first loading: tangential load, displacement, slipped fractions and energy loss.

        Each row is a load, and the column names contain units.

        `energy_lost` is the energy loss in a cycle with this amplitude. The table is the backbone of a Masing model.
        """
        import pandas

        columns = {
            "tangential_load_mN": self.tangential_load, "displacement_um": self.displacement,
            "slipped_area": self.slipped_area, "slipped_load": self.slipped_load,
            "energy_lost_mN_um": self.energy_lost(self.tangential_load),
        }  # fmt: skip
        return pandas.DataFrame({name: np.concatenate([[0.0], column]) for name, column in columns.items()})

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the tangential load against displacement or, if displacements are not finite, against slipped area.

        Draws into the given axes or into new axes, and returns the axes.
        """
        curve_properties = {"sliding_load": self.sliding_load, "stiffness": self.stiffness}
        return draw_onset(
            axes_or_new_axes(ax), self.tangential_load, self.displacement, self.slipped_area, **curve_properties
        )

    def iwan(self) -> FourParameterIwan:
        """Fit Segalman's four-parameter Iwan model to the onset curve; see `FourParameterIwan`.

        Raises
        ------
        ValueError
            If there are fewer than three loads, or no displacements.
        """
        curve_properties = {"sliding_load": self.sliding_load, "stiffness": self.stiffness}
        return fit_iwan(self.displacement, self.tangential_load, **curve_properties)

    def lugre(self) -> LuGre:
        """Fit the bristle stiffness of the LuGre model to the onset curve; see `LuGre`.

        Raises
        ------
        ValueError
            If there are no displacements.
        """
        return fit_lugre(self.displacement, self.tangential_load, sliding_load=self.sliding_load)

    def _resolve_load_index(self, index: Any) -> int:
        return resolve_index(index, len(self._slips), "tangential loads")

    def _spread_over_all_points(self, values: Floats, value_elsewhere: float) -> Floats:
        all_values = np.full(self._tangential_problem.size, value_elsewhere)
        all_values[self._tangential_problem.points] = values
        return all_values

    def _validate_amplitudes(self, amplitude: ArrayLike) -> Floats:
        loads = float_array("amplitude", amplitude)
        min_load = MIN_SLIDING_FRACTION * self.sliding_load
        is_in_range = (loads >= min_load) & (loads <= self.sliding_load * (1 + LOAD_TOLERANCE))
        if not (is_in_range | (loads == 0)).all():
            raise ValueError(
                f"amplitude must be between {min_load:g} mN and the sliding load, {self.sliding_load:g} mN, "
                f"got {short_repr(amplitude)}"
            )
        return np.minimum(loads, self.sliding_load)

    def _solve_at_load(self, load: float) -> SlipState:
        """Return the slip state at a tangential load (mN).

        The solution at the nearest load is the initial guess.
        """
        nearest_slip = min(self._slips, key=lambda slip: abs(slip.load - load))
        return (
            nearest_slip
            if abs(nearest_slip.load - load) <= LOAD_TOLERANCE * self.sliding_load
            else self._tangential_problem.at(load, nearest_slip)
        )


def compute_onset(
    tangential_problem: TangentialProblem, *, mu0: float, tau0: float, direction: float, steps: int | Sequence[float],
    displacements: ArrayLike | None,
) -> Onset:  # fmt: skip
    """Compute the onset of sliding at given fractions of the sliding load, or at given displacements (µm)."""
    sliding_state = tangential_problem.at(tangential_problem.sliding_load)
    slip_states: list[SlipState] = []
    if displacements is None:
        for load_fraction in parse_load_fractions(steps).tolist():
            slip_states.append(
                tangential_problem.at(
                    load_fraction * tangential_problem.sliding_load, slip_states[-1] if slip_states else None
                )
                if load_fraction < 1
                else sliding_state
            )
    else:
        for displacement in _validate_displacements(displacements, sliding_state.displacement).tolist():
            slip_states.append(
                _solve_at_displacement(
                    tangential_problem, displacement, sliding_state, slip_states[-1] if slip_states else None
                )
            )
    columns = {
        name: make_read_only(np.array([getattr(slip, name) for slip in slip_states]))
        for name in ("displacement", "slipped_area", "slipped_load")
    }
    return Onset(
        tangential_load=make_read_only(np.array([slip.load for slip in slip_states])), **columns,
        normal_load=tangential_problem.normal_load, sliding_load=tangential_problem.sliding_load,
        displacement_at_sliding=sliding_state.displacement, stiffness=tangential_problem.stiffness,
        mu0=mu0, tau0=tau0, direction=direction, _tangential_problem=tangential_problem, _slips=tuple(slip_states),
    )  # fmt: skip


DEFAULT_POISSON_RATIO = 0.3
MIN_RELATIVE_STRENGTH = 1e-9
"""Smallest mu0 or tau0/E* for which an onset of sliding is computed. Smaller friction is lost in round-off."""


def resolve_index(index: Any, count: int, items: str) -> int:
    """Convert an index, which may count from the end, to a nonnegative index. Raise a `ValueError` if out of range."""
    try:
        checked_index = validate_whole_number("index", index, minimum=-count, maximum=count - 1)
    except ValueError:
        raise ValueError(
            f"index must be at least {-count} and below {count}, the number of {items}, got {short_repr(index)}"
        ) from None
    return checked_index % count


def validate_nonzero_strengths(mu0: Any, tau0: Any, effective_modulus: float) -> tuple[float, float]:
    """Check that mu0 and tau0 (GPa) are not both negligible, and return both as floats."""
    strengths = validate_mu0_and_tau0(mu0, tau0, effective_modulus)
    if max(strengths[0], strengths[1] / effective_modulus) < MIN_RELATIVE_STRENGTH:
        raise ValueError(
            "mu0 and tau0 must not both be 0 or negligible, because nothing would resist sliding; "
            f"mu0 or tau0/E* must be at least {MIN_RELATIVE_STRENGTH:g}"
        )
    return strengths


def parse_direction(direction: Direction, *, line: bool) -> float:
    """Parse a single direction of motion, and return its angle from +x towards +y in degrees.

    With `line`, for profiles, the direction must be along x.
    """
    model = ContactModel(direction=direction)
    if model.angles().ndim > 0:
        raise ValueError(f"direction must be a single angle, got {short_repr(direction)}")
    if line:
        model.for_profiles()
    return float(model.angles())


def parse_poisson_ratios(poisson: float | Sequence[float]) -> tuple[float, float]:
    """Parse Poisson's ratios of the upper and the lower body from a pair of numbers, or from one number for both."""
    given_ratios = float_array("poisson", poisson)
    if given_ratios.shape not in ((), (1,), (2,)) or not ((given_ratios > -1) & (given_ratios <= 0.5)).all():
        raise ValueError(
            "poisson must be one ratio, or two ratios for the upper and the lower body, above -1 and at most 0.5, "
            f"got {short_repr(poisson)}"
        )
    two_ratios = np.broadcast_to(given_ratios.ravel(), (2,))
    return float(two_ratios[0]), float(two_ratios[1])


def parse_load_fractions(steps: int | Sequence[float]) -> Floats:
    """Convert the argument `steps` to fractions of the sliding load.

    An integer n means n equal steps up to 1.
    """
    if np.ndim(steps) == 0:
        count = validate_whole_number("steps", steps, minimum=1, maximum=100_000)
        return np.arange(1, count + 1) / count
    fractions = float_array("steps", steps, ndim=1)
    if not (fractions.size > 0 and (fractions > 0).all() and (np.diff(fractions) > 0).all()):
        raise ValueError(
            f"steps must be fractions of the sliding load, above 0 and strictly increasing, got {short_repr(steps)}"
        )
    if not (fractions[0] >= MIN_SLIDING_FRACTION and fractions[-1] <= 1):
        raise ValueError(
            f"steps are fractions of the sliding load and must be between {MIN_SLIDING_FRACTION:g} and 1, "
            f"got {short_repr(steps)}"
        )
    return fractions


def _validate_displacements(displacements: ArrayLike, limit: float) -> Floats:
    displacement_array = float_array("displacements", displacements, ndim=1)
    if not (displacement_array.size > 0 and (displacement_array > 0).all() and (np.diff(displacement_array) > 0).all()):
        raise ValueError(f"displacements must be above 0 µm and strictly increasing, got {short_repr(displacements)}")
    if not np.isfinite(limit):
        raise ValueError(
            "displacements must not be given for a free half-plane, because its displacement is infinite at any load; "
            "give steps, or press with boundary='periodic'"
        )
    if not limit > 0:
        raise ValueError(
            "displacements must not be given for flat surfaces in full contact, because such surfaces do not move "
            "before they slide; give steps instead"
        )
    min_displacement = MIN_SLIDING_FRACTION * limit
    if not (displacement_array[0] >= min_displacement and displacement_array[-1] <= limit):
        raise ValueError(
            f"displacements must be between {min_displacement:g} µm and the displacement at sliding, {limit:g} µm, "
            f"got {short_repr(displacements)}"
        )
    return displacement_array


def _solve_at_displacement(
    tangential_problem: TangentialProblem, target_displacement: float, sliding_state: SlipState, near: SlipState | None
) -> SlipState:
    """Find the slip state with a given displacement (µm) by varying the tangential load."""
    from scipy.optimize import brentq

    sliding_displacement = sliding_state.displacement
    states_by_load = {1.0: sliding_state}
    if near is not None:
        states_by_load[near.load / tangential_problem.sliding_load] = near

    def excess_displacement(load_fraction: float) -> float:
        if load_fraction == 0:
            return -target_displacement
        if load_fraction not in states_by_load:
            nearest_fraction = min(states_by_load, key=lambda value: abs(value - load_fraction))
            states_by_load[load_fraction] = tangential_problem.at(
                load_fraction * tangential_problem.sliding_load, states_by_load[nearest_fraction]
            )
        return states_by_load[load_fraction].displacement - target_displacement

    if target_displacement >= sliding_displacement * (1 - DISPLACEMENT_TOLERANCE):
        return sliding_state
    load_fraction = brentq(
        excess_displacement,
        min(states_by_load) if near else 0.0,
        1.0,
        xtol=DISPLACEMENT_TOLERANCE * target_displacement / sliding_displacement,
        rtol=1e-12,
    )
    return states_by_load[load_fraction]
