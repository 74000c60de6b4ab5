// Contact laws: what one asperity contact carries.
//
// A law is one struct: its parameters as members, its name and the list of the parameters, what it carries, and the
// patch on which it does. It becomes one of the library's by its name in `Law`, below; all else follows from these.
#pragma once

#include "stiction/array.hpp"
#include "stiction/encounter.hpp"

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
  double force;  ///< [mN]
  double area;   ///< [µm²]
};

/// A number that a law has: finite, and between `low` and `high`, at which it may be if `ends` says so.
template <class L>
struct Parameter {
  std::string_view name;
  std::string_view unit;
  double L::* member;
  double low = 0.0;
  double high = std::numeric_limits<double>::infinity();
  bool ends = false;
};

/// Two elastic spheres: F = 4/3 E* R^(1/2) overlap^(3/2), A = π R overlap.
/// Hertz 1882; Johnson, Contact Mechanics (1985), eqs. 4.22-4.24. Exact within a << R.
struct HertzSphere {
  double effective_modulus;  ///< E* [GPa] > 0

  static constexpr std::string_view name = "hertz-sphere";
  static constexpr auto parameters() {
    return std::array{Parameter<HertzSphere>{"effective_modulus", "GPa", &HertzSphere::effective_modulus}};
  }
  ForceArea operator()(double overlap, const Radii& radii) const;
  Vector2 semi_axes(double overlap, const Radii& radii) const;
};

/// Two elastic parallel cylinders of a width w: F = π/4 E* overlap w, A = 2 w (R overlap)^(1/2), overlap being that of
/// the undeformed circles, a²/R. Johnson, Contact Mechanics (1985), eq. 4.45 with 2a the width of contact. Exact within
/// a << R for the force on a given half-width; the far approach of line contacts has no finite value.
struct HertzCylinder {
  double effective_modulus;  ///< E* [GPa] > 0
  double width;              ///< w [µm] > 0, along the cylinders

  static constexpr std::string_view name = "hertz-cylinder";
  static constexpr auto parameters() {
    return std::array{Parameter<HertzCylinder>{"effective_modulus", "GPa", &HertzCylinder::effective_modulus},
                      Parameter<HertzCylinder>{"width", "µm", &HertzCylinder::width}};
  }
  ForceArea operator()(double overlap, const Radii& radii) const;
  Vector2 semi_axes(double overlap, const Radii& radii) const;
};

/// A sphere that yields: elastic, perfectly plastic.
/// Jackson & Green, J. Tribol. 127 (2005) 343, eqs. for the critical interference and for contact above 1.9 times it;
/// below, Hertz. Fitted to finite elements up to a contact radius of 0.41 R; at the transition the load jumps by less
/// than 1 %.
struct JacksonGreen {
  double effective_modulus;  ///< E* [GPa] > 0
  double yield_strength;     ///< S_y [GPa], of the softer body, above 0 and below E*/10
  double poisson_ratio;      ///< of that body, from 0 to 0.5

  static constexpr std::string_view name = "jackson-green";
  static constexpr auto parameters() {
    return std::array{Parameter<JacksonGreen>{"effective_modulus", "GPa", &JacksonGreen::effective_modulus},
                      Parameter<JacksonGreen>{"yield_strength", "GPa", &JacksonGreen::yield_strength},
                      Parameter<JacksonGreen>{"poisson_ratio", "", &JacksonGreen::poisson_ratio, 0.0, 0.5, true}};
  }
  ForceArea operator()(double overlap, const Radii& radii) const;
  Vector2 semi_axes(double overlap, const Radii& radii) const;
  void check() const;  ///< what its parameters must be beside each other
};

/// Every law of the library. A member of one that is called gets an overlap [µm] > 0 and the principal radii [µm] > 0
/// of two asperities; these three take them for spheres, whose radii are equal.
using Law = std::variant<HertzSphere, HertzCylinder, JacksonGreen>;

/// A law by its name and all of its parameters by theirs. Throws std::invalid_argument naming what is unknown, missing
/// or out of its range.
Law law(std::string_view name, const std::map<std::string, double>& parameters);

/// Throws std::invalid_argument naming a parameter that is out of its range.
void check(const Law& law);

// Here, because it is called at every contact and every approach: out of line it costs 6 % of all.
inline ForceArea HertzSphere::operator()(double overlap, const Radii& radii) const {
  const double radius = radii.mean();
  return {4.0 / 3.0 * effective_modulus * std::sqrt(radius * overlap) * overlap, std::numbers::pi * radius * overlap};
}

}  // namespace stiction
