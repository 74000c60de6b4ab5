"""Reference for adhesion: minimise the energy as a function of the gap by L-BFGS-B."""

import numpy as np
from scipy.fft import fft2, fftfreq, ifft2
from scipy.optimize import minimize

MAX_GAP_OPENING = 60.0
"""Upper bound of the change of the gap, in adhesion ranges. At this bound, the bodies are separated."""


def minimize_energy(heights, spacing, load, gap, *, effective_modulus, work_of_adhesion, adhesion_range):
    """Return gap (µm) and pressure (GPa) of periodic bodies with the gap `heights` at a mean external load (GPa).

    Find the minimum of 1/2 (g - g0) Q (g - g0) - w Σ exp(-g/ρ) + load Σ g over g >= 0 next to `gap`, with
    Q = E*|k|/2.
    """
    rows, columns = heights.shape
    waves = 2 * np.pi * np.hypot(*np.meshgrid(fftfreq(rows, spacing), fftfreq(columns, spacing), indexing="ij"))
    strength = work_of_adhesion / adhesion_range

    def energy_and_gradient(x):
        g = x.reshape(heights.shape) * adhesion_range
        elastic_pressure = ifft2(fft2(g - heights) * waves * effective_modulus / 2).real
        attraction = strength * np.exp(-g / adhesion_range)
        energy = (elastic_pressure * (g - heights) / 2 + load * g - attraction * adhesion_range).sum()
        gradient = elastic_pressure + load + attraction
        return energy / (strength * adhesion_range), gradient.ravel() / strength

    start = gap.ravel() / adhesion_range
    bounds = [(0, MAX_GAP_OPENING + item) for item in heights.ravel() / adhesion_range]
    options = {"maxiter": 20_000, "maxfun": 50_000, "ftol": 1e-16, "gtol": 1e-9, "maxcor": 30}
    result = minimize(energy_and_gradient, start, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
    gap = result.x.reshape(heights.shape) * adhesion_range
    pressure = np.where(gap > 0, 0.0, energy_and_gradient(result.x)[1].reshape(heights.shape) * strength)
    return gap, pressure
