// Two asperities that face each other, and how they touch at an approach: Hanaor, Gan & Einav, Tribol. Int. 93 (2016)
// 229, Eqs. 4 and 5.
//
// Every kind of encounter has a member `at(approach)`, and `is_apart(approach)` for what needs no more; all that comes
// after it asks for nothing else. Positions are relative to the point of the lower body at which the asperities face
// each other. The approach [µm] is the displacement of the upper body towards the lower one since first touch of the
// bodies; `gap` [µm], of the two points at zero approach, is measured from the same.
#pragma once

#include "stiction/array.hpp"
#include "stiction/asperity.hpp"

#include <cmath>
#include <optional>
#include <variant>

namespace stiction {

/// The principal radii [µm] of the relative curvature of two bodies at a point. Of two spheres both are the effective
/// radius, 1/R = 1/R_u + 1/R_l.
struct Radii {
  double major;  ///< the larger
  double minor;

  /// Of the sphere with the same product of curvatures. Not by a root where both are equal: a sphere keeps its radius.
  double mean() const { return major == minor ? major : std::sqrt(major) * std::sqrt(minor); }
};

struct Touch {
  Vector3 normal;  ///< unit vector from the lower to the upper body
  Vector3 centre;  ///< of the contact [µm]
  double overlap;  ///< [µm], along the normal; not positive where the asperities are apart
};

/// Which pairs of curvatures may touch: `convex` both bodies convex, `signed_` also a ball in a wider cup.
enum class Curvature { convex, signed_ };

/// Two spheres, at most one of them concave (Eq. 4). With p = δ - gap, by how much the points of the bodies have passed
/// each other, X = -p e_z + R_l n_l - R_u n_u lies between the centres. The overlap, R_u + R_l less the signed length
/// of X, is written without the difference of two large numbers that it is where a body is nearly flat, as
/// ((R_u + R_l)² - X²) / (|R_u + R_l| + |X|), and the centre is measured from the smaller sphere.
struct SpherePair {
  Vector3 apart;   ///< X at p = 0 [µm]
  double gap;      ///< [µm]
  double reach;    ///< |R_u + R_l| [µm]
  double sign;     ///< of R_u R_l
  double lateral;  ///< R_u R_l |n_u + n_l|² [µm²], which is zero where the slopes are equal
  double radius;   ///< effective [µm]
  Vector3 pole;    ///< centre of the smaller sphere, relative to its own point [µm]
  double pole_radius;
  bool pole_below;  ///< the smaller sphere is the lower one

  Touch at(double approach) const;
  bool is_apart(double approach) const;  ///< at(approach).overlap <= 0, without a division or a root
  double overlap_numerator(double passed) const { return sign * (lateral + passed * (2.0 * apart.z() - passed)); }
};

/// A sphere and a straight body: the limit of an infinite radius, in which the normal is the straight one's own.
struct SphereOnStraight {
  Vector3 normal;  ///< of the straight body, pointing upwards
  Vector3 centre;  ///< of the sphere, relative to its own point [µm]
  bool below;      ///< the sphere is below the straight body
  double gap;      ///< [µm]
  double radius;   ///< [µm]

  Touch at(double approach) const;
  bool is_apart(double approach) const { return !(at(approach).overlap > 0.0); }
};

using Encounter = std::variant<SpherePair, SphereOnStraight>;

/// None where rule 3 forbids it: the effective radius must be positive and finite, and the curvatures as allowed.
std::optional<SpherePair> sphere_pair(const Asperity& upper, const Asperity& lower, double gap, Curvature allowed);

/// None where the sphere is not convex.
std::optional<SphereOnStraight> sphere_on_straight(const Asperity& sphere, Side side_of_sphere,
                                                   const Asperity& straight, double gap);

/// Radii of an encounter of spheres.
Radii radii(const Encounter& encounter);

/// Rules 1, 2 and 4. A contact's centre lies in [-half_cell, half_cell) along x (Eq. 5; infinite: no such rule), and
/// the asperities overlap. `crossed` are those whose normal does not point upwards: the sphere centres have passed each
/// other.
enum class Verdict { no_contact, crossed, contact };

inline Verdict judge(const Touch& touch, double half_cell) {
  if (!(touch.overlap > 0.0 && touch.centre.x() >= -half_cell && touch.centre.x() < half_cell)) {
    return Verdict::no_contact;
  }
  return touch.normal.z() > 0.0 ? Verdict::contact : Verdict::crossed;
}

// ---- The kernels, inline because they are what a contact costs -----------------------------------------------------

inline Touch SpherePair::at(double approach) const {
  const double passed = approach - gap;
  const Vector3 x(apart.x(), apart.y(), apart.z() - passed);
  const double distance = x.norm();
  const Vector3 normal = sign / distance * x;
  const double overlap = overlap_numerator(passed) / (reach + distance);
  const double depth = pole_radius - 0.5 * overlap;
  if (pole_below) {
    return {normal, pole + depth * normal, overlap};
  }
  return {normal, pole - depth * normal - Vector3(0.0, 0.0, passed), overlap};
}

inline bool SpherePair::is_apart(double approach) const { return !(overlap_numerator(approach - gap) > 0.0); }

inline Touch SphereOnStraight::at(double approach) const {
  const double passed = approach - gap;
  // How far the sphere's pole rises above its own point, and the points have passed each other, along the normal.
  const double overlap = radius + (below ? 1.0 : -1.0) * centre.dot(normal) + passed * normal.z();
  const double depth = radius - 0.5 * overlap;
  if (below) {
    return {normal, centre + depth * normal, overlap};
  }
  return {normal, centre - depth * normal - Vector3(0.0, 0.0, passed), overlap};
}

}  // namespace stiction
