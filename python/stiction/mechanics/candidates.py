"""Places where two bodies may touch, found once and pressed many times."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

import stiction._core
from stiction._caching import cached_property
from stiction._checks import Floats, check_choice, number, read_only
from stiction.mechanics.model import (
    ContactModel,
    Curvature,
    check_pair,
    measured_source,
    model_for_pair,
    model_of,
    refuse_no_modulus,
)
from stiction.surfaces.profile import Profile
from stiction.surfaces.surface import Surface

_GROOVED = 1e-9  # of its depth: a gap that changes by less along x or y is one of grooves


@dataclass(frozen=True, eq=False, repr=False)
class Candidates:
    """The local minima of the splined gap between two bodies, in the order of the grid; all arrays are read-only.

    What `candidates` returns, and `contacts` and `press` take in place of two bodies. Positions are in the frame of the
    lower body.

    Attributes
    ----------
    index : (c,) ndarray of int
        Grid point on the left of the minimum; on surfaces that below it on the left, counted row by row.
    position : (c, 3) ndarray, µm
        Of the lower body there.
    gap : (c,) ndarray, µm
        Above the first touch of grid points: a candidate touches at approaches above it. Slightly negative where a
        minimum between grid points is lower than all of them.
    radii : (c, 2) ndarray, µm
        Principal radii of the relative curvature, the larger first.
    deepest : float, µm
        Approach up to which they were looked for.
    curvature : {"convex", "signed"}
        By which they were chosen.
    sources : tuple of str
        Files that the bodies were read from, if any.

    Examples
    --------
    >>> from stiction import candidates, self_affine_surface
    >>> rough = {"hurst_exponent": 0.8, "rms": 0.02, "shape": (64, 64), "spacing": 0.1}
    >>> upper, lower = (self_affine_surface(3, side=side, **rough) for side in ("upper", "lower"))
    >>> candidates(upper, lower, deepest=0.02)
    Candidates: 10 up to an approach of 0.02 µm, signed curvature
    """

    core: stiction._core.Candidates | stiction._core.ArealCandidates
    curvature: Curvature
    sources: tuple[str, ...] = ()

    def __len__(self) -> int:
        """Return the number of candidates."""
        return len(self.core)

    def __repr__(self) -> str:
        """Show how many there are, and by what they were found."""
        return f"Candidates: {len(self)} up to an approach of {self.deepest:.4g} µm, {self.curvature} curvature"

    @property
    def deepest(self) -> float:  # noqa: D102
        return self.core.deepest

    @property
    def index(self) -> NDArray[np.int64]:  # noqa: D102
        return self._columns["index"].astype(np.int64, copy=False)

    @property
    def position(self) -> Floats:  # noqa: D102
        return self._columns["position"]

    @property
    def gap(self) -> Floats:  # noqa: D102
        return self._columns["gap"]

    @property
    def radii(self) -> Floats:  # noqa: D102
        return self._columns["radii"]

    @cached_property
    def _columns(self) -> dict[str, NDArray[np.float64]]:
        return {name: read_only(column) for name, column in self.core.columns().items()}


def candidates(
    upper: Profile | Surface, lower: Profile | Surface, *, deepest: float, curvature: Curvature | None = None
) -> Candidates:
    """Where two bodies may touch at approaches up to a deepest one: the local minima of their splined gap.

    Parameters
    ----------
    upper, lower : Profile or Surface
        Both of one kind, on the same grid. A profile whose points lie on a line, to round-off, is a straight body.
    deepest : float, µm
        At least 0.
    curvature : {"convex", "signed"}, optional
        Whether both bodies must be convex, or one may be a wider cup. By default "convex" for profiles and "signed" for
        surfaces.

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
    check_choice("curvature", curvature, Curvature)
    core = stiction._core.candidates(
        upper.heights, lower.heights, spacing=upper.spacing, deepest=number("deepest", deepest, unit="µm"),
        curvature=curvature,
    )  # fmt: skip
    if isinstance(upper, Surface) and len(core) == 0:
        # A gap that does not change along x or y has valleys for minima, of which none is a point.
        gap = upper.heights - lower.heights
        for axis, along, across in ((0, "y", "rows"), (1, "x", "columns")):
            if float(np.ptp(gap, axis=axis).max()) < _GROOVED * float(np.ptp(gap)):
                raise ValueError(
                    f"the gap between upper and lower does not change along {along}, so that its minima are lines and "
                    f"not points: press {across} of both as profiles, or use half_space"
                )
    return Candidates(core, curvature, tuple(filter(None, map(measured_source, (upper, lower)))))


def known_of(upper: Any, lower: Any, contact: Mapping[str, object]) -> tuple[Candidates | None, ContactModel]:
    """The candidates that stand in place of both bodies, if they do, and the model by which these are pressed."""
    if not isinstance(upper, Candidates):
        return None, model_for_pair(upper, lower, contact)
    if "effective_modulus" not in contact and "model" not in contact:
        refuse_no_modulus(*upper.sources)
    model = model_of(contact)
    for name, own in (("detection", "gap-minimum"), ("curvature", upper.curvature)):
        if getattr(model, name) not in (None, own):
            raise ValueError(f"{name} must be that of the candidates, {own!r}, got {getattr(model, name)!r}")
    model = replace(model, detection="gap-minimum", curvature=upper.curvature)
    areal = isinstance(upper.core, stiction._core.ArealCandidates)
    return upper, model.for_surfaces() if areal else model.for_profiles()
