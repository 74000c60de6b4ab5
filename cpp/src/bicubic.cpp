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

// ---- The tridiagonal system of one direction ------------------------------------------------------------------------
//
// c_(i-1) + 4 c_i + c_(i+1) = 6 z_i at inner points. A second derivative of zero makes c = z at both ends, so there it
// is known, and 2 c - c of the inner neighbour beyond. Many lines are solved side by side.

// Of the elimination: 1/4, 1/(4 - 1/4) and so on, which tends to 2 - sqrt(3).
std::vector<double> pivots(Index points) {
  std::vector<double> result(static_cast<std::size_t>(points), 0.0);
  for (std::size_t i = 1; i < result.size(); ++i) {
    result[i] = 1.0 / (4.0 - result[i - 1]);
  }
  return result;
}

// `lines` lines of `points` values: those of one point are next to each other, those of the next `stride` further on.
STICTION_MULTIVERSION
void solve(double* values, Index points, Index lines, Index stride, const double* pivot) {
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
  double* rim = values - stride;
  for (Index line = 0; line < lines; ++line) {
    rim[line] = 2.0 * values[line] - values[stride + line];
  }
  const double* last = values + (points - 1) * stride;
  rim = values + points * stride;
  for (Index line = 0; line < lines; ++line) {
    rim[line] = 2.0 * last[line] - last[line - stride];
  }
}

// ---- One cell -------------------------------------------------------------------------------------------------------

struct Basis {
  std::array<double, 4> value;
  std::array<double, 4> first;
  std::array<double, 4> second;
};

// The four cubic B-splines of a cell.
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
  if (rows < fewest_points || columns < fewest_points) {
    throw std::invalid_argument("natural_bicubic: the map has " + std::to_string(rows) + " rows and " +
                                std::to_string(columns) + " columns, at least 4 of each are needed");
  }
  const Index stride = coefficients.outerStride();
  double* heights = coefficients.data() + stride + 1;

  // Along rows: some at a time, turned so that those of one column are next to each other.
  constexpr Index together = 16;
  std::vector<double> turned(static_cast<std::size_t>((columns + 2) * together));
  std::vector<double> pivot = pivots(columns);
  for (Index first = 0; first < rows; first += together) {
    const Index lines = std::min(together, rows - first);
    for (Index line = 0; line < lines; ++line) {
      const double* row = heights + (first + line) * stride;
      for (Index i = 0; i < columns; ++i) {
        turned[static_cast<std::size_t>((i + 1) * together + line)] = row[i];
      }
    }
    solve(turned.data() + together, columns, together, together, pivot.data());
    for (Index line = 0; line < lines; ++line) {
      double* row = heights + (first + line) * stride - 1;
      for (Index i = 0; i < columns + 2; ++i) {
        row[i] = turned[static_cast<std::size_t>(i * together + line)];
      }
    }
  }

  // Along columns: as many at a time as stay in the processor's cache on the way up and down.
  constexpr Index wide = 64;
  pivot = pivots(rows);
  for (Index first = -1; first < columns + 1; first += wide) {
    solve(heights + first, rows, std::min(wide, columns + 1 - first), stride, pivot.data());
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
