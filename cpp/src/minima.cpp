#include "stiction/minima.hpp"

#include "marks.hpp"
#include "multiversion.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

namespace stiction {
namespace {

constexpr double epsilon = std::numeric_limits<double>::epsilon();

// A minimum may lie `max_overshoot` of a cell side outside its cell, so that no minimum between two cells is lost.
// Two minima in a cell count as one if their positions differ by less than 2 `merge_distance` along x and along y.
constexpr double max_overshoot = 1e-8;
constexpr double merge_distance = 1e-6;

// In a cell, 16 coefficients bound the spline, and differences of neighbouring coefficients bound its derivatives.
// A cell can contain a minimum only if a coefficient is at most `max_value`, and both derivatives may be zero.

STICTION_INLINE double smaller(double a, double b) { return a < b ? a : b; }
STICTION_INLINE double larger(double a, double b) { return a > b ? a : b; }

// A block of 29 cells depends on 32 columns of coefficients, a multiple of every SIMD width.
constexpr Index cells_per_block = 29;

STICTION_MULTIVERSION
void mark_low(const double* coefficients, Index cells, double max_value, unsigned char* marks) {
  for (Index first = 0; first < cells; first += cells_per_block) {
    unsigned char any = 0;
    if (first + cells_per_block <= cells) {
      for (Index i = first; i < first + cells_per_block + 3; ++i) {
        any |= static_cast<unsigned char>(coefficients[i] <= max_value);
      }
    } else {
      for (Index i = first; i < cells + 3; ++i) {
        any |= static_cast<unsigned char>(coefficients[i] <= max_value);
      }
    }
    *marks++ = any;
  }
}

// For each column: smallest of four successive spline coefficients, and ranges of their differences along x and y.
struct Ranges {
  explicit Ranges(Index columns) : buffer(static_cast<std::size_t>(5 * columns)), size(columns) {}
  double* lowest() { return buffer.data(); }
  double* x_low() { return buffer.data() + size; }
  double* x_high() { return buffer.data() + 2 * size; }
  double* y_low() { return buffer.data() + 3 * size; }
  double* y_high() { return buffer.data() + 4 * size; }

  std::vector<double> buffer;
  Index size;
};

STICTION_MULTIVERSION
void column_ranges(const double* c0, Index stride, Index count, double* lowest, double* x_low, double* x_high,
                   double* y_low, double* y_high) {
  const double* c1 = c0 + stride;
  const double* c2 = c1 + stride;
  const double* c3 = c2 + stride;
  for (Index i = 0; i < count; ++i) {
    lowest[i] = smaller(smaller(c0[i], c1[i]), smaller(c2[i], c3[i]));
    const double a = c1[i] - c0[i];
    const double b = c2[i] - c1[i];
    const double c = c3[i] - c2[i];
    y_low[i] = smaller(smaller(a, b), c);
    y_high[i] = larger(larger(a, b), c);
  }
  for (Index i = 0; i + 1 < count; ++i) {
    const double a = c0[i + 1] - c0[i];
    const double b = c1[i + 1] - c1[i];
    const double c = c2[i + 1] - c2[i];
    const double d = c3[i + 1] - c3[i];
    x_low[i] = smaller(smaller(a, b), smaller(c, d));
    x_high[i] = larger(larger(a, b), larger(c, d));
  }
}

STICTION_MULTIVERSION
void mark_possible_cells(const double* lowest, const double* x_low, const double* x_high, const double* y_low,
                         const double* y_high, Index cells, double max_value, unsigned char* marks) {
  for (Index i = 0; i < cells; ++i) {
    const double low = smaller(smaller(lowest[i], lowest[i + 1]), smaller(lowest[i + 2], lowest[i + 3]));
    const double xl = smaller(smaller(x_low[i], x_low[i + 1]), x_low[i + 2]);
    const double xh = larger(larger(x_high[i], x_high[i + 1]), x_high[i + 2]);
    const double yl = smaller(smaller(y_low[i], y_low[i + 1]), smaller(y_low[i + 2], y_low[i + 3]));
    const double yh = larger(larger(y_high[i], y_high[i + 1]), larger(y_high[i + 2], y_high[i + 3]));
    marks[i] = (low <= max_value) & (xl <= 0.0) & (xh >= 0.0) & (yl <= 0.0) & (yh >= 0.0);
  }
}

// Bernstein coefficients of a bicubic polynomial on a cell or on part of a cell. The second index belongs to x.
using Net = std::array<std::array<double, 4>, 4>;

template <std::size_t lanes>
using Nets = std::array<std::array<std::array<double, lanes>, 4>, 4>;

constexpr std::size_t cells_per_batch = 8;

// Class of a cell or a part: it has no minimum, is convex with at most one minimum, or is undecided.
enum class CellClass : unsigned char { excluded, convex, undecided };

template <std::size_t Width>
using PackNet = Pack<Width>[4][4];

template <class P>
STICTION_INLINE void extend_range(P& low, P& high, const P& value) {
  low = value < low ? value : low;
  high = value > high ? value : high;
}

template <std::size_t Width>
STICTION_INLINE void classify(const PackNet<Width>& net, double max_value, const Pack<Width>& slack,
                              CellClass* classes) {
  using P = Pack<Width>;
  const P zero{};
  P low = net[0][0];
  P x_low = net[0][1] - net[0][0];
  P x_high = x_low;
  P y_low = net[1][0] - net[0][0];
  P y_high = y_low;
  // The second derivatives xx, xy and yy are 6, 9 and 6 times the second differences of the Bernstein coefficients.
  P xx_low = net[0][2] - 2.0 * net[0][1] + net[0][0];
  P xx_high = xx_low;
  P xy_low = (net[1][1] - net[1][0]) - (net[0][1] - net[0][0]);
  P xy_high = xy_low;
  P yy_low = net[2][0] - 2.0 * net[1][0] + net[0][0];
  P yy_high = yy_low;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      low = net[j][i] < low ? net[j][i] : low;
      if (i < 3) {
        extend_range<P>(x_low, x_high, net[j][i + 1] - net[j][i]);
      }
      if (j < 3) {
        extend_range<P>(y_low, y_high, net[j + 1][i] - net[j][i]);
      }
      if (i < 2) {
        extend_range<P>(xx_low, xx_high, net[j][i + 2] - 2.0 * net[j][i + 1] + net[j][i]);
      }
      if (j < 2) {
        extend_range<P>(yy_low, yy_high, net[j + 2][i] - 2.0 * net[j + 1][i] + net[j][i]);
      }
      if (i < 3 && j < 3) {
        extend_range<P>(xy_low, xy_high, (net[j + 1][i + 1] - net[j + 1][i]) - (net[j][i + 1] - net[j][i]));
      }
    }
  }
  const P min_abs_xy = xy_low > zero ? xy_low : (xy_high < zero ? -xy_high : zero);
  const P max_abs_xy = xy_high > -xy_low ? xy_high : -xy_low;
  const auto zero_slope = (x_low <= slack) & (x_high >= -slack) & (y_low <= slack) & (y_high >= -slack);
  const auto curved_up = (xx_high > 2.0 * slack) & (yy_high > 2.0 * slack);
  // If the Hessian matrix is indefinite at every point of a cell, the cell contains no minimum.
  const auto no_saddle = 36.0 * xx_high * yy_high >= 81.0 * min_abs_xy * min_abs_xy;
  const auto possible = zero_slope & curved_up & no_saddle & (low <= zero + max_value);
  const auto convex = (xx_low > zero) & (yy_low > zero) & (36.0 * xx_low * yy_low > 81.0 * max_abs_xy * max_abs_xy);
  for (std::size_t k = 0; k < Width; ++k) {
    classes[k] = possible[k] == 0 ? CellClass::excluded : (convex[k] == 0 ? CellClass::undecided : CellClass::convex);
  }
}

template <class P>
STICTION_INLINE void to_bernstein(P& c0, P& c1, P& c2, P& c3) {
  // Multiplying by reciprocals avoids divisions, which would take most of the run time.
  constexpr double third = 1.0 / 3.0;
  constexpr double sixth = 1.0 / 6.0;
  const P a = sixth * (c0 + 4.0 * c1 + c2);
  const P b = third * (2.0 * c1 + c2);
  const P c = third * (c1 + 2.0 * c2);
  const P d = sixth * (c1 + 4.0 * c2 + c3);
  c0 = a;
  c1 = b;
  c2 = c;
  c3 = d;
}

// Convert B-spline coefficients to Bernstein coefficients in place. Also returns the round-off of the spline.
template <std::size_t Width>
STICTION_INLINE void classify_cells_kernel(double* coefficients, double max_value, double* round_off,
                                           CellClass* classes) {
  for (std::size_t k = 0; k < cells_per_batch; k += Width) {
    PackNet<Width> net;
    Pack<Width> largest{};
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i) {
        net[j][i] = load<Width>(coefficients + (4 * j + i) * cells_per_batch + k);
      }
      to_bernstein(net[j][0], net[j][1], net[j][2], net[j][3]);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      to_bernstein(net[0][i], net[1][i], net[2][i], net[3][i]);
      for (std::size_t j = 0; j < 4; ++j) {
        const Pack<Width> size = net[j][i] > -net[j][i] ? net[j][i] : -net[j][i];
        largest = size > largest ? size : largest;
        store<Width>(net[j][i], coefficients + (4 * j + i) * cells_per_batch + k);
      }
    }
    const Pack<Width> slack = 4.0 * epsilon * largest;
    store<Width>(slack, round_off + k);
    classify<Width>(net, max_value, slack, classes + k);
  }
}

STICTION_KERNEL(classify_cells, (double* coefficients, double max_value, double* round_off, CellClass* classes),
                (coefficients, max_value, round_off, classes))

// Divide a cubic Bernstein polynomial into its two halves by de Casteljau's algorithm.
STICTION_INLINE void halve(double a, double b, double c, double d, std::array<double, 4>& first,
                           std::array<double, 4>& second) {
  const double ab = 0.5 * (a + b);
  const double bc = 0.5 * (b + c);
  const double cd = 0.5 * (c + d);
  const double abc = 0.5 * (ab + bc);
  const double bcd = 0.5 * (bc + cd);
  const double middle = 0.5 * (abc + bcd);
  first = {a, ab, abc, middle};
  second = {middle, bcd, cd, d};
}

// The quarters of a cell are in the order lower left, lower right, upper left, upper right.
STICTION_INLINE void quarter(const Net& net, Nets<4>& quarters) {
  std::array<Net, 2> halves;
  for (std::size_t i = 0; i < 4; ++i) {
    std::array<double, 4> lower;
    std::array<double, 4> upper;
    halve(net[0][i], net[1][i], net[2][i], net[3][i], lower, upper);
    for (std::size_t j = 0; j < 4; ++j) {
      halves[0][j][i] = lower[j];
      halves[1][j][i] = upper[j];
    }
  }
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t j = 0; j < 4; ++j) {
      std::array<double, 4> left;
      std::array<double, 4> right;
      const auto& row = halves[half][j];
      halve(row[0], row[1], row[2], row[3], left, right);
      for (std::size_t i = 0; i < 4; ++i) {
        quarters[j][i][2 * half] = left[i];
        quarters[j][i][2 * half + 1] = right[i];
      }
    }
  }
}

template <std::size_t Width>
STICTION_INLINE void classify_quarters_kernel(const Net& whole, double max_value, double round_off, Nets<4>& quarters,
                                              CellClass* classes) {
  constexpr std::size_t width = Width < 4 ? Width : 4;
  quarter(whole, quarters);
  for (std::size_t k = 0; k < 4; k += width) {
    PackNet<width> net;
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i) {
        net[j][i] = load<width>(&quarters[j][i][k]);
      }
    }
    classify<width>(net, max_value, Pack<width>{} + round_off, classes + k);
  }
}

STICTION_KERNEL(classify_quarters,
                (const Net& whole, double max_value, double round_off, Nets<4>& quarters, CellClass* classes),
                (whole, max_value, round_off, quarters, classes))

template <std::size_t lanes>
Net extract(const Nets<lanes>& nets, std::size_t lane) {
  Net net;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      net[j][i] = nets[j][i][lane];
    }
  }
  return net;
}

class Cell {
 public:
  Cell(const MatrixView& coefficients, Index row, Index column, double max_value)
      : coefficients_(coefficients), row_(row), column_(column), max_value_(max_value) {}

  // Call `visit(minimum)` with the position of each minimum. The position may be slightly outside the cell.
  template <class Visit>
  void search(const Net& net, double round_off, CellClass cell_class, const Visit& visit) const {
    search_part(net, 0.0, 0.0, 1.0, round_off, cell_class, visit);
  }

 private:
  template <class Visit>
  void search_part(const Net& net, double u, double v, double size, double round_off, CellClass cell_class,
                   const Visit& visit) const {
    constexpr double smallest = 1.0 / 64.0;
    const bool is_smallest = size <= smallest;
    if (cell_class == CellClass::convex || is_smallest) {
      const double margin = is_smallest ? size : max_overshoot;
      const auto minimum = newton(u + 0.5 * size, v + 0.5 * size, size, round_off);
      if (minimum && minimum->u >= u - margin && minimum->u <= u + size + margin && minimum->v >= v - margin &&
          minimum->v <= v + size + margin) {
        if (inside(minimum->u) && inside(minimum->v)) {
          visit(*minimum);
        }
        return;
      }
      if (is_smallest) {
        return;
      }
    }
    Nets<4> quarters;
    std::array<CellClass, 4> classes;
    classify_quarters(net, max_value_, round_off, quarters, classes.data());
    const double half = 0.5 * size;
    for (std::size_t k = 0; k < 4; ++k) {
      if (classes[k] != CellClass::excluded) {
        search_part(extract(quarters, k), k % 2 == 0 ? u : u + half, k < 2 ? v : v + half, half, round_off, classes[k],
                    visit);
      }
    }
  }

  static bool inside(double t) { return t >= -max_overshoot && t <= 1.0 + max_overshoot; }

  std::optional<Minimum> newton(double u, double v, double size, double round_off) const {
    for (int i = 0; i < 30; ++i) {
      const Jet at = bicubic_at(coefficients_, row_, column_, u, v);
      const double determinant = at.xx * at.yy - at.xy * at.xy;
      if (!(at.xx > 0.0 && at.yy > 0.0 && determinant > 0.0)) {
        return std::nullopt;
      }
      double du = (at.xy * at.y - at.yy * at.x) / determinant;
      double dv = (at.xy * at.x - at.xx * at.y) / determinant;
      const double length = larger(std::abs(du), std::abs(dv));
      // If the spline is nearly level, round-off prevents the steps of Newton's method from becoming shorter.
      if (length <= 1e-12 || larger(std::abs(at.x), std::abs(at.y)) <= round_off) {
        return Minimum{row_, column_, u + du, v + dv, {}};
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
  double max_value_;
};

// A minimum on the right or upper side of a cell belongs to the neighbouring cell.
void move_to_owner(double& fraction, Index& cell, Index cells) {
  if (fraction >= 1.0 - merge_distance && cell + 1 < cells) {
    cell += 1;
    fraction -= 1.0;
  }
}

bool precedes(const Minimum& a, const Minimum& b) { return a.row != b.row ? a.row < b.row : a.column < b.column; }

}  // namespace

Jet at_minimum(const MatrixView& coefficients, const Minimum& minimum) {
  const Index left = minimum.u < 0.0 && minimum.column > 0 ? 1 : 0;
  const Index below = minimum.v < 0.0 && minimum.row > 0 ? 1 : 0;
  return bicubic_at(coefficients, minimum.row - below, minimum.column - left, minimum.u + static_cast<double>(left),
                    minimum.v + static_cast<double>(below));
}

bool is_same(const Minimum& first, const Minimum& second) {
  return std::abs(first.u - second.u) < 2.0 * merge_distance && std::abs(first.v - second.v) < 2.0 * merge_distance;
}

std::vector<Minimum> minima(const MatrixView& coefficients, const CellRange& range, double max_value,
                            const CancellationCheck& check_cancellation) {
  const Index rows = coefficients.rows() - 3;
  const Index columns = coefficients.cols() - 3;
  const Index stride = coefficients.outerStride();
  std::vector<Minimum> all_minima;
  const Index blocks = (range.columns + cells_per_block - 1) / cells_per_block;
  std::vector<unsigned char> low(static_cast<std::size_t>((range.rows + 3) * blocks));
  for (Index row = 0; row < range.rows + 3; ++row) {
    mark_low(coefficients.data() + (range.row + row) * stride + range.column, range.columns, max_value,
             &low[static_cast<std::size_t>(row * blocks)]);
  }
  const auto is_low = [&](Index row, Index block) {
    const unsigned char* first = &low[static_cast<std::size_t>((row - range.row) * blocks + block)];
    return (first[0] | first[blocks] | first[2 * blocks] | first[3 * blocks]) != 0;
  };
  std::vector<unsigned char> marks(static_cast<std::size_t>(range.columns));
  Ranges ranges(range.columns + 3);
  std::vector<Index> remaining_columns;
  Nets<cells_per_batch> nets{};
  std::array<double, cells_per_batch> round_off;
  std::array<CellClass, cells_per_batch> classes;
  const auto add_minimum = [&](Minimum minimum) {
    const double x = static_cast<double>(minimum.column) + minimum.u;
    const double y = static_cast<double>(minimum.row) + minimum.v;
    const bool on_edge = x < merge_distance || y < merge_distance ||
                         x > static_cast<double>(columns) - merge_distance ||
                         y > static_cast<double>(rows) - merge_distance;
    if (!on_edge) {
      move_to_owner(minimum.u, minimum.column, columns);
      move_to_owner(minimum.v, minimum.row, rows);
      minimum.at = at_minimum(coefficients, minimum);
      if (minimum.at.value <= max_value) {
        all_minima.push_back(minimum);
      }
    }
  };
  for (Index row = range.row; row < range.row + range.rows; ++row) {
    check_cancellation();
    remaining_columns.clear();
    for (Index block = 0; block < blocks; ++block) {
      if (!is_low(row, block)) {
        continue;
      }
      const Index first = range.column + block * cells_per_block;
      while (block + 1 < blocks && is_low(row, block + 1)) {
        ++block;
      }
      const Index cells = std::min(range.columns, (block + 1) * cells_per_block) - (first - range.column);
      column_ranges(coefficients.data() + row * stride + first, stride, cells + 3, ranges.lowest(), ranges.x_low(),
                    ranges.x_high(), ranges.y_low(), ranges.y_high());
      mark_possible_cells(ranges.lowest(), ranges.x_low(), ranges.x_high(), ranges.y_low(), ranges.y_high(), cells,
                          max_value, marks.data());
      for_each_marked(marks.data(), 0, cells, [&](Index i) { remaining_columns.push_back(first + i); });
    }
    for (std::size_t begin = 0; begin < remaining_columns.size(); begin += cells_per_batch) {
      const std::size_t count = std::min(cells_per_batch, remaining_columns.size() - begin);
      for (std::size_t k = 0; k < count; ++k) {
        const double* c = coefficients.data() + row * stride + remaining_columns[begin + k];
        for (std::size_t j = 0; j < 4; ++j, c += stride) {
          for (std::size_t i = 0; i < 4; ++i) {
            nets[j][i][k] = c[i];
          }
        }
      }
      classify_cells(nets[0][0].data(), max_value, round_off.data(), classes.data());
      for (std::size_t k = 0; k < count; ++k) {
        if (classes[k] != CellClass::excluded) {
          Cell(coefficients, row, remaining_columns[begin + k], max_value)
              .search(extract(nets, k), round_off[k], classes[k], add_minimum);
        }
      }
    }
  }
  std::stable_sort(all_minima.begin(), all_minima.end(), precedes);
  // Remove copies of minima that were found twice: in two cells, or in two parts of a cell.
  // Both copies of a minimum are in the same cell, because `move_to_owner` has moved them.
  std::vector<Minimum> result;
  result.reserve(all_minima.size());
  for (const Minimum& minimum : all_minima) {
    bool is_duplicate = false;
    for (auto second = result.rbegin(); second != result.rend() && !precedes(*second, minimum) && !is_duplicate;
         ++second) {
      is_duplicate = is_same(*second, minimum);
    }
    if (!is_duplicate) {
      result.push_back(minimum);
    }
  }
  return result;
}

}  // namespace stiction
