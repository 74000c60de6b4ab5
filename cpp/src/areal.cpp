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

std::string shape_text(const MatrixView& map) {
  return std::to_string(map.rows()) + " by " + std::to_string(map.cols());
}

void check(const SurfacePair& pair, double deepest) {
  if (pair.upper.rows() != pair.lower.rows() || pair.upper.cols() != pair.lower.cols()) {
    fail("upper and lower must have equal shapes, got " + shape_text(pair.upper) + " and " + shape_text(pair.lower));
  }
  if (pair.upper.rows() < min_map_points || pair.upper.cols() < min_map_points) {
    fail("upper and lower must have at least 4 rows and 4 columns, got " + shape_text(pair.upper));
  }
  for (const double spacing : pair.spacing) {
    if (!(spacing > 0.0) || !std::isfinite(spacing)) {
      fail("spacing must be above 0 and finite, got " + format_number(spacing) + " µm");
    }
  }
  if (!(deepest >= 0.0) || !std::isfinite(deepest)) {
    fail("approach must be at least 0 and finite, got " + format_number(deepest) + " µm");
  }
}

// Range of the heights of a row. `zero` is 0 if all heights of the row are finite, and NaN otherwise.
struct RowRange {
  double lowest;
  double highest;
  double largest;
  double zero;
};

STICTION_MULTIVERSION
RowRange row_range(const double* upper, const double* lower, Index size) {
  constexpr Index lanes = 16;
  double lowest[lanes];
  double highest[lanes];
  double largest[lanes] = {};
  double zero[lanes] = {};
  std::fill_n(lowest, lanes, std::numeric_limits<double>::infinity());
  std::fill_n(highest, lanes, -std::numeric_limits<double>::infinity());
  const auto add = [&](Index i, Index lane) {
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
  for (; i + lanes <= size; i += lanes) {
    for (Index lane = 0; lane < lanes; ++lane) {
      add(i + lane, lane);
    }
  }
  for (; i < size; ++i) {
    add(i, 0);
  }
  return {*std::min_element(lowest, lowest + lanes), *std::max_element(highest, highest + lanes),
          *std::max_element(largest, largest + lanes), std::accumulate(zero, zero + lanes, 0.0)};
}

STICTION_MULTIVERSION
void subtract(const double* upper, const double* lower, Index size, double offset, double* result) {
  for (Index i = 0; i < size; ++i) {
    result[i] = (upper[i] - lower[i]) - offset;
  }
}

// Mark grid points with a gap of at most `deepest`, and with no smaller gap, except for round-off, at eight neighbours.
STICTION_MULTIVERSION
void mark_grid_minima(const double* above, const double* at, const double* below, Index size, double deepest,
                      double round_off, unsigned char* marks) {
  constexpr Index block = 32;
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

// Part of a map that fits into the cache: a range of cells, and the surrounding points that influence their spline.
struct Tile {
  CellRange cells;
  Index row;  // (row, column) is the position of the tile's first point in the map
  Index column;
  Index rows;
  Index columns;
};

std::vector<Tile> make_tiles(Index rows, Index columns) {
  constexpr Index size = 256;
  // A height more than 32 points away changes the spline by less than 0.268^32 = 5e-19 of this height.
  constexpr Index margin = 32;
  std::vector<Tile> tiles;
  for (Index row = 0; row < rows - 1; row += size) {
    for (Index column = 0; column < columns - 1; column += size) {
      const CellRange cells{row, column, std::min(size, rows - 1 - row), std::min(size, columns - 1 - column)};
      const Index first_row = std::max<Index>(0, row - margin);
      const Index first_column = std::max<Index>(0, column - margin);
      tiles.push_back({cells, first_row, first_column, std::min(rows, row + cells.rows + 1 + margin) - first_row,
                       std::min(columns, column + cells.columns + 1 + margin) - first_column});
    }
  }
  return tiles;
}

// Return sqrt(a² + b²) without overflow of a² or b². std::hypot would require a newer C library.
double length(double a, double b) {
  const double longer = std::max(std::abs(a), std::abs(b));
  const double ratio = std::min(std::abs(a), std::abs(b)) / longer;
  return longer > 0.0 ? longer * std::sqrt(1.0 + ratio * ratio) : longer;
}

double smaller_curvature(double xx, double xy, double yy) { return 0.5 * (xx + yy) - length(0.5 * (xx - yy), xy); }

struct GridMinimum {
  Index row;
  Index column;
  double gap;
};

struct SplineMinimum {
  Minimum minimum;
  Jet lower;

  Index cell(Index columns) const { return minimum.row * columns + minimum.column; }
};

void add_candidate(const SurfacePair& pair, const SplineMinimum& spline_minimum, double offset,
                   std::vector<ArealCandidate>& candidates) {
  const double dx = pair.spacing.x();
  const double dy = pair.spacing.y();
  const auto& [row, column, u, v, gap] = spline_minimum.minimum;
  const ContactGeometry geometry = contact_geometry({spline_minimum.lower.x / dx, spline_minimum.lower.y / dy},
                                                    gap.xx / (dx * dx), gap.xy / (dx * dy), gap.yy / (dy * dy));
  if (!(geometry.radii.major > 0.0) || !std::isfinite(geometry.radii.major)) {
    return;
  }
  const Vector3 position(dx * (static_cast<double>(column) + u), dy * (static_cast<double>(row) + v),
                         offset + spline_minimum.lower.value);
  ArealCandidate candidate{row,
                           column,
                           position,
                           gap.value,
                           0.0,
                           geometry.normal,
                           geometry.radii,
                           geometry.along,
                           hertz_ellipse(geometry.radii.major, geometry.radii.minor)};
  const ProjectedEllipse ellipse = projected_ellipse(candidate);
  const double x = std::min(position.x(), dx * static_cast<double>(pair.lower.cols() - 1) - position.x());
  const double y = std::min(position.y(), dy * static_cast<double>(pair.lower.rows() - 1) - position.y());
  candidate.edge_overlap = std::min(x * x / ellipse.xx, y * y / ellipse.yy);
  candidates.push_back(candidate);
}

}  // namespace

ContactGeometry contact_geometry(const Vector2& slope, double xx, double xy, double yy) {
  const double q2 = 1.0 + slope.squaredNorm();
  const double q = std::sqrt(q2);
  // With q = sqrt(1 + p²), the power (I + p pᵀ)^(-1/2) of the metric is I - p pᵀ / (q (q + 1)).
  // The matrix (a, b; b, c) is (I + p pᵀ)^(-1/2) · (Hessian matrix) · (I + p pᵀ)^(-1/2) / q.
  const double factor = 1.0 / (q * (q + 1.0));
  const double r00 = 1.0 - factor * slope.x() * slope.x();
  const double r01 = -factor * slope.x() * slope.y();
  const double r11 = 1.0 - factor * slope.y() * slope.y();
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
  // The eigenvector of the smaller eigenvalue is computed from the matrix row that causes no cancellation.
  Vector2 vector =
      half_difference > 0.0 ? Vector2(-b, half_difference + radius) : Vector2(radius - half_difference, -b);
  vector = radius > 0.0 ? Vector2(vector.normalized()) : Vector2(1.0, 0.0);
  const Vector2 horizontal(r00 * vector.x() + r01 * vector.y(), r01 * vector.x() + r11 * vector.y());
  return {Vector3(-slope.x(), -slope.y(), 1.0) / q,
          {1.0 / std::min(smaller, larger), 1.0 / larger},
          Vector3(horizontal.x(), horizontal.y(), horizontal.dot(slope))};
}

ArealCandidates candidates(const SurfacePair& pair, double deepest, Curvature curvature,
                           const CancellationCheck& check_cancellation) {
  check(pair, deepest);
  const Index rows = pair.upper.rows();
  const Index columns = pair.upper.cols();
  RowRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 0.0, 0.0};
  for (Index row = 0; row < rows; ++row) {
    const RowRange in_row = row_range(pair.upper.row(row).data(), pair.lower.row(row).data(), columns);
    range = {std::min(range.lowest, in_row.lowest), std::max(range.highest, in_row.highest),
             std::max(range.largest, in_row.largest), range.zero + in_row.zero};
  }
  if (range.zero != 0.0) {
    fail("upper and lower must be finite, got NaN or infinite heights");
  }
  if (!(range.lowest < range.highest)) {
    fail("upper and lower must not be parallel: their gap is constant and has no minimum");
  }

  const std::vector<Tile> tiles = make_tiles(rows, columns);
  Index max_rows = 0;
  Index max_columns = 0;
  for (const Tile& tile : tiles) {
    max_rows = std::max(max_rows, tile.rows);
    max_columns = std::max(max_columns, tile.columns);
  }
  std::vector<double> buffer(static_cast<std::size_t>((max_rows + 2) * (max_columns + 2)));
  Eigen::Map<Matrix> workspace(buffer.data(), max_rows + 2, max_columns + 2);
  std::vector<unsigned char> marks(static_cast<std::size_t>(max_columns));
  std::vector<GridMinimum> grid_minima;
  std::vector<SplineMinimum> spline_minima;
  const double offset = pair.lower(0, 0);
  const double round_off = round_off_fraction * range.largest;
  // Slopes and curvatures up to `level_limit` [µm] count as zero. This limit exceeds the round-off of the heights.
  const double level_limit = std::max(level_fraction * (range.highest - range.lowest), 16.0 * round_off);
  for (const Tile& tile : tiles) {
    check_cancellation();
    auto spline = workspace.topLeftCorner(tile.rows + 2, tile.columns + 2);
    auto heights = spline.block(1, 1, tile.rows, tile.columns);
    for (Index row = 0; row < tile.rows; ++row) {
      subtract(pair.upper.row(tile.row + row).data() + tile.column, pair.lower.row(tile.row + row).data() + tile.column,
               tile.columns, range.lowest, &heights(row, 0));
    }
    const CellRange cells{tile.cells.row - tile.row, tile.cells.column - tile.column, tile.cells.rows,
                          tile.cells.columns};
    for (Index row = std::max<Index>(cells.row, 1); row < cells.row + cells.rows; ++row) {
      const double* at = &heights(row, 0);
      mark_grid_minima(at - workspace.outerStride(), at, at + workspace.outerStride(), tile.columns, deepest, round_off,
                       marks.data());
      for_each_marked(marks.data(), std::max<Index>(cells.column, 1), cells.column + cells.columns,
                      [&](Index i) { grid_minima.push_back({tile.row + row, tile.column + i, at[i]}); });
    }
    natural_bicubic(spline);
    std::vector<Minimum> minima_in_tile = minima(spline, cells, deepest, check_cancellation);
    std::erase_if(minima_in_tile, [&](const Minimum& minimum) {
      return smaller_curvature(minimum.at.xx, minimum.at.xy, minimum.at.yy) <= level_limit;
    });
    if (minima_in_tile.empty()) {
      continue;
    }
    heights = (pair.lower.block(tile.row, tile.column, tile.rows, tile.columns).array() - offset).matrix();
    natural_bicubic(spline);
    for (const Minimum& minimum : minima_in_tile) {
      spline_minima.push_back({minimum, at_minimum(spline, minimum)});
      // Slopes up to `level_limit` count as zero, so that round-off does not decide which contacts oppose the motion.
      for (double* slope : {&spline_minima.back().lower.x, &spline_minima.back().lower.y}) {
        *slope = std::abs(*slope) > level_limit ? *slope : 0.0;
      }
      spline_minima.back().minimum.row += tile.row;
      spline_minima.back().minimum.column += tile.column;
    }
  }

  // Two neighbouring tiles may both contain the same minimum, at their common edge.
  std::stable_sort(spline_minima.begin(), spline_minima.end(),
                   [&](const SplineMinimum& a, const SplineMinimum& b) { return a.cell(columns) < b.cell(columns); });
  const auto repeated = [&](const SplineMinimum& a, const SplineMinimum& b) {
    return a.cell(columns) == b.cell(columns) && is_same(a.minimum, b.minimum);
  };
  spline_minima.erase(std::unique(spline_minima.begin(), spline_minima.end(), repeated), spline_minima.end());

  ArealCandidates result{{}, {}, {}, deepest, pair.spacing, rows, columns};
  const auto before = [&](const SplineMinimum& spline_minimum, Index cell) {
    return spline_minimum.cell(columns) < cell;
  };
  for (const GridMinimum& point : grid_minima) {
    bool matched = false;
    for (const Index row : {point.row - 1, point.row}) {
      const Index first = row * columns + point.column - 1;
      const auto near = std::lower_bound(spline_minima.begin(), spline_minima.end(), first, before);
      matched = matched || (near != spline_minima.end() && near->cell(columns) <= first + 1);
    }
    result.grid_minima.push_back(point.gap);
    if (!matched) {
      result.unanswered.push_back(point.gap);
    }
  }
  std::sort(result.grid_minima.begin(), result.grid_minima.end());
  std::sort(result.unanswered.begin(), result.unanswered.end());
  for (const SplineMinimum& spline_minimum : spline_minima) {
    const Jet& below = spline_minimum.lower;
    const Jet& gap = spline_minimum.minimum.at;
    const bool summits = smaller_curvature(-below.xx, -below.xy, -below.yy) >= -level_limit &&
                         smaller_curvature(below.xx + gap.xx, below.xy + gap.xy, below.yy + gap.yy) >= -level_limit;
    if (curvature == Curvature::signed_ || summits) {
      add_candidate(pair, spline_minimum, offset, result.all);
    }
  }
  return result;
}

}  // namespace stiction
