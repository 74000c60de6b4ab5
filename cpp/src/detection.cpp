#include "stiction/detection.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace stiction {
namespace {

// What a pass over points has seen, for each of some lanes.
struct Seen {
  static constexpr std::size_t lanes = 16;

  double upper_zero[lanes] = {};  // 0, or NaN where a height is not finite
  double lower_zero[lanes] = {};
  double upper_largest[lanes] = {};
  double lower_largest[lanes] = {};
};

// The lowest gap of each block goes to block_gap.
STICTION_MULTIVERSION
Seen screen_blocks(const double* upper, const double* lower, std::size_t size, double* block_gap) {
  constexpr std::size_t lanes = Seen::lanes;
  constexpr std::size_t block = Screening::block;
  static_assert(block % lanes == 0 && (lanes & (lanes - 1)) == 0);
  Seen seen;
  double lowest[lanes];
  const auto take = [&](std::size_t i, std::size_t lane) {
    const double gap = upper[i] - lower[i];
    lowest[lane] = gap < lowest[lane] ? gap : lowest[lane];
    seen.upper_zero[lane] += upper[i] - upper[i];
    seen.lower_zero[lane] += lower[i] - lower[i];
    seen.upper_largest[lane] = std::max(seen.upper_largest[lane], std::abs(upper[i]));
    seen.lower_largest[lane] = std::max(seen.lower_largest[lane], std::abs(lower[i]));
  };
  std::size_t begin = 0;
  for (; begin < size; begin += block) {
    std::fill_n(lowest, lanes, std::numeric_limits<double>::infinity());
    const std::size_t end = std::min(begin + block, size);
    std::size_t i = begin;
    for (; i + lanes <= end; i += lanes) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        take(i + lane, lane);
      }
    }
    for (; i < end; ++i) {
      take(i, i % lanes);
    }
    for (std::size_t half = lanes / 2; half > 0; half /= 2) {
      for (std::size_t lane = 0; lane < half; ++lane) {
        lowest[lane] = lowest[lane + half] < lowest[lane] ? lowest[lane + half] : lowest[lane];
      }
    }
    *block_gap++ = lowest[0];
  }
  return seen;
}

STICTION_MULTIVERSION
double largest_second_difference(const double* upper, const double* lower, std::size_t size) {
  constexpr std::size_t lanes = 16;
  double largest[lanes] = {};
  const auto at = [&](std::size_t i) {
    return std::abs((upper[i - 1] - lower[i - 1]) - 2.0 * (upper[i] - lower[i]) + (upper[i + 1] - lower[i + 1]));
  };
  std::size_t i = 1;
  for (; i + lanes < size; i += lanes) {
    for (std::size_t lane = 0; lane < lanes; ++lane) {
      largest[lane] = std::max(largest[lane], at(i + lane));
    }
  }
  for (; i + 1 < size; ++i) {
    largest[0] = std::max(largest[0], at(i));
  }
  return *std::max_element(largest, largest + lanes);
}

}  // namespace

void Screening::add(Values upper, Values lower) {
  const std::size_t before = block_gap.size();
  block_gap.resize(before + (upper.size() + block - 1) / block);
  const Seen seen = screen_blocks(upper.data(), lower.data(), upper.size(), block_gap.data() + before);
  gap = std::accumulate(block_gap.begin() + static_cast<Index>(before), block_gap.end(), gap,
                        [](double lowest, double each) { return std::min(lowest, each); });
  const auto is_zero = [](double zero) { return zero == 0.0; };
  upper_finite = upper_finite && std::all_of(std::begin(seen.upper_zero), std::end(seen.upper_zero), is_zero);
  lower_finite = lower_finite && std::all_of(std::begin(seen.lower_zero), std::end(seen.lower_zero), is_zero);
  upper_largest =
      std::max(upper_largest, *std::max_element(std::begin(seen.upper_largest), std::end(seen.upper_largest)));
  lower_largest =
      std::max(lower_largest, *std::max_element(std::begin(seen.lower_largest), std::end(seen.lower_largest)));
}

Screening screen(Values upper, Values lower) {
  Screening result;
  result.block_gap.reserve(upper.size() / Screening::block + 1);
  result.add(upper, lower);
  return result;
}

std::vector<Stretch> stretches_within(Values upper, Values lower, const Screening& screening, double largest) {
  constexpr std::size_t step = 8;      // points that are taken together
  constexpr std::size_t closest = 32;  // no stretches are nearer to each other
  std::vector<Stretch> stretches;
  for (std::size_t b = 0; b < screening.block_gap.size(); ++b) {
    if (!(screening.block_gap[b] - screening.gap <= largest)) {
      continue;
    }
    const std::size_t block_end = std::min((b + 1) * Screening::block, upper.size());
    for (std::size_t begin = b * Screening::block; begin < block_end; begin += step) {
      const std::size_t end = std::min(begin + step, block_end);
      bool within = false;
      for (std::size_t i = begin; i < end; ++i) {
        within = within || (upper[i] - lower[i]) - screening.gap <= largest;
      }
      if (!within) {
        continue;
      }
      if (!stretches.empty() && begin - stretches.back().end <= closest) {
        stretches.back().end = end;
      } else {
        stretches.push_back({begin, end});
      }
    }
  }
  return stretches;
}

double largest_dip(Values upper, Values lower) {
  return 0.375 * largest_second_difference(upper.data(), lower.data(), upper.size());
}

bool is_straight(Values heights, double largest) {
  const double round_off = 4.0 * std::numeric_limits<double>::epsilon() * largest;
  for (std::size_t i = 1; i + 1 < heights.size(); ++i) {
    if (std::abs((heights[i + 1] - heights[i]) - (heights[i] - heights[i - 1])) > round_off) {
      return false;
    }
  }
  return true;
}

STICTION_MULTIVERSION
void mark_cells(Derivatives at, const double* upper, const double* lower, std::size_t size, double zero, double largest,
                double half_cell, unsigned char* marks) {
  constexpr double round_off = 1e-12;
  for (std::size_t i = 0; i < size; ++i) {
    const double upper_slope = at.upper_slope[i];
    const double lower_slope = at.lower_slope[i];
    const double gap = (upper[i] - lower[i]) - zero;
    // R = scale q and O = scale (slope, 1), with the sign of the side.
    const double upper_q2 = 1.0 + upper_slope * upper_slope;
    const double lower_q2 = 1.0 + lower_slope * lower_slope;
    const double upper_scale = upper_q2 / at.upper_curvature[i];
    const double lower_scale = -lower_q2 / at.lower_curvature[i];
    const double upper_radius = upper_scale * std::sqrt(upper_q2);
    const double lower_radius = lower_scale * std::sqrt(lower_q2);
    const double lower_x = lower_scale * lower_slope;
    const double apart_x = -upper_scale * upper_slope - lower_x;
    const double apart_y = gap + upper_scale + lower_scale - largest;
    const double least_y = apart_y > 0.0 ? apart_y : 0.0;
    const double farthest = upper_radius + lower_radius;
    const double nearest = std::sqrt(apart_x * apart_x + least_y * least_y);
    const double half_excess = 0.5 * (upper_radius - lower_radius);
    const double middle = lower_x + 0.5 * apart_x;
    const double limit = half_cell + round_off * (std::abs(lower_x) + std::abs(apart_x) + std::abs(half_excess));
    // The centre is at middle - half_excess apart_x / distance, from the farthest to the nearest; both sides are
    // multiplied by the distance. What is not a number is left to the exact rules.
    const double moved = half_excess * apart_x;
    const double above = middle - limit;
    const double below = middle + limit;
    const bool beside = ((above * farthest > moved) & (above * nearest > moved)) |
                        ((below * farthest < moved) & (below * nearest < moved));
    const bool apart = nearest > farthest * (1.0 + round_off);
    const bool convex = (at.upper_curvature[i] > 0.0) & (at.lower_curvature[i] < 0.0);
    marks[i] = convex & (gap <= largest) & !beside & !apart;
  }
}

// Its slope rises through zero between the ends, or comes down to zero and rises again, or rises through zero and comes
// down again.
STICTION_MULTIVERSION
void mark_minima(Derivatives at, std::size_t size, unsigned char* marks) {
  for (std::size_t i = 0; i < size; ++i) {
    const double slope = at.upper_slope[i] - at.lower_slope[i];
    const double curvature = at.upper_curvature[i] - at.lower_curvature[i];
    const double next_slope = at.upper_slope[i + 1] - at.lower_slope[i + 1];
    const double next_curvature = at.upper_curvature[i + 1] - at.lower_curvature[i + 1];
    const bool rises = (slope <= 0.0) & (next_slope > 0.0);
    const bool dips = (slope >= 0.0) & (curvature < 0.0) & (next_curvature > 0.0) & (next_slope > 0.0);
    const bool bulges = (slope <= 0.0) & (curvature > 0.0) & (next_curvature < 0.0) & (next_slope < 0.0);
    const bool starts = (slope == 0.0) & (curvature > 0.0);
    marks[i] = rises | dips | bulges | starts;
  }
}

}  // namespace stiction
