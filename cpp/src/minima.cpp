#include "stiction/minima.hpp"

#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace stiction {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// In cells. A minimum this far beyond its cell is still found there, so that none is lost between two cells to
// round-off; two this near to each other are one.
constexpr double beyond = 1e-8;
constexpr double same = 1e-6;

// ---- Which cells to look into: wide and cheap -----------------------------------------------------------------------

// The spline in a cell lies within the range of its 16 coefficients, and a derivative of it within the range of their
// differences: there can be a minimum where the lowest is low enough and both ranges hold zero.

STICTION_INLINE double least(double a, double b) { return a < b ? a : b; }
STICTION_INLINE double most(double a, double b) { return a > b ? a : b; }

// Ranges of one column of four coefficients, or of the differences of two such columns.
struct Ranges {
  explicit Ranges(Index columns) : work(static_cast<std::size_t>(5 * columns)), size(columns) {}
  double* lowest() { return work.data(); }
  double* x_low() { return work.data() + size; }
  double* x_high() { return work.data() + 2 * size; }
  double* y_low() { return work.data() + 3 * size; }
  double* y_high() { return work.data() + 4 * size; }

  std::vector<double> work;
  Index size;
};

STICTION_MULTIVERSION
void screen_columns(const double* c0, Index stride, Index count, double* lowest, double* x_low, double* x_high,
                    double* y_low, double* y_high) {
  const double* c1 = c0 + stride;
  const double* c2 = c1 + stride;
  const double* c3 = c2 + stride;
  for (Index i = 0; i < count; ++i) {
    lowest[i] = least(least(c0[i], c1[i]), least(c2[i], c3[i]));
    const double a = c1[i] - c0[i];
    const double b = c2[i] - c1[i];
    const double c = c3[i] - c2[i];
    y_low[i] = least(least(a, b), c);
    y_high[i] = most(most(a, b), c);
  }
  for (Index i = 0; i + 1 < count; ++i) {
    const double a = c0[i + 1] - c0[i];
    const double b = c1[i + 1] - c1[i];
    const double c = c2[i + 1] - c2[i];
    const double d = c3[i + 1] - c3[i];
    x_low[i] = least(least(a, b), least(c, d));
    x_high[i] = most(most(a, b), most(c, d));
  }
}

STICTION_MULTIVERSION
void screen_cells(const double* lowest, const double* x_low, const double* x_high, const double* y_low,
                  const double* y_high, Index cells, double highest, unsigned char* marks) {
  for (Index i = 0; i < cells; ++i) {
    const double low = least(least(lowest[i], lowest[i + 1]), least(lowest[i + 2], lowest[i + 3]));
    const double xl = least(least(x_low[i], x_low[i + 1]), x_low[i + 2]);
    const double xh = most(most(x_high[i], x_high[i + 1]), x_high[i + 2]);
    const double yl = least(least(y_low[i], y_low[i + 1]), least(y_low[i + 2], y_low[i + 3]));
    const double yh = most(most(y_high[i], y_high[i + 1]), most(y_high[i + 2], y_high[i + 3]));
    marks[i] = (low <= highest) & (xl <= 0.0) & (xh >= 0.0) & (yl <= 0.0) & (yh >= 0.0);
  }
}

// ---- One cell -------------------------------------------------------------------------------------------------------

// Bernstein coefficients of a bicubic on a square, x along the inner index.
using Net = std::array<std::array<double, 4>, 4>;

Net bernstein(const MatrixView& coefficients, Index row, Index column) {
  const auto convert = [](double a, double b, double c, double d) {
    return std::array<double, 4>{(a + 4.0 * b + c) / 6.0, (2.0 * b + c) / 3.0, (b + 2.0 * c) / 3.0,
                                 (b + 4.0 * c + d) / 6.0};
  };
  Net rows;
  for (Index j = 0; j < 4; ++j) {
    const double* c = coefficients.data() + (row + j) * coefficients.outerStride() + column;
    rows[static_cast<std::size_t>(j)] = convert(c[0], c[1], c[2], c[3]);
  }
  Net net;
  for (std::size_t i = 0; i < 4; ++i) {
    const auto turned = convert(rows[0][i], rows[1][i], rows[2][i], rows[3][i]);
    for (std::size_t j = 0; j < 4; ++j) {
      net[j][i] = turned[j];
    }
  }
  return net;
}

// The coefficients of both halves of a cubic.
STICTION_INLINE void halve(std::array<double, 4>& first, std::array<double, 4>& second) {
  const auto [a, b, c, d] = first;
  const double ab = 0.5 * (a + b);
  const double bc = 0.5 * (b + c);
  const double cd = 0.5 * (c + d);
  const double abc = 0.5 * (ab + bc);
  const double bcd = 0.5 * (bc + cd);
  const double middle = 0.5 * (abc + bcd);
  first = {a, ab, abc, middle};
  second = {middle, bcd, cd, d};
}

void halve_along_x(Net& first, Net& second) {
  for (std::size_t j = 0; j < 4; ++j) {
    halve(first[j], second[j]);
  }
}

void halve_along_y(Net& first, Net& second) {
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<double, 4> one{first[0][i], first[1][i], first[2][i], first[3][i]};
    std::array<double, 4> other;
    halve(one, other);
    for (std::size_t j = 0; j < 4; ++j) {
      first[j][i] = one[j];
      second[j][i] = other[j];
    }
  }
}

struct Range {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void take(double value) {
    low = least(low, value);
    high = most(high, value);
  }
};

// What the signs of a part of a cell say about minima in it.
enum class Finding { none, convex, open };

Finding examine(const Net& net, double highest, double round_off) {
  Range x;
  for (const auto& row : net) {
    for (std::size_t i = 0; i < 3; ++i) {
      x.take(row[i + 1] - row[i]);
    }
  }
  if (x.low > round_off || x.high < -round_off) {
    return Finding::none;
  }
  Range y;
  for (std::size_t j = 0; j < 3; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      y.take(net[j + 1][i] - net[j][i]);
    }
  }
  if (y.low > round_off || y.high < -round_off) {
    return Finding::none;
  }
  Range value;
  for (const auto& row : net) {
    for (const double one : row) {
      value.take(one);
    }
  }
  if (value.low > highest) {
    return Finding::none;
  }
  // Second derivatives: 6, 9 and 6 times these.
  Range xx;
  Range xy;
  Range yy;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      if (i < 2) {
        xx.take(net[j][i + 2] - 2.0 * net[j][i + 1] + net[j][i]);
      }
      if (j < 2) {
        yy.take(net[j + 2][i] - 2.0 * net[j + 1][i] + net[j][i]);
      }
      if (i < 3 && j < 3) {
        xy.take((net[j + 1][i + 1] - net[j + 1][i]) - (net[j][i + 1] - net[j][i]));
      }
    }
  }
  if (xx.high <= 2.0 * round_off || yy.high <= 2.0 * round_off) {
    return Finding::none;
  }
  const double least_xy = xy.low > 0.0 ? xy.low : (xy.high < 0.0 ? -xy.high : 0.0);
  if (36.0 * xx.high * yy.high < 81.0 * least_xy * least_xy) {
    return Finding::none;  // a saddle everywhere
  }
  const double most_xy = most(std::abs(xy.low), std::abs(xy.high));
  const bool convex = xx.low > 0.0 && yy.low > 0.0 && 36.0 * xx.low * yy.low > 81.0 * most_xy * most_xy;
  return convex ? Finding::convex : Finding::open;
}

class Cell {
 public:
  Cell(const MatrixView& coefficients, Index row, Index column, double highest)
      : coefficients_(coefficients), row_(row), column_(column), highest_(highest) {}

  // Calls found(Minimum), whose u and v may be somewhat beyond the cell.
  template <class Found>
  void search(const Found& found) const {
    const Net net = bernstein(coefficients_, row_, column_);
    double largest = 0.0;
    for (const auto& row : net) {
      for (const double value : row) {
        largest = most(largest, std::abs(value));
      }
    }
    part(net, 0.0, 0.0, 1.0, 4.0 * epsilon * largest, found);
  }

 private:
  template <class Found>
  void part(const Net& net, double u, double v, double size, double round_off, const Found& found) const {
    constexpr double smallest = 1.0 / 64.0;
    const Finding finding = examine(net, highest_, round_off);
    if (finding == Finding::none) {
      return;
    }
    const bool last = size <= smallest;
    if (finding == Finding::convex || last) {
      const double around = last ? size : beyond;
      const auto minimum = newton(u + 0.5 * size, v + 0.5 * size, size);
      if (minimum && minimum->u >= u - around && minimum->u <= u + size + around && minimum->v >= v - around &&
          minimum->v <= v + size + around) {
        if (minimum->at.value <= highest_ && inside(minimum->u) && inside(minimum->v)) {
          found(*minimum);
        }
        return;
      }
      if (last) {
        return;
      }
    }
    const double half = 0.5 * size;
    Net lower_left = net;
    Net upper_left;
    halve_along_y(lower_left, upper_left);
    Net lower_right;
    Net upper_right;
    halve_along_x(lower_left, lower_right);
    halve_along_x(upper_left, upper_right);
    part(lower_left, u, v, half, round_off, found);
    part(lower_right, u + half, v, half, round_off, found);
    part(upper_left, u, v + half, half, round_off, found);
    part(upper_right, u + half, v + half, half, round_off, found);
  }

  static bool inside(double t) { return t >= -beyond && t <= 1.0 + beyond; }

  std::optional<Minimum> newton(double u, double v, double size) const {
    for (int i = 0; i < 30; ++i) {
      const Jet at = bicubic_at(coefficients_, row_, column_, u, v);
      const double determinant = at.xx * at.yy - at.xy * at.xy;
      if (!(at.xx > 0.0 && at.yy > 0.0 && determinant > 0.0)) {
        return std::nullopt;
      }
      double du = (at.xy * at.y - at.yy * at.x) / determinant;
      double dv = (at.xy * at.x - at.xx * at.y) / determinant;
      const double length = most(std::abs(du), std::abs(dv));
      if (length <= 1e-12) {
        return Minimum{row_, column_, u + du, v + dv, bicubic_at(coefficients_, row_, column_, u + du, v + dv)};
      }
      if (length > 2.0 * size) {
        du *= 2.0 * size / length;
        dv *= 2.0 * size / length;
      }
      u += du;
      v += dv;
      if (!(std::abs(u - 0.5) < 2.0 && std::abs(v - 0.5) < 2.0)) {
        return std::nullopt;
      }
    }
    return std::nullopt;
  }

  const MatrixView& coefficients_;
  Index row_;
  Index column_;
  double highest_;
};

// ---- Each once, and not on the edge ---------------------------------------------------------------------------------

// A minimum within round-off of a side of its cell belongs to the cell on whose left, or lower, side it then is.
void settle(double& fraction, Index& cell, Index cells) {
  if (fraction >= 1.0 - same && cell + 1 < cells) {
    cell += 1;
    fraction -= 1.0;
  }
  fraction = std::abs(fraction) < same ? most(fraction, 0.0) : fraction;
}

bool before(const Minimum& a, const Minimum& b) { return a.row != b.row ? a.row < b.row : a.column < b.column; }

}  // namespace

bool is_same(const Minimum& one, const Minimum& other) {
  return std::abs(one.u - other.u) < 2.0 * same && std::abs(one.v - other.v) < 2.0 * same;
}

std::vector<Minimum> minima(const MatrixView& coefficients, const Cells& where, double highest,
                            const Checkpoint& checkpoint) {
  const Index rows = coefficients.rows() - 3;  // of all cells
  const Index columns = coefficients.cols() - 3;
  const Index stride = coefficients.outerStride();
  std::vector<Minimum> found;
  std::vector<unsigned char> marks(static_cast<std::size_t>(where.columns));
  Ranges ranges(where.columns + 3);
  for (Index row = where.row; row < where.row + where.rows; ++row) {
    checkpoint();
    screen_columns(coefficients.data() + row * stride + where.column, stride, where.columns + 3, ranges.lowest(),
                   ranges.x_low(), ranges.x_high(), ranges.y_low(), ranges.y_high());
    screen_cells(ranges.lowest(), ranges.x_low(), ranges.x_high(), ranges.y_low(), ranges.y_high(), where.columns,
                 highest, marks.data());
    for (Index i = 0; i < where.columns; ++i) {
      if (marks[static_cast<std::size_t>(i)] != 0) {
        Cell(coefficients, row, where.column + i, highest).search([&](Minimum minimum) {
          const double x = static_cast<double>(minimum.column) + minimum.u;
          const double y = static_cast<double>(minimum.row) + minimum.v;
          const bool on_edge =
              x < same || y < same || x > static_cast<double>(columns) - same || y > static_cast<double>(rows) - same;
          if (!on_edge) {
            settle(minimum.u, minimum.column, columns);
            settle(minimum.v, minimum.row, rows);
            found.push_back(minimum);
          }
        });
      }
    }
  }
  std::stable_sort(found.begin(), found.end(), before);
  // The same minimum seen from two cells or two parts of one is now in one cell.
  std::vector<Minimum> result;
  result.reserve(found.size());
  for (const Minimum& minimum : found) {
    bool known = false;
    for (auto other = result.rbegin(); other != result.rend() && !before(*other, minimum) && !known; ++other) {
      known = is_same(*other, minimum);
    }
    if (!known) {
      result.push_back(minimum);
    }
  }
  return result;
}

}  // namespace stiction
