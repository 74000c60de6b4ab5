"""Compute a contact law for a discrete-element code, and apply it to a grain that is pressed and then pushed."""

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
mean_table = table.sel(statistic="mean")
pressure, approach = mean_table["pressure"].values, mean_table["approach"].values  # GPa, µm
friction = mean_table["friction_coefficient"].values

GRAIN_FACE_AREA = 1e4  # area of the contact face between two grains, µm²


def normal_force(overlap):
    """Return the force (mN) at a given overlap (µm) of the mean planes, interpolated in the table."""
    return GRAIN_FACE_AREA * np.exp(np.interp(overlap, approach, np.log(pressure)))


def slip_force(force):
    """Return the tangential force (mN) at which a face slips under a given normal force (mN)."""
    return force * np.interp(np.log(force / GRAIN_FACE_AREA), np.log(pressure), friction)


GRAIN_MASS, TIME_STEP, DAMPING = 1e-7, 1e-8, 0.1  # mass (kg), time step (s) and damping (N s/m)
overlap_now, speed, slip_distance, slip_speed, history = float(approach[0]), 0.0, 0.0, 0.0, []
for step in range(6000):
    time = step * TIME_STEP
    force = normal_force(overlap_now)
    speed += TIME_STEP * ((200 - force) * 1e-3 - DAMPING * speed) / GRAIN_MASS
    overlap_now += TIME_STEP * speed * 1e6
    push_force = max(0.0, 4e6 * (time - 2e-5))  # mN
    net_push_force = (
        max(push_force - slip_force(force), 0.0) if push_force > slip_force(force) or slip_speed > 0 else 0.0
    )
    slip_speed += TIME_STEP * net_push_force * 1e-3 / GRAIN_MASS
    slip_distance += TIME_STEP * slip_speed * 1e6
    history.append((1e6 * time, overlap_now, force, push_force, slip_distance))
    if slip_distance > 0.5:
        break
time, overlap, normal_forces, push_force, slip_distance = np.array(history).T
slip_index = np.argmax(slip_distance > 0)
print(
    f"pressed to {normal_forces[slip_index]:.0f} mN, overlap {1000 * overlap[slip_index]:.0f} nm; "
    f"slips at {push_force[slip_index]:.0f} mN"
)
area_factor, stiffness_factor, stiffness_exponent = (
    mean_table[name] for name in ("area_factor", "stiffness_factor", "stiffness_exponent")
)
print(f"A/A0 = {float(area_factor):.3g} p within {100 * float(mean_table['area_deviation']):.0f} %", end="; ")
print(
    f"k/A0 = {1e-6 * float(stiffness_factor):.3g} p^{float(stiffness_exponent):.3g} "
    f"within {100 * float(mean_table['stiffness_deviation']):.0f} %, p in GPa and k/A0 in GPa/µm"
)

figure, (law_axes, force_axes) = plt.subplots(1, 2, figsize=(5.4, 2.2), layout="constrained")
law_axes.semilogy(1000 * approach, 1000 * pressure, "o-", markersize=3, color=FORCE_COLOUR)
law_axes.set(xlabel="overlap of the mean planes (nm)", ylabel="nominal pressure (MPa)", title="the contact law")
for forces, label, colour in ((normal_forces, "normal force", FORCE_COLOUR), (push_force, "push", FRICTION_COLOUR)):
    force_axes.plot(time, forces, color=colour)
    force_axes.annotate(label, (30, forces[time > 30][0]), (0, 3), textcoords="offset points", ha="right", color=colour)
force_axes.axvline(time[slip_index], color="0.5", linestyle=":")
force_axes.annotate("slips", (time[slip_index], 400), (-2, 0), textcoords="offset points", ha="right", color="0.4")
force_axes.set(xlabel="time (µs)", ylabel="force (mN)", title="a grain that is pressed, then pushed")
figure.savefig("contact_law.png", dpi=200)
