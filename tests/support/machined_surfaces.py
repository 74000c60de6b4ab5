"""Generated machined surfaces and instrument noise: profiles and maps of unit rms, lengths in points."""

import numpy as np

GRID_SHAPES = {1: (2048,), 2: (128, 128)}


def filtered_noise(rng, shape, hurst, *, longest=None, shortest=None, stretch=1.0):
    """Return a self-affine piece of a larger field; wavelengths in points, stretched along the first axis."""
    frequencies = list(np.meshgrid(*(np.fft.fftfreq(2 * size) for size in shape), indexing="ij"))
    frequencies[0] = frequencies[0] * stretch
    radius = np.sqrt(sum(np.square(frequency) for frequency in frequencies))
    radius.flat[0] = np.inf
    amplitude = np.maximum(radius, 0 if longest is None else 1 / longest) ** (-hurst - len(shape) / 2)
    amplitude.flat[0] = 0
    if shortest is not None:
        amplitude[radius > 1 / shortest] = 0
    field = np.fft.ifftn(amplitude * np.fft.fftn(rng.normal(size=radius.shape))).real
    return unit(field[tuple(slice(size) for size in shape)])


def unit(heights):
    return heights / heights.std()


def across(rng, dimensions):
    """Return the coordinate across straight grooves, at a random angle on a map."""
    if dimensions == 1:
        return np.arange(GRID_SHAPES[1][0]) * 1.0
    angle = rng.uniform(0, np.pi)
    y, x = np.indices(GRID_SHAPES[2])
    return x * np.cos(angle) + y * np.sin(angle)


def turned(rng, dimensions, *, feed=(14, 60), rough=0.05, wander=0.15):
    """Return round cusps of random depth."""
    place = across(rng, dimensions) / rng.uniform(*feed) + rng.random()
    cusp = np.floor(place).astype(int)
    cusp -= cusp.min()
    depth = 1 + wander * rng.normal(size=cusp.max() + 1)
    shape = GRID_SHAPES[dimensions]
    return unit(depth[cusp] * np.square(place % 1 - 0.5)) + rough * filtered_noise(rng, shape, 0.8)


def milled(rng, dimensions):
    """Return sharp cusps, whose even harmonics vanish."""
    place = across(rng, dimensions) / rng.uniform(14, 60) + rng.random()
    return unit(np.abs(place % 1 - 0.5)) + 0.05 * filtered_noise(rng, GRID_SHAPES[dimensions], 0.7)


def ground(rng, dimensions, *, stretch=30.0):
    """Return grooves whose length is `stretch` times their width; infinity gives straight grooves."""
    hurst, longest = rng.uniform(0.5, 0.9), rng.uniform(30, 120)
    if dimensions == 1:
        return filtered_noise(rng, GRID_SHAPES[1], hurst, longest=longest)
    if np.isfinite(stretch):
        return filtered_noise(rng, GRID_SHAPES[2], hurst, longest=longest, stretch=stretch)
    return filtered_noise(rng, GRID_SHAPES[2][:1], hurst, longest=longest)[np.newaxis, :] + np.zeros(GRID_SHAPES[2])


def honed(rng, dimensions):
    """Return plateaus with fine roughness."""
    shape = GRID_SHAPES[dimensions]
    rough = filtered_noise(rng, shape, rng.uniform(0.6, 0.95), longest=rng.uniform(40, 100))
    return np.minimum(rough, np.quantile(rough, 0.6)) + 0.03 * filtered_noise(rng, shape, 0.8)


CLEAN = {
    "turned": turned,
    "turned roughly": lambda rng, dimensions: turned(rng, dimensions, rough=0.3),
    "turned at a fine feed": lambda rng, dimensions: turned(rng, dimensions, feed=(8, 14), wander=0, rough=0.1),
    "milled": milled,
    "ground": ground,
    "ground along straight grooves": lambda rng, dimensions: ground(rng, dimensions, stretch=np.inf),
    "honed": honed,
    "H 0.3": lambda rng, dimensions: filtered_noise(rng, GRID_SHAPES[dimensions], 0.3),
    "H 1": lambda rng, dimensions: filtered_noise(rng, GRID_SHAPES[dimensions], 1.0),
}
