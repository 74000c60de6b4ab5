// Contact laws: what one asperity contact carries. A law is a small object with one function,
// (overlap [µm], radius [µm]) -> (force [mN], area [µm²]); its parameters are its members.
#pragma once

#include <cmath>
#include <numbers>
#include <variant>

namespace stiction {

struct ForceArea {
  double force;  ///< [mN]
  double area;   ///< [µm²]
};

/// Two elastic spheres pressed together by `overlap` > 0; radius > 0 is the effective one, 1/R = 1/R_u + 1/R_l.
/// Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24. Exact within a << R.
struct HertzSphere {
  double effective_modulus;  ///< E* [GPa] > 0

  ForceArea operator()(double overlap, double radius) const {
    return {4.0 / 3.0 * effective_modulus * std::sqrt(radius * overlap) * overlap, std::numbers::pi * radius * overlap};
  }
};

using Law = std::variant<HertzSphere>;

}  // namespace stiction
