"""Draw friction against each parameter, and write images/friction.png from the results of `./dev claims --columns`.

It reads build/claims/columns, which `./dev claims --repetitions 2000 --columns` writes.
"""

from pathlib import Path

import numpy as np
from claims import HIGH_AMPLITUDE, LOW_AMPLITUDE, ResampledMeans
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from stiction import gentle_friction, random_phases, weierstrass_mandelbrot_moments, weierstrass_mandelbrot_surface
from stiction.solve import store

DOCS_DIRECTORY = Path(__file__).parents[1]
RESULTS_DIRECTORY = DOCS_DIRECTORY.parent / "build/claims/columns"
MU0, TAU0, AMPLITUDE = 0.4, 0.2, 0.1
MAP_SIDE_POINTS, EXTENT = 256, 10.0
CURVE_STYLES = {
    "lines": ("#D55E00", "s", "profiles, spheres"),
    "half-spaces": ("#0072B2", "o", "height maps, half-space"),
}


def compute_gap_gradients(dimensions: np.ndarray) -> np.ndarray:
    """Return the rms gradient of the gap between two maps of the study for each D, from the exact slopes of Eq. 1."""
    values = []
    for dimension in dimensions:
        heights = [
            np.ptp(
                weierstrass_mandelbrot_surface(
                    random_phases(2016, repetition=repetition), dimension, shape=(MAP_SIDE_POINTS,) * 2, extent=EXTENT,
                    band_limit="nyquist",
                ).heights
            )
            for repetition in range(10)
        ]  # fmt: skip
        moments = weierstrass_mandelbrot_moments(dimension, shortest_wavelength=2 * EXTENT / MAP_SIDE_POINTS)
        # The variance of the slope is multiplied by 4, for two directions and two bodies.
        values.append(AMPLITUDE * np.mean(1 / np.array(heights)) * np.sqrt(4 * moments.slope))
    return np.array(values)


def draw_curve(ax: Axes, result: ResampledMeans, values: np.ndarray, name: str, *, is_hollow: bool = False) -> None:
    """Draw ensemble means over D with a 95 % band, at each D at which over 97.5 % of the resamples give a number."""
    colour, marker, label = CURVE_STYLES[name]
    has_interval = np.isfinite(values).mean(axis=0) > 0.975
    lower, upper = np.nanquantile(values[1:, has_interval], [0.025, 0.975], axis=0)
    x = result.dimensions[has_interval]
    ax.fill_between(x, lower, upper, color=colour, alpha=0.2, lw=0)
    ax.plot(
        x, values[0, has_interval], color=colour, marker=marker, ms=2 if x.size > 20 else 3, lw=0.9,
        mfc="white" if is_hollow else colour, mew=0.6, label=None if is_hollow else label,
    )  # fmt: skip


def area_exponents(result: ResampledMeans) -> np.ndarray:
    """Return the exponent of the area as a function of load, as an array (resample, D)."""
    load = np.log(result.mean_sums("normal_elastic", AMPLITUDE))
    area = np.log(result.mean_sums("contact_area", AMPLITUDE))
    load = load - load.mean(axis=2, keepdims=True)
    return np.asarray((area * load).sum(axis=2) / (load * load).sum(axis=2))


def draw_panels(axes: np.ndarray, result: ResampledMeans, name: str) -> None:
    friction, adhesive_friction = (
        result.evaluate_at("friction", result.middle_load, tau0=tau0) for tau0 in (0.0, TAU0)
    )
    loads = result.middle_load_of_all_amplitudes()
    high_amplitude_values, low_amplitude_values = (
        result.evaluate_at("friction", loads, tau0=TAU0, amplitude=a) for a in (HIGH_AMPLITUDE, LOW_AMPLITUDE)
    )
    area_at_high_mu0, area_at_low_mu0 = (result.evaluate_at("area", result.middle_load, mu0=mu0) for mu0 in (1.0, 0.1))
    for ax, values in zip(
        axes,
        (
            area_exponents(result), friction, adhesive_friction - friction, adhesive_friction,
            result.evaluate_at("friction", result.light_load) / result.evaluate_at("friction", result.heavy_load),
            friction / MU0, high_amplitude_values / low_amplitude_values,
            np.abs(area_at_high_mu0 / area_at_low_mu0 - 1),
        ),
        strict=True,
    ):  # fmt: skip
        draw_curve(ax, result, values, name)


def main() -> None:
    figure = Figure(figsize=(7.2, 4.1), dpi=200, layout="constrained")
    axes = figure.subplots(2, 4, sharex=True).ravel()
    for name in CURVE_STYLES:
        dataset = store.read(RESULTS_DIRECTORY / name)
        sliding = "opposing" if "sliding" in dataset.dims else None
        with np.errstate(divide="ignore", invalid="ignore"):
            result = ResampledMeans(dataset, AMPLITUDE, sliding=sliding)
            draw_panels(axes, result, name)
            if name == "half-spaces":
                result = ResampledMeans(dataset, AMPLITUDE, sliding="all")
                draw_curve(
                    axes[5], result, result.evaluate_at("friction", result.middle_load) / MU0, name, is_hollow=True
                )
                draw_curve(
                    axes[3], result, result.evaluate_at("friction", result.middle_load, tau0=TAU0), name, is_hollow=True
                )
        del dataset
    slopes = compute_gap_gradients(result.dimensions)
    for ax, tau0 in ((axes[1], 0.0), (axes[3], TAU0)):
        ax.plot(
            result.dimensions, gentle_friction(MU0, tau0, rms_gradient=slopes, order=2), color="0.1", lw=1, ls="--",
            label="closed form",
        )  # fmt: skip
    titles = (
        "1  exponent of area", "2  $\\mu_s$, $\\tau_0$ = 0", "3  $\\mu_s$ due to $\\tau_0$ = 200 MPa",
        "4  $\\mu_s$, $\\tau_0$ = 200 MPa",
        "5  $\\mu_s$, light / heavy load", "6  $\\mu_s/\\mu_0$", "7  $\\mu_s$, height 0.2 / 0.05 µm",
        "8  change of area by friction",
    )  # fmt: skip
    axis_ranges = ((0.6, 1.1), (0.15, 1.0), (-0.1, 0.9), (0.2, 1.2), (0.5, 1.5), (0.4, 2), (0.3, 4), (1e-3, 3))
    for ax, title, axis_range in zip(axes, titles, axis_ranges, strict=True):
        ax.set_title(title, fontsize=7.5, loc="left")
        ax.set_ylim(axis_range)
        ax.tick_params(labelsize=6.5)
    axes[6].set_yscale("log")
    axes[6].yaxis.set_ticks((0.3, 0.5, 1, 2, 4), labels=["0.3", "0.5", "1", "2", "4"])
    axes[6].yaxis.set_tick_params(which="minor", labelleft=False)
    axes[7].set_yscale("log")
    for ax in (axes[0], axes[4], axes[5], axes[6]):
        ax.axhline(1, color="0.6", lw=0.6, zorder=0)
    for ax in axes[4:]:
        ax.set_xlabel("D", fontsize=7.5)
    axes[1].legend(fontsize=5.6, frameon=False, loc="upper left", handlelength=1.4, borderaxespad=0.2)
    figure.savefig(DOCS_DIRECTORY / "images/friction.png")


if __name__ == "__main__":
    main()
