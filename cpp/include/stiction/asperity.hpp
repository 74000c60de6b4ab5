// A point of a rough profile as a sphere: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 2 and 3.
#pragma once

#include "stiction/array.hpp"

#include <vector>

namespace stiction {

/// Which body a profile bounds: `lower` is solid below it, `upper` solid above it.
enum class Side { lower, upper };

/// The osculating sphere of a profile at one point.
struct Asperity {
  Vector2 normal;  ///< unit vector out of the solid
  double radius;   ///< R [µm], positive where the solid is convex; infinite where the curvature is zero

  /// Sphere centre relative to the point on the profile [µm]; not finite where the radius is not.
  Vector2 centre_offset() const { return -radius * normal; }
};

/// slope f' [-], curvature f'' [1/µm]. With q = sqrt(1 + f'²): normal (-f', 1)/q and R = -q³/f'' for the lower body,
/// both negated for the upper one.
Asperity asperity(double slope, double curvature, Side side);

/// The asperity at every point of a profile of heights [µm], spacing [µm] > 0, and the spline it came from.
struct Asperities {
  std::vector<double> slope;      ///< f' [-]
  std::vector<double> curvature;  ///< f'' [1/µm]
  std::vector<Vector2> normal;    ///< [-]
  std::vector<double> radius;     ///< R [µm]
  std::vector<Vector2> centre;    ///< [µm], point j of the profile lying at (j Δx, y_j)
};

Asperities asperities(Values heights, double spacing, Side side);

}  // namespace stiction
