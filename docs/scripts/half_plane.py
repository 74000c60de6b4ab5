"""Compare figure 6 with half-planes and with cylinders, and write images/half_plane.png.

    python docs/scripts/half_plane.py [DIRECTORY]

Results are stored in DIRECTORY (build/half_plane). Missing results are computed, which takes 40 minutes on one core.
With --as-is, stored results are drawn even if they are incomplete.
"""

import sys
import warnings
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from stiction import Study, friction_map, run
from stiction.solve import store

DOCS_FOLDER = Path(__file__).parents[1]

FIGURE_LOADS = (0.05, 0.25)
"""Loads of the panels, in mN."""
MU0 = 0.4
TAU0_VALUES = (0.0, 0.2)
"""tau0 in GPa."""
COLOURS_BY_TAU0 = {0.0: "#0072B2", 0.2: "#D55E00"}  # Okabe & Ito


def load_results(directory: Path) -> dict:
    half_plane_study = Study.named("figure6-half-plane")
    cylinder_study = Study().with_changes(
        {
            "surfaces.fractal_dimension": {"start": 1.0, "stop": 1.5, "count": 25},
            "surfaces.points": 131_072,
            "surfaces.band_limit": "nyquist",
            "contact.law": "hertz-cylinder",
            "contact.detection": "gap-minimum",
            "contact.sliding": ["opposing", "all"],
            "contact.approach": {"start": "0.1 nm", "stop": "100 nm", "count": 100, "spacing": "geometric"},
            "ensemble.repetitions": 50,
        }
    )
    result = {}
    for name, study in {"half-plane": half_plane_study, "cylinders": cylinder_study}.items():
        path = directory / name
        path.parent.mkdir(parents=True, exist_ok=True)
        result[name] = store.read(path) if "--as-is" in sys.argv and path.exists() else run(study, store=path).dataset
    return result


def main(directory: Path) -> None:
    results = load_results(directory)
    figure = Figure(figsize=(6.7, 4.8), dpi=200, layout="constrained")
    axes = figure.subplots(2, 2, sharex=True, sharey="row")
    for name, result in results.items():
        friction = friction_map(result, FIGURE_LOADS, mu0=[MU0], tau0=TAU0_VALUES).squeeze()
        for row, rule in enumerate(("opposing", "all")):
            for ax, load in zip(axes[row], FIGURE_LOADS, strict=True):
                for strength in TAU0_VALUES:
                    curve = friction.sel(sliding=rule, tau0=strength).sel(load=load, method="nearest")
                    dimension, mean = curve["fractal_dimension"].values, curve["friction_coefficient"].values
                    is_half_plane = name == "half-plane"
                    ax.plot(
                        dimension, mean, "-" if is_half_plane else "--", lw=1.1, color=COLOURS_BY_TAU0[strength],
                        label=f"{name}, $\\tau_0$ = {1000 * strength:g} MPa",
                    )  # fmt: skip
                    low, high = (curve[end].values for end in ("lower", "upper"))
                    ax.fill_between(
                        dimension,
                        low,
                        high,
                        color=COLOURS_BY_TAU0[strength],
                        alpha=0.25 if is_half_plane else 0.12,
                        lw=0,
                    )
                ax.set_title(f"{rule}, $F_N$ = {load:g} mN", fontsize=8)
                ax.tick_params(labelsize=7)
    for ax in axes[1]:
        ax.set_xlabel("fractal dimension $D$", fontsize=8)
    for ax in axes[:, 0]:
        ax.set_ylabel(r"$\mu_s$", fontsize=8)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=2, fontsize=7.5, frameon=False)
    figure.savefig(DOCS_FOLDER / "images/half_plane.png")
    print({name: int(np.size(result["repetition"])) for name, result in results.items()})


if __name__ == "__main__":
    warnings.filterwarnings("ignore", message=".*repetitions are finished.*")
    paths = [Path(each) for each in sys.argv[1:] if not each.startswith("--")]
    main(paths[0] if paths else DOCS_FOLDER.parent / "build/half_plane")
