"""Profiles as heights on a uniform grid, and the base class of profiles and height maps."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Self

import numpy as np
from numpy.typing import NDArray

import stiction._core
from stiction._caching import cached_property
from stiction._checks import Floats, check_choice, float_array, make_read_only, validate_number
from stiction._drawing import draw_profile, draw_surface
from stiction._repr import PlotReprMixin, axes_or_new_axes
from stiction._units import short_repr
from stiction.surfaces.height_step import find_height_step
from stiction.surfaces.interchange import describe_body, extract_heights, to_data_array

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

AmplitudeMeasure = Literal["height", "Ra", "Rq"]
Side = Literal["lower", "upper"]
LineOrientation = Literal["x", "y"]  # rows, columns
# Maximum number of points of a body: the heights of a generated body of this size take 0.8 GB of memory.
MAX_POINTS = 100_000_000
MIN_ACCEPTED_SPACING, MAX_ACCEPTED_SPACING = 1e-30, 1e30  # µm, powers do not overflow
# Minimum number of points of a body: a natural cubic spline needs two interior points.
MIN_POINTS = 4


@dataclass(frozen=True, eq=False, repr=False)
class Body(PlotReprMixin):
    """Base class of profiles and height maps: heights on a uniform grid, with a history of processing steps."""

    _ndim: ClassVar[int]
    x: ClassVar[property]

    heights: Floats = field(metadata={"unit": "µm"})
    spacing: Any = field(kw_only=True, metadata={"unit": "µm"})
    history: tuple[str, ...] = field(default=(), kw_only=True)
    missing: NDArray[np.bool_] | None = field(default=None, kw_only=True)

    def _check_and_store(self, heights: Floats, spacing: Any) -> None:
        """Check and store the heights, the spacing, the history and the mask of missing points of a body."""
        if not MIN_ACCEPTED_SPACING <= np.min(spacing) <= np.max(spacing) <= MAX_ACCEPTED_SPACING:
            allowed = f"from {MIN_ACCEPTED_SPACING:g} to {MAX_ACCEPTED_SPACING:g} µm"
            raise ValueError(f"spacing must be {allowed}, got {short_repr(spacing)}")
        # The caller may modify the array of heights, so it is copied.
        if heights.flags.writeable or not heights.flags.owndata:
            heights = make_read_only(heights.copy())
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "spacing", spacing)
        if not isinstance(self.history, tuple) or not all(isinstance(step, str) for step in self.history):
            raise ValueError(f"history must be a tuple of strings, got {short_repr(self.history)}")
        if self.missing is not None:
            try:
                missing = np.array(self.missing)
            except ValueError:
                # NumPy rejects a nested list whose rows have different lengths.
                missing = np.array(None)
            if missing.dtype != np.bool_ or missing.shape != heights.shape or missing.all():
                mask_text = "True at every point" if missing.all() else f"{missing.dtype} {missing.shape}"
                allowed = f"a boolean array of shape {heights.shape} that is False at one point or more"
                raise ValueError(f"the mask `missing` must be {allowed}, got {mask_text}")
            object.__setattr__(self, "missing", make_read_only(missing) if missing.any() else None)

    def __reduce__(self) -> tuple[Any, ...]:
        # Unpickling calls the constructor of a body, which makes the heights read-only again.
        return partial(type(self), spacing=self.spacing, history=self.history, missing=self.missing), (self.heights,)

    @property
    def spacings(self) -> tuple[float, ...]:
        """Distances (µm) between neighbouring points along x or, for surfaces, along y and x."""
        return self.spacing if isinstance(self.spacing, tuple) else (self.spacing,)

    @property
    def is_flat(self) -> bool:
        """True if all heights of the body are equal."""
        return bool((self.heights == self.heights.flat[0]).all())

    @property
    def heights_with_nan(self) -> Floats:
        """Heights (µm) of the body, with NaN at missing points."""
        return self.heights if self.missing is None else np.where(self.missing, np.nan, self.heights)

    @cached_property
    def height_step(self) -> float:
        """Step (µm) between the discrete values to which the measured heights were rounded, or 0 without rounding.

        See `find_height_step`.
        """
        return find_height_step(self.heights_with_nan)

    def changed(self, heights: Floats, step: str, **others: Any) -> Self:
        """Return a copy of the body with new heights and with an additional history entry."""
        return replace(self, heights=heights, history=(*self.history, step), **others)

    def __repr__(self) -> str:
        """Return a one-line description of the body: size, spacing, roughness and history."""
        return describe_body(type(self).__name__, self.heights, self.spacings, self.history)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the heights of a profile against x, or the heights of a height map as an image.

        Draws into the given axes, or into new ones, and returns them.
        """
        if self.heights.ndim == 2:
            return draw_surface(axes_or_new_axes(ax), self.heights, self.spacing)
        return draw_profile(axes_or_new_axes(ax), self.x, self.heights)

    @classmethod
    def from_(cls, other: Any, *, unit: str | None = None) -> Self:
        """Create a profile or a height map from an object of another library with heights, spacing and unit.

        Parameters
        ----------
        other : object
            A line scan or a topography of SurfaceTopography, a Surface of surfalize, or an xarray.DataArray over x, or
            over y and x, with units.
        unit : str, optional
            Unit of all lengths, if the object has no unit.

        Raises
        ------
        ValueError
            If the type is not supported, if the number of dimensions is wrong, if there is no unit, or if points are
            missing.

        Examples
        --------
        >>> from stiction import Profile
        >>> profile = Profile([0.0, 1.0, 0.0, 1.0], spacing=0.5)
        >>> Profile.from_(profile.to_xarray()).spacing
        0.5
        """
        extracted = extract_heights("other", other, unit=unit)
        expected_kind, actual_kind = (("profile", "surface")[ndim - 1] for ndim in (cls._ndim, extracted.heights.ndim))
        if actual_kind != expected_kind:
            raise ValueError(
                f"`other` must be a {expected_kind}, got a {actual_kind}; use {actual_kind.capitalize()}.from_(...)"
            )
        spacing = extracted.spacing[0] if cls._ndim == 1 else extracted.spacing
        return cls(extracted.heights, spacing=spacing, history=extracted.history, missing=extracted.missing)

    def to_xarray(self) -> xarray.DataArray:
        """Convert the body to an xarray.DataArray with coordinates, units and history.

        This is the inverse of `from_`.
        """
        positions = {axis: getattr(self, axis) for axis in "yx"[2 - self.heights.ndim :]}
        return to_data_array(self.heights, self.history, **positions)


@dataclass(frozen=True, eq=False, repr=False)
class Profile(Body):
    """Heights of a surface along a line, on a uniform grid that starts at x = 0.

    Parameters
    ----------
    heights : (n,) array_like of float, µm
        At least 4 finite heights; copied, and read-only afterwards.
    spacing : float, µm
        Distance between neighbouring points, above 0.
    history : tuple of str
        Origin of the heights and the processing steps, one short phrase each.
    missing : (n,) array_like of bool, optional
        Mask of points that were not measured. They make no contact, and their heights are interpolated.

    Examples
    --------
    >>> from stiction import Profile
    >>> profile = Profile([0.0, 0.1, 0.0, -0.1, 0.0], spacing=0.5)
    >>> profile.extent
    2.5
    >>> profile.with_amplitude(1.0).heights
    array([ 0. ,  0.5,  0. , -0.5,  0. ])
    """

    _ndim = 1
    spacing: float = field(kw_only=True, metadata={"unit": "µm"})

    def __post_init__(self) -> None:
        heights = float_array("heights", self.heights, ndim=1)
        if heights.size < MIN_POINTS:
            raise ValueError(f"heights must have at least {MIN_POINTS} points, got {heights.size}")
        self._check_and_store(heights, validate_number("spacing", self.spacing, unit="µm", above=0))

    def __len__(self) -> int:
        """Return the number of points of the profile."""
        return self.heights.size

    @property
    def x(self) -> Floats:
        """Positions (µm) of the points of the profile along x; point j lies at j Δx."""
        return np.arange(self.heights.size, dtype=np.float64) * self.spacing

    @property
    def extent(self) -> float:
        """Length (µm) of the profile: number of points times spacing."""
        return self.heights.size * self.spacing

    def with_amplitude(self, amplitude: float, measure: AmplitudeMeasure = "height") -> Profile:
        """Return a copy of the profile, scaled to zero mean and a given total height, Ra or Rq (µm).

        Parameters
        ----------
        amplitude : float, µm
            Value of the measure after scaling, above 0.
        measure : {"height", "Ra", "Rq"}
            Highest minus lowest point, mean absolute deviation, or root-mean-square deviation from the mean.
        """
        scaled_profile = scale_profile(self.heights, self.spacing, amplitude, measure, np.empty_like(self.heights))
        object.__setattr__(scaled_profile, "history", (*self.history, f"scaled to {measure} {amplitude:g} µm"))
        object.__setattr__(scaled_profile, "missing", self.missing)
        return scaled_profile


def select_from_mask(mask: NDArray[np.bool_] | None, index: Any) -> NDArray[np.bool_] | None:
    """Select elements of a mask of missing points by an index or slice; return None if there is no mask."""
    return None if mask is None else mask[index]


def combine_missing_masks(upper: Any, lower: Any) -> NDArray[np.bool_] | None:
    """Return a mask of the points that are missing in at least one of two bodies, or None if no point is missing.

    Raises a `ValueError` if no point is measured in both bodies.
    """
    masks = [body.missing for body in (upper, lower) if body.missing is not None]
    missing: NDArray[np.bool_] | None = np.logical_or.reduce(masks) if masks else None
    if missing is not None and missing.all():
        raise ValueError("the upper and the lower body must share at least one measured position, got none")
    return missing


def reject_missing_points(body: Any, operation: str) -> None:
    """Raise a `ValueError` if a body has missing points; the message names the operation that needs all heights."""
    if body.missing is not None:
        raise ValueError(
            f"{operation} requires complete scans, got {int(body.missing.sum())} missing points; crop the scan, "
            "interpolate, or use the half-space solver, which accepts missing points"
        )


def scale_profile(
    heights: Floats, spacing: float, amplitude: float, measure: AmplitudeMeasure, scaled_heights: Floats
) -> Profile:
    """Scale the heights of a profile such that a roughness measure, such as "Rq", equals `amplitude` (µm).

    The array `scaled_heights` stores the scaled heights.
    """
    check_choice("measure", measure, AmplitudeMeasure)
    amplitude = validate_number("amplitude", amplitude, unit="µm", above=0)
    if not stiction._core.scale_to_amplitude(heights, amplitude, measure, scaled_heights):
        raise ValueError("profile must not be flat, because a flat profile cannot be scaled to an amplitude")
    profile = object.__new__(Profile)
    object.__setattr__(profile, "heights", make_read_only(scaled_heights[:]))
    object.__setattr__(profile, "spacing", spacing)
    return profile
