#include "stiction/areal.hpp"

#include "multiversion.hpp"
#include "stiction/minima.hpp"
#include "text.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <string>

namespace stiction {
namespace {

using std::numbers::pi;

[[noreturn]] void fail(const std::string& what) { throw std::invalid_argument(what); }

std::string size_of(const MatrixView& map) { return std::to_string(map.rows()) + " by " + std::to_string(map.cols()); }

// ---- From maps to the gap -------------------------------------------------------------------------------------------

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

// The range of the gap in a row, and 0, or NaN where a height is not finite.
struct RowRange {
  double lowest;
  double highest;
  double zero;
};

STICTION_MULTIVERSION
RowRange range_of(const double* upper, const double* lower, Index size) {
  constexpr Index lanes = 16;
  double lowest[lanes];
  double highest[lanes];
  double zero[lanes] = {};
  std::fill_n(lowest, lanes, std::numeric_limits<double>::infinity());
  std::fill_n(highest, lanes, -std::numeric_limits<double>::infinity());
  const auto take = [&](Index i, Index lane) {
    const double gap = upper[i] - lower[i];
    lowest[lane] = gap < lowest[lane] ? gap : lowest[lane];
    highest[lane] = gap > highest[lane] ? gap : highest[lane];
    zero[lane] += gap - gap;
  };
  Index i = 0;
  for (; i + lanes <= size; i += lanes) {
    for (Index lane = 0; lane < lanes; ++lane) {
      take(i + lane, lane);
    }
  }
  for (; i < size; ++i) {
    take(i, 0);
  }
  return {*std::min_element(lowest, lowest + lanes), *std::max_element(highest, highest + lanes),
          std::accumulate(zero, zero + lanes, 0.0)};
}

// Marks the points of a row that are lower than their eight neighbours and at most `deepest` high, but for both ends.
STICTION_MULTIVERSION
void mark_grid_minima(const double* above, const double* at, const double* below, Index size, double deepest,
                      unsigned char* marks) {
  for (Index i = 1; i + 1 < size; ++i) {
    const double z = at[i];
    marks[i] = (z <= deepest) & (z < at[i - 1]) & (z < at[i + 1]) & (z < above[i - 1]) & (z < above[i]) &
               (z < above[i + 1]) & (z < below[i - 1]) & (z < below[i]) & (z < below[i + 1]);
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

bool is_summit(double xx, double xy, double yy, double sign) {
  return sign * xx > 0.0 && sign * yy > 0.0 && xx * yy > xy * xy;
}

bool is_level(const MatrixView& map) {
  const double first = map(0, 0);
  return (map.row(0).array() == first).all() && (map.array() == first).all();
}

// A point that is lower than its neighbours.
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

// ---- Ellipses in the plane ------------------------------------------------------------------------------------------

// The shape {x : xᵀ S⁻¹ x <= 1} of an ellipse of unit overlap, seen from above.
struct Shape {
  double xx;
  double xy;
  double yy;
};

Shape shape_of(const ArealCandidate& candidate) {
  const Vector3 across = candidate.normal.cross(candidate.along);
  const auto entry = [&](Index i, Index j) {
    return candidate.ellipse.major * candidate.along[i] * candidate.along[j] +
           candidate.ellipse.minor * across[i] * across[j];
  };
  return {entry(0, 0), entry(0, 1), entry(1, 1)};
}

// Whether two ellipses overlap whose centres are r apart: they are apart where for some λ in (0, 1)
// λ (1 - λ) rᵀ [(1 - λ) A + λ B]⁻¹ r > 1, a function with one maximum (Perram & Wertheim, J. Comput. Phys. 58 (1985)
// 409), found here by golden section.
bool overlap(const Shape& a, double a_size, const Shape& b, double b_size, const Vector2& r) {
  const auto contact = [&](double at) {
    const double one = (1.0 - at) * a_size;
    const double other = at * b_size;
    const double xx = one * a.xx + other * b.xx;
    const double xy = one * a.xy + other * b.xy;
    const double yy = one * a.yy + other * b.yy;
    return at * (1.0 - at) * (yy * r.x() * r.x() - 2.0 * xy * r.x() * r.y() + xx * r.y() * r.y()) / (xx * yy - xy * xy);
  };
  constexpr double golden = 0.6180339887498949;
  double low = 0.0;
  double high = 1.0;
  double left = 1.0 - golden;
  double right = golden;
  double at_left = contact(left);
  double at_right = contact(right);
  for (int i = 0; i < 25; ++i) {
    if (at_left > 1.0 || at_right > 1.0) {
      return false;
    }
    if (at_left > at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - golden * (high - low);
      at_left = contact(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + golden * (high - low);
      at_right = contact(right);
    }
  }
  return true;
}

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
  candidate.farthest = candidate.gap + std::min(x * x / shape.xx, y * y / shape.yy) / candidate.normal.z();
  all.push_back(candidate);
}

// The approaches at which a candidate is a contact, as a range of their indices.
struct Steps {
  std::size_t begin;
  std::size_t end;
};

Steps steps_of(const ArealCandidate& candidate, Values approaches) {
  const auto behind = [&](double approach) {
    return static_cast<std::size_t>(std::upper_bound(approaches.begin(), approaches.end(), approach) -
                                    approaches.begin());
  };
  return {behind(candidate.gap), behind(candidate.farthest)};
}

// For each candidate, the first of the approaches at which its ellipse overlaps another: as many as there are for none.
// Ellipses grow with the approach about their centres, so once overlapping they are so for ever.
std::vector<std::size_t> first_overlaps(const std::vector<ArealCandidate>& all, Values approaches,
                                        const Checkpoint& checkpoint) {
  struct Seen {
    std::size_t index;
    Steps steps;
    Shape shape;
    double left;
    double right;
    double half_height;
  };
  std::vector<Seen> seen;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const Steps steps = steps_of(all[i], approaches);
    if (steps.begin < steps.end) {
      const Shape shape = shape_of(all[i]);
      const double size = all[i].overlap(approaches[steps.end - 1]);
      const double reach = std::sqrt(shape.xx * size);
      const double x = all[i].position.x();
      seen.push_back({i, steps, shape, x - reach, x + reach, std::sqrt(shape.yy * size)});
    }
  }
  std::sort(seen.begin(), seen.end(), [](const Seen& a, const Seen& b) { return a.left < b.left; });
  std::vector<std::size_t> first(all.size(), approaches.size());
  for (std::size_t i = 0; i < seen.size(); ++i) {
    checkpoint();
    const Seen& one = seen[i];
    const ArealCandidate& a = all[one.index];
    for (std::size_t j = i + 1; j < seen.size() && seen[j].left <= one.right; ++j) {
      const Seen& other = seen[j];
      const ArealCandidate& b = all[other.index];
      const Vector2 apart = (b.position - a.position).head<2>();
      const auto at = [&](std::size_t k) {
        return overlap(one.shape, a.overlap(approaches[k]), other.shape, b.overlap(approaches[k]), apart);
      };
      // Nothing new is to be learned at and behind the later of what is known of the two.
      std::size_t begin = std::max(one.steps.begin, other.steps.begin);
      std::size_t end = std::min({std::max(first[one.index], first[other.index]), one.steps.end, other.steps.end});
      if (begin >= end || std::abs(apart.y()) > one.half_height + other.half_height || !at(end - 1)) {
        continue;
      }
      --end;
      while (begin < end) {
        const std::size_t middle = (begin + end) / 2;
        if (at(middle)) {
          end = middle;
        } else {
          begin = middle + 1;
        }
      }
      first[one.index] = std::min(first[one.index], end);
      first[other.index] = std::min(first[other.index], end);
    }
  }
  return first;
}

// ---- What a contact carries -----------------------------------------------------------------------------------------

double elastic_area(const Ellipse& ellipse, double overlap) {
  return pi * std::sqrt(ellipse.major * ellipse.minor) * overlap;
}

// Laws of spheres take the one of the mean radius, unless they say better.
template <class AnyLaw>
ForceArea carried(const AnyLaw& law, const ArealCandidate& candidate, double overlap) {
  return law(overlap, candidate.radii);
}

ForceArea carried(const HertzSphere& law, const ArealCandidate& candidate, double overlap) {
  return {4.0 / 3.0 * law.effective_modulus * std::sqrt(candidate.ellipse.stiff * overlap) * overlap,
          elastic_area(candidate.ellipse, overlap)};
}

[[noreturn]] ForceArea carried(const HertzCylinder&, const ArealCandidate&, double) {
  fail("law hertz-cylinder is of parallel cylinders, and contacts of surfaces are ellipses: take hertz-sphere");
}

void check(const ArealCandidates& found, Values approaches, const Law& law) {
  if (approaches.empty()) {
    fail("approaches is empty, at least one is needed");
  }
  for (std::size_t k = 0; k < approaches.size(); ++k) {
    if (!(approaches[k] >= 0.0) || !std::isfinite(approaches[k])) {
      fail("approach is " + text(approaches[k]) + " µm, must be 0 or above and finite");
    }
    if (k > 0 && !(approaches[k] > approaches[k - 1])) {
      fail("approaches must increase, but " + text(approaches[k - 1]) + " µm is followed by " + text(approaches[k]) +
           " µm");
    }
  }
  if (!(approaches.back() <= found.deepest)) {
    fail("approach is " + text(approaches.back()) + " µm, but candidates were looked for up to " + text(found.deepest) +
         " µm");
  }
  stiction::check(law);
  if (std::holds_alternative<HertzCylinder>(law)) {
    carried(std::get<HertzCylinder>(law), {}, 0.0);
  }
}

void check(const Vector2& direction) {
  if (!(std::abs(direction.norm() - 1.0) < 1e-9)) {
    fail("direction is (" + text(direction.x()) + ", " + text(direction.y()) + "), must be a unit vector");
  }
}

// ---- Sums -----------------------------------------------------------------------------------------------------------

// What depends on the direction: multiples of force, then multiples of area.
constexpr std::size_t of_force = 5;
constexpr std::size_t of_area = 3;
using Directed = std::array<double, of_force + of_area>;

Directed directed(const Vector3& normal, const Vector2& direction) {
  const Vector2 lateral(-direction.y(), direction.x());
  const Vector3 friction = tangent(normal, direction);
  const double along = -friction.head<2>().dot(direction);
  const double across = -friction.head<2>().dot(lateral);
  return {-normal.head<2>().dot(direction),
          -normal.head<2>().dot(lateral),
          friction.z(),
          along,
          across,
          friction.z(),
          along,
          across};
}

// sums(m, k) += factors[m] values(k), force for the first factors and area for the others.
STICTION_MULTIVERSION
void accumulate(const double* factors, const double* force, const double* area, std::size_t begin, std::size_t end,
                std::size_t stride, double* sums) {
  for (std::size_t m = 0; m < of_force + of_area; ++m) {
    const double factor = factors[m];
    const double* values = m < of_force ? force : area;
    double* sum = sums + m * stride;
    for (std::size_t k = begin; k < end; ++k) {
      sum[k] += factor * values[k];
    }
  }
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
  const double radius = std::hypot(half_difference, b);
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
  RowRange range{std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity(), 0.0};
  for (Index row = 0; row < rows; ++row) {
    const RowRange one = range_of(pair.upper.row(row).data(), pair.lower.row(row).data(), columns);
    range = {std::min(range.lowest, one.lowest), std::max(range.highest, one.highest), range.zero + one.zero};
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
  Matrix work(most_rows + 2, most_columns + 2);
  std::vector<unsigned char> marks(static_cast<std::size_t>(most_columns));
  std::vector<GridMinimum> points;
  std::vector<Place> places;
  const double offset = pair.lower(0, 0);
  const bool level_upper = is_level(pair.upper);
  for (const Tile& tile : tiles) {
    checkpoint();
    auto spline = work.topLeftCorner(tile.rows + 2, tile.columns + 2);
    auto heights = spline.block(1, 1, tile.rows, tile.columns);
    const auto of_tile = [&](const MatrixView& map) {
      return map.block(tile.row, tile.column, tile.rows, tile.columns).array();
    };
    heights = ((of_tile(pair.upper) - of_tile(pair.lower)) - range.lowest).matrix();
    const Cells cells{tile.cells.row - tile.row, tile.cells.column - tile.column, tile.cells.rows, tile.cells.columns};
    for (Index row = std::max<Index>(cells.row, 1); row < cells.row + cells.rows; ++row) {
      const double* at = &heights(row, 0);
      mark_grid_minima(at - work.outerStride(), at, at + work.outerStride(), tile.columns, deepest, marks.data());
      for (Index i = std::max<Index>(cells.column, 1); i < cells.column + cells.columns; ++i) {
        if (marks[static_cast<std::size_t>(i)] != 0) {
          points.push_back({tile.row + row, tile.column + i, at[i]});
        }
      }
    }
    natural_bicubic(spline);
    const std::vector<Minimum> found = minima(spline, cells, deepest, checkpoint);
    if (found.empty()) {
      continue;
    }
    heights = (of_tile(pair.lower) - offset).matrix();
    natural_bicubic(spline);
    for (const Minimum& one : found) {
      places.push_back({one, bicubic_at(spline, one.row, one.column, one.u, one.v)});
      if (level_upper) {
        // The slope of both is that of the upper body: exactly none, so that no contact opposes by round-off.
        places.back().lower.x = 0.0;
        places.back().lower.y = 0.0;
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

  ArealCandidates result{{}, {}, {}, deepest, pair.spacing, columns};
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
    const bool summits = is_summit(below.xx, below.xy, below.yy, -1.0) &&
                         is_summit(below.xx + gap.xx, below.xy + gap.xy, below.yy + gap.yy, 1.0);
    if (curvature == Curvature::signed_ || summits) {
      add_candidate(pair, place, offset, result.all);
    }
  }
  return result;
}

std::vector<Contact> contacts(const ArealCandidates& found, double approach, const Law& law, const Vector2& direction) {
  check(found, Values(&approach, 1), law);
  check(direction);
  std::vector<Contact> result;
  const auto with = [&](const auto& one_law) {
    for (const ArealCandidate& one : found.all) {
      const double overlap = one.overlap(approach);
      if (!(overlap > 0.0) || approach > one.farthest) {
        continue;
      }
      const auto [force, area] = carried(one_law, one, overlap);
      // What yields spreads in proportion.
      const double spread = area / elastic_area(one.ellipse, overlap);
      result.push_back(
          {one.row * found.columns + one.column, one.position - 0.5 * overlap * one.normal, one.normal,
           tangent(one.normal, direction), one.radii,
           Vector2(std::sqrt(one.ellipse.major * overlap * spread), std::sqrt(one.ellipse.minor * overlap * spread)),
           overlap, force, area, opposes(one.normal, direction)});
    }
  };
  std::visit(with, law);
  return result;
}

std::vector<ArealSums> press(const ArealCandidates& found, Values approaches, const Law& law,
                             std::span<const Vector2> directions, Sliding sliding, const Checkpoint& checkpoint) {
  check(found, approaches, law);
  if (directions.empty()) {
    fail("direction is empty, at least one is needed");
  }
  for (const Vector2& direction : directions) {
    check(direction);
  }
  const std::size_t steps = approaches.size();
  const double widest = found.spacing.maxCoeff();
  const std::vector<std::size_t> overlapping = first_overlaps(found.all, approaches, checkpoint);
  std::vector<ArealSums> common(steps);  // what all directions share
  std::vector<double> sums(directions.size() * (of_force + of_area) * steps, 0.0);
  std::vector<double> force(steps);
  std::vector<double> area(steps);
  const auto with = [&](const auto& one_law) {
    for (std::size_t i = 0; i < found.all.size(); ++i) {
      checkpoint();
      const ArealCandidate& one = found.all[i];
      const auto [begin, end] = steps_of(one, approaches);
      const double radius = one.radii.mean();
      for (std::size_t k = begin; k < end; ++k) {
        const double overlap = one.overlap(approaches[k]);
        const ForceArea has = carried(one_law, one, overlap);
        force[k] = has.force;
        area[k] = has.area;
        const double load = has.force * one.normal.z();
        const double relative_overlap = overlap / radius;
        ArealSums& sum = common[k];
        sum.contact_count += 1;
        sum.contact_area += has.area;
        sum.normal_elastic += load;
        sum.overlap_load += load * relative_overlap;
        sum.load_beyond_hertz += relative_overlap > hertz_limit ? load : 0.0;
        sum.load_below_grid += radius < widest ? load : 0.0;
        sum.load_overlapping += k >= overlapping[i] ? load : 0.0;
      }
      for (std::size_t k = std::max(begin, end); k < steps; ++k) {
        common[k].crossed_count += 1;
      }
      for (std::size_t d = 0; begin < end && d < directions.size(); ++d) {
        if (sliding == Sliding::all || opposes(one.normal, directions[d])) {
          const Directed factors = directed(one.normal, directions[d]);
          accumulate(factors.data(), force.data(), area.data(), begin, end, steps,
                     sums.data() + d * (of_force + of_area) * steps);
        }
      }
    }
  };
  std::visit(with, law);
  const auto within = [](const std::vector<double>& gaps, double approach) {
    return std::upper_bound(gaps.begin(), gaps.end(), approach) - gaps.begin();
  };
  for (std::size_t k = 0; k < steps; ++k) {
    common[k].grid_minimum_count = within(found.grid_minima, approaches[k]);
    common[k].unanswered_count = within(found.unanswered, approaches[k]);
  }
  std::vector<ArealSums> result;
  result.reserve(directions.size() * steps);
  for (std::size_t d = 0; d < directions.size(); ++d) {
    const auto sum = [&](std::size_t m, std::size_t k) { return sums[(d * (of_force + of_area) + m) * steps + k]; };
    for (std::size_t k = 0; k < steps; ++k) {
      ArealSums row = common[k];
      row.tangential_elastic = sum(0, k);
      row.lateral_elastic = sum(1, k);
      row.normal_frictional = sum(2, k);
      row.tangential_frictional = sum(3, k);
      row.lateral_frictional = sum(4, k);
      row.normal_adhesive = sum(5, k);
      row.tangential_adhesive = sum(6, k);
      row.lateral_adhesive = sum(7, k);
      result.push_back(row);
    }
  }
  return result;
}

std::vector<ArealSums> press(const ArealCandidates& found, Values approaches, const ContactModel& model,
                             const Checkpoint& checkpoint) {
  return press(found, approaches, model.law, std::span(&model.direction, 1), model.sliding, checkpoint);
}

}  // namespace stiction
