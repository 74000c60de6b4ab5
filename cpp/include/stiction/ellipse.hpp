// Elliptic Hertzian contact, for relative curvatures that depend on the direction.
#pragma once

namespace stiction {

/// For any overlap d [µm] > 0 and E* [GPa], the semi-axes are a = sqrt(major d) and b = sqrt(minor d).
/// The contact area is π a b, and the force at the overlap d is 4/3 E* sqrt(`force_radius`) d^(3/2).
/// For two spheres, `major`, `minor` and `force_radius` equal the effective radius R.
struct Ellipse {
  double major;         ///< a²/d [µm]
  double minor;         ///< b²/d [µm]
  double force_radius;  ///< radius [µm] of the sphere with the same force at the same overlap
};

/// Compute the contact ellipse for principal radii `longer` >= `shorter` > 0 [µm] of the relative curvature.
/// Sources: Hertz 1882; Johnson, Contact Mechanics (1985), section 4.2.
/// Let k = b/a and e² = 1 - k², and let K and E be the complete elliptic integrals of modulus e.
/// Hertz theory gives shorter/longer = k² (K - E) / (E - k² K), a² = 2 d longer (K - E) / (e² K), F = 2/3 π a d E*/K.
/// The relative error of `major`, `minor` and `force_radius` is about 1e-15, unless shorter/longer underflows.
Ellipse hertz_ellipse(double longer, double shorter);

}  // namespace stiction
