#include "stiction/patches.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

namespace stiction {
namespace {

// Fraction of a cell by which points under pressure extend beyond the true contact at each open side of a cell.
// On lines, the fraction is half of 0.38 ± 0.03 points per contact, from Westergaard's solution for a sinusoid.
constexpr double line_side_fraction = 0.19;
constexpr double area_side_fraction = (std::numbers::pi - 1 + std::numbers::ln2) / 24;

// Disjoint sets of points (union-find). Each set is represented by its first point.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : first_(count) {
    for (std::size_t i = 0; i < count; ++i) {
      first_[i] = static_cast<std::int32_t>(i);
    }
  }

  std::size_t first(std::size_t i) {
    auto at = static_cast<std::int32_t>(i);
    while (first_[static_cast<std::size_t>(at)] != at) {
      std::int32_t& next = first_[static_cast<std::size_t>(at)];
      at = next = first_[static_cast<std::size_t>(next)];
    }
    return static_cast<std::size_t>(at);
  }

  void unite(std::size_t i, std::size_t j) {
    const std::size_t first_i = first(i);
    const std::size_t first_j = first(j);
    first_[std::max(first_i, first_j)] = static_cast<std::int32_t>(std::min(first_i, first_j));
  }

 private:
  std::vector<std::int32_t> first_;
};

}  // namespace

Patches patches_of(Values pressure, const Grid& grid, double hardness) {
  if (pressure.size() != grid.size()) {
    throw std::invalid_argument("patches_of: pressure must have as many elements as the grid has points");
  }
  Patches result;
  // Number of a point among the points under pressure, counted from 1. Points without pressure have the number 0.
  std::vector<std::int32_t> numbers(pressure.size(), 0);
  for (std::size_t i = 0; i < pressure.size(); ++i) {
    if (pressure[i] != 0.0) {
      result.points.push_back(static_cast<std::int64_t>(i));
      result.pressure.push_back(pressure[i]);
      numbers[i] = static_cast<std::int32_t>(result.points.size());
    }
  }
  const auto rows = static_cast<std::int64_t>(grid.rows);
  const auto columns = static_cast<std::int64_t>(grid.columns);
  const double side_fraction = grid.line ? line_side_fraction : area_side_fraction;
  // Return the number of a point: 0 beyond an edge or, if the grid is periodic, the number at the opposite edge.
  const auto at = [&](std::int64_t row, std::int64_t column) -> std::int32_t {
    if (row < 0 || row >= rows || column < 0 || column >= columns) {
      if (!grid.periodic) {
        return 0;
      }
      row = (row + rows) % rows;
      column = (column + columns) % columns;
    }
    return numbers[static_cast<std::size_t>(row * columns + column)];
  };
  DisjointSets sets(result.points.size());
  result.contact_fraction.reserve(result.points.size());
  for (std::size_t k = 0; k < result.points.size(); ++k) {
    const std::int64_t row = result.points[k] / columns;
    const std::int64_t column = result.points[k] % columns;
    for (std::int64_t down = grid.line ? 0 : -1; down <= (grid.line ? 0 : 1); ++down) {
      for (std::int64_t right = -1; right <= 1; ++right) {
        const std::int32_t neighbour = at(row + down, column + right);
        if (neighbour > 0 && static_cast<std::size_t>(neighbour) <= k) {
          sets.unite(k, static_cast<std::size_t>(neighbour - 1));
        }
      }
    }
    const auto is_open = [&](std::int64_t down, std::int64_t right) {
      const std::int64_t y = row + down;
      const std::int64_t x = column + right;
      const bool is_beyond = y < 0 || y >= rows || x < 0 || x >= columns;
      return !(is_beyond && !grid.periodic) && at(y, x) == 0;
    };
    int open = static_cast<int>(is_open(0, -1)) + static_cast<int>(is_open(0, 1));
    if (!grid.line) {
      open += static_cast<int>(is_open(-1, 0)) + static_cast<int>(is_open(1, 0));
    }
    result.contact_fraction.push_back(std::max(1 - side_fraction * open, result.pressure[k] / hardness));
  }
  result.patch.resize(result.points.size());
  for (std::size_t k = 0; k < result.points.size(); ++k) {
    const std::size_t first = sets.first(k);
    result.patch[k] = first == k ? ++result.count : result.patch[first];
  }
  return result;
}

PatchSums patch_sums(Values force, Values area, Values slope_y, Values slope_x, std::span<const std::int32_t> patch,
                     std::span<const std::array<double, 2>> directions) {
  const std::size_t size = force.size();
  if (area.size() != size || slope_x.size() != size || patch.size() != size ||
      (!slope_y.empty() && slope_y.size() != size)) {
    throw std::invalid_argument("patch_sums: area, slope_y, slope_x and patch must be as long as force");
  }
  std::int32_t last = 0;
  for (const std::int32_t first_patch : patch) {
    if (first_patch < 1) {
      throw std::invalid_argument("patch_sums: patch must be at least 1");
    }
    last = std::max(last, first_patch);
  }
  const auto count = static_cast<std::size_t>(last);
  PatchSums sums;
  sums.force.resize(count);
  sums.area.resize(count);
  for (auto* values : {&sums.leaning, &sums.upward, &sums.forward, &sums.upward_area, &sums.forward_area}) {
    values->resize(directions.size() * count);
  }
  const auto along_y = [&](std::size_t i) { return slope_y.empty() ? 0.0 : slope_y[i]; };
  double squares = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const auto p = static_cast<std::size_t>(patch[i] - 1);
    const double squared_slope = slope_x[i] * slope_x[i] + along_y(i) * along_y(i);
    sums.force[p] += force[i];
    sums.area[p] += area[i] * std::sqrt(1 + squared_slope);
    squares += squared_slope * force[i];
    total += force[i];
  }
  sums.steepness = std::sqrt(squares / total);
  for (std::size_t direction = 0; direction < directions.size(); ++direction) {
    const auto [x, y] = directions[direction];
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t at = direction * count + static_cast<std::size_t>(patch[i] - 1);
      const double rise = slope_x[i] * x + along_y(i) * y;  // -q s·n
      const double across = slope_x[i] * y - along_y(i) * x;
      // The tangent t is (-s + (s·n) n) / sqrt(1 - (s·n)²). The square root equals level/q, so q F t_z = -F rise/level.
      const double level = std::sqrt(1 + across * across);
      const double upward = -rise / level;
      sums.leaning[at] += rise * force[i];
      sums.upward[at] += upward * force[i];
      sums.forward[at] += level * force[i];
      sums.upward_area[at] += upward * area[i];
      sums.forward_area[at] += level * area[i];
    }
  }
  return sums;
}

}  // namespace stiction
