#include "stiction/patches.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

// Distance by which pressure extends beyond the true contact at a side next to an unloaded cell, over the cell size.
// On profiles, Westergaard's solution for a sinusoid gives 0.38 ± 0.03 cells for both sides of a contact together.
constexpr double line_side_fraction = 0.19;
constexpr double area_side_fraction = (std::numbers::pi - 1 + std::numbers::ln2) / 24;

// Union-find structure. Each set is represented by its first point.
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

std::size_t count_patches(const ContactView& contact, std::size_t num_grid_points) {
  const std::size_t size = contact.points.size();
  if (contact.pressure.size() != size || contact.contact_fraction.size() != size || contact.patch.size() != size) {
    throw std::invalid_argument("patch_sums: pressure, contact_fraction and patch must be as long as points");
  }
  if (size == 0) {
    throw std::invalid_argument("patch_sums: a contact must have at least one point");
  }
  for (const std::int64_t point : contact.points) {
    if (point < 0 || std::cmp_greater_equal(point, num_grid_points)) {
      throw std::invalid_argument("patch_sums: points must be on the grid");
    }
  }
  const auto [lowest, highest] = std::minmax_element(contact.patch.begin(), contact.patch.end());
  if (*lowest < 1) {
    throw std::invalid_argument("patch_sums: patch must be at least 1");
  }
  return static_cast<std::size_t>(*highest);
}

}  // namespace

Patches patches_of(Values pressure, const Grid& grid, double hardness) {
  if (pressure.size() != grid.size()) {
    throw std::invalid_argument("patches_of: pressure must have as many elements as the grid has points");
  }
  Patches result;
  // `numbers` contains 1, 2, 3 and so on at points under pressure, and 0 at all other points.
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
  // Return the number of a point. Beyond an edge, it is 0 or, on a periodic grid, the number at the opposite edge.
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

PatchSums patch_sums(std::span<const ContactView> contacts, Values slope_y, Values slope_x, double cell_area,
                     std::span<const std::array<double, 2>> directions) {
  if (!slope_y.empty() && slope_y.size() != slope_x.size()) {
    throw std::invalid_argument("patch_sums: slope_y must be as long as slope_x");
  }
  PatchSums sums;
  std::size_t count = 0;
  for (const ContactView& contact : contacts) {
    sums.first_patch.push_back(static_cast<std::int64_t>(count));
    count += count_patches(contact, slope_x.size());
  }
  sums.force.resize(count);
  sums.area.resize(count);
  for (auto* values : {&sums.leaning, &sums.upward, &sums.forward, &sums.upward_area, &sums.forward_area}) {
    values->resize(directions.size() * count);
  }
  const auto along_y = [&](std::size_t point) { return slope_y.empty() ? 0.0 : slope_y[point]; };
  for (std::size_t index = 0; index < contacts.size(); ++index) {
    const ContactView& contact = contacts[index];
    const auto first = static_cast<std::size_t>(sums.first_patch[index]);
    double squares = 0.0;
    double total = 0.0;
    for (std::size_t i = 0; i < contact.points.size(); ++i) {
      const auto point = static_cast<std::size_t>(contact.points[i]);
      const std::size_t patch = first + static_cast<std::size_t>(contact.patch[i] - 1);
      const double force = contact.pressure[i] * cell_area;
      const double squared_slope = slope_x[point] * slope_x[point] + along_y(point) * along_y(point);
      sums.force[patch] += force;
      sums.area[patch] += contact.contact_fraction[i] * cell_area * std::sqrt(1 + squared_slope);
      squares += squared_slope * force;
      total += force;
    }
    sums.steepness.push_back(std::sqrt(squares / total));
    for (std::size_t direction = 0; direction < directions.size(); ++direction) {
      const auto [x, y] = directions[direction];
      for (std::size_t i = 0; i < contact.points.size(); ++i) {
        const auto point = static_cast<std::size_t>(contact.points[i]);
        const std::size_t at = direction * count + first + static_cast<std::size_t>(contact.patch[i] - 1);
        const double force = contact.pressure[i] * cell_area;
        const double area = contact.contact_fraction[i] * cell_area;
        const double rise = slope_x[point] * x + along_y(point) * y;  // -q s·n
        const double across = slope_x[point] * y - along_y(point) * x;
        // With q = sqrt(1 + slope²), `level` is q sqrt(1 - (s·n)²). The tangent is t = (-s + (s·n) n) q/level.
        // A force q F along t has the vertical component q F t_z = -F rise/level.
        const double level = std::sqrt(1 + across * across);
        const double upward = -rise / level;
        sums.leaning[at] += rise * force;
        sums.upward[at] += upward * force;
        sums.forward[at] += level * force;
        sums.upward_area[at] += upward * area;
        sums.forward_area[at] += level * area;
      }
    }
  }
  return sums;
}

}  // namespace stiction
