#include "stiction/detection.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stiction {
namespace {

struct PassSums {
  static constexpr std::size_t lanes = 16;

  double upper_nonfinite[lanes] = {};  // NaN if a height is not finite, 0 otherwise
  double lower_nonfinite[lanes] = {};
  double upper_max_abs[lanes] = {};
  double lower_max_abs[lanes] = {};
};

STICTION_MULTIVERSION
PassSums scan_blocks(const double* upper, const double* lower, std::size_t size, double* block_min_gap) {
  constexpr std::size_t lanes = PassSums::lanes;
  constexpr std::size_t block = Prefilter::block;
  static_assert(block % lanes == 0 && (lanes & (lanes - 1)) == 0);
  PassSums sums;
  double lowest[lanes];
  const auto add = [&](std::size_t i, std::size_t lane) {
    const double gap = upper[i] - lower[i];
    lowest[lane] = gap < lowest[lane] ? gap : lowest[lane];
    sums.upper_nonfinite[lane] += upper[i] - upper[i];
    sums.lower_nonfinite[lane] += lower[i] - lower[i];
    sums.upper_max_abs[lane] = std::max(sums.upper_max_abs[lane], std::abs(upper[i]));
    sums.lower_max_abs[lane] = std::max(sums.lower_max_abs[lane], std::abs(lower[i]));
  };
  std::size_t begin = 0;
  for (; begin < size; begin += block) {
    std::fill_n(lowest, lanes, std::numeric_limits<double>::infinity());
    const std::size_t end = std::min(begin + block, size);
    std::size_t i = begin;
    for (; i + lanes <= end; i += lanes) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        add(i + lane, lane);
      }
    }
    for (; i < end; ++i) {
      add(i, i % lanes);
    }
    for (std::size_t half = lanes / 2; half > 0; half /= 2) {
      for (std::size_t lane = 0; lane < half; ++lane) {
        lowest[lane] = lowest[lane + half] < lowest[lane] ? lowest[lane + half] : lowest[lane];
      }
    }
    *block_min_gap++ = lowest[0];
  }
  return sums;
}

STICTION_MULTIVERSION
double max_second_difference(const double* upper, const double* lower, std::size_t size) {
  constexpr std::size_t lanes = 16;
  double largest[lanes] = {};
  const auto second_difference = [&](std::size_t i) {
    return std::abs((upper[i - 1] - lower[i - 1]) - 2.0 * (upper[i] - lower[i]) + (upper[i + 1] - lower[i + 1]));
  };
  std::size_t i = 1;
  for (; i + lanes < size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      largest[lane] = std::max(largest[lane], second_difference(i + lane));
    }
  }
  for (; i + 1 < size; ++i) {
    largest[0] = std::max(largest[0], second_difference(i));
  }
  return *std::max_element(largest, largest + lanes);
}

}  // namespace

void Prefilter::add(Values upper, Values lower) {
  const std::size_t old_size = block_min_gap.size();
  block_min_gap.resize(old_size + (upper.size() + block - 1) / block);
  const PassSums sums = scan_blocks(upper.data(), lower.data(), upper.size(), block_min_gap.data() + old_size);
  min_gap = std::accumulate(block_min_gap.begin() + static_cast<Index>(old_size), block_min_gap.end(), min_gap,
                            [](double a, double b) { return std::min(a, b); });
  const auto is_zero = [](double zero) { return zero == 0.0; };
  upper_finite = upper_finite && std::all_of(std::begin(sums.upper_nonfinite), std::end(sums.upper_nonfinite), is_zero);
  lower_finite = lower_finite && std::all_of(std::begin(sums.lower_nonfinite), std::end(sums.lower_nonfinite), is_zero);
  upper_max_abs =
      std::max(upper_max_abs, *std::max_element(std::begin(sums.upper_max_abs), std::end(sums.upper_max_abs)));
  lower_max_abs =
      std::max(lower_max_abs, *std::max_element(std::begin(sums.lower_max_abs), std::end(sums.lower_max_abs)));
}

Prefilter run_prefilter(Values upper, Values lower) {
  Prefilter result;
  result.block_min_gap.reserve(upper.size() / Prefilter::block + 1);
  result.add(upper, lower);
  return result;
}

std::vector<IndexRange> ranges_within(Values upper, Values lower, const Prefilter& prefilter, double max_gap) {
  constexpr std::size_t granularity = 8;
  constexpr std::size_t merge_distance = 32;
  std::vector<IndexRange> ranges;
  for (std::size_t b = 0; b < prefilter.block_min_gap.size(); ++b) {
    if (!(prefilter.block_min_gap[b] - prefilter.min_gap <= max_gap)) {
      continue;
    }
    const std::size_t block_end = std::min((b + 1) * Prefilter::block, upper.size());
    for (std::size_t begin = b * Prefilter::block; begin < block_end; begin += granularity) {
      const std::size_t end = std::min(begin + granularity, block_end);
      bool within = false;
      for (std::size_t i = begin; i < end; ++i) {
        within = within || (upper[i] - lower[i]) - prefilter.min_gap <= max_gap;
      }
      if (!within) {
        continue;
      }
      if (!ranges.empty() && begin - ranges.back().end <= merge_distance) {
        ranges.back().end = end;
      } else {
        ranges.push_back({begin, end});
      }
    }
  }
  return ranges;
}

double max_dip(Values upper, Values lower) {
  return 0.375 * max_second_difference(upper.data(), lower.data(), upper.size());
}

bool is_straight(Values heights, double max_abs) {
  const double round_off = 4.0 * std::numeric_limits<double>::epsilon() * max_abs;
  for (std::size_t i = 1; i + 1 < heights.size(); ++i) {
    if (std::abs((heights[i + 1] - heights[i]) - (heights[i] - heights[i - 1])) > round_off) {
      return false;
    }
  }
  return true;
}

STICTION_MULTIVERSION
void mark_cells(Derivatives derivatives, const double* upper, const double* lower, std::size_t size, double zero,
                double max_approach, double half_cell, unsigned char* marks) {
  constexpr double round_off = 1e-12;
  for (std::size_t i = 0; i < size; ++i) {
    const double upper_slope = derivatives.upper_slope[i];
    const double lower_slope = derivatives.lower_slope[i];
    const double gap = (upper[i] - lower[i]) - zero;
    // With q² = 1 + f'², the osculating sphere has its centre at the offset (-f', 1) q²/f'' from the profile.
    // The osculating sphere has the radius q·scale. On the upper profile, scale is q²/f''; on the lower, -q²/f''.
    const double upper_q2 = 1.0 + upper_slope * upper_slope;
    const double lower_q2 = 1.0 + lower_slope * lower_slope;
    const double upper_scale = upper_q2 / derivatives.upper_curvature[i];
    const double lower_scale = -lower_q2 / derivatives.lower_curvature[i];
    const double upper_radius = upper_scale * std::sqrt(upper_q2);
    const double lower_radius = lower_scale * std::sqrt(lower_q2);
    const double lower_x = lower_scale * lower_slope;
    const double separation_x = -upper_scale * upper_slope - lower_x;
    const double separation_y = gap + upper_scale + lower_scale - max_approach;
    const double min_y = separation_y > 0.0 ? separation_y : 0.0;
    const double max_distance = upper_radius + lower_radius;
    const double min_distance = std::sqrt(separation_x * separation_x + min_y * min_y);
    const double half_excess = 0.5 * (upper_radius - lower_radius);
    const double middle = lower_x + 0.5 * separation_x;
    const double limit = half_cell + round_off * (std::abs(lower_x) + std::abs(separation_x) + std::abs(half_excess));
    // The contact centre is at middle - half_excess · separation_x / distance, and is compared with the cell edges.
    // Both sides of the comparison are multiplied by the distance of the sphere centres, which avoids a division.
    // If a derivative is NaN, the point is marked, so that the exact rules decide whether it can be in contact.
    const double shift = half_excess * separation_x;
    const double left_edge = middle - limit;
    const double right_edge = middle + limit;
    const bool outside_cell = ((left_edge * max_distance > shift) & (left_edge * min_distance > shift)) |
                              ((right_edge * max_distance < shift) & (right_edge * min_distance < shift));
    const bool separated = min_distance > max_distance * (1.0 + round_off);
    const bool convex = (derivatives.upper_curvature[i] > 0.0) & (derivatives.lower_curvature[i] < 0.0);
    marks[i] = convex & (gap <= max_approach) & !outside_cell & !separated;
  }
}

// Mark an interval if the slope of the gap rises through zero or from zero, or may be zero at two points in it.
STICTION_MULTIVERSION
void mark_minima(Derivatives derivatives, std::size_t size, unsigned char* marks) {
  for (std::size_t i = 0; i < size; ++i) {
    const double slope = derivatives.upper_slope[i] - derivatives.lower_slope[i];
    const double curvature = derivatives.upper_curvature[i] - derivatives.lower_curvature[i];
    const double next_slope = derivatives.upper_slope[i + 1] - derivatives.lower_slope[i + 1];
    const double next_curvature = derivatives.upper_curvature[i + 1] - derivatives.lower_curvature[i + 1];
    const bool rises = (slope <= 0.0) & (next_slope > 0.0);
    const bool dips = (slope >= 0.0) & (curvature < 0.0) & (next_curvature > 0.0) & (next_slope > 0.0);
    const bool bulges = (slope <= 0.0) & (curvature > 0.0) & (next_curvature < 0.0) & (next_slope < 0.0);
    const bool starts = (slope == 0.0) & (curvature > 0.0);
    marks[i] = rises | dips | bulges | starts;
  }
}

}  // namespace stiction
