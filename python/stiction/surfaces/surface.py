"""A rough surface: heights on a uniform grid over an area."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

import stiction._core as _core
from stiction._checks import Floats, choice, float_array, number, read_only, whole_number
from stiction._shown import Shown, axes_for
from stiction.surfaces.profile import MOST_POINTS, Profile, mask_of, part, steps

if TYPE_CHECKING:
    import xarray
    from matplotlib.axes import Axes

SurfaceAmplitude = Literal["height", "Sa", "Sq"]

# Each is that of all points, whatever their arrangement, and has the name of the profile's in the core.
_OF_POINTS = {"height": "height", "Sa": "Ra", "Sq": "Rq"}


@dataclass(frozen=True, eq=False, repr=False)
class Surface(Shown):
    """Heights of a surface on a uniform grid that starts at x = y = 0: x along the columns, y along the rows.

    Parameters
    ----------
    heights : (rows, columns) array_like of float, µm
        At least 2 by 2 finite heights; copied, and read-only afterwards.
    spacing : (float, float), µm
        Distances between neighbouring rows and between neighbouring columns (Δy, Δx), above 0; one number for both.
    history : tuple of str
        Where the heights come from and what was done to them, a short sentence for each step.
    missing : (rows, columns) array_like of bool, optional
        Where nothing was measured, so that nothing touches there; heights there only bridge the holes.

    Raises
    ------
    ValueError
        If heights are not such an array, or a spacing is not above 0, or the history is not a tuple of strings, or all
        points are missing.

    Examples
    --------
    >>> from stiction import Surface
    >>> surface = Surface([[0.0, 1.0, 0.0, 1.0], [1.0, 2.0, 1.0, 2.0]], spacing=(0.5, 0.25))
    >>> surface.extent
    (1.0, 1.0)
    >>> surface.row(1).heights
    array([1., 2., 1., 2.])
    >>> surface.with_amplitude(4.0).heights[0]
    array([-2.,  0., -2.,  0.])
    """

    heights: Floats = field(metadata={"unit": "µm"})
    spacing: tuple[float, float] = field(kw_only=True, metadata={"unit": "µm"})
    history: tuple[str, ...] = field(default=(), kw_only=True)
    missing: NDArray[np.bool_] | None = field(default=None, kw_only=True)

    def __post_init__(self) -> None:
        heights = float_array("heights", self.heights, ndim=2)
        if min(heights.shape) < 2:
            raise ValueError(f"heights must have at least 2 rows and 2 columns, got shape {heights.shape}")
        if heights.flags.writeable or not heights.flags.owndata:  # somebody else may still change it
            heights = read_only(heights.copy())
        object.__setattr__(self, "heights", heights)
        object.__setattr__(self, "spacing", lengths("spacing", self.spacing))
        object.__setattr__(self, "history", steps("history", self.history))
        object.__setattr__(self, "missing", mask_of(self.missing, heights.shape))

    def __reduce__(self) -> tuple[Any, ...]:
        # Read-only on the other side as well.
        return partial(Surface, spacing=self.spacing, history=self.history, missing=self.missing), (self.heights,)

    @property
    def x(self) -> Floats:
        """(columns,) positions of the columns, µm."""
        return np.arange(self.heights.shape[1], dtype=np.float64) * self.spacing[1]

    @property
    def y(self) -> Floats:
        """(rows,) positions of the rows, µm."""
        return np.arange(self.heights.shape[0], dtype=np.float64) * self.spacing[0]

    @property
    def extent(self) -> tuple[float, float]:
        """Points times spacing along y and x, µm."""
        rows, columns = self.heights.shape
        return rows * self.spacing[0], columns * self.spacing[1]

    def row(self, index: int) -> Profile:
        """Return one row as a profile along x."""
        index = whole_number("index", index, least=0, most=self.heights.shape[0] - 1)
        return self._line(index, 1, f"row {index}")

    def column(self, index: int) -> Profile:
        """Return one column as a profile along y."""
        index = whole_number("index", index, least=0, most=self.heights.shape[1] - 1)
        return self._line((slice(None), index), 0, f"column {index}")

    def _line(self, index: Any, axis: int, step: str) -> Profile:
        mask = part(self.missing, index)
        mask = None if mask is None or mask.all() else mask  # of a line without any point only the bridge is left
        return Profile(self.heights[index], spacing=self.spacing[axis], history=(*self.history, step), missing=mask)

    @property
    def is_flat(self) -> bool:
        """Whether all heights are equal: a flat body, which has no amplitude."""
        return bool((self.heights == self.heights[0, 0]).all())

    def with_amplitude(self, amplitude: float, measure: SurfaceAmplitude = "height") -> Surface:
        """The same shape about a mean of zero, scaled to an amplitude.

        Parameters
        ----------
        amplitude : float, µm
            The value that the measure shall have, above 0.
        measure : {"height", "Sa", "Sq"}
            Highest minus lowest point, mean absolute deviation, or root-mean-square deviation from the mean.

        Raises
        ------
        ValueError
            If the amplitude is not above 0, the measure is unknown, or the surface is flat.
        """
        choice("measure", measure, SurfaceAmplitude)
        amplitude = number("amplitude", amplitude, unit="µm", above=0)
        scaled = np.empty(self.heights.size)
        if not _core.scale_to_amplitude(self.heights.ravel(), amplitude, _OF_POINTS[measure], scaled):
            raise ValueError("a flat surface has no amplitude to scale")
        history = (*self.history, f"scaled to {measure} {amplitude:g} µm")
        return Surface(scaled.reshape(self.heights.shape), spacing=self.spacing, history=history, missing=self.missing)

    def __repr__(self) -> str:
        """Show its size, its roughness and where it is from."""
        from stiction.surfaces.foreign import words_of

        return words_of(type(self).__name__, self.heights, self.spacing, self.history)

    def plot(self, ax: Axes | None = None) -> Axes:
        """Draw a map of the heights.

        Parameters
        ----------
        ax : matplotlib.axes.Axes, optional
            New ones by default, which are returned.
        """
        from stiction._drawing import draw_surface

        return draw_surface(axes_for(ax), self.heights, self.spacing)

    @classmethod
    def from_(cls, other: Any, *, unit: str | None = None) -> Surface:
        """A surface from an object of another library, as it is: its heights, its spacing and its unit.

        Parameters
        ----------
        other : object
            A topography of SurfaceTopography, a Surface of surfalize, or an xarray.DataArray over y and x with units.
        unit : str, optional
            Of all lengths, where the object says none.

        Raises
        ------
        ValueError
            If it is none of these, is no surface, has no unit, or points are missing.

        Examples
        --------
        >>> from stiction import Surface
        >>> surface = Surface([[0.0, 1.0], [2.0, 3.0]], spacing=0.5)
        >>> Surface.from_(surface.to_xarray()).spacing
        (0.5, 0.5)
        """
        from stiction.surfaces.foreign import taken_from

        taken = taken_from("other", other, unit=unit)
        if taken.heights.ndim != 2:
            raise ValueError("other must be a surface, got a profile; see Profile.from_")
        spacing = lengths("spacing", taken.spacing)
        return cls(taken.heights, spacing=spacing, history=taken.history, missing=taken.missing)

    def to_xarray(self) -> xarray.DataArray:
        """Heights with their coordinates, units and history as an xarray.DataArray; `from_` takes it back."""
        from stiction.surfaces.foreign import data_array_of

        return data_array_of(self.heights, self.history, y=self.y, x=self.x)


def lengths(name: str, value: Any) -> tuple[float, float]:
    """A length for y and one for x, both above 0, from a pair or from one number for both."""
    pair = value if isinstance(value, (tuple, list)) or np.ndim(value) > 0 else (value, value)
    if len(pair) != 2:
        raise ValueError(f"{name} must be a number or a pair (y, x), got {value!r}")
    along_y, along_x = (number(name, item, unit="µm", above=0) for item in pair)
    return along_y, along_x


def rows_and_columns(shape: Any, *, least: int) -> tuple[int, int]:
    """The shape of a surface, so many rows and columns at least and no more points than one may have."""
    if not isinstance(shape, (tuple, list)) or len(shape) != 2:
        raise ValueError(f"shape must be (rows, columns), got {shape!r}")
    rows, columns = (whole_number("shape", size, least=least, most=MOST_POINTS) for size in shape)
    if rows * columns > MOST_POINTS:
        raise ValueError(f"shape must hold at most {MOST_POINTS} points, got {shape!r}")
    return rows, columns


def refuse_flat(body: Profile | Surface) -> None:
    """Refuse a body whose heights are all equal, or so small or large that their products leave the range."""
    name, height = type(body).__name__.lower(), float(np.ptp(body.heights))
    if height == 0:
        raise ValueError(f"a flat {name} has no roughness")
    if not _LEAST_HEIGHT < height < 1 / _LEAST_HEIGHT:
        raise ValueError(
            f"the height of the {name} must be above {_LEAST_HEIGHT:g} and below {1 / _LEAST_HEIGHT:g} µm, "
            f"got {height:g}"
        )


_LEAST_HEIGHT = 1e-50  # µm. Products of moments go as the fourth power of heights, which must stay in range
