#include "stiction/areal.hpp"

#include "areal_overlaps.hpp"
#include "checks.hpp"
#include "marks.hpp"
#include "multiversion.hpp"
#include "stiction/minima.hpp"
#include "text.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

namespace stiction {
namespace {

std::string size_of(const MatrixView& map) { return std::to_string(map.rows()) + " by " + std::to_string(map.cols()); }

void check(const SurfacePair& pair, double deepest) {
  if (pair.upper.rows() != pair.lower.rows() || pair.upper.cols() != pair.lower.cols()) {
    fail("upper and lower must have equal shapes, not " + size_of(pair.upper) + " and " + size_of(pair.lower));
  }
  if (pair.upper.rows() < fewest_points || pair.upper.cols() < fewest_points) {
    fail("upper and lower have a shape of " + size_of(pair.upper) + ", at least 4 rows and 4 columns are needed");
  }
  for (const double spacing : pair.spacing) {
    if (!(spacing > 0.0) || !std::isfinite(spacing)) {
      fail("spacing is " + text(spacing) + " µm, must be above 0 and finite");
    }
  }
  if (!(deepest >= 0.0) || !std::isfinite(deepest)) {
    fail("approach is " + text(deepest) + " µm, must be 0 or above and finite");
  }
}

// The range of the gap in a row, the largest height of both bodies, and 0, or NaN where a height is not finite.
struct RowRange {
  double lowest;
  double highest;
  double largest;
  double zero;
};

STICTION_MULTIVERSION
RowRange range_of(const double* upper, const double* lower, Index size) {
  constexpr Index width = 16;
  double lowest[width];
  double highest[width];
  double largest[width] = {};
  double zero[width] = {};
  std::fill_n(lowest, width, std::numeric_limits<double>::infinity());
  std::fill_n(highest, width, -std::numeric_limits<double>::infinity());
  const auto take = [&](Index i, Index lane) {
    const double gap = upper[i] - lower[i];
    lowest[lane] = gap < lowest[lane] ? gap : lowest[lane];
    highest[lane] = gap > highest[lane] ? gap : highest[lane];
    const double above = std::abs(upper[i]);
    const double below = std::abs(lower[i]);
    const double larger = above > below ? above : below;
    largest[lane] = larger > largest[lane] ? larger : largest[lane];
    zero[lane] += gap - gap;
  };
  Index i = 0;
  for (; i + width <= size; i += width) {
    for (Index lane = 0; lane < width; ++lane) {
      take(i + lane, lane);
    }
  }
  for (; i < size; ++i) {
    take(i, 0);
  }
  return {*std::min_element(lowest, lowest + width), *std::max_element(highest, highest + width),
          *std::max_element(largest, largest + width), std::accumulate(zero, zero + width, 0.0)};
}

STICTION_MULTIVERSION
void subtract(const double* upper, const double* lower, Index size, double offset, double* result) {
  for (Index i = 0; i < size; ++i) {
    result[i] = (upper[i] - lower[i]) - offset;
  }
}

// Marks the points of a row of which none of the eight neighbours is lower by more than round-off and that are at most
// `deepest` high, but for both ends.
STICTION_MULTIVERSION
void mark_grid_minima(const double* above, const double* at, const double* below, Index size, double deepest,
                      double round_off, unsigned char* marks) {
  constexpr Index block = 32;  // of which few have points that low
  for (Index first = 1; first + 1 < size; first += block) {
    const Index end = std::min(first + block, size - 1);
    unsigned char any = 0;
    for (Index i = first; i < end; ++i) {
      marks[i] = static_cast<unsigned char>(at[i] <= deepest);
      any |= marks[i];
    }
    for (Index i = first; any != 0 && i < end; ++i) {
      const double z = at[i] - round_off;
      marks[i] &=
          static_cast<unsigned char>((z <= at[i - 1]) & (z <= at[i + 1]) & (z <= above[i - 1]) & (z <= above[i]) &
                                     (z <= above[i + 1]) & (z <= below[i - 1]) & (z <= below[i]) & (z <= below[i + 1]));
    }
  }
}

// A part of a map, so small that its arrays stay in the processor's cache: cells of its own, and points as far around
// them as their splines reach.
struct Tile {
  Cells cells;   // of the map
  Index row;     // the first point
  Index column;  // likewise
  Index rows;    // points
  Index columns;
};

std::vector<Tile> tiles_of(Index rows, Index columns) {
  constexpr Index size = 256;   // of cells
  constexpr Index around = 32;  // 0.268^32 = 5e-19 of a height
  std::vector<Tile> tiles;
  for (Index row = 0; row < rows - 1; row += size) {
    for (Index column = 0; column < columns - 1; column += size) {
      const Cells cells{row, column, std::min(size, rows - 1 - row), std::min(size, columns - 1 - column)};
      const Index first_row = std::max<Index>(0, row - around);
      const Index first_column = std::max<Index>(0, column - around);
      tiles.push_back({cells, first_row, first_column, std::min(rows, row + cells.rows + 1 + around) - first_row,
                       std::min(columns, column + cells.columns + 1 + around) - first_column});
    }
  }
  return tiles;
}

// Without overflow on the way. Not std::hypot, which asks for a newer C library than all else.
double length(double a, double b) {
  const double longer = std::max(std::abs(a), std::abs(b));
  const double ratio = std::min(std::abs(a), std::abs(b)) / longer;
  return longer > 0.0 ? longer * std::sqrt(1.0 + ratio * ratio) : longer;
}

// The smaller principal second derivative.
double smaller_bend(double xx, double xy, double yy) { return 0.5 * (xx + yy) - length(0.5 * (xx - yy), xy); }

// A point of which no neighbour is lower.
struct GridMinimum {
  Index row;
  Index column;
  double gap;
};

// A minimum of the gap, and the lower body there.
struct Place {
  Minimum minimum;
  Jet lower;

  Index cell(Index columns) const { return minimum.row * columns + minimum.column; }
};

void add_candidate(const SurfacePair& pair, const Place& place, double offset, std::vector<ArealCandidate>& all) {
  const double dx = pair.spacing.x();
  const double dy = pair.spacing.y();
  const auto& [row, column, u, v, gap] = place.minimum;
  const Meeting met =
      meeting({place.lower.x / dx, place.lower.y / dy}, gap.xx / (dx * dx), gap.xy / (dx * dy), gap.yy / (dy * dy));
  if (!(met.radii.major > 0.0) || !std::isfinite(met.radii.major)) {
    return;
  }
  const Vector3 position(dx * (static_cast<double>(column) + u), dy * (static_cast<double>(row) + v),
                         offset + place.lower.value);
  ArealCandidate candidate{row,       column,    position,
                           gap.value, 0.0,       met.normal,
                           met.radii, met.along, hertz_ellipse(met.radii.major, met.radii.minor)};
  const Shape shape = shape_of(candidate);
  const double x = std::min(position.x(), dx * static_cast<double>(pair.lower.cols() - 1) - position.x());
  const double y = std::min(position.y(), dy * static_cast<double>(pair.lower.rows() - 1) - position.y());
  candidate.room = std::min(x * x / shape.xx, y * y / shape.yy);
  all.push_back(candidate);
}

}  // namespace

Meeting meeting(const Vector2& slope, double xx, double xy, double yy) {
  const double q2 = 1.0 + slope.squaredNorm();
  const double q = std::sqrt(q2);
  // The metric to the power -1/2 is I - p pᵀ / (q (q + 1)); on both sides of the Hessian it leaves an ordinary
  // eigenvalue problem, of the matrix (a, b; b, c).
  const double shrink = 1.0 / (q * (q + 1.0));
  const double r00 = 1.0 - shrink * slope.x() * slope.x();
  const double r01 = -shrink * slope.x() * slope.y();
  const double r11 = 1.0 - shrink * slope.y() * slope.y();
  const double h00 = r00 * xx + r01 * xy;
  const double h01 = r00 * xy + r01 * yy;
  const double h10 = r01 * xx + r11 * xy;
  const double h11 = r01 * xy + r11 * yy;
  const double a = (h00 * r00 + h01 * r01) / q;
  const double b = (h00 * r01 + h01 * r11) / q;
  const double c = (h10 * r01 + h11 * r11) / q;
  const double half_difference = 0.5 * (a - c);
  const double radius = length(half_difference, b);
  const double larger = 0.5 * (a + c) + radius;
  const double smaller = (xx * yy - xy * xy) / (q2 * q2) / larger;
  // The eigenvector of the smaller one, from whichever row does not cancel.
  Vector2 vector =
      half_difference > 0.0 ? Vector2(-b, half_difference + radius) : Vector2(radius - half_difference, -b);
  vector = radius > 0.0 ? Vector2(vector.normalized()) : Vector2(1.0, 0.0);
  const Vector2 horizontal(r00 * vector.x() + r01 * vector.y(), r01 * vector.x() + r11 * vector.y());
  return {Vector3(-slope.x(), -slope.y(), 1.0) / q,
          {1.0 / std::min(smaller, larger), 1.0 / larger},
          Vector3(horizontal.x(), horizontal.y(), horizontal.dot(slope))};
}

ArealCandidates candidates(const SurfacePair& pair, double deepest, Curvature curvature, const Checkpoint& checkpoint) {
  check(pair, deepest);
  const Index rows = pair.upper.rows();
  const Index columns = pair.upper.cols();
  RowRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 0.0, 0.0};
  for (Index row = 0; row < rows; ++row) {
    const RowRange one = range_of(pair.upper.row(row).data(), pair.lower.row(row).data(), columns);
    range = {std::min(range.lowest, one.lowest), std::max(range.highest, one.highest),
             std::max(range.largest, one.largest), range.zero + one.zero};
  }
  if (range.zero != 0.0) {
    fail("upper or lower has heights that are NaN or infinite");
  }
  if (!(range.lowest < range.highest)) {
    fail("upper and lower are parallel: their gap is the same everywhere, and so it has no minimum");
  }

  const std::vector<Tile> tiles = tiles_of(rows, columns);
  Index most_rows = 0;
  Index most_columns = 0;
  for (const Tile& tile : tiles) {
    most_rows = std::max(most_rows, tile.rows);
    most_columns = std::max(most_columns, tile.columns);
  }
  std::vector<double> kept(static_cast<std::size_t>((most_rows + 2) * (most_columns + 2)));
  Eigen::Map<Matrix> work(kept.data(), most_rows + 2, most_columns + 2);
  std::vector<unsigned char> marks(static_cast<std::size_t>(most_columns));
  std::vector<GridMinimum> points;
  std::vector<Place> places;
  const double offset = pair.lower(0, 0);
  const double round_off = round_off_share * range.largest;
  // Where heights are known to round-off only, no better than that.
  const double level = std::max(level_share * (range.highest - range.lowest), 16.0 * round_off);
  for (const Tile& tile : tiles) {
    checkpoint();
    auto spline = work.topLeftCorner(tile.rows + 2, tile.columns + 2);
    auto heights = spline.block(1, 1, tile.rows, tile.columns);
    for (Index row = 0; row < tile.rows; ++row) {
      subtract(pair.upper.row(tile.row + row).data() + tile.column, pair.lower.row(tile.row + row).data() + tile.column,
               tile.columns, range.lowest, &heights(row, 0));
    }
    const Cells cells{tile.cells.row - tile.row, tile.cells.column - tile.column, tile.cells.rows, tile.cells.columns};
    for (Index row = std::max<Index>(cells.row, 1); row < cells.row + cells.rows; ++row) {
      const double* at = &heights(row, 0);
      mark_grid_minima(at - work.outerStride(), at, at + work.outerStride(), tile.columns, deepest, round_off,
                       marks.data());
      for_each_marked(marks.data(), std::max<Index>(cells.column, 1), cells.column + cells.columns,
                      [&](Index i) { points.push_back({tile.row + row, tile.column + i, at[i]}); });
    }
    natural_bicubic(spline);
    std::vector<Minimum> found = minima(spline, cells, deepest, checkpoint);
    std::erase_if(found, [&](const Minimum& one) { return smaller_bend(one.at.xx, one.at.xy, one.at.yy) <= level; });
    if (found.empty()) {
      continue;
    }
    heights = (pair.lower.block(tile.row, tile.column, tile.rows, tile.columns).array() - offset).matrix();
    natural_bicubic(spline);
    for (const Minimum& one : found) {
      places.push_back({one, at_minimum(spline, one)});
      // So that no contact opposes by round-off.
      for (double* slope : {&places.back().lower.x, &places.back().lower.y}) {
        *slope = std::abs(*slope) > level ? *slope : 0.0;
      }
      places.back().minimum.row += tile.row;
      places.back().minimum.column += tile.column;
    }
  }

  // On the seam of two tiles the same minimum may have been found twice.
  std::stable_sort(places.begin(), places.end(),
                   [&](const Place& a, const Place& b) { return a.cell(columns) < b.cell(columns); });
  const auto repeated = [&](const Place& a, const Place& b) {
    return a.cell(columns) == b.cell(columns) && is_same(a.minimum, b.minimum);
  };
  places.erase(std::unique(places.begin(), places.end(), repeated), places.end());

  ArealCandidates result{{}, {}, {}, deepest, pair.spacing, rows, columns};
  const auto before = [&](const Place& place, Index cell) { return place.cell(columns) < cell; };
  for (const GridMinimum& point : points) {
    bool answered = false;
    for (const Index row : {point.row - 1, point.row}) {
      const Index first = row * columns + point.column - 1;
      const auto near = std::lower_bound(places.begin(), places.end(), first, before);
      answered = answered || (near != places.end() && near->cell(columns) <= first + 1);
    }
    result.grid_minima.push_back(point.gap);
    if (!answered) {
      result.unanswered.push_back(point.gap);
    }
  }
  std::sort(result.grid_minima.begin(), result.grid_minima.end());
  std::sort(result.unanswered.begin(), result.unanswered.end());
  for (const Place& place : places) {
    const Jet& below = place.lower;
    const Jet& gap = place.minimum.at;
    const bool summits = smaller_bend(-below.xx, -below.xy, -below.yy) >= -level &&
                         smaller_bend(below.xx + gap.xx, below.xy + gap.xy, below.yy + gap.yy) >= -level;
    if (curvature == Curvature::signed_ || summits) {
      add_candidate(pair, place, offset, result.all);
    }
  }
  return result;
}

}  // namespace stiction
