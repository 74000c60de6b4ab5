"""What does a pair of figure6 cost, in U, and where does it go? What do two threads gain?"""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
from measure import in_units, seconds, unit
from stiction import Study, press, random_phases, run, weierstrass_mandelbrot_family
from stiction.surfaces.profile import scaled_profile

STUDY = Study.named("figure6").with_changes({"ensemble.repetitions": 30})
PAIRS = 30 * 50
TURNS = 10
SIGNAL = np.random.default_rng(0).random(150_000)


def computed(study: Study, workers: int) -> None:
    with ThreadPoolExecutor(workers) as pool:
        run(study, executor=pool)


def two_over_one(study: Study) -> float:
    """How many times faster two threads are: the median of turns, each of one and then two."""
    gains = [seconds(lambda: computed(study, 1), 1) / seconds(lambda: computed(study, 2), 1) for _ in range(TURNS)]
    return float(np.median(gains))


def rows() -> list[tuple[str, str]]:
    fresh = seconds(lambda: np.fft.rfft(SIGNAL), 40)  # before any large block has been freed
    result = [
        ("U", f"{1e3 * unit():.2f} ms"),
        ("the same FFT in a process that has not freed large memory yet", f"{1e3 * fresh:.2f} ms"),
    ]
    for detection in ("cell", "gap-minimum"):
        study = STUDY.with_changes({"contact.detection": detection})
        cost = in_units(lambda study=study: computed(study, 1), 3) / PAIRS
        result.append((f"a pair of figure6, {detection}, one thread", f"{cost:.2f} U"))
        gain = two_over_one(study)
        result.append((f"two threads over one, {detection}, median of {TURNS}", f"{gain:.2f}"))
        share = 2 / gain - 1  # of one thread's time that a second does not shorten (Amdahl)
        four = 1 / (share + (1 - share) / 4)
        result.append((f"four threads over one, {detection}, by Amdahl's law from these", f"{four:.1f}"))

    dimensions = STUDY.surfaces.fractal_dimensions()
    phases = {side: random_phases(2016, side=side) for side in ("upper", "lower")}
    generation = 2 * in_units(lambda: weierstrass_mandelbrot_family(phases["upper"], dimensions)) / 50
    one = in_units(lambda: weierstrass_mandelbrot_family(phases["upper"], dimensions[:1]))
    families = {side: weierstrass_mandelbrot_family(p, dimensions) for side, p in phases.items()}
    scratch = np.empty((2, 150_000))
    spacing = 40 / 150_000

    def scaled():
        for upper, lower in zip(families["upper"], families["lower"], strict=True):
            yield (
                scaled_profile(upper, spacing, 0.1, "height", scratch[0]),
                scaled_profile(lower, spacing, 0.1, "height", scratch[1]),
            )

    scaling = in_units(lambda: [None for _ in scaled()]) / 50
    approaches = STUDY.contact.approaches()
    result += [
        ("generation: both bodies, 50 dimensions together", f"{generation:.2f} U a pair"),
        ("generation: one profile of one dimension", f"{one:.1f} U"),
        ("scaling of both bodies", f"{scaling:.2f} U a pair"),
    ]
    for detection in ("cell", "gap-minimum"):
        for what, steps in (("first touch only", approaches[:1]), ("40 nm only", approaches[-1:]), ("40", approaches)):
            cost = in_units(lambda s=steps, d=detection: [press(u, lo, s, detection=d) for u, lo in scaled()]) / 50
            result.append((f"contact, {detection}, approaches: {what}", f"{cost - scaling:.2f} U a pair"))
    return result
