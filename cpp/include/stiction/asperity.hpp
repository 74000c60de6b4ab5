// A point of a rough profile as a sphere: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 2 and 3.
#pragma once

#include "stiction/array.hpp"

#include <string_view>
#include <vector>

namespace stiction {

/// Which body a profile bounds: `lower` is solid below it, `upper` solid above it.
enum class Side { lower, upper };

/// By the words of results: "lower", "upper". Throws std::invalid_argument for another.
Side side(std::string_view word);

/// The osculating sphere of a profile at one point.
struct Asperity {
  Vector3 normal;  ///< unit vector out of the solid, (n_x, 0, n_z)
  double radius;   ///< R [µm], positive where the solid is convex; infinite where the curvature is zero

  /// Sphere centre relative to the point on the profile [µm]; not finite where the radius is not.
  Vector3 centre_offset() const { return {-radius * normal.x(), 0.0, -radius * normal.z()}; }
};

/// slope f' [-], curvature f'' [1/µm]. With q = sqrt(1 + f'²): normal (-f', 0, 1)/q and R = -q³/f'' for the lower body,
/// both negated for the upper one.
Asperity asperity(double slope, double curvature, Side side);

/// The asperity at every point of a profile of heights [µm], spacing [µm] > 0, and the spline it came from.
struct Asperities {
  std::vector<double> slope;      ///< f' [-]
  std::vector<double> curvature;  ///< f'' [1/µm]
  std::vector<Vector3> normal;    ///< [-]
  std::vector<double> radius;     ///< R [µm]
  std::vector<Vector3> centre;    ///< [µm], point j of the profile lying at (j Δx, 0, z_j)
};

Asperities asperities(Values heights, double spacing, Side side);

}  // namespace stiction
