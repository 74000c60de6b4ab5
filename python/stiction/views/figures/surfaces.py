"""Figures of generated bodies themselves: profiles of several fractal dimensions, and several length scales."""

from __future__ import annotations

from typing import Any

from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from stiction._drawing import HEIGHT_MAP
from stiction._units import exact
from stiction.studies.members import pair_of, phases_of, unscaled_profile
from stiction.studies.study import Study
from stiction.surfaces.fractal import weierstrass_mandelbrot_surface
from stiction.views.style import evenly_spread, label, new_figure

LENGTH_SCALES = (0.5, 1.0, 2.0)  # of the study's own, in the figure of length scales
AREAL_POINTS = 400  # rows and columns of a surface in a figure
MOST_PROFILES = 5


def profiles_figure(study: Study) -> Figure:
    """Profiles of several fractal dimensions, of the same phases: their whole length, and one length scale of it."""
    bodies: Any = study.surfaces
    dimensions = bodies.fractal_dimensions()
    dimensions = dimensions[evenly_spread(dimensions.size, MOST_PROFILES)]
    amplitude = float(bodies.amplitudes()[0])
    window = min(float(bodies.length_scale), float(bodies.extent))
    figure = new_figure(12 + 13 * dimensions.size)
    axes = figure.subplots(dimensions.size, 2, squeeze=False, sharex="col", sharey=True)
    for row, dimension in enumerate(dimensions):
        _, profile = pair_of(study, 0, fractal_dimension=dimension, amplitude=amplitude)
        for ax, end in zip(axes[row], (profile.extent, window), strict=True):
            shown = profile.x <= end
            ax.fill_between(profile.x[shown], profile.heights[shown], profile.heights.min(), color="0.85", linewidth=0)
            ax.plot(profile.x[shown], profile.heights[shown], color="0.2", linewidth=0.4)
            ax.set_xlim(0, end)
        axes[row, 0].set_title(f"$D$ = {dimension:.3g}", loc="left", pad=2)
    for ax in axes[-1]:
        ax.set_xlabel(label("x"))
    axes[dimensions.size // 2, 0].set_ylabel(label("height"))
    return figure


def length_scales_figure(study: Study) -> Figure:
    """Eq. 1, unscaled, for three length scales and the same phases: profiles, and surfaces without aliases."""
    bodies: Any = study.surfaces
    dimension = bodies.fractal_dimensions()[0]
    extent = float(bodies.extent)
    pixels = int(min(AREAL_POINTS, bodies.points))
    scales = [factor * float(bodies.length_scale) for factor in LENGTH_SCALES]
    figure = new_figure(66)
    axes = figure.subplots(2, len(scales), height_ratios=[1, 1.2], sharex=True)
    for column, scale in enumerate(scales):
        scaled = study.with_changes({"surfaces.length_scale": exact(scale, "um")})
        profile = unscaled_profile(scaled, 0, "lower", dimension)
        surface = weierstrass_mandelbrot_surface(
            phases_of(study, 0, "lower"), dimension, shape=(pixels, pixels), extent=extent, length_scale=scale,
            gamma=bodies.gamma, convention=bodies.convention, band_limit="nyquist",
        )  # fmt: skip
        top, bottom = axes[:, column]
        top.plot(profile.x, profile.heights - profile.heights.mean(), color="0.2", linewidth=0.4)
        top.set(title=f"$L$ = {scale:.3g} µm", xlim=(0, extent))
        heights = surface.heights - surface.heights.mean()
        image = bottom.imshow(heights, extent=(0, extent, 0, extent), origin="lower", cmap=HEIGHT_MAP)
        bar = figure.colorbar(image, ax=bottom, location="bottom", pad=0.02)
        bar.locator = MaxNLocator(3)
        bar.set_label(label("height"))
        bottom.set_xlabel(label("x"))
        bottom.tick_params(axis="x", labelbottom=True)
        if column > 0:
            bottom.tick_params(labelleft=False)
    axes[0, 0].set_ylabel(label("height"))
    axes[1, 0].set_ylabel(label("y"))
    return figure
