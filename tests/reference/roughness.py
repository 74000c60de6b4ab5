"""Reference for roughness parameters: their definitions as loops over points and sorted lists."""

import itertools
import math

import numpy as np


def height_parameters(z, spacing):
    """Return height and slope parameters by name. The name "a" stands for Ra or Pa, "q" for Rq or Pq, and so on."""
    n = len(z)
    q = math.sqrt(math.fsum(v * v for v in z) / n)
    slopes = [
        (z[i + 3] - 9 * z[i + 2] + 45 * z[i + 1] - 45 * z[i - 1] + 9 * z[i - 2] - z[i - 3]) / 60 / spacing
        for i in range(3, n - 3)
    ]
    return {
        "a": math.fsum(abs(v) for v in z) / n, "q": q, "t": max(z) - min(z),
        "sk": math.fsum(v**3 for v in z) / n / q**3, "ku": math.fsum(v**4 for v in z) / n / q**4,
        "dq": math.sqrt(math.fsum(s * s for s in slopes) / len(slopes)),
    }  # fmt: skip


def mean_section_extremes(z, count):
    """Return the mean peak height and the mean pit depth of `count` equal sections."""
    length = len(z) // count
    parts = [z[k * length : (k + 1) * length] for k in range(count)]
    return sum(max(part) for part in parts) / count, sum(-min(part) for part in parts) / count


def mean_profile_element(z, peak, pit):
    """Return the mean spacing (in points) and the mean height of the profile elements."""
    features, previous_sign = [], 0  # [sign, first point, last point] of each significant hill or dale
    for i, height in enumerate(z):
        sign = 1 if height > peak / 10 else -1 if height < -pit / 10 else 0
        if sign == 0:
            continue
        if sign == previous_sign:
            features[-1][2] = i
        else:
            features.append([sign, i, i])
        previous_sign = sign
    element_ends = []
    for (_, _, last_point), (_, next_point, _) in itertools.pairwise(features):
        crossings = [
            i + z[i] / (z[i] - z[i + 1]) for i in range(last_point, next_point) if (z[i] > 0) != (z[i + 1] > 0)
        ]
        element_ends.append((crossings[0] + crossings[-1]) / 2)
    spacings, element_heights = [], []
    for start, stop in zip(element_ends, element_ends[2:], strict=False):
        element_points = [z[i] for i in range(len(z)) if start <= i <= stop]
        spacings.append(stop - start)
        element_heights.append(max(element_points) - min(element_points))
    return sum(spacings) / len(spacings), sum(element_heights) / len(element_heights)


def height_at_material_ratio(z, ratio):
    """Return the height above which the fraction `ratio` of the points lies."""
    descending = sorted(z, reverse=True)
    position = ratio * (len(descending) - 1)
    lower_index = min(int(position), len(descending) - 2)
    return descending[lower_index] + (position - lower_index) * (descending[lower_index + 1] - descending[lower_index])


def material_ratio_at_height(z, height):
    """Return the fraction of points above a height."""
    return sum(1 for v in z if v > height) / len(z)


def stratified_parameters(z):
    """Return the parameters of stratified surfaces (Rk, Rpk, Rvk, Mrk1, Mrk2), by trying all secants of 40 %."""
    descending = sorted(z, reverse=True)
    n = len(descending)
    width = round(0.4 * n)
    start = min(range(n - width + 1), key=lambda i: descending[i] - descending[i + width - 1])
    ratios = [(i + 0.5) / n for i in range(start, start + width)]
    slope, upper = np.polyfit(ratios, descending[start : start + width], 1)
    lower = upper + slope
    heights_above_core, depths_below_core = [v - upper for v in z if v > upper], [lower - v for v in z if v < lower]
    return {
        "k": upper - lower, "pk": 2 * sum(heights_above_core) / len(heights_above_core) if heights_above_core else 0.0,
        "vk": 2 * sum(depths_below_core) / len(depths_below_core) if depths_below_core else 0.0,
        "mrk1": len(heights_above_core) / n, "mrk2": 1 - len(depths_below_core) / n,
    }  # fmt: skip


def material_and_void_volumes(z):
    """Return material and void volumes, by integrating the material ratio curve in 20 000 steps."""
    min_height, max_height = min(z), max(z)
    descending = np.sort(np.ravel(z))[::-1]
    levels = np.linspace(min_height, max_height, 20_001)
    middle = (levels[1:] + levels[:-1]) / 2
    ratios = np.array([np.searchsorted(-descending, -c) for c in middle]) / descending.size
    step = levels[1] - levels[0]

    def material_volume(ratio):
        return step * ratios[middle > height_at_material_ratio(z, ratio)].sum()

    def void_volume(ratio):
        return step * (1 - ratios[middle < height_at_material_ratio(z, ratio)]).sum()

    return {
        "Vmp": material_volume(0.1), "Vmc": material_volume(0.8) - material_volume(0.1),
        "Vvc": void_volume(0.1) - void_volume(0.8), "Vvv": void_volume(0.8)
    }  # fmt: skip


def neighbour_points(point, shape):
    """Return the neighbours of a grid point, of which there are up to eight."""
    j, i = point
    return [
        (j + b, i + a)
        for b in (-1, 0, 1)
        for a in (-1, 0, 1)
        if (a or b) and 0 <= j + b < shape[0] and 0 <= i + a < shape[1]
    ]


def wolf_pruned_peaks(heights, threshold):
    """Return the peaks after Wolf pruning, which merges hills below the threshold over their highest saddle."""
    points = [(j, i) for j in range(heights.shape[0]) for i in range(heights.shape[1])]
    peak_of = {}

    def climb_to_peak(point):
        if point not in peak_of:
            highest_neighbour = max(neighbour_points(point, heights.shape), key=lambda neighbour: heights[neighbour])
            peak_of[point] = climb_to_peak(highest_neighbour) if heights[highest_neighbour] > heights[point] else point
        return peak_of[point]

    saddles = {}
    for point in points:
        for neighbour in neighbour_points(point, heights.shape):
            a, b = climb_to_peak(point), climb_to_peak(neighbour)
            if a != b:
                level = min(heights[point], heights[neighbour])
                saddles.setdefault(a, {})
                saddles[a][b] = max(saddles[a].get(b, -math.inf), level)
    peaks = {climb_to_peak(point) for point in points}
    while len(peaks) > 1:
        lowest_peak = min(peaks, key=lambda peak: heights[peak] - max(saddles[peak].values()))
        neighbour_peak = max(saddles[lowest_peak], key=lambda neighbour: saddles[lowest_peak][neighbour])
        if heights[lowest_peak] - saddles[lowest_peak][neighbour_peak] >= threshold:
            break
        for neighbour, level in saddles.pop(lowest_peak).items():
            del saddles[neighbour][lowest_peak]
            if neighbour != neighbour_peak:
                level = max(level, saddles[neighbour_peak].get(neighbour, -math.inf))
                saddles[neighbour_peak][neighbour] = saddles[neighbour][neighbour_peak] = level
        peaks.remove(lowest_peak)
    return peaks


def feature_parameters(z, spacing):
    """Return the feature parameters Spd, Spc, S5p, S5v and S10z after Wolf pruning at 5 % of the height range."""
    threshold = 0.05 * float(z.max() - z.min())
    peaks, pits = wolf_pruned_peaks(z, threshold), wolf_pruned_peaks(-z, threshold)
    rows, columns = z.shape
    curvatures = []
    for j, i in peaks:
        if 0 < j < rows - 1 and 0 < i < columns - 1:
            curvature_y = (z[j - 1, i] - 2 * z[j, i] + z[j + 1, i]) / spacing[0] ** 2
            curvature_x = (z[j, i - 1] - 2 * z[j, i] + z[j, i + 1]) / spacing[1] ** 2
            curvatures.append(-(curvature_y + curvature_x) / 2)
    highest_peaks = sorted((z[p] for p in peaks), reverse=True)[:5]
    pit_depths = sorted(-z[p] for p in pits)[::-1][:5]
    return {
        "Spd": len(peaks) / (rows * spacing[0] * columns * spacing[1]), "Spc": sum(curvatures) / len(curvatures),
        "S5p": sum(highest_peaks) / 5, "S5v": sum(pit_depths) / 5, "S10z": (sum(highest_peaks) + sum(pit_depths)) / 5,
    }  # fmt: skip


def dominant_wavelength(z, spacing):
    """Return the wavelength of the largest Fourier coefficient, by direct sums."""
    rows, columns = z.shape
    best, result = 0.0, math.nan
    y, x = np.arange(rows)[:, np.newaxis], np.arange(columns)
    for k in range(-(rows // 2), rows // 2 + 1):
        for m in range(columns // 2 + 1):
            size = abs((z * np.exp(-2j * math.pi * (k * y / rows + m * x / columns))).sum())
            if (k, m) != (0, 0) and size > best * (1 + 1e-9):
                best = size
                result = 1 / math.hypot(k / (rows * spacing[0]), m / (columns * spacing[1]))
    return result
