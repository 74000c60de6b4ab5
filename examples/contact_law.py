"""Compute a contact law for a discrete-element code. The law then presses a grain, which is pushed until it slides."""

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
# The command `stiction table` computes the same table and writes it to table.nc.
table = friction_table(run(study)).squeeze().sel(sliding="all")
mean = table.sel(statistic="mean")
pressure, approach = mean["pressure"].values, mean["approach"].values  # GPa, µm
friction = mean["friction_coefficient"].values

FACE_AREA = 1e4  # area of the contact face between two grains, µm²


def normal_force(overlap):
    """Return the force (mN) at a given overlap of the mean planes (µm), interpolated in the table."""
    return FACE_AREA * np.exp(np.interp(overlap, approach, np.log(pressure)))


def slip_force(force):
    """Return the tangential force (mN) at which a face under a normal force slips."""
    return force * np.interp(np.log(force / FACE_AREA), np.log(pressure), friction)


# mass (kg), time step (s) and damping (N s/m)
GRAIN_MASS, TIME_STEP, DAMPING = 1e-7, 1e-8, 0.1  # kg, s, N s/m
overlap_now, speed, slip_distance, slip_speed, history = float(approach[0]), 0.0, 0.0, 0.0, []
for step in range(6000):
    time = step * TIME_STEP
    force = normal_force(overlap_now)
    speed += TIME_STEP * ((200 - force) * 1e-3 - DAMPING * speed) / GRAIN_MASS
    overlap_now += TIME_STEP * speed * 1e6
    push = max(0.0, 4e6 * (time - 2e-5))  # mN
    net_push = max(push - slip_force(force), 0.0) if push > slip_force(force) or slip_speed > 0 else 0.0
    slip_speed += TIME_STEP * net_push * 1e-3 / GRAIN_MASS
    slip_distance += TIME_STEP * slip_speed * 1e6
    history.append((1e6 * time, overlap_now, force, push, slip_distance))
    if slip_distance > 0.5:
        break
time, overlap, normal, push, slip_distance = np.array(history).T
first = np.argmax(slip_distance > 0)
print(f"pressed to {normal[first]:.0f} mN, overlap {1000 * overlap[first]:.0f} nm; slips at {push[first]:.0f} mN")
a, b, c = (mean[name] for name in ("area_factor", "stiffness_factor", "stiffness_exponent"))
print(f"A/A0 = {float(a):.3g} p within {100 * float(mean['area_deviation']):.0f} %", end="; ")
print(f"k/A0 = {float(b):.3g} p^{float(c):.3g} within {100 * float(mean['stiffness_deviation']):.0f} %, p in GPa")

figure, (left, right) = plt.subplots(1, 2, figsize=(5.4, 2.2), layout="constrained")
left.semilogy(1000 * approach, 1000 * pressure, "o-", markersize=3, color=FORCE_COLOUR)
left.set(xlabel="overlap of the mean planes (nm)", ylabel="nominal pressure (MPa)", title="the contact law")
for values, text, colour in ((normal, "normal force", FORCE_COLOUR), (push, "push", FRICTION_COLOUR)):
    right.plot(time, values, color=colour)
    right.annotate(text, (30, values[time > 30][0]), (0, 3), textcoords="offset points", ha="right", color=colour)
right.axvline(time[first], color="0.5", linestyle=":")
right.annotate("slips", (time[first], 400), (-2, 0), textcoords="offset points", ha="right", color="0.4")
right.set(xlabel="time (µs)", ylabel="force (mN)", title="a grain that is pressed, then pushed")
figure.savefig("contact_law.png", dpi=200)
