"""Height maps: rough surfaces as heights on a uniform grid over an area."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal, TypeVar

import numpy as np

import stiction._core as _core
from stiction._checks import Floats, check_choice, float_array, validate_number, validate_whole_number
from stiction._units import short_repr
from stiction.surfaces.measured.raw import LENGTH_UNITS
from stiction.surfaces.profile import MAX_POINTS, Body, Profile, select_from_mask

AnyBody = TypeVar("AnyBody", bound="Profile | Surface")
SurfaceAmplitudeMeasure = Literal["height", "Sa", "Sq"]
BodyLike = Any

# Names of amplitude parameters in the C++ core, which treats the heights of a map like those of a profile.
_CPP_MEASURE_NAMES = {"height": "height", "Sa": "Ra", "Sq": "Rq"}
# Minimum height range (µm), and reciprocal of the maximum. Fourth powers of heights then stay within double range.
_MIN_BODY_HEIGHT_RANGE = 1e-50


@dataclass(frozen=True, eq=False, repr=False)
class Surface(Body):
    """Height map: heights of a surface on a uniform grid that starts at x = y = 0.

    Columns are points along x, and rows are points along y.

    Parameters
    ----------
    heights : (rows, columns) array_like of float, µm
        At least 2 by 2 finite heights; copied, and read-only afterwards.
    spacing : (float, float), µm
        Distances between neighbouring rows and between neighbouring columns (Δy, Δx), above 0; one number for both.
    history : tuple of str
        Origin of the heights and the processing steps, one short phrase each.
    missing : (rows, columns) array_like of bool, optional
        Mask of points that were not measured. They make no contact, and their heights are interpolated.

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

    _ndim = 2
    spacing: tuple[float, float] = field(kw_only=True, metadata={"unit": "µm"})

    def __post_init__(self) -> None:
        heights = float_array("heights", self.heights, ndim=2)
        if min(heights.shape) < 2:
            raise ValueError(f"heights must have at least 2 rows and 2 columns, got shape {heights.shape}")
        self._check_and_store(heights, parse_lengths("spacing", self.spacing))

    @property
    def x(self) -> Floats:
        """Positions (µm) of the columns along x."""
        return np.arange(self.heights.shape[1], dtype=np.float64) * self.spacing[1]

    @property
    def y(self) -> Floats:
        """Positions (µm) of the rows along y."""
        return np.arange(self.heights.shape[0], dtype=np.float64) * self.spacing[0]

    @property
    def extent(self) -> tuple[float, float]:
        """Side lengths (µm) of the height map along y and along x: numbers of points times spacings."""
        rows, columns = self.heights.shape
        return rows * self.spacing[0], columns * self.spacing[1]

    def row(self, index: int) -> Profile:
        """Return one row of the height map as a profile along x."""
        index = validate_whole_number("index", index, minimum=0, maximum=self.heights.shape[0] - 1)
        return self._extract_profile(index, 1, f"row {index}")

    def column(self, index: int) -> Profile:
        """Return one column of the height map as a profile along y."""
        index = validate_whole_number("index", index, minimum=0, maximum=self.heights.shape[1] - 1)
        return self._extract_profile((slice(None), index), 0, f"column {index}")

    def _extract_profile(self, index: Any, axis: int, step: str) -> Profile:
        mask = select_from_mask(self.missing, index)
        # A line without any measured point consists of interpolated heights, which then count as measured.
        mask = None if mask is None or mask.all() else mask
        return Profile(self.heights[index], spacing=self.spacing[axis], history=(*self.history, step), missing=mask)

    def with_amplitude(self, amplitude: float, measure: SurfaceAmplitudeMeasure = "height") -> Surface:
        """Return a copy of the height map, scaled to zero mean and a given total height, Sa or Sq (µm).

        Parameters
        ----------
        amplitude : float, µm
            Value of the measure after scaling, above 0.
        measure : {"height", "Sa", "Sq"}
            Highest minus lowest point, mean absolute deviation, or root-mean-square deviation from the mean.
        """
        check_choice("measure", measure, SurfaceAmplitudeMeasure)
        amplitude = validate_number("amplitude", amplitude, unit="µm", above=0)
        scaled_heights = np.empty(self.heights.size)
        if not _core.scale_to_amplitude(self.heights.ravel(), amplitude, _CPP_MEASURE_NAMES[measure], scaled_heights):
            raise ValueError("surface must not be flat, because a flat surface cannot be scaled to an amplitude")
        return self.changed(scaled_heights.reshape(self.heights.shape), f"scaled to {measure} {amplitude:g} µm")


def parse_lengths(name: str, value: Any) -> tuple[float, float]:
    """Parse positive lengths along y and x, given as a pair or as a single number for both axes."""
    lengths = value if isinstance(value, (tuple, list)) or np.ndim(value) > 0 else (value, value)
    if len(lengths) != 2:
        raise ValueError(f"{name} must be a number or a pair (y, x), got {short_repr(value)}")
    along_y, along_x = (validate_number(name, length, unit="µm", above=0) for length in lengths)
    return along_y, along_x


def as_body(name: str, given: Any, *kinds: type[Body], spacing: Any = None, unit: str = "um") -> Any:
    """Convert an array of heights to a profile or a height map.

    Bodies are returned unchanged.

    Parameters
    ----------
    name : str
        Name of the argument, for messages.
    given : Profile, Surface or array_like
    kinds : type
        `Profile`, `Surface`, or by default both.
    spacing : float (µm), text with a unit, or a pair (y, x) of either
        Distance between the points of an array; required for arrays.
    unit : str
        Unit of the heights of an array.

    Raises
    ------
    ValueError
        If `given` has another type, or is an array without a spacing.
    """
    allowed_kinds = kinds or (Profile, Surface)
    kind_text = " or a ".join(kind.__name__ for kind in allowed_kinds)
    if isinstance(given, allowed_kinds):
        if spacing is not None:
            raise ValueError(
                f"spacing must be omitted, because {name} is a {type(given).__name__} with its own spacing"
            )
        return given
    is_array = isinstance(given, (np.ndarray, list, tuple))
    if not is_array or spacing is None:
        hint = "; make one by " + " or ".join(f"{kind.__name__}(z, spacing=...)" for kind in allowed_kinds)
        raise ValueError(f"{name} must be a {kind_text}, got {type(given).__name__}{hint if is_array else ''}")
    if not isinstance(unit, str) or unit not in LENGTH_UNITS:
        raise ValueError(f"unit must be one unit of length for arrays, such as um or nm, got {short_repr(unit)}")
    heights = float_array(name, given) * float(LENGTH_UNITS[unit])
    for kind in allowed_kinds:
        if kind._ndim == heights.ndim:
            return kind(heights, spacing=spacing, history=("given as an array",))
    raise ValueError(f"{name} must be a {kind_text}, got an array of shape {heights.shape}")


def as_bodies(upper: Any, lower: Any, *, spacing: Any = None, unit: str = "um") -> tuple[Any, Any]:
    """Convert two arrays of heights to two profiles or two height maps with `as_body`.

    Bodies are returned unchanged. Spacing and unit apply only to arrays.
    """
    if spacing is not None and isinstance(upper, Body) and isinstance(lower, Body):
        raise ValueError("spacing must be omitted, because upper and lower have their own spacings")
    upper, lower = (
        as_body(name, given, spacing=None if isinstance(given, Body) else spacing, unit=unit)
        for name, given in (("upper", upper), ("lower", lower))
    )
    return upper, lower


def parse_shape(shape: Any, *, min_count: int) -> tuple[int, int]:
    """Check that a shape has at least `min_count` rows and columns, and at most MAX_POINTS points.

    Returns the shape.
    """
    if not isinstance(shape, (tuple, list)) or len(shape) != 2:
        raise ValueError(f"shape must be (rows, columns), got {short_repr(shape)}")
    rows, columns = (validate_whole_number("shape", size, minimum=min_count, maximum=MAX_POINTS) for size in shape)
    if rows * columns > MAX_POINTS:
        raise ValueError(f"shape must have at most {MAX_POINTS} points, got {short_repr(shape)}")
    return rows, columns


def reject_flat_body(body: Profile | Surface) -> None:
    """Raise a `ValueError` if a body is flat, or if its height range is too small or too large to compute with."""
    kind_name, height = type(body).__name__.lower(), float(np.ptp(body.heights))
    if height == 0:
        raise ValueError(f"{kind_name} must not be flat, because a flat {kind_name} has no roughness")
    if not _MIN_BODY_HEIGHT_RANGE < height < 1 / _MIN_BODY_HEIGHT_RANGE:
        raise ValueError(
            f"the height range of the {kind_name} must be between {_MIN_BODY_HEIGHT_RANGE:g} and "
            f"{1 / _MIN_BODY_HEIGHT_RANGE:g} µm, got {height:g}"
        )
