"""Compare the asperity model with the elastic half-space, and write images/half_space.png and generated/half_space.md.

The script takes about a minute on one core.
"""

import math
import sys
from concurrent.futures import ProcessPoolExecutor
from itertools import product
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from scipy.stats import t as student
from stiction import HertzCylinder, Profile, Surface, half_space, press, self_affine, self_affine_surface

DOCS_DIRECTORY = Path(__file__).parents[1]

EFFECTIVE_MODULUS = 10.0
RMS_SLOPE = 0.1
"""Root-mean-square slope of each body, along the profile or in all directions."""
MU0 = 0.4
TAU0_OVER_MODULUS = (0.0, 0.02)
"""tau0 divided by E*."""
RELATIVE_PRESSURES = (0.002, 0.02, 0.1)
"""Mean pressures in units of E* times the rms slope of the gap."""
HURST_EXPONENTS = (0.5, 0.8)
PAIR_COUNTS = {("lines", 8): 24, ("lines", 32): 24, ("lines", 128): 16, ("surfaces", 8): 12, ("surfaces", 32): 6}
"""Number of pairs by kind of surface and bandwidth, which is the ratio of the longest to the shortest wavelength."""
LONGEST_WAVELENGTHS_PER_SIDE = {"lines": 4, "surfaces": 2}
"""Side length of a surface, as a multiple of the longest wavelength."""
POINTS_PER_SHORTEST_WAVELENGTH = {"lines": 16, "surfaces": 8}
"""Number of grid points per shortest wavelength."""
SLIDING_RULES = ("opposing", "all")
SEED = 2016
COLOURS, MARKERS = {8: "#0072B2", 32: "#D55E00", 128: "#009E73"}, {0.5: "o", 0.8: "s"}  # Okabe & Ito

# Columns of a pair's results at one load: area, stiffness, and friction for each rule and tau0.
AREA_COLUMN, STIFFNESS_COLUMN, FRICTION_COLUMN = 0, 1, 2
COLUMN_NAMES = [
    "area",
    "stiffness",
    *(f"{rule}, {relative_tau0:g}" for rule, relative_tau0 in product(SLIDING_RULES, TAU0_OVER_MODULUS)),
]


def create_body(kind: str, hurst: float, bandwidth: int, repetition: int, side: str) -> Profile | Surface:
    """Return one surface of a pair, periodic on unit length, with the rms slope `RMS_SLOPE`."""
    n = LONGEST_WAVELENGTHS_PER_SIDE[kind] * bandwidth * POINTS_PER_SHORTEST_WAVELENGTH[kind]
    options = {"hurst_exponent": hurst, "repetition": repetition, "side": side, "rms": 1.0, "spacing": 1 / n}
    options |= {
        "longest_wavelength": 1 / LONGEST_WAVELENGTHS_PER_SIDE[kind],
        "shortest_wavelength": 1 / (LONGEST_WAVELENGTHS_PER_SIDE[kind] * bandwidth),
    }
    surface = (
        self_affine(SEED, points=n, periodic=True, **options)
        if kind == "lines"
        else self_affine_surface(SEED, shape=(n, n), **options)
    )
    slopes = [
        np.diff(surface.heights, axis=axis, append=np.take(surface.heights, [0], axis)) * n
        for axis in range(surface.heights.ndim)
    ]
    height_factor = RMS_SLOPE / math.sqrt(sum(float(np.mean(slope**2)) for slope in slopes))
    return type(surface)(surface.heights * height_factor, spacing=surface.spacing)


def friction_coefficient(sums: dict[str, np.ndarray], relative_tau0: float) -> np.ndarray:
    tangential_load, normal_load = (
        sums[f"{component}_elastic"]
        + MU0 * sums[f"{component}_frictional"]
        + relative_tau0 * EFFECTIVE_MODULUS * sums[f"{component}_adhesive"]
        for component in ("tangential", "normal")
    )
    return tangential_load / normal_load


def solve_half_space(upper, lower, loads: np.ndarray) -> np.ndarray:
    """Return half-space results as an array (load, column). Friction is averaged over both directions along x."""
    curves = [half_space(upper, lower, loads, boundary="periodic", direction=direction) for direction in ("+x", "-x")]
    columns = [curves[0].contact_area, curves[0].stiffness]
    for rule in SLIDING_RULES:
        curves_with_rule = [curve.with_sliding(rule) for curve in curves]
        columns += [
            np.mean(
                [
                    curve.friction_coefficient(mu0=MU0, tau0=relative_tau0 * EFFECTIVE_MODULUS)
                    for curve in curves_with_rule
                ],
                axis=0,
            )
            for relative_tau0 in TAU0_OVER_MODULUS
        ]
    return np.array(columns).T


def solve_asperities(upper, lower, loads: np.ndarray, max_approach: float) -> np.ndarray:
    """Return results of the asperity model at the approach at which its elastic load equals the half-space load."""
    model_options = {"law": HertzCylinder(), "detection": "gap-minimum"} if isinstance(upper, Profile) else {}
    approaches = np.geomspace(1e-5, 1.0, 400) * max_approach
    sum_names = [
        f"{component}_{part}"
        for component in ("tangential", "normal")
        for part in ("elastic", "frictional", "adhesive")
    ]
    columns: list[np.ndarray] = []
    for rule in SLIDING_RULES:
        curves = [
            press(upper, lower, approaches, sliding=rule, direction=direction, **model_options)
            for direction in ("+x", "-x")
        ]
        load = curves[0].normal_elastic
        first_indices = np.array([int(np.argmax(load >= expected_load)) for expected_load in loads])
        assert (load[first_indices] >= loads).all(), "a load is not reached"
        load_fraction = (loads - load[first_indices - 1]) / (load[first_indices] - load[first_indices - 1])

        def interpolate_between(values, first_indices=first_indices, load_fraction=load_fraction):
            return values[first_indices - 1] + load_fraction * (values[first_indices] - values[first_indices - 1])

        if not columns:
            columns = [interpolate_between(curves[0].contact_area), interpolate_between(np.gradient(load, approaches))]
        for relative_tau0 in TAU0_OVER_MODULUS:
            coefficients = [
                friction_coefficient(
                    {name: interpolate_between(getattr(curve, name)) for name in sum_names}, relative_tau0
                )
                for curve in curves
            ]
            columns.append(np.mean(coefficients, axis=0))
    return np.array(columns).T


def compute_pair_results(kind: str, bandwidth: int, hurst: float, repetition: int) -> np.ndarray:
    """Return the results of a pair in the half-space and the asperity model, as an array (load, model, column)."""
    upper, lower = (create_body(kind, hurst, bandwidth, repetition, side) for side in ("upper", "lower"))
    slope = RMS_SLOPE * math.sqrt(2)
    loads = np.array(RELATIVE_PRESSURES) * EFFECTIVE_MODULUS * slope  # mN on 1 µm²
    gap = upper.heights - lower.heights
    return np.stack(
        [solve_half_space(upper, lower, loads), solve_asperities(upper, lower, loads, float(np.ptp(gap)))], axis=1
    )


def mean_and_half_width(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the mean over the first axis, and the half width of its 95 % interval by Student's t."""
    n = len(values)
    return values.mean(axis=0), student.ppf(0.975, n - 1) * values.std(axis=0, ddof=1) / math.sqrt(n)


def ratio_with_interval(values: np.ndarray, column: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the geometric mean ratio of asperity to half-space results at each load, and its interval."""
    mean, half_width = mean_and_half_width(np.log(values[:, :, 1, column] / values[:, :, 0, column]))
    return np.exp(mean), np.exp(mean - half_width), np.exp(mean + half_width)


def draw_figure(results: dict) -> None:
    figure = Figure(figsize=(6.7, 7.6), dpi=200, layout="constrained")
    rows = [
        (AREA_COLUMN, "true area"),
        (STIFFNESS_COLUMN, "normal stiffness"),
        (FRICTION_COLUMN, r"friction, $\tau_0 = 0$" + "\nopposing"),
        (FRICTION_COLUMN + 1, r"friction, $\tau_0 = 0.02\,E^*$" + "\nopposing"),
        (FRICTION_COLUMN + 3, r"friction, $\tau_0 = 0.02\,E^*$" + "\nall"),
    ]
    axes = figure.subplots(len(rows), 2, sharex=True, sharey="row")
    for (column, label), axes_pair in zip(rows, axes, strict=True):
        for kind, ax in zip(LONGEST_WAVELENGTHS_PER_SIDE, axes_pair, strict=True):
            for k, ((body_kind, bandwidth), hurst) in enumerate(
                (case, h) for case in PAIR_COUNTS if case[0] == kind for h in HURST_EXPONENTS
            ):
                mean, lower_limit, upper_limit = ratio_with_interval(results[body_kind, bandwidth, hurst], column)
                ax.errorbar(
                    np.array(RELATIVE_PRESSURES) * 1.05 ** (k - 2), mean, (mean - lower_limit, upper_limit - mean),
                    lw=0.9, elinewidth=0.7, marker=MARKERS[hurst], ms=3, color=COLOURS[bandwidth],
                    mfc="white" if hurst == 0.5 else COLOURS[bandwidth],
                )  # fmt: skip
            ax.axhline(1, color="0.6", lw=0.6, zorder=0)
            ax.set_xscale("log")
            ax.xaxis.minorticks_off()
            ax.tick_params(labelsize=7)
        axes_pair[0].set_ylabel(label, fontsize=8)
    for kind, ax in zip(LONGEST_WAVELENGTHS_PER_SIDE, axes[0], strict=True):
        ax.set_title(
            {"lines": "profiles: line contacts", "surfaces": "height maps: elliptical contacts"}[kind], fontsize=9
        )
    axes[1, 0].set_yscale("log")
    axes[1, 0].yaxis.set_ticks((0.3, 0.5, 1, 2), labels=["0.3", "0.5", "1", "2"])
    axes[1, 0].yaxis.minorticks_off()
    for ax in axes[-1]:
        ax.xaxis.set_ticks(RELATIVE_PRESSURES, labels=[f"{load:g}" for load in RELATIVE_PRESSURES])
        ax.set_xlabel(r"$\bar p\,/\,E^* h'$", fontsize=8)
    ax = axes[0, 0]
    legend_handles = [
        ax.plot([], [], color=colour, label=f"longest / shortest wavelength {bandwidth}")[0]
        for bandwidth, colour in COLOURS.items()
    ]
    for hurst, marker in MARKERS.items():
        fill_colour = "white" if hurst == 0.5 else "0.3"
        legend_handles += ax.plot(
            [], [], ls="", marker=marker, color="0.3", mfc=fill_colour, ms=3, label=f"$H$ = {hurst:g}"
        )
    figure.legend(handles=legend_handles, loc="outside lower center", ncols=3, fontsize=7.5, frameon=False)
    figure.supylabel("asperities / half-space", fontsize=9)
    figure.savefig(DOCS_DIRECTORY / "images/half_space.png")


def format_tables(results: dict) -> str:
    def format_ratio(values: np.ndarray, column: int, load: int) -> str:
        mean, lower_limit, upper_limit = (limit[load] for limit in ratio_with_interval(values, column))
        return f"{mean:.2f} ({lower_limit:.2f} to {upper_limit:.2f})"

    def format_friction(values: np.ndarray, column: int, load: int) -> str:
        mean, half_width = mean_and_half_width(values[:, load, :, column])
        return f"{mean[1]:.3f} ± {half_width[1]:.3f}, {mean[0]:.3f} ± {half_width[0]:.3f}"

    header = "| surfaces | longest / shortest wavelength | H | p̄ / (E* h') |"
    area_rows = [
        f"{header} A/A0, half-space | ratio of areas | ratio of stiffnesses |",
        "|---|---|---|---|---|---|---|",
    ]
    friction_rows = [
        f"{header} opposing contacts, τ0 = 0 | opposing contacts, τ0 = 2 % of E* "
        "| all contacts, τ0 = 0 | all contacts, τ0 = 2 % of E* |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for (kind, bandwidth, hurst), values in results.items():
        for load, pressure in enumerate(RELATIVE_PRESSURES):
            row_start = f"| {kind} | {bandwidth} | {hurst:g} | {pressure:g} |"
            area_fraction = values[:, load, 0, AREA_COLUMN].mean()
            area_rows.append(
                f"{row_start} {area_fraction:.3f} | {format_ratio(values, AREA_COLUMN, load)} "
                f"| {format_ratio(values, STIFFNESS_COLUMN, load)} |"
            )
            friction_rows.append(
                f"{row_start} {' | '.join(format_friction(values, FRICTION_COLUMN + k, load) for k in range(4))} |"
            )
    return "\n".join(
        [
            "Results of the asperity model divided by results of the half-space model, at equal elastic load: "
            "geometric "
            "means over pairs with 95 % intervals.\n",
            *area_rows,
            f"\nFriction coefficients for μ0 = {MU0:g}. The first number in a cell is for the asperity model and the "
            "second "
            "for the half-space model: means over pairs ± half of their 95 % intervals.\n",
            *friction_rows,
            "",
        ]
    )


def main(workers: int = 1) -> None:
    cases = [(kind, bandwidth, hurst) for (kind, bandwidth), hurst in product(PAIR_COUNTS, HURST_EXPONENTS)]
    with ProcessPoolExecutor(workers) as pool:
        jobs = {
            case: [pool.submit(compute_pair_results, *case, k) for k in range(PAIR_COUNTS[case[:2]])] for case in cases
        }
        results = {case: np.array([job.result() for job in pair_jobs]) for case, pair_jobs in jobs.items()}
    draw_figure(results)
    (DOCS_DIRECTORY / "generated/half_space.md").write_text(format_tables(results), encoding="utf-8")


if __name__ == "__main__":
    main(*map(int, sys.argv[1:]))
