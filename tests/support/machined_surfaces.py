"""Generators of machined surfaces with an rms height of 1. Lengths are in grid points."""

import numpy as np

GRID_SHAPES = {1: (2048,), 2: (128, 128)}


def filtered_noise(rng, shape, hurst, *, longest_wavelength=None, shortest_wavelength=None, stretch=1.0):
    """Return self-affine noise with wavelengths between two limits, stretched along the first axis."""
    frequencies = list(np.meshgrid(*(np.fft.fftfreq(2 * size) for size in shape), indexing="ij"))
    frequencies[0] = frequencies[0] * stretch
    radius = np.sqrt(sum(np.square(frequency) for frequency in frequencies))
    radius.flat[0] = np.inf
    amplitude = np.maximum(radius, 0 if longest_wavelength is None else 1 / longest_wavelength) ** (
        -hurst - len(shape) / 2
    )
    amplitude.flat[0] = 0
    if shortest_wavelength is not None:
        amplitude[radius > 1 / shortest_wavelength] = 0
    field = np.fft.ifftn(amplitude * np.fft.fftn(rng.normal(size=radius.shape))).real
    return scale_to_unit_rms(field[tuple(slice(size) for size in shape)])


def scale_to_unit_rms(heights):
    return heights / heights.std()


def coordinate_across_grooves(rng, dimensions):
    """Return the coordinate perpendicular to straight grooves. On a map, the grooves have a random angle."""
    if dimensions == 1:
        return np.arange(GRID_SHAPES[1][0]) * 1.0
    angle = rng.uniform(0, np.pi)
    y, x = np.indices(GRID_SHAPES[2])
    return x * np.cos(angle) + y * np.sin(angle)


def turned_surface(rng, dimensions, *, feed=(14, 60), rough=0.05, depth_variation=0.15):
    """Return a turned surface, which has rounded cusps of random depth and added noise."""
    position = coordinate_across_grooves(rng, dimensions) / rng.uniform(*feed) + rng.random()
    cusp = np.floor(position).astype(int)
    cusp -= cusp.min()
    depth = 1 + depth_variation * rng.normal(size=cusp.max() + 1)
    shape = GRID_SHAPES[dimensions]
    return scale_to_unit_rms(depth[cusp] * np.square(position % 1 - 0.5)) + rough * filtered_noise(rng, shape, 0.8)


def milled_surface(rng, dimensions):
    """Return a milled surface with sharp triangular cusps, whose spectrum has no even harmonics."""
    position = coordinate_across_grooves(rng, dimensions) / rng.uniform(14, 60) + rng.random()
    return scale_to_unit_rms(np.abs(position % 1 - 0.5)) + 0.05 * filtered_noise(rng, GRID_SHAPES[dimensions], 0.7)


def ground_surface(rng, dimensions, *, stretch=30.0):
    """Return a ground surface, whose grooves are `stretch` times as long as wide. Infinity gives straight grooves."""
    hurst, longest = rng.uniform(0.5, 0.9), rng.uniform(30, 120)
    if dimensions == 1:
        return filtered_noise(rng, GRID_SHAPES[1], hurst, longest_wavelength=longest)
    if np.isfinite(stretch):
        return filtered_noise(rng, GRID_SHAPES[2], hurst, longest_wavelength=longest, stretch=stretch)
    return filtered_noise(rng, GRID_SHAPES[2][:1], hurst, longest_wavelength=longest)[np.newaxis, :] + np.zeros(
        GRID_SHAPES[2]
    )


def honed_surface(rng, dimensions):
    """Return a honed surface, which has plateaus with fine roughness between deep valleys."""
    shape = GRID_SHAPES[dimensions]
    coarse_heights = filtered_noise(rng, shape, rng.uniform(0.6, 0.95), longest_wavelength=rng.uniform(40, 100))
    return np.minimum(coarse_heights, np.quantile(coarse_heights, 0.6)) + 0.03 * filtered_noise(rng, shape, 0.8)


MACHINED_SURFACES = {
    "turned": turned_surface,
    "turned roughly": lambda rng, dimensions: turned_surface(rng, dimensions, rough=0.3),
    "turned at a fine feed": lambda rng, dimensions: turned_surface(
        rng, dimensions, feed=(8, 14), depth_variation=0, rough=0.1
    ),
    "milled": milled_surface,
    "ground": ground_surface,
    "ground along straight grooves": lambda rng, dimensions: ground_surface(rng, dimensions, stretch=np.inf),
    "honed": honed_surface,
    "H 0.3": lambda rng, dimensions: filtered_noise(rng, GRID_SHAPES[dimensions], 0.3),
    "H 1": lambda rng, dimensions: filtered_noise(rng, GRID_SHAPES[dimensions], 1.0),
}
