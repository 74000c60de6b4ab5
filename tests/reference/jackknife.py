"""Reference for intervals of means at given loads: the jackknife of docs/explanation/intervals.md, in loops."""

import math

import numpy as np
from scipy.stats import t as student_t

STEPS_AROUND_CROSSING = 4


def interval_at_load(normal, values, load):
    """Return the mean at a mean normal load, and the limits of its interval.

    Normal loads and values have the shape (steps, repetitions). The mean load must rise through the given load.
    """
    repetitions = normal.shape[1]
    mean_normal, mean_values = normal.mean(axis=1), values.mean(axis=1)
    step = next(k for k in range(1, len(normal)) if mean_normal[k - 1] < load <= mean_normal[k])
    fraction = (load - mean_normal[step - 1]) / (mean_normal[step] - mean_normal[step - 1])
    normal_at_load, values_at_load = (
        (1 - fraction) * curves[step - 1] + fraction * curves[step] for curves in (normal, values)
    )
    mean = values_at_load.mean()
    window = slice(max(step - 1 - STEPS_AROUND_CROSSING, 0), step + STEPS_AROUND_CROSSING + 1)
    slope = np.polyfit(mean_normal[window], mean_values[window], 1)[0]
    logarithms, differences = [], []
    for left_out in range(repetitions):
        change = (mean - values_at_load[left_out]) / (repetitions - 1)
        load_change = (load - normal_at_load[left_out]) / (repetitions - 1)
        differences.append(change - slope * load_change)
        if change / mean > -1 + 1e-12 and load_change / load > -1:
            exponent = slope * load / mean
            logarithms.append(math.log(1 + change / mean) - exponent * math.log(1 + load_change / load))
    if len(logarithms) == repetitions:
        factor = math.exp(half_width(logarithms))
        return mean, mean / factor, mean * factor
    return mean, max(mean - half_width(differences), 0.0), mean + half_width(differences)


def half_width(jackknife_values):
    """Return the half width of the interval, with degrees of freedom from the kurtosis of the jackknife values."""
    count = len(jackknife_values)
    deviations = np.array(jackknife_values) - np.mean(jackknife_values)
    square_sum = (deviations**2).sum()
    kurtosis = count * (deviations**4).sum() / square_sum**2
    freedom = min(max(2 * count / (kurtosis - 1), 1), count - 1)
    return student_t.ppf(0.975, freedom) * math.sqrt((count - 1) / count * square_sum)
