"""Solve random contact problems of elastic half-spaces, and check each solution with an independent reference.

    python tests/soak/half_space.py [PROBLEMS] [SEED] [HARD]

The PROBLEMS are profiles of 16 to 150 000 points and maps of up to 512 by 512 points, with periodic and free
boundaries, with and without a hardness. Heights are self-affine (Hurst exponent 0.3 to 1), flat, an arc or a spike. The
mean pressure is from 1e-4 E* h' to full contact, with the rms slope h'. The HARD problems have hardnesses of 0.001 to
2 E* h' and loads up to the hardness times the nominal area. The solver must not reject any problem, and the mean
pressure must not exceed the hardness.
"""

import sys
import time
from pathlib import Path

import numpy as np
import scipy.fft
from stiction import Profile, Surface, half_space

sys.path.insert(0, str(Path(__file__).parents[1]))
from reference import dense_half_space

NUM_PROBLEMS, SEED, NUM_HARD_PROBLEMS = 200, 2026, 1000
SOLVER_TOLERANCE = 1e-6
ROUND_OFF = 1e-9
"""Allowance for round-off in the check of the solver tolerance."""
MAX_SUM_ERROR = 1e-12
"""Relative round-off of a sum of up to 262 144 numbers."""
EFFECTIVE_MODULUS = 10.0


def random_heights(random, shape):
    """Return random heights with an rms slope of 1 on a grid spacing of 1 µm, and a text that describes them."""
    kind = random.choice(["self-affine", "self-affine", "self-affine", "grid", "spike", "flat", "arc"])
    if kind == "flat":
        return np.zeros(shape), kind
    if kind == "spike":
        z = np.zeros(shape)
        z[tuple(random.integers(0, n) for n in shape)] = 1.0
        return z, kind
    if kind == "arc":
        return -sum(np.square(axis - axis.mean()) for axis in np.meshgrid(*map(np.arange, shape), indexing="ij")) * (
            1.0 / max(shape)
        ), kind
    hurst = random.uniform(0.3, 1.0)
    shortest = 2.0 if kind == "grid" else random.choice([2.0, 4.0, 16.0])
    band = np.exp(random.uniform(np.log(2), np.log(4000)))
    frequencies = [np.abs(scipy.fft.fftfreq(n)) for n in shape[:-1]] + [scipy.fft.rfftfreq(shape[-1])]
    k = np.sqrt(sum(np.square(axis) for axis in np.meshgrid(*frequencies, indexing="ij")))
    is_in_band = (k > 0) & (k <= 1 / shortest) & (k >= 1 / (shortest * band))
    if not is_in_band.any():
        return np.zeros(shape), "flat"
    noise = random.normal(size=k.shape) + 1j * random.normal(size=k.shape)
    amplitude = np.where(is_in_band, np.where(k > 0, k, 1.0) ** (-hurst - len(shape) / 2), 0.0)
    z = scipy.fft.irfftn(amplitude * noise, shape)
    slope = np.sqrt(sum(np.mean(np.square(np.diff(z, axis=axis))) for axis in range(z.ndim)))
    return z / slope, f"{kind} H {hurst:.2f} band {band:.0f} shortest {shortest:g}"


def random_problem(random):
    """Return two bodies, a load, further arguments of `half_space`, and a text that describes the problem."""
    if random.random() < 0.5:
        shape = (int(np.exp(random.uniform(np.log(16), np.log(150_000)))),)
    else:
        shape = tuple(int(np.exp(random.uniform(np.log(8), np.log(512)))) for _ in range(2))
    periodic = bool(random.random() < 0.5)
    z, description = random_heights(random, shape)
    slope = np.exp(random.uniform(np.log(1e-4), np.log(3.0)))
    z = slope * z
    pressure = EFFECTIVE_MODULUS * slope * np.exp(random.uniform(np.log(1e-4), np.log(3.0)))
    hardness = pressure * np.exp(random.uniform(np.log(1.01), np.log(100.0))) if random.random() < 0.25 else None
    description = (
        f"{shape} {description} slope {slope:.1e} p/E*h' {pressure / EFFECTIVE_MODULUS / slope:.1e} hardness/p "
        + (f"{hardness / pressure:.2f}" if hardness else "none")
    )
    return assemble_problem(z, pressure, hardness, periodic, description)


def random_problem_with_hardness(random):
    """Return a random problem with a hardness that limits the pressure."""
    axes = 1 if random.random() < 0.4 else 2
    shape = tuple(int(np.exp(random.uniform(np.log(32), np.log(513)))) for _ in range(axes))
    z, description = random_heights(random, shape)
    slope = np.exp(random.uniform(np.log(1e-3), 0.0))
    hardness = EFFECTIVE_MODULUS * slope * np.exp(random.uniform(np.log(1e-3), np.log(2.0)))
    load_fraction = np.exp(random.uniform(np.log(1e-4), 0.0)) if random.random() < 0.5 else random.uniform(0.5, 0.9999)
    relative_hardness = hardness / EFFECTIVE_MODULUS / slope
    description = f"{shape} {description} slope {slope:.1e} H/E*h' {relative_hardness:.1e} F/(H A0) {load_fraction:.4f}"
    return assemble_problem(slope * z, load_fraction * hardness, hardness, bool(random.random() < 0.5), description)


def assemble_problem(z, pressure, hardness, periodic, description):
    """Return a body on a flat, the load, other arguments of `half_space`, and the description with the boundary."""
    body = Profile if z.ndim == 1 else Surface
    arguments = {"boundary": "periodic" if periodic else "free", "hardness": hardness, "tolerance": SOLVER_TOLERANCE}
    bodies = (body(values, spacing=1.0) for values in (np.zeros(z.shape), z))
    return *bodies, pressure * float(z.size), arguments, f"{arguments['boundary']} {description}"


def find_solution_violations(lower, load, arguments, curve):
    """Return the contact conditions that the pressure of a solution violates, as texts."""
    hardness = arguments["hardness"] or np.inf
    faults = dense_half_space.find_violations(
        curve.contact(0).pressure,
        lower.heights.max() - lower.heights,
        (1.0,) * lower.heights.ndim,
        EFFECTIVE_MODULUS,
        load,
        periodic=arguments["boundary"] == "periodic",
        tolerance=SOLVER_TOLERANCE + ROUND_OFF,
        hardness=hardness,
    )
    area = float(curve.contact_area[0])
    if not load / area <= hardness * (1 + MAX_SUM_ERROR):
        faults.append(f"mean pressure {load / area / hardness:.4f} of the hardness")
    return faults


def main(num_problems=NUM_PROBLEMS, seed=SEED, num_hard_problems=NUM_HARD_PROBLEMS):
    """Solve all problems, print the slow, rejected and wrong solutions, and return the number of failures."""
    num_wrong = solve_problems(random_problem, num_problems, seed)[1]
    num_rejected, num_wrong_hard = solve_problems(random_problem_with_hardness, num_hard_problems, seed)
    return num_wrong + num_rejected + num_wrong_hard


def solve_problems(create_problem, num_problems, seed):
    """Solve random problems, and return the number of rejected problems and the number of wrong solutions."""
    random = np.random.default_rng(seed)
    num_rejected = num_wrong = 0
    iterations, times = [], []
    for number in range(num_problems):
        upper, lower, load, arguments, description = create_problem(random)
        start = time.process_time()
        try:
            curve = half_space(upper, lower, [load], effective_modulus=EFFECTIVE_MODULUS, **arguments)
        except RuntimeError as error:
            num_rejected += 1
            print(f"{number}: rejected: {description}: {error} ({time.process_time() - start:.1f} s)", flush=True)
            continue
        times.append(time.process_time() - start)
        iterations.append(int(curve.iterations[0]))
        if faults := find_solution_violations(lower, load, arguments, curve):
            num_wrong += 1
            print(f"{number}: WRONG: {description}: {', '.join(faults)}", flush=True)
        if iterations[-1] > 300:
            print(f"{number}: slow: {iterations[-1]} iterations, {times[-1]:.1f} s: {description}", flush=True)
    if times:
        print(
            f"seed {seed}: {num_problems} problems, {num_rejected} rejected, {num_wrong} wrong; "
            f"iterations: median {np.median(iterations):.0f}, 95 % {np.quantile(iterations, 0.95):.0f}, "
            f"most {max(iterations)}; processor time: median {np.median(times):.2f} s, most {max(times):.1f} s",
            flush=True,
        )
    return num_rejected, num_wrong


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])) != 0)
