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

// In cells. A minimum this far beyond its cell is still found there, so that none is lost between two cells to
// round-off; two this near to each other are one.
constexpr double beyond = 1e-8;
constexpr double same = 1e-6;

// ---- Which cells to look into: wide and cheap -----------------------------------------------------------------------

// The spline in a cell lies within the range of its 16 coefficients, and a derivative of it within the range of their
// differences: there can be a minimum where the lowest is low enough and both ranges hold zero.

STICTION_INLINE double least(double a, double b) { return a < b ? a : b; }
STICTION_INLINE double most(double a, double b) { return a > b ? a : b; }

// Cells of a row that are left out together where no coefficient is low enough; they have three columns more.
constexpr Index cells_at_once = 29;

// Whether a block in a row of coefficients is low enough.
STICTION_MULTIVERSION
void mark_low(const double* coefficients, Index cells, double highest, unsigned char* marks) {
  for (Index first = 0; first < cells; first += cells_at_once) {
    unsigned char any = 0;
    if (first + cells_at_once <= cells) {
      for (Index i = first; i < first + cells_at_once + 3; ++i) {
        any |= static_cast<unsigned char>(coefficients[i] <= highest);
      }
    } else {
      for (Index i = first; i < cells + 3; ++i) {
        any |= static_cast<unsigned char>(coefficients[i] <= highest);
      }
    }
    *marks++ = any;
  }
}

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

// ---- Parts of cells, several at a time ------------------------------------------------------------------------------

// Bernstein coefficients of a bicubic on a square, x along the inner index.
using Net = std::array<std::array<double, 4>, 4>;

// The same of several squares, for each coefficient one after the other.
template <std::size_t lanes>
using Nets = std::array<std::array<std::array<double, lanes>, 4>, 4>;

constexpr std::size_t together = 8;  // cells

// What the signs of a part of a cell say about minima in it.
enum class Finding : unsigned char { none, convex, open };

// Packs of numbers, a square in each.
template <std::size_t Width>
using PackNet = Pack<Width>[4][4];

template <class P>
STICTION_INLINE void narrow(P& low, P& high, const P& value) {
  low = value < low ? value : low;
  high = value > high ? value : high;
}

template <std::size_t Width>
STICTION_INLINE void examine(const PackNet<Width>& net, double highest, const Pack<Width>& slack, Finding* findings) {
  using P = Pack<Width>;
  const P none{};
  P low = net[0][0];
  P x_low = net[0][1] - net[0][0];
  P x_high = x_low;
  P y_low = net[1][0] - net[0][0];
  P y_high = y_low;
  // Second derivatives: 6, 9 and 6 times these.
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
        narrow<P>(x_low, x_high, net[j][i + 1] - net[j][i]);
      }
      if (j < 3) {
        narrow<P>(y_low, y_high, net[j + 1][i] - net[j][i]);
      }
      if (i < 2) {
        narrow<P>(xx_low, xx_high, net[j][i + 2] - 2.0 * net[j][i + 1] + net[j][i]);
      }
      if (j < 2) {
        narrow<P>(yy_low, yy_high, net[j + 2][i] - 2.0 * net[j + 1][i] + net[j][i]);
      }
      if (i < 3 && j < 3) {
        narrow<P>(xy_low, xy_high, (net[j + 1][i + 1] - net[j + 1][i]) - (net[j][i + 1] - net[j][i]));
      }
    }
  }
  const P least_xy = xy_low > none ? xy_low : (xy_high < none ? -xy_high : none);
  const P most_xy = xy_high > -xy_low ? xy_high : -xy_low;
  const auto level = (x_low <= slack) & (x_high >= -slack) & (y_low <= slack) & (y_high >= -slack);
  const auto hollow = (xx_high > 2.0 * slack) & (yy_high > 2.0 * slack);
  const auto no_saddle = 36.0 * xx_high * yy_high >= 81.0 * least_xy * least_xy;  // not everywhere
  const auto possible = level & hollow & no_saddle & (low <= none + highest);
  const auto convex = (xx_low > none) & (yy_low > none) & (36.0 * xx_low * yy_low > 81.0 * most_xy * most_xy);
  for (std::size_t k = 0; k < Width; ++k) {
    findings[k] = possible[k] == 0 ? Finding::none : (convex[k] == 0 ? Finding::open : Finding::convex);
  }
}

template <class P>
STICTION_INLINE void to_bernstein(P& c0, P& c1, P& c2, P& c3) {
  // Not by divisions, which would take longer than all else.
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

// Of B-spline coefficients, in place, those of Bernstein; the round-off of a cell's values.
template <std::size_t Width>
STICTION_INLINE void examine_cells_kernel(double* coefficients, double highest, double* round_off, Finding* findings) {
  for (std::size_t k = 0; k < together; k += Width) {
    PackNet<Width> net;
    Pack<Width> largest{};
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i) {
        net[j][i] = load<Width>(coefficients + (4 * j + i) * together + k);
      }
      to_bernstein(net[j][0], net[j][1], net[j][2], net[j][3]);
    }
    for (std::size_t i = 0; i < 4; ++i) {
      to_bernstein(net[0][i], net[1][i], net[2][i], net[3][i]);
      for (std::size_t j = 0; j < 4; ++j) {
        const Pack<Width> size = net[j][i] > -net[j][i] ? net[j][i] : -net[j][i];
        largest = size > largest ? size : largest;
        store<Width>(net[j][i], coefficients + (4 * j + i) * together + k);
      }
    }
    const Pack<Width> slack = 4.0 * epsilon * largest;
    store<Width>(slack, round_off + k);
    examine<Width>(net, highest, slack, findings + k);
  }
}

STICTION_KERNEL(examine_cells, (double* coefficients, double highest, double* round_off, Finding* findings),
                (coefficients, highest, round_off, findings))

// The coefficients of both halves of a cubic.
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

// The quarters of a part: left and right of the lower half, and of the upper one.
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
STICTION_INLINE void examine_quarters_kernel(const Net& whole, double highest, double round_off, Nets<4>& quarters,
                                             Finding* findings) {
  constexpr std::size_t width = Width < 4 ? Width : 4;
  quarter(whole, quarters);
  for (std::size_t k = 0; k < 4; k += width) {
    PackNet<width> net;
    for (std::size_t j = 0; j < 4; ++j) {
      for (std::size_t i = 0; i < 4; ++i) {
        net[j][i] = load<width>(&quarters[j][i][k]);
      }
    }
    examine<width>(net, highest, Pack<width>{} + round_off, findings + k);
  }
}

STICTION_KERNEL(examine_quarters,
                (const Net& whole, double highest, double round_off, Nets<4>& quarters, Finding* findings),
                (whole, highest, round_off, quarters, findings))

template <std::size_t lanes>
Net one_of(const Nets<lanes>& nets, std::size_t lane) {
  Net net;
  for (std::size_t j = 0; j < 4; ++j) {
    for (std::size_t i = 0; i < 4; ++i) {
      net[j][i] = nets[j][i][lane];
    }
  }
  return net;
}

// ---- One cell -------------------------------------------------------------------------------------------------------

class Cell {
 public:
  Cell(const MatrixView& coefficients, Index row, Index column, double highest)
      : coefficients_(coefficients), row_(row), column_(column), highest_(highest) {}

  // Calls found(Minimum), without what is there, whose u and v may be somewhat beyond the cell.
  template <class Found>
  void search(const Net& net, double round_off, Finding finding, const Found& found) const {
    part(net, 0.0, 0.0, 1.0, round_off, finding, found);
  }

 private:
  template <class Found>
  void part(const Net& net, double u, double v, double size, double round_off, Finding finding,
            const Found& found) const {
    constexpr double smallest = 1.0 / 64.0;
    const bool last = size <= smallest;
    if (finding == Finding::convex || last) {
      const double around = last ? size : beyond;
      const auto minimum = newton(u + 0.5 * size, v + 0.5 * size, size, round_off);
      if (minimum && minimum->u >= u - around && minimum->u <= u + size + around && minimum->v >= v - around &&
          minimum->v <= v + size + around) {
        if (inside(minimum->u) && inside(minimum->v)) {
          found(*minimum);
        }
        return;
      }
      if (last) {
        return;
      }
    }
    Nets<4> quarters;
    std::array<Finding, 4> findings;
    examine_quarters(net, highest_, round_off, quarters, findings.data());
    const double half = 0.5 * size;
    for (std::size_t k = 0; k < 4; ++k) {
      if (findings[k] != Finding::none) {
        part(one_of(quarters, k), k % 2 == 0 ? u : u + half, k < 2 ? v : v + half, half, round_off, findings[k], found);
      }
    }
  }

  static bool inside(double t) { return t >= -beyond && t <= 1.0 + beyond; }

  std::optional<Minimum> newton(double u, double v, double size, double round_off) const {
    for (int i = 0; i < 30; ++i) {
      const Jet at = bicubic_at(coefficients_, row_, column_, u, v);
      const double determinant = at.xx * at.yy - at.xy * at.xy;
      if (!(at.xx > 0.0 && at.yy > 0.0 && determinant > 0.0)) {
        return std::nullopt;
      }
      double du = (at.xy * at.y - at.yy * at.x) / determinant;
      double dv = (at.xy * at.x - at.xx * at.y) / determinant;
      const double length = most(std::abs(du), std::abs(dv));
      // Where the floor is nearly level, steps never become shorter than round-off makes them.
      if (length <= 1e-12 || most(std::abs(at.x), std::abs(at.y)) <= round_off) {
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
  double highest_;
};

// ---- Each once, and not on the edge ---------------------------------------------------------------------------------

// A minimum next to a side of its cell belongs to the cell on whose left, or lower, side it then is.
void settle(double& fraction, Index& cell, Index cells) {
  if (fraction >= 1.0 - same && cell + 1 < cells) {
    cell += 1;
    fraction -= 1.0;
  }
}

bool before(const Minimum& a, const Minimum& b) { return a.row != b.row ? a.row < b.row : a.column < b.column; }

}  // namespace

Jet at_minimum(const MatrixView& coefficients, const Minimum& minimum) {
  const Index left = minimum.u < 0.0 && minimum.column > 0 ? 1 : 0;
  const Index below = minimum.v < 0.0 && minimum.row > 0 ? 1 : 0;
  return bicubic_at(coefficients, minimum.row - below, minimum.column - left, minimum.u + static_cast<double>(left),
                    minimum.v + static_cast<double>(below));
}

bool is_same(const Minimum& one, const Minimum& other) {
  return std::abs(one.u - other.u) < 2.0 * same && std::abs(one.v - other.v) < 2.0 * same;
}

std::vector<Minimum> minima(const MatrixView& coefficients, const Cells& where, double highest,
                            const Checkpoint& checkpoint) {
  const Index rows = coefficients.rows() - 3;  // of all cells
  const Index columns = coefficients.cols() - 3;
  const Index stride = coefficients.outerStride();
  std::vector<Minimum> found;
  const Index blocks = (where.columns + cells_at_once - 1) / cells_at_once;
  std::vector<unsigned char> low(static_cast<std::size_t>((where.rows + 3) * blocks));
  for (Index row = 0; row < where.rows + 3; ++row) {
    mark_low(coefficients.data() + (where.row + row) * stride + where.column, where.columns, highest,
             &low[static_cast<std::size_t>(row * blocks)]);
  }
  const auto is_low = [&](Index row, Index at) {
    const unsigned char* first = &low[static_cast<std::size_t>((row - where.row) * blocks + at)];
    return (first[0] | first[blocks] | first[2 * blocks] | first[3 * blocks]) != 0;
  };
  std::vector<unsigned char> marks(static_cast<std::size_t>(where.columns));
  Ranges ranges(where.columns + 3);
  std::vector<Index> columns_left;  // of the cells in a row
  Nets<together> nets{};
  std::array<double, together> round_off;
  std::array<Finding, together> findings;
  const auto keep = [&](Minimum minimum) {
    const double x = static_cast<double>(minimum.column) + minimum.u;
    const double y = static_cast<double>(minimum.row) + minimum.v;
    const bool on_edge =
        x < same || y < same || x > static_cast<double>(columns) - same || y > static_cast<double>(rows) - same;
    if (!on_edge) {
      settle(minimum.u, minimum.column, columns);
      settle(minimum.v, minimum.row, rows);
      minimum.at = at_minimum(coefficients, minimum);
      if (minimum.at.value <= highest) {
        found.push_back(minimum);
      }
    }
  };
  for (Index row = where.row; row < where.row + where.rows; ++row) {
    checkpoint();
    columns_left.clear();
    for (Index at = 0; at < blocks; ++at) {
      if (!is_low(row, at)) {
        continue;
      }
      const Index first = where.column + at * cells_at_once;
      while (at + 1 < blocks && is_low(row, at + 1)) {
        ++at;
      }
      const Index cells = std::min(where.columns, (at + 1) * cells_at_once) - (first - where.column);
      screen_columns(coefficients.data() + row * stride + first, stride, cells + 3, ranges.lowest(), ranges.x_low(),
                     ranges.x_high(), ranges.y_low(), ranges.y_high());
      screen_cells(ranges.lowest(), ranges.x_low(), ranges.x_high(), ranges.y_low(), ranges.y_high(), cells, highest,
                   marks.data());
      for_each_marked(marks.data(), 0, cells, [&](Index i) { columns_left.push_back(first + i); });
    }
    for (std::size_t begin = 0; begin < columns_left.size(); begin += together) {
      const std::size_t count = std::min(together, columns_left.size() - begin);
      for (std::size_t k = 0; k < count; ++k) {
        const double* c = coefficients.data() + row * stride + columns_left[begin + k];
        for (std::size_t j = 0; j < 4; ++j, c += stride) {
          for (std::size_t i = 0; i < 4; ++i) {
            nets[j][i][k] = c[i];
          }
        }
      }
      examine_cells(nets[0][0].data(), highest, round_off.data(), findings.data());
      for (std::size_t k = 0; k < count; ++k) {
        if (findings[k] != Finding::none) {
          Cell(coefficients, row, columns_left[begin + k], highest)
              .search(one_of(nets, k), round_off[k], findings[k], keep);
        }
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
