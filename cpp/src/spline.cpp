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
    throw std::invalid_argument("natural_spline: heights must have at least 4 values, got " +
                                std::to_string(heights.size()));
  }
  if (!(spacing > 0.0)) {
    throw std::invalid_argument("natural_spline: spacing must be above 0, got " + std::to_string(spacing) + " µm");
  }
  if (slope.size() != size || curvature.size() != size) {
    throw std::invalid_argument("natural_spline: slope and curvature must be as long as heights");
  }
}

// Curvatures f'' satisfy f''_(i-1) + 4 f''_i + f''_(i+1) = 6 (y_(i-1) - 2 y_i + y_(i+1)) / Δx². At both ends, f'' = 0.

double load_scale(double spacing) { return 6.0 / (spacing * spacing); }

STICTION_MULTIVERSION
void right_sides(const double* heights, Index size, double scale, double* result) {
  for (Index i = 0; i < size; ++i) {
    const double* y = heights + i;
    result[i] = scale * ((y[1] - y[0]) - (y[0] - y[-1]));
  }
}

// The slope at a point is the mean slope of the cubics on both sides, so that mirrored heights give mirrored slopes.
STICTION_MULTIVERSION
void slopes(const double* heights, const double* curvature, Index size, double spacing, double* result) {
  const double height_factor = 0.5 / spacing;
  const double curvature_factor = spacing / 12.0;
  for (Index i = 0; i < size; ++i) {
    const double* y = heights + i;
    const double* c = curvature + i;
    result[i] = height_factor * (y[1] - y[-1]) - curvature_factor * (c[1] - c[-1]);
  }
}

double first_slope(Values heights, double next_curvature, double spacing) {
  return (heights[1] - heights[0]) / spacing - spacing * next_curvature / 6.0;
}

double last_slope(Values heights, double curvature_before, double spacing) {
  const std::size_t size = heights.size();
  return (heights[size - 1] - heights[size - 2]) / spacing + spacing * curvature_before / 6.0;
}

// Distance in grid points beyond which the curvature due to a unit load is negligible (0.268^28 = 1e-16).
constexpr Index kernel_reach = 28;
// A chunk plus one point on each side has a multiple of `stride` points.
constexpr Index stride = 32;
constexpr Index chunk = 254;
static_assert((chunk + 2) % stride == 0);

using Kernel = std::array<double, kernel_reach + 1>;

// Element k of the kernel is the curvature at a distance of k points from a unit load far from both ends of a profile.
const Kernel& unit_load() {
  static const Kernel kernel = [] {
    constexpr std::size_t middle = 3 * kernel_reach;
    std::vector<double> load(2 * middle + 1);
    std::vector<double> curvature(load.size());
    load[middle] = 1.0;
    gsl::solve_tridiagonal(4.0, 1.0, load, curvature);
    Kernel result;
    std::copy_n(curvature.begin() + middle, result.size(), result.begin());
    return result;
  }();
  return kernel;
}

// Compute result[i] = Σ_k kernel[|k|] values[i + k]. `size` must be a multiple of `stride`.
template <std::size_t Width>
STICTION_INLINE void superpose_kernel(const double* values, const double* kernel, std::size_t size, double* result) {
  constexpr std::size_t packs = 4;
  static_assert(stride % (packs * Width) == 0);
  for (std::size_t i = 0; i < size; i += packs * Width) {
    Pack<Width> sum[packs];
    for (std::size_t p = 0; p < packs; ++p) {
      sum[p] = kernel[0] * load<Width>(values + i + p * Width);
    }
    for (std::size_t k = 1; k <= kernel_reach; ++k) {
      for (std::size_t p = 0; p < packs; ++p) {
        const double* at = values + i + p * Width;
        sum[p] += kernel[k] * (load<Width>(at - k) + load<Width>(at + k));
      }
    }
    for (std::size_t p = 0; p < packs; ++p) {
      store<Width>(sum[p], result + i + p * Width);
    }
  }
}

STICTION_KERNEL(superpose, (const double* values, const double* kernel, std::size_t size, double* result),
                (values, kernel, size, result))

}  // namespace

void natural_spline(Values heights, double spacing, std::span<double> slope, std::span<double> curvature) {
  const std::size_t size = heights.size();
  check(heights, spacing, size, slope, curvature);
  std::vector<double> load(size - 2);
  const auto inner = static_cast<Index>(size) - 2;
  right_sides(heights.data() + 1, inner, load_scale(spacing), load.data());
  curvature.front() = 0.0;
  curvature.back() = 0.0;
  gsl::solve_tridiagonal(4.0, 1.0, load, curvature.subspan(1, size - 2));
  slope.front() = first_slope(heights, curvature[1], spacing);
  slopes(heights.data() + 1, curvature.data() + 1, inner, spacing, slope.data() + 1);
  slope.back() = last_slope(heights, curvature[size - 2], spacing);
}

void natural_spline_from(Values heights, double spacing, Index first, std::span<double> slope,
                         std::span<double> curvature) {
  const auto size = static_cast<Index>(heights.size());
  const auto points = static_cast<Index>(slope.size());
  check(heights, spacing, slope.size(), slope, curvature);
  if (first < 0 || first > size - points) {
    throw std::invalid_argument("natural_spline_from: the points must lie within the profile");
  }
  const double* y = heights.data();
  const double scale = load_scale(spacing);
  const Index last = size - 1;
  // The load is mirrored at both ends with opposite sign, which makes the curvature 0 at both ends.
  const auto load_at = [&](Index j) {
    const Index i = (j % (2 * last) + 2 * last) % (2 * last);
    const Index image = i > last ? 2 * last - i : i;
    double load = 0.0;
    if (image > 0 && image < last) {
      right_sides(y + image, 1, scale, &load);
    }
    return i > last ? -load : load;
  };
  std::array<double, chunk + 2 + 2 * kernel_reach> load;
  std::array<double, chunk + 2> curvatures;  // starting one point before the chunk
  for (Index done = 0; done < points; done += chunk) {
    const Index count = std::min(chunk, points - done);
    const Index begin = first + done;
    const Index padded = (count + 2 + stride - 1) / stride * stride;
    const Index load_begin = begin - 1 - kernel_reach;
    const Index load_end = load_begin + padded + 2 * kernel_reach;
    const Index inner_begin = std::clamp<Index>(1, load_begin, load_end);
    const Index inner_end = std::clamp<Index>(last, inner_begin, load_end);
    const auto load_slot = [&](Index j) { return load.data() + (j - load_begin); };
    for (Index j = load_begin; j < inner_begin; ++j) {
      *load_slot(j) = load_at(j);
    }
    right_sides(y + inner_begin, inner_end - inner_begin, scale, load_slot(inner_begin));
    for (Index j = inner_end; j < load_end; ++j) {
      *load_slot(j) = load_at(j);
    }
    superpose(load.data() + kernel_reach, unit_load().data(), static_cast<std::size_t>(padded), curvatures.data());

    std::copy_n(curvatures.data() + 1, count, curvature.data() + done);
    const Index first_inner = begin == 0 ? 1 : 0;  // first point with neighbours on both sides
    const Index last_inner = begin + count == size ? count - 1 : count;
    slopes(y + begin + first_inner, curvatures.data() + 1 + first_inner, last_inner - first_inner, spacing,
           slope.data() + done + first_inner);
    if (begin == 0) {
      slope.front() = first_slope(heights, curvatures[2], spacing);
    }
    if (begin + count == size) {
      slope.back() = last_slope(heights, curvatures[static_cast<std::size_t>(count - 1)], spacing);
    }
  }
}

}  // namespace stiction
