// What many contacts carry together, so that normal and tangential load follow for every mu0 and tau0 by linear
// algebra: Hanaor, Gan & Einav, Tribol. Int. 93 (2016) 229, Eqs. 6 and 7 and section 2.5.
//
// The upper body is about to move along a horizontal unit vector s. A contact of normal n opposes the motion where
// s·n < 0. Contacts that slide carry friction, along the tangent t = -s + (s·n) n, normalised, and push.
#pragma once

#include "stiction/array.hpp"
#include "stiction/encounter.hpp"
#include "stiction/law.hpp"

#include <array>
#include <cmath>
#include <string_view>
#include <variant>

namespace stiction {

/// Which contacts slide: `opposing` only those that oppose the motion, as the paper has it, `all` every one, of which
/// those that lean with the motion push forward.
enum class Sliding { opposing, all };

/// By the words of results: "opposing", "all". Throws std::invalid_argument for another.
Sliding sliding(std::string_view word);

/// Sums over the contacts at one approach. F = elastic + mu0 frictional + tau0 adhesive, for both loads.
struct Sums {
  Index contact_count = 0;
  double contact_area = 0.0;           ///< Σ A                 [µm²]
  double normal_elastic = 0.0;         ///< Σ F n_z             [mN]
  double tangential_elastic = 0.0;     ///< -Σ_sliding F s·n   [mN]
  double normal_frictional = 0.0;      ///< Σ_sliding F t_z    [mN] per unit mu0
  double tangential_frictional = 0.0;  ///< -Σ_sliding F s·t   [mN] per unit mu0
  double normal_adhesive = 0.0;        ///< Σ_sliding A t_z    [mN] per GPa of tau0
  double tangential_adhesive = 0.0;    ///< -Σ_sliding A s·t   [mN] per GPa of tau0

  // How far the model is trusted. Shares are of Σ F n_z, and R is the mean radius.
  double overlap_load = 0.0;       ///< Σ F n_z overlap/R                       [mN]
  double load_beyond_hertz = 0.0;  ///< Σ F n_z of contacts with overlap > R/10 [mN]
  double load_below_grid = 0.0;    ///< Σ F n_z of contacts with R < Δx         [mN]
  Index crossed_count = 0;         ///< would-be contacts refused because the sphere centres have crossed

  /// One more contact: how the bodies touch, what it carries, where the upper body is about to move, and the distance
  /// Δx [µm] of grid points.
  void add(const Touch& touch, const Radii& radii, const ForceArea& carried, const Vector2& direction, Sliding sliding,
           double spacing);

  /// Of it, what does not depend on the direction. Returns the load F n_z [mN].
  double add(const Vector3& normal, double overlap, double radius, const ForceArea& carried, double spacing);
};

/// A member of `Sums`: its name, the unit and the words in which results speak of it.
struct Quantity {
  std::string_view name;
  std::string_view unit;
  std::string_view words;
  std::variant<Index Sums::*, double Sums::*> member;
};

/// All of them.
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
    Quantity{"crossed_count", "1", "number of contacts refused because their sphere centres had crossed",
             &Sums::crossed_count},
};

/// The unit vector along which friction acts on the upper body at a contact of this normal, n_z > 0.
Vector3 tangent(const Vector3& normal, const Vector2& direction);

/// A contact whose normal force on the upper body points against the motion.
inline bool opposes(const Vector3& normal, const Vector2& direction) { return normal.head<2>().dot(direction) < 0.0; }

/// How a sliding contact of this normal pulls on the upper body: -s·n times its force, and t_z and -s·t times its
/// friction.
struct Pull {
  double push;  ///< -s·n
  double lift;  ///< t_z
  double drag;  ///< -s·t, the length of n less its part along s
};
Pull pull(const Vector3& normal, const Vector2& direction);

/// F_N [mN], upwards on the upper body, and F_T [mN], which starts the sliding; mu0 [-], tau0 [GPa].
double normal_load(const Sums& sums, double mu0, double tau0 = 0.0);
double tangential_load(const Sums& sums, double mu0, double tau0 = 0.0);

/// Whether there is a coefficient of friction: not without a contact, nor where friction holds the bodies, F_N <= 0.
enum class Status { ok, no_contact, self_locked };
Status status(const Sums& sums, double mu0, double tau0 = 0.0);

/// F_T / F_N; NaN unless the status is `ok`.
double friction_coefficient(const Sums& sums, double mu0, double tau0 = 0.0);

// ---- The kernel, inline because it is what a contact costs ---------------------------------------------------------

inline Vector3 tangent(const Vector3& normal, const Vector2& direction) {
  const double along = normal.head<2>().dot(direction);
  const double across = normal.y() * direction.x() - normal.x() * direction.y();
  if (across == 0.0) {
    // In the plane of s and z no normalisation is needed; every contact of a profile is there.
    return {-normal.z() * direction.x(), -normal.z() * direction.y(), along};
  }
  // By its parts along s, across it and upwards, because (s·n) n - s is the difference of equal vectors at a wall.
  const double length = std::sqrt(normal.z() * normal.z() + across * across);
  const double left = along * (across / length);
  return {-length * direction.x() - left * direction.y(), -length * direction.y() + left * direction.x(),
          along * (normal.z() / length)};
}

/// Overlap over radius up to which Hertz is trusted: he assumes a << R.
inline constexpr double hertz_limit = 0.1;

inline Pull pull(const Vector3& normal, const Vector2& direction) {
  const double along = normal.head<2>().dot(direction);
  const double across = normal.y() * direction.x() - normal.x() * direction.y();
  if (across == 0.0) {
    return {-along, along, normal.z()};  // as on every profile
  }
  const double length = std::sqrt(normal.z() * normal.z() + across * across);
  return {-along, along * (normal.z() / length), length};
}

inline double Sums::add(const Vector3& normal, double overlap, double radius, const ForceArea& carried,
                        double spacing) {
  const double load = carried.force * normal.z();
  const double relative_overlap = overlap / radius;
  contact_count += 1;
  contact_area += carried.area;
  normal_elastic += load;
  overlap_load += load * relative_overlap;
  load_beyond_hertz += relative_overlap > hertz_limit ? load : 0.0;
  load_below_grid += radius < spacing ? load : 0.0;
  return load;
}

inline void Sums::add(const Touch& touch, const Radii& radii, const ForceArea& carried, const Vector2& direction,
                      Sliding sliding, double spacing) {
  add(touch.normal, touch.overlap, radii.mean(), carried, spacing);
  if (sliding == Sliding::all || opposes(touch.normal, direction)) {
    const auto [force, area] = carried;
    const Pull by = pull(touch.normal, direction);
    tangential_elastic += force * by.push;
    normal_frictional += force * by.lift;
    tangential_frictional += force * by.drag;
    normal_adhesive += area * by.lift;
    tangential_adhesive += area * by.drag;
  }
}

}  // namespace stiction
