"""Fit the exponent of the area of yielding contacts to maps, profiles and balls: generated/yielding_exponent.md.

    python docs/scripts/yielding_exponent.py [DIRECTORY] [FINITE_ELEMENTS]

Rough height maps and balls of an elastic-plastic half-space are pressed by a rigid flat. tamaas computes the true area.
Results are stored in DIRECTORY (build/yielding_exponent), one JSON file for each case. Missing results are computed,
which takes about half an hour on one core. Results of profiles are those of yielding_area.py in the directory
FINITE_ELEMENTS (build/yielding_area). Young's modulus is the unit of stress, the side of the periodic cell is the unit
of length, and Poisson's ratio is 0.3.
"""

import json
import math
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import tamaas
import yielding_area
from stiction import Surface, half_space
from tamaas.nonlinear_solvers import DFSANECXXSolver
from yielding_area import (
    BALL_HARDNESS_FACTOR,
    EFFECTIVE_MODULUS,
    MAX_RMS_SLOPE,
    ONSET_OF_YIELD,
    POISSON_RATIO,
    YIELD_EXPONENTS_WITH_ONSET,
    combine_areas_by_power,
    combine_areas_from_onset,
)  # fmt: skip

DOCS_DIRECTORY = Path(__file__).parents[1]

NUM_FINE_POINTS = 160
"""Points per side of the grid on which the half-space model is solved."""
EDGE_CORRECTION = (math.pi - 1 + math.log(2)) / 24
"""Fraction of a grid cell that is subtracted from the contact area for each side between contact and gap."""
MIN_NUM_POINTS = 60
"""Minimum number of points in contact for a comparison of the area of a ball."""
AREA_FRACTION_RANGE = (0.02, 0.4)
"""Smallest and largest area fraction A/A0 for which areas are included in the fit of an exponent."""
MIN_NUM_LOADS = 3
"""Minimum number of loads that the fit of an exponent requires."""
TRIAL_EXPONENTS = np.geomspace(0.3, 8.0, 800)


# ---- Cases ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RoughMap:
    """Periodic map with random phases and a range of wave numbers (periods per side of the cell)."""

    seed: int
    wave_numbers: tuple[float, float]
    relative_modulus: float
    """E* h'/(2 H), where h' is the rms slope: about 1.2 times the pressure ratio x."""
    area_fractions: tuple[float, ...] = (0.08, 0.16, 0.24, 0.34)
    """Area fractions A/A0 by the closed form at the computed loads."""
    num_points: int = 32
    num_layers: int = 14
    depth: float = 0.35
    hurst: float = 0.8
    rms_slope: float = 0.05

    @property
    def hardness(self) -> float:
        return EFFECTIVE_MODULUS * self.rms_slope / 2 / self.relative_modulus

    def heights(self, num_points: int) -> np.ndarray:
        min_wave_number, max_wave_number = self.wave_numbers
        axis_wave_numbers = np.arange(-math.floor(max_wave_number), math.floor(max_wave_number) + 1)
        radius = np.hypot(*np.meshgrid(axis_wave_numbers, axis_wave_numbers))
        real_parts, imaginary_parts = np.random.default_rng(self.seed).normal(size=(2, *radius.shape))
        is_in_range = (radius >= min_wave_number) & (radius <= max_wave_number)
        amplitudes = np.where(is_in_range, real_parts + 1j * imaginary_parts, 0) * np.where(
            is_in_range, radius, 1
        ) ** -(self.hurst + 1)
        fourier_factors = np.exp(2j * np.pi * np.multiply.outer(np.arange(num_points) / num_points, axis_wave_numbers))
        slopes = [
            fourier_factors @ (2j * np.pi * factor * amplitudes) @ fourier_factors.T
            for factor in (axis_wave_numbers, axis_wave_numbers[:, np.newaxis])
        ]
        rms_slope = math.sqrt(sum(float(np.mean(slope.real**2)) for slope in slopes))
        return (fourier_factors @ amplitudes @ fourier_factors.T).real * self.rms_slope / rms_slope

    def choose_pressures(self) -> np.ndarray:
        """Return the mean pressures at which the closed form gives the area fractions of the case."""
        pressures = np.geomspace(0.005, 0.5, 16) * EFFECTIVE_MODULUS * self.rms_slope
        pressures = pressures[pressures < self.hardness]
        elastic, _, _ = solve_half_space(self, pressures, num_points=128)
        areas = combine_areas_from_onset(elastic, pressures / self.hardness, 1.25)
        return np.exp(np.interp(np.log(self.area_fractions), np.log(areas), np.log(pressures)))


@dataclass(frozen=True)
class PeriodicBall:
    """Parabola of revolution in the middle of a cell that is repeated periodically."""

    radius: float
    num_points: int = 32
    num_layers: int = 14
    depth: float = 0.4
    hardness: float = 0.002 * BALL_HARDNESS_FACTOR

    def heights(self, num_points: int) -> np.ndarray:
        x = np.arange(num_points) / num_points - 0.5
        return -np.add.outer(x**2, x**2) / (2 * self.radius)

    def choose_pressures(self) -> np.ndarray:
        return np.array([0.02, 0.04, 0.07, 0.11]) * self.hardness


CASES: dict[str, RoughMap | PeriodicBall] = {
    "map 1": RoughMap(1, (1, 2), relative_modulus=1.2),
    "map 2": RoughMap(2, (1, 2), relative_modulus=2.0),
    "map 3": RoughMap(3, (1, 2.3), relative_modulus=1.0),
    "map 4": RoughMap(4, (1, 2.3), relative_modulus=1.5),
    "map 5": RoughMap(5, (2, 4), 1.4, area_fractions=(0.12,), num_points=40, num_layers=10, depth=0.25),
    "map 6": RoughMap(6, (1, 2.3), relative_modulus=0.9),
    "map 4, deeper": RoughMap(4, (1, 2.3), 1.5, area_fractions=(0.16, 0.34), num_layers=24, depth=0.5),
    "ball, light": PeriodicBall(radius=14.0),
    "ball, heavy": PeriodicBall(radius=4.0),
}


# ---- True areas by tamaas -------------------------------------------------------------------------------------------


def measure_area_fraction(contact: np.ndarray) -> float:
    """Return the area fraction A/A0 of the points in contact, corrected at the edges of contacts."""
    num_sides = sum(int((contact != np.roll(contact, 1, axis)).sum()) for axis in (0, 1))
    return float(contact.sum() - EDGE_CORRECTION * num_sides) / contact.size


def run_case(case: RoughMap | PeriodicBall) -> dict[str, list[float]]:
    """Return mean pressures, A/A0 of the elastic-plastic solid, and A/A0 of the elastic solid on the same grid."""
    tamaas.set_log_level(tamaas.LogLevel.error)
    yield_strength = case.hardness / BALL_HARDNESS_FACTOR
    num_points = case.num_points
    heights = case.heights(num_points)
    plastic_solid = tamaas.Model(
        tamaas.model_type.volume_2d, [case.depth, 1.0, 1.0], [case.num_layers, num_points, num_points]
    )
    elastic_solid = tamaas.Model(tamaas.model_type.basic_2d, [1.0, 1.0], [num_points, num_points])
    for model in (plastic_solid, elastic_solid):
        model.E, model.nu = 1.0, POISSON_RATIO
    material = tamaas.materials.IsotropicHardening(plastic_solid, yield_strength, 0.01 * yield_strength)
    residual = tamaas.Residual(plastic_solid, material)
    plastic_solver = DFSANECXXSolver(residual)
    plastic_solver.tolerance = 1e-5 * yield_strength
    constraint_kind = tamaas.PolonskyKeerRey.pressure
    # Pass a copy, because the solver of tamaas changes the array of heights.
    contact_solver = tamaas.PolonskyKeerRey(plastic_solid, heights.copy(), 1e-10, constraint_kind, constraint_kind)
    coupled_solver = tamaas.AndersonMixing(contact_solver, plastic_solver, 1e-5)
    elastic_solver = tamaas.PolonskyKeerRey(elastic_solid, heights.copy(), 1e-10)
    result: dict[str, list[float]] = {"pressure": [], "area": [], "elastic_area": []}
    for pressure in case.choose_pressures():
        coupled_solver.solve(float(pressure))  # `solve` also updates the plastic strain of the solid
        elastic_solver.solve(float(pressure))
        result["pressure"].append(float(pressure))
        result["area"].append(measure_area_fraction(plastic_solid.traction[..., 2] > 0))
        result["elastic_area"].append(measure_area_fraction(elastic_solid.traction > 0))
    return result


def load_result(name: str, directory: Path) -> dict[str, list[float]]:
    """Return the stored result of a case. If it is missing, compute and store it."""
    path = directory / f"{name.replace(', ', '_').replace(' ', '_')}.json"
    if not path.exists():
        path.write_text(json.dumps(run_case(CASES[name])), encoding="utf-8")
    return json.loads(path.read_text("utf-8"))


# ---- Areas by models and exponents ----------------------------------------------------------------------------------


def solve_half_space(
    case: RoughMap | PeriodicBall, pressures: np.ndarray, num_points: int = NUM_FINE_POINTS
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return three arrays: elastic A/A0, A/A0 with limited pressure, and number of elastic contact patches."""
    if isinstance(case, PeriodicBall):
        elastic = math.pi * (3 * pressures * case.radius / (4 * EFFECTIVE_MODULUS)) ** (2 / 3)
        return elastic, np.full(pressures.size, math.nan), np.ones(pressures.size, dtype=int)
    lower = Surface(case.heights(num_points), spacing=1 / num_points)
    upper = Surface(np.zeros((num_points, num_points)), spacing=1 / num_points)
    options = {"effective_modulus": EFFECTIVE_MODULUS, "boundary": "periodic", "sliding": "all"}
    curve = half_space(upper, lower, pressures, **options)
    capped = half_space(upper, lower, pressures, hardness=case.hardness, **options)
    num_patches = np.array([int(curve.contact(k).patches.max()) for k in range(pressures.size)])
    return curve.contact_area, capped.contact_area, num_patches


@dataclass(frozen=True)
class AreasOfOneCase:
    """Areas of a case over the load (elastic, F/H, true, and with limited pressure), and numbers of contact patches."""

    elastic: np.ndarray
    plastic: np.ndarray
    true: np.ndarray
    capped: np.ndarray
    num_patches: np.ndarray

    def select(self, is_selected: np.ndarray) -> "AreasOfOneCase":
        return AreasOfOneCase(*(values[is_selected] for values in vars(self).values()))

    @property
    def pressure_ratio(self) -> np.ndarray:
        return self.plastic / self.elastic

    def deviations(self, combine: Callable[[np.ndarray, np.ndarray, float], np.ndarray], exponent: float) -> np.ndarray:
        """Return the logarithm of the area by a closed form divided by the true area, for each load."""
        return np.log(combine(self.elastic, self.plastic, exponent) / self.true)

    def fit_exponent(self) -> float:
        """Return the exponent m with the smallest mean squared deviation of the closed form."""
        mean_squared_deviations = [
            float(np.mean(self.deviations(combine_areas_from_onset, m) ** 2)) for m in TRIAL_EXPONENTS
        ]
        return float(TRIAL_EXPONENTS[int(np.argmin(mean_squared_deviations))])


def find_map_areas(case: RoughMap | PeriodicBall, result: dict[str, list[float]]) -> AreasOfOneCase:
    """Return the areas of a map divided by A0.

    True areas are corrected for the error of the elastic area on the grid.
    """
    pressures, true_areas, elastic_areas_on_grid = (
        np.array(result[key]) for key in ("pressure", "area", "elastic_area")
    )
    elastic_areas, capped_areas, num_patches = solve_half_space(case, pressures)
    if isinstance(case, RoughMap):
        true_areas = true_areas * elastic_areas / elastic_areas_on_grid
    areas = AreasOfOneCase(elastic_areas, pressures / case.hardness, true_areas, capped_areas, num_patches)
    return areas if isinstance(case, RoughMap) else areas.select(true_areas * case.num_points**2 >= MIN_NUM_POINTS)


def find_finite_element_areas(case: yielding_area.FiniteElementCase, result: dict[str, list[float]]) -> AreasOfOneCase:
    """Return the areas of a case of yielding_area.py at all loads at which it yields and its area is moderate."""
    loads, true_areas = (np.array(result[key]) for key in ("load", "area_edges"))
    min_fraction, max_fraction = AREA_FRACTION_RANGE
    if isinstance(case, yielding_area.PressedBall):
        max_fraction = math.inf
    fractions = true_areas / case.nominal_area
    is_selected = (fractions > min_fraction) & (fractions < max_fraction)
    loads, true_areas = loads[is_selected], true_areas[is_selected]
    half_space_areas = yielding_area.solve_half_space(case, loads)
    num_patches = np.array([len(forces) for forces, _ in half_space_areas.patches])
    areas = AreasOfOneCase(
        half_space_areas.elastic, loads / case.hardness, true_areas, half_space_areas.capped, num_patches
    )
    return areas.select(areas.pressure_ratio > ONSET_OF_YIELD)


# ---- Tables ---------------------------------------------------------------------------------------------------------


def format_loads(areas: dict[str, AreasOfOneCase]) -> list[str]:
    titles = ["case", "x", "A/A0", "patches", "A/A_el", "pressure cap", "n = 2", "n = 2.25"]
    titles += [f"m = {m:g}" for m in YIELD_EXPONENTS_WITH_ONSET]
    rows = [f"| {' | '.join(titles)} |", "|" + "---|" * len(titles)]
    for name, case_areas in areas.items():
        area_ratios = [np.exp(case_areas.deviations(combine_areas_by_power, n)) for n in (2, 2.25)]
        area_ratios += [np.exp(case_areas.deviations(combine_areas_from_onset, m)) for m in YIELD_EXPONENTS_WITH_ONSET]
        for k, true in enumerate(case_areas.true):
            capped = case_areas.capped[k] / true
            ratios = [
                "" if math.isnan(capped) else f"{capped:.2f}",
                *(f"{area_ratio[k]:.2f}" for area_ratio in area_ratios),
            ]
            rows.append(
                f"| {name} | {case_areas.pressure_ratio[k]:.2f} | {true:.3f} | {case_areas.num_patches[k]} "
                f"| {true / case_areas.elastic[k]:.2f} | {' | '.join(ratios)} |"
            )
    return rows


def format_exponents(areas: dict[str, AreasOfOneCase]) -> list[str]:
    rows = [
        "| case | loads | x | m | rms deviation at this m | mean, m = 1.15 | lowest | highest |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, case_areas in areas.items():
        exponent = case_areas.fit_exponent()
        rms_deviation = math.sqrt(float(np.mean(case_areas.deviations(combine_areas_from_onset, exponent) ** 2)))
        ratios = np.exp(case_areas.deviations(combine_areas_from_onset, 1.15))
        x = case_areas.pressure_ratio
        rows.append(
            f"| {name} | {x.size} | {x.min():.2f} to {x.max():.2f} | {exponent:.2f} | {100 * rms_deviation:.1f} % "
            f"| {ratios.mean():.2f} | {ratios.min():.2f} | {ratios.max():.2f} |"
        )
    return rows


def format_summary(groups: dict[str, dict[str, AreasOfOneCase]]) -> list[str]:
    rows = [
        "| cases | number | mean m | standard deviation | lowest | highest | within 1 to 1.5 | within 0.7 to 1.6 |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for title, group in groups.items():
        exponents = np.array([areas.fit_exponent() for areas in group.values()])
        fractions_inside = [
            float(np.mean((exponents >= low) & (exponents <= high))) for low, high in ((1, 1.5), (0.7, 1.6))
        ]
        deviation = exponents.std(ddof=1)
        rows.append(
            f"| {title} | {exponents.size} | {exponents.mean():.2f} | {deviation:.2f} | {exponents.min():.2f} "
            f"| {exponents.max():.2f} | {100 * fractions_inside[0]:.0f} % | {100 * fractions_inside[1]:.0f} % |"
        )
    return rows


def format_layer_depth_comparison(results: dict[str, dict[str, list[float]]]) -> list[str]:
    rows = ["| case | A/A0 | A/A0 with more and deeper layers |", "|---|---|---|"]
    name = "map 4"
    areas, deeper_areas = (results[key]["area"] for key in (name, f"{name}, deeper"))
    pressures, deeper_pressures = (results[key]["pressure"] for key in (name, f"{name}, deeper"))
    for pressure, area in zip(deeper_pressures, deeper_areas, strict=True):
        k = int(np.argmin(np.abs(np.array(pressures) - pressure)))
        rows.append(f"| {name} | {areas[k]:.3f} | {area:.3f} |")
    return rows


def main(directory: Path, finite_elements: Path) -> None:
    directory.mkdir(parents=True, exist_ok=True)
    results = {name: load_result(name, directory) for name in CASES}
    maps = {name: find_map_areas(CASES[name], result) for name, result in results.items() if "deeper" not in name}
    fitted_areas = {name: areas for name, areas in maps.items() if areas.true.size >= MIN_NUM_LOADS}
    profiles = {}
    for name, case in yielding_area.CASES.items():
        result = yielding_area.load_result(name, finite_elements)
        if result is None or case.yield_strength >= 1 or name.endswith(("hardening", "fine")):
            continue
        areas = find_finite_element_areas(case, result)
        if areas.true.size >= MIN_NUM_LOADS:
            profiles[name] = areas
    flat_profiles = {name: areas for name, areas in profiles.items() if yielding_area.classify_case(name) == "profile"}
    balls = {
        f"{kind}: {name}": areas
        for kind, group in (("tamaas", fitted_areas), ("CalculiX", profiles))
        for name, areas in group.items()
        if name.startswith("ball")
    }
    rough_maps = {name: areas for name, areas in fitted_areas.items() if name.startswith("map")}
    text = [
        "Height maps and balls by tamaas: areas divided by the true area. x is the mean pressure of the elastic "
        "contact divided by the hardness, at equal load.\n",
        *format_loads(maps),
        "\nExponent m of each case, fitted to the loads with x above 0.5 and A/A0 between 0.02 and 0.4; the last three "
        "columns contain the area with m = 1.15 divided by the true area. Cases without a program were computed with "
        "tamaas; cases with fewer than three loads are left out.\n",
        *format_exponents(fitted_areas | {f"{name} (CalculiX)": areas for name, areas in profiles.items()}),
        "\nExponents of the cases.\n",
        *format_summary(
            {
                "maps": rough_maps,
                f"profiles, rms slope up to {MAX_RMS_SLOPE:g}": flat_profiles,
                "balls": balls,
                "maps, profiles and balls": rough_maps | flat_profiles | balls,
            }
        ),
        "\nA/A0 of a map with 14 layers in a depth of 0.35, and with 24 layers in a depth of 0.5.\n",
        *format_layer_depth_comparison(results),
        "",
    ]
    (DOCS_DIRECTORY / "generated/yielding_exponent.md").write_text("\n".join(text), encoding="utf-8")


if __name__ == "__main__":
    build_directory = DOCS_DIRECTORY.parent / "build"
    default_directories = [build_directory / "yielding_exponent", build_directory / "yielding_area"]
    main(
        *(
            Path(sys.argv[k + 1]) if len(sys.argv) > k + 1 else default_directory
            for k, default_directory in enumerate(default_directories)
        )
    )
