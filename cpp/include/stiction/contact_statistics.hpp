// Statistics of the contacts between two bodies: load fractions, and quantiles of contact area and pressure.
#pragma once

#include "stiction/elastic_kernel.hpp"
#include "stiction/patches.hpp"
#include "stiction/values.hpp"

#include <cstddef>
#include <span>
#include <vector>

namespace stiction {

struct ContactTable {
  Values force;                   ///< normal force on each contact [mN]
  Values area;                    ///< projected area of each contact [µm²]
  Values cells;                   ///< number of grid cells that each contact covers
  std::span<const bool> at_edge;  ///< true for each contact that reaches the edge of the grid
  Values pressure;                ///< contact pressures [GPa] at which the distribution of the pressure is given
  Values weight;                  ///< weight of each pressure, proportional to the area with this pressure
};

/// Statistics of the contacts at one load. Load fractions are fractions of the load on all contacts together.
struct ContactStatistics {
  double fraction_on_largest = 0.0;        ///< load fraction on the contact with the largest force
  double fraction_at_edge = 0.0;           ///< load fraction on contacts that reach the edge of the grid
  double fraction_on_small = 0.0;          ///< load fraction on contacts with few cells
  std::vector<double> area_quantiles;      ///< quantiles of the contact area [µm²]
  std::vector<double> pressure_quantiles;  ///< quantiles of the weighted contact pressure [GPa]
};

/// `probabilities` are the probabilities of the quantiles. Small contacts cover at most `max_small_cells` grid cells.
/// A pressure p is the quantile at (weight of all smaller pressures + half the weight of p) / (total weight).
/// Throws std::invalid_argument for an empty table, arrays of different lengths, or decreasing `probabilities`.
ContactStatistics contact_statistics(const ContactTable& table, Values probabilities, double max_small_cells);

/// Throws std::invalid_argument in the same cases as `contact_statistics`, and if a point is not on the grid.
ContactStatistics patch_statistics(const ContactView& contact, const Grid& grid, Values probabilities,
                                   double max_small_cells);

/// Return the fraction of the load on a contact that acts on marked grid points.
/// Throws std::invalid_argument if a point of the contact is not on the grid.
double load_fraction_on_marked_points(const ContactView& contact, std::span<const bool> marks);

}  // namespace stiction
