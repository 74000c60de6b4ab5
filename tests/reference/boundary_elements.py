"""Solve the contact of a periodic rough profile with a flat by three methods.

The methods are the elastic half-space by boundary elements (tamaas), the asperity model, and the asperity model with
elastic interaction of the asperities.
"""

import numpy as np
from stiction import HertzCylinder, Profile, contacts

EFFECTIVE_MODULUS = 10.0  # GPa
MIN_WAVES_PER_PERIOD = 4
PERIOD = 4.0  # µm; the longest wavelength is a quarter of the period
RMS_SLOPE = 0.1
SOLVER_TOLERANCE = 1e-10

EXCESS_POINTS_PER_CONTACT = 0.38
"""Mean number of grid points by which a contact on a grid exceeds the length of the exact contact.

Measured on Westergaard's sinusoid: 0.38 +- 0.03 for contacts of 5 to 60 points at any load up to half contact.
"""

RELATIVE_LOAD_STEP = 0.02  # as a fraction of the load
NUM_WRAPPED_POINTS = 48  # number of points that are added on each side, so that the ends of the spline have no effect


def band_limited_profile(random, hurst_exponent, bandwidth, points_per_wave):
    """Return the heights of one period of a self-affine profile with rms slope 0.1.

    The wavelengths are from 1 µm down to 1 µm / bandwidth. The random phases do not depend on the number of points, so
    different grids sample the same profile.
    """
    waves = np.arange(MIN_WAVES_PER_PERIOD, MIN_WAVES_PER_PERIOD * bandwidth + 1)
    amplitude = waves ** (-0.5 - hurst_exponent)
    slope = 2 * np.pi / PERIOD * np.sqrt(0.5 * np.sum(np.square(waves * amplitude)))
    points = MIN_WAVES_PER_PERIOD * bandwidth * points_per_wave
    transform = np.zeros(points // 2 + 1, complex)
    transform[waves] = 0.5 * points * RMS_SLOPE / slope * amplitude * np.exp(2j * np.pi * random.random(waves.size))
    return np.fft.irfft(transform, points)


class PeriodicHalfSpace:
    """Elastic half-space with one period of heights (µm) in contact with a rigid flat, solved by tamaas."""

    def __init__(self, heights, period, *, tolerance=SOLVER_TOLERANCE):
        import tamaas

        tamaas.initialize(1)  # Use one thread, because the transforms are short.
        tamaas.set_log_level(tamaas.LogLevel.error)
        self.heights, self.tolerance = heights, tolerance
        self.model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_1d, [period], [heights.size])
        self.model.E, self.model.nu = EFFECTIVE_MODULUS, 0.0
        self.solver = tamaas.PolonskyKeerRey(self.model, heights, tolerance)
        self.solver.max_iter = 20_000

    def solve(self, pressure):
        """Return contact fraction, number of contacts and mean gap (µm) at a mean pressure (GPa)."""
        complementarity_error = self.solver.solve(pressure)
        traction = np.array(self.model.traction).ravel()
        if not complementarity_error <= self.tolerance or abs(traction.mean() / pressure - 1) > 1e-9:
            raise RuntimeError(
                f"no solution at {pressure} GPa: error {complementarity_error}, mean traction {traction.mean()}"
            )
        in_contact = traction > 0
        count = np.count_nonzero(in_contact & ~np.roll(in_contact, 1))
        fraction = (np.count_nonzero(in_contact) - EXCESS_POINTS_PER_CONTACT * count) / in_contact.size
        return fraction, count, float((np.array(self.model.displacement).ravel() - self.heights).mean())

    def contact_response(self, pressure):
        """Return contact fraction, number of contacts and stiffness (GPa/µm)."""
        pressures = pressure * np.array([1 - RELATIVE_LOAD_STEP, 1 + RELATIVE_LOAD_STEP])
        solution_below, solution_above = (self.solve(step) for step in pressures)
        return (
            0.5 * (solution_below[0] + solution_above[0]),
            0.5 * (solution_below[1] + solution_above[1]),
            (pressures[1] - pressures[0]) / (solution_below[2] - solution_above[2]),
        )


class PeriodicAsperities:
    """Asperity model of one period: Hertzian cylinders at the minima of the gap."""

    def __init__(self, heights, period):
        self.period, self.points = period, heights.size
        self.lower = Profile(np.pad(heights, NUM_WRAPPED_POINTS, mode="wrap"), spacing=period / heights.size)
        self.flat = Profile(np.zeros(len(self.lower)), spacing=self.lower.spacing)
        self.height = np.ptp(heights)

    def find_contacts(self, approach):
        """Return position (µm), overlap (µm), radius (µm), force (mN) and area (µm²) of each contact of one period."""
        table = contacts(
            self.flat, self.lower, approach, effective_modulus=EFFECTIVE_MODULUS, law=HertzCylinder(),
            detection="gap-minimum",
        )  # fmt: skip
        is_inside = (table.index >= NUM_WRAPPED_POINTS) & (table.index < NUM_WRAPPED_POINTS + self.points)
        return (
            values[is_inside] for values in (table.centre[:, 0], table.overlap, table.radius, table.force, table.area)
        )

    def contact_response(self, pressure):
        """Return contact fraction, number of contacts and stiffness (GPa/µm)."""
        approach, load = 10 * self.height, pressure * self.period
        # The load is a convex, piecewise linear function of the approach, so Newton's method converges from above.
        for _ in range(100):
            _, overlap, _, force, area = self.find_contacts(approach)
            stiffness = (force / overlap).sum()
            step = (force.sum() - load) / stiffness
            approach -= step
            if abs(step) < 1e-12 * self.height:
                return area.sum() / self.period, force.size, stiffness / self.period
        raise RuntimeError(f"no approach found for {pressure} GPa")

    def interacting_response(self, pressure):
        """Return contact fraction, number of contacts and stiffness (GPa/µm) with elastic interaction.

        The stiffness is NaN if too many contacts have merged.
        """
        x, overlap, radius, _, _ = self.find_contacts(self.height)
        height_below_summit, load, count = overlap.max() - overlap, pressure * self.period, x.size
        modulus = np.pi * EFFECTIVE_MODULUS
        distance = self.period / np.pi * np.abs(np.sin(np.pi * (x[:, None] - x) / self.period))

        def interaction_matrix(half_width, min_distance_factor):
            # Limit the distance of two contacts to a multiple of their half-widths, because the effect of merged
            # contacts on each other, and of a contact on itself, is singular.
            min_distance = 0.5 * min_distance_factor * (half_width[:, None] + half_width)
            return -2 / modulus * np.log(2 * np.pi / self.period * np.maximum(distance, min_distance))

        is_active = height_below_summit <= np.sort(height_below_summit)[:3].max()
        force = np.where(is_active, load / is_active.sum(), 0.0)
        for iteration in range(400):
            half_width = np.sqrt(4 * np.maximum(force, 1e-3 * load / count) * radius / modulus)
            matrix = interaction_matrix(half_width, 0.5 * np.exp(-0.5))  # mean of ln|s| over the Hertzian pressure
            active_indices = np.flatnonzero(is_active)
            system = np.ones((active_indices.size + 1, active_indices.size + 1))
            system[:-1, :-1] = matrix[np.ix_(active_indices, active_indices)]
            system[:-1, -1], system[-1, -1] = -1, 0
            *forces, approach = np.linalg.solve(system, np.append(-height_below_summit[active_indices], load))
            previous_force, force = force, np.zeros(count)
            force[active_indices] = forces
            if (force < 0).any():
                is_active &= force > 0
                force = np.maximum(force, 0)
                continue
            violation = np.where(is_active, 0, approach - height_below_summit - matrix @ force)
            has_converged = np.allclose(force, previous_force, rtol=1e-7, atol=1e-9 * load)
            if has_converged and violation.max() <= 1e-9 * self.height:
                # A small increase of the approach adds the pressure of a flat punch, over which the mean of ln|s| is
                # ln(a/2).
                tangent_matrix = interaction_matrix(half_width, 0.5)[np.ix_(active_indices, active_indices)]
                # The matrix is not positive definite if too many contacts have merged.
                is_stable = np.linalg.eigvalsh(tangent_matrix)[0] > 0
                stiffness = np.linalg.solve(tangent_matrix, np.ones(active_indices.size)).sum() if is_stable else np.nan
                return 2 * half_width[active_indices].sum() / self.period, active_indices.size, stiffness / self.period
            # After 20 iterations, activate only the asperity with the largest overlap, so that iterations do not cycle.
            is_active |= (violation > 1e-9 * self.height) & (violation >= (0 if iteration < 20 else violation.max()))
        raise RuntimeError(f"no interacting solution at {pressure} GPa")
