"""Measure the effect of scan resolution, and write docs/generated/resolution.md and docs/images/resolution.png.

The argument selects the part to compute: "settling", "bracketing", "continuing" or "joining". Without an argument,
table and figure are written from the results in the directory `resolution`. Seeds are fixed; all parts take 15 minutes.
"""

import json
import math
import sys
from pathlib import Path

import numpy as np
from stiction import (
    Surface,
    half_space,
    joined_spectrum,
    resolution,
    scale_dependent_roughness,
    self_affine_surface,
    surface_spectrum,
)

DOCS_DIRECTORY = Path(__file__).parent.parent
RESULTS_DIRECTORY = Path("resolution")
LARGE_MAP_SIDE_POINTS, SMALL_MAP_SIDE_POINTS, SPACING = 1024, 512, 0.01  # spacing in µm
EFFECTIVE_MODULUS, HARDNESS, MU0, TAU0 = 115.0, 4.0, 0.2, 0.2  # GPa
PRESSURE, HIGH_PRESSURE = 0.02, 0.2  # GPa
HURST_EXPONENTS = (0.4, 0.8)
GAP_GRADIENTS_BY_HURST_EXPONENT = {0.4: 0.6, 0.8: 0.25}
"""Rms gradient of the gap by Hurst exponent, including all wavelengths from four points upwards."""
CUTOFFS_IN_POINTS = (8, 16, 32, 64)
"""Cutoff wavelengths in grid points. The surfaces themselves have wavelengths from four points upwards."""
BANDS_PER_DECADE = 5
NUM_PAIRS, NUM_BRACKET_TEST_PAIRS, NUM_EXTRAPOLATION_TEST_PAIRS = 6, 50, 50
"""Number of pairs per Hurst exponent, for each part of the study."""


def gap_gradient(bodies):
    gap = Surface(bodies[0].heights - bodies[1].heights, spacing=bodies[0].spacing)
    return float(scale_dependent_roughness(gap, periodic=True).gradient[-1])


def create_pair(hurst, index, num_points, longest_wavelength):
    """Return two self-affine surfaces with a given gap gradient, whose shortest wavelength is four grid spacings."""
    bodies = [
        self_affine_surface(
            28, hurst_exponent=hurst, rms=0.01, shape=(num_points, num_points), spacing=SPACING, side=side,
            repetition=index, longest_wavelength=longest_wavelength * SPACING, shortest_wavelength=4 * SPACING,
        )
        for side in ("upper", "lower")
    ]  # fmt: skip
    height_factor = GAP_GRADIENTS_BY_HURST_EXPONENT[hurst] / gap_gradient(bodies)
    return [Surface(height_factor * body.heights, spacing=SPACING) for body in bodies]


def compute_coarser_cutoffs():
    """Compute pairs of surfaces at their own resolution and at coarser cutoffs, both without and with a hardness."""
    results = []
    for hurst in HURST_EXPONENTS:
        for index in range(NUM_PAIRS):
            bodies = create_pair(hurst, index, LARGE_MAP_SIDE_POINTS, LARGE_MAP_SIDE_POINTS // 4)
            results.append({"hurst": hurst, **compute_pair_results(bodies, CUTOFFS_IN_POINTS, HARDNESS, "plastic")})
            results[-1] |= compute_pair_results(bodies, CUTOFFS_IN_POINTS, None, "elastic")
            results[-1] |= {
                "softer": compute_pair_results(bodies, CUTOFFS_IN_POINTS[-1:], HARDNESS / 2, "plastic")["plastic"]
            }
            print(hurst, index, results[-1]["plastic"]["area"], results[-1]["plastic"]["all"], flush=True)
            save_results("settling", results)


def compute_bracket_tests():
    """Compute many smaller pairs with a hardness, to test bounds for finer scans that coarse results give."""
    results = []
    for hurst in HURST_EXPONENTS:
        for index in range(NUM_BRACKET_TEST_PAIRS):
            bodies = create_pair(hurst, 2000 + index, LARGE_MAP_SIDE_POINTS // 4, LARGE_MAP_SIDE_POINTS // 16)
            results.append({"hurst": hurst, **compute_pair_results(bodies, CUTOFFS_IN_POINTS[:2], HARDNESS, "plastic")})
            print(hurst, index, results[-1]["plastic"]["area"], flush=True)
            save_results("bracketing", results)


def compute_pair_results(bodies, cutoffs, hardness, name):
    load = PRESSURE * math.prod(bodies[0].extent)
    result = resolution(
        *bodies, [load], hardness=hardness, cut_offs=[item * SPACING for item in cutoffs], mu0=MU0, tau0=TAU0,
        effective_modulus=EFFECTIVE_MODULUS, boundary="periodic",
    )  # fmt: skip
    friction_by_rule = result.friction_coefficient[..., 0]
    model_results = {
        "area": result.contact_area_fraction[:, 0].values.tolist(),
        "pressure": result.mean_pressure[:, 0].values.tolist(),
        "all": friction_by_rule.sel(sliding="all").values.tolist(),
        "opposing": friction_by_rule.sel(sliding="opposing").values.tolist(),
        "capped": result.load_fraction_at_hardness[:, 0].values.tolist(),
        "gradient": result.rms_gradient.values.tolist(),
    }
    if hardness is None:
        return {name: model_results}
    plastic_limit = [float(result.plastic_area_fraction[0]), float(result.plastic_friction_coefficient[0])]
    model_results |= {
        f"most_{result_name}": result[f"bracket_{variable_name}"][:, 0].sel(end="upper").values.tolist()
        for result_name, variable_name in (("area", "area_fraction"), ("all", "friction_coefficient"))
    }
    return {name: model_results, "limit": plastic_limit}


def simulate_coarser_scan(body, shortest_wavelength, step):
    """Return every `step`-th point of a surface after a low-pass filter with the cutoff `shortest` (points)."""
    transform = np.fft.fft2(body.heights)
    k = np.hypot(*np.meshgrid(*(np.fft.fftfreq(SMALL_MAP_SIDE_POINTS),) * 2, indexing="ij"))
    filtered_heights = np.fft.ifft2(np.where(k * shortest_wavelength <= 1 + 1e-9, transform, 0)).real
    return Surface(filtered_heights[::step, ::step], spacing=step * SPACING)


def compute_extrapolations():
    """Extrapolate scans that are filtered at 32 points: the elastic result at 4 points, and the yield wavelength."""
    from stiction.mechanics.brackets import estimate_gap_hurst_exponent

    load = HIGH_PRESSURE * (SMALL_MAP_SIDE_POINTS * SPACING) ** 2
    results = []
    for hurst in HURST_EXPONENTS:
        for index in range(NUM_EXTRAPOLATION_TEST_PAIRS):
            fine_bodies = create_pair(hurst, 1000 + index, SMALL_MAP_SIDE_POINTS, SMALL_MAP_SIDE_POINTS)
            coarse_bodies = [simulate_coarser_scan(body, 32, 4) for body in fine_bodies]
            # Hardness that the mean elastic contact pressure reaches at a wavelength of about 10 points.
            hardness = EFFECTIVE_MODULUS * GAP_GRADIENTS_BY_HURST_EXPONENT[hurst] / 2.2 * (4 / 10) ** (1 - hurst)
            options = {
                "mu0": MU0,
                "tau0": TAU0,
                "effective_modulus": EFFECTIVE_MODULUS,
                "boundary": "periodic",
                "cut_offs": [],
            }
            coarse_result = resolution(*coarse_bodies, [load], hardness=hardness, **options)
            fine_curve = half_space(
                *fine_bodies, [load], effective_modulus=EFFECTIVE_MODULUS, boundary="periodic", sliding="all",
                direction=[0.0, 90.0, 180.0, 270.0],
            )  # fmt: skip
            friction = float(
                fine_curve.tangential_load(mu0=MU0, tau0=TAU0).mean()
                / fine_curve.normal_load(mu0=MU0, tau0=TAU0).mean()
            )
            kappa = float(fine_curve.contact_area[0]) * EFFECTIVE_MODULUS * gap_gradient(fine_bodies) / load
            gap = Surface(fine_bodies[0].heights - fine_bodies[1].heights, spacing=SPACING)
            plastic_wavelength = scale_dependent_roughness(gap, periodic=True).wavelength_of(
                kappa * hardness / EFFECTIVE_MODULUS
            )
            extrapolated = coarse_result.sel(finer_wavelength=4 * SPACING, method="nearest")
            coarse_gap = Surface(coarse_bodies[0].heights - coarse_bodies[1].heights, spacing=4 * SPACING)
            estimate = estimate_gap_hurst_exponent(coarse_gap, True)
            row = {
                "hurst": hurst, "index": index, "friction": friction, "wavelength": plastic_wavelength, "kappa": kappa,
                "said_kappa": float(coarse_result.elastic_kappa[0]),
                "said_friction": extrapolated.continued_elastic_friction_coefficient[0].values.tolist(),
                "said_wavelength": coarse_result.plastic_wavelength[0, 0].values.tolist(),
                "gradient": gap_gradient(fine_bodies),
                "said_gradient": extrapolated.continued_rms_gradient.values.tolist(),
                "exponent": None if estimate is None else [estimate.value, estimate.lower, estimate.upper],
                "at_scan": float(coarse_result.friction_coefficient.sel(sliding="all")[0, 0]),
                "finer_wavelength": float(extrapolated.finer_wavelength),
            }  # fmt: skip
            results.append(row)
            print(hurst, index, row["friction"], row["said_friction"], flush=True)
            save_results("continuing", results)


def compute_joined_spectrum():
    """Compute one surface as three simulated instruments measure it, and the joined spectrum of the scans."""
    from scipy.ndimage import grey_dilation
    from stiction.views.scans import joined_spectrum_figure
    from stiction.views.style import save_figure

    points, radius = 2048, 0.01  # µm
    surface = self_affine_surface(
        28, hurst_exponent=0.8, rms=0.05, shape=(points, points), spacing=SPACING, longest_wavelength=2.56
    )
    generator = np.random.default_rng(28)

    def average_pixels(heights, pixel, noise):
        num_pixels = heights.shape[0] // pixel
        means = heights.reshape(num_pixels, pixel, num_pixels, pixel).mean((1, 3))
        return Surface(means + noise * generator.normal(size=means.shape), spacing=pixel * SPACING)

    tip_half_width = int(np.ceil(np.sqrt(2 * radius * np.ptp(surface.heights)) / SPACING))
    y, x = np.mgrid[-tip_half_width : tip_half_width + 1, -tip_half_width : tip_half_width + 1] * SPACING
    tip_heights = -(x**2 + y**2) / (2 * radius)
    fine_maps = [surface.heights[row : row + 512, column : column + 512] for row in (0, 1024) for column in (0, 1024)]
    scans = {
        "microscope": [average_pixels(surface.heights, 16, 0.5e-3)],
        "large probe": [average_pixels(surface.heights[:1024, side : side + 1024], 4, 0.1e-3) for side in (0, 1024)],
        "fine probe": [
            Surface(grey_dilation(fine_map, structure=tip_heights, mode="nearest"), spacing=SPACING)
            for fine_map in fine_maps
        ],
    }
    scan_names = [name for name, item in scans.items() for _ in item]
    joined = joined_spectrum(
        [scan for value in scans.values() for scan in value],
        tip_radii=[radius if name == "fine probe" else None for name in scan_names],
        per_decade=BANDS_PER_DECADE,
    )
    first_scans = [scans[name][0] for name in scans]
    joined_first_scans = joined_spectrum(first_scans, tip_radii=[None, None, radius], names=list(scans))
    save_figure(joined_spectrum_figure(joined_first_scans), DOCS_DIRECTORY / "images/characterise_joined.png")
    q, _, density = surface_spectrum(surface, periodic=True).waves()
    bin_half_width = 10 ** (0.5 / BANDS_PER_DECADE)
    true_density = []
    for wave_number in joined.wave_number:
        is_in_bin = (q >= wave_number / bin_half_width) & (q < wave_number * bin_half_width)
        true_density.append(float((density[is_in_bin] * (q[is_in_bin] / wave_number) ** 3).mean()))
    joined_roughness, true_roughness = joined.roughness(), scale_dependent_roughness(surface, periodic=True)
    wavelengths = 2 * math.pi / joined.wave_number
    result = {
        "names": scan_names, "wavelength": wavelengths.tolist(), "density": joined.density.tolist(),
        "known": true_density,
        "count": joined.count.tolist(), "contribution": joined.contribution.tolist(), "ratio": joined.ratio.tolist(),
        "bands": joined.bands, "reasons": joined.reasons, "disagreement": joined.disagreement.tolist(),
        "gradient": joined_roughness.gradient.tolist(),
        "known_gradient": true_roughness.gradient_at(wavelengths).tolist(),
    }  # fmt: skip
    save_results("joining", result)


def save_results(name, results):
    RESULTS_DIRECTORY.mkdir(exist_ok=True)
    (RESULTS_DIRECTORY / f"{name}.json").write_text(json.dumps(results), encoding="utf-8")


def load_results(name):
    return json.loads((RESULTS_DIRECTORY / f"{name}.json").read_text(encoding="utf-8"))


def render_coarser_cutoff_rows(rows):
    """Return the table rows of one Hurst exponent: deviations of results at coarser cutoffs from the finest result."""

    def format_means(model, name, factor=1.0, digits=3):
        values = np.mean([row[model][name] for row in rows], axis=0)
        return " | ".join(f"{factor * value:.{digits}f}" for value in values)

    lines = [
        f"| Hurst {rows[0]['hurst']}, {len(rows)} pairs | "
        + " | ".join(f"{count} points" for count in (4, *CUTOFFS_IN_POINTS))
        + " |",
        "|" + "---|" * (2 + len(CUTOFFS_IN_POINTS)),
        f"| h' of the gap | {format_means('plastic', 'gradient')} |",
        f"| elastic: A/A0 (%) | {format_means('elastic', 'area', 100)} |",
        f"| elastic: mean pressure (GPa) | {format_means('elastic', 'pressure', 1, 1)} |",
        f"| elastic: μ_s, friction at all contacts | {format_means('elastic', 'all')} |",
        f"| H = 4 GPa: A/A0 (%), F/H is {100 * rows[0]['limit'][0]:.3f} | {format_means('plastic', 'area', 100)} |",
        f"| H = 4 GPa: fraction of the load on yielded points | {format_means('plastic', 'capped', 1, 2)} |",
        f"| H = 4 GPa: μ_s, friction at all contacts; limit {rows[0]['limit'][1]:.3f} "
        f"| {format_means('plastic', 'all')} |",
        f"| H = 4 GPa: μ_s, friction at opposing contacts | {format_means('plastic', 'opposing')} |",
    ]
    for name, quantity_title in (("all", "μ_s, friction at all contacts"), ("area", "A/A0")):
        values = np.array([row["plastic"][name] for row in rows])
        largest_differences = 100 * np.abs(values / values[:, :1] - 1).max(axis=0)
        cells = " | ".join(f"{difference:.1f}" for difference in largest_differences)
        lines.append(f"| {quantity_title}: largest difference from the finest (%) | {cells} |")
    return lines


def count_pairs_inside_brackets(rows, name, limit_index, upper_key):
    """Count the pairs for which the bounds at each cutoff contain the results at all finer cutoffs."""
    count = 0
    for row in rows:
        values, bracket_ends, gradients = (row["plastic"][key] for key in (name, upper_key, "gradient"))
        index_pairs = [
            (fine_index, coarse_index) for coarse_index in range(len(values)) for fine_index in range(coarse_index)
        ]
        count += all(
            row["limit"][limit_index]
            <= values[fine_index]
            <= bracket_ends[coarse_index] * (1 + gradients[fine_index] ** 2 / 8)
            for fine_index, coarse_index in index_pairs
        )
    return f"{count} of {len(rows)}"


def median_bracket_widths(rows, name, limit_index, upper_key):
    """Return the median width of the bounds, relative to the limit (%), at each cutoff except the finest."""
    relative_bounds = np.array([np.array(row["plastic"][upper_key]) / row["limit"][limit_index] for row in rows])
    return ", ".join(f"{100 * (width_ratio - 1):.1f}" for width_ratio in np.median(relative_bounds, axis=0)[1:])


def render_rows_of_bounds(groups):
    """Return the rows of the table of bounds: fractions of pairs inside them, and their widths."""
    lines = [
        "| bracket: from the plastic limit to | A/A0: pairs inside | A/A0: upper bound above the plastic limit (%) "
        "| μ_s, friction at all contacts: pairs inside | μ_s: upper bound above the plastic limit (%) |",
        "|---|---|---|---|---|",
    ]
    for group_title, rows in groups.items():
        for bracket_title, key_prefix in (
            ("the upper bound of the bracket", "most_"),
            ("the result at the coarser cutoff", ""),
        ):
            cells = [
                item
                for limit_index, name in enumerate(("area", "all"))
                for item in (
                    count_pairs_inside_brackets(rows, name, limit_index, key_prefix + name),
                    median_bracket_widths(rows, name, limit_index, key_prefix + name),
                )
            ]
            lines.append(f"| {bracket_title}; {group_title} | {' | '.join(cells)} |")
    return lines


def render_yield_deviation_rows(rows_by_exponent):
    """Return table rows with the deviation of the coarsest from the finest result, at pressures of H and 2 H."""
    lines = [
        f"| μ_s, friction at all contacts, at {CUTOFFS_IN_POINTS[-1]} points | elastic mean pressure / hardness "
        "| mean difference from the finest (%) | largest difference (%) |",
        "|---|---|---|---|",
    ]
    for hurst, rows in rows_by_exponent.items():
        for name, hardness in (("plastic", HARDNESS), ("softer", HARDNESS / 2)):
            pressure_ratio = np.mean([row["elastic"]["pressure"][-1] for row in rows]) / hardness
            values = np.array([row[name]["all"] for row in rows])
            relative_differences = 100 * (values[:, -1] / values[:, 0] - 1)
            lines.append(
                f"| Hurst {hurst}, H = {hardness:g} GPa | {pressure_ratio:.1f} "
                f"| {relative_differences.mean():.1f} | {np.abs(relative_differences).max():.1f} |"
            )
    return lines


def count_covered_pairs(rows, name):
    """Count the pairs of surfaces whose predicted interval contains the true value.

    A missing interval counts as zero width at 0.
    """
    intervals = np.nan_to_num([row[f"said_{name}"][1:] for row in rows])
    true_values = np.array([row[name] for row in rows])
    return f"{int(((intervals[:, 0] <= true_values) & (true_values <= intervals[:, 1])).sum())} of {len(rows)}"


def render_extrapolation_rows(extrapolations):
    extrapolations_by_exponent = [[row for row in extrapolations if row["hurst"] == hurst] for hurst in HURST_EXPONENTS]
    extrapolations_with_exponent = [
        [row for row in rows if row["exponent"] is not None] for rows in extrapolations_by_exponent
    ]

    def median_over_rows(rows, name):
        return np.median(np.nan_to_num([row[name] for row in rows]), axis=0)

    columns = {
        "pairs; without a self-affine band": [
            f"{len(a)}; {len(a) - len(b)}"
            for a, b in zip(extrapolations_by_exponent, extrapolations_with_exponent, strict=True)
        ],
        "elastic μ_s at the scan's 32 points": [
            f"{median_over_rows(rows, 'at_scan'):.4f}" for rows in extrapolations_with_exponent
        ],
        "elastic μ_s at 4 points, solved": [
            f"{median_over_rows(rows, 'friction'):.4f}" for rows in extrapolations_with_exponent
        ],
        "estimated from the scan": [
            "{:.4f} [{:.4f}, {:.4f}]".format(*median_over_rows(rows, "said_friction"))
            for rows in extrapolations_with_exponent
        ],
        "in its interval": [count_covered_pairs(rows, "friction") for rows in extrapolations_with_exponent],
        "wavelength at which plasticity reaches, solved (nm)": [
            f"{1e3 * median_over_rows(rows, 'wavelength'):.0f}" for rows in extrapolations_with_exponent
        ],
        "estimated from the scan (nm)": [
            "{:.0f} [{:.0f}, {:.0f}]".format(*1e3 * median_over_rows(rows, "said_wavelength"))
            for rows in extrapolations_with_exponent
        ],
        "in its interval ": [count_covered_pairs(rows, "wavelength") for rows in extrapolations_with_exponent],
    }
    titles = " | ".join(f"Hurst {exponent}" for exponent in HURST_EXPONENTS)
    header = f"| medians; {SMALL_MAP_SIDE_POINTS}² points, {1e3 * HIGH_PRESSURE:g} MPa | {titles} |"
    return [
        header,
        "|---|" + "---|" * len(HURST_EXPONENTS),
        *(f"| {name} | {' | '.join(cells)} |" for name, cells in columns.items()),
    ]


def render_spectrum_rows(joined_results):
    scan_names = list(dict.fromkeys(joined_results["names"]))
    lines = [
        "| wavelength (µm) | averaged values of the spectrum | combined / true spectrum | estimated / true h' of "
        "longer wavelengths "
        f"| {' | '.join(scan_names)} |",
        "|---|---|---|---|" + "---|" * len(scan_names),
    ]
    contribution = np.array(joined_results["contribution"])
    for index, wavelength in enumerate(joined_results["wavelength"]):
        contributions = [
            sum(contribution[scan, index] for scan, name in enumerate(joined_results["names"]) if name == scan_name)
            for scan_name in scan_names
        ]
        lines.append(
            f"| {wavelength:.3g} | {joined_results['count'][index]:.0f} "
            f"| {joined_results['density'][index] / joined_results['known'][index]:.3f} "
            f"| {joined_results['gradient'][index] / joined_results['known_gradient'][index]:.3f} "
            f"| {' | '.join(f'{100 * fraction:.0f} %' for fraction in contributions)} |"
        )
    first_scan_indices = {name: joined_results["names"].index(name) for name in scan_names}
    range_texts = ", ".join(
        f"{name} {1e3 * joined_results['bands'][scan][0]:.0f} nm ({joined_results['reasons'][scan]})"
        for name, scan in first_scan_indices.items()
    )
    return [
        *lines,
        "",
        "The last columns are the fractions that the scans contribute. The scans are used down to these wavelengths: "
        f"{range_texts}.",
    ]


def write_page():
    coarser_cutoffs, bracket_tests, extrapolations, joined_results = (
        load_results(name) for name in ("settling", "bracketing", "continuing", "joining")
    )
    rows_by_exponent = {hurst: [row for row in coarser_cutoffs if row["hurst"] == hurst] for hurst in HURST_EXPONENTS}
    lines = []
    for rows in rows_by_exponent.values():
        lines += [*render_coarser_cutoff_rows(rows), ""]
    lines += [
        f"Means over pairs of maps of {LARGE_MAP_SIDE_POINTS}² points with wavelengths from 4 points to a quarter of "
        "the side, "
        f"filtered at the cutoff wavelength of each column. E\\* is {EFFECTIVE_MODULUS:g} GPa, the nominal pressure "
        f"{1e3 * PRESSURE:g} MPa, μ0 {MU0:g} and τ0 {1e3 * TAU0:g} MPa.",
        "",
        *render_yield_deviation_rows(rows_by_exponent),
        "",
        *render_rows_of_bounds(
            {
                f"{LARGE_MAP_SIDE_POINTS}², 4 to 64 points": coarser_cutoffs,
                f"{LARGE_MAP_SIDE_POINTS // 4}², 4 to 16 points": bracket_tests,
            }
        ),
        "",
        "A pair is inside the bracket if all finer results are inside, apart from a factor of 1 + h'²/8 for their "
        "slopes. Upper bounds are medians, one for each cutoff except the first.",
        "",
        *render_extrapolation_rows(extrapolations),
        "",
        *render_spectrum_rows(joined_results),
    ]
    (DOCS_DIRECTORY / "generated/resolution.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
    draw_figure(rows_by_exponent)


def draw_figure(rows_by_exponent):
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(1, 2, figsize=(8, 3.8), layout="constrained")
    colours = dict(zip(HURST_EXPONENTS, ("#0072b2", "#d55e00"), strict=True))
    wavelengths = 1e3 * SPACING * np.array([4, *CUTOFFS_IN_POINTS])
    for hurst, rows in rows_by_exponent.items():
        for axis, name, factor in ((axes[0], "area", 100), (axes[1], "all", 1)):
            for model, line in (("plastic", "-o"), ("elastic", "--s")):
                values = factor * np.array([row[model][name] for row in rows])
                label = f"Hurst {hurst}, {'H = 4 GPa' if model == 'plastic' else 'elastic'}"
                axis.plot(wavelengths, values.mean(axis=0), line, color=colours[hurst], markersize=4, label=label)
                axis.fill_between(
                    wavelengths, values.min(axis=0), values.max(axis=0), color=colours[hurst], alpha=0.12, lw=0
                )
    plastic_limit = rows_by_exponent[HURST_EXPONENTS[0]][0]["limit"]
    for axis, value, limit_label in (
        (axes[0], 100 * plastic_limit[0], "$F/H$"),
        (axes[1], plastic_limit[1], "$\\mu_0 + \\tau_0/H$"),
    ):
        axis.axhline(value, color="black", lw=1)
        axis.annotate(
            f"plastic limit {limit_label}", (wavelengths[0], value), (0, -3), textcoords="offset points", va="top",
            fontsize=9,
        )  # fmt: skip
        axis.set(xscale="log", xlabel="cutoff wavelength (nm)")
        axis.set_xticks(wavelengths, [f"{wavelength:g}" for wavelength in wavelengths])
        axis.set_xticks([], minor=True)
    axes[0].set(yscale="log", ylabel="true contact area A/A0 (%)", title="True area")
    axes[0].set_yticks([0.05, 0.1, 0.2, 0.5], ["0.05", "0.1", "0.2", "0.5"])
    axes[0].set_yticks([], minor=True)
    axes[0].legend(fontsize=8, loc="lower right")
    axes[1].set(ylabel="$\\mu_s$, friction at all contacts", title="Friction")
    figure.savefig(DOCS_DIRECTORY / "images/resolution.png", dpi=160)


if __name__ == "__main__":
    functions_by_result = {
        "settling": compute_coarser_cutoffs,
        "bracketing": compute_bracket_tests,
        "continuing": compute_extrapolations,
        "joining": compute_joined_spectrum,
    }
    (functions_by_result[sys.argv[1]] if len(sys.argv) > 1 else write_page)()
