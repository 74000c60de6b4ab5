#include "stiction/spline.hpp"

#include "gsl.hpp"
#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>
#include <string>
#include <vector>

namespace stiction {
namespace {

void check(Values heights, double spacing, std::size_t size, std::span<double> slope, std::span<double> curvature) {
  if (heights.size() < 4) {
    throw std::invalid_argument("natural_spline: heights has " + std::to_string(heights.size()) +
                                " values, at least 4 are needed");
  }
  if (!(spacing > 0.0)) {
    throw std::invalid_argument("natural_spline: spacing is " + std::to_string(spacing) + " µm, must be above 0");
  }
  if (slope.size() != size || curvature.size() != size) {
    throw std::invalid_argument("natural_spline: slope and curvature must be as long as heights");
  }
}

// ---- The load of the spline's tridiagonal system --------------------------------------------------------------------
//
// f''_(i-1) + 4 f''_i + f''_(i+1) = 6 (y_(i-1) - 2 y_i + y_(i+1)) / Δx², and f'' = 0 at both ends.

double load_scale(double spacing) { return 6.0 / (spacing * spacing); }

STICTION_MULTIVERSION
void loads(const double* heights, std::size_t size, double scale, double* result) {
  for (std::size_t i = 0; i < size; ++i) {
    const double* y = heights + i;
    result[i] = scale * ((y[1] - y[0]) - (y[0] - y[-1]));
  }
}

// The mean of the two cubics' slopes at a point, which are equal: symmetric in x, so a mirrored profile has mirrored
// slopes to the last bit.
STICTION_MULTIVERSION
void slopes(const double* heights, const double* curvature, std::size_t size, double spacing, double* result) {
  const double of_heights = 0.5 / spacing;
  const double of_curvature = spacing / 12.0;
  for (std::size_t i = 0; i < size; ++i) {
    const double* y = heights + i;
    const double* c = curvature + i;
    result[i] = of_heights * (y[1] - y[-1]) - of_curvature * (c[1] - c[-1]);
  }
}

double first_slope(Values heights, double next_curvature, double spacing) {
  return (heights[1] - heights[0]) / spacing - spacing * next_curvature / 6.0;
}

double last_slope(Values heights, double curvature_before, double spacing) {
  const std::size_t size = heights.size();
  return (heights[size - 1] - heights[size - 2]) / spacing + spacing * curvature_before / 6.0;
}

// ---- Superposition --------------------------------------------------------------------------------------------------

// Points on each side beyond which the curvature of a unit load, 0.268^28 = 1e-16, is nothing.
constexpr std::size_t reach = 28;
// Points that are computed together.
constexpr std::size_t chunk = 256;
constexpr std::size_t width = 4 * pack_size;
static_assert((chunk + 2) % 2 == 0 && chunk % width == 0);

using Kernel = std::array<double, reach + 1>;

// Curvature at 0, 1, ..., `reach` points from a unit load, far from both ends.
const Kernel& unit_load() {
  static const Kernel kernel = [] {
    constexpr std::size_t half = 3 * reach;
    std::vector<double> load(2 * half + 1);
    std::vector<double> curvature(load.size());
    load[half] = 1.0;
    gsl::solve_tridiagonal(4.0, 1.0, load, curvature);
    Kernel result;
    std::copy_n(curvature.begin() + half, result.size(), result.begin());
    return result;
  }();
  return kernel;
}

// result[i] = Σ_k kernel[|k|] load[i + k] for i = 0, 1, ..., a whole number of widths of them.
STICTION_MULTIVERSION
void superpose(const double* load_values, const double* kernel, std::size_t size, double* result) {
  constexpr std::size_t packs = width / pack_size;
  for (std::size_t i = 0; i < size; i += width) {
    Pack sum[packs];
    const double* at = load_values + i;
    for (std::size_t p = 0; p < packs; ++p) {
      sum[p] = kernel[0] * load(at + p * pack_size);
    }
    for (std::size_t k = 1; k <= reach; ++k) {
      for (std::size_t p = 0; p < packs; ++p) {
        sum[p] += kernel[k] * (load(at + p * pack_size - k) + load(at + p * pack_size + k));
      }
    }
    for (std::size_t p = 0; p < packs; ++p) {
      store(sum[p], result + i + p * pack_size);
    }
  }
}

}  // namespace

void natural_spline(Values heights, double spacing, std::span<double> slope, std::span<double> curvature) {
  const std::size_t size = heights.size();
  check(heights, spacing, size, slope, curvature);
  std::vector<double> load(size - 2);
  loads(heights.data() + 1, size - 2, load_scale(spacing), load.data());
  curvature.front() = 0.0;
  curvature.back() = 0.0;
  gsl::solve_tridiagonal(4.0, 1.0, load, curvature.subspan(1, size - 2));
  slope.front() = first_slope(heights, curvature[1], spacing);
  slopes(heights.data() + 1, curvature.data() + 1, size - 2, spacing, slope.data() + 1);
  slope.back() = last_slope(heights, curvature[size - 2], spacing);
}

void natural_spline_from(Values heights, double spacing, Index first, std::span<double> slope,
                         std::span<double> curvature) {
  const auto size = static_cast<Index>(heights.size());
  check(heights, spacing, slope.size(), slope, curvature);
  if (first < 0 || static_cast<Index>(slope.size()) > size - first) {
    throw std::invalid_argument("natural_spline_from: the points lie beyond the profile");
  }
  const double scale = load_scale(spacing);
  const Index last = size - 1;
  // An end without curvature is a point of odd symmetry: beyond it the load is that of its mirror image, reversed.
  const auto load_at = [&](Index j) {
    const Index period = 2 * last;
    Index i = (j % period + period) % period;
    const double sign = i > last ? -1.0 : 1.0;
    i = i > last ? period - i : i;
    double load = 0.0;
    if (i > 0 && i < last) {
      loads(heights.data() + i, 1, scale, &load);
    }
    return sign * load;
  };
  constexpr auto before = static_cast<Index>(reach) + 1;
  std::array<double, chunk + width + 2 * reach> around;
  std::array<double, chunk + width> curvatures;  // from one point before the first
  for (std::size_t done = 0; done < slope.size(); done += chunk) {
    const std::size_t count = std::min(chunk, slope.size() - done);
    const Index begin = first + static_cast<Index>(done);
    const std::size_t wanted = (count + 2 + width - 1) / width * width;
    const Index load_begin = begin - before;
    const Index load_end = load_begin + static_cast<Index>(wanted + 2 * reach);
    const Index inside_begin = std::clamp<Index>(1, load_begin, load_end);
    const Index inside_end = std::clamp<Index>(last, inside_begin, load_end);
    for (Index j = load_begin; j < inside_begin; ++j) {
      around[static_cast<std::size_t>(j - load_begin)] = load_at(j);
    }
    loads(heights.data() + inside_begin, static_cast<std::size_t>(inside_end - inside_begin), scale,
          around.data() + (inside_begin - load_begin));
    for (Index j = inside_end; j < load_end; ++j) {
      around[static_cast<std::size_t>(j - load_begin)] = load_at(j);
    }
    superpose(around.data() + reach, unit_load().data(), wanted, curvatures.data());

    std::copy_n(curvatures.data() + 1, count, curvature.data() + done);
    const bool at_start = begin == 0;
    const bool at_end = begin + static_cast<Index>(count) == size;
    const std::size_t from = at_start ? 1 : 0;
    const std::size_t to = at_end ? count - 1 : count;
    if (to > from) {
      slopes(heights.data() + begin + from, curvatures.data() + 1 + from, to - from, spacing,
             slope.data() + done + from);
    }
    if (at_start) {
      slope.front() = first_slope(heights, curvatures[2], spacing);
    }
    if (at_end) {
      slope.back() = last_slope(heights, curvatures[count - 1], spacing);
    }
  }
}

}  // namespace stiction
