"""Random problems for the elastic half-space: each is solved to the tolerance, as checked anew here, or refused.

    python tests/soak/half_space.py [PROBLEMS] [SEED]

Lines of 16 to 150 000 points and maps of up to 512 a side; Hurst exponents 0.3 to 1, bands up to 4000:1 and up to the
grid; steep, nearly flat, flat, a spike; mean pressures from 1e-4 E* h' to full contact; periodic and free, with and
without a hardness.
"""

import sys
import time

import numpy as np
import scipy.fft
from stiction import Profile, Surface, half_space

PROBLEMS, SEED = 200, 2026
TOLERANCE = 1e-6
ROUND_OFF = 1e-9
"""Of the checks that are made anew, in the unit of the error."""
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
    body = (lambda values: Profile(values, spacing=1.0)) if len(shape) == 1 else (lambda v: Surface(v, spacing=1.0))
    pressure = MODULUS * slope * np.exp(random.uniform(np.log(1e-4), np.log(3.0)))
    hardness = pressure * np.exp(random.uniform(np.log(1.01), np.log(100.0))) if random.random() < 0.25 else None
    words = f"{shape} {words} slope {slope:.1e} p/E*h' {pressure / MODULUS / slope:.1e} hardness/p " + (
        f"{hardness / pressure:.2f}" if hardness else "none"
    )
    arguments = {"boundary": "periodic" if periodic else "free", "hardness": hardness, "tolerance": TOLERANCE}
    load = pressure * float(np.prod(shape))
    return body(np.zeros(shape)), body(z), load, arguments, f"{arguments['boundary']} {words}"


def wrong(curve, load, hardness):
    """What is not as it should be, computed from the pressure alone; empty if all is."""
    contact = curve.contact(0)
    p, g = contact.pressure, contact.gap
    problem = curve._problem
    scale = problem.gap.std()
    if not problem.periodic:
        even = problem.kernel.displacement(np.full(p.shape, p.mean()))
        scale = max(scale, even.std())
    elif scale == 0:
        scale = p.mean() / MODULUS  # of a cell
    most = (TOLERANCE + ROUND_OFF) * scale
    capped = p >= hardness if hardness else np.zeros(p.shape, bool)
    faults = []
    if abs(p.sum() / load - 1) > ROUND_OFF:
        faults.append(f"load {p.sum() / load - 1:.1e}")
    if p.min() < 0 or (hardness and p.max() > hardness):
        faults.append("pressure beyond its bounds")
    if (open_by := np.max(g[(p > 0)], initial=0)) > most:
        faults.append(f"open under pressure {open_by / scale:.1e}")
    if (overlap := np.max(-g[~capped], initial=0)) > most:
        faults.append(f"overlap {overlap / scale:.1e}")
    return faults


def main(problems=PROBLEMS, seed=SEED):
    """Solve them, print what is slow, refused or wrong, and the counts."""
    random = np.random.default_rng(seed)
    solved = refused = failed = 0
    iterations, times = [], []
    for number in range(problems):
        upper, lower, load, arguments, words = problem(random)
        start = time.process_time()
        try:
            curve = half_space(upper, lower, [load], effective_modulus=MODULUS, **arguments)
        except RuntimeError as error:
            refused += 1
            print(f"{number}: refused: {words}: {error} ({time.process_time() - start:.1f} s)", flush=True)
            continue
        times.append(time.process_time() - start)
        iterations.append(int(curve.iterations[0]))
        if faults := wrong(curve, load, arguments["hardness"]):
            failed += 1
            print(f"{number}: WRONG: {words}: {', '.join(faults)}", flush=True)
        else:
            solved += 1
        if iterations[-1] > 300:
            print(f"{number}: slow: {iterations[-1]} iterations, {times[-1]:.1f} s: {words}", flush=True)
    print(
        f"seed {seed}: {problems} problems, {solved} solved, {refused} refused, {failed} wrong; "
        f"iterations: median {np.median(iterations):.0f}, 95 % {np.quantile(iterations, 0.95):.0f}, "
        f"most {max(iterations)}; processor time: median {np.median(times):.2f} s, most {max(times):.1f} s"
    )
    return failed


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])) != 0)
