#include "stiction/contact_statistics.hpp"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <memory>
#include <numeric>
#include <stdexcept>
#include <utility>

namespace stiction {
namespace {

double sum(Values values) { return std::accumulate(values.begin(), values.end(), 0.0); }

std::vector<double> sample_quantiles(Values values, Values probabilities) {
  std::vector<double> sorted(values.begin(), values.end());
  std::sort(sorted.begin(), sorted.end());
  std::vector<double> quantiles;
  quantiles.reserve(probabilities.size());
  for (const double probability : probabilities) {
    const double position = probability * static_cast<double>(sorted.size() - 1);
    const auto lower = static_cast<std::size_t>(position);
    const double low = sorted[lower];
    const double high = sorted[std::min(lower + 1, sorted.size() - 1)];
    const double fraction = position - static_cast<double>(lower);
    quantiles.push_back(fraction < 0.5 ? low + (high - low) * fraction : high - (high - low) * (1 - fraction));
  }
  return quantiles;
}

std::vector<double> weighted_quantiles(Values values, Values weights, Values probabilities) {
  std::vector<std::pair<double, double>> sorted(values.size());
  for (std::size_t i = 0; i < values.size(); ++i) {
    sorted[i] = {values[i], weights[i]};
  }
  std::sort(sorted.begin(), sorted.end());
  const double total = sum(weights);
  std::vector<double> quantiles;
  quantiles.reserve(probabilities.size());
  std::size_t next = 0;
  double next_centre = sorted[0].second / 2 / total;  // cumulative fraction up to the centre of the next weight
  double previous_centre = 0.0;
  double cumulative = sorted[0].second;
  for (const double probability : probabilities) {
    while (next < sorted.size() && next_centre <= probability) {
      previous_centre = next_centre;
      if (++next < sorted.size()) {
        cumulative += sorted[next].second;
        next_centre = (cumulative - sorted[next].second / 2) / total;
      }
    }
    if (next == 0 || next == sorted.size()) {
      quantiles.push_back(sorted[next == 0 ? 0 : next - 1].first);
      continue;
    }
    const double slope = (sorted[next].first - sorted[next - 1].first) / (next_centre - previous_centre);
    quantiles.push_back(slope * (probability - previous_centre) + sorted[next - 1].first);
  }
  return quantiles;
}

void check_points(const ContactView& contact, std::size_t num_grid_points) {
  const std::size_t size = contact.points.size();
  if (contact.pressure.size() != size || contact.contact_fraction.size() != size || contact.patch.size() != size) {
    throw std::invalid_argument("patch_statistics: pressure, contact_fraction and patch must be as long as points");
  }
  for (const std::int64_t point : contact.points) {
    if (point < 0 || std::cmp_greater_equal(point, num_grid_points)) {
      throw std::invalid_argument("patch_statistics: points must be on the grid");
    }
  }
}

}  // namespace

ContactStatistics contact_statistics(const ContactTable& table, Values probabilities, double max_small_cells) {
  const std::size_t size = table.force.size();
  if (table.area.size() != size || table.cells.size() != size || table.at_edge.size() != size ||
      table.weight.size() != table.pressure.size()) {
    throw std::invalid_argument(
        "contact_statistics: area, cells and at_edge must be as long as force, and weight as long as pressure");
  }
  if (size == 0 || table.pressure.empty()) {
    throw std::invalid_argument("contact_statistics: there must be at least one contact and one pressure");
  }
  if (!std::is_sorted(probabilities.begin(), probabilities.end())) {
    throw std::invalid_argument("contact_statistics: probabilities must be in increasing order");
  }
  double at_edge = 0.0;
  double on_small = 0.0;
  for (std::size_t i = 0; i < size; ++i) {
    at_edge += table.at_edge[i] ? table.force[i] : 0.0;
    on_small += table.cells[i] <= max_small_cells ? table.force[i] : 0.0;
  }
  const double total = sum(table.force);
  return {*std::max_element(table.force.begin(), table.force.end()) / total, at_edge / total, on_small / total,
          sample_quantiles(table.area, probabilities), weighted_quantiles(table.pressure, table.weight, probabilities)};
}

ContactStatistics patch_statistics(const ContactView& contact, const Grid& grid, Values probabilities,
                                   double max_small_cells) {
  check_points(contact, grid.size());
  const double cell_area = grid.spacing_x * grid.spacing_y;
  const auto count = static_cast<std::size_t>(
      contact.patch.empty() ? 0 : *std::max_element(contact.patch.begin(), contact.patch.end()));
  std::vector<double> force(count, 0.0);
  std::vector<double> area(count, 0.0);
  std::vector<double> cells(count, 0.0);
  const auto at_edge = std::make_unique<bool[]>(count);
  for (std::size_t i = 0; i < contact.points.size(); ++i) {
    if (contact.patch[i] < 1) {
      throw std::invalid_argument("patch_statistics: patch must be at least 1");
    }
    const auto patch = static_cast<std::size_t>(contact.patch[i] - 1);
    const std::size_t row = static_cast<std::size_t>(contact.points[i]) / grid.columns;
    const std::size_t column = static_cast<std::size_t>(contact.points[i]) % grid.columns;
    force[patch] += contact.pressure[i];
    area[patch] += contact.contact_fraction[i];
    cells[patch] += 1.0;
    at_edge[patch] = at_edge[patch] || column == 0 || column + 1 == grid.columns ||
                     (!grid.line && (row == 0 || row + 1 == grid.rows));
  }
  for (std::size_t patch = 0; patch < count; ++patch) {
    force[patch] *= cell_area;
    area[patch] *= cell_area;
  }
  const std::vector<double> weight(contact.pressure.size(), 1.0);
  return contact_statistics({force, area, cells, {at_edge.get(), count}, contact.pressure, weight}, probabilities,
                            max_small_cells);
}

double load_fraction_on_marked_points(const ContactView& contact, std::span<const bool> marks) {
  check_points(contact, marks.size());
  double marked = 0.0;
  for (std::size_t i = 0; i < contact.points.size(); ++i) {
    marked += marks[static_cast<std::size_t>(contact.points[i])] ? contact.pressure[i] : 0.0;
  }
  return marked / sum(contact.pressure);
}

}  // namespace stiction
