#include "stiction/patches.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>

namespace stiction {
namespace {

// Of a cell, by which points under pressure reach beyond the contact at each open side. On lines half of 0.38 +- 0.03
// points for each contact, measured on Westergaard's sinusoid.
constexpr double beyond_side_of_line = 0.19;
constexpr double beyond_side_of_area = (std::numbers::pi - 1 + std::numbers::ln2) / 24;

// Sets of points, each of which is named by its first one.
class Sets {
 public:
  explicit Sets(std::size_t count) : first_(count) {
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
    const std::size_t one = first(i);
    const std::size_t other = first(j);
    first_[std::max(one, other)] = static_cast<std::int32_t>(std::min(one, other));
  }

 private:
  std::vector<std::int32_t> first_;
};

}  // namespace

Patches patches_of(Values pressure, const Grid& grid, double hardness) {
  if (pressure.size() != grid.size()) {
    throw std::invalid_argument("patches_of: pressure must be on the grid");
  }
  Patches found;
  // The number of a point among those under pressure, from 1 on.
  std::vector<std::int32_t> number(pressure.size(), 0);
  for (std::size_t i = 0; i < pressure.size(); ++i) {
    if (pressure[i] != 0.0) {
      found.points.push_back(static_cast<std::int64_t>(i));
      found.pressure.push_back(pressure[i]);
      number[i] = static_cast<std::int32_t>(found.points.size());
    }
  }
  const auto rows = static_cast<std::int64_t>(grid.rows);
  const auto columns = static_cast<std::int64_t>(grid.columns);
  const double beyond_side = grid.line ? beyond_side_of_line : beyond_side_of_area;
  // Of a place beyond the edges: 0, or that of the other side.
  const auto at = [&](std::int64_t row, std::int64_t column) -> std::int32_t {
    if (row < 0 || row >= rows || column < 0 || column >= columns) {
      if (!grid.periodic) {
        return 0;
      }
      row = (row + rows) % rows;
      column = (column + columns) % columns;
    }
    return number[static_cast<std::size_t>(row * columns + column)];
  };
  Sets sets(found.points.size());
  found.share.reserve(found.points.size());
  for (std::size_t k = 0; k < found.points.size(); ++k) {
    const std::int64_t row = found.points[k] / columns;
    const std::int64_t column = found.points[k] % columns;
    for (std::int64_t down = grid.line ? 0 : -1; down <= (grid.line ? 0 : 1); ++down) {
      for (std::int64_t right = -1; right <= 1; ++right) {
        const std::int32_t other = at(row + down, column + right);
        if (other > 0 && static_cast<std::size_t>(other) <= k) {
          sets.unite(k, static_cast<std::size_t>(other - 1));
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
    found.share.push_back(std::max(1 - beyond_side * open, found.pressure[k] / hardness));
  }
  found.patch.resize(found.points.size());
  for (std::size_t k = 0; k < found.points.size(); ++k) {
    const std::size_t first = sets.first(k);
    found.patch[k] = first == k ? ++found.count : found.patch[first];
  }
  return found;
}

PatchSums patch_sums(Values force, Values area, Values slope_y, Values slope_x, std::span<const std::int32_t> patch,
                     std::span<const std::array<double, 2>> directions) {
  const std::size_t size = force.size();
  if (area.size() != size || slope_x.size() != size || patch.size() != size ||
      (!slope_y.empty() && slope_y.size() != size)) {
    throw std::invalid_argument("patch_sums: there must be as many areas, slopes and patches as forces");
  }
  std::int32_t last = 0;
  for (const std::int32_t one : patch) {
    if (one < 1) {
      throw std::invalid_argument("patch_sums: patches are numbered from 1 on");
    }
    last = std::max(last, one);
  }
  const auto count = static_cast<std::size_t>(last);
  PatchSums sums;
  sums.force.resize(count);
  sums.area.resize(count);
  for (auto* each : {&sums.leaning, &sums.upward, &sums.forward, &sums.upward_area, &sums.forward_area}) {
    each->resize(directions.size() * count);
  }
  const auto along_y = [&](std::size_t i) { return slope_y.empty() ? 0.0 : slope_y[i]; };
  double squares = 0.0;
  double total = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    const auto at = static_cast<std::size_t>(patch[i] - 1);
    const double steep = slope_x[i] * slope_x[i] + along_y(i) * along_y(i);
    sums.force[at] += force[i];
    sums.area[at] += area[i] * std::sqrt(1 + steep);
    squares += steep * force[i];
    total += force[i];
  }
  sums.steepness = std::sqrt(squares / total);
  for (std::size_t way = 0; way < directions.size(); ++way) {
    const auto [x, y] = directions[way];
    for (std::size_t i = 0; i < size; ++i) {
      const std::size_t at = way * count + static_cast<std::size_t>(patch[i] - 1);
      const double rise = slope_x[i] * x + along_y(i) * y;  // -q s·n
      const double across = slope_x[i] * y - along_y(i) * x;
      // t = -s + (s·n) n over its length, sqrt(1 - (s·n)²), which is level/q: F q t_z is -F rise/level.
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
