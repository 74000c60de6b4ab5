"""Section `[surfaces]` of a study with generated profiles or height maps."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Field, model_validator

from stiction._checks import Floats
from stiction._units import exact_quantity_text, quantity, short_repr
from stiction.mechanics.model import PROFILE_WIDTH
from stiction.study.member_names import REPETITION_NAMES, MemberNames
from stiction.study.values import (
    MAX_NUM_PARAMETER_VALUES,
    FractalDimensionRange,
    FractalDimensionsOrRange,
    Length,
    Lengths,
    NumGridPoints,
    SettingsSectionVariant,
    list_to_tuple_validator,
    make_key_error,
    parse_positive_length,
    to_value_array,
)
from stiction.surfaces.fractal import FractalConvention
from stiction.surfaces.profile import MAX_POINTS, MIN_POINTS, AmplitudeMeasure
from stiction.surfaces.spectrum import ROUND_OFF_FACTOR
from stiction.surfaces.surface import SurfaceAmplitudeMeasure

LengthScale = Annotated[Length, Field(description="L of Eq. 1, which sets the longest wavelength.")]
FrequencyRatio = Annotated[float, Field(gt=1, description="Ratio γ of successive frequencies in Eq. 1.")]
NumWaveDirections = Annotated[
    int, Field(ge=1, le=MAX_NUM_PARAMETER_VALUES, description="M of Eq. 1: number of directions.")
]
NumFrequencies = Annotated[
    int, Field(ge=1, le=MAX_NUM_PARAMETER_VALUES, description="n_max of Eq. 1: number of frequencies per direction.")
]
BandLimit = Annotated[
    Literal["none", "nyquist"],
    Field(description="Treatment of wavelengths below two grid points: aliased, as in the paper, or omitted."),
]
FractalDimensionConvention = Annotated[
    FractalConvention,
    Field(description="Definition of D: that of the paper, H = 4 - 2D, or the classical one, H = 2 - D."),
]
MapExtents = Annotated[
    tuple[Length, Length], list_to_tuple_validator, Field(description="Lengths of a surface along y and x.")
]
GridShape = Annotated[
    tuple[NumGridPoints, NumGridPoints], list_to_tuple_validator, Field(description="Rows and columns of a surface.")
]
AmplitudeDefinition = Annotated[
    SurfaceAmplitudeMeasure,
    Field(description="Measure of the amplitude: total height, mean (Sa) or root mean square (Sq)."),
]


# Maximum product of the numbers of directions and frequencies of generated surfaces, which limits the run time.
MAX_DIRECTIONS_TIMES_FREQUENCIES = 1_000_000


class CommonGeneratedSurfaceSettings(SettingsSectionVariant):
    """Keys of `[surfaces]` that all generated surfaces have: fractal dimension and amplitude."""

    bodies: ClassVar[str] = "generated areas"
    is_areal: ClassVar[bool] = True
    """True if the members are pairs of height maps, and False if they are pairs of profiles."""

    press: ClassVar[None] = None
    level: ClassVar[None] = None
    cut_off: ClassVar[tuple[float, ...]] = ()
    vouched: ClassVar[None] = None
    both_readings: ClassVar[None] = None
    first_scan_member_index: ClassVar[int] = 0
    scan_counts: ClassVar[tuple[int, int]] = (1, 1)
    member_names: ClassVar[MemberNames] = REPETITION_NAMES

    fractal_dimension: FractalDimensionsOrRange = Field(
        default=FractalDimensionRange(start=1.0, stop=1.7, count=50),
        description="D, as defined by `convention`; for surfaces, D of a section.",
    )
    amplitude: Lengths = Field(
        default=(quantity("0.1 um", "length"),),
        description="Amplitude to which each profile or surface is scaled; `amplitude_measure` defines it.",
    )

    @model_validator(mode="after")
    def _require_harmonics_below_limit(self) -> Self:
        num_harmonics = getattr(self, "directions", 0) * getattr(self, "frequencies", 0)
        if num_harmonics > MAX_DIRECTIONS_TIMES_FREQUENCIES:
            raise make_key_error(
                "directions",
                f"number of directions times number of frequencies must be at most {MAX_DIRECTIONS_TIMES_FREQUENCIES}, "
                f"got {num_harmonics}",
            )
        return self

    def max_wavelength(self) -> float:
        """Return the longest wavelength (µm) of the generated surfaces, which is the length scale L in Eq. 1."""
        return float(self.length_scale)  # type: ignore[attr-defined]

    def fractal_dimensions(self) -> Floats:
        """Return all fractal dimensions of the study."""
        return to_value_array(self.fractal_dimension)

    def amplitudes(self) -> Floats:
        """Return all amplitudes (µm) of the study."""
        return to_value_array(self.amplitude)

    def cell_coordinates(self) -> dict[str, Floats]:
        """Return the fractal dimensions and amplitudes (µm) of the study, each combination of which is a cell."""
        return {"fractal_dimension": self.fractal_dimensions(), "amplitude": self.amplitudes()}


class GeneratedProfileSettings(CommonGeneratedSurfaceSettings):
    """Keys of `[surfaces]` for pairs of fractal profiles from Eq. 1 of the paper (Weierstrass-Mandelbrot)."""

    place: ClassVar[str] = "fractal profiles"
    bodies: ClassVar[str] = "generated lines"
    is_areal: ClassVar[bool] = False

    kind: Literal["profile"] = Field(default="profile", description="Kind of surfaces: lines or areas.")
    amplitude_measure: AmplitudeMeasure = Field(
        default="height", description="Measure of the amplitude: total height, mean (Ra) or root mean square (Rq)."
    )
    length_scale: LengthScale = quantity("1 um", "length")
    extent: Length = Field(default=quantity("40 um", "length"), description="Length of a profile.")
    points: int = Field(
        default=150_000, ge=MIN_POINTS, le=MAX_POINTS,
        description="Number of points of a profile; the spacing is the extent divided by this number.",
    )  # fmt: skip
    gamma: FrequencyRatio = 1.5
    directions: NumWaveDirections = 40
    frequencies: NumFrequencies = 40
    convention: FractalDimensionConvention = "paper"
    band_limit: BandLimit = "none"

    @property
    def spacing(self) -> float:
        """Distance (µm) between neighbouring points of the profiles."""
        return float(self.extent) / self.points

    @property
    def nominal_area(self) -> float:
        """Nominal area (µm²) of a profile: its length times `PROFILE_WIDTH`."""
        return float(self.extent) * PROFILE_WIDTH


class GeneratedMapSettings(CommonGeneratedSurfaceSettings):
    """Keys of `[surfaces]` for all generated height maps: side lengths and shape of the grid."""

    kind: Literal["surface"] = Field(default="surface", description="Kind of surfaces: lines or areas.")
    extent: MapExtents = (quantity("10 um", "length"), quantity("10 um", "length"))
    shape: GridShape = (512, 512)

    @model_validator(mode="after")
    def _require_points_below_limit(self) -> GeneratedMapSettings:
        if self.shape[0] * self.shape[1] > MAX_POINTS:
            raise make_key_error("shape", f"must have at most {MAX_POINTS} points, got {list(self.shape)}")
        return self

    def extents(self) -> tuple[float, float]:
        """Return the side lengths (µm) of a map along y and x."""
        along_y, along_x = self.extent
        return float(along_y), float(along_x)

    @property
    def nominal_area(self) -> float:
        """Nominal area (µm²) of a map."""
        return math.prod(self.extents())

    def spacings(self) -> tuple[float, float]:
        """Return the grid spacings (µm) of a map along y and x."""
        (along_y, along_x), (rows, columns) = self.extents(), self.shape
        return along_y / rows, along_x / columns


class WeierstrassMandelbrotSettings(GeneratedMapSettings):
    """Keys of `[surfaces]` for pairs of fractal height maps from Eq. 1 of the paper (Weierstrass-Mandelbrot)."""

    place: ClassVar[str] = "Weierstrass-Mandelbrot surfaces"

    generator: Literal["weierstrass-mandelbrot"] = Field(
        default="weierstrass-mandelbrot", description="Generator: Eq. 1 of the paper over an area."
    )
    amplitude_measure: AmplitudeDefinition = "height"
    length_scale: LengthScale = quantity("1 um", "length")
    gamma: FrequencyRatio = 1.5
    directions: NumWaveDirections = 40
    frequencies: NumFrequencies = 40
    convention: FractalDimensionConvention = "paper"
    band_limit: BandLimit = "none"


def _to_fractal_dimensions(exponents: Any) -> Any:
    """Convert Hurst exponents H to fractal dimensions D = 2 - H in ascending order."""
    try:
        if isinstance(exponents, Mapping):
            limits = {"start": round(2 - exponents["stop"], 12), "stop": round(2 - exponents["start"], 12)}
            return {**exponents, **limits}
        values = exponents if isinstance(exponents, (list, tuple)) else [exponents]
        return sorted(round(2 - value, 12) for value in values)
    except (TypeError, KeyError):
        raise make_key_error(
            "hurst_exponent", f"must be numbers above 0 and at most 1, got {short_repr(exponents)}"
        ) from None


class SelfAffineSettings(GeneratedMapSettings):
    """Keys of `[surfaces]` for pairs of Gaussian height maps whose spectrum is a power law."""

    place: ClassVar[str] = "self-affine surfaces"

    generator: Literal["self-affine"] = Field(
        default="self-affine", description="Generator: Gaussian roughness with a power-law spectrum."
    )
    amplitude_measure: AmplitudeDefinition = "height"
    longest_wavelength: Length | None = Field(
        default=None, description="Roll-off wavelength of the spectrum; by default the longer side."
    )
    shortest_wavelength: Length | None = Field(
        default=None, description="Cutoff wavelength of the spectrum; by default twice the larger spacing."
    )
    convention: Literal["classical"] = Field(default="classical", description="Definition of D: H = 2 - D.")

    other_keys: ClassVar[dict[str, tuple[str, str]]] = {
        "hurst_exponent": (
            "a list or a range of numbers above 0, at most 1",
            "Hurst exponent H = 2 - D, instead of `fractal_dimension`.",
        ),
        "rms": ("a list of lengths above 0", "Sq of each surface, instead of `amplitude` and `amplitude_measure`."),
        "spacing": (
            "a length above 0 or a list of two",
            "Distance between rows and between columns, instead of `extent`.",
        ),
    }
    """Allowed values and description of each alternative key; the keys are arguments of `self_affine_surface`."""

    @model_validator(mode="before")
    @classmethod
    def _translate_alternative_keys(cls, keys: Any) -> Any:
        """Convert alternative keys, such as `hurst_exponent` or `rms`, to the standard keys of the section."""
        if not isinstance(keys, Mapping) or not cls.other_keys.keys() & keys.keys():
            return keys
        section = {key: value for key, value in keys.items() if key not in cls.other_keys}
        if "hurst_exponent" in keys:
            section["fractal_dimension"] = _to_fractal_dimensions(keys["hurst_exponent"])
        if "rms" in keys:
            rms = keys["rms"]
            section |= {"amplitude": rms if isinstance(rms, (list, tuple)) else [rms], "amplitude_measure": "Sq"}
        if "spacing" in keys:
            spacing, shape = keys["spacing"], section.get("shape", cls.model_fields["shape"].default)
            spacings = spacing if isinstance(spacing, (list, tuple)) else [spacing, spacing]
            if len(spacings) != 2 or len(shape) != 2:
                raise make_key_error("spacing", f"must be a length or a list of two lengths, got {short_repr(spacing)}")
            try:
                spacing_values = [float(parse_positive_length(text)) for text in spacings]
            except ValueError as error:
                raise make_key_error("spacing", str(error)) from None
            section["extent"] = [
                exact_quantity_text(float(f"{spacing_value * n:.12g}"), "um")
                for spacing_value, n in zip(spacing_values, shape, strict=True)
            ]
        return section

    @model_validator(mode="after")
    def _require_valid_wavelengths(self) -> SelfAffineSettings:
        longest_side, nyquist_wavelength, longest_wavelength = (
            max(self.extents()),
            2 * max(self.spacings()),
            self.max_wavelength(),
        )
        shortest_wavelength = (
            nyquist_wavelength if self.shortest_wavelength is None else float(self.shortest_wavelength)
        )
        if longest_wavelength > longest_side * ROUND_OFF_FACTOR:
            raise make_key_error(
                "longest_wavelength",
                f"must be at most the longer side ({longest_side:g} um), got {longest_wavelength:g} um",
            )
        if shortest_wavelength * ROUND_OFF_FACTOR < nyquist_wavelength:
            raise make_key_error(
                "shortest_wavelength",
                f"must be at least {nyquist_wavelength:g} um, twice the larger spacing, got {shortest_wavelength:g} um",
            )
        if not shortest_wavelength < longest_wavelength:
            raise make_key_error(
                "shortest_wavelength",
                f"must be below the longest wavelength ({longest_wavelength:g} um), got {shortest_wavelength:g} um",
            )
        return self

    def max_wavelength(self) -> float:
        """Return the longest wavelength (µm) of the generated surfaces."""
        return max(self.extents()) if self.longest_wavelength is None else float(self.longest_wavelength)


GeneratedSurfaceSettings = GeneratedProfileSettings | WeierstrassMandelbrotSettings | SelfAffineSettings
"""Section `[surfaces]` of a study of generated surfaces."""
