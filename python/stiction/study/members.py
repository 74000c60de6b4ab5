"""Members of a study: pairs of generated or measured bodies.

A member is a generated pair, two lines or two maps at a relative position, or a pair of surrogates. The study and the
number of the member determine the member completely.
"""

from __future__ import annotations

import contextlib
import functools
import math
import threading
from collections.abc import Iterator
from typing import Any

import numpy as np

from stiction._caching import cached_property
from stiction._checks import Floats, check_instance
from stiction.study.generated_surfaces import SelfAffineSettings
from stiction.study.measured_surfaces import MeasuredSurfaceSettings
from stiction.study.member_sources import BodyAttributes, EnsembleMember, MemberSource
from stiction.study.study import Study
from stiction.surfaces import fractal
from stiction.surfaces.missing_data import compute_scattered_missing_fraction
from stiction.surfaces.pairing import SIDES
from stiction.surfaces.profile import Profile, Side, combine_missing_masks, scale_profile
from stiction.surfaces.scan_defects import (
    MIN_LAY_SLOPE_RATIO,
    compute_lay_ratio,
    compute_mean_square_slope,
    estimate_roughness_drift,
)
from stiction.surfaces.self_affine import self_affine_surface
from stiction.surfaces.surface import Surface

MAX_BATCH_BYTES = 64_000_000  # bytes
MAX_CACHED_PAIRS = 16
NUM_AVERAGED_MEMBERS = 16
# Number of points assumed for a profile (False) or a map (True) if its scan file is missing.
TYPICAL_SCAN_POINTS = {False: 4000, True: 400**2}

# ---- Generated bodies ------------------------------------------------------------------------------------------------


def generate_phases(study: Study, repetition: int, side: Side) -> Floats:
    """Generate random phases (rad) for the fractal surface of one body, with shape (directions, frequencies).

    The surface is a Weierstrass-Mandelbrot surface (Eq. 1 of the paper).
    """
    surfaces: Any = study.surfaces
    return fractal.random_phases(
        study.ensemble.seed, repetition=repetition, side=side, directions=surfaces.directions,
        frequencies=surfaces.frequencies,
    )  # fmt: skip


def _get_weierstrass_arguments(surfaces: Any) -> dict[str, Any]:
    """Return the parameters of Weierstrass-Mandelbrot surfaces: length scale, γ, convention for D, band limit.

    The surfaces, profiles or height maps, are defined by Eq. 1 of the paper.
    """
    return {
        "length_scale": float(surfaces.length_scale), "gamma": surfaces.gamma, "convention": surfaces.convention,
        "band_limit": None if surfaces.band_limit == "none" else surfaces.band_limit,
    }  # fmt: skip


def fill_profile_family(study: Study, heights: Floats, dimensions: Floats, repetition: int, side: Side) -> Floats:
    """Write one profile of a body per fractal dimension to the rows of the array `heights`.

    The heights are not scaled to an amplitude. Returns an array (k, 3): mean, minimum and maximum of each profile.
    """
    surfaces: Any = study.surfaces
    phases = generate_phases(study, repetition, side)
    return fractal.fill_profile_family(
        heights, phases, dimensions, extent=float(surfaces.extent), **_get_weierstrass_arguments(surfaces)
    )


def generate_unscaled_profile(study: Study, repetition: int, side: Side, dimension: float) -> Profile:
    """Generate a profile with a given fractal dimension for one body.

    The heights are not scaled to the amplitude of the study.
    """
    surfaces: Any = study.surfaces
    heights = np.empty((1, surfaces.points))
    fill_profile_family(study, heights, np.array([dimension]), repetition, side)
    return Profile(heights[0], spacing=surfaces.spacing)


def generate_profile_pairs(
    study: Study, repetition: int, dimensions: Floats, amplitude: float
) -> Iterator[tuple[Profile, Profile]]:
    """Generate a pair of profiles for each fractal dimension, and scale the heights to an amplitude (µm).

    The computing time is nearly independent of the number of fractal dimensions.
    """
    surfaces: Any = study.surfaces
    batch_size = max(1, MAX_BATCH_BYTES // (8 * surfaces.points))
    for batch_start in range(0, dimensions.size, batch_size):
        batch_dimensions = dimensions[batch_start : batch_start + batch_size]
        body_heights = [np.empty((batch_dimensions.size, surfaces.points)) for _ in SIDES]
        for side, heights in zip(SIDES, body_heights, strict=True):
            fill_profile_family(study, heights, batch_dimensions, repetition, side)
        for pair in zip(*body_heights, strict=True):
            upper, lower = (
                scale_profile(heights, surfaces.spacing, amplitude, surfaces.amplitude_measure, np.empty_like(heights))
                for heights in pair
            )
            yield upper, lower


def generate_unscaled_surface(study: Study, repetition: int, side: Side, dimension: float) -> Surface:
    """Generate a height map with a given fractal dimension for one body.

    The heights are not scaled to the amplitude of the study.
    """
    surfaces: Any = study.surfaces
    if isinstance(surfaces, SelfAffineSettings):
        longest_wavelength, shortest_wavelength = surfaces.longest_wavelength, surfaces.shortest_wavelength
        return self_affine_surface(
            study.ensemble.seed,
            hurst_exponent=fractal.hurst_from_fractal_dimension(dimension, convention="classical"), rms=1.0,
            shape=surfaces.shape, spacing=surfaces.spacings(),
            longest_wavelength=None if longest_wavelength is None else float(longest_wavelength),
            shortest_wavelength=None if shortest_wavelength is None else float(shortest_wavelength),
            repetition=repetition, side=side,
        )  # fmt: skip
    phases = generate_phases(study, repetition, side)
    return fractal.weierstrass_mandelbrot_surface(
        phases, dimension, shape=surfaces.shape, extent=surfaces.extents(), **_get_weierstrass_arguments(surfaces)
    )


def scale_surface_to_amplitude(study: Study, surface: Surface, amplitude: float) -> Surface:
    """Scale a height map to an amplitude (µm), in the amplitude measure of the study."""
    surfaces: Any = study.surfaces
    return surface.with_amplitude(amplitude, surfaces.amplitude_measure)


def pair_of(
    study: Study, repetition: int, *, fractal_dimension: float, amplitude: float
) -> tuple[Profile, Profile] | tuple[Surface, Surface]:
    """Generate the two surfaces that `run` brings into contact in one repetition of a study.

    Parameters
    ----------
    study : Study
    repetition : int
        Number of the pair, at least 0. It may exceed the number of repetitions of the study.
    fractal_dimension : float
        At least 1 and below 2, in the convention of the study.
    amplitude : float, µm
        Above 0, in the amplitude measure of the study.

    Returns
    -------
    upper, lower : Profile or Surface
        Profiles or surfaces, according to `surfaces.kind`.

    Raises
    ------
    ValueError
        If an argument is out of range, if the profiles of the study cannot be computed, or if its bodies are measured.

    Examples
    --------
    >>> from stiction import Study, pair_of, press
    >>> study = Study.named("figure6").with_changes({"surfaces.points": 2000, "surfaces.extent": "1 um"})
    >>> upper, lower = pair_of(study, 7, fractal_dimension=1.3, amplitude=0.1)
    >>> press(upper, lower, [0.01, 0.02]).contact_count.shape
    (2,)
    """
    check_instance("study", study, Study, "a Study")
    if study.is_measured:
        raise ValueError(
            "pair_of requires a study of generated bodies, because measured bodies have no fractal dimension"
        )
    if study.is_areal:
        upper, lower = (
            scale_surface_to_amplitude(
                study, generate_unscaled_surface(study, repetition, side, fractal_dimension), amplitude
            )
            for side in SIDES
        )
        return upper, lower
    return next(generate_profile_pairs(study, repetition, np.array([fractal_dimension]), amplitude))


# ---- Measured bodies -------------------------------------------------------------------------------------------------


def _get_grid_properties(body: Any) -> tuple[Any, ...]:
    """Return type, shape and spacing of a scan.

    Scans whose properties are equal have equal grids.

    The spacing is rounded, because positions in a file are subject to round-off.
    """
    spacing_texts = [f"{step:.5g}" for step in np.atleast_1d(getattr(body, "spacing", 0.0))]
    return type(body), np.shape(getattr(body, "heights", body)), *spacing_texts


class PreparedBodies:
    """Measured bodies that are read from files and provide the members of a study.

    Each file is read only once. The constructor raises a `ValueError` if a file has changed.
    """

    def __init__(self, surfaces: MeasuredSurfaceSettings, seed: int) -> None:
        self._surfaces, self._seed = surfaces, seed
        self._scans_by_side = [[scan.read() for scan in getattr(surfaces, side).scans] for side in SIDES]
        for side, scans in zip(SIDES, self._scans_by_side, strict=True):
            if len(scans) > 1 and len({_get_grid_properties(scan) for scan in scans}) > 1:
                raise ValueError(
                    f"surfaces.{side}: the scans of a body must have the same number of points and the same spacing"
                )
            heights = [scan.heights for scan in scans if isinstance(scan, Profile | Surface)]
            if len(heights) > 1 and len({array.tobytes() for array in heights}) < len(heights):
                raise ValueError(f"surfaces.{side}: two scans of a body are identical; give each scan only once")
        if surfaces.first_scan_member_index and math.prod(surfaces.scan_counts) > 1:
            raise ValueError("surfaces.surrogates: must be 0 if a body has several scans")
        self._cached_members = functools.lru_cache(MAX_CACHED_PAIRS)(self._prepare_member_source)
        self._locks: dict[tuple[float, int, int], threading.Lock] = {}

    def members(self, wavelength: float, upper: int = 0, lower: int = 0) -> MemberSource:
        """Return an object that provides pairs of surfaces from two scans after low-pass filtering at a cutoff (µm).

        A cutoff of 0 stands for no filter. If several threads need the same members, one thread filters the scans, and
        the others wait. Raises a `ValueError` if the scans form no members.
        """
        cache_key = wavelength, upper, lower
        with self._locks.setdefault(cache_key, threading.Lock()):
            return self._cached_members(*cache_key)

    def _prepare_member_source(self, wavelength: float, upper: int, lower: int) -> MemberSource:
        surfaces, indices = self._surfaces, (upper, lower)
        scan_pair = self._scans_by_side[0][upper], self._scans_by_side[1][lower]
        files = (getattr(surfaces, side).scans[index] for side, index in zip(SIDES, indices, strict=True))
        upper_cutoff, lower_cutoff = (file.select_cut_off_of_scan(wavelength) for file in files)
        return surfaces.build_member_source(scan_pair, (upper_cutoff, lower_cutoff), self._seed)

    def member(self, index: int, wavelength: float) -> EnsembleMember:
        """Return the surface pair `index` of scans that are low-pass filtered at `wavelength` (µm, 0 for no filter)."""
        surfaces = self._surfaces
        # Within a scan pair, members are numbered from 0, except surrogates, whose number in the study is their seed.
        has_surrogates = surfaces.press == "surrogates" or getattr(surfaces, "replace", "none") != "none"
        index_within_pair = index if has_surrogates else index // math.prod(surfaces.scan_counts)
        return self.members(wavelength, *surfaces.scan_indices_of_members(index)).member(index_within_pair)

    @cached_property
    def attributes(self) -> BodyAttributes:
        """Attributes that a result stores about the bodies, such as nominal area, processing history and grid."""
        properties = self.members(self._surfaces.reported_cut_off()).find_shared_properties()
        attributes: dict[str, Any] = {
            side: "\n".join(body.history)
            for side, body in zip(SIDES, (properties.upper, properties.lower), strict=True)
        }
        attributes |= {
            "shape": properties.shape,
            "spacing_um": properties.spacing,
            "fraction_used": properties.piece_fractions,
        }
        for side, scan in zip(SIDES, properties.scans, strict=True):
            attributes[f"{side}_spacing_um"] = scan.spacing
            attributes[f"{side}_extent_um"] = scan.extent
            if (fraction_and_gap := getattr(self._surfaces, side).find_interpolated_fraction_and_gap()).any():
                attributes[f"{side}_filled"] = fraction_and_gap
        attributes |= self._drift_attributes | self._lay_attributes
        for side, scans in zip(SIDES, self._scans_by_side, strict=True):
            masks = [mask for scan in scans if (mask := getattr(scan, "missing", None)) is not None]
            if scattered_fraction := sum(map(compute_scattered_missing_fraction, masks)) / len(scans):
                attributes[f"{side}_pierced"] = scattered_fraction
        return BodyAttributes.from_values(float(properties.area) * self._find_measured_fraction(), attributes)

    @cached_property
    def _pressed_bodies(self) -> list[Profile | Surface]:
        """Low-pass filtered first scan of each body, in a list that is empty for a measured gap or for spectra.

        The members of a study are cut from these and any further scans.
        """
        pairs = getattr(self.members(self._surfaces.reported_cut_off()), "pairs", None)
        filtered_scans = [getattr(pairs, side, None) for side in SIDES]
        bodies = [body for body in filtered_scans if isinstance(body, Profile | Surface)]
        return bodies if len(bodies) == len(SIDES) else []

    @cached_property
    def _lay_attributes(self) -> dict[str, Any]:
        """Lay ratio of each map as attributes of a result: rms slope across the lay over rms slope along the lay.

        Empty unless both maps have a lay.
        """
        maps = [body for body in self._pressed_bodies if isinstance(body, Surface)]
        if self._surfaces.press != "areas" or len(maps) < len(SIDES):
            return {}
        ratios = {f"{side}_lay": compute_lay_ratio(body) for side, body in zip(SIDES, maps, strict=True)}
        return ratios if min(ratios.values()) > MIN_LAY_SLOPE_RATIO else {}

    @cached_property
    def _drift_attributes(self) -> dict[str, Any]:
        """Roughness drift along the scan, for each body that has a single scan, as attributes of a result.

        Each attribute contains the drift and the body's fraction of the mean square slope of the gap. A body without
        drift has no attribute.
        """
        bodies = self._pressed_bodies
        if not bodies:
            return {}
        mean_squares = np.array([compute_mean_square_slope(body) for body in bodies])
        fractions = mean_squares / (mean_squares.sum() or 1.0)
        return {
            f"{side}_drift": np.array([drift, fraction])
            for side, body, fraction, count in zip(SIDES, bodies, fractions, self._surfaces.scan_counts, strict=True)
            if count == 1 and (drift := estimate_roughness_drift(body)) > 0
        }

    def _find_measured_fraction(self) -> float:
        """Return the fraction of the nominal area in which both bodies have measured heights.

        The fraction is a mean over the first surface pairs.
        """
        if all(getattr(scan, "missing", None) is None for scans in self._scans_by_side for scan in scans):
            return 1.0
        measured_fractions = []
        # If there are fewer than `NUM_AVERAGED_MEMBERS` members, the error for a nonexistent member ends the loop.
        with contextlib.suppress(ValueError, IndexError):
            for index in range(NUM_AVERAGED_MEMBERS):
                missing = combine_missing_masks(*self.member(index, self._surfaces.reported_cut_off()).pair)
                measured_fractions.append(1.0 if missing is None else 1 - float(missing.mean()))
        return float(np.mean(measured_fractions)) if measured_fractions else 1.0


def count_grid_points(study: Study) -> int:
    """Return the number of grid points of a member, or a typical number of points if no scan can be read."""
    settings: Any = study.surfaces
    if not study.is_measured:
        return math.prod(settings.shape) if study.is_areal else int(settings.points)
    with contextlib.suppress(ValueError, OSError):
        return int(np.prod(find_body_attributes(study).attributes["shape"]))
    return TYPICAL_SCAN_POINTS[study.is_areal]


def get_first_pair(study: Study) -> Any:
    """Return the upper and the lower body of the first member of a study.

    Measured bodies are filtered at the first cutoff. Generated bodies have the first fractal dimension and the first
    amplitude. Raises a `ValueError` if files are missing.
    """
    cell = {name: float(values[0]) for name, values in study.surfaces.cell_coordinates().items()}
    return (
        read_measured_bodies(study).member(0, cell["cut_off"]).pair if study.is_measured else pair_of(study, 0, **cell)
    )


def read_measured_bodies(study: Study) -> PreparedBodies:
    """Load the measured bodies of a study from their files.

    The bodies are cached, and are read again only if a file changes.
    """
    surfaces = study.surfaces
    assert isinstance(surfaces, MeasuredSurfaceSettings)
    stamps = tuple(scan.file_stamp() for side in SIDES for scan in getattr(surfaces, side).scans)
    return _read_cached_bodies(surfaces, study.ensemble.seed, stamps)


@functools.lru_cache(maxsize=4)
def _read_cached_bodies(surfaces: MeasuredSurfaceSettings, seed: int, _: object) -> PreparedBodies:
    return PreparedBodies(surfaces, seed)


def check_scans_provide_all_members(study: Study) -> None:
    """Raise a `ValueError` if a study requests more members (key `repetitions`) than its scans provide."""
    if study.is_measured:
        cutoff = float(study.surfaces.cell_coordinates()["cut_off"][0])
        read_measured_bodies(study).member(study.ensemble.repetitions - 1, cutoff)


def find_body_attributes(study: Study) -> BodyAttributes:
    """Return the attributes of measured bodies that a result stores, or no attributes for generated bodies."""
    return read_measured_bodies(study).attributes if study.is_measured else BodyAttributes()
