"""How results depend on the number of points: writes images/grid_dependence.png and generated/grid_dependence.md."""

from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from stiction import Study, run
from stiction.mechanics.friction import normal_load, tangential_load

DOCS = Path(__file__).parents[1]
POINTS = (37_500, 75_000, 150_000, 300_000, 600_000)
DIMENSIONS = [1.0, 1.1, 1.2, 1.3, 1.4, 1.5, 1.6, 1.7]
MU0 = 0.4


def measured(detection: str) -> dict[str, np.ndarray]:
    """Loads (mN) and area (µm²) at an approach of 10 nm, (dimension, points, repetition)."""
    columns: dict[str, list[np.ndarray]] = {"load": [], "normal": [], "tangential": [], "area": [], "below": []}
    for points in POINTS:
        study = Study().with_changes(
            {
                "surfaces.fractal_dimension": DIMENSIONS,
                "surfaces.points": points,
                "contact.detection": detection,
                "contact.approach": ["10 nm"],
                "ensemble.repetitions": 24,
            }
        )
        data = run(study).isel(amplitude=0, approach=0).transpose("fractal_dimension", "repetition")
        columns["load"].append(data["normal_elastic"].values)
        columns["normal"].append(normal_load(data, MU0, 0.0).values)
        columns["tangential"].append(tangential_load(data, MU0, 0.0).values)
        columns["area"].append(data["contact_area"].values)
        columns["below"].append((data["load_below_grid"] / data["normal_elastic"].sum("repetition")).values)
    return {name: np.stack(values, axis=1) for name, values in columns.items()}


def main() -> None:
    results = {detection: measured(detection) for detection in ("cell", "gap-minimum")}
    figure = Figure(figsize=(6.7, 4.6), dpi=200, layout="constrained")
    axes = figure.subplots(2, 3, sharex=True)
    lines = [
        "| D | detection | load at 37 500 | 150 000 | 600 000 points (mN) | μ_s at 37 500 | 150 000 | 600 000 "
        "| load on R < Δx at 150 000 |",
        "|---|---|---|---|---|---|---|---|---|",
    ]
    for row, (detection, sums) in enumerate(results.items()):
        load, area, normal, tangential = (sums[name].mean(axis=2) for name in ("load", "area", "normal", "tangential"))
        friction = np.divide(tangential, normal, out=np.full(normal.shape, np.nan), where=normal > 0)
        for d, dimension in enumerate(DIMENSIONS):
            colour = f"C{d}"
            for column, values in enumerate((load / load[:, [-1]], area / area[:, [-1]], friction)):
                axes[row, column].plot(POINTS, values[d], "o-", ms=2.5, lw=1, color=colour, label=f"{dimension:.1f}")
            shown = [f"{load[d, k]:.3g}" for k in (0, 2, 4)] + [
                f"{friction[d, k]:.3f}" if normal[d, k] > 0 else "locked" for k in (0, 2, 4)
            ]
            below = f"{100 * sums['below'][d, 2].sum():.0f} %"
            lines.append(f"| {dimension:.1f} | {detection} | {' | '.join(shown)} | {below} |")
        axes[row, 0].set_ylabel(f"{detection}\n$\\Sigma F n_z$ / that at 600 000 points")
        axes[row, 1].set_ylabel("$A$ / that at 600 000 points")
        axes[row, 2].set_ylabel(r"$\mu_s$")
    for ax in axes.flat:
        ax.set_xscale("log")
        ax.set_yscale("log")
        ax.tick_params(labelsize=7)
        ax.yaxis.label.set_size(7)
        ax.xaxis.set_ticks(POINTS, labels=["37.5", "75", "150", "300", "600"])
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
        ax.set_xlabel("points (thousands)", fontsize=7)
    figure.legend(
        *axes[0, 0].get_legend_handles_labels(), title="$D$", loc="outside right center", fontsize=7, frameon=False
    )
    figure.savefig(DOCS / "images/grid_dependence.png")
    (DOCS / "generated/grid_dependence.md").write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
