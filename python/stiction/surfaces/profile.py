"""A rough profile: heights on a uniform grid."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

import stiction._core
from stiction._checks import Floats, choice, float_array, number, read_only
from stiction._shown import Shown, axes_for

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

AmplitudeMeasure = Literal["height", "Ra", "Rq"]
Side = Literal["lower", "upper"]  # which of the two bodies
Along = Literal["x", "y"]  # axis that the lines of a surface run along: its rows or its columns
MOST_POINTS = 100_000_000  # largest number of points of a generated body: 0.8 GB of heights
FEWEST_POINTS = 4  # a natural cubic spline with a curvature of its own needs two interior points


@dataclass(frozen=True, eq=False, repr=False)
class Profile(Shown):
    """Heights of a surface along a line, on a uniform grid that starts at x = 0.

    Parameters
    ----------
    heights : (n,) array_like of float, µm
        At least 4 finite heights; copied, and read-only afterwards.
    spacing : float, µm
        Distance between neighbouring points, above 0.
    history : tuple of str
        Where the heights come from and what was done to them, a short sentence for each step.
    missing : (n,) array_like of bool, optional
        Where nothing was measured, so that nothing touches there; heights there only bridge the holes.

    Raises
    ------
    ValueError
        If heights are not a one-dimensional array of at least 4 finite numbers, or the spacing is not above 0, or the
        history is not a tuple of strings, or all points are missing.

    Examples
    --------
    >>> from stiction import Profile
    >>> profile = Profile([0.0, 0.1, 0.0, -0.1, 0.0], spacing=0.5)
    >>> profile.extent
    2.5
    >>> profile.with_amplitude(1.0).heights
    array([ 0. ,  0.5,  0. , -0.5,  0. ])
    """

    heights: Floats = field(metadata={"unit": "µm"})
    spacing: float = field(kw_only=True, metadata={"unit": "µm"})
    history: tuple[str, ...] = field(default=(), kw_only=True)
    missing: NDArray[np.bool_] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        heights = float_array("heights", self.heights, ndim=1)
        if heights.size < FEWEST_POINTS:
            raise ValueError(f"heights must have at least {FEWEST_POINTS} points, got {heights.size}")
        if heights.flags.writeable or not heights.flags.owndata:  # somebody else may still change it
            heights = read_only(heights.copy())
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "spacing", number("spacing", self.spacing, unit="µm", above=0))
        object.__setattr__(self, "history", steps("history", self.history))
        object.__setattr__(self, "missing", mask_of(self.missing, heights.shape))

    def __reduce__(self) -> tuple[Any, ...]:
        # Read-only on the other side as well.
        return partial(Profile, spacing=self.spacing, history=self.history, missing=self.missing), (self.heights,)

    def __len__(self) -> int:
        """Return the number of points."""
        return self.heights.size

    @property
    def x(self) -> Floats:
        """(n,) positions j Δx of the points, µm."""
        return np.arange(self.heights.size, dtype=np.float64) * self.spacing

    @property
    def extent(self) -> float:
        """Points times spacing, µm."""
        return self.heights.size * self.spacing

    @property
    def is_flat(self) -> bool:
        """Whether all heights are equal: a flat body, which has no amplitude."""
        return bool((self.heights == self.heights[0]).all())

    def with_amplitude(self, amplitude: float, measure: AmplitudeMeasure = "height") -> Profile:
        """The same shape about a mean of zero, scaled to an amplitude.

        Parameters
        ----------
        amplitude : float, µm
            The value that the measure shall have, above 0.
        measure : {"height", "Ra", "Rq"}
            Highest minus lowest point, mean absolute deviation, or root-mean-square deviation from the mean.

        Raises
        ------
        ValueError
            If the amplitude is not above 0, the measure is unknown, or the profile is flat.
        """
        scaled = scaled_profile(self.heights, self.spacing, amplitude, measure, np.empty_like(self.heights))
        object.__setattr__(scaled, "history", (*self.history, f"scaled to {measure} {amplitude:g} µm"))
        object.__setattr__(scaled, "missing", self.missing)
        return scaled

    def __repr__(self) -> str:
        """Show its size, its roughness and where it is from."""
        from stiction.surfaces.foreign import words_of

        return words_of(type(self).__name__, self.heights, (self.spacing,), self.history)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw the heights over x.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            New ones by default, which are returned.
        """
        from stiction._drawing import draw_profile

        return draw_profile(axes_for(ax), self.x, self.heights)

    @classmethod
    def from_(cls, other: Any, *, unit: str | None = None) -> Profile:
        """A profile from an object of another library, as it is: its heights, its spacing and its unit.

        Parameters
        ----------
        other : object
            A line scan of SurfaceTopography, or an xarray.DataArray over x with units.
        unit : str, optional
            Of all lengths, where the object says none.

        Raises
        ------
        ValueError
            If it is none of these, is no profile, has no unit, or points are missing.

        Examples
        --------
        >>> from stiction import Profile
        >>> profile = Profile([0.0, 1.0, 0.0, 1.0], spacing=0.5)
        >>> Profile.from_(profile.to_xarray()).spacing
        0.5
        """
        from stiction.surfaces.foreign import taken_from

        taken = taken_from("other", other, unit=unit)
        if taken.heights.ndim != 1:
            raise ValueError("other must be a profile, got a surface; see Surface.from_")
        return cls(taken.heights, spacing=taken.spacing[0], history=taken.history, missing=taken.missing)

    def to_xarray(self) -> xarray.DataArray:
        """Heights with their coordinates, units and history as an xarray.DataArray; `from_` takes it back."""
        from stiction.surfaces.foreign import data_array_of

        return data_array_of(self.heights, self.history, x=self.x)


def steps(name: str, value: Any) -> tuple[str, ...]:
    """A tuple of strings."""
    if not isinstance(value, tuple) or not all(isinstance(step, str) for step in value):
        raise ValueError(f"{name} must be a tuple of strings, got {value!r}")
    return value


def mask_of(value: Any, shape: tuple[int, ...]) -> NDArray[np.bool_] | None:
    """A mask of missing points, read-only; None where no point is missing."""
    if value is None:
        return None
    mask = np.array(value)
    if mask.dtype != np.bool_ or mask.shape != shape or mask.all():
        raise ValueError(f"missing must be a mask of shape {shape} that leaves points, got {mask.dtype} {mask.shape}")
    return read_only(mask) if mask.any() else None


def part(mask: NDArray[np.bool_] | None, index: Any) -> NDArray[np.bool_] | None:
    """What of a mask lies at an index."""
    return None if mask is None else mask[index]


def missing_of(upper: Any, lower: Any) -> NDArray[np.bool_] | None:
    """Where one of two bodies on a grid was not measured; None where both are whole."""
    masks = [body.missing for body in (upper, lower) if body.missing is not None]
    return np.logical_or.reduce(masks) if masks else None


def refuse_missing(body: Any, what: str) -> None:
    """Refuse a scan with holes for what takes whole ones."""
    if body.missing is not None:
        raise ValueError(
            f"{what} takes whole scans, and {int(body.missing.sum())} points of one are masked: press it by the "
            "half-space as it is, crop it, or interpolate"
        )


def scaled_profile(
    heights: Floats, spacing: float, amplitude: float, measure: AmplitudeMeasure, scaled: Floats
) -> Profile:
    """`Profile(heights, spacing=spacing).with_amplitude(amplitude, measure)` in the memory of `scaled`.

    New memory costs more than the scaling itself; whoever scales many profiles one after the other gives the same
    again, and the profile before is then gone.
    """
    choice("measure", measure, AmplitudeMeasure)
    amplitude = number("amplitude", amplitude, unit="µm", above=0)
    if not stiction._core.scale_to_amplitude(heights, amplitude, measure, scaled):
        raise ValueError("a flat profile has no amplitude to scale")
    profile = object.__new__(Profile)
    object.__setattr__(profile, "heights", read_only(scaled[:]))
    object.__setattr__(profile, "spacing", spacing)
    return profile
