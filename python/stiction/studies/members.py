"""The members of a study: pairs of bodies, generated or measured, each of which follows from the study and its number.

A member is a generated repetition, a line at an offset, two maps at a relative position, or a pair of surrogates.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from stiction._checks import Floats, read_only
from stiction.mechanics.model import THICKNESS
from stiction.studies.generated_surfaces import SelfAffineSurfaces
from stiction.studies.measured_surfaces import MeasuredAreas, MeasuredLines
from stiction.studies.result import About, areas, is_measured, measured, profiles
from stiction.studies.study import Study, study_from_text
from stiction.surfaces.cut_off import cut_off
from stiction.surfaces.fractal import (
    BandLimit,
    Convention,
    fill_family,
    hurst_exponent,
    random_phases,
    weierstrass_mandelbrot_surface,
)
from stiction.surfaces.joined import JoinedSpectrum
from stiction.surfaces.pairing import SIDES, IsotropicPairs, LinePairs, MapPairs, lower_piece, spread
from stiction.surfaces.preparation import levelled, rotated, turned_over
from stiction.surfaces.profile import Profile, Side, scaled_profile
from stiction.surfaces.self_affine import self_affine_surface
from stiction.surfaces.spectral_pairs import SpectrumPairs, spectrum_of
from stiction.surfaces.surface import Surface

Pair = tuple[Profile, Profile] | tuple[Surface, Surface]

Maker = MapPairs | IsotropicPairs | SpectrumPairs | LinePairs

# ---- Generated -------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class ProfileGenerator:
    """Eq. 1 as a study sets it: all of its profiles but for fractal dimension and amplitude. Lengths in µm."""

    seed: int
    directions: int
    frequencies: int
    length_scale: float
    gamma: float
    extent: float
    points: int
    convention: Convention
    band_limit: BandLimit | None

    @classmethod
    def of(cls, study: Study) -> ProfileGenerator:
        """That of a study."""
        surfaces = profiles(study)
        return cls(
            seed=study.ensemble.seed,
            directions=surfaces.directions,
            frequencies=surfaces.frequencies,
            length_scale=float(surfaces.length_scale),
            gamma=surfaces.gamma,
            extent=float(surfaces.extent),
            points=surfaces.points,
            convention=surfaces.convention,
            band_limit=None if surfaces.band_limit == "none" else surfaces.band_limit,
        )

    @property
    def spacing(self) -> float:
        """Of the points, µm."""
        return self.extent / self.points

    def phases(self, repetition: int, side: Side) -> Floats:
        """(directions, frequencies) phases of one body of a repetition, rad."""
        return random_phases(
            self.seed, repetition=repetition, side=side, directions=self.directions, frequencies=self.frequencies
        )

    def fill(self, heights: Floats, dimensions: Floats, repetition: int, side: Side) -> Floats:
        """Unscaled heights (k, points) of one body at fractal dimensions (k,), in memory that is there already.

        Returns
        -------
        (k, 3) ndarray, µm
            Mean, lowest and highest of each.
        """
        return fill_family(
            heights,
            self.phases(repetition, side),
            dimensions,
            length_scale=self.length_scale,
            gamma=self.gamma,
            extent=self.extent,
            convention=self.convention,
            band_limit=self.band_limit,
        )

    def heights(self, dimension: float, repetition: int, side: Side) -> Floats:
        """Unscaled heights (points,) of one body at a fractal dimension."""
        family = np.empty((1, self.points))
        self.fill(family, np.array([dimension]), repetition, side)
        return read_only(family[0])


FAMILY_MEMORY = 64_000_000
"""Bytes of each body's profiles that are held at a time, so that memory does not grow with the study."""


def pairs_of(study: Study, repetition: int, dimensions: Floats, amplitude: float) -> Iterator[tuple[Profile, Profile]]:
    """`pair_of` profiles at each of several fractal dimensions, many of which take little longer than one."""
    generator = ProfileGenerator.of(study)
    measure = profiles(study).amplitude_measure
    members = max(1, FAMILY_MEMORY // (8 * generator.points))
    for first in range(0, dimensions.size, members):
        family = dimensions[first : first + members]
        bodies = [np.empty((family.size, generator.points)) for _ in range(2)]
        generator.fill(bodies[0], family, repetition, "upper")
        generator.fill(bodies[1], family, repetition, "lower")
        for pair in zip(*bodies, strict=True):
            upper, lower = (
                scaled_profile(heights, generator.spacing, amplitude, measure, np.empty_like(heights))
                for heights in pair
            )
            yield upper, lower


def unscaled_surface(study: Study, repetition: int, side: Side, dimension: float) -> Surface:
    """One body of a study of surfaces at a fractal dimension, whatever its amplitude."""
    surfaces = areas(study)
    if isinstance(surfaces, SelfAffineSurfaces):
        longest, shortest = surfaces.longest_wavelength, surfaces.shortest_wavelength
        return self_affine_surface(
            study.ensemble.seed,
            hurst_exponent=hurst_exponent(dimension, convention="classical"),
            rms=1.0,
            shape=surfaces.shape,
            spacing=surfaces.spacings(),
            longest_wavelength=None if longest is None else float(longest),
            shortest_wavelength=None if shortest is None else float(shortest),
            repetition=repetition,
            side=side,
        )
    phases = random_phases(
        study.ensemble.seed,
        repetition=repetition,
        side=side,
        directions=surfaces.directions,
        frequencies=surfaces.frequencies,
    )
    return weierstrass_mandelbrot_surface(
        phases,
        dimension,
        shape=surfaces.shape,
        extent=surfaces.extents(),
        length_scale=float(surfaces.length_scale),
        gamma=surfaces.gamma,
        convention=surfaces.convention,
        band_limit=None if surfaces.band_limit == "none" else surfaces.band_limit,
    )


def scaled_surface(study: Study, surface: Surface, amplitude: float) -> Surface:
    """A surface at one of the amplitudes of its study."""
    return surface.with_amplitude(amplitude, areas(study).amplitude_measure)


def pair_of(
    study: Study, repetition: int, *, fractal_dimension: float, amplitude: float
) -> tuple[Profile, Profile] | tuple[Surface, Surface]:
    """One pair of a study of generated bodies, as `run` presses it together.

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
    if is_measured(study):
        raise ValueError("pair_of is for studies of generated bodies; the members of measured ones have no dimension")
    if study.surfaces.kind == "surface":
        one, other = (
            scaled_surface(study, unscaled_surface(study, repetition, side, fractal_dimension), amplitude)
            for side in SIDES
        )
        return one, other
    generator = ProfileGenerator.of(study)
    measure = profiles(study).amplitude_measure
    bodies = []
    for side in SIDES:
        heights = generator.heights(fractal_dimension, repetition, side)
        bodies.append(scaled_profile(heights, generator.spacing, amplitude, measure, np.empty_like(heights)))
    upper, lower = bodies
    return upper, lower


# ---- Measured --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Measured:
    """One member of measured bodies: the pair, how far its upper body is moved (µm), and what kind of pair it is."""

    pair: Pair
    x: float
    y: float
    line: int = 0
    surrogate: bool = False


class Bodies:
    """Two measured bodies, read and prepared once, and the members that they make at each cut-off.

    Raises
    ------
    ValueError
        If a file cannot be read, is another than the study was written for, or does not make what the study asks for.
    """

    def __init__(self, study: Study) -> None:
        self._study = study
        self._surfaces = measured(study)
        self._scans = self._surfaces.upper.read(), self._surfaces.lower.read()
        self._check_kinds()
        self._makers: dict[float, Maker] = {}

    def _check_kinds(self) -> None:
        press = self._surfaces.press
        if any(isinstance(scan, JoinedSpectrum) for scan in self._scans):
            if press != "surrogates":
                raise ValueError(f'surfaces.press: of a spectrum there are "surrogates" alone, got "{press}"')
            return
        are_maps = [isinstance(scan, Surface) for scan in self._scans]
        if press == "areas" and not all(are_maps):
            raise ValueError('surfaces.press: "areas" are of two maps, and one of the files is a profile')
        if press == "surrogates" and any(are_maps) and not all(are_maps):
            raise ValueError('surfaces.press: "surrogates" are of two maps or of two profiles, not of one of each')

    def maker(self, wavelength: float) -> Maker:
        """What makes the pairs of bodies from which waves shorter than a cut-off are taken off."""
        if wavelength not in self._makers:
            self._makers[wavelength] = self._made(wavelength)
        return self._makers[wavelength]

    def _made(self, wavelength: float) -> Maker:
        surfaces, seed = self._surfaces, self._study.ensemble.seed
        one, other = self._scans
        level: Any = None if surfaces.level == "none" else surfaces.level
        if isinstance(one, JoinedSpectrum) or isinstance(other, JoinedSpectrum):
            finest = float(surfaces.cells()["cut_off"][0])
            return SpectrumPairs(spectrum_of(one), spectrum_of(other), level, seed, wavelength, finest)
        upper, lower = (cut_off(scan, wavelength) if wavelength > 0 else scan for scan in (one, other))
        if isinstance(surfaces, MeasuredLines):
            travel = None if surfaces.travel is None else float(surfaces.travel)
            several = surfaces.replace != "none" or isinstance(upper, Surface) or isinstance(lower, Surface)
            return LinePairs(upper, lower, travel, level, surfaces.along, surfaces.replace, seed, several=several)
        if isinstance(upper, Profile) and isinstance(lower, Profile):
            trend: Any = "line" if level == "plane" else level
            return IsotropicPairs(turned_over(levelled(upper, trend)), levelled(lower, trend), "plane", seed)
        assert isinstance(upper, Surface)
        assert isinstance(lower, Surface)
        plane: Any = "plane" if level == "line" else level
        above = levelled(upper, plane)
        if isinstance(surfaces, MeasuredAreas) and surfaces.rotate:
            above = rotated(above, surfaces.rotate)
        return MapPairs(turned_over(above), levelled(lower, plane), plane, seed)

    def member(self, index: int, wavelength: float) -> Measured:
        """One member at a cut-off (µm, 0 for the scan itself)."""
        maker, surfaces = self.maker(wavelength), self._surfaces
        if isinstance(maker, (IsotropicPairs, SpectrumPairs)):
            return Measured(maker.surrogates(index), np.nan, np.nan, surrogate=True)
        if isinstance(maker, MapPairs):
            made = surfaces.surrogates if isinstance(surfaces, MeasuredAreas) else index + 1
            if index < made:
                return Measured(maker.surrogates(index), np.nan, np.nan, surrogate=True)
            shift = index - made
            if shift >= maker.most():
                raise ValueError(f"the maps have {maker.most()} relative positions, and member {index} is beyond them")
            return Measured(maker.pair(shift), *maker.moved(shift))
        return self._at_offset(maker, index)

    def _at_offset(self, maker: LinePairs, index: int) -> Measured:
        surfaces = self._surfaces
        assert isinstance(surfaces, MeasuredLines)
        line, place = divmod(index, surfaces.offsets) if maker.several else (0, index)
        most = maker.most()
        if most is not None and line >= most:
            raise ValueError(f"the surfaces have {most} pairs of lines, and member {index} is on pair {line + 1}")
        slider, track = maker.pair(line)
        room = len(track) - len(slider)
        if room == 0 and place > 0:
            raise ValueError("several positions need a travel, for which the slider is shortened")
        # A line on itself is no pair at 0; several lines are not on themselves.
        alone = maker.several and surfaces.offsets == 1 and surfaces.travel is None
        if alone or room == 0:
            steps = 0
        elif surfaces.offsets == 1 and surfaces.travel is not None and place == 0:
            steps = room  # one position: the travel that was asked for
        else:
            steps = 1 + min(int(spread(place + 1, 1)[0] * room), room - 1)
        offset = steps * slider.spacing
        pair = slider, lower_piece(track, offset, slider)
        return Measured(pair, offset, maker.place(line), line=line, surrogate=surfaces.replace != "none")

    def about(self) -> About:
        """What a result says of the bodies."""
        maker = self.maker(float(self._surfaces.cells()["cut_off"][0]))
        if isinstance(maker, LinePairs):
            slider, track = maker.pair(0)
            bodies: tuple[Any, Any] = (slider, track)
            area, shape, spacing = slider.extent * THICKNESS, [len(slider)], [slider.spacing]
            used = [len(slider) / len(track)] * 2
        else:
            bodies = maker.upper, maker.lower
            area, shape, spacing, used = maker.area, list(maker.shape), list(maker.spacing), list(maker.used)
        if isinstance(maker, SpectrumPairs):  # as if two points were the shortest wave
            scanned = [np.array([max(body.shortest, maker.finest) / 2]) for body in (maker.upper, maker.lower)]
            extents = [np.array([maker.side])] * 2
        else:
            scans = [scan for scan in self._scans if not isinstance(scan, JoinedSpectrum)]
            scanned = [np.atleast_1d(scan.spacing) for scan in scans]
            extents = [np.atleast_1d(scan.extent) for scan in scans]
        attributes = {side: "\n".join(body.history) for side, body in zip(SIDES, bodies, strict=True)}
        return About(
            nominal_area=float(area),
            attributes=attributes
            | {
                "shape": np.array(shape, np.int64),
                "spacing_um": np.array(spacing, np.float64),
                "fraction_used": np.array(used, np.float64),
                "upper_spacing_um": scanned[0],
                "lower_spacing_um": scanned[1],
                "upper_extent_um": extents[0],
                "lower_extent_um": extents[1],
            },
        )


def bodies_of(study: Study) -> Bodies:
    """The measured bodies of a study, which a process reads once."""
    return _bodies(study.to_toml())


@functools.lru_cache(maxsize=4)
def _bodies(text: str) -> Bodies:
    return Bodies(study_from_text(text, "the study"))


def about(study: Study) -> About:
    """What the bodies of a study say of a result: nothing, where they are generated."""
    return bodies_of(study).about() if is_measured(study) else About()
