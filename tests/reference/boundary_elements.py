"""Periodic rough profiles pressed on a flat, at a given load, in three ways: an elastic half-space by boundary elements
(tamaas), the model on one period, and the model's asperities with the interaction that the model leaves out.
"""

import numpy as np
from stiction import HertzCylinder, Profile, contacts

EFFECTIVE_MODULUS = 10.0  # GPa
LONGEST_PER_PERIOD = 4
PERIOD = 4.0  # µm, so that the longest wave is 1 µm
RMS_SLOPE = 0.1
SOLVER_TOLERANCE = 1e-10  # of the solver's complementarity error

POINTS_TOO_MANY = 0.38
"""Mean excess length of a row of grid points under pressure over the contact, in points.

Measured on Westergaard's sinusoid: 0.38 +- 0.03 for contacts of 5 to 60 points at any load up to half contact.
"""

LOAD_STEP = 0.02  # half of the relative difference of the two loads of a stiffness
WRAP = 48  # points of the neighbouring periods on each side, so that the ends of the spline have no effect


def band_limited_profile(random, hurst_exponent, bandwidth, points_per_wave):
    """Return heights of one period: random phases, C1D ∝ q^(-1-2H) from 1 µm down to 1 µm / bandwidth, rms slope 0.1.

    The phases are drawn in the order of wavenumbers, so any number of points samples the same profile.
    """
    waves = np.arange(LONGEST_PER_PERIOD, LONGEST_PER_PERIOD * bandwidth + 1)
    amplitude = waves ** (-0.5 - hurst_exponent)
    slope = 2 * np.pi / PERIOD * np.sqrt(0.5 * np.sum(np.square(waves * amplitude)))
    points = LONGEST_PER_PERIOD * bandwidth * points_per_wave
    transform = np.zeros(points // 2 + 1, complex)
    transform[waves] = 0.5 * points * RMS_SLOPE / slope * amplitude * np.exp(2j * np.pi * random.random(waves.size))
    return np.fft.irfft(transform, points)


class PeriodicHalfSpace:
    """One period of heights (µm) on a rigid flat; q = 0 has no compliance, so the mean height does not change."""

    def __init__(self, heights, period, *, tolerance=SOLVER_TOLERANCE):
        import tamaas

        tamaas.initialize(1)  # transforms too short for threads
        tamaas.set_log_level(tamaas.LogLevel.error)
        self.heights, self.tolerance = heights, tolerance
        self.model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_1d, [period], [heights.size])
        self.model.E, self.model.nu = EFFECTIVE_MODULUS, 0.0
        self.solver = tamaas.PolonskyKeerRey(self.model, heights, tolerance)
        self.solver.max_iter = 20_000

    def pressed(self, pressure):
        """Return contact fraction, number of contacts and mean gap (µm) at a mean pressure (GPa)."""
        error = self.solver.solve(pressure)
        traction = np.array(self.model.traction).ravel()
        if not error <= self.tolerance or abs(traction.mean() / pressure - 1) > 1e-9:
            raise RuntimeError(f"no solution at {pressure} GPa: error {error}, mean traction {traction.mean()}")
        touching = traction > 0
        count = np.count_nonzero(touching & ~np.roll(touching, 1))
        fraction = (np.count_nonzero(touching) - POINTS_TOO_MANY * count) / touching.size
        return fraction, count, float((np.array(self.model.displacement).ravel() - self.heights).mean())

    def at(self, pressure):
        """Return contact fraction, number of contacts and stiffness (GPa/µm)."""
        steps = pressure * np.array([1 - LOAD_STEP, 1 + LOAD_STEP])
        below, above = (self.pressed(step) for step in steps)
        return 0.5 * (below[0] + above[0]), 0.5 * (below[1] + above[1]), (steps[1] - steps[0]) / (below[2] - above[2])


class PeriodicAsperities:
    """Asperity model of one period: Hertzian cylinders at the minima of the gap."""

    def __init__(self, heights, period):
        self.period, self.points = period, heights.size
        self.lower = Profile(np.pad(heights, WRAP, mode="wrap"), spacing=period / heights.size)
        self.flat = Profile(np.zeros(len(self.lower)), spacing=self.lower.spacing)
        self.height = np.ptp(heights)

    def touching(self, approach):
        """Return position (µm), overlap (µm), radius (µm), force (mN) and area (µm²) of each contact of one period."""
        table = contacts(
            self.flat, self.lower, approach, effective_modulus=EFFECTIVE_MODULUS, law=HertzCylinder(),
            detection="gap-minimum",
        )  # fmt: skip
        own = (table.index >= WRAP) & (table.index < WRAP + self.points)
        return (values[own] for values in (table.centre[:, 0], table.overlap, table.radius, table.force, table.area))

    def at(self, pressure):
        """Return contact fraction, number of contacts and stiffness (GPa/µm)."""
        approach, load = 10 * self.height, pressure * self.period
        # A sum of ramps is convex and piecewise linear: Newton's method from above needs at most one step per kink.
        for _ in range(100):
            _, overlap, _, force, area = self.touching(approach)
            stiffness = (force / overlap).sum()  # the law is linear
            step = (force.sum() - load) / stiffness
            approach -= step
            if abs(step) < 1e-12 * self.height:
                return area.sum() / self.period, force.size, stiffness / self.period
        raise RuntimeError(f"no approach found for {pressure} GPa")

    def interacting(self, pressure):
        """Return the results of `at` with elastic interaction: all loads displace each asperity.

        The stiffness is NaN if too many contacts have merged.
        """
        x, overlap, radius, _, _ = self.touching(self.height)
        depth, load, count = overlap.max() - overlap, pressure * self.period, x.size
        modulus = np.pi * EFFECTIVE_MODULUS
        distance = self.period / np.pi * np.abs(np.sin(np.pi * (x[:, None] - x) / self.period))

        def influence(half_width, own):
            # A contact acts on its own crest from a distance of `own` half-widths; no neighbour acts from a smaller
            # distance, even if merged.
            nearest = 0.5 * own * (half_width[:, None] + half_width)
            return -2 / modulus * np.log(2 * np.pi / self.period * np.maximum(distance, nearest))

        active = depth <= np.sort(depth)[:3].max()
        force = np.where(active, load / active.sum(), 0.0)
        for round_ in range(400):
            half_width = np.sqrt(4 * np.maximum(force, 1e-3 * load / count) * radius / modulus)
            matrix = influence(half_width, 0.5 * np.exp(-0.5))  # the mean of ln|s| over Hertz' pressure
            on = np.flatnonzero(active)
            system = np.ones((on.size + 1, on.size + 1))
            system[:-1, :-1] = matrix[np.ix_(on, on)]
            system[:-1, -1], system[-1, -1] = -1, 0
            *forces, approach = np.linalg.solve(system, np.append(-depth[on], load))
            before, force = force, np.zeros(count)
            force[on] = forces
            if (force < 0).any():
                active &= force > 0
                force = np.maximum(force, 0)
                continue
            short = np.where(active, 0, approach - depth - matrix @ force)
            settled = np.allclose(force, before, rtol=1e-7, atol=1e-9 * load)
            if settled and short.max() <= 1e-9 * self.height:
                # A small further approach adds the pressure of a flat punch, over which the mean of ln|s| is ln(a/2).
                tangent = influence(half_width, 0.5)[np.ix_(on, on)]
                stable = np.linalg.eigvalsh(tangent)[0] > 0  # unless too many have merged
                stiffness = np.linalg.solve(tangent, np.ones(on.size)).sum() if stable else np.nan
                return 2 * half_width[on].sum() / self.period, on.size, stiffness / self.period
            # First all short ones at the same time; later only the worst, to avoid cycles.
            active |= (short > 1e-9 * self.height) & (short >= (0 if round_ < 20 else short.max()))
        raise RuntimeError(f"no interacting solution at {pressure} GPa")
