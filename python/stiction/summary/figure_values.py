"""Data for figures: datasets that are evaluated from a result, and surfaces that are generated from a study."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from stiction._units import exact_quantity
from stiction.evaluate.point import sort_sliding_rules
from stiction.study.members import generate_phases, generate_unscaled_profile, pair_of
from stiction.summary.evaluation import Evaluation
from stiction.surfaces.fractal import weierstrass_mandelbrot_surface
from stiction.surfaces.profile import Profile

if TYPE_CHECKING:
    import xarray

    from stiction.companions.height_scale import ScaledBodies
    from stiction.study.study import Study
    from stiction.surfaces.surface import Surface

MAX_DRAWN_PROFILES = 5
MAX_DRAWN_CURVES = 8
LENGTH_SCALE_FACTORS = (0.5, 1.0, 2.0)
MAX_SURFACE_SIDE_POINTS = 400
MAX_DRAWN_STRENGTHS = 2
CURVE_LOAD_FRACTIONS = (0.25, 0.5, 0.75)
"""Loads for which the onset of sliding is drawn, as fractions of the load range on a logarithmic scale."""


# ---- Measured surfaces -----------------------------------------------------------------------------------------------


def evaluate_positions(result: Evaluation, point: xarray.Dataset) -> xarray.Dataset:
    """Add the friction coefficient of each surface pair (`member_friction`) to a dataset for one load, mu0 and tau0.

    The variable has the dimensions repetition, direction and sliding.
    """
    load, mu0, tau0 = (float(point[name]) for name in ("load", "mu0", "tau0"))
    members = result.at(load, mu0=mu0, tau0=tau0, per_member=True)
    member_friction = members["friction_coefficient"].isel(cut_off=0, load=0, mu0=0, tau0=0)
    return point.assign(member_friction=member_friction.transpose("repetition", "direction", ...))


def evaluate_positions_at_first_load(result: Evaluation) -> xarray.Dataset:
    """Return friction at the study's first load, mu0 and tau0, including the coefficient of each surface pair."""
    first_load = float(result.study.friction.load[0])
    points = sort_sliding_rules(result.at_study_loads, result.study).isel(cut_off=0, mu0=0, tau0=0)
    return evaluate_positions(result, points.sel(load=first_load, method="nearest"))


def find_opposing_contacts(picture: xarray.Dataset, direction: float) -> NDArray[np.bool_]:
    """Return a mask of the contacts whose slope opposes the motion of the upper body.

    The direction of motion is in degrees from +x towards +y.
    """
    slope_x, slope_y = (picture[f"contact_slope_{axis}"].values for axis in "xy")
    return np.asarray(slope_x * np.cos(np.radians(direction)) + slope_y * np.sin(np.radians(direction)) > 0)


def evaluate_height_factors(
    result: Evaluation, scaled_bodies: ScaledBodies, mu0_index: int = 0, tau0_index: int = 0
) -> xarray.Dataset:
    """Evaluate friction at the study's first load for each factor by which the heights were multiplied.

    Nominal area and area fraction are omitted if the study has no nominal area.
    """
    settings, factors = result.study.friction, result.height_factors[scaled_bodies]
    mu0, tau0 = settings.mu0[mu0_index], float(settings.tau0[tau0_index])
    points = result.at(float(settings.load[0]), mu0=mu0, tau0=tau0, height_scale=factors, scaled=scaled_bodies)
    points = sort_sliding_rules(points.isel(load=0, mu0=0, tau0=0), result.study)
    return remove_undefined_nominal_area(points, result.study)


def remove_undefined_nominal_area(points: xarray.Dataset, study: Study) -> xarray.Dataset:
    """Remove nominal area and area fraction from a dataset if the contact model has no nominal area."""
    names = ["nominal_area", "contact_area_fraction"]
    return points if study.has_nominal_area else points.drop_vars(names, errors="ignore")


# ---- Generated surfaces ----------------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class FrictionOverDimension:
    """Friction of generated surfaces as a function of fractal dimension, for one mu0 and at most two tau0.

    Attributes
    ----------
    study : Study
    map_points : xarray.Dataset
        Result of `Result.at` at loads that cover the load range of the result.
    curve_points : xarray.Dataset
        Result of `Result.at` at a load that 90 % of the combinations of fractal dimension and amplitude reach.
    strengths : list of str
        Values of tau0 with units.
    """

    study: Study
    map_points: xarray.Dataset
    curve_points: xarray.Dataset
    strengths: list[str]


def iterate_motions(result: Evaluation) -> Iterator[tuple[str, Evaluation]]:
    """Yield the part of a result for each sliding rule and direction of motion, with a suffix for file names."""
    dims = [dim for dim in ("sliding", "direction") if dim in result.head.dims]
    if not dims:
        yield "", result
        return
    for index in np.ndindex(*(result.head.sizes[dim] for dim in dims)):
        selection = result.dataset.isel(dict(zip(dims, index, strict=True)))
        names = [f"{selection[dim].item():g}" if dim == "direction" else str(selection[dim].item()) for dim in dims]
        yield "".join(f"_{name}" for name in names), Evaluation(selection)


def evaluate_friction_over_dimension(result: Evaluation, mu0: Sequence[float]) -> list[FrictionOverDimension]:
    """Evaluate friction of generated surfaces over the fractal dimension, for each mu0 and for at most two tau0."""
    strengths = list(result.study.friction.tau0)
    strengths = strengths if len(strengths) <= MAX_DRAWN_STRENGTHS else [strengths[0], strengths[-1]]
    loads = result.reached_loads()
    curve_load = _find_commonly_reached_load(result, float(loads[0]))
    tau0 = [float(strength) for strength in strengths]
    points = result.at([*loads, curve_load], mu0=mu0, tau0=tau0, quantities=["share_beyond_hertz"])
    map_points, curve_points = points.sel(load=loads), points.sel(load=curve_load)
    strength_texts = [strength.text for strength in strengths]
    return [
        FrictionOverDimension(result.study, map_points.isel(mu0=index), curve_points.isel(mu0=index), strength_texts)
        for index in range(len(mu0))
    ]


def _find_commonly_reached_load(result: Evaluation, lowest: float) -> float:
    """Return a load (mN) that 90 % of the combinations of fractal dimension and amplitude reach or exceed.

    The load is a power of 10, unless this power would be below `lowest` (mN). The load is at least `lowest`, even if
    fewer combinations reach `lowest`.
    """
    highest_loads = result.mean_elastic_loads.max(result.study.step_quantity).values
    common_load = float(np.quantile(highest_loads[highest_loads > 0], 0.1))
    power_of_ten = 10.0 ** np.floor(np.log10(0.9 * common_load))
    return float(power_of_ten if power_of_ten >= lowest else max(common_load, lowest))


def evaluate_area_over_load(result: Evaluation) -> xarray.Dataset:
    """Evaluate the true area of generated surfaces over the load range, for the first mu0 and tau0 of the study.

    The dataset contains at most `MAX_DRAWN_CURVES` fractal dimensions.
    """
    settings = result.study.friction
    mu0, tau0 = settings.mu0[0], float(settings.tau0[0])
    points = result.at(
        result.reached_loads(), mu0=mu0, tau0=tau0, quantities=["contact_area", "share_beyond_hertz"]
    ).isel(mu0=0, tau0=0)
    return points.isel(fractal_dimension=_evenly_spaced_indices(points.sizes["fractal_dimension"], MAX_DRAWN_CURVES))


def evaluate_onset_over_dimension(result: Evaluation) -> xarray.Dataset | None:
    """Evaluate the onset of sliding of generated surfaces at a few loads, with mu0 and tau0 from `contact.onset`.

    Returns None if the study computes no onset. Raises a `ValueError` if no pair is in contact.
    """
    study = result.study
    if study.uses_half_space or study.contact.onset is None:
        return None
    settings = study.contact.onset
    smallest_log_load, largest_log_load = np.log(result.reached_loads(2))
    loads = np.unique(
        [
            float(f"{np.exp(smallest_log_load + fraction * (largest_log_load - smallest_log_load)):.0e}")
            for fraction in CURVE_LOAD_FRACTIONS
        ]
    )
    return result.at(loads, mu0=settings.mu0, tau0=float(settings.tau0)).isel(mu0=0, tau0=0)


# ---- Surfaces of a study ---------------------------------------------------------------------------------------------


def generate_profiles(study: Study) -> dict[float, Profile]:
    """Generate profiles for several fractal dimensions of a study, all with the same random phases."""
    surfaces: Any = study.surfaces
    dimensions, amplitude = surfaces.fractal_dimensions(), float(surfaces.amplitudes()[0])
    drawn_dimensions = dimensions[_evenly_spaced_indices(dimensions.size, MAX_DRAWN_PROFILES)]
    profiles = {}
    for dimension in drawn_dimensions.tolist():
        _, profile = pair_of(study, 0, fractal_dimension=dimension, amplitude=amplitude)
        assert isinstance(profile, Profile), "only studies of profiles have this figure"
        profiles[dimension] = profile
    return profiles


def generate_bodies_by_length_scale(study: Study) -> dict[float, tuple[Profile, Surface]]:
    """Generate a profile and a map (Eq. 1 of the paper) for each length scale (µm), all with equal random phases.

    The heights of the profiles are not scaled to the amplitude of the study.
    """
    surfaces: Any = study.surfaces
    dimension = surfaces.fractal_dimensions()[0]
    num_points = int(min(MAX_SURFACE_SIDE_POINTS, surfaces.points))
    bodies = {}
    for length_scale in (factor * float(surfaces.length_scale) for factor in LENGTH_SCALE_FACTORS):
        scaled_study = study.with_changes({"surfaces.length_scale": exact_quantity(length_scale, "um")})
        profile = generate_unscaled_profile(scaled_study, 0, "lower", dimension)
        surface = weierstrass_mandelbrot_surface(
            generate_phases(study, 0, "lower"),
            dimension,
            shape=(num_points, num_points),
            extent=float(surfaces.extent),
            length_scale=length_scale,
            gamma=surfaces.gamma,
            convention=surfaces.convention,
            band_limit="nyquist",
        )
        bodies[length_scale] = profile, surface
    return bodies


def _evenly_spaced_indices(count: int, max_count: int) -> NDArray[np.intp]:
    """Return at most `max_count` evenly spaced indices from 0 to `count` - 1, including both ends."""
    return np.unique(np.linspace(0, count - 1, min(max_count, count)).round().astype(np.intp))
