"""Test the small-slope curve of friction, and write images/collapse*.png, generated/collapse.md and collapse.csv.

Each point is an ensemble of pairs of maps or profiles, evaluated by the half-space and by the asperity model. Finished
points are stored in build/collapse.jsonl and are not computed again. The script takes about ten minutes on one core.
"""

from __future__ import annotations

import csv
import json
import os
import sys
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from itertools import pairwise, permutations, product
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.special import erf
from stiction import (
    Profile,
    Surface,
    approach_at_load,
    flipped,
    gentle_friction,
    half_space,
    levelled,
    press,
    random_phases,
    read_profile,
    read_surface,
    self_affine,
    self_affine_surface,
    weierstrass_mandelbrot,
    weierstrass_mandelbrot_surface,
)
from stiction._core import patches_of
from stiction.mechanics.friction import FrictionLaw
from stiction.mechanics.patches import grid_slopes, patch_sums

DOCS_DIRECTORY = Path(__file__).parents[1]
RESULTS_FILE = DOCS_DIRECTORY.parent / "build/collapse.jsonl"
DATA_DIRECTORY = Path(os.environ.get("STICTION_TEST_DATA", DOCS_DIRECTORY.parents[1] / "shared/data"))
"""Directory of measured maps. Cases whose file is missing are left out."""

EFFECTIVE_MODULUS = 10.0
SEED = 13
MU0 = 0.4
TAU0_BY_LABEL = {"0": 0.0, "2": 0.02 * EFFECTIVE_MODULUS}
"""Adhesive shear strengths in GPa, by their percentage of E*."""
SLIDING_RULES = ("opposing", "all")
LOW_RELATIVE_PRESSURE = 0.01
"""Mean pressure divided by E* h', which gives a contact fraction of about 0.02."""
RELATIVE_PRESSURES = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 2.0)
NUM_POINTS, EXTENT = 256, 10.0

BodyPair = tuple[Surface, Surface] | tuple[Profile, Profile]


# ---- Cases -----------------------------------------------------------------------------------------------------------


def iterate_cases() -> Iterator[dict]:
    """Yield all cases of the figures. Each case specifies surfaces and a contact model."""
    dimensions = [round(1 + d / 10, 1) for d in range(10)]
    for dimension, height, (scale, num_frequencies) in product(
        dimensions, (0.03, 0.1, 0.3, 0.6), ((2.0, 8), (2.0, 5), (1.0, 6), (1.0, 4))
    ):
        yield {"family": "WM area", "D": dimension, "height": height, "L": scale, "n": num_frequencies}
    wavelength_bands = ((5.0, 0.3125), (2.5, 0.3125), (5.0, 0.15625))
    for hurst, (longest, shortest), gradient in product((0.3, 0.5, 0.7, 0.9), wavelength_bands, (0.05, 0.15, 0.4, 0.8)):
        yield {"family": "self-affine area", "H": hurst, "longest": longest, "shortest": shortest, "h": gradient}
    for hurst, stretch, gradient, angle in product((0.5, 0.8), (2.0, 4.0), (0.1, 0.3, 0.8), (0.0, 45.0, 90.0)):
        yield {
            "family": "stretched area", "H": hurst, "longest": 5.0, "shortest": 0.3125, "h": gradient,
            "stretch": stretch, "angle": angle,
        }  # fmt: skip
    for dimension, height, num_frequencies in product(
        (1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7), (0.03, 0.1, 0.3), (6, 10)
    ):
        yield {"family": "WM line", "D": dimension, "height": height, "L": 1.0, "n": num_frequencies}
    for hurst, shortest, gradient in product((0.3, 0.5, 0.7, 0.9), (0.16, 0.04), (0.05, 0.15, 0.4, 0.8)):
        yield {"family": "self-affine line", "H": hurst, "longest": 5.0, "shortest": shortest, "h": gradient}
    band = {"longest": 5.0, "shortest": 0.3125}
    for hurst, gradient, load in product((0.5, 0.8), (0.1, 0.4), RELATIVE_PRESSURES):
        yield {"family": "load", "H": hurst, **band, "h": gradient, "load": load}
    for slope_ratio, compliance_share, load in product(
        (1.0, 2.0, 4.0, None), (0.0, 0.5, 1.0), (LOW_RELATIVE_PRESSURE, 0.1)
    ):
        yield {
            "family": "unequal",
            "H": 0.8,
            **band,
            "h": 0.3,
            "ratio": slope_ratio,
            "share": compliance_share,
            "load": load,
        }
    for hursts, compliance_share in product(((0.3, 0.9), (0.9, 0.3)), (0.0, 0.5, 1.0)):
        yield {
            "family": "other spectra",
            "H": hursts[0],
            "H_lower": hursts[1],
            **band,
            "h": 0.3,
            "share": compliance_share,
        }
    for gradient in (1.5, 3.0):
        yield {"family": "steep", "H": 0.8, **band, "h": gradient}
    for angle, load in product((0.0, 90.0), (0.003, 0.02)):
        yield {"family": "measured area", "file": "di-4.di", "angle": angle, "load": load}
    yield {"family": "measured line", "file": "dektak-1.csv"}


def generate_case_pairs(case: dict) -> tuple[list[BodyPair], str]:
    """Return the pairs of surfaces of a case, with their boundary condition."""
    match case["family"]:
        case "WM area" | "WM line" as family:
            return [
                generate_fractal_pair(case, repetition, family)
                for repetition in range(6 if family == "WM area" else 10)
            ], "free"
        case "measured area":
            return load_map_pairs(case), "free"
        case "measured line":
            return load_profile_pairs(case), "free"
        case "self-affine line":
            return [generate_self_affine_pair(case, repetition) for repetition in range(10)], "periodic"
        case _:
            return [generate_self_affine_pair(case, repetition) for repetition in range(6)], "periodic"


def generate_fractal_pair(case: dict, repetition: int, family: str) -> BodyPair:
    bodies = []
    for side in ("upper", "lower"):
        phases = random_phases(SEED, repetition=repetition, side=side, frequencies=case["n"])
        if family == "WM area":
            body = weierstrass_mandelbrot_surface(
                phases, case["D"], shape=(NUM_POINTS, NUM_POINTS), extent=EXTENT, length_scale=case["L"]
            )
            bodies.append(body.with_amplitude(case["height"]))
        else:
            line = weierstrass_mandelbrot(phases, case["D"], length_scale=case["L"], points=16_384)
            bodies.append(line.with_amplitude(case["height"]))
    return tuple(bodies)


def generate_self_affine_pair(case: dict, repetition: int) -> BodyPair:
    """Return two self-affine surfaces, of which one is flatter by a ratio, scaled to the gap gradient of the case."""
    is_line = case["family"] == "self-affine line"
    bodies = []
    for side in ("upper", "lower"):
        surface_options = {
            "hurst_exponent": case["H"] if side == "upper" else case.get("H_lower", case["H"]), "rms": 1.0,
            "longest_wavelength": case["longest"], "shortest_wavelength": case["shortest"],
            "repetition": repetition, "side": side,
        }  # fmt: skip
        if is_line:
            bodies.append(self_affine(SEED, points=8192, spacing=20 / 8192, periodic=True, **surface_options))
        else:
            bodies.append(
                self_affine_surface(
                    SEED, shape=(NUM_POINTS, NUM_POINTS), spacing=EXTENT / NUM_POINTS, **surface_options
                )
            )
    spacing = bodies[0].spacing
    if stretch := case.get("stretch"):
        spacing = (spacing[0] * stretch, spacing[1])
    gradients = [rms_gradient(body.heights, spacing, periodic=True) for body in bodies]
    slope_ratio = case.get("ratio", 1.0)
    gradient_fractions = (
        (1.0, 0.0) if slope_ratio is None else (slope_ratio / np.hypot(1, slope_ratio), 1 / np.hypot(1, slope_ratio))
    )
    heights = [
        body.heights * gradient_fraction / gradient
        for body, gradient_fraction, gradient in zip(bodies, gradient_fractions, gradients, strict=True)
    ]
    height_factor = case["h"] / rms_gradient(heights[0] - heights[1], spacing, periodic=True)
    return tuple(type(bodies[0])(height_factor * height, spacing=spacing) for height in heights)


class LoadSums:
    """Contact sums as attributes with the names that `FrictionLaw.load` requires."""

    def __init__(self, columns: dict) -> None:
        vars(self).update(columns)


def rms_gradient(heights: np.ndarray, spacing, *, periodic: bool) -> float:
    spacings = spacing if isinstance(spacing, tuple) else (spacing,)
    return float(np.sqrt(sum(np.square(slope).mean() for slope in grid_slopes(heights, spacings, periodic=periodic))))


def load_map_pairs(case: dict) -> list[BodyPair]:
    """Return pairs of quarters of a measured map. The upper map of each pair is flipped."""
    surface = levelled(read_surface(DATA_DIRECTORY / case["file"]), "plane")
    half_shape = [size // 2 for size in surface.heights.shape]
    first_indices = product((0, half_shape[0]), (0, half_shape[1]))
    quarter_maps = [
        Surface(surface.heights[row : row + half_shape[0], column : column + half_shape[1]], spacing=surface.spacing)
        for row, column in first_indices
    ]
    return [(flipped(upper), lower) for upper, lower in permutations(quarter_maps, 2)]


def load_profile_pairs(case: dict) -> list[BodyPair]:
    """Return pairs of quarters of a measured profile. The upper profile of each pair is flipped."""
    line = levelled(read_profile(DATA_DIRECTORY / case["file"]), "line")
    quarter_length = len(line) // 4
    quarter_profiles = [
        Profile(line.heights[k * quarter_length : (k + 1) * quarter_length], spacing=line.spacing) for k in range(4)
    ]
    return [(flipped(upper), lower) for upper, lower in permutations(quarter_profiles, 2)]


# ---- Measuring -------------------------------------------------------------------------------------------------------


def compute_case_results(case: dict) -> dict:
    """Return slopes, κ, contact counts and friction of each pair for both models, as means over both directions."""
    pairs, boundary = generate_case_pairs(case)
    return {"case": case, "pairs": [compute_pair_results(case, *pair, boundary) for pair in pairs]}


def compute_pair_results(case: dict, upper, lower, boundary: str) -> dict:
    is_periodic = boundary == "periodic"
    spacing = upper.spacing if isinstance(upper, Surface) else (upper.spacing,)
    heights = upper.heights - lower.heights
    gap_slopes = grid_slopes(heights, spacing, periodic=is_periodic)
    angle = np.radians(case.get("angle", 0.0))
    if len(gap_slopes) == 2:
        slope_along_motion = gap_slopes[1] * np.cos(angle) + gap_slopes[0] * np.sin(angle)
        slope_across_motion = gap_slopes[0] * np.cos(angle) - gap_slopes[1] * np.sin(angle)
    else:
        slope_along_motion, slope_across_motion = gap_slopes[0], np.zeros(1)
    second_derivatives = [
        grid_slopes(slope, spacing, periodic=is_periodic)[axis] for axis, slope in enumerate(gap_slopes)
    ]
    gap_gradient = float(np.sqrt(sum(np.square(slope).mean() for slope in gap_slopes)))
    mean_square_curvature = np.mean([np.square(slope).mean() for slope in second_derivatives])
    mean_square_slope = np.mean([np.square(slope).mean() for slope in gap_slopes])
    body_gradients = [rms_gradient(body.heights, spacing, periodic=is_periodic) for body in (upper, lower)]
    nominal_area = float(np.prod(spacing)) * heights.size  # profiles have a thickness of 1 µm
    load = case.get("load", LOW_RELATIVE_PRESSURE) * EFFECTIVE_MODULUS * gap_gradient * nominal_area
    pair_results = {
        "rms_gradient": gap_gradient,
        "rms_slope": float(np.sqrt(np.square(slope_along_motion).mean())),
        "rms_across": float(np.sqrt(np.square(slope_across_motion).mean())),
        "nayak": float(heights.var() * mean_square_curvature / mean_square_slope**2),
        "slope_ratio": body_gradients[0] / body_gradients[1] if min(body_gradients) > 0 else 0.0,
    }
    compliance_share = case.get("share", 0.5)
    directions = ("+x", "-x") if len(gap_slopes) == 1 else (case.get("angle", 0.0), case.get("angle", 0.0) + 180.0)
    curves = [
        half_space(
            upper,
            lower,
            [load],
            effective_modulus=EFFECTIVE_MODULUS,
            boundary=boundary,
            compliance_share=compliance_share,
            direction=direction,
        )
        for direction in (directions if len(gap_slopes) == 1 else [directions])
    ]
    pressure = curves[0].contact(0).pressure
    interface_slopes = grid_slopes(
        (1 - compliance_share) * lower.heights + compliance_share * upper.heights, spacing, periodic=is_periodic
    )
    point_area = float(np.prod(spacing))
    points, pressures, contact_fractions, _ = patches_of(pressure, periodic=is_periodic, hardness=np.inf)
    contact_area = float(contact_fractions.sum()) * point_area
    pair_results["kappa"] = contact_area * EFFECTIVE_MODULUS * gap_gradient / load
    pair_results["fraction"] = contact_area / nominal_area
    pair_results["contacts"] = int(curves[0].contact_count[0])
    for sliding_rule, (name, tau0) in product(SLIDING_RULES, TAU0_BY_LABEL.items()):
        values = [
            curve_for_sliding_rule.friction_coefficient(mu0=MU0, tau0=tau0)
            for curve_for_sliding_rule in (curve.with_sliding(sliding_rule) for curve in curves)
        ]
        pair_results[f"mu {sliding_rule} {name}"] = float(np.mean(values))
    # Repeat with the sliding rule applied to each grid point by its slope, instead of to each contact patch.
    motion_vectors = np.array([[np.cos(angle), np.sin(angle)], [-np.cos(angle), -np.sin(angle)]])
    point_labels = np.arange(1, points.size + 1, dtype=np.int32)
    contact_points = (points, pressures, contact_fractions, point_labels)
    slopes = [slope.ravel() for slope in interface_slopes]
    point_sums = LoadSums(patch_sums([contact_points], slopes, point_area, motion_vectors).totals("opposing"))
    for name, tau0 in TAU0_BY_LABEL.items():
        pair_results[f"mu points {name}"] = float(np.mean(FrictionLaw(MU0, tau0).coefficient(point_sums)))
    for name, model_options in asperity_models(upper):
        pair_results |= solve_asperities(upper, lower, load, directions, name, model_options, gap_gradient)
    return pair_results


def asperity_models(upper) -> list[tuple[str, dict]]:
    """Return the asperity models that apply to a pair, each with its name and arguments."""
    if isinstance(upper, Surface):
        return [("asperities", {})]
    cylinder_options = {"law": "hertz-cylinder", "detection": "gap-minimum", "curvature": "signed"}
    return [("cylinders", cylinder_options), ("spheres", {})]


def solve_asperities(
    upper, lower, load: float, directions, name: str, model_options: dict, gap_gradient: float
) -> dict:
    options = {"effective_modulus": EFFECTIVE_MODULUS, **model_options}
    approach = approach_at_load(upper, lower, [load], mu0=0.0, **options)
    model_results = {}
    for sliding_rule in SLIDING_RULES:
        if not np.isfinite(approach).all():
            continue
        curves = [
            press(upper, lower, approach, sliding=sliding_rule, direction=direction, **options)
            for direction in directions
        ]
        model_results[f"{name} kappa"] = float(
            curves[0].contact_area[0] * EFFECTIVE_MODULUS * gap_gradient / curves[0].normal_elastic[0]
        )
        for label, tau0 in TAU0_BY_LABEL.items():
            values = [curve.friction_coefficient(mu0=MU0, tau0=tau0) for curve in curves]
            model_results[f"{name} {sliding_rule} {label}"] = float(np.mean(values))
    return model_results


# ---- Running ---------------------------------------------------------------------------------------------------------


def load_results() -> dict[str, dict]:
    """Return the stored results, keyed by the JSON text of the case."""
    if not RESULTS_FILE.exists():
        return {}
    rows = [json.loads(line) for line in RESULTS_FILE.read_text(encoding="utf-8").splitlines() if line.endswith("}")]
    return {json.dumps(row["case"]): row for row in rows}


def load_or_compute_case_results() -> list[dict]:
    """Return the results of all cases with existing data. Results that are not stored are computed."""
    RESULTS_FILE.parent.mkdir(exist_ok=True)
    stored_results = load_results()
    cases = [case for case in iterate_cases() if "file" not in case or (DATA_DIRECTORY / case["file"]).exists()]
    missing_cases = [case for case in cases if json.dumps(case) not in stored_results]
    with RESULTS_FILE.open("a", encoding="utf-8") as file, ProcessPoolExecutor(2) as pool:
        for index, row in enumerate(pool.map(compute_case_results, missing_cases), start=1):
            stored_results[json.dumps(row["case"])] = row
            file.write(json.dumps(row) + "\n")
            file.flush()
            print(f"\r{index} of {len(missing_cases)} points", end="", file=sys.stderr, flush=True)
    return [stored_results[json.dumps(case)] for case in cases]


# ---- Tables and figures ----------------------------------------------------------------------------------------------

SURFACE_FAMILY_TITLES = {
    "WM area": "Weierstrass-Mandelbrot maps", "self-affine area": "self-affine maps",
    "stretched area": "stretched maps", "WM line": "Weierstrass-Mandelbrot profiles",
    "self-affine line": "self-affine profiles", "measured area": "AFM map", "measured line": "stylus profile",
}  # fmt: skip
COLOURS = ("#0072B2", "#009E73", "#56B4E9", "#D55E00", "#E69F00", "#CC79A7", "0.2")
GRADIENT_BIN_EDGES = (0.0, 0.1, 0.3, 0.6, 1.0, 4.0)
"""Limits of the ranges of h' in the table of results."""
RULE_TITLES = {
    "points": "opposing, point by point",
    "opposing": "opposing, by patches",
    "all": "friction at all contacts",
}


def closed_form_friction(
    pair: dict, sliding_rule: str, tau0: float, *, order: int = 2, kappa: float | None = None
) -> float:
    """Return the coefficient in closed form for the slopes and κ of a pair."""
    return float(
        gentle_friction(
            MU0, tau0, rms_gradient=pair["rms_gradient"], rms_slope=min(pair["rms_slope"], pair["rms_gradient"]),
            slope_ratio=pair["slope_ratio"], effective_modulus=EFFECTIVE_MODULUS, kappa=kappa or pair["kappa"],
            sliding="all" if sliding_rule == "all" else "opposing", order=order,
        )
    )  # fmt: skip


def summarise_case(row: dict) -> dict:
    """Return the means over the pairs of a case, and their ratios to the closed form with standard errors."""
    pairs = row["pairs"]
    names = ("rms_gradient", "rms_slope", "nayak", "slope_ratio", "fraction", "kappa", "contacts")
    case_means = {name: float(np.mean([pair[name] for pair in pairs])) for name in names}
    case_means |= {"family": row["case"]["family"], "case": row["case"], "pairs": len(pairs)}
    case_means["kappa_error"] = float(np.std([pair["kappa"] for pair in pairs], ddof=1) / np.sqrt(len(pairs)))
    rule_by_model = {f"mu {sliding_rule}": sliding_rule for sliding_rule in RULE_TITLES} | {
        f"{name} {sliding_rule}": sliding_rule
        for name in ("asperities", "cylinders", "spheres")
        for sliding_rule in SLIDING_RULES
    }
    for (model, sliding_rule), (label, tau0) in product(rule_by_model.items(), TAU0_BY_LABEL.items()):
        values = np.array([pair.get(f"{model} {label}", np.nan) for pair in pairs])
        if np.isfinite(values).all():
            closed_form_values = np.array([closed_form_friction(pair, sliding_rule, tau0) for pair in pairs])
            case_means[f"{model} {label}"] = float(values.mean())
            case_means[f"{model} {label} over form"] = (
                float(values.mean() / closed_form_values.mean()) if closed_form_values.any() else np.nan
            )
            standard_deviation = (
                np.std(values - closed_form_values * values.mean() / closed_form_values.mean(), ddof=1)
                if closed_form_values.any()
                else np.nan
            )
            case_means[f"{model} {label} error"] = float(
                standard_deviation / closed_form_values.mean() / np.sqrt(len(pairs))
            )
    return case_means


def format_residuals_in_percent(points: list[dict], name: str) -> str:
    """Return the mean and the largest residual of some points in per cent as text."""
    residuals = np.array([100 * (point[f"{name} over form"] - 1) for point in points if f"{name} over form" in point])
    residuals = residuals[np.isfinite(residuals)]
    if not residuals.size:
        return ""
    return f"{residuals.mean():+z.1f} ({residuals[np.abs(residuals).argmax()]:+z.1f})"


def render_family_rows(points: list[dict]) -> list[str]:
    rows = [
        "| surfaces | h' | ensembles | κ | contacts | by points, τ0 = 0 | by points, τ0 = 2 % of E* "
        "| by patches, τ0 = 0 | by patches, τ0 = 2 % of E* | all contacts, τ0 = 0 | all contacts, τ0 = 2 % of E* | "
        "asperity model, τ0 = 0 "
        "| asperity model, τ0 = 2 % of E* | standard error |",
        "|" + "---|" * 14,
    ]
    for family, family_title in SURFACE_FAMILY_TITLES.items():
        for min_gradient, max_gradient in pairwise(GRADIENT_BIN_EDGES):
            selected_points = [
                point
                for point in points
                if point["family"] == family and min_gradient <= point["rms_gradient"] < max_gradient
            ]
            if not selected_points:
                continue
            model = "cylinders" if family.endswith("line") else "asperities"
            kappas, counts = ([item[name] for item in selected_points] for name in ("kappa", "contacts"))
            cells = [
                family_title, f"{min_gradient:g} to {max_gradient:g}", f"{len(selected_points)}",
                f"{min(kappas):.2f} to {max(kappas):.2f}", f"{min(counts):.0f} to {max(counts):.0f}",
                *(
                    format_residuals_in_percent(selected_points, f"mu {sliding_rule} {key}")
                    for sliding_rule, key in product(RULE_TITLES, TAU0_BY_LABEL)
                ),
                *(format_residuals_in_percent(selected_points, f"{model} opposing {key}") for key in TAU0_BY_LABEL),
                f"{100 * np.mean([point['mu points 0 error'] for point in selected_points]):.1f}",
            ]  # fmt: skip
            rows.append(f"| {' | '.join(cells)} |")
    return rows


def render_limit_rows(points: list[dict]) -> list[str]:
    """Return the rows of the table of limits, one per secondary case."""
    rows = [
        "| bodies | h' | p̄/(E* h') | true area | κ | by points | by patches | friction at all contacts |",
        "|" + "---|" * 8,
    ]  # fmt: skip
    for point in points:
        case, family = point["case"], point["family"]
        if family in SURFACE_FAMILY_TITLES:
            continue
        case_text = f"H = {case['H']:g}"
        if family == "unequal":
            ratio_text = "a flat" if case["ratio"] is None else f"ratio of slopes {case['ratio']:g}"
            case_text += f", {ratio_text}, c_l = {case['share']:g}"
        elif family == "other spectra":
            case_text += f" on H = {case['H_lower']:g}, c_l = {case['share']:g}"
        cells = [
            case_text, f"{point['rms_gradient']:.2g}", f"{case.get('load', LOW_RELATIVE_PRESSURE):g}",
            f"{point['fraction']:.2g}", f"{point['kappa']:.2f}",
            *(
                format_residuals_in_percent([point], f"mu {sliding_rule} 0").split(" ")[0]
                for sliding_rule in RULE_TITLES
            ),
        ]  # fmt: skip
        rows.append(f"| {' | '.join(cells)} |")
    return rows


def draw_friction_and_deviations(points: list[dict]) -> None:
    figure = Figure(figsize=(6.9, 5.6), dpi=200, layout="constrained")
    axes = figure.subplots(2, 2).ravel()
    fine_gradients = np.geomspace(0.01, 3, 200)
    for family, colour in zip(SURFACE_FAMILY_TITLES, COLOURS, strict=True):
        selected_points = [point for point in points if point["family"] == family]
        if not selected_points:
            continue
        is_line = family.endswith("line")
        gradient = np.array([item["rms_gradient"] for item in selected_points])
        mean_slope = np.array([item["rms_slope"] for item in selected_points]) / (2 * np.sqrt(2 * np.pi))
        marker_style = {"ls": "", "marker": "s" if is_line else "o", "ms": 2.6, "color": colour, "mew": 0.5}
        model = "cylinders" if is_line else "asperities"
        select_values = lambda name: np.array([item.get(name, np.nan) for item in selected_points])  # noqa: E731, B023
        axes[0].plot(mean_slope, select_values(f"{model} opposing 0"), ls="", marker="x", ms=2, color="0.75", zorder=0)
        axes[0].plot(mean_slope, select_values("mu opposing 0"), **marker_style | {"mfc": "white", "ms": 2.2})
        axes[0].plot(mean_slope, select_values("mu points 0"), **marker_style, label=SURFACE_FAMILY_TITLES[family])
        if not is_line:
            axes[1].plot(
                gradient, select_values(f"{model} opposing 2"), ls="", marker="x", ms=2, color="0.75", zorder=0
            )
            axes[1].plot(gradient, select_values("mu points 2"), **marker_style)
        axes[2].plot(gradient, 100 * (select_values("mu points 0 over form") - 1), **marker_style)
        axes[2].plot(
            gradient, 100 * (select_values("mu opposing 0 over form") - 1), **marker_style | {"mfc": "white", "ms": 2.2}
        )
        axes[3].plot(gradient, 100 * (select_values("mu all 0 over form") - 1), **marker_style)
        first_order_friction = [
            np.mean([closed_form_friction(pair, "all", 0.0, order=1) for pair in item["together"]])
            for item in selected_points
        ]
        axes[3].plot(
            gradient,
            100 * (select_values("mu all 0") / first_order_friction - 1),
            **marker_style | {"mfc": "white", "ms": 2.2},
        )
    scaled_slope = fine_gradients / (4 * np.sqrt(np.pi))
    axes[0].plot(
        scaled_slope, gentle_friction(MU0, rms_gradient=fine_gradients), color="0.1", lw=1, label="closed form"
    )
    axes[0].plot(scaled_slope, gentle_friction(MU0, rms_gradient=fine_gradients, order=2), color="0.1", lw=1, ls="--")
    closed_form_options = {"rms_gradient": fine_gradients, "effective_modulus": EFFECTIVE_MODULUS}
    axes[1].plot(fine_gradients, gentle_friction(MU0, TAU0_BY_LABEL["2"], **closed_form_options), color="0.1", lw=1)
    axes[1].plot(
        fine_gradients,
        gentle_friction(MU0, TAU0_BY_LABEL["2"], **closed_form_options, order=2),
        color="0.1",
        lw=1,
        ls="--",
    )
    slope_at_minimum = np.sqrt(2 * np.sqrt(np.pi) * 2.2 * TAU0_BY_LABEL["2"] / EFFECTIVE_MODULUS)
    axes[1].axvline(slope_at_minimum, color="0.6", lw=0.7, ls=":")
    axes[0].set(xlabel="mean slope $S = g_s / 2\\sqrt{2\\pi}$", ylabel="$\\mu_s$")
    axes[0].set(title="opposing contacts, $\\tau_0$ = 0")
    axes[0].set(xscale="log", ylim=(0.18, 0.9))
    axes[1].set(xlabel="$h'$", ylabel="$\\mu_s$", xscale="log")
    axes[1].set(ylim=(0.25, 1.2), title="opposing contacts, $\\tau_0$ = 2 % of $E^*$; height maps")
    axes[2].set(
        xlabel="$h'$",
        ylabel="deviation from the closed form (%)",
        title="opposing contacts: by points (filled), by patches (open)",
    )
    axes[3].set(
        xlabel="$h'$",
        ylabel="deviation from the closed form (%)",
        title="all contacts: second order (filled), first order (open)",
    )
    axes[2].set(xscale="log", ylim=(-26, 8))
    axes[3].set(xscale="log", ylim=(-2, 26))
    for ax in axes:
        ax.title.set_fontsize(8)
        ax.tick_params(labelsize=7)
        ax.xaxis.label.set_fontsize(8)
        ax.yaxis.label.set_fontsize(8)
    for ax in axes[2:]:
        ax.axhline(0, color="0.1", lw=0.8, zorder=0)
    figure.legend(loc="outside lower center", ncols=4, fontsize=6.5, frameon=False)
    figure.savefig(DOCS_DIRECTORY / "images/collapse.png")


def draw_limits_of_closed_form(points: list[dict]) -> None:
    figure = Figure(figsize=(6.9, 2.7), dpi=200, layout="constrained")
    load_plot_axes, kappa_plot_axes, spectra_plot_axes = figure.subplots(1, 3)
    style = {(0.5, 0.1): ("#0072B2", "o"), (0.5, 0.4): ("#0072B2", "s"), (0.8, 0.1): ("#D55E00", "o"),
             (0.8, 0.4): ("#D55E00", "s")}  # fmt: skip
    for (hurst, gradient), (colour, marker) in style.items():
        selected_points = [
            point for point in points if point["family"] == "load" and (point["case"]["H"], point["case"]["h"]) == (
                hurst, gradient,
            )
        ]  # fmt: skip
        load = [item["case"]["load"] for item in selected_points]
        marker_style = {
            "color": colour,
            "marker": marker,
            "ms": 3,
            "lw": 0.8,
            "label": f"H = {hurst:g}, h' = {gradient:g}",
        }
        load_plot_axes.plot(
            load, [100 * (item["mu points 0 over form"] - 1) for item in selected_points], **marker_style
        )
        load_plot_axes.plot(
            load,
            [100 * (item["mu opposing 0 over form"] - 1) for item in selected_points],
            **marker_style | {"mfc": "white", "label": ""},
        )
        if gradient == 0.1:
            kappa_plot_axes.errorbar(
                load, [item["kappa"] for item in selected_points], [item["kappa_error"] for item in selected_points],
                **marker_style | {"label": f"H = {hurst:g}"},
            )  # fmt: skip
    fine_pressures = np.geomspace(RELATIVE_PRESSURES[0], RELATIVE_PRESSURES[-1], 200)
    kappa_plot_axes.axhline(np.sqrt(2 * np.pi), color="0.5", lw=0.8, ls="-.", label="Bush-Gibson-Thomas")
    kappa_plot_axes.plot(
        fine_pressures, erf(np.sqrt(2) * fine_pressures) / fine_pressures, color="0.3", lw=0.9, ls="--", label="Persson"
    )
    kappa_plot_axes.plot(fine_pressures, np.minimum(1 / fine_pressures, 3), color="0.8", lw=0.7, zorder=0)
    for family, colour in list(zip(SURFACE_FAMILY_TITLES, COLOURS, strict=True))[:5]:
        selected_points = [point for point in points if point["family"] == family]
        spectra_plot_axes.plot(
            [item["nayak"] for item in selected_points], [item["kappa"] for item in selected_points], ls="",
            color=colour, ms=2.4, marker="s" if family.endswith("line") else "o", label=SURFACE_FAMILY_TITLES[family],
        )  # fmt: skip
    for value, line_style in ((np.sqrt(2 * np.pi), "-."), (np.sqrt(8 / np.pi), "--")):
        spectra_plot_axes.axhline(value, color="0.5", lw=0.8, ls=line_style)
    load_plot_axes.set(xscale="log", xlabel="$\\bar p / E^* h'$", ylabel="$\\mu_s$: deviation from the closed form (%)")
    load_plot_axes.axhline(0, color="0.1", lw=0.8, zorder=0)
    kappa_plot_axes.set(xscale="log", xlabel="$\\bar p / E^* h'$", ylabel="$\\kappa = A E^* h' / F$", ylim=(0, 3))
    spectra_plot_axes.set(xscale="log", xlabel="Nayak's parameter", ylabel="$\\kappa$", ylim=(0, 4))
    for ax in (load_plot_axes, kappa_plot_axes, spectra_plot_axes):
        ax.tick_params(labelsize=7)
        ax.xaxis.label.set_fontsize(8)
        ax.yaxis.label.set_fontsize(8)
        ax.legend(fontsize=5.5, frameon=False)
    figure.savefig(DOCS_DIRECTORY / "images/collapse_limits.png")


def write_case_means(points: list[dict]) -> None:
    """Write the means over the pairs of each case to a CSV file."""
    column_names = sorted({key for point in points for key in point if key not in ("case", "together")})
    column_names = ["family", "of", *(key for key in column_names if key != "family")]
    with (DOCS_DIRECTORY / "generated/collapse.csv").open("w", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, column_names, lineterminator="\n")
        writer.writeheader()
        for point in points:
            case_text = "; ".join(f"{key} {value}" for key, value in point["case"].items() if key != "family")
            number_texts = {key: f"{value:.5g}" for key, value in point.items() if isinstance(value, float)}
            writer.writerow({"family": point["family"], "of": case_text, "pairs": point["pairs"], **number_texts})


def main() -> None:
    rows = load_or_compute_case_results()
    points = [summarise_case(row) | {"together": row["pairs"]} for row in rows]
    draw_friction_and_deviations(points)
    draw_limits_of_closed_form(points)
    write_case_means(points)
    num_main_points = sum(point["family"] in SURFACE_FAMILY_TITLES for point in points)
    num_pairs = sum(point["pairs"] for point in points)
    text = [
        "Relative deviations of friction from the closed form of second order in per cent: mean over the ensembles, "
        "and the largest deviation. The closed form uses the κ of each pair, and nothing is fitted. "
        f"There are {num_main_points} ensembles here and {len(points) - num_main_points} in the next table, "
        f"with {num_pairs} pairs in total. μ0 is 0.4. The mean pressure is {LOW_RELATIVE_PRESSURE:g} E* h', except for "
        "measured surfaces, for which it is 0.003 and 0.02 E* h'.",
        "\n".join(render_family_rows(points)),
        "Limits of the closed form, with τ0 = 0: deviations in per cent for loads up to full contact, for bodies of "
        "different roughness, stiffness and spectra, and for steep slopes.",
        "\n".join(render_limit_rows(points)),
    ]
    (DOCS_DIRECTORY / "generated/collapse.md").write_text("\n\n".join(text) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
