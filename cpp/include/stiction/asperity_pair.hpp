// Asperity pairs, and the contact point of an asperity pair at a given approach.
// Source: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 4 and 5.
//
// Positions are relative to the point of the lower surface at which the two asperities face each other.
// `gap` [µm] is the vertical distance between the facing points of two asperities at first contact of the surfaces.
#pragma once

#include "stiction/array.hpp"
#include "stiction/asperity.hpp"

#include <cmath>
#include <optional>
#include <variant>

namespace stiction {

/// Principal radii [µm] of the relative curvature. For two spheres, both equal R, with 1/R = 1/R_u + 1/R_l.
struct Radii {
  double major;  ///< the larger radius
  double minor;

  /// Return the geometric mean of the two principal radii. If both are equal, return this radius without round-off.
  double mean() const { return major == minor ? major : std::sqrt(major) * std::sqrt(minor); }
};

struct ContactPoint {
  Vector3 normal;  ///< unit vector from the lower to the upper surface
  Vector3 centre;  ///< position of the contact centre [µm]
  /// Overlap of the asperities along the normal [µm], zero or negative if the asperities are separated.
  double overlap;
};

/// `convex` requires both surfaces to be convex; `signed_` also allows a convex sphere in a larger concave sphere.
enum class Curvature { convex, signed_ };

/// Asperity pair of two spheres, at most one of which is concave (Eq. 4).
/// At the penetration p = approach - gap, the vector between the sphere centres is X = -p e_z + R_l n_l - R_u n_u.
/// The overlap is R_u + R_l minus the signed length of X, computed as ((R_u + R_l)² - X²) / (|R_u + R_l| + |X|).
/// On nearly flat surfaces, subtracting |X| from R_u + R_l would lose all correct digits, because both are large.
/// The contact centre is computed from the smaller sphere, because the larger radius would cause cancellation.
struct SpherePair {
  Vector3 separation;      ///< vector X at penetration p = 0 [µm]
  double gap;              ///< gap at first contact of the surfaces [µm]
  double radius_sum;       ///< |R_u + R_l| [µm]
  double sign;             ///< sign of R_u R_l
  double misalignment;     ///< R_u R_l |n_u + n_l|² [µm²]; zero if the slopes are equal
  double radius;           ///< effective radius [µm]
  Vector3 smaller_centre;  ///< centre of the smaller sphere, relative to its surface point [µm]
  double smaller_radius;
  bool smaller_is_lower;

  ContactPoint contact_at(double approach) const;
  bool is_separated(double approach) const;
  /// Return (R_u + R_l)² - X² [µm²], the numerator of the overlap, multiplied by the sign of R_u R_l.
  double overlap_numerator(double penetration) const {
    return sign * (misalignment + penetration * (2.0 * separation.z() - penetration));
  }
};

/// Pair of a sphere and a flat, which is the limit of a sphere of infinite radius.
struct SphereOnFlat {
  Vector3 normal;  ///< normal of the flat, pointing upwards
  Vector3 centre;  ///< centre of the sphere, relative to its surface point [µm]
  bool sphere_is_lower;
  double gap;     ///< gap at first contact of the surfaces [µm]
  double radius;  ///< radius of the sphere [µm]

  ContactPoint contact_at(double approach) const;
  bool is_separated(double approach) const { return !(contact_at(approach).overlap > 0.0); }
};

using AsperityPair = std::variant<SpherePair, SphereOnFlat>;

/// Return the asperity pair of two spheres, or std::nullopt if spheres of the given curvatures cannot form a contact.
std::optional<SpherePair> sphere_pair(const Asperity& upper, const Asperity& lower, double gap, Curvature allowed);

/// Return the asperity pair of a sphere and a flat, or std::nullopt if the sphere's radius is not positive and finite.
std::optional<SphereOnFlat> sphere_on_flat(const Asperity& sphere, Side sphere_side, const Asperity& flat, double gap);

Radii radii(const AsperityPair& asperity_pair);

/// `crossed` means that the contact normal points downwards, because the sphere centres have passed each other.
enum class ContactClass { no_contact, crossed, contact };

/// In a contact, the asperities overlap, and the contact centre lies in [-half_cell, half_cell) along x (Eq. 5).
inline ContactClass classify(const ContactPoint& contact_point, double half_cell) {
  if (!(contact_point.overlap > 0.0 && contact_point.centre.x() >= -half_cell &&
        contact_point.centre.x() < half_cell)) {
    return ContactClass::no_contact;
  }
  return contact_point.normal.z() > 0.0 ? ContactClass::contact : ContactClass::crossed;
}

inline ContactPoint SpherePair::contact_at(double approach) const {
  const double penetration = approach - gap;
  const Vector3 x(separation.x(), separation.y(), separation.z() - penetration);
  const double distance = x.norm();
  const Vector3 normal = sign / distance * x;
  const double overlap = overlap_numerator(penetration) / (radius_sum + distance);
  const double depth = smaller_radius - 0.5 * overlap;
  if (smaller_is_lower) {
    return {normal, smaller_centre + depth * normal, overlap};
  }
  return {normal, smaller_centre - depth * normal - Vector3(0.0, 0.0, penetration), overlap};
}

inline bool SpherePair::is_separated(double approach) const { return !(overlap_numerator(approach - gap) > 0.0); }

inline ContactPoint SphereOnFlat::contact_at(double approach) const {
  const double penetration = approach - gap;
  const double overlap = radius + (sphere_is_lower ? 1.0 : -1.0) * centre.dot(normal) + penetration * normal.z();
  const double depth = radius - 0.5 * overlap;
  if (sphere_is_lower) {
    return {normal, centre + depth * normal, overlap};
  }
  return {normal, centre - depth * normal - Vector3(0.0, 0.0, penetration), overlap};
}

}  // namespace stiction
