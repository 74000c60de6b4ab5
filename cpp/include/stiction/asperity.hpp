// Asperities of a profile: the osculating sphere at each point.
// Source: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 2 and 3.
#pragma once

#include "stiction/array.hpp"

#include <string_view>
#include <vector>

namespace stiction {

/// Body to which a profile belongs. The lower body lies below its profile, and the upper body lies above its profile.
enum class Side { lower, upper };

/// Return the Side that is named "lower" or "upper". Throws std::invalid_argument for any other name.
Side side(std::string_view name);

struct Asperity {
  Vector3 normal;  ///< unit normal that points out of the solid, (n_x, 0, n_z)
  double radius;   ///< Radius R [µm], positive where the solid is convex and infinite where the curvature is zero.

  /// Return the sphere centre relative to the point on the profile [µm]. The centre is not finite at zero curvature.
  Vector3 centre_offset() const { return {-radius * normal.x(), 0.0, -radius * normal.z()}; }
};

/// Compute the osculating sphere at a point of a profile with slope f' [-] and curvature f'' [1/µm].
/// With q = sqrt(1 + f'²), the lower surface has the normal (-f', 0, 1)/q and the radius R = -q³/f''.
/// The upper surface has the normal (f', 0, -1)/q and the radius R = q³/f''.
Asperity asperity(double slope, double curvature, Side side);

struct Asperities {
  std::vector<double> slope;      ///< slopes f' [-]
  std::vector<double> curvature;  ///< curvatures f'' [1/µm]
  std::vector<Vector3> normal;
  std::vector<double> radius;  ///< radii R [µm]
  /// Sphere centres [µm], in the coordinates in which point j of the profile is at (j Δx, 0, z_j).
  std::vector<Vector3> centre;
};

Asperities asperities(Values heights, double spacing, Side side);

}  // namespace stiction
