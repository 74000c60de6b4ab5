// Two rough profiles pressed together: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 4 to 7.
//
// Both profiles share one grid. The approach is the displacement of the upper body towards the lower one, measured from
// the first touch of grid points. A profile whose points lie on a line, to the round-off of their heights, is a convex
// body of infinite radius, with the line's normal.
#pragma once

#include "stiction/array.hpp"
#include "stiction/law.hpp"

#include <vector>

namespace stiction {

/// Where a contact is looked for.
/// cell (Eq. 5): at grid points, where the contact centre lies within half a spacing of the point.
/// gap_minimum: at the local minima of the splined gap, each found once for all approaches; does not depend on the grid
/// where the grid resolves the surfaces.
enum class Detection { cell, gap_minimum };

/// Which pairs of curvatures may touch: `convex` both bodies convex, `any` also a ball in a wider cup.
enum class Curvature { convex, any };

struct ContactModel {
  Law law;
  Detection detection = Detection::cell;
  Curvature curvature = Curvature::convex;
  int shear = +1;  ///< the upper body is about to move along +x or -x
};

/// One contact. Positions are in the frame of the lower profile.
struct Contact {
  Index index;      ///< grid point that owns it: its own (cell), or the one on its left (gap_minimum)
  Vector2 centre;   ///< [µm]
  Vector2 normal;   ///< unit vector from the lower to the upper body
  Vector2 tangent;  ///< unit vector of the friction on the upper body
  double radius;    ///< effective radius [µm]
  double overlap;   ///< [µm]
  double force;     ///< normal force [mN]
  double area;      ///< [µm²]
  bool opposing;    ///< its normal force opposes the motion
};

/// Load and area at each approach, split so that F_N and F_T follow for every mu0 and tau0:
/// F = elastic + mu0 frictional + tau0 adhesive. t is the tangent, σ the shear sign.
struct LoadSums {
  std::vector<Index> contact_count;
  std::vector<double> contact_area;           ///< Σ A               [µm²]
  std::vector<double> normal_elastic;         ///< Σ F n_z           [mN]
  std::vector<double> tangential_elastic;     ///< -σ Σ_opp F n_x    [mN]
  std::vector<double> normal_frictional;      ///< Σ_opp F t_z       [mN] per unit mu0
  std::vector<double> tangential_frictional;  ///< -σ Σ_opp F t_x    [mN] per unit mu0
  std::vector<double> normal_adhesive;        ///< Σ_opp A t_z       [mN] per GPa of tau0
  std::vector<double> tangential_adhesive;    ///< -σ Σ_opp A t_x    [mN] per GPa of tau0

  // How far the model is trusted. Shares are of Σ F n_z.
  std::vector<double> overlap_load;       ///< Σ F n_z overlap/R                       [mN]
  std::vector<double> load_beyond_hertz;  ///< Σ F n_z of contacts with overlap > R/10 [mN]
  std::vector<double> load_below_grid;    ///< Σ F n_z of contacts with R < Δx         [mN]
  std::vector<Index> crossed_count;       ///< would-be contacts refused because the sphere centres have crossed

  explicit LoadSums(std::size_t approaches);
};

/// Every contact at one approach [µm] >= 0, in the order of the grid.
/// Heights [µm] are finite, at least 4 and equally many; spacing [µm] > 0. Throws std::invalid_argument.
std::vector<Contact> contacts(Values upper, Values lower, double spacing, double approach, const ContactModel& model);

/// The sums at approaches [µm], which are >= 0 and strictly increasing. Otherwise as `contacts`.
LoadSums press(Values upper, Values lower, double spacing, Values approaches, const ContactModel& model);

}  // namespace stiction
