// Contact laws: what one asperity contact carries. A law is a small object with one function,
// (overlap [µm] > 0, effective radius [µm] > 0) -> (force [mN], area [µm²]); its parameters are its members.
#pragma once

#include <variant>

namespace stiction {

struct ForceArea {
  double force;  ///< [mN]
  double area;   ///< [µm²]
};

/// Two elastic spheres: F = 4/3 E* R^(1/2) overlap^(3/2), A = π R overlap.
/// Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24. Exact within a << R.
struct HertzSphere {
  double effective_modulus;  ///< E* [GPa] > 0

  ForceArea operator()(double overlap, double radius) const;
};

/// Two elastic parallel cylinders of a width w: F = π/4 E* overlap w, A = 2 w (R overlap)^(1/2), overlap being that of
/// the undeformed circles, a²/R. Johnson, Contact Mechanics (1985), eq. 4.45 with 2a the width of contact. Exact within
/// a << R for the force on a given half-width; the far approach of line contacts has no finite value.
struct HertzCylinder {
  double effective_modulus;  ///< E* [GPa] > 0
  double width;              ///< w [µm] > 0, along the cylinders

  ForceArea operator()(double overlap, double radius) const;
};

/// A sphere that yields: elastic, perfectly plastic.
/// Jackson & Green, J. Tribol. 127 (2005) 343, eqs. for the critical interference and for contact above 1.9 times it;
/// below, Hertz. Fitted to finite elements up to a contact radius of 0.41 R; at the transition the load jumps by less
/// than 1 %.
struct JacksonGreen {
  double effective_modulus;  ///< E* [GPa] > 0
  double yield_strength;     ///< S_y [GPa], of the softer body, above 0 and below E*/10
  double poisson_ratio;      ///< of that body, from 0 to 0.5

  ForceArea operator()(double overlap, double radius) const;
};

using Law = std::variant<HertzSphere, HertzCylinder, JacksonGreen>;

/// Throws std::invalid_argument naming a parameter that is out of its range.
void check(const Law& law);

}  // namespace stiction
