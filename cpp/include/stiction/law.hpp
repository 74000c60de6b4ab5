// Contact laws: normal force and area of one asperity contact.
//
// To make a new law available everywhere, add its struct to the variant `Law`.
#pragma once

#include "stiction/array.hpp"
#include "stiction/asperity_pair.hpp"

#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <string>
#include <string_view>
#include <variant>

namespace stiction {

struct ForceArea {
  double force;  ///< normal force [mN]
  double area;   ///< contact area [µm²]
};

/// Parameter of a law. It must be finite and between `low` and `high`, or equal to one of them if `inclusive` is true.
template <class L>
struct Parameter {
  std::string_view name;
  std::string_view unit;
  double L::* member;
  double low = 0.0;
  double high = std::numeric_limits<double>::infinity();
  bool inclusive = false;
};

/// Two elastic spheres: F = 4/3 E* R^(1/2) overlap^(3/2), A = π R overlap.
/// Source: Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24. Hertz theory is exact in the limit a << R.
struct HertzSphere {
  double effective_modulus;  ///< E* [GPa] > 0

  static constexpr std::string_view name = "hertz-sphere";
  static constexpr auto parameters() {
    return std::array{Parameter<HertzSphere>{"effective_modulus", "GPa", &HertzSphere::effective_modulus}};
  }
  ForceArea operator()(double overlap, const Radii& radii) const;
  Vector2 semi_axes(double overlap, const Radii& radii) const;
};

/// Two elastic parallel cylinders of width w: F = π/4 E* overlap w, A = 2 w (R overlap)^(1/2).
/// The overlap of the undeformed cylinders is set to a²/R, where a is the half-width of the contact.
/// For a given half-width a << R, the force F is exact: Johnson, Contact Mechanics (1985), section 4.2(c).
/// The overlap is not the approach of distant points, which for a line contact grows without limit with their distance.
struct HertzCylinder {
  double effective_modulus;  ///< E* [GPa] > 0
  double width;              ///< width w [µm] > 0 along the cylinders

  static constexpr std::string_view name = "hertz-cylinder";
  static constexpr auto parameters() {
    return std::array{Parameter<HertzCylinder>{"effective_modulus", "GPa", &HertzCylinder::effective_modulus},
                      Parameter<HertzCylinder>{"width", "µm", &HertzCylinder::width}};
  }
  ForceArea operator()(double overlap, const Radii& radii) const;
  Vector2 semi_axes(double overlap, const Radii& radii) const;
};

/// An elastic-perfectly plastic sphere: Jackson & Green, J. Tribol. 127 (2005) 343.
/// Hertz theory applies up to 1.9 times the critical interference; above, a fit to finite-element results applies.
/// The fit is valid up to a contact radius of 0.41 R. From Hertz theory to the fit, the load jumps by less than 1 %.
struct JacksonGreen {
  double effective_modulus;  ///< E* [GPa] > 0
  double yield_strength;     ///< yield strength S_y [GPa] of the softer body, above 0 and below E*/10
  double poisson_ratio;      ///< Poisson's ratio of the softer body, from 0 to 0.5

  static constexpr std::string_view name = "jackson-green";
  static constexpr auto parameters() {
    return std::array{Parameter<JacksonGreen>{"effective_modulus", "GPa", &JacksonGreen::effective_modulus},
                      Parameter<JacksonGreen>{"yield_strength", "GPa", &JacksonGreen::yield_strength},
                      Parameter<JacksonGreen>{"poisson_ratio", "", &JacksonGreen::poisson_ratio, 0.0, 0.5, true}};
  }
  ForceArea operator()(double overlap, const Radii& radii) const;
  Vector2 semi_axes(double overlap, const Radii& radii) const;
  void check() const;
};

/// One of the contact laws of the library.
/// The call operator of a law computes force and area for an overlap [µm] > 0 and principal radii [µm] > 0.
/// All laws in this file use only the geometric mean of the two principal radii.
using Law = std::variant<HertzSphere, HertzCylinder, JacksonGreen>;

/// Throws std::invalid_argument with the name of an unknown, missing or invalid parameter.
Law law(std::string_view name, const std::map<std::string, double>& parameters);

/// Throws std::invalid_argument with the name of a parameter that is out of range.
void check(const Law& law);

// The call operator of HertzSphere is inline, because function calls for all contacts cost 6 % of the total time.
inline ForceArea HertzSphere::operator()(double overlap, const Radii& radii) const {
  const double radius = radii.mean();
  return {4.0 / 3.0 * effective_modulus * std::sqrt(radius * overlap) * overlap, std::numbers::pi * radius * overlap};
}

}  // namespace stiction
