"""Solve random problems of the elastic half-space: each is solved within the tolerance, or rejected.

    python tests/soak/half_space.py [PROBLEMS] [SEED] [HARD]

Lines of 16 to 150 000 points and maps of up to 512 a side; Hurst exponents 0.3 to 1, bands up to 4000:1 and up to the
grid; steep, nearly flat, flat, a spike; mean pressures from 1e-4 E* h' to full contact; periodic and free, with and
without a hardness. Then HARD problems of 32 to 512 points a side with hardnesses from 0.001 to 2 E* h' under loads up
to all that they bear: none may be refused, no mean pressure above the hardness.
"""

import sys
import time
from pathlib import Path

import numpy as np
import scipy.fft
from stiction import Profile, Surface, half_space

sys.path.insert(0, str(Path(__file__).parents[1]))
from reference import dense_half_space

PROBLEMS, SEED, HARD = 200, 2026, 1000
TOLERANCE = 1e-6
ROUND_OFF = 1e-9
"""Tolerance of the checks that are made anew, in the unit of the error."""
SUMS = 1e-12
"""Round-off of a load over hardness, by sums of up to 262 144 numbers."""
MODULUS = 10.0


def heights(random, shape):
    """A rough body of rms slope 1 on points 1 µm apart, and in words what it is."""
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
    waves = [np.abs(scipy.fft.fftfreq(n)) for n in shape[:-1]] + [scipy.fft.rfftfreq(shape[-1])]
    k = np.sqrt(sum(np.square(axis) for axis in np.meshgrid(*waves, indexing="ij")))
    inside = (k > 0) & (k <= 1 / shortest) & (k >= 1 / (shortest * band))
    if not inside.any():
        return np.zeros(shape), "flat"
    noise = random.normal(size=k.shape) + 1j * random.normal(size=k.shape)
    amplitude = np.where(inside, np.where(k > 0, k, 1.0) ** (-hurst - len(shape) / 2), 0.0)
    z = scipy.fft.irfftn(amplitude * noise, shape)
    slope = np.sqrt(sum(np.mean(np.square(np.diff(z, axis=axis))) for axis in range(z.ndim)))
    return z / slope, f"{kind} H {hurst:.2f} band {band:.0f} shortest {shortest:g}"


def problem(random):
    """Two bodies and the arguments of `half_space`, and in words what they are."""
    if random.random() < 0.5:
        shape = (int(np.exp(random.uniform(np.log(16), np.log(150_000)))),)
    else:
        shape = tuple(int(np.exp(random.uniform(np.log(8), np.log(512)))) for _ in range(2))
    periodic = bool(random.random() < 0.5)
    z, words = heights(random, shape)
    slope = np.exp(random.uniform(np.log(1e-4), np.log(3.0)))
    z = slope * z
    pressure = MODULUS * slope * np.exp(random.uniform(np.log(1e-4), np.log(3.0)))
    hardness = pressure * np.exp(random.uniform(np.log(1.01), np.log(100.0))) if random.random() < 0.25 else None
    words = f"{shape} {words} slope {slope:.1e} p/E*h' {pressure / MODULUS / slope:.1e} hardness/p " + (
        f"{hardness / pressure:.2f}" if hardness else "none"
    )
    return posed(z, pressure, hardness, periodic, words)


def hard_problem(random):
    """The same, of bodies whose hardness matters."""
    axes = 1 if random.random() < 0.4 else 2
    shape = tuple(int(np.exp(random.uniform(np.log(32), np.log(513)))) for _ in range(axes))
    z, words = heights(random, shape)
    slope = np.exp(random.uniform(np.log(1e-3), 0.0))
    hardness = MODULUS * slope * np.exp(random.uniform(np.log(1e-3), np.log(2.0)))
    share = np.exp(random.uniform(np.log(1e-4), 0.0)) if random.random() < 0.5 else random.uniform(0.5, 0.9999)
    words = f"{shape} {words} slope {slope:.1e} H/E*h' {hardness / MODULUS / slope:.1e} F/(H A0) {share:.4f}"
    return posed(slope * z, share * hardness, hardness, bool(random.random() < 0.5), words)


def posed(z, pressure, hardness, periodic, words):
    """A body on a flat as arguments of `half_space`, and in words."""
    body = Profile if z.ndim == 1 else Surface
    arguments = {"boundary": "periodic" if periodic else "free", "hardness": hardness, "tolerance": TOLERANCE}
    bodies = (body(values, spacing=1.0) for values in (np.zeros(z.shape), z))
    return *bodies, pressure * float(z.size), arguments, f"{arguments['boundary']} {words}"


def wrong(lower, load, arguments, curve):
    """What is not as it should be, computed from the pressure alone; empty if all is."""
    hardness = arguments["hardness"] or np.inf
    faults = dense_half_space.faults(
        curve.contact(0).pressure,
        lower.heights.max() - lower.heights,
        (1.0,) * lower.heights.ndim,
        MODULUS,
        load,
        periodic=arguments["boundary"] == "periodic",
        tolerance=TOLERANCE + ROUND_OFF,
        hardness=hardness,
    )
    area = float(curve.contact_area[0])
    if not load / area <= hardness * (1 + SUMS):
        faults.append(f"mean pressure {load / area / hardness:.4f} of the hardness")
    return faults


def main(problems=PROBLEMS, seed=SEED, hard=HARD):
    """Solve them, print what is slow, refused or wrong, and the counts."""
    failed = solved_all(problem, problems, seed)[1]
    refused, broken = solved_all(hard_problem, hard, seed)
    return failed + refused + broken


def solved_all(pose, problems, seed):
    """How many of the problems are refused and how many answered wrongly."""
    random = np.random.default_rng(seed)
    refused = failed = 0
    iterations, times = [], []
    for number in range(problems):
        upper, lower, load, arguments, words = pose(random)
        start = time.process_time()
        try:
            curve = half_space(upper, lower, [load], effective_modulus=MODULUS, **arguments)
        except RuntimeError as error:
            refused += 1
            print(f"{number}: refused: {words}: {error} ({time.process_time() - start:.1f} s)", flush=True)
            continue
        times.append(time.process_time() - start)
        iterations.append(int(curve.iterations[0]))
        if faults := wrong(lower, load, arguments, curve):
            failed += 1
            print(f"{number}: WRONG: {words}: {', '.join(faults)}", flush=True)
        if iterations[-1] > 300:
            print(f"{number}: slow: {iterations[-1]} iterations, {times[-1]:.1f} s: {words}", flush=True)
    if times:
        print(
            f"seed {seed}: {problems} problems, {refused} refused, {failed} wrong; "
            f"iterations: median {np.median(iterations):.0f}, 95 % {np.quantile(iterations, 0.95):.0f}, "
            f"most {max(iterations)}; processor time: median {np.median(times):.2f} s, most {max(times):.1f} s",
            flush=True,
        )
    return refused, failed


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])) != 0)
