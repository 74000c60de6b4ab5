"""Compare the speed of stiction with other programs and libraries, and check that their results agree."""

import numpy as np
import plain
from measure import median_time
from stiction import HertzCylinder, Profile, Study, press, random_phases, weierstrass_mandelbrot_family
from stiction.solve.member_solution import compute_member_arrays

NUM_POINTS, PROFILE_LENGTH = 150_000, 40.0
CONTACT_SUM_NAMES = ("contact_count", "contact_area", "normal_elastic", "tangential_elastic", "normal_frictional",
        "tangential_frictional", "normal_adhesive", "tangential_adhesive")  # fmt: skip


def compare_with_plain_program() -> list[tuple[str, str]]:
    study = Study.named("figure6").with_changes({"ensemble.repetitions": 1})
    approaches = study.contact.loading_steps()
    our_time = median_time(lambda: compute_member_arrays(study, 0), 5) / 50
    sums = compute_member_arrays(study, 0)
    plain_times, largest_relative_difference = [], 0.0
    for dimension_index in (0, 25):  # indices of the fractal dimensions 1.00 and 1.357
        dimension = study.surfaces.fractal_dimensions()[dimension_index]

        def press_with_plain_program(dimension=dimension):
            upper, lower = (
                plain.generate_profile(
                    random_phases(2016, side=side), dimension, extent=PROFILE_LENGTH, points=NUM_POINTS, amplitude=0.1
                )
                for side in ("upper", "lower")
            )
            return plain.press(upper, lower, PROFILE_LENGTH / NUM_POINTS, approaches)

        plain_times.append(
            median_time(
                lambda press_with_plain_program=press_with_plain_program: assert_finite(press_with_plain_program()), 1
            )
        )
        plain_sums = press_with_plain_program()
        our_sums = np.array([sums[name][dimension_index, 0] for name in CONTACT_SUM_NAMES])
        assert np.array_equal(our_sums[0], plain_sums[0])
        largest_relative_difference = max(
            largest_relative_difference,
            float((np.abs(our_sums - plain_sums) / np.maximum(np.abs(plain_sums), 1e-300)).max()),
        )
    # Tolerance for the plain program, whose round-off gives phase errors of 4e-7 rad at the highest frequency.
    assert largest_relative_difference < 1e-3, largest_relative_difference
    return [
        ("plain NumPy/SciPy program, time relative to a pair on one thread", f"{np.mean(plain_times) / our_time:.0f}"),
        ("largest relative difference of a sum; contact counts are equal", f"{largest_relative_difference:.0e}"),
    ]


def assert_finite(values: np.ndarray) -> None:
    assert np.isfinite(values).all()


def compare_profile_generators() -> list[tuple[str, str]]:
    phases = random_phases(2016)
    dimensions = Study.named("figure6").surfaces.fractal_dimensions()
    profiles = weierstrass_mandelbrot_family(phases, dimensions)
    stiction_time = median_time(lambda: weierstrass_mandelbrot_family(phases, dimensions), 5)
    plain_time = (
        median_time(
            lambda: plain.generate_profile(phases, 1.3, extent=PROFILE_LENGTH, points=NUM_POINTS, amplitude=0.1), 1
        )
        * 50
    )
    rows = [("direct sum in NumPy, time relative to the family of 50 profiles", f"{plain_time / stiction_time:.0f}")]
    import finufft

    # Compute a non-uniform transform per frequency group (40 wavelengths, 150 000 points), and then the matrix product.
    m, n = np.arange(1, 41), np.arange(40)
    cosine_waves = np.cos(np.pi * m / 40)[:, None] * 1.5 ** n[None, :] * (PROFILE_LENGTH / NUM_POINTS)
    angle = 2 * np.pi * (cosine_waves - np.rint(cosine_waves))
    frequency_weights = np.log(1.5) * 1.5 ** (2 * n[None, :] * (dimensions[:, None] - 2))

    def generate_by_finufft():
        phase_groups = np.empty((40, NUM_POINTS))
        for k in range(40):
            # FINUFFT numbers modes from -N/2, so multiply the amplitudes by the phase at the first point.
            amplitudes = np.exp(1j * (phases[:, k] + angle[:, k] * (NUM_POINTS // 2)))
            sums = finufft.nufft1d1(
                np.ascontiguousarray(angle[:, k]), amplitudes, NUM_POINTS, eps=1e-12, isign=1, nthreads=1
            )
            phase_groups[k] = np.cos(phases[:, k]).sum() - sums.real
        return frequency_weights @ phase_groups

    finufft_profiles = generate_by_finufft()
    relative_difference = np.abs(finufft_profiles - profiles).max() / np.ptp(profiles, axis=1).min()
    assert relative_difference < 1e-8, relative_difference
    finufft_time = median_time(generate_by_finufft, 3)
    rows.append(
        (
            "FINUFFT (eps 1e-12, one thread) and a BLAS product, time relative to the same family",
            f"{finufft_time / stiction_time:.0f}",
        )
    )
    rows.append(("largest difference of the profiles, relative to their height", f"{relative_difference:.0e}"))
    return rows


def compare_with_boundary_elements() -> list[tuple[str, str]]:
    import tamaas

    tamaas.set_log_level(tamaas.LogLevel.error)
    num_points, modulus = 8192, 10.0
    x = np.arange(num_points) / num_points
    generator = np.random.default_rng(5)
    heights = np.zeros(num_points)
    for q in range(1, 257):  # The profile is periodic and self-affine with H = 0.8.
        heights += q**-1.3 * np.cos(2 * np.pi * (q * x + generator.random()))
    heights *= 0.01 / np.ptp(heights)
    lower, upper = Profile(heights, spacing=1 / num_points), Profile(np.zeros(num_points), spacing=1 / num_points)
    approaches = np.linspace(1e-5, 3e-3, 40)
    curve = press(upper, lower, approaches, law=HertzCylinder(), detection="gap-minimum")
    load = float(curve.normal_elastic[20])
    model = tamaas.ModelFactory.createModel(tamaas.model_type.basic_1d, [1.0], [num_points])
    model.E, model.nu = modulus, 0.0

    def compute_contact_fraction():
        solver = tamaas.PolonskyKeerRey(model, heights, 1e-8)
        solver.solve(load)
        return float((model.traction > 0).mean())

    area = compute_contact_fraction()
    # The asperity model gives a smaller area than the half-space model, because it neglects interaction.
    assert 0.05 < float(curve.contact_area[20]) / area < 1
    stiction_time = median_time(
        lambda: press(upper, lower, approaches, law=HertzCylinder(), detection="gap-minimum"), 20
    )
    return [
        (
            "tamaas, one load of a profile of 8192 points, time relative to a curve of 40 approaches",
            f"{median_time(compute_contact_fraction, 5) / stiction_time:.0f}",
        ),
        ("our area over tamaas' at that load", f"{float(curve.contact_area[20]) / area:.2f}"),
    ]


def run_benchmark() -> list[tuple[str, str]]:
    return compare_with_plain_program() + compare_profile_generators() + compare_with_boundary_elements()
