"""Compare areas of yielding contacts with finite elements: images/yielding_area.png, generated/yielding_area.md, .csv.

    python docs/scripts/yielding_area.py [DIRECTORY] [CASE ...]

Rough profiles and a ball of an elastic-plastic solid are pressed by a rigid flat. CalculiX (`ccx`) computes the true
area. Results are stored in DIRECTORY (build/yielding_area), one JSON file for each case. Missing results are computed,
which takes half an hour on one core. If names of cases are given, only these cases are computed. Young's modulus is the
unit of stress, and Poisson's ratio is 0.3.
"""

import csv
import json
import math
import os
import re
import shutil
import subprocess
import sys
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from stiction import JacksonGreen, Profile, Surface, force_and_area, half_space, self_affine, self_affine_surface
from stiction.mechanics.hardness import yielded_area

DOCS_DIRECTORY = Path(__file__).parents[1]

POISSON_RATIO = 0.3
EFFECTIVE_MODULUS = 1 / (1 - POISSON_RATIO**2)
CONSTRAINED_MODULUS = (1 - POISSON_RATIO) / ((1 + POISSON_RATIO) * (1 - 2 * POISSON_RATIO))
"""Constrained modulus of the solid: stress per strain if the lateral strain is 0."""
PROFILE_HARDNESS_FACTOR = (2 + math.pi) / math.sqrt(3)
"""Hardness divided by yield strength for a flat punch in plane strain (Prandtl)."""
BALL_HARDNESS_FACTOR = 2.84
"""Hardness divided by yield strength for a ball (Jackson & Green 2005)."""
CONTACT_STIFFNESS = 30.0
"""Stiffness of the contact springs (pressure per overlap), times the width of the smallest element."""
SPRING_LENGTH = 10.0
NUM_WEDGES = 180
"""Number of equal wedges into which an axisymmetric solid is divided. CalculiX computes a single wedge."""
MAX_AREA_FRACTION = 0.4
"""Area fraction A/A0 at the largest load of a case, in the half-space model with limited pressure."""
AREA_FRACTIONS = (0.02, 0.04, 0.07, 0.11, 0.16, 0.22, 0.3, 0.4, 0.55, 0.75, 1.0)
"""Area fractions A/A0 at which areas are compared."""
MAX_RMS_SLOPE = 0.1
"""Largest rms slope for which the hardness of a flat surface certainly applies."""
MAX_COMPARED_FRACTION = 0.42
"""Largest A/A0 for which areas are included in summaries."""
ONSET_OF_YIELD = 0.5
"""Mean pressure divided by hardness above which yielding below the surface adds area."""
YIELD_EXPONENTS_WITHOUT_ONSET = (2.0, 2.25, 2.5)
YIELD_EXPONENTS_WITH_ONSET = (0.7, 1.0, 1.15, 1.25, 1.6)
"""Exponents m: the limits and the centre of the default range of `pair`, and two values in between."""
USED_AREA_FORM_TITLE = "m = 1.15"
AREA_FORM_TITLES = {
    "pressure cap": "pressure cap",
    USED_AREA_FORM_TITLE: f"from the onset of yield, {USED_AREA_FORM_TITLE}",
}
SEED = 2016
CCX = shutil.which("ccx")


# ---- Cases ----------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class RoughProfile:
    """Rough profile between two mirror planes, in plane strain."""

    seed: int
    hurst: float
    rms_slope: float
    yield_strength: float
    tangent_modulus: float = 0.0
    refinement: int = 1
    length: float = 64.0
    max_wave_number: int = 10
    depth: float = 48.0

    @property
    def hardness(self) -> float:
        return PROFILE_HARDNESS_FACTOR * self.yield_strength

    def amplitudes(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the wave numbers (half periods per length) and the amplitudes of the cosines that form the profile."""
        wave_numbers = np.arange(round(self.length / 32), self.max_wave_number + 1)
        amplitudes = np.random.default_rng(self.seed).normal(size=wave_numbers.size)
        amplitudes *= wave_numbers ** -(self.hurst + 0.5)
        slope = math.sqrt(float(np.sum((amplitudes * np.pi * wave_numbers / self.length) ** 2)) / 2)
        return wave_numbers, amplitudes * self.rms_slope / slope

    def heights(self, x: np.ndarray) -> np.ndarray:
        wave_numbers, amplitudes = self.amplitudes()
        return np.cos(np.pi * np.multiply.outer(x, wave_numbers) / self.length) @ amplitudes

    def columns(self) -> np.ndarray:
        """Return the element boundaries along x, which are four times denser in the upper half of the heights."""
        x = np.linspace(0, self.length, round(62.5 * self.length) + 1)
        heights = self.heights(x)
        density = np.where(heights > np.quantile(heights, 0.55), 4.0, 1.0)
        density = np.convolve(np.pad(density, 100, mode="edge"), np.full(201, 1 / 201), mode="valid")
        position = np.concatenate([[0], np.cumsum((density[1:] + density[:-1]) / 2)])
        return np.interp(np.linspace(0, position[-1], round(1.125 * self.length) * self.refinement + 1), position, x)

    def rows(self) -> np.ndarray:
        """Return the depths of the element boundaries below the surface."""
        num_rows = 13 * self.refinement
        depths = np.cumsum(1.28 ** (np.arange(num_rows) / self.refinement))
        return np.concatenate([[0], depths / depths[-1] * self.depth])

    def bodies(self, num_points: int = 8192) -> tuple[Profile, Profile]:
        """Return the rigid flat and the profile with its mirror image."""
        spacing = 2 * self.length / num_points
        heights = self.heights(np.arange(num_points) * spacing)
        return Profile(np.zeros(num_points), spacing=spacing), Profile(heights, spacing=spacing)

    @property
    def nominal_area(self) -> float:
        return self.length


@dataclass(frozen=True)
class PressedBall:
    """Ball pressed by a flat: a parabola of revolution."""

    yield_strength: float
    max_relative_pressure: float = 3.0
    refinement: int = 1
    tangent_modulus: float = 0.0
    radius: float = 500.0

    @property
    def hardness(self) -> float:
        return BALL_HARDNESS_FACTOR * self.yield_strength

    @property
    def max_radius(self) -> float:
        """Contact radius at the largest load, if the mean pressure is the hardness."""
        elastic_radius = self.max_relative_pressure * self.hardness * 3 * math.pi / (4 * EFFECTIVE_MODULUS)
        elastic_radius *= self.radius
        return elastic_radius * math.sqrt(self.max_relative_pressure)

    @property
    def nominal_area(self) -> float:
        return math.pi * self.max_radius**2

    @property
    def depth(self) -> float:
        return 12 * self.max_radius

    def heights(self, x: np.ndarray) -> np.ndarray:
        return -(x**2) / (2 * self.radius)

    def columns(self) -> np.ndarray:
        inner_positions = np.linspace(0, 1.25, 36 * self.refinement + 1)
        outer_positions = np.geomspace(1.25, 12, 12 * self.refinement + 1)[1:]
        return np.concatenate([inner_positions, outer_positions]) * self.max_radius

    def rows(self) -> np.ndarray:
        depths = np.cumsum(1.23 ** (np.arange(19 * self.refinement) / self.refinement))
        return np.concatenate([[0], depths / depths[-1] * self.depth])


FiniteElementCase = RoughProfile | PressedBall

CASES: dict[str, FiniteElementCase] = {
    "elastic": RoughProfile(seed=1, hurst=0.8, rms_slope=0.05, yield_strength=10.0),
    "profile 1": RoughProfile(seed=11, hurst=0.8, rms_slope=0.03, yield_strength=0.02),
    "profile 2": RoughProfile(seed=12, hurst=0.7, rms_slope=0.06, yield_strength=0.02),
    "profile 3": RoughProfile(seed=13, hurst=0.5, rms_slope=0.05, yield_strength=0.01),
    "profile 4": RoughProfile(seed=14, hurst=0.9, rms_slope=0.1, yield_strength=0.02),
    "profile 5": RoughProfile(seed=15, hurst=0.6, rms_slope=0.06, yield_strength=0.003),
    "profile 6": RoughProfile(seed=16, hurst=0.7, rms_slope=0.2, yield_strength=0.02),
    "profile 7": RoughProfile(seed=17, hurst=0.9, rms_slope=0.12, yield_strength=0.005),
    "profile 8": RoughProfile(seed=18, hurst=0.8, rms_slope=0.04, yield_strength=0.01),
    "profile 9": RoughProfile(seed=19, hurst=0.7, rms_slope=0.05, yield_strength=0.003),
    "profile 10": RoughProfile(seed=20, hurst=0.5, rms_slope=0.04, yield_strength=0.003, max_wave_number=14),
    "profile 11": RoughProfile(31, hurst=0.7, rms_slope=0.05, yield_strength=0.006, length=192.0, max_wave_number=30),
    "profile 12": RoughProfile(32, hurst=0.8, rms_slope=0.05, yield_strength=0.003, length=192.0, max_wave_number=30),
    "profile 3, hardening": RoughProfile(seed=13, hurst=0.5, rms_slope=0.05, yield_strength=0.01, tangent_modulus=0.05),
    "profile 6, hardening": RoughProfile(seed=16, hurst=0.7, rms_slope=0.2, yield_strength=0.02, tangent_modulus=0.05),
    "ball": PressedBall(yield_strength=0.002),
    "ball, light": PressedBall(yield_strength=0.002, max_relative_pressure=0.9),
    "profile 7, flatter": RoughProfile(seed=17, hurst=0.9, rms_slope=0.03, yield_strength=0.00125),
    "ball, fine": PressedBall(yield_strength=0.002, refinement=2),
    "profile 3, fine": RoughProfile(seed=13, hurst=0.5, rms_slope=0.05, yield_strength=0.01, refinement=2),
    "profile 6, fine": RoughProfile(seed=16, hurst=0.7, rms_slope=0.2, yield_strength=0.02, refinement=2),
}


# ---- Finite elements ------------------------------------------------------------------------------------------------


class InputFile:
    """Lines of a CalculiX input file, and the numbers of its nodes and elements."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.num_nodes = 0
        self.num_elements = 0

    def add_nodes(self, coordinates: np.ndarray) -> np.ndarray:
        """Add nodes, of shape (n, dimensions), and return their numbers."""
        numbers = self.num_nodes + 1 + np.arange(len(coordinates))
        self.lines.append("*NODE")
        self.lines += [
            ", ".join([str(number), *(f"{value:.10g}" for value in row)])
            for number, row in zip(numbers, coordinates, strict=True)
        ]
        self.num_nodes += len(coordinates)
        return numbers

    def add_elements(self, kind: str, name: str, nodes: np.ndarray) -> None:
        self.lines.append(f"*ELEMENT, TYPE={kind}, ELSET={name}")
        for row in nodes:
            self.num_elements += 1
            self.lines.append(", ".join(map(str, [self.num_elements, *row])))

    def add_node_set(self, name: str, numbers: np.ndarray) -> None:
        self.lines.append(f"*NSET, NSET={name}")
        self.lines += [f"{number}," for number in np.unique(numbers)]

    def add_unilateral_springs(
        self, nodes: np.ndarray, ends: np.ndarray, gaps: np.ndarray, stiffnesses: np.ndarray
    ) -> None:
        """Add springs that push if they are shortened by more than their gap."""
        for k, (node, end, gap, stiffness) in enumerate(zip(nodes, ends, gaps, stiffnesses, strict=True)):
            self.add_elements("SPRINGA", f"SPRING{k}", np.array([[node, end]]))
            self.lines += [
                f"*SPRING, ELSET=SPRING{k}, NONLINEAR",
                "",
                f"{-stiffness:.9e}, {-gap - 1:.9e}",
                f"0., {-gap:.9e}",
                f"0., {SPRING_LENGTH:.1f}",
            ]


def node_weights(case: FiniteElementCase) -> np.ndarray:
    """Return the part of the area that belongs to each node of the pressed surface under a uniform pressure."""
    columns = case.columns()
    weights = np.zeros(2 * columns.size - 1)
    points, point_weights = np.polynomial.legendre.leggauss(3)
    for element, (left_edge, right_edge) in enumerate(pairwise(columns)):
        for point, point_weight in zip(points, point_weights, strict=True):
            shape_functions = np.array([point * (point - 1) / 2, 1 - point**2, point * (point + 1) / 2])
            radius = (left_edge + right_edge) / 2 + point * (right_edge - left_edge) / 2
            circumference = 2 * math.pi * radius / NUM_WEDGES if isinstance(case, PressedBall) else 1.0
            weights[2 * element : 2 * element + 3] += (
                shape_functions * circumference * point_weight * (right_edge - left_edge) / 2
            )
    return np.maximum(weights, 1e-6 * weights.max())


def plane_nodes(columns: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, depth, and a table with the index of the node at (2 column, 2 row), for eight-node elements."""
    x, depth = (np.interp(np.arange(2 * v.size - 1) / 2, np.arange(v.size), v) for v in (columns, rows))
    is_node = np.add.outer(np.arange(x.size) % 2, np.arange(depth.size) % 2) < 2
    table = np.where(is_node, np.cumsum(is_node).reshape(is_node.shape) - 1, -1)
    i, j = np.nonzero(is_node)
    return x[i], depth[j], table


def create_plane_model(case: FiniteElementCase, model: InputFile) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Add the solid to the model, and return the numbers, positions x and heights of its surface nodes."""
    x, depth, table = plane_nodes(case.columns(), case.rows())
    numbers = model.add_nodes(np.column_stack([x, case.heights(x) * (1 - depth / depth.max()) - depth]))
    node = numbers[table]
    i, j = (
        index.ravel()
        for index in np.meshgrid(
            2 * np.arange(len(case.columns()) - 1), 2 * np.arange(len(case.rows()) - 1), indexing="ij"
        )
    )
    corners = [(0, 2), (2, 2), (2, 0), (0, 0), (1, 2), (2, 1), (1, 0), (0, 1)]
    kind = "CAX8R" if isinstance(case, PressedBall) else "CPE8R"
    model.add_elements(kind, "SOLID", np.stack([node[i + a, j + b] for a, b in corners], axis=1))
    sides = [0] if isinstance(case, PressedBall) else [0, -1]
    model.add_node_set("SIDES", np.concatenate([node[side, table[side] >= 0] for side in sides]))
    model.add_node_set("BOTTOM", node[:, -1])
    surface = node[:, 0]
    return surface, x[table[:, 0]], case.heights(x[table[:, 0]])


def write_input(case: FiniteElementCase, approach: float, path: Path) -> None:
    """Write the input file of a case in which the rigid flat approaches the solid by `approach`."""
    model = InputFile()
    surface, x, heights = create_plane_model(case, model)
    spring_ends = model.add_nodes(np.column_stack([x, heights + SPRING_LENGTH]))
    stiffness = CONTACT_STIFFNESS / np.diff(case.columns()).min()
    model.add_unilateral_springs(surface, spring_ends, heights.max() - heights, stiffness * node_weights(case))
    model.add_node_set("SURFACE", surface)
    model.add_node_set("FLAT", spring_ends)
    largest_strain = 2.0
    hardening_modulus = (
        case.tangent_modulus / (1 - case.tangent_modulus) if case.tangent_modulus else 0.01 * case.yield_strength
    )
    model.lines += [
        "*MATERIAL, NAME=METAL", "*ELASTIC", f"1., {POISSON_RATIO}",
        "*PLASTIC", f"{case.yield_strength}, 0.",
        f"{case.yield_strength + hardening_modulus * largest_strain:.8g}, {largest_strain}",
        "*SOLID SECTION, ELSET=SOLID, MATERIAL=METAL", "1.",
        "*BOUNDARY", "SIDES, 1, 1",
        "BOTTOM, 2, 2", "FLAT, 1, 3",
        "*STEP, INC=400", "*STATIC", "0.03, 1., 1e-6, 0.07",
        "*BOUNDARY", f"FLAT, 2, 2, {-approach:.8g}",
        "*NODE PRINT, NSET=FLAT", "RF", "*NODE PRINT, NSET=SURFACE", "U", "*END STEP",
    ]  # fmt: skip
    path.write_text("\n".join(model.lines) + "\n", encoding="utf-8")


def read_output(path: Path, quantity: str, node_set: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the times, and a quantity's vertical component as an array (times, nodes), from a CalculiX data file."""
    pattern = rf" {quantity} \([a-z,]+\) for set {node_set} and time +(\S+)\n\n((?: +\d+ .*\n)+)"
    blocks = re.findall(pattern, path.read_text(encoding="utf-8"))
    tables = [np.array([line.split() for line in block.strip().splitlines()], dtype=float) for _, block in blocks]
    return np.array([float(time) for time, _ in blocks]), np.array([table[:, 2] for table in tables])


def interpolate_contact_length(x: np.ndarray, gap: np.ndarray, contact: np.ndarray, power: float) -> float:
    """Return the length in contact, if the gap beside contacts increases with a power of the distance from the edge."""
    contact_length = 0.0
    contact_starts = np.flatnonzero(np.diff(contact.astype(int), prepend=0) == 1)
    contact_ends = np.flatnonzero(np.diff(contact.astype(int), append=0) == -1)
    for contact_start, contact_end in zip(contact_starts, contact_ends, strict=True):
        contact_length += x[contact_end] - x[contact_start]
        for edge_node, step in ((contact_start, -1), (contact_end, 1)):
            next_node, second_node = edge_node + step, edge_node + 2 * step
            if not 0 <= next_node < x.size:
                continue
            node_distance = abs(x[next_node] - x[edge_node])
            free_length = 0.5 * node_distance
            if 0 <= second_node < x.size and not contact[second_node] and gap[second_node] > gap[next_node] > 0:
                distance_ratio = (gap[second_node] / gap[next_node]) ** (1 / power)
                free_length = abs(x[second_node] - x[next_node]) / (distance_ratio - 1)
            contact_length += node_distance - min(free_length, node_distance)
    return contact_length


def measure_area(case: FiniteElementCase, x: np.ndarray, gap: np.ndarray, force: np.ndarray) -> tuple[float, ...]:
    """Return two estimates of the true area: from nodes that carry a force, and from interpolated contact edges."""
    is_contact = force > 0
    node_boundaries = np.concatenate([[x[0]], (x[1:] + x[:-1]) / 2, [x[-1]]])
    interpolated_length = interpolate_contact_length(x, gap, is_contact, 1.5)
    if isinstance(case, PressedBall):
        return math.pi * node_boundaries[np.flatnonzero(is_contact)[-1] + 1] ** 2, math.pi * interpolated_length**2
    return float(np.diff(node_boundaries)[is_contact].sum()), interpolated_length


def find_approach(case: FiniteElementCase) -> float:
    """Return the approach of the rigid flat at the largest load of a case."""
    if isinstance(case, PressedBall):
        return 0.5 * case.max_radius**2 / case.radius
    is_elastic = case.yield_strength >= 1
    pressures = np.geomspace(0.005, 0.6, 15) * (case.rms_slope if is_elastic else case.hardness)
    upper, lower = case.bodies(1024)
    curve = half_space(
        upper, lower, 2 * case.length * pressures, effective_modulus=EFFECTIVE_MODULUS, boundary="periodic",
        hardness=None if is_elastic else case.hardness,
    )  # fmt: skip
    fractions = curve.contact_area / (2 * case.length)
    pressure = float(np.interp(MAX_AREA_FRACTION, fractions, pressures))
    return 1.1 * float(np.interp(pressure, pressures, curve.approach)) + pressure * case.depth / CONSTRAINED_MODULUS


def run_case(case: FiniteElementCase, directory: Path) -> dict[str, list[float]]:
    """Run CalculiX for a case in a directory, and return the load and the true areas at each increment."""
    directory.mkdir(parents=True, exist_ok=True)
    approach = find_approach(case)
    write_input(case, approach, directory / "case.inp")
    with open(directory / "log", "w", encoding="utf-8") as log:
        subprocess.run(
            [str(CCX), "case"], cwd=directory, stdout=log, stderr=log, check=False,
            env=os.environ | {"OMP_NUM_THREADS": "1"},
        )  # fmt: skip
    return read_result(case, directory, approach)


def read_result(case: FiniteElementCase, directory: Path, approach: float) -> dict[str, list[float]]:
    """Return the load and the true areas at each increment of a computed case."""
    times, reactions = read_output(directory / "case.dat", "forces", "FLAT")
    _, displacements = read_output(directory / "case.dat", "displacements", "SURFACE")
    columns = case.columns()
    x = np.interp(np.arange(2 * columns.size - 1) / 2, np.arange(columns.size), columns)
    heights = case.heights(x)
    num_wedges = NUM_WEDGES if isinstance(case, PressedBall) else 1
    result: dict[str, list[float]] = {"load": [], "area_nodes": [], "area_edges": []}
    for time, reaction, displacement in zip(times, -reactions, displacements, strict=True):
        if not (reaction > 0).any():
            continue
        gap = heights.max() - time * approach - heights - displacement
        areas = measure_area(case, x, gap, reaction)
        for name, value in zip(result, (num_wedges * reaction.sum(), *areas), strict=True):
            result[name].append(float(value))
    if not result["load"]:
        raise RuntimeError(f"CalculiX computed no increment; see {directory / 'log'}")
    return result


def load_result(name: str, directory: Path) -> dict[str, list[float]] | None:
    """Return the stored result of a case.

    If it is missing, compute and store it, provided that CalculiX is installed.
    """
    path = directory / f"{name.replace(', ', '_').replace(' ', '_')}.json"
    if path.exists():
        return json.loads(path.read_text("utf-8"))
    if CCX is None:
        return None
    result = run_case(CASES[name], directory / path.stem)
    path.write_text(json.dumps(result), encoding="utf-8")
    return result


# ---- Half-space areas and closed forms ------------------------------------------------------------------------------


@dataclass(frozen=True)
class HalfSpaceAreas:
    """Areas of the half-space model at the loads of the finite-element results."""

    elastic: np.ndarray
    capped: np.ndarray
    patches: list[tuple[np.ndarray, np.ndarray]]
    """Forces and areas of the elastic contact patches at each load."""


def solve_half_space(case: FiniteElementCase, loads: np.ndarray) -> HalfSpaceAreas:
    options = {"effective_modulus": EFFECTIVE_MODULUS, "sliding": "all"}
    hardness = case.hardness if case.yield_strength < 1 else None
    if isinstance(case, PressedBall):
        elastic_area = math.pi * (3 * loads * case.radius / (4 * EFFECTIVE_MODULUS)) ** (2 / 3)
        num_points = 96
        spacing = 2.6 * math.sqrt(max(elastic_area.max(), loads.max() / case.hardness) / math.pi) / num_points
        x = (np.arange(num_points) - (num_points - 1) / 2) * spacing
        lower = Surface(-np.add.outer(x**2, x**2) / (2 * case.radius), spacing=spacing)
        upper = Surface(np.zeros((num_points, num_points)), spacing=spacing)
        capped_curve = half_space(upper, lower, loads, boundary="free", hardness=hardness, **options)
        patches = [(loads[[k]], elastic_area[[k]]) for k in range(loads.size)]
        return HalfSpaceAreas(elastic_area, capped_curve.contact_area, patches)
    upper, lower = case.bodies()
    num_images = 2
    options["boundary"] = "periodic"
    curve = half_space(upper, lower, num_images * loads, **options)
    capped_curve = half_space(upper, lower, num_images * loads, hardness=hardness, **options)
    patches = []
    for k in range(loads.size):
        contact = curve.contact(k)
        cell_area = math.prod(contact.spacing) / num_images
        force, area = (
            cell_area * np.bincount(contact.patches.ravel(), values.ravel())[1:]
            for values in (contact.pressure, contact.share)
        )
        patches.append((force, area))
    return HalfSpaceAreas(curve.contact_area / num_images, capped_curve.contact_area / num_images, patches)


def combine_areas_by_power(elastic: np.ndarray, plastic: np.ndarray, exponent: float) -> np.ndarray:
    """Return (A_el^m + (F/H)^m)^(1/m), whose limits are the elastic area A_el and the plastic area F/H."""
    return (elastic**exponent + plastic**exponent) ** (1 / exponent)


def combine_areas_from_onset(elastic: np.ndarray, plastic: np.ndarray, exponent: float) -> np.ndarray:
    """Return the elastic area below the onset of yielding, and the area by `yielded_area` above the onset."""
    return yielded_area(elastic, plastic, 1.0, exponent)


@dataclass(frozen=True)
class AreaComparison:
    """True area of a case at one load by finite elements, with areas of other models divided by this area."""

    case: str
    pressure_ratio: float
    area_fraction: float
    num_patches: int
    area_by_nodes: float
    ratios: dict[str, float]


def compare_case(name: str, result: dict[str, list[float]]) -> list[AreaComparison]:
    """Compare the areas of a case at selected loads."""
    case = CASES[name]
    loads, areas, areas_by_nodes = (np.array(result[key]) for key in ("load", "area_edges", "area_nodes"))
    fractions = areas / case.nominal_area
    selected_indices = sorted({int(np.argmin(np.abs(np.log(fractions / target)))) for target in AREA_FRACTIONS})
    half_space_areas = solve_half_space(case, loads[selected_indices])
    comparisons = []
    for k, index in enumerate(selected_indices):
        elastic_area, plastic_area = half_space_areas.elastic[k], loads[index] / case.hardness
        forces, patch_areas = half_space_areas.patches[k]
        areas_by_model = {
            "pressure cap": half_space_areas.capped[k],
            **{
                f"n = {n:g}": combine_areas_by_power(elastic_area, plastic_area, n)
                for n in YIELD_EXPONENTS_WITHOUT_ONSET
            },
            "n = 2.25, per patch": combine_areas_by_power(patch_areas, forces / case.hardness, 2.25).sum(),
            **{
                f"m = {m:g}": combine_areas_from_onset(elastic_area, plastic_area, m)
                for m in YIELD_EXPONENTS_WITH_ONSET
            },
            **{
                f"m = {m:g}, per patch": combine_areas_from_onset(patch_areas, forces / case.hardness, m).sum()
                for m in (1.15, 1.25)
            },
        }
        max_area = math.inf if isinstance(case, PressedBall) else case.nominal_area
        ratios = {key: float(min(value, max_area) / areas[index]) for key, value in areas_by_model.items()}
        comparisons.append(
            AreaComparison(
                name,
                float(plastic_area / elastic_area),
                float(fractions[index]),
                len(forces),
                float(areas_by_nodes[index] / areas[index]),
                ratios,
            )
        )
    return comparisons


def published_ball_fits() -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return x = F/(A_el H) and A/A_el of published fits, for overlaps up to 110 times the overlap at first yield.

    Jackson & Green, Journal of Tribology 127 (2005) 343; Kogut & Etsion, Journal of Applied Mechanics 69 (2002) 657.
    """
    radius, yield_strength = 1.0, 0.002
    overlaps = np.geomspace(2.0, 110.0, 12)
    law = JacksonGreen(yield_strength=yield_strength, poisson_ratio=POISSON_RATIO)
    first_overlap = (math.pi * 1.295 * math.exp(0.736 * POISSON_RATIO) * yield_strength / (2 * EFFECTIVE_MODULUS)) ** 2
    options = {"radius": radius, "effective_modulus": EFFECTIVE_MODULUS}
    loads, areas = np.array([force_and_area(law, overlap=w * first_overlap, **options) for w in overlaps]).T
    result = {"Jackson and Green": normalize_by_hertz(loads, areas, BALL_HARDNESS_FACTOR * yield_strength)}
    hardness = 2.8 * yield_strength
    first_overlap = (math.pi * (0.454 + 0.41 * POISSON_RATIO) * hardness / (2 * EFFECTIVE_MODULUS)) ** 2
    is_small = overlaps < 6
    loads = np.where(is_small, 1.03 * overlaps**1.425, 1.4 * overlaps**1.263)
    loads *= 4 / 3 * EFFECTIVE_MODULUS * first_overlap**1.5
    areas = np.where(is_small, 0.93 * overlaps**1.136, 0.94 * overlaps**1.146) * math.pi * first_overlap
    result["Kogut and Etsion"] = normalize_by_hertz(loads, areas, hardness)
    return result


def normalize_by_hertz(loads: np.ndarray, areas: np.ndarray, hardness: float) -> tuple[np.ndarray, np.ndarray]:
    """Return F/(A_el H) and A/A_el for a ball of radius 1, where A_el is Hertz's area."""
    elastic_areas = math.pi * (3 * loads / (4 * EFFECTIVE_MODULUS)) ** (2 / 3)
    return loads / (elastic_areas * hardness), areas / elastic_areas


# ---- Friction at opposing contacts ----------------------------------------------------------------------------------


def create_rough_pair(kind: str, hurst: float, repetition: int) -> tuple[list[Profile] | list[Surface], float]:
    """Return two periodic surfaces of unit length, each with an rms slope of 0.1, and the rms slope of the gap."""
    options = {"hurst_exponent": hurst, "rms": 1.0, "repetition": repetition}
    if kind == "maps":
        options |= {"shape": (96, 96), "spacing": 1 / 96, "longest_wavelength": 1 / 2, "shortest_wavelength": 1 / 16}
        bodies = [self_affine_surface(SEED, side=side, **options) for side in ("upper", "lower")]
    else:
        options |= {"points": 2048, "spacing": 1 / 2048, "longest_wavelength": 1 / 4, "shortest_wavelength": 1 / 64}
        bodies = [self_affine(SEED, side=side, periodic=True, **options) for side in ("upper", "lower")]
    gap = bodies[0].heights - bodies[1].heights
    slopes = [np.diff(gap, axis=axis, append=np.take(gap, [0], axis)) * len(gap) for axis in range(gap.ndim)]
    factor = 0.1 * math.sqrt(2 / sum(float(np.mean(slope**2)) for slope in slopes))
    return [type(body)(body.heights * factor, spacing=body.spacing) for body in bodies], 0.1 * math.sqrt(2)


def compare_opposing_sums(kind: str, hurst: float, repetition: int) -> list[list[float]]:
    """Compare friction at opposing contacts: scaled elastic solution against the solution with the pressure cap.

    Each row contains x = F/(A_el H), the ratio of the elastic tangential sums (scaled over capped, means over both
    directions), the mean coefficients over both directions (scaled, capped), and the difference of the coefficients
    along +x. The mean area of opposing contacts over both directions is always half of the area.
    """
    bodies, slope = create_rough_pair(kind, hurst, repetition)
    loads = np.array([0.01, 0.03, 0.1]) * slope
    options = {"effective_modulus": 1.0, "boundary": "periodic"}
    elastic_curve = half_space(*bodies, loads, **options)
    rows = []
    for relative_hardness in (0.15, 0.3, 0.6, 1.2):
        hardness = relative_hardness * slope
        capped_curve = half_space(*bodies, loads[loads < 0.5 * hardness], hardness=hardness, **options)
        num_loads = capped_curve.load.size
        area_ratios = capped_curve.contact_area / elastic_curve.contact_area[:num_loads]
        results_by_curve = []
        for curve, area_factor in ((elastic_curve, area_ratios), (capped_curve, 1.0)):
            results_by_direction = []
            for direction in ("+x", "-x"):
                directed_curve = curve.with_direction(direction)
                load_parts = [
                    (directed_curve.tangential_elastic, directed_curve.normal_elastic),
                    (directed_curve.tangential_frictional, directed_curve.normal_frictional),
                    (directed_curve.tangential_adhesive, directed_curve.normal_adhesive),
                ]
                tangential, normal = (
                    np.array([load_part[k][:num_loads] for load_part in load_parts]) for k in range(2)
                )
                tangential[2], normal[2] = tangential[2] * area_factor, normal[2] * area_factor
                part_factors = np.array([1.0, 0.2, 0.05 * hardness])
                results_by_direction.append([*tangential, part_factors @ tangential / (part_factors @ normal)])
            results_by_curve.append(np.array(results_by_direction))
        scaled_means, capped_means = (values.mean(axis=0) for values in results_by_curve)
        pressure_ratio = loads[:num_loads] / elastic_curve.contact_area[:num_loads] / hardness
        difference = results_by_curve[0][0, 3] - results_by_curve[1][0, 3]
        rows += np.vstack(
            [pressure_ratio, scaled_means[0] / capped_means[0], scaled_means[3], capped_means[3], difference]
        ).T.tolist()
    return rows


# ---- Tables and figure ----------------------------------------------------------------------------------------------


def format_cases(points: list[AreaComparison]) -> list[str]:
    rows = [
        "| case | seed | Hurst exponent | rms slope | yield strength / E | tangent modulus / E | x | A/A0 |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name in dict.fromkeys(point.case for point in points):
        case = CASES[name]
        case_points = [point for point in points if point.case == name]
        description = (
            "| | | " if isinstance(case, PressedBall) else f"| {case.seed} | {case.hurst:g} | {case.rms_slope:g} "
        )
        x_range, fraction_range = (
            f"{min(values):.2f} to {max(values):.2f}"
            for values in (
                [point.pressure_ratio for point in case_points],
                [point.area_fraction for point in case_points],
            )
        )
        rows.append(
            f"| {name} {description}| {case.yield_strength:g} | {case.tangent_modulus:g} | {x_range} "
            f"| {'' if isinstance(case, PressedBall) else fraction_range} |"
        )
    return rows


def write_points(points: list[AreaComparison]) -> None:
    """Write areas divided by the finite-element area as CSV, with one row per case and load."""
    names = [name for name in points[0].ratios if name not in ("n = 2", "n = 2.5")]
    with (DOCS_DIRECTORY / "generated/yielding_area.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["case", "x", "A/A0", "patches", "area by nodes", *names])
        for point in points:
            fraction = "" if point.case.startswith("ball") else f"{point.area_fraction:.3f}"
            numbers = [point.area_by_nodes, *(point.ratios[name] for name in names)]
            writer.writerow(
                [point.case, f"{point.pressure_ratio:.2f}", fraction, point.num_patches]
                + [f"{number:.2f}" for number in numbers]
            )


def format_summary(points: list[AreaComparison]) -> list[str]:
    rows = [
        "| model | points | mean | mean deviation | lowest | highest | within 12 % |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in points[0].ratios:
        ratios = np.array([point.ratios[name] for point in points])
        rows.append(
            f"| {name} | {ratios.size} | {ratios.mean():.3f} | {100 * np.abs(ratios - 1).mean():.1f} % "
            f"| {ratios.min():.2f} | {ratios.max():.2f} | {100 * (np.abs(ratios - 1) <= 0.12).mean():.0f} % |"
        )
    return rows


def format_published_fits() -> list[str]:
    rows = ["| fit | form | lowest | highest |", "|---|---|---|---|"]
    for name, (pressure_ratios, area_ratios) in published_ball_fits().items():
        forms = {f"n = {n:g}": combine_areas_by_power(1.0, pressure_ratios, n) for n in (2, 2.25)}
        forms |= {f"m = {m:g}": combine_areas_from_onset(1.0, pressure_ratios, m) for m in YIELD_EXPONENTS_WITH_ONSET}
        for form, areas in forms.items():
            ratios = areas / area_ratios
            rows.append(f"| {name} | {form} | {ratios.min():.2f} | {ratios.max():.2f} |")
    return rows


def format_convergence(results: dict[str, dict[str, list[float]]]) -> list[str]:
    rows = ["| case | lowest | highest |", "|---|---|---|"]
    for name in (name for name in results if f"{name}, fine" in results):
        coarse_loads_and_areas, fine_loads_and_areas = (
            [np.array(results[key][quantity]) for quantity in ("load", "area_edges")] for key in (name, f"{name}, fine")
        )
        ratios = []
        for fraction in (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.35):
            index = int(np.argmin(np.abs(coarse_loads_and_areas[1] / CASES[name].nominal_area - fraction)))
            if coarse_loads_and_areas[0][index] <= fine_loads_and_areas[0][-1]:
                ratios.append(
                    np.interp(coarse_loads_and_areas[0][index], *fine_loads_and_areas)
                    / coarse_loads_and_areas[1][index]
                )
        rows.append(f"| {name} | {min(ratios):.3f} | {max(ratios):.3f} |")
    return rows


def format_opposing_sums(rows: dict[str, list[list[float]]]) -> list[str]:
    lines = [
        "| surfaces | x | results | elastic sum | μ_s, scaled − capped, mean of ±x | the same along +x, rms |",
        "|---|---|---|---|---|---|",
    ]
    for kind, values in rows.items():
        table = np.array(values)
        for min_ratio, max_ratio in pairwise((0.0, 0.5, 1.0, 2.0, 10.0)):
            selected_rows = table[(table[:, 0] >= min_ratio) & (table[:, 0] < max_ratio)]
            if len(selected_rows) < 4:
                continue
            difference = selected_rows[:, 2] - selected_rows[:, 3]
            label = f"{min_ratio:g} to {max_ratio:g}" if max_ratio < 10 else f"above {min_ratio:g}"
            lines.append(
                f"| {kind} | {label} | {len(selected_rows)} "
                f"| {selected_rows[:, 1].mean():.2f} ± {selected_rows[:, 1].std():.2f} "
                f"| {difference.mean():+.4f} ± {difference.std():.4f} of {selected_rows[:, 3].mean():.3f} "
                f"| {np.sqrt(np.mean(selected_rows[:, 4] ** 2)):.3f} |"
            )
    return lines


def classify_case(name: str) -> str:
    case = CASES[name]
    if isinstance(case, PressedBall):
        return "ball"
    return "steep profile" if case.rms_slope > MAX_RMS_SLOPE else "profile"


def draw_figure(points: list[AreaComparison]) -> None:
    figure = Figure(figsize=(6.7, 3.6), dpi=200, layout="constrained")
    axes = figure.subplots(1, 2, sharex=True, sharey=True)
    groups = {
        ("profile", "profiles"): ("#0072B2", "#0072B2"),
        ("steep profile", "profiles, rms slope above 0.1"): ("#0072B2", "white"),
        ("ball", "ball"): ("#D55E00", "#D55E00"),
    }  # Okabe & Ito
    for ax, form in zip(axes, ("pressure cap", USED_AREA_FORM_TITLE), strict=True):
        for (kind, label), (colour, fill_colour) in groups.items():
            selected_points = [point for point in points if classify_case(point.case) == kind]
            ax.plot(
                [point.pressure_ratio for point in selected_points], [point.ratios[form] for point in selected_points],
                ls="", marker="o", ms=3, color=colour, mfc=fill_colour, mew=0.7, label=label,
            )  # fmt: skip
        ax.axhline(1, color="0.6", lw=0.6, zorder=0)
        ax.axhspan(0.88, 1.12, color="0.93", zorder=-1)
        ax.set_xscale("log")
        ax.xaxis.set_ticks((0.2, 0.5, 1, 2, 3), labels=["0.2", "0.5", "1", "2", "3"])
        ax.xaxis.minorticks_off()
        ax.tick_params(labelsize=7)
        ax.set_xlabel(r"$x = F\,/\,(A_\mathrm{el}\,H)$", fontsize=9)
        ax.set_title(AREA_FORM_TITLES[form], fontsize=9)
    axes[0].set_ylabel("area / area by finite elements", fontsize=9)
    axes[0].legend(fontsize=7.5, frameon=False)
    figure.savefig(DOCS_DIRECTORY / "images/yielding_area.png")


def main(directory: Path) -> None:
    directory.mkdir(parents=True, exist_ok=True)
    results = {name: result for name in CASES if (result := load_result(name, directory)) is not None}
    if not results:
        sys.exit(f"CalculiX (ccx) is not installed, and {directory} contains no results")
    points = [point for name, result in results.items() for point in compare_case(name, result)]
    compared_points = [point for point in points if CASES[point.case].yield_strength < 1]
    summarized_points = [
        point
        for point in compared_points
        if not point.case.endswith(("hardening", "fine"))
        and (point.case.startswith("ball") or point.area_fraction <= MAX_COMPARED_FRACTION)
    ]
    opposing_rows_by_kind = {
        kind: [
            row
            for hurst in (0.5, 0.8)
            for repetition in range(4)
            for row in compare_opposing_sums(kind, hurst, repetition)
        ]
        for kind in ("maps", "profiles")
    }
    text = [
        "Cases. x is the mean pressure of the elastic contact divided by the hardness, at equal load. Forms with an "
        r"exponent n are $(A_\mathrm{el}^n + (F/H)^n)^{1/n}$; forms with an exponent m start at the onset of yield."
        "\n",
        *format_cases(points),
        f"\nAreas divided by the finite-element area, for A/A0 below {MAX_COMPARED_FRACTION:g} and x above 0.5, "
        "without hardening and without repetitions on finer meshes.\n",
        *format_summary([point for point in summarized_points if point.pressure_ratio > 0.5]),
        "\nThe same for x up to 0.5.\n",
        *format_summary([point for point in summarized_points if point.pressure_ratio <= 0.5]),
        "\nPublished fits to finite elements for a ball, x = 0.5 to 3.1: forms divided by the fit.\n",
        *format_published_fits(),
        "\nArea on a mesh twice as fine, divided by the area, at equal load and A/A0 from 0.05 to 0.35. For the ball, "
        "A0 is its largest contact area.\n",
        *format_convergence(results),
        "\nFriction at opposing contacts: elastic solution scaled to the area of the pressure cap, divided by the "
        "solution with the pressure cap (mean ± standard deviation over pairs and loads; μ0 = 0.2, τ0 = 5 % of the "
        "hardness).\n",
        *format_opposing_sums(opposing_rows_by_kind),
        "",
    ]
    (DOCS_DIRECTORY / "generated/yielding_area.md").write_text("\n".join(text), encoding="utf-8")
    write_points(points)
    draw_figure(summarized_points)


if __name__ == "__main__":
    store = Path(sys.argv[1]) if sys.argv[1:] else DOCS_DIRECTORY.parent / "build/yielding_area"
    if sys.argv[2:]:
        store.mkdir(parents=True, exist_ok=True)
        for case_name in sys.argv[2:]:
            load_result(case_name, store)
    else:
        main(store)
