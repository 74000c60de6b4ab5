"""The members of a study: pairs of bodies, generated or measured, each of which follows from the study and its number.

A member is a generated repetition, a line at an offset, two maps at a relative position, or a pair of surrogates.
"""

from __future__ import annotations

import contextlib
import functools
import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from stiction._checks import Floats, check_instance
from stiction.studies.generated_surfaces import SelfAffineSurfaces
from stiction.studies.measured_surfaces import BodyAttributes, Measured, Member, Members
from stiction.studies.study import Study
from stiction.surfaces import fractal
from stiction.surfaces.pairing import SIDES
from stiction.surfaces.profile import Profile, Side, combine_missing, scale_profile
from stiction.surfaces.self_affine import self_affine_surface
from stiction.surfaces.surface import Surface

MAX_BATCH_BYTES = (
    64_000_000  # bytes of each body's profiles held at a time, so that memory does not grow with the study
)
MAX_CACHED_PAIRS = 16  # pairs of scans that are held as they are pressed
NUM_AVERAGED_MEMBERS = 16  # members over which the measured area is averaged
TYPICAL_SCAN_POINTS = {False: 4000, True: 400**2}  # points of a line and of an area that are pressed of a common scan

# ---- Generated -------------------------------------------------------------------------------------------------------


def generate_phases(study: Study, repetition: int, side: Side) -> Floats:
    """(directions, frequencies) phases of Eq. 1 of one body of a repetition, rad."""
    surfaces: Any = study.surfaces
    return fractal.random_phases(
        study.ensemble.seed, repetition=repetition, side=side, directions=surfaces.directions,
        frequencies=surfaces.frequencies,
    )  # fmt: skip


def _equation(surfaces: Any) -> dict[str, Any]:
    """Eq. 1 as a study sets it, but for phases and grid."""
    return {
        "length_scale": float(surfaces.length_scale), "gamma": surfaces.gamma, "convention": surfaces.convention,
        "band_limit": None if surfaces.band_limit == "none" else surfaces.band_limit,
    }  # fmt: skip


def fill_profiles(study: Study, heights: Floats, dimensions: Floats, repetition: int, side: Side) -> Floats:
    """Unscaled heights (k, points) of one body at dimensions (k,); mean, lowest and highest of each, (k, 3)."""
    surfaces: Any = study.surfaces
    phases = generate_phases(study, repetition, side)
    return fractal.fill_profiles(heights, phases, dimensions, extent=float(surfaces.extent), **_equation(surfaces))


def unscaled_profile(study: Study, repetition: int, side: Side, dimension: float) -> Profile:
    """One body of a study of profiles at a fractal dimension, whatever its amplitude."""
    surfaces: Any = study.surfaces
    heights = np.empty((1, surfaces.points))
    fill_profiles(study, heights, np.array([dimension]), repetition, side)
    return Profile(heights[0], spacing=surfaces.spacing)


def generate_pairs(
    study: Study, repetition: int, dimensions: Floats, amplitude: float
) -> Iterator[tuple[Profile, Profile]]:
    """`pair_of` profiles at each of several fractal dimensions, many of which take little longer than one."""
    surfaces: Any = study.surfaces
    members = max(1, MAX_BATCH_BYTES // (8 * surfaces.points))
    for first in range(0, dimensions.size, members):
        family = dimensions[first : first + members]
        bodies = [np.empty((family.size, surfaces.points)) for _ in SIDES]
        for side, heights in zip(SIDES, bodies, strict=True):
            fill_profiles(study, heights, family, repetition, side)
        for pair in zip(*bodies, strict=True):
            upper, lower = (
                scale_profile(each, surfaces.spacing, amplitude, surfaces.amplitude_measure, np.empty_like(each))
                for each in pair
            )
            yield upper, lower


def unscaled_surface(study: Study, repetition: int, side: Side, dimension: float) -> Surface:
    """One body of a study of surfaces at a fractal dimension, whatever its amplitude."""
    surfaces: Any = study.surfaces
    if isinstance(surfaces, SelfAffineSurfaces):
        longest, shortest = surfaces.longest_wavelength, surfaces.shortest_wavelength
        return self_affine_surface(
            study.ensemble.seed, hurst_exponent=fractal.hurst_exponent(dimension, convention="classical"), rms=1.0,
            shape=surfaces.shape, spacing=surfaces.spacings(),
            longest_wavelength=None if longest is None else float(longest),
            shortest_wavelength=None if shortest is None else float(shortest), repetition=repetition, side=side,
        )  # fmt: skip
    phases = generate_phases(study, repetition, side)
    return fractal.weierstrass_mandelbrot_surface(
        phases, dimension, shape=surfaces.shape, extent=surfaces.extents(), **_equation(surfaces)
    )


def scaled_surface(study: Study, surface: Surface, amplitude: float) -> Surface:
    """A surface at one of the amplitudes of its study."""
    surfaces: Any = study.surfaces
    return surface.with_amplitude(amplitude, surfaces.amplitude_measure)


def pair_of(
    study: Study, repetition: int, *, fractal_dimension: float, amplitude: float
) -> tuple[Profile, Profile] | tuple[Surface, Surface]:
    """Generate one pair of surfaces of a study, equal to the pair that `run` computes.

    Parameters
    ----------
    study : Study
    repetition : int
        From 0 on; as its number alone decides, it may lie beyond those that the study asks for.
    fractal_dimension : float
        At least 1 and below 2, in the study's convention.
    amplitude : float, µm
        Above 0, in the study's measure.

    Returns
    -------
    upper, lower : Profile or Surface
        As `surfaces.kind` says.

    Raises
    ------
    ValueError
        If a number is outside its range, the study's profiles cannot be computed, or its bodies are measured.

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
        raise ValueError("pair_of is for studies of generated bodies; the members of measured ones have no dimension")
    if study.is_areal:
        one, other = (
            scaled_surface(study, unscaled_surface(study, repetition, side, fractal_dimension), amplitude)
            for side in SIDES
        )
        return one, other
    return next(generate_pairs(study, repetition, np.array([fractal_dimension]), amplitude))


# ---- Measured --------------------------------------------------------------------------------------------------------


def _grid(body: Any) -> tuple[Any, ...]:
    """Kind and points of a scan; steps that were read from positions are equal but for round-off."""
    steps = [f"{step:.5g}" for step in np.atleast_1d(getattr(body, "spacing", 0.0))]
    return type(body), np.shape(getattr(body, "heights", body)), *steps


class LoadedBodies:
    """Measured bodies, read once, and the members that they make; a `ValueError` if a file is not what it was."""

    def __init__(self, surfaces: Measured, seed: int) -> None:
        self._surfaces, self._seed = surfaces, seed
        self._parts = [[scan.read() for scan in getattr(surfaces, side).scans] for side in SIDES]
        for side, scans in zip(SIDES, self._parts, strict=True):
            if len(scans) > 1 and len({_grid(scan) for scan in scans}) > 1:
                raise ValueError(f"surfaces.{side}: the scans of a part must have the same points and spacing")
            heights = [scan.heights.tobytes() for scan in scans if isinstance(scan, Profile | Surface)]
            if len(set(heights)) < len(heights):
                raise ValueError(f"surfaces.{side}: two scans of a part are the same; give each place once")
        if surfaces.first_scanned and math.prod(surfaces.scan_counts) > 1:
            raise ValueError("surfaces.surrogates: of several scans of a part all members are pieces of these")
        self.members = functools.lru_cache(MAX_CACHED_PAIRS)(self._prepared)

    def _prepared(self, wavelength: float, upper: int = 0, lower: int = 0) -> Members:
        """What makes the members of two scans at a cut-off (µm, 0 for none); a `ValueError` if none can be made."""
        surfaces, places = self._surfaces, (upper, lower)
        scans = self._parts[0][upper], self._parts[1][lower]
        files = (getattr(surfaces, side).scans[place] for side, place in zip(SIDES, places, strict=True))
        above, below = (file.cut_off_at(wavelength) for file in files)
        return surfaces.members(scans, (above, below), self._seed)

    def member(self, index: int, wavelength: float) -> Member:
        """One member at a cut-off (µm, 0 for the scans themselves)."""
        surfaces = self._surfaces
        # Each pair of scans has positions of its own, and surrogates of all pairs have random numbers of their own.
        made = surfaces.press == "surrogates" or getattr(surfaces, "replace", "none") != "none"
        own = index if made else index // math.prod(surfaces.scan_counts)
        return self.members(wavelength, *surfaces.scans_of(index)).member(own)

    def attributes(self) -> BodyAttributes:
        """What a result says of the bodies."""
        facts = self.members(self._surfaces.quoted_cut_off()).facts()
        attributes: dict[str, Any] = {
            side: "\n".join(body.history) for side, body in zip(SIDES, (facts.upper, facts.lower), strict=True)
        }
        attributes |= {
            "shape": np.array(facts.shape, np.int64),
            "spacing_um": np.array(facts.spacing, np.float64),
            "fraction_used": np.array(facts.used, np.float64),
        }
        for side, scan in zip(SIDES, facts.scans, strict=True):
            attributes[f"{side}_spacing_um"] = np.atleast_1d(np.asarray(scan.spacing, np.float64))
            attributes[f"{side}_extent_um"] = np.atleast_1d(np.asarray(scan.extent, np.float64))
            if (filled := getattr(self._surfaces, side).filled()).any():
                attributes[f"{side}_filled"] = filled
        return BodyAttributes(nominal_area=float(facts.area) * self._measured(), attributes=attributes)

    def _measured(self) -> float:
        """Share of a member that was measured in both, a mean over the first ones, however many there are."""
        if all(getattr(scan, "missing", None) is None for scans in self._parts for scan in scans):
            return 1.0
        found = []
        with contextlib.suppress(ValueError, IndexError):  # of fewer members
            for index in range(NUM_AVERAGED_MEMBERS):
                missing = combine_missing(*self.member(index, self._surfaces.quoted_cut_off()).pair)
                found.append(1.0 if missing is None else 1 - float(missing.mean()))
        return float(np.mean(found)) if found else 1.0


def count_points(study: Study) -> int:
    """How many points of a grid the bodies of a member have; where files are gone, as many as of a common scan."""
    surfaces: Any = study.surfaces
    if not study.is_measured:
        return math.prod(surfaces.shape) if study.is_areal else int(surfaces.points)
    with contextlib.suppress(ValueError, OSError):
        return int(np.prod(body_attributes(study).attributes["shape"]))
    return TYPICAL_SCAN_POINTS[study.is_areal]


def first_pair(study: Study) -> Any:
    """Return both bodies of the first member in the first cell; a `ValueError` if files are gone."""
    cell = {name: float(values[0]) for name, values in study.surfaces.cells().items()}
    return load_bodies(study).member(0, cell["cut_off"]).pair if study.is_measured else pair_of(study, 0, **cell)


def load_bodies(study: Study) -> LoadedBodies:
    """The measured bodies of a study, which a process reads once, and again when a file has changed."""
    surfaces = study.surfaces
    assert isinstance(surfaces, Measured)
    stamps = tuple(scan.stamp() for side in SIDES for scan in getattr(surfaces, side).scans)
    return _bodies(surfaces, study.ensemble.seed, stamps)


@functools.lru_cache(maxsize=4)
def _bodies(surfaces: Measured, seed: int, _: object) -> LoadedBodies:
    return LoadedBodies(surfaces, seed)


def body_attributes(study: Study) -> BodyAttributes:
    """What the bodies of a study say of a result: nothing, where they are generated."""
    return load_bodies(study).attributes() if study.is_measured else BodyAttributes()
