#include "stiction/bicubic.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

namespace stiction {
namespace {

// Spline coefficients c for heights z: c_(i-1) + 4 c_i + c_(i+1) = 6 z_i at inner points, and c = z at both ends.

// A row of heights is multiplied by the inverse spline matrix, because Gaussian elimination would be sequential.
// The inverse spline matrix is -6 a / ((1 - a s) (1 - a / s)), where s is a shift by one point, and a = sqrt(3) - 2.
// The factor 1 / (1 - a s) is the product of 1 + a s, 1 + a² s², 1 + a⁴ s⁴ and so on. Each needs one pass over the row.
// A row of heights is continued beyond both its ends by point reflection.
constexpr std::array<Index, 5> shifts{1, 2, 4, 8, 16};
// Neglecting heights more than 32 points away changes a coefficient by 0.268^32 = 5e-19 of a height.
constexpr Index reach = 32;

struct PassFactors {
  double neighbour;
  double overall;
};

// Each pass over a row multiplies by (1 + b² + b (s + 1/s)) / (1 + b²), with the shift s and b = a, a², a⁴ and so on.
constexpr std::array<PassFactors, shifts.size()> row_passes() {
  std::array<PassFactors, shifts.size()> result{};
  double b = -0.26794919243112270647;  // sqrt(3) - 2
  double factor = -6.0 * b;
  for (PassFactors& pass : result) {
    pass = {b / (1.0 + b * b), 1.0};
    factor *= 1.0 + b * b;
    b *= b;
  }
  result.back().overall = factor;
  return result;
}

// `row` includes one coefficient beyond each end. `work` contains 2 · length values (see `work_length`).
template <std::size_t Width>
STICTION_INLINE void solve_row_kernel(double* row, Index points, Index length, double* work) {
  constexpr std::array<PassFactors, shifts.size()> passes = row_passes();
  constexpr auto width = static_cast<Index>(Width);
  double* from = work;
  double* to = work + length;
  double* at = from + reach;
  std::copy(row, row + points, at);
  for (Index k = 1; k <= reach; ++k) {
    at[-k] = 2.0 * at[0] - at[k];
    at[points - 1 + k] = 2.0 * at[points - 1] - at[points - 1 - k];
  }
  Index first = 0;
  for (std::size_t pass = 0; pass < passes.size(); ++pass) {
    const Index shift = shifts[pass];
    const auto [neighbour, overall] = passes[pass];
    first += shift;
    for (Index i = first; i < points + 2 * reach - first; i += width) {
      const Pack<Width> neighbours = load<Width>(from + i - shift) + load<Width>(from + i + shift);
      store<Width>(overall * (load<Width>(from + i) + neighbour * neighbours), to + i);
    }
    std::swap(from, to);
  }
  std::copy(from + reach - 1, from + reach + points + 1, row - 1);
}

STICTION_KERNEL(solve_row, (double* row, Index points, Index length, double* work), (row, points, length, work))

Index work_length(Index points) { return points + 2 * reach + static_cast<Index>(widest_pack); }

std::vector<double> pivots(Index points) {
  std::vector<double> result(static_cast<std::size_t>(points), 0.0);
  for (std::size_t i = 1; i < result.size(); ++i) {
    result[i] = 1.0 / (4.0 - result[i - 1]);
  }
  return result;
}

// At one point, the unknowns of all lines are contiguous in memory. Successive points are `stride` elements apart.
STICTION_MULTIVERSION
void solve_columns(double* values, Index points, Index lines, Index stride, const double* pivot) {
  for (Index i = 1; i + 1 < points; ++i) {
    const double* before = values + (i - 1) * stride;
    double* at = values + i * stride;
    const double p = pivot[i];
    for (Index line = 0; line < lines; ++line) {
      at[line] = (6.0 * at[line] - before[line]) * p;
    }
  }
  for (Index i = points - 2; i > 0; --i) {
    const double* after = values + (i + 1) * stride;
    double* at = values + i * stride;
    const double p = pivot[i];
    for (Index line = 0; line < lines; ++line) {
      at[line] -= p * after[line];
    }
  }
  double* beyond = values - stride;
  for (Index line = 0; line < lines; ++line) {
    beyond[line] = 2.0 * values[line] - values[stride + line];
  }
  const double* last = values + (points - 1) * stride;
  beyond = values + points * stride;
  for (Index line = 0; line < lines; ++line) {
    beyond[line] = 2.0 * last[line] - last[line - stride];
  }
}

STICTION_MULTIVERSION
void scaled_differences(const double* before, const double* after, Index size, double factor, double* result) {
  for (Index i = 0; i < size; ++i) {
    result[i] = factor * (after[i] - before[i]);
  }
}

// Number of columns that are solved together, small enough for the cache.
constexpr Index columns_per_strip = 64;

struct Basis {
  std::array<double, 4> value;
  std::array<double, 4> first;
  std::array<double, 4> second;
};

STICTION_INLINE Basis basis(double t) {
  const double s = 1.0 - t;
  return {{s * s * s / 6.0, 2.0 / 3.0 - t * t * (1.0 - 0.5 * t), 2.0 / 3.0 - s * s * (1.0 - 0.5 * s), t * t * t / 6.0},
          {-0.5 * s * s, t * (1.5 * t - 2.0), -s * (1.5 * s - 2.0), 0.5 * t * t},
          {s, 3.0 * t - 2.0, 3.0 * s - 2.0, t}};
}

}  // namespace

void natural_bicubic(Eigen::Ref<Matrix> coefficients) {
  const Index rows = coefficients.rows() - 2;
  const Index columns = coefficients.cols() - 2;
  if (rows < min_map_points || columns < min_map_points) {
    throw std::invalid_argument("natural_bicubic: the map must have at least 4 rows and 4 columns, got " +
                                std::to_string(rows) + " by " + std::to_string(columns));
  }
  const Index stride = coefficients.outerStride();
  double* heights = coefficients.data() + stride + 1;

  const Index length = work_length(columns);
  std::vector<double> work(static_cast<std::size_t>(2 * length));
  for (Index row = 0; row < rows; ++row) {
    solve_row(heights + row * stride, columns, length, work.data());
  }

  const std::vector<double> pivot = pivots(rows);
  for (Index first = -1; first < columns + 1; first += columns_per_strip) {
    solve_columns(heights + first, rows, std::min(columns_per_strip, columns + 1 - first), stride, pivot.data());
  }
}

void natural_slopes(const MatrixView& heights, const Vector2& spacing, Eigen::Ref<Matrix> along_x,
                    Eigen::Ref<Matrix> along_y) {
  const Index rows = heights.rows();
  const Index columns = heights.cols();
  if (columns < 2 || rows < 1) {
    throw std::invalid_argument("natural_slopes: the map must have at least two points per row, got " +
                                std::to_string(rows) + " by " + std::to_string(columns));
  }
  const Index length = work_length(columns);
  std::vector<double> work(static_cast<std::size_t>(2 * length));
  std::vector<double> line(static_cast<std::size_t>(columns + 2));
  for (Index row = 0; row < rows; ++row) {
    const double* from = heights.data() + row * heights.outerStride();
    std::copy(from, from + columns, line.begin() + 1);
    solve_row(line.data() + 1, columns, length, work.data());
    scaled_differences(line.data(), line.data() + 2, columns, 0.5 / spacing.x(),
                       along_x.data() + row * along_x.outerStride());
  }
  if (rows < 2) {
    return;
  }
  const std::vector<double> pivot = pivots(rows);
  std::vector<double> strip(static_cast<std::size_t>((rows + 2) * columns_per_strip));
  for (Index first = 0; first < columns; first += columns_per_strip) {
    const Index lines = std::min(columns_per_strip, columns - first);
    for (Index row = 0; row < rows; ++row) {
      const double* from = heights.data() + row * heights.outerStride() + first;
      std::copy(from, from + lines, strip.begin() + (row + 1) * columns_per_strip);
    }
    solve_columns(strip.data() + columns_per_strip, rows, lines, columns_per_strip, pivot.data());
    for (Index row = 0; row < rows; ++row) {
      const double* before = strip.data() + row * columns_per_strip;
      scaled_differences(before, before + 2 * columns_per_strip, lines, 0.5 / spacing.y(),
                         along_y.data() + row * along_y.outerStride() + first);
    }
  }
}

Jet bicubic_at(const MatrixView& coefficients, Index row, Index column, double u, double v) {
  const Basis along_x = basis(u);
  const Basis along_y = basis(v);
  Jet jet{};
  for (Index j = 0; j < 4; ++j) {
    const double* c = coefficients.data() + (row + j) * coefficients.outerStride() + column;
    double value = 0.0;
    double first = 0.0;
    double second = 0.0;
    for (std::size_t i = 0; i < 4; ++i) {
      value += along_x.value[i] * c[i];
      first += along_x.first[i] * c[i];
      second += along_x.second[i] * c[i];
    }
    const auto k = static_cast<std::size_t>(j);
    jet.value += along_y.value[k] * value;
    jet.x += along_y.value[k] * first;
    jet.y += along_y.first[k] * value;
    jet.xx += along_y.value[k] * second;
    jet.xy += along_y.first[k] * first;
    jet.yy += along_y.second[k] * value;
  }
  return jet;
}

}  // namespace stiction
