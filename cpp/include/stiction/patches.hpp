// Connected patches of pressures on a grid, and the sums over each of them that friction is made of.
#pragma once

#include "stiction/array.hpp"
#include "stiction/elastic_kernel.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace stiction {

/// The points of a grid under pressure, in their order.
struct Patches {
  std::vector<std::int64_t> points;  ///< their places on the grid
  std::vector<double> pressure;      ///< [GPa]
  std::vector<double> share;         ///< of the point's cell that is in contact
  std::vector<std::int32_t> patch;   ///< from 1 on, by the first point of each
  std::int32_t count = 0;            ///< of patches
};

/// Points are connected with all their neighbours, on areas eight, and over the edges where the grid is periodic. A
/// cell is in contact but for 0.19 of it at each open side on lines and (π - 1 + ln 2)/24 on areas, and not less than
/// its pressure over the hardness [GPa], which may be infinite; the edge of a grid is no open side. Yastrebov, Anciaux
/// & Molinari, Tribology International 114 (2017) 161. Throws std::invalid_argument for another number of pressures.
Patches patches_of(Values pressure, const Grid& grid, double hardness);

/// Of each patch; of each direction and of it.
struct PatchSums {
  std::vector<double> force;         ///< Σ F n_z [mN]
  std::vector<double> area;          ///< along the interface [µm²]
  std::vector<double> leaning;       ///< -Σ F s·n [mN]
  std::vector<double> upward;        ///< Σ F t_z [mN]
  std::vector<double> forward;       ///< -Σ F s·t [mN]
  std::vector<double> upward_area;   ///< Σ A t_z [µm²]
  std::vector<double> forward_area;  ///< -Σ A s·t [µm²]
  double steepness = 0.0;            ///< root-mean-square slope, weighted with the force
};

/// Sums over points: forces [mN] and shares of the ground plan [µm²], slopes along y (none on lines) and x of the
/// deformed interface there, patches from 1 on, and horizontal unit vectors (x, y) of the directions. Throws
/// std::invalid_argument if lengths differ or a patch is below 1.
PatchSums patch_sums(Values force, Values area, Values slope_y, Values slope_x, std::span<const std::int32_t> patch,
                     std::span<const std::array<double, 2>> directions);

}  // namespace stiction
