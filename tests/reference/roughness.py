"""Roughness parameters by their definitions: sums, sorted lists and walks over points, in loops."""

import itertools
import math

import numpy as np


def heights_and_slopes(z, spacing):
    """Return field parameters of heights about their mean line, by names without the profile letter."""
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


def sections(z, count):
    """Return means over equal sections of the highest point and of the depth of the lowest point."""
    length = len(z) // count
    parts = [z[k * length : (k + 1) * length] for k in range(count)]
    return sum(max(part) for part in parts) / count, sum(-min(part) for part in parts) / count


def profile_elements(z, peak, pit):
    """Return mean spacing (points) and height of the profile elements, point by point."""
    features, kind = [], 0  # sign, first and last point of each significant hill or dale
    for i, height in enumerate(z):
        now = 1 if height > peak / 10 else -1 if height < -pit / 10 else 0
        if now == 0:
            continue
        if now == kind:
            features[-1][2] = i
        else:
            features.append([now, i, i])
        kind = now
    ends = []
    for (_, _, last), (_, following, _) in itertools.pairwise(features):
        places = [i + z[i] / (z[i] - z[i + 1]) for i in range(last, following) if (z[i] > 0) != (z[i + 1] > 0)]
        ends.append((places[0] + places[-1]) / 2)
    spacings, tall = [], []
    for start, stop in zip(ends, ends[2:], strict=False):
        inside = [z[i] for i in range(len(z)) if start <= i <= stop]
        spacings.append(stop - start)
        tall.append(max(inside) - min(inside))
    return sum(spacings) / len(spacings), sum(tall) / len(tall)


def height_at(z, ratio):
    """Return the height above which a fraction of the points lies, linear between sorted points."""
    falling = sorted(z, reverse=True)
    place = ratio * (len(falling) - 1)
    below = min(int(place), len(falling) - 2)
    return falling[below] + (place - below) * (falling[below + 1] - falling[below])


def ratio_at(z, height):
    return sum(1 for v in z if v > height) / len(z)


def stratified(z):
    """Return core height, reduced peak height and pit depth, and material ratios, by trying all secants of 40 %."""
    falling = sorted(z, reverse=True)
    n = len(falling)
    width = round(0.4 * n)
    start = min(range(n - width + 1), key=lambda i: falling[i] - falling[i + width - 1])
    share = [(i + 0.5) / n for i in range(start, start + width)]
    slope, upper = np.polyfit(share, falling[start : start + width], 1)
    lower = upper + slope
    above, below = [v - upper for v in z if v > upper], [lower - v for v in z if v < lower]
    return {
        "k": upper - lower, "pk": 2 * sum(above) / len(above) if above else 0.0,
        "vk": 2 * sum(below) / len(below) if below else 0.0, "mrk1": len(above) / n, "mrk2": 1 - len(below) / n,
    }  # fmt: skip


def volumes(z):
    """Return material and void volumes, by integrating the material ratio curve in 20 000 steps."""
    low, high = min(z), max(z)
    falling = np.sort(np.ravel(z))[::-1]
    levels = np.linspace(low, high, 20_001)
    middle = (levels[1:] + levels[:-1]) / 2
    ratios = np.array([np.searchsorted(-falling, -c) for c in middle]) / falling.size
    step = levels[1] - levels[0]

    def material(ratio):
        return step * ratios[middle > height_at(z, ratio)].sum()

    def void(ratio):
        return step * (1 - ratios[middle < height_at(z, ratio)]).sum()

    return {
        "Vmp": material(0.1), "Vmc": material(0.8) - material(0.1), "Vvc": void(0.1) - void(0.8), "Vvv": void(0.8)
    }  # fmt: skip


def neighbours(point, shape):
    j, i = point
    return [
        (j + b, i + a)
        for b in (-1, 0, 1)
        for a in (-1, 0, 1)
        if (a or b) and 0 <= j + b < shape[0] and 0 <= i + a < shape[1]
    ]


def wolf_pruned_peaks(heights, threshold):
    """Return the peaks that remain after merging the lowest hills over their highest saddles."""
    points = [(j, i) for j in range(heights.shape[0]) for i in range(heights.shape[1])]
    peak_of = {}

    def climb(point):
        if point not in peak_of:
            highest = max(neighbours(point, heights.shape), key=lambda other: heights[other])
            peak_of[point] = climb(highest) if heights[highest] > heights[point] else point
        return peak_of[point]

    saddles = {}
    for point in points:
        for other in neighbours(point, heights.shape):
            a, b = climb(point), climb(other)
            if a != b:
                level = min(heights[point], heights[other])
                saddles.setdefault(a, {})
                saddles[a][b] = max(saddles[a].get(b, -math.inf), level)
    peaks = {climb(point) for point in points}
    while len(peaks) > 1:
        lowest = min(peaks, key=lambda peak: heights[peak] - max(saddles[peak].values()))
        onto = max(saddles[lowest], key=lambda other: saddles[lowest][other])
        if heights[lowest] - saddles[lowest][onto] >= threshold:
            break
        for other, level in saddles.pop(lowest).items():
            del saddles[other][lowest]
            if other != onto:
                level = max(level, saddles[onto].get(other, -math.inf))
                saddles[onto][other] = saddles[other][onto] = level
        peaks.remove(lowest)
    return peaks


def features(z, spacing):
    """Return peak density, mean curvature of inner peaks and five-point heights of pruned hills and dales."""
    threshold = 0.05 * float(z.max() - z.min())
    peaks, pits = wolf_pruned_peaks(z, threshold), wolf_pruned_peaks(-z, threshold)
    rows, columns = z.shape
    curvatures = []
    for j, i in peaks:
        if 0 < j < rows - 1 and 0 < i < columns - 1:
            along_y = (z[j - 1, i] - 2 * z[j, i] + z[j + 1, i]) / spacing[0] ** 2
            along_x = (z[j, i - 1] - 2 * z[j, i] + z[j, i + 1]) / spacing[1] ** 2
            curvatures.append(-(along_y + along_x) / 2)
    high = sorted((z[p] for p in peaks), reverse=True)[:5]
    deep = sorted(-z[p] for p in pits)[::-1][:5]
    return {
        "Spd": len(peaks) / (rows * spacing[0] * columns * spacing[1]), "Spc": sum(curvatures) / len(curvatures),
        "S5p": sum(high) / 5, "S5v": sum(deep) / 5, "S10z": (sum(high) + sum(deep)) / 5,
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
