// Connected contact patches on a grid, and the sums over each patch that determine friction.
#pragma once

#include "stiction/elastic_kernel.hpp"
#include "stiction/values.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace stiction {

/// Grid points under pressure, in increasing order of their indices, and the contact patches that they form.
struct Patches {
  std::vector<std::int64_t> points;      ///< indices of the points on the grid
  std::vector<double> pressure;          ///< pressure at each point [GPa]
  std::vector<double> contact_fraction;  ///< contact fraction of the cell of each point
  /// Patch number of each point. Patches are numbered from 1, in the order of their first points.
  std::vector<std::int32_t> patch;
  std::int32_t count = 0;  ///< number of patches
};

/// Connect each grid point under pressure to its neighbours under pressure: up to 8 on maps, up to 2 on profiles.
/// On a periodic grid, points at opposite edges of the grid are neighbours, too.
/// A side of a grid cell under pressure is open if the adjacent cell is on the grid and carries no pressure.
/// Each open side reduces the contact fraction of the cell: by 0.19 on profiles, by (π - 1 + ln 2)/24 on maps.
/// Source: Yastrebov, Anciaux & Molinari, Tribology International 114 (2017) 161.
/// The contact fraction of a cell is at least pressure/hardness, both in GPa. The hardness may be infinite.
Patches patches_of(Values pressure, const Grid& grid, double hardness);

/// View of a contact, with the arrays of its `Patches`. ContactView does not own the arrays.
struct ContactView {
  std::span<const std::int64_t> points;
  Values pressure;
  Values contact_fraction;
  std::span<const std::int32_t> patch;
};

/// Sums over the points of each contact patch. The patches of all contacts follow one another in one array.
/// Sums that depend on the direction of motion are matrices of shape (directions, patches).
struct PatchSums {
  std::vector<double> force;              ///< Σ F n_z [mN]
  std::vector<double> area;               ///< contact area along the deformed interface [µm²]
  std::vector<double> leaning;            ///< -Σ F s·n [mN]
  std::vector<double> upward;             ///< Σ F t_z [mN]
  std::vector<double> forward;            ///< -Σ F s·t [mN]
  std::vector<double> upward_area;        ///< Σ A t_z [µm²]
  std::vector<double> forward_area;       ///< -Σ A s·t [µm²]
  std::vector<double> steepness;          ///< root-mean-square slope of each contact, weighted by the force
  std::vector<std::int64_t> first_patch;  ///< index of the first patch of each contact
};

/// `slope_y` and `slope_x` are the slopes of the deformed interface on the grid; `slope_y` is empty for profiles.
/// `cell_area` is the area of a grid cell [µm²]. Directions are horizontal unit vectors (x, y).
/// Throws std::invalid_argument if arrays differ in length, a contact is empty, or a point or patch number is invalid.
PatchSums patch_sums(std::span<const ContactView> contacts, Values slope_y, Values slope_x, double cell_area,
                     std::span<const std::array<double, 2>> directions);

}  // namespace stiction
