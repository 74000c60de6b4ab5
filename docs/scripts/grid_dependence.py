"""Measure the effect of the number of points on loads, areas and friction.

The script writes images/grid_dependence.png, generated/grid_dependence.md and generated/grid_claim.md.
"""

from pathlib import Path

import matplotlib as mpl
import numpy as np
from claims import ResampledMeans
from stiction import Study, run
from stiction.evaluate.intervals import PowerSums
from stiction.mechanics.friction import FrictionLaw
from stiction.views.style import MATPLOTLIB_STYLE, PAGE_WIDTH, fractal_dimension_colours, new_figure, save_figure

DOCS_DIRECTORY = Path(__file__).parents[1]
POINT_COUNTS = (37_500, 75_000, 150_000, 300_000, 600_000)
FRACTAL_DIMENSIONS = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7]
MU0 = 0.4

CLAIM_POINT_COUNTS = (75_000, 150_000, 300_000)
"""Numbers of grid points: half the default number, the default number, and twice the default number."""
MIDDLE_CLAIM_LOAD = 33e-6  # mN, the middle load of the other claims


def compute_grid_results(contact_detection: str) -> dict[str, np.ndarray]:
    """Return loads (mN) and area (µm²) at an approach of 10 nm, as arrays (dimension, points, repetition)."""
    columns: dict[str, list[np.ndarray]] = {"load": [], "normal": [], "tangential": [], "area": [], "below": []}
    for points in POINT_COUNTS:
        study = Study().with_changes(
            {
                "surfaces.fractal_dimension": FRACTAL_DIMENSIONS,
                "surfaces.points": points,
                "contact.detection": contact_detection,
                "contact.approach": ["10 nm"],
                "ensemble.repetitions": 24,
            }
        )
        dataset = run(study).dataset.isel(amplitude=0, approach=0).transpose("fractal_dimension", "repetition")
        columns["load"].append(dataset["normal_elastic"].values)
        columns["normal"].append(FrictionLaw(MU0, 0.0).load("normal", dataset))
        columns["tangential"].append(FrictionLaw(MU0, 0.0).load("tangential", dataset))
        columns["area"].append(dataset["contact_area"].values)
        columns["below"].append((dataset["load_below_grid"] / dataset["normal_elastic"].sum("repetition")).values)
    return {name: np.stack(values, axis=1) for name, values in columns.items()}


def ratio_of_means(numerator: np.ndarray, denominator: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the ratio of means over the last axis, and its 95 % interval by the jackknife of the ratio's logarithm."""
    numerator, denominator = np.broadcast_arrays(numerator, denominator)
    repetitions = numerator.shape[-1]

    def leave_one_out_means(values: np.ndarray) -> np.ndarray:
        return (values.sum(axis=-1, keepdims=True) - values) / (repetitions - 1)

    with np.errstate(divide="ignore", invalid="ignore"):
        ratio = np.where(denominator.mean(axis=-1) > 0, numerator.mean(axis=-1) / denominator.mean(axis=-1), np.nan)
        log_ratios = np.log(leave_one_out_means(numerator) / leave_one_out_means(denominator))
        log_ratio_columns = log_ratios.reshape(-1, repetitions).T
        is_known = np.isfinite(log_ratio_columns).all(axis=0)
        half_width = np.full(log_ratio_columns.shape[1], np.nan)
        power_sums = PowerSums((int(is_known.sum()),))
        power_sums.add((log_ratio_columns - log_ratio_columns.mean(axis=0))[:, is_known].T)
        half_width[is_known] = power_sums.half_width()
    half_width = half_width.reshape(ratio.shape)
    return ratio, ratio * np.exp(-half_width), ratio * np.exp(half_width)


def compute_resampled_areas(contact_detection: str) -> list[np.ndarray]:
    """Return the area (µm²) at `MIDDLE_CLAIM_LOAD` for each number of grid points, as arrays (resample, D).

    The studies have the same seed, so that each resample consists of the same repetitions for every number of points.
    """
    study = Study().with_changes(
        {"surfaces.fractal_dimension": FRACTAL_DIMENSIONS[:-1], "contact.detection": contact_detection}
    )
    return [
        ResampledMeans(run(study.with_changes({"surfaces.points": points})).dataset, 0.1).evaluate_at(
            "area", MIDDLE_CLAIM_LOAD
        )
        for points in CLAIM_POINT_COUNTS
    ]


def write_claim_table() -> None:
    """Write the ratios of true areas at half and double resolution, with 95 % intervals."""
    ratios_by_column = []
    for contact_detection in ("cell", "gap-minimum"):
        coarse_areas, default_areas, fine_areas = compute_resampled_areas(contact_detection)
        ratios_by_column += [coarse_areas / default_areas, default_areas / fine_areas]
    column_titles = [
        f"{ratio}, {contact_detection}"
        for contact_detection in ("cell", "gap-minimum")
        for ratio in ("75 / 150", "150 / 300")
    ]
    lines = [f"| D | {' | '.join(column_titles)} |", "|---" * (1 + len(column_titles)) + "|"]
    for index, dimension in enumerate(FRACTAL_DIMENSIONS[:-1]):
        cells = []
        for ratios in ratios_by_column:
            lower, upper = np.quantile(ratios[1:, index], [0.025, 0.975])
            cells.append(f"{ratios[0, index]:.2f} [{lower:.2f}, {upper:.2f}]")
        lines.append(f"| {dimension:.1f} | {' | '.join(cells)} |")
    (DOCS_DIRECTORY / "generated/grid_claim.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


def main() -> None:
    write_claim_table()
    with mpl.rc_context(MATPLOTLIB_STYLE):
        draw_figure()


def draw_figure() -> None:
    results = {
        contact_detection: compute_grid_results(contact_detection) for contact_detection in ("cell", "gap-minimum")
    }
    figure = new_figure(115, width=PAGE_WIDTH)
    axes = figure.subplots(2, 3, sharex=True)
    lines = [
        "| D | detection | load (mN), 37 500 points | load (mN), 150 000 points | load (mN), 600 000 points "
        "| μ_s, 37 500 points | μ_s, 150 000 points | μ_s, 600 000 points "
        "| fraction of the load on radii below the spacing, 150 000 points |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row, (contact_detection, sums) in enumerate(results.items()):
        load, normal_load = sums["load"].mean(axis=2), sums["normal"].mean(axis=2)
        ratios = (
            ratio_of_means(sums["load"], sums["load"][:, [-1]]),
            ratio_of_means(sums["area"], sums["area"][:, [-1]]),
            ratio_of_means(sums["tangential"], sums["normal"]),
        )
        friction = ratios[2][0]
        for dimension_index, (dimension, colour) in enumerate(
            zip(FRACTAL_DIMENSIONS, fractal_dimension_colours(FRACTAL_DIMENSIONS), strict=True)
        ):
            for column, (values, lower, upper) in enumerate(ratios):
                ax = axes[row, column]
                ax.fill_between(
                    POINT_COUNTS, lower[dimension_index], upper[dimension_index], color=colour, alpha=0.18, linewidth=0
                )
                ax.plot(
                    POINT_COUNTS, values[dimension_index], "o-", ms=2, lw=0.9, color=colour, label=f"{dimension:.1f}"
                )
            shown_loads = [f"{load[dimension_index, k]:.3g}" for k in (0, 2, 4)] + [
                f"{friction[dimension_index, k]:.3f}" if normal_load[dimension_index, k] > 0 else "locked"
                for k in (0, 2, 4)
            ]
            below_text = f"{100 * sums['below'][dimension_index, 2].sum():.0f} %"
            lines.append(f"| {dimension:.1f} | {contact_detection} | {' | '.join(shown_loads)} | {below_text} |")
        axes[row, 0].set_ylabel(f"{contact_detection}\n$\\Sigma F n_z$ / that at 600 000 points")
        axes[row, 1].set_ylabel("$A$ / that at 600 000 points")
        axes[row, 2].set_ylabel(r"coefficient of static friction $\mu_s$")
    for ax in axes.flat:
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.xaxis.set_ticks(POINT_COUNTS, labels=["37.5", "75", "150", "300", "600"])
        ax.minorticks_off()
    for ax in axes[:, :2].flat:
        ticks = (0.5, 1, 2, 5, 10, 30, 100)
        ax.set_ylim(0.4, 150)
        ax.yaxis.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        ax.axhline(1, color="0.7", lw=0.6, zorder=0)
    for ax in axes[:, 2]:
        ticks = (0.2, 0.3, 0.5, 1, 2, 5)
        ax.set_ylim(0.12, 10)
        ax.yaxis.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
    for ax in axes[-1]:
        ax.set_xlabel("points (thousands)")
    figure.legend(*axes[0, 0].get_legend_handles_labels(), title="$D$\nbands: 95 %", loc="outside right center")
    save_figure(figure, DOCS_DIRECTORY / "images/grid_dependence.png")
    (DOCS_DIRECTORY / "generated/grid_dependence.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
