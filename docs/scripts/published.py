"""Print the numbers of docs/explanation/experiments.md on published laws of rough contact.

python docs/scripts/published.py
"""

import numpy as np
from stiction import Surface, half_space, self_affine_surface

NUM_POINTS, SHORTEST_WAVELENGTH, NUM_SEEDS = 512, 8, 3
MEAN_PRESSURES_OVER_MODULUS_TIMES_SLOPE = (0.01, 0.05, 0.1, 0.2, 0.4)


def compute_contact_statistics(hurst, seed, *, wavelength_ratio=16, pressures=MEAN_PRESSURES_OVER_MODULUS_TIMES_SLOPE):
    """Return contact fraction, gap / rms height, stiffness x rms height / pressure, and Nayak's parameter."""
    rough_surface = self_affine_surface(
        seed,
        hurst_exponent=hurst,
        rms=0.02,
        shape=(NUM_POINTS, NUM_POINTS),
        spacing=1.0,
        shortest_wavelength=SHORTEST_WAVELENGTH,
        longest_wavelength=SHORTEST_WAVELENGTH * wavelength_ratio,
    )
    spectrum = np.abs(np.fft.fft2(rough_surface.heights)) ** 2
    wave_number = 2 * np.pi * np.hypot(*np.meshgrid(*[np.fft.fftfreq(NUM_POINTS)] * 2, indexing="ij"))
    m0, m2, m4 = ((spectrum * wave_number**order).sum() / NUM_POINTS**4 for order in (0, 2, 4))
    loads = np.array(pressures) * 10.0 * np.sqrt(m2) * NUM_POINTS**2
    flat_surface = Surface(np.zeros((NUM_POINTS, NUM_POINTS)), spacing=1.0)
    curve = half_space(flat_surface, rough_surface, loads, boundary="periodic", effective_modulus=10.0, tolerance=1e-5)
    pressure = loads / NUM_POINTS**2
    gap = (rough_surface.heights.max() - rough_surface.heights.mean() - curve.closure) / np.sqrt(m0)
    stiffness = curve.closure_stiffness * np.sqrt(m0) / pressure
    # Spectral moments of a profile that is cut from an isotropic surface: m2 / 2 and 3 m4 / 8.
    return curve.contact_area / NUM_POINTS**2, gap, stiffness, m0 * (3 * m4 / 8) / (m2 / 2) ** 2


def main():
    areas_by_exponent = []
    for hurst in (0.3, 0.5, 0.8):
        statistics_by_seed = [compute_contact_statistics(hurst, seed) for seed in range(NUM_SEEDS)]
        area, gap, stiffness = (np.mean([statistics[i] for statistics in statistics_by_seed], axis=0) for i in range(3))
        areas_by_exponent.append(area)
        print(f"H = {hurst}: area {np.round(area, 4)} gap {np.round(gap, 3)} K rms / p {np.round(stiffness, 2)}")
    print("spread over H:", np.round(np.ptp(areas_by_exponent, axis=0) / np.mean(areas_by_exponent, axis=0), 3))
    for wavelength_ratio in (2, 4, 8, 16, 32):
        statistics_by_seed = [
            compute_contact_statistics(0.8, seed, wavelength_ratio=wavelength_ratio, pressures=(0.1,))
            for seed in range(NUM_SEEDS)
        ]
        area, nayak = (
            np.mean([statistics[0][0] for statistics in statistics_by_seed]),
            np.mean([statistics[3] for statistics in statistics_by_seed]),
        )
        print(f"longest over shortest {wavelength_ratio}: Nayak {nayak:.2f}, area at 0.1 {area:.4f}")


if __name__ == "__main__":
    main()
