// Sums over contacts, from which the normal and tangential loads follow as linear functions of mu0 and tau0.
// Source: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 6 and 7 and section 2.5.
//
// The upper surface is about to move along a horizontal unit vector s.
// A contact with normal n opposes the motion if s·n < 0.
// A sliding contact transmits friction along the tangent t, which is the normalised vector -s + (s·n) n.
// A sliding contact also contributes the horizontal component of its normal force to the tangential load.
#pragma once

#include "stiction/array.hpp"
#include "stiction/asperity_pair.hpp"
#include "stiction/law.hpp"

#include <array>
#include <cmath>
#include <string_view>
#include <variant>

namespace stiction {

/// Contacts at which friction acts: all contacts, or only contacts whose slope opposes the motion, as in the paper.
enum class Sliding { opposing, all };

/// Return the sliding rule named "opposing" or "all". Throws std::invalid_argument for any other name.
Sliding sliding(std::string_view name);

/// The normal load and the tangential load are each computed as elastic + mu0 · frictional + tau0 · adhesive.
struct Sums {
  Index contact_count = 0;
  double contact_area = 0.0;           ///< Σ A                 [µm²]
  double normal_elastic = 0.0;         ///< Σ F n_z             [mN]
  double tangential_elastic = 0.0;     ///< -Σ_sliding F s·n   [mN]
  double normal_frictional = 0.0;      ///< Σ_sliding F t_z    [mN] per unit mu0
  double tangential_frictional = 0.0;  ///< -Σ_sliding F s·t   [mN] per unit mu0
  double normal_adhesive = 0.0;        ///< Σ_sliding A t_z    [mN] per GPa of tau0
  double tangential_adhesive = 0.0;    ///< -Σ_sliding A s·t   [mN] per GPa of tau0

  // Sums that test the assumptions of the model. R is the geometric mean of the principal radii of a contact.
  double overlap_load = 0.0;       ///< Σ F n_z overlap/R                       [mN]
  double load_beyond_hertz = 0.0;  ///< Σ F n_z of contacts with overlap > R/10 [mN]
  double load_below_grid = 0.0;    ///< Σ F n_z of contacts with R < Δx         [mN]
  Index crossed_count = 0;         ///< number of pairs rejected because their sphere centres have crossed

  /// The upper surface moves along `direction`, and `spacing` is the grid spacing Δx [µm].
  void add(const ContactPoint& contact_point, const Radii& radii, const ForceArea& force_area, const Vector2& direction,
           Sliding sliding, double spacing);

  /// Add the contributions of a contact that do not depend on the direction. Returns the normal load F n_z [mN].
  double add(const Vector3& normal, double overlap, double radius, const ForceArea& force_area, double spacing);
};

struct Quantity {
  std::string_view name;
  std::string_view unit;
  std::string_view description;
  std::variant<Index Sums::*, double Sums::*> member;
};

inline constexpr std::array quantities{
    Quantity{"contact_count", "1", "number of contacts", &Sums::contact_count},
    Quantity{"contact_area", "um^2", "true contact area", &Sums::contact_area},
    Quantity{"normal_elastic", "mN", "normal load of the elastic forces", &Sums::normal_elastic},
    Quantity{"tangential_elastic", "mN", "tangential load of the elastic forces of sliding contacts",
             &Sums::tangential_elastic},
    Quantity{"normal_frictional", "mN", "normal load per unit mu0", &Sums::normal_frictional},
    Quantity{"tangential_frictional", "mN", "tangential load per unit mu0", &Sums::tangential_frictional},
    Quantity{"normal_adhesive", "mN/GPa", "normal load per unit tau0", &Sums::normal_adhesive},
    Quantity{"tangential_adhesive", "mN/GPa", "tangential load per unit tau0", &Sums::tangential_adhesive},
    Quantity{"overlap_load", "mN", "normal load times overlap / radius", &Sums::overlap_load},
    Quantity{"load_beyond_hertz", "mN", "normal load of contacts with an overlap above a tenth of their radius",
             &Sums::load_beyond_hertz},
    Quantity{"load_below_grid", "mN", "normal load of contacts with a radius below the grid spacing",
             &Sums::load_below_grid},
    Quantity{"crossed_count", "1", "number of overlapping pairs rejected because their sphere centres have crossed",
             &Sums::crossed_count},
};

Vector3 tangent(const Vector3& normal, const Vector2& direction);

inline bool opposes(const Vector3& normal, const Vector2& direction) { return normal.head<2>().dot(direction) < 0.0; }

struct SlidingFactors {
  double push;  ///< -s·n
  double lift;  ///< t_z
  double drag;  ///< -s·t, the length of the part of n perpendicular to s
};

SlidingFactors sliding_factors(const Vector3& normal, const Vector2& direction);

/// Return the normal load F_N [mN], upwards on the upper surface, or the tangential load F_T [mN] that starts sliding.
double normal_load(const Sums& sums, double mu0, double tau0 = 0.0);
double tangential_load(const Sums& sums, double mu0, double tau0 = 0.0);

/// `self_locked` means that friction alone holds the surfaces together: the normal load F_N is not positive.
enum class Status { ok, no_contact, self_locked };

/// Return `ok` if a friction coefficient exists for mu0 [-] and tau0 [GPa]. Otherwise, return why none exists.
Status status(const Sums& sums, double mu0, double tau0 = 0.0);

/// Return the coefficient of friction F_T / F_N, or NaN unless the status is `ok`.
double friction_coefficient(const Sums& sums, double mu0, double tau0 = 0.0);

inline Vector3 tangent(const Vector3& normal, const Vector2& direction) {
  const double along = normal.head<2>().dot(direction);
  const double across = normal.y() * direction.x() - normal.x() * direction.y();
  if (across == 0.0) {
    // If the contact normal lies in the plane of s and z, as on profiles, the tangent already has unit length.
    return {-normal.z() * direction.x(), -normal.z() * direction.y(), along};
  }
  // At a steep wall, (s·n) n - s would lose digits as the difference of two nearly equal vectors.
  const double length = std::sqrt(normal.z() * normal.z() + across * across);
  const double lateral = along * (across / length);
  return {-length * direction.x() - lateral * direction.y(), -length * direction.y() + lateral * direction.x(),
          along * (normal.z() / length)};
}

/// Largest ratio of overlap to radius up to which Hertz theory counts as valid. Hertz theory assumes a << R.
inline constexpr double hertz_limit = 0.1;

inline SlidingFactors sliding_factors(const Vector3& normal, const Vector2& direction) {
  const double along = normal.head<2>().dot(direction);
  const double across = normal.y() * direction.x() - normal.x() * direction.y();
  if (across == 0.0) {
    return {-along, along, normal.z()};  // every profile takes this branch
  }
  const double length = std::sqrt(normal.z() * normal.z() + across * across);
  return {-along, along * (normal.z() / length), length};
}

inline double Sums::add(const Vector3& normal, double overlap, double radius, const ForceArea& force_area,
                        double spacing) {
  const double load = force_area.force * normal.z();
  const double relative_overlap = overlap / radius;
  contact_count += 1;
  contact_area += force_area.area;
  normal_elastic += load;
  overlap_load += load * relative_overlap;
  load_beyond_hertz += relative_overlap > hertz_limit ? load : 0.0;
  load_below_grid += radius < spacing ? load : 0.0;
  return load;
}

inline void Sums::add(const ContactPoint& contact_point, const Radii& radii, const ForceArea& force_area,
                      const Vector2& direction, Sliding sliding, double spacing) {
  add(contact_point.normal, contact_point.overlap, radii.mean(), force_area, spacing);
  if (sliding == Sliding::all || opposes(contact_point.normal, direction)) {
    const auto [force, area] = force_area;
    const SlidingFactors factors = sliding_factors(contact_point.normal, direction);
    tangential_elastic += force * factors.push;
    normal_frictional += force * factors.lift;
    tangential_frictional += force * factors.drag;
    normal_adhesive += area * factors.lift;
    tangential_adhesive += area * factors.drag;
  }
}

}  // namespace stiction
