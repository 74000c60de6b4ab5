"""Contact candidates: places where two surfaces may touch.

One search serves many approaches.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stiction._core
from stiction._caching import cached_property
from stiction._checks import Floats, check_choice, make_read_only, validate_number
from stiction._units import short_repr
from stiction.mechanics.model import (
    ContactModel,
    CurvatureRequirement,
    check_pair,
    make_model,
    make_pair_model,
    reject_missing_modulus,
    source_history_entry,
)
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

_GROOVE_TOLERANCE_TO_GAP_RANGE = 1e-9


@dataclass(frozen=True, eq=False, repr=False)
class Candidates:
    """Local minima of the spline-interpolated gap between two surfaces.

    All arrays are read-only.

    Returned by `candidates`; `contacts` and `press` accept it instead of two surfaces. Positions are in the frame of
    the lower surface.

    Attributes
    ----------
    index : (c,) ndarray of int
        Grid point to the left of the minimum, or to the lower left of it on surfaces, counted row by row.
    position : (c, 3) ndarray, µm
        Position on the lower surface.
    gap : (c,) ndarray, µm
        Gap minus the gap at first contact of the grid points; the candidate touches at larger approaches. The value is
        slightly negative if a minimum between grid points is lower than all grid points.
    radii : (c, 2) ndarray, µm
        Principal radii of the relative curvature, the larger one first.
    deepest : float, µm
        Largest approach that the search covered.
    curvature : {"convex", "signed"}
        Criterion of the search.
    sources : tuple of str
        Files of the surfaces, if they were read from files.

    Examples
    --------
    >>> from stiction import candidates, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> candidates(upper, lower, deepest=0.02)
    Candidates: 10 up to an approach of 0.02 µm, signed curvature
    """

    core: stiction._core.Candidates | stiction._core.ArealCandidates
    curvature: CurvatureRequirement
    sources: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of contact candidates."""
        return len(self.core)

    def __repr__(self) -> str:
        """Return a line with the number of candidates, the maximum approach and the curvature criterion."""
        return f"Candidates: {len(self)} up to an approach of {self.deepest:.4g} µm, {self.curvature} curvature"

    @property
    def deepest(self) -> float:  # noqa: D102
        return self.core.deepest

    @property
    def index(self) -> NDArray[np.int64]:  # noqa: D102
        return self._arrays_by_column_name["index"].astype(np.int64, copy=False)

    @property
    def position(self) -> Floats:  # noqa: D102
        return self._arrays_by_column_name["position"]

    @property
    def gap(self) -> Floats:  # noqa: D102
        return self._arrays_by_column_name["gap"]

    @property
    def radii(self) -> Floats:  # noqa: D102
        return self._arrays_by_column_name["radii"]

    @cached_property
    def _arrays_by_column_name(self) -> dict[str, NDArray[np.float64]]:
        return {name: make_read_only(column) for name, column in self.core.columns().items()}


def candidates(
    upper: Profile | Surface, lower: Profile | Surface, *, deepest: float, curvature: CurvatureRequirement | None = None
) -> Candidates:
    """Find the places where two surfaces may touch at any approach up to a given maximum.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Two profiles or two surfaces on the same grid. A profile that is straight to round-off is treated as flat.
    deepest : float, µm
        Largest approach, at least 0.
    curvature : {"convex", "signed"}, optional
        With "convex", both surfaces must be convex at a contact; with "signed", only their gap. The default is "convex"
        for profiles and "signed" for surfaces.

    Returns
    -------
    candidates : Candidates
        Positions, gaps (µm) and radii (µm) of the possible contacts, for `contacts` and `press`.

    Raises
    ------
    ValueError
        If the grids differ or an argument is outside its range.

    See Also
    --------
    press : Loads and area from candidates.

    Notes
    -----
    Candidates are the local minima of the splined gap. One search serves any number of approaches up to `deepest`.

    Examples
    --------
    >>> import numpy as np
    >>> from stiction import Profile, candidates, press
    >>> x = np.arange(201) * 0.01 - 1.003
    >>> ball, flat = Profile(-(x**2) / 2, spacing=0.01), Profile(np.zeros(201), spacing=0.01)
    >>> found = candidates(flat, ball, deepest=0.02)
    >>> len(found), found.radii.round(3)
    (1, array([[1., 1.]]))
    >>> press(found, [0.01, 0.02]).contact_count
    array([1, 1])
    """
    check_pair(upper, lower)
    if curvature is None:
        curvature = "signed" if isinstance(upper, Surface) else "convex"
    check_choice("curvature", curvature, CurvatureRequirement)
    core = stiction._core.candidates(
        upper.heights, lower.heights, spacing=upper.spacing, deepest=validate_number("deepest", deepest, unit="µm"),
        curvature=curvature,
    )  # fmt: skip
    if isinstance(upper, Surface) and len(core) == 0:
        # The minima of a gap that is constant along one axis are lines instead of points.
        gap = upper.heights - lower.heights
        for axis, along, across in ((0, "y", "rows"), (1, "x", "columns")):
            if float(np.ptp(gap, axis=axis).max()) < _GROOVE_TOLERANCE_TO_GAP_RANGE * float(np.ptp(gap)):
                raise ValueError(
                    f"the gap between the upper and the lower surface must vary along {along}, because otherwise its "
                    f"minima are lines instead of points; extract {across} of both surfaces and press them as "
                    "profiles, or use half_space"
                )
    return Candidates(core, curvature, tuple(filter(None, map(source_history_entry, (upper, lower)))))


def find_candidates_and_model(
    upper: Any, lower: Any, contact: Mapping[str, object]
) -> tuple[Candidates | None, ContactModel]:
    """Return the contact candidates (None if the bodies are given as surfaces) and the contact model."""
    if not isinstance(upper, Candidates):
        return None, make_pair_model(upper, lower, contact)
    if "effective_modulus" not in contact and "model" not in contact:
        reject_missing_modulus(*upper.sources)
    model = make_model(contact)
    for name, expected in (("detection", "gap-minimum"), ("curvature", upper.curvature)):
        if getattr(model, name) not in (None, expected):
            raise ValueError(
                f"{name} must be {expected!r}, as in the search for the candidates, "
                f"got {short_repr(getattr(model, name))}"
            )
    model = replace(model, detection="gap-minimum", curvature=upper.curvature)
    is_areal = isinstance(upper.core, stiction._core.ArealCandidates)
    return upper, model.for_surfaces() if is_areal else model.for_profiles()
