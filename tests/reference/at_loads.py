"""A mean at a load and its jackknife, from all repetitions at once and with each one really left out."""

import numpy as np
from scipy.special import stdtrit


def at_load(normal, values, load):
    """(mean, lower, upper) of values (r, k), read off where the mean of normal loads (r, k) first reaches a load."""
    count, steps = normal.shape
    curve = normal.mean(axis=0)
    index = next(
        (k for k in range(steps) if curve[k] >= load and (curve[k - 1] < load if k else curve[0] == load)), None
    )
    if index is None:
        return np.nan, np.nan, np.nan
    before = max(index - 1, 0)
    rise = curve[index] - curve[before]
    part = (load - curve[before]) / rise if rise > 0 else 1.0
    own_load, own = (each[:, before] + part * (each[:, index] - each[:, before]) for each in (normal, values))
    mean = own.mean()
    if np.count_nonzero(normal.any(axis=1)) < 2:
        return mean, np.nan, np.nan
    around = slice(max(index - 5, 0), min(index + 4, steps - 1) + 1)
    x, y = curve[around] - curve[around].mean(), values.mean(axis=0)[around]
    slope = (x * (y - y.mean())).sum() / (x * x).sum() if (x * x).sum() > 0 else 0.0
    left_out = [(np.delete(own, r).mean(), np.delete(own_load, r).mean()) for r in range(count)]
    if any(other <= 0 for _, other in left_out):
        return mean, np.nan, np.nan
    if mean != 0 and all(other / mean > 0 for other, _ in left_out):
        logarithms = [np.log(v / mean) - slope * load / mean * np.log(n / load) for v, n in left_out]
        half = _half_width(np.array(logarithms))
        return mean, *sorted([mean * np.exp(-half), mean * np.exp(half)])
    half = _half_width(np.array([v - slope * n for v, n in left_out]))
    least = -np.inf if (values < 0).any() else 0.0
    return mean, max(mean - half, least), mean + half


def _half_width(values):
    count = values.size
    deviations = values - values.mean()
    squares = (deviations**2).sum()
    kurtosis = count * (deviations**4).sum() / squares**2 if squares > 0 else 3.0
    freedom = min(max(2 * count / max(kurtosis - 1, 1e-9), 1), count - 1)
    return stdtrit(freedom, 0.975) * np.sqrt((count - 1) / count * squares)
