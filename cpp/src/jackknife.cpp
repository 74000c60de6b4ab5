#include "stiction/jackknife.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace stiction {
namespace {

// Number of repetitions per chunk, so small that the intermediate values of a chunk fit into the first-level cache.
constexpr std::size_t repetitions_per_chunk = 256;
// Number of partial sums, a multiple of all SIMD widths, so that each width adds numbers in the same order.
constexpr std::size_t sum_lanes = 32;
using RepetitionChunk = std::array<double, repetitions_per_chunk>;
using LaneValues = std::array<double, sum_lanes>;

// ln(1 + x) = 2 (t + t³/3 + t⁵/5 + ...) with t = x / (2 + x). For |x| ≤ 1/8, the omitted terms are below 3e-18 t.
constexpr double max_series_argument = 0.125;
constexpr std::array series_coefficients{1.0 / 13.0, 1.0 / 11.0, 1.0 / 9.0, 1.0 / 7.0, 1.0 / 5.0, 1.0 / 3.0, 1.0};
STICTION_INLINE double log1p_series(double x) {
  const double t = x / (2.0 + x);
  double sum = 0.0;
  for (const double coefficient : series_coefficients) {
    sum = sum * (t * t) + coefficient;
  }
  return 2.0 * t * sum;
}

STICTION_INLINE bool is_small(double x) { return std::abs(x) <= max_series_argument; }  // false for NaN

STICTION_INLINE void compute_log1p(const RepetitionChunk& arguments, std::size_t size, RepetitionChunk& logarithms) {
  for (std::size_t i = 0; i < size; ++i) {
    logarithms[i] = log1p_series(arguments[i]);
  }
  if (std::all_of(arguments.begin(), arguments.begin() + static_cast<std::ptrdiff_t>(size), is_small)) {
    return;
  }
  for (std::size_t i = 0; i < size; ++i) {
    if (!is_small(arguments[i])) {
      logarithms[i] = std::log1p(arguments[i]);
    }
  }
}

template <class Add>
STICTION_INLINE void for_each_lane(const RepetitionChunk& values, std::size_t size, Add add) {
  std::size_t i = 0;
  for (; i + sum_lanes <= size; i += sum_lanes) {
    for (std::size_t lane = 0; lane < sum_lanes; ++lane) {
      add(values[i + lane], lane);
    }
  }
  for (; i < size; ++i) {
    add(values[i], i % sum_lanes);
  }
}

STICTION_INLINE double sum_of(const LaneValues& values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += value;
  }
  return sum;
}

STICTION_INLINE void add_powers(const RepetitionChunk& values, std::size_t size, double* sums) {
  LaneValues first{};
  LaneValues second{};
  LaneValues third{};
  LaneValues fourth{};
  for_each_lane(values, size, [&](double value, std::size_t lane) {
    const double square = value * value;
    first[lane] += value;
    second[lane] += square;
    third[lane] += square * value;
    fourth[lane] += square * square;
  });
  sums[0] += sum_of(first);
  sums[1] += sum_of(second);
  sums[2] += sum_of(third);
  sums[3] += sum_of(fourth);
}

STICTION_INLINE double find_min(const RepetitionChunk& values, std::size_t size, double min) {
  LaneValues lane_min;
  lane_min.fill(min);
  for_each_lane(values, size,
                [&](double value, std::size_t lane) { lane_min[lane] = std::min(lane_min[lane], value); });
  return *std::min_element(lane_min.begin(), lane_min.end());
}

struct StepRows {
  const double* before;
  const double* after;

  StepRows(const CurveView& curves, Index curve, Index step)
      : before(curves.values + curve * curves.curve_stride + std::max<Index>(step - 1, 0) * curves.step_stride),
        after(curves.values + curve * curves.curve_stride + step * curves.step_stride) {}
};

struct PointOnCurve {
  double fraction;
  double load;
  double mean;
  double slope;
};

STICTION_MULTIVERSION
void add_point(const PointOnCurve& point, StepRows loads, StepRows values, std::size_t repetitions, double num_others,
               double* sums) {
  RepetitionChunk difference;
  RepetitionChunk relative_change;
  RepetitionChunk relative_load_change;
  RepetitionChunk logarithm;
  RepetitionChunk load_logarithm;
  const double weight = 1.0 / num_others;
  const double inverse_mean = 1.0 / point.mean;
  const double inverse_load = 1.0 / point.load;
  const double exponent = point.slope * point.load / point.mean;
  for (std::size_t start = 0; start < repetitions; start += repetitions_per_chunk) {
    const std::size_t size = std::min(repetitions_per_chunk, repetitions - start);
    for (std::size_t i = 0; i < size; ++i) {
      const double load_before = loads.before[start + i];
      const double load = load_before + point.fraction * (loads.after[start + i] - load_before);
      const double value_before = values.before[start + i];
      const double value = value_before + point.fraction * (values.after[start + i] - value_before);
      const double load_change = (point.load - load) * weight;
      const double value_change = (point.mean - value) * weight;
      difference[i] = value_change - point.slope * load_change;
      relative_change[i] = value_change * inverse_mean;
      relative_load_change[i] = load_change * inverse_load;
    }
    compute_log1p(relative_change, size, logarithm);
    compute_log1p(relative_load_change, size, load_logarithm);
    for (std::size_t i = 0; i < size; ++i) {
      logarithm[i] -= exponent * load_logarithm[i];
    }
    add_powers(logarithm, size, sums);
    add_powers(difference, size, sums + 4);
    sums[8] = find_min(relative_change, size, sums[8]);
    sums[9] = find_min(relative_load_change, size, sums[9]);
  }
}

}  // namespace

void jackknife_sums(const CurvePoints& points, const CurveView& loads, const CurveView& values, Index repetitions,
                    Index total_repetitions, Eigen::Ref<Matrix> sums) {
  for (std::size_t i = 0; i < points.curve.size(); ++i) {
    std::array<double, jackknife_sum_rows> point_sums{};
    point_sums[8] = point_sums[9] = std::numeric_limits<double>::infinity();
    const Index curve = points.curve[i];
    const Index step = points.step[i];
    add_point({points.fraction[i], points.load[i], points.mean[i], points.slope[i]}, {loads, curve, step},
              {values, curve, step}, static_cast<std::size_t>(repetitions), static_cast<double>(total_repetitions - 1),
              point_sums.data());
    for (Index row = 0; row < jackknife_sum_rows; ++row) {
      sums(row, static_cast<Index>(i)) = point_sums[static_cast<std::size_t>(row)];
    }
  }
}

}  // namespace stiction
