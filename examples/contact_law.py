"""Contact law for a discrete-element code: a grain is pressed, then pushed until it slides."""

import matplotlib

matplotlib.use("agg")
import matplotlib.pyplot as plt
import numpy as np
from stiction import friction_table, run, table_study
from stiction.views.style import FORCE_COLOUR, FRICTION_COLOUR, MATPLOTLIB_STYLE

plt.rcParams.update(MATPLOTLIB_STYLE)

study = table_study(
    hurst_exponents=[0.8], rms=[0.05], pressures=[0.001, 0.003, 0.01, 0.03, 0.1], mu0=[0.4], points=128, repetitions=8,
)  # fmt: skip
# Or "stiction table", and xarray.open_dataset("table.nc").
table = friction_table(run(study)).squeeze().sel(sliding="all")
mean = table.sel(statistic="mean")
pressure, approach = mean["pressure"].values, mean["approach"].values  # GPa, µm
friction = mean["friction_coefficient"].values

AREA = 1e4  # µm²: contact face between two grains


def normal_force(overlap):
    """Return the force (mN) at an overlap of the mean planes (µm), interpolated in the table."""
    return AREA * np.exp(np.interp(overlap, approach, np.log(pressure)))


def strength(force):
    """Return the tangential force (mN) at which a face under a normal force slips."""
    return force * np.interp(np.log(force / AREA), np.log(pressure), friction)


# A grain of 0.1 mg is pressed to 200 mN, then pushed with increasing force, in steps of 10 ns.
MASS, STEP, DAMPING = 1e-7, 1e-8, 0.1  # kg, s, N s/m
place, speed, slid, slip, history = float(approach[0]), 0.0, 0.0, 0.0, []
for step in range(6000):
    time = step * STEP
    force = normal_force(place)
    speed += STEP * ((200 - force) * 1e-3 - DAMPING * speed) / MASS
    place += STEP * speed * 1e6
    push = max(0.0, 4e6 * (time - 2e-5))  # mN
    pushed_off = max(push - strength(force), 0.0) if push > strength(force) or slip > 0 else 0.0
    slip += STEP * pushed_off * 1e-3 / MASS
    slid += STEP * slip * 1e6
    history.append((1e6 * time, place, force, push, slid))
    if slid > 0.5:
        break
time, overlap, normal, push, slid = np.array(history).T
first = np.argmax(slid > 0)
print(f"pressed to {normal[first]:.0f} mN, overlap {1000 * overlap[first]:.0f} nm; slips at {push[first]:.0f} mN")
a, b, c = (mean[name] for name in ("area_factor", "stiffness_factor", "stiffness_exponent"))
print(f"A/A0 = {float(a):.3g} p within {100 * float(mean['area_deviation']):.0f} %", end="; ")
print(f"k/A0 = {float(b):.3g} p^{float(c):.3g} within {100 * float(mean['stiffness_deviation']):.0f} %, p in GPa")

figure, (left, right) = plt.subplots(1, 2, figsize=(5.4, 2.2), layout="constrained")
left.semilogy(1000 * approach, 1000 * pressure, "o-", markersize=3, color=FORCE_COLOUR)
left.set(xlabel="overlap of the mean planes (nm)", ylabel="nominal pressure (MPa)", title="the contact law")
for values, words, colour in ((normal, "normal force", FORCE_COLOUR), (push, "push", FRICTION_COLOUR)):
    right.plot(time, values, color=colour)
    right.annotate(words, (30, values[time > 30][0]), (0, 3), textcoords="offset points", ha="right", color=colour)
right.axvline(time[first], color="0.5", linestyle=":")
right.annotate("slips", (time[first], 400), (-2, 0), textcoords="offset points", ha="right", color="0.4")
right.set(xlabel="time (µs)", ylabel="force (mN)", title="a grain that is pressed, then pushed")
figure.savefig("contact_law.png", dpi=200)
