// An elliptic contact: two bodies that touch at a point where their relative curvature differs with direction.
#pragma once

namespace stiction {

/// What an elliptic contact has for each unit of overlap; all follows from it, for any overlap d [µm] > 0 and E* [GPa]:
/// semi-axes a = sqrt(major d), b = sqrt(minor d), area A = π sqrt(major minor) d, force F = 4/3 E* sqrt(stiff)
/// d^(3/2). Spheres have all three equal to R.
struct Ellipse {
  double major;  ///< a²/d [µm]
  double minor;  ///< b²/d [µm]
  double stiff;  ///< radius [µm] of the sphere that carries the same force at the same overlap
};

/// The contact of two elastic bodies with principal relative radii of curvature `longer` >= `shorter` > 0 [µm].
/// Hertz 1882; Johnson, Contact Mechanics (1985), section 4.2: with k = b/a, e² = 1 - k² and the complete elliptic
/// integrals K, E of modulus e, shorter/longer = k² (K - E) / (E - k² K), a² = 2 d longer (K - E) / (e² K) and
/// F = 2/3 π a d E*/K. To some 1e-15 for any radii whose ratio is a normal number. Throws std::invalid_argument.
Ellipse hertz_ellipse(double longer, double shorter);

}  // namespace stiction
